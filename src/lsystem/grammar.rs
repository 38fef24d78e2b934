//! A checked grammar: everything that derivation and the turtle need, with no text left to look at.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::chances::{Bound, Chances, bounds};
use super::code::Expression;
use super::column::{Cell, Column, for_width};
use super::derive::{self, Limits};
use super::dialect::Remark;
use super::error::{DeriveError, GrammarErrors};
use super::growth::Curves;
use super::lanes::{self, Values};
use super::look::{NamedSurface, Widths};
use super::names::{Names, Symbol};
use super::output::Spare;
use super::parse;
use super::record::{self, Recorded};
use super::rests::Rests;
use super::shape::{Shape, Wrap};
use super::string::ModuleString;
use super::unwritten::Unwritten;
use crate::tree::foliage::{Dress, Season};
use crate::tree::organs::Palette;
use crate::tree::radii::{self, FitParams};
use crate::tree::{Drawing, Organs, Tree};

/// A grammar that has been read and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Grammar {
    pub(crate) names: Names,
    pub(crate) arity: Arc<[u8]>,
    pub(crate) roles: Vec<Role>,
    pub(crate) axiom: ModuleString,
    pub(crate) rules: RuleSet,
    /// Applied after each step until nothing changes.
    pub(crate) decompose: Option<RuleSet>,
    pub(crate) decompose_depth: u32,
    /// By symbol: whether its decomposition never ends, whatever the parameters. Empty where all may end.
    pub(crate) endless: Vec<bool>,
    /// Applied to what the turtle draws, never to the string.
    pub(crate) interpret: Option<RuleSet>,
    pub(crate) interpret_depth: u32,
    /// Contexts are plain neighbours.
    pub(crate) literal: bool,
    pub(crate) steps: Option<u32>,
    pub(crate) seed: u64,
    pub(crate) angle: Option<f64>,
    pub(crate) tropism: Option<DVec3>,
    /// Metres below which no segment goes down.
    pub(crate) ground: Option<f64>,
    /// How modules grow between two steps.
    pub(crate) curves: Curves,
    pub(crate) shapes: Vec<Shape>,
    /// How they go on when they are used up.
    pub(crate) wrap: Wrap,
    /// For each symbol its dictionary entry.
    pub(crate) shape_of: Vec<Option<u16>>,
    /// What the indices of colours and materials mean.
    pub(crate) palette: Palette,
    /// What `~` places.
    pub(crate) surfaces: Vec<NamedSurface>,
    /// Bark, leaves and season.
    pub(crate) dress: Dress,
    /// What the turtle's widths are.
    pub(crate) widths: Widths,
    /// For each symbol that begins with `~` and names no shape its surface.
    pub(crate) surface_of: Vec<Option<u16>>,
    /// The turtle answers queries after each step.
    pub(crate) has_queries: bool,
    pub(crate) remarks: Vec<Remark>,
}

/// What a symbol is to the rewriting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Role {
    /// Seen by contexts.
    #[default]
    Module,
    /// `[`
    Open,
    /// `]`
    Close,
    /// `%`
    Cut,
    /// Skipped by contexts.
    Ignored,
}

/// Which of several matching productions applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Order {
    /// The first in the file.
    #[default]
    First,
    /// Longer contexts first, then those with a condition, then the first in the file.
    Specific,
}

/// One module of a context pattern.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Pattern {
    /// A module whose parameters go into the slots from `slot` on.
    Module {
        /// Name and number of parameters in one.
        symbol: Symbol,
        /// First slot.
        slot: u16,
    },
    /// A branch: so many items of the pattern stand in it, then its `Close`.
    Open {
        /// Items between this and its `Close`.
        inside: usize,
    },
    /// End of a branch.
    Close,
}

impl Pattern {
    /// The symbol that it wants, if it wants one.
    #[inline]
    pub(crate) fn symbol(&self) -> Option<Symbol> {
        match self {
            Self::Module { symbol, .. } => Some(*symbol),
            Self::Open { .. } | Self::Close => None,
        }
    }
}

/// Where a production looks for its contexts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Looks {
    pub(crate) left: bool,
    /// To the right, past branches.
    pub(crate) right: bool,
    /// To the right, into branches.
    pub(crate) into_branches: bool,
    /// For parameters, too.
    pub(crate) binds: bool,
}

