//! Rules and parameters of Houdini's L-System node, as text.
//!
//! Houdini keeps them in the node, so this is what a person copies from its tabs: a line `label: value` for each parameter that is used
//! (`generations: 7`, `premise: FFFA`, `angle: 28`) and a line `A(i):i>2=F[+A(i-1)]:0.5` for each rule, with or without `rule 1:` before it.

use super::Dialect;
use super::expression::{Kind, Node};
use super::model::{Block, Model, Module, Rule, Valued, formals};
use super::reader::Reader;
use super::text::Fault;

/// The node's own angle, where a file states none.
const ANGLE: &str = "28";

/// Labels of the node's parameters that mean something here, in small letters.
const LABELS: [&str; 17] = [
    "premise",
    "generations",
    "context ignore",
    "random seed",
    "step size scale",
    "step size",
    "angle scale",
    "angle",
    "thickness scale",
    "thickness",
    "gravity",
    "variable b",
    "variable c",
    "variable d",
    "b",
    "c",
    "d",
];

/// Parameters of the node that change nothing but looks.
const LOOKS: [&str; 14] = [
    "type",
    "start position",
    "random scale",
    "continuous angles",
    "continuous length",
    "continuous width",
    "apply color",
    "rows",
    "cols",
    "tension",
    "point attributes",
    "uv increment",
    "group prefix",
    "group",
];

pub(super) fn read(text: &str, model: &mut Model) {
    let mut houdini = Houdini {
        text,
        thickness: None,
    };
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let trimmed = line.trim();
        // `#` is a symbol too, but no line of rules begins with it.
        if trimmed.is_empty() || trimmed.starts_with('#') {
            continue;
        }
        let start = start + (line.len() - line.trim_start().len());
        let end = start + trimmed.len();
        let result = houdini.line(start, end, model);
        model.kept(result);
    }
    houdini.finish(model);
}

struct Houdini<'a> {
    text: &'a str,
    thickness: Option<Valued>,
}

/// The label at the beginning of a line, and its length with the colon.
fn label(line: &str) -> Option<(&'static str, usize)> {
    let (before, _) = line.split_once(':')?;
    let word: String = before
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .to_lowercase();
    let known = LABELS.into_iter().chain(LOOKS).find(|l| *l == word)?;
    Some((known, before.len() + 1))
}

/// Bytes of `rule 3:` at the beginning of a line.
fn rule_label(line: &str) -> usize {
    let lower = line.get(..4).unwrap_or("").to_lowercase();
    if lower != "rule" {
        return 0;
    }
    match line.split_once(':') {
        Some((before, _))
            if before
                .get(4..)
                .unwrap_or("")
                .trim()
                .bytes()
                .all(|b| b.is_ascii_digit()) =>
        {
            before.len() + 1
        }
        _ => 0,
    }
}

impl<'a> Houdini<'a> {
    fn line(&mut self, start: usize, end: usize, model: &mut Model) -> Result<(), Fault> {
        let line = self.text.get(start..end).unwrap_or("");
        let Some((label, length)) = label(line) else {
            let start = start + rule_label(line);
            let reader = Reader::new(self.text, Dialect::Houdini, start, end);
            return rule(reader, model);
        };
        let mut reader = Reader::new(self.text, Dialect::Houdini, start + length, end);
        if reader.at_end() || LOOKS.contains(&label) {
            if LOOKS.contains(&label) {
                model.remark(start, format!("`{label}`, a parameter of the drawing"));
            }
            return Ok(());
        }
        match label {
            "premise" => model.axiom = Some((start, string(&mut reader, ' ')?)),
            "generations" => model.steps = Some(valued(&mut reader)?),
            "random seed" => model.seed = Some(valued(&mut reader)?),
            "angle" => model.angle = Some(valued(&mut reader)?),
            "thickness" => self.thickness = Some(valued(&mut reader)?),
            "context ignore" => model.ignored = string(&mut reader, ' ')?,
            "gravity" => {
                model.remark(start, "`gravity`: state `tropism 0 -1 0` and use `T(e)`");
            }
            _ => {
                let name = label.strip_prefix("variable ").unwrap_or(label);
                let value = valued(&mut reader)?;
                if model.is_constant(&name.replace(' ', "_")) {
                    return Err(Fault::new(
                        start,
                        format!("`{name}` stands here a second time"),
                    ));
                }
                model.constant(name.replace(' ', "_"), value);
            }
        }
        Ok(())
    }

    fn finish(&mut self, model: &mut Model) {
        if model.angle.is_none()
            && let Ok(value) = Node::number(0, ANGLE)
        {
            model.angle = Some(Valued { at: 0, value });
        }
        self.check_scales(model);
        // Where the turtle starts: its step and width, before the premise.
        let mut start = Vec::new();
        if model.is_constant("step_size") {
            let name = Node::make(0, Kind::Name("step_size".to_owned()));
            start.extend(name.map(|name| ("step size", name)));
        }
        if let (Some((at, axiom)), false) = (&mut model.axiom, start.is_empty()) {
            let at = *at;
            let modules = start.into_iter().map(|(key, value)| Module {
                key: key.to_owned(),
                at,
                arguments: vec![value],
            });
            axiom.splice(0..0, modules);
        }
        if let Some(thickness) = self.thickness.take() {
            let value = thickness.value;
            if let Some((at, axiom)) = &mut model.axiom {
                let module = Module {
                    key: "thickness".to_owned(),
                    at: *at,
                    arguments: vec![value],
                };
                axiom.insert(0, module);
            }
        }
        let sums = chances(model);
        for (at, sum) in sums {
            if (sum - 1.0).abs() > 1e-9 {
                model.remark(
                    at,
                    "chances of one module's rules that do not add up to 1; they are weights here, one of which is always drawn",
                );
            }
        }
    }

