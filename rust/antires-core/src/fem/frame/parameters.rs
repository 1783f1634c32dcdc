//! What parameters do to a frame: properties of sections, masses and supports, angles, positions and lengths.
//!
//! ```text
//! property   Young's modulus (Pa), density (kg/m³), tube thickness and outer diameter (m) of sections;
//!            mass (kg), inertia (kg·m²) of lumped masses; stiffness (N/m) of springs to ground.
//!            The value p is the new one, or a factor on the old one.
//! angle      a group of beams, and all downstream of its pivot node c, turn by p degrees about an
//!            axis through c: x ← c + R(p) (x − c). The beams are formed again from the coordinates,
//!            so that rigid motions stay free. Angles act in the order of the parameters, each about its
//!            pivot where it then is. Supports and sensors keep their global directions.
//! position   nodes move by p metres along a unit vector n: x ← x + p n.
//! length     beams get longer by the factor p and keep their directions: the far end b of each, seen from
//!            the pivot, moves as its near end a does and by (p − 1) (b − a) more; all downstream moves along.
//! ```

use nalgebra::{Rotation3, Unit, Vector3};

use super::Frame;
use super::dofs::Dimension;
use crate::error::{Argument, Error, Result};
use crate::fem::parameters::{Angle, Parameter, Property, Quantity, Scale};

impl Frame {
    /// The numbers that hold a property of carrier `index`; none when there is no such carrier.
    fn slots(&mut self, property: Property, index: usize) -> Option<&mut [f64]> {
        let parts = &mut self.description;
        let section = parts.sections.get_mut(index);
        let lump = parts.point_masses.get_mut(index);
        let one = match property {
            Property::YoungsModulus => &mut section?.youngs_modulus_pa,
            Property::Density => &mut section?.density_kg_per_m3,
            Property::Thickness => section?.shape.tube_mut()?.1,
            Property::Diameter => section?.shape.tube_mut()?.0,
            Property::Mass => &mut lump?.mass_kg,
            Property::Inertia => {
                let about = &mut lump?.inertia_kg_m2;
                return Some(match parts.dimension {
                    Dimension::Plane => &mut about[2..],
                    Dimension::Space => about,
                });
            }
            Property::SupportStiffness => {
                &mut parts.ground_springs.get_mut(index)?.stiffness_n_per_m
            }
        };
        Some(std::slice::from_mut(one))
    }

    /// The values of a property of carrier `index`, one, or three about the axes; none when there is
    /// no such carrier.
    fn values(&self, property: Property, index: usize) -> Option<Vec<f64>> {
        // A copy, since one table of places is better than two; only set-up calls this.
        self.clone().slots(property, index).map(|s| s.to_vec())
    }

    /// Sets what the frame's own parameters govern; factors on terms are left to the caller.
    pub(super) fn apply(&mut self, parameters: &[Parameter], x: &[f64]) {
        for (parameter, &value) in parameters.iter().zip(x) {
            match &parameter.quantity {
                &Quantity::Property(property, scale) => {
                    for &index in &parameter.terms {
                        for slot in self.slots(property, index).into_iter().flatten() {
                            *slot = match scale {
                                Scale::Value => value,
                                Scale::Factor => *slot * value,
                            };
                        }
                    }
                }
                Quantity::Angle(angle) if value != 0.0 => {
                    self.turn(angle, value.to_radians(), &parameter.terms);
                }
                Quantity::Position(direction) => self.shift(direction, value, &parameter.terms),
                Quantity::Length(way) if value != 1.0 => self.stretch(way, value),
                _ => {}
            }
        }
    }

    fn turn(&mut self, angle: &Angle, radians: f64, nodes: &[usize]) {
        let axis = Unit::new_normalize(Vector3::from(angle.axis));
        let rotation = Rotation3::from_axis_angle(&axis, radians);
        let center = Vector3::from(self.description.nodes_m[angle.pivot]);
        for &node in nodes {
            let x = Vector3::from(self.description.nodes_m[node]) - center;
            self.description.nodes_m[node] = (center + rotation * x).into();
        }
        for (beam, reference) in self.description.beams.iter().zip(&mut self.references) {
            // `nodes` ascends: `downstream` lists them so.
            if beam.nodes.iter().any(|n| nodes.binary_search(n).is_ok()) {
                *reference = (rotation * Vector3::from(*reference)).into();
            }
        }
    }

