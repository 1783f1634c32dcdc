//! Roots of the deleted pencil that the matrices have yet to confirm, and how they join those that are known.

use crate::error::Result;
use crate::linalg::pencil::{Bounded, UNCERTAIN};
use crate::linalg::pencil::{real_eigenvalues, roots_near};
use crate::linalg::sparse::SparseMatrix;

/// Most dofs of which QZ is asked at several scales, and the ratio of the entries of K and M from which on it is.
const MOST_AT_SCALES: usize = 120;
const FAR_APART: f64 = 1e8;

/// Relative distance in x within which a root of one route is that of the other.
const SAME_ROOT: f64 = 1e-6;

/// Whether two roots in x are one.
pub(super) fn near(x: f64, other: f64) -> bool {
    (x - other).abs() <= SAME_ROOT * x
}

/// Adds to `roots` those of `sure` that have no partner of their own there; one that is not certain takes its place
/// from its partner.
pub(super) fn add_new(roots: &mut Vec<Bounded>, sure: &[Bounded]) {
    let mut free: Vec<usize> = (0..roots.len()).collect();
    for root in sure {
        let distance = |&at: &usize| (roots[at].x - root.x).abs();
        let closest =
            (0..free.len()).min_by(|&p, &q| distance(&free[p]).total_cmp(&distance(&free[q])));
        let reach = |at: usize| {
            let own = root.bound + roots[at].bound.min(UNCERTAIN * root.x);
            own.max(SAME_ROOT * root.x)
        };
        match closest.filter(|&p| distance(&free[p]) <= reach(free[p])) {
            Some(p) => {
                let at = free.swap_remove(p);
                if roots[at].bound.is_infinite() {
                    roots[at] = *root;
                }
            }
            None => roots.push(*root),
        }
    }
}

/// Takes those `on_poles` out of `x` that have no partner of their own among `by_qz`, after all others of `x` have
/// taken theirs.
pub(super) fn take_out(x: &mut Vec<f64>, on_poles: &[f64], by_qz: &[f64]) -> Vec<f64> {
    let mut places = Vec::new();
    for pole in on_poles {
        let same = |&j: &usize| x[j] == *pole && !places.contains(&j);
        places.extend((0..x.len()).find(same));
    }
    let mut free = by_qz.to_vec();
    let mut take = |x: f64| match free.iter().position(|&other| near(x, other)) {
        Some(at) => {
            free.swap_remove(at);
            true
        }
        None => false,
    };
    for (_, &x) in x.iter().enumerate().filter(|(j, _)| !places.contains(j)) {
        take(x);
    }
    places.retain(|&j| !take(x[j]));
    places.sort_unstable();
    places.iter().rev().map(|&j| x.remove(j)).collect()
}

/// What QZ takes for real and positive roots up to `ceiling`, ascending, well known or not.
pub(super) fn candidates(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    (i, k): (usize, usize),
    ceiling: f64,
) -> Result<Vec<f64>> {
    let without = |gone: usize| -> Vec<usize> { (0..k_mat.n()).filter(|&d| d != gone).collect() };
    let roots = real_eigenvalues(
        k_mat.deleted(i, k).as_ref(),
        m_mat.deleted(i, k).as_ref(),
        (&without(i), &without(k)),
        (0.0, ceiling),
    )?;
    Ok(roots.iter().map(|root| root.x).collect())
}

/// The same, of pencils whose roots may be many decades apart, once for each end: QZ knows a root by the size of the
/// matrices near it.
pub(super) fn at_other_scales(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    (i, k): (usize, usize),
    ceiling: f64,
) -> Vec<Vec<f64>> {
    if k_mat.n() > MOST_AT_SCALES {
        return Vec::new();
    }
    let mut ratios: Vec<f64> = k_mat
        .entries()
        .zip(&m_mat.values)
        .filter(|((_, _, k), m)| *k != 0.0 && **m != 0.0)
        .map(|((_, _, k), m)| (k / m).abs())
        .collect();
    ratios.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (ratios.first(), ratios.last()) else {
        return Vec::new();
    };
    if most < FAR_APART * least {
        return Vec::new();
    }
    let (a, b) = (k_mat.deleted(i, k), m_mat.deleted(i, k));
    [least, most]
        .map(|x| roots_near(a.as_ref(), b.as_ref(), x, ceiling))
        .into()
}
