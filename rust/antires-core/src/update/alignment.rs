//! Which place of one ascending list belongs to which of another: one to one, in order, with gaps.
//!
//! ```text
//! T(i, j) = min( T(i−1, j−1) + c_ij,  T(i−1, j) + a_i,  T(i, j−1) + b_j )
//! ```
//!
//! c_ij is the price of a pair, a_i and b_j those of staying alone. Along a change of the model the roots of
//! one response keep their order but for pairs that merge, vanish or appear; and so do the values measured of
//! them. So this is the assignment that explains a whole response best.

use std::f64::consts::PI;

/// Partner of what has none.
pub const ALONE: i64 = -1;

/// Places in ln f, each of a response: responses ascend, and places within each.
#[derive(Debug, Clone, Copy)]
pub struct Places<'a> {
    /// Number of the response of each.
    pub response: &'a [i64],
    /// ln of each frequency.
    pub log_f: &'a [f64],
}

impl Places<'_> {
    /// Where the response that begins at `first` ends.
    fn end(self, first: usize) -> usize {
        let own = self.response[first];
        first + self.response[first..].partition_point(|&each| each <= own)
    }

    /// Where a response begins and ends.
    fn of(self, response: i64) -> (usize, usize) {
        let first = self.response.partition_point(|&each| each < response);
        let count = self.response[first..].partition_point(|&each| each <= response);
        (first, first + count)
    }
}

/// The table of one alignment after the other.
#[derive(Debug, Default)]
pub struct Aligner {
    table: Vec<f64>,
    cost: Vec<f64>,
}

impl Aligner {
    /// Column of each row, [`ALONE`] without one: the order-preserving assignment of least cost.
    pub fn align(
        &mut self,
        cost: impl Fn(usize, usize) -> f64,
        alone_row: impl Fn(usize) -> f64,
        alone_column: impl Fn(usize) -> f64,
        n_columns: usize,
        found: &mut [i64],
    ) {
        let (rows, width) = (found.len(), n_columns + 1);
        self.cost.clear();
        self.cost
            .extend((0..rows).flat_map(|i| (0..n_columns).map(move |j| (i, j))).map(|(i, j)| cost(i, j)));
        self.table.clear();
        self.table.resize((rows + 1) * width, 0.0);
        for j in 0..n_columns {
            self.table[j + 1] = self.table[j] + alone_column(j);
        }
        for i in 0..rows {
            let (above, here) = self.table[i * width..].split_at_mut(width);
            let row = alone_row(i);
            here[0] = above[0] + row;
            for j in 0..n_columns {
                let pair = above[j] + self.cost[i * n_columns + j];
                here[j + 1] = pair.min(above[j + 1] + row).min(here[j] + alone_column(j));
            }
        }
        found.fill(ALONE);
        let (mut i, mut j) = (rows, n_columns);
        let at = |i: usize, j: usize| self.table[i * width + j];
        #[allow(clippy::float_cmp)] // the same sums as above
        while i > 0 && j > 0 {
            if at(i, j) == at(i - 1, j - 1) + self.cost[(i - 1) * n_columns + j - 1] {
                (i, j) = (i - 1, j - 1);
                found[i] = i64::try_from(j).unwrap_or(ALONE);
            } else if at(i, j) == at(i - 1, j) + alone_row(i - 1) {
                i -= 1;
            } else {
                j -= 1;
            }
        }
    }
}

/// Root of each value, [`ALONE`] without one: the most probable assignment of every response.
///
/// A pair costs −ln of the normal density of its distance, with `value_std` and `root_std` together; a value
/// without a root costs `alone`, a root without a value its `alone_root`.
pub fn associate(
    values: Places<'_>,
    value_std: &[f64],
    roots: Places<'_>,
    root_std: &[f64],
    alone: f64,
    alone_root: &[f64],
) -> Vec<i64> {
    let mut found = vec![ALONE; values.log_f.len()];
    let mut aligner = Aligner::default();
    let mut first = 0;
    while first < found.len() {
        let end = values.end(first);
        let (low, high) = roots.of(values.response[first]);
        let price = |i: usize, j: usize| {
            let (i, j) = (first + i, low + j);
            let sigma = value_std[i].hypot(root_std[j]);
            let apart = (values.log_f[i] - roots.log_f[j]) / sigma;
            0.5 * apart * apart + sigma.ln() + 0.5 * (2.0 * PI).ln()
        };
        let own = &mut found[first..end];
        aligner.align(price, |_| alone, |j| alone_root[low + j], high - low, own);
        shift(own, low);
        first = end;
    }
    found
}

