//! Columns i and k of (K − xM)⁻¹ from factors of K − xM, for roots on the matrices themselves
//! and for their sensitivities.
//!
//! ```text
//! (K − xM) u = e_k,  (K − xM) w = e_i        H_ik = e_iᵀu,  dH_ik/dx = wᵀMu
//! ```
//!
//! At a zero of H_ik, u without its entry i and w without its entry k are the null vectors of the deleted
//! pencil. The factors are formed without pivoting, so their growth is asked each time.

use super::scaled::ScaledMatrices;
use crate::linalg::banded::LARGEST_GROWTH;

/// u and w in the order and the scale of the factors, and M u.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    u: Vec<f64>,
    w: Vec<f64>,
    mu: Vec<f64>,
}

/// H_ik on the matrices at one x, in the scale of the matrices.
#[derive(Debug, Clone, Copy)]
pub struct ReceptanceAt {
    /// H_ik.
    pub value: f64,
    /// dH_ik/dx.
    pub slope: f64,
    /// How far one ulp of random sign in each entry of K and M moves a root at this x.
    pub ulp: f64,
}

impl Columns {
    /// H_ik at `x`; none where rounding spoils the factors.
    pub fn receptance(
        &mut self,
        matrices: &mut ScaledMatrices,
        (i, k): (usize, usize),
        x: f64,
    ) -> Option<ReceptanceAt> {
        let (i, k) = (matrices.structure().row(i), matrices.structure().row(k));
        let slope = self.solve(matrices, (i, k), x)?;
        let Self { u, w, .. } = self;
        let moved =
            matrices.stiffness().squared_form(w, u) + x * x * matrices.mass().squared_form(w, u);
        Some(ReceptanceAt {
            value: u[i],
            slope,
            ulp: f64::EPSILON * moved.sqrt() / slope.abs(),
        })
    }

    /// Columns i and k of (K − xM)⁻¹ by dof, each up to a factor, into `left` and `right`; returns leftᵀ M
    /// right.
    pub fn by_dof(
        &mut self,
        matrices: &mut ScaledMatrices,
        (i, k): (usize, usize),
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Option<f64> {
        let (i, k) = (matrices.structure().row(i), matrices.structure().row(k));
        let slope = self.solve(matrices, (i, k), x)?;
        for (out, column) in [(left, &self.w), (right, &self.u)] {
            out.clear();
            out.resize(matrices.n(), 0.0);
            matrices.by_dof(column, out);
        }
        Some(slope)
    }

    /// Solves for u and w at rows `i` and `k`; returns wᵀMu.
    fn solve(
        &mut self,
        matrices: &mut ScaledMatrices,
        (i, k): (usize, usize),
        x: f64,
    ) -> Option<f64> {
        if matrices.factorize(x) > LARGEST_GROWTH {
            return None;
        }
        let Self { u, w, mu } = self;
        for (column, load) in [(&mut *u, k), (&mut *w, i)] {
            column.clear();
            column.resize(matrices.stride(), 0.0);
            column[load] = 1.0;
            matrices.solve(column);
        }
        mu.resize(matrices.stride(), 0.0);
        matrices.mass().multiply(u, mu);
        let slope: f64 = w.iter().zip(mu.iter()).map(|(a, b)| a * b).sum();
        // A dof without mass has no scale.
        slope.is_finite().then_some(slope)
    }
}
