//! All panels that are used, together: who is looked at, and what is wanted.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{RichText, Ui};

use super::{
    LayoutParams, Painted,
    bench::Bench,
    keyboard::Keyboard,
    previews::{MANY as SEEDS, Previews},
    sheet::{Sheet, Tick},
    study::Pictures,
    theme::{PAPER, TITLE},
    words::{Language, Words},
};
use crate::{
    sketch::Sketch,
    tree::foliage::Bare,
    world::{
        DrawSettings, World,
        board::Buttons,
        comparing::{Overlay, Subject},
        document::{Document, Edit},
        grove::Grove,
        handles::Says,
        lesson::Lesson,
        marks::Mark,
        model::Model,
        models::Looking,
        panels::{PanelId, PanelPointer},
        room::{Quality, RoomSettings},
        scene::weather::{Light, Wind},
        study::flow::{Event, Study},
    },
};

/// What a person has set about the room; it belongs to the person, not to a project.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Of the panels.
    pub language: Language,
    /// In the room.
    pub room: RoomSettings,
    /// Whether a headset's runtime shows the panels by itself, where it can: their text is sharper so.
    pub layers: bool,
    /// How finely everything is drawn.
    pub quality: Quality,
    /// Whether a headset's pictures have all their pixels even where the device is late with them; otherwise fewer then.
    pub sharp: bool,
    /// By what everything is lit.
    pub light: Light,
    /// How it blows; not at all until it is asked for.
    pub wind: Wind,
    /// How far they have come in the tutorial: the number of the next lesson.
    pub lesson: usize,
}

/// A small picture, as many pixels wide as high.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thumbnail {
    /// Pixels of a side.
    pub side: usize,
    /// Red, green, blue, alpha of each pixel, row by row.
    pub rgba: Vec<u8>,
}

/// A project that was worked on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recent {
    /// Its file.
    pub project: PathBuf,
    /// What it looked like.
    pub picture: Option<Thumbnail>,
}

/// What a person wants with centerlines; models are told by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineWish {
    /// Light a branch of a model, or none.
    Light(usize, Option<usize>),
    /// Look for those that were not found once more.
    Again(usize),
    /// Stop looking.
    Stop,
    /// Write them beside the project as a file with this ending.
    Write(usize, &'static str),
    /// Take a branch of them into the sketch, or with none all.
    Take(usize, Option<usize>),
}

/// What a person wants with models as L-systems; models are told by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AbstractionWish {
    /// Look for trees like a model, with a seed.
    Find(usize, u64),
    /// Stop looking for those.
    Stop(usize),
    /// Stand the tree of this place in the list beside its model.
    Stand(usize, usize),
    /// Stand a tree of the preset with this number there.
    Plant(usize),
    /// Let a tree grow on by itself, or not.
    Grow(usize, bool),
    /// Write a tree beside the project as a file with this ending.
    Write(usize, &'static str),
}

/// What a person wants with trees that are compared; models are told by their numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompareWish {
    /// Compare a model with these; with none not at all.
    With(usize, Vec<Subject>),
    /// Lay the others over it so.
    LayOver(Overlay),
}

/// What a person wants; the application carries it out.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Do this.
    Edit(Edit),
    /// Show how it would be.
    TryOut(Edit),
    /// Make edits of what is shown.
    Settle,
    /// Undo the last edit.
    Undo,
    /// Redo the last edit undone.
    Redo,
    /// Grow by so many steps, or back.
    Step(i32),
    /// Start or end playback.
    Play(bool),
    /// Steps a second.
    Speed(f64),
    /// Show the tree at a moment, steps.
    Scrub(f64),
    /// Show or hide a panel.
    Show(PanelId, bool),
    /// Set the room.
    Set(Settings),
    /// Take the tree home as a file with this ending.
    Export(&'static str),
    /// Save this project and go on with that one.
    Open(PathBuf),
    /// Begin anew with the sketch of another project.
    TakeSketch(PathBuf),
    /// Draw like this.
    Draw(DrawSettings),
    /// Bring a scanned model onto the stage, by its file as the project names it.
    Bring(String),
    /// Look at models like this.
    Look(Looking),
    /// Do this with endpoints, proposals and measures.
    Mark(Mark),
    /// Write a model's endpoints beside the project, as `csv` or `json`.
    WriteEnds(usize, &'static str),
    /// Take a model's endpoints from a file, as the project names it.
    ReadEnds(usize, String),
    /// Do this with a model's centerlines.
    Line(LineWish),
    /// Do this with models as L-systems.
    Abstraction(AbstractionWish),
    /// Do this with trees that are compared.
    Compare(CompareWish),
    /// Stop the reading of a model.
    StopReading,
    /// Look again which models lie beside the project, and try again those that could not be read.
    FindModels,
    /// Go to a lesson of the tutorial, or end it.
    Teach(Option<usize>),
    /// Do this in the sitting of a study.
    Study(Event),
}

/// What the panels show.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// As it is seen, with what is tried out.
    pub document: &'a Document,
    /// How far the tree has grown, steps.
    pub moment: f64,
    /// Whether it plays.
    pub playing: bool,
    /// Steps a second.
    pub speed: f64,
    /// How many edits can be undone and redone.
    pub undo: [usize; 2],
    /// Whether the bench is there.
    pub bench: bool,
    /// How drawing acts.
    pub draw: DrawSettings,
    /// The lesson that is going on, and its number from 0.
    pub lesson: Option<(usize, Lesson)>,
    /// What people call the parts of the controllers in hand.
    pub buttons: &'a Buttons,
    /// What is said beside a handle.
    pub says: Option<Says>,
    /// To ask it what it knows of models.
    pub world: &'a World,
    /// The person's.
    pub settings: Settings,
}

