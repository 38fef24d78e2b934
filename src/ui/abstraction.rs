//! The page of a model as an L-system: trees like a scan, found while one watches; and of a tree that grows on the stage, its numbers, its seed and how far it
//! has grown.

use std::sync::Arc;

use egui::{
    Align2, Button, Color32, DragValue, Response, RichText, Sense, Slider, SliderClamping, Ui,
    pos2, vec2,
};

use super::{
    models::{TITLE_SIZE, arrange},
    panels::{AbstractionWish, View, Wish},
    theme::{INK, MESSAGE, SMALLEST, TITLE},
    words::Words,
};
use crate::abstraction::{ByOrder, Candidate, Difference, ORDERS_MOST, Params, presets};
use crate::mesh::unit::Rounded;
use crate::tree::{NO_PARENT, Tree};
use crate::world::abstracting::{Abstraction, Search};
use crate::world::likeness::Likeness;
use crate::world::lines::LineLook;
use crate::world::model::Model;

/// Trees in a row of previews, and how high these are, points.
const IN_A_ROW: usize = 3;
const HIGH: f32 = 110.0;
/// Segments of a preview at most: of more, each so many-th.
const SEGMENTS: usize = 600;
const GROUND: Color32 = Color32::from_rgb(12, 15, 17);
const BARK: Color32 = Color32::from_rgb(200, 178, 140);
const CHOSEN: Color32 = Color32::from_rgb(230, 120, 40);
/// Files that are written of a tree that grows.
const ENDINGS: [(&str, &str); 6] = [
    ("LSYS", "lsys"),
    ("GLB", "glb"),
    ("USDA", "usda"),
    ("PLY", "ply"),
    ("OBJ", "obj"),
    ("SWC", "swc"),
];

/// What the page remembers between looks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Abstractions {
    /// The seed that the next search has.
    seed: u64,
    /// The place of the tree that is looked at, and the seed of its search.
    chosen: (usize, u64),
}

impl Abstractions {
    /// Lays out what concerns one model.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        (at, model): (usize, &mut Model),
        wishes: &mut Vec<Wish>,
    ) {
        if let Some(likeness) = model.likeness.clone() {
            return tree(ui, view, words, (at, model, &likeness), wishes);
        }
        // As it is kept: a hand that carries an endpoint changes nothing yet.
        let kept = view.world.document().models.get(at);
        if !kept.is_some_and(|kept| matches!(view.world.lines(kept), Some(Ok(_)))) {
            return lines_first(ui, words, model);
        }
        let search = kept.and_then(|kept| view.world.abstraction(kept));
        match search {
            Some(search) if search.goes_on => drawing(ui, words, (at, search), wishes),
            _ => self.begin(ui, words, (at, search), wishes),
        }
        match search.and_then(|search| search.found.as_ref().map(|found| (search.seed, found))) {
            None => {}
            Some((_, Err(why))) => {
                ui.label(RichText::new(view.settings.language.say(why)).color(MESSAGE));
            }
            Some((seed, Ok(found))) => self.found(ui, words, (at, seed, found), wishes),
        }
    }

    /// What begins a search, and another one.
    fn begin(
        &mut self,
        ui: &mut Ui,
        words: &Words,
        (at, search): (usize, Option<&Search>),
        wishes: &mut Vec<Wish>,
    ) {
        ui.horizontal_wrapped(|ui| {
            ui.label(words.seed);
            ui.add(
                DragValue::new(&mut self.seed)
                    .range(0..=SEED_MOST)
                    .speed(0.1),
            );
            let name = match search {
                None => words.abstract_this,
                Some(_) => words.another_one,
            };
            if ui.button(name).clicked() {
                // The same seed would find the same.
                if search.is_some_and(|search| search.seed == self.seed) {
                    self.seed = (self.seed + 1).min(SEED_MOST);
                }
                wishes.push(Wish::Abstraction(AbstractionWish::Find(at, self.seed)));
            }
        });
    }

    /// The trees that were found: pictures to choose from, and the numbers of the one that was chosen.
    fn found(
        &mut self,
        ui: &mut Ui,
        words: &Words,
        (at, seed, found): (usize, u64, &Arc<Abstraction>),
        wishes: &mut Vec<Wish>,
    ) {
        if self.chosen.1 != seed {
            self.chosen = (0, seed);
        }
        self.chosen.0 = self.chosen.0.min(found.ranked.len().saturating_sub(1));
        let places: Vec<usize> = (0..found.ranked.len()).collect();
        for row in places.chunks(IN_A_ROW) {
            ui.horizontal(|ui| {
                #[expect(clippy::cast_precision_loss, reason = "a handful of pictures")]
                let wide = (ui.available_width() - 16.0) / IN_A_ROW as f32;
                for place in row {
                    let Some((candidate, tree)) = found.ranked.get(*place) else {
                        continue;
                    };
                    let told = Rounded(candidate.distance).to_string();
                    let look = (*place == self.chosen.0, told.as_str());
                    if preview(ui, tree, [wide, HIGH], look).clicked() {
                        self.chosen.0 = *place;
                    }
                }
            });
        }
        let Some((candidate, _)) = found.ranked.get(self.chosen.0) else {
            return;
        };
        if ui.button(words.stand_beside).clicked() {
            let wish = AbstractionWish::Stand(at, self.chosen.0);
            wishes.push(Wish::Abstraction(wish));
        }
        numbers(ui, words, candidate, found.by_rules.as_ref());
    }
}

