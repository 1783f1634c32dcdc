//! The comparison objective: resonances and mode shapes in, parameters out.

use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::modal::mac::Shape;
use antires_core::modal::modes::AllModes;
use antires_core::optimize::{Bounds, Hooks, IslandOptions, Objective, minimize_objective};
use antires_core::update::modal_objective::{MeasuredMode, ModalObjective};
use antires_core::update::unknowns::Misfit;

use crate::common::chain8::{
    INTACT, PAPER, assert_found, assert_same_for_any_threads, chain8, damaged, each, search,
};

/// The flexible modes `wanted` of a model at `dofs`, turned into the complex plane, each entry shifted by a
/// fixed pattern of up to `error`.
fn measured(
    model: &Model,
    wanted: impl Iterator<Item = usize>,
    dofs: &[usize],
    error: f64,
) -> Vec<MeasuredMode> {
    let solved = AllModes::of(model).unwrap().finite();
    let mut count = 0;
    let mut noise = || {
        count += 1;
        error * (2.3 * f64::from(count)).sin()
    };
    wanted
        .map(|r| {
            let largest = solved.shapes.col(r).iter().fold(0.0_f64, |m, p| m.max(p.abs()));
            let (cos, sin) = (0.9_f64.cos(), 0.9_f64.sin());
            let entries: Vec<(f64, f64)> = dofs
                .iter()
                .map(|&dof| {
                    let (a, b) = (solved.shapes[(dof, r)] / largest + noise(), noise());
                    (a * cos - b * sin, a * sin + b * cos)
                })
                .collect();
            MeasuredMode {
                freq_hz: solved.freq_hz[r] * (1.0 + 0.1 * noise()),
                shape: Shape::new("shape", dofs.to_vec(), &entries).unwrap(),
            }
        })
        .collect()
}

fn damage_objective(dofs: &[usize], error: f64) -> ModalObjective {
    ModalObjective::new(
        chain8(INTACT),
        each(Quantity::StiffnessReduction, 7),
        measured(&chain8(damaged()), 1..8, dofs, error),
        Misfit::Absolute,
        Some(PAPER),
        1e-3,
    )
    .unwrap()
}

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

#[test]
fn two_masses_on_two_springs_cost_what_the_closed_form_says() {
    // Equal masses m, ground - k - m - k p - m: x = (k/m) (1 + 2p ± √(1 + 4p²)) / 2, shape (1, 1 − x' / p), ...
    let (m, k) = (2.0, 300.0);
    let model = mass_spring_chain(&[m, m], &[k], k, 0.0).unwrap();
    let spring = each(Quantity::StiffnessFactor, 1);
    let at = |p: f64| {
        [-1.0, 1.0].map(|sign| {
            // K = k [[1 + p, −p], [−p, p]]: (1 + p − y) a = p b with y = x m / k.
            let y = (1.0 + 2.0 * p + sign * (1.0 + 4.0 * p * p).sqrt()) / 2.0;
            (y * k / m, [p, 1.0 + p - y])
        })
    };
    let truth = at(1.0);
    let mut wanted = Vec::new();
    for (x, shape) in truth {
        let entries = shape.map(|v| (0.6 * v, -0.8 * v));
        wanted.push(MeasuredMode {
            freq_hz: x.sqrt() / std::f64::consts::TAU,
            shape: Shape::new("shape", vec![0, 1], &entries).unwrap(),
        });
    }
    let objective = |misfit| {
        let (model, spring, wanted) = (model.clone(), spring.clone(), wanted.clone());
        ModalObjective::new(model, spring, wanted, misfit, None, 0.0).unwrap()
    };
    for p in [0.3, 0.8, 1.0, 1.7] {
        let (mut e, mut shapes) = (Vec::new(), 0.0);
        for ((x, a), (y, b)) in at(p).into_iter().zip(truth) {
            let dot = |u: [f64; 2], v: [f64; 2]| u[0] * v[0] + u[1] * v[1];
            let mac = dot(a, b).powi(2) / (dot(a, a) * dot(b, b));
            e.push(x / y - 1.0);
            shapes += (1.0 - mac).powi(2);
        }
        for (misfit, frequencies) in [
            (Misfit::Absolute, e[0].abs() + e[1].abs()),
            (Misfit::Squared, e[0] * e[0] + e[1] * e[1]),
            (Misfit::Largest, e[0].abs().max(e[1].abs())),
        ] {
            let objective = objective(misfit);
            let cost = objective.cost(&[p], &mut objective.workspace());
            assert!((cost - frequencies - shapes).abs() < 1e-12, "{p} {cost}");
        }
    }
}

