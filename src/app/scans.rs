//! Scanned models of the workshop: read and looked at on a worker, one after the other.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::abstraction::blunt;
use crate::app::queue::Queue;
use crate::centerline::analysis::ModelFacts;
use crate::mesh::colour::{by_parts, by_problems};
use crate::mesh::display::Display;
use crate::mesh::intersect::{IntersectParams, intersections};
use crate::mesh::line::along;
use crate::mesh::mend::{Mend, mend_all};
use crate::mesh::paint::Paint;
use crate::mesh::pick::{Cache, Picker};
use crate::mesh::problem::problems;
use crate::mesh::report::{Component, ReportParams, report};
use crate::mesh::surface::Surface;
use crate::mesh::textured::{LayerLimits, Textured, moved};
use crate::mesh::unit::{Scale, Unit};
use crate::mesh::{self, Format, Mesh, ReadLimits, read, read_bytes};
use crate::tree::export::Swc;
use crate::world::likeness::Likeness;
use crate::world::model::LoadedModel;
use crate::world::scene::new_revision;

/// A file to read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scan {
    /// As the project names it.
    pub(super) file: String,
    /// Where it is.
    pub(super) path: PathBuf,
    /// What is mended on it, in order.
    pub(super) mends: Vec<Mend>,
    /// What grows in the place of the file, where something does.
    pub(super) likeness: Option<Likeness>,
    /// Where to keep what takes long to work out, if somewhere.
    pub(super) cache: Option<PathBuf>,
    /// Whether it comes onto the stage when it is read; else it stands there and waits for its mesh.
    pub(super) comes: bool,
}

/// A model that was read, and what is guessed of it.
#[derive(Debug)]
pub(super) struct Read {
    pub(super) model: LoadedModel,
    pub(super) unit: Unit,
    pub(super) z_up: bool,
}

/// What became of a file.
pub(super) type Done = (Scan, Result<Read, String>);

/// How far long work is, thousandths; the thread writes and frames read.
#[derive(Default)]
pub(super) struct Progress(AtomicU32);

