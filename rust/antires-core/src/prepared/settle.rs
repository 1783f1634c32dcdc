//! The most probable severities of sets of elements, and their evidence.

use super::evidence::{Evidence, FURTHEST, evidence};
use super::expected::Errors;
use super::look::look;
use super::places::Places;
use super::tables::Tables;
use super::values::Test;

/// Longest step of u.
const LONGEST: f64 = 0.7;

/// Where a set has come to.
#[derive(Clone, Debug)]
pub struct Settled {
    /// Severities of the last look.
    pub u: Vec<f64>,
    /// What is seen from there.
    pub seen: Evidence,
    /// At the severities of the last look.
    pub log_likelihood: f64,
}

/// Newton steps from `u` until they are shorter than `rests`, by at most `looks`.
#[must_use]
pub fn settled(
    t: &Tables<'_>,
    test: &Test<'_>,
    elements: &[usize],
    u: &[f64],
    (looks, rests): (usize, f64),
    errors: Errors,
) -> Settled {
    let mut u: Vec<f64> = u.iter().map(|x| x.clamp(0.0, FURTHEST)).collect();
    for nth in 1.. {
        let seen = look(t, test, &Places::new(t, elements, &u), elements, errors);
        let found = evidence(seen.log_likelihood, &seen.gain, &seen.curvature, &u);
        let apart = found
            .u
            .iter()
            .zip(&u)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        if nth >= looks || apart < rests {
            return Settled {
                u,
                seen: found,
                log_likelihood: seen.log_likelihood,
            };
        }
        for (x, ahead) in u.iter_mut().zip(found.u) {
            *x += (ahead - *x).clamp(-LONGEST, LONGEST);
        }
    }
    unreachable!("the loop ends by itself")
}
