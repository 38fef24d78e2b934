//! Planted trees are grown one after the other on a thread of their own, and stand on the stage when they are ready.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::individuals::standing;
use super::worker::Worker;
use crate::mesh::display::Display;
use crate::world::World;
use crate::world::planted::PlantRequest;

/// What became of an individual.
type Grown = (PlantRequest, Result<Arc<Display>, String>);

/// See the module.
pub(super) struct Planter {
    worker: Worker<PlantRequest, Grown>,
    /// What the thread is at.
    at: Option<PlantRequest>,
}

impl Planter {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let job = |request: &PlantRequest, cancel: &AtomicBool| {
            let PlantRequest {
                sketch,
                step,
                individual,
            } = request;
            let grown = standing(sketch, *step, *individual, cancel);
            (request.clone(), grown)
        };
        Ok(Self {
            worker: Worker::start("ramus-plant", job)?,
            at: None,
        })
    }

    /// Goes on: takes what has grown, and asks for what is lacking. What is lacking no more is cancelled.
    pub(super) fn follow(&mut self, world: &mut World) {
        if self.at.is_some()
            && let Some(grown) = self.worker.poll()
        {
            self.take(grown, world);
        }
        self.ask(world);
    }

    /// Waits until everything stands that is planted.
    pub(super) fn finish(&mut self, world: &mut World) {
        self.ask(world);
        while self.at.is_some() {
            let Some(grown) = self.worker.wait() else {
                return;
            };
            self.take(grown, world);
            self.ask(world);
        }
    }

    /// Whether something grows.
    pub(super) fn is_busy(&self) -> bool {
        self.at.is_some()
    }

    fn take(&mut self, (request, grown): Grown, world: &mut World) {
        self.at = self.at.take().filter(|at| !at.is(&request));
        world.set_plant(&request, grown);
    }

    fn ask(&mut self, world: &World) {
        let request = world.plant_request();
        let is_at = |request: &PlantRequest| self.at.as_ref().is_some_and(|at| at.is(request));
        match request {
            Some(request) if !is_at(&request) => {
                self.at = Some(request.clone());
                self.worker.ask(request);
            }
            Some(_) => {}
            None => {
                if self.at.take().is_some() {
                    self.worker.cancel();
                }
            }
        }
    }
}
