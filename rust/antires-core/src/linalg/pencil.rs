//! Finite real eigenvalues of a general real pencil A v = x B v.
//!
//! The pencil is first taken apart into irreducible blocks ([`super::blocks`]), which is exact. A block
//! that is a symmetric part of the structure goes to the symmetric solver; any other goes to QZ.
//!
//! QZ gives each eigenvalue as a ratio α/β. A QZ solver may return without having converged, and a
//! singular B scatters its infinite eigenvalues over large finite ones. So each real eigenvalue in the
//! asked range is verified on the matrices themselves. Two steps of inverse iteration on A − xB give
//! its right and left vectors v, y, and with them
//!
//! 1. its backward error ‖(A − xB) v‖ / ((‖A‖ + |x| ‖B‖) ‖v‖), which must be at rounding level;
//! 2. its first-order uncertainty (Stewart & Sun, Matrix Perturbation Theory, 1990, VI.2.2): the
//!    chordal distance that n ulp of A and B can move it, n·eps·‖y‖‖v‖ / √(|yᵀAv|² + |yᵀBv|²). An
//!    eigenvalue that this can carry to infinity (to zero) is infinite (zero) at working precision.
//!
//! A and B are scaled to unit norm first, so that x is of order one. The uncertainty is that of matrices known
//! to some ulp of their norm. A root of entries far below the norm, such as soft springs under stiff beams, may
//! be known much better and still come out as uncertain: such roots are returned too, marked, for a caller that
//! can look at them entry by entry.

use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{GevdParams, gevd_real, gevd_scratch};
use faer::prelude::Solve;
use faer::{Auto, Col, Mat, MatRef, Par, Spec};

use super::blocks::irreducible_blocks;
use super::equilibrated::Equilibrated;
use super::symmetric::SymmetricSolver;
use super::tolerances::{
    QZ_BACKWARD_ERROR, REAL_ROOT, REPEATED_ROOT, REPEATED_ROOT_DISTANCE, ROOT_UNCERTAINTY,
    SPLIT_ROOT,
};
use crate::error::{Error, Result};

/// A real eigenvalue of a pencil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PencilRoot {
    /// Its value.
    pub x: f64,
    /// How far, relatively, n ulp of the norms of A and B can move it; of a repeated root, half the gap to
    /// which QZ splits it.
    pub uncertainty: f64,
    /// Whether another one lies close by.
    pub repeated: bool,
    /// False where that can carry it to zero, to infinity or off the real line, or where it fails its residual
    /// check.
    pub certain: bool,
    /// The backward error of one that would be certain but for that: QZ may not have converged.
    pub backward_error: Option<f64>,
}

/// Real eigenvalues of A v = x B v in (low, high], ascending, repeated ones repeated.
///
/// `rows` and `cols` name the rows and columns of A and B by dof, so that symmetric blocks are recognised.
///
/// # Errors
/// [`Error::Numerical`] when QZ does not converge or no vectors of an eigenvalue can be found.
pub fn real_eigenvalues(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    (rows, cols): (&[usize], &[usize]),
    (low, high): (f64, f64),
) -> Result<Vec<PencilRoot>> {
    let mut roots = Vec::new();
    for block in irreducible_blocks(a, b).unwrap_or_default() {
        let n = block.rows.len();
        let part =
            |m: MatRef<'_, f64>| Mat::from_fn(n, n, |i, j| m[(block.rows[i], block.cols[j])]);
        let (block_a, block_b) = (part(a), part(b));
        let mut row_dofs: Vec<usize> = block.rows.iter().map(|&r| rows[r]).collect();
        let mut col_dofs: Vec<usize> = block.cols.iter().map(|&c| cols[c]).collect();
        row_dofs.sort_unstable();
        col_dofs.sort_unstable();
        let symmetric =
            (n > 1 && row_dofs == col_dofs).then(|| symmetric_eigenvalues(&block_a, &block_b));
        match symmetric.flatten() {
            _ if n == 1 => roots.extend(ratio(block_a[(0, 0)], block_b[(0, 0)], low, high)),
            Some(found) => roots.extend(found.into_iter().filter(|r| low < r.x && r.x <= high)),
            None => roots.extend(block_eigenvalues(block_a, block_b, low, high)?),
        }
    }
    roots.sort_by(|p, q| p.x.total_cmp(&q.x));
    Ok(roots)
}

