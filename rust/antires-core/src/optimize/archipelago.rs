//! The search: islands in step, generation by generation.
//!
//! ```text
//! populations at random, guesses among them; evaluate
//! repeat
//!     if every island waits: finished if their bests agree, else exchange and search on
//!     finished if a budget is spent
//!     every searching island proposes a generation; evaluate all proposals as one batch; accept
//! ```
//!
//! Each island draws from its own stream of the seed, proposals and acceptance go island by island,
//! and only the evaluation of a batch is parallel. So one seed gives the same bits for any number
//! of threads. Of equal costs the one found first wins, within a batch the lower island, then the
//! lower index.
//!
//! V. Meruane, Model updating using antiresonant frequencies identified from transmissibility
//! functions, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.

use std::ops::ControlFlow;

use super::bounds::Bounds;
use super::evaluate::ObjectiveEvaluator;
use super::island::{Habitat, Island};
use super::migration::exchange;
use super::objective::{Candidates, Evaluator, Objective};
use super::options::IslandOptions;
use super::outcome::{
    Failure, History, Hooks, Interrupt, IslandProgress, Outcome, Progress, Status,
};
use super::selection::GeometricSelection;
use super::termination::Consensus;
use crate::error::{Error, Result};

/// Minimizes the cost that `evaluator` computes, inside `bounds`.
///
/// `guesses` join the initial populations: guess `g` goes to island `g` modulo their number. `seed`
/// determines the search entirely, apart from an interrupt. A search that is interrupted or runs out
/// of its budget still has an outcome: the best so far, and a status that says so.
///
/// # Errors
/// [`Failure::Input`] for unusable options or guesses; [`Failure::Evaluation`] with the evaluator's
/// own fault.
pub fn minimize<E: Evaluator>(
    evaluator: &mut E,
    bounds: &Bounds,
    guesses: &[Vec<f64>],
    options: &IslandOptions,
    seed: u64,
    hooks: &mut Hooks<'_>,
) -> std::result::Result<Outcome, Failure<E::Fault>> {
    options.validate()?;
    bounds.check_guesses(guesses)?;
    let room = options.islands * options.population;
    if guesses.len() > room {
        let wanted = format!("at most {room}, the individuals of all islands");
        return Err(Error::input("x0", format!("{} guesses", guesses.len()), wanted).into());
    }
    let mut archipelago = Archipelago::new(evaluator, bounds, guesses, options, seed);
    let status = archipelago.search(hooks).map_err(Failure::Evaluation)?;
    Ok(archipelago.into_outcome(status))
}

/// As [`minimize`], for a native objective evaluated on `threads` threads of the search's own.
///
/// # Errors
/// If `threads`, the options or the guesses are unusable.
pub fn minimize_objective<O: Objective>(
    objective: &O,
    bounds: &Bounds,
    guesses: &[Vec<f64>],
    options: &IslandOptions,
    seed: u64,
    threads: usize,
    hooks: &mut Hooks<'_>,
) -> Result<Outcome> {
    let mut evaluator = ObjectiveEvaluator::new(objective, threads)?;
    minimize(&mut evaluator, bounds, guesses, options, seed, hooks).map_err(|failure| match failure
    {
        Failure::Input(error) => error,
        Failure::Evaluation(never) => match never {},
    })
}

/// A search under way.
struct Archipelago<'a, E: Evaluator> {
    evaluator: &'a mut E,
    habitat: Habitat<'a>,
    islands: Vec<Island>,
    consensus: Consensus,
    generation: usize,
    evaluations: usize,
    /// Evaluations at the last migration.
    evaluations_before: usize,
    best_x: Vec<f64>,
    best_cost: f64,
    history: History,
    // Buffers reused from generation to generation.
    batch: Vec<f64>,
    costs: Vec<f64>,
    progress: Vec<IslandProgress>,
}

impl<'a, E: Evaluator> Archipelago<'a, E> {
    fn new(
        evaluator: &'a mut E,
        bounds: &'a Bounds,
        guesses: &[Vec<f64>],
        options: &'a IslandOptions,
        seed: u64,
    ) -> Self {
        let habitat = Habitat {
            bounds,
            options,
            selection: GeometricSelection::new(options.population, options.selection_pressure),
        };
        let n = options.islands;
        let mut islands: Vec<Island> = (0..n).map(|i| Island::new(i, &habitat, seed)).collect();
        for (g, guess) in guesses.iter().enumerate() {
            islands[g % n].settle(g / n, guess);
        }
        for island in &mut islands {
            island.repair_first(bounds, &|x| evaluator.repair(x));
        }
        Self {
            best_x: islands[0].candidate(0).to_vec(),
            best_cost: f64::INFINITY,
            evaluator,
            habitat,
            islands,
            consensus: Consensus::default(),
            generation: 0,
            evaluations: 0,
            evaluations_before: 0,
            history: History {
                n_islands: n,
                ..History::default()
            },
            batch: Vec::new(),
            costs: Vec::new(),
            progress: Vec::new(),
        }
    }

