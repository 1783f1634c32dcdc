//! Mutation: with probability `p_m` a gene forgets its parents.
//!
//! Each gene mutates independently; a mutating gene undergoes one of two kinds, equally likely:
//!
//! - boundary: the lower or the upper bound, equally likely. Where the optimum lies on a bound (an
//!   undamaged element, `beta = 0`), this kind finds it exactly;
//! - uniform: anywhere between the bounds.
//!
//! Z. Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs, 3rd ed., Springer
//! (1996). How Meruane (2013) shares `p_m` between the two is not printed.

use super::bounds::Bounds;
use crate::rng::Rng;

/// Mutates each gene of `x` with probability `p`.
pub(super) fn mutate(x: &mut [f64], p: f64, bounds: &Bounds, rng: &mut Rng) {
    for (i, gene) in x.iter_mut().enumerate() {
        if rng.coin(p) {
            let (lo, hi) = (bounds.lower()[i], bounds.upper()[i]);
            let boundary = rng.coin(0.5);
            *gene = match boundary {
                true if rng.coin(0.5) => lo,
                true => hi,
                false => rng.uniform(lo, hi),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn genes_mutate_at_the_rate_and_shares_of_the_definition() {
        let bounds = Bounds::uniform(10, -1.0, 3.0).unwrap();
        let mut rng = Rng::new(2, 0);
        let (mut lower, mut upper, mut inside) = (0, 0, 0);
        let trials = 20_000;
        for _ in 0..trials {
            // A mark no mutation can produce tells touched genes from untouched.
            let mut x = [7.0; 10];
            mutate(&mut x, 0.02, &bounds, &mut rng);
            for gene in x {
                if gene == -1.0 {
                    lower += 1;
                } else if gene == 3.0 {
                    upper += 1;
                } else if gene != 7.0 {
                    assert!(bounds.admits(0, gene));
                    inside += 1;
                }
            }
        }
        // 200,000 genes: 1000 each at the bounds, 2000 inside; four standard deviations around.
        assert!((875..=1125).contains(&lower), "{lower} at the lower bound");
        assert!((875..=1125).contains(&upper), "{upper} at the upper bound");
        assert!((1820..=2180).contains(&inside), "{inside} inside");
    }

    #[test]
    fn probability_zero_touches_nothing() {
        let bounds = Bounds::uniform(50, 0.0, 1.0).unwrap();
        let mut x = [7.0; 50];
        mutate(&mut x, 0.0, &bounds, &mut Rng::new(1, 0));
        assert_eq!(x, [7.0; 50]);
    }
}
