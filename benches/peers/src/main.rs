//! Derivation beside other engines, in one run: the crates `lindenmayer` and `symbios`, and npm's `lindenmayer` where node has it.
//!
//! `scripts/peers.sh`, which `make bench` calls. All engines take turns, each run is measured in CPU time of its process on one
//! thread, medians are printed, and what each engine made is compared with what the literature says. This is a package of
//! its own, so that neither tests nor the program ever build the peers.

mod systems;

use std::process::Command;
use std::sync::atomic::AtomicBool;

use cpu_time::ProcessTime;
use ramus::lsystem::{Grammar, Limits};
use systems::{System, cells, systems};

/// Turns.
const TURNS: usize = 5;
/// What a string of the stochastic system says of all strings before it: modules made for each of its own.
const STOCHASTIC_SUM: f64 = 1.376;

/// One run: CPU seconds and modules of the last string.
type Run = (f64, usize);

fn main() {
    let node = node();
    println!(
        "{:8} {:>8} {:>12} {:>9} {:>8} {:>12}   M modules per CPU second, ratios, what is asked for",
        "", "ramus", "lindenmayer", "symbios", "npm", "goal"
    );
    let mut missed = Vec::new();
    for system in systems() {
        let line = compare(&system, node.as_deref());
        println!("{}", line.text);
        missed.extend(line.missed);
    }
    if !missed.is_empty() {
        println!("missed: {}", missed.join(", "));
    }
}

struct Line {
    text: String,
    missed: Option<String>,
}

fn compare(system: &System, node: Option<&str>) -> Line {
    let grammar = Grammar::parse(&system.grammar, system.name).expect("a grammar of ours");
    let produced = produced(&grammar, system);
    let symbios_text = symbios_text(system.name);
    let mut runs: [Vec<Run>; 4] = Default::default();
    for _ in 0..TURNS {
        runs[0].push(ours(&grammar, system));
        runs[1].extend(lindenmayer(system, &grammar));
        runs[2].push(symbios(&symbios_text, system.steps));
        runs[3].extend(node.and_then(|modules| npm(modules, system)));
    }
    let speeds: Vec<Option<f64>> = runs
        .iter()
        .map(|runs| {
            let seconds = median(runs.iter().map(|run| run.0).collect())?;
            let modules = match system.length {
                Some(_) => produced,
                None => median(runs.iter().map(|run| run.1 as f64).collect())? * STOCHASTIC_SUM,
            };
            Some(modules / seconds / 1e6)
        })
        .collect();
    let ours = speeds[0].unwrap_or(f64::NAN);
    let peer = |index: usize| {
        let Some(speed) = speeds[index] else {
            return "–".to_owned();
        };
        let wrong = system
            .length
            .is_some_and(|length| runs[index].iter().any(|r| r.1 != length));
        let mark = if wrong { " (wrong)" } else { "" };
        format!("{speed:.1}{mark} ×{:.1}", ours / speed)
    };
    let (goal, reached) = goal(system.name, ours, &speeds);
    let text = format!(
        "{:8} {ours:8.1} {:>12} {:>9} {:>8} {goal:>12}",
        system.name,
        peer(1),
        peer(2),
        peer(3)
    );
    let missed = (!reached).then(|| format!("{} ({goal})", system.name));
    Line { text, missed }
}

