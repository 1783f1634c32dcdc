//! The response of K − xM to one load, from a Krylov space: exact low poles and a few that stand for the rest.
//!
//! With σ > 0, A = K + σM and s = x + σ the response to a load e is u(x) = (K − xM)⁻¹ e =
//! (I − s A⁻¹M)⁻¹ A⁻¹e. Lanczos in the inner product of M, started at q_1 = A⁻¹e / β_0, gives
//! A⁻¹M Q = Q T + β q_{p+1} e_pᵀ with T tridiagonal, and with T = Y Θ Yᵀ
//!
//! ```text
//! u(x) ≈ β_0 Q (I − sT)⁻¹ e_1 = β_0 Σ_j (Q y_j) y_1j / (1 − s θ_j)
//! u(x) − that = s β y_p(s) (I − s A⁻¹M)⁻¹ q_{p+1},      y_p(s) = β_0 [(I − sT)⁻¹]_p1
//! ```
//!
//! These are partial fractions with poles λ_j = 1/θ_j − σ. The low ones are the modes that the load excites;
//! the high ones match p moments of all other modes: they are the residual series of the classical modal
//! method, summed. The identity for the error is exact, and y_p is a product of p factors that costs nothing
//! to follow, so the space grows until the error is below rounding everywhere up to a given x.
//!
//! Summed as it stands, the poles far above leave their rounding: they are large, and all but cancel. What they
//! are at x = −σ is known by itself, a = A⁻¹e, and beside it they are small:
//!
//! ```text
//! u(x) = a + s Σ_j c_j / (λ_j − x),       c_j = β_0 (Q y_j) y_1j
//! ```
//!
//! M may be singular. Then a has a part without mass, for which the inner product of M is blind, and the space
//! starts from A⁻¹M a instead: u(x) = a + s (I − s A⁻¹M)⁻¹ A⁻¹M a, of the same form with c_j over θ_j.
//!
//! A space of *four vectors at a time* starts from W = A⁻¹M [a, r_1, r_2, r_3] = Q_1 C, r fixed pseudo-random
//! numbers: the factors are read once for four, and modes that the load does not excite come with it. T is then
//! block tridiagonal, A⁻¹M Q = Q T + Q_{p+1} B Eᵀ, and
//!
//! ```text
//! u(x) ≈ a + s Q (I − sT)⁻¹ C e_1 = a + s Σ_j (Q y_j) g_j / (1 − sθ_j),    g_j = (C e_1)ᵀ y_j
//! u(x) − that = s² (I − s A⁻¹M)⁻¹ Q_{p+1} B Eᵀ (I − sT)⁻¹ C e_1
//! ```
//!
//! It has half as many vectors again, and a third as many readings of the factors, which is what large ones cost.
//! Its vectors are made orthonormal, W = Q B with QᵀMQ = I, by Cholesky factors of WᵀMW until they are those of I:
//!
//! ```text
//! W ← W − V VᵀMW,   WᵀMW = RᵀR,   W ← W R⁻¹,   B ← R B
//! ```
//!
//! Where the vectors are all but dependent the first pass leaves them far from orthogonal; any regular R keeps the
//! product, so small pivots are raised, and another pass mends what is left.
//!
//! The start depends on the load alone: the same matrices give the same bits whatever was solved before.
//!
//! References: Ericsson & Ruhe, Math. Comp. 35 (1980) 1251-1268 (shift and invert); Boley, Circuits Syst.
//! Signal Process. 13 (1994) 733-758 (Lanczos and moments); Grimes, Lewis & Simon, SIAM J. Matrix Anal.
//! Appl. 15 (1994) 228-272 (count of the modes by inertia); Golub & Underwood, in Mathematical Software III, 1977,
//! 361-377 (blocks); Fukaya, Kannan, Nakatsukasa, Yamamoto & Yanagisawa, SIAM J. Sci. Comput. 42 (2020) A477-A503.

use super::factors::{Factors, Filled, Form, Row, SparseFactors, take};
use super::sparse::SparseMatrix;
use super::symmetric::{StandardSymmetric, decompose_tridiagonal};
use super::wide::{COLUMNS, LANES, dot, subtract, widest};

/// Error of the response relative to its start at which the space is large enough.
const NEGLIGIBLE_ERROR: f64 = 1e-17;

