//! What is minimized: `J(x)`, and what an objective may tell besides for the polish.
//!
//! `x` holds `n` genes inside box [bounds](super::Bounds). Two layers meet here:
//!
//! - [`Objective`]: a native cost of one candidate, called from many threads at once;
//! - [`Evaluator`]: the costs of a whole batch of candidates. The search calls only this one, once
//!   per generation. [`ObjectiveEvaluator`](super::ObjectiveEvaluator) makes an evaluator of any
//!   objective; a binding writes its own, so that a foreign function is entered once per
//!   generation and its exception travels through as [`Evaluator::Fault`].
//!
//! A cost that is not finite (`+inf`, `-inf`, `NaN`) counts as the worst possible: it becomes
//! `+inf` as the search takes it in.
//!
//! # composition
//!
//! What an objective may tell beyond its value: how it is composed, and its first derivatives.
//!
//! ```text
//! J(x) = ρ(e(x)) + Σ_i price_i x_i + (a toll on each sparse gene that is above its lower bound)
//! e(x + d) ≈ e(x) + A d
//! ```
//!
//! With this a local [polish](crate::optimize::polish) can solve for all continuous genes at once and treat the
//! toll, which no derivative knows, by moves from gene to gene.
//!
//! # evaluate
//!
//! Many evaluations at once: the same numbers in the same order for any number of threads.
//!
//! Workers take candidates one by one from a common counter, so an expensive candidate delays
//! nobody; each result goes to its candidate's place, so who computed it leaves no trace.
//!
//! The threads belong to the [`Workers`] that made them and end with it. The process-wide rayon
//! pool is never entered: after a `fork` its threads are gone and waiting for them never ends.
//! While the workers compute, the calling thread sleeps and wakes every [`POLL_INTERVAL`] to ask
//! whether to stop. One thread means no thread: everything runs inline, and the question is asked
//! between candidates.
//!
//! # ledger
//!
//! The account of a search: every evaluation passes here, is counted, and may be the best so far.
//!
//! The budget is kept to the letter: of a batch that would exceed it, only the first candidates are
//! evaluated. It counts a linearization, which is J and all its slopes at one point, as one evaluation, as it
//! takes one solution of the eigenproblem; how many there were is counted beside.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use super::bounds::Bounds;
use super::outcome::{Hooks, Interrupt};
use crate::error::{Error, Result};

/// A cost function of one candidate, callable from several threads at once.
///
/// Any `Fn(&[f64]) -> f64` that is `Sync` is an objective without workspace and without repair.
pub trait Objective: Sync {
    /// Buffers that one thread reuses from candidate to candidate.
    type Workspace: Send;

    /// New buffers; called once per thread and run.
    fn workspace(&self) -> Self::Workspace;

    /// The cost of `x`.
    ///
    /// Must depend on `x` alone, never on what an earlier candidate left in `workspace`: which
    /// thread evaluates which candidate is not determined.
    fn cost(&self, x: &[f64], workspace: &mut Self::Workspace) -> f64;

    /// Moves a proposed `x` to the point that shall stand for it, for example by snapping
    /// negligible genes to zero. The result, clipped to the bounds, is what is evaluated and kept.
    fn repair(&self, _x: &mut [f64]) {}

    /// How the cost is composed, where the objective tells.
    fn composition(&self) -> Option<Composition> {
        None
    }

    /// The cost and its residuals' first derivatives at `x`, where the objective can tell; under the same
    /// rule as [`cost`](Self::cost), and with the same cost.
    fn linearize(&self, _x: &[f64], _workspace: &mut Self::Workspace) -> Option<Linearization> {
        None
    }
}

impl<F: Fn(&[f64]) -> f64 + Sync> Objective for F {
    type Workspace = ();

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        self(x)
    }
}

/// Candidates to be evaluated together: an `m x n` matrix, one candidate per row.
#[derive(Debug, Clone, Copy)]
pub struct Candidates<'a> {
    genes: &'a [f64],
    n_genes: usize,
}

impl<'a> Candidates<'a> {
    /// The rows of `genes`, each `n_genes` long, in row-major order.
    ///
    /// # Panics
    /// If `genes` does not divide into rows of `n_genes`.
    pub fn new(genes: &'a [f64], n_genes: usize) -> Self {
        assert!(
            n_genes > 0 && genes.len().is_multiple_of(n_genes),
            "{} values do not divide into rows of {n_genes}",
            genes.len()
        );
        Self { genes, n_genes }
    }

    /// The number of candidates, `m`.
    pub fn len(&self) -> usize {
        self.genes.len() / self.n_genes
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.genes.is_empty()
    }

