//! What is wrong with a mesh in words: each fault with its number, what it means and how it is mended.
//!
//! The order is by harm: first what stops measuring (surfaces without an inside), then what spoils a part of it, then what only costs.

use serde::Serialize;

use super::intersect::Intersections;
use super::report::Report;

/// A fault of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// [`Report::unusable_triangles`].
    UnusableTriangles,
    /// [`Report::non_manifold_edges`].
    NonManifoldEdges,
    /// [`Report::non_manifold_vertices`].
    NonManifoldVertices,
    /// Components that cannot be oriented.
    OneSidedComponents,
    /// Components whose triangles show their backs to the outside.
    InsideOutComponents,
    /// [`Report::turned_triangles`].
    TurnedTriangles,
    /// [`Intersections::pairs`].
    SelfIntersections,
    /// [`Report::boundary_loops`].
    OpenEnds,
    /// [`Report::duplicate_triangles`].
    DuplicateTriangles,
    /// [`Report::degenerate_triangles`].
    DegenerateTriangles,
    /// [`Report::zero_area_triangles`].
    ZeroAreaTriangles,
    /// [`Report::duplicate_vertices`].
    DuplicateVertices,
    /// [`Report::unused_vertices`].
    UnusedVertices,
}

/// A fault that a mesh has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// Which.
    pub fault: Fault,
    /// How often.
    pub count: usize,
    /// Whether that is all; else there are more.
    pub complete: bool,
    /// What it is, with its number.
    pub what: String,
    /// How it is mended, or when it need not be.
    pub hint: &'static str,
}

/// All faults of a mesh, the worst first. Without `intersections` nothing is said of them.
pub fn problems(report: &Report, intersections: Option<&Intersections>) -> Vec<Problem> {
    use Fault::*;
    let components = |is: fn(&super::report::Component) -> bool| {
        report.components.iter().filter(|one| is(one)).count()
    };
    let pairs = intersections.map_or(0, |found| found.pairs.len());
    let counts = [
        (UnusableTriangles, report.unusable_triangles.len()),
        (NonManifoldEdges, report.non_manifold_edges.len()),
        (NonManifoldVertices, report.non_manifold_vertices.len()),
        (OneSidedComponents, components(|one| !one.orientable)),
        (InsideOutComponents, components(|one| one.is_inside_out())),
        (TurnedTriangles, report.turned_triangles.len()),
        (SelfIntersections, pairs),
        (OpenEnds, report.boundary_loops.len()),
        (DuplicateTriangles, report.duplicate_triangles.len()),
        (DegenerateTriangles, report.degenerate_triangles.len()),
        (ZeroAreaTriangles, report.zero_area_triangles.len()),
        (DuplicateVertices, report.duplicate_vertices.len()),
        (UnusedVertices, report.unused_vertices.len()),
    ];
    let complete =
        |fault| fault != SelfIntersections || intersections.is_none_or(|found| found.complete);
    counts
        .into_iter()
        .filter(|(fault, count)| *count > 0 || !complete(*fault))
        .map(|(fault, count)| Problem {
            fault,
            count,
            complete: complete(fault),
            what: what(fault, count, complete(fault)),
            hint: hint(fault),
        })
        .collect()
}

/// A number with its digits in threes: `1,234,567`.
pub fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.char_indices() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn what(fault: Fault, count: usize, complete: bool) -> String {
    let (one, many) = words(fault);
    let least = if complete { "" } else { "more than " };
    let words = if count == 1 { one } else { many };
    format!("{least}{} {words}", grouped(count))
}

/// Of one and of many.
fn words(fault: Fault) -> (&'static str, &'static str) {
    match fault {
        Fault::UnusableTriangles => (
            "triangle has a vertex that is not there or not finite",
            "triangles have a vertex that is not there or not finite",
        ),
        Fault::NonManifoldEdges => (
            "non-manifold edge: more than two triangles meet at it",
            "non-manifold edges: more than two triangles meet at each",
        ),
        Fault::NonManifoldVertices => (
            "non-manifold vertex: parts touch in this point only",
            "non-manifold vertices: parts touch in these points only",
        ),
        Fault::OneSidedComponents => (
            "component has only one side, as a Möbius strip",
            "components have only one side, as a Möbius strip",
        ),
        Fault::InsideOutComponents => ("component is inside out", "components are inside out"),
        Fault::TurnedTriangles => (
            "triangle faces the other way than its neighbours",
            "triangles face the other way than their neighbours",
        ),
        Fault::SelfIntersections => (
            "pair of triangles passes through each other",
            "pairs of triangles pass through each other",
        ),
        Fault::OpenEnds => ("open end (boundary loop)", "open ends (boundary loops)"),
        Fault::DuplicateTriangles => ("triangle is there already", "triangles are there already"),
        Fault::DegenerateTriangles => (
            "degenerate triangle: it has a vertex twice",
            "degenerate triangles: they have a vertex twice",
        ),
        Fault::ZeroAreaTriangles => (
            "triangle without area: its vertices are on one line",
            "triangles without area: their vertices are on one line",
        ),
        Fault::DuplicateVertices => (
            "vertex has the coordinates of another",
            "vertices have the coordinates of others",
        ),
        Fault::UnusedVertices => ("vertex is in no triangle", "vertices are in no triangle"),
    }
}

