//! Colours of triangles that show what a report found: parts, and what is wrong.
//!
//! A fault colours the triangles that have it; a fault of an edge or a vertex those that have the edge or vertex, so that it is seen from afar. Where
//! several faults meet, the worst shows, in the order of [`super::problem`].

use super::Mesh;
use super::intersect::Intersections;
use super::problem::Fault;
use super::report::{NONE, Report};

/// A colour, sRGB with alpha; all 0: the model's own.
pub type Colour = [u8; 4];

/// Colours for numbers of parts: Okabe and Ito's eight, which people with any colour vision tell apart, then the same darker.
#[must_use]
pub fn part_colour(number: u32) -> Colour {
    const EIGHT: [[u8; 3]; 8] = [
        [230, 159, 0],
        [86, 180, 233],
        [0, 158, 115],
        [240, 228, 66],
        [0, 114, 178],
        [213, 94, 0],
        [204, 121, 167],
        [200, 200, 200],
    ];
    let [red, green, blue] = EIGHT[(number % 8) as usize];
    let quarters = 4 - number / 8 % 3;
    let darker = |part: u8| u8::try_from(u32::from(part) * quarters / 4).unwrap_or(part);
    [darker(red), darker(green), darker(blue), 255]
}

/// The colour of a fault, where it has a place on the surface.
#[must_use]
pub fn fault_colour(fault: Fault) -> Option<Colour> {
    Some(match fault {
        Fault::NonManifoldEdges | Fault::NonManifoldVertices => [204, 121, 167, 255],
        Fault::OneSidedComponents => [120, 60, 140, 255],
        Fault::InsideOutComponents | Fault::TurnedTriangles => [230, 159, 0, 255],
        Fault::SelfIntersections => [213, 94, 0, 255],
        Fault::OpenEnds => [0, 114, 178, 255],
        Fault::DuplicateTriangles | Fault::DegenerateTriangles | Fault::ZeroAreaTriangles => {
            [240, 228, 66, 255]
        }
        Fault::UnusableTriangles | Fault::DuplicateVertices | Fault::UnusedVertices => return None,
    })
}

/// Each triangle in the colour of its part.
#[must_use]
pub fn by_parts(report: &Report) -> Vec<Colour> {
    let parts = report.component_of_triangle.iter();
    parts
        .map(|&part| {
            if part == NONE {
                [0; 4]
            } else {
                part_colour(part)
            }
        })
        .collect()
}

/// Each triangle in the colour of the worst that is wrong with it.
#[must_use]
pub fn by_problems(mesh: &Mesh, report: &Report, intersections: &Intersections) -> Vec<Colour> {
    let mut colours = vec![[0; 4]; mesh.triangles.len()];
    let mut paint = |fault: Fault, triangles: &mut dyn Iterator<Item = u32>| {
        let Some(colour) = fault_colour(fault) else {
            return;
        };
        for triangle in triangles {
            if let Some(place) = colours.get_mut(triangle as usize) {
                *place = colour;
            }
        }
    };
    let numbered = || (0_u32..).zip(&mesh.triangles);
    // Joined vertices stand for each other by the smallest of their number.
    let joined = joined(mesh, report);
    let same = |vertex: u32| joined.get(vertex as usize).copied().unwrap_or(vertex);
    let having = |marked: &[bool], least: usize| {
        let is = |vertex: &&u32| {
            marked
                .get(same(**vertex) as usize)
                .copied()
                .unwrap_or(false)
        };
        numbered()
            .filter(|(_, corners)| corners.iter().filter(is).count() >= least)
            .map(|(triangle, _)| triangle)
            .collect::<Vec<_>>()
    };
    let marked = |vertices: &mut dyn Iterator<Item = u32>| {
        let mut marks = vec![false; mesh.positions.len()];
        for vertex in vertices {
            if let Some(mark) = marks.get_mut(vertex as usize) {
                *mark = true;
            }
        }
        marks
    };
    let of_components = |is: fn(&super::report::Component) -> bool| {
        let parts = (0_u32..).zip(&report.component_of_triangle);
        parts.filter(move |&(_, &part)| report.components.get(part as usize).is_some_and(is))
    };

    // The mildest first: what comes later covers it.
    paint(
        Fault::ZeroAreaTriangles,
        &mut report.zero_area_triangles.iter().copied(),
    );
    paint(
        Fault::DegenerateTriangles,
        &mut report.degenerate_triangles.iter().copied(),
    );
    paint(
        Fault::DuplicateTriangles,
        &mut report.duplicate_triangles.iter().copied(),
    );
    let ends = marked(&mut report.loop_vertices.iter().copied());
    paint(Fault::OpenEnds, &mut having(&ends, 1).into_iter());
    let pairs = intersections.pairs.iter().flatten();
    paint(Fault::SelfIntersections, &mut pairs.copied());
    paint(
        Fault::TurnedTriangles,
        &mut report.turned_triangles.iter().copied(),
    );
    let inside_out = of_components(super::report::Component::is_inside_out);
    paint(
        Fault::InsideOutComponents,
        &mut inside_out.map(|(triangle, _)| triangle),
    );
    let one_sided = of_components(|part| !part.orientable);
    paint(
        Fault::OneSidedComponents,
        &mut one_sided.map(|(triangle, _)| triangle),
    );
    let vertices = marked(&mut report.non_manifold_vertices.iter().copied());
    paint(
        Fault::NonManifoldVertices,
        &mut having(&vertices, 1).into_iter(),
    );
    let edges = marked(&mut report.non_manifold_edges.iter().flatten().copied());
    paint(Fault::NonManifoldEdges, &mut having(&edges, 2).into_iter());
    colours
}

