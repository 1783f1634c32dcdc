//! Symmetric band matrices: product, A = L D Lᵀ, and the count of eigenvalues below a shift.
//!
//! Column j of the lower triangle is stored from its diagonal down, `half` entries below it. The factors
//! are formed without pivoting: stable for a positive definite A. For K − xM, which is not, only the signs
//! of D are used. By Sylvester's law as many of them are negative as there are eigenvalues of
//! K φ = λ M φ below x; the growth of the factors tells how far rounding may have shifted x.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 4.3 and 8.4.

use crate::linalg::wide::NullaryFnOnce;

use super::wide::{self, LANES, dot, subtract};

/// Growth of the factors, relative to the matrix, at which they are no longer trusted: rounding is then
/// still below 1e-9 of the matrix.
pub const LARGEST_GROWTH: f64 = 1e6;

/// A symmetric band matrix, or its factors L (unit, below the diagonal) and D.
#[derive(Debug, Clone, Default)]
pub struct Banded {
    n: usize,
    /// Diagonals below the main one.
    band: usize,
    /// Their number padded to whole lanes.
    half: usize,
    diagonal: Vec<f64>,
    /// Column j below the diagonal at j half; `half` columns of zeros follow, so that no loop needs a
    /// shorter end.
    below: Vec<f64>,
    /// 1 / D of the factors.
    inverse: Vec<f64>,
}

impl Banded {
    /// Zero matrix of `n` rows with `band` diagonals below the main one.
    #[must_use]
    pub fn new(n: usize, band: usize) -> Self {
        let half = band.next_multiple_of(LANES);
        Self {
            n,
            band,
            half,
            diagonal: vec![0.0; n + half],
            below: vec![0.0; (n + half) * half],
            inverse: vec![0.0; n],
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// Entries by which vectors are longer than n, to be kept at zero.
    #[must_use]
    pub fn half(&self) -> usize {
        self.half
    }

    /// Zero matrix again.
    pub fn clear(&mut self) {
        self.diagonal.fill(0.0);
        self.below.fill(0.0);
    }

    /// Sets the entry (row, column), row >= column, within the band.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        if row == column {
            self.diagonal[row] = value;
        } else {
            self.below[column * self.half + row - column - 1] = value;
        }
    }

    /// self = a + factor · b, all of one shape.
    pub fn combine(&mut self, a: &Self, factor: f64, b: &Self) {
        for (out, a, b) in [
            (&mut self.diagonal, &a.diagonal, &b.diagonal),
            (&mut self.below, &a.below, &b.below),
        ] {
            for ((out, &x), &y) in out.iter_mut().zip(a).zip(b) {
                *out = x + factor * y;
            }
        }
    }

    /// Puts zeros into row and column `i`, and one on the diagonal.
    pub fn pin(&mut self, i: usize) {
        for d in 1..=self.band.min(i) {
            self.below[(i - d) * self.half + d - 1] = 0.0;
        }
        self.below[i * self.half..(i + 1) * self.half].fill(0.0);
        self.diagonal[i] = 1.0;
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &[f64] {
        &self.below[j * self.half..(j + 1) * self.half]
    }

    /// Diagonal entry j, of the matrix or of D.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        self.diagonal[j]
    }

