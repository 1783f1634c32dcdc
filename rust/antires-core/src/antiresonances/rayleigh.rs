//! Two-sided Rayleigh quotients on the deleted pencil, for a root of H_ik on the matrices themselves.
//!
//! ```text
//! v ← (K_ik − xM_ik)⁻¹ v,  y ← (K_ik − xM_ik)⁻ᵀ y,    x ← yᵀK_ik v / yᵀM_ik v
//! ```
//!
//! The deleted pencil knows no pole, so that a pole beside the root does not disturb the iteration, which
//! converges cubically.
//!
//! Reference: A. M. Ostrowski, On the convergence of the Rayleigh quotient iteration III, Arch. Rational Mech.
//! Anal. 3 (1959) 325-340.

use faer::prelude::Solve;
use faer::{Col, Mat};

use super::newton::{Placed, Step, newton};
use crate::linalg::sparse::SparseMatrix;

/// The root of det(K_ik − x M_ik) nearest to `x` within `reach`; none where there is none.
pub(super) fn by_quotients(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    (i, k): (usize, usize),
    x: f64,
    reach: f64,
) -> Option<Placed> {
    // Powers of two, which round nothing, give translations and rotations one unit.
    let scale: Vec<f64> = (0..k_mat.n())
        .map(|d| match k_mat.diagonal(d) {
            s if s > 0.0 => (-0.5 * s.log2()).round().exp2(),
            _ => 1.0,
        })
        .collect();
    let n = k_mat.n() - 1;
    let part = |a: &SparseMatrix| {
        let deleted = a.deleted(i, k);
        Mat::from_fn(n, n, |r, c| {
            deleted[(r, c)] * scale[r + usize::from(r >= i)] * scale[c + usize::from(c >= k)]
        })
    };
    let (stiffness, mass) = (part(k_mat), part(m_mat));
    let mut v = Col::from_fn(n, |r| 1.0 + 0.3 * (1.7 * r as f64).sin());
    let mut y = v.clone();
    newton(x, reach, |at| {
        let shifted = Mat::from_fn(n, n, |r, c| stiffness[(r, c)] - at * mass[(r, c)]);
        let factors = shifted.partial_piv_lu();
        for _ in 0..2 {
            v = unit(factors.solve(&v));
            y = unit(factors.solve_transpose(&y));
        }
        let (mut force, mut slope, mut moved) = (0.0, 0.0, 0.0);
        for c in 0..n {
            for r in 0..n {
                let by_k = y[r] * stiffness[(r, c)] * v[c];
                let by_m = y[r] * mass[(r, c)] * v[c];
                force += y[r] * shifted[(r, c)] * v[c];
                slope += by_m;
                moved += by_k * by_k + at * at * by_m * by_m;
            }
        }
        Some(Step {
            length: force / slope,
            ulp: f64::EPSILON * moved.sqrt() / slope.abs(),
        })
    })
}

fn unit(v: Col<f64>) -> Col<f64> {
    let size = v.norm_l2();
    v * faer::Scale(size.recip())
}
