//! Plane beam: u, v, θ at either end; Euler-Bernoulli, or with shear and rotary inertia (Timoshenko).
//!
//! Linear shape functions along the beam; across it the matrices of [`bending`].
//!
//! ```text
//! K_axial = EA/L [[1, -1], [-1, 1]]         M_axial = ρA L/6 [[2, 1], [1, 2]]
//! ```
//!
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.

use nalgebra::{Matrix3, Matrix6};

use super::{bending, set, to_global};
use crate::fem::section::Rigidity;

/// Local dofs of the axial motion and of the bending.
const AXIAL: [usize; 2] = [0, 3];
const ACROSS: [usize; 4] = [1, 2, 4, 5];

/// Stiffness in global axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn stiffness(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, axes) = axes(a, b);
    let ea = section.axial_n / l;
    let mut local = Matrix6::zeros();
    set(&mut local, AXIAL, [[ea, -ea], [-ea, ea]]);
    set(
        &mut local,
        ACROSS,
        bending::stiffness(l, &section.bending_z, 1.0),
    );
    to_global(&local, &axes)
}

/// Consistent mass in global axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn mass(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, axes) = axes(a, b);
    let m = section.mass_kg_per_m * l;
    let (m2, m1) = (m / 3.0, m / 6.0);
    let mut local = Matrix6::zeros();
    set(&mut local, AXIAL, [[m2, m1], [m1, m2]]);
    set(
        &mut local,
        ACROSS,
        bending::mass(l, section.mass_kg_per_m, &section.bending_z, 1.0),
    );
    to_global(&local, &axes)
}

/// Length, and the rotation from global to local axes (θ stays).
fn axes(a: [f64; 2], b: [f64; 2]) -> (f64, Matrix3<f64>) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let l = (dx * dx + dy * dy).sqrt();
    let (c, s) = (dx / l, dy / l);
    (l, Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0))
}
