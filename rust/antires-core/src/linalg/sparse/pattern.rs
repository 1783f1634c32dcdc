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

    /// Those of the places that `kept` tells, mirror images alike, and the diagonal; for each its number here.
    #[must_use]
    pub fn kept(&self, kept: impl Fn(usize) -> bool) -> (Self, Vec<usize>) {
        let mirrors = self.mirrors();
        let (mut starts, mut rows, mut origin) = (vec![0], Vec::new(), Vec::new());
        for j in 0..self.n() {
            for at in self.starts[j]..self.starts[j + 1] {
                if kept(at) || kept(mirrors[at]) || self.rows[at] as usize == j {
                    rows.push(self.rows[at]);
                    origin.push(at);
                }
            }
            starts.push(rows.len());
        }
        (Self { starts, rows }, origin)
    }

    /// The pattern with row and column `order[new]` moved to `new`, and for each of its places the number
    /// that it has here.
    #[must_use]
    pub fn permuted(&self, order: &[usize]) -> (Self, Vec<usize>) {
        let n = self.n();
        let mut place = vec![0_u32; n];
        let mut starts = Vec::with_capacity(n + 1);
        starts.push(0);
        for (new, &old) in order.iter().enumerate() {
            place[old] = new as u32;
            starts.push(starts[new] + self.column(old).len());
        }
        let mirrors = self.mirrors();
        let (mut rows, mut origin) = (vec![0_u32; self.len()], vec![0; self.len()]);
        // Row after row of the new pattern, so that the columns come out sorted.
        let mut next = starts.clone();
        for (new, &old) in order.iter().enumerate() {
            for at in self.starts[old]..self.starts[old + 1] {
                let free = &mut next[place[self.rows[at] as usize] as usize];
                rows[*free] = new as u32;
                origin[*free] = mirrors[at];
                *free += 1;
            }
        }
        (Self { starts, rows }, origin)
    }

    /// For each place (i, j) the number of the place (j, i).
    fn mirrors(&self) -> Vec<usize> {
        let mut next = self.starts.clone();
        let mirror = |&i: &u32| {
            let at = next[i as usize];
            next[i as usize] += 1;
            at
        };
        self.rows.iter().map(mirror).collect()
    }
}

#[cfg(test)]
mod tests;
