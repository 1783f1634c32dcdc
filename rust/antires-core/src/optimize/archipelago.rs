//! A search under way: islands, the evaluations made, the record, and the loop over the generations.
//!
//! Between two generations it passes over a [tape](crate::optimize::population) as a snapshot. A search that goes on from one gives
//! the bits of one that was never stopped: the snapshot holds the populations, where every random stream stands,
//! the account of evaluations, the record, and what the polish remembers. The bounds, the seed and the sizes are
//! passed first and must be those of the search that takes the snapshot up; that the objective is the same one is
//! for the caller to know.
//!
//! # minimize
//!
//! The search: islands in step, generation by generation.
//!
//! ```text
//! populations at random, guesses among them; evaluate
//! polish the objective's own starting point, which settles on the first island
//! repeat
//!     if every island waits, or it is time to polish: polish the islands' bests; finished if they agree
//!     if every island waits: exchange and search on
//!     finished if a budget is spent
//!     every searching island proposes a generation; evaluate all proposals as one batch; accept
//! ```
//!
//! Each island draws from its own stream of the seed, proposals and acceptance go island by island,
//! and only the evaluation of a batch is parallel. So one seed gives the same bits for any number
//! of threads. Of equal costs the one found first wins, within a batch the lower island, then the
//! lower index. Without a [polish](crate::optimize::polish) islands meet only when all wait, as in the paper. With
//! one, bests that are the same before any exchange were found independently, so that is asked at once.
//!
//! V. Meruane, Model updating using antiresonant frequencies identified from transmissibility
//! functions, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.

use std::ops::ControlFlow;

use super::bounds::Bounds;
use super::island::{Consensus, GeometricSelection, Habitat, Island, exchange};
use super::objective::{Evaluator, Ledger, Objective, ObjectiveEvaluator, Stop};
use super::options::IslandOptions;
use super::outcome::{Failure, History, Hooks, Interrupt, IslandProgress, Outcome, Progress, Status};
use super::polish::{Path, Point, Polish};
use super::population::{Tape, pass_bounds};
use crate::error::{Error, Result};

/// The first bytes of a snapshot: a name and the version of the layout.
const HEADER: u64 = u64::from_le_bytes(*b"antires3");

/// A search under way.
pub(super) struct Archipelago<'a, E: Evaluator> {
    ledger: Ledger<'a, E>,
    habitat: Habitat<'a>,
    islands: Vec<Island>,
    polish: Option<Polish>,
    consensus: Consensus,
    generation: usize,
    /// Generation of the last polish.
    polished: usize,
    /// Evaluations at the last migration.
    evaluations_before: usize,
    history: History,
    // Buffers reused from generation to generation.
    batch: Vec<f64>,
    costs: Vec<f64>,
    progress: Vec<IslandProgress>,
}

impl<'a, E: Evaluator> Archipelago<'a, E> {
    pub(super) fn new(
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
        let best_x = islands[0].candidate(0).to_vec();
        Self {
            polish: Polish::new(&*evaluator, bounds.lower(), options),
            ledger: Ledger::new(evaluator, bounds, options.max_evaluations, best_x),
            habitat,
            islands,
            consensus: Consensus::default(),
            generation: 0,
            polished: 0,
            evaluations_before: 0,
            history: History { n_islands: n, ..History::default() },
            batch: Vec::new(),
            costs: Vec::new(),
            progress: Vec::new(),
        }
    }

