//! The workshop's scanned models: brought onto the stage, and read when the project has them.

use std::path::{Path, PathBuf};

use super::{NO_PROJECT, Workshop};
use crate::app::ends;
use crate::app::scans::{Done, ENDINGS, Read, Scan, named, offered};
use crate::app::takeaway::{Taken, free_name};
use crate::ui::{AbstractionWish, LineWish};
use crate::world::document::Edit;
use crate::world::model::Model;
use crate::world::scene::SurfaceLook;

/// The folder beside a project that holds what can be worked out again.
const CACHE: &str = ".ramus-cache";

impl Workshop {
    /// Has a model read and brings it onto the stage; what is wrong with it is told on the board.
    pub fn bring_model(&mut self, path: &Path) {
        let file = named(path, self.folder().as_deref());
        self.bring(file, path.to_owned());
    }

    /// The same for a file that somebody drops onto the window; a recording knows nothing of files.
    pub fn drop_model(&mut self, path: &Path) {
        if self.stays {
            let told = "This session is recorded, and a recording knows no files that are dropped: take models from the bench.";
            return self.world.show_message(told.into());
        }
        self.bring_model(path);
    }

    /// The same for a file as the project names it.
    pub(super) fn bring_named(&mut self, file: &str) {
        let path = self.path_of(file);
        self.bring(file.to_owned(), path);
    }

    fn bring(&mut self, file: String, path: PathBuf) {
        let scan = Scan {
            file,
            path,
            mends: Vec::new(),
            likeness: None,
            cache: self.cache(),
            comes: true,
        };
        if !self.scans.ask(scan) {
            let told = "So many models wait to be read that this one is left out: ask again when they are there.";
            self.world.show_message(told.into());
        }
    }

    /// Offers the models that lie beside the project.
    pub fn offer_models(&mut self) {
        let folder = self.folder().unwrap_or_else(|| PathBuf::from("."));
        self.panels.offer_models(offered(&folder, &ENDINGS));
        self.panels
            .offer_endpoints(offered(&folder, &["csv", "json"]));
    }

    /// Looks for models in this folder and not in the project's, waits for them in the frame that wants them, and offers those that lie there: so a
    /// session plays as it was recorded beside it.
    pub fn stay_with_models_of(&mut self, folder: &Path) {
        self.stays = true;
        self.models_in = std::path::absolute(folder).ok();
        self.offer_models();
        self.finish_models();
    }

    /// Where the models are that the project names.
    fn folder(&self) -> Option<PathBuf> {
        if let Some(folder) = &self.models_in {
            return Some(folder.clone());
        }
        let project = std::path::absolute(self.project()?).ok()?;
        project.parent().map(Path::to_owned)
    }

    /// Where what takes long to work out of models is kept: beside the project, if there is one.
    fn cache(&self) -> Option<PathBuf> {
        let project = self.project()?;
        Some(project.with_file_name(CACHE))
    }

    fn path_of(&self, file: &str) -> PathBuf {
        self.folder()
            .map_or_else(|| file.into(), |folder| folder.join(file))
    }

    /// Whether a model is on its way, or its centerlines are.
    #[must_use]
    pub fn is_reading(&self) -> bool {
        self.scans.is_busy()
            || self.world.wanted_model().is_some()
            || self.world.wanted_lines().is_some()
            || self.world.wanted_shading().is_some()
            || self.world.wanted_abstraction().is_some()
            || self.world.wanted_comparison().is_some()
    }

    /// Has the meshes read of models that stand on the stage, and brings those that were asked for. In a session that is recorded or played the frame
    /// waits for them: it must play the same however long files take.
    pub(super) fn follow_scans(&mut self) {
        self.want_scans();
        let waits = self.stays;
        while let Some(done) = if waits {
            self.scans.wait()
        } else {
            self.scans.poll()
        } {
            self.take_scan(done);
        }
        self.study(waits);
        self.find_lines(waits);
        self.find_abstractions(waits);
        self.compare(waits);
        let reading = self.scans.reading();
        self.world.tell_reading(reading);
    }

    /// Has worked out what is wanted of models; `waits`: all of it, now.
    fn study(&mut self, waits: bool) {
        while self.studies.follow(&self.world)
            && let Some(done) = if waits {
                self.studies.wait()
            } else {
                self.studies.poll()
            }
        {
            done.give(&mut self.world);
        }
    }

