//! Eigenvalues of a small Hermitian matrix: Householder's reduction to a real tridiagonal one, then QL.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 8.3.1 and 8.3.3.
//!
//! # dominant
//!
//! The dominant eigenpair of a small Hermitian matrix with nonnegative eigenvalues.
//!
//! Power iteration with powers of the matrix: after k squarings the second eigenvalue, over the first, is the
//! 2^k-th power of what it was. Where a few steps with one power do not settle the vector, the matrix is
//! squared again. One product with the matrix itself takes the rounding of the squarings away. For spectral
//! matrices, whose first eigenvalue stands out, this is a fraction of a full decomposition.

use faer::c64;

use super::symmetric::decompose_tridiagonal;

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
        let converged = decompose_tridiagonal(values, &mut self.off, &mut [], 0);
        values.sort_unstable_by(f64::total_cmp);
        converged
    }

    /// Clears column k below its first entry under the diagonal, whose magnitude it returns.
    fn reflect(&mut self, n: usize, k: usize) -> f64 {
        let size = (k + 1..n).map(|i| self.a[i * n + k].norm_sqr()).sum::<f64>().sqrt();
        let head = self.a[(k + 1) * n + k];
        let below = size * size - head.norm_sqr();
        if k + 2 == n || size == 0.0 || below <= 0.0 {
            return head.norm().max(if k + 2 == n { 0.0 } else { size });
        }
        let turn = if head.norm() > 0.0 { head / head.norm() } else { c64::new(1.0, 0.0) };
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

// ---- dominant

/// Squarings after which two equal eigenvalues are taken as such.
const MOST_SQUARINGS: usize = 40;
/// Steps with one power, and the squared change of a unit vector below which it stands.
const STEPS: usize = 6;
const SETTLED: f64 = 1e-30;

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
    moved: Vec<c64>,
}

impl Workspace {
    /// For matrices of `n` rows.
    pub fn new(n: usize) -> Self {
        let zero = vec![c64::new(0.0, 0.0); n * n];
        Self { n, matrix: zero.clone(), power: zero.clone(), next: zero, moved: vec![c64::new(0.0, 0.0); n] }
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
            return Dominant { first: 0.0, rest: 0.0 };
        }
        for (power, value) in self.power.iter_mut().zip(&self.matrix) {
            *power = *value / trace;
        }
        for _ in 0..MOST_SQUARINGS {
            self.square();
            if self.iterated(vector) {
                break;
            }
        }
        // Once through the matrix itself, and Rayleigh's quotient.
        multiply(&self.matrix, vector, &mut self.moved);
        normalize(&mut self.moved);
        vector.copy_from_slice(&self.moved);
        multiply(&self.matrix, vector, &mut self.moved);
        let first: f64 = vector.iter().zip(&self.moved).map(|(a, b)| a.re * b.re + a.im * b.im).sum();
        let rest = if n > 1 { (trace - first) / (n as f64 - 1.0) } else { 0.0 };
        Dominant { first, rest }
    }

    /// P ← P² / tr P².
    fn square(&mut self) {
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
        let over = 1.0 / trace;
        for value in &mut self.next {
            *value *= over;
        }
        std::mem::swap(&mut self.power, &mut self.next);
    }

    /// A few steps from the column of the largest diagonal entry; whether the vector stands.
    fn iterated(&mut self, vector: &mut [c64]) -> bool {
        let n = self.n;
        let mut best = 0;
        for i in 1..n {
            if self.power[i * n + i].re > self.power[best * n + best].re {
                best = i;
            }
        }
        for i in 0..n {
            vector[i] = self.power[i * n + best];
        }
        normalize(vector);
        for _ in 0..STEPS {
            multiply(&self.power, vector, &mut self.moved);
            normalize(&mut self.moved);
            let change: f64 = vector.iter().zip(&self.moved).map(|(a, b)| (a - b).norm_sqr()).sum();
            vector.copy_from_slice(&self.moved);
            if change <= SETTLED {
                return true;
            }
        }
        false
    }
}

/// out ← A v, A by rows.
fn multiply(a: &[c64], v: &[c64], out: &mut [c64]) {
    for (row, out) in a.chunks_exact(v.len()).zip(out) {
        let (mut re, mut im) = (0.0, 0.0);
        for (a, v) in row.iter().zip(v) {
            re += a.re * v.re - a.im * v.im;
            im += a.re * v.im + a.im * v.re;
        }
        *out = c64::new(re, im);
    }
}

fn normalize(v: &mut [c64]) {
    let over = 1.0 / v.iter().map(c64::norm_sqr).sum::<f64>().sqrt();
    for v in v {
        *v *= over;
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
        let found = values(2, |i, j| c64::new(if i == j { 2.0 } else { 0.0 }, if i < j { 1.0 } else { 0.0 }));
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

    /// v vᴴ · 5 + w wᴴ · `second`, v = (3, 4i)/5 and w = (4i, 3)/5 orthogonal.
    fn solve(second: f64) -> (Dominant, Vec<c64>) {
        let v = [c64::new(0.6, 0.0), c64::new(0.0, 0.8)];
        let w = [c64::new(0.0, 0.8), c64::new(0.6, 0.0)];
        let mut vector = vec![c64::new(0.0, 0.0); 2];
        let found = Workspace::new(2)
            .solve(|i, j| v[i] * v[j].conj() * 5.0 + w[i] * w[j].conj() * second, &mut vector);
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
