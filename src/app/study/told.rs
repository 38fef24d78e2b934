//! A report as text for the screen.

use super::report::{Condition, Pair, Report};
use super::summary::{Paired, Summary, Test};
use crate::world::study::score::{Part, STATEMENTS};

/// The whole report.
pub fn told(report: &Report) -> String {
    let mut lines = vec![heading(report)];
    for section in [usability, statements, sickness, tasks, left_out] {
        let section = section(report);
        if !section.is_empty() {
            lines.push(String::new());
            lines.extend(section);
        }
    }
    lines.join("\n") + "\n"
}

fn many(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

fn heading(report: &Report) -> String {
    let conditions = report.conditions.iter();
    let sizes: Vec<String> = conditions
        .map(|one| format!("{} ({})", one.condition, one.sittings))
        .collect();
    format!(
        "{}, {}: {}",
        many(report.participants.len(), "participant", "participants"),
        many(sizes.len(), "condition", "conditions"),
        sizes.join(", ")
    )
}

/// The width that all conditions' names fit into.
fn width(report: &Report) -> usize {
    let names = report.conditions.iter().map(|one| one.condition.len());
    names.max().unwrap_or(0).max("condition".len())
}

/// A number of two decimals, with a minus that is as wide as a plus.
fn two(value: f64) -> String {
    // No minus before a nothing.
    let rounded = (value * 100.0).round() / 100.0 + 0.0;
    format!("{rounded:.2}").replace('-', "−")
}

fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), two)
}

fn three(value: f64) -> String {
    match value < 0.0005 {
        true => format!("{value:.1e}"),
        false => format!("{value:.3}"),
    }
}

fn usability(report: &Report) -> Vec<String> {
    let wide = width(report);
    let mut lines = Vec::new();
    for one in &report.conditions {
        let Some(sus) = &one.sus else { continue };
        let Summary {
            n,
            mean,
            sd,
            median,
            min,
            max,
        } = sus.summary;
        lines.push(format!(
            "  {:wide$} {n:4} {:>7} {:>7} {:>7} {min:>6} {max:>6}  {}, {}",
            one.condition,
            two(mean),
            maybe(sd),
            two(median),
            sus.adjective,
            sus.acceptability
        ));
    }
    if lines.is_empty() {
        return lines;
    }
    let head = format!(
        "  {:wide$}    n    mean      sd  median    min    max",
        "condition"
    );
    lines.splice(0..0, ["System Usability Scale, 0 to 100".to_owned(), head]);
    lines.extend(report.conditions.iter().flat_map(by_order));
    for pair in &report.pairs {
        if let Some(sus) = &pair.sus {
            lines.push(format!(
                "  {} less {}: {}",
                pair.second,
                pair.first,
                compared(sus)
            ));
        }
    }
    lines
}

/// Whether it mattered what came first, where both did.
fn by_order(one: &Condition) -> Option<String> {
    let orders = &one.sus.as_ref()?.by_order;
    let parts = orders.iter().map(|by| {
        format!(
            "{} as sitting {} ({})",
            two(by.summary.mean),
            by.order,
            by.summary.n
        )
    });
    (orders.len() > 1).then(|| {
        let parts: Vec<String> = parts.collect();
        format!("  {}: mean {}", one.condition, parts.join(", "))
    })
}

/// A mean difference and its test, in a line.
fn compared(paired: &Paired) -> String {
    let Paired { difference, test } = paired;
    let mean = format!(
        "{} on average of {}",
        two(difference.mean),
        many(difference.n, "pair", "pairs")
    );
    match test {
        None => format!("{mean}; no pair differs"),
        Some(test) => format!("{mean}; {}", tested(test)),
    }
}

fn tested(test: &Test) -> String {
    let p = match test.p_method {
        "exact" => format!(
            "p {} (exact; {} by the normal distribution)",
            three(test.p),
            three(test.p_limit)
        ),
        _ => format!("p {} (by the normal distribution)", three(test.p)),
    };
    format!(
        "Wilcoxon W {} of {} pairs that differ, Z {:.3}, {p}, rank-biserial {}",
        test.w_plus.min(test.w_minus),
        test.n,
        test.z,
        two(test.effect)
    )
    .replace("Z -", "Z −")
}

/// A statement.
struct Row<'a> {
    name: String,
    /// Under each condition.
    means: Vec<Option<f64>>,
    /// Where there is one pair of conditions.
    paired: Option<&'a Paired>,
}

/// Statements of the SUS and own ones: their means, and p where two conditions are compared.
fn statements(report: &Report) -> Vec<String> {
    let sus: Vec<Row<'_>> = STATEMENTS
        .iter()
        .enumerate()
        .map(|(place, name)| {
            let of = |one: &Condition| one.sus.as_ref()?.items.get(place).copied().flatten();
            row(report, place, name, &of, |pair| &pair.items)
        })
        .collect();
    let most = report.conditions.iter().map(|one| one.own.len()).max();
    let own: Vec<Row<'_>> = (0..most.unwrap_or(0))
        .map(|place| {
            let of = |one: &Condition| one.own.get(place).copied().flatten();
            row(report, place, &format!("own_{}", place + 1), &of, |pair| {
                &pair.own
            })
        })
        .collect();
    let answered = |rows: &[Row<'_>]| {
        let mut means = rows.iter().flat_map(|row| &row.means);
        means.any(Option::is_some)
    };
    let mut lines = Vec::new();
    for rows in [sus, own].iter().filter(|rows| answered(rows)) {
        lines.push(match lines.is_empty() {
            true => "Means of statements, 1 strongly disagree to 5 strongly agree".to_owned(),
            false => String::new(),
        });
        lines.push(statements_head(report));
        lines.extend(rows.iter().map(|row| statement(report, row)));
    }
    lines
}

