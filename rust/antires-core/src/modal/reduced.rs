//! Poles of one excitation up to a limit, from factors of K − xM, with the proof that none is missing.
//!
//! 1. A Krylov space of the load gives H_ik for every i as partial fractions that are exact to rounding below
//!    the limit (`poles`).
//! 2. By Sylvester's law the inertia of K − xM counts all modes below the limit. Each of the poles found has
//!    a residual far below its distance from the next, so if there are as many, they are the modes.
//! 3. If there are more modes than poles, the load does not excite the others: a node at the excitation, or
//!    a repeated eigenvalue, of which any load excites one combination only. They are sought in the
//!    complement of those found until the count is met (`hidden_modes`).
//!
//! What cannot be settled so is left to the dense solver.
//! ```text
//! H_ik(x) = H_ik(−σ) + (x + σ) Σ_j c_ij / (λ_j − x),    c_ij = φ_ij φ_kj θ_j,  λ_j = 1/θ_j − σ
//! ```
//!
//! Poles up to the limit are the modes that the load excites; those far above stand for all other modes together
//! ([`Krylov`]). A space is *settled* if its poles are those of the modes, also where two of them nearly coincide. The
//! load is answered for before that: of two modes of nearly one frequency, as structures that are nearly square or
//! symmetric have them, the space holds a mixture, and the second enters by rounding, and late. With residuals r of
//! two poles whose θ differ by d the mixture is r / d, and what the two together have for θ is off by r² over the
//! distance of the next.
//!
//! Reference: Parlett, The Symmetric Eigenvalue Problem, SIAM 1998, sections 11.5 and 11.7.

use std::sync::Arc;

use super::columns::{Columns, ReceptanceAt};
use super::minor::{Ends, MinorSeries};
use super::receptance::Receptance;
use super::scaled::{ScaledMatrices, Scope};
use super::several::SeveralForces;
use super::structure::{MOST_DENSE, Structure};
use crate::linalg::factors::{Factors, Form};
use crate::linalg::krylov::{Krylov, Operator, Start, pseudo_random};
use crate::linalg::sparse::SparseMatrix;

/// Shift σ as a fraction of the limit in x. A small one separates the poles best, a large one keeps the
/// digits of the lowest: at one tenth the digits of λ are lost to (λ + σ)/σ, eleven at most.
const SHIFT: f64 = 0.1;

/// Largest share of the modes below the limit for which a part of them costs less than all.
const MOST_MODES: f64 = 0.35;

/// Places of the count above the limit, as parts of the margin.
const CUTS: [f64; 5] = [0.0, 0.37, 0.61, 0.84, 0.99];

/// Distance of the count from the next pole, in rounding errors of the count.
const CLEAR: f64 = 10.0;

/// Least relative distance of the count from a pole.
const ON_THE_LIMIT: f64 = 1e-8;

/// Modes and pseudo-modes as seen by one excitation.
pub struct ReducedModes {
    matrices: ScaledMatrices,
    /// What the Krylov spaces start from, once it is known whether all directions have a mass.
    start: Option<Start>,
    poles: Poles,
    hidden: HiddenModes,
    columns: Columns,
    last: Option<Attempt>,
    several: SeveralForces,
    /// Forces and limit of the last space of several, and whether it was found.
    last_several: Option<(Vec<usize>, f64, bool)>,
}

/// What was last asked of the matrices.
#[derive(Clone, Copy)]
struct Attempt {
    excitation: usize,
    limit: f64,
    scope: Scope,
    succeeded: bool,
}

impl ReducedModes {
    /// Reserves the memory.
    pub fn new(structure: Arc<Structure>) -> Self {
        Self {
            start: None,
            matrices: ScaledMatrices::new(structure),
            poles: Poles::default(),
            hidden: HiddenModes::default(),
            columns: Columns::default(),
            last: None,
            several: SeveralForces::default(),
            last_several: None,
        }
    }

    /// Takes K and M.
    pub fn set_matrices(&mut self, k: &SparseMatrix, m: &SparseMatrix) {
        self.matrices.set(k, m);
        (self.last, self.start, self.last_several) = (None, None, None);
    }

    /// K and M, ordered and scaled.
    pub fn matrices(&mut self) -> &mut ScaledMatrices {
        &mut self.matrices
    }

    /// H_ik at `x` on the matrices, or what a minor has for it; none where rounding spoils the factors of K − xM.
    pub fn receptance_at(&mut self, ends: &Ends, x: f64) -> Option<ReceptanceAt> {
        self.columns.receptance(&mut self.matrices, ends, x)
    }

