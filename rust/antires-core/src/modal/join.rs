//! The roots of the deleted pencil, joined with those that the modal series proves.
//!
//! QZ answers for the norm of the matrices. What one series isolated by a change of sign stands on its own and
//! is never taken away by it: each proven root, and each root that cancels against a pole, takes the root of the
//! pencil next to it for its own. Those of the pencil that remain are
//!
//! - kept, if QZ knows them well,
//! - polished on the matrices, if it does not; kept where that ends at a root that none has yet;
//! - dropped, if neither QZ nor a polish can tell them from zero, infinity or a complex pair; of one that does
//!   not even solve the pencil it is said that QZ failed.

use faer::{Mat, MatRef};

use super::antiresonances::{AntiresonanceSolver, Matrices};
use super::isolate::{DOUBTFUL_ROOT, ONE_ROOT, REACH, SAME_ULPS};
use super::polish::Polished;
use crate::error::Result;
use crate::linalg::pencil::{PencilRoot, real_eigenvalues, refused};
use crate::linalg::tolerances::ROOT_UNCERTAINTY;

/// Relative distance within which a root of the pencil is that of a proven one, or of the cancelled one expected
/// at a pole.
const SAME_ROOT: f64 = 1e-6;

impl AntiresonanceSolver {
    /// Adds the roots of the pencil up to `ceiling` to those found.
    ///
    /// # Errors
    /// Those of [`real_eigenvalues`], and a root that QZ returned without having converged.
    pub(super) fn join_pencil(
        &mut self,
        matrices: Matrices<'_>,
        (i, k): (usize, usize),
        ceiling: f64,
    ) -> Result<()> {
        let (k_mat, m_mat) = matrices;
        let (k_ik, m_ik) = (deleted(k_mat, i, k), deleted(m_mat, i, k));
        let without =
            |gone: usize| -> Vec<usize> { (0..k_mat.nrows()).filter(|&d| d != gone).collect() };
        let mut pencil = real_eigenvalues(
            k_ik.as_ref(),
            m_ik.as_ref(),
            (&without(i), &without(k)),
            (self.found.floor, ceiling),
        )?;
        for &x in &self.found.proven {
            take_nearest(&mut pencil, x);
        }
        self.found.cancelled.retain_mut(|(x, sure)| {
            let own = take_nearest(&mut pencil, *x);
            *x = own.map_or(*x, |root| root.x);
            *sure || own.is_some()
        });
        for root in pencil {
            if root.certain && (root.repeated || root.uncertainty <= DOUBTFUL_ROOT) {
                self.found.proven.push(root.x);
                continue;
            }
            let reach = REACH * root.uncertainty * root.x;
            match self.polish(matrices, (i, k), root.x, reach) {
                Some(Polished { x, ulp }) => {
                    let known = |y: &f64| (x - y).abs() <= (ONE_ROOT * y).max(SAME_ULPS * ulp);
                    let mut cancelled = self.found.cancelled.iter().map(|(y, _)| y);
                    if !self.found.proven.iter().any(known) && !cancelled.any(known) && x <= ceiling
                    {
                        self.found.proven.push(x);
                    }
                }
                None => match root.backward_error {
                    Some(error) => return Err(refused(root.x, error)),
                    None if root.certain => self.found.proven.push(root.x),
                    None => {}
                },
            }
        }
        Ok(())
    }
}

/// Takes the root nearest to `x` out of the list, if it can be the same.
fn take_nearest(roots: &mut Vec<PencilRoot>, x: f64) -> Option<PencilRoot> {
    let distance = |r: &PencilRoot| (r.x - x).abs();
    let at =
        (0..roots.len()).min_by(|&a, &b| distance(&roots[a]).total_cmp(&distance(&roots[b])))?;
    let reach = roots[at].uncertainty.clamp(SAME_ROOT, ROOT_UNCERTAINTY);
    (distance(&roots[at]) <= reach * x).then(|| roots.remove(at))
}

/// The matrix without row `i` and column `k`.
fn deleted(a: MatRef<'_, f64>, i: usize, k: usize) -> Mat<f64> {
    let n = a.nrows();
    Mat::from_fn(n - 1, n - 1, |r, c| {
        a[(r + usize::from(r >= i), c + usize::from(c >= k))]
    })
}
