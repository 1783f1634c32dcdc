//! Columns i and k of (K − xM)⁻¹ from factors of K − xM, for roots on the matrices themselves
//! and for their sensitivities.
//!
//! ```text
//! (K − xM) u = e_k,  (K − xM) w = e_i        H_ik = e_iᵀu,  dH_ik/dx = wᵀMu
//! ```
//!
//! At a zero of H_ik, u without its entry i and w without its entry k are the null vectors of the deleted
//! pencil. The factors are formed without pivoting, so their growth is asked each time.
//!
//! # modal_columns
//!
//! Columns i and k of (K − xM)⁻¹ from all modes, where [`columns`](crate::modal::columns) has no factors.
//!
//! # on_pole
//!
//! Null vectors of the deleted pencil on a pole: a root of det(K_ik − x M_ik) that cancels.
//!
//! Sought are u with u_i = 0 and (K − λM) u on e_k alone, w with w_k = 0 and (K − λM) w on e_i alone; then
//!
//! ```text
//! dx/dp = wᵀ (dK/dp − λ dM/dp) u / (wᵀ M u)
//! ```
//!
//! - A single mode φ with a node at i: u = φ, w = φ_k h_i − H_ik φ, where h_i and H_ik are column i of the
//!   receptance matrix and its entry k without that mode. So dx/dp = dλ/dp + φ_k (dφ_i/dp) / H_ik: the root keeps
//!   its distance from the pole, which is the residue over what else responds there. A node at k: the two change
//!   places. Nodes at both: u = w = φ.
//! - Two modes of one λ, of which i and k see one combination each: u and w are those that i and k do not see.
//! - All else has more null vectors than one, or none that is not defective, and no derivative: NaN.
//!
//! # nelson
//!
//! Nelson's adjoint solution for one mode: the derivative of any function of its shape, for all parameters.
//!
//! The derivative of a function of a shape whose size it ignores, with slope g there (gᵀφ = 0), needs one
//! solution for each mode, whatever the number of parameters:
//!
//! ```text
//! (K − λM) dφ/dp = −(K' − λM' − λ'M) φ        differentiated K φ = λ M φ
//! (K − λM) z = g,  zᵀMφ = 0                   gᵀ dφ/dp = −zᵀ (K' − λM') φ
//! ```
//!
//! K − λM is singular. By factors it is solved with the row and the column of the largest entry of φ taken
//! out; from all modes z = Σ φ_s (φ_sᵀg) / (λ_s − λ) over the others.
//!
//! Source: R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA J. 14 (1976) 1201-1205,
//! doi 10.2514/3.7211.

use super::minor::{Ends, MinorSeries, Small};
use super::scaled::ScaledMatrices;
use crate::linalg::banded::LARGEST_GROWTH;
use crate::linalg::symmetric::SymmetricSolver;

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
    pub fn receptance(&mut self, matrices: &mut ScaledMatrices, ends: &Ends, x: f64) -> Option<ReceptanceAt> {
        let (value, slope) = self.solve(matrices, ends, x)?;
        let Self { u, w, .. } = self;
        let moved = matrices.stiffness.squared_form(w, u) + x * x * matrices.mass.squared_form(w, u);
        Some(ReceptanceAt { value, slope, ulp: f64::EPSILON * moved.sqrt() / slope.abs() })
    }

    /// Columns i and k of (K − xM)⁻¹ by dof, each up to a factor, into `left` and `right`; returns leftᵀ M
    /// right.
    pub fn by_dof(
        &mut self,
        matrices: &mut ScaledMatrices,
        ends: &Ends,
        x: f64,
        left: &mut Vec<f64>,
        right: &mut Vec<f64>,
    ) -> Option<f64> {
        let (_, slope) = self.solve(matrices, ends, x)?;
        for (out, column) in [(left, &self.w), (right, &self.u)] {
            zeros(out, matrices.n());
            matrices.by_dof(column, out);
        }
        Some(slope)
    }

    /// Solves for u and w; returns H_ik, or bᵀH[I, J] c, and wᵀMu.
    fn solve(&mut self, matrices: &mut ScaledMatrices, ends: &Ends, x: f64) -> Option<(f64, f64)> {
        if matrices.factorize(x) > LARGEST_GROWTH {
            return None;
        }
        let Self { u, w, mu } = self;
        let row = |dof: usize| matrices.structure.row(dof);
        let solved = |column: &mut Vec<f64>, loads: &mut dyn Iterator<Item = (usize, f64)>| {
            zeros(column, matrices.stride());
            loads.for_each(|(dof, load)| column[row(dof)] = load);
            matrices.solve(column);
        };
        let value = if let Some((i, k)) = ends.pair() {
            solved(u, &mut [(k, 1.0)].into_iter());
            solved(w, &mut [(i, 1.0)].into_iter());
            u[row(i)]
        } else {
            let mut h = Small::zeros(ends.forces().len());
            for (k, &force) in ends.forces().iter().enumerate() {
                solved(u, &mut [(force, 1.0)].into_iter());
                ends.responses().iter().enumerate().for_each(|(i, &dof)| h.a[i][k] = u[row(dof)]);
            }
            let null = h.null(None);
            solved(u, &mut ends.forces().iter().copied().zip(null.right));
            solved(w, &mut ends.responses().iter().copied().zip(null.left));
            null.value
        };
        mu.resize(matrices.stride(), 0.0);
        matrices.mass.multiply(u, mu);
        let slope: f64 = w.iter().zip(mu.iter()).map(|(a, b)| a * b).sum();
        // A dof without mass has no scale.
        slope.is_finite().then_some((value, slope))
    }
}