    /// The number of genes of each candidate, `n`.
    pub fn n_genes(&self) -> usize {
        self.n_genes
    }

    /// Candidate `i`.
    pub fn row(&self, i: usize) -> &'a [f64] {
        &self.genes[i * self.n_genes..][..self.n_genes]
    }

    /// All values in row-major order.
    pub fn as_slice(&self) -> &'a [f64] {
        self.genes
    }
}

/// The costs of a batch of candidates.
pub trait Evaluator {
    /// What can go wrong in an evaluation, handed through the search untouched.
    type Fault;

    /// As [`Objective::repair`].
    fn repair(&self, _x: &mut [f64]) {}

    /// Writes the cost of candidate `i` to `costs[i]`.
    ///
    /// `costs` arrives filled with `NaN` and has one entry per candidate; there is at least one.
    /// A long evaluation calls `poll` every now and then (some 20 ms apart, on the calling
    /// thread), and when that returns an interrupt gives up and breaks with it; costs written
    /// until then are still compared with the best so far.
    fn evaluate(
        &mut self,
        candidates: Candidates<'_>,
        costs: &mut [f64],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Self::Fault>;

    /// As [`Objective::composition`].
    fn composition(&self) -> Option<Composition> {
        None
    }

    /// Writes the linearization of candidate `i` to `found[i]`, under the rules of
    /// [`evaluate`](Self::evaluate); `found` arrives filled with `None`.
    fn linearize(
        &mut self,
        _candidates: Candidates<'_>,
        _found: &mut [Option<Linearization>],
        _poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Self::Fault> {
        Ok(ControlFlow::Continue(()))
    }
}

// ---- composition

/// The norm ρ of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Norm {
    /// Σ |e|.
    Absolute,
    /// Σ e².
    Squared,
}

/// The parts of J.
#[derive(Debug, Clone, PartialEq)]
pub struct Composition {
    /// The norm of the residuals, where the objective can also be linearized.
    pub norm: Option<Norm>,
    /// Where a search begins that knows nothing: nothing damaged, everything nominal. Its sparse genes
    /// are put to their lower bounds.
    pub start: Option<Vec<f64>>,
    /// The slope that J has by itself, apart from the residuals; one a gene.
    pub price: Vec<f64>,
    /// Which genes rest at their lower bound unless they earn their toll.
    pub sparse: Vec<bool>,
}

impl Composition {
    /// What can be said of any function: genes with lower bound 0 may be sparse.
    pub(super) fn unknown(lower: &[f64]) -> Self {
        Self {
            norm: None,
            start: None,
            price: vec![0.0; lower.len()],
            sparse: lower.iter().map(|&low| low == 0.0).collect(),
        }
    }
}

/// J and its residuals near one candidate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Linearization {
    /// J, exactly the objective's cost there.
    pub cost: f64,
    /// e, m of them.
    pub residuals: Vec<f64>,
    /// A = de/dx, m x n, row by row.
    pub jacobian: Vec<f64>,
}

// ---- evaluate

/// How long the calling thread waits for workers before it asks again whether to stop.
pub const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// A private set of threads.
#[derive(Debug)]
pub struct Workers {
    /// None: everything runs on the calling thread.
    pool: Option<rayon::ThreadPool>,
}

impl Workers {
    /// Starts `threads` threads, or none where `threads` is 1.
    pub fn new(threads: usize) -> Result<Self> {
        let pool = match threads {
            0 => {
                return Err(Error::input("threads", 0, "at least 1")
                    .remedy("Use 1 to evaluate on the calling thread."));
            }
            1 => None,
            _ => Some(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .thread_name(|i| format!("antires-{i}"))
                    .build()
                    .map_err(|error| {
                        Error::input("threads", threads, "a number the system can start")
                            .remedy(format!("The system says: {error}."))
                    })?,
            ),
        };
        Ok(Self { pool })
    }

