//! The tasks of a study: a file with their texts, times and pictures, or those that Ramus brings along.

use std::io::{BufReader, Read as _};
use std::path::{Component, Path};

use anyhow::{Context as _, Result, anyhow, ensure};
use image::imageops::{FilterType, overlay};
use image::{ImageReader, Limits, Rgba, RgbaImage};
use serde::{Deserialize, Serialize};

use super::{TASKS_MOST, check_name};
use crate::app::cohort::entries::text_of;
use crate::tree::file::write_atomically;
use crate::ui::Thumbnail;
use crate::world::study::flow::{Plan, SECONDS_MOST, Task};
use crate::world::study::score::OWN_ITEMS_MOST;

/// What a file of tasks says it is.
pub const FORMAT: &str = "ramus-study-tasks/1";
/// The name of a sitting's file of tasks.
pub const TASKS: &str = "tasks.json";
/// Longest text of a task, in letters; of a statement. More fits no page.
const TEXT_MOST: [usize; 2] = [200, 100];
/// Pixels of a side of a picture as it is shown.
const SIDE: u32 = 512;
/// Pixels of a side of a picture as it may come.
const SIDE_MOST: u32 = 8192;
/// Longest file of a picture, in bytes.
const BYTES_MOST: u64 = 64 << 20;

/// A file of tasks.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Form {
    format: String,
    tasks: Vec<Task>,
    #[serde(default)]
    statements: Vec<String>,
}

/// Tasks and what is to be made, a picture a task.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// The tasks.
    pub plan: Plan,
    /// In their order.
    pub pictures: Vec<Option<Thumbnail>>,
}

impl Told {
    /// The tasks that Ramus brings along: three trees, each a little harder.
    ///
    /// # Errors
    /// Where a picture that is built in is broken, which a test excludes.
    pub fn own() -> Result<Self> {
        let tasks = OWN.map(|own| Task {
            name: own.name.to_owned(),
            text: own.text.to_owned(),
            german: Some(own.german.to_owned()),
            seconds: own.seconds,
            picture: Some(picture_name(own.name)),
        });
        let picture = |own: &Own| picture(own.picture).map(Some);
        Ok(Self {
            plan: Plan {
                tasks: tasks.into(),
                statements: Vec::new(),
            },
            pictures: OWN.iter().map(picture).collect::<Result<_>>()?,
        })
    }

    /// Reads a file of tasks, and the pictures beside it.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let text = text_of(path, "file of tasks")?;
        let plan = plan(&text).with_context(|| name.to_string())?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let pictures = plan.tasks.iter().map(|task| {
            let Some(file) = &task.picture else {
                return Ok(None);
            };
            let file = folder.join(file);
            let read = || -> Result<Thumbnail> { picture(&bytes_of(&file)?) };
            read()
                .map(Some)
                .with_context(|| format!("{} cannot be shown", file.display()))
        });
        let pictures = pictures.collect::<Result<_>>()?;
        Ok(Self { plan, pictures })
    }

    /// Writes tasks and pictures into a folder, so that a sitting can be gone on with whatever becomes of the files it was begun with.
    ///
    /// # Errors
    /// Where the disk does not take them.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let mut plan = self.plan.clone();
        for (task, picture) in plan.tasks.iter_mut().zip(&self.pictures) {
            task.picture = picture.as_ref().map(|_| picture_name(&task.name));
            if let (Some(name), Some(picture)) = (&task.picture, picture) {
                write_atomically(&folder.join(name), &png(picture)?)?;
            }
        }
        let form = Form {
            format: FORMAT.to_owned(),
            tasks: plan.tasks,
            statements: plan.statements,
        };
        let text = serde_json::to_string_pretty(&form)? + "\n";
        Ok(write_atomically(&folder.join(TASKS), text.as_bytes())?)
    }

    /// Whether other tasks ask the same, whatever their pictures are called.
    pub fn asks_as(&self, other: &Self) -> bool {
        let without = |plan: &Plan| {
            let mut plan = plan.clone();
            plan.tasks.iter_mut().for_each(|task| task.picture = None);
            plan
        };
        without(&self.plan) == without(&other.plan)
    }
}

/// The file of a task's picture.
fn picture_name(task: &str) -> String {
    format!("picture-{task}.png")
}

/// A task that is built in.
struct Own {
    name: &'static str,
    text: &'static str,
    german: &'static str,
    seconds: f64,
    picture: &'static [u8],
}