/// Makes a column of n zeros.
fn zeros(column: &mut Vec<f64>, n: usize) {
    column.clear();
    column.resize(n, 0.0);
}

// ---- modal_columns

/// The columns from all modes: h_i = Σ φ_r φ_ir / (λ_r − x) + Σ ψ ψ_i; returns h_iᵀ M h_k.
pub fn modal_columns(
    modes: &SymmetricSolver,
    (i, k): (usize, usize),
    x: f64,
    left: &mut Vec<f64>,
    right: &mut Vec<f64>,
) -> f64 {
    let (lambda, phi) = (&modes.eigenvalues, &modes.vectors);
    let n = phi.nrows();
    zeros(left, n);
    zeros(right, n);
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

/// Null vectors of the deleted pencil of a minor at `x`, on a pole too, from all modes; returns leftᵀ M right, NaN where
/// there are more than one.
pub fn of_minor(
    modes: &SymmetricSolver,
    series: &MinorSeries,
    ends: &Ends,
    x: f64,
    (left, right): (&mut Vec<f64>, &mut Vec<f64>),
) -> f64 {
    let (lambda, phi) = (&modes.eigenvalues, &modes.vectors);
    let n = phi.nrows();
    let (null, bordered, along) = series.null_vectors(x);
    for (column, factors, dofs) in [(left, null.left, ends.responses()), (right, null.right, ends.forces())] {
        zeros(column, n);
        for r in 0..phi.ncols() {
            let part = if bordered.contains(&r) {
                factors[dofs.len() + r - bordered.start]
            } else {
                let moved: f64 = dofs.iter().zip(factors).map(|(&dof, factor)| factor * phi[(dof, r)]).sum();
                moved * lambda.get(r).map_or(1.0, |l| (l - x).recip())
            };
            (0..n).for_each(|dof| column[dof] += part * phi[(dof, r)]);
        }
    }
    along
}

// ---- on_pole

/// Modes whose λ lie this close together, relatively, have one pole.
const ONE_POLE: f64 = 1e-9;

/// A mode smaller than this at a dof, relative to its largest entry, has a node there.
const NODE: f64 = 1e-9;

/// w into `left` and u into `right`, by dof, at the pole `x`; returns wᵀ M u, NaN where there is no derivative.
pub fn on_pole(
    modes: &SymmetricSolver,
    (i, k): (usize, usize),
    x: f64,
    left: &mut Vec<f64>,
    right: &mut Vec<f64>,
) -> f64 {
    let (lambda, phi) = (&modes.eigenvalues, &modes.vectors);
    let n = phi.nrows();
    zeros(left, n);
    zeros(right, n);
    let first = lambda.partition_point(|&l| l < x - ONE_POLE * x);
    let last = lambda.partition_point(|&l| l <= x + ONE_POLE * x);
    let sees = |dof: usize, r: usize| {
        let largest = (0..n).fold(0.0_f64, |m, d| m.max(phi[(d, r)].abs()));
        phi[(dof, r)].abs() > NODE * largest
    };
    let add = |column: &mut Vec<f64>, factor: f64, r: usize| {
        for (dof, entry) in column.iter_mut().enumerate() {
            *entry += factor * phi[(dof, r)];
        }
    };
    match last - first {
        1 if sees(i, first) && sees(k, first) => f64::NAN,
        1 if !sees(i, first) && !sees(k, first) => {
            add(left, 1.0, first);
            add(right, 1.0, first);
            1.0
        }
        1 => {
            // What responds there without this mode.
            let at_i = !sees(i, first);
            let (node, other) = if at_i { (i, k) } else { (k, i) };
            let (mode, column) = if at_i { (&mut *right, &mut *left) } else { (&mut *left, &mut *right) };
            add(mode, 1.0, first);
            let strength = phi[(other, first)];
            let mut rest = 0.0;
            for r in (0..phi.ncols()).filter(|&r| r != first) {
                let stretch = lambda.get(r).map_or(1.0, |l| (l - x).recip());
                let part = phi[(node, r)] * stretch;
                rest += part * phi[(other, r)];
                add(column, strength * part, r);
            }
            add(column, -rest, first);
            -rest
        }
        2 => {
            let pair = [first, first + 1];
            let [at_i, at_k] = [i, k].map(|dof| pair.map(|r| phi[(dof, r)]));
            add(left, -at_k[1], pair[0]);
            add(left, at_k[0], pair[1]);
            add(right, -at_i[1], pair[0]);
            add(right, at_i[0], pair[1]);
            let slope = at_i[0] * at_k[0] + at_i[1] * at_k[1];
            let size = at_i[0].hypot(at_i[1]) * at_k[0].hypot(at_k[1]);
            if slope.abs() > NODE * size { slope } else { f64::NAN }
        }
        _ => f64::NAN,
    }
}

// ---- nelson

/// Whether a solution could be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjoint {
    /// It is in place.
    Solved,
    /// Rounding spoils the factors.
    Spoiled,
}