#[test]
fn the_truth_costs_its_penalties_and_nothing_more() {
    for dofs in [&ALL[..], &[2, 7], &[3]] {
        let objective = damage_objective(dofs, 0.0);
        let truth = [0.0, 0.0, 0.0, 0.0, 0.55, 0.0, 0.0];
        let cost = objective.cost(&truth, &mut objective.workspace());
        assert!((cost - 0.155).abs() < 1e-9, "{dofs:?} {cost}");
    }
}

/// A free chain of 60 masses without symmetry, for the band route, and 9 for the dense one.
fn long_chain(n: usize) -> Model {
    let wave = |i: usize, a: f64| 1.0 + 0.3 * (a * i as f64).sin();
    let masses: Vec<f64> = (0..n).map(|i| 0.5 * wave(i, 1.7)).collect();
    let springs: Vec<f64> = (1..n).map(|i| 5e4 * wave(i, 0.9)).collect();
    mass_spring_chain(&masses, &springs, 0.0, 2e3).unwrap()
}

fn mixed() -> Vec<Parameter> {
    let of = |quantity, terms: &[usize]| Parameter { quantity, terms: terms.to_vec() };
    vec![
        of(Quantity::StiffnessReduction, &[2]),
        of(Quantity::StiffnessFactor, &[1, 2, 5]),
        of(Quantity::MassFactor, &[3]),
        of(Quantity::MassFactor, &[0, 6, 7]),
    ]
}

#[test]
fn a_linearization_has_the_objectives_cost_and_its_slope() {
    let at = [0.3, 1.1, 0.9, 1.05];
    for n in [9, 60] {
        let model = long_chain(n);
        let truth = model.at(&mixed(), &[0.5, 1.02, 1.1, 0.97]).unwrap();
        let dofs = [0, 2, 3, 6, 8];
        for (misfit, penalty) in [(Misfit::Absolute, Some(PAPER)), (Misfit::Squared, None)] {
            let objective = ModalObjective::new(
                model.clone(),
                mixed(),
                measured(&truth, 1..6, &dofs, 0.05),
                misfit,
                penalty,
                1e-3,
            )
            .unwrap()
            .with_weights(Some(vec![1.0, 2.0, 0.5, 1.0, 0.7]))
            .unwrap();
            let ws = &mut objective.workspace();
            let here = objective.linearize(&at, ws).unwrap();
            assert_eq!(here.cost, objective.cost(&at, ws));
            let moved = |index: usize, h: f64| {
                let mut p = at;
                p[index] += h;
                objective.linearize(&p, &mut objective.workspace()).unwrap().residuals
            };
            let h = 1e-4;
            for index in 0..4 {
                let (ahead, behind) = (moved(index, h), moved(index, -h));
                for row in 0..10 {
                    let difference = (ahead[row] - behind[row]) / (2.0 * h);
                    let slope = here.jacobian[4 * row + index];
                    assert!(
                        (slope - difference).abs() < 1e-6,
                        "{n} dofs, residual {row}, parameter {index}: {slope} {difference}"
                    );
                }
            }
            // The residuals in their norm, with the penalty, are J.
            let norm = |e: &f64| match misfit {
                Misfit::Squared => e * e,
                _ => e.abs(),
            };
            let charged = if penalty.is_some() { 0.1 + 0.03 } else { 0.0 };
            let sum = here.residuals.iter().map(norm).sum::<f64>() + charged;
            assert!((here.cost - sum).abs() < 1e-12);
        }
    }
}

#[test]
fn the_band_and_the_dense_route_agree() {
    // 60 dofs go by the band for a few modes, and densely where most are asked for.
    let model = long_chain(60);
    let of = |wanted: std::ops::Range<usize>| {
        let truth = model.at(&mixed(), &[0.5, 1.02, 1.1, 0.97]).unwrap();
        let measured = measured(&truth, wanted, &[0, 7, 20, 33, 59], 0.02);
        ModalObjective::new(model.clone(), mixed(), measured, Misfit::Absolute, None, 0.0).unwrap()
    };
    let (few, most) = (of(0..8), of(0..50));
    for x in [[0.0, 1.0, 1.0, 1.0], [0.9, 0.7, 1.3, 0.8]] {
        let pairs = |objective: &ModalObjective| {
            let ws = &mut objective.workspace();
            let pairs = objective.pairs(&x, ws).unwrap();
            pairs.into_iter().take(8).map(Option::unwrap)
        };
        for (a, b) in pairs(&few).zip(pairs(&most)) {
            assert_eq!(a.mode, b.mode);
            assert!((a.lambda / b.lambda - 1.0).abs() < 1e-9, "{a:?} {b:?}");
            assert!((a.mac - b.mac).abs() < 1e-9, "{a:?} {b:?}");
        }
    }
}