    /// Has the centerlines found that models are to show; `waits`: all of them, now.
    fn find_lines(&mut self, waits: bool) {
        while self.finding.follow(&self.world)
            && let Some((model, found)) = if waits {
                self.finding.wait()
            } else {
                self.finding.poll()
            }
        {
            self.world.give_lines(&model, found);
            self.study(waits);
        }
        self.world.tell_finding(self.finding.now());
    }

    /// Has trees like models looked for, and shows how near they are; `waits`: all of them, now.
    fn find_abstractions(&mut self, waits: bool) {
        while self.abstracting.follow(&self.world)
            && let Some((model, seed, found)) = if waits {
                self.abstracting.wait()
            } else {
                self.abstracting.poll()
            }
        {
            self.world.give_abstraction(&model, seed, found, true);
        }
        if let Some((model, seed, found)) = self.abstracting.so_far() {
            self.world.give_abstraction(&model, seed, Ok(found), false);
        }
    }

    /// Has trees compared; `waits`: all of them, now.
    fn compare(&mut self, waits: bool) {
        while self.comparing.follow(&self.world)
            && let Some((trees, found)) = if waits {
                self.comparing.wait()
            } else {
                self.comparing.poll()
            }
        {
            self.world.give_comparison(trees, found);
        }
    }

    /// Does what is wanted with abstractions.
    pub(super) fn do_with_abstraction(&mut self, wish: AbstractionWish) {
        let model = |at: usize| self.document().models.get(at).cloned();
        match wish {
            AbstractionWish::Find(at, seed) => self.world.abstract_model(at, seed),
            AbstractionWish::Stop(at) => {
                if let Some(model) = model(at) {
                    self.world.stop_abstracting(&model);
                }
            }
            AbstractionWish::Stand(at, place) => {
                if let Err(error) = self.world.stand_beside(at, place) {
                    self.world.show_message(error.to_string());
                }
            }
            AbstractionWish::Plant(preset) => {
                if let Err(error) = self.world.plant(preset) {
                    self.world.show_message(error.to_string());
                }
            }
            AbstractionWish::Grow(at, on) => self.world.grow_on(at, on),
            AbstractionWish::Write(at, ending) => self.write_likeness(at, ending),
        }
    }

    /// Writes a tree that grows on the stage beside the project, or its grammar, under a name that is free.
    fn write_likeness(&mut self, at: usize, ending: &'static str) {
        let Some(model) = self.document().models.get(at).cloned() else {
            return;
        };
        let Some(likeness) = model.likeness else {
            return;
        };
        let Some(project) = self.project() else {
            return self.world.show_message(NO_PROJECT.into());
        };
        let stem = Path::new(&model.file).file_stem().unwrap_or_default();
        let name = format!("{}-like.{ending}", stem.to_string_lossy());
        let name = project.with_file_name(name);
        self.take_away(Taken::Likeness(likeness), &name, ending);
    }

    /// Does what is wanted with centerlines.
    pub(super) fn do_with_lines(&mut self, wish: LineWish) {
        match wish {
            LineWish::Light(model, branch) => self.world.light_branch(model, branch),
            LineWish::Again(model) => self.world.find_lines_again(model),
            LineWish::Stop => {
                if let Some(model) = self.finding.stop() {
                    let why = format!("Stopped looking for the centerlines of {}.", model.file);
                    self.world.give_lines(&model, Err(why));
                }
            }
            LineWish::Write(model, ending) => self.write_lines(model, ending),
            LineWish::Take(model, branch) => {
                if let Err(error) = self.world.take_lines(model, branch) {
                    self.world.show_message(error.to_string());
                }
            }
        }
    }

    /// Writes a model's centerlines beside the project, under a name that is free.
    fn write_lines(&mut self, at: usize, ending: &'static str) {
        let Some(model) = self.document().models.get(at).cloned() else {
            return;
        };
        let Some(Ok(lines)) = self.world.lines(&model).map(|found| found.cloned()) else {
            return;
        };
        let Some(project) = self.project() else {
            return self.world.show_message(NO_PROJECT.into());
        };
        let stem = Path::new(&model.file).file_stem().unwrap_or_default();
        let name = format!("{}-lines.{ending}", stem.to_string_lossy());
        let name = project.with_file_name(name);
        self.take_away(Taken::Lines(lines, model.unit), &name, ending);
    }

    /// Stops the reading of the model that is being read.
    pub(super) fn stop_reading(&mut self) {
        let Some(scan) = self.scans.stop() else {
            return;
        };
        let why = format!("Stopped reading {}.", scan.file);
        self.take_scan((scan, Err(why)));
    }

