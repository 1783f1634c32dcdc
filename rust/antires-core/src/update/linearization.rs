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
use crate::antiresonances::{ZeroBatch, ZeroSensitivity};
use crate::fem::slopes::MatrixSlopes;
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
        let (mut zero, mut batch) = (ZeroSensitivity::default(), ZeroBatch::default());
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
                let row = Row {
                    first,
                    along,
                    weight,
                    measured: eigenvalue(measured_hz),
                };
                batch.push(&zero, row);
                if batch.is_full() {
                    add(&mut batch, &slopes, &mut found.jacobian);
                }
            }
        }
        add(&mut batch, &slopes, &mut found.jacobian);
        found.cost += unknowns.penalty_at(&snapped);
        Some(found)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns().snap(x);
    }
}

/// The row of the Jacobian that a root moves, and how.
struct Row {
    first: usize,
    along: f64,
    weight: f64,
    measured: f64,
}

/// Adds what the roots in the batch have to say, and empties it.
fn add(batch: &mut ZeroBatch<Row>, slopes: &[MatrixSlopes], jacobian: &mut [f64]) {
    for (p, slopes) in slopes.iter().enumerate() {
        batch.along(slopes, |row, dx| {
            let slope = row.weight * dx / row.measured;
            // A double zero has no derivative; the descent must not follow one.
            jacobian[row.first + p] += if slope.is_finite() {
                row.along * slope
            } else {
                0.0
            };
        });
    }
    batch.clear();
}
