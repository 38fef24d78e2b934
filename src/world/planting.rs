//! The brush that plants: the trigger plants trees where a hand points at the ground or touches the platform, the grip takes them away.
//!
//! The ground is met by the hand's ray, or in miniature on the platform's top, which stands for the ground around the full-size tree as the sketch stands for
//! that tree. The trigger plants one there at once; while it stays pulled, further ones follow the hand, never nearer to another than
//! the spacing. The grip, and the eraser's trigger, uproot what the hand points at and then what it passes. All that a hand does between two edges is *one*
//! edit, made when it lets go; until then [`Tools::shown`] has it. As with strokes, what was planted before a hand or the focus was lost is kept.
//!
//! How a tree is turned, how large it is and which individual it is, its place and its number draw (SplitMix64), never the time: the same session plants the same
//! grove.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{
    at_hand::OnGround,
    document::{Document, Edit, EditError},
    grove::{FARTHEST, Grove, INDIVIDUALS, Plant},
    history::History,
    hover::Pointer,
    scene::{Ball, Color, Rod, Scene},
    settings::DrawTool,
    stage::{Palette, StageParams, faded},
    tools::{Hold, Hover, Tools, pointer},
};
use crate::tree::draws::Draws;

/// How planting acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantParams {
    /// How far rays reach the ground, metres: farther away a hand cannot aim.
    pub reach: f32,
    /// A tip within this of the ground touches it, metres.
    pub touch: f32,
    /// Angle by which a ray may miss a trunk, radians.
    pub tolerance: f32,
    /// The eraser takes what is as near as this to its way, metres.
    pub uproot: f32,
    /// Height up to which a trunk can be aimed at, metres: the same whatever has grown by then, so that a session that is played again uproots the same.
    pub trunk: f32,
    /// Height of a tree that has not grown yet, metres.
    pub sapling: f32,
    /// Most trees that one frame plants in one hand: more than a hand can pass.
    pub at_once: usize,
}

impl Default for PlantParams {
    fn default() -> Self {
        Self {
            reach: 60.0,
            touch: 0.05,
            tolerance: 1.5_f32.to_radians(),
            uproot: 0.5,
            trunk: 2.0,
            sapling: 0.6,
            at_once: 32,
        }
    }
}

/// What a hand plants or uproots, from the pull to letting go.
#[derive(Clone, Debug, Default)]
pub(super) struct Brush {
    planted: Vec<Plant>,
    /// Numbers in the committed grove.
    uprooted: Vec<u32>,
    /// Where the hand was on the ground in the last frame.
    last: Option<Vec2>,
}

/// Sides of the ring on the ground.
const RING: u8 = 32;
/// Thickness of the ring: metres, and metres for each metre of distance.
const RING_RADIUS: [f32; 2] = [0.002, 0.0025];
/// Where the crown of a tree in miniature is, and its radius, in parts of the height.
const CROWN: [f32; 2] = [0.68, 0.3];
/// Thickness of a trunk in miniature, metres.
const TRUNK: f32 = 0.0016;

impl Tools {
    fn plants(&self) -> bool {
        self.params.settings.tool == DrawTool::Plant
    }

    /// Stage metres of the full-size tree in a metre of the platform.
    fn ground_from_miniature(&self) -> f32 {
        self.shown.sketch.scale / self.shown.platform.scale
    }

    /// The ground that a place on the platform stands for.
    fn under_miniature(&self, on_platform: Vec3) -> Vec2 {
        let in_sketch = self
            .miniature
            .sketch_from_stage
            .transform_point3(on_platform);
        let at = self.stage.tree + in_sketch * self.shown.sketch.scale;
        Vec2::new(at.x, at.z)
    }

    /// Where on the platform a place on the ground is, if that is on it.
    fn on_platform(&self, ground: Vec2) -> Option<Vec3> {
        let away = Vec3::new(ground.x, 0.0, ground.y) - self.stage.tree;
        let away = Vec3::new(away.x, 0.0, away.z) / self.shown.sketch.scale;
        let place = self.miniature.stage_from_sketch.transform_point3(away);
        let top = self.shown.platform.position;
        (place.distance(top) <= self.stage.platform_radius).then_some(place)
    }

