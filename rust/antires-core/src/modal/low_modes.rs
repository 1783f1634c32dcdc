//! All modes of a model up to a limit: frequencies, shapes, and what their derivatives need.
//!
//! A slender structure is solved by [`ReducedModes`], where a count of the modes by inertia proves that none
//! is missing; all else, and what that leaves open, by the dense [`SymmetricSolver`].
//!
//! The derivative of a function of a shape whose size it ignores, with slope g there (gᵀφ = 0), needs one
//! solution for each mode, whatever the number of parameters:
//!
//! ```text
//! (K − λM) dφ/dp = −(K' − λM' − λ'M) φ        differentiated K φ = λ M φ
//! (K − λM) z = g,  zᵀMφ = 0                   gᵀ dφ/dp = −zᵀ (K' − λM') φ
//! ```
//!
//! K − λM is singular. In band form it is solved with the row and the column of the largest entry of φ taken
//! out, as Nelson does; from all modes z = Σ φ_s (φ_sᵀg) / (λ_s − λ) over the others.
//!
//! Source: R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA J. 14 (1976) 1201-1205.

use std::sync::Arc;

use faer::MatRef;

use super::reduced::ReducedModes;
use super::structure::Structure;
use crate::error::Result;
use crate::linalg::banded::LARGEST_GROWTH;
use crate::linalg::symmetric::SymmetricSolver;

/// Eigenvalues this near to one another, relatively, count as one that is repeated: their shapes are then a
/// matter of rounding.
const REPEATED: f64 = 1e-8;

/// Modes up to a limit, with the memory to find them again.
pub struct LowModes {
    n: usize,
    reduced: Option<ReducedModes>,
    /// Made when first needed, with whether it holds the matrices last solved.
    dense: Option<(SymmetricSolver, bool)>,
    lambda: Vec<f64>,
    /// Shapes by dof, one after the other.
    shapes: Vec<f64>,
    zero: f64,
}

impl LowModes {
    /// Reserves the memory for the models of one structure.
    #[must_use]
    pub fn new(structure: &Arc<Structure>) -> Self {
        Self {
            n: structure.n_dof(),
            reduced: structure
                .is_slender()
                .then(|| ReducedModes::new(Arc::clone(structure))),
            dense: None,
            lambda: Vec::new(),
            shapes: Vec::new(),
            zero: 0.0,
        }
    }

