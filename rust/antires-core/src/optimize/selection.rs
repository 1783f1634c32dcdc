//! Normalized geometric selection: who becomes a parent depends on rank alone.
//!
//! The individual of rank `r` (1 the best, `P` the worst) is chosen with probability
//!
//! ```text
//! P(r) = q' (1 - q)^(r - 1),    q' = q / (1 - (1 - q)^P)
//! ```
//!
//! where `q` is the probability of choosing the best in an endless population. Only the order of
//! the costs counts, so their scale does not, and infinite costs do no harm.
//!
//! J. A. Joines, C. R. Houck, On the use of non-stationary penalty functions to solve nonlinear
//! constrained optimization problems with GA's, Proc. 1st IEEE Conf. Evolutionary Computation
//! (1994) 579-584, doi 10.1109/ICEC.1994.349995; C. R. Houck, J. A. Joines, M. G. Kay, A genetic
//! algorithm for function optimization: a Matlab implementation (GAOT), NCSU-IE TR 95-09 (1995).

use crate::rng::Rng;

/// The cumulative probabilities of the ranks.
#[derive(Debug, Clone)]
pub(super) struct GeometricSelection {
    cumulative: Vec<f64>,
}

impl GeometricSelection {
    /// The table for `population` individuals and `0 < q < 1`.
    pub(super) fn new(population: usize, q: f64) -> Self {
        let mut terms: Vec<f64> = (0..population)
            .scan(1.0, |power, _| {
                let term = q * *power;
                *power *= 1.0 - q;
                Some(term)
            })
            .collect();
        // Dividing by the sum is the factor q'/q, without its 0/0 for tiny q.
        let total: f64 = terms.iter().sum();
        let mut sum = 0.0;
        for term in &mut terms {
            sum += *term;
            *term = sum / total;
        }
        Self { cumulative: terms }
    }

    /// Draws a rank, counted from 0 for the best.
    #[inline]
    pub(super) fn draw(&self, rng: &mut Rng) -> usize {
        let u = rng.unit();
        let rank = self.cumulative.partition_point(|&c| c <= u);
        // The last entry may be rounded below 1.
        rank.min(self.cumulative.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ranks_are_drawn_with_the_probabilities_of_the_formula() {
        let (population, q) = (40_usize, 0.08_f64);
        let selection = GeometricSelection::new(population, q);
        let mut rng = Rng::new(11, 0);
        let mut counts = vec![0_u32; population];
        let draws = 400_000_u32;
        for _ in 0..draws {
            counts[selection.draw(&mut rng)] += 1;
        }
        let mut p = q / (1.0 - (1.0 - q).powi(40));
        let mut total = 0.0;
        let mut chi2 = 0.0;
        for &count in &counts {
            total += p;
            let expected = p * f64::from(draws);
            chi2 += (f64::from(count) - expected).powi(2) / expected;
            p *= 1.0 - q;
        }
        assert!((total - 1.0).abs() < 1e-12);
        // Chi-square with 39 degrees of freedom: 72.1 has probability 0.001.
        assert!(chi2 < 72.1, "chi-square {chi2}");
    }

    #[test]
    fn the_table_ends_at_one_even_for_extreme_q() {
        for q in [1e-12, 0.08, 0.999] {
            let selection = GeometricSelection::new(40, q);
            assert!((selection.cumulative[39] - 1.0).abs() < 1e-12);
            assert!(selection.cumulative.is_sorted());
        }
        // A tiny q leaves every rank equally likely.
        let even = GeometricSelection::new(4, 1e-12).cumulative;
        assert!((even[0] - 0.25).abs() < 1e-9 && (even[2] - 0.75).abs() < 1e-9);
    }
}
