//! Ill-posed frames and parameters: an error that names the part.

use antires_core::error::Argument;
use antires_core::fem::checks::check_bounds;
use antires_core::fem::frame::elements::{Dimension, FrameDescription};
use antires_core::fem::frame::{Frame, Property, Scale};
use antires_core::fem::model::Model;
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::fem::term::Term;
use faer::Mat;

use super::build::{beam, each, hanger, joint, line, model, tree, tube, without};

fn refused(change: impl Fn(&mut FrameDescription)) -> String {
    let mut description = tree(Dimension::Plane);
    change(&mut description);
    Frame::new(description).unwrap_err().to_string()
}

#[test]
fn frames_that_cannot_be() {
    for (start, error) in [
        ("elements[7]: got nodes 0 and 1 again", refused(|d| d.elements.push(beam(1, 0, 0)))),
        ("elements[0]: got an element of length 0", refused(|d| d.nodes_m[1] = d.nodes_m[0])),
        ("elements[0]: got node 1 at both ends", refused(|d| each!(d, Beam, 0).nodes = [1, 1])),
        ("elements[0]: got node 99", refused(|d| each!(d, Beam, 0).nodes = [0, 99])),
        ("elements[0]: got section 7", refused(|d| each!(d, Beam, 0).section = 7)),
        ("nodes_m[2]: got NaN m", refused(|d| d.nodes_m[2][0] = f64::NAN)),
        ("nodes_m: got node 9, whose dof 'u'", refused(|d| d.nodes_m.push([3.0; 3]))),
        ("elements: got none", refused(|d| d.elements.clear())),
        ("fixed: got all dofs", refused(|d| d.fixed = (0..27).map(|i| (i / 3, i % 3)).collect())),
        ("fixed[0]: got node 50", refused(|d| d.fixed = vec![(50, 0)])),
        ("point_masses[0]: got -1 kg", refused(|d| each!(d, PointMass, 0).mass_kg = -1.0)),
        (
            "ground_springs[1]: got inf N/m",
            refused(|d| {
                each!(d, GroundSpring, 1).stiffness_n_per_m = f64::INFINITY;
            }),
        ),
        (
            "node_springs[3]: got a direction, between",
            refused(|d| {
                each!(d, NodeSpring, 3).direction = Some(0);
            }),
        ),
        ("node_springs[0]: got no direction", refused(|d| each!(d, NodeSpring, 0).direction = None)),
        (
            "orientation[2]: got [0.5, 0.1, 0.0]",
            refused(|d| {
                each!(d, Beam, 2).reference = Some([0.5, 0.1, 0.0]);
            }),
        ),
    ] {
        assert!(error.starts_with(start), "wanted {start}, got {error}");
    }
}

#[test]
fn a_fixed_dof_is_no_dof() {
    let mut description = line(Dimension::Plane, 2, [1.0, 0.0, 0.0], tube());
    description.fixed = vec![(0, 1)];
    let frame = Frame::new(description).unwrap();
    assert_eq!(frame.dof(0, "theta").unwrap(), 1);
    assert_eq!(frame.dofs().node_and_direction(1), (0, 2));
    let error = frame.dof(0, "v").unwrap_err().to_string();
    assert!(error.starts_with("direction: got 'v' of node 0, which is fixed"), "{error}");
    assert!(frame.dof(0, "w").unwrap_err().to_string().contains("one of u, v, theta"));
    assert!(frame.dof(3, "u").is_err());
}

#[test]
fn parts_that_do_not_hang_together_are_counted() {
    let description = tree(Dimension::Plane);
    assert_eq!(Frame::new(description.clone()).unwrap().parts(), [0; 9]);
    let parts = Frame::new(without(description, "node_springs")).unwrap().parts();
    assert_eq!(parts, [0, 0, 0, 0, 0, 0, 0, 1, 1]);
}

