//! Axial spring of stiffness k between two dofs: `k [[1, -1], [-1, 1]]`; to ground: `[k]`.

use nalgebra::{Matrix1, Matrix2};

use crate::fem::term::Term;

/// Contribution to K of a spring of `stiffness_n_per_m` between dofs `a` and `b`.
#[must_use]
pub fn between(a: usize, b: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(
        &[a, b],
        &(Matrix2::new(1.0, -1.0, -1.0, 1.0) * stiffness_n_per_m),
    )
}

/// Contribution to K of a spring of `stiffness_n_per_m` from dof `a` to ground.
#[must_use]
pub fn to_ground(a: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(&[a], &Matrix1::new(stiffness_n_per_m))
}
