//! The errors of the core: what was given, what is wanted, and how to get there.
//!
//! Every message about an input follows one pattern, `argument: got this; wanted that. remedy`, so
//! that the Python face can pass it on unchanged. A run that did not converge is not an error: its
//! outcome says so in a status.

/// The result of a fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong in the core.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument cannot be used as it was given.
    #[error("{argument}: got {got}; wanted {wanted}.{}", spaced(remedy))]
    InvalidInput {
        /// The argument's name, with an index where it has one: `bounds[3]`.
        argument: String,
        /// What was given.
        got: String,
        /// What would have been accepted.
        wanted: String,
        /// What to do about it; may be empty.
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
}

impl Error {
    /// An unusable argument, without a remedy.
    #[must_use]
    #[allow(clippy::needless_pass_by_value)] // numbers and literals read better without a `&`
    pub fn input(
        argument: impl Into<String>,
        got: impl ToString,
        wanted: impl Into<String>,
    ) -> Self {
        Self::InvalidInput {
            argument: argument.into(),
            got: got.to_string(),
            wanted: wanted.into(),
            remedy: String::new(),
        }
    }

    /// The same error with a remedy, where it is one of input; any other error is left as it is.
    #[must_use]
    pub fn remedy(mut self, text: impl Into<String>) -> Self {
        if let Self::InvalidInput { remedy, .. } = &mut self {
            *remedy = text.into();
        }
        self
    }
}

/// The remedy with the space that separates it from the sentence before, or nothing.
fn spaced(remedy: &str) -> String {
    if remedy.is_empty() {
        String::new()
    } else {
        format!(" {remedy}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_says_got_wanted_and_remedy_without_a_trailing_space() {
        let plain = Error::input("islands", 0, "at least 1");
        assert_eq!(plain.to_string(), "islands: got 0; wanted at least 1.");
        let helped = plain.remedy("Leave it out for 4.");
        assert_eq!(
            helped.to_string(),
            "islands: got 0; wanted at least 1. Leave it out for 4."
        );
    }

    #[test]
    fn a_remedy_leaves_other_errors_alone() {
        let error = Error::Numerical {
            what: "the eigenproblem".into(),
            detail: "no convergence".into(),
        };
        assert_eq!(error.clone().remedy("Count again."), error);
    }
}