    /// The ground that something that points is at, on the platform or around.
    fn ground_at(&self, pointer: &Pointer) -> Option<OnGround> {
        let spot = |at: Vec2, along: f32, in_miniature: bool| OnGround {
            at,
            along,
            plant: None,
            in_miniature,
        };
        let top = self.shown.platform.position;
        let on_top = |place: Vec3| {
            let aside = place - top;
            aside.x.hypot(aside.z) <= self.stage.platform_radius
        };
        let touched = (pointer.tip.y - top.y).abs() <= self.params.hover.touch;
        let found = if touched && on_top(pointer.tip) {
            spot(self.under_miniature(pointer.tip), 0.0, true)
        } else if let Some((place, along)) = level(pointer, top.y, self.params.hover.reach)
            && on_top(place)
        {
            spot(self.under_miniature(place), along, true)
        } else if pointer.tip.y <= self.params.plant.touch {
            // Below it, too: on the desktop a drag's tip sinks there, and means the ground on its ray.
            let foot = level(pointer, 0.0, self.params.plant.reach);
            let foot = foot.map_or(pointer.tip, |(foot, _)| foot);
            spot(Vec2::new(foot.x, foot.z), 0.0, false)
        } else {
            let (foot, along) = level(pointer, 0.0, self.params.plant.reach)?;
            spot(Vec2::new(foot.x, foot.z), along, false)
        };
        (found.at.abs().max_element() <= FARTHEST).then_some(found)
    }

