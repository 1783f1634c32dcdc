//! The matrices of all elements, each with its formula.
//!
//! # bending
//!
//! Bending of a beam in one plane: deflection and rotation at either end, in the order (v₁, θ₁, v₂, θ₂).
//!
//! With EI, κGA, ρA, ρI constant over the length L and the static deflection of a beam with shear as
//! shape function (consistent mass, rotary inertia apart):
//!
//! ```text
//! Φ = 12 EI / (κGA L²)                              0 where shear is rigid (Euler-Bernoulli)
//!
//!              EI      | 12   6L      -12   6L      |
//! K      = ----------- | 6L   (4+Φ)L² -6L   (2-Φ)L² |
//!          L³ (1 + Φ)  |-12  -6L       12  -6L      |
//!                      | 6L   (2-Φ)L² -6L   (4+Φ)L² |
//!
//!              ρA L      | a1  a2  a3 -a4 |  a1 = 156 + 294Φ + 140Φ²   a2 = (22 + 77/2 Φ + 35/2 Φ²) L
//! M_ρA   = ------------- | a2  a5  a4 -a6 |  a3 =  54 + 126Φ +  70Φ²   a4 = (13 + 63/2 Φ + 35/2 Φ²) L
//!          420 (1 + Φ)²  | a3  a4  a1 -a2 |  a5 = (4 + 7Φ + 7/2 Φ²) L²
//!                        |-a4 -a6 -a2  a5 |  a6 = (3 + 7Φ + 7/2 Φ²) L²
//!
//!              ρI        | 36  b1 -36  b1 |  b1 = (3 - 15Φ) L
//! M_ρI   = ------------- | b1  b2 -b1 -b3 |  b2 = (4 + 5Φ + 10Φ²) L²
//!          30 L (1 + Φ)² |-36 -b1  36 -b1 |  b3 = (1 + 5Φ - 5Φ²) L²
//!                        | b1 -b3 -b1  b2 |
//! ```
//!
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.
//!
//! # beam2
//!
//! Plane beam: u, v, θ at either end; Euler-Bernoulli, or with shear and rotary inertia (Timoshenko).
//!
//! Linear shape functions along the beam; across it the matrices of [`bending`].
//!
//! ```text
//! K_axial = EA/L [[1, -1], [-1, 1]]         M_axial = ρA L/6 [[2, 1], [1, 2]]
//! ```
//!
//! Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.
//!
//! # beam3
//!
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
//!
//! # spring
//!
//! Axial spring of stiffness k between two dofs: `k [[1, -1], [-1, 1]]`; to ground: `[k]`.
//!
//! Between two nodes the spring acts along the unit vector n from one to the other:
//!
//! ```text
//! K = k | n nᵀ   -n nᵀ |
//!       |-n nᵀ    n nᵀ |
//! ```
//!
//! # lumped
//!
//! Lumped inertia at one dof: `[m]`, kg for a translation, kg·m² for a rotation.

use nalgebra::{Matrix1, Matrix2, Matrix3, Matrix6, SMatrix, Vector3};

use super::section::{Bending, Rigidity};
use super::term::Term;

/// Tᵀ A T of a symmetric element matrix A in local axes, T block-diagonal with the 3 x 3 rotation
/// `axes` from global to local. The upper triangle mirrors the lower: symmetric to the last bit.
fn to_global<const N: usize>(local: &SMatrix<f64, N, N>, axes: &Matrix3<f64>) -> SMatrix<f64, N, N> {
    let mut global = SMatrix::<f64, N, N>::zeros();
    let back = axes.transpose();
    for row in (0..N).step_by(3) {
        for col in (0..=row).step_by(3) {
            let block = Matrix3::from_fn(|i, j| local[(row + i, col + j)]);
            let turned = product(&back, &product(&block, axes));
            for j in 0..3 {
                for i in 0..3 {
                    global[(row + i, col + j)] = turned[(i, j)];
                }
            }
        }
    }
    global.fill_upper_triangle_with_lower_triangle();
    global
}

/// A · B written out: several times faster at this size than the general product.
fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// Writes the matrix of one motion to its local dofs.
fn set<const N: usize, const D: usize>(
    target: &mut SMatrix<f64, N, N>,
    dofs: [usize; D],
    values: [[f64; D]; D],
) {
    for (&i, row) in dofs.iter().zip(values) {
        for (&j, value) in dofs.iter().zip(row) {
            target[(i, j)] = value;
        }
    }
}

