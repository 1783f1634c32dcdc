//! How the antiresonances move with the model: dx/dp of a zero x = ω² of H_ik.
//!
//! With h_i = (K − xM)⁻¹ e_i, the column of the receptance matrix, a change of the model at a zero
//! (H_ik = 0) gives
//!
//! ```text
//! dH_ik = −h_iᵀ (dK − x dM − dx M) h_k = 0
//! dx/dp = h_iᵀ (dK/dp − x dM/dp) h_k / (h_iᵀ M h_k),    h_iᵀ M h_k = dH_ik/dx
//! ```
//!
//! h_k without its entry i (which is H_ik = 0) and h_i without its entry k are the right and left null
//! vectors of the deleted pencil, so this is the sensitivity of its eigenvalue: one formula, two
//! readings. A factor on either column cancels. Of a minor det H[I, J] the second reading holds, with null vectors
//! combined of the columns of all responses and forces. On a pole, where K − xM is singular, the second reading holds.
//!
//! Source: J. He & Y. Q. Li, Relocation of anti-resonances of a vibratory system by local structural
//! changes, Int. J. Anal. Exp. Modal Anal. 10 (1995) 224-235; J. E. Mottershead, On the zeros of structural
//! frequency response functions and their sensitivities, Mech. Syst. Signal Process. 12 (1998) 591-597.
//!
//! # zero_batch
//!
//! Sensitivities of many zeros at once: each entry of dK/dp is read once for all of them.
//!
//! Null vectors stand side by side, those of one dof next to each other. Every sum has the order that
//! [`ZeroSensitivity::along`] adds in: the bits are the same.

use super::solver::Prepared;
use crate::error::Result;
use crate::fem::assembly::MatrixSlopes;
use crate::linalg::wide::widest;
use crate::modal::minor::Ends;

/// The null vectors of one zero, ready to be joined with any change of the model.
#[derive(Debug, Clone, Default)]
pub struct ZeroSensitivity {
    x: f64,
    /// Left null vector.
    pub left: Vec<f64>,
    /// Right null vector.
    pub right: Vec<f64>,
    /// dH_ik/dx, with the factors of the two vectors.
    pub slope: f64,
}

impl ZeroSensitivity {
    /// Takes up the zero `x` = ω² of H_ik.
    pub fn set(&mut self, prepared: &mut Prepared<'_>, ends: &Ends, x: f64) -> Result<()> {
        self.x = x;
        self.slope = prepared.columns(ends, x, &mut self.left, &mut self.right)?;
        Ok(())
    }

    /// Takes up a root `x` that cancels against a pole, see [`crate::modal::columns`].
    pub fn set_cancelled(&mut self, prepared: &mut Prepared<'_>, ends: &Ends, x: f64) -> Result<()> {
        self.x = x;
        self.slope = prepared.vectors_on_pole(ends, x, &mut self.left, &mut self.right)?;
        Ok(())
    }

    /// dx/dp in (rad/s)² per unit of p; not finite at a double zero, which has no derivative.
    pub fn along(&self, slopes: &MatrixSlopes) -> f64 {
        let join = |entries: &[(u32, u32, f64)]| -> f64 {
            let (left, right) = (&self.left, &self.right);
            entries.iter().map(|&(row, col, value)| left[row as usize] * value * right[col as usize]).sum()
        };
        (join(&slopes.stiffness) - self.x * join(&slopes.mass)) / self.slope
    }
}

// ---- zero_batch

/// Zeros side by side.
const WIDTH: usize = 32;

/// Null vectors of some zeros, each with what its derivatives belong to.
#[derive(Debug, Clone)]
pub struct ZeroBatch<T> {
    left: Vec<f64>,
    right: Vec<f64>,
    x: Vec<f64>,
    slope: Vec<f64>,
    owners: Vec<T>,
}

impl<T> Default for ZeroBatch<T> {
    fn default() -> Self {
        Self { left: Vec::new(), right: Vec::new(), x: Vec::new(), slope: Vec::new(), owners: Vec::new() }
    }
}

