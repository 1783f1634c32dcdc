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
//! Dofs whose row of M is zero are condensed first, which is exact, whatever their springs beside those of the masses.
//!
//! Conventions: λ ascending, φᵀ M φ = 1, columns are modes. |λ| below [`SymmetricSolver::zero`], what
//! rounding makes of a rigid-body mode, is returned as exactly 0.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., section 8.7.
//!
//! # standard
//!
//! The standard problem A q = μ q, A symmetric: every pair verified.
//!
//! Up to 32 rows go to [`SmallSymmetric`], larger matrices to faer.
//!
//! # small
//!
//! A = V Λ Vᵀ of a small symmetric matrix: Householder's reduction to a tridiagonal one, then QL.
//!
//! Up to some dozens of rows this is several times faster than a blocked solver; a matrix that is tridiagonal
//! already, as of a chain, goes straight to QL.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 8.3.1 and 8.3.3.
//!
//! # tridiagonal
//!
//! Eigenvalues and eigenvectors of a small symmetric tridiagonal matrix, by the implicit QL iteration.
//!
//! Plane rotations chase the bulge of a Wilkinson-shifted QL step from the bottom of each unreduced block
//! to its top; they are applied to the columns of `vectors` as they come.
//!
//! Reference: Parlett, The Symmetric Eigenvalue Problem (1998), ch. 8.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, Mat, MatRef, Par, Scale};

use super::balance::Balance;
use super::wide::widest;
use crate::error::{Error, Result};

/// A Cholesky pivot ratio of M below this sends the symmetric problem down the shifted path:
/// reduction by a worse-conditioned M would cost more than half of the digits.
const MASS_PIVOT_RATIO: f64 = 1e-8;

/// An eigenvalue of (M, K + σM) below `n` times this, relative to the largest, is an infinite mode.
const INFINITE_MODE: f64 = 4.0 * f64::EPSILON;

/// Solver of K φ = λ M φ for one size, with its working memory; reuse it between evaluations.
pub struct SymmetricSolver {
    n: usize,
    standard: StandardSymmetric,
    factor: Mat<f64>,
    work: Mat<f64>,
    inverse_root_mass: Vec<f64>,
    memory: MemBuffer,
    /// Finite eigenvalues λ of the last [`solve`](Self::solve), ascending.
    pub eigenvalues: Vec<f64>,
    /// The mass-normalised φ in the order of the eigenvalues, then the massless ψ.
    pub vectors: Mat<f64>,
    /// Shift σ of the massless path, with the largest μ; none when M was reduced directly.
    shift: Option<(f64, f64)>,
    /// Eigenvalues below this are zero at working precision.
    pub zero: f64,
    /// How the matrices were scaled; none where they were not.
    balance: Option<Balance>,
    /// That of the dofs with mass, where those without were condensed.
    condensed: Option<Box<SymmetricSolver>>,
}

/// Ulp of every entry of K, in φᵀ K φ, up to which λ is zero.
const RIGID_ULPS: f64 = 16.0;

/// Most rigid-body modes a structure has.
const RIGID_MODES: usize = 6;

