//! Scanned models in the hands: found, gripped by their pedestal's rim or by themselves, carried, turned and scaled, and drawn.
//!
//! A model is held as the platform is (`grip`): level, turned by one hand, scaled by two. Where all is linked, what turns one turns the others
//! about their own middles. A hand means a model only where it means nothing else, so a model that a person stands in is in no tool's way.

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};

use super::abstracting;
use super::branches;
use super::comparing;
use super::document::{Document, Edit, Placement};
use super::grip::{GripParams, PlatformGrip};
use super::history::History;
use super::hover::{self, Pointer};
use super::input::Pose;
use super::likeness::Likeness;
use super::marks::Marks;
use super::model::{Colouring, LoadedModel, Model, SIDE_BOUNDS};
use super::scene::{Color, ModelLook, PlacedModel, Rod, Scene};
use super::signs;
use super::stage::{Palette, StageParams, furniture, rim};
use super::tools::{Hand, Hold, Hover, Tools};
use crate::mesh::display::Display;
use crate::mesh::mend::Mend;
use crate::mesh::pick::Hit;
use crate::mesh::unit::{Rounded, Unit};

/// How far a model may be carried and how large it may be pulled: farther than the platform, since people walk in it.
pub(super) const GRIP: GripParams = GripParams {
    farthest: 300.0,
    height: [-300.0, 300.0],
    scale: SIDE_BOUNDS,
    least_span: 0.02,
};

/// Edges of boxes: radius as a part of the box's longest side, and bounds of it, metres.
const BOX_RADIUS: f32 = 0.0015;
const BOX_RADII: [f32; 2] = [0.0006, 0.01];
/// Colour of a box's edges, linear.
pub const BOX_COLOR: Color = [0.05, 0.12, 0.25, 1.0];

/// A pedestal is a platform of this size.
fn pedestal(stage: &StageParams) -> StageParams {
    StageParams {
        platform_radius: 0.12,
        rim_width: 0.025,
        column_radius: 0.03,
        foot_radius: 0.11,
        ..*stage
    }
}

/// What a model's surface comes from: a file and what is mended on it, or what it grows from.
#[derive(Clone, Debug)]
pub(super) struct Source {
    file: String,
    mends: Vec<Mend>,
    likeness: Option<Likeness>,
}

impl Source {
    pub(super) fn of(model: &Model) -> Self {
        Self {
            file: model.file.clone(),
            mends: model.mends.clone(),
            likeness: model.likeness.clone(),
        }
    }
}

pub(super) fn is_of(source: &Source, model: &Model) -> bool {
    source.file == model.file && source.mends == model.mends && source.likeness == model.likeness
}

/// A model's colours by numbers, and what they mean.
#[derive(Clone, Debug)]
pub struct Painting {
    /// What is drawn.
    pub display: Arc<Display>,
    /// Its number for the renderer.
    pub revision: u64,
    /// The numbers at both ends of the scale, in the file's unit, curvature in one over it; none where no vertex has a number.
    pub range: Option<[f32; 2]>,
}

/// A file that is being read, or whose centerlines are being found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// As the project names it.
    pub file: String,
    /// How far, in steps of five hundredths.
    pub percent: u32,
}

impl Reading {
    /// Says which file is at work and how far that is, thousandths.
    pub(super) fn tell(told: &mut Option<Self>, now: Option<(&str, u32)>) {
        let Some((file, thousandths)) = now else {
            *told = None;
            return;
        };
        let percent = thousandths / 50 * 5;
        match told {
            Some(told) if told.file == file => told.percent = percent,
            _ => {
                *told = Some(Self {
                    file: file.to_owned(),
                    percent,
                });
            }
        }
    }
}

/// What became of a model's file.
type Found = Result<Arc<LoadedModel>, String>;

/// Whether models are cut open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cut {
    /// They are whole.
    #[default]
    None,
    /// What lies between a person and the plane before their left hand is cut away (right, if they are left-handed).
    InHand,
    /// The plane stays where the hand had it.
    Stays,
}

/// How a person looks at models; it is theirs for the session, and no part of the project.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Looking {
    /// Whether models are cut open.
    pub cut: Cut,
    /// Whether there is a light in the other hand.
    pub lamp: bool,
}

