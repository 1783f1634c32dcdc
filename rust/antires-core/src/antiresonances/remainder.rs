//! The partial fractions of H without the poles at the ends of a cell, laid out for loops without branches.
//!
//! ```text
//! g(x) = Σ c_r / (λ_r − x) + d,    λ_r not at an end of the cell
//! ```
//!
//! A pole that is left out is moved to infinity with the residue 0, and so is the padding to whole lanes:
//! its terms vanish by themselves. Sums run in four lanes, the same on every machine.

use super::cell::Cell;
use crate::linalg::wide::{LANES, total};
use crate::modal::receptance::Receptance;

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
        Jet {
            value: total(value) + self.constant,
            slope: total(slope),
            bend: 2.0 * total(bend),
        }
    }
}
