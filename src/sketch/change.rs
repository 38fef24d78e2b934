//! Changing a sketch: pure functions from one sketch to the next.
//!
//! The old sketch stays as it is and shares every untouched stroke with the new one, which makes
//! undo a matter of keeping the old value. A change that would break an invariant is refused with
//! a reason; nothing is half done. Places are given in the sketch's axes from its root, the way a
//! hand points at them.

use std::{collections::HashSet, sync::Arc};

use glam::{DVec3, Vec3};

use super::{
    BOUNDS, Habit, Letter, NodeRef, SelfSimilar, Sketch, SketchError, Stroke, Symmetry, Wrap,
    quantize,
};

/// Lengths may be this much below the shortest segment: half a step of the grid, metres.
const GRID_SLACK: f64 = 0.000_05;

/// More strokes than letters: their bound is far below.
pub(super) const NO_LETTER: SketchError = SketchError::TooMany {
    what: "strokes",
    most: BOUNDS.strokes,
};

impl Sketch {
    /// Adds a segment from `from` to the place `to`: at an apex the stroke grows, at any other node
    /// a new branch starts, with the first free letter. Gives the new sketch and its new apex.
    ///
    /// # Errors
    /// Where `from` does not exist or is the root of a trunk that has segments, and where `to` is
    /// not finite, out of bounds or too close.
    pub fn add_segment(&self, from: NodeRef, to: Vec3) -> Result<(Self, NodeRef), SketchError> {
        self.add_segments(from, &[to])
    }

    /// Adds several segments at once, as a free-hand stroke does. No place: nothing changes.
    ///
    /// # Errors
    /// As for [`Self::add_segment`].
    pub fn add_segments(&self, from: NodeRef, to: &[Vec3]) -> Result<(Self, NodeRef), SketchError> {
        self.check_node(from)?;
        let from = self.own_name(from);
        if to.is_empty() {
            return Ok((self.clone(), from));
        }
        let mut next = self.clone();
        let (letter, _) = next.stroke_to_draw(from)?;
        let start = next.start(letter).ok_or(SketchError::NoStroke(letter))?;
        let added: Vec<Vec3> = to.iter().map(|&to| quantize::point(to - start)).collect();
        next.edit_stroke(letter, |stroke| stroke.append_plain(added))?;
        next.validate()?;
        let apex = next.apex(letter).ok_or(SketchError::NoStroke(letter))?;
        Ok((next, apex))
    }

    /// The same with radii of its own for each of them, metres as large as the sketch; 0: by da Vinci's rule.
    ///
    /// # Errors
    /// As for [`Self::add_segment`], and where there is not one radius for each, or one is out of bounds.
    pub fn add_thick_segments(
        &self,
        from: NodeRef,
        to: &[Vec3],
        radii: &[f32],
    ) -> Result<(Self, NodeRef), SketchError> {
        let (mut next, apex) = self.add_segments(from, to)?;
        if radii.len() != to.len() {
            return Err(SketchError::Radii(apex.letter, radii.len(), to.len()));
        }
        next.edit_stroke(apex.letter, |stroke| {
            let before = stroke.points.len() - to.len();
            stroke.radii.resize(before, 0.0);
            stroke
                .radii
                .extend(radii.iter().copied().map(quantize::radius));
            stroke.tidy_radii();
        })?;
        next.validate()?;
        Ok((next, apex))
    }

    /// The sketch with a letter as thick as what grows from it makes it, whatever radii it had.
    ///
    /// # Errors
    /// Where the letter does not exist.
    pub fn without_radii(&self, letter: Letter) -> Result<Self, SketchError> {
        let mut next = self.clone();
        next.edit_stroke(letter, |stroke| stroke.radii = Vec::new())?;
        Ok(next)
    }

