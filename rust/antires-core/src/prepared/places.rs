//! The roots at any severities of a few elements, between the levels.

use super::tables::Tables;

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
    /// Slopes by all u (r, n), where they were computed.
    pub slopes: Option<Vec<f64>>,
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
        between: Between {
            below: j,
            near,
            share: s,
        },
        there: t.there[closer..closer + size].to_vec(),
        place,
        beside,
    }
}

/// Slope of a root at one severity by another u.
fn slope_between(t: &Tables<'_>, e: usize, at: Between, root: usize, by: usize) -> f64 {
    let low = t.slope_row(e, at.below, root)[by];
    let high = t.slope_row(e, at.below + 1, root)[by];
    f64::from(low) + at.share * f64::from(high - low)
}

/// Second derivative of ln f by two u, without damage.
#[must_use]
pub fn mixed(t: &Tables<'_>, a: usize, b: usize, root: usize) -> f64 {
    let first = t.slope_row(a, 1, root)[b] - t.slope_row(a, 0, root)[b];
    let second = t.slope_row(b, 1, root)[a] - t.slope_row(b, 0, root)[a];
    0.5 * f64::from(first + second) / t.levels[1]
}

impl Places {
    /// The roots at severities `u` of `elements`, the others undamaged.
    #[must_use]
    pub fn new(t: &Tables<'_>, elements: &[usize], u: &[f64]) -> Self {
        let size = t.size();
        let mut found = Self {
            elements: elements.to_vec(),
            u: u.to_vec(),
            between: Vec::with_capacity(u.len()),
            there: t.there[..size].to_vec(),
            place: t.place[..size].to_vec(),
            beside: t.beside[..size].to_vec(),
            slopes: None,
        };
        let each: Vec<One> = elements
            .iter()
            .zip(u)
            .map(|(&e, &x)| one(t, e, x))
            .collect();
        found.between = each.iter().map(|one| one.between).collect();
        if let [only] = each.as_slice() {
            found.there.clone_from(&only.there);
            found.place.clone_from(&only.place);
            found.beside.clone_from(&only.beside);
            return found;
        }
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
                    let start = |by: usize| f64::from(t.slope_row(0, 0, k)[by]);
                    found.place[k] += (slope_between(t, a, each[i].between, k, b) - start(b))
                        * u[j]
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
            let share = if both {
                way.share
            } else {
                (way.near - way.below) as f64
            };
            let (low, high) = (row(e, way.below, root), row(e, way.below + 1, root));
            for ((x, l), h) in out.iter_mut().zip(low).zip(high) {
                *x += f64::from(*l) * (1.0 - share) + f64::from(*h) * share;
            }
        }
    }

    /// Slope of a root by the severity of one of all elements.
    #[must_use]
    pub fn slope(&self, t: &Tables<'_>, root: usize, by: usize) -> f64 {
        if let Some(slopes) = &self.slopes {
            return slopes[root * t.n + by];
        }
        let start = f64::from(t.slope_row(0, 0, root)[by]);
        let mut total = start;
        for (&e, way) in self.elements.iter().zip(&self.between) {
            let both = t.there[t.at(e, way.below) + root] && t.there[t.at(e, way.below + 1) + root];
            let share = if both {
                way.share
            } else {
                (way.near - way.below) as f64
            };
            let low = f64::from(t.slope_row(e, way.below, root)[by]);
            let high = f64::from(t.slope_row(e, way.below + 1, root)[by]);
            total += low + share * (high - low) - start;
        }
        total
    }
}
