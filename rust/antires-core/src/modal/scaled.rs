//! K and M in the order of their [`Structure`], scaled to one unit, and the factors of K − xM.
//!
//! ```text
//! K̃ = S P K Pᵀ S,   M̃ = S P M Pᵀ S        P the ordering of the [`Structure`], S diagonal
//! ```
//!
//! S holds powers of two that bring each diagonal entry of M near one; where a dof has no mass, or next to none,
//! that of K near the largest of the others. They round nothing, give translations and rotations one unit, and scale H_ik by a
//! factor, which moves no zero. A *row* is a place in the ordering.

use std::sync::Arc;

use super::structure::{Layout, Structure};
use crate::linalg::banded::Banded;
use crate::linalg::factors::{Factors, Form, Signs, SparseFactors};
use crate::linalg::sparse::SparseMatrix;

/// Least pivot of M, relative to its diagonal, for which all directions have a mass.
const LEAST_MASS: f64 = 1e-8;

/// K_jj / M_jj over that of the softer dofs from which on a dof has next to no mass.
const FAR_STIFFER: f64 = 1e8;

/// K̃ and M̃, with the memory for factors.
pub struct ScaledMatrices {
    /// The ordering.
    pub structure: Arc<Structure>,
    /// K̃.
    pub stiffness: Form,
    /// M̃.
    pub mass: Form,
    /// The diagonal of S.
    pub scale: Vec<f64>,
    /// The factors last made: there is memory for one matrix only.
    pub factors: Factors,
    /// c of K̃ + cM̃ that the factors are of, and what they tell of it.
    held: Option<(f64, Signs)>,
    largest_stiffness: f64,
    /// Where and of what modes were counted last, and what came out.
    counted: Option<((f64, Scope), Signs)>,
}

/// Whose modes count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// Those of all dofs.
    Whole,
    /// Those of the part of the structure that a row is in: a load there moves no other.
    PartOf(usize),
}

/// Two zero matrices of the form that a structure has, and memory for factors.
fn memory(structure: &Structure) -> (Form, Form, Factors) {
    if let Layout::Sparse(layout) = &structure.layout {
        let zero = SparseMatrix::new(Arc::clone(&layout.symbolic.pattern));
        let factors = SparseFactors::new(Arc::clone(&layout.symbolic));
        return (Form::Sparse(zero.clone()), Form::Sparse(zero.clone()), Factors::Sparse(zero, factors));
    }
    let zero = Banded::new(structure.n_dof(), structure.half);
    (Form::Band(zero.clone()), Form::Band(zero.clone()), Factors::Band(zero))
}

impl ScaledMatrices {
    /// Reserves the memory.
    pub fn new(structure: Arc<Structure>) -> Self {
        let (stiffness, mass, factors) = memory(&structure);
        Self {
            stiffness,
            mass,
            scale: Vec::new(),
            factors,
            held: None,
            largest_stiffness: 0.0,
            counted: None,
            structure,
        }
    }

    /// Takes K and M.
    pub fn set(&mut self, k: &SparseMatrix, m: &SparseMatrix) {
        self.set_scale(k, m);
        let (structure, scale) = (&self.structure, &self.scale);
        for (form, matrix) in [(&mut self.stiffness, k), (&mut self.mass, m)] {
            match (form, &structure.layout) {
                (Form::Band(band), Layout::Band(entries)) => {
                    band.clear();
                    for &(at, row, column) in entries {
                        let (row, column) = (row as usize, column as usize);
                        let value = matrix.values[at as usize] * scale[row] * scale[column];
                        band.set(row, column, value);
                    }
                }
                (Form::Sparse(form), Layout::Sparse(layout)) => {
                    let pattern = &layout.symbolic.pattern;
                    for column in 0..pattern.n() {
                        for at in pattern.places(column) {
                            let row = pattern.rows()[at] as usize;
                            let value = matrix.values[layout.origin[at] as usize];
                            form.values[at] = value * scale[row] * scale[column];
                        }
                    }
                }
                _ => {}
            }
        }
        self.largest_stiffness = self.stiffness.largest_diagonal();
        (self.counted, self.held) = (None, None);
    }