    /// Waits until all models are there or are told to be unreadable.
    pub fn finish_models(&mut self) {
        self.want_scans();
        while let Some(done) = self.scans.wait() {
            self.take_scan(done);
            self.want_scans();
        }
        self.study(true);
        self.find_lines(true);
        self.find_abstractions(true);
        self.compare(true);
        self.world.tell_reading(None);
        self.keep_journal();
    }

    fn want_scans(&mut self) {
        // One at a time: what is read now may be the one that is wanted.
        if !self.scans.is_busy()
            && let Some(model) = self.world.wanted_model()
        {
            let scan = Scan {
                file: model.file.clone(),
                path: self.path_of(&model.file),
                mends: model.mends.clone(),
                likeness: model.likeness.clone(),
                cache: self.cache(),
                comes: false,
            };
            self.scans.ask(scan);
        }
    }

    /// Writes a model's endpoints beside the project, as `csv` or `json`, under a name that is free.
    pub(super) fn write_ends(&mut self, at: usize, ending: &str) {
        let Some(model) = self.document().models.get(at) else {
            return;
        };
        let Some(project) = self.project() else {
            return self.world.show_message(NO_PROJECT.into());
        };
        let stem = Path::new(&model.file).file_stem().unwrap_or_default();
        let name = project.with_file_name(format!("{}-ends", stem.to_string_lossy()));
        let path = free_name(&name, ending, |_| false);
        let told = match ends::write(&path, &model.endpoints) {
            Ok(()) => format!("Written: {}.", path.display()),
            Err(why) => why,
        };
        self.world.show_message(told);
        self.offer_models();
    }

    /// Takes a model's endpoints from a file, in the place of those that it has.
    pub(super) fn read_ends(&mut self, at: usize, file: &str) {
        let read = ends::read(&self.path_of(file));
        let taken = read.and_then(|endpoints| {
            let taken = self.world.set_endpoints(at, endpoints);
            taken.map_err(|error| error.to_string())
        });
        if let Err(why) = taken {
            self.world.show_message(why);
        }
    }

    fn take_scan(&mut self, (scan, read): Done) {
        let of = |model: &&Model| {
            let is_same = model.file == scan.file && model.mends == scan.mends;
            is_same && model.likeness == scan.likeness
        };
        // As it is kept, or as it is tried out.
        let stands = [self.world.document(), self.world.shown()]
            .into_iter()
            .find_map(|document| document.models.iter().find(of).cloned());
        let read = match (read, stands) {
            (Ok(read), _) if scan.comes => return self.come(scan.file, read),
            (Err(why), _) if scan.comes => return self.world.show_message(why),
            // It was taken away meanwhile, or is mended otherwise.
            (_, None) => return,
            (read, Some(model)) => (model, read.map(|read| read.model)),
        };
        self.world.give_model(&read.0, read.1);
    }

