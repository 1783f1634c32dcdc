//! The polish: solves what the plain search is slow at, and keeps every promise the search makes.

use std::sync::atomic::{AtomicUsize, Ordering};

use antires_core::optimize::{
    Bounds, Composition, Hooks, Interrupt, IslandOptions, Linearization, Norm, Objective, Outcome, Status,
    minimize_objective,
};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

use crate::common::{assert_monotone, bits, config, rastrigin, sparse, sphere};

const N: usize = 12;
const M: usize = 25;

/// Residuals A (g(x) - g(truth)), g bending upward, and the damage penalties; calls are counted.
struct Hidden {
    truth: [f64; N],
    calls: AtomicUsize,
}

impl Hidden {
    fn new(raised: &[(usize, f64)]) -> Self {
        let mut truth = [0.0; N];
        for &(gene, size) in raised {
            truth[gene] = size;
        }
        Self { truth, calls: AtomicUsize::new(0) }
    }

    /// A smooth matrix, whose neighbouring columns are much alike.
    fn a(i: usize, j: usize) -> f64 {
        let at = j as f64 - 0.5 * i as f64;
        1.0 / (1.0 + 0.3 * at * at)
    }

    fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let g = |x: f64| x / (1.05 - x);
        let apart: Vec<f64> = x.iter().zip(&self.truth).map(|(&x, &t)| g(x) - g(t)).collect();
        let of = |i: usize| (0..N).map(|j| Self::a(i, j) * apart[j]).sum();
        (0..M).map(of).collect()
    }

    fn cost_of(&self, x: &[f64]) -> f64 {
        let misfit: f64 = self.residuals(x).iter().map(|e| e.abs()).sum();
        let count = x.iter().filter(|x| **x > 0.0).count();
        misfit + 0.1 * x.iter().sum::<f64>() + 0.1 * count as f64
    }
}

impl Objective for Hidden {
    type Workspace = ();

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.cost_of(x)
    }

    fn composition(&self) -> Option<Composition> {
        Some(Composition {
            norm: Some(Norm::Absolute),
            start: Some(vec![0.0; N]),
            price: vec![0.1; N],
            sparse: vec![true; N],
        })
    }

    fn linearize(&self, x: &[f64], (): &mut ()) -> Option<Linearization> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        let slope = |x: f64| 1.05 / (1.05 - x).powi(2);
        let entries = (0..M).flat_map(|i| (0..N).map(move |j| Self::a(i, j) * slope(x[j])));
        Some(Linearization {
            cost: self.cost_of(x),
            residuals: self.residuals(x),
            jacobian: entries.collect(),
        })
    }
}

fn search(objective: &impl Objective, options: &IslandOptions, seed: u64, threads: usize) -> Outcome {
    let bounds = Bounds::uniform(N, 0.0, 0.99).unwrap();
    let hooks = &mut Hooks::default();
    minimize_objective(objective, &bounds, &[], options, seed, threads, hooks).unwrap()
}

#[test]
fn hidden_damages_are_found_with_exact_zeros_and_few_evaluations() {
    let cases: [&[(usize, f64)]; 5] =
        [&[], &[(0, 0.4)], &[(11, 0.75)], &[(3, 0.55), (8, 0.3)], &[(5, 0.6), (6, 0.5), (1, 0.9)]];
    for raised in cases {
        for seed in 0..3 {
            let objective = Hidden::new(raised);
            let outcome = search(&objective, &IslandOptions::default(), seed, 1);
            let bar = objective.cost_of(&objective.truth);
            assert!(outcome.fun <= bar + 1e-6, "{raised:?}: {} > {bar}", outcome.fun);
            assert!(outcome.status.success(), "{:?}", outcome.status);
            assert!(outcome.nfev < 12_000, "{raised:?}: {}", outcome.nfev);
            // What remains is damage, never a rest of the arithmetic.
            let raised = outcome.x.iter().filter(|x| **x > 0.0);
            assert!(raised.clone().all(|&x| x > 1e-3), "{:?}", outcome.x);
            assert_monotone(&outcome);
        }
    }
}

#[test]
fn the_polish_is_worth_its_evaluations() {
    let solved = |polish: Option<bool>| {
        let options = IslandOptions { polish, max_evaluations: 4000, ..IslandOptions::default() };
        let objective = Hidden::new(&[(3, 0.75), (9, 0.3)]);
        let bar = objective.cost_of(&objective.truth) + 1e-6;
        (0..5).filter(|&seed| search(&objective, &options, seed, 1).fun <= bar).count()
    };
    assert_eq!((solved(None), solved(Some(false))), (5, 0));
}

