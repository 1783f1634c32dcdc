//! Lumped inertia at one dof: `[m]`, kg for a translation, kg·m² for a rotation.

use nalgebra::Matrix1;

use crate::fem::term::Term;

/// Contribution to M of the lumped inertia `mass_kg` at dof `a`.
#[must_use]
pub fn at(a: usize, mass_kg: f64) -> Term {
    Term::from_element(&[a], &Matrix1::new(mass_kg))
}
