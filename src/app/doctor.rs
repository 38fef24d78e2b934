//! What this machine has for Ramus, and for each thing missing the one command that mends it.

mod runtime;

use runtime::{Fault, Runtimes};

use crate::app::headset;
use crate::app::portrait;
use crate::render::{Gpu, GpuParams, Headless, Multiview, RenderError, probe};
use ramus_xr::openxr::ConnectError;

/// How a part of the machine is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// There and working.
    Good,
    /// Ramus goes on without it, or works around it.
    Lacking,
    /// Ramus cannot draw without it.
    Missing,
}

/// One line of the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What was looked at.
    pub part: &'static str,
    /// How it is.
    pub health: Health,
    /// What was found, in words.
    pub found: String,
    /// The one command that mends it.
    pub mend: Option<String>,
}

impl Finding {
    fn good(part: &'static str, found: impl Into<String>) -> Self {
        Self {
            part,
            health: Health::Good,
            found: found.into(),
            mend: None,
        }
    }

    fn bad(part: &'static str, health: Health, found: impl Into<String>, mend: String) -> Self {
        Self {
            part,
            health,
            found: found.into(),
            mend: Some(mend),
        }
    }
}

/// Systems whose package commands are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum System {
    Bookworm,
    Debian,
    Fedora,
    Arch,
    Suse,
    Other,
}

/// What can be installed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Package {
    VulkanLoader,
    Driver,
    Validation,
    OpenXrLoader,
    OpenXrRuntime,
}

/// Reads the system from the text of `/etc/os-release`.
fn system(os_release: &str) -> System {
    let value = |key: &str| {
        os_release
            .lines()
            .filter_map(|line| line.split_once('='))
            .find(|(name, _)| *name == key)
            .map(|(_, value)| value.trim_matches('"').to_owned())
            .unwrap_or_default()
    };
    let family = format!("{} {}", value("ID"), value("ID_LIKE"));
    let is = |name: &str| family.split_whitespace().any(|word| word == name);
    if is("debian") && value("VERSION_CODENAME") == "bookworm" {
        System::Bookworm
    } else if is("debian") || is("ubuntu") {
        System::Debian
    } else if is("fedora") || is("rhel") {
        System::Fedora
    } else if is("arch") {
        System::Arch
    } else if family.contains("suse") {
        System::Suse
    } else {
        System::Other
    }
}

/// A line that mends something: it runs as it stands when it is pasted into a shell in any folder.
fn line(command: &str, remark: &str) -> String {
    match (command, remark) {
        (command, "") => command.to_owned(),
        ("", remark) => format!("# {remark}"),
        (command, remark) => format!("{command} # {remark}"),
    }
}

/// Whether a program of this name is on the path.
fn on_path(name: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(name).is_file()))
}

/// A word as a shell takes it.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// How this user becomes the one who may install.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Root {
    /// Is it already.
    Already,
    /// By `sudo`.
    Sudo,
    /// By `su`, which every system has.
    Su,
}

impl Root {
    fn look() -> Self {
        use std::os::unix::fs::MetadataExt as _;
        if std::fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0) {
            Self::Already
        } else if on_path("sudo") {
            Self::Sudo
        } else {
            Self::Su
        }
    }

    /// The command as root runs it.
    fn runs(self, command: &str) -> String {
        let simple = !command.contains("&&") && !command.contains('|');
        match self {
            Self::Already => command.to_owned(),
            Self::Sudo if simple => format!("sudo {command}"),
            Self::Sudo => format!("sudo sh -c {}", quoted(command)),
            Self::Su => format!("su -c {}", quoted(command)),
        }
    }
}

/// The WiVRn streaming runtime from Flathub, where the system has no runtime of its own: `flatpak` is there by then.
const WIVRN: &str = "flatpak remote-add --user --if-not-exists flathub https://dl.flathub.org/repo/flathub.flatpakrepo \
     && flatpak install --user -y flathub io.github.wivrn.wivrn && flatpak run io.github.wivrn.wivrn";

