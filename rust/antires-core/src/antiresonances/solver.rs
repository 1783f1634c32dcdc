//! The solver: K and M handed over once, then the antiresonances of as many responses as are asked for.
//!
//! ```text
//! let mut prepared = solver.prepare(K, M);       one evaluation
//! prepared.find(i, k, &query, &mut freq_hz)      every response
//! prepared.columns((i, k), x, ...)               sensitivities of the roots
//! ```

use std::sync::Arc;

use super::pencil_route;
use super::query::{Query, Route, Transfer};
use super::search::{Memory, Search};
use super::secular::Certainty;
use crate::error::Result;
use crate::linalg::pencil::UNCERTAIN;
use crate::linalg::sparse::SparseMatrix;
use crate::modal::modal_columns::modal_columns;
use crate::modal::modes::{eigenvalue, hertz};
use crate::modal::on_pole::on_pole;
use crate::modal::solved::{Solutions, Solved};
use crate::modal::structure::Structure;

/// Ulps of K and M by which factors without pivoting may move a root, beside √n.
const FACTOR_ULPS: f64 = 64.0;

/// Working memory for the models of one structure.
///
/// Below a limit in frequency, where factors of K − xM are cheap, it is solved by
/// [`ReducedModes`](crate::modal::reduced::ReducedModes), all else, and what that leaves open, by the dense
/// [`SymmetricSolver`](crate::linalg::symmetric::SymmetricSolver).
pub struct AntiresonanceSolver {
    solutions: Solutions,
    memory: Memory,
}

impl AntiresonanceSolver {
    /// Reserves the memory for the models of one structure.
    #[must_use]
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self {
            solutions: Solutions::new(structure),
            memory: Memory::default(),
        }
    }

    /// Takes K and M.
    #[must_use]
    pub fn prepare<'a>(
        &'a mut self,
        stiffness: &'a SparseMatrix,
        mass: &'a SparseMatrix,
    ) -> Prepared<'a> {
        Prepared {
            solved: self.solutions.of(stiffness, mass),
            memory: &mut self.memory,
            doubtful: false,
        }
    }
}

/// K and M with what was solved of them: one eigenproblem serves every response.
pub struct Prepared<'a> {
    solved: Solved<'a>,
    memory: &'a mut Memory,
    doubtful: bool,
}

impl Prepared<'_> {
    /// Antiresonances (Hz) of H_ik up to the limit of the query, appended to `freq_hz`.
    ///
    /// Where rounding leaves the modal route in doubt, the roots of the pencil join those that are proven.
    ///
    /// # Errors
    /// Those of [`Solved::dense`], and of the pencil if that is the route asked for.
    pub fn find(
        &mut self,
        i: usize,
        k: usize,
        query: &Query,
        freq_hz: &mut Vec<f64>,
    ) -> Result<Transfer> {
        let ceiling = eigenvalue(query.f_max_hz);
        // The pencil has the roots of all parts of the structure, of those too that the force does not move.
        let for_pencil = query.include_cancelled || query.route == Route::Pencil;
        let mut certainty = self.search((i, k), for_pencil, ceiling)?;
        if certainty == Certainty::Doubtful && !for_pencil && self.solved.may_be_dense() {
            certainty = self.search((i, k), true, ceiling)?;
        }
        if query.route == Route::Modal && self.memory.is_zero() {
            return Ok(Transfer::IdenticallyZero);
        }
        let found = self.memory.found();
        found.drop_cancelled_zeros();
        self.doubtful = certainty == Certainty::Doubtful && !self.solved.may_be_dense();
        if self.doubtful {
            found.settle_open();
        } else if query.route == Route::Pencil || certainty == Certainty::Doubtful {
            match pencil_route::join(&mut self.solved, (i, k), ceiling, found) {
                Err(error) if query.route == Route::Pencil => return Err(error),
                Err(_) => found.settle_open(),
                Ok(()) => {}
            }
        }
        if query.include_cancelled {
            found.include_cancelled();
        }
        freq_hz.extend(found.sorted().iter().map(|&x| hertz(x)));
        Ok(Transfer::Present)
    }

    fn search(&mut self, ends: (usize, usize), whole: bool, ceiling: f64) -> Result<Certainty> {
        Search::new(&mut self.solved, ends, whole, self.memory).run(ceiling)
    }

    /// Whether rounding leaves a doubt about the number of roots last found: of structures too large for the
    /// pencil.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// How far (Hz) a root at `freq_hz` may be from that of the matrices, by factors of K − xM; infinite where those
    /// do not tell.
    pub fn bound(&mut self, ends: (usize, usize), freq_hz: f64) -> f64 {
        let x = eigenvalue(freq_hz);
        let ulps = FACTOR_ULPS + (self.solved.n_dof() as f64).sqrt();
        let error = match self.solved.reduced().receptance_at(ends, x) {
            Some(here) => (here.value / here.slope).abs() + ulps * here.ulp,
            None => f64::INFINITY,
        };
        if error <= UNCERTAIN * x {
            freq_hz - hertz(x - error)
        } else {
            f64::INFINITY
        }
    }

    /// Those of the response last found that cancel against a pole (Hz), appended to `freq_hz`.
    pub fn cancelled(&mut self, freq_hz: &mut Vec<f64>) {
        freq_hz.extend(self.memory.found().cancelled().map(hertz));
    }

    /// Eigenvalues of the whole structure, ascending.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn eigenvalues(&mut self) -> Result<&[f64]> {
        Ok(self.solved.dense()?.eigenvalues())
    }

    /// Null vectors of the deleted pencil at a root `x` that cancels against a pole, into `left` and `right`;
    /// returns leftᵀ M right.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn vectors_on_pole(
        &mut self,
        ends: (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Result<f64> {
        Ok(on_pole(self.solved.dense()?, ends, x, left, right))
    }

    /// Columns i and k of (K − xM)⁻¹, each up to a factor, into `left` and `right`; returns leftᵀ M right.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn columns(
        &mut self,
        ends: (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Result<f64> {
        if self.solved.is_reducible()
            && let Some(slope) = self.solved.reduced().columns(ends, x, left, right)
        {
            return Ok(slope);
        }
        Ok(modal_columns(self.solved.dense()?, ends, x, left, right))
    }
}
