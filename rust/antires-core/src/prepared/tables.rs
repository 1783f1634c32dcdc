//! Tables and a test as they are handed over; the roots at any severities of a few elements, between the levels of the
//! tables; Cholesky factors of several matrices side by side, packed by rows.

use crate::linalg::wide::widest;

/// Roots (r) at levels (l) of u of each element (n), and of cracks behind them, (k) in all; arrays are row-major.
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
    /// (k, l, r) whether the model has it.
    pub there: &'a [bool],
    /// (k, l, r) ln f expected in the measured structure.
    pub place: &'a [f64],
    /// (k, l, r) how far that is from the model's.
    pub beside: &'a [f64],
    /// (k, l, r) slope of the place by u of the element.
    pub by_own: &'a [f64],
    /// (n, l, r, n) slopes of ln f by all u.
    pub slopes: &'a [f32],
    /// (n, n, l, r) the same by the first, of the second.
    pub crossed: &'a [f32],
    /// (n + c, l, r, q) what multiplies the errors of the model.
    pub errors: &'a [f32],
    /// (r, r) covariance of the roots without damage.
    pub spread: &'a [f64],
    /// (k − n) the element of each crack, in whose place it stands where slopes are asked for.
    pub host: &'a [i64],
    /// (k − n) the row of errors of each.
    pub errors_of: &'a [i64],
    /// Variance of a root that has just appeared.
    pub new_variance: f64,
}

impl<'a> Tables<'a> {
    /// Number of roots.
    pub fn size(&self) -> usize {
        self.response.len()
    }

    /// The element that a crack is in, or the element itself.
    pub fn host(&self, e: usize) -> usize {
        if e < self.n { e } else { self.host[e - self.n] as usize }
    }

    /// Where (e, level) begins in a table of roots.
    pub fn at(&self, e: usize, level: usize) -> usize {
        (e * self.levels.len() + level) * self.size()
    }

    /// One row of slopes, (n,).
    pub fn slope_row(&self, e: usize, level: usize, root: usize) -> &'a [f32] {
        &self.slopes[(self.at(self.host(e), level) + root) * self.n..][..self.n]
    }

    /// Slopes of all roots at (e, level) by one u, (r,).
    pub fn slopes_by(&self, by: usize, e: usize, level: usize) -> &'a [f32] {
        let cells = self.n * self.levels.len() * self.size();
        &self.crossed[self.host(by) * cells + self.at(self.host(e), level)..][..self.size()]
    }

    /// One row of errors, (q,).
    pub fn error_row(&self, e: usize, level: usize, root: usize) -> &'a [f32] {
        let row = if e < self.n { e } else { self.errors_of[e - self.n] as usize };
        &self.errors[(self.at(row, level) + root) * self.q..][..self.q]
    }

    /// Whether all arrays have their lengths, and levels rise from 0.
    pub fn consistent(&self) -> bool {
        let (r, levels) = (self.size(), self.levels.len());
        let (cells, rows) = (self.n * levels * r, self.errors.len() / (levels * r * self.q).max(1));
        let all = (self.n + self.host.len()) * levels * r;
        levels > 1
            && self.n > 0
            && self.levels[0] == 0.0
            && self.levels.is_sorted()
            && self.response.is_sorted()
            && [self.seen.len(), self.old.len(), self.intact.len()] == [r; 3]
            && self.host.iter().all(|e| (0..self.n as i64).contains(e))
            && self.errors_of.len() == self.host.len()
            && self.errors_of.iter().all(|row| (0..rows as i64).contains(row))
            && [self.there.len(), self.place.len(), self.beside.len(), self.by_own.len()] == [all; 4]
            && [self.slopes.len(), self.crossed.len()] == [cells * self.n; 2]
            && self.errors.len() >= cells * self.q
            && self.spread.len() == r * r
    }
}

// ---- values

/// Probabilities that a root is found which the other state showed, or did not; of a false value.
const FOUND: f64 = 0.97;
const FOUND_ONCE: f64 = 0.5;
const FALSE: f64 = 0.01;
/// Over so much of ln f from the edges of the band a root is ever more surely found; least width of the band.
const EDGE: f64 = 0.06;
const LEAST_BAND: f64 = 0.1;
/// An error of predictions (multiple of the change), a multiple of the standard deviations, the share of a
/// change that is wrong along the slopes of all elements; ln of the probability of these alone, with a change of
/// all values alike, and with one by heat.
pub type Error = [f64; 6];

