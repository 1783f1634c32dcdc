//! Pairing: which analytic value stands for a measured one, anew at every evaluation. One analytic value may
//! serve several measured ones.
//!
//! An antiresonance takes the nearest in Hz, ties to the lower, and fades out at the edge of the band in which the
//! model is asked for antiresonances. A mode takes the one least apart,
//!
//! ```text
//! |ln(ω_A² / ω_E²)| + (1 − MAC)²,        ties to the lower
//! ```
//!
//! The shapes decide among modes of like frequency: where two have changed places each keeps its own. As the
//! second term is at most one, no shape makes up for a frequency that is off by more than a factor √e = 1.65
//! beyond another's; so a mode far away takes no partner from a nearer one however alike the two look at a
//! few sensors, and a rigid-body mode, at ω = 0, takes none at all. With a single sensor, where every MAC is
//! one, this is the nearest frequency. Near a match the measure is what the pair adds to J, of which this
//! pairing is the lower envelope, so that J hardly jumps where a partner changes.

/// Residual given to a measured value when the model has no antiresonance to offer.
pub const UNPAIRED: f64 = 1.0;

/// The last part of the band of the analytic values in which a partner fades out: from 1.49 to 1.5 times the
/// highest measured frequency, so that all but this hundredth is e as defined. No partner there explains anything.
const FADING: f64 = 0.01 / 1.5;

/// A measured antiresonance and what the model has for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pairing {
    /// The nearest antiresonance of the model (Hz).
    pub partner_hz: Option<f64>,
    /// The residual e; [`UNPAIRED`] without a partner.
    pub residual: f64,
    /// The antiresonances (Hz) that e moves with, and ∂e/∂x_A times x_E for each, x = ω².
    pub moves_with: [Option<(f64, f64)>; 2],
}

impl Pairing {
    /// Pairs `measured_hz` with the nearest of ascending `analytic_hz`, which are all up to `limit_hz`, or none.
    ///
    /// What e would be without a partner near the limit, `e'`, comes in by degrees, so that J does not jump where
    /// an antiresonance leaves the band:
    ///
    /// ```text
    /// e = (1 − t) (f_A² / f_E² − 1) + t |e'|,   t = (f_A − f_0) / (f_limit − f_0) from f_0 = 1.49/1.5 f_limit on
    /// ```
    #[must_use]
    pub fn of(analytic_hz: &[f64], measured_hz: f64, limit_hz: f64) -> Self {
        let Some(nth) = nearest(analytic_hz, measured_hz) else {
            return Self {
                partner_hz: None,
                residual: UNPAIRED,
                moves_with: [None; 2],
            };
        };
        let hz = analytic_hz[nth];
        let e = residual(Some(hz), measured_hz);
        let width = FADING * limit_hz;
        let share = (hz - (limit_hz - width)) / width;
        if share <= 0.0 {
            return Self {
                partner_hz: Some(hz),
                residual: e,
                moves_with: [Some((hz, 1.0)), None],
            };
        }
        // All others in the band lie below the measured value, or they would be nearer.
        let below = nth.checked_sub(1).map(|i| analytic_hz[i]);
        let without = residual(below, measured_hz).abs();
        let along = 1.0 - share + (without - e) * measured_hz.powi(2) / (2.0 * hz * width);
        Self {
            partner_hz: Some(hz),
            residual: (1.0 - share) * e + share * without,
            moves_with: [Some((hz, along)), below.map(|low| (low, -share))],
        }
    }
}

/// Index of the value of ascending `analytic_hz` nearest to `measured_hz`, or none when it is empty.
#[must_use]
pub fn nearest(analytic_hz: &[f64], measured_hz: f64) -> Option<usize> {
    let above = analytic_hz.partition_point(|&a| a < measured_hz);
    let low = above.checked_sub(1);
    match (low, analytic_hz.get(above)) {
        (Some(i), Some(&high)) if high - measured_hz >= measured_hz - analytic_hz[i] => Some(i),
        (_, Some(_)) => Some(above),
        (low, None) => low,
    }
}

/// A mode of the model that stands for a measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// Number of the mode, ascending in frequency.
    pub mode: usize,
    /// λ = ω_A² in (rad/s)².
    pub lambda: f64,
    /// MAC of the two shapes.
    pub mac: f64,
}

/// The mode of ascending `lambda` least apart from one measured at `measured`, in (rad/s)²; those up to `zero` are
/// rigid-body modes and left out. None where no other is there.
#[must_use]
pub fn least_apart(
    lambda: &[f64],
    zero: f64,
    measured: f64,
    mac: impl Fn(usize) -> f64,
) -> Option<Partner> {
    let mut best: Option<(f64, Partner)> = None;
    for (mode, &lambda) in lambda.iter().enumerate().filter(|(_, l)| **l > zero) {
        let apart = (lambda / measured).ln().abs();
        let least = best.map_or(f64::INFINITY, |(least, _)| least);
        if apart >= least {
            continue;
        }
        let mac = mac(mode);
        let apart = apart + (1.0 - mac).powi(2);
        if apart < least {
            best = Some((apart, Partner { mode, lambda, mac }));
        }
    }
    best.map(|(_, partner)| partner)
}

