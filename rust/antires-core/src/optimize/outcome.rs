//! What a search reports: its progress while it runs, its outcome when it ends.

use super::crossover::Crossover;
use super::population::Population;
use crate::error::Error;

/// Why a caller's hook asks the search to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interrupt {
    /// The user: Ctrl-C.
    User,
    /// The time allowed is over.
    TimeLimit,
    /// The caller's callback has seen enough.
    Callback,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The islands' bests agree in every gene.
    Agreed,
    /// The islands' bests agreed in cost at several successive migrations, not in genes: a flat
    /// valley, many `x` explain the data equally well.
    CostAgreed,
    /// The only island found no improvement; there is no other to agree with.
    Stagnated,
    /// Between two migrations not one new candidate arose, and still the bests disagree: the
    /// populations have collapsed.
    Collapsed,
    /// The budget of evaluations is spent.
    MaxEvaluations,
    /// The budget of generations is spent.
    MaxGenerations,
    /// The time allowed is over.
    TimeLimit,
    /// The user interrupted.
    Interrupted,
    /// The callback asked to stop.
    Callback,
}

impl Status {
    /// Whether the search ended by itself, by its own rules for having finished.
    pub fn success(self) -> bool {
        matches!(self, Self::Agreed | Self::CostAgreed | Self::Stagnated)
    }

    /// The status in a word or two: `agreed`, `cost agreed`, `stagnated`, `collapsed`, `budget` (of
    /// evaluations, generations or time), `interrupted` or `callback`.
    pub fn label(self) -> &'static str {
        match self {
            Self::Agreed => "agreed",
            Self::CostAgreed => "cost agreed",
            Self::Stagnated => "stagnated",
            Self::Collapsed => "collapsed",
            Self::MaxEvaluations | Self::MaxGenerations | Self::TimeLimit => "budget",
            Self::Interrupted => "interrupted",
            Self::Callback => "callback",
        }
    }

    /// The status in a sentence.
    pub fn message(self) -> &'static str {
        match self {
            Self::Agreed => "All searches ended at one solution.",
            Self::CostAgreed => {
                "The islands' best individuals agree in cost but not in genes: \
                 several solutions are equally good."
            }
            Self::Stagnated => "The only island found no further improvement.",
            Self::Collapsed => {
                "The populations collapsed: no new candidate arises, yet the islands' best \
                 individuals disagree. Raise the mutation probability or the population."
            }
            Self::MaxEvaluations => {
                "The budget of evaluations, linearizations included, was spent before the islands agreed."
            }
            Self::MaxGenerations => "The budget of generations was spent before the islands agreed.",
            Self::TimeLimit => "The time limit was reached before the islands agreed.",
            Self::Interrupted => "Interrupted by the user; this is the best found until then.",
            Self::Callback => "Stopped by the callback; this is the best found until then.",
        }
    }
}

impl From<Interrupt> for Status {
    fn from(interrupt: Interrupt) -> Self {
        match interrupt {
            Interrupt::User => Self::Interrupted,
            Interrupt::TimeLimit => Self::TimeLimit,
            Interrupt::Callback => Self::Callback,
        }
    }
}

/// What an island is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IslandState {
    /// It proposes a generation at a time.
    Searching,
    /// It found no improvement for a while and waits for the others.
    Waiting,
}

/// One island, seen from outside while the search runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IslandProgress {
    /// Its lowest cost.
    pub best_cost: f64,
    /// What it is doing.
    pub state: IslandState,
}

/// The search after a generation.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Generations completed; 0 after the initial populations.
    pub generation: usize,
    /// Evaluations so far.
    pub evaluations: usize,
    /// Migrations so far.
    pub migrations: usize,
    /// The lowest cost so far.
    pub best_cost: f64,
    /// The candidate it belongs to.
    pub best_x: &'a [f64],
    /// The islands in order.
    pub islands: &'a [IslandProgress],
}

/// A question to the caller: shall the search stop?
pub type ShouldStop<'a> = dyn FnMut() -> Option<Interrupt> + 'a;

/// A caller's view of every generation, and its chance to stop the search.
pub type OnProgress<'a> = dyn FnMut(&Progress<'_>) -> Option<Interrupt> + 'a;

/// Takes the search as it stands between two generations, for [`Hooks::resume`].
pub type Keep<'a> = dyn FnMut(Vec<u8>) + 'a;

