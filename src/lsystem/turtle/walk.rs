//! Reading: module after module moves the pen and draws.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec4};

use super::super::error::{DeriveError, DeriveProblem};
use super::super::grammar::Grammar;
use super::super::names::Symbol;
use super::super::shape::Shape;
use super::super::string::{Module, ModuleString, arity_of};
use super::TurtleParams;
use super::action::{Action, actions};
use super::canvas::{Canvas, Drawn, Outline, narrow, narrowed};
use super::grown::Grown;
use super::pen::{Cylinder, NO_SHAPE, Pen, Stance};
use crate::tree::NO_PARENT;

/// Modules read between two looks at the cancel flag,
const CHECK_EVERY: u64 = 1 << 14;
/// of a string's.
const BLOCK: usize = 1 << 10;

/// Ends of an outline nearer than this part of its size are one vertex.
const CLOSED: f64 = 1e-9;

/// An outline that is being traced.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// Its first vertex, in the list of all.
    first: usize,
    node: u32,
    /// Index of the `{`.
    position: u64,
}

/// The turtle: a pen, a pen for each open bracket, and the vertices of open outlines.
pub struct Turtle<'a, C> {
    grammar: &'a Grammar,
    pub(super) params: &'a TurtleParams,
    /// By symbol.
    actions: Vec<Action>,
    pub(super) pen: Pen,
    stack: Vec<Pen>,
    /// Brackets within brackets at most.
    deepest: usize,
    /// Brackets that were open where it began.
    below: usize,
    /// How large the segments of shapes are drawn.
    pub(super) shape_scale: f64,
    outlines: Vec<Open>,
    /// Of all open outlines, the outermost first.
    vertices: Vec<DVec3>,
    /// Modules read.
    position: u64,
    canvas: C,
}

impl<'a, C: Canvas> Turtle<'a, C> {
    /// A turtle at its start, on a canvas with nothing but the start.
    #[must_use]
    pub fn new(grammar: &'a Grammar, params: &'a TurtleParams, canvas: C) -> Self {
        Self::within(grammar, params, actions(grammar, params), canvas)
    }

    /// The same with what each symbol does.
    pub(super) fn within(
        grammar: &'a Grammar,
        params: &'a TurtleParams,
        actions: Vec<Action>,
        canvas: C,
    ) -> Self {
        Self {
            grammar,
            params,
            actions,
            pen: Pen::new(params.width),
            stack: Vec::new(),
            deepest: deepest(params),
            below: 0,
            shape_scale: 1.0,
            outlines: Vec::new(),
            vertices: Vec::new(),
            position: 0,
            canvas,
        }
    }

    /// Where it stands.
    #[must_use]
    pub fn pen(&self) -> &Pen {
        &self.pen
    }

    /// Puts it into a branch with so many brackets round it.
    pub(super) fn go_to(&mut self, pen: Pen, depth: usize) {
        (self.pen, self.below) = (pen, depth);
    }

    /// Whether no bracket is open that was not where it began.
    pub(super) fn is_level(&self) -> bool {
        self.stack.is_empty()
    }

    /// Brackets round it.
    pub(super) fn depth(&self) -> usize {
        self.below + self.stack.len()
    }

    /// The pen in a branch that begins here, and the brackets round it.
    pub(super) fn inside(&mut self) -> Result<(Pen, usize), DeriveError> {
        self.push()?;
        let depth = self.depth();
        let before = self.stack.pop().unwrap_or(self.pen);
        Ok((std::mem::replace(&mut self.pen, before), depth))
    }

    /// Index of the module that is read next, or was refused.
    pub(super) fn position(&self) -> u64 {
        self.position
    }

    /// Goes on at another module.
    pub(super) fn set_position(&mut self, position: u64) {
        self.position = position;
    }

    pub(super) fn canvas_mut(&mut self) -> &mut C {
        &mut self.canvas
    }

    /// Reads a string, which may be a part of one whose parts before it are read.
    ///
    /// # Errors
    /// The turtle's limits, positions beyond f32, what the canvas cannot hold, or `cancel` being set.
    pub fn read(&mut self, string: &ModuleString, cancel: &AtomicBool) -> Result<(), DeriveError> {
        self.read_part(string, 0..string.len(), 0, cancel)
    }

