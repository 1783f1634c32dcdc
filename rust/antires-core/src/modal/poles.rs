//! The poles of the response to one load below a limit, from its Krylov space, and H_ik as partial fractions
//! of them.
//!
//! ```text
//! H_ik(x) = H_ik(−σ) + (x + σ) Σ_j c_ij / (λ_j − x),    c_ij = φ_ij φ_kj θ_j,  λ_j = 1/θ_j − σ
//! ```
//!
//! Those up to the limit are the modes that the load excites; those far above stand for all other modes
//! together ([`Krylov`](crate::linalg::krylov::Krylov)).

use super::receptance::Receptance;
use super::scaled::ScaledMatrices;
use super::settled::{FOUND, Pairs, UNSEEN, is_close, settled, uncertainty};
use super::space::Space;
use crate::linalg::factors::Form;
use crate::linalg::krylov::Start;

/// The poles are told up to this part above the limit, for the count to find a clear place.
pub(super) const MARGIN: f64 = 0.02;

/// Response at x = −σ, relative to the largest, below which nothing is left of it.
const NOTHING: f64 = 1e-14;

/// Rounding errors of Θ within which two poles are one.
const REPEATED: f64 = 32.0;

/// Most rigid-body modes a structure has.
const RIGID: usize = 6;

/// The poles of one load, with the memory to find them again.
#[derive(Default)]
pub(super) struct Poles {
    space: Space,
    sigma: f64,
    limit: f64,
    zero: f64,
    found: Vec<bool>,
    repeated: Vec<f64>,
    weighted: Vec<f64>,
    vectors: Vec<f64>,
    row: Vec<f64>,
}

impl Poles {
    /// Finds the poles up to `limit` of a load on row `k`; `matrices` hold the factors of K + σM. False where
    /// one of them is neither a mode nor rounding.
    pub fn find(
        &mut self,
        matrices: &ScaledMatrices,
        (sigma, limit): (f64, f64),
        (k, start): (usize, Start),
    ) -> bool {
        (self.limit, self.sigma) = (limit, sigma);
        let highest = self.highest();
        let least = highest.recip();
        let settled = |space: &dyn Pairs| settled(space, least);
        let grown = self.space.grow(matrices, (k, start), highest, settled);
        if !grown || !self.classify(matrices) {
            return false;
        }
        self.tell_repeated(matrices);
        true
    }

    /// Largest s = x + σ for which the response is exact.
    pub fn highest(&self) -> f64 {
        (1.0 + MARGIN) * self.limit + self.sigma
    }

    /// σ.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Eigenvalues below this are zero at working precision.
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Appends the vector of pole `j` by rows, and M times it.
    pub fn vector(&self, j: usize, mass: &Form, weighted: &mut Vec<f64>, vectors: &mut Vec<f64>) {
        self.space.vector(j, mass, weighted, vectors);
    }

    /// For each pole up to the limit and its margin: whether it is a mode.
    pub fn found(&self) -> &[bool] {
        &self.found
    }

    /// λ of all poles, ascending.
    pub fn lambda(&self) -> impl Iterator<Item = f64> {
        self.space.theta().iter().map(|&t| self.pole(t))
    }

    /// Number of modes with θ of at least `least`.
    pub fn count(&self, least: f64) -> usize {
        let poles = self.space.theta().iter().zip(&self.found);
        poles.filter(|(t, f)| **t >= least && **f).count()
    }

    /// Eigenvalues of the modes, ascending.
    pub fn modes(&self) -> Vec<f64> {
        let modes = self.lambda().zip(&self.found).filter(|(_, f)| **f);
        modes.map(|(l, _)| l).collect()
    }

    /// Vectors of the modes by rows, one after the other.
    pub fn vectors(&mut self, matrices: &ScaledMatrices) -> &[f64] {
        self.weighted.clear();
        self.vectors.clear();
        for j in 0..self.found.len() {
            if self.found[j] {
                self.vector_of(matrices, j);
            }
        }
        &self.vectors
    }

    fn vector_of(&mut self, matrices: &ScaledMatrices, j: usize) {
        let (weighted, vectors) = (&mut self.weighted, &mut self.vectors);
        self.space.vector(j, matrices.mass(), weighted, vectors);
    }

