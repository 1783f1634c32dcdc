//! Logarithms of probabilities of the standard normal distribution.
//!
//! Near the middle by the series of its integral, in the tail by the continued fraction of Mills's ratio
//! (M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions, 26.2.11 and 26.2.14).

use std::f64::consts::{LN_2, PI};

/// From here on the continued fraction.
const TAIL: f64 = 3.0;
/// Its terms there: more than double precision needs.
const TERMS: usize = 60;

/// ln of the probability below `x`.
#[must_use]
pub fn log_below(x: f64) -> f64 {
    if x < -TAIL {
        return log_tail(-x);
    }
    if x > TAIL {
        return (-log_tail(x).exp()).ln_1p();
    }
    let (mut term, mut sum, mut k) = (x, x, 1.0);
    while term.abs() > 1e-17 * sum.abs() {
        k += 2.0;
        term *= x * x / k;
        sum += term;
    }
    let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    (0.5 + density * sum).ln()
}

/// ln of the probability above z > 0, far out.
fn log_tail(z: f64) -> f64 {
    if z > 1e150 {
        return f64::NEG_INFINITY;
    }
    let mut ratio = z;
    for k in (1..=TERMS).rev() {
        ratio = z + k as f64 / ratio;
    }
    -0.5 * z * z - 0.5 * (2.0 * PI).ln() - ratio.ln()
}

/// ln of the probability between two limits.
#[must_use]
pub fn log_between(low: f64, high: f64) -> f64 {
    // The tail is resolved on the negative side.
    let (low, high) = if low > 0.0 {
        (-high, -low)
    } else {
        (low, high)
    };
    let (top, bottom) = (log_below(high), log_below(low));
    let apart = bottom - top;
    // ln(1 − e^apart), by whichever way keeps its digits.
    top + if apart > -LN_2 {
        (-apart.min(-1e-15).exp_m1()).ln()
    } else {
        (-apart.exp()).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use super::{log_below, log_between};

    /// ln Φ(x), as SciPy's `log_ndtr` has it.
    #[test]
    fn logarithms_are_right() {
        let known = [
            (-30.0, -454.321_243_956_343_27),
            (-6.0, -20.736_768_949_974_71),
            (-3.0, -6.607_726_221_510_35),
            (-1.0, -1.841_021_645_009_264),
            (0.0, -std::f64::consts::LN_2),
            (1.5, -0.069_143_455_612_233_99),
            (4.0, -3.167_174_337_748_920_6e-5),
        ];
        for (x, expected) in known {
            let apart: f64 = log_below(x) / expected - 1.0;
            assert!(apart.abs() < 1e-11, "{x}: {}", log_below(x));
        }
    }

    #[test]
    fn both_sides_are_alike() {
        for (low, high) in [(0.5, 2.0), (3.5, 3.6), (7.0, 9.0), (-1.0, 0.0)] {
            let (one, other) = (log_between(low, high), log_between(-high, -low));
            assert!((one - other).abs() < 1e-9 * one.abs());
        }
        let narrow = log_between(0.3, 0.3 + 1e-9);
        let density = -0.5 * 0.09 - 0.5 * (2.0 * std::f64::consts::PI).ln() + 1e-9_f64.ln();
        assert!((narrow - density).abs() < 1e-6);
    }
}
