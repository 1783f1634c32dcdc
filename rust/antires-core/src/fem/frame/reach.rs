//! Moves of nodes: which follow when beams get longer, and how far they go.

use super::Frame;
use super::description::norm;
use crate::error::{Argument, Error, Result};
use crate::fem::parameters::Reach;

/// What must be left of a beam's length while a node moves.
const LEFT: f64 = 0.01;

impl Frame {
    /// The nodes that move when the beams `group` get longer while the node `pivot` stays, each with the node
    /// it is reached from.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for what [`Frame::downstream`] refuses, a group that is not reached from the
    /// pivot, or one that lies in a loop, which cannot close when only some of its beams get longer.
    pub fn reach(&self, group: &[usize], pivot: usize) -> Result<Vec<Reach>> {
        let moving = self.downstream(group, pivot)?;
        let parts = self.description();
        let mut edges: Vec<([usize; 2], bool)> = (parts.beams.iter().enumerate())
            .map(|(i, beam)| (beam.nodes, group.contains(&i)))
            .collect();
        edges.extend(
            parts
                .node_springs
                .iter()
                .map(|spring| (spring.nodes, false)),
        );
        edges.retain(|(nodes, _)| {
            nodes
                .iter()
                .all(|n| *n == pivot || moving.binary_search(n).is_ok())
        });
        // Nodes of one carrier move alike. The carrier of a far end is itself.
        let mut carrier: Vec<Option<usize>> = vec![None; parts.nodes_m.len()];
        carrier[pivot] = Some(pivot);
        let mut way: Vec<Reach> = Vec::new();
        let mut stretching = vec![false; edges.len()];
        let mut pending = vec![pivot];
        while let Some(from) = pending.pop() {
            for (edge, (nodes, stretched)) in edges.iter().enumerate() {
                if !nodes.contains(&from) {
                    continue;
                }
                let node = nodes[usize::from(nodes[0] == from)];
                if carrier[node].is_none() {
                    carrier[node] = if *stretched {
                        Some(node)
                    } else {
                        carrier[from]
                    };
                    stretching[edge] = *stretched;
                    way.push(Reach {
                        node,
                        from,
                        stretched: *stretched,
                    });
                    pending.push(node);
                }
            }
        }
        for (edge, ([a, b], stretched)) in edges.iter().enumerate() {
            if *stretched != stretching[edge] || (!stretched && carrier[*a] != carrier[*b]) {
                return Err(Error::input(
                    "elements",
                    format!("a group in a loop, which nodes {a} and {b} close"),
                    "elements outside loops, all reached from the pivot",
                )
                .remedy(
                    "Move nodes by position instead, so that all members of the loop follow.",
                ));
            }
        }
        Ok(way)
    }

    pub(super) fn shift(&mut self, direction: &[f64; 3], distance_m: f64, nodes: &[usize]) {
        for &node in nodes {
            for (x, n) in self.description.nodes_m[node].iter_mut().zip(direction) {
                *x += distance_m * n;
            }
        }
    }

    pub(super) fn stretch(&mut self, way: &[Reach], factor: f64) {
        let before = self.description.nodes_m.clone();
        for step in way {
            let now = self.description.nodes_m[step.from];
            let [near, far] = [step.from, step.node].map(|node| before[node]);
            let factor = if step.stretched { factor } else { 1.0 };
            self.description.nodes_m[step.node] =
                std::array::from_fn(|i| now[i] + factor * (far[i] - near[i]));
        }
    }

    /// Length of the shortest beam (m).
    pub fn shortest_m(&self) -> f64 {
        let parts = self.description();
        let lengths = parts.beams.iter().map(|beam| parts.length_m(beam.nodes));
        lengths.fold(f64::INFINITY, f64::min)
    }

    /// Checks that no beam shrinks to nothing while `nodes` move by `low` to `high` metres.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] naming the first beam that does.
    pub fn check_way(
        &self,
        direction: [f64; 3],
        nodes: &[usize],
        low: f64,
        high: f64,
    ) -> Result<()> {
        let parts = self.description();
        for (i, beam) in parts.beams.iter().enumerate() {
            let [first, last] = beam.nodes.map(|node| nodes.contains(&node));
            if first == last {
                continue;
            }
            let along = parts.vector_m(beam.nodes);
            let sign = if last { 1.0 } else { -1.0 };
            // Where the moving end is nearest to the other.
            let towards: f64 = (0..3)
                .map(|axis| sign * direction[axis] * along[axis])
                .sum();
            let at = (-towards).clamp(low, high);
            let left = norm(std::array::from_fn(|axis| {
                along[axis] + sign * at * direction[axis]
            }));
            if left < LEFT * norm(along) {
                return Err(Error::input(
                    Argument::from("elements").item(i),
                    format!("an element of length {left:e} m at a shift of {at} m"),
                    "a hundredth of its length or more",
                )
                .remedy("Narrow the bounds of the position."));
            }
        }
        Ok(())
    }
}
