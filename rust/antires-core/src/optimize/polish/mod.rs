//! Polish: what a local search makes of the islands' bests.
//!
//! Two things that recombination is slow at are done here, at the start and whenever the islands meet:
//!
//! - [`descent`] solves for all continuous genes at once where the objective can be linearized, and
//!   [`compass`] searches along the genes where it cannot;
//! - [`moves`] change which sparse genes are above their lower bound: a gene is dropped, added, or
//!   exchanged for another whose size is then found anew. A count of damaged elements has no
//!   derivative, and between neighbours that explain nearly the same data no path leads downhill.
//!
//! A polish is deterministic: it draws no random number. It may spend a number of evaluations on each
//! point, all of them counted, and no point gets worse. What a move led to is remembered, so that
//! islands that arrive at the same optimum do not pay for its neighbours again.

pub mod cholesky;
pub mod compass;
pub mod descent;
mod local;
pub mod moves;
mod point;
pub mod step;
pub mod subproblem;

use super::composition::Composition;
use super::ledger::{Ledger, Stop};
use super::objective::Evaluator;
use super::options::IslandOptions;
use super::outcome::Hooks;
use super::tape::Tape;
use local::LocalSearch;
use moves::Moves;

pub(super) use point::Point;

/// Most steps of one descent.
const MOST_STEPS: usize = 60;

/// The polish of one search, with its memory.
pub(super) struct Polish {
    local: LocalSearch,
    moves: Moves,
}

impl Polish {
    /// The polish that `options` ask for, if any.
    pub(super) fn new<E: Evaluator>(
        evaluator: &E,
        lower: &[f64],
        options: &IslandOptions,
    ) -> Option<Self> {
        let told = || evaluator.composition();
        let composition = match options.polish {
            Some(false) => None,
            None => told(),
            Some(true) => Some(told().unwrap_or_else(|| Composition::unknown(lower))),
        };
        composition.map(|composition| Self {
            local: LocalSearch {
                composition,
                allowance: options.polish_evaluations,
            },
            moves: Moves::default(),
        })
    }

    /// The optimum reached from where a search begins that knows nothing.
    pub(super) fn begin<E: Evaluator>(
        &mut self,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<Option<Point>, Stop<E::Fault>> {
        let Some(mut x) = self.local.composition.start.clone() else {
            return Ok(None);
        };
        for (gene, &sparse) in self.local.composition.sparse.iter().enumerate() {
            if sparse {
                x[gene] = ledger.bounds.lower()[gene];
            }
        }
        ledger.repair(&mut x);
        let mut costs = Vec::new();
        ledger.all_costs(&x, &mut costs, hooks)?;
        let mut points = [Point { x, cost: costs[0] }];
        self.run(&mut points, ledger, hooks)?;
        let [point] = points;
        Ok(Some(point))
    }

    /// Improves every point as far as its allowance goes.
    ///
    /// When the search must stop in the midst, the points are left somewhere on their way down.
    pub(super) fn run<E: Evaluator>(
        &mut self,
        points: &mut [Point],
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        self.local.descend(points, MOST_STEPS, ledger, hooks)?;
        if self.local.composition.sparse.contains(&true) {
            for point in points {
                self.moves.settle(&self.local, point, ledger, hooks)?;
            }
        }
        Ok(())
    }

    /// Passes what it remembers.
    pub(super) fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        self.moves.pass(n_genes, tape);
    }
}