    /// Rounding error of the poles near x: that of Θ.
    pub fn error(&self, x: f64) -> f64 {
        4.0 * f64::EPSILON * (x + self.sigma).powi(2) * self.space.theta()[0]
    }

    /// λ_j of a pole.
    fn pole(&self, theta: f64) -> f64 {
        theta.recip() - self.sigma
    }

    /// Tells the modes among the poles up to the limit.
    fn classify(&mut self, matrices: &ScaledMatrices) -> bool {
        let theta = self.space.theta();
        let least = self.highest().recip();
        let strongest = (0..theta.len())
            .map(|j| self.space.first(j).abs())
            .fold(0.0, f64::max);
        self.found.clear();
        for (j, &t) in theta.iter().enumerate().take_while(|(_, t)| **t >= least) {
            let found = self.space.residual(j) <= FOUND * t;
            if !found && self.space.first(j).abs() > UNSEEN * strongest {
                return false;
            }
            self.found.push(found);
        }
        self.zero = (0..self.found.len().min(RIGID))
            .map(|j| 16.0 * self.ulps(matrices, j))
            .fold(0.0, f64::max);
        true
    }

    /// How far one ulp in each entry of K and M can move the eigenvalue of pole `j`.
    fn ulps(&mut self, matrices: &ScaledMatrices, j: usize) -> f64 {
        self.weighted.clear();
        self.vectors.clear();
        self.vector_of(matrices, j);
        let lambda = self.pole(self.space.theta()[j]).abs();
        let moved = matrices.stiffness().absolute_form(&self.vectors)
            + lambda * matrices.mass().absolute_form(&self.vectors);
        f64::EPSILON * moved
    }

    /// Notes how near each pole may come to the one below and still be the same, repeated.
    fn tell_repeated(&mut self, matrices: &ScaledMatrices) {
        self.repeated.clear();
        for j in 0..self.found.len() {
            let theta = self.space.theta();
            let (s, largest) = (theta[j].recip(), theta[0]);
            let mut tolerance = REPEATED * f64::EPSILON * s * s * largest;
            if is_close(theta, j) {
                let moved = s * s * uncertainty(self.space.pairs(), j);
                tolerance += moved + 4.0 * self.ulps(matrices, j);
            }
            self.repeated.push(tolerance);
        }
    }

    /// Forms the partial fractions between row `i` of `n` and the load; a root cancels on each pole of `hidden`.
    pub fn form(&mut self, n: usize, i: usize, hidden: &[f64], h: &mut Receptance) {
        h.clear();
        let space = &self.space;
        space.row(i, &mut self.row);
        let known = space.response(i);
        h.begin(self.sigma, known);
        let (mut size_i, mut size_k, mut modes) = (0.0_f64, 0.0_f64, 0);
        let top = (4.0 * (self.limit + self.sigma)).recip();
        let largest_theta = space.theta()[0];
        let mut floor = 0.0;
        for (j, (&theta, &phi_i)) in space.theta().iter().zip(&self.row).enumerate() {
            let phi_k = space.strength(j);
            let rounding = j < self.found.len() && !self.found[j];
            if theta <= f64::EPSILON * largest_theta {
                // So stiff that beside the response it is nothing but its rounding.
                floor += (phi_k * phi_i * theta).abs() / f64::EPSILON;
                continue;
            }
            if theta >= top {
                size_i = size_i.max(phi_i.abs());
                size_k = size_k.max(phi_k.abs());
            }
            if rounding {
                continue;
            }
            if j >= self.found.len() {
                floor += (phi_k * phi_i * theta).abs();
            }
            let lambda = self.pole(theta);
            let lambda = if lambda.abs() <= self.zero {
                0.0
            } else {
                lambda
            };
            h.add(
                lambda,
                phi_i * phi_k,
                self.repeated.get(j).copied().unwrap_or(0.0),
            );
            if j < self.found.len() {
                modes = h.poles.len();
            }
        }
        h.cancelled
            .extend(hidden.iter().filter(|&&l| l <= self.limit));
        h.floor_error = 4.0 * f64::EPSILON * floor;
        h.finish(n, modes, (size_i, size_k));
        let error = 4.0 * f64::EPSILON * known.abs();
        if error > h.residue_error {
            h.floor_error += error / self.sigma;
        }
        h.is_zero &= known.abs() <= NOTHING * space.largest_response();
    }
}
