//! One panel's egui: a pointer in, wishes and painted triangles out.
//!
//! A sheet is laid out only when something about it changed: the pointer moved or pressed, a key was typed, what it shows is
//! another thing, or egui itself asks for another look. What only follows, a pointer that passes over it, a slider in a hand or a tree that
//! grows, is laid out in every other frame: a panel's time is short. Presses, releases, keys and scrolling wait for nothing. A frame in which nothing happens costs a
//! comparison and allocates nothing. It runs without any device, so a recorded session that is played without a picture does
//! what it did with one; time comes from the session for the same reason.

use egui::{
    Event, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, ViewportId, WidgetRect,
};

use super::{LayoutParams, Painted, theme, whole_pixels};
use crate::world::panels::PanelPointer;

/// Points that the stick scrolls in a second when it is pushed all the way.
pub const SCROLL_POINTS: f32 = 600.0;

/// A pointer that moved less than this stays where it was, points: hands tremble.
const STILL: f32 = 0.25;

/// Beyond every panel, points.
const FAR: f32 = 1e4;

/// Longest time between two frames that counts, seconds.
pub const LONGEST: f64 = 0.1;

/// Something that the person should feel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tick {
    /// The pointer came onto something that can be used.
    Hover,
    /// Something was pressed.
    Click,
}

/// What happened on a sheet in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Looked {
    /// To be felt, by this hand.
    pub tick: Option<(usize, Tick)>,
    /// Something on it takes text.
    pub wants_keys: bool,
}

/// See the module.
pub struct Sheet {
    context: egui::Context,
    params: LayoutParams,
    /// Width and height, metres.
    size: [f32; 2],
    pointer: Option<(Pos2, bool)>,
    /// The hand that the pointer is.
    hand: Option<usize>,
    /// A press whose pointer went away does not begin anew when it comes back.
    void: bool,
    /// Typed and not yet taken in.
    typed: Vec<Event>,
    /// In the last frame it was laid out, and did nothing but follow.
    follows: bool,
    hovered: Option<egui::Id>,
    looked: Looked,
    again: bool,
    time: f64,
    painted: Option<Painted>,
    /// Whether a picture will take what is painted.
    seen: bool,
    /// Texts and the middles of where they stand, points; none: they are not kept.
    texts: Option<Vec<(String, Pos2)>>,
}

impl Sheet {
    /// A sheet of a size in metres.
    #[must_use]
    pub fn new(size: [f32; 2], params: LayoutParams) -> Self {
        let context = egui::Context::default();
        theme::apply(&context);
        Self {
            context,
            params,
            size,
            pointer: None,
            hand: None,
            void: false,
            typed: Vec::new(),
            follows: false,
            hovered: None,
            looked: Looked::default(),
            again: true,
            time: 0.0,
            painted: None,
            seen: true,
            texts: None,
        }
    }

    /// The sheet for a picture that is made anew: laid out and painted from nothing, and scrolled as it was.
    #[must_use]
    pub fn anew(&self) -> Self {
        let anew = Self::new(self.size, self.params);
        let kept = self.context.data(Clone::clone);
        anew.context.data_mut(|data| *data = kept);
        anew
    }

    /// Says that no picture is drawn: what is painted is thrown away.
    pub fn unseen(&mut self) {
        self.seen = false;
        self.drop_painted();
    }

    fn drop_painted(&mut self) {
        if let Some(mut painted) = self.painted.take() {
            painted.textures.clear();
        }
    }

    /// Keeps where texts stand from the next look on.
    pub fn keep_texts(&mut self) {
        self.texts = Some(Vec::new());
        self.again = true;
    }

    /// The middle of the n-th text (from 1) that is this one, metres right of and below the upper left corner.
    #[must_use]
    pub fn find_text(&self, text: &str, nth: usize) -> Option<glam::Vec2> {
        let mut texts = self.texts.as_ref()?.iter().filter(|(kept, _)| kept == text);
        let (_, at) = texts.nth(nth.checked_sub(1)?)?;
        let LayoutParams {
            pixels_per_metre,
            pixels_per_point,
        } = self.params;
        Some(glam::Vec2::new(at.x, at.y) * (pixels_per_point / pixels_per_metre))
    }