/// The models' meshes, as far as they were read, and the one in the hands.
#[derive(Debug, Default)]
pub(super) struct Models {
    found: Vec<(Source, Found)>,
    pub(super) reading: Option<Reading>,
    /// How often that changed.
    pub(super) changes: u64,
    pub(super) looking: Looking,
    /// The plane of the cut: its normal, towards the person, and how far along it lies.
    pub(super) plane: Option<Vec4>,
    /// Where the light is.
    pub(super) lamp: Option<Vec3>,
    pub(super) marks: Marks,
    pub(super) lines: branches::Store,
    pub(super) abstractions: abstracting::Store,
    pub(super) comparing: comparing::Store,
    /// Colours by numbers that were worked out.
    painted: Vec<(Source, Colouring, Painting)>,
    grip: Option<(usize, PlatformGrip)>,
    /// The list that hands hold models of by their place in it.
    pub(super) seen: Arc<Vec<Model>>,
}

impl Models {
    /// A model whose file is to be read next.
    pub(super) fn wanted<'a>(&self, document: &'a Document) -> Option<&'a Model> {
        let mut models = document.models.iter();
        models.find(|model| self.get(model).is_none())
    }

    pub(super) fn give(&mut self, model: &Model, found: Found) {
        self.found.retain(|(known, _)| !is_of(known, model));
        self.found.push((Source::of(model), found));
        self.changes += 1;
    }

    /// Those that could not be read are wanted again.
    pub(super) fn forget_failures(&mut self) {
        self.found.retain(|(_, found)| found.is_ok());
        self.changes += 1;
    }

    fn get(&self, model: &Model) -> Option<&Found> {
        let (_, found) = self.found.iter().find(|(known, _)| is_of(known, model))?;
        Some(found)
    }

    /// Whether a model was read as it is to be.
    pub(super) fn is_read(&self, model: &Model) -> bool {
        matches!(self.get(model), Some(Ok(_)))
    }

    /// The mesh of a model, if its file could be read and was; while another mend is at work, as it was before.
    pub(super) fn loaded(&self, model: &Model) -> Option<&Arc<LoadedModel>> {
        match self.get(model) {
            Some(found) => found.as_ref().ok(),
            None => {
                let before = self.found.iter().rev();
                let is_grown = model.likeness.is_some();
                let mut same = before.filter(|(source, _)| {
                    source.file == model.file && source.likeness.is_some() == is_grown
                });
                same.find_map(|(_, found)| found.as_ref().ok())
            }
        }
    }

    /// Forgets the meshes that no model has any more, as it is kept or as it is seen; undo has them read again.
    pub(super) fn keep(&mut self, documents: [&Document; 2]) {
        let [committed, _] = documents;
        let wanted = documents.into_iter().find_map(|one| self.wanted(one));
        let wanted = wanted.map(|model| model.file.clone());
        let kept = |source: &Source| {
            let mut models = documents.into_iter().flat_map(|one| one.models.iter());
            wanted.as_ref() == Some(&source.file) || models.any(|model| is_of(source, model))
        };
        self.found.retain(|(source, _)| kept(source));
        self.marks.keep(committed);
        self.lines.keep(committed);
        self.abstractions.keep(committed);
        self.comparing.keep(committed);
        self.painted.retain(|(source, by, _)| {
            let mut models = committed.models.iter();
            models.any(|model| is_of(source, model) && model.colouring == *by)
        });
    }

    /// A model that is to be coloured by numbers that nobody has worked out.
    pub(super) fn unpainted<'a>(&self, document: &'a Document) -> Option<&'a Model> {
        let mut models = document.models.iter();
        models.find(|model| {
            let is_numbers = model.colouring.is_numbers();
            is_numbers && self.is_read(model) && self.painting(model).is_none()
        })
    }

    pub(super) fn paint(&mut self, model: &Model, painting: Painting) {
        let source = Source::of(model);
        self.painted.push((source, model.colouring, painting));
        self.changes += 1;
    }

    /// A model's colours by numbers, if they were worked out.
    pub(super) fn painting(&self, model: &Model) -> Option<&Painting> {
        let mut painted = self.painted.iter();
        let found = painted.find(|(source, by, _)| is_of(source, model) && *by == model.colouring);
        found.map(|(_, _, painting)| painting)
    }

    /// Describes pedestals, models and boxes.
    pub(super) fn draw(
        &self,
        document: &Document,
        meant: impl Fn(usize) -> bool,
        stage: &StageParams,
        palette: &Palette,
        head: Vec3,
        scene: &mut Scene,
    ) {
        let pedestal = pedestal(stage);
        for (at, model) in document.models.iter().enumerate() {
            let place = &model.place;
            furniture(place, meant(at), &pedestal, palette, &mut scene.plates);
            let Some(loaded) = self.loaded(model) else {
                continue;
            };
            let world_from_model = loaded.stage_from_model(model);
            let (display, revision) = match self.painting(model) {
                Some(painting) => (&painting.display, painting.revision),
                None => loaded.shown(model),
            };
            if model.boxed {
                let [least, most] = BOX_RADII;
                let radius = (place.scale * BOX_RADIUS).clamp(least, most);
                box_rods(display, &world_from_model, radius, &mut scene.rods);
                box_signs(display, &world_from_model, model.unit, head, scene);
            }
            if let Some((length, on_stage)) = loaded.scale_bar(model) {
                let at = bar(place, on_stage, &mut scene.rods);
                let symbol = model.unit.symbol();
                signs::write(format_args!("{length} {symbol}"), at, head, scene);
            }
            scene.models.push(PlacedModel {
                display: Arc::clone(display),
                revision,
                world_from_model,
                look: ModelLook {
                    cut: self.plane,
                    lamp: self.lamp,
                    ..model.look()
                },
            });
        }
    }
}

