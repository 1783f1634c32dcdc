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
//! readings. A factor on either column cancels. On a pole, where K − xM is singular, the second reading holds.
//!
//! Source: J. He & Y. Q. Li, Relocation of anti-resonances of a vibratory system by local structural
//! changes, Int. J. Anal. Exp. Modal Anal. 10 (1995) 224-235; J. E. Mottershead, On the zeros of structural
//! frequency response functions and their sensitivities, Mech. Syst. Signal Process. 12 (1998) 591-597.

use super::solver::Prepared;
use crate::error::Result;
use crate::fem::slopes::MatrixSlopes;

/// The null vectors of one zero, ready to be joined with any change of the model.
#[derive(Debug, Clone, Default)]
pub struct ZeroSensitivity {
    x: f64,
    left: Vec<f64>,
    right: Vec<f64>,
    /// dH_ik/dx, with the factors of the two columns.
    slope: f64,
}

impl ZeroSensitivity {
    /// Takes up the zero `x` = ω² of H_ik.
    ///
    /// # Errors
    /// Those of [`Prepared::columns`].
    pub fn set(&mut self, prepared: &mut Prepared<'_>, ends: (usize, usize), x: f64) -> Result<()> {
        self.x = x;
        self.slope = prepared.columns(ends, x, &mut self.left, &mut self.right)?;
        Ok(())
    }

    /// Takes up a root `x` that cancels against a pole, see [`crate::modal::on_pole`].
    ///
    /// # Errors
    /// Those of [`Prepared::vectors_on_pole`].
    pub fn set_cancelled(
        &mut self,
        prepared: &mut Prepared<'_>,
        ends: (usize, usize),
        x: f64,
    ) -> Result<()> {
        self.x = x;
        self.slope = prepared.vectors_on_pole(ends, x, &mut self.left, &mut self.right)?;
        Ok(())
    }

    /// Left and right null vector.
    #[must_use]
    pub fn vectors(&self) -> (&[f64], &[f64]) {
        (&self.left, &self.right)
    }

    /// The zero.
    pub(super) fn x(&self) -> f64 {
        self.x
    }

    /// dH_ik/dx, with the factors of the two vectors.
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// dx/dp in (rad/s)² per unit of p; not finite at a double zero, which has no derivative.
    #[must_use]
    pub fn along(&self, slopes: &MatrixSlopes) -> f64 {
        let join = |entries: &[(u32, u32, f64)]| -> f64 {
            let (left, right) = (&self.left, &self.right);
            entries
                .iter()
                .map(|&(row, col, value)| left[row as usize] * value * right[col as usize])
                .sum()
        };
        (join(&slopes.stiffness) - self.x * join(&slopes.mass)) / self.slope
    }
}
