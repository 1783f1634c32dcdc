//! The antiresonances of a model, each with a bound of its error if that is asked for.
//!
//! Dofs whose units are far apart are brought to one first ([`Balance`]), which moves no root. Models of up to [`MOST_CHECKED`] dofs are solved on both routes, and what one of them finds alone counts if the
//! matrices confirm it ([`RootBounds`]).

use std::sync::Arc;

use super::solver::{AntiresonanceSolver, Antiresonances, Prepared, Query, Transfer, pencil_roots};
use crate::error::Result;
use crate::fem::model::{Model, joins};
use crate::linalg::balance::Balance;
use crate::linalg::pencil::{Bounded, RootBounds, UNCERTAIN, roots_near};
use crate::linalg::sparse::SparseMatrix;
use crate::modal::minor::Ends;
use crate::modal::modes::{eigenvalue, hertz};
use crate::modal::structure::{MOST_DENSE, Structure};

/// Antiresonances of a model between each of some ends.
pub fn antiresonances(model: &Model, every: &[Ends], query: &Query) -> Result<Vec<Antiresonances>> {
    each(model, every, query, |prepared, (k_mat, m_mat), ends, query| {
        let mut found = Antiresonances::default();
        let transfer = match prepared.find(ends, query, &mut found.freq_hz) {
            Ok(transfer) => transfer,
            Err(error) if k_mat.n() > MOST_CHECKED => return Err(error),
            Err(_) => return bounded(prepared, (k_mat, m_mat), ends, query),
        };
        found.identically_zero = transfer == Transfer::IdenticallyZero;
        found.doubtful = !found.identically_zero && prepared.is_doubtful();
        Ok(found)
    })
}

/// The same, each with a bound of its error: [`Antiresonances::error_hz`].
pub fn bounded_antiresonances(model: &Model, every: &[Ends], query: &Query) -> Result<Vec<Antiresonances>> {
    each(model, every, query, bounded)
}

