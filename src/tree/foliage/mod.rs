//! What a tree wears: its bark, and leaves, blossoms and fruit on its twigs, by order, age and light.
//!
//! ```text
//! Tree ─▶ which twigs bear (order, radius, age) ─▶ Light among their leaves ─▶ Placed leaves with colours of the season
//! ```
//!
//! A grammar that places each leaf itself (`~L`) says where it is; a [`Bearing`] says it for all twigs at once, so that leaves cost the string nothing and any
//! tree, one that was sketched or read from a file, too, can have them. Leaves stand at equal distances along an axis, turned by the golden angle from one to
//! the next (or in whorls, or in two ranks), lean away from it and turn their upper side to the light. Those that would stand in the dark are
//! left out, as trees shed them: Horn, *The Adaptive Geometry of Trees*, 1971. Everything that is random is drawn from the seed, the node's place and the leaf's number.

use std::fmt;

use glam::{Mat3, Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bark::Bark;
use super::draws::Draws;
use super::organs::{Material, Organs, Paint, Placed, Surface, from_bytes};
use super::{NO_PARENT, Tree};

mod kinds;
pub mod light;
mod thin;

pub use kinds::{Kind, kind, kinds};
use light::Light;
pub(super) use thin::thin;
pub(crate) use thin::two_triangles;

/// Leaves beyond which fewer and larger ones stand for all.
pub const MOST_LEAVES: u64 = 1 << 21;
/// Shades of each colour, so that no two neighbours are alike.
const SHADES: u16 = 6;
/// The first index of colours and materials that leaves take, far above those that grammars count from.
const FIRST_INDEX: u16 = 40_000;
/// The golden angle, radians: from each leaf of a twig to the next.
const GOLDEN: f32 = 2.399_963_1;
/// The flare of bark that says none.
pub const USUAL_FLARE: f32 = 0.5;
/// Parts of size² that a leaf's area is.
const AREA: f32 = 0.35;

/// A time of the year.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Season {
    /// Young leaves, blossoms.
    Spring,
    /// Full leaves.
    #[default]
    Summer,
    /// Coloured leaves, fruit.
    Autumn,
    /// Evergreens alone.
    Winter,
}

impl Season {
    /// All, in the order of the year.
    pub const ALL: [Self; 4] = [Self::Spring, Self::Summer, Self::Autumn, Self::Winter];

    /// Its name in grammars.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Summer => "summer",
            Self::Autumn => "autumn",
            Self::Winter => "winter",
        }
    }
}

/// How leaves stand about their twig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ranks {
    /// Each is turned from the one before: by the golden angle; whorls by half the angle between their leaves.
    #[default]
    Spiral,
    /// To the left and right of the twig, in its most level plane.
    Two,
}

/// One kind of leaf, blossom or fruit, and which twigs bear it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// A name of [`Kind`]s, or a letter of the grammar's surfaces.
    pub name: String,
    /// What is placed.
    pub surface: Surface,
    /// Metres that it is long.
    pub size: f32,
    /// Metres of twig from one to the next.
    pub every: f32,
    /// How many at one place, 1 to 12.
    pub whorl: u8,
    /// How they stand about the twig.
    pub ranks: Ranks,
    /// Between leaf and twig, degrees.
    pub angle: f32,
    /// How much it hangs, 0 to 1.
    pub droop: f32,
    /// Twigs up to this radius bear, metres.
    pub twig: f32,
    /// Twigs from this order on bear.
    pub order: u16,
    /// Twigs that appeared in so many of the last steps bear.
    pub young: u32,
    /// Only the ends of twigs bear.
    pub tips: bool,
    /// Parts of the sky's light without which there is none, 0 to 1.
    pub light: f32,
    /// How far sizes differ, 0 to 1.
    pub vary: f32,
    /// The seasons that it is there, in the order of [`Season::ALL`].
    pub seasons: [bool; 4],
}

/// Numbers of a bearing with their names in grammars and their bounds.
pub const NUMBERS: [(&str, [f32; 2]); 10] = [
    ("size", [1e-4, 100.0]),
    ("every", [1e-4, 1000.0]),
    ("whorl", [1.0, 12.0]),
    ("angle", [0.0, 180.0]),
    ("droop", [0.0, 1.0]),
    ("twig", [0.0, 1000.0]),
    ("order", [0.0, 65535.0]),
    ("young", [1.0, 1e6]),
    ("light", [0.0, 1.0]),
    ("vary", [0.0, 1.0]),
];

