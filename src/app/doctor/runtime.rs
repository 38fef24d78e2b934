//! Which OpenXR runtimes this machine has, and the one command that makes one of them answer.
//!
//! Looking ([`Runtimes::look`]) is apart from deciding ([`Runtimes::mend`]), so that every case is a line of a table.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::{Machine, Package, line, quoted};

/// Where the loader looks for the active runtime, after `XR_RUNTIME_JSON` and the user's own folder.
const ACTIVE: [&str; 3] = [
    "/etc/xdg/openxr/1/active_runtime.json",
    "/usr/local/etc/openxr/1/active_runtime.json",
    "/etc/openxr/1/active_runtime.json",
];

/// Where runtimes put their manifests; in the home folder where the path is relative.
const FOLDERS: [&str; 5] = [
    "/usr/share/openxr/1",
    "/usr/local/share/openxr/1",
    ".local/share/openxr/1",
    ".steam/steam/steamapps/common/SteamVR",
    ".local/share/Steam/steamapps/common/SteamVR",
];

/// Monado's socket for systemd: with it the service starts by itself when a program asks.
const MONADO_SOCKET: &str = "/usr/lib/systemd/user/monado.socket";

/// Runtimes whose own commands are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Monado,
    Wivrn,
    /// The same in Flathub's box, which has no program of its own on the path.
    WivrnFlatpak,
    SteamVr,
    Other,
}

impl Kind {
    /// The runtime that a name, a path or a manifest's text speaks of.
    fn of(text: &str) -> Self {
        let text = text.to_lowercase();
        let has = |word: &str| text.contains(word);
        // WiVRn is built on Monado and may name it too.
        if has("wivrn") && (has("flatpak") || has("io.github.wivrn")) {
            Self::WivrnFlatpak
        } else if has("wivrn") {
            Self::Wivrn
        } else if has("monado") {
            Self::Monado
        } else if has("steamxr") || has("steamvr") || has("vrclient") {
            Self::SteamVr
        } else {
            Self::Other
        }
    }
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault<'a> {
    /// No runtime answers.
    Silent,
    /// The runtime of this name answers and sees no headset.
    NoHeadset(&'a str),
}

/// A manifest that is there, with the runtime that it belongs to.
type Manifest = (PathBuf, Kind);

/// The runtimes of a machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Runtimes {
    /// `XR_RUNTIME_JSON` names this file, which is not there.
    misled: Option<PathBuf>,
    /// The manifest that the loader takes.
    active: Option<Manifest>,
    /// Manifests that lie in the usual places.
    installed: Vec<Manifest>,
    /// Monado's service is started by systemd.
    socket: bool,
}