/// How what lies inside of a model looks: it stands out from the blue of what is seen through.
pub fn centerline_look() -> ModelLook {
    ModelLook {
        color: [0.85, 0.16, 0.02, 1.0],
        ..ModelLook::default()
    }
}

/// Thickness of a scale bar and height of its ends, as parts of its length.
const BAR: [f32; 2] = [0.02, 0.06];
/// Dark and light by turns, as on maps, linear.
const BAR_COLORS: [Color; 2] = [[0.02, 0.02, 0.02, 1.0], [0.8, 0.8, 0.8, 1.0]];
/// How far before the pedestal's middle it lies, metres, and how far below the top.
const BAR_PLACE: [f32; 2] = [0.165, 0.03];

/// A bar before the pedestal that is as long as it says, in two halves; gives its middle.
fn bar(place: &Placement, length: f32, rods: &mut Vec<Rod>) -> Vec3 {
    let [before, below] = BAR_PLACE;
    let [radius, ends] = BAR.map(|part| part * length);
    let middle = place.position + Vec3::new(0.0, -below, before);
    let half = Vec3::X * (length * 0.5);
    let mut rod = |from, to, color| {
        rods.push(Rod {
            from,
            to,
            radius: radius.clamp(0.002, 0.03),
            color,
        });
    };
    let [dark, light] = BAR_COLORS;
    rod(middle - half, middle, dark);
    rod(middle, middle + half, light);
    for end in [middle - half, middle + half] {
        rod(end - Vec3::Y * ends, end + Vec3::Y * ends, dark);
    }
    middle
}

/// How long a model's box is along each axis, at the middle of the edge that is nearest to the person.
pub fn box_signs(
    display: &Display,
    world_from_model: &Affine3A,
    unit: Unit,
    head: Vec3,
    scene: &mut Scene,
) {
    let corners = display
        .corners()
        .map(|corner| world_from_model.transform_point3(corner));
    let middle = |corner: usize, axis: usize| corners[corner].midpoint(corners[corner | 1 << axis]);
    for (axis, length) in display.size().to_array().into_iter().enumerate() {
        let edges = (0..corners.len()).filter(|corner| corner & 1 << axis == 0);
        let far = |corner: &usize| middle(*corner, axis).distance(head);
        if let Some(nearest) = edges.min_by(|a, b| far(a).total_cmp(&far(b))) {
            let length = Rounded(f64::from(length));
            let symbol = unit.symbol();
            let at = middle(nearest, axis);
            signs::write(format_args!("{length} {symbol}"), at, head, scene);
        }
    }
}

