//! Resonant frequencies and mass-normalised mode shapes: all, or the lowest.
//!
//! # low_modes
//!
//! All modes of a model up to a limit: frequencies, shapes, and the adjoint solutions for their derivatives.
//!
//! Where factors of K − xM are cheap it is solved by [`ReducedModes`], where a count of the modes
//! by inertia proves that none is missing; all else, and what that leaves open, by the dense
//! [`SymmetricSolver`].
//!
//! # frf
//!
//! Frequency response functions by modal superposition.
//!
//! ```text
//! receptance    H(ω) = Σ_r φ_ir φ_kr / (ω_r² − ω² + 2 j ζ_r ω_r ω) + d_ik     [m/N]
//! mobility      j ω H(ω)                                                     [m/(N s)]
//! accelerance   −ω² H(ω)                                                     [m/(N s²)]
//! ```
//!
//! Source: Ewins, Modal Testing, 2nd ed. (2000), section 2.4.

use std::f64::consts::TAU;
use std::sync::Arc;

use faer::{Mat, MatRef};

use super::columns::{self, Adjoint};
use super::reduced::ReducedModes;
use super::scaled::{ScaledMatrices, Scope};
use super::solved::Solved;
use super::structure::Structure;
use crate::error::{Error, Result};
use crate::fem::model::Model;
use crate::linalg::symmetric::SymmetricSolver;

/// Modes more than asked for, and half of those, that the factors may find.
const SPARE: usize = 4;

/// Counts of modes at most in a search for their limit, and the step down from a λ with too many below it.
const MOST_COUNTS: usize = 60;
const COARSE: f64 = 1e-2;

/// Finite modes of a model.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Resonant frequencies (Hz), ascending; rigid-body modes at 0. An unstable mode (λ < 0) has NaN.
    pub freq_hz: Vec<f64>,
    /// Shapes [n_dof x n_modes], φᵀ M φ = 1.
    pub shapes: Mat<f64>,
}

/// Frequency in Hz of an eigenvalue λ = ω² in (rad/s)².
pub fn hertz(lambda: f64) -> f64 {
    lambda.sqrt() / TAU
}

/// λ = ω² in (rad/s)² of a frequency in Hz.
pub fn eigenvalue(freq_hz: f64) -> f64 {
    (TAU * freq_hz).powi(2)
}

/// All solutions of K φ = λ M φ.
#[derive(Debug, Clone)]
pub struct AllModes {
    /// Finite eigenvalues, ascending.
    pub lambda: Vec<f64>,
    /// Their shapes, then the massless ones of [`SymmetricSolver::vectors`], [n_dof x n_dof].
    pub vectors: Mat<f64>,
}

impl AllModes {
    /// Solves the dense eigenproblem of `model`.
    pub fn of(model: &Model) -> Result<Self> {
        let n = model.n_dof();
        Error::check_memory(|| format!("all modes of {n} dofs"), n.saturating_mul(n).saturating_mul(6))?;
        let mut solver = SymmetricSolver::new(n);
        let (k, m) = (model.stiffness().to_dense(), model.mass().to_dense());
        solver.solve(k.as_ref(), m.as_ref())?;
        Ok(Self { lambda: solver.eigenvalues, vectors: solver.vectors })
    }

    /// The finite modes.
    pub fn finite(&self) -> Modes {
        let shapes: MatRef<'_, f64> = self.vectors.get(.., ..self.lambda.len());
        Modes { freq_hz: self.lambda.iter().map(|&l| hertz(l)).collect(), shapes: shapes.to_owned() }
    }
}

/// The lowest modes of a model, up to `f_max_hz` and at most `most` of them, from factors of K − xM: a count
/// by inertia proves that none is missing. None where those are not cheap, where they are more than a part
/// of all modes, or where rounding leaves a doubt: then [`AllModes`] has to tell.
pub fn low_modes(model: &Model, f_max_hz: f64, most: Option<usize>) -> Result<Option<Modes>> {
    let structure = Structure::of(model);
    structure.check_room()?;
    Ok(by_factors(structure, model, f_max_hz, most))
}

