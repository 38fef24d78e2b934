//! `ramus derive`: a grammar file grown, printed, drawn and exported.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::{ArgGroup, Args as ClapArgs, ValueEnum};

use super::explain;
use super::inputs::grammar_text;
use super::moment::{Moment, step_at, time};
use super::outputs::{
    check_places, light, not_over_each_other, picture_file, tell_bare, tree_file,
};
use super::print_result;
use super::progress::{Progress, start_watch};
use super::unwritten::{self, Wanted};
use crate::app::portrait::{self, Scenery};
use crate::app::{export, memory};
use crate::lsystem::report::Report;
use crate::lsystem::{
    DeriveError, DeriveProblem, ExplainParams, Grammar, Limit, Limits, TurtleParams,
};
use crate::render::{self, RenderError};
use crate::sketch::Sketch;
use crate::tree::organs::{Organist, refined_len};
use crate::tree::radii::{self, RadiusParams};
use crate::tree::{Drawing, Organs, tubes};
use crate::world::scene::weather::Light;

#[derive(Debug, ClapArgs)]
#[command(group(ArgGroup::new("made").args(["json", "export", "png"]).multiple(true)))]
pub(super) struct Args {
    /// The grammar file (.lsys)
    file: PathBuf,
    /// Steps to derive; without it the number that the file states
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// Steps to grow, of which the last may be a part: 3.25 shows a quarter of the growth from step 3 to step 4
    #[arg(long, value_name = "STEPS", value_parser = time, conflicts_with = "steps")]
    time: Option<f64>,
    /// What to print
    #[arg(long, value_enum, value_name = "WHAT")]
    print: Option<Print>,
    /// Print counts, sums and bounds as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Count, measure, draw and export the string as it comes, without holding it: for strings of any length, in the time that they take
    #[arg(long, requires = "made", conflicts_with_all = ["print", "time"])]
    stream: bool,
    /// Say which production rewrote each module in a step: the last one, or STEP
    #[arg(long, value_name = "STEP", num_args = 0..=1, value_parser = explain::step(),
        conflicts_with_all = ["print", "export", "png", "stream", "time"])]
    explain: Option<Option<u32>>,
    /// The first module that --explain shows, as its position from 0
    #[arg(
        long,
        value_name = "POSITION",
        requires = "explain",
        default_value_t = 0
    )]
    at: usize,
    /// Lines of modules that --explain shows at most
    #[arg(long, value_name = "N", requires = "explain", default_value_t = ExplainParams::default().entries)]
    entries: usize,
    /// Write the tree; the ending tells the format: .glb, .usda, .ply, .obj or .swc (may be given more than once)
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    export: Vec<PathBuf>,
    /// Draw the tree into a PNG picture
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    png: Option<PathBuf>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
    /// What the picture shows behind the tree
    #[arg(long, value_enum, default_value_t = Backdrop::Stage, value_name = "WHICH")]
    backdrop: Backdrop,
    /// What lights the picture
    #[arg(long, value_name = "LIGHT", default_value = Light::Day.name(), value_parser = light())]
    light: Light,
    /// How the grammar's widths are meant in exports and pictures
    #[arg(long, value_enum, default_value_t = Widths::Auto, value_name = "HOW")]
    widths: Widths,
    /// Radius of the tips in metres, for `--widths da-vinci`
    #[arg(long, value_name = "METRES", default_value_t = Sketch::default().tip_radius, value_parser = tip)]
    tip: f32,
    /// Seed of the random draws, in place of the file's
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// Most memory that strings, tree and surface may take, in MiB; never more than the machine has free
    #[arg(long, value_name = "MIB", default_value_t = 4096, value_parser = clap::value_parser!(u64).range(1..))]
    memory: u64,
}

/// A radius of tips that the rule admits.
fn tip(text: &str) -> Result<f32, String> {
    let tip_radius = text.parse().map_err(|_| "no number".to_owned())?;
    let params = RadiusParams {
        tip_radius,
        ..RadiusParams::default()
    };
    params.validate().map_err(|error| error.to_string())?;
    Ok(tip_radius)
}

/// Bytes of a node of the tree itself.
const NODE_BYTES: u64 = 28;

/// Bytes of a mebibyte.
const MIB: u64 = 1 << 20;

/// The memory that a run may take, and where that comes from.
#[derive(Clone, Copy, Debug)]
struct Budget {
    bytes: u64,
    /// `--memory` was more than the machine has.
    by_machine: bool,
}

