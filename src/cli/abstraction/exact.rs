//! `ramus abstract --exact`: the very tree as a compact grammar.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use super::super::print_result;
use super::super::progress::Progress;
use super::super::trees::held;
use super::Args;
use crate::abstraction::exact::{Deviation, Exact, Point, Size, curve, exact, size};
use crate::app::trees::Held;
use crate::app::{export, portrait, tradeoff};
use crate::mesh::unit::Rounded;
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

/// Writes a tree as a grammar.
pub(super) fn run(args: &Args, tolerance: Tolerance) -> Result<()> {
    let never = AtomicBool::new(false);
    let name = args.model.display().to_string();
    let cannot = || format!("cannot abstract {name}");
    let given = given(&args.model)?;
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
fn given(path: &Path) -> Result<Held> {
    let name = path.display();
    let ending = path.extension().unwrap_or_default();
    if ending.eq_ignore_ascii_case("json") {
        bail!(
            "{name} is a table, and a table has no shape that could be written exactly: give a model, a skeleton, a grammar or a project"
        );
    }
    if path.is_dir() || ending.eq_ignore_ascii_case("csv") {
        bail!("{name} is a group of models, and --exact writes one tree: give one of its models");
    }
    let held = held(path)?;
    held.remarks.iter().for_each(|remark| whisper!("{remark}"));
    Ok(held)
}

/// Writes the files that are asked for.
fn write(
    args: &Args,
    name: &str,
    given: &Held,
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
    given: &Held,
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