fn hint(fault: Fault) -> &'static str {
    match fault {
        Fault::UnusableTriangles => "export the model again: the file is damaged",
        Fault::NonManifoldEdges => {
            "remove inner walls, or take the outer surface only (Blender: Select › All by Trait › Non Manifold shows them)"
        }
        Fault::NonManifoldVertices => {
            "part the surfaces at these points, or smooth the segmentation a little before it is meshed"
        }
        Fault::OneSidedComponents => {
            "it has no inside to measure: cut it, or mesh the segmentation again"
        }
        Fault::InsideOutComponents => "turn its triangles (mend: `orient`)",
        Fault::TurnedTriangles => "turn them to agree (mend: `orient`)",
        Fault::SelfIntersections => {
            "unite the parts to one surface (Blender: Modifiers › Remesh, or Boolean › Union with Self Intersection)"
        }
        Fault::OpenEnds => {
            "as it should be where a vessel or duct was cut; else fill the holes (mend: `close`)"
        }
        Fault::DuplicateTriangles => "they are left out; delete them to have a smaller file",
        Fault::DegenerateTriangles => {
            "they are left out; delete them to have a smaller file (mend: `weld`)"
        }
        Fault::ZeroAreaTriangles => {
            "they do no harm to lengths and areas; dissolve them where normals look wrong (Blender: Mesh › Clean Up › Degenerate Dissolve)"
        }
        Fault::DuplicateVertices => {
            "usual in STL files and at seams of colours; they are taken as one (mend: `weld` makes them one)"
        }
        Fault::UnusedVertices => "they are not shown; delete them to have a smaller file",
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that stops says enough by stopping"
    )]
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::mesh::intersect::{IntersectParams, intersections};
    use crate::mesh::report::{ReportParams, report};
    use crate::mesh::{Mesh, made};

    fn faults(mesh: &Mesh) -> Vec<(Fault, usize, bool)> {
        let never = AtomicBool::new(false);
        let report = report(mesh, &ReportParams::default(), &never, &mut |_, _| {}).unwrap();
        let params = IntersectParams { pairs_most: 3 };
        let pairs = intersections(mesh, &params, &never, &mut |_, _| {}).unwrap();
        let found = problems(&report, Some(&pairs));
        found
            .iter()
            .map(|one| (one.fault, one.count, one.complete))
            .collect()
    }

    #[test]
    fn each_fault_is_told() {
        let inverted = made::turned(made::cube(), |_| true);
        let pushed = made::both(
            &made::cube(),
            &made::placed(made::cube(), 1.0, glam::Vec3::splat(0.3)),
        );
        let table = [
            (made::cube(), vec![]),
            (made::tube(5, 3), vec![(Fault::OpenEnds, 2, true)]),
            (inverted, vec![(Fault::InsideOutComponents, 1, true)]),
            (
                made::turned(made::cube(), |t| t == 3),
                vec![(Fault::TurnedTriangles, 1, true)],
            ),
            (
                made::moebius(9),
                vec![
                    (Fault::OneSidedComponents, 1, true),
                    (Fault::OpenEnds, 1, true),
                ],
            ),
            (
                made::bow_tie(),
                vec![
                    (Fault::NonManifoldVertices, 1, true),
                    (Fault::OpenEnds, 2, true),
                ],
            ),
            (
                made::soup(&made::cube()),
                vec![(Fault::DuplicateVertices, 28, true)],
            ),
            (pushed, vec![(Fault::SelfIntersections, 3, false)]),
        ];
        for (mesh, expected) in table {
            assert_eq!(faults(&mesh), expected);
        }
    }

    #[test]
    fn numbers_are_said_in_threes_and_words_agree() {
        for (number, expected) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
        ] {
            assert_eq!(grouped(number), expected);
        }
        assert_eq!(
            what(Fault::UnusedVertices, 1, true),
            "1 vertex is in no triangle"
        );
        assert_eq!(
            what(Fault::SelfIntersections, 1000, false),
            "more than 1,000 pairs of triangles pass through each other"
        );
    }
}