/// What QZ takes for real and positive eigenvalues up to `high`, ascending, of the pencil scaled so that those near
/// `x` keep their digits. They are not verified; where QZ fails there are none.
#[must_use]
pub fn roots_near(a: MatRef<'_, f64>, b: MatRef<'_, f64>, x: f64, high: f64) -> Vec<f64> {
    let mut roots = Vec::new();
    for block in irreducible_blocks(a, b).unwrap_or_default() {
        let n = block.rows.len();
        let part =
            |m: MatRef<'_, f64>| Mat::from_fn(n, n, |i, j| m[(block.rows[i], block.cols[j])]);
        let (block_a, block_b) = (part(a), part(b) * faer::Scale(x));
        let scaled = Equilibrated::weighted(&block_a, &block_b, 1.0);
        let ratios = qz_ratios(&scaled.a, &scaled.b).unwrap_or_default();
        let found = ratios.iter().map(|(ratio, _)| ratio * x);
        roots.extend(found.filter(|x| 0.0 < *x && *x <= high));
    }
    roots.sort_by(f64::total_cmp);
    roots
}

/// The root of a block of one row, exact.
fn ratio(a: f64, b: f64, low: f64, high: f64) -> Option<PencilRoot> {
    let x = a / b;
    (low < x && x <= high && x.is_finite()).then_some(PencilRoot {
        x,
        uncertainty: f64::EPSILON,
        repeated: false,
        certain: true,
        backward_error: None,
    })
}

/// Eigenvalues of a symmetric block; none when it is not fit for the symmetric solver.
fn symmetric_eigenvalues(a: &Mat<f64>, b: &Mat<f64>) -> Option<Vec<PencilRoot>> {
    let mut solver = SymmetricSolver::new(a.nrows());
    solver.solve(a.as_ref(), b.as_ref()).ok()?;
    let root = |&x: &f64| {
        let uncertainty = solver.uncertainty(x.abs()) / x.abs();
        PencilRoot {
            x,
            uncertainty,
            repeated: false,
            certain: uncertainty <= ROOT_UNCERTAINTY,
            backward_error: None,
        }
    };
    Some(solver.eigenvalues().iter().map(root).collect())
}

/// Real eigenvalues of an irreducible block in (low, high], by QZ.
fn block_eigenvalues(a: Mat<f64>, b: Mat<f64>, low: f64, high: f64) -> Result<Vec<PencilRoot>> {
    let n = a.nrows();
    let scaled = Equilibrated::of(&a, &b);
    let (a, b) = if scaled.is_graded {
        (scaled.a, scaled.b)
    } else {
        (a, b)
    };
    let (norm_a, norm_b) = (a.norm_l2(), b.norm_l2());
    if norm_a == 0.0 || norm_b == 0.0 {
        // No stiffness: every root is zero. No mass: every root is infinite.
        return Ok(Vec::new());
    }
    let unit = norm_a / norm_b;
    let a = a * faer::Scale(norm_a.recip());
    let b = b * faer::Scale(norm_b.recip());
    let mut candidates = qz_ratios(&a, &b)?;
    candidates.retain(|(x, _)| low < x * unit && x * unit <= high);
    candidates.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut roots = Vec::with_capacity(candidates.len());
    for (j, &(x, imaginary)) in candidates.iter().enumerate() {
        let close = |other: &(f64, f64)| (other.0 - x).abs() <= REPEATED_ROOT * x.abs();
        let has_neighbour =
            (j > 0 && close(&candidates[j - 1])) || candidates.get(j + 1).is_some_and(close);
        let multiplicity = if has_neighbour {
            Multiplicity::Repeated
        } else {
            Multiplicity::Simple
        };
        let checked = Verified::of(&a, &b, x)?;
        let certain = checked.is_certain(x, n, multiplicity) && checked.is_real(x, imaginary, n);
        let small = checked.has_small_residual(multiplicity);
        roots.push(PencilRoot {
            x: x * unit,
            uncertainty: match multiplicity {
                Multiplicity::Repeated => SPLIT_ROOT,
                Multiplicity::Simple => checked.uncertainty(x, n),
            },
            repeated: multiplicity == Multiplicity::Repeated,
            certain: certain && small,
            backward_error: (certain && !small).then_some(checked.residual),
        });
    }
    let (mut sure, open): (Vec<_>, Vec<_>) = roots.into_iter().partition(|r| r.certain);
    merge_defective(&mut sure);
    sure.extend(open);
    Ok(sure)
}

/// QZ splits a double root with one vector by the root of rounding, to either side; the mean of the two
/// is as good as a simple root.
fn merge_defective(roots: &mut [PencilRoot]) {
    for group in roots.chunk_by_mut(|p, q| q.x - p.x <= SPLIT_ROOT * q.x) {
        let mean = group.iter().map(|r| r.x).sum::<f64>() / group.len() as f64;
        group.iter_mut().for_each(|r| r.x = mean);
    }
}