/// What may come with any damage.
#[derive(Clone, Debug)]
pub struct Together {
    /// Standard deviation of a change of all values alike, ln f.
    pub alike: f64,
    /// Changes of ln stiffness that heat makes, (k, n), of standard deviation 1 each.
    pub heat: Vec<f64>,
    /// Beside so many damaged elements heat is not looked at.
    pub many: usize,
}

/// Values of a test, ascending within each response of each set.
#[derive(Clone, Debug)]
pub struct Test {
    /// Response of each.
    pub response: Vec<i64>,
    /// ln f.
    pub log_f: Vec<f64>,
    /// Relative standard deviations.
    pub std: Vec<f64>,
    /// Number of the set, ascending.
    pub set: Vec<i64>,
    /// By response: in how many sets it was measured.
    pub times: Vec<f64>,
    /// The band, ln f.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Standard deviation of what moves all values alike.
    pub common: f64,
    /// The same of what moves each by itself.
    pub extra: f64,
    /// At most [`SIDE`].
    pub errors: Vec<Error>,
    /// Changes of all.
    pub together: Together,
}

impl Test {
    /// In how many sets a response was measured.
    pub fn measured(&self, response: i64) -> f64 {
        let nth = usize::try_from(response).unwrap_or(usize::MAX);
        self.times.get(nth).copied().unwrap_or(0.0)
    }

    /// Whether all arrays have their lengths.
    pub fn consistent(&self) -> bool {
        let m = self.response.len();
        [self.log_f.len(), self.std.len(), self.set.len()] == [m; 3]
            && !self.errors.is_empty()
            && self.errors.len() <= SIDE
    }

    /// Price of a value without a root.
    pub fn alone(&self) -> f64 {
        -(FALSE / (self.high - self.low).max(LEAST_BAND)).ln()
    }

    /// Prices of a root that is missed, and of one that is found.
    pub fn prices(&self, place: f64, seen: bool) -> (f64, f64) {
        let found: f64 = if seen { FOUND } else { FOUND_ONCE };
        let inside = ((place - self.low).min(self.high - place) / EDGE).clamp(0.0, 1.0);
        (-inside * (1.0 - found).ln(), -inside * found.ln())
    }
}

// ---- places

/// Where between two levels a severity lies.
#[derive(Clone, Copy, Debug)]
struct Between {
    below: usize,
    near: usize,
    share: f64,
}

/// Roots at severities of some elements.
#[derive(Clone, Debug)]
pub struct Places {
    /// The damaged elements.
    pub elements: Vec<usize>,
    /// Their severities.
    pub u: Vec<f64>,
    between: Vec<Between>,
    /// Whether the model has each.
    pub there: Vec<bool>,
    /// ln f expected in the measured structure.
    pub place: Vec<f64>,
    /// How far that is from the model's.
    pub beside: Vec<f64>,
}

struct One {
    between: Between,
    there: Vec<bool>,
    place: Vec<f64>,
    beside: Vec<f64>,
}

fn one(t: &Tables<'_>, e: usize, u: f64) -> One {
    let j = t.levels.partition_point(|&l| l <= u).saturating_sub(1);
    let j = j.min(t.levels.len() - 2);
    let width = t.levels[j + 1] - t.levels[j];
    let s = (u - t.levels[j]) / width;
    let near = if s > 0.5 { j + 1 } else { j };
    let (low, high, closer) = (t.at(e, j), t.at(e, j + 1), t.at(e, near));
    let r = 1.0 - s;
    let size = t.size();
    let (mut place, mut beside) = (vec![0.0; size], vec![0.0; size]);
    for k in 0..size {
        if t.there[low + k] && t.there[high + k] {
            let bend = r * t.by_own[low + k] - s * t.by_own[high + k];
            let rise = t.place[high + k] - t.place[low + k];
            place[k] = t.place[low + k] + s * s * (3.0 - 2.0 * s) * rise + s * r * width * bend;
            beside[k] = r * t.beside[low + k] + s * t.beside[high + k];
        } else {
            place[k] = t.place[closer + k] + t.by_own[closer + k] * (u - t.levels[near]);
            beside[k] = t.beside[closer + k];
        }
    }
    One {
        between: Between { below: j, near, share: s },
        there: t.there[closer..closer + size].to_vec(),
        place,
        beside,
    }
}

