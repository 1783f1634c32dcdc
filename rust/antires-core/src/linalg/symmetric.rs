//! K φ = λ M φ with K, M symmetric and M positive semi-definite.
//!
//! Two reductions to a standard symmetric problem, chosen by M and K:
//!
//! - M diagonal and well-conditioned, or K indefinite: M = L Lᵀ, L⁻¹ K L⁻ᵀ q = λ q, φ = L⁻ᵀ q. A diagonal
//!   M needs no factor. The error of every λ is some ulp of the largest, times the condition of M: of a
//!   frame with consistent masses (largest λ 4e11) the rigid-body modes came out at 13 instead of 0.
//! - Otherwise, with σ > 0 and K + σM = L Lᵀ, L⁻¹ M L⁻ᵀ q = μ q, λ = 1/μ − σ, φ = L⁻ᵀ q / √μ: the error
//!   of λ is some ulp of (λ + σ)²/σ, so the low modes keep their digits. The directions with μ = 0 carry no
//!   mass (M may be singular); they have no finite λ but add a constant Σ ψψᵀ, ψ = L⁻ᵀ q, to the receptance:
//!
//! ```text
//! (K − xM)⁻¹ = Σ_finite φ φᵀ / (λ − x) + Σ_infinite ψ ψᵀ
//! ```
//!
//! Conventions: λ ascending, φᵀ M φ = 1, columns are modes. |λ| below [`SymmetricSolver::zero`], what
//! rounding makes of a rigid-body mode, is returned as exactly 0.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., section 8.7.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, MatRef, Par};

use super::balance::Balance;
use super::standard::StandardSymmetric;
use super::tolerances::{INFINITE_MODE, MASS_PIVOT_RATIO, zero_eigenvalue};
use crate::error::{Error, Result};

/// Solver of K φ = λ M φ for one size, with its working memory; reuse it between evaluations.
pub struct SymmetricSolver {
    n: usize,
    standard: StandardSymmetric,
    factor: Mat<f64>,
    work: Mat<f64>,
    inverse_root_mass: Vec<f64>,
    memory: MemBuffer,
    eigenvalues: Vec<f64>,
    vectors: Mat<f64>,
    /// Shift σ of the massless path, with the largest μ; none when M was reduced directly.
    shift: Option<(f64, f64)>,
    zero: f64,
    /// How the matrices were scaled; none where they were not.
    balance: Option<Balance>,
}

/// Ulp of every entry of K, in φᵀ K φ, up to which λ is zero.
const RIGID_ULPS: f64 = 16.0;

/// Most rigid-body modes a structure has.
const RIGID_MODES: usize = 6;

