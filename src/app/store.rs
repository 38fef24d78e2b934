//! The project on disk: opened, recovered, journalled while the session runs, saved at its end.
//!
//! Beside `tree.ramus` lies `tree.ramus.journal` while a session is open: every finished action is
//! appended to it at once (into the system's cache, so that a kill loses nothing), and a worker forces it
//! to the disk. A killed session loses nothing but what was not finished; the next start repeats the
//! journal on the project. Saving writes the project whole; closing
//! also takes the journal away. The journal is locked, so that two sessions never write one project.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use crate::app::worker::Worker;
use crate::tree::TreeError;
use crate::tree::file::{check_place, write_atomically};
use crate::world::document::Document;
use crate::world::history::{Action, History};
use crate::world::journal::{self, Damage, Decoded, Journal, JournalError};
use crate::world::project::{self, ProjectError};

/// Larger files are no projects or journals; they are not even read.
const MAX_FILE_BYTES: u64 = 512 << 20;

/// Why a project cannot be opened or kept.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The project file is broken.
    #[error("{path}: {source}", path = path.display())]
    Project {
        /// What is wrong.
        source: ProjectError,
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {path} ({source}): check that it is there and may be read", path = path.display())]
    Read {
        /// What the system said.
        source: io::Error,
        /// The file.
        path: PathBuf,
    },
    /// The journal cannot be written, so edits would not be safe.
    #[error("cannot keep a journal at {path} ({source}): choose a project in a folder that you may write to and that has room", path = path.display())]
    Journal {
        /// What the system said.
        source: io::Error,
        /// The journal.
        path: PathBuf,
    },
    /// Another session has the project open.
    #[error("another Ramus has {path} open: end it first, or choose another project", path = path.display())]
    Busy {
        /// The project.
        path: PathBuf,
    },
    /// The journal was written by a later program.
    #[error("{path}: {source}", path = path.display())]
    Recover {
        /// What is wrong.
        source: JournalError,
        /// The journal.
        path: PathBuf,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] TreeError),
    /// The project could not be saved at the session's end; the work lies elsewhere.
    #[error("the project was not saved ({source}); {kept}")]
    Unsaved {
        /// Why not.
        source: TreeError,
        /// Where the work is and how it comes back.
        kept: String,
    },
}

/// An opened project.
pub struct Opened {
    /// Where it is kept.
    pub store: Store,
    /// What was in it, with what could be recovered.
    pub history: History,
    /// What the person should know: what was recovered, what was put aside.
    pub message: Option<String>,
}

/// Keeps one project and its journal.
pub struct Store {
    project: PathBuf,
    journal_path: PathBuf,
    file: Arc<File>,
    journal: Journal,
    /// How long the journal is where it is surely whole.
    whole_bytes: u64,
    /// Lines that could not be written yet (a full disk); they are tried again with the next.
    unwritten: Vec<u8>,
    sync: Worker<Arc<File>, ()>,
    /// What forcing the journal to the disk failed in, until it was told.
    fault: Arc<Mutex<Option<io::Error>>>,
    /// Whether the session began empty, whatever lies at the path.
    begun: bool,
}

/// `tree.ramus` → `tree.ramus.journal`, and the like.
fn beside(project: &Path, suffix: &str) -> PathBuf {
    let mut name = project.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

/// The first of `tree.ramus.SUFFIX`, `tree.ramus.SUFFIX.2`, … that is not there yet, and the last one that is.
fn names(project: &Path, suffix: &str) -> (PathBuf, Option<PathBuf>) {
    let mut path = beside(project, suffix);
    let mut last = None;
    let mut number = 2;
    while path.exists() {
        let next = beside(project, &format!("{suffix}.{number}"));
        last = Some(std::mem::replace(&mut path, next));
        number += 1;
    }
    (path, last)
}

fn free_name(project: &Path, suffix: &str) -> PathBuf {
    names(project, suffix).0
}

/// What a project is called that had to make room for a newer one.
const BEFORE: &str = ".before.ramus";

/// A sentence for whoever opens an empty project beside which an older one lies.
#[must_use]
pub fn older_one(project: &Path, document: &Document) -> Option<String> {
    if !document.sketch.is_empty() {
        return None;
    }
    names(project, BEFORE).1.map(|older| {
        format!(
            "nothing is in {}, and an older project lies beside it: {}",
            project.display(),
            older.display()
        )
    })
}

/// Keeps a project beside itself if the document, which is to be written there, differs from it; gives its new name.
///
/// # Errors
/// Where the older project cannot be read or kept: it must not be written over then.
pub fn keep_older(project: &Path, document: &Document) -> Result<Option<PathBuf>, StoreError> {
    match read(project)? {
        Some(older) if older != project::to_bytes(document) => {
            let kept = free_name(project, BEFORE);
            write_atomically(&kept, &older)?;
            Ok(Some(kept))
        }
        _ => Ok(None),
    }
}

fn read(path: &Path) -> Result<Option<Vec<u8>>, StoreError> {
    let failed = |source| StoreError::Read {
        source,
        path: path.to_owned(),
    };
    let file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.map_err(failed)?,
    };
    let mut bytes = Vec::new();
    let read = file
        .take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if read as u64 > MAX_FILE_BYTES {
        return Err(failed(io::Error::other(
            "it is larger than 512 MiB, which no project is",
        )));
    }
    Ok(Some(bytes))
}

