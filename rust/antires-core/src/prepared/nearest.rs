//! Each value with the nearest root: which severities are worth a closer look, and where sets settle.

use std::ops::Range;

use super::evidence::{Evidence, FURTHEST, evidence};
use super::look::look;
use super::tables::{Places, Tables, Test, mixed};
use crate::linalg::wide::widest;

/// Further from every root than this (ln f) a value counts as unexplained.
const FAR: f64 = 0.2;
/// Degrees of freedom of the errors: few, so that a false value hardly counts.
const FREEDOM: f64 = 4.0;
/// Precision of u where nothing sees it; longest step of u.
const BLIND: f64 = 1e-2;
const LONGEST: f64 = 0.7;
/// Factors that a product of 64 bits can have without overflow.
const FACTORS: usize = 32;

/// How much is left unexplained by a set with one element more, at each level of its severity.
#[derive(Clone, Debug)]
pub struct Left {
    /// Sums of distances, (further, levels).
    pub distance: Vec<f64>,
    /// Sums of ln(1 + distance² / (freedom · variance)), (further, levels).
    pub misfit: Vec<f64>,
}

/// Variance of each value about the root that is nearest without damage.
pub fn variances(t: &Tables<'_>, test: &Test) -> Vec<f64> {
    let start = Places::new(t, &[], &[]);
    (0..test.log_f.len())
        .map(|i| {
            let own = nearest(t, &start, test.response[i], test.log_f[i])
                .map_or(FAR * FAR, |k| t.spread[k * t.size() + k]);
            own + test.common.powi(2) + test.std[i].powi(2)
        })
        .collect()
}

fn of_response(t: &Tables<'_>, response: i64) -> Range<usize> {
    t.response.partition_point(|&r| r < response)..t.response.partition_point(|&r| r <= response)
}

fn nearest(t: &Tables<'_>, at: &Places, response: i64, log_f: f64) -> Option<usize> {
    let (mut best, mut least) = (None, f64::INFINITY);
    for k in of_response(t, response).filter(|&k| at.there[k]) {
        let apart = (at.place[k] - log_f).abs();
        if apart < least {
            (least, best) = (apart, Some(k));
        }
    }
    best
}

/// Levels side by side.
const BLOCK: usize = 8;

widest!(
    /// Sums of distances and misfits at each level.
    fn scan(
        log_f: &[f64],
        weight: &[f64],
        groups: &[(&[usize], Range<usize>)],
        places: &[[f64; BLOCK]],
    ) -> ([f64; BLOCK], [f64; BLOCK]) {
        let (mut distance, mut misfit) = ([0.0; BLOCK], [0.0; BLOCK]);
        let (mut product, mut factors) = ([1.0_f64; BLOCK], 0);
        for (own, roots) in groups {
            for &i in *own {
                let mut least = [FAR; BLOCK];
                for place in &places[roots.clone()] {
                    for l in 0..BLOCK {
                        let apart = (place[l] - log_f[i]).abs();
                        least[l] = if apart < least[l] { apart } else { least[l] };
                    }
                }
                for l in 0..BLOCK {
                    distance[l] += least[l];
                    product[l] *= 1.0 + least[l] * least[l] * weight[i];
                }
                factors += 1;
                if factors == FACTORS {
                    for l in 0..BLOCK {
                        misfit[l] += product[l].ln();
                    }
                    (product, factors) = ([1.0; BLOCK], 0);
                }
            }
        }
        for l in 0..BLOCK {
            misfit[l] += product[l].ln();
        }
        (distance, misfit)
    }
);

