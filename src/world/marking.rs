//! Hands that mark scanned models: the trigger sets endpoints and measures, the grip moves endpoints.

use std::sync::Arc;

use glam::Vec3;

use super::document::{Document, Edit};
use super::history::History;
use super::hover::{self, HoverParams, Pointer};
use super::marks::{Found, MOST_MEASURES, WayRequest, mark_radius, marked, with_endpoints};
use super::model::{LoadedModel, Model};
use super::models::{Source, is_of};
use super::scene::SurfaceLook;
use super::settings::DrawTool;
use super::tools::{Hand, Hold, Hover, Tools, pointer};
use crate::mesh::endpoints::{Endpoint, Kind, Proposal, next_name};
use crate::mesh::pick::Hit;

impl Tools {
    /// Whether the trigger marks places of models.
    pub(super) fn is_marking(&self) -> bool {
        matches!(
            self.params.settings.tool,
            DrawTool::Mark | DrawTool::Measure(_)
        )
    }

    /// The endpoint that is touched, else pointed at; none that is hidden behind the surface.
    pub(super) fn end_at(&self, pointer: &Pointer) -> Option<(usize, usize, f32)> {
        let models = self.shown.models.iter().enumerate();
        let found = models.filter_map(|(number, model)| {
            if model.endpoints.is_empty() {
                return None;
            }
            let (at, along) = self.end_of(model, pointer)?;
            Some((number, at, along))
        });
        found.min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn end_of(&self, model: &Model, pointer: &Pointer) -> Option<(usize, f32)> {
        let loaded = self.models.loaded(model)?;
        let (map, scale) = (loaded.stage_from_model(model), loaded.scale(model));
        let inverse = map.inverse();
        let params = self.params.hover;
        let there = Pointer {
            origin: inverse.transform_point3(pointer.origin),
            direction: inverse
                .transform_vector3(pointer.direction)
                .normalize_or_zero(),
            tip: inverse.transform_point3(pointer.tip),
            hand: inverse.transform_point3(pointer.hand),
        };
        let reach = params.reach.max(2.0 * model.place.scale);
        let here = HoverParams {
            touch: params.touch / scale,
            reach: reach / scale,
            ..params
        };
        let radius = mark_radius(model);
        let places = model.endpoints.iter();
        let centers = places.map(|end| loaded.from_origin(end.point));
        let hit = hover::ball(centers, radius / scale, &there, &here)?;
        let along = hit.along * scale;
        let seen_through = !matches!(
            model.surface,
            Some(SurfaceLook::Matte | SurfaceLook::Shaded | SurfaceLook::Textured)
        );
        let hidden = !hit.touched
            && !seen_through
            && self
                .models
                .spot(model, pointer, &params)
                .is_some_and(|(met, _)| met + 2.0 * radius < along);
        (!hidden).then_some((hit.index, along))
    }

    /// The trigger at a place of a model: an endpoint, or a place to measure at.
    pub(super) fn mark(&mut self, hand: usize, at: usize, place: &Hit, history: &mut History) {
        let document = history.committed();
        let Some(model) = document.models.get(at) else {
            return;
        };
        let Some(loaded) = self.models.loaded(model).cloned() else {
            return;
        };
        if let DrawTool::Measure(what) = self.params.settings.tool {
            let room = self.models.marks.measure(what, model, *place, &loaded);
            self.models.changes += 1;
            return match room {
                true => self.pulse(hand, self.params.haptics.create),
                false => self.refuse(
                    hand,
                    format!(
                        "There are {MOST_MEASURES} measures: take some away on the bench first."
                    ),
                ),
            };
        }
        let settings = &mut self.params.settings;
        let kind = settings.next_end;
        let like = Endpoint {
            name: next_name(&model.endpoints, kind),
            kind,
            ..Endpoint::default()
        };
        let mut endpoints = model.endpoints.to_vec();
        endpoints.push(marked(&loaded, place, settings.snap_ends, like));
        // One source, and targets from then on.
        settings.next_end = Kind::Target;
        self.set_endpoints(hand, at, endpoints, self.params.haptics.create, history);
    }

    fn set_endpoints(
        &mut self,
        hand: usize,
        at: usize,
        endpoints: Vec<Endpoint>,
        haptic: [f32; 2],
        history: &mut History,
    ) {
        if let Some(edit) = with_endpoints(history.committed(), at, endpoints) {
            self.apply(hand, edit, haptic, history);
        }
    }

    /// Makes an edit of a change of a model's endpoints.
    fn change_ends(
        &mut self,
        hand: usize,
        model: usize,
        haptic: [f32; 2],
        history: &mut History,
        change: impl FnOnce(&mut Vec<Endpoint>),
    ) {
        if let Some(of) = history.committed().models.get(model) {
            let mut endpoints = of.endpoints.to_vec();
            change(&mut endpoints);
            self.set_endpoints(hand, model, endpoints, haptic, history);
        }
    }

    /// The trigger at an endpoint: a source becomes a target, and back.
    pub(super) fn turn_end(&mut self, hand: usize, model: usize, at: usize, history: &mut History) {
        let haptic = self.params.haptics.choose;
        self.change_ends(hand, model, haptic, history, |endpoints| {
            if let Some(end) = endpoints.get_mut(at) {
                end.kind = end.kind.other();
            }
        });
    }

    /// Takes an endpoint away, one in the hand too.
    pub(super) fn delete_end(
        &mut self,
        hand: usize,
        model: usize,
        at: usize,
        history: &mut History,
    ) {
        self.hands[hand].hold = Hold::Nothing;
        let haptic = self.params.haptics.delete;
        self.change_ends(hand, model, haptic, history, |endpoints| {
            if at < endpoints.len() {
                endpoints.remove(at);
            }
        });
    }

    /// Where a hand holds an endpoint now: on the surface of its model, where the hand touches it or points.
    pub(super) fn end_in(
        &self,
        hand: usize,
        committed: &Document,
    ) -> Option<(usize, usize, Endpoint)> {
        let Hand {
            hold: Hold::End { model, at },
            sample: Some(sample),
            ..
        } = *self.hands.get(hand)?
        else {
            return None;
        };
        let of = committed.models.get(model)?;
        let like = of.endpoints.get(at)?.clone();
        let (_, place) = self
            .models
            .spot(of, &pointer(&sample), &self.params.hover)?;
        let loaded = self.models.loaded(of)?;
        let snaps = self.params.settings.snap_ends;
        Some((model, at, marked(loaded, &place, snaps, like)))
    }

    /// Lets an endpoint go where it is now.
    pub(super) fn release_end(&mut self, hand: usize, history: &mut History) {
        let held = self.end_in(hand, history.committed());
        self.hands[hand].hold = Hold::Nothing;
        let Some((model, at, end)) = held else { return };
        let haptic = self.params.haptics.choose;
        self.change_ends(hand, model, haptic, history, |endpoints| {
            if let Some(place) = endpoints.get_mut(at) {
                *place = end;
            }
        });
    }

    /// Which endpoint a hand holds or means.
    pub(super) fn end_meant(&self, hand: usize) -> Option<(usize, usize)> {
        let hand = self.hands.get(hand)?;
        match (hand.hold, hand.hover) {
            (Hold::End { model, at }, _) | (Hold::Nothing, Hover::End { model, at, .. }) => {
                Some((model, at))
            }
            _ => None,
        }
    }

    /// A place of a model, from its mesh's origin, on the stage.
    pub(super) fn on_stage(&self, at: usize, place: Vec3) -> Option<Vec3> {
        let model = self.shown.models.get(at)?;
        let loaded = self.models.loaded(model)?;
        Some(loaded.stage_from_model(model).transform_point3(place))
    }

    /// Where an endpoint stands on the stage.
    pub(super) fn end_place(&self, model: usize, at: usize) -> Option<Vec3> {
        let model = self.shown.models.get(model)?;
        self.models.place_of(model, model.endpoints.get(at)?)
    }

    /// Puts held endpoints where the hands have them.
    pub(super) fn arrange_ends(&self, committed: &Document, models: &mut Arc<Vec<Model>>) {
        for hand in 0..self.hands.len() {
            if let Some((model, at, end)) = self.end_in(hand, committed)
                && let Some(model) = Arc::make_mut(models).get_mut(model)
                && let Some(place) = Arc::make_mut(&mut model.endpoints).get_mut(at)
            {
                *place = end;
            }
        }
    }

    /// Has ends proposed for a model.
    pub(super) fn propose(&mut self, document: &Document, at: usize) {
        if let Some(model) = document.models.get(at) {
            self.models.marks.asked = Some(Source::of(model));
        }
    }

    /// The model whose ends are to be proposed.
    pub(super) fn proposals_wanted<'a>(
        &self,
        document: &'a Document,
    ) -> Option<(&'a Model, Arc<LoadedModel>)> {
        let source = self.models.marks.asked.as_ref()?;
        let model = document.models.iter().find(|model| is_of(source, model))?;
        Some((model, Arc::clone(self.models.loaded(model)?)))
    }

