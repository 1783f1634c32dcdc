//! The roots as they are expected in the measured structure at some severities.

use super::factor::row;
use super::places::Places;
use super::tables::Tables;
use super::values::Test;
use crate::linalg::wide::{NullaryFnOnce, dot, run};

/// Change of a root that has just appeared.
const NEW: f64 = 0.1;
/// Standard deviation of a root that the model has lost and the structure may have, from its intact place.
const LOST: f64 = 0.1;
/// Roots so far outside of the band (ln f) are not looked at.
const MARGIN: f64 = 0.3;
/// Roots as they are expected, those that count alone.
#[derive(Clone, Debug)]
pub struct Foreseen {
    /// Number in the tables.
    pub root: Vec<usize>,
    /// Its response.
    pub response: Vec<i64>,
    /// ln f expected.
    pub place: Vec<f64>,
    /// Whether the model has lost it.
    pub gone: Vec<bool>,
    /// From the intact state.
    pub change: Vec<f64>,
    /// Whether the baseline shows it.
    pub seen: Vec<bool>,
    /// What multiplies the errors of the model; empty for those without damage.
    pub rows: Vec<f64>,
    /// Variance of its own.
    pub extra: Vec<f64>,
}

/// Whether errors of the model are those at the severities, or those without damage: four times quicker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errors {
    /// At the severities.
    There,
    /// Without damage.
    Undamaged,
}

/// The roots near the band, ascending by response and place.
#[must_use]
pub fn foreseen(t: &Tables<'_>, test: &Test<'_>, at: &Places, errors: Errors) -> Foreseen {
    let mut shown: Vec<(usize, f64, bool)> = Vec::with_capacity(t.size());
    for k in 0..t.size() {
        let gone = t.seen[k] && !at.there[k];
        let model = at.place[k] - at.beside[k];
        let near = at.there[k] && model > test.low - MARGIN && model < test.high + MARGIN;
        if gone {
            shown.push((k, t.intact[k] + t.beside[k], true));
        } else if near {
            shown.push((k, at.place[k], false));
        }
    }
    shown.sort_by(|a, b| {
        (t.response[a.0], a.1)
            .partial_cmp(&(t.response[b.0], b.1))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut rows = Vec::new();
    if errors == Errors::There {
        rows.resize(shown.len() * t.q, 0.0);
        for (&(k, _, gone), out) in shown.iter().zip(rows.chunks_exact_mut(t.q.max(1))) {
            if !gone {
                at.row(t, k, |e, level, root| t.error_row(e, level, root), out);
            }
        }
    }
    let of = |f: &dyn Fn(usize, f64, bool) -> f64| -> Vec<f64> {
        shown
            .iter()
            .map(|&(k, place, gone)| f(k, place, gone))
            .collect()
    };
    Foreseen {
        root: shown.iter().map(|one| one.0).collect(),
        response: shown.iter().map(|one| t.response[one.0]).collect(),
        place: shown.iter().map(|one| one.1).collect(),
        gone: shown.iter().map(|one| one.2).collect(),
        change: of(&|k, place, gone| match (gone, t.old[k]) {
            (true, _) => 0.0,
            (false, true) => place - at.beside[k] - t.intact[k],
            (false, false) => NEW,
        }),
        seen: shown.iter().map(|one| t.seen[one.0] && !one.2).collect(),
        extra: of(&|k, _, gone| match (gone, t.old[k]) {
            (true, _) => LOST * LOST,
            (false, true) => 0.0,
            (false, false) => t.new_variance,
        }),
        rows,
    }
}

struct Spread<'a> {
    rows: &'a [f64],
    q: usize,
    which: &'a [usize],
}

impl NullaryFnOnce for Spread<'_> {
    type Output = Vec<f64>;

    /// Lower triangle of products of rows.
    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let own = |k: usize| &self.rows[self.which[k] * self.q..][..self.q];
        let mut found = Vec::with_capacity(row(self.which.len()));
        for i in 0..self.which.len() {
            for j in 0..=i {
                found.push(dot(own(i), own(j)));
            }
        }
        found
    }
}

/// Lower triangle of the covariance of some of the roots that are shown, without what is measured.
#[must_use]
pub fn covariance(t: &Tables<'_>, test: &Test<'_>, roots: &Foreseen, which: &[usize]) -> Vec<f64> {
    let mut found = if roots.rows.is_empty() {
        let mut found = Vec::with_capacity(row(which.len()));
        for i in 0..which.len() {
            for &b in &which[..=i] {
                let pair = roots.root[which[i]] * t.size() + roots.root[b];
                found.push(if roots.gone[which[i]] || roots.gone[b] {
                    0.0
                } else {
                    t.spread[pair]
                });
            }
        }
        found
    } else {
        run(Spread {
            rows: &roots.rows,
            q: t.q,
            which,
        })
    };
    let alike = |k: usize| if roots.gone[k] { 0.0 } else { test.common };
    for i in 0..which.len() {
        for j in 0..=i {
            found[row(i) + j] += alike(which[i]) * alike(which[j]);
            if which[i] == which[j] {
                found[row(i) + j] += roots.extra[which[i]];
            }
        }
    }
    found
}

struct Variances<'a> {
    rows: &'a [f64],
    q: usize,
}

impl NullaryFnOnce for Variances<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        self.rows
            .chunks_exact(self.q)
            .map(|own| dot(own, own))
            .collect()
    }
}

/// Variance of every root that is shown, by the errors of the model alone.
#[must_use]
pub fn variances(t: &Tables<'_>, roots: &Foreseen) -> Vec<f64> {
    if !roots.rows.is_empty() {
        return run(Variances {
            rows: &roots.rows,
            q: t.q,
        });
    }
    let size = t.size();
    let one = |(&k, &gone)| if gone { 0.0 } else { t.spread[k * size + k] };
    roots.root.iter().zip(&roots.gone).map(one).collect()
}
