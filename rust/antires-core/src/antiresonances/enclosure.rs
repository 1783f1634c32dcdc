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
//! The poles at the ends of the cell stay out of the series; their part is added by [`EndPoles`].

use super::cell::Cell;
use super::end_poles::EndPoles;
use super::range::Range;
use super::remainder::{Lanes, Remainder};
use crate::linalg::wide::{self, LANES, NullaryFnOnce, total};
use crate::modal::receptance::Receptance;

/// Bounds over a cell.
#[derive(Debug, Clone, Copy)]
pub struct Enclosure {
    value: Range,
    noise: f64,
    slope: Range,
    curvature: Range,
    ends: EndPoles,
}

impl Enclosure {
    /// Bounds of `h` over `cell` from `ORDER` terms of the series; `rest` is `h` without the poles at the
    /// ends. Few terms do between poles; more are needed where f is small against its partial fractions.
    pub fn of<const ORDER: usize>(h: &Receptance, rest: &Remainder, cell: Cell) -> Self {
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

    /// Bounds of f.
    pub fn value(&self) -> Range {
        self.value
    }

    /// Rounding error of f in the cell.
    pub fn noise(&self) -> f64 {
        self.noise
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
    rest: &'a Remainder,
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
        let mut rest = Remainder::default();
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
                    (bounds.value(), f),
                    (bounds.slope(), slope),
                    (bounds.curvature(), bend),
                    (fine.value(), f),
                    (fine.slope(), slope),
                    (fine.curvature(), bend),
                ] {
                    let slack = 1e-12 * (1.0 + v.abs());
                    assert!(
                        range.low() <= v + slack && v - slack <= range.high(),
                        "{x} {v} {range:?}"
                    );
                }
            }
        }
        let width = |r: Range| r.high() - r.low();
        let at = |half: f64| {
            let cell = Cell {
                a: 1.3 - half,
                b: 1.3 + half,
                below: 1,
                pole_a: false,
                pole_b: false,
            };
            width(Enclosure::of::<5>(&h, &rest, cell).value())
        };
        assert!(at(0.005) < 0.2 * at(0.05));
    }
}
