//! Forming the terms of a frame from its present sections and coordinates.

use nalgebra::Matrix1;

use super::Frame;
use super::description::NodeSpring;
use super::dofs::Dimension;
use crate::fem::elements::{
    along_line, pair, plane_mass, plane_stiffness, space_mass, space_stiffness,
};
use crate::fem::term::{Side, Term};

impl Frame {
    /// Number of stiffness terms: beams, springs to ground, springs between nodes.
    pub fn n_stiffness_terms(&self) -> usize {
        let parts = &self.description;
        parts.beams.len() + parts.ground_springs.len() + parts.node_springs.len()
    }

    /// Number of mass terms: beams, lumped masses.
    pub fn n_mass_terms(&self) -> usize {
        self.description.beams.len() + self.description.point_masses.len()
    }

    /// All stiffness and all mass terms.
    pub fn terms(&self) -> (Vec<Term>, Vec<Term>) {
        (
            (0..self.n_stiffness_terms())
                .map(|t| self.stiffness_term(t))
                .collect(),
            (0..self.n_mass_terms())
                .map(|t| self.mass_term(t))
                .collect(),
        )
    }

    /// Stiffness term `index` as it now is.
    pub fn stiffness_term(&self, index: usize) -> Term {
        let mut term = Term::default();
        self.form_stiffness(index, &mut term);
        term
    }

    /// Mass term `index` as it now is.
    pub fn mass_term(&self, index: usize) -> Term {
        let mut term = Term::default();
        self.form_mass(index, &mut term);
        term
    }

    /// Forms stiffness term `index` into `term`.
    pub(super) fn form_stiffness(&self, index: usize, term: &mut Term) {
        let parts = &self.description;
        let Some(after_beams) = index.checked_sub(parts.beams.len()) else {
            self.form_beam(index, Side::Stiffness, term);
            return;
        };
        let Some(after_ground) = after_beams.checked_sub(parts.ground_springs.len()) else {
            let spring = &parts.ground_springs[after_beams];
            let dof = self.dofs.number(spring.node, spring.direction);
            term.set_element(&[dof], &Matrix1::new(spring.stiffness_n_per_m));
            return;
        };
        self.form_node_spring(&parts.node_springs[after_ground], term);
    }

    /// Forms mass term `index` into `term`.
    pub(super) fn form_mass(&self, index: usize, term: &mut Term) {
        let parts = &self.description;
        let Some(after_beams) = index.checked_sub(parts.beams.len()) else {
            self.form_beam(index, Side::Mass, term);
            return;
        };
        let lump = &parts.point_masses[after_beams];
        let (m, [ix, iy, iz]) = (lump.mass_kg, lump.inertia_kg_m2);
        match parts.dimension {
            Dimension::Plane => self.form_lump(lump.node, [m, m, iz], term),
            Dimension::Space => self.form_lump(lump.node, [m, m, m, ix, iy, iz], term),
        }
    }

    fn form_lump<const N: usize>(&self, node: usize, diagonal: [f64; N], term: &mut Term) {
        let dofs: [Option<usize>; N] = std::array::from_fn(|i| self.dofs.number(node, i));
        term.set_diagonal(&dofs, &diagonal);
    }

    fn form_beam(&self, index: usize, side: Side, term: &mut Term) {
        let parts = &self.description;
        let beam = &parts.beams[index];
        let [a, b] = beam.nodes.map(|node| parts.nodes_m[node]);
        let section = parts.sections[beam.section].rigidity();
        let factor = match side {
            Side::Stiffness => self.stiffness_factors[index],
            Side::Mass => self.mass_factors[index],
        };
        match parts.dimension {
            Dimension::Plane => {
                let (a, b) = ([a[0], a[1]], [b[0], b[1]]);
                let matrix = match side {
                    Side::Stiffness => plane_stiffness(a, b, &section),
                    Side::Mass => plane_mass(a, b, &section),
                };
                term.set_element(&self.dofs.pair::<6>(beam.nodes), &(matrix * factor));
            }
            Dimension::Space => {
                let up = self.references[index];
                let matrix = match side {
                    Side::Stiffness => space_stiffness(a, b, up, &section),
                    Side::Mass => space_mass(a, b, up, &section),
                };
                term.set_element(&self.dofs.pair::<12>(beam.nodes), &(matrix * factor));
            }
        }
    }

    fn form_node_spring(&self, spring: &NodeSpring, term: &mut Term) {
        let k = spring.stiffness_n_per_m;
        if let Some(direction) = spring.direction {
            let dofs = spring.nodes.map(|node| self.dofs.number(node, direction));
            term.set_element(&dofs, &pair(k));
            return;
        }
        let length = self.description.length_m(spring.nodes);
        let along = self.description.vector_m(spring.nodes).map(|x| x / length);
        match self.description.dimension {
            Dimension::Plane => {
                let dofs = self.dofs.pair::<4>(spring.nodes);
                term.set_element(&dofs, &along_line::<4>(&along, k));
            }
            Dimension::Space => {
                let dofs = self.dofs.pair::<6>(spring.nodes);
                term.set_element(&dofs, &along_line::<6>(&along, k));
            }
        }
    }
}
