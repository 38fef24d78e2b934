//! Radii by da Vinci's rule: a parent's cross-section equals the sum of its children's.
//!
//! With exponent e, `radius(node)^e = Σ radius(child)^e`, and tips have the tip radius. It follows that
//! `radius(node) = tip_radius · tips(node)^(1/e)` where `tips(node)` counts the tips above the node (1 at a tip
//! itself). So one backward pass counts tips in integers: no error adds up over millions of nodes, and
//! the result does not depend on the order in which children are added.
//!
//! At a fork the node's own radius is the sum of *all* its children, the axis child and the laterals; the segment above
//! the fork begins with it and tapers to the axis child's radius, and a lateral begins with its own.
//!
//! e = 2 is da Vinci's observation as kept in spec/sketch.md; Eloy (Phys. Rev. Lett. 107, 258101, 2011)
//! derives 1.8 to 2.3 from wind loads; Murray's law for vessels is 3.

use super::{NO_PARENT, Tree, TreeError, growth};

/// How thick a tree is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiusParams {
    /// Radius of every tip in metres, 0.000001 to 10.
    pub tip_radius: f32,
    /// The exponent e, 1 to 4.
    pub exponent: f32,
}

impl Default for RadiusParams {
    fn default() -> Self {
        Self {
            tip_radius: 0.004,
            exponent: 2.0,
        }
    }
}

impl RadiusParams {
    /// Bounds of the tips' radius, metres.
    pub const TIP_RADIUS: [f32; 2] = [1e-6, 10.0];
    /// Bounds of the exponent.
    pub const EXPONENT: [f32; 2] = [1.0, 4.0];

    /// Checks that both values lie in their ranges.
    ///
    /// # Errors
    /// [`TreeError::Parameter`] names the value that does not.
    pub fn validate(&self) -> Result<(), TreeError> {
        let fields = [
            ("the tip radius (metres)", self.tip_radius, Self::TIP_RADIUS),
            ("the radius exponent", self.exponent, Self::EXPONENT),
        ];
        for (name, value, [least, most]) in fields {
            if !(least..=most).contains(&value) {
                let [value, least, most] = [value, least, most].map(f64::from);
                return Err(TreeError::Parameter {
                    name,
                    value,
                    least,
                    most,
                });
            }
        }
        Ok(())
    }

    /// The same with values outside their ranges clamped, and values that are no numbers replaced by the default.
    #[must_use]
    pub fn clamped(self) -> Self {
        let mend = |value: f32, [least, most]: [f32; 2], default| {
            if value.is_nan() {
                default
            } else {
                value.clamp(least, most)
            }
        };
        let default = Self::default();
        Self {
            tip_radius: mend(self.tip_radius, Self::TIP_RADIUS, default.tip_radius),
            exponent: mend(self.exponent, Self::EXPONENT, default.exponent),
        }
    }

    /// Radius in metres below so many tips.
    pub fn radius(&self, tips: u32) -> f32 {
        let tips = f64::from(tips);
        // Square root is exact to the last digit; powf costs more and is not, but in f64 that does not reach f32.
        #[allow(
            clippy::float_cmp,
            reason = "2 exactly is the default and the fast way"
        )]
        let thickness = if self.exponent == 2.0 {
            tips.sqrt()
        } else {
            tips.powf(1.0 / f64::from(self.exponent))
        };
        #[allow(
            clippy::cast_possible_truncation,
            reason = "rounded to f32 once, at the end"
        )]
        let radius = (f64::from(self.tip_radius) * thickness) as f32;
        radius
    }
}

/// Writes da Vinci radii into a valid tree and returns those of one step earlier: of the tree
/// made of the nodes with `birth < newest` alone, 0 for the others (see [`growth`]).
///
/// A root whose segments are all new had no thickness before. Parameters are taken [`RadiusParams::clamped`];
/// call [`RadiusParams::validate`] where a person entered them.
pub fn da_vinci(tree: &mut Tree, params: &RadiusParams, newest: u32) -> Vec<f32> {
    let mut before = Vec::new();
    da_vinci_into(tree, params, newest, &mut before);
    before
}

/// [`da_vinci`] into a vector that is reused.
pub fn da_vinci_into(tree: &mut Tree, params: &RadiusParams, newest: u32, before: &mut Vec<f32>) {
    let params = params.clamped();
    let nodes = tree.len();
    before.clear();
    before.resize(nodes, 0.0);
    // Segments that are not whole have no radius before; where they stand on a segment that is not whole, they
    // are not whole either.
    let bases = growth::bases(tree, newest);
    // Tips above each node, now and one step earlier. Sums stay below the number of nodes, which fits u32.
    let mut tips = vec![[0_u32; 2]; nodes];
    tree.radius.resize(nodes, 0.0);
    for node in (0..nodes).rev() {
        let parent = tree.parent[node];
        let [now, old] = tips[node];
        let now = now.max(1);
        let old = match parent {
            NO_PARENT => old,
            _ if bases[node] as usize != node => 0,
            _ => old.max(1),
        };
        tree.radius[node] = params.radius(now);
        if old > 0 {
            before[node] = params.radius(old);
        }
        if parent != NO_PARENT {
            let below = &mut tips[parent as usize];
            below[0] += now;
            below[1] += old;
        }
    }
}

