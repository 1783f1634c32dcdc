//! What stays the same while the parameters of a model change: which dofs are joined, and the ordering that
//! makes a band of K and M.

use faer::MatRef;

use crate::fem::model::Model;
use crate::linalg::ordering::reverse_cuthill_mckee;

/// Below this many dofs one dense eigenproblem costs less than the factors and the Krylov space.
const FEWEST_DOFS: usize = 40;

/// Widest half-bandwidth, as a fraction of the dofs, for which the band pays.
const WIDEST_BAND: f64 = 0.25;

/// Ordering of the dofs and bandwidth of every K and M of one model.
#[derive(Debug, Clone)]
pub struct Structure {
    order: Vec<usize>,
    place: Vec<usize>,
    half: usize,
}

impl Structure {
    /// Structure of `n` dofs joined by `entries` (row, column). An entry of K or M outside them, at any
    /// later time, would be lost.
    #[must_use]
    pub fn new(n: usize, entries: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut neighbours = vec![Vec::new(); n];
        for (i, j) in entries.filter(|(i, j)| i != j) {
            neighbours[i].push(j);
            neighbours[j].push(i);
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        let order = reverse_cuthill_mckee(&neighbours);
        let mut place = vec![0; n];
        for (new, &old) in order.iter().enumerate() {
            place[old] = new;
        }
        let reach = |i: usize| neighbours[i].iter().map(move |&j| (i, j));
        let half = (0..n)
            .flat_map(reach)
            .map(|(i, j)| place[i].abs_diff(place[j]))
            .max()
            .unwrap_or(0);
        Self { order, place, half }
    }

    /// Structure of a model at whatever values its parameters take.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let n = model.n_dof();
        let terms = model.stiffness_terms().iter().chain(model.mass_terms());
        let listed = terms.flat_map(|t| t.entries().iter().map(|e| (e.0 as usize, e.1 as usize)));
        let present = entries(model.stiffness()).chain(entries(model.mass()));
        Self::new(n, present.chain(listed))
    }

    /// Whether the band route pays.
    #[must_use]
    pub fn is_slender(&self) -> bool {
        let n = self.order.len();
        n >= FEWEST_DOFS && self.half as f64 <= WIDEST_BAND * n as f64
    }

    /// Number of dofs.
    #[must_use]
    pub fn n_dof(&self) -> usize {
        self.order.len()
    }

    /// Number of diagonals below the main one.
    #[must_use]
    pub fn half(&self) -> usize {
        self.half
    }

    /// Dof in row `row` of the band.
    #[must_use]
    pub fn dof(&self, row: usize) -> usize {
        self.order[row]
    }

    /// Row of a dof in the band.
    #[must_use]
    pub fn row(&self, dof: usize) -> usize {
        self.place[dof]
    }
}

fn entries(a: MatRef<'_, f64>) -> impl Iterator<Item = (usize, usize)> {
    (0..a.ncols()).flat_map(move |j| {
        (j..a.nrows())
            .filter(move |&i| a[(i, j)] != 0.0)
            .map(move |i| (i, j))
    })
}
