//! A search between two generations as bytes, and back: what a checkpoint holds.
//!
//! Each part of the search passes its numbers over a tape, which either writes or reads them, so the two
//! directions cannot differ. Floats pass as their bits. A search that goes on from a snapshot gives the bits of
//! one that was never stopped: the snapshot holds the populations, where every random stream stands, the
//! account of evaluations, the record, and what the polish remembers.
//!
//! The bounds, the seed and the sizes are passed first and must be those of the search that takes the snapshot
//! up; that the objective is the same one is for the caller to know.

use super::archipelago::Archipelago;
use super::bounds::Bounds;
use super::island::Island;
use super::objective::Evaluator;
use super::polish::moves::Scan;
use super::polish::{Point, Polish};
use super::population::Population;
use crate::error::{Error, Result};
use crate::rng::{Rng, RngState};

/// The first bytes: a name and the version of the layout.
const HEADER: u64 = u64::from_le_bytes(*b"antires2");

/// Numbers in a row, written or read.
pub(super) enum Tape<'a> {
    Writing(Vec<u8>),
    /// What is left to read, or none after something that does not fit.
    Reading(Option<&'a [u8]>),
}

impl Tape<'_> {
    fn word(&mut self, value: &mut u64) {
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

    fn count(&mut self, value: &mut usize) {
        let mut word = *value as u64;
        self.word(&mut word);
        *value = word as usize;
    }

    fn float(&mut self, value: &mut f64) {
        let mut word = value.to_bits();
        self.word(&mut word);
        *value = f64::from_bits(word);
    }

    fn flag(&mut self, value: &mut bool) {
        let mut word = u64::from(*value);
        self.word(&mut word);
        *value = word != 0;
    }

    fn floats(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| self.float(value));
    }

    /// A list whose length may differ; `blank` makes a new item.
    fn list<T>(
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
    fn same(&mut self, known: u64) {
        let mut word = known;
        self.word(&mut word);
        if word != known {
            *self = Self::Reading(None);
        }
    }
}

impl<E: Evaluator> Archipelago<'_, E> {
    /// The search as it stands between two generations.
    pub(super) fn save(&mut self) -> Vec<u8> {
        let mut tape = Tape::Writing(Vec::new());
        self.pass(&mut tape);
        match tape {
            Tape::Writing(bytes) => bytes,
            Tape::Reading(_) => unreachable!("writing never fails"),
        }
    }

    /// Takes up a search where it was saved.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for bytes that are no snapshot of a search with these bounds, options and seed.
    pub(super) fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let mut tape = Tape::Reading(Some(bytes));
        self.pass(&mut tape);
        if !matches!(tape, Tape::Reading(Some([]))) {
            return Err(Error::input(
                "checkpoint",
                format!("{} bytes that do not fit this search", bytes.len()),
                "the snapshot of a search with the same parameters, bounds, options and seed",
            )
            .remedy("Begin anew under another name, or give the same problem and options."));
        }
        self.observe();
        Ok(())
    }

    fn pass(&mut self, tape: &mut Tape<'_>) {
        tape.same(HEADER);
        pass_bounds(self.ledger.bounds, tape);
        tape.same(self.islands.len() as u64);
        self.islands.iter_mut().for_each(|island| island.pass(tape));
        tape.count(&mut self.ledger.evaluations);
        tape.count(&mut self.ledger.linearizations);
        tape.floats(&mut self.ledger.best_x);
        tape.float(&mut self.ledger.best_cost);
        tape.count(&mut self.consensus.in_cost);
        tape.count(&mut self.generation);
        tape.count(&mut self.polished);
        tape.count(&mut self.evaluations_before);
        let history = &mut self.history;
        tape.list(&mut history.evaluations, || 0, Tape::count);
        tape.list(&mut history.best_costs, || 0.0, Tape::float);
        tape.list(&mut history.migrations, || 0, Tape::count);
        tape.same(u64::from(self.polish.is_some()));
        if let Some(polish) = &mut self.polish {
            polish.pass(self.ledger.bounds.n_genes(), tape);
        }
    }
}

fn pass_bounds(bounds: &Bounds, tape: &mut Tape<'_>) {
    tape.same(bounds.n_genes() as u64);
    for end in bounds.lower().iter().chain(bounds.upper()) {
        tape.same(end.to_bits());
    }
}

impl Island {
    fn pass(&mut self, tape: &mut Tape<'_>) {
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
}

impl Population {
    fn pass(&mut self, tape: &mut Tape<'_>) {
        tape.same(self.len() as u64);
        tape.floats(&mut self.genes);
        tape.floats(&mut self.costs);
    }
}

impl Polish {
    fn pass(&mut self, n_genes: usize, tape: &mut Tape<'_>) {
        let blank = || Scan {
            base: vec![0.0; n_genes],
            best: None,
        };
        tape.list(&mut self.scanned, blank, |tape, scan| {
            tape.floats(&mut scan.base);
            let mut some = scan.best.is_some();
            tape.flag(&mut some);
            if some {
                let best = scan.best.get_or_insert_with(|| Point {
                    x: vec![0.0; n_genes],
                    cost: 0.0,
                });
                tape.floats(&mut best.x);
                tape.float(&mut best.cost);
            }
        });
    }
}
