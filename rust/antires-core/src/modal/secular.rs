//! All roots of f(x) = Σ c_r / (λ_r − x) + d in an interval, isolated by proof.
//!
//! Between its poles f is smooth, and [`Enclosure`] bounds f, f' and f'' over a whole cell:
//!
//! - f bounded away from zero: no root;
//! - f' of one sign: f is monotone, and its end signs tell of one root or none;
//! - f'' of one sign: f is convex or concave, with at most two roots, told apart at its extremum;
//! - otherwise the cell is halved.
//!
//! Nothing is scanned, so two close roots are not stepped over. What rounding hides is decided by the
//! computed signs below the last pole; beyond it such a root is infinite at working precision (H_ik of
//! a long chain falls off as x^-n there, its partial fractions only as 1/x).

use super::bracket::root_in_cell;
use super::enclosure::{Cell, Enclosure};
use super::receptance::Receptance;
use super::tail::is_rootless;

/// Upper end of an unbounded search, relative to the last pole.
const INFINITY_RATIO: f64 = 1e16;

/// Terms of the series between poles, and beyond the last one where f falls off.
const NEAR_ORDER: usize = 5;
const FAR_ORDER: usize = 10;

/// Cells examined for one response before the rest is decided by end signs: a backstop that no tested
/// model comes near.
const MOST_CELLS: usize = 100_000;

/// Appends the roots of `h` in (low, high] to `roots`, ascending. `high` may be infinite.
pub fn roots(h: &Receptance, low: f64, high: f64, roots: &mut Vec<f64>, scratch: &mut Vec<f64>) {
    let Some(&last) = h.poles.last() else {
        return;
    };
    let start = roots.len();
    let mut budget = MOST_CELLS;
    let ceiling = high.min(INFINITY_RATIO * last.abs().max(f64::MIN_POSITIVE / f64::EPSILON));
    let mut a = (low, None);
    for (index, &pole) in h.poles.iter().enumerate() {
        if pole <= low {
            if pole == low {
                a = (low, Some(index));
            }
            continue;
        }
        if pole >= ceiling {
            // The term grows towards its pole, but the pole itself lies outside.
            search(
                h,
                Cell {
                    a: a.0,
                    b: ceiling,
                    pole_a: a.1,
                    pole_b: None,
                },
                false,
                &mut budget,
                roots,
            );
            a = (ceiling, None);
            break;
        }
        search(
            h,
            Cell {
                a: a.0,
                b: pole,
                pole_a: a.1,
                pole_b: Some(index),
            },
            false,
            &mut budget,
            roots,
        );
        a = (pole, Some(index));
    }
    if a.0 < ceiling && !is_rootless(h, scratch) {
        search(
            h,
            Cell {
                a: a.0,
                b: ceiling,
                pole_a: a.1,
                pole_b: None,
            },
            true,
            &mut budget,
            roots,
        );
    }
    roots[start..].sort_by(f64::total_cmp);
}

/// Finds the roots of one cell; the halves of a cell that cannot be decided are searched in turn.
fn search(h: &Receptance, cell: Cell, beyond_last: bool, budget: &mut usize, roots: &mut Vec<f64>) {
    *budget = budget.saturating_sub(1);
    let bounds = if beyond_last {
        Enclosure::of::<FAR_ORDER>(h, cell)
    } else {
        Enclosure::of::<NEAR_ORDER>(h, cell)
    };
    if bounds.value.sign(bounds.noise).is_some() {
        return;
    }
    let drowned = bounds.value.magnitude() <= 4.0 * bounds.noise;
    if drowned && beyond_last {
        return;
    }
    let decided = drowned || cell.is_narrow() || *budget == 0;
    if decided || bounds.slope().sign(0.0).is_some() {
        if sign(h, cell, false) != sign(h, cell, true) {
            roots.push(solve(h, cell));
        }
    } else if let Some(convex) = bounds.curvature().sign(0.0) {
        curved(h, cell, convex, roots);
    } else {
        let middle = cell.middle();
        search(h, cell.left_of(middle), beyond_last, budget, roots);
        search(h, cell.right_of(middle), beyond_last, budget, roots);
    }
}

/// Sign of f at the left or right end of the cell, as the limit from inside.
fn sign(h: &Receptance, cell: Cell, right: bool) -> bool {
    match (right, cell.pole_a, cell.pole_b) {
        (false, Some(r), _) => h.residues[r] < 0.0,
        (true, _, Some(r)) => h.residues[r] > 0.0,
        (false, None, _) => h.value(cell.a) >= 0.0,
        (true, _, None) => h.value(cell.b) >= 0.0,
    }
}

/// The one root of a cell whose end signs differ.
fn solve(h: &Receptance, cell: Cell) -> f64 {
    root_in_cell(h, cell, sign(h, cell, false))
}

/// A convex (or concave) cell: none, one or two roots.
fn curved(h: &Receptance, cell: Cell, convex: bool, roots: &mut Vec<f64>) {
    let (at_a, at_b) = (sign(h, cell, false), sign(h, cell, true));
    if at_a != at_b {
        roots.push(solve(h, cell));
        return;
    }
    // A convex function that is negative at both ends stays negative; mirrored for a concave one.
    if at_a != convex {
        return;
    }
    let upward = if convex { 1.0 } else { -1.0 };
    let mut shrinking = cell;
    while !shrinking.is_narrow() {
        let middle = shrinking.middle();
        if middle <= shrinking.a || middle >= shrinking.b {
            return;
        }
        let (value, slope) = (upward * h.value(middle), upward * h.slope(middle));
        if value < 0.0 {
            roots.push(solve(h, cell.left_of(middle)));
            roots.push(solve(h, cell.right_of(middle)));
            return;
        }
        // The tangent lies under the curve: if it stays positive on the falling side, so does f.
        let falling = if slope > 0.0 {
            middle - shrinking.a
        } else {
            shrinking.b - middle
        };
        if value - slope.abs() * falling > 0.0 {
            return;
        }
        shrinking = if slope > 0.0 {
            shrinking.left_of(middle)
        } else {
            shrinking.right_of(middle)
        };
    }
}
