//! What a frame is made of: nodes with their dofs, sections, and elements of four kinds.
//!
//! ```text
//! plane   u, v            θ about z             named  u v theta
//! space   u, v, w         θx, θy, θz            named  u v w rx ry rz
//! ```
//!
//! Free dofs are numbered node by node in this order, fixed ones left out. A kind of element is a struct, what a frame
//! asks of it (`Part`), and its name in the list of `kinds!`: nothing else in the core knows of it. The formulas are in
//! `fem::elements`.

use nalgebra::Matrix1;

use crate::error::{Argument, Error, Result};
use crate::fem::elements::{along_line, pair, plane_mass, plane_stiffness, space_mass, space_stiffness};
use crate::fem::parameters::Property;
use crate::fem::section::Section;
use crate::fem::term::{Side, Term};

/// Sine of the smallest angle between a beam and its reference direction.
const PARALLEL: f64 = 1e-3;

/// Shortest element, relative to the extent of the frame, that still has a direction.
const SHORTEST: f64 = 1e-9;

/// Whether a frame lies in the plane or in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// In the plane x-y: u, v, θ a node.
    Plane,
    /// In space: six dofs a node.
    Space,
}

impl Dimension {
    /// Names of a node's dofs, in order; a *direction* is an index into them.
    pub fn directions(self) -> &'static [&'static str] {
        match self {
            Self::Plane => &["u", "v", "theta"],
            Self::Space => &["u", "v", "w", "rx", "ry", "rz"],
        }
    }

    /// Dofs of a node.
    pub fn per_node(self) -> usize {
        self.directions().len()
    }

    /// Coordinates of a node: the first directions are translations along them.
    pub fn axes(self) -> usize {
        match self {
            Self::Plane => 2,
            Self::Space => 3,
        }
    }

    /// The direction of a name.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a node has no such dof.
    pub fn direction(self, argument: &Argument, name: &str) -> Result<usize> {
        let names = self.directions();
        names.iter().position(|n| *n == name).ok_or_else(|| {
            Error::input(argument, format!("the direction '{name}'"), format!("one of {}", names.join(", ")))
                .remedy("The letters are those of the node's dofs: translations, then rotations.")
        })
    }
}

/// From node and direction to the number of the free dof, and back.
#[derive(Debug, Clone)]
pub struct DofMap {
    dimension: Dimension,
    numbers: Vec<Option<usize>>,
    slots: Vec<usize>,
}

impl DofMap {
    /// Numbers the dofs of `n_nodes` nodes, `fixed` (node, direction) left out.
    pub fn new(dimension: Dimension, n_nodes: usize, fixed: &[(usize, usize)]) -> Self {
        let per_node = dimension.per_node();
        let mut free = vec![true; n_nodes * per_node];
        for &(node, direction) in fixed {
            free[node * per_node + direction] = false;
        }
        let slots: Vec<usize> = (0..free.len()).filter(|&slot| free[slot]).collect();
        let mut numbers = vec![None; free.len()];
        for (number, &slot) in slots.iter().enumerate() {
            numbers[slot] = Some(number);
        }
        Self { dimension, numbers, slots }
    }

    /// Number of free dofs.
    pub fn n_free(&self) -> usize {
        self.slots.len()
    }

    /// Number of a dof, none when it is fixed.
    pub fn number(&self, node: usize, direction: usize) -> Option<usize> {
        self.numbers[node * self.dimension.per_node() + direction]
    }

    /// Node and direction of the free dof `number`.
    pub fn node_and_direction(&self, number: usize) -> (usize, usize) {
        let slot = self.slots[number];
        let per_node = self.dimension.per_node();
        (slot / per_node, slot % per_node)
    }

    /// Numbers of the first `N` dofs of a node.
    fn of_node<const N: usize>(&self, node: usize) -> [Option<usize>; N] {
        std::array::from_fn(|direction| self.number(node, direction))
    }