    /// The planted tree that something points at: the nearest whose trunk the ray meets, or the one in miniature.
    fn plant_at(&self, pointer: &Pointer, ground: Option<&OnGround>) -> Option<(usize, f32)> {
        let plants = self.shown.grove.plants.iter().enumerate();
        if let Some(on) = ground.filter(|on| on.in_miniature) {
            let reach = self.params.hover.touch * self.ground_from_miniature();
            let near = plants.map(|(at, plant)| (at, plant.at.distance(on.at)));
            let near = near.filter(|(_, away)| *away <= reach);
            let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
            return Some((nearest.0, on.along));
        }
        let spread = self.params.plant.tolerance.tan();
        let met = plants.filter_map(|(at, plant)| {
            let height = self.trunk_of(plant);
            let (along, aside) = apart(pointer, plant.foot(), height)?;
            let near = along <= self.params.plant.reach && aside <= 0.03 * height + along * spread;
            near.then_some((at, along))
        });
        met.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How high a planted tree's trunk can be aimed at, metres.
    fn trunk_of(&self, plant: &Plant) -> f32 {
        self.params.plant.trunk * plant.size
    }

    /// How high a planted tree is drawn, metres.
    fn height_of(&self, plant: &Plant) -> f32 {
        let display = self.planted.display(plant);
        let height = display.map_or(self.params.plant.sapling, |(display, _)| display.high.y);
        height.max(self.params.plant.touch) * plant.size
    }

    /// What a hand means on the ground with the tool that it has, if that works there and nothing is nearer than `before`.
    pub(super) fn ground_meant(&self, pointer: &Pointer, before: Option<f32>) -> Option<OnGround> {
        let tool = self.params.settings.tool;
        let uproots = tool == DrawTool::Erase && !self.shown.grove.is_empty();
        if !self.plants() && !uproots {
            return None;
        }
        let ground = self.ground_at(pointer);
        let plant = self.plant_at(pointer, ground.as_ref());
        let found = match (ground, plant) {
            (Some(ground), plant) => OnGround {
                plant: plant.map(|(at, _)| at),
                ..ground
            },
            // Above the horizon there is a crown to point at, and no ground.
            (None, Some((at, along))) => OnGround {
                at: self.shown.grove.plants.get(at)?.at,
                along,
                plant: Some(at),
                in_miniature: false,
            },
            (None, None) => return None,
        };
        let wanted = self.plants() || found.plant.is_some();
        (wanted && before.is_none_or(|before| found.along < before)).then_some(found)
    }

    /// The trigger on the ground: it plants, or with the eraser uproots.
    pub(super) fn use_ground(&mut self, hand: usize, on: OnGround, history: &mut History) {
        if !self.plants() {
            return self.begin_uprooting(hand, on);
        }
        let committed = history.committed();
        let refused = if committed.step == 0 || committed.sketch.is_empty() {
            Err(EditError::NothingToPlant)
        } else {
            committed.grove.has_room(1)
        };
        if let Err(error) = refused {
            return self.refuse(hand, sentence(&error));
        }
        self.hands[hand].hold = Hold::Planting;
        self.brushes[hand] = Brush::default();
        self.plant(hand, on.at, committed);
        self.brushes[hand].last = Some(on.at);
        self.show(history);
    }

    /// The trigger of the brush where there is no ground.
    pub(super) fn miss_ground(&mut self, hand: usize) {
        self.refuse(
            hand,
            "Trees are planted on the ground: point at it, or touch the platform.".into(),
        );
    }

    /// Begins to take planted trees away, with the one that the hand points at.
    pub(super) fn begin_uprooting(&mut self, hand: usize, on: OnGround) {
        self.hands[hand].hold = Hold::Uprooting;
        self.brushes[hand] = Brush {
            last: Some(on.at),
            ..Brush::default()
        };
        if let Some(plant) = on.plant {
            self.uproot(hand, plant);
        }
    }

    fn uproot(&mut self, hand: usize, plant: usize) {
        let Ok(number) = u32::try_from(plant) else {
            return;
        };
        let known = |brush: &Brush| brush.uprooted.contains(&number);
        if !self.brushes.iter().any(known) {
            self.brushes[hand].uprooted.push(number);
            self.pulse(hand, self.params.haptics.delete);
        }
    }

    /// Puts a tree into the hand's brush.
    fn plant(&mut self, hand: usize, at: Vec2, committed: &Document) {
        let number = committed.grove.plants.len() + self.brushes[hand].planted.len();
        let vary = self.params.settings.plant_vary;
        let plant = individual_at(at, number, vary);
        self.brushes[hand].planted.push(plant);
        self.pulse(hand, self.params.haptics.create);
    }

    /// Lets the brushes of both hands follow them.
    pub(super) fn follow_brushes(&mut self, history: &History) {
        for hand in 0..self.hands.len() {
            let Some(sample) = self.hands[hand].sample else {
                continue;
            };
            let hold = self.hands[hand].hold;
            let Some(from) = self.brushes[hand].last else {
                continue;
            };
            let ground = match hold {
                Hold::Planting | Hold::Uprooting => self.ground_at(&pointer(&sample)),
                _ => None,
            };
            let Some(on) = ground else { continue };
            if hold == Hold::Planting {
                self.plant_along(hand, from, on.at, history);
            } else {
                self.uproot_along(hand, from, &on, history);
            }
        }
    }

    /// Plants on the way from one place to another, at the spacing.
    fn plant_along(&mut self, hand: usize, from: Vec2, to: Vec2, history: &History) {
        let committed = history.committed();
        let spacing = self.params.settings.plant_spacing;
        let mut last = from;
        for _ in 0..self.params.plant.at_once {
            let way = to - last;
            if way.length() < spacing {
                break;
            }
            last += way.normalize_or_zero() * spacing;
            let brush = &self.brushes[hand].planted;
            let mut others = committed.grove.plants.iter().chain(brush);
            // A little less, so that a row that a hand goes back over stays that row.
            if others.any(|other| other.at.distance(last) < 0.9 * spacing) {
                continue;
            }
            if committed.grove.has_room(brush.len() + 1).is_err() {
                self.brushes[hand].last = None;
                return self.refuse(hand, sentence(&EditError::GroveFull));
            }
            self.plant(hand, last, committed);
        }
        self.brushes[hand].last = Some(last);
    }

    /// Takes away what stands near the way from one place to another.
    fn uproot_along(&mut self, hand: usize, from: Vec2, on: &OnGround, history: &History) {
        let reach = match on.in_miniature {
            true => self.params.hover.touch * self.ground_from_miniature(),
            false => self.params.plant.uproot,
        };
        let grove = Arc::clone(&history.committed().grove);
        if from != on.at {
            for (number, plant) in grove.plants.iter().enumerate() {
                if to_way(plant.at, from, on.at) <= reach {
                    self.uproot(hand, number);
                }
            }
        }
        self.brushes[hand].last = Some(on.at);
    }

    /// Makes one edit of what a hand has planted or uprooted.
    pub(super) fn finish_brush(&mut self, hand: usize, history: &mut History) {
        let brush = std::mem::take(&mut self.brushes[hand]);
        if matches!(self.hands[hand].hold, Hold::Planting | Hold::Uprooting) {
            self.hands[hand].hold = Hold::Nothing;
        }
        let haptic = self.params.haptics.choose;
        if !brush.planted.is_empty() {
            let trees = brush.planted;
            self.apply(hand, Edit::Plant { trees }, haptic, history);
        }
        if !brush.uprooted.is_empty() {
            let trees = brush.uprooted;
            self.apply(hand, Edit::Uproot { trees }, haptic, history);
        }
    }

    /// The grove with what hands have planted and uprooted.
    pub(super) fn grove_in_hand(&self, committed: &Document) -> Arc<Grove> {
        let is_idle = |brush: &Brush| brush.planted.is_empty() && brush.uprooted.is_empty();
        if self.brushes.iter().all(is_idle) {
            return Arc::clone(&committed.grove);
        }
        let mut grove = Grove::clone(&committed.grove);
        for brush in &self.brushes {
            grove.plants.extend(&brush.planted);
        }
        let gone: Vec<u32> = self
            .brushes
            .iter()
            .flat_map(|brush| brush.uprooted.iter().copied())
            .collect();
        // Kinds stay in their places while the hand holds on.
        let mut number = 0;
        grove.plants.retain(|_| {
            number += 1;
            !gone.contains(&(number - 1))
        });
        Arc::new(grove)
    }

    /// Draws the planted trees, the same in miniature, and what brushes are at.
    pub(super) fn draw_grove(&self, palette: &Palette, stage: &StageParams, scene: &mut Scene) {
        let grove = &self.shown.grove;
        self.planted.draw(grove, scene);
        for plant in &grove.plants {
            let height = self.height_of(plant);
            if self.planted.display(plant).is_none() {
                // A stick, until it has grown.
                sapling(plant.foot(), height, 0.03 * height, stage, scene);
            }
            if let Some(foot) = self.on_platform(plant.at) {
                let height = height / self.ground_from_miniature();
                sapling(foot, height, TRUNK, stage, scene);
                scene.balls.push(Ball {
                    center: foot + Vec3::Y * height * CROWN[0],
                    radius: height * CROWN[1],
                    color: faded(palette.letter(2), 0.6),
                });
            }
        }
        for hand in &self.hands {
            if let Hover::Ground(on) = hand.hover {
                self.draw_ring(&on, palette, scene);
            }
        }
    }

    /// A ring where a brush would plant, or around what would be uprooted.
    fn draw_ring(&self, on: &OnGround, palette: &Palette, scene: &mut Scene) {
        let mut ring = |center: Vec3, radius: f32, color: Color| {
            let [least, for_each] = RING_RADIUS;
            let thick = least + for_each * center.distance(self.head);
            let at = |side: u8| {
                let angle = f32::from(side) / f32::from(RING) * std::f32::consts::TAU;
                center + Vec3::new(angle.cos(), 0.0, angle.sin()) * radius
            };
            scene.rods.extend((0..RING).map(|side| Rod {
                from: at(side),
                to: at(side + 1),
                radius: thick,
                color,
            }));
        };
        let plant = on.plant.and_then(|at| self.shown.grove.plants.get(at));
        let (at, radius, color) = match plant {
            Some(plant) => (plant.at, 0.12 * self.height_of(plant), palette.hovered),
            None => {
                let half = self.params.settings.plant_spacing * 0.5;
                (on.at, half, palette.ghost)
            }
        };
        match self.on_platform(at).filter(|_| on.in_miniature) {
            Some(place) => ring(place, radius / self.ground_from_miniature(), color),
            None => ring(Vec3::new(at.x, 0.02, at.y), radius, color),
        }
    }
}

/// A tree's trunk, as a rod.
fn sapling(foot: Vec3, height: f32, radius: f32, stage: &StageParams, scene: &mut Scene) {
    scene.rods.push(Rod {
        from: foot,
        to: foot + Vec3::Y * height,
        radius: radius.min(4.0 * stage.line_radius),
        color: Palette::default().stump,
    });
}

/// The tree that is planted at a place: turned and sized by what the place and its number draw.
fn individual_at(at: Vec2, number: usize, vary: f32) -> Plant {
    let seed = u64::from(at.x.to_bits()) << 32 | u64::from(at.y.to_bits());
    let mut draws = Draws::new(seed, number as u64);
    let yaw_deg = draws.uniform(0.0, 360.0);
    let larger = draws.uniform(-1.0, 1.0);
    let individual = draws.uniform(0.0, f64::from(INDIVIDUALS));
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "sizes are f32, and individuals fewer than a byte holds"
    )]
    let plant = Plant {
        at,
        yaw_deg,
        size: 1.0 + vary * larger as f32,
        individual: individual as u8,
        kind: None,
    };
    plant.quantized()
}

