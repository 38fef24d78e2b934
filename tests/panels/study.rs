//! The sitting of a study, answered page by page by hands: what is written is what was answered.

use std::path::Path;

use glam::{Vec2, Vec3};
use ramus::app::opening::Opening;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::study::report::report;
use ramus::app::study::sitting::Sitting;
use ramus::app::study::{Outcome, Study, answers};
use ramus::app::workshop::Workshop;
use ramus::ui::words::{Language, StudyWords};
use ramus::world::panels::PanelId;
use ramus::world::study::flow::Page;
use ramus::world::study::score::{Factor, Part};
use ramus::world::{World, history::History};
use tempfile::TempDir;

use super::pictures::{draw as pictured, save, views};
use super::visitor::{LEFT, RIGHT, Visitor};

const PANEL: PanelId = PanelId::Study;

fn sitting(folder: &TempDir) -> Sitting {
    let sitting = Sitting::of(folder.path(), "P1", "ramus", None).unwrap();
    sitting.make_folder().unwrap();
    sitting
}

fn seated(folder: &TempDir) -> Visitor {
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    workshop.sit(sitting(folder)).unwrap();
    Visitor::at(workshop)
}

fn page(visitor: &Visitor) -> Page {
    visitor.workshop.world().study().unwrap().page()
}

/// Answers each question of the page by pulling the trigger at it; answers go round.
fn answer_all(visitor: &mut Visitor) {
    let Page::Questions(part, from, to) = page(visitor) else {
        return;
    };
    let [least, most] = part.range();
    for item in from..to {
        let value = given(part, item);
        assert!((least..=most).contains(&value));
        // Each question has each answer once, one below the other.
        let hand = if item % 2 == 0 { RIGHT } else { LEFT };
        visitor.click_nth(hand, PANEL, &value.to_string(), item - from + 1);
        let answered = visitor.workshop.world().study().unwrap();
        assert_eq!(answered.answer(part, item), Some(value), "{part:?} {item}");
    }
}

/// What is answered to an item.
fn given(part: Part, item: usize) -> u8 {
    let item = u8::try_from(item).unwrap();
    match part {
        Part::SsqBefore => item % 3,
        Part::SsqAfter => 3 - item % 4,
        Part::Sus | Part::Own => 1 + item % 5,
    }
}

fn next(visitor: &mut Visitor) {
    visitor.click(RIGHT, PANEL, "Next");
}

fn trunk(visitor: &mut Visitor) {
    visitor.tip_to(RIGHT, Vec3::new(0.0, 0.98, -0.55));
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    visitor.rest(RIGHT);
    visitor.frame();
}

#[test]
fn a_sitting_is_answered_by_hands_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = seated(&folder);
    assert!(visitor.says(PANEL, "Welcome"));
    next(&mut visitor);
    for _ in 0..2 {
        answer_all(&mut visitor);
        next(&mut visitor);
    }
    for (number, task) in ["fork", "fern", "tree"].into_iter().enumerate() {
        assert_eq!(page(&visitor), Page::Task(number));
        trunk(&mut visitor);
        visitor.click(LEFT, PANEL, "Begin");
        let strokes = |visitor: &Visitor| visitor.document().sketch.strokes[0].points.len();
        assert_eq!(strokes(&visitor), 0, "{task} begins with an empty stage");
        trunk(&mut visitor);
        assert_eq!(strokes(&visitor), 1);
        visitor.wait(1.5);
        let end = if number == 1 {
            "Leave it"
        } else {
            "It is done"
        };
        visitor.click(RIGHT, PANEL, end);
        next(&mut visitor);
    }
    while !visitor.workshop.world().study().unwrap().is_over() {
        answer_all(&mut visitor);
        next(&mut visitor);
    }
    assert!(visitor.says(PANEL, "Thank you"));
    visitor.workshop.rise().unwrap();
    let study = Study::read(folder.path(), false).unwrap();
    let sitting = &study.sittings[0];
    for part in [Part::SsqBefore, Part::Sus, Part::SsqAfter] {
        let items = part.items().unwrap();
        let expected: Vec<u8> = (0..items).map(|item| given(part, item)).collect();
        assert_eq!(sitting.whole(part).unwrap(), expected, "{part:?}");
    }
    let outcomes: Vec<Outcome> = sitting.tasks.iter().map(|task| task.outcome).collect();
    assert_eq!(outcomes, [Outcome::Done, Outcome::Left, Outcome::Done]);
    assert!(
        sitting
            .tasks
            .iter()
            .all(|task| (1.5..3.0).contains(&task.seconds)),
        "{:?}",
        sitting.tasks
    );
    let at = folder.path().join("P1/ramus");
    for file in [
        "answers.json",
        "tasks.json",
        "picture-fern.png",
        "task-fork.ramus",
        "task-tree.ramus",
    ] {
        assert!(at.join(file).is_file(), "{file}");
    }
    assert_eq!(answers::read(&at.join("answers.json")).unwrap().page, None);
    // 1 2 3 4 5 1 2 3 4 5: odd ones 0 2 4 1 3, even ones 3 1 4 2 0.
    let report = report(&study);
    let condition = &report.conditions[0];
    assert_eq!(condition.sus.as_ref().unwrap().summary.mean, 50.0);
    // 0 1 2 0 1 2 …: nausea is of 1, 6, 7, 8, 9, 15, 16, so 0 + 2 + 0 + 1 + 2 + 2 + 0.
    let nausea = condition
        .ssq
        .iter()
        .find(|one| one.factor == Factor::Nausea);
    assert_eq!(nausea.unwrap().before.unwrap().mean, 7.0 * 9.54);
    let again = Sitting::of(folder.path(), "P1", "ramus", None).unwrap_err();
    assert!(again.to_string().contains("has finished"), "{again}");
}