impl Bearing {
    /// A kind as it usually stands.
    #[must_use]
    pub fn of(kind: &Kind) -> Self {
        Self {
            name: kind.name.to_owned(),
            surface: Surface::built_in(kind.surface).unwrap_or_default(),
            size: kind.size,
            every: kind.every,
            whorl: kind.whorl,
            ranks: kind.ranks,
            angle: kind.angle,
            droop: kind.droop,
            twig: f32::MAX,
            order: 0,
            young: u32::MAX,
            tips: false,
            light: kind.light,
            vary: 0.25,
            seasons: kind.seasons,
        }
    }

    /// A surface of a grammar's own.
    #[must_use]
    pub fn of_surface(name: &str, surface: &Surface) -> Self {
        Self {
            name: name.to_owned(),
            surface: surface.clone(),
            ..Self::of(&kinds::PLAIN)
        }
    }

    /// Sets one of [`NUMBERS`], within its bounds.
    pub fn set(&mut self, name: &str, value: f32) {
        let Some((_, [least, most])) = NUMBERS.iter().find(|(known, _)| *known == name) else {
            return;
        };
        let value = value.clamp(*least, *most);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within bounds that the types hold"
        )]
        match name {
            "size" => self.size = value,
            "every" => self.every = value,
            "whorl" => self.whorl = value.round() as u8,
            "angle" => self.angle = value,
            "droop" => self.droop = value,
            "twig" => self.twig = value,
            "order" => self.order = value.round() as u16,
            // Its bound means all.
            "young" if value >= *most => self.young = u32::MAX,
            "young" => self.young = value.round() as u32,
            "light" => self.light = value,
            _ => self.vary = value,
        }
    }

    /// One of [`NUMBERS`].
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f32> {
        #[allow(clippy::cast_precision_loss, reason = "steps of growth are few")]
        Some(match name {
            "size" => self.size,
            "every" => self.every,
            "whorl" => f32::from(self.whorl),
            "angle" => self.angle,
            "droop" => self.droop,
            "twig" => self.twig,
            "order" => f32::from(self.order),
            "young" => self.young as f32,
            "light" => self.light,
            "vary" => self.vary,
            _ => return None,
        })
    }

    /// Whether the twig that ends at a node bears.
    fn is_on(&self, tree: &Tree, node: usize, newest: u32) -> bool {
        tree.parent[node] != NO_PARENT
            && tree.order[node] >= self.order
            && tree.radius[node] <= self.twig
            && newest.saturating_sub(tree.birth[node]) < self.young
    }
}

/// As a grammar says it, without `bears`: its name and what differs from its kind.
impl fmt::Display for Bearing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        let usual = Self::of(kind(&self.name).unwrap_or(&kinds::PLAIN));
        for (name, _) in NUMBERS {
            if let Some(value) = self
                .get(name)
                .filter(|value| usual.get(name) != Some(*value))
            {
                write!(f, " {name} {value}")?;
            }
        }
        if self.ranks != usual.ranks {
            f.write_str(if self.ranks == Ranks::Two {
                " ranked"
            } else {
                " spiral"
            })?;
        }
        if self.tips {
            f.write_str(" tips")?;
        }
        if self.seasons != usual.seasons {
            f.write_str(" in")?;
            let there = Season::ALL.iter().zip(self.seasons);
            for (season, _) in there.filter(|(_, there)| *there) {
                write!(f, " {}", season.name())?;
            }
        }
        Ok(())
    }
}

/// What a tree should bear in this season, and does not: its [`fmt::Display`] says so in a sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct Bare {
    /// As a grammar says it, without `bears`.
    pub bearing: String,
    /// [`Bearing::light`], less of which arrives wherever one would stand; none where no twig bears any.
    pub light: Option<f32>,
}

impl fmt::Display for Bare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bearing = &self.bearing;
        match self.light {
            Some(light) => write!(
                f,
                "`bears {bearing}`: none stands, as all would stand in the dark, with less than {light} of the sky's light; give fewer or smaller ones, or a lower `light`"
            ),
            None => write!(
                f,
                "`bears {bearing}`: no twig bears any; see what `twig`, `order`, `young` and `every` ask for"
            ),
        }
    }
}

/// What a tree wears.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dress {
    /// Of trunk and branches.
    pub bark: Bark,
    /// As [`Organs::flare`].
    pub flare: f32,
    /// The time of the year.
    pub season: Season,
    /// Leaves, blossoms and fruit.
    pub bears: Vec<Bearing>,
}

