//! Finite real eigenvalues of a general real pencil A v = x B v.
//!
//! The pencil is first taken apart into irreducible blocks ([`crate::linalg::pencil`]), which is exact. A block
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
//!
//! # blocks
//!
//! Block-triangular form of a pencil: its eigenvalues are those of the irreducible diagonal blocks.
//!
//! A perfect matching pairs every row with a column of non-zero entry; the strong components of the
//! directed graph row → column then give the blocks (Dulmage & Mendelsohn, Can. J. Math. 10 (1958)
//! 517-534; Pothen & Fan, ACM Trans. Math. Softw. 16 (1990) 303-324). Nothing is rounded. Where
//! response and excitation are far apart the deleted pencil is so far from normal that QZ on the whole
//! of it may move its roots by per cents, while its blocks, the parts of the structure that the path
//! between the two leaves over, are as benign as the structure itself.
//!
//! # equilibrated
//!
//! A general pencil whose rows and columns are brought to one size by powers of two, which round nothing.
//!
//! The scales are those that make all entries at most one, and those of one permutation, the one of largest product,
//! one (about): the determinant then stands on entries of size one, however weak the links on which it hangs. They
//! are the potentials of an assignment problem with the costs −log₂|a_ij|.
//!
//! References: M. Olschowka & A. Neumaier, Linear Algebra Appl. 240 (1996) 131-151; I. S. Duff & J. Koster, SIAM J.
//! Matrix Anal. Appl. 22 (2001) 973-996.
//!
//! # root_bounds
//!
//! How far a root of a pencil A − xB may be from that of the matrices as given.
//!
//! ```text
//! δ = yᵀ(A − xB)v / yᵀBv        its place, by two-sided Rayleigh quotients
//! ε = c eps |y|ᵀ(|A| + x|B|)|v| / |yᵀBv|        how far rounding may have moved that
//! ```
//!
//! with right and left null vectors v, y from inverse iteration. The first-order bound is ε with c = 16 + n, and what
//! v leaves over of (A − xB)v: it covers the rounding of the products, and the change of the root by some ulp of each
//! entry of K and M. It says nothing where it is not small: then the root is not certain.
//!
//! Roots whose bounds overlap are taken together: with bases V, Y of their deflating subspaces all of them are
//! eigenvalues of G⁻¹E + Δ, E = Yᵀ(A − xB)V, G = YᵀBV, |Δ| <= |G⁻¹| c eps |Y|ᵀ(|A| + x|B|)|V|. For each p
//!
//! ```text
//! |λ|^p <= ‖(G⁻¹E)^p‖ + ‖(|G⁻¹E| + |Δ|)^p − |G⁻¹E|^p‖
//! ```
//!
//! so that a double root with one vector is known to the root of rounding, one with two as well as a simple one.
//!
//! Reference: G. W. Stewart & J. Sun, Matrix Perturbation Theory, 1990, VI.2.2.

use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{GevdParams, gevd_real, gevd_scratch};
use faer::prelude::Solve;
use faer::{Auto, Col, Mat, MatRef, Par, Scale, Spec};

use super::symmetric::SymmetricSolver;
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

impl PencilRoot {
    /// A root that solves the pencil, and stands alone.
    fn simple(x: f64, uncertainty: f64) -> Self {
        let certain = uncertainty <= ROOT_UNCERTAINTY;
        Self { x, uncertainty, repeated: false, certain, backward_error: None }
    }
}