/// What the caller wants to be asked and told; the default is nothing.
#[derive(Default)]
pub struct Hooks<'a> {
    /// Asked after every generation, and every few candidates or milliseconds while one is
    /// evaluated; always on the calling thread. Must be quick: a microsecond, not a millisecond.
    pub should_stop: Option<&'a mut ShouldStop<'a>>,
    /// Told of every generation, the initial one included.
    pub progress: Option<&'a mut OnProgress<'a>>,
    /// Given a snapshot after every generation: some copies of the populations.
    pub keep: Option<&'a mut Keep<'a>>,
    /// The snapshot to go on from.
    pub resume: Option<&'a [u8]>,
}

impl Hooks<'_> {
    /// Asks whether to stop.
    pub(super) fn poll(&mut self) -> Option<Interrupt> {
        self.should_stop.as_mut().and_then(|ask| ask())
    }

    /// Reports a generation.
    pub(super) fn report(&mut self, progress: &Progress<'_>) -> Option<Interrupt> {
        self.progress.as_mut().and_then(|tell| tell(progress))
    }
}

/// How the search went: a record per generation, the initial populations' first; none where that was interrupted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// The number of islands.
    pub n_islands: usize,
    /// Evaluations up to and with each generation.
    pub evaluations: Vec<usize>,
    /// Each generation's lowest cost per island: a row per generation, a column per island.
    pub best_costs: Vec<f64>,
    /// The generation after which each migration took place.
    pub migrations: Vec<usize>,
}

/// An island at the end of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct FinalIsland {
    /// Its crossover operator.
    pub crossover: Crossover,
    /// What it was doing.
    pub state: IslandState,
    /// Its individuals and their costs.
    pub population: Population,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The best candidate found.
    pub x: Vec<f64>,
    /// Its cost; `+inf` where no evaluation gave a finite one.
    pub fun: f64,
    /// Evaluations made, those of an interrupted generation and all linearizations included: what the
    /// budget counts.
    pub nfev: usize,
    /// Linearizations among them.
    pub njev: usize,
    /// Whether a local search polished the islands' bests.
    pub polished: bool,
    /// Generations completed after the initial one.
    pub nit: usize,
    /// Migrations.
    pub migrations: usize,
    /// Why the search ended.
    pub status: Status,
    /// Every generation's record.
    pub history: History,
    /// The islands after the last completed generation.
    pub islands: Vec<FinalIsland>,
}

impl Outcome {
    /// The status in a sentence, and what it does not say: whether bests that agree were found independently.
    pub fn message(&self) -> String {
        let message = self.status.message();
        if self.status != Status::Agreed {
            return message.to_string();
        }
        if self.migrations > 0 {
            return format!("{message} They had exchanged their bests, so not all found it on their own.");
        }
        let how = if self.polished {
            "each was reached by a local search from a random start of its own"
        } else {
            "each island found it on its own"
        };
        format!("{message} They had exchanged nothing yet: {how}.")
    }
}

/// Why a search has no outcome.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Failure<F> {
    /// The problem or the options are unusable.
    #[error(transparent)]
    Input(#[from] Error),
    /// The evaluator failed; its fault as it was.
    #[error("the evaluation of the objective function failed")]
    Evaluation(F),
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Status; 9] = [
        Status::Agreed,
        Status::CostAgreed,
        Status::Stagnated,
        Status::Collapsed,
        Status::MaxEvaluations,
        Status::MaxGenerations,
        Status::TimeLimit,
        Status::Interrupted,
        Status::Callback,
    ];

    #[test]
    fn every_status_says_something_of_its_own() {
        for (i, status) in ALL.iter().enumerate() {
            assert!(status.message().ends_with('.'));
            assert!(ALL[..i].iter().all(|s| s.message() != status.message()));
        }
        let budgets = ALL.iter().filter(|s| s.label() == "budget").count();
        assert_eq!(budgets, 3);
        assert_eq!(ALL.iter().filter(|s| s.success()).count(), 3);
    }

    #[test]
    fn an_agreement_before_any_exchange_is_called_so() {
        let outcome = |status, migrations, polished| Outcome {
            x: vec![0.0],
            fun: 0.0,
            nfev: 1,
            njev: 0,
            polished,
            nit: 0,
            migrations,
            status,
            history: History::default(),
            islands: Vec::new(),
        };
        let early = outcome(Status::Agreed, 0, true).message();
        assert!(early.starts_with(Status::Agreed.message()) && early.contains("local search"));
        assert!(outcome(Status::Agreed, 0, false).message().contains("on its own"));
        let late = outcome(Status::Agreed, 1, true).message();
        assert!(late.starts_with(Status::Agreed.message()) && late.contains("not all"));
        let budget = Status::MaxEvaluations;
        assert_eq!(outcome(budget, 0, true).message(), budget.message());
    }
}
