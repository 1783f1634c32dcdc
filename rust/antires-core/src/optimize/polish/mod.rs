//! Polish: what a local search makes of the islands' bests.
//!
//! Two things that recombination is slow at are done here, at the start and whenever the islands meet:
//!
//! - [`descent`] solves for all continuous genes at once where the objective can be linearized, and
//!   [`compass`] searches along the genes where it cannot. From far off least squares on all genes come first, and a
//!   search begins by them: from most starts they lead to the optimum within some fifty linearizations;
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
use local::{LocalSearch, MOST_STEPS};
use moves::Moves;

pub(super) use moves::Path;
pub(super) use point::Point;

/// Sizes, as fractions of the range, to which all sparse genes are raised where a search begins.
const STARTS: [f64; 3] = [0.05, 0.2, 0.5];

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
        self.scatter(&mut points[0], ledger, hooks)?;
        self.run(&mut points, |_| Path::Any, ledger, hooks)?;
        let [point] = points;
        Ok(Some(point))
    }

    /// Least squares from a few starts, all sparse genes raised alike, and what is dropped from there: `point` goes to
    /// the best of them, if that is better.
    fn scatter<E: Evaluator>(
        &self,
        point: &mut Point,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let composition = &self.local.composition;
        if composition.norm.is_none() || !composition.sparse.contains(&true) {
            return Ok(());
        }
        let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
        let raised = |size: f64| {
            let genes = composition.sparse.iter().enumerate();
            let x = genes.map(|(gene, &sparse)| {
                let width = if sparse {
                    upper[gene] - lower[gene]
                } else {
                    0.0
                };
                point.x[gene] + size * width
            });
            Point {
                x: x.collect(),
                cost: f64::INFINITY,
            }
        };
        let mut starts = STARTS.map(raised);
        self.local.approach(&mut starts, ledger, hooks)?;
        for start in starts.iter_mut().filter(|start| start.cost.is_finite()) {
            moves::prune(&self.local, start, Path::Any, ledger, hooks)?;
            point.take(&start.x, start.cost);
        }
        Ok(())
    }

    /// Improves every point as far as its allowance goes, point i by moves along `path(i)`.
    ///
    /// When the search must stop in the midst, the points are left somewhere on their way down.
    pub(super) fn run<E: Evaluator>(
        &mut self,
        points: &mut [Point],
        path: impl Fn(usize) -> Path,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        self.local.approach(points, ledger, hooks)?;
        self.local.descend(points, MOST_STEPS, ledger, hooks)?;
        if self.local.composition.sparse.contains(&true) {
            for (i, point) in points.iter_mut().enumerate() {
                self.moves
                    .settle(&self.local, point, path(i), ledger, hooks)?;
            }
        }
        Ok(())
    }

    /// Passes what it remembers.
    pub(super) fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        self.moves.pass(n_genes, tape);
    }
}
