//! How a mode moves with the model: its eigenvalue, and the MAC of its shape with a measured one.
//!
//! ```text
//! dλ/dp   = φᵀ (dK/dp − λ dM/dp) φ
//! dMAC/dp = −zᵀ (dK/dp − λ dM/dp) φ,      (K − λM) z = dMAC/dφ,  zᵀMφ = 0
//! ```
//!
//! The second is [`LowModes::adjoint`]. MAC does not see the size of φ, so its normalisation does not matter.
//!
//! Source: R. L. Fox & M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA J. 6 (1968)
//! 2426-2429; R. B. Nelson, AIAA J. 14 (1976) 1201-1205.

use super::low_modes::LowModes;
use super::mac::Shape;
use super::solved::Solved;
use crate::error::Result;
use crate::fem::slopes::MatrixSlopes;

/// The vectors of one mode, ready to be joined with any change of the model.
#[derive(Debug, Clone, Default)]
pub struct ModeSensitivity {
    lambda: f64,
    phi: Vec<f64>,
    slope: Vec<f64>,
    z: Vec<f64>,
}

impl ModeSensitivity {
    /// Takes up mode `r` of `modes`, which are those of `solved`, and the measured `shape`.
    ///
    /// # Errors
    /// Those of [`LowModes::adjoint`].
    pub fn set(
        &mut self,
        modes: &LowModes,
        solved: &mut Solved<'_>,
        r: usize,
        shape: &Shape,
    ) -> Result<()> {
        self.lambda = modes.eigenvalues()[r];
        self.phi.clear();
        self.phi.extend_from_slice(modes.shape(r));
        if modes.space(r).len() > self.phi.len() {
            self.z.clear();
            self.z.resize(self.phi.len(), 0.0);
            return Ok(());
        }
        shape.slope(&self.phi, &mut self.slope);
        modes.adjoint(solved, r, &self.slope, &mut self.z)
    }

    /// dλ/dp in (rad/s)² and dMAC/dp, per unit of p. A repeated mode has no derivatives: the first is then that
    /// of one of its shapes, right where p splits it not, the second zero.
    #[must_use]
    pub fn along(&self, slopes: &MatrixSlopes) -> (f64, f64) {
        let join = |left: &[f64], entries: &[(u32, u32, f64)]| -> f64 {
            entries
                .iter()
                .map(|&(row, col, value)| left[row as usize] * value * self.phi[col as usize])
                .sum()
        };
        let of =
            |left: &[f64]| join(left, &slopes.stiffness) - self.lambda * join(left, &slopes.mass);
        (of(&self.phi), -of(&self.z))
    }
}
