//! An island: a population, the operators that renew it, and the patience to wait.
//!
//! A generation proposes `P` offspring: parents in pairs by [selection](super::selection), crossed
//! with probability `p_c` by the island's [operator](super::crossover), then
//! [mutated](super::mutation), repaired and clipped. Offspring equal to a parent keep that parent's
//! cost; the others are evaluated. The offspring replace the population, except that the best
//! individual so far, if better than all of them, takes the place of the worst (elitism).
//!
//! An island whose best has not improved for `patience` generations waits.

use super::bounds::Bounds;
use super::crossover::Crossover;
use super::mutation::mutate;
use super::options::IslandOptions;
use super::outcome::{FinalIsland, IslandProgress, IslandState};
use super::population::Population;
use super::selection::GeometricSelection;
use super::tape::Tape;
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
    pending: Vec<usize>,
    ranking: Vec<usize>,
    /// Generations since the best last improved on `reference`.
    stagnant: usize,
    reference: f64,
    waiting: bool,
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
        for i in 0..self.offspring.len() {
            let x = self.offspring.row_mut(i);
            repair(x);
            bounds.clip(x);
            self.population
                .row_mut(i)
                .copy_from_slice(self.offspring.row(i));
        }
    }

    /// Proposes a generation; what needs an evaluation is then [pending](Self::pending).
    pub(super) fn propose(&mut self, habitat: &Habitat<'_>, repair: &dyn Fn(&mut [f64])) {
        self.population.rank(&mut self.ranking);
        self.pending.clear();
        let size = self.population.len();
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
    fn finish(
        &mut self,
        i: usize,
        parents: [usize; 2],
        habitat: &Habitat<'_>,
        repair: &dyn Fn(&mut [f64]),
    ) {
        let child = self.offspring.row_mut(i);
        let p = habitat.options.mutation_probability;
        mutate(child, p, habitat.bounds, &mut self.rng);
        repair(child);
        habitat.bounds.clip(child);
        let same = parents
            .into_iter()
            .find(|&p| self.population.row(p) == child);
        if let Some(parent) = same {
            self.offspring.set_cost(i, self.population.cost(parent));
        } else {
            self.pending.push(i);
        }
    }

    /// The offspring that need an evaluation, ascending.
    pub(super) fn pending(&self) -> &[usize] {
        &self.pending
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
            self.offspring
                .replace(worst, self.population.row(best), best_cost);
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

    pub(super) fn waiting(&self) -> bool {
        self.waiting
    }

    pub(super) fn best_cost(&self) -> f64 {
        self.population.cost(self.population.best())
    }

    pub(super) fn best_row(&self) -> &[f64] {
        self.population.row(self.population.best())
    }

    pub(super) fn progress(&self) -> IslandProgress {
        IslandProgress {
            best_cost: self.best_cost(),
            state: self.state(),
        }
    }

    fn state(&self) -> IslandState {
        if self.waiting {
            IslandState::Waiting
        } else {
            IslandState::Searching
        }
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
        FinalIsland {
            crossover: self.crossover,
            state: self.state(),
            rng: self.rng.state(),
            population: self.population,
        }
    }
}

/// Whether `cost` is an improvement on `reference`; on an infinite one every finite cost is.
fn improves(cost: f64, reference: f64, tolerance: f64) -> bool {
    cost < reference && (reference.is_infinite() || reference - cost > tolerance * reference.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn as_is(_: &mut [f64]) {}

    fn sum(x: &[f64]) -> f64 {
        x.iter().sum()
    }

    /// Evaluates what is pending by the sum of genes and accepts; returns how many there were.
    fn renew(island: &mut Island, options: &IslandOptions) -> usize {
        let pending = island.pending().iter();
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
    fn every_cost_belongs_to_its_genes_and_the_best_is_never_lost() {
        let bounds = Bounds::uniform(6, 0.0, 1.0).unwrap();
        // An odd population: the last has no partner.
        let options = IslandOptions {
            population: 13,
            ..IslandOptions::default()
        };
        let habitat = habitat(&bounds, &options);
        for number in 0..4 {
            let mut island = Island::new(number, &habitat, 3);
            assert_eq!(renew(&mut island, &options), 13);
            let mut best = island.best_cost();
            let mut evaluated = 0;
            for _ in 0..60 {
                island.propose(&habitat, &as_is);
                evaluated += renew(&mut island, &options);
                let population = &island.population;
                for i in 0..population.len() {
                    assert_eq!(population.cost(i), sum(population.row(i)));
                    assert!(bounds.contain(population.row(i)));
                }
                assert!(island.best_cost() <= best);
                best = island.best_cost();
            }
            // Copies keep their cost: fewer evaluations than offspring.
            assert!((1..60 * 13).contains(&evaluated), "{evaluated} evaluations");
        }
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
        assert!(island.pending().is_empty());
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
        assert!(!island.pending().is_empty());
        for &i in island.pending() {
            // A step beyond the better parent, whose copy comes next; the cost is linear.
            assert!(sum(island.candidate(i)) < sum(island.candidate(i + 1)));
        }
    }

    #[test]
    fn a_truncated_generation_keeps_the_individuals_in_place() {
        let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
        let options = IslandOptions::default();
        let habitat = habitat(&bounds, &options);
        let mut island = Island::new(2, &habitat, 3);
        renew(&mut island, &options);
        let before = island.population.clone();
        island.propose(&habitat, &as_is);
        let pending = island.pending().to_vec();
        let cost = sum(island.candidate(pending[0]));
        island.accept(&[cost], &options);
        let after = &island.population;
        for &i in &pending[1..] {
            let elite = after.row(i) == before.row(before.best());
            assert!(elite || after.row(i) == before.row(i), "individual {i}");
        }
        assert!((0..after.len()).all(|i| after.cost(i) == sum(after.row(i))));
    }

    #[test]
    fn an_island_waits_when_its_patience_ends() {
        let bounds = Bounds::uniform(3, 0.0, 1.0).unwrap();
        let options = IslandOptions {
            patience: 5,
            ..IslandOptions::default()
        };
        let habitat = habitat(&bounds, &options);
        let mut island = Island::new(0, &habitat, 3);
        // A constant cost: the initial generation is the only improvement.
        island.accept(&vec![1.0; options.population], &options);
        for generation in 1..=5 {
            assert!(!island.waiting(), "before generation {generation}");
            island.propose(&habitat, &as_is);
            let costs = vec![1.0; island.pending().len()];
            island.accept(&costs, &options);
        }
        assert!(island.waiting());
        island.resume();
        assert!(!island.waiting());
    }

    #[test]
    fn improvement_is_relative_to_the_reference() {
        assert!(improves(0.999, 1.0, 0.0) && !improves(1.0, 1.0, 0.0));
        assert!(improves(0.98, 1.0, 0.01) && !improves(0.995, 1.0, 0.01));
        assert!(improves(-1.02, -1.0, 0.01) && !improves(-1.005, -1.0, 0.01));
        assert!(improves(5.0, f64::INFINITY, 0.0));
        assert!(!improves(f64::INFINITY, f64::INFINITY, 0.0));
    }
}
