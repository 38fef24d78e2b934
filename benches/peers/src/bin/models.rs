//! Models read beside trimesh, PyVista (VTK) and meshio from PyPI, in one run: `models PYTHON FOLDER [FORMAT]`.
//!
//! `scripts/peers.sh`, which `make bench` calls, and which puts the libraries there. The same surface of 1.3 million triangles is
//! written into FOLDER in each format. Each library reads it in a process of its own for each file, which has read it once before it is
//! timed and answers line by line (`models.py`), so all take turns; files are in the system's cache, threads are as each has them.
//!
//! "Ready to draw" is parsed, checked, vertices of one place joined, and a normal at each. What all have made is compared: numbers of
//! triangles, and of vertices where they are joined.

#[path = "../../../ring/mod.rs"]
mod ring;

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::Vec3;
use ramus::mesh::display::Display;
use ramus::mesh::write::WriteFormat;
use ramus::mesh::{self, Mesh, ReadLimits};

/// Turns.
const TURNS: usize = 5;
/// How many times as fast as trimesh models are to be ready to draw.
const GOAL: f64 = 5.0;
/// The libraries, as `models.py` knows them.
const PEERS: [&str; 3] = ["trimesh", "pyvista", "meshio"];

/// Writes a surface.
type Writer = fn(&mut BufWriter<File>, &Mesh);

/// Names of files, what they are, and who writes them.
const FILES: [(&str, &str, Writer); 8] = [
    ("binary.ply", "binary PLY", |to, ring| {
        WriteFormat::Ply.write(ring, to).unwrap();
    }),
    ("ascii.ply", "ASCII PLY", ring::ascii_ply),
    ("binary.stl", "binary STL", |to, ring| {
        WriteFormat::Stl.write(ring, to).unwrap();
    }),
    ("ring.obj", "OBJ", |to, ring| {
        WriteFormat::Obj.write(ring, to).unwrap();
    }),
    ("ring.glb", "GLB", |to, ring| {
        WriteFormat::Glb.write(ring, to).unwrap();
    }),
    ("raw.vtp", "raw VTP", ring::raw_vtp),
    ("old.vtk", "binary VTK", ring::binary_vtk),
    ("new.vtk", "binary VTK 5.1", ring::new_binary_vtk),
];

/// What is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Task {
    Parse,
    Draw,
}

/// One run.
#[derive(Clone, Copy)]
struct Run {
    seconds: f64,
    triangles: usize,
    vertices: usize,
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(python), Some(folder)) = (arguments.next(), arguments.next()) else {
        println!("usage: models PYTHON FOLDER [FORMAT]");
        return ExitCode::FAILURE;
    };
    // A part of a format's name; all without one.
    let wanted = arguments.next().unwrap_or_default();
    let ring = ring::ring();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "\nmodels of {} triangles, medians of {TURNS} turns in ms, {cores} cores",
        ring.triangles.len()
    );
    println!(
        "{:14} {:7} {:>8} {:>9} {:>9} {:>9} {:>16}",
        "", "", "ramus", "trimesh", "pyvista", "meshio", "ratio"
    );
    let (mut missed, mut differing) = (Vec::new(), Vec::new());
    for (name, format, write) in FILES.into_iter().filter(|file| file.1.contains(&wanted)) {
        let path = Path::new(&folder).join(name);
        let mut to = BufWriter::new(File::create(&path).unwrap());
        write(&mut to, &ring);
        to.flush().unwrap();
        drop(to);
        let mut peers = PEERS.map(|peer| Peer::start(&python, peer));
        for task in [Task::Parse, Task::Draw] {
            let line = line(task, format, &turns(task, &path, &mut peers), &ring);
            println!("{}", line.text);
            missed.extend(line.missed);
            differing.extend(line.differing);
        }
        std::fs::remove_file(path).unwrap();
    }
    if !missed.is_empty() {
        println!("missed: {}", missed.join(", "));
    }
    if differing.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!(
        "they made different things of one file: {}",
        differing.join(", ")
    );
    ExitCode::FAILURE
}

/// A row of the table.
struct Line {
    text: String,
    missed: Option<String>,
    differing: Vec<String>,
}

/// All runs of ours and of each library, ours between theirs.
fn turns(task: Task, path: &Path, peers: &mut [Option<Peer>; 3]) -> [Vec<Run>; 4] {
    let mut runs: [Vec<Run>; 4] = Default::default();
    // The first turn warms up; a library that cannot do it is asked no more.
    for turn in 0..=TURNS {
        for (at, peer) in peers.iter_mut().enumerate() {
            let own = ours(task, path);
            let able = turn == 0 || !runs[at + 1].is_empty();
            let theirs = peer.as_mut().filter(|_| able);
            let theirs = theirs.and_then(|peer| peer.run(task, path));
            if turn == 1 {
                runs[at + 1].clear();
            }
            if turn > 0 {
                runs[0].push(own);
            }
            runs[at + 1].extend(theirs);
        }
    }
    runs
}