/// Reads a project file that need not be kept open.
///
/// # Errors
/// Where it is missing, cannot be read or is broken.
pub fn read_project(path: &Path) -> Result<Document, StoreError> {
    let bytes = read(path)?.ok_or_else(|| StoreError::Read {
        source: io::ErrorKind::NotFound.into(),
        path: path.to_owned(),
    })?;
    project::from_bytes(&bytes).map_err(|source| StoreError::Project {
        source,
        path: path.to_owned(),
    })
}

/// Whether a journal was kept for this project: for the state that it starts from, or for one that was saved on the way.
fn belongs(decoded: &Decoded, project: &Document) -> bool {
    if decoded.project == *project {
        return true;
    }
    let mut history = History::new(decoded.project.clone());
    decoded
        .actions
        .iter()
        .any(|action| history.repeat(action.clone()).is_ok() && history.committed() == project)
}

/// What a journal left behind by a killed session gave.
struct Left {
    history: History,
    journal: Option<(Journal, u64)>,
    message: Option<String>,
}

impl Store {
    /// Opens a project, or begins one where there is none, and recovers what a killed session left.
    ///
    /// # Errors
    /// [`StoreError`]; no file is changed then.
    pub fn open(project: &Path) -> Result<Opened, StoreError> {
        let document = match read(project)? {
            None => Document::default(),
            Some(bytes) => project::from_bytes(&bytes).map_err(|source| StoreError::Project {
                source,
                path: project.to_owned(),
            })?,
        };
        let journal_path = Self::journal_of(project);
        let file = Self::lock(project, &journal_path)?;
        let mut left = Self::recover(project, &journal_path, document)?;
        let older = || older_one(project, left.history.committed());
        left.message = left.message.or_else(older);
        Self::keep(project, journal_path, file, left)
    }

    /// Where a project's journal lies.
    #[must_use]
    pub fn journal_of(project: &Path) -> PathBuf {
        beside(project, ".journal")
    }

    /// Whether a killed session left a journal beside a project.
    #[must_use]
    pub fn has_journal(project: &Path) -> bool {
        std::fs::metadata(Self::journal_of(project)).is_ok_and(|data| data.len() > 0)
    }

    /// Begins an empty project ([`Self::begin_with`]).
    ///
    /// # Errors
    /// [`StoreError`]; no file is changed then.
    pub fn begin(project: &Path) -> Result<Opened, StoreError> {
        Self::begin_with(project, Document::default())
    }

    /// Begins a project with a document, whatever is at `project`: an older file lies there unchanged until the session is
    /// closed. Work that a killed session left in its journal is saved beside it.
    ///
    /// # Errors
    /// [`StoreError`]; no file is changed then.
    pub fn begin_with(project: &Path, document: Document) -> Result<Opened, StoreError> {
        if project.exists() {
            check_place(project)?;
        }
        let journal_path = Self::journal_of(project);
        let file = Self::lock(project, &journal_path)?;
        let mut message = None;
        if file.metadata().is_ok_and(|data| data.len() > 0) {
            let base = read(project)?.and_then(|bytes| project::from_bytes(&bytes).ok());
            let left = Self::recover(project, &journal_path, base.unwrap_or_default())?;
            message = left.message;
            if left.history.undo_count() + left.history.redo_count() > 0 {
                let aside = free_name(project, ".recovered.ramus");
                write_atomically(&aside, &project::to_bytes(left.history.committed()))?;
                message = Some(format!(
                    "an earlier session ended abruptly; its work was saved as {}",
                    aside.display()
                ));
            }
        }
        let left = Left {
            history: History::new(document),
            journal: None,
            message,
        };
        let mut opened = Self::keep(project, journal_path, file, left)?;
        opened.store.begun = true;
        Ok(opened)
    }

