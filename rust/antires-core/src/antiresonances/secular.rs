//! All roots of f(x) = Σ c_r / (λ_r − x) + d in an interval, isolated by proof.
//!
//! Between its poles f is smooth, and [`Enclosure`] bounds f, f' and f'' over a whole cell:
//!
//! - f bounded away from zero: no root;
//! - f' of one sign: f is monotone, and its end signs tell of one root or none ([`Screening`] tells most
//!   cells of these two kinds);
//! - f'' of one sign: f is convex or concave, with at most two roots, told apart at its extremum;
//! - otherwise the cell is halved.
//!
//! Where the signs of the residues alone tell ([`Pattern`]), no bound is asked.
//!
//! Nothing is scanned, so two close roots are not stepped over. What rounding hides is decided by the
//! computed signs and reported as doubtful, for the pencil to settle. Far beyond the last pole a root
//! that rounding hides is infinite at working precision (H_ik of a long chain falls off as x^-n there,
//! its partial fractions only as 1/x).

use super::beyond_last_pole::is_rootless;
use super::bracket::root_in_cell;
use super::cell::Cell;
use super::enclosure::Enclosure;
use super::range::Sign;
use super::remainder::Remainder;
use super::screening::{Screening, Verdict};
use crate::modal::receptance::{Pattern, Receptance};

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
    screening: Screening,
    rest: Remainder,
    moments: Vec<f64>,
}

/// Whether the number of roots is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Certainty {
    /// By proof.
    Proven,
    /// Rounding leaves a doubt.
    Doubtful,
}

impl Certainty {
    /// Proven where both are.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        if self == Self::Proven {
            other
        } else {
            Self::Doubtful
        }
    }
}

/// Where a cell lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    BetweenPoles,
    BeyondLastPole,
}

/// An end of a cell.
#[derive(Debug, Clone, Copy)]
enum End {
    Left,
    Right,
}

/// A search for the roots of one receptance.
struct Secular<'a> {
    h: &'a Receptance,
    rest: &'a mut Remainder,
    roots: &'a mut Vec<f64>,
    budget: usize,
    certainty: Certainty,
}

/// Appends the roots of `h` in (low, high] to `roots`, ascending; `high` may be infinite. Their
/// places are good to [`Receptance::noise_and_slope`].
pub fn roots(
    h: &Receptance,
    low: f64,
    high: f64,
    roots: &mut Vec<f64>,
    scratch: &mut Scratch,
) -> Certainty {
    let Some(&last) = h.poles.last() else {
        return Certainty::Proven;
    };
    let start = roots.len();
    let Scratch {
        screening,
        rest,
        moments,
    } = scratch;
    rest.set(h);
    let ceiling = high.min(INFINITY_RATIO * last.abs().max(f64::MIN_POSITIVE / f64::EPSILON));
    screening.prepare(h, low, ceiling);
    let mut search = Secular {
        h,
        rest,
        roots,
        budget: MOST_CELLS,
        certainty: Certainty::Proven,
    };
    let pattern = h.pattern();
    for index in 0..screening.n_cells() {
        let cell = screening.cell(index);
        let place = if !cell.pole_b && last < ceiling {
            Place::BeyondLastPole
        } else {
            Place::BetweenPoles
        };
        let verdict = match pattern {
            Pattern::OneSign if place == Place::BetweenPoles => Verdict::Monotone,
            Pattern::OneSign if h.falls_off() => Verdict::Rootless,
            Pattern::Counted if between_one_sign(h, cell) => Verdict::Monotone,
            Pattern::Counted => Verdict::Rootless,
            _ => screening.verdict(index, h, search.rest),
        };
        match verdict {
            Verdict::Rootless => {}
            // Beyond the last pole the sign at the ceiling may be rounding.
            Verdict::Monotone if place == Place::BetweenPoles => {
                let middle = screening.middle(index, h, search.rest);
                search.monotone(cell, Some(middle));
            }
            _ if place == Place::BeyondLastPole && is_rootless(h, moments) => {}
            _ => search.cell(cell, place),
        }
    }
    search.check_cancelled();
    let certainty = search.certainty;
    roots[start..].sort_by(f64::total_cmp);
    certainty
}

