//! The standard problem A q = μ q, A symmetric: every pair verified.
//!
//! Up to 32 rows go to [`SmallSymmetric`], larger matrices to faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Scale};

use super::small::{MOST_ROWS, SmallSymmetric};
use crate::error::{Error, Result};

/// Residual of an eigenpair, in n ulp of the largest eigenvalue, that the solver's own rounding explains.
const RESIDUAL_ULPS: f64 = 16.0;

/// A, and after [`decompose`](Self::decompose) its eigenvectors and eigenvalues.
pub struct StandardSymmetric {
    n: usize,
    matrix: Mat<f64>,
    vectors: Mat<f64>,
    values: Vec<f64>,
    memory: MemBuffer,
    small: SmallSymmetric,
}

impl StandardSymmetric {
    /// Reserves the memory for `n` rows.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let memory = self_adjoint_evd_scratch::<f64>(
            n,
            ComputeEigenvectors::Yes,
            Par::Seq,
            Default::default(),
        );
        Self {
            n,
            matrix: Mat::zeros(n, n),
            vectors: Mat::zeros(n, n),
            values: vec![0.0; n],
            memory: MemBuffer::new(memory),
            small: SmallSymmetric::default(),
        }
    }

    /// A, to be written, lower triangle.
    pub fn matrix_mut(&mut self) -> &mut Mat<f64> {
        &mut self.matrix
    }

    /// μ, ascending.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Q.
    #[must_use]
    pub fn vectors(&self) -> &Mat<f64> {
        &self.vectors
    }

    /// Q, to be transformed in place.
    pub fn vectors_mut(&mut self) -> &mut Mat<f64> {
        &mut self.vectors
    }

    /// A = Q diag(μ) Qᵀ; A is overwritten.
    ///
    /// # Errors
    /// [`Error::Numerical`] when the solver does not converge.
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
                self.matrix[(i, j)] = self.matrix[(j, i)];
            }
        }
        let mut image = Mat::<f64>::zeros(n, n);
        matmul(
            image.as_mut(),
            Accum::Replace,
            self.matrix.as_ref(),
            self.vectors.as_ref(),
            1.0,
            Par::Seq,
        );
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
