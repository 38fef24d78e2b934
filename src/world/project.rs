//! The `.ramus` project file: text that a person can read, and the same bytes for the same document.
//!
//! JSON with a fixed order of fields, one point a line, numbers in their shortest exact form.
//! The writer is by hand because serde_json's pretty form spreads a point over five lines. Nothing in the
//! file depends on the clock, the machine or the headset, so a replayed session can be compared
//! byte for byte. The format is described in `docs/src/project-file.md`.
//!
//! Reading meets files from elsewhere: size and counts are bounded, unknown fields are refused (a
//! newer format raises the version instead), and the whole document is checked before it is given
//! out, so nothing later has to doubt it.

use std::{fmt::Write as _, sync::Arc};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::document::{Document, EditError, Placement};
use super::grove::{Grove, Kind, Plant};
use super::model::Model;
use crate::sketch::{
    Habit, Letter, NodeRef, OwnRules, SelfSimilar, Sketch, Stroke, Wrap, own_rules::by_name,
    quantize,
};

/// The first field of every project file.
const FORMAT: &str = "ramus-project";
/// The newest version this program reads, all older ones too. It writes the oldest that says all: a project
/// without curves and rules of one's own can be read by a program that knows none.
const VERSION: u64 = 6;
/// The first version with planted trees, lines that end, and ends that keep away from other wood.
const GROVE: u64 = 6;
/// The first version in which trees have a habit.
const HABIT: u64 = 5;
/// The first version in which strokes have radii.
const RADII: u64 = 4;
/// The first version with scanned models.
const MODELS: u64 = 3;
/// The first version in which strokes have handles and a person has rules.
const HANDLES: u64 = 2;
/// The version without them.
const PLAIN: u64 = 1;
/// The first program version that reads [`VERSION`].
const NEEDS: &str = "0.1.0";
/// Largest file read, bytes: many times what the bounds of a sketch allow.
const MAX_BYTES: usize = 64 << 20;
/// Longest part of a foreign text repeated in a message, characters.
const MAX_QUOTE: usize = 200;

/// Why a file is no project this program can read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectError {
    /// Larger than any project.
    #[error(
        "this file is {0} bytes long, and no project is longer than {MAX_BYTES}: choose a .ramus file"
    )]
    TooLarge(usize),
    /// Some other file.
    #[error(
        "this is no Ramus project (its first field must be \"format\": \"{FORMAT}\"): choose a .ramus file"
    )]
    NotAProject,
    /// Of a later program.
    #[error("this project has format version {version}, which Ramus {needs} or later reads; this is Ramus {ours}, which reads versions up to {VERSION}", ours = env!("CARGO_PKG_VERSION"))]
    Version {
        /// The file's version.
        version: u64,
        /// The program it asks for.
        needs: String,
    },
    /// Cut off or edited so that it cannot be read.
    #[error(
        "this project file is damaged ({0}): mend that place, or take the last copy that was whole"
    )]
    Malformed(String),
    /// Readable, but against the rules.
    #[error("this project file is damaged: {0}")]
    Invalid(#[from] EditError),
}

/// What every version has.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u64,
    #[serde(default)]
    needs: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    version: u64,
    #[serde(rename = "needs")]
    _needs: String,
    step: u32,
    selected: NodeRef,
    platform: Placement,
    divergence_deg: f64,
    scale: f32,
    tip_radius: f32,
    radius_exponent: f32,
    wrap: Wrap,
    self_similar_branches: bool,
    #[serde(default)]
    own_rules: OwnRules,
    /// Since version [`HABIT`].
    #[serde(default)]
    habit: Option<Habit>,
    /// Since version [`MODELS`].
    #[serde(default)]
    linked: bool,
    #[serde(default)]
    models: Vec<Model>,
    /// Since version [`GROVE`]: projects of one tree.
    #[serde(default)]
    kinds: Vec<File>,
    #[serde(default)]
    plants: Vec<Plant>,
    strokes: Vec<FileStroke>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileStroke {
    letter: Letter,
    attachment: Option<NodeRef>,
    self_similar: Option<SelfSimilar>,
    /// Since version [`HANDLES`].
    #[serde(default)]
    handles: Option<Vec<u32>>,
    /// Since version [`RADII`].
    #[serde(default)]
    radii: Option<Vec<f32>>,
    points: Vec<Vec3>,
}

