//! The descent on the continuous genes that an objective allows: [`descent`] where it can be linearized, else
//! [`compass`].

use super::super::composition::Composition;
use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::point::Point;
use super::{compass, descent};

/// More raised sparse genes than these are far off.
const FEW: usize = 3;

/// What a relaxed descent leaves of a sparse gene below this fraction of its range is nothing.
const NEGLIGIBLE: f64 = 0.02;

/// Most steps of one descent.
pub(super) const MOST_STEPS: usize = 60;

/// How an objective is composed, and what may be spent on a point.
pub(super) struct LocalSearch {
    pub(super) composition: Composition,
    /// Evaluations.
    pub(super) allowance: usize,
}

impl LocalSearch {
    /// Brings every point down, with at most `most_steps` steps; none gets worse.
    pub(super) fn descend<E: Evaluator>(
        &self,
        points: &mut [Point],
        most_steps: usize,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        if let Some(norm) = self.composition.norm {
            return descent::descend(points, norm, &self.composition, most_steps, ledger, hooks);
        }
        let limits = (most_steps, self.allowance);
        points
            .iter_mut()
            .try_for_each(|point| compass::descend(point, &self.composition, limits, ledger, hooks))
    }

    /// From far off, where more than [`FEW`] sparse genes are raised, each point goes to what a
    /// [relaxed](descent::relax) descent, a threshold and a descent on the rest lead to, where that is better.
    pub(super) fn approach<E: Evaluator>(
        &self,
        points: &mut [Point],
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let Some(norm) = self.composition.norm else {
            return Ok(());
        };
        let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
        let far: Vec<usize> = (0..points.len())
            .filter(|&i| self.raised(&points[i].x, lower).len() > FEW)
            .collect();
        let mut trials: Vec<Point> = far.iter().map(|&i| points[i].clone()).collect();
        descent::relax(&mut trials, &self.composition, ledger, hooks)?;
        for trial in &mut trials {
            for gene in self.raised(&trial.x, lower) {
                if trial.x[gene] - lower[gene] < NEGLIGIBLE * (upper[gene] - lower[gene]) {
                    trial.x[gene] = lower[gene];
                }
            }
            // Known as soon as the descent linearizes there.
            trial.cost = f64::INFINITY;
        }
        descent::descend(
            &mut trials,
            norm,
            &self.composition,
            MOST_STEPS,
            ledger,
            hooks,
        )?;
        for (&i, trial) in far.iter().zip(&trials) {
            points[i].take(&trial.x, trial.cost);
        }
        Ok(())
    }

    /// Sparse genes above their lower bound.
    pub(super) fn raised(&self, x: &[f64], lower: &[f64]) -> Vec<usize> {
        (0..x.len())
            .filter(|&gene| self.composition.sparse[gene] && x[gene] > lower[gene])
            .collect()
    }
}