/// Mesa 25 for Debian 12. The source is added only where no other one brings the backports: apt refuses to read one
/// source with two keys.
const BACKPORTS: &str = "grep -rqs bookworm-backports /etc/apt/sources.list /etc/apt/sources.list.d \
     || echo \"deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm-backports main\" \
     > /etc/apt/sources.list.d/bookworm-backports.list; \
     apt-get update && apt-get install -y -t bookworm-backports mesa-vulkan-drivers";

/// The line that installs a package, from nothing.
fn install(package: Package, system: System, root: Root) -> String {
    use Package as P;
    use System as S;
    let name = match (system, package) {
        (S::Bookworm, P::Driver) => return root.runs(BACKPORTS),
        (S::Debian, P::OpenXrRuntime) => "libopenxr1-monado monado-service",
        (S::Other, P::OpenXrRuntime) => {
            return line(
                "",
                "install an OpenXR runtime: Monado (https://monado.dev) or WiVRn (https://github.com/WiVRn/WiVRn)",
            );
        }
        (_, P::OpenXrRuntime) => "flatpak",
        (S::Bookworm | S::Debian | S::Suse, P::VulkanLoader) => "libvulkan1",
        (S::Debian | S::Fedora, P::Driver) => "mesa-vulkan-drivers",
        (S::Bookworm | S::Debian | S::Suse, P::Validation) => "vulkan-validationlayers",
        (S::Bookworm | S::Debian, P::OpenXrLoader) => "libopenxr-loader1",
        (S::Fedora, P::VulkanLoader) => "vulkan-loader",
        (S::Fedora | S::Arch, P::Validation) => "vulkan-validation-layers",
        (S::Fedora, P::OpenXrLoader) => "openxr-libs",
        (S::Arch, P::VulkanLoader) => "vulkan-icd-loader",
        (S::Arch, P::Driver) => "vulkan-swrast",
        (S::Arch, P::OpenXrLoader) => "openxr",
        (S::Suse, P::Driver) => "libvulkan_lvp",
        (S::Suse, P::OpenXrLoader) => "libopenxr_loader1",
        (S::Other, P::VulkanLoader) => {
            return line("", "install the Vulkan loader (libvulkan.so.1)");
        }
        (S::Other, P::Driver) => {
            return line(
                "",
                "install the Vulkan driver of your graphics card, or Mesa 25's lavapipe",
            );
        }
        (S::Other, P::Validation) => {
            return line("", "install the Khronos Vulkan validation layer");
        }
        (S::Other, P::OpenXrLoader) => {
            return line("", "install the OpenXR loader (libopenxr_loader.so.1)");
        }
    };
    let tool = match system {
        S::Bookworm | S::Debian | S::Other => "apt-get update && apt-get install -y",
        S::Fedora => "dnf install -y",
        S::Arch => "pacman -S --needed --noconfirm",
        S::Suse => "zypper --non-interactive install",
    };
    let installed = root.runs(&format!("{tool} {name}"));
    match (system, package) {
        (S::Debian, P::OpenXrRuntime) => {
            format!("{installed} && systemctl --user start monado.socket")
        }
        (_, P::OpenXrRuntime) => format!("{installed} && {WIVRN}"),
        _ => installed,
    }
}

/// Whom the commands are for.
#[derive(Clone, Debug)]
struct Machine {
    system: System,
    root: Root,
    /// How this program is started from any folder, quoted.
    program: String,
}

impl Machine {
    fn look() -> Self {
        let os_release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
        let program = std::env::current_exe().unwrap_or_else(|_| "ramus".into());
        Self {
            system: system(&os_release),
            root: Root::look(),
            program: quoted(&program.display().to_string()),
        }
    }

    fn install(&self, package: Package) -> String {
        install(package, self.system, self.root)
    }
}