    /// Columns i and k of (K − xM)⁻¹ by dof, each up to a factor, into `left` and `right`, or of a minor the
    /// combinations of columns that its null vectors make; returns leftᵀ M right, none where rounding spoils the
    /// factors of K − xM.
    pub fn columns(&mut self, ends: &Ends, x: f64, left: &mut Vec<f64>, right: &mut Vec<f64>) -> Option<f64> {
        self.columns.by_dof(&mut self.matrices, ends, x, left, right)
    }

    /// Finds the poles up to `limit` of the excitation, and all other modes of the whole structure if those are
    /// asked for; false where the dense solver has to.
    pub fn solve(&mut self, excitation: usize, limit: f64, whole: bool) -> bool {
        let row = self.matrices.structure.row(excitation);
        let scope = if whole { Scope::Whole } else { Scope::PartOf(row) };
        let same = |last: &Attempt| last.excitation == excitation && last.limit == limit;
        let serves = |last: &Attempt| last.scope == scope || last.scope == Scope::Whole;
        if let Some(last) = self.last.filter(|last| same(last) && serves(last)) {
            return last.succeeded;
        }
        let succeeded = self.try_solve(row, limit, scope);
        self.last = Some(Attempt { excitation, limit, scope, succeeded });
        succeeded
    }

    /// Finds the response to several forces up to `limit`, and the number of modes up to there; false where the dense
    /// solver has to.
    pub fn solve_several(&mut self, forces: &[usize], limit: f64) -> bool {
        if let Some((_, _, found)) = self.last_several.as_ref().filter(|(f, l, _)| f == forces && *l == limit)
        {
            return *found;
        }
        let found = self.solve(forces[0], limit, true) && {
            let mut modes = self.poles.modes();
            modes.extend(&self.hidden.lambda);
            modes.retain(|&lambda| lambda <= limit);
            let rows: Vec<usize> = forces.iter().map(|&dof| self.matrices.structure.row(dof)).collect();
            let sigma = self.poles.sigma;
            self.matrices.shift(sigma) && self.several.grow(&self.matrices, &rows, (sigma, limit), &modes)
        };
        self.last_several = Some((forces.to_vec(), limit, found));
        found
    }

    /// The series between some responses and the forces of the last [`solve_several`](Self::solve_several).
    pub fn series(&self, responses: &[usize], series: &mut MinorSeries) {
        let rows: Vec<usize> = responses.iter().map(|&dof| self.matrices.structure.row(dof)).collect();
        self.several.series(&rows, self.poles.zero, series);
    }

    fn try_solve(&mut self, row: usize, limit: f64, scope: Scope) -> bool {
        let n = self.matrices.n();
        let start = *self.start.get_or_insert_with(|| {
            if self.matrices.mass_is_definite() { Start::Response } else { Start::Remainder }
        });
        let few = |c| n > MOST_DENSE || c as f64 <= MOST_MODES * n as f64;
        if !few(self.matrices.count_below(limit, scope).0) {
            return false;
        }
        let sigma = SHIFT * limit;
        self.matrices.shift(sigma)
            && self.poles.find(&self.matrices, (sigma, limit), (row, start))
            && self.complete(limit, scope)
    }

    /// A place at the limit or just above it, away from all poles, and the number of modes below it.
    fn count(&mut self, limit: f64, scope: Scope) -> Option<(f64, usize)> {
        CUTS.iter().find_map(|c| {
            let cut = (1.0 + c * MARGIN) * limit;
            let distances = self.poles.lambda().map(|pole| (pole - cut).abs());
            let room = distances.fold(cut, f64::min);
            let (count, error) = self.matrices.count_below(cut, scope);
            (CLEAR * error <= room && room > ON_THE_LIMIT * cut).then_some((cut, count))
        })
    }

    /// Meets the count of modes below the limit.
    fn complete(&mut self, limit: f64, scope: Scope) -> bool {
        self.hidden.clear();
        let Some((cut, count)) = self.count(limit, scope) else {
            return false;
        };
        let shown = self.poles.count((cut + self.poles.sigma).recip());
        if count <= shown {
            return count == shown;
        }
        self.matrices.shift(self.poles.sigma);
        self.hidden.find(&self.matrices, &self.poles, cut, count - shown)
    }

