//! What hangs together: the parts of a frame, and the nodes downstream of a pivot.

use super::Frame;
use crate::error::{Error, Result};

impl Frame {
    /// For each node the number of its part; nodes of one part are joined by beams or springs.
    pub fn parts(&self) -> Vec<usize> {
        let mut part = vec![usize::MAX; self.description().nodes_m.len()];
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
        let parts = self.description();
        parts.check_node(&"pivot".into(), pivot)?;
        if let Some(&beam) = group.iter().find(|&&beam| beam >= parts.beams.len()) {
            return Err(Error::input(
                "elements",
                format!("element {beam}"),
                format!("a zero-based element in 0..{}", parts.beams.len() - 1),
            )
            .remedy("Elements are counted from 0, in the order in which they are given."));
        }
        let touches = |beam: usize| parts.beams[beam].nodes.contains(&pivot);
        if !group.iter().any(|&beam| touches(beam)) {
            return Err(Error::input(
                "pivot",
                format!("node {pivot}, which no element of the group touches"),
                "an end of the group",
            )
            .remedy("Name the node at which the group joins the rest of the frame."));
        }
        let neighbours = self.neighbours();
        let mut turning = vec![false; parts.nodes_m.len()];
        turning[pivot] = true; // a wall for the flood
        for &beam in group {
            for node in parts.beams[beam].nodes {
                if !turning[node] {
                    flood(&neighbours, node, |node| {
                        !std::mem::replace(&mut turning[node], true)
                    });
                }
            }
        }
        turning[pivot] = false;
        let other = (0..parts.beams.len()).find(|beam| {
            !group.contains(beam)
                && touches(*beam)
                && parts.beams[*beam].nodes.iter().any(|&node| turning[node])
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
        let parts = self.description();
        let mut neighbours = vec![Vec::new(); parts.nodes_m.len()];
        let beams = parts.beams.iter().map(|beam| beam.nodes);
        let springs = parts.node_springs.iter().map(|spring| spring.nodes);
        for [a, b] in beams.chain(springs) {
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
