//! The response to several forces, exact to rounding up to a limit, from one Krylov space.
//!
//! ```text
//! H e_k = u_k + s (1 − s A⁻¹M)⁻¹ A⁻¹M u_k,           u_k = A⁻¹e_k,  A = K + σM,  s = x + σ
//!       = u_k + s Q (1 − sT)⁻¹ g_k,                  T = QᵀM A⁻¹M Q,  g_k = QᵀM A⁻¹M u_k
//!       = u_k + s Σ_j (Q y_j) (y_jᵀg_k / θ_j) / (λ_j − x),      T y = θ y,  λ = 1/θ − σ
//! ```
//!
//! Q is an M-orthonormal basis of what A⁻¹M makes of the A⁻¹M u_k, vector by vector, each orthogonalized against
//! all before it. Poles up to the limit are the modes that the forces move; that these are all, but for those given as
//! hidden, is what [`ReducedModes`](super::reduced::ReducedModes) has proved. Those above stand for all other modes
//! together. With any responses they make a [`MinorSeries`].

use super::minor::{Each, MinorSeries};
use super::scaled::ScaledMatrices;
use crate::linalg::krylov::project_out;
use crate::linalg::symmetric::SmallSymmetric;
use crate::linalg::wide::dot;

/// What is left of the response, relative to all of it, when the space is large enough; and at which parts of s.
const NEGLIGIBLE: f64 = 1e-16;
const SAMPLES: [f64; 4] = [1.0, 0.913, 0.719, 0.531];

/// A next vector this small, relative to what it was orthogonalized from, is rounding.
const INVARIANT: f64 = 1e-13;

/// Vectors between two questions whether it is.
const MORE: usize = 4;

/// θ, relative to the largest, of which nothing is left.
const TOO_STIFF: f64 = 1e-14;

/// Residual, relative to θ, of a pole that is a mode; part of it in the forces, relative to the largest, below which
/// a pole is rounding; relative distance within which two are one.
const FOUND: f64 = 1e-6;
const UNSEEN: f64 = 1e-11;
const ONE: f64 = 1e-6;

/// The space of some forces, with the memory to grow it again.
#[derive(Default)]
pub(super) struct SeveralForces {
    n: usize,
    stride: usize,
    sigma: f64,
    limit: f64,
    /// u_k, and g_k as far as it is not zero.
    columns: Vec<f64>,
    start: Vec<Vec<f64>>,
    /// Q, M Q, and the columns of T, each to its last entry below the diagonal.
    basis: Vec<f64>,
    weighted: Vec<f64>,
    t: Vec<Vec<f64>>,
    small: SmallSymmetric,
    /// λ and y_jᵀg_k / θ_j of the poles, y_j of all of them row by row, and λ of the modes that no force moves.
    poles: Vec<(f64, Each)>,
    ways: Vec<f64>,
    hidden: Vec<f64>,
}

impl SeveralForces {
    /// Grows the space of the forces on `rows`; `matrices` hold the factors of K + σM, and `modes` are the eigenvalues
    /// of all modes up to the limit. False where the space does not come to those.
    pub fn grow(
        &mut self,
        matrices: &ScaledMatrices,
        rows: &[usize],
        (sigma, limit): (f64, f64),
        modes: &[f64],
    ) -> bool {
        (self.n, self.stride, self.sigma, self.limit) = (matrices.n(), matrices.stride(), sigma, limit);
        for memory in [&mut self.columns, &mut self.basis, &mut self.weighted] {
            memory.clear();
        }
        // What is mostly enough.
        for memory in [&mut self.basis, &mut self.weighted] {
            memory.reserve(self.stride * (2 * modes.len() + 8 * rows.len()));
        }
        self.start.clear();
        self.t.clear();
        let mut sizes = Vec::new();
        let (mut w, mut weighted) = (vec![0.0; self.stride], vec![0.0; self.stride]);
        for &row in rows {
            w.fill(0.0);
            w[row] = 1.0;
            matrices.solve(&mut w);
            self.columns.extend_from_slice(&w);
            matrices.mass.multiply(&w, &mut weighted);
            weighted[self.n..].fill(0.0);
            sizes.push(dot(&w, &weighted).sqrt());
            w.copy_from_slice(&weighted);
            matrices.solve(&mut w);
            let part = self.append(matrices, &mut w);
            self.start.push(part);
        }
        let mut enough = self.n;
        loop {
            let (p, count) = (self.t.len(), self.basis.len() / self.stride);
            let last = p == count || p >= enough;
            let asked = p > modes.len() + rows.len() && p % MORE == 0;
            if last || asked && self.error(p, &sizes) <= NEGLIGIBLE {
                if self.decompose(p) && self.tell_modes(p, rows.len(), modes) {
                    return true;
                }
                if last {
                    return false;
                }
                // Modes of nearly one frequency come apart late.
                enough = enough.min(2 * p);
            }
            w.copy_from_slice(&self.weighted[p * self.stride..(p + 1) * self.stride]);
            matrices.solve(&mut w);
            let column = self.append(matrices, &mut w);
            self.t.push(column);
        }
    }

