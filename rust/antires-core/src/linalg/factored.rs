//! Factors of K + cM, in band or in sparse form.

use super::banded::Banded;
use super::form::Form;
use super::sparse::{SparseFactors, SparseMatrix};

/// Factors of K + cM, with the memory to form them again.
pub enum Factors {
    /// Of band matrices.
    Band(Banded),
    /// Of sparse ones: what was factorized, and its factors.
    Sparse(SparseMatrix, SparseFactors),
}

/// What the factors tell of the matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signs {
    /// Number of negative pivots.
    pub negative: usize,
    /// Growth of the factors relative to the matrix.
    pub growth: f64,
}

impl Factors {
    /// Factorizes `k` + `c` `m`, all in the form that this is for, with row and column `pinned` replaced by
    /// those of the identity.
    ///
    /// # Panics
    /// For matrices of another form.
    pub fn factorize(&mut self, k: &Form, c: f64, m: &Form, pinned: Option<usize>) -> Signs {
        let (negative, growth) = match (self, k, m) {
            (Self::Band(factors), Form::Band(k), Form::Band(m)) => {
                factors.combine(k, c, m);
                if let Some(row) = pinned {
                    factors.pin(row);
                }
                factors.factorize()
            }
            (Self::Sparse(sum, factors), Form::Sparse(k), Form::Sparse(m)) => {
                for (out, (k, m)) in sum.values.iter_mut().zip(k.values.iter().zip(&m.values)) {
                    *out = k + c * m;
                }
                if let Some(row) = pinned {
                    sum.pin(row);
                }
                factors.factorize(sum)
            }
            _ => unreachable!("matrices and factors of one structure have one form"),
        };
        Signs { negative, growth }
    }

    /// Number of negative pivots among the rows that `counts` tells.
    #[must_use]
    pub fn negative_in(&self, counts: impl Fn(usize) -> bool) -> usize {
        let pivots = match self {
            Self::Band(factors) => factors.inverse_pivots(),
            Self::Sparse(_, factors) => factors.inverse_pivots(),
        };
        // NaN is not positive.
        let negative = |&row: &usize| !(pivots[row] > 0.0) && counts(row);
        (0..pivots.len()).filter(negative).count()
    }

    /// Solves in place with the factors last made.
    pub fn solve(&self, x: &mut [f64]) {
        match self {
            Self::Band(factors) => factors.solve(x),
            Self::Sparse(_, factors) => factors.solve(x),
        }
    }
}
