//! A root on the matrices themselves, where the modal series or QZ leaves it less exact than K and M tell it.
//!
//! The factors of K − xM come first ([`newton`](crate::antiresonances::placement)). Where rounding spoils them, or where a pole so near
//! that the steps do not settle, two-sided Rayleigh quotients take over ([`rayleigh`](crate::antiresonances::placement)).
//!
//! # newton
//!
//! Newton's method for a root of H_ik on the matrices themselves.
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
//! # rayleigh
//!
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

use crate::linalg::pencil::{ROOT_UNCERTAINTY, unit};
use crate::linalg::sparse::SparseMatrix;
use crate::modal::minor::Ends;
use crate::modal::reduced::ReducedModes;
use crate::modal::solved::Solved;

/// The root of H_ik nearest to `x` within `reach`; none where there is none.
pub(super) fn place(solved: &mut Solved<'_>, ends: &Ends, x: f64, reach: f64) -> Option<Placed> {
    let by_factors = by_factors(solved.reduced(), ends, x, reach);
    if by_factors.is_some() || !solved.may_be_dense() {
        return by_factors;
    }
    by_quotients((solved.stiffness, solved.mass), ends, x, reach)
}

// ---- newton

/// Most steps: from three digits four lead to the last.
const NEWTON_STEPS: usize = 8;

/// Relative step below which a root is placed.
const SETTLED: f64 = 1e-12;

/// Farthest that the iteration may carry a root, relatively.
const FARTHEST: f64 = 1e-2;

/// Relative size of steps, which no longer shrink, within which a root is known all the same: the factors have
/// more rounding than an ulp of K and M.
const SCATTER: f64 = 1e-9;

/// Step from which on they count as scatter.
const SHRUNK: usize = 4;

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

/// A root on the matrices, and how far one ulp of theirs, or rounding of the steps, moves it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub x: f64,
    pub ulp: f64,
}

/// The root within `reach` of `x`, or as near as rounding tells; none where the steps do not settle
/// on one, or where an ulp of K and M can carry it to zero or infinity.
pub(super) fn newton(x: f64, reach: f64, mut step_at: impl FnMut(f64) -> Option<Step>) -> Option<Placed> {
    let (mut at, mut scatter) = (x, 0.0_f64);
    for iteration in 1..=NEWTON_STEPS {
        let Step { length, ulp } = step_at(at)?;
        at += length;
        let reach = reach.max(MOST_ULPS * ulp).min(FARTHEST * x);
        // NaN is no root.
        if !((at - x).abs() <= reach && ulp <= ROOT_UNCERTAINTY * at) {
            return None;
        }
        // A step of a few ulps is rounding of the factors: the next would not be shorter.
        let enough = if iteration < NEWTON_STEPS {
            ulp.max((MOST_ULPS * ulp).min(SCATTER * at))
        } else {
            MOST_ULPS * ulp
        };
        if length.abs() <= enough.max(SETTLED * at) {
            return Some(Placed { x: at, ulp });
        }
        if iteration >= SHRUNK {
            scatter = scatter.max(length.abs());
        }
    }
    (scatter <= SCATTER * at).then_some(Placed { x: at, ulp: scatter })
}

/// The root of H_ik nearest to `x` within `reach`, on the factors of K − xM; none where there is none, or where
/// rounding spoils them.
pub(super) fn by_factors(reduced: &mut ReducedModes, ends: &Ends, x: f64, reach: f64) -> Option<Placed> {
    newton(x, reach, |at| {
        let here = reduced.receptance_at(ends, at)?;
        Some(Step { length: -here.value / here.slope, ulp: here.ulp })
    })
}

// ---- rayleigh

