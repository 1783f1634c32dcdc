//! Migration: each island's best goes to both of its neighbours on a ring.
//!
//! Island `i` receives copies of the bests of islands `i - 1` and `i + 1` (modulo the number of
//! islands), as they were before any exchange, in this order; they take the places of its worst and
//! its second worst. Two islands exchange one individual each, a single island none. The best of an
//! island always stays at home too.

use super::island::Island;

/// Exchanges the bests of neighbours; every island then searches on.
pub(super) fn exchange(islands: &mut [Island]) {
    let emigrants: Vec<(Vec<f64>, f64)> = islands
        .iter()
        .map(|island| (island.best_row().to_vec(), island.best_cost()))
        .collect();
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

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::super::island::Habitat;
    use super::super::options::IslandOptions;
    use super::super::selection::GeometricSelection;
    use super::*;

    /// Islands of four, island `i` with costs `10 i + 0..4` by index; genes as drawn.
    fn islands(n: usize) -> Vec<Island> {
        let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
        let options = IslandOptions {
            population: 4,
            ..IslandOptions::default()
        };
        let habitat = Habitat {
            bounds: &bounds,
            options: &options,
            selection: GeometricSelection::new(4, 0.08),
        };
        let settle = |i: usize| {
            let mut island = Island::new(i, &habitat, 1);
            let costs: Vec<f64> = (0..4).map(|k| (10 * i + k) as f64).collect();
            island.accept(&costs, &options);
            island
        };
        (0..n).map(settle).collect()
    }

    fn costs(island: &Island) -> &[f64] {
        island.population.costs()
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
}
