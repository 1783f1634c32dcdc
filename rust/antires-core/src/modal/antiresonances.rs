//! Antiresonances of H_ik: the positive real x = ω² with det(K_ik − x M_ik) = 0.
//!
//! - The **modal route** takes one symmetric eigenproblem for all responses and brackets the zeros of
//!   each receptance between its poles ([`super::secular`]). It is what the optimizer runs.
//! - The **pencil route** deletes row i and column k and solves the general eigenproblem by QZ
//!   ([`crate::linalg::pencil`]). It is the reference, but for roots far below the norm of the matrices: those
//!   that the modal series isolates and Newton's method confirms on the matrices are joined to it (`join`).
//!
//! Both leave out, by default, the roots that cancel against a pole ([`Receptance`]), since no
//! measurement can show them. Dropped by both: roots that are infinite, negative, complex, or zero at
//! working precision (the tolerances of [`crate::linalg::tolerances`]).
//!
//! Source: Meruane, J. Sound Vib. 332 (2013) 807-820; D'Ambrogio & Fregolent, J. Sound Vib. 236
//! (2000) 227-243.

use std::sync::Arc;

use faer::MatRef;

use super::columns::modal_columns;
use super::isolate::{Found, Series};
use super::modes::{eigenvalue, hertz};
use super::receptance::Receptance;
use super::reduced::ReducedModes;
use super::secular::Scratch;
use super::structure::Structure;
use crate::error::Result;
use crate::fem::model::{Model, connected};
use crate::linalg::symmetric::SymmetricSolver;

/// How the roots are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// Zeros of the modal series.
    Modal,
    /// Generalized eigenvalues of the deleted pencil.
    Pencil,
}

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Query {
    /// The route.
    pub route: Route,
    /// Highest frequency (Hz), infinity for all.
    pub f_max_hz: f64,
    /// Whether roots that cancel against a pole are returned too.
    pub include_cancelled: bool,
}

/// Antiresonances of one response.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Antiresonances {
    /// Frequencies (Hz), ascending.
    pub freq_hz: Vec<f64>,
    /// True when H_ik is identically zero: response and excitation are not connected.
    pub identically_zero: bool,
}

/// K and M.
pub(super) type Matrices<'a> = (MatRef<'a, f64>, MatRef<'a, f64>);

/// Solver with its working memory; one eigenproblem serves every response.
///
/// A slender structure with a limit in frequency is solved by [`ReducedModes`], all else, and what that
/// leaves open, by the dense [`SymmetricSolver`].
pub struct AntiresonanceSolver {
    pub(super) structure: Arc<Structure>,
    /// Each made when first needed, with whether it holds the matrices last set.
    pub(super) band: Option<(ReducedModes, bool)>,
    pub(super) dense: Option<(SymmetricSolver, bool)>,
    pub(super) receptance: Receptance,
    pub(super) scratch: Scratch,
    pub(super) found: Found,
}

