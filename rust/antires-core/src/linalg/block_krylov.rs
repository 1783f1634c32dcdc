//! The response of K − xM to one load as in [`super::krylov`], from a space that three more starts share: the
//! factors are read once for four vectors, and modes that the load does not excite come with it.
//!
//! With A = K + σM, s = x + σ, a = A⁻¹e and W_0 = A⁻¹M [a, r_1, r_2, r_3] = Q_1 C, block Lanczos in the inner
//! product of M gives A⁻¹M Q = Q T + Q_{p+1} B Eᵀ, T block tridiagonal. With T = Y Θ Yᵀ
//!
//! ```text
//! u(x) ≈ a + s Q (I − sT)⁻¹ C e_1 = a + s Σ_j (Q y_j) g_j / (1 − sθ_j),    g_j = (C e_1)ᵀ y_j
//! u(x) − that = s² (I − s A⁻¹M)⁻¹ Q_{p+1} B Eᵀ (I − sT)⁻¹ C e_1
//! ```
//!
//! The space grows until the last is negligible. It has half as many vectors again as that of the load alone, and
//! a third as many readings of the factors, which is what large ones cost. The other starts are fixed
//! pseudo-random numbers: the same matrices give the same bits whatever was solved before.
//!
//! Reference: Golub & Underwood, in Mathematical Software III, 1977, 361-377 (block Lanczos).

use super::panel::{Gram, Square, Take, identity, orthonormalize, product, transposed};
use super::sparse::several::{Filled, Row};
use super::sparse::{SparseFactors, SparseMatrix};
use super::standard::StandardSymmetric;
use super::wide::{self, LANES, dot, subtract};
use faer::Mat;

/// Error of the response relative to its start at which the space is large enough.
const NEGLIGIBLE_ERROR: f64 = 1e-17;

/// Fractions of the highest s at which the error is followed; see [`super::krylov`].
const SAMPLES: [f64; 6] = [1.0, 0.967, 0.913, 0.836, 0.719, 0.531];

/// Vectors of the space, with the memory to grow it again.
#[derive(Debug, Clone, Default)]
pub struct BlockKrylov {
    n: usize,
    /// One after the other.
    basis: Vec<f64>,
    /// Diagonal blocks of T and those below them, the last of which is B.
    diagonal: Vec<Square>,
    below: Vec<Square>,
    /// C.
    start: Square,
    /// a.
    response: Vec<f64>,
    theta: Vec<f64>,
    /// Y, column after column.
    ritz: Vec<f64>,
}

/// Part of the last block of (I − sT)⁻¹ C at one s, from block to block.
#[derive(Clone, Copy)]
struct Sample {
    inverse: Square,
    last: Square,
}

impl BlockKrylov {
    /// Grows the space of the load on row `k`, the other starts on the rows that are `joined` to it, until the error is
    /// negligible for all x + σ up to `s_max` and `settled` says so. False where `most` vectors do not do.
    #[must_use]
    pub fn grow(
        &mut self,
        (shifted, mass): (&SparseFactors, &SparseMatrix),
        (k, joined): (usize, impl Fn(usize) -> bool),
        s_max: f64,
        most: usize,
        settled: impl Fn(&Self) -> bool,
    ) -> bool {
        let (n, mass) = (mass.n(), &Filled::of(mass));
        self.n = n;
        self.basis.clear();
        self.diagonal.clear();
        self.below.clear();
        self.response.clear();
        self.response.resize(n, 0.0);
        self.response[k] = 1.0;
        shifted.solve(&mut self.response);
        let mut mq = vec![Row::default(); n];
        let mut q = self.starts(joined);
        mass.multiply(&q, &mut mq);
        q.copy_from_slice(&mq);
        shifted.solve_several(&mut q);
        let Some(start) = orthonormalize(&mut q, &mut mq, mass, &[]) else {
            return false;
        };
        self.start = start;
        let mut samples = Vec::new();
        let (mut before, mut w) = (Vec::new(), vec![Row::default(); n]);
        while self.basis.len() + LANES * n <= most * n {
            for c in 0..LANES {
                self.basis.extend(q.iter().map(|row| row[c]));
            }
            w.copy_from_slice(&mq);
            shifted.solve_several(&mut w);
            let (a, b) = (&mq[..], &w[..]);
            let own = wide::run(Gram { a, b });
            let other = transposed(&own);
            let own: Square =
                std::array::from_fn(|c| std::array::from_fn(|r| 0.5 * (own[c][r] + other[c][r])));
            let (v, by) = (&q[..], &own);
            wide::run(Take { w: &mut w, v, by });
            if let Some(coupling) = self.below.last() {
                let by = &transposed(coupling);
                let v = &before[..];
                wide::run(Take { w: &mut w, v, by });
            }
            let Some(next) = orthonormalize(&mut w, &mut mq, mass, &self.basis) else {
                return false;
            };
            self.diagonal.push(own);
            self.below.push(next);
            before.clone_from(&q);
            std::mem::swap(&mut q, &mut w);
            if self.error(&mut samples, s_max) <= NEGLIGIBLE_ERROR
                && self.decompose()
                && settled(self)
            {
                return true;
            }
        }
        false
    }

    /// a and three columns of pseudo-random numbers.
    fn starts(&self, joined: impl Fn(usize) -> bool) -> Vec<Row> {
        let mut state = 1_u64;
        let mut random = || {
            // The 64-bit congruential generator of Knuth, MMIX.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let row = |(row, &a): (usize, &f64)| {
            if joined(row) {
                [a, random(), random(), random()]
            } else {
                Row::default()
            }
        };
        self.response.iter().enumerate().map(row).collect()
    }

