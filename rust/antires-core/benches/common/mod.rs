//! Models that the benches share.
#![allow(dead_code, missing_docs, clippy::missing_panics_doc)]

use antires_core::fem::frame::Frame;
use antires_core::fem::frame::elements::{
    Beam, Dimension, Element, FrameDescription, GroundSpring, PointMass,
};
use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::fem::parameters::{Parameter, Quantity};
use antires_core::fem::section::{Section, Shape, Shear};

/// The eight masses of the paper.
pub fn chain8() -> Model {
    let mut masses = [0.4194; 8];
    masses[0] = 0.5593;
    mass_spring_chain(&masses, &[56.7e3; 7], 0.0, 0.0).unwrap()
}

/// A free chain of `n` masses without symmetry.
pub fn chain(n: usize) -> Model {
    let wave = |i: usize, step: f64| 1.0 + 0.3 * (step * i as f64).sin();
    let masses: Vec<f64> = (0..n).map(|i| 0.5 * wave(i, 1.7)).collect();
    let springs: Vec<f64> = (1..n).map(|i| 5e4 * wave(i, 0.9)).collect();
    mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap()
}

/// A frame like the exhaust system of the paper: 47 beams and 48 nodes in the plane (144 dofs), five lumps, on
/// soft springs.
pub fn exhaust_like() -> Model {
    let beam = |(a, b)| Element::from(Beam::new([a, b], usize::from(a > 20)));
    let tube = |thickness_m: f64| Section {
        shape: Shape::Tube { outer_diameter_m: 0.038, thickness_m },
        youngs_modulus_pa: 2.07e11,
        density_kg_per_m3: 7850.0,
        poisson: 0.3,
        shear: Shear::Rigid,
    };
    // A curved pipe of 43 beams, and a branch of 4.
    let pipe = |i: usize| {
        let along = i as f64 / 43.0;
        [2.3 * along, 0.2 * (4.0 * along).sin(), 0.0]
    };
    let [x, y, _] = pipe(15);
    let branch = (1..=4).map(|i| [x + 0.01 * f64::from(i), y - 0.05 * f64::from(i), 0.0]);
    let along_branch = [(15, 44), (44, 45), (45, 46), (46, 47)];
    let lump = |(node, mass_kg): (usize, f64)| {
        Element::PointMass(PointMass { node, mass_kg, inertia_kg_m2: [0.0, 0.0, 0.004 * mass_kg] })
    };
    let hanger = |node: usize| {
        [0, 1].map(|direction| {
            Element::GroundSpring(GroundSpring { node, direction, stiffness_n_per_m: 800.0 })
        })
    };
    let beams = (0..43).map(|i| (i, i + 1)).chain(along_branch).map(beam);
    let lumps = [(5, 0.8), (14, 2.1), (25, 3.0), (36, 1.2), (47, 0.7)].map(lump);
    let hangers = [0, 21, 43].into_iter().flat_map(hanger);
    let frame = Frame::new(FrameDescription {
        dimension: Dimension::Plane,
        nodes_m: (0..=43).map(pipe).chain(branch).collect(),
        sections: vec![tube(0.0015), tube(0.0012)],
        elements: beams.chain(lumps).chain(hangers).collect(),
        fixed: vec![],
    });
    Model::from_frame(frame.unwrap()).unwrap()
}

/// Transverse dofs of `count` nodes along the pipe.
pub fn sensors(count: usize) -> Vec<usize> {
    (0..count).map(|i| 3 * (i * 43 / count) + 1).collect()
}

/// A stiffness reduction of each of these elements.
pub fn reductions(elements: std::ops::Range<usize>) -> Vec<Parameter> {
    elements
        .map(|element| Parameter { quantity: Quantity::StiffnessReduction, terms: vec![element] })
        .collect()
}
