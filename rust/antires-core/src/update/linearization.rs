//! What the optimizer asks of the antiresonance objective: its cost and the first derivatives of its residuals.
//!
//! ```text
//! e = x_A / x_E − 1,  x = ω²        de/dp = (dx_A/dp) / x_E
//! ```
//!
//! with dx_A/dp from [`crate::antiresonances::sensitivities`], and at the edge of the band as of [`super::pairing`].
//! The pairing counts as fixed: where a measured antiresonance is about to change its partner the linear model is
//! wrong, and the optimizer's trust region finds out.

use super::objective::{AntiresonanceObjective, Workspace};
use crate::antiresonances::ZeroSensitivity;
use crate::modal::modes::eigenvalue;
use crate::optimize::{Composition, Linearization, Objective};

impl Objective for AntiresonanceObjective {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        self.memory()
    }

    fn cost(&self, x: &[f64], ws: &mut Workspace) -> f64 {
        self.value(x, ws)
    }

    fn composition(&self) -> Option<Composition> {
        Some(self.unknowns().composition(self.misfit().norm()))
    }

    /// J, its residuals and their derivatives; `None` where the eigenproblem fails.
    fn linearize(&self, x: &[f64], ws: &mut Workspace) -> Option<Linearization> {
        let unknowns = self.unknowns();
        let snapped = unknowns.snapped(x);
        let mut formed = self.form(&snapped, ws);
        let pairs = self.pairs_of(&mut formed).ok()?;
        let slopes = unknowns.slopes(&snapped);
        let n = slopes.len();
        let mut found = Linearization {
            cost: 0.0,
            residuals: Vec::with_capacity(pairs.len()),
            jacobian: Vec::with_capacity(pairs.len() * n),
        };
        let mut zero = ZeroSensitivity::default();
        for ((target, measured_hz, weight), pairing) in self.measured().zip(pairs) {
            let e = weight * pairing.residual;
            found.cost = self.misfit().add(found.cost, e);
            found.residuals.push(e);
            let first = found.jacobian.len();
            found.jacobian.extend(std::iter::repeat_n(0.0, n));
            let cancelled_hz = &formed.roots[target].cancelled_hz;
            for (analytic_hz, along) in pairing.moves_with.into_iter().flatten() {
                let (ends, x) = (self.ends(target), eigenvalue(analytic_hz));
                if cancelled_hz.contains(&analytic_hz) {
                    zero.set_cancelled(&mut formed.prepared, ends, x).ok()?;
                } else {
                    zero.set(&mut formed.prepared, ends, x).ok()?;
                }
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
        found.cost += unknowns.penalty_at(&snapped);
        Some(found)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns().snap(x);
    }
}
