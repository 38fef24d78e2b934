//! A statement cut into tokens, each with whether a blank goes before it.
//!
//! Blanks between modules are the writer's (`F[+F]F` and `A B` read differently to people), but for their number; those of
//! expressions follow from the operators. The statement has been parsed before, so what is not understood here is
//! only given up (`None`), never an error: it then stays as it is.

use crate::lsystem::names::Names;
use crate::lsystem::source::{Cursor, Statement};

/// What a token is to the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Plain,
    /// The `:` before a condition or a weight.
    Colon,
    /// The arrow of a production.
    Arrow,
}

#[derive(Clone, Debug)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    /// First byte in the source.
    pub(super) at: usize,
    /// Whether a blank goes before it, unless it is the first of its line.
    pub(super) blank: bool,
    pub(super) part: Part,
}

/// The tokens of a statement, its keyword included; `None` where it is not understood.
pub(super) fn tokens<'a>(
    names: &Names,
    cursor: Cursor<'a>,
    statement: &Statement,
) -> Option<Vec<Token<'a>>> {
    let mut reader = Reader {
        names,
        cursor,
        found: Vec::new(),
    };
    if !statement.keyword.is_empty() {
        reader.put(statement.keyword, statement.start, false, Part::Plain);
    }
    match statement.keyword {
        "" => reader.production()?,
        "axiom" => reader.modules(Gaps::Kept, true)?,
        "ignore" | "consider" => reader.modules(Gaps::All, true)?,
        "const" => reader.constants()?,
        "steps" | "seed" | "angle" => reader.expression(true, true)?,
        "ground" => reader.signed(true)?,
        "tropism" => {
            for _ in 0..3 {
                reader.signed(true)?;
            }
        }
        "decompose" | "interpret" => {
            if reader.word("depth") {
                reader.expression(true, true)?;
            }
            reader.sign("{", true)?;
        }
        "module" => reader.declarations()?,
        "shape" | "surface" => reader.shape()?,
        "colour" | "material" => reader.look()?,
        "bark" | "season" | "bears" | "widths" => reader.words()?,
        "order" | "wrap" | "context" | "dialect" => {
            reader.identifier(true)?;
        }
        "growth" => reader.growth()?,
        "include" => reader.quoted()?,
        _ => return None,
    }
    reader.cursor.at_end().then_some(reader.found)
}

/// Blanks between modules.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Gaps {
    /// Where the text has them.
    Kept,
    /// Everywhere.
    All,
}

/// Infix operators, the longest first, and whether they are comparisons or join such.
const OPERATORS: [(&str, bool); 14] = [
    ("||", true),
    ("&&", true),
    ("==", true),
    ("!=", true),
    ("<=", true),
    (">=", true),
    ("<", true),
    (">", true),
    ("+", false),
    ("-", false),
    ("*", false),
    ("/", false),
    ("%", false),
    ("^", false),
];

struct Reader<'a, 'n> {
    names: &'n Names,
    cursor: Cursor<'a>,
    found: Vec<Token<'a>>,
}

