//! Scanned models on the stage: what the project keeps of each, and where each stands.
//!
//! The project names the file and says how it is shown; the mesh stays in its file. A model's size on the stage is kept as the length of its
//! longest side there, so that a neuron of a tenth of a millimetre and a tree of thirty metres lie on the same grid, whatever unit their files are in.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, DVec3, Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::document::{PLACEMENT_BOUNDS, Placement};
use super::likeness::Likeness;
use super::lines::LineLook;
use super::scene::{ModelLook, SurfaceLook, new_revision};
use crate::centerline::analysis::ModelFacts;
use crate::mesh::display::Display;
use crate::mesh::endpoints::{Endpoint, NAME_MOST};
use crate::mesh::mend::Mend;
use crate::mesh::problem::Problem;
use crate::mesh::surface::Surface;
use crate::mesh::textured::Textured;
use crate::mesh::unit::Unit;
use crate::tree::Tree;

/// Most models of a project.
pub const MOST_MODELS: usize = 8;
/// Most mends of a model.
const MOST_MENDS: usize = 32;
/// Longest name of a file, bytes.
const LONGEST_NAME: usize = 1024;
/// Most endpoints of a model: each edit of a model keeps them all.
pub const MOST_ENDPOINTS: usize = 4096;
/// Smallest and largest longest side on the stage, metres: a model in the palm, and one to walk in.
pub const SIDE_BOUNDS: [f32; 2] = [0.01, 500.0];

/// By what the triangles of a model are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colouring {
    /// By nothing: all have one colour.
    #[default]
    Plain,
    /// By the part that they belong to.
    Parts,
    /// By what is wrong with them.
    Problems,
    /// By how much the surface bends.
    Curvature,
    /// By the radius of the largest ball inside.
    Radius,
    /// By how thick what it encloses is.
    Thickness,
}

impl Colouring {
    /// Whether it shows a number at each vertex, which is worked out when somebody wants to see it.
    #[must_use]
    pub fn is_numbers(self) -> bool {
        matches!(self, Self::Curvature | Self::Radius | Self::Thickness)
    }
}

/// A scanned model as the project keeps it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Its file: from the project's folder, or from the root.
    pub file: String,
    /// What the file's numbers count.
    pub unit: Unit,
    /// Whether the file's third axis points up; else its second does.
    pub z_up: bool,
    /// What is mended on it each time it is read, in order; the file stays as it is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mends: Vec<Mend>,
    /// Where its pedestal stands; `scale` is the length of its longest side on the stage, metres.
    pub place: Placement,
    /// Its faces, or none.
    pub surface: Option<SurfaceLook>,
    /// Whether its edges are drawn.
    pub wireframe: bool,
    /// Whether its vertices are drawn.
    pub vertices: bool,
    /// Whether its box is drawn.
    pub boxed: bool,
    /// By what it is coloured.
    pub colouring: Colouring,
    /// Where its paths begin and end, in the file's coordinates.
    #[serde(default, skip_serializing_if = "is_none")]
    pub endpoints: Arc<Vec<Endpoint>>,
    /// How its centerlines are seen; none where they are not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<LineLook>,
    /// What it grows from, where it is no scan but an L-system like that file's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub likeness: Option<Likeness>,
}

fn is_none(endpoints: &Arc<Vec<Endpoint>>) -> bool {
    endpoints.is_empty()
}

/// Why a project cannot have a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// No file, or a name that no file has.
    #[error("a model needs the name of its file, of at most {LONGEST_NAME} bytes in one line")]
    Name,
    /// NaN, infinite, too small, too large or too far out.
    #[error(
        "a model cannot stand there: its place must be within {} m of the room's middle, and its longest side between {} m and {} m",
        PLACEMENT_BOUNDS.position, SIDE_BOUNDS[0], SIDE_BOUNDS[1]
    )]
    Place,
    /// More than 32 mends.
    #[error(
        "a model is mended at most {MOST_MENDS} times: undo some, or write the mended one with `ramus inspect --repair` and bring that"
    )]
    TooManyMends,
    /// More than 4096 endpoints.
    #[error("a model has at most {MOST_ENDPOINTS} endpoints: take some away first")]
    TooManyEndpoints,
    /// An endpoint that no file can hold.
    #[error(
        "an endpoint needs a name of at most {NAME_MOST} bytes in one line, and finite coordinates"
    )]
    Endpoint,
    /// A parameter of what it grows from is beyond its limits.
    #[error("a model cannot grow so: its {0} is beyond the limits of that number")]
    Likeness(&'static str),
    /// More than [`MOST_MODELS`].
    #[error("a project has at most {MOST_MODELS} models: remove one first")]
    TooMany,
}

