//! The eight-mass chain of the paper, and the search for the damage of its fifth spring.

use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::optimize::{Bounds, Hooks, IslandOptions, Objective, Outcome, minimize_objective};
use antires_core::update::unknowns::Penalty;

use super::bits;

pub const PAPER: Penalty = Penalty { gamma1: 0.1, gamma2: 0.1 };
pub const INTACT: [f64; 7] = [56.7e3; 7];

pub fn damaged() -> [f64; 7] {
    let mut springs = INTACT;
    springs[4] *= 0.45;
    springs
}

pub fn chain8(springs: [f64; 7]) -> Model {
    let mut masses = [0.4194; 8];
    masses[0] = 0.5593;
    mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap()
}

/// One parameter for each of the first `count` terms.
pub fn each(quantity: Quantity, count: usize) -> Vec<Parameter> {
    (0..count).map(|term| Parameter { quantity: quantity.clone(), terms: vec![term] }).collect()
}

/// The search for stiffness reductions of the springs.
pub fn search(objective: &impl Objective, seed: u64, threads: usize) -> Outcome {
    let bounds = Bounds::uniform(7, 0.0, 0.99).unwrap();
    let (options, hooks) = (IslandOptions::default(), &mut Hooks::default());
    minimize_objective(objective, &bounds, &[], &options, seed, threads, hooks).unwrap()
}

/// The search has found the fifth spring, its loss within 0.01, and no other.
pub fn assert_found(outcome: &Outcome) {
    assert!(outcome.status.success(), "{:?}", outcome.status);
    for (spring, &beta) in outcome.x.iter().enumerate() {
        if spring == 4 {
            assert!((beta - 0.55).abs() < 0.01, "{beta}");
        } else {
            assert_eq!(beta, 0.0, "spring {spring}");
        }
    }
}

pub fn assert_same_for_any_threads(objective: &impl Objective) {
    let one = bits(&search(objective, 7, 1));
    for threads in [2, 3, 8] {
        assert_eq!(one, bits(&search(objective, 7, threads)), "{threads} threads");
    }
}
