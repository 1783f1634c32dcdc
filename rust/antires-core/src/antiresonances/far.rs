//! Roots of H_ik far above the last pole of a structure with dofs that have no mass.
//!
//! Such a dof on a soft spring beside stiff ones has H_ik of another sign far above all poles than beside them, where
//! the partial fractions, each of which falls off as 1/x, drown in rounding while H_ik itself falls off much faster.
//! The factors of K − xM keep its sign: it is asked at points a fixed ratio apart, and a change of it is a root.

use super::placement::{Placed, place};
use super::secular::{Certainty, FAR_RATIO, INFINITY_RATIO};
use crate::modal::minor::Ends;
use crate::modal::receptance::Receptance;
use crate::modal::solved::Solved;

/// Ratio of neighbouring points in x.
const STEP: f64 = 16.0;

/// Multiple of what an ulp of K and M makes of H from which on its sign is certain.
const SURE: f64 = 16.0;

/// Halvings of an interval, in log x, after which Newton's method takes over.
const HALVINGS: usize = 20;

/// Farthest that it may go, relatively.
const NEAR: f64 = 1e-4;

/// Hands those of `h` up to `ceiling` to `take`; doubtful where the structure is too small for factors.
pub(super) fn add_roots(
    solved: &mut Solved<'_>,
    ends: &Ends,
    h: &Receptance,
    ceiling: f64,
    mut take: impl FnMut(Placed),
) -> Certainty {
    let massless = solved.dense_in_hand().is_some_and(|all| all.eigenvalues.len() < solved.n_dof());
    let last = h.poles.last().copied().unwrap_or_default();
    if !massless || h.constant != 0.0 || h.is_zero || last <= 0.0 {
        return Certainty::Proven;
    }
    if !solved.is_reducible() {
        return Certainty::Doubtful;
    }
    let highest = ceiling.min(INFINITY_RATIO * last);
    let mut before = None;
    let mut x = FAR_RATIO * last;
    while x < STEP * highest {
        x = x.min(highest);
        if let Some(positive) = sign(solved, ends, x) {
            if let Some((low, was)) = before
                && was != positive
                && let Some(root) = root_between(solved, ends, (low, x), was)
                && root.x <= ceiling
            {
                take(root);
            }
            before = Some((x, positive));
        }
        x *= STEP;
    }
    Certainty::Proven
}

/// Whether H is positive at `x`; none where rounding hides it.
fn sign(solved: &mut Solved<'_>, ends: &Ends, x: f64) -> Option<bool> {
    let here = solved.reduced().receptance_at(ends, x)?;
    (here.value.abs() > SURE * here.ulp * here.slope.abs()).then_some(here.value > 0.0)
}

/// The root between two points, of which H is positive at the lower one or not.
fn root_between(
    solved: &mut Solved<'_>,
    ends: &Ends,
    (mut low, mut high): (f64, f64),
    positive: bool,
) -> Option<Placed> {
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        match sign(solved, ends, middle) {
            Some(here) if here == positive => low = middle,
            Some(_) => high = middle,
            None => return place(solved, ends, middle, NEAR * middle),
        }
    }
    let near = (low * high).sqrt();
    place(solved, ends, near, NEAR * near)
}