#[test]
fn what_is_left_open_is_told_and_one_can_go_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = seated(&folder);
    next(&mut visitor);
    visitor.click(RIGHT, PANEL, "2");
    next(&mut visitor);
    assert!(visitor.says(PANEL, "Without an answer: 7"));
    next(&mut visitor);
    assert_eq!(page(&visitor), Page::Questions(Part::SsqBefore, 8, 16));
    visitor.click(LEFT, PANEL, "Back");
    visitor.click(LEFT, PANEL, "3");
    visitor.workshop.rise().unwrap();
    // Whoever starts Ramus again is where they were, with what they said.
    let mut again = seated(&folder);
    assert!(again.says(PANEL, "2 / "));
    let study = again.workshop.world().study().unwrap();
    assert_eq!(study.answer(Part::SsqBefore, 0), Some(3));
    assert_eq!(again.frame.hands[LEFT].trigger, 0.0);
    again.click(LEFT, PANEL, "Back");
    assert_eq!(page(&again), Page::Welcome);
}

#[test]
fn a_task_s_time_runs_out_on_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let tasks = folder.path().join("tasks.json");
    let text = r#"{"format": "ramus-study-tasks/1", "statements": ["I saw enough."],
        "tasks": [{"name": "quick", "text": "Draw.", "seconds": 2}]}"#;
    std::fs::write(&tasks, text).unwrap();
    let sitting = Sitting::of(folder.path(), "P1", "ramus", Some(&tasks)).unwrap();
    sitting.make_folder().unwrap();
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    workshop.sit(sitting).unwrap();
    let mut visitor = Visitor::at(workshop);
    while page(&visitor) != Page::Task(0) {
        next(&mut visitor);
    }
    assert!(visitor.says(PANEL, "Time left: 0:02"));
    visitor.click(RIGHT, PANEL, "Begin");
    visitor.wait(1.2);
    assert!(visitor.says(PANEL, "Time left: 0:01"));
    // The menu of the system is before their eyes: no time passes.
    visitor.frame.focused = false;
    visitor.wait(5.0);
    visitor.frame.focused = true;
    visitor.wait(0.1);
    assert!(visitor.says(PANEL, "Time left: 0:01"));
    visitor.wait(1.0);
    assert!(visitor.says(PANEL, "The time is over."));
    while page(&visitor) != Page::Questions(Part::Own, 0, 1) {
        next(&mut visitor);
    }
    assert!(visitor.says(PANEL, "I saw enough."));
    answer_all(&mut visitor);
    visitor.workshop.rise().unwrap();
    let study = Study::read(folder.path(), false).unwrap();
    let task = &study.sittings[0].tasks[0];
    assert_eq!((task.seconds, task.outcome), (2.0, Outcome::TimeOver));
    assert_eq!(study.sittings[0].whole(Part::Own).unwrap(), [1]);
}

/// A recording says what the sitting began with: played again, the same hands give the same answers.
#[test]
fn a_recorded_sitting_plays_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = seated(&folder);
    let opening = Opening::of(&visitor.workshop);
    let from = visitor.frames.len();
    next(&mut visitor);
    answer_all(&mut visitor);
    next(&mut visitor);
    let frames = visitor.frames.split_off(from);
    let mut again = Workshop::unsaved(World::new(History::default())).unwrap();
    opening.apply(&mut again);
    for frame in &visitor.frames {
        again.update(frame);
    }
    for frame in &frames {
        again.update(frame);
    }
    let progress = |workshop: &Workshop| workshop.world().study().unwrap().progress().clone();
    assert_eq!(progress(&again), progress(&visitor.workshop));
    assert_eq!(progress(&again).page, 2);
}

