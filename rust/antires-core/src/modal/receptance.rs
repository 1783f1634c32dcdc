//! One receptance as partial fractions: H_ik(x) = Σ c_r / (λ_r − x) + d.
//!
//! Of a Krylov space it is that over a factor without roots, H_ik(x) = (x + σ) Σ c_r / (λ_r − x), with a first
//! pole at −σ whose residue is −H_ik(−σ): exact there, and small rounding from poles far above.
//!
//! Eigenvalues that coincide at working precision share one pole, whose residue is the sum over
//! their eigenspace (the parts depend on the basis, the sum does not). A pole whose residue is below
//! 1e-12 of the largest is not seen by i or k: the mode has a node there, the FRF
//! shows neither peak nor dip, and the pencil has a root on it, a *cancelled* one.

use crate::linalg::symmetric::SymmetricSolver;

/// Below this fraction of the largest residue a pole is cancelled. Measured gap: residues that
/// vanish by symmetry come out below 1e-16, all others above 1e-8.
const NEGLIGIBLE_RESIDUE: f64 = 1e-12;

/// Largest residue, relative to |φ_i||φ_k|, at which the whole receptance is zero at working precision.
const IDENTICALLY_ZERO: f64 = 1e-14;

/// Multiple of its error from which on the sign of a residue is certain.
const SURE_RESIDUE: f64 = 16.0;

/// Eigenvalues closer than this many times their uncertainty are repeated.
const REPEATED: f64 = 32.0;

/// Ulps to be expected in a sum over `n` dofs: each its own at most, of many their random walk.
pub(super) fn ulps(n: usize) -> f64 {
    (n as f64).min(16.0 * (n as f64).sqrt())
}

/// Partial fractions of one receptance.
#[derive(Debug, Clone, Default)]
pub struct Receptance {
    /// Poles λ seen by both dofs, strictly ascending, after those that are no modes.
    pub poles: Vec<f64>,
    /// Number of poles at the beginning that are no modes: one or none, at −σ.
    pub beside: usize,
    /// Residues φ_i φ_k, one a pole.
    pub residues: Vec<f64>,
    /// Constant part, from massless directions.
    pub constant: f64,
    /// Eigenvalues at which the deleted pencil has a root that cancels, ascending, with multiplicity.
    pub cancelled: Vec<f64>,
    /// Absolute error to be expected of one residue.
    pub residue_error: f64,
    /// Absolute error of the part of H that stands for the poles far above, and of the constant.
    pub floor_error: f64,
    /// Residue below which a pole is cancelled.
    pub negligible: f64,
    /// True when nothing of H_ik is left at working precision.
    pub is_zero: bool,
    /// Upper bound of the number of roots, cancelled ones too, if known.
    pub most_roots: Option<usize>,
}

/// What the residues alone tell of the roots between neighbouring poles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// All of one sign: H is monotone between poles.
    OneSign,
    /// Poles of one sign have one root between them, others none, and there is no root elsewhere.
    Counted,
    /// Nothing.
    Open,
}

impl Receptance {
    /// Forms the partial fractions between dofs `i` and `k` from a solved eigenproblem.
    pub fn form(&mut self, solver: &SymmetricSolver, i: usize, k: usize) {
        let (lambda, phi) = (&solver.eigenvalues, &solver.vectors);
        let n = phi.nrows();
        self.clear();
        let (mut size_i, mut size_k) = (0.0_f64, 0.0_f64);
        for r in 0..lambda.len() {
            let (a, b) = (phi[(i, r)], phi[(k, r)]);
            size_i = size_i.max(a.abs());
            size_k = size_k.max(b.abs());
            self.add(lambda[r], a * b, REPEATED * solver.uncertainty(lambda[r].abs()));
        }
        self.constant = (lambda.len()..n).map(|r| phi[(i, r)] * phi[(k, r)]).sum();
        if lambda.len() < n {
            self.floor_error = ulps(n) * f64::EPSILON * solver.static_size(i, k);
            if self.constant.abs() <= self.floor_error {
                (self.constant, self.floor_error) = (0.0, 0.0);
            }
        }
        self.finish(n, self.poles.len(), (size_i, size_k));
    }

    /// Empties the partial fractions.
    pub fn clear(&mut self) {
        self.poles.clear();
        self.residues.clear();
        self.cancelled.clear();
        (self.constant, self.floor_error, self.beside) = (0.0, 0.0, 0);
        self.most_roots = None;
    }

