//! `ramus doctor`: everything is looked at, and what is missing has a command.

use std::fs;

use super::{folder, ramus, succeed};

#[test]
fn doctor_looks_at_everything_and_names_one_command_for_what_is_missing() {
    let said = succeed(ramus().arg("doctor"));
    assert!(said.contains("Ramus") && said.contains("OpenXR"), "{said}");
    let said = succeed(
        ramus()
            .arg("doctor")
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent"),
    );
    assert!(
        said.contains("Vulkan device") && said.contains("mend it:"),
        "{said}"
    );
    assert!(said.contains("cannot draw here"), "{said}");
    if !said.contains("Vulkan loader") {
        let command = mend(&said, "Vulkan device");
        assert_eq!(command, "unset VK_DRIVER_FILES VK_ICD_FILENAMES");
        assert!(said.contains("VK_DRIVER_FILES=/nonexistent"), "{said}");
    }
}

/// The command under the line of a part, if it is missing.
fn mend<'a>(said: &'a str, part: &str) -> &'a str {
    said.lines()
        .skip_while(|line| !line.contains(part))
        .nth(1)
        .and_then(|line| line.trim().strip_prefix("mend it: "))
        .unwrap_or_else(|| panic!("no command for {part}:\n{said}"))
}

#[test]
fn a_runtime_that_does_not_answer_gets_a_command_and_no_advice() {
    let folder = folder();
    let doctor = |runtime: &str| {
        succeed(
            ramus()
                .arg("doctor")
                .env("HOME", folder.path())
                .env("XDG_CONFIG_HOME", folder.path().join("config"))
                .env("XR_RUNTIME_JSON", runtime),
        )
    };
    let said = doctor("/nonexistent/runtime.json");
    if said.contains("OpenXR loader      the OpenXR loader") {
        assert!(!mend(&said, "OpenXR loader").is_empty(), "{said}");
        println!("skipped: there is no OpenXR loader here");
        return;
    }
    // Whatever runtimes this machine has: the variable is what keeps the loader from them.
    assert_eq!(mend(&said, "OpenXR runtime"), "unset XR_RUNTIME_JSON");
    assert!(
        said.contains("XR_RUNTIME_JSON names /nonexistent/runtime.json"),
        "{said}"
    );
    // A manifest in its place, whose runtime is not there: the runtime's own command.
    for (name, expected) in [
        ("openxr_monado.json", "monado"),
        ("openxr_wivrn.json", "wivrn-dashboard"),
        ("steamxr_linux64.json", "steam://rungameid/250820"),
        ("other.json", "XR_LOADER_DEBUG=all /"),
    ] {
        let manifest = folder.path().join(name);
        let text = r#"{"file_format_version":"1.0.0","runtime":{"library_path":"/nonexistent/library.so"}}"#;
        fs::write(&manifest, text).unwrap();
        let said = doctor(manifest.to_str().unwrap());
        let command = mend(&said, "OpenXR runtime");
        assert!(command.contains(expected), "{name}: {command}");
    }
}

/// The report is the command's result: a disk that does not take it is told, a reader who leaves is not.
#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_told_and_a_closed_one_is_not() {
    let output = ramus()
        .arg("doctor")
        .stdout(
            fs::OpenOptions::new()
                .write(true)
                .open("/dev/full")
                .unwrap(),
        )
        .output()
        .unwrap();
    super::refused(&output, &["standard output does not take the report"]);
    let mut child = ramus()
        .arg("doctor")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(super::text(&output.stderr), "");
}