/// One production.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rule {
    /// Its text, for messages.
    pub(crate) text: String,
    /// File and line.
    pub(crate) location: String,
    pub(crate) predecessor: Symbol,
    /// Nearest module first; no brackets.
    pub(crate) left: Vec<Pattern>,
    pub(crate) right: Vec<Pattern>,
    pub(crate) looks: Looks,
    /// Modules of both contexts.
    pub(crate) context_length: usize,
    /// Parameters bound by the predecessor and by both contexts.
    pub(crate) slots: usize,
    pub(crate) condition: Option<Expression>,
    pub(crate) weight: Option<Expression>,
    pub(crate) successor: Vec<Symbol>,
    /// Parameters of all successor modules, one after the other.
    pub(crate) arguments: Vec<Expression>,
    /// Successor modules of the predecessor's own symbol, with their first argument: one of them may be the same module.
    pub(crate) heirs: Vec<(usize, usize)>,
}

impl Rule {
    /// Whether it applies to every module of its predecessor's symbol.
    pub(crate) fn unconditional(&self) -> bool {
        self.left.is_empty()
            && self.right.is_empty()
            && self.condition.is_none()
            && self.weight.is_none()
    }

    /// Its weight, where that alone decides and is a number above 0.
    fn constant_weight(&self) -> Option<f64> {
        match self.weight {
            Some(Expression::Constant(weight))
                if weight > 0.0 && self.condition.is_none() && !self.has_context() =>
            {
                Some(weight)
            }
            _ => None,
        }
    }

    pub(crate) fn has_context(&self) -> bool {
        !(self.left.is_empty() && self.right.is_empty())
    }

    /// Rank under [`Order::Specific`]: larger goes first.
    pub(crate) fn rank(&self) -> (usize, bool) {
        (self.context_length, self.condition.is_some())
    }
}

/// What a round does with a symbol's modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// There is no production.
    Stay,
    /// This production applies to every one.
    Always(u16),
    /// The symbols of its two neighbours decide.
    Near,
    /// Chance decides, by weights that never change.
    Draw,
    /// It depends; the first of the candidates is given.
    Choose(u16),
}

/// A production that depends on no more than the symbols of two neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Near {
    /// The neighbour that it needs; none: any.
    pub(crate) left: Option<Symbol>,
    pub(crate) right: Option<Symbol>,
    pub(crate) number: u16,
}

impl Near {
    fn of(rule: &Rule, number: u16) -> Option<Self> {
        let one = |pattern: &[Pattern]| match pattern {
            [] => Some(None),
            [Pattern::Module { symbol, .. }] => Some(Some(*symbol)),
            _ => None,
        };
        let plain = rule.condition.is_none() && rule.weight.is_none();
        let (left, right) = (one(&rule.left)?, one(&rule.right)?);
        plain.then_some(Self {
            left,
            right,
            number,
        })
    }
}

/// Productions, found by symbol.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RuleSet {
    pub(crate) rules: Vec<Rule>,
    /// For each symbol its productions, best first.
    pub(crate) by_symbol: Vec<Vec<u16>>,
    plans: Vec<Plan>,
    /// Where no more than a draw is needed to choose any module's production: the table that says which.
    pub(crate) chances: Option<Chances>,
    /// For each symbol whose plan is [`Plan::Near`] its productions, best first.
    near: Vec<Vec<Near>>,
    /// For each symbol whose plan is [`Plan::Draw`] its choices, each with the draw up to which it is meant.
    weighted: Vec<Vec<Bound>>,
    pub(crate) order: Order,
    pub(crate) has_context: bool,
    /// What any of them looks for.
    pub(crate) looks: Looks,
    /// What the symbols of two neighbours decide, where nothing else does.
    pub(crate) table: Option<NearTable>,
    /// For each choice how many modules and parameters it makes; what stays makes itself, its parameters not counted.
    made: Vec<(u32, u32)>,
    /// Slots and depth that its expressions need in columns; none where they are not worth it.
    pub(crate) columns: Option<(usize, usize)>,
    /// Which modules may be rewritten, by what stands next to them.
    pub(crate) rests: Rests,
}

fn table(plans: &[Plan], near: &[Vec<Near>]) -> Option<NearTable> {
    let simple = |plan: &Plan| matches!(plan, Plan::Stay | Plan::Always(_) | Plan::Near);
    let side = plans.len() + 1;
    if side > MOST_IN_TABLE || !plans.contains(&Plan::Near) || !plans.iter().all(simple) {
        return None;
    }
    let mut table = NearTable {
        side,
        choices: vec![0; side * side * side],
    };
    let places = (0..side).flat_map(|left| (0..side).map(move |symbol| (left, symbol)));
    for ((left, symbol), row) in places.zip(table.choices.chunks_mut(side)) {
        let is = |wanted: Option<Symbol>, found| wanted.is_none_or(|w| usize::from(w) == found);
        for (right, choice) in row.iter_mut().enumerate() {
            *choice = match plans.get(symbol) {
                Some(Plan::Always(number)) => number + 1,
                Some(Plan::Near) => near
                    .get(symbol)
                    .and_then(|all| all.iter().find(|n| is(n.left, left) && is(n.right, right)))
                    .map_or(0, |near| near.number + 1),
                _ => 0,
            };
        }
    }
    Some(table)
}

