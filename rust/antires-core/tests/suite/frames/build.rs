//! Frames that the tests share.

use antires_core::fem::frame::Frame;
use antires_core::fem::frame::description::{
    Beam, FrameDescription, GroundSpring, NodeSpring, PointMass,
};
use antires_core::fem::frame::dofs::Dimension;
use antires_core::fem::model::Model;
use antires_core::fem::section::{Section, Shape, Shear};

pub fn steel(shape: Shape) -> Section {
    Section {
        shape,
        youngs_modulus_pa: 2.1e11,
        density_kg_per_m3: 7850.0,
        poisson: 0.3,
        shear: Shear::Rigid,
    }
}

pub fn tube() -> Section {
    steel(Shape::Tube {
        outer_diameter_m: 0.038,
        thickness_m: 0.0015,
    })
}

pub fn beam(a: usize, b: usize, section: usize) -> Beam {
    Beam {
        nodes: [a, b],
        section,
        reference: None,
    }
}

pub fn plain(dimension: Dimension, nodes_m: Vec<[f64; 3]>, beams: Vec<Beam>) -> FrameDescription {
    FrameDescription {
        dimension,
        nodes_m,
        beams,
        sections: vec![tube()],
        point_masses: vec![],
        ground_springs: vec![],
        node_springs: vec![],
        fixed: vec![],
    }
}

/// A straight beam of `n` elements from the origin to `end`.
pub fn line(dimension: Dimension, n: usize, end: [f64; 3], section: Section) -> FrameDescription {
    let nodes = (0..=n)
        .map(|i| end.map(|x| x * i as f64 / n as f64))
        .collect();
    let mut frame = plain(
        dimension,
        nodes,
        (0..n).map(|i| beam(i, i + 1, 0)).collect(),
    );
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
    frame.sections.push(steel(Shape::Tube {
        outer_diameter_m: 0.05,
        thickness_m: 0.002,
    }));
    frame.sections.push(steel(Shape::Rectangle {
        width_m: 0.03,
        height_m: 0.02,
    }));
    frame.point_masses = vec![
        PointMass {
            node: 3,
            mass_kg: 2.0,
            inertia_kg_m2: [0.01; 3],
        },
        PointMass {
            node: 5,
            mass_kg: 1.0,
            inertia_kg_m2: [0.002, 0.003, 0.004],
        },
    ];
    frame.ground_springs = [0, 4]
        .map(|node| GroundSpring {
            node,
            direction: 1,
            stiffness_n_per_m: 2e3,
        })
        .to_vec();
    for direction in 0..dimension.per_node() {
        frame.node_springs.push(NodeSpring {
            nodes: [6, 7],
            direction: Some(direction),
            stiffness_n_per_m: 1e5,
        });
    }
    frame.node_springs.push(NodeSpring {
        nodes: [6, 8],
        direction: None,
        stiffness_n_per_m: 3e4,
    });
    frame
}