impl Dress {
    /// Adds to a tree's organs what it wears; radii must be as they are drawn. `seed` chooses sizes and turns; leaves do not hang below the height `ground`.
    pub fn put_on(&self, tree: &Tree, organs: &mut Organs, seed: u64, ground: Option<f32>) {
        organs.bark = self.bark;
        organs.flare = self.flare;
        let newest = tree.birth.iter().copied().max().unwrap_or(0);
        let there = Season::ALL
            .iter()
            .position(|one| *one == self.season)
            .unwrap_or(0);
        let worn: Vec<&Bearing> = self
            .bears
            .iter()
            .filter(|bearing| bearing.seasons.get(there) == Some(&true))
            .collect();
        if worn.is_empty() || tree.segment_count() == 0 {
            return;
        }
        let course = Course::of(tree);
        let mut sites: Vec<Vec<Site>> = worn
            .iter()
            .map(|bearing| course.sites(bearing, newest))
            .collect();
        let total: u64 = sites
            .iter()
            .flatten()
            .map(|site| u64::from(site.count))
            .sum();
        let cloud = cloud(&course, &worn, &sites);
        let light = Light::among(&cloud);
        // Fewer and larger, so that the crown is as dense.
        #[allow(clippy::cast_precision_loss, reason = "a share")]
        let share = (MOST_LEAVES as f64 / total.max(1) as f64).min(1.0);
        organs.crown = middle(&cloud);
        for (number, (bearing, sites)) in (0_u16..).zip(worn.iter().zip(&mut sites)) {
            let Ok(surface) = u16::try_from(organs.surfaces.len()) else {
                return;
            };
            let index = FIRST_INDEX + number.min(600) * 32;
            let colours = self.dye(bearing, index, organs);
            organs.surfaces.push(bearing.surface.clone());
            let places = Places {
                course: &course,
                bearing,
                light: light.as_ref(),
                share,
                #[allow(clippy::cast_possible_truncation, reason = "a factor")]
                larger: share.sqrt().recip() as f32,
                seed: seed ^ (u64::from(number) << 40),
                ground,
                surface,
                index,
                colours,
                is_round: self.bark.is_round_tipped() && self.flare > 0.0,
            };
            let placed: Vec<Vec<Placed>> = sites
                .par_chunks(4096)
                .map(|sites| places.of(sites))
                .collect();
            let stands = placed.iter().map(Vec::len).sum();
            if stands == 0 {
                organs.bare.push(Bare {
                    bearing: bearing.to_string(),
                    light: (!sites.is_empty()).then_some(bearing.light),
                });
            }
            organs.placed.reserve(stands);
            organs.placed.extend(placed.into_iter().flatten());
        }
    }

    /// Gives a bearing its material and the colours of the season; their number.
    fn dye(&self, bearing: &Bearing, index: u16, organs: &mut Organs) -> u16 {
        let of = kind(&bearing.name).unwrap_or(&kinds::PLAIN);
        let material = Material {
            roughness: of.roughness,
            metallic: 0.0,
        };
        organs.palette.set_material(index, material);
        organs.palette.set_name(index, &bearing.name);
        let own: Vec<[f32; 3]> = of
            .colours(self.season)
            .iter()
            .map(|c| from_bytes(*c))
            .collect();
        let mut count = 0;
        for colour in own.iter().take(5) {
            for shade in 0..SHADES {
                // Lighter and darker, yellower and bluer, evenly about the colour.
                let by = f32::from(shade) / f32::from(SHADES - 1) - 0.5;
                let warm = f32::from(shade * 5 % SHADES) / f32::from(SHADES - 1) - 0.5;
                let [r, g, b] = *colour;
                let light = 1.0 + 0.36 * by;
                let shaded = [
                    r * (light + 0.16 * warm),
                    g * light,
                    b * (light - 0.20 * warm),
                ];
                organs.palette.set_linear(index + count, shaded);
                count += 1;
            }
        }
        count
    }
}

/// Where leaves of one segment stand.
#[derive(Clone, Copy, Debug)]
struct Site {
    node: u32,
    /// The number along the axis of the first place.
    first: u32,
    /// Leaves in all.
    count: u32,
}

/// A tree with the way along each axis.
struct Course<'a> {
    tree: &'a Tree,
    /// Metres from where the axis begins to each node.
    along: Vec<f32>,
    is_tip: Vec<bool>,
}

impl<'a> Course<'a> {
    fn of(tree: &'a Tree) -> Self {
        let mut along = vec![0.0_f32; tree.len()];
        let mut is_tip = vec![true; tree.len()];
        for node in 0..tree.len() {
            let parent = tree.parent[node];
            if parent == NO_PARENT {
                continue;
            }
            let below = parent as usize;
            is_tip[below] = false;
            let goes_on = tree.order[node] == tree.order[below];
            let before = if goes_on { along[below] } else { 0.0 };
            along[node] = before + tree.position[node].distance(tree.position[below]);
        }
        Self {
            tree,
            along,
            is_tip,
        }
    }