    /// The texts on it, where they are kept.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().flatten().map(|(text, _)| text.as_str())
    }

    /// Types into what has the focus.
    pub fn type_in(&mut self, event: Event) {
        self.typed.push(event);
    }

    /// Looks at the sheet where that is needed. `changed`: what it shows is not what it showed.
    pub fn look(
        &mut self,
        pointer: Option<PanelPointer>,
        seconds: f64,
        changed: bool,
        show: impl FnMut(&mut egui::Ui),
    ) -> Looked {
        self.looked.tick = None;
        // Also where nothing is looked at: clicks long apart are no double click.
        self.time += seconds.clamp(0.0, LONGEST);
        let seen = self.pointer;
        let events = self.events(pointer, seconds);
        if events.is_empty() && !changed && !self.again {
            self.follows = false;
            return self.looked;
        }
        let moves = |event: &Event| matches!(event, Event::PointerMoved(_));
        let follows = events.iter().all(moves);
        if follows && std::mem::take(&mut self.follows) {
            self.again = true;
            // Where it was seen last: a press that loses its hand ends there.
            self.pointer = seen;
            return self.looked;
        }
        self.follows = follows;
        self.run(events, show);
        self.feel(pointer);
        self.looked
    }

    /// What the pointer and the keys did, as egui wants to hear it.
    fn events(&mut self, pointer: Option<PanelPointer>, seconds: f64) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.typed);
        let hand = pointer.map(|pointer| pointer.hand);
        if std::mem::replace(&mut self.hand, hand) != hand && self.lose_pointer(&mut events) {
            // Another hand has it from the next frame on: what was dragged must not jump there.
            self.hand = None;
            return events;
        }
        self.void &= pointer.is_none_or(|pointer| pointer.pressed);
        let scroll = pointer.map_or(0.0, |pointer| pointer.scroll);
        let scrolls = scroll.abs() > 0.3;
        if let Some(pointer) = pointer {
            let at = self.points(pointer.at);
            let pressed = pointer.pressed && !self.void;
            self.move_pointer(at, pressed, scrolls, &mut events);
        }
        if scrolls {
            #[expect(clippy::cast_possible_truncation, reason = "a frame's seconds")]
            let far = scroll * SCROLL_POINTS * seconds.clamp(0.0, LONGEST) as f32;
            events.push(Event::MouseWheel {
                unit: MouseWheelUnit::Point,
                delta: egui::vec2(0.0, far),
                phase: TouchPhase::Move,
                modifiers: Modifiers::NONE,
                source: egui::MouseWheelSource::Unknown,
            });
        }
        events
    }

    /// Tells where the pointer is, where egui makes something of it.
    fn move_pointer(&mut self, at: Pos2, pressed: bool, scrolls: bool, events: &mut Vec<Event>) {
        let (before, was) = self.pointer.unzip();
        let was = was.unwrap_or(false);
        let rests = !pressed && !was && !scrolls;
        let still = |old: Pos2| old.distance(at) <= STILL || (rests && self.is_as_at(old, at));
        let moved = before.is_none_or(|old| !still(old));
        let at = before.filter(|_| !moved && pressed == was).unwrap_or(at);
        if moved || pressed != was {
            events.push(Event::PointerMoved(at));
        }
        if pressed != was {
            events.push(button(at, pressed));
        }
        self.pointer = Some((at, pressed));
    }

    /// Whether a pointer that presses nothing does at one place what it does at the other, so that there is nothing to be looked at.
    fn is_as_at(&self, one: Pos2, other: Pos2) -> bool {
        let style = self.context.global_style();
        let nearby = style.interaction.interact_radius;
        let bar = style.spacing.scroll.bar_width;
        let same = |part: &WidgetRect| {
            let [near, now] = [one, other].map(|at| Nearness::of(at, part.interact_rect, nearby));
            // The nearest of several parts has the pointer, and the bar of a scroll area shows whether its handle has.
            let by_place =
                near == Nearness::Beside || (part.rect.width() <= bar && near != Nearness::Far);
            near == now && !by_place
        };
        self.context.viewport(|viewport| {
            let parts = &viewport.prev_pass.widgets;
            parts.layers().all(|(_, layer)| layer.iter().all(same))
        })
    }

    /// The hand is lost or points away: what it dragged ends where it is, and what it pressed is not clicked. Gives whether
    /// it pressed something.
    fn lose_pointer(&mut self, events: &mut Vec<Event>) -> bool {
        let Some((at, pressed)) = self.pointer.take() else {
            return false;
        };
        if pressed {
            // To egui a pointer that was so far away meanwhile has not clicked.
            let away = at + egui::vec2(FAR, 0.0);
            events.extend([away, at].map(Event::PointerMoved));
            events.push(button(at, false));
            self.void = true;
        }
        events.push(Event::PointerGone);
        pressed
    }

    fn points(&self, at: glam::Vec2) -> Pos2 {
        let LayoutParams {
            pixels_per_metre,
            pixels_per_point,
        } = self.params;
        let points = at * (pixels_per_metre / pixels_per_point);
        Pos2::new(points.x, points.y)
    }

    fn run(&mut self, events: Vec<Event>, show: impl FnMut(&mut egui::Ui)) {
        let LayoutParams {
            pixels_per_metre,
            pixels_per_point,
        } = self.params;
        let size_px = self
            .size
            .map(|metres| whole_pixels(metres * pixels_per_metre));
        let side = |pixels: u32| pixels as f32 / pixels_per_point;
        let size_points = egui::vec2(side(size_px[0]), side(size_px[1]));
        let mut input = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size_points)),
            time: Some(self.time),
            events,
            ..Default::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(pixels_per_point);
        }
        let mut output = self.context.run_ui(input, show);
        let wait = output
            .viewport_output
            .get(&ViewportId::ROOT)
            .map(|viewport| viewport.repaint_delay);
        self.again = wait.is_some_and(|wait| wait.is_zero());
        if let Some(texts) = &mut self.texts {
            texts.clear();
            output.shapes.iter().for_each(|clipped| {
                keep(&clipped.shape, clipped.clip_rect, texts);
            });
        }
        if !self.seen {
            output.textures_delta.clear();
            return;
        }
        let primitives = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        let mut textures = output.textures_delta;
        // Textures that nobody took yet must still come.
        if let Some(mut before) = self.painted.take() {
            before.textures.append(textures);
            textures = std::mem::take(&mut before.textures);
        }
        self.painted = Some(Painted {
            size_px,
            pixels_per_point: output.pixels_per_point,
            primitives,
            textures,
        });
    }

    /// Decides what is felt.
    fn feel(&mut self, pointer: Option<PanelPointer>) {
        let (used, clicked) = self.context.interaction_snapshot(|snapshot| {
            let used = snapshot.dragged.or(snapshot.clicked);
            let hovered =
                used.or_else(|| snapshot.hovered.iter().min_by_key(|id| id.value()).copied());
            (
                hovered,
                snapshot.clicked.or(snapshot.drag_started).is_some(),
            )
        });
        let came = used.is_some() && used != self.hovered;
        self.hovered = used;
        let tick = match (clicked, came) {
            (true, _) => Some(Tick::Click),
            (false, true) => Some(Tick::Hover),
            _ => None,
        };
        self.looked = Looked {
            tick: pointer.map(|pointer| pointer.hand).zip(tick),
            wants_keys: self.context.egui_wants_keyboard_input(),
        };
    }

    /// What is to be painted, where it changed since it was taken last.
    pub fn take_painted(&mut self) -> Option<Painted> {
        self.painted.take()
    }
}

