//! The optimizer's search: reaches optima, keeps its budget, ends for a reason, repeats bit for bit.

use std::sync::atomic::{AtomicUsize, Ordering};

use antires_core::optimize::{
    Agreement, Bounds, Crossover, Hooks, IslandOptions, IslandState, Status, minimize_objective,
};
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};

use crate::common::{assert_monotone, bits, config, rastrigin, run, sparse, sphere};

#[test]
fn the_sphere_is_solved_and_the_islands_agree() {
    let bounds = Bounds::uniform(5, -1.0, 1.0).unwrap();
    for seed in 0..5 {
        let outcome = run(&sphere, &bounds, &IslandOptions::default(), seed);
        assert!(outcome.fun < 1e-5, "seed {seed}: {}", outcome.fun);
        assert!(outcome.status.success(), "seed {seed}: {:?}", outcome.status);
        assert_eq!(sphere(&outcome.x), outcome.fun);
        assert_eq!(outcome.history.evaluations.len(), outcome.nit + 1);
        assert_eq!(outcome.history.migrations.len(), outcome.migrations);
        assert_monotone(&outcome);
    }
}

#[test]
fn rastrigin_does_not_trap_it_in_a_local_minimum() {
    let bounds = Bounds::uniform(10, -5.12, 5.12).unwrap();
    for seed in 0..5 {
        let outcome = run(&rastrigin, &bounds, &IslandOptions::default(), seed);
        // The best local minimum beside the global one costs 0.995.
        assert!(outcome.fun < 0.05, "seed {seed}: {}", outcome.fun);
        assert_monotone(&outcome);
    }
}

#[test]
fn a_sparse_truth_is_found_with_exact_zeros() {
    let bounds = Bounds::uniform(7, 0.0, 0.99).unwrap();
    for seed in 0..5 {
        let outcome = run(&sparse, &bounds, &IslandOptions::default(), seed);
        for (i, &x) in outcome.x.iter().enumerate() {
            if i == 3 {
                assert!((x - 0.55).abs() < 1e-3, "seed {seed}: {x}");
            } else {
                assert_eq!(x, 0.0, "seed {seed}, gene {i}");
            }
        }
        assert_eq!(outcome.status, Status::Agreed);
        // What "agreed" claims, checked on the islands themselves.
        for island in &outcome.islands {
            let best = island.population.row(island.population.best());
            let close = best.iter().zip(&outcome.x).all(|(a, b)| (a - b).abs() <= 1e-6);
            assert!(close, "{best:?} and {:?}", outcome.x);
            assert_eq!(island.state, IslandState::Waiting);
        }
    }
}

#[test]
fn one_seed_gives_one_outcome_for_any_number_of_threads() {
    let bounds = Bounds::uniform(6, -5.12, 5.12).unwrap();
    let options = IslandOptions { patience: 5, max_evaluations: 6000, ..IslandOptions::default() };
    let with = |seed, threads| {
        let hooks = &mut Hooks::default();
        minimize_objective(&rastrigin, &bounds, &[], &options, seed, threads, hooks).unwrap()
    };
    for seed in 0..5 {
        let one = with(seed, 1);
        assert!(one.migrations > 0);
        for threads in [2, 3, 8] {
            let other = with(seed, threads);
            assert_eq!(bits(&one), bits(&other), "seed {seed}, {threads} threads");
            assert_eq!(one, other, "seed {seed}, {threads} threads");
        }
    }
    assert_ne!(with(0, 1).x, with(1, 1).x);
}

#[test]
fn any_number_of_islands_works() {
    let bounds = Bounds::uniform(4, -1.0, 1.0).unwrap();
    for islands in [1, 2, 7] {
        let options = IslandOptions { islands, ..IslandOptions::default() };
        let outcome = run(&sphere, &bounds, &options, 3);
        assert_eq!(outcome.islands.len(), islands);
        for (i, island) in outcome.islands.iter().enumerate() {
            assert_eq!(island.crossover, Crossover::PAPER[i % 4]);
        }
        assert_eq!(outcome.status == Status::Stagnated, islands == 1);
        assert_eq!(outcome.migrations == 0, islands == 1);
        // One island has arithmetic crossover only and no one to lead it out of a corner.
        let bar = if islands == 1 { 0.05 } else { 1e-3 };
        assert!(outcome.fun < bar, "{islands} islands: {}", outcome.fun);
    }
}

