//! What stays the same while the parameters of a model change: which dofs are joined, and the ordering that
//! makes a band of K and M.

use faer::MatRef;

use crate::fem::model::Model;
use crate::fem::term::Term;
use crate::linalg::ordering::reverse_cuthill_mckee;

/// Below this many dofs one dense eigenproblem costs less than the factors and the Krylov space.
const FEWEST_DOFS: usize = 40;

/// Widest half-bandwidth, as a fraction of the dofs, for which the band pays.
const WIDEST_BAND: f64 = 0.25;

/// Most dofs for which the degrees of the determinants are kept.
const MOST_DEGREES: usize = 64;

/// Ordering of the dofs and bandwidth of every K and M of one model.
#[derive(Debug, Clone)]
pub struct Structure {
    order: Vec<usize>,
    place: Vec<usize>,
    half: usize,
    /// Degree of each determinant, of small structures.
    degrees: Option<Vec<u16>>,
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
        Self {
            order,
            place,
            half,
            degrees: None,
        }
    }

    /// Structure of a model at whatever values its parameters take.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let n = model.n_dof();
        let of = |a, terms: &[Term]| -> Vec<(usize, usize)> {
            let listed = terms.iter().flat_map(Term::entries);
            let listed = listed.map(|e| (e.0 as usize, e.1 as usize));
            entries(a).chain(listed).collect()
        };
        let stiffness = of(model.stiffness(), model.stiffness_terms());
        let mass = of(model.mass(), model.mass_terms());
        let all = stiffness.iter().chain(&mass).copied();
        Self {
            degrees: (n <= MOST_DEGREES).then(|| degrees(n, &stiffness, &mass)),
            ..Self::new(n, all)
        }
    }

    /// Upper bound of the degree in x of det(K_ik − x M_ik): of the number of roots. None for large
    /// structures.
    #[must_use]
    pub fn degree(&self, i: usize, k: usize) -> Option<usize> {
        let degrees = self.degrees.as_ref()?;
        Some(usize::from(degrees[i * self.n_dof() + k]))
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

/// Each product in det(K_ik − x M_ik) takes a path from i to k and cycles beside it; a dof off the path gives
/// one power of x at most, a step along it none where only K joins the two dofs.
fn degrees(n: usize, stiffness: &[(usize, usize)], mass: &[(usize, usize)]) -> Vec<u16> {
    let mut cost = vec![u16::MAX; n * n];
    for (entries, price) in [(stiffness, 1), (mass, 0)] {
        for &(i, j) in entries {
            (cost[i * n + j], cost[j * n + i]) = (price, price);
        }
    }
    let mut degrees = Vec::with_capacity(n * n);
    for start in 0..n {
        // Steps through K alone from `start`, cheapest dof first.
        let mut steps = vec![u16::MAX; n];
        let mut open: Vec<usize> = (0..n).collect();
        steps[start] = 0;
        while let Some(at) = (0..open.len()).min_by_key(|&q| steps[open[q]]) {
            let dof = open.swap_remove(at);
            for &other in &open {
                let through = steps[dof].saturating_add(cost[dof * n + other]);
                steps[other] = steps[other].min(through);
            }
        }
        degrees.extend(steps.iter().map(|&s| (n as u16 - 1).saturating_sub(s)));
    }
    degrees
}

fn entries(a: MatRef<'_, f64>) -> impl Iterator<Item = (usize, usize)> {
    (0..a.ncols()).flat_map(move |j| {
        (j..a.nrows())
            .filter(move |&i| a[(i, j)] != 0.0)
            .map(move |i| (i, j))
    })
}
