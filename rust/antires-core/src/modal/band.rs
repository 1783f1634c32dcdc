//! K and M of a slender structure as band matrices, scaled to one unit, and the factors of K − xM.
//!
//! ```text
//! K̃ = S P K Pᵀ S,   M̃ = S P M Pᵀ S        P the ordering of the [`Structure`], S diagonal
//! ```
//!
//! S holds powers of two that bring each diagonal entry of M near one. They round nothing, give translations
//! and rotations one unit, and scale H_ik by a factor, which moves no zero. A *row* is a place in the ordering.

use std::sync::Arc;

use faer::MatRef;

use super::structure::Structure;
use crate::linalg::banded::{Banded, count_below};

/// Least pivot of M, relative to its diagonal, for which all directions have a mass.
const LEAST_MASS: f64 = 1e-8;

/// K̃ and M̃, with the memory for factors.
pub struct BandMatrices {
    structure: Arc<Structure>,
    stiffness: Banded,
    mass: Banded,
    scale: Vec<f64>,
    factors: Banded,
}

impl BandMatrices {
    /// Reserves the memory.
    #[must_use]
    pub fn new(structure: Arc<Structure>) -> Self {
        let band = Banded::new(structure.n_dof(), structure.half());
        Self {
            structure,
            stiffness: band.clone(),
            mass: band.clone(),
            scale: Vec::new(),
            factors: band,
        }
    }

    /// Takes K and M.
    pub fn set(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) {
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
    }

    /// The ordering.
    #[must_use]
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.mass.n()
    }

    /// Length of the vectors that [`solve`](Self::solve) takes: the rows and some zeros.
    #[must_use]
    pub fn stride(&self) -> usize {
        self.mass.n() + self.mass.half()
    }

    /// K̃.
    #[must_use]
    pub fn stiffness(&self) -> &Banded {
        &self.stiffness
    }

    /// M̃.
    #[must_use]
    pub fn mass(&self) -> &Banded {
        &self.mass
    }

    /// The diagonal of S.
    #[must_use]
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Whether all directions have a mass.
    pub fn mass_is_definite(&mut self) -> bool {
        self.factors.clone_from(&self.mass);
        self.factors.factorize_definite(LEAST_MASS)
    }

    /// Number of eigenvalues below `x`, and by how much rounding may have shifted x in it.
    pub fn count_below(&mut self, x: f64) -> (usize, f64) {
        count_below(&self.stiffness, &self.mass, x, &mut self.factors)
    }

    /// Factorizes K̃ − xM̃; returns the growth of the factors.
    pub fn factorize(&mut self, x: f64) -> f64 {
        self.factors.combine(&self.stiffness, -x, &self.mass);
        self.factors.factorize().1
    }

    /// [`factorize`](Self::factorize) with row and column `row` taken out.
    pub fn factorize_without(&mut self, row: usize, x: f64) -> f64 {
        self.factors.combine(&self.stiffness, -x, &self.mass);
        self.factors.pin(row);
        self.factors.factorize().1
    }

    /// Solves in place with the factors last made.
    pub fn solve(&self, column: &mut [f64]) {
        self.factors.solve(column);
    }

    /// Brings a vector by rows back to the dofs and their units.
    pub fn by_dof(&self, rows: &[f64], dofs: &mut [f64]) {
        for (row, (value, scale)) in rows.iter().zip(&self.scale).enumerate() {
            dofs[self.structure.dof(row)] = scale * value;
        }
    }
}