    /// Largest modulus of the residues of the poles up to `limit`.
    pub fn largest_residue(&self, limit: f64) -> f64 {
        let poles = self.poles.iter().zip(&self.residues);
        let below = poles.take_while(|(l, _)| **l <= limit);
        below.map(|(_, c)| c.abs()).fold(0.0, f64::max)
    }

    /// Begins with the pole at −σ of a response of `known` there.
    pub fn begin(&mut self, sigma: f64, known: f64) {
        self.poles.push(-sigma);
        self.residues.push(-known);
        self.beside = 1;
    }

    /// Adds a mode, λ ascending; within `repeated` of the last it shares its pole.
    pub fn add(&mut self, lambda: f64, residue: f64, repeated: f64) {
        match (self.poles.last(), self.residues.last_mut()) {
            (Some(&pole), Some(c)) if lambda - pole <= repeated => {
                // The eigenspace adds m − 1 roots on the pole, whatever its residue.
                self.cancelled.push(pole);
                *c += residue;
            }
            _ => {
                self.poles.push(lambda);
                self.residues.push(residue);
            }
        }
    }

    /// Sets the cancelled ones of the lowest `modes` poles aside, those that are no modes counted; the others stand for modes far above.
    /// `size_i` and `size_k` are the largest entries of the modes at the two dofs.
    pub fn finish(&mut self, n: usize, modes: usize, (size_i, size_k): (f64, f64)) {
        let scale = size_i * size_k;
        let of = if modes == 0 { self.poles.len() } else { modes };
        let largest = self.residues[self.beside..of].iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        self.residue_error = ulps(n) * f64::EPSILON * scale;
        self.is_zero = largest <= IDENTICALLY_ZERO * scale && self.constant == 0.0;
        self.negligible = NEGLIGIBLE_RESIDUE * largest;
        self.drop_negligible(modes);
    }

    /// Sets the poles up to `limit` aside whose residues are below `factor` times the bar so far.
    pub fn raise_bar(&mut self, factor: f64, limit: f64) {
        self.negligible *= factor;
        self.drop_negligible(self.poles.partition_point(|&l| l <= limit));
    }

    fn drop_negligible(&mut self, modes: usize) {
        let mut kept = 0;
        for r in 0..self.poles.len() {
            if (self.beside..modes).contains(&r) && self.residues[r].abs() <= self.negligible {
                self.cancelled.push(self.poles[r]);
            } else {
                self.poles[kept] = self.poles[r];
                self.residues[kept] = self.residues[r];
                kept += 1;
            }
        }
        self.poles.truncate(kept);
        self.residues.truncate(kept);
        self.cancelled.sort_by(f64::total_cmp);
    }

    /// Looks at the signs of the residues. Between neighbours of one sign lies an odd number of roots, so
    /// as many pairs of them as there are roots at most leave none for elsewhere.
    pub fn pattern(&self) -> Pattern {
        let of_modes = &self.residues[self.beside..];
        if of_modes.iter().all(|c| c * of_modes[0] > 0.0) {
            return Pattern::OneSign;
        }
        let sure = |c: &f64| c.abs() > SURE_RESIDUE * self.residue_error;
        match self.most_roots {
            Some(most) if self.cancelled.is_empty() && self.residues.iter().all(sure) => {
                let pairs = self.residues.windows(2).filter(|c| c[0] * c[1] > 0.0);
                if pairs.count() == most { Pattern::Counted } else { Pattern::Open }
            }
            _ => Pattern::Open,
        }
    }

    /// Whether H falls off to zero far above its poles.
    pub fn falls_off(&self) -> bool {
        self.constant == 0.0 && self.beside == 0
    }

    /// H at x.
    pub fn value(&self, x: f64) -> f64 {
        self.poles.iter().zip(&self.residues).map(|(l, c)| c / (l - x)).sum::<f64>() + self.constant
    }

    /// dH/dx at x.
    pub fn slope(&self, x: f64) -> f64 {
        self.poles.iter().zip(&self.residues).map(|(l, c)| c / ((l - x) * (l - x))).sum()
    }

    /// Rounding error of H at x, and dH/dx.
    pub fn noise_and_slope(&self, x: f64) -> (f64, f64) {
        let (mut reach, mut slope) = (0.0, 0.0);
        for (l, c) in self.poles.iter().zip(&self.residues) {
            let s = (l - x).recip();
            reach += s.abs();
            slope += c * s * s;
        }
        (self.residue_error * reach + self.floor_error, slope)
    }
}
