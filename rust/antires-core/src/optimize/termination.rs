//! When the islands have finished: their bests agree.
//!
//! The question is put when all islands wait, before they exchange anything (right after an
//! exchange neighbours would agree for no merit of theirs); with a polish also before the first exchange. With `b_k` the best individual of island
//! `k`, `J_k` its cost and `range_i = upper_i - lower_i`:
//!
//! - they agree in genes if `max_k b_k,i - min_k b_k,i <= gene_tolerance range_i` for every gene `i`;
//! - they agree in cost if `max_k J_k - min_k J_k <= cost_tolerance |min_k J_k| + cost_floor`.
//!
//! Agreement in genes ends the search at once. Agreement in cost ends it when it is found
//! `cost_migrations` times in a row: by then a best could have travelled that many islands, and
//! all searched on from it in vain. A single island has nobody to agree with and ends when it waits.
//!
//! Meruane (2013) knows agreement in genes only. On a flat valley (a common factor of all
//! stiffnesses and masses, a mass that no antiresonance contains) that never comes.

use super::bounds::Bounds;
use super::island::Island;
use super::options::{Agreement, IslandOptions};
use super::outcome::Status;

/// Counts agreements in cost from migration to migration.
#[derive(Debug, Default)]
pub(super) struct Consensus {
    pub(super) in_cost: usize,
}

impl Consensus {
    /// Why the search ends, or `None` if it goes on; agreements in cost count only before an exchange.
    pub(super) fn reached(
        &mut self,
        islands: &[Island],
        bounds: &Bounds,
        options: &IslandOptions,
        before_exchange: bool,
    ) -> Option<Status> {
        if let [island] = islands {
            return island.waiting().then_some(Status::Stagnated);
        }
        if agree_in_genes(islands, bounds, options.gene_tolerance) {
            return Some(Status::Agreed);
        }
        if before_exchange && options.agreement == Agreement::GenesOrCost {
            let costs = islands.iter().map(Island::best_cost);
            if agree_in_cost(costs, options.cost_tolerance, options.cost_floor) {
                self.in_cost += 1;
            } else {
                self.in_cost = 0;
            }
            if self.in_cost >= options.cost_migrations {
                return Some(Status::CostAgreed);
            }
        }
        None
    }
}

fn agree_in_genes(islands: &[Island], bounds: &Bounds, tolerance: f64) -> bool {
    let bests: Vec<&[f64]> = islands.iter().map(Island::best_row).collect();
    (0..bounds.n_genes()).all(|i| {
        let values = bests.iter().map(|best| best[i]);
        let (low, high) = extremes(values);
        high - low <= tolerance * (bounds.upper()[i] - bounds.lower()[i])
    })
}

fn agree_in_cost(costs: impl Iterator<Item = f64>, tolerance: f64, floor: f64) -> bool {
    let (low, high) = extremes(costs);
    // Infinite costs: inf - inf is NaN, and nobody agrees.
    high - low <= tolerance * low.abs() + floor
}

fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

#[cfg(test)]
mod tests {
    use super::super::island::Habitat;
    use super::super::selection::GeometricSelection;
    use super::*;

    #[test]
    fn costs_agree_relative_to_the_smallest_or_below_the_floor() {
        let agree = |costs: &[f64]| agree_in_cost(costs.iter().copied(), 1e-6, 1e-12);
        assert!(agree(&[1.0, 1.0 + 0.9e-6]) && !agree(&[1.0, 1.0 + 1.1e-6]));
        assert!(agree(&[-1.0, -1.0 - 0.9e-6]) && !agree(&[-1.0, 1.0]));
        assert!(agree(&[0.0, 0.9e-12]) && !agree(&[0.0, 1.1e-12]));
        assert!(!agree(&[1.0, f64::INFINITY]) && !agree(&[f64::INFINITY; 2]));
    }

    /// Two islands whose bests are `a` and `b` with the costs `cost_a` and `cost_b`.
    fn pair(bounds: &Bounds, options: &IslandOptions, bests: [([f64; 2], f64); 2]) -> Vec<Island> {
        let habitat = Habitat {
            bounds,
            options,
            selection: GeometricSelection::new(options.population, 0.08),
        };
        let settle = |(x, cost): &([f64; 2], f64)| {
            let mut island = Island::new(0, &habitat, 1);
            island.settle(0, x);
            let mut costs = vec![1e3; options.population];
            costs[0] = *cost;
            island.accept(&costs, options);
            island
        };
        bests.iter().map(settle).collect()
    }

    #[test]
    fn genes_agree_within_a_fraction_of_their_range() {
        let bounds = Bounds::new(vec![0.0, -100.0], vec![1.0, 100.0]).unwrap();
        let options = IslandOptions::default();
        let status = |b: [f64; 2]| {
            let islands = pair(&bounds, &options, [([0.5, 5.0], 1.0), (b, 2.0)]);
            Consensus::default().reached(&islands, &bounds, &options, true)
        };
        assert_eq!(status([0.5 + 0.9e-6, 5.0 - 190e-6]), Some(Status::Agreed));
        assert_eq!(status([0.5 + 1.1e-6, 5.0]), None);
        assert_eq!(status([0.5, 5.0 - 210e-6]), None);
    }

    #[test]
    fn costs_must_agree_at_three_migrations_in_a_row() {
        let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
        let options = IslandOptions::default();
        let even = pair(&bounds, &options, [([0.0, 0.0], 1.0), ([1.0, 1.0], 1.0)]);
        let odd = pair(&bounds, &options, [([0.0, 0.0], 1.0), ([1.0, 1.0], 1.1)]);
        let mut consensus = Consensus::default();
        let mut ask = |islands| consensus.reached(islands, &bounds, &options, true);
        assert_eq!([ask(&even), ask(&even), ask(&odd)], [None; 3]);
        assert_eq!([ask(&even), ask(&even)], [None; 2]);
        assert_eq!(ask(&even), Some(Status::CostAgreed));

        let paper = IslandOptions {
            agreement: Agreement::Genes,
            ..options
        };
        let mut consensus = Consensus::default();
        assert!((0..9).all(|_| consensus.reached(&even, &bounds, &paper, true).is_none()));
    }
}