impl Runtimes {
    /// Looks at this machine.
    pub(super) fn look() -> Self {
        let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty());
        let home = variable("HOME").map(PathBuf::from).unwrap_or_default();
        let config =
            variable("XDG_CONFIG_HOME").map_or_else(|| home.join(".config"), PathBuf::from);
        let named = variable("XR_RUNTIME_JSON").map(PathBuf::from);
        let misled = named.clone().filter(|path| !path.is_file());
        let places = std::iter::once(config.join("openxr/1/active_runtime.json"))
            .chain(ACTIVE.iter().map(PathBuf::from));
        let active = named
            .into_iter()
            .chain(places)
            .find(|path| path.is_file())
            .map(described);
        let mut installed: Vec<Manifest> = FOLDERS
            .iter()
            .flat_map(|folder| manifests(&home.join(folder)))
            .collect();
        installed.sort_by(|a, b| a.0.cmp(&b.0));
        Self {
            misled,
            active,
            installed,
            socket: Path::new(MONADO_SOCKET).exists(),
        }
    }

    /// The file that `XR_RUNTIME_JSON` names although it is not there.
    pub(super) fn misled(&self) -> Option<String> {
        self.misled.as_ref().map(|path| path.display().to_string())
    }

    /// The one line that mends a fault.
    pub(super) fn mend(&self, fault: Fault<'_>, machine: &Machine) -> String {
        match (fault, &self.active, self.installed.first()) {
            (Fault::NoHeadset(runtime), ..) => self.restart(Kind::of(runtime), machine),
            // Whatever else there is, the loader looks nowhere else.
            (Fault::Silent, ..) if self.misled.is_some() => "unset XR_RUNTIME_JSON".to_owned(),
            (Fault::Silent, Some((path, kind)), _) => self.start(path, *kind, machine),
            (Fault::Silent, None, Some((path, _))) => {
                format!("XR_RUNTIME_JSON={} {}", shown(path), machine.program)
            }
            (Fault::Silent, None, None) => machine.install(Package::OpenXrRuntime),
        }
    }

    /// Starts the runtime that is active and does not answer.
    fn start(&self, manifest: &Path, kind: Kind, machine: &Machine) -> String {
        match kind {
            Kind::Monado if self.socket => "systemctl --user start monado.socket".to_owned(),
            Kind::Monado => "monado-service &".to_owned(),
            Kind::Wivrn => "wivrn-dashboard".to_owned(),
            Kind::WivrnFlatpak => "flatpak run io.github.wivrn.wivrn".to_owned(),
            Kind::SteamVr => "steam steam://rungameid/250820".to_owned(),
            Kind::Other => line(
                &format!("XR_LOADER_DEBUG=all {} doctor", machine.program),
                &format!(
                    "says why the runtime of {} does not answer",
                    manifest.display()
                ),
            ),
        }
    }

    /// Makes a runtime that sees no headset look again, or bring one of its own.
    fn restart(&self, kind: Kind, machine: &Machine) -> String {
        let boxed = self
            .active
            .as_ref()
            .is_some_and(|(_, kind)| *kind == Kind::WivrnFlatpak);
        let simulated = "brings Monado's own simulated headset";
        let lead = "leads through connecting the headset";
        match kind {
            Kind::Monado if self.socket => line(
                "systemctl --user stop monado.service; SIMULATED_ENABLE=1 monado-service",
                simulated,
            ),
            Kind::Monado => line(
                "pkill -x monado-service; SIMULATED_ENABLE=1 monado-service",
                simulated,
            ),
            Kind::Wivrn if !boxed => line("wivrn-dashboard", lead),
            Kind::Wivrn | Kind::WivrnFlatpak => line("flatpak run io.github.wivrn.wivrn", lead),
            Kind::SteamVr => "steam steam://rungameid/250820".to_owned(),
            Kind::Other => line(
                &format!("{} --headset simulated", machine.program),
                "until the runtime's own settings show the headset",
            ),
        }
    }
}

/// All manifests in a folder: files of JSON that name a runtime's library.
fn manifests(folder: &Path) -> Vec<Manifest> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension() == Some(OsStr::new("json")))
        .filter(|path| head(path).contains("library_path"))
        .map(described)
        .collect()
}

/// A manifest with what it belongs to: told by its text, else by the name of the file that it leads to.
fn described(path: PathBuf) -> Manifest {
    let real = path.canonicalize().unwrap_or_else(|_| path.clone());
    let kind = Kind::of(&format!("{} {}", head(&path), real.display()));
    (path, kind)
}