/// Largest seed: files and panels tell seeds as numbers that all programs read exactly.
const SEED_MOST: u64 = u32::MAX as u64;

/// A search that goes on.
fn drawing(ui: &mut Ui, words: &Words, (at, search): (usize, &Search), wishes: &mut Vec<Wish>) {
    let [drawn, of] = match &search.found {
        Some(Ok(found)) => found.drawn,
        _ => [0, 0],
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{}: {drawn} / {of}", words.trees_drawn));
        if ui.button(words.cancel).clicked() {
            wishes.push(Wish::Abstraction(AbstractionWish::Stop(at)));
        }
    });
}

/// Says that centerlines are needed, and has them found.
pub(super) fn lines_first(ui: &mut Ui, words: &Words, model: &mut Model) {
    ui.label(words.lines_first);
    if model.lines.is_none() && ui.button(words.find_lines).clicked() {
        model.lines = Some(LineLook::default());
    }
}

/// What a number of a table is called: `of.mean` or `of_mean`, or what has neither.
pub(super) fn name(of: &str, words: &Words) -> String {
    let endings = [
        (".mean", false),
        ("_mean", false),
        (".std", true),
        ("_std", true),
    ];
    let of_ending = endings
        .into_iter()
        .find_map(|(ending, is_std)| Some((of.strip_suffix(ending)?, is_std)));
    let (of, is_std) = match of_ending {
        Some((of, is_std)) => (of, Some(is_std)),
        None => (of, None),
    };
    let of = match of {
        "centerlines" => words.tips,
        "junctions" => words.junctions,
        "branches" => words.branches,
        "branch_length" => words.length,
        "point_radius" => words.points,
        "centerline_length" => words.whole_way,
        "bifurcation_angle_deg" => words.angle,
        "branch_radius" => words.radius,
        "parent_angle_deg" => words.parent_angle,
        "stem_length" => words.stem,
        "tortuosity" => words.tortuosity,
        "curvature" => words.curvature,
        "torsion" => words.torsion,
        other => other,
    };
    match is_std {
        None => of.to_owned(),
        Some(false) => format!("{of}: {}", words.mean),
        Some(true) => format!("{of}: {}", words.deviation),
    }
}

