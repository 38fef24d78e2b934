//! The tutorial's panel: what to do, with which part of the controller that is in hand, and a picture of it.

use egui::{
    Align, Color32, CornerRadius, FontId, Painter, Pos2, Rect, RichText, Stroke, StrokeKind, Ui,
    Vec2, pos2, text::LayoutJob, vec2,
};

use super::{
    panels::{View, Wish},
    theme::{INK, MESSAGE, PAPER, TITLE},
    words::{Language, Words},
};
use crate::world::{
    board::Buttons,
    lesson::{Lesson, Part},
};

/// Lays the lesson out.
pub(super) fn show(ui: &mut Ui, view: &View<'_>, wishes: &mut Vec<Wish>) {
    let language = view.settings.language;
    let words = language.words();
    let frame = egui::Frame::new().fill(PAPER).inner_margin(12.0);
    egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        let Some((number, lesson)) = view.lesson else {
            return;
        };
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(182.0);
                let place = format!("{} / {}", number + 1, Lesson::ALL.len());
                ui.label(RichText::new(place).color(MESSAGE));
                ui.label(RichText::new(title(lesson, words)).color(TITLE).size(20.0));
                ui.label(RichText::new(told(lesson, view.buttons, language)).size(16.0));
            });
            let room = vec2(ui.available_width(), 150.0);
            let (rect, _) = ui.allocate_exact_size(room, egui::Sense::empty());
            let name = part_name(lesson.part(), view.buttons, language);
            Drawing::new(ui.painter(), rect, view.buttons).draw(lesson.part(), &name);
        });
        ui.with_layout(egui::Layout::bottom_up(Align::Min), |ui| {
            ui.horizontal(|ui| {
                if ui
                    .add_enabled(number > 0, egui::Button::new(words.lesson_back))
                    .clicked()
                {
                    wishes.push(Wish::Teach(Some(number - 1)));
                }
                if ui.button(words.lesson_skip).clicked() {
                    wishes.push(Wish::Teach(Some(number + 1)));
                }
                if ui.button(words.lesson_stop).clicked() {
                    wishes.push(Wish::Teach(None));
                }
            });
        });
    });
}

fn title(lesson: Lesson, words: &Words) -> &'static str {
    texts(lesson, words).0
}

/// Title and text of a lesson.
fn texts(lesson: Lesson, words: &Words) -> (&'static str, &'static str) {
    match lesson {
        Lesson::Draw => (words.learn_draw, words.do_draw),
        Lesson::DrawOn => (words.learn_draw_on, words.do_draw_on),
        Lesson::FreeHand => (words.learn_free_hand, words.do_free_hand),
        Lesson::Branch => (words.learn_branch, words.do_branch),
        Lesson::Grow => (words.learn_grow, words.do_grow),
        Lesson::Back => (words.learn_back, words.do_back),
        Lesson::Move => (words.learn_move, words.do_move),
        Lesson::Delete => (words.learn_delete, words.do_delete),
        Lesson::Undo => (words.learn_undo, words.do_undo),
        Lesson::Redo => (words.learn_redo, words.do_redo),
        Lesson::Platform => (words.learn_platform, words.do_platform),
        Lesson::Lever => (words.learn_lever, words.do_lever),
        Lesson::Wheel => (words.learn_wheel, words.do_wheel),
        Lesson::Panel => (words.learn_panel, words.do_panel),
        Lesson::Wrist => (words.learn_wrist, words.do_wrist),
        Lesson::Stump => (words.learn_stump, words.do_stump),
    }
}

/// The sentence that says what to do; where the controller has no such part, how else it is done.
fn told(lesson: Lesson, buttons: &Buttons, language: Language) -> String {
    let words = language.words();
    let missing = match lesson.part() {
        Part::Grow => buttons.grow.is_none(),
        Part::Back => buttons.back.is_none(),
        Part::Undo => buttons.undo.is_none(),
        Part::Grab => buttons.grab.is_none(),
        Part::Draw | Part::Hand => false,
    };
    if missing {
        return words.do_on_bench.to_owned();
    }
    let draw = part_name(Part::Draw, buttons, language);
    let grab = part_name(Part::Grab, buttons, language);
    let part = part_name(lesson.part(), buttons, language);
    let text = match (lesson, &buttons.redo) {
        (Lesson::Undo, Some(_)) => words.do_undo_key,
        (Lesson::Redo, Some(_)) => words.do_redo_key,
        (Lesson::Draw, _) if buttons.desk => words.do_draw_desk,
        (Lesson::Panel, _) if buttons.desk => words.do_panel_desk,
        (Lesson::Platform, _) if buttons.desk => words.do_platform_desk,
        _ => texts(lesson, words).1,
    };
    text.replace("{redo}", buttons.redo.as_deref().unwrap_or_default())
        .replace("{draw}", &draw)
        .replace("{grab}", &grab)
        .replace("{part}", &part)
}

