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

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatRef, Par, Scale};

use super::small::{MOST_ROWS, SmallSymmetric};
use super::tolerances::{INFINITE_MODE, MASS_PIVOT_RATIO, zero_eigenvalue};
use crate::error::{Error, Result};

/// Solver of K φ = λ M φ for one size, with its working memory; reuse it between evaluations.
pub struct SymmetricSolver {
    n: usize,
    reduced: Mat<f64>,
    factor: Mat<f64>,
    rotated: Mat<f64>,
    inverse_root_mass: Vec<f64>,
    raw: Vec<f64>,
    memory: MemBuffer,
    small: SmallSymmetric,
    eigenvalues: Vec<f64>,
    vectors: Mat<f64>,
    /// Shift σ of the massless path, with the largest μ; none when M was reduced directly.
    shift: Option<(f64, f64)>,
    zero: f64,
}

/// Ulp of every entry of K, in φᵀ K φ, up to which λ is zero.
const RIGID_ULPS: f64 = 16.0;

/// Residual of an eigenpair, in n ulp of the largest eigenvalue, that the solver's own rounding explains.
const RESIDUAL_ULPS: f64 = 16.0;

/// Most rigid-body modes a structure has.
const RIGID_MODES: usize = 6;

impl SymmetricSolver {
    /// Reserves the memory for `n` degrees of freedom.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let requirement = StackReq::any_of(&[
            self_adjoint_evd_scratch::<f64>(
                n,
                ComputeEigenvectors::Yes,
                Par::Seq,
                Default::default(),
            ),
            cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()),
        ]);
        Self {
            n,
            reduced: Mat::zeros(n, n),
            factor: Mat::zeros(n, n),
            rotated: Mat::zeros(n, n),
            inverse_root_mass: vec![0.0; n],
            raw: vec![0.0; n],
            memory: MemBuffer::new(requirement),
            small: SmallSymmetric::default(),
            eigenvalues: Vec::with_capacity(n),
            vectors: Mat::zeros(n, n),
            shift: None,
            zero: 0.0,
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
        match self.shift {
            None => ulps * self.raw[self.n - 1].abs().max(self.raw[0].abs()),
            Some((sigma, largest_mu)) => ulps * largest_mu * (lambda + sigma).powi(2),
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

    /// For a well-conditioned diagonal M: `reduced` = M^(-1/2) K M^(-1/2).
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
        if least <= MASS_PIVOT_RATIO * most {
            return false;
        }
        for i in 0..self.n {
            self.inverse_root_mass[i] = m[(i, i)].sqrt().recip();
        }
        for j in 0..self.n {
            for i in j..self.n {
                self.reduced[(i, j)] =
                    k[(i, j)] * self.inverse_root_mass[i] * self.inverse_root_mass[j];
            }
        }
        true
    }

    fn finish_diagonal(&mut self) -> Result<()> {
        self.decompose()?;
        for j in 0..self.n {
            let rotated = self.rotated.col_as_slice(j).iter();
            let vector = self.vectors.col_as_slice_mut(j).iter_mut();
            for ((v, q), s) in vector.zip(rotated).zip(&self.inverse_root_mass) {
                *v = q * s;
            }
        }
        self.keep_all_eigenvalues();
        Ok(())
    }

    fn finish_regular(&mut self) -> Result<()> {
        self.decompose()?;
        self.unreduce();
        self.vectors.copy_from(&self.rotated);
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
        self.decompose()?;
        self.unreduce();
        let largest = self.raw[self.n - 1];
        let threshold = INFINITE_MODE * self.n as f64 * largest;
        if self.raw[0] < -1e3 * threshold {
            return Err(Error::Numerical {
                what: "modes of (K, M)".into(),
                detail: format!(
                    "the mass matrix is indefinite: the pair has the eigenvalue {:e} relative to {largest:e}",
                    self.raw[0]
                ),
            });
        }
        self.shift = Some((sigma, largest));
        // μ descending is λ ascending; the massless directions (smallest μ) go last.
        self.eigenvalues.clear();
        for j in 0..self.n {
            let source = self.n - 1 - j;
            let mu = self.raw[source];
            let finite = mu > threshold;
            let scale = if finite { mu.sqrt().recip() } else { 1.0 };
            for i in 0..self.n {
                self.vectors[(i, j)] = self.rotated[(i, source)] * scale;
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
        let largest = self.raw.iter().fold(0.0_f64, |a, l| a.max(l.abs()));
        self.zero = zero_eigenvalue(self.n, largest);
        self.eigenvalues.clear();
        self.eigenvalues.extend_from_slice(&self.raw);
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

    /// `reduced` = L⁻¹ A L⁻ᵀ for symmetric A.
    fn reduce(&mut self, a: MatRef<'_, f64>) {
        self.reduced.copy_from(a);
        solve_lower_triangular_in_place(self.factor.as_ref(), self.reduced.as_mut(), Par::Seq);
        self.rotated.copy_from(self.reduced.transpose());
        solve_lower_triangular_in_place(self.factor.as_ref(), self.rotated.as_mut(), Par::Seq);
        self.reduced.copy_from(&self.rotated);
    }

    /// `rotated` = L⁻ᵀ `rotated`.
    fn unreduce(&mut self) {
        solve_upper_triangular_in_place(
            self.factor.as_ref().transpose(),
            self.rotated.as_mut(),
            Par::Seq,
        );
    }

    /// `reduced` = `rotated` diag(`raw`) `rotated`ᵀ.
    fn decompose(&mut self) -> Result<()> {
        if self.n <= MOST_ROWS && self.small.solve(self.n, |i, j| self.reduced[(i, j)]) {
            for j in 0..self.n {
                let (value, vector) = self.small.pair(j);
                self.raw[j] = value;
                self.rotated.col_as_slice_mut(j).copy_from_slice(vector);
            }
            return Ok(());
        }
        let unit = self.unit();
        self.reduced *= Scale(unit.recip());
        self_adjoint_evd(
            self.reduced.as_ref(),
            faer::diag::DiagMut::from_slice_mut(&mut self.raw),
            Some(self.rotated.as_mut()),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .map_err(|_| not_converged())?;
        self.check()?;
        self.raw.iter_mut().for_each(|value| *value *= unit);
        Ok(())
    }

    /// The power of two that brings the largest entry of `reduced` near one.
    ///
    /// faer 0.24 deflates at absolute thresholds: of matrices far from one it loses digits, or returns one
    /// value twice and leaves out its neighbour.
    fn unit(&self) -> f64 {
        let largest = (0..self.n).fold(0.0_f64, |l, j| l.max(self.reduced[(j, j)].abs()));
        if largest > 0.0 && largest.is_finite() {
            largest.log2().round().exp2()
        } else {
            1.0
        }
    }

    /// Looks at every pair of a decomposition: values by Rayleigh's quotient, residuals by their norm, since
    /// the solver can return without having converged.
    fn check(&mut self) -> Result<()> {
        let n = self.n;
        // The solver reads the lower triangle only.
        for j in 0..n {
            for i in 0..j {
                self.reduced[(i, j)] = self.reduced[(j, i)];
            }
        }
        let mut image = Mat::<f64>::zeros(n, n);
        matmul(
            image.as_mut(),
            Accum::Replace,
            self.reduced.as_ref(),
            self.rotated.as_ref(),
            1.0,
            Par::Seq,
        );
        let mut worst = 0.0_f64;
        for j in 0..n {
            let (q, aq) = (self.rotated.col_as_slice(j), image.col_as_slice(j));
            let value: f64 = q.iter().zip(aq).map(|(q, a)| q * a).sum();
            let residual: f64 = q.iter().zip(aq).map(|(q, a)| (a - value * q).powi(2)).sum();
            self.raw[j] = value;
            worst = worst.max(residual.sqrt());
        }
        let largest = self.raw.iter().fold(0.0_f64, |l, v| l.max(v.abs()));
        // NaN fails too.
        if !(worst <= RESIDUAL_ULPS * n as f64 * f64::EPSILON * largest) {
            return Err(not_converged());
        }
        if !self.raw.is_sorted() {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&a, &b| self.raw[a].total_cmp(&self.raw[b]));
            let (raw, rotated) = (self.raw.clone(), self.rotated.clone());
            for (j, &from) in order.iter().enumerate() {
                self.raw[j] = raw[from];
                let column = self.rotated.col_as_slice_mut(j);
                column.copy_from_slice(rotated.col_as_slice(from));
            }
        }
        Ok(())
    }
}

fn not_converged() -> Error {
    Error::Numerical {
        what: "symmetric eigenproblem".into(),
        detail: "the iteration did not converge; check K and M for extreme values".into(),
    }
}