    /// Runs to an end and says which.
    fn search(&mut self, hooks: &mut Hooks<'_>) -> std::result::Result<Status, E::Fault> {
        if let ControlFlow::Break(interrupt) = self.evaluate(hooks)? {
            return Ok(interrupt.into());
        }
        self.record();
        loop {
            if let Some(interrupt) = self.report(hooks) {
                return Ok(interrupt.into());
            }
            if self.islands.iter().all(Island::waiting)
                && let Some(status) = self.meet()
            {
                return Ok(status);
            }
            if let Some(status) = self.budget() {
                return Ok(status);
            }
            self.propose();
            if let ControlFlow::Break(interrupt) = self.evaluate(hooks)? {
                return Ok(interrupt.into());
            }
            self.generation += 1;
            self.record();
        }
    }

    /// All islands wait: they agree, or exchange.
    fn meet(&mut self) -> Option<Status> {
        let Habitat {
            bounds, options, ..
        } = self.habitat;
        let status = self.consensus.reached(&self.islands, bounds, options);
        if status.is_some() {
            return status;
        }
        if self.evaluations == self.evaluations_before {
            return Some(Status::Collapsed);
        }
        self.evaluations_before = self.evaluations;
        self.history.migrations.push(self.generation);
        exchange(&mut self.islands);
        None
    }

    fn budget(&self) -> Option<Status> {
        let options = self.habitat.options;
        if self.evaluations >= options.max_evaluations {
            Some(Status::MaxEvaluations)
        } else if options
            .max_generations
            .is_some_and(|most| self.generation >= most)
        {
            Some(Status::MaxGenerations)
        } else {
            None
        }
    }

    fn propose(&mut self) {
        let evaluator = &*self.evaluator;
        for island in self.islands.iter_mut().filter(|island| !island.waiting()) {
            island.propose(&self.habitat, &|x| evaluator.repair(x));
        }
    }

    /// Evaluates what the islands have pending, as far as the budget goes, and lets them accept.
    ///
    /// After an interrupt the generation is discarded, but what it did evaluate may be the best.
    fn evaluate(
        &mut self,
        hooks: &mut Hooks<'_>,
    ) -> std::result::Result<ControlFlow<Interrupt>, E::Fault> {
        let Habitat {
            bounds, options, ..
        } = self.habitat;
        let n_genes = bounds.n_genes();
        let left = options.max_evaluations - self.evaluations;
        self.batch.clear();
        let candidates = self
            .islands
            .iter()
            .filter(|island| !island.waiting())
            .flat_map(|island| island.pending().iter().map(|&i| island.candidate(i)));
        for candidate in candidates.take(left) {
            self.batch.extend_from_slice(candidate);
        }
        let batch = Candidates::new(&self.batch, n_genes);
        self.costs.clear();
        self.costs.resize(batch.len(), f64::NAN);
        if !batch.is_empty() {
            let flow = self
                .evaluator
                .evaluate(batch, &mut self.costs, &mut || hooks.poll())?;
            if flow.is_break() {
                self.evaluations += self.costs.iter().filter(|cost| !cost.is_nan()).count();
                self.keep_best();
                return Ok(flow);
            }
        }
        self.evaluations += self.costs.len();
        self.keep_best();
        let mut costs = &self.costs[..];
        for island in self.islands.iter_mut().filter(|island| !island.waiting()) {
            let (own, others) = costs.split_at(island.pending().len().min(costs.len()));
            island.accept(own, options);
            costs = others;
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Makes costs that are not finite the worst, and notes a candidate better than all before.
    fn keep_best(&mut self) {
        let n_genes = self.habitat.bounds.n_genes();
        for (i, cost) in self.costs.iter_mut().enumerate() {
            if !cost.is_finite() {
                *cost = f64::INFINITY;
            }
            if *cost < self.best_cost {
                self.best_cost = *cost;
                self.best_x
                    .copy_from_slice(&self.batch[i * n_genes..][..n_genes]);
            }
        }
    }

    fn record(&mut self) {
        self.progress.clear();
        self.progress
            .extend(self.islands.iter().map(Island::progress));
        self.history.evaluations.push(self.evaluations);
        let costs = self.progress.iter().map(|island| island.best_cost);
        self.history.best_costs.extend(costs);
    }

    fn report(&self, hooks: &mut Hooks<'_>) -> Option<Interrupt> {
        let progress = Progress {
            generation: self.generation,
            evaluations: self.evaluations,
            migrations: self.history.migrations.len(),
            best_cost: self.best_cost,
            best_x: &self.best_x,
            islands: &self.progress,
        };
        hooks.report(&progress).or_else(|| hooks.poll())
    }

    fn into_outcome(self, status: Status) -> Outcome {
        Outcome {
            x: self.best_x,
            fun: self.best_cost,
            nfev: self.evaluations,
            nit: self.generation,
            migrations: self.history.migrations.len(),
            status,
            history: self.history,
            islands: self.islands.into_iter().map(Island::into_final).collect(),
        }
    }
}