/// How near a pointer is to a part: all that egui asks.
#[derive(Clone, Copy, PartialEq)]
enum Nearness {
    Far,
    /// Beside it, and near enough to be meant for it.
    Beside,
    /// On it, at its edge.
    Edge,
    /// On it, and near nothing that is behind it.
    Inside,
}

impl Nearness {
    fn of(at: Pos2, part: Rect, nearby: f32) -> Self {
        // A little more than egui's own radius, which it compares squared.
        let nearby = nearby + 0.01;
        if part.shrink(nearby).contains(at) {
            Self::Inside
        } else if part.contains(at) {
            Self::Edge
        } else if part.expand(nearby).contains(at) {
            Self::Beside
        } else {
            Self::Far
        }
    }
}

impl Drop for Sheet {
    fn drop(&mut self) {
        self.drop_painted();
    }
}

/// Keeps the texts of a shape that are to be seen.
fn keep(shape: &egui::Shape, clip: Rect, texts: &mut Vec<(String, Pos2)>) {
    match shape {
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| keep(shape, clip, texts)),
        egui::Shape::Text(text) => {
            let at = text.galley.rect.center() + text.pos.to_vec2();
            if clip.contains(at) {
                texts.push((text.galley.text().to_owned(), at));
            }
        }
        _ => {}
    }
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::collections::HashSet;

    use glam::Vec2;

    use super::*;

    /// Parts of every kind.
    fn parts(ui: &mut egui::Ui) {
        egui::CentralPanel::default().show(ui, |ui| {
            ui.horizontal_wrapped(|ui| (0..9).for_each(|n| _ = ui.button(format!("tab {n}"))));
            ui.separator();
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| {
                    for n in 0..20 {
                        let mut value = f64::from(n);
                        ui.label("a line of text");
                        ui.add(egui::Slider::new(&mut value, 0.0..=20.0).text("slider"));
                        ui.horizontal(|ui| {
                            ui.add(egui::DragValue::new(&mut value));
                            ui.checkbox(&mut (n % 2 == 0), "checked");
                            _ = ui.add_enabled(n % 3 == 0, egui::Button::new("perhaps"));
                        });
                    }
                });
        });
    }

    /// What is to be seen, and what has the pointer. Not where glyphs are kept: that depends on the order in which they came.
    fn seen(sheet: &Sheet) -> (Vec<(Pos2, egui::Color32)>, HashSet<egui::Id>) {
        let primitives = sheet.painted.iter().flat_map(|painted| &painted.primitives);
        let vertices = primitives.flat_map(|clipped| match &clipped.primitive {
            egui::epaint::Primitive::Mesh(mesh) => mesh.vertices.as_slice(),
            egui::epaint::Primitive::Callback(_) => &[],
        });
        let vertices = vertices.map(|vertex| (vertex.pos, vertex.color));
        let parts = sheet
            .context
            .interaction_snapshot(|snapshot| snapshot.hovered.iter().copied().collect());
        (vertices.collect(), parts)
    }

    /// A pointer that wanders over all parts: where nothing is looked at, a look would have changed nothing.
    #[test]
    fn a_pointer_that_stays_on_a_part_is_not_looked_at() {
        let size = [0.4, 0.3];
        let [mut lazy, mut eager] = [(); 2].map(|()| Sheet::new(size, LayoutParams::default()));
        let mut at = Vec2::new(0.2, 0.15);
        let mut state = 1_u64;
        let mut step = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        let (mut looks, steps) = (0, 1_500);
        for number in 0..steps {
            let far = if number % 20 == 0 { 0.3 } else { 0.004 };
            at = (at + Vec2::new(step(), step()) * far).clamp(Vec2::ZERO, Vec2::from(size));
            let trembles = |old: Pos2| old.distance(lazy.points(at)) <= STILL;
            if lazy.pointer.is_some_and(|(old, _)| trembles(old)) {
                continue;
            }
            // What is scrolled comes to rest in some frames, whose number depends on the time of the last look.
            let scrolls = number % 97 == 0;
            for frame in 0..if scrolls { 200 } else { 2 } {
                let pointer = PanelPointer {
                    hand: 1,
                    at,
                    pressed: false,
                    scroll: if scrolls && frame == 0 { -1.0 } else { 0.0 },
                };
                lazy.look(Some(pointer), 0.011, false, |ui| {
                    looks += 1;
                    parts(ui);
                });
                eager.pointer = None;
                eager.look(Some(pointer), 0.011, true, parts);
            }
            assert!(seen(&lazy) == seen(&eager), "at {at}, step {number}");
        }
        assert!(looks < steps * 2 / 3, "{looks} looks for {steps} steps");
    }
}