/// The model's numbers, the tree's, and by how much these are off; those that are off by more than they may be are marked.
fn numbers(ui: &mut Ui, words: &Words, candidate: &Candidate, by_rules: Option<&Candidate>) {
    let all = &candidate.differences;
    let matching = all.iter().filter(|one| one.matches()).count();
    ui.label(format!(
        "{}: {matching} / {}",
        words.numbers_match,
        all.len()
    ));
    let heads = [words.in_the_model, words.in_the_tree, words.by_rules];
    cells(ui, "", heads.map(str::to_owned), INK);
    for (place, one) in all.iter().enumerate() {
        let ruled = by_rules.and_then(|ruled| ruled.differences.get(place));
        let short = |number: f64| Rounded(number).to_string();
        let ruled = ruled.map_or_else(|| "-".to_owned(), |ruled: &Difference| short(ruled.got));
        let ink = if one.matches() { INK } else { MESSAGE };
        let numbers = [short(one.target), short(one.got), ruled];
        cells(ui, &name(one.name, words), numbers, ink);
    }
    for one in &candidate.by_order {
        let difference = &one.difference;
        let short = |number: f64| Rounded(number).to_string();
        let ink = if difference.matches() { INK } else { MESSAGE };
        let numbers = [
            short(difference.target),
            short(difference.got),
            "-".to_owned(),
        ];
        let of = name(difference.name, words);
        let said = format!("{} {}: {of}", words.order, one.order);
        cells(ui, &said, numbers, ink);
    }
}

/// A row of a table: what it is, and three numbers.
pub(super) fn cells(ui: &mut Ui, name: &str, numbers: [String; 3], ink: Color32) {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y - 4.0);
    let (place, _) = ui.allocate_exact_size(size, Sense::hover());
    let font = egui::TextStyle::Body.resolve(ui.style());
    let painter = ui.painter();
    painter.text(
        place.left_center(),
        Align2::LEFT_CENTER,
        name,
        font.clone(),
        ink,
    );
    let part = size.x / 6.0;
    for (back, number) in (0_u8..).zip(numbers.iter().rev()) {
        let right = place.right_center() - vec2(part * f32::from(back), 0.0);
        painter.text(right, Align2::RIGHT_CENTER, number, font.clone(), ink);
    }
}

/// A tree seen from the side, as large as there is room, with a word below; how it `is_chosen`.
fn preview(
    ui: &mut Ui,
    tree: &Tree,
    [wide, high]: [f32; 2],
    (is_chosen, told): (bool, &str),
) -> Response {
    let (place, answer) = ui.allocate_exact_size(vec2(wide, high), Sense::click());
    let painter = ui.painter().with_clip_rect(place);
    painter.rect_filled(place, 4.0, GROUND);
    let edge = match (is_chosen, answer.hovered()) {
        (true, _) => Some(CHOSEN),
        (false, true) => Some(INK),
        (false, false) => None,
    };
    if let Some(edge) = edge {
        painter.rect_stroke(place, 4.0, (2.0, edge), egui::StrokeKind::Inside);
    }
    let room = place.shrink(8.0).with_max_y(place.bottom() - 20.0);
    let low = tree
        .position
        .iter()
        .fold(glam::Vec3::INFINITY, |low, at| low.min(*at));
    let top = tree
        .position
        .iter()
        .fold(glam::Vec3::NEG_INFINITY, |top, at| top.max(*at));
    let (middle, size) = ((low + top) * 0.5, top - low);
    let scale = (room.width() / size.x.max(1e-9)).min(room.height() / size.y.max(1e-9));
    let on_panel = |node: u32| {
        let at = (tree.position[node as usize] - middle) * scale;
        pos2(room.center().x + at.x, room.center().y - at.y)
    };
    let every = tree.len().div_ceil(SEGMENTS).max(1);
    for node in (0_u32..).take(tree.len()).step_by(every) {
        let parent = tree.parent[node as usize];
        if parent != NO_PARENT {
            let thick = (2.0 * tree.radius[node as usize] * scale).clamp(1.0, 12.0);
            painter.line_segment([on_panel(parent), on_panel(node)], (thick, BARK));
        }
    }
    let font = egui::FontId::proportional(SMALLEST);
    let below = place.center_bottom() - vec2(0.0, 3.0);
    painter.text(below, Align2::CENTER_BOTTOM, told, font, INK);
    answer
}