/// What `find` gives for each on the balanced matrices, in the units of the model.
fn each(
    model: &Model,
    every: &[Ends],
    query: &Query,
    find: impl Fn(&mut Prepared<'_>, (&SparseMatrix, &SparseMatrix), &Ends, &Query) -> Result<Antiresonances>,
) -> Result<Vec<Antiresonances>> {
    if model.n_dof() > MOST_DENSE {
        query.check_large(model.n_dof())?;
    }
    for ends in every {
        ends.forces().iter().try_for_each(|&k| model.check_dof("excitation", k))?;
        ends.responses().iter().try_for_each(|&i| model.check_dof("response", i))?;
    }
    let balance = Balance::of_sparse(model.stiffness(), model.mass());
    let scaled = balance.as_ref().map(|b| (b.stiffness(model.stiffness()), b.mass(model.mass())));
    let (k_mat, m_mat) = match &scaled {
        Some((k, m)) => (k, m),
        None => (model.stiffness(), model.mass()),
    };
    let query = &Query {
        f_max_hz: balance.as_ref().map_or(query.f_max_hz, |b| b.scaled_frequency(query.f_max_hz)),
        ..*query
    };
    let structure = Structure::of(model);
    structure.check_room()?;
    let mut solver = AntiresonanceSolver::new(&Arc::new(structure));
    let mut prepared = solver.prepare(k_mat, m_mat);
    let mut out = Vec::with_capacity(every.len());
    for ends in every {
        let mut found = if joins(k_mat, m_mat, ends.responses(), ends.forces()) {
            find(&mut prepared, (k_mat, m_mat), ends, query)?
        } else {
            Antiresonances { identically_zero: true, ..Antiresonances::default() }
        };
        if let Some(balance) = &balance {
            for freq in found.freq_hz.iter_mut().chain(&mut found.error_hz) {
                *freq = balance.frequency(*freq);
            }
        }
        out.push(found);
    }
    Ok(out)
}

// ---- bounded

/// Most dofs of which each root is confirmed on the dense deleted pencil, and both routes are asked.
pub(super) const MOST_CHECKED: usize = 400;

/// Relative distance in x, beside its bound, at which a root lies on a pole: what modes are known to.
const ON_POLE: f64 = 1e-10;

/// Rounding of x = ω² to Hz, relative.
const TO_HERTZ: f64 = 4.0 * f64::EPSILON;

/// The roots of one response with their bounds.
pub(super) fn bounded(
    prepared: &mut Prepared<'_>,
    matrices: (&SparseMatrix, &SparseMatrix),
    ends: &Ends,
    query: &Query,
) -> Result<Antiresonances> {
    let (i, k) = (ends.responses(), ends.forces());
    let n = matrices.0.n();
    let mut found = Antiresonances::default();
    let first = prepared.find(ends, query, &mut found.freq_hz);
    if n > MOST_CHECKED {
        found.identically_zero = first? == Transfer::IdenticallyZero;
        found.doubtful = !found.identically_zero && prepared.is_doubtful();
        found.error_hz = found.freq_hz.iter().map(|&f| prepared.bound(ends, f)).collect();
        return Ok(found);
    }
    let mut on_poles = Vec::new();
    let is_zero = match &first {
        Ok(transfer) => {
            if query.include_cancelled {
                prepared.cancelled(&mut on_poles);
            }
            *transfer == Transfer::IdenticallyZero
        }
        Err(_) => false,
    };
    // A root that only the pencil has, on a pole, cancels: the FRF shows nothing there.
    let cancelling = match &first {
        Ok(_) if !query.include_cancelled => prepared.eigenvalues()?.to_vec(),
        _ => Vec::new(),
    };
    let certifier = RootBounds::of(&matrices.0.deleted(i, k), &matrices.1.deleted(i, k));
    let x_of = |freq_hz: &[f64]| -> Vec<f64> { freq_hz.iter().map(|&f| eigenvalue(f)).collect() };
    let mut x = x_of(&found.freq_hz);
    let ceiling = eigenvalue(query.f_max_hz);
    // Where QZ fails, the modal route stands alone.
    let roots = match candidates(matrices, ends, ceiling) {
        Err(_) => certifier.places(&x),
        Ok(by_qz) => {
            // A residue may be negligible without a root beside the pole.
            let alone = take_out(&mut x, &x_of(&on_poles), &by_qz);
            let mut roots = certifier.places(&x);
            let sure = |root: &Bounded| root.bound <= UNCERTAIN * root.x;
            let confirmed = |candidates: &[f64]| -> Vec<Bounded> {
                certifier
                    .places(candidates)
                    .into_iter()
                    .filter(sure)
                    .filter(|root| !cancelling.iter().any(|&pole| on_pole(root, pole)))
                    .collect()
            };
            add_new(&mut roots, &confirmed(&by_qz));
            for more in at_other_scales(matrices, ends, ceiling) {
                add_new(&mut roots, &confirmed(&more));
            }
            for root in certifier.places(&alone).into_iter().filter(sure) {
                if !roots.iter().any(|other| near(root.x, other.x)) {
                    roots.push(root);
                }
            }
            roots.sort_by(|p, q| p.x.total_cmp(&q.x));
            if roots.len() > x.len() {
                // What was added may lie so close to others that only all of them together have a bound.
                let all: Vec<f64> = roots.iter().map(|root| root.x).collect();
                roots = certifier.places(&all);
            }
            roots
        }
    };
    if first.is_err() {
        // Without modes QZ alone has to tell. A dof without stiffness and mass leaves it nothing to tell.
        if roots.is_empty() || has_empty_row(matrices) {
            return first.map(|_| found);
        }
        found.doubtful = true;
    }
    found.identically_zero = is_zero && roots.is_empty();
    found.freq_hz = roots.iter().map(|root| hertz(root.x)).collect();
    found.error_hz = roots.iter().map(hertz_error).collect();
    Ok(found)
}

/// Whether a root lies on a pole.
fn on_pole(root: &Bounded, pole: f64) -> bool {
    (root.x - pole).abs() <= root.bound + ON_POLE * root.x
}

/// Whether some dof has neither stiffness nor mass.
fn has_empty_row((k_mat, m_mat): (&SparseMatrix, &SparseMatrix)) -> bool {
    let mut present = vec![false; k_mat.n()];
    for (i, _, value) in k_mat.entries().chain(m_mat.entries()) {
        present[i] |= value != 0.0;
    }
    present.contains(&false)
}

/// The bound in Hz of one in x = ω²; infinite for one that is not certain.
fn hertz_error(root: &Bounded) -> f64 {
    if root.bound <= UNCERTAIN * root.x {
        // √ is concave: the lower side is the farther one.
        let freq = hertz(root.x);
        (freq - hertz(root.x - root.bound)).max(0.0) + TO_HERTZ * freq
    } else {
        f64::INFINITY
    }
}

// ---- candidates

/// Most dofs of which QZ is asked at several scales, and the ratio of the entries of K and M from which on it is.
const MOST_AT_SCALES: usize = 120;
const FAR_APART: f64 = 1e8;

/// Relative distance in x within which a root of one route is that of the other.
const SAME_ROOT: f64 = 1e-6;

/// Whether two roots in x are one.
pub(super) fn near(x: f64, other: f64) -> bool {
    (x - other).abs() <= SAME_ROOT * x
}

/// Adds to `roots` those of `sure` that have no partner of their own there; one that is not certain takes its place
/// from its partner.
pub(super) fn add_new(roots: &mut Vec<Bounded>, sure: &[Bounded]) {
    let mut free: Vec<usize> = (0..roots.len()).collect();
    for root in sure {
        let distance = |&at: &usize| (roots[at].x - root.x).abs();
        let closest = (0..free.len()).min_by(|&p, &q| distance(&free[p]).total_cmp(&distance(&free[q])));
        let reach = |at: usize| {
            let own = root.bound + roots[at].bound.min(UNCERTAIN * root.x);
            own.max(SAME_ROOT * root.x)
        };
        match closest.filter(|&p| distance(&free[p]) <= reach(free[p])) {
            Some(p) => {
                let at = free.swap_remove(p);
                if roots[at].bound.is_infinite() {
                    roots[at] = *root;
                }
            }
            None => roots.push(*root),
        }
    }
}

/// Takes those `on_poles` out of `x` that have no partner of their own among `by_qz`, after all others of `x` have
/// taken theirs.
pub(super) fn take_out(x: &mut Vec<f64>, on_poles: &[f64], by_qz: &[f64]) -> Vec<f64> {
    let mut places = Vec::new();
    for pole in on_poles {
        let same = |&j: &usize| x[j] == *pole && !places.contains(&j);
        places.extend((0..x.len()).find(same));
    }
    let mut free = by_qz.to_vec();
    let mut take = |x: f64| match free.iter().position(|&other| near(x, other)) {
        Some(at) => {
            free.swap_remove(at);
            true
        }
        None => false,
    };
    for (_, &x) in x.iter().enumerate().filter(|(j, _)| !places.contains(j)) {
        take(x);
    }
    places.retain(|&j| !take(x[j]));
    places.sort_unstable();
    places.iter().rev().map(|&j| x.remove(j)).collect()
}

/// What QZ takes for real and positive roots up to `ceiling`, ascending, well known or not.
pub(super) fn candidates(
    matrices: (&SparseMatrix, &SparseMatrix),
    ends: &Ends,
    ceiling: f64,
) -> Result<Vec<f64>> {
    Ok(pencil_roots(matrices, ends, (0.0, ceiling))?.iter().map(|root| root.x).collect())
}

/// The same, of pencils whose roots may be many decades apart, once for each end: QZ knows a root by the size of the
/// matrices near it.
pub(super) fn at_other_scales(
    (k_mat, m_mat): (&SparseMatrix, &SparseMatrix),
    ends: &Ends,
    ceiling: f64,
) -> Vec<Vec<f64>> {
    let (i, k) = (ends.responses(), ends.forces());
    if k_mat.n() > MOST_AT_SCALES {
        return Vec::new();
    }
    let mut ratios: Vec<f64> = k_mat
        .entries()
        .zip(&m_mat.values)
        .filter(|((_, _, k), m)| *k != 0.0 && **m != 0.0)
        .map(|((_, _, k), m)| (k / m).abs())
        .collect();
    ratios.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (ratios.first(), ratios.last()) else {
        return Vec::new();
    };
    if most < FAR_APART * least {
        return Vec::new();
    }
    let (a, b) = (k_mat.deleted(i, k), m_mat.deleted(i, k));
    [least, most].map(|x| roots_near(a.as_ref(), b.as_ref(), x, ceiling)).into()
}
