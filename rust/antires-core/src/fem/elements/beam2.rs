//! Plane Euler-Bernoulli beam: u, v, θ at either end.
//!
//! With EA, EI, ρA constant over the length L, linear shape functions along the beam and cubic ones
//! across it (consistent mass, no rotary inertia), in the order (v₁, θ₁, v₂, θ₂):
//!
//! ```text
//!          EI  | 12    6L   -12   6L  |          ρA L | 156    22L    54   -13L |
//! K_bend = --- | 6L    4L²  -6L   2L² |   M_bend = --- | 22L    4L²   13L  -3L² |
//!          L³  |-12   -6L    12  -6L  |           420 | 54     13L   156   -22L |
//!              | 6L    2L²  -6L   4L² |               |-13L   -3L²  -22L   4L²  |
//!
//! K_axial = EA/L [[1, -1], [-1, 1]]         M_axial = ρA L/6 [[2, 1], [1, 2]]
//! ```
//!
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.

use nalgebra::{Matrix3, Matrix6};

use super::to_global;
use crate::fem::section::Rigidity;

/// Stiffness in global axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn stiffness(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, axes) = axes(a, b);
    let ea = section.axial_n / l;
    let k = section.bending_z_nm2 / (l * l * l);
    let (k12, k6, k4, k2) = (12.0 * k, 6.0 * k * l, 4.0 * k * l * l, 2.0 * k * l * l);
    #[rustfmt::skip]
    let local = Matrix6::new(
         ea, 0.0,  0.0, -ea,  0.0,  0.0,
        0.0,  k12,  k6, 0.0, -k12,   k6,
        0.0,  k6,   k4, 0.0, -k6,    k2,
        -ea, 0.0,  0.0,  ea,  0.0,  0.0,
        0.0, -k12, -k6, 0.0,  k12,  -k6,
        0.0,  k6,   k2, 0.0, -k6,    k4,
    );
    to_global(&local, &axes)
}

/// Consistent mass in global axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn mass(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, axes) = axes(a, b);
    let m = section.mass_kg_per_m * l;
    let (m2, m1) = (m / 3.0, m / 6.0);
    let m = m / 420.0;
    let (own, turn, tip) = (156.0 * m, 22.0 * m * l, 4.0 * m * l * l);
    let (far, cross, both) = (54.0 * m, 13.0 * m * l, 3.0 * m * l * l);
    #[rustfmt::skip]
    let local = Matrix6::new(
         m2, 0.0,    0.0,    m1,  0.0,    0.0,
        0.0, own,    turn,  0.0,  far,   -cross,
        0.0, turn,   tip,   0.0,  cross, -both,
         m1, 0.0,    0.0,    m2,  0.0,    0.0,
        0.0, far,    cross, 0.0,  own,   -turn,
        0.0, -cross, -both, 0.0, -turn,   tip,
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
