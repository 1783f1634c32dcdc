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

pub mod elements;
mod parameters;

use crate::error::{Error, Result};
use crate::fem::term::{Side, Term};
use elements::{DofMap, FrameDescription, check_node};

pub use crate::fem::parameters::{Angle, Property, Reach, Scale};
pub use parameters::{Nominal, Reform};

/// A checked frame with its dof numbering.
#[derive(Debug, Clone)]
pub struct Frame {
    description: FrameDescription,
    dofs: DofMap,
    /// Numbers of the elements that make the terms of K, and of M.
    terms: [Vec<usize>; 2],
    /// Reference direction of each beam; it turns with the beam.
    references: Vec<[f64; 3]>,
}

impl Frame {
    /// Checks a description and numbers its free dofs.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for anything [`FrameDescription::check`] refuses, when every dof is
    /// fixed, or when a free dof has neither stiffness nor mass.
    pub fn new(mut description: FrameDescription) -> Result<Self> {
        description.sort();
        description.check()?;
        let nodes = description.nodes_m.len();
        let dofs = DofMap::new(description.dimension, nodes, &description.fixed);
        if dofs.n_free() == 0 {
            return Err(Error::input("fixed", "all dofs", "at least one free dof")
                .remedy("Leave free what is to move."));
        }
        let reference = |beam: &elements::Beam| {
            let default = || description.default_reference(beam.nodes);
            beam.reference.unwrap_or_else(default)
        };
        let frame = Self {
            references: description.beams().map(reference).collect(),
            terms: [Side::Stiffness, Side::Mass].map(|side| description.terms(side)),
            description,
            dofs,
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
        check_node(&"node".into(), node, self.description.nodes_m.len())?;
        let index = self.description.dimension.direction(&"direction".into(), direction)?;
        self.dofs.number(node, index).ok_or_else(|| {
            Error::input("direction", format!("'{direction}' of node {node}, which is fixed"), "a free dof")
                .remedy("A fixed dof does not move: it has no response, and a force on it does nothing.")
        })
    }

    fn check_every_dof_is_held(&self) -> Result<()> {
        let mut held = vec![false; self.dofs.n_free()];
        for term in [Side::Stiffness, Side::Mass].into_iter().flat_map(|side| self.terms(side)) {
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

    /// All terms of one matrix.
    pub fn terms(&self, side: Side) -> Vec<Term> {
        (0..self.terms[side as usize].len()).map(|index| self.term(side, index)).collect()
    }

    /// Term `index` of one matrix as it now is.
    pub fn term(&self, side: Side, index: usize) -> Term {
        let mut term = Term::default();
        self.form(side, index, &mut term);
        term
    }

    /// Forms a term of one matrix into `term`.
    fn form(&self, side: Side, index: usize, term: &mut Term) {
        let element = self.terms[side as usize][index];
        let up = self.references.get(element).copied().unwrap_or_default();
        self.description.form(element, side, &self.dofs, up, term);
    }

    /// Whether a term differs from that of `other`, formed from the same frame.
    fn differs(&self, other: &Self, side: Side, index: usize) -> bool {
        let element = self.terms[side as usize][index];
        self.description.differs(&other.description, element)
            // A turn about a beam's own axis moves no node.
            || self.references.get(element) != other.references.get(element)
    }

    /// For each node the number of its part; nodes of one part are joined by beams or springs.
    pub fn parts(&self) -> Vec<usize> {
        let mut part = vec![usize::MAX; self.description.nodes_m.len()];
        let neighbours = self.neighbours();
        let mut count = 0;
        for start in 0..part.len() {
            if part[start] == usize::MAX {
                flood(&neighbours, start, |node| {
                    let new = part[node] == usize::MAX;
                    part[node] = count;
                    new
                });
                count += 1;
            }
        }
        part
    }

    /// The nodes that turn with the beams `group` about the node `pivot`: those of the group and all
    /// downstream, reached without passing the pivot. The pivot itself stays.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when the group is empty, has a beam outside the frame, does not touch the pivot, or lies
    /// in a loop through it, so that turning it would tear or stretch other beams.
    pub fn downstream(&self, group: &[usize], pivot: usize) -> Result<Vec<usize>> {
        let beams: Vec<[usize; 2]> = self.description.beams().map(|beam| beam.nodes).collect();
        let n_nodes = self.description.nodes_m.len();
        check_node(&"pivot".into(), pivot, n_nodes)?;
        if let Some(&beam) = group.iter().find(|&&beam| beam >= beams.len()) {
            return Err(Error::input(
                "elements",
                format!("element {beam}"),
                format!("an element from 0 to {}", beams.len() - 1),
            )
            .remedy("Elements are counted from 0, in the order in which they are given."));
        }
        let touches = |beam: usize| beams[beam].contains(&pivot);
        if !group.iter().any(|&beam| touches(beam)) {
            return Err(Error::input(
                "pivot",
                format!("node {pivot}, which no element of the group touches"),
                "an end of the group",
            )
            .remedy("Name the node at which the group joins the rest of the frame."));
        }
        let neighbours = self.neighbours();
        let mut turning = vec![false; n_nodes];
        turning[pivot] = true; // a wall for the flood
        for &beam in group {
            for node in beams[beam] {
                if !turning[node] {
                    flood(&neighbours, node, |node| !std::mem::replace(&mut turning[node], true));
                }
            }
        }
        turning[pivot] = false;
        let other = (0..beams.len()).find(|beam| {
            !group.contains(beam) && touches(*beam) && beams[*beam].iter().any(|&node| turning[node])
        });
        if let Some(beam) = other {
            return Err(Error::input(
                "elements",
                format!("a group in a loop through node {pivot}, closed by element {beam}"),
                "a group that only the pivot joins to the rest",
            )
            .remedy("Add that element to the group, or choose another pivot."));
        }
        Ok((0..turning.len()).filter(|&node| turning[node]).collect())
    }

    /// The nodes joined to each node by a beam or a spring.
    fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut neighbours = vec![Vec::new(); self.description.nodes_m.len()];
        for (_, [a, b]) in self.description.joined() {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
        neighbours
    }
}

/// Visits `start` and all reached from it; `enter` marks a node and says whether it was new.
fn flood(neighbours: &[Vec<usize>], start: usize, mut enter: impl FnMut(usize) -> bool) {
    let mut pending = vec![start];
    while let Some(node) = pending.pop() {
        if enter(node) {
            pending.extend(&neighbours[node]);
        }
    }
}
