//! The response of K − xM to one load, from a Krylov space: exact low poles and a few that stand for the
//! rest.
//!
//! With σ > 0, A = K + σM and s = x + σ the response to a load e is u(x) = (K − xM)⁻¹ e =
//! (I − s A⁻¹M)⁻¹ A⁻¹e. Lanczos in the inner product of M, started at q_1 = A⁻¹e / β_0, gives
//! A⁻¹M Q = Q T + β q_{p+1} e_pᵀ with T tridiagonal, and with T = Y Θ Yᵀ
//!
//! ```text
//! u(x) ≈ β_0 Q (I − sT)⁻¹ e_1 = β_0 Σ_j (Q y_j) y_1j / (1 − s θ_j)
//! u(x) − that = s β y_p(s) (I − s A⁻¹M)⁻¹ q_{p+1},      y_p(s) = β_0 [(I − sT)⁻¹]_p1
//! ```
//!
//! These are partial fractions with poles λ_j = 1/θ_j − σ. The low ones are the modes that the load excites;
//! the high ones match p moments of all other modes: they are the residual series of the classical modal
//! method, summed. The identity for the error is exact, and y_p is a product of p factors that costs nothing
//! to follow, so the space grows until the error is below rounding everywhere up to a given x.
//!
//! Summed as it stands, the poles far above leave their rounding: they are large, and all but cancel. What they
//! are at x = −σ is known by itself, a = A⁻¹e, and beside it they are small:
//!
//! ```text
//! u(x) = a + s Σ_j c_j / (λ_j − x),       c_j = β_0 (Q y_j) y_1j
//! ```
//!
//! M may be singular. Then a has a part without mass, for which the inner product of M is blind, and the space
//! starts from A⁻¹M a instead: u(x) = a + s (I − s A⁻¹M)⁻¹ A⁻¹M a, of the same form with c_j over θ_j.
//!
//! The start depends on the load alone: the same matrices give the same bits whatever was solved before.
//!
//! References: Ericsson & Ruhe, Math. Comp. 35 (1980) 1251-1268 (shift and invert); Boley, Circuits Syst.
//! Signal Process. 13 (1994) 733-758 (Lanczos and moments); Grimes, Lewis & Simon, SIAM J. Matrix Anal.
//! Appl. 15 (1994) 228-272 (count of the modes by inertia).

use crate::linalg::wide::NullaryFnOnce;

use super::factored::Factors;
use super::form::Form;
use super::tridiagonal;
use super::wide::{self, dot, subtract};

/// Error of the response relative to its start at which the space is large enough.
const NEGLIGIBLE_ERROR: f64 = 1e-17;

/// Fractions of the highest s at which the error is followed. Unlike one another, so that a pole of the
/// approximation near one of them does not hide in all.
const SAMPLES: [f64; 6] = [1.0, 0.967, 0.913, 0.836, 0.719, 0.531];

/// A next vector this small, relative to what it was orthogonalized from, is rounding: the space is
/// invariant.
const INVARIANT: f64 = 1e-14;

/// Vectors between two questions whether the space is settled.
const MORE: usize = 8;

/// Lanczos vectors and the poles they give, with the memory to do it again.
#[derive(Debug, Clone, Default)]
pub struct Krylov {
    n: usize,
    /// Rows of a stored vector: n and the padding of [`Form`].
    stride: usize,
    /// q_j and M q_j, one after the other.
    basis: Vec<f64>,
    weighted: Vec<f64>,
    alpha: Vec<f64>,
    beta: Vec<f64>,
    coefficients: Vec<f64>,
    /// Eigenvalues of T ascending in λ, and the eigenvectors in the same order, p rows each.
    theta: Vec<f64>,
    ritz: Vec<f64>,
    unsorted: Vec<f64>,
    order: Vec<usize>,
    start: Start,
    start_norm: f64,
    /// A⁻¹e.
    response: Vec<f64>,
}

/// What a space starts from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Start {
    /// A⁻¹e: all directions have a mass.
    #[default]
    Response,
    /// A⁻¹M A⁻¹e, A⁻¹e kept aside: some may have none, see the module.
    Remainder,
}

/// What a Krylov space is grown in: A = K + σM factorized, M, and vectors to stay orthogonal to.
#[derive(Clone, Copy)]
pub struct Operator<'a> {
    /// Factors of A.
    pub shifted: &'a Factors,
    /// M.
    pub mass: &'a Form,
    /// M v of each vector v that is kept out, one after the other, and the vectors.
    pub outside: (&'a [f64], &'a [f64]),
}

