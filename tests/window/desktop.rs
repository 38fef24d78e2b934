//! A desktop for tests: an X server without a screen, and programs in it that are clicked and typed at.

use std::{
    fs::{self, File},
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use glam::Vec2;
use image::{Rgb, RgbImage};
use tempfile::TempDir;

/// Longest wait for anything: drawing by the processor on a machine that others use.
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until something is so.
pub(crate) fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// An X server.
pub(crate) struct Desktop {
    server: Child,
    display: String,
    /// Where the server keeps its screen as a file.
    screen: TempDir,
}

impl Desktop {
    /// Starts one; none where the programs for it are missing, which away from CI skips the test.
    pub(crate) fn start() -> Option<Self> {
        for (program, flag) in [("Xvfb", "-help"), ("xdotool", "version")] {
            if Command::new(program).arg(flag).output().is_err() {
                println!("skipped: no {program} here; on Debian: apt-get install xvfb xdotool");
                assert!(
                    std::env::var_os("CI").is_none_or(|ci| ci != "true"),
                    "CI has {program}"
                );
                return None;
            }
        }
        let screen = tempfile::tempdir().unwrap();
        let mut server = Command::new("Xvfb")
            .args([
                // Else it begins anew when its last client leaves, and turns away whoever comes meanwhile.
                "-noreset",
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1280x800x24",
                "-nolisten",
                "tcp",
                "-fbdir",
            ])
            .arg(screen.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut number)
            .unwrap();
        Some(Self {
            server,
            display: format!(":{}", number.trim()),
            screen,
        })
    }

    /// The program, to be given arguments.
    pub(crate) fn program(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ramus"));
        command
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("RAMUS_VALIDATION", "1")
            .stdout(Stdio::null());
        command
    }

    /// Runs it until its window, with this in its title, is there and has the keyboard; what it says on standard error goes into
    /// the file `log`.
    pub(crate) fn run(&self, command: &mut Command, title: &str, log: &Path) -> Program {
        let mut program = Program {
            child: command.stderr(File::create(log).unwrap()).spawn().unwrap(),
            display: self.display.clone(),
            window: String::new(),
            log: log.to_owned(),
        };
        until("its window comes", || {
            let ended = program.child.try_wait().unwrap();
            let said = || fs::read_to_string(log).unwrap_or_default();
            assert!(ended.is_none(), "it ended ({ended:?}): {}", said());
            program.window = program.xdotool(&["search", "--onlyvisible", "--name", title]);
            !program.window.is_empty()
        });
        let window = program.window.clone();
        program.xdotool(&["windowfocus", &window]);
        program
    }

    /// What the screen shows: XWD, a head of big-endian words before 32 bits a pixel.
    pub(crate) fn screen(&self) -> RgbImage {
        let bytes = fs::read(self.screen.path().join("Xvfb_screen0")).unwrap();
        let word = |at: usize| u32::from_be_bytes(bytes[4 * at..4 * at + 4].try_into().unwrap());
        let (head, width, height, line, colors) = (word(0), word(4), word(5), word(12), word(19));
        let pixels = &bytes[(head + 12 * colors) as usize..];
        RgbImage::from_fn(width, height, |x, y| {
            let at = (y * line + 4 * x) as usize;
            Rgb([pixels[at + 2], pixels[at + 1], pixels[at]])
        })
    }
}

impl Drop for Desktop {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A program with its window.
pub(crate) struct Program {
    child: Child,
    display: String,
    window: String,
    log: PathBuf,
}

impl Program {
    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn at(&self, place: Vec2, then: &[&str]) {
        let [x, y] = place.to_array().map(|value| format!("{value:.0}"));
        let mut arguments = vec!["mousemove", "--window", &self.window, &x, &y];
        arguments.extend(then);
        self.xdotool(&arguments);
    }

    /// Clicks at a place in the window, pixels.
    pub(crate) fn click(&self, place: Vec2) {
        self.at(place, &["click", "1"]);
    }

    /// Drags with a button in some steps.
    pub(crate) fn drag(&self, button: u8, from: Vec2, to: Vec2) {
        let button = button.to_string();
        self.at(from, &["mousedown", &button]);
        for part in 1..=8_u8 {
            self.at(from.lerp(to, f32::from(part) / 8.0), &["sleep", "0.05"]);
        }
        self.at(to, &["mouseup", &button]);
    }

    pub(crate) fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    pub(crate) fn resize(&self, width: u32, height: u32) {
        let (width, height) = (width.to_string(), height.to_string());
        self.xdotool(&["windowsize", "--sync", &self.window, &width, &height]);
    }

    /// The picture that the program keeps in this file.
    pub(crate) fn picture(&self, file: &Path) -> RgbImage {
        self.key("p");
        until("the picture is there", || file.exists());
        image::open(file).unwrap().to_rgb8()
    }

    /// Processor time that it takes in so many seconds, once it rests.
    pub(crate) fn processor_seconds(&self, seconds: u64) -> f64 {
        let used = || {
            let stat = fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap();
            // Behind the name in brackets: user and system time are the 12th and 13th.
            let rest = stat.rsplit(')').next().unwrap();
            let ticks = rest.split_whitespace().skip(11).take(2);
            ticks
                .map(|ticks| ticks.parse::<f64>().unwrap())
                .sum::<f64>()
                / 100.0
        };
        // The last message goes from the board.
        std::thread::sleep(Duration::from_secs(12));
        let before = used();
        std::thread::sleep(Duration::from_secs(seconds));
        used() - before
    }

    /// Ends it by a key and gives what it said on standard error.
    pub(crate) fn end(self, key: &str) -> String {
        self.key(key);
        self.ended()
    }

    /// Waits until it ends in good order and gives what it said on standard error besides how far it is.
    pub(crate) fn ended(mut self) -> String {
        until("it ends", || self.child.try_wait().unwrap().is_some());
        let said = fs::read_to_string(&self.log).unwrap();
        let status = self.child.wait().unwrap();
        assert!(status.success(), "{status}: {said}");
        let lines = said.lines().filter(|line| !line.starts_with("playing: "));
        lines.collect::<Vec<_>>().join("\n")
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
