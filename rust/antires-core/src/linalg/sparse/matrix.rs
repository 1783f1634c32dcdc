//! A symmetric matrix on a fixed pattern.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::pattern::Pattern;
use crate::linalg::wide::{LANES, total};

/// Values on a [`Pattern`], which other matrices may share.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    pattern: Arc<Pattern>,
    /// One for each place, in its order.
    pub values: Vec<f64>,
}

impl SparseMatrix {
    /// Zero matrix.
    #[must_use]
    pub fn new(pattern: Arc<Pattern>) -> Self {
        let values = vec![0.0; pattern.len()];
        Self { pattern, values }
    }

    /// A dense symmetric matrix, every place of it.
    #[must_use]
    pub fn full(dense: MatRef<'_, f64>) -> Self {
        let n = dense.nrows() as u32;
        let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let mut matrix = Self::new(Arc::new(Pattern::new(n as usize, places)));
        for j in 0..dense.ncols() {
            for i in 0..dense.nrows() {
                matrix.add(i, j, dense[(i, j)]);
            }
        }
        matrix
    }

    /// The places of its entries.
    #[must_use]
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Entry (i, j), zero outside the pattern.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.pattern.find(i, j).map_or(0.0, |at| self.values[at])
    }

    /// Diagonal entry `j`.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        self.get(j, j)
    }

    /// Adds to the entry (i, j), which has to be a place of the pattern.
    ///
    /// # Panics
    /// If it is none.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.pattern.find(i, j).expect("a place of the pattern");
        self.values[at] += value;
    }

    /// Puts zeros into row and column `j`, and one on the diagonal.
    pub fn pin(&mut self, j: usize) {
        for at in self.pattern.starts()[j]..self.pattern.starts()[j + 1] {
            let i = self.pattern.rows()[at] as usize;
            self.values[at] = f64::from(u8::from(i == j));
            if let Some(mirrored) = self.pattern.find(j, i).filter(|_| i != j) {
                self.values[mirrored] = 0.0;
            }
        }
    }

    /// All places (row, column) with their values, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.n()).flat_map(move |j| {
            let range = self.pattern.starts()[j]..self.pattern.starts()[j + 1];
            range.map(move |at| (self.pattern.rows()[at] as usize, j, self.values[at]))
        })
    }

    /// Largest modulus of the entries.
    #[must_use]
    pub fn norm_max(&self) -> f64 {
        self.values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
    }

    /// The same as a dense matrix.
    #[must_use]
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.n(), self.n());
        self.write_dense(&mut dense);
        dense
    }

    /// [`to_dense`](Self::to_dense) into a matrix that is zero outside the pattern.
    pub fn write_dense(&self, dense: &mut Mat<f64>) {
        for j in 0..self.n() {
            let range = self.pattern.starts()[j]..self.pattern.starts()[j + 1];
            let column = dense.col_as_slice_mut(j);
            for at in range {
                column[self.pattern.rows()[at] as usize] = self.values[at];
            }
        }
    }

    /// The dense matrix without row `i` and column `k`.
    #[must_use]
    pub fn deleted(&self, i: usize, k: usize) -> Mat<f64> {
        let n = self.n();
        let mut dense = Mat::zeros(n - 1, n - 1);
        for (row, column, value) in self.entries() {
            if row != i && column != k {
                let at = (row - usize::from(row > i), column - usize::from(column > k));
                dense[at] = value;
            }
        }
        dense
    }

    /// y = A x.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let (starts, rows) = (self.pattern.starts(), self.pattern.rows());
        for j in 0..self.n() {
            let range = starts[j]..starts[j + 1];
            // Symmetric: column j is row j.
            y[j] = gathered_dot(&self.values[range.clone()], &rows[range], x);
        }
    }

    /// Σ |x_i| |A_ij| |x_j|: how far one ulp in each entry can move xᵀ A x, over ulp.
    #[must_use]
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        self.summed(|i, j, a| (x[i] * a * x[j]).abs())
    }

    /// Σ (w_i A_ij u_j)²: the square of how far one ulp of random sign in each entry moves wᵀ A u, over ulp.
    #[must_use]
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        self.summed(|i, j, a| (w[i] * a * u[j]).powi(2))
    }

    fn summed(&self, term: impl Fn(usize, usize, f64) -> f64) -> f64 {
        let (starts, rows) = (self.pattern.starts(), self.pattern.rows());
        let column = |j: usize| {
            let range = starts[j]..starts[j + 1];
            let pairs = self.values[range.clone()].iter().zip(&rows[range]);
            pairs.map(|(&a, &i)| term(i as usize, j, a)).sum::<f64>()
        };
        (0..self.n()).map(column).sum()
    }
}

/// Σ a_q x_(rows_q), in sums side by side: one alone waits for each addition.
#[inline]
fn gathered_dot(a: &[f64], rows: &[u32], x: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (rows, rows_rest) = rows.as_chunks::<LANES>();
    for (a, rows) in a.iter().zip(rows) {
        for l in 0..LANES {
            sums[l] += a[l] * x[rows[l] as usize];
        }
    }
    let rest = a_rest.iter().zip(rows_rest);
    total(sums) + rest.map(|(a, &row)| a * x[row as usize]).sum::<f64>()
}

#[cfg(test)]
mod tests;
