//! The roots of the deleted pencil, joined with those that the modal series proves.
//!
//! QZ answers for the norm of the matrices. What one series isolated by a change of sign stands on its own and
//! is never taken away by it: each proven root, and each root that cancels against a pole, takes the root of the
//! pencil next to it for its own. Those of the pencil that remain are
//!
//! - kept, if QZ knows them well,
//! - placed on the matrices ([`super::placement`]), if it does not; kept where that ends at a root that none has yet;
//! - dropped, if neither QZ nor the matrices can tell them from zero, infinity or a complex pair; of one that does
//!   not even solve the pencil it is said that QZ failed.

use super::found::Found;
use super::placement::place;
use super::search::{DOUBTFUL_ROOT, REACH};
use crate::error::Result;
use crate::linalg::pencil::ROOT_UNCERTAINTY;
use crate::linalg::pencil::{PencilRoot, real_eigenvalues, refused};
use crate::modal::solved::Solved;

/// Relative distance within which a root of the pencil is that of a proven one, or of the cancelled one expected
/// at a pole.
const SAME_ROOT: f64 = 1e-6;

/// Adds the roots of the pencil up to `ceiling` to those found.
///
/// # Errors
/// Those of [`real_eigenvalues`], and a root that QZ returned without having converged.
pub(super) fn join(
    solved: &mut Solved<'_>,
    (i, k): (usize, usize),
    ceiling: f64,
    found: &mut Found,
) -> Result<()> {
    let (k_ik, m_ik) = (
        solved.stiffness().deleted(i, k),
        solved.mass().deleted(i, k),
    );
    let n = solved.n_dof();
    let without = |gone: usize| -> Vec<usize> { (0..n).filter(|&d| d != gone).collect() };
    let mut pencil = real_eigenvalues(
        k_ik.as_ref(),
        m_ik.as_ref(),
        (&without(i), &without(k)),
        (found.floor(), ceiling),
    )?;
    found.claim(|x| take_nearest(&mut pencil, x).map(|root| root.x));
    for root in pencil {
        if root.certain && (root.repeated || root.uncertainty <= DOUBTFUL_ROOT) {
            found.prove(root.x);
            continue;
        }
        let reach = REACH * root.uncertainty * root.x;
        match place(solved, (i, k), root.x, reach) {
            Some(placed) => {
                if !found.has(placed) && placed.x <= ceiling {
                    found.prove(placed.x);
                }
            }
            None => match root.backward_error {
                Some(error) => return Err(refused(root.x, error)),
                None if root.certain => found.prove(root.x),
                None => {}
            },
        }
    }
    Ok(())
}

/// Takes the root nearest to `x` out of the list, if it can be the same.
fn take_nearest(roots: &mut Vec<PencilRoot>, x: f64) -> Option<PencilRoot> {
    let distance = |r: &PencilRoot| (r.x - x).abs();
    let at =
        (0..roots.len()).min_by(|&a, &b| distance(&roots[a]).total_cmp(&distance(&roots[b])))?;
    let reach = roots[at].uncertainty.clamp(SAME_ROOT, ROOT_UNCERTAINTY);
    (distance(&roots[at]) <= reach * x).then(|| roots.remove(at))
}
