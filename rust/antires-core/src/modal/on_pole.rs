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

use crate::linalg::symmetric::SymmetricSolver;

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
    let (lambda, phi) = (modes.eigenvalues(), modes.vectors());
    let n = phi.nrows();
    for column in [&mut *left, &mut *right] {
        column.clear();
        column.resize(n, 0.0);
    }
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
            let (mode, column) = if at_i {
                (&mut *right, &mut *left)
            } else {
                (&mut *left, &mut *right)
            };
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
            if slope.abs() > NODE * size {
                slope
            } else {
                f64::NAN
            }
        }
        _ => f64::NAN,
    }
}
