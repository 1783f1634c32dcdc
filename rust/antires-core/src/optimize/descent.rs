//! Local descent on the continuous genes: by linearization, or by compass search.
//!
//! # descent
//!
//! Where the objective can be linearized: sequential linear (or quadratic) programming with a trust region.
//!
//! Each iteration minimizes the linear model of the residuals over the part of the box within a radius
//! of the point ([`Subproblem`]); the radius grows where the model foretold the gain and shrinks
//! where it did not. A sparse gene at its lower bound stays there. Several descents run in step, so that
//! their evaluations form one batch.
//!
//! From a point far off, where many sparse genes are raised, the sum of absolute residuals and its prices have local
//! minima everywhere. A *relaxed* descent goes first, on Σ e² of all genes, sparse ones at rest among them, without
//! prices: a smooth problem that leads near the optimum from most starts.
//!
//! R. Fletcher & E. Sainz de la Maza, Nonlinear programming and nonsmooth optimization by successive
//! linear programming, Math. Program. 43 (1989) 235-256.
//!
//! # compass
//!
//! For objectives that only know their value.
//!
//! From the point, one step up and one down along every gene are evaluated as one batch; the best of
//! them, and the sum of all that gained, are where the search goes on; where none gains, the steps halve.
//!
//! T. G. Kolda, R. M. Lewis & V. Torczon, Optimization by direct search, SIAM Review 45 (2003) 385-482.
//!
//! # subproblem
//!
//! The step of a descent: the norm of linear residuals and a price, over a box.
//!
//! ```text
//! min_d  Σ |e_i + (A d)_i| + cᵀ d    or    Σ (e_i + (A d)_i)² + cᵀ d,        low <= d <= high
//! ```
//!
//! by a primal-dual interior point method. With r = e + A d = u − v and y the slope of the norm at r, the
//! conditions are, for Σ |r|, u (1 − y) = v (1 + y) = μ, and for Σ r², y = 2 r; in both
//! c + Aᵀ y = z_l − z_h with z_l (d − low) = z_h (high − d) = μ. Eliminating all but Δd leaves
//!
//! ```text
//! (Aᵀ W A + Z) Δd = rhs,   W = 1 / (u/(1 − y) + v/(1 + y))  or  2,   Z = z_l/(d − low) + z_h/(high − d)
//! ```
//!
//! n x n and positive definite. The start satisfies every equation but the products, and so do all
//! iterates; Mehrotra's predictor chooses μ and the correction of second order.
//!
//! S. Portnoy & R. Koenker, The Gaussian hare and the Laplacian tortoise, Statist. Sci. 12 (1997) 279-300;
//! S. Mehrotra, SIAM J. Optim. 2 (1992) 575-601.

use super::bounds::Bounds;
use super::objective::{Composition, Evaluator, Ledger, Linearization, Norm, Stop};
use super::outcome::Hooks;

/// Two points are one where every gene agrees to this fraction of its range.
const SAME: f64 = 1e-6;

/// A candidate and its cost.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    pub(super) x: Vec<f64>,
    pub(super) cost: f64,
}

impl Point {
    /// Moves to `x`, whatever it costs.
    pub(super) fn settle(&mut self, x: &[f64], cost: f64) {
        self.x.copy_from_slice(x);
        self.cost = cost;
    }

    /// Moves to `x` where that costs less.
    pub(super) fn take(&mut self, x: &[f64], cost: f64) {
        if cost < self.cost {
            self.settle(x, cost);
        }
    }
}

/// Whether the two candidates are the same, as far as a polish can tell.
pub(super) fn same(bounds: &Bounds, a: &[f64], b: &[f64]) -> bool {
    let (lower, upper) = (bounds.lower(), bounds.upper());
    (0..a.len()).all(|i| (a[i] - b[i]).abs() <= SAME * (upper[i] - lower[i]))
}

/// More raised sparse genes than these are far off.
const FEW: usize = 3;

/// What a relaxed descent leaves of a sparse gene below this fraction of its range is nothing.
const NEGLIGIBLE: f64 = 0.02;

/// Most steps of one descent.
pub(super) const MOST_STEPS: usize = 60;

