//! `ramus doctor`: what this machine has, and how to mend what is missing.

use anyhow::Result;

use crate::app::doctor::{Health, examine};

pub(super) fn run() -> Result<()> {
    let findings = examine();
    for finding in &findings {
        let mark = match finding.health {
            Health::Good => "ok",
            Health::Lacking => "--",
            Health::Missing => "!!",
        };
        tell!("{mark}  {:<18} {}", finding.part, finding.found);
        if let Some(mend) = &finding.mend {
            tell!("    {:<18} mend it: {mend}", "");
        }
    }
    let missing = findings
        .iter()
        .any(|finding| finding.health == Health::Missing);
    let headset = findings
        .iter()
        .any(|finding| finding.part == "headset" && finding.health == Health::Good);
    tell!(
        "{}",
        match (missing, headset) {
            (true, _) => "Ramus cannot draw here yet; grammars can be derived and exported.",
            (false, true) => "Ramus can start in the headset.",
            (false, false) =>
                "Ramus can draw here and play sessions on its simulated headset; for the workshop it needs a headset.",
        }
    );
    Ok(())
}
