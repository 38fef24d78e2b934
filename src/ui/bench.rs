//! The bench: a panel with everything that can be set, in tabs.

use egui::{Button, DragValue, RichText, ScrollArea, Slider, SliderClamping, Ui};

use super::{
    models::Models,
    panels::{Recent, View, Wish},
    planting,
    previews::{MANY as SEEDS, Previews},
    projects::Projects,
    rules::Rules,
    species::SpeciesTab,
    theme::{MESSAGE, PAPER, TITLE},
    words::{Language, Words},
};
use crate::{
    sketch::{BOUNDS, GOLDEN_DEG, Letter, SelfSimilar, Stroke, Wrap},
    world::{
        DrawSettings, DrawTool,
        document::Edit,
        lesson::Lesson,
        panels::PanelId,
        room::Quality,
        scene::weather::{Light, Wind},
    },
};

/// Tabs of the bench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    #[default]
    Grow,
    Draw,
    Shape,
    Letters,
    Rules,
    Models,
    Room,
    File,
    Species,
}

/// What the bench remembers between looks.
#[derive(Default)]
pub(super) struct Bench {
    tab: Tab,
    /// It asks whether the sketch is really to be cleared, or the planted trees uprooted.
    asks: bool,
    /// The largest moment of the growth slider while it is dragged: its end must not run from the hand.
    furthest: Option<f64>,
    rules: Rules,
    projects: Projects,
    models: Models,
    species: SpeciesTab,
}

/// The files that a tree can be taken home as, by their endings.
const EXPORTS: [&str; 6] = ["glb", "usda", "ply", "obj", "swc", "lsys"];

/// Turns from branch to branch that plants are known for, degrees.
const ANGLES: [f64; 4] = [GOLDEN_DEG, 180.0, 120.0, 90.0];

/// The angle that drawing snaps to when that is switched on, degrees.
const ANGLE_DEG: f32 = 15.0;

/// A bench being laid out: what it shows, and what is wanted.
struct Page<'a> {
    view: &'a View<'a>,
    words: &'static Words,
    wishes: &'a mut Vec<Wish>,
}

impl Bench {
    /// Offers projects to go on with.
    pub(super) fn offer(&mut self, recent: Vec<Recent>) {
        self.species.offer(recent.clone());
        self.projects = Projects::of(recent);
    }

    /// Takes pictures of individuals.
    pub(super) fn give_previews(&mut self, given: Previews) {
        self.species.row.give(given);
    }

    /// The seeds of the individuals that are looked at, if the tab with them is open.
    pub(super) fn seeds_shown(&self) -> Option<[u32; SEEDS]> {
        let is_open = self.tab == Tab::Species;
        self.species.row.seeds().filter(|_| is_open)
    }

    /// Pictures are given to another egui with the next look.
    pub(super) fn load_anew(&mut self) {
        self.species.load_anew();
    }

    /// Offers models to be brought.
    pub(super) fn offer_models(&mut self, files: Vec<String>) {
        self.models.offer(files);
    }

    /// Offers files with endpoints.
    pub(super) fn offer_endpoints(&mut self, files: Vec<String>) {
        self.models.offer_endpoints(files);
    }

