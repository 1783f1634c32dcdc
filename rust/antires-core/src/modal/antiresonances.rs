//! Antiresonances of H_ik: the positive real x = ω² with det(K_ik − x M_ik) = 0.
//!
//! - The **modal route** takes one symmetric eigenproblem for all responses and brackets the zeros of
//!   each receptance between its poles ([`secular`]). It is what the optimizer runs.
//! - The **pencil route** deletes row i and column k and solves the general eigenproblem by QZ
//!   ([`crate::linalg::pencil`]). It is the reference.
//!
//! Both leave out, by default, the roots that cancel against a pole ([`Receptance`]), since no
//! measurement can show them. Dropped by both: roots that are infinite, negative, complex, or zero at
//! working precision (the tolerances of [`crate::linalg::tolerances`]).
//!
//! Source: Meruane, J. Sound Vib. 332 (2013) 807-820; D'Ambrogio & Fregolent, J. Sound Vib. 236
//! (2000) 227-243.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::columns::modal_columns;
use super::modes::{eigenvalue, hertz};
use super::receptance::Receptance;
use super::reduced::ReducedModes;
use super::secular::{self, Scratch};
use super::structure::Structure;
use crate::error::Result;
use crate::fem::model::{Model, connected};
use crate::linalg::pencil::real_eigenvalues;
use crate::linalg::symmetric::SymmetricSolver;

/// Relative distance within which a pencil root is the cancelled one expected at a pole.
const SAME_ROOT: f64 = 1e-6;

/// Relative uncertainty of a root in x from which on it is doubtful.
const DOUBTFUL_ROOT: f64 = 1e-9;

/// Relative uncertainty of a root in x from which on it is polished on the matrices.
const POLISHED_ROOT: f64 = 1e-10;

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

/// Solver with its working memory; one eigenproblem serves every response.
///
/// A slender structure with a limit in frequency is solved by [`ReducedModes`], all else, and what that
/// leaves open, by the dense [`SymmetricSolver`].
pub struct AntiresonanceSolver {
    structure: Arc<Structure>,
    reduced: Option<ReducedModes>,
    /// Made when first needed, with whether it holds the matrices last set.
    dense: Option<(SymmetricSolver, bool)>,
    /// Roots below this are zero at working precision.
    floor: f64,
    /// Whether the receptance in hand is that of the band route.
    by_reduced: bool,
    receptance: Receptance,
    lambda: Vec<f64>,
    scratch: Scratch,
}

impl AntiresonanceSolver {
    /// Reserves the memory for the models of one structure.
    #[must_use]
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self {
            structure: Arc::clone(structure),
            reduced: structure
                .is_slender()
                .then(|| ReducedModes::new(Arc::clone(structure))),
            dense: None,
            floor: 0.0,
            by_reduced: false,
            receptance: Receptance::default(),
            lambda: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    /// Takes the matrices of the following queries.
    pub fn set_matrices(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) {
        if let Some(reduced) = &mut self.reduced {
            reduced.set_matrices(k, m);
        }
        if let Some((_, current)) = &mut self.dense {
            *current = false;
        }
    }

    /// Forms the receptance between dofs `i` and `k`, exact up to the limit of the query.
    fn form(
        &mut self,
        (k_mat, m_mat): (MatRef<'_, f64>, MatRef<'_, f64>),
        i: usize,
        k: usize,
        query: &Query,
    ) -> Result<()> {
        if query.f_max_hz.is_finite()
            && let Some(reduced) = &mut self.reduced
            && reduced.solve(k, eigenvalue(query.f_max_hz))
        {
            reduced.form(i, &mut self.receptance);
            self.receptance.most_roots = None;
            self.floor = reduced.zero();
            self.by_reduced = true;
            return Ok(());
        }
        let solver = dense(&mut self.dense, (k_mat, m_mat))?;
        self.receptance.form(solver, i, k);
        self.receptance.most_roots = self.structure.degree(i, k);
        self.by_reduced = false;
        self.floor = solver.zero();
        Ok(())
    }

    /// Columns i and k of (K − xM)⁻¹, each up to a factor, into `left` and `right`; returns leftᵀ M right.
    /// `matrices` are those last set, and `k` is the excitation of the last query.
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
        if let Some(reduced) = &mut self.reduced
            && let Some(slope) = reduced.columns((i, k), x, left, right)
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
    /// Where rounding leaves the modal route in doubt, the pencil decides.
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
        self.form(matrices, i, k, query)?;
        if query.route == Route::Pencil {
            freq_hz.extend(self.pencil(matrices, i, k, query)?);
            return Ok(true);
        }
        if self.receptance.is_zero {
            return Ok(false);
        }
        let floor = self.floor;
        let ceiling = eigenvalue(query.f_max_hz);
        self.lambda.clear();
        let certain = secular::roots(
            &self.receptance,
            0.0,
            ceiling,
            &mut self.lambda,
            &mut self.scratch,
        );
        self.lambda.retain(|&x| x > floor);
        let certain = certain && self.place_roots(i);
        if !certain && let Ok(settled) = self.pencil(matrices, i, k, query) {
            freq_hz.extend(settled);
            return Ok(true);
        }
        if query.include_cancelled {
            let inside = |x: &&f64| **x > floor && **x <= ceiling;
            self.lambda
                .extend(self.receptance.cancelled.iter().filter(inside));
            self.lambda.sort_by(f64::total_cmp);
        }
        freq_hz.extend(self.lambda.iter().map(|&x| hertz(x)));
        Ok(true)
    }

