//! What a parameter of a frame can set: a property of sections, masses and supports, an angle, a length.

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

/// A turn about a node; its terms are the nodes that turn, from [`Frame::downstream`](super::Frame::downstream).
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
