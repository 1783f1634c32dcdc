//! Axial spring of stiffness k between two dofs: `k [[1, -1], [-1, 1]]`; to ground: `[k]`.
//!
//! Between two nodes the spring acts along the unit vector n from one to the other:
//!
//! ```text
//! K = k | n nᵀ   -n nᵀ |
//!       |-n nᵀ    n nᵀ |
//! ```

use nalgebra::{Matrix1, Matrix2, SMatrix};

use crate::fem::term::Term;

/// Contribution to K of a spring of `stiffness_n_per_m` between dofs `a` and `b`.
#[must_use]
pub fn between(a: usize, b: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(&[a, b], &pair(stiffness_n_per_m))
}

/// Contribution to K of a spring of `stiffness_n_per_m` from dof `a` to ground.
#[must_use]
pub fn to_ground(a: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(&[a], &Matrix1::new(stiffness_n_per_m))
}

/// The matrix of a spring between two dofs.
#[must_use]
pub fn pair(stiffness_n_per_m: f64) -> Matrix2<f64> {
    Matrix2::new(1.0, -1.0, -1.0, 1.0) * stiffness_n_per_m
}

/// The matrix of a spring along `direction` (unit vector of `N / 2` components) over the translations
/// of two nodes.
#[must_use]
pub fn along<const N: usize>(direction: &[f64], stiffness_n_per_m: f64) -> SMatrix<f64, N, N> {
    let half = N / 2;
    SMatrix::from_fn(|i, j| {
        let sign = if (i < half) == (j < half) { 1.0 } else { -1.0 };
        sign * stiffness_n_per_m * (direction[i % half] * direction[j % half])
    })
}
