//! `ramus abstract --exact`: the very tree as a compact grammar.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::DVec3;
use serde::Serialize;

use super::super::inputs::grammar_text;
use super::super::inspect::Loaded;
use super::super::print_result;
use super::super::progress::Progress;
use super::Args;
use crate::abstraction::exact::{Deviation, Exact, Point, Size, curve, exact, size};
use crate::app::analysis::{Wanted, checked, endpoints, found, prepared};
use crate::app::store::read_project;
use crate::app::{export, portrait, tradeoff};
use crate::lsystem::{Grammar, Limits, TurtleParams, interpret};
use crate::mesh::unit::Rounded;
use crate::sketch;
use crate::tree::file::write_atomically;
use crate::tree::{Drawing, Organs, Tree};

/// How far off a grammar may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tolerance {
    /// In the model's unit.
    Length(f64),
    /// Of the tree's size, the diagonal of its box; 1 is all of it.
    Part(f64),
}

impl Tolerance {
    fn of(self, tree: &Tree) -> f64 {
        match self {
            Self::Length(length) => length,
            Self::Part(part) => part * size(tree),
        }
    }
}

pub(super) fn tolerance(text: &str) -> Result<Tolerance, String> {
    let part = text.strip_suffix('%');
    match part.unwrap_or(text).trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(match part {
            Some(_) => Tolerance::Part(number / 100.0),
            None => Tolerance::Length(number),
        }),
        _ => Err(
            "a length above 0 in the model's unit is asked for, or a part of its size such as 0.5%"
                .to_owned(),
        ),
    }
}

pub(super) fn curve_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("svg") => Ok(path),
        _ => Err(format!(
            "{}: curves are written as SVG; use the ending .svg",
            path.display()
        )),
    })
}

/// All that is told, `ramus-exact/1`.
#[derive(Serialize)]
struct Told<'a> {
    format: &'static str,
    tolerance: f64,
    tree_size: f64,
    origin: [f64; 3],
    error: Deviation,
    segments: Segments,
    size: Size,
    plain: Size,
    curve: Option<&'a [Point]>,
    seconds: f64,
    grammar: &'a str,
}

#[derive(Serialize)]
struct Segments {
    tree: usize,
    grammar: usize,
}

/// A tree and where its own origin is in the file's coordinates.
struct Given {
    tree: Tree,
    origin: DVec3,
}

/// Writes a tree as a grammar.
pub(super) fn run(
    args: &Args,
    tolerance: Tolerance,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let name = args.model.display().to_string();
    let cannot = || format!("cannot abstract {name}");
    let given = given(&args.model, read)?;
    let started = Instant::now();
    let length = tolerance.of(&given.tree);
    let work = || exact(&given.tree, length, &never, &|_, _| {});
    let found = Progress::during("looking for a grammar", work).with_context(cannot)?;
    let points = match args.curve {
        Some(_) => {
            let mut progress = Progress::new("looking for grammars");
            let mut show = |done, of| progress.show(done, of);
            Some(curve(&given.tree, &found, &never, &mut show).with_context(cannot)?)
        }
        None => None,
    };
    let seconds = started.elapsed().as_secs_f64();
    write(args, &name, &given, &found, points.as_deref())?;
    let root = given.origin + found.origin;
    let text = match args.json {
        true => {
            let [tree, grammar] = found.segments;
            let told = Told {
                format: "ramus-exact/1",
                tolerance: found.tolerance,
                tree_size: size(&given.tree),
                origin: root.to_array(),
                error: found.error,
                segments: Segments { tree, grammar },
                size: found.size,
                plain: found.plain,
                curve: points.as_deref(),
                seconds,
                grammar: &found.grammar,
            };
            serde_json::to_string(&told)? + "\n"
        }
        false => screen(&name, &given, &found, points.as_deref(), seconds),
    };
    print_result("the abstraction", |out| out.write_all(text.as_bytes()))
}

/// The tree of a file of any kind.
fn given(path: &Path, read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>) -> Result<Given> {
    let never = AtomicBool::new(false);
    let name = path.display();
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    let at_zero = |tree| Given {
        tree,
        origin: DVec3::ZERO,
    };
    match ending.as_deref().and_then(|ending| ending.to_str()) {
        Some("json") => bail!(
            "{name} is a table, and a table has no shape that could be written exactly: give a model, a skeleton, a grammar or a project"
        ),
        Some("lsys") => Ok(at_zero(grown(path)?)),
        Some("ramus") => {
            let document = read_project(path)?;
            let cannot = || format!("cannot grow the sketch of {name}");
            let grown =
                sketch::grow(&document.sketch, document.step, &never).with_context(cannot)?;
            Ok(at_zero(grown.tree))
        }
        _ => measured(path, read),
    }
}

/// The tree of a grammar after the steps that it states.
fn grown(path: &Path) -> Result<Tree> {
    let never = AtomicBool::new(false);
    let name = path.display().to_string();
    let grammar =
        Grammar::parse(&grammar_text(path)?, &name).map_err(|errors| anyhow!("{errors}"))?;
    let Some(steps) = grammar.steps() else {
        bail!("{name} states no number of steps: add a line such as `steps 5`");
    };
    let grow = || {
        let string = grammar.derive(steps, &Limits::default(), &never)?;
        interpret(&grammar, &string, &TurtleParams::default(), &never)
    };
    Progress::during("deriving", grow).with_context(|| name.clone())
}

