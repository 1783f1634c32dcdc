//! The whole core: measured antiresonances in, parameters out.

use antires_core::antiresonances::{Query, Route, antiresonances};
use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::optimize::{Bounds, Hooks, IslandOptions, Linearization, Objective, minimize_objective};
use antires_core::update::objective::{AntiresonanceObjective, Sees, Target};
use antires_core::update::unknowns::Misfit;

use crate::common::chain8::{
    INTACT, PAPER, assert_found, assert_same_for_any_threads, chain8, damaged, each, search,
};

/// Exact zeros, each shifted by a fixed pattern of up to `error`, as an identification would.
fn targets(model: &Model, error: f64) -> Vec<Target> {
    let query = Query { route: Route::Pencil, f_max_hz: f64::INFINITY, include_cancelled: false };
    let ends: Vec<_> = (0..8).map(|dof| (dof, 0).into()).collect();
    let mut count = 0;
    antiresonances(model, &ends, &query)
        .unwrap()
        .into_iter()
        .enumerate()
        .map(|(dof, zeros)| {
            let freq_hz = zeros
                .freq_hz
                .into_iter()
                .map(|f| {
                    count += 1;
                    f * (1.0 + error * (2.3 * f64::from(count)).sin())
                })
                .collect();
            Target { ends: (dof, 0).into(), freq_hz, ..Target::default() }
        })
        .collect()
}

fn reductions() -> Vec<Parameter> {
    each(Quantity::StiffnessReduction, 7)
}

fn damage_objective(error: f64, snap: f64) -> AntiresonanceObjective {
    let measured = targets(&chain8(damaged()), error);
    AntiresonanceObjective::new(chain8(INTACT), reductions(), measured, Misfit::Absolute, Some(PAPER), snap)
        .unwrap()
}

#[test]
fn the_truth_costs_its_penalties_and_nothing_more() {
    let objective = damage_objective(0.0, 0.0);
    let mut workspace = objective.workspace();
    let truth = [0.0, 0.0, 0.0, 0.0, 0.55, 0.0, 0.0];
    let cost = objective.cost(&truth, &mut workspace);
    assert!((cost - (0.1 * 0.55 + 0.1)).abs() < 1e-9, "{cost}");
    assert!(objective.cost(&[0.0; 7], &mut workspace) > 1.0);
}

#[test]
fn a_negligible_severity_is_not_charged_once_it_is_snapped() {
    let x = [1e-6, 0.0, 1e-6, 0.0, 0.55, 1e-6, 0.0];
    let as_printed = damage_objective(0.0, 0.0);
    let snapped = damage_objective(0.0, 1e-3);
    let cost = |o: &AntiresonanceObjective| o.cost(&x, &mut o.workspace());
    assert!((cost(&as_printed) - cost(&snapped) - 0.3).abs() < 1e-4);
    let mut repaired = x;
    snapped.repair(&mut repaired);
    assert_eq!(repaired, [0.0, 0.0, 0.0, 0.0, 0.55, 0.0, 0.0]);
}

#[test]
fn the_damaged_spring_is_found_from_imperfect_measurements() {
    for seed in [1, 2, 3] {
        let outcome = search(&damage_objective(1e-3, 1e-3), seed, 2);
        assert_found(&outcome);
    }
}

#[test]
fn the_outcome_does_not_depend_on_the_number_of_threads() {
    assert_same_for_any_threads(&damage_objective(1e-3, 1e-3));
}

#[test]
fn the_cost_is_finite_everywhere_even_where_a_spring_is_gone() {
    let objective = damage_objective(0.0, 0.0);
    let mut workspace = objective.workspace();
    for mask in 0..128_u32 {
        let x: Vec<f64> = (0..7).map(|i| f64::from((mask >> i) & 1)).collect();
        let cost = objective.cost(&x, &mut workspace);
        assert!(cost.is_finite() && cost >= 0.0, "{x:?}: {cost}");
    }
}