impl<'a> Reader<'a, '_> {
    fn put(&mut self, text: &'a str, at: usize, blank: bool, part: Part) {
        self.found.push(Token {
            text,
            at,
            blank,
            part,
        });
    }

    /// Takes what stands from `at` to the cursor.
    fn put_from(&mut self, at: usize, blank: bool) {
        let text = self.cursor.between(at, self.cursor.pos());
        self.put(text, at, blank, Part::Plain);
    }

    /// Takes a sign that must stand here.
    fn sign(&mut self, sign: &str, blank: bool) -> Option<()> {
        self.try_sign(sign, blank).then_some(())
    }

    fn try_sign(&mut self, sign: &str, blank: bool) -> bool {
        self.cursor.skip_blank();
        let at = self.cursor.pos();
        let here = self.cursor.take(sign);
        if here {
            self.put_from(at, blank);
        }
        here
    }

    fn identifier(&mut self, blank: bool) -> Option<&'a str> {
        self.cursor.skip_blank();
        let at = self.cursor.pos();
        let name = self.cursor.identifier()?;
        self.put(name, at, blank, Part::Plain);
        Some(name)
    }

    /// Takes the identifier `word` if it stands here.
    fn word(&mut self, word: &str) -> bool {
        let mut ahead = self.cursor.clone();
        ahead.identifier() == Some(word) && self.identifier(true).is_some()
    }

    fn quoted(&mut self) -> Option<()> {
        self.cursor.skip_blank();
        let at = self.cursor.pos();
        let length = self.cursor.rest().strip_prefix('"')?.find(['"', '\n'])? + 2;
        self.cursor.advance(length);
        self.put_from(at, true);
        self.found.last()?.text.ends_with('"').then_some(())
    }

    /// Whether blanks (or comments) stand between the last token and what follows.
    fn gap(&mut self) -> bool {
        let end = self
            .found
            .last()
            .map_or(0, |last| last.at + last.text.len());
        self.cursor.skip_blank();
        self.cursor.pos() > end
    }

    /// Modules with expressions as parameters, to the end of the statement; `blank` before the first.
    fn modules(&mut self, gaps: Gaps, mut blank: bool) -> Option<()> {
        if self.try_sign("*", true) {
            return Some(());
        }
        while !self.cursor.at_end() {
            self.module(blank)?;
            if self.try_sign("(", false) && !self.try_sign(")", false) {
                self.arguments()?;
            }
            blank = self.gap() || gaps == Gaps::All;
        }
        Some(())
    }

    fn module(&mut self, blank: bool) -> Option<()> {
        self.cursor.skip_blank();
        let at = self.cursor.pos();
        let name = self.names.read(&mut self.cursor).ok()?;
        self.put(name, at, blank, Part::Plain);
        Some(())
    }

    /// Expressions up to the `)` that closes them.
    fn arguments(&mut self) -> Option<()> {
        let mut blank = false;
        loop {
            self.expression(false, blank)?;
            if self.try_sign(")", false) {
                return Some(());
            }
            self.sign(",", false)?;
            blank = true;
        }
    }

    /// An expression, up to what cannot go on it. `wide`: arithmetic has blanks round it, as outside of parentheses.
    fn expression(&mut self, wide: bool, mut blank: bool) -> Option<()> {
        let mut depth = 0_usize;
        let mut operand = false; // whether an operand stands before
        let mut last_sign = "";
        loop {
            self.cursor.skip_blank();
            let rest = self.cursor.rest();
            let at = self.cursor.pos();
            let first = rest.chars().next();
            if !operand {
                match first {
                    Some('(') => {
                        self.sign("(", blank)?;
                        depth += 1;
                        (blank, last_sign) = (false, "");
                    }
                    // A call without arguments is none of the language's, but for later ones.
                    Some(')') if depth > 0 => {
                        self.sign(")", false)?;
                        depth -= 1;
                        operand = true;
                    }
                    Some('-' | '+' | '!') if !rest.starts_with("->") => {
                        let sign = rest.get(..1)?;
                        // `x - -y`: two signs of one kind are kept apart.
                        self.sign(sign, blank || last_sign == sign)?;
                        (blank, last_sign) = (false, sign);
                    }
                    Some(c) if c.is_ascii_digit() || c == '.' => {
                        crate::lsystem::expression::number(&mut self.cursor).ok()?;
                        self.put_from(at, blank);
                        operand = true;
                    }
                    Some(c) if c.is_alphabetic() || c == '_' => {
                        self.identifier(blank)?;
                        operand = true;
                        if self.try_sign("(", false) {
                            depth += 1;
                            (operand, blank, last_sign) = (false, false, "");
                        }
                    }
                    _ => return None,
                }
                continue;
            }
            match first {
                Some(')') if depth > 0 => {
                    self.sign(")", false)?;
                    depth -= 1;
                    continue;
                }
                Some(',') if depth > 0 => {
                    self.sign(",", false)?;
                    (operand, blank, last_sign) = (false, true, "");
                    continue;
                }
                _ => {}
            }
            let operator = OPERATORS.iter().find(|(sign, _)| rest.starts_with(*sign));
            match operator {
                Some((sign, joins)) if !rest.starts_with("->") && !rest.starts_with("-->") => {
                    blank = *joins || (wide && depth == 0 && *sign != "^");
                    self.sign(sign, blank)?;
                    last_sign = sign;
                    operand = false;
                }
                _ => return (depth == 0).then_some(()),
            }
        }
    }

    fn constants(&mut self) -> Option<()> {
        loop {
            self.identifier(true)?;
            self.sign("=", true)?;
            self.expression(true, true)?;
            if !self.try_sign(",", false) {
                return Some(());
            }
        }
    }

    fn declarations(&mut self) -> Option<()> {
        loop {
            self.cursor.skip_blank();
            let at = self.cursor.pos();
            let name = Names::read_declared(&mut self.cursor).ok()?;
            self.put(name, at, true, Part::Plain);
            self.formals()?;
            if !self.try_sign(",", false) {
                return Some(());
            }
        }
    }

    /// Names of parameters in parentheses, if there are any.
    fn formals(&mut self) -> Option<()> {
        if !self.try_sign("(", false) || self.try_sign(")", false) {
            return Some(());
        }
        let mut blank = false;
        loop {
            self.identifier(blank)?;
            if self.try_sign(")", false) {
                return Some(());
            }
            self.sign(",", false)?;
            blank = true;
        }
    }

    fn production(&mut self) -> Option<()> {
        let mut blank = false;
        let mut first = true; // no module since the last `<` or `>`
        loop {
            self.cursor.skip_blank();
            let at = self.cursor.pos();
            let rest = self.cursor.rest();
            let arrow = ["-->", "->"].into_iter().find(|a| rest.starts_with(*a));
            if let Some(arrow) = arrow.filter(|a| !first || *a == "->") {
                self.cursor.advance(arrow.len());
                self.put("->", at, true, Part::Arrow);
                return self.modules(Gaps::Kept, true);
            }
            match rest.chars().next()? {
                '<' => self.sign("<", true)?,
                '>' => self.sign(">", true)?,
                ':' => {
                    self.sign(":", true)?;
                    self.found.last_mut()?.part = Part::Colon;
                    self.conditions()?;
                    first = false;
                    continue;
                }
                _ => {
                    self.module(blank)?;
                    self.formals()?;
                    blank = self.gap();
                    first = false;
                    continue;
                }
            }
            (blank, first) = (true, true);
        }
    }

    fn conditions(&mut self) -> Option<()> {
        if self.word("weight") {
            return self.expression(true, true);
        }
        if self.try_sign("*", true) {
            return Some(());
        }
        self.expression(true, true)?;
        if self.try_sign(",", false) {
            if !self.word("weight") {
                return None;
            }
            self.expression(true, true)?;
        }
        Some(())
    }

    /// A module's growth curve, and the numbers or points of it.
    fn growth(&mut self) -> Option<()> {
        if !self.word("default") {
            self.module(true)?;
        }
        self.identifier(true)?;
        while !self.cursor.at_end() {
            if self.try_sign("(", true) {
                self.signed(false)?;
                self.try_sign(",", false);
                self.signed(true)?;
                self.sign(")", false)?;
                self.try_sign(",", false);
            } else {
                self.signed(true)?;
            }
        }
        Some(())
    }

    fn shape(&mut self) -> Option<()> {
        self.module(true)?;
        self.sign("=", true)?;
        if !self.try_sign("[", true) {
            // A surface by its name.
            return self.identifier(true).map(|_| ());
        }
        let mut blank = false;
        while !self.try_sign("]", false) {
            self.sign("(", blank)?;
            let mut blank_within = false;
            while !self.try_sign(")", false) {
                self.signed(blank_within)?;
                self.try_sign(",", false);
                blank_within = true;
            }
            self.try_sign(",", false);
            blank = true;
        }
        Some(())
    }

    /// An index, and numbers with or without words before them.
    fn look(&mut self) -> Option<()> {
        self.signed(true)?;
        self.sign("=", true)?;
        while !self.cursor.at_end() {
            if self.identifier(true).is_none() {
                self.signed(true)?;
            }
            self.try_sign(",", false);
        }
        Some(())
    }

    /// Words, which may have hyphens, and numbers.
    fn words(&mut self) -> Option<()> {
        while !self.cursor.at_end() {
            if self.identifier(true).is_none() {
                self.signed(true)?;
                continue;
            }
            if self.try_sign("-", false) {
                self.identifier(false)?;
            }
        }
        Some(())
    }

    /// A number with its sign.
    fn signed(&mut self, blank: bool) -> Option<()> {
        let mut blank = blank;
        if ["-", "+"].iter().any(|sign| self.try_sign(sign, blank)) {
            blank = false;
        }
        self.cursor.skip_blank();
        let at = self.cursor.pos();
        crate::lsystem::expression::number(&mut self.cursor).ok()?;
        self.put_from(at, blank);
        Some(())
    }
}