/// First and least step of a compass search, as fractions of each gene's range.
const FIRST_STEP: f64 = 1.0 / 16.0;
const LEAST_STEP: f64 = 1e-7;

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
            return self.bring_down(points, Goal::Cost(norm), most_steps, ledger, hooks);
        }
        points.iter_mut().try_for_each(|point| self.compass(point, most_steps, ledger, hooks))
    }

    /// From far off, where more than [`FEW`] sparse genes are raised, each point goes to what a
    /// relaxed descent, a threshold and a descent on the rest lead to, where that is better.
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
        let far: Vec<usize> =
            (0..points.len()).filter(|&i| self.raised(&points[i].x, lower).len() > FEW).collect();
        let mut trials: Vec<Point> = far.iter().map(|&i| points[i].clone()).collect();
        self.bring_down(&mut trials, Goal::Squares, SQUARES_STEPS, ledger, hooks)?;
        for trial in &mut trials {
            for gene in self.raised(&trial.x, lower) {
                if trial.x[gene] - lower[gene] < NEGLIGIBLE * (upper[gene] - lower[gene]) {
                    trial.x[gene] = lower[gene];
                }
            }
            // Known as soon as the descent linearizes there.
            trial.cost = f64::INFINITY;
        }
        self.bring_down(&mut trials, Goal::Cost(norm), MOST_STEPS, ledger, hooks)?;
        for (&i, trial) in far.iter().zip(&trials) {
            points[i].take(&trial.x, trial.cost);
        }
        Ok(())
    }

    /// Sparse genes above their lower bound.
    pub(super) fn raised(&self, x: &[f64], lower: &[f64]) -> Vec<usize> {
        (0..x.len()).filter(|&gene| self.composition.sparse[gene] && x[gene] > lower[gene]).collect()
    }

    /// Brings each of `points` down with at most `most_steps` steps: none gets worse in J, where that is the goal; for
    /// squares each goes to where they are small, whatever J is there.
    fn bring_down<E: Evaluator>(
        &self,
        points: &mut [Point],
        goal: Goal,
        most_steps: usize,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let batch: Vec<f64> = points.iter().flat_map(|point| point.x.clone()).collect();
        let found = ledger.linearizations(&batch, hooks)?;
        let mut descents: Vec<Descent> =
            points.iter().zip(found).map(|(point, here)| Descent::new(point, here)).collect();
        for _ in 0..most_steps {
            for descent in &mut descents {
                descent.propose(goal, &self.composition, ledger);
            }
            let batch: Vec<f64> = descents
                .iter()
                .filter(|descent| !descent.done)
                .flat_map(|descent| descent.trial.clone())
                .collect();
            if batch.is_empty() {
                break;
            }
            let mut found = ledger.linearizations(&batch, hooks)?.into_iter();
            for (descent, point) in descents.iter_mut().zip(points.iter_mut()) {
                if descent.done {
                    continue;
                }
                descent.accept(goal, found.next().flatten());
                match goal {
                    Goal::Cost(_) => point.take(&descent.x, descent.here.cost),
                    Goal::Squares => point.settle(&descent.x, descent.here.cost),
                }
            }
        }
        Ok(())
    }

    /// Brings `point` down without derivatives; it never gets worse.
    fn compass<E: Evaluator>(
        &self,
        point: &mut Point,
        most_steps: usize,
        ledger: &mut Ledger<'_, E>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        let end = ledger.evaluations.saturating_add(self.allowance);
        let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
        let free: Vec<usize> = (0..point.x.len())
            .filter(|&gene| {
                upper[gene] > lower[gene] && !(self.composition.sparse[gene] && point.x[gene] == lower[gene])
            })
            .collect();
        let n = point.x.len();
        let (mut batch, mut costs) = (Vec::new(), Vec::new());
        let mut size = FIRST_STEP;
        for _ in 0..most_steps {
            if size < LEAST_STEP || ledger.evaluations >= end || free.is_empty() {
                break;
            }
            batch.clear();
            for &gene in &free {
                for sign in [1.0, -1.0] {
                    let mut trial = point.x.clone();
                    trial[gene] += sign * size * (upper[gene] - lower[gene]);
                    ledger.repair(&mut trial);
                    batch.extend(trial);
                }
            }
            ledger.all_costs(&batch, &mut costs, hooks)?;
            let before = point.clone();
            let mut together = point.x.clone();
            let mut gained = 0;
            for (row, &cost) in batch.chunks_exact(n).zip(&costs) {
                if cost < before.cost {
                    gained += 1;
                    for (sum, (there, here)) in together.iter_mut().zip(row.iter().zip(&before.x)) {
                        *sum += there - here;
                    }
                }
                point.take(row, cost);
            }
            if gained == 0 {
                size *= 0.5;
            } else if gained > 1 {
                ledger.repair(&mut together);
                ledger.all_costs(&together, &mut costs, hooks)?;
                point.take(&together, costs[0]);
            }
        }
        Ok(())
    }
}

