//! An interval of x = ω² without a pole inside: between neighbouring poles, beside one, or a part of these.
//!
//! # remainder
//!
//! The partial fractions of H without the poles at the ends of a cell, laid out for loops without branches.
//!
//! ```text
//! g(x) = Σ c_r / (λ_r − x) + d,    λ_r not at an end of the cell
//! ```
//!
//! A pole that is left out is moved to infinity with the residue 0, and so is the padding to whole lanes:
//! its terms vanish by themselves. Sums run in four lanes, the same on every machine.
//!
//! # end_poles
//!
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
//!
//! # enclosure
//!
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
//!
//! # screening
//!
//! Screening of the cells between neighbouring poles: bounds of f and f' over each that cost little.
//!
//! Inside a cell from a to b every term of g, the part of f without the poles at the ends, is monotone, and
//! so is its derivative. With s = 1 / (λ − a) and t = 1 / (λ − b)
//!
//! ```text
//! |g  − Σ c_r (s + t)/2|   <= Σ |c_r| |s − t|/2
//! |g' − Σ c_r (s² + t²)/2| <= Σ |c_r| |s² − t²|/2
//! ```
//!
//! The factors do not depend on the residues. They are formed once for all responses that share their poles;
//! a response then costs some products a cell.
//!
//! # beyond_last_pole
//!
//! No root beyond the last pole: a certificate in O(n²).
//!
//! For x > λ_n, the identity 1/(x − λ) = 1/(x − μ) · (1 + (λ − μ)/(x − λ)), applied with
//! μ = λ_1, λ_2, ... in turn, turns the partial fractions into
//!
//! ```text
//! −f(x) = Σ_r c_r / (x − λ_r) = Σ_j D_j / Π_{i<=j} (x − λ_i),    D_j = Σ_{r>=j} c_r Π_{i<j} (λ_r − λ_i)
//! ```
//!
//! in which every product is positive. If the D_j that exceed their rounding have one sign, f has no
//! root there that survives rounding. (D_1 = Σ c = (M⁻¹)_ik and the next moments vanish when i and k
//! are far apart in a lumped chain: the small sums are left out of the vote.)

use crate::linalg::wide::{LANES, total, widest};
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
        [self.pole_a.then(|| self.below - 1), self.pole_b.then_some(self.below)]
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
        Self { b: x, pole_b: false, ..self }
    }

    /// Part of the cell right of `x`.
    pub fn right_of(self, x: f64) -> Self {
        Self { a: x, pole_a: false, ..self }
    }

    /// True when the cell is a few ulp wide.
    pub fn is_narrow(self) -> bool {
        self.b - self.a <= 8.0 * f64::EPSILON * self.b.abs().max(self.a.abs())
    }
}

// ---- range

/// Multiple of its rounding error below which a value is drowned in it.
const DROWNED: f64 = 4.0;

/// A sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Below zero.
    Negative,
    /// Above zero.
    Positive,
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
        Self { low: centre - spread, high: centre + spread }
    }

    /// Adds a term that ranges from `nearest` away from zero, to infinity.
    pub(super) fn add_beyond(&mut self, nearest: f64) {
        if nearest > 0.0 {
            self.low += nearest;
            self.high = f64::INFINITY;
        } else {
            self.high += nearest;
            self.low = f64::NEG_INFINITY;
        }
    }

    /// The one sign of all values, when zero is excluded by more than `pad`.
    pub fn sign(self, pad: f64) -> Option<Sign> {
        if self.low > pad {
            Some(Sign::Positive)
        } else if self.high < -pad {
            Some(Sign::Negative)
        } else {
            None
        }
    }

    /// Whether all values are drowned in a rounding error of `noise`.
    pub fn is_drowned(self, noise: f64) -> bool {
        self.magnitude() <= DROWNED * noise
    }

    /// Whether some value is not.
    pub fn stands_out(self, noise: f64) -> bool {
        self.magnitude() > DROWNED * noise
    }

    /// Largest modulus in the range.
    fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

// ---- remainder

/// Four partial sums.
pub type Lanes = [f64; LANES];

/// Poles and residues of a receptance, padded.
#[derive(Debug, Clone, Default)]
pub struct Remainder {
    poles: Vec<f64>,
    residues: Vec<f64>,
    constant: f64,
}

/// g, g' and g'' at a point.
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    /// g.
    pub value: f64,
    /// g'.
    pub slope: f64,
    /// g''.
    pub bend: f64,
}