#[test]
fn wrong_problems_are_refused_by_name() {
    let build = |parameters, targets, snap| {
        let model = chain8(INTACT);
        let objective =
            AntiresonanceObjective::new(model, parameters, targets, Misfit::Absolute, Some(PAPER), snap);
        objective.err().expect("refused").to_string()
    };
    let at = |dof, excitation, freq| {
        vec![Target { ends: (dof, excitation).into(), freq_hz: vec![freq], ..Target::default() }]
    };
    let ground = Parameter { quantity: Quantity::StiffnessFactor, terms: vec![7] };
    assert!(build(reductions(), at(8, 0, 1.0), 0.0).starts_with("measured: got dof 8"));
    assert!(build(reductions(), at(0, 9, 1.0), 0.0).starts_with("excitation: got dof 9"));
    assert!(build(reductions(), at(0, 0, -1.0), 0.0).contains("positive"));
    assert!(build(reductions(), vec![], 0.0).contains("at least one"));
    assert!(build(vec![], at(0, 0, 1.0), 0.0).starts_with("parameters"));
    assert!(build(vec![ground], at(0, 0, 1.0), 0.0).contains("changes the model"));
    assert!(build(reductions(), at(0, 0, 1.0), 0.1).starts_with("snap"));
}

#[test]
fn no_search_ends_with_rests_of_arithmetic_paid_as_damage() {
    // snap = 0: nothing but the search itself makes zeros.
    for (a, b) in [((4, 0.55), (4, 0.55)), ((1, 0.3), (5, 0.6)), ((2, 0.8), (3, 0.4))] {
        let mut springs = INTACT;
        for (spring, beta) in [a, b] {
            springs[spring] = INTACT[spring] * (1.0 - beta);
        }
        let measured = targets(&chain8(springs), 1e-3);
        let intact = chain8(INTACT);
        let objective =
            AntiresonanceObjective::new(intact, reductions(), measured, Misfit::Absolute, Some(PAPER), 0.0)
                .unwrap();
        let polished = search(&objective, 1, 1);
        assert!(polished.x.iter().all(|&x| x == 0.0 || x > 1e-3), "{:?}", polished.x);
        let damaged = |(spring, beta): (usize, f64)| (polished.x[spring] - beta).abs() < 0.02;
        assert!(damaged(a) && damaged(b), "{:?}", polished.x);
    }
}

#[test]
fn the_flat_valley_of_updating_is_walked_to_its_bottom() {
    // Masses and springs within 10 %: a common scale and the first mass are not seen.
    let masses = [0.5593, 0.40, 0.44, 0.41, 0.43, 0.42, 0.40, 0.43];
    let springs = [54e3, 58e3, 55e3, 60e3, 57e3, 52e3, 59e3];
    let measured = targets(&mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap(), 0.0);
    let (masses, springs) = (Quantity::MassFactor, Quantity::StiffnessFactor);
    let parameters = [each(masses, 8), each(springs, 7)].concat();
    for misfit in [Misfit::Absolute, Misfit::Squared] {
        let objective = AntiresonanceObjective::new(
            chain8(INTACT),
            parameters.clone(),
            measured.clone(),
            misfit,
            None,
            0.0,
        )
        .unwrap();
        let bounds = Bounds::uniform(15, 0.9, 1.1).unwrap();
        let options = IslandOptions::default();
        let hooks = &mut Hooks::default();
        let outcome = minimize_objective(&objective, &bounds, &[], &options, 1, 1, hooks).unwrap();
        assert!(outcome.status.success(), "{:?}", outcome.status);
        // The valley has no one set of genes to agree in: three migrations, each after 40 idle generations.
        assert!(outcome.fun < 1e-9 && outcome.nfev < 30_000, "{} {}", outcome.fun, outcome.nfev);
    }
}

/// A free chain of seven equal masses: dof 3 lies on a node of every other mode.
fn symmetric() -> Model {
    mass_spring_chain(&[1.0; 7], &[5e4; 6], 0.0, 0.0).unwrap()
}

