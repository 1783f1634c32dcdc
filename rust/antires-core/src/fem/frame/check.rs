//! The checks of a description: every part is one that a frame can be made of.

use super::description::{Beam, FrameDescription, NodeSpring, PARALLEL, cross, norm};
use crate::error::{Argument, Error, Result};

/// Shortest element, relative to the extent of the frame, that still has a direction.
const SHORTEST: f64 = 1e-9;

impl FrameDescription {
    /// Checks every part; the messages name it as the Python face calls it.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] naming the first part that cannot be used.
    pub fn check(&self) -> Result<()> {
        self.check_nodes()?;
        for (i, section) in self.sections.iter().enumerate() {
            section.check(&Argument::from("sections").item(i))?;
        }
        self.check_beams()?;
        for (i, mass) in self.point_masses.iter().enumerate() {
            let name = Argument::from("point_masses").item(i);
            self.check_node(&name, mass.node)?;
            check_amount(&name, "kg", mass.mass_kg)?;
            for inertia in mass.inertia_kg_m2 {
                check_amount(&name, "kg·m²", inertia)?;
            }
        }
        for (i, spring) in self.ground_springs.iter().enumerate() {
            let name = Argument::from("ground_springs").item(i);
            self.check_node(&name, spring.node)?;
            self.check_direction(&name, spring.direction)?;
            check_amount(&name, "N/m", spring.stiffness_n_per_m)?;
        }
        for (i, spring) in self.node_springs.iter().enumerate() {
            self.check_node_spring(&Argument::from("node_springs").item(i), spring)?;
        }
        for (i, &(node, direction)) in self.fixed.iter().enumerate() {
            let name = Argument::from("fixed").item(i);
            self.check_node(&name, node)?;
            self.check_direction(&name, direction)?;
        }
        Ok(())
    }

    /// Largest distance along an axis between two nodes (m).
    fn extent_m(&self) -> f64 {
        (0..3)
            .map(|axis| {
                let along = || self.nodes_m.iter().map(|x| x[axis]);
                along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    }

    fn check_nodes(&self) -> Result<()> {
        if self.nodes_m.is_empty() || self.beams.is_empty() {
            let (what, wanted) = if self.nodes_m.is_empty() {
                ("nodes_m", "at least two nodes")
            } else {
                ("elements", "at least one element")
            };
            return Err(Error::input(what, "none", wanted)
                .remedy("A frame is at least one beam between two nodes."));
        }
        for (i, node) in self.nodes_m.iter().enumerate() {
            if let Some(x) = node.iter().find(|x| !x.is_finite()) {
                return Err(Error::input(
                    Argument::from("nodes_m").item(i),
                    format!("{x} m"),
                    "finite coordinates",
                )
                .remedy("Correct the coordinates of that node, in m."));
            }
        }
        Ok(())
    }

    fn check_beams(&self) -> Result<()> {
        let shortest = SHORTEST * self.extent_m();
        for (i, beam) in self.beams.iter().enumerate() {
            let name = Argument::from("elements").item(i);
            self.check_pair(&name, beam.nodes)?;
            if beam.section >= self.sections.len() {
                return Err(Error::input(
                    name,
                    format!("section {}", beam.section),
                    format!("a section below {}", self.sections.len()),
                )
                .remedy("Sections are counted from 0, in the order in which they are given."));
            }
            let length = self.length_m(beam.nodes);
            if length <= shortest {
                return Err(Error::input(
                    name,
                    format!(
                        "an element of length {length:e} m between nodes {} and {}",
                        beam.nodes[0], beam.nodes[1]
                    ),
                    "a length above zero",
                )
                .remedy("Join coincident nodes by node_springs, or make them one node."));
            }
            if let Some(reference) = beam.reference {
                self.check_reference(i, beam, reference)?;
            }
        }
        let mut pairs: Vec<([usize; 2], usize)> = self
            .beams
            .iter()
            .enumerate()
            .map(|(i, beam)| {
                let [a, b] = beam.nodes;
                ([a.min(b), a.max(b)], i)
            })
            .collect();
        pairs.sort_unstable();
        for pair in pairs.windows(2) {
            if pair[0].0 == pair[1].0 {
                let [a, b] = pair[0].0;
                return Err(Error::input(
                    Argument::from("elements").item(pair[1].1),
                    format!("nodes {a} and {b} again, after elements[{}]", pair[0].1),
                    "each pair of nodes joined once",
                )
                .remedy("Describe two beams side by side by one Section with their sums."));
            }
        }
        Ok(())
    }

    fn check_reference(&self, index: usize, beam: &Beam, reference: [f64; 3]) -> Result<()> {
        let along = self.vector_m(beam.nodes);
        let across = cross(along, reference);
        let scale = norm(along) * norm(reference);
        if scale.is_finite() && norm(across) > PARALLEL * scale {
            return Ok(());
        }
        Err(Error::input(
            Argument::from("orientation").item(index),
            format!("{reference:?}, along its element"),
            "a direction across the element",
        )
        .remedy("It tells where the section's z axis points; leave it out for the default."))
    }

    fn check_node_spring(&self, name: &Argument, spring: &NodeSpring) -> Result<()> {
        self.check_pair(name, spring.nodes)?;
        check_amount(name, "N/m", spring.stiffness_n_per_m)?;
        let apart = self.length_m(spring.nodes) > SHORTEST * self.extent_m();
        let [a, b] = spring.nodes;
        match spring.direction {
            None if !apart => Err(Error::input(
                name,
                format!("no direction, at the coincident nodes {a} and {b}"),
                "the direction of a spring between coincident nodes",
            )
            .remedy("Say in which direction it acts, such as 'v'.")),
            // It would resist a rotation of the whole structure: a hidden support.
            Some(direction) if apart && direction < self.dimension.axes() => Err(Error::input(
                name,
                format!("a direction, between the nodes {a} and {b} at different places"),
                "no direction, for a spring along the line between them",
            )
            .remedy("Only a spring along that line leaves rigid motions free.")),
            Some(direction) => self.check_direction(name, direction),
            None => Ok(()),
        }
    }

    fn check_pair(&self, name: &Argument, nodes: [usize; 2]) -> Result<()> {
        for node in nodes {
            self.check_node(name, node)?;
        }
        if nodes[0] == nodes[1] {
            return Err(Error::input(
                name,
                format!("node {} at both ends", nodes[0]),
                "two different nodes",
            )
            .remedy("Join it to another node, or leave it out."));
        }
        Ok(())
    }

    pub(super) fn check_node(&self, name: &Argument, node: usize) -> Result<()> {
        if node < self.nodes_m.len() {
            return Ok(());
        }
        Err(Error::input(
            name,
            format!("node {node}"),
            format!("a zero-based node in 0..{}", self.nodes_m.len() - 1),
        )
        .remedy("Nodes are counted from 0, in the order of nodes_m."))
    }

    fn check_direction(&self, name: &Argument, direction: usize) -> Result<()> {
        if direction < self.dimension.per_node() {
            return Ok(());
        }
        Err(Error::input(
            name,
            format!("direction {direction}"),
            format!("a direction below {}", self.dimension.per_node()),
        )
        .remedy("Directions are counted from 0: translations, then rotations."))
    }
}

fn check_amount(name: &Argument, unit: &str, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(Error::input(
        name,
        format!("{value} {unit}"),
        "a finite value of at least 0",
    )
    .remedy("Leave it out where there is none."))
}
