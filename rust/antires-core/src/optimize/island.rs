//! An island: a population, the operators that renew it, and the patience to wait.
//!
//! A generation proposes `P` offspring: parents in pairs by [selection](crate::optimize::island), crossed
//! with probability `p_c` by the island's [operator](super::crossover), then
//! [mutated](crate::optimize::island), repaired and clipped. Offspring equal to a parent keep that parent's
//! cost; the others are evaluated. The offspring replace the population, except that the best
//! individual so far, if better than all of them, takes the place of the worst (elitism).
//!
//! An island whose best has not improved for `patience` generations waits.
//!
//! # selection
//!
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
//!
//! # mutation
//!
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
//!
//! # migration
//!
//! Migration: each island's best goes to both of its neighbours on a ring.
//!
//! Island `i` receives copies of the bests of islands `i - 1` and `i + 1` (modulo the number of
//! islands), as they were before any exchange, in this order; they take the places of its worst and
//! its second worst. Two islands exchange one individual each, a single island none. The best of an
//! island always stays at home too.
//!
//! # termination
//!
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
use super::crossover::Crossover;
use super::options::{Agreement, IslandOptions};
use super::outcome::{FinalIsland, IslandProgress, IslandState, Status};
use super::population::{Population, Tape};
use crate::rng::{Rng, RngState};

/// What all islands share.
pub(super) struct Habitat<'a> {
    pub(super) bounds: &'a Bounds,
    pub(super) options: &'a IslandOptions,
    pub(super) selection: GeometricSelection,
}

/// One island.
pub(super) struct Island {
    crossover: Crossover,
    rng: Rng,
    pub(super) population: Population,
    offspring: Population,
    /// Offspring that need an evaluation, ascending.
    pub(super) pending: Vec<usize>,
    ranking: Vec<usize>,
    /// Generations since the best last improved on `reference`.
    stagnant: usize,
    reference: f64,
    pub(super) waiting: bool,
}

impl Island {
    /// Island number `number`, with all of its first individuals pending.
    pub(super) fn new(number: usize, habitat: &Habitat<'_>, seed: u64) -> Self {
        let (bounds, options) = (habitat.bounds, habitat.options);
        let size = options.population;
        let mut rng = Rng::new(seed, number as u64);
        let mut first = Population::new(size, bounds.n_genes());
        for i in 0..size {
            bounds.draw(&mut rng, first.row_mut(i));
        }
        Self {
            crossover: options.crossovers[number % options.crossovers.len()],
            rng,
            population: first.clone(),
            offspring: first,
            pending: (0..size).collect(),
            ranking: Vec::with_capacity(size),
            stagnant: 0,
            reference: f64::INFINITY,
            waiting: false,
        }
    }

    /// Puts a guess in place of first individual `i`.
    pub(super) fn settle(&mut self, i: usize, guess: &[f64]) {
        self.offspring.row_mut(i).copy_from_slice(guess);
    }

    /// Repairs and clips the first individuals.
    pub(super) fn repair_first(&mut self, bounds: &Bounds, repair: &dyn Fn(&mut [f64])) {
        for i in 0..self.offspring.size() {
            let x = self.offspring.row_mut(i);
            repair(x);
            bounds.clip(x);
            self.population.row_mut(i).copy_from_slice(self.offspring.row(i));
        }
    }

    /// Proposes a generation; what needs an evaluation is then [pending](Self::pending).
    pub(super) fn propose(&mut self, habitat: &Habitat<'_>, repair: &dyn Fn(&mut [f64])) {
        self.population.rank(&mut self.ranking);
        self.pending.clear();
        let size = self.population.size();
        for i in (0..size - 1).step_by(2) {
            let (a, b) = (self.select(habitat), self.select(habitat));
            // By rank: of two parents the lower rank is the better.
            let (better, worse) = (self.ranking[a.min(b)], self.ranking[a.max(b)]);
            let (first, second) = self.offspring.pair_mut(i);
            if self.rng.coin(habitat.options.crossover_probability) {
                self.crossover.cross(
                    self.population.row(better),
                    self.population.row(worse),
                    habitat.bounds,
                    &mut self.rng,
                    first,
                    second,
                );
            } else {
                first.copy_from_slice(self.population.row(better));
                second.copy_from_slice(self.population.row(worse));
            }
            self.finish(i, [better, worse], habitat, repair);
            self.finish(i + 1, [better, worse], habitat, repair);
        }
        if size % 2 == 1 {
            let rank = self.select(habitat);
            let single = self.ranking[rank];
            let child = self.offspring.row_mut(size - 1);
            child.copy_from_slice(self.population.row(single));
            self.finish(size - 1, [single; 2], habitat, repair);
        }
    }

    /// Draws the rank of a parent.
    fn select(&mut self, habitat: &Habitat<'_>) -> usize {
        habitat.selection.draw(&mut self.rng)
    }

