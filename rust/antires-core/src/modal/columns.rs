//! Columns i and k of (K − xM)⁻¹ from band matrices or from all modes, for roots on the matrices themselves
//! and for their sensitivities.
//!
//! ```text
//! (K − xM) u = e_k,  (K − xM) w = e_i        H_ik = e_iᵀu,  dH_ik/dx = wᵀMu
//! ```
//!
//! At a zero of H_ik, u without its entry i and w without its entry k are the null vectors of the deleted
//! pencil. The band factors are formed without pivoting, so their growth is asked each time.

use super::polish::Step;
use super::reduced::ReducedModes;
use crate::linalg::banded::LARGEST_GROWTH;
use crate::linalg::symmetric::SymmetricSolver;

/// u and w in the order and the scale of the band, and M u.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    u: Vec<f64>,
    w: Vec<f64>,
    mu: Vec<f64>,
}

impl ReducedModes {
    /// Newton's step for a root of H_ik at `x`, by rows `i` and `k` of the band.
    pub(super) fn newton_step(&mut self, (i, k): (usize, usize), x: f64) -> Option<Step> {
        let slope = self.solve_columns(i, k, x)?;
        Some(Step {
            length: -self.columns.u[i] / slope,
            ulp: self.ulp_shift(x, slope),
        })
    }

    /// How far one ulp of random sign in each entry of K and M moves the root at `x`, from u and w there.
    fn ulp_shift(&self, x: f64, slope: f64) -> f64 {
        let Columns { u, w, .. } = &self.columns;
        let moved = self.stiffness.squared_form(w, u) + x * x * self.mass.squared_form(w, u);
        f64::EPSILON * moved.sqrt() / slope.abs()
    }

    /// Columns i and k of (K − xM)⁻¹ by dof, each up to a factor, into `left` and `right`; returns leftᵀ M
    /// right.
    pub fn columns(
        &mut self,
        (i, k): (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Option<f64> {
        let slope = self.solve_columns(self.structure.row(i), self.structure.row(k), x)?;
        for (out, column) in [(left, &self.columns.w), (right, &self.columns.u)] {
            out.clear();
            out.resize(self.mass.n(), 0.0);
            for (row, scale) in self.scale.iter().enumerate() {
                out[self.structure.dof(row)] = scale * column[row];
            }
        }
        Some(slope)
    }

    /// Solves for u and w at rows `i` and `k` of the band; returns wᵀMu.
    fn solve_columns(&mut self, i: usize, k: usize, x: f64) -> Option<f64> {
        self.work.combine(&self.stiffness, -x, &self.mass);
        let (_, growth) = self.work.factorize();
        if growth > LARGEST_GROWTH {
            return None;
        }
        let padded = self.mass.n() + self.mass.half();
        let Columns { u, w, mu } = &mut self.columns;
        for (column, load) in [(&mut *u, k), (&mut *w, i)] {
            column.clear();
            column.resize(padded, 0.0);
            column[load] = 1.0;
            self.work.solve(column);
        }
        mu.resize(padded, 0.0);
        self.mass.multiply(u, mu);
        let slope: f64 = w.iter().zip(mu.iter()).map(|(a, b)| a * b).sum();
        // A dof without mass has no scale.
        slope.is_finite().then_some(slope)
    }
}

/// The columns from all modes: h_i = Σ φ_r φ_ir / (λ_r − x) + Σ ψ ψ_i; returns h_iᵀ M h_k.
pub(super) fn modal_columns(
    modes: &SymmetricSolver,
    (i, k): (usize, usize),
    x: f64,
    left: &mut Vec<f64>,
    right: &mut Vec<f64>,
) -> f64 {
    let (lambda, phi) = (modes.eigenvalues(), modes.vectors());
    let n = phi.nrows();
    for column in [&mut *left, &mut *right] {
        column.clear();
        column.resize(n, 0.0);
    }
    let mut slope = 0.0;
    for r in 0..phi.ncols() {
        let stretch = lambda.get(r).map_or(1.0, |l| (l - x).recip());
        let (at_i, at_k) = (phi[(i, r)] * stretch, phi[(k, r)] * stretch);
        for dof in 0..n {
            left[dof] += at_i * phi[(dof, r)];
            right[dof] += at_k * phi[(dof, r)];
        }
        if r < lambda.len() {
            slope += at_i * at_k;
        }
    }
    slope
}