    /// Computes `task(i, workspace)` for every `i < n` and delivers `(i, result)`, in no particular
    /// order, on the calling thread.
    ///
    /// `workspaces` limits the parallelism: one thread computes per workspace. After an interrupt
    /// from `poll`, tasks under way are finished, none is begun, and what was computed is still
    /// delivered. A panic in a task goes on in the calling thread once the workers have stopped.
    ///
    /// # Panics
    /// If there is no workspace but something to do; and with a task that panics.
    pub fn run<W: Send, T: Send>(
        &self,
        workspaces: &mut [W],
        n: usize,
        task: &(impl Fn(usize, &mut W) -> T + Sync),
        poll: &mut dyn FnMut() -> Option<Interrupt>,
        mut deliver: impl FnMut(usize, T),
    ) -> ControlFlow<Interrupt> {
        assert!(n == 0 || !workspaces.is_empty(), "workers need a workspace");
        let Some(pool) = &self.pool else {
            for i in 0..n {
                if let Some(interrupt) = poll() {
                    return ControlFlow::Break(interrupt);
                }
                deliver(i, task(i, &mut workspaces[0]));
            }
            return ControlFlow::Continue(());
        };

        let workers = workspaces.len().min(n);
        let next = AtomicUsize::new(0);
        let cancelled = AtomicBool::new(false);
        let mut results: Vec<Vec<(usize, T)>> = Vec::new();
        results.resize_with(workers, || Vec::with_capacity(n / workers + 1));
        let mut interrupt = None;
        pool.in_place_scope(|scope| {
            // Nothing is ever sent: the channel closes when the last worker has dropped its end,
            // be it that all is done or that it panicked.
            let (working, all_done) = mpsc::channel::<Infallible>();
            for (workspace, results) in workspaces.iter_mut().zip(&mut results) {
                let working = working.clone();
                let (next, cancelled) = (&next, &cancelled);
                scope.spawn(move |_| {
                    let _working = working;
                    while !cancelled.load(Ordering::Relaxed) {
                        let i = next.fetch_add(1, Ordering::Relaxed);
                        if i >= n {
                            break;
                        }
                        results.push((i, task(i, workspace)));
                    }
                });
            }
            drop(working);
            while all_done.recv_timeout(POLL_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                interrupt = poll();
                if interrupt.is_some() {
                    cancelled.store(true, Ordering::Relaxed);
                    break;
                }
            }
        });
        for (i, result) in results.into_iter().flatten() {
            deliver(i, result);
        }
        interrupt.map_or(ControlFlow::Continue(()), ControlFlow::Break)
    }
}

/// The evaluator of a native [`Objective`]: a batch's candidates in parallel, a workspace per thread.
#[derive(Debug)]
pub struct ObjectiveEvaluator<'a, O: Objective> {
    objective: &'a O,
    workers: Workers,
    workspaces: Vec<O::Workspace>,
    start: Option<Vec<f64>>,
}

impl<'a, O: Objective> ObjectiveEvaluator<'a, O> {
    /// Starts `threads` threads for `objective`.
    pub fn new(objective: &'a O, threads: usize) -> Result<Self> {
        let workers = Workers::new(threads)?;
        let mut workspaces = Vec::new();
        workspaces.resize_with(threads, || objective.workspace());
        Ok(Self { objective, workers, workspaces, start: None })
    }

    /// The same, a search beginning at `start` in place of the point that the objective tells.
    pub fn starting_at(mut self, start: Option<Vec<f64>>) -> Self {
        self.start = start;
        self
    }

    /// What `question` finds of every candidate, each in its place.
    fn each<T: Send>(
        &mut self,
        question: impl Fn(&O, &[f64], &mut O::Workspace) -> T + Sync,
        candidates: Candidates<'_>,
        answers: &mut [T],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> ControlFlow<Interrupt> {
        let objective = self.objective;
        self.workers.run(
            &mut self.workspaces,
            candidates.len(),
            &|i, workspace| question(objective, candidates.row(i), workspace),
            poll,
            |i, answer| answers[i] = answer,
        )
    }
}

impl<O: Objective> Evaluator for ObjectiveEvaluator<'_, O> {
    type Fault = Infallible;

    fn repair(&self, x: &mut [f64]) {
        self.objective.repair(x);
    }

