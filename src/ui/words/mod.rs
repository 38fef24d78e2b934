//! Every string of the panels, one file a language: a language that lacks one does not compile.

use serde::{Deserialize, Serialize};

mod de;
mod en;

/// A language of the panels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// English.
    #[default]
    English,
    /// German.
    German,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::English, Self::German];

    /// What people call a part of a controller; the names come in English.
    #[must_use]
    pub fn part(self, name: &str) -> String {
        match self {
            Self::English => name.to_owned(),
            Self::German => de::part(name),
        }
    }

    /// Its strings.
    #[must_use]
    pub fn words(self) -> &'static Words {
        match self {
            Self::English => &en::WORDS,
            Self::German => &de::WORDS,
        }
    }
}

/// Makes the struct of all strings.
macro_rules! words {
    ($($name:ident),* $(,)?) => {
        /// All strings; each field says where it stands by its name.
        #[allow(missing_docs, reason = "the names are the strings")]
        #[derive(Clone, Copy, Debug)]
        pub struct Words { $(pub $name: &'static str),* }

        impl Words {
            /// All of them by name, to be checked.
            pub fn all(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
                [$((stringify!($name), self.$name)),*].into_iter()
            }
        }
    };
}

words! {
    language, tab_grow, tab_shape, tab_letters, tab_room, tab_file,
    step, grow, back, play, pause, speed, steps_a_second, undo, redo, clear, really_clear, keep,
    divergence, golden, alternate, thirds, opposite, scale, tip_radius, millimetres, radius_exponent, wrap, wrap_carry, wrap_restart,
    letter, trunk, branch_at, self_similar, every, depth, endless, nothing_drawn, new_branches,
    bench, hide, say_divergence, say_moment, say_clear, say_clear_again,
    layers, figure, turning, vignette, left_handed, lift,
    lesson_start, lesson_back, lesson_skip, lesson_stop,
    learn_draw, do_draw, learn_draw_on, do_draw_on,
    learn_branch, do_branch, learn_grow, do_grow,
    learn_back, do_back, learn_move, do_move,
    learn_delete, do_delete, learn_undo, do_undo,
    learn_redo, do_redo, learn_platform, do_platform,
    learn_lever, do_lever, learn_wheel, do_wheel,
    learn_panel, do_panel, learn_wrist, do_wrist,
    learn_stump, do_stump, do_on_bench,
    tab_draw, pen, eraser, spacing, tolerance,
    smoothing, snap_angle, snap_mirror, mirror_symmetry, symmetry,
    learn_free_hand, do_free_hand,
    tab_rules, rules_hint, own, edit, apply, generated, cancel, further, further_hint,
    export, exported_to, save, delete, enter, space, close,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn every_language_says_everything_in_its_own_words() {
        for language in Language::ALL {
            for (name, text) in language.words().all() {
                assert!(!text.trim().is_empty(), "{language:?} {name}");
                let known = text
                    .chars()
                    .all(|c| c.is_ascii() || "äöüÄÖÜß…°×·–„“≥".contains(c));
                assert!(
                    known,
                    "{language:?} {name}: {text} has a sign that the font may lack"
                );
            }
        }
        let [english, german] = Language::ALL.map(Language::words);
        let same = english.all().zip(german.all()).filter(|(a, b)| a.1 == b.1);
        let same: Vec<_> = same.map(|(a, _)| a.1).collect();
        assert!(same.len() <= 4, "not translated? {same:?}");
    }
}