/// The finite ratios α/β of QZ that are real or nearly so: real part, relative imaginary part.
fn qz_ratios(a: &Mat<f64>, b: &Mat<f64>) -> Result<Vec<(f64, f64)>> {
    let n = a.nrows();
    let (mut re, mut im, mut beta) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let none = ComputeEigenvectors::No;
    let mut memory = MemBuffer::new(gevd_scratch::<f64>(
        n,
        none,
        none,
        Par::Seq,
        Default::default(),
    ));
    gevd_real(
        a.clone().as_mut(),
        b.clone().as_mut(),
        DiagMut::from_slice_mut(&mut re),
        DiagMut::from_slice_mut(&mut im),
        DiagMut::from_slice_mut(&mut beta),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        unblocked(),
    )
    .map_err(|_| failed("QZ reached its iteration limit"))?;
    Ok((0..n)
        .filter(|&j| im[j].abs() <= SPLIT_ROOT * re[j].abs())
        .map(|j| (re[j] / beta[j], (im[j] / re[j]).abs()))
        .filter(|(x, _)| x.is_finite())
        .collect())
}

/// Of faer 0.24 the blocked Hessenberg-triangular reduction loses all digits from 34 rows on, and the sweeps of
/// many shifts, from 75 rows on, take hundreds of times longer than those of one.
fn unblocked() -> Spec<GevdParams, f64> {
    let mut params = <GevdParams as Auto<f64>>::auto();
    params.hessenberg.block_size = 1;
    params.hessenberg.blocking_threshold = usize::MAX;
    params.schur.blocking_threshold = usize::MAX;
    Spec::new(params)
}

/// Whether another root lies close by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Multiplicity {
    Simple,
    Repeated,
}

/// An eigenvalue with its vectors, checked on the matrices.
struct Verified {
    /// ‖y‖‖v‖ / √(|yᵀAv|² + |yᵀBv|²).
    condition: f64,
    /// ‖(A − xB) v‖ / (1 + |x|).
    residual: f64,
}

impl Verified {
    fn of(a: &Mat<f64>, b: &Mat<f64>, x: f64) -> Result<Self> {
        let n = a.nrows();
        // A root that hits the eigenvalue exactly would make a pivot zero.
        for nudge in [0.0, 4.0, -16.0] {
            let at = x * (1.0 + nudge * f64::EPSILON);
            let shifted = Mat::from_fn(n, n, |i, j| a[(i, j)] - at * b[(i, j)]);
            let lu = shifted.partial_piv_lu();
            let mut v = Col::from_fn(n, |i| 1.0 + 0.3 * (1.7 * i as f64).sin());
            let mut y = v.clone();
            for _ in 0..2 {
                v = unit(lu.solve(&v));
                y = unit(lu.solve_transpose(&y));
            }
            let residual = (&shifted * &v).norm_l2() / (1.0 + x.abs());
            if !residual.is_finite() || !y.norm_l2().is_finite() {
                continue;
            }
            let strength = (y.transpose() * a * &v).hypot(y.transpose() * b * &v);
            return Ok(Self {
                condition: strength.max(f64::MIN_POSITIVE).recip(),
                residual,
            });
        }
        Err(failed(&format!(
            "no vectors could be found for the eigenvalue {x:e} (scaled)"
        )))
    }

    fn has_small_residual(&self, multiplicity: Multiplicity) -> bool {
        let most = match multiplicity {
            // A repeated root is itself only good to the root of rounding.
            Multiplicity::Repeated => SPLIT_ROOT,
            Multiplicity::Simple => QZ_BACKWARD_ERROR,
        };
        self.residual <= most
    }

    /// First-order uncertainty relative to the chordal distance of x = α/β, α² + β² = 1, from zero and from
    /// infinity.
    fn uncertainty(&self, x: f64, n: usize) -> f64 {
        n as f64 * f64::EPSILON * self.condition / distance(x)
    }

    /// Whether an imaginary part of that size can be rounding.
    fn is_real(&self, x: f64, imaginary: f64, n: usize) -> bool {
        imaginary <= REAL_ROOT.max(10.0 * self.uncertainty(x, n))
    }

    fn is_certain(&self, x: f64, n: usize, multiplicity: Multiplicity) -> bool {
        match multiplicity {
            // The vectors of a repeated root are arbitrary within its plane and say nothing of its
            // uncertainty; infinite roots do not come as real roots this close together.
            Multiplicity::Repeated => distance(x) > REPEATED_ROOT_DISTANCE,
            Multiplicity::Simple => self.uncertainty(x, n) <= ROOT_UNCERTAINTY,
        }
    }
}

/// Chordal distance of x from zero and from infinity.
fn distance(x: f64) -> f64 {
    x.abs().min(1.0) / x.hypot(1.0)
}

fn unit(v: Col<f64>) -> Col<f64> {
    let size = v.norm_l2();
    v * faer::Scale(size.recip())
}

/// The error of a root that does not solve the pencil.
#[must_use]
pub fn refused(x: f64, backward_error: f64) -> Error {
    failed(&format!(
        "the eigenvalue {x:e} has a backward error of {backward_error:e}"
    ))
}

fn failed(detail: &str) -> Error {
    Error::Numerical {
        what: "antiresonance pencil".into(),
        detail: format!("{detail}. Use method=\"modal\", or check K and M for extreme values"),
    }
}