    /// Takes in what is proposed.
    pub(super) fn give_proposals(&mut self, model: &Model, proposals: Vec<Proposal>) {
        let marks = &mut self.models.marks;
        marks.asked.take_if(|source| is_of(source, model));
        marks.proposals.retain(|(source, _)| !is_of(source, model));
        if !proposals.is_empty() {
            let source = Source::of(model);
            marks.proposals.push((source, proposals));
        }
        self.models.changes += 1;
    }

    /// Takes proposals out: one of a model, or all.
    pub(super) fn take_proposals(
        &mut self,
        document: &Document,
        at: usize,
        which: Option<usize>,
    ) -> Vec<Proposal> {
        let Some(model) = document.models.get(at) else {
            return Vec::new();
        };
        self.models.changes += 1;
        let all = &mut self.models.marks.proposals;
        let Some(place) = all.iter().position(|(source, _)| is_of(source, model)) else {
            return Vec::new();
        };
        let list = &mut all[place].1;
        let taken = match which {
            Some(one) if one < list.len() => vec![list.remove(one)],
            Some(_) => Vec::new(),
            None => std::mem::take(list),
        };
        if list.is_empty() {
            all.remove(place);
        }
        taken
    }

    /// The edit that makes endpoints of proposals.
    pub(super) fn taking(document: &Document, at: usize, taken: Vec<Proposal>) -> Option<Edit> {
        let mut endpoints = document.models.get(at)?.endpoints.to_vec();
        for mut proposal in taken {
            let kind = match endpoints.iter().any(|end| end.kind == Kind::Source) {
                true => Kind::Target,
                false => proposal.endpoint.kind,
            };
            proposal.endpoint.kind = kind;
            proposal.endpoint.name = next_name(&endpoints, kind);
            endpoints.push(proposal.endpoint);
        }
        with_endpoints(document, at, endpoints)
    }

