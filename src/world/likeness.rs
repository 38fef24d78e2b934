//! Models that are no scans: trees that grow from an L-system's parameters, as an abstraction of a scan does.
//!
//! The project keeps the parameters and how far the tree has grown; the tree itself is made of them each time. So it can be stepped through, tried with
//! other seeds and other numbers, and undone, and needs no file.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use hashbrown::HashMap;
use serde::{Deserialize, Serialize};

use super::document::Edit;
use super::model::{Model, ModelError, SIDE_BOUNDS};
use super::scene::SurfaceLook;
use crate::abstraction::{AbstractionError, Grower, Params, blunt, steps};
use crate::lsystem::Limits;
use crate::tree::growth;
use crate::tree::{NO_PARENT, Tree};

/// What a tree may hold: more than a person could look at.
const LIMITS: Limits = Limits {
    modules: 2_000_000,
    bytes: 1 << 30,
};
/// What is derived to see when a tree ends: panels ask in every frame.
const SOON: Limits = Limits {
    modules: 4000,
    bytes: 1 << 24,
};
/// How far beside its model it stands, in the model's longest side.
const BESIDE: f32 = 1.1;

/// What a model grows from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Likeness {
    /// The L-system's numbers, its seed among them.
    pub params: Arc<Params>,
    /// How many iterations it has grown, a part of one too; none where it is whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment: Option<f64>,
}

impl Likeness {
    /// The whole tree of some parameters.
    #[must_use]
    pub fn whole(params: Params) -> Self {
        Self {
            params: Arc::new(params),
            moment: None,
        }
    }

    /// # Errors
    /// The name of the first number that is beyond its limits.
    pub(super) fn validate(&self) -> Result<(), ModelError> {
        self.params.check().map_err(|error| match error {
            AbstractionError::Parameter { name, .. } => ModelError::Likeness(name),
            _ => ModelError::Likeness("parameters"),
        })?;
        let most = f64::from(steps(&self.params));
        let fits = self
            .moment
            .is_none_or(|moment| (0.0..=most).contains(&moment));
        fits.then_some(()).ok_or(ModelError::Likeness("moment"))
    }

    /// The iteration after which nothing grows any more; of a large tree one after which that is as good as sure.
    #[must_use]
    pub fn last(&self) -> u32 {
        let most = steps(&self.params);
        if self.params.radial_increment != 0.0 {
            return most;
        }
        let (seed, never) = (self.params.seed, AtomicBool::new(false));
        let ends = Grower::new(&self.params).map(|mut grower| grower.ends(seed, &SOON, &never));
        ends.ok().flatten().unwrap_or(most)
    }

    /// The tree as far as it has grown: that of the iteration before, and what is new of this one by a part.
    ///
    /// # Errors
    /// A tree too large to be looked at, or `cancel` being set.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between nothing and some hundred iterations"
    )]
    pub fn tree(&self, cancel: &AtomicBool) -> Result<Tree, AbstractionError> {
        let mut grower = Grower::new(&self.params)?;
        let seed = self.params.seed;
        let Some(moment) = self.moment else {
            return grower.tree(seed, &LIMITS, cancel);
        };
        let newest = moment.ceil() as u32;
        let mut tree = grower.tree_at(newest, seed, &LIMITS, cancel)?;
        let part = (moment - moment.floor()) as f32;
        if part == 0.0 {
            return Ok(tree);
        }
        let before = grower.tree_at(newest - 1, seed, &LIMITS, cancel)?;
        let radii = date(&mut tree, &before, newest);
        Ok(growth::grown(&tree, &radii, newest, part))
    }

    /// The same as it is looked at: with blunt tips.
    ///
    /// # Errors
    /// As [`Self::tree`].
    pub fn shown(&self, cancel: &AtomicBool) -> Result<Tree, AbstractionError> {
        self.tree(cancel).map(|tree| blunt(&tree))
    }
}

