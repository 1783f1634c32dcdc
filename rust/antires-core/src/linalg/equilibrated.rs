//! A general pencil whose rows and columns are brought to one size by powers of two, which round nothing.
//!
//! The scales are those that make all entries at most one, and those of one permutation, the one of largest product,
//! one (about): the determinant then stands on entries of size one, however weak the links on which it hangs. They
//! are the potentials of an assignment problem with the costs −log₂|a_ij|.
//!
//! References: M. Olschowka & A. Neumaier, Linear Algebra Appl. 240 (1996) 131-151; I. S. Duff & J. Koster, SIAM J.
//! Matrix Anal. Appl. 22 (2001) 973-996.

use faer::Mat;

/// Cost of a zero: no permutation of entries that are not zero costs as much.
const ABSENT: f64 = 1e6;

/// Ratio of two scales of rows, or of columns, from which on a pencil is graded.
const GRADED: f64 = 1e6;

/// A pencil with the scales of its rows and columns.
pub struct Equilibrated {
    /// A, scaled.
    pub a: Mat<f64>,
    /// B, scaled.
    pub b: Mat<f64>,
    /// Whether rows or columns differed by many decades.
    pub is_graded: bool,
}

impl Equilibrated {
    /// R A C and R B C with powers of two R and C; where the pencil is singular for each x by its zeros, A and B.
    #[must_use]
    pub fn of(a: &Mat<f64>, b: &Mat<f64>) -> Self {
        let ratio = a.norm_max() / b.norm_max();
        let is_number = ratio.is_finite() && ratio > 0.0;
        Self::weighted(a, b, if is_number { ratio } else { 1.0 })
    }

    /// The same, where an entry has the size of the larger of |a_ij| and `weight` |b_ij|.
    #[must_use]
    pub fn weighted(a: &Mat<f64>, b: &Mat<f64>, weight: f64) -> Self {
        let n = a.nrows();
        let cost = |i: usize, j: usize| {
            let size = a[(i, j)].abs().max(weight * b[(i, j)].abs());
            if size > 0.0 { -size.log2() } else { ABSENT }
        };
        let Some((rows, columns)) = potentials(n, cost) else {
            return Self {
                a: a.clone(),
                b: b.clone(),
                is_graded: false,
            };
        };
        let whole = |v: Vec<f64>| -> Vec<f64> { v.iter().map(|v| v.round().exp2()).collect() };
        let (rows, columns) = (whole(rows), whole(columns));
        let spread = |v: &[f64]| {
            let most = v.iter().fold(0.0_f64, |m, s| m.max(*s));
            most / v.iter().fold(f64::INFINITY, |m, s| m.min(*s))
        };
        let scaled = |m: &Mat<f64>| Mat::from_fn(n, n, |i, j| m[(i, j)] * rows[i] * columns[j]);
        Self {
            a: scaled(a),
            b: scaled(b),
            is_graded: n > 1 && spread(&rows).max(spread(&columns)) > GRADED,
        }
    }
}

/// u and v with u_i + v_j <= cost_ij, and equality along the cheapest permutation; none where that has to use an
/// absent entry. Successive shortest paths, O(n³).
fn potentials(n: usize, cost: impl Fn(usize, usize) -> f64) -> Option<(Vec<f64>, Vec<f64>)> {
    // Places are counted from 1; 0 stands for the row that looks for a column.
    let (mut u, mut v) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    let mut row_of = vec![0; n + 1];
    for row in 1..=n {
        let mut least = vec![f64::INFINITY; n + 1];
        let (mut used, mut way) = (vec![false; n + 1], vec![0; n + 1]);
        row_of[0] = row;
        let mut column = 0;
        while row_of[column] != 0 {
            used[column] = true;
            let (from, mut next, mut step) = (row_of[column], 0, f64::INFINITY);
            for j in (1..=n).filter(|&j| !used[j]) {
                let reduced = cost(from - 1, j - 1) - u[from] - v[j];
                if reduced < least[j] {
                    (least[j], way[j]) = (reduced, column);
                }
                if least[j] < step {
                    (step, next) = (least[j], j);
                }
            }
            for j in 0..=n {
                if used[j] {
                    u[row_of[j]] += step;
                    v[j] -= step;
                } else {
                    least[j] -= step;
                }
            }
            column = next;
        }
        while column != 0 {
            row_of[column] = row_of[way[column]];
            column = way[column];
        }
    }
    let absent = (1..=n).any(|j| cost(row_of[j] - 1, j - 1) >= ABSENT);
    (!absent).then(|| (u[1..].to_vec(), v[1..].to_vec()))
}

#[cfg(test)]
mod tests;