    /// Takes from w its part in the basis, and appends what is left, if anything; all coefficients.
    fn append(&mut self, matrices: &ScaledMatrices, w: &mut [f64]) -> Vec<f64> {
        let stride = self.stride;
        let count = self.basis.len() / stride;
        let mut coefficients = vec![0.0; count];
        let before = dot(w, w);
        let mut parts = Vec::with_capacity(count + 1);
        for _ in 0..2 {
            project_out(w, &self.weighted, &self.basis, &mut parts);
            coefficients.iter_mut().zip(&parts).for_each(|(all, part)| *all += part);
        }
        let mut weighted = vec![0.0; stride];
        matrices.mass.multiply(w, &mut weighted);
        weighted[self.n..].fill(0.0);
        let size = dot(w, &weighted).sqrt();
        if size > 0.0 && dot(w, w).sqrt() > INVARIANT * before.sqrt() && count < self.n {
            let scale = size.recip();
            self.basis.extend(w.iter().map(|a| a * scale));
            self.weighted.extend(weighted.iter().map(|a| a * scale));
            coefficients.push(size);
        }
        coefficients
    }

    /// Entry of T, row not above column, or of g.
    fn entry(column: &[f64], at: usize) -> f64 {
        column.get(at).copied().unwrap_or(0.0)
    }

    /// ‖C y‖, C the rows of T beyond the first `p`: what they leave over.
    fn left_over(&self, p: usize, y: &[f64]) -> f64 {
        let count = self.basis.len() / self.stride;
        let row = |q: usize| (0..p).map(|j| Self::entry(&self.t[j], q) * y[j]).sum::<f64>();
        (p..count).map(|q| row(q).powi(2)).sum::<f64>().sqrt()
    }

    /// What the first `p` vectors leave of the response up to the limit, relative to all of it.
    fn error(&self, p: usize, sizes: &[f64]) -> f64 {
        let mut worst = 0.0_f64;
        let (mut l, mut d) = (vec![0.0; p * p], vec![0.0; p]);
        for s in SAMPLES.map(|c| c * (self.limit + self.sigma)) {
            // 1 − sT = L D Lᵀ, with as many entries beside the diagonal as there are forces, all others rounding; a
            // pivot that happens to be small makes the error too large, if anything.
            let band = |i: usize| i.saturating_sub(sizes.len());
            for i in 0..p {
                for j in band(i)..=i {
                    let own = f64::from(u8::from(i == j)) - s * Self::entry(&self.t[i], j);
                    let done: f64 = (band(i)..j).map(|c| l[i * p + c] * l[j * p + c] * d[c]).sum();
                    if i == j {
                        d[i] = own - done;
                    } else {
                        l[i * p + j] = (own - done) / d[j];
                    }
                }
            }
            for (g, size) in self.start.iter().zip(sizes) {
                let mut y: Vec<f64> = (0..p).map(|i| Self::entry(g, i)).collect();
                for i in 0..p {
                    y[i] -= (band(i)..i).map(|c| l[i * p + c] * y[c]).sum::<f64>();
                }
                (0..p).for_each(|i| y[i] /= d[i]);
                for i in (0..p).rev() {
                    y[i] -= (i + 1..p.min(i + 1 + sizes.len())).map(|r| l[r * p + i] * y[r]).sum::<f64>();
                }
                let left = s * s * self.left_over(p, &y) / size;
                worst = if left.is_nan() { f64::INFINITY } else { worst.max(left) };
            }
            if worst > NEGLIGIBLE {
                return worst;
            }
        }
        worst
    }