/// Says of a tree's nodes which are not in that of the iteration before, and gives the radii that those which are had there. (Where radii grow with every
/// iteration the grammar makes all segments anew, and says nothing of which are new.)
fn date(tree: &mut Tree, before: &Tree, newest: u32) -> Vec<f32> {
    let place = |at: Vec3| at.to_array().map(f32::to_bits);
    let nodes = (0_u32..).zip(tree.parent.iter().zip(tree.position.iter()));
    let there: HashMap<(u32, [u32; 3]), u32> = nodes
        .map(|(node, (parent, at))| ((*parent, place(*at)), node))
        .collect();
    let mut radii = vec![0.0; tree.len()];
    let mut births = vec![newest; tree.len()];
    // Where each node of the tree before is now; parents stand before their children.
    let mut now = vec![NO_PARENT; before.len()];
    for node in 0..before.len() {
        let parent = match before.parent[node] {
            NO_PARENT => NO_PARENT,
            parent if now[parent as usize] == NO_PARENT => continue,
            parent => now[parent as usize],
        };
        if let Some(found) = there.get(&(parent, place(before.position[node]))) {
            now[node] = *found;
            radii[*found as usize] = before.radius[node];
            births[*found as usize] = 0;
        }
    }
    for (birth, dated) in tree.birth.iter_mut().zip(births) {
        *birth = dated;
    }
    radii
}

/// The longest side of the box around a tree's tubes.
#[must_use]
pub fn side(tree: &Tree) -> f32 {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (node, parent) in tree.parent.iter().enumerate() {
        if *parent == NO_PARENT {
            continue;
        }
        let ends = [*parent as usize, node].map(|end| tree.position[end]);
        let along = (ends[1] - ends[0]).normalize_or_zero();
        // A ring about the segment reaches so far along each axis.
        let across = (Vec3::ONE - along * along).max(Vec3::ZERO);
        let reach = tree.radius[node] * across.map(f32::sqrt);
        for end in ends {
            low = low.min(end - reach);
            high = high.max(end + reach);
        }
    }
    (high - low).max_element().max(0.0)
}

/// The edit that stands a tree of these parameters beside the model that it is like, as large as that is shown; `sides` are the longest sides of the
/// model and of the tree in the model's unit. None where there is no such model.
#[must_use]
pub(super) fn beside(
    document: &super::document::Document,
    at: usize,
    params: Params,
    sides: [f32; 2],
) -> Option<Edit> {
    let mut models = document.models.to_vec();
    let of = models.get(at)?.clone();
    let mut model = Model::new(of.file.clone(), of.unit, false, models.len());
    let [least, most] = SIDE_BOUNDS;
    let times = sides[1] / sides[0].max(f32::MIN_POSITIVE);
    model.place = of.place;
    model.place.scale = (of.place.scale * times).clamp(least, most);
    let apart = BESIDE * f32::midpoint(of.place.scale, model.place.scale);
    // Towards the middle of the room, where people look.
    let aside = if of.place.position.x > 0.0 {
        -apart
    } else {
        apart
    };
    model.place.position.x += aside;
    model.surface = Some(SurfaceLook::default());
    model.likeness = Some(Likeness::whole(params));
    models.push(model);
    Some(Edit::Arrange {
        models,
        platform: document.platform,
        linked: document.linked,
    })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn likeness(moment: Option<f64>) -> Likeness {
        let params = Params {
            bifurcation_probability: 0.8,
            seed: 5,
            ..Params::default()
        };
        Likeness {
            params: Arc::new(params),
            moment,
        }
    }

    fn length(tree: &Tree) -> f32 {
        let nodes = 1..tree.len();
        let of = |node: usize| {
            let from = tree.position[tree.parent[node] as usize];
            tree.position[node].distance(from)
        };
        nodes.map(of).sum()
    }

    #[test]
    fn it_grows_step_by_step_and_evenly_between_steps() {
        let never = AtomicBool::new(false);
        let at = |moment: f64| likeness(Some(moment)).tree(&never).unwrap();
        let whole = likeness(None).tree(&never).unwrap();
        let last = likeness(None).last();
        assert_eq!(at(f64::from(last)), whole);
        let mut before = 0.0;
        for step in 0..last {
            let [from, half, to] = [0.0, 0.5, 1.0].map(|part| length(&at(f64::from(step) + part)));
            assert!(
                (half - f32::midpoint(from, to)).abs() < 1e-4,
                "{step}: {from} {half} {to}"
            );
            assert!(from >= before && to >= from, "{step}");
            before = from;
        }
        assert!(before > 2.0 * length(&at(0.0)), "it grew");
    }

    #[test]
    fn numbers_beyond_their_limits_are_refused() {
        assert_eq!(likeness(None).validate(), Ok(()));
        for moment in [-1.0, 1e9, f64::NAN] {
            assert_eq!(
                likeness(Some(moment)).validate(),
                Err(ModelError::Likeness("moment"))
            );
        }
        let mut wrong = likeness(None);
        Arc::make_mut(&mut wrong.params).iterations = 51.0;
        assert_eq!(wrong.validate(), Err(ModelError::Likeness("iterations")));
    }
}