    /// Compares what rounding of the series can move each root with its place, and mends what is too much on
    /// the matrices themselves. False where that cannot be done.
    fn place_roots(&mut self, i: usize) -> bool {
        for x in &mut self.lambda {
            let (noise, slope) = self.receptance.noise_and_slope(*x);
            let mut moved = noise / slope.abs();
            if let (Some(reduced), true) = (&mut self.reduced, self.by_reduced) {
                moved += reduced.pole_error(*x);
                if moved > POLISHED_ROOT * *x
                    && let Some(better) = reduced.polish(i, *x, 16.0 * moved)
                {
                    *x = better;
                    continue;
                }
            }
            // NaN counts as doubtful.
            if !(moved <= DOUBTFUL_ROOT * *x) {
                return false;
            }
        }
        self.lambda.sort_by(f64::total_cmp);
        true
    }

    /// Pencil route: antiresonances (Hz) of H_ik up to `f_max_hz`, ascending.
    fn pencil(
        &self,
        (k_mat, m_mat): (MatRef<'_, f64>, MatRef<'_, f64>),
        i: usize,
        k: usize,
        query: &Query,
    ) -> Result<Vec<f64>> {
        let (floor, ceiling) = (self.floor, eigenvalue(query.f_max_hz));
        let (k_ik, m_ik) = (deleted(k_mat, i, k), deleted(m_mat, i, k));
        let without = |gone: usize| {
            (0..k_mat.nrows())
                .filter(|&d| d != gone)
                .collect::<Vec<_>>()
        };
        let mut x = real_eigenvalues(
            k_ik.as_ref(),
            m_ik.as_ref(),
            (&without(i), &without(k)),
            (floor, ceiling),
        )?;
        if !query.include_cancelled {
            for &pole in self.receptance.cancelled.iter().filter(|&&l| l > floor) {
                let distance = |x: f64| (x - pole).abs();
                let nearest = (0..x.len())
                    .min_by(|&a, &b| distance(x[a]).total_cmp(&distance(x[b])))
                    .filter(|&at| distance(x[at]) <= SAME_ROOT * pole);
                if let Some(at) = nearest {
                    x.remove(at);
                }
            }
        }
        Ok(x.into_iter().map(hertz).collect())
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

/// The dense solution of the matrices last set, made when first asked for.
fn dense<'a>(
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

/// The matrix without row `i` and column `k`.
fn deleted(a: MatRef<'_, f64>, i: usize, k: usize) -> Mat<f64> {
    let n = a.nrows();
    Mat::from_fn(n - 1, n - 1, |r, c| {
        a[(r + usize::from(r >= i), c + usize::from(c >= k))]
    })
}
