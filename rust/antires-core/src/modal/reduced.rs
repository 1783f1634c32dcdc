//! Poles of one excitation up to a limit, from band matrices, with the proof that none is missing.
//!
//! 1. [`Krylov`] gives H_ik for every i as partial fractions that are exact to rounding below the limit.
//! 2. By Sylvester's law the inertia of K − xM counts all modes below the limit. Each of the poles found has
//!    a residual far below its distance from the next, so if there are as many, they are the modes.
//! 3. If there are more modes than poles, the load does not excite the others: a node at the excitation, or
//!    a repeated eigenvalue, of which any load excites one combination only. They are sought in the
//!    complement of those found, from a start of fixed pseudo-random numbers, until the count is met.
//!
//! What cannot be settled so is left to the dense solver.

use std::sync::Arc;

use faer::MatRef;

use super::columns::Columns;
use super::receptance::Receptance;
use super::structure::Structure;
use crate::linalg::banded::{Banded, count_below};
use crate::linalg::krylov::{Krylov, Operator};

/// Shift σ as a fraction of the limit in x. A small one separates the poles best, a large one keeps the
/// digits of the lowest: at one tenth the digits of λ are lost to (λ + σ)/σ, eleven at most.
const SHIFT: f64 = 0.1;

/// Least pivot of M, relative to its diagonal, for which all directions have a mass.
const LEAST_MASS: f64 = 1e-8;

/// Residual, relative to θ, of a pole that counts as found. The eigenvalue is good to its square.
const FOUND: f64 = 1e-6;

/// Part of a mode in the load, relative to the largest, below which a pole that is not found is rounding.
const UNSEEN: f64 = 1e-11;

/// Rounding errors of Θ within which two poles are one.
const REPEATED: f64 = 32.0;

/// Relative distance of two poles from which on it is asked whether they are one.
const CLOSE: f64 = 1e-6;

/// Most rigid-body modes a structure has.
const RIGID: usize = 6;

/// Largest share of the modes below the limit for which a part of them costs less than all.
const MOST_MODES: f64 = 0.35;

/// The modes are counted at the limit, or up to this part of it above, where the count is clear.
const MARGIN: f64 = 0.02;

/// Places of the count within the margin.
const CUTS: [f64; 5] = [0.0, 0.37, 0.61, 0.84, 0.99];

/// Distance of the count from the next pole, in rounding errors of the count.
const CLEAR: f64 = 10.0;

/// Least relative distance of the count from a pole.
const ON_THE_LIMIT: f64 = 1e-8;

/// Modes and pseudo-modes as seen by one excitation.
pub struct ReducedModes {
    pub(super) structure: Arc<Structure>,
    pub(super) stiffness: Banded,
    pub(super) mass: Banded,
    /// Power of two that brings each diagonal entry of M near one. It rounds nothing, gives translations and
    /// rotations one unit, and scales H_ik by a factor, which moves no zero.
    pub(super) scale: Vec<f64>,
    shifted: Banded,
    pub(super) work: Banded,
    pub(super) krylov: Krylov,
    second: Krylov,
    pub(super) sigma: f64,
    pub(super) limit: f64,
    /// Eigenvalues below this are zero at working precision.
    pub(super) zero: f64,
    /// For each pole up to the limit: whether it is a mode.
    pub(super) found: Vec<bool>,
    repeated: Vec<f64>,
    /// Modes that the load does not excite: λ, and the vectors after those that it does.
    pub(super) hidden: Vec<f64>,
    pub(super) weighted: Vec<f64>,
    pub(super) vectors: Vec<f64>,
    row: Vec<f64>,
    pub(super) columns: Columns,
    pub(super) solved: Option<(usize, f64, bool)>,
}

impl ReducedModes {
    /// Reserves the memory.
    #[must_use]
    pub fn new(structure: Arc<Structure>) -> Self {
        let band = Banded::new(structure.n_dof(), structure.half());
        Self {
            structure,
            stiffness: band.clone(),
            mass: band.clone(),
            scale: Vec::new(),
            shifted: band.clone(),
            work: band,
            krylov: Krylov::default(),
            second: Krylov::default(),
            sigma: 0.0,
            limit: 0.0,
            zero: 0.0,
            found: Vec::new(),
            repeated: Vec::new(),
            hidden: Vec::new(),
            weighted: Vec::new(),
            vectors: Vec::new(),
            row: Vec::new(),
            columns: Columns::default(),
            solved: None,
        }
    }