/// Slope of a root at one severity by another u.
fn slope_between(t: &Tables<'_>, e: usize, at: Between, root: usize, by: usize) -> f64 {
    let low = t.slope_row(e, at.below, root)[t.host(by)];
    let high = t.slope_row(e, at.below + 1, root)[t.host(by)];
    f64::from(low) + at.share * f64::from(high - low)
}

/// Second derivative of ln f by two u, without damage.
pub fn mixed(t: &Tables<'_>, a: usize, b: usize, root: usize) -> f64 {
    let (a, b) = (t.host(a), t.host(b));
    let first = t.slope_row(a, 1, root)[b] - t.slope_row(a, 0, root)[b];
    let second = t.slope_row(b, 1, root)[a] - t.slope_row(b, 0, root)[a];
    0.5 * f64::from(first + second) / t.levels[1]
}

impl Places {
    /// The roots at severities `u` of `elements`, the others undamaged.
    pub fn new(t: &Tables<'_>, elements: &[usize], u: &[f64]) -> Self {
        let size = t.size();
        let mut found = Self {
            elements: elements.to_vec(),
            u: u.to_vec(),
            between: Vec::with_capacity(u.len()),
            there: t.there[..size].to_vec(),
            place: t.place[..size].to_vec(),
            beside: t.beside[..size].to_vec(),
        };
        let each: Vec<One> = elements.iter().zip(u).map(|(&e, &x)| one(t, e, x)).collect();
        found.between = each.iter().map(|one| one.between).collect();
        for k in 0..size {
            for one in &each {
                found.place[k] += one.place[k] - t.place[k];
                found.beside[k] += one.beside[k] - t.beside[k];
            }
            if !each.is_empty() {
                let all = each.iter().all(|one| one.there[k]);
                found.there[k] = all || (!t.old[k] && each.iter().any(|one| one.there[k]));
            }
            if !t.old[k] {
                continue;
            }
            for i in 0..each.len() {
                for j in i + 1..each.len() {
                    let (a, b) = (elements[i], elements[j]);
                    let start = |by: usize| f64::from(t.slope_row(0, 0, k)[t.host(by)]);
                    found.place[k] += (slope_between(t, a, each[i].between, k, b) - start(b)) * u[j]
                        + (slope_between(t, b, each[j].between, k, a) - start(a)) * u[i]
                        - mixed(t, a, b, k) * u[i] * u[j];
                }
            }
        }
        found
    }

    /// One root's row of slopes or errors, by `row` from their table, into `out`.
    pub fn row<'a>(
        &self,
        t: &Tables<'a>,
        root: usize,
        row: impl Fn(usize, usize, usize) -> &'a [f32],
        out: &mut [f64],
    ) {
        let start = row(0, 0, root);
        let shift = self.elements.len() as f64 - 1.0;
        for (x, s) in out.iter_mut().zip(start) {
            *x = -shift * f64::from(*s);
        }
        for (&e, way) in self.elements.iter().zip(&self.between) {
            let both = t.there[t.at(e, way.below) + root] && t.there[t.at(e, way.below + 1) + root];
            let share = if both { way.share } else { (way.near - way.below) as f64 };
            let (low, high) = (row(e, way.below, root), row(e, way.below + 1, root));
            for ((x, l), h) in out.iter_mut().zip(low).zip(high) {
                *x += f64::from(*l) * (1.0 - share) + f64::from(*h) * share;
            }
        }
    }

    /// Slope of a root by the severity of an element or crack.
    pub fn slope(&self, t: &Tables<'_>, root: usize, by: usize) -> f64 {
        let column = t.host(by);
        let own = |e: usize, level: usize| {
            let hosts = || f64::from(t.slope_row(e, level, root)[column]);
            if by >= t.n && e == by { t.by_own[t.at(e, level) + root] } else { hosts() }
        };
        let start = own(0, 0);
        let mut total = start;
        for (&e, way) in self.elements.iter().zip(&self.between) {
            let both = t.there[t.at(e, way.below) + root] && t.there[t.at(e, way.below + 1) + root];
            let share = if both { way.share } else { (way.near - way.below) as f64 };
            let (low, high) = (own(e, way.below), own(e, way.below + 1));
            total += low + share * (high - low) - start;
        }
        total
    }
}

// ---- factor

/// Matrices side by side.
pub const SIDE: usize = 16;

