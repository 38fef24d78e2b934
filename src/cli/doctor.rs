//! `ramus doctor`: what this machine has, and how to mend what is missing.

use std::io::Write as _;

use anyhow::Result;

use super::print_result;
use crate::app::doctor::{Finding, Health, examine};

pub(super) fn run() -> Result<()> {
    let findings = examine();
    print_result("the report", |out| {
        for finding in &findings {
            let mark = match finding.health {
                Health::Good => "ok",
                Health::Lacking => "--",
                Health::Missing => "!!",
            };
            writeln!(out, "{mark}  {:<18} {}", finding.part, finding.found)?;
            if let Some(mend) = &finding.mend {
                writeln!(out, "    {:<18} mend it: {mend}", "")?;
            }
        }
        writeln!(out, "{}", verdict(&findings))
    })
}

fn verdict(findings: &[Finding]) -> &'static str {
    let missing = findings
        .iter()
        .any(|finding| finding.health == Health::Missing);
    let headset = findings
        .iter()
        .any(|finding| finding.part == "headset" && finding.health == Health::Good);
    match (missing, headset) {
        (true, _) => "Ramus cannot draw here yet; grammars can be derived and exported.",
        (false, true) => "Ramus can start in the headset.",
        (false, false) => {
            "Ramus can draw here and play sessions on its simulated headset; for the workshop it needs a headset."
        }
    }
}