/// Fractions of the highest s at which the error is followed. Unlike one another, so that a pole of the
/// approximation near one of them does not hide in all.
const SAMPLES: [f64; 6] = [1.0, 0.967, 0.913, 0.836, 0.719, 0.531];

/// A next vector this small, relative to what it was orthogonalized from, is rounding: the space is
/// invariant.
const INVARIANT: f64 = 1e-14;

/// Vectors between two questions whether the space is settled.
const MORE: usize = 8;

/// Lanczos vectors, one or four at a time, and the poles they give, with the memory to do it again.
#[derive(Debug, Clone, Default)]
pub struct Krylov {
    /// Vectors that are added at a time: one, or [`LANES`].
    width: usize,
    n: usize,
    /// Rows of a stored vector: n and the padding of [`Form`].
    stride: usize,
    /// q_j, and of single ones M q_j, one after the other.
    basis: Vec<f64>,
    weighted: Vec<f64>,
    /// T of single vectors.
    alpha: Vec<f64>,
    beta: Vec<f64>,
    coefficients: Vec<f64>,
    /// Diagonal blocks of T and those below them, the last of which is B.
    diagonal: Vec<Square>,
    below: Vec<Square>,
    /// Eigenvalues of T, θ_j = 1 / (λ_j + σ), descending.
    pub theta: Vec<f64>,
    /// The eigenvectors in the same order, p rows each.
    ritz: Vec<f64>,
    kind: Start,
    /// What the space starts from in the first vectors: β_0, or C.
    start: Square,
    /// A⁻¹e: the response at x = −σ.
    pub response: Vec<f64>,
}

/// What a space starts from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Start {
    /// A⁻¹e: all directions have a mass.
    #[default]
    Response,
    /// A⁻¹M A⁻¹e, A⁻¹e kept aside: some may have none, see the module.
    Remainder,
}

/// What a Krylov space is grown in: A = K + σM factorized, M, and vectors to stay orthogonal to.
#[derive(Clone, Copy)]
pub struct Operator<'a> {
    /// Factors of A.
    pub shifted: &'a Factors,
    /// M.
    pub mass: &'a Form,
    /// M v of each vector v that is kept out, one after the other, and the vectors.
    pub outside: (&'a [f64], &'a [f64]),
}

impl Krylov {
    fn begin(&mut self, width: usize, n: usize, stride: usize, kind: Start) {
        (self.width, self.n, self.stride, self.kind) = (width, n, stride, kind);
        self.basis.clear();
        self.weighted.clear();
        self.alpha.clear();
        self.beta.clear();
        self.diagonal.clear();
        self.below.clear();
    }

    /// Grows the space of A⁻¹ times `load`, from `start`, until the error is negligible for all x + σ up to `s_max` and
    /// `settled` says so, for which it may come to twice the size, or until `most` vectors. False when the latter, or a
    /// failure of the small eigenproblem, comes before the error is negligible.
    #[must_use]
    pub fn grow(
        &mut self,
        op: Operator<'_>,
        (load, start): (&[f64], Start),
        s_max: f64,
        most: usize,
        settled: impl Fn(&Self) -> bool,
    ) -> bool {
        self.begin(1, op.mass.n(), op.mass.n() + op.mass.padding(), start);
        let mut w = load.to_vec();
        op.shifted.solve(&mut w);
        self.response.clone_from(&w);
        if start == Start::Remainder {
            op.mass.multiply(&self.response, &mut w);
            w[self.n..].fill(0.0);
            op.shifted.solve(&mut w);
        }
        self.keep_out(op, &mut w);
        self.start[0][0] = self.append(op, &w);
        if self.start[0][0] == 0.0 {
            return false;
        }
        // δ_j = det T_j(s) / det T_(j−1)(s), and the product that y_p is.
        let mut ratio = [1.0; SAMPLES.len()];
        let mut product = [1.0; SAMPLES.len()];
        // Vectors at which it is asked again, and at which it is enough, once the error is negligible.
        let mut asked: Option<(usize, usize)> = None;
        loop {
            let j = self.alpha.len();
            w.copy_from_slice(&self.weighted[j * self.stride..(j + 1) * self.stride]);
            op.shifted.solve(&mut w);
            let size = self.orthogonalize(op, &mut w);
            let beta = self.append(op, &w);
            let mut error = 0.0_f64;
            for (c, (ratio, product)) in SAMPLES.iter().zip(ratio.iter_mut().zip(&mut product)) {
                let s = c * s_max;
                let coupling = if j == 0 { 0.0 } else { s * self.beta[j - 1] };
                *ratio = 1.0 - s * self.alpha[j] - coupling * coupling / *ratio;
                *product *= if j == 0 { 1.0 } else { coupling } / *ratio;
                error = error.max((s * beta * *product).abs());
            }
            let invariant = beta <= INVARIANT * size;
            self.beta.push(beta);
            // NaN, from a sample on a pole, keeps the space growing.
            let negligible = error <= NEGLIGIBLE_ERROR || asked.is_some();
            let (next, enough) = asked.unwrap_or((j, 2 * j));
            let last = invariant || j + 1 >= most;
            if invariant || negligible && (last || j >= next) {
                let decomposed = self.decompose_single();
                if !decomposed || last || j >= enough || settled(self) {
                    return decomposed;
                }
                asked = Some((j + MORE, enough));
            } else if last {
                return false;
            }
        }
    }