/// An error as the sentence that a person is told.
fn sentence(error: &EditError) -> String {
    error.to_string()
}

/// Where a ray meets a level plane from above, and metres along it; a ray that begins below has met it behind, at 0.
fn level(pointer: &Pointer, height: f32, reach: f32) -> Option<(Vec3, f32)> {
    let along = (height - pointer.origin.y) / pointer.direction.y;
    // A level ray gives ±∞ or NaN, which fails here.
    let met = pointer.direction.y < 0.0 && along.abs() <= reach;
    met.then(|| (pointer.origin + pointer.direction * along, along.max(0.0)))
}

/// How near a ray comes to an upright trunk, and where along the ray, metres; `None` where that is behind its beginning.
fn apart(pointer: &Pointer, foot: Vec3, height: f32) -> Option<(f32, f32)> {
    let ahead = Vec2::new(pointer.direction.x, pointer.direction.z);
    let away = Vec2::new(foot.x - pointer.origin.x, foot.z - pointer.origin.z);
    let level = ahead.length_squared();
    // A ray straight down has no way over the ground.
    if level < 1e-6 {
        return None;
    }
    let along = away.dot(ahead) / level;
    let at = pointer.origin + pointer.direction * along;
    let within = at.y.clamp(foot.y, foot.y + height);
    let aside = at.distance(Vec3::new(foot.x, within, foot.z));
    (along > 0.0).then_some((along, aside))
}

