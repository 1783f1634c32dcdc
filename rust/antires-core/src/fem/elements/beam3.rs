//! Space beam: u, v, w, θx, θy, θz at either end; bending in two planes, Euler-Bernoulli or with shear and
//! rotary inertia (Timoshenko), St. Venant torsion, axial.
//!
//! Local axes: x from the first node to the second; y the part of the reference direction across x;
//! z = x × y. Bending in the plane x-y (v, θz) is that of the plane beam with E I_z; in the plane x-z
//! (w, θy) with E I_y, where θy = −w′ turns the sign of every entry between w and θy. Torsion and
//! axial motion share one pattern:
//!
//! ```text
//! K = c/L [[1, -1], [-1, 1]]    c = EA, GJ          M = m L/6 [[2, 1], [1, 2]]    m = ρA, ρ(I_y + I_z)
//! ```
//!
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::{bending, set, to_global};
use crate::fem::section::Rigidity;

/// A matrix over both ends.
pub type Matrix12 = SMatrix<f64, 12, 12>;

/// Local dofs of one bending plane (deflection and rotation at either end), and the sign of a
/// rotation against the slope.
const PLANE_XY: ([usize; 4], f64) = ([1, 5, 7, 11], 1.0);
const PLANE_XZ: ([usize; 4], f64) = ([2, 4, 8, 10], -1.0);

/// Stiffness in global axes of a beam from `a` to `b` (m) with reference direction `up`.
#[must_use]
pub fn stiffness(a: [f64; 3], b: [f64; 3], up: [f64; 3], section: &Rigidity) -> Matrix12 {
    let (l, axes) = axes(a, b, up);
    let mut local = Matrix12::zeros();
    for (dofs, c) in [
        ([0, 6], section.axial_n / l),
        ([3, 9], section.torsion_nm2 / l),
    ] {
        set(&mut local, dofs, [[c, -c], [-c, c]]);
    }
    for ((dofs, sign), plane) in [
        (PLANE_XY, &section.bending_z),
        (PLANE_XZ, &section.bending_y),
    ] {
        set(&mut local, dofs, bending::stiffness(l, plane, sign));
    }
    to_global(&local, &axes)
}

/// Consistent mass in global axes of a beam from `a` to `b` (m) with reference direction `up`.
#[must_use]
pub fn mass(a: [f64; 3], b: [f64; 3], up: [f64; 3], section: &Rigidity) -> Matrix12 {
    let (l, axes) = axes(a, b, up);
    let mut local = Matrix12::zeros();
    for (dofs, m) in [
        ([0, 6], section.mass_kg_per_m * l),
        ([3, 9], section.polar_kgm * l),
    ] {
        set(&mut local, dofs, [[m / 3.0, m / 6.0], [m / 6.0, m / 3.0]]);
    }
    for ((dofs, sign), plane) in [
        (PLANE_XY, &section.bending_z),
        (PLANE_XZ, &section.bending_y),
    ] {
        let matrix = bending::mass(l, section.mass_kg_per_m, plane, sign);
        set(&mut local, dofs, matrix);
    }
    to_global(&local, &axes)
}

/// Length, and the rotation from global to local axes.
fn axes(a: [f64; 3], b: [f64; 3], up: [f64; 3]) -> (f64, Matrix3<f64>) {
    let along = Vector3::from(b) - Vector3::from(a);
    let l = along.norm();
    let x = along / l;
    let z = x.cross(&Vector3::from(up)).normalize();
    let y = z.cross(&x);
    (
        l,
        Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]),
    )
}