    /// Numbers of `COUNT` dofs of each of two nodes, `COUNT` · 2 = `N`, from the first direction on.
    fn pair<const N: usize>(&self, nodes: [usize; 2]) -> [Option<usize>; N] {
        let half = N / 2;
        std::array::from_fn(|i| self.number(nodes[i / half], i % half))
    }
}

// ---- what all kinds answer

/// Where elements are: the nodes and sections of a frame.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    dimension: Dimension,
    nodes_m: &'a [[f64; 3]],
    sections: &'a [Section],
    /// Length (m) up to which two nodes coincide.
    shortest_m: f64,
}

/// An element as Python has it: its nodes (of a beam also its section), its direction, its values.
pub type Row = (Vec<usize>, Option<String>, Vec<f64>);

/// What a frame asks of an element.
trait Part {
    /// Whether it adds to that matrix.
    fn adds_to(&self, side: Side) -> bool {
        side == Side::Stiffness
    }
    /// As Python has it.
    fn row(&self, dimension: Dimension) -> Row;
    /// Refuses one that cannot be.
    fn check(&self, name: &Argument, place: Place<'_>) -> Result<()>;
    /// Forms its term of one matrix; `up` is the reference direction of a beam.
    fn form(&self, side: Side, place: Place<'_>, dofs: &DofMap, up: [f64; 3], term: &mut Term);
    /// Scales its part of one matrix.
    fn scale(&mut self, side: Side, factor: f64);
    /// The two nodes that it joins, if it does.
    fn joins(&self) -> Option<[usize; 2]> {
        None
    }
    /// The numbers that hold a property, if it has that.
    fn slots(&mut self, _property: Property, _dimension: Dimension) -> Option<&mut [f64]> {
        None
    }
    /// Whether all dofs are fixed on which that property acts.
    fn is_fixed(&self, _property: Property, _dimension: Dimension, _dofs: &DofMap) -> bool {
        false
    }
}

/// The kinds of elements, in the order of the terms and of the checks.
macro_rules! kinds {
    ($($kind:ident),*) => {
        /// An element of any kind.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Element {
            $(#[doc = concat!("See [`", stringify!($kind), "`].")] $kind($kind)),*
        }

        impl Element {
            fn part(&self) -> &dyn Part {
                match self { $(Self::$kind(part) => part),* }
            }

            fn part_mut(&mut self) -> &mut dyn Part {
                match self { $(Self::$kind(part) => part),* }
            }

            /// The element of a row of Python's `argument`, where it is number `i`.
            pub fn of_row(argument: &str, i: usize, row: &Row, dimension: Dimension) -> Result<Self> {
                let name = &Argument::from(argument).item(i);
                match argument {
                    $($kind::ARGUMENT => Ok(Self::$kind($kind::of_row(row, name, dimension)?)),)*
                    _ => Err(Error::input(name, "elements of an unknown kind", [$($kind::ARGUMENT),*].join(", "))
                        .remedy("Correct the name.")),
                }
            }

            /// The argument that lists elements of this kind.
            pub fn argument(&self) -> &'static str {
                match self { $(Self::$kind(_) => $kind::ARGUMENT),* }
            }

            fn rank(&self) -> usize {
                let kinds = [$($kind::ARGUMENT),*];
                kinds.iter().position(|kind| *kind == self.argument()).unwrap_or(kinds.len())
            }
        }

        $(impl From<$kind> for Element {
            fn from(part: $kind) -> Self {
                Self::$kind(part)
            }
        })*
    };
}

kinds!(Beam, PointMass, GroundSpring, NodeSpring);

impl Element {
    /// As Python has it.
    pub fn row(&self, dimension: Dimension) -> Row {
        self.part().row(dimension)
    }
}

impl Place<'_> {
    pub(super) fn vector_m(&self, nodes: [usize; 2]) -> [f64; 3] {
        let [a, b] = nodes.map(|node| self.nodes_m[node]);
        std::array::from_fn(|axis| b[axis] - a[axis])
    }

    pub(super) fn length_m(&self, nodes: [usize; 2]) -> f64 {
        norm(self.vector_m(nodes))
    }