/// The pictures are those of `assets/study/NAME.lsys`, as `ramus derive NAME.lsys --png NAME.png --size 512 --backdrop paper` draws them.
const OWN: [Own; 3] = [
    Own {
        name: "fork",
        text: "Draw a trunk with two branches, and let it grow, so that the full-size tree looks like this.",
        german: "Einen Stamm mit zwei Zweigen zeichnen und wachsen lassen, so dass der große Baum so aussieht.",
        seconds: 300.0,
        picture: include_bytes!("../../../assets/study/fork.png"),
    },
    Own {
        name: "fern",
        text: "Make a plant like this: its branches stand in two rows and become shorter towards the tip.",
        german: "So eine Pflanze machen: Ihre Zweige stehen in zwei Reihen und werden zur Spitze hin kürzer.",
        seconds: 480.0,
        picture: include_bytes!("../../../assets/study/fern.png"),
    },
    Own {
        name: "tree",
        text: "Make a tree like this one, as near as you come in the time.",
        german: "So einen Baum machen, so ähnlich, wie es in der Zeit geht.",
        seconds: 600.0,
        picture: include_bytes!("../../../assets/study/tree.png"),
    },
];

/// Reads the text of a file of tasks.
///
/// # Errors
/// What is wrong with it.
pub fn plan(text: &str) -> Result<Plan> {
    let form: Form = serde_json::from_str(text)
        .map_err(|error| anyhow!("no tasks can be read there ({error})"))?;
    ensure!(
        form.format == FORMAT,
        "its format is {:?} and not {FORMAT:?}",
        form.format.chars().take(40).collect::<String>()
    );
    let plan = Plan {
        tasks: form.tasks,
        statements: form.statements,
    };
    check(&plan)?;
    Ok(plan)
}

fn check(plan: &Plan) -> Result<()> {
    ensure!(
        plan.tasks.len() <= TASKS_MOST,
        "there are more than {TASKS_MOST} tasks"
    );
    ensure!(
        plan.statements.len() <= OWN_ITEMS_MOST,
        "there are more than {OWN_ITEMS_MOST} statements"
    );
    let [of_task, of_statement] = TEXT_MOST;
    for (place, task) in plan.tasks.iter().enumerate() {
        let name = &task.name;
        check_name("task", name)?;
        let is_twice = plan.tasks[..place].iter().any(|other| other.name == *name);
        ensure!(!is_twice, "the task {name} is there twice");
        for text in [Some(&task.text), task.german.as_ref()]
            .into_iter()
            .flatten()
        {
            check_text(&format!("the text of the task {name}"), text, of_task)?;
        }
        ensure!(
            task.seconds >= 1.0 && task.seconds <= SECONDS_MOST,
            "the task {name} has {} seconds: write 1 to {SECONDS_MOST}",
            task.seconds
        );
        let inside = |file: &String| {
            let mut parts = Path::new(file).components();
            parts.all(|part| matches!(part, Component::Normal(_)))
        };
        ensure!(
            task.picture.as_ref().is_none_or(inside),
            "the picture of the task {name} is not beside or below the file of the tasks"
        );
    }
    for (place, text) in plan.statements.iter().enumerate() {
        check_text(&format!("statement {}", place + 1), text, of_statement)?;
    }
    Ok(())
}

/// A text that fits its place on the panel.
fn check_text(what: &str, text: &str, most: usize) -> Result<()> {
    let letters = text.chars().count();
    ensure!(
        (1..=most).contains(&letters),
        "{what} has {letters} letters: write 1 to {most}"
    );
    Ok(())
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    ensure!(path.metadata()?.is_file(), "it is no file");
    let mut bytes = Vec::new();
    std::fs::File::open(path)?
        .take(BYTES_MOST + 1)
        .read_to_end(&mut bytes)?;
    ensure!(
        bytes.len() as u64 <= BYTES_MOST,
        "it is longer than {BYTES_MOST} bytes"
    );
    Ok(bytes)
}

/// A picture as panels show it: square, with paper where it has none.
fn picture(bytes: &[u8]) -> Result<Thumbnail> {
    let mut reader =
        ImageReader::new(BufReader::new(std::io::Cursor::new(bytes))).with_guessed_format()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(SIDE_MOST);
    limits.max_image_height = Some(SIDE_MOST);
    reader.limits(limits);
    let read = reader.decode();
    let read = read.map_err(|error| {
        anyhow!("it is no PNG or JPEG of at most {SIDE_MOST} pixels a side ({error})")
    })?;
    let fitted = read.resize(SIDE, SIDE, FilterType::Triangle).into_rgba8();
    let mut square = RgbaImage::from_pixel(SIDE, SIDE, Rgba([255; 4]));
    let middle = |side: u32| i64::from((SIDE - side.min(SIDE)) / 2);
    overlay(
        &mut square,
        &fitted,
        middle(fitted.width()),
        middle(fitted.height()),
    );
    Ok(Thumbnail {
        side: SIDE as usize,
        rgba: square.into_raw(),
    })
}