    /// Runs to an end and says which.
    pub(super) fn search(&mut self, hooks: &mut Hooks<'_>) -> Result<Status, E::Fault> {
        if hooks.resume.is_none() {
            if let ControlFlow::Break(interrupt) = self.evaluate(hooks)? {
                return Ok(interrupt.into());
            }
            self.record();
            if let ControlFlow::Break(interrupt) = self.begin(hooks)? {
                return Ok(interrupt.into());
            }
        }
        loop {
            if let Some(keep) = &mut hooks.keep {
                keep(self.save());
            }
            let meeting = self.time_to_meet();
            if meeting && let ControlFlow::Break(interrupt) = self.polish_bests(hooks)? {
                return Ok(interrupt.into());
            }
            if let Some(interrupt) = self.report(hooks) {
                return Ok(interrupt.into());
            }
            if meeting && let Some(status) = self.meet() {
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

    /// Polishes the objective's own starting point.
    ///
    /// It settles on the first island only, so that the others' agreement means something.
    fn begin(&mut self, hooks: &mut Hooks<'_>) -> Result<ControlFlow<Interrupt>, E::Fault> {
        let Some(polish) = &mut self.polish else {
            return Ok(ControlFlow::Continue(()));
        };
        let flow = match polish.begin(&mut self.ledger, hooks) {
            Ok(Some(point)) => {
                self.islands[0].welcome(&point.x, point.cost);
                Ok(())
            }
            Ok(None) => return Ok(ControlFlow::Continue(())),
            Err(stop) => Err(stop),
        };
        self.polished(flow)
    }

    /// Polishes every island's best in its place.
    fn polish_bests(&mut self, hooks: &mut Hooks<'_>) -> Result<ControlFlow<Interrupt>, E::Fault> {
        let Some(polish) = &mut self.polish else {
            return Ok(ControlFlow::Continue(()));
        };
        let best = |island: &Island| Point { x: island.best_row().to_vec(), cost: island.best_cost() };
        let mut points: Vec<Point> = self.islands.iter().map(best).collect();
        // Until they exchange, islands but the first, which has the start's optimum, find their own way.
        let alone = self.history.migrations.is_empty();
        let path = |i: usize| if alone && i > 0 { Path::Own } else { Path::Any };
        let flow = polish.run(&mut points, path, &mut self.ledger, hooks);
        for (island, point) in self.islands.iter_mut().zip(&points) {
            island.refine_best(&point.x, point.cost);
        }
        self.polished(flow)
    }

    /// After a polish: what was found on the way is not lost, be it a gain too small for a move or what an
    /// interrupted one had reached; and the record says what it cost.
    fn polished(&mut self, flow: Result<(), Stop<E::Fault>>) -> Result<ControlFlow<Interrupt>, E::Fault> {
        let flow = match flow {
            // The main loop sees a spent budget by itself.
            Ok(()) | Err(Stop::Budget) => ControlFlow::Continue(()),
            Err(Stop::Interrupt(interrupt)) => ControlFlow::Break(interrupt),
            Err(Stop::Fault(fault)) => return Err(fault),
        };
        let known = self.islands.iter().map(Island::best_cost);
        if known.fold(f64::INFINITY, f64::min) > self.ledger.best_cost {
            self.islands[0].welcome(&self.ledger.best_x, self.ledger.best_cost);
        }
        self.history.evaluations.pop();
        let kept = self.history.best_costs.len() - self.islands.len();
        self.history.best_costs.truncate(kept);
        self.record();
        Ok(flow)
    }

    /// Whether all islands wait or, with a polish, enough generations have passed.
    fn time_to_meet(&self) -> bool {
        let interval = self.habitat.options.polish_interval;
        self.all_wait()
            || (self.polish.is_some() && self.generation.saturating_sub(self.polished) >= interval)
    }

    fn all_wait(&self) -> bool {
        self.islands.iter().all(|island| island.waiting)
    }

    /// The islands' bests agree, or are exchanged when it is time to.
    fn meet(&mut self) -> Option<Status> {
        let Habitat { bounds, options, .. } = self.habitat;
        self.polished = self.generation;
        let exchange_now = self.all_wait();
        if exchange_now || self.history.migrations.is_empty() {
            let status = self.consensus.reached(&self.islands, bounds, options, exchange_now);
            if status.is_some() {
                return status;
            }
        }
        if !exchange_now {
            return None;
        }
        if self.ledger.evaluations == self.evaluations_before {
            return Some(Status::Collapsed);
        }
        self.evaluations_before = self.ledger.evaluations;
        self.history.migrations.push(self.generation);
        exchange(&mut self.islands);
        None
    }

    fn budget(&self) -> Option<Status> {
        let options = self.habitat.options;
        if self.ledger.left() == 0 {
            Some(Status::MaxEvaluations)
        } else if options.max_generations.is_some_and(|most| self.generation >= most) {
            Some(Status::MaxGenerations)
        } else {
            None
        }
    }

    fn propose(&mut self) {
        let ledger = &self.ledger;
        for island in self.islands.iter_mut().filter(|island| !island.waiting) {
            island.propose(&self.habitat, &|x| ledger.repair(x));
        }
    }

    /// Evaluates what the islands have pending, as far as the budget goes, and lets them accept.
    ///
    /// After an interrupt the generation is discarded, but what it did evaluate may be the best.
    fn evaluate(&mut self, hooks: &mut Hooks<'_>) -> Result<ControlFlow<Interrupt>, E::Fault> {
        self.batch.clear();
        for island in self.islands.iter().filter(|island| !island.waiting) {
            for &i in &island.pending {
                self.batch.extend_from_slice(island.candidate(i));
            }
        }
        let flow = self.ledger.costs(&self.batch, &mut self.costs, hooks)?;
        if flow.is_break() {
            return Ok(flow);
        }
        let mut costs = &self.costs[..];
        for island in self.islands.iter_mut().filter(|island| !island.waiting) {
            let (own, others) = costs.split_at(island.pending.len().min(costs.len()));
            island.accept(own, self.habitat.options);
            costs = others;
        }
        Ok(flow)
    }

    /// Looks at the islands for the next report.
    fn observe(&mut self) {
        self.progress.clear();
        self.progress.extend(self.islands.iter().map(Island::progress));
    }

    fn record(&mut self) {
        self.observe();
        self.history.evaluations.push(self.ledger.evaluations);
        let costs = self.progress.iter().map(|island| island.best_cost);
        self.history.best_costs.extend(costs);
    }

    fn report(&self, hooks: &mut Hooks<'_>) -> Option<Interrupt> {
        let progress = Progress {
            generation: self.generation,
            evaluations: self.ledger.evaluations,
            migrations: self.history.migrations.len(),
            best_cost: self.ledger.best_cost,
            best_x: &self.ledger.best_x,
            islands: &self.progress,
        };
        hooks.report(&progress).or_else(|| hooks.poll())
    }

    pub(super) fn into_outcome(self, status: Status) -> Outcome {
        Outcome {
            x: self.ledger.best_x,
            fun: self.ledger.best_cost,
            nfev: self.ledger.evaluations,
            njev: self.ledger.linearizations,
            polished: self.polish.is_some(),
            nit: self.generation,
            migrations: self.history.migrations.len(),
            status,
            history: self.history,
            islands: self.islands.into_iter().map(Island::into_final).collect(),
        }
    }
}

impl<E: Evaluator> Archipelago<'_, E> {
    /// The search as it stands between two generations.
    fn save(&mut self) -> Vec<u8> {
        let mut tape = Tape::Writing(Vec::new());
        self.pass(&mut tape);
        match tape {
            Tape::Writing(bytes) => bytes,
            Tape::Reading(_) => unreachable!("writing never fails"),
        }
    }

    /// Takes up a search where it was saved.
    pub(super) fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let mut tape = Tape::Reading(Some(bytes));
        self.pass(&mut tape);
        if !matches!(tape, Tape::Reading(Some([]))) {
            return Err(Error::input(
                "checkpoint",
                format!("{} bytes that do not fit this search", bytes.len()),
                "the snapshot of a search with the same parameters, bounds, options and seed",
            )
            .remedy("Begin anew under another name, or give the same problem and options."));
        }
        self.observe();
        Ok(())
    }

    fn pass(&mut self, tape: &mut Tape<'_>) {
        tape.same(HEADER);
        pass_bounds(self.ledger.bounds, tape);
        tape.same(self.islands.len() as u64);
        self.islands.iter_mut().for_each(|island| island.pass(tape));
        tape.count(&mut self.ledger.evaluations);
        tape.count(&mut self.ledger.linearizations);
        tape.floats(&mut self.ledger.best_x);
        tape.float(&mut self.ledger.best_cost);
        tape.count(&mut self.consensus.in_cost);
        tape.count(&mut self.generation);
        tape.count(&mut self.polished);
        tape.count(&mut self.evaluations_before);
        let history = &mut self.history;
        tape.list(&mut history.evaluations, || 0, Tape::count);
        tape.list(&mut history.best_costs, || 0.0, Tape::float);
        tape.list(&mut history.migrations, || 0, Tape::count);
        tape.same(u64::from(self.polish.is_some()));
        if let Some(polish) = &mut self.polish {
            polish.pass(self.ledger.bounds.n_genes(), tape);
        }
    }
}

// ---- minimize

/// Minimizes the cost that `evaluator` computes, inside `bounds`.
///
/// `guesses` join the initial populations: guess `g` goes to island `g` modulo their number. `seed`
/// determines the search entirely, apart from an interrupt. A search that is interrupted or runs out
/// of its budget still has an outcome: the best so far, and a status that says so. With a
/// snapshot in the hooks the search goes on from there, to the same bits.
pub fn minimize<E: Evaluator>(
    evaluator: &mut E,
    bounds: &Bounds,
    guesses: &[Vec<f64>],
    options: &IslandOptions,
    seed: u64,
    hooks: &mut Hooks<'_>,
) -> Result<Outcome, Failure<E::Fault>> {
    options.validate()?;
    bounds.check_guesses(guesses)?;
    let room = options.islands * options.population;
    if guesses.len() > room {
        let wanted = format!("at most {room}, the individuals of all islands");
        return Err(Error::input("x0", format!("{} guesses", guesses.len()), wanted)
            .remedy("Keep the best of them, or give the islands more individuals.")
            .into());
    }
    let mut archipelago = Archipelago::new(evaluator, bounds, guesses, options, seed);
    if let Some(bytes) = hooks.resume {
        archipelago.restore(bytes)?;
    }
    let status = archipelago.search(hooks).map_err(Failure::Evaluation)?;
    Ok(archipelago.into_outcome(status))
}

/// As [`minimize`], for a native objective evaluated on `threads` threads of the search's own.
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
    minimize(&mut evaluator, bounds, guesses, options, seed, hooks).map_err(|failure| match failure {
        Failure::Input(error) => error,
        Failure::Evaluation(never) => match never {},
    })
}
