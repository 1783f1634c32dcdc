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

use super::cell::Cell;
use super::range::Sign;
use super::remainder::{Jet, Remainder};
use crate::linalg::wide::{self, NullaryFnOnce};
use crate::modal::receptance::Receptance;

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
        let (left, d_left) = if self.cell.pole_a {
            (x - self.cell.a, 1.0)
        } else {
            (1.0, 0.0)
        };
        let (right, d_right) = if self.cell.pole_b {
            (self.cell.b - x, -1.0)
        } else {
            (1.0, 0.0)
        };
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
        let y = if slope > 0.0 {
            2.0 * ca / (slope + root)
        } else {
            0.5 * (slope - root) / g
        };
        let x = a + y * width;
        if x > a && x < b { x } else { middle }
    }
}

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
    let smooth = Smooth {
        rest,
        cell,
        ends: cell.end_residues(h),
    };
    wide::run(Search {
        smooth,
        left,
        at_middle,
    })
}

/// [`root_in_cell`].
struct Search<'a> {
    smooth: Smooth<'a>,
    left: Sign,
    at_middle: Option<f64>,
}

impl NullaryFnOnce for Search<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self {
            smooth,
            left,
            at_middle,
        } = self;
        let cell = smooth.cell;
        let (mut low, mut high) = (cell.a, cell.b);
        let mut x = smooth.start(at_middle);
        let mut last_step = f64::INFINITY;
        // Bisection alone needs fewer than 1100 halvings of any interval of doubles.
        for _ in 0..1200 {
            let [value, slope, bend] = smooth.at(x);
            if value == 0.0 {
                return x;
            }
            let here = if value > 0.0 {
                Sign::Positive
            } else {
                Sign::Negative
            };
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receptance(poles: &[f64], residues: &[f64], constant: f64) -> Receptance {
        Receptance {
            poles: poles.to_vec(),
            residues: residues.to_vec(),
            constant,
            ..Receptance::default()
        }
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
        let cell = Cell {
            a: 1.0,
            b: 3.0,
            below: 1,
            pole_a: true,
            pole_b: true,
        };
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
        let cell = Cell {
            a: 3.0,
            b: 50.0,
            below: 2,
            pole_a: false,
            pole_b: false,
        };
        let left = if h.value(3.0) > 0.0 {
            Sign::Positive
        } else {
            Sign::Negative
        };
        assert!((solve(&h, cell, left) - 4.0).abs() <= 4.0 * f64::EPSILON);
        let half = Cell {
            a: 2.0,
            b: 50.0,
            below: 2,
            pole_a: true,
            pole_b: false,
        };
        assert!((solve(&h, half, Sign::Negative) - 4.0).abs() <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn strong_neighbours_do_not_mislead_the_model() {
        let h = receptance(&[0.999, 1.0, 3.0, 3.001], &[50.0, 1e-3, 1e-3, 80.0], -7.0);
        let cell = Cell {
            a: 1.0,
            b: 3.0,
            below: 2,
            pole_a: true,
            pole_b: true,
        };
        let root = solve(&h, cell, Sign::Negative);
        let (before, after) = (root * (1.0 - 1e-14), root * (1.0 + 1e-14));
        assert!(h.value(before) < 0.0 && h.value(after) > 0.0);
    }
}
