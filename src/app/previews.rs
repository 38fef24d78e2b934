//! Pictures of the next individuals of the tree on the platform, drawn on a thread with a device of its own while the row of them is looked at.
//!
//! One is made after the other, so that the first is soon there, and each frame takes at most one. When the sketch, a law, the season or the step changes, what
//! is being made is cancelled and all begin anew; only the row's pictures are kept. Whether chance has a part in the sketch is not read from its
//! laws, which may be anybody's rules: individuals are alike where those that were grown are.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::individuals::of_seed;
use super::portrait::{Easel, PAPER};
use super::worker::Worker;
use crate::sketch::Sketch;
use crate::tree::Drawing;
use crate::ui::{Panels, Preview, Previews as Row, Thumbnail};
use crate::world::document::Document;

/// Pixels of a picture's side: as many as the row shows.
const PIXELS: u32 = 112;

/// A picture to make.
struct Wanted {
    sketch: Arc<Sketch>,
    step: u32,
    seed: u32,
}

/// What became of it.
struct Made {
    of: Arc<Sketch>,
    step: u32,
    seed: u32,
    /// The picture, or why there is none.
    picture: Result<Thumbnail, String>,
    /// What tells individuals apart; none where it did not grow.
    print: Option<u64>,
}

/// See the module.
pub(super) struct Previews {
    worker: Worker<Wanted, Made>,
    /// What the pictures are of; its seed is not looked at.
    of: Option<(Arc<Sketch>, u32)>,
    /// The sketch that was looked at last: the same, or one that is alike.
    seen: Option<Arc<Sketch>>,
    /// The seed of which one is being made.
    at: Option<u32>,
    made: Vec<(Preview, Option<u64>)>,
    /// Whether the panels have not been given all of that yet.
    is_new: bool,
}

impl Previews {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        Ok(Self {
            worker: Worker::start_with("ramus-previews", || None, make)?,
            of: None,
            seen: None,
            at: None,
            made: Vec::new(),
            is_new: false,
        })
    }

    /// Goes on with what the panels show of the document.
    pub(super) fn follow(&mut self, panels: &mut Panels, document: &Document) {
        let Some(seeds) = panels.seeds_shown() else {
            return self.rest();
        };
        self.follow_sketch(document);
        if self.at.is_some()
            && let Some(made) = self.worker.poll()
        {
            self.take(made);
        }
        let before = self.made.len();
        self.made.retain(|(one, _)| seeds.contains(&one.seed));
        self.is_new |= self.made.len() != before;
        self.ask(&seeds);
        self.give(panels);
    }

    /// Waits until all that are shown are there.
    pub(super) fn finish(&mut self, panels: &mut Panels, document: &Document) {
        self.follow(panels, document);
        while self.at.is_some() {
            let Some(made) = self.worker.wait() else {
                return;
            };
            self.take(made);
            self.follow(panels, document);
        }
    }

    /// Whether one is being made.
    pub(super) fn is_busy(&self) -> bool {
        self.at.is_some()
    }

    /// Nobody looks: what is being made is not needed.
    fn rest(&mut self) {
        if self.at.take().is_some() {
            self.worker.cancel();
        }
    }

    /// Begins anew where another tree is to be seen.
    fn follow_sketch(&mut self, document: &Document) {
        let (sketch, step) = (&document.sketch, document.step);
        let is_seen = |seen: &Arc<Sketch>| Arc::ptr_eq(seen, sketch);
        let was_seen = self.seen.as_ref().is_some_and(is_seen);
        self.seen = Some(Arc::clone(sketch));
        let same = |(of, at): &(Arc<Sketch>, u32)| {
            *at == step && (was_seen || Arc::ptr_eq(of, sketch) || is_alike(of, sketch))
        };
        if !self.of.as_ref().is_some_and(same) {
            self.rest();
            self.is_new |= !self.made.is_empty();
            self.made.clear();
            self.of = Some((Arc::clone(sketch), step));
        }
    }

    fn take(&mut self, made: Made) {
        self.at = None;
        let same =
            |(of, step): &(Arc<Sketch>, u32)| Arc::ptr_eq(of, &made.of) && *step == made.step;
        if self.of.as_ref().is_some_and(same) {
            let one = Preview {
                seed: made.seed,
                picture: made.picture,
            };
            self.made.push((one, made.print));
            self.is_new = true;
        }
    }

    /// Asks for the next one that is not there.
    fn ask(&mut self, seeds: &[u32]) {
        let Some((sketch, step)) = self.of.clone() else {
            return;
        };
        if self.at.is_some_and(|at| !seeds.contains(&at)) {
            self.rest();
        }
        if self.at.is_some() || sketch.is_empty() || step == 0 {
            return;
        }
        let is_there = |seed: &u32| self.made.iter().any(|(one, _)| one.seed == *seed);
        let Some(seed) = seeds.iter().copied().find(|seed| !is_there(seed)) else {
            return;
        };
        self.at = Some(seed);
        self.worker.ask(Wanted { sketch, step, seed });
    }

    /// Gives the panels what changed.
    fn give(&mut self, panels: &mut Panels) {
        if !std::mem::take(&mut self.is_new) {
            return;
        }
        let prints: Vec<u64> = self.made.iter().filter_map(|(_, print)| *print).collect();
        let are_alike = prints.len() > 1 && prints.windows(2).all(|pair| pair[0] == pair[1]);
        let all = self.made.iter().map(|(one, _)| one.clone()).collect();
        panels.give_previews(Row { all, are_alike });
    }
}

