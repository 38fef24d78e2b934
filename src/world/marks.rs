//! Marks on scanned models: endpoints that hands set, move and take away, and what is measured between places.
//!
//! Endpoints belong to the project, and each change of them is an edit. Measures are a person's for the session, as a ruler that is laid
//! on a table. Both are of a model's own coordinates, so they stay where they are on it however it is carried and scaled.

use std::sync::Arc;

use glam::{Affine3A, DVec3, Vec3};

use super::document::{Document, Edit};
use super::hover::{HoverParams, Pointer};
use super::model::{LoadedModel, Model};
use super::models::{Models, Source, is_of};
use super::scene::{Ball, Color, Rod, Scene};
use super::signs;
use crate::mesh::endpoints::{Endpoint, Kind, Proposal, Snapped};
use crate::mesh::measure::{Thickness, angle, distance, section, thickness};
use crate::mesh::pick::Hit;
use crate::mesh::unit::{Rounded, Unit};

/// Most measures at a time.
pub const MOST_MEASURES: usize = 16;
/// Rods that a way along a surface is drawn with at most.
const WAY_RODS: usize = 200;
/// Radius of an endpoint's ball as a part of the model's longest side, and its bounds, metres on the stage.
const RADIUS: f32 = 0.012;
const RADII: [f32; 2] = [0.0025, 0.03];
/// Colours of sources, targets, proposals and measures, linear.
const SOURCE: Color = [0.80, 0.10, 0.03, 1.0];
const TARGET: Color = [0.02, 0.25, 0.75, 1.0];
const PROPOSED: Color = [0.9, 0.62, 0.05, 1.0];
const MEASURE: Color = [0.02, 0.35, 0.10, 1.0];

/// What is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measuring {
    /// How far two places are from each other, straight.
    #[default]
    Distance,
    /// The shortest way between them on the surface.
    Along,
    /// The angle at the second of three places.
    Angle,
    /// How thick the model is at a place.
    Thickness,
}

impl Measuring {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Distance, Self::Along, Self::Angle, Self::Thickness];

    /// At how many places it is measured.
    #[must_use]
    pub fn places(self) -> usize {
        match self {
            Self::Distance | Self::Along => 2,
            Self::Angle => 3,
            Self::Thickness => 1,
        }
    }
}

/// What came of measuring; lengths in the file's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// There are places to come.
    Begun,
    /// It is being worked out.
    Waiting,
    /// So long.
    Length(f64),
    /// An angle, degrees.
    Degrees(f64),
    /// So thick.
    Thickness(Thickness),
    /// There is no such way or angle.
    None,
}

/// A measure that was laid on a model.
#[derive(Clone, Debug)]
pub struct Measure {
    /// Its number, which no other has in this session.
    pub id: u64,
    pub(super) source: Source,
    /// What is measured.
    pub what: Measuring,
    /// Where, from the mesh's origin.
    pub places: Vec<Hit>,
    /// What came of it.
    pub found: Found,
    /// The way that was measured, from the mesh's origin.
    pub(super) way: Vec<Vec3>,
}

impl Measure {
    /// Whether it is on this model.
    #[must_use]
    pub fn is_on(&self, model: &Model) -> bool {
        is_of(&self.source, model)
    }
}

/// A way along the surface that is to be worked out.
#[derive(Clone, Debug)]
pub struct WayRequest {
    /// The measure's number.
    pub id: u64,
    /// The model.
    pub loaded: Arc<LoadedModel>,
    /// From where to where.
    pub ends: [Hit; 2],
}

/// What a panel does with marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Have ends proposed for a model.
    Propose(usize),
    /// Take a proposal, or all: the model, and its number.
    Take(usize, Option<usize>),
    /// Refuse a proposal, or all.
    Refuse(usize, Option<usize>),
    /// Take a measure away, or all.
    Unmeasure(Option<u64>),
}

/// Measures and proposals of this session.
#[derive(Debug, Default)]
pub(super) struct Marks {
    pub(super) measures: Vec<Measure>,
    next: u64,
    pub(super) proposals: Vec<(Source, Vec<Proposal>)>,
    /// The model whose ends are to be proposed.
    pub(super) asked: Option<Source>,
}

impl Marks {
    /// Forgets what is on models that are no more, or are mended otherwise.
    pub(super) fn keep(&mut self, document: &Document) {
        let there = |source: &Source| document.models.iter().any(|model| is_of(source, model));
        self.measures.retain(|measure| there(&measure.source));
        self.proposals.retain(|(source, _)| there(source));
        self.asked.take_if(|source| !there(source));
    }

    /// The proposals for a model that were neither taken nor refused.
    pub(super) fn proposals(&self, model: &Model) -> &[Proposal] {
        let mut all = self.proposals.iter();
        all.find(|(source, _)| is_of(source, model))
            .map_or(&[], |(_, list)| list)
    }

