//! Individuals and their costs: a `P x n` matrix of genes, row by row, and `P` costs.
//!
//! Of equal costs the lower index ranks first, so every order here is total.
//!
//! # tape
//!
//! Numbers in a row as bytes, written or read by the same code.
//!
//! Each part of a search passes its numbers over a tape, so the two directions cannot differ. Floats pass as
//! their bits.

use std::cmp::Ordering;

use super::bounds::Bounds;

/// The individuals of one island.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    n_genes: usize,
    /// All genes, individual after individual.
    pub genes: Vec<f64>,
    /// All costs; `+inf` where never evaluated, or not finite.
    pub costs: Vec<f64>,
}

impl Population {
    /// `size` individuals of `n_genes` zeros, not evaluated yet: their cost is `+inf`.
    pub(super) fn new(size: usize, n_genes: usize) -> Self {
        Self { n_genes, genes: vec![0.0; size * n_genes], costs: vec![f64::INFINITY; size] }
    }

    /// Passes genes and costs.
    pub(super) fn pass(&mut self, tape: &mut Tape<'_>) {
        tape.same(self.size() as u64);
        tape.floats(&mut self.genes);
        tape.floats(&mut self.costs);
    }

    /// The number of individuals, `P`.
    pub fn size(&self) -> usize {
        self.costs.len()
    }

    /// The genes of individual `i`.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.genes[i * self.n_genes..][..self.n_genes]
    }

    /// The cost of individual `i`.
    #[inline]
    pub fn cost(&self, i: usize) -> f64 {
        self.costs[i]
    }

    /// The individual of the lowest cost; of several the first.
    pub fn best(&self) -> usize {
        let mut best = 0;
        for i in 1..self.size() {
            if self.costs[i] < self.costs[best] {
                best = i;
            }
        }
        best
    }

    /// The individual of the highest cost; of several the last.
    pub(super) fn worst(&self) -> usize {
        let mut worst = 0;
        for i in 1..self.size() {
            if self.costs[i] >= self.costs[worst] {
                worst = i;
            }
        }
        worst
    }

    /// Writes the individuals' indices to `ranking`, best first.
    pub(super) fn rank(&self, ranking: &mut Vec<usize>) {
        ranking.clear();
        ranking.extend(0..self.size());
        ranking.sort_unstable_by(|&i, &j| self.compare(i, j));
    }

    /// Whether individual `i` ranks before, like or after individual `j`.
    pub(super) fn compare(&self, i: usize, j: usize) -> Ordering {
        self.costs[i].total_cmp(&self.costs[j]).then(i.cmp(&j))
    }

    /// The genes of individual `i`, to be written.
    pub(super) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.genes[i * self.n_genes..][..self.n_genes]
    }

    /// The genes of individuals `i` and `i + 1`, to be written.
    pub(super) fn pair_mut(&mut self, i: usize) -> (&mut [f64], &mut [f64]) {
        self.genes[i * self.n_genes..][..2 * self.n_genes].split_at_mut(self.n_genes)
    }

    /// Sets the cost of individual `i`, which must not be `NaN`.
    pub(super) fn set_cost(&mut self, i: usize, cost: f64) {
        debug_assert!(!cost.is_nan());
        self.costs[i] = cost;
    }

    /// Replaces individual `i`.
    pub(super) fn replace(&mut self, i: usize, genes: &[f64], cost: f64) {
        self.row_mut(i).copy_from_slice(genes);
        self.set_cost(i, cost);
    }
}

// ---- tape

/// Numbers in a row, written or read.
pub(super) enum Tape<'a> {
    Writing(Vec<u8>),
    /// What is left to read, or none after something that does not fit.
    Reading(Option<&'a [u8]>),
}

impl Tape<'_> {
    pub(super) fn word(&mut self, value: &mut u64) {
        match self {
            Self::Writing(bytes) => bytes.extend_from_slice(&value.to_le_bytes()),
            Self::Reading(left) => {
                *left = left.and_then(|bytes| {
                    let (word, rest) = bytes.split_first_chunk()?;
                    *value = u64::from_le_bytes(*word);
                    Some(rest)
                });
            }
        }
    }

    pub(super) fn count(&mut self, value: &mut usize) {
        let mut word = *value as u64;
        self.word(&mut word);
        *value = word as usize;
    }

    pub(super) fn float(&mut self, value: &mut f64) {
        let mut word = value.to_bits();
        self.word(&mut word);
        *value = f64::from_bits(word);
    }

    pub(super) fn flag(&mut self, value: &mut bool) {
        let mut word = u64::from(*value);
        self.word(&mut word);
        *value = word != 0;
    }

    pub(super) fn floats(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| self.float(value));
    }

    /// A list whose length may differ; `blank` makes a new item.
    pub(super) fn list<T>(
        &mut self,
        items: &mut Vec<T>,
        blank: impl Fn() -> T,
        mut pass: impl FnMut(&mut Self, &mut T),
    ) {
        let mut length = items.len();
        self.count(&mut length);
        if let Self::Reading(left) = self {
            // An item takes a word at least: a length that cannot be is not believed.
            *left = left.filter(|bytes| length <= bytes.len() / 8);
            let length = if left.is_some() { length } else { 0 };
            items.clear();
            items.resize_with(length, blank);
        }
        items.iter_mut().for_each(|item| pass(self, item));
    }

    /// A number that is known beforehand.
    pub(super) fn same(&mut self, known: u64) {
        let mut word = known;
        self.word(&mut word);
        if word != known {
            *self = Self::Reading(None);
        }
    }
}

/// The box of a search, which is known beforehand.
pub(super) fn pass_bounds(bounds: &Bounds, tape: &mut Tape<'_>) {
    tape.same(bounds.n_genes() as u64);
    for end in bounds.lower().iter().chain(bounds.upper()) {
        tape.same(end.to_bits());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn population(costs: &[f64]) -> Population {
        let mut population = Population::new(costs.len(), 2);
        for (i, &cost) in costs.iter().enumerate() {
            population.replace(i, &[i as f64, 10.0 * i as f64], cost);
        }
        population
    }

    #[test]
    fn ranking_is_by_cost_then_index() {
        let inf = f64::INFINITY;
        let population = population(&[3.0, 1.0, inf, 1.0, inf]);
        let mut ranking = vec![9];
        population.rank(&mut ranking);
        assert_eq!(ranking, [1, 3, 0, 2, 4]);
        assert_eq!((population.best(), population.worst()), (1, 4));
    }
}
