//! A = V Λ Vᵀ of a small symmetric matrix: Householder's reduction to a tridiagonal one, then QL.
//!
//! Up to some dozens of rows this is several times faster than a blocked solver; a matrix that is tridiagonal
//! already, as of a chain, goes straight to QL.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 8.3.1 and 8.3.3.

use super::tridiagonal;

/// Most rows for which this is the faster way.
pub const MOST_ROWS: usize = 32;

/// Eigenvalues and eigenvectors of the last matrix.
#[derive(Debug, Clone, Default)]
pub struct SmallSymmetric {
    /// The matrix by columns, below the diagonal then the reflectors.
    a: Vec<f64>,
    diagonal: Vec<f64>,
    off: Vec<f64>,
    scales: Vec<f64>,
    vectors: Vec<f64>,
    work: Vec<f64>,
    order: Vec<usize>,
}

impl SmallSymmetric {
    /// Solves for the matrix of `n` rows whose entries (row, column), row >= column, `entry` gives. False
    /// where an eigenvalue does not converge.
    #[must_use]
    pub fn solve(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) -> bool {
        self.a.clear();
        self.a.resize(n * n, 0.0);
        for j in 0..n {
            for i in j..n {
                let value = entry(i, j);
                (self.a[j * n + i], self.a[i * n + j]) = (value, value);
            }
        }
        self.reduce(n);
        self.accumulate(n);
        if !tridiagonal::decompose(&mut self.diagonal, &mut self.off, &mut self.vectors, n) {
            return false;
        }
        let values = &self.diagonal;
        self.order.clear();
        self.order.extend(0..n);
        self.order
            .sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
        true
    }

    /// Eigenpair `j`, eigenvalues ascending.
    #[must_use]
    pub fn pair(&self, j: usize) -> (f64, &[f64]) {
        let (n, at) = (self.diagonal.len(), self.order[j]);
        (self.diagonal[at], &self.vectors[at * n..(at + 1) * n])
    }

    /// A → Qᵀ A Q, tridiagonal, with one reflector 1 − τ v vᵀ a column, v in place of what it clears.
    fn reduce(&mut self, n: usize) {
        self.diagonal.clear();
        self.off.clear();
        self.scales.clear();
        for k in 0..n {
            let (done, rest) = self.a.split_at_mut((k + 1) * n);
            let column = &mut done[k * n..];
            self.diagonal.push(column[k]);
            if k + 1 == n {
                break;
            }
            let v = &mut column[k + 1..];
            let tail: f64 = v[1..].iter().map(|x| x * x).sum();
            if tail == 0.0 {
                self.off.push(v[0]);
                self.scales.push(0.0);
                continue;
            }
            let beta = -(v[0] * v[0] + tail).sqrt().copysign(v[0]);
            let first = v[0] - beta;
            let tau = -first / beta;
            v[1..].iter_mut().for_each(|x| *x /= first);
            v[0] = 1.0;
            self.off.push(beta);
            self.scales.push(tau);
            // p = τ A v, then w = p − (τ/2 pᵀv) v, and A − v wᵀ − w vᵀ.
            self.work.clear();
            self.work
                .extend(rest.chunks_exact(n).map(|c| tau * dot(&c[k + 1..], v)));
            let half = 0.5 * tau * dot(&self.work, v);
            for (w, &x) in self.work.iter_mut().zip(v.iter()) {
                *w -= half * x;
            }
            for (j, c) in rest.chunks_exact_mut(n).enumerate() {
                let (vj, wj) = (v[j], self.work[j]);
                for ((a, &x), &w) in c[k + 1..].iter_mut().zip(v.iter()).zip(&self.work) {
                    *a -= x * wj + w * vj;
                }
            }
        }
    }

    /// Q from the reflectors, the last first.
    fn accumulate(&mut self, n: usize) {
        self.vectors.clear();
        self.vectors.resize(n * n, 0.0);
        for j in 0..n {
            self.vectors[j * n + j] = 1.0;
        }
        for k in (0..self.scales.len())
            .rev()
            .filter(|&k| self.scales[k] != 0.0)
        {
            let v = &self.a[k * n + k + 1..(k + 1) * n];
            for column in self.vectors[(k + 1) * n..].chunks_exact_mut(n) {
                let column = &mut column[k + 1..];
                let part = self.scales[k] * dot(column, v);
                for (q, &x) in column.iter_mut().zip(v) {
                    *q -= part * x;
                }
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(n: usize, entry: impl Fn(usize, usize) -> f64) {
        let mut solver = SmallSymmetric::default();
        let full = |i: usize, j: usize| entry(i.max(j), i.min(j));
        assert!(solver.solve(n, &entry));
        let scale = (0..n * n)
            .map(|q| full(q / n, q % n).abs())
            .fold(1e-300, f64::max);
        for j in 0..n {
            let (value, v) = solver.pair(j);
            assert!(j == 0 || solver.pair(j - 1).0 <= value);
            for i in 0..n {
                let r: f64 = (0..n).map(|c| full(i, c) * v[c]).sum::<f64>() - value * v[i];
                assert!(r.abs() <= 2e-15 * n as f64 * scale, "{n} {r:e}");
            }
            for k in 0..=j {
                let product = dot(v, solver.pair(k).1);
                assert!((product - f64::from(u8::from(k == j))).abs() < 1e-14 * n as f64);
            }
        }
    }

    #[test]
    fn full_sparse_and_degenerate_matrices_are_solved() {
        for n in 1..=MOST_ROWS {
            check(n, |i, j| {
                ((7 * i + 3 * j) as f64).sin() + ((i * j) as f64).cos()
            });
            check(n, |i, j| {
                if i - j < 2 {
                    2.0 - 3.0 * (i - j) as f64
                } else {
                    0.0
                }
            });
            check(n, |_, _| 1.0);
            check(n, |i, j| f64::from(u8::from(i == j)));
            check(n, |i, j| 1e12 / (1 + 10_usize.pow(i as u32 % 9) + j) as f64);
        }
        check(4, |_, _| 0.0);
    }
}