impl SymmetricSolver {
    /// Reserves the memory for `n` degrees of freedom.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let memory = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        Self {
            n,
            standard: StandardSymmetric::new(n),
            factor: Mat::zeros(n, n),
            work: Mat::zeros(n, n),
            inverse_root_mass: vec![0.0; n],
            memory: MemBuffer::new(memory),
            eigenvalues: Vec::with_capacity(n),
            vectors: Mat::zeros(n, n),
            shift: None,
            zero: 0.0,
            balance: None,
        }
    }

    /// Eigenvalues below this are zero at working precision.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Absolute uncertainty of an eigenvalue near `lambda`: n ulp of what was decomposed.
    #[must_use]
    pub fn uncertainty(&self, lambda: f64) -> f64 {
        let ulps = self.n as f64 * f64::EPSILON;
        let units = self.balance.as_ref().map_or(1.0, |b| b.eigenvalue(1.0));
        match self.shift {
            None => {
                let (first, last) = (
                    self.standard.values()[0],
                    self.standard.values()[self.n - 1],
                );
                ulps * units * last.abs().max(first.abs())
            }
            Some((sigma, largest_mu)) => {
                ulps * units * largest_mu * (lambda / units + sigma).powi(2)
            }
        }
    }

    /// Finite eigenvalues λ of the last [`solve`](Self::solve), ascending.
    #[must_use]
    pub fn eigenvalues(&self) -> &[f64] {
        &self.eigenvalues
    }

    /// Vectors of the last [`solve`](Self::solve): the mass-normalised φ in the order of
    /// [`eigenvalues`](Self::eigenvalues), then the massless ψ.
    #[must_use]
    pub fn vectors(&self) -> MatRef<'_, f64> {
        self.vectors.as_ref()
    }

    /// Solves for all modes.
    ///
    /// # Errors
    /// [`Error::Numerical`] when K and M share a null vector (a dof with neither stiffness nor mass),
    /// when M is indefinite, or when the eigensolver does not converge.
    pub fn solve(&mut self, stiffness: MatRef<'_, f64>, mass: MatRef<'_, f64>) -> Result<()> {
        self.balance = Balance::of(self.n, |j| (stiffness[(j, j)], mass[(j, j)]));
        let Some(balance) = self.balance.take() else {
            return self.solve_as_given(stiffness, mass);
        };
        let (k, m) = (
            Mat::from_fn(self.n, self.n, |i, j| {
                balance.stiffness_entry(i, j, stiffness[(i, j)])
            }),
            Mat::from_fn(self.n, self.n, |i, j| {
                balance.mass_entry(i, j, mass[(i, j)])
            }),
        );
        self.solve_as_given(k.as_ref(), m.as_ref())?;
        for value in &mut self.eigenvalues {
            *value = balance.eigenvalue(*value);
        }
        self.zero = balance.eigenvalue(self.zero);
        let finite = self.eigenvalues.len();
        for j in 0..self.n {
            for dof in 0..self.n {
                let entry = &mut self.vectors[(dof, j)];
                *entry = if j < finite {
                    balance.shape(dof, *entry)
                } else {
                    balance.massless_shape(dof, *entry)
                };
            }
        }
        self.balance = Some(balance);
        Ok(())
    }

    fn solve_as_given(&mut self, stiffness: MatRef<'_, f64>, mass: MatRef<'_, f64>) -> Result<()> {
        self.shift = None;
        if self.scale_by_diagonal_mass(stiffness, mass) {
            return self.finish_diagonal();
        }
        let shifted = self.solve_shifted(stiffness, mass);
        if shifted.is_err() && self.factorize(mass) && self.pivot_ratio() >= MASS_PIVOT_RATIO {
            self.reduce(stiffness);
            return self.finish_regular();
        }
        shifted
    }

    /// For a well-conditioned diagonal M, no dof so much stiffer for its mass than others that it would take their
    /// digits: the standard problem of M^(-1/2) K M^(-1/2).
    fn scale_by_diagonal_mass(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) -> bool {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for j in 0..self.n {
            for i in 0..j {
                if m[(i, j)] != 0.0 {
                    return false;
                }
            }
            least = least.min(m[(j, j)]);
            most = most.max(m[(j, j)]);
        }
        let rates = || (0..self.n).map(|j| k[(j, j)] / m[(j, j)]);
        let (slowest, fastest) = rates()
            .filter(|rate| *rate > 0.0)
            .fold((f64::INFINITY, 0.0_f64), |(lo, hi), r| {
                (lo.min(r), hi.max(r))
            });
        if least <= MASS_PIVOT_RATIO * most || slowest <= MASS_PIVOT_RATIO * fastest {
            return false;
        }
        for i in 0..self.n {
            self.inverse_root_mass[i] = m[(i, i)].sqrt().recip();
        }
        for j in 0..self.n {
            for i in j..self.n {
                self.standard.matrix_mut()[(i, j)] =
                    k[(i, j)] * self.inverse_root_mass[i] * self.inverse_root_mass[j];
            }
        }
        true
    }

    fn finish_diagonal(&mut self) -> Result<()> {
        self.standard.decompose()?;
        for j in 0..self.n {
            let rotated = self.standard.vectors().col_as_slice(j).iter();
            let vector = self.vectors.col_as_slice_mut(j).iter_mut();
            for ((v, q), s) in vector.zip(rotated).zip(&self.inverse_root_mass) {
                *v = q * s;
            }
        }
        self.keep_all_eigenvalues();
        Ok(())
    }

    fn finish_regular(&mut self) -> Result<()> {
        self.standard.decompose()?;
        self.unreduce();
        self.vectors.copy_from(self.standard.vectors());
        self.keep_all_eigenvalues();
        Ok(())
    }

    /// The massless path: M q = μ (K + σM) q.
    fn solve_shifted(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) -> Result<()> {
        let trace = |a: MatRef<'_, f64>| (0..self.n).map(|i| a[(i, i)]).sum::<f64>();
        let (trace_k, trace_m) = (trace(k), trace(m));
        let sigma = if trace_m > 0.0 && trace_k > 0.0 {
            1e-3 * trace_k / trace_m
        } else {
            1.0
        };
        let shifted = Mat::from_fn(self.n, self.n, |i, j| k[(i, j)] + sigma * m[(i, j)]);
        if !self.factorize(shifted.as_ref()) || self.pivot_ratio() < 1e-14 {
            return Err(Error::Numerical {
                what: "modes of (K, M)".into(),
                detail: "M is singular and K + sigma M is not positive definite: some motion has neither \
                         mass nor stiffness, or a matrix is indefinite. Remove or constrain that dof."
                    .into(),
            });
        }
        self.reduce(m);
        self.standard.decompose()?;
        self.unreduce();
        let largest = self.standard.values()[self.n - 1];
        let threshold = INFINITE_MODE * self.n as f64 * largest;
        if self.standard.values()[0] < -1e3 * threshold {
            return Err(Error::Numerical {
                what: "modes of (K, M)".into(),
                detail: format!(
                    "the mass matrix is indefinite: the pair has the eigenvalue {:e} relative to {largest:e}",
                    self.standard.values()[0]
                ),
            });
        }
        self.shift = Some((sigma, largest));
        // μ descending is λ ascending; the massless directions (smallest μ) go last.
        self.eigenvalues.clear();
        for j in 0..self.n {
            let source = self.n - 1 - j;
            let mu = self.standard.values()[source];
            let finite = mu > threshold;
            let scale = if finite { mu.sqrt().recip() } else { 1.0 };
            for i in 0..self.n {
                self.vectors[(i, j)] = self.standard.vectors()[(i, source)] * scale;
            }
            if finite {
                self.eigenvalues.push(mu.recip() - sigma);
            }
        }
        // The digits of λ near zero are those of σ, and of K itself, not of the largest λ.
        let lowest = 0..self.eigenvalues.len().min(RIGID_MODES);
        self.zero = lowest
            .map(|j| RIGID_ULPS * f64::EPSILON * self.absolute_form(k, j))
            .fold(zero_eigenvalue(self.n, sigma), f64::max);
        self.clear_zeros();
        Ok(())
    }

    /// Σ |φ_i| |K_ij| |φ_j| of mode `j`: how far one ulp in each entry can move φᵀ K φ, over ulp.
    fn absolute_form(&self, k: MatRef<'_, f64>, j: usize) -> f64 {
        let phi = self.vectors.col(j);
        (0..self.n)
            .map(|c| {
                let column: f64 = (0..self.n).map(|r| (k[(r, c)] * phi[r]).abs()).sum();
                phi[c].abs() * column
            })
            .sum()
    }

    fn clear_zeros(&mut self) {
        for l in &mut self.eigenvalues {
            if l.abs() <= self.zero {
                *l = 0.0;
            }
        }
    }

    fn keep_all_eigenvalues(&mut self) {
        let largest = self
            .standard
            .values()
            .iter()
            .fold(0.0_f64, |a, l| a.max(l.abs()));
        self.zero = zero_eigenvalue(self.n, largest);
        self.eigenvalues.clear();
        self.eigenvalues.extend_from_slice(self.standard.values());
        self.clear_zeros();
    }

    /// `factor` = L of the given matrix; false when it is not positive definite.
    fn factorize(&mut self, a: MatRef<'_, f64>) -> bool {
        self.factor.copy_from(a);
        cholesky_in_place(
            self.factor.as_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .is_ok()
    }

    /// Smallest over largest squared pivot of `factor`.
    fn pivot_ratio(&self) -> f64 {
        let (least, most) = (0..self.n)
            .map(|i| self.factor[(i, i)])
            .fold((f64::INFINITY, 0.0_f64), |(lo, hi), p| {
                (lo.min(p), hi.max(p))
            });
        (least / most).powi(2)
    }

    /// Takes L⁻¹ A L⁻ᵀ for symmetric A to the standard problem.
    fn reduce(&mut self, a: MatRef<'_, f64>) {
        let (reduced, factor) = (self.standard.matrix_mut(), self.factor.as_ref());
        reduced.copy_from(a);
        solve_lower_triangular_in_place(factor, reduced.as_mut(), Par::Seq);
        self.work.copy_from(reduced.transpose());
        solve_lower_triangular_in_place(factor, self.work.as_mut(), Par::Seq);
        reduced.copy_from(&self.work);
    }

    /// Q ← L⁻ᵀ Q.
    fn unreduce(&mut self) {
        solve_upper_triangular_in_place(
            self.factor.as_ref().transpose(),
            self.standard.vectors_mut().as_mut(),
            Par::Seq,
        );
    }
}
