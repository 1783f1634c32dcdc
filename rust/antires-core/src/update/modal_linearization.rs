//! What the optimizer asks of the comparison objective: its cost and the first derivatives of its residuals.
//!
//! ```text
//! de/dp = (dλ_A/dp) / λ_E,   d(1 − MAC)/dp = −dMAC/dp
//! ```
//!
//! from [`crate::modal::mode_sensitivities`]; the pairing counts as fixed. Eq. 18 mixes absolute values of e with
//! squares of s = 1 − MAC. As s² is not negative it is its own absolute value, so Σ|e| + Σs² is the sum of
//! absolute values of the residuals e and s², the latter with the slope 2 s ds/dp; in the sum of squares the
//! residuals are e and s themselves.

use super::misfit::Misfit;
use super::modal_objective::{ModalObjective, ModalWorkspace};
use crate::modal::mode_sensitivities::ModeSensitivity;
use crate::modal::modes::eigenvalue;
use crate::optimize::{Composition, Linearization, Objective};

impl Objective for ModalObjective {
    type Workspace = ModalWorkspace;

    fn workspace(&self) -> ModalWorkspace {
        self.memory()
    }

    fn cost(&self, x: &[f64], ws: &mut ModalWorkspace) -> f64 {
        self.value(x, ws)
    }

    fn composition(&self) -> Option<Composition> {
        Some(self.unknowns().composition(self.misfit().norm()))
    }

    /// J, its residuals, two for each measured mode, and their derivatives; `None` where the eigenproblem
    /// fails.
    fn linearize(&self, x: &[f64], ws: &mut ModalWorkspace) -> Option<Linearization> {
        let snapped = self.unknowns().snapped(x);
        let mut formed = self.form(&snapped, ws);
        let pairs = self.pairs_of(&mut formed).ok()?;
        let slopes = self.unknowns().slopes(&snapped);
        let (m, n) = (pairs.len(), slopes.len());
        let mut found = Linearization {
            cost: 0.0,
            residuals: Vec::with_capacity(2 * m),
            jacobian: vec![0.0; 2 * m * n],
        };
        let mut both = Vec::with_capacity(m);
        let mut mode = ModeSensitivity::default();
        for (nth, ((measured, weight), partner)) in self.measured().zip(pairs).enumerate() {
            let (e, s) = self.residuals(nth, partner);
            both.push((e, s));
            // The residual that the norm knows, and its slope along s.
            let (shape, along) = match self.misfit() {
                Misfit::Squared => (s, 1.0),
                Misfit::Absolute | Misfit::Largest => (s * s, 2.0 * s),
            };
            found.residuals.extend([e, shape]);
            let Some(partner) = partner else { continue };
            let (modes, solved) = (&*formed.modes, &mut formed.solved);
            mode.set(modes, solved, partner.mode, &measured.shape)
                .ok()?;
            let rows = found.jacobian[2 * nth * n..].split_at_mut(n);
            for (index, slopes) in slopes.iter().enumerate() {
                let (lambda, mac) = mode.along(slopes);
                // Two modes all but repeated: the descent must not follow what is no number.
                let finite = |slope: f64| if slope.is_finite() { slope } else { 0.0 };
                rows.0[index] = finite(weight * lambda / eigenvalue(measured.freq_hz));
                rows.1[index] = finite(-along * weight * mac);
            }
        }
        found.cost = self.total(&both, &snapped);
        Some(found)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns().snap(x);
    }
}