    /// Takes K and M.
    pub fn set_matrices(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) {
        let structure = &self.structure;
        let dof = |row| structure.dof(row);
        self.scale.clear();
        self.scale.extend((0..structure.n_dof()).map(|row| {
            let mass = m[(dof(row), dof(row))];
            (-0.5 * mass.log2()).round().exp2()
        }));
        let scale = &self.scale;
        self.stiffness
            .fill(|i, j| k[(dof(i), dof(j))] * scale[i] * scale[j]);
        self.mass
            .fill(|i, j| m[(dof(i), dof(j))] * scale[i] * scale[j]);
        self.solved = None;
    }

    /// Finds the poles up to `limit` of the excitation; false where the dense solver has to.
    pub fn solve(&mut self, excitation: usize, limit: f64) -> bool {
        match self.solved {
            Some((k, x, well)) if k == excitation && x == limit => well,
            _ => {
                let well = self.try_solve(excitation, limit);
                self.solved = Some((excitation, limit, well));
                well
            }
        }
    }

    fn try_solve(&mut self, excitation: usize, limit: f64) -> bool {
        let n = self.mass.n();
        self.work.clone_from(&self.mass);
        if !self.work.factorize_definite(LEAST_MASS) {
            return false;
        }
        (self.limit, self.sigma) = (limit, SHIFT * limit);
        self.shifted
            .combine(&self.stiffness, self.sigma, &self.mass);
        if !self.shifted.factorize_definite(0.0) {
            return false;
        }
        let few = |c| c as f64 <= MOST_MODES * n as f64;
        if !few(count_below(&self.stiffness, &self.mass, limit, &mut self.work).0) {
            return false;
        }
        let mut load = vec![0.0; n + self.mass.half()];
        load[self.structure.row(excitation)] = 1.0;
        let op = Operator {
            shifted: &self.shifted,
            mass: &self.mass,
            outside: (&[], &[]),
        };
        if !self
            .krylov
            .grow(op, &load, (1.0 + MARGIN) * limit + self.sigma, n)
        {
            return false;
        }
        if !self.classify() {
            return false;
        }
        self.tell_repeated();
        self.complete()
    }

    /// λ_j of a pole.
    fn pole(&self, theta: f64) -> f64 {
        theta.recip() - self.sigma
    }

    /// Tells the modes among the poles up to the limit.
    fn classify(&mut self) -> bool {
        let theta = self.krylov.theta();
        let least = ((1.0 + MARGIN) * self.limit + self.sigma).recip();
        let strongest = (0..theta.len())
            .map(|j| self.krylov.first(j).abs())
            .fold(0.0, f64::max);
        self.found.clear();
        for (j, &t) in theta.iter().enumerate().take_while(|(_, t)| **t >= least) {
            let found = self.krylov.residual(j) <= FOUND * t;
            if !found && self.krylov.first(j).abs() > UNSEEN * strongest {
                return false;
            }
            self.found.push(found);
        }
        self.zero = (0..self.found.len().min(RIGID))
            .map(|j| 16.0 * self.ulps(j))
            .fold(0.0, f64::max);
        true
    }

    /// How far one ulp in each entry of K and M can move the eigenvalue of pole `j`.
    fn ulps(&mut self, j: usize) -> f64 {
        self.weighted.clear();
        self.vectors.clear();
        self.krylov.vector(j, &mut self.weighted, &mut self.vectors);
        let lambda = self.pole(self.krylov.theta()[j]).abs();
        let moved = self.stiffness.absolute_form(&self.vectors)
            + lambda * self.mass.absolute_form(&self.vectors);
        f64::EPSILON * moved
    }

    /// Notes how near each pole may come to the one below and still be the same, repeated.
    fn tell_repeated(&mut self) {
        self.repeated.clear();
        for j in 0..self.found.len() {
            let theta = self.krylov.theta();
            let (s, largest) = (theta[j].recip(), theta[0]);
            let mut tolerance = REPEATED * f64::EPSILON * s * s * largest;
            if j > 0 && s - theta[j - 1].recip() <= CLOSE * s {
                tolerance += 4.0 * self.ulps(j);
            }
            self.repeated.push(tolerance);
        }
        self.weighted.clear();
        self.vectors.clear();
    }

