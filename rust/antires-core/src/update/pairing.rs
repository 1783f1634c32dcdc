//! Pairing: every measured antiresonance takes the nearest analytic one, in Hz, ties to the lower.
//! One analytic value may serve several measured ones.

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
    fn the_residual_is_the_relative_difference_of_squares() {
        assert!((residual(Some(1.1), 1.0) - 0.21).abs() < 1e-15);
        assert_eq!(residual(None, 5.0), 1.0);
    }
}
