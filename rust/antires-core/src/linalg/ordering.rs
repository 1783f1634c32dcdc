//! Reverse Cuthill-McKee: an ordering of the dofs that brings the entries of K and M near the diagonal.
//!
//! Breadth first from a dof at the end of a longest path, neighbours of low degree first, the whole
//! reversed (George & Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, ch. 4).
//! A frame without many loops comes out with a half-bandwidth of a few nodes.

/// Ordering of the vertices of a graph: `order[new] = old`. Components follow one another.
#[must_use]
pub fn reverse_cuthill_mckee(neighbours: &[Vec<usize>]) -> Vec<usize> {
    let n = neighbours.len();
    let mut placed = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for seed in 0..n {
        if placed[seed] {
            continue;
        }
        let start = far_end(neighbours, seed);
        let first = order.len();
        placed[start] = true;
        order.push(start);
        let mut next = first;
        while next < order.len() {
            let mut fresh: Vec<usize> = neighbours[order[next]]
                .iter()
                .copied()
                .filter(|&v| !placed[v])
                .collect();
            fresh.sort_unstable_by_key(|&v| (neighbours[v].len(), v));
            fresh.dedup();
            for v in fresh {
                placed[v] = true;
                order.push(v);
            }
            next += 1;
        }
    }
    order.reverse();
    order
}

/// A vertex from which the breadth-first levels are many (pseudo-peripheral).
fn far_end(neighbours: &[Vec<usize>], seed: usize) -> usize {
    let (mut start, mut depth) = (seed, 0);
    loop {
        let levels = levels(neighbours, start);
        let last = levels.iter().filter_map(|l| *l).max().unwrap_or(0);
        let end = (0..neighbours.len())
            .filter(|&v| levels[v] == Some(last))
            .min_by_key(|&v| (neighbours[v].len(), v));
        match end {
            Some(end) if last > depth => (start, depth) = (end, last),
            _ => return start,
        }
    }
}

fn levels(neighbours: &[Vec<usize>], start: usize) -> Vec<Option<usize>> {
    let mut level = vec![None; neighbours.len()];
    level[start] = Some(0);
    let mut queue = std::collections::VecDeque::from([(start, 0)]);
    while let Some((v, depth)) = queue.pop_front() {
        for &w in &neighbours[v] {
            if level[w].is_none() {
                level[w] = Some(depth + 1);
                queue.push_back((w, depth + 1));
            }
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shuffled_path_becomes_a_band_of_one() {
        // Vertices 0..12 of a path, visited in steps of 5 modulo 13.
        let at = |j: usize| (5 * j) % 13;
        let mut neighbours = vec![Vec::new(); 13];
        for j in 0..12 {
            neighbours[at(j)].push(at(j + 1));
            neighbours[at(j + 1)].push(at(j));
        }
        let order = reverse_cuthill_mckee(&neighbours);
        for pair in order.windows(2) {
            assert!(neighbours[pair[0]].contains(&pair[1]));
        }
    }

    #[test]
    fn every_vertex_of_every_component_appears_once() {
        let neighbours = vec![vec![3], vec![], vec![4], vec![0], vec![2]];
        let mut order = reverse_cuthill_mckee(&neighbours);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4]);
    }
}
