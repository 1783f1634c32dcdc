//! The signs of D, and the growth of the factors.

use super::blocks::blocks;
use super::symbolic::Symbolic;
use crate::linalg::wide::{self, NullaryFnOnce};

/// Number of negative pivots and growth of the factors, NaN where one is not a number; the inverse pivots.
pub(super) struct Pivots<'a> {
    pub symbolic: &'a Symbolic,
    pub values: &'a [f64],
    pub inverse: &'a mut [f64],
}

impl NullaryFnOnce for Pivots<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let (mut negative, mut growth) = (0, 0.0_f64);
        for block in blocks(self.symbolic) {
            for c in 0..block.width {
                let column = &block.column(self.values, c)[c..];
                let pivot = column[0];
                negative += usize::from(pivot < 0.0);
                self.inverse[block.first + c] = pivot.recip();
                let largest = wide::largest(&column[1..]);
                let size = if largest > 1.0 {
                    largest * largest
                } else {
                    1.0 + 0.0 * largest
                };
                let size = size * pivot.abs();
                // NaN stays.
                growth = if size <= growth { growth } else { size };
                if growth.is_nan() {
                    return (negative, growth);
                }
            }
        }
        (negative, growth)
    }
}
