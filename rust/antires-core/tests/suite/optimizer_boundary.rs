//! The optimizer at its boundary: repair, interruption, evaluators of other kinds, wrong input.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use antires_core::error::Error;
use antires_core::optimize::{
    Bounds, Candidates, Evaluator, Failure, Hooks, Interrupt, IslandOptions, IslandState, Objective,
    Progress, Status, minimize, minimize_objective,
};

use crate::common::{best_costs, bits, rastrigin, run, sparse, sphere};

struct Snapping;

impl Objective for Snapping {
    type Workspace = Vec<f64>;

    fn workspace(&self) -> Vec<f64> {
        Vec::new()
    }

    fn cost(&self, x: &[f64], seen: &mut Vec<f64>) -> f64 {
        seen.clear();
        seen.extend_from_slice(x);
        assert!(seen.iter().all(|&x| x == 0.0 || x >= 0.05), "unrepaired {seen:?}");
        sparse(seen)
    }

    fn repair(&self, x: &mut [f64]) {
        for x in x {
            if *x < 0.05 {
                *x = 0.0;
            }
        }
    }
}

#[test]
fn what_is_repaired_is_what_is_evaluated_and_returned() {
    let bounds = Bounds::uniform(7, 0.0, 0.99).unwrap();
    for threads in [1, 2] {
        let options = IslandOptions::default();
        let guess = [vec![0.01; 7]];
        let hooks = &mut Hooks::default();
        let outcome = minimize_objective(&Snapping, &bounds, &guess, &options, 5, threads, hooks).unwrap();
        assert_eq!(outcome.x.iter().filter(|&&x| x == 0.0).count(), 6);
        for island in &outcome.islands {
            let genes = &island.population.genes;
            assert!(genes.iter().all(|&x| x == 0.0 || x >= 0.05));
        }
    }
}

struct Overshooting;

impl Objective for Overshooting {
    type Workspace = ();

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        assert!(x.iter().all(|x| (0.2..=1.0).contains(x)));
        x.iter().sum()
    }

    fn repair(&self, x: &mut [f64]) {
        x.fill(0.0);
    }
}

#[test]
fn a_repair_out_of_bounds_is_clipped() {
    let bounds = Bounds::uniform(2, 0.2, 1.0).unwrap();
    let outcome = run(&Overshooting, &bounds, &IslandOptions::default(), 5);
    assert_eq!(outcome.x, [0.2, 0.2]);
}

#[test]
fn costs_that_are_not_finite_are_the_worst() {
    let partial = |x: &[f64]| match x[0] {
        x if x < -0.5 => f64::NAN,
        x if x < -0.2 => f64::NEG_INFINITY,
        x if x > 0.5 => f64::INFINITY,
        x => x + 1.0,
    };
    let bounds = Bounds::uniform(1, -1.0, 1.0).unwrap();
    let outcome = run(&partial, &bounds, &IslandOptions::default(), 5);
    assert!((outcome.x[0] + 0.2).abs() < 1e-3, "{}", outcome.x[0]);
    for island in &outcome.islands {
        let costs = &island.population.costs;
        assert!(costs.iter().all(|c| c.is_finite() || *c == f64::INFINITY));
    }

    let hopeless = |_: &[f64]| f64::NAN;
    let options = IslandOptions { max_evaluations: 1000, ..IslandOptions::default() };
    let outcome = run(&hopeless, &bounds, &options, 5);
    assert_eq!((outcome.fun, outcome.status), (f64::INFINITY, Status::MaxEvaluations));
    assert!(bounds.contain(&outcome.x));
}

#[test]
fn fixed_genes_stay_and_a_point_is_solved_at_once() {
    let bounds = Bounds::new(vec![0.7, -1.0], vec![0.7, 1.0]).unwrap();
    let outcome = run(&sphere, &bounds, &IslandOptions::default(), 2);
    assert_eq!(outcome.x[0], 0.7);
    assert!((outcome.fun - 0.16).abs() < 1e-5);

    let point = Bounds::uniform(2, 0.5, 0.5).unwrap();
    let outcome = run(&sphere, &point, &IslandOptions::default(), 2);
    assert_eq!((outcome.status, outcome.nfev), (Status::Agreed, 160));
}

