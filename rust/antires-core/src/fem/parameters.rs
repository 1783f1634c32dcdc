//! Updating parameters: how a value p scales the terms it governs.
//!
//! ```text
//! stiffness reduction   s = 1 − β      0 <= β <= 1   (damage)
//! stiffness factor      s = p          p > 0
//! mass factor           s = p          p > 0
//! ```
//!
//! Several parameters on one term multiply. A [`Property`], an angle, position or length of a frame acts on
//! what the terms are formed from, see [`frame`](super::frame); all kinds mix.

use super::frame::property::{Angle, Property, Reach, Scale};

/// What a parameter value means.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// Stiffness loss β of the terms: s = 1 − β.
    StiffnessReduction,
    /// Factor on the stiffness of the terms.
    StiffnessFactor,
    /// Factor on the mass of the terms.
    MassFactor,
    /// A property of sections, lumped masses or supports of a frame.
    Property(Property, Scale),
    /// Angle (degrees) of what lies downstream of a node of a frame.
    Angle(Angle),
    /// Shift (m) of nodes of a frame along this unit vector.
    Position([f64; 3]),
    /// Factor on the length of beams of a frame, whose far ends and all downstream move along.
    Length(Vec<Reach>),
}

impl Quantity {
    /// Whether terms of a frame are formed anew, where others scale the terms that there are.
    #[must_use]
    pub fn forms_anew(&self) -> bool {
        matches!(
            self,
            Self::Property(..) | Self::Angle(_) | Self::Position(_) | Self::Length(_)
        )
    }
}

/// One scalar unknown and the terms it governs.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// What the value means.
    pub quantity: Quantity,
    /// Indices of the stiffness (or mass) terms; of the sections, lumped masses or springs of a
    /// [`Property`]; of the nodes that turn by an [`Angle`], or move with a position or length.
    pub terms: Vec<usize>,
}