    fn lock(project: &Path, journal_path: &Path) -> Result<File, StoreError> {
        let failed = |source| StoreError::Journal {
            source,
            path: journal_path.to_owned(),
        };
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(journal_path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => Ok(file),
            Err(TryLockError::WouldBlock) => Err(StoreError::Busy {
                path: project.to_owned(),
            }),
            Err(TryLockError::Error(source)) => Err(failed(source)),
        }
    }

    /// Reads what is in the journal; whatever cannot be used is put aside, never thrown away.
    fn recover(project: &Path, journal_path: &Path, base: Document) -> Result<Left, StoreError> {
        let bytes = read(journal_path)?.unwrap_or_default();
        let fresh = |message| Left {
            history: History::new(base.clone()),
            journal: None,
            message,
        };
        let put_aside = |why: &str| {
            let aside = free_name(project, ".journal.damaged");
            write_atomically(&aside, &bytes)?;
            Ok::<_, StoreError>(format!(
                "{why}; the journal was kept as {}",
                aside.display()
            ))
        };
        let decoded = match journal::decode(&bytes) {
            Ok(decoded) => decoded,
            Err(JournalError::Empty) => return Ok(fresh(None)),
            Err(source @ JournalError::Version(_)) => {
                return Err(StoreError::Recover {
                    source,
                    path: journal_path.to_owned(),
                });
            }
            Err(error) => return Ok(fresh(Some(put_aside(&error.to_string())?))),
        };
        let recovered = journal::recover(&decoded);
        // Going on in the same journal needs all its actions to have been repeated.
        let whole = recovered.actions == decoded.actions.len();
        let broken = matches!(decoded.damage, Some(Damage::Broken { .. }));
        let mut message = recovered.message;
        if let Some(why) = message.take_if(|_| broken || !whole) {
            message = Some(put_aside(&why)?);
        }
        if decoded.actions.is_empty() {
            // A line that was never finished is no action.
            return Ok(fresh(message.filter(|_| broken)));
        }
        if !belongs(&decoded, &base) {
            let aside = free_name(project, ".recovered.ramus");
            write_atomically(&aside, &project::to_bytes(recovered.history.committed()))?;
            let strange = format!(
                "a session that ended abruptly did not start from the project as it is; its work was saved as {}",
                aside.display()
            );
            return Ok(fresh(Some(match message {
                Some(damage) => format!("{strange}; {damage}"),
                None => strange,
            })));
        }
        let actions = recovered.actions;
        Ok(Left {
            history: recovered.history,
            journal: whole.then_some((decoded.journal, decoded.whole_bytes as u64)),
            message: message.or_else(|| {
                Some(format!(
                    "recovered {actions} actions of a session that ended abruptly"
                ))
            }),
        })
    }

    fn keep(
        project: &Path,
        journal_path: PathBuf,
        file: File,
        left: Left,
    ) -> Result<Opened, StoreError> {
        let failed = |source| StoreError::Journal {
            source,
            path: journal_path.clone(),
        };
        let fault = Arc::new(Mutex::new(None));
        let sync = Worker::start("ramus-sync", {
            let fault = Arc::clone(&fault);
            move |file: &Arc<File>, _: &AtomicBool| {
                if let Err(error) = file.sync_data() {
                    *fault.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                }
            }
        })
        .map_err(failed)?;
        let (journal, whole_bytes) = left.journal.unwrap_or_else(|| {
            let (journal, _) = Journal::begin(left.history.committed());
            (journal, 0)
        });
        let mut store = Self {
            project: project.to_owned(),
            journal_path: journal_path.clone(),
            file: Arc::new(file),
            journal,
            whole_bytes,
            unwritten: Vec::new(),
            sync,
            fault,
            begun: false,
        };
        if whole_bytes == 0 {
            // What could not be repeated lies in a file of its own; what could is saved before the journal starts anew.
            let recovered = left.history.undo_count() + left.history.redo_count() > 0;
            if recovered {
                write_atomically(project, &project::to_bytes(left.history.committed()))?;
            }
            store
                .start_journal(left.history.committed())
                .map_err(failed)?;
        } else {
            store.file.set_len(whole_bytes).map_err(failed)?;
        }
        Ok(Opened {
            store,
            history: left.history,
            message: left.message,
        })
    }

    /// The project's path.
    #[must_use]
    pub fn project(&self) -> &Path {
        &self.project
    }