/// Looks at the machine.
#[must_use]
pub fn examine() -> Vec<Finding> {
    let machine = Machine::look();
    let mut findings = vec![Finding::good("Ramus", env!("CARGO_PKG_VERSION"))];
    findings.extend(vulkan(&machine));
    findings.extend(openxr(&machine));
    findings
}

/// Variables by which the Vulkan loader is kept from the drivers that are installed.
const DRIVER_VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Why the loader finds no device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct NoDevice {
    /// The variables of [`DRIVER_VARIABLES`] that are set, with their values.
    variables: Vec<(&'static str, String)>,
    /// A driver's manifest lies where the loader looks.
    driver: bool,
}

impl NoDevice {
    fn look() -> Self {
        let value = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
        let variables = DRIVER_VARIABLES
            .into_iter()
            .filter_map(|name| Some((name, value(name)?)))
            .collect();
        let driver = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"]
            .iter()
            .filter_map(|folder| std::fs::read_dir(folder).ok())
            .flatten()
            .flatten()
            .any(|file| {
                file.path()
                    .extension()
                    .is_some_and(|ending| ending == "json")
            });
        Self { variables, driver }
    }

    /// What to add to the finding, and the line that mends it.
    fn mend(&self, machine: &Machine) -> (String, String) {
        if self.variables.is_empty() {
            return match self.driver {
                false => (String::new(), machine.install(Package::Driver)),
                true => (
                    "; a driver is installed and does not answer".to_owned(),
                    line(
                        &format!(
                            "VK_LOADER_DEBUG=error,warn,driver {} doctor",
                            machine.program
                        ),
                        "says why",
                    ),
                ),
            };
        }
        let said: Vec<String> = self
            .variables
            .iter()
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        let names: Vec<&str> = self.variables.iter().map(|(name, _)| *name).collect();
        (
            format!(
                "; {} keeps the loader from the drivers that are installed",
                said.join(" and ")
            ),
            format!("unset {}", names.join(" ")),
        )
    }
}

fn vulkan(machine: &Machine) -> Vec<Finding> {
    let gpu = match portrait::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            let found = first_clause(&error.to_string());
            let (part, found, mend) = match error.downcast_ref() {
                Some(RenderError::NoLoader(_)) => {
                    let mend = machine.install(Package::VulkanLoader);
                    ("Vulkan loader", found, mend)
                }
                Some(RenderError::NoDevice(_)) => {
                    let (why, mend) = NoDevice::look().mend(machine);
                    ("Vulkan device", found + &why, mend)
                }
                _ => {
                    let mend = machine.install(Package::Driver);
                    ("Vulkan device", error.to_string(), mend)
                }
            };
            return vec![Finding::bad(part, Health::Missing, found, mend)];
        }
    };
    let info = gpu.info();
    let kind = if info.software {
        ", drawn by the processor"
    } else {
        ""
    };
    let mut findings = vec![
        Finding::good(
            "Vulkan device",
            format!("{} (Vulkan {}{kind})", info.device, info.version),
        ),
        Finding::good("driver", info.driver.clone()),
    ];
    findings.push(match probe::multiview(&gpu) {
        Ok(Multiview::Works) => Finding::good("multiview", "works: both eyes in one pass"),
        Ok(Multiview::Broken) => Finding::bad(
            "multiview",
            Health::Lacking,
            "broken in this driver: each eye is drawn in a pass of its own, which is slower",
            machine.install(Package::Driver),
        ),
        Err(error) => Finding::bad(
            "multiview",
            Health::Missing,
            error.to_string(),
            machine.install(Package::Driver),
        ),
    });
    findings.push(validation(machine));
    findings
}

/// Only developers need the validation layer, but they should know.
fn validation(machine: &Machine) -> Finding {
    let checked = Gpu::new(
        &Headless::default(),
        &GpuParams {
            validation: true,
            sync_validation: false,
        },
    );
    if checked.is_ok_and(|gpu| gpu.info().validation) {
        Finding::good("validation layer", "installed (used by the tests)")
    } else {
        Finding::bad(
            "validation layer",
            Health::Lacking,
            "not installed (only the tests use it)",
            machine.install(Package::Validation),
        )
    }
}

