//! Pairing: which analytic value stands for a measured one, anew at every evaluation. One analytic value may
//! serve several measured ones.
//!
//! An antiresonance takes the nearest in Hz, ties to the lower. A mode takes the one least apart,
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

/// The value of ascending `analytic_hz` nearest to `measured_hz`, or none when it is empty.
#[must_use]
pub fn nearest(analytic_hz: &[f64], measured_hz: f64) -> Option<f64> {
    let above = analytic_hz.partition_point(|&a| a < measured_hz);
    match (
        above.checked_sub(1).map(|i| analytic_hz[i]),
        analytic_hz.get(above),
    ) {
        (Some(low), Some(&high)) => Some(if high - measured_hz < measured_hz - low {
            high
        } else {
            low
        }),
        (low, high) => low.or(high.copied()),
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
        assert_eq!(nearest(&analytic, 0.1), Some(1.0));
        assert_eq!(nearest(&analytic, 1.4), Some(1.0));
        assert_eq!(nearest(&analytic, 3.0), Some(2.0));
        assert_eq!(nearest(&analytic, 3.1), Some(4.0));
        assert_eq!(nearest(&analytic, 9.0), Some(4.0));
        assert_eq!(nearest(&[], 9.0), None);
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