    /// The way that is to be worked out next.
    pub(super) fn way_wanted(&self, document: &Document) -> Option<WayRequest> {
        let mut waiting = self.models.marks.measures.iter();
        let measure = waiting.find(|measure| measure.found == Found::Waiting)?;
        let model = document.models.iter().find(|model| measure.is_on(model))?;
        let [from, to] = *measure.places.as_slice() else {
            return None;
        };
        Some(WayRequest {
            id: measure.id,
            loaded: Arc::clone(self.models.loaded(model)?),
            ends: [from, to],
        })
    }

    /// Takes in a way that was worked out; none: no way leads there.
    pub(super) fn give_way(&mut self, id: u64, way: Option<(f64, Vec<Vec3>)>) {
        let mut measures = self.models.marks.measures.iter_mut();
        if let Some(measure) = measures.find(|measure| measure.id == id) {
            (measure.found, measure.way) = match way {
                Some((length, way)) => (Found::Length(length), way),
                None => (Found::None, Vec::new()),
            };
            self.models.changes += 1;
        }
    }

    /// Takes a measure away, or all.
    pub(super) fn unmeasure(&mut self, id: Option<u64>) {
        let measures = &mut self.models.marks.measures;
        measures.retain(|measure| id.is_some_and(|id| measure.id != id));
        self.models.changes += 1;
    }
}