    fn check_pair(&self, name: &Argument, nodes: [usize; 2]) -> Result<()> {
        for node in nodes {
            check_node(name, node, self.nodes_m.len())?;
        }
        if nodes[0] == nodes[1] {
            let got = format!("node {} at both ends", nodes[0]);
            return Err(Error::input(name, got, "two different nodes")
                .remedy("Join it to another node, or leave it out."));
        }
        Ok(())
    }

    fn check_direction(&self, name: &Argument, direction: usize) -> Result<()> {
        if direction < self.dimension.per_node() {
            return Ok(());
        }
        let wanted = format!("a direction from 0 to {}", self.dimension.per_node() - 1);
        Err(Error::input(name, format!("direction {direction}"), wanted)
            .remedy("Directions are counted from 0: translations, then rotations."))
    }
}

/// Refuses a node that a frame of `n` nodes does not have.
pub(in crate::fem) fn check_node(name: &Argument, node: usize, n: usize) -> Result<()> {
    if node < n {
        return Ok(());
    }
    let wanted = format!("a node from 0 to {}", n - 1);
    Err(Error::input(name, format!("node {node}"), wanted)
        .remedy("Nodes are counted from 0, in the order of nodes_m."))
}

fn check_amount(name: &Argument, unit: &str, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(Error::input(name, format!("{value} {unit}"), "a finite value of at least 0")
        .remedy("Leave it out where there is none."))
}

// ---- the kinds

/// A beam between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Its ends.
    pub nodes: [usize; 2],
    /// Index of its section.
    pub section: usize,
    /// Reference direction in space: the local y axis is the part of it across the beam. None: the
    /// global z axis, or the global x axis for beams along z.
    pub reference: Option<[f64; 3]>,
    /// What earlier updates left of its stiffness and mass.
    factors: [f64; 2],
}

impl Beam {
    const ARGUMENT: &'static str = "elements";

    /// A beam with the default reference direction.
    pub fn new(nodes: [usize; 2], section: usize) -> Self {
        Self { nodes, section, reference: None, factors: [1.0; 2] }
    }

    #[expect(clippy::unnecessary_wraps, reason = "a row of some kinds can be wrong")]
    fn of_row((nodes, ..): &Row, _: &Argument, _: Dimension) -> Result<Self> {
        Ok(Self::new([nodes[0], nodes[1]], nodes[2]))
    }
}

impl Part for Beam {
    fn adds_to(&self, _: Side) -> bool {
        true
    }

    fn row(&self, _: Dimension) -> Row {
        let [a, b] = self.nodes;
        (vec![a, b, self.section], None, vec![])
    }

    fn check(&self, name: &Argument, place: Place<'_>) -> Result<()> {
        place.check_pair(name, self.nodes)?;
        if self.section >= place.sections.len() {
            let wanted = format!("a section below {}", place.sections.len());
            return Err(Error::input(name, format!("section {}", self.section), wanted)
                .remedy("Sections are counted from 0, in the order in which they are given."));
        }
        let (along, [a, b]) = (place.vector_m(self.nodes), self.nodes);
        if norm(along) <= place.shortest_m {
            let got = format!("an element of length {:e} m between nodes {a} and {b}", norm(along));
            return Err(Error::input(name, got, "a length above zero")
                .remedy("Join coincident nodes by node_springs, or make them one node."));
        }
        let Some(reference) = self.reference else {
            return Ok(());
        };
        let scale = norm(along) * norm(reference);
        if scale.is_finite() && norm(cross(along, reference)) > PARALLEL * scale {
            return Ok(());
        }
        let got = format!("{reference:?}, along its element");
        Err(Error::input(name.called("orientation"), got, "a direction across the element")
            .remedy("It tells where the section's z axis points; leave it out for the default."))
    }

