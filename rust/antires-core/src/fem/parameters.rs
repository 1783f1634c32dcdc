//! Updating parameters: how a value p scales the terms it governs.
//!
//! ```text
//! stiffness reduction   s = 1 − β      0 <= β <= 1   (damage)
//! stiffness factor      s = p          p > 0
//! mass factor           s = p          p > 0
//! value of a group      s = (p / p0)^k p > 0      k for each of its terms, of stiffness and mass
//! ```
//!
//! Several parameters on one term multiply. A [`Property`], an angle, position or length of a frame acts on
//! what the terms are formed from, see [`frame`](super::frame); all kinds mix.

use super::term::Side;

/// What a parameter value means.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// Stiffness loss β of the terms: s = 1 − β.
    StiffnessReduction,
    /// Factor on the stiffness of the terms.
    StiffnessFactor,
    /// Factor on the mass of the terms.
    MassFactor,
    /// Value of groups, from the nominal one: whether each term is of the mass, and its power.
    GroupValue(f64, Vec<(bool, i32)>),
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
    pub fn forms_anew(&self) -> bool {
        matches!(self, Self::Property(..) | Self::Angle(_) | Self::Position(_) | Self::Length(_))
    }

    /// Matrix of the `nth` term, its factor at a value and the slope of that; none where terms themselves change.
    pub(super) fn factor(&self, nth: usize, value: f64) -> Option<(Side, f64, f64)> {
        match self {
            Self::StiffnessReduction => Some((Side::Stiffness, 1.0 - value, -1.0)),
            Self::StiffnessFactor => Some((Side::Stiffness, value, 1.0)),
            Self::MassFactor => Some((Side::Mass, value, 1.0)),
            Self::GroupValue(nominal, terms) => {
                let ((mass, power), s) = (terms[nth], value / nominal);
                let side = if mass { Side::Mass } else { Side::Stiffness };
                Some((side, s.powi(power), f64::from(power) * s.powi(power - 1) / nominal))
            }
            _ => None,
        }
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

// ---- property

/// A property that a parameter can set; its terms are indices of sections, lumped masses or springs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// Young's modulus of sections (Pa).
    YoungsModulus,
    /// Density of sections (kg/m³).
    Density,
    /// Wall of tubes (m).
    Thickness,
    /// Outer diameter of tubes (m).
    Diameter,
    /// Mass of lumped masses (kg).
    Mass,
    /// Inertia of lumped masses (kg·m²); in space about all three axes.
    Inertia,
    /// Stiffness of springs to ground (N/m).
    SupportStiffness,
}

/// How a value is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The new value.
    Value,
    /// A factor on the nominal value.
    Factor,
}

/// A turn about a node; its terms are the nodes that turn, from [`Frame::downstream`](crate::fem::frame::Frame::downstream).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    /// The node that stays.
    pub pivot: usize,
    /// Axis of the turn; z in the plane.
    pub axis: [f64; 3],
}

/// One node that moves when beams get longer, in the order in which they are reached from the pivot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reach {
    /// The node.
    pub node: usize,
    /// The node it is reached from, whose shift it shares.
    pub from: usize,
    /// Whether a beam that gets longer lies between the two.
    pub stretched: bool,
}

impl Property {
    /// Whether sections carry it, where elements carry the others.
    pub(super) fn is_of_sections(self) -> bool {
        matches!(self, Self::YoungsModulus | Self::Density | Self::Thickness | Self::Diameter)
    }

    /// What a term of it is.
    pub(super) fn carrier(self) -> &'static str {
        match self {
            Self::YoungsModulus | Self::Density => "section",
            Self::Thickness | Self::Diameter => "tube section",
            Self::Mass | Self::Inertia => "point mass",
            Self::SupportStiffness => "ground spring",
        }
    }
}
