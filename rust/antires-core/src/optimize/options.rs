//! The knobs of the island genetic algorithm.

use super::crossover::Crossover;
use crate::error::{Error, Result};

/// What the islands' bests must agree in for the search to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreement {
    /// In genes, or in cost over several migrations: a flat valley ends too. The default.
    GenesOrCost,
    /// In genes only, as Meruane (2013) has it.
    Genes,
}

impl Agreement {
    /// `genes-or-cost` or `genes`.
    ///
    /// # Errors
    /// For any other name.
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "genes-or-cost" => Ok(Self::GenesOrCost),
            "genes" => Ok(Self::Genes),
            _ => Err(Error::input("agreement", format!("'{name}'"), "'genes-or-cost' or 'genes'")
                .remedy("Leave it out for 'genes-or-cost'.")),
        }
    }

    /// The name [`Agreement::from_name`] knows it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::GenesOrCost => "genes-or-cost",
            Self::Genes => "genes",
        }
    }
}

/// The settings of a search. [`IslandOptions::default`] is the paper's algorithm, completed where the
/// paper is silent, with stop rules of our own, and polished where the objective allows; `polish: Some(false)`
/// leaves the polish out.
#[derive(Debug, Clone, PartialEq)]
pub struct IslandOptions {
    /// Islands, at least 1. Default 4.
    pub islands: usize,
    /// Individuals per island, at least 4, so that immigrants never displace the best. Default 40.
    pub population: usize,
    /// The islands' crossover operators: island `i` has number `i`, and they repeat in turn. At least
    /// one. Default: arithmetic, heuristic, blend (BLX-0.5), uniform.
    pub crossovers: Vec<Crossover>,
    /// Probability `p_c` that a pair of parents is crossed, else copied; in [0, 1]. Default 0.80.
    pub crossover_probability: f64,
    /// Probability `p_m` that a gene mutates, shared by boundary and uniform mutation; in [0, 1].
    /// Default 0.02.
    pub mutation_probability: f64,
    /// Selection pressure `q`: the probability that selection takes the best of an endless
    /// population; above 0, below 1. Default 0.08.
    pub selection_pressure: f64,
    /// Generations without improvement after which an island waits, at least 1. Default 40.
    pub patience: usize,
    /// A best cost `J` is an improvement on `J0`, the best when the count last began, where
    /// `J0 - J > improvement_tolerance * |J0|`; in [0, 1). Slow gains add up until they count.
    /// With 0, the algorithm as printed, ever smaller gains keep an island from waiting, and so all
    /// from exchanging: on the 15-parameter chain it migrated 1 to 5 times in 200,000 evaluations,
    /// with 1e-4 up to 29 times. Default 1e-4.
    pub improvement_tolerance: f64,
    /// What the islands' bests must agree in. Default: genes or cost.
    pub agreement: Agreement,
    /// Bests agree in genes where every gene differs by at most this fraction of its bounds'
    /// distance, between any two islands; in [0, 1). Default 1e-6.
    pub gene_tolerance: f64,
    /// Bests agree in cost where the largest and the smallest differ by at most this fraction of the
    /// smallest's magnitude, plus `cost_floor`; in [0, 1). Default 1e-6.
    pub cost_tolerance: f64,
    /// The absolute part of the agreement in cost, for costs that go to zero; finite, not negative,
    /// in the unit of the cost. Default 1e-12.
    pub cost_floor: f64,
    /// Successive migrations at which the costs must agree, at least 1. Default 3.
    pub cost_migrations: usize,
    /// Whether a local search [polishes](super::polish) the objective's starting point and, when they meet,
    /// the islands' bests: never for `Some(false)`; always for `Some(true)`, without derivatives where need be; for `None` where the objective tells how it is composed.
    /// Default `None`.
    pub polish: Option<bool>,
    /// Generations after which the bests are polished, even if not all islands wait; at least 1. Default
    /// 10.
    pub polish_interval: usize,
    /// Evaluations after which the polish of one point begins nothing new; at least 1. Default 1000.
    pub polish_evaluations: usize,
    /// Budget of evaluations, at least 1; never exceeded. Default 200,000.
    pub max_evaluations: usize,
    /// Budget of generations after the initial one; none by default.
    pub max_generations: Option<usize>,
}

impl Default for IslandOptions {
    fn default() -> Self {
        Self {
            islands: 4,
            population: 40,
            crossovers: Crossover::PAPER.to_vec(),
            crossover_probability: 0.80,
            mutation_probability: 0.02,
            selection_pressure: 0.08,
            patience: 40,
            improvement_tolerance: 1e-4,
            agreement: Agreement::GenesOrCost,
            gene_tolerance: 1e-6,
            cost_tolerance: 1e-6,
            cost_floor: 1e-12,
            cost_migrations: 3,
            polish: None,
            polish_interval: 10,
            polish_evaluations: 1000,
            max_evaluations: 200_000,
            max_generations: None,
        }
    }
}