impl Remainder {
    /// Takes all poles of `h`.
    pub fn set(&mut self, h: &Receptance) {
        let padded = h.poles.len().next_multiple_of(LANES);
        self.poles.clear();
        self.poles.extend_from_slice(&h.poles);
        self.poles.resize(padded, f64::INFINITY);
        self.residues.clear();
        self.residues.extend_from_slice(&h.residues);
        self.residues.resize(padded, 0.0);
        self.constant = h.constant;
    }

    /// Leaves the poles at the ends of `cell` out.
    pub fn leave_out(&mut self, cell: Cell) {
        for r in cell.ends().into_iter().flatten() {
            (self.poles[r], self.residues[r]) = (f64::INFINITY, 0.0);
        }
    }

    /// Takes the poles at the ends of `cell` back.
    pub fn take_back(&mut self, h: &Receptance, cell: Cell) {
        for r in cell.ends().into_iter().flatten() {
            (self.poles[r], self.residues[r]) = (h.poles[r], h.residues[r]);
        }
    }

    /// Poles and residues in whole lanes.
    #[inline(always)]
    pub fn lanes(&self) -> impl Iterator<Item = (&Lanes, &Lanes)> {
        let (poles, _) = self.poles.as_chunks::<LANES>();
        let (residues, _) = self.residues.as_chunks::<LANES>();
        poles.iter().zip(residues)
    }

    /// g, g' and g'' at `x`.
    #[inline(always)]
    pub fn at(&self, x: f64) -> Jet {
        let (mut value, mut slope, mut bend) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (poles, residues) in self.lanes() {
            for l in 0..LANES {
                let s = (poles[l] - x).recip();
                let term = residues[l] * s;
                value[l] += term;
                slope[l] += term * s;
                bend[l] += term * s * s;
            }
        }
        Jet { value: total(value) + self.constant, slope: total(slope), bend: 2.0 * total(bend) }
    }
}

// ---- end_poles

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
        Self { left, right, width: cell.b - cell.a }
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

// ---- enclosure

