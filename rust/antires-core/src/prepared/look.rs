//! The values of a test and the roots expected in the measured structure, seen from one point of the severities.

use std::ops::Range;

use super::tables::{Entry, Places, SIDE, Tables, Test, factorize, gram, row, whiten_rows, whitened};
use crate::linalg::wide::{dot, widest};
use crate::update::alignment::{self, associate};

/// Error of a change in the association, share of it that all changes have in common, and by how much all
/// errors are widened.
const FIRST_KAPPA: f64 = 0.1;
const COMMON: f64 = 0.5;
const WIDER: [f64; 2] = [1.0, 3.0];

/// All that is linear from a point.
#[derive(Clone, Debug, Default)]
pub struct Look {
    /// Of the values.
    pub log_likelihood: f64,
    /// Gradient by the severities that were asked for.
    pub gain: Vec<f64>,
    /// Gauss-Newton Hessian by them, row-major.
    pub curvature: Vec<f64>,
    /// The most probable of the errors.
    pub error: usize,
    /// Root of each value in the order of response and place, −1 without one.
    pub partner: Vec<i64>,
    /// How far that root lies beside the model's.
    pub beside: Vec<f64>,
    /// Of values that have a root, ln f.
    pub residual: Vec<f64>,
    /// Their standard deviations, with that error.
    pub std: Vec<f64>,
    /// Of all together.
    pub chi_square: f64,
    /// Of all values alike, ln f, by that error.
    pub shift: f64,
}

/// Root of each value, and what those without a partner cost.
fn associated(test: &Test, roots: &Foreseen, sigma: &[f64], wider: f64) -> (Vec<i64>, f64) {
    let prices: Vec<_> = roots.place.iter().zip(&roots.seen).map(|(&p, &s)| test.prices(p, s)).collect();
    let alone_root: Vec<f64> = prices.iter().map(|(missed, present)| missed - present).collect();
    let sigma: Vec<f64> = sigma.iter().map(|s| wider * s).collect();
    let std: Vec<f64> = test.std.iter().map(|s| wider * s).collect();
    let of_roots = alignment::Places { response: &roots.response, log_f: &roots.place };
    let alone = test.alone();
    let (mut partner, mut first) = (Vec::with_capacity(std.len()), 0);
    while first < std.len() {
        let end = first + test.set[first..].partition_point(|&s| s == test.set[first]);
        let values =
            alignment::Places { response: &test.response[first..end], log_f: &test.log_f[first..end] };
        partner.extend(associate(values, &std[first..end], of_roots, &sigma, alone, &alone_root));
        first = end;
    }
    let lost = partner.iter().filter(|&&k| k < 0).count() as f64 * alone;
    // A root of a response that a set has not measured is not missed there.
    let missed: f64 = prices
        .iter()
        .zip(&roots.response)
        .map(|((missed, _), &response)| test.measured(response) * missed)
        .sum();
    let taken: f64 = partner.iter().filter_map(|&k| alone_root.get(usize::try_from(k).ok()?)).sum();
    (partner, lost + missed - taken)
}

/// Slopes of roots by all u, row-major.
fn slopes_of(t: &Tables<'_>, at: &Places, roots: &Foreseen, root: &[usize]) -> Vec<f64> {
    let mut slopes = vec![0.0; root.len() * t.n];
    for (&k, out) in root.iter().zip(slopes.chunks_exact_mut(t.n)) {
        if !roots.gone[k] {
            at.row(t, roots.root[k], |e, l, r| t.slope_row(e, l, r), out);
        }
    }
    slopes
}