/// What is asked for, in words, and whether it is reached.
fn goal(name: &str, ours: f64, speeds: &[Option<f64>]) -> (String, bool) {
    let times = |factor: f64, index: usize, peer: &str| {
        let reached = speeds[index].is_none_or(|speed| ours >= factor * speed);
        (format!("{factor}× {peer}"), reached)
    };
    match name {
        "honda" => times(11.0, 2, "symbios"),
        "row" => times(15.0, 2, "symbios"),
        "signal" => times(6.5, 2, "symbios"),
        "diffuse" => times(10.0, 2, "symbios"),
        "hh" => ("90".to_owned(), ours >= 90.0),
        _ => times(2.0, 1, "lindenmayer"),
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Modules of all strings behind the axiom.
fn produced(grammar: &Grammar, system: &System) -> f64 {
    let (limits, cancel) = (Limits::default(), AtomicBool::new(false));
    let mut string = grammar.derive(0, &limits, &cancel).expect("an axiom");
    let mut sum = 0;
    for step in 1..=system.steps {
        string = grammar
            .derive_next(&string, step, &limits, &cancel)
            .expect("a step");
        sum += string.len();
    }
    assert_eq!(
        string.len(),
        system.length.unwrap_or(string.len()),
        "{}: another string than the literature's",
        system.name
    );
    sum as f64
}

fn ours(grammar: &Grammar, system: &System) -> Run {
    let start = ProcessTime::now();
    let string = grammar.derive(system.steps, &Limits::default(), &AtomicBool::new(false));
    let seconds = start.elapsed().as_secs_f64();
    (seconds, string.expect("a string").len())
}

/// The crate knows context-free strings only.
fn lindenmayer(system: &System, grammar: &Grammar) -> Option<Run> {
    use lindenmayer::{LSystem, LSystemStochastic};
    let steps = system.steps as usize;
    if system.name == "stoch" {
        let rules = vec![("F[+F]F[-F]F", 0.33), ("F[+F]F", 0.33), ("F[-F]F", 0.34)];
        let peer = LSystemStochastic::new("F".into(), &[('F', rules)]);
        let start = ProcessTime::now();
        let string = peer.string(steps, Some(7));
        return Some((start.elapsed().as_secs_f64(), string.len()));
    }
    if !matches!(system.name, "algae" | "bush") {
        return None;
    }
    let lines = system.grammar.lines();
    let rules: Vec<(char, &str)> = lines
        .filter_map(|line| line.split_once(" -> "))
        .filter_map(|(from, to)| Some((from.chars().next()?, to)))
        .collect();
    let axiom = system.grammar.strip_prefix("axiom ")?.lines().next()?;
    let peer = LSystem::new(axiom.into(), &rules);
    let start = ProcessTime::now();
    let string = peer.string(steps);
    let seconds = start.elapsed().as_secs_f64();
    let own = grammar.derive(6, &Limits::default(), &AtomicBool::new(false));
    let own = own.expect("a string").to_text(grammar);
    assert_eq!(peer.string(6), own, "{}: the same string", system.name);
    Some((seconds, string.len()))
}

/// The systems in its notation: letters for digits and braces, which it has none for.
fn symbios_text(name: &str) -> String {
    let text = match name {
        "algae" => "omega: b\na -> a b\nb -> a",
        "bush" => {
            "omega: A\nA -> [ & F L ! A ] / / / / / ' [ & F L ! A ] / / / / / / / ' [ & F L ! A ]\n\
             F -> S / / / / / F\nS -> F L\nL -> [ ' ' ' ^ ^ P - f + f + f - | - f + f + f Q ]"
        }
        "stoch" => {
            "omega: F\n0.33: F -> F [ + F ] F [ - F ] F\n0.33: F -> F [ + F ] F\n0.34: F -> F [ - F ] F"
        }
        "honda" => {
            "omega: A(1,10)\nA(l,w) -> !(w) F(l) [ &(45) B(l*0.6,w*0.707) ] /(137.5) A(l*0.9,w*0.707)\n\
             B(l,w) -> !(w) F(l) [ -(45) $ C(l*0.6,w*0.707) ] C(l*0.9,w*0.707)\n\
             C(l,w) -> !(w) F(l) [ +(45) $ B(l*0.6,w*0.707) ] B(l*0.9,w*0.707)"
        }
        "row" => {
            "omega: F(1,0)\nF(x,t) : t==0 -> F(x*0.3,2) + F(x*0.45825756949558,1) - - F(x*0.45825756949558,1) + F(x*0.7,0)\n\
             F(x,t) : t>0 -> F(x,t-1)"
        }
        "signal" => return format!("omega: b{}\nb < a -> b\nb -> a", " a".repeat(1 << 20)),
        "hh" => {
            "#ignore: + - F\nomega: F I F I F I\nO < O > O -> I\nO < O > I -> I [ - F I F I ]\nO < I > O -> I\n\
             O < I > I -> I\nI < O > O -> O\nI < O > I -> I F I\nI < I > O -> I\nI < I > I -> O\n+ -> -\n- -> +"
        }
        _ => {
            return format!(
                "omega: {}\nC(l) < C(x) > C(r) : x>=0 -> C(x+0.25*(l+r-2*x))",
                cells()
            );
        }
    };
    text.to_owned()
}

fn symbios(text: &str, steps: u32) -> Run {
    let mut peer = symbios::System::new();
    peer.max_capacity = 1 << 28;
    for line in text.lines() {
        let done = match line.strip_prefix("omega: ") {
            Some(axiom) => {
                peer.state.max_capacity = 1 << 28;
                peer.set_axiom(axiom)
            }
            None if line.starts_with('#') => peer.add_directive(line),
            None => peer.add_rule(line),
        };
        done.expect("its notation");
    }
    let start = ProcessTime::now();
    peer.derive(steps as usize).expect("a string");
    (start.elapsed().as_secs_f64(), peer.state.len())
}

/// The folder of node's modules, where node runs and has the package there.
fn node() -> Option<String> {
    let modules = std::env::args().nth(1)?;
    let has_it = std::path::Path::new(&modules).join("lindenmayer").exists();
    let runs = Command::new("node").arg("--version").output();
    if has_it && runs.is_ok_and(|output| output.status.success()) {
        return Some(modules);
    }
    println!("npm's lindenmayer is left out: node or the package is not here");
    None
}

fn npm(modules: &str, system: &System) -> Option<Run> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/lindenmayer.cjs");
    let output = Command::new("node")
        .args([script, modules, system.name, &system.steps.to_string()])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (seconds, modules) = text.trim().split_once(' ')?;
    Some((seconds.parse().ok()?, modules.parse().ok()?))
}
