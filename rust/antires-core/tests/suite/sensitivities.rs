//! Sensitivities of antiresonances against central differences of the whole computation.

use std::sync::Arc;

use antires_core::antiresonances::{AntiresonanceSolver, Query, Route, ZeroSensitivity, antiresonances};
use antires_core::fem::assembly::Slopes;
use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::modal::modes::eigenvalue;
use antires_core::modal::structure::Structure;
use antires_core::optimize::{Linearization, Objective};
use antires_core::update::objective::{AntiresonanceObjective, Target};
use antires_core::update::unknowns::{Misfit, Penalty};

/// A grounded chain with no symmetry.
fn chain() -> Model {
    let masses = [0.56, 0.42, 0.38, 0.47, 0.41, 0.44];
    let springs = [5.1e4, 6.2e4, 4.7e4, 5.9e4, 5.3e4];
    mass_spring_chain(&masses, &springs, 900.0, 0.0).unwrap()
}

/// One parameter of each kind, two of them on the same term.
fn parameters() -> Vec<Parameter> {
    let of = |quantity, terms: &[usize]| Parameter { quantity, terms: terms.to_vec() };
    vec![
        of(Quantity::StiffnessReduction, &[2]),
        of(Quantity::StiffnessFactor, &[1, 2]),
        of(Quantity::MassFactor, &[3]),
        of(Quantity::MassFactor, &[0, 4]),
        of(Quantity::StiffnessFactor, &[5]),
        of(Quantity::GroupValue(0.8, vec![(false, 3), (false, -1), (true, 1)]), &[2, 4, 3]),
    ]
}

const AT: [f64; 6] = [0.3, 1.1, 0.9, 1.05, 1.2, 0.95];

fn solver(model: &Model) -> AntiresonanceSolver {
    AntiresonanceSolver::new(&Arc::new(Structure::of(model)))
}

fn zeros(model: &Model, response: usize) -> Vec<f64> {
    let query = Query { route: Route::Modal, f_max_hz: f64::INFINITY, include_cancelled: false };
    let found = antiresonances(model, &[(response, 1).into()], &query).unwrap();
    found[0].freq_hz.iter().map(|&f| eigenvalue(f)).collect()
}

#[test]
fn analytic_sensitivities_are_the_limit_of_differences() {
    let (model, parameters) = (chain(), parameters());
    let here = model.at(&parameters, &AT).unwrap();
    let mut solver = solver(&here);
    let mut prepared = solver.prepare(here.stiffness(), here.mass());
    let slopes = Slopes::new(&model, &parameters, &AT);
    let mut zero = ZeroSensitivity::default();
    let mut compared = 0;
    for response in 0..6 {
        for (nth, x) in zeros(&here, response).into_iter().enumerate() {
            zero.set(&mut prepared, &(response, 1).into(), x).unwrap();
            for index in 0..parameters.len() {
                let moved = |h: f64| {
                    let mut p = AT;
                    p[index] += h;
                    zeros(&model.at(&parameters, &p).unwrap(), response)[nth]
                };
                // Fourth order: truncation h^4 = 1e-12, rounding 1e-15 / h = 1e-12.
                let h = 1e-3;
                let difference =
                    (8.0 * (moved(h) - moved(-h)) - moved(2.0 * h) + moved(-2.0 * h)) / (12.0 * h);
                let analytic = zero.along(&slopes.along(index));
                assert!(
                    (analytic - difference).abs() <= 1e-8 * x,
                    "response {response}, zero {nth}, parameter {index}: {analytic} and {difference}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 90, "{compared} compared");
}

#[test]
fn one_mass_between_two_springs_moves_as_the_textbook_says() {
    // H_11 of two masses on a spring between them: its zero is x = k / m_2.
    let model = mass_spring_chain(&[1.0, 2.0], &[500.0], 0.0, 0.0).unwrap();
    let parameters = [Quantity::StiffnessReduction, Quantity::MassFactor]
        .map(|quantity| Parameter { terms: vec![usize::from(quantity == Quantity::MassFactor)], quantity });
    let slopes = Slopes::new(&model, &parameters, &[0.0, 1.0]);
    let mut zero = ZeroSensitivity::default();
    let mut solver = solver(&model);
    let mut prepared = solver.prepare(model.stiffness(), model.mass());
    zero.set(&mut prepared, &(0, 0).into(), 250.0).unwrap();
    for index in 0..2 {
        let slope = zero.along(&slopes.along(index));
        assert!((slope + 250.0).abs() < 1e-9, "{slope}");
    }
    // Of a model that has lost half of its spring, half is a quarter.
    let half = model.at(&parameters, &[0.5, 1.0]).unwrap();
    assert_eq!(half.at(&parameters, &[0.5, 1.0]).unwrap().stiffness().get(0, 0), 125.0);
}

fn objective(misfit: Misfit, penalty: Option<Penalty>) -> AntiresonanceObjective {
    let truth = chain().at(&parameters(), &[0.5, 1.02, 1.1, 0.97, 0.8]).unwrap();
    let hertz = |x: &f64| x.sqrt() / std::f64::consts::TAU;
    let targets = (0..6).map(|dof| Target {
        ends: (dof, 1).into(),
        freq_hz: zeros(&truth, dof).iter().map(hertz).collect(),
        ..Target::default()
    });
    AntiresonanceObjective::new(chain(), parameters(), targets.collect(), misfit, penalty, 1e-3).unwrap()
}

#[test]
fn a_linearization_has_the_objectives_cost_and_its_slope() {
    let penalty = Some(Penalty { gamma1: 0.1, gamma2: 0.1 });
    for (misfit, penalty) in [(Misfit::Absolute, penalty), (Misfit::Squared, None)] {
        let objective = objective(misfit, penalty);
        let ws = &mut objective.workspace();
        let Linearization { cost, residuals, jacobian } = objective.linearize(&AT, ws).unwrap();
        assert_eq!(cost, objective.cost(&AT, ws));
        let price = objective.composition().unwrap().price;
        for (index, price) in price.iter().enumerate() {
            let columns = residuals.iter().zip(jacobian.chunks_exact(AT.len()));
            let slope: f64 = columns
                .map(|(e, row)| match misfit {
                    Misfit::Squared => 2.0 * e * row[index],
                    _ => e.signum() * row[index],
                })
                .sum();
            let h = 1e-6;
            let moved = |h: f64| {
                let mut p = AT;
                p[index] += h;
                objective.cost(&p, &mut objective.workspace())
            };
            let difference = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((slope + price - difference).abs() < 1e-6, "{index}: {slope} {difference}");
        }
    }
}
