//! What the world asks and is told of scanned models: their files, what is worked out of them, and what panels want with them.

use std::sync::Arc;

use glam::Vec3;

use super::World;
use super::document::EditError;
use super::marks::{self, Mark, Measure, WayRequest};
use super::model::{LoadedModel, Model};
use super::models::{Looking, Painting, Reading};
use super::tools::Tools;
use crate::mesh::endpoints::{Endpoint, Proposal};

impl World {
    /// A model on the stage that has not been read yet as it is to be; [`Self::give_model`] brings what became of it.
    #[must_use]
    pub fn wanted_model(&self) -> Option<&Model> {
        self.tools.models.wanted(self.shown())
    }

    /// Gives what a model's file holds, mended as it is to be, or a sentence that says why not: its pedestal stays empty then.
    pub fn give_model(&mut self, model: &Model, found: Result<LoadedModel, String>) {
        if let Err(why) = &found {
            self.show_message(why.clone());
        }
        self.tools.models.give(model, found.map(Arc::new));
        self.tools
            .models
            .keep([self.history.committed(), &self.tools.shown]);
    }

    /// A model that is to be coloured by numbers, which nobody has worked out; [`Self::give_painting`] brings what became of it.
    #[must_use]
    pub fn wanted_painting(&self) -> Option<(&Model, Arc<LoadedModel>)> {
        let models = &self.tools.models;
        let model = models.unpainted(self.document())?;
        Some((model, Arc::clone(models.loaded(model)?)))
    }

    /// Gives a model's colours by numbers; they are dropped where it is to be coloured otherwise meanwhile.
    pub fn give_painting(&mut self, model: &Model, painting: Painting) {
        self.tools.models.paint(model, painting);
        self.tools
            .models
            .keep([self.history.committed(), &self.tools.shown]);
    }

    /// What a model's colours by numbers mean, if they were worked out.
    #[must_use]
    pub fn painting(&self, model: &Model) -> Option<&Painting> {
        self.tools.models.painting(model)
    }

    /// What lies on models: measures, in the order in which they were laid.
    #[must_use]
    pub fn measures(&self) -> &[Measure] {
        &self.tools.models.marks.measures
    }

    /// Ends that are proposed for a model.
    #[must_use]
    pub fn proposals(&self, model: &Model) -> &[Proposal] {
        self.tools.models.marks.proposals(model)
    }

    /// A way along a surface that is to be worked out; [`Self::give_way`] brings it.
    #[must_use]
    pub fn wanted_way(&self) -> Option<WayRequest> {
        self.tools.way_wanted(self.document())
    }

    /// Gives the length of a measured way and where it leads, from the mesh's origin; none where no way leads there.
    pub fn give_way(&mut self, id: u64, way: Option<(f64, Vec<Vec3>)>) {
        self.tools.give_way(id, way);
    }

    /// A model whose ends are to be proposed; [`Self::give_proposals`] brings them.
    #[must_use]
    pub fn wanted_proposals(&self) -> Option<(&Model, Arc<LoadedModel>)> {
        self.tools.proposals_wanted(self.document())
    }

    /// Gives the ends that are proposed for a model.
    pub fn give_proposals(&mut self, model: &Model, proposals: Vec<Proposal>) {
        if proposals.is_empty() {
            self.show_message("No ends were found to propose: set them by hand.".into());
        }
        self.tools.give_proposals(model, proposals);
    }

    /// Gives a model other endpoints.
    ///
    /// # Errors
    /// Where the edit is refused; nothing changes then.
    pub fn set_endpoints(
        &mut self,
        model: usize,
        endpoints: Vec<Endpoint>,
    ) -> Result<(), EditError> {
        match marks::with_endpoints(self.document(), model, endpoints) {
            Some(edit) => self.apply(edit),
            None => Ok(()),
        }
    }

    /// Does what a panel wants with marks.
    ///
    /// # Errors
    /// Where an edit that it makes is refused; the proposals are gone then.
    pub fn mark(&mut self, mark: Mark) -> Result<(), EditError> {
        match mark {
            Mark::Propose(model) => self.tools.propose(self.history.committed(), model),
            Mark::Refuse(model, which) => {
                let document = self.history.committed();
                self.tools.take_proposals(document, model, which);
            }
            Mark::Take(model, which) => {
                let document = self.history.committed();
                let taken = self.tools.take_proposals(document, model, which);
                if let Some(edit) = Tools::taking(document, model, taken) {
                    return self.apply(edit);
                }
            }
            Mark::Unmeasure(id) => self.tools.unmeasure(id),
        }
        Ok(())
    }

    /// Says which file is being read and how far that is, thousandths; panels show it in steps of five hundredths.
    pub fn tell_reading(&mut self, reading: Option<(&str, u32)>) {
        Reading::tell(&mut self.tools.models.reading, reading);
    }

    /// The file that is being read.
    #[must_use]
    pub fn reading(&self) -> Option<&Reading> {
        self.tools.models.reading.as_ref()
    }

    /// Has the models read again that could not be.
    pub fn try_models_again(&mut self) {
        self.tools.models.forget_failures();
    }

    /// How models are looked at.
    #[must_use]
    pub fn looking(&self) -> Looking {
        self.tools.models.looking
    }

    /// Sets that.
    pub fn look(&mut self, looking: Looking) {
        self.tools.models.looking = looking;
    }

    /// How often a model was read or could not be.
    #[must_use]
    pub fn model_changes(&self) -> u64 {
        self.tools.models.changes
    }

    /// What is known of a model's mesh, if its file was read.
    #[must_use]
    pub fn loaded_model(&self, model: &Model) -> Option<&LoadedModel> {
        self.tools.models.loaded(model).map(|loaded| &**loaded)
    }
}