    /// Appends w / ‖w‖ and M w / ‖w‖; returns ‖w‖ = √(wᵀMw).
    fn append(&mut self, op: Operator<'_>, w: &[f64]) -> f64 {
        let at = self.basis.len();
        self.basis.extend_from_slice(w);
        self.weighted.resize(at + self.stride, 0.0);
        let mw = &mut self.weighted[at..];
        op.mass.multiply(w, mw);
        mw[self.n..].fill(0.0);
        let norm = dot(w, mw).max(0.0).sqrt();
        if norm > 0.0 {
            let inverse = norm.recip();
            self.basis[at..].iter_mut().for_each(|x| *x *= inverse);
            self.weighted[at..].iter_mut().for_each(|x| *x *= inverse);
        }
        norm
    }

    /// Takes from w its part in the space, appends the diagonal entry of T, and returns the size of w before.
    fn orthogonalize(&mut self, op: Operator<'_>, w: &mut [f64]) -> f64 {
        let (j, stride) = (self.alpha.len(), self.stride);
        let at = j * stride;
        // The three-term recurrence first; the pass over all vectors then finds rounding only.
        if j > 0 {
            subtract(w, self.beta[j - 1], &self.basis[at - stride..at]);
        }
        let alpha = dot(w, &self.weighted[at..at + stride]);
        subtract(w, alpha, &self.basis[at..at + stride]);
        self.keep_out(op, w);
        project_out(w, &self.weighted, &self.basis, &mut self.coefficients);
        self.alpha.push(alpha + self.coefficients[j]);
        alpha.abs() + if j > 0 { self.beta[j - 1] } else { 0.0 }
    }

    fn keep_out(&mut self, op: Operator<'_>, w: &mut [f64]) {
        let (weighted, vectors) = op.outside;
        let coefficients = &mut self.coefficients;
        if !vectors.is_empty() {
            project_out(w, weighted, vectors, coefficients);
        }
    }