/// Bounds over a cell.
#[derive(Debug, Clone, Copy)]
pub struct Enclosure {
    /// Bounds of f.
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
    pub fn of<const ORDER: usize>(h: &Receptance, rest: &Remainder, cell: Cell) -> Self {
        let (middle, radius) = (0.5 * (cell.a + cell.b), 0.5 * (cell.b - cell.a));
        let (series, tails) = series([[0.0; LANES]; ORDER], rest, cell, middle, radius);
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

widest!(
    /// Coefficients a_j of the series about the middle of a cell, added to `series`, and of the rest of f, f', f''/2 and
    /// of the reciprocals, lane by lane.
    fn series<const ORDER: usize>(
        series: [Lanes; ORDER],
        rest: &Remainder,
        cell: Cell,
        middle: f64,
        radius: f64,
    ) -> ([Lanes; ORDER], [Lanes; 4]) {
        let mut series = series;
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
                // 1 / (1 − ρ): in a cell as wide as that beyond the last pole ρ is one but for rounding.
                let away = (cell.a - poles[l]).max(poles[l] - cell.b);
                let beyond = (s * away).max(f64::MIN_POSITIVE).recip();
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
);

// ---- screening

/// Rows of factors for each lane of poles.
const ROWS: usize = 5;

/// Cells of one set of poles, with the factors of their bounds.
#[derive(Debug, Clone, Default)]
pub struct Screening {
    poles: Vec<f64>,
    low: f64,
    ceiling: f64,
    /// Ascending.
    pub cells: Vec<Cell>,
    /// Σ 1 / |λ − x| at most, a cell each.
    reach: Vec<f64>,
    /// (s + t)/2, |s − t|/2, (s² + t²)/2, |s² − t²|/2 and 1 / (λ − middle), lane by lane, cell by cell.
    factors: Vec<[Lanes; ROWS]>,
}

/// What the screening tells of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// f has no root.
    Rootless,
    /// f is monotone.
    Monotone,
    /// Nothing.
    Unclear,
}

impl Screening {
    /// Forms the cells of the poles of `h` from `low` to `ceiling`, unless it has them.
    pub fn prepare(&mut self, h: &Receptance, low: f64, ceiling: f64) {
        if self.poles == h.poles && self.low == low && self.ceiling == ceiling {
            return;
        }
        self.poles.clone_from(&h.poles);
        (self.low, self.ceiling) = (low, ceiling);
        self.form_cells();
        self.form_factors();
    }

    fn form_cells(&mut self) {
        self.cells.clear();
        let mut cell = Cell {
            a: self.low,
            b: self.ceiling,
            below: self.poles.partition_point(|&pole| pole < self.low),
            pole_a: false,
            pole_b: true,
        };
        for &pole in &self.poles[cell.below..] {
            if pole >= self.ceiling {
                break;
            }
            if pole > self.low {
                self.cells.push(Cell { b: pole, ..cell });
            }
            (cell.a, cell.below, cell.pole_a) = (pole, cell.below + 1, true);
        }
        if cell.a < self.ceiling {
            // Where a pole lies at the ceiling or above, its term is one of the rest.
            self.cells.push(Cell { b: self.ceiling, pole_b: false, ..cell });
        }
    }

    fn form_factors(&mut self) {
        self.factors.clear();
        self.reach.clear();
        for &cell in &self.cells {
            let (a, b, middle) = (cell.a, cell.b, 0.5 * (cell.a + cell.b));
            let ends = cell.ends();
            let mut reach = [0.0; LANES];
            for (chunk, poles) in self.poles.chunks(LANES).enumerate() {
                let mut rows = [[0.0; LANES]; ROWS];
                for (l, &pole) in poles.iter().enumerate() {
                    if ends.contains(&Some(LANES * chunk + l)) {
                        continue;
                    }
                    let (s, t) = ((pole - a).recip(), (pole - b).recip());
                    rows[0][l] = 0.5 * (s + t);
                    rows[1][l] = 0.5 * (s - t).abs();
                    rows[2][l] = 0.5 * (s * s + t * t);
                    rows[3][l] = 0.5 * (s * s - t * t).abs();
                    rows[4][l] = (pole - middle).recip();
                    reach[l] += s.abs().max(t.abs());
                }
                self.factors.push(rows);
            }
            self.reach.push(total(reach));
        }
    }

    /// Value of g in the middle of a cell.
    pub fn middle(&self, index: usize, h: &Receptance, all: &Remainder) -> f64 {
        let mut sums = [0.0; LANES];
        for (rows, (_, residues)) in self.factors_of(index).iter().zip(all.lanes()) {
            for l in 0..LANES {
                sums[l] += residues[l] * rows[4][l];
            }
        }
        total(sums) + h.constant
    }

    fn factors_of(&self, index: usize) -> &[[Lanes; ROWS]] {
        let chunks = self.poles.len().div_ceil(LANES);
        &self.factors[index * chunks..(index + 1) * chunks]
    }

    /// What the bounds over a cell tell of `h`, which `all` holds without a pole left out.
    pub fn verdict(&self, index: usize, h: &Receptance, all: &Remainder) -> Verdict {
        let mut sums = [[0.0; LANES]; 4];
        for (rows, (_, residues)) in self.factors_of(index).iter().zip(all.lanes()) {
            for l in 0..LANES {
                let (c, size) = (residues[l], residues[l].abs());
                sums[0][l] += c * rows[0][l];
                sums[1][l] += size * rows[1][l];
                sums[2][l] += c * rows[2][l];
                sums[3][l] += size * rows[3][l];
            }
        }
        let [value, value_spread, slope, slope_spread] = sums.map(total);
        let mut value = Range::about(value + h.constant, value_spread);
        let mut slope = Range::about(slope, slope_spread);
        let ends = EndPoles::of(h, self.cells[index]);
        ends.add::<1>(&mut value);
        ends.add::<2>(&mut slope);
        let reach = self.reach[index] + ends.reach();
        let noise = f64::EPSILON * h.constant.abs() + h.floor_error + h.residue_error * reach;
        if slope.sign(h.residue_error * reach * reach).is_some() && value.stands_out(noise) {
            return Verdict::Monotone;
        }
        match value.sign(noise) {
            Some(_) => Verdict::Rootless,
            None => Verdict::Unclear,
        }
    }
}

// ---- beyond_last_pole

/// True when `h` is proved to have no root above its last pole. False means "not proved".
pub fn is_rootless(h: &Receptance, scratch: &mut Vec<f64>) -> bool {
    if h.constant != 0.0 {
        return false;
    }
    let n = h.poles.len();
    // The first n entries hold c_r Π (λ_r − λ_i), the others their error, both up to a common scale.
    scratch.clear();
    scratch.extend_from_slice(&h.residues);
    scratch.resize(2 * n, h.residue_error);
    let (terms, errors) = scratch.split_at_mut(n);
    let span = h.poles[n - 1] - h.poles[0];
    let mut vote = 0.0_f64;
    for j in 0..n {
        let (mut sum, mut error) = (0.0, 0.0);
        for r in j..n {
            sum += terms[r];
            error += errors[r];
            // Relative to the span, the products stay in the range of doubles.
            let factor = (h.poles[r] - h.poles[j]) / span;
            terms[r] *= factor;
            errors[r] *= factor;
        }
        if sum.abs() > error {
            if sum * vote < 0.0 {
                return false;
            }
            vote = sum;
        }
    }
    vote != 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy() -> Receptance {
        Receptance {
            poles: vec![1.0, 2.0, 3.5, 7.0],
            residues: vec![0.3, -0.7, 0.5, -0.1],
            constant: 0.05,
            ..Receptance::default()
        }
    }

    #[test]
    fn bounds_hold_over_the_cell_and_shrink_with_it() {
        let h = wavy();
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
            let cell = Cell { a, b, below, pole_a, pole_b };
            rest.leave_out(cell);
            let bounds = Enclosure::of::<5>(&h, &rest, cell);
            let fine = Enclosure::of::<9>(&h, &rest, cell);
            rest.take_back(&h, cell);
            for step in 1..200 {
                let x = a + (b - a) * f64::from(step) / 200.0;
                let (f, slope) = (h.value(x), h.slope(x));
                let bend: f64 = h.poles.iter().zip(&h.residues).map(|(l, c)| c / (l - x).powi(3)).sum();
                for (range, v) in [
                    (bounds.value, f),
                    (bounds.slope(), slope),
                    (bounds.curvature(), bend),
                    (fine.value, f),
                    (fine.slope(), slope),
                    (fine.curvature(), bend),
                ] {
                    let slack = 1e-12 * (1.0 + v.abs());
                    assert!(range.low <= v + slack && v - slack <= range.high, "{x} {v} {range:?}");
                }
            }
        }
        let width = |r: Range| r.high - r.low;
        let at = |half: f64| {
            let cell = Cell { a: 1.3 - half, b: 1.3 + half, below: 1, pole_a: false, pole_b: false };
            width(Enclosure::of::<5>(&h, &rest, cell).value)
        };
        assert!(at(0.005) < 0.2 * at(0.05));
    }

    fn signed(residues: &[f64]) -> Receptance {
        Receptance {
            poles: vec![1.0, 2.0, 3.5, 7.0, 9.0],
            residues: residues.to_vec(),
            constant: 0.05,
            ..Receptance::default()
        }
    }

    #[test]
    fn what_is_seen_is_so() {
        let mut screening = Screening::default();
        let mut all = Remainder::default();
        let (mut rootless, mut monotone) = (0, 0);
        for signs in 0..32 {
            let sized = [0.3, 0.7, 0.5, 0.1, 0.4];
            let residues: Vec<f64> =
                (0..5).map(|r| if signs >> r & 1 == 0 { sized[r] } else { -sized[r] }).collect();
            let h = signed(&residues);
            screening.prepare(&h, 0.0, 30.0);
            all.set(&h);
            assert_eq!(screening.cells.len(), 6);
            for index in 0..6 {
                let cell = screening.cells[index];
                let inside = |j: i32| cell.a + (cell.b - cell.a) * f64::from(j) / 400.0;
                let slopes = (1..400).map(|j| h.slope(inside(j)) > 0.0);
                let signs = (1..400).map(|j| h.value(inside(j)) > 0.0);
                match screening.verdict(index, &h, &all) {
                    Verdict::Rootless => {
                        rootless += 1;
                        assert!(signs.clone().all(|s| s) || !signs.clone().any(|s| s));
                    }
                    Verdict::Monotone => {
                        monotone += 1;
                        assert!(slopes.clone().all(|s| s) || !slopes.clone().any(|s| s));
                    }
                    Verdict::Unclear => {}
                }
            }
        }
        assert!(rootless > 40 && monotone > 40, "{rootless} {monotone}");
    }

    fn receptance(poles: &[f64], residues: &[f64]) -> Receptance {
        Receptance {
            poles: poles.to_vec(),
            residues: residues.to_vec(),
            residue_error: 1e-16,
            ..Receptance::default()
        }
    }

    #[test]
    fn proves_what_is_rootless_and_nothing_else() {
        let mut scratch = Vec::new();
        assert!(is_rootless(&receptance(&[1.0, 2.0], &[0.5, 0.5]), &mut scratch));
        assert!(is_rootless(&receptance(&[1.0, 2.0], &[-1.0, 1.0]), &mut scratch));
        // −1.5/(1−x) + 1/(2−x) vanishes at x = 4.
        let crossing = receptance(&[1.0, 2.0], &[-1.5, 1.0]);
        assert_eq!(crossing.value(4.0), 0.0);
        assert!(!is_rootless(&crossing, &mut scratch));
    }
}
