//! Less memory than the work needs: one sentence and exit code 1, never an abort.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::{Command, Output};

use super::{folder, ramus, refused, text};

/// Twice as many segments with every step.
const DOUBLING: &str = "axiom F\nF -> FF\n";

/// Runs `ramus derive` in an address space of so many KiB.
fn within(kib: u32, folder: &std::path::Path, args: &[&str]) -> Output {
    let program = ramus();
    Command::new("sh")
        .args(["-c", "ulimit -v \"$0\" && exec \"$@\""])
        .arg(kib.to_string())
        .arg(program.get_program())
        .args(["derive", "doubling.lsys"])
        .args(args)
        // Each thread takes addresses of its own, so their number must not depend on the machine.
        .env("RAYON_NUM_THREADS", "2")
        .current_dir(folder)
        .output()
        .unwrap()
}

#[test]
fn a_process_with_little_memory_ends_in_a_sentence() {
    let folder = folder();
    fs::write(folder.path().join("doubling.lsys"), DOUBLING).unwrap();
    let mut refusals = 0;
    for kib in [100_000, 150_000, 200_000, 300_000, 900_000] {
        for args in [
            &["--steps", "20", "--json"][..],
            &["--steps", "22", "--json"],
            &["--steps", "30", "--json"],
            &["--steps", "17", "--export", "tree.glb"],
            &["--steps", "20", "--export", "tree.obj", "--memory", "64"],
        ] {
            let output = within(kib, folder.path(), args);
            if output.status.code() == Some(0) {
                continue;
            }
            refused(&output, &["MiB", "fewer steps"]);
            refusals += 1;
        }
    }
    // The last of each row, and the third, can never be done; the first in the widest room can.
    assert!((10..25).contains(&refusals), "{refusals}");
    let output = within(900_000, folder.path(), &["--steps", "20", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn what_the_memory_option_does_not_hold_is_refused_by_its_name() {
    let folder = folder();
    fs::write(folder.path().join("doubling.lsys"), DOUBLING).unwrap();
    for args in [
        // The strings, the tree, the surface, the picture.
        &["--steps", "30", "--json", "--memory", "64"][..],
        &["--steps", "22", "--json", "--memory", "64"],
        &["--steps", "19", "--export", "tree.glb", "--memory", "64"],
        &["--steps", "19", "--png", "tree.png", "--memory", "64"],
    ] {
        let output = ramus()
            .args(["derive", "doubling.lsys"])
            .args(args)
            .current_dir(folder.path())
            .output()
            .unwrap();
        refused(&output, &["--memory", "64 MiB"]);
    }
    let left = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 1, "nothing is written");
}
