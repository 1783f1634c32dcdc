//! The one root of f(x) = Σ c_r / (λ_r − x) + d in a cell, to the last digits.
//!
//! The poles at the ends of the cell bend f most, and are known. So f is modelled by them and a straight
//! line for the rest g, matched in value and slope at the last point x_k,
//!
//! ```text
//! f(x) ≈ c_a / (a − x) + c_b / (b − x) + g(x_k) + g'(x_k) (x − x_k)
//! ```
//!
//! and the root of the model, a cubic when the poles are multiplied out, is the next point. The error
//! falls quadratically with a small factor: three or four evaluations are typical. Every point shrinks
//! the bracket; a step that leaves it, or is not half the one before, gives way to bisection.

use super::enclosure::Cell;
use super::receptance::Receptance;

/// f at a point, split into the end poles' part and the straight-line model of the rest.
struct Local {
    x: f64,
    value: f64,
    rest: f64,
    rest_slope: f64,
}

impl Local {
    fn of(h: &Receptance, cell: Cell, x: f64) -> Self {
        let (mut rest, mut rest_slope, mut ends) = (h.constant, 0.0, 0.0);
        for (r, (&pole, &c)) in h.poles.iter().zip(&h.residues).enumerate() {
            let s = (pole - x).recip();
            if cell.pole_a == Some(r) || cell.pole_b == Some(r) {
                ends += c * s;
            } else {
                rest += c * s;
                rest_slope += c * s * s;
            }
        }
        Self {
            x,
            value: rest + ends,
            rest,
            rest_slope,
        }
    }

    /// Root of the model, by Newton steps on the cubic from `x`; may leave the bracket.
    fn model_root(&self, h: &Receptance, cell: Cell) -> f64 {
        let residue = |pole: Option<usize>| pole.map_or(0.0, |r| h.residues[r]);
        let (ca, cb) = (residue(cell.pole_a), residue(cell.pole_b));
        let mut y = self.x;
        for _ in 0..6 {
            let (left, d_left) = if cell.pole_a.is_some() {
                (y - cell.a, 1.0)
            } else {
                (1.0, 0.0)
            };
            let (right, d_right) = if cell.pole_b.is_some() {
                (cell.b - y, -1.0)
            } else {
                (1.0, 0.0)
            };
            let line = self.rest + self.rest_slope * (y - self.x);
            let cubic = -ca * right + cb * left + line * left * right;
            let slope = -ca * d_right
                + cb * d_left
                + self.rest_slope * left * right
                + line * (d_left * right + left * d_right);
            let step = cubic / slope;
            y -= step;
            // The model itself is only good to the square of the step.
            if step.is_nan() || step.abs() <= 1e-4 * (y - self.x).abs() {
                break;
            }
        }
        y
    }
}

/// Root of `h` in `cell`; f is positive at the left end if `left_positive`, and has the other sign at
/// the right end.
pub fn root_in_cell(h: &Receptance, cell: Cell, left_positive: bool) -> f64 {
    let (mut low, mut high) = (cell.a, cell.b);
    let mut x = 0.5 * (low + high);
    let mut last_step = f64::INFINITY;
    // Bisection alone needs fewer than 1100 halvings of any interval of doubles.
    for _ in 0..1200 {
        let local = Local::of(h, cell, x);
        if local.value == 0.0 {
            return x;
        }
        if (local.value > 0.0) == left_positive {
            low = x;
        } else {
            high = x;
        }
        let next = local.model_root(h, cell);
        let step = (next - x).abs();
        // Quadratic convergence: after so small a step the next one would be below rounding.
        let room = (x - cell.a).min(cell.b - x);
        if step <= (1e-9 * room).max(f64::EPSILON * x.abs()) {
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

    #[test]
    fn between_two_poles_the_root_is_exact() {
        let h = receptance(&[1.0, 3.0], &[1.0, 1.0], 0.0);
        let cell = Cell {
            a: 1.0,
            b: 3.0,
            pole_a: Some(0),
            pole_b: Some(1),
        };
        assert!((root_in_cell(&h, cell, false) - 2.0).abs() <= f64::EPSILON * 2.0);
        // 1e-9/(1−x) + 1/(3−x): the root hugs the weak pole.
        let h = receptance(&[1.0, 3.0], &[1e-9, 1.0], 0.0);
        let want = 1.0 + 2.0 * 1e-9 / (1.0 + 1e-9);
        assert!((root_in_cell(&h, cell, false) - want).abs() <= 2.0 * f64::EPSILON);
    }

    #[test]
    fn cells_without_poles_at_their_ends_are_solved_too() {
        // −1.5/(1−x) + 1/(2−x) vanishes at 4.
        let h = receptance(&[1.0, 2.0], &[-1.5, 1.0], 0.0);
        let cell = Cell {
            a: 3.0,
            b: 50.0,
            pole_a: None,
            pole_b: None,
        };
        let left = h.value(3.0) > 0.0;
        assert!((root_in_cell(&h, cell, left) - 4.0).abs() <= 4.0 * f64::EPSILON);
        let half = Cell {
            a: 2.0,
            b: 50.0,
            pole_a: Some(1),
            pole_b: None,
        };
        assert!((root_in_cell(&h, half, h.residues[1] < 0.0) - 4.0).abs() <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn strong_neighbours_do_not_mislead_the_model() {
        let h = receptance(&[0.999, 1.0, 3.0, 3.001], &[50.0, 1e-3, 1e-3, 80.0], -7.0);
        let cell = Cell {
            a: 1.0,
            b: 3.0,
            pole_a: Some(1),
            pole_b: Some(2),
        };
        let root = root_in_cell(&h, cell, false);
        let (before, after) = (root * (1.0 - 1e-14), root * (1.0 + 1e-14));
        assert!(h.value(before) < 0.0 && h.value(after) > 0.0);
    }
}