impl Krylov {
    /// Grows the space of A⁻¹ times `load`, from `start`, until the error is negligible for all x + σ up to `s_max` and
    /// `settled` says so, for which it may come to twice the size, or until `most` vectors. False when the latter, or a
    /// failure of the small eigenproblem, comes before the error is negligible.
    #[must_use]
    pub fn grow(
        &mut self,
        op: Operator<'_>,
        (load, start): (&[f64], Start),
        s_max: f64,
        most: usize,
        settled: impl Fn(&Self) -> bool,
    ) -> bool {
        self.n = op.mass.n();
        self.stride = self.n + op.mass.padding();
        self.alpha.clear();
        self.beta.clear();
        self.basis.clear();
        self.weighted.clear();
        let mut w = load.to_vec();
        op.shifted.solve(&mut w);
        self.start = start;
        self.response.clone_from(&w);
        if start == Start::Remainder {
            op.mass.multiply(&self.response, &mut w);
            w[self.n..].fill(0.0);
            op.shifted.solve(&mut w);
        }
        self.keep_out(op, &mut w);
        self.start_norm = self.append(op, &w);
        if self.start_norm == 0.0 {
            return false;
        }
        // δ_j = det T_j(s) / det T_(j−1)(s), and the product that y_p is.
        let mut ratio = [1.0; SAMPLES.len()];
        let mut product = [1.0; SAMPLES.len()];
        // Vectors at which it is asked again, and at which it is enough, once the error is negligible.
        let mut asked: Option<(usize, usize)> = None;
        loop {
            let j = self.alpha.len();
            w.copy_from_slice(&self.weighted[j * self.stride..(j + 1) * self.stride]);
            op.shifted.solve(&mut w);
            let size = self.orthogonalize(op, &mut w);
            let beta = self.append(op, &w);
            let mut error = 0.0_f64;
            for (c, (ratio, product)) in SAMPLES.iter().zip(ratio.iter_mut().zip(&mut product)) {
                let s = c * s_max;
                let coupling = if j == 0 { 0.0 } else { s * self.beta[j - 1] };
                *ratio = 1.0 - s * self.alpha[j] - coupling * coupling / *ratio;
                *product *= if j == 0 { 1.0 } else { coupling } / *ratio;
                error = error.max((s * beta * *product).abs());
            }
            let invariant = beta <= INVARIANT * size;
            self.beta.push(beta);
            // NaN, from a sample on a pole, keeps the space growing.
            let negligible = error <= NEGLIGIBLE_ERROR || asked.is_some();
            let (next, enough) = asked.unwrap_or((j, 2 * j));
            let last = invariant || j + 1 >= most;
            if invariant || negligible && (last || j >= next) {
                let decomposed = self.decompose();
                if !decomposed || last || j >= enough || settled(self) {
                    return decomposed;
                }
                asked = Some((j + MORE, enough));
            } else if last {
                return false;
            }
        }
    }

    /// Appends w / ‖w‖ and M w / ‖w‖; returns ‖w‖ = √(wᵀMw).
    fn append(&mut self, op: Operator<'_>, w: &[f64]) -> f64 {
        let at = self.basis.len();
        self.basis.extend_from_slice(w);
        self.weighted.resize(at + self.stride, 0.0);
        let mw = &mut self.weighted[at..];
        op.mass.multiply(w, mw);
        mw[self.n..].fill(0.0);
        let norm = dot(w, mw).max(0.0).sqrt();
        if norm > 0.0 {
            let inverse = norm.recip();
            self.basis[at..].iter_mut().for_each(|x| *x *= inverse);
            self.weighted[at..].iter_mut().for_each(|x| *x *= inverse);
        }
        norm
    }

    /// Takes from w its part in the space, appends the diagonal entry of T, and returns the size of w
    /// before.
    fn orthogonalize(&mut self, op: Operator<'_>, w: &mut [f64]) -> f64 {
        let (j, stride) = (self.alpha.len(), self.stride);
        let at = j * stride;
        // The three-term recurrence first; the pass over all vectors then finds rounding only.
        if j > 0 {
            subtract(w, self.beta[j - 1], &self.basis[at - stride..at]);
        }
        let alpha = dot(w, &self.weighted[at..at + stride]);
        subtract(w, alpha, &self.basis[at..at + stride]);
        self.keep_out(op, w);
        wide::run(ProjectOut {
            w,
            weighted: &self.weighted,
            vectors: &self.basis,
            coefficients: &mut self.coefficients,
        });
        self.alpha.push(alpha + self.coefficients[j]);
        alpha.abs() + if j > 0 { self.beta[j - 1] } else { 0.0 }
    }

