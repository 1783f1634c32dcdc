//! One evaluation of J: the damage of the eight-mass chain (7 unknowns, 28 antiresonances), and of a frame like the
//! exhaust system (144 dofs, 30 unknowns, 16 responses to 260 Hz), with and without derivatives.
#![allow(missing_docs)]

mod common;

use std::hint::black_box;

use antires_core::antiresonances::{Query, Route, antiresonances};
use antires_core::fem::model::Model;
use antires_core::fem::parameters::Parameter;
use antires_core::optimize::Objective;
use antires_core::update::objective::{AntiresonanceObjective, Target};
use antires_core::update::unknowns::{Misfit, Penalty};
use criterion::{Criterion, criterion_group, criterion_main};

/// The search for the damage of element `damaged`, from exact antiresonances up to `f_max_hz`.
fn damage_objective(
    model: &Model,
    unknowns: Vec<Parameter>,
    damaged: usize,
    (dofs, excitation): (&[usize], usize),
    f_max_hz: f64,
) -> AntiresonanceObjective {
    let truth = common::reductions(damaged..damaged + 1);
    let truth = model.at(&truth, &[0.55]).unwrap();
    let query = Query { route: Route::Modal, f_max_hz, include_cancelled: false };
    let ends: Vec<_> = dofs.iter().map(|&dof| (dof, excitation).into()).collect();
    let measured = antiresonances(&truth, &ends, &query).unwrap();
    let targets = dofs.iter().zip(measured).map(|(&dof, found)| Target {
        ends: (dof, excitation).into(),
        freq_hz: found.freq_hz,
        ..Target::default()
    });
    let penalty = Penalty { gamma1: 0.1, gamma2: 0.1 };
    let (model, targets) = (model.clone(), targets.collect());
    let (misfit, penalty) = (Misfit::Absolute, Some(penalty));
    AntiresonanceObjective::new(model, unknowns, targets, misfit, penalty, 1e-3).unwrap()
}

fn objective(criterion: &mut Criterion) {
    let all: Vec<usize> = (0..8).collect();
    let sensors = common::sensors(16);
    let chain = damage_objective(&common::chain8(), common::reductions(0..7), 4, (&all, 0), f64::INFINITY);
    let frame =
        damage_objective(&common::exhaust_like(), common::reductions(17..47), 31, (&sensors, 1), 260.0);
    let mut group = criterion.benchmark_group("objective");
    for (name, objective, n) in [("chain8", &chain, 7), ("exhaust_like", &frame, 30)] {
        // A few damaged elements, as a search has them.
        let x: Vec<f64> = (0..n).map(|i| if i % 4 == 1 { 0.025 * f64::from(i + 1) } else { 0.0 }).collect();
        let mut workspace = objective.workspace();
        group.bench_function(format!("{name}/cost"), |bench| {
            bench.iter(|| objective.cost(black_box(&x), &mut workspace));
        });
        group.bench_function(format!("{name}/linearize"), |bench| {
            bench.iter(|| objective.linearize(black_box(&x), &mut workspace));
        });
    }
    group.finish();
}

criterion_group!(benches, objective);
criterion_main!(benches);
