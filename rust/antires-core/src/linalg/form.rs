//! A symmetric matrix in band or in sparse form.

use super::banded::Banded;
use super::sparse::SparseMatrix;

/// A symmetric matrix.
pub enum Form {
    /// By diagonals.
    Band(Banded),
    /// By places.
    Sparse(SparseMatrix),
}

impl Form {
    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        match self {
            Self::Band(a) => a.n(),
            Self::Sparse(a) => a.n(),
        }
    }

    /// Entries by which vectors are longer than n, to be kept at zero.
    #[must_use]
    pub fn padding(&self) -> usize {
        match self {
            Self::Band(a) => a.half(),
            Self::Sparse(_) => 0,
        }
    }

    /// Diagonal entry `j`.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        match self {
            Self::Band(a) => a.diagonal(j),
            Self::Sparse(a) => a.diagonal(j),
        }
    }

    /// Largest diagonal entry.
    #[must_use]
    pub fn largest_diagonal(&self) -> f64 {
        (0..self.n()).fold(0.0, |largest, j| f64::max(largest, self.diagonal(j)))
    }

    /// y = A x; see [`Banded::multiply`].
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Band(a) => a.multiply(x, y),
            Self::Sparse(a) => a.multiply(x, y),
        }
    }

    /// Σ |x_i| |A_ij| |x_j|.
    #[must_use]
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        match self {
            Self::Band(a) => a.absolute_form(x),
            Self::Sparse(a) => a.absolute_form(x),
        }
    }

    /// Σ (w_i A_ij u_j)².
    #[must_use]
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        match self {
            Self::Band(a) => a.squared_form(w, u),
            Self::Sparse(a) => a.squared_form(w, u),
        }
    }
}
