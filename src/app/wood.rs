//! A planted grove as it is written: the tree on the platform and the planted ones, each individual once with all its places.
//!
//! Files count from the foot of the tree on the platform, so that it stands at zero, and what is planted around it as on the stage.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use anyhow::{Result, anyhow, ensure};
use glam::Vec3;
use rayon::prelude::*;

use super::individuals::planted;
use crate::sketch::{self, Grown};
use crate::tree::export::{ExportParams, Extras, Individual, Place, Stand};
use crate::tree::foliage::Season;
use crate::tree::{Drawing, Organs, Tree};
use crate::world::document::Document;
use crate::world::grove::{Kind, Plant};
use crate::world::stage::StageParams;

/// Bytes that all its individuals may take in memory, before there is any surface.
const BYTES_MOST: u64 = 2 << 30;

/// An individual and where it stands.
#[derive(Clone, Debug)]
pub struct Standing {
    /// As it grew.
    pub drawing: Drawing,
    /// At least one.
    pub places: Vec<Place>,
}

/// What is to be grown: an individual of a kind, or the tree on the platform itself.
struct Wanted {
    kind: Kind,
    individual: Option<u8>,
    places: Vec<Place>,
}

/// Grows a project's tree and everything that is planted around it, in another season where one is said.
///
/// # Errors
/// What cannot be grown, or that it is too much for one file.
pub fn grown(document: &Document, season: Option<Season>) -> Result<Vec<Standing>> {
    let bytes = AtomicU64::new(0);
    let grow = |wanted: Wanted| {
        let drawing = drawing(&wanted)?;
        let own = bytes_of(&drawing);
        // As soon as it is known: each may be large.
        let before = bytes.fetch_add(own, Ordering::Relaxed);
        ensure!(
            before.saturating_add(own) <= BYTES_MOST,
            "the planted trees are too large for one file: uproot those of some kinds, or step them back"
        );
        let places = wanted.places;
        Ok(Standing { drawing, places })
    };
    let wanted = wanted(document, season);
    wanted.into_par_iter().map(grow).collect()
}

/// All of them as they stand in a file, where each has been made as coarse as it is to be.
#[must_use]
pub fn stand<'a>(
    name: &str,
    trees: impl Iterator<Item = (&'a Tree, &'a Organs, u32, &'a [Place])>,
    extras: Extras,
) -> Stand<'a> {
    let individual = |(tree, organs, sides, places): (_, _, _, &[Place])| Individual {
        places: places.to_vec(),
        tree,
        organs,
        params: ExportParams { sides },
    };
    Stand {
        name: name.to_owned(),
        is_grove: true,
        trees: trees.map(individual).collect(),
        extras,
    }
}

/// What is planted as the tree on the platform, whatever kind that is.
fn living(document: &Document) -> Kind {
    Kind {
        sketch: Arc::clone(&document.sketch),
        step: document.step,
    }
}

fn has_grown(kind: &Kind) -> bool {
    kind.step > 0 && !kind.sketch.is_empty()
}

/// How many of the planted trees are at a step, or of a sketch, at which there is nothing of them.
#[must_use]
pub fn ungrown(document: &Document) -> usize {
    let living = living(document);
    let kinds = document.grove.plants.iter();
    let kinds = kinds.filter_map(|plant| document.grove.kind_of(plant, &living));
    kinds.filter(|kind| !has_grown(kind)).count()
}

