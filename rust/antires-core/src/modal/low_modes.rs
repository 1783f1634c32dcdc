//! All modes of a model up to a limit: frequencies, shapes, and the adjoint solutions for their derivatives.
//!
//! Where factors of K − xM are cheap it is solved by [`ReducedModes`](super::reduced::ReducedModes), where a count of the modes
//! by inertia proves that none is missing; all else, and what that leaves open, by the dense
//! [`SymmetricSolver`](crate::linalg::symmetric::SymmetricSolver).

use super::nelson::{self, Adjoint};
use super::solved::Solved;
use crate::error::Result;

/// Eigenvalues this near to one another, relatively, count as one that is repeated: their shapes are then a
/// matter of rounding.
const REPEATED: f64 = 1e-8;

/// Modes up to a limit, with the memory to find them again.
#[derive(Debug, Clone, Default)]
pub struct LowModes {
    n: usize,
    lambda: Vec<f64>,
    /// Shapes by dof, one after the other.
    shapes: Vec<f64>,
    zero: f64,
}

impl LowModes {
    /// Finds all modes of K φ = λ M φ with λ up to `limit`; from `start`, a dof that the modes looked for
    /// move, that is quickest.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn find(&mut self, solved: &mut Solved<'_>, limit: f64, start: usize) -> Result<()> {
        self.n = solved.n_dof();
        if solved.is_reducible() {
            let reduced = solved.reduced();
            if reduced.solve(start, limit, true) {
                reduced.modes(&mut self.lambda, &mut self.shapes);
                self.zero = reduced.zero();
                return Ok(());
            }
        }
        let solver = solved.dense()?;
        let all = solver.eigenvalues();
        let count = all.partition_point(|&l| l <= limit);
        self.lambda.clear();
        self.lambda.extend_from_slice(&all[..count]);
        self.shapes.clear();
        for r in 0..count {
            self.shapes
                .extend((0..self.n).map(|dof| solver.vectors()[(dof, r)]));
        }
        self.zero = 16.0 * solver.uncertainty(0.0);
        Ok(())
    }

    /// Eigenvalues λ = ω², ascending.
    #[must_use]
    pub fn eigenvalues(&self) -> &[f64] {
        &self.lambda
    }

    /// Mass-normalised shape of mode `r`, one entry a dof.
    #[must_use]
    pub fn shape(&self, r: usize) -> &[f64] {
        &self.shapes[r * self.n..(r + 1) * self.n]
    }

    /// The shapes that belong to the eigenvalue of mode `r`, one after the other: more than one where it is
    /// repeated.
    #[must_use]
    pub fn space(&self, r: usize) -> &[f64] {
        let same = |a: usize, b: usize| {
            (self.lambda[b] - self.lambda[a]).abs() <= REPEATED * self.lambda[b].abs()
        };
        let (mut first, mut last) = (r, r);
        while first > 0 && same(first - 1, first) {
            first -= 1;
        }
        while last + 1 < self.lambda.len() && same(last, last + 1) {
            last += 1;
        }
        &self.shapes[first * self.n..(last + 1) * self.n]
    }

    /// Eigenvalues up to this are zero at working precision: rigid-body modes.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Solves (K − λM) z = g with zᵀMφ = 0 for mode `r` and a slope `g` with gᵀφ = 0, see [`nelson`]; `solved`
    /// are the matrices whose modes these are.
    ///
    /// Not for a repeated mode, whose shape has no derivative.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn adjoint(
        &self,
        solved: &mut Solved<'_>,
        r: usize,
        g: &[f64],
        z: &mut Vec<f64>,
    ) -> Result<()> {
        if solved.is_reducible() && solved.dense_in_hand().is_none() {
            let mode = (self.lambda[r], self.shape(r));
            if nelson::by_factors(solved.reduced().matrices(), mode, g, z) == Adjoint::Solved {
                return Ok(());
            }
        }
        // The modes are in one order on both routes.
        nelson::by_all_modes(solved.dense()?, r, g, z);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::solved::Solutions;
    use super::super::structure::Structure;
    use super::*;
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::model::Model;
    use crate::linalg::sparse::SparseMatrix;
    use faer::Mat;
    use std::sync::Arc;

    /// A free chain of 50 masses without symmetry.
    fn chain() -> Model {
        let wave = |i: usize, a: f64| 1.0 + 0.3 * (a * i as f64).sin();
        let masses: Vec<f64> = (0..50).map(|i| 0.5 * wave(i, 1.7)).collect();
        let springs: Vec<f64> = (1..50).map(|i| 5e4 * wave(i, 0.9)).collect();
        mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap()
    }

    /// Memory for the band route.
    fn slender(model: &Model) -> Solutions {
        let structure = Structure::of(model);
        assert!(structure.is_reducible());
        Solutions::new(&Arc::new(structure))
    }

    /// Memory for the dense one: every dof counts as joined to every other.
    fn full(model: &Model) -> Solutions {
        let pattern = SparseMatrix::full(model.stiffness().to_dense().as_ref());
        let structure = Structure::new(pattern.pattern(), |_| true);
        assert!(!structure.is_reducible());
        Solutions::new(&Arc::new(structure))
    }

    fn low(solved: &mut Solved<'_>, limit: f64) -> LowModes {
        let mut modes = LowModes::default();
        modes.find(solved, limit, 7).unwrap();
        modes
    }

    #[test]
    fn both_routes_give_one_answer() {
        let model = chain();
        let (k, m) = (model.stiffness(), model.mass());
        let (mut for_band, mut for_dense) = (slender(&model), full(&model));
        let (mut banded, mut solved) = (for_band.of(k, m), for_dense.of(k, m));
        let (band, dense) = (low(&mut banded, 3e4), low(&mut solved, 3e4));
        assert!(banded.dense_in_hand().is_none() && solved.dense_in_hand().is_some());
        let count = band.eigenvalues().len();
        assert!(count > 8 && count == dense.eigenvalues().len(), "{count}");
        assert!(band.eigenvalues()[0] <= band.zero() && dense.eigenvalues()[0] <= dense.zero());
        let (mut by_band, mut densely) = (Vec::new(), Vec::new());
        for r in 1..count {
            let (a, b) = (band.eigenvalues()[r], dense.eigenvalues()[r]);
            assert!(a > band.zero() && (a / b - 1.0).abs() < 1e-10, "{a} {b}");
            let sign = (band.shape(r)[0] * dense.shape(r)[0]).signum();
            for (p, q) in band.shape(r).iter().zip(dense.shape(r)) {
                assert!((p - sign * q).abs() < 1e-8, "{p} {q}");
            }
            // A slope without part along the shape.
            let mut g = vec![0.0; 50];
            (g[3], g[20]) = (band.shape(r)[20], -band.shape(r)[3]);
            band.adjoint(&mut banded, r, &g, &mut by_band).unwrap();
            dense.adjoint(&mut solved, r, &g, &mut densely).unwrap();
            assert!(banded.dense_in_hand().is_none(), "the band settled it");
            let size = densely.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
            for (y, z) in by_band.iter().zip(&densely) {
                assert!((y - z).abs() < 1e-7 * size, "{y} {z}");
            }
        }
    }

    #[test]
    fn modes_that_the_start_does_not_move_are_found_and_repeated_ones_belong_together() {
        // Two equal chains beside each other: every mode twice, and the load moves one of each two.
        let one = chain();
        let twice = |a: &SparseMatrix| {
            Mat::from_fn(100, 100, |i, j| {
                if i / 50 == j / 50 {
                    a.get(i % 50, j % 50)
                } else {
                    0.0
                }
            })
        };
        let model = Model::new(twice(one.stiffness()), twice(one.mass()), vec![], vec![]).unwrap();
        let of = |model: &Model| {
            let mut memory = slender(model);
            let mut solved = memory.of(model.stiffness(), model.mass());
            let modes = low(&mut solved, 2e4);
            assert!(solved.dense_in_hand().is_none());
            modes
        };
        let (single, double) = (of(&one), of(&model));
        assert_eq!(double.eigenvalues().len(), 2 * single.eigenvalues().len());
        for r in 2..double.eigenvalues().len() {
            let ratio = double.eigenvalues()[r] / single.eigenvalues()[r / 2];
            assert!((ratio - 1.0).abs() < 1e-10, "{ratio}");
            assert_eq!(double.space(r).len(), 200);
            assert_eq!(single.space(r / 2).len(), 50);
        }
    }
}
