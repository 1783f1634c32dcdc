//! A test: its values, their errors, and what roots without values cost.

use super::factor::SIDE;

/// Probabilities that a root is found which the other state showed, or did not; of a false value.
const FOUND: f64 = 0.97;
const FOUND_ONCE: f64 = 0.5;
const FALSE: f64 = 0.01;
/// Over so much of ln f from the edges of the band a root is ever more surely found; least width of the band.
const EDGE: f64 = 0.06;
const LEAST_BAND: f64 = 0.1;
/// An error of predictions (multiple of the change), a multiple of the standard deviations, and a probability.
pub type Error = [f64; 3];

/// Values of a test, ascending within each response of each set.
#[derive(Clone, Copy, Debug)]
pub struct Test<'a> {
    /// Response of each.
    pub response: &'a [i64],
    /// ln f.
    pub log_f: &'a [f64],
    /// Relative standard deviations.
    pub std: &'a [f64],
    /// Number of the set, ascending.
    pub set: &'a [i64],
    /// By response: in how many sets it was measured.
    pub times: &'a [f64],
    /// The band, ln f.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Standard deviation of what moves all values alike.
    pub common: f64,
    /// At most [`SIDE`].
    pub errors: &'a [Error],
}

impl Test<'_> {
    /// In how many sets a response was measured.
    #[must_use]
    pub fn measured(&self, response: i64) -> f64 {
        let nth = usize::try_from(response).unwrap_or(usize::MAX);
        self.times.get(nth).copied().unwrap_or(0.0)
    }

    /// Whether all arrays have their lengths.
    #[must_use]
    pub fn consistent(&self) -> bool {
        let m = self.response.len();
        [self.log_f.len(), self.std.len(), self.set.len()] == [m; 3]
            && !self.errors.is_empty()
            && self.errors.len() <= SIDE
    }

    /// Price of a value without a root.
    #[must_use]
    pub fn alone(&self) -> f64 {
        -(FALSE / (self.high - self.low).max(LEAST_BAND)).ln()
    }

    /// Prices of a root that is missed, and of one that is found.
    #[must_use]
    pub fn prices(&self, place: f64, seen: bool) -> (f64, f64) {
        let found: f64 = if seen { FOUND } else { FOUND_ONCE };
        let inside = ((place - self.low).min(self.high - place) / EDGE).clamp(0.0, 1.0);
        (-inside * (1.0 - found).ln(), -inside * found.ln())
    }
}
