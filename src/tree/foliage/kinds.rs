//! The leaves, blossoms and fruit there are, each as it usually stands, with its colours round the year.

use super::{Ranks, Season};

/// A kind of leaf, blossom or fruit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// Its name in grammars.
    pub name: &'static str,
    /// The built-in surface.
    pub surface: &'static str,
    /// Metres.
    pub size: f32,
    /// Metres of twig from one to the next.
    pub every: f32,
    /// How many at one place.
    pub whorl: u8,
    /// How they stand about the twig.
    pub ranks: Ranks,
    /// Between leaf and twig, degrees.
    pub angle: f32,
    /// How much it hangs, 0 to 1.
    pub droop: f32,
    /// Parts of the sky's light that it needs.
    pub light: f32,
    /// 0 (wet) to 1 (matte).
    pub roughness: f32,
    /// When it is there.
    pub seasons: [bool; 4],
    /// sRGB in spring, summer and autumn; an empty one is as in summer. In winter as in summer.
    spring: &'static [[u8; 3]],
    summer: &'static [[u8; 3]],
    autumn: &'static [[u8; 3]],
}

impl Kind {
    /// The colours of a season, at least one.
    #[must_use]
    pub fn colours(&self, season: Season) -> &'static [[u8; 3]] {
        let of = match season {
            Season::Spring => self.spring,
            Season::Autumn => self.autumn,
            Season::Summer | Season::Winter => self.summer,
        };
        if of.is_empty() { self.summer } else { of }
    }
}

const FALLS: [bool; 4] = [true, true, true, false];
const STAYS: [bool; 4] = [true; 4];

/// What a surface of a grammar's own is like.
pub(super) const PLAIN: Kind = Kind {
    name: "leaf",
    surface: "leaf",
    size: 0.1,
    every: 0.08,
    whorl: 1,
    ranks: Ranks::Spiral,
    angle: 55.0,
    droop: 0.2,
    light: 0.12,
    roughness: 0.6,
    seasons: FALLS,
    spring: &[[140, 176, 78]],
    summer: &[[88, 136, 52]],
    autumn: &[[214, 168, 60], [190, 110, 44]],
};

/// All kinds.
static KINDS: [Kind; 13] = [
    PLAIN,
    Kind {
        name: "maple",
        surface: "maple",
        size: 0.13,
        every: 0.075,
        whorl: 2,
        angle: 62.0,
        droop: 0.3,
        spring: &[[150, 172, 74], [168, 120, 66]],
        summer: &[[88, 134, 52], [102, 146, 58]],
        autumn: &[[196, 52, 26], [222, 104, 30], [230, 160, 48], [170, 40, 32]],
        ..PLAIN
    },
    Kind {
        name: "oak",
        surface: "oak",
        size: 0.12,
        every: 0.05,
        angle: 52.0,
        droop: 0.15,
        spring: &[[148, 164, 72]],
        summer: &[[84, 118, 48], [96, 132, 54]],
        autumn: &[[158, 92, 40], [186, 126, 50], [122, 78, 42], [170, 70, 38]],
        ..PLAIN
    },
    Kind {
        name: "birch",
        surface: "birch",
        size: 0.06,
        every: 0.045,
        angle: 58.0,
        droop: 0.45,
        spring: &[[156, 188, 82]],
        summer: &[[112, 154, 62], [128, 168, 70]],
        autumn: &[[232, 190, 48], [240, 208, 84], [214, 160, 44]],
        ..PLAIN
    },
    Kind {
        name: "willow",
        surface: "willow",
        size: 0.11,
        every: 0.035,
        angle: 38.0,
        droop: 0.35,
        spring: &[[176, 190, 88]],
        summer: &[[112, 142, 74], [128, 154, 84]],
        autumn: &[[216, 194, 84], [196, 178, 92]],
        ..PLAIN
    },
    Kind {
        name: "apple",
        surface: "ovate",
        size: 0.08,
        every: 0.045,
        spring: &[[134, 168, 76]],
        summer: &[[94, 138, 56], [106, 150, 64]],
        autumn: &[[206, 170, 66], [178, 122, 54], [128, 140, 62]],
        ..PLAIN
    },
    Kind {
        name: "needles",
        surface: "needles",
        size: 0.11,
        every: 0.035,
        angle: 40.0,
        droop: 0.05,
        light: 0.06,
        roughness: 0.7,
        seasons: STAYS,
        spring: &[[72, 108, 62], [124, 156, 82]],
        summer: &[[62, 98, 60], [74, 112, 66]],
        autumn: &[],
        ..PLAIN
    },
    Kind {
        name: "pinnule",
        surface: "pinnule",
        size: 0.05,
        every: 0.014,
        whorl: 2,
        ranks: Ranks::Two,
        angle: 72.0,
        droop: 0.05,
        light: 0.0,
        spring: &[[132, 176, 70]],
        summer: &[[74, 128, 46], [86, 140, 52]],
        autumn: &[[176, 136, 62], [140, 100, 52]],
        ..PLAIN
    },
    Kind {
        name: "spines",
        surface: "spines",
        size: 0.05,
        every: 0.06,
        whorl: 10,
        angle: 90.0,
        droop: 0.0,
        light: 0.0,
        roughness: 0.8,
        seasons: STAYS,
        spring: &[],
        summer: &[[226, 212, 170], [206, 186, 140]],
        autumn: &[],
        ..PLAIN
    },
    Kind {
        name: "blossom",
        surface: "blossom",
        size: 0.05,
        every: 0.11,
        angle: 60.0,
        droop: 0.0,
        light: 0.1,
        seasons: [true, false, false, false],
        spring: &[[248, 226, 232], [244, 206, 218], [250, 240, 240]],
        summer: &[[248, 226, 232]],
        autumn: &[],
        ..PLAIN
    },
    Kind {
        name: "fruit",
        surface: "fruit",
        size: 0.08,
        every: 0.7,
        angle: 100.0,
        droop: 0.9,
        light: 0.1,
        roughness: 0.35,
        seasons: [false, true, true, false],
        spring: &[],
        summer: &[[128, 160, 60]],
        autumn: &[[186, 38, 30], [206, 92, 40], [212, 176, 66]],
        ..PLAIN
    },
    Kind {
        name: "cone",
        surface: "cone",
        size: 0.12,
        every: 1.2,
        angle: 120.0,
        droop: 0.95,
        light: 0.2,
        roughness: 0.8,
        seasons: STAYS,
        spring: &[],
        summer: &[[112, 76, 48]],
        autumn: &[],
        ..PLAIN
    },
    Kind {
        name: "flower",
        surface: "blossom",
        size: 0.09,
        every: 0.5,
        angle: 80.0,
        droop: 0.0,
        light: 0.0,
        seasons: [false, true, false, false],
        spring: &[],
        summer: &[[222, 70, 120], [236, 110, 150]],
        autumn: &[],
        ..PLAIN
    },
];

/// A kind by its name.
#[must_use]
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// All kinds.
#[must_use]
pub fn kinds() -> [&'static Kind; KINDS.len()] {
    KINDS.each_ref()
}
