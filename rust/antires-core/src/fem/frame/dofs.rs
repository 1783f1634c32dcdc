//! Degrees of freedom of a frame: three a node in the plane, six in space, fixed ones left out.
//!
//! ```text
//! plane   u, v            θ about z             named  u v theta
//! space   u, v, w         θx, θy, θz            named  u v w rx ry rz
//! ```
//!
//! Free dofs are numbered node by node in this order.

use crate::error::{Argument, Error, Result};

/// Whether a frame lies in the plane or in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// In the plane x-y: u, v, θ a node.
    Plane,
    /// In space: six dofs a node.
    Space,
}

impl Dimension {
    /// Names of a node's dofs, in order; a *direction* is an index into them.
    pub fn directions(self) -> &'static [&'static str] {
        match self {
            Self::Plane => &["u", "v", "theta"],
            Self::Space => &["u", "v", "w", "rx", "ry", "rz"],
        }
    }

    /// Dofs of a node.
    pub fn per_node(self) -> usize {
        self.directions().len()
    }

    /// Coordinates of a node: the first directions are translations along them.
    pub fn axes(self) -> usize {
        match self {
            Self::Plane => 2,
            Self::Space => 3,
        }
    }

    /// The direction of a name.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a node has no such dof.
    pub fn direction(self, argument: &Argument, name: &str) -> Result<usize> {
        let names = self.directions();
        names.iter().position(|n| *n == name).ok_or_else(|| {
            Error::input(
                argument,
                format!("the direction '{name}'"),
                format!("one of {}", names.join(", ")),
            )
            .remedy("The letters are those of the node's dofs: translations, then rotations.")
        })
    }
}

/// From node and direction to the number of the free dof, and back.
#[derive(Debug, Clone)]
pub struct DofMap {
    dimension: Dimension,
    numbers: Vec<Option<usize>>,
    slots: Vec<usize>,
}

impl DofMap {
    /// Numbers the dofs of `n_nodes` nodes, `fixed` (node, direction) left out.
    pub fn new(dimension: Dimension, n_nodes: usize, fixed: &[(usize, usize)]) -> Self {
        let per_node = dimension.per_node();
        let mut free = vec![true; n_nodes * per_node];
        for &(node, direction) in fixed {
            free[node * per_node + direction] = false;
        }
        let slots: Vec<usize> = (0..free.len()).filter(|&slot| free[slot]).collect();
        let mut numbers = vec![None; free.len()];
        for (number, &slot) in slots.iter().enumerate() {
            numbers[slot] = Some(number);
        }
        Self {
            dimension,
            numbers,
            slots,
        }
    }

    /// Number of free dofs.
    pub fn n_free(&self) -> usize {
        self.slots.len()
    }

    /// Number of a dof, none when it is fixed.
    pub fn number(&self, node: usize, direction: usize) -> Option<usize> {
        self.numbers[node * self.dimension.per_node() + direction]
    }

    /// Node and direction of the free dof `number`.
    pub fn node_and_direction(&self, number: usize) -> (usize, usize) {
        let slot = self.slots[number];
        let per_node = self.dimension.per_node();
        (slot / per_node, slot % per_node)
    }

    /// Numbers of `COUNT` dofs of each of two nodes, `COUNT` · 2 = `N`, from the first direction on.
    pub(super) fn pair<const N: usize>(&self, nodes: [usize; 2]) -> [Option<usize>; N] {
        let half = N / 2;
        std::array::from_fn(|i| self.number(nodes[i / half], i % half))
    }
}