/// Number of the root of `before` that each root of `after` has been, [`ALONE`] for a new one.
///
/// Where a response has as many roots as before they keep their order; otherwise those that moved least are the
/// same, a root that appears or vanishes costing `born`.
pub fn follow(before: Places<'_>, after: Places<'_>, born: f64) -> Vec<i64> {
    let mut found = vec![ALONE; after.log_f.len()];
    let mut aligner = Aligner::default();
    let mut first = 0;
    while first < found.len() {
        let end = after.end(first);
        let (low, high) = before.of(after.response[first]);
        let own = &mut found[first..end];
        if own.len() == high - low {
            for (nth, each) in own.iter_mut().enumerate() {
                *each = i64::try_from(nth).unwrap_or(ALONE);
            }
        } else {
            let moved = |i: usize, j: usize| (after.log_f[first + i] - before.log_f[low + j]).abs();
            aligner.align(moved, |_| born, |_| born, high - low, own);
        }
        shift(own, low);
        first = end;
    }
    found
}

/// From numbers within a response to those in the whole list.
fn shift(found: &mut [i64], first: usize) {
    let first = i64::try_from(first).unwrap_or(i64::MAX);
    for each in found.iter_mut().filter(|each| **each != ALONE) {
        *each += first;
    }
}

#[cfg(test)]
mod tests {
    use super::{ALONE, Aligner, Places, associate, follow};

    /// Least cost over all order-preserving assignments, by trying them.
    fn least(cost: &[Vec<f64>], rows: &[f64], columns: &[f64]) -> f64 {
        match (rows.split_first(), columns.split_first()) {
            (None, _) => columns.iter().sum(),
            (_, None) => rows.iter().sum(),
            (Some((a, others)), Some((b, rest))) => {
                let without_first: Vec<Vec<f64>> = cost.iter().map(|r| r[1..].to_vec()).collect();
                let pair = cost[0][0] + least(&without_first[1..], others, rest);
                let row_alone = a + least(&cost[1..], others, columns);
                pair.min(row_alone).min(b + least(&without_first, rows, rest))
            }
        }
    }

    #[test]
    fn no_assignment_costs_less() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from(seed >> 33).unwrap()) / f64::from(u32::MAX)
        };
        for (n_rows, n_columns) in [(3, 4), (4, 4), (5, 2), (1, 5), (0, 3)] {
            let cost: Vec<Vec<f64>> =
                (0..n_rows).map(|_| (0..n_columns).map(|_| random()).collect()).collect();
            let rows: Vec<f64> = (0..n_rows).map(|_| 0.4 * random()).collect();
            let columns: Vec<f64> = (0..n_columns).map(|_| 0.4 * random()).collect();
            let mut found = vec![ALONE; n_rows];
            Aligner::default().align(|i, j| cost[i][j], |i| rows[i], |j| columns[j], n_columns, &mut found);
            let taken: Vec<usize> = found.iter().filter_map(|&j| usize::try_from(j).ok()).collect();
            assert!(taken.is_sorted() && taken.windows(2).all(|w| w[0] < w[1]));
            let mut price: f64 = (0..n_columns).filter(|j| !taken.contains(j)).map(|j| columns[j]).sum();
            for (i, &j) in found.iter().enumerate() {
                price += usize::try_from(j).map_or(rows[i], |j| cost[i][j]);
            }
            assert!((price - least(&cost, &rows, &columns)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_value_between_responses_belongs_to_its_own() {
        let roots = Places { response: &[0, 0, 2, 2], log_f: &[1.0, 2.0, 1.1, 2.1] };
        let values = Places { response: &[0, 1, 2], log_f: &[2.001, 2.0, 1.102] };
        let small = [1e-2; 4];
        let found = associate(values, &small[..3], roots, &small, 8.0, &[1.0; 4]);
        assert_eq!(found, [1, ALONE, 2]);
    }

    #[test]
    fn a_root_that_appears_is_new() {
        let before = Places { response: &[0, 0, 1], log_f: &[1.0, 2.0, 1.5] };
        let after = Places { response: &[0, 0, 0, 1], log_f: &[0.99, 1.5, 2.01, 1.8] };
        assert_eq!(follow(before, after, 0.05), [0, ALONE, 1, 2]);
    }
}