    /// Lays the bench out.
    pub(super) fn show(&mut self, ui: &mut Ui, view: &View<'_>, wishes: &mut Vec<Wish>) {
        let words = view.settings.language.words();
        let frame = egui::Frame::new().fill(PAPER).inner_margin(12.0);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let tabs = [
                    (Tab::Grow, words.tab_grow),
                    (Tab::Draw, words.tab_draw),
                    (Tab::Shape, words.tab_shape),
                    (Tab::Letters, words.tab_letters),
                    (Tab::Rules, words.tab_rules),
                    (Tab::Room, words.tab_room),
                    (Tab::File, words.tab_file),
                    // The last one, so that sessions that were recorded without it press what they pressed.
                    (Tab::Models, words.tab_models),
                    (Tab::Species, words.tab_species),
                ];
                for (tab, name) in tabs {
                    if ui.selectable_label(self.tab == tab, name).clicked() {
                        self.tab = tab;
                        self.asks = false;
                    }
                }
            });
            ui.separator();
            let mut page = Page {
                view,
                words,
                wishes,
            };
            ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| match self.tab {
                    Tab::Grow => self.grow(ui, &mut page),
                    Tab::Draw => page.draw(ui, &mut self.asks),
                    Tab::Shape => page.shape(ui),
                    Tab::Letters => page.letters(ui),
                    Tab::Rules => self.rules.show(ui, page.view, page.wishes),
                    Tab::Models => self.models.show(ui, page.view, page.words, page.wishes),
                    Tab::Species => self.species.show(ui, page.view, page.words, page.wishes),
                    Tab::Room => page.room(ui),
                    Tab::File => {
                        page.file(ui);
                        ui.separator();
                        self.projects.show(ui, page.words, page.wishes);
                    }
                });
        });
    }

    fn grow(&mut self, ui: &mut Ui, page: &mut Page<'_>) {
        let (words, view) = (page.words, page.view);
        page.moment(ui, &mut self.furthest);
        ui.horizontal(|ui| {
            if ui.button(words.back).clicked() {
                page.wishes.push(Wish::Step(-1));
            }
            if ui.button(words.grow).clicked() {
                page.wishes.push(Wish::Step(1));
            }
            let play = if view.playing {
                words.pause
            } else {
                words.play
            };
            if ui.button(play).clicked() {
                page.wishes.push(Wish::Play(!view.playing));
            }
        });
        let mut speed = view.speed;
        ui.label(words.speed);
        let slider = Slider::new(&mut speed, 0.1..=10.0)
            .clamping(SliderClamping::Edits)
            .logarithmic(true)
            .max_decimals(1)
            .suffix(format!(" {}", words.steps_a_second));
        if ui.add(slider).changed() {
            page.wishes.push(Wish::Speed(speed));
        }
        ui.separator();
        let [undo, redo] = view.undo;
        ui.horizontal(|ui| {
            let back = Button::new(format!("{} ({undo})", words.undo));
            if ui.add_enabled(undo > 0, back).clicked() {
                page.wishes.push(Wish::Undo);
            }
            let again = Button::new(format!("{} ({redo})", words.redo));
            if ui.add_enabled(redo > 0, again).clicked() {
                page.wishes.push(Wish::Redo);
            }
        });
        ui.separator();
        self.clear(ui, page);
    }

    /// Clears the sketch, when it is asked twice.
    fn clear(&mut self, ui: &mut Ui, page: &mut Page<'_>) {
        let words = page.words;
        let drawn = !page.view.document.sketch.is_empty();
        self.asks &= drawn;
        if !self.asks {
            self.asks = ui.add_enabled(drawn, Button::new(words.clear)).clicked();
            return;
        }
        ui.horizontal(|ui| {
            if ui
                .button(RichText::new(words.really_clear).color(MESSAGE))
                .clicked()
            {
                page.wishes.push(Wish::Edit(Edit::Clear));
                self.asks = false;
            }
            if ui.button(words.keep).clicked() {
                self.asks = false;
            }
        });
    }
}