impl<'a> View<'a> {
    /// What a world shows.
    #[must_use]
    pub fn of(world: &'a World, settings: Settings) -> Self {
        Self {
            document: world.shown(),
            moment: world.moment(),
            playing: world.is_playing(),
            speed: world.speed(),
            undo: [world.undo_count(), world.history().redo_count()],
            bench: world.has_panel(PanelId::Bench),
            draw: world.settings(),
            lesson: world.lesson(),
            buttons: world.buttons(),
            says: world.says(),
            world,
            settings,
        }
    }

    fn key(&self) -> Key {
        // A moment is shown in twentieths: more is not seen, and costs a look each time.
        const PARTS: f64 = 20.0;
        Key {
            sketch: Arc::clone(&self.document.sketch),
            models: Arc::clone(&self.document.models),
            linked: self.document.linked,
            grove: Arc::clone(&self.document.grove),
            read: self.world.model_changes(),
            reading: self.world.reading().map(|reading| reading.percent),
            finding: self.world.finding().map(|finding| finding.percent),
            looking: self.world.looking(),
            step: self.document.step,
            bare: self.world.bare().to_vec(),
            moment: (self.moment * PARTS).round(),
            seen: Seen {
                playing: self.playing,
                speed: self.speed,
                undo: self.undo,
                bench: self.bench,
                lesson: self.lesson,
                draw: self.draw,
                settings: self.settings,
            },
        }
    }
}

/// What the panels showed last.
struct Key {
    sketch: Arc<Sketch>,
    models: Arc<Vec<Model>>,
    linked: bool,
    grove: Arc<Grove>,
    /// How often models were read.
    read: u64,
    /// How far the reading of one is.
    reading: Option<u32>,
    /// How far the search for centerlines is.
    finding: Option<u32>,
    looking: Looking,
    step: u32,
    /// What the tree should bear and does not.
    bare: Vec<Bare>,
    moment: f64,
    seen: Seen,
}

/// What all of them show; the rest is on the bench alone, and changes with every frame that moves a node or plays the tree.
#[derive(PartialEq)]
struct Seen {
    playing: bool,
    speed: f64,
    undo: [usize; 2],
    bench: bool,
    lesson: Option<(usize, Lesson)>,
    draw: DrawSettings,
    settings: Settings,
}

impl Key {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.sketch, &other.sketch)
            && Arc::ptr_eq(&self.models, &other.models)
            && Arc::ptr_eq(&self.grove, &other.grove)
            && (self.linked, self.read, self.looking) == (other.linked, other.read, other.looking)
            && (self.reading, self.finding) == (other.reading, other.finding)
            && (self.step, self.moment) == (other.step, other.moment)
            && self.bare == other.bare
            && self.seen == other.seen
    }
}

/// See the module.
pub struct Panels {
    sheets: [Sheet; 6],
    shown: Option<Key>,
    said: Option<(Option<Says>, Language)>,
    buttons: Option<Buttons>,
    /// Which panels were there when they were looked at last.
    there: [bool; 6],
    bench: Bench,
    /// What the sitting of a study showed last.
    study: Option<u64>,
    pictures: Pictures,
    /// No picture is drawn.
    is_unseen: bool,
    keyboard: Keyboard,
    typed: Vec<egui::Event>,
    wishes: Vec<Wish>,
    ticks: Vec<(usize, Tick)>,
}

