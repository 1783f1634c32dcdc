//! Objectives and checks that the tests of optimizer and updating share.
#![allow(dead_code, missing_docs, clippy::missing_panics_doc)]

pub mod chain8;

use std::f64::consts::TAU;

use antires_core::optimize::{Bounds, Hooks, IslandOptions, Objective, Outcome, minimize_objective};
use proptest::test_runner::Config;

/// Cases of a property test: `cases`, or what `PROPTEST_CASES` asks for in a campaign.
pub fn config(cases: u32) -> Config {
    let asked = std::env::var("PROPTEST_CASES").ok();
    Config::with_cases(asked.and_then(|n| n.parse().ok()).unwrap_or(cases))
}

pub fn sphere(x: &[f64]) -> f64 {
    x.iter().map(|x| (x - 0.3).powi(2)).sum()
}

pub fn rastrigin(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x + 10.0 - 10.0 * (TAU * x).cos()).sum()
}

/// Distance to a sparse truth plus both penalties of damage: the minimum has exact zeros.
pub fn sparse(x: &[f64]) -> f64 {
    let misfit: f64 = x.iter().enumerate().map(|(i, x)| (x - if i == 3 { 0.55 } else { 0.0 }).abs()).sum();
    let count = x.iter().filter(|x| **x > 0.0).count();
    misfit + 0.1 * x.iter().sum::<f64>() + 0.1 * count as f64
}

pub fn run(objective: &impl Objective, bounds: &Bounds, options: &IslandOptions, seed: u64) -> Outcome {
    minimize_objective(objective, bounds, &[], options, seed, 1, &mut Hooks::default()).unwrap()
}

/// Every number of an outcome, as bits.
pub fn bits(outcome: &Outcome) -> Vec<u64> {
    let populations = outcome.islands.iter().flat_map(|island| {
        let population = &island.population;
        population.genes.iter().chain(&population.costs)
    });
    let floats = outcome
        .x
        .iter()
        .chain([&outcome.fun])
        .chain(&outcome.history.best_costs)
        .chain(populations)
        .map(|x| x.to_bits());
    let counts = [outcome.nfev, outcome.nit, outcome.migrations];
    let counts = counts.iter().chain(&outcome.history.evaluations);
    floats.chain(counts.map(|&n| n as u64)).collect()
}

/// The lowest cost of all islands at each record.
pub fn best_costs(outcome: &Outcome) -> Vec<f64> {
    let records = outcome.history.best_costs.chunks_exact(outcome.islands.len());
    records.map(|islands| islands.iter().copied().fold(f64::INFINITY, f64::min)).collect()
}

pub fn assert_monotone(outcome: &Outcome) {
    let best = best_costs(outcome);
    assert!(best.is_sorted_by(|a, b| a >= b), "{best:?}");
    assert!(outcome.history.evaluations.is_sorted());
    assert_eq!(best.last(), Some(&outcome.fun));
}