    /// Mutates and repairs offspring `i`; it inherits the cost of a parent it equals.
    fn finish(&mut self, i: usize, parents: [usize; 2], habitat: &Habitat<'_>, repair: &dyn Fn(&mut [f64])) {
        let child = self.offspring.row_mut(i);
        let p = habitat.options.mutation_probability;
        mutate(child, p, habitat.bounds, &mut self.rng);
        repair(child);
        habitat.bounds.clip(child);
        let same = parents.into_iter().find(|&p| self.population.row(p) == child);
        if let Some(parent) = same {
            self.offspring.set_cost(i, self.population.cost(parent));
        } else {
            self.pending.push(i);
        }
    }

    /// The genes of offspring `i`.
    pub(super) fn candidate(&self, i: usize) -> &[f64] {
        self.offspring.row(i)
    }

    /// Accepts the proposed generation, given the costs of the first pending offspring in order.
    ///
    /// Offspring without a cost (the budget was spent) leave their place to the individual there.
    pub(super) fn accept(&mut self, costs: &[f64], options: &IslandOptions) {
        for (nth, &i) in self.pending.iter().enumerate() {
            if let Some(&cost) = costs.get(nth) {
                self.offspring.set_cost(i, cost);
            } else {
                let kept = self.population.cost(i);
                self.offspring.replace(i, self.population.row(i), kept);
            }
        }
        self.pending.clear();
        let best = self.population.best();
        let best_cost = self.population.cost(best);
        if best_cost < self.offspring.cost(self.offspring.best()) {
            let worst = self.offspring.worst();
            self.offspring.replace(worst, self.population.row(best), best_cost);
        }
        std::mem::swap(&mut self.population, &mut self.offspring);
        self.count_stagnation(options);
    }

    fn count_stagnation(&mut self, options: &IslandOptions) {
        let cost = self.best_cost();
        if improves(cost, self.reference, options.improvement_tolerance) {
            self.reference = cost;
            self.stagnant = 0;
        } else {
            self.stagnant += 1;
            self.waiting = self.stagnant >= options.patience;
        }
    }

    /// Takes a newcomer in place of its worst individual.
    pub(super) fn welcome(&mut self, genes: &[f64], cost: f64) {
        let worst = self.population.worst();
        self.population.replace(worst, genes, cost);
    }

    /// Puts what a polish made of the best in its place, where that is better.
    pub(super) fn refine_best(&mut self, genes: &[f64], cost: f64) {
        let best = self.population.best();
        if cost < self.population.cost(best) {
            self.population.replace(best, genes, cost);
        }
    }

    /// Searches on with new patience.
    pub(super) fn resume(&mut self) {
        self.reference = self.best_cost();
        self.stagnant = 0;
        self.waiting = false;
    }

    pub(super) fn best_cost(&self) -> f64 {
        self.population.cost(self.population.best())
    }

    pub(super) fn best_row(&self) -> &[f64] {
        self.population.row(self.population.best())
    }

    pub(super) fn progress(&self) -> IslandProgress {
        IslandProgress { best_cost: self.best_cost(), state: self.state() }
    }

    fn state(&self) -> IslandState {
        if self.waiting { IslandState::Waiting } else { IslandState::Searching }
    }

    /// Passes the island as it stands between two generations.
    pub(super) fn pass(&mut self, tape: &mut Tape<'_>) {
        let RngState { seed, stream, word } = self.rng.state();
        tape.same(seed);
        tape.same(stream);
        let (mut low, mut high) = (word as u64, (word >> 64) as u64);
        tape.word(&mut low);
        tape.word(&mut high);
        let word = u128::from(low) | u128::from(high) << 64;
        self.rng = Rng::restore(RngState { seed, stream, word });
        self.population.pass(tape);
        tape.count(&mut self.stagnant);
        tape.float(&mut self.reference);
        tape.flag(&mut self.waiting);
        // The next generation overwrites all offspring.
        self.offspring.clone_from(&self.population);
        self.pending.clear();
    }

    pub(super) fn into_final(self) -> FinalIsland {
        FinalIsland { crossover: self.crossover, state: self.state(), population: self.population }
    }
}

/// Whether `cost` is an improvement on `reference`; on an infinite one every finite cost is.
fn improves(cost: f64, reference: f64, tolerance: f64) -> bool {
    cost < reference && (reference.is_infinite() || reference - cost > tolerance * reference.abs())
}

// ---- selection

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

// ---- mutation

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

// ---- migration

/// Exchanges the bests of neighbours; every island then searches on.
pub(super) fn exchange(islands: &mut [Island]) {
    let emigrants: Vec<(Vec<f64>, f64)> =
        islands.iter().map(|island| (island.best_row().to_vec(), island.best_cost())).collect();
    let n = islands.len();
    let mut ranking = Vec::new();
    for (i, island) in islands.iter_mut().enumerate() {
        let (left, right) = ((i + n - 1) % n, (i + 1) % n);
        let population = &mut island.population;
        population.rank(&mut ranking);
        let mut places = ranking.iter().rev();
        let mut receive = |from: usize| {
            if let Some(&place) = places.next() {
                let (genes, cost) = &emigrants[from];
                population.replace(place, genes, *cost);
            }
        };
        if left != i {
            receive(left);
        }
        if right != left {
            receive(right);
        }
        island.resume();
    }
}