    /// Grows the space of the load on row `k` four vectors at a time, the other starts on the rows that are `joined` to
    /// it, until the error is negligible for all x + σ up to `s_max` and `settled` says so. False where `most` vectors
    /// do not do.
    #[must_use]
    pub fn grow_block(
        &mut self,
        (shifted, mass): (&SparseFactors, &SparseMatrix),
        (k, joined): (usize, impl Fn(usize) -> bool),
        s_max: f64,
        most: usize,
        settled: impl Fn(&Self) -> bool,
    ) -> bool {
        let (n, mass) = (mass.n(), &Filled::of(mass));
        self.begin(LANES, n, n, Start::Remainder);
        self.response.clear();
        self.response.resize(n, 0.0);
        self.response[k] = 1.0;
        shifted.solve(&mut self.response);
        let mut mq = vec![Row::default(); n];
        let mut q = self.starts(joined);
        mass.multiply(&q, &mut mq);
        q.copy_from_slice(&mq);
        shifted.solve_several(&mut q);
        let Some(start) = orthonormalize(&mut q, &mut mq, mass, &[]) else {
            return false;
        };
        self.start = start;
        let mut samples = Vec::new();
        let (mut before, mut w) = (Vec::new(), vec![Row::default(); n]);
        while self.basis.len() + LANES * n <= most * n {
            for c in 0..LANES {
                self.basis.extend(q.iter().map(|row| row[c]));
            }
            w.copy_from_slice(&mq);
            shifted.solve_several(&mut w);
            let own = gram(&mq, &w);
            let other = transposed(&own);
            let own: Square =
                std::array::from_fn(|c| std::array::from_fn(|r| 0.5 * (own[c][r] + other[c][r])));
            take_product(&mut w, &q, &own);
            if let Some(coupling) = self.below.last() {
                take_product(&mut w, &before, &transposed(coupling));
            }
            let Some(next) = orthonormalize(&mut w, &mut mq, mass, &self.basis) else {
                return false;
            };
            self.diagonal.push(own);
            self.below.push(next);
            before.clone_from(&q);
            std::mem::swap(&mut q, &mut w);
            if self.block_error(&mut samples, s_max) <= NEGLIGIBLE_ERROR
                && self.decompose_blocks()
                && settled(self)
            {
                return true;
            }
        }
        false
    }

    /// a and three columns of pseudo-random numbers.
    fn starts(&self, joined: impl Fn(usize) -> bool) -> Vec<Row> {
        let mut random = pseudo_random();
        let row = |(row, &a): (usize, &f64)| {
            if joined(row) { [a, random(), random(), random()] } else { Row::default() }
        };
        self.response.iter().enumerate().map(row).collect()
    }

    /// Largest error of the response, relative to its start; `samples` hold the inverse and the part of the last block
    /// of (I − sT)⁻¹ C at each s, from block to block.
    fn block_error(&self, samples: &mut Vec<(Square, Square)>, s_max: f64) -> f64 {
        let j = self.diagonal.len() - 1;
        let size = norm(&self.start[0]);
        let mut worst = 0.0_f64;
        for (q, part) in SAMPLES.iter().enumerate() {
            let s = part * s_max;
            let mut pivot = identity();
            let mut last = self.start;
            if let Some((inverse, before)) = samples.get(q) {
                let coupling = &self.below[j - 1];
                let through = product(coupling, inverse);
                let back = product(&through, &transposed(coupling));
                subtract(pivot.as_flattened_mut(), s * s, back.as_flattened());
                last = product(coupling, before);
                last.as_flattened_mut().iter_mut().for_each(|x| *x *= s);
            }
            subtract(pivot.as_flattened_mut(), s, self.diagonal[j].as_flattened());
            let inverse = inverse(pivot);
            let last = product(&inverse, &last);
            let error = s * norm(&product(&self.below[j], &last)[0]) / size;
            // NaN, from a sample on a pole, keeps the space growing.
            worst = if error <= worst { worst } else { error };
            if q < samples.len() {
                samples[q] = (inverse, last);
            } else {
                samples.push((inverse, last));
            }
        }
        worst
    }

    /// T = Y Θ Yᵀ of single vectors, in the order of ascending λ: θ descending, the negative ones (rounding) last.
    fn decompose_single(&mut self) -> bool {
        let p = self.alpha.len();
        let mut vectors = vec![0.0; p * p];
        for j in 0..p {
            vectors[j * p + j] = 1.0;
        }
        let (mut off, mut values) = (self.beta.clone(), self.alpha.clone());
        if !decompose_tridiagonal(&mut values, &mut off, &mut vectors, p) {
            return false;
        }
        let mut order: Vec<usize> = (0..p).collect();
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        self.theta = order.iter().map(|&j| values[j]).collect();
        self.ritz.clear();
        for &j in &order {
            self.ritz.extend_from_slice(&vectors[j * p..(j + 1) * p]);
        }
        true
    }

    /// The same of blocks.
    fn decompose_blocks(&mut self) -> bool {
        let p = LANES * self.diagonal.len();
        let mut solver = StandardSymmetric::new(p);
        let t = &mut solver.matrix;
        for (j, (own, below)) in self.diagonal.iter().zip(&self.below).enumerate() {
            let at = j * LANES;
            for c in 0..LANES {
                for r in 0..LANES {
                    t[(at + r, at + c)] = own[c][r];
                    if at + LANES < p {
                        t[(at + LANES + r, at + c)] = below[c][r];
                    }
                }
            }
        }
        if solver.decompose().is_err() {
            return false;
        }
        self.theta = solver.values.iter().rev().copied().collect();
        self.ritz.clear();
        for j in (0..p).rev() {
            self.ritz.extend(solver.vectors.col_as_slice(j));
        }
        true
    }

