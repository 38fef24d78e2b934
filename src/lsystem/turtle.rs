//! The turtle: reads a string once, from front to back, and writes a [`Tree`].
//!
//! Its frame is a unit quaternion whose own axes are X = right (−L), Y = heading H, Z = up U, so that the start (H = +Y, L = −X, U = +Z) is the
//! quaternion 1 and a shape's x, y, z are the stage's. `+` turns about U, `&` about L, `/` about H, all right-handed; the frame is
//! renormalised after every turn, positions are summed in f64. The stack of brackets is on the heap.
//!
//! What a `Tree` cannot hold (colours, materials, polygons, spheres, cylinders' ends, shapes placed with `~`) is read and
//! leaves the skeleton alone; `docs/src/language.md` lists each symbol.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DQuat, DVec3, Vec3};

use super::derive::{Limits, interpreted};
use super::error::{DeriveError, DeriveProblem};
use super::grammar::Grammar;
use super::names::Symbol;
use super::shape::Shape;
use super::string::ModuleString;
use crate::tree::{NO_PARENT, Tree};

/// Modules read between two looks at the cancel flag.
const CHECK_EVERY: usize = 1 << 14;

/// Bytes of a node in all arrays of a tree.
const NODE_BYTES: u64 = 28;

/// Nodes that room is made for at least.
const LEAST_ROOM: usize = 64;

/// What the turtle takes where the string says nothing, and how far it may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurtleParams {
    /// Length of `F` and `f` without a parameter, metres.
    pub length: f64,
    /// Width (diameter) before the first `!`, metres.
    pub width: f64,
    /// What `!` without a parameter multiplies the width by.
    pub narrow: f64,
    /// Degrees of a turn without a parameter, where the grammar has no `angle`.
    pub angle: f64,
    /// Brackets within brackets.
    pub max_depth: usize,
    /// Nodes of the tree; at most 2^32 − 2, and no more than `limits.bytes` holds.
    pub max_nodes: u64,
    /// Limits of the string that the `interpret` block makes, and of the tree's bytes.
    pub limits: Limits,
}

impl Default for TurtleParams {
    /// A step of 1 m, a width of 0.1 m that `!` divides by √2 (two such branches have the parent's cross-section), turns
    /// of 60° as in L-Py, 4 million brackets within brackets, 512 million nodes.
    fn default() -> Self {
        Self {
            length: 1.0,
            width: 0.1,
            narrow: std::f64::consts::FRAC_1_SQRT_2,
            angle: 60.0,
            max_depth: 4_000_000,
            max_nodes: 1 << 29,
            limits: Limits::default(),
        }
    }
}

/// What a symbol makes the turtle do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Action {
    Nothing,
    Draw,
    Move,
    /// About the turtle's own axis, by the parameter times the sign.
    Turn(DVec3, f64),
    TurnAround,
    Level,
    Width,
    Push,
    Pop,
    BeginPolygon,
    EndPolygon,
    Tropism,
    /// Follow the shape of this index.
    Follow(u16),
}

fn action(grammar: &Grammar, symbol: Symbol) -> Action {
    if let Some(shape) = grammar.shape_of.get(usize::from(symbol)).copied().flatten() {
        return Action::Follow(shape);
    }
    // Right-handed turns: +X is −L, so a positive turn about L is a negative one about X.
    match grammar.name(symbol) {
        "F" | "G" => Action::Draw,
        "f" | "g" => Action::Move,
        "+" => Action::Turn(DVec3::Z, 1.0),
        "-" => Action::Turn(DVec3::Z, -1.0),
        "&" => Action::Turn(DVec3::X, -1.0),
        "^" => Action::Turn(DVec3::X, 1.0),
        "/" => Action::Turn(DVec3::Y, 1.0),
        "\\" => Action::Turn(DVec3::Y, -1.0),
        "|" => Action::TurnAround,
        "$" => Action::Level,
        "!" => Action::Width,
        "[" => Action::Push,
        "]" => Action::Pop,
        "{" => Action::BeginPolygon,
        "}" => Action::EndPolygon,
        "T" => Action::Tropism,
        _ => Action::Nothing,
    }
}

