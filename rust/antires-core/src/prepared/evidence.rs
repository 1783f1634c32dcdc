//! The evidence of a set of at most three elements, from one look.
//!
//! ln f is linear in u near a point and all severities are equally probable, so that it is the integral of a
//! Gaussian times e^(−Σu) over the box of u; see `damage.inference` of the package.
//!
//! # normal
//!
//! Logarithms of probabilities of the standard normal distribution.
//!
//! Near the middle by the series of its integral, in the tail by the continued fraction of Mills's ratio
//! (M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions, 26.2.11 and 26.2.14).

use std::f64::consts::{LN_2, PI};
use std::sync::OnceLock;

/// Largest severity, and the same as u.
pub const HIGHEST: f64 = 0.99;
/// −ln(1 − [`HIGHEST`]).
pub const FURTHEST: f64 = 4.605_170_185_988_091;
/// Precision of u where nothing sees it.
const BLIND: f64 = 1e-2;
/// Coordinates so many standard deviations from both bounds do not count.
const FAR: f64 = 5.0;
/// Points of the rule along each coordinate but the last, and how far they reach (scales of decay).
const POINTS: usize = 20;
const REACH: f64 = 7.0;

/// What a look says of a set.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// ln of the evidence.
    pub log: f64,
    /// Most probable u, in the box.
    pub u: Vec<f64>,
    /// Mean of u without the box.
    pub mean: Vec<f64>,
    /// Its covariance (k, k).
    pub covariance: Vec<f64>,
}

type Square = [[f64; 3]; 3];

/// Inverse of a positive definite matrix, and ln of its determinant.
fn inverse(a: &Square, k: usize) -> (Square, f64) {
    let (mut a, mut inverse, mut log) = (*a, [[0.0; 3]; 3], 0.0);
    for i in 0..k {
        inverse[i][i] = 1.0;
    }
    for p in 0..k {
        let pivot = a[p][p].max(1e-300);
        log += pivot.ln();
        for j in 0..k {
            a[p][j] /= pivot;
            inverse[p][j] /= pivot;
        }
        for i in (0..k).filter(|&i| i != p) {
            let c = a[i][p];
            for j in 0..k {
                a[i][j] -= c * a[p][j];
                inverse[i][j] -= c * inverse[p][j];
            }
        }
    }
    (inverse, log)
}

/// Most probable point in the box: those outside are put on their bound, the worst first.
fn peak(mean: [f64; 3], covariance: &Square, k: usize) -> [f64; 3] {
    let (mut best, mut spread, mut free) = (mean, *covariance, [true; 3]);
    for _ in 0..k {
        let mut worst = (0.0, usize::MAX, 0.0);
        for i in (0..k).filter(|&i| free[i]) {
            let sd = spread[i][i].sqrt();
            let (below, above) = (-best[i] / sd, (best[i] - FURTHEST) / sd);
            if below.max(above) > worst.0 {
                worst = (below.max(above), i, if below > above { 0.0 } else { FURTHEST });
            }
        }
        let (_, w, bound) = worst;
        if w == usize::MAX {
            break;
        }
        let gain: [f64; 3] = std::array::from_fn(|i| spread[i][w] / spread[w][w]);
        let (step, row) = (bound - best[w], spread[w]);
        for i in 0..k {
            best[i] += gain[i] * step;
            for j in 0..k {
                spread[i][j] -= gain[i] * row[j];
            }
        }
        free[w] = false;
        spread[w][w] = 1.0;
    }
    best.map(|x| x.clamp(0.0, FURTHEST))
}

/// Points and weights of Gauss and Legendre on [−1, 1].
fn rule() -> &'static [(f64, f64); POINTS] {
    static RULE: OnceLock<[(f64, f64); POINTS]> = OnceLock::new();
    RULE.get_or_init(|| {
        std::array::from_fn(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (POINTS as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut before, mut here) = (1.0, x);
                for n in 2..=POINTS {
                    let n = n as f64;
                    (before, here) = (here, ((2.0 * n - 1.0) * x * here - (n - 1.0) * before) / n);
                }
                slope = POINTS as f64 * (x * here - before) / (x * x - 1.0);
                x -= here / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
    })
}

/// ln of the probability of the box.
fn log_inside(mean: [f64; 3], covariance: &Square, k: usize) -> f64 {
    if k == 0 {
        return 0.0;
    }
    let sd = covariance[0][0].sqrt();
    if k == 1 {
        return log_between(-mean[0] / sd, (FURTHEST - mean[0]) / sd);
    }
    let top = peak(mean, covariance, k)[0];
    let decay = sd * sd / (mean[0] - top).abs().max(sd);
    let (low, high) = ((top - REACH * decay).max(0.0), (top + REACH * decay).min(FURTHEST));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let gain: [f64; 3] = std::array::from_fn(|i| covariance[i][0] / covariance[0][0]);
    let mut rest = [[0.0; 3]; 3];
    for i in 1..k {
        for j in 1..k {
            rest[i - 1][j - 1] = covariance[i][j] - gain[i] * covariance[0][j];
        }
    }
    let logs = rule().map(|(x, weight)| {
        let at = middle + half * x;
        let z = (at - mean[0]) / sd;
        let mut given = [0.0; 3];
        for i in 1..k {
            given[i - 1] = mean[i] + gain[i] * (at - mean[0]);
        }
        let density = -0.5 * z * z - 0.5 * (2.0 * PI).ln() - sd.ln();
        density + (weight * half).ln() + log_inside(given, &rest, k - 1)
    });
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + logs.iter().map(|x| (x - most).exp()).sum::<f64>().ln()
}