fn by_factors(structure: Structure, model: &Model, f_max_hz: f64, most: Option<usize>) -> Option<Modes> {
    if !structure.is_reducible() {
        return None;
    }
    let mut reduced = ReducedModes::new(Arc::new(structure));
    reduced.set_matrices(model.stiffness(), model.mass());
    let mut limit = eigenvalue(f_max_hz);
    if let Some(most) = most {
        limit = limit.min(limit_above(most, reduced.matrices())?);
    }
    if !(limit.is_finite() && reduced.solve(0, limit, true)) {
        return None;
    }
    let (mut lambda, mut shapes) = (Vec::new(), Vec::new());
    reduced.modes(&mut lambda, &mut shapes);
    lambda.truncate(most.unwrap_or(usize::MAX));
    let n = model.n_dof();
    Some(Modes {
        freq_hz: lambda.iter().map(|&l| hertz(l)).collect(),
        shapes: Mat::from_fn(n, lambda.len(), |dof, r| shapes[r * n + dof]),
    })
}

/// A λ with `most` modes below it, or a few more; none where the search for it leads nowhere.
fn limit_above(most: usize, matrices: &mut ScaledMatrices) -> Option<f64> {
    let enough = most..=most + most / 2 + SPARE;
    let largest = matrices.stiffness.largest_diagonal();
    let (mut low, mut high) = (0.0, largest);
    for _ in 0..MOST_COUNTS {
        // Halving the exponent, until there is a lower end.
        let at = if low > 0.0 { f64::sqrt(low * high) } else { COARSE * high };
        let (count, _) = matrices.count_below(at, Scope::Whole);
        if enough.contains(&count) {
            return Some(at);
        }
        *(if count < most { &mut low } else { &mut high }) = at;
    }
    None
}

// ---- low_modes

/// Eigenvalues this near to one another, relatively, count as one that is repeated: their shapes are then a
/// matter of rounding.
const REPEATED: f64 = 1e-8;

/// Modes up to a limit, with the memory to find them again.
#[derive(Debug, Clone, Default)]
pub struct LowModes {
    n: usize,
    /// Eigenvalues λ = ω², ascending.
    pub lambda: Vec<f64>,
    /// Shapes by dof, one after the other.
    shapes: Vec<f64>,
    /// Eigenvalues up to this are zero at working precision: rigid-body modes.
    pub zero: f64,
}

impl LowModes {
    /// Finds all modes of K φ = λ M φ with λ up to `limit`; from `start`, a dof that the modes looked for
    /// move, that is quickest.
    pub fn find(&mut self, solved: &mut Solved<'_>, limit: f64, start: usize) -> Result<()> {
        self.n = solved.n_dof();
        if solved.is_reducible() {
            let reduced = solved.reduced();
            if reduced.solve(start, limit, true) {
                reduced.modes(&mut self.lambda, &mut self.shapes);
                self.zero = reduced.zero();
                return Ok(());
            }
        }
        let solver = solved.dense()?;
        let all = &solver.eigenvalues;
        let count = all.partition_point(|&l| l <= limit);
        self.lambda.clear();
        self.lambda.extend_from_slice(&all[..count]);
        self.shapes.clear();
        for r in 0..count {
            self.shapes.extend((0..self.n).map(|dof| solver.vectors[(dof, r)]));
        }
        self.zero = 16.0 * solver.uncertainty(0.0);
        Ok(())
    }

    /// Mass-normalised shape of mode `r`, one entry a dof.
    pub fn shape(&self, r: usize) -> &[f64] {
        &self.shapes[r * self.n..(r + 1) * self.n]
    }

