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

use crate::fem::section::Bending;

/// A matrix over (v₁, θ₁, v₂, θ₂).
pub type Matrix = [[f64; 4]; 4];

/// 12 EI / (κGA L²); zero where shear is rigid.
fn shear_to_bending(plane: &Bending, l: f64) -> f64 {
    12.0 * plane.stiffness_nm2 / (plane.shear_n * l * l)
}

/// Stiffness of one plane; `sign` is that of a rotation against the slope.
#[must_use]
pub fn stiffness(l: f64, plane: &Bending, sign: f64) -> Matrix {
    let phi = shear_to_bending(plane, l);
    let k = plane.stiffness_nm2 / (l * l * l) / (1.0 + phi);
    let (k12, k6) = (12.0 * k, sign * 6.0 * k * l);
    let (k4, k2) = ((4.0 + phi) * k * l * l, (2.0 - phi) * k * l * l);
    [
        [k12, k6, -k12, k6],
        [k6, k4, -k6, k2],
        [-k12, -k6, k12, -k6],
        [k6, k2, -k6, k4],
    ]
}

/// Consistent mass of one plane; `sign` is that of a rotation against the slope.
#[must_use]
pub fn mass(l: f64, mass_kg_per_m: f64, plane: &Bending, sign: f64) -> Matrix {
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
