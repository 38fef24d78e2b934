//! Centerlines on the stage: which models show theirs, what became of the search for them, the branch that is lit, and hands that choose branches.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::World;
use super::document::{Document, EditError};
use super::hover::{HoverParams, Pointer};
use super::lines::{Lines, Shading};
use super::marks::mark_radius;
use super::model::{LoadedModel, Model, up};
use super::models::{Models, Reading, Source, centerline_look, is_of};
use super::scene::{Ball, Color, ModelLook, PlacedModel, Rod, Scene, SurfaceLook};
use super::settings::DrawTool;
use super::signs;
use super::taken;
use super::tools::{Hover, Tools};
use crate::mesh::endpoints::Endpoint;
use crate::mesh::unit::Rounded;

/// Colours of the branch that was chosen, of the one that a hand is at, and of targets that no way leads to, linear: no scale of numbers has them.
pub const LIT: Color = [0.95, 0.02, 0.40, 1.0];
const MEANT: Color = [1.0, 0.45, 0.70, 1.0];
const UNREACHED: Color = [0.85, 0.25, 0.0, 1.0];
/// A lit branch is so many times as thick as the line, and no thinner than this part of the model's longest side.
const LIT_RADIUS: f32 = 1.6;
const LIT_LEAST: f32 = 0.004;
/// Rods that a lit branch is drawn with at most.
const LIT_RODS: usize = 200;
/// How far from a hand its label can be read, metres.
const READABLE: f32 = 1.0;
/// Colour of the largest balls within, linear.
const BALLS: Color = [0.10, 0.45, 0.25, 1.0];

/// What centerlines belong to: a file, its mends, the endpoints, whether they go on to open ends, and what gaps they bridge.
#[derive(Clone, Debug)]
pub(super) struct LineKey {
    source: Source,
    endpoints: Arc<Vec<Endpoint>>,
    reach: Reach,
}

type Reach = (bool, Option<u16>);

fn reach(model: &Model) -> Reach {
    let look = model.lines.unwrap_or_default();
    (look.caps, look.bridge)
}

impl LineKey {
    pub(super) fn of(model: &Model) -> Self {
        Self {
            source: Source::of(model),
            endpoints: Arc::clone(&model.endpoints),
            reach: reach(model),
        }
    }

    pub(super) fn is_of(&self, model: &Model) -> bool {
        let (one, other) = (&self.endpoints, &model.endpoints);
        let is_between = Arc::ptr_eq(one, other) || one == other;
        is_of(&self.source, model) && is_between && self.reach == reach(model)
    }
}

/// What became of the search for a model's centerlines.
type Found = Result<Arc<Lines>, String>;

/// All that is known of centerlines.
#[derive(Debug, Default)]
pub(super) struct Store {
    found: Vec<(LineKey, Found)>,
    shaded: Vec<(LineKey, Shading)>,
    /// The branch that was chosen.
    lit: Option<(LineKey, usize)>,
    /// The file whose centerlines are being found, and how far that is.
    finding: Option<Reading>,
}

impl Store {
    /// Forgets what no model shows any more.
    pub(super) fn keep(&mut self, document: &Document) {
        let shows = |key: &LineKey| {
            let mut models = document.models.iter();
            models.any(|model| model.lines.is_some() && key.is_of(model))
        };
        self.found.retain(|(key, _)| shows(key));
        self.shaded.retain(|(key, _)| shows(key));
        self.lit.take_if(|(key, _)| !shows(key));
    }

    fn get(&self, model: &Model) -> Option<&Found> {
        let mut found = self.found.iter();
        let (_, found) = found.find(|(key, _)| key.is_of(model))?;
        Some(found)
    }

    /// The centerlines of a model that shows them, where they were found.
    fn lines(&self, model: &Model) -> Option<&Arc<Lines>> {
        model.lines?;
        self.get(model)?.as_ref().ok()
    }

    fn shading(&self, model: &Model) -> Option<&Shading> {
        let mut shaded = self.shaded.iter();
        let (_, shading) = shaded.find(|(key, _)| key.is_of(model))?;
        Some(shading)
    }

