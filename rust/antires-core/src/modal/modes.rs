//! Resonant frequencies and mass-normalised mode shapes.

use faer::{Mat, MatRef};

use crate::error::Result;
use crate::fem::model::Model;
use crate::linalg::symmetric::SymmetricSolver;

/// All finite modes of a model.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Resonant frequencies (Hz), ascending; rigid-body modes at 0. An unstable mode (λ < 0) has NaN.
    pub freq_hz: Vec<f64>,
    /// Shapes [n_dof x n_modes], φᵀ M φ = 1.
    pub shapes: Mat<f64>,
}

/// Frequency in Hz of an eigenvalue λ = ω² in (rad/s)².
#[must_use]
pub fn hertz(lambda: f64) -> f64 {
    lambda.sqrt() / std::f64::consts::TAU
}

/// λ = ω² in (rad/s)² of a frequency in Hz.
#[must_use]
pub fn eigenvalue(freq_hz: f64) -> f64 {
    (std::f64::consts::TAU * freq_hz).powi(2)
}

/// Solves for all finite modes of `model`.
///
/// # Errors
/// Those of [`SymmetricSolver::solve`].
pub fn modes(model: &Model) -> Result<Modes> {
    let mut solver = SymmetricSolver::new(model.n_dof());
    solver.solve(model.stiffness(), model.mass())?;
    let finite = solver.eigenvalues().len();
    let shapes: MatRef<'_, f64> = solver.vectors().get(.., ..finite);
    Ok(Modes {
        freq_hz: solver.eigenvalues().iter().map(|&l| hertz(l)).collect(),
        shapes: shapes.to_owned(),
    })
}