/// The turtle's state: what brackets save.
#[derive(Clone, Copy, Debug)]
struct State {
    position: DVec3,
    frame: DQuat,
    /// Metres, a diameter.
    width: f64,
    tropism: f64,
    /// The node at this position, or `NO_PARENT` after a move without drawing.
    node: u32,
    /// The dictionary letter drawn last, if nothing else was drawn since.
    shape: Option<u16>,
    /// Its parameter.
    shape_index: f64,
}

/// Draws a string: one segment for each drawing module, under a root node at the turtle's start. A move without drawing
/// begins a new root.
///
/// # Errors
/// The turtle's limits, positions beyond f32, or `cancel` being set.
pub fn interpret(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
) -> Result<Tree, DeriveError> {
    let shown = interpreted(grammar, string, &params.limits, cancel)?;
    // The string that is shown lies in the same memory as what is drawn.
    let mut params = *params;
    let shown_bytes = shown.as_ref().map_or(0, ModuleString::bytes);
    params.limits.bytes = params.limits.bytes.saturating_sub(shown_bytes);
    let mut turtle = Turtle::new(grammar, &params);
    turtle.run(shown.as_ref().unwrap_or(string), cancel)?;
    Ok(turtle.finish())
}

struct Turtle<'a> {
    grammar: &'a Grammar,
    params: &'a TurtleParams,
    /// By symbol.
    actions: Vec<Action>,
    /// By symbol: the tree's letter, once it has drawn.
    letters: Vec<Option<u16>>,
    angle: f64,
    state: State,
    stack: Vec<State>,
    polygons: usize,
    /// By node, for roots only: no segment has set the radius yet.
    bare_root: Option<u32>,
    tree: Tree,
}

/// One module while it is drawn.
#[derive(Clone, Copy)]
struct Here {
    symbol: Symbol,
    birth: u32,
    position: usize,
}

impl<'a> Turtle<'a> {
    fn new(grammar: &'a Grammar, params: &'a TurtleParams) -> Self {
        let symbols = 0..u16::try_from(grammar.names.symbols().len()).unwrap_or(u16::MAX);
        let state = State {
            position: DVec3::ZERO,
            frame: DQuat::IDENTITY,
            width: params.width,
            tropism: 0.0,
            node: 0,
            shape: None,
            shape_index: 0.0,
        };
        let mut turtle = Self {
            grammar,
            params,
            actions: symbols.clone().map(|s| action(grammar, s)).collect(),
            letters: symbols.map(|_| None).collect(),
            angle: grammar.angle.unwrap_or(params.angle),
            state,
            stack: Vec::new(),
            polygons: 0,
            bare_root: None,
            tree: Tree::default(),
        };
        turtle.add(NO_PARENT, Vec3::ZERO, 0.0, 0, 0);
        turtle.bare_root = Some(0);
        turtle
    }