impl SymmetricSolver {
    /// Reserves the memory for `n` degrees of freedom.
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
            condensed: None,
        }
    }

    /// Absolute uncertainty of an eigenvalue near `lambda`: n ulp of what was decomposed.
    pub fn uncertainty(&self, lambda: f64) -> f64 {
        let ulps = self.n as f64 * f64::EPSILON;
        let units = self.units();
        if let Some(of_masses) = &self.condensed {
            return units * of_masses.uncertainty(lambda / units);
        }
        match self.shift {
            None => {
                let (first, last) = (self.standard.values[0], self.standard.values[self.n - 1]);
                ulps * units * last.abs().max(first.abs())
            }
            Some((sigma, largest_mu)) => ulps * units * largest_mu * (lambda / units + sigma).powi(2),
        }
    }

    fn units(&self) -> f64 {
        self.balance.as_ref().map_or(1.0, |b| b.eigenvalue(1.0))
    }

    /// The size Σ ψ_i ψ_k is rounded at: √(g_i g_k), g the diagonal of Σ ψψᵀ, or of (K + σM)⁻¹ where σ mixes them
    /// with the modes.
    pub fn static_size(&self, i: usize, k: usize) -> f64 {
        let shift = self.shift.map_or(f64::INFINITY, |(sigma, _)| self.units() * sigma);
        let stretch = |r: usize| self.eigenvalues.get(r).map_or(1.0, |l| (l + shift).recip());
        let size = |dof: usize| (0..self.n).map(|r| self.vectors[(dof, r)].powi(2) * stretch(r)).sum::<f64>();
        (size(i) * size(k)).sqrt()
    }

    /// Solves for all modes.
    pub fn solve(&mut self, stiffness: MatRef<'_, f64>, mass: MatRef<'_, f64>) -> Result<()> {
        self.balance = Balance::of(self.n, |j| (stiffness[(j, j)], mass[(j, j)]));
        let Some(balance) = self.balance.take() else {
            return self.solve_as_given(stiffness, mass);
        };
        let (k, m) = (
            Mat::from_fn(self.n, self.n, |i, j| balance.stiffness_entry(i, j, stiffness[(i, j)])),
            Mat::from_fn(self.n, self.n, |i, j| balance.mass_entry(i, j, mass[(i, j)])),
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
                *entry =
                    if j < finite { balance.shape(dof, *entry) } else { balance.massless_shape(dof, *entry) };
            }
        }
        self.balance = Some(balance);
        Ok(())
    }

    fn solve_as_given(&mut self, stiffness: MatRef<'_, f64>, mass: MatRef<'_, f64>) -> Result<()> {
        self.shift = None;
        self.condensed = None;
        if self.solve_condensed(stiffness, mass)? {
            return Ok(());
        }
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

    /// Condenses the dofs without mass, exactly: K_cc − K_cm K_mm⁻¹ K_mc, φ_m = −K_mm⁻¹ K_mc φ_c, Σ ψψᵀ = K_mm⁻¹.
    /// False where there are none, or where K_mm is not positive definite.
    fn solve_condensed(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) -> Result<bool> {
        let (gone, kept): (Vec<usize>, Vec<usize>) =
            (0..self.n).partition(|&j| m[(j, j)] == 0.0 && (0..self.n).all(|i| m[(i, j)] == 0.0));
        if gone.is_empty() || kept.is_empty() {
            return Ok(false);
        }
        let part = |a: MatRef<'_, f64>, rows: &[usize], cols: &[usize]| {
            Mat::from_fn(rows.len(), cols.len(), |i, j| a[(rows[i], cols[j])])
        };
        let mut factor = part(k, &gone, &gone);
        if !cholesky(&mut factor, &mut self.memory) {
            return Ok(false);
        }
        let mut carried = part(k, &gone, &kept);
        solve_lower_triangular_in_place(factor.as_ref(), carried.as_mut(), Par::Seq);
        let mut stiffness = part(k, &kept, &kept);
        matmul(stiffness.as_mut(), Accum::Add, carried.transpose(), carried.as_ref(), -1.0, Par::Seq);
        let mut of_masses = Box::new(Self::new(kept.len()));
        of_masses.solve_as_given(stiffness.as_ref(), part(m, &kept, &kept).as_ref())?;
        solve_upper_triangular_in_place(factor.transpose(), carried.as_mut(), Par::Seq);
        let follow = &carried * &of_masses.vectors;
        let mut alone = Mat::identity(gone.len(), gone.len());
        solve_upper_triangular_in_place(factor.transpose(), alone.as_mut(), Par::Seq);
        self.vectors.fill(0.0);
        for j in 0..kept.len() {
            kept.iter().enumerate().for_each(|(r, &dof)| self.vectors[(dof, j)] = of_masses.vectors[(r, j)]);
            gone.iter().enumerate().for_each(|(r, &dof)| self.vectors[(dof, j)] = -follow[(r, j)]);
        }
        for j in 0..gone.len() {
            let column = kept.len() + j;
            gone.iter().enumerate().for_each(|(r, &dof)| self.vectors[(dof, column)] = alone[(r, j)]);
        }
        self.eigenvalues.clone_from(&of_masses.eigenvalues);
        self.shift = of_masses.shift;
        self.zero = of_masses.zero.max(self.rigid_ulps(k));
        self.condensed = Some(of_masses);
        self.clear_zeros();
        Ok(true)
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
            .fold((f64::INFINITY, 0.0_f64), |(lo, hi), r| (lo.min(r), hi.max(r)));
        if least <= MASS_PIVOT_RATIO * most || slowest <= MASS_PIVOT_RATIO * fastest {
            return false;
        }
        for i in 0..self.n {
            self.inverse_root_mass[i] = m[(i, i)].sqrt().recip();
        }
        for j in 0..self.n {
            for i in j..self.n {
                self.standard.matrix[(i, j)] =
                    k[(i, j)] * self.inverse_root_mass[i] * self.inverse_root_mass[j];
            }
        }
        true
    }

    fn finish_diagonal(&mut self) -> Result<()> {
        self.standard.decompose()?;
        for j in 0..self.n {
            let rotated = self.standard.vectors.col_as_slice(j).iter();
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
        self.vectors.copy_from(&self.standard.vectors);
        self.keep_all_eigenvalues();
        Ok(())
    }

    /// The massless path: M q = μ (K + σM) q.
    fn solve_shifted(&mut self, k: MatRef<'_, f64>, m: MatRef<'_, f64>) -> Result<()> {
        let trace = |a: MatRef<'_, f64>| (0..self.n).map(|i| a[(i, i)]).sum::<f64>();
        let (trace_k, trace_m) = (trace(k), trace(m));
        let sigma = if trace_m > 0.0 && trace_k > 0.0 { 1e-3 * trace_k / trace_m } else { 1.0 };
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
        let largest = self.standard.values[self.n - 1];
        let threshold = INFINITE_MODE * self.n as f64 * largest;
        if self.standard.values[0] < -1e3 * threshold {
            return Err(Error::Numerical {
                what: "modes of (K, M)".into(),
                detail: format!(
                    "the mass matrix is indefinite: the pair has the eigenvalue {:e} relative to {largest:e}; \
                     check the signs of its entries",
                    self.standard.values[0]
                ),
            });
        }
        self.shift = Some((sigma, largest));
        // μ descending is λ ascending; the massless directions (smallest μ) go last.
        self.eigenvalues.clear();
        for j in 0..self.n {
            let source = self.n - 1 - j;
            let mu = self.standard.values[source];
            let finite = mu > threshold;
            let scale = if finite { mu.sqrt().recip() } else { 1.0 };
            for i in 0..self.n {
                self.vectors[(i, j)] = self.standard.vectors[(i, source)] * scale;
            }
            if finite {
                self.eigenvalues.push(mu.recip() - sigma);
            }
        }
        // The digits of λ near zero are those of σ, and of K itself, not of the largest λ.
        self.zero = zero_eigenvalue(self.n, sigma).max(self.rigid_ulps(k));
        self.clear_zeros();
        Ok(())
    }

    /// How far ulps of K may move the lowest λ.
    fn rigid_ulps(&self, k: MatRef<'_, f64>) -> f64 {
        let lowest = 0..self.eigenvalues.len().min(RIGID_MODES);
        lowest.map(|j| RIGID_ULPS * f64::EPSILON * self.absolute_form(k, j)).fold(0.0, f64::max)
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
        let largest = self.standard.values.iter().fold(0.0_f64, |a, l| a.max(l.abs()));
        self.zero = zero_eigenvalue(self.n, largest);
        self.eigenvalues.clear();
        self.eigenvalues.extend_from_slice(&self.standard.values);
        self.clear_zeros();
    }

    /// `factor` = L of the given matrix; false when it is not positive definite.
    fn factorize(&mut self, a: MatRef<'_, f64>) -> bool {
        self.factor.copy_from(a);
        cholesky(&mut self.factor, &mut self.memory)
    }

    /// Smallest over largest squared pivot of `factor`.
    fn pivot_ratio(&self) -> f64 {
        let (least, most) = (0..self.n)
            .map(|i| self.factor[(i, i)])
            .fold((f64::INFINITY, 0.0_f64), |(lo, hi), p| (lo.min(p), hi.max(p)));
        (least / most).powi(2)
    }

    /// Takes L⁻¹ A L⁻ᵀ for symmetric A to the standard problem.
    fn reduce(&mut self, a: MatRef<'_, f64>) {
        let (reduced, factor) = (&mut self.standard.matrix, self.factor.as_ref());
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
            self.standard.vectors.as_mut(),
            Par::Seq,
        );
    }
}