impl Progress {
    /// How far it is.
    pub(super) fn now(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    /// It begins.
    pub(super) fn begin(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// What tells how far a stage is that begins and ends at so many thousandths of the whole.
    pub(super) fn stage(&self, [from, to]: [u32; 2]) -> impl FnMut(usize, usize) {
        self.0.store(from, Ordering::Relaxed);
        move |done, of| {
            let width = to - from;
            let part = (width as usize).saturating_mul(done) / of.max(1);
            let part = u32::try_from(part).unwrap_or(width).min(width);
            self.0.store(from + part, Ordering::Relaxed);
        }
    }
}

/// Where the stages of reading a model begin and end, thousandths: mending, the report, its crossings, the hierarchy; the file is read before them, and
/// levels of detail are made after them.
const STAGES: [[u32; 2]; 4] = [[250, 300], [300, 450], [450, 700], [700, 850]];

/// Reads what was asked for.
pub(super) struct Scans {
    queue: Queue<Scan, Done>,
    progress: Arc<Progress>,
}

impl Scans {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let progress = Arc::new(Progress::default());
        let told = Arc::clone(&progress);
        let job = move |scan: &Scan, cancel: &AtomicBool| (scan.clone(), look(scan, &told, cancel));
        Ok(Self {
            queue: Queue::start("ramus-scans", job)?,
            progress,
        })
    }

    /// Asks for a file, unless it is on its way. False: too many wait already.
    pub(super) fn ask(&mut self, scan: Scan) -> bool {
        self.queue.open().any(|other| *other == scan) || self.queue.ask(scan)
    }

    /// Goes on; gives what was read since.
    pub(super) fn poll(&mut self) -> Option<Done> {
        self.queue.poll()
    }

    /// Waits for the next file that is on its way, if one is.
    pub(super) fn wait(&mut self) -> Option<Done> {
        self.queue.wait()
    }

    /// The file that is being read, and how far that is, thousandths.
    pub(super) fn reading(&self) -> Option<(&str, u32)> {
        let scan = self.queue.open().next()?;
        Some((&scan.file, self.progress.now()))
    }

    /// Stops what is being read, and gives it back.
    pub(super) fn stop(&mut self) -> Option<Scan> {
        self.queue.stop()
    }

    pub(super) fn is_busy(&self) -> bool {
        self.queue.is_busy()
    }
}

/// Reads a file, mends what is asked for, and looks at the result.
fn look(scan: &Scan, progress: &Progress, cancel: &AtomicBool) -> Result<Read, String> {
    let Scan { path, mends, .. } = scan;
    let [mending, reporting, crossing, building] = STAGES;
    progress.begin();
    let model = match &scan.likeness {
        Some(likeness) => grown(likeness, cancel)?,
        None => read(path, &ReadLimits::default(), cancel).map_err(|error| error.to_string())?,
    };
    let (stated, format) = (model.scale(), model.format);
    let stopped = || "the reading of the model was cancelled".to_owned();
    let (remarks, skeleton) = (model.remarks, model.skeleton);
    // Mends join and replace the vertices that materials are put on by.
    let before = (model.paint.is_some() && !mends.is_empty()).then(|| model.mesh.clone());
    let mut mended = progress.stage(mending);
    let (mesh, accounts) = mend_all(model.mesh, mends, cancel, &mut |_, done, of| {
        mended(done, of)
    })
    .map_err(|error| format!("{error}: {}", path.display()))?;
    let mesh = Arc::new(mesh);
    let params = ReportParams::default();
    let report = report(&mesh, &params, cancel, &mut progress.stage(reporting))
        .map_err(|error| error.to_string())?;
    let params = IntersectParams::default();
    let found =
        intersections(&mesh, &params, cancel, &mut progress.stage(crossing)).ok_or_else(stopped)?;
    let mut built = progress.stage(building);
    let picker = match &scan.cache {
        Some(folder) => kept_picker(&mesh, folder, cancel, &mut built),
        None => Picker::new(Arc::clone(&mesh), cancel, &mut built),
    };
    let surface = picker
        .and_then(|picker| Surface::new(picker, cancel))
        .ok_or_else(stopped)?;
    let coloured = match (model.paint, before) {
        (Some(paint), None) => painted(surface, paint, cancel),
        (Some(paint), Some(before)) => repainted(surface, &paint, before, cancel),
        (None, _) => LoadedModel::new(surface, cancel),
    };
    let mut model = coloured.ok_or_else(stopped)?;
    model.remarks.splice(..0, remarks);
    if let Some(skeleton) = &skeleton {
        let line = Display::new(Arc::new(along(skeleton)), None, cancel).ok_or_else(stopped)?;
        model.centerline = Some((Arc::new(line), new_revision()));
        model.skeleton = Some(Arc::new(skeleton.clone()));
    }
    let plain = Arc::clone(&model.plain);
    let guess = stated.or_else(|| Scale::guessed(report.size().max_element()));
    if plain.size().max_element() <= 0.0 || guess.is_none() {
        return Err(format!(
            "{}: all of the model lies in one place, so there is nothing to see",
            path.display()
        ));
    }
    model.parts = Arc::new(plain.coloured(by_parts(&report)));
    model.problems = Arc::new(plain.coloured(by_problems(&mesh, &report, &found)));
    model.revisions = [new_revision(), new_revision(), new_revision()];
    model.faults = problems(&report, Some(&found));
    model.facts = ModelFacts::new(scan.file.clone(), &report, guess);
    let genus = report.components.iter().filter_map(Component::genus);
    model.loops = genus.map(|genus| genus as usize).sum();
    model.accounts = accounts.iter().map(ToString::to_string).collect();
    Ok(Read {
        unit: guess.map_or(Unit::Metres, |scale| scale.unit),
        z_up: stands_on_its_third_axis(format),
        model,
    })
}

/// A tree that grows, as the skeleton that it would be in a file.
fn grown(likeness: &Likeness, cancel: &AtomicBool) -> Result<mesh::Model, String> {
    let wrong = |why: &dyn std::fmt::Display| format!("the tree cannot grow: {why}");
    let mut tree = likeness.tree(cancel).map_err(|error| wrong(&error))?;
    let mut file = Vec::new();
    let shown = blunt(&tree);
    let skeleton = Swc::new(&shown).map_err(|error| wrong(&error))?;
    skeleton.write(&mut file).map_err(|error| wrong(&error))?;
    let mut model =
        read_bytes(&file, &ReadLimits::default(), cancel).map_err(|error| wrong(&error))?;
    // It is counted and measured as it grew.
    let origin = model.mesh.origin.as_vec3();
    tree.position.iter_mut().for_each(|at| *at -= origin);
    model.skeleton = Some(tree);
    Ok(model)
}

/// A model with the colours of its file; what is not shown of them is told.
fn painted(surface: Surface, paint: Paint, cancel: &AtomicBool) -> Option<LoadedModel> {
    let (textured, remarks) = Textured::new(paint, &LayerLimits::default(), cancel)?;
    let mut model = LoadedModel::with_materials(surface, textured, cancel)?;
    model.remarks = remarks;
    Some(model)
}

/// The same of a model that was mended, whose vertices are not those of its file.
fn repainted(
    surface: Surface,
    paint: &Paint,
    before: Mesh,
    cancel: &AtomicBool,
) -> Option<LoadedModel> {
    let (mesh, paint) = moved(paint, before, surface.mesh(), cancel)?;
    let (textured, remarks) = Textured::new(paint, &LayerLimits::default(), cancel)?;
    let mut model = LoadedModel::new(surface, cancel)?;
    model.remarks = remarks;
    if let Some(textured) = textured {
        let display = Display::new(Arc::new(mesh), Some(&textured), cancel)?;
        let display = display.textured(Arc::new(textured));
        model.textured = Some((Arc::new(display), new_revision()));
    }
    Some(model)
}

/// Smaller models are searched through sooner than a file is found.
const LEAST_KEPT: usize = 100_000;
/// Most files in the cache.
const MOST_KEPT: usize = 32;

/// A picker whose hierarchy is kept in a folder, by what the mesh holds; what the folder cannot take is built each time.
fn kept_picker(
    mesh: &Arc<Mesh>,
    folder: &Path,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<Picker> {
    if mesh.triangles.len() < LEAST_KEPT || std::fs::create_dir_all(folder).is_err() {
        return Picker::new(Arc::clone(mesh), cancel, progress);
    }
    let path = folder.join(format!("{}.{CACHED}", Picker::name_of(mesh)));
    let (picker, cache) = Picker::cached(Arc::clone(mesh), &path, cancel, progress)?;
    if matches!(cache, Cache::Written) {
        forget_the_oldest(folder);
    }
    Some(picker)
}

/// Ending of the files in the cache.
const CACHED: &str = "pick";

/// Takes the oldest files out of a cache that holds too many.
fn forget_the_oldest(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == CACHED))
        .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .collect();
    files.sort_unstable();
    let many = files.len().saturating_sub(MOST_KEPT);
    for (_, path) in files.drain(..many) {
        // One that stays is tried again next time.
        let _ = std::fs::remove_file(path);
    }
}