    /// A place at the limit or just above it, away from all poles, and the number of modes below it.
    fn count(&mut self) -> Option<(f64, usize)> {
        CUTS.iter().find_map(|c| {
            let cut = (1.0 + c * MARGIN) * self.limit;
            let distance = |&t: &f64| (self.pole(t) - cut).abs();
            let room = self.krylov.theta().iter().map(distance).fold(cut, f64::min);
            let (count, error) = count_below(&self.stiffness, &self.mass, cut, &mut self.work);
            (CLEAR * error <= room && room > ON_THE_LIMIT * cut).then_some((cut, count))
        })
    }

    /// Meets the count of modes below the limit.
    fn complete(&mut self) -> bool {
        self.hidden.clear();
        let Some((cut, count)) = self.count() else {
            return false;
        };
        let below = |t: &f64| *t >= (cut + self.sigma).recip();
        let poles = self.krylov.theta();
        let shown = poles
            .iter()
            .zip(&self.found)
            .filter(|(t, f)| below(t) && **f)
            .count();
        if count <= shown {
            return count == shown;
        }
        for j in 0..self.found.len() {
            if self.found[j] {
                self.krylov.vector(j, &mut self.weighted, &mut self.vectors);
            }
        }
        let mut state = 1_u64;
        while shown + self.hidden.len() < count {
            let mut load = vec![0.0; self.mass.n() + self.mass.half()];
            for x in &mut load[..self.mass.n()] {
                // The 64-bit congruential generator of Knuth, MMIX.
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                *x = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            }
            let mut start = vec![0.0; load.len()];
            self.mass.multiply(&load, &mut start);
            start[self.mass.n()..].fill(0.0);
            let op = Operator {
                shifted: &self.shifted,
                mass: &self.mass,
                outside: (&self.weighted, &self.vectors),
            };
            let most = self.mass.n();
            if !self
                .second
                .grow(op, &start, (1.0 + MARGIN) * self.limit + self.sigma, most)
            {
                return false;
            }
            let before = self.hidden.len();
            for (j, &t) in self.second.theta().iter().enumerate() {
                if below(&t) && self.second.residual(j) <= FOUND * t {
                    self.hidden.push(t.recip() - self.sigma);
                    self.second.vector(j, &mut self.weighted, &mut self.vectors);
                }
            }
            if self.hidden.len() == before {
                return false;
            }
        }
        shown + self.hidden.len() == count
    }

    /// Rounding error of the poles near x: that of Θ.
    #[must_use]
    pub fn pole_error(&self, x: f64) -> f64 {
        4.0 * f64::EPSILON * (x + self.sigma).powi(2) * self.krylov.theta()[0]
    }

    /// Eigenvalues and roots below this are zero at working precision.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Forms the partial fractions between dof `i` and the excitation of the last [`solve`](Self::solve).
    pub fn form(&mut self, i: usize, h: &mut Receptance) {
        h.clear();
        let krylov = &self.krylov;
        krylov.row(self.structure.row(i), &mut self.row);
        let (mut size_i, mut size_k, mut modes) = (0.0_f64, 0.0_f64, 0);
        let top = (4.0 * (self.limit + self.sigma)).recip();
        let largest_theta = krylov.theta()[0];
        for (j, (&theta, &phi_i)) in krylov.theta().iter().zip(&self.row).enumerate() {
            let strength = krylov.start_norm() * krylov.first(j);
            if theta <= f64::EPSILON * largest_theta {
                // So stiff that its term is constant in band.
                h.constant += strength * phi_i;
                continue;
            }
            let phi_k = strength / theta;
            if theta >= top {
                size_i = size_i.max(phi_i.abs());
                size_k = size_k.max(phi_k.abs());
            }
            if j >= self.found.len() {
                h.floor_error += (strength * phi_i).abs();
            } else if !self.found[j] {
                continue;
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
            .extend(self.hidden.iter().filter(|&&l| l <= self.limit));
        h.floor_error = 4.0 * f64::EPSILON * (h.floor_error + h.constant.abs());
        h.finish(self.mass.n(), modes, (size_i, size_k));
    }
}
