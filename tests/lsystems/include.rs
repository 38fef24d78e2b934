//! Grammars of several files.

use ramus::lsystem::Grammar;

use super::text_of;

/// Files of the grammar's own folder are read; others are not.
#[test]
fn includes() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let write = |name: &str, text: &str| {
        let path = inner.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    std::fs::write(folder.path().join("outside.lsys"), "A -> B\n").unwrap();
    write("rules.lsys", "const k = 2\nA(x) -> A(x+k)\n");
    write("wrong.lsys", "\nA(x) -> A(y)\n");
    let main = write("main.lsys", "");
    let read = |text: &str| Grammar::parse(text, &main);
    let grammar = read("include \"rules.lsys\"\naxiom A(k)\n").unwrap();
    assert_eq!(text_of(&grammar, 1), "A(4)");
    std::fs::create_dir(inner.join("folder")).unwrap();
    // A hole of a file: it takes no room on the disk.
    let long = std::fs::File::create(inner.join("long.lsys")).unwrap();
    long.set_len(300 << 20).unwrap();
    write("a.lsys", "include \"b.lsys\"\n");
    write("b.lsys", "include \"a.lsys\"\n");
    for (text, part) in [
        (
            "include \"wrong.lsys\"\naxiom A(1)\n",
            "wrong.lsys:2:11: unknown name `y`",
        ),
        (
            "include \"../outside.lsys\"\naxiom A\n",
            "outside the grammar's folder",
        ),
        (
            "include \"/etc/hostname\"\naxiom A\n",
            "outside the grammar's folder",
        ),
        (
            "include \"missing.lsys\"\naxiom A\n",
            "there is no `missing.lsys`",
        ),
        (
            "include \"folder\"\naxiom A\n",
            "cannot read `folder`: it is no regular file",
        ),
        (
            "include \"long.lsys\"\naxiom A\n",
            "cannot read `long.lsys`: it is longer than",
        ),
        ("include \"main.lsys\"\naxiom A\n", "includes itself"),
        ("include \"a.lsys\"\naxiom A\n", "includes itself"),
        ("include \"rules.lsys\naxiom A\n", "not closed"),
    ] {
        let shown = read(text).expect_err(text).to_string();
        assert!(shown.contains(part), "{text}\n{shown}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("outside.lsys"), inner.join("link.lsys"))
            .unwrap();
        let shown = read("include \"link.lsys\"\naxiom A\n")
            .unwrap_err()
            .to_string();
        assert!(shown.contains("outside the grammar's folder"), "{shown}");
    }
}

/// Opening a pipe waits for its writer, so a test that fails here does not end.
#[cfg(unix)]
#[test]
fn a_pipe_is_not_included() {
    let folder = tempfile::tempdir().unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("pipe.lsys"))
        .status();
    if !made.is_ok_and(|status| status.success()) {
        eprintln!("skipped: mkfifo makes no pipe here");
        return;
    }
    let main = folder.path().join("main.lsys");
    std::fs::write(&main, "").unwrap();
    let error = Grammar::parse("include \"pipe.lsys\"\naxiom A\n", main.to_str().unwrap())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no regular file"), "{error}");
}
