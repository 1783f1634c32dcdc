//! Bounds of f(x) = Σ c_r / (λ_r − x) + d, f' and f'' over a cell that holds no pole inside.
//!
//! About the middle m of the cell, with half-width δ and s_r = 1 / (λ_r − m),
//!
//! ```text
//! Σ c_r / (λ_r − x) = Σ_j a_j (x − m)^j,    a_j = Σ_r c_r s_r^(j+1),    |x − m| <= δ < 1 / |s_r|
//! ```
//!
//! is cut after a few terms; the rest is bounded term by term by a geometric series in ρ_r = δ |s_r|.
//! The a_j carry the cancellation between the terms, so the bounds are as narrow as f itself varies,
//! however small f is against its terms.
//!
//! The poles at the ends of the cell stay out of the series. Over a cell of width w with poles at both
//! ends, t = x − λ_a and A, B the moduli of the residues, their part has a closed least value,
//!
//! ```text
//! min over 0 < t < w of  A / t^p + B / (w − t)^p  =  (A^(1/(p+1)) + B^(1/(p+1)))^(p+1) / w^p
//!                                                 >= (A + B + (2^(p+1) − 2) √(AB)) / w^p
//! ```
//!
//! with p = 1, 2, 3 for f, f' and f''/2, wherever the two terms have one sign. The second line, equal for A
//! = B, follows from a + b >= 2 √(ab) for the mixed terms in pairs, and needs one root.

use crate::linalg::wide::NullaryFnOnce;

use super::receptance::Receptance;
use super::rest::{LANES, Lanes, Rest, total};
use crate::linalg::wide;

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

/// Lower and upper bounds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// All within `spread` of `centre`.
    pub fn about(centre: f64, spread: f64) -> Self {
        Self {
            low: centre - spread,
            high: centre + spread,
        }
    }

    /// Adds a term that ranges from `nearest` away from zero, to infinity.
    fn add_beyond(&mut self, nearest: f64) {
        if nearest > 0.0 {
            self.low += nearest;
            self.high = f64::INFINITY;
        } else {
            self.high += nearest;
            self.low = f64::NEG_INFINITY;
        }
    }

    /// Some(positive) when zero is excluded by more than `pad`.
    pub fn sign(self, pad: f64) -> Option<bool> {
        if self.low > pad {
            Some(true)
        } else if self.high < -pad {
            Some(false)
        } else {
            None
        }
    }

    /// Largest modulus in the range.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// Multiple of its rounding error below which f is drowned in it.
pub const DROWNED: f64 = 4.0;

/// Bounds over a cell.
#[derive(Debug, Clone, Copy)]
pub struct Enclosure {
    /// Of f.
    pub value: Range,
    /// Rounding error of f in the cell.
    pub noise: f64,
    slope: Range,
    curvature: Range,
    ends: EndPoles,
}

impl Enclosure {
    /// Bounds of `h` over `cell` from `ORDER` terms of the series; `rest` is `h` without the poles at the
    /// ends. Few terms do between poles; more are needed where f is small against its partial fractions.
    pub fn of<const ORDER: usize>(h: &Receptance, rest: &Rest, cell: Cell) -> Self {
        let (middle, radius) = (0.5 * (cell.a + cell.b), 0.5 * (cell.b - cell.a));
        let (series, tails) = wide::run(Series::<ORDER> {
            rest,
            middle,
            radius,
        });
        let a = series.map(total);
        let [t0, t1, t2, reciprocals] = tails.map(total);
        let tail = [t0, t1, t2];
        let (mut spread, mut power) = (tail, 1.0);
        for j in 1..ORDER {
            let size = a[j].abs() * power;
            spread[0] += size * radius;
            if j >= 2 {
                spread[1] += j as f64 * size;
            }
            if j >= 3 {
                spread[2] += 0.5 * (j * (j - 1)) as f64 * size / radius;
            }
            power *= radius;
        }
        let ends = EndPoles::of(h, cell);
        let mut value = Range::about(a[0] + h.constant, spread[0]);
        ends.add::<1>(&mut value);
        Self {
            value,
            noise: f64::EPSILON * h.constant.abs()
                + h.floor_error
                + h.residue_error * (reciprocals + ends.reach()),
            slope: Range::about(a[1], spread[1]),
            curvature: Range::about(a[2], spread[2]),
            ends,
        }
    }