/// A ← L of A = L Lᵀ; false when it is not positive definite.
fn cholesky(a: &mut Mat<f64>, memory: &mut MemBuffer) -> bool {
    let memory = MemStack::new(memory);
    cholesky_in_place(a.as_mut(), Default::default(), Par::Seq, memory, Default::default()).is_ok()
}

/// λ = 0 in floating point: rigid-body eigenvalues scatter over a few `n` ulp of the largest.
fn zero_eigenvalue(n: usize, largest: f64) -> f64 {
    16.0 * n as f64 * f64::EPSILON * largest
}

// ---- standard

/// Residual of an eigenpair, in n ulp of the largest eigenvalue, that the solver's own rounding explains.
const RESIDUAL_ULPS: f64 = 16.0;

/// A, and after [`decompose_tridiagonal`](Self::decompose) its eigenvectors and eigenvalues.
pub struct StandardSymmetric {
    n: usize,
    /// A, to be written, lower triangle.
    pub matrix: Mat<f64>,
    /// Q.
    pub vectors: Mat<f64>,
    /// μ, ascending.
    pub values: Vec<f64>,
    memory: MemBuffer,
    small: SmallSymmetric,
}

impl StandardSymmetric {
    /// Reserves the memory for `n` rows.
    pub fn new(n: usize) -> Self {
        let memory =
            self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
        Self {
            n,
            matrix: Mat::zeros(n, n),
            vectors: Mat::zeros(n, n),
            values: vec![0.0; n],
            memory: MemBuffer::new(memory),
            small: SmallSymmetric::default(),
        }
    }

