//! All roots of f(x) = Σ c_r / (λ_r − x) + d in an interval, isolated by proof.
//!
//! Between its poles f is smooth, and [`Enclosure`] bounds f, f' and f'' over a whole cell:
//!
//! - f bounded away from zero: no root;
//! - f' of one sign: f is monotone, and its end signs tell of one root or none ([`Glance`] sees most cells
//!   of these two kinds);
//! - f'' of one sign: f is convex or concave, with at most two roots, told apart at its extremum;
//! - otherwise the cell is halved.
//!
//! Where the signs of the residues alone tell ([`Pattern`]), no bound is asked.
//!
//! Nothing is scanned, so two close roots are not stepped over. What rounding hides is decided by the
//! computed signs and reported as doubtful, for the pencil to settle. Far beyond the last pole a root
//! that rounding hides is infinite at working precision (H_ik of a long chain falls off as x^-n there,
//! its partial fractions only as 1/x).

use super::bracket::root_in_cell;
use super::enclosure::{Cell, DROWNED, Enclosure};
use super::glance::{Glance, Sight};
use super::receptance::{Pattern, Receptance};
use super::rest::Rest;
use super::tail::is_rootless;

/// Upper end of an unbounded search, relative to the last pole.
const INFINITY_RATIO: f64 = 1e16;

/// Beyond this multiple of the last pole, what drowns in rounding is infinite.
const FAR_RATIO: f64 = 16.0;

/// Terms of the series between poles, and beyond the last one where f falls off.
const NEAR_ORDER: usize = 5;
const FAR_ORDER: usize = 10;

/// Cells examined for one response before the rest is decided by end signs: a backstop that no tested
/// model comes near.
const MOST_CELLS: usize = 100_000;

/// Relative distance in x within which a root lies on a pole; closer than the pencil's by a margin.
const ON_A_POLE: f64 = 1e-7;

/// Working memory of a search.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    glance: Glance,
    rest: Rest,
    tail: Vec<f64>,
}

/// A search for the roots of one receptance.
pub struct Secular<'a> {
    h: &'a Receptance,
    rest: &'a mut Rest,
    roots: &'a mut Vec<f64>,
    budget: usize,
    doubtful: bool,
}

/// Appends the roots of `h` in (low, high] to `roots`, ascending; `high` may be infinite. False when
/// rounding leaves a doubt about the number of them. Their places are good to
/// [`Receptance::noise_and_slope`].
pub fn roots(
    h: &Receptance,
    low: f64,
    high: f64,
    roots: &mut Vec<f64>,
    scratch: &mut Scratch,
) -> bool {
    let Some(&last) = h.poles.last() else {
        return true;
    };
    let start = roots.len();
    let Scratch { glance, rest, tail } = scratch;
    rest.set(h);
    let ceiling = high.min(INFINITY_RATIO * last.abs().max(f64::MIN_POSITIVE / f64::EPSILON));
    glance.prepare(h, low, ceiling);
    let mut search = Secular {
        h,
        rest,
        roots,
        budget: MOST_CELLS,
        doubtful: false,
    };
    let pattern = h.pattern();
    for index in 0..glance.n_cells() {
        let cell = glance.cell(index);
        let beyond_last = !cell.pole_b && last < ceiling;
        let sight = match pattern {
            Pattern::OneSign if !beyond_last => Sight::Monotone,
            Pattern::OneSign if h.constant == 0.0 => Sight::Rootless,
            Pattern::Counted if between_one_sign(h, cell) => Sight::Monotone,
            Pattern::Counted => Sight::Rootless,
            _ => glance.at(index, h, search.rest),
        };
        match sight {
            Sight::Rootless => {}
            // Beyond the last pole the sign at the ceiling may be rounding.
            Sight::Monotone if !beyond_last => {
                let middle = glance.middle(index, h, search.rest);
                search.monotone(cell, Some(middle));
            }
            _ if beyond_last && is_rootless(h, tail) => {}
            _ => search.cell(cell, beyond_last),
        }
    }
    search.check_cancelled();
    let doubtful = search.doubtful;
    roots[start..].sort_by(f64::total_cmp);
    !doubtful
}