fn png(picture: &Thumbnail) -> Result<Vec<u8>> {
    let side = u32::try_from(picture.side)?;
    let image = RgbaImage::from_raw(side, side, picture.rgba.clone());
    let image = image.context("a picture has other pixels than it says")?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use serde_json::{Value, json};

    use super::*;
    use crate::app::sentence;

    #[test]
    fn what_is_brought_along_is_written_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let own = Told::own().unwrap();
        check(&own.plan).unwrap();
        own.write(folder.path()).unwrap();
        let again = Told::read(&folder.path().join(TASKS)).unwrap();
        assert!(again.asks_as(&own));
        assert_eq!(again.pictures, own.pictures);
        for picture in own.pictures.iter().flatten() {
            let dark = picture
                .rgba
                .chunks(4)
                .filter(|pixel| pixel[1] < 200)
                .count();
            assert!(dark > 1000, "there is something on it");
        }
    }

    #[test]
    fn what_is_wrong_with_tasks_is_told() {
        let task = json!({"name": "a", "text": "Draw.", "seconds": 60, "picture": "a.png"});
        let with = |key: &str, value: Value| {
            let mut task = task.clone();
            task[key] = value;
            json!([task])
        };
        let many: Vec<Value> = (0..51)
            .map(|n| json!({"name": format!("t{n}"), "text": "D", "seconds": 1}))
            .collect();
        for (tasks, expected) in [
            (with("name", json!("a/b")), "is not of letters"),
            (
                with("text", json!("")),
                "the text of the task a has 0 letters",
            ),
            (
                with("german", json!("ü".repeat(201))),
                "has 201 letters: write 1 to 200",
            ),
            (with("seconds", json!(0)), "has 0 seconds"),
            (with("seconds", json!(1e9)), "has 1000000000 seconds"),
            (with("picture", json!("../a.png")), "is not beside or below"),
            (with("picture", json!("/a.png")), "is not beside or below"),
            (with("pictur", json!("a.png")), "unknown field `pictur`"),
            (json!([task, task]), "the task a is there twice"),
            (json!(many), "more than 50 tasks"),
        ] {
            let text = json!({"format": FORMAT, "tasks": tasks}).to_string();
            let told = sentence(&plan(&text).unwrap_err());
            assert!(told.contains(expected), "{expected}: {told}");
        }
        for (text, expected) in [
            ("", "no tasks can be read"),
            (
                "{\"format\":\"ramus-study-tasks/2\",\"tasks\":[]}",
                "its format is",
            ),
            (
                "{\"format\":\"ramus-study-tasks/1\",\"tasks\":[],\"statements\":[\"\"]}",
                "statement 1 has 0",
            ),
        ] {
            let told = sentence(&plan(text).unwrap_err());
            assert!(told.contains(expected), "{expected}: {told}");
        }
    }

    #[test]
    fn a_picture_that_is_none_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.json");
        let task = json!({"name": "a", "text": "Draw.", "seconds": 60, "picture": "a.png"});
        std::fs::write(
            &path,
            json!({"format": FORMAT, "tasks": [task]}).to_string(),
        )
        .unwrap();
        let told = sentence(&Told::read(&path).unwrap_err());
        assert!(told.contains("a.png cannot be shown"), "{told}");
        std::fs::write(folder.path().join("a.png"), b"\x89PNG\r\n\x1a\n").unwrap();
        let told = sentence(&Told::read(&path).unwrap_err());
        assert!(told.contains("it is no PNG or JPEG"), "{told}");
        let wide = RgbaImage::from_pixel(40, 10, Rgba([9, 9, 9, 255]));
        wide.save(folder.path().join("a.png")).unwrap();
        let read = Told::read(&path).unwrap();
        let picture = read.pictures[0].as_ref().unwrap();
        let at = |x: usize, y: usize| picture.rgba[(y * picture.side + x) * 4];
        assert_eq!([at(5, 5), at(256, 256), at(256, 500)], [255, 9, 255]);
    }
}