    /// A = Q diag(μ) Qᵀ; A is overwritten.
    pub fn decompose(&mut self) -> Result<()> {
        if self.n <= MOST_ROWS && self.small.solve(self.n, |i, j| self.matrix[(i, j)]) {
            for j in 0..self.n {
                let (value, vector) = self.small.pair(j);
                self.values[j] = value;
                self.vectors.col_as_slice_mut(j).copy_from_slice(vector);
            }
            return Ok(());
        }
        let unit = self.unit();
        self.matrix *= Scale(unit.recip());
        self_adjoint_evd(
            self.matrix.as_ref(),
            faer::diag::DiagMut::from_slice_mut(&mut self.values),
            Some(self.vectors.as_mut()),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .map_err(|_| not_converged())?;
        self.check()?;
        self.values.iter_mut().for_each(|value| *value *= unit);
        Ok(())
    }

    /// The power of two that brings the largest entry of A near one.
    ///
    /// faer 0.24 deflates at absolute thresholds: of matrices far from one it loses digits, or returns one
    /// value twice and leaves out its neighbour.
    fn unit(&self) -> f64 {
        let largest = (0..self.n).fold(0.0_f64, |l, j| l.max(self.matrix[(j, j)].abs()));
        if largest > 0.0 && largest.is_finite() { largest.log2().round().exp2() } else { 1.0 }
    }

    /// Looks at every pair of a decomposition: values by Rayleigh's quotient, residuals by their norm, since
    /// the solver can return without having converged.
    fn check(&mut self) -> Result<()> {
        let n = self.n;
        // The solver reads the lower triangle only.
        for j in 0..n {
            for i in 0..j {
                self.matrix[(i, j)] = self.matrix[(j, i)];
            }
        }
        let mut image = Mat::<f64>::zeros(n, n);
        matmul(image.as_mut(), Accum::Replace, self.matrix.as_ref(), self.vectors.as_ref(), 1.0, Par::Seq);
        let mut worst = 0.0_f64;
        for j in 0..n {
            let (q, aq) = (self.vectors.col_as_slice(j), image.col_as_slice(j));
            let value: f64 = q.iter().zip(aq).map(|(q, a)| q * a).sum();
            let residual: f64 = q.iter().zip(aq).map(|(q, a)| (a - value * q).powi(2)).sum();
            self.values[j] = value;
            worst = worst.max(residual.sqrt());
        }
        let largest = self.values.iter().fold(0.0_f64, |l, v| l.max(v.abs()));
        // NaN fails too.
        if !(worst <= RESIDUAL_ULPS * n as f64 * f64::EPSILON * largest) {
            return Err(not_converged());
        }
        if !self.values.is_sorted() {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&a, &b| self.values[a].total_cmp(&self.values[b]));
            let (before, vectors) = (self.values.clone(), self.vectors.clone());
            for (j, &from) in order.iter().enumerate() {
                self.values[j] = before[from];
                let column = self.vectors.col_as_slice_mut(j);
                column.copy_from_slice(vectors.col_as_slice(from));
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

// ---- small

/// Most rows for which this is the faster way.
pub const MOST_ROWS: usize = 32;

/// Eigenvalues and eigenvectors of the last matrix.
#[derive(Debug, Clone, Default)]
pub struct SmallSymmetric {
    /// The matrix by columns, below the diagonal then the reflectors.
    a: Vec<f64>,
    diagonal: Vec<f64>,
    off: Vec<f64>,
    scales: Vec<f64>,
    vectors: Vec<f64>,
    work: Vec<f64>,
    order: Vec<usize>,
}

impl SmallSymmetric {
    /// Solves for the matrix of `n` rows whose entries (row, column), row >= column, `entry` gives. False
    /// where an eigenvalue does not converge.
    #[must_use]
    pub fn solve(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) -> bool {
        self.a.clear();
        self.a.resize(n * n, 0.0);
        for j in 0..n {
            for i in j..n {
                let value = entry(i, j);
                (self.a[j * n + i], self.a[i * n + j]) = (value, value);
            }
        }
        self.reduce(n);
        self.accumulate(n);
        if !decompose_tridiagonal(&mut self.diagonal, &mut self.off, &mut self.vectors, n) {
            return false;
        }
        let values = &self.diagonal;
        self.order.clear();
        self.order.extend(0..n);
        self.order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
        true
    }

    /// Eigenpair `j`, eigenvalues ascending.
    pub fn pair(&self, j: usize) -> (f64, &[f64]) {
        let (n, at) = (self.diagonal.len(), self.order[j]);
        (self.diagonal[at], &self.vectors[at * n..(at + 1) * n])
    }

    /// A → Qᵀ A Q, tridiagonal, with one reflector 1 − τ v vᵀ a column, v in place of what it clears.
    fn reduce(&mut self, n: usize) {
        self.diagonal.clear();
        self.off.clear();
        self.scales.clear();
        for k in 0..n {
            let (done, rest) = self.a.split_at_mut((k + 1) * n);
            let column = &mut done[k * n..];
            self.diagonal.push(column[k]);
            if k + 1 == n {
                break;
            }
            let v = &mut column[k + 1..];
            let tail: f64 = v[1..].iter().map(|x| x * x).sum();
            if tail == 0.0 {
                self.off.push(v[0]);
                self.scales.push(0.0);
                continue;
            }
            let beta = -(v[0] * v[0] + tail).sqrt().copysign(v[0]);
            let first = v[0] - beta;
            let tau = -first / beta;
            v[1..].iter_mut().for_each(|x| *x /= first);
            v[0] = 1.0;
            self.off.push(beta);
            self.scales.push(tau);
            // p = τ A v, then w = p − (τ/2 pᵀv) v, and A − v wᵀ − w vᵀ.
            self.work.clear();
            self.work.extend(rest.chunks_exact(n).map(|c| tau * dot(&c[k + 1..], v)));
            let half = 0.5 * tau * dot(&self.work, v);
            for (w, &x) in self.work.iter_mut().zip(v.iter()) {
                *w -= half * x;
            }
            for (j, c) in rest.chunks_exact_mut(n).enumerate() {
                let (vj, wj) = (v[j], self.work[j]);
                for ((a, &x), &w) in c[k + 1..].iter_mut().zip(v.iter()).zip(&self.work) {
                    *a -= x * wj + w * vj;
                }
            }
        }
    }

    /// Q from the reflectors, the last first.
    fn accumulate(&mut self, n: usize) {
        self.vectors.clear();
        self.vectors.resize(n * n, 0.0);
        for j in 0..n {
            self.vectors[j * n + j] = 1.0;
        }
        for k in (0..self.scales.len()).rev().filter(|&k| self.scales[k] != 0.0) {
            let v = &self.a[k * n + k + 1..(k + 1) * n];
            for column in self.vectors[(k + 1) * n..].chunks_exact_mut(n) {
                let column = &mut column[k + 1..];
                let part = self.scales[k] * dot(column, v);
                for (q, &x) in column.iter_mut().zip(v) {
                    *q -= part * x;
                }
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

// ---- tridiagonal

/// QL steps allowed for one eigenvalue; two or three are usual.
const MOST_STEPS: usize = 60;

/// Entries off the diagonal below this, relative to the largest, are zero: their squares would underflow.
const NOTHING: f64 = 1e-100;

/// Replaces `diagonal` by the eigenvalues (in no order), `off` (one shorter, or with a last entry that is
/// not read) by rubbish, and multiplies `vectors` from the right by the orthogonal matrix of eigenvectors;
/// its columns of `rows` entries follow one another. False when an eigenvalue does not converge.
pub fn decompose_tridiagonal(
    diagonal: &mut [f64],
    off: &mut [f64],
    vectors: &mut [f64],
    rows: usize,
) -> bool {
    let largest = diagonal.iter().chain(off.iter()).fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest == 0.0;
    }
    // A power of two, which rounds nothing: squares then neither overflow nor underflow where it matters.
    let scale = largest.log2().round().exp2();
    diagonal.iter_mut().chain(off.iter_mut()).for_each(|x| *x /= scale);
    let converged = iterate(&mut *diagonal, off, vectors, rows);
    for x in diagonal {
        *x *= scale;
    }
    converged
}

widest!(
    /// The QL steps of [`decompose_tridiagonal`].
    fn iterate(diagonal: &mut [f64], off: &mut [f64], vectors: &mut [f64], rows: usize) -> bool {
        let n = diagonal.len();
        for top in 0..n {
            let mut steps = 0;
            loop {
                let bottom = (top..n - 1)
                    .find(|&j| {
                        let near = diagonal[j].abs() + diagonal[j + 1].abs();
                        off[j].abs() <= 0.5 * f64::EPSILON * near + NOTHING
                    })
                    .unwrap_or(n - 1);
                if bottom == top {
                    break;
                }
                if steps == MOST_STEPS {
                    return false;
                }
                steps += 1;
                step(diagonal, off, vectors, rows, top, bottom);
            }
        }
        true
    }
);

/// One shifted QL step on the unreduced block top..=bottom.
#[inline(always)]
fn step(d: &mut [f64], e: &mut [f64], vectors: &mut [f64], rows: usize, top: usize, bottom: usize) {
    let half_gap = 0.5 * (d[top + 1] - d[top]) / e[top];
    let radius = (half_gap * half_gap + 1.0).sqrt().copysign(half_gap);
    // Distance of the last diagonal entry from the eigenvalue of the leading pair that is nearer to d[top].
    let mut g = d[bottom] - d[top] + e[top] / (half_gap + radius);
    let (mut sine, mut cosine, mut moved) = (1.0, 1.0, 0.0);
    for j in (top..bottom).rev() {
        let f = sine * e[j];
        let b = cosine * e[j];
        let r = (f * f + g * g).sqrt();
        if bottom > j + 1 {
            e[j + 1] = r;
        }
        if r == 0.0 {
            // The block falls apart here: what was moved is taken back, and the parts are done in turn.
            d[j + 1] -= moved;
            return;
        }
        let inverse = r.recip();
        (sine, cosine) = (f * inverse, g * inverse);
        let lower = d[j + 1] - moved;
        let turn = (d[j] - lower) * sine + 2.0 * cosine * b;
        moved = sine * turn;
        d[j + 1] = lower + moved;
        g = cosine * turn - b;
        let (left, right) = vectors[j * rows..(j + 2) * rows].split_at_mut(rows);
        for (u, v) in left.iter_mut().zip(right) {
            let (x, y) = (*u, *v);
            *v = sine * x + cosine * y;
            *u = cosine * x - sine * y;
        }
    }
    d[top] -= moved;
    e[top] = g;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(n: usize, entry: impl Fn(usize, usize) -> f64) {
        let mut solver = SmallSymmetric::default();
        let full = |i: usize, j: usize| entry(i.max(j), i.min(j));
        assert!(solver.solve(n, &entry));
        let scale = (0..n * n).map(|q| full(q / n, q % n).abs()).fold(1e-300, f64::max);
        for j in 0..n {
            let (value, v) = solver.pair(j);
            assert!(j == 0 || solver.pair(j - 1).0 <= value);
            for i in 0..n {
                let r: f64 = (0..n).map(|c| full(i, c) * v[c]).sum::<f64>() - value * v[i];
                assert!(r.abs() <= 2e-15 * n as f64 * scale, "{n} {r:e}");
            }
            for k in 0..=j {
                let product = dot(v, solver.pair(k).1);
                assert!((product - f64::from(u8::from(k == j))).abs() < 1e-14 * n as f64);
            }
        }
    }

    #[test]
    fn full_sparse_and_degenerate_matrices_are_solved() {
        for n in 1..=MOST_ROWS {
            check(n, |i, j| ((7 * i + 3 * j) as f64).sin() + ((i * j) as f64).cos());
            check(n, |i, j| if i - j < 2 { 2.0 - 3.0 * (i - j) as f64 } else { 0.0 });
            check(n, |_, _| 1.0);
            check(n, |i, j| f64::from(u8::from(i == j)));
            check(n, |i, j| 1e12 / (1 + 10_usize.pow(i as u32 % 9) + j) as f64);
        }
        check(4, |_, _| 0.0);
    }

    fn check_tridiagonal(diagonal: &[f64], off: &[f64]) -> Vec<f64> {
        let n = diagonal.len();
        let (mut d, mut e) = (diagonal.to_vec(), off.to_vec());
        let mut v = vec![0.0; n * n];
        for j in 0..n {
            v[j * n + j] = 1.0;
        }
        assert!(decompose_tridiagonal(&mut d, &mut e, &mut v, n));
        let scale = diagonal.iter().chain(off).fold(1e-300_f64, |m, x| m.max(x.abs()));
        for j in 0..n {
            let y = &v[j * n..(j + 1) * n];
            for i in 0..n {
                let mut r = (diagonal[i] - d[j]) * y[i];
                if i > 0 {
                    r += off[i - 1] * y[i - 1];
                }
                if i + 1 < n {
                    r += off[i] * y[i + 1];
                }
                assert!(r.abs() <= 1e-14 * n as f64 * scale, "{r}");
            }
            for k in 0..=j {
                let dot: f64 = y.iter().zip(&v[k * n..]).map(|(a, b)| a * b).sum();
                assert!((dot - f64::from(u8::from(k == j))).abs() < 1e-14 * n as f64);
            }
        }
        d.sort_by(f64::total_cmp);
        d
    }

    #[test]
    fn the_chain_has_its_closed_form() {
        let n = 40;
        let got = check_tridiagonal(&vec![2.0; n], &vec![-1.0; n - 1]);
        for (j, l) in got.iter().enumerate() {
            let want = 2.0 - 2.0 * ((j + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            assert!((l - want).abs() < 1e-14);
        }
    }

    #[test]
    fn split_graded_and_single_matrices_are_solved() {
        check_tridiagonal(&[3.0], &[]);
        check_tridiagonal(&[1.0, 1.0, 1.0], &[0.0, 0.0]);
        check_tridiagonal(&[1.0, 2.0, 3.0, 4.0], &[0.5, 0.0, 0.5]);
        check_tridiagonal(&[0.0, 0.0], &[1.0]);
        let graded: Vec<f64> = (0..20).map(|j| 10.0_f64.powi(-j)).collect();
        check_tridiagonal(&graded, &graded[1..].iter().map(|x| 0.3 * x).collect::<Vec<_>>());
    }
}