impl Secular<'_> {
    /// Finds the roots of one cell; the halves of a cell that cannot be decided are searched in turn.
    fn cell(&mut self, cell: Cell, place: Place) {
        self.budget = self.budget.saturating_sub(1);
        self.rest.leave_out(cell);
        let bounds = match place {
            Place::BeyondLastPole => Enclosure::of::<FAR_ORDER>(self.h, self.rest, cell),
            Place::BetweenPoles => Enclosure::of::<NEAR_ORDER>(self.h, self.rest, cell),
        };
        self.rest.take_back(self.h, cell);
        if bounds.value().sign(bounds.noise()).is_some() {
            return;
        }
        let drowned = bounds.value().is_drowned(bounds.noise());
        if drowned && place == Place::BeyondLastPole {
            if cell.a < FAR_RATIO * self.h.poles[self.h.poles.len() - 1] {
                self.certainty = Certainty::Doubtful;
            }
            return;
        }
        let guessed = drowned || cell.is_narrow() || self.budget == 0;
        if guessed {
            self.certainty = Certainty::Doubtful;
        }
        if guessed || bounds.slope().sign(0.0).is_some() {
            self.solve(cell);
        } else if let Some(bend) = bounds.curvature().sign(0.0) {
            self.curved(cell, bend, bounds.noise());
        } else {
            let middle = cell.middle();
            self.cell(cell.left_of(middle), place);
            self.cell(cell.right_of(middle), place);
        }
    }

    /// One root or none, by the signs at the ends of a cell; `middle` is the value of the part of the other
    /// poles in its middle, if known.
    fn monotone(&mut self, cell: Cell, middle: Option<f64>) {
        let left = sign(self.h, cell, End::Left);
        if left != sign(self.h, cell, End::Right) {
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

    /// A cell with f'' of the sign `bend`, convex or concave: none, one or two roots.
    fn curved(&mut self, cell: Cell, bend: Sign, noise: f64) {
        let h = self.h;
        let (at_a, at_b) = (sign(h, cell, End::Left), sign(h, cell, End::Right));
        if at_a != at_b {
            self.solve(cell);
            return;
        }
        // A convex function that is negative at both ends stays negative; mirrored for a concave one.
        if at_a != bend {
            return;
        }
        let upward = bend.unit();
        let mut shrinking = cell;
        while !shrinking.is_narrow() {
            let middle = shrinking.middle();
            let (value, slope) = (upward * h.value(middle), upward * h.slope(middle));
            if value.abs() <= noise {
                // f touches zero, or nearly so: two roots or none is beyond its rounding.
                self.certainty = Certainty::Doubtful;
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
        self.certainty = Certainty::Doubtful;
    }

    /// Looks whether H really vanishes on the poles that are taken for cancelled ones.
    fn check_cancelled(&mut self) {
        let h = self.h;
        if h.cancelled.iter().any(|&l| is_hollow(h, l)) {
            self.certainty = Certainty::Doubtful;
        }
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

/// Sign of f at an end of the cell, as the limit from inside.
fn sign(h: &Receptance, cell: Cell, end: End) -> Sign {
    let [pole_a, pole_b] = cell.ends();
    let positive = match (end, pole_a, pole_b) {
        (End::Left, Some(r), _) => h.residues[r] < 0.0,
        (End::Right, _, Some(r)) => h.residues[r] > 0.0,
        (End::Left, None, _) => h.value(cell.a) >= 0.0,
        (End::Right, _, None) => h.value(cell.b) >= 0.0,
    };
    if positive {
        Sign::Positive
    } else {
        Sign::Negative
    }
}