/// All severities of one more element tried, the others as they are.
pub fn scanned(t: &Tables<'_>, test: &Test, at: &Places, further: &[usize], variance: &[f64]) -> Left {
    let (levels, size) = (t.levels.len(), t.size());
    let weight: Vec<f64> = variance.iter().map(|v| 1.0 / (FREEDOM * v)).collect();
    let none = vec![f64::INFINITY; further.len() * levels];
    let mut left = Left { distance: none.clone(), misfit: none };
    // Values of one response, of whatever set, stand together.
    let mut order: Vec<usize> = (0..test.log_f.len()).collect();
    order.sort_by_key(|&i| test.response[i]);
    let mut groups = Vec::new();
    for own in order.chunk_by(|&i, &j| test.response[i] == test.response[j]) {
        groups.push((own, of_response(t, test.response[own[0]])));
    }
    let (mut by_u, mut places) = (vec![0.0; size], vec![[f64::INFINITY; BLOCK]; size]);
    for (nth, &e) in further.iter().enumerate() {
        for k in 0..size {
            by_u[k] = 0.0;
            if t.old[k] && !at.elements.is_empty() {
                let both: f64 = at.elements.iter().zip(&at.u).map(|(&a, u)| mixed(t, a, e, k) * u).sum();
                by_u[k] = at.slope(t, k, e) - f64::from(t.slope_row(0, 0, k)[e]) - both;
            }
        }
        for first in (1..levels).step_by(BLOCK) {
            let count = BLOCK.min(levels - first);
            for (l, level) in (first..first + count).enumerate() {
                let (from, u) = (t.at(e, level), t.levels[level]);
                for k in 0..size {
                    let there = t.there[from + k] && (at.there[k] || !t.old[k]);
                    let shift = if t.old[k] { at.place[k] - t.place[k] + by_u[k] * u } else { 0.0 };
                    places[k][l] = if there { t.place[from + k] + shift } else { f64::INFINITY };
                }
                for (&a, ua) in at.elements.iter().zip(&at.u) {
                    let (here, start) = (t.slopes_by(a, e, level), t.slopes_by(a, 0, 0));
                    for k in (0..size).filter(|&k| t.old[k]) {
                        places[k][l] += f64::from(here[k] - start[k]) * ua;
                    }
                }
            }
            let (distance, misfit) = scan(&test.log_f, &weight, &groups, &places);
            let own = nth * levels + first;
            left.distance[own..own + count].copy_from_slice(&distance[..count]);
            left.misfit[own..own + count].copy_from_slice(&misfit[..count]);
        }
    }
    left
}

/// Severities that explain more, by a few steps with weights that a false value hardly has; and what is left.
pub fn refined(
    t: &Tables<'_>,
    test: &Test,
    elements: &[usize],
    u: &[f64],
    (steps, outside): (usize, f64),
    variance: &[f64],
) -> (Vec<f64>, f64) {
    let (mut u, n, mut left) = (u.to_vec(), u.len(), 0.0);
    for nth in 0..=steps {
        let at = Places::new(t, elements, &u);
        let (mut matrix, mut gain, mut slope) = (vec![0.0; n * n], vec![-1.0; n], vec![0.0; n]);
        left = u.iter().sum();
        for i in 0..test.log_f.len() {
            let Some(k) = nearest(t, &at, test.response[i], test.log_f[i]) else {
                left += (1.0 + FAR * FAR / (FREEDOM * variance[i])).ln() * 0.5 * (FREEDOM + 1.0);
                continue;
            };
            let residual = (test.log_f[i] - at.place[k]).clamp(-FAR, FAR);
            let moved = outside * (at.place[k] - t.place[k]).clamp(-FAR, FAR);
            let own = variance[i] + moved * moved;
            let odd = 1.0 + residual * residual / (FREEDOM * own);
            left += 0.5 * (FREEDOM + 1.0) * odd.ln() + 0.5 * (own / variance[i]).ln();
            let weight = 1.0 / (own * odd);
            for a in 0..n {
                slope[a] = at.slope(t, k, elements[a]);
            }
            for a in 0..n {
                gain[a] += weight * slope[a] * residual;
                for b in 0..n {
                    matrix[a * n + b] += weight * slope[a] * slope[b];
                }
            }
        }
        if nth == steps {
            break;
        }
        for a in 0..n {
            matrix[a * n + a] += BLIND;
        }
        for (x, step) in u.iter_mut().zip(solved(&mut matrix, gain)) {
            *x = (*x + step.clamp(-LONGEST, LONGEST)).clamp(0.0, FURTHEST);
        }
    }
    (u, left)
}

/// x of A x = b, A symmetric and positive definite.
fn solved(a: &mut [f64], mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for p in 0..n {
        let pivot = a[p * n + p].max(1e-300);
        for i in p + 1..n {
            let c = a[i * n + p] / pivot;
            for j in p..n {
                a[i * n + j] -= c * a[p * n + j];
            }
            b[i] -= c * b[p];
        }
    }
    for p in (0..n).rev() {
        let sum: f64 = (p + 1..n).map(|j| a[p * n + j] * b[j]).sum();
        b[p] = (b[p] - sum) / a[p * n + p].max(1e-300);
    }
    b
}

// ---- settle

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
pub fn settled(
    t: &Tables<'_>,
    test: &Test,
    elements: &[usize],
    u: &[f64],
    (looks, rests): (usize, f64),
) -> Settled {
    let mut u: Vec<f64> = u.iter().map(|x| x.clamp(0.0, FURTHEST)).collect();
    for nth in 1.. {
        let seen = look(t, test, &Places::new(t, elements, &u), elements);
        let found = evidence(seen.log_likelihood, &seen.gain, &seen.curvature, &u);
        let apart = found.u.iter().zip(&u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if nth >= looks || apart < rests {
            return Settled { u, seen: found, log_likelihood: seen.log_likelihood };
        }
        for (x, ahead) in u.iter_mut().zip(found.u) {
            *x += (ahead - *x).clamp(-LONGEST, LONGEST);
        }
    }
    unreachable!("the loop ends by itself")
}