fn seen_by(sees: Sees, excitation: usize, dof: usize, freq_hz: Vec<f64>) -> AntiresonanceObjective {
    let targets = (0..7).map(|d| Target {
        ends: (d, excitation).into(),
        freq_hz: if d == dof { freq_hz.clone() } else { vec![] },
        sees,
        together: 0,
    });
    let unknowns = each(Quantity::StiffnessReduction, 6);
    let targets = targets.collect();
    AntiresonanceObjective::new(symmetric(), unknowns, targets, Misfit::Absolute, None, 0.0).unwrap()
}

#[test]
fn what_transmissibilities_see_on_a_node_frfs_do_not() {
    let measured = vec![15.84, 44.38, 64.13];
    let at = |sees, excitation| {
        let objective = seen_by(sees, excitation, 3, measured.clone());
        let pairs = objective.pairs(&[0.0; 6], &mut objective.workspace());
        let rounded = |hz: f64| (100.0 * hz).round() / 100.0;
        pairs.unwrap().iter().map(|p| p.partner_hz.map(rounded)).collect::<Vec<_>>()
    };
    let all: Vec<_> = measured.iter().copied().map(Some).collect();
    assert_eq!(at(Sees::Transmissibility, 0), all);
    assert_eq!(at(Sees::Unknown, 0), all);
    assert_eq!(at(Sees::Frf, 0), [None; 3]);
}

#[test]
fn what_all_responses_share_no_transmissibility_sees() {
    // The force on the node: no response has the odd modes, and their roots are in all numerators.
    let at = |sees| {
        let objective = seen_by(sees, 3, 2, vec![15.84]);
        objective.pairs(&[0.0; 6], &mut objective.workspace()).unwrap()[0].partner_hz.unwrap()
    };
    assert!((at(Sees::Unknown) - 15.838).abs() < 1e-3);
    assert!((at(Sees::Transmissibility) - 21.995).abs() < 1e-3);
    assert!((at(Sees::Frf) - 21.995).abs() < 1e-3);
}

#[test]
fn nothing_jumps_where_a_symmetry_breaks() {
    for (excitation, dof) in [(0, 3), (3, 2)] {
        let objective = seen_by(Sees::Transmissibility, excitation, dof, vec![15.9, 44.1, 64.4]);
        let ws = &mut objective.workspace();
        let mut cost = |beta: f64| objective.cost(&[0.0, beta, 0.0, 0.0, 0.0, 0.0], ws);
        let mut last = cost(0.0);
        // From rounding on, and then by steps in which a root that all share comes in.
        let small = (0..60).map(|i| 1e-16 * 10_f64.powf(f64::from(i) / 5.0));
        let more = (1..2_000).map(|i| 1e-4 + 2e-5 * f64::from(i));
        for beta in small.chain(more) {
            let here = cost(beta);
            assert!((here - last).abs() < 0.03, "{excitation}: {last} to {here} at {beta:e}");
            last = here;
        }
    }
}

#[test]
fn roots_on_a_pole_move_as_differences_say() {
    for (dof, freq_hz) in [(3, vec![15.9, 44.1, 64.4]), (1, vec![11.0, 29.0])] {
        let objective = seen_by(Sees::Transmissibility, 0, dof, freq_hz);
        let ws = &mut objective.workspace();
        let Linearization { jacobian, .. } = objective.linearize(&[0.0; 6], ws).unwrap();
        for (index, row) in jacobian.iter().enumerate() {
            let (value, parameter) = (index / 6, index % 6);
            let mut at = |beta: f64| {
                let mut x = [0.0; 6];
                x[parameter] = beta;
                objective.pairs(&x, ws).unwrap()[value].residual
            };
            let h = 1e-4;
            let difference = (8.0 * (at(h) - at(-h)) - at(2.0 * h) + at(-2.0 * h)) / (12.0 * h);
            assert!((row - difference).abs() < 1e-7, "{dof}, {index}: {row} and {difference}");
        }
    }
}