/// The colours that numbers have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// From dark blue over green to yellow, equally far apart for the eye and for all kinds of colour vision: Smith and van der Walt's viridis.
    Rising,
    /// From blue over white, which is zero, to red: Moreland 2009, "Diverging Color Maps for Scientific Visualization".
    AboutZero,
}

/// Where there is no number.
const NO_NUMBER: Colour = [128, 128, 128, 255];

impl Ramp {
    /// The colour of a part of the way from the scale's low end to its high one, 0 to 1; what lies outside has that of the end.
    #[must_use]
    pub fn colour(self, part: f32) -> Colour {
        const RISING: [[u8; 3]; 9] = [
            [68, 1, 84],
            [71, 44, 122],
            [59, 81, 139],
            [44, 113, 142],
            [33, 144, 141],
            [39, 173, 129],
            [92, 200, 99],
            [170, 220, 50],
            [253, 231, 37],
        ];
        const ABOUT_ZERO: [[u8; 3]; 3] = [[59, 76, 192], [221, 221, 221], [180, 4, 38]];
        let stops: &[[u8; 3]] = match self {
            Self::Rising => &RISING,
            Self::AboutZero => &ABOUT_ZERO,
        };
        if part.is_nan() {
            return NO_NUMBER;
        }
        let steps = stops.len() - 1;
        #[allow(clippy::cast_precision_loss, reason = "a handful of stops")]
        let along = part.clamp(0.0, 1.0) * steps as f32;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the stops"
        )]
        let below = (along as usize).min(steps - 1);
        #[allow(clippy::cast_precision_loss, reason = "a handful of stops")]
        let part = along - below as f32;
        let mixed = [0, 1, 2].map(|channel| {
            let [one, other] = [stops[below][channel], stops[below + 1][channel]].map(f32::from);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between two bytes"
            )]
            let byte = (one + (other - one) * part).round() as u8;
            byte
        });
        [mixed[0], mixed[1], mixed[2], 255]
    }

    /// The numbers between which the scale runs: all but the two smallest and largest of a hundred, so that a few wild ones do not decide; about
    /// zero as far up as down. None where there is no number.
    #[must_use]
    pub fn range(self, values: &[f32]) -> Option<[f32; 2]> {
        let about_zero = self == Self::AboutZero;
        let size = |value: &f32| if about_zero { value.abs() } else { *value };
        let mut known: Vec<f32> = values
            .iter()
            .map(size)
            .filter(|value| value.is_finite())
            .collect();
        let last = known.len().checked_sub(1)?;
        let mut of = |hundredth: usize| {
            let (_, value, _) =
                known.select_nth_unstable_by(last * hundredth / 100, f32::total_cmp);
            *value
        };
        let (low, high) = (of(2), of(98));
        Some(if about_zero {
            [-high, high]
        } else {
            [low, high]
        })
    }
}

/// Each number in its colour.
#[must_use]
pub fn by_numbers(values: &[f32], scale: Ramp, [low, high]: [f32; 2]) -> Vec<Colour> {
    let width = (high - low).max(f32::MIN_POSITIVE);
    let colours = values.iter();
    colours
        .map(|value| scale.colour((value - low) / width))
        .collect()
}

