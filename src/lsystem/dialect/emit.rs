//! A foreign grammar written in our notation.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::Dialect;
use super::expression::{Binary, Expr, Kind, Node};
use super::functions::PYTHON_CONSTANTS;
use super::meaning::{self, Argument, Drawn, Meaning};
use super::model::{Block, Model, Module, Rule, Valued};
use super::text::{Fault, Writer};

/// Letters that our turtle follows.
const TURTLE_LETTERS: [&str; 5] = ["F", "G", "f", "g", "T"];

/// Writes all of it; faults go into the model.
pub(super) fn written(model: &mut Model) -> Writer {
    let mut emitter = Emitter {
        plain: interpreted_once(model),
        names: HashMap::new(),
        taken: HashSet::new(),
        declarations: Vec::new(),
        drawn: BTreeMap::new(),
        remarks: Vec::new(),
        faults: Vec::new(),
        dialect: model.dialect,
    };
    emitter.declare(model);
    let mut body = Writer::default();
    emitter.body(model, &mut body);
    let mut out = Writer::default();
    out.put(&format!("# Brought over from {}.\n", model.dialect), 0);
    emitter.statements(model, &mut out);
    for (at, line) in &emitter.declarations {
        out.put(line, *at);
    }
    out.append(body);
    for fault in emitter.faults {
        model.fault(fault);
    }
    for (at, message) in emitter.remarks {
        model.remark(at, message);
    }
    out
}

/// Whether a module that an interpretation draws may keep our symbol: a second round would draw it again.
fn interpreted_once(model: &Model) -> bool {
    let none = model.rules.iter().all(|r| r.block != Block::Interpret);
    let once = model
        .interpret_depth
        .as_ref()
        .is_none_or(|d| matches!(&d.value.kind, Kind::Number(n) if n.trim() == "1"));
    none || once
}

struct Emitter {
    dialect: Dialect,
    plain: bool,
    /// For a symbol and its number of parameters the name of the declared module.
    names: HashMap<(String, usize), String>,
    taken: HashSet<String>,
    declarations: Vec<(usize, String)>,
    /// Interpretations of symbols that our turtle draws otherwise, by name and number of parameters.
    drawn: BTreeMap<(String, usize), (usize, Drawn)>,
    remarks: Vec<(usize, String)>,
    faults: Vec<Fault>,
}

impl Emitter {
    /// Declared modules take their own names first.
    fn declare(&mut self, model: &Model) {
        for declared in &model.declared {
            let key = (declared.name.clone(), declared.formals.len());
            if declared.name.chars().count() > 1
                && meaning::of(self.dialect, &declared.name, declared.formals.len()) == Meaning::Own
                && !declared.formals.is_empty()
                && !self.names.contains_key(&key)
            {
                self.taken.insert(declared.name.clone());
                let line = format!(
                    "module {}({})\n",
                    declared.name,
                    declared.formals.join(", ")
                );
                self.declarations.push((0, line));
                self.names.insert(key, declared.name.clone());
            }
        }
    }

    /// The name of a declared module for a symbol.
    fn word(&mut self, module: &Module, word: &str) -> String {
        let arity = module.arguments.len();
        let key = (module.key.clone(), arity);
        if let Some(known) = self.names.get(&key) {
            return known.clone();
        }
        let mut name = word.to_owned();
        if self.taken.contains(&name) {
            name.push_str(&arity.to_string());
        }
        while self.taken.contains(&name) {
            name.push('_');
        }
        self.taken.insert(name.clone());
        let formals: Vec<String> = (1..=arity).map(|i| format!("p{i}")).collect();
        let list = match formals.is_empty() {
            true => String::new(),
            false => format!("({})", formals.join(", ")),
        };
        self.declarations
            .push((module.at, format!("module {name}{list}\n")));
        self.names.insert(key, name.clone());
        name
    }

    /// The name of a module in our string, and its parameters.
    fn named(&mut self, module: &Module) -> (String, Vec<Expr>) {
        let arity = module.arguments.len();
        let own = || module.arguments.clone();
        if module.key.len() > 1 && module.key.starts_with('~') {
            return (module.key.clone(), own());
        }
        match meaning::of(self.dialect, &module.key, arity) {
            Meaning::Same(name) => (name.to_owned(), own()),
            Meaning::Reordered(name, order) => {
                let list = order
                    .iter()
                    .filter_map(|i| module.arguments.get(*i).cloned());
                (name.to_owned(), list.collect())
            }
            Meaning::Drawn {
                symbol,
                word,
                drawn,
            } => {
                let name = match symbol {
                    Some(symbol) if self.plain => symbol.to_owned(),
                    _ => self.word(module, word),
                };
                self.drawn
                    .entry((name.clone(), arity))
                    .or_insert((module.at, drawn));
                (name, own())
            }
            Meaning::Nothing { word, missing } => {
                if let Some(missing) = missing {
                    self.remarks.push((module.at, missing.to_owned()));
                }
                (self.word(module, word), own())
            }
            Meaning::Refused(why) => {
                self.faults.push(Fault::new(
                    module.at,
                    format!("found `{}`; {why}", module.key),
                ));
                (module.key.clone(), own())
            }
            Meaning::Own => (self.own_name(module), own()),
        }
    }

