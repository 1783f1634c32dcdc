//! Laws of every frame: symmetry, rigid motions, total mass, independence of the order of nodes.

use antires_core::fem::frame::elements::{Dimension, FrameDescription};
use antires_core::fem::model::Model;
use antires_core::linalg::sparse::SparseMatrix;
use antires_core::modal::modes::AllModes;
use faer::Mat;
use nalgebra::Vector3;

use super::build::{each, model, tree, without};

const BOTH: [Dimension; 2] = [Dimension::Plane, Dimension::Space];

/// Rigid motions of a frame as columns: translations, then rotations about the origin.
pub fn rigid_motions(model: &Model) -> Mat<f64> {
    let frame = model.frame().unwrap();
    let dimension = frame.description().dimension;
    let axes = dimension.axes();
    Mat::from_fn(model.n_dof(), dimension.per_node(), |dof, motion| {
        let (node, direction) = frame.dofs().node_and_direction(dof);
        if motion < axes {
            return f64::from(u8::from(motion == direction));
        }
        let axis = if axes == 2 { 2 } else { motion - 3 };
        let mut about = Vector3::zeros();
        about[axis] = 1.0;
        let x = Vector3::from(frame.description().nodes_m[node]);
        if direction < axes {
            about.cross(&x)[direction]
        } else {
            f64::from(u8::from(direction - axes == if axes == 2 { 0 } else { axis }))
        }
    })
}

fn free(dimension: Dimension) -> FrameDescription {
    without(tree(dimension), "ground_springs")
}

#[test]
fn matrices_are_symmetric_to_the_last_bit_and_rigid_motions_free() {
    for dimension in BOTH {
        let model = model(free(dimension));
        for matrix in [model.stiffness(), model.mass()].map(SparseMatrix::to_dense) {
            for j in 0..model.n_dof() {
                for i in 0..j {
                    assert_eq!(matrix[(i, j)], matrix[(j, i)]);
                }
            }
        }
        let forces = model.stiffness().to_dense() * rigid_motions(&model);
        let scale = model.stiffness().norm_max();
        assert!(forces.norm_max() < 1e-14 * scale, "{:e}", forces.norm_max() / scale);
        let zero = AllModes::of(&model).unwrap().finite();
        let rigid = zero.freq_hz.iter().filter(|f| **f < 1e-2).count();
        assert_eq!(rigid, dimension.per_node(), "{:?}", &zero.freq_hz[..8]);
    }
}

#[test]
fn rigid_motions_carry_the_mass_and_inertia_of_the_structure() {
    for dimension in BOTH {
        let model = model(free(dimension));
        let parts = model.frame().unwrap().description();
        let lumps = || each!(parts.elements.iter(), PointMass);
        let mut mass_kg: f64 = lumps().map(|m| m.mass_kg).sum();
        let mut about_z: f64 = lumps()
            .map(|m| {
                let [x, y, _] = parts.nodes_m[m.node];
                m.inertia_kg_m2[2] + m.mass_kg * (x * x + y * y)
            })
            .sum();
        for beam in parts.beams() {
            let [a, b] = beam.nodes.map(|n| Vector3::from(parts.nodes_m[n]));
            let m = parts.sections[beam.section].rigidity().mass_kg_per_m * (b - a).norm();
            mass_kg += m;
            // Thin rod: m/3 (a² + a·b + b²), across the axis; in space the section adds its own.
            let flat = |v: Vector3<f64>| Vector3::new(v.x, v.y, 0.0);
            let (a, b) = (flat(a), flat(b));
            about_z += m / 3.0 * (a.dot(&a) + a.dot(&b) + b.dot(&b));
        }
        let motions = rigid_motions(&model);
        let total = motions.transpose() * model.mass().to_dense() * &motions;
        for axis in 0..dimension.axes() {
            assert!((total[(axis, axis)] / mass_kg - 1.0).abs() < 1e-13);
        }
        let last = dimension.per_node() - 1;
        // The polar inertia of slender tubes is a matter of 1e-4.
        let slack = if dimension == Dimension::Plane { 1e-13 } else { 1e-3 };
        assert!((total[(last, last)] / about_z - 1.0).abs() < slack);
    }
}

#[test]
fn the_order_of_an_elements_nodes_changes_nothing() {
    for dimension in BOTH {
        let straight = model(tree(dimension));
        let mut description = tree(dimension);
        for beam in each!(description.elements.iter_mut(), Beam) {
            beam.nodes.reverse();
        }
        let reversed = model(description);
        for (a, b) in [(straight.stiffness(), reversed.stiffness()), (straight.mass(), reversed.mass())] {
            assert!((a.to_dense() - b.to_dense()).norm_max() < 1e-14 * a.norm_max());
        }
    }
}

#[test]
fn a_plane_frame_is_the_space_frame_held_in_its_plane() {
    let plane = model(tree(Dimension::Plane));
    let mut description = tree(Dimension::Plane);
    description.dimension = Dimension::Space;
    // The joint springs of the plane act on u, v and theta, which is rz in space.
    for spring in each!(description.elements.iter_mut(), NodeSpring) {
        spring.direction = spring.direction.map(|d| if d == 2 { 5 } else { d });
    }
    let nodes_m = description.nodes_m.clone();
    // The reference direction of the plane: its local y lies in the plane.
    for beam in each!(description.elements.iter_mut(), Beam) {
        let [a, b] = beam.nodes.map(|n| Vector3::from(nodes_m[n]));
        beam.reference = Some(Vector3::z().cross(&(b - a)).into());
    }
    for node in 0..description.nodes_m.len() {
        description.fixed.extend([2, 3, 4].map(|direction| (node, direction)));
    }
    let space = model(description);
    for (a, b) in [(plane.stiffness(), space.stiffness()), (plane.mass(), space.mass())] {
        assert!((a.to_dense() - b.to_dense()).norm_max() < 1e-14 * a.norm_max());
    }
}