/// The root of det(K_ik − x M_ik) nearest to `x` within `reach`; none where there is none.
pub(super) fn by_quotients(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    ends: &Ends,
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
    let without = |gone: &[usize]| -> Vec<f64> {
        (0..k_mat.n()).filter(|d| !gone.contains(d)).map(|d| scale[d]).collect()
    };
    let (rows, columns) = (without(ends.responses()), without(ends.forces()));
    let n = rows.len();
    let part = |a: &SparseMatrix| {
        let deleted = a.deleted(ends.responses(), ends.forces());
        Mat::from_fn(n, n, |r, c| deleted[(r, c)] * rows[r] * columns[c])
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
        Some(Step { length: force / slope, ulp: f64::EPSILON * moved.sqrt() / slope.abs() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::antiresonances::{Query, Route, antiresonances};
    use crate::fem::model::{Model, mass_spring_chain};
    use crate::modal::modes::eigenvalue;
    use crate::modal::reduced::ReducedModes;
    use crate::modal::structure::Structure;
    use faer::Mat;
    use std::sync::Arc;

    /// A stiff chain, its last mass on a soft spring.
    fn chain(n: usize) -> Model {
        mass_spring_chain(&vec![1.0; n], &vec![1e12; n - 1], 0.0, 1e2).unwrap()
    }

    fn band_of(model: &Model) -> ReducedModes {
        let mut band = ReducedModes::new(Arc::new(Structure::of(model)));
        band.set_matrices(model.stiffness(), model.mass());
        band
    }

    #[test]
    fn the_deleted_pencil_leads_to_the_closed_form() {
        let model = chain(60);
        let matrices = (model.stiffness(), model.mass());
        // Fixed at mass 30, the masses above it are a rod, fixed and free: 4 k sin²(π / (4 m + 2)).
        let m = 30.0_f64;
        let want = 4e12 * (std::f64::consts::PI / (4.0 * m + 2.0)).sin().powi(2);
        for start in [0.999 * want, 1.0008 * want] {
            let found = by_quotients(matrices, &(30, 59).into(), start, 2e-3 * want).unwrap();
            assert!((found.x / want - 1.0).abs() < 1e-12, "{found:?} {want}");
            assert!(found.ulp < 1e-12 * want);
            assert!(by_quotients(matrices, &(30, 59).into(), start, 1e-5 * want).is_none());
        }
        // No pivot of the band is sound there: the masses above are the first rows, and singular.
        assert!(by_factors(&mut band_of(&model), &(30, 59).into(), 0.999 * want, 2e-3 * want).is_none());
    }

    #[test]
    fn band_and_deleted_pencil_lead_to_one_root() {
        // Springs to the next mass and to the one after it.
        let joined = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 4.0 + 0.1 * (i as f64).sin(),
            1 | 2 => -1.0,
            _ => 0.0,
        };
        let stiffness = Mat::from_fn(50, 50, |i, j| 1e4 * joined(i, j));
        let mass = Mat::from_fn(50, 50, |i, j| f64::from(u8::from(i == j)));
        let model = Model::new(stiffness, mass, vec![], vec![]).unwrap();
        let (matrices, mut band) = ((model.stiffness(), model.mass()), band_of(&model));
        let query = Query { route: Route::Modal, f_max_hz: f64::INFINITY, include_cancelled: false };
        let roots = &antiresonances(&model, &[(17, 30).into()], &query).unwrap()[0].freq_hz;
        assert!(roots.len() > 20);
        let mut settled = 0;
        for want in roots.iter().map(|&f| eigenvalue(f)) {
            let (start, reach) = (want * (1.0 + 1e-6), 1e-5 * want);
            let deleted = by_quotients(matrices, &(17, 30).into(), start, reach).unwrap();
            assert!((deleted.x / want - 1.0).abs() < 1e-11);
            if let Some(found) = by_factors(&mut band, &(17, 30).into(), start, reach) {
                settled += 1;
                assert!((found.x / deleted.x - 1.0).abs() < 1e-11);
            }
        }
        assert!(2 * settled > roots.len(), "{settled}");
    }

    #[test]
    fn where_there_is_no_root_none_is_made() {
        let model = chain(60);
        let (matrices, mut band) = ((model.stiffness(), model.mass()), band_of(&model));
        // The transfer from end to end of a chain has no zero.
        for x in [1.0, 1e6, 1e11, 1e13] {
            assert!(by_factors(&mut band, &(0, 59).into(), x, 1e-2 * x).is_none());
            assert!(by_quotients(matrices, &(0, 59).into(), x, 1e-2 * x).is_none());
        }
    }

    /// Steps to a root at one that scatter by `size` in turn to either side, an ulp said to be far smaller.
    fn scattered(size: f64) -> Option<Placed> {
        let mut sign = 1.0;
        newton(1.0 + 1e-8, 1e-6, |at| {
            sign = -sign;
            Some(Step { length: 1.0 - at + sign * size, ulp: 1e-15 })
        })
    }

    #[test]
    fn steps_that_scatter_little_have_placed_the_root() {
        let placed = scattered(2e-10).unwrap();
        assert!((placed.x - 1.0).abs() <= placed.ulp, "{placed:?}");
        assert!(placed.ulp < 5e-10);
    }

    #[test]
    fn steps_that_scatter_more_have_not() {
        assert!(scattered(2e-9).is_none());
    }
}