    /// Brings a model that was read.
    fn come(&mut self, file: String, read: Read) {
        let document = self.world.document();
        let mut models = document.models.to_vec();
        let mut model = Model::new(file, read.unit, read.z_up, models.len());
        if read.model.textured.is_some() {
            model.surface = Some(SurfaceLook::Textured);
        }
        models.push(model.clone());
        let edit = Edit::Arrange {
            models,
            platform: document.platform,
            linked: document.linked,
        };
        match self.world.apply(edit) {
            Ok(()) => self.world.give_model(&model, Ok(read.model)),
            Err(error) => self.world.show_message(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::fs;

    use super::*;
    use crate::app::scans::tests::TETRAHEDRON;
    use crate::app::store::Store;
    use crate::app::workshop::WorkshopParams;
    use crate::mesh::mend::Mend;
    use crate::world::model::MOST_MODELS;

    #[test]
    fn a_model_is_brought_kept_with_the_project_and_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("models/corner.obj");
        fs::create_dir(folder.path().join("models")).unwrap();
        fs::write(&model, TETRAHEDRON).unwrap();
        let project = folder.path().join("a.ramus");
        let open = || {
            let opened = Store::open(&project).unwrap();
            Workshop::new(opened, WorkshopParams::default()).unwrap()
        };
        let mut workshop = open();
        workshop.bring_model(&model);
        assert!(workshop.is_reading());
        workshop.finish_models();
        assert!(!workshop.is_reading());
        let models = workshop.document().models.to_vec();
        assert_eq!(models.len(), 1);
        assert_eq!(
            models[0].file, "models/corner.obj",
            "from the project's folder"
        );
        assert_eq!(workshop.scene().models.len(), 1);
        assert_eq!(workshop.edits(), 1);
        workshop.close().unwrap();

        let mut again = open();
        assert_eq!(*again.document().models, models);
        assert_eq!(again.scene().models.len(), 0, "it is not read yet");
        again.finish_models();
        assert_eq!(again.scene().models.len(), 1);

        // Taken away, and brought back by undo, it is read again.
        let platform = again.document().platform;
        let none = Edit::Arrange {
            models: Vec::new(),
            platform,
            linked: false,
        };
        again.world.apply(none).unwrap();
        assert!(again.scene().models.is_empty() && !again.is_reading());
        again.world.undo();
        again.finish_models();
        assert_eq!(again.scene().models.len(), 1);
        drop(again);

        // Its file is gone: the project opens, the pedestal is empty, and it is told.
        fs::remove_file(&model).unwrap();
        let mut without = open();
        without.finish_models();
        assert_eq!(without.document().models.len(), 1, "nothing is lost");
        assert!(without.scene().models.is_empty() && !without.is_reading());
        assert!(without.world().has_message());
    }

    #[test]
    fn a_mend_is_an_edit_that_the_project_keeps_and_undo_takes_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("open.obj");
        // The tetrahedron without its last face.
        let open_corner = TETRAHEDRON.rsplit_once("f ").unwrap().0;
        fs::write(&file, open_corner).unwrap();
        let opened = Store::open(&folder.path().join("a.ramus")).unwrap();
        let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
        workshop.bring_model(&file);
        workshop.finish_models();
        let triangles = |workshop: &Workshop| {
            let model = &workshop.document().models[0];
            let loaded = workshop.world().loaded_model(model).unwrap();
            (loaded.plain.mesh.triangles.len(), loaded.accounts.len())
        };
        assert_eq!(triangles(&workshop), (3, 0));
        let mended = |workshop: &Workshop, mends: Vec<Mend>| {
            let document = workshop.document();
            let mut models = document.models.to_vec();
            models[0].mends = mends;
            Edit::Arrange {
                models,
                platform: document.platform,
                linked: false,
            }
        };
        let close = Mend::parse("close").unwrap();
        let edit = mended(&workshop, vec![close]);
        workshop.world.apply(edit).unwrap();
        assert_eq!(
            triangles(&workshop),
            (3, 0),
            "as it was, until it is mended"
        );
        workshop.finish_models();
        assert_eq!(triangles(&workshop), (4, 1));
        assert_eq!(workshop.scene().models.len(), 1);
        assert_eq!(
            fs::read_to_string(&file).unwrap(),
            open_corner,
            "the file stays"
        );
        let bytes = crate::world::project::to_bytes(workshop.document());
        assert!(
            String::from_utf8(bytes)
                .unwrap()
                .contains("\"mends\":[\"close")
        );
        workshop.world.undo();
        workshop.finish_models();
        assert_eq!(triangles(&workshop), (3, 0));
        // What cannot be mended is told, and nothing is lost.
        let edit = mended(&workshop, vec![Mend::parse("remesh=0.0000001").unwrap()]);
        workshop.world.apply(edit).unwrap();
        workshop.finish_models();
        assert!(workshop.world().has_message() && !workshop.is_reading());
        workshop.world.undo();
        workshop.finish_models();
        assert_eq!(triangles(&workshop), (3, 0));
    }

    #[test]
    fn what_is_no_model_is_told_and_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("letter.ply");
        fs::write(&file, "Dear reader,\n").unwrap();
        let opened = Store::open(&folder.path().join("a.ramus")).unwrap();
        let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
        workshop.bring_model(&file);
        workshop.finish_models();
        assert!(workshop.document().models.is_empty() && workshop.world().has_message());
        let board = workshop.scene().board.clone().unwrap();
        let told = board.content.message.clone().unwrap();
        assert!(told.contains("letter.ply"), "{told}");
    }

    #[test]
    fn a_project_has_so_many_models_and_no_more() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("corner.obj");
        fs::write(&file, TETRAHEDRON).unwrap();
        let opened = Store::open(&folder.path().join("a.ramus")).unwrap();
        let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
        for _ in 0..MOST_MODELS + 2 {
            workshop.bring_model(&file);
            workshop.finish_models();
        }
        assert_eq!(workshop.document().models.len(), MOST_MODELS);
        assert_eq!(workshop.scene().models.len(), MOST_MODELS);
        assert!(workshop.world().has_message());
    }
}