    fn form(&self, side: Side, place: Place<'_>, dofs: &DofMap, up: [f64; 3], term: &mut Term) {
        let [a, b] = self.nodes.map(|node| place.nodes_m[node]);
        let section = place.sections[self.section].rigidity();
        match place.dimension {
            Dimension::Plane => {
                let (a, b) = ([a[0], a[1]], [b[0], b[1]]);
                let matrix = match side {
                    Side::Stiffness => plane_stiffness(a, b, &section),
                    Side::Mass => plane_mass(a, b, &section),
                };
                term.set_element(&dofs.pair::<6>(self.nodes), &(matrix * self.factors[side as usize]));
            }
            Dimension::Space => {
                let matrix = match side {
                    Side::Stiffness => space_stiffness(a, b, up, &section),
                    Side::Mass => space_mass(a, b, up, &section),
                };
                term.set_element(&dofs.pair::<12>(self.nodes), &(matrix * self.factors[side as usize]));
            }
        }
    }

    fn scale(&mut self, side: Side, factor: f64) {
        self.factors[side as usize] *= factor;
    }

    fn joins(&self) -> Option<[usize; 2]> {
        Some(self.nodes)
    }
}

/// A lumped mass at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass {
    /// The node.
    pub node: usize,
    /// Mass (kg), for all translations.
    pub mass_kg: f64,
    /// Inertia about x, y, z (kg·m²); in the plane only z counts.
    pub inertia_kg_m2: [f64; 3],
}

impl PointMass {
    const ARGUMENT: &'static str = "point_masses";

    #[expect(clippy::unnecessary_wraps, reason = "a row of some kinds can be wrong")]
    fn of_row((nodes, _, values): &Row, _: &Argument, _: Dimension) -> Result<Self> {
        let inertia_kg_m2 = std::array::from_fn(|axis| values[1 + axis]);
        Ok(Self { node: nodes[0], mass_kg: values[0], inertia_kg_m2 })
    }
}

impl Part for PointMass {
    fn adds_to(&self, side: Side) -> bool {
        side == Side::Mass
    }

    fn row(&self, _: Dimension) -> Row {
        let [ix, iy, iz] = self.inertia_kg_m2;
        (vec![self.node], None, vec![self.mass_kg, ix, iy, iz])
    }

    fn check(&self, name: &Argument, place: Place<'_>) -> Result<()> {
        check_node(name, self.node, place.nodes_m.len())?;
        check_amount(name, "kg", self.mass_kg)?;
        let mut inertia = self.inertia_kg_m2.into_iter();
        inertia.try_for_each(|inertia| check_amount(name, "kg·m²", inertia))
    }

    fn form(&self, _: Side, place: Place<'_>, dofs: &DofMap, _: [f64; 3], term: &mut Term) {
        let (m, [ix, iy, iz]) = (self.mass_kg, self.inertia_kg_m2);
        match place.dimension {
            Dimension::Plane => term.set_diagonal(&dofs.of_node(self.node), &[m, m, iz]),
            Dimension::Space => term.set_diagonal(&dofs.of_node(self.node), &[m, m, m, ix, iy, iz]),
        }
    }

    fn scale(&mut self, _: Side, factor: f64) {
        self.mass_kg *= factor;
        self.inertia_kg_m2.iter_mut().for_each(|inertia| *inertia *= factor);
    }

    fn slots(&mut self, property: Property, dimension: Dimension) -> Option<&mut [f64]> {
        match (property, dimension) {
            (Property::Mass, _) => Some(std::slice::from_mut(&mut self.mass_kg)),
            (Property::Inertia, Dimension::Plane) => Some(&mut self.inertia_kg_m2[2..]),
            (Property::Inertia, Dimension::Space) => Some(&mut self.inertia_kg_m2),
            _ => None,
        }
    }

    fn is_fixed(&self, property: Property, dimension: Dimension, dofs: &DofMap) -> bool {
        let translations = dimension.axes();
        let mut directions = match property {
            Property::Mass => 0..translations,
            _ => translations..dimension.per_node(),
        };
        directions.all(|direction| dofs.number(self.node, direction).is_none())
    }
}

/// A spring from one dof to ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundSpring {
    /// The node.
    pub node: usize,
    /// The direction, an index into [`Dimension::directions`].
    pub direction: usize,
    /// Stiffness (N/m, or N·m/rad for a rotation).
    pub stiffness_n_per_m: f64,
}

