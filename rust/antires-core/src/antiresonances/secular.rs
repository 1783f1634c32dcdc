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
//!
//! # bracket
//!
//! The one root of f(x) = Σ c_r / (λ_r − x) + d in a cell, to the last digits.
//!
//! The poles at the ends of the cell bend f most, and are known. Multiplied out,
//!
//! ```text
//! F(x) = (x − a) (b − x) f(x) = −c_a (b − x) + c_b (x − a) + g(x) (x − a) (b − x)
//! ```
//!
//! is smooth, with g the part of all other poles. With g as it is in the middle, F is a quadratic, whose
//! root is the first point; Halley's steps −2 F F' / (2 F'² − F F'') follow, of third order. Every point
//! shrinks the bracket; a step that leaves it, or is not half the one before, gives way to bisection.
//! A factor is left out where there is no pole.
//!
//! Reference: Melman, Numer. Math. 69 (1995) 483-493 (transformed secular equations).

use super::bounds::{Cell, Enclosure, Jet, Remainder, Screening, Sign, Verdict, is_rootless};
use crate::linalg::wide::widest;
use crate::modal::receptance::{Pattern, Receptance};

/// Upper end of an unbounded search, relative to the last pole.
pub(super) const INFINITY_RATIO: f64 = 1e16;

/// Beyond this multiple of the last pole, what drowns in rounding is infinite.
pub(super) const FAR_RATIO: f64 = 16.0;

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
pub fn roots(h: &Receptance, low: f64, high: f64, roots: &mut Vec<f64>, scratch: &mut Scratch) -> Certainty {
    let Some(&last) = h.poles.last() else {
        return Certainty::Proven;
    };
    let start = roots.len();
    let Scratch { screening, rest, moments } = scratch;
    rest.set(h);
    let ceiling = high.min(farthest(h, last));
    screening.prepare(h, low, ceiling);
    let mut search = Secular { h, rest, roots, budget: MOST_CELLS, certainty: Certainty::Proven };
    let pattern = h.pattern();
    for (index, &cell) in screening.cells.iter().enumerate() {
        let place = if !cell.pole_b && last < ceiling { Place::BeyondLastPole } else { Place::BetweenPoles };
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

/// Where a search without a limit ends: with a constant d, |x − λ| <= Σ |c_r| / |d| for a root beyond the last pole λ.
fn farthest(h: &Receptance, last: f64) -> f64 {
    let by_pole = INFINITY_RATIO * last.abs().max(f64::MIN_POSITIVE / f64::EPSILON);
    if h.constant == 0.0 {
        return by_pole;
    }
    let residues: f64 = h.residues.iter().map(|c| c.abs()).sum();
    by_pole.max(last + 2.0 * residues / h.constant.abs())
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
        if bounds.value.sign(bounds.noise).is_some() {
            return;
        }
        let drowned = bounds.value.is_drowned(bounds.noise);
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
            self.monotone(cell, None);
        } else if let Some(bend) = bounds.curvature().sign(0.0) {
            self.curved(cell, bend, bounds.noise);
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

    /// A cell with f'' of the sign `bend`, convex or concave: none, one or two roots.
    fn curved(&mut self, cell: Cell, bend: Sign, noise: f64) {
        let h = self.h;
        let (at_a, at_b) = (sign(h, cell, End::Left), sign(h, cell, End::Right));
        if at_a != at_b {
            self.monotone(cell, None);
            return;
        }
        // A convex function that is negative at both ends stays negative; mirrored for a concave one.
        if at_a != bend {
            return;
        }
        let upward = if bend == Sign::Positive { 1.0 } else { -1.0 };
        let mut shrinking = cell;
        while !shrinking.is_narrow() {
            let middle = shrinking.middle();
            let (value, slope) = (upward * h.value(middle), upward * h.slope(middle));
            if value.abs() <= noise {
                // f touches zero, or nearly so: two roots or none is beyond its rounding.
                self.certainty = Certainty::Doubtful;
            }
            if value < 0.0 {
                self.monotone(cell.left_of(middle), None);
                self.monotone(cell.right_of(middle), None);
                return;
            }
            // The tangent lies under the curve: if it stays positive on the falling side, so does f.
            let falling = if slope > 0.0 { middle - shrinking.a } else { shrinking.b - middle };
            if value - slope.abs() * falling > noise {
                return;
            }
            shrinking = if slope > 0.0 { shrinking.left_of(middle) } else { shrinking.right_of(middle) };
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
    if positive { Sign::Positive } else { Sign::Negative }
}

// ---- bracket

/// Relative step after which the next one of third order is below rounding.
const LAST_STEP: f64 = 1e-6;

/// f in a cell with the poles at its ends multiplied out.
struct Smooth<'a> {
    rest: &'a Remainder,
    cell: Cell,
    ends: [f64; 2],
}

impl Smooth<'_> {
    /// F, F' and F'' at x.
    #[inline(always)]
    fn at(&self, x: f64) -> [f64; 3] {
        let Jet { value, slope, bend } = self.rest.at(x);
        let [ca, cb] = self.ends;
        let (left, d_left) = if self.cell.pole_a { (x - self.cell.a, 1.0) } else { (1.0, 0.0) };
        let (right, d_right) = if self.cell.pole_b { (self.cell.b - x, -1.0) } else { (1.0, 0.0) };
        let (both, d_both) = (left * right, d_left * right + left * d_right);
        [
            cb * left - ca * right + value * both,
            cb * d_left - ca * d_right + slope * both + value * d_both,
            bend * both + 2.0 * slope * d_both + 2.0 * value * d_left * d_right,
        ]
    }

    /// First point: between two poles of one sign the root with g as in the middle, else the middle.
    #[inline(always)]
    fn start(&self, at_middle: Option<f64>) -> f64 {
        let (a, b) = (self.cell.a, self.cell.b);
        let (middle, width) = (0.5 * (a + b), b - a);
        let [ca, cb] = self.ends;
        if ca * cb <= 0.0 {
            return middle;
        }
        // G y² − B y + c_a = 0 for y = (x − a)/w; with c_a, c_b > 0 one root lies in 0 < y < 1.
        let (ca, cb) = (ca.abs(), cb.abs());
        let at_middle = at_middle.unwrap_or_else(|| self.rest.at(middle).value);
        let g = at_middle * width * self.ends[0].signum();
        let slope = ca + cb + g;
        let root = (slope * slope - 4.0 * g * ca).max(0.0).sqrt();
        let y = if slope > 0.0 { 2.0 * ca / (slope + root) } else { 0.5 * (slope - root) / g };
        let x = a + y * width;
        if x > a && x < b { x } else { middle }
    }
}

widest!(
    /// Root of `h` in `cell`, with `rest` the part of the other poles; f has the sign `left` at the left end
    /// and the other one at the right end. `at_middle` is the value of `rest` there, if
    /// known.
    pub fn root_in_cell(
        h: &Receptance,
        rest: &Remainder,
        cell: Cell,
        left: Sign,
        at_middle: Option<f64>,
    ) -> f64 {
        let smooth = Smooth { rest, cell, ends: cell.end_residues(h) };
        let (mut low, mut high) = (cell.a, cell.b);
        let mut x = smooth.start(at_middle);
        let mut last_step = f64::INFINITY;
        // Bisection alone needs fewer than 1100 halvings of any interval of doubles.
        for _ in 0..1200 {
            let [value, slope, bend] = smooth.at(x);
            if value == 0.0 {
                return x;
            }
            let here = if value > 0.0 { Sign::Positive } else { Sign::Negative };
            if here == left {
                low = x;
            } else {
                high = x;
            }
            let next = x - 2.0 * value * slope / (2.0 * slope * slope - value * bend);
            let step = (next - x).abs();
            let room = (x - cell.a).min(cell.b - x);
            if step <= (LAST_STEP * room).max(f64::EPSILON * x.abs()) {
                return next.clamp(low, high);
            }
            if next > low && next < high && step < 0.5 * last_step {
                (x, last_step) = (next, step);
            } else {
                (x, last_step) = (0.5 * (low + high), high - low);
            }
            if x <= low || x >= high {
                return x;
            }
        }
        x
    }
);

#[cfg(test)]
mod tests {
    use super::*;

    fn receptance(poles: &[f64], residues: &[f64], constant: f64) -> Receptance {
        Receptance { poles: poles.to_vec(), residues: residues.to_vec(), constant, ..Receptance::default() }
    }

    fn solve(h: &Receptance, cell: Cell, left: Sign) -> f64 {
        let mut rest = Remainder::default();
        rest.set(h);
        rest.leave_out(cell);
        root_in_cell(h, &rest, cell, left, None)
    }

    #[test]
    fn between_two_poles_the_root_is_exact() {
        let h = receptance(&[1.0, 3.0], &[1.0, 1.0], 0.0);
        let cell = Cell { a: 1.0, b: 3.0, below: 1, pole_a: true, pole_b: true };
        assert!((solve(&h, cell, Sign::Negative) - 2.0).abs() <= f64::EPSILON * 2.0);
        // 1e-9/(1−x) + 1/(3−x): the root hugs the weak pole.
        let h = receptance(&[1.0, 3.0], &[1e-9, 1.0], 0.0);
        let want = 1.0 + 2.0 * 1e-9 / (1.0 + 1e-9);
        assert!((solve(&h, cell, Sign::Negative) - want).abs() <= 2.0 * f64::EPSILON);
    }

    #[test]
    fn cells_without_poles_at_their_ends_are_solved_too() {
        // −1.5/(1−x) + 1/(2−x) vanishes at 4.
        let h = receptance(&[1.0, 2.0], &[-1.5, 1.0], 0.0);
        let cell = Cell { a: 3.0, b: 50.0, below: 2, pole_a: false, pole_b: false };
        let left = if h.value(3.0) > 0.0 { Sign::Positive } else { Sign::Negative };
        assert!((solve(&h, cell, left) - 4.0).abs() <= 4.0 * f64::EPSILON);
        let half = Cell { a: 2.0, b: 50.0, below: 2, pole_a: true, pole_b: false };
        assert!((solve(&h, half, Sign::Negative) - 4.0).abs() <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn strong_neighbours_do_not_mislead_the_model() {
        let h = receptance(&[0.999, 1.0, 3.0, 3.001], &[50.0, 1e-3, 1e-3, 80.0], -7.0);
        let cell = Cell { a: 1.0, b: 3.0, below: 2, pole_a: true, pole_b: true };
        let root = solve(&h, cell, Sign::Negative);
        let (before, after) = (root * (1.0 - 1e-14), root * (1.0 + 1e-14));
        assert!(h.value(before) < 0.0 && h.value(after) > 0.0);
    }
}