    /// Draws a curve from `from` through places of the sketch, its handles, with so many segments on the
    /// way to each; at an apex the stroke grows, elsewhere a new branch starts. With a symmetry, a
    /// new branch is drawn with its copies, and one that goes on, with those that are images of it. Gives
    /// the new sketch and the new apex.
    ///
    /// # Errors
    /// As for [`Self::add_segment`]; where a place has no number of segments or none at all, and where the symmetry
    /// is out of bounds.
    pub fn draw_curve(
        &self,
        from: NodeRef,
        through: &[Vec3],
        segments: &[u32],
        symmetry: Symmetry,
    ) -> Result<(Self, NodeRef), SketchError> {
        self.check_node(from)?;
        check_curve(through, segments, symmetry)?;
        let from = self.own_name(from);
        let mut next = self.clone();
        let (letter, is_new) = next.stroke_to_draw(from)?;
        let twins = match is_new {
            true => Vec::new(),
            false => self.twins(letter, symmetry),
        };
        let start = next.start(letter).ok_or(SketchError::NoStroke(letter))?;
        let places: Vec<Vec3> = through
            .iter()
            .map(|&to| quantize::point(to - start))
            .collect();
        next.edit_stroke(letter, |stroke| stroke.append_curve(&places, segments))?;
        for (twin, image) in twins {
            let images: Vec<Vec3> = places.iter().map(|&place| image.of(place)).collect();
            next.edit_stroke(twin, |stroke| stroke.append_curve(&images, segments))?;
        }
        if is_new && let Some(drawn) = next.strokes.last().map(Arc::clone) {
            next.add_copies(&drawn, symmetry)?;
        }
        next.validate()?;
        let apex = next.apex(letter).ok_or(SketchError::NoStroke(letter))?;
        Ok((next, apex))
    }

    /// The letter that drawing from a node goes to, and whether it is a new branch, which is then there without segments.
    fn stroke_to_draw(&mut self, from: NodeRef) -> Result<(Letter, bool), SketchError> {
        if self.is_apex(from) {
            return Ok((from.letter, false));
        }
        if from == NodeRef::ROOT {
            return Err(SketchError::BranchAtRoot);
        }
        let letter = self.free_letter()?;
        let own_rate = SelfSimilar {
            rate: from.node,
            depth_limit: None,
        };
        self.strokes.push(Arc::new(Stroke {
            letter,
            points: Vec::new(),
            handles: Vec::new(),
            attachment: Some(from),
            self_similar: self.self_similar_branches.then_some(own_rate),
            radii: Vec::new(),
        }));
        Ok((letter, true))
    }

    /// Moves a node to the place `to`; branches that start at it travel along. On a plain stroke its neighbours
    /// stay. On a curve it becomes a handle if it was none; the other handles stay, and the nodes in the two spans to
    /// either side lie on the new curve, as many as before.
    ///
    /// # Errors
    /// Where the node does not exist or is a stroke's start, and where `to` is not finite, out of
    /// bounds or too close to a neighbour.
    pub fn move_node(&self, at: NodeRef, to: Vec3) -> Result<Self, SketchError> {
        self.own_node(at)?;
        let start = self
            .start(at.letter)
            .ok_or(SketchError::NoStroke(at.letter))?;
        let mut next = self.clone();
        next.edit_stroke(at.letter, |stroke| {
            stroke.move_own_node(at.node, to - start);
        })?;
        next.validate()?;
        Ok(next)
    }