    fn y(&self, j: usize) -> &[f64] {
        let p = self.theta.len();
        &self.ritz[j * p..(j + 1) * p]
    }

    /// Part of the start in y_j.
    fn own(&self, j: usize) -> f64 {
        if self.width == 1 {
            self.start[0][0] * self.y(j)[0]
        } else {
            dot(&self.start[0], &self.y(j)[..LANES])
        }
    }

    /// Part of the load in y_j, over θ_j: c_j = that (Q y_j)_i.
    pub fn strength(&self, j: usize) -> f64 {
        match self.kind {
            Start::Response => self.own(j),
            // A pole without θ is so far above that nothing is left of it.
            Start::Remainder if self.theta[j] == 0.0 => 0.0,
            Start::Remainder => self.own(j) / self.theta[j],
        }
    }

    /// Modulus of the part of the start in y_j, over the size of the start.
    pub fn first(&self, j: usize) -> f64 {
        if self.width == 1 { self.y(j)[0].abs() } else { (self.own(j) / norm(&self.start[0])).abs() }
    }

    /// Residual ‖A⁻¹M v − θ v‖ of v = Q y_j.
    pub fn residual(&self, j: usize) -> f64 {
        let (y, p) = (self.y(j), self.theta.len());
        if self.width == 1 {
            return (self.beta[p - 1] * y[p - 1]).abs();
        }
        let last = &y[p - LANES..];
        self.below.last().map_or(0.0, |b| {
            let row = |r: usize| (0..LANES).map(|c| b[c][r] * last[c]).sum();
            norm(&std::array::from_fn(row))
        })
    }

    /// Entry i of every Q y_j, into `out`.
    pub fn row(&self, i: usize, out: &mut Vec<f64>) {
        let p = self.theta.len();
        let q: Vec<f64> = (0..p).map(|r| self.basis[r * self.stride + i]).collect();
        out.clear();
        out.extend(self.ritz.chunks_exact(p).map(|y| dot(&q, y)));
    }

    /// Appends v = Q y_j and M v.
    pub fn vector(&self, j: usize, mass: &Form, weighted: &mut Vec<f64>, vectors: &mut Vec<f64>) {
        let (n, at) = (self.stride, vectors.len());
        vectors.resize(at + n, 0.0);
        weighted.resize(at + n, 0.0);
        let (v, mv) = (&mut vectors[at..], &mut weighted[at..]);
        for (r, &y) in self.y(j).iter().enumerate() {
            subtract(v, -y, &self.basis[r * n..(r + 1) * n]);
            if self.width == 1 {
                subtract(mv, -y, &self.weighted[r * n..(r + 1) * n]);
            }
        }
        if self.width > 1 {
            mass.multiply(v, mv);
        }
    }
}

/// Fixed numbers between −0.5 and 0.5: the 64-bit congruential generator of Knuth, MMIX.
pub fn pseudo_random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

widest!(
    /// Takes from w its part in the vectors V, with `weighted` = M V and VᵀMV = I, vector after vector; `coefficients`
    /// become VᵀMw.
    pub fn project_out(w: &mut [f64], weighted: &[f64], vectors: &[f64], coefficients: &mut Vec<f64>) {
        let stride = w.len();
        coefficients.clear();
        for v in weighted.chunks_exact(stride) {
            coefficients.push(dot(w, v));
        }
        for (v, &c) in vectors.chunks_exact(stride).zip(coefficients.iter()) {
            subtract(w, c, v);
        }
    }
);

fn norm(a: &Row) -> f64 {
    dot(a, a).sqrt()
}