/// A tree that grows on the stage.
fn tree(
    ui: &mut Ui,
    view: &View<'_>,
    words: &Words,
    (at, model, likeness): (usize, &mut Model, &Likeness),
    wishes: &mut Vec<Wish>,
) {
    let loaded = view.world.loaded_model(model);
    if let Some(skeleton) = loaded.and_then(|loaded| loaded.skeleton.as_ref()) {
        let (segments, tips) = (skeleton.segment_count(), skeleton.tips().len());
        ui.horizontal_wrapped(|ui| {
            for (name, count) in [
                (words.segments, segments),
                (words.tips, tips),
                (words.junctions, skeleton.junctions()),
            ] {
                ui.label(format!("{name}: {count}"));
            }
        });
    }
    let mut page = Page {
        view,
        at,
        likeness,
        wishes,
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(words.seed);
        let mut seed = likeness.params.seed;
        let answer = ui.add(DragValue::new(&mut seed).range(0..=SEED_MOST).speed(0.1));
        page.number(&answer, |params| params.seed = seed);
        if ui.button(words.another_one).clicked() {
            let next = (likeness.params.seed + 1).min(SEED_MOST);
            page.change(|params| params.seed = next);
        }
    });
    page.moment(ui, words);
    ui.separator();
    page.sliders(ui);
    page.pruning(ui, words);
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        ui.label(words.write_lines);
        for (name, ending) in ENDINGS {
            if ui.button(name).clicked() {
                let wish = AbstractionWish::Write(at, ending);
                page.wishes.push(Wish::Abstraction(wish));
            }
        }
    });
}

/// The page of a tree, being laid out.
struct Page<'a, 'v> {
    view: &'a View<'v>,
    at: usize,
    likeness: &'a Likeness,
    wishes: &'a mut Vec<Wish>,
}

