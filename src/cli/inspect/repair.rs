//! Mending a model by a list, and writing it.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow};

use super::super::progress::Progress;
use crate::mesh::Mesh;
use crate::mesh::mend::{Account, Mend, list_from_text, mend_all};
use crate::mesh::write::WriteFormat;
use crate::tree::file::write_atomically_with;

/// The mends of a list.
pub(super) fn mends(list: &str) -> Result<Vec<Mend>> {
    list_from_text(list).context("--repair")
}

/// Mends a mesh in place.
pub(super) fn mended(
    mesh: &mut Mesh,
    mends: &[Mend],
    cancel: &AtomicBool,
    path: &Path,
) -> Result<Vec<Account>> {
    let mut progress = Progress::new("mending");
    let mut show = |_: &Mend, done, of| progress.show(done, of);
    let (mended, accounts) = mend_all(std::mem::take(mesh), mends, cancel, &mut show)
        .map_err(|error| anyhow!("{error}: {}", path.display()))?;
    *mesh = mended;
    Ok(accounts)
}

/// Writes a mesh in the format that the name's ending tells.
pub(super) fn write(mesh: &Mesh, out: &Path) -> Result<()> {
    let format = WriteFormat::of(out)?;
    format.check(mesh)?;
    Progress::during("writing", || {
        write_atomically_with(out, |file| format.write(mesh, file))
    })?;
    Ok(())
}
