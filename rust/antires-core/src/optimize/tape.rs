//! Numbers in a row as bytes, written or read by the same code.
//!
//! Each part of a search passes its numbers over a tape, so the two directions cannot differ. Floats pass as
//! their bits.

use super::bounds::Bounds;

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
