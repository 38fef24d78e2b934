//! L-Py's files: Python with rules between.
//!
//! What begins in the first column begins a statement; lines that are indented belong to it. Constants (`r = 0.5`), rules with arrows and
//! rules whose Python (see `python`) decides what they `produce` are carried over; other Python is named.

use super::Dialect;
use super::expression::Node;
use super::model::{Block, Declared, Model, Module, Rule, Valued, formals};
use super::python;
use super::reader::Reader;
use super::text::Fault;
use super::words::Words;

/// Where L-Py's editor keeps its settings.
const SETTINGS: &str = "###### INITIALISATION ######";

pub(super) fn read(text: &str, model: &mut Model) {
    let end = text.find(SETTINGS).unwrap_or(text.len());
    if end < text.len() {
        model.remark(
            end,
            "the settings of L-Py's editor: colours, lights and the scene",
        );
    }
    let mut lpy = Lpy {
        text,
        words: Words::new(),
        block: None,
        skipped: false,
        axiom: None,
    };
    let statements = statements(text, end);
    for (start, end) in &statements {
        lpy.declarations(*start, *end, model);
    }
    for (start, end) in statements {
        if let Err(fault) = lpy.statement(start, end, model) {
            model.fault(fault);
        }
    }
    // As L-Py takes them where a file says nothing.
    let one = || {
        Some(Valued {
            at: 0,
            value: Node::number(0, "1").ok()?,
        })
    };
    model.steps = model.steps.take().or_else(one);
    model.decompose_depth = model.decompose_depth.take().or_else(one);
}

/// Statements with what is indented below them: first and last byte.
fn statements(text: &str, end: usize) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    let mut at = 0;
    for line in text.get(..end).unwrap_or("").split_inclusive('\n') {
        let start = at;
        at += line.len();
        let trimmed = line.trim();
        if trimmed.is_empty() || trimmed.starts_with('#') {
            continue;
        }
        let goes_on = line.starts_with([' ', '\t', ')', '}'])
            || trimmed == "]"
            || ["else:", "elif ", "except", "finally:"]
                .iter()
                .any(|w| line.starts_with(w));
        let last = start + line.trim_end().len();
        match found.last_mut().filter(|_| goes_on) {
            Some(statement) => statement.1 = last,
            None => found.push((start, last)),
        }
    }
    found
}

/// Modules with values, up to the reader's end.
pub(super) fn string(reader: &mut Reader<'_>, words: &Words) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    if reader.rest().trim() == "*" {
        reader.take("*");
    }
    while !reader.at_end() {
        let at = reader.pos();
        let key = words.symbol(reader)?;
        let arguments = match reader.take("(") {
            true => reader.arguments()?,
            false => Vec::new(),
        };
        list.push(placed(Module { key, at, arguments }));
    }
    Ok(list)
}

/// `~("leaf", 2)` and `surface("leaf", 2)` as a placed shape with its size.
fn placed(mut module: Module) -> Module {
    use super::expression::Kind;
    if matches!(module.key.as_str(), "~" | "surface")
        && let Some(first) = module.arguments.first()
        && let Kind::Text(name) = &first.kind
        && name.chars().count() == 1
        && name.chars().all(char::is_alphabetic)
    {
        module.key = format!("~{name}");
        module.arguments.remove(0);
    }
    module
}

/// Modules with names of parameters, up to `<`, `>`, `:` or an arrow.
fn heads(reader: &mut Reader<'_>, words: &Words) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    loop {
        if reader.at_end() {
            return Ok(list);
        }
        let rest = reader.rest();
        let arrow = rest.starts_with("-->") || rest.starts_with("-static->");
        if arrow || rest.starts_with(['<', '>', ':']) {
            return Ok(list);
        }
        let at = reader.pos();
        let key = words.symbol(reader)?;
        let arguments = match reader.take("(") {
            true => formals(reader)?,
            false => Vec::new(),
        };
        list.push(Module { key, at, arguments });
    }
}

struct Lpy<'a> {
    text: &'a str,
    words: Words,
    /// The list of rules that is read, or Python.
    block: Option<Block>,
    /// In a group of rules that nothing puts to use.
    skipped: bool,
    axiom: Option<usize>,
}

/// Words before a colon that begin a part of the file.
const LABELS: [&str; 9] = [
    "Axiom",
    "derivation length",
    "production",
    "interpretation",
    "homomorphism",
    "decomposition",
    "maximum depth",
    "ignore",
    "consider",
];

/// The label at the beginning of a statement, and its length with the colon.
fn label(statement: &str) -> Option<(&'static str, usize)> {
    LABELS.into_iter().find_map(|label| {
        let rest = statement.strip_prefix(label)?;
        let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        let colon = rest.trim_start_matches([' ', '\t']).starts_with(':');
        colon.then_some((label, label.len() + blanks + 1))
    })
}