#[test]
fn without_a_study_there_is_no_panel_of_one() {
    let mut visitor = Visitor::with_tree();
    assert!(!visitor.workshop.world().has_panel(PANEL));
    let scene = visitor.workshop.scene();
    assert!(scene.panels.iter().all(|panel| panel.slot != PANEL.slot()));
    assert!(
        !Opening::of(&visitor.workshop)
            .comments()
            .concat()
            .contains("study")
    );
}

/// Tasks and statements as long as they may be.
const LONGEST: [usize; 2] = [200, 100];

/// What fills most pages: Ramus' own tasks in each language, and the longest texts.
fn fullest(folder: &TempDir) -> Vec<(Sitting, Language)> {
    let [task, statement] = LONGEST.map(|most| {
        "mighty boughs "
            .chars()
            .cycle()
            .take(most)
            .collect::<String>()
    });
    let tasks = folder.path().join("tasks.json");
    let text = serde_json::json!({
        "format": "ramus-study-tasks/1", "statements": vec![statement; 5],
        "tasks": [{"name": "long", "text": task, "seconds": 86_400}],
    });
    std::fs::write(&tasks, text.to_string()).unwrap();
    let of = |code: &str, tasks: Option<&Path>| {
        Sitting::of(folder.path(), code, "ramus", tasks).unwrap()
    };
    vec![
        (of("E", None), Language::English),
        (of("G", None), Language::German),
        (of("L", Some(&tasks)), Language::German),
    ]
}

/// All of it is on the sheet: nothing stands over its edges, or over what is below.
#[test]
fn every_page_fits_its_panel_in_both_languages() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 900, 900).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (sitting, language) in fullest(&folder) {
        let code = sitting.participant.clone();
        sitting.make_folder().unwrap();
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        workshop.sit(sitting).unwrap();
        let mut visitor = Visitor::at(workshop);
        let mut settings = visitor.workshop.settings();
        settings.language = language;
        visitor.workshop.set(settings);
        visitor.frame();
        let words = language.study();
        let center = visitor.center(PANEL);
        let near = views(center + visitor.normal(PANEL) * 0.95, center);
        let stand = views(Vec3::new(0.0, 1.6, 0.35), Vec3::new(-0.15, 1.4, -1.0));
        for number in 0.. {
            if let (Page::Questions(part, 0, _), "E") = (page(&visitor), code.as_str()) {
                // As a page looks in the middle.
                for (value, nth) in [(1, 1), (2, 2), (1, 3)] {
                    let value = u8::to_string(&(value + part.range()[0]));
                    visitor.click_nth(RIGHT, PANEL, &value, nth);
                }
            }
            let image = pictured(&mut visitor, &mut picture, &near);
            save(&image, &format!("study-{code}-{number}.png"));
            let sheet = image::imageops::crop_imm(&image, 160, 80, 640, 740).to_image();
            save(&sheet, &format!("sheet-{code}-{number}.png"));
            if number == 3 {
                let image = pictured(&mut visitor, &mut picture, &stand);
                save(&image, &format!("study-{code}-stand.png"));
            }
            is_on_its_sheet(&visitor, words);
            if visitor.workshop.world().study().unwrap().is_over() {
                break;
            }
            // On through all pages, with questions open and tasks left.
            if let Page::Task(_) = page(&visitor) {
                visitor.click(RIGHT, PANEL, words.begin);
                is_on_its_sheet(&visitor, words);
                visitor.click(RIGHT, PANEL, words.leave);
            }
            let before = page(&visitor);
            visitor.click(RIGHT, PANEL, words.next);
            if page(&visitor) == before {
                is_on_its_sheet(&visitor, words);
                visitor.click(RIGHT, PANEL, words.next);
            }
            assert_ne!(page(&visitor), before);
        }
    }
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

/// Middles of texts are on the sheet, and those of the page above its footer, one below the other.
fn is_on_its_sheet(visitor: &Visitor, words: &StudyWords) {
    let size = Vec2::from(visitor.workshop.world().panel_size(PANEL));
    let told = words.missing.split("{}").next().unwrap_or_default();
    let footer = visitor
        .workshop
        .texts(PANEL)
        .find(|text| text.starts_with(told))
        .unwrap_or(words.back);
    let footer = visitor.find(PANEL, footer).y;
    for text in visitor.workshop.texts(PANEL) {
        let at = visitor.find(PANEL, text);
        let inside = at.cmpge(Vec2::splat(0.01)).all() && at.cmple(size - 0.01).all();
        assert!(inside, "{text} at {at}");
        let in_footer = [words.back, words.next].contains(&text) || text.starts_with(told);
        assert!(
            in_footer || at.y < footer - 0.042,
            "{text} is over the footer"
        );
    }
}
