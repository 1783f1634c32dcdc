//! K and M of one evaluation, handed over once, with the solutions of them that are asked for.
//!
//! Each solution is made when it is first needed and serves all that follows: the poles of an excitation by
//! factors ([`ReducedModes`]), and all modes by the dense [`SymmetricSolver`]. The memory, [`Solutions`],
//! outlives the matrices and serves the next evaluation.

use std::sync::Arc;

use faer::Mat;

use super::reduced::ReducedModes;
use super::structure::{MOST_DENSE, Structure};
use crate::error::{Error, Result};
use crate::linalg::sparse::SparseMatrix;
use crate::linalg::symmetric::SymmetricSolver;

/// Memory for the solutions of the models of one structure.
pub struct Solutions {
    structure: Arc<Structure>,
    reduced: Option<ReducedModes>,
    dense: Option<Dense>,
}

/// The dense solver and its copies of K and M.
struct Dense {
    solver: SymmetricSolver,
    stiffness: Mat<f64>,
    mass: Mat<f64>,
}

impl Solutions {
    /// Memory for the models of one structure; it is reserved when first needed.
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self { structure: Arc::clone(structure), reduced: None, dense: None }
    }

    /// The solutions of K and M.
    pub fn of<'a>(&'a mut self, stiffness: &'a SparseMatrix, mass: &'a SparseMatrix) -> Solved<'a> {
        Solved { stiffness, mass, memory: self, reduced_is_current: false, dense_is_current: false }
    }
}

/// K and M with the solutions made of them so far.
pub struct Solved<'a> {
    /// K (N/m).
    pub stiffness: &'a SparseMatrix,
    /// M (kg).
    pub mass: &'a SparseMatrix,
    memory: &'a mut Solutions,
    /// Whether the memory holds these matrices.
    reduced_is_current: bool,
    dense_is_current: bool,
}

impl Solved<'_> {
    /// Number of dofs.
    pub fn n_dof(&self) -> usize {
        self.stiffness.n()
    }

    /// Upper bound of the number of roots of H_ik, see [`Structure::degree`].
    pub fn degree(&self, i: usize, k: usize) -> Option<usize> {
        self.memory.structure.degree(i, k)
    }

    /// Whether the modes below a limit cost less than all of them.
    pub fn is_reducible(&self) -> bool {
        self.memory.structure.is_reducible()
    }

    /// Whether the dense solvers may be asked: they need seconds to minutes, and n² numbers, above that.
    pub fn may_be_dense(&self) -> bool {
        self.n_dof() <= MOST_DENSE
    }

    /// The modes below a limit.
    pub fn reduced(&mut self) -> &mut ReducedModes {
        let structure = &self.memory.structure;
        let reduced = self.memory.reduced.get_or_insert_with(|| ReducedModes::new(Arc::clone(structure)));
        if !self.reduced_is_current {
            reduced.set_matrices(self.stiffness, self.mass);
            self.reduced_is_current = true;
        }
        reduced
    }

    /// All modes.
    pub fn dense(&mut self) -> Result<&SymmetricSolver> {
        let n = self.n_dof();
        if !self.may_be_dense() {
            return Err(Error::Numerical {
                what: format!("the modes of {n} dofs"),
                detail: "the factors of K - x M do not settle them, and there are too many dofs for the \
                         dense solvers. Ask for a lower f_max_hz, or check that the stiffness is positive \
                         semi-definite and that no dof has neither stiffness nor mass."
                    .into(),
            });
        }
        let dense = self.memory.dense.get_or_insert_with(|| Dense {
            solver: SymmetricSolver::new(n),
            stiffness: Mat::zeros(n, n),
            mass: Mat::zeros(n, n),
        });
        if !self.dense_is_current {
            self.stiffness.write_dense(&mut dense.stiffness);
            self.mass.write_dense(&mut dense.mass);
            let (k, m) = (dense.stiffness.as_ref(), dense.mass.as_ref());
            dense.solver.solve(k, m)?;
            self.dense_is_current = true;
        }
        Ok(&dense.solver)
    }

    /// All modes, if they were solved for.
    pub fn dense_in_hand(&self) -> Option<&SymmetricSolver> {
        let dense = self.memory.dense.as_ref();
        dense.filter(|_| self.dense_is_current).map(|d| &d.solver)
    }
}