    /// The modes up to the limit of the last [`solve`](Self::solve), ascending, and their mass-normalised shapes
    /// by dof.
    pub fn modes(&mut self, lambda: &mut Vec<f64>, shapes: &mut Vec<f64>) {
        let (n, stride) = (self.matrices.n(), self.matrices.stride());
        let limit = self.last.map_or(0.0, |last| last.limit);
        let mut values = self.poles.modes();
        values.extend(&self.hidden.lambda);
        let zero = self.poles.zero;
        let vectors = if self.hidden.lambda.is_empty() {
            let modes: Vec<usize> = (0..self.poles.found.len()).filter(|&j| self.poles.found[j]).collect();
            self.poles.vectors(&self.matrices, modes.into_iter())
        } else {
            &self.hidden.vectors
        };
        let mut order: Vec<usize> = (0..values.len()).filter(|&j| values[j] <= limit).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        lambda.clear();
        shapes.clear();
        for j in order {
            let value = values[j];
            lambda.push(if value.abs() <= zero { 0.0 } else { value });
            let at = shapes.len();
            shapes.resize(at + n, 0.0);
            self.matrices.by_dof(&vectors[j * stride..j * stride + n], &mut shapes[at..]);
        }
    }

    /// Rounding error of the poles near x: that of Θ.
    pub fn pole_error(&self, x: f64) -> f64 {
        self.poles.error(x)
    }

    /// Eigenvalues and roots below this are zero at working precision.
    pub fn zero(&self) -> f64 {
        self.poles.zero
    }

    /// Forms the partial fractions between dof `i` and the excitation of the last [`solve`](Self::solve).
    pub fn form(&mut self, i: usize, h: &mut Receptance) {
        let (n, row) = (self.matrices.n(), self.matrices.structure.row(i));
        self.poles.form(n, row, &self.hidden.lambda, h);
    }
}

/// The poles are told up to this part above the limit, for the count to find a clear place.
const MARGIN: f64 = 0.02;

/// Values of the factors from which on a block costs no more than the load alone. It also has up to four modes of
/// one frequency, as square structures do, which leave the count of modes open otherwise.
const LARGE: usize = 20_000;

/// Response at x = −σ, relative to the largest, below which nothing is left of it.
const NOTHING: f64 = 1e-14;

/// Rounding errors of Θ within which two poles are one.
const REPEATED: f64 = 32.0;

/// Most rigid-body modes a structure has.
const RIGID: usize = 6;

/// The poles of one load, with the memory to find them again.
#[derive(Default)]
struct Poles {
    space: Krylov,
    sigma: f64,
    limit: f64,
    /// Eigenvalues below this are zero at working precision.
    zero: f64,
    /// For each pole up to the limit and its margin: whether it is a mode.
    found: Vec<bool>,
    repeated: Vec<f64>,
    weighted: Vec<f64>,
    vectors: Vec<f64>,
    row: Vec<f64>,
}

impl Poles {
    /// Finds the poles up to `limit` of a load on row `k`; `matrices` hold the factors of K + σM. False where
    /// one of them is neither a mode nor rounding.
    fn find(
        &mut self,
        matrices: &ScaledMatrices,
        (sigma, limit): (f64, f64),
        (k, start): (usize, Start),
    ) -> bool {
        (self.limit, self.sigma) = (limit, sigma);
        let highest = self.highest();
        let least = highest.recip();
        let settled = |space: &Krylov| settled(space, least);
        if !self.grow(matrices, (k, start), highest, settled) || !self.classify(matrices) {
            return false;
        }
        self.tell_repeated(matrices);
        true
    }

    /// Grows the space of the load, where the factors are large four vectors at a time.
    fn grow(
        &mut self,
        matrices: &ScaledMatrices,
        (k, start): (usize, Start),
        highest: f64,
        settled: impl Fn(&Krylov) -> bool,
    ) -> bool {
        let (n, mass) = (matrices.n(), &matrices.mass);
        if let (Factors::Sparse(_, factors), Form::Sparse(mass)) = (&matrices.factors, mass)
            && factors.symbolic.n_values() >= LARGE
        {
            let part = |row: usize| matrices.structure.part(row);
            let joined = |row: usize| part(row) == part(k);
            if self.space.grow_block((factors, mass), (k, joined), highest, n, &settled) {
                return true;
            }
        }
        let mut load = vec![0.0; matrices.stride()];
        load[k] = 1.0;
        let op = Operator { shifted: &matrices.factors, mass, outside: (&[], &[]) };
        self.space.grow(op, (&load, start), highest, n, settled)
    }

    /// Largest s = x + σ for which the response is exact.
    fn highest(&self) -> f64 {
        (1.0 + MARGIN) * self.limit + self.sigma
    }

    /// λ of all poles, ascending.
    fn lambda(&self) -> impl Iterator<Item = f64> {
        self.space.theta.iter().map(|&t| self.pole(t))
    }

    /// Number of modes with θ of at least `least`.
    fn count(&self, least: f64) -> usize {
        let poles = self.space.theta.iter().zip(&self.found);
        poles.filter(|(t, f)| **t >= least && **f).count()
    }