fn line(task: Task, format: &str, runs: &[Vec<Run>; 4], ring: &Mesh) -> Line {
    let times = runs.each_ref().map(|runs| median(runs));
    let ours = times[0].unwrap_or(f64::NAN);
    let peers = ["ramus"].into_iter().chain(PEERS);
    let differing: Vec<String> = peers
        .zip(runs)
        .filter_map(|(peer, runs)| difference(task, runs, ring).map(|text| (peer, text)))
        .map(|(peer, text)| format!("{format} by {peer}: {text}"))
        .collect();
    let (what, beside, factor) = match task {
        Task::Parse => {
            let fastest = (1..4).filter(|&at| times[at].is_some());
            let fastest = fastest.min_by(|a, b| times[*a].partial_cmp(&times[*b]).unwrap());
            ("parsed", fastest, 1.0)
        }
        Task::Draw => ("drawn", times[1].map(|_| 1), GOAL),
    };
    let ratio = beside.and_then(|at| Some((PEERS[at - 1], times[at]? / ours)));
    let shown =
        times.map(|time| time.map_or("–".to_owned(), |time| format!("{:.1}", 1e3 * time)));
    let [own, trimesh, pyvista, meshio] = shown;
    let told = ratio.map_or("–".to_owned(), |(peer, ratio)| {
        format!("{peer} ×{ratio:.2}")
    });
    let mark = if differing.is_empty() {
        ""
    } else {
        "  (differs)"
    };
    Line {
        text: format!(
            "{format:14} {what:7} {own:>8} {trimesh:>9} {pyvista:>9} {meshio:>9} {told:>16}{mark}"
        ),
        missed: ratio
            .filter(|(_, ratio)| *ratio < factor)
            .map(|(peer, ratio)| format!("{format} {what} ({peer} ×{ratio:.2} of {factor})")),
        differing,
    }
}

/// What a library made that is not the surface.
fn difference(task: Task, runs: &[Run], ring: &Mesh) -> Option<String> {
    let expected = (ring.triangles.len(), ring.positions.len());
    runs.iter().find_map(|run| {
        let (triangles, vertices) = (run.triangles, run.vertices);
        // While nobody joins them, vertices may be as many as corners.
        let is_same = triangles == expected.0 && (task == Task::Parse || vertices == expected.1);
        (!is_same).then(|| format!("{triangles} triangles and {vertices} vertices"))
    })
}

fn median(runs: &[Run]) -> Option<f64> {
    let mut seconds: Vec<f64> = runs.iter().map(|run| run.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied()
}

fn ours(task: Task, path: &Path) -> Run {
    let never = AtomicBool::new(false);
    let start = Instant::now();
    let model = mesh::read(path, &ReadLimits::default(), &never).expect("a model of ours");
    if task == Task::Parse {
        let seconds = start.elapsed().as_secs_f64();
        return run(seconds, &model.mesh, model.mesh.positions.len());
    }
    let display = Display::bare(Arc::new(model.mesh), &never).expect("nobody stops it");
    let seconds = start.elapsed().as_secs_f64();
    // Vertices of one place share a normal; so many places there are.
    let key = |position: &Vec3| (*position + Vec3::ZERO).to_array().map(f32::to_bits);
    let places: HashSet<[u32; 3]> = display.mesh.positions.iter().map(key).collect();
    assert_eq!(
        display.normals.len(),
        display.mesh.positions.len(),
        "a normal for each vertex"
    );
    run(seconds, &display.mesh, places.len())
}

fn run(seconds: f64, mesh: &Mesh, vertices: usize) -> Run {
    Run {
        seconds,
        triangles: mesh.triangles.len(),
        vertices,
    }
}

/// A process of a library.
struct Peer {
    process: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    fn start(python: &str, library: &str) -> Option<Self> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/models.py");
        let mut process = Command::new(python)
            .args([script, library])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let questions = process.stdin.take();
        let answers = BufReader::new(process.stdout.take()?);
        Some(Self {
            process,
            questions,
            answers,
        })
    }

    /// One run; none where the library does not know how to.
    fn run(&mut self, task: Task, path: &Path) -> Option<Run> {
        let word = match task {
            Task::Parse => "parse",
            Task::Draw => "draw",
        };
        writeln!(self.questions.as_mut()?, "{word} {}", path.display()).ok()?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer).ok()?;
        let mut words = answer.split_whitespace();
        Some(Run {
            seconds: words.next()?.parse().ok()?,
            triangles: words.next()?.parse().ok()?,
            vertices: words.next()?.parse().ok()?,
        })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // The end of its questions ends it.
        self.questions = None;
        let _ = self.process.wait();
    }
}
