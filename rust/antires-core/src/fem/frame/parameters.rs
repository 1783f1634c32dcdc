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
use super::elements::norm;
use crate::error::{Argument, Error, Result};
use crate::fem::parameters::{Angle, Parameter, Property, Quantity, Reach, Scale};
use crate::fem::term::{Places, Side, Term};
use crate::linalg::sparse::SparseMatrix;

/// What must be left of a beam's length while a node moves.
const LEFT: f64 = 0.01;

impl Frame {
    /// The values of a property of carrier `index`, one, or three about the axes; none when there is
    /// no such carrier.
    fn values(&self, property: Property, index: usize) -> Option<Vec<f64>> {
        // A copy, since one table of places is better than two; only set-up calls this.
        self.description.clone().slots(property, index).map(|s| s.to_vec())
    }

    /// Sets what the frame's own parameters govern; factors on terms are left to the caller.
    fn apply(&mut self, parameters: &[Parameter], x: &[f64]) {
        for (parameter, &value) in parameters.iter().zip(x) {
            match &parameter.quantity {
                &Quantity::Property(property, scale) => {
                    for &index in &parameter.terms {
                        for slot in self.description.slots(property, index).into_iter().flatten() {
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
        for (beam, reference) in self.description.beams().zip(&mut self.references) {
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
            for (nth, &term) in parameter.terms.iter().enumerate() {
                if let Some((side, factor, _)) = parameter.quantity.factor(nth, value) {
                    frame.description.scale(frame.terms[side as usize][term], side, factor);
                }
            }
        }
        frame.description.check()?;
        Ok(frame)
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
                return Err(Error::input(name, format!("{carrier} {index}"), wanted)
                    .remedy(format!("Each {carrier} is counted from 0, in the order of the model.")));
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
        let unused = |index: &usize| self.description.is_unused(property, *index, &self.dofs);
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

    /// The common nominal value of a property, none for different ones.
    pub fn nominal(&self, property: Property, indices: &[usize]) -> Option<f64> {
        let mut values = Vec::new();
        for &index in indices {
            values.extend(self.values(property, index)?);
        }
        let first = *values.first()?;
        values.iter().all(|v| *v == first).then_some(first)
    }

    /// The nodes that move when the beams `group` get longer while the node `pivot` stays, each with the node
    /// it is reached from.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for what [`Frame::downstream`] refuses, a group that is not reached from the
    /// pivot, or one that lies in a loop, which cannot close when only some of its beams get longer.
    pub fn reach(&self, group: &[usize], pivot: usize) -> Result<Vec<Reach>> {
        let moving = self.downstream(group, pivot)?;
        let parts = self.description();
        let joined = parts.joined().map(|(i, nodes)| (nodes, group.contains(&i)));
        let mut edges: Vec<([usize; 2], bool)> = joined.collect();
        edges.retain(|(nodes, _)| nodes.iter().all(|n| *n == pivot || moving.binary_search(n).is_ok()));
        // Nodes of one carrier move alike. The carrier of a far end is itself.
        let mut carrier: Vec<Option<usize>> = vec![None; parts.nodes_m.len()];
        carrier[pivot] = Some(pivot);
        let mut way: Vec<Reach> = Vec::new();
        let mut stretching = vec![false; edges.len()];
        let mut pending = vec![pivot];
        while let Some(from) = pending.pop() {
            for (edge, (nodes, stretched)) in edges.iter().enumerate() {
                if !nodes.contains(&from) {
                    continue;
                }
                let node = nodes[usize::from(nodes[0] == from)];
                if carrier[node].is_none() {
                    carrier[node] = if *stretched { Some(node) } else { carrier[from] };
                    stretching[edge] = *stretched;
                    way.push(Reach { node, from, stretched: *stretched });
                    pending.push(node);
                }
            }
        }
        for (edge, ([a, b], stretched)) in edges.iter().enumerate() {
            if *stretched != stretching[edge] || (!stretched && carrier[*a] != carrier[*b]) {
                return Err(Error::input(
                    "elements",
                    format!("a group in a loop, which nodes {a} and {b} close"),
                    "elements outside loops, all reached from the pivot",
                )
                .remedy("Move nodes by position instead, so that all members of the loop follow."));
            }
        }
        Ok(way)
    }

    fn shift(&mut self, direction: &[f64; 3], distance_m: f64, nodes: &[usize]) {
        for &node in nodes {
            for (x, n) in self.description.nodes_m[node].iter_mut().zip(direction) {
                *x += distance_m * n;
            }
        }
    }

    fn stretch(&mut self, way: &[Reach], factor: f64) {
        let before = self.description.nodes_m.clone();
        for step in way {
            let now = self.description.nodes_m[step.from];
            let [near, far] = [step.from, step.node].map(|node| before[node]);
            let factor = if step.stretched { factor } else { 1.0 };
            self.description.nodes_m[step.node] =
                std::array::from_fn(|i| now[i] + factor * (far[i] - near[i]));
        }
    }

    /// Length of the shortest beam (m).
    pub fn shortest_m(&self) -> f64 {
        let parts = self.description();
        let lengths = parts.beams().map(|beam| parts.place().length_m(beam.nodes));
        lengths.fold(f64::INFINITY, f64::min)
    }

    /// Checks that no beam shrinks to nothing while `nodes` move by `low` to `high` metres.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] naming the first beam that does.
    pub fn check_way(&self, direction: [f64; 3], nodes: &[usize], low: f64, high: f64) -> Result<()> {
        let parts = self.description();
        for (i, beam) in parts.beams().enumerate() {
            let [first, last] = beam.nodes.map(|node| nodes.contains(&node));
            if first == last {
                continue;
            }
            let along = parts.place().vector_m(beam.nodes);
            let sign = if last { 1.0 } else { -1.0 };
            // Where the moving end is nearest to the other.
            let towards: f64 = (0..3).map(|axis| sign * direction[axis] * along[axis]).sum();
            let at = (-towards).clamp(low, high);
            let left = norm(std::array::from_fn(|axis| along[axis] + sign * at * direction[axis]));
            if left < LEFT * norm(along) {
                return Err(Error::input(
                    Argument::from("elements").item(i),
                    format!("an element of length {left:e} m at a shift of {at} m"),
                    "at least a hundredth of its own length",
                )
                .remedy("Narrow the bounds of the position."));
            }
        }
        Ok(())
    }

    /// The frame with its own parameters at `x`; factors on terms are left to the caller.
    pub fn formed(&self, parameters: &[Parameter], x: &[f64]) -> Self {
        let mut frame = self.clone();
        frame.apply(parameters, x);
        frame
    }

    /// Indices of the terms of one matrix in which this frame differs from `other`, formed from the same one.
    pub fn terms_unlike<'a>(&'a self, other: &'a Self, side: Side) -> impl Iterator<Item = usize> + 'a {
        (0..self.terms[side as usize].len()).filter(move |&t| self.differs(other, side, t))
    }

    /// Brings back what [`Frame::apply`] can change.
    fn reset_to(&mut self, nominal: &Self) {
        let (now, then) = (&mut self.description, &nominal.description);
        now.nodes_m.clone_from(&then.nodes_m);
        now.sections.clone_from(&then.sections);
        now.elements.clone_from(&then.elements);
        self.references.clone_from(&nominal.references);
    }
}

/// One nominal matrix, its terms and their places in it.
#[derive(Clone, Copy)]
pub struct Nominal<'a> {
    /// K or M.
    pub matrix: &'a SparseMatrix,
    /// What it is the sum of.
    pub terms: &'a [Term],
    /// Places of their entries.
    pub places: &'a Places,
}

/// A frame at a parameter vector, with its terms; the memory is reused from one vector to the next.
///
/// K and M are summed anew from all terms in their order. So they depend on the parameter vector alone, not on
/// the one before, and are those of a model built with these values.
#[derive(Debug, Clone)]
pub struct Reform {
    working: Frame,
    stiffness: Terms,
    mass: Terms,
}

/// Terms of one matrix as they are now.
#[derive(Debug, Clone, Default)]
struct Terms {
    /// Empty as long as none was formed again.
    now: Vec<Term>,
    altered: Vec<bool>,
    /// Whether the matrix differs from the nominal one.
    matrix_altered: bool,
}

impl Reform {
    /// The nominal state of `frame`.
    pub fn new(frame: &Frame) -> Self {
        Self { working: frame.clone(), stiffness: Terms::default(), mass: Terms::default() }
    }

    /// Forms both matrices at `x`: (nominal, factors on its terms, matrix) for stiffness and mass.
    pub fn form(
        &mut self,
        nominal: &Frame,
        parameters: &[Parameter],
        x: &[f64],
        [stiffness, mass]: [(Nominal<'_>, &Vec<f64>, &mut SparseMatrix); 2],
    ) {
        if parameters.iter().any(|p| p.quantity.forms_anew()) {
            self.working.reset_to(nominal);
            self.working.apply(parameters, x);
            let working = &self.working;
            self.stiffness.refresh(stiffness.0.terms, [working, nominal], Side::Stiffness);
            self.mass.refresh(mass.0.terms, [working, nominal], Side::Mass);
        }
        self.stiffness.sum(stiffness.0, stiffness.1, stiffness.2);
        self.mass.sum(mass.0, mass.1, mass.2);
    }
}

impl Terms {
    fn refresh(&mut self, nominal: &[Term], [working, before]: [&Frame; 2], side: Side) {
        if self.now.is_empty() {
            self.now = nominal.to_vec();
            self.altered = vec![false; nominal.len()];
        }
        for (i, (term, altered)) in self.now.iter_mut().zip(&mut self.altered).enumerate() {
            if working.differs(before, side, i) {
                working.form(side, i, term);
                *altered = true;
            } else if *altered {
                term.copy_from(&nominal[i]);
                *altered = false;
            }
        }
    }

    fn sum(&mut self, nominal: Nominal<'_>, factors: &[f64], matrix: &mut SparseMatrix) {
        let altered = self.altered.contains(&true) || factors.iter().any(|f| *f != 1.0);
        if !altered && !self.matrix_altered {
            return;
        }
        self.matrix_altered = altered;
        let terms = if self.now.is_empty() { nominal.terms } else { &self.now };
        matrix.values.fill(0.0);
        for (t, (term, &factor)) in terms.iter().zip(factors).enumerate() {
            term.add_to(&mut matrix.values, nominal.places.of(t), factor);
        }
    }
}