/// One entry of all of them.
pub type Entry = [f64; SIDE];

/// Least pivot: covariances of measured values are larger.
const LEAST: f64 = 1e-24;

/// Where row i begins.
pub const fn row(i: usize) -> usize {
    i * (i + 1) / 2
}

widest!(
    /// L of L Lᵀ = A for all matrices, in place.
    pub fn factorize(a: &mut [Entry], size: usize) {
        for i in 0..size {
            let (above, here) = a.split_at_mut(row(i));
            for j in 0..=i {
                let mut sum = here[j];
                if j < i {
                    let other = &above[row(j)..=row(j) + j];
                    for (x, y) in here[..j].iter().zip(&other[..j]) {
                        for l in 0..SIDE {
                            sum[l] -= x[l] * y[l];
                        }
                    }
                    for l in 0..SIDE {
                        sum[l] /= other[j][l];
                    }
                } else {
                    for x in &here[..j] {
                        for l in 0..SIDE {
                            sum[l] -= x[l] * x[l];
                        }
                    }
                    for l in 0..SIDE {
                        sum[l] = sum[l].max(LEAST).sqrt();
                    }
                }
                here[j] = sum;
            }
        }
    }
);

/// L⁻¹ b for all of them.
pub fn whitened(factors: &[Entry], b: &[f64]) -> Vec<Entry> {
    let mut white: Vec<Entry> = Vec::with_capacity(b.len());
    for (i, &value) in b.iter().enumerate() {
        let own = &factors[row(i)..=row(i) + i];
        let mut sum = [value; SIDE];
        for (x, w) in own.iter().zip(&white) {
            for l in 0..SIDE {
                sum[l] -= x[l] * w[l];
            }
        }
        for l in 0..SIDE {
            sum[l] /= own[i][l];
        }
        white.push(sum);
    }
    white
}

widest!(
    /// L⁻¹ B of one of the matrices, rows of `width` columns, in place.
    pub fn whiten_rows(factors: &[Entry], which: usize, rows: &mut [f64], width: usize) {
        let size = rows.len() / width.max(1);
        for i in 0..size {
            let (before, rest) = rows.split_at_mut(i * width);
            let own = &mut rest[..width];
            for (k, other) in before.chunks_exact(width).enumerate() {
                let c = factors[row(i) + k][which];
                for (x, y) in own.iter_mut().zip(other) {
                    *x -= c * y;
                }
            }
            let over = 1.0 / factors[row(i) + i][which];
            for x in own.iter_mut() {
                *x *= over;
            }
        }
    }
);

widest!(
    /// BᵀB of rows of `n` columns.
    pub fn gram(rows: &[f64], n: usize) -> Vec<f64> {
        let mut found = vec![0.0; n * n];
        for row in rows.chunks_exact(n.max(1)) {
            for (i, &c) in row.iter().enumerate() {
                for (x, y) in found[i * n..i * n + n].iter_mut().zip(row) {
                    *x += c * y;
                }
            }
        }
        found
    }
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_all_matrices_reproduce_them() {
        let size = 7;
        let entry = |i: usize, j: usize, l: usize| {
            let apart = (i as f64 - j as f64).abs();
            (-apart / (1.0 + l as f64)).exp() + if i == j { 0.1 } else { 0.0 }
        };
        let mut a: Vec<[f64; SIDE]> = Vec::new();
        for i in 0..size {
            for j in 0..=i {
                a.push(std::array::from_fn(|l| entry(i, j, l)));
            }
        }
        factorize(&mut a, size);
        let b: Vec<f64> = (0..size).map(|i| 1.0 + i as f64).collect();
        let white = whitened(&a, &b);
        for l in 0..SIDE {
            let mut rows = b.clone();
            whiten_rows(&a, l, &mut rows, 1);
            for i in 0..size {
                assert!((rows[i] - white[i][l]).abs() < 1e-12);
                let back: f64 = (0..=i).map(|k| a[row(i) + k][l] * white[k][l]).sum();
                assert!((back - b[i]).abs() < 1e-12);
                for j in 0..=i {
                    let sum: f64 = (0..=j).map(|k| a[row(i) + k][l] * a[row(j) + k][l]).sum();
                    assert!((sum - entry(i, j, l)).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn gram_is_the_product() {
        let found = gram(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2);
        assert_eq!(found, [35.0, 44.0, 44.0, 56.0]);
    }
}
