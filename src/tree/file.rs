//! Files written whole or not at all.
//!
//! The bytes go to a new file in the same folder, are forced to the disk, and take the target's name in one step; then the
//! folder's entry is forced too. Whatever fails on the way, and wherever the power goes, the path holds
//! either the old file or the new one. Where the system has files without a name (Linux, on most disks) the new one has none until it is whole, so that
//! no litter stays behind even where the program is ended from outside; elsewhere it has a name of its own for so long.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::TreeError;

/// Bytes that go to the system at a time.
const BUFFER: usize = 1 << 18;

/// Writes `bytes` to `path`, replacing a file that is there only once the new one is whole.
///
/// A symbolic link is followed, so that the file it points to is replaced; permissions of an old file are kept. Must not
/// be called from the frame loop: forcing to disk takes milliseconds and more.
///
/// # Errors
/// [`TreeError::Write`], which says what to do; the old file is unchanged then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), TreeError> {
    write_atomically_with(path, |out| out.write_all(bytes))
}

/// The same for what is written part by part, so that it need not lie in memory whole.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_atomically_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), TreeError> {
    try_write(path, write).map_err(|error| TreeError::Write {
        problem: explain(path, &error),
        path: path.to_owned(),
    })
}

/// Whether [`write_atomically`] would find its way to `path`, asked before long work: a small file is made beside it and
/// taken away. (Whether there is room for all of it is known only then.)
///
/// # Errors
/// [`TreeError::Write`], as from writing.
pub fn check_place(path: &Path) -> Result<(), TreeError> {
    prepare(path).map(drop).map_err(|error| TreeError::Write {
        problem: explain(path, &error),
        path: path.to_owned(),
    })
}

/// The file that a path leads to, and that which is there.
fn target(path: &Path) -> io::Result<(PathBuf, Option<fs::Metadata>)> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let old = match fs::metadata(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        old => old.ok(),
    };
    if old.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(ErrorKind::IsADirectory.into());
    }
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        // Replacing a device or a pipe by a file would break the system, not write to it.
        return Err(io::Error::other("a device or pipe has this name"));
    }
    if old.as_ref().is_some_and(|old| old.permissions().readonly()) {
        return Err(io::Error::new(
            ErrorKind::PermissionDenied,
            "the file is write-protected",
        ));
    }
    Ok((path, old))
}

