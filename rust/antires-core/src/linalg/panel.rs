//! Four vectors side by side made orthonormal, W = Q B with QᵀMQ = I: Cholesky factors of WᵀMW until they are
//! those of I.
//!
//! ```text
//! W ← W − V VᵀMW,   WᵀMW = RᵀR,   W ← W R⁻¹,   B ← R B
//! ```
//!
//! Where the vectors are all but dependent the first pass leaves them far from orthogonal; any regular R keeps the
//! product, so small pivots are raised, and another pass mends what is left.
//!
//! Reference: Fukaya, Kannan, Nakatsukasa, Yamamoto & Yanagisawa, SIAM J. Sci. Comput. 42 (2020) A477-A503.

use super::sparse::several::{Filled, Row, take};
use super::wide::{self, COLUMNS, LANES, NullaryFnOnce};

/// A small matrix, column after column.
pub type Square = [[f64; LANES]; LANES];

/// Pivots below this, relative to the diagonal, are raised to it.
const LEAST_PIVOT: f64 = 1e-13;

/// Pivot relative to the diagonal from which on a pass is not asked to look at V again.
const CLEAR_PIVOT: f64 = 1e-6;

/// Distance from orthogonality that one correction brings to rounding.
const NEARLY: f64 = 1e-8;

/// Most passes.
const MOST_PASSES: usize = 12;

/// Makes `w` orthonormal in `mass` and orthogonal to the vectors of `outside`, one after the other; `weighted` becomes
/// M times it. Returns B; none where they cannot be made so.
pub fn orthonormalize(
    w: &mut [Row],
    weighted: &mut [Row],
    mass: &Filled,
    outside: &[f64],
) -> Option<Square> {
    let mut b = identity();
    let mut look = true;
    for pass in 0..MOST_PASSES {
        mass.multiply(w, weighted);
        let (a, c) = (&*w, &*weighted);
        let mut gram = wide::run(Gram { a, b: c });
        let mut far = 0.0_f64;
        let looked = look && !outside.is_empty();
        if looked {
            let taken = wide::run(ProjectOut {
                w,
                weighted,
                vectors: outside,
            });
            far = taken.iter().flatten().fold(0.0, |m, t| m.max(t.abs()));
            for t in &taken {
                for c in 0..LANES {
                    for r in 0..LANES {
                        gram[c][r] -= t[r] * t[c];
                    }
                }
            }
        }
        for c in 0..LANES {
            for r in 0..LANES {
                let of_unit = f64::from(u8::from(r == c && gram[c][c] > 0.0));
                far = far.max((gram[c][r] - of_unit).abs());
            }
        }
        if !far.is_finite() {
            return None;
        }
        let (root, least) = root(&gram);
        b = product(&root, &b);
        wide::run(Divide {
            rows: w,
            root: &root,
        });
        let done = pass > 0 && far <= NEARLY;
        if done && looked {
            mass.multiply(w, weighted);
        } else if done {
            wide::run(Divide {
                rows: weighted,
                root: &root,
            });
        }
        if done {
            return Some(b);
        }
        look = least < CLEAR_PIVOT;
    }
    None
}

/// I.
#[must_use]
pub fn identity() -> Square {
    let mut identity = Square::default();
    for c in 0..LANES {
        identity[c][c] = 1.0;
    }
    identity
}

/// A B.
#[must_use]
pub fn product(a: &Square, b: &Square) -> Square {
    let entry = |r: usize, c: usize| (0..LANES).map(|q| a[q][r] * b[c][q]).sum();
    std::array::from_fn(|c| std::array::from_fn(|r| entry(r, c)))
}

/// Aᵀ.
#[must_use]
pub fn transposed(a: &Square) -> Square {
    std::array::from_fn(|c| std::array::from_fn(|r| a[r][c]))
}

/// R of G = RᵀR and its least pivot relative to the diagonal; vectors of which nothing is left stay as they are.
fn root(gram: &Square) -> (Square, f64) {
    let (mut root, mut least) = (Square::default(), 1.0_f64);
    for c in 0..LANES {
        let own = gram[c][c];
        if !(own > 0.0) {
            root[c][c] = 1.0;
            continue;
        }
        let known: f64 = (0..c).map(|q| root[c][q].powi(2)).sum();
        least = least.min((own - known) / own);
        let pivot = (own - known).max(LEAST_PIVOT * own).sqrt();
        root[c][c] = pivot;
        for r in c + 1..LANES {
            let known: f64 = (0..c).map(|q| root[c][q] * root[r][q]).sum();
            root[r][c] = (gram[r][c] - known) / pivot;
        }
    }
    (root, least)
}

/// AᵀB.
pub struct Gram<'a> {
    /// A.
    pub a: &'a [Row],
    /// B.
    pub b: &'a [Row],
}

impl NullaryFnOnce for Gram<'_> {
    type Output = Square;

    #[inline(always)]
    fn call(self) -> Square {
        // rows[r] is row r of the product.
        let mut rows = Square::default();
        for (a, b) in self.a.iter().zip(self.b) {
            for r in 0..LANES {
                take(&mut rows[r], -a[r], b);
            }
        }
        transposed(&rows)
    }
}

/// W ← W − V C.
pub struct Take<'a> {
    /// W.
    pub w: &'a mut [Row],
    /// The rows of V.
    pub v: &'a [Row],
    /// C.
    pub by: &'a Square,
}

impl NullaryFnOnce for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let rows = transposed(self.by);
        for (w, v) in self.w.iter_mut().zip(self.v) {
            for q in 0..LANES {
                take(w, v[q], &rows[q]);
            }
        }
    }
}

/// W ← W R⁻¹, row by row.
struct Divide<'a> {
    rows: &'a mut [Row],
    root: &'a Square,
}

impl NullaryFnOnce for Divide<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let inverse: Row = std::array::from_fn(|c| self.root[c][c].recip());
        for row in self.rows {
            for c in 0..LANES {
                for q in 0..c {
                    row[c] -= row[q] * self.root[c][q];
                }
                row[c] *= inverse[c];
            }
        }
    }
}

/// W ← W − V VᵀMW; returns VᵀMW, row by row.
struct ProjectOut<'a> {
    w: &'a mut [Row],
    weighted: &'a [Row],
    /// V, column after column.
    vectors: &'a [f64],
}

impl NullaryFnOnce for ProjectOut<'_> {
    type Output = Vec<Row>;

    #[inline(always)]
    fn call(self) -> Vec<Row> {
        let n = self.w.len();
        let mut all = Vec::with_capacity(self.vectors.len() / n);
        // The columns come in whole groups.
        for group in self.vectors.chunks_exact(n * COLUMNS) {
            let v: [&[f64]; COLUMNS] = std::array::from_fn(|q| &group[q * n..][..n]);
            let mut sums = [[0.0; LANES]; COLUMNS];
            for (r, weighted) in self.weighted[..n].iter().enumerate() {
                for q in 0..COLUMNS {
                    take(&mut sums[q], -v[q][r], weighted);
                }
            }
            all.extend(sums);
        }
        for (group, sums) in self
            .vectors
            .chunks_exact(n * COLUMNS)
            .zip(all.chunks(COLUMNS))
        {
            let v: [&[f64]; COLUMNS] = std::array::from_fn(|q| &group[q * n..][..n]);
            for (r, w) in self.w.iter_mut().enumerate() {
                for q in 0..COLUMNS {
                    take(w, v[q][r], &sums[q]);
                }
            }
        }
        all
    }
}