    /// Finds all modes of K φ = λ M φ with λ up to `limit`; from `start`, a dof that the modes looked for
    /// move, the band route is quickest.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn solve(
        &mut self,
        (k, m): (MatRef<'_, f64>, MatRef<'_, f64>),
        limit: f64,
        start: usize,
    ) -> Result<()> {
        if let Some((_, current)) = &mut self.dense {
            *current = false;
        }
        if let Some(reduced) = &mut self.reduced {
            reduced.set_matrices(k, m);
            if reduced.solve(start, limit) {
                reduced.modes(&mut self.lambda, &mut self.shapes);
                self.zero = reduced.zero();
                return Ok(());
            }
        }
        self.solve_dense((k, m))?;
        let Some((solver, _)) = &self.dense else {
            return Ok(());
        };
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

    fn solve_dense(&mut self, (k, m): (MatRef<'_, f64>, MatRef<'_, f64>)) -> Result<()> {
        let (solver, current) = self
            .dense
            .get_or_insert_with(|| (SymmetricSolver::new(self.n), false));
        if !*current {
            solver.solve(k, m)?;
            *current = true;
        }
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

    /// Solves (K − λM) z = g with zᵀMφ = 0 for mode `r` and a slope `g` with gᵀφ = 0; the matrices are those
    /// last solved.
    ///
    /// Not for a repeated mode, whose shape has no derivative.
    ///
    /// # Errors
    /// Those of [`SymmetricSolver::solve`].
    pub fn adjoint(
        &mut self,
        matrices: (MatRef<'_, f64>, MatRef<'_, f64>),
        r: usize,
        g: &[f64],
        z: &mut Vec<f64>,
    ) -> Result<()> {
        let by_band = self.dense.as_ref().is_none_or(|(_, current)| !current);
        let (lambda, phi) = (self.lambda[r], &self.shapes[r * self.n..(r + 1) * self.n]);
        if let (true, Some(reduced)) = (by_band, &mut self.reduced)
            && reduced.pinned_solution(lambda, phi, g, z)
        {
            return Ok(());
        }
        self.solve_dense(matrices)?;
        z.clear();
        z.resize(self.n, 0.0);
        if let Some((solver, _)) = &self.dense {
            let (all, vectors) = (solver.eigenvalues(), solver.vectors());
            // The modes are in one order on both routes.
            for s in (0..self.n).filter(|&s| s != r) {
                let along: f64 = (0..self.n).map(|dof| vectors[(dof, s)] * g[dof]).sum();
                let stretch = all.get(s).map_or(1.0, |l| (l - all[r]).recip());
                for (dof, z) in z.iter_mut().enumerate() {
                    *z += along * stretch * vectors[(dof, s)];
                }
            }
        }
        Ok(())
    }
}

impl ReducedModes {
    /// The modes up to the limit of the last [`solve`](Self::solve), ascending, and their mass-normalised shapes
    /// by dof.
    pub(super) fn modes(&mut self, lambda: &mut Vec<f64>, shapes: &mut Vec<f64>) {
        let n = self.mass.n();
        // Vectors of those that the load excites stand before the hidden ones, where there are any.
        if self.hidden.is_empty() {
            self.weighted.clear();
            self.vectors.clear();
        }
        let mut found = Vec::new();
        for j in (0..self.found.len()).filter(|&j| self.found[j]) {
            if self.hidden.is_empty() {
                self.krylov.vector(j, &mut self.weighted, &mut self.vectors);
            }
            found.push(self.krylov.theta()[j].recip() - self.sigma);
        }
        found.extend(&self.hidden);
        let mut order: Vec<usize> = (0..found.len())
            .filter(|&j| found[j] <= self.limit)
            .collect();
        order.sort_by(|&a, &b| found[a].total_cmp(&found[b]));
        lambda.clear();
        shapes.clear();
        let stride = n + self.mass.half();
        for j in order {
            let value = found[j];
            lambda.push(if value.abs() <= self.zero { 0.0 } else { value });
            let vector = &self.vectors[j * stride..j * stride + n];
            let at = shapes.len();
            shapes.resize(at + n, 0.0);
            for (row, (v, scale)) in vector.iter().zip(&self.scale).enumerate() {
                shapes[at + self.structure.dof(row)] = v * scale;
            }
        }
    }

    /// z of (K − λM) z = g, M-orthogonal to `phi`, from the band matrix with one row and column taken out;
    /// false where rounding spoils its factors.
    fn pinned_solution(&mut self, lambda: f64, phi: &[f64], g: &[f64], z: &mut Vec<f64>) -> bool {
        let (n, half) = (self.mass.n(), self.mass.half());
        let by_row = |values: &[f64], times: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let rows = (0..n).map(|row| values[self.structure.dof(row)] * times(self.scale[row]));
            rows.chain(std::iter::repeat_n(0.0, half)).collect()
        };
        let shape = by_row(phi, &f64::recip);
        let mut solution = by_row(g, &|scale| scale);
        let largest = (0..n).fold(0, |at, row| {
            if shape[row].abs() > shape[at].abs() {
                row
            } else {
                at
            }
        });
        self.work.combine(&self.stiffness, -lambda, &self.mass);
        self.work.pin(largest);
        solution[largest] = 0.0;
        if self.work.factorize().1 > LARGEST_GROWTH {
            return false;
        }
        self.work.solve(&mut solution);
        let mut weighted = vec![0.0; n + half];
        self.mass.multiply(&shape, &mut weighted);
        let part: f64 = solution[..n]
            .iter()
            .zip(&weighted)
            .map(|(s, w)| s * w)
            .sum();
        z.clear();
        z.resize(n, 0.0);
        for row in 0..n {
            z[self.structure.dof(row)] = self.scale[row] * (solution[row] - part * shape[row]);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::model::Model;
    use faer::Mat;

    /// A free chain of 50 masses without symmetry.
    fn chain() -> Model {
        let wave = |i: usize, a: f64| 1.0 + 0.3 * (a * i as f64).sin();
        let masses: Vec<f64> = (0..50).map(|i| 0.5 * wave(i, 1.7)).collect();
        let springs: Vec<f64> = (1..50).map(|i| 5e4 * wave(i, 0.9)).collect();
        mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap()
    }

    fn low(model: &Model, slender: bool, limit: f64) -> LowModes {
        let mut modes = LowModes::new(&Arc::new(Structure::of(model)));
        assert!(modes.reduced.is_some());
        if !slender {
            modes.reduced = None;
        }
        let matrices = (model.stiffness(), model.mass());
        modes.solve(matrices, limit, 7).unwrap();
        assert_eq!(modes.dense.is_none(), slender);
        modes
    }

    #[test]
    fn both_routes_give_one_answer() {
        let model = chain();
        let matrices = (model.stiffness(), model.mass());
        let (mut band, mut dense) = (low(&model, true, 3e4), low(&model, false, 3e4));
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
            band.adjoint(matrices, r, &g, &mut by_band).unwrap();
            dense.adjoint(matrices, r, &g, &mut densely).unwrap();
            assert!(band.dense.is_none(), "the band settled it");
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
        let twice = |a: MatRef<'_, f64>| {
            Mat::from_fn(100, 100, |i, j| {
                if i / 50 == j / 50 {
                    a[(i % 50, j % 50)]
                } else {
                    0.0
                }
            })
        };
        let model = Model::new(twice(one.stiffness()), twice(one.mass()), vec![], vec![]).unwrap();
        let (single, double) = (low(&one, true, 2e4), low(&model, true, 2e4));
        assert_eq!(double.eigenvalues().len(), 2 * single.eigenvalues().len());
        for r in 2..double.eigenvalues().len() {
            let ratio = double.eigenvalues()[r] / single.eigenvalues()[r / 2];
            assert!((ratio - 1.0).abs() < 1e-10, "{ratio}");
            assert_eq!(double.space(r).len(), 200);
            assert_eq!(single.space(r / 2).len(), 50);
        }
    }
}
