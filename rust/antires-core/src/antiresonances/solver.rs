//! The solver: K and M handed over once, then the antiresonances of as many responses as are asked for.
//!
//! ```text
//! let mut prepared = solver.prepare(K, M);       one evaluation
//! prepared.find(i, k, &query, &mut freq_hz)      every response
//! prepared.columns((i, k), x, ...)               sensitivities of the roots
//! ```

use std::sync::Arc;

use super::pencil_route;
use super::query::{Antiresonances, Query, Route, Transfer};
use super::search::{Memory, Search};
use super::secular::Certainty;
use crate::error::{Error, Result};
use crate::fem::model::{Model, connected};
use crate::linalg::sparse::SparseMatrix;
use crate::modal::modal_columns::modal_columns;
use crate::modal::modes::{eigenvalue, hertz};
use crate::modal::on_pole::on_pole;
use crate::modal::solved::{Solutions, Solved};
use crate::modal::structure::{MOST_DENSE, Structure};

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

    /// Those of the response last found that cancel against a pole (Hz), appended to `freq_hz`.
    pub fn cancelled(&mut self, freq_hz: &mut Vec<f64>) {
        freq_hz.extend(self.memory.found().cancelled().map(hertz));
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

/// Antiresonances of each response of a model.
///
/// # Errors
/// [`crate::error::Error::InvalidInput`] for a dof outside the model, and those of the eigenproblems.
pub fn antiresonances(
    model: &Model,
    responses: &[usize],
    excitation: usize,
    query: &Query,
) -> Result<Vec<Antiresonances>> {
    if model.n_dof() > MOST_DENSE {
        check_large(model.n_dof(), query)?;
    }
    model.check_dof("excitation", excitation)?;
    for &i in responses {
        model.check_dof("response", i)?;
    }
    let (k_mat, m_mat) = (model.stiffness(), model.mass());
    let structure = Structure::of(model);
    structure.check_room()?;
    let mut solver = AntiresonanceSolver::new(&Arc::new(structure));
    let mut prepared = solver.prepare(k_mat, m_mat);
    let mut out = Vec::with_capacity(responses.len());
    for &i in responses {
        let mut found = Antiresonances::default();
        found.identically_zero = !connected(k_mat, m_mat, i, excitation)
            || prepared.find(i, excitation, query, &mut found.freq_hz)?
                == Transfer::IdenticallyZero;
        found.doubtful = !found.identically_zero && prepared.is_doubtful();
        out.push(found);
    }
    Ok(out)
}

/// All roots of a large model cost n² memory and n³ time, and QZ 25 times that.
fn check_large(n: usize, query: &Query) -> Result<()> {
    if query.route == Route::Pencil {
        return Err(Error::input(
            "method",
            format!("'pencil' for {n} dofs"),
            format!("at most {MOST_DENSE} dofs for QZ, whose time grows with their cube"),
        )
        .remedy("Leave it out: 'modal' proves its roots."));
    }
    if query.f_max_hz.is_infinite() {
        return Err(Error::input(
            "f_max_hz",
            format!("no limit for {n} dofs"),
            format!("a limit in Hz for more than {MOST_DENSE} dofs: all roots need all modes"),
        )
        .remedy(
            "Give the highest frequency that matters; time and memory go with the modes below it.",
        ));
    }
    Ok(())
}