/// e = ω_A² / ω_E² − 1 of a pair, [`UNPAIRED`] without a partner.
#[must_use]
pub fn residual(paired_hz: Option<f64>, measured_hz: f64) -> f64 {
    paired_hz.map_or(UNPAIRED, |a| (a / measured_hz).powi(2) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_takes_the_closer_neighbour_and_the_lower_on_a_tie() {
        let analytic = [1.0, 2.0, 4.0];
        assert_eq!(nearest(&analytic, 0.1), Some(0));
        assert_eq!(nearest(&analytic, 1.4), Some(0));
        assert_eq!(nearest(&analytic, 3.0), Some(1));
        assert_eq!(nearest(&analytic, 3.1), Some(2));
        assert_eq!(nearest(&analytic, 9.0), Some(2));
        assert_eq!(nearest(&[], 9.0), None);
    }

    /// e of 1 Hz (the highest measured, so that the limit is 1.5 Hz) when one antiresonance is at `hz` and the
    /// others at `low`; those beyond the limit are not seen.
    fn leaving(hz: f64, low: &[f64], measured_hz: f64) -> Pairing {
        let mut analytic = low.to_vec();
        analytic.extend((hz <= 1.5).then_some(hz));
        Pairing::of(&analytic, measured_hz, 1.5)
    }

    #[test]
    fn nothing_jumps_where_an_antiresonance_leaves_the_band() {
        // Alone; with another below; and for a lower measured value, for which it is far off.
        for (low, measured_hz) in [(&[][..], 1.0), (&[0.4], 1.0), (&[], 0.3)] {
            let step = 1e-6;
            let sizes: Vec<f64> = (0..30_000)
                .map(|i| {
                    leaving(1.48 + step * f64::from(i), low, measured_hz)
                        .residual
                        .abs()
                })
                .collect();
            let steepest = sizes
                .windows(2)
                .map(|w| (w[1] - w[0]).abs())
                .fold(0.0, f64::max);
            // Within the last 0.01 Hz it falls from what it was to what is left.
            assert!(steepest < step * (110.0 * sizes[0] + 50.0), "{steepest:e}");
            assert!((sizes[0] - residual(Some(1.48), measured_hz)).abs() < 1e-12);
            let left = residual(low.last().copied(), measured_hz).abs();
            assert!((sizes[29_999] - left).abs() < 1e-12);
        }
    }

    #[test]
    fn a_fading_residual_moves_with_both_antiresonances() {
        let (h, e) = (1e-7, 0.9);
        let at = |hz: f64, low: f64| Pairing::of(&[low, hz], e, 1.5).residual;
        let moves = Pairing::of(&[0.2, 1.496], e, 1.5).moves_with;
        for (moved, numeric) in [
            (
                moves[0],
                (at(1.496 + h, 0.2) - at(1.496 - h, 0.2)) / (2.0 * h),
            ),
            (
                moves[1],
                (at(1.496, 0.2 + h) - at(1.496, 0.2 - h)) / (2.0 * h),
            ),
        ] {
            // ∂e/∂f = ∂e/∂x · 2 f / E², with x = f² here.
            let (hz, along) = moved.unwrap();
            assert!((along * 2.0 * hz / e.powi(2) - numeric).abs() < 1e-6 * numeric.abs());
        }
        assert_eq!(
            Pairing::of(&[0.95], e, 1.5).moves_with,
            [Some((0.95, 1.0)), None]
        );
    }

    #[test]
    fn modes_keep_their_partners_where_they_cross_and_lose_none_to_far_ones() {
        let pair = |lambda: &[f64], mac: &[f64], measured: f64| {
            least_apart(lambda, 1e-6, measured, |mode| mac[mode]).map(|p| p.mode)
        };
        // Crossed: the nearer frequency has the other shape.
        assert_eq!(pair(&[1.0, 1.3], &[0.05, 0.97], 1.02), Some(1));
        // A mode far above, or a rigid-body mode, with exactly the shape.
        assert_eq!(pair(&[1.0, 3.0], &[0.0, 1.0], 1.02), Some(0));
        assert_eq!(pair(&[0.0, 1e-7, 1.0], &[1.0, 1.0, 0.2], 1.3), Some(2));
        // One sensor: the nearest frequency. Nothing to tell the two apart: the lower.
        assert_eq!(pair(&[0.8, 1.1], &[1.0, 1.0], 1.0), Some(1));
        assert_eq!(pair(&[1.0, 1.0], &[0.5, 0.5], 1.2), Some(0));
        // None but rigid-body modes; the only other one, however far.
        assert_eq!(pair(&[0.0], &[1.0], 1.0), None);
        assert_eq!(pair(&[0.0, 80.0], &[1.0, 0.0], 1.0), Some(1));
    }

    #[test]
    fn the_residual_is_the_relative_difference_of_squares() {
        assert!((residual(Some(1.1), 1.0) - 0.21).abs() < 1e-15);
        assert_eq!(residual(None, 5.0), 1.0);
    }
}