    /// Largest error of the response, relative to its start.
    fn error(&self, samples: &mut Vec<Sample>, s_max: f64) -> f64 {
        let j = self.diagonal.len() - 1;
        let size = norm(&self.start[0]);
        let mut worst = 0.0_f64;
        for (q, part) in SAMPLES.iter().enumerate() {
            let s = part * s_max;
            let mut pivot = identity();
            let mut last = self.start;
            if let Some(before) = samples.get(q) {
                let coupling = &self.below[j - 1];
                let through = product(coupling, &before.inverse);
                let back = product(&through, &transposed(coupling));
                subtract(pivot.as_flattened_mut(), s * s, back.as_flattened());
                last = product(coupling, &before.last);
                last.as_flattened_mut().iter_mut().for_each(|x| *x *= s);
            }
            subtract(pivot.as_flattened_mut(), s, self.diagonal[j].as_flattened());
            let inverse = inverse(pivot);
            let last = product(&inverse, &last);
            let error = s * norm(&product(&self.below[j], &last)[0]) / size;
            // NaN, from a sample on a pole, keeps the space growing.
            worst = if error <= worst { worst } else { error };
            let sample = Sample { inverse, last };
            if q < samples.len() {
                samples[q] = sample;
            } else {
                samples.push(sample);
            }
        }
        worst
    }

    /// T = Y Θ Yᵀ, θ descending.
    fn decompose(&mut self) -> bool {
        let p = LANES * self.diagonal.len();
        let mut solver = StandardSymmetric::new(p);
        let t: &mut Mat<f64> = solver.matrix_mut();
        for (j, (own, below)) in self.diagonal.iter().zip(&self.below).enumerate() {
            let at = j * LANES;
            for c in 0..LANES {
                for r in 0..LANES {
                    t[(at + r, at + c)] = own[c][r];
                    if at + LANES < p {
                        t[(at + LANES + r, at + c)] = below[c][r];
                    }
                }
            }
        }
        if solver.decompose().is_err() {
            return false;
        }
        self.theta.clear();
        self.theta.extend(solver.values().iter().rev());
        self.ritz.clear();
        for j in (0..p).rev() {
            self.ritz.extend(solver.vectors().col_as_slice(j));
        }
        true
    }

    fn y(&self, j: usize) -> &[f64] {
        let p = self.theta.len();
        &self.ritz[j * p..(j + 1) * p]
    }

    /// θ_j = 1 / (λ_j + σ), descending.
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Entry `i` of a: the response at x = −σ.
    #[must_use]
    pub fn response(&self, i: usize) -> f64 {
        self.response[i]
    }

    /// Largest modulus of the response at x = −σ.
    #[must_use]
    pub fn largest_response(&self) -> f64 {
        self.response.iter().fold(0.0, |m, a| m.max(a.abs()))
    }

    /// Modulus of g_j over the size of the start.
    #[must_use]
    pub fn first(&self, j: usize) -> f64 {
        (dot(&self.start[0], &self.y(j)[..LANES]) / norm(&self.start[0])).abs()
    }

    /// Part of the load in y_j, over θ_j: c_j = that (Q y_j)_i.
    #[must_use]
    pub fn strength(&self, j: usize) -> f64 {
        let own = dot(&self.start[0], &self.y(j)[..LANES]);
        // A pole without θ is so far above that nothing is left of it.
        if self.theta[j] == 0.0 {
            0.0
        } else {
            own / self.theta[j]
        }
    }

    /// Residual ‖A⁻¹M v − θ v‖ of v = Q y_j.
    #[must_use]
    pub fn residual(&self, j: usize) -> f64 {
        let (y, p) = (self.y(j), self.theta.len());
        let last = &y[p - LANES..];
        self.below.last().map_or(0.0, |b| {
            let row = |r: usize| (0..LANES).map(|c| b[c][r] * last[c]).sum();
            let rows: Row = std::array::from_fn(row);
            norm(&rows)
        })
    }

    /// Entry i of every Q y_j, into `out`.
    pub fn row(&self, i: usize, out: &mut Vec<f64>) {
        let p = self.theta.len();
        let q: Vec<f64> = (0..p).map(|r| self.basis[r * self.n + i]).collect();
        out.clear();
        out.extend(self.ritz.chunks_exact(p).map(|y| dot(&q, y)));
    }

    /// Appends v = Q y_j.
    pub fn vector(&self, j: usize, vectors: &mut Vec<f64>) {
        let at = vectors.len();
        vectors.resize(at + self.n, 0.0);
        for (q, &y) in self.basis.chunks_exact(self.n).zip(self.y(j)) {
            subtract(&mut vectors[at..], -y, q);
        }
    }
}

fn norm(a: &Row) -> f64 {
    dot(a, a).sqrt()
}

/// A⁻¹ by Gauss and Jordan on the columns, with the largest pivot of each row; not finite where there is none.
fn inverse(mut a: Square) -> Square {
    let mut inverse = identity();
    for c in 0..LANES {
        let best = (c..LANES).max_by(|&p, &q| a[p][c].abs().total_cmp(&a[q][c].abs()));
        let best = best.unwrap_or(c);
        a.swap(c, best);
        inverse.swap(c, best);
        let pivot = a[c][c].recip();
        a[c].iter_mut().for_each(|x| *x *= pivot);
        inverse[c].iter_mut().for_each(|x| *x *= pivot);
        let (own, done) = (a[c], inverse[c]);
        for r in (0..LANES).filter(|&r| r != c) {
            let by = a[r][c];
            subtract(&mut a[r], by, &own);
            subtract(&mut inverse[r], by, &done);
        }
    }
    inverse
}
