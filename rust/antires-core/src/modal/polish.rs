//! A root of H_ik on the matrices themselves, by Newton's method.
//!
//! ```text
//! x ← x − H_ik / H'_ik,    H_ik = e_iᵀu,  H'_ik = wᵀMu,  (K − xM) u = e_k,  (K − xM) w = e_i
//! ```
//!
//! One ulp of random sign in each entry of K and M moves the root by eps √(Σ (w_r K_rs u_s)² + x² (w_r M_rs u_s)²)
//! / |wᵀMu|: the measure of what its place can be known to. Unlike a condition number of the whole matrices, it
//! does not count the stiffest entries against a mode that does not strain them: a soft support under a fine
//! mesh is known as well as its spring.
//!
//! The band factors come first ([`ReducedModes`]); where rounding spoils them, LU with pivoting.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};

use super::reduced::ReducedModes;
use crate::linalg::tolerances::ROOT_UNCERTAINTY;

/// Most steps: from three digits four lead to the last.
const NEWTON_STEPS: usize = 8;

/// Relative step below which a root is polished.
const POLISHED: f64 = 1e-12;

/// Farthest that a polish may carry a root, relatively.
const FARTHEST: f64 = 1e-2;

/// Ulps of K and M within which a root is where it can be.
const MOST_ULPS: f64 = 16.0;

/// Newton's step at a point, and how far one ulp of K and M moves the root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// −H/H'.
    pub length: f64,
    /// See the module.
    pub ulp: f64,
}

/// The root within `reach` of `x`, or as near as rounding of K and M tells; none where the steps do not settle
/// on one, or where ulps of K and M carry it to zero or infinity.
fn newton(x: f64, reach: f64, mut step_at: impl FnMut(f64) -> Option<Step>) -> Option<f64> {
    let mut at = x;
    for turn in 1..=NEWTON_STEPS {
        let Step { length, ulp } = step_at(at)?;
        at += length;
        let reach = reach.max(MOST_ULPS * ulp).min(FARTHEST * x);
        // NaN is no root.
        if !((at - x).abs() <= reach) || !(MOST_ULPS * ulp <= ROOT_UNCERTAINTY * at) {
            return None;
        }
        let enough = if turn < NEWTON_STEPS {
            ulp
        } else {
            MOST_ULPS * ulp
        };
        if length.abs() <= enough.max(POLISHED * at) {
            return Some(at);
        }
    }
    None
}

impl ReducedModes {
    /// The root of H_ik nearest to `x` within `reach` on the matrices last set; none where there is none, or
    /// where rounding spoils the factors of K − xM.
    pub fn polish(&mut self, (i, k): (usize, usize), x: f64, reach: f64) -> Option<f64> {
        let (i, k) = (self.structure.row(i), self.structure.row(k));
        newton(x, reach, |at| self.newton_step((i, k), at))
    }
}

/// [`ReducedModes::polish`] by LU with pivoting, for any matrices.
pub(super) fn polish_dense(
    (k_mat, m_mat): (MatRef<'_, f64>, MatRef<'_, f64>),
    (i, k): (usize, usize),
    x: f64,
    reach: f64,
) -> Option<f64> {
    let n = k_mat.nrows();
    // Powers of two, which round nothing, give translations and rotations one unit.
    let scale: Vec<f64> = (0..n)
        .map(|d| match k_mat[(d, d)] {
            s if s > 0.0 => (-0.5 * s.log2()).round().exp2(),
            _ => 1.0,
        })
        .collect();
    let scaled = |a: MatRef<'_, f64>| Mat::from_fn(n, n, |r, c| a[(r, c)] * scale[r] * scale[c]);
    let (stiffness, mass) = (scaled(k_mat), scaled(m_mat));
    newton(x, reach, |at| {
        let shifted = Mat::from_fn(n, n, |r, c| stiffness[(r, c)] - at * mass[(r, c)]);
        let loads = Mat::from_fn(n, 2, |r, c| {
            f64::from(u8::from(r == if c == 0 { k } else { i }))
        });
        let columns = shifted.partial_piv_lu().solve(&loads);
        let (u, w) = (columns.col(0), columns.col(1));
        let (mut slope, mut moved) = (0.0, 0.0);
        for c in 0..n {
            for r in 0..n {
                let (by_k, by_m) = (w[r] * stiffness[(r, c)] * u[c], w[r] * mass[(r, c)] * u[c]);
                slope += by_m;
                moved += by_k * by_k + at * at * by_m * by_m;
            }
        }
        Some(Step {
            length: -u[i] / slope,
            ulp: f64::EPSILON * moved.sqrt() / slope.abs(),
        })
    })
}
