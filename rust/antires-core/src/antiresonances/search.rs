//! The roots of one response by the modal series: isolated, then placed.
//!
//! Where rounding disturbs, they are sought once more with the low modes from factors of K − xM.
//!
//! The shift of the dense solver is some 1e-3 of the mean of λ, for all modes have to be found with it. A mode far
//! below, such as a stiff frame on soft springs, keeps few digits of its λ and of its shape, and a root of H_ik
//! beside it may drown. A search in doubt is therefore divided: below a fifth of the modes the series of
//! [`ReducedModes`](crate::modal::reduced::ReducedModes) takes over, whose shift suits them.

use super::far;
use super::placement::{Placed, place};
use super::secular::{self, Certainty, Scratch};
use crate::error::Result;
use crate::modal::minor::{Ends, MinorSeries};
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
    /// The response last searched.
    pub receptance: Receptance,
    series: MinorSeries,
    scratch: Scratch,
    /// The roots last found.
    pub found: Found,
}

/// The search for the roots of H_ik, or of a minor.
pub(super) struct Search<'a, 'm> {
    /// Whether the poles of all parts of the structure are wanted: on those of others, roots cancel.
    pub whole: bool,
    pub solved: &'a mut Solved<'m>,
    pub ends: Ends,
    pub memory: &'a mut Memory,
}

impl Search<'_, '_> {
    /// Finds the roots up to `ceiling`.
    pub fn run(&mut self, ceiling: f64) -> Result<Certainty> {
        let Some((i, k)) = self.ends.pair() else {
            return self.minor(ceiling);
        };
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
        self.memory.receptance.most_roots = degree;
        self.memory.found.begin(solver.zero);
        match self.isolate((0.0, ceiling), Series::Dense) {
            Certainty::Proven => {
                let Memory { receptance, found, .. } = &mut *self.memory;
                Ok(far::add_roots(self.solved, &self.ends, receptance, ceiling, |root| {
                    if !found.has(root) {
                        found.proven.push(root.x);
                    }
                }))
            }
            Certainty::Doubtful => Ok(self.divided(ceiling)),
        }
    }