// ---- descent

/// First trust radius, as a fraction of each gene's range.
const FIRST_RADIUS: f64 = 0.25;

/// A trust radius or a foretold relative gain below this ends a descent.
const LEAST_RADIUS: f64 = 1e-7;
const LEAST_GAIN: f64 = 1e-9;

/// Gains foretold below this, relative to J, are not worth a second try when the first failed.
const DOUBTFUL_GAIN: f64 = 1e-6;

/// Of squares: most steps, and the foretold relative gain that ends them; what is near is for others to refine.
const SQUARES_STEPS: usize = 25;
const SQUARES_GAIN: f64 = 1e-3;

/// What is brought down.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goal {
    /// J, whose residuals have this norm.
    Cost(Norm),
    /// Σ e² of all genes, without a price.
    Squares,
}

impl Goal {
    /// Its value at a linearization.
    fn of(self, at: &Linearization) -> f64 {
        match self {
            Self::Cost(_) => at.cost,
            Self::Squares => at.residuals.iter().map(|e| e * e).sum(),
        }
    }
}

/// One descent under way.
struct Descent {
    x: Vec<f64>,
    here: Linearization,
    /// The gene of each column of the step.
    free: Vec<usize>,
    radius: f64,
    trial: Vec<f64>,
    foretold: f64,
    done: bool,
}

impl Descent {
    fn new(point: &Point, here: Option<Linearization>) -> Self {
        let done = here.is_none();
        Self {
            x: point.x.clone(),
            here: here.unwrap_or_default(),
            free: Vec::new(),
            radius: FIRST_RADIUS,
            trial: point.x.clone(),
            foretold: 0.0,
            done,
        }
    }

    /// Writes the next trial, or is done.
    fn propose<E: Evaluator>(&mut self, goal: Goal, composition: &Composition, ledger: &Ledger<'_, E>) {
        if self.done {
            return;
        }
        let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
        let width = |gene: usize| upper[gene] - lower[gene];
        self.free.clear();
        self.free.extend((0..self.x.len()).filter(|&gene| {
            let rests = composition.sparse[gene] && self.x[gene] == lower[gene];
            width(gene) > 0.0 && !(rests && goal != Goal::Squares)
        }));
        if self.free.is_empty() {
            self.done = true;
            return;
        }
        // In units of each gene's range.
        let (n, x) = (self.x.len(), &self.x);
        let scaled = |values: &[f64]| -> Vec<f64> {
            values
                .chunks_exact(n)
                .flat_map(|row| self.free.iter().map(|&gene| row[gene] * width(gene)))
                .collect()
        };
        let room = |gene: usize, end: f64| (end - x[gene]) / width(gene);
        let low = self.free.iter().map(|&gene| room(gene, lower[gene]).max(-self.radius));
        let high = self.free.iter().map(|&gene| room(gene, upper[gene]).min(self.radius));
        let (low, high): (Vec<f64>, Vec<f64>) = (low.collect(), high.collect());
        let (norm, price, least_gain) = match goal {
            Goal::Cost(norm) => (norm, scaled(&composition.price), LEAST_GAIN),
            Goal::Squares => (Norm::Squared, vec![0.0; self.free.len()], SQUARES_GAIN),
        };
        let problem = Subproblem {
            norm,
            residuals: &self.here.residuals,
            jacobian: &scaled(&self.here.jacobian),
            price: &price,
            low: &low,
            high: &high,
        };
        let step = problem.solve();
        self.foretold = problem.value(&vec![0.0; step.len()]) - problem.value(&step);
        self.trial.copy_from_slice(&self.x);
        for ((&gene, &d), &least) in self.free.iter().zip(&step).zip(&low) {
            self.trial[gene] =
                if d == least && least > -self.radius { lower[gene] } else { self.x[gene] + d * width(gene) };
        }
        ledger.repair(&mut self.trial);
        // Written so that NaN, of residuals that are not finite, ends the descent too.
        self.done = !(self.foretold > least_gain * goal.of(&self.here).abs()) || self.trial == self.x;
    }

