//! Centerlines of models on the stage: found and measured on a worker, one model after the other, and stopped as soon as nobody wants them any more.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use crate::app::queue::Queue;
use crate::app::scans::Progress;
use crate::centerline::analysis::Analysis;
use crate::centerline::{Centerline, CenterlineError, Params, STAGES, centerline};
use crate::mesh::endpoints::{Proposal, propose};
use crate::world::World;
use crate::world::lines::Lines;
use crate::world::model::{LoadedModel, Model};

/// What is to be found.
#[derive(Clone, Debug)]
struct Search(Model, Arc<LoadedModel>);

/// What became of it.
type Done = (Model, Result<Lines, String>);

/// Where the stages begin and end, thousandths: proposing ends, the centerlines, measuring and making what is drawn.
const PARTS: [[u32; 2]; 3] = [[0, 200], [200, 850], [850, 1000]];

/// Finds what is wanted.
pub(super) struct Finding {
    queue: Queue<Search, Done>,
    progress: Arc<Progress>,
}

impl Finding {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let progress = Arc::new(Progress::default());
        let told = Arc::clone(&progress);
        let job = move |Search(model, loaded): &Search, cancel: &AtomicBool| {
            told.begin();
            let found = found(model, loaded, &told, cancel);
            (
                model.clone(),
                found.map_err(|why| format!("{}: {why}", model.file)),
            )
        };
        Ok(Self {
            queue: Queue::start("ramus-centerlines", job)?,
            progress,
        })
    }

    /// Stops what nobody wants any more, and begins what the world wants next, unless something is under way. Whether something is.
    pub(super) fn follow(&mut self, world: &World) -> bool {
        let at_work = self.queue.open().next();
        if at_work.is_some_and(|Search(model, _)| !world.wants_lines(model)) {
            self.queue.stop();
        }
        if !self.queue.is_busy()
            && let Some((model, loaded)) = world.wanted_lines()
        {
            // The line is empty.
            let _ = self.queue.ask(Search(model.clone(), loaded));
        }
        self.queue.is_busy()
    }

    pub(super) fn poll(&mut self) -> Option<Done> {
        self.queue.poll()
    }

    pub(super) fn wait(&mut self) -> Option<Done> {
        self.queue.wait()
    }

    /// The file whose centerlines are being found, and how far that is, thousandths.
    pub(super) fn now(&self) -> Option<(&str, u32)> {
        let Search(model, _) = self.queue.open().next()?;
        Some((&model.file, self.progress.now()))
    }

    /// Stops what is being found, and gives the model back.
    pub(super) fn stop(&mut self) -> Option<Model> {
        self.queue.stop().map(|Search(model, _)| model)
    }
}

/// Finds a model's centerlines and measures them; those of a skeleton are the skeleton.
fn found(
    model: &Model,
    loaded: &LoadedModel,
    progress: &Progress,
    cancel: &AtomicBool,
) -> Result<Lines, String> {
    let [proposing, finding, measuring] = PARTS;
    let began = Instant::now();
    let mut proposals = Vec::new();
    let centerline = match &loaded.skeleton {
        Some(skeleton) => Centerline {
            tree: skeleton.as_ref().clone(),
            origin: loaded.plain.mesh.origin,
            ..Centerline::default()
        },
        None => {
            let mut stage = progress.stage(proposing);
            stage(0, 1);
            let proposed = model.endpoints.is_empty();
            let mut endpoints = model.endpoints.to_vec();
            if proposed {
                proposals = propose(&loaded.surface, cancel).ok_or_else(stopped)?;
                let ends = proposals.iter().map(|one| one.endpoint.clone());
                endpoints = ends.collect();
            }
            if proposed && endpoints.len() < 2 {
                return Err(NO_ENDS.to_owned());
            }
            let look = model.lines.unwrap_or_default();
            let params = Params {
                proposed,
                ..look.params(loaded.side())
            };
            let mut stage = progress.stage(finding);
            let told = &mut |done: usize, of: usize| stage(done, of.max(STAGES));
            centerline(&loaded.surface, &endpoints, &params, cancel, told)
                .map_err(|error| error.to_string())?
        }
    };
    let found_in = began.elapsed();
    let mut stage = progress.stage(measuring);
    stage(0, 2);
    let began = Instant::now();
    let automatic = model.endpoints.is_empty() && loaded.skeleton.is_none();
    let mut analysis = Analysis::new(loaded.facts.clone(), &centerline, automatic, loaded.loops);
    analysis.timing_ms.centerline = found_in.as_secs_f64() * 1e3;
    analysis.timing_ms.measure = began.elapsed().as_secs_f64() * 1e3;
    stage(1, 2);
    let proposals = taken(proposals, &centerline);
    Lines::new(centerline, analysis, proposals, &loaded.plain, cancel).ok_or_else(stopped)
}

/// What is said of a surface on which no two ends were found.
const NO_ENDS: &str = "no ends were found on its surface: set a source and targets by hand";

fn stopped() -> String {
    CenterlineError::Cancelled.to_string()
}

/// The proposals that centerlines begin and end at, as sources and targets that they were taken for.
fn taken(proposals: Vec<Proposal>, found: &Centerline) -> Vec<Proposal> {
    let of = |mut proposal: Proposal| {
        let mut ends = found.endpoints.iter();
        let end = ends.find(|end| end.point == proposal.endpoint.point)?;
        proposal.endpoint.kind = end.kind;
        Some(proposal)
    };
    proposals.into_iter().filter_map(of).collect()
}
