//! A candidate and its cost.

use super::super::bounds::Bounds;

/// Two points are one where every gene agrees to this fraction of its range.
const SAME: f64 = 1e-6;

/// A candidate and its cost.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::optimize) struct Point {
    pub(in crate::optimize) x: Vec<f64>,
    pub(in crate::optimize) cost: f64,
}

impl Point {
    /// Moves to `x`, whatever it costs.
    pub(super) fn settle(&mut self, x: &[f64], cost: f64) {
        self.x.copy_from_slice(x);
        self.cost = cost;
    }

    /// Moves to `x` where that costs less.
    pub(super) fn take(&mut self, x: &[f64], cost: f64) {
        if cost < self.cost {
            self.settle(x, cost);
        }
    }
}

/// Whether the two candidates are the same, as far as a polish can tell.
pub(super) fn same(bounds: &Bounds, a: &[f64], b: &[f64]) -> bool {
    let (lower, upper) = (bounds.lower(), bounds.upper());
    (0..a.len()).all(|i| (a[i] - b[i]).abs() <= SAME * (upper[i] - lower[i]))
}