/// What people call a part, in a language.
fn part_name(part: Part, buttons: &Buttons, language: Language) -> String {
    let name = match part {
        Part::Draw => &buttons.draw,
        Part::Grab => &buttons.grab,
        Part::Grow => &buttons.grow,
        Part::Back => &buttons.back,
        Part::Undo => &buttons.undo,
        Part::Hand => &None,
    };
    name.as_ref()
        .map_or_else(String::new, |name| language.part(name))
}

/// Controllers as they are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A stick and two buttons on a plate.
    Stick,
    /// A stick alone, which does what the buttons would.
    StickAlone,
    /// A round touchpad on a wand.
    Wand,
    /// A touchpad on a short handle, a button at its shoulder.
    Shoulder,
    /// Two buttons.
    Simple,
    /// A bare hand.
    Hand,
    /// A pen.
    Pen,
    /// A mouse beside a keyboard.
    Mouse,
}

fn kind(buttons: &Buttons) -> Kind {
    let has = |name: &Option<String>, part: &str| {
        name.as_ref()
            .is_some_and(|name| name.to_lowercase().contains(part))
    };
    if buttons.desk {
        Kind::Mouse
    } else if has(&buttons.draw, "pinch") {
        Kind::Hand
    } else if has(&buttons.draw, "middle") {
        Kind::Pen
    } else if has(&buttons.draw, "select") {
        Kind::Simple
    } else if has(&buttons.grab, "shoulder") {
        Kind::Shoulder
    } else if has(&buttons.undo, "pad") {
        Kind::Wand
    } else if has(&buttons.grow, "stick") {
        Kind::StickAlone
    } else {
        Kind::Stick
    }
}

/// A controller drawn in outlines, in a square of 100 by 100.
struct Drawing<'a> {
    painter: &'a Painter,
    origin: Pos2,
    scale: f32,
    /// Room for the name, points.
    width: f32,
    kind: Kind,
}

const LINE: Color32 = Color32::from_rgb(150, 160, 165);
const BODY: Color32 = Color32::from_rgb(40, 48, 54);

impl<'a> Drawing<'a> {
    fn new(painter: &'a Painter, rect: Rect, buttons: &Buttons) -> Self {
        let scale = rect.width().min(rect.height() - 18.0) / 100.0;
        let side = 100.0 * scale;
        Self {
            painter,
            origin: pos2(rect.center().x - side * 0.5, rect.min.y),
            scale,
            width: rect.width(),
            kind: kind(buttons),
        }
    }

    fn at(&self, x: f32, y: f32) -> Pos2 {
        self.origin + vec2(x, y) * self.scale
    }

    fn circle(&self, [x, y, radius]: [f32; 3], lit: bool) {
        let fill = if lit { MESSAGE } else { BODY };
        self.painter.circle(
            self.at(x, y),
            radius * self.scale,
            fill,
            Stroke::new(1.5, LINE),
        );
    }

    fn block(&self, [x, y, width, height]: [f32; 4], round: u8, lit: bool) {
        let fill = if lit { MESSAGE } else { BODY };
        let size: Vec2 = vec2(width, height) * self.scale;
        let rect = Rect::from_min_size(self.at(x, y), size);
        self.painter.rect(
            rect,
            CornerRadius::same(round),
            fill,
            Stroke::new(1.5, LINE),
            StrokeKind::Middle,
        );
    }

    fn draw(&self, part: Part, name: &str) {
        match self.kind {
            Kind::Stick => self.stick(part),
            Kind::StickAlone => self.stick_alone(part),
            Kind::Wand => self.wand(part),
            Kind::Shoulder => self.shoulder(part),
            Kind::Simple => self.simple(part),
            Kind::Hand => self.hand(part),
            Kind::Pen => self.pen(part),
            Kind::Mouse => self.mouse(part),
        }
        self.caption(name);
    }

    /// The part's name below, in two lines where it is long.
    fn caption(&self, name: &str) {
        let font = FontId::proportional(14.0);
        let mut job = LayoutJob::simple(name.to_owned(), font, INK, self.width);
        job.halign = Align::Center;
        let galley = self.painter.layout_job(job);
        self.painter.galley(self.at(50.0, 102.0), galley, INK);
    }