/// A⁻¹ by Gauss and Jordan on the columns, with the largest pivot of each row; not finite where there is none.
fn inverse(mut a: Square) -> Square {
    let mut inverse = identity();
    for c in 0..LANES {
        let best = (c..LANES).max_by(|&p, &q| a[p][c].abs().total_cmp(&a[q][c].abs()));
        let best = best.unwrap_or(c);
        a.swap(c, best);
        inverse.swap(c, best);
        let pivot = a[c][c].recip();
        a[c].iter_mut().for_each(|x| *x *= pivot);
        inverse[c].iter_mut().for_each(|x| *x *= pivot);
        let (own, done) = (a[c], inverse[c]);
        for r in (0..LANES).filter(|&r| r != c) {
            let by = a[r][c];
            subtract(&mut a[r], by, &own);
            subtract(&mut inverse[r], by, &done);
        }
    }
    inverse
}

/// A small matrix, column after column.
type Square = [[f64; LANES]; LANES];

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
fn orthonormalize(w: &mut [Row], weighted: &mut [Row], mass: &Filled, outside: &[f64]) -> Option<Square> {
    let mut b = identity();
    let mut look = true;
    for pass in 0..MOST_PASSES {
        mass.multiply(w, weighted);
        let mut gram = gram(w, weighted);
        let mut far = 0.0_f64;
        let looked = look && !outside.is_empty();
        if looked {
            let taken = project_out_rows(w, weighted, outside);
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
        divide(w, &root);
        let done = pass > 0 && far <= NEARLY;
        if done && looked {
            mass.multiply(w, weighted);
        } else if done {
            divide(weighted, &root);
        }
        if done {
            return Some(b);
        }
        look = least < CLEAR_PIVOT;
    }
    None
}

/// I.
fn identity() -> Square {
    let mut identity = Square::default();
    for c in 0..LANES {
        identity[c][c] = 1.0;
    }
    identity
}

/// A B.
fn product(a: &Square, b: &Square) -> Square {
    let entry = |r: usize, c: usize| (0..LANES).map(|q| a[q][r] * b[c][q]).sum();
    std::array::from_fn(|c| std::array::from_fn(|r| entry(r, c)))
}

/// Aᵀ.
fn transposed(a: &Square) -> Square {
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

widest!(
    /// AᵀB.
    fn gram(a: &[Row], b: &[Row]) -> Square {
        // rows[r] is row r of the product.
        let mut rows = Square::default();
        for (a, b) in a.iter().zip(b) {
            for r in 0..LANES {
                take(&mut rows[r], -a[r], b);
            }
        }
        transposed(&rows)
    }
);

widest!(
    /// W ← W − V C.
    fn take_product(w: &mut [Row], v: &[Row], by: &Square) {
        let rows = transposed(by);
        for (w, v) in w.iter_mut().zip(v) {
            for q in 0..LANES {
                take(w, v[q], &rows[q]);
            }
        }
    }
);

widest!(
    /// W ← W R⁻¹, row by row.
    fn divide(rows: &mut [Row], root: &Square) {
        let inverse: Row = std::array::from_fn(|c| root[c][c].recip());
        for row in rows {
            for c in 0..LANES {
                for q in 0..c {
                    row[c] -= row[q] * root[c][q];
                }
                row[c] *= inverse[c];
            }
        }
    }
);

widest!(
    /// W ← W − V VᵀMW with V column after column; returns VᵀMW, row by row.
    fn project_out_rows(w: &mut [Row], weighted: &[Row], vectors: &[f64]) -> Vec<Row> {
        let n = w.len();
        let mut all = Vec::with_capacity(vectors.len() / n);
        // The columns come in whole groups.
        for group in vectors.chunks_exact(n * COLUMNS) {
            let v: [&[f64]; COLUMNS] = std::array::from_fn(|q| &group[q * n..][..n]);
            let mut sums = [[0.0; LANES]; COLUMNS];
            for (r, weighted) in weighted[..n].iter().enumerate() {
                for q in 0..COLUMNS {
                    take(&mut sums[q], -v[q][r], weighted);
                }
            }
            all.extend(sums);
        }
        for (group, sums) in vectors.chunks_exact(n * COLUMNS).zip(all.chunks(COLUMNS)) {
            let v: [&[f64]; COLUMNS] = std::array::from_fn(|q| &group[q * n..][..n]);
            for (r, w) in w.iter_mut().enumerate() {
                for q in 0..COLUMNS {
                    take(w, v[q][r], &sums[q]);
                }
            }
        }
        all
    }
);
