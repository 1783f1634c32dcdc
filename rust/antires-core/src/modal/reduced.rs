//! Poles of one excitation up to a limit, from band matrices, with the proof that none is missing.
//!
//! 1. A Krylov space of the load gives H_ik for every i as partial fractions that are exact to rounding below
//!    the limit (`poles`).
//! 2. By Sylvester's law the inertia of K − xM counts all modes below the limit. Each of the poles found has
//!    a residual far below its distance from the next, so if there are as many, they are the modes.
//! 3. If there are more modes than poles, the load does not excite the others: a node at the excitation, or
//!    a repeated eigenvalue, of which any load excites one combination only. They are sought in the
//!    complement of those found until the count is met (`hidden_modes`).
//!
//! What cannot be settled so is left to the dense solver.

use std::sync::Arc;

use faer::MatRef;

use super::band::BandMatrices;
use super::columns::{Columns, ReceptanceAt};
use super::hidden_modes::{HiddenModes, Outside};
use super::poles::{MARGIN, Poles};
use super::receptance::Receptance;
use super::structure::Structure;
use crate::linalg::banded::Banded;

/// Shift σ as a fraction of the limit in x. A small one separates the poles best, a large one keeps the
/// digits of the lowest: at one tenth the digits of λ are lost to (λ + σ)/σ, eleven at most.
const SHIFT: f64 = 0.1;

/// Largest share of the modes below the limit for which a part of them costs less than all.
const MOST_MODES: f64 = 0.35;

/// Places of the count above the limit, as parts of the margin.
const CUTS: [f64; 5] = [0.0, 0.37, 0.61, 0.84, 0.99];

/// Distance of the count from the next pole, in rounding errors of the count.
const CLEAR: f64 = 10.0;

/// Least relative distance of the count from a pole.
const ON_THE_LIMIT: f64 = 1e-8;

/// Modes and pseudo-modes as seen by one excitation.
pub struct ReducedModes {
    band: BandMatrices,
    /// Factors of K + σM.
    shifted: Banded,
    poles: Poles,
    hidden: HiddenModes,
    columns: Columns,
    last: Option<Attempt>,
}

/// What was last asked of the matrices.
#[derive(Clone, Copy)]
struct Attempt {
    excitation: usize,
    limit: f64,
    succeeded: bool,
}

impl ReducedModes {
    /// Reserves the memory.
    #[must_use]
    pub fn new(structure: Arc<Structure>) -> Self {
        let shifted = Banded::new(structure.n_dof(), structure.half());
        Self {
            band: BandMatrices::new(structure),
            shifted,
            poles: Poles::default(),
            hidden: HiddenModes::default(),
            columns: Columns::default(),
            last: None,
        }
    }

    /// Takes K and M.
    pub fn set_matrices(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) {
        self.band.set(k, m);
        self.last = None;
    }

    /// K and M as band matrices.
    pub fn band(&mut self) -> &mut BandMatrices {
        &mut self.band
    }

    /// H_ik at `x` on the matrices; none where rounding spoils the factors of K − xM.
    pub fn receptance_at(&mut self, ends: (usize, usize), x: f64) -> Option<ReceptanceAt> {
        self.columns.receptance(&mut self.band, ends, x)
    }

    /// Columns i and k of (K − xM)⁻¹ by dof, each up to a factor, into `left` and `right`; returns leftᵀ M
    /// right, none where rounding spoils the factors of K − xM.
    pub fn columns(
        &mut self,
        ends: (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Option<f64> {
        self.columns.by_dof(&mut self.band, ends, x, left, right)
    }

    /// Finds the poles up to `limit` of the excitation; false where the dense solver has to.
    pub fn solve(&mut self, excitation: usize, limit: f64) -> bool {
        match self.last {
            Some(last) if last.excitation == excitation && last.limit == limit => last.succeeded,
            _ => {
                let succeeded = self.try_solve(excitation, limit);
                self.last = Some(Attempt {
                    excitation,
                    limit,
                    succeeded,
                });
                succeeded
            }
        }
    }

    fn try_solve(&mut self, excitation: usize, limit: f64) -> bool {
        let n = self.band.n();
        if !self.band.mass_is_definite() {
            return false;
        }
        let sigma = SHIFT * limit;
        self.shifted
            .combine(self.band.stiffness(), sigma, self.band.mass());
        if !self.shifted.factorize_definite(0.0) {
            return false;
        }
        let few = |c| c as f64 <= MOST_MODES * n as f64;
        if !few(self.band.count_below(limit).0) {
            return false;
        }
        let row = self.band.structure().row(excitation);
        self.poles
            .find(&self.band, &self.shifted, (sigma, limit), row)
            && self.complete(limit)
    }

    /// A place at the limit or just above it, away from all poles, and the number of modes below it.
    fn count(&mut self, limit: f64) -> Option<(f64, usize)> {
        CUTS.iter().find_map(|c| {
            let cut = (1.0 + c * MARGIN) * limit;
            let distances = self.poles.lambda().map(|pole| (pole - cut).abs());
            let room = distances.fold(cut, f64::min);
            let (count, error) = self.band.count_below(cut);
            (CLEAR * error <= room && room > ON_THE_LIMIT * cut).then_some((cut, count))
        })
    }

    /// Meets the count of modes below the limit.
    fn complete(&mut self, limit: f64) -> bool {
        self.hidden.clear();
        let Some((cut, count)) = self.count(limit) else {
            return false;
        };
        let shown = self.poles.count((cut + self.poles.sigma()).recip());
        if count <= shown {
            return count == shown;
        }
        let outside = Outside {
            band: &self.band,
            shifted: &self.shifted,
            poles: &self.poles,
            cut,
        };
        self.hidden.find(&outside, count - shown)
    }

    /// The modes up to the limit of the last [`solve`](Self::solve), ascending, and their mass-normalised shapes
    /// by dof.
    pub fn modes(&mut self, lambda: &mut Vec<f64>, shapes: &mut Vec<f64>) {
        let (n, stride) = (self.band.n(), self.band.stride());
        let limit = self.last.map_or(0.0, |last| last.limit);
        let mut values = self.poles.modes();
        values.extend(self.hidden.lambda());
        let zero = self.poles.zero();
        let vectors = if self.hidden.lambda().is_empty() {
            self.poles.vectors()
        } else {
            self.hidden.vectors()
        };
        let mut order: Vec<usize> = (0..values.len()).filter(|&j| values[j] <= limit).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        lambda.clear();
        shapes.clear();
        for j in order {
            let value = values[j];
            lambda.push(if value.abs() <= zero { 0.0 } else { value });
            let at = shapes.len();
            shapes.resize(at + n, 0.0);
            self.band
                .by_dof(&vectors[j * stride..j * stride + n], &mut shapes[at..]);
        }
    }

    /// Rounding error of the poles near x: that of Θ.
    #[must_use]
    pub fn pole_error(&self, x: f64) -> f64 {
        self.poles.error(x)
    }

    /// Eigenvalues and roots below this are zero at working precision.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.poles.zero()
    }

    /// Forms the partial fractions between dof `i` and the excitation of the last [`solve`](Self::solve).
    pub fn form(&mut self, i: usize, h: &mut Receptance) {
        let (n, row) = (self.band.n(), self.band.structure().row(i));
        self.poles.form(n, row, self.hidden.lambda(), h);
    }
}
