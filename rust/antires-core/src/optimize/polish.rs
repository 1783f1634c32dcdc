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
//!
//! # moves
//!
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

pub(super) use super::descent::Point;
use super::descent::{LocalSearch, MOST_STEPS, same};
use super::objective::{Composition, Evaluator, Ledger, Stop};
use super::options::IslandOptions;
use super::outcome::Hooks;
use super::population::Tape;

/// Sizes, as fractions of the range, to which all sparse genes are raised where a search begins.
const STARTS: [f64; 3] = [0.05, 0.2, 0.5];

/// The polish of one search, with its memory.
pub(super) struct Polish {
    local: LocalSearch,
    moves: Moves,
}

impl Polish {
    /// The polish that `options` ask for, if any.
    pub(super) fn new<E: Evaluator>(evaluator: &E, lower: &[f64], options: &IslandOptions) -> Option<Self> {
        let told = || evaluator.composition();
        let composition = match options.polish {
            Some(false) => None,
            None => told(),
            Some(true) => Some(told().unwrap_or_else(|| Composition::unknown(lower))),
        };
        composition.map(|composition| Self {
            local: LocalSearch { composition, allowance: options.polish_evaluations },
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
                let width = if sparse { upper[gene] - lower[gene] } else { 0.0 };
                point.x[gene] + size * width
            });
            Point { x: x.collect(), cost: f64::INFINITY }
        };
        let mut starts = STARTS.map(raised);
        self.local.approach(&mut starts, ledger, hooks)?;
        for start in starts.iter_mut().filter(|start| start.cost.is_finite()) {
            prune(&self.local, start, Path::Any, ledger, hooks)?;
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
                self.moves.settle(&self.local, point, path(i), ledger, hooks)?;
            }
        }
        Ok(())
    }

    /// Passes what it remembers.
    pub(super) fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        self.moves.pass(n_genes, tape);
    }
}

// ---- moves

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
pub(in crate::optimize) enum Path {
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
            bases.extend(raised.iter().map(|&gene| without(&point.x, gene, lower)));
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
        self.scanned.push(Scan { base, best: best.clone() });
        Ok(best)
    }

    /// Passes what is remembered.
    pub(super) fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        let blank = || Scan { base: vec![0.0; n_genes], best: None };
        tape.list(&mut self.scanned, blank, |tape, scan| {
            tape.floats(&mut scan.base);
            let mut some = scan.best.is_some();
            tape.flag(&mut some);
            if some {
                let best = scan.best.get_or_insert_with(|| Point { x: vec![0.0; n_genes], cost: 0.0 });
                tape.floats(&mut best.x);
                tape.float(&mut best.cost);
            }
        });
    }
}

/// `x` with one gene put to rest.
fn without(x: &[f64], gene: usize, lower: &[f64]) -> Vec<f64> {
    let mut rest = x.to_vec();
    rest[gene] = lower[gene];
    rest
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
        let mut best = Point { x: sizes[..base.len()].to_vec(), cost: costs[0] };
        for (x, &cost) in sizes.chunks_exact(base.len()).zip(costs) {
            best.take(x, cost);
        }
        best
    };
    Ok(genes.zip(costs.chunks_exact(SIZES.len())).map(best).collect())
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
        let mut batch: Vec<f64> = raised.iter().flat_map(|&gene| without(&point.x, gene, lower)).collect();
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
