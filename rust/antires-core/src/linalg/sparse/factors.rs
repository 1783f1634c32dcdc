//! A = L D Lᵀ of a sparse matrix, without pivoting: stable for a positive definite A. Of K − xM, which is not,
//! the growth of the factors tells how far rounding may have gone, as in [`super::super::banded`].
//!
//! faer forms the values, block by block. Column after column of a block is contiguous, so that a solution
//! reads L twice in the order of its memory.

use std::sync::Arc;

use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::{
    factorize_supernodal_numeric_ldlt, factorize_supernodal_numeric_ldlt_scratch,
};

use super::matrix::SparseMatrix;
use super::symbolic::Symbolic;
use crate::linalg::wide::{self, COLUMNS, NullaryFnOnce, dot, subtract};

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

    /// x = A⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        wide::run(Solve { factors: self, x });
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

/// A block of columns of one structure.
struct Block<'a> {
    first: usize,
    width: usize,
    height: usize,
    /// Where its values begin.
    values: usize,
    /// Rows below the diagonal block.
    rows: &'a [u32],
}

fn block(symbolic: &Symbolic, s: usize) -> Block<'_> {
    let nodes = symbolic.supernodes();
    let (first, end) = (nodes.supernode_begin()[s], nodes.supernode_end()[s]);
    let rows = nodes.supernode(s).pattern();
    let width = (end - first) as usize;
    Block {
        first: first as usize,
        width,
        height: width + rows.len(),
        values: nodes.col_ptr_for_val()[s] as usize,
        rows,
    }
}

fn blocks(symbolic: &Symbolic) -> impl DoubleEndedIterator<Item = Block<'_>> {
    (0..symbolic.supernodes().n_supernodes()).map(|s| block(symbolic, s))
}

/// [`SparseFactors::solve`].
struct Solve<'a> {
    factors: &'a SparseFactors,
    x: &'a mut [f64],
}

impl NullaryFnOnce for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { factors, x } = self;
        // The rows of a block: its own, then those below.
        let mut rows: Vec<f64> = Vec::new();
        for block in blocks(&factors.symbolic) {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.resize(block.height, 0.0);
            forward(&block, &factors.values, &mut rows);
            let (head, below) = rows.split_at(block.width);
            x[own].copy_from_slice(head);
            for (&row, value) in block.rows.iter().zip(below) {
                x[row as usize] += value;
            }
        }
        for (x, inverse) in x.iter_mut().zip(&factors.inverse) {
            *x *= inverse;
        }
        for block in blocks(&factors.symbolic).rev() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.extend(block.rows.iter().map(|&row| x[row as usize]));
            backward(&block, &factors.values, &mut rows);
            x[own].copy_from_slice(&rows[..block.width]);
        }
    }
}

impl Block<'_> {
    /// Column `c` of L.
    #[inline(always)]
    fn column<'v>(&self, values: &'v [f64], c: usize) -> &'v [f64] {
        &values[self.values + c * self.height..][..self.height]
    }
}

/// Takes the own rows times L from those below them.
#[inline(always)]
fn forward(block: &Block<'_>, values: &[f64], rows: &mut [f64]) {
    let mut c = 0;
    while c + COLUMNS <= block.width {
        let columns: [&[f64]; COLUMNS] = std::array::from_fn(|q| block.column(values, c + q));
        for q in 0..COLUMNS {
            for r in q + 1..COLUMNS {
                rows[c + r] -= rows[c + q] * columns[q][c + r];
            }
        }
        let head = std::array::from_fn(|q| rows[c + q]);
        c += COLUMNS;
        wide::subtract_block(&mut rows[c..], head, columns.map(|column| &column[c..]));
    }
    for c in c..block.width {
        let (head, rest) = rows.split_at_mut(c + 1);
        subtract(rest, head[c], &block.column(values, c)[c + 1..]);
    }
}

/// Takes Lᵀ times the rows below from the own ones.
#[inline(always)]
fn backward(block: &Block<'_>, values: &[f64], rows: &mut [f64]) {
    let blocked = block.width / COLUMNS * COLUMNS;
    for c in (blocked..block.width).rev() {
        let (head, rest) = rows.split_at_mut(c + 1);
        head[c] -= dot(&block.column(values, c)[c + 1..], rest);
    }
    for c in (0..blocked).step_by(COLUMNS).rev() {
        let columns: [&[f64]; COLUMNS] = std::array::from_fn(|q| block.column(values, c + q));
        let end = c + COLUMNS;
        let taken = wide::dot_block(columns.map(|column| &column[end..]), &rows[end..]);
        for q in (0..COLUMNS).rev() {
            let own: f64 = (q + 1..COLUMNS)
                .map(|r| columns[q][c + r] * rows[c + r])
                .sum();
            rows[c + q] -= taken[q] + own;
        }
    }
}

/// Number of negative pivots and growth of the factors, NaN where one is not a number; the inverse pivots.
struct Pivots<'a> {
    symbolic: &'a Symbolic,
    values: &'a [f64],
    inverse: &'a mut [f64],
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

#[cfg(test)]
mod tests;