/// Of a set whose severities are `u` where the look is from, by the gradient and Hessian (k, k) by them.
pub fn evidence(log_likelihood: f64, gain: &[f64], curvature: &[f64], u: &[f64]) -> Evidence {
    let k = u.len();
    let room: Vec<f64> = u.iter().map(|x| (-x).exp()).collect();
    let mut matrix = [[0.0; 3]; 3];
    for i in 0..k {
        for j in 0..k {
            matrix[i][j] = curvature[i * k + j] * room[i] * room[j];
        }
        matrix[i][i] += BLIND;
    }
    let (covariance, log_size) = inverse(&matrix, k);
    let (mut mean, mut rise) = ([0.0; 3], 0.0);
    for i in 0..k {
        let step: f64 = (0..k).map(|j| covariance[i][j] * (gain[j] * room[j] - 1.0)).sum();
        mean[i] = u[i] + step;
        rise += 0.5 * (gain[i] * room[i] - 1.0) * step;
    }
    let best = peak(mean, &covariance, k);
    // Those far from both bounds come last and out.
    let near: Vec<usize> =
        (0..k).filter(|&i| mean[i].min(FURTHEST - mean[i]) < FAR * covariance[i][i].sqrt()).collect();
    let (mut of_near, mut means) = ([[0.0; 3]; 3], [0.0; 3]);
    for (i, &a) in near.iter().enumerate() {
        means[i] = mean[a];
        for (j, &b) in near.iter().enumerate() {
            of_near[i][j] = covariance[a][b];
        }
    }
    let size = k as f64;
    let volume = 0.5 * (size * (2.0 * PI).ln() - log_size) - size * HIGHEST.ln() - u.iter().sum::<f64>();
    Evidence {
        log: log_likelihood + rise + volume + log_inside(means, &of_near, near.len()),
        u: best[..k].to_vec(),
        mean: mean[..k].to_vec(),
        covariance: covariance[..k].iter().flat_map(|row| row[..k].to_vec()).collect(),
    }
}

// ---- normal

/// From here on the continued fraction.
const TAIL: f64 = 3.0;
/// Its terms there: more than double precision needs.
const TERMS: usize = 60;

/// ln of the probability below `x`.
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
pub fn log_between(low: f64, high: f64) -> f64 {
    // The tail is resolved on the negative side.
    let (low, high) = if low > 0.0 { (-high, -low) } else { (low, high) };
    let (top, bottom) = (log_below(high), log_below(low));
    let apart = bottom - top;
    // ln(1 − e^apart), by whichever way keeps its digits.
    top + if apart > -LN_2 { (-apart.min(-1e-15).exp_m1()).ln() } else { (-apart.exp()).ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same integral by a fine grid of midpoints.
    #[test]
    fn the_integral_is_that_of_a_grid() {
        let (gain, curvature, u) = ([3.0, -2.0], [40.0, 12.0, 12.0, 30.0], [0.3, 0.1]);
        let found = evidence(-5.0, &gain, &curvature, &u);
        let room = u.map(|x: f64| (-x).exp());
        let (steps, mut sum) = (3000, 0.0);
        let width = FURTHEST / f64::from(steps);
        for i in 0..steps {
            for j in 0..steps {
                let x = [(f64::from(i) + 0.5) * width, (f64::from(j) + 0.5) * width];
                let by = [(x[0] - u[0]) * room[0], (x[1] - u[1]) * room[1]];
                let mut log = gain[0] * by[0] + gain[1] * by[1] - x[0] - x[1];
                for a in 0..2 {
                    for b in 0..2 {
                        log -= 0.5 * by[a] * curvature[2 * a + b] * by[b];
                    }
                    log -= 0.5 * 0.01 * (x[a] - u[a]).powi(2);
                }
                sum += log.exp() * width * width;
            }
        }
        let expected = -5.0 + f64::ln(sum) - 2.0 * f64::ln(HIGHEST);
        assert!((found.log - expected).abs() < 2e-3, "{} {expected}", found.log);
        assert!(found.u[1] == 0.0 && found.u[0] > 0.3);
    }

    #[test]
    fn three_without_correlation_are_a_product() {
        let covariance = [[0.04, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.09]];
        let mean = [0.05, -0.1, 0.2];
        let product: f64 = (0..3)
            .map(|i| {
                let mut one = [[0.0; 3]; 3];
                one[0][0] = covariance[i][i];
                log_inside([mean[i], 0.0, 0.0], &one, 1)
            })
            .sum();
        assert!((log_inside(mean, &covariance, 3) - product).abs() < 1e-3);
    }

    #[test]
    fn the_rule_integrates_polynomials() {
        let of = |power: i32| rule().iter().map(|(x, w)| w * x.powi(power)).sum::<f64>();
        assert!((of(0) - 2.0).abs() < 1e-13);
        assert!((of(10) - 2.0 / 11.0).abs() < 1e-13);
    }

    /// ln Φ(x), as SciPy's `log_ndtr` has it.
    #[test]
    fn logarithms_are_right() {
        let known = [
            (-30.0, -454.321_243_956_343_27),
            (-6.0, -20.736_768_949_974_71),
            (-3.0, -6.607_726_221_510_35),
            (-1.0, -1.841_021_645_009_264),
            (0.0, -LN_2),
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
        let density = -0.5 * 0.09 - 0.5 * (2.0 * PI).ln() + 1e-9_f64.ln();
        assert!((narrow - density).abs() < 1e-6);
    }
}