    /// Bounds of f'.
    pub fn slope(&self) -> Range {
        let mut range = self.slope;
        self.ends.add::<2>(&mut range);
        range
    }

    /// Bounds of f''/2.
    pub fn curvature(&self) -> Range {
        let mut range = self.curvature;
        self.ends.add::<3>(&mut range);
        range
    }
}

/// Coefficients a_j of the series about the middle of a cell, and of the rest of f, f', f''/2 and of the
/// reciprocals, lane by lane.
struct Series<'a, const ORDER: usize> {
    rest: &'a Rest,
    middle: f64,
    radius: f64,
}

impl<const ORDER: usize> NullaryFnOnce for Series<'_, ORDER> {
    type Output = ([Lanes; ORDER], [Lanes; 4]);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self {
            rest,
            middle,
            radius,
        } = self;
        let mut series = [[0.0; LANES]; ORDER];
        let mut tails = [[0.0; LANES]; 4];
        let p = ORDER as f64;
        for (poles, residues) in rest.lanes() {
            for l in 0..LANES {
                let s = (poles[l] - middle).recip();
                let mut term = residues[l] * s;
                let size = term.abs();
                for coefficient in &mut series {
                    coefficient[l] += term;
                    term *= s;
                }
                let s = s.abs();
                let rho = radius * s;
                let beyond = (1.0 - rho).max(f64::EPSILON).recip();
                let mut last = size * beyond;
                for _ in 2..ORDER {
                    last *= rho;
                }
                // Σ_{j>=p} ρ^j and its first and (halved) second derivatives by ρ.
                let grown = rho * (p + rho * beyond);
                tails[0][l] += last * rho * rho;
                tails[1][l] += last * s * grown;
                tails[2][l] += last * s * s * (0.5 * p * (p - 1.0) + beyond * grown);
                tails[3][l] += s * beyond;
            }
        }
        (series, tails)
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn receptance() -> Receptance {
        Receptance {
            poles: vec![1.0, 2.0, 3.5, 7.0],
            residues: vec![0.3, -0.7, 0.5, -0.1],
            constant: 0.05,
            ..Receptance::default()
        }
    }

    #[test]
    fn bounds_hold_over_the_cell_and_shrink_with_it() {
        let h = receptance();
        let mut rest = Rest::default();
        rest.set(&h);
        for (a, b, below, pole_a, pole_b) in [
            (1.0, 2.0, 1, true, true),
            (2.0, 3.5, 2, true, true),
            (3.5, 7.0, 3, true, true),
            (1.2, 1.4, 1, false, false),
            (2.0, 2.5, 2, true, false),
            (3.0, 3.5, 2, false, true),
            (7.5, 30.0, 4, false, false),
        ] {
            let cell = Cell {
                a,
                b,
                below,
                pole_a,
                pole_b,
            };
            rest.leave_out(cell);
            let bounds = Enclosure::of::<5>(&h, &rest, cell);
            let fine = Enclosure::of::<9>(&h, &rest, cell);
            rest.take_back(&h, cell);
            for step in 1..200 {
                let x = a + (b - a) * f64::from(step) / 200.0;
                let (f, slope) = (h.value(x), h.slope(x));
                let bend: f64 = h
                    .poles
                    .iter()
                    .zip(&h.residues)
                    .map(|(l, c)| c / (l - x).powi(3))
                    .sum();
                for (range, v) in [
                    (bounds.value, f),
                    (bounds.slope(), slope),
                    (bounds.curvature(), bend),
                    (fine.value, f),
                    (fine.slope(), slope),
                    (fine.curvature(), bend),
                ] {
                    let slack = 1e-12 * (1.0 + v.abs());
                    assert!(
                        range.low <= v + slack && v - slack <= range.high,
                        "{x} {v} {range:?}"
                    );
                }
            }
        }
        let width = |r: Range| r.high - r.low;
        let at = |half: f64| {
            let cell = Cell {
                a: 1.3 - half,
                b: 1.3 + half,
                below: 1,
                pole_a: false,
                pole_b: false,
            };
            width(Enclosure::of::<5>(&h, &rest, cell).value)
        };
        assert!(at(0.005) < 0.2 * at(0.05));
    }
}