impl Secular<'_> {
    /// Finds the roots of one cell; the halves of a cell that cannot be decided are searched in turn.
    fn cell(&mut self, cell: Cell, beyond_last: bool) {
        self.budget = self.budget.saturating_sub(1);
        self.rest.leave_out(cell);
        let bounds = if beyond_last {
            Enclosure::of::<FAR_ORDER>(self.h, self.rest, cell)
        } else {
            Enclosure::of::<NEAR_ORDER>(self.h, self.rest, cell)
        };
        self.rest.take_back(self.h, cell);
        if bounds.value.sign(bounds.noise).is_some() {
            return;
        }
        let drowned = bounds.value.magnitude() <= DROWNED * bounds.noise;
        if drowned && beyond_last {
            self.doubtful |= cell.a < FAR_RATIO * self.h.poles[self.h.poles.len() - 1];
            return;
        }
        let guessed = drowned || cell.is_narrow() || self.budget == 0;
        self.doubtful |= guessed;
        if guessed || bounds.slope().sign(0.0).is_some() {
            self.solve(cell);
        } else if let Some(convex) = bounds.curvature().sign(0.0) {
            self.curved(cell, convex, bounds.noise);
        } else {
            let middle = cell.middle();
            self.cell(cell.left_of(middle), beyond_last);
            self.cell(cell.right_of(middle), beyond_last);
        }
    }

    /// One root or none, by the signs at the ends of a cell; `middle` is the value of the part of the other
    /// poles in its middle, if known.
    fn monotone(&mut self, cell: Cell, middle: Option<f64>) {
        let left = sign(self.h, cell, false);
        if left != sign(self.h, cell, true) {
            self.rest.leave_out(cell);
            let root = root_in_cell(self.h, self.rest, cell, left, middle);
            self.rest.take_back(self.h, cell);
            self.roots.push(root);
        }
    }

    /// The one root of a cell whose end signs differ.
    fn solve(&mut self, cell: Cell) {
        self.monotone(cell, None);
    }

    /// A convex (or concave) cell: none, one or two roots.
    fn curved(&mut self, cell: Cell, convex: bool, noise: f64) {
        let h = self.h;
        let (at_a, at_b) = (sign(h, cell, false), sign(h, cell, true));
        if at_a != at_b {
            self.solve(cell);
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
            let (value, slope) = (upward * h.value(middle), upward * h.slope(middle));
            if value.abs() <= noise {
                // f touches zero, or nearly so: two roots or none is beyond its rounding.
                self.doubtful = true;
            }
            if value < 0.0 {
                self.solve(cell.left_of(middle));
                self.solve(cell.right_of(middle));
                return;
            }
            // The tangent lies under the curve: if it stays positive on the falling side, so does f.
            let falling = if slope > 0.0 {
                middle - shrinking.a
            } else {
                shrinking.b - middle
            };
            if value - slope.abs() * falling > noise {
                return;
            }
            shrinking = if slope > 0.0 {
                shrinking.left_of(middle)
            } else {
                shrinking.right_of(middle)
            };
        }
        self.doubtful = true;
    }

    /// Looks whether H really vanishes on the poles that are taken for cancelled ones.
    fn check_cancelled(&mut self) {
        let h = self.h;
        self.doubtful |= h.cancelled.iter().any(|&l| is_hollow(h, l));
    }
}

/// Whether H vanishes at `l`, a pole that i or k does not see, so that rounding hides what the pencil has there.
///
/// It has a root if the rest of H stands out, at a distance of residue / H, and the residue may be as large as
/// what counts as negligible.
#[must_use]
pub fn is_hollow(h: &Receptance, l: f64) -> bool {
    let least = h.noise_and_slope(l).0 + h.negligible / (ON_A_POLE * l);
    l > 0.0 && least.is_finite() && h.value(l).abs() <= least
}

/// Whether the poles on either side of the cell, at its ends or further away, have residues of one sign.
fn between_one_sign(h: &Receptance, cell: Cell) -> bool {
    cell.below > 0
        && cell.below < h.residues.len()
        && h.residues[cell.below - 1] * h.residues[cell.below] > 0.0
}

/// Sign of f at the left or right end of the cell, as the limit from inside.
fn sign(h: &Receptance, cell: Cell, right: bool) -> bool {
    let [pole_a, pole_b] = cell.ends();
    match (right, pole_a, pole_b) {
        (false, Some(r), _) => h.residues[r] < 0.0,
        (true, _, Some(r)) => h.residues[r] > 0.0,
        (false, None, _) => h.value(cell.a) >= 0.0,
        (true, _, None) => h.value(cell.b) >= 0.0,
    }
}
