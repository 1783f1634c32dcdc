//! First derivatives of the residuals, for the optimizer's polish.
//!
//! ```text
//! e = x_A / x_E − 1,  x = ω²        de/dp = (dx_A/dp) / x_E
//! ```
//!
//! with dx_A/dp from [`crate::modal::sensitivities`], and at the edge of the band as of [`super::pairing`]. The pairing counts as fixed: where a measured value is
//! about to change its partner the model is wrong, and the optimizer's trust region finds out.

use super::objective::{AntiresonanceObjective, Workspace};
use crate::modal::modes::eigenvalue;
use crate::modal::sensitivities::ZeroSensitivity;
use crate::optimize::Linearization;

impl AntiresonanceObjective {
    /// J, its residuals and their derivatives; `None` where the eigenproblem fails.
    pub(super) fn linearized(&self, x: &[f64], ws: &mut Workspace) -> Option<Linearization> {
        let snapped = self.unknowns.snapped(x);
        let pairs = self.pairs(&snapped, ws).ok()?;
        let slopes = self.unknowns.slopes(&snapped);
        let n = slopes.len();
        let mut found = Linearization {
            cost: 0.0,
            residuals: Vec::with_capacity(pairs.len()),
            jacobian: Vec::with_capacity(pairs.len() * n),
        };
        let measured = self
            .targets
            .iter()
            .flat_map(|target| target.freq_hz.iter().map(move |&freq| (target, freq)));
        let mut zero = ZeroSensitivity::default();
        for (((target, measured_hz), pairing), weight) in measured.zip(pairs).zip(&self.weights) {
            let e = weight * pairing.residual;
            found.cost = self.misfit.add(found.cost, e);
            found.residuals.push(e);
            let first = found.jacobian.len();
            found.jacobian.extend(std::iter::repeat_n(0.0, n));
            for (analytic_hz, along) in pairing.moves_with.into_iter().flatten() {
                let matrices = (ws.assembly.stiffness.as_ref(), ws.assembly.mass.as_ref());
                let ends = (target.dof, target.excitation);
                zero.set(&mut ws.solver, matrices, ends, eigenvalue(analytic_hz))
                    .ok()?;
                for (entry, slopes) in found.jacobian[first..].iter_mut().zip(&slopes) {
                    let slope = weight * zero.along(slopes) / eigenvalue(measured_hz);
                    // A double zero has no derivative; the descent must not follow one.
                    *entry += if slope.is_finite() {
                        along * slope
                    } else {
                        0.0
                    };
                }
            }
        }
        found.cost += self.unknowns.penalty_at(&snapped);
        Some(found)
    }
}
