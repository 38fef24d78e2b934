//! The direction that a set of vectors avoids most, and directions spread evenly.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

/// Eigenvalues of a symmetric matrix, the smallest first, with their unit vectors: Jacobi's rotations, until nothing is left beside the diagonal.
pub(super) fn eigen(of: DMat3) -> [(f64, DVec3); 3] {
    let (mut matrix, mut vectors) = (of, DMat3::IDENTITY);
    // It is quadratic near the end; eight sweeps are more than are ever needed.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let beside = matrix.col(q)[p];
            if beside == 0.0 {
                continue;
            }
            let ratio = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * beside);
            let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cosine;
            turn.col_mut(q)[q] = cosine;
            turn.col_mut(q)[p] = tangent * cosine;
            turn.col_mut(p)[q] = -tangent * cosine;
            matrix = turn.transpose() * matrix * turn;
            vectors *= turn;
        }
    }
    let mut pairs = [0, 1, 2].map(|axis| (matrix.col(axis)[axis], vectors.col(axis)));
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs
}

/// How unit vectors scatter about their mean, divided by their number.
pub(super) fn scatter(vectors: &[DVec3]) -> DMat3 {
    let count = u32::try_from(vectors.len()).map_or(1.0, f64::from).max(1.0);
    let mean = vectors.iter().sum::<DVec3>() / count;
    let mut sum = DMat3::ZERO;
    for vector in vectors {
        let from = *vector - mean;
        sum += DMat3::from_cols(from * from.x, from * from.y, from * from.z);
    }
    sum * count.recip()
}

/// `count` directions, evenly spread by the golden angle: those within `widest` radians of z.
pub(super) fn spread(count: u32, widest: f64) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let cap = 1.0 - widest.cos();
    (0..count).map(move |number| {
        let z = 1.0 - cap * (f64::from(number) + 0.5) / f64::from(count);
        let (sin, cos) = (golden * f64::from(number) % TAU).sin_cos();
        let out = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(out * cos, out * sin, z)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn eigenvectors_are_what_the_matrix_only_stretches(six in prop::array::uniform6(-3_i8..=3), scale in -6_i32..6) {
            let [a, b, c, d, e, f] = six.map(|number| f64::from(number) * 10.0_f64.powi(scale));
            let matrix = DMat3::from_cols(DVec3::new(a, b, c), DVec3::new(b, d, e), DVec3::new(c, e, f));
            let pairs = eigen(matrix);
            for (value, vector) in pairs {
                prop_assert!((vector.length() - 1.0).abs() < 1e-12);
                prop_assert!((matrix * vector - value * vector).length() <= 1e-12 * 10.0_f64.powi(scale) * 10.0);
            }
            prop_assert!(pairs[0].0 <= pairs[1].0 && pairs[1].0 <= pairs[2].0);
            prop_assert!(pairs[0].1.dot(pairs[1].1).abs() < 1e-12);
        }
    }

    #[test]
    fn directions_fill_their_cone_evenly() {
        for (count, widest, mean) in [(1000, PI, 0.0), (1000, PI / 3.0, 0.75)] {
            let all: Vec<DVec3> = spread(count, widest).collect();
            assert!(all.iter().all(|one| (one.length() - 1.0).abs() < 1e-12));
            assert!(all.iter().all(|one| one.z >= widest.cos()));
            let sum = all.iter().sum::<DVec3>() / f64::from(count);
            assert!((sum - mean * DVec3::Z).length() < 0.005, "{sum}");
        }
    }
}