    fn lit(&self, model: &Model) -> Option<usize> {
        let (key, branch) = self.lit.as_ref()?;
        key.is_of(model).then_some(*branch)
    }
}

/// Whether what lies inside of a model is seen.
pub(super) fn is_seen_through(model: &Model) -> bool {
    matches!(model.surface, None | Some(SurfaceLook::XRay))
}

impl Models {
    /// Describes what lies inside of models whose surface hides nothing. What is found belongs to models as they are kept, also while a hand
    /// carries one of their endpoints.
    pub(super) fn draw_lines(
        &self,
        [shown, kept]: [&Document; 2],
        meant: [Option<(usize, usize)>; 2],
        head: Vec3,
        scene: &mut Scene,
    ) {
        for (at, model) in shown.models.iter().enumerate() {
            let seen = is_seen_through(model);
            let Some(loaded) = self.loaded(model).filter(|_| seen) else {
                continue;
            };
            let map = loaded.stage_from_model(model);
            let lines = kept.models.get(at).and_then(|kept| {
                let lines = self.lines.lines(kept)?;
                Some((lines, self.lines.shading(kept)?, self.lines.lit(kept)))
            });
            let mut placed = |display, revision, look| {
                scene.models.push(PlacedModel {
                    display: Arc::clone(display),
                    revision,
                    world_from_model: map,
                    look: ModelLook {
                        cut: self.plane,
                        lamp: self.lamp,
                        ..look
                    },
                });
            };
            let Some((lines, shading, lit)) = lines else {
                if let Some((display, revision)) = &loaded.centerline {
                    placed(display, *revision, centerline_look());
                }
                continue;
            };
            placed(&shading.display, shading.revision, centerline_look());
            if model.lines.is_some_and(|look| look.balls) {
                let (display, revision) = &lines.balls;
                placed(display, *revision, balls_look());
            }
            let hover = meant
                .into_iter()
                .flatten()
                .filter(|(model, _)| *model == at);
            for (_, branch) in hover.filter(|(_, branch)| Some(*branch) != lit) {
                light(lines, branch, (model, loaded), &map, MEANT, scene);
            }
            if let Some(branch) = lit {
                let top = light(lines, branch, (model, loaded), &map, LIT, scene);
                // A hand that is at it has the label beside it.
                let is_told = meant.contains(&Some((at, branch)));
                if let (Some(top), Some(facts)) = (top, lines.analysis.branches.get(branch))
                    && !is_told
                {
                    let (length, symbol) = (Rounded(facts.length), model.unit.symbol());
                    let above = top + Vec3::Y * mark_radius(model);
                    signs::write(format_args!("{length} {symbol}"), above, head, scene);
                }
            }
            for (place, gap) in lines.unreached() {
                let radius = mark_radius(model);
                cross(map.transform_point3(*place), radius, scene);
                if let Some(gap) = gap {
                    scene.balls.push(Ball {
                        center: map.transform_point3(*gap),
                        radius: radius * 0.7,
                        color: UNREACHED,
                    });
                }
            }
        }
    }
}

/// How the largest balls within look: seen through, so that the line stays.
fn balls_look() -> ModelLook {
    ModelLook {
        surface: Some(SurfaceLook::XRay),
        color: BALLS,
        ..ModelLook::default()
    }
}

/// Lights a branch; gives its middle.
fn light(
    lines: &Lines,
    branch: usize,
    (model, loaded): (&Model, &LoadedModel),
    map: &Affine3A,
    color: Color,
    scene: &mut Scene,
) -> Option<Vec3> {
    let nodes = lines.nodes_of(branch);
    let (scale, least) = (loaded.scale(model), LIT_LEAST * model.place.scale);
    let every = nodes.len().div_ceil(LIT_RODS).max(1);
    let mut last: Option<(Vec3, f32)> = None;
    let on_stage = |node: &u32| {
        let (place, thick) = lines.place(*node)?;
        let radius = (thick * scale * LIT_RADIUS).max(least);
        Some((map.transform_point3(place), radius))
    };
    for (at, node) in nodes.iter().enumerate() {
        let is_drawn = at % every == 0 || at + 1 == nodes.len();
        let Some((place, radius)) = is_drawn.then(|| on_stage(node)).flatten() else {
            continue;
        };
        scene.balls.push(Ball {
            center: place,
            radius,
            color,
        });
        if let Some((from, before)) = last.replace((place, radius)) {
            scene.rods.push(Rod {
                from,
                to: place,
                radius: f32::midpoint(before, radius),
                color,
            });
        }
    }
    let (middle, _) = nodes.get(nodes.len() / 2).and_then(on_stage)?;
    Some(middle)
}

