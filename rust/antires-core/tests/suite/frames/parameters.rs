//! Parameters of frames: formed again they are the frame built anew, and rigid motions stay free.

use antires_core::error::Argument;
use antires_core::fem::assembly::Assembly;
use antires_core::fem::frame::elements::Dimension;
use antires_core::fem::frame::{Angle, Property, Scale};
use antires_core::fem::model::Model;
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::fem::section::Shape;
use antires_core::linalg::sparse::SparseMatrix;

use super::build::{each, model, tree, without};
use super::laws::rigid_motions;

const BOTH: [Dimension; 2] = [Dimension::Plane, Dimension::Space];
const AXIS: [f64; 3] = [0.3, -0.2, 0.9];

fn set(property: Property, scale: Scale, terms: &[usize]) -> Parameter {
    Parameter { quantity: Quantity::Property(property, scale), terms: terms.to_vec() }
}

fn angle(model: &Model, group: &[usize], pivot: usize) -> Parameter {
    let frame = model.frame().unwrap();
    let axis = match frame.description().dimension {
        Dimension::Plane => [0.0, 0.0, 1.0],
        Dimension::Space => AXIS,
    };
    Parameter {
        quantity: Quantity::Angle(Angle { pivot, axis }),
        terms: frame.downstream(group, pivot).unwrap(),
    }
}

/// One of each kind, all at once, with values off their nominal ones.
fn all_kinds(model: &Model) -> (Vec<Parameter>, Vec<f64>) {
    use Property::{Density, Diameter, Inertia, Mass, SupportStiffness, Thickness, YoungsModulus};
    let term = |quantity, terms: &[usize]| Parameter { quantity, terms: terms.to_vec() };
    vec![
        (term(Quantity::StiffnessReduction, &[1]), 0.4),
        (term(Quantity::StiffnessReduction, &[3, 5]), 0.2),
        (term(Quantity::StiffnessFactor, &[9]), 1.3), // a joint spring
        (term(Quantity::MassFactor, &[0]), 1.1),
        (term(Quantity::MassFactor, &[8]), 0.7), // the second lump
        (set(YoungsModulus, Scale::Value, &[0, 1]), 1.9e11),
        (set(Density, Scale::Factor, &[2]), 1.07),
        (set(Thickness, Scale::Value, &[0]), 0.0018),
        (set(Diameter, Scale::Factor, &[0, 1]), 1.05),
        (set(Mass, Scale::Value, &[0]), 2.6),
        (set(Inertia, Scale::Factor, &[1]), 1.4),
        (set(SupportStiffness, Scale::Value, &[0, 1]), 3.1e3),
        (angle(model, &[2], 2), 6.0),
        (angle(model, &[3], 3), -11.0),
        (angle(model, &[4, 5], 2), 3.5),
    ]
    .into_iter()
    .unzip()
}

fn close(a: &SparseMatrix, b: &SparseMatrix) {
    let (a, b) = (a.to_dense(), b.to_dense());
    let (scale, difference) = (b.norm_max(), (a - b).norm_max());
    assert!(difference <= 4.0 * f64::EPSILON * scale, "{:e}", difference / scale);
}

fn bits(assembly: &Assembly) -> Vec<u64> {
    let entries = |m: &SparseMatrix| -> Vec<u64> { m.values.iter().map(|v| v.to_bits()).collect() };
    [entries(&assembly.stiffness), entries(&assembly.mass)].concat()
}

#[test]
fn forming_again_is_building_anew_and_forgets_what_was_before() {
    for dimension in BOTH {
        let nominal = model(tree(dimension));
        let (mut parameters, mut x) = all_kinds(&nominal);
        parameters.push(Parameter { quantity: Quantity::Position([0.6, 0.8, 0.0]), terms: vec![1, 3] });
        x.push(0.013);
        for (i, parameter) in parameters.iter().enumerate() {
            parameter.check(&Argument::from("parameters").item(i), &nominal).unwrap();
        }
        let mut assembly = Assembly::new(&nominal);
        let untouched = bits(&assembly);
        assembly.form(&nominal, &parameters, &x);
        let updated = nominal.at(&parameters, &x).unwrap();
        close(&assembly.stiffness, updated.stiffness());
        close(&assembly.mass, updated.mass());
        let first = bits(&assembly);

        // Each kind alone, too; and the state after it is that of the vector alone.
        let rest: Vec<f64> = parameters.iter().map(|p| p.nominal(&nominal).unwrap_or(1.0)).collect();
        for i in 0..x.len() {
            let mut one = rest.clone();
            one[i] = x[i];
            assembly.form(&nominal, &parameters, &one);
            assert_ne!(bits(&assembly), untouched, "parameter {i} changes nothing");
            let alone = nominal.at(&parameters, &one).unwrap();
            close(&assembly.stiffness, alone.stiffness());
            close(&assembly.mass, alone.mass());
        }
        assembly.form(&nominal, &parameters, &rest);
        assert_eq!(bits(&assembly), untouched);
        assembly.form(&nominal, &parameters, &x);
        assert_eq!(bits(&assembly), first);
    }
}

