//! Modes below a limit that a load does not excite: a node at the excitation, or the other combinations of a
//! repeated eigenvalue, of which any load excites one only.
//!
//! They are sought in the complement of those found, from starts of fixed pseudo-random numbers, until the
//! count by inertia is met.

use super::poles::Poles;
use super::scaled::ScaledMatrices;
use super::settled::FOUND;
use crate::linalg::krylov::{Krylov, Operator, Start};

/// In whose complement hidden modes are sought.
pub(super) struct Outside<'a> {
    /// With the factors of K + σM.
    pub matrices: &'a ScaledMatrices,
    /// The poles of the load.
    pub poles: &'a Poles,
    /// Only modes below this count.
    pub cut: f64,
}

/// The hidden modes, with the memory to find them again.
#[derive(Default)]
pub(super) struct HiddenModes {
    krylov: Krylov,
    lambda: Vec<f64>,
    /// M v and v of the shown modes, then of the hidden ones; nothing where none is hidden.
    weighted: Vec<f64>,
    vectors: Vec<f64>,
}

impl HiddenModes {
    pub fn clear(&mut self) {
        self.lambda.clear();
        self.weighted.clear();
        self.vectors.clear();
    }

    /// Their eigenvalues.
    pub fn lambda(&self) -> &[f64] {
        &self.lambda
    }

    /// Vectors of the shown modes, then of the hidden ones, by rows; empty where none is hidden.
    pub fn vectors(&self) -> &[f64] {
        &self.vectors
    }

    /// Finds `missing` modes; false where they do not come out as many.
    pub fn find(&mut self, outside: &Outside<'_>, missing: usize) -> bool {
        let Outside {
            matrices,
            poles,
            cut,
        } = *outside;
        let (mass, sigma) = (matrices.mass(), poles.sigma());
        let shown = poles.found().iter().enumerate().filter(|(_, f)| **f);
        for (j, _) in shown {
            poles.vector(j, mass, &mut self.weighted, &mut self.vectors);
        }
        let least = (cut + sigma).recip();
        let mut state = 1_u64;
        while self.lambda.len() < missing {
            let mut load = vec![0.0; matrices.stride()];
            for x in &mut load[..mass.n()] {
                // The 64-bit congruential generator of Knuth, MMIX.
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                *x = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            }
            let mut start = vec![0.0; load.len()];
            mass.multiply(&load, &mut start);
            start[mass.n()..].fill(0.0);
            let op = Operator {
                shifted: matrices.factors(),
                mass,
                outside: (&self.weighted, &self.vectors),
            };
            let (load, highest) = ((&start[..], Start::Response), poles.highest());
            if !self.krylov.grow(op, load, highest, mass.n(), |_| true) {
                return false;
            }
            let before = self.lambda.len();
            for (j, &t) in self.krylov.theta().iter().enumerate() {
                if t >= least && self.krylov.residual(j) <= FOUND * t {
                    self.lambda.push(t.recip() - sigma);
                    self.krylov.vector(j, &mut self.weighted, &mut self.vectors);
                }
            }
            if self.lambda.len() == before {
                return false;
            }
        }
        self.lambda.len() == missing
    }
}
