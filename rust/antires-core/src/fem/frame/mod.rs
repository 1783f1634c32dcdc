//! Frames of beams, lumped masses and springs, in the plane or in space.
//!
//! ```text
//! K(p) = Σ_e s_e(p) K_e(p) + Σ springs      M(p) = Σ_e r_e(p) M_e(p) + Σ lumped masses
//! ```
//!
//! K_e and M_e depend on the section and on the coordinates of both ends; s_e and r_e are the factors
//! of `StiffnessReduction`, `StiffnessFactor` and `MassFactor`. Fixed dofs are left out.
//!
//! Stiffness terms in order: beams, springs to ground, springs between nodes. Mass terms: beams,
//! lumped masses.

mod check;
pub mod description;
pub mod dofs;
mod parameters;
mod reach;
pub mod reform;
mod terms;
mod topology;

use description::FrameDescription;
use dofs::DofMap;

use crate::error::{Error, Result};

pub use super::parameters::{Angle, Property, Reach, Scale};

/// A checked frame with its dof numbering.
#[derive(Debug, Clone)]
pub struct Frame {
    description: FrameDescription,
    dofs: DofMap,
    /// Reference direction of each beam; it turns with the beam.
    references: Vec<[f64; 3]>,
    /// What earlier updates left of each beam's stiffness and mass.
    stiffness_factors: Vec<f64>,
    mass_factors: Vec<f64>,
}

impl Frame {
    /// Checks a description and numbers its free dofs.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for anything [`FrameDescription::check`] refuses, when every dof is
    /// fixed, or when a free dof has neither stiffness nor mass.
    pub fn new(description: FrameDescription) -> Result<Self> {
        description.check()?;
        let dofs = DofMap::new(
            description.dimension,
            description.nodes_m.len(),
            &description.fixed,
        );
        if dofs.n_free() == 0 {
            return Err(Error::input("fixed", "all dofs", "at least one free dof")
                .remedy("Leave free what is to move."));
        }
        let n = description.beams.len();
        let references = description
            .beams
            .iter()
            .map(|beam| {
                beam.reference
                    .unwrap_or_else(|| description.default_reference(beam.nodes))
            })
            .collect();
        let frame = Self {
            description,
            dofs,
            references,
            stiffness_factors: vec![1.0; n],
            mass_factors: vec![1.0; n],
        };
        frame.check_every_dof_is_held()?;
        Ok(frame)
    }

    /// What the frame is made of.
    pub fn description(&self) -> &FrameDescription {
        &self.description
    }

    /// Numbering of the free dofs.
    pub fn dofs(&self) -> &DofMap {
        &self.dofs
    }

    /// Number of the free dof `direction` of `node`.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is no such dof, or when it is fixed.
    pub fn dof(&self, node: usize, direction: &str) -> Result<usize> {
        self.description.check_node(&"node".into(), node)?;
        let index = self
            .description
            .dimension
            .direction(&"direction".into(), direction)?;
        self.dofs.number(node, index).ok_or_else(|| {
            Error::input(
                "direction",
                format!("'{direction}' of node {node}, which is fixed"),
                "a free dof",
            )
            .remedy(
                "A fixed dof does not move: it has no response, and a force on it does nothing.",
            )
        })
    }

    fn check_every_dof_is_held(&self) -> Result<()> {
        let mut held = vec![false; self.dofs.n_free()];
        let (stiffness, mass) = self.terms();
        for term in stiffness.iter().chain(&mass) {
            for &(row, col, value) in term.entries() {
                held[row as usize] |= row == col && value > 0.0;
            }
        }
        let Some(loose) = held.iter().position(|held| !held) else {
            return Ok(());
        };
        let (node, direction) = self.dofs.node_and_direction(loose);
        let name = self.description.dimension.directions()[direction];
        Err(Error::input(
            "nodes_m",
            format!("node {node}, whose dof '{name}' has neither stiffness nor mass"),
            "every free dof held by an element, a spring or a mass",
        )
        .remedy("Join the node by an element, or fix the dof."))
    }
}
