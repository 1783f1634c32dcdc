//! Poles of one excitation up to a limit, from factors of K − xM, with the proof that none is missing.
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

use super::columns::{Columns, ReceptanceAt};
use super::hidden_modes::{HiddenModes, Outside};
use super::poles::{MARGIN, Poles};
use super::receptance::Receptance;
use super::scaled::{ScaledMatrices, Scope};
use super::structure::{MOST_DENSE, Structure};
use crate::linalg::krylov::Start;
use crate::linalg::sparse::SparseMatrix;

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
    matrices: ScaledMatrices,
    /// What the Krylov spaces start from, once it is known whether all directions have a mass.
    start: Option<Start>,
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
    scope: Scope,
    succeeded: bool,
}

impl ReducedModes {
    /// Reserves the memory.
    #[must_use]
    pub fn new(structure: Arc<Structure>) -> Self {
        Self {
            start: None,
            matrices: ScaledMatrices::new(structure),
            poles: Poles::default(),
            hidden: HiddenModes::default(),
            columns: Columns::default(),
            last: None,
        }
    }

    /// Takes K and M.
    pub fn set_matrices(&mut self, k: &SparseMatrix, m: &SparseMatrix) {
        self.matrices.set(k, m);
        (self.last, self.start) = (None, None);
    }

    /// K and M, ordered and scaled.
    pub fn matrices(&mut self) -> &mut ScaledMatrices {
        &mut self.matrices
    }

    /// H_ik at `x` on the matrices; none where rounding spoils the factors of K − xM.
    pub fn receptance_at(&mut self, ends: (usize, usize), x: f64) -> Option<ReceptanceAt> {
        self.columns.receptance(&mut self.matrices, ends, x)
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
        self.columns
            .by_dof(&mut self.matrices, ends, x, left, right)
    }

    /// Finds the poles up to `limit` of the excitation, and all other modes of the whole structure if those are
    /// asked for; false where the dense solver has to.
    pub fn solve(&mut self, excitation: usize, limit: f64, whole: bool) -> bool {
        let row = self.matrices.structure().row(excitation);
        let scope = if whole {
            Scope::Whole
        } else {
            Scope::PartOf(row)
        };
        let same = |last: &Attempt| last.excitation == excitation && last.limit == limit;
        let serves = |last: &Attempt| last.scope == scope || last.scope == Scope::Whole;
        if let Some(last) = self.last.filter(|last| same(last) && serves(last)) {
            return last.succeeded;
        }
        let succeeded = self.try_solve(row, limit, scope);
        self.last = Some(Attempt {
            excitation,
            limit,
            scope,
            succeeded,
        });
        succeeded
    }

    fn try_solve(&mut self, row: usize, limit: f64, scope: Scope) -> bool {
        let n = self.matrices.n();
        let start = *self.start.get_or_insert_with(|| {
            if self.matrices.mass_is_definite() {
                Start::Response
            } else {
                Start::Remainder
            }
        });
        let few = |c| n > MOST_DENSE || c as f64 <= MOST_MODES * n as f64;
        if !few(self.matrices.count_below(limit, scope).0) {
            return false;
        }
        let sigma = SHIFT * limit;
        self.matrices.shift(sigma)
            && self
                .poles
                .find(&self.matrices, (sigma, limit), (row, start))
            && self.complete(limit, scope)
    }

    /// A place at the limit or just above it, away from all poles, and the number of modes below it.
    fn count(&mut self, limit: f64, scope: Scope) -> Option<(f64, usize)> {
        CUTS.iter().find_map(|c| {
            let cut = (1.0 + c * MARGIN) * limit;
            let distances = self.poles.lambda().map(|pole| (pole - cut).abs());
            let room = distances.fold(cut, f64::min);
            let (count, error) = self.matrices.count_below(cut, scope);
            (CLEAR * error <= room && room > ON_THE_LIMIT * cut).then_some((cut, count))
        })
    }

    /// Meets the count of modes below the limit.
    fn complete(&mut self, limit: f64, scope: Scope) -> bool {
        self.hidden.clear();
        let Some((cut, count)) = self.count(limit, scope) else {
            return false;
        };
        let shown = self.poles.count((cut + self.poles.sigma()).recip());
        if count <= shown {
            return count == shown;
        }
        self.matrices.shift(self.poles.sigma());
        let outside = Outside {
            matrices: &self.matrices,
            poles: &self.poles,
            cut,
        };
        self.hidden.find(&outside, count - shown)
    }

    /// The modes up to the limit of the last [`solve`](Self::solve), ascending, and their mass-normalised shapes
    /// by dof.
    pub fn modes(&mut self, lambda: &mut Vec<f64>, shapes: &mut Vec<f64>) {
        let (n, stride) = (self.matrices.n(), self.matrices.stride());
        let limit = self.last.map_or(0.0, |last| last.limit);
        let mut values = self.poles.modes();
        values.extend(self.hidden.lambda());
        let zero = self.poles.zero();
        let vectors = if self.hidden.lambda().is_empty() {
            self.poles.vectors(&self.matrices)
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
            self.matrices
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
        let (n, row) = (self.matrices.n(), self.matrices.structure().row(i));
        self.poles.form(n, row, self.hidden.lambda(), h);
    }
}