    fn accept(&mut self, goal: Goal, there: Option<Linearization>) {
        let Some(there) = there else {
            self.done = true;
            return;
        };
        let (before, after) = (goal.of(&self.here), goal.of(&there));
        let share = (before - after) / self.foretold;
        if share > 0.75 {
            self.radius = (2.0 * self.radius).min(1.0);
        } else if !(share >= 0.25) {
            self.radius *= 0.25;
            self.done = self.foretold < DOUBTFUL_GAIN * before.abs();
        }
        if after < before {
            self.x.copy_from_slice(&self.trial);
            self.here = there;
        }
        self.done |= self.radius < LEAST_RADIUS;
    }
}

// ---- subproblem

/// The model and its box.
pub(super) struct Subproblem<'a> {
    pub(super) norm: Norm,
    /// e, m of them.
    pub(super) residuals: &'a [f64],
    /// A, m x n, row by row.
    pub(super) jacobian: &'a [f64],
    /// c, n of them.
    pub(super) price: &'a [f64],
    /// Lower ends of the box; each below its upper end.
    pub(super) low: &'a [f64],
    /// Upper ends of the box.
    pub(super) high: &'a [f64],
}

impl Subproblem<'_> {
    /// The value of the model at `d`, without the price of the point the step starts from.
    pub(super) fn value(&self, d: &[f64]) -> f64 {
        let norm: f64 = self
            .residuals
            .iter()
            .zip(self.times(d))
            .map(|(e, change)| match self.norm {
                Norm::Absolute => (e + change).abs(),
                Norm::Squared => (e + change).powi(2),
            })
            .sum();
        norm + dot(self.price, d)
    }

    /// A d.
    pub(super) fn times(&self, d: &[f64]) -> Vec<f64> {
        self.jacobian.chunks_exact(d.len()).map(|row| dot(row, d)).collect()
    }

    /// Aᵀ y.
    pub(super) fn transposed_times(&self, y: &[f64]) -> Vec<f64> {
        let n = self.low.len();
        let mut sum = vec![0.0; n];
        for (row, &y) in self.jacobian.chunks_exact(n).zip(y) {
            for (sum, a) in sum.iter_mut().zip(row) {
                *sum += y * a;
            }
        }
        sum
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Most iterations; some 15 are typical.
const MOST_ITERATIONS: usize = 50;

/// Duality gap, relative to the cost at the start, at which the step is found: squares count as such.
const GAP: (f64, f64) = (1e-10, 1e-18);

/// A component this near to a bound, relative to the box, lies on it.
const ON_BOUND: f64 = 1e-7;

/// The iterate.
struct Iterate {
    d: Vec<f64>,
    /// Slopes of the norm, y.
    y: Vec<f64>,
    /// The positive and the negative part of each residual, both kept above zero; for Σ |r| only.
    u: Vec<f64>,
    v: Vec<f64>,
    z_low: Vec<f64>,
    z_high: Vec<f64>,
}

/// A direction for each part of the [`Iterate`].
type Direction = Iterate;

impl Subproblem<'_> {
    /// The step; inside the box, to the tolerance of the gap.
    pub(super) fn solve(&self) -> Vec<f64> {
        let mut at = self.start();
        let n = at.d.len();
        let (products, tolerance) = match self.norm {
            Norm::Absolute => (2 * (at.u.len() + n), GAP.0),
            Norm::Squared => (2 * n, GAP.1),
        };
        let value = self.value(&vec![0.0; n]).abs();
        let mut last_gap = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let gap = self.gap(&at, None);
            if gap <= tolerance * value || gap >= last_gap * 0.999 {
                break;
            }
            last_gap = gap;
            let Some(factor) = Factor::of(self.normal_matrix(&at), n) else {
                break;
            };
            let affine = self.direction(&at, &factor, 0.0, None);
            let reached = self.gap(&at, Some((&affine, self.length(&at, &affine).min(1.0))));
            let mu = (reached / gap).powi(3) * gap / products as f64;
            let direction = self.direction(&at, &factor, mu, Some(&affine));
            let length = (0.995 * self.length(&at, &direction)).min(1.0);
            at.advance(&direction, length);
        }
        for j in 0..n {
            let width = self.high[j] - self.low[j];
            if at.d[j] - self.low[j] <= ON_BOUND * width {
                at.d[j] = self.low[j];
            } else if self.high[j] - at.d[j] <= ON_BOUND * width {
                at.d[j] = self.high[j];
            }
        }
        at.d
    }

    fn start(&self) -> Iterate {
        let n = self.low.len();
        let d: Vec<f64> = (0..n).map(|j| 0.5 * (self.low[j] + self.high[j])).collect();
        let r: Vec<f64> = self.residuals.iter().zip(self.times(&d)).map(|(e, c)| e + c).collect();
        let m = r.len();
        let room = r.iter().map(|r| r.abs()).sum::<f64>() / m.max(1) as f64 + f64::MIN_POSITIVE.sqrt();
        let (y, u, v) = match self.norm {
            Norm::Absolute => (
                vec![0.0; m],
                r.iter().map(|r| r.max(0.0) + room).collect(),
                r.iter().map(|r| (-r).max(0.0) + room).collect(),
            ),
            Norm::Squared => (r.iter().map(|r| 2.0 * r).collect(), vec![], vec![]),
        };
        // z_low − z_high = c + Aᵀ y, both positive.
        let g: Vec<f64> = self.transposed_times(&y).iter().zip(self.price).map(|(a, c)| a + c).collect();
        // Room for both, in the unit of the cost over the width of the box.
        let extra: Vec<f64> =
            (0..n).map(|j| room * (1 + m) as f64 / (n as f64 * (self.high[j] - self.low[j]))).collect();
        Iterate {
            d,
            y,
            u,
            v,
            z_low: g.iter().zip(&extra).map(|(g, more)| g.max(0.0) + more).collect(),
            z_high: g.iter().zip(&extra).map(|(g, more)| (-g).max(0.0) + more).collect(),
        }
    }

    /// The sum of all products, at the point or as far along a direction as given.
    fn gap(&self, at: &Iterate, along: Option<(&Direction, f64)>) -> f64 {
        let moved = |x: f64, dx: fn(&Direction) -> &Vec<f64>, i: usize| {
            along.map_or(x, |(direction, length)| x + length * dx(direction)[i])
        };
        let mut gap = 0.0;
        for i in 0..at.u.len() {
            let y = moved(at.y[i], |d| &d.y, i);
            gap += moved(at.u[i], |d| &d.u, i) * (1.0 - y) + moved(at.v[i], |d| &d.v, i) * (1.0 + y);
        }
        for j in 0..at.d.len() {
            let d = moved(at.d[j], |d| &d.d, j);
            gap += (d - self.low[j]) * moved(at.z_low[j], |d| &d.z_low, j)
                + (self.high[j] - d) * moved(at.z_high[j], |d| &d.z_high, j);
        }
        gap
    }

    fn weight(&self, at: &Iterate, i: usize) -> f64 {
        match self.norm {
            Norm::Absolute => (at.u[i] / (1.0 - at.y[i]) + at.v[i] / (1.0 + at.y[i])).recip(),
            Norm::Squared => 2.0,
        }
    }

    /// Aᵀ W A + Z, lower triangle of an n x n matrix, row by row.
    fn normal_matrix(&self, at: &Iterate) -> Vec<f64> {
        let n = at.d.len();
        let mut matrix = vec![0.0; n * n];
        for (i, row) in self.jacobian.chunks_exact(n).enumerate() {
            let weight = self.weight(at, i);
            for p in 0..n {
                let scaled = weight * row[p];
                for q in 0..=p {
                    matrix[p * n + q] += scaled * row[q];
                }
            }
        }
        for j in 0..n {
            matrix[j * n + j] +=
                at.z_low[j] / (at.d[j] - self.low[j]) + at.z_high[j] / (self.high[j] - at.d[j]);
        }
        matrix
    }

    /// Newton's direction to products μ, less the products of `second`'s own changes.
    fn direction(&self, at: &Iterate, factor: &Factor, mu: f64, second: Option<&Direction>) -> Direction {
        let (m, n) = (at.u.len(), at.d.len());
        let twice = |a: fn(&Direction) -> &Vec<f64>, b: fn(&Direction) -> &Vec<f64>, i: usize| {
            second.map_or(0.0, |s| a(s)[i] * b(s)[i])
        };
        // What each product u (1 − y), v (1 + y), (d − low) z_low, (high − d) z_high must still change by.
        let du: Vec<f64> =
            (0..m).map(|i| mu - at.u[i] * (1.0 - at.y[i]) + twice(|s| &s.u, |s| &s.y, i)).collect();
        let dv: Vec<f64> =
            (0..m).map(|i| mu - at.v[i] * (1.0 + at.y[i]) - twice(|s| &s.v, |s| &s.y, i)).collect();
        let dl: Vec<f64> = (0..n)
            .map(|j| mu - (at.d[j] - self.low[j]) * at.z_low[j] - twice(|s| &s.d, |s| &s.z_low, j))
            .collect();
        let dh: Vec<f64> = (0..n)
            .map(|j| mu - (self.high[j] - at.d[j]) * at.z_high[j] + twice(|s| &s.d, |s| &s.z_high, j))
            .collect();
        // W q, where u and v would move apart by q without any step.
        let pull: Vec<f64> = (0..m)
            .map(|i| self.weight(at, i) * (du[i] / (1.0 - at.y[i]) - dv[i] / (1.0 + at.y[i])))
            .collect();
        let mut d = if m == 0 { vec![0.0; n] } else { self.transposed_times(&pull) };
        for j in 0..n {
            d[j] += dl[j] / (at.d[j] - self.low[j]) - dh[j] / (self.high[j] - at.d[j]);
        }
        factor.solve(&mut d);
        let change = self.times(&d);
        let y: Vec<f64> = match self.norm {
            Norm::Absolute => (0..m).map(|i| self.weight(at, i) * change[i] - pull[i]).collect(),
            Norm::Squared => change.iter().map(|c| 2.0 * c).collect(),
        };
        Direction {
            u: (0..m).map(|i| (du[i] + at.u[i] * y[i]) / (1.0 - at.y[i])).collect(),
            v: (0..m).map(|i| (dv[i] - at.v[i] * y[i]) / (1.0 + at.y[i])).collect(),
            z_low: (0..n).map(|j| (dl[j] - at.z_low[j] * d[j]) / (at.d[j] - self.low[j])).collect(),
            z_high: (0..n).map(|j| (dh[j] + at.z_high[j] * d[j]) / (self.high[j] - at.d[j])).collect(),
            d,
            y,
        }
    }

    /// How far the direction can be followed until a factor of a product reaches zero; at most 1e3.
    fn length(&self, at: &Iterate, direction: &Direction) -> f64 {
        let mut length = 1e3_f64;
        let mut limit = |value: f64, change: f64| {
            if change < 0.0 {
                length = length.min(-value / change);
            }
        };
        for i in 0..at.u.len() {
            limit(at.u[i], direction.u[i]);
            limit(at.v[i], direction.v[i]);
            limit(1.0 - at.y[i], -direction.y[i]);
            limit(1.0 + at.y[i], direction.y[i]);
        }
        for j in 0..at.d.len() {
            limit(at.d[j] - self.low[j], direction.d[j]);
            limit(self.high[j] - at.d[j], -direction.d[j]);
            limit(at.z_low[j], direction.z_low[j]);
            limit(at.z_high[j], direction.z_high[j]);
        }
        length
    }
}

