//! The island genetic algorithm: minimize `J(x)` over a box.
//!
//! Several populations (islands) search on their own, each with its own crossover operator, and
//! exchange their bests when all of them are stuck; the search ends when the islands agree.
//!
//! | step | definition | where |
//! |---|---|---|
//! | selection | rank `r` with probability `q' (1 - q)^(r - 1)` | [`island`] |
//! | crossover | arithmetic, heuristic, BLX-0.5, uniform: one per island, in turn | [`crossover`] |
//! | mutation | per gene with `p_m`: to a bound, or uniform | [`island`] |
//! | elitism, waiting | the best survives; 40 generations without improvement | [`island`] |
//! | migration | the best to both neighbours on a ring, for the worst there | [`island`] |
//! | polish | local search from the bests, where the objective tells its parts | [`polish`] |
//! | end | the bests agree in genes, or in cost at 3 migrations, or a budget | [`island`] |
//!
//! Beyond an objective ([`Objective`], or [`Evaluator`] for whole batches), [`Bounds`] and
//! [`IslandOptions`] there is nothing to set:
//!
//! ```
//! use antires_core::optimize::{minimize_objective, Bounds, Hooks, IslandOptions};
//!
//! let sphere = |x: &[f64]| x.iter().map(|x| (x - 0.3).powi(2)).sum::<f64>();
//! let bounds = Bounds::uniform(5, -1.0, 1.0)?;
//! let options = IslandOptions { max_evaluations: 20_000, ..IslandOptions::default() };
//! let outcome = minimize_objective(&sphere, &bounds, &[], &options, 7, 2, &mut Hooks::default())?;
//! assert!(outcome.fun < 1e-6);
//! # Ok::<(), antires_core::error::Error>(())
//! ```
//!
//! The same seed gives the same bits for any number of threads. No clock is read here: a time limit,
//! like Ctrl-C, is a hook that says stop.
//!
//! May use: `error`, `rng`.
//!
//! V. Meruane, Model updating using antiresonant frequencies identified from transmissibility
//! functions, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021. Where the paper does
//! not print a number (`q`, the share of the mutations, the heuristic's tries) the documentation of
//! [`IslandOptions`] and [`Crossover`] states ours.

mod archipelago;
mod bounds;
mod crossover;
mod descent;
mod island;
mod objective;
mod options;
mod outcome;
mod polish;
mod population;

pub use archipelago::{minimize, minimize_objective};
pub use bounds::Bounds;
pub use crossover::Crossover;
pub use objective::{
    Candidates, Composition, Evaluator, Linearization, Norm, Objective, ObjectiveEvaluator, evaluate_many,
};
pub use options::{Agreement, IslandOptions};
pub use outcome::{
    Failure, FinalIsland, History, Hooks, Interrupt, IslandProgress, IslandState, Keep, OnProgress, Outcome,
    Progress, ShouldStop, Status,
};
pub use population::Population;