fn wanted(document: &Document, season: Option<Season>) -> Vec<Wanted> {
    let in_season = |kind: &Kind| match season {
        None => kind.clone(),
        Some(season) => Kind {
            sketch: kind.sketch.in_season(season).into(),
            step: kind.step,
        },
    };
    let living = living(document);
    let mut all = Vec::new();
    if has_grown(&living) {
        all.push(Wanted {
            kind: in_season(&living),
            individual: None,
            places: vec![Place::at("tree-1".to_owned(), Vec3::ZERO)],
        });
    }
    let mut known: Vec<(Option<u8>, u8, usize)> = Vec::new();
    for (number, plant) in (2_u32..).zip(&document.grove.plants) {
        let Some(kind) = document.grove.kind_of(plant, &living) else {
            continue;
        };
        if !has_grown(kind) {
            continue;
        }
        let is_known = |(of, individual, _): &&(Option<u8>, u8, usize)| {
            (*of, *individual) == (plant.kind, plant.individual)
        };
        let at = match known.iter().find(is_known) {
            Some((_, _, at)) => *at,
            None => {
                known.push((plant.kind, plant.individual, all.len()));
                all.push(Wanted {
                    kind: in_season(kind),
                    individual: Some(plant.individual),
                    places: Vec::new(),
                });
                all.len() - 1
            }
        };
        if let Some(wanted) = all.get_mut(at) {
            wanted.places.push(place(number, plant));
        }
    }
    all
}

fn place(number: u32, plant: &Plant) -> Place {
    Place {
        name: format!("tree-{number}"),
        at: plant.foot() - StageParams::default().tree,
        yaw_deg: plant.yaw_deg,
        size: plant.size,
    }
}

fn drawing(wanted: &Wanted) -> Result<Drawing> {
    let Kind { sketch, step } = &wanted.kind;
    let never = AtomicBool::new(false);
    let made = match wanted.individual {
        Some(individual) => planted(sketch, *step, individual, &never),
        None => sketch::grow(sketch, *step, &never)
            .map(|Grown { tree, organs, .. }| Drawing { tree, organs }),
    };
    made.map_err(|error| anyhow!("the planted trees cannot grow: {error}"))
}

fn bytes_of(drawing: &Drawing) -> u64 {
    /// A node: parent, position, radius, letter, order, birth.
    const NODE: u64 = 4 + 12 + 4 + 2 + 2 + 4;
    NODE * drawing.tree.len() as u64 + drawing.organs.bytes()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use glam::Vec2;

    use super::*;
    use crate::world::document::Edit;
    use crate::world::species::SPECIES;

    #[test]
    fn each_individual_is_grown_once_and_stands_in_all_its_places() {
        let species = |name: &str| SPECIES.iter().find(|one| one.name == name).unwrap();
        let plant = |x: f32, individual: u8| Plant {
            at: Vec2::new(x, -6.0),
            yaw_deg: 30.0,
            size: 1.2,
            individual,
            kind: None,
        };
        let trees = vec![plant(3.0, 2), plant(6.0, 5), plant(9.0, 2)];
        let cactus = species("cactus").document();
        let planted = cactus.after(&Edit::Plant { trees }).unwrap();
        let mixed = planted.after(&species("fern").edit()).unwrap();
        let trees = vec![plant(-3.0, 2)];
        let mixed = mixed.after(&Edit::Plant { trees }).unwrap();
        let wood = grown(&mixed, None).unwrap();
        let names = |one: &Standing| -> Vec<String> {
            one.places.iter().map(|place| place.name.clone()).collect()
        };
        let all: Vec<_> = wood.iter().map(names).collect();
        assert_eq!(
            all,
            [
                vec!["tree-1"],
                vec!["tree-2", "tree-4"],
                vec!["tree-3"],
                vec!["tree-5"]
            ]
        );
        assert_eq!(wood[1].places[1].at, Vec3::new(9.0, 0.0, 0.0));
        assert_eq!(wood[0].places[0].at, Vec3::ZERO);
        assert_ne!(wood[1].drawing.tree.position, wood[2].drawing.tree.position);
        let winter = grown(&mixed, Some(Season::Winter)).unwrap();
        assert_eq!(winter.len(), 4);
        // At step 0 there is nothing of a tree.
        let nothing = planted.after(&Edit::SetStep { step: 0 }).unwrap();
        assert!(grown(&nothing, None).unwrap().is_empty());
    }
}
