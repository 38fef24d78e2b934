//! The trees that were planted on the stage: where each stands, and which individual of which tree it is.
//!
//! A planted tree is an individual of the tree on the platform: of its sketch, its laws, its season and its step, with a seed of its own. As long as that
//! tree is the one on the platform the planted ones change and grow with it, as instances do in programs for modelling. When another sketch takes its
//! place (a species, another project's sketch, the cleared platform), they stay what they were: their sketch becomes a [`Kind`] that the grove keeps, and
//! the brush goes on with the new tree. So a mixed wood is planted by choosing one species after the other.
//!
//! There are [`INDIVIDUALS`] of a tree and no more, each of which stands in many places, turned and a little larger or smaller: what a wood takes in memory
//! depends on its kinds and not on its trees. (Rejected: a seed a tree. Two hundred maples would be two hundred meshes, and nobody tells them from eight.)

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::document::EditError;
use crate::sketch::{Sketch, quantize};

/// Individuals of a tree that are planted.
pub const INDIVIDUALS: u8 = 8;
/// Planted trees at most.
pub const PLANTS_MOST: usize = 256;
/// Trees that a grove is of at most, with the one on the platform.
pub const KINDS_MOST: usize = 6;
/// Farthest place along an axis from the stage's middle, metres.
pub const FARTHEST: f32 = 200.0;
/// Smallest and largest size, in parts of the grown tree.
pub const SIZES: [f32; 2] = [0.1, 4.0];

/// A planted tree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// Where its foot is on the ground, metres: to the right of the stage's middle, and towards the person.
    pub at: Vec2,
    /// Turn about +Y, degrees, 0…360.
    pub yaw_deg: f64,
    /// Its size over that of the grown tree.
    pub size: f32,
    /// Which individual it is, 0 to [`INDIVIDUALS`] − 1.
    pub individual: u8,
    /// Which of [`Grove::kinds`] it is of; none: of the tree on the platform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<u8>,
}

impl Plant {
    /// The plant with every number on the grid.
    #[must_use]
    pub fn quantized(&self) -> Self {
        let at = quantize::point(Vec3::new(self.at.x, 0.0, self.at.y));
        Self {
            at: Vec2::new(at.x, at.z),
            yaw_deg: quantize::angle_deg(self.yaw_deg),
            size: quantize::coordinate(self.size),
            ..*self
        }
    }

    /// Its tree's own frame to the stage, metres: the foot on its place.
    #[must_use]
    pub fn stage_from_tree(&self) -> Affine3A {
        #[expect(clippy::cast_possible_truncation, reason = "poses are f32")]
        let yaw = self.yaw_deg.to_radians() as f32;
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(self.size),
            Quat::from_rotation_y(yaw),
            self.foot(),
        )
    }

    /// Its foot on the stage, metres.
    #[must_use]
    pub fn foot(&self) -> Vec3 {
        Vec3::new(self.at.x, 0.0, self.at.y)
    }

    /// # Errors
    /// Where a number is not finite or out of bounds.
    fn validate(&self, kinds: usize) -> Result<(), EditError> {
        let near = self.at.is_finite() && self.at.abs().max_element() <= FARTHEST;
        if !near {
            return Err(EditError::PlantPlace);
        }
        if !(0.0..=360.0).contains(&self.yaw_deg) {
            return Err(EditError::PlantTurn(self.yaw_deg));
        }
        let [least, most] = SIZES;
        let known = self.kind.is_none_or(|kind| usize::from(kind) < kinds);
        if !(least..=most).contains(&self.size) || self.individual >= INDIVIDUALS || !known {
            return Err(EditError::Plant);
        }
        Ok(())
    }
}

/// A tree that was on the platform when it was planted and is there no more.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// What grows.
    pub sketch: Arc<Sketch>,
    /// How far.
    pub step: u32,
}

/// All planted trees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grove {
    /// Trees that are no more on the platform; each has a plant.
    pub kinds: Vec<Kind>,
    /// In the order in which they were planted.
    pub plants: Vec<Plant>,
}

