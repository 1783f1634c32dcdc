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
