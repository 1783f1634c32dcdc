//! The roots of one response by the modal series: isolated, placed, and, where rounding disturbs, once more with
//! the low modes from the band.
//!
//! The shift of the dense solver is some 1e-3 of the mean of λ, for all modes have to be found with it. A mode far
//! below, such as a stiff frame on soft springs, keeps few digits of its λ and of its shape, and a root of H_ik
//! beside it may drown. A search in doubt is therefore divided: below a fifth of the modes the series of
//! [`super::reduced`] takes over, whose shift suits them.

use super::antiresonances::{AntiresonanceSolver, Matrices, band};
use super::polish::{Polished, polish_deleted};
use super::secular;

/// Relative uncertainty of a root in x from which on it is doubtful.
pub(super) const DOUBTFUL_ROOT: f64 = 1e-9;

/// Relative uncertainty of a root in x from which on it is polished, of the series of the band.
const POLISHED_ROOT: f64 = 1e-10;

/// Multiple of the expected error of a root within which its polish has to end.
pub(super) const REACH: f64 = 16.0;

/// Shares of the modes between which a search is divided.
const LOW_MODES: (f64, f64) = (0.15, 0.25);

/// Least relative gap between two modes, in x, in which it is.
const LEAST_GAP: f64 = 1e-4;

/// Relative width in x by which the upper part of a divided search overlaps the lower one.
const OVERLAP: f64 = 1e-6;

/// Relative distance in x within which two roots, placed on the matrices from different starts, are one.
pub(super) const ONE_ROOT: f64 = 1e-8;

/// Relative distance in x within which two roots of one series were polished to the same place.
const FOUND_TWICE: f64 = 1e-12;

/// Ulps of K and M within which two roots placed on the matrices are one.
pub(super) const SAME_ULPS: f64 = 16.0;

/// What is known of the roots of one response.
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    /// Roots isolated by a change of sign, and placed.
    pub proven: Vec<f64>,
    /// Roots that rounding may have made.
    pub open: Vec<f64>,
    /// Poles on which a root lies that cancels, and whether that is sure.
    pub cancelled: Vec<(f64, bool)>,
    /// Roots below this are zero at working precision.
    pub floor: f64,
}

impl Found {
    pub fn clear(&mut self) {
        self.proven.clear();
        self.open.clear();
        self.cancelled.clear();
    }
}

/// Whose partial fractions are in hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Series {
    /// Poles up to a limit.
    Band,
    /// All modes.
    Dense,
}

impl AntiresonanceSolver {
    /// Adds the roots of the receptance in hand, in (low, high], to those found; false where rounding leaves a
    /// doubt.
    pub(super) fn isolate(
        &mut self,
        matrices: Matrices<'_>,
        pair: (usize, usize),
        (low, high): (f64, f64),
        series: Series,
    ) -> bool {
        let h = &self.receptance;
        let within = h.cancelled.iter().filter(|&&x| low < x && x <= high);
        let told = within.map(|&x| (x, !h.is_zero && !secular::is_hollow(h, x)));
        self.found.cancelled.extend(told);
        if self.receptance.is_zero {
            return true;
        }
        let mut roots = Vec::new();
        let mut certain =
            secular::roots(&self.receptance, low, high, &mut roots, &mut self.scratch);
        let (floor, first) = (self.found.floor, self.found.proven.len());
        let mut last_polished = 0.0;
        for x in roots.into_iter().filter(|&x| x > floor) {
            let (noise, slope) = self.receptance.noise_and_slope(x);
            let by_noise = noise / slope.abs();
            let (by_poles, fair) = match series {
                Series::Band => (
                    band(&mut self.band, &self.structure, matrices).pole_error(x),
                    POLISHED_ROOT,
                ),
                Series::Dense => (
                    self.dense.as_ref().map_or(0.0, |(d, _)| d.uncertainty(x)),
                    DOUBTFUL_ROOT,
                ),
            };
            let moved = by_noise + by_poles;
            if !(moved <= fair * x)
                && let Some(better) = self.polish(matrices, pair, x, REACH * moved)
            {
                if (better.x - last_polished).abs()
                    <= (FOUND_TWICE * better.x).max(SAME_ULPS * better.ulp)
                {
                    certain = false;
                } else {
                    self.found.proven.push(better.x);
                    last_polished = better.x;
                }
                continue;
            }
            let known = match series {
                Series::Band => moved,
                Series::Dense => by_noise,
            };
            // NaN counts as doubtful.
            if known <= DOUBTFUL_ROOT * x {
                self.found.proven.push(x);
            } else {
                self.found.open.push(x);
                certain = false;
            }
        }
        self.found.proven[first..].sort_by(f64::total_cmp);
        certain
    }

    /// The root within `reach` of `x` on the matrices, from band factors or, where rounding spoils them, on the deleted
    /// pencil.
    pub(super) fn polish(
        &mut self,
        matrices: Matrices<'_>,
        pair: (usize, usize),
        x: f64,
        reach: f64,
    ) -> Option<Polished> {
        let by_band = band(&mut self.band, &self.structure, matrices).polish(pair, x, reach);
        by_band.or_else(|| polish_deleted(matrices, pair, x, reach))
    }

    /// The search once more, with the low modes from the band; false where that leaves a doubt too. All modes
    /// are in hand.
    pub(super) fn divided(
        &mut self,
        matrices: Matrices<'_>,
        (i, k): (usize, usize),
        ceiling: f64,
    ) -> bool {
        let Some((solver, _)) = &self.dense else {
            return false;
        };
        let Some(limit) = widest_gap(solver.eigenvalues(), solver.zero()) else {
            return false;
        };
        let limit = limit.min(ceiling);
        let low = band(&mut self.band, &self.structure, matrices);
        if !low.solve(k, limit) {
            return false;
        }
        self.found.floor = low.zero();
        self.found.clear();
        let dense_series = std::mem::take(&mut self.receptance);
        low.form(i, &mut self.receptance);
        // A residue counts as negligible beside the largest of all modes.
        let largest = |upto: f64| {
            let told = dense_series.poles.iter().zip(&dense_series.residues);
            let below = told.take_while(|(l, _)| **l <= upto).map(|(_, c)| c.abs());
            below.fold(0.0, f64::max)
        };
        let factor = largest(f64::INFINITY) / largest(limit);
        if factor.is_finite() {
            self.receptance.raise_bar(factor, limit);
        }
        let below = self.isolate(matrices, (i, k), (0.0, limit), Series::Band);
        let split = self.found.proven.len();
        self.receptance = dense_series;
        if limit == ceiling {
            return below;
        }
        let overlap = (1.0 - OVERLAP) * limit;
        let cancelled = self.found.cancelled.len();
        let above = self.isolate(matrices, (i, k), (overlap, ceiling), Series::Dense);
        let (lower, upper) = self.found.proven.split_at(split);
        let again = |x: &f64| {
            let twice = |y: &f64| (x - y).abs() <= ONE_ROOT * y;
            *x <= limit * (1.0 + ONE_ROOT) && lower.iter().any(twice)
        };
        let upper: Vec<f64> = upper.iter().copied().filter(|x| !again(x)).collect();
        self.found.proven.truncate(split);
        self.found.proven.extend(upper);
        let mut index = 0;
        self.found.cancelled.retain(|&(x, _)| {
            index += 1;
            index <= cancelled || x > limit
        });
        below && above
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
