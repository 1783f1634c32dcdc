//! Blend crossover BLX-alpha: every gene uniform over the parents' interval, extended.
//!
//! ```text
//! c_i ~ U(min(a_i, b_i) - alpha d_i, max(a_i, b_i) + alpha d_i),    d_i = |a_i - b_i|
//! ```
//!
//! independently per gene and child; with `alpha = 0.5` neither contraction nor expansion is
//! favoured. A gene that falls outside its bounds is set to the bound it passed.
//!
//! L. J. Eshelman, J. D. Schaffer, Real-coded genetic algorithms and interval-schemata, Foundations
//! of Genetic Algorithms 2 (1993) 187-202.

use super::super::bounds::Bounds;
use crate::rng::Rng;

pub(super) fn cross(
    a: &[f64],
    b: &[f64],
    alpha: f64,
    bounds: &Bounds,
    rng: &mut Rng,
    c: &mut [f64],
) {
    for i in 0..a.len() {
        let reach = alpha * (a[i] - b[i]).abs();
        c[i] = rng.uniform(a[i].min(b[i]) - reach, a[i].max(b[i]) + reach);
    }
    bounds.clip(c);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_fill_the_extended_interval_evenly() {
        let bounds = Bounds::uniform(1, -100.0, 100.0).unwrap();
        let mut rng = Rng::new(8, 0);
        let mut counts = [0_u32; 8];
        let draws = 80_000;
        let mut c = [0.0];
        for _ in 0..draws {
            // Parents 1 and 3: the interval is [0, 4], in eight cells of a half.
            cross(&[3.0], &[1.0], 0.5, &bounds, &mut rng, &mut c);
            assert!((0.0..=4.0).contains(&c[0]));
            counts[((2.0 * c[0]) as usize).min(7)] += 1;
        }
        let expected = f64::from(draws) / 8.0;
        let chi2: f64 = counts
            .iter()
            .map(|&n| (f64::from(n) - expected).powi(2) / expected)
            .sum();
        // Chi-square with 7 degrees of freedom: 24.3 has probability 0.001.
        assert!(chi2 < 24.3, "chi-square {chi2}, counts {counts:?}");
    }

    #[test]
    fn what_passes_a_bound_lands_exactly_on_it() {
        let bounds = Bounds::uniform(1, 0.0, 1.0).unwrap();
        let mut rng = Rng::new(8, 1);
        let mut c = [0.0];
        let mut zeros = 0;
        for _ in 0..10_000 {
            // The interval is [-0.2, 0.6]: a quarter of it lies below the bound.
            cross(&[0.0], &[0.4], 0.5, &bounds, &mut rng, &mut c);
            assert!(bounds.contain(&c));
            zeros += u32::from(c[0] == 0.0);
        }
        assert!((2320..=2680).contains(&zeros), "{zeros} zeros");
    }
}