/// The table of what chance alone decides, or nothing at all; none where anything else decides a module's production.
fn chances(plans: &[Plan], weighted: &[Vec<Bound>]) -> Option<Chances> {
    let drawn = |plan: &Plan| matches!(plan, Plan::Stay | Plan::Always(_) | Plan::Draw);
    if !plans.iter().all(drawn) {
        return None;
    }
    let always = |plan: &Plan| match plan {
        Plan::Always(number) => [(number + 1, 0)],
        _ => [(0, 0)],
    };
    let always: Vec<[Bound; 1]> = plans.iter().map(always).collect();
    let rows = plans.iter().zip(&always).zip(weighted);
    Chances::new(rows.map(|((plan, always), weighted)| match plan {
        Plan::Draw => weighted.as_slice(),
        _ => always,
    }))
}

/// Sets of more productions are not worked on in columns.
const MOST_IN_COLUMNS: usize = 256;

/// Neighbours have at most so many symbols where a table says what becomes of each module.
const MOST_IN_TABLE: usize = 32;

/// What becomes of a module, by its symbol and those of its neighbours alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct NearTable {
    /// Symbols, and one more where there is no neighbour.
    side: usize,
    /// Choices, by left neighbour, symbol, right neighbour.
    choices: Vec<u16>,
}

impl NearTable {
    /// The place of a neighbour in the table.
    #[inline]
    pub(crate) fn neighbour(&self, symbol: Option<Symbol>) -> usize {
        symbol.map_or(self.side - 1, usize::from)
    }

    /// The choice for a module between two neighbours.
    #[inline]
    pub(crate) fn choice(&self, left: usize, symbol: usize, right: usize) -> u16 {
        let place = (left * self.side + symbol) * self.side + right;
        self.choices.get(place).copied().unwrap_or(0)
    }
}

/// What expressions need in columns.
fn columns(rules: &[Rule]) -> Option<(usize, usize)> {
    fn asked(rule: &Rule) -> impl Iterator<Item = &Expression> {
        rule.condition.iter().chain(&rule.weight)
    }
    let all = || {
        rules
            .iter()
            .flat_map(move |rule| asked(rule).chain(&rule.arguments))
    };
    if rules.len() > MOST_IN_COLUMNS || all().any(Expression::may_draw) {
        return None;
    }
    let slots = rules.iter().map(|rule| rule.slots).max()?;
    let depth = all().map(lanes::depth).max().unwrap_or(0);
    Values::fits(slots, depth).then_some((slots, depth))
}

/// Whether there is one of these symbols among others. They are looked at a few at a time, without an end in between.
fn has<S: Cell>(symbols: &[S], these: &[bool]) -> bool {
    let is = |symbol: &S| these.get(symbol.index()) == Some(&true);
    let mut groups = symbols.chunks(64);
    groups.any(|group| group.iter().fold(false, |any, symbol| any | is(symbol)))
}

