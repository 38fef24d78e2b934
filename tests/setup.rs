//! What the set-up scripts read out of a machine's apt sources: any mirror, both formats.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::{fs, path::Path, process::Command};

const DEB822: &str = "\
Types: deb deb-src
# a remark
URIs: https://mirror.example/debian
Suites: bookworm bookworm-updates
Components: main contrib
Signed-By: /usr/share/keyrings/example.gpg

Types: deb
URIs: https://mirror.example/debian-security
Suites: bookworm-security
Components: main
";

const INLINE_KEY: &str = "\
Types: deb-src
URIs: https://sources.example/debian
Suites: bookworm
Components: main

Enabled: no
Types: deb
URIs: https://disabled.example/debian
Suites: bookworm
Components: main

Types: deb
URIs: http://10.0.0.1:3142/debian
Suites: bookworm
Components: main
Signed-By:
 -----BEGIN PGP PUBLIC KEY BLOCK-----
 .
 abc
 -----END PGP PUBLIC KEY BLOCK-----
";

const ONE_LINE: &str = "\
# deb http://commented.example/debian bookworm main
deb-src http://sources.example/debian bookworm main
deb [ arch=amd64 signed-by=/etc/apt/keyrings/a.gpg ] http://list.example/debian/ bookworm main non-free
deb http://list.example/debian bookworm-updates main
";

/// Runs a function of `scripts/apt.sh` against an apt folder with this one source file.
fn apt(file: &str, text: &str, call: &str) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sources.list.d")).unwrap();
    fs::write(folder.path().join(file), text).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/apt.sh");
    let output = Command::new("bash")
        .args([
            "-euo",
            "pipefail",
            "-c",
            &format!(". '{}'; {call}", script.display()),
        ])
        .env("RAMUS_APT_FOLDER", folder.path())
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{call}");
    (
        output.status.success(),
        String::from_utf8(output.stdout).unwrap(),
    )
}

#[test]
fn addresses_and_keys_come_from_the_sources() {
    let cases: &[(&str, &str, &str, &str)] = &[
        (
            "sources.list.d/a.sources",
            DEB822,
            "https://mirror.example/debian\n",
            "/usr/share/keyrings/example.gpg\n",
        ),
        (
            "sources.list.d/a.sources",
            INLINE_KEY,
            "http://10.0.0.1:3142/debian\n",
            "",
        ),
        (
            "sources.list",
            ONE_LINE,
            "http://list.example/debian/\n",
            "/etc/apt/keyrings/a.gpg\n",
        ),
        (
            "sources.list.d/b.list",
            "deb http://plain.example/debian bookworm main\n",
            "http://plain.example/debian\n",
            "",
        ),
    ];
    for (file, text, address, key) in cases {
        assert_eq!(
            apt(file, text, "apt_address_for bookworm"),
            (true, (*address).to_owned()),
            "{text}"
        );
        assert_eq!(
            apt(file, text, "apt_key_for bookworm"),
            (true, (*key).to_owned()),
            "{text}"
        );
    }
}

#[test]
fn a_derived_source_keeps_mirror_key_and_options() {
    let derived = |file, text| apt(file, text, "apt_source_for bookworm bookworm-backports");
    assert_eq!(
        derived("sources.list.d/a.sources", DEB822),
        (
            true,
            "sources\nTypes: deb\nURIs: https://mirror.example/debian\nSuites: bookworm-backports\n\
             Components: main contrib\nSigned-By: /usr/share/keyrings/example.gpg\n"
                .to_owned()
        )
    );
    let (found, text) = derived("sources.list.d/a.sources", INLINE_KEY);
    assert!(
        found && text.contains("10.0.0.1") && text.contains("\n .\n abc\n"),
        "{text}"
    );
    assert!(!text.contains("disabled"), "{text}");
    assert_eq!(
        derived("sources.list", ONE_LINE),
        (
            true,
            "list\ndeb [ arch=amd64 signed-by=/etc/apt/keyrings/a.gpg ] http://list.example/debian/ \
             bookworm-backports main non-free\n"
                .to_owned()
        )
    );
}

#[test]
fn a_machine_without_the_suite_is_noticed() {
    let (found, text) = apt(
        "sources.list",
        "deb http://x.example/ubuntu noble main\n",
        "apt_source_for bookworm x",
    );
    assert!(!found && text.is_empty(), "{text}");
}