impl Budget {
    /// What this process may take now, when all threads that the work needs run.
    fn of(args: &Args) -> Self {
        start_watch();
        Self::new(args, memory::room())
    }

    /// An eighth of what is free is left to threads, libraries and everybody else.
    fn new(args: &Args, room: Option<u64>) -> Self {
        let asked = args.memory.saturating_mul(MIB);
        match room.map(|room| room / 8 * 7) {
            Some(room) if room < asked => Self {
                bytes: room,
                by_machine: true,
            },
            _ => Self {
                bytes: asked,
                by_machine: false,
            },
        }
    }

    /// What makes it larger, as the end of a sentence.
    fn advice(self) -> String {
        let mib = self.bytes / MIB;
        if self.by_machine {
            format!(
                "close other programs or raise the process's limit: there are {mib} MiB free for it"
            )
        } else {
            format!("give more memory than {mib} MiB with --memory")
        }
    }

    /// The problem of a derivation or drawing, with what this command line can do about it.
    fn explain(self, error: DeriveError, file: &str) -> anyhow::Error {
        let last = error.last_whole_step().map_or_else(String::new, |step| {
            format!("; steps up to {step} can be derived: give --steps {step}")
        });
        match *error.problem {
            DeriveProblem::Limit {
                limit: Limit::Bytes(_),
                ..
            }
            | DeriveProblem::DecompositionLimit {
                limit: Limit::Bytes(_),
                ..
            }
            | DeriveProblem::Memory { .. }
            | DeriveProblem::DrawingMemory { .. }
            | DeriveProblem::TooManyNodes { .. } => {
                anyhow!("{file}: {error}, or {}{last}", self.advice())
            }
            _ => anyhow!("{file}: {error}{last}"),
        }
    }

