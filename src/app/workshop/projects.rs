//! Other projects: gone on with, or their sketches taken.

use std::path::Path;
use std::sync::Arc;

use super::{Workshop, grow_worker};
use crate::app::abstracting::Abstracting;
use crate::app::comparing::Comparing;
use crate::app::finding::Finding;
use crate::app::planting::Planter;
use crate::app::previews::Previews;
use crate::app::scans::Scans;
use crate::app::store::{Store, read_project};
use crate::app::studies::Studies;
use crate::sketch::Grower;
use crate::world::World;
use crate::world::document::{Document, Edit};
use crate::world::project;

impl Workshop {
    /// Saves the project and goes on with another one; where either cannot be done, this one stays.
    pub(super) fn go_on_with(&mut self, project: &Path) {
        let there = std::path::absolute(project).ok();
        let here = self.project().map(std::path::absolute);
        if here.is_some_and(|here| here.ok() == there) {
            return self.world.show_message("You are in it.".into());
        }
        if self.stays {
            let told =
                "This session is recorded, and a recording stays with one project: end it first.";
            return self.world.show_message(told.into());
        }
        let told = match self.exchange(project) {
            Ok(told) => told,
            Err(error) => format!("{error:#}"),
        };
        self.world.show_message(told);
    }

    /// Begins anew with the sketch of another project; its models stay there.
    pub(super) fn take_sketch(&mut self, project: &Path) {
        let theirs = match read_project(project) {
            Ok(theirs) => theirs,
            Err(error) => return self.world.show_message(error.to_string()),
        };
        let alone = Document {
            models: Arc::default(),
            linked: false,
            grove: Arc::default(),
            ..theirs
        };
        let project = String::from_utf8_lossy(&project::to_bytes(&alone)).into_owned();
        if let Err(error) = self.world.apply(Edit::TakeSpecies { project }) {
            self.world.show_message(error.to_string());
        }
    }

    fn exchange(&mut self, project: &Path) -> anyhow::Result<String> {
        self.keep_journal();
        self.save()?;
        // Trees that are on their way belong to this world, and the next one's wishes have the same numbers.
        let (worker, scans, studies) = (grow_worker()?, Scans::start()?, Studies::start()?);
        let (finding, abstracting) = (Finding::start()?, Abstracting::start()?);
        let comparing = Comparing::start()?;
        let (planter, previews) = (Planter::start()?, Previews::start()?);
        let opened = Store::open(project)?;
        if let Some(store) = self.store.replace(opened.store) {
            // Everything is in the file already; what is left is the journal's end.
            store.close(self.world.document())?;
        }
        let mut world = World::new(opened.history);
        world.set_room(self.settings.room);
        world.set_settings(self.world.settings());
        world.take_buttons(self.world.buttons().clone());
        self.world = world;
        (self.worker, self.scans, self.studies) = (worker, scans, studies);
        (self.finding, self.abstracting) = (finding, abstracting);
        self.comparing = comparing;
        (self.planter, self.previews) = (planter, previews);
        self.growing = None;
        (self.grower, self.saved) = (Grower::default(), self.edits);
        self.offer_models();
        let name = project.file_name().unwrap_or_default().to_string_lossy();
        Ok(opened
            .message
            .unwrap_or_else(|| format!("Going on with {name}.")))
    }
}