/// The vertex that the report takes for each.
fn joined(mesh: &Mesh, report: &Report) -> Vec<u32> {
    if report.duplicate_vertices.is_empty() {
        return (0..).take(mesh.positions.len()).collect();
    }
    let used = vec![true; mesh.positions.len()];
    super::report::representatives(&mesh.positions, &used)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::AtomicBool;

    use glam::Vec3;

    use super::*;
    use crate::mesh::intersect::{IntersectParams, intersections};
    use crate::mesh::made;
    use crate::mesh::report::{ReportParams, report};

    /// How many triangles have the colour of each fault.
    fn counted(mesh: &Mesh, faults: &[Fault]) -> Vec<usize> {
        let never = AtomicBool::new(false);
        let report = report(mesh, &ReportParams::default(), &never, &mut |_, _| ()).unwrap();
        let found = intersections(mesh, &IntersectParams::default(), &never, &mut |_, _| ());
        let colours = by_problems(mesh, &report, &found.unwrap());
        let count = |fault: &Fault| {
            let colour = fault_colour(*fault).unwrap();
            colours.iter().filter(|&&own| own == colour).count()
        };
        faults.iter().map(count).collect()
    }

    #[test]
    fn what_is_wrong_has_its_colour_and_what_is_right_has_none() {
        use Fault::*;
        let faults = [
            OpenEnds,
            SelfIntersections,
            TurnedTriangles,
            NonManifoldEdges,
        ];
        // A ball is as it should be.
        assert_eq!(counted(&made::sphere(2), &faults), [0, 0, 0, 0]);
        // Each open end of a tube of 6 has 6 edges; one of two triangles has two vertices there, and each other one: 18 of both ends.
        let tube = made::tube(6, 5);
        let found = counted(&tube, &faults);
        let ends = found[0];
        assert!(
            ends > 20 && ends < tube.triangles.len() && found[1..] == [0, 0, 0],
            "{found:?}"
        );
        // The same as a file without connectivity has it.
        assert_eq!(counted(&made::soup(&tube), &faults)[0], ends);
        let turned = made::turned(made::sphere(2), |triangle| triangle == 3);
        assert_eq!(counted(&turned, &faults), [0, 0, 1, 0]);
        let ball = made::sphere(2);
        let crossing = made::both(&ball, &made::placed(ball.clone(), 1.0, Vec3::X));
        assert!(counted(&crossing, &faults)[1] > 4);
        // Three pages of two triangles share the edge.
        assert!(counted(&made::book(), &faults)[3] >= 3);
    }

    #[test]
    fn numbers_have_the_colours_of_their_scale() {
        let [low, high] = Ramp::Rising.range(&[f32::NAN, 3.0, 1.0, 2.0]).unwrap();
        assert_eq!([low, high], [1.0, 2.0], "of three the largest is wild");
        let colours = by_numbers(
            &[1.0, 1.5, 2.0, 9.0, -9.0, f32::NAN],
            Ramp::Rising,
            [low, high],
        );
        assert_eq!(colours[0], [68, 1, 84, 255]);
        assert_eq!(colours[1], [33, 144, 141, 255]);
        assert_eq!([colours[2], colours[4]], [[253, 231, 37, 255], colours[0]]);
        assert_eq!([colours[3], colours[5]], [colours[2], NO_NUMBER]);
        let range = Ramp::AboutZero.range(&[-4.0, 1.0, 0.5, -4.0]).unwrap();
        assert_eq!(range, [-4.0, 4.0]);
        assert_eq!(
            by_numbers(&[0.0], Ramp::AboutZero, range),
            [[221, 221, 221, 255]]
        );
        // All the same: one colour, and no division by nothing.
        assert_eq!(by_numbers(&[2.0], Ramp::Rising, [2.0, 2.0]), [colours[0]]);
        assert_eq!(Ramp::Rising.range(&[f32::NAN, f32::INFINITY]), None);
        // Brighter and brighter, so that it can be read without colour.
        let light = |part: f32| {
            let [red, green, blue, _] = Ramp::Rising.colour(part).map(f32::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let lights: Vec<f32> = (0..=100_u8)
            .map(|part| light(f32::from(part) / 100.0))
            .collect();
        assert!(lights.windows(2).all(|pair| pair[1] > pair[0]));
    }

    #[test]
    fn parts_have_colours_of_their_own() {
        let ball = made::sphere(2);
        let far = made::both(&ball, &made::placed(ball.clone(), 0.5, Vec3::X * 9.0));
        let never = AtomicBool::new(false);
        let report = report(&far, &ReportParams::default(), &never, &mut |_, _| ()).unwrap();
        let colours = by_parts(&report);
        let half = ball.triangles.len();
        assert!(
            colours[..half]
                .iter()
                .all(|&colour| colour == part_colour(0))
        );
        assert!(
            colours[half..]
                .iter()
                .all(|&colour| colour == part_colour(1))
        );
        let first: std::collections::HashSet<_> = (0..24).map(part_colour).collect();
        assert_eq!(first.len(), 24);
    }
}