#[test]
fn groups_that_cannot_turn() {
    let frame = |description| Frame::new(description).unwrap();
    let error = |f: &Frame, group: &[usize], pivot| f.downstream(group, pivot).unwrap_err().to_string();
    let tree = tree(Dimension::Plane);
    let open = frame(tree.clone());
    assert!(error(&open, &[0], 4).starts_with("pivot: got node 4, which no element"));
    assert!(error(&open, &[], 4).starts_with("pivot"));
    assert!(error(&open, &[40], 4).starts_with("elements: got element 40"));
    assert!(error(&open, &[4], 40).starts_with("pivot: got node 40"));
    let mut looped = tree;
    looped.elements.push(beam(4, 6, 0));
    let error = error(&frame(looped), &[2], 2);
    assert!(error.starts_with("elements: got a group in a loop through node 2"), "{error}");
}

fn property(property: Property, scale: Scale, terms: &[usize]) -> Parameter {
    Parameter { quantity: Quantity::Property(property, scale), terms: terms.to_vec() }
}

#[test]
fn parameters_that_change_nothing_or_cannot_be() {
    use Property::{Inertia, Mass, SupportStiffness, Thickness, YoungsModulus};
    use Scale::{Factor, Value};
    let mut description = tree(Dimension::Plane);
    description.sections.push(tube()); // section 3, used by no beam
    each!(description, PointMass, 1).inertia_kg_m2 = [0.0; 3];
    description.fixed = vec![(0, 1), (3, 2)];
    let model = model(description);
    for (what, parameter) in [
        ("which no free part", property(YoungsModulus, Value, &[3])),
        ("section 9", property(YoungsModulus, Value, &[9])),
        ("tube section 2", property(Thickness, Value, &[2])),
        ("different values [0.0015, 0.002]", property(Thickness, Value, &[0, 1])),
        ("which are zero", property(Inertia, Factor, &[1])),
        ("which no free part", property(Inertia, Value, &[0])),
        ("which no free part", property(SupportStiffness, Value, &[0])),
        ("point mass 2", property(Mass, Value, &[2])),
    ] {
        let error = parameter.check(&Argument::from("parameters").item(5), &model).unwrap_err().to_string();
        assert!(error.starts_with("parameters[5]: got "), "{error}");
        assert!(error.contains(what), "wanted {what}, got {error}");
    }
    let chain = antires_core::fem::model::mass_spring_chain(&[1.0; 2], &[1.0], 0.0, 0.0).unwrap();
    let error = property(Mass, Value, &[0]).check(&"p".into(), &chain).unwrap_err().to_string();
    assert!(error.contains("FrameModel"), "{error}");
}

#[test]
fn bounds_that_allow_what_cannot_be() {
    use Property::{Diameter, Thickness};
    let model = model(tree(Dimension::Plane));
    let parameters = [property(Thickness, Scale::Value, &[0]), property(Diameter, Scale::Factor, &[0])];
    check_bounds(&model, &parameters, &[0.001, 0.9], &[0.017, 1.1]).unwrap();
    let error = check_bounds(&model, &parameters, &[0.001, 0.85], &[0.017, 1.1]).unwrap_err();
    assert!(error.to_string().contains("thickness_m"), "{error}");

    // A term larger than what the matrix contains: half of it gone leaves K negative.
    let spring = Mat::from_fn(1, 1, |_, _| 3.0);
    let term = Term::from_entries(vec![(0, 0, 5.0)]);
    let matrices = Model::new(spring.clone(), spring, vec![term.clone()], vec![term]).unwrap();
    for (quantity, name) in [(Quantity::StiffnessReduction, "stiffness"), (Quantity::MassFactor, "mass")] {
        let parameter = [Parameter { quantity: quantity.clone(), terms: vec![0] }];
        let (within, beyond) = match quantity {
            Quantity::MassFactor => ([0.5, 1.1], [0.3, 1.1]),
            _ => ([0.0, 0.5], [0.0, 0.7]),
        };
        check_bounds(&matrices, &parameter, &within[..1], &within[1..]).unwrap();
        let error = check_bounds(&matrices, &parameter, &beyond[..1], &beyond[1..]).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn a_spring_to_a_fixed_dof_is_held_and_a_joint_needs_two_nodes() {
    let description = line(Dimension::Plane, 2, [1.0, 0.0, 0.0], tube());
    for element in [hanger(0, 7, 1.0), joint([1, 1], Some(2), 1.0)] {
        let mut description = description.clone();
        description.elements.push(element);
        assert!(Frame::new(description).is_err());
    }
}
