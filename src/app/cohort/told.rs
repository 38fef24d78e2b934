//! What a cohort takes of an analysis: read from the JSON object `ramus-analysis/1`, whether a file has it or it was just made.
//!
//! Both ways are one: an analysis that was just made is written and read as a file's is, so that tables do not depend on how the models came. Nodes
//! are passed over, which are most of a file.

mod branch;

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use anyhow::{Result, anyhow, bail, ensure};
use serde::Deserialize;
use serde::de::IgnoredAny;

pub use self::branch::{Branch, Definition};
use self::branch::{Vmtk, Whole};
use crate::centerline::analysis::{Analysis, FORMAT, Nodes};
use crate::mesh::unit::Unit;

/// Longest file of an analysis that is read, in bytes.
const BYTES_MOST: u64 = 1 << 30;
/// Bytes in which a file says what it is.
const HEAD: u64 = 256;
/// Longest text that is taken, in bytes: paths and sentences.
const TEXT_MOST: usize = 16 << 10;

/// An analysis, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// What was found.
    Found(Box<Facts>),
    /// The model's file, and the reason in a sentence.
    Failed(String, String),
}

/// The file, as it may be.
#[derive(Deserialize)]
struct Form {
    format: String,
    model: Model,
    failed: Option<String>,
    endpoints: Option<Endpoints>,
    counts: Option<Counts>,
    counts_vmtk: Option<CountsVmtk>,
    table: Option<Measured>,
    table_vmtk: Option<Measured>,
    orders: Option<Orders>,
    branches: Option<Vec<Whole>>,
    branches_vmtk: Option<Vec<Vmtk>>,
    junctions: Option<Vec<Junction>>,
    junctions_vmtk: Option<Vec<IgnoredAny>>,
}

/// What is taken of an analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// The model.
    pub model: Model,
    /// Its endpoints.
    pub endpoints: Endpoints,
    /// How many there are of everything.
    pub counts: Counts,
    /// How many there are by VMTK's definition; None where balls overlap too much for it.
    pub counts_vmtk: Option<CountsVmtk>,
    /// Means and deviations, of whole branches.
    pub table: Measured,
    /// The same by VMTK's definition; None where balls overlap too much for it.
    pub table_vmtk: Option<Measured>,
    /// By Strahler's orders.
    pub orders: Orders,
    /// Each whole branch.
    pub branches: Vec<Branch>,
    /// Each branch by VMTK's definition.
    pub branches_vmtk: Vec<Branch>,
    /// Each junction of whole branches.
    pub junctions: Vec<Junction>,
}

/// The model, as [`ModelFacts`](crate::centerline::analysis::ModelFacts) has it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Model {
    pub file: String,
    #[serde(default)]
    pub triangles: usize,
    #[serde(default)]
    pub vertices: usize,
    #[serde(default)]
    pub unit: Option<Unit>,
    #[serde(default)]
    pub components: usize,
    #[serde(default)]
    pub open_ends: usize,
    #[serde(default)]
    pub watertight: bool,
}

/// Endpoints.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Endpoints {
    /// Whether they were found and not given.
    pub automatic: bool,
    /// At how many of them lines go on to the middle of the open end.
    pub capped: usize,
    unreached: Vec<IgnoredAny>,
}

impl Endpoints {
    /// Targets that no way leads to.
    pub fn unreached(&self) -> usize {
        self.unreached.len()
    }
}

/// As [`Counts`](crate::centerline::analysis::Counts).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Counts {
    pub centerlines: usize,
    pub branches: usize,
    pub junctions: usize,
    pub bifurcations: usize,
    pub multifurcations: usize,
    pub tips: usize,
    pub loops_left_out: usize,
}

/// As [`CountsVmtk`](crate::centerline::analysis::CountsVmtk).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct CountsVmtk {
    pub branches: usize,
    pub bifurcations: usize,
    pub multifurcations: usize,
    pub tips: usize,
    pub swallowed: usize,
}

