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

use super::cell::Cell;
use super::end_poles::EndPoles;
use super::range::Range;
use super::remainder::{Lanes, Remainder};
use crate::linalg::wide::{LANES, total};
use crate::modal::receptance::Receptance;

/// Rows of factors for each lane of poles.
const ROWS: usize = 5;

/// Cells of one set of poles, with the factors of their bounds.
#[derive(Debug, Clone, Default)]
pub struct Screening {
    poles: Vec<f64>,
    low: f64,
    ceiling: f64,
    cells: Vec<Cell>,
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
            self.cells.push(Cell {
                b: self.ceiling,
                pole_b: false,
                ..cell
            });
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

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.cells.len()
    }

    /// A cell.
    pub fn cell(&self, index: usize) -> Cell {
        self.cells[index]
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

#[cfg(test)]
mod tests {
    use super::*;

    fn receptance(residues: &[f64]) -> Receptance {
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
            let residues: Vec<f64> = (0..5)
                .map(|r| {
                    if signs >> r & 1 == 0 {
                        sized[r]
                    } else {
                        -sized[r]
                    }
                })
                .collect();
            let h = receptance(&residues);
            screening.prepare(&h, 0.0, 30.0);
            all.set(&h);
            assert_eq!(screening.n_cells(), 6);
            for index in 0..6 {
                let cell = screening.cell(index);
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
}