/// The document as a project file: always the same bytes for equal documents.
#[must_use]
pub fn to_bytes(document: &Document) -> Vec<u8> {
    let sketch = &*document.sketch;
    let mut text = String::from("{\n");
    field(&mut text, 1, "format", &FORMAT);
    let curved = sketch.strokes.iter().any(|stroke| stroke.is_curve());
    let has_models = !document.models.is_empty() || document.linked;
    let thick = sketch.strokes.iter().any(|stroke| !stroke.radii.is_empty());
    let has_habit = *sketch.habit != Habit::default();
    let version = if !document.grove.is_empty() || sketch.habit.has_later_laws() {
        GROVE
    } else if has_habit {
        HABIT
    } else if thick {
        RADII
    } else if has_models {
        MODELS
    } else if curved || !sketch.own_rules.is_empty() {
        HANDLES
    } else {
        PLAIN
    };
    field(&mut text, 1, "version", &version);
    field(&mut text, 1, "needs", &NEEDS);
    field(&mut text, 1, "step", &document.step);
    field(&mut text, 1, "selected", &document.selected);
    field(&mut text, 1, "platform", &document.platform);
    field(&mut text, 1, "divergence_deg", &sketch.divergence_deg);
    field(&mut text, 1, "scale", &sketch.scale);
    field(&mut text, 1, "tip_radius", &sketch.tip_radius);
    field(&mut text, 1, "radius_exponent", &sketch.radius_exponent);
    field(&mut text, 1, "wrap", &sketch.wrap);
    field(
        &mut text,
        1,
        "self_similar_branches",
        &sketch.self_similar_branches,
    );
    // Left out where there are none, so that older programs read such projects.
    if !sketch.own_rules.is_empty() {
        field(&mut text, 1, "own_rules", &*sketch.own_rules);
    }
    if has_habit {
        field(&mut text, 1, "habit", &*sketch.habit);
    }
    if has_models {
        field(&mut text, 1, "linked", &document.linked);
        text.push_str("  \"models\": [");
        for (number, model) in document.models.iter().enumerate() {
            text.push_str(if number == 0 { "\n    " } else { ",\n    " });
            push_json(&mut text, model);
        }
        text.push_str("\n  ],\n");
    }
    push_grove(&mut text, &document.grove);
    text.push_str("  \"strokes\": [\n");
    for (number, stroke) in (1..).zip(&sketch.strokes) {
        text.push_str("    {\n");
        field(&mut text, 3, "letter", &stroke.letter);
        field(&mut text, 3, "attachment", &stroke.attachment);
        field(&mut text, 3, "self_similar", &stroke.self_similar);
        if stroke.is_curve() {
            field(&mut text, 3, "handles", &stroke.handles);
        }
        if !stroke.radii.is_empty() {
            field(&mut text, 3, "radii", &stroke.radii);
        }
        text.push_str("      \"points\": [");
        for (number, point) in (0..).zip(&stroke.points) {
            text.push_str(if number == 0 {
                "\n        "
            } else {
                ",\n        "
            });
            push_json(&mut text, point);
        }
        text.push_str(if stroke.points.is_empty() {
            "]\n"
        } else {
            "\n      ]\n"
        });
        text.push_str(if number == sketch.strokes.len() {
            "    }\n"
        } else {
            "    },\n"
        });
    }
    text.push_str("  ]\n}\n");
    text.into_bytes()
}

/// Planted trees, one a line, and those trees that they are of beside the one on the platform: each a project of its own.
fn push_grove(text: &mut String, grove: &Grove) {
    if grove.is_empty() {
        return;
    }
    for (number, kind) in grove.kinds.iter().enumerate() {
        text.push_str(if number == 0 {
            "  \"kinds\": [\n    "
        } else {
            ",\n    "
        });
        let alone = Document {
            sketch: Arc::clone(&kind.sketch),
            step: kind.step,
            ..Document::default()
        };
        let project = to_bytes(&alone);
        let project = String::from_utf8_lossy(&project);
        text.push_str(&project.trim_end().replace('\n', "\n    "));
    }
    if !grove.kinds.is_empty() {
        text.push_str("\n  ],\n");
    }
    text.push_str("  \"plants\": [");
    for (number, plant) in grove.plants.iter().enumerate() {
        text.push_str(if number == 0 { "\n    " } else { ",\n    " });
        push_json(text, plant);
    }
    text.push_str("\n  ],\n");
}

fn field(text: &mut String, indent: usize, name: &str, value: &impl Serialize) {
    let _ = write!(text, "{:1$}\"{name}\": ", "", indent * 2);
    push_json(text, value);
    text.push_str(",\n");
}

/// Writing plain data into memory cannot fail; were it to, reading would find the gap.
fn push_json(text: &mut String, value: &impl Serialize) {
    text.push_str(&serde_json::to_string(value).unwrap_or_default());
}