/// The twelve edges of a model's box.
pub fn box_rods(display: &Display, world_from_model: &Affine3A, radius: f32, rods: &mut Vec<Rod>) {
    let corners = display
        .corners()
        .map(|corner| world_from_model.transform_point3(corner));
    for (number, from) in corners.into_iter().enumerate() {
        // Each edge once, from its smaller end.
        for axis in [1, 2, 4] {
            if number & axis == 0 {
                rods.push(Rod {
                    from,
                    to: corners[number | axis],
                    radius,
                    color: BOX_COLOR,
                });
            }
        }
    }
}

/// Metres along a ray to a box in a frame of its own; 0 from within.
fn met_box(
    display: &Display,
    world_from_model: &Affine3A,
    origin: Vec3,
    direction: Vec3,
) -> Option<f32> {
    let inverse = world_from_model.inverse();
    let origin = inverse.transform_point3(origin);
    let direction = inverse.transform_vector3(direction);
    let (a, b) = (
        (display.low - origin) / direction,
        (display.high - origin) / direction,
    );
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    // A ray along a face gives NaN there, which max and min leave out.
    (enter <= leave && leave >= 0.0).then_some(enter.max(0.0))
}

impl Tools {
    /// Lets the plane follow the hand that it is in, and the light the other; where a hand is lost both stay.
    pub(super) fn follow_looking(&mut self, hand: usize) {
        let sample = |hand: usize| self.hands.get(hand).and_then(|hand| hand.sample);
        let (cutting, lighting) = (sample(hand), sample(1 - hand.min(1)));
        let models = &mut self.models;
        match models.looking.cut {
            Cut::None => models.plane = None,
            Cut::Stays => {}
            Cut::InHand => {
                if let Some(sample) = cutting {
                    let normal = -sample.direction;
                    models.plane = Some(normal.extend(normal.dot(sample.tip)));
                }
            }
        }
        if !models.looking.lamp {
            models.lamp = None;
        } else if let Some(sample) = lighting {
            models.lamp = Some(sample.tip);
        }
    }

