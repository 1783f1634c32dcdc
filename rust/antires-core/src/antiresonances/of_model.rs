//! The antiresonances of a model, each with a bound of its error if that is asked for.
//!
//! Dofs whose units are far apart are brought to one first ([`Balance`]), which moves no root.

use std::sync::Arc;

use super::bounded::{MOST_CHECKED, bounded};
use super::query::{Antiresonances, Query, Transfer};
use super::solver::{AntiresonanceSolver, Prepared};
use crate::error::Result;
use crate::fem::model::{Model, connected};
use crate::linalg::balance::Balance;
use crate::linalg::sparse::SparseMatrix;
use crate::modal::structure::{MOST_DENSE, Structure};

/// Antiresonances of each response of a model.
///
/// # Errors
/// [`crate::error::Error::InvalidInput`] for a dof outside the model, and those of the eigenproblems.
pub fn antiresonances(
    model: &Model,
    responses: &[usize],
    excitation: usize,
    query: &Query,
) -> Result<Vec<Antiresonances>> {
    each(
        model,
        responses,
        excitation,
        query,
        |prepared, (k_mat, m_mat), i, query| {
            let mut found = Antiresonances::default();
            let transfer = match prepared.find(i, excitation, query, &mut found.freq_hz) {
                Ok(transfer) => transfer,
                Err(error) if k_mat.n() > MOST_CHECKED => return Err(error),
                Err(_) => return bounded(prepared, (k_mat, m_mat), (i, excitation), query),
            };
            found.identically_zero = transfer == Transfer::IdenticallyZero;
            found.doubtful = !found.identically_zero && prepared.is_doubtful();
            Ok(found)
        },
    )
}

/// The same, each with a bound of its error: [`Antiresonances::error_hz`].
///
/// # Errors
/// Those of [`antiresonances`].
pub fn bounded_antiresonances(
    model: &Model,
    responses: &[usize],
    excitation: usize,
    query: &Query,
) -> Result<Vec<Antiresonances>> {
    each(
        model,
        responses,
        excitation,
        query,
        |prepared, matrices, i, query| bounded(prepared, matrices, (i, excitation), query),
    )
}

/// What `find` gives for each response on the balanced matrices, in the units of the model.
fn each(
    model: &Model,
    responses: &[usize],
    excitation: usize,
    query: &Query,
    find: impl Fn(
        &mut Prepared<'_>,
        (&SparseMatrix, &SparseMatrix),
        usize,
        &Query,
    ) -> Result<Antiresonances>,
) -> Result<Vec<Antiresonances>> {
    if model.n_dof() > MOST_DENSE {
        query.check_large(model.n_dof())?;
    }
    model.check_dof("excitation", excitation)?;
    for &i in responses {
        model.check_dof("response", i)?;
    }
    let balance = Balance::of_sparse(model.stiffness(), model.mass());
    let scaled = balance
        .as_ref()
        .map(|b| (b.stiffness(model.stiffness()), b.mass(model.mass())));
    let (k_mat, m_mat) = match &scaled {
        Some((k, m)) => (k, m),
        None => (model.stiffness(), model.mass()),
    };
    let query = &Query {
        f_max_hz: balance
            .as_ref()
            .map_or(query.f_max_hz, |b| b.scaled_frequency(query.f_max_hz)),
        ..*query
    };
    let structure = Structure::of(model);
    structure.check_room()?;
    let mut solver = AntiresonanceSolver::new(&Arc::new(structure));
    let mut prepared = solver.prepare(k_mat, m_mat);
    let mut out = Vec::with_capacity(responses.len());
    for &i in responses {
        let mut found = if connected(k_mat, m_mat, i, excitation) {
            find(&mut prepared, (k_mat, m_mat), i, query)?
        } else {
            Antiresonances {
                identically_zero: true,
                ..Antiresonances::default()
            }
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