/// Whitened vectors, the first of residuals, as they are where the `n` changes behind it, of standard deviation
/// 1 each, have made the covariance larger; half of the logarithm of what its determinant has gained.
fn moved_out(vectors: &mut [Vec<f64>], n: usize) -> f64 {
    let mut log_size = 0.0;
    for c in 1..=n {
        let change = vectors[c].clone();
        let square = dot(&change, &change);
        if square > 0.0 {
            // (I - f q q')^2 = I - q q' / (1 + q'q)
            let share = (1.0 - 1.0 / (1.0 + square).sqrt()) / square;
            for vector in &mut *vectors {
                let along = share * dot(&change, vector);
                for (x, q) in vector.iter_mut().zip(&change) {
                    *x -= along * q;
                }
            }
            log_size += 0.5 * square.ln_1p();
        }
    }
    log_size
}

/// ln of the probability of the values by each way and error, and the most probable of them.
fn probable(
    test: &Test,
    a: &[Entry],
    white: &[Entry],
    white_sides: &[Vec<Entry>],
    ways: &[Range<usize>; 3],
) -> ([[f64; SIDE]; 3], (usize, usize)) {
    let mut logs = [[f64::NEG_INFINITY; SIDE]; 3];
    let mut best = (0, 0);
    for (l, error) in test.errors.iter().enumerate() {
        let lane = |entries: &[Entry]| entries.iter().map(|w| w[l]).collect::<Vec<f64>>();
        let own = lane(white);
        let beside: Vec<Vec<f64>> = white_sides.iter().map(|side| lane(side)).collect();
        let log_diagonal: f64 = (0..white.len()).map(|i| a[row(i) + i][l].ln()).sum();
        for (way, columns) in ways.iter().enumerate() {
            let prior = error[3 + way];
            if prior > f64::NEG_INFINITY && (way == 0 || !columns.is_empty()) {
                let mut vectors = vec![own.clone()];
                vectors.extend(beside[columns.clone()].iter().cloned());
                let log_size = moved_out(&mut vectors, columns.len());
                logs[way][l] = prior - 0.5 * dot(&vectors[0], &vectors[0]) - log_diagonal - log_size;
                if logs[way][l] > logs[best.0][best.1] {
                    best = (way, l);
                }
            }
        }
    }
    (logs, best)
}

