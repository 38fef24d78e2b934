//! A few linear equations.

/// Solves symmetric, positive equations, of which the lower half is given (Cholesky). None where they are not positive.
pub(crate) fn solve<const N: usize>(
    mut matrix: [[f64; N]; N],
    mut right: [f64; N],
) -> Option<[f64; N]> {
    for i in 0..N {
        for j in 0..=i {
            let sum = (0..j).fold(matrix[i][j], |sum, k| sum - matrix[i][k] * matrix[j][k]);
            if i != j {
                matrix[i][j] = sum / matrix[j][j];
            } else if sum > 0.0 && sum.is_finite() {
                matrix[i][i] = sum.sqrt();
            } else {
                return None;
            }
        }
    }
    for i in 0..N {
        let sum = (0..i).fold(right[i], |sum, k| sum - matrix[i][k] * right[k]);
        right[i] = sum / matrix[i][i];
    }
    for i in (0..N).rev() {
        let sum = (i + 1..N).fold(right[i], |sum, k| sum - matrix[k][i] * right[k]);
        right[i] = sum / matrix[i][i];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved_where_they_can_be() {
        let matrix = [[4.0, 0.0, 0.0], [2.0, 5.0, 0.0], [1.0, 3.0, 6.0]];
        let [x, y, z] = solve(matrix, [11.0, 21.0, 25.0]).unwrap_or_default();
        let back = [
            4.0 * x + 2.0 * y + z,
            2.0 * x + 5.0 * y + 3.0 * z,
            x + 3.0 * y + 6.0 * z,
        ];
        for (found, expected) in back.into_iter().zip([11.0, 21.0, 25.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        for matrix in [
            [[0.0, 0.0], [0.0, 1.0]],
            [[1.0, 0.0], [2.0, 1.0]],
            [[f64::NAN, 0.0], [0.0, 1.0]],
        ] {
            assert_eq!(solve(matrix, [1.0, 1.0]), None);
        }
    }
}
