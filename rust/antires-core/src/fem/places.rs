//! Where the entries of terms are in the matrices that they are parts of.

use super::term::Term;
use crate::linalg::sparse::Pattern;

/// Where the entries of each of some terms are in a matrix of one pattern.
#[derive(Debug, Clone, Default)]
pub struct Places {
    starts: Vec<usize>,
    places: Vec<u32>,
}

impl Places {
    /// Places of the entries of `terms`, all of which the pattern has.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn new(pattern: &Pattern, terms: &[Term]) -> Self {
        let (mut starts, mut places) = (vec![0], Vec::new());
        for term in terms {
            places.extend(term.entries().iter().map(|&(i, j, _)| {
                let at = pattern.find(i as usize, j as usize);
                at.expect("a place of the pattern") as u32
            }));
            starts.push(places.len());
        }
        places.shrink_to_fit();
        Self { starts, places }
    }

    /// Those of term `index`.
    #[must_use]
    pub fn of(&self, index: usize) -> &[u32] {
        &self.places[self.starts[index]..self.starts[index + 1]]
    }
}