// ---- bending

/// A matrix over (v₁, θ₁, v₂, θ₂).
pub type BendingMatrix = [[f64; 4]; 4];

/// 12 EI / (κGA L²); zero where shear is rigid.
fn shear_to_bending(plane: &Bending, l: f64) -> f64 {
    12.0 * plane.stiffness_nm2 / (plane.shear_n * l * l)
}

/// Stiffness of one plane; `sign` is that of a rotation against the slope.
pub fn bending_stiffness(l: f64, plane: &Bending, sign: f64) -> BendingMatrix {
    let phi = shear_to_bending(plane, l);
    let k = plane.stiffness_nm2 / (l * l * l) / (1.0 + phi);
    let (k12, k6) = (12.0 * k, sign * 6.0 * k * l);
    let (k4, k2) = ((4.0 + phi) * k * l * l, (2.0 - phi) * k * l * l);
    [[k12, k6, -k12, k6], [k6, k4, -k6, k2], [-k12, -k6, k12, -k6], [k6, k2, -k6, k4]]
}

/// Consistent bending_mass of one plane; `sign` is that of a rotation against the slope.
pub fn bending_mass(l: f64, mass_kg_per_m: f64, plane: &Bending, sign: f64) -> BendingMatrix {
    let phi = shear_to_bending(plane, l);
    let (phi2, square) = (phi * phi, (1.0 + phi) * (1.0 + phi));
    let m = mass_kg_per_m * l / 420.0 / square;
    let own = (156.0 + 294.0 * phi + 140.0 * phi2) * m;
    let turn = sign * (22.0 + 38.5 * phi + 17.5 * phi2) * m * l;
    let tip = (4.0 + 7.0 * phi + 3.5 * phi2) * m * l * l;
    let far = (54.0 + 126.0 * phi + 70.0 * phi2) * m;
    let cross = sign * (13.0 + 31.5 * phi + 17.5 * phi2) * m * l;
    let both = (3.0 + 7.0 * phi + 3.5 * phi2) * m * l * l;
    let r = plane.rotary_kgm / (30.0 * l) / square;
    let r36 = 36.0 * r;
    let r1 = sign * (3.0 - 15.0 * phi) * r * l;
    let r2 = (4.0 + 5.0 * phi + 10.0 * phi2) * r * l * l;
    let r3 = (1.0 + 5.0 * phi - 5.0 * phi2) * r * l * l;
    let (own, far, turn, cross) = (own + r36, far - r36, turn + r1, cross - r1);
    let (tip, both) = (tip + r2, both + r3);
    [
        [own, turn, far, -cross],
        [turn, tip, cross, -both],
        [far, cross, own, -turn],
        [-cross, -both, -turn, tip],
    ]
}

// ---- beam2

/// Local dofs of the axial motion and of the bending.
const AXIAL: [usize; 2] = [0, 3];
const ACROSS: [usize; 4] = [1, 2, 4, 5];

/// Stiffness in global plane_axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn plane_stiffness(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, plane_axes) = plane_axes(a, b);
    let ea = section.axial_n / l;
    let mut local = Matrix6::zeros();
    set(&mut local, AXIAL, [[ea, -ea], [-ea, ea]]);
    set(&mut local, ACROSS, bending_stiffness(l, &section.bending_z, 1.0));
    to_global(&local, &plane_axes)
}

/// Consistent plane_mass in global plane_axes of a beam from `a` to `b` (x, y in m).
#[must_use]
pub fn plane_mass(a: [f64; 2], b: [f64; 2], section: &Rigidity) -> Matrix6<f64> {
    let (l, plane_axes) = plane_axes(a, b);
    let m = section.mass_kg_per_m * l;
    let (m2, m1) = (m / 3.0, m / 6.0);
    let mut local = Matrix6::zeros();
    set(&mut local, AXIAL, [[m2, m1], [m1, m2]]);
    set(&mut local, ACROSS, bending_mass(l, section.mass_kg_per_m, &section.bending_z, 1.0));
    to_global(&local, &plane_axes)
}