impl GroundSpring {
    const ARGUMENT: &'static str = "ground_springs";

    fn of_row((nodes, direction, values): &Row, name: &Argument, dimension: Dimension) -> Result<Self> {
        let direction = dimension.direction(name, direction.as_deref().unwrap_or_default())?;
        Ok(Self { node: nodes[0], direction, stiffness_n_per_m: values[0] })
    }
}

impl Part for GroundSpring {
    fn row(&self, dimension: Dimension) -> Row {
        let direction = dimension.directions()[self.direction].to_owned();
        (vec![self.node], Some(direction), vec![self.stiffness_n_per_m])
    }

    fn check(&self, name: &Argument, place: Place<'_>) -> Result<()> {
        check_node(name, self.node, place.nodes_m.len())?;
        place.check_direction(name, self.direction)?;
        check_amount(name, "N/m", self.stiffness_n_per_m)
    }

    fn form(&self, _: Side, _: Place<'_>, dofs: &DofMap, _: [f64; 3], term: &mut Term) {
        let dof = dofs.number(self.node, self.direction);
        term.set_element(&[dof], &Matrix1::new(self.stiffness_n_per_m));
    }

    fn scale(&mut self, _: Side, factor: f64) {
        self.stiffness_n_per_m *= factor;
    }

    fn slots(&mut self, property: Property, _: Dimension) -> Option<&mut [f64]> {
        (property == Property::SupportStiffness).then(|| std::slice::from_mut(&mut self.stiffness_n_per_m))
    }

    fn is_fixed(&self, _: Property, _: Dimension, dofs: &DofMap) -> bool {
        dofs.number(self.node, self.direction).is_none()
    }
}

/// A spring between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeSpring {
    /// The nodes.
    pub nodes: [usize; 2],
    /// The dof whose relative motion it resists; none: along the line between the nodes.
    pub direction: Option<usize>,
    /// Stiffness (N/m, or N·m/rad for a rotation).
    pub stiffness_n_per_m: f64,
}

impl NodeSpring {
    const ARGUMENT: &'static str = "node_springs";

    fn of_row((nodes, direction, values): &Row, name: &Argument, dimension: Dimension) -> Result<Self> {
        let direction = direction.as_deref().map(|d| dimension.direction(name, d)).transpose()?;
        Ok(Self { nodes: [nodes[0], nodes[1]], direction, stiffness_n_per_m: values[0] })
    }
}

impl Part for NodeSpring {
    fn row(&self, dimension: Dimension) -> Row {
        let direction = self.direction.map(|d| dimension.directions()[d].to_owned());
        (self.nodes.to_vec(), direction, vec![self.stiffness_n_per_m])
    }

    fn check(&self, name: &Argument, place: Place<'_>) -> Result<()> {
        place.check_pair(name, self.nodes)?;
        check_amount(name, "N/m", self.stiffness_n_per_m)?;
        let apart = place.length_m(self.nodes) > place.shortest_m;
        let [a, b] = self.nodes;
        match self.direction {
            None if !apart => Err(Error::input(
                name,
                format!("no direction, at the coincident nodes {a} and {b}"),
                "the direction of a spring between coincident nodes",
            )
            .remedy("Say in which direction it acts, such as 'v'.")),
            // It would resist a rotation of the whole structure: a hidden support.
            Some(direction) if apart && direction < place.dimension.axes() => Err(Error::input(
                name,
                format!("a direction, between the nodes {a} and {b} at different places"),
                "no direction, for a spring along the line between them",
            )
            .remedy("Only a spring along that line leaves rigid motions free.")),
            Some(direction) => place.check_direction(name, direction),
            None => Ok(()),
        }
    }

