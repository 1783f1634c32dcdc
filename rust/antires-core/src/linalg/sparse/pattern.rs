//! Where a symmetric matrix has entries: both triangles by columns, rows ascending, every diagonal place.

/// The pattern of a symmetric matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    starts: Vec<usize>,
    rows: Vec<u32>,
}

impl Pattern {
    /// Pattern of `n` rows with the given places, their mirror images and the diagonal. A place outside is
    /// a bug of the caller.
    #[must_use]
    pub fn new(n: usize, places: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let all = || {
            let mirrored = places.clone().filter(|(i, j)| i != j);
            mirrored.flat_map(|(i, j)| [(i, j), (j, i)])
        };
        let mut starts = vec![0_usize; n + 1];
        for j in 0..n {
            starts[j + 1] = 1;
        }
        for (_, j) in all() {
            starts[j as usize + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut rows = vec![0_u32; starts[n]];
        for j in 0..n {
            rows[next[j]] = j as u32;
            next[j] += 1;
        }
        for (i, j) in all() {
            rows[next[j as usize]] = i;
            next[j as usize] += 1;
        }
        // Sorted, each place once.
        let (mut kept, mut first) = (0, 0);
        for j in 0..n {
            let end = starts[j + 1];
            rows[first..end].sort_unstable();
            starts[j] = kept;
            for at in first..end {
                if at == first || rows[at] != rows[at - 1] {
                    rows[kept] = rows[at];
                    kept += 1;
                }
            }
            first = end;
        }
        starts[n] = kept;
        rows.truncate(kept);
        rows.shrink_to_fit();
        Self { starts, rows }
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of places.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether the matrix has no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Where each column begins, and the end of the last.
    #[must_use]
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Rows of all columns, one after the other.
    #[must_use]
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Rows of column `j`, ascending.
    #[must_use]
    pub fn column(&self, j: usize) -> &[u32] {
        &self.rows[self.starts[j]..self.starts[j + 1]]
    }

    /// Number of the place (i, j), if it is one.
    #[must_use]
    pub fn find(&self, i: usize, j: usize) -> Option<usize> {
        let found = self.column(j).binary_search(&(i as u32));
        found.ok().map(|at| self.starts[j] + at)
    }

    /// The pattern with row and column `order[new]` moved to `new`, and for each of its places the number
    /// that it has here.
    #[must_use]
    pub fn permuted(&self, order: &[usize]) -> (Self, Vec<usize>) {
        let n = self.n();
        let mut place = vec![0_u32; n];
        for (new, &old) in order.iter().enumerate() {
            place[old] = new as u32;
        }
        let mut starts = Vec::with_capacity(n + 1);
        starts.push(0);
        let (mut rows, mut origin) = (
            Vec::with_capacity(self.len()),
            Vec::with_capacity(self.len()),
        );
        let mut column = Vec::new();
        for &old in order {
            column.clear();
            let range = self.starts[old]..self.starts[old + 1];
            column.extend(range.map(|at| (place[self.rows[at] as usize], at)));
            column.sort_unstable();
            rows.extend(column.iter().map(|c| c.0));
            origin.extend(column.iter().map(|c| c.1));
            starts.push(rows.len());
        }
        (Self { starts, rows }, origin)
    }
}

#[cfg(test)]
mod tests;
