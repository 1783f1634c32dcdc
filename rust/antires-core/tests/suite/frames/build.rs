//! Frames that the tests share.

use antires_core::fem::frame::Frame;
use antires_core::fem::frame::elements::{
    Beam, Dimension, Element, FrameDescription, GroundSpring, NodeSpring, PointMass,
};
use antires_core::fem::model::Model;
use antires_core::fem::section::{Section, Shape, Shear};

pub fn steel(shape: Shape) -> Section {
    Section { shape, youngs_modulus_pa: 2.1e11, density_kg_per_m3: 7850.0, poisson: 0.3, shear: Shear::Rigid }
}

pub fn tube() -> Section {
    steel(Shape::Tube { outer_diameter_m: 0.038, thickness_m: 0.0015 })
}

/// The elements of one kind.
macro_rules! each {
    ($elements:expr, $kind:ident) => {
        $elements.filter_map(|element| match element {
            antires_core::fem::frame::elements::Element::$kind(part) => Some(part),
            _ => None,
        })
    };
    ($frame:expr, $kind:ident, $number:expr) => {
        each!($frame.elements.iter_mut(), $kind).nth($number).unwrap()
    };
}
pub(crate) use each;

/// Takes all elements of one argument out.
pub fn without(mut frame: FrameDescription, argument: &str) -> FrameDescription {
    frame.elements.retain(|element| element.argument() != argument);
    frame
}

pub fn beam(a: usize, b: usize, section: usize) -> Element {
    Beam::new([a, b], section).into()
}

pub fn lump(node: usize, mass_kg: f64, inertia_kg_m2: [f64; 3]) -> Element {
    Element::PointMass(PointMass { node, mass_kg, inertia_kg_m2 })
}

pub fn hanger(node: usize, direction: usize, stiffness_n_per_m: f64) -> Element {
    Element::GroundSpring(GroundSpring { node, direction, stiffness_n_per_m })
}

pub fn joint(nodes: [usize; 2], direction: Option<usize>, stiffness_n_per_m: f64) -> Element {
    Element::NodeSpring(NodeSpring { nodes, direction, stiffness_n_per_m })
}

pub fn plain(dimension: Dimension, nodes_m: Vec<[f64; 3]>, elements: Vec<Element>) -> FrameDescription {
    let sections = vec![tube()];
    FrameDescription { dimension, nodes_m, sections, elements, fixed: vec![] }
}

/// A straight beam of `n` elements from the origin to `end`.
pub fn line(dimension: Dimension, n: usize, end: [f64; 3], section: Section) -> FrameDescription {
    let nodes = (0..=n).map(|i| end.map(|x| x * i as f64 / n as f64)).collect();
    let mut frame = plain(dimension, nodes, (0..n).map(|i| beam(i, i + 1, 0)).collect());
    frame.sections = vec![section];
    frame
}

pub fn model(description: FrameDescription) -> Model {
    Model::from_frame(Frame::new(description).unwrap()).unwrap()
}

/// A tree with a branch, two sections, lumps, hangers and a joint spring:
///
/// ```text
/// 0 -0- 1 -1- 2 -2- 3 -3- 4        nodes and beams; the branch 2 -4- 5 -5- 6; node 7 hangs at 6 by a joint
/// ```
pub fn tree(dimension: Dimension) -> FrameDescription {
    let space = f64::from(u8::from(dimension == Dimension::Space));
    let nodes = [
        [0.0, 0.0, 0.0],
        [0.4, 0.05, 0.1],
        [0.8, 0.0, 0.2],
        [1.3, 0.1, 0.1],
        [1.7, 0.3, 0.0],
        [0.9, 0.35, 0.1],
        [1.1, 0.6, 0.3],
        [1.1, 0.6, 0.3],
        [1.4, 0.8, 0.5],
    ]
    .map(|[x, y, z]| [x, y, z * space])
    .to_vec();
    let beams = vec![
        beam(0, 1, 0),
        beam(1, 2, 0),
        beam(2, 3, 1),
        beam(3, 4, 1),
        beam(2, 5, 2),
        beam(5, 6, 2),
        beam(7, 8, 1),
    ];
    let mut frame = plain(dimension, nodes, beams);
    frame.sections.push(steel(Shape::Tube { outer_diameter_m: 0.05, thickness_m: 0.002 }));
    frame.sections.push(steel(Shape::Rectangle { width_m: 0.03, height_m: 0.02 }));
    frame.elements.extend([
        lump(3, 2.0, [0.01; 3]),
        lump(5, 1.0, [0.002, 0.003, 0.004]),
        hanger(0, 1, 2e3),
        hanger(4, 1, 2e3),
    ]);
    let directions = 0..dimension.per_node();
    frame.elements.extend(directions.map(|direction| joint([6, 7], Some(direction), 1e5)));
    frame.elements.push(joint([6, 8], None, 3e4));
    frame
}