/// Slopes by `columns` at severities where `room` is 1 − β of each.
fn judged(
    t: &Tables<'_>,
    test: &Test,
    at: &Places,
    roots: &Foreseen,
    (partner, price): (Vec<i64>, f64),
    (columns, room): (&[usize], &[f64]),
) -> Look {
    let has: Vec<usize> = (0..partner.len()).filter(|&i| partner[i] >= 0).collect();
    let root: Vec<usize> = has.iter().map(|&i| partner[i] as usize).collect();
    let m = has.len();
    let residual: Vec<f64> = has.iter().zip(&root).map(|(&i, &k)| test.log_f[i] - roots.place[k]).collect();
    let changes: f64 = root.iter().map(|&k| roots.change[k].powi(2)).sum();
    let mean = changes / m.max(1) as f64;
    let size: Vec<f64> = root.iter().map(|&k| (roots.change[k].powi(2) + COMMON * mean).sqrt()).collect();
    let model = covariance(t, test, roots, &root);
    let by_u = slopes_of(t, at, roots, &root);
    let of = |i: usize| &by_u[i * t.n..][..t.n];
    let total: f64 = by_u.iter().map(|s| s * s).sum();
    let mixed = test.errors.iter().any(|e| e[2] > 0.0) && total > 0.0;
    let error = |l: usize| test.errors[l.min(test.errors.len() - 1)];
    let squares: [Entry; 3] = [0, 1, 2].map(|part| std::array::from_fn(|l| error(l)[part].powi(2)));
    let mut a: Vec<Entry> = Vec::with_capacity(model.len());
    for i in 0..m {
        for j in 0..=i {
            let c = model[row(i) + j];
            let own = if root[i] == root[j] { size[i] * size[j] } else { 0.0 };
            let noise = if i == j { test.std[has[i]].powi(2) } else { 0.0 };
            let along = if mixed { dot(of(i), of(j)) * changes / total } else { 0.0 };
            a.push(std::array::from_fn(|l| {
                c + squares[1][l] * noise + squares[0][l] * own + squares[2][l] * along
            }));
        }
    }
    let mut sides: Vec<Vec<f64>> =
        vec![root.iter().map(|&k| if roots.gone[k] { 0.0 } else { test.together.alike }).collect()];
    if at.u.iter().filter(|&&u| u > 0.0).count() < test.together.many {
        let by_heat = |w: &[f64]| (0..m).map(|i| dot(of(i), w)).collect::<Vec<f64>>();
        sides.extend(test.together.heat.chunks_exact(t.n.max(1)).map(by_heat));
    }
    let ways = [0..0, 0..1, 1..sides.len()];
    let diagonal: Vec<Entry> = (0..m).map(|i| a[row(i) + i]).collect();
    factorize(&mut a, m);
    let white = whitened(&a, &residual);
    let white_sides: Vec<Vec<Entry>> = sides.iter().map(|side| whitened(&a, side)).collect();
    let (logs, (way, best)) = probable(test, &a, &white, &white_sides, &ways);
    let most = logs[way][best];
    let sum: f64 = logs.iter().flatten().map(|x| (x - most).exp()).sum();
    let width = columns.len();
    let mut slopes = Vec::with_capacity(m * width);
    for i in 0..m {
        let slope = |c: usize| if c < t.n { of(i)[c] } else { at.slope(t, roots.root[root[i]], c) };
        slopes.extend(columns.iter().zip(room).map(|(&c, r)| slope(c) / r));
    }
    whiten_rows(&a, best, &mut slopes, width);
    let mut vectors: Vec<Vec<f64>> = vec![white.iter().map(|w| w[best]).collect()];
    vectors.extend(white_sides[ways[way].clone()].iter().map(|side| side.iter().map(|w| w[best]).collect()));
    let n_changes = vectors.len() - 1;
    vectors.extend((0..width).map(|c| slopes.iter().skip(c).step_by(width.max(1)).copied().collect()));
    if n_changes > 0 {
        moved_out(&mut vectors, n_changes);
        for (c, column) in vectors[1 + n_changes..].iter().enumerate() {
            for (i, x) in column.iter().enumerate() {
                slopes[i * width + c] = *x;
            }
        }
    }
    let gain: Vec<f64> = vectors[1 + n_changes..].iter().map(|column| dot(column, &vectors[0])).collect();
    let (mut moved, mut more) = (vec![0.0; m], vec![0.0; m]);
    for (side, own) in sides[ways[way].clone()].iter().zip(&vectors[1..]) {
        let amount = dot(own, &vectors[0]);
        for i in 0..m {
            moved[i] += amount * side[i];
            more[i] += side[i].powi(2);
        }
    }
    moved.sort_by(f64::total_cmp);
    let shift = if m == 0 { 0.0 } else { 0.5 * (moved[(m - 1) / 2] + moved[m / 2]) };
    let mut beside = vec![0.0; partner.len()];
    for (&i, &k) in has.iter().zip(&root) {
        beside[i] = if roots.gone[k] { 0.0 } else { at.beside[roots.root[k]] };
    }
    Look {
        log_likelihood: most + sum.ln() - 0.5 * m as f64 * (2.0 * std::f64::consts::PI).ln() - price,
        gain,
        curvature: gram(&slopes, width),
        error: best,
        partner,
        beside,
        residual,
        std: diagonal.iter().zip(&more).map(|(d, s)| (d[best] + s).sqrt()).collect(),
        chi_square: dot(&vectors[0], &vectors[0]),
        shift,
    }
}

