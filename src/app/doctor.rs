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

/// The command that installs a package.
fn install(package: Package, system: System) -> String {
    use Package as P;
    use System as S;
    let (tool, name) = match (system, package) {
        (S::Bookworm, P::Driver) => {
            return "scripts/setup.sh run  (adds Debian's backports and installs Mesa 25 from them)"
                .to_owned();
        }
        (S::Debian, P::OpenXrRuntime) => (
            "sudo apt-get install",
            "libopenxr1-monado monado-service && systemctl --user start monado.socket",
        ),
        // Debian 12 and others have no runtime of their own; this one runs everywhere.
        (_, P::OpenXrRuntime) => ("flatpak install", "flathub io.github.wivrn.wivrn"),
        (S::Bookworm | S::Debian, P::VulkanLoader) => ("sudo apt-get install", "libvulkan1"),
        (S::Debian, P::Driver) => ("sudo apt-get install", "mesa-vulkan-drivers"),
        (S::Bookworm | S::Debian, P::Validation) => {
            ("sudo apt-get install", "vulkan-validationlayers")
        }
        (S::Bookworm | S::Debian, P::OpenXrLoader) => ("sudo apt-get install", "libopenxr-loader1"),
        (S::Fedora, P::VulkanLoader) => ("sudo dnf install", "vulkan-loader"),
        (S::Fedora, P::Driver) => ("sudo dnf install", "mesa-vulkan-drivers"),
        (S::Fedora, P::Validation) => ("sudo dnf install", "vulkan-validation-layers"),
        (S::Fedora, P::OpenXrLoader) => ("sudo dnf install", "openxr-libs"),
        (S::Arch, P::VulkanLoader) => ("sudo pacman -S", "vulkan-icd-loader"),
        (S::Arch, P::Driver) => ("sudo pacman -S", "vulkan-swrast"),
        (S::Arch, P::Validation) => ("sudo pacman -S", "vulkan-validation-layers"),
        (S::Arch, P::OpenXrLoader) => ("sudo pacman -S", "openxr"),
        (S::Suse, P::VulkanLoader) => ("sudo zypper install", "libvulkan1"),
        (S::Suse, P::Driver) => ("sudo zypper install", "libvulkan_lvp"),
        (S::Suse, P::Validation) => ("sudo zypper install", "vulkan-validationlayers"),
        (S::Suse, P::OpenXrLoader) => ("sudo zypper install", "libopenxr_loader1"),
        (S::Other, P::VulkanLoader) => ("install", "the Vulkan loader (libvulkan.so.1)"),
        (S::Other, P::Driver) => (
            "install",
            "the Vulkan driver of your graphics card, or Mesa 25's lavapipe",
        ),
        (S::Other, P::Validation) => ("install", "the Khronos Vulkan validation layer"),
        (S::Other, P::OpenXrLoader) => ("install", "the OpenXR loader (libopenxr_loader.so.1)"),
    };
    format!("{tool} {name}")
}

/// Looks at the machine.
#[must_use]
pub fn examine() -> Vec<Finding> {
    let os_release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    let system = system(&os_release);
    let mut findings = vec![Finding::good("Ramus", env!("CARGO_PKG_VERSION"))];
    findings.extend(vulkan(system));
    findings.extend(openxr(system));
    findings
}

fn vulkan(system: System) -> Vec<Finding> {
    let gpu = match portrait::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            let (part, package) = match error.downcast_ref() {
                Some(RenderError::NoLoader(_)) => ("Vulkan loader", Package::VulkanLoader),
                _ => ("Vulkan device", Package::Driver),
            };
            return vec![Finding::bad(
                part,
                Health::Missing,
                error.to_string(),
                install(package, system),
            )];
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
            install(Package::Driver, system),
        ),
        Err(error) => Finding::bad(
            "multiview",
            Health::Missing,
            error.to_string(),
            install(Package::Driver, system),
        ),
    });
    findings.push(validation(system));
    findings
}

/// Only developers need the validation layer, but they should know.
fn validation(system: System) -> Finding {
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
            install(Package::Validation, system),
        )
    }
}

fn openxr(system: System) -> Vec<Finding> {
    const LOADER: &str = "OpenXR loader";
    const RUNTIME: &str = "OpenXR runtime";
    const HEADSET: &str = "headset";
    let loader = || Finding::good(LOADER, "installed");
    let mend = |fault| Runtimes::look().mend(fault, system);
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
            let found = one_clause(&error);
            let lacks = |part, found, mend| Finding::bad(part, Health::Lacking, found, mend);
            match &error {
                ConnectError::NoLoader => {
                    vec![lacks(LOADER, found, install(Package::OpenXrLoader, system))]
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
                    lacks(RUNTIME, found, install(Package::OpenXrRuntime, system)),
                ],
                _ => vec![loader(), lacks(RUNTIME, found, mend(Fault::Silent))],
            }
        }
    }
}

/// What happened, without the advice that an error's sentence ends with: the advice has a line of its own here.
fn one_clause(error: &ConnectError) -> String {
    let text = error.to_string();
    text.split([';', ':']).next().unwrap_or(&text).to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
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

    #[test]
    fn every_package_has_one_command_everywhere() {
        use {Package as P, System as S};
        for system in [
            S::Bookworm,
            S::Debian,
            S::Fedora,
            S::Arch,
            S::Suse,
            S::Other,
        ] {
            for package in [
                P::VulkanLoader,
                P::Driver,
                P::Validation,
                P::OpenXrLoader,
                P::OpenXrRuntime,
            ] {
                let command = install(package, system);
                assert!(
                    !command.is_empty() && !command.contains('\n'),
                    "{system:?} {package:?}"
                );
            }
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
