//! A = L D Lᵀ of a sparse matrix, without pivoting: stable for a positive definite A. Of K − xM, which is not,
//! the growth of the factors tells how far rounding may have gone, as in [`super::super::banded`].
//!
//! faer forms the values, block by block (module `blocks`).

use std::sync::Arc;

use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::{
    factorize_supernodal_numeric_ldlt, factorize_supernodal_numeric_ldlt_scratch,
};

use super::matrix::SparseMatrix;
use super::pivots::Pivots;
use super::several::{self, Row};
use super::solution::Solution;
use super::symbolic::Symbolic;
use crate::linalg::wide;

/// Factors of the matrices of one pattern, in the order of its [`Symbolic`] analysis.
pub struct SparseFactors {
    symbolic: Arc<Symbolic>,
    /// L by blocks of columns, D on its diagonal.
    values: Vec<f64>,
    inverse: Vec<f64>,
    memory: MemBuffer,
}

impl SparseFactors {
    /// Reserves the memory.
    #[must_use]
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let needed = factorize_supernodal_numeric_ldlt_scratch::<u32, f64>(
            symbolic.supernodes(),
            Par::Seq,
            Default::default(),
        );
        Self {
            values: Vec::new(),
            inverse: vec![0.0; symbolic.pattern().n()],
            memory: MemBuffer::new(needed),
            symbolic,
        }
    }

    /// The analysis of the pattern.
    #[must_use]
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// Factorizes `a`, whose pattern is that of the analysis in the new order; returns the number of negative
    /// entries of D and the growth of the factors relative to A, infinite where a pivot is exactly zero.
    pub fn factorize(&mut self, a: &SparseMatrix) -> (usize, f64) {
        self.values.resize(self.symbolic.n_values(), 0.0);
        let matrix = SparseColMatRef::new(self.symbolic.matrix(), &a.values);
        let done = factorize_supernodal_numeric_ldlt(
            &mut self.values,
            matrix,
            Default::default(),
            self.symbolic.supernodes(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        if done.is_err() {
            return (0, f64::INFINITY);
        }
        let (negative, growth) = wide::run(Pivots {
            symbolic: &self.symbolic,
            values: &self.values,
            inverse: &mut self.inverse,
        });
        if growth.is_nan() {
            return (0, f64::INFINITY);
        }
        (negative, growth / a.norm_max().max(f64::MIN_POSITIVE))
    }

    /// Whether `a`, whose pattern is the one analysed, is definite; it is factorized.
    pub fn factorize_moved(&mut self, a: &SparseMatrix) -> Definiteness {
        let mut moved = SparseMatrix::new(Arc::clone(self.symbolic.pattern()));
        for (value, &at) in moved.values.iter_mut().zip(self.symbolic.origin()) {
            *value = a.values[at];
        }
        match self.factorize(&moved) {
            (0, growth) if growth.is_finite() => Definiteness::Positive,
            _ => Definiteness::Not,
        }
    }

    /// 1 / D.
    #[must_use]
    pub fn inverse_pivots(&self) -> &[f64] {
        &self.inverse
    }

    /// X = A⁻¹ X, several columns at once.
    pub fn solve_several(&self, x: &mut [Row]) {
        wide::run(several::Solve {
            symbolic: &self.symbolic,
            values: &self.values,
            inverse: &self.inverse,
            x,
        });
    }

    /// x = A⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        wide::run(Solution {
            symbolic: &self.symbolic,
            values: &self.values,
            inverse: &self.inverse,
            x,
        });
    }
}

/// Whether all pivots are above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Definiteness {
    /// They are.
    Positive,
    /// One is not.
    Not,
}

#[cfg(test)]
mod tests;