impl<'a> Lpy<'a> {
    fn reader(&self, start: usize, end: usize) -> Reader<'a> {
        Reader::new(self.text, Dialect::Lpy, start, end)
    }

    /// Names of modules are known in the whole file.
    fn declarations(&mut self, start: usize, end: usize, model: &mut Model) {
        let mut reader = self.reader(start, end);
        if !reader.take_word("module") || reader.take("=") {
            return;
        }
        loop {
            let Some(name) = reader.word() else { return };
            self.words.add(name);
            let mut declared = Vec::new();
            if reader.take("(") {
                while let Some(formal) = reader.word() {
                    declared.push(formal.to_owned());
                    // A value that a parameter has by itself.
                    if reader.take("=") && reader.expression().is_err() {
                        return;
                    }
                    reader.take(",");
                }
                reader.take(")");
            }
            model.declared.push(Declared {
                name: name.to_owned(),
                formals: declared,
            });
            if !reader.take(",") {
                return;
            }
        }
    }

    fn statement(&mut self, start: usize, end: usize, model: &mut Model) -> Result<(), Fault> {
        let text = self.text.get(start..end).unwrap_or("");
        if let Some((label, length)) = label(text) {
            return self.labelled(label, self.reader(start + length, end), model);
        }
        let mut reader = self.reader(start, end);
        let first = reader.clone().word().unwrap_or("");
        match first {
            "endlsystem" => self.block = None,
            "endgroup" => self.skipped = false,
            "group" if text.trim_end().ends_with(':') && self.block.is_some() => {
                reader.take_word("group");
                self.skipped = reader.rest().trim_end_matches(':').trim() != "0";
                if self.skipped {
                    model.remark(start, "groups of rules, which only Python code puts to use");
                }
            }
            _ => {
                return match self.block {
                    Some(_) if self.skipped => Ok(()),
                    Some(block) => self.rule(block, reader, model),
                    None => code(reader, text, model),
                };
            }
        }
        Ok(())
    }

    fn labelled(
        &mut self,
        label: &str,
        mut reader: Reader<'a>,
        model: &mut Model,
    ) -> Result<(), Fault> {
        let start = reader.pos();
        match label {
            "Axiom" => {
                if self.axiom.replace(start).is_some() {
                    return Err(Fault::new(start, "the axiom stands here a second time"));
                }
                model.axiom = Some((start, string(&mut reader, &self.words)?));
            }
            "derivation length" => model.steps = Some(valued(&mut reader)?),
            "maximum depth" => {
                let depth = Some(valued(&mut reader)?);
                match self.block {
                    Some(Block::Decompose) => model.decompose_depth = depth,
                    _ => model.interpret_depth = depth,
                }
            }
            "ignore" | "consider" => {
                let mut list = string(&mut reader, &self.words)?;
                list.retain(|m| !(label == "consider" && matches!(m.key.as_str(), "[" | "]")));
                match label {
                    "ignore" => model.ignored = list,
                    _ => model.considered = Some(list),
                }
            }
            _ => {
                self.block = Some(match label {
                    "production" => Block::Main,
                    "decomposition" => Block::Decompose,
                    _ => Block::Interpret,
                });
            }
        }
        Ok(())
    }

    fn rule(&self, block: Block, mut reader: Reader<'a>, model: &mut Model) -> Result<(), Fault> {
        let start = reader.pos();
        let mut left = Vec::new();
        let mut heads = heads(&mut reader, &self.words)?;
        for sides in ["<<", ">>"] {
            if reader.rest().starts_with(sides) {
                return Err(reader.expected(
                    "one `<` or `>`; contexts of what is made in this step cannot be carried over",
                ));
            }
        }
        if reader.take("<") {
            left = heads;
            heads = self::heads(&mut reader, &self.words)?;
        }
        let mut right = Vec::new();
        if reader.take(">") {
            right = self::heads(&mut reader, &self.words)?;
        }
        if block != Block::Main && !(left.is_empty() && right.is_empty()) {
            return Err(Fault::new(
                start,
                "contexts of decompositions and interpretations cannot be carried over",
            ));
        }
        let mut heads = heads.into_iter();
        let Some(predecessor) = heads.next() else {
            return Err(reader.expected("a rule: a module, then `-->` or `:`"));
        };
        if let Some(second) = heads.next() {
            return Err(Fault::new(
                second.at,
                format!(
                    "found `{}`; a rule for several modules at once cannot be carried over",
                    second.key
                ),
            ));
        }
        let rule = Rule {
            block,
            left,
            predecessor,
            right,
            condition: None,
            weight: None,
            successor: Vec::new(),
        };
        if reader.take("-static->") || reader.take("-->") {
            let successor = string(&mut reader, &self.words)?;
            model.add(Rule { successor, ..rule });
            return Ok(());
        }
        if !reader.take(":") {
            return Err(reader.expected("`-->` or `:`"));
        }
        python::rules(reader, &self.words, &rule, model)
    }
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