    fn form(&self, _: Side, place: Place<'_>, dofs: &DofMap, _: [f64; 3], term: &mut Term) {
        let k = self.stiffness_n_per_m;
        if let Some(direction) = self.direction {
            let dofs = self.nodes.map(|node| dofs.number(node, direction));
            term.set_element(&dofs, &pair(k));
            return;
        }
        let length = place.length_m(self.nodes);
        let along = place.vector_m(self.nodes).map(|x| x / length);
        match place.dimension {
            Dimension::Plane => {
                term.set_element(&dofs.pair::<4>(self.nodes), &along_line::<4>(&along, k));
            }
            Dimension::Space => {
                term.set_element(&dofs.pair::<6>(self.nodes), &along_line::<6>(&along, k));
            }
        }
    }

    fn scale(&mut self, _: Side, factor: f64) {
        self.stiffness_n_per_m *= factor;
    }

    fn joins(&self) -> Option<[usize; 2]> {
        Some(self.nodes)
    }
}

// ---- the frame

/// Everything a frame is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameDescription {
    /// Plane or space.
    pub dimension: Dimension,
    /// Coordinates (m); z is 0 in the plane.
    pub nodes_m: Vec<[f64; 3]>,
    /// Sections of the beams.
    pub sections: Vec<Section>,
    /// Elements; those of one kind keep their order.
    pub elements: Vec<Element>,
    /// Fixed dofs (node, direction).
    pub fixed: Vec<(usize, usize)>,
}

impl FrameDescription {
    /// Brings the elements into the order of their kinds.
    pub(super) fn sort(&mut self) {
        self.elements.sort_by_key(Element::rank);
    }