/// z for the mode (λ, φ) by the matrices.
pub fn by_factors(
    matrices: &mut ScaledMatrices,
    (lambda, phi): (f64, &[f64]),
    g: &[f64],
    z: &mut Vec<f64>,
) -> Adjoint {
    let (n, padding) = (matrices.n(), matrices.stride() - matrices.n());
    let by_row = |values: &[f64], times: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let rows = (0..n).map(|row| values[matrices.structure.dof(row)] * times(matrices.scale[row]));
        rows.chain(std::iter::repeat_n(0.0, padding)).collect()
    };
    let shape = by_row(phi, &f64::recip);
    let mut solution = by_row(g, &|scale| scale);
    let largest = (0..n).fold(0, |at, row| if shape[row].abs() > shape[at].abs() { row } else { at });
    solution[largest] = 0.0;
    if matrices.factorize_without(largest, lambda) > LARGEST_GROWTH {
        return Adjoint::Spoiled;
    }
    matrices.solve(&mut solution);
    let mut weighted = vec![0.0; matrices.stride()];
    matrices.mass.multiply(&shape, &mut weighted);
    let part: f64 = solution[..n].iter().zip(&weighted).map(|(s, w)| s * w).sum();
    for (value, along) in solution[..n].iter_mut().zip(&shape) {
        *value -= part * along;
    }
    zeros(z, n);
    matrices.by_dof(&solution[..n], z);
    Adjoint::Solved
}

/// z for mode `r` from all modes.
pub fn by_all_modes(modes: &SymmetricSolver, r: usize, g: &[f64], z: &mut Vec<f64>) {
    let (all, vectors) = (&modes.eigenvalues, &modes.vectors);
    let n = vectors.nrows();
    zeros(z, n);
    for s in (0..n).filter(|&s| s != r) {
        let along: f64 = (0..n).map(|dof| vectors[(dof, s)] * g[dof]).sum();
        let stretch = all.get(s).map_or(1.0, |l| (l - all[r]).recip());
        for (dof, z) in z.iter_mut().enumerate() {
            *z += along * stretch * vectors[(dof, s)];
        }
    }
}