/// Whether two sketches differ in their seeds at most.
fn is_alike(one: &Sketch, other: &Sketch) -> bool {
    *one == other.with_seed(one.habit.seed)
}

/// Grows an individual and draws it; the device is opened for the first one.
fn make(easel: &mut Option<Easel>, wanted: &Wanted, cancel: &AtomicBool) -> Made {
    let Wanted { sketch, step, seed } = wanted;
    let grown = of_seed(sketch, *step, *seed, cancel);
    let print = grown.as_ref().ok().map(print_of);
    let picture = match grown {
        // Nobody waits for it any more.
        _ if cancel.load(Ordering::Relaxed) => Err("it was cancelled".to_owned()),
        Ok(drawing) => draw(drawing, easel).map_err(|error| format!("{error:#}")),
        Err(error) => Err(error.to_string()),
    };
    Made {
        of: Arc::clone(sketch),
        step: *step,
        seed: *seed,
        picture,
        print,
    }
}

fn draw(drawing: Drawing, easel: &mut Option<Easel>) -> anyhow::Result<Thumbnail> {
    let open = match easel {
        Some(open) => open,
        None => easel.insert(Easel::new(PIXELS, PAPER)?),
    };
    let picture = open.draw(drawing)?;
    Ok(Thumbnail {
        side: PIXELS as usize,
        rgba: picture.into_raw(),
    })
}

/// A number that individuals share only where they are the same.
fn print_of(drawing: &Drawing) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut take = |place: glam::Vec3| place.to_array().map(f32::to_bits).hash(&mut hasher);
    drawing.tree.position.iter().for_each(|place| take(*place));
    let organs = &drawing.organs;
    organs.placed.iter().for_each(|one| take(one.position));
    organs.spheres.iter().for_each(|one| take(one.center));
    organs.corners.iter().for_each(|place| take(*place));
    hasher.finish()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::world::species::SPECIES;

    #[test]
    fn a_seed_alone_is_the_same_row_and_a_season_is_another() {
        let sketch = SPECIES[0].document().sketch;
        assert!(is_alike(&sketch, &sketch.with_seed(9)));
        let other = sketch.in_season(crate::tree::foliage::Season::Winter);
        assert!(!is_alike(&sketch, &other));
    }

    #[test]
    fn prints_tell_individuals_apart() {
        let never = AtomicBool::new(false);
        let fern = SPECIES.iter().find(|one| one.name == "fern").unwrap();
        let fern = fern.document();
        let print = |seed| print_of(&of_seed(&fern.sketch, fern.step, seed, &never).unwrap());
        assert_eq!(print(4), print(4));
        assert_ne!(print(4), print(5));
    }
}
