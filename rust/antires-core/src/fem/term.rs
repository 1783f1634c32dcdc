//! A term: the sparse, symmetric contribution of one element (or group) to K or M, and its places there.

use nalgebra::SMatrix;

use crate::linalg::sparse::Pattern;

/// The matrix that a term is a part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// K.
    Stiffness,
    /// M.
    Mass,
}

/// Entries (row, column, value) of a symmetric matrix, both triangles stored.
#[derive(Debug, Clone, Default)]
pub struct Term {
    entries: Vec<(u32, u32, f64)>,
}

impl Term {
    /// Term of an element whose local dofs are the global `dofs`.
    #[must_use]
    pub fn from_element<const N: usize>(dofs: &[usize; N], matrix: &SMatrix<f64, N, N>) -> Self {
        let mut entries = Vec::with_capacity(N * N);
        for (i, &row) in dofs.iter().enumerate() {
            for (j, &col) in dofs.iter().enumerate() {
                entries.push((row as u32, col as u32, matrix[(i, j)]));
            }
        }
        Self { entries }
    }

    /// Makes this the term of an element whose local dofs are the global `dofs`, none where fixed. The
    /// memory is reused; the same dofs give the same entries in the same order.
    pub fn set_element<const N: usize>(&mut self, dofs: &[Option<usize>; N], matrix: &SMatrix<f64, N, N>) {
        self.entries.clear();
        for (i, row) in dofs.iter().enumerate() {
            let Some(row) = row else { continue };
            for (j, col) in dofs.iter().enumerate() {
                if let Some(col) = col {
                    self.entries.push((*row as u32, *col as u32, matrix[(i, j)]));
                }
            }
        }
    }

    /// Makes this a diagonal term at the global `dofs`, none where fixed.
    pub fn set_diagonal<const N: usize>(&mut self, dofs: &[Option<usize>; N], values: &[f64; N]) {
        self.entries.clear();
        for (dof, &value) in dofs.iter().zip(values) {
            if let Some(dof) = dof {
                self.entries.push((*dof as u32, *dof as u32, value));
            }
        }
    }

    /// Makes this term equal to `other`, reusing the memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.entries.clone_from(&other.entries);
    }

    /// Term from explicit entries, both triangles given.
    pub fn from_entries(entries: Vec<(u32, u32, f64)>) -> Self {
        Self { entries }
    }

    /// The entries (row, column, value).
    pub fn entries(&self) -> &[(u32, u32, f64)] {
        &self.entries
    }

    /// True when the term contributes nothing.
    pub fn is_zero(&self) -> bool {
        self.entries.iter().all(|e| e.2 == 0.0)
    }

    /// values += factor · term, at its `places`.
    pub fn add_to(&self, values: &mut [f64], places: &[u32], factor: f64) {
        for (entry, &at) in self.entries.iter().zip(places) {
            values[at as usize] += factor * entry.2;
        }
    }
}

// ---- places

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
    pub fn of(&self, index: usize) -> &[u32] {
        &self.places[self.starts[index]..self.starts[index + 1]]
    }
}