    /// A segment's start and end, and its length.
    fn segment(&self, node: u32) -> (Vec3, Vec3, f32) {
        let end = self.tree.position[node as usize];
        let start = self.tree.position[self.tree.parent[node as usize] as usize];
        (start, end, start.distance(end))
    }

    /// The segments that bear, and how much.
    fn sites(&self, bearing: &Bearing, newest: u32) -> Vec<Site> {
        let mut sites = Vec::new();
        for node in (0..self.tree.len()).filter(|node| bearing.is_on(self.tree, *node, newest)) {
            let Ok(index) = u32::try_from(node) else {
                break;
            };
            let (_, _, length) = self.segment(index);
            let [from, to] = [self.along[node] - length, self.along[node]]
                .map(|way| (way / bearing.every).floor());
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "`as` saturates, and what is drawn is bounded"
            )]
            let (first, mut places) =
                ((from as u32).saturating_add(1), (to - from).max(0.0) as u32);
            if bearing.tips {
                places = 0;
            }
            let count = places.saturating_mul(u32::from(bearing.whorl.max(1)));
            let count = count.saturating_add(u32::from(self.is_tip[node]));
            if count > 0 {
                sites.push(Site {
                    node: index,
                    first,
                    count,
                });
            }
        }
        sites
    }
}

/// Where all leaves are, roughly, with their areas: what takes light.
fn cloud(course: &Course<'_>, worn: &[&Bearing], sites: &[Vec<Site>]) -> Vec<(Vec3, f32)> {
    let of = |(bearing, sites): (&&Bearing, &Vec<Site>)| {
        let area = AREA * bearing.size * bearing.size;
        sites
            .iter()
            .map(|site| {
                let (start, end, _) = course.segment(site.node);
                #[allow(clippy::cast_precision_loss, reason = "an area")]
                let of_all = area * site.count as f32;
                (start.midpoint(end), of_all)
            })
            .collect::<Vec<_>>()
    };
    worn.iter().zip(sites).flat_map(of).collect()
}

/// The middle of a crown: of its leaves' box, a third of the way up, so that the top looks up and the skirts look out.
fn middle(cloud: &[(Vec3, f32)]) -> Vec3 {
    let corners = cloud.iter().fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), (p, _)| (low.min(*p), high.max(*p)),
    );
    let (low, high) = corners;
    let middle = low.midpoint(high);
    let middle = Vec3::new(middle.x, low.y + (high.y - low.y) / 3.0, middle.z);
    if middle.is_finite() {
        middle
    } else {
        Vec3::ZERO
    }
}

/// Places one kind of leaf.
struct Places<'a> {
    course: &'a Course<'a>,
    bearing: &'a Bearing,
    light: Option<&'a Light>,
    /// Parts of all leaves that are placed.
    share: f64,
    /// How much larger these are.
    larger: f32,
    seed: u64,
    /// Metres below which none hangs.
    ground: Option<f32>,
    surface: u16,
    /// Of the material and the first colour.
    index: u16,
    colours: u16,
    /// Tips are domes, as `organs::collar` makes them.
    is_round: bool,
}

