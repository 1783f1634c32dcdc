//! Cholesky factors of several matrices side by side, packed by rows.

use crate::linalg::wide::{NullaryFnOnce, run};

/// Matrices side by side.
pub const SIDE: usize = 12;

/// One entry of all of them.
pub type Entry = [f64; SIDE];

/// Least pivot: covariances of measured values are larger.
const LEAST: f64 = 1e-24;

/// Where row i begins.
#[must_use]
pub const fn row(i: usize) -> usize {
    i * (i + 1) / 2
}

struct Factors<'a> {
    a: &'a mut [Entry],
    size: usize,
}

impl NullaryFnOnce for Factors<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for i in 0..self.size {
            let (above, here) = self.a.split_at_mut(row(i));
            for j in 0..=i {
                let mut sum = here[j];
                if j < i {
                    let other = &above[row(j)..=row(j) + j];
                    for (x, y) in here[..j].iter().zip(&other[..j]) {
                        for l in 0..SIDE {
                            sum[l] -= x[l] * y[l];
                        }
                    }
                    for l in 0..SIDE {
                        sum[l] /= other[j][l];
                    }
                } else {
                    for x in &here[..j] {
                        for l in 0..SIDE {
                            sum[l] -= x[l] * x[l];
                        }
                    }
                    for l in 0..SIDE {
                        sum[l] = sum[l].max(LEAST).sqrt();
                    }
                }
                here[j] = sum;
            }
        }
    }
}

/// L of L Lᵀ = A for all matrices, in place.
pub fn factorize(a: &mut [Entry], size: usize) {
    run(Factors { a, size });
}

/// L⁻¹ b for all of them.
#[must_use]
pub fn whitened(factors: &[Entry], b: &[f64]) -> Vec<Entry> {
    let mut white: Vec<Entry> = Vec::with_capacity(b.len());
    for (i, &value) in b.iter().enumerate() {
        let own = &factors[row(i)..=row(i) + i];
        let mut sum = [value; SIDE];
        for (x, w) in own.iter().zip(&white) {
            for l in 0..SIDE {
                sum[l] -= x[l] * w[l];
            }
        }
        for l in 0..SIDE {
            sum[l] /= own[i][l];
        }
        white.push(sum);
    }
    white
}

struct Solve<'a> {
    factors: &'a [Entry],
    which: usize,
    rows: &'a mut [f64],
    width: usize,
}

impl NullaryFnOnce for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let size = self.rows.len() / self.width;
        for i in 0..size {
            let (before, rest) = self.rows.split_at_mut(i * self.width);
            let own = &mut rest[..self.width];
            for (k, other) in before.chunks_exact(self.width).enumerate() {
                let c = self.factors[row(i) + k][self.which];
                for (x, y) in own.iter_mut().zip(other) {
                    *x -= c * y;
                }
            }
            let over = 1.0 / self.factors[row(i) + i][self.which];
            for x in own.iter_mut() {
                *x *= over;
            }
        }
    }
}

/// L⁻¹ B of one of the matrices, rows of `width` columns, in place.
pub fn whiten_rows(factors: &[Entry], which: usize, rows: &mut [f64], width: usize) {
    if width > 0 {
        run(Solve {
            factors,
            which,
            rows,
            width,
        });
    }
}

struct Gram<'a> {
    rows: &'a [f64],
    width: usize,
}

impl NullaryFnOnce for Gram<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let n = self.width;
        let mut found = vec![0.0; n * n];
        for row in self.rows.chunks_exact(n) {
            for (i, &c) in row.iter().enumerate() {
                for (x, y) in found[i * n..i * n + n].iter_mut().zip(row) {
                    *x += c * y;
                }
            }
        }
        found
    }
}

/// BᵀB of rows of `width` columns.
#[must_use]
pub fn gram(rows: &[f64], width: usize) -> Vec<f64> {
    if width == 0 {
        return Vec::new();
    }
    run(Gram { rows, width })
}

#[cfg(test)]
mod tests {
    use super::{SIDE, factorize, gram, row, whiten_rows, whitened};

    #[test]
    fn factors_of_all_matrices_reproduce_them() {
        let size = 7;
        let entry = |i: usize, j: usize, l: usize| {
            let apart = (i as f64 - j as f64).abs();
            (-apart / (1.0 + l as f64)).exp() + if i == j { 0.1 } else { 0.0 }
        };
        let mut a: Vec<[f64; SIDE]> = Vec::new();
        for i in 0..size {
            for j in 0..=i {
                a.push(std::array::from_fn(|l| entry(i, j, l)));
            }
        }
        factorize(&mut a, size);
        let b: Vec<f64> = (0..size).map(|i| 1.0 + i as f64).collect();
        let white = whitened(&a, &b);
        for l in 0..SIDE {
            let mut rows = b.clone();
            whiten_rows(&a, l, &mut rows, 1);
            for i in 0..size {
                assert!((rows[i] - white[i][l]).abs() < 1e-12);
                let back: f64 = (0..=i).map(|k| a[row(i) + k][l] * white[k][l]).sum();
                assert!((back - b[i]).abs() < 1e-12);
                for j in 0..=i {
                    let sum: f64 = (0..=j).map(|k| a[row(i) + k][l] * a[row(j) + k][l]).sum();
                    assert!((sum - entry(i, j, l)).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn gram_is_the_product() {
        let found = gram(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2);
        assert_eq!(found, [35.0, 44.0, 44.0, 56.0]);
    }
}
