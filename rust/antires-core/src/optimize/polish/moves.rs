//! Moves from gene to gene: which of the sparse genes are above their lower bound.
//!
//! ```text
//! drop    one gene after another goes to its lower bound, as long as J falls
//! add     every gene at rest is raised to a few sizes; the best few are brought down and dropped from
//! swap    the same, after one of the raised genes was put to rest
//! ```
//!
//! From an intact structure, adding is matching pursuit: the single damage that explains most, then the
//! next. Swaps mend what a greedy choice, or an island, got wrong.
//!
//! S. Mallat & Z. Zhang, Matching pursuits with time-frequency dictionaries, IEEE Trans. Signal Process. 41
//! (1993) 3397-3415.

use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::{Point, Polish};

/// Sizes to which a gene is raised, as fractions of its range.
const SIZES: [f64; 7] = [0.1, 0.25, 0.4, 0.55, 0.7, 0.8, 0.9];

/// How many genes of a scan are followed up, and with how many steps at most.
const FOLLOWED: usize = 6;
const FOLLOWED_STEPS: usize = 20;

/// A gain counts where it exceeds this fraction of J.
const GAIN: f64 = 1e-7;

/// What came of raising each gene of a point.
pub(super) struct Scan {
    base: Vec<f64>,
    /// The best size of each gene tried, cheapest first.
    raised: Vec<Point>,
}

impl Polish {
    /// Moves `point` from gene to gene until no move gains, or the allowance is spent.
    pub(super) fn settle<E: Evaluator>(
        &mut self,
        point: &mut Point,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let end = ledger.evaluations.saturating_add(self.allowance);
        self.prune(point, ledger, hooks)?;
        loop {
            if let Some(known) = self
                .settled
                .iter()
                .find(|known| Self::same(ledger, &known.x, &point.x))
            {
                point.take(&known.x, known.cost);
                return Ok(());
            }
            let Some(better) = self.neighbour(point, end, ledger, hooks)? else {
                if ledger.evaluations < end {
                    self.settled.push(point.clone());
                }
                return Ok(());
            };
            *point = better;
        }
    }

    /// The best point that adding or swapping a gene leads to, where it gains.
    fn neighbour<E: Evaluator>(
        &mut self,
        point: &Point,
        end: usize,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<Option<Point>, Stop<E::Fault>> {
        let lower = ledger.bounds.lower();
        let raised: Vec<usize> = self.raised(&point.x, lower);
        let without = |&gene: &usize| {
            let mut base = point.x.clone();
            base[gene] = lower[gene];
            base
        };
        // Swaps first where there is something to swap: they keep the count.
        let bases: Vec<Vec<f64>> = raised
            .iter()
            .map(without)
            .chain([point.x.clone()])
            .collect();
        for base in bases {
            if ledger.evaluations >= end {
                return Ok(None);
            }
            let scan = self.scan(base, ledger, hooks)?;
            let mut tried = self.scanned[scan].raised[..].to_vec();
            tried.truncate(FOLLOWED);
            self.descend(&mut tried, FOLLOWED_STEPS, ledger, hooks)?;
            for candidate in &mut tried {
                self.prune(candidate, ledger, hooks)?;
            }
            let best = tried.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
            if let Some(best) = best.filter(|best| best.cost < point.cost - GAIN * point.cost.abs())
            {
                return Ok(Some(best));
            }
        }
        Ok(None)
    }

    /// Sparse genes above their lower bound.
    fn raised(&self, x: &[f64], lower: &[f64]) -> Vec<usize> {
        (0..x.len())
            .filter(|&gene| self.composition.sparse[gene] && x[gene] > lower[gene])
            .collect()
    }

    /// Raises every sparse gene at rest of `base`; returns which of the scans tells what came of it.
    fn scan<E: Evaluator>(
        &mut self,
        base: Vec<f64>,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<usize, Stop<E::Fault>> {
        if let Some(known) = self
            .scanned
            .iter()
            .position(|scan| Self::same(ledger, &scan.base, &base))
        {
            return Ok(known);
        }
        let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
        let resting: Vec<usize> = (0..base.len())
            .filter(|&gene| {
                self.composition.sparse[gene]
                    && base[gene] == lower[gene]
                    && upper[gene] > lower[gene]
            })
            .collect();
        let (mut batch, mut costs) = (Vec::new(), Vec::new());
        for &gene in &resting {
            for size in SIZES {
                let mut trial = base.clone();
                trial[gene] = lower[gene] + size * (upper[gene] - lower[gene]);
                ledger.repair(&mut trial);
                batch.extend(trial);
            }
        }
        ledger.all_costs(&batch, &mut costs, hooks)?;
        let candidates: Vec<Point> = batch
            .chunks_exact(base.len())
            .zip(&costs)
            .map(|(x, &cost)| Point {
                x: x.to_vec(),
                cost,
            })
            .collect();
        let mut raised: Vec<Point> = candidates
            .chunks_exact(SIZES.len())
            .filter_map(|sizes| {
                sizes
                    .iter()
                    .min_by(|a, b| a.cost.total_cmp(&b.cost))
                    .cloned()
            })
            .collect();
        // A stable sort: of equal costs the lower gene first.
        raised.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        self.scanned.push(Scan { base, raised });
        Ok(self.scanned.len() - 1)
    }

    /// Drops raised genes as long as that lowers J, each time followed by a descent of the rest.
    fn prune<E: Evaluator>(
        &self,
        point: &mut Point,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let lower = ledger.bounds.lower();
        let n = point.x.len();
        let mut costs = Vec::new();
        loop {
            let raised = self.raised(&point.x, lower);
            let mut batch = Vec::new();
            for &gene in &raised {
                let mut trial = point.x.clone();
                trial[gene] = lower[gene];
                batch.extend(trial);
            }
            ledger.all_costs(&batch, &mut costs, hooks)?;
            let mut order: Vec<usize> = (0..raised.len()).collect();
            order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
            // The cheapest to lose, then that and the next, and so on: many may go at once.
            let mut trial = point.x.clone();
            batch.clear();
            for &i in &order {
                trial[raised[i]] = lower[raised[i]];
                batch.extend_from_slice(&trial);
            }
            ledger.all_costs(&batch, &mut costs, hooks)?;
            let before = point.cost;
            for (row, &cost) in batch.chunks_exact(n).zip(&costs) {
                point.take(row, cost);
            }
            if point.cost >= before {
                return Ok(());
            }
            self.descend(std::slice::from_mut(point), FOLLOWED_STEPS, ledger, hooks)?;
        }
    }
}