    /// The shapes that belong to the eigenvalue of mode `r`, one after the other: more than one where it is
    /// repeated.
    pub fn space(&self, r: usize) -> &[f64] {
        let same =
            |a: usize, b: usize| (self.lambda[b] - self.lambda[a]).abs() <= REPEATED * self.lambda[b].abs();
        let (mut first, mut last) = (r, r);
        while first > 0 && same(first - 1, first) {
            first -= 1;
        }
        while last + 1 < self.lambda.len() && same(last, last + 1) {
            last += 1;
        }
        &self.shapes[first * self.n..(last + 1) * self.n]
    }

    /// Solves (K − λM) z = g with zᵀMφ = 0 for mode `r` and a slope `g` with gᵀφ = 0, see [`columns`]; `solved`
    /// are the matrices whose modes these are.
    ///
    /// Not for a repeated mode, whose shape has no derivative.
    pub fn adjoint(&self, solved: &mut Solved<'_>, r: usize, g: &[f64], z: &mut Vec<f64>) -> Result<()> {
        if solved.is_reducible() && solved.dense_in_hand().is_none() {
            let mode = (self.lambda[r], self.shape(r));
            if columns::by_factors(solved.reduced().matrices(), mode, g, z) == Adjoint::Solved {
                return Ok(());
            }
        }
        // The modes are in one order on both routes.
        columns::by_all_modes(solved.dense()?, r, g, z);
        Ok(())
    }
}

// ---- frf

/// The motion quantity of a frequency response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Displacement over force.
    Receptance,
    /// Velocity over force.
    Mobility,
    /// Acceleration over force.
    Accelerance,
}

/// H(ω) of each response, [n_responses x n_freq] row by row, as (real, imaginary) pairs.
///
/// `damping_ratio` holds one ζ for every mode, or one value for all.
pub fn frequency_response(
    modes: &AllModes,
    responses: &[usize],
    excitation: usize,
    freq_hz: &[f64],
    damping_ratio: &[f64],
    motion: Motion,
) -> Vec<(f64, f64)> {
    let (lambda, phi) = (&modes.lambda, modes.vectors.as_ref());
    let n = phi.nrows();
    let mut out = vec![(0.0, 0.0); responses.len() * freq_hz.len()];
    for (row, &i) in out.chunks_exact_mut(freq_hz.len().max(1)).zip(responses) {
        let massless: f64 = (lambda.len()..n).map(|r| phi[(i, r)] * phi[(excitation, r)]).sum();
        for (h, &f) in row.iter_mut().zip(freq_hz) {
            let omega = TAU * f;
            let (mut re, mut im) = scaled(massless, 0.0, omega, motion);
            for (r, &l) in lambda.iter().enumerate() {
                let residue = phi[(i, r)] * phi[(excitation, r)];
                let zeta = damping_ratio[if damping_ratio.len() == 1 { 0 } else { r }];
                let (dr, di) = (l - omega * omega, 2.0 * zeta * l.max(0.0).sqrt() * omega);
                if dr == 0.0 && di == 0.0 {
                    // A rigid-body mode at standstill: only the accelerance has a limit there.
                    re += if motion == Motion::Accelerance { residue } else { f64::INFINITY * residue };
                    continue;
                }
                let size = dr * dr + di * di;
                let (a, b) = scaled(residue * dr / size, -residue * di / size, omega, motion);
                re += a;
                im += b;
            }
            *h = (re, im);
        }
    }
    out
}

