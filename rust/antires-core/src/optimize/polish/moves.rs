//! Moves from gene to gene: which of the sparse genes are above their lower bound.
//!
//! ```text
//! drop    one gene after another goes to its lower bound, as long as J falls
//! add     every gene at rest is raised to a few sizes; from the best size of each a few steps are
//!         taken, and the best few are brought all the way and dropped from
//! swap    the same, after one of the raised genes was put to rest
//! ```
//!
//! From an intact structure, adding is matching pursuit: the single damage that explains most, then the
//! next. Swaps mend what a greedy choice, or an island, got wrong.
//!
//! A path of its own never puts the last raised gene to rest before its moves have ended. Else every point
//! that is worse than no damage falls back to it, and what follows is one pursuit from one point for all islands,
//! whose agreement says nothing.
//!
//! S. Mallat & Z. Zhang, Matching pursuits with time-frequency dictionaries, IEEE Trans. Signal Process. 41
//! (1993) 3397-3415.

use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::super::tape::Tape;
use super::local::LocalSearch;
use super::point::{Point, same};

/// Sizes to which a gene is raised, as fractions of its range. A stiffness that is nearly lost acts by
/// what is left of it, so they are denser at the upper end.
const SIZES: [f64; 6] = [0.12, 0.32, 0.52, 0.7, 0.82, 0.92];

/// How many genes of a scan are followed a few steps, and how many of those all the way: what a coarse
/// size costs says little of what the right one will.
const FOLLOWED: (usize, usize) = (40, 4);
const FOLLOWED_FAR: (usize, usize) = (6, 20);

/// A gain counts where it exceeds this fraction of J.
const GAIN: f64 = 1e-7;

/// Where moves may lead through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Path {
    /// Anywhere.
    Any,
    /// Not through the point where no sparse gene is raised, from which every search may start.
    Own,
}

impl Path {
    /// Fewest raised genes on the way.
    fn fewest(self) -> usize {
        match self {
            Self::Any => 0,
            Self::Own => 1,
        }
    }
}

/// What came of adding a gene to a point.
struct Scan {
    base: Vec<f64>,
    /// `None` where no gene was left to add.
    best: Option<Point>,
}

/// The moves of one search, with the memory of what they led to.
#[derive(Default)]
pub(super) struct Moves {
    /// Points to which single genes have been added, and the best that came of it.
    scanned: Vec<Scan>,
}

impl Moves {
    /// Moves `point` from gene to gene until no move gains, or the allowance is spent.
    pub(super) fn settle<E: Evaluator>(
        &mut self,
        local: &LocalSearch,
        point: &mut Point,
        path: Path,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let end = ledger.evaluations.saturating_add(local.allowance);
        prune(local, point, path, ledger, hooks)?;
        while let Some(better) = self.neighbour(local, point, path, end, ledger, hooks)? {
            *point = better;
        }
        prune(local, point, Path::Any, ledger, hooks)
    }