/// Programs for scans count upwards along the third axis; those for pictures, whose formats OBJ and glTF are, and tracers of neurons along the second.
pub(crate) fn stands_on_its_third_axis(format: Format) -> bool {
    !matches!(
        format,
        Format::Obj | Format::Gltf | Format::Glb | Format::Swc
    )
}

/// Endings of the files that are offered.
pub(super) const ENDINGS: [&str; 8] = ["glb", "gltf", "obj", "ply", "stl", "swc", "vtk", "vtp"];
/// Most files that are offered.
const MOST_OFFERED: usize = 100;

/// The files with such endings in a folder and in its folder `models`, as the project in it would name them.
pub(super) fn offered(folder: &Path, endings: &[&str]) -> Vec<String> {
    let mut files: Vec<String> = ["", "models/"]
        .into_iter()
        .flat_map(|below| {
            let entries = std::fs::read_dir(folder.join(below)).into_iter().flatten();
            entries.flatten().filter_map(move |entry| {
                let name = entry.file_name().into_string().ok()?;
                let ending = Path::new(&name).extension()?.to_str()?.to_lowercase();
                endings
                    .contains(&&*ending)
                    .then(|| format!("{below}{name}"))
            })
        })
        .collect();
    files.sort_unstable();
    files.truncate(MOST_OFFERED);
    files
}

