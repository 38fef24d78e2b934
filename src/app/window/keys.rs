//! What keys mean, and how the board calls them.

use winit::event::KeyEvent;
use winit::keyboard::{Key, KeyCode, ModifiersState, NamedKey, PhysicalKey};

use super::pointer::{Axis, Tap};
use crate::world::board::Buttons;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A controller's button.
    Tap(Tap),
    /// The plane across an axis while it is held.
    Across(Axis),
    /// The picture as a file.
    Picture,
    /// Tree and grammar as files.
    Export,
    /// The keys on the board.
    Help,
    /// The eye before the tree or before the platform.
    Look,
    /// The recorded eye or the window's.
    Eye,
    /// The end.
    Close,
}

/// What a key means; `repeated`: it is held and comes again.
pub(super) fn meaning(key: &KeyEvent, held: ModifiersState) -> Option<Meaning> {
    of(&key.logical_key, key.physical_key, held, key.repeat)
}

fn of(
    logical: &Key,
    physical: PhysicalKey,
    held: ModifiersState,
    repeated: bool,
) -> Option<Meaning> {
    let (shift, control) = (held.shift_key(), held.control_key() || held.super_key());
    let found = match logical {
        Key::Named(NamedKey::Escape) => Meaning::Close,
        Key::Named(NamedKey::ArrowUp) => Meaning::Tap(Tap::Grow),
        Key::Named(NamedKey::ArrowDown) => Meaning::Tap(Tap::Back),
        _ => match (letter(logical, physical)?, control, shift) {
            ('g', false, false) => Meaning::Tap(Tap::Grow),
            ('g', false, true) => Meaning::Tap(Tap::Back),
            ('z', true, false) => Meaning::Tap(Tap::Undo),
            ('z', true, true) | ('y', true, _) => Meaning::Tap(Tap::Redo),
            ('x', false, _) => Meaning::Across(Axis::X),
            ('y', false, _) => Meaning::Across(Axis::Y),
            ('z', false, _) => Meaning::Across(Axis::Z),
            ('p', false, _) => Meaning::Picture,
            ('s', _, _) => Meaning::Export,
            ('h', false, _) => Meaning::Help,
            ('f', false, _) => Meaning::Look,
            ('v', false, _) => Meaning::Eye,
            ('q', true, _) => Meaning::Close,
            _ => return None,
        },
    };
    // Held, a key undoes and redoes on and on; each step of growth wants a press of its own.
    let goes_on = matches!(found, Meaning::Tap(Tap::Undo | Tap::Redo));
    (!repeated || goes_on).then_some(found)
}

/// The letter on a key, in lower case; where the keyboard's letters are not Latin, the one at its place.
fn letter(logical: &Key, physical: PhysicalKey) -> Option<char> {
    if let Key::Character(text) = logical
        && let Some(letter) = text.chars().next().filter(char::is_ascii)
    {
        return Some(letter.to_ascii_lowercase());
    }
    Some(match physical {
        PhysicalKey::Code(KeyCode::KeyG) => 'g',
        PhysicalKey::Code(KeyCode::KeyX) => 'x',
        PhysicalKey::Code(KeyCode::KeyY) => 'y',
        PhysicalKey::Code(KeyCode::KeyZ) => 'z',
        PhysicalKey::Code(KeyCode::KeyP) => 'p',
        PhysicalKey::Code(KeyCode::KeyS) => 's',
        PhysicalKey::Code(KeyCode::KeyH) => 'h',
        PhysicalKey::Code(KeyCode::KeyF) => 'f',
        PhysicalKey::Code(KeyCode::KeyV) => 'v',
        PhysicalKey::Code(KeyCode::KeyQ) => 'q',
        _ => return None,
    })
}

/// What the board calls mouse buttons and keys.
#[must_use]
pub(super) fn buttons() -> Buttons {
    let some = |name: &str| Some(name.to_owned());
    Buttons {
        draw: some("left button"),
        grab: some("right button"),
        grow: some("G"),
        back: some("Shift+G"),
        undo: some("Ctrl+Z"),
        redo: some("Ctrl+Y"),
        desk: true,
        others: vec![["middle", "turn the view; wheel: zoom; H: all keys"].map(str::to_owned)],
    }
}

/// What whoever begins is told.
pub(super) const BEGIN: &str =
    "Click above the yellow ball to draw the trunk, then press G to let it grow.";

/// All keys in a few sentences, for the board.
pub(super) const HELP: &str = "Left button: draw, choose. Right: move a node or the rim. Middle or Alt+left: turn the view, with Shift: move it; wheel: nearer. \
G: grow, Shift+G: back. Ctrl+Z, Ctrl+Y: undo, redo. X, Y, Z held: draw across that axis. F: see the tree, again: the platform. S: export. P: picture. Esc: save and end.";

#[cfg(test)]
mod tests {
    use winit::keyboard::{NativeKeyCode, SmolStr};

    use super::*;

    #[test]
    fn keys_mean_what_the_guide_says() {
        let none = ModifiersState::empty();
        let (shift, control) = (ModifiersState::SHIFT, ModifiersState::CONTROL);
        let unknown = PhysicalKey::Unidentified(NativeKeyCode::Unidentified);
        let character = |text: &str| Key::Character(SmolStr::new(text));
        for (key, held, expected) in [
            ("g", none, Some(Meaning::Tap(Tap::Grow))),
            ("G", shift, Some(Meaning::Tap(Tap::Back))),
            ("z", control, Some(Meaning::Tap(Tap::Undo))),
            ("Z", control | shift, Some(Meaning::Tap(Tap::Redo))),
            ("y", control, Some(Meaning::Tap(Tap::Redo))),
            ("z", none, Some(Meaning::Across(Axis::Z))),
            ("p", none, Some(Meaning::Picture)),
            ("s", control, Some(Meaning::Export)),
            ("k", none, None),
            ("q", none, None),
            ("q", control, Some(Meaning::Close)),
        ] {
            let found = of(&character(key), unknown, held, false);
            assert_eq!(found, expected, "{key} {held:?}");
        }
        // A Cyrillic keyboard: the key at the place of G.
        let place = PhysicalKey::Code(KeyCode::KeyG);
        let found = of(&character("п"), place, none, false);
        assert_eq!(found, Some(Meaning::Tap(Tap::Grow)), "by its place");
        let again = |key: &str, held| of(&character(key), unknown, held, true);
        assert_eq!(again("g", none), None, "one press, one step");
        assert!(again("z", control).is_some(), "undo goes on");
    }
}