/// Where a number of the parameters is.
type Place<N> = fn(&mut Params) -> &mut N;
/// A number by its name in the grammar, and its limits.
type Number = (&'static str, Place<f64>, [f64; 2]);

/// Numbers that have sliders, by their names in the grammar.
const NUMBERS: [Number; 11] = [
    (
        "bifurcation_probability",
        |p| &mut p.bifurcation_probability,
        [0.0, 1.0],
    ),
    (
        "trifurcation_probability",
        |p| &mut p.trifurcation_probability,
        [0.0, 1.0],
    ),
    ("iterations", |p| &mut p.iterations, [1.0, 50.0]),
    ("iterations_std", |p| &mut p.iterations_std, [0.0, 25.0]),
    ("side_life", |p| &mut p.side_life, [0.0, 1.0]),
    ("length_ratio", |p| &mut p.length_ratio, [0.3, 2.0]),
    ("radius_ratio", |p| &mut p.radius_ratio, [0.3, 2.0]),
    ("upwards_angle", |p| &mut p.upwards_angle, [-90.0, 90.0]),
    (
        "upwards_angle_std",
        |p| &mut p.upwards_angle_std,
        [0.0, 60.0],
    ),
    (
        "bifurcation_angle",
        |p| &mut p.bifurcation_angle,
        [-90.0, 90.0],
    ),
    (
        "bifurcation_angle_std",
        |p| &mut p.bifurcation_angle_std,
        [0.0, 60.0],
    ),
];

/// Lengths, which are dragged: they have no largest value.
const LENGTHS: [(&str, Place<f64>); 4] = [
    ("segment_length", |p| &mut p.segment_length),
    ("segment_length_std", |p| &mut p.segment_length_std),
    ("segment_radius", |p| &mut p.segment_radius),
    ("radial_increment", |p| &mut p.radial_increment),
];

/// Whole numbers.
const WHOLE: [(&str, Place<u32>, u32); 3] = [
    ("stem_length", |p| &mut p.stem_length, 30),
    ("max_order", |p| &mut p.max_order, 12),
    ("roll_range", |p| &mut p.roll_range, 180),
];

impl Page<'_, '_> {
    /// The edit that gives the tree another likeness.
    fn edit(&self, likeness: Likeness) -> crate::world::document::Edit {
        let document = self.view.document;
        let mut models = document.models.to_vec();
        if let Some(model) = models.get_mut(self.at) {
            model.likeness = Some(likeness);
        }
        arrange(document, models, document.linked)
    }

    fn with(&self, set: impl FnOnce(&mut Params)) -> Likeness {
        let mut likeness = self.likeness.clone();
        set(Arc::make_mut(&mut likeness.params));
        // Trees of other numbers may be done sooner.
        let last = f64::from(likeness.last());
        likeness.moment = likeness.moment.map(|moment| moment.min(last));
        likeness
    }

    fn change(&mut self, set: impl FnOnce(&mut Params)) {
        let edit = self.edit(self.with(set));
        self.wishes.push(Wish::Edit(edit));
    }

    /// A number that is slid or dragged: one edit when the hand lets go.
    fn number(&mut self, answer: &Response, set: impl FnOnce(&mut Params)) {
        let to = answer.changed().then(|| self.with(set));
        self.try_out(answer, to);
    }

    fn try_out(&mut self, answer: &Response, to: Option<Likeness>) {
        if let Some(likeness) = to {
            let edit = self.edit(likeness);
            self.wishes.push(Wish::TryOut(edit));
        }
        if answer.drag_stopped() || (answer.changed() && !answer.dragged()) {
            self.wishes.push(Wish::Settle);
        }
    }

    /// How far it has grown: step by step, on and back, and all between.
    fn moment(&mut self, ui: &mut Ui, words: &Words) {
        let last = f64::from(self.likeness.last());
        let now = self.likeness.moment.unwrap_or(last);
        let to = |moment: f64| Likeness {
            moment: Some(moment.clamp(0.0, last)).filter(|moment| *moment < last),
            ..self.likeness.clone()
        };
        let (back, on) = (to(now.ceil() - 1.0), to(now.floor() + 1.0));
        let mut moment = now;
        let plays = self.view.world.grows_on(self.at);
        ui.horizontal_wrapped(|ui| {
            for (name, likeness, can) in
                [(words.back, back, now > 0.0), (words.grow, on, now < last)]
            {
                if ui.add_enabled(can, Button::new(name)).clicked() {
                    let edit = self.edit(likeness);
                    self.wishes.push(Wish::Edit(edit));
                }
            }
            let name = if plays { words.pause } else { words.play };
            if ui.button(name).clicked() {
                let wish = AbstractionWish::Grow(self.at, !plays);
                self.wishes.push(Wish::Abstraction(wish));
            }
        });
        let slider = Slider::new(&mut moment, 0.0..=last)
            .clamping(SliderClamping::Edits)
            .max_decimals(1)
            .text(words.iterations);
        let answer = ui.add(slider);
        let to = answer.changed().then(|| to(moment));
        self.try_out(&answer, to);
    }

    /// What lengths, radii and angles of each order are multiplied by.
    fn by_order(&mut self, ui: &mut Ui) {
        let params = Arc::clone(&self.likeness.params);
        let words = self.view.settings.language.words();
        let orders = ByOrder::ALL.map(|of| of.factors(&params).len());
        let orders = orders.into_iter().max().unwrap_or(0);
        ui.horizontal_wrapped(|ui| {
            ui.label(words.by_order);
            let more = ui.add_enabled(orders < ORDERS_MOST, Button::new(words.one_more));
            let less = ui.add_enabled(orders > 0, Button::new(words.one_less));
            let to = orders + usize::from(more.clicked()) - usize::from(less.clicked());
            if to != orders {
                self.change(|params| {
                    for of in ByOrder::ALL {
                        let factors = of.factors_mut(params);
                        // A new order begins as the one before it.
                        let last = factors.last().copied().unwrap_or(1.0);
                        factors.resize(to, last);
                    }
                });
            }
        });
        for order in 0..orders {
            ui.horizontal(|ui| {
                ui.label(order.to_string());
                for of in ByOrder::ALL {
                    // The stem leaves no fork.
                    let Some(factor) = of.factors(&params).get(order).copied() else {
                        continue;
                    };
                    if order == 0 && of == ByOrder::Angle {
                        continue;
                    }
                    let mut to = factor;
                    let value = DragValue::new(&mut to).range(0.001..=1000.0).speed(0.01);
                    let answer = ui.add(value.max_decimals(2));
                    self.number(&answer, |params| of.factors_mut(params)[order] = to);
                }
            });
        }
    }

    fn sliders(&mut self, ui: &mut Ui) {
        let mut params = Params::clone(&self.likeness.params);
        for (name, of, [least, most]) in NUMBERS {
            let number = of(&mut params);
            let slider = Slider::new(number, least..=most)
                .clamping(SliderClamping::Edits)
                .max_decimals(2)
                .text(name);
            let answer = ui.add(slider);
            let to = *number;
            self.number(&answer, |params| *of(params) = to);
        }
        for (name, of, most) in WHOLE {
            let number = of(&mut params);
            let slider = Slider::new(number, 0..=most);
            let answer = ui.add(slider.clamping(SliderClamping::Edits).text(name));
            let to = *number;
            self.number(&answer, |params| *of(params) = to);
        }
        for (name, of) in LENGTHS {
            ui.horizontal(|ui| {
                let number = of(&mut params);
                let least = if name == "segment_length_std" {
                    0.0
                } else {
                    1e-6
                };
                let least = if name == "radial_increment" {
                    -1e6
                } else {
                    least
                };
                let speed = 0.01 * number.abs().max(1e-3);
                let value = DragValue::new(number)
                    .range(least..=1e6)
                    .clamp_existing_to_range(false)
                    .speed(speed);
                let answer = ui.add(value);
                ui.label(name);
                let to = *number;
                self.number(&answer, |params| *of(params) = to);
            });
        }
        self.by_order(ui);
        let mut around = params.around;
        if ui.checkbox(&mut around, "around").changed() {
            self.change(|params| params.around = around);
        }
    }

    /// What is left out: what runs into the tree, and what leaves an ellipsoid.
    fn pruning(&mut self, ui: &mut Ui, words: &Words) {
        let params = Arc::clone(&self.likeness.params);
        let mut prunes = params.prune_intersections;
        if ui.checkbox(&mut prunes, words.no_intersections).changed() {
            self.change(|params| params.prune_intersections = prunes);
        }
        let mut within = params.bounding_ellipsoid.is_some();
        if ui.checkbox(&mut within, words.within_ellipsoid).changed() {
            // About the size of the tree.
            let length =
                params.segment_length * (f64::from(params.stem_length) + params.iterations);
            let radii = [0.5, 0.8, 0.5].map(|part| part * length);
            self.change(|params| params.bounding_ellipsoid = within.then_some(radii));
        }
        if let Some(radii) = params.bounding_ellipsoid {
            ui.horizontal(|ui| {
                for (axis, radius) in radii.into_iter().enumerate() {
                    let mut to = radius;
                    let value = DragValue::new(&mut to)
                        .range(1e-6..=1e6)
                        .speed(0.01 * radius);
                    let answer = ui.add(value);
                    let mut changed = radii;
                    changed[axis] = to;
                    self.number(&answer, |params| params.bounding_ellipsoid = Some(changed));
                }
            });
        }
    }
}

/// Trees that need no scan.
pub(super) fn plant(ui: &mut Ui, words: &Words, wishes: &mut Vec<Wish>) {
    ui.label(
        RichText::new(words.trees_of_numbers)
            .color(TITLE)
            .size(TITLE_SIZE),
    );
    ui.horizontal_wrapped(|ui| {
        for (place, preset) in presets().iter().enumerate() {
            if ui.button(preset.name).clicked() {
                wishes.push(Wish::Abstraction(AbstractionWish::Plant(place)));
            }
        }
    });
}
