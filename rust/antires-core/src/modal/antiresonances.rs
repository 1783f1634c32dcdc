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

use faer::{Mat, MatRef};

use super::modes::{eigenvalue, hertz};
use super::receptance::Receptance;
use super::secular;
use crate::error::Result;
use crate::fem::model::{Model, connected};
use crate::linalg::pencil::real_eigenvalues;
use crate::linalg::symmetric::SymmetricSolver;

/// Relative distance within which a pencil root is the cancelled one expected at a pole.
const SAME_ROOT: f64 = 1e-6;

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

/// Solver with its working memory; one symmetric eigenproblem serves every response.
pub struct AntiresonanceSolver {
    modes: SymmetricSolver,
    receptance: Receptance,
    lambda: Vec<f64>,
    scratch: Vec<f64>,
}

impl AntiresonanceSolver {
    /// Reserves the memory for `n` degrees of freedom.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            modes: SymmetricSolver::new(n),
            receptance: Receptance::default(),
            lambda: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Solves the symmetric eigenproblem that the following queries share.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn set_matrices(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) -> Result<()> {
        self.modes.solve(k, m)
    }

    /// The modes of the matrices last set.
    #[must_use]
    pub fn modes(&self) -> &SymmetricSolver {
        &self.modes
    }

    /// Antiresonances (Hz) of H_ik up to the limit of the query, appended to `freq_hz`; `matrices` are
    /// those last set. Returns false when H_ik is identically zero at working precision.
    ///
    /// Where rounding leaves the modal route in doubt, the pencil decides.
    ///
    /// # Errors
    /// Those of the pencil, if that is the route asked for.
    pub fn find(
        &mut self,
        matrices: (MatRef<'_, f64>, MatRef<'_, f64>),
        i: usize,
        k: usize,
        query: &Query,
        freq_hz: &mut Vec<f64>,
    ) -> Result<bool> {
        self.receptance.form(&self.modes, i, k);
        if query.route == Route::Pencil {
            freq_hz.extend(self.pencil(matrices, i, k, query)?);
            return Ok(true);
        }
        if self.receptance.is_zero {
            return Ok(false);
        }
        let floor = self.zero_root();
        let ceiling = eigenvalue(query.f_max_hz);
        self.lambda.clear();
        let certain = secular::roots(
            &self.receptance,
            0.0,
            ceiling,
            &mut self.lambda,
            &mut self.scratch,
        );
        if !certain && let Ok(settled) = self.pencil(matrices, i, k, query) {
            freq_hz.extend(settled);
            return Ok(true);
        }
        self.lambda.retain(|&x| x > floor);
        if query.include_cancelled {
            let inside = |x: &&f64| **x > floor && **x <= ceiling;
            self.lambda
                .extend(self.receptance.cancelled.iter().filter(inside));
            self.lambda.sort_by(f64::total_cmp);
        }
        freq_hz.extend(self.lambda.iter().map(|&x| hertz(x)));
        Ok(true)
    }

    /// Pencil route: antiresonances (Hz) of H_ik up to `f_max_hz`, ascending.
    fn pencil(
        &self,
        (k_mat, m_mat): (MatRef<'_, f64>, MatRef<'_, f64>),
        i: usize,
        k: usize,
        query: &Query,
    ) -> Result<Vec<f64>> {
        let (floor, ceiling) = (self.zero_root(), eigenvalue(query.f_max_hz));
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

    /// Roots below this are zero at working precision.
    fn zero_root(&self) -> f64 {
        16.0 * self.modes.uncertainty(0.0)
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
    let mut solver = AntiresonanceSolver::new(model.n_dof());
    solver.set_matrices(k_mat, m_mat)?;
    let mut out = Vec::with_capacity(responses.len());
    for &i in responses {
        let mut found = Antiresonances::default();
        found.identically_zero = !connected(k_mat, m_mat, i, excitation)
            || !solver.find((k_mat, m_mat), i, excitation, query, &mut found.freq_hz)?;
        out.push(found);
    }
    Ok(out)
}

/// The matrix without row `i` and column `k`.
fn deleted(a: MatRef<'_, f64>, i: usize, k: usize) -> Mat<f64> {
    let n = a.nrows();
    Mat::from_fn(n - 1, n - 1, |r, c| {
        a[(r + usize::from(r >= i), c + usize::from(c >= k))]
    })
}