    /// Appends finished actions to the journal.
    ///
    /// # Errors
    /// Where the system refuses; the actions are kept and tried again with the next call.
    pub fn append(&mut self, actions: &[Action]) -> Result<(), StoreError> {
        for action in actions {
            self.unwritten
                .extend_from_slice(self.journal.line(action).as_bytes());
        }
        if self.unwritten.is_empty() {
            return Ok(());
        }
        self.write_out().map_err(|source| StoreError::Journal {
            source,
            path: self.journal_path.clone(),
        })
    }

    /// What the worker that forces the journal to the disk complained of, if anything.
    ///
    /// # Errors
    /// Where forcing failed: the disk is full or gone.
    pub fn check(&mut self) -> Result<(), StoreError> {
        let fault = self
            .fault
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        fault.map_or(Ok(()), |source| {
            Err(StoreError::Journal {
                source,
                path: self.journal_path.clone(),
            })
        })
    }

    /// Saves the project whole. The journal goes on: undo may reach back behind a save. A session that began whatever lay
    /// there ([`Self::begin`]) leaves the older file alone until it is closed: its work is in the journal.
    ///
    /// # Errors
    /// Where the project cannot be written; project and journal are as they were then.
    pub fn save(&mut self, document: &Document) -> Result<(), StoreError> {
        if self.begun {
            return Ok(());
        }
        Ok(write_atomically(
            &self.project,
            &project::to_bytes(document),
        )?)
    }

    /// Saves and takes the journal away: the session ended in good order.
    ///
    /// # Errors
    /// Where the project cannot be written; the journal stays then, and holds everything. Where it cannot be written
    /// either, the project is saved in the system's folder for temporary files, and the error says under which name.
    pub fn close(mut self, document: &Document) -> Result<(), StoreError> {
        if let Err(source) = write_atomically(&self.project, &project::to_bytes(document)) {
            let kept = self.rescue(document);
            return Err(StoreError::Unsaved { source, kept });
        }
        // A journal that cannot be removed repeats what is saved already.
        let _ = std::fs::remove_file(&self.journal_path);
        Ok(())
    }

    /// Ends a session that failed after [`Self::begin`]: an older project stays as it is, and what was made is saved
    /// beside it, or as the project where there is none. Gives the file in which it is; nothing made needs none.
    ///
    /// # Errors
    /// As [`Self::close`].
    pub fn set_aside(mut self, document: &Document) -> Result<Option<PathBuf>, StoreError> {
        let mut saved = None;
        if *document != Document::default() {
            let bytes = project::to_bytes(document);
            let path = match read(&self.project) {
                Ok(None) => self.project.clone(),
                Ok(Some(older)) if older == bytes => self.project.clone(),
                _ => free_name(&self.project, ".unfinished.ramus"),
            };
            if let Err(source) = write_atomically(&path, &bytes) {
                let kept = self.rescue(document);
                return Err(StoreError::Unsaved { source, kept });
            }
            saved = Some(path);
        }
        let _ = std::fs::remove_file(&self.journal_path);
        Ok(saved)
    }

    /// Keeps the work where the project cannot be saved; says where.
    fn rescue(&mut self, document: &Document) -> String {
        if self.unwritten.is_empty() || self.write_out().is_ok() {
            let next = match self.begun && self.project.is_file() {
                true => "saves it beside the older one",
                false => "goes on from there",
            };
            return format!(
                "all of the work is in {}, and the next start on this project {next}",
                self.journal_path.display()
            );
        }
        let name = self.project.file_name().unwrap_or_default();
        let path = free_name(&std::env::temp_dir().join(name), ".rescued.ramus");
        match write_atomically(&path, &project::to_bytes(document)) {
            Ok(()) => format!("all of the work was saved as {} instead", path.display()),
            Err(_) => format!(
                "the work up to the last action that could be written is in {}",
                self.journal_path.display()
            ),
        }
    }

    fn start_journal(&mut self, base: &Document) -> io::Result<()> {
        let (journal, header) = Journal::begin(base);
        self.journal = journal;
        self.unwritten = header.into_bytes();
        self.whole_bytes = 0;
        self.file.set_len(0)?;
        self.write_out()
    }

    /// Writes what is due after the last whole line; a half-written line of an earlier try is cut off first.
    fn write_out(&mut self) -> io::Result<()> {
        let mut file = &*self.file;
        file.set_len(self.whole_bytes)?;
        file.seek(SeekFrom::Start(self.whole_bytes))?;
        file.write_all(&self.unwritten)?;
        self.whole_bytes += self.unwritten.len() as u64;
        self.unwritten.clear();
        self.sync.ask(Arc::clone(&self.file));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