impl Model {
    /// A model where the n-th stands at first: behind the platform, to its sides in turn.
    #[must_use]
    pub fn new(file: String, unit: Unit, z_up: bool, number: usize) -> Self {
        let row = u16::try_from(number / 2).unwrap_or(0);
        let side = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self {
            file,
            unit,
            z_up,
            mends: Vec::new(),
            place: Placement {
                position: Vec3::new(0.48 * side, 0.9, -1.0 - 0.5 * f32::from(row)),
                yaw_deg: 0.0,
                scale: 0.4,
            },
            surface: Some(SurfaceLook::default()),
            wireframe: false,
            vertices: false,
            boxed: false,
            colouring: Colouring::default(),
            endpoints: Arc::default(),
            lines: None,
            likeness: None,
        }
    }

    /// The model with its place on the grid.
    #[must_use]
    pub fn quantized(&self) -> Self {
        Self {
            place: self.place.quantized(),
            ..self.clone()
        }
    }

    /// # Errors
    /// What is wrong with it first.
    pub fn validate(&self) -> Result<(), ModelError> {
        let name = &self.file;
        if name.is_empty() || name.len() > LONGEST_NAME || name.contains(char::is_control) {
            return Err(ModelError::Name);
        }
        if self.mends.len() > MOST_MENDS {
            return Err(ModelError::TooManyMends);
        }
        if self.endpoints.len() > MOST_ENDPOINTS {
            return Err(ModelError::TooManyEndpoints);
        }
        if !self.endpoints.iter().all(Endpoint::is_sound) {
            return Err(ModelError::Endpoint);
        }
        let Placement {
            position,
            yaw_deg,
            scale,
        } = self.place;
        let [least, most] = SIDE_BOUNDS;
        let far = position.abs().max_element();
        // NaN fails each.
        let fits = position.is_finite() && far <= PLACEMENT_BOUNDS.position;
        if !fits || !(0.0..=360.0).contains(&yaw_deg) || !(least..=most).contains(&scale) {
            return Err(ModelError::Place);
        }
        self.likeness.as_ref().map_or(Ok(()), Likeness::validate)
    }

    /// What of it is to be seen.
    #[must_use]
    pub fn look(&self) -> ModelLook {
        ModelLook {
            surface: self.surface,
            wireframe: self.wireframe,
            vertices: self.vertices,
            ..ModelLook::default()
        }
    }
}

/// Checks all models of a project.
///
/// # Errors
/// What is wrong first.
pub fn validate(models: &[Model]) -> Result<(), ModelError> {
    if models.len() > MOST_MODELS {
        return Err(ModelError::TooMany);
    }
    models.iter().try_for_each(Model::validate)
}

/// What a file of a model holds, made ready to be shown.
#[derive(Clone, Debug)]
pub struct LoadedModel {
    /// As it is drawn, in its own colour.
    pub plain: Arc<Display>,
    /// The same coloured by parts.
    pub parts: Arc<Display>,
    /// The same coloured by problems.
    pub problems: Arc<Display>,
    /// Numbers of these three for the renderer.
    pub revisions: [u64; 3],
    /// The same as its file colours it, and its number; none where the file says nothing of colours.
    pub textured: Option<(Arc<Display>, u64)>,
    /// The skeleton inside it and its number, where there is one: seen where the surface can be seen through.
    pub centerline: Option<(Arc<Display>, u64)>,
    /// That skeleton itself, from the mesh's origin.
    pub skeleton: Option<Arc<Tree>>,
    /// What is told of the surface beside its centerlines.
    pub facts: ModelFacts,
    /// How many loops the surface has.
    pub loops: usize,
    /// What of the file is not shown as it was meant, in a sentence each.
    pub remarks: Vec<String>,
    /// What is wrong with it, the worst first.
    pub faults: Vec<Problem>,
    /// What each mend changed, a line each.
    pub accounts: Vec<String>,
    /// Where it is pointed at and measured.
    pub surface: Arc<Surface>,
}

impl LoadedModel {
    /// A model in one colour, with no word on what is wrong with it; `None` when somebody asked to stop.
    #[must_use]
    pub fn new(surface: Surface, cancel: &AtomicBool) -> Option<Self> {
        Self::with_materials(surface, None, cancel)
    }

