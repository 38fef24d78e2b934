//! What a derivation takes from the machine at most, as the system counts it: little more than its last two strings.
//!
//! Each system is a test of its own, so that the test runner gives it a process of its own.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test that fails shows the line")]

use std::fs;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use ramus::lsystem::{Grammar, Growing, Limits};

/// Where tests share a process they take turns.
static TURN: Mutex<()> = Mutex::new(());

/// A figure of the process's memory in bytes.
fn memory(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(name)).unwrap();
    let kib = line.split_whitespace().nth(1).unwrap();
    kib.parse::<u64>().unwrap() * 1024
}

/// What a work makes, and the most memory that it took meanwhile, in bytes.
fn measured<T>(work: impl FnOnce() -> T) -> (T, u64) {
    // The pool's threads are there before it is measured.
    rayon::join(|| (), || ());
    let before = memory("VmRSS");
    // Forgets the highest mark so far.
    fs::write("/proc/self/clear_refs", "5").unwrap();
    let made = work();
    (made, memory("VmHWM").saturating_sub(before))
}

/// Steps in which a system that begins small is small still.
const FEW: u32 = 6;

/// Derives a system and holds its peak to so many times its last string.
fn takes_at_most(times: f64, text: &str, steps: u32) {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let grammar = Grammar::parse(text, "system").unwrap();
    let never = AtomicBool::new(false);
    let derive = |steps| grammar.derive(steps, &Limits::default(), &never).unwrap();
    if steps > FEW {
        // The pages of the program itself come from its file when they are used first; they are no derivation's.
        drop(derive(FEW));
    }
    let (string, taken) = measured(|| derive(steps));
    let bytes = string.bytes();
    assert!(bytes > 8 << 20, "{bytes} bytes are too few to measure");
    assert!(taken >= bytes, "what is there was taken: {taken}");
    let ratio = taken as f64 / bytes as f64;
    println!(
        "{} modules of {bytes} bytes, {taken} at most, {ratio:.2} times as much",
        string.len()
    );
    assert!(
        ratio <= times,
        "{taken} bytes, {ratio:.2} times its {bytes}"
    );
}

#[test]
fn algae_are_written_once() {
    takes_at_most(1.1, "axiom b\na -> ab\nb -> a\n", 33);
}

#[test]
fn a_bush_is_written_once() {
    let bush = "axiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\n\
                L -> ['''^^{-f+f+f-|-f+f+f}]\n";
    takes_at_most(1.1, bush, 11);
}

#[test]
fn honda_s_tree_is_written_once() {
    takes_at_most(1.2, include_str!("../assets/grammars/honda.lsys"), 18);
}

#[test]
fn rows_are_written_once() {
    let row = "axiom F(1,0)\nF(x,t) : t==0 -> F(x*0.3,2)+F(x*0.46,1)--F(x*0.46,1)+F(x*0.7,0)\n\
               F(x,t) : t>0 -> F(x,t-1)\n";
    takes_at_most(1.2, row, 18);
}

#[test]
fn chance_takes_two_strings() {
    let stoch = "axiom F\nF : weight 0.33 -> F[+F]F[-F]F\nF : weight 0.33 -> F[+F]F\nF : weight 0.34 -> F[-F]F\n";
    takes_at_most(1.6, stoch, 12);
}

#[test]
fn a_signal_takes_two_strings() {
    let signal = format!("axiom b{}\nb < a -> b\nb -> a\n", "a".repeat(1 << 23));
    takes_at_most(2.2, &signal, 4);
}

/// Contexts across branches: no index of the whole string is made.
#[test]
fn hogeweg_and_hesper_s_plant_takes_two_strings() {
    let plant = "ignore +-F\naxiom F1F1F1\n0 < 0 > 0 -> 1\n0 < 0 > 1 -> 1[-F1F1]\n0 < 1 > 0 -> 1\n\
                 0 < 1 > 1 -> 1\n1 < 0 > 0 -> 0\n1 < 0 > 1 -> 1F1\n1 < 1 > 0 -> 1\n1 < 1 > 1 -> 0\n\
                 + -> -\n- -> +\n";
    takes_at_most(2.2, plant, 54);
}

#[test]
fn a_diffusion_takes_two_strings() {
    let cells: String = (0..1_u32 << 20)
        .map(|i| format!("C({})", i.count_ones()))
        .collect();
    let diffuse = format!("axiom {cells}\nC(l) < C(x) > C(r) : x>=0 -> C(x+0.25*(l+r-2*x))\n");
    takes_at_most(2.2, &diffuse, 3);
}

/// What is drawn between two steps needs both strings and what changes between them.
#[test]
fn growing_keeps_to_its_limit() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let grammar = Grammar::parse("axiom F(1)\nF(x) -> F(x) F(x*1.1)\n", "doubling").unwrap();
    let never = AtomicBool::new(false);
    let mut made = 0;
    for mebibytes in [15, 25, 35, 45, 55, 90] {
        let limits = Limits {
            bytes: mebibytes << 20,
            ..Limits::default()
        };
        let (growing, taken) = measured(|| Growing::new(&grammar, 20, &limits, &never));
        match growing {
            Ok(growing) => {
                made += 1;
                assert!(growing.bytes() <= limits.bytes, "{mebibytes} MiB");
            }
            Err(error) => {
                let last = error.last_whole_step();
                assert_eq!(last, Some(19), "{mebibytes} MiB: {error}");
                let limit = format!("limit of {} bytes", limits.bytes);
                assert!(
                    error.to_string().contains(&limit),
                    "{mebibytes} MiB: {error}"
                );
            }
        }
        // A few pages are more than the strings' own.
        assert!(
            taken <= limits.bytes + (1 << 20),
            "{mebibytes} MiB: {taken} bytes"
        );
    }
    assert!((1..6).contains(&made), "some have room: {made}");
}
