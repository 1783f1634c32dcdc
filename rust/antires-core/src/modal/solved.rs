//! K and M of one evaluation, handed over once, with the solutions of them that are asked for.
//!
//! Each solution is made when it is first needed and serves all that follows: the poles of an excitation by
//! the band ([`ReducedModes`]), and all modes by the dense [`SymmetricSolver`]. The memory, [`Solutions`],
//! outlives the matrices and serves the next evaluation.

use std::sync::Arc;

use faer::MatRef;

use super::reduced::ReducedModes;
use super::structure::Structure;
use crate::error::Result;
use crate::linalg::symmetric::SymmetricSolver;

/// Memory for the solutions of the models of one structure.
pub struct Solutions {
    structure: Arc<Structure>,
    band: Option<ReducedModes>,
    dense: Option<SymmetricSolver>,
}

impl Solutions {
    /// Memory for the models of one structure; it is reserved when first needed.
    #[must_use]
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self {
            structure: Arc::clone(structure),
            band: None,
            dense: None,
        }
    }

    /// The solutions of K and M.
    #[must_use]
    pub fn of<'a>(&'a mut self, stiffness: MatRef<'a, f64>, mass: MatRef<'a, f64>) -> Solved<'a> {
        Solved {
            stiffness,
            mass,
            memory: self,
            band_is_current: false,
            dense_is_current: false,
        }
    }
}

/// K and M with the solutions made of them so far.
pub struct Solved<'a> {
    stiffness: MatRef<'a, f64>,
    mass: MatRef<'a, f64>,
    memory: &'a mut Solutions,
    /// Whether the memory holds these matrices.
    band_is_current: bool,
    dense_is_current: bool,
}

impl Solved<'_> {
    /// K (N/m).
    #[must_use]
    pub fn stiffness(&self) -> MatRef<'_, f64> {
        self.stiffness
    }

    /// M (kg).
    #[must_use]
    pub fn mass(&self) -> MatRef<'_, f64> {
        self.mass
    }

    /// Number of dofs.
    #[must_use]
    pub fn n_dof(&self) -> usize {
        self.stiffness.nrows()
    }

    /// Upper bound of the number of roots of H_ik, see [`Structure::degree`].
    #[must_use]
    pub fn degree(&self, i: usize, k: usize) -> Option<usize> {
        self.memory.structure.degree(i, k)
    }

    /// Whether the band route pays.
    #[must_use]
    pub fn is_slender(&self) -> bool {
        self.memory.structure.is_slender()
    }

    /// The band route.
    pub fn band(&mut self) -> &mut ReducedModes {
        let structure = &self.memory.structure;
        let band = self
            .memory
            .band
            .get_or_insert_with(|| ReducedModes::new(Arc::clone(structure)));
        if !self.band_is_current {
            band.set_matrices(self.stiffness, self.mass);
            self.band_is_current = true;
        }
        band
    }

    /// All modes.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn dense(&mut self) -> Result<&SymmetricSolver> {
        let n = self.n_dof();
        let solver = self
            .memory
            .dense
            .get_or_insert_with(|| SymmetricSolver::new(n));
        if !self.dense_is_current {
            solver.solve(self.stiffness, self.mass)?;
            self.dense_is_current = true;
        }
        Ok(solver)
    }

    /// All modes, if they were solved for.
    #[must_use]
    pub fn dense_in_hand(&self) -> Option<&SymmetricSolver> {
        self.memory.dense.as_ref().filter(|_| self.dense_is_current)
    }
}