/// The file that a path leads to, and a new one beside it that may take its place.
fn prepare(path: &Path) -> io::Result<(PathBuf, NamedTempFile)> {
    let (path, old) = target(path)?;
    let folder = folder_of(&path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ramus-").suffix(".tmp");
    #[cfg(unix)]
    let ordinary = std::os::unix::fs::PermissionsExt::from_mode(0o666); // Less what the umask takes away.
    #[cfg(unix)]
    builder.permissions(ordinary);
    let file = builder.tempfile_in(&folder)?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok((path, file))
}

fn try_write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let (real, old) = target(path)?;
    let path = if let Some(mut file) = unnamed::file_in(&folder_of(&real)) {
        if let Some(old) = old {
            file.set_permissions(old.permissions())?;
        }
        write_all(&mut file, write)?;
        unnamed::name(&file, &real)?;
        real
    } else {
        let (path, mut file) = prepare(path)?;
        write_all(file.as_file_mut(), write)?;
        file.persist(&path).map_err(|failed| failed.error)?;
        path
    };
    // The name itself is safe once the folder is; where a folder cannot be forced (Windows), the system does it in its time.
    if let Ok(folder) = File::open(folder_of(&path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn write_all(
    file: &mut File,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, &mut *file);
    write(&mut out)?;
    out.flush()?;
    drop(out);
    file.sync_all()
}

/// Files that have no name until they are whole (open(2), O_TMPFILE).
#[cfg(target_os = "linux")]
mod unnamed {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::Path;

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    /// A new one in a folder; none where the disk has no such, or something is in the way that is told elsewhere.
    pub(super) fn file_in(folder: &Path) -> Option<File> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        // Less what the umask takes away.
        let file = open(folder, flags, Mode::from_raw_mode(0o666)).ok()?;
        // Names are given through this.
        Path::new("/proc/self/fd").is_dir().then(|| file.into())
    }

    /// Gives it its name, in place of what has it. A name that is taken cannot be given: for a moment it has another one.
    pub(super) fn name(file: &File, path: &Path) -> io::Result<()> {
        let from = format!("/proc/self/fd/{}", file.as_raw_fd());
        let link = |to: &Path| linkat(CWD, from.as_str(), CWD, to, AtFlags::SYMLINK_FOLLOW);
        match link(path) {
            Err(error) if error == rustix::io::Errno::EXIST => {}
            done => return done.map_err(io::Error::from),
        }
        let beside = tempfile::Builder::new()
            .prefix(".ramus-")
            .suffix(".tmp")
            .make_in(super::folder_of(path), |to| Ok(link(to)?))?;
        beside.persist(path).map_err(|failed| failed.error)
    }
}

#[cfg(not(target_os = "linux"))]
mod unnamed {
    use std::fs::File;
    use std::io;
    use std::path::Path;

    pub(super) fn file_in(_: &Path) -> Option<File> {
        None
    }

    pub(super) fn name(_: &File, _: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// The folder that holds a path.
fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// What went wrong and how to mend it, without the path (which the error adds at its end).
fn explain(path: &Path, error: &io::Error) -> String {
    let folder_missing = !folder_of(path).is_dir();
    match error.kind() {
        ErrorKind::StorageFull => "the disk is full: free some space or choose another disk".into(),
        ErrorKind::QuotaExceeded => "your quota on this disk is used up: free some space or choose another disk".into(),
        ErrorKind::FileTooLarge => "the file is larger than this disk or your limits allow: choose another disk".into(),
        ErrorKind::ReadOnlyFilesystem => "this disk can only be read: choose another folder".into(),
        ErrorKind::PermissionDenied => {
            "you may not write here: choose another folder, or make the folder and the file writable".into()
        }
        ErrorKind::IsADirectory => "a folder has this name: choose another file name".into(),
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder: choose another folder".into(),
        ErrorKind::InvalidFilename => "the file name is too long or not allowed here: choose another".into(),
        ErrorKind::NotFound if folder_missing => "the folder does not exist: make it first or choose another".into(),
        _ => format!("the file could not be written ({error}): try again, or choose another folder"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]

    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn new_and_old_files_are_written_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ärger tree.ramus");
        for bytes in [&b"first"[..], b"", &[7; 100_000]] {
            write_atomically(&path, bytes).unwrap();
            check_place(&path).unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes);
        }
        assert_eq!(names_in(folder.path()), ["ärger tree.ramus"], "no litter");
    }

    /// So nothing is left where the program is ended in the middle.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_has_no_name_until_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        if unnamed::file_in(folder.path()).is_none() {
            println!("skipped: this disk has no files without a name (O_TMPFILE)");
            return;
        }
        let path = folder.path().join("tree.glb");
        for (number, before) in [vec![], vec!["tree.glb".to_owned()]].iter().enumerate() {
            let bytes = [u8::try_from(number).unwrap(); 1_000_000];
            write_atomically_with(&path, |out| {
                out.write_all(&bytes)?;
                assert_eq!(names_in(folder.path()), *before);
                Ok(())
            })
            .unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes);
        }
        let failed = write_atomically_with(&path, |out| {
            out.write_all(b"half of it")?;
            Err(ErrorKind::Interrupted.into())
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), [1; 1_000_000]);
        assert_eq!(names_in(folder.path()), ["tree.glb"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let [real, link, plain] = ["real", "link", "plain"].map(|name| folder.path().join(name));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&real), 0o640);
        write_atomically(&plain, b"new").unwrap();
        fs::write(&real, "").unwrap();
        let other = folder.path().join("other");
        fs::write(&other, "made the usual way").unwrap();
        assert_eq!(
            mode(&plain),
            mode(&other),
            "readable by whom the umask lets read"
        );
    }

    #[test]
    fn what_is_in_the_way_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "old").unwrap();
        let table = [
            (
                folder.path().join("missing/tree.glb"),
                "folder does not exist",
            ),
            (folder.path().to_owned(), "a folder has this name"),
            (file.join("tree.glb"), "not a folder"),
            (folder.path().join("x".repeat(300)), "file name is too long"),
        ];
        for (path, expected) in table {
            let message = write_atomically(&path, b"new").unwrap_err().to_string();
            assert_eq!(check_place(&path).unwrap_err().to_string(), message);
            assert!(
                message.contains(expected) && message.ends_with(&path.display().to_string()),
                "{message}"
            );
        }
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["file"]);
    }

    #[test]
    fn a_write_protected_file_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept");
        fs::write(&path, "old").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let message = write_atomically(&path, b"new").unwrap_err().to_string();
        assert!(
            message.contains("writable") && message.contains("unchanged"),
            "{message}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["kept"]);
    }

    #[test]
    fn every_kind_of_failure_has_a_sentence() {
        use ErrorKind as Kind;
        let path = std::env::temp_dir().join("tree.glb");
        for (kind, expected) in [
            (Kind::StorageFull, "disk is full"),
            (Kind::QuotaExceeded, "quota"),
            (Kind::FileTooLarge, "larger than"),
            (Kind::ReadOnlyFilesystem, "only be read"),
            (Kind::PermissionDenied, "may not write"),
            (Kind::Interrupted, "try again"),
        ] {
            let problem = explain(&path, &kind.into());
            assert!(
                problem.contains(expected) && problem.contains(": "),
                "{problem}"
            );
        }
    }

    /// A real full disk and a real read-only one: this very test again, in a name space of its own with a disk of 64 KiB.
    #[cfg(target_os = "linux")]
    #[test]
    fn full_and_read_only_disks_keep_the_old_file() {
        const DISK: &str = "RAMUS_TEST_SMALL_DISK";
        if let Some(disk) = std::env::var_os(DISK) {
            on_a_small_disk(Path::new(&disk));
            return;
        }
        let disk = tempfile::tempdir().unwrap();
        let run = |script: &str| {
            let test = "tree::file::tests::full_and_read_only_disks_keep_the_old_file";
            std::process::Command::new("unshare")
                .args(["--user", "--map-root-user", "--mount", "sh", "-c", script])
                .arg(std::env::current_exe().unwrap())
                .args(["--exact", test, "--nocapture"])
                .env(DISK, disk.path())
                .output()
        };
        let mount = format!("mount -t tmpfs -o size=64k none \"${DISK}\"");
        if !run(&mount).is_ok_and(|done| done.status.success()) {
            println!(
                "skipped: this system lets the test mount no disk of its own (unshare, mount)"
            );
            return;
        }
        let done = run(&format!("{mount} && exec \"$0\" \"$@\"")).unwrap();
        let text = String::from_utf8_lossy(&done.stdout);
        assert!(
            done.status.success() && text.contains("1 passed"),
            "{text}{}",
            String::from_utf8_lossy(&done.stderr)
        );
    }

    #[cfg(target_os = "linux")]
    fn on_a_small_disk(disk: &Path) {
        let path = disk.join("tree.glb");
        write_atomically(&path, &[1; 10_000]).unwrap();
        let message = write_atomically(&path, &[2; 100_000])
            .unwrap_err()
            .to_string();
        assert!(message.contains("disk is full"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), [1; 10_000]);
        assert_eq!(names_in(disk), ["tree.glb"]);

        let done = std::process::Command::new("mount")
            .args(["-o", "remount,ro"])
            .arg(disk)
            .status()
            .unwrap();
        assert!(done.success());
        let message = write_atomically(&path, &[3; 10]).unwrap_err().to_string();
        assert!(message.contains("only be read"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), [1; 10_000]);
    }
}