    /// Reads modules that come one after the other.
    pub(super) fn read_modules<'m>(
        &mut self,
        modules: impl Iterator<Item = Module<'m>>,
        cancel: &AtomicBool,
    ) -> Result<(), DeriveError> {
        self.read_grown(modules.map(|module| (module, Grown::WHOLE)), cancel)
    }

    /// Reads modules of a string, before which so many parameters stand. They are widened a block at a time, so that one loop
    /// does for strings of all widths.
    pub(super) fn read_part(
        &mut self,
        string: &ModuleString,
        modules: Range<usize>,
        parameters: usize,
        cancel: &AtomicBool,
    ) -> Result<(), DeriveError> {
        let (mut symbols, mut births) = ([0_u16; BLOCK], [0_u32; BLOCK]);
        let mut rest = string.parameters.get(parameters..).unwrap_or(&[]);
        let mut from = modules.start;
        while from < modules.end {
            let length = BLOCK.min(modules.end - from);
            let (Some(symbols), Some(births)) =
                (symbols.get_mut(..length), births.get_mut(..length))
            else {
                break;
            };
            string.symbols.read(from, symbols);
            string.births.read(from, births);
            if cancel.load(Ordering::Relaxed) {
                let step = births.iter().copied().max().unwrap_or(0);
                return Err(DeriveProblem::Cancelled { step }.into());
            }
            // Without parameters no module is asked for its own.
            rest = match string.parameters.is_empty() {
                true => self.read_block::<false>(&string.arity, symbols, births, rest)?,
                false => self.read_block::<true>(&string.arity, symbols, births, rest)?,
            };
            from += length;
        }
        Ok(())
    }

    /// Reads modules of which symbols, births and parameters are given; returns the parameters behind theirs. What most strings consist
    /// of is done here, with the stance in registers, and is what [`Self::step`] does.
    fn read_block<'p, const HAS_PARAMETERS: bool>(
        &mut self,
        arity: &[u8],
        symbols: &[Symbol],
        births: &[u32],
        mut rest: &'p [f64],
    ) -> Result<&'p [f64], DeriveError> {
        let start = self.position;
        // A ground may turn the stance, which would have to lie in memory for that.
        let is_free = self.grammar.ground.is_none();
        let mut stance = self.pen.stance();
        for (at, (symbol, birth)) in (start..).zip(symbols.iter().zip(births)) {
            let mut parameters: &[f64] = &[];
            if HAS_PARAMETERS {
                let arity = arity_of(arity, *symbol);
                (parameters, rest) = rest.split_at(arity.min(rest.len()));
            }
            let first = parameters.first().copied();
            match self.actions.get_mut(usize::from(*symbol)) {
                None | Some(Action::Nothing) => {}
                Some(Action::Turn(turn)) => {
                    let degrees = first.or_else(|| self.pen.scaled_turn(turn.default_degrees));
                    stance.turn_about(turn.axis, turn.half(degrees));
                }
                Some(Action::Draw) if is_free && self.outlines.is_empty() => {
                    self.position = at;
                    let by = self.drawn(*symbol, *birth);
                    let length = first.unwrap_or(self.params.length * self.pen.length_scale);
                    self.pen.shape = NO_SHAPE;
                    self.pen.stand(stance);
                    stance.position = stance.ahead(length);
                    self.draw(by, stance.position, None)?;
                    if let Some(vector) = self.bends() {
                        stance.bend(vector, self.pen.tropism);
                    }
                }
                Some(Action::Push) => {
                    self.position = at;
                    self.pen.stand(stance);
                    self.push()?;
                }
                Some(Action::Pop) => {
                    if let Some(pen) = self.stack.pop() {
                        self.pen = pen;
                        stance = pen.stance();
                    }
                }
                Some(Action::Width) => {
                    self.pen.width = first.unwrap_or(self.pen.width * self.params.narrow);
                }
                Some(Action::Level) => stance.level(),
                Some(_) => {
                    self.position = at;
                    self.pen.stand(stance);
                    self.step(Module {
                        symbol: *symbol,
                        birth: *birth,
                        parameters,
                    })?;
                    stance = self.pen.stance();
                }
            }
        }
        self.position = start + symbols.len() as u64;
        self.pen.stand(stance);
        Ok(rest)
    }

    /// The module that is read.
    fn drawn(&self, symbol: Symbol, birth: u32) -> Drawn {
        Drawn {
            symbol,
            birth,
            position: self.position,
        }
    }

    /// Reads modules that are partly grown.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn read_grown<'m>(
        &mut self,
        modules: impl Iterator<Item = (Module<'m>, Grown)>,
        cancel: &AtomicBool,
    ) -> Result<(), DeriveError> {
        for (module, grown) in modules {
            if self.position.is_multiple_of(CHECK_EVERY) && cancel.load(Ordering::Relaxed) {
                let step = module.birth;
                return Err(DeriveProblem::Cancelled { step }.into());
            }
            self.step_grown(module, grown)?;
            self.position += 1;
        }
        Ok(())
    }

    /// The canvas, when everything is read.
    ///
    /// # Errors
    /// An outline that is still open.
    pub fn finish(self) -> Result<C, DeriveError> {
        match self.outlines.last() {
            None => Ok(self.canvas),
            Some(open) => {
                let position = open.position;
                Err(DeriveProblem::OpenOutline { position }.into())
            }
        }
    }

    /// What a symbol makes it do.
    pub(super) fn action(&self, symbol: Symbol) -> Action {
        let action = self.actions.get(usize::from(symbol));
        action.copied().unwrap_or(Action::Nothing)
    }

    /// Reads one module.
    #[inline(never)]
    pub(super) fn step(&mut self, module: Module<'_>) -> Result<(), DeriveError> {
        let by = self.drawn(module.symbol, module.birth);
        let first = module.parameters.first().copied();
        let Some(action) = self.actions.get_mut(usize::from(module.symbol)) else {
            return Ok(());
        };
        match action {
            Action::Nothing => {}
            Action::Turn(turn) => {
                let degrees = first.or_else(|| self.pen.scaled_turn(turn.default_degrees));
                let (axis, half) = (turn.axis, turn.half(degrees));
                self.pen.change(|stance| stance.turn_about(axis, half));
            }
            Action::Draw => return self.forward(by, first, true),
            Action::DrawWithin => return self.forward(by, first, false),
            Action::Move => return self.skip(first, true),
            Action::MoveWithin => return self.skip(first, false),
            Action::Push => return self.push(),
            Action::Pop => {
                if let Some(pen) = self.stack.pop() {
                    self.pen = pen;
                }
            }
            Action::Width => {
                self.pen.width = first.unwrap_or(self.pen.width * self.params.narrow);
            }
            Action::ScaleWidth => self.pen.width *= first.unwrap_or(1.0),
            Action::ScaleLength => self.pen.length_scale *= first.unwrap_or(1.0),
            Action::ScaleAngle => self.pen.angle_scale *= first.unwrap_or(1.0),
            Action::Level => self.pen.change(Stance::level),
            Action::TurnAround => self.pen.change(Stance::turn_around),
            Action::Tropism => self.pen.tropism = first.unwrap_or(0.0),
            Action::NextColour => self.pen.colour = index(first, self.pen.colour, 1),
            Action::LastColour => self.pen.colour = index(first, self.pen.colour, -1),
            Action::Material => self.pen.material = index(first, self.pen.material, 1),
            Action::BeginCylinder => self.pen.cylinder = Cylinder::Begins,
            Action::EndCylinder => self.pen.cylinder = Cylinder::None,
            Action::Follow(shape) => {
                let shape = *shape;
                return self.follow(by, shape, first);
            }
            Action::Place(shape) => {
                let shape = *shape;
                return self.place(by, shape, first);
            }
            Action::BeginPolygon => self.outlines.push(Open {
                first: self.vertices.len(),
                node: self.pen.node,
                position: self.position,
            }),
            Action::Query => return self.canvas.query(&self.pen, by),
            Action::Vertex => return self.vertex(),
            Action::EndPolygon => return self.end_outline(by),
            Action::Sphere => {
                let radius = first.unwrap_or(self.pen.width / 2.0).abs();
                self.fits(by, radius)?;
                return self.canvas.sphere(&self.pen, by, radius);
            }
            Action::Surface => {
                let scale = first.unwrap_or(1.0);
                self.fits(by, scale)?;
                return self.canvas.surface(&self.pen, by, scale);
            }
        }
        Ok(())
    }

    fn push(&mut self) -> Result<(), DeriveError> {
        if self.below + self.stack.len() >= self.deepest {
            let problem = DeriveProblem::TooDeep {
                position: self.position,
                depth: self.deepest,
            };
            return Err(problem.into());
        }
        self.stack.push(self.pen);
        self.pen.order = self.pen.order.saturating_add(1);
        if let Cylinder::Of(_) = self.pen.cylinder {
            self.pen.cylinder = Cylinder::Begins;
        }
        Ok(())
    }

    /// `F` and `G`.
    #[inline]
    fn forward(
        &mut self,
        by: Drawn,
        length: Option<f64>,
        is_vertex: bool,
    ) -> Result<(), DeriveError> {
        let length = length.unwrap_or(self.params.length * self.pen.length_scale);
        self.pen.shape = NO_SHAPE;
        if self.outlines.is_empty() {
            let end = self.end(length);
            self.draw(by, end, None)?;
        } else {
            self.pen.jump(self.pen.stance().ahead(length));
            if is_vertex {
                self.vertex()?;
            }
        }
        self.bend();
        Ok(())
    }

    /// `f` and `g`.
    fn skip(&mut self, length: Option<f64>, is_vertex: bool) -> Result<(), DeriveError> {
        self.pen.shape = NO_SHAPE;
        let length = length.unwrap_or(self.params.length * self.pen.length_scale);
        self.pen.jump(self.pen.stance().ahead(length));
        if is_vertex { self.vertex() } else { Ok(()) }
    }

    #[inline]
    fn bend(&mut self) {
        if let Some(vector) = self.bends() {
            let tropism = self.pen.tropism;
            self.pen.change(|stance| stance.bend(vector, tropism));
        }
    }

    /// Where a segment of this length ends.
    #[inline]
    fn end(&mut self, length: f64) -> DVec3 {
        match self.grammar.ground {
            None => self.pen.stance().ahead(length),
            Some(ground) => self.pen.change(|stance| stance.ahead_above(length, ground)),
        }
    }

    /// Where a segment bends to.
    #[inline]
    fn bends(&self) -> Option<DVec3> {
        let vector = self.grammar.tropism;
        vector.filter(|_| self.pen.tropism != 0.0)
    }

    /// Draws the dictionary's segment that the module's parameter names, or the whole shape where it has none.
    fn follow(&mut self, by: Drawn, letter: u16, index: Option<f64>) -> Result<(), DeriveError> {
        let grammar = self.grammar;
        let Some(shape) = grammar.shapes.get(usize::from(letter)) else {
            return Ok(());
        };
        let scale = [self.shape_scale * self.pen.length_scale, self.shape_scale];
        match index {
            Some(index) => self.follow_segment(by, letter, shape, whole(index), scale),
            None => self.follow_all(by, letter, shape, scale),
        }
    }

    /// Draws a whole shape where the turtle stands, and leaves the turtle there.
    fn place(&mut self, by: Drawn, letter: u16, scale: Option<f64>) -> Result<(), DeriveError> {
        let grammar = self.grammar;
        let Some(shape) = grammar.shapes.get(usize::from(letter)) else {
            return Ok(());
        };
        let pen = self.pen;
        if let Cylinder::Of(_) = pen.cylinder {
            self.pen.cylinder = Cylinder::Begins;
        }
        self.follow_all(by, letter, shape, [scale.unwrap_or(1.0); 2])?;
        self.pen = pen;
        Ok(())
    }

    fn follow_all(
        &mut self,
        by: Drawn,
        letter: u16,
        shape: &Shape,
        scale: [f64; 2],
    ) -> Result<(), DeriveError> {
        self.pen.shape = NO_SHAPE;
        let mut index = 0.0;
        for _ in &shape.segments {
            self.follow_segment(by, letter, shape, index, scale)?;
            index += 1.0;
        }
        Ok(())
    }

    #[expect(clippy::float_cmp, reason = "both are whole numbers")]
    fn follow_segment(
        &mut self,
        by: Drawn,
        letter: u16,
        shape: &Shape,
        index: f64,
        scale: [f64; 2],
    ) -> Result<(), DeriveError> {
        let Some(segment) = shape.segments.get(remainder(index, shape.segments.len())) else {
            return Ok(());
        };
        let goes_on = self.pen.shape == letter && index == self.pen.segment + 1.0;
        let turn = if goes_on { segment.turn } else { segment.frame };
        self.pen.change(|stance| stance.turn(turn));
        let [longer, thicker] = scale;
        let length = segment.length * longer;
        if self.outlines.is_empty() {
            let radius = segment.radius.map(|radius| radius * thicker.abs());
            let end = self.end(length);
            self.draw(by, end, radius)?;
        } else {
            self.pen.jump(self.pen.stance().ahead(length));
            self.vertex()?;
        }
        (self.pen.shape, self.pen.segment) = (letter, index);
        self.bend();
        Ok(())
    }

    /// Draws the segment from here to `end`.
    #[inline(always)]
    fn draw(&mut self, by: Drawn, end: DVec3, radius: Option<f64>) -> Result<(), DeriveError> {
        let width = radius.map_or(self.pen.width.abs(), |radius| radius * 2.0);
        let radius = narrow(width / 2.0);
        let place = narrowed(end);
        // All four at once: this is done for each segment.
        if !place.extend(radius).abs().cmple(Vec4::MAX).all() {
            return Err(if place.is_finite() {
                self.too_wide(by, width)
            } else {
                self.too_far(by)
            });
        }
        if self.pen.node == NO_PARENT {
            self.pen.node = self.canvas.root(&self.pen, by, radius)?;
        }
        let node = self.canvas.segment(&self.pen, by, end, radius)?;
        if self.pen.cylinder == Cylinder::Begins {
            self.pen.cylinder = Cylinder::Of(node);
        }
        self.pen.node = node;
        self.pen.position = end;
        Ok(())
    }

    /// The outline's next vertex is here.
    fn vertex(&mut self) -> Result<(), DeriveError> {
        let Some(open) = self.outlines.last() else {
            return Ok(());
        };
        let position = self.pen.position;
        let own = self.vertices.get(open.first..).unwrap_or(&[]);
        if own.last() == Some(&position) {
            return Ok(());
        }
        if self.vertices.len() as u64 >= self.params.max_nodes {
            let limit = self.params.max_nodes;
            return Err(DeriveProblem::TooManyNodes { limit }.into());
        }
        self.vertices.push(position);
        Ok(())
    }

    fn end_outline(&mut self, by: Drawn) -> Result<(), DeriveError> {
        let Some(open) = self.outlines.pop() else {
            let position = by.position;
            return Err(DeriveProblem::NoOutline { position }.into());
        };
        let vertices = self.vertices.get(open.first..).unwrap_or(&[]);
        let vertices = without_closing(vertices);
        let fits = |v: &DVec3| narrowed(*v).is_finite();
        let result = if !vertices.iter().all(fits) {
            Err(self.too_far(by))
        } else if vertices.len() < 3 {
            Ok(())
        } else {
            let node = open.node;
            let outline = Outline { vertices, node };
            self.canvas.polygon(&self.pen, by, outline)
        };
        self.vertices.truncate(open.first);
        result
    }

    /// Whether something of this size here can be held.
    fn fits(&self, by: Drawn, size: f64) -> Result<(), DeriveError> {
        if !narrowed(self.pen.position).is_finite() {
            return Err(self.too_far(by));
        }
        if !narrow(size).is_finite() {
            return Err(self.too_wide(by, size));
        }
        Ok(())
    }

    #[cold]
    fn too_far(&self, by: Drawn) -> DeriveError {
        let module = self.grammar.name(by.symbol).to_owned();
        let position = by.position;
        DeriveProblem::TooFar { position, module }.into()
    }

    #[cold]
    fn too_wide(&self, by: Drawn, width: f64) -> DeriveError {
        let problem = DeriveProblem::TooWide {
            position: by.position,
            module: self.grammar.name(by.symbol).to_owned(),
            width,
        };
        problem.into()
    }
}