/// The most probable of the ways to associate values and roots, with slopes by the severities of `columns`.
pub fn look(t: &Tables<'_>, test: &Test, at: &Places, columns: &[usize]) -> Look {
    let roots = foreseen(t, test, at);
    let own = variances(t, &roots);
    let room: Vec<f64> = columns
        .iter()
        .map(|c| at.elements.iter().position(|e| e == c).map_or(1.0, |nth| (-at.u[nth]).exp()))
        .collect();
    let alike = test.together.alike;
    let mut best: Option<Look> = None;
    let mut before: Option<Vec<i64>> = None;
    for (wider, moved) in [(WIDER[0], 0.0), (WIDER[1], 0.0), (1.0, alike)] {
        // All may have moved alike where some found no root.
        if moved > 0.0 && before.as_ref().is_some_and(|partner| !partner.contains(&-1)) {
            break;
        }
        let sigma: Vec<f64> = (0..own.len())
            .map(|k| {
                let common = if roots.gone[k] { 0.0 } else { test.common * test.common };
                let change = (FIRST_KAPPA * roots.change[k]).powi(2);
                (own[k] + common + roots.extra[k] + change + moved * moved).sqrt()
            })
            .collect();
        let way = associated(test, &roots, &sigma, wider);
        if before.as_ref() == Some(&way.0) {
            continue;
        }
        before = Some(way.0.clone());
        let found = judged(t, test, at, &roots, way, (columns, &room));
        if best.as_ref().is_none_or(|known| found.log_likelihood > known.log_likelihood) {
            best = Some(found);
        }
    }
    best.unwrap_or_default()
}

// ---- expected

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
    /// What multiplies the errors of the model; empty without damage, where their covariance is known.
    pub rows: Vec<f64>,
    /// Variance of its own.
    pub extra: Vec<f64>,
}

/// The roots near the band, ascending by response and place.
pub fn foreseen(t: &Tables<'_>, test: &Test, at: &Places) -> Foreseen {
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
        (t.response[a.0], a.1).partial_cmp(&(t.response[b.0], b.1)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut rows = Vec::new();
    if !at.elements.is_empty() {
        rows.resize(shown.len() * t.q, 0.0);
        for (&(k, _, gone), out) in shown.iter().zip(rows.chunks_exact_mut(t.q.max(1))) {
            if !gone {
                at.row(t, k, |e, level, root| t.error_row(e, level, root), out);
            }
        }
    }
    let of = |f: &dyn Fn(usize, f64, bool) -> f64| -> Vec<f64> {
        shown.iter().map(|&(k, place, gone)| f(k, place, gone)).collect()
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
            (false, true) => test.extra * test.extra,
            (false, false) => t.new_variance + test.extra * test.extra,
        }),
        rows,
    }
}

widest!(
    /// Lower triangle of products of rows.
    fn spread(rows: &[f64], q: usize, which: &[usize]) -> Vec<f64> {
        let own = |k: usize| &rows[which[k] * q..][..q];
        let mut found = Vec::with_capacity(row(which.len()));
        for i in 0..which.len() {
            for j in 0..=i {
                found.push(dot(own(i), own(j)));
            }
        }
        found
    }
);

/// Lower triangle of the covariance of some of the roots that are shown, without what is measured.
pub fn covariance(t: &Tables<'_>, test: &Test, roots: &Foreseen, which: &[usize]) -> Vec<f64> {
    let mut found = if roots.rows.is_empty() {
        let mut found = Vec::with_capacity(row(which.len()));
        for i in 0..which.len() {
            for &b in &which[..=i] {
                let pair = roots.root[which[i]] * t.size() + roots.root[b];
                found.push(if roots.gone[which[i]] || roots.gone[b] { 0.0 } else { t.spread[pair] });
            }
        }
        found
    } else {
        spread(&roots.rows, t.q, which)
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

widest!(
    /// Squared length of each row.
    fn squares(rows: &[f64], q: usize) -> Vec<f64> {
        rows.chunks_exact(q).map(|own| dot(own, own)).collect()
    }
);

/// Variance of every root that is shown, by the errors of the model alone.
pub fn variances(t: &Tables<'_>, roots: &Foreseen) -> Vec<f64> {
    if !roots.rows.is_empty() {
        return squares(&roots.rows, t.q);
    }
    let size = t.size();
    let one = |(&k, &gone)| if gone { 0.0 } else { t.spread[k * size + k] };
    roots.root.iter().zip(&roots.gone).map(one).collect()
}
