//! Crossover: two parents, two children; one kind per island.
//!
//! Each island searches with an operator of its own, in turn over the list of the options, so the
//! islands differ in how they explore and profit from what the others found. All operators keep
//! the children inside the bounds.
//!
//! V. Meruane, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.

mod arithmetic;
mod blend;
mod heuristic;
mod uniform;

use super::bounds::Bounds;
use crate::error::{Error, Result};
use crate::rng::Rng;

/// A crossover operator and its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crossover {
    /// Complementary weighted means of the parents.
    Arithmetic,
    /// A step from the worse parent through the better one, else copies.
    Heuristic {
        /// How often a step is drawn in search of one inside the bounds; at least 1, default 3.
        tries: usize,
    },
    /// BLX-alpha: every gene uniform over the parents' interval, extended.
    Blend {
        /// The extension at either end, in interval lengths; in [0, 10], default 0.5.
        alpha: f64,
    },
    /// Every gene from either parent.
    Uniform,
}

impl Crossover {
    /// The paper's four, in the order its islands use them.
    pub const ALL: [Self; 4] = [
        Self::Arithmetic,
        Self::Heuristic { tries: 3 },
        Self::Blend { alpha: 0.5 },
        Self::Uniform,
    ];

    /// The operator of that name, with default settings.
    ///
    /// # Errors
    /// If there is none; the message lists the names.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| {
                let names = Self::ALL
                    .map(|kind| format!("'{}'", kind.name()))
                    .join(", ");
                Error::input("crossovers", format!("'{name}'"), format!("one of {names}"))
                    .remedy("Leave it out for one of each.")
            })
    }

    /// The operator's name: `arithmetic`, `heuristic`, `blend` or `uniform`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Arithmetic => "arithmetic",
            Self::Heuristic { .. } => "heuristic",
            Self::Blend { .. } => "blend",
            Self::Uniform => "uniform",
        }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// If one is out of its range.
    pub fn validate(&self) -> Result<()> {
        match *self {
            Self::Heuristic { tries: 0 } => {
                Err(
                    Error::input("crossovers", "'heuristic' with 0 tries", "at least 1 try")
                        .remedy("The original takes 3."),
                )
            }
            Self::Blend { alpha } if !(0.0..=10.0).contains(&alpha) => Err(Error::input(
                "crossovers",
                format!("'blend' with alpha {alpha}"),
                "alpha in [0, 10]",
            )
            .remedy("BLX-0.5 has 0.5.")),
            _ => Ok(()),
        }
    }

    /// Writes the children of two parents, of which `better` has the lower cost.
    pub(super) fn cross(
        &self,
        better: &[f64],
        worse: &[f64],
        bounds: &Bounds,
        rng: &mut Rng,
        first: &mut [f64],
        second: &mut [f64],
    ) {
        match *self {
            Self::Arithmetic => arithmetic::cross(better, worse, bounds, rng, first, second),
            Self::Heuristic { tries } => {
                heuristic::cross(better, worse, tries, bounds, rng, first, second);
            }
            Self::Blend { alpha } => {
                blend::cross(better, worse, alpha, bounds, rng, first);
                blend::cross(better, worse, alpha, bounds, rng, second);
            }
            Self::Uniform => uniform::cross(better, worse, rng, first, second),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{prop, prop_assert, prop_assert_eq, proptest};

    use super::*;

    #[test]
    fn names_lead_back_to_their_operators() {
        for kind in Crossover::ALL {
            assert_eq!(Crossover::from_name(kind.name()), Ok(kind));
        }
        assert_eq!(
            Crossover::from_name("twopoint").unwrap_err().to_string(),
            "crossovers: got 'twopoint'; wanted one of 'arithmetic', 'heuristic', 'blend', 'uniform'. \
             Leave it out for one of each."
        );
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        assert!(Crossover::Heuristic { tries: 0 }.validate().is_err());
        for alpha in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(Crossover::Blend { alpha }.validate().is_err(), "{alpha}");
        }
        assert!(Crossover::ALL.iter().all(|kind| kind.validate().is_ok()));
    }

    proptest! {
        #[test]
        fn children_stay_inside_the_bounds(
            genes in prop::collection::vec((-1e3..1e3_f64, 0.0..1e3_f64, 0.0..=1.0_f64, 0.0..=1.0_f64), 1..12),
            kind in 0..4_usize,
            seed: u64,
        ) {
            let lower: Vec<f64> = genes.iter().map(|g| g.0).collect();
            let upper: Vec<f64> = genes.iter().map(|g| g.0 + g.1).collect();
            let bounds = Bounds::new(lower, upper).unwrap();
            let mut a: Vec<f64> = genes.iter().map(|g| g.0 + g.1 * g.2).collect();
            let mut b: Vec<f64> = genes.iter().map(|g| g.0 + g.1 * g.3).collect();
            bounds.clip(&mut a);
            bounds.clip(&mut b);
            let (mut c, mut d) = (vec![0.0; a.len()], vec![0.0; a.len()]);
            let mut rng = Rng::new(seed, 0);
            for _ in 0..20 {
                Crossover::ALL[kind].cross(&a, &b, &bounds, &mut rng, &mut c, &mut d);
                prop_assert!(bounds.contain(&c) && bounds.contain(&d), "{c:?} {d:?}");
            }
        }

        #[test]
        fn equal_parents_have_equal_children(
            x in prop::collection::vec(-5.0..5.0_f64, 1..12),
            kind in 0..4_usize,
            seed: u64,
        ) {
            let bounds = Bounds::uniform(x.len(), -5.0, 5.0).unwrap();
            let (mut c, mut d) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            let mut rng = Rng::new(seed, 0);
            Crossover::ALL[kind].cross(&x, &x, &bounds, &mut rng, &mut c, &mut d);
            prop_assert_eq!(&c, &x);
            prop_assert_eq!(&d, &x);
        }
    }
}