/// Python outside the rules.
fn code(mut reader: Reader<'_>, text: &str, model: &mut Model) -> Result<(), Fault> {
    let start = reader.pos();
    let first = reader.clone().word().unwrap_or("");
    match first {
        "module" => return Ok(()),
        "from" | "import" => {
            let known = ["math", "random", "openalea", "lpy", "numpy"];
            let module = text.split_whitespace().nth(1).unwrap_or("");
            if !known
                .iter()
                .any(|k| module == *k || module.starts_with(&format!("{k}.")))
            {
                model.remark(start, format!("the Python module `{module}`"));
            }
            return Ok(());
        }
        "def" => {
            reader.take_word("def");
            let name = reader.word().unwrap_or("");
            if matches!(name, "Start" | "StartEach" | "EndEach" | "End") {
                return Err(Fault::new(
                    start,
                    format!(
                        "the Python function `{name}` runs between the steps and cannot be carried over; expected rules alone"
                    ),
                ));
            }
            model.remark(start, format!("the Python function `{name}`"));
            return Ok(());
        }
        "seed" | "random" if seeded(&mut reader, model) => return Ok(()),
        "extern" => {
            reader.take_word("extern");
            if reader.take("(") {
                return assigned(&mut reader, ")", model);
            }
        }
        _ => {}
    }
    if let Some(angle) = text
        .split_once("setAngleIncrement(")
        .or_else(|| text.split_once("angle_increment ="))
    {
        let at = start + text.len() - angle.1.len();
        let mut inner = reader.clone();
        inner.advance(at - start);
        if let Ok(value) = inner.expression() {
            model.angle = Some(Valued { at, value });
            return Ok(());
        }
    }
    let mut ahead = reader.clone();
    let named = ahead.word().is_some() && (ahead.take("=") || ahead.take(","));
    if named && !ahead.rest().starts_with('=') {
        return assigned(&mut reader, "", model);
    }
    model.remark(start, "Python code outside the rules");
    Ok(())
}

/// `seed(3)` or `random.seed(3)`.
fn seeded(reader: &mut Reader<'_>, model: &mut Model) -> bool {
    let mut ahead = reader.clone();
    ahead.take_word("random");
    ahead.take(".");
    if !(ahead.take_word("seed") && ahead.take("(")) {
        return false;
    }
    let at = ahead.pos();
    match ahead.expression() {
        Ok(value) => {
            model.seed = Some(Valued { at, value });
            true
        }
        Err(_) => false,
    }
}

/// `a = 1`, `a, b = 1, 2` and, up to `close`, `a=1, b=2`. What is no number is named.
fn assigned(reader: &mut Reader<'_>, close: &str, model: &mut Model) -> Result<(), Fault> {
    let mut names = Vec::new();
    loop {
        reader.skip_blank();
        let at = reader.pos();
        let Some(name) = reader.word() else {
            model.remark(at, "Python code outside the rules");
            return Ok(());
        };
        names.push((at, name.to_owned()));
        if !reader.take(",") {
            break;
        }
    }
    if !reader.take("=") {
        let at = names.first().map_or(0, |n| n.0);
        model.remark(at, "Python code outside the rules");
        return Ok(());
    }
    let mut names = names.into_iter().peekable();
    while let Some((at, name)) = names.next() {
        if model.is_constant(&name) {
            return Err(Fault::new(
                at,
                format!("`{name}` is given a value twice; expected a constant"),
            ));
        }
        match reader.expression() {
            Ok(value) => model.constant(name, Valued { at, value }),
            Err(_) => {
                model.remark(at, format!("`{name}`, whose value is no number"));
                return Ok(());
            }
        }
        if names.peek().is_some() && !reader.take(",") {
            model.remark(at, "Python code outside the rules");
            return Ok(());
        }
    }
    if !close.is_empty() && reader.take(",") {
        return assigned_next(reader, close, model);
    }
    if !close.is_empty() {
        reader.take(close);
    }
    if !reader.at_end() && !reader.rest().starts_with(';') {
        let at = reader.pos();
        return Err(Fault::new(
            at,
            "this Python code cannot be carried over; expected the end of the line",
        ));
    }
    Ok(())
}

/// The further values of an `extern`.
fn assigned_next(reader: &mut Reader<'_>, close: &str, model: &mut Model) -> Result<(), Fault> {
    while let Some(name) = reader.word() {
        let at = reader.pos();
        let name = name.to_owned();
        if !reader.take("=") {
            return Err(reader.expected("`=`"));
        }
        let value = reader.expression()?;
        model.constant(name, Valued { at, value });
        if !reader.take(",") {
            break;
        }
    }
    match reader.take(close) {
        true => Ok(()),
        false => Err(reader.expected(&format!("`{close}`"))),
    }
}