impl Panels {
    /// Panels of a world's sizes.
    #[must_use]
    pub fn new(world: &World) -> Self {
        let sheet = |id| Sheet::new(world.panel_size(id), LayoutParams::default());
        Self {
            sheets: PanelId::ALL.map(sheet),
            shown: None,
            said: None,
            buttons: None,
            there: [false; 6],
            bench: Bench::default(),
            study: None,
            pictures: Pictures::default(),
            is_unseen: false,
            keyboard: Keyboard::default(),
            typed: Vec::new(),
            wishes: Vec::new(),
            ticks: Vec::new(),
        }
    }

    /// Says that no picture is drawn.
    pub fn unseen(&mut self) {
        self.sheets.iter_mut().for_each(Sheet::unseen);
        self.is_unseen = true;
    }

    /// The picture is made anew: all is laid out and painted again. Tabs, and a rule that is being written, stay.
    pub fn show_anew(&mut self) {
        self.sheets
            .iter_mut()
            .for_each(|sheet| *sheet = sheet.anew());
        (self.shown, self.said, self.buttons) = (None, None, None);
        self.there = [false; 6];
        self.pictures.load_anew();
        self.bench.load_anew();
        self.typed.clear();
    }

    /// Offers projects to go on with.
    pub fn offer(&mut self, recent: Vec<Recent>) {
        self.bench.offer(recent);
        self.shown = None;
    }

    /// Gives the pictures of the individuals that are looked at.
    pub fn give_previews(&mut self, given: Previews) {
        self.bench.give_previews(given);
        self.shown = None;
    }

    /// The seeds of the individuals that somebody looks at, whose pictures are wanted.
    #[must_use]
    pub fn seeds_shown(&self) -> Option<[u32; SEEDS]> {
        let is_there = self.there[PanelId::Bench as usize] && !self.is_unseen;
        is_there.then(|| self.bench.seeds_shown()).flatten()
    }

    /// Gives the pictures of a study's tasks.
    pub fn give_pictures(&mut self, pictures: Vec<Option<Thumbnail>>) {
        self.pictures = Pictures::of(pictures);
        self.study = None;
    }

    /// Offers models to be brought.
    pub fn offer_models(&mut self, files: Vec<String>) {
        self.bench.offer_models(files);
        self.shown = None;
    }

    /// Offers files with endpoints.
    pub fn offer_endpoints(&mut self, files: Vec<String>) {
        self.bench.offer_endpoints(files);
        self.shown = None;
    }

    /// Looks at every panel that changed; gives what is wanted and what hands should feel.
    pub fn look(
        &mut self,
        world: &World,
        settings: Settings,
        seconds: f64,
    ) -> (&mut Vec<Wish>, &[(usize, Tick)]) {
        self.wishes.clear();
        self.ticks.clear();
        let view = View::of(world, settings);
        let key = view.key();
        let shown = self.shown.as_ref();
        let on_bench = !shown.is_some_and(|shown| shown.is(&key));
        let mut changed = !shown.is_some_and(|shown| shown.seen == key.seen);
        if self.buttons.as_ref() != Some(view.buttons) {
            self.buttons = Some(view.buttons.clone());
            changed = true;
        }
        self.shown = Some(key);
        let study = world.study().map(Study::seen);
        let in_study = std::mem::replace(&mut self.study, study) != study;
        if !view.bench {
            // Nothing takes text that nobody sees.
            self.typed.clear();
            if world.has_panel(PanelId::Keyboard) {
                self.wishes.push(Wish::Show(PanelId::Keyboard, false));
            }
        }
        for id in PanelId::ALL {
            let there = world.has_panel(id);
            let was_there = std::mem::replace(&mut self.there[id as usize], there);
            let came = there && !was_there;
            let pointer = world.pointer(id).filter(|_| there);
            let other =
                changed || (id == PanelId::Bench && on_bench) || (id == PanelId::Study && in_study);
            if there {
                self.look_at(id, &view, pointer, seconds, other || came);
            }
        }
        (&mut self.wishes, &self.ticks)
    }

