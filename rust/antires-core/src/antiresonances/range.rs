//! Bounds of a value, and what they tell of its sign.

/// Multiple of its rounding error below which a value is drowned in it.
const DROWNED: f64 = 4.0;

/// A sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Below zero.
    Negative,
    /// Above zero.
    Positive,
}

impl Sign {
    /// −1 or 1.
    pub fn unit(self) -> f64 {
        match self {
            Self::Negative => -1.0,
            Self::Positive => 1.0,
        }
    }
}

/// Lower and upper bounds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// All within `spread` of `centre`.
    pub fn about(centre: f64, spread: f64) -> Self {
        Self {
            low: centre - spread,
            high: centre + spread,
        }
    }

    /// Adds a term that ranges from `nearest` away from zero, to infinity.
    pub(super) fn add_beyond(&mut self, nearest: f64) {
        if nearest > 0.0 {
            self.low += nearest;
            self.high = f64::INFINITY;
        } else {
            self.high += nearest;
            self.low = f64::NEG_INFINITY;
        }
    }

    /// The one sign of all values, when zero is excluded by more than `pad`.
    pub fn sign(self, pad: f64) -> Option<Sign> {
        if self.low > pad {
            Some(Sign::Positive)
        } else if self.high < -pad {
            Some(Sign::Negative)
        } else {
            None
        }
    }

    /// Whether all values are drowned in a rounding error of `noise`.
    pub fn is_drowned(self, noise: f64) -> bool {
        self.magnitude() <= DROWNED * noise
    }

    /// Whether some value is not.
    pub fn stands_out(self, noise: f64) -> bool {
        self.magnitude() > DROWNED * noise
    }

    /// Lower bound.
    pub fn low(self) -> f64 {
        self.low
    }

    /// Upper bound.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Largest modulus in the range.
    fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}