fn openxr(machine: &Machine) -> Vec<Finding> {
    const LOADER: &str = "OpenXR loader";
    const RUNTIME: &str = "OpenXR runtime";
    const HEADSET: &str = "headset";
    let loader = || Finding::good(LOADER, "installed");
    let runtimes = Runtimes::look();
    let mend = |fault| runtimes.mend(fault, machine);
    match headset::connect() {
        Ok(found) => {
            let extent = found.extent();
            vec![
                loader(),
                Finding::good(RUNTIME, "answers"),
                Finding::good(
                    HEADSET,
                    format!(
                        "{}, {} × {} pixels an eye",
                        found.describe(),
                        extent.width,
                        extent.height
                    ),
                ),
            ]
        }
        Err(error) => {
            let found = first_clause(&error.to_string());
            let lacks = |part, found, mend| Finding::bad(part, Health::Lacking, found, mend);
            match &error {
                ConnectError::NoLoader => {
                    vec![lacks(LOADER, found, machine.install(Package::OpenXrLoader))]
                }
                ConnectError::NoHeadset(name) | ConnectError::NoStereo(name) => vec![
                    loader(),
                    Finding::good(RUNTIME, "answers"),
                    lacks(
                        HEADSET,
                        format!("{found}; connect it and switch it on, or"),
                        mend(Fault::NoHeadset(name)),
                    ),
                ],
                // Starting it again gives it nothing; another one has it.
                ConnectError::NoVulkan(_) => vec![
                    loader(),
                    lacks(RUNTIME, found, machine.install(Package::OpenXrRuntime)),
                ],
                _ => {
                    let found = match runtimes.misled() {
                        Some(path) => {
                            format!("{found}: XR_RUNTIME_JSON names {path}, which is not there")
                        }
                        None => found,
                    };
                    vec![loader(), lacks(RUNTIME, found, mend(Fault::Silent))]
                }
            }
        }
    }
}