    fn run(&mut self, string: &ModuleString, cancel: &AtomicBool) -> Result<(), DeriveError> {
        for (position, module) in string.iter().enumerate() {
            if position % CHECK_EVERY == 0 && cancel.load(Ordering::Relaxed) {
                let step = string.births().max().unwrap_or(0);
                return Err(DeriveProblem::Cancelled { step }.into());
            }
            let here = Here {
                symbol: module.symbol,
                birth: module.birth,
                position,
            };
            let first = module.parameters.first().copied();
            match self
                .actions
                .get(usize::from(module.symbol))
                .copied()
                .unwrap_or(Action::Nothing)
            {
                Action::Nothing => {}
                Action::Draw => {
                    let length = first.unwrap_or(self.params.length);
                    self.state.shape = None;
                    if self.polygons > 0 {
                        self.move_by(length);
                    } else {
                        self.draw(here, length, None)?;
                    }
                    self.bend();
                }
                Action::Move => {
                    self.state.shape = None;
                    self.move_by(first.unwrap_or(self.params.length));
                }
                Action::Turn(axis, sign) => self.turn(DQuat::from_axis_angle(
                    axis,
                    (sign * first.unwrap_or(self.angle)).to_radians(),
                )),
                Action::TurnAround => self.turn(DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0)),
                Action::Level => self.level(),
                Action::Width => {
                    self.state.width = first.unwrap_or(self.state.width * self.params.narrow)
                }
                Action::Push => {
                    if self.stack.len() >= self.params.max_depth {
                        let problem = DeriveProblem::TooDeep {
                            position: position as u64,
                            depth: self.params.max_depth,
                        };
                        return Err(problem.into());
                    }
                    self.stack.push(self.state);
                }
                Action::Pop => {
                    if let Some(state) = self.stack.pop() {
                        self.state = state;
                    }
                }
                Action::BeginPolygon => self.polygons += 1,
                Action::EndPolygon => self.polygons = self.polygons.saturating_sub(1),
                Action::Tropism => self.state.tropism = first.unwrap_or(0.0),
                Action::Follow(shape) => self.follow(here, shape, first)?,
            }
        }
        Ok(())
    }

    fn turn(&mut self, by: DQuat) {
        self.state.frame = (self.state.frame * by).normalize();
    }

    /// Rolls so that L is horizontal and U is not below it; a vertical heading stays as it is.
    fn level(&mut self) {
        let heading = self.state.frame * DVec3::Y;
        let left = DVec3::Y.cross(heading);
        if left.length_squared() < 1e-24 {
            return;
        }
        let left = left.normalize();
        let up = heading.cross(left);
        self.state.frame =
            DQuat::from_mat3(&glam::DMat3::from_cols(-left, heading, up)).normalize();
    }

    /// Turns the heading toward the tropism vector by e·|H × T| radians (ABOP, section 2.1).
    fn bend(&mut self) {
        let Some(vector) = self.grammar.tropism else {
            return;
        };
        if self.state.tropism == 0.0 {
            return;
        }
        let torque = (self.state.frame * DVec3::Y).cross(vector);
        let strength = torque.length();
        if strength > 1e-12 {
            let bend = DQuat::from_axis_angle(torque / strength, self.state.tropism * strength);
            self.state.frame = (bend * self.state.frame).normalize();
        }
    }

    fn move_by(&mut self, length: f64) {
        self.state.position += self.state.frame * DVec3::Y * length;
        self.state.node = NO_PARENT;
    }

    /// Draws the dictionary's segment that the module's parameter names, or the whole shape where it has none.
    fn follow(&mut self, here: Here, letter: u16, index: Option<f64>) -> Result<(), DeriveError> {
        let grammar = self.grammar;
        let Some(shape) = grammar.shapes.get(usize::from(letter)) else {
            return Ok(());
        };
        if let Some(index) = index {
            return self.follow_segment(here, letter, shape, index.floor());
        }
        self.state.shape = None;
        let mut index = 0.0;
        for _ in &shape.segments {
            self.follow_segment(here, letter, shape, index)?;
            index += 1.0;
        }
        Ok(())
    }

    #[expect(clippy::float_cmp, reason = "both are whole numbers")]
    fn follow_segment(
        &mut self,
        here: Here,
        letter: u16,
        shape: &Shape,
        index: f64,
    ) -> Result<(), DeriveError> {
        let length = f64::from(u32::try_from(shape.segments.len()).unwrap_or(u32::MAX));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 ≤ remainder < length"
        )]
        let Some(segment) = shape.segments.get(index.rem_euclid(length) as usize) else {
            return Ok(());
        };
        let goes_on = self.state.shape == Some(letter) && index == self.state.shape_index + 1.0;
        self.turn(if goes_on { segment.turn } else { segment.frame });
        self.draw(here, segment.length, segment.radius)?;
        self.state.shape = Some(letter);
        self.state.shape_index = index;
        self.bend();
        Ok(())
    }

    /// Adds the segment from here to `length` ahead.
    fn draw(&mut self, here: Here, length: f64, radius: Option<f64>) -> Result<(), DeriveError> {
        let order = u16::try_from(self.stack.len()).unwrap_or(u16::MAX);
        let width = radius.map_or(self.state.width.abs(), |radius| radius * 2.0);
        let radius = narrow(width / 2.0);
        if self.state.node == NO_PARENT {
            let at = narrowed(self.state.position);
            self.room(2)?;
            let node = self.add(NO_PARENT, at, radius, order, here.birth);
            self.state.node = node;
            self.bare_root = Some(node);
        }
        self.room(1)?;
        let end = self.state.position + self.state.frame * DVec3::Y * length;
        let at = narrowed(end);
        if !at.is_finite() || !radius.is_finite() {
            let module = self.grammar.name(here.symbol).to_owned();
            let position = here.position as u64;
            let problem = if at.is_finite() {
                DeriveProblem::TooWide {
                    position,
                    module,
                    width,
                }
            } else {
                DeriveProblem::TooFar { position, module }
            };
            return Err(problem.into());
        }
        let letter = self.letter(here.symbol);
        let parent = self.state.node;
        if self.bare_root == Some(parent) {
            // A root is as thick as the first segment that leaves it.
            if let (Some(r), Some(l)) = (
                self.tree.radius.get_mut(parent as usize),
                self.tree.letter.get_mut(parent as usize),
            ) {
                (*r, *l) = (radius, letter);
            }
            self.bare_root = None;
        }
        self.state.node = self.add(parent, at, radius, order, here.birth);
        if let Some(last) = self.tree.letter.last_mut() {
            *last = letter;
        }
        self.state.position = end;
        Ok(())
    }

    /// Makes room for so many more nodes: by half of what is there, so that little of the memory stays unused.
    fn room(&mut self, nodes: u64) -> Result<(), DeriveError> {
        let limit = self
            .params
            .max_nodes
            .min(self.params.limits.bytes / NODE_BYTES)
            .min(u64::from(NO_PARENT) - 1);
        if self.tree.parent.len() as u64 + nodes > limit {
            return Err(DeriveProblem::TooManyNodes { limit }.into());
        }
        let have = self.tree.parent.len();
        if self.tree.parent.capacity() - have < nodes.try_into().unwrap_or(usize::MAX) {
            let left = usize::try_from(limit).unwrap_or(usize::MAX) - have;
            let more = (have / 2).max(LEAST_ROOM).min(left);
            if self.tree.try_reserve(more).is_err() {
                let nodes = have as u64;
                return Err(DeriveProblem::DrawingMemory { nodes }.into());
            }
        }
        Ok(())
    }

    fn add(&mut self, parent: u32, position: Vec3, radius: f32, order: u16, birth: u32) -> u32 {
        let node = u32::try_from(self.tree.parent.len()).unwrap_or(NO_PARENT);
        self.tree.parent.push(parent);
        self.tree.position.push(position);
        self.tree.radius.push(radius);
        self.tree.letter.push(0);
        self.tree.order.push(order);
        self.tree.birth.push(birth);
        node
    }

    /// The tree's number for a symbol's name; symbols of one name share it.
    fn letter(&mut self, symbol: Symbol) -> u16 {
        if let Some(known) = self.letters.get(usize::from(symbol)).copied().flatten() {
            return known;
        }
        let name = self.grammar.name(symbol);
        let index = self
            .tree
            .letters
            .iter()
            .position(|l| l == name)
            .unwrap_or_else(|| {
                self.tree.letters.push(name.to_owned());
                self.tree.letters.len() - 1
            });
        let index = u16::try_from(index).unwrap_or(0);
        if let Some(slot) = self.letters.get_mut(usize::from(symbol)) {
            *slot = Some(index);
        }
        index
    }

    fn finish(mut self) -> Tree {
        let radius = narrow(self.params.width.abs() / 2.0);
        if self.tree.parent.len() == 1
            && let Some(root) = self.tree.radius.first_mut()
        {
            *root = radius;
        }
        if self.tree.letters.is_empty() {
            self.tree.letters.push(String::new());
        }
        self.tree
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a tree holds f32; what is beyond becomes infinite and is refused"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}

fn narrowed(position: DVec3) -> Vec3 {
    Vec3::new(narrow(position.x), narrow(position.y), narrow(position.z))
}