    /// The pedestal's rim that is meant, if one is.
    pub(super) fn pedestal_at(&self, pointer: &Pointer) -> Option<(usize, f32)> {
        let pedestal = pedestal(&self.stage);
        let models = self.shown.models.iter().enumerate();
        let met = models.filter_map(|(at, model)| {
            let ring = rim(&model.place, &pedestal);
            Some((at, hover::ring(&ring, pointer, &self.params.hover)?))
        });
        met.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The model whose surface is meant, and where from its mesh's origin; else the one whose box is, if one is.
    pub(super) fn model_at(&self, pointer: &Pointer) -> Option<(usize, f32, Option<Hit>)> {
        let params = &self.params.hover;
        let models = || self.shown.models.iter().enumerate();
        let spots = models().filter_map(|(at, model)| {
            let (along, hit) = self.models.spot(model, pointer, params)?;
            Some((at, along, Some(hit)))
        });
        let boxes = models().filter_map(|(at, model)| {
            let loaded = self.models.loaded(model)?;
            let map = loaded.stage_from_model(model);
            let along = met_box(&loaded.plain, &map, pointer.origin, pointer.direction)?;
            (along <= params.reach).then_some((at, along, None))
        });
        let nearer = |a: &(usize, f32, _), b: &(usize, f32, _)| a.1.total_cmp(&b.1);
        spots.min_by(nearer).or_else(|| boxes.min_by(nearer))
    }

    /// Takes hold of a model; while one is held, the other hand takes no other.
    pub(super) fn take_model(&mut self, hand: usize, at: usize) {
        if self
            .models
            .grip
            .as_ref()
            .is_some_and(|(held, _)| *held != at)
        {
            return;
        }
        self.hands[hand].hold = Hold::Model(at);
        self.grip_model_anew(at);
        self.pulse(hand, self.params.haptics.choose);
    }

    /// Begins a model's grip anew, from where it is seen now.
    fn grip_model_anew(&mut self, at: usize) {
        let poses = self.model_poses(at);
        let place = self.shown.models.get(at).map(|model| model.place);
        self.models.grip = place.map(|place| (at, PlatformGrip::new(place, poses)));
    }

    fn model_poses(&self, at: usize) -> [Option<Pose>; 2] {
        self.hands.map(|hand| match hand {
            Hand {
                hold: Hold::Model(held),
                sample: Some(sample),
                ..
            } if held == at => Some(sample.grip),
            _ => None,
        })
    }

    /// Lets go of a model where it is now.
    pub(super) fn release_model(&mut self, hand: usize, at: usize, history: &mut History) {
        let edit = self.arrangement(history.committed());
        self.hands[hand].hold = Hold::Nothing;
        if self.hands.iter().any(|other| other.hold == Hold::Model(at)) {
            // The other hand carries on from here; one grip is one action.
            if let Edit::Arrange { models, .. } = edit {
                self.shown.models = Arc::new(models);
            }
            self.grip_model_anew(at);
            return;
        }
        self.models.grip = None;
        self.apply(hand, edit, self.params.haptics.choose, history);
    }

    /// Lets go of models that are no more, and of those in whose place another one stands.
    pub(super) fn check_models(&mut self, models: &[Model]) {
        fn file(models: &[Model], at: usize) -> Option<&str> {
            models.get(at).map(|model| model.file.as_str())
        }
        let seen = Arc::clone(&self.models.seen);
        self.let_go_of_models(|at| at >= models.len() || file(&seen, at) != file(models, at));
    }

    /// Puts a held model back, and lets go of these models.
    pub(super) fn let_go_of_models(&mut self, of: impl Fn(usize) -> bool) {
        if self.models.grip.as_ref().is_some_and(|(at, _)| of(*at)) {
            self.models.grip = None;
        }
        for hand in &mut self.hands {
            if let Hold::Model(at) | Hold::End { model: at, .. } = hand.hold
                && of(at)
            {
                hand.hold = Hold::Nothing;
            }
        }
    }

    /// The models and the platform with what hands hold of them: where the platform is held, `platform` says where.
    pub(super) fn arranged(
        &self,
        committed: &Document,
        platform: Option<Placement>,
    ) -> (Arc<Vec<Model>>, Placement) {
        let mut place = platform.unwrap_or(committed.platform);
        let mut models = Arc::clone(&committed.models);
        self.arrange_ends(committed, &mut models);
        let mut turned = place.yaw_deg - committed.platform.yaw_deg;
        let mut held = None;
        if let Some((at, grip)) = &self.models.grip
            && let Some(model) = committed.models.get(*at)
        {
            let to = grip.placement(self.model_poses(*at), &GRIP);
            turned = to.yaw_deg - model.place.yaw_deg;
            held = Some(*at);
            if let Some(model) = Arc::make_mut(&mut models).get_mut(*at) {
                model.place = to;
            }
        }
        if !committed.linked || turned == 0.0 {
            return (models, place);
        }
        let turn = |place: &mut Placement| {
            place.yaw_deg += turned;
            *place = place.quantized();
        };
        let others = Arc::make_mut(&mut models).iter_mut().enumerate();
        for (_, model) in others.filter(|(at, _)| held != Some(*at)) {
            turn(&mut model.place);
        }
        if held.is_some() {
            turn(&mut place);
        }
        (models, place)
    }

    /// What letting go of everything that is held would make of models and platform.
    pub(super) fn arrangement(&self, committed: &Document) -> Edit {
        let platform = self.platform_in_hand();
        let (models, platform) = self.arranged(committed, platform);
        Edit::Arrange {
            models: models.to_vec(),
            platform,
            linked: committed.linked,
        }
    }

    /// Whether a hand holds a model or means it.
    pub(super) fn means_model(&self, at: usize) -> bool {
        self.hands.iter().any(|hand| {
            hand.hold == Hold::Model(at)
                || hand.hold == Hold::Nothing
                    && matches!(hand.hover, Hover::Model { at: other, .. } if other == at)
        })
    }
}
