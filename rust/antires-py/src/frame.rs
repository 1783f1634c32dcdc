//! Frames: their description in, their parts out.

use antires_core::error::{Argument, Result};
use antires_core::fem::frame::Frame as CoreFrame;
use antires_core::fem::frame::elements::{Dimension, Element, FrameDescription, Row};
use antires_core::fem::section::{Section, Shape, Shear};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::doorway::to_python;

/// (shape's name, its dimensions, E, density, Poisson's ratio).
type SectionParts = (String, Vec<f64>, f64, f64, f64);
/// Shear coefficients along y and z; none: rigid in shear; an empty list: Cowper's.
type ShearParts = Option<Vec<f64>>;

/// The description of a frame with its dof numbering.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct Frame {
    pub core: CoreFrame,
}

#[pymethods]
impl Frame {
    /// Nodes (n, 2 or 3); reference directions of the beams (n_beams, 3) or none; sections; elements by the argument
    /// that lists them, as rows of (integers, direction, values); fixed dofs; the shear of each section, or none where
    /// all are rigid.
    #[new]
    #[pyo3(signature = (nodes_m, references, sections, elements, fixed, shear=None))]
    fn new(
        nodes_m: PyReadonlyArray2<'_, f64>,
        references: Option<PyReadonlyArray2<'_, f64>>,
        sections: Vec<SectionParts>,
        elements: Vec<(String, Vec<Row>)>,
        fixed: Vec<(usize, String)>,
        shear: Option<Vec<ShearParts>>,
    ) -> PyResult<Self> {
        let nodes = nodes_m.as_array();
        let columns = nodes.ncols();
        let dimension = if columns == 2 { Dimension::Plane } else { Dimension::Space };
        let shear_of_section = |i: usize| {
            let given = shear.as_ref().and_then(|all| all.get(i).cloned().flatten());
            shear_of(given)
        };
        let coordinates = |axis, row: &[f64]| row.get(axis).copied().unwrap_or(0.0);
        let rows = nodes.rows().into_iter().map(|row| row.to_vec());
        let sections = sections.into_iter().enumerate();
        let mut description = FrameDescription {
            dimension,
            nodes_m: rows.map(|row| std::array::from_fn(|axis| coordinates(axis, &row))).collect(),
            sections: sections.map(|(i, parts)| section(parts, shear_of_section(i))).collect(),
            elements: elements_of(&elements, dimension).map_err(to_python)?,
            fixed: fixed_of(fixed, dimension).map_err(to_python)?,
        };
        if let Some(references) = references {
            let rows = references.as_array();
            for (i, element) in description.elements.iter_mut().enumerate() {
                if let Element::Beam(beam) = element {
                    beam.reference = Some(std::array::from_fn(|axis| rows[(i, axis)]));
                }
            }
        }
        let core = CoreFrame::new(description).map_err(to_python)?;
        Ok(Self { core })
    }

    /// Coordinates (n, 2 or 3) in m.
    fn nodes_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let parts = self.core.description();
        let shape = (parts.nodes_m.len(), parts.dimension.axes());
        Array2::from_shape_fn(shape, |(node, axis)| parts.nodes_m[node][axis]).into_pyarray(py)
    }

    fn sections(&self) -> Vec<SectionParts> {
        let sections = self.core.description().sections.iter();
        sections.map(section_parts).collect()
    }

    /// The elements of one argument, as rows.
    fn elements(&self, argument: &str) -> Vec<Row> {
        let parts = self.core.description();
        parts.listed(argument).map(|element| element.row(parts.dimension)).collect()
    }

    /// Number of the free dof of a node.
    fn dof(&self, node: usize, direction: &str) -> PyResult<usize> {
        self.core.dof(node, direction).map_err(to_python)
    }

    /// Node and direction of each free dof.
    fn dof_names(&self) -> Vec<(usize, &'static str)> {
        let names = self.core.description().dimension.directions();
        (0..self.core.dofs().n_free())
            .map(|dof| {
                let (node, direction) = self.core.dofs().node_and_direction(dof);
                (node, names[direction])
            })
            .collect()
    }

    /// The number of the part that each node belongs to.
    fn parts(&self) -> Vec<usize> {
        self.core.parts()
    }
}

fn elements_of(lists: &[(String, Vec<Row>)], dimension: Dimension) -> Result<Vec<Element>> {
    let each = |(argument, rows): &(String, Vec<Row>)| -> Vec<Result<Element>> {
        let rows = rows.iter().enumerate();
        rows.map(|(i, row)| Element::of_row(argument, i, row, dimension)).collect()
    };
    lists.iter().flat_map(each).collect()
}

fn fixed_of(fixed: Vec<(usize, String)>, dimension: Dimension) -> Result<Vec<(usize, usize)>> {
    let each = |(i, (node, name)): (usize, (usize, String))| {
        Ok((node, dimension.direction(&Argument::from("fixed").item(i), &name)?))
    };
    fixed.into_iter().enumerate().map(each).collect()
}

fn shear_of(parts: ShearParts) -> Shear {
    match parts.as_deref() {
        None => Shear::Rigid,
        Some([]) => Shear::Cowper,
        Some(given) => Shear::Coefficients { y: given[0], z: given.get(1).copied().unwrap_or(f64::NAN) },
    }
}

fn section(parts: SectionParts, shear: Shear) -> Section {
    let (shape, size, youngs_modulus_pa, density_kg_per_m3, poisson) = parts;
    // A size that is missing is NaN, which the core refuses by name.
    let at = |i: usize| size.get(i).copied().unwrap_or(f64::NAN);
    let shape = match shape.as_str() {
        "tube" => Shape::Tube { outer_diameter_m: at(0), thickness_m: at(1) },
        "rectangle" => Shape::Rectangle { width_m: at(0), height_m: at(1) },
        _ => Shape::General { area_m2: at(0), inertia_y_m4: at(1), inertia_z_m4: at(2), torsion_m4: at(3) },
    };
    Section { shape, youngs_modulus_pa, density_kg_per_m3, poisson, shear }
}

fn section_parts(section: &Section) -> SectionParts {
    let (name, size) = match section.shape {
        Shape::Tube { outer_diameter_m, thickness_m } => ("tube", vec![outer_diameter_m, thickness_m]),
        Shape::Rectangle { width_m, height_m } => ("rectangle", vec![width_m, height_m]),
        Shape::General { area_m2, inertia_y_m4, inertia_z_m4, torsion_m4 } => {
            ("general", vec![area_m2, inertia_y_m4, inertia_z_m4, torsion_m4])
        }
    };
    (name.to_owned(), size, section.youngs_modulus_pa, section.density_kg_per_m3, section.poisson)
}