#[test]
fn modes_that_cross_keep_their_shapes() {
    // Two oscillators hardly joined: the stiffer one of the model is the softer one of the structure.
    let build = |a, b| mass_spring_chain(&[1.0, 1.0], &[1.0], a, b).unwrap();
    let truth = build(900.0, 1000.0);
    let parameters = vec![
        Parameter { quantity: Quantity::StiffnessFactor, terms: vec![1] },
        Parameter { quantity: Quantity::StiffnessFactor, terms: vec![2] },
    ];
    let measured = measured(&truth, 0..2, &[0, 1], 0.0);
    let objective =
        ModalObjective::new(build(1000.0, 900.0), parameters, measured, Misfit::Absolute, None, 0.0).unwrap();
    let pairs = objective.pairs(&[1.0, 1.0], &mut objective.workspace()).unwrap();
    let partners: Vec<usize> = pairs.iter().map(|p| p.unwrap().mode).collect();
    assert_eq!(partners, [1, 0]);
    let bounds = Bounds::uniform(2, 0.7, 1.3).unwrap();
    let (options, hooks) = (IslandOptions::default(), &mut Hooks::default());
    let outcome = minimize_objective(&objective, &bounds, &[], &options, 1, 1, hooks).unwrap();
    assert!((outcome.x[0] - 0.9).abs() < 1e-6 && (outcome.x[1] - 10.0 / 9.0).abs() < 1e-6);
}

#[test]
fn the_damaged_spring_is_found_from_imperfect_modes() {
    for (dofs, seed) in [(&ALL[..], 1), (&ALL, 2), (&[0, 3, 6], 3)] {
        let outcome = search(&damage_objective(dofs, 1e-2), seed, 2);
        assert_found(&outcome);
    }
}

#[test]
fn the_outcome_does_not_depend_on_the_number_of_threads() {
    assert_same_for_any_threads(&damage_objective(&ALL, 1e-2));
}

#[test]
fn the_cost_is_finite_everywhere_even_where_springs_are_gone() {
    let objective = damage_objective(&[1, 6], 0.0);
    let mut workspace = objective.workspace();
    for mask in 0..128_u32 {
        let x: Vec<f64> = (0..7).map(|i| f64::from((mask >> i) & 1)).collect();
        let cost = objective.cost(&x, &mut workspace);
        assert!(cost.is_finite() && cost >= 0.0, "{x:?}: {cost}");
    }
    // All springs gone leave rigid bodies only: seven modes, one for the frequency and one for the shape.
    let none = objective.cost(&[1.0; 7], &mut workspace);
    assert!((none - (14.0 + 1.4)).abs() < 1e-12, "{none}");
}

#[test]
fn wrong_problems_are_refused_by_name() {
    let build = |freq_hz, dof| {
        let mode = MeasuredMode { freq_hz, shape: Shape::new("shape", vec![dof], &[(1.0, 0.0)]).unwrap() };
        let (model, parameters) = (chain8(INTACT), each(Quantity::StiffnessReduction, 7));
        let wrong = ModalObjective::new(model, parameters, vec![mode], Misfit::Absolute, None, 0.0);
        wrong.err().expect("refused").to_string()
    };
    assert!(build(10.0, 8).starts_with("measured: got dof 8"));
    assert!(build(0.0, 1).contains("Leave rigid-body modes out"));
    assert!(build(f64::NAN, 1).contains("positive, finite"));
    let (model, parameters) = (chain8(INTACT), each(Quantity::StiffnessReduction, 7));
    let none = ModalObjective::new(model, parameters, vec![], Misfit::Absolute, None, 0.0);
    assert!(none.err().unwrap().to_string().contains("at least one"));
    let weighted = damage_objective(&ALL, 0.0).with_weights(Some(vec![1.0; 6]));
    assert!(weighted.err().unwrap().to_string().starts_with("weights"));
}
