//! What no parameter changes: which dofs are joined, ordering and form of the factors of K − xM.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::fem::model::Model;
use crate::fem::parameters::Parameter;
use crate::fem::term::Term;
use crate::linalg::banded::reverse_cuthill_mckee;
use crate::linalg::factors::Symbolic;
use crate::linalg::sparse::{Pattern, SparseMatrix};

/// Below this many dofs one dense eigenproblem costs less than the factors and the Krylov space.
const FEWEST_DOFS: usize = 40;

/// Widest half-bandwidth, as a fraction of the dofs, for which the band pays.
const WIDEST_BAND: f64 = 0.25;

/// Most dofs for which a slender structure is put into a band without asking whether sparse factors are quicker.
const SMALL: usize = 500;

/// Most dofs for which a band is tried.
const MOST_BAND: usize = 20_000;

/// Cost of an operation of the sparse factors in operations of the band.
const SPARSE_COST: f64 = 1.5;

/// Cost of the sparse factors, as a part of n³, from which on they do not pay for few dofs.
const DENSE_COST: f64 = 0.05;

/// Most dofs for which the dense solvers may be asked.
pub const MOST_DENSE: usize = 2000;

/// Dense matrices that all modes take at a time.
const DENSE_MATRICES: usize = 6;

/// Vectors of a Krylov space for which there must be room.
const KRYLOV_VECTORS: usize = 200;

/// Most dofs for which the degrees of the determinants are kept.
const MOST_DEGREES: usize = 64;

/// How K and M are held to be factorized.
#[derive(Debug, Clone)]
pub enum Layout {
    /// Not at all: the dense solvers are quicker.
    Dense,
    /// In a band: place in the model's matrices, row and column of each entry of its lower half.
    Band(Vec<(u32, u32, u32)>),
    /// Sparse.
    Sparse(SparseLayout),
}

/// The analysis of a sparse structure.
#[derive(Debug, Clone)]
pub struct SparseLayout {
    /// Ordering and blocks.
    pub symbolic: Arc<Symbolic>,
    /// For each place of the ordered pattern that in the model's matrices.
    pub origin: Vec<u32>,
}

/// Ordering of the dofs and form of every K and M of one model.
#[derive(Debug, Clone)]
pub struct Structure {
    order: Vec<usize>,
    place: Vec<usize>,
    /// Number of diagonals of a band below the main one.
    pub half: usize,
    /// How K and M are held.
    pub layout: Layout,
    /// For each row the number of the part of the structure, joined in itself and to no other, that it is in.
    parts: Vec<u32>,
    /// Degree of each determinant, of small structures.
    degrees: Option<Vec<u16>>,
}

impl Structure {
    /// Structure of matrices on `pattern`, those of its places that `kept` tells. An entry of K or M elsewhere,
    /// at any later time, would be lost.
    pub fn new(pattern: &Pattern, kept: impl Fn(usize) -> bool) -> Self {
        Self::ordered(pattern, &kept).divided(pattern, kept)
    }

    fn ordered(pattern: &Pattern, kept: &impl Fn(usize) -> bool) -> Self {
        let n = pattern.n();
        let entries = |j: usize| pattern.places(j).filter(|&at| kept(at));
        let row = |at: usize| pattern.rows()[at];
        let band = (n <= MOST_BAND).then(|| {
            let others = |j: usize| entries(j).map(row).filter(move |&i| i as usize != j);
            let neighbours: Vec<Vec<usize>> =
                (0..n).map(|j| others(j).map(|i| i as usize).collect()).collect();
            let order = reverse_cuthill_mckee(&neighbours);
            let place = inverse(&order);
            let reach = |j: usize| neighbours[j].iter().map(move |&i| (i, j));
            let distances = (0..n).flat_map(reach).map(|(i, j)| place[i].abs_diff(place[j]));
            let half = distances.max().unwrap_or(0);
            (order, place, half)
        });
        let slender = |half: usize| half as f64 <= WIDEST_BAND * n as f64;
        let by_band = |(order, place, half): (Vec<usize>, Vec<usize>, usize)| {
            let lower = |j: usize| {
                let place = &place;
                let moved = entries(j).map(move |at| (at, place[row(at) as usize], place[j]));
                moved.filter(|(_, i, j)| i >= j)
            };
            let all = (0..n).flat_map(lower);
            let layout = all.map(|(at, i, j)| (at as u32, i as u32, j as u32));
            let layout = Layout::Band(layout.collect());
            Self::laid_out(order, half, layout)
        };
        let dense = || Self::laid_out((0..n).collect(), 0, Layout::Dense);
        match band {
            _ if n < FEWEST_DOFS => return dense(),
            Some(band) if n <= SMALL && slender(band.2) => return by_band(band),
            _ => {}
        }
        let (reduced, kept_places) = pattern.kept(kept);
        let Some(symbolic) = Symbolic::new(&reduced) else {
            return dense();
        };
        let cost = SPARSE_COST * symbolic.flops;
        if n <= SMALL && cost > DENSE_COST * (n as f64).powi(3) {
            return dense();
        }
        match band {
            Some(band) if slender(band.2) && n as f64 * (band.2 as f64).powi(2) <= cost => by_band(band),
            _ => {
                let order = symbolic.order.clone();
                let origin = symbolic.origin.iter();
                let origin = origin.map(|&at| kept_places[at] as u32).collect();
                let symbolic = Arc::new(symbolic);
                Self::laid_out(order, 0, Layout::Sparse(SparseLayout { symbolic, origin }))
            }
        }
    }