/// What happened, without the advice that an error's sentence ends with: the advice has a line of its own here.
fn first_clause(text: &str) -> String {
    text.split([';', ':']).next().unwrap_or(text).to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        clippy::unwrap_used,
        reason = "the table says it"
    )]
    use super::*;

    #[test]
    fn systems_are_known_by_their_os_release() {
        for (text, expected) in [
            ("ID=debian\nVERSION_CODENAME=bookworm\n", System::Bookworm),
            ("ID=debian\nVERSION_CODENAME=trixie\n", System::Debian),
            (
                "ID=ubuntu\nID_LIKE=debian\nVERSION_CODENAME=noble\n",
                System::Debian,
            ),
            ("ID=fedora\n", System::Fedora),
            ("ID=manjaro\nID_LIKE=arch\n", System::Arch),
            (
                "ID=\"opensuse-tumbleweed\"\nID_LIKE=\"opensuse suse\"\n",
                System::Suse,
            ),
            ("", System::Other),
            ("garbage\u{0}===\n=", System::Other),
        ] {
            assert_eq!(system(text), expected, "{text:?}");
        }
    }

    /// A machine of each system, for each way to become root.
    pub(super) fn machines() -> Vec<Machine> {
        use System as S;
        [
            S::Bookworm,
            S::Debian,
            S::Fedora,
            S::Arch,
            S::Suse,
            S::Other,
        ]
        .into_iter()
        .flat_map(|system| {
            [Root::Already, Root::Sudo, Root::Su].map(|root| Machine {
                system,
                root,
                program: "'/opt/my tools/ramus'".to_owned(),
            })
        })
        .collect()
    }

    /// Fails unless a shell would take the line in any folder and on a bare system.
    pub(super) fn runs_as_it_is(line: &str, machine: &Machine) {
        let shell = std::process::Command::new("bash")
            .args(["-n", "-c", line])
            .output()
            .unwrap();
        assert!(shell.status.success(), "{machine:?}: {line}");
        assert!(!line.contains('\n') && !line.is_empty(), "{line}");
        let command = line.split(" # ").next().unwrap();
        // Everything that is called by a path is called by a whole one.
        let quoted = |part: &&str| part.starts_with('/');
        let parts: Vec<&str> = command.split('\'').collect();
        let bare: String = parts
            .iter()
            .map(|part| if quoted(part) { "/quoted" } else { part })
            .collect();
        for word in bare.split([' ', '=', '"']) {
            let relative = word.contains('/') && !word.starts_with('/') && !word.contains("://");
            assert!(!relative, "{word} in {line}");
        }
        if command.starts_with('#') {
            assert_eq!(machine.system, System::Other, "no command: {line}");
            return;
        }
        let first = bare
            .split_whitespace()
            .find(|word| !word.contains('='))
            .unwrap();
        let everywhere = [
            "unset",
            "grep",
            "su",
            "sudo",
            "systemctl",
            "pkill",
            "/quoted",
        ];
        let tools = ["apt-get", "dnf", "pacman", "zypper"];
        // Of the runtime that is there.
        let runtimes = ["monado-service", "wivrn-dashboard", "flatpak", "steam"];
        let known = [&everywhere[..], &tools, &runtimes].concat();
        assert!(known.contains(&first), "{first} in {line}");
    }

    #[test]
    fn every_package_has_one_line_that_runs_as_it_is() {
        use Package as P;
        for machine in machines() {
            for package in [
                P::VulkanLoader,
                P::Driver,
                P::Validation,
                P::OpenXrLoader,
                P::OpenXrRuntime,
            ] {
                let line = machine.install(package);
                runs_as_it_is(&line, &machine);
                // One word for the other shell, so that all of it runs as root.
                if machine.root == Root::Su && machine.system != System::Other {
                    assert!(line.starts_with("su -c '"), "{line}");
                }
                // What is called is installed by the same line.
                if let Some((before, _)) = line.split_once("flatpak remote-add") {
                    assert!(before.contains(" flatpak"), "{line}");
                    assert!(line.contains("https://dl.flathub.org/"), "{line}");
                }
                assert!(
                    machine.root != Root::Already || !line.contains("sudo"),
                    "{line}"
                );
            }
        }
    }

    #[test]
    fn no_device_has_its_cause_named() {
        let set = |variables: &[&'static str], driver| NoDevice {
            variables: variables
                .iter()
                .map(|name| (*name, "/nonexistent".to_owned()))
                .collect(),
            driver,
        };
        for machine in machines() {
            for (cause, found, mend) in [
                (set(&[], true), "does not answer", "VK_LOADER_DEBUG="),
                (
                    set(&["VK_DRIVER_FILES"], true),
                    "VK_DRIVER_FILES=/nonexistent",
                    "unset VK_DRIVER_FILES",
                ),
                (
                    set(&DRIVER_VARIABLES, false),
                    "VK_ICD_FILENAMES=/nonexistent",
                    "unset VK_DRIVER_FILES VK_ICD_FILENAMES",
                ),
            ] {
                let (why, line) = cause.mend(&machine);
                assert!(
                    why.contains(found) && line.starts_with(mend),
                    "{why}: {line}"
                );
                runs_as_it_is(&line, &machine);
            }
            let (why, line) = set(&[], false).mend(&machine);
            assert_eq!(
                (why, line),
                (String::new(), machine.install(Package::Driver))
            );
        }
    }

    #[test]
    fn everything_that_is_not_well_says_how_to_mend_it() {
        for finding in examine() {
            assert_eq!(
                finding.health == Health::Good,
                finding.mend.is_none(),
                "{finding:?}"
            );
            assert!(!finding.found.is_empty());
        }
    }
}
