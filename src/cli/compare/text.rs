//! A comparison as a person reads it.

use std::fmt::Write as _;

use crate::mesh::unit::Rounded;
use crate::tree::compare::space::Apart as Far;
use crate::tree::compare::told::About;
use crate::tree::compare::{Bars, Pair, Studied};

/// Letters of a tree's name in tables.
const NAME: usize = 22;

/// Numbers, distributions, branching and space, with the verdicts first.
pub(super) fn screen(about: &[About], trees: &[Studied], pairs: &[Pair]) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    for (place, one) in about.iter().enumerate() {
        let branches = trees[place].measures.branches.len();
        let mark = if place == 0 {
            ", which the others are compared to"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "{}: {}, {} nodes, {}{mark}",
            one.name,
            one.kind,
            one.nodes,
            match branches {
                1 => "1 branch".to_owned(),
                branches => format!("{branches} branches"),
            }
        );
    }
    text.push('\n');
    for pair in pairs {
        let [a, b] = pair.places.map(|place| &about[place].name);
        let _ = writeln!(text, "{b} to {a}: {}.", pair.verdict.words);
    }
    let to_first: Vec<&Pair> = pairs.iter().filter(|pair| pair.places[0] == 0).collect();
    text.push('\n');
    numbers(&mut text, about, trees, &to_first);
    for pair in &to_first {
        let [a, b] = pair.places.map(|place| &about[place].name);
        let _ = writeln!(text, "\n{b} to {a}");
        distributions(&mut text, pair);
        topology(&mut text, pair);
        space(&mut text, pair);
    }
    if about.len() > 2 {
        matrix(&mut text, about, pairs);
    }
    let lines = text.lines().map(str::trim_end);
    lines.flat_map(|line| [line, "\n"]).collect()
}

fn short(name: &str) -> String {
    let letters = name.chars().count();
    match letters > NAME {
        // The end of a path says more than its beginning.
        true => format!(
            "…{}",
            name.chars().skip(letters + 1 - NAME).collect::<String>()
        ),
        false => name.to_owned(),
    }
}

fn value(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| Rounded(value).to_string())
}

fn percent(part: Option<f64>) -> String {
    match part {
        None => "–".to_owned(),
        // Next to nothing is not told with a sign.
        Some(part) if part.abs() < 5e-4 => "0.0 %".to_owned(),
        Some(part) if part.abs() < 10.0 => format!("{:+.1} %", 100.0 * part),
        Some(part) => format!("{:+.0} %", 100.0 * part),
    }
}

/// A row a number: what each tree has, and how much more than the first.
fn numbers(text: &mut String, about: &[About], trees: &[Studied], to_first: &[&Pair]) {
    let _ = write!(text, "{:<36}{:>NAME$}", "", short(&about[0].name));
    for one in &about[1..] {
        let _ = write!(
            text,
            "{:>width$}{:>12}",
            short(&one.name),
            "",
            width = NAME + 2
        );
    }
    text.push('\n');
    for (row, number) in trees[0].numbers.iter().enumerate() {
        let _ = write!(text, "{:<36}{:>NAME$}", number.name, value(number.value));
        for pair in to_first {
            let difference = &pair.differences[row];
            let mark = if difference.matches(false) { ' ' } else { '!' };
            let _ = write!(
                text,
                "{:>width$}{:>12}",
                value(difference.b),
                format!("{} {mark}", percent(difference.relative)),
                width = NAME + 2
            );
        }
        text.push('\n');
    }
    text.push_str("! beyond tolerance: 5 % of means and counts, 10 % of standard deviations; lengths in each file's own unit, angles in degrees\n");
}

/// A row a quantity, as they are and at one size.
fn distributions(text: &mut String, pair: &Pair) {
    let _ = writeln!(
        text,
        "  {:<24}{:>9}{:>9}{:>7}{:>12}{:>9}   {:>16}",
        "distribution", "n", "n", "D", "p by Holm", "Cliff's", "D at one size"
    );
    for (one, free) in pair.distributions.iter().zip(&pair.scale_free) {
        let p = one
            .tested
            .map(|tested| tested.ks_p[1].min(tested.mann_whitney[2]));
        let of = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
        };
        let p = match p {
            Some(p) if p < 1e-300 => "< 1e-300".to_owned(),
            Some(p) if p < 1e-3 => format!("{p:.0e}"),
            p => of(p, 3),
        };
        let mark = |is_told: bool| if is_told { '!' } else { ' ' };
        let _ = writeln!(
            text,
            "  {:<24}{:>9}{:>9}{:>7}{p:>12}{:>9} {} {:>16} {}",
            one.words,
            one.n[0],
            one.n[1],
            of(one.d, 2),
            of(one.tested.map(|tested| tested.delta), 2),
            mark(one.is_told()),
            of(free.d, 2),
            mark(free.is_told()),
        );
    }
    text.push_str("  ! told apart: corrected p below 0.05 and D of 0.15 or more\n");
}

fn topology(text: &mut String, pair: &Pair) {
    let of = |bars: &Bars| {
        let exact = match bars.as_is.matched {
            Some(_) => "",
            None => ", by slices",
        };
        format!(
            "{:.1} % of {} and {} bars have no counterpart, {:.1} % at one length{exact}",
            100.0 * bars.as_is.share,
            bars.n[0],
            bars.n[1],
            100.0 * bars.scale_free.share
        )
    };
    let topology = &pair.topology;
    let _ = writeln!(text, "  barcodes along branches: {}", of(&topology.path));
    let _ = writeln!(text, "  barcodes straight out: {}", of(&topology.radial));
    let _ = match topology.edits {
        Some(edits) => writeln!(
            text,
            "  forks: {edits} of {} branches to take away or add until both fork alike",
            pair.branches[0] + pair.branches[1]
        ),
        None => writeln!(text, "  forks: not counted, there are too many branches"),
    };
}

fn space(text: &mut String, pair: &Pair) {
    let Some(space) = &pair.space else {
        return;
    };
    let of = |far: Far| {
        format!(
            "{} in the mean ({:.1} % of their reach), {} at most",
            Rounded(far.mean),
            100.0 * far.mean / space.reach,
            Rounded(far.max)
        )
    };
    let fit = |scale: f64| match (scale - 1.0).abs() < 5e-4 {
        true => String::new(),
        false => format!(", the second made {} times as large", Rounded(scale)),
    };
    let _ = writeln!(text, "  axes apart as they are: {}", of(space.as_is));
    let _ = writeln!(text, "  root to root: {}", of(space.rooted));
    let _ = writeln!(
        text,
        "  fitted: {}{}",
        of(space.fitted.apart),
        fit(space.fitted.scale)
    );
    let _ = writeln!(text, "  mirrored and fitted: {}", of(space.mirrored.apart));
}

/// How much of the branching has no counterpart, tree by tree.
fn matrix(text: &mut String, about: &[About], pairs: &[Pair]) {
    text.push_str("\nbars without counterpart, at one length\n");
    for (row, one) in about.iter().enumerate() {
        let _ = write!(text, "  {:<NAME$}", short(&one.name));
        for column in 0..about.len() {
            let places = [row.min(column), row.max(column)];
            let pair = pairs.iter().find(|pair| pair.places == places);
            let share = pair.map_or(0.0, |pair| pair.topology.path.scale_free.share);
            let _ = write!(text, "{:>8}", format!("{:.0} %", 100.0 * share));
        }
        text.push('\n');
    }
}
