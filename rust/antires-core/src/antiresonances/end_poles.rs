//! The poles at the ends of a cell, whose part of f is known in closed form.
//!
//! Over a cell of width w with poles at both ends, t = x − λ_a and A, B the moduli of the residues, their part
//! has a closed least value,
//!
//! ```text
//! min over 0 < t < w of  A / t^p + B / (w − t)^p  =  (A^(1/(p+1)) + B^(1/(p+1)))^(p+1) / w^p
//!                                                 >= (A + B + (2^(p+1) − 2) √(AB)) / w^p
//! ```
//!
//! with p = 1, 2, 3 for f, f' and f''/2, wherever the two terms have one sign. The second line, equal for A
//! = B, follows from a + b >= 2 √(ab) for the mixed terms in pairs, and needs one root.

use super::cell::Cell;
use super::range::Range;
use crate::modal::receptance::Receptance;

/// Residues of the poles at the ends of a cell of width w; zero where there is none.
#[derive(Debug, Clone, Copy)]
pub struct EndPoles {
    left: f64,
    right: f64,
    width: f64,
}

impl EndPoles {
    /// Those of `cell`.
    pub fn of(h: &Receptance, cell: Cell) -> Self {
        let [left, right] = cell.end_residues(h);
        Self {
            left,
            right,
            width: cell.b - cell.a,
        }
    }

    /// Sum of 1 / |λ − x| of the end poles at their far ends.
    pub fn reach(self) -> f64 {
        f64::from(u8::from(self.left != 0.0) + u8::from(self.right != 0.0)) / self.width
    }

    /// Adds the range of the end terms of f (P = 1), f' (P = 2) or f''/2 (P = 3).
    pub fn add<const P: i32>(self, range: &mut Range) {
        // Left of x, λ − x = −t is negative: odd powers change the sign.
        let left = if P == 2 { self.left } else { -self.left };
        let right = self.right;
        let scale = self.width.powi(P).recip();
        if left * right > 0.0 {
            // The least value, from below.
            let (a, b) = (left.abs(), right.abs());
            let mixed = [2.0, 6.0, 14.0][P as usize - 1] * (a * b).sqrt();
            range.add_beyond(((a + b + mixed) * scale).copysign(left));
        } else {
            for term in [left, right] {
                if term != 0.0 {
                    range.add_beyond(term * scale);
                }
            }
        }
    }
}