    /// Eigenvalues and eigenvectors of T of the first `p` vectors.
    fn decompose(&mut self, p: usize) -> bool {
        let Self { small, t, .. } = self;
        p == 0 || small.solve(p, |i, j| Self::entry(&t[i], j))
    }

    /// Takes over the poles; false where one up to the limit is neither a mode nor rounding.
    fn tell_modes(&mut self, p: usize, forces: usize, modes: &[f64]) -> bool {
        self.poles.clear();
        let mut places = Vec::new();
        self.hidden = modes.to_vec();
        let theta = |j: usize| self.small.pair(j).0;
        let stiffest = if p > 0 { TOO_STIFF * theta(p - 1) } else { 0.0 };
        let strength = |j: usize, k: usize| -> f64 {
            let (theta, y) = self.small.pair(j);
            self.start[k].iter().zip(y).map(|(g, y)| g * y).sum::<f64>() / (theta * theta)
        };
        let least = (self.limit + self.sigma).recip();
        let inside: Vec<usize> = (0..p).rev().take_while(|&j| theta(j) >= least).collect();
        let strongest: Vec<f64> =
            (0..forces).map(|k| inside.iter().fold(0.0, |m: f64, &j| m.max(strength(j, k).abs()))).collect();
        for j in (0..p).rev().filter(|&j| theta(j) > stiffest) {
            let (theta, y) = self.small.pair(j);
            let lambda = theta.recip() - self.sigma;
            let mut gamma = Each::default();
            (0..forces).for_each(|k| gamma[k] = strength(j, k) * theta);
            if theta >= least {
                let found = self.left_over(p, y) <= FOUND * theta;
                let seen = (0..forces).any(|k| strength(j, k).abs() > UNSEEN * strongest[k]);
                if !found && seen {
                    return false;
                }
                let distance = |other: f64| (other - lambda).abs();
                let own = (0..self.hidden.len())
                    .min_by(|&a, &b| distance(self.hidden[a]).total_cmp(&distance(self.hidden[b])))
                    .filter(|&a| distance(self.hidden[a]) <= ONE * (lambda.abs() + self.sigma));
                match own {
                    Some(own) => {
                        self.hidden.swap_remove(own);
                    }
                    None if seen => return false,
                    None => {}
                }
                if own.is_none() || !found {
                    // A hidden mode that rounding brings in: it counts among those, or not at all.
                    self.hidden.extend(own.map(|_| lambda));
                    continue;
                }
            }
            self.poles.push((lambda, gamma));
            places.push(j);
        }
        self.ways.clear();
        for q in 0..p {
            self.ways.extend(places.iter().map(|&j| self.small.pair(j).1[q]));
        }
        true
    }

    /// The series between responses on `rows` and the forces; eigenvalues up to `zero` are zero.
    pub fn series(&self, rows: &[usize], zero: f64, series: &mut MinorSeries) {
        series.begin(rows.len(), self.n, Some(self.sigma), self.limit);
        for (i, &row) in rows.iter().enumerate() {
            for (k, u) in self.columns.chunks_exact(self.stride).enumerate() {
                series.constant[i][k] = u[row];
            }
        }
        let mut parts: Vec<(f64, Each, Each)> = Vec::new();
        let mut psi = vec![Each::default(); self.poles.len()];
        let mut sums = vec![0.0; psi.len()];
        for (i, &row) in rows.iter().enumerate() {
            sums.fill(0.0);
            let basis = self.basis.iter().skip(row).step_by(self.stride);
            for (q, ways) in basis.zip(self.ways.chunks_exact(psi.len().max(1))) {
                sums.iter_mut().zip(ways).for_each(|(sum, y)| *sum += y * q);
            }
            psi.iter_mut().zip(&sums).for_each(|(psi, sum)| psi[i] = *sum);
        }
        parts.extend(self.poles.iter().zip(psi).map(|(&(lambda, gamma), psi)| (lambda, psi, gamma)));
        parts.extend(self.hidden.iter().map(|&lambda| (lambda, Each::default(), Each::default())));
        for part in &mut parts {
            part.0 = if part.0.abs() <= zero { 0.0 } else { part.0 };
        }
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (lambda, psi, gamma) in parts {
            series.add(lambda, psi, gamma);
        }
        series.end();
    }
}