    fn own_name(&mut self, module: &Module) -> String {
        let key = &module.key;
        if TURTLE_LETTERS.contains(&key.as_str()) {
            return format!("{key}′");
        }
        let mut chars = key.chars();
        match (chars.next(), chars.next()) {
            (Some(c), None) if c.is_alphanumeric() => key.clone(),
            (Some(c), Some(_)) if c.is_alphabetic() => {
                let word = key.clone();
                self.word(module, &word)
            }
            _ => {
                let message = format!("`{key}` cannot be a module's name here");
                self.faults.push(Fault::new(module.at, message));
                key.clone()
            }
        }
    }

    fn keep(&mut self, result: Result<(), Fault>) {
        if let Err(fault) = result {
            self.faults.push(fault);
        }
    }

    /// A module with its parameters.
    fn module(&mut self, out: &mut Writer, name: &str, at: usize, list: &[Expr]) {
        out.put(name, at);
        for (i, argument) in list.iter().enumerate() {
            out.put(if i == 0 { "(" } else { ", " }, argument.at);
            let result = argument.write(out);
            self.keep(result);
        }
        if !list.is_empty() {
            out.put(")", at);
        }
    }

    /// Modules with blanks between them; `shown` where they are drawn and never rewritten.
    fn modules(&mut self, out: &mut Writer, modules: &[Module], shown: bool) {
        for module in modules {
            if out.is_full() {
                return;
            }
            let arity = module.arguments.len();
            let meaning = meaning::of(self.dialect, &module.key, arity);
            if let (true, Meaning::Drawn { drawn, .. }) = (shown, meaning) {
                match parts(drawn, module.at, &module.arguments) {
                    Ok(parts) => {
                        for (name, list) in parts {
                            out.put(" ", module.at);
                            self.module(out, name, module.at, &list);
                        }
                    }
                    Err(fault) => self.faults.push(fault),
                }
                continue;
            }
            let (name, list) = self.named(module);
            out.put(" ", module.at);
            self.module(out, &name, module.at, &list);
        }
    }

    fn valued(&mut self, out: &mut Writer, word: &str, valued: &Valued) {
        out.put(word, valued.at);
        out.put(" ", valued.at);
        let result = valued.value.write(out);
        self.keep(result);
        out.put("\n", valued.at);
    }

    /// Statements that stand before the modules' declarations.
    fn statements(&mut self, model: &Model, out: &mut Writer) {
        for (name, value) in python_constants(model) {
            out.put(&format!("const {name} = {value}\n"), 0);
        }
        for (name, valued) in &model.constants {
            self.valued(out, &format!("const {name} ="), valued);
        }
        for (word, valued) in [
            ("steps", &model.steps),
            ("seed", &model.seed),
            ("angle", &model.angle),
        ] {
            if let Some(valued) = valued {
                self.valued(out, word, valued);
            }
        }
    }

    fn body(&mut self, model: &Model, out: &mut Writer) {
        for (word, list) in [
            ("ignore", Some(&model.ignored)),
            ("consider", model.considered.as_ref()),
        ] {
            if let Some(list) = list.filter(|list| !list.is_empty()) {
                out.put(word, list.first().map_or(0, |m| m.at));
                self.modules(out, list, false);
                out.put("\n", 0);
            }
        }
        if let Some((at, axiom)) = &model.axiom {
            out.put("axiom", *at);
            self.modules(out, axiom, false);
            out.put(if axiom.is_empty() { " *\n" } else { "\n" }, *at);
        }
        self.rules(model, out, Block::Main);
        if model.rules.iter().any(|r| r.block == Block::Decompose) {
            self.open(out, "decompose", model.decompose_depth.as_ref());
            self.rules(model, out, Block::Decompose);
            out.put("}\n", 0);
        }
        let interprets = model.rules.iter().any(|r| r.block == Block::Interpret);
        // Their names are noted while the strings are written, so this block comes last.
        if interprets || !self.drawn.is_empty() {
            let depth = model.interpret_depth.as_ref().filter(|_| interprets);
            self.open(out, "interpret", depth);
            self.rules(model, out, Block::Interpret);
            for ((name, arity), (at, drawn)) in self.drawn.clone() {
                let result = self.interpretation(out, &name, arity, at, drawn);
                self.keep(result);
            }
            out.put("}\n", 0);
        }
    }

    fn open(&mut self, out: &mut Writer, word: &str, depth: Option<&Valued>) {
        out.put(word, depth.map_or(0, |d| d.at));
        if let Some(depth) = depth {
            out.put(" depth ", depth.at);
            let result = depth.value.write(out);
            self.keep(result);
        }
        out.put(" {\n", depth.map_or(0, |d| d.at));
    }

