//! The roots of one response, each with a bound of its error.
//!
//! Models of up to [`MOST_CHECKED`] dofs are solved on both routes, and what one of them finds alone counts if the
//! matrices confirm it ([`RootBounds`]).

use super::candidates::{add_new, at_other_scales, candidates, near, take_out};
use super::query::{Antiresonances, Query, Transfer};
use super::solver::Prepared;
use crate::error::Result;
use crate::linalg::pencil::{Bounded, RootBounds, UNCERTAIN};
use crate::linalg::sparse::SparseMatrix;
use crate::modal::modes::{eigenvalue, hertz};

/// Most dofs of which each root is confirmed on the dense deleted pencil, and both routes are asked.
pub(super) const MOST_CHECKED: usize = 400;

/// Relative distance in x, beside its bound, at which a root lies on a pole: what modes are known to.
const ON_POLE: f64 = 1e-10;

/// Rounding of x = ω² to Hz, relative.
const TO_HERTZ: f64 = 4.0 * f64::EPSILON;

/// The roots of one response with their bounds.
pub(super) fn bounded(
    prepared: &mut Prepared<'_>,
    matrices: (&SparseMatrix, &SparseMatrix),
    ends: (usize, usize),
    query: &Query,
) -> Result<Antiresonances> {
    let (i, k) = ends;
    let n = matrices.0.n();
    let mut found = Antiresonances::default();
    let first = prepared.find(i, k, query, &mut found.freq_hz);
    if n > MOST_CHECKED {
        found.identically_zero = first? == Transfer::IdenticallyZero;
        found.doubtful = !found.identically_zero && prepared.is_doubtful();
        found.error_hz = found
            .freq_hz
            .iter()
            .map(|&f| prepared.bound(ends, f))
            .collect();
        return Ok(found);
    }
    let mut on_poles = Vec::new();
    let is_zero = match &first {
        Ok(transfer) => {
            if query.include_cancelled {
                prepared.cancelled(&mut on_poles);
            }
            *transfer == Transfer::IdenticallyZero
        }
        Err(_) => false,
    };
    // A root that only the pencil has, on a pole, cancels: the FRF shows nothing there.
    let cancelling = match &first {
        Ok(_) if !query.include_cancelled => prepared.eigenvalues()?.to_vec(),
        _ => Vec::new(),
    };
    let certifier = RootBounds::of(&matrices.0.deleted(i, k), &matrices.1.deleted(i, k));
    let x_of = |freq_hz: &[f64]| -> Vec<f64> { freq_hz.iter().map(|&f| eigenvalue(f)).collect() };
    let mut x = x_of(&found.freq_hz);
    let ceiling = eigenvalue(query.f_max_hz);
    // Where QZ fails, the modal route stands alone.
    let roots = match candidates(matrices, ends, ceiling) {
        Err(_) => certifier.places(&x),
        Ok(by_qz) => {
            // A residue may be negligible without a root beside the pole.
            let alone = take_out(&mut x, &x_of(&on_poles), &by_qz);
            let mut roots = certifier.places(&x);
            let sure = |root: &Bounded| root.bound <= UNCERTAIN * root.x;
            let confirmed = |candidates: &[f64]| -> Vec<Bounded> {
                certifier
                    .places(candidates)
                    .into_iter()
                    .filter(sure)
                    .filter(|root| !cancelling.iter().any(|&pole| on_pole(root, pole)))
                    .collect()
            };
            add_new(&mut roots, &confirmed(&by_qz));
            for more in at_other_scales(matrices, ends, ceiling) {
                add_new(&mut roots, &confirmed(&more));
            }
            for root in certifier.places(&alone).into_iter().filter(sure) {
                if !roots.iter().any(|other| near(root.x, other.x)) {
                    roots.push(root);
                }
            }
            roots.sort_by(|p, q| p.x.total_cmp(&q.x));
            if roots.len() > x.len() {
                // What was added may lie so close to others that only all of them together have a bound.
                let all: Vec<f64> = roots.iter().map(|root| root.x).collect();
                roots = certifier.places(&all);
            }
            roots
        }
    };
    if first.is_err() {
        // Without modes QZ alone has to tell. A dof without stiffness and mass leaves it nothing to tell.
        if roots.is_empty() || has_empty_row(matrices) {
            return first.map(|_| found);
        }
        found.doubtful = true;
    }
    found.identically_zero = is_zero && roots.is_empty();
    found.freq_hz = roots.iter().map(|root| hertz(root.x)).collect();
    found.error_hz = roots.iter().map(hertz_error).collect();
    Ok(found)
}

/// Whether a root lies on a pole.
fn on_pole(root: &Bounded, pole: f64) -> bool {
    (root.x - pole).abs() <= root.bound + ON_POLE * root.x
}

/// Whether some dof has neither stiffness nor mass.
fn has_empty_row((k_mat, m_mat): (&SparseMatrix, &SparseMatrix)) -> bool {
    let mut present = vec![false; k_mat.n()];
    for (i, _, value) in k_mat.entries().chain(m_mat.entries()) {
        present[i] |= value != 0.0;
    }
    present.contains(&false)
}

/// The bound in Hz of one in x = ω²; infinite for one that is not certain.
fn hertz_error(root: &Bounded) -> f64 {
    if root.bound <= UNCERTAIN * root.x {
        // √ is concave: the lower side is the farther one.
        let freq = hertz(root.x);
        (freq - hertz(root.x - root.bound)).max(0.0) + TO_HERTZ * freq
    } else {
        f64::INFINITY
    }
}
