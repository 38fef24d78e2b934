//! The reference systems, which L-Py and cpfg were run on, written as their files and brought over: the same results.

use std::fmt::Write as _;

use ramus::lsystem::Grammar;
use serde_json::Value;

use super::super::{reference, shared};

fn productions(system: &Value) -> impl Iterator<Item = &str> {
    let list = system["productions"].as_array().unwrap();
    list.iter().map(|p| p.as_str().unwrap())
}

fn constants(system: &Value) -> Vec<(&str, String)> {
    let list = system["constants"].as_object().into_iter().flatten();
    let text = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
    list.map(|(name, value)| (name.as_str(), text(value)))
        .collect()
}

/// Head, condition and successor.
fn parts(production: &str) -> (&str, Option<&str>, &str) {
    let (head, successor) = production.split_once("->").unwrap();
    let head = head.trim_end_matches('-');
    match head.split_once(':') {
        Some((head, condition)) => (head.trim(), Some(condition.trim()), successor.trim()),
        None => (head.trim(), None, successor.trim()),
    }
}

/// The letters that a system draws besides `F`.
fn drawn(system: &Value) -> Option<(&Value, String)> {
    let checks = system["checks"].as_array().into_iter().flatten();
    let geometry = checks.map(|c| &c["geometry"]).find(|g| g.is_object())?;
    let draw = geometry["draw"].as_str().unwrap();
    Some((
        &geometry["delta"],
        draw.chars().filter(|c| *c != 'F').collect(),
    ))
}

/// The turtle's level is `@v` in both programs; powers within parentheses are `power`.
fn modules(text: &str, power: &str) -> String {
    let mut depth = 0;
    let mut out = String::new();
    for c in text.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        match c {
            '$' => out += "@v",
            '^' if depth > 0 => out += power,
            c => out.push(c),
        }
    }
    out
}

fn lpy(system: &Value) -> String {
    let python = |text: &str| {
        let text = text.replace("&&", " and ").replace("||", " or ");
        text.replace('^', "**")
    };
    let mut text = "dialect lpy\n".to_owned();
    for (name, value) in constants(system) {
        writeln!(text, "{name} = {}", python(&value)).unwrap();
    }
    for list in ["ignore", "consider"] {
        if let Some(names) = system[list].as_str() {
            writeln!(text, "{list}: {names}").unwrap();
        }
    }
    let axiom = modules(system["axiom"].as_str().unwrap(), "**");
    writeln!(text, "Axiom: {axiom}").unwrap();
    if let Some((angle, _)) = drawn(system) {
        writeln!(text, "context().turtle.setAngleIncrement({angle})").unwrap();
    }
    text += "production:\n";
    for production in productions(system) {
        let (head, condition, successor) = parts(production);
        let successor = modules(successor, "**");
        match condition {
            None => writeln!(text, "{head} --> {successor}").unwrap(),
            Some(condition) => {
                let condition = python(condition);
                writeln!(text, "{head} :\n  if {condition}:\n    produce {successor}").unwrap();
            }
        }
    }
    if let Some((_, letters)) = drawn(system) {
        text += "interpretation:\n";
        for letter in letters.chars() {
            writeln!(text, "{letter} --> F").unwrap();
        }
    }
    text + "endlsystem\n"
}

fn cpfg(system: &Value) -> String {
    let mut text = "dialect cpfg\nLsystem: 1\n".to_owned();
    if !constants(system).is_empty() {
        text += "Start: {\n";
        for (name, value) in constants(system) {
            writeln!(text, "  {name} = {value};").unwrap();
        }
        text += "}\n";
    }
    for (list, brackets) in [("ignore", ""), ("consider", "[]")] {
        if let Some(names) = system[list].as_str() {
            writeln!(text, "{list}: {names}{brackets}").unwrap();
        }
    }
    let axiom = modules(system["axiom"].as_str().unwrap(), "^");
    writeln!(text, "Axiom: {axiom}").unwrap();
    for production in productions(system) {
        let (head, condition, successor) = parts(production);
        let condition = condition.map_or(String::new(), |c| format!(" : {c}"));
        let head = match head.split_once('>') {
            Some((before, right)) => format!("{before}>{}", right.replace(']', "=]")),
            None => head.to_owned(),
        };
        let successor = modules(successor, "^");
        writeln!(text, "{head}{condition} --> {successor}").unwrap();
    }
    text + "endlsystem\n"
}

/// Whether a symbol is called otherwise in our string, so that the names' hash is another.
fn renamed(system: &Value, symbols: &str) -> bool {
    let mut words = productions(system).chain(system["axiom"].as_str());
    words.any(|text| text.chars().any(|c| symbols.contains(c)))
}

#[test]
fn reference_systems_are_the_same_when_they_come_from_l_py_or_cpfg() {
    let own = include_str!("../../data/lsystems.json").to_owned();
    let (mut seen, mut checks) = ([0, 0], 0);
    for json in [Some(own), shared("lsystems-reference.json")]
        .into_iter()
        .flatten()
    {
        let all: Value = serde_json::from_str(&json).unwrap();
        for system in all["systems"].as_array().unwrap() {
            let id = system["id"].as_str().unwrap();
            let files = [
                (lpy(system), renamed(system, "TGg';"), true),
                (cpfg(system), renamed(system, "T/\\';"), false),
            ];
            for (i, (text, renamed, geometry)) in files.into_iter().enumerate() {
                if renamed {
                    continue;
                }
                let grammar =
                    Grammar::parse(&text, id).unwrap_or_else(|e| panic!("{id}: {e}\n{text}"));
                seen[i] += 1;
                for check in system["checks"].as_array().unwrap() {
                    let mut check = check.clone();
                    if !geometry {
                        check["geometry"] = Value::Null;
                    }
                    reference::check(&format!("{id} {i}"), &grammar, &check);
                    checks += 1;
                }
            }
        }
    }
    eprintln!("{seen:?} systems, {checks} checks");
    assert!(seen[0] >= 10 && seen[1] >= 10, "{seen:?}");
}