impl RuleSet {
    pub(crate) fn new(rules: Vec<Rule>, symbols: usize, order: Order) -> Self {
        let mut by_symbol: Vec<Vec<u16>> = vec![Vec::new(); symbols];
        for (index, rule) in rules.iter().enumerate() {
            if let (Some(list), Ok(index)) = (
                by_symbol.get_mut(usize::from(rule.predecessor)),
                u16::try_from(index),
            ) {
                list.push(index);
            }
        }
        if order == Order::Specific {
            let rank = |index: &u16| {
                rules
                    .get(usize::from(*index))
                    .map(|r| std::cmp::Reverse(r.rank()))
            };
            for list in &mut by_symbol {
                list.sort_by_key(rank); // stable: file order among equals
            }
        }
        let has_context = rules.iter().any(Rule::has_context);
        let any = |look: fn(&Looks) -> bool| rules.iter().any(|rule| look(&rule.looks));
        let looks = Looks {
            left: any(|l| l.left),
            right: any(|l| l.right),
            into_branches: any(|l| l.into_branches),
            binds: any(|l| l.binds),
        };
        let rule = |number: &u16| rules.get(usize::from(*number));
        let near: Vec<Vec<Near>> = by_symbol
            .iter()
            .map(|list| {
                let near = |number: &u16| Near::of(rule(number)?, *number);
                let all: Option<Vec<Near>> = list.iter().map(near).collect();
                all.unwrap_or_default()
            })
            .collect();
        let weighted: Vec<Vec<Bound>> = by_symbol
            .iter()
            .map(|list| {
                let weighted = |number: &u16| Some((number + 1, rule(number)?.constant_weight()?));
                let all: Option<Vec<(u16, f64)>> = list.iter().map(weighted).collect();
                bounds(&all.unwrap_or_default())
            })
            .collect();
        let plan = |(index, list): (usize, &Vec<u16>)| match list.first() {
            None => Plan::Stay,
            Some(first) if rule(first).is_some_and(Rule::unconditional) => Plan::Always(*first),
            Some(_) if near.get(index).is_some_and(|n| !n.is_empty()) => Plan::Near,
            Some(_) if weighted.get(index).is_some_and(|all| !all.is_empty()) => Plan::Draw,
            Some(first) => Plan::Choose(*first),
        };
        let plans: Vec<Plan> = by_symbol.iter().enumerate().map(plan).collect();
        let table = table(&plans, &near);
        let chances = chances(&plans, &weighted);
        let columns = columns(&rules);
        let rests = Rests::new(&plans, &by_symbol, &rules);
        let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let size = |rule: &Rule| (number(rule.successor.len()), number(rule.arguments.len()));
        let made = std::iter::once((1, 0)).chain(rules.iter().map(size));
        Self {
            table,
            made: made.collect(),
            columns,
            rests,
            rules,
            by_symbol,
            plans,
            chances,
            near,
            weighted,
            order,
            has_context,
            looks,
        }
    }

    #[inline]
    pub(crate) fn plan(&self, symbol: Symbol) -> Plan {
        let plan = self.plans.get(usize::from(symbol));
        plan.copied().unwrap_or(Plan::Stay)
    }

    /// Whether there is a production for any of the symbols.
    pub(crate) fn may_rewrite(&self, symbols: &Column) -> bool {
        let is: Vec<bool> = self.plans.iter().map(|plan| *plan != Plan::Stay).collect();
        for_width!(symbols, symbols => has(symbols, &is))
    }

    /// How many modules and parameters a choice makes.
    #[inline]
    pub(crate) fn made(&self, choice: u16) -> (u32, u32) {
        let made = self.made.get(usize::from(choice));
        made.copied().unwrap_or_default()
    }

    /// The choices of a symbol whose plan is [`Plan::Draw`].
    #[inline]
    pub(crate) fn weighted(&self, symbol: Symbol) -> &[Bound] {
        self.weighted
            .get(usize::from(symbol))
            .map_or(&[], Vec::as_slice)
    }

    /// The productions of a symbol whose plan is [`Plan::Near`].
    #[inline]
    pub(crate) fn near(&self, symbol: Symbol) -> &[Near] {
        self.near
            .get(usize::from(symbol))
            .map_or(&[], Vec::as_slice)
    }

    /// Whether anything is left to chance: which production applies, or a parameter.
    pub(crate) fn draws(&self) -> bool {
        let drawn = |rule: &Rule| {
            let mut computed = rule.condition.iter().chain(&rule.arguments);
            rule.weight.is_some() || computed.any(Expression::draws)
        };
        self.rules.iter().any(drawn)
    }
}

impl Grammar {
    /// Reads a grammar. `file` names the text in messages; where it is a file that exists, `include` reads from its folder.
    ///
    /// # Errors
    /// All faults found, each with its line and column.
    pub fn parse(source: &str, file: &str) -> Result<Self, GrammarErrors> {
        parse::grammar(source, file)
    }

    /// Gives a shape other displacements, without radii; a name that no shape has is left alone.
    pub fn set_shape(&mut self, name: &str, displacements: &[DVec3]) {
        if let Some(shape) = self.shapes.iter_mut().find(|shape| shape.name == name) {
            *shape = Shape::plain(name, displacements);
            shape.set_wrap(self.wrap);
        }
    }

