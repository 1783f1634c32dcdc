//! The parts of J and the first derivatives of its residuals, for the optimizer's polish.
//!
//! ```text
//! e = x_A / x_E − 1,  x = ω²        de/dp = (dx_A/dp) / x_E
//! ```
//!
//! with dx_A/dp from [`crate::modal::sensitivities`]. The pairing counts as fixed: where a measured value is
//! about to change its partner the model is wrong, and the optimizer's trust region finds out.

use super::misfit::Misfit;
use super::objective::{AntiresonanceObjective, Workspace};
use super::pairing::residual;
use crate::fem::slopes::{MatrixSlopes, Slopes};
use crate::modal::modes::eigenvalue;
use crate::modal::sensitivities::ZeroSensitivity;
use crate::optimize::{Composition, Linearization, Norm, Objective};

impl AntiresonanceObjective {
    /// How J is composed; the largest residual has no linearization here, its sum and its squares have.
    pub(super) fn parts(&self) -> Composition {
        let sparse: Vec<bool> = (0..self.n_parameters())
            .map(|i| self.penalty.is_some() && self.is_reduction(i))
            .collect();
        let gamma1 = self.penalty.map_or(0.0, |penalty| penalty.gamma1);
        let nominal = self.parameters.iter().map(|p| p.nominal(&self.model));
        Composition {
            norm: match self.misfit {
                Misfit::Absolute => Some(Norm::Absolute),
                Misfit::Squared => Some(Norm::Squared),
                Misfit::Largest => None,
            },
            start: nominal.collect(),
            price: sparse
                .iter()
                .map(|&s| if s { gamma1 } else { 0.0 })
                .collect(),
            sparse,
        }
    }

    /// J, its residuals and their derivatives; `None` where the eigenproblem fails.
    pub(super) fn linearized(&self, x: &[f64], ws: &mut Workspace) -> Option<Linearization> {
        let mut snapped = x.to_vec();
        self.repair(&mut snapped);
        let pairs = self.pairs(&snapped, ws).ok()?;
        let n = self.n_parameters();
        let along = Slopes::new(&self.model, &self.parameters, &snapped);
        let slopes: Vec<MatrixSlopes> = (0..n).map(|index| along.along(index)).collect();
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
        for (((target, measured_hz), paired), weight) in measured.zip(pairs).zip(&self.weights) {
            let e = weight * residual(paired, measured_hz);
            found.cost = self.misfit.add(found.cost, e);
            found.residuals.push(e);
            let Some(analytic_hz) = paired else {
                found.jacobian.extend(std::iter::repeat_n(0.0, n));
                continue;
            };
            let matrices = (ws.assembly.stiffness.as_ref(), ws.assembly.mass.as_ref());
            let ends = (target.dof, target.excitation);
            zero.set(&mut ws.solver, matrices, ends, eigenvalue(analytic_hz))
                .ok()?;
            for slopes in &slopes {
                let slope = weight * zero.along(slopes) / eigenvalue(measured_hz);
                // A double zero has no derivative; the descent must not follow one.
                found
                    .jacobian
                    .push(if slope.is_finite() { slope } else { 0.0 });
            }
        }
        found.cost += self.penalty_at(&snapped);
        Some(found)
    }
}