/// The beginning of a file: manifests are short, and what else has such a name need not be read.
fn head(path: &Path) -> String {
    use std::io::Read as _;
    const MOST: u64 = 64 << 10;
    let mut bytes = Vec::new();
    if let Ok(file) = std::fs::File::open(path) {
        // What cannot be read says nothing.
        let _ = file.take(MOST).read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A path as a shell takes it.
fn shown(path: &Path) -> String {
    quoted(&path.display().to_string())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        clippy::unwrap_used,
        reason = "the tables say it"
    )]
    use super::super::tests::{machines, runs_as_it_is};
    use super::super::{Root, System};
    use super::*;

    fn manifest(path: &str) -> Manifest {
        (PathBuf::from(path), Kind::of(path))
    }

    #[test]
    fn each_fault_has_the_command_that_mends_it() {
        let monado = manifest("/usr/share/openxr/1/openxr_monado.json");
        let wivrn = manifest("/usr/share/openxr/1/openxr_wivrn.json");
        let steam =
            manifest("/home/a b/.steam/steam/steamapps/common/SteamVR/steamxr_linux64.json");
        let strange = manifest("/opt/strange.json");
        let boxed = manifest("/var/lib/flatpak/app/io.github.wivrn.wivrn/openxr_wivrn.json");
        let none = Runtimes::default();
        let active = |manifest: &Manifest| Runtimes {
            active: Some(manifest.clone()),
            ..Runtimes::default()
        };
        let installed = |manifest: &Manifest| Runtimes {
            installed: vec![manifest.clone()],
            ..Runtimes::default()
        };
        let with_socket = |runtimes: Runtimes| Runtimes {
            socket: true,
            ..runtimes
        };
        let misled = |runtimes: Runtimes| Runtimes {
            misled: Some(PathBuf::from("/nonexistent")),
            ..runtimes
        };
        let table = [
            // Nothing there: installed and started.
            (
                none.clone(),
                Fault::Silent,
                "apt-get install -y libopenxr1-monado monado-service",
            ),
            (misled(none.clone()), Fault::Silent, "unset XR_RUNTIME_JSON"),
            // There and not active: named.
            (
                installed(&monado),
                Fault::Silent,
                "XR_RUNTIME_JSON=/usr/share/openxr/1/openxr_monado.json '/opt/my tools/ramus'",
            ),
            (
                misled(installed(&wivrn)),
                Fault::Silent,
                "unset XR_RUNTIME_JSON",
            ),
            (
                installed(&steam),
                Fault::Silent,
                "XR_RUNTIME_JSON='/home/a b/.steam/steam/steamapps/common/SteamVR/steamxr_linux64.json' '/opt/my tools/ramus'",
            ),
            // Active and silent: started.
            (active(&monado), Fault::Silent, "monado-service &"),
            (
                with_socket(active(&monado)),
                Fault::Silent,
                "systemctl --user start monado.socket",
            ),
            (active(&wivrn), Fault::Silent, "wivrn-dashboard"),
            (
                active(&steam),
                Fault::Silent,
                "steam steam://rungameid/250820",
            ),
            (
                active(&strange),
                Fault::Silent,
                "XR_LOADER_DEBUG=all '/opt/my tools/ramus' doctor # says why",
            ),
            // The variable is what keeps the active one from being found.
            (
                misled(active(&monado)),
                Fault::Silent,
                "unset XR_RUNTIME_JSON",
            ),
            // Answering without a headset: by the name that the runtime gives itself.
            (
                active(&monado),
                Fault::NoHeadset("Monado(XRT) by Collabora et al '25.0.0'"),
                "pkill -x monado-service; SIMULATED_ENABLE=1 monado-service",
            ),
            (
                with_socket(none.clone()),
                Fault::NoHeadset("Monado(XRT)"),
                "systemctl --user stop monado.service; SIMULATED_ENABLE=1 monado-service",
            ),
            (none.clone(), Fault::NoHeadset("WiVRn"), "wivrn-dashboard"),
            (
                active(&boxed),
                Fault::NoHeadset("WiVRn"),
                "flatpak run io.github.wivrn.wivrn",
            ),
            (
                active(&boxed),
                Fault::Silent,
                "flatpak run io.github.wivrn.wivrn",
            ),
            (
                none.clone(),
                Fault::NoHeadset("SteamVR/OpenXR"),
                "steam steam://rungameid/250820",
            ),
            (
                none,
                Fault::NoHeadset("Another 1.0"),
                "'/opt/my tools/ramus' --headset simulated # until",
            ),
        ];
        for (runtimes, fault, expected) in table {
            for machine in machines() {
                let said = runtimes.mend(fault, &machine);
                let debian = machine.system == System::Debian && machine.root != Root::Su;
                assert!(
                    said.contains(expected) || (expected.contains("apt-get") && !debian),
                    "{runtimes:?} {fault:?}: {said}"
                );
                runs_as_it_is(&said, &machine);
            }
        }
    }

    #[test]
    fn manifests_are_found_by_what_is_in_them() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let one = write(
            "one.json",
            r#"{"runtime": {"library_path": "libopenxr_wivrn.so"}}"#,
        );
        write("layer.json", r#"{"api_layer": {}}"#);
        write("notes.txt", "library_path");
        assert_eq!(manifests(folder.path()), [(one, Kind::Wivrn)]);
        assert_eq!(manifests(&folder.path().join("none")), []);
        // A link by another name is known by where it leads.
        #[cfg(unix)]
        {
            let real = write("openxr_monado.json", "{}");
            let link = folder.path().join("active_runtime.json");
            std::os::unix::fs::symlink(real, &link).unwrap();
            assert_eq!(described(link.clone()), (link, Kind::Monado));
        }
    }
}
