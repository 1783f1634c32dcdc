//! Descent on the continuous genes: sequential linear (or quadratic) programming with a trust region.
//!
//! Each iteration minimizes the linear model of the residuals over the part of the box within a radius
//! of the point ([`step`](super::step)); the radius grows where the model foretold the gain and shrinks
//! where it did not. A sparse gene at its lower bound stays there. Several descents run in step, so that
//! their evaluations form one batch.
//!
//! From a point far off, where many sparse genes are raised, the sum of absolute residuals and its prices have local
//! minima everywhere. `relax` first descends on Σ e² of all genes, sparse ones at rest among them, without prices: a
//! smooth problem that leads near the optimum from most starts.
//!
//! R. Fletcher & E. Sainz de la Maza, Nonlinear programming and nonsmooth optimization by successive
//! linear programming, Math. Program. 43 (1989) 235-256.

use super::super::composition::{Composition, Linearization, Norm};
use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::point::Point;
use super::subproblem::Subproblem;

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

/// Brings each of `points` down to a local minimum, with at most `most_steps` steps; none gets worse.
pub(super) fn descend<E: Evaluator>(
    points: &mut [Point],
    norm: Norm,
    composition: &Composition,
    most_steps: usize,
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<(), Stop<E::Fault>> {
    let goal = Goal::Cost(norm);
    bring_down(points, goal, composition, most_steps, ledger, hooks)
}

/// Moves each of `points` to where Σ e² is small, whatever J is there.
pub(super) fn relax<E: Evaluator>(
    points: &mut [Point],
    composition: &Composition,
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<(), Stop<E::Fault>> {
    let goal = Goal::Squares;
    bring_down(points, goal, composition, SQUARES_STEPS, ledger, hooks)
}

fn bring_down<E: Evaluator>(
    points: &mut [Point],
    goal: Goal,
    composition: &Composition,
    most_steps: usize,
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<(), Stop<E::Fault>> {
    let batch: Vec<f64> = points.iter().flat_map(|point| point.x.clone()).collect();
    let found = ledger.linearizations(&batch, hooks)?;
    let mut descents: Vec<Descent> = points
        .iter()
        .zip(found)
        .map(|(point, here)| Descent::new(point, here))
        .collect();
    for _ in 0..most_steps {
        for descent in &mut descents {
            descent.propose(goal, composition, ledger);
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
    fn propose<E: Evaluator>(
        &mut self,
        goal: Goal,
        composition: &Composition,
        ledger: &Ledger<'_, E>,
    ) {
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
        let low = self
            .free
            .iter()
            .map(|&gene| room(gene, lower[gene]).max(-self.radius));
        let high = self
            .free
            .iter()
            .map(|&gene| room(gene, upper[gene]).min(self.radius));
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
            self.trial[gene] = if d == least && least > -self.radius {
                lower[gene]
            } else {
                self.x[gene] + d * width(gene)
            };
        }
        ledger.repair(&mut self.trial);
        // Written so that NaN, of residuals that are not finite, ends the descent too.
        self.done =
            !(self.foretold > least_gain * goal.of(&self.here).abs()) || self.trial == self.x;
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