impl IslandOptions {
    /// Checks every setting against its range.
    ///
    /// # Errors
    /// For the first that is out of range, by name.
    pub fn validate(&self) -> Result<()> {
        let counts = [
            ("islands", self.islands, 1),
            ("population", self.population, 4),
            ("patience", self.patience, 1),
            ("cost_migrations", self.cost_migrations, 1),
            ("polish_interval", self.polish_interval, 1),
            ("polish_evaluations", self.polish_evaluations, 1),
            ("max_evaluations", self.max_evaluations, 1),
        ];
        for (name, got, least) in counts {
            if got < least {
                return Err(Error::input(name, got, format!("at least {least}"))
                    .remedy("Leave it out for the default."));
            }
        }
        let probabilities = [
            ("crossover_probability", self.crossover_probability),
            ("mutation_probability", self.mutation_probability),
        ];
        for (name, got) in probabilities {
            if !(0.0..=1.0).contains(&got) {
                return Err(Error::input(name, got, "a value in [0, 1]")
                    .remedy("It is a probability; leave it out for the default."));
            }
        }
        let tolerances = [
            ("improvement_tolerance", self.improvement_tolerance),
            ("gene_tolerance", self.gene_tolerance),
            ("cost_tolerance", self.cost_tolerance),
        ];
        for (name, got) in tolerances {
            if !(0.0..1.0).contains(&got) {
                return Err(Error::input(name, got, "a value in [0, 1)")
                    .remedy("It is relative; leave it out for the default."));
            }
        }
        let q = self.selection_pressure;
        if !(q > 0.0 && q < 1.0) {
            return Err(Error::input("selection_pressure", q, "a value in (0, 1)")
                .remedy("It is the chance of the best to be drawn; leave it out for the default."));
        }
        if !(self.cost_floor >= 0.0 && self.cost_floor.is_finite()) {
            return Err(Error::input("cost_floor", self.cost_floor, "a finite value of at least 0")
                .remedy("It is a cost below which the search is done; leave it out for the default."));
        }
        // Streams are split by island and memory by individual: refuse what cannot be meant.
        if self.islands.saturating_mul(self.population) > MAX_INDIVIDUALS {
            return Err(Error::input(
                "islands",
                format!("{} islands of {}", self.islands, self.population),
                format!("at most {MAX_INDIVIDUALS} individuals in all"),
            )
            .remedy("Lower islands or population."));
        }
        if self.crossovers.is_empty() {
            return Err(Error::input("crossovers", "none", "at least one operator")
                .remedy("Leave it out for one of each."));
        }
        self.crossovers.iter().try_for_each(Crossover::validate)
    }
}

/// The most individuals a search may have.
const MAX_INDIVIDUALS: usize = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid() {
        assert_eq!(IslandOptions::default().validate(), Ok(()));
    }

    #[test]
    fn every_setting_out_of_range_is_refused_by_name() {
        type Spoil = fn(&mut IslandOptions);
        let cases: [(&str, Spoil); 23] = [
            ("islands", |o| o.islands = 0),
            ("islands", |o| o.islands = usize::MAX),
            ("population", |o| o.population = 3),
            ("patience", |o| o.patience = 0),
            ("cost_migrations", |o| o.cost_migrations = 0),
            ("polish_interval", |o| o.polish_interval = 0),
            ("polish_evaluations", |o| o.polish_evaluations = 0),
            ("max_evaluations", |o| o.max_evaluations = 0),
            ("crossover_probability", |o| o.crossover_probability = 1.1),
            ("crossover_probability", |o| {
                o.crossover_probability = f64::NAN;
            }),
            ("mutation_probability", |o| o.mutation_probability = -0.1),
            ("selection_pressure", |o| o.selection_pressure = 0.0),
            ("selection_pressure", |o| o.selection_pressure = 1.0),
            ("selection_pressure", |o| o.selection_pressure = f64::NAN),
            ("improvement_tolerance", |o| o.improvement_tolerance = 1.0),
            ("gene_tolerance", |o| o.gene_tolerance = -1e-9),
            ("cost_tolerance", |o| o.cost_tolerance = f64::NAN),
            ("cost_floor", |o| o.cost_floor = f64::INFINITY),
            ("cost_floor", |o| o.cost_floor = -1.0),
            ("crossovers", |o| o.crossovers.clear()),
            ("crossovers", |o| o.crossovers = vec![Crossover::Heuristic { tries: 0 }]),
            ("crossovers", |o| o.crossovers = vec![Crossover::Blend { alpha: f64::NAN }]),
            ("crossovers", |o| o.crossovers = vec![Crossover::Blend { alpha: -0.1 }]),
        ];
        for (name, spoil) in cases {
            let mut options = IslandOptions::default();
            spoil(&mut options);
            let Err(Error::InvalidInput { argument, .. }) = options.validate() else {
                panic!("{name} was not refused");
            };
            assert_eq!(argument.name(), name);
        }
    }

    #[test]
    fn agreements_have_names() {
        for agreement in [Agreement::Genes, Agreement::GenesOrCost] {
            assert_eq!(Agreement::from_name(agreement.name()), Ok(agreement));
        }
        assert!(Agreement::from_name("costs").is_err());
    }
}