    /// Deletes a node and all above it on its line, with the branches attached there and theirs.
    /// A branch that loses its first node goes as a whole. Gives the new sketch and the node that
    /// the line ended on.
    ///
    /// # Errors
    /// Where the node does not exist or is a stroke's start.
    pub fn delete_node(&self, at: NodeRef) -> Result<(Self, NodeRef), SketchError> {
        let index = self.own_node(at)?;
        let below = NodeRef::new(at.letter, at.node.saturating_sub(1));
        let mut end = below;
        let mut gone = HashSet::new();
        let mut next = self.clone();
        next.strokes.clear();
        for stroke in &self.strokes {
            // Attachments name earlier strokes, so one pass finds every branch of a branch.
            let lost = stroke.attachment.is_some_and(|to| {
                gone.contains(&to.letter) || (to.letter == at.letter && to.node >= at.node)
            });
            match stroke.attachment {
                _ if lost => {
                    gone.insert(stroke.letter);
                }
                Some(foot) if stroke.letter == at.letter && index == 0 => {
                    end = foot;
                    gone.insert(stroke.letter);
                }
                _ if stroke.letter == at.letter => {
                    let mut shorter = Stroke::clone(stroke);
                    shorter.truncate(index);
                    next.strokes.push(Arc::new(shorter));
                }
                _ => next.strokes.push(Arc::clone(stroke)),
            }
        }
        Ok((next, end))
    }

    /// Deletes everything drawn; angles and sizes stay.
    #[must_use]
    pub fn clear(&self) -> Self {
        let mut next = self.clone();
        next.strokes = Self::default().strokes;
        next
    }

    /// Switches a letter's copies of itself on (with rate and depth limit) or off.
    ///
    /// # Errors
    /// Where the letter does not exist, the rate is 0 or out of bounds, or a rule of a person's own gives the letter other
    /// parameters than it would have.
    pub fn with_self_similar(
        &self,
        letter: Letter,
        self_similar: Option<SelfSimilar>,
    ) -> Result<Self, SketchError> {
        let mut next = self.clone();
        next.edit_stroke(letter, |stroke| stroke.self_similar = self_similar)?;
        next.validate()?;
        if next.declaration(letter) != self.declaration(letter) {
            next.check_parameters(letter)?;
        }
        Ok(next)
    }

    /// Sets the turn from one branch to the next, in degrees: any angle within [`BOUNDS`], brought
    /// to 0…360.
    ///
    /// # Errors
    /// Where the angle is not finite or beyond the bounds.
    pub fn with_divergence(&self, degrees: f64) -> Result<Self, SketchError> {
        let mut next = self.clone();
        let most = BOUNDS.angle_deg;
        within("the divergence angle in degrees", degrees, [-most, most])?;
        next.divergence_deg = quantize::angle_deg(quantize::angle_deg(degrees).rem_euclid(360.0));
        next.validate()?;
        Ok(next)
    }

    /// Sets full size over sketch, the radius of a tip at full size (metres), and the exponent of
    /// da Vinci's rule.
    ///
    /// # Errors
    /// Where one is not finite or out of bounds.
    pub fn with_sizes(&self, scale: f32, tip: f32, exponent: f32) -> Result<Self, SketchError> {
        let mut next = self.clone();
        next.scale = quantize::coordinate(scale);
        next.tip_radius = quantize::coordinate(tip);
        next.radius_exponent = quantize::coordinate(exponent);
        next.validate()?;
        Ok(next)
    }

    /// Sets how a line goes on after its last drawn segment.
    #[must_use]
    pub fn with_wrap(&self, wrap: Wrap) -> Self {
        Self {
            wrap,
            ..self.clone()
        }
    }

    /// Sets how the tree grows beyond what is drawn, and what it wears.
    ///
    /// # Errors
    /// A number out of its bounds, a line that no grammar reads, or a rule of a person's own that cannot be read beside the new laws.
    pub fn with_habit(&self, habit: Habit) -> Result<Self, SketchError> {
        habit.validate()?;
        let next = Self {
            habit: Arc::new(habit),
            ..self.clone()
        };
        next.check_own_rules()?;
        for stroke in &next.strokes {
            next.check_parameters(stroke.letter)?;
        }
        Ok(next)
    }

    /// A branch's node 0 is its parent's node: gives the node under the parent's name.
    #[must_use]
    pub fn own_name(&self, at: NodeRef) -> NodeRef {
        let foot = self.stroke(at.letter).and_then(|stroke| stroke.attachment);
        foot.filter(|_| at.node == 0).unwrap_or(at)
    }