    /// A place that is to be measured. False: there are too many measures.
    pub(super) fn measure(
        &mut self,
        what: Measuring,
        model: &Model,
        place: Hit,
        surface: &LoadedModel,
    ) -> bool {
        let goes_on = |last: &&mut Measure| {
            last.found == Found::Begun && last.what == what && is_of(&last.source, model)
        };
        self.measures.retain(|one| {
            one.found != Found::Begun || one.what == what && is_of(&one.source, model)
        });
        let full = self.measures.len() >= MOST_MEASURES;
        let measure = match self.measures.last_mut().filter(goes_on) {
            Some(begun) => begun,
            None if full => return false,
            None => {
                self.next += 1;
                self.measures.push(Measure {
                    id: self.next,
                    source: Source::of(model),
                    what,
                    places: Vec::new(),
                    found: Found::Begun,
                    way: Vec::new(),
                });
                let Some(last) = self.measures.last_mut() else {
                    return false;
                };
                last
            }
        };
        measure.places.push(place);
        measure.found = found(measure, surface);
        true
    }
}

/// What is measured when all places are there.
fn found(measure: &Measure, loaded: &LoadedModel) -> Found {
    match (measure.what, &*measure.places) {
        (Measuring::Distance, [from, to]) => Found::Length(distance(from.point, to.point)),
        (Measuring::Along, [_, _]) => Found::Waiting,
        (Measuring::Angle, [one, at, other]) => angle(at.point, one.point, other.point)
            .map_or(Found::None, |angle| Found::Degrees(angle.to_degrees())),
        (Measuring::Thickness, [at]) => {
            let picker = loaded.surface.picker();
            Found::Thickness(thickness(picker, at.point, at.normal))
        }
        _ => Found::Begun,
    }
}

/// An endpoint at a place of the surface, snapped to the middle of the tube there if that is wanted.
pub(super) fn marked(loaded: &LoadedModel, place: &Hit, snaps: bool, like: Endpoint) -> Endpoint {
    let section = snaps.then(|| section(&loaded.surface, place)).flatten();
    let mut end = Endpoint {
        point: loaded.in_file(place.point),
        snapped: section.map(|section| Snapped {
            centre: loaded.in_file(section.centre),
            radius: f64::from(section.radius),
        }),
        ..like
    };
    if !end.is_sound() {
        // A tube so thin that its radius is nothing.
        end.snapped = None;
    }
    end
}

/// The edit that gives a model other endpoints.
pub(super) fn with_endpoints(
    document: &Document,
    at: usize,
    endpoints: Vec<Endpoint>,
) -> Option<Edit> {
    let mut models = document.models.to_vec();
    models.get_mut(at)?.endpoints = Arc::new(endpoints);
    Some(Edit::Arrange {
        models,
        platform: document.platform,
        linked: document.linked,
    })
}

/// The radius of a mark on a model, metres on the stage.
pub(super) fn mark_radius(model: &Model) -> f32 {
    let [least, most] = RADII;
    (model.place.scale * RADIUS).clamp(least, most)
}

impl Models {
    /// What of a ray is not cut away: from and to, metres along it.
    fn kept(&self, pointer: &Pointer, reach: f32) -> Option<[f32; 2]> {
        let Some(plane) = self.plane else {
            return Some([0.0, reach]);
        };
        let normal = plane.truncate();
        let (above, along) = (
            normal.dot(pointer.origin) - plane.w,
            normal.dot(pointer.direction),
        );
        let crossing = -above / along;
        let [from, to] = match (above > 0.0, along > 0.0) {
            // It begins in what is cut away, and leaves it or not.
            (true, true) => return None,
            (true, false) => [crossing, reach],
            (false, true) => [0.0, crossing.min(reach)],
            (false, false) => [0.0, reach],
        };
        (from < to).then_some([from, to])
    }

    pub(super) fn is_cut(&self, place: Vec3) -> bool {
        self.plane
            .is_some_and(|plane| plane.truncate().dot(place) > plane.w)
    }

    /// The place of a model's surface that is touched, else pointed at: metres along the ray, and the place, from the mesh's origin.
    pub(super) fn spot(
        &self,
        model: &Model,
        pointer: &Pointer,
        params: &HoverParams,
    ) -> Option<(f32, Hit)> {
        let loaded = self.loaded(model)?;
        let (map, scale) = (loaded.stage_from_model(model), loaded.scale(model));
        let (inverse, picker) = (map.inverse(), loaded.surface.picker());
        let tip = inverse.transform_point3(pointer.tip);
        let touched = picker.nearest(tip, params.touch / scale);
        if let Some(hit) = touched.filter(|hit| !self.is_cut(map.transform_point3(hit.point))) {
            return Some((0.0, hit));
        }
        // What is large is seen from afar.
        let reach = params.reach.max(2.0 * model.place.scale);
        let [from, to] = self.kept(pointer, reach)?;
        let origin = inverse.transform_point3(pointer.origin + pointer.direction * from);
        let direction = inverse.transform_vector3(pointer.direction);
        let hit = picker.ray(origin, direction, (to - from) / scale)?;
        Some((from + hit.distance * scale, hit))
    }

