//! Individuals of a sketch: what previews show, what the brush plants, and what files hold of a planted grove.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::mesh::Mesh;
use crate::mesh::display::Display;
use crate::sketch::{self, Grown, Sketch, SketchError};
use crate::tree::Drawing;
use crate::tree::detail::{coarser, size, triangles_of};
use crate::tree::export::painted::{PaintedMesh, painted};
use crate::tree::organs::Placed;
use crate::tree::vary::{Spread, varied};

/// Triangles of a planted tree's mesh: eight of a kind are some dozen megabytes, and a frame shows fewer of what is far away.
const TRIANGLES: u64 = 60_000;
/// Corners of its rings.
const SIDES: u32 = 4;
/// What its surface may be off by at first, in parts of the tree's size, and by how much more each time that it has too many triangles: all leaves of the
/// species stay with the first.
const WITHIN: [f32; 2] = [0.003, 1.6];
/// How often it is made coarser at most: a branch as long as the tree goes then.
const TIMES: u32 = 14;
/// What has more triangles than this is heavy, such as fruit: of these there are fewer before anything else is coarser.
const HEAVY: usize = 16;

/// The individual of a seed, as the sketch would be with that.
///
/// # Errors
/// Where it cannot be grown, or `cancel` was set meanwhile.
pub fn of_seed(
    sketch: &Sketch,
    step: u32,
    seed: u32,
    cancel: &AtomicBool,
) -> Result<Drawing, SketchError> {
    let Grown { tree, organs, .. } = sketch::grow(&sketch.with_seed(seed), step, cancel)?;
    Ok(Drawing { tree, organs })
}

/// A planted individual, by its number from 0. Its seed is that number and one more whatever the sketch's own is, so that a grove stays as it is when another
/// individual is chosen for the platform. Where no law draws by the seed, its branches are turned and as long a little otherwise, as those of
/// `ramus export --count` are.
///
/// # Errors
/// As [`of_seed`].
pub fn planted(
    sketch: &Sketch,
    step: u32,
    individual: u8,
    cancel: &AtomicBool,
) -> Result<Drawing, SketchError> {
    let seed = u32::from(individual) + 1;
    let drawing = of_seed(sketch, step, seed, cancel)?;
    Ok(match sketch.habit.has_chance() {
        true => drawing,
        false => varied(&drawing, u64::from(seed), Spread::USUAL),
    })
}

/// A planted individual as it stands on the stage.
///
/// # Errors
/// A sentence that says why there is nothing to stand there, or that it was cancelled.
pub(super) fn standing(
    sketch: &Sketch,
    step: u32,
    individual: u8,
    cancel: &AtomicBool,
) -> Result<Arc<Display>, String> {
    let wrong = |why: &dyn std::fmt::Display| format!("The planted trees cannot grow: {why}.");
    let drawing = planted(sketch, step, individual, cancel).map_err(|error| wrong(&error))?;
    let coarse = light(&drawing, cancel).ok_or_else(|| wrong(&"it was cancelled"))?;
    let PaintedMesh {
        positions,
        triangles,
        colours,
    } = painted(&coarse, SIDES).map_err(|error| wrong(&error))?;
    let mesh = Mesh {
        positions,
        triangles,
        ..Mesh::default()
    };
    let display = Display::new(Arc::new(mesh), None, cancel);
    let display = display.ok_or_else(|| wrong(&"it was cancelled"))?;
    Ok(Arc::new(display.painted(colours)))
}

/// The drawing with no more triangles than a planted tree has, or as few as there can be. `None` when somebody asked to stop.
fn light(drawing: &Drawing, cancel: &AtomicBool) -> Option<Drawing> {
    let [first, more] = WITHIN;
    let mut within = first * size(&drawing.tree);
    let mut coarse = fewer(coarser(drawing, within));
    for _ in 0..TIMES {
        if triangles_of(&coarse, SIDES) <= TRIANGLES {
            break;
        }
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        within *= more;
        coarse = fewer(coarser(drawing, within));
    }
    Some(coarse)
}

/// The drawing without as many of its heavy organs as are too many, evenly of all.
fn fewer(mut drawing: Drawing) -> Drawing {
    let excess = triangles_of(&drawing, SIDES).saturating_sub(TRIANGLES);
    if excess == 0 {
        return drawing;
    }
    let organs = &mut drawing.organs;
    let triangles: Vec<usize> = organs
        .surfaces
        .iter()
        .map(|one| one.indices.len() / 3)
        .collect();
    let of = |placed: &Placed| {
        triangles
            .get(usize::from(placed.surface))
            .copied()
            .unwrap_or(0)
    };
    let heavy = |placed: &&Placed| of(placed) > HEAVY;
    let all: usize = organs.placed.iter().filter(heavy).map(of).sum();
    let all = all as u64;
    let stay = all.saturating_sub(excess);
    // Each owes its share of those that stay.
    let mut owed = 0;
    organs.placed.retain(|placed| {
        if of(placed) <= HEAVY {
            return true;
        }
        owed += stay;
        let stays = owed >= all;
        owed -= if stays { all } else { 0 };
        stays
    });
    drawing
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::sketch::{Habit, Letter, NodeRef};
    use crate::world::species::SPECIES;
    use glam::Vec3;

    #[test]
    fn individuals_differ_with_laws_and_without_and_do_not_hang_on_the_sketchs_own_seed() {
        let never = AtomicBool::new(false);
        let up = [Vec3::Y * 0.2, Vec3::Y * 0.4];
        let (plain, _) = Sketch::default().add_segments(NodeRef::ROOT, &up).unwrap();
        let at = NodeRef::new(Letter::TRUNK, 1);
        let (plain, _) = plain.add_segments(at, &[Vec3::new(0.2, 0.4, 0.0)]).unwrap();
        let fern = SPECIES.iter().find(|one| one.name == "fern").unwrap();
        let fern = fern.document();
        // A law that ends lines draws nothing.
        let ends = Habit {
            length: 3.0,
            ..Habit::default()
        };
        let ended = plain.with_habit(ends).unwrap();
        for (sketch, step) in [(&plain, 4), (&ended, 4), (&*fern.sketch, fern.step)] {
            let of = |sketch: &Sketch, number| planted(sketch, step, number, &never).unwrap();
            assert_eq!(of(sketch, 3), of(&sketch.with_seed(77), 3));
            assert_ne!(of(sketch, 3).tree.position, of(sketch, 4).tree.position);
        }
    }

    #[test]
    fn species_stand_with_bark_and_leaves_and_few_triangles() {
        let never = AtomicBool::new(false);
        for species in &SPECIES {
            let name = species.name;
            let document = species.document();
            let display = standing(&document.sketch, document.step, 0, &never).unwrap();
            let triangles = display.mesh.triangles.len();
            assert!((1000..=60_000).contains(&triangles), "{name}: {triangles}");
            assert_eq!(display.vertex_colours.len(), display.mesh.positions.len());
            // It is as high as what has grown.
            let grown = planted(&document.sketch, document.step, 0, &never).unwrap();
            let (low, high) = grown.bounds().unwrap();
            let off = (display.high.y - high.y)
                .abs()
                .max((display.low.y - low.y).abs());
            assert!(off < 0.1 * (high.y - low.y), "{name}: {off} m");
        }
        let cancelled = AtomicBool::new(true);
        let document = SPECIES[0].document();
        assert!(standing(&document.sketch, document.step, 0, &cancelled).is_err());
        assert!(standing(&Sketch::default(), 3, 0, &never).is_err());
    }
}