#[test]
fn progress_tells_what_the_history_keeps_and_may_stop_the_search() {
    let bounds = Bounds::uniform(4, -5.12, 5.12).unwrap();
    let options = IslandOptions { patience: 3, ..IslandOptions::default() };
    let mut told = Vec::new();
    let mut progress = |progress: &Progress<'_>| {
        assert_eq!(rastrigin(progress.best_x), progress.best_cost);
        assert_eq!(progress.islands.len(), 4);
        let costs: Vec<f64> = progress.islands.iter().map(|island| island.best_cost).collect();
        let waiting = progress.islands.iter().any(|i| i.state == IslandState::Waiting);
        told.push((progress.generation, progress.evaluations, costs, waiting));
        (progress.generation == 30).then_some(Interrupt::Callback)
    };
    let hooks = &mut Hooks { progress: Some(&mut progress), ..Hooks::default() };
    let outcome = minimize_objective(&rastrigin, &bounds, &[], &options, 1, 2, hooks).unwrap();
    assert_eq!((outcome.status, outcome.nit), (Status::Callback, 30));
    assert_eq!(told.len(), outcome.history.evaluations.len());
    assert!(told.iter().any(|record| record.3), "no island ever waited");
    for (g, (generation, evaluations, costs, _)) in told.iter().enumerate() {
        assert_eq!(*generation, g);
        assert_eq!(*evaluations, outcome.history.evaluations[g]);
        assert_eq!(costs, &outcome.history.best_costs[4 * g..4 * (g + 1)]);
    }
}

#[test]
fn an_interrupted_search_returns_its_best_soon() {
    let bounds = Bounds::uniform(4, -5.12, 5.12).unwrap();
    for threads in [1, 2] {
        for (interrupt, status) in
            [(Interrupt::User, Status::Interrupted), (Interrupt::TimeLimit, Status::TimeLimit)]
        {
            let calls = AtomicUsize::new(0);
            let slow = |x: &[f64]| {
                calls.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(1));
                rastrigin(x)
            };
            // The initial populations take 160 ms on one thread: the third generation or so.
            let mut stop = || (calls.load(Ordering::Relaxed) > 300).then_some(interrupt);
            let hooks = &mut Hooks { should_stop: Some(&mut stop), ..Hooks::default() };
            let options = IslandOptions::default();
            let outcome = minimize_objective(&slow, &bounds, &[], &options, 1, threads, hooks).unwrap();
            assert_eq!(outcome.status, status);
            assert_eq!(outcome.nfev, calls.load(Ordering::Relaxed));
            // 300 and what ran until the next question: 20 ms, ten times that if busy.
            assert!((301..700).contains(&outcome.nfev), "{}", outcome.nfev);
            assert_eq!(rastrigin(&outcome.x), outcome.fun);
            // The discarded generation may have bettered the last record, never worsened it.
            assert!(outcome.fun <= best_costs(&outcome)[outcome.nit]);
            assert_eq!(outcome.history.evaluations.len(), outcome.nit + 1);
        }
    }
}

#[test]
fn a_search_interrupted_at_once_still_has_an_outcome() {
    let bounds = Bounds::uniform(4, -5.12, 5.12).unwrap();
    let mut stop = || Some(Interrupt::User);
    let hooks = &mut Hooks { should_stop: Some(&mut stop), ..Hooks::default() };
    let options = IslandOptions::default();
    let guess = [vec![1.0; 4]];
    let outcome = minimize_objective(&rastrigin, &bounds, &guess, &options, 1, 1, hooks).unwrap();
    assert_eq!((outcome.status, outcome.nfev), (Status::Interrupted, 0));
    assert_eq!((&outcome.x, outcome.fun), (&guess[0], f64::INFINITY));
    assert!(outcome.history.evaluations.is_empty());
}

