//! Leaves, needles, blossoms and fruit by kind: few triangles each, since a tree has tens of thousands.
//!
//! A leaf is two halves about its rib, folded up a little and bent back, on a stalk of one triangle. Outlines are those of the species' herbarium sheets in
//! a dozen points a half, in the turtle's axes (x right, y ahead, z up), 1 long with the stalk.

use glam::{Quat, Vec3};
use std::f32::consts::TAU;

use super::surface::Surface;

/// A half of a leaf: how wide it is (x) at what length (y).
type Half = [[f32; 2]];

/// How far normals of leaves are those of the crown: as a cloud is lit, and not as a heap of sheets.
const ROUNDED: f32 = 0.55;

/// Five lobes, notched: a fan about a point of the rib.
const MAPLE: &Half = &[
    [0.07, 0.22],
    [0.29, 0.13],
    [0.23, 0.28],
    [0.37, 0.33],
    [0.52, 0.56],
    [0.36, 0.53],
    [0.31, 0.62],
    [0.14, 0.60],
    [0.19, 0.76],
    [0.09, 0.83],
];
/// Round lobes.
const OAK: &Half = &[
    [0.03, 0.14],
    [0.11, 0.28],
    [0.06, 0.34],
    [0.20, 0.46],
    [0.10, 0.52],
    [0.27, 0.67],
    [0.14, 0.73],
    [0.19, 0.88],
];
const BIRCH: &Half = &[[0.20, 0.34], [0.31, 0.46], [0.17, 0.74]];
const WILLOW: &Half = &[[0.055, 0.28], [0.075, 0.52], [0.045, 0.80]];
const OVATE: &Half = &[[0.17, 0.30], [0.27, 0.52], [0.20, 0.78]];
const PINNULE: &Half = &[[0.15, 0.08], [0.15, 0.40], [0.09, 0.76]];

impl Surface {
    /// Five-lobed, 22 triangles and the stalk.
    pub(super) fn maple() -> Self {
        let mut made = Self::new([80, 122, 46], true);
        made.stalk(0.22);
        let rib = Vec3::new(0.0, 0.42, -0.01);
        for side in [1.0, -1.0] {
            let lobe = |[x, y]: [f32; 2]| bent(side * x, y, 0.30, 0.22);
            let base = bent(0.0, 0.20, 0.0, 0.22);
            let tip = bent(0.0, 1.0, 0.0, 0.22);
            let outline = [base]
                .into_iter()
                .chain(MAPLE.iter().map(|p| lobe(*p)))
                .chain([tip]);
            made.fan(rib, &outline.collect::<Vec<_>>(), side < 0.0);
        }
        made.in_crown();
        made
    }

    pub(super) fn oak() -> Self {
        Self::leaf_of(OAK, [72, 106, 40], 0.12, 0.30, 0.16)
    }

    pub(super) fn birch() -> Self {
        Self::leaf_of(BIRCH, [108, 150, 60], 0.26, 0.35, 0.18)
    }

    pub(super) fn willow() -> Self {
        Self::leaf_of(WILLOW, [120, 148, 78], 0.08, 0.40, 0.26)
    }

    pub(super) fn ovate() -> Self {
        Self::leaf_of(OVATE, [84, 126, 52], 0.18, 0.40, 0.20)
    }

    pub(super) fn pinnule() -> Self {
        Self::leaf_of(PINNULE, [80, 134, 50], 0.0, 0.20, 0.30)
    }

    /// A leaf of a half's outline: stalk, rib, both halves.
    fn leaf_of(half: &Half, colour: [u8; 3], stalk: f32, fold: f32, bend: f32) -> Self {
        let mut made = Self::new(colour, true);
        if stalk > 0.0 {
            made.stalk(stalk);
        }
        for side in [1.0, -1.0] {
            let mut last = [bent(0.0, stalk, 0.0, bend); 2];
            for [x, y] in half.iter().copied().chain([[0.0, 1.0]]) {
                let next = [bent(0.0, y, 0.0, bend), bent(side * x, y, fold, bend)];
                made.strip(last, next, side < 0.0);
                last = next;
            }
        }
        made.in_crown();
        made
    }

    /// Normals of its own, and how far those of the crown shine through.
    fn in_crown(&mut self) {
        self.smooth();
        self.weld();
        self.rounded = ROUNDED;
    }

