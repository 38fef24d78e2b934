//! Every string of the panels, one file a language: a language that lacks one does not compile.

use serde::{Deserialize, Serialize};

mod de;
mod en;
mod study;

pub use self::study::StudyWords;

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

    /// A line of the board or a message in this language. The world speaks English; a sentence that is not in the
    /// language's table stays as it is.
    #[must_use]
    pub fn say(self, english: &str) -> String {
        let table: &[(&str, &str)] = match self {
            Self::English => &[],
            Self::German => de::SAID,
        };
        let said = table
            .iter()
            .find_map(|(from, to)| Some(filled(to, &holes(english, from)?)));
        said.unwrap_or_else(|| english.to_owned())
    }

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

/// What stands in a text where a pattern has `{}`; none where it is no text of the pattern. A hole ends where the pattern goes on for the
/// first time.
fn holes<'a>(text: &'a str, pattern: &str) -> Option<Vec<&'a str>> {
    let mut parts = pattern.split("{}");
    let mut rest = text.strip_prefix(parts.next()?)?;
    let mut found = Vec::new();
    let mut parts = parts.peekable();
    while let Some(part) = parts.next() {
        let end = match parts.peek() {
            None if part.is_empty() => rest.len(),
            None => rest
                .len()
                .checked_sub(part.len())
                .filter(|_| rest.ends_with(part))?,
            Some(_) => rest.find(part)?,
        };
        let (hole, after) = rest.split_at_checked(end)?;
        found.push(hole);
        rest = after.get(part.len()..)?;
    }
    rest.is_empty().then_some(found)
}

/// A pattern with its holes filled, in order.
fn filled(pattern: &str, holes: &[&str]) -> String {
    let mut parts = pattern.split("{}");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for (number, part) in parts.enumerate() {
        text.push_str(holes.get(number).copied().unwrap_or_default());
        text.push_str(part);
    }
    text
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
    take_branch, take_tree,
    part_lsystem, lines_first, seed, abstract_this, another_one, trees_drawn, stand_beside, numbers_match, in_the_model, in_the_tree, by_rules, segments, iterations, no_intersections, within_ellipsoid, trees_of_numbers,
    part_compare, compare_with, the_sketch, nothing_to_compare, comparing, same_tree, same_kind, alike_in_part, too_few_to_tell, different_trees, numbers_match_both, distributions_apart, no_counterpart, branch_edits, apart_in_space, off_by, in_the_other, at_one_size, all_numbers, lay_over, not_laid, root_to_root, fitted, parent_angle, own_radii, by_order, one_more, one_less,
    part_lines, find_lines, no_lines, finding, waits, trigger_chooses, inscribed_balls, branch, branches, junctions, tips, length, tortuosity, torsion, taper, volume, area, order, strahler, horsfield, radius_here, mean_radius, mean, deviation, least, most, upwards, whole_way, stem, points, path_radius, summary, how_many, not_reached, write_lines, again, caps, bridge_gaps,
    reading, part_look, part_mend, part_places, the_trigger, trigger_draws, trigger_marks, trigger_measures, next_end, snap_ends, source, target, sources, targets, endpoints, no_endpoints, propose, take, take_all, refuse, refuse_all, open_end, tip, write_endpoints, read_endpoints,
    distance, along, angle, thickness, curvature, radius, measured, no_measures, places, opposite_side, by_rays, no_way, no_numbers,
    cut, cut_none, cut_in_hand, cut_stays, lamp,
    mend, mend_weld, mend_debris, mend_largest, mend_orient, mend_close, mend_close_smooth, mend_smooth, mend_decimate, mend_remesh, unmend,
    tab_species, begin_with, own_species, individual, another, bark, bears, bare_dark, bare_twigs, maple, oak, birch, spruce, willow, apple, fern, cactus, spring, summer, autumn, winter, law_wander, law_spread, law_light, law_gravity, law_dominance, law_shrink, law_starve, law_length, law_reach, law_peak, law_crowd,
    leaf_size, leaf_every, leaf_droop, leaf_young,
    more_individuals, plant_them, all_alike, grow_first, no_pictures, planter, plant_how, plant_spacing, plant_vary, planted, uproot_all, really_uproot,
    tab_models, models_here, no_models_here, look_again, linked, model_is_not_there, take_away, triangles, vertices, unit, stands_on, shown_at, bar_is, one_to_one, reset_view, textured, shaded, matte, x_ray, no_faces, edges, box_and_size, colour_by, nothing, parts, problems, no_problems,
    language, tab_grow, tab_shape, tab_letters, tab_room, tab_file,
    step, grow, back, play, pause, speed, steps_a_second, undo, redo, clear, really_clear, keep,
    divergence, golden, alternate, thirds, opposite, scale, tip_radius, millimetres, radius_exponent, wrap, wrap_carry, wrap_restart,
    letter, trunk, branch_at, self_similar, every, depth, endless, nothing_drawn, new_branches,
    bench, hide, say_divergence, say_moment, say_clear, say_clear_again,
    layers, quality, quality_light, quality_full, quality_high, sharp, light, light_day, light_evening, light_studio, wind, wind_still, wind_breeze, wind_strong, figure, turning, vignette, left_handed, lift,
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
    recent, go_on,
    do_undo_key, do_redo_key, do_draw_desk, do_panel_desk, do_platform_desk,
    tab_rules, rules_hint, own, edit, apply, generated, cancel, further, further_hint,
    export, exported_to, save, delete, enter, space, close,
}

