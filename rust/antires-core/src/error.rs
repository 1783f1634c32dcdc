//! The errors of the core: what was given, what is wanted, and how to get there.
//!
//! Every error about an input has the same four fields and says them in the same order,
//! `argument: got this; wanted that. remedy`. The Python face takes the fields, never the sentence. A
//! run that did not converge is not an error: its outcome says so in a status.

use std::fmt;

/// The result of a fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong in the core.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument cannot be used as it was given.
    #[error("{argument}: got {got}; wanted {wanted}. {remedy}")]
    InvalidInput {
        /// The argument, or the part of it that is wrong.
        argument: Argument,
        /// What was given.
        got: String,
        /// What would have been accepted.
        wanted: String,
        /// What to do about it.
        remedy: String,
    },

    /// A computation on valid input failed.
    #[error("{what} failed: {detail}")]
    Numerical {
        /// The computation.
        what: String,
        /// How it failed.
        detail: String,
    },

    /// There is not enough memory for a computation.
    #[error("{what} needs {bytes} bytes of memory, which are not there")]
    Memory {
        /// The computation.
        what: String,
        /// What it needs.
        bytes: usize,
    },
}

impl Error {
    /// Asks for the memory of so many numbers, and gives it back: what takes it later cannot fail half-way.
    ///
    /// # Errors
    /// [`Error::Memory`] where it is not there.
    pub fn check_memory(what: impl FnOnce() -> String, numbers: usize) -> Result<()> {
        let mut probe: Vec<f64> = Vec::new();
        probe
            .try_reserve_exact(numbers)
            .map_err(|_| Self::Memory { what: what(), bytes: numbers.saturating_mul(size_of::<f64>()) })
    }

    /// An unusable argument, still without what to do about it: [`Refusal::remedy`] makes it an error.
    #[allow(clippy::needless_pass_by_value)] // numbers and literals read better without a `&`
    pub fn input(argument: impl Into<Argument>, got: impl ToString, wanted: impl Into<String>) -> Refusal {
        Refusal { argument: argument.into(), got: got.to_string(), wanted: wanted.into() }
    }
}

/// An error that lacks its remedy; none leaves the crate like that.
#[must_use = "say by `remedy` what to do"]
#[derive(Debug)]
pub struct Refusal {
    argument: Argument,
    got: String,
    wanted: String,
}

impl Refusal {
    /// The error, with what the caller can do.
    pub fn remedy(self, text: impl Into<String>) -> Error {
        let Self { argument, got, wanted } = self;
        Error::InvalidInput { argument, got, wanted, remedy: text.into() }
    }
}

/// An argument by its name, or a part of one: `point_masses[2].inertia_kg_m2`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Argument {
    name: String,
    steps: Vec<Step>,
}

/// A step from an argument to a part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// To an item, by its index.
    Item(usize),
    /// To a field, by its name.
    Field(String),
}

impl Argument {
    /// Item `index` of this argument.
    pub fn item(&self, index: usize) -> Self {
        self.with(Step::Item(index))
    }

    /// A field of this argument.
    pub fn field(&self, name: impl Into<String>) -> Self {
        self.with(Step::Field(name.into()))
    }

    /// The same part of the argument `name`.
    pub fn called(&self, name: impl Into<String>) -> Self {
        Self { name: name.into(), steps: self.steps.clone() }
    }

    /// The argument's own name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The way from the argument to the part that is meant; empty where all of it is.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    fn with(&self, step: Step) -> Self {
        let mut part = self.clone();
        part.steps.push(step);
        part
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        self.steps.iter().try_for_each(|step| match step {
            Step::Item(index) => write!(f, "[{index}]"),
            Step::Field(name) => write!(f, ".{name}"),
        })
    }
}

impl<S: Into<String>> From<S> for Argument {
    fn from(name: S) -> Self {
        Self { name: name.into(), steps: Vec::new() }
    }
}

impl From<&Self> for Argument {
    fn from(argument: &Self) -> Self {
        argument.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_not_there_is_an_error_with_its_size() {
        let all = Error::check_memory(|| "modes".into(), usize::MAX / 16);
        assert!(matches!(all, Err(Error::Memory { bytes, .. }) if bytes > 1 << 59));
        assert_eq!(Error::check_memory(|| "modes".into(), 1000), Ok(()));
    }

    #[test]
    fn a_part_of_an_argument_is_spelt_as_python_spells_it() {
        let part = Argument::from("point_masses").item(2).field("mass_kg");
        assert_eq!(part.to_string(), "point_masses[2].mass_kg");
        assert_eq!(part.name(), "point_masses");
        assert_eq!(part.steps(), [Step::Item(2), Step::Field("mass_kg".into())]);
    }
}
