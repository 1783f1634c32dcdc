//! Eigenvalues of a small Hermitian matrix: Householder's reduction to a real tridiagonal one, then QL.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 8.3.1 and 8.3.3.

use faer::c64;

use super::tridiagonal;

/// Room for one matrix.
#[derive(Debug, Clone, Default)]
pub struct Hermitian {
    /// By rows, both triangles.
    a: Vec<c64>,
    v: Vec<c64>,
    w: Vec<c64>,
    off: Vec<f64>,
}

impl Hermitian {
    /// Ascending eigenvalues of the matrix of `values.len()` rows whose entries (row, column) on and above
    /// the diagonal `entry` gives. False where one does not converge.
    pub fn eigenvalues(&mut self, entry: impl Fn(usize, usize) -> c64, values: &mut [f64]) -> bool {
        let n = values.len();
        self.a.resize(n * n, c64::new(0.0, 0.0));
        for i in 0..n {
            for j in i..n {
                let value = entry(i, j);
                self.a[i * n + j] = value;
                self.a[j * n + i] = value.conj();
            }
        }
        self.off.clear();
        self.off.resize(n, 0.0);
        for k in 0..n {
            values[k] = self.a[k * n + k].re;
            if k + 1 < n {
                self.off[k] = self.reflect(n, k);
            }
        }
        let converged = tridiagonal::decompose(values, &mut self.off, &mut [], 0);
        values.sort_unstable_by(f64::total_cmp);
        converged
    }

    /// Clears column k below its first entry under the diagonal, whose magnitude it returns.
    fn reflect(&mut self, n: usize, k: usize) -> f64 {
        let size = (k + 1..n)
            .map(|i| self.a[i * n + k].norm_sqr())
            .sum::<f64>()
            .sqrt();
        let head = self.a[(k + 1) * n + k];
        let below = size * size - head.norm_sqr();
        if k + 2 == n || size == 0.0 || below <= 0.0 {
            return head.norm().max(if k + 2 == n { 0.0 } else { size });
        }
        let turn = if head.norm() > 0.0 {
            head / head.norm()
        } else {
            c64::new(1.0, 0.0)
        };
        let m = n - k - 1;
        self.v.clear();
        self.v.extend((k + 1..n).map(|i| self.a[i * n + k]));
        self.v[0] += turn * size;
        // 2 / vᴴv; the trailing block becomes A − v wᴴ − w vᴴ.
        let factor = 2.0 / self.v.iter().map(c64::norm_sqr).sum::<f64>();
        self.w.clear();
        self.w.resize(m, c64::new(0.0, 0.0));
        let mut along = 0.0;
        for i in 0..m {
            let row = &self.a[(k + 1 + i) * n + k + 1..(k + 2 + i) * n];
            let (mut re, mut im) = (0.0, 0.0);
            for (a, v) in row.iter().zip(&self.v) {
                re += a.re * v.re - a.im * v.im;
                im += a.re * v.im + a.im * v.re;
            }
            self.w[i] = c64::new(re * factor, im * factor);
            along += self.v[i].re * self.w[i].re + self.v[i].im * self.w[i].im;
        }
        let half = 0.5 * factor * along;
        for i in 0..m {
            self.w[i] -= self.v[i] * half;
        }
        for i in 0..m {
            let (vi, wi) = (self.v[i], self.w[i]);
            let row = &mut self.a[(k + 1 + i) * n + k + 1..(k + 2 + i) * n];
            for ((a, v), w) in row.iter_mut().zip(&self.v).zip(&self.w) {
                a.re -= vi.re * w.re + vi.im * w.im + wi.re * v.re + wi.im * v.im;
                a.im -= vi.im * w.re - vi.re * w.im + wi.im * v.re - wi.re * v.im;
            }
        }
        size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(n: usize, entry: impl Fn(usize, usize) -> c64) -> Vec<f64> {
        let mut out = vec![0.0; n];
        assert!(Hermitian::default().eigenvalues(entry, &mut out));
        out
    }

    #[test]
    fn two_rows_by_hand() {
        // [[2, i], [-i, 2]] has 1 and 3.
        let found = values(2, |i, j| {
            c64::new(
                if i == j { 2.0 } else { 0.0 },
                if i < j { 1.0 } else { 0.0 },
            )
        });
        assert!((found[0] - 1.0).abs() < 1e-15 && (found[1] - 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_circulant_by_its_symbol() {
        // First row (4, 1 + i, 0, 0, 1 − i): 4 + 2 cos θ − 2 sin θ at the five roots of unity.
        let n = 5;
        let found = values(n, |i, j| match (j + n - i) % n {
            0 => c64::new(4.0, 0.0),
            1 => c64::new(1.0, 1.0),
            4 => c64::new(1.0, -1.0),
            _ => c64::new(0.0, 0.0),
        });
        let mut wanted: Vec<f64> = (0..n)
            .map(|k| {
                let angle = std::f64::consts::TAU * k as f64 / n as f64;
                4.0 + 2.0 * angle.cos() - 2.0 * angle.sin()
            })
            .collect();
        wanted.sort_unstable_by(f64::total_cmp);
        for (a, b) in found.iter().zip(&wanted) {
            assert!((a - b).abs() < 1e-13, "{found:?} {wanted:?}");
        }
    }

    #[test]
    fn one_row_a_diagonal_and_nothing() {
        assert_eq!(values(1, |_, _| c64::new(3.0, 0.0)), [3.0]);
        let diagonal = |i: usize, j: usize| c64::new(if i == j { i as f64 } else { 0.0 }, 0.0);
        assert_eq!(values(4, diagonal), [0.0, 1.0, 2.0, 3.0]);
        assert!(values(0, diagonal).is_empty());
    }
}
