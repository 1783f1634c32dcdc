//! Bounds of f(x) = Σ c_r / (λ_r − x) + d, f' and f'' over a cell that holds no pole inside.
//!
//! About the middle m of the cell, with half-width δ and s_r = 1 / (λ_r − m),
//!
//! ```text
//! Σ c_r / (λ_r − x) = Σ_j a_j (x − m)^j,    a_j = Σ_r c_r s_r^(j+1),    |x − m| <= δ < 1 / |s_r|
//! ```
//!
//! is cut after [`ORDER`] terms; the rest is bounded term by term by a geometric series in ρ_r = δ |s_r|.
//! The a_j carry the cancellation between the terms, so the bounds are as narrow as f itself varies,
//! however small f is against its terms. A pole at an end of the cell is kept out of the series: its
//! term is monotone, and its end values bound it.

use super::receptance::Receptance;

/// Terms kept of the series.
const ORDER: usize = 8;

/// A cell between or beside poles; a pole at an end is named by its index.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Left end.
    pub a: f64,
    /// Right end.
    pub b: f64,
    /// Pole at the left end.
    pub pole_a: Option<usize>,
    /// Pole at the right end.
    pub pole_b: Option<usize>,
}

impl Cell {
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
        Self { b: x, pole_b: None, ..self }
    }

    /// Part of the cell right of `x`.
    pub fn right_of(self, x: f64) -> Self {
        Self { a: x, pole_a: None, ..self }
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
    fn about(centre: f64, spread: f64) -> Self {
        Self { low: centre - spread, high: centre + spread }
    }

    fn add_monotone(&mut self, at_a: f64, at_b: f64) {
        self.low += at_a.min(at_b);
        self.high += at_a.max(at_b);
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

/// Bounds over a cell.
#[derive(Debug, Clone, Copy)]
pub struct Enclosure {
    /// Of f.
    pub value: Range,
    /// Of f'.
    pub slope: Range,
    /// Of f'' / 2.
    pub curvature: Range,
    /// Rounding error of f in the cell.
    pub noise: f64,
}

impl Enclosure {
    /// Bounds of `h` over `cell`.
    pub fn of(h: &Receptance, cell: Cell) -> Self {
        let (middle, radius) = (0.5 * (cell.a + cell.b), 0.5 * (cell.b - cell.a));
        let mut a = [0.0; ORDER];
        let mut tail = [0.0; 3];
        let mut reciprocals = 0.0;
        for (r, (&pole, &c)) in h.poles.iter().zip(&h.residues).enumerate() {
            if cell.pole_a == Some(r) || cell.pole_b == Some(r) {
                continue;
            }
            let s = (pole - middle).recip();
            let mut term = c * s;
            for coefficient in &mut a {
                *coefficient += term;
                term *= s;
            }
            let rho = radius * s.abs();
            let rest = (1.0 - rho).max(f64::EPSILON).recip();
            let (p, last) = (ORDER as f64, rho.powi(ORDER as i32 - 2));
            let (c, s) = (c.abs(), s.abs());
            // Σ_{j>=p} ρ^j and its first and (halved) second derivatives by ρ.
            tail[0] += c * s * last * rho * rho * rest;
            tail[1] += c * s * s * last * rho * rest * (p + rho * rest);
            tail[2] += c * s * s * s * last * rest
                * (0.5 * p * (p - 1.0) + rho * rest * (p + rho * rest));
            reciprocals += s * rest;
        }
        let (mut spread, mut power) = (tail, 1.0);
        for j in 1..ORDER {
            let size = a[j].abs() * power;
            spread[0] += size * radius;
            if j >= 2 {
                spread[1] += j as f64 * size;
            }
            if j >= 3 {
                spread[2] += 0.5 * (j * (j - 1)) as f64 * a[j].abs() * power / radius;
            }
            power *= radius;
        }
        let mut out = Self {
            value: Range::about(a[0] + h.constant, spread[0]),
            slope: Range::about(a[1], spread[1]),
            curvature: Range::about(a[2], spread[2]),
            noise: f64::EPSILON * h.constant.abs() + h.residue_error * reciprocals,
        };
        for (end, at_left) in [(cell.pole_a, true), (cell.pole_b, false)] {
            if let Some(r) = end {
                out.add_end_pole(h, cell, r, at_left);
            }
        }
        out
    }

    fn add_end_pole(&mut self, h: &Receptance, cell: Cell, r: usize, at_left: bool) {
        let (pole, c) = (h.poles[r], h.residues[r]);
        let far = (pole - if at_left { cell.b } else { cell.a }).recip();
        let near = if at_left { f64::NEG_INFINITY } else { f64::INFINITY };
        self.value.add_monotone(c * near, c * far);
        self.slope.add_monotone(c * f64::INFINITY, c * far * far);
        self.curvature.add_monotone(c * near, c * far * far * far);
        self.noise += h.residue_error * far.abs();
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
        for (a, b, pole_a, pole_b) in [
            (1.0, 2.0, Some(0), Some(1)),
            (1.2, 1.4, None, None),
            (2.0, 2.5, Some(1), None),
            (3.0, 3.5, None, Some(2)),
            (7.5, 30.0, None, None),
        ] {
            let bounds = Enclosure::of(&h, Cell { a, b, pole_a, pole_b });
            for step in 1..200 {
                let x = a + (b - a) * f64::from(step) / 200.0;
                let (f, slope) = (h.value(x), h.slope(x));
                let bend: f64 =
                    h.poles.iter().zip(&h.residues).map(|(l, c)| c / (l - x).powi(3)).sum();
                for (range, v) in
                    [(bounds.value, f), (bounds.slope, slope), (bounds.curvature, bend)]
                {
                    let slack = 1e-12 * (1.0 + v.abs());
                    assert!(range.low <= v + slack && v - slack <= range.high, "{x} {v} {range:?}");
                }
            }
        }
        let width = |r: Range| r.high - r.low;
        let at = |half: f64| {
            let cell = Cell { a: 1.3 - half, b: 1.3 + half, pole_a: None, pole_b: None };
            width(Enclosure::of(&h, cell).value)
        };
        assert!(at(0.005) < 0.2 * at(0.05));
    }
}