    /// What the text says in another program's notation and could not be carried over.
    #[must_use]
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    /// The string after `steps` steps.
    ///
    /// # Errors
    /// A limit, a value that cannot be computed, or `cancel` being set (seen within a few milliseconds); the last whole
    /// step is in the error.
    pub fn derive(
        &self,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<ModuleString, DeriveError> {
        self.derive_watched(steps, limits, cancel, &mut |_| {})
    }

    /// [`Grammar::derive`], which calls `progress` with the number of steps made, before each further one where the
    /// steps are made one after the other.
    ///
    /// # Errors
    /// As [`Grammar::derive`].
    pub fn derive_watched(
        &self,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(u32),
    ) -> Result<ModuleString, DeriveError> {
        derive::derive(self, steps, limits, cancel, progress)
    }

    /// The string after `steps` steps, not written down: to be counted, walked through and printed whatever its length. `None`
    /// where modules do not each develop alone and without chance (a context, a random draw, a `decompose` block, `%` or a
    /// query), where too many of them differ, or a value cannot be computed: [`Grammar::derive`] does it or says why.
    ///
    /// # Errors
    /// More modules than u128 counts, or `cancel` being set.
    pub fn unwritten(
        &self,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Option<Unwritten>, DeriveError> {
        Unwritten::new(self, steps, limits, cancel)
    }

    /// One step on: the string of step `step` from that of step `step − 1`.
    ///
    /// # Errors
    /// As [`Grammar::derive`]; the error carries no string, since the caller has it.
    pub fn derive_next(
        &self,
        string: &ModuleString,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<ModuleString, DeriveError> {
        derive::next(self, string, step, &mut Spare::default(), limits, cancel)
    }

    /// [`Grammar::derive_next`] with a record of which production rewrote each module, and into what.
    ///
    /// # Errors
    /// As [`Grammar::derive_next`].
    pub fn derive_recorded(
        &self,
        string: &ModuleString,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Recorded, DeriveError> {
        record::recorded(self, string, step, limits, cancel)
    }

    /// The productions of the grammar's main part in the order of the file: the text of each (cut where it is long), and
    /// its file and line as `file:line`.
    pub fn productions(&self) -> impl ExactSizeIterator<Item = (&str, &str)> {
        let rules = self.rules.rules.iter();
        rules.map(|rule| (rule.text.as_str(), rule.location.as_str()))
    }

    /// The number of steps that the file states.
    #[must_use]
    pub fn steps(&self) -> Option<u32> {
        self.steps
    }

    /// The seed of the random draws.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What its trees wear.
    #[must_use]
    pub fn dress(&self) -> &Dress {
        &self.dress
    }

    /// The same grammar at another time of the year.
    #[must_use]
    pub fn with_season(mut self, season: Season) -> Self {
        self.dress.season = season;
        self
    }

    /// Makes what the turtle drew what it looks like: radii by the grammar's `widths`, or fitted where they are far too large for metres, whose factor is
    /// returned; then bark and leaves.
    pub fn finish(&self, drawing: &mut Drawing) -> Option<f32> {
        let factor = match &self.widths {
            Widths::DaVinci(params) => {
                radii::da_vinci(&mut drawing.tree, params, u32::MAX);
                None
            }
            Widths::Metres => None,
            Widths::Auto => radii::fit(&mut drawing.tree, &FitParams::default()),
        };
        self.dress_up(&drawing.tree, &mut drawing.organs);
        factor
    }

    /// Adds bark and leaves to what the turtle drew, whose radii are as they are to be drawn.
    pub fn dress_up(&self, tree: &Tree, organs: &mut Organs) {
        #[expect(clippy::cast_possible_truncation, reason = "metres of a stage")]
        let ground = self.ground.map(|ground| ground as f32);
        self.dress.put_on(tree, organs, self.seed, ground);
    }

    /// Whether its seed matters: something is drawn, or leaves are borne, whose sizes are.
    #[must_use]
    pub fn has_chance(&self) -> bool {
        let mut sets = [&self.decompose, &self.interpret].into_iter().flatten();
        self.rules.draws() || sets.any(RuleSet::draws) || !self.dress.bears.is_empty()
    }

    /// The same grammar with another seed: another individual of the same kind.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Gives it another seed.
    pub fn set_seed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// The turn in degrees of `+ - & ^ \ /` without a parameter, where the file states it.
    #[must_use]
    pub fn angle(&self) -> Option<f64> {
        self.angle
    }

    /// The name of a symbol of a string of this grammar.
    #[must_use]
    pub fn name(&self, symbol: Symbol) -> &str {
        self.names.name(symbol)
    }

    /// The same without where in the text its productions stand and how they are spelled: what two texts that mean the
    /// same have in common.
    pub(super) fn meaning(mut self) -> Self {
        let sets = [
            Some(&mut self.rules),
            self.decompose.as_mut(),
            self.interpret.as_mut(),
        ];
        for rule in sets.into_iter().flatten().flat_map(|set| &mut set.rules) {
            rule.text.clear();
            rule.location.clear();
        }
        self
    }

    pub(crate) fn role(&self, symbol: Symbol) -> Role {
        self.roles
            .get(usize::from(symbol))
            .copied()
            .unwrap_or_default()
    }
}