    /// Seen from the side of the thumb: ring, plate with stick and buttons, handle, trigger before it, grip on it.
    fn stick(&self, part: Part) {
        self.ring(part);
        self.circle([42.0, 34.0, 9.5], part == Part::Undo);
        self.circle([60.0, 38.0, 5.5], part == Part::Grow);
        self.circle([63.0, 24.0, 5.5], part == Part::Back);
    }

    fn stick_alone(&self, part: Part) {
        self.ring(part);
        self.pad([50.0, 30.0, 13.0], part);
    }

    fn ring(&self, part: Part) {
        self.block([14.0, 26.0, 16.0, 20.0], 6, part == Part::Draw);
        self.block([36.0, 40.0, 28.0, 56.0], 10, part == Part::Hand);
        self.block([26.0, 56.0, 14.0, 24.0], 6, part == Part::Grab);
        self.circle([50.0, 30.0, 27.0], part == Part::Hand);
    }

    /// A stick or a touchpad that grows at its top, steps back at its bottom, and undoes and redoes at its sides.
    fn pad(&self, [x, y, radius]: [f32; 3], part: Part) {
        self.circle([x, y, radius], false);
        let to_edge = radius * 0.64;
        let sides = part == Part::Undo;
        for (across, down, lit) in [
            (0.0, -to_edge, part == Part::Grow),
            (0.0, to_edge, part == Part::Back),
            (-to_edge, 0.0, sides),
            (to_edge, 0.0, sides),
        ] {
            self.circle([x + across, y + down, radius * 0.27], lit);
        }
    }

    fn wand(&self, part: Part) {
        self.circle([50.0, 14.0, 13.0], false);
        self.block([38.0, 24.0, 24.0, 74.0], 10, part == Part::Hand);
        self.block([24.0, 40.0, 14.0, 18.0], 6, part == Part::Draw);
        self.block([56.0, 66.0, 10.0, 18.0], 4, part == Part::Grab);
        self.pad([50.0, 46.0, 11.0], part);
    }

    fn shoulder(&self, part: Part) {
        self.block([32.0, 8.0, 36.0, 40.0], 14, part == Part::Hand);
        self.block([38.0, 40.0, 24.0, 56.0], 10, part == Part::Hand);
        self.block([18.0, 14.0, 15.0, 11.0], 4, part == Part::Grab);
        self.block([20.0, 30.0, 14.0, 18.0], 6, part == Part::Draw);
        self.pad([50.0, 26.0, 14.0], part);
    }

    fn simple(&self, part: Part) {
        self.block([36.0, 6.0, 28.0, 90.0], 12, part == Part::Hand);
        self.circle([50.0, 24.0, 9.5], part == Part::Draw);
        self.circle([50.0, 48.0, 5.5], part == Part::Grab);
    }

    /// Thumb and index finger meet for a pinch; the other three close for a grip.
    fn hand(&self, part: Part) {
        self.block([34.0, 48.0, 36.0, 42.0], 12, part == Part::Hand);
        for x in [46.0, 54.5, 63.0] {
            self.block([x, 14.0, 8.0, 38.0], 6, part == Part::Grab);
        }
        self.block([36.0, 18.0, 9.0, 34.0], 6, part == Part::Draw);
        self.block([18.0, 40.0, 22.0, 10.0], 6, part == Part::Draw);
    }

    /// A mouse seen from above, and a key beside it.
    fn mouse(&self, part: Part) {
        self.block([44.0, 24.0, 42.0, 70.0], 18, part == Part::Hand);
        self.block([46.0, 26.0, 18.0, 28.0], 8, part == Part::Draw);
        self.block([66.0, 26.0, 18.0, 28.0], 8, part == Part::Grab);
        self.block([62.5, 32.0, 5.0, 14.0], 3, false);
        let keys = matches!(part, Part::Grow | Part::Back | Part::Undo);
        self.block([10.0, 62.0, 26.0, 24.0], 5, keys);
    }

    /// Its tip down; the buttons by their places: front, middle, back.
    fn pen(&self, part: Part) {
        self.block([44.0, 6.0, 12.0, 76.0], 6, part == Part::Hand);
        self.block([47.0, 82.0, 6.0, 12.0], 3, part == Part::Draw);
        self.block([45.5, 26.0, 9.0, 12.0], 4, part == Part::Grab);
        self.block([45.5, 41.0, 9.0, 14.0], 4, part == Part::Draw);
        self.block([45.5, 58.0, 9.0, 12.0], 4, part == Part::Grow);
    }
}