impl<T> ZeroBatch<T> {
    /// Adds a zero, which must not find the batch full.
    pub fn push(&mut self, zero: &ZeroSensitivity, owner: T) {
        let at = self.owners.len();
        for (all, own) in [(&mut self.left, &zero.left), (&mut self.right, &zero.right)] {
            all.resize(own.len() * WIDTH, 0.0);
            for (row, &value) in all.chunks_exact_mut(WIDTH).zip(own) {
                row[at] = value;
            }
        }
        self.x.push(zero.x);
        self.slope.push(zero.slope);
        self.owners.push(owner);
    }

    /// Whether it is time to ask and to [`clear`](Self::clear).
    pub fn is_full(&self) -> bool {
        self.owners.len() == WIDTH
    }

    /// Leaves no zero.
    pub fn clear(&mut self) {
        self.x.clear();
        self.slope.clear();
        self.owners.clear();
    }

    /// dx/dp of every zero with its owner, see [`ZeroSensitivity::along`].
    pub fn along(&self, slopes: &MatrixSlopes, mut visit: impl FnMut(&T, f64)) {
        if self.owners.is_empty() {
            return;
        }
        let join = |entries| join(entries, &self.left, &self.right);
        let (stiffness, mass) = (join(&slopes.stiffness), join(&slopes.mass));
        for (nth, owner) in self.owners.iter().enumerate() {
            let change = stiffness[nth] - self.x[nth] * mass[nth];
            visit(owner, change / self.slope[nth]);
        }
    }
}

widest!(
    /// Σ left · value · right of each zero.
    fn join(entries: &[(u32, u32, f64)], left: &[f64], right: &[f64]) -> [f64; WIDTH] {
        let (left, _) = left.as_chunks::<WIDTH>();
        let (right, _) = right.as_chunks::<WIDTH>();
        // What an empty iterator sums to.
        let mut sums = [-0.0; WIDTH];
        for &(row, column, value) in entries {
            let (l, r) = (&left[row as usize], &right[column as usize]);
            for z in 0..WIDTH {
                sums[z] += l[z] * value * r[z];
            }
        }
        sums
    }
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::antiresonances::{AntiresonanceSolver, Query, Route, ZeroSensitivity};
    use crate::fem::assembly::MatrixSlopes;
    use crate::fem::model::mass_spring_chain;
    use crate::modal::modes::eigenvalue;
    use crate::modal::structure::Structure;
    use std::sync::Arc;

    #[test]
    fn many_zeros_at_once_have_the_bits_of_one() {
        let masses: Vec<f64> = (0..60).map(|i| 1.0 + 0.01 * f64::from(i)).collect();
        let springs: Vec<f64> = (0..59).map(|i| 1e4 + 70.0 * f64::from(i)).collect();
        let model = mass_spring_chain(&masses, &springs, 2e4, 0.0).unwrap();
        let mut solver = AntiresonanceSolver::new(&Arc::new(Structure::of(&model)));
        let mut prepared = solver.prepare(model.stiffness(), model.mass());
        let query = Query { route: Route::Modal, f_max_hz: f64::INFINITY, include_cancelled: false };
        let mut roots = Vec::new();
        prepared.find(&(0, 0).into(), &query, &mut roots).unwrap();
        assert!(roots.len() > WIDTH);
        let slopes = MatrixSlopes {
            stiffness: vec![(0, 0, 2.0), (3, 4, -1.0), (4, 3, -1.0), (59, 59, 0.3)],
            mass: vec![(7, 7, 0.5)],
        };
        let (mut zero, mut batch) = (ZeroSensitivity::default(), ZeroBatch::default());
        for chunk in roots.chunks(WIDTH) {
            for &hz in chunk {
                zero.set(&mut prepared, &(0, 0).into(), eigenvalue(hz)).unwrap();
                batch.push(&zero, zero.along(&slopes));
            }
            assert_eq!(batch.is_full(), chunk.len() == WIDTH);
            batch.along(&slopes, |alone, together| {
                assert_eq!(alone.to_bits(), together.to_bits());
            });
            batch.clear();
        }
        batch.along(&slopes, |_, _| unreachable!("no zero is left"));
        ZeroBatch::<()>::default().along(&slopes, |(), _| unreachable!("there was none"));
    }
}
