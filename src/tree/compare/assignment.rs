//! Who goes with whom, at the least cost: the assignment problem, by successive shortest paths with potentials (Kuhn 1955; Jonker and Volgenant 1987).

/// The column of each row, each column once, so that the costs are the least together. There must be no more rows than columns, and costs are numbers.
/// Takes rows² × columns steps at most.
pub fn assignment(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    assert!(rows <= columns, "every row needs a column");
    // Place 0 of rows and columns is nobody's.
    let mut of_row = vec![0.0; rows + 1];
    let mut of_column = vec![0.0; columns + 1];
    let mut taken = vec![0_usize; columns + 1];
    let mut before = vec![0_usize; columns + 1];
    for row in 1..=rows {
        taken[0] = row;
        let mut at = 0;
        let mut least = vec![f64::INFINITY; columns + 1];
        let mut seen = vec![false; columns + 1];
        while taken[at] != 0 {
            seen[at] = true;
            let from = taken[at];
            let (mut step, mut next) = (f64::INFINITY, 0);
            for column in 1..=columns {
                if seen[column] {
                    continue;
                }
                let reduced = cost(from - 1, column - 1) - of_row[from] - of_column[column];
                if reduced < least[column] {
                    least[column] = reduced;
                    before[column] = at;
                }
                if least[column] < step {
                    step = least[column];
                    next = column;
                }
            }
            for column in 0..=columns {
                if seen[column] {
                    of_row[taken[column]] += step;
                    of_column[column] -= step;
                } else {
                    least[column] -= step;
                }
            }
            at = next;
        }
        while at != 0 {
            taken[at] = taken[before[at]];
            at = before[at];
        }
    }
    let mut found = vec![0; rows];
    for column in 1..=columns {
        if taken[column] != 0 {
            found[taken[column] - 1] = column - 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least of all ways.
    fn of_all(rows: usize, free: &mut Vec<usize>, cost: &dyn Fn(usize, usize) -> f64) -> f64 {
        let Some(row) = rows.checked_sub(1) else {
            return 0.0;
        };
        let mut least = f64::INFINITY;
        for place in 0..free.len() {
            let column = free.remove(place);
            least = least.min(cost(row, column) + of_all(row, free, cost));
            free.insert(place, column);
        }
        least
    }

    proptest! {
        #[test]
        fn no_other_way_costs_less(
            costs in prop::collection::vec(prop_oneof![-5.0..5.0, Just(0.0), Just(1.0)], 36),
            rows in 0_usize..5, more in 0_usize..3,
        ) {
            let columns = rows + more;
            let cost = |row: usize, column: usize| costs[row * 6 + column % 6];
            let found = assignment(rows, columns, cost);
            let mut once = found.clone();
            once.sort_unstable();
            once.dedup();
            prop_assert_eq!(once.len(), rows);
            let sum: f64 = found.iter().enumerate().map(|(row, column)| cost(row, *column)).sum();
            let least = of_all(rows, &mut (0..columns).collect(), &cost);
            prop_assert!((sum - least).abs() < 1e-9, "{} {}", sum, least);
        }
    }
}