/// How far a place is from the straight way between two others.
fn to_way(place: Vec2, from: Vec2, to: Vec2) -> f32 {
    let way = to - from;
    let part =
        ((place - from).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    place.distance(from + way * part)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    fn ray(origin: Vec3, to: Vec3) -> Pointer {
        Pointer {
            origin,
            direction: (to - origin).normalize(),
            tip: origin,
            hand: origin,
        }
    }

    #[test]
    fn rays_meet_the_ground_from_above_and_not_absurdly_far() {
        let eye = Vec3::new(0.0, 1.6, 0.0);
        let (place, along) =
            level(&ray(eye, Vec3::new(3.0, 0.0, -4.0)), 0.0, 60.0).unwrap_or_default();
        assert!(place.distance(Vec3::new(3.0, 0.0, -4.0)) < 1e-5 && along > 5.0);
        for to in [
            Vec3::new(0.0, 1.6, -4.0),
            Vec3::new(0.0, 2.0, -4.0),
            Vec3::new(0.0, 1.599, -1.0),
        ] {
            assert_eq!(level(&ray(eye, to), 0.0, 60.0), None, "{to}");
        }
        // From below the ground the same ray has met it.
        let below = ray(Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.0, -1.5, -1.0));
        let (place, along) = level(&below, 0.0, 60.0).unwrap_or_default();
        assert!(place.distance(Vec3::new(0.0, 0.0, 0.5)) < 1e-5 && along == 0.0);
    }

    #[test]
    fn a_trunk_is_met_at_its_height_and_not_beyond_it() {
        let (eye, foot) = (Vec3::new(0.0, 1.6, 0.0), Vec3::new(0.0, 0.0, -5.0));
        let aside = |to: Vec3| apart(&ray(eye, to), foot, 3.0).map(|(_, aside)| aside);
        assert!(aside(Vec3::new(0.0, 2.5, -5.0)).is_some_and(|aside| aside < 1e-5));
        assert!(aside(Vec3::new(0.0, 4.0, -5.0)).is_some_and(|aside| aside > 0.9));
        assert!(aside(Vec3::new(0.5, 1.0, -5.0)).is_some_and(|aside| (0.4..0.6).contains(&aside)));
        assert_eq!(aside(Vec3::new(0.0, 1.6, 5.0)), None, "behind");
        assert_eq!(aside(Vec3::ZERO), None, "straight down");
    }

    #[test]
    fn a_place_and_a_number_say_which_tree_it_is() {
        let at = Vec2::new(1.5, -7.0);
        assert_eq!(individual_at(at, 3, 0.2), individual_at(at, 3, 0.2));
        let mut seen = [0_u32; INDIVIDUALS as usize];
        let (mut low, mut high) = (f32::MAX, 0.0_f32);
        for number in 0..800 {
            let plant = individual_at(at, number, 0.25);
            assert!((0.0..=360.0).contains(&plant.yaw_deg));
            (low, high) = (low.min(plant.size), high.max(plant.size));
            seen[usize::from(plant.individual)] += 1;
        }
        assert!(
            seen.iter().all(|count| (60..140).contains(count)),
            "{seen:?}"
        );
        assert!(
            (0.749..0.77).contains(&low) && (1.23..=1.251).contains(&high),
            "{low} {high}"
        );
        assert_eq!(individual_at(at, 3, 0.0).size, 1.0);
    }

    #[test]
    fn what_is_passed_is_near_the_way() {
        let (from, to) = (Vec2::ZERO, Vec2::new(4.0, 0.0));
        assert_eq!(to_way(Vec2::new(2.0, 1.0), from, to), 1.0);
        assert_eq!(to_way(Vec2::new(7.0, 4.0), from, to), 5.0);
        assert_eq!(to_way(Vec2::new(0.0, 2.0), from, from), 2.0);
    }
}