    /// A scale that is used must be told, since it stands in the node.
    fn check_scales(&self, model: &mut Model) {
        let rules = model.rules.iter().flat_map(|r| &r.successor);
        let axiom = model.axiom.iter().flat_map(|a| &a.1);
        let mut missing = Vec::new();
        for module in axiom.chain(rules).filter(|m| m.arguments.is_empty()) {
            let name = match module.key.as_str() {
                "\"" | "_" => "step size scale",
                ";" | "@" => "angle scale",
                "!" | "?" => "thickness scale",
                _ => continue,
            };
            let told = missing.iter().any(|(_, _, known)| *known == name);
            if !told && !model.is_constant(&name.replace(' ', "_")) {
                missing.push((module.at, module.key.clone(), name));
            }
        }
        for (at, key, name) in missing {
            model.fault(Fault::new(
                at,
                format!("`{key}` without a parameter uses the node's {name}; expected a line `{name}: …` with what the node's Values say"),
            ));
        }
    }
}

/// For each module the place of its first rule with a chance, and the sum of the chances that are numbers.
fn chances(model: &Model) -> Vec<(usize, f64)> {
    let mut sums = std::collections::BTreeMap::new();
    for rule in &model.rules {
        let Some(weight) = &rule.weight else { continue };
        let value = match &weight.kind {
            Kind::Number(text) => text.parse().unwrap_or(f64::NAN),
            _ => f64::NAN,
        };
        let symbol = (&rule.predecessor.key, rule.predecessor.arguments.len());
        let entry = sums.entry(symbol).or_insert((weight.at, 0.0));
        entry.1 += value;
    }
    let known = sums
        .into_values()
        .filter(|(_, sum): &(usize, f64)| !sum.is_nan());
    known.collect()
}

fn valued(reader: &mut Reader<'_>) -> Result<Valued, Fault> {
    reader.skip_blank();
    let at = reader.pos();
    let value = reader.expression()?;
    match reader.at_end() {
        true => Ok(Valued { at, value }),
        false => Err(reader.expected("the end of the line")),
    }
}

/// A symbol with its parameters as `read` takes them.
fn module(
    reader: &mut Reader<'_>,
    read: fn(&mut Reader<'_>) -> Result<Vec<super::expression::Expr>, Fault>,
) -> Result<Module, Fault> {
    reader.skip_blank();
    let at = reader.pos();
    if reader.rest().starts_with(['(', ')']) {
        return Err(reader.expected("a symbol"));
    }
    let Some(first) = reader.bump() else {
        return Err(reader.expected("a symbol"));
    };
    if first == '`' {
        return Err(Fault::new(
            at,
            "Houdini's own expressions, in backquotes, cannot be carried over; expected their value",
        ));
    }
    let arguments = match reader.rest().starts_with('(') {
        true => {
            reader.take("(");
            read(reader)?
        }
        false => Vec::new(),
    };
    let key = first.to_string();
    Ok(Module { key, at, arguments })
}

/// Modules with values, up to `stop` or the end.
fn string(reader: &mut Reader<'_>, stop: char) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    while !reader.at_end() && reader.peek() != Some(stop) {
        list.push(module(reader, |r| r.arguments())?);
    }
    Ok(list)
}

/// Modules with names of parameters, up to `<`, `>`, `:` or `=`.
fn heads(reader: &mut Reader<'_>) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    while !reader.at_end() && !reader.rest().starts_with(['<', '>', ':', '=']) {
        list.push(module(reader, formals)?);
    }
    Ok(list)
}

fn rule(mut reader: Reader<'_>, model: &mut Model) -> Result<(), Fault> {
    let mut left = Vec::new();
    let mut found = heads(&mut reader)?;
    if reader.take("<") {
        left = found;
        found = heads(&mut reader)?;
    }
    let mut right = Vec::new();
    if reader.take(">") {
        right = heads(&mut reader)?;
    }
    let mut found = found.into_iter();
    let Some(predecessor) = found.next() else {
        return Err(reader.expected("a parameter of the node, such as `premise: …`, or a rule"));
    };
    if let Some(second) = found.next() {
        return Err(Fault::new(
            second.at,
            format!(
                "found `{}`; expected `=` or `:` after the one symbol that a rule replaces",
                second.key
            ),
        ));
    }
    let mut condition = None;
    if reader.take(":") {
        condition = Some(reader.expression()?);
    }
    if !reader.take("=") {
        return Err(reader.expected("`=`"));
    }
    let successor = string(&mut reader, ':')?;
    let mut weight = None;
    if reader.take(":") {
        weight = Some(reader.expression()?);
    }
    if !reader.at_end() {
        return Err(reader.expected("the end of the rule"));
    }
    model.add(Rule {
        block: Block::Main,
        left,
        predecessor,
        right,
        condition,
        weight,
        successor,
    });
    Ok(())
}