    /// Eigenvalues of the modes, ascending.
    fn modes(&self) -> Vec<f64> {
        let modes = self.lambda().zip(&self.found).filter(|(_, f)| **f);
        modes.map(|(l, _)| l).collect()
    }

    /// Vectors of some poles by rows, one after the other.
    fn vectors(&mut self, matrices: &ScaledMatrices, poles: impl Iterator<Item = usize>) -> &[f64] {
        self.weighted.clear();
        self.vectors.clear();
        for j in poles {
            self.space.vector(j, &matrices.mass, &mut self.weighted, &mut self.vectors);
        }
        &self.vectors
    }

    /// Rounding error of the poles near x: that of Θ.
    fn error(&self, x: f64) -> f64 {
        4.0 * f64::EPSILON * (x + self.sigma).powi(2) * self.space.theta[0]
    }

    /// λ_j of a pole.
    fn pole(&self, theta: f64) -> f64 {
        theta.recip() - self.sigma
    }

    /// Tells the modes among the poles up to the limit.
    fn classify(&mut self, matrices: &ScaledMatrices) -> bool {
        let theta = &self.space.theta;
        let least = self.highest().recip();
        let strongest = (0..theta.len()).map(|j| self.space.first(j)).fold(0.0, f64::max);
        self.found.clear();
        for (j, &t) in theta.iter().enumerate().take_while(|(_, t)| **t >= least) {
            let found = self.space.residual(j) <= FOUND * t;
            if !found && self.space.first(j) > UNSEEN * strongest {
                return false;
            }
            self.found.push(found);
        }
        self.zero =
            (0..self.found.len().min(RIGID)).map(|j| 16.0 * self.ulps(matrices, j)).fold(0.0, f64::max);
        true
    }

    /// How far one ulp in each entry of K and M can move the eigenvalue of pole `j`.
    fn ulps(&mut self, matrices: &ScaledMatrices, j: usize) -> f64 {
        let lambda = self.pole(self.space.theta[j]).abs();
        let v = self.vectors(matrices, std::iter::once(j));
        f64::EPSILON * (matrices.stiffness.absolute_form(v) + lambda * matrices.mass.absolute_form(v))
    }

    /// Notes how near each pole may come to the one below and still be the same, repeated.
    fn tell_repeated(&mut self, matrices: &ScaledMatrices) {
        self.repeated.clear();
        for j in 0..self.found.len() {
            let theta = &self.space.theta;
            let (s, largest) = (theta[j].recip(), theta[0]);
            let mut tolerance = REPEATED * f64::EPSILON * s * s * largest;
            if is_close(theta, j) {
                let moved = s * s * uncertainty(&self.space, j);
                tolerance += moved + 4.0 * self.ulps(matrices, j);
            }
            self.repeated.push(tolerance);
        }
    }

    /// Forms the partial fractions between row `i` of `n` and the load; a root cancels on each pole of `hidden`.
    fn form(&mut self, n: usize, i: usize, hidden: &[f64], h: &mut Receptance) {
        h.clear();
        let space = &self.space;
        space.row(i, &mut self.row);
        let known = space.response[i];
        h.begin(self.sigma, known);
        let (mut size_i, mut size_k, mut modes) = (0.0_f64, 0.0_f64, 0);
        let top = (4.0 * (self.limit + self.sigma)).recip();
        let largest_theta = space.theta[0];
        let mut floor = 0.0;
        for (j, (&theta, &phi_i)) in space.theta.iter().zip(&self.row).enumerate() {
            let phi_k = space.strength(j);
            let rounding = j < self.found.len() && !self.found[j];
            if theta <= f64::EPSILON * largest_theta {
                // So stiff that beside the response it is nothing but its rounding.
                floor += (phi_k * phi_i * theta).abs() / f64::EPSILON;
                continue;
            }
            if theta >= top {
                size_i = size_i.max(phi_i.abs());
                size_k = size_k.max(phi_k.abs());
            }
            if rounding {
                continue;
            }
            if j >= self.found.len() {
                floor += (phi_k * phi_i * theta).abs();
            }
            let lambda = self.pole(theta);
            let lambda = if lambda.abs() <= self.zero { 0.0 } else { lambda };
            h.add(lambda, phi_i * phi_k, self.repeated.get(j).copied().unwrap_or(0.0));
            if j < self.found.len() {
                modes = h.poles.len();
            }
        }
        h.cancelled.extend(hidden.iter().filter(|&&l| l <= self.limit));
        h.floor_error = 4.0 * f64::EPSILON * floor;
        h.finish(n, modes, (size_i, size_k));
        let error = 4.0 * f64::EPSILON * known.abs();
        if error > h.residue_error {
            h.floor_error += error / self.sigma;
        }
        let largest = space.response.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        h.is_zero &= known.abs() <= NOTHING * largest;
    }
}