    /// How a symbol is drawn that our turtle draws otherwise or not at all.
    fn interpretation(
        &mut self,
        out: &mut Writer,
        name: &str,
        arity: usize,
        at: usize,
        drawn: Drawn,
    ) -> Result<(), Fault> {
        let formals: Result<Vec<Expr>, Fault> = (1..=arity)
            .map(|i| Node::make(at, Kind::Name(format!("p{i}"))))
            .collect();
        let formals = formals?;
        out.put("    ", at);
        self.module(out, name, at, &formals);
        out.put(" ->", at);
        for (name, list) in parts(drawn, at, &formals)? {
            out.put(" ", at);
            self.module(out, name, at, &list);
        }
        out.put("\n", at);
        Ok(())
    }

    fn rules(&mut self, model: &Model, out: &mut Writer, block: Block) {
        for rule in model.rules.iter().filter(|r| r.block == block) {
            if out.is_full() {
                self.faults
                    .push(Fault::new(rule.predecessor.at, "this grammar is too long"));
                return;
            }
            if let Some(at) = rule.repeated_draw() {
                self.faults.push(Fault::new(
                    at,
                    "this is drawn at random once and used twice, which cannot be carried over; hand it on as a module's parameter",
                ));
            }
            self.rule(out, rule);
        }
    }

    fn rule(&mut self, out: &mut Writer, rule: &Rule) {
        let at = rule.predecessor.at;
        if rule.block != Block::Main {
            out.put("   ", at);
        }
        let mut line = Writer::default();
        if !rule.left.is_empty() {
            self.modules(&mut line, &rule.left, false);
            line.put(" <", at);
        }
        self.modules(&mut line, std::slice::from_ref(&rule.predecessor), false);
        if !rule.right.is_empty() {
            line.put(" >", at);
            self.modules(&mut line, &rule.right, false);
        }
        // The blank before the first module is not wanted at the beginning of a line.
        if rule.block == Block::Main {
            line.trim_start();
        }
        out.append(line);
        if rule.condition.is_some() || rule.weight.is_some() {
            out.put(" : ", at);
        }
        if let Some(condition) = &rule.condition {
            let result = condition.write(out);
            self.keep(result);
        }
        if let Some(weight) = &rule.weight {
            let comma = if rule.condition.is_some() { ", " } else { "" };
            out.put(&format!("{comma}weight "), weight.at);
            let result = weight.write(out);
            self.keep(result);
        }
        out.put(" ->", at);
        self.modules(out, &rule.successor, rule.block == Block::Interpret);
        out.put(
            if rule.successor.is_empty() {
                " *\n"
            } else {
                "\n"
            },
            at,
        );
    }
}

/// The modules that a symbol is drawn as.
fn parts(drawn: Drawn, at: usize, own: &[Expr]) -> Result<Vec<(&'static str, Vec<Expr>)>, Fault> {
    let value = |argument: &Argument| -> Result<Expr, Fault> {
        let of = |i: usize| {
            own.get(i)
                .cloned()
                .ok_or_else(|| Fault::new(at, "this symbol has too few parameters"))
        };
        match *argument {
            Argument::Own(i, 1.0) => of(i),
            Argument::Own(i, factor) => {
                let factor = Node::number(at, &factor.to_string())?;
                Node::binary(at, Binary::Multiply, &factor, &of(i)?)
            }
            Argument::Inverse(i) => {
                Node::binary(at, Binary::Divide, &Node::number(at, "1")?, &of(i)?)
            }
            Argument::Around(i) => {
                let most = of(i)?;
                let least = Node::make(at, Kind::Negate(most.clone()))?;
                Node::call(at, "uniform", &[&least, &most])
            }
            Argument::Fixed(text) => Node::number(at, text),
        }
    };
    drawn
        .iter()
        .map(|(name, list)| Ok((*name, list.iter().map(value).collect::<Result<_, _>>()?)))
        .collect()
}

/// What `from math import *` gave, where it is used and the grammar gives it no other value.
fn python_constants(model: &Model) -> Vec<(&'static str, &'static str)> {
    if model.dialect != Dialect::Lpy {
        return Vec::new();
    }
    let mut used = HashSet::new();
    {
        let mut see = |e: &Expr| {
            Node::visit(e, &mut |node| {
                if let Kind::Name(name) = &node.kind {
                    used.insert(name.clone());
                }
            });
        };
        let settings = [&model.steps, &model.decompose_depth, &model.interpret_depth];
        for valued in settings.into_iter().flatten() {
            see(&valued.value);
        }
        for (_, valued) in &model.constants {
            see(&valued.value);
        }
        let rules = model.rules.iter();
        let modules = model
            .axiom
            .iter()
            .flat_map(|a| &a.1)
            .chain(rules.clone().flat_map(|r| &r.successor));
        for argument in modules.flat_map(|m| &m.arguments) {
            see(argument);
        }
        for rule in rules {
            for part in rule.condition.iter().chain(&rule.weight) {
                see(part);
            }
        }
    }
    PYTHON_CONSTANTS
        .into_iter()
        .filter(|(name, _)| used.contains(*name) && !model.is_constant(name))
        .collect()
}