    /// The best point that swapping or adding a gene leads to, where it gains.
    fn neighbour<E: Evaluator>(
        &mut self,
        local: &LocalSearch,
        point: &Point,
        path: Path,
        end: usize,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<Option<Point>, Stop<E::Fault>> {
        let lower = ledger.bounds.lower();
        // Swaps first: they keep the count.
        let mut bases: Vec<Vec<f64>> = Vec::new();
        let raised = local.raised(&point.x, lower);
        if raised.len() > path.fewest() {
            for gene in raised {
                let mut base = point.x.clone();
                base[gene] = lower[gene];
                bases.push(base);
            }
        }
        bases.push(point.x.clone());
        for base in bases {
            if ledger.evaluations >= end {
                return Ok(None);
            }
            let best = self.scan(local, base, ledger, hooks)?;
            let gains = |best: &Point| best.cost < point.cost - GAIN * point.cost.abs();
            if let Some(best) = best.filter(gains) {
                return Ok(Some(best));
            }
        }
        Ok(None)
    }

    /// The best that adding a gene to `base` leads to. What is known from an earlier scan is not computed
    /// again: islands arrive at the same optima, and these have common neighbours.
    fn scan<E: Evaluator>(
        &mut self,
        local: &LocalSearch,
        base: Vec<f64>,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<Option<Point>, Stop<E::Fault>> {
        let known = |scan: &&Scan| same(ledger.bounds, &scan.base, &base);
        if let Some(scan) = self.scanned.iter().find(known) {
            return Ok(scan.best.clone());
        }
        let mut tried = additions(local, &base, ledger, hooks)?;
        for (most, steps) in [FOLLOWED, FOLLOWED_FAR] {
            // A stable sort: of equal costs the lower gene first.
            tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            tried.truncate(most);
            local.descend(&mut tried, steps, ledger, hooks)?;
        }
        for candidate in &mut tried {
            // Of any path, so that what is remembered serves all; none of them ends without a last pruning.
            prune(local, candidate, Path::Own, ledger, hooks)?;
        }
        let best = tried.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        self.scanned.push(Scan {
            base,
            best: best.clone(),
        });
        Ok(best)
    }

    /// Passes what is remembered.
    pub(super) fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        let blank = || Scan {
            base: vec![0.0; n_genes],
            best: None,
        };
        tape.list(&mut self.scanned, blank, |tape, scan| {
            tape.floats(&mut scan.base);
            let mut some = scan.best.is_some();
            tape.flag(&mut some);
            if some {
                let best = scan.best.get_or_insert_with(|| Point {
                    x: vec![0.0; n_genes],
                    cost: 0.0,
                });
                tape.floats(&mut best.x);
                tape.float(&mut best.cost);
            }
        });
    }
}

/// `base` with each sparse gene at rest raised to the best of a few sizes.
fn additions<E: Evaluator>(
    local: &LocalSearch,
    base: &[f64],
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<Vec<Point>, Stop<E::Fault>> {
    let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
    let (mut batch, mut costs) = (Vec::new(), Vec::new());
    for gene in (0..base.len()).filter(|&gene| local.composition.sparse[gene]) {
        if base[gene] > lower[gene] || lower[gene] == upper[gene] {
            continue;
        }
        for size in SIZES {
            let mut trial = base.to_vec();
            trial[gene] = lower[gene] + size * (upper[gene] - lower[gene]);
            ledger.repair(&mut trial);
            batch.extend(trial);
        }
    }
    ledger.all_costs(&batch, &mut costs, hooks)?;
    let genes = batch.chunks_exact(base.len() * SIZES.len());
    let best = |(sizes, costs): (&[f64], &[f64])| {
        let mut best = Point {
            x: sizes[..base.len()].to_vec(),
            cost: costs[0],
        };
        for (x, &cost) in sizes.chunks_exact(base.len()).zip(costs) {
            best.take(x, cost);
        }
        best
    };
    Ok(genes
        .zip(costs.chunks_exact(SIZES.len()))
        .map(best)
        .collect())
}

/// Drops raised genes as long as that lowers J, each time followed by a descent of the rest.
pub(super) fn prune<E: Evaluator>(
    local: &LocalSearch,
    point: &mut Point,
    path: Path,
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<(), Stop<E::Fault>> {
    let lower = ledger.bounds.lower();
    let n = point.x.len();
    let mut costs = Vec::new();
    loop {
        let raised = local.raised(&point.x, lower);
        let most = raised.len().saturating_sub(path.fewest());
        if most == 0 {
            return Ok(());
        }
        let mut batch = Vec::new();
        for &gene in &raised {
            let mut trial = point.x.clone();
            trial[gene] = lower[gene];
            batch.extend(trial);
        }
        ledger.all_costs(&batch, &mut costs, hooks)?;
        let before = point.cost;
        let mut trial = point.x.clone();
        for (row, &cost) in batch.chunks_exact(n).zip(&costs) {
            point.take(row, cost);
        }
        // The cheapest to lose, then that and the next, and so on: many may go at once.
        let mut order: Vec<usize> = (0..raised.len()).collect();
        order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        batch.clear();
        for (nth, &i) in order.iter().take(most).enumerate() {
            trial[raised[i]] = lower[raised[i]];
            // The first alone was among the single drops.
            if nth > 0 {
                batch.extend_from_slice(&trial);
            }
        }
        ledger.all_costs(&batch, &mut costs, hooks)?;
        for (row, &cost) in batch.chunks_exact(n).zip(&costs) {
            point.take(row, cost);
        }
        if point.cost >= before {
            return Ok(());
        }
        local.descend(std::slice::from_mut(point), FOLLOWED_FAR.1, ledger, hooks)?;
    }
}
