//! The descent on the continuous genes that an objective allows: [`descent`] where it can be linearized, else
//! [`compass`].

use super::super::composition::Composition;
use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::point::Point;
use super::{compass, descent};

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

    /// Sparse genes above their lower bound.
    pub(super) fn raised(&self, x: &[f64], lower: &[f64]) -> Vec<usize> {
        (0..x.len())
            .filter(|&gene| self.composition.sparse[gene] && x[gene] > lower[gene])
            .collect()
    }
}