    /// Where an endpoint is on the stage.
    pub(super) fn place_of(&self, model: &Model, endpoint: &Endpoint) -> Option<Vec3> {
        let loaded = self.loaded(model)?;
        let map = loaded.stage_from_model(model);
        Some(map.transform_point3(loaded.from_origin(endpoint.point)))
    }

    /// Describes endpoints, proposals and measures.
    pub(super) fn draw_marks(
        &self,
        document: &Document,
        lit: [Option<(usize, usize)>; 2],
        head: Vec3,
        scene: &mut Scene,
    ) {
        for (number, model) in document.models.iter().enumerate() {
            let Some(loaded) = self.loaded(model) else {
                continue;
            };
            let map = loaded.stage_from_model(model);
            let on_stage = |place| map.transform_point3(loaded.from_origin(place));
            let radius = mark_radius(model);
            for (at, endpoint) in model.endpoints.iter().enumerate() {
                let is_lit = lit.contains(&Some((number, at)));
                let size = if is_lit { radius * 1.5 } else { radius };
                pin(endpoint, on_stage, size, color_of(endpoint.kind), scene);
            }
            for proposal in self.marks.proposals(model) {
                pin(&proposal.endpoint, on_stage, radius * 0.8, PROPOSED, scene);
            }
            let unit = model.unit;
            for measure in self.marks.measures.iter().filter(|one| one.is_on(model)) {
                draw_measure(measure, &map, radius * 0.6, unit, head, scene);
            }
        }
    }
}

/// An endpoint: a ball on the surface and one in the middle of the tube, and a rod between them. `on_stage` says where a place in the file's
/// coordinates is.
pub fn pin(
    endpoint: &Endpoint,
    on_stage: impl Fn(DVec3) -> Vec3,
    radius: f32,
    color: Color,
    scene: &mut Scene,
) {
    let center = on_stage(endpoint.point);
    scene.balls.push(Ball {
        center,
        radius,
        color,
    });
    if let Some(snapped) = &endpoint.snapped {
        let middle = on_stage(snapped.centre);
        scene.balls.push(Ball {
            center: middle,
            radius: radius * 0.6,
            color,
        });
        scene.rods.push(Rod {
            from: center,
            to: middle,
            radius: radius * 0.25,
            color,
        });
    }
}

/// The colour of an endpoint, linear.
#[must_use]
pub fn color_of(kind: Kind) -> Color {
    match kind {
        Kind::Source => SOURCE,
        Kind::Target => TARGET,
    }
}

fn draw_measure(
    measure: &Measure,
    map: &Affine3A,
    radius: f32,
    unit: Unit,
    head: Vec3,
    scene: &mut Scene,
) {
    let on_stage = |place: Vec3| map.transform_point3(place);
    for place in &measure.places {
        scene.balls.push(Ball {
            center: on_stage(place.point),
            radius,
            color: MEASURE,
        });
    }
    let mut last = None;
    let mut way = |place: Vec3| {
        if let Some(from) = last.replace(place) {
            scene.rods.push(Rod {
                from,
                to: place,
                radius: radius * 0.5,
                color: MEASURE,
            });
        }
    };
    let middle = if measure.way.is_empty() {
        measure
            .places
            .iter()
            .for_each(|place| way(on_stage(place.point)));
        match &*measure.places {
            [from, to] => on_stage(from.point.midpoint(to.point)),
            [_, at, _] => on_stage(at.point),
            other => match other.last() {
                Some(at) => on_stage(at.point),
                None => return,
            },
        }
    } else {
        let every = measure.way.len().div_ceil(WAY_RODS).max(1);
        let end = measure.way.last().into_iter();
        let thinned = measure.way.iter().step_by(every).chain(end);
        thinned.for_each(|place| way(on_stage(*place)));
        on_stage(measure.way[measure.way.len() / 2])
    };
    let symbol = unit.symbol();
    match measure.found {
        Found::Length(length) => {
            signs::write(
                format_args!("{} {symbol}", Rounded(length)),
                middle,
                head,
                scene,
            );
        }
        Found::Degrees(degrees) => {
            signs::write(format_args!("{}°", Rounded(degrees)), middle, head, scene);
        }
        Found::Thickness(Thickness {
            opposite: Some(thick),
            ..
        }) => {
            let thick = Rounded(f64::from(thick));
            signs::write(format_args!("{thick} {symbol}"), middle, head, scene);
        }
        _ => {}
    }
}
