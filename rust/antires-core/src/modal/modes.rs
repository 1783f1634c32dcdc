//! Resonant frequencies and mass-normalised mode shapes: all, or the lowest.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::reduced::ReducedModes;
use super::scaled::{ScaledMatrices, Scope};
use super::structure::Structure;
use crate::error::{Error, Result};
use crate::fem::model::Model;
use crate::linalg::symmetric::SymmetricSolver;

/// Modes more than asked for, and half of those, that the factors may find.
const SPARE: usize = 4;

/// Counts of modes at most in a search for their limit, and the step down from a λ with too many below it.
const MOST_COUNTS: usize = 60;
const COARSE: f64 = 1e-2;

/// Finite modes of a model.
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

/// All solutions of K φ = λ M φ.
#[derive(Debug, Clone)]
pub struct AllModes {
    /// Finite eigenvalues, ascending.
    pub lambda: Vec<f64>,
    /// Their shapes, then the massless ones of [`SymmetricSolver::vectors`], [n_dof x n_dof].
    pub vectors: Mat<f64>,
}

impl AllModes {
    /// Solves the dense eigenproblem of `model`.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn of(model: &Model) -> Result<Self> {
        let n = model.n_dof();
        Error::check_memory(
            || format!("all modes of {n} dofs"),
            n.saturating_mul(n).saturating_mul(6),
        )?;
        let mut solver = SymmetricSolver::new(n);
        let (k, m) = (model.stiffness().to_dense(), model.mass().to_dense());
        solver.solve(k.as_ref(), m.as_ref())?;
        Ok(Self {
            lambda: solver.eigenvalues().to_vec(),
            vectors: solver.vectors().to_owned(),
        })
    }

    /// The finite modes.
    #[must_use]
    pub fn finite(&self) -> Modes {
        let shapes: MatRef<'_, f64> = self.vectors.get(.., ..self.lambda.len());
        Modes {
            freq_hz: self.lambda.iter().map(|&l| hertz(l)).collect(),
            shapes: shapes.to_owned(),
        }
    }
}

/// Solves for all finite modes of `model`.
///
/// # Errors
/// Those of [`SymmetricSolver::solve`].
pub fn modes(model: &Model) -> Result<Modes> {
    Ok(AllModes::of(model)?.finite())
}

/// The lowest modes of a model, up to `f_max_hz` and at most `most` of them, from factors of K − xM: a count
/// by inertia proves that none is missing. None where those are not cheap, where they are more than a part
/// of all modes, or where rounding leaves a doubt: then [`AllModes`] has to tell.
///
/// # Errors
/// [`Error::Memory`].
pub fn low_modes(model: &Model, f_max_hz: f64, most: Option<usize>) -> Result<Option<Modes>> {
    let structure = Structure::of(model);
    structure.check_room()?;
    Ok(by_factors(structure, model, f_max_hz, most))
}

fn by_factors(
    structure: Structure,
    model: &Model,
    f_max_hz: f64,
    most: Option<usize>,
) -> Option<Modes> {
    if !structure.is_reducible() {
        return None;
    }
    let mut reduced = ReducedModes::new(Arc::new(structure));
    reduced.set_matrices(model.stiffness(), model.mass());
    let mut limit = eigenvalue(f_max_hz);
    if let Some(most) = most {
        limit = limit.min(limit_above(most, reduced.matrices())?);
    }
    if !(limit.is_finite() && reduced.solve(0, limit, true)) {
        return None;
    }
    let (mut lambda, mut shapes) = (Vec::new(), Vec::new());
    reduced.modes(&mut lambda, &mut shapes);
    lambda.truncate(most.unwrap_or(usize::MAX));
    let n = model.n_dof();
    Some(Modes {
        freq_hz: lambda.iter().map(|&l| hertz(l)).collect(),
        shapes: Mat::from_fn(n, lambda.len(), |dof, r| shapes[r * n + dof]),
    })
}

/// A λ with `most` modes below it, or a few more; none where the search for it leads nowhere.
fn limit_above(most: usize, matrices: &mut ScaledMatrices) -> Option<f64> {
    let enough = most..=most + most / 2 + SPARE;
    let largest = matrices.stiffness().largest_diagonal();
    let (mut low, mut high) = (0.0, largest);
    for _ in 0..MOST_COUNTS {
        // Halving the exponent, until there is a lower end.
        let at = if low > 0.0 {
            f64::sqrt(low * high)
        } else {
            COARSE * high
        };
        let (count, _) = matrices.count_below(at, Scope::Whole);
        if enough.contains(&count) {
            return Some(at);
        }
        *(if count < most { &mut low } else { &mut high }) = at;
    }
    None
}