impl AntiresonanceSolver {
    /// Reserves the memory for the models of one structure.
    #[must_use]
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self {
            structure: Arc::clone(structure),
            band: None,
            dense: None,
            receptance: Receptance::default(),
            scratch: Scratch::default(),
            found: Found::default(),
        }
    }

    /// Takes the matrices of the following queries.
    pub fn set_matrices(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) {
        if let Some((_, current)) = &mut self.band {
            *current = false;
        }
        if let Some((_, current)) = &mut self.dense {
            *current = false;
        }
        if self.structure.is_slender() {
            band(&mut self.band, &self.structure, (k, m));
        }
    }

    /// Columns i and k of (K − xM)⁻¹, each up to a factor, into `left` and `right`; returns leftᵀ M right.
    /// `matrices` are those last set.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn columns(
        &mut self,
        matrices: (MatRef<'_, f64>, MatRef<'_, f64>),
        (i, k): (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Result<f64> {
        if self.structure.is_slender()
            && let Some(slope) =
                band(&mut self.band, &self.structure, matrices).columns((i, k), x, left, right)
        {
            return Ok(slope);
        }
        Ok(modal_columns(
            dense(&mut self.dense, matrices)?,
            (i, k),
            x,
            left,
            right,
        ))
    }

    /// Antiresonances (Hz) of H_ik up to the limit of the query, appended to `freq_hz`; `matrices` are
    /// those last set. Returns false when H_ik is identically zero at working precision.
    ///
    /// Where rounding leaves the modal route in doubt, the roots of the pencil join those that are proven.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`], and of the pencil if that is the route asked for.
    pub fn find(
        &mut self,
        matrices: (MatRef<'_, f64>, MatRef<'_, f64>),
        i: usize,
        k: usize,
        query: &Query,
        freq_hz: &mut Vec<f64>,
    ) -> Result<bool> {
        let ceiling = eigenvalue(query.f_max_hz);
        let certain = self.search(matrices, (i, k), ceiling)?;
        if query.route == Route::Modal && self.receptance.is_zero {
            return Ok(false);
        }
        let floor = self.found.floor;
        self.found.cancelled.retain(|&(x, _)| x > floor);
        if query.route == Route::Pencil || !certain {
            match self.join_pencil(matrices, (i, k), ceiling) {
                Err(error) if query.route == Route::Pencil => return Err(error),
                Err(_) => self.found.proven.append(&mut self.found.open),
                Ok(()) => {}
            }
        }
        if query.include_cancelled {
            let cancelled = self.found.cancelled.iter().map(|(x, _)| x);
            self.found.proven.extend(cancelled);
        }
        self.found.proven.sort_by(f64::total_cmp);
        freq_hz.extend(self.found.proven.iter().map(|&x| hertz(x)));
        Ok(true)
    }

    /// Finds the roots up to `ceiling` by the modal series; false where rounding leaves a doubt.
    fn search(
        &mut self,
        matrices: Matrices<'_>,
        (i, k): (usize, usize),
        ceiling: f64,
    ) -> Result<bool> {
        self.found.clear();
        if ceiling.is_finite() && self.structure.is_slender() {
            let band = band(&mut self.band, &self.structure, matrices);
            if band.solve(k, ceiling) {
                band.form(i, &mut self.receptance);
                self.receptance.most_roots = None;
                self.found.floor = band.zero();
                return Ok(self.isolate(matrices, (i, k), (0.0, ceiling), Series::Band));
            }
        }
        let solver = dense(&mut self.dense, matrices)?;
        self.receptance.form(solver, i, k);
        self.receptance.most_roots = self.structure.degree(i, k);
        self.found.floor = solver.zero();
        if self.isolate(matrices, (i, k), (0.0, ceiling), Series::Dense) {
            return Ok(true);
        }
        Ok(self.divided(matrices, (i, k), ceiling))
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
    model.check_dof("excitation", excitation)?;
    for &i in responses {
        model.check_dof("response", i)?;
    }
    let (k_mat, m_mat) = (model.stiffness(), model.mass());
    let mut solver = AntiresonanceSolver::new(&Arc::new(Structure::of(model)));
    solver.set_matrices(k_mat, m_mat);
    let mut out = Vec::with_capacity(responses.len());
    for &i in responses {
        let mut found = Antiresonances::default();
        found.identically_zero = !connected(k_mat, m_mat, i, excitation)
            || !solver.find((k_mat, m_mat), i, excitation, query, &mut found.freq_hz)?;
        out.push(found);
    }
    Ok(out)
}

/// The band matrices of the matrices last set, made when first asked for.
pub(super) fn band<'a>(
    kept: &'a mut Option<(ReducedModes, bool)>,
    structure: &Arc<Structure>,
    (k_mat, m_mat): Matrices<'_>,
) -> &'a mut ReducedModes {
    let (band, current) =
        kept.get_or_insert_with(|| (ReducedModes::new(Arc::clone(structure)), false));
    if !*current {
        band.set_matrices(k_mat, m_mat);
        *current = true;
    }
    band
}

/// The dense solution of the matrices last set, made when first asked for.
pub(super) fn dense<'a>(
    kept: &'a mut Option<(SymmetricSolver, bool)>,
    (k_mat, m_mat): (MatRef<'_, f64>, MatRef<'_, f64>),
) -> Result<&'a SymmetricSolver> {
    let (solver, current) =
        kept.get_or_insert_with(|| (SymmetricSolver::new(k_mat.nrows()), false));
    if !*current {
        solver.solve(k_mat, m_mat)?;
        *current = true;
    }
    Ok(solver)
}
