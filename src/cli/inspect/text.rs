//! One screen that tells a biologist what a model is like: what is wrong first, then size, shape, parts and open ends.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::facts::{ComponentFacts, Facts, OpenEnd};
use crate::mesh::problem::grouped;
use crate::mesh::unit::{Confidence, Scale, told};

/// Parts and open ends that the screen has room for.
const ROWS_MOST: usize = 8;

pub(super) fn screen(facts: &Facts) -> String {
    let mut text = format!(
        "{}: {}, {} triangles, {} vertices\n\n",
        facts.file,
        facts.format,
        grouped(facts.triangles),
        grouped(facts.vertices)
    );
    for account in facts.repairs.iter().flatten() {
        let _ = writeln!(text, "* {account}");
    }
    if facts.repairs.as_ref().is_some_and(|all| !all.is_empty()) {
        text.push('\n');
    }
    problems(facts, &mut text);
    beside(facts, &mut text);
    for remark in &facts.remarks {
        row(&mut text, "Remark", remark);
    }
    row(&mut text, "Size", &size(facts));
    row(&mut text, "Unit", &unit(facts.scale, &facts.size));
    row(&mut text, "Surface", &surface(facts));
    row(&mut text, "Shape", &shape(facts));
    if let Some(paint) = paint(facts) {
        row(&mut text, "Paint", &paint);
    }
    list(
        &mut text,
        "Parts",
        facts.component_count,
        &facts.components,
        part,
    );
    list(
        &mut text,
        "Open ends",
        facts.open_end_count,
        &facts.open_ends,
        open_end,
    );
    text
}

/// Nothing can fail in writing to a string.
fn row(text: &mut String, name: &str, what: &str) {
    let _ = writeln!(text, "{name:<10}{what}");
}

/// What the file holds beside the surface.
fn beside(facts: &Facts, text: &mut String) {
    if let Some(nodes) = facts.skeleton_nodes {
        let told = format!(
            "{} nodes, around which the surface was made",
            grouped(nodes)
        );
        row(text, "Skeleton", &told);
    }
    for (count, told) in [
        (
            facts.skipped_faces,
            "faces of the file have fewer than three corners",
        ),
        (facts.skipped_lines, "lines of the file are no surface"),
        (facts.skipped_points, "points of the file are no surface"),
        (
            facts.surplus_bytes,
            "bytes of the file stand behind its last triangle",
        ),
    ] {
        if count > 0 {
            row(text, "Left out", &format!("{} {told}", grouped(count)));
        }
    }
}

fn problems(facts: &Facts, text: &mut String) {
    if facts.problems.is_empty() {
        text.push_str("Nothing is wrong with it.\n\n");
        return;
    }
    for problem in &facts.problems {
        let _ = writeln!(text, "! {}\n    {}", problem.what, problem.hint);
    }
    text.push('\n');
}

/// Four digits, or as many as a whole number has.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e7).contains(&magnitude) => format!("{value:.3e}"),
        _ if magnitude >= 1000.0 => format!("{value:.0}"),
        _ if magnitude >= 10.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

fn point(point: &[f64; 3]) -> String {
    point.map(number).join(" ")
}

fn size(facts: &Facts) -> String {
    format!(
        "{}, from ({}) to ({})",
        facts.size.map(number).join(" × "),
        point(&facts.min),
        point(&facts.max)
    )
}

fn unit(scale: Option<Scale>, size: &[f64; 3]) -> String {
    let Some(scale) = scale else {
        return "not known, since the model has no size".to_owned();
    };
    let longest = size.iter().copied().fold(0.0, f64::max);
    let sure = match scale.confidence {
        Confidence::Stated => "as the format has it",
        Confidence::Customary => "by the format's custom",
        Confidence::Guessed => "guessed by size",
    };
    let long = told(longest * scale.unit.metres());
    let or: Vec<String> = scale
        .alternatives
        .iter()
        .map(|unit| {
            format!(
                ", or {} if in {}",
                told(longest * unit.metres()),
                unit.name()
            )
        })
        .collect();
    format!("{} ({sure}): {long} long{}", scale.unit.name(), or.concat())
}

fn surface(facts: &Facts) -> String {
    let closed = match (facts.watertight, facts.manifold) {
        (true, true) => "watertight",
        (true, false) => "watertight but not manifold",
        (false, true) => "open",
        (false, false) => "open and not manifold",
    };
    let volume = match facts.volume {
        Some(volume) if facts.watertight => format!(", encloses {}", number(volume)),
        Some(volume) => format!(", closed parts enclose {}", number(volume)),
        None => String::new(),
    };
    format!("{closed}, area {}{volume}", number(facts.area))
}

fn shape(facts: &Facts) -> String {
    let handles: u64 = facts
        .components
        .iter()
        .filter_map(|part| part.genus)
        .map(u64::from)
        .sum();
    let genus = match facts.components.iter().all(|part| part.genus.is_some()) {
        true => format!("genus {handles}"),
        false => "no genus, since it is not a manifold with two sides".to_owned(),
    };
    format!(
        "{} in {}, {} open ends, {genus}, Euler characteristic {}",
        if facts.orientable {
            "two sides"
        } else {
            "one side"
        },
        match facts.component_count {
            1 => "1 part".to_owned(),
            many => format!("{} parts", grouped(many)),
        },
        grouped(facts.open_end_count),
        facts.euler_characteristic
    )
}

/// What colours the surface, if anything does.
fn paint(facts: &Facts) -> Option<String> {
    let several = |count: usize, what: &str| match count {
        0 => None,
        1 => Some(format!("1 {what}")),
        many => Some(format!("{} {what}s", grouped(many))),
    };
    let images = facts.images.iter().take(ROWS_MOST).map(|image| {
        let (width, height) = (image.width_px, image.height_px);
        format!("{} {width} × {height}", image.format)
    });
    let images: Vec<String> = images.collect();
    let images =
        several(facts.image_count, "image").map(|count| format!("{count} ({})", images.join(", ")));
    let colours = facts
        .has_colours
        .then(|| "colours at the vertices".to_owned());
    let all = [several(facts.material_count, "material"), images, colours];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Rows as far as there is room. One part is the whole and not told again.
fn list<T>(text: &mut String, name: &str, count: usize, all: &[T], tell: fn(&T) -> String) {
    if count == 0 || (count == 1 && name == "Parts") {
        return;
    }
    let _ = writeln!(text, "\n{name}");
    for (at, one) in all.iter().take(ROWS_MOST).enumerate() {
        let _ = writeln!(text, "  {:<8}{}", at + 1, tell(one));
    }
    if count > ROWS_MOST {
        let _ = writeln!(text, "  and {} more", grouped(count - ROWS_MOST));
    }
}

fn part(part: &ComponentFacts) -> String {
    let ends = match (part.closed, part.boundary_loops) {
        (true, _) => "closed".to_owned(),
        (false, 1) => "1 open end".to_owned(),
        (false, ends) => format!("{ends} open ends"),
    };
    let turned = match (part.inside_out, part.hollow) {
        (true, _) => ", inside out",
        (_, true) => ", a hollow",
        _ => "",
    };
    format!(
        "{} triangles, area {}, {ends}{turned}",
        grouped(part.triangles as usize),
        number(part.area)
    )
}

/// How wide it is: the diameter of a circle as long.
fn open_end(end: &OpenEnd) -> String {
    format!(
        "about {} wide, {} edges, centre ({})",
        number(end.length / PI),
        grouped(end.edges),
        point(&end.centre)
    )
}