#[test]
fn the_updated_frame_is_nominal_at_its_new_state() {
    for dimension in BOTH {
        let nominal = model(tree(dimension));
        let (parameters, x) = all_kinds(&nominal);
        let updated = nominal.at(&parameters, &x).unwrap();
        let parts = updated.frame().unwrap().description();
        assert_eq!(parts.sections[1].youngs_modulus_pa, 1.9e11);
        let Shape::Tube { outer_diameter_m, thickness_m } = parts.sections[0].shape else { panic!() };
        assert_eq!((outer_diameter_m, thickness_m), (0.038 * 1.05, 0.0018));
        let lump = each!(parts.elements.iter(), PointMass).next().unwrap();
        let hanger = each!(parts.elements.iter(), GroundSpring).nth(1).unwrap();
        assert_eq!((lump.mass_kg, hanger.stiffness_n_per_m), (2.6, 3.1e3));
        assert_eq!(parameters[5].nominal(&updated), Some(1.9e11));
        // Lengths are kept by turning.
        for beam in parts.beams() {
            let length = |m: &Model| {
                let nodes = &m.frame().unwrap().description().nodes_m;
                let [a, b] = beam.nodes.map(|n| nodes[n]);
                (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
            };
            assert!((length(&updated) / length(&nominal) - 1.0).abs() < 1e-14);
        }
        // Built anew from that description, only the factors on beams are missing.
        let (same, rest) = (Assembly::new(&updated), vec![]);
        let again = updated.at(&rest, &[]).unwrap();
        assert_eq!(same.stiffness, *again.stiffness());
    }
}

#[test]
fn rigid_motions_stay_free_at_any_angle() {
    for dimension in BOTH {
        let nominal = model(without(tree(dimension), "ground_springs"));
        let parameters = [angle(&nominal, &[2], 2), angle(&nominal, &[3], 3), angle(&nominal, &[4], 2)];
        let mut assembly = Assembly::new(&nominal);
        for degrees in [0.1, 7.0, 45.0, 90.0, 137.0, 180.0, -260.0] {
            let x = [degrees, -0.7 * degrees, 0.3 * degrees];
            assembly.form(&nominal, &parameters, &x);
            let turned = nominal.at(&parameters, &x).unwrap();
            let forces = assembly.stiffness.to_dense() * rigid_motions(&turned);
            let scale = assembly.stiffness.norm_max();
            assert!(forces.norm_max() < 2e-14 * scale, "{degrees}: {:e}", forces.norm_max() / scale);
            // The nominal rigid rotations are not those of the turned structure: the test can fail.
            let others = assembly.stiffness.to_dense() * rigid_motions(&nominal);
            assert!(others.norm_max() > 1e-5 * scale);
        }
    }
}

#[test]
fn nested_angles_turn_what_lies_downstream() {
    let nominal = model(tree(Dimension::Plane));
    let frame = nominal.frame().unwrap();
    assert_eq!(frame.downstream(&[2], 2).unwrap(), [3, 4]);
    assert_eq!(frame.downstream(&[4], 2).unwrap(), [5, 6, 7, 8]);
    assert_eq!(frame.downstream(&[1], 1).unwrap(), [2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(frame.downstream(&[1], 2).unwrap(), [0, 1]);
    let parameters = [angle(&nominal, &[2], 2), angle(&nominal, &[3], 3)];
    let turned = nominal.at(&parameters, &[90.0, -90.0]).unwrap();
    let (then, now) = (&frame.description().nodes_m, &turned.frame().unwrap().description().nodes_m);
    // Node 3 has turned about node 2; beam 3 points where it did.
    assert!((now[3][0] - (then[2][0] - (then[3][1] - then[2][1]))).abs() < 1e-15);
    assert!((now[3][1] - (then[2][1] + (then[3][0] - then[2][0]))).abs() < 1e-15);
    for axis in 0..2 {
        assert!(((now[4][axis] - now[3][axis]) - (then[4][axis] - then[3][axis])).abs() < 1e-15);
    }
}