    /// # Errors
    /// Where the node does not exist.
    pub(crate) fn check_node(&self, at: NodeRef) -> Result<(), SketchError> {
        let apex = self
            .apex(at.letter)
            .ok_or(SketchError::NoStroke(at.letter))?;
        if at.node > apex.node {
            return Err(SketchError::NoNode(at.letter, at.node, apex.node));
        }
        Ok(())
    }

    /// The place of a node in its stroke's points.
    ///
    /// # Errors
    /// Where it does not exist or is the stroke's start, which is not its own.
    fn own_node(&self, at: NodeRef) -> Result<usize, SketchError> {
        self.check_node(at)?;
        if at.node > 0 {
            return Ok(at.node as usize - 1);
        }
        match self.stroke(at.letter).and_then(|stroke| stroke.attachment) {
            Some(foot) => Err(SketchError::StartOfBranch(
                at.letter,
                foot.letter,
                foot.node,
            )),
            None => Err(SketchError::Root),
        }
    }

    pub(super) fn free_letter(&self) -> Result<Letter, SketchError> {
        self.free_letters().next().ok_or(NO_LETTER)
    }

    /// All letters that name no stroke.
    pub(super) fn free_letters(&self) -> impl Iterator<Item = Letter> + use<> {
        let taken: HashSet<Letter> = self.strokes.iter().map(|stroke| stroke.letter).collect();
        (1..=u16::MAX)
            .map(Letter::from_index)
            .filter(move |letter| !taken.contains(letter))
    }

    /// Gives a stroke a changed copy, leaving the shared one to the sketches that hold it.
    fn edit_stroke(
        &mut self,
        letter: Letter,
        change: impl FnOnce(&mut Stroke),
    ) -> Result<(), SketchError> {
        let index = self.index_of(letter).ok_or(SketchError::NoStroke(letter))?;
        let stroke = self
            .strokes
            .get_mut(index)
            .ok_or(SketchError::NoStroke(letter))?;
        change(Arc::make_mut(stroke));
        Ok(())
    }

    /// Checks every invariant of [`Sketch`], in time proportional to its size.
    ///
    /// # Errors
    /// The first one broken.
    pub fn validate(&self) -> Result<(), SketchError> {
        self.validate_settings()?;
        self.habit.validate()?;
        if self.strokes.len() > BOUNDS.strokes {
            return Err(SketchError::TooMany {
                what: "strokes",
                most: BOUNDS.strokes,
            });
        }
        let points: usize = self.strokes.iter().map(|stroke| stroke.points.len()).sum();
        if points > BOUNDS.points {
            return Err(SketchError::TooMany {
                what: "nodes",
                most: BOUNDS.points,
            });
        }
        if self.strokes.is_empty() {
            return Err(SketchError::NoStroke(Letter::TRUNK));
        }
        // Start and stroke of each letter seen so far: an attachment must find its own here, so
        // there can be no cycle.
        let mut seen = std::collections::HashMap::with_capacity(self.strokes.len());
        for (index, stroke) in self.strokes.iter().enumerate() {
            let start = match stroke.attachment {
                None if index == 0 && stroke.letter == Letter::TRUNK => DVec3::ZERO,
                Some(at) if index > 0 && stroke.letter != Letter::TRUNK => {
                    let bad = SketchError::BadAttachment(stroke.letter, at.letter, at.node);
                    let (start, parent): &(DVec3, &Arc<Stroke>) =
                        seen.get(&at.letter).ok_or_else(|| bad.clone())?;
                    let offset = (at.node > 0).then(|| parent.offset(at.node)).flatten();
                    *start + offset.ok_or(bad)?.as_dvec3()
                }
                _ => return Err(SketchError::Loose(stroke.letter)),
            };
            stroke.validate(start)?;
            if seen.insert(stroke.letter, (start, stroke)).is_some() {
                return Err(SketchError::Twice(stroke.letter));
            }
        }
        Ok(())
    }