/// The same where some nodes are as thick as is `given` of them, 0 of the others: what stands below them carries their cross-section.
///
/// Radii add up as floating numbers here, always in the same order.
pub fn da_vinci_given(
    tree: &mut Tree,
    params: &RadiusParams,
    newest: u32,
    given: &[f32],
) -> Vec<f32> {
    let params = params.clamped();
    let exponent = f64::from(params.exponent);
    let power = |radius: f32| f64::from(radius).powf(exponent);
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounded to f32 once, at the end"
    )]
    let root = |sum: f64| sum.powf(exponent.recip()) as f32;
    let bases = growth::bases(tree, newest);
    let mut before = vec![0.0; tree.len()];
    // What is above each node, by the exponent, now and one step earlier.
    let mut above = vec![[0.0_f64; 2]; tree.len()];
    tree.radius.resize(tree.len(), 0.0);
    for node in (0..tree.len()).rev() {
        let parent = tree.parent[node];
        let own = given.get(node).copied().filter(|radius| *radius > 0.0);
        let thick = |sum: f64| match own {
            Some(radius) => (radius, power(radius)),
            None if sum > 0.0 => (root(sum), sum),
            None => (params.tip_radius, power(params.tip_radius)),
        };
        let [now, old] = above[node];
        let was_there = match parent {
            NO_PARENT => old > 0.0,
            _ => bases[node] as usize == node,
        };
        let (radius, now) = thick(now);
        tree.radius[node] = radius;
        let mut earlier = 0.0;
        if was_there {
            (before[node], earlier) = thick(old);
        }
        if parent != NO_PARENT {
            let below = &mut above[parent as usize];
            below[0] += now;
            below[1] += earlier;
        }
    }
    before
}

/// When widths count as relative, and what they are brought to; both as parts of the tree's largest extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitParams {
    /// A largest radius beyond this part is no wood's.
    pub most: f32,
    /// The largest radius after fitting.
    pub fitted: f32,
}

impl Default for FitParams {
    /// The thickest trunks known (Adansonia, Taxodium) have a radius of a fifth of their height; a park tree's is a
    /// fortieth.
    fn default() -> Self {
        Self {
            most: 0.2,
            fitted: 0.025,
        }
    }
}

/// Scales all radii where the largest is too thick for the tree to be seen.
///
/// Published grammars often give widths without a unit: Honda's trees begin with a width of 10 on a branch of
/// length 1 (ABOP, Fig. 2.6), and only the ratios are meant. Gives the factor, `None` where the radii stay.
pub fn fit(tree: &mut Tree, params: &FitParams) -> Option<f32> {
    let (low, high) = tree.bounds()?;
    let extent = (high - low).max_element();
    let thickest = tree.radius.iter().copied().fold(0.0, f32::max);
    let factor = extent * params.fitted / thickest;
    if thickest <= extent * params.most || !factor.is_finite() || factor <= 0.0 {
        return None;
    }
    for radius in &mut tree.radius {
        *radius *= factor;
    }
    Some(factor)
}

/// Uniform lines in a picture are at most so thick: their radius as a part of the median segment's length.
const SLIM: f32 = 0.08;

/// Sets radii for a picture's sake, where widths that say nothing would make hairlines or one solid patch.
///
/// Where all are equal (a published grammar that draws lines and means no width), they are kept between `finest` and
/// 0.08 of the median segment's length; where they differ, what is thinner than `finest` alone is made so thick.
pub fn for_picture(tree: &mut Tree, finest: f32) {
    let widest = tree.radius.iter().copied().fold(0.0, f32::max);
    let thinnest = tree.radius.iter().copied().fold(f32::MAX, f32::min);
    let uniform = thinnest > widest * 0.999;
    let most = match median_length(tree) {
        Some(length) if uniform => length * SLIM,
        _ => f32::MAX,
    };
    for radius in &mut tree.radius {
        // A width of nothing is meant: such segments are not to be seen.
        if *radius > 0.0 {
            *radius = radius.min(most).max(finest);
        }
    }
}

/// The median of the lengths of a tree's segments that have one.
fn median_length(tree: &Tree) -> Option<f32> {
    let mut lengths: Vec<f32> = (tree.parent.iter().zip(&tree.position))
        .filter_map(|(&parent, at)| Some(tree.position.get(parent as usize)?.distance(*at)))
        .filter(|&length| length > 0.0 && length.is_finite())
        .collect();
    if lengths.is_empty() {
        return None;
    }
    let middle = lengths.len() / 2;
    Some(*lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
}