/// As a project in this folder names a file: from the folder where it is below it.
pub(super) fn named(path: &Path, folder: Option<&Path>) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = folder.and_then(|folder| std::path::absolute(folder).ok());
    let below = folder.and_then(|folder| whole.strip_prefix(folder).ok().map(Path::to_owned));
    below.unwrap_or(whole).to_string_lossy().into_owned()
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// A tetrahedron.
    pub(crate) const TETRAHEDRON: &str =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

    #[test]
    fn files_are_read_one_after_the_other_and_each_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        std::fs::write(&path, TETRAHEDRON).unwrap();
        let mut scans = Scans::start().unwrap();
        let scan = |file: &str, comes| Scan {
            file: file.to_owned(),
            path: folder.path().join(file),
            mends: Vec::new(),
            likeness: None,
            cache: None,
            comes,
        };
        assert!(scans.ask(scan("a.obj", true)) && scans.ask(scan("a.obj", true)));
        assert!(scans.ask(scan("none.obj", false)));
        assert!(scans.is_busy());
        let (first, read) = scans.wait().unwrap();
        let read = read.unwrap();
        assert!(first.comes && !read.z_up && read.unit == Unit::Metres);
        assert_eq!(read.model.plain.mesh.triangles.len(), 4);
        assert!(read.model.faults.is_empty(), "{:?}", read.model.faults);
        let (second, read) = scans.wait().unwrap();
        assert_eq!(second.file, "none.obj");
        assert!(read.unwrap_err().contains("none.obj"));
        assert!(scans.wait().is_none() && scans.poll().is_none() && !scans.is_busy());
    }

    #[test]
    fn stages_tell_how_far_the_whole_is() {
        let progress = Progress::default();
        let far = || progress.0.load(Ordering::Relaxed);
        let mut stage = progress.stage([300, 450]);
        assert_eq!(far(), 300);
        stage(1, 2);
        assert_eq!(far(), 375);
        stage(9, 2);
        assert_eq!(far(), 450, "no farther than its end");
        stage(0, 0);
        assert_eq!(far(), 300, "of nothing");
    }

    #[test]
    fn a_large_model_is_found_in_the_cache_the_next_time() {
        let folder = tempfile::tempdir().unwrap();
        let (kept, never) = (folder.path().join("kept"), AtomicBool::new(false));
        let picked = |mesh: &Arc<Mesh>| kept_picker(mesh, &kept, &never, &mut |_, _| ()).unwrap();
        let small = Arc::new(mesh::made::sphere(3));
        picked(&small);
        assert!(!folder.path().join("kept").exists(), "small ones need none");
        let large = Arc::new(mesh::made::torus(400, 130));
        let hit = |picker: &Picker| picker.ray(glam::Vec3::X * 9.0, glam::Vec3::NEG_X, 99.0);
        let first = hit(&picked(&large));
        let files = || {
            std::fs::read_dir(folder.path().join("kept"))
                .unwrap()
                .count()
        };
        assert_eq!((files(), first.is_some()), (1, true));
        assert_eq!(hit(&picked(&large)), first);
        assert_eq!(files(), 1);
        // The oldest go.
        for number in 0..MOST_KEPT + 5 {
            let name = folder.path().join(format!("kept/{number}.{CACHED}"));
            std::fs::write(name, "").unwrap();
        }
        std::fs::write(folder.path().join("kept/notes.txt"), "").unwrap();
        forget_the_oldest(&folder.path().join("kept"));
        assert_eq!(files(), MOST_KEPT + 1, "and nothing else");
    }

    #[test]
    fn a_skeleton_is_seen_inside_the_surface_that_is_made_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("neuron.swc");
        std::fs::write(&path, "1 1 90 0 0 2 -1\n2 1 90 10 0 2 1\n3 1 95 18 0 1 2\n").unwrap();
        let scan = Scan {
            file: "neuron.swc".to_owned(),
            path,
            mends: Vec::new(),
            likeness: None,
            cache: None,
            comes: true,
        };
        let read = look(&scan, &Progress::default(), &AtomicBool::new(false)).unwrap();
        let model = read.model;
        let (line, _) = model.centerline.unwrap();
        assert!(line.low.cmpge(model.plain.low).all() && line.high.cmple(model.plain.high).all());
    }

    #[test]
    fn what_lies_in_one_place_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("point.obj");
        std::fs::write(&path, "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n").unwrap();
        let scan = Scan {
            file: "point.obj".to_owned(),
            path,
            mends: Vec::new(),
            likeness: None,
            cache: None,
            comes: true,
        };
        let told = look(&scan, &Progress::default(), &AtomicBool::new(false)).unwrap_err();
        assert!(told.contains("in one place"), "{told}");
    }

    #[test]
    fn models_beside_the_project_are_offered_and_named_from_there() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("models")).unwrap();
        for file in ["duct.STL", "models/airway.ply", "tree.ramus", "notes.txt"] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        assert_eq!(
            offered(folder.path(), &ENDINGS),
            ["duct.STL", "models/airway.ply"]
        );
        assert!(offered(&folder.path().join("nowhere"), &ENDINGS).is_empty());
        let below = folder.path().join("models/airway.ply");
        assert_eq!(named(&below, Some(folder.path())), "models/airway.ply");
        assert_eq!(
            named(&below, Some(Path::new("/elsewhere"))),
            below.to_string_lossy()
        );
        assert_eq!(named(&below, None), below.to_string_lossy());
    }
}