/// Length, and the rotation from global to local plane_axes (θ stays).
fn plane_axes(a: [f64; 2], b: [f64; 2]) -> (f64, Matrix3<f64>) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let l = (dx * dx + dy * dy).sqrt();
    let (c, s) = (dx / l, dy / l);
    (l, Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0))
}

// ---- beam3

/// A matrix over both ends.
pub type Matrix12 = SMatrix<f64, 12, 12>;

/// Local dofs of one bending plane (deflection and rotation at either end), and the sign of a
/// rotation against the slope.
const PLANE_XY: ([usize; 4], f64) = ([1, 5, 7, 11], 1.0);
const PLANE_XZ: ([usize; 4], f64) = ([2, 4, 8, 10], -1.0);

/// Stiffness in global space_axes of a beam from `a` to `b` (m) with reference direction `up`.
#[must_use]
pub fn space_stiffness(a: [f64; 3], b: [f64; 3], up: [f64; 3], section: &Rigidity) -> Matrix12 {
    let (l, space_axes) = space_axes(a, b, up);
    let mut local = Matrix12::zeros();
    for (dofs, c) in [([0, 6], section.axial_n / l), ([3, 9], section.torsion_nm2 / l)] {
        set(&mut local, dofs, [[c, -c], [-c, c]]);
    }
    for ((dofs, sign), plane) in [(PLANE_XY, &section.bending_z), (PLANE_XZ, &section.bending_y)] {
        set(&mut local, dofs, bending_stiffness(l, plane, sign));
    }
    to_global(&local, &space_axes)
}

/// Consistent space_mass in global space_axes of a beam from `a` to `b` (m) with reference direction `up`.
#[must_use]
pub fn space_mass(a: [f64; 3], b: [f64; 3], up: [f64; 3], section: &Rigidity) -> Matrix12 {
    let (l, space_axes) = space_axes(a, b, up);
    let mut local = Matrix12::zeros();
    for (dofs, m) in [([0, 6], section.mass_kg_per_m * l), ([3, 9], section.polar_kgm * l)] {
        set(&mut local, dofs, [[m / 3.0, m / 6.0], [m / 6.0, m / 3.0]]);
    }
    for ((dofs, sign), plane) in [(PLANE_XY, &section.bending_z), (PLANE_XZ, &section.bending_y)] {
        let matrix = bending_mass(l, section.mass_kg_per_m, plane, sign);
        set(&mut local, dofs, matrix);
    }
    to_global(&local, &space_axes)
}

/// Length, and the rotation from global to local space_axes.
fn space_axes(a: [f64; 3], b: [f64; 3], up: [f64; 3]) -> (f64, Matrix3<f64>) {
    let along = Vector3::from(b) - Vector3::from(a);
    let l = along.norm();
    let x = along / l;
    let z = x.cross(&Vector3::from(up)).normalize();
    let y = z.cross(&x);
    (l, Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]))
}

// ---- spring

/// Contribution to K of a spring of `stiffness_n_per_m` between dofs `a` and `b`.
pub fn between(a: usize, b: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(&[a, b], &pair(stiffness_n_per_m))
}

/// Contribution to K of a spring of `stiffness_n_per_m` from dof `a` to ground.
pub fn to_ground(a: usize, stiffness_n_per_m: f64) -> Term {
    Term::from_element(&[a], &Matrix1::new(stiffness_n_per_m))
}

/// The matrix of a spring between two dofs.
pub fn pair(stiffness_n_per_m: f64) -> Matrix2<f64> {
    Matrix2::new(1.0, -1.0, -1.0, 1.0) * stiffness_n_per_m
}

/// The matrix of a spring along `direction` (unit vector of `N / 2` components) over the translations
/// of two nodes.
pub fn along_line<const N: usize>(direction: &[f64], stiffness_n_per_m: f64) -> SMatrix<f64, N, N> {
    let half = N / 2;
    SMatrix::from_fn(|i, j| {
        let sign = if (i < half) == (j < half) { 1.0 } else { -1.0 };
        sign * stiffness_n_per_m * (direction[i % half] * direction[j % half])
    })
}

// ---- lumped

/// Contribution to M of the lumped inertia `mass_kg` at dof `a`.
pub fn lump(a: usize, mass_kg: f64) -> Term {
    Term::from_element(&[a], &Matrix1::new(mass_kg))
}