    /// Adds the roots of the receptance in hand, in (low, high], to those found.
    fn isolate(&mut self, (low, high): (f64, f64), series: Series) -> Certainty {
        let Memory { receptance: h, scratch, found, .. } = &mut *self.memory;
        for &x in h.cancelled.iter().filter(|&&x| low < x && x <= high) {
            let presence =
                if h.is_zero || secular::is_hollow(h, x) { Presence::Open } else { Presence::Sure };
            found.cancelled.push((x, presence));
        }
        if h.is_zero {
            return Certainty::Proven;
        }
        let mut roots = Vec::new();
        let mut certainty = secular::roots(h, low, high, &mut roots, scratch);
        let (floor, first) = (found.floor, found.mark());
        let mut last_placed = 0.0;
        for x in roots.into_iter().filter(|&x| x > floor) {
            let (noise, slope) = h.noise_and_slope(x);
            let by_noise = noise / slope.abs();
            let (by_poles, fair) = match series {
                Series::Reduced => (
                    self.solved.reduced().pole_error(x),
                    if self.solved.n_dof() <= MOST_EXACT { INEXACT_ROOT } else { DOUBTFUL_ROOT },
                ),
                Series::Dense => {
                    let dense = self.solved.dense_in_hand();
                    (dense.map_or(0.0, |d| d.uncertainty(x)), DOUBTFUL_ROOT)
                }
            };
            let moved = by_noise + by_poles;
            if !(moved <= fair * x)
                && let Some(better) = place(self.solved, &self.ends, x, REACH * moved)
            {
                if placed_twice(better, last_placed) {
                    certainty = Certainty::Doubtful;
                } else {
                    found.proven.push(better.x);
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
                found.proven.push(x);
            } else {
                found.open.push(x);
                certainty = Certainty::Doubtful;
            }
        }
        found.proven[first.proven..].sort_by(f64::total_cmp);
        certainty
    }

    /// The roots of a minor: isolated between its poles as spread, then refined on the series itself.
    fn minor(&mut self, ceiling: f64) -> Result<Certainty> {
        let Memory { receptance: h, series, scratch, found } = &mut *self.memory;
        let ends = self.ends;
        let reduced = ceiling.is_finite()
            && self.solved.is_reducible()
            && self.solved.reduced().solve_several(ends.forces(), ceiling);
        if reduced {
            self.solved.reduced().series(ends.responses(), series);
            found.begin(self.solved.reduced().zero());
        } else {
            let solver = self.solved.dense()?;
            series.of_all_modes(solver, &ends);
            found.begin(solver.zero);
        }
        series.form(h);
        let floor = found.floor;
        let inside = |x: f64| floor < x && x <= ceiling;
        for &x in h.cancelled.iter().filter(|&&x| inside(x)) {
            found.cancelled.push((x, if h.is_zero { Presence::Open } else { Presence::Sure }));
        }
        if h.is_zero {
            return Ok(Certainty::Proven);
        }
        let mut isolated = Vec::new();
        let mut certainty = secular::roots(h, 0.0, ceiling, &mut isolated, scratch);
        // Far beyond the last pole the minor is small against what spreading changes: the pencil has to tell.
        let far = h.poles.last().is_some_and(|last| ceiling > secular::FAR_RATIO * last);
        if series.is_open || far && !series.groups.is_empty() {
            certainty = Certainty::Doubtful;
        }
        for group in series.groups.iter().filter(|group| inside(group.lambda)) {
            (0..group.cancelled).for_each(|_| found.cancelled.push((group.lambda, Presence::Sure)));
            let among = isolated.iter().filter(|&&x| group.holds(x)).count();
            if among != group.cancelled && among != 0 {
                certainty = Certainty::Doubtful;
            }
        }
        isolated.retain(|&x| inside(x) && !series.groups.iter().any(|group| group.holds(x)));
        let mut last = 0.0;
        for x in isolated {
            let Some(refined) = series.refined(x).filter(|root| root.x - last > FOUND_TWICE * x) else {
                found.open.push(x);
                certainty = Certainty::Doubtful;
                continue;
            };
            let by_poles = if reduced {
                self.solved.reduced().pole_error(x)
            } else {
                self.solved.dense_in_hand().map_or(0.0, |dense| dense.uncertainty(x))
            };
            let moved = refined.noise + by_poles * refined.condition;
            // NaN counts as doubtful.
            let known = if moved <= DOUBTFUL_ROOT * x {
                Some(refined.x)
            } else {
                place(self.solved, &ends, refined.x, REACH * moved)
                    .filter(|better| !placed_twice(*better, last))
                    .map(|better| better.x)
            };
            if let Some(known) = known {
                found.proven.push(known);
                last = known;
            } else {
                found.open.push(refined.x);
                certainty = Certainty::Doubtful;
            }
        }
        Ok(certainty)
    }

    /// The search once more, with the low modes from factors of K − xM. All modes are in hand.
    fn divided(&mut self, ceiling: f64) -> Certainty {
        let Some((i, k)) = self.ends.pair() else {
            return Certainty::Doubtful;
        };
        let modes = self.solved.dense_in_hand();
        let Some(gap) = modes.and_then(|all| widest_gap(&all.eigenvalues, all.zero)) else {
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
        if below == Certainty::Proven { above } else { below }
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

// ---- found

/// Relative distance in x within which two roots, placed on the matrices from different starts, are one.
const ONE_ROOT: f64 = 1e-8;

/// Relative distance in x within which two roots of one series were placed on the same one.
const FOUND_TWICE: f64 = 1e-12;

/// Ulps of K and M within which two roots placed on the matrices are one.
const SAME_ULPS: f64 = 16.0;

/// Whether a root that cancels against a pole is there for sure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Presence {
    Sure,
    /// Rounding hides it; the pencil has to tell.
    Open,
}

/// The roots of one response, in x = ω².
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    /// Isolated by a change of sign, and placed.
    pub proven: Vec<f64>,
    /// Those that rounding may have made.
    open: Vec<f64>,
    /// Poles on which a root lies that cancels.
    cancelled: Vec<(f64, Presence)>,
    /// Roots below this are zero at working precision.
    pub floor: f64,
}

/// How many roots there were at some time.
#[derive(Clone, Copy)]
pub(super) struct Mark {
    proven: usize,
    cancelled: usize,
}

impl Found {
    /// Forgets all roots; those below `floor` are zero from now on.
    fn begin(&mut self, floor: f64) {
        self.proven.clear();
        self.open.clear();
        self.cancelled.clear();
        self.floor = floor;
    }

    fn mark(&self) -> Mark {
        Mark { proven: self.proven.len(), cancelled: self.cancelled.len() }
    }

    /// Drops what was found since, above `limit` but for an overlap, and was known before.
    fn drop_twice(&mut self, since: Mark, limit: f64) {
        let (lower, upper) = self.proven.split_at(since.proven);
        let again = |x: &f64| {
            let twice = |y: &f64| (x - y).abs() <= ONE_ROOT * y;
            *x <= limit * (1.0 + ONE_ROOT) && lower.iter().any(twice)
        };
        let upper: Vec<f64> = upper.iter().copied().filter(|x| !again(x)).collect();
        self.proven.truncate(since.proven);
        self.proven.extend(upper);
        let mut index = 0;
        self.cancelled.retain(|&(x, _)| {
            index += 1;
            index <= since.cancelled || x > limit
        });
    }

    /// Drops the cancelled roots that are zero at working precision.
    pub fn drop_cancelled_zeros(&mut self) {
        let floor = self.floor;
        self.cancelled.retain(|&(x, _)| x > floor);
    }

    /// Lets each proven or cancelled root take its own from elsewhere. A cancelled one then lies there; one
    /// that was open and finds none is dropped.
    pub fn claim(&mut self, mut take_nearest: impl FnMut(f64) -> Option<f64>) {
        for &x in &self.proven {
            take_nearest(x);
        }
        self.cancelled.retain_mut(|(x, presence)| {
            let own = take_nearest(*x);
            *x = own.unwrap_or(*x);
            *presence == Presence::Sure || own.is_some()
        });
    }

    /// Whether a root placed on the matrices is one of those proven or cancelled.
    pub fn has(&self, Placed { x, ulp }: Placed) -> bool {
        let known = |y: &f64| (x - y).abs() <= (ONE_ROOT * y).max(SAME_ULPS * ulp);
        self.proven.iter().any(known) || self.cancelled().any(|y| known(&y))
    }

    /// Takes the open roots for proven ones.
    pub fn settle_open(&mut self) {
        self.proven.append(&mut self.open);
    }

    /// Takes the cancelled roots for proven ones.
    pub fn include_cancelled(&mut self) {
        self.proven.extend(self.cancelled.iter().map(|&(x, _)| x));
    }

    /// Where roots lie that cancel.
    pub fn cancelled(&self) -> impl Iterator<Item = f64> {
        self.cancelled.iter().map(|&(x, _)| x)
    }

    /// The proven roots, ascending.
    pub fn sorted(&mut self) -> &[f64] {
        self.proven.sort_by(f64::total_cmp);
        &self.proven
    }
}

/// Whether two roots of one series, isolated apart, were placed on the same root.
pub(super) fn placed_twice(here: Placed, before: f64) -> bool {
    (here.x - before).abs() <= (FOUND_TWICE * here.x).max(SAME_ULPS * here.ulp)
}