    /// A shoot with a brush of needles: one triangle each.
    pub(super) fn needles() -> Self {
        let mut made = Self::new([44, 80, 48], true);
        const NEEDLES: u8 = 22;
        for number in 0..NEEDLES {
            let t = f32::from(number) / f32::from(NEEDLES - 1);
            let turn = Quat::from_rotation_y(f32::from(number) * 2.4);
            let foot = Vec3::Y * (0.66 * t);
            let lean = 0.95 - 0.55 * t;
            let ahead = turn * Vec3::new(lean.sin(), lean.cos(), 0.0);
            let across = turn * Vec3::Z * 0.026;
            let tip = foot + ahead * 0.36;
            made.sheet([foot - across, foot + across, tip]);
        }
        made.in_crown();
        made
    }

    /// A cluster of spines about the place where it stands.
    pub(super) fn spines() -> Self {
        let mut made = Self::new([216, 198, 154], true);
        for number in 0..7_u8 {
            let turn = Quat::from_rotation_y(f32::from(number) * TAU / 6.0);
            let lean = if number == 6 { 0.0 } else { 1.05 };
            let ahead = turn * Vec3::new(f32::sin(lean), f32::cos(lean), 0.0);
            let across = turn * Vec3::Z * 0.035;
            made.sheet([-across, across, ahead * if number == 6 { 1.0 } else { 0.6 }]);
        }
        made.smooth();
        made
    }

    /// Five petals that open ahead, two triangles each, and a yellow heart.
    pub(super) fn blossom() -> Self {
        let mut made = Self::new([248, 226, 232], true);
        for petal in 0..5_u8 {
            let turn = Quat::from_rotation_y(TAU * f32::from(petal) / 5.0);
            let at = |out: f32, ahead: f32, aside: f32| turn * Vec3::new(out, ahead, aside);
            let foot = at(0.03, 0.10, 0.0);
            let [left, right] = [at(0.34, 0.24, -0.21), at(0.34, 0.24, 0.21)];
            let tip = at(0.52, 0.26, 0.0);
            made.sheet([foot, right, left]);
            made.sheet([left, right, tip]);
        }
        made.heart([238, 188, 40], 0.16, 0.09);
        made.smooth();
        made
    }

    /// A round fruit on its stalk.
    pub(super) fn fruit() -> Self {
        let mut made = Self::new([186, 40, 32], false);
        made.ball(Vec3::Y * 0.58, Vec3::new(0.44, 0.40, 0.44), 10, 6, 0);
        made
    }

    /// The stalk: one triangle.
    fn stalk(&mut self, length: f32) {
        let tip = bent(0.0, length + 0.02, 0.0, 0.2);
        self.sheet([Vec3::X * -0.012, Vec3::X * 0.012, tip]);
    }
}

/// A point of a leaf: raised away from the rib, bent back towards the tip.
fn bent(x: f32, y: f32, fold: f32, bend: f32) -> Vec3 {
    Vec3::new(x, y, fold * x.abs() - bend * y * y)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::super::surface::BUILT_IN;
    use super::*;

    /// Every surface: about 1 long, vertices that are used, normals of length 1, no triangle without area, and few of them where trees have many.
    #[test]
    fn surfaces_are_whole_and_small() {
        for name in BUILT_IN {
            let made = Surface::built_in(name).unwrap();
            assert_eq!(made.normals.len(), made.positions.len());
            assert_eq!(made.tone.len(), made.positions.len());
            assert!(
                made.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4),
                "{name}"
            );
            if made.rounded == 0.0 {
                continue;
            }
            let high = made.positions.iter().fold(0.0_f32, |most, p| most.max(p.y));
            assert!((0.2..=1.05).contains(&high), "{name}: {high}");
            for at in 0..made.positions.len() {
                assert!(
                    made.indices.contains(&u32::try_from(at).unwrap()),
                    "{name}: vertex {at} is not used"
                );
            }
            let triangles = made.indices.len() / 3;
            assert!((7..=33).contains(&triangles), "{name}: {triangles}");
            for corners in made.indices.chunks_exact(3) {
                let [a, b, c] =
                    [corners[0], corners[1], corners[2]].map(|i| made.positions[i as usize]);
                let normal = (b - a).cross(c - a);
                assert!(normal.length() > 1e-5, "{name}: {a} {b} {c}");
                // Leaves show their upper side up; brushes of needles all sides.
                assert!(
                    name == "needles"
                        || normal.z > 0.0
                        || (c.y - a.y).abs() > 10.0 * b.x.abs().max(a.x.abs()),
                    "{name}: {normal}"
                );
            }
        }
        // Halves share their rib.
        assert!(
            Surface::oak().positions.len() <= 33,
            "{}",
            Surface::oak().positions.len()
        );
    }
}