/// As [`TableFacts`](crate::centerline::analysis::TableFacts).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Measured {
    pub branch_length: Spread,
    pub point_radius: Spread,
    pub centerline_length: Spread,
    pub stem_length: Option<f64>,
    pub stem_iterations: Option<f64>,
    pub iterations: MeanStd,
    pub bifurcation_angle_deg: Spread,
    pub bifurcation_angle_in_plane_deg: Spread,
    pub upwards_angle_deg: MeanStd,
    pub curvature: Spread,
    pub torsion: Spread,
    pub tortuosity: Spread,
}

/// As [`Spread`](crate::tree::measure::Spread); what is not finite is null in JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Spread {
    pub n: usize,
    pub mean: Option<f64>,
    pub std: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
}

impl From<crate::tree::measure::Spread> for Spread {
    fn from(spread: crate::tree::measure::Spread) -> Self {
        Self {
            n: spread.n,
            mean: Some(spread.mean),
            std: Some(spread.std),
            min: Some(spread.min),
            max: Some(spread.max),
        }
    }
}

/// Two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct MeanStd {
    pub mean: Option<f64>,
    pub std: Option<f64>,
}

/// As [`OrderFacts`](crate::centerline::analysis::OrderFacts).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Orders {
    pub branching_ratio: Option<f64>,
    pub length_ratio: Option<f64>,
    pub radius_ratio: Option<f64>,
    #[serde(default)]
    pub centrifugal: Vec<Centrifugal>,
}

/// As [`CentrifugalFacts`](crate::centerline::analysis::CentrifugalFacts).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Centrifugal {
    pub order: u32,
    pub branches: usize,
    pub branch_length: MeanStd,
    pub point_radius: Mean,
    pub bifurcation_angle_deg: Option<MeanStd>,
}

/// One number.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Mean {
    pub mean: Option<f64>,
}

/// As [`RadiusFacts`](crate::centerline::analysis::RadiusFacts).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Radius {
    pub mean: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub start: Option<f64>,
    pub end: Option<f64>,
    pub taper: Option<f64>,
}

/// As [`JunctionFacts`](crate::centerline::analysis::JunctionFacts).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Junction {
    pub parent_angles_deg: Vec<Option<f64>>,
    pub murray: Option<f64>,
    pub asymmetry: Option<f64>,
}

/// Whether a file says at its beginning that it is an analysis.
pub fn looks_like_one(path: &Path) -> bool {
    // What is no plain file may never begin.
    if !path.is_file() {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    let name = FORMAT.as_bytes();
    read.is_ok() && head.windows(name.len()).any(|part| part == name)
}

impl Told {
    /// Of an analysis that was just made.
    ///
    /// # Errors
    /// None that a person could meet.
    pub fn new(mut analysis: Analysis) -> Result<Self> {
        analysis.nodes = Nodes::default();
        Self::from_bytes(&serde_json::to_vec(&analysis)?)
    }

    /// Of the bytes of such a file.
    ///
    /// # Errors
    /// As [`Told::read`], without the file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        Self::from_reader(bytes)
    }

    /// Reads what `ramus analyze --json` wrote into a file.
    ///
    /// # Errors
    /// In a sentence: what is wrong with it, and how to mend it.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let unreadable = |error: std::io::Error| {
            anyhow!("{name} cannot be read ({error}): check that it is there and may be read")
        };
        let known = path.metadata().map_err(unreadable)?;
        ensure!(known.is_file(), "{name} is no file: name an analysis");
        ensure!(
            known.len() <= BYTES_MOST,
            "{name} is longer than {BYTES_MOST} bytes, and no analysis is"
        );
        let file = File::open(path).map_err(unreadable)?;
        // It may grow while it is read.
        Self::from_reader(BufReader::new(file.take(BYTES_MOST)))
            .map_err(|error| anyhow!("{name} {error}"))
    }

    fn from_reader(read: impl Read) -> Result<Self> {
        let form: Form = serde_json::from_reader(read).map_err(|error| {
            anyhow!("is no analysis as `ramus analyze --json` writes it ({error}): write it anew")
        })?;
        form.checked()
    }

    /// The file of the model that was analyzed.
    pub fn file(&self) -> &str {
        match self {
            Self::Found(facts) => &facts.model.file,
            Self::Failed(file, _) => file,
        }
    }
}

