//! What is worked out of models that stand on the stage: ways along them, ends that they may have, colours by numbers, and those of centerlines. On a worker, one after the
//! other, each once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;

use crate::app::queue::Queue;
use crate::mesh::colour::{Colour, Ramp, by_numbers};
use crate::mesh::endpoints::{Proposal, propose};
use crate::mesh::field::{curvature, radius, thickness};
use crate::mesh::measure::along;
use crate::mesh::surface::Surface;
use crate::world::World;
use crate::world::lines::{Lines, Shading};
use crate::world::marks::WayRequest;
use crate::world::model::{Colouring, LoadedModel, Model};
use crate::world::models::Painting;
use crate::world::scene::new_revision;

/// Vertices that are asked for their thickness or ball; more take longer than people wait, and colours do not show it.
const MOST_ASKED: usize = 50_000;

/// What is to be worked out.
#[derive(Clone, Debug)]
enum Study {
    Way(WayRequest),
    Ends(Model, Arc<LoadedModel>),
    Paint(Model, Arc<LoadedModel>),
    Shade(Model, Arc<Lines>),
}

/// What came of it; none where it was cancelled.
#[derive(Debug)]
pub(super) enum Studied {
    Way(u64, Option<(f64, Vec<Vec3>)>),
    Ends(Model, Vec<Proposal>),
    Paint(Model, Painting),
    Shade(Model, Shading),
    Cancelled,
}

impl Studied {
    /// Gives it to the world that wanted it.
    pub(super) fn give(self, world: &mut World) {
        match self {
            Self::Way(id, way) => world.give_way(id, way),
            Self::Ends(model, proposals) => world.give_proposals(&model, proposals),
            Self::Paint(model, painting) => world.give_painting(&model, painting),
            Self::Shade(model, shading) => world.give_shading(&model, shading),
            Self::Cancelled => {}
        }
    }
}

/// Works out what is wanted.
pub(super) struct Studies(Queue<Study, Studied>);

impl Studies {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        Ok(Self(Queue::start("ramus-studies", study)?))
    }

    /// Begins what the world wants next, unless something is under way. Whether something is.
    pub(super) fn follow(&mut self, world: &World) -> bool {
        if !self.0.is_busy() {
            let way = world.wanted_way().map(Study::Way);
            let ends = || {
                world
                    .wanted_proposals()
                    .map(|(model, loaded)| Study::Ends(model.clone(), loaded))
            };
            let paint = || {
                world
                    .wanted_painting()
                    .map(|(model, loaded)| Study::Paint(model.clone(), loaded))
            };
            let shade = || {
                world
                    .wanted_shading()
                    .map(|(model, lines)| Study::Shade(model.clone(), lines))
            };
            if let Some(study) = way.or_else(shade).or_else(ends).or_else(paint) {
                // The line is empty.
                let _ = self.0.ask(study);
            }
        }
        self.0.is_busy()
    }

    pub(super) fn poll(&mut self) -> Option<Studied> {
        self.0.poll()
    }

    pub(super) fn wait(&mut self) -> Option<Studied> {
        self.0.wait()
    }
}

fn study(study: &Study, cancel: &AtomicBool) -> Studied {
    let done = match study {
        Study::Way(way) => {
            let [from, to] = &way.ends;
            let found = along(&way.loaded.surface, from, to, cancel).ok();
            found.map(|found| Studied::Way(way.id, found.map(|way| (way.length, way.points))))
        }
        Study::Ends(model, loaded) => propose(&loaded.surface, cancel)
            .map(|proposals| Studied::Ends(model.clone(), proposals)),
        Study::Paint(model, loaded) => painting(loaded, model.colouring, cancel)
            .map(|painting| Studied::Paint(model.clone(), painting)),
        Study::Shade(model, lines) => {
            let by = model.lines.and_then(|look| look.by);
            Some(Studied::Shade(model.clone(), lines.shaded(by)))
        }
    };
    done.unwrap_or(Studied::Cancelled)
}

/// A model's colours by numbers; `None` when somebody asked to stop.
fn painting(loaded: &LoadedModel, by: Colouring, cancel: &AtomicBool) -> Option<Painting> {
    let (colours, range) = coloured(&loaded.surface, by, cancel)?;
    Some(Painting {
        display: Arc::new(loaded.plain.painted(colours)),
        revision: new_revision(),
        range,
    })
}

/// The colours of a surface's vertices by numbers, and the numbers at both ends of the scale, in the file's unit or, for curvature, in one over
/// it; none where no vertex has a number. `None` when somebody asked to stop.
pub fn coloured(
    surface: &Surface,
    by: Colouring,
    cancel: &AtomicBool,
) -> Option<(Vec<Colour>, Option<[f32; 2]>)> {
    let (numbers, ramp) = match by {
        Colouring::Thickness => (thickness(surface, MOST_ASKED, cancel)?, Ramp::Rising),
        Colouring::Radius => (radius(surface, MOST_ASKED, cancel)?, Ramp::Rising),
        Colouring::Curvature | Colouring::Plain | Colouring::Parts | Colouring::Problems => {
            (curvature(surface, cancel)?, Ramp::AboutZero)
        }
    };
    let range = ramp.range(&numbers);
    let colours = by_numbers(&numbers, ramp, range.unwrap_or_default());
    Some((colours, range))
}