/// A cross, as on a map where nothing goes on.
fn cross(at: Vec3, radius: f32, scene: &mut Scene) {
    let [x, y] = [Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)];
    for arm in [x, y, Vec3::Z] {
        let arm = arm * (radius * 1.8);
        scene.rods.push(Rod {
            from: at - arm,
            to: at + arm,
            radius: radius * 0.45,
            color: UNREACHED,
        });
    }
}

/// How near a ray comes to a piece of a line: how far along the ray, and how far aside.
fn nearest(origin: Vec3, direction: Vec3, [from, to]: [Vec3; 2]) -> (f32, f32) {
    let (way, away) = (to - from, from - origin);
    let (along_way, squared) = (direction.dot(way), way.length_squared());
    let across = squared - along_way * along_way;
    let part = (direction.dot(away) * along_way - away.dot(way)) / across;
    // A piece along the ray, or without a length: where it begins.
    let part = if part.is_finite() {
        part.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let place = from + way * part;
    let along = direction.dot(place - origin).max(0.0);
    (along, place.distance(origin + direction * along))
}

impl Tools {
    /// The branch that is touched, else pointed at, where the trigger chooses branches: model, branch, metres along the ray.
    pub(super) fn branch_at(&self, pointer: &Pointer) -> Option<(usize, usize, f32)> {
        if self.params.settings.tool != DrawTool::Branch {
            return None;
        }
        let models = self.shown.models.iter().enumerate();
        let found = models.filter_map(|(number, model)| {
            let (branch, along) = self.branch_of(model, pointer)?;
            Some((number, branch, along))
        });
        found.min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn branch_of(&self, model: &Model, pointer: &Pointer) -> Option<(usize, f32)> {
        if !is_seen_through(model) {
            return None;
        }
        let loaded = self.models.loaded(model)?;
        let lines = self.models.lines.lines(model)?;
        let (map, scale) = (loaded.stage_from_model(model), loaded.scale(model));
        let inverse = map.inverse();
        let HoverParams {
            touch,
            reach,
            tolerance,
            ..
        } = self.params.hover;
        let origin = inverse.transform_point3(pointer.origin);
        let along = inverse.transform_vector3(pointer.direction);
        let direction = along.normalize_or_zero();
        let tip = inverse.transform_point3(pointer.tip);
        let reach = reach.max(2.0 * model.place.scale) / scale;
        let (touch, spread) = (touch / scale, tolerance.tan());
        // The touched one that is nearest, else the one that is least aside for how far it is.
        let mut best: Option<(bool, f32, usize, f32)> = None;
        let better = |a: (bool, f32), b: (bool, f32)| a.0 && !b.0 || a.0 == b.0 && a.1 < b.1;
        for branch in 0..lines.len() {
            let Some((centre, around)) = lines.around(branch) else {
                continue;
            };
            let (far, aside) = nearest(origin, direction, [centre, centre]);
            let near = centre.distance(tip) <= around + touch
                || aside <= around + (far + around) * spread && far <= reach + around;
            if !near {
                continue;
            }
            for pair in lines.nodes_of(branch).windows(2) {
                let [Some((from, thick)), Some((to, _))] =
                    [lines.place(pair[0]), lines.place(pair[1])]
                else {
                    continue;
                };
                let (at, aside) = nearest(origin, direction, [from, to]);
                let aside = (aside - thick).max(0.0);
                let met = at > 0.0 && at <= reach && aside <= at * spread;
                let away = away_from(tip, [from, to]);
                let one = match (away <= touch, met) {
                    (true, _) => (true, away, branch, 0.0),
                    (_, true) => (false, aside / at, branch, at),
                    _ => continue,
                };
                let place = map.transform_point3(origin + direction * at);
                let hidden = !one.0 && self.models.is_cut(place);
                if !hidden && best.is_none_or(|best| better((one.0, one.1), (best.0, best.1))) {
                    best = Some(one);
                }
            }
        }
        best.map(|(_, _, branch, at)| (branch, at * scale))
    }

    /// The trigger of a hand that chooses branches: the one that is lit goes out.
    pub(super) fn pull_at_branch(&mut self, hand: usize, hover: Hover) {
        let Hover::Branch { model, branch, .. } = hover else {
            return self.refuse(
                hand,
                "The trigger chooses branches of centerlines: point at one, or take the pen on the bench to draw.".into(),
            );
        };
        let Some(of) = self.shown.models.get(model) else {
            return;
        };
        let was = self.models.lines.lit(of) == Some(branch);
        self.models.lines.lit = (!was).then(|| (LineKey::of(of), branch));
        self.models.changes += 1;
        self.pulse(hand, self.params.haptics.choose);
    }

    /// The branch that a hand is at.
    pub(super) fn branch_meant(&self, hand: usize) -> Option<(usize, usize)> {
        match self.hands.get(hand)?.hover {
            Hover::Branch { model, branch, .. } => Some((model, branch)),
            _ => None,
        }
    }

    /// Where it is told what a hand is at, on the stage: at the branch, and no farther away than it can be read.
    pub(super) fn branch_place(&self, hand: usize) -> Option<Vec3> {
        let hand = self.hands.get(hand)?;
        let (sample, Hover::Branch { along, .. }) = (hand.sample?, hand.hover) else {
            return None;
        };
        Some(match along > 0.0 {
            true => sample.aim.position + sample.direction * along.min(READABLE),
            false => sample.tip,
        })
    }
}

/// How far a place is from a piece of a line.
fn away_from(place: Vec3, [from, to]: [Vec3; 2]) -> f32 {
    let way = to - from;
    let part = (place - from).dot(way) / way.length_squared();
    let part = if part.is_finite() {
        part.clamp(0.0, 1.0)
    } else {
        0.0
    };
    place.distance(from + way * part)
}

impl World {
    /// A model that shows its centerlines, which nobody has found as it is now; [`Self::give_lines`] brings what became of them.
    #[must_use]
    pub fn wanted_lines(&self) -> Option<(&Model, Arc<LoadedModel>)> {
        let models = &self.tools.models;
        let mut all = self.document().models.iter();
        let model = all.find(|model| models.wants_lines(model))?;
        Some((model, Arc::clone(models.loaded(model)?)))
    }

    /// Whether the centerlines of a model are still wanted, as it was when they were asked for.
    #[must_use]
    pub fn wants_lines(&self, model: &Model) -> bool {
        let key = LineKey::of(model);
        let mut all = self.document().models.iter();
        all.any(|now| key.is_of(now) && self.tools.models.wants_lines(now))
    }

    /// Gives a model's centerlines, or a sentence that says why there are none. Those that nobody wants any more are dropped.
    pub fn give_lines(&mut self, model: &Model, found: Result<Lines, String>) {
        if !self.wants_lines(model) {
            return;
        }
        match &found {
            Ok(lines) if self.proposals(model).is_empty() && !lines.proposals.is_empty() => {
                self.tools.give_proposals(model, lines.proposals.clone());
            }
            Ok(_) => {}
            Err(why) => self.show_message(why.clone()),
        }
        let store = &mut self.tools.models.lines;
        store.found.push((LineKey::of(model), found.map(Arc::new)));
        self.tools.models.changes += 1;
    }

    /// A model whose centerlines are to be seen in other colours than they are; [`Self::give_shading`] brings them.
    #[must_use]
    pub fn wanted_shading(&self) -> Option<(&Model, Arc<Lines>)> {
        let store = &self.tools.models.lines;
        let mut all = self.document().models.iter();
        all.find_map(|model| {
            let (look, lines) = (model.lines?, store.lines(model)?);
            let shading = store.shading(model);
            let is_so = shading.is_some_and(|shading| shading.by == look.by);
            (!is_so).then(|| (model, Arc::clone(lines)))
        })
    }

    /// Gives a model's centerlines in other colours.
    pub fn give_shading(&mut self, model: &Model, shading: Shading) {
        let store = &mut self.tools.models.lines;
        store.shaded.retain(|(key, _)| !key.is_of(model));
        store.shaded.push((LineKey::of(model), shading));
        self.tools.models.lines.keep(self.history.committed());
        self.tools.models.changes += 1;
    }

    /// The centerlines of a model that shows them, or a sentence that says why there are none; `None` while they are being found.
    #[must_use]
    pub fn lines(&self, model: &Model) -> Option<Result<&Arc<Lines>, &str>> {
        model.lines?;
        let found = self.tools.models.lines.get(model)?;
        Some(found.as_ref().map_err(String::as_str))
    }

    /// The colours of a model's centerlines, and what they mean.
    #[must_use]
    pub fn shading(&self, model: &Model) -> Option<&Shading> {
        self.tools.models.lines.shading(model)
    }

    /// Looks for centerlines again where none were found.
    pub fn find_lines_again(&mut self, at: usize) {
        if let Some(model) = self.history.committed().models.get(at) {
            let found = &mut self.tools.models.lines.found;
            found.retain(|(key, found)| found.is_ok() || !key.is_of(model));
            self.tools.models.changes += 1;
        }
    }

    /// The branch of a model that is lit.
    #[must_use]
    pub fn lit_branch(&self, model: &Model) -> Option<usize> {
        self.tools.models.lines.lit(model)
    }

    /// Lights a branch of a model, or none.
    pub fn light_branch(&mut self, at: usize, branch: Option<usize>) {
        if let Some(model) = self.history.committed().models.get(at) {
            let key = LineKey::of(model);
            self.tools.models.lines.lit = branch.map(|branch| (key, branch));
            self.tools.models.changes += 1;
        }
    }

    /// Takes a branch of a model's centerlines into the sketch as a line from the selected node, or with none the whole tree; what the sketch has no room
    /// for is told.
    ///
    /// # Errors
    /// Where the sketch refuses it.
    pub fn take_lines(&mut self, at: usize, which: Option<usize>) -> Result<(), EditError> {
        let document = self.history.committed();
        let Some((model, lines)) = document.models.get(at).and_then(|model| {
            let lines = self.lines(model)?.ok()?;
            Some((model, Arc::clone(lines)))
        }) else {
            return Ok(());
        };
        let (turn, tree) = (up(model.z_up), &lines.centerline.tree);
        let to = document.sketch.position(document.selected);
        let to = to.unwrap_or_default();
        let strokes = match document.sketch.is_empty() {
            true => 0,
            false => document.sketch.strokes.len(),
        };
        let taken = match which {
            Some(one) => taken::branch(tree, lines.nodes_of(one), turn, to).map(|edit| (edit, 0)),
            None => taken::whole(tree, turn, to, taken::room(strokes)),
        };
        let Some((edit, left_out)) = taken else {
            return Ok(());
        };
        self.apply(edit)?;
        if left_out > 0 {
            let told =
                format!("{left_out} of its branches, the shortest, have no room in the sketch.");
            self.show_message(told);
        }
        Ok(())
    }

    /// Says which file's centerlines are being found and how far that is, thousandths; panels show it in steps of five hundredths.
    pub fn tell_finding(&mut self, finding: Option<(&str, u32)>) {
        Reading::tell(&mut self.tools.models.lines.finding, finding);
    }

    /// The file whose centerlines are being found.
    #[must_use]
    pub fn finding(&self) -> Option<&Reading> {
        self.tools.models.lines.finding.as_ref()
    }
}

impl Models {
    fn wants_lines(&self, model: &Model) -> bool {
        model.lines.is_some() && self.is_read(model) && self.lines.get(model).is_none()
    }
}