    /// y = A x; both have [`half`](Self::half) more entries than A has rows, zero in x and of no meaning in
    /// y.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        wide::run(Multiply { matrix: self, x, y });
    }

    /// Σ |x_i| |A_ij| |x_j|: how far one ulp in each entry can move xᵀ A x, over ulp.
    #[must_use]
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| {
                let rows = self.column(j).iter().zip(&x[j + 1..]);
                let below: f64 = rows.map(|(a, xi)| (a * xi).abs()).sum();
                x[j].abs() * (self.diagonal[j].abs() * x[j].abs() + 2.0 * below)
            })
            .sum()
    }

    /// Σ (w_i A_ij u_j)²: the square of how far one ulp of random sign in each entry moves wᵀ A u, over ulp.
    #[must_use]
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| {
                let pairs = w[j + 1..].iter().zip(&u[j + 1..]);
                let rows = self.column(j).iter().zip(pairs);
                let below: f64 = rows
                    .map(|(a, (wi, ui))| (a * wi * u[j]).powi(2) + (a * w[j] * ui).powi(2))
                    .sum();
                (w[j] * self.diagonal[j] * u[j]).powi(2) + below
            })
            .sum()
    }

    /// Replaces A by its factors; returns the number of negative entries of D and the growth of the
    /// factors relative to A.
    pub fn factorize(&mut self) -> (usize, f64) {
        let larger = |m: f64, a: &f64| m.max(a.abs());
        let largest = self.diagonal.iter().fold(0.0, larger);
        let largest = self.below.iter().fold(largest, larger);
        let (half, mut negative, mut growth) = (self.half, 0, 0.0_f64);
        for j in 0..self.n {
            if self.diagonal[j] == 0.0 {
                // A pivot of exactly zero: the least shift of the matrix that makes it regular.
                self.diagonal[j] = f64::EPSILON * largest + f64::MIN_POSITIVE;
            }
            let pivot = self.diagonal[j];
            // NaN is not positive.
            negative += usize::from(!(pivot > 0.0));
            let inverse = pivot.recip();
            self.inverse[j] = inverse;
            let (done, rest) = self.below.split_at_mut((j + 1) * half);
            let column = &mut done[j * half..];
            for c in 0..self.band {
                let l = column[c] * inverse;
                if l != 0.0 {
                    self.diagonal[j + 1 + c] -= l * column[c];
                    let target = &mut rest[c * half..(c + 1) * half - c - 1];
                    for (t, &a) in target.iter_mut().zip(&column[c + 1..]) {
                        *t -= l * a;
                    }
                }
            }
            for l in column {
                growth = growth.max((*l * *l * inverse).abs());
                *l *= inverse;
            }
            growth = growth.max(pivot.abs());
        }
        (negative, growth / largest.max(f64::MIN_POSITIVE))
    }

    /// 1 / D of the factors.
    #[must_use]
    pub fn inverse_pivots(&self) -> &[f64] {
        &self.inverse
    }

    /// x = A⁻¹ x from the factors; x has [`half`](Self::half) more entries than A has rows, kept at zero.
    pub fn solve(&self, x: &mut [f64]) {
        wide::run(Solve { factors: self, x });
    }

    /// Whether the matrix is positive definite by more than `least` of each diagonal entry; the matrix is
    /// replaced by its factors.
    pub fn factorize_definite(&mut self, least: f64) -> bool {
        let diagonal: Vec<f64> = (0..self.n).map(|j| self.diagonal(j)).collect();
        self.factorize();
        // NaN compares false.
        (0..self.n).all(|j| self.diagonal(j) > least * diagonal[j])
    }
}

/// [`Banded::solve`].
struct Solve<'a> {
    factors: &'a Banded,
    x: &'a mut [f64],
}

impl NullaryFnOnce for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { factors, x } = self;
        let (n, half) = (factors.n, factors.half);
        for j in 0..n {
            let (head, rows) = x[j..=j + half].split_at_mut(1);
            subtract(rows, head[0], factors.column(j));
        }
        x[n..].fill(0.0);
        for (x, inverse) in x.iter_mut().zip(&factors.inverse) {
            *x *= inverse;
        }
        for j in (0..n).rev() {
            let (head, rows) = x[j..=j + half].split_at_mut(1);
            head[0] -= dot(factors.column(j), rows);
        }
    }
}

/// [`Banded::multiply`].
struct Multiply<'a> {
    matrix: &'a Banded,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl NullaryFnOnce for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { matrix, x, y } = self;
        y.fill(0.0);
        for j in 0..matrix.n {
            let (column, xj) = (matrix.column(j), x[j]);
            let (head, rows) = y[j..=j + matrix.half].split_at_mut(1);
            subtract(rows, -xj, column);
            head[0] += matrix.diagonal[j] * xj + dot(column, &x[j + 1..=j + matrix.half]);
        }
    }
}

#[cfg(test)]
mod tests;