    fn laid_out(order: Vec<usize>, half: usize, layout: Layout) -> Self {
        Self { place: inverse(&order), order, half, layout, parts: Vec::new(), degrees: None }
    }

    /// The same with its parts, on those places of `pattern` that `kept` tells.
    fn divided(mut self, pattern: &Pattern, kept: impl Fn(usize) -> bool) -> Self {
        self.parts = vec![u32::MAX; pattern.n()];
        let (mut count, mut pending) = (0, Vec::new());
        for seed in 0..pattern.n() {
            if self.parts[self.place[seed]] != u32::MAX {
                continue;
            }
            self.parts[self.place[seed]] = count;
            pending.push(seed);
            while let Some(dof) = pending.pop() {
                for (at, &other) in pattern.places(dof).zip(pattern.column(dof)) {
                    let part = &mut self.parts[self.place[other as usize]];
                    if *part == u32::MAX && kept(at) {
                        *part = count;
                        pending.push(other as usize);
                    }
                }
            }
            count += 1;
        }
        self
    }

    /// Structure of a model, which stays as it is.
    pub fn of(model: &Model) -> Self {
        Self::under(model, &[])
    }

    /// Structure of a model at whatever values its parameters take.
    pub fn under(model: &Model, parameters: &[Parameter]) -> Self {
        let (n, pattern) = (model.n_dof(), model.stiffness().pattern());
        let sides = || [(model.stiffness(), model.stiffness_terms()), (model.mass(), model.mass_terms())];
        // The zeros of an element may fill when its geometry changes.
        let structure = if n <= SMALL || parameters.iter().any(|p| p.quantity.forms_anew()) {
            Self::new(pattern, |_| true)
        } else {
            let mut kept = vec![false; pattern.n_places()];
            for ((matrix, terms), places) in sides().into_iter().zip(&*model.places()) {
                for (kept, value) in kept.iter_mut().zip(&matrix.values) {
                    *kept |= *value != 0.0;
                }
                for (t, term) in terms.iter().enumerate() {
                    for (entry, &at) in term.entries().iter().zip(places.of(t)) {
                        kept[at as usize] |= entry.2 != 0.0;
                    }
                }
            }
            Self::new(pattern, |at| kept[at])
        };
        if n > MOST_DEGREES {
            return structure;
        }
        let [stiffness, mass] = sides().map(|(matrix, terms)| joined(matrix, terms));
        Self { degrees: Some(degrees(n, &stiffness, &mass)), ..structure }
    }

    /// Whether there is room for K, M, the factors and the Krylov space, or for dense matrices.
    pub fn check_room(&self) -> Result<()> {
        let n = self.n_dof();
        let matrices = match &self.layout {
            Layout::Dense => n.saturating_mul(n).saturating_mul(DENSE_MATRICES),
            Layout::Band(_) => 3 * (n + self.half).saturating_mul(self.half + 2),
            Layout::Sparse(layout) => layout.symbolic.n_values() + 3 * layout.origin.len(),
        };
        let numbers = matrices.saturating_add(n.saturating_mul(KRYLOV_VECTORS));
        Error::check_memory(|| format!("a model of {n} dofs"), numbers)
    }

    /// Upper bound of the degree in x of det(K_ik − x M_ik): of the number of roots. None for large
    /// structures.
    pub fn degree(&self, i: usize, k: usize) -> Option<usize> {
        let degrees = self.degrees.as_ref()?;
        Some(usize::from(degrees[i * self.n_dof() + k]))
    }

    /// Whether the modes below a limit cost less than all of them.
    pub fn is_reducible(&self) -> bool {
        !matches!(self.layout, Layout::Dense)
    }

    /// Number of dofs.
    pub fn n_dof(&self) -> usize {
        self.order.len()
    }

    /// Number of the part that a row is in.
    pub fn part(&self, row: usize) -> u32 {
        self.parts[row]
    }

    /// Dof in row `row` of the ordering.
    pub fn dof(&self, row: usize) -> usize {
        self.order[row]
    }

    /// Row of a dof in the ordering.
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

/// Places of one matrix that parameters may fill.
fn joined(matrix: &SparseMatrix, terms: &[Term]) -> Vec<(usize, usize)> {
    let filled = matrix.entries().filter(|e| e.2 != 0.0);
    let listed = terms.iter().flat_map(Term::entries);
    let listed = listed.map(|e| (e.0 as usize, e.1 as usize));
    filled.map(|(i, j, _)| (i, j)).chain(listed).collect()
}

fn inverse(order: &[usize]) -> Vec<usize> {
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new;
    }
    place
}