    /// The frame whose nominal state is this one at parameter values `x`.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a value is impossible, for example a wall thicker than the radius.
    pub fn at(&self, parameters: &[Parameter], x: &[f64]) -> Result<Self> {
        let mut frame = self.clone();
        frame.apply(parameters, x);
        for (parameter, &value) in parameters.iter().zip(x) {
            for &term in &parameter.terms {
                match &parameter.quantity {
                    Quantity::StiffnessReduction => frame.scale_stiffness(term, 1.0 - value),
                    Quantity::StiffnessFactor => frame.scale_stiffness(term, value),
                    Quantity::MassFactor => frame.scale_mass(term, value),
                    _ => {}
                }
            }
        }
        frame.description.check()?;
        Ok(frame)
    }

    fn scale_stiffness(&mut self, term: usize, factor: f64) {
        let parts = &mut self.description;
        let (beams, ground) = (parts.beams.len(), parts.ground_springs.len());
        if term < beams {
            self.stiffness_factors[term] *= factor;
        } else if term < beams + ground {
            parts.ground_springs[term - beams].stiffness_n_per_m *= factor;
        } else {
            parts.node_springs[term - beams - ground].stiffness_n_per_m *= factor;
        }
    }

    fn scale_mass(&mut self, term: usize, factor: f64) {
        let beams = self.description.beams.len();
        if term < beams {
            self.mass_factors[term] *= factor;
            return;
        }
        let lump = &mut self.description.point_masses[term - beams];
        lump.mass_kg *= factor;
        for inertia in &mut lump.inertia_kg_m2 {
            *inertia *= factor;
        }
    }

    /// Checks that a property parameter called `name` governs something of this frame.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for carriers that do not exist or are not used, different nominal
    /// values under one new value, or a factor on zero.
    pub fn check_property(
        &self,
        name: &Argument,
        property: Property,
        scale: Scale,
        indices: &[usize],
    ) -> Result<()> {
        let carrier = property.carrier();
        let mut nominal = Vec::new();
        for &index in indices {
            let Some(values) = self.values(property, index) else {
                let wanted = format!("a {carrier} of the model");
                return Err(
                    Error::input(name, format!("{carrier} {index}"), wanted).remedy(format!(
                        "Each {carrier} is counted from 0, in the order of the model."
                    )),
                );
            };
            nominal.extend(values);
        }
        if scale == Scale::Value && nominal.iter().any(|v| *v != nominal[0]) {
            return Err(Error::input(
                name,
                format!("one new value for the different values {nominal:?}"),
                "nominal values that are equal",
            )
            .remedy("Make the parameter relative: a factor on each of them."));
        }
        if scale == Scale::Factor && nominal.iter().all(|v| *v == 0.0) {
            return Err(Error::input(
                name,
                format!("a factor on the {carrier}(s) {indices:?}, which are zero"),
                "a parameter that changes the model",
            )
            .remedy("Give a nominal value above zero, or leave the parameter out."));
        }
        let beams = &self.description.beams;
        let unused = |index: &usize| match property {
            Property::YoungsModulus
            | Property::Density
            | Property::Thickness
            | Property::Diameter => beams.iter().all(|beam| beam.section != *index),
            Property::Mass | Property::Inertia => self.mass_is_fixed(property, *index),
            Property::SupportStiffness => {
                let spring = &self.description.ground_springs[*index];
                self.dofs.number(spring.node, spring.direction).is_none()
            }
        };
        if indices.iter().all(unused) {
            return Err(Error::input(
                name,
                format!("the {carrier}(s) {indices:?}, which no free part of the model uses"),
                "a parameter that changes the model",
            )
            .remedy("Leave it out, or use it in the model first."));
        }
        Ok(())
    }

    /// Whether all dofs that a lumped mass or inertia acts on are fixed.
    fn mass_is_fixed(&self, property: Property, index: usize) -> bool {
        let node = self.description.point_masses[index].node;
        let dimension = self.description.dimension;
        let translations = dimension.axes();
        let mut directions = match property {
            Property::Mass => 0..translations,
            _ => translations..dimension.per_node(),
        };
        directions.all(|direction| self.dofs.number(node, direction).is_none())
    }

    /// The common nominal value of a property, none for different ones.
    pub fn nominal(&self, property: Property, indices: &[usize]) -> Option<f64> {
        let mut values = Vec::new();
        for &index in indices {
            values.extend(self.values(property, index)?);
        }
        let first = *values.first()?;
        values.iter().all(|v| *v == first).then_some(first)
    }
}