    pub(super) fn place(&self) -> Place<'_> {
        Place { dimension: self.dimension, nodes_m: &self.nodes_m, sections: &self.sections, shortest_m: 0.0 }
    }

    /// The elements that one argument lists.
    pub fn listed(&self, argument: &str) -> impl Iterator<Item = &Element> {
        self.elements.iter().filter(move |element| element.argument() == argument)
    }

    /// The beams: the first elements.
    pub fn beams(&self) -> impl Iterator<Item = &Beam> {
        self.elements.iter().map_while(|element| match element {
            Element::Beam(beam) => Some(beam),
            _ => None,
        })
    }

    /// Numbers of the elements that add to one matrix, in the order of its terms.
    pub(super) fn terms(&self, side: Side) -> Vec<usize> {
        let adds = |i: &usize| self.elements[*i].part().adds_to(side);
        (0..self.elements.len()).filter(adds).collect()
    }

    /// The two nodes that each element joins, of those that do, with its number.
    pub(super) fn joined(&self) -> impl Iterator<Item = (usize, [usize; 2])> {
        let all = self.elements.iter().enumerate();
        all.filter_map(|(i, element)| Some((i, element.part().joins()?)))
    }

    /// Forms the term of element `i`; `up` is its reference direction.
    pub(super) fn form(&self, i: usize, side: Side, dofs: &DofMap, up: [f64; 3], term: &mut Term) {
        self.elements[i].part().form(side, self.place(), dofs, up, term);
    }

    /// Scales what element `i` adds to one matrix.
    pub(super) fn scale(&mut self, i: usize, side: Side, factor: f64) {
        self.elements[i].part_mut().scale(side, factor);
    }

    /// The numbers that hold a property of its carrier number `index`; none when there is no such carrier.
    pub(super) fn slots(&mut self, property: Property, index: usize) -> Option<&mut [f64]> {
        let one = match property {
            Property::YoungsModulus => &mut self.sections.get_mut(index)?.youngs_modulus_pa,
            Property::Density => &mut self.sections.get_mut(index)?.density_kg_per_m3,
            Property::Thickness => self.sections.get_mut(index)?.shape.tube_mut()?.1,
            Property::Diameter => self.sections.get_mut(index)?.shape.tube_mut()?.0,
            _ => {
                let carriers = self.elements.iter_mut();
                return carriers
                    .filter_map(|element| element.part_mut().slots(property, self.dimension))
                    .nth(index);
            }
        };
        Some(std::slice::from_mut(one))
    }

    /// Whether no free part uses the carrier number `index` of a property.
    pub(super) fn is_unused(&self, property: Property, index: usize, dofs: &DofMap) -> bool {
        if property.is_of_sections() {
            return self.beams().all(|beam| beam.section != index);
        }
        let mut own = self.clone();
        let mut carriers = own.elements.iter_mut().filter_map(|element| {
            let carries = element.part_mut().slots(property, self.dimension).is_some();
            carries.then(|| element.part().is_fixed(property, self.dimension, dofs))
        });
        carriers.nth(index) == Some(true)
    }

    /// Whether element `i` moves or changes between this description and `then`, of the same elements.
    pub(super) fn differs(&self, then: &Self, i: usize) -> bool {
        let part = self.elements[i].part();
        let moved = |node: usize| self.nodes_m[node] != then.nodes_m[node];
        let reformed = match self.elements[i] {
            Element::Beam(beam) => self.sections[beam.section] != then.sections[beam.section],
            _ => self.elements[i] != then.elements[i],
        };
        reformed || part.joins().is_some_and(|nodes| nodes.into_iter().any(moved))
    }

    /// The reference direction of a beam that has none of its own: z, or x for beams along z.
    pub(super) fn default_reference(&self, nodes: [usize; 2]) -> [f64; 3] {
        let along = self.place().vector_m(nodes);
        let up = [0.0, 0.0, 1.0];
        if norm(cross(along, up)) > PARALLEL * norm(along) { up } else { [1.0, 0.0, 0.0] }
    }

    /// Checks every part; the messages name it as the Python face calls it.
    pub fn check(&self) -> Result<()> {
        let missing = if self.nodes_m.is_empty() {
            Some(("nodes_m", "at least two nodes"))
        } else {
            self.beams().next().is_none().then_some(("elements", "at least one element"))
        };
        if let Some((what, wanted)) = missing {
            return Err(
                Error::input(what, "none", wanted).remedy("A frame is at least one beam between two nodes.")
            );
        }
        for (i, node) in self.nodes_m.iter().enumerate() {
            if let Some(x) = node.iter().find(|x| !x.is_finite()) {
                let name = Argument::from("nodes_m").item(i);
                return Err(Error::input(name, format!("{x} m"), "finite coordinates")
                    .remedy("Correct the coordinates of that node, in m."));
            }
        }
        for (i, section) in self.sections.iter().enumerate() {
            section.check(&Argument::from("sections").item(i))?;
        }
        let place = Place { shortest_m: SHORTEST * self.extent_m(), ..self.place() };
        for kind in self.elements.chunk_by(|a, b| a.rank() == b.rank()) {
            for (i, element) in kind.iter().enumerate() {
                element.part().check(&Argument::from(element.argument()).item(i), place)?;
            }
            if matches!(kind[0], Element::Beam(_)) {
                self.check_joined_once()?;
            }
        }
        for (i, &(node, direction)) in self.fixed.iter().enumerate() {
            let name = Argument::from("fixed").item(i);
            check_node(&name, node, self.nodes_m.len())?;
            place.check_direction(&name, direction)?;
        }
        Ok(())
    }

    /// Largest distance along an axis between two nodes (m).
    fn extent_m(&self) -> f64 {
        let extent = |axis: usize| {
            let along = || self.nodes_m.iter().map(|x| x[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        (0..3).map(extent).fold(0.0, f64::max)
    }

    fn check_joined_once(&self) -> Result<()> {
        let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        let beams = self.beams().enumerate();
        let mut pairs: Vec<_> = beams.map(|(i, beam)| (sorted(beam.nodes), i)).collect();
        pairs.sort_unstable();
        let Some(twice) = pairs.windows(2).find(|pair| pair[0].0 == pair[1].0) else {
            return Ok(());
        };
        let (([a, b], first), again) = (twice[0], twice[1].1);
        Err(Error::input(
            Argument::from("elements").item(again),
            format!("nodes {a} and {b} again, after elements[{first}]"),
            "each pair of nodes joined once",
        )
        .remedy("Describe two beams side by side by one Section with their sums."))
    }
}

pub(super) fn norm(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
