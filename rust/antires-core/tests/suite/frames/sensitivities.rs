//! Sensitivities to every kind of parameter of a frame, against differences of the whole computation.

use antires_core::fem::frame::elements::{Dimension, FrameDescription};
use antires_core::fem::frame::{Angle, Property, Scale};
use antires_core::fem::model::Model;
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::fem::section::Shape;
use antires_core::modal::modes::{eigenvalue, hertz};
use antires_core::optimize::{Linearization, Objective};
use antires_core::update::objective::{AntiresonanceObjective, Target};
use antires_core::update::unknowns::Misfit;

use super::build::{each, hanger, line, lump, model, steel, tube};

/// A pipe of 18 beams, two sections, hung softly, with a silencer near its end: 57 dofs, a case for bands.
fn pipe() -> FrameDescription {
    let mut frame = line(Dimension::Plane, 18, [1.9, 0.2, 0.0], tube());
    frame.sections.push(steel(Shape::Tube { outer_diameter_m: 0.045, thickness_m: 0.0012 }));
    for beam in each!(frame.elements.iter_mut(), Beam).skip(7) {
        beam.section = 1;
    }
    frame.elements.extend([(4, 2.0), (13, 3.5)].map(|(node, mass)| lump(node, mass, [0.01; 3])));
    let hangers = [(0, 0), (1, 1), (9, 1), (17, 1)];
    frame.elements.extend(hangers.map(|(node, direction)| hanger(node, direction, 2.5e3)));
    frame
}

/// One parameter of each kind, several of them on the same beams, and where to take the slopes.
fn parameters(model: &Model) -> (Vec<Parameter>, Vec<f64>) {
    let turned = model.frame().unwrap().downstream(&[10], 10).unwrap();
    let angle = Angle { pivot: 10, axis: [0.0, 0.0, 1.0] };
    let longer = model.frame().unwrap().reach(&[14, 15], 14).unwrap();
    let along: Vec<usize> = longer.iter().map(|step| step.node).collect();
    let property = |p, scale| Quantity::Property(p, scale);
    [
        (Quantity::StiffnessReduction, vec![3], 0.3),
        (Quantity::StiffnessFactor, vec![2, 3, 11], 1.1),
        (Quantity::MassFactor, vec![12], 0.9),
        (property(Property::YoungsModulus, Scale::Value), vec![0], 1.95e11),
        (property(Property::Density, Scale::Factor), vec![0, 1], 1.04),
        (property(Property::Thickness, Scale::Value), vec![1], 0.0014),
        (property(Property::Diameter, Scale::Factor), vec![0], 0.97),
        (property(Property::Mass, Scale::Value), vec![1], 3.1),
        (property(Property::Inertia, Scale::Value), vec![0], 0.02),
        (property(Property::SupportStiffness, Scale::Factor), vec![1, 2], 1.3),
        (Quantity::Angle(angle), turned, 12.0),
        (Quantity::Position([0.6, 0.8, 0.0]), vec![6, 7], 0.02),
        (Quantity::Length(longer), along, 1.04),
    ]
    .map(|(quantity, terms, at)| (Parameter { quantity, terms }, at))
    .into_iter()
    .unzip()
}

#[test]
fn sensitivities_of_frames_are_the_limit_of_differences() {
    let model = model(pipe());
    let (parameters, at) = parameters(&model);
    let targets = [4, 10, 19, 31, 46, 52].map(|dof| Target {
        ends: (dof, 4).into(),
        freq_hz: vec![61.0, 118.0, 203.0, 310.0],
        ..Target::default()
    });
    let objective =
        AntiresonanceObjective::new(model, parameters, targets.to_vec(), Misfit::Squared, None, 0.0).unwrap();
    let ws = &mut objective.workspace();
    let Linearization { residuals, jacobian, .. } = objective.linearize(&at, ws).unwrap();
    let n = at.len();
    let mut largest = vec![0.0_f64; n];
    for index in 0..n {
        let step = 1e-4 * at[index];
        let mut moved = |times: f64| -> Vec<f64> {
            let mut p = at.clone();
            p[index] += times * step;
            let pairs = objective.pairs(&p, ws).unwrap();
            pairs.iter().map(|f| eigenvalue(f.partner_hz.unwrap())).collect()
        };
        let (a, b, c, d) = (moved(1.0), moved(-1.0), moved(2.0), moved(-2.0));
        for row in 0..residuals.len() {
            let difference = (8.0 * (a[row] - b[row]) - c[row] + d[row]) / (12.0 * step);
            let measured = eigenvalue([61.0, 118.0, 203.0, 310.0][row % 4]);
            // Per unit of relative change (of a degree for the angle), so that 1 is a large slope.
            let scale = at[index];
            let analytic = jacobian[row * n + index] * scale;
            let difference = difference / measured * scale;
            assert!(
                (analytic - difference).abs() <= 2e-7 * (1.0 + difference.abs()),
                "parameter {index}, value {row} near {:.1} Hz: {analytic} and {difference}",
                hertz(measured)
            );
            largest[index] = largest[index].max(difference.abs());
        }
    }
    assert!(largest.iter().all(|slope| *slope > 1e-5), "{largest:?}");
}