impl Page<'_> {
    fn heading(&self, ui: &mut Ui, text: &str) {
        ui.label(RichText::new(text).color(TITLE).size(18.0));
    }

    /// The growth slider: reaches some steps beyond where the tree is, as far as steps go.
    fn moment(&mut self, ui: &mut Ui, furthest: &mut Option<f64>) {
        const AHEAD: f64 = 10.0;
        let mut moment = self.view.moment;
        let ahead = (moment + AHEAD)
            .max(2.0 * AHEAD)
            .min(f64::from(BOUNDS.step));
        let most = furthest.unwrap_or(ahead);
        let slider = Slider::new(&mut moment, 0.0..=most)
            .clamping(SliderClamping::Edits)
            .max_decimals(2)
            .text(self.words.step);
        let answer = ui.add(slider);
        *furthest = answer.dragged().then_some(most);
        if answer.changed() {
            self.wishes.push(Wish::Scrub(moment));
        }
        self.settle_after(&answer);
    }

    /// A change is one edit when the hand lets go.
    fn settle_after(&mut self, answer: &egui::Response) {
        if answer.drag_stopped() || (answer.changed() && !answer.dragged()) {
            self.wishes.push(Wish::Settle);
        }
    }

    /// A slider for a number of the document.
    fn number(&mut self, ui: &mut Ui, name: &str, slider: Slider<'_>, edit: impl FnOnce() -> Edit) {
        ui.label(name);
        let answer = ui.add(slider);
        if answer.changed() {
            self.wishes.push(Wish::TryOut(edit()));
        }
        self.settle_after(&answer);
    }

    /// Pen, eraser and planting, free-hand strokes, snapping and symmetry.
    fn draw(&mut self, ui: &mut Ui, asks: &mut bool) {
        let (words, mut draw) = (self.words, self.view.draw);
        ui.horizontal(|ui| {
            ui.selectable_value(&mut draw.tool, DrawTool::Draw, words.pen);
            ui.selectable_value(&mut draw.tool, DrawTool::Erase, words.eraser);
            ui.selectable_value(&mut draw.tool, DrawTool::Plant, words.planter);
        });
        ui.separator();
        if self.view.draw.tool == DrawTool::Plant {
            let edit = planting::show(ui, self.view, words, &mut draw, asks);
            self.wishes.extend(edit.map(Wish::Edit));
            if draw != self.view.draw {
                self.wishes.push(Wish::Draw(draw));
            }
            return;
        }
        let lengths = [
            (&mut draw.spacing, words.spacing, DrawSettings::SPACING),
            (
                &mut draw.tolerance,
                words.tolerance,
                DrawSettings::TOLERANCE,
            ),
        ];
        for (metres, name, [least, most]) in lengths {
            ui.label(name);
            let mut millimetres = *metres * 1000.0;
            let slider = Slider::new(&mut millimetres, least * 1000.0..=most * 1000.0)
                .clamping(SliderClamping::Edits)
                .max_decimals(0)
                .suffix(words.millimetres);
            if ui.add(slider).changed() {
                *metres = millimetres / 1000.0;
            }
        }
        ui.label(words.smoothing);
        let slider = Slider::new(&mut draw.smoothing, 0.0..=1.0);
        ui.add(slider.clamping(SliderClamping::Edits).max_decimals(2));
        ui.separator();
        let mut snaps = draw.snap_angle_deg.is_some();
        ui.checkbox(&mut snaps, words.snap_angle);
        let angle = draw.snap_angle_deg.unwrap_or(ANGLE_DEG);
        draw.snap_angle_deg = snaps.then_some(angle);
        if let Some(angle) = &mut draw.snap_angle_deg {
            let [least, most] = DrawSettings::SNAP_ANGLE_DEG;
            let slider = Slider::new(angle, least..=most).step_by(5.0).suffix("°");
            ui.add(slider.clamping(SliderClamping::Edits));
        }
        ui.checkbox(&mut draw.snap_mirror, words.snap_mirror);
        ui.separator();
        ui.checkbox(&mut draw.mirror_symmetry, words.mirror_symmetry);
        ui.label(words.symmetry);
        let slider = Slider::new(&mut draw.symmetry, 1..=16);
        ui.add(slider.clamping(SliderClamping::Edits));
        if draw != self.view.draw {
            self.wishes.push(Wish::Draw(draw));
        }
    }

    fn shape(&mut self, ui: &mut Ui) {
        let (words, sketch) = (self.words, &self.view.document.sketch);
        let degrees = std::cell::Cell::new(sketch.divergence_deg);
        let slider = Slider::from_get_set(0.0..=360.0, |new| {
            degrees.set(new.unwrap_or(degrees.get()));
            degrees.get()
        });
        self.number(
            ui,
            words.divergence,
            slider
                .clamping(SliderClamping::Edits)
                .suffix("°")
                .max_decimals(3),
            || Edit::SetDivergence {
                degrees: degrees.get(),
            },
        );
        ui.horizontal_wrapped(|ui| {
            let names = [words.golden, words.alternate, words.thirds, words.opposite];
            for (degrees, name) in ANGLES.into_iter().zip(names) {
                let chosen = sketch.divergence_deg == degrees;
                if ui.selectable_label(chosen, name).clicked() && !chosen {
                    self.wishes
                        .push(Wish::Edit(Edit::SetDivergence { degrees }));
                }
            }
        });
        ui.separator();
        self.sizes(ui);
        ui.separator();
        ui.label(words.wrap);
        for (wrap, name) in [
            (Wrap::CarryHeading, words.wrap_carry),
            (Wrap::Restart, words.wrap_restart),
        ] {
            if ui.radio(sketch.wrap == wrap, name).clicked() && sketch.wrap != wrap {
                self.wishes.push(Wish::Edit(Edit::SetWrap { to: wrap }));
            }
        }
    }

    fn sizes(&mut self, ui: &mut Ui) {
        use std::cell::Cell;
        let (words, sketch) = (self.words, &self.view.document.sketch);
        let sizes = [
            sketch.scale,
            sketch.tip_radius * 1000.0,
            sketch.radius_exponent,
        ]
        .map(Cell::new);
        let edit = || Edit::SetSizes {
            scale: sizes[0].get(),
            tip_radius: sizes[1].get() / 1000.0,
            radius_exponent: sizes[2].get(),
        };
        let [least_tip, most_tip] = BOUNDS.tip_radius.map(|metres| metres * 1000.0);
        let ranges = [BOUNDS.scale, [least_tip, most_tip], BOUNDS.radius_exponent];
        let names = [words.scale, words.tip_radius, words.radius_exponent];
        let units = [" ×", words.millimetres, ""];
        for (at, size) in sizes.iter().enumerate() {
            let [least, most] = ranges[at].map(f64::from);
            let slider = Slider::from_get_set(least..=most, |new| {
                if let Some(new) = new {
                    #[expect(clippy::cast_possible_truncation, reason = "sizes are f32")]
                    size.set(new as f32);
                }
                f64::from(size.get())
            });
            let slider = slider
                .clamping(SliderClamping::Edits)
                .logarithmic(at < 2)
                .suffix(units[at])
                .max_decimals(2);
            self.number(ui, names[at], slider, edit);
        }
    }

    fn letters(&mut self, ui: &mut Ui) {
        let (words, sketch) = (self.words, &self.view.document.sketch);
        let mut on = sketch.self_similar_branches;
        if ui.checkbox(&mut on, words.new_branches).clicked() {
            self.wishes
                .push(Wish::Edit(Edit::SetSelfSimilarBranches { on }));
        }
        if sketch.is_empty() {
            ui.label(words.nothing_drawn);
            return;
        }
        for stroke in &sketch.strokes {
            ui.separator();
            ui.push_id(stroke.letter.index(), |ui| self.letter(ui, stroke));
        }
    }

    /// One line: its name, where it hangs, and how it branches from itself.
    fn letter(&mut self, ui: &mut Ui, stroke: &Stroke) {
        let (words, letter) = (self.words, stroke.letter);
        let place = match stroke.attachment {
            None => words.trunk.to_owned(),
            Some(at) => format!("{} {} {}", at.letter, words.branch_at, at.node),
        };
        ui.label(RichText::new(format!("{} {letter} · {place}", words.letter)).color(TITLE));
        if !stroke.radii.is_empty() {
            let mut thick = true;
            if ui.checkbox(&mut thick, words.own_radii).clicked() {
                self.wishes.push(Wish::Edit(Edit::ForgetRadii { letter }));
            }
        }
        let mut on = stroke.self_similar.is_some();
        if ui.checkbox(&mut on, words.self_similar).clicked() {
            let rate = stroke.attachment.map_or(1, |at| at.node.max(1));
            let own = SelfSimilar {
                rate,
                depth_limit: None,
            };
            self.set_own(letter, on.then_some(own), true);
        }
        let Some(own) = stroke.self_similar else {
            return;
        };
        ui.horizontal(|ui| {
            let mut rate = own.rate;
            ui.label(words.every);
            let answer = ui.add(
                DragValue::new(&mut rate)
                    .range(1..=BOUNDS.points)
                    .speed(0.05)
                    .suffix("."),
            );
            if answer.changed() {
                self.set_own(letter, Some(SelfSimilar { rate, ..own }), false);
            }
            self.settle_after(&answer);
        });
        ui.horizontal(|ui| {
            let mut depth = own.depth_limit.unwrap_or(BOUNDS.depth + 1);
            ui.label(words.depth);
            let value = DragValue::new(&mut depth)
                .range(0..=BOUNDS.depth + 1)
                .speed(0.05)
                .custom_formatter(|depth, _| match depth > f64::from(BOUNDS.depth) {
                    true => words.endless.to_owned(),
                    false => format!("{depth:.0}"),
                });
            let answer = ui.add(value);
            if answer.changed() {
                let depth_limit = (depth <= BOUNDS.depth).then_some(depth);
                self.set_own(letter, Some(SelfSimilar { depth_limit, ..own }), false);
            }
            self.settle_after(&answer);
        });
    }

    fn set_own(&mut self, letter: Letter, to: Option<SelfSimilar>, at_once: bool) {
        let edit = Edit::SetSelfSimilar { letter, to };
        self.wishes.push(match at_once {
            true => Wish::Edit(edit),
            false => Wish::TryOut(edit),
        });
    }

    fn room(&mut self, ui: &mut Ui) {
        let (words, mut settings) = (self.words, self.view.settings);
        ui.horizontal(|ui| {
            for language in Language::ALL {
                let name = language.words().language;
                ui.selectable_value(&mut settings.language, language, name);
            }
            ui.separator();
            ui.label(words.quality);
            for (quality, name) in Quality::ALL.into_iter().zip(words.qualities()) {
                ui.selectable_value(&mut settings.quality, quality, name);
            }
        });
        ui.horizontal(|ui| {
            ui.label(words.light);
            for (light, name) in Light::ALL.into_iter().zip(words.lights()) {
                ui.selectable_value(&mut settings.light, light, name);
            }
        });
        ui.horizontal(|ui| {
            ui.label(words.wind);
            for (wind, name) in Wind::ALL.into_iter().zip(words.winds()) {
                ui.selectable_value(&mut settings.wind, wind, name);
            }
        });
        // All of the page is in sight without scrolling.
        ui.horizontal(|ui| {
            ui.checkbox(&mut settings.layers, words.layers);
            ui.checkbox(&mut settings.sharp, words.sharp);
        });
        let room = &mut settings.room;
        for (on, name) in [
            (&mut room.figure, words.figure),
            (&mut room.turning, words.turning),
            (&mut room.vignette, words.vignette),
            (&mut room.left_handed, words.left_handed),
        ] {
            ui.checkbox(on, name);
        }
        ui.horizontal_wrapped(|ui| {
            ui.label(words.lift);
            ui.spacing_mut().slider_width *= 0.7;
            let slider = Slider::new(&mut room.lift, -0.5..=1.0)
                .clamping(SliderClamping::Edits)
                .max_decimals(2)
                .suffix(" m");
            ui.add(slider);
        });
        if settings != self.view.settings {
            self.wishes.push(Wish::Set(settings));
        }
        ui.separator();
        ui.horizontal(|ui| {
            if ui.button(words.lesson_start).clicked() {
                // Where they stopped, or from the beginning after the last one.
                let next = settings.lesson.saturating_add(1);
                let at = if next < Lesson::ALL.len() {
                    settings.lesson
                } else {
                    0
                };
                self.wishes.push(Wish::Teach(Some(at)));
            }
            let hide = format!("{}: {}", words.bench, words.hide);
            if ui.button(hide).clicked() {
                self.wishes.push(Wish::Show(PanelId::Bench, false));
            }
        });
    }

    fn file(&mut self, ui: &mut Ui) {
        self.heading(ui, self.words.export);
        ui.horizontal_wrapped(|ui| {
            for ending in EXPORTS {
                if ui.button(ending.to_uppercase()).clicked() {
                    self.wishes.push(Wish::Export(ending));
                }
            }
        });
    }
}