/// Real eigenvalues of A v = x B v in (low, high], ascending, repeated ones repeated.
///
/// `rows` and `cols` name the rows and columns of A and B by dof, so that symmetric blocks are recognised.
pub fn real_eigenvalues(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    (rows, cols): (&[usize], &[usize]),
    (low, high): (f64, f64),
) -> Result<Vec<PencilRoot>> {
    let mut roots = Vec::new();
    for block in irreducible_blocks(a, b).unwrap_or_default() {
        let n = block.rows.len();
        let part = |m: MatRef<'_, f64>| Mat::from_fn(n, n, |i, j| m[(block.rows[i], block.cols[j])]);
        let (block_a, block_b) = (part(a), part(b));
        let mut row_dofs: Vec<usize> = block.rows.iter().map(|&r| rows[r]).collect();
        let mut col_dofs: Vec<usize> = block.cols.iter().map(|&c| cols[c]).collect();
        row_dofs.sort_unstable();
        col_dofs.sort_unstable();
        let symmetric = (n > 1 && row_dofs == col_dofs).then(|| symmetric_eigenvalues(&block_a, &block_b));
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
pub fn roots_near(a: MatRef<'_, f64>, b: MatRef<'_, f64>, x: f64, high: f64) -> Vec<f64> {
    let mut roots = Vec::new();
    for block in irreducible_blocks(a, b).unwrap_or_default() {
        let n = block.rows.len();
        let part = |m: MatRef<'_, f64>| Mat::from_fn(n, n, |i, j| m[(block.rows[i], block.cols[j])]);
        let (block_a, block_b) = (part(a), part(b) * Scale(x));
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
    (low < x && x <= high && x.is_finite()).then_some(PencilRoot::simple(x, f64::EPSILON))
}

/// Eigenvalues of a symmetric block; none when it is not fit for the symmetric solver.
fn symmetric_eigenvalues(a: &Mat<f64>, b: &Mat<f64>) -> Option<Vec<PencilRoot>> {
    let mut solver = SymmetricSolver::new(a.nrows());
    solver.solve(a.as_ref(), b.as_ref()).ok()?;
    let root = |&x: &f64| PencilRoot::simple(x, solver.uncertainty(x.abs()) / x.abs());
    Some(solver.eigenvalues.iter().map(root).collect())
}

/// Real eigenvalues of an irreducible block in (low, high], by QZ.
fn block_eigenvalues(a: Mat<f64>, b: Mat<f64>, low: f64, high: f64) -> Result<Vec<PencilRoot>> {
    let n = a.nrows();
    let scaled = Equilibrated::of(&a, &b);
    let (a, b) = if scaled.is_graded { (scaled.a, scaled.b) } else { (a, b) };
    let (norm_a, norm_b) = (a.norm_l2(), b.norm_l2());
    if norm_a == 0.0 || norm_b == 0.0 {
        // No stiffness: every root is zero. No mass: every root is infinite.
        return Ok(Vec::new());
    }
    let unit = norm_a / norm_b;
    let a = a * Scale(norm_a.recip());
    let b = b * Scale(norm_b.recip());
    let mut candidates = qz_ratios(&a, &b)?;
    candidates.retain(|(x, _)| low < x * unit && x * unit <= high);
    candidates.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut roots = Vec::with_capacity(candidates.len());
    for (j, &(x, imaginary)) in candidates.iter().enumerate() {
        let close = |other: &(f64, f64)| (other.0 - x).abs() <= REPEATED_ROOT * x.abs();
        let has_neighbour = (j > 0 && close(&candidates[j - 1])) || candidates.get(j + 1).is_some_and(close);
        let multiplicity = if has_neighbour { Multiplicity::Repeated } else { Multiplicity::Simple };
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
    let mut memory = MemBuffer::new(gevd_scratch::<f64>(n, none, none, Par::Seq, Default::default()));
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
            return Ok(Self { condition: strength.max(f64::MIN_POSITIVE).recip(), residual });
        }
        Err(failed(&format!("no vectors could be found for the eigenvalue {x:e} (scaled)")))
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

/// v / ‖v‖.
pub fn unit(v: Col<f64>) -> Col<f64> {
    let size = v.norm_l2();
    v * Scale(size.recip())
}

/// The error of a root that does not solve the pencil.
pub fn refused(x: f64, backward_error: f64) -> Error {
    failed(&format!("the eigenvalue {x:e} has a backward error of {backward_error:e}"))
}

fn failed(detail: &str) -> Error {
    Error::Numerical {
        what: "antiresonance pencil".into(),
        detail: format!("{detail}. Use method=\"modal\", or check K and M for extreme values"),
    }
}

// ---- blocks

/// One diagonal block: its rows and its columns, both ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Rows of the pencil.
    pub rows: Vec<usize>,
    /// Columns of the pencil.
    pub cols: Vec<usize>,
}

/// Irreducible blocks of A − xB; none when the pattern admits no non-zero determinant.
pub fn irreducible_blocks(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Option<Vec<Block>> {
    let n = a.nrows();
    let present = |r: usize, c: usize| a[(r, c)] != 0.0 || b[(r, c)] != 0.0;
    let columns: Vec<Vec<usize>> = (0..n).map(|r| (0..n).filter(|&c| present(r, c)).collect()).collect();
    let row_of = perfect_matching(&columns)?;
    // Edge r → s: row r has an entry in the column that is matched to row s.
    let ahead: Vec<Vec<usize>> = columns.iter().map(|cs| cs.iter().map(|&c| row_of[c]).collect()).collect();
    let mut behind = vec![Vec::new(); n];
    for (r, edges) in ahead.iter().enumerate() {
        for &s in edges {
            behind[s].push(r);
        }
    }
    let mut column_of = vec![0; n];
    for (c, &r) in row_of.iter().enumerate() {
        column_of[r] = c;
    }
    let mut placed = vec![false; n];
    let mut blocks = Vec::new();
    for start in 0..n {
        if placed[start] {
            continue;
        }
        let (forward, backward) = (reach(&ahead, start), reach(&behind, start));
        let rows: Vec<usize> = (0..n).filter(|&r| forward[r] && backward[r]).collect();
        let mut cols: Vec<usize> = rows.iter().map(|&r| column_of[r]).collect();
        cols.sort_unstable();
        for &r in &rows {
            placed[r] = true;
        }
        blocks.push(Block { rows, cols });
    }
    Some(blocks)
}

/// Row matched to each column, by augmenting paths.
fn perfect_matching(columns: &[Vec<usize>]) -> Option<Vec<usize>> {
    let n = columns.len();
    let mut row_of: Vec<Option<usize>> = vec![None; n];
    for root in 0..n {
        // Breadth first over rows; `via[c]` is the row from which column c was reached.
        let mut via: Vec<Option<usize>> = vec![None; n];
        let mut queue = std::collections::VecDeque::from([root]);
        let mut free = None;
        while let Some(row) = queue.pop_front() {
            for &c in &columns[row] {
                if via[c].is_some() {
                    continue;
                }
                via[c] = Some(row);
                match row_of[c] {
                    Some(next) => queue.push_back(next),
                    None => free = Some(c),
                }
                if free.is_some() {
                    break;
                }
            }
            if free.is_some() {
                break;
            }
        }
        // Walk the path back, giving each column to the row that reached it.
        let mut column = free?;
        loop {
            let row = via[column]?;
            let given_up = (0..n).find(|&c| row_of[c] == Some(row));
            row_of[column] = Some(row);
            match given_up {
                Some(c) => column = c,
                None => break,
            }
        }
    }
    row_of.into_iter().collect()
}

fn reach(edges: &[Vec<usize>], start: usize) -> Vec<bool> {
    let mut seen = vec![false; edges.len()];
    let mut pending = vec![start];
    seen[start] = true;
    while let Some(node) = pending.pop() {
        for &next in &edges[node] {
            if !seen[next] {
                seen[next] = true;
                pending.push(next);
            }
        }
    }
    seen
}

// ---- equilibrated

/// Cost of a zero: no permutation of entries that are not zero costs as much.
const ABSENT: f64 = 1e6;

/// Ratio of two scales of rows, or of columns, from which on a pencil is graded.
const GRADED: f64 = 1e6;

/// A pencil with the scales of its rows and columns.
pub struct Equilibrated {
    /// A, scaled.
    pub a: Mat<f64>,
    /// B, scaled.
    pub b: Mat<f64>,
    /// Whether rows or columns differed by many decades.
    pub is_graded: bool,
}

impl Equilibrated {
    /// R A C and R B C with powers of two R and C; where the pencil is singular for each x by its zeros, A and B.
    pub fn of(a: &Mat<f64>, b: &Mat<f64>) -> Self {
        let ratio = a.norm_max() / b.norm_max();
        let is_number = ratio.is_finite() && ratio > 0.0;
        Self::weighted(a, b, if is_number { ratio } else { 1.0 })
    }

    /// The same, where an entry has the size of the larger of |a_ij| and `weight` |b_ij|.
    pub fn weighted(a: &Mat<f64>, b: &Mat<f64>, weight: f64) -> Self {
        let n = a.nrows();
        let cost = |i: usize, j: usize| {
            let size = a[(i, j)].abs().max(weight * b[(i, j)].abs());
            if size > 0.0 { -size.log2() } else { ABSENT }
        };
        let Some((rows, columns)) = potentials(n, cost) else {
            return Self { a: a.clone(), b: b.clone(), is_graded: false };
        };
        let whole = |v: Vec<f64>| -> Vec<f64> { v.iter().map(|v| v.round().exp2()).collect() };
        let (rows, columns) = (whole(rows), whole(columns));
        let spread = |v: &[f64]| {
            let most = v.iter().fold(0.0_f64, |m, s| m.max(*s));
            most / v.iter().fold(f64::INFINITY, |m, s| m.min(*s))
        };
        let scaled = |m: &Mat<f64>| Mat::from_fn(n, n, |i, j| m[(i, j)] * rows[i] * columns[j]);
        Self { a: scaled(a), b: scaled(b), is_graded: n > 1 && spread(&rows).max(spread(&columns)) > GRADED }
    }
}

/// u and v with u_i + v_j <= cost_ij, and equality along the cheapest permutation; none where that has to use an
/// absent entry. Successive shortest paths, O(n³).
fn potentials(n: usize, cost: impl Fn(usize, usize) -> f64) -> Option<(Vec<f64>, Vec<f64>)> {
    // Places are counted from 1; 0 stands for the row that looks for a column.
    let (mut u, mut v) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    let mut row_of = vec![0; n + 1];
    for row in 1..=n {
        let mut least = vec![f64::INFINITY; n + 1];
        let (mut used, mut way) = (vec![false; n + 1], vec![0; n + 1]);
        row_of[0] = row;
        let mut column = 0;
        while row_of[column] != 0 {
            used[column] = true;
            let (from, mut next, mut step) = (row_of[column], 0, f64::INFINITY);
            for j in (1..=n).filter(|&j| !used[j]) {
                let reduced = cost(from - 1, j - 1) - u[from] - v[j];
                if reduced < least[j] {
                    (least[j], way[j]) = (reduced, column);
                }
                if least[j] < step {
                    (step, next) = (least[j], j);
                }
            }
            for j in 0..=n {
                if used[j] {
                    u[row_of[j]] += step;
                    v[j] -= step;
                } else {
                    least[j] -= step;
                }
            }
            column = next;
        }
        while column != 0 {
            row_of[column] = row_of[way[column]];
            column = way[column];
        }
    }
    let absent = (1..=n).any(|j| cost(row_of[j] - 1, j - 1) >= ABSENT);
    (!absent).then(|| (u[1..].to_vec(), v[1..].to_vec()))
}

// ---- tolerances

/// Backward error above which an eigenvalue of the QZ algorithm is refused. Backward stability
/// promises a small multiple of `n` ulp; a solver that silently stopped early is far off it.
pub const QZ_BACKWARD_ERROR: f64 = 1e-10;

/// An eigenvalue whose first-order relative uncertainty exceeds this is infinite (or zero) at working precision.
/// Defective infinite eigenvalues of multiplicity m scatter over x ~ eps^(-1/m) with an uncertainty of order
/// 1/m. For QZ the measure is n ulp of the norms, which real finite roots exceed too where K spans many decades:
/// frames of some hundred dofs on soft springs. Such roots are asked again on the matrices, where the measure is
/// an ulp of each entry.
pub const ROOT_UNCERTAINTY: f64 = 1e-3;

/// A root counts as real when its imaginary part is below this fraction of its modulus, or below ten
/// times its uncertainty: repeated real roots come back from QZ as conjugate pairs apart by rounding.
pub const REAL_ROOT: f64 = 1e-9;

/// A double root with one vector comes back from QZ split by the root of rounding, some 1e-8 times the
/// root of its condition; closer than this the two halves, real or complex, are one root.
pub const SPLIT_ROOT: f64 = 3e-7;

/// Roots this close, relatively, count as repeated.
pub const REPEATED_ROOT: f64 = 1e-6;

/// A repeated real root nearer than this to zero or infinity, in the scaled pencil, is dropped: it
/// cannot be told from a cluster of infinite ones.
pub const REPEATED_ROOT_DISTANCE: f64 = 1e-8;

// ---- root_bounds

/// Relative bound in x from which on a root is not certain.
pub const UNCERTAIN: f64 = 1e-3;

/// Most steps of an iteration, and solutions in each.
const STEPS: usize = 8;
const SOLUTIONS: usize = 2;
const MORE_SOLUTIONS: usize = 5;

/// Relative distances from a root at which the pencil is factorized, and from several.
const ON_ROOT: [f64; 3] = [0.0, 4.0 * f64::EPSILON, -16.0 * f64::EPSILON];
const BESIDE_ROOTS: [f64; 3] = [1e-6, -3e-6, 1e-5];

/// Relative distance within which roots are taken together of which one alone has no bound.
const TOGETHER: f64 = 1e-5;

/// Ulps of each product that count, beside one for each row.
const ULPS: f64 = 16.0;

/// Residual of a null vector, relative to the scaled pencil.
const NULL_VECTOR: f64 = 1e-9;

/// Farthest that the root of the matrices may be from the one given, relatively.
const FARTHEST: f64 = 1e-2;

/// Largest number of roots that are taken together.
const MOST_TOGETHER: usize = 60;

/// A pencil whose roots are known.
pub struct RootBounds {
    a: Mat<f64>,
    b: Mat<f64>,
}

/// A root on the matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// Where it is.
    pub x: f64,
    /// How far a root may be from there; infinite where that is not known.
    pub bound: f64,
}

impl RootBounds {
    /// Of the pencil A − xB.
    pub fn of(a: &Mat<f64>, b: &Mat<f64>) -> Self {
        let Equilibrated { a, b, .. } = Equilibrated::of(a, b);
        Self { a, b }
    }

    /// The place of each of `roots`, ascending in x, on the matrices, and how far a root of its own may be from there;
    /// infinite where that is not known.
    pub fn places(&self, roots: &[f64]) -> Vec<Bounded> {
        let places: Vec<Bounded> = roots.iter().map(|&x| self.place(x)).collect();
        let apart = |j: usize| {
            let (p, q) = (places[j], places[j + 1]);
            let apart = if p.bound.is_finite() && q.bound.is_finite() {
                2.0 * (p.bound + q.bound)
            } else {
                TOGETHER * q.x
            };
            q.x - p.x > apart
        };
        let mut out = Vec::with_capacity(roots.len());
        let mut first = 0;
        for last in 0..roots.len() {
            if last + 1 < roots.len() && !apart(last) {
                continue;
            }
            if first == last {
                out.push(places[last]);
            } else {
                out.extend(self.together(&roots[first..=last]));
            }
            first = last + 1;
        }
        out
    }

    /// The root next to `x`.
    fn place(&self, x: f64) -> Bounded {
        let mut at = x;
        for _ in 0..STEPS {
            let Some(block) = self.block(at, 1) else {
                break;
            };
            let slope = block.slope[(0, 0)];
            let (step, bound) = (block.force[(0, 0)] / slope, block.rounding[(0, 0)] / slope.abs());
            at += step;
            // NaN is no root.
            if !((at - x).abs() <= FARTHEST * x && bound <= UNCERTAIN * x) {
                break;
            }
            if step.abs() <= bound {
                if block.residual <= NULL_VECTOR {
                    return Bounded { x: at, bound };
                }
                break;
            }
        }
        Bounded { x, bound: f64::INFINITY }
    }

    /// Roots that lie closer together than their own bounds.
    fn together(&self, roots: &[f64]) -> Vec<Bounded> {
        let m = roots.len();
        let middle = roots.iter().sum::<f64>() / m as f64;
        let radius =
            if m <= MOST_TOGETHER { self.block(middle, m).map(|block| block.radius()) } else { None };
        let radius = radius.filter(|r| *r <= UNCERTAIN * middle).unwrap_or(f64::INFINITY);
        let bounded = |&x: &f64| Bounded { x, bound: radius + (x - middle).abs() };
        roots.iter().map(bounded).collect()
    }

    /// What the `m` vectors next to `x` tell on either side.
    fn block(&self, x: f64, m: usize) -> Option<NullBlock> {
        let n = self.a.nrows();
        // Where x is a root to the last digit, a pivot vanishes; of several roots the farther ones need some distance.
        let nudges = if m == 1 { ON_ROOT } else { BESIDE_ROOTS };
        for nudge in nudges {
            let at = x * (1.0 + nudge);
            let lu = (&self.a - Scale(at) * &self.b).partial_piv_lu();
            let mut right =
                Mat::from_fn(n, m, |i, j| 1.0 + 0.3 * (1.7 * (i + 1) as f64 * (j + 1) as f64).sin());
            let mut left = right.clone();
            for round in 0..(if m == 1 { SOLUTIONS } else { MORE_SOLUTIONS }) {
                if m > 1 && round > 0 {
                    right = &self.b * &right;
                    left = self.b.transpose() * &left;
                }
                right = lu.solve(&right);
                orthonormalize(&mut right);
                left = lu.solve_transpose(&left);
                orthonormalize(&mut left);
            }
            let finite = |a: &Mat<f64>| a.norm_l2().is_finite();
            if !(finite(&right) && finite(&left)) {
                continue;
            }
            let shifted = &self.a - Scale(x) * &self.b;
            let image = &shifted * &right;
            let inertia = &self.b * &right;
            let force = left.transpose() * &image;
            let slope = left.transpose() * &inertia;
            let known = slope.partial_piv_lu().solve(&force);
            let sizes = Mat::from_fn(n, n, |i, j| self.a[(i, j)].abs() + x.abs() * self.b[(i, j)].abs());
            let rounding = Scale((ULPS + n as f64) * f64::EPSILON) * (&sizes * modulus(&right));
            // Of two roots in one, the vectors are a mixture: what they leave over tells.
            let left_over = modulus(&(&image - &inertia * &known));
            return Some(NullBlock {
                rounding: modulus(&left).transpose() * (rounding + left_over),
                residual: image.norm_l2() / sizes.norm_l2(),
                force,
                slope,
            });
        }
        None
    }
}

fn modulus(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs())
}

/// Projections of the pencil on its null vectors.
struct NullBlock {
    /// Yᵀ(A − xB)V.
    force: Mat<f64>,
    /// YᵀBV.
    slope: Mat<f64>,
    /// c eps |Y|ᵀ(|A| + x|B|)|V| + |Y|ᵀ|(A − xB)V − BV G⁻¹E|.
    rounding: Mat<f64>,
    /// ‖(A − xB)V‖ relative to the pencil.
    residual: f64,
}

impl NullBlock {
    /// How far from x all roots of the block are; NaN where their vectors do not tell.
    fn radius(&self) -> f64 {
        let m = self.slope.nrows();
        let inverse = self.slope.partial_piv_lu().solve(Mat::<f64>::identity(m, m));
        let known = &inverse * &self.force;
        let error = modulus(&inverse) * &self.rounding;
        let sizes = modulus(&known);
        let widened = &sizes + &error;
        let (mut power, mut least, mut most) = (known.clone(), sizes.clone(), widened.clone());
        let mut radius = f64::NAN;
        for p in 1..=m {
            let whole = power.norm_l2() + (&most - &least).norm_l2();
            radius = radius.min(whole.powf(1.0 / p as f64));
            power = &power * &known;
            least = &least * &sizes;
            most = &most * &widened;
        }
        radius
    }
}

/// Gram-Schmidt, twice.
fn orthonormalize(vectors: &mut Mat<f64>) {
    for j in 0..vectors.ncols() {
        for _ in 0..2 {
            for p in 0..j {
                let part: f64 = vectors.col(p).transpose() * vectors.col(j);
                for i in 0..vectors.nrows() {
                    vectors[(i, j)] -= part * vectors[(i, p)];
                }
            }
            let size = vectors.col(j).norm_l2().recip();
            for i in 0..vectors.nrows() {
                vectors[(i, j)] *= size;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangular_pencil_falls_into_single_entries() {
        let a = Mat::from_fn(4, 4, |r, c| f64::from(u8::from(r >= c)));
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(4, 4).as_ref()).unwrap();
        assert_eq!(blocks.len(), 4);
        assert!(blocks.iter().all(|b| b.rows == b.cols && b.rows.len() == 1));
    }

    #[test]
    fn a_cycle_is_irreducible_and_an_empty_row_is_singular() {
        let a = Mat::from_fn(5, 5, |r, c| f64::from(u8::from(c == (r + 1) % 5 || c == r)));
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(5, 5).as_ref()).unwrap();
        assert_eq!(blocks.len(), 1);
        let singular = Mat::from_fn(3, 3, |r, _| if r == 1 { 0.0 } else { 1.0 });
        assert_eq!(irreducible_blocks(singular.as_ref(), singular.as_ref()), None);
    }

    #[test]
    fn a_row_gives_its_column_up_for_another() {
        let rows = [[0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let a = Mat::from_fn(3, 3, |r, c| rows[r][c]);
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(3, 3).as_ref()).unwrap();
        let columns: Vec<_> = blocks.iter().map(|b| b.cols.clone()).collect();
        assert_eq!(columns, [[2], [1], [0]]);
    }

    #[test]
    fn a_weak_link_on_which_the_determinant_hangs_becomes_one() {
        // Two rows share the first two columns but for 1e-18: no scale of rows by their largest entries finds it.
        let weak = 2.0_f64.powi(-60);
        let rows = [[1.0, 2.0, 0.0], [1.0, 2.0, weak], [weak, 3.0, 1.0]];
        let a = Mat::from_fn(3, 3, |i, j| if (i, j) == (1, 1) { 0.0 } else { rows[i][j] });
        let scaled = Equilibrated::of(&a, &Mat::zeros(3, 3));
        assert!(scaled.a.norm_max() <= 2.0);
        let at_least = |v: f64| v.abs() > 0.2;
        for i in 0..3 {
            assert!((0..3).any(|j| at_least(scaled.a[(i, j)])));
            assert!((0..3).any(|j| at_least(scaled.a[(j, i)])));
        }
    }

    #[test]
    fn units_are_taken_out() {
        let d = [1e-9, 1.0, 1e12];
        let a = Mat::from_fn(3, 3, |i, j| d[i] * d[j] * (1.0 + (i + 2 * j) as f64 % 3.0));
        let scaled = Equilibrated::of(&a, &a);
        assert!(scaled.is_graded);
        for i in 0..3 {
            for j in 0..3 {
                assert!((0.05..=4.0).contains(&scaled.a[(i, j)]), "{}", scaled.a[(i, j)]);
            }
        }
    }

    #[test]
    fn zeros_that_leave_no_permutation_leave_all_as_it_is() {
        let a = Mat::from_fn(3, 3, |i, _| if i == 1 { 0.0 } else { 1e12 });
        let scaled = Equilibrated::of(&a, &a);
        assert!(!scaled.is_graded && scaled.a == a);
        let empty = Mat::<f64>::zeros(0, 0);
        assert!(!Equilibrated::of(&empty, &empty).is_graded);
    }

    fn bounds_of(a: &Mat<f64>, b: &Mat<f64>, roots: &[f64]) -> Vec<Bounded> {
        RootBounds::of(a, b).places(roots)
    }

    #[test]
    fn a_simple_root_is_placed_and_bounded() {
        let a = Mat::from_fn(3, 3, |i, j| [[2.0, 1.0, 0.0], [0.0, 5.0, 1.0], [0.0, 0.0, 9.0]][i][j]);
        let identity = Mat::<f64>::identity(3, 3);
        for (given, want) in [(2.0 + 1e-9, 2.0), (5.0, 5.0), (9.0 - 1e-5, 9.0)] {
            let placed = bounds_of(&a, &identity, &[given])[0];
            assert!((placed.x - want).abs() <= placed.bound);
            assert!(placed.bound < 1e-12, "{placed:?}");
        }
    }

    #[test]
    fn where_there_is_no_root_there_is_no_bound() {
        // Roots 1 and a complex pair.
        let a = Mat::from_fn(3, 3, |i, j| [[1.0, 0.0, 0.0], [0.0, 4.0, 1.0], [0.0, -1.0, 4.0]][i][j]);
        let identity = Mat::<f64>::identity(3, 3);
        for x in [4.0, 2.5, 30.0] {
            assert!(bounds_of(&a, &identity, &[x])[0].bound.is_infinite());
        }
    }

    #[test]
    fn a_double_root_is_bounded_by_its_vectors() {
        let identity = Mat::<f64>::identity(3, 3);
        for (coupling, least, most) in [(0.0, 0.0, 1e-13), (1.0, 1e-9, 1e-6)] {
            let rows = [[4.0, coupling, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 7.0]];
            let a = Mat::from_fn(3, 3, |i, j| rows[i][j]);
            let both = bounds_of(&a, &identity, &[4.0, 4.0]);
            for placed in both {
                assert!((placed.x - 4.0).abs() <= placed.bound);
                assert!(least < placed.bound && placed.bound < most, "{placed:?}");
            }
        }
    }
}
