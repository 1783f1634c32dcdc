//! The solver: K and M handed over once, then the antiresonances of as many responses as are asked for.
//!
//! ```text
//! let mut prepared = solver.prepare(K, M);       one evaluation
//! prepared.find(&ends, &query, &mut freq_hz)     every response
//! prepared.columns(&ends, x, ...)                sensitivities of the roots
//! ```
//!
//! # pencil_route
//!
//! The roots of the deleted pencil, joined with those that the modal series proves.
//!
//! QZ answers for the norm of the matrices. What one series isolated by a change of sign stands on its own and
//! is never taken away by it: each proven root, and each root that cancels against a pole, takes the root of the
//! pencil next to it for its own. Those of the pencil that remain are
//!
//! - kept, if QZ knows them well,
//! - placed on the matrices ([`crate::antiresonances::placement`]), if it does not; kept where that ends at a root that none has yet;
//! - dropped, if neither QZ nor the matrices can tell them from zero, infinity or a complex pair; of one that does
//!   not even solve the pencil it is said that QZ failed.

use std::sync::Arc;

use super::placement::place;
use super::search::{DOUBTFUL_ROOT, Found, Memory, REACH, Search};
use super::secular::Certainty;
use crate::error::{Error, Result};
use crate::linalg::pencil::{PencilRoot, ROOT_UNCERTAINTY, UNCERTAIN, real_eigenvalues, refused};
use crate::linalg::sparse::SparseMatrix;
use crate::modal::columns::{modal_columns, of_minor, on_pole};
use crate::modal::minor::{Ends, MinorSeries};
use crate::modal::modes::{eigenvalue, hertz};
use crate::modal::solved::{Solutions, Solved};
use crate::modal::structure::{MOST_DENSE, Structure};

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
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self { solutions: Solutions::new(structure), memory: Memory::default() }
    }

    /// Takes K and M.
    pub fn prepare<'a>(&'a mut self, stiffness: &'a SparseMatrix, mass: &'a SparseMatrix) -> Prepared<'a> {
        Prepared { solved: self.solutions.of(stiffness, mass), memory: &mut self.memory, doubtful: false }
    }
}

/// K and M with what was solved of them: one eigenproblem serves every response.
pub struct Prepared<'a> {
    solved: Solved<'a>,
    memory: &'a mut Memory,
    doubtful: bool,
}

impl Prepared<'_> {
    /// Antiresonances (Hz) of H_ik, or of a minor, up to the limit of the query, appended to `freq_hz`.
    ///
    /// Where rounding leaves the modal route in doubt, the roots of the pencil join those that are proven.
    pub fn find(&mut self, ends: &Ends, query: &Query, freq_hz: &mut Vec<f64>) -> Result<Transfer> {
        let ceiling = eigenvalue(query.f_max_hz);
        // The pencil has the roots of all parts of the structure, of those too that the force does not move.
        let for_pencil = query.include_cancelled || query.route == Route::Pencil;
        let mut certainty = self.search(ends, for_pencil, ceiling)?;
        if certainty == Certainty::Doubtful && !for_pencil && self.solved.may_be_dense() {
            certainty = self.search(ends, true, ceiling)?;
        }
        if query.route == Route::Modal && self.memory.receptance.is_zero {
            return Ok(Transfer::IdenticallyZero);
        }
        let found = &mut self.memory.found;
        found.drop_cancelled_zeros();
        self.doubtful = certainty == Certainty::Doubtful && !self.solved.may_be_dense();
        if self.doubtful {
            found.settle_open();
        } else if query.route == Route::Pencil || certainty == Certainty::Doubtful {
            match join(&mut self.solved, ends, ceiling, found) {
                Err(error) if query.route == Route::Pencil => return Err(error),
                Err(_) => {
                    found.settle_open();
                    self.doubtful = true;
                }
                Ok(()) => {}
            }
        }
        if query.include_cancelled {
            found.include_cancelled();
        }
        freq_hz.extend(found.sorted().iter().map(|&x| hertz(x)));
        Ok(Transfer::Present)
    }

    fn search(&mut self, ends: &Ends, whole: bool, ceiling: f64) -> Result<Certainty> {
        Search { whole, solved: &mut self.solved, ends: *ends, memory: self.memory }.run(ceiling)
    }

    /// Whether rounding leaves a doubt about the number of roots last found: of structures too large for the
    /// pencil, or where QZ fails.
    pub fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// How far (Hz) a root at `freq_hz` may be from that of the matrices, by factors of K − xM; infinite where those
    /// do not tell.
    pub fn bound(&mut self, ends: &Ends, freq_hz: f64) -> f64 {
        let x = eigenvalue(freq_hz);
        let ulps = FACTOR_ULPS + (self.solved.n_dof() as f64).sqrt();
        let error = match self.solved.reduced().receptance_at(ends, x) {
            Some(here) => (here.value / here.slope).abs() + ulps * here.ulp,
            None => f64::INFINITY,
        };
        if error <= UNCERTAIN * x { freq_hz - hertz(x - error) } else { f64::INFINITY }
    }

    /// Those of the response last found that cancel against a pole (Hz), appended to `freq_hz`.
    pub fn cancelled(&mut self, freq_hz: &mut Vec<f64>) {
        freq_hz.extend(self.memory.found.cancelled().map(hertz));
    }

    /// Eigenvalues of the whole structure, ascending.
    pub fn eigenvalues(&mut self) -> Result<&[f64]> {
        Ok(&self.solved.dense()?.eigenvalues)
    }

    /// Null vectors of the deleted pencil at a root `x` that cancels against a pole, into `left` and `right`;
    /// returns leftᵀ M right.
    pub fn vectors_on_pole(
        &mut self,
        ends: &Ends,
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Result<f64> {
        match ends.pair() {
            Some(pair) => Ok(on_pole(self.solved.dense()?, pair, x, left, right)),
            None => self.of_minor(ends, x, (left, right)),
        }
    }

    fn of_minor(&mut self, ends: &Ends, x: f64, vectors: (&mut Vec<f64>, &mut Vec<f64>)) -> Result<f64> {
        let solver = self.solved.dense()?;
        let mut series = MinorSeries::default();
        series.of_all_modes(solver, ends);
        Ok(of_minor(solver, &series, ends, x, vectors))
    }

    /// Columns i and k of (K − xM)⁻¹, each up to a factor, into `left` and `right`, or of a minor the null vectors of the
    /// deleted pencil; returns leftᵀ M right.
    pub fn columns(&mut self, ends: &Ends, x: f64, left: &mut Vec<f64>, right: &mut Vec<f64>) -> Result<f64> {
        if self.solved.is_reducible()
            && let Some(slope) = self.solved.reduced().columns(ends, x, left, right)
        {
            return Ok(slope);
        }
        match ends.pair() {
            Some(pair) => Ok(modal_columns(self.solved.dense()?, pair, x, left, right)),
            None => self.of_minor(ends, x, (left, right)),
        }
    }
}

