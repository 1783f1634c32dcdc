//! An interval of x = ω² without a pole inside: between neighbouring poles, beside one, or a part of these.

use crate::modal::receptance::Receptance;

/// A cell between or beside poles.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Left end.
    pub a: f64,
    /// Right end.
    pub b: f64,
    /// Number of poles at or left of `a`.
    pub below: usize,
    /// Whether the last of them lies at `a`.
    pub pole_a: bool,
    /// Whether the next pole lies at `b`.
    pub pole_b: bool,
}

impl Cell {
    /// Indices of the poles at the ends.
    pub fn ends(self) -> [Option<usize>; 2] {
        [
            self.pole_a.then(|| self.below - 1),
            self.pole_b.then_some(self.below),
        ]
    }

    /// Residues of the poles at the ends, zero where there is none.
    pub fn end_residues(self, h: &Receptance) -> [f64; 2] {
        self.ends().map(|end| end.map_or(0.0, |r| h.residues[r]))
    }

    /// Arithmetic middle, or the geometric one where the cell spans orders of magnitude.
    pub fn middle(self) -> f64 {
        if self.a > 0.0 && self.b > 4.0 * self.a {
            self.a.sqrt() * self.b.sqrt()
        } else {
            0.5 * (self.a + self.b)
        }
    }

    /// Part of the cell left of `x`.
    pub fn left_of(self, x: f64) -> Self {
        Self {
            b: x,
            pole_b: false,
            ..self
        }
    }

    /// Part of the cell right of `x`.
    pub fn right_of(self, x: f64) -> Self {
        Self {
            a: x,
            pole_a: false,
            ..self
        }
    }

    /// True when the cell is a few ulp wide.
    pub fn is_narrow(self) -> bool {
        self.b - self.a <= 8.0 * f64::EPSILON * self.b.abs().max(self.a.abs())
    }
}
