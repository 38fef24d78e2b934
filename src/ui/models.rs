//! The bench's tab for scanned models: which stand on the stage, what they are like, how they are shown, and which can be brought.

use egui::{Button, RichText, Ui};

use super::{
    abstraction::{self, Abstractions},
    compare::Comparisons,
    lines::Table,
    marks::{Marks, legend},
    panels::{View, Wish},
    theme::{MESSAGE, TITLE},
    words::Words,
};
use crate::mesh::colour::fault_colour;
use crate::mesh::mend::{Cap, Close, Debris, Decimate, Mend, Remesh, Smooth, Weld};
use crate::mesh::unit::{Rounded, Unit};
use crate::world::document::{Document, Edit};
use crate::world::model::{Colouring, LoadedModel, Model};
use crate::world::models::{Cut, Looking};
use crate::world::scene::SurfaceLook;

/// See the module.
#[derive(Default)]
pub(super) struct Models {
    offered: Vec<String>,
    /// Which model's page is open.
    chosen: usize,
    part: Part,
    marks: Marks,
    lines: Table,
    abstractions: Abstractions,
    comparisons: Comparisons,
}

/// Parts of a model's page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Part {
    /// How it is shown.
    #[default]
    Look,
    /// What is wrong with it, and mended.
    Mend,
    /// Endpoints and measures.
    Places,
    /// Centerlines.
    Lines,
    /// As an L-system.
    LSystem,
    /// Beside others.
    Compare,
}

/// Size of headings.
pub(super) const TITLE_SIZE: f32 = 18.0;

/// Faults that are listed of a model.
const MOST_FAULTS: usize = 6;

impl Models {
    pub(super) fn offer(&mut self, files: Vec<String>) {
        self.offered = files;
    }

    pub(super) fn offer_endpoints(&mut self, files: Vec<String>) {
        self.marks.offered = files;
    }

    /// Lays the tab out.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        wishes: &mut Vec<Wish>,
    ) {
        let document = view.document;
        self.choose(ui, document);
        if let Some(model) = document.models.get(self.chosen) {
            let mut changed = model.clone();
            let kept = self.page(ui, view, words, &mut changed, wishes);
            let mut models = document.models.to_vec();
            if !kept {
                models.remove(self.chosen);
                wishes.push(Wish::Edit(arrange(document, models, document.linked)));
            } else if changed != *model {
                models[self.chosen] = changed;
                wishes.push(Wish::Edit(arrange(document, models, document.linked)));
            }
            ui.separator();
        }
        self.bring(ui, words, wishes);
        abstraction::plant(ui, words, wishes);
        // The last row: what comes and goes must not move what a hand is about to press.
        if let Some(reading) = view.world.reading() {
            ui.horizontal_wrapped(|ui| {
                let (file, percent) = (file_name(&reading.file), reading.percent);
                ui.label(format!("{} {file}: {percent} %", words.reading));
                if ui.button(words.cancel).clicked() {
                    wishes.push(Wish::StopReading);
                }
            });
        }
    }

    /// One model; false: it is to go.
    fn page(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        model: &mut Model,
        wishes: &mut Vec<Wish>,
    ) -> bool {
        let Some(loaded) = view.world.loaded_model(model) else {
            ui.label(RichText::new(words.model_is_not_there).color(MESSAGE));
            return !ui.button(words.take_away).clicked();
        };
        facts(ui, words, loaded, model);
        for row in [
            [
                (Part::Look, words.part_look),
                (Part::Mend, words.part_mend),
                (Part::Places, words.part_places),
            ],
            [
                (Part::Lines, words.part_lines),
                (Part::LSystem, words.part_lsystem),
                (Part::Compare, words.part_compare),
            ],
        ] {
            ui.horizontal(|ui| {
                for (part, name) in row {
                    ui.selectable_value(&mut self.part, part, name);
                }
            });
        }
        ui.separator();
        match self.part {
            Part::Look => {
                size(ui, words, loaded, model);
                ui.separator();
                look(ui, words, loaded, model);
                legend(ui, view, words, model);
                looking(ui, words, view.world.looking(), wishes);
                linked(ui, view, words, wishes);
            }
            Part::Mend => {
                faults(ui, words, loaded);
                mending(ui, words, loaded, model);
            }
            Part::Places => {
                let on = (self.chosen, &mut *model);
                self.marks.show(ui, view, words, on, wishes);
            }
            Part::Lines => {
                let on = (self.chosen, &mut *model);
                self.lines.show(ui, view, words, on, wishes);
            }
            Part::LSystem => {
                let on = (self.chosen, &mut *model);
                self.abstractions.show(ui, view, words, on, wishes);
            }
            Part::Compare => {
                let on = (self.chosen, &mut *model);
                self.comparisons.show(ui, view, words, on, wishes);
            }
        }
        ui.separator();
        !ui.button(words.take_away).clicked()
    }

    fn choose(&mut self, ui: &mut Ui, document: &Document) {
        self.chosen = self.chosen.min(document.models.len().saturating_sub(1));
        ui.horizontal_wrapped(|ui| {
            for (at, model) in document.models.iter().enumerate() {
                let label = name_of(model);
                if ui.selectable_label(self.chosen == at, label).clicked() {
                    self.chosen = at;
                }
            }
        });
    }

    /// The files that can be brought.
    fn bring(&self, ui: &mut Ui, words: &Words, wishes: &mut Vec<Wish>) {
        ui.label(
            RichText::new(words.models_here)
                .color(TITLE)
                .size(TITLE_SIZE),
        );
        if self.offered.is_empty() {
            ui.label(words.no_models_here);
        }
        for file in &self.offered {
            if ui.button(file).clicked() {
                wishes.push(Wish::Bring(file.clone()));
            }
        }
        if ui.button(words.look_again).clicked() {
            wishes.push(Wish::FindModels);
        }
    }
}

