//! The roots of one response by the modal series: isolated, placed, and, where rounding disturbs, once more with
//! the low modes from factors of K − xM.
//!
//! The shift of the dense solver is some 1e-3 of the mean of λ, for all modes have to be found with it. A mode far
//! below, such as a stiff frame on soft springs, keeps few digits of its λ and of its shape, and a root of H_ik
//! beside it may drown. A search in doubt is therefore divided: below a fifth of the modes the series of
//! [`ReducedModes`](crate::modal::reduced::ReducedModes) takes over, whose shift suits them.

use super::found::{Found, Presence, placed_twice};
use super::placement::place;
use super::secular::{self, Certainty, Scratch};
use crate::error::Result;
use crate::modal::receptance::Receptance;
use crate::modal::solved::Solved;

/// Relative uncertainty of a root in x from which on it is doubtful.
pub(super) const DOUBTFUL_ROOT: f64 = 1e-9;

/// Relative uncertainty of a root in x from which on it is placed on the matrices, of the series up to a limit; of
/// large structures it is [`DOUBTFUL_ROOT`], for each place costs a factorization or two.
const INEXACT_ROOT: f64 = 1e-10;

/// Most dofs of a structure that is not large.
const MOST_EXACT: usize = 1000;

/// Multiple of the expected error of a root within which its place on the matrices has to lie.
pub(super) const REACH: f64 = 16.0;

/// Shares of the modes between which a search is divided.
const LOW_MODES: (f64, f64) = (0.15, 0.25);

/// Least relative gap between two modes, in x, in which it is.
const LEAST_GAP: f64 = 1e-4;

/// Relative width in x by which the upper part of a divided search overlaps the lower one.
const OVERLAP: f64 = 1e-6;

/// Whose partial fractions are in hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Series {
    /// Poles up to a limit.
    Reduced,
    /// All modes.
    Dense,
}

/// Working memory of the searches.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    receptance: Receptance,
    scratch: Scratch,
    found: Found,
}

impl Memory {
    /// Whether the response last searched is identically zero at working precision.
    pub fn is_zero(&self) -> bool {
        self.receptance.is_zero
    }

    /// The roots last found.
    pub fn found(&mut self) -> &mut Found {
        &mut self.found
    }
}

/// The search for the roots of H_ik.
pub(super) struct Search<'a, 'm> {
    /// Whether the poles of all parts of the structure are wanted: on those of others, roots cancel.
    whole: bool,
    solved: &'a mut Solved<'m>,
    ends: (usize, usize),
    memory: &'a mut Memory,
}

impl<'a, 'm> Search<'a, 'm> {
    /// The search for the roots between the dofs `ends`, response and excitation.
    pub fn new(
        solved: &'a mut Solved<'m>,
        ends: (usize, usize),
        whole: bool,
        memory: &'a mut Memory,
    ) -> Self {
        Self {
            whole,
            solved,
            ends,
            memory,
        }
    }

    /// Finds the roots up to `ceiling`.
    ///
    /// # Errors
    /// Those of [`Solved::dense`].
    pub fn run(&mut self, ceiling: f64) -> Result<Certainty> {
        let (i, k) = self.ends;
        if ceiling.is_finite() && self.solved.is_reducible() {
            let reduced = self.solved.reduced();
            if reduced.solve(k, ceiling, self.whole) {
                reduced.form(i, &mut self.memory.receptance);
                self.memory.found.begin(reduced.zero());
                return Ok(self.isolate((0.0, ceiling), Series::Reduced));
            }
        }
        let degree = self.solved.degree(i, k);
        let solver = self.solved.dense()?;
        self.memory.receptance.form(solver, i, k);
        self.memory.receptance.bound_roots(degree);
        self.memory.found.begin(solver.zero());
        match self.isolate((0.0, ceiling), Series::Dense) {
            Certainty::Proven => Ok(Certainty::Proven),
            Certainty::Doubtful => Ok(self.divided(ceiling)),
        }
    }

