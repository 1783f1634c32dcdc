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

use crate::linalg::pencil::ROOT_UNCERTAINTY;
use crate::modal::reduced::ReducedModes;

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
pub(super) fn newton(
    x: f64,
    reach: f64,
    mut step_at: impl FnMut(f64) -> Option<Step>,
) -> Option<Placed> {
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
    (scatter <= SCATTER * at).then_some(Placed {
        x: at,
        ulp: scatter,
    })
}

/// The root of H_ik nearest to `x` within `reach`, on the factors of K − xM; none where there is none, or where
/// rounding spoils them.
pub(super) fn by_factors(
    reduced: &mut ReducedModes,
    ends: (usize, usize),
    x: f64,
    reach: f64,
) -> Option<Placed> {
    newton(x, reach, |at| {
        let here = reduced.receptance_at(ends, at)?;
        Some(Step {
            length: -here.value / here.slope,
            ulp: here.ulp,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps to a root at one that scatter by `size` in turn to either side, an ulp said to be far smaller.
    fn scattered(size: f64) -> Option<Placed> {
        let mut sign = 1.0;
        newton(1.0 + 1e-8, 1e-6, |at| {
            sign = -sign;
            Some(Step {
                length: 1.0 - at + sign * size,
                ulp: 1e-15,
            })
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
