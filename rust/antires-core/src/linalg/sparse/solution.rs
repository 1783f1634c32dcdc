//! x = A⁻¹ x with the factors L D Lᵀ: L is read twice in the order of its memory, several columns at once.

use super::blocks::{Block, blocks};
use super::symbolic::Symbolic;
use crate::linalg::wide::{COLUMNS, NullaryFnOnce, dot, dot_block, subtract, subtract_block};

/// A solution in place.
pub(super) struct Solution<'a> {
    pub symbolic: &'a Symbolic,
    pub values: &'a [f64],
    /// 1 / D.
    pub inverse: &'a [f64],
    pub x: &'a mut [f64],
}

impl NullaryFnOnce for Solution<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            symbolic,
            values,
            inverse,
            x,
        } = self;
        // The rows of a block: its own, then those below.
        let mut rows: Vec<f64> = Vec::new();
        for block in blocks(symbolic) {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.resize(block.height, 0.0);
            forward(&block, values, &mut rows);
            let (head, below) = rows.split_at(block.width);
            x[own].copy_from_slice(head);
            for (&row, value) in block.rows.iter().zip(below) {
                x[row as usize] += value;
            }
        }
        for (x, inverse) in x.iter_mut().zip(inverse) {
            *x *= inverse;
        }
        for block in blocks(symbolic).rev() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.extend(block.rows.iter().map(|&row| x[row as usize]));
            backward(&block, values, &mut rows);
            x[own].copy_from_slice(&rows[..block.width]);
        }
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
        subtract_block(&mut rows[c..], head, columns.map(|column| &column[c..]));
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
        let taken = dot_block(columns.map(|column| &column[end..]), &rows[end..]);
        for q in (0..COLUMNS).rev() {
            let own: f64 = (q + 1..COLUMNS)
                .map(|r| columns[q][c + r] * rows[c + r])
                .sum();
            rows[c + q] -= taken[q] + own;
        }
    }
}