/// Reads a project file.
///
/// # Errors
/// What is wrong with the file, in a sentence; never a panic, whatever the bytes.
pub fn from_bytes(bytes: &[u8]) -> Result<Document, ProjectError> {
    if bytes.len() > MAX_BYTES {
        return Err(ProjectError::TooLarge(bytes.len()));
    }
    // Some editors put a mark of the encoding before the text.
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let head: Head = match serde_json::from_slice(bytes) {
        Ok(head) => head,
        // A file that is cut off still begins like a project.
        Err(error) if looks_like_a_project(bytes) => return Err(malformed(&error)),
        Err(_) => return Err(ProjectError::NotAProject),
    };
    if head.format != FORMAT {
        return Err(ProjectError::NotAProject);
    }
    if !(PLAIN..=VERSION).contains(&head.version) {
        let needs = head.needs.as_deref().unwrap_or("of its time");
        let needs = needs
            .chars()
            .filter(|c| !c.is_control())
            .take(MAX_QUOTE)
            .collect();
        return Err(ProjectError::Version {
            version: head.version,
            needs,
        });
    }
    let file: File = serde_json::from_slice(bytes).map_err(|error| malformed(&error))?;
    if head.version < HANDLES && file.strokes.iter().any(|stroke| stroke.handles.is_some()) {
        return Err(ProjectError::Malformed(format!(
            "version {} has no field `handles`",
            head.version
        )));
    }
    if head.version < RADII && file.strokes.iter().any(|stroke| stroke.radii.is_some()) {
        return Err(ProjectError::Malformed(format!(
            "version {} has no field `radii`",
            head.version
        )));
    }
    if head.version < GROVE && file.habit.as_ref().is_some_and(Habit::has_later_laws) {
        return Err(ProjectError::Malformed(format!(
            "version {} has no laws `length`, `reach`, `peak`, `crowd`",
            head.version
        )));
    }
    if head.version < HABIT && file.habit.is_some() {
        return Err(ProjectError::Malformed(format!(
            "version {} has no field `habit`",
            head.version
        )));
    }
    if head.version < MODELS && (file.linked || !file.models.is_empty()) {
        return Err(ProjectError::Malformed(format!(
            "version {} has no models",
            head.version
        )));
    }
    if head.version < GROVE && !(file.plants.is_empty() && file.kinds.is_empty()) {
        return Err(ProjectError::Malformed(format!(
            "version {} has no planted trees",
            head.version
        )));
    }
    let holds_more = |kind: &File| {
        let is_one_tree = kind.models.is_empty() && kind.kinds.is_empty() && kind.plants.is_empty();
        !is_one_tree || !(PLAIN..=VERSION).contains(&kind.version)
    };
    if file.kinds.iter().any(holds_more) {
        return Err(ProjectError::Malformed(
            "a kind of planted tree is a project of one tree alone".to_owned(),
        ));
    }
    let mut document = document_from_file(file);
    document.validate()?;
    for kind in &document.grove.kinds {
        let alone = Document {
            sketch: Arc::clone(&kind.sketch),
            step: kind.step,
            ..Document::default()
        };
        alone.validate()?;
    }
    // A kind that nothing is of would take the place of another.
    Arc::make_mut(&mut document.grove).prune();
    Ok(document)
}

fn looks_like_a_project(bytes: &[u8]) -> bool {
    let beginning = &bytes[..bytes.len().min(MAX_QUOTE)];
    String::from_utf8_lossy(beginning).contains(FORMAT)
}

fn malformed(error: &serde_json::Error) -> ProjectError {
    let text = error.to_string();
    let short: String = text
        .chars()
        .filter(|c| !c.is_control())
        .take(MAX_QUOTE)
        .collect();
    ProjectError::Malformed(short)
}

/// The document a file describes, on the grid but not yet checked.
fn document_from_file(file: File) -> Document {
    let kinds = file.kinds.into_iter().map(|kind| {
        let Document { sketch, step, .. } = document_from_file(kind);
        Kind { sketch, step }
    });
    let grove = Grove {
        kinds: kinds.collect(),
        plants: file.plants.iter().map(Plant::quantized).collect(),
    };
    let strokes = file.strokes.into_iter().map(|stroke| {
        let radii = stroke.radii.unwrap_or_default();
        let mut stroke = Stroke {
            letter: stroke.letter,
            points: stroke.points.into_iter().map(quantize::point).collect(),
            attachment: stroke.attachment,
            self_similar: stroke.self_similar,
            handles: stroke.handles.unwrap_or_default(),
            radii: radii.into_iter().map(quantize::radius).collect(),
        };
        stroke.tidy_radii();
        Arc::new(stroke)
    });
    let sketch = Sketch {
        strokes: strokes.collect(),
        divergence_deg: quantize::angle_deg(file.divergence_deg),
        scale: quantize::coordinate(file.scale),
        tip_radius: quantize::coordinate(file.tip_radius),
        radius_exponent: quantize::coordinate(file.radius_exponent),
        wrap: file.wrap,
        self_similar_branches: file.self_similar_branches,
        own_rules: Arc::new(by_name(file.own_rules)),
        habit: Arc::new(file.habit.unwrap_or_default().quantized()),
    };
    Document {
        sketch: Arc::new(sketch),
        step: file.step,
        platform: file.platform.quantized(),
        selected: file.selected,
        models: Arc::new(file.models.iter().map(Model::quantized).collect()),
        linked: file.linked,
        grove: Arc::new(grove),
    }
}