/// The width of a condition's means.
fn mean_width(condition: &Condition) -> usize {
    condition.condition.len().max(6)
}

fn statements_head(report: &Report) -> String {
    let mut head = format!("  {:32}", "");
    for one in &report.conditions {
        head += &format!(" {:>wide$}", one.condition, wide = mean_width(one));
    }
    if report.pairs.len() == 1 {
        head += "       p  p (Holm)";
    }
    head
}

fn statement(report: &Report, row: &Row<'_>) -> String {
    let mut line = format!("  {:32}", row.name);
    for (one, mean) in report.conditions.iter().zip(&row.means) {
        line += &format!(" {:>wide$}", maybe(*mean), wide = mean_width(one));
    }
    if let Some(test) = row.paired.and_then(|paired| paired.test) {
        let holm = test.p_holm.map_or_else(String::new, three);
        line += &format!(" {:>7}  {holm:>8}", three(test.p));
    }
    line
}

fn row<'a>(
    report: &'a Report,
    place: usize,
    name: &str,
    of: &dyn Fn(&Condition) -> Option<Summary>,
    paired: fn(&Pair) -> &Vec<Option<Paired>>,
) -> Row<'a> {
    let means = report.conditions.iter().map(|one| Some(of(one)?.mean));
    Row {
        name: format!("{:2} {name}", place + 1),
        means: means.collect(),
        paired: match report.pairs.as_slice() {
            [pair] => paired(pair).get(place).and_then(Option::as_ref),
            _ => None,
        },
    }
}

fn sickness(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    for one in report.conditions.iter().filter(|one| !one.ssq.is_empty()) {
        lines.push(format!(
            "Simulator Sickness Questionnaire, {}: means (sd)",
            one.condition
        ));
        lines.push(format!(
            "  {:15} {:>16} {:>16} {:>16}",
            "", "before", "after", "change"
        ));
        for factor in &one.ssq {
            let shown = |summary: Option<Summary>| match summary {
                None => "–".to_owned(),
                Some(found) => format!("{} ({})", two(found.mean), maybe(found.sd)),
            };
            let change = factor.change.as_ref();
            let test = match change.map(|change| change.test) {
                None => String::new(),
                Some(None) => "  nobody changed".to_owned(),
                Some(Some(test)) => format!("  Z {:.3}, p {}", test.z, three(test.p)),
            };
            lines.push(format!(
                "  {:15} {:>16} {:>16} {:>16}{}",
                factor.factor.name(),
                shown(factor.before),
                shown(factor.after),
                shown(change.map(|change| change.difference)),
                test.replace("Z -", "Z −")
            ));
        }
        let n = |of: fn(&super::report::Sickness) -> usize| one.ssq.first().map_or(0, of);
        lines.push(format!(
            "  n: {} before, {} after, {} both",
            n(|one| one.before.map_or(0, |all| all.n)),
            n(|one| one.after.map_or(0, |all| all.n)),
            n(|one| one.change.map_or(0, |all| all.difference.n)),
        ));
    }
    lines
}

fn tasks(report: &Report) -> Vec<String> {
    let wide = width(report);
    let names = report.conditions.iter().flat_map(|one| &one.tasks);
    let task_wide = names.map(|task| task.task.len()).max().unwrap_or(0).max(4);
    let mut lines = Vec::new();
    for one in &report.conditions {
        for task in &one.tasks {
            let median = maybe(task.seconds.map(|seconds| seconds.median));
            let mean = maybe(task.seconds.map(|seconds| seconds.mean));
            lines.push(format!(
                "  {:wide$} {:task_wide$} {:5} {:5} {:10} {:5} {median:>10} {mean:>8}",
                one.condition, task.task, task.n, task.done, task.time_over, task.left
            ));
        }
    }
    if !lines.is_empty() {
        let head = format!(
            "  {:wide$} {:task_wide$}     n  done  time over  left  median s   mean s",
            "condition", "task"
        );
        lines.splice(
            0..0,
            ["Tasks; times of those that are done".to_owned(), head],
        );
    }
    lines
}

fn left_out(report: &Report) -> Vec<String> {
    let lines = report.left_out.iter().map(|one| {
        let of = match one.part {
            Part::Own => "some means of",
            _ => "the score of",
        };
        format!(
            "  {} under {} is left out of {of} {}: {}",
            one.participant,
            one.condition,
            one.part.title(),
            one.reason
        )
    });
    let mut lines: Vec<String> = lines.collect();
    if !lines.is_empty() {
        lines.insert(0, "Left out".to_owned());
    }
    lines
}
