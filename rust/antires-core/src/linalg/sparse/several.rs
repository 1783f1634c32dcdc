//! X = A⁻¹ X with the factors L D Lᵀ, and Y = A X, for [`LANES`] columns at once: L and A are read once for all.
//!
//! The columns lie side by side: what is read of L or A meets a whole row of X.

use super::blocks::{Block, blocks};
use super::matrix::SparseMatrix;
use super::symbolic::Symbolic;
use crate::linalg::wide::{self, COLUMNS, LANES, NullaryFnOnce};

/// One row of the columns.
pub type Row = [f64; LANES];

/// Columns of L that are read side by side on the way back, where each has sums of its own.
const BACK: usize = 4;

/// [`SparseFactors::solve_several`](super::SparseFactors::solve_several).
pub(super) struct Solve<'a> {
    pub symbolic: &'a Symbolic,
    pub values: &'a [f64],
    /// 1 / D.
    pub inverse: &'a [f64],
    pub x: &'a mut [Row],
}

impl NullaryFnOnce for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (values, x) = (self.values, self.x);
        let mut rows: Vec<Row> = Vec::new();
        for block in blocks(self.symbolic) {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.resize(block.height, [0.0; LANES]);
            forward(&block, values, &mut rows);
            let (head, below) = rows.split_at(block.width);
            x[own].copy_from_slice(head);
            for (&row, value) in block.rows.iter().zip(below) {
                for (x, value) in x[row as usize].iter_mut().zip(value) {
                    *x += value;
                }
            }
        }
        for (row, inverse) in x.iter_mut().zip(self.inverse) {
            row.iter_mut().for_each(|x| *x *= inverse);
        }
        for block in blocks(self.symbolic).rev() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.extend(block.rows.iter().map(|&row| x[row as usize]));
            backward(&block, values, &mut rows);
            x[own].copy_from_slice(&rows[..block.width]);
        }
    }
}

/// x −= l a.
#[inline(always)]
pub fn take(x: &mut Row, l: f64, a: &Row) {
    for w in 0..LANES {
        x[w] -= l * a[w];
    }
}

/// Takes the own rows times L from those below them.
#[inline(always)]
fn forward(block: &Block<'_>, values: &[f64], rows: &mut [Row]) {
    let mut c = 0;
    while c + COLUMNS <= block.width {
        let columns: [&[f64]; COLUMNS] =
            std::array::from_fn(|q| &block.column(values, c + q)[c..block.height]);
        let (head, below) = rows[c..].split_at_mut(COLUMNS);
        for q in 0..COLUMNS {
            for r in q + 1..COLUMNS {
                let own = head[q];
                take(&mut head[r], columns[q][r], &own);
            }
        }
        let columns = columns.map(|column| &column[COLUMNS..][..below.len()]);
        for (r, row) in below.iter_mut().enumerate() {
            let mut sum = *row;
            for q in 0..COLUMNS {
                take(&mut sum, columns[q][r], &head[q]);
            }
            *row = sum;
        }
        c += COLUMNS;
    }
    for c in c..block.width {
        let (head, below) = rows[c..].split_at_mut(1);
        let column = &block.column(values, c)[c + 1..];
        for (row, &l) in below.iter_mut().zip(column) {
            take(row, l, &head[0]);
        }
    }
}

/// Takes Lᵀ times the rows below from the own ones.
#[inline(always)]
fn backward(block: &Block<'_>, values: &[f64], rows: &mut [Row]) {
    let paired = block.width / BACK * BACK;
    for c in (paired..block.width).rev() {
        let (head, below) = rows[c..].split_at_mut(1);
        for (row, &l) in below.iter().zip(&block.column(values, c)[c + 1..]) {
            take(&mut head[0], l, row);
        }
    }
    for c in (0..paired).step_by(BACK).rev() {
        let columns: [&[f64]; BACK] =
            std::array::from_fn(|q| &block.column(values, c + q)[c..block.height]);
        let (head, below) = rows[c..].split_at_mut(BACK);
        let mut own: [Row; BACK] = std::array::from_fn(|q| head[q]);
        let under = columns.map(|column| &column[BACK..][..below.len()]);
        for (r, row) in below.iter().enumerate() {
            for q in 0..BACK {
                take(&mut own[q], under[q][r], row);
            }
        }
        for q in (0..BACK).rev() {
            for r in q + 1..BACK {
                let done = own[r];
                take(&mut own[q], columns[q][r], &done);
            }
        }
        head.copy_from_slice(&own);
    }
}

/// The entries of a symmetric matrix that are not zero, for products with several columns at once.
#[derive(Debug, Clone, Default)]
pub struct Filled {
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Filled {
    /// Those of `a`.
    #[must_use]
    pub fn of(a: &SparseMatrix) -> Self {
        let pattern = a.pattern();
        let mut filled = Self::default();
        filled.starts.push(0);
        for j in 0..pattern.n() {
            let range = pattern.starts()[j]..pattern.starts()[j + 1];
            for (&value, &row) in a.values[range].iter().zip(pattern.column(j)) {
                if value != 0.0 {
                    filled.rows.push(row);
                    filled.values.push(value);
                }
            }
            filled.starts.push(filled.rows.len());
        }
        filled
    }

    /// Y = A X.
    pub fn multiply(&self, x: &[Row], y: &mut [Row]) {
        wide::run(Multiply { a: self, x, y });
    }
}

/// [`Filled::multiply`].
struct Multiply<'a> {
    a: &'a Filled,
    x: &'a [Row],
    y: &'a mut [Row],
}

impl NullaryFnOnce for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (a, x, y) = (self.a, self.x, self.y);
        for (range, y) in a.starts.windows(2).zip(y) {
            let (start, end) = (range[0], range[1]);
            let mut sum = [0.0; LANES];
            // Symmetric: column j is row j.
            for (&value, &row) in a.values[start..end].iter().zip(&a.rows[start..end]) {
                take(&mut sum, -value, &x[row as usize]);
            }
            *y = sum;
        }
    }
}