    /// Adds the roots of the receptance in hand, in (low, high], to those found.
    fn isolate(&mut self, (low, high): (f64, f64), series: Series) -> Certainty {
        let Memory {
            receptance: h,
            scratch,
            found,
        } = &mut *self.memory;
        for &x in h.cancelled.iter().filter(|&&x| low < x && x <= high) {
            let presence = if h.is_zero || secular::is_hollow(h, x) {
                Presence::Open
            } else {
                Presence::Sure
            };
            found.cancel(x, presence);
        }
        if h.is_zero {
            return Certainty::Proven;
        }
        let mut roots = Vec::new();
        let mut certainty = secular::roots(h, low, high, &mut roots, scratch);
        let (floor, first) = (found.floor(), found.mark());
        let mut last_placed = 0.0;
        for x in roots.into_iter().filter(|&x| x > floor) {
            let (noise, slope) = h.noise_and_slope(x);
            let by_noise = noise / slope.abs();
            let (by_poles, fair) = match series {
                Series::Reduced => (
                    self.solved.reduced().pole_error(x),
                    if self.solved.n_dof() <= MOST_EXACT {
                        INEXACT_ROOT
                    } else {
                        DOUBTFUL_ROOT
                    },
                ),
                Series::Dense => {
                    let dense = self.solved.dense_in_hand();
                    (dense.map_or(0.0, |d| d.uncertainty(x)), DOUBTFUL_ROOT)
                }
            };
            let moved = by_noise + by_poles;
            if !(moved <= fair * x)
                && let Some(better) = place(self.solved, self.ends, x, REACH * moved)
            {
                if placed_twice(better, last_placed) {
                    certainty = Certainty::Doubtful;
                } else {
                    found.prove(better.x);
                    last_placed = better.x;
                }
                continue;
            }
            let known = match series {
                Series::Reduced => moved,
                Series::Dense => by_noise,
            };
            // NaN counts as doubtful.
            if known <= DOUBTFUL_ROOT * x {
                found.prove(x);
            } else {
                found.leave_open(x);
                certainty = Certainty::Doubtful;
            }
        }
        found.sort_since(first);
        certainty
    }

    /// The search once more, with the low modes from factors of K − xM. All modes are in hand.
    fn divided(&mut self, ceiling: f64) -> Certainty {
        let (i, k) = self.ends;
        let modes = self.solved.dense_in_hand();
        let Some(gap) = modes.and_then(|all| widest_gap(all.eigenvalues(), all.zero())) else {
            return Certainty::Doubtful;
        };
        let limit = gap.min(ceiling);
        let low = self.solved.reduced();
        if !low.solve(k, limit, self.whole) {
            return Certainty::Doubtful;
        }
        self.memory.found.begin(low.zero());
        let of_all_modes = std::mem::take(&mut self.memory.receptance);
        low.form(i, &mut self.memory.receptance);
        // A residue counts as negligible beside the largest of all modes.
        let largest = |upto: f64| of_all_modes.largest_residue(upto);
        let factor = largest(f64::INFINITY) / largest(limit);
        if factor.is_finite() {
            self.memory.receptance.raise_bar(factor, limit);
        }
        let below = self.isolate((0.0, limit), Series::Reduced);
        self.memory.receptance = of_all_modes;
        if limit == ceiling {
            return below;
        }
        let split = self.memory.found.mark();
        let above = self.isolate(((1.0 - OVERLAP) * limit, ceiling), Series::Dense);
        self.memory.found.drop_twice(split, limit);
        below.and(above)
    }
}

/// The middle of the widest gap, relatively, between the modes at which a search may be divided; none where all
/// of them are zero or repeated.
fn widest_gap(lambda: &[f64], zero: f64) -> Option<f64> {
    let at = |share: f64| (share * lambda.len() as f64) as usize;
    (at(LOW_MODES.0).max(1)..at(LOW_MODES.1))
        .filter(|&j| lambda[j - 1] > zero)
        .map(|j| (lambda[j - 1], lambda[j]))
        .max_by(|a, b| (a.1 / a.0).total_cmp(&(b.1 / b.0)))
        .filter(|(below, above)| above - below > LEAST_GAP * below)
        .map(|(below, above)| (below * above).sqrt())
}
