//! Algorithm 1 as a grammar in Ramus's own language, which a person can open and edit.
//!
//! A tip `B(time, order, iteration, centerline, longest, other)` grows a segment as long as its time is below its order's lifetime, then forks
//! or goes on. It dies once its iteration is beyond the longest that its centerline may be. A tip whose fork already holds a dead branch does not
//! fork: `other` is the longest that the other branch's centerline may be, so that it is known when that died. Two productions cannot tell
//! each other what they drew, so a fork is first a module `J` that holds what was drawn, and decomposes into its branches in the same step.
//!
//! Lengths, radii and angles by order go by the forks below a branch, `f`, as a measured tree's orders do; `o` counts, as the source's, also where a tip goes
//! on without a fork.
//!
//! Numbers of centerlines: the first branch keeps its parent's, each further one gets a new one: a digit more in base three, at the place of the order.

use std::fmt::Write as _;

use super::by_order::ByOrder;
use super::error::AbstractionError;
use super::params::Params;
use crate::lsystem::Grammar;

/// How many standard deviations beyond its mean a drawn number of iterations is taken to be at most.
const DEVIATIONS: f64 = 4.0;

/// The steps after which no tip lives, as good as surely.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "some hundred at most"
)]
pub fn steps(params: &Params) -> u32 {
    (params.iterations + DEVIATIONS * params.iterations_std)
        .ceil()
        .clamp(0.0, 1000.0) as u32
        + 2
}

/// The grammar's text.
pub fn text(params: &Params) -> String {
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write_text(&mut text, params);
    text
}

/// The grammar.
///
/// # Errors
/// A parameter beyond its limits.
pub fn grammar(params: &Params) -> Result<Grammar, AbstractionError> {
    params.check()?;
    Ok(Grammar::parse(&text(params), "abstraction.lsys")?)
}

