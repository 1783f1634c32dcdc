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

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use super::composition::{Composition, Linearization};
use super::objective::{Candidates, Evaluator, Objective};
use super::outcome::Interrupt;
use crate::error::{Error, Result};

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
    ///
    /// # Errors
    /// If `threads` is 0, or the system refuses to start them.
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
    ///
    /// # Errors
    /// As [`Workers::new`].
    pub fn new(objective: &'a O, threads: usize) -> Result<Self> {
        let workers = Workers::new(threads)?;
        let mut workspaces = Vec::new();
        workspaces.resize_with(threads, || objective.workspace());
        Ok(Self {
            objective,
            workers,
            workspaces,
            start: None,
        })
    }

    /// The same, a search beginning at `start` in place of the point that the objective tells.
    #[must_use]
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
    ) -> std::result::Result<ControlFlow<Interrupt>, Infallible> {
        Ok(self.each(O::cost, candidates, costs, poll))
    }

    fn composition(&self) -> Option<Composition> {
        let told = self.objective.composition()?;
        Some(Composition {
            start: self.start.clone().or(told.start),
            ..told
        })
    }

    fn linearize(
        &mut self,
        candidates: Candidates<'_>,
        found: &mut [Option<Linearization>],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> std::result::Result<ControlFlow<Interrupt>, Infallible> {
        Ok(self.each(O::linearize, candidates, found, poll))
    }
}

/// `task(i, workspace)` for every `i < n`, in order, computed on `threads` threads of its own.
///
/// The values are the same bits for any number of threads, provided that a task does not depend on
/// what an earlier one left in its workspace. Breaks with the interrupt that `should_stop` returned.
///
/// # Errors
/// As [`Workers::new`].
pub fn parallel_map<W: Send, T: Send>(
    n: usize,
    threads: usize,
    workspace: impl FnMut() -> W,
    task: impl Fn(usize, &mut W) -> T + Sync,
    should_stop: &mut dyn FnMut() -> Option<Interrupt>,
) -> Result<ControlFlow<Interrupt, Vec<T>>> {
    let workers = Workers::new(threads)?;
    let mut workspaces = Vec::new();
    workspaces.resize_with(threads.min(n), workspace);
    let mut slots: Vec<Option<T>> = Vec::new();
    slots.resize_with(n, || None);
    let flow = workers.run(&mut workspaces, n, &task, should_stop, |i, value| {
        slots[i] = Some(value);
    });
    Ok(match flow {
        ControlFlow::Continue(()) => ControlFlow::Continue(slots.into_iter().flatten().collect()),
        ControlFlow::Break(interrupt) => ControlFlow::Break(interrupt),
    })
}

/// The cost of every candidate, in order, as the objective returned it: neither repaired before nor
/// replaced after, so a `NaN` stays a `NaN`.
///
/// # Errors
/// As [`Workers::new`].
pub fn evaluate_many<O: Objective>(
    objective: &O,
    candidates: Candidates<'_>,
    threads: usize,
    should_stop: &mut dyn FnMut() -> Option<Interrupt>,
) -> Result<ControlFlow<Interrupt, Vec<f64>>> {
    parallel_map(
        candidates.len(),
        threads,
        || objective.workspace(),
        |i, workspace| objective.cost(candidates.row(i), workspace),
        should_stop,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn never() -> Option<Interrupt> {
        None
    }

    #[test]
    fn a_map_keeps_the_order_for_any_number_of_threads() {
        for threads in [1, 2, 3, 8] {
            for n in [0, 1, 2, 100] {
                let flow = parallel_map(n, threads, || (), |i, ()| i * i, &mut never).unwrap();
                let expected: Vec<_> = (0..n).map(|i| i * i).collect();
                assert_eq!(flow, ControlFlow::Continue(expected), "{threads} threads");
            }
        }
    }

    #[test]
    fn every_thread_keeps_its_own_workspace() {
        // Each task counts up its workspace; the counts must add up to the number of tasks.
        let workers = Workers::new(3).unwrap();
        let mut counts = [0_usize; 3];
        let flow = workers.run(
            &mut counts,
            500,
            &|_, count| *count += 1,
            &mut never,
            |_, ()| {},
        );
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
            let flow = parallel_map(
                10_000,
                threads,
                || (),
                |_, ()| {
                    std::thread::sleep(Duration::from_millis(2));
                    done.fetch_add(1, Ordering::Relaxed);
                },
                &mut stop,
            );
            assert_eq!(flow.unwrap(), ControlFlow::Break(Interrupt::User));
            // Two polls are 40 ms at most, 20 tasks a thread; ten times that for a busy machine.
            let done = done.into_inner();
            assert!(
                (1..400).contains(&done),
                "{done} tasks on {threads} threads"
            );
        }
    }

    #[test]
    fn a_panic_reaches_the_caller_instead_of_hanging() {
        for threads in [1, 2] {
            let caught = std::panic::catch_unwind(|| {
                parallel_map(
                    50,
                    threads,
                    || (),
                    |i, ()| assert!(i != 30, "task thirty"),
                    &mut never,
                )
            });
            let payload = caught.unwrap_err();
            let text = payload.downcast_ref::<&str>();
            assert_eq!(text, Some(&"task thirty"), "{threads} threads");
        }
    }

    #[test]
    fn no_thread_is_refused() {
        let error = Workers::new(0).unwrap_err().to_string();
        assert_eq!(
            error,
            "threads: got 0; wanted at least 1. Use 1 to evaluate on the calling thread."
        );
    }

    #[test]
    fn many_evaluations_return_raw_costs() {
        let objective = |x: &[f64]| if x[0] < 0.0 { f64::NAN } else { x[0] + x[1] };
        let xs = [1.0, 2.0, -1.0, 0.0, 0.25, 0.5];
        for threads in [1, 2] {
            let flow = evaluate_many(&objective, Candidates::new(&xs, 2), threads, &mut never);
            let ControlFlow::Continue(costs) = flow.unwrap() else {
                panic!("nothing interrupts");
            };
            assert_eq!((costs[0], costs[2]), (3.0, 0.75));
            assert!(costs[1].is_nan());
        }
    }
}