impl Grove {
    /// Whether nothing is planted.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.plants.is_empty()
    }

    /// Whether trees are planted that are of the one on the platform.
    #[must_use]
    pub fn is_living(&self) -> bool {
        self.plants.iter().any(|plant| plant.kind.is_none())
    }

    /// The tree that a plant is of, where `living` is the one on the platform.
    #[must_use]
    pub fn kind_of<'a>(&'a self, plant: &Plant, living: &'a Kind) -> Option<&'a Kind> {
        match plant.kind {
            None => Some(living),
            Some(kind) => self.kinds.get(usize::from(kind)),
        }
    }

    /// With more trees, which are of the one on the platform.
    ///
    /// # Errors
    /// A place or size out of bounds, or where the grove is full.
    pub fn with(&self, trees: &[Plant]) -> Result<Self, EditError> {
        self.has_room(trees.len())?;
        let mut next = self.clone();
        next.plants.extend(trees.iter().map(|tree| {
            Plant {
                kind: None,
                ..*tree
            }
            .quantized()
        }));
        next.validate()?;
        Ok(next)
    }

    /// # Errors
    /// Where so many more trees of the one on the platform have no room.
    pub fn has_room(&self, trees: usize) -> Result<(), EditError> {
        if self.plants.len() + trees > PLANTS_MOST {
            return Err(EditError::GroveFull);
        }
        if !self.is_living() && self.kinds.len() >= KINDS_MOST {
            return Err(EditError::GroveKinds);
        }
        Ok(())
    }

    /// Without the trees of these numbers; kinds that nothing is of any more go, too.
    ///
    /// # Errors
    /// Where one of them is not there.
    pub fn without(&self, trees: &[u32]) -> Result<Self, EditError> {
        let gone = |at: usize| trees.iter().any(|tree| *tree as usize == at);
        if trees.iter().any(|tree| *tree as usize >= self.plants.len()) {
            return Err(EditError::NoPlant);
        }
        let plants = self.plants.iter().enumerate();
        let plants = plants.filter(|(at, _)| !gone(*at)).map(|(_, plant)| *plant);
        let mut next = Self {
            kinds: self.kinds.clone(),
            plants: plants.collect(),
        };
        next.prune();
        Ok(next)
    }

    /// The grove when another tree takes the place of this one on the platform: what is of it stays as it is. Of a tree that has not grown there is nothing to
    /// keep, so its plants go on with the next one.
    #[must_use]
    pub fn kept(&self, sketch: &Arc<Sketch>, step: u32) -> Self {
        let mut next = self.clone();
        if !self.is_living() || sketch.is_empty() || step == 0 {
            return next;
        }
        let kind = Kind {
            sketch: Arc::clone(sketch),
            step,
        };
        let number = next.kinds.iter().position(|known| *known == kind);
        let number = number.unwrap_or_else(|| {
            next.kinds.push(kind);
            next.kinds.len() - 1
        });
        let living = next.plants.iter_mut().filter(|plant| plant.kind.is_none());
        living.for_each(|plant| plant.kind = u8::try_from(number).ok());
        next
    }

    /// Forgets the kinds that nothing is of.
    pub(super) fn prune(&mut self) {
        for number in (0..self.kinds.len()).rev() {
            let Ok(kind) = u8::try_from(number) else {
                continue;
            };
            if self.plants.iter().any(|plant| plant.kind == Some(kind)) {
                continue;
            }
            self.kinds.remove(number);
            let later = self
                .plants
                .iter_mut()
                .filter_map(|plant| plant.kind.as_mut());
            later.filter(|of| **of > kind).for_each(|of| *of -= 1);
        }
    }

    /// Checks everything, as a file from elsewhere needs it.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), EditError> {
        if self.plants.len() > PLANTS_MOST {
            return Err(EditError::GroveFull);
        }
        if self.kinds.len() + usize::from(self.is_living()) > KINDS_MOST {
            return Err(EditError::GroveKinds);
        }
        self.plants
            .iter()
            .try_for_each(|plant| plant.validate(self.kinds.len()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::sketch::NodeRef;

    fn plant(x: f32) -> Plant {
        Plant {
            at: Vec2::new(x, -8.0),
            yaw_deg: 90.0,
            size: 1.1,
            individual: 3,
            kind: None,
        }
    }

    fn sketch(height: f32) -> Arc<Sketch> {
        let drawn = Sketch::default().add_segment(NodeRef::ROOT, Vec3::Y * height);
        Arc::new(drawn.unwrap().0)
    }

    #[test]
    fn what_was_planted_stays_what_it_was_when_another_tree_comes() {
        let (oak, elm) = (sketch(0.3), sketch(0.4));
        let grove = Grove::default().with(&[plant(1.0), plant(2.0)]).unwrap();
        assert!(grove.is_living());
        let kept = grove.kept(&oak, 5);
        assert!(!kept.is_living());
        assert_eq!(kept.kinds.len(), 1);
        let mixed = kept.with(&[plant(3.0)]).unwrap().kept(&elm, 4);
        let kinds = |grove: &Grove| -> Vec<_> { grove.plants.iter().map(|one| one.kind).collect() };
        assert_eq!(kinds(&mixed), [Some(0), Some(0), Some(1)]);
        // The same tree again is the same kind.
        let again = mixed.with(&[plant(4.0)]).unwrap().kept(&oak, 5);
        assert_eq!(kinds(&again)[3], Some(0));
        // A kind goes with its last tree.
        let fewer = again.without(&[0, 1, 3]).unwrap();
        assert_eq!((fewer.kinds.len(), kinds(&fewer)), (1, vec![Some(0)]));
        assert_eq!(fewer.kinds[0].sketch, elm);
        // Of what has not grown nothing is kept.
        assert_eq!(grove.kept(&oak, 0), grove);
        assert_eq!(grove.kept(&Arc::default(), 5), grove);
    }

    #[test]
    fn a_full_grove_and_absurd_plants_are_refused() {
        let many = vec![plant(0.0); PLANTS_MOST];
        let full = Grove::default().with(&many).unwrap();
        let told = full.with(&[plant(0.0)]).unwrap_err().to_string();
        assert!(told.contains("256") && told.contains("uproot"), "{told}");
        let mut mixed = Grove::default();
        for number in 1..=6_u8 {
            let tree = sketch(f32::from(number) * 0.1);
            mixed = mixed.with(&[plant(1.0)]).unwrap().kept(&tree, 3);
        }
        assert_eq!(mixed.kinds.len(), KINDS_MOST);
        let told = mixed.with(&[plant(0.0)]).unwrap_err().to_string();
        assert!(told.contains("6 different trees"), "{told}");
        assert!(full.without(&[256]).is_err());
        for wrong in [
            Plant {
                at: Vec2::new(f32::NAN, 0.0),
                ..plant(0.0)
            },
            Plant {
                at: Vec2::new(0.0, 1e9),
                ..plant(0.0)
            },
            Plant {
                yaw_deg: f64::INFINITY,
                ..plant(0.0)
            },
            Plant {
                yaw_deg: -1.0,
                ..plant(0.0)
            },
            Plant {
                size: 0.0,
                ..plant(0.0)
            },
            Plant {
                size: 40.0,
                ..plant(0.0)
            },
            Plant {
                individual: 8,
                ..plant(0.0)
            },
        ] {
            assert!(Grove::default().with(&[wrong]).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn a_foot_stands_on_its_place_and_what_is_turned_is_turned() {
        let on_stage = plant(2.0).stage_from_tree();
        assert!(
            on_stage
                .transform_point3(Vec3::ZERO)
                .distance(Vec3::new(2.0, 0.0, -8.0))
                < 1e-6
        );
        let aside = on_stage.transform_point3(Vec3::X);
        assert!(aside.distance(Vec3::new(2.0, 0.0, -9.1)) < 1e-5, "{aside}");
    }
}