fn write_text(text: &mut String, params: &Params) -> std::fmt::Result {
    // Forks below a branch are counted only where something goes by them.
    let by_forks = ByOrder::ALL.iter().any(|of| !of.factors(params).is_empty());
    let forks_below = if by_forks { ", forks" } else { "" };
    writeln!(
        text,
        "# A branching structure by its statistics: Algorithm 1 of van Nielen, Verbeek and Cao.\n\
         # I(length, radius, iteration, centerline) is a segment, B(time, order, iteration, centerline, longest, other{forks_below}) a live tip, D a dead one,\n\
         # J a fork as it comes into being."
    )?;
    writeln!(text, "seed {}\nsteps {}", params.seed, steps(params))?;
    let stem = params.stem_length;
    let constants: [(&str, f64); 14] = [
        ("segment_radius", params.segment_radius),
        ("radial_increment", params.radial_increment),
        ("iterations", params.iterations),
        ("iterations_std", params.iterations_std),
        ("side_life", params.side_life),
        ("max_order", f64::from(params.max_order)),
        ("segment_length", params.segment_length),
        ("segment_length_std", params.segment_length_std),
        ("length_ratio", params.length_ratio),
        ("radius_ratio", params.radius_ratio),
        ("upwards_angle", params.upwards_angle),
        ("upwards_angle_std", params.upwards_angle_std),
        ("bifurcation_angle", params.bifurcation_angle),
        ("bifurcation_angle_std", params.bifurcation_angle_std),
    ];
    for (name, value) in constants {
        writeln!(text, "const {name} = {value}")?;
    }
    writeln!(text, "const roll_range = {}", params.roll_range)?;
    writeln!(
        text,
        "const bifurcation_probability = {}",
        params.bifurcation_probability
    )?;
    writeln!(
        text,
        "const trifurcation_probability = {}",
        params.trifurcation_probability
    )?;
    text.push_str("const never = 1e9\n\naxiom ");
    let of_stem = |of: ByOrder| match of.factors(params).first() {
        Some(factor) => format!(" * {factor}"),
        None => String::new(),
    };
    let [long, thick] = [ByOrder::Length, ByOrder::Radius].map(of_stem);
    for _ in 0..stem {
        write!(
            text,
            "I(segment_length{long}, segment_radius{thick}, 0, 0) "
        )?;
    }
    text.push_str("S\n");
    if params.radial_increment != 0.0 {
        text.push_str("I(l, r, i, c) -> I(l, r + radial_increment, i, c)\n");
    }
    let [long, thick] = [ByOrder::Length, ByOrder::Radius].map(|of| of_order(params, of));
    let [f, next, first] = match by_forks {
        true => [", f", ", f + 1", ", 1"],
        false => [""; 3],
    };
    let roll = "/(integer(-roll_range, roll_range))";
    writeln!(
        text,
        "B(t, o, i, c, m, n{f}) : i > m -> D(c)\n\
         B(t, o, i, c, m, n{f}) : t < floor(max_order / (o + 1)) + 1 -> ^(normal(upwards_angle, upwards_angle_std)) I(lognormal(segment_length, segment_length_std) * length_ratio^o{long}, segment_radius * radius_ratio^o{thick}, i + 1, c) B(t + 1, o, i + 1, c, m, n{f})\n\
         B(t, o, i, c, m, n{f}) : i - 1 > n -> [ {roll} B(0, o + 1, i + 1, c, m, never{f}) ]"
    )?;
    let [two, three] = forks(params);
    if params.bifurcation_probability < 1.0 {
        writeln!(
            text,
            "B(t, o, i, c, m, n{f}) : weight 1 - bifurcation_probability -> [ {roll} B(0, o + 1, i + 1, c, m, never{f}) ]"
        )?;
    }
    let draw = "lognormal(iterations, iterations_std)";
    let side = |i: &str| match params.side_life {
        1.0 => draw.to_owned(),
        _ => format!("mix({i}, {draw}, side_life)"),
    };
    let (of_stem, later) = (side("0"), side("i + 1"));
    if two > 0.0 {
        writeln!(
            text,
            "B(t, o, i, c, m, n{f}) : weight bifurcation_probability * (1 - trifurcation_probability) -> J(o + 1, i + 1, c, {draw}, {later}{next})"
        )?;
    }
    if three > 0.0 {
        writeln!(
            text,
            "B(t, o, i, c, m, n{f}) : weight bifurcation_probability * trifurcation_probability -> J(o + 1, i + 1, c, {draw}, {later}, {later}{next})"
        )?;
    }
    writeln!(
        text,
        "decompose {{\n  S -> J(0, 0, 0, {draw}, {of_stem}{first})"
    )?;
    let branch = |text: &mut String, place: [u32; 2], line: &str, lives: [&str; 2]| {
        branch(text, params, place, line, lives, f)
    };
    let tag = |parameters: &str| format!("  J(o, i, c, {parameters}{f}) ->");
    text.push_str(&tag("m, n"));
    branch(text, [0, 2], "c", ["m", "n"])?;
    branch(text, [1, 2], "c + 3^-(o + 1)", ["n", "m"])?;
    if three > 0.0 {
        text.push('\n');
        text.push_str(&tag("l, m, n"));
        branch(text, [0, 3], "c", ["l", "min(m, n)"])?;
        branch(text, [1, 3], "c + 3^-(o + 1)", ["m", "min(l, n)"])?;
        branch(text, [2, 3], "c + 2 * 3^-(o + 1)", ["n", "min(l, m)"])?;
    }
    text.push_str("\n}\ninterpret {\n  I(l, r, i, c) -> !(2 * r) F(l)\n}\n");
    Ok(())
}

/// What multiplies a number by the order of a branch, which is how many forks are below it.
fn of_order(params: &Params, of: ByOrder) -> String {
    let factors = of.factors(params);
    if factors.is_empty() {
        return String::new();
    }
    let all: Vec<String> = factors.iter().map(f64::to_string).collect();
    format!(" * pick(f, {})", all.join(", "))
}

/// How likely a fork has two and three branches.
fn forks(params: &Params) -> [f64; 2] {
    let three = params.bifurcation_probability * params.trifurcation_probability;
    [params.bifurcation_probability - three, three]
}

/// A branch of a fork.
fn branch(
    text: &mut String,
    params: &Params,
    [place, of]: [u32; 2],
    centerline: &str,
    [longest, other]: [&str; 2],
    forks: &str,
) -> std::fmt::Result {
    let turned = match params.around {
        true => f64::from(place) * 360.0 / f64::from(of),
        false => 0.0,
    };
    let roll = match turned {
        0.0 => "integer(-roll_range, roll_range)".to_owned(),
        turned => format!("{turned} + integer(-roll_range, roll_range)"),
    };
    let pitch = of_order(params, ByOrder::Angle);
    write!(
        text,
        " [ /({roll}) &(normal(bifurcation_angle{pitch}, bifurcation_angle_std)) B(0, o, i, {centerline}, {longest}, {other}{forks}) ]"
    )
}