/// Pens take half of the memory at most: a stack doubles when it is full.
fn deepest(params: &TurtleParams) -> usize {
    let pens = params.limits.bytes / 2 / size_of::<Pen>() as u64;
    params
        .max_depth
        .min(usize::try_from(pens).unwrap_or(usize::MAX))
}

/// Numbers from here on are no u32.
const BEYOND: f64 = 4_294_967_296.0;

/// The number rounded down. Small ones, which is to say all of them, without a call.
#[inline]
fn whole(number: f64) -> f64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "in range"
    )]
    if (0.0..BEYOND).contains(&number) {
        f64::from(number as u32)
    } else {
        number.floor()
    }
}

/// A whole number modulo a length.
#[inline]
fn remainder(number: f64, length: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "in range; 0 ≤ remainder < length"
    )]
    match u32::try_from(length) {
        Ok(length) if (0.0..BEYOND).contains(&number) => (number as u32 % length.max(1)) as usize,
        Ok(length) => number.rem_euclid(f64::from(length)) as usize,
        Err(_) => 0,
    }
}

/// The index that a module gives, the nearest there is, or the next or last one.
fn index(given: Option<f64>, now: u16, by: i16) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast of a float takes the nearest value"
    )]
    given.map_or(now.saturating_add_signed(by), |index| index.round() as u16)
}

/// The vertices without a last one that is where the first is.
fn without_closing(vertices: &[DVec3]) -> &[DVec3] {
    let (Some(first), Some((last, rest))) = (vertices.first(), vertices.split_last()) else {
        return vertices;
    };
    let size = rest
        .iter()
        .fold(0.0_f64, |size, v| size.max(v.distance(*first)));
    if last.distance(*first) <= CLOSED * size {
        rest
    } else {
        vertices
    }
}
