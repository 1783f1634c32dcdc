//! What is asked for, and what comes back.

use crate::error::{Error, Result};
use crate::modal::structure::MOST_DENSE;

/// How the roots are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// Zeros of the modal series.
    Modal,
    /// Generalized eigenvalues of the deleted pencil.
    Pencil,
}

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Query {
    /// The route.
    pub route: Route,
    /// Highest frequency (Hz), infinity for all.
    pub f_max_hz: f64,
    /// Whether roots that cancel against a pole are returned too.
    pub include_cancelled: bool,
}

impl Query {
    /// Refuses what no memory and patience serve: all roots of a large model cost n² memory and n³ time, and QZ 25
    /// times that.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] without a limit, and for the pencil route.
    pub fn check_large(&self, n: usize) -> Result<()> {
        if self.route == Route::Pencil {
            return Err(Error::input(
                "method",
                format!("'pencil' for {n} dofs"),
                format!("at most {MOST_DENSE} dofs for QZ, whose time grows with their cube"),
            )
            .remedy("Leave it out: 'modal' proves its roots."));
        }
        if self.f_max_hz.is_infinite() {
            return Err(Error::input(
                "f_max_hz",
                format!("no limit for {n} dofs"),
                format!("a limit in Hz for more than {MOST_DENSE} dofs: all roots need all modes"),
            )
            .remedy(
                "Give the highest frequency that matters; time and memory go with the modes below it.",
            ));
        }
        Ok(())
    }
}

/// Antiresonances of one response.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Antiresonances {
    /// Frequencies (Hz), ascending.
    pub freq_hz: Vec<f64>,
    /// How far each may be from that of the matrices as given, infinite for one that is not certain; empty if it
    /// was not asked for.
    pub error_hz: Vec<f64>,
    /// True when H_ik is identically zero: response and excitation are not connected.
    pub identically_zero: bool,
    /// True when rounding leaves a doubt about their number that only the dense solvers could settle.
    pub doubtful: bool,
}

/// Whether there is anything to be zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transfer {
    /// H_ik is not zero everywhere.
    Present,
    /// H_ik is identically zero at working precision.
    IdenticallyZero,
}