impl Places<'_> {
    /// How far the bark is from the middle, so far below the end of a node's segment.
    fn skin(&self, node: usize, below: f32) -> f32 {
        let radius = self.course.tree.radius[node];
        if self.is_round && self.course.is_tip[node] && below < radius {
            (below * (2.0 * radius - below)).max(0.0).sqrt()
        } else {
            radius
        }
    }

    fn of(&self, sites: &[Site]) -> Vec<Placed> {
        let mut placed = Vec::new();
        for site in sites {
            // Where not all are placed: every so many, the rest of a leaf by chance.
            let mut draws = Draws::new(self.seed ^ self.key(site.node), u64::MAX);
            let kept = f64::from(site.count) * self.share + draws.uniform(0.0, 1.0);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "at most all of them"
            )]
            let kept = if self.share < 1.0 {
                kept as u32
            } else {
                site.count
            };
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "at most all of them"
            )]
            let number = |kept: u32| (f64::from(kept) / self.share) as u32;
            placed.extend((0..kept).filter_map(|kept| self.leaf(site, number(kept))));
        }
        placed
    }

    /// What a node's leaves are drawn by: its place, which stays while the tree grows, as its number does not.
    fn key(&self, node: u32) -> u64 {
        let place = self.course.tree.position[node as usize].to_array();
        let [x, y, z] = place.map(|part| u64::from(part.to_bits()));
        Draws::new(x << 32 | y, z).next()
    }

    /// The leaf of a number on a segment, where it is kept.
    fn leaf(&self, site: &Site, number: u32) -> Option<Placed> {
        let Bearing {
            every,
            whorl,
            ranks,
            ..
        } = *self.bearing;
        let whorl = u32::from(whorl.max(1));
        let node = site.node as usize;
        let tree = self.course.tree;
        let (start, end, length) = self.course.segment(site.node);
        let axis = (end - start).try_normalize()?;
        let terminal = self.course.is_tip[node] && number + 1 == site.count;
        let place = site.first.saturating_add(number / whorl);
        let mut draws = Draws::new(self.seed ^ self.key(site.node), u64::from(number));
        #[allow(clippy::cast_possible_truncation, reason = "0 to 1")]
        let mut draw = || draws.uniform(0.0, 1.0) as f32;
        #[allow(clippy::cast_precision_loss, reason = "places along a twig are few")]
        let way = if terminal {
            1.0
        } else {
            let back = self.course.along[node] - place as f32 * every;
            (1.0 - back / length.max(1e-9)).clamp(0.0, 1.0)
        };
        let at = start.lerp(end, way);
        let light = self.light.map_or(1.0, |light| light.at(at));
        let least = self.bearing.light;
        if light < least * (0.5 + draw()) {
            return None;
        }
        // About the axis: from its most level side on.
        let level = axis.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
        let other = level.cross(axis);
        #[allow(clippy::cast_precision_loss, reason = "places along a twig are few")]
        let turn = match (ranks, whorl) {
            (Ranks::Two, _) => std::f32::consts::PI * ((place + number % whorl) % 2) as f32,
            (Ranks::Spiral, 1) => GOLDEN * (place % 4096) as f32,
            (Ranks::Spiral, _) => {
                let step = std::f32::consts::TAU / whorl as f32;
                step * ((number % whorl) as f32 + 0.5 * (place % 2) as f32)
            }
        };
        let (sin, cos) = (turn + 0.5 * (draw() - 0.5)).sin_cos();
        let outward = level * cos + other * sin;
        let angle = if terminal {
            0.25 * draw()
        } else {
            self.bearing.angle.to_radians()
        };
        let (sin, cos) = (angle + 0.35 * (draw() - 0.5)).sin_cos();
        let leaning = axis * cos + outward * sin;
        let droop = self.bearing.droop;
        let ahead =
            (leaning * (1.0 - 0.6 * droop) + Vec3::NEG_Y * (1.2 * droop)).try_normalize()?;
        // The upper side to the sky, where the leaf is not upright itself; there outwards from the axis.
        let wanted = Vec3::Y + outward * 0.35 + Vec3::new(draw() - 0.5, 0.0, draw() - 0.5) * 0.7;
        let vary = self.bearing.vary * (2.0 * draw() - 1.0);
        let scale = self.bearing.size * (1.0 + vary) * self.larger;
        let radius = match terminal {
            true => 0.0,
            false => self.skin(node, (1.0 - way) * length),
        };
        let position = at + outward * radius;
        let ahead = match self.ground {
            None => ahead,
            Some(ground) => lifted(ahead, (ground - position.y) / scale),
        };
        let up = wanted.reject_from_normalized(ahead).try_normalize();
        let up = up.unwrap_or_else(|| ahead.any_orthonormal_vector());
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the number of colours"
        )]
        let colour = (draw() * f32::from(self.colours)) as u16;
        Some(Placed {
            surface: self.surface,
            paint: Paint {
                colour: self.index + colour.min(self.colours.saturating_sub(1)),
                material: self.index,
            },
            position,
            orientation: Quat::from_mat3(&Mat3::from_cols(ahead.cross(up), ahead, up)),
            scale,
            birth: tree.birth[node],
            node: site.node,
            light,
        })
    }
}

/// A direction that goes down by no more than it may, or not at all from below.
fn lifted(ahead: Vec3, least: f32) -> Vec3 {
    let least = least.min(0.0);
    if ahead.y >= least {
        return ahead;
    }
    let aside = Vec3::new(ahead.x, 0.0, ahead.z).normalize_or(Vec3::X);
    aside * (1.0 - least * least).max(0.0).sqrt() + Vec3::Y * least
}

#[cfg(test)]
mod tests;