    fn look_at(
        &mut self,
        id: PanelId,
        view: &View<'_>,
        pointer: Option<PanelPointer>,
        seconds: f64,
        changed: bool,
    ) {
        let words = view.settings.language.words();
        let [bench, wrist, keyboard, label, lesson, study] = &mut self.sheets;
        let wishes = &mut self.wishes;
        let looked = match id {
            PanelId::Bench => {
                self.typed.drain(..).for_each(|key| bench.type_in(key));
                let looked = bench.look(pointer, seconds, changed, |ui| {
                    self.bench.show(ui, view, wishes);
                });
                if looked.wants_keys != self.there[PanelId::Keyboard as usize] {
                    wishes.push(Wish::Show(PanelId::Keyboard, looked.wants_keys));
                }
                looked
            }
            PanelId::Wrist => wrist.look(pointer, seconds, changed, |ui| {
                show_wrist(ui, view, words, wishes);
            }),
            PanelId::Keyboard => {
                let typed = &mut self.typed;
                keyboard.look(pointer, seconds, changed, |ui| {
                    if self.keyboard.show(ui, words, typed) {
                        typed.push(escape());
                    }
                })
            }
            PanelId::Label => {
                let says = Some((view.says, view.settings.language));
                let other = std::mem::replace(&mut self.said, says) != says;
                label.look(None, seconds, other, |ui| show_label(ui, view, words))
            }
            PanelId::Lesson => lesson.look(pointer, seconds, changed, |ui| {
                super::lesson::show(ui, view, wishes);
            }),
            PanelId::Study => study.look(pointer, seconds, changed, |ui| {
                super::study::show(ui, view, &mut self.pictures, wishes);
            }),
        };
        self.ticks.extend(looked.tick);
    }

    /// Keeps where texts stand from now on.
    pub fn keep_texts(&mut self) {
        self.sheets.iter_mut().for_each(Sheet::keep_texts);
        self.shown = None;
    }

    /// Where the n-th text (from 1) that is this one stands on a panel, metres right of and below its upper left corner.
    #[must_use]
    pub fn find_text(&self, id: PanelId, text: &str, nth: usize) -> Option<glam::Vec2> {
        self.sheets[id as usize].find_text(text, nth)
    }

    /// The texts on a panel, where they are kept.
    pub fn texts(&self, id: PanelId) -> impl Iterator<Item = &str> {
        self.sheets[id as usize].texts()
    }

    /// What is to be painted, with its slot, where it changed since it was taken last.
    pub fn take_painted(&mut self) -> impl Iterator<Item = (usize, Painted)> {
        let sheets = PanelId::ALL.into_iter().zip(&mut self.sheets);
        sheets.filter_map(|(id, sheet)| Some((id.slot(), sheet.take_painted()?)))
    }
}

/// Ends typing.
fn escape() -> egui::Event {
    egui::Event::Key {
        key: egui::Key::Escape,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: egui::Modifiers::NONE,
    }
}

/// The few things on the back of a hand.
fn show_wrist(ui: &mut Ui, view: &View<'_>, words: &Words, wishes: &mut Vec<Wish>) {
    let frame = egui::Frame::new().fill(PAPER).inner_margin(6.0);
    egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        let [undo, redo] = view.undo;
        let bench = if view.bench { words.hide } else { words.bench };
        let play = if view.playing {
            words.pause
        } else {
            words.play
        };
        let parts = [
            (bench, true, Wish::Show(PanelId::Bench, !view.bench)),
            (play, true, Wish::Play(!view.playing)),
            (words.undo, undo > 0, Wish::Undo),
            (words.redo, redo > 0, Wish::Redo),
        ];
        for (name, can, wish) in parts {
            let button = egui::Button::new(name).min_size(egui::vec2(86.0, 0.0));
            if ui.add_enabled(can, button).clicked() {
                wishes.push(wish);
            }
        }
    });
}

/// The line beside a handle.
fn show_label(ui: &mut Ui, view: &View<'_>, words: &Words) {
    let text = match view.says {
        Some(Says::End { model, at }) => {
            let end = view
                .document
                .models
                .get(model)
                .and_then(|model| model.endpoints.get(at));
            end.map(|end| end.name.clone()).unwrap_or_default()
        }
        Some(Says::Branch { model, branch }) => {
            super::lines::said(view, words, model, branch).unwrap_or_default()
        }
        Some(Says::Divergence(degrees)) => format!("{} {degrees:.3}°", words.say_divergence),
        Some(Says::Moment(moment)) => format!("{} {moment:.1}", words.say_moment),
        Some(Says::Clear) => words.say_clear.to_owned(),
        Some(Says::ClearAgain) => words.say_clear_again.to_owned(),
        None => String::new(),
    };
    let frame = egui::Frame::new().fill(PAPER).inner_margin(2.0);
    egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        ui.centered_and_justified(|ui| ui.label(RichText::new(text).color(TITLE).size(15.0)));
    });
}
