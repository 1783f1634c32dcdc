//! The subproblem of a descent: the norm of linear residuals and a price, over a box.
//!
//! ```text
//! min_d  Σ |e_i + (A d)_i| + cᵀ d    or    Σ (e_i + (A d)_i)² + cᵀ d,        low <= d <= high
//! ```

use super::super::composition::Norm;

/// The model and its box.
pub(super) struct Subproblem<'a> {
    pub(super) norm: Norm,
    /// e, m of them.
    pub(super) residuals: &'a [f64],
    /// A, m x n, row by row.
    pub(super) jacobian: &'a [f64],
    /// c, n of them.
    pub(super) price: &'a [f64],
    /// Lower ends of the box; each below its upper end.
    pub(super) low: &'a [f64],
    /// Upper ends of the box.
    pub(super) high: &'a [f64],
}

impl Subproblem<'_> {
    /// The value of the model at `d`, without the price of the point the step starts from.
    pub(super) fn value(&self, d: &[f64]) -> f64 {
        let norm: f64 = self
            .residuals
            .iter()
            .zip(self.times(d))
            .map(|(e, change)| match self.norm {
                Norm::Absolute => (e + change).abs(),
                Norm::Squared => (e + change).powi(2),
            })
            .sum();
        norm + dot(self.price, d)
    }

    /// A d.
    pub(super) fn times(&self, d: &[f64]) -> Vec<f64> {
        self.jacobian
            .chunks_exact(d.len())
            .map(|row| dot(row, d))
            .collect()
    }

    /// Aᵀ y.
    pub(super) fn transposed_times(&self, y: &[f64]) -> Vec<f64> {
        let n = self.low.len();
        let mut sum = vec![0.0; n];
        for (row, &y) in self.jacobian.chunks_exact(n).zip(y) {
            for (sum, a) in sum.iter_mut().zip(row) {
                *sum += y * a;
            }
        }
        sum
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
