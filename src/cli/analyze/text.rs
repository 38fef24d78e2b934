//! The analysis as a person reads it.

use std::fmt::Write as _;

use crate::centerline::analysis::{Analysis, TableFacts};
use crate::mesh::unit::Rounded;
use crate::tree::measure::{Spread, spread};

/// Some thirty lines.
pub(super) fn screen(analysis: &Analysis) -> String {
    let mut text = String::new();
    let counts = analysis.counts;
    let many = |count: usize, one: &str, more: &str| {
        format!("{count} {}", if count == 1 { one } else { more })
    };
    let mut line = |said: String| {
        let _ = writeln!(text, "{said}"); // Writing into a string cannot fail.
    };
    let unit = analysis
        .model
        .unit
        .map_or(String::new(), |unit| format!(", most likely in {unit}"));
    line(format!("{}{unit}", analysis.model.file));
    line(format!(
        "{}, {}, {} ({}), {}",
        many(counts.centerlines, "centerline", "centerlines"),
        many(counts.branches, "branch", "branches"),
        many(counts.junctions, "junction", "junctions"),
        many(counts.bifurcations, "bifurcation", "bifurcations"),
        many(counts.tips, "tip", "tips"),
    ));
    if analysis.endpoints.automatic {
        line("endpoints were found on the surface".to_owned());
    }
    if !analysis.endpoints.unreached.is_empty() {
        let lost = analysis.endpoints.unreached.len();
        line(format!(
            "{} not reached",
            many(lost, "target was", "targets were")
        ));
    }
    if counts.loops_left_out > 0 {
        line(format!(
            "{}: the tree has one side of each",
            many(counts.loops_left_out, "loop", "loops")
        ));
    }
    if let Some(vmtk) = analysis.counts_vmtk {
        let swallowed = match vmtk.swallowed {
            0 => String::new(),
            many => format!(", {many} too short to be any"),
        };
        line(format!(
            "by VMTK's definition {}, {} ({} of two){swallowed}",
            many(vmtk.branches, "branch", "branches"),
            many(
                vmtk.bifurcations + vmtk.multifurcations,
                "bifurcation",
                "bifurcations"
            ),
            vmtk.bifurcations,
        ));
    } else {
        line("balls overlap too much for VMTK's definition of branch".to_owned());
    }
    text += &table("whole branches", &analysis.table);
    if let Some(vmtk) = &analysis.table_vmtk {
        text += &table("VMTK's branches", vmtk);
    }
    let to_surface = spread(
        analysis
            .centerlines
            .iter()
            .filter_map(|one| one.length_to_surface),
    );
    if to_surface.n > 0 {
        let _ = writeln!(
            text,
            "centerlines from surface to surface {} ± {}",
            Rounded(to_surface.mean),
            Rounded(to_surface.std),
        );
    }
    text
}

/// The rows of a table whose branches are so.
fn table(branches: &str, table: &TableFacts) -> String {
    let mut text = format!(
        "\n{branches:<34}{:>10}{:>10}{:>10}{:>10}{:>8}\n",
        "mean", "std", "min", "max", "n"
    );
    let mut row = |name: &str, spread: &Spread| {
        let numbers = [spread.mean, spread.std, spread.min, spread.max]
            .map(|number| Rounded(number).to_string());
        let [mean, std, min, max] = numbers;
        let _ = writeln!(
            text,
            "{name:<34}{mean:>10}{std:>10}{min:>10}{max:>10}{:>8}",
            spread.n
        );
    };
    row("branch length", &table.branch_length);
    row("point radius", &table.point_radius);
    row("centerline length", &table.centerline_length);
    row("bifurcation angle (degrees)", &table.bifurcation_angle_deg);
    row(
        "the same in its plane",
        &table.bifurcation_angle_in_plane_deg,
    );
    row("curvature", &table.curvature);
    row("torsion", &table.torsion);
    row("tortuosity (length / chord − 1)", &table.tortuosity);
    let _ = writeln!(
        text,
        "stem {} ({} iterations); iterations {} ± {}; upwards angle {} ± {} degrees",
        Rounded(table.stem_length),
        Rounded(table.stem_iterations),
        Rounded(table.iterations.mean),
        Rounded(table.iterations.std),
        Rounded(table.upwards_angle_deg.mean),
        Rounded(table.upwards_angle_deg.std),
    );
    text
}