#[test]
fn one_seed_gives_one_outcome_for_any_number_of_threads() {
    // A polish that is cut short and little patience, so that the islands meet before they agree.
    let options = IslandOptions {
        max_evaluations: 5000,
        patience: 2,
        polish_evaluations: 1,
        ..IslandOptions::default()
    };
    for seed in 0..3 {
        let objective = Hidden::new(&[(5, 0.6), (6, 0.5), (1, 0.9)]);
        let one = search(&objective, &options, seed, 1);
        assert!(one.migrations > 0);
        for threads in [2, 3, 8] {
            let other = search(&objective, &options, seed, threads);
            assert_eq!(bits(&one), bits(&other), "seed {seed}, {threads} threads");
        }
    }
}

proptest! {
    #![proptest_config(config(48))]
    #[test]
    fn every_evaluation_of_a_polish_is_counted_and_none_exceeds_the_budget(
        max_evaluations in 1..3000_usize,
        islands in 1..5_usize,
        polish_interval in 1..12_usize,
        polish_evaluations in 1..400_usize,
        seed in any::<u64>(),
    ) {
        let options = IslandOptions {
            max_evaluations, islands, polish_interval, polish_evaluations, ..IslandOptions::default()
        };
        let objective = Hidden::new(&[(3, 0.55), (8, 0.3)]);
        let outcome = search(&objective, &options, seed, 1);
        prop_assert_eq!(outcome.nfev, objective.calls.load(Ordering::Relaxed));
        prop_assert!(outcome.nfev <= max_evaluations);
        if outcome.status == Status::MaxEvaluations {
            prop_assert_eq!(outcome.nfev, max_evaluations);
        }
        prop_assert_eq!(objective.cost_of(&outcome.x), outcome.fun);
        assert_monotone(&outcome);
        for island in &outcome.islands {
            let population = &island.population;
            for i in 0..population.size() {
                let cost = population.cost(i);
                prop_assert!(cost == objective.cost_of(population.row(i)) || cost == f64::INFINITY);
            }
        }
    }
}

#[test]
fn a_stop_inside_the_polish_ends_it_there_with_the_best_so_far() {
    for threads in [1, 2] {
        for after in [170, 200, 260, 330] {
            let objective = Hidden::new(&[(3, 0.55), (8, 0.3)]);
            let count = || objective.calls.load(Ordering::Relaxed);
            let mut stop = || (count() >= after).then_some(Interrupt::User);
            let hooks = &mut Hooks { should_stop: Some(&mut stop), ..Hooks::default() };
            let bounds = Bounds::uniform(N, 0.0, 0.99).unwrap();
            let options = IslandOptions::default();
            let outcome = minimize_objective(&objective, &bounds, &[], &options, 3, threads, hooks).unwrap();
            assert_eq!((outcome.status, outcome.nit), (Status::Interrupted, 0));
            assert_eq!(outcome.nfev, count());
            assert_eq!(objective.cost_of(&outcome.x), outcome.fun);
            assert_monotone(&outcome);
            if threads == 1 {
                assert_eq!(outcome.nfev, after);
            }
        }
    }
}

#[test]
fn a_plain_function_is_polished_when_asked_without_derivatives() {
    let options = IslandOptions { polish: Some(true), ..IslandOptions::default() };
    let (seven, ten) = (Bounds::uniform(7, 0.0, 0.99).unwrap(), Bounds::uniform(10, -5.12, 5.12).unwrap());
    let run = |objective: &(dyn Fn(&[f64]) -> f64 + Sync), bounds, options: &IslandOptions, seed| {
        let objective = |x: &[f64]| objective(x);
        let hooks = &mut Hooks::default();
        minimize_objective(&objective, bounds, &[], options, seed, 1, hooks).unwrap()
    };
    for seed in 0..3 {
        let outcome = run(&sparse, &seven, &options, seed);
        let (found, zeros): (Vec<f64>, Vec<f64>) = outcome.x.iter().partition(|x| **x > 0.0);
        assert_eq!(zeros.len(), 6, "{:?}", outcome.x);
        assert!((found[0] - 0.55).abs() < 1e-5, "{found:?}");
        let outcome = run(&sphere, &ten, &options, seed);
        assert!(outcome.fun < 1e-10, "{}", outcome.fun);
        assert_monotone(&outcome);
    }
    // Many local minima: the polish must not end the search in the first that all islands reach.
    let solved = |seed: &u64| run(&rastrigin, &ten, &options, *seed).fun < 1e-6;
    assert!((0..6).filter(solved).count() >= 5);
    // Unasked, a function that tells nothing of itself is searched as it always was.
    let unasked = run(&sparse, &seven, &IslandOptions::default(), 4);
    let paper = IslandOptions { polish: Some(false), ..IslandOptions::default() };
    assert_eq!(bits(&unasked), bits(&run(&sparse, &seven, &paper, 4)));
}