    fn validate_settings(&self) -> Result<(), SketchError> {
        within(
            "the divergence angle in degrees",
            self.divergence_deg,
            [0.0, 360.0],
        )?;
        let [least, most] = BOUNDS.scale.map(f64::from);
        within("the scale", self.scale.into(), [least, most])?;
        let [least, most] = BOUNDS.tip_radius.map(f64::from);
        within(
            "the tip radius in metres",
            self.tip_radius.into(),
            [least, most],
        )?;
        let [least, most] = BOUNDS.radius_exponent.map(f64::from);
        within(
            "the exponent of the radii",
            self.radius_exponent.into(),
            [least, most],
        )
    }
}

impl Stroke {
    /// Checks the stroke itself, given where it starts.
    fn validate(&self, start: DVec3) -> Result<(), SketchError> {
        if self.points.is_empty() && self.attachment.is_some() {
            return Err(SketchError::EmptyBranch(self.letter));
        }
        if let Some(own) = self.self_similar {
            let most = f64::from(u32::try_from(BOUNDS.points).unwrap_or(u32::MAX));
            within(
                "the rate of a branch's copies",
                own.rate.into(),
                [1.0, most],
            )?;
            let depth = own.depth_limit.unwrap_or(0);
            within("the depth limit", depth.into(), [0.0, BOUNDS.depth.into()])?;
        }
        if !self.handles_are_sound() {
            return Err(SketchError::Handles(self.letter));
        }
        if ![0, self.points.len()].contains(&self.radii.len()) {
            let (radii, nodes) = (self.radii.len(), self.points.len());
            return Err(SketchError::Radii(self.letter, radii, nodes));
        }
        let [least, most] = BOUNDS.radius.map(f64::from);
        for radius in self.radii.iter().filter(|radius| **radius != 0.0) {
            within("a radius in metres", (*radius).into(), [least, most])?;
        }
        let most = f64::from(BOUNDS.coordinate);
        let shortest = f64::from(BOUNDS.segment) - GRID_SLACK;
        let mut below = DVec3::ZERO;
        for (number, point) in (1_u32..).zip(&self.points) {
            let point = point.as_dvec3();
            for coordinate in (start + point).to_array() {
                within("a coordinate in metres", coordinate, [-most, most])?;
            }
            if point.distance(below) < shortest {
                return Err(SketchError::TooShort(self.letter, number));
            }
            below = point;
        }
        Ok(())
    }
}

/// Checks what a curve is drawn from before any memory is taken for it.
fn check_curve(through: &[Vec3], segments: &[u32], symmetry: Symmetry) -> Result<(), SketchError> {
    let turns = [1.0, Symmetry::TURNS_MOST.into()];
    within("the turns of the symmetry", symmetry.turns.into(), turns)?;
    if through.is_empty() || through.len() != segments.len() || segments.contains(&0) {
        return Err(SketchError::Spans);
    }
    let nodes: u64 = segments.iter().copied().map(u64::from).sum();
    if nodes > BOUNDS.points as u64 {
        return Err(SketchError::TooMany {
            what: "nodes",
            most: BOUNDS.points,
        });
    }
    through
        .iter()
        .flat_map(|to| to.to_array())
        .try_for_each(|coordinate| finite("a coordinate in metres", coordinate.into()))
}

fn finite(what: &'static str, value: f64) -> Result<(), SketchError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(SketchError::NotFinite(what))
    }
}

pub(super) fn within(
    what: &'static str,
    found: f64,
    [least, most]: [f64; 2],
) -> Result<(), SketchError> {
    finite(what, found)?;
    if found < least || found > most {
        return Err(SketchError::OutOfBounds {
            what,
            found,
            least,
            most,
        });
    }
    Ok(())
}