    fn set_scale(&mut self, k: &SparseMatrix, m: &SparseMatrix) {
        let n = self.structure.n_dof();
        let to_one = |value: f64| (-0.5 * value.log2()).round().exp2();
        let stiffest = self.stiffest(k, m);
        self.scale.clear();
        for row in 0..n {
            let dof = self.structure.dof(row);
            let (stiffness, mass) = (k.diagonal(dof), m.diagonal(dof));
            self.scale.push(if stiffness > stiffest * mass {
                to_one(stiffness / stiffest)
            } else if mass > 0.0 {
                to_one(mass)
            } else {
                1.0
            });
        }
    }

    /// Largest K_jj / M_jj of the dofs that have more than next to no mass, one where none has.
    fn stiffest(&self, k: &SparseMatrix, m: &SparseMatrix) -> f64 {
        let rate = |dof: usize| k.diagonal(dof) / m.diagonal(dof);
        let mut rates: Vec<f64> = (0..self.structure.n_dof())
            .filter(|&dof| m.diagonal(dof) > 0.0)
            .map(rate)
            .filter(|rate| *rate > 0.0)
            .collect();
        let largest = rates.iter().copied().fold(0.0, f64::max);
        let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
        if largest <= FAR_STIFFER * least {
            return if largest > 0.0 { largest } else { 1.0 };
        }
        let quarter = rates.len() / 4;
        let typical = *rates.select_nth_unstable_by(quarter, f64::total_cmp).1;
        let moving = rates.iter().copied().filter(|rate| *rate <= FAR_STIFFER * typical);
        moving.fold(0.0, f64::max)
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.mass.n()
    }

    /// Length of the vectors that [`solve`](Self::solve) takes: the rows and some zeros.
    pub fn stride(&self) -> usize {
        self.mass.n() + self.mass.padding()
    }

    /// Whether it is certain that all directions have a mass; of sparse matrices it is not asked.
    pub fn mass_is_definite(&mut self) -> bool {
        match (&mut self.factors, &self.mass) {
            (Factors::Band(factors), Form::Band(mass)) => {
                self.held = None;
                factors.clone_from(mass);
                factors.factorize_definite(LEAST_MASS)
            }
            _ => false,
        }
    }

    /// Number of eigenvalues below `x`, and by how much rounding may have shifted x in it.
    pub fn count_below(&mut self, x: f64, scope: Scope) -> (usize, f64) {
        let known = self.counted.filter(|(of, _)| *of == (x, scope));
        let signs = if let Some((_, signs)) = known {
            signs
        } else {
            let mut signs = self.hold(-x);
            if let Scope::PartOf(of) = scope {
                let part = |row| self.structure.part(row);
                signs.negative = self.factors.negative_in(|row| part(row) == part(of));
            }
            self.counted = Some(((x, scope), signs));
            signs
        };
        let error = f64::EPSILON * self.largest_stiffness * signs.growth.max(1.0);
        (signs.negative, error)
    }

    /// Factorizes K̃ + cM̃, unless the factors are those.
    fn hold(&mut self, c: f64) -> Signs {
        if let Some((_, signs)) = self.held.filter(|(of, _)| *of == c) {
            return signs;
        }
        let signs = self.factors.factorize(&self.stiffness, c, &self.mass, None);
        self.held = Some((c, signs));
        signs
    }

    /// Factorizes K̃ + σM̃; whether that is definite.
    pub fn shift(&mut self, sigma: f64) -> bool {
        let signs = self.hold(sigma);
        signs.negative == 0 && signs.growth.is_finite()
    }

    /// Factorizes K̃ − xM̃; returns the growth of the factors.
    pub fn factorize(&mut self, x: f64) -> f64 {
        self.hold(-x).growth
    }

    /// [`factorize`](Self::factorize) with row and column `row` taken out.
    pub fn factorize_without(&mut self, row: usize, x: f64) -> f64 {
        self.held = None;
        let (k, m) = (&self.stiffness, &self.mass);
        self.factors.factorize(k, -x, m, Some(row)).growth
    }

    /// Solves in place with the factors last made.
    pub fn solve(&self, column: &mut [f64]) {
        self.factors.solve(column);
    }

    /// Brings a vector by rows back to the dofs and their units.
    pub fn by_dof(&self, rows: &[f64], dofs: &mut [f64]) {
        for (row, (value, scale)) in rows.iter().zip(&self.scale).enumerate() {
            dofs[self.structure.dof(row)] = scale * value;
        }
    }
}
