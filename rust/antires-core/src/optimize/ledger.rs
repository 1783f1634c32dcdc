//! The account of a search: every evaluation passes here, is counted, and may be the best so far.
//!
//! The budget is kept to the letter: of a batch that would exceed it, only the first candidates are
//! evaluated. It counts a linearization, which is J and all its slopes at one point, as one evaluation, as it
//! takes one solution of the eigenproblem; how many there were is counted beside.

use std::ops::ControlFlow;

use super::bounds::Bounds;
use super::composition::Linearization;
use super::objective::{Candidates, Evaluator};
use super::outcome::{Hooks, Interrupt};

/// Why an evaluation did not come about in full.
#[derive(Debug)]
pub(super) enum Stop<F> {
    /// A hook asked to stop.
    Interrupt(Interrupt),
    /// The budget is spent.
    Budget,
    /// The evaluator failed.
    Fault(F),
}

/// The evaluator, the evaluations it made, and the best candidate it saw.
pub(super) struct Ledger<'a, E: Evaluator> {
    evaluator: &'a mut E,
    pub(super) bounds: &'a Bounds,
    max_evaluations: usize,
    /// Costs and linearizations: what the budget counts.
    pub(super) evaluations: usize,
    /// The linearizations among them.
    pub(super) linearizations: usize,
    pub(super) best_x: Vec<f64>,
    pub(super) best_cost: f64,
}

impl<'a, E: Evaluator> Ledger<'a, E> {
    /// An empty account; `best_x` stands until an evaluation gives a finite cost.
    pub(super) fn new(
        evaluator: &'a mut E,
        bounds: &'a Bounds,
        max_evaluations: usize,
        best_x: Vec<f64>,
    ) -> Self {
        Self {
            evaluator,
            bounds,
            max_evaluations,
            evaluations: 0,
            linearizations: 0,
            best_x,
            best_cost: f64::INFINITY,
        }
    }

    /// Evaluations left in the budget.
    pub(super) fn left(&self) -> usize {
        self.max_evaluations.saturating_sub(self.evaluations)
    }

    /// The point that shall stand for `x`: repaired and inside the bounds.
    pub(super) fn repair(&self, x: &mut [f64]) {
        self.evaluator.repair(x);
        self.bounds.clip(x);
    }

    /// Writes the costs of `batch`, candidates in a row, to `costs`, as far as the budget goes; costs
    /// that are not finite become the worst, `+inf`.
    ///
    /// After an interrupt the costs already computed still count, and may be the best.
    pub(super) fn costs(
        &mut self,
        batch: &[f64],
        costs: &mut Vec<f64>,
        hooks: &mut Hooks<'_>,
    ) -> Result<ControlFlow<Interrupt>, E::Fault> {
        let n_genes = self.bounds.n_genes();
        let count = (batch.len() / n_genes).min(self.left());
        let batch = Candidates::new(&batch[..count * n_genes], n_genes);
        costs.clear();
        costs.resize(count, f64::NAN);
        if batch.is_empty() {
            return Ok(ControlFlow::Continue(()));
        }
        let flow = self
            .evaluator
            .evaluate(batch, costs, &mut || hooks.poll())?;
        self.evaluations += match flow {
            ControlFlow::Continue(()) => count,
            ControlFlow::Break(_) => costs.iter().filter(|cost| !cost.is_nan()).count(),
        };
        for (i, cost) in costs.iter_mut().enumerate() {
            if !cost.is_finite() {
                *cost = f64::INFINITY;
            }
            self.note(batch.row(i), *cost);
        }
        Ok(flow)
    }

    /// As [`costs`](Self::costs), but a batch that was not evaluated in full is a [`Stop`].
    pub(super) fn all_costs(
        &mut self,
        batch: &[f64],
        costs: &mut Vec<f64>,
        hooks: &mut Hooks<'_>,
    ) -> Result<(), Stop<E::Fault>> {
        match self.costs(batch, costs, hooks).map_err(Stop::Fault)? {
            ControlFlow::Break(interrupt) => Err(Stop::Interrupt(interrupt)),
            ControlFlow::Continue(()) if costs.len() * self.bounds.n_genes() < batch.len() => {
                Err(Stop::Budget)
            }
            ControlFlow::Continue(()) => Ok(()),
        }
    }

    /// The linearizations of `batch`, each counted as one evaluation; `None` where there is none.
    pub(super) fn linearizations(
        &mut self,
        batch: &[f64],
        hooks: &mut Hooks<'_>,
    ) -> Result<Vec<Option<Linearization>>, Stop<E::Fault>> {
        let n_genes = self.bounds.n_genes();
        let wanted = batch.len() / n_genes;
        let count = wanted.min(self.left());
        let batch = Candidates::new(&batch[..count * n_genes], n_genes);
        let mut found = vec![None; count];
        if !batch.is_empty() {
            let flow = self
                .evaluator
                .linearize(batch, &mut found, &mut || hooks.poll())
                .map_err(Stop::Fault)?;
            for (i, linearization) in found.iter().enumerate() {
                if let Some(linearization) = linearization {
                    self.evaluations += 1;
                    self.linearizations += 1;
                    self.note(batch.row(i), linearization.cost);
                }
            }
            if let ControlFlow::Break(interrupt) = flow {
                return Err(Stop::Interrupt(interrupt));
            }
        }
        if count < wanted {
            return Err(Stop::Budget);
        }
        Ok(found)
    }

    fn note(&mut self, x: &[f64], cost: f64) {
        if cost < self.best_cost {
            self.best_cost = cost;
            self.best_x.copy_from_slice(x);
        }
    }
}