#[test]
fn a_flat_valley_ends_agreed_in_cost_and_by_the_paper_not_at_all() {
    // Only the sum matters: the bests agree in cost, their genes differ.
    let valley = |x: &[f64]| 1.0 + (x.iter().sum::<f64>() - 2.0).abs();
    let bounds = Bounds::uniform(6, 0.0, 1.0).unwrap();
    let options = IslandOptions { max_evaluations: 60_000, ..IslandOptions::default() };
    let paper = IslandOptions { agreement: Agreement::Genes, ..options.clone() };
    let mut in_cost = 0;
    for seed in 0..5 {
        let outcome = run(&valley, &bounds, &options, seed);
        assert!((outcome.fun - 1.0).abs() < 1e-3);
        if outcome.status == Status::CostAgreed {
            in_cost += 1;
            assert!(outcome.migrations >= 2);
            let outcome = run(&valley, &bounds, &paper, seed);
            assert_ne!(outcome.status, Status::CostAgreed);
        }
    }
    assert!(in_cost > 0, "no seed agreed in cost");
}

#[test]
fn interchangeable_optima_agree_in_cost() {
    // A constant: every individual is as good, no island ever improves.
    let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
    let constant = |_: &[f64]| 2.5;
    let outcome = run(&constant, &bounds, &IslandOptions::default(), 1);
    assert_eq!(outcome.status, Status::CostAgreed);
    // Asked at generations 40, 80 and 120, with an exchange after the first two.
    assert_eq!((outcome.nit, outcome.migrations), (120, 2));
    assert_eq!(outcome.history.migrations, [40, 80]);
}

#[test]
fn collapsed_populations_end_instead_of_looping() {
    let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
    let constant = |_: &[f64]| 2.5;
    let options = IslandOptions {
        agreement: Agreement::Genes,
        crossover_probability: 0.0,
        mutation_probability: 0.0,
        ..IslandOptions::default()
    };
    let outcome = run(&constant, &bounds, &options, 1);
    assert_eq!((outcome.status, outcome.nfev), (Status::Collapsed, 160));
    assert!(!outcome.status.success());
}

#[test]
fn generations_are_a_budget_too() {
    let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
    for most in [0, 1, 9] {
        let options = IslandOptions { max_generations: Some(most), ..IslandOptions::default() };
        let outcome = run(&sphere, &bounds, &options, 1);
        assert_eq!((outcome.status, outcome.nit), (Status::MaxGenerations, most));
    }
}

proptest! {
    #![proptest_config(config(64))]
    #[test]
    fn evaluations_are_counted_and_never_exceed_the_budget(
        max_evaluations in 1..2000_usize,
        islands in 1..6_usize,
        population in 4..20_usize,
        seed in any::<u64>(),
    ) {
        let calls = AtomicUsize::new(0);
        let counting = |x: &[f64]| {
            calls.fetch_add(1, Ordering::Relaxed);
            rastrigin(x)
        };
        let options = IslandOptions { max_evaluations, islands, population, patience: 10, ..IslandOptions::default() };
        let bounds = Bounds::uniform(4, -2.0, 3.0).unwrap();
        let outcome = run(&counting, &bounds, &options, seed);
        let calls = calls.into_inner();
        prop_assert_eq!(outcome.nfev, calls);
        prop_assert!(calls <= max_evaluations);
        if outcome.status == Status::MaxEvaluations {
            prop_assert_eq!(calls, max_evaluations);
        }
        prop_assert!(bounds.contain(&outcome.x));
        prop_assert_eq!(rastrigin(&outcome.x), outcome.fun);
        assert_monotone(&outcome);
        // Every individual carries the cost of its own genes, or none if the budget left it out.
        for island in &outcome.islands {
            let population = &island.population;
            for i in 0..population.size() {
                let cost = population.cost(i);
                prop_assert!(cost == rastrigin(population.row(i)) || cost == f64::INFINITY);
                prop_assert!(bounds.contain(population.row(i)));
            }
        }
    }
}

#[test]
fn guesses_are_evaluated_and_kept() {
    let bounds = Bounds::uniform(8, -1.0, 1.0).unwrap();
    let options = IslandOptions { max_generations: Some(0), ..IslandOptions::default() };
    let guesses = vec![vec![0.9; 8], vec![0.3; 8], vec![0.8; 8]];
    let hooks = &mut Hooks::default();
    let outcome = minimize_objective(&sphere, &bounds, &guesses, &options, 1, 1, hooks).unwrap();
    assert_eq!((&outcome.x, outcome.fun), (&guesses[1], 0.0));
    for (g, guess) in guesses.iter().enumerate() {
        assert_eq!(outcome.islands[g].population.row(0), guess);
    }
}