    fn keep_out(&mut self, op: Operator<'_>, w: &mut [f64]) {
        let (weighted, vectors) = op.outside;
        if !vectors.is_empty() {
            wide::run(ProjectOut {
                w,
                weighted,
                vectors,
                coefficients: &mut self.coefficients,
            });
        }
    }

    /// T = Y Θ Yᵀ, in the order of ascending λ: θ descending, the negative ones (rounding) last.
    fn decompose(&mut self) -> bool {
        let p = self.alpha.len();
        self.unsorted.clear();
        self.unsorted.resize(p * p, 0.0);
        for j in 0..p {
            self.unsorted[j * p + j] = 1.0;
        }
        let mut off = self.beta.clone();
        let mut eigenvalues = self.alpha.clone();
        if !tridiagonal::decompose(&mut eigenvalues, &mut off, &mut self.unsorted, p) {
            return false;
        }
        self.order.clear();
        self.order.extend(0..p);
        self.order
            .sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
        self.theta.clear();
        self.ritz.clear();
        for &j in &self.order {
            self.theta.push(eigenvalues[j]);
            self.ritz
                .extend_from_slice(&self.unsorted[j * p..(j + 1) * p]);
        }
        true
    }

    /// θ_j = 1 / (λ_j + σ), descending.
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Entry `i` of A⁻¹e: the response at x = −σ.
    #[must_use]
    pub fn response(&self, i: usize) -> f64 {
        self.response[i]
    }

    /// Largest modulus of the response at x = −σ.
    #[must_use]
    pub fn largest_response(&self) -> f64 {
        self.response.iter().fold(0.0, |m, a| m.max(a.abs()))
    }

    /// Part of the load in y_j, over θ_j: c_j = that (Q y_j)_i.
    #[must_use]
    pub fn strength(&self, j: usize) -> f64 {
        let strength = self.start_norm * self.first(j);
        match self.start {
            Start::Response => strength,
            Start::Remainder => strength / self.theta[j],
        }
    }

    /// First component of y_j.
    #[must_use]
    pub fn first(&self, j: usize) -> f64 {
        self.ritz[j * self.theta.len()]
    }

    /// Residual ‖A⁻¹M v − θ v‖ of v = Q y_j: |β y_pj|.
    #[must_use]
    pub fn residual(&self, j: usize) -> f64 {
        let p = self.theta.len();
        (self.beta[p - 1] * self.ritz[(j + 1) * p - 1]).abs()
    }

    /// Entry i of every Q y_j, into `out`.
    pub fn row(&self, i: usize, out: &mut Vec<f64>) {
        let p = self.theta.len();
        let q: Vec<f64> = (0..p).map(|r| self.basis[r * self.stride + i]).collect();
        out.clear();
        out.extend(self.ritz.chunks_exact(p).map(|y| dot(&q, y)));
    }

    /// Appends v = Q y_j and M v.
    pub fn vector(&self, j: usize, weighted: &mut Vec<f64>, vectors: &mut Vec<f64>) {
        let (p, at) = (self.theta.len(), vectors.len());
        vectors.resize(at + self.stride, 0.0);
        weighted.resize(at + self.stride, 0.0);
        for (r, &y) in self.ritz[j * p..(j + 1) * p].iter().enumerate() {
            let column = r * self.stride..(r + 1) * self.stride;
            subtract(&mut vectors[at..], -y, &self.basis[column.clone()]);
            subtract(&mut weighted[at..], -y, &self.weighted[column]);
        }
    }
}

/// Takes from w its part in the vectors V, with `weighted` = M V and VᵀMV = I.
struct ProjectOut<'a> {
    w: &'a mut [f64],
    weighted: &'a [f64],
    vectors: &'a [f64],
    coefficients: &'a mut Vec<f64>,
}

impl NullaryFnOnce for ProjectOut<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let stride = self.w.len();
        self.coefficients.clear();
        for v in self.weighted.chunks_exact(stride) {
            self.coefficients.push(dot(self.w, v));
        }
        for (v, &c) in self
            .vectors
            .chunks_exact(stride)
            .zip(self.coefficients.iter())
        {
            subtract(self.w, c, v);
        }
    }
}