/// The centerlines of a surface between ends that are found on it; a skeleton as it is.
fn measured(path: &Path, read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>) -> Result<Given> {
    let never = AtomicBool::new(false);
    let loaded = Progress::during("reading", || read(path, &never))?;
    let origin = loaded.mesh.origin;
    if let Some(tree) = loaded.skeleton {
        return Ok(Given { tree, origin });
    }
    let wanted = Wanted::default();
    let of_surface = || -> Result<Given> {
        let report = checked(&loaded.mesh, &mut |_, _| {})?;
        let on = prepared(&loaded.mesh, report, &mut |_, _| {})?;
        let ends = endpoints(&wanted, &on)?;
        let found = found(&wanted, &on, &ends, &mut |_, _| {})?;
        for one in &found.unreached {
            whisper!("{} is {one}", one.name);
        }
        Ok(Given {
            tree: found.tree,
            origin,
        })
    };
    Progress::during("measuring", of_surface)
        .with_context(|| format!("cannot analyze {}", path.display()))
}

/// Writes the files that are asked for.
fn write(
    args: &Args,
    name: &str,
    given: &Given,
    found: &Exact,
    points: Option<&[Point]>,
) -> Result<()> {
    if let Some(path) = &args.grammar {
        write_atomically(path, found.grammar.as_bytes())?;
    }
    if let Some(path) = &args.export {
        let mut tree = found.tree.clone();
        let root = given.origin + found.origin;
        for position in tree.position.iter_mut() {
            *position = (position.as_dvec3() + root).as_vec3();
        }
        export::drawing(&tree, &Organs::default(), path)?;
    }
    if let (Some(Some(path)), Some(points)) = (&args.curve, points) {
        let file = args.model.file_name().unwrap_or_default().to_string_lossy();
        let drawn = tradeoff::svg(&file, size(&given.tree), points);
        write_atomically(path, drawn.as_bytes())?;
    }
    if let Some(path) = &args.png {
        let drawing = Drawing {
            tree: found.tree.clone(),
            organs: Organs::default(),
        };
        let draw = || portrait::of_drawing(drawing, args.size, false, portrait::PAPER);
        let picture = Progress::during("drawing", draw)
            .with_context(|| format!("cannot draw the abstraction of {name}"))?;
        export::png(&picture, path)?;
    }
    Ok(())
}

/// The grammar's lines on the screen at most, and letters of each.
const SHOWN_LINES: usize = 12;
const SHOWN_LETTERS: usize = 150;

/// What is found as a person reads it.
fn screen(
    name: &str,
    given: &Given,
    found: &Exact,
    points: Option<&[Point]>,
    seconds: f64,
) -> String {
    let whole = size(&given.tree);
    let part = |length: f64| format!("{} % of its size", Rounded(100.0 * length / whole));
    let mut text = String::new();
    let mut line = |said: String| {
        let _ = writeln!(text, "{said}"); // Writing into a string cannot fail.
    };
    let [written, symbols] = [found.plain, found.size].map(|size| size.symbols());
    line(format!(
        "{name}: a grammar of {symbols} modules and parameters, found in {seconds:.1} s; written out, segment by segment, the tree takes {written} ({} times as many)",
        Rounded(written as f64 / symbols.max(1) as f64)
    ));
    let Deviation { max, mean, radius } = found.error;
    line(format!(
        "its tree is off by {} at most ({}), {} in the mean; radii by {} at most; asked for was {} ({})\n",
        Rounded(max),
        part(max),
        Rounded(mean),
        Rounded(radius),
        Rounded(found.tolerance),
        part(found.tolerance)
    ));
    line(format!("{:<12}{:>13}{:>13}", "", "grammar", "written out"));
    let [tree, drawn] = found.segments;
    for (what, grammar, plain) in [
        ("segments", drawn, tree),
        (
            "productions",
            found.size.productions,
            found.plain.productions,
        ),
        ("modules", found.size.modules, found.plain.modules),
        ("parameters", found.size.parameters, found.plain.parameters),
        ("bytes", found.size.bytes, found.plain.bytes),
    ] {
        line(format!("{what:<12}{grammar:>13}{plain:>13}"));
    }
    if let Some(points) = points {
        line(format!(
            "\n{:>13}{:>13}{:>13}{:>13}{:>13}",
            "tolerance", "off by", "productions", "symbols", "bytes"
        ));
        for one in points {
            line(format!(
                "{:>13}{:>13}{:>13}{:>13}{:>13}",
                Rounded(one.tolerance).to_string(),
                Rounded(one.error.max).to_string(),
                one.size.productions,
                one.size.symbols(),
                one.size.bytes
            ));
        }
    }
    line(String::new());
    let lines = found.grammar.lines();
    for shown in lines.clone().take(SHOWN_LINES) {
        let cut: String = shown.chars().take(SHOWN_LETTERS).collect();
        let rest = if cut.len() < shown.len() { " …" } else { "" };
        line(format!("{cut}{rest}"));
    }
    let more = lines.count().saturating_sub(SHOWN_LINES);
    if more > 0 {
        line(format!(
            "… and {more} lines more: --grammar FILE writes all of it"
        ));
    }
    text
}
