//! What a frame is made of.

use super::dofs::Dimension;
use crate::fem::section::Section;

/// Sine of the smallest angle between a beam and its reference direction.
pub(super) const PARALLEL: f64 = 1e-3;

/// A beam between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Its ends.
    pub nodes: [usize; 2],
    /// Index of its section.
    pub section: usize,
    /// Reference direction in space: the local y axis is the part of it across the beam. None: the
    /// global z axis, or the global x axis for beams along z.
    pub reference: Option<[f64; 3]>,
}

/// A lumped mass at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass {
    /// The node.
    pub node: usize,
    /// Mass (kg), for all translations.
    pub mass_kg: f64,
    /// Inertia about x, y, z (kg·m²); in the plane only z counts.
    pub inertia_kg_m2: [f64; 3],
}

/// A spring from one dof to ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundSpring {
    /// The node.
    pub node: usize,
    /// The direction, an index into [`Dimension::directions`].
    pub direction: usize,
    /// Stiffness (N/m, or N·m/rad for a rotation).
    pub stiffness_n_per_m: f64,
}

/// A spring between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeSpring {
    /// The nodes.
    pub nodes: [usize; 2],
    /// The dof whose relative motion it resists; none: along the line between the nodes.
    pub direction: Option<usize>,
    /// Stiffness (N/m, or N·m/rad for a rotation).
    pub stiffness_n_per_m: f64,
}

/// Everything a frame is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameDescription {
    /// Plane or space.
    pub dimension: Dimension,
    /// Coordinates (m); z is 0 in the plane.
    pub nodes_m: Vec<[f64; 3]>,
    /// Beams.
    pub beams: Vec<Beam>,
    /// Sections of the beams.
    pub sections: Vec<Section>,
    /// Lumped masses.
    pub point_masses: Vec<PointMass>,
    /// Springs to ground.
    pub ground_springs: Vec<GroundSpring>,
    /// Springs between nodes.
    pub node_springs: Vec<NodeSpring>,
    /// Fixed dofs (node, direction).
    pub fixed: Vec<(usize, usize)>,
}

impl FrameDescription {
    pub(super) fn vector_m(&self, nodes: [usize; 2]) -> [f64; 3] {
        let [a, b] = nodes.map(|node| self.nodes_m[node]);
        std::array::from_fn(|axis| b[axis] - a[axis])
    }

    pub(super) fn length_m(&self, nodes: [usize; 2]) -> f64 {
        norm(self.vector_m(nodes))
    }

    /// The reference direction of a beam that has none of its own: z, or x for beams along z.
    pub(super) fn default_reference(&self, nodes: [usize; 2]) -> [f64; 3] {
        let along = self.vector_m(nodes);
        let up = [0.0, 0.0, 1.0];
        if norm(cross(along, up)) > PARALLEL * norm(along) {
            up
        } else {
            [1.0, 0.0, 0.0]
        }
    }
}

pub(super) fn norm(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
