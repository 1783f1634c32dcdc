//! Descent without derivatives: compass search, for objectives that only know their value.
//!
//! From the point, one step up and one down along every gene are evaluated as one batch; the best of
//! them, and the sum of all that gained, are where the search goes on; where none gains, the steps halve.
//!
//! T. G. Kolda, R. M. Lewis & V. Torczon, Optimization by direct search, SIAM Review 45 (2003) 385-482.

use super::super::composition::Composition;
use super::super::ledger::{Ledger, Stop};
use super::super::objective::Evaluator;
use super::super::outcome::Hooks;
use super::point::Point;

/// First and least step, as fractions of each gene's range.
const FIRST_STEP: f64 = 1.0 / 16.0;
const LEAST_STEP: f64 = 1e-7;

/// Brings `point` down, with at most `limits` steps and about so many evaluations; it never
/// gets worse.
pub(super) fn descend<E: Evaluator>(
    point: &mut Point,
    composition: &Composition,
    limits: (usize, usize),
    ledger: &mut Ledger<'_, E>,
    hooks: &mut Hooks<'_>,
) -> Result<(), Stop<E::Fault>> {
    let end = ledger.evaluations.saturating_add(limits.1);
    let (lower, upper) = (ledger.bounds.lower(), ledger.bounds.upper());
    let free: Vec<usize> = (0..point.x.len())
        .filter(|&gene| {
            upper[gene] > lower[gene] && !(composition.sparse[gene] && point.x[gene] == lower[gene])
        })
        .collect();
    let n = point.x.len();
    let (mut batch, mut costs) = (Vec::new(), Vec::new());
    let mut size = FIRST_STEP;
    for _ in 0..limits.0 {
        if size < LEAST_STEP || ledger.evaluations >= end || free.is_empty() {
            break;
        }
        batch.clear();
        for &gene in &free {
            for sign in [1.0, -1.0] {
                let mut trial = point.x.clone();
                trial[gene] += sign * size * (upper[gene] - lower[gene]);
                ledger.repair(&mut trial);
                batch.extend(trial);
            }
        }
        ledger.all_costs(&batch, &mut costs, hooks)?;
        let before = point.clone();
        let mut together = point.x.clone();
        let mut gained = 0;
        for (row, &cost) in batch.chunks_exact(n).zip(&costs) {
            if cost < before.cost {
                gained += 1;
                for (sum, (there, here)) in together.iter_mut().zip(row.iter().zip(&before.x)) {
                    *sum += there - here;
                }
            }
            point.take(row, cost);
        }
        if gained == 0 {
            size *= 0.5;
        } else if gained > 1 {
            ledger.repair(&mut together);
            ledger.all_costs(&together, &mut costs, hooks)?;
            point.take(&together, costs[0]);
        }
    }
    Ok(())
}