    /// Refuses what a file or a picture of the drawing takes beside the drawing itself: so many bytes for each node of the finer tree and
    /// for what the tree carries.
    fn check(self, what: &str, drawing: &Drawing, node_bytes: usize, more: u64) -> Result<()> {
        let Drawing { tree, organs } = drawing;
        // What the machine has free is told without the tree, `--memory` is meant with it.
        let own = if self.by_machine {
            0
        } else {
            tree.len() as u64 * NODE_BYTES + organs.bytes()
        };
        let fine = refined_len(tree, organs).saturating_mul(node_bytes as u64);
        let needed = fine.saturating_add(more).saturating_add(own);
        if needed <= self.bytes {
            return Ok(());
        }
        bail!(
            "{what} of {} segments{} needs {} MiB; take fewer steps, or {}",
            tree.segment_count(),
            carried(organs),
            needed.div_ceil(MIB),
            self.advice()
        )
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Print {
    /// The modules with their parameters
    String,
    /// How many of each name, and their parameters' sums
    Counts,
    /// How many modules after each step
    Growth,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Backdrop {
    /// Sky and ground, as in the workshop
    Stage,
    /// Paper, as a figure in print has it
    Paper,
}

impl Backdrop {
    fn drawn(self) -> render::Backdrop {
        match self {
            Self::Stage => render::Backdrop::Stage,
            Self::Paper => portrait::PAPER,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Widths {
    /// In metres, unless the trunk would be thicker than a fifth of the tree: then scaled to fit, as ABOP means them.
    /// Pictures also show no line thinner than about two pixels, and where all widths are equal none thicker than a sixth of the usual segment's length
    Auto,
    /// In metres, whatever comes of it
    Metres,
    /// By da Vinci's rule in place of the grammar's, as the workshop does: tips as --tip says, each cross-section the sum of those it carries
    DaVinci,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let outputs = || args.export.iter().chain(&args.png);
    not_over_each_other(Some(&args.file), outputs().map(PathBuf::as_path), None)?;
    let radii = RadiusParams {
        tip_radius: args.tip,
        exponent: Sketch::default().radius_exponent,
    };
    let grammar = read(args)?;
    check_places(outputs())?;
    let whole = || args.steps.or(grammar.steps()).map(|steps| (steps, 1.0));
    let (steps, age) = args.time.map(step_at).or_else(whole).ok_or_else(|| {
        anyhow!(
            "{} states no number of steps: give one with --steps N",
            args.file.display()
        )
    })?;
    let budget = Budget::of(args);
    let limits = Limits {
        bytes: budget.bytes,
        ..Limits::default()
    };
    let never = AtomicBool::new(false);
    if let Some(step) = args.explain {
        let params = ExplainParams {
            from: args.at,
            entries: args.entries,
            ..ExplainParams::default()
        };
        let explained = explain::explained(&grammar, step.unwrap_or(steps), &params, &limits)?
            .map_err(|error| budget.explain(error, &args.file.display().to_string()))?;
        return explain::print(&explained, args.json);
    }

    let named = || args.file.display().to_string();
    let explain = |error| budget.explain(error, &named());
    let only_printed = outputs().next().is_none() && !args.json;
    let wanted = match args.print {
        Some(Print::String) if only_printed => Some(Wanted::Text),
        Some(Print::Counts) if only_printed && age >= 1.0 => Some(Wanted::Counts),
        Some(Print::Growth) => Some(Wanted::Growth),
        _ => None,
    };
    if args.stream {
        let (asked, name) = ((args.json, outputs().next().is_some()), named());
        let (printed, drawing) =
            unwritten::stream(&grammar, steps, &limits, asked, &name, explain)?;
        return printed.and(drawing.map_or(Ok(()), |drawing| {
            write(args, &grammar, drawing, steps, &radii)
        }));
    }
    if let Some(wanted) = wanted
        && unwritten::print(wanted, &grammar, steps, &limits, explain)?
        && only_printed
    {
        return Ok(());
    }

    let began = Instant::now();
    let mut progress = Progress::new("deriving");
    let moment = Moment::new(&grammar, (steps, age), &limits, &never, &mut |done| {
        progress.show(done as usize, steps as usize);
    })
    .map_err(explain)?;
    let string = moment.string();
    drop(progress);
    let derive_ms = began.elapsed().as_secs_f64() * 1e3;

    // A full standard output must not cost the files: it is told at the end.
    let mut printed = Ok(());
    if args.print == Some(Print::String) {
        printed = print_result("the string", |out| {
            string.write_text(&grammar, out)?;
            writeln!(out)
        });
        if only_printed {
            return printed;
        }
    }
    let began = Instant::now();
    // The string stays until it is counted, so the tree has the rest.
    let turtle = TurtleParams {
        limits: Limits {
            bytes: budget.bytes.saturating_sub(moment.bytes()),
            ..limits
        },
        ..TurtleParams::default()
    };
    let drawing = Progress::during("drawing with the turtle", || {
        moment.drawing(&grammar, &turtle, &never)
    })
    .map_err(explain)?;
    let turtle_ms = began.elapsed().as_secs_f64() * 1e3;
    let mut report = Report::new(&grammar, string, &drawing.tree, steps, derive_ms, turtle_ms);
    report.time = args.time;
    drop(moment);
    if args.print == Some(Print::Counts) {
        let counts = report.counts_text();
        printed = printed.and(print_result("the counts", |out| {
            out.write_all(counts.as_bytes())
        }));
    }
    if args.json {
        let json = report.to_json().with_context(named);
        printed = printed
            .and(json.and_then(|json| print_result("the JSON", |out| writeln!(out, "{json}"))));
    } else if args.print.is_none() {
        tell!(
            "{}: {} modules and {} segments{} after {} steps",
            args.file.display(),
            report.modules,
            report.segments,
            carried(&drawing.organs),
            args.time.unwrap_or(f64::from(steps))
        );
    }
    printed.and(write(args, &grammar, drawing, steps, &radii))
}

/// Writes the files that are asked for, if there is anything to write into them.
fn write(
    args: &Args,
    grammar: &Grammar,
    drawing: Drawing,
    steps: u32,
    radii: &RadiusParams,
) -> Result<()> {
    let outputs = || args.export.iter().chain(&args.png);
    let bare = drawing.tree.segment_count() == 0;
    let skeleton = outputs().find(|path| bare && is_skeleton(path));
    if (drawing.is_empty() && outputs().next().is_some()) || skeleton.is_some() {
        let why = match skeleton {
            Some(path) if !drawing.is_empty() => {
                format!(
                    "and {} holds segments only: export it as GLB or OBJ",
                    path.display()
                )
            }
            _ => "so there is no file to write; segments are drawn by `F` and by the letters of shapes"
                .to_owned(),
        };
        bail!(
            "{}: the string after {steps} steps draws no segment, {why}",
            args.file.display()
        );
    }
    // What the tree itself takes is taken.
    write_files(args, grammar, drawing, radii, Budget::of(args))
}

/// What a drawing has besides segments, as a part of a sentence.
fn carried(organs: &Organs) -> String {
    let kinds = [
        (organs.polygons.len(), "polygons"),
        (organs.spheres.len(), "spheres"),
        (organs.placed.len(), "surfaces"),
    ];
    let there = kinds.iter().filter(|(number, _)| *number > 0);
    there
        .map(|(number, kind)| format!(", {number} {kind}"))
        .collect()
}

/// Whether a file holds the skeleton alone.
fn is_skeleton(path: &Path) -> bool {
    export::Format::of(path).is_ok_and(|format| format == export::Format::Swc)
}

fn read(args: &Args) -> Result<Grammar> {
    let name = args.file.display().to_string();
    let text = grammar_text(&args.file)?;
    let grammar = Grammar::parse(&text, &name).map_err(|errors| anyhow!("{errors}"))?;
    for remark in grammar.remarks() {
        whisper!("{remark}");
    }
    Ok(match args.seed {
        Some(seed) => grammar.with_seed(seed),
        None => grammar,
    })
}

/// Bytes for each node while a picture is made: segments, and their copies on the way to the device and on it.
const PICTURE_BYTES: usize = tubes::NODE_BYTES + 2 * size_of::<tubes::TubeSegment>();

/// Bytes for each vertex of an organ on its way to the device and on it.
const ORGAN_VERTEX_BYTES: usize = 64;

/// Bytes of all organs' triangles while a picture is made.
fn picture_bytes(organs: &Organs) -> u64 {
    let organist = Organist::new(organs);
    let bytes = |index| {
        let (vertices, indices) = organist.size(index);
        (vertices * ORGAN_VERTEX_BYTES + indices * 2 * size_of::<u32>()) as u64
    };
    (0..organs.len()).map(bytes).sum()
}

/// Bytes for each node of da Vinci's radii: two counts of tips, a base and an older radius.
const RADII_BYTES: usize = 16;

fn write_files(
    args: &Args,
    grammar: &Grammar,
    mut drawing: Drawing,
    radius_params: &RadiusParams,
    budget: Budget,
) -> Result<()> {
    if args.export.is_empty() && args.png.is_none() {
        return Ok(());
    }
    let factor = match args.widths {
        Widths::Auto => grammar.finish(&mut drawing),
        Widths::Metres => {
            grammar.dress_up(&drawing.tree, &mut drawing.organs);
            None
        }
        Widths::DaVinci => {
            budget.check("the radii", &drawing, RADII_BYTES, 0)?;
            radii::da_vinci(&mut drawing.tree, radius_params, u32::MAX);
            grammar.dress_up(&drawing.tree, &mut drawing.organs);
            None
        }
    };
    tell_bare(&drawing.organs);
    for path in &args.export {
        if !is_skeleton(path) {
            budget.check(&path.display().to_string(), &drawing, tubes::NODE_BYTES, 0)?;
        }
        let Drawing { tree, organs } = &drawing;
        Progress::during("writing", || export::drawing(tree, organs, path))?;
    }
    if let Some(path) = &args.png {
        let organs = picture_bytes(&drawing.organs);
        budget.check(&path.display().to_string(), &drawing, PICTURE_BYTES, organs)?;
        let set_widths = args.widths == Widths::Auto;
        let scenery = Scenery {
            backdrop: args.backdrop.drawn(),
            light: args.light,
        };
        let picture = Progress::during("drawing", || portrait::of_drawing(drawing, args.size, set_widths, scenery))
            .map_err(|error| match error.downcast_ref() {
                Some(RenderError::OutOfMemory(_)) => anyhow!(
                    "the graphics memory does not hold a picture of {0} × {0} pixels: choose a smaller --size, or close other programs that draw",
                    args.size
                ),
                _ => error,
            })?;
        Progress::during("writing", || export::png(&picture, path))?;
    }
    if let Some(factor) = factor {
        whisper!(
            "ramus: the widths are far too large for metres and were multiplied by {factor:.2e}; --widths metres leaves them"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn the_machine_and_the_option_bound_the_memory_whichever_is_less() {
        for (asked, room, bytes, advice) in [
            ("64", None, 64 * MIB, "--memory"),
            ("64", Some(800 * MIB), 64 * MIB, "--memory"),
            ("4096", Some(800 * MIB), 700 * MIB, "700 MiB free"),
        ] {
            let line = Line::parse_from(["derive", "a.lsys", "--memory", asked]);
            let budget = Budget::new(&line.args, room);
            assert_eq!(budget.bytes, bytes, "{asked} {room:?}");
            assert!(budget.advice().contains(advice), "{}", budget.advice());
        }
    }
}
