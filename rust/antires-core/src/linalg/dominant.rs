//! The dominant eigenpair of a small Hermitian matrix with nonnegative eigenvalues.
//!
//! The matrix over its trace is squared until it is the projector v vᴴ: after k squarings the second
//! eigenvalue, over the first, is the 2^k-th power of what it was. One product with the matrix itself takes
//! the rounding of the squarings away. For spectral matrices, whose first eigenvalue stands out, three to six
//! squarings do, a fraction of a full decomposition.

use faer::c64;

/// Squarings after which two equal eigenvalues are taken as such.
const MOST_SQUARINGS: usize = 40;
/// 1 − tr P² of a projector, but for rounding.
const PURE: f64 = 1e-14;

/// The largest eigenvalue, the mean of the others and the unit eigenvector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dominant {
    /// Largest eigenvalue.
    pub first: f64,
    /// Mean of the others; 0 where there are none.
    pub rest: f64,
}

/// Room for one matrix.
#[derive(Debug, Clone)]
pub struct Workspace {
    n: usize,
    matrix: Vec<c64>,
    power: Vec<c64>,
    next: Vec<c64>,
}

impl Workspace {
    /// For matrices of `n` rows.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zero = vec![c64::new(0.0, 0.0); n * n];
        Self {
            n,
            matrix: zero.clone(),
            power: zero.clone(),
            next: zero,
        }
    }

    /// Solves for the Hermitian matrix whose entries (row, column) on and above the diagonal `entry` gives;
    /// `vector` takes the eigenvector.
    pub fn solve(&mut self, entry: impl Fn(usize, usize) -> c64, vector: &mut [c64]) -> Dominant {
        let n = self.n;
        let mut trace = 0.0;
        for i in 0..n {
            for j in i..n {
                let value = entry(i, j);
                self.matrix[i * n + j] = value;
                self.matrix[j * n + i] = value.conj();
            }
            self.matrix[i * n + i].im = 0.0;
            trace += self.matrix[i * n + i].re;
        }
        if n == 0 || !(trace > 0.0) {
            vector.fill(c64::new(0.0, 0.0));
            if let Some(one) = vector.first_mut() {
                *one = c64::new(1.0, 0.0);
            }
            return Dominant {
                first: 0.0,
                rest: 0.0,
            };
        }
        for (power, value) in self.power.iter_mut().zip(&self.matrix) {
            *power = *value / trace;
        }
        for _ in 0..MOST_SQUARINGS {
            if self.square() {
                break;
            }
        }
        self.project(vector);
        let first = self.rayleigh(vector);
        let rest = if n > 1 {
            (trace - first) / (n as f64 - 1.0)
        } else {
            0.0
        };
        Dominant { first, rest }
    }

    /// P ← P² / tr P²; true when P was a projector.
    fn square(&mut self) -> bool {
        let n = self.n;
        let mut trace = 0.0;
        for i in 0..n {
            let row = &self.power[i * n..(i + 1) * n];
            for j in i..n {
                let other = &self.power[j * n..(j + 1) * n];
                let (mut re, mut im) = (0.0, 0.0);
                // (P²)_ij = Σ P_ik P_kj, and P_kj is the conjugate of P_jk.
                for (a, b) in row.iter().zip(other) {
                    re += a.re * b.re + a.im * b.im;
                    im += a.im * b.re - a.re * b.im;
                }
                self.next[i * n + j] = c64::new(re, im);
                self.next[j * n + i] = c64::new(re, -im);
            }
            trace += self.next[i * n + i].re;
        }
        for value in &mut self.next {
            *value /= trace;
        }
        std::mem::swap(&mut self.power, &mut self.next);
        1.0 - trace <= PURE
    }

    /// The column of the projector's largest diagonal entry, once more through the matrix, at unit length.
    fn project(&mut self, vector: &mut [c64]) {
        let n = self.n;
        let best = (0..n)
            .max_by(|&a, &b| {
                self.power[a * n + a]
                    .re
                    .total_cmp(&self.power[b * n + b].re)
            })
            .unwrap_or(0);
        for i in 0..n {
            let mut sum = c64::new(0.0, 0.0);
            for k in 0..n {
                sum += self.matrix[i * n + k] * self.power[k * n + best];
            }
            vector[i] = sum;
        }
        let length = vector.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        for v in vector {
            *v /= length;
        }
    }

    fn rayleigh(&self, v: &[c64]) -> f64 {
        let n = self.n;
        let mut sum = 0.0;
        for i in 0..n {
            let mut product = c64::new(0.0, 0.0);
            for k in 0..n {
                product += self.matrix[i * n + k] * v[k];
            }
            sum += (v[i].conj() * product).re;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v vᴴ · 5 + w wᴴ · `second`, v = (3, 4i)/5 and w = (4i, 3)/5 orthogonal.
    fn solve(second: f64) -> (Dominant, Vec<c64>) {
        let v = [c64::new(0.6, 0.0), c64::new(0.0, 0.8)];
        let w = [c64::new(0.0, 0.8), c64::new(0.6, 0.0)];
        let mut vector = vec![c64::new(0.0, 0.0); 2];
        let found = Workspace::new(2).solve(
            |i, j| v[i] * v[j].conj() * 5.0 + w[i] * w[j].conj() * second,
            &mut vector,
        );
        (found, vector)
    }

    #[test]
    fn a_matrix_made_of_its_vectors() {
        for second in [0.0, 1e-12, 0.1, 4.0, 4.99] {
            let (found, vector) = solve(second);
            assert!((found.first - 5.0).abs() < 1e-13, "{second}");
            assert!((found.rest - second).abs() < 1e-13, "{second}");
            let along = c64::new(0.6, 0.0) * vector[0] + c64::new(0.0, -0.8) * vector[1];
            assert!((along.norm_sqr() - 1.0).abs() < 1e-12, "{second}");
        }
    }

    #[test]
    fn nothing_and_one_row() {
        let mut vector = [c64::new(9.0, 9.0)];
        let found = Workspace::new(1).solve(|_, _| c64::new(0.0, 0.0), &mut vector);
        assert_eq!((found.first, found.rest), (0.0, 0.0));
        let found = Workspace::new(1).solve(|_, _| c64::new(3.0, 0.0), &mut vector);
        assert_eq!((found.first, found.rest), (3.0, 0.0));
    }
}