// ---- termination

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
            return island.waiting.then_some(Status::Stagnated);
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
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::bounds::Bounds;
    use crate::optimize::options::IslandOptions;

    fn as_is(_: &mut [f64]) {}

    fn sum(x: &[f64]) -> f64 {
        x.iter().sum()
    }

    /// Evaluates what is pending by the sum of genes and accepts; returns how many there were.
    fn renew(island: &mut Island, options: &IslandOptions) -> usize {
        let pending = island.pending.iter();
        let costs: Vec<f64> = pending.map(|&i| sum(island.candidate(i))).collect();
        island.accept(&costs, options);
        costs.len()
    }

    fn habitat<'a>(bounds: &'a Bounds, options: &'a IslandOptions) -> Habitat<'a> {
        Habitat {
            bounds,
            options,
            selection: GeometricSelection::new(options.population, options.selection_pressure),
        }
    }

    /// An island with its second generation proposed.
    fn proposed(habitat: &Habitat<'_>) -> Island {
        let mut island = Island::new(0, habitat, 3);
        renew(&mut island, habitat.options);
        island.propose(habitat, &as_is);
        island
    }

    #[test]
    fn without_crossover_and_mutation_nothing_is_evaluated() {
        let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
        let options = IslandOptions {
            crossover_probability: 0.0,
            mutation_probability: 0.0,
            ..IslandOptions::default()
        };
        let island = proposed(&habitat(&bounds, &options));
        assert!(island.pending.is_empty());
    }

    #[test]
    fn the_better_parent_is_the_one_of_lower_cost() {
        let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
        let options = IslandOptions {
            crossovers: vec![Crossover::Heuristic { tries: 3 }],
            mutation_probability: 0.0,
            ..IslandOptions::default()
        };
        let island = proposed(&habitat(&bounds, &options));
        assert!(!island.pending.is_empty());
        for &i in &island.pending {
            // A step beyond the better parent, whose copy comes next; the cost is linear.
            assert!(sum(island.candidate(i)) < sum(island.candidate(i + 1)));
        }
    }

    #[test]
    fn improvement_is_relative_to_the_reference() {
        assert!(improves(0.999, 1.0, 0.0) && !improves(1.0, 1.0, 0.0));
        assert!(improves(0.98, 1.0, 0.01) && !improves(0.995, 1.0, 0.01));
        assert!(improves(-1.02, -1.0, 0.01) && !improves(-1.005, -1.0, 0.01));
        assert!(improves(5.0, f64::INFINITY, 0.0));
        assert!(!improves(f64::INFINITY, f64::INFINITY, 0.0));
    }

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

    /// Islands of four, island `i` with costs `10 i + 0..4` by index; genes as drawn.
    fn islands(n: usize) -> Vec<Island> {
        let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
        let options = IslandOptions { population: 4, ..IslandOptions::default() };
        let habitat =
            Habitat { bounds: &bounds, options: &options, selection: GeometricSelection::new(4, 0.08) };
        let settle = |i: usize| {
            let mut island = Island::new(i, &habitat, 1);
            let costs: Vec<f64> = (0..4).map(|k| (10 * i + k) as f64).collect();
            island.accept(&costs, &options);
            island
        };
        (0..n).map(settle).collect()
    }

    fn costs(island: &Island) -> &[f64] {
        &island.population.costs
    }

    #[test]
    fn neighbours_bests_replace_the_worst_two() {
        let mut islands = islands(5);
        let best_of_4 = islands[4].best_row().to_vec();
        exchange(&mut islands);
        assert_eq!(costs(&islands[0]), [0.0, 1.0, 10.0, 40.0]);
        assert_eq!(costs(&islands[2]), [20.0, 21.0, 30.0, 10.0]);
        assert_eq!(costs(&islands[4]), [40.0, 41.0, 0.0, 30.0]);
        assert_eq!(islands[0].population.row(3), best_of_4);
    }

    #[test]
    fn two_islands_exchange_one_each_and_one_none() {
        let mut pair = islands(2);
        exchange(&mut pair);
        assert_eq!(costs(&pair[0]), [0.0, 1.0, 2.0, 10.0]);
        assert_eq!(costs(&pair[1]), [10.0, 11.0, 12.0, 0.0]);
        let mut single = islands(1);
        exchange(&mut single);
        assert_eq!(costs(&single[0]), [0.0, 1.0, 2.0, 3.0]);
    }

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
        let habitat =
            Habitat { bounds, options, selection: GeometricSelection::new(options.population, 0.08) };
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

        let paper = IslandOptions { agreement: Agreement::Genes, ..options };
        let mut consensus = Consensus::default();
        assert!((0..9).all(|_| consensus.reached(&even, &bounds, &paper, true).is_none()));
    }
}