    /// The same that can be seen as its file colours it, too. `textured` must be of the surface's mesh.
    #[must_use]
    pub fn with_materials(
        surface: Surface,
        textured: Option<Textured>,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mesh = Arc::clone(surface.mesh());
        let plain = Arc::new(Display::new(mesh, textured.as_ref(), cancel)?);
        let revision = new_revision();
        let materials = |textured| (Arc::new(plain.textured(Arc::new(textured))), new_revision());
        Some(Self {
            textured: textured.map(materials),
            centerline: None,
            skeleton: None,
            facts: ModelFacts::default(),
            loops: 0,
            remarks: Vec::new(),
            parts: Arc::clone(&plain),
            problems: Arc::clone(&plain),
            plain,
            revisions: [revision; 3],
            faults: Vec::new(),
            accounts: Vec::new(),
            surface: Arc::new(surface),
        })
    }

    /// The longest side of its box in the file's unit.
    #[must_use]
    pub fn side(&self) -> f32 {
        self.plain.size().max_element()
    }

    /// What is drawn of a model that looks so, and its number; plain where it shows numbers, which are worked out elsewhere.
    #[must_use]
    pub fn shown(&self, model: &Model) -> (&Arc<Display>, u64) {
        let [plain, parts, problems] = self.revisions;
        match (model.colouring, &self.textured) {
            (Colouring::Parts, _) => (&self.parts, parts),
            (Colouring::Problems, _) => (&self.problems, problems),
            (Colouring::Plain, Some((textured, revision)))
                if model.surface == Some(SurfaceLook::Textured) =>
            {
                (textured, *revision)
            }
            _ => (&self.plain, plain),
        }
    }

    /// Its box as it stands when the file's axis is up: smallest and largest corner in the file's unit, about the mesh's origin.
    fn upright(&self, z_up: bool) -> (Vec3, Vec3) {
        let turn = up(z_up);
        let [a, b] = [self.plain.low, self.plain.high].map(|corner| turn * corner);
        (a.min(b), a.max(b))
    }

    /// Model, from its mesh's origin, to stage: its lowest point stands on its pedestal's middle.
    #[must_use]
    pub fn stage_from_model(&self, model: &Model) -> Affine3A {
        let (low, high) = self.upright(model.z_up);
        let middle = (low + high) * 0.5;
        let foot = Vec3::new(middle.x, low.y, middle.z);
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(self.scale(model)),
            Quat::from_rotation_y(model.place.yaw()),
            model.place.position,
        ) * Affine3A::from_translation(-foot)
            * Affine3A::from_quat(up(model.z_up))
    }

    /// Width, height and depth as it stands, in the file's unit.
    #[must_use]
    pub fn size(&self, z_up: bool) -> Vec3 {
        let (low, high) = self.upright(z_up);
        high - low
    }

    /// The longest side of the real thing, metres, where the stage has room for it.
    #[must_use]
    pub fn real_side(&self, model: &Model) -> Option<f32> {
        #[expect(clippy::cast_possible_truncation, reason = "a size of the stage")]
        let side = (f64::from(self.side()) * model.unit.metres()) as f32;
        let [least, most] = SIDE_BOUNDS;
        (least..=most).contains(&side).then_some(side)
    }

    /// A bar to measure by: 1, 2 or 5 of a power of ten of the file's unit, about a third of the model's longest side. What it stands for in that
    /// unit, and its length on the stage, metres.
    #[must_use]
    pub fn scale_bar(&self, model: &Model) -> Option<(f64, f32)> {
        let third = f64::from(self.side()) / 3.0;
        if !third.is_normal() {
            return None;
        }
        let power = 10_f64.powf(third.log10().floor());
        let round = [5.0, 2.0, 1.0].map(|times| times * power);
        let length = round.into_iter().find(|length| *length <= third)?;
        #[expect(clippy::cast_possible_truncation, reason = "a length on the stage")]
        let on_stage = (length / f64::from(self.side()) * f64::from(model.place.scale)) as f32;
        Some((length, on_stage))
    }

    /// How many metres of the stage a length of 1 in the file's unit has.
    #[must_use]
    pub fn scale(&self, model: &Model) -> f32 {
        model.place.scale / self.side().max(f32::MIN_POSITIVE)
    }

    /// A place in the file's coordinates, from the mesh's origin.
    #[must_use]
    pub fn from_origin(&self, place: DVec3) -> Vec3 {
        (place - self.plain.mesh.origin).as_vec3()
    }

    /// A place from the mesh's origin, in the file's coordinates.
    #[must_use]
    pub fn in_file(&self, place: Vec3) -> DVec3 {
        self.plain.mesh.origin + place.as_dvec3()
    }

    /// How many metres of the stage stand for a real one.
    #[must_use]
    pub fn magnification(&self, model: &Model) -> f64 {
        f64::from(model.place.scale) / (f64::from(self.side()) * model.unit.metres())
    }
}