impl Form {
    fn checked(self) -> Result<Told> {
        ensure!(
            self.format == FORMAT,
            "is no analysis: its format is not {FORMAT}; give what `ramus analyze --json` wrote"
        );
        let texts = [Some(&self.model.file), self.failed.as_ref()];
        ensure!(
            texts.iter().flatten().all(|text| text.len() <= TEXT_MOST),
            "has a text of more than {TEXT_MOST} bytes, and no analysis does: write it anew"
        );
        ensure!(
            !texts
                .iter()
                .flatten()
                .any(|text| text.contains(char::is_control)),
            "has a path or a reason of more than one line: write it anew"
        );
        ensure!(
            !self.model.file.is_empty(),
            "does not say of which file it is: write it anew"
        );
        if let Some(reason) = self.failed {
            return Ok(Told::Failed(self.model.file, reason));
        }
        let missing = |what| anyhow!("is no whole analysis: {what} are missing; write it anew");
        let branches = self.branches.ok_or_else(|| missing("branches"))?;
        let of_vmtk = "branches by VMTK's definition";
        let branches_vmtk = self.branches_vmtk.ok_or_else(|| missing(of_vmtk))?;
        let junctions_vmtk = self.junctions_vmtk.ok_or_else(|| missing(of_vmtk))?;
        let facts = Facts {
            model: self.model,
            endpoints: self.endpoints.ok_or_else(|| missing("endpoints"))?,
            counts: self.counts.ok_or_else(|| missing("counts"))?,
            counts_vmtk: self.counts_vmtk,
            table: self.table.ok_or_else(|| missing("measures"))?,
            table_vmtk: self.table_vmtk,
            orders: self.orders.ok_or_else(|| missing("orders"))?,
            branches: branches.into_iter().map(Branch::from).collect(),
            branches_vmtk: branches_vmtk.into_iter().map(Branch::from).collect(),
            junctions: self.junctions.ok_or_else(|| missing("junctions"))?,
        };
        facts.check(junctions_vmtk.len())?;
        Ok(Told::Found(Box::new(facts)))
    }
}

impl Facts {
    /// The branches of a definition.
    pub fn branches_of(&self, definition: Definition) -> &[Branch] {
        match definition {
            Definition::Whole => &self.branches,
            Definition::Vmtk => &self.branches_vmtk,
        }
    }

    /// How many branches it has by both definitions.
    pub fn branches_of_all(&self) -> usize {
        self.branches.len().saturating_add(self.branches_vmtk.len())
    }

    /// The table of a definition.
    pub fn table_of(&self, definition: Definition) -> Option<&Measured> {
        match definition {
            Definition::Whole => Some(&self.table),
            Definition::Vmtk => self.table_vmtk.as_ref(),
        }
    }

    /// Branches are numbered, each behind its parent, and there are as many as is said.
    fn check(&self, junctions_vmtk: usize) -> Result<()> {
        let (counts, branches) = (self.counts, &self.branches);
        let vmtk = self.counts_vmtk.map_or([0; 2], |vmtk| {
            [
                vmtk.branches,
                vmtk.bifurcations.saturating_add(vmtk.multifurcations),
            ]
        });
        for (what, counted, there) in [
            ("branches", counts.branches, branches.len()),
            ("junctions", counts.junctions, self.junctions.len()),
            ("branches of VMTK", vmtk[0], self.branches_vmtk.len()),
            ("junctions of VMTK", vmtk[1], junctions_vmtk),
        ] {
            if counted != there {
                bail!("says that there are {counted} {what}, and has {there}: write it anew");
            }
        }
        ensure!(
            self.counts_vmtk.is_some() == self.table_vmtk.is_some(),
            "has one half of what VMTK's definition tells and not the other: write it anew"
        );
        for (place, branch) in branches.iter().enumerate() {
            ensure!(
                branch.id == place && branch.parent.is_none_or(|parent| parent < place),
                "has a branch {place} of another number or before its parent: write it anew"
            );
        }
        Ok(())
    }
}