// ---- query

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

impl Query {
    /// Refuses what no memory and patience serve: all roots of a large model cost n² memory and n³ time, and QZ 25
    /// times that.
    pub fn check_large(&self, n: usize) -> Result<()> {
        if self.route == Route::Pencil {
            return Err(Error::input(
                "method",
                format!("'pencil' for {n} dofs"),
                format!("at most {MOST_DENSE} dofs for QZ, whose time grows with their cube"),
            )
            .remedy("Leave it out: 'modal' proves its roots."));
        }
        if self.f_max_hz.is_infinite() {
            return Err(Error::input(
                "f_max_hz",
                format!("no limit for {n} dofs"),
                format!("a limit in Hz for more than {MOST_DENSE} dofs: all roots need all modes"),
            )
            .remedy("Give the highest frequency that matters; time and memory go with the modes below it."));
        }
        Ok(())
    }
}

/// Antiresonances of one response.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Antiresonances {
    /// Frequencies (Hz), ascending.
    pub freq_hz: Vec<f64>,
    /// How far each may be from that of the matrices as given, infinite for one that is not certain; empty if it
    /// was not asked for.
    pub error_hz: Vec<f64>,
    /// True when H_ik is identically zero: response and excitation are not connected.
    pub identically_zero: bool,
    /// True when rounding leaves a doubt about their number that only the dense solvers could settle.
    pub doubtful: bool,
}

/// Whether there is anything to be zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transfer {
    /// H_ik is not zero everywhere.
    Present,
    /// H_ik is identically zero at working precision.
    IdenticallyZero,
}

// ---- pencil_route

/// Relative distance within which a root of the pencil is that of a proven one, or of the cancelled one expected
/// at a pole.
const SAME_ROOT: f64 = 1e-6;

/// Adds the roots of the pencil up to `ceiling` to those found.
pub(super) fn join(solved: &mut Solved<'_>, ends: &Ends, ceiling: f64, found: &mut Found) -> Result<()> {
    let range = (found.floor, ceiling);
    let mut pencil = pencil_roots((solved.stiffness, solved.mass), ends, range)?;
    found.claim(|x| take_nearest(&mut pencil, x).map(|root| root.x));
    for root in pencil {
        if root.certain && (root.repeated || root.uncertainty <= DOUBTFUL_ROOT) {
            found.proven.push(root.x);
            continue;
        }
        let reach = REACH * root.uncertainty * root.x;
        match place(solved, ends, root.x, reach) {
            Some(placed) => {
                if !found.has(placed) && placed.x <= ceiling {
                    found.proven.push(placed.x);
                }
            }
            None => match root.backward_error {
                Some(error) => return Err(refused(root.x, error)),
                None if root.certain => found.proven.push(root.x),
                None => {}
            },
        }
    }
    Ok(())
}

/// The roots of the deleted pencil between two limits by QZ, well known or not.
pub(super) fn pencil_roots(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    ends: &Ends,
    range: (f64, f64),
) -> Result<Vec<PencilRoot>> {
    let (i, k) = (ends.responses(), ends.forces());
    let without = |gone: &[usize]| -> Vec<usize> { (0..k_mat.n()).filter(|d| !gone.contains(d)).collect() };
    let (a, b) = (k_mat.deleted(i, k), m_mat.deleted(i, k));
    real_eigenvalues(a.as_ref(), b.as_ref(), (&without(i), &without(k)), range)
}

/// Takes the root nearest to `x` out of the list, if it can be the same.
fn take_nearest(roots: &mut Vec<PencilRoot>, x: f64) -> Option<PencilRoot> {
    let distance = |r: &PencilRoot| (r.x - x).abs();
    let at = (0..roots.len()).min_by(|&a, &b| distance(&roots[a]).total_cmp(&distance(&roots[b])))?;
    let reach = roots[at].uncertainty.clamp(SAME_ROOT, ROOT_UNCERTAINTY);
    (distance(&roots[at]) <= reach * x).then(|| roots.remove(at))
}