/// The turn that points a file's axis up.
#[must_use]
pub fn up(z_up: bool) -> Quat {
    const QUARTER: f32 = std::f32::consts::FRAC_1_SQRT_2;
    if z_up {
        Quat::from_xyzw(-QUARTER, 0.0, 0.0, QUARTER)
    } else {
        Quat::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::mesh::made;
    use crate::mesh::pick::Picker;

    fn tube() -> LoadedModel {
        let mesh = made::placed(made::tube(12, 4), 10.0, Vec3::new(500.0, 0.0, 70.0));
        let (mesh, never) = (Arc::new(mesh), AtomicBool::new(false));
        let picker = Picker::new(mesh, &never, &mut |_, _| ()).unwrap();
        LoadedModel::new(Surface::new(picker, &never).unwrap(), &never).unwrap()
    }

    #[test]
    fn a_model_stands_on_its_pedestal_with_its_longest_side_as_long_as_is_said() {
        let tube = tube();
        for z_up in [false, true] {
            for yaw_deg in [0.0, 90.0] {
                let mut model = Model::new("a.ply".into(), Unit::Millimetres, z_up, 0);
                model.place.yaw_deg = yaw_deg;
                let map = tube.stage_from_model(&model);
                let at = tube
                    .plain
                    .mesh
                    .positions
                    .iter()
                    .map(|p| map.transform_point3(*p));
                let (low, high) = at.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| {
                    (l.min(p), h.max(p))
                });
                let foot = Vec3::new((low.x + high.x) / 2.0, low.y, (low.z + high.z) / 2.0);
                assert!(foot.distance(model.place.position) < 1e-4, "{foot}");
                let side = (high - low).max_element();
                assert!((side - model.place.scale).abs() < 1e-4, "{side}");
                // The tube runs along the file's third axis.
                assert_eq!(z_up, (high - low).y > 0.39, "{low} {high}");
            }
        }
        let mut model = Model::new("a.ply".into(), Unit::Millimetres, true, 0);
        model.place.scale = 0.03;
        assert!(
            (tube.magnification(&model) - 1.0).abs() < 1e-3,
            "30 mm are 30 mm"
        );
    }

    #[test]
    fn the_bar_is_a_round_length_and_right_at_every_size() {
        let tube = tube();
        let mut model = Model::new("a.ply".into(), Unit::Millimetres, true, 0);
        for scale in [0.01, 0.4, 30.0, 500.0] {
            model.place.scale = scale;
            let (said, length) = tube.scale_bar(&model).unwrap();
            // The tube is 30 long: a third of it is 10.
            assert_eq!(said, 10.0);
            assert!((length - scale / 3.0).abs() < 1e-4 * scale, "{length}");
        }
        assert_eq!(tube.real_side(&model), Some(0.03));
        model.unit = Unit::Nanometres;
        assert_eq!(tube.real_side(&model), None, "nobody sees it");
    }

    #[test]
    fn what_no_project_has_is_refused() {
        let good = Model::new("ducts/a.ply".into(), Unit::Millimetres, true, 0);
        assert_eq!(good.validate(), Ok(()));
        let with = |change: fn(&mut Model)| {
            let mut model = good.clone();
            change(&mut model);
            model.validate()
        };
        assert_eq!(with(|m| m.file.clear()), Err(ModelError::Name));
        assert_eq!(with(|m| m.file = "a\nb".into()), Err(ModelError::Name));
        assert_eq!(with(|m| m.file = "a".repeat(2000)), Err(ModelError::Name));
        assert_eq!(
            with(|m| m.mends = vec![Mend::Orient; 33]),
            Err(ModelError::TooManyMends)
        );
        assert_eq!(with(|m| m.place.scale = 0.0), Err(ModelError::Place));
        assert_eq!(with(|m| m.place.scale = f32::NAN), Err(ModelError::Place));
        assert_eq!(with(|m| m.place.position.x = 1e9), Err(ModelError::Place));
        assert_eq!(with(|m| m.place.yaw_deg = 400.0), Err(ModelError::Place));
        assert_eq!(validate(&vec![good.clone(); 8]), Ok(()));
        assert_eq!(validate(&vec![good; 9]), Err(ModelError::TooMany));
    }

    #[test]
    fn models_stand_beside_each_other_at_first() {
        let places: Vec<Vec3> = (0..MOST_MODELS)
            .map(|n| {
                Model::new("a".into(), Unit::Metres, false, n)
                    .place
                    .position
            })
            .collect();
        for (n, place) in places.iter().enumerate() {
            assert!(
                places[..n]
                    .iter()
                    .all(|other| other.distance(*place) > 0.45)
            );
        }
    }
}