impl Iterate {
    fn advance(&mut self, direction: &Direction, length: f64) {
        let pairs = [
            (&mut self.d, &direction.d),
            (&mut self.y, &direction.y),
            (&mut self.u, &direction.u),
            (&mut self.v, &direction.v),
            (&mut self.z_low, &direction.z_low),
            (&mut self.z_high, &direction.z_high),
        ];
        for (values, changes) in pairs {
            for (value, change) in values.iter_mut().zip(changes) {
                *value += length * change;
            }
        }
    }
}

/// L of a positive definite matrix L Lᵀ, row by row.
pub(super) struct Factor {
    n: usize,
    l: Vec<f64>,
}

impl Factor {
    /// Factor of the n x n matrix whose lower triangle is given, row by row; `None` where it is not
    /// positive definite at working precision.
    pub(super) fn of(mut a: Vec<f64>, n: usize) -> Option<Self> {
        for j in 0..n {
            for i in j..n {
                let done: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
                let rest = a[i * n + j] - done;
                a[i * n + j] = if i > j {
                    rest / a[j * n + j]
                } else if rest > 0.0 && rest.is_finite() {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Self { n, l: a })
    }

    /// A⁻¹ b in place of b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let (n, l) = (self.n, &self.l);
        for i in 0..n {
            let done: f64 = (0..i).map(|k| l[i * n + k] * b[k]).sum();
            b[i] = (b[i] - done) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
            b[i] = (b[i] - done) / l[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(norm: Norm, e: &[f64], a: &[f64], price: &[f64], reach: f64) -> Vec<f64> {
        let (low, high) = (vec![-reach; price.len()], vec![reach; price.len()]);
        let problem = Subproblem { norm, residuals: e, jacobian: a, price, low: &low, high: &high };
        problem.solve()
    }

    #[test]
    fn one_unknown_goes_to_the_median_the_mean_or_the_end_of_the_box() {
        let (e, ones) = ([3.0, -1.0, 10.0, 2.0, 4.0], [1.0; 5]);
        let at = |norm, price, reach| solve(norm, &e, &ones, &[price], reach)[0];
        assert!((at(Norm::Absolute, 0.0, 20.0) + 3.0).abs() < 1e-8);
        // Σ (e + d)² + c d: d = −mean − c / 10.
        assert!((at(Norm::Squared, 5.0, 20.0) + 3.6 + 0.5).abs() < 1e-8);
        // Σ |e + d| + 2 d turns where one is above and three are below.
        assert!((at(Norm::Absolute, 2.0, 20.0) + 4.0).abs() < 1e-8);
        for norm in [Norm::Absolute, Norm::Squared] {
            assert_eq!(at(norm, 0.0, 1.0), -1.0);
        }
    }

    #[test]
    fn a_consistent_system_is_solved_whatever_the_flat_directions() {
        // Twelve residuals of four unknowns, the last two of which act as one.
        let a: Vec<f64> = (0..12)
            .flat_map(|i| {
                let at = |k: f64| (k * f64::from(i) + 0.3 * k).sin();
                [at(0.7), at(1.9), at(0.4), at(0.4)]
            })
            .collect();
        let truth = [0.3, -0.2, 0.15, 0.1];
        let e: Vec<f64> =
            a.chunks_exact(4).map(|row| -row.iter().zip(truth).map(|(a, x)| a * x).sum::<f64>()).collect();
        for norm in [Norm::Absolute, Norm::Squared] {
            let d = solve(norm, &e, &a, &[0.0; 4], 1.0);
            assert!((d[0] - 0.3).abs() < 1e-6 && (d[1] + 0.2).abs() < 1e-6, "{d:?}");
            assert!((d[2] + d[3] - 0.25).abs() < 1e-6, "{d:?}");
        }
    }

    #[test]
    fn no_neighbour_of_a_step_is_better() {
        let a: Vec<f64> = (0..40).map(|i| (1.7 * f64::from(i * i)).cos()).collect();
        let e: Vec<f64> = (0..10).map(|i| (2.9 * f64::from(i)).sin()).collect();
        let price = [0.1, 0.3, 0.0, -0.2];
        for (norm, reach) in [(Norm::Absolute, 0.2), (Norm::Absolute, 5.0), (Norm::Squared, 5.0)] {
            let (low, high) = ([-reach; 4], [reach; 4]);
            let problem =
                Subproblem { norm, residuals: &e, jacobian: &a, price: &price, low: &low, high: &high };
            let d = problem.solve();
            let best = problem.value(&d);
            for k in 0..200 {
                let mut near = d.clone();
                for (j, x) in near.iter_mut().enumerate() {
                    let shift = 1e-3 * (f64::from(k) * 1.3 + 2.1 * j as f64).sin();
                    *x = (*x + shift).clamp(-reach, reach);
                }
                assert!(problem.value(&near) >= best - 1e-9, "{norm:?} {reach}");
            }
        }
    }

    #[test]
    fn a_factor_solves_and_refuses_what_is_not_positive_definite() {
        // Rows of a 3 x 3 matrix, its upper triangle ignored.
        let a = vec![4.0, 9.0, 9.0, 2.0, 5.0, 9.0, -2.0, 1.0, 6.0];
        let mut b = [4.0 + 4.0 - 6.0, 2.0 + 10.0 + 3.0, -2.0 + 2.0 + 18.0];
        Factor::of(a, 3).unwrap().solve(&mut b);
        for (x, expected) in b.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - expected).abs() < 1e-14, "{b:?}");
        }
        assert!(Factor::of(vec![1.0, 0.0, 2.0, 1.0], 2).is_none());
        assert!(Factor::of(vec![f64::NAN], 1).is_none());
    }
}
