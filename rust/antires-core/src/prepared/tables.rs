//! The tables, as they are handed over.

/// Roots (r) at levels (l) of u of each element (n); arrays are row-major.
#[derive(Clone, Copy, Debug)]
pub struct Tables<'a> {
    /// u of each level, ascending from 0.
    pub levels: &'a [f64],
    /// Number of elements.
    pub n: usize,
    /// Number of errors of the model.
    pub q: usize,
    /// Response of each root, ascending.
    pub response: &'a [i64],
    /// Whether the baseline shows it.
    pub seen: &'a [bool],
    /// Whether the undamaged model has it.
    pub old: &'a [bool],
    /// ln f in the undamaged model.
    pub intact: &'a [f64],
    /// (n, l, r) whether the model has it.
    pub there: &'a [bool],
    /// (n, l, r) ln f expected in the measured structure.
    pub place: &'a [f64],
    /// (n, l, r) how far that is from the model's.
    pub beside: &'a [f64],
    /// (n, l, r) slope of the place by u of the element.
    pub by_own: &'a [f64],
    /// (n, l, r, n) slopes of ln f by all u.
    pub slopes: &'a [f32],
    /// (n, n, l, r) the same by the first, of the second.
    pub crossed: &'a [f32],
    /// (n, l, r, q) what multiplies the errors of the model.
    pub errors: &'a [f32],
    /// (r, r) covariance of the roots without damage.
    pub spread: &'a [f64],
    /// Variance of a root that has just appeared.
    pub new_variance: f64,
}

impl<'a> Tables<'a> {
    /// Number of roots.
    #[must_use]
    pub fn size(&self) -> usize {
        self.response.len()
    }

    /// Where (e, level) begins in a table of roots.
    #[must_use]
    pub fn at(&self, e: usize, level: usize) -> usize {
        (e * self.levels.len() + level) * self.size()
    }

    /// One row of slopes, (n,).
    #[must_use]
    pub fn slope_row(&self, e: usize, level: usize, root: usize) -> &'a [f32] {
        &self.slopes[(self.at(e, level) + root) * self.n..][..self.n]
    }

    /// Slopes of all roots at (e, level) by one u, (r,).
    #[must_use]
    pub fn slopes_by(&self, by: usize, e: usize, level: usize) -> &'a [f32] {
        let cells = self.n * self.levels.len() * self.size();
        &self.crossed[by * cells + self.at(e, level)..][..self.size()]
    }

    /// One row of errors, (q,).
    #[must_use]
    pub fn error_row(&self, e: usize, level: usize, root: usize) -> &'a [f32] {
        &self.errors[(self.at(e, level) + root) * self.q..][..self.q]
    }

    /// Whether all arrays have their lengths, and levels rise from 0.
    #[must_use]
    pub fn consistent(&self) -> bool {
        let (r, levels) = (self.size(), self.levels.len());
        let cells = self.n * levels * r;
        levels > 1
            && self.n > 0
            && self.levels[0] == 0.0
            && self.levels.is_sorted()
            && self.response.is_sorted()
            && [self.seen.len(), self.old.len(), self.intact.len()] == [r; 3]
            && self.there.len() == cells
            && [self.place.len(), self.beside.len(), self.by_own.len()] == [cells; 3]
            && [self.slopes.len(), self.crossed.len()] == [cells * self.n; 2]
            && self.errors.len() == cells * self.q
            && self.spread.len() == r * r
    }
}