#[test]
fn a_discarded_generation_still_gives_its_best() {
    let bounds = Bounds::uniform(4, -5.12, 5.12).unwrap();
    let calls = AtomicUsize::new(0);
    let costs = std::sync::Mutex::new(Vec::new());
    let recording = |x: &[f64]| {
        calls.fetch_add(1, Ordering::Relaxed);
        let cost = rastrigin(x);
        costs.lock().unwrap().push(cost);
        cost
    };
    // In the middle of the initial populations.
    let mut stop = || (calls.load(Ordering::Relaxed) == 50).then_some(Interrupt::User);
    let hooks = &mut Hooks { should_stop: Some(&mut stop), ..Hooks::default() };
    let options = IslandOptions::default();
    let outcome = minimize_objective(&recording, &bounds, &[], &options, 1, 1, hooks).unwrap();
    let best = costs.lock().unwrap().iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!((outcome.nfev, outcome.fun), (50, best));
    assert_eq!(rastrigin(&outcome.x), outcome.fun);
    assert!(outcome.history.evaluations.is_empty());
}

/// Evaluates whole batches, and fails in a batch of choice.
struct Batches {
    made: usize,
    fails_at: Option<usize>,
}

#[derive(Debug, PartialEq)]
struct Exception(&'static str);

impl Evaluator for Batches {
    type Fault = Exception;

    fn evaluate(
        &mut self,
        candidates: Candidates<'_>,
        costs: &mut [f64],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Exception> {
        assert!(!candidates.is_empty());
        assert_eq!((candidates.len(), candidates.n_genes()), (costs.len(), 3));
        if Some(self.made) == self.fails_at {
            return Err(Exception("division by zero"));
        }
        self.made += 1;
        if let Some(interrupt) = poll() {
            return Ok(ControlFlow::Break(interrupt));
        }
        for (i, cost) in costs.iter_mut().enumerate() {
            *cost = sphere(candidates.row(i));
        }
        Ok(ControlFlow::Continue(()))
    }
}

#[test]
fn a_batch_evaluator_gives_the_same_bits_in_one_call_a_generation() {
    let bounds = Bounds::uniform(3, -1.0, 1.0).unwrap();
    let options = IslandOptions::default();
    let mut batches = Batches { made: 0, fails_at: None };
    let outcome = minimize(&mut batches, &bounds, &[], &options, 9, &mut Hooks::default()).unwrap();
    assert_eq!(bits(&outcome), bits(&run(&sphere, &bounds, &options, 9)));
    assert!(batches.made <= outcome.nit + 1);
}

#[test]
fn a_fault_comes_back_as_it_was() {
    let bounds = Bounds::uniform(3, -1.0, 1.0).unwrap();
    for fails_at in [0, 5] {
        let mut batches = Batches { made: 0, fails_at: Some(fails_at) };
        let options = IslandOptions::default();
        let result = minimize(&mut batches, &bounds, &[], &options, 9, &mut Hooks::default());
        assert_eq!(result.unwrap_err(), Failure::Evaluation(Exception("division by zero")));
        assert_eq!(batches.made, fails_at);
    }
}

#[test]
fn unusable_input_is_refused_by_name() {
    let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
    let refused = |guesses: &[Vec<f64>], options: &IslandOptions, threads| {
        let hooks = &mut Hooks::default();
        let result = minimize_objective(&sphere, &bounds, guesses, options, 1, threads, hooks);
        match result.unwrap_err() {
            Error::InvalidInput { argument, .. } => argument.to_string(),
            other => panic!("{other}"),
        }
    };
    let default = IslandOptions::default();
    let none = IslandOptions { islands: 0, ..default.clone() };
    assert_eq!(refused(&[], &none, 1), "islands");
    assert_eq!(refused(&[], &default, 0), "threads");
    assert_eq!(refused(&[vec![0.5]], &default, 1), "x0[0]");
    assert_eq!(refused(&[vec![0.5, 2.0]], &default, 1), "x0[0][1]");
    assert_eq!(refused(&vec![vec![0.5; 2]; 161], &default, 1), "x0");
}