pub(super) fn arrange(document: &Document, models: Vec<Model>, linked: bool) -> Edit {
    Edit::Arrange {
        models,
        platform: document.platform,
        linked,
    }
}

/// What a model is called: by its file, a tree that grows by its seed, too.
pub(super) fn name_of(model: &Model) -> String {
    let name = file_name(&model.file);
    match &model.likeness {
        None => name.to_owned(),
        Some(likeness) => format!("{name} * {}", likeness.params.seed),
    }
}

fn file_name(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

/// Whether all turn together.
pub(super) fn linked(ui: &mut Ui, view: &View<'_>, words: &Words, wishes: &mut Vec<Wish>) {
    let document = view.document;
    let mut linked = document.linked;
    if ui.checkbox(&mut linked, words.linked).changed() {
        wishes.push(Wish::Edit(arrange(
            document,
            document.models.to_vec(),
            linked,
        )));
    }
}

/// How large it is, in its unit, which can be chosen.
fn facts(ui: &mut Ui, words: &Words, loaded: &LoadedModel, model: &mut Model) {
    let mesh = &loaded.plain.mesh;
    let symbol = model.unit.symbol();
    let [width, height, depth] = loaded
        .size(model.z_up)
        .to_array()
        .map(|side| Rounded(side.into()));
    ui.label(format!("{width} × {height} × {depth} {symbol}"));
    let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
    ui.label(format!(
        "{triangles} {}, {vertices} {}",
        words.triangles, words.vertices
    ));
    ui.horizontal_wrapped(|ui| {
        ui.label(words.unit);
        for unit in [
            Unit::Metres,
            Unit::Centimetres,
            Unit::Millimetres,
            Unit::Micrometres,
            Unit::Nanometres,
        ] {
            ui.selectable_value(&mut model.unit, unit, unit.symbol());
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(words.stands_on);
        ui.selectable_value(&mut model.z_up, true, "z");
        ui.selectable_value(&mut model.z_up, false, "y");
    });
}

/// How large it stands there.
fn size(ui: &mut Ui, words: &Words, loaded: &LoadedModel, model: &mut Model) {
    let times = loaded.magnification(model);
    let told = if times >= 1.0 {
        format!("{} : 1", Rounded(times))
    } else {
        format!("1 : {}", Rounded(1.0 / times))
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{} {told}", words.shown_at));
        if let Some((length, _)) = loaded.scale_bar(model) {
            let symbol = model.unit.symbol();
            ui.label(format!("{} {length} {symbol}", words.bar_is));
        }
    });
    ui.horizontal(|ui| {
        let whole = loaded.real_side(model);
        let can = whole.is_some();
        if ui.add_enabled(can, Button::new(words.one_to_one)).clicked()
            && let Some(side) = whole
        {
            model.place.scale = side;
        }
        if ui.button(words.reset_view).clicked() {
            let fresh = Model::new(String::new(), model.unit, model.z_up, 0);
            model.place = fresh.place;
        }
    });
}

/// What of it is to be seen.
fn look(ui: &mut Ui, words: &Words, loaded: &LoadedModel, model: &mut Model) {
    ui.horizontal_wrapped(|ui| {
        for (surface, name) in [
            (Some(SurfaceLook::Textured), words.textured),
            (Some(SurfaceLook::Shaded), words.shaded),
            (Some(SurfaceLook::Matte), words.matte),
            (Some(SurfaceLook::XRay), words.x_ray),
            (None, words.no_faces),
        ] {
            // Files that say nothing of colours have nothing to show there.
            if surface != Some(SurfaceLook::Textured) || loaded.textured.is_some() {
                ui.selectable_value(&mut model.surface, surface, name);
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut model.wireframe, words.edges);
        ui.checkbox(&mut model.vertices, words.vertices);
        ui.checkbox(&mut model.boxed, words.box_and_size);
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(words.colour_by);
        for (colouring, name) in [
            (Colouring::Plain, words.nothing),
            (Colouring::Parts, words.parts),
            (Colouring::Problems, words.problems),
            (Colouring::Curvature, words.curvature),
            (Colouring::Radius, words.radius),
            (Colouring::Thickness, words.thickness),
        ] {
            ui.selectable_value(&mut model.colouring, colouring, name);
        }
    });
}

/// How all models are looked at.
fn looking(ui: &mut Ui, words: &Words, before: Looking, wishes: &mut Vec<Wish>) {
    ui.separator();
    let mut looking = before;
    ui.horizontal_wrapped(|ui| {
        ui.label(words.cut);
        for (cut, name) in [
            (Cut::None, words.cut_none),
            (Cut::InHand, words.cut_in_hand),
            (Cut::Stays, words.cut_stays),
        ] {
            ui.selectable_value(&mut looking.cut, cut, name);
        }
    });
    ui.checkbox(&mut looking.lamp, words.lamp);
    if looking != before {
        wishes.push(Wish::Look(looking));
    }
}

/// What is wrong with it, in the colours in which it is shown.
fn faults(ui: &mut Ui, words: &Words, loaded: &LoadedModel) {
    if loaded.faults.is_empty() {
        ui.label(words.no_problems);
    }
    for problem in loaded.faults.iter().take(MOST_FAULTS) {
        let text = RichText::new(&problem.what);
        ui.label(match fault_colour(problem.fault) {
            Some([red, green, blue, _]) => text.color(bright([red, green, blue])),
            None => text,
        });
        ui.label(problem.hint);
    }
    for remark in loaded.remarks.iter().take(MOST_FAULTS) {
        ui.label(remark);
    }
}

/// What can be mended, and what each mend changed; undo takes one back.
fn mending(ui: &mut Ui, words: &Words, loaded: &LoadedModel, model: &mut Model) {
    ui.separator();
    ui.label(RichText::new(words.mend).color(TITLE).size(TITLE_SIZE));
    for account in &loaded.accounts {
        ui.label(account);
    }
    let close = |cap| Close {
        cap,
        ..Close::default()
    };
    ui.horizontal_wrapped(|ui| {
        for (name, mend) in [
            (words.mend_weld, Mend::Weld(Weld::default())),
            (words.mend_debris, Mend::Debris(Debris::default())),
            (words.mend_largest, Mend::Largest),
            (words.mend_orient, Mend::Orient),
            (words.mend_close, Mend::Close(close(Cap::Flat))),
            (words.mend_close_smooth, Mend::Close(close(Cap::Smooth))),
            (words.mend_smooth, Mend::Smooth(Smooth::default())),
            (words.mend_decimate, Mend::Decimate(Decimate::default())),
            (words.mend_remesh, Mend::Remesh(Remesh::default())),
        ] {
            if ui.button(name).clicked() {
                model.mends.push(mend);
            }
        }
    });
    let mended = !model.mends.is_empty();
    if ui.add_enabled(mended, Button::new(words.unmend)).clicked() {
        model.mends.clear();
    }
}

/// A colour that can be read on dark paper.
fn bright(colour: [u8; 3]) -> egui::Color32 {
    let [red, green, blue] = colour.map(|part| part / 2 + 110);
    egui::Color32::from_rgb(red, green, blue)
}