    fn evaluate(
        &mut self,
        candidates: Candidates<'_>,
        costs: &mut [f64],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Infallible> {
        Ok(self.each(O::cost, candidates, costs, poll))
    }

    fn composition(&self) -> Option<Composition> {
        let told = self.objective.composition()?;
        Some(Composition { start: self.start.clone().or(told.start), ..told })
    }

    fn linearize(
        &mut self,
        candidates: Candidates<'_>,
        found: &mut [Option<Linearization>],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Infallible> {
        Ok(self.each(O::linearize, candidates, found, poll))
    }
}

/// What `question` finds of every candidate, in order, computed on `threads` threads of its own; of costs what the
/// objective returns: neither repaired before nor replaced after, so a `NaN` stays a `NaN`.
///
/// The values are the same bits for any number of threads. Breaks with the interrupt that `should_stop` returned.
pub fn evaluate_many<O: Objective, T: Send>(
    objective: &O,
    candidates: Candidates<'_>,
    threads: usize,
    question: impl Fn(&O, &[f64], &mut O::Workspace) -> T + Sync,
    should_stop: &mut dyn FnMut() -> Option<Interrupt>,
) -> Result<ControlFlow<Interrupt, Vec<T>>> {
    let mut evaluator = ObjectiveEvaluator::new(objective, threads.min(candidates.len().max(1)))?;
    let mut answers: Vec<Option<T>> = Vec::new();
    answers.resize_with(candidates.len(), || None);
    let ask = |o: &O, x: &[f64], ws: &mut O::Workspace| Some(question(o, x, ws));
    Ok(match evaluator.each(ask, candidates, &mut answers, should_stop) {
        ControlFlow::Continue(()) => ControlFlow::Continue(answers.into_iter().flatten().collect()),
        ControlFlow::Break(interrupt) => ControlFlow::Break(interrupt),
    })
}

// ---- ledger

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
        let flow = self.evaluator.evaluate(batch, costs, &mut || hooks.poll())?;
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
            let flow =
                self.evaluator.linearize(batch, &mut found, &mut || hooks.poll()).map_err(Stop::Fault)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn never() -> Option<Interrupt> {
        None
    }

    /// What `at` makes of each of the first `n` numbers.
    fn each_of<T: Send>(
        n: u32,
        threads: usize,
        at: impl Fn(f64) -> T + Sync,
        stop: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> ControlFlow<Interrupt, Vec<T>> {
        let numbers: Vec<f64> = (0..n).map(f64::from).collect();
        let objective = |_: &[f64]| f64::NAN;
        evaluate_many(&objective, Candidates::new(&numbers, 1), threads, |_, x, ()| at(x[0]), stop).unwrap()
    }

    #[test]
    fn a_map_keeps_the_order_for_any_number_of_threads() {
        for threads in [1, 2, 3, 8] {
            for n in [0, 1, 2, 100] {
                let expected: Vec<_> = (0..n).map(|i| f64::from(i * i)).collect();
                let found = each_of(n, threads, |x| x * x, &mut never);
                assert_eq!(found, ControlFlow::Continue(expected), "{threads} threads");
            }
        }
    }

    #[test]
    fn every_thread_keeps_its_own_workspace() {
        // Each task counts up its workspace; the counts must add up to the number of tasks.
        let workers = Workers::new(3).unwrap();
        let mut counts = [0_usize; 3];
        let flow = workers.run(&mut counts, 500, &|_, count| *count += 1, &mut never, |_, ()| {});
        assert!(flow.is_continue());
        assert_eq!(counts.iter().sum::<usize>(), 500);
    }

    #[test]
    fn an_interrupt_ends_a_long_batch_early() {
        for threads in [1, 2] {
            let mut polls = 0;
            let mut stop = || {
                polls += 1;
                (polls > 2).then_some(Interrupt::User)
            };
            let done = AtomicUsize::new(0);
            let slow = |_| {
                std::thread::sleep(Duration::from_millis(2));
                done.fetch_add(1, Ordering::Relaxed);
            };
            assert_eq!(each_of(10_000, threads, slow, &mut stop), ControlFlow::Break(Interrupt::User));
            // Two polls are 40 ms at most, 20 tasks a thread; ten times that for a busy machine.
            let done = done.into_inner();
            assert!((1..400).contains(&done), "{done} tasks on {threads} threads");
        }
    }

    #[test]
    fn a_panic_reaches_the_caller_instead_of_hanging() {
        for threads in [1, 2] {
            let caught = std::panic::catch_unwind(|| {
                each_of(50, threads, |x| assert!(x != 30.0, "task thirty"), &mut never)
            });
            let payload = caught.unwrap_err();
            let text = payload.downcast_ref::<&str>();
            assert_eq!(text, Some(&"task thirty"), "{threads} threads");
        }
    }

    #[test]
    fn no_thread_is_refused() {
        let error = Workers::new(0).unwrap_err().to_string();
        assert_eq!(error, "threads: got 0; wanted at least 1. Use 1 to evaluate on the calling thread.");
    }

    #[test]
    fn many_evaluations_return_raw_costs() {
        let objective = |x: &[f64]| if x[0] < 0.0 { f64::NAN } else { x[0] + x[1] };
        let xs = Candidates::new(&[1.0, 2.0, -1.0, 0.0, 0.25, 0.5], 2);
        let costs = evaluate_many(&objective, xs, 1, Objective::cost, &mut never).unwrap();
        let costs = costs.continue_value().unwrap();
        assert!((costs[0], costs[2]) == (3.0, 0.75) && costs[1].is_nan());
    }
}
