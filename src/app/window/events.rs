//! The window's events, as acts of the pointer and wishes of keys.

use std::rc::Rc;
use std::sync::Arc;

use glam::Vec2;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use super::camera::Camera;
use super::keys::{self, Meaning};
use super::pointer::{Act, Button, Drag, Pointer};
use super::{Wire, Wishes};

/// Size of a new window, in the desktop's points, and the least that makes sense.
const SIZE: LogicalSize<f64> = LogicalSize::new(1280.0, 800.0);
const LEAST: LogicalSize<f64> = LogicalSize::new(320.0, 240.0);

/// Pixels of a touchpad that are a notch of a wheel.
const NOTCH_PX: f64 = 50.0;

/// What the window said since the last frame.
pub(super) struct Events {
    title: String,
    window: Option<Arc<Window>>,
    fault: Option<String>,
    pointer: Pointer,
    held: ModifiersState,
    /// The mouse button whose drag moves the eye.
    dragging: Option<MouseButton>,
    size: PhysicalSize<u32>,
    occluded: bool,
    /// Something happened that changes the picture.
    news: bool,
    closed: bool,
    at_tree: bool,
    wire: Rc<Wire>,
}

impl Events {
    pub(super) fn new(title: &str, wire: Rc<Wire>) -> Self {
        let size = PhysicalSize::new(1280, 800);
        Self {
            title: title.to_owned(),
            window: None,
            fault: None,
            pointer: Pointer::new(Camera::at_work(), Vec2::new(1280.0, 800.0)),
            held: ModifiersState::empty(),
            dragging: None,
            size,
            occluded: false,
            news: true,
            closed: false,
            at_tree: false,
            wire,
        }
    }

    pub(super) fn window(&self) -> Option<Arc<Window>> {
        self.window.clone()
    }

    pub(super) fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    pub(super) fn pointer(&self) -> &Pointer {
        &self.pointer
    }

    pub(super) fn pointer_mut(&mut self) -> &mut Pointer {
        &mut self.pointer
    }

    /// Pixels of the window; nothing where it is folded up.
    pub(super) fn size(&self) -> Vec2 {
        #[expect(
            clippy::cast_precision_loss,
            reason = "windows are at most some thousands of pixels"
        )]
        Vec2::new(self.size.width as f32, self.size.height as f32)
    }

    /// Whether anything of the window can be seen.
    pub(super) fn is_seen(&self) -> bool {
        self.size.width > 0 && self.size.height > 0 && !self.occluded
    }

    pub(super) fn has_news(&self) -> bool {
        self.news
    }

    pub(super) fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.news)
    }

    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    pub(super) fn close(&mut self) {
        self.closed = true;
    }

    fn act(&mut self, act: Act) {
        self.news = true;
        self.pointer.take(act);
    }

    fn mouse(&mut self, state: ElementState, button: MouseButton) {
        let down = state.is_pressed();
        if !down && self.dragging == Some(button) {
            self.dragging = None;
            return self.act(Act::Drag(None));
        }
        let turns = self.held.alt_key() || self.held.control_key();
        let drags = button == MouseButton::Middle || button == MouseButton::Left && turns;
        if down && drags && self.dragging.is_none() {
            self.dragging = Some(button);
            self.wire.own_eye.set(true);
            let drag = if self.held.shift_key() {
                Drag::Pan
            } else {
                Drag::Orbit
            };
            return self.act(Act::Drag(Some(drag)));
        }
        match button {
            MouseButton::Left => self.act(Act::Button(Button::Trigger, down)),
            MouseButton::Right => self.act(Act::Button(Button::Squeeze, down)),
            _ => {}
        }
    }

    fn wheel(&mut self, delta: MouseScrollDelta) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => lines,
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a few notches; precision does not matter"
            )]
            MouseScrollDelta::PixelDelta(pixels) => (pixels.y / NOTCH_PX) as f32,
        };
        if notches.is_finite() && notches != 0.0 {
            self.wire.own_eye.set(true);
            self.act(Act::Wheel(notches));
        }
    }

    fn key(&mut self, key: &KeyEvent) {
        let Some(meaning) = keys::meaning(key, self.held) else {
            return;
        };
        let down = key.state.is_pressed();
        if let Meaning::Across(axis) = meaning {
            return self.act(Act::Across(down.then_some(axis)));
        }
        if !down {
            return;
        }
        let wishes = self.wire.wishes.get();
        match meaning {
            Meaning::Tap(tap) => self.act(Act::Tap(tap)),
            Meaning::Close => self.closed = true,
            Meaning::Look => {
                self.at_tree = !self.at_tree;
                self.wire.own_eye.set(true);
                if self.at_tree {
                    self.wire.wishes.set(Wishes {
                        tree: true,
                        ..wishes
                    });
                } else {
                    self.act(Act::Look(Camera::at_work()));
                }
            }
            Meaning::Eye => self.wire.own_eye.set(!self.wire.own_eye.get()),
            Meaning::Picture => self.wire.wishes.set(Wishes {
                picture: true,
                ..wishes
            }),
            Meaning::Export => self.wire.wishes.set(Wishes {
                export: true,
                ..wishes
            }),
            Meaning::Help => self.wire.wishes.set(Wishes {
                help: true,
                ..wishes
            }),
            Meaning::Across(_) => {}
        }
        self.news = true;
    }

    fn focus(&mut self, focused: bool) {
        self.held = ModifiersState::empty();
        self.dragging = None;
        self.act(Act::Focus(focused));
    }
}

impl ApplicationHandler for Events {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_some() {
            return;
        }
        let attributes = Window::default_attributes()
            .with_title(&self.title)
            .with_inner_size(SIZE)
            .with_min_inner_size(LEAST);
        match event_loop.create_window(attributes) {
            Ok(window) => {
                self.size = window.inner_size();
                self.pointer = Pointer::new(Camera::at_work(), self.size());
                self.window = Some(Arc::new(window));
            }
            Err(error) => self.fault = Some(super::one_line(&error)),
        }
    }

    fn window_event(
        &mut self,
        _event_loop: &ActiveEventLoop,
        _window: WindowId,
        event: WindowEvent,
    ) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => self.closed = true,
            WindowEvent::Resized(size) => {
                self.size = size;
                self.news = true;
            }
            WindowEvent::RedrawRequested | WindowEvent::ScaleFactorChanged { .. } => {
                self.news = true;
            }
            WindowEvent::Occluded(occluded) => {
                self.occluded = occluded;
                self.news = true;
            }
            WindowEvent::DroppedFile(file) => {
                self.wire.dropped.borrow_mut().push(file);
                self.news = true;
            }
            WindowEvent::Focused(focused) => self.focus(focused),
            WindowEvent::ModifiersChanged(held) => self.held = held.state(),
            WindowEvent::CursorMoved { position, .. } => {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "a place in a window of some thousands of pixels"
                )]
                let to = Vec2::new(position.x as f32, position.y as f32);
                self.act(Act::Moved(to));
            }
            WindowEvent::MouseInput { state, button, .. } => self.mouse(state, button),
            WindowEvent::MouseWheel { delta, .. } => self.wheel(delta),
            WindowEvent::KeyboardInput {
                event,
                is_synthetic: false,
                ..
            } => self.key(&event),
            _ => {}
        }
    }
}
