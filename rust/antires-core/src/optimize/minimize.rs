//! The search: islands in step, generation by generation.
//!
//! ```text
//! populations at random, guesses among them; evaluate
//! polish the objective's own starting point, which settles on the first island
//! repeat
//!     if every island waits, or it is time to polish: polish the islands' bests; finished if they agree
//!     if every island waits: exchange and search on
//!     finished if a budget is spent
//!     every searching island proposes a generation; evaluate all proposals as one batch; accept
//! ```
//!
//! Each island draws from its own stream of the seed, proposals and acceptance go island by island,
//! and only the evaluation of a batch is parallel. So one seed gives the same bits for any number
//! of threads. Of equal costs the one found first wins, within a batch the lower island, then the
//! lower index. Without a [polish](super::polish) islands meet only when all wait, as in the paper. With
//! one, bests that are the same before any exchange were found independently, so that is asked at once.
//!
//! V. Meruane, Model updating using antiresonant frequencies identified from transmissibility
//! functions, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.

use super::archipelago::Archipelago;
use super::bounds::Bounds;
use super::evaluate::ObjectiveEvaluator;
use super::objective::{Evaluator, Objective};
use super::options::IslandOptions;
use super::outcome::{Failure, Hooks, Outcome};
use crate::error::{Error, Result};

/// Minimizes the cost that `evaluator` computes, inside `bounds`.
///
/// `guesses` join the initial populations: guess `g` goes to island `g` modulo their number. `seed`
/// determines the search entirely, apart from an interrupt. A search that is interrupted or runs out
/// of its budget still has an outcome: the best so far, and a status that says so. With a
/// snapshot in the hooks the search goes on from there, to the same bits.
///
/// # Errors
/// [`Failure::Input`] for unusable options or guesses; [`Failure::Evaluation`] with the evaluator's
/// own fault.
pub fn minimize<E: Evaluator>(
    evaluator: &mut E,
    bounds: &Bounds,
    guesses: &[Vec<f64>],
    options: &IslandOptions,
    seed: u64,
    hooks: &mut Hooks<'_>,
) -> std::result::Result<Outcome, Failure<E::Fault>> {
    options.validate()?;
    bounds.check_guesses(guesses)?;
    let room = options.islands * options.population;
    if guesses.len() > room {
        let wanted = format!("at most {room}, the individuals of all islands");
        return Err(
            Error::input("x0", format!("{} guesses", guesses.len()), wanted)
                .remedy("Keep the best of them, or give the islands more individuals.")
                .into(),
        );
    }
    let mut archipelago = Archipelago::new(evaluator, bounds, guesses, options, seed);
    if let Some(bytes) = hooks.resume {
        archipelago.restore(bytes)?;
    }
    let status = archipelago.search(hooks).map_err(Failure::Evaluation)?;
    Ok(archipelago.into_outcome(status))
}

/// As [`minimize`], for a native objective evaluated on `threads` threads of the search's own.
///
/// # Errors
/// If `threads`, the options or the guesses are unusable.
pub fn minimize_objective<O: Objective>(
    objective: &O,
    bounds: &Bounds,
    guesses: &[Vec<f64>],
    options: &IslandOptions,
    seed: u64,
    threads: usize,
    hooks: &mut Hooks<'_>,
) -> Result<Outcome> {
    let mut evaluator = ObjectiveEvaluator::new(objective, threads)?;
    minimize(&mut evaluator, bounds, guesses, options, seed, hooks).map_err(|failure| match failure
    {
        Failure::Input(error) => error,
        Failure::Evaluation(never) => match never {},
    })
}