impl Words {
    /// How finely everything may be drawn, from the lightest on.
    #[must_use]
    pub fn qualities(&self) -> [&'static str; 3] {
        [self.quality_light, self.quality_full, self.quality_high]
    }

    /// By what everything may be lit.
    #[must_use]
    pub fn lights(&self) -> [&'static str; 3] {
        [self.light_day, self.light_evening, self.light_studio]
    }

    /// How it may blow.
    #[must_use]
    pub fn winds(&self) -> [&'static str; 3] {
        [self.wind_still, self.wind_breeze, self.wind_strong]
    }

    /// Names of the species, in their order.
    #[must_use]
    pub fn species(&self) -> [&'static str; 8] {
        [
            self.maple,
            self.oak,
            self.birch,
            self.spruce,
            self.willow,
            self.apple,
            self.fern,
            self.cactus,
        ]
    }

    /// The seasons, in the order of the year.
    #[must_use]
    pub fn seasons(&self) -> [&'static str; 4] {
        [self.spring, self.summer, self.autumn, self.winter]
    }

    /// The laws of growth, in the order of [`LAWS`](crate::sketch::habit::LAWS).
    #[must_use]
    pub fn laws(&self) -> [&'static str; 11] {
        [
            self.law_wander,
            self.law_spread,
            self.law_light,
            self.law_gravity,
            self.law_dominance,
            self.law_shrink,
            self.law_starve,
            self.law_length,
            self.law_reach,
            self.law_peak,
            self.law_crowd,
        ]
    }

    /// What is set of leaves: size, distance, droop, age.
    #[must_use]
    pub fn leaf_numbers(&self) -> [&'static str; 4] {
        [
            self.leaf_size,
            self.leaf_every,
            self.leaf_droop,
            self.leaf_young,
        ]
    }
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

    #[test]
    fn patterns_find_their_holes() {
        for (text, pattern, expected) in [
            ("step 3", "step {}", Some(vec!["3"])),
            ("step 3 of 4", "step {} of {}", Some(vec!["3", "4"])),
            ("a", "a", Some(vec![])),
            ("ab", "a", None),
            ("", "{}", Some(vec![""])),
            ("1, 2", "{}, {}", Some(vec!["1", "2"])),
            ("ende", "{}e", Some(vec!["end"])),
            ("e", "{}ee", None),
            ("größer als 3 m", "größer als {} m", Some(vec!["3"])),
        ] {
            assert_eq!(holes(text, pattern), expected, "{text} {pattern}");
        }
        assert_eq!(filled("{} und {}", &["1"]), "1 und ");
    }

    #[test]
    fn each_sentence_of_the_table_has_its_holes() {
        for (from, to) in de::SAID {
            let count = |text: &str| text.matches("{}").count();
            assert_eq!(count(from), count(to), "{from}");
            let text = from.replace("{}", "7");
            assert_ne!(
                Language::German.say(&text),
                text,
                "another one comes before it"
            );
        }
    }

    /// Every sentence that the rooms below say to a person, as it stands in their sources.
    #[test]
    fn every_message_of_the_world_is_in_the_table() {
        let sources = [
            include_str!("../../world/tools.rs"),
            include_str!("../../world/handles.rs"),
            include_str!("../../world/play.rs"),
            include_str!("../../world/stroke.rs"),
            include_str!("../../world/mod.rs"),
            include_str!("../../world/marking.rs"),
            include_str!("../../world/branches.rs"),
            include_str!("../../world/scanned.rs"),
            include_str!("../../app/comparing.rs"),
        ];
        let mut found = 0;
        for source in sources {
            let code = source.split("#[cfg(test)]").next().unwrap_or_default();
            // Sentences are the strings that begin with a capital and end with a full stop.
            for text in code.split('"').skip(1).step_by(2) {
                let sentence = text.starts_with(|c: char| c.is_ascii_uppercase())
                    && text.ends_with('.')
                    && text.contains(' ');
                if !sentence {
                    continue;
                }
                found += 1;
                // Named holes are numbers when they are said.
                let said = text
                    .split(['{', '}'])
                    .enumerate()
                    .map(|(at, part)| if at % 2 == 1 { "7" } else { part })
                    .collect::<String>();
                assert_ne!(Language::German.say(&said), said, "not in German: {text}");
            }
        }
        assert!(found >= 8, "only {found} sentences found");
    }
}