/// (re + j im) times 1, jω or −ω².
fn scaled(re: f64, im: f64, omega: f64, motion: Motion) -> (f64, f64) {
    match motion {
        Motion::Receptance => (re, im),
        Motion::Mobility => (-omega * im, omega * re),
        Motion::Accelerance => (-omega * omega * re, -omega * omega * im),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::model::{Model, mass_spring_chain};
    use crate::linalg::sparse::SparseMatrix;
    use crate::modal::solved::Solutions;
    use crate::modal::structure::Structure;
    use faer::Mat;
    use std::sync::Arc;

    /// A free chain of 50 masses without symmetry.
    fn chain() -> Model {
        let wave = |i: usize, a: f64| 1.0 + 0.3 * (a * i as f64).sin();
        let masses: Vec<f64> = (0..50).map(|i| 0.5 * wave(i, 1.7)).collect();
        let springs: Vec<f64> = (1..50).map(|i| 5e4 * wave(i, 0.9)).collect();
        mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap()
    }

    /// Memory for the band route.
    fn slender(model: &Model) -> Solutions {
        let structure = Structure::of(model);
        assert!(structure.is_reducible());
        Solutions::new(&Arc::new(structure))
    }

    /// Memory for the dense one: every dof counts as joined to every other.
    fn full(model: &Model) -> Solutions {
        let pattern = SparseMatrix::full(model.stiffness().to_dense().as_ref());
        let structure = Structure::new(pattern.pattern(), |_| true);
        assert!(!structure.is_reducible());
        Solutions::new(&Arc::new(structure))
    }

    fn low(solved: &mut Solved<'_>, limit: f64) -> LowModes {
        let mut modes = LowModes::default();
        modes.find(solved, limit, 7).unwrap();
        modes
    }

    #[test]
    fn both_routes_give_one_answer() {
        let model = chain();
        let (k, m) = (model.stiffness(), model.mass());
        let (mut for_band, mut for_dense) = (slender(&model), full(&model));
        let (mut banded, mut solved) = (for_band.of(k, m), for_dense.of(k, m));
        let (band, dense) = (low(&mut banded, 3e4), low(&mut solved, 3e4));
        assert!(banded.dense_in_hand().is_none() && solved.dense_in_hand().is_some());
        let count = band.lambda.len();
        assert!(count > 8 && count == dense.lambda.len(), "{count}");
        assert!(band.lambda[0] <= band.zero && dense.lambda[0] <= dense.zero);
        let (mut by_band, mut densely) = (Vec::new(), Vec::new());
        for r in 1..count {
            let (a, b) = (band.lambda[r], dense.lambda[r]);
            assert!(a > band.zero && (a / b - 1.0).abs() < 1e-10, "{a} {b}");
            let sign = (band.shape(r)[0] * dense.shape(r)[0]).signum();
            for (p, q) in band.shape(r).iter().zip(dense.shape(r)) {
                assert!((p - sign * q).abs() < 1e-8, "{p} {q}");
            }
            // A slope without part along the shape.
            let mut g = vec![0.0; 50];
            (g[3], g[20]) = (band.shape(r)[20], -band.shape(r)[3]);
            band.adjoint(&mut banded, r, &g, &mut by_band).unwrap();
            dense.adjoint(&mut solved, r, &g, &mut densely).unwrap();
            assert!(banded.dense_in_hand().is_none(), "the band settled it");
            let size = densely.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
            for (y, z) in by_band.iter().zip(&densely) {
                assert!((y - z).abs() < 1e-7 * size, "{y} {z}");
            }
        }
    }

    #[test]
    fn modes_that_the_start_does_not_move_are_found_and_repeated_ones_belong_together() {
        // Two equal chains beside each other: every mode twice, and the load moves one of each two.
        let one = chain();
        let twice = |a: &SparseMatrix| {
            Mat::from_fn(100, 100, |i, j| if i / 50 == j / 50 { a.get(i % 50, j % 50) } else { 0.0 })
        };
        let model = Model::new(twice(one.stiffness()), twice(one.mass()), vec![], vec![]).unwrap();
        let of = |model: &Model| {
            let mut memory = slender(model);
            let mut solved = memory.of(model.stiffness(), model.mass());
            let modes = low(&mut solved, 2e4);
            assert!(solved.dense_in_hand().is_none());
            modes
        };
        let (single, double) = (of(&one), of(&model));
        assert_eq!(double.lambda.len(), 2 * single.lambda.len());
        for r in 2..double.lambda.len() {
            let ratio = double.lambda[r] / single.lambda[r / 2];
            assert!((ratio - 1.0).abs() < 1e-10, "{ratio}");
            assert_eq!(double.space(r).len(), 200);
            assert_eq!(single.space(r / 2).len(), 50);
        }
    }
}
