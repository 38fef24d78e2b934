//! The turn that brings points onto others, and the main directions of points: both are eigenvectors of small symmetric matrices.

use glam::{DMat3, DQuat, DVec3};

/// Sweeps of Jacobi's method at most; a handful is the rule.
const SWEEPS: u8 = 50;

/// Eigenvalues of a symmetric matrix and, as rows, their vectors of length 1 (Jacobi 1846): the largest first.
pub(super) fn eigen<const N: usize>(mut matrix: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    let mut vectors = [[0.0; N]; N];
    (0..N).for_each(|i| vectors[i][i] = 1.0);
    for _ in 0..SWEEPS {
        let mut turned = false;
        for p in 0..N {
            for q in p + 1..N {
                let small = 1e-16 * (matrix[p][p].abs() + matrix[q][q].abs());
                let is_turned = matrix[p][q].abs() > small;
                if !is_turned {
                    continue;
                }
                turned = true;
                let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for row in &mut matrix {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for i in 0..N {
                    let [x, y] = [matrix[p][i], matrix[q][i]];
                    (matrix[p][i], matrix[q][i]) = (c * x - s * y, s * x + c * y);
                    let [x, y] = [vectors[p][i], vectors[q][i]];
                    (vectors[p][i], vectors[q][i]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
        if !turned {
            break;
        }
    }
    let mut found: [(f64, [f64; N]); N] = std::array::from_fn(|i| (matrix[i][i], vectors[i]));
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

/// A right-handed frame along the directions in which points are spread about the origin, as columns, the widest first.
pub(super) fn frame(points: &[DVec3]) -> DMat3 {
    let mut matrix = [[0.0; 3]; 3];
    for point in points {
        for i in 0..3 {
            (0..3).for_each(|j| matrix[i][j] += point[i] * point[j]);
        }
    }
    let [x, y, _] = eigen(matrix).map(|(_, vector)| DVec3::from(vector));
    DMat3::from_cols(x, y, x.cross(y))
}

/// The turn about the origin that brings the first points of pairs nearest to the second, by least squares (Horn 1987).
pub(super) fn turn(pairs: &[[DVec3; 2]]) -> DMat3 {
    let mut s = [[0.0; 3]; 3];
    for [from, to] in pairs {
        for i in 0..3 {
            (0..3).for_each(|j| s[i][j] += from[i] * to[j]);
        }
    }
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
    let matrix = [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ];
    let [(_, [w, x, y, z]), ..] = eigen(matrix);
    let turn = DQuat::from_xyzw(x, y, z, w).normalize();
    if turn.is_finite() {
        DMat3::from_quat(turn)
    } else {
        DMat3::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn vectors_are_kept_but_for_their_length(half in prop::collection::vec(-3.0..3.0, 10)) {
            let mut matrix = [[0.0; 4]; 4];
            let places = (0..4_usize).flat_map(|i| (0..=i).map(move |j| (i, j)));
            for ((i, j), number) in places.zip(&half) {
                (matrix[i][j], matrix[j][i]) = (*number, *number);
            }
            let found = eigen(matrix);
            for (value, vector) in found {
                for (row, part) in matrix.iter().zip(vector) {
                    let product: f64 = row.iter().zip(vector).map(|(a, b)| a * b).sum();
                    prop_assert!((product - value * part).abs() < 1e-9);
                }
                prop_assert!((vector.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            }
            prop_assert!(found.is_sorted_by(|a, b| a.0 >= b.0));
        }

        #[test]
        fn a_turn_is_found(
            axis in prop::array::uniform3(-1.0..1.0), angle in 0.1..3.0,
            points in prop::collection::vec(prop::array::uniform3(-5.0..5.0), 6),
        ) {
            let axis = DVec3::from(axis).try_normalize().unwrap_or(DVec3::X);
            let expected = DMat3::from_axis_angle(axis, angle);
            let pairs: Vec<[DVec3; 2]> = points.iter().map(|point| {
                let point = DVec3::from(*point);
                [point, expected * point]
            }).collect();
            let found = turn(&pairs);
            prop_assert!(pairs.iter().all(|[from, to]| (found * *from).distance(*to) < 1e-6));
            let frame = frame(&pairs.map_first());
            prop_assert!((frame.determinant() - 1.0).abs() < 1e-9);
        }
    }

    trait First {
        fn map_first(&self) -> Vec<DVec3>;
    }

    impl First for Vec<[DVec3; 2]> {
        fn map_first(&self) -> Vec<DVec3> {
            self.iter().map(|[first, _]| *first).collect()
        }
    }

    #[test]
    fn of_nothing_nothing_is_turned() {
        assert_eq!(turn(&[]), DMat3::IDENTITY);
        assert!(frame(&[]).determinant() == 1.0);
    }
}