/// The hidden modes, with the memory to find them again.
#[derive(Default)]
struct HiddenModes {
    krylov: Krylov,
    lambda: Vec<f64>,
    /// M v and v of the shown modes, then of the hidden ones, by rows; nothing where none is hidden.
    weighted: Vec<f64>,
    vectors: Vec<f64>,
}

impl HiddenModes {
    fn clear(&mut self) {
        self.lambda.clear();
        self.weighted.clear();
        self.vectors.clear();
    }

    /// Finds the `missing` modes below `cut` in the complement of the poles of the load; `matrices` hold the factors of
    /// K + σM. False where they do not come out as many.
    fn find(&mut self, matrices: &ScaledMatrices, poles: &Poles, cut: f64, missing: usize) -> bool {
        let (mass, sigma) = (&matrices.mass, poles.sigma);
        for j in (0..poles.found.len()).filter(|&j| poles.found[j]) {
            poles.space.vector(j, mass, &mut self.weighted, &mut self.vectors);
        }
        let least = (cut + sigma).recip();
        let mut random = pseudo_random();
        while self.lambda.len() < missing {
            let mut load = vec![0.0; matrices.stride()];
            load[..mass.n()].fill_with(&mut random);
            let mut start = vec![0.0; load.len()];
            mass.multiply(&load, &mut start);
            start[mass.n()..].fill(0.0);
            let op = Operator { shifted: &matrices.factors, mass, outside: (&self.weighted, &self.vectors) };
            let (load, highest) = ((&start[..], Start::Response), poles.highest());
            if !self.krylov.grow(op, load, highest, mass.n(), |_| true) {
                return false;
            }
            let before = self.lambda.len();
            for (j, &t) in self.krylov.theta.iter().enumerate() {
                if t >= least && self.krylov.residual(j) <= FOUND * t {
                    self.lambda.push(t.recip() - sigma);
                    self.krylov.vector(j, mass, &mut self.weighted, &mut self.vectors);
                }
            }
            if self.lambda.len() == before {
                return false;
            }
        }
        self.lambda.len() == missing
    }
}

/// Residual, relative to θ, of a pole that counts as found. The eigenvalue is good to its square.
const FOUND: f64 = 1e-6;

/// Part of a mode in the load, relative to the largest, below which a pole that is not found is rounding.
const UNSEEN: f64 = 1e-11;

/// Relative distance of two poles from which on it is asked whether they are one.
const CLOSE: f64 = 1e-6;

/// Largest mixture of two modes: a part of the one in the other's residue is the square of it.
const MIXTURE: f64 = 1e-8;

/// Whether each pole with θ of at least `least` is a mode or rounding, and no two of them are mixed.
fn settled(space: &Krylov, least: f64) -> bool {
    let theta = &space.theta;
    let strongest = (0..theta.len()).fold(0.0, |m, j| f64::max(m, space.first(j)));
    let found = |j: usize| space.residual(j) <= FOUND * theta[j];
    let rounding = f64::EPSILON * theta[0];
    let unmixed = |j: usize| {
        let mixed = MIXTURE * (theta[j - 1] - theta[j]);
        !found(j - 1) || space.residual(j - 1).max(space.residual(j)) <= mixed.max(rounding)
    };
    let mut up_to_limit = theta.iter().take_while(|t| **t >= least).enumerate();
    up_to_limit.all(|(j, _)| {
        if found(j) { !is_close(theta, j) || unmixed(j) } else { space.first(j) <= UNSEEN * strongest }
    })
}

/// Whether pole `j` may be the one before it, repeated.
fn is_close(theta: &[f64], j: usize) -> bool {
    j > 0 && theta[j - 1] - theta[j] <= CLOSE * theta[j - 1]
}

/// How far θ of pole `j` and of the one before may be from those of the modes that the two stand for.
fn uncertainty(space: &Krylov, j: usize) -> f64 {
    let theta = &space.theta;
    let apart = |other: &&f64| (**other - theta[j]).abs() > CLOSE * theta[j];
    let (before, after) = theta.split_at(j);
    let others = [before.iter().rev().find(apart), after.iter().find(apart)];
    let distances = others.into_iter().flatten().map(|other| (other - theta[j]).abs());
    let gap = distances.fold(theta[j], f64::min);
    (space.residual(j).powi(2) + space.residual(j - 1).powi(2)) / gap
}
