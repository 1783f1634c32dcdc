//! Frames: their description in, their parts out.

use antires_core::error::Argument;
use antires_core::fem::frame::Frame as CoreFrame;
use antires_core::fem::frame::description::{
    Beam, FrameDescription, GroundSpring, NodeSpring, PointMass,
};
use antires_core::fem::frame::dofs::Dimension;
use antires_core::fem::section::{Section, Shape, Shear};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::doorway::to_python;

/// (shape's name, its dimensions, E, density, Poisson's ratio).
type SectionParts = (String, Vec<f64>, f64, f64, f64);
/// Shear coefficients along y and z; none: rigid in shear; an empty list: Cowper's.
type ShearParts = Option<Vec<f64>>;
/// (node, mass, inertia about x, y, z).
type PointMassParts = (usize, f64, [f64; 3]);
/// (node, direction, stiffness).
type GroundSpringParts = (usize, String, f64);
/// (node, node, direction or none, stiffness).
type NodeSpringParts = (usize, usize, Option<String>, f64);

/// The description of a frame with its dof numbering.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct Frame {
    pub core: CoreFrame,
}

#[pymethods]
impl Frame {
    /// Nodes (n, 2 or 3); elements (node, node, section); references (n_elements, 3) or none; the shear of
    /// each section, or none where all are rigid.
    #[new]
    #[pyo3(signature = (nodes_m, elements, references, sections, point_masses, ground_springs, node_springs, fixed, shear=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        nodes_m: PyReadonlyArray2<'_, f64>,
        elements: Vec<(usize, usize, usize)>,
        references: Option<PyReadonlyArray2<'_, f64>>,
        sections: Vec<SectionParts>,
        point_masses: Vec<PointMassParts>,
        ground_springs: Vec<GroundSpringParts>,
        node_springs: Vec<NodeSpringParts>,
        fixed: Vec<(usize, String)>,
        shear: Option<Vec<ShearParts>>,
    ) -> PyResult<Self> {
        let nodes = nodes_m.as_array();
        let columns = nodes.ncols();
        let dimension = if columns == 2 {
            Dimension::Plane
        } else {
            Dimension::Space
        };
        let beams = elements.iter().enumerate().map(|(i, &(a, b, section))| {
            let reference = references.as_ref().map(|rows| {
                let rows = rows.as_array();
                std::array::from_fn(|axis| rows[(i, axis)])
            });
            Beam {
                nodes: [a, b],
                section,
                reference,
            }
        });
        let at = |argument: &str, i: usize, name: &str| {
            dimension
                .direction(&Argument::from(argument).item(i), name)
                .map_err(to_python)
        };
        let description = FrameDescription {
            dimension,
            nodes_m: nodes
                .rows()
                .into_iter()
                .map(|row| std::array::from_fn(|axis| if axis < columns { row[axis] } else { 0.0 }))
                .collect(),
            beams: beams.collect(),
            sections: sections
                .into_iter()
                .enumerate()
                .map(|(i, parts)| {
                    let given = shear.as_ref().and_then(|all| all.get(i).cloned().flatten());
                    section(parts, shear_of(given))
                })
                .collect(),
            point_masses: point_masses
                .into_iter()
                .map(|(node, mass_kg, inertia_kg_m2)| PointMass {
                    node,
                    mass_kg,
                    inertia_kg_m2,
                })
                .collect(),
            ground_springs: ground_springs
                .into_iter()
                .enumerate()
                .map(|(i, (node, direction, stiffness_n_per_m))| {
                    Ok(GroundSpring {
                        node,
                        direction: at("ground_springs", i, &direction)?,
                        stiffness_n_per_m,
                    })
                })
                .collect::<PyResult<_>>()?,
            node_springs: node_springs
                .into_iter()
                .enumerate()
                .map(|(i, (a, b, direction, stiffness_n_per_m))| {
                    let direction = direction.map(|d| at("node_springs", i, &d)).transpose()?;
                    Ok(NodeSpring {
                        nodes: [a, b],
                        direction,
                        stiffness_n_per_m,
                    })
                })
                .collect::<PyResult<_>>()?,
            fixed: fixed
                .into_iter()
                .enumerate()
                .map(|(i, (node, direction))| Ok((node, at("fixed", i, &direction)?)))
                .collect::<PyResult<_>>()?,
        };
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

    fn point_masses(&self) -> Vec<PointMassParts> {
        let masses = self.core.description().point_masses.iter();
        masses
            .map(|m| (m.node, m.mass_kg, m.inertia_kg_m2))
            .collect()
    }

    fn ground_springs(&self) -> Vec<GroundSpringParts> {
        let parts = self.core.description();
        let name = |direction: usize| parts.dimension.directions()[direction].to_owned();
        let springs = parts.ground_springs.iter();
        springs
            .map(|s| (s.node, name(s.direction), s.stiffness_n_per_m))
            .collect()
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

fn shear_of(parts: ShearParts) -> Shear {
    match parts.as_deref() {
        None => Shear::Rigid,
        Some([]) => Shear::Cowper,
        Some(given) => Shear::Coefficients {
            y: given[0],
            z: given.get(1).copied().unwrap_or(f64::NAN),
        },
    }
}

fn section(parts: SectionParts, shear: Shear) -> Section {
    let (shape, size, youngs_modulus_pa, density_kg_per_m3, poisson) = parts;
    // A size that is missing is NaN, which the core refuses by name.
    let at = |i: usize| size.get(i).copied().unwrap_or(f64::NAN);
    let shape = match shape.as_str() {
        "tube" => Shape::Tube {
            outer_diameter_m: at(0),
            thickness_m: at(1),
        },
        "rectangle" => Shape::Rectangle {
            width_m: at(0),
            height_m: at(1),
        },
        _ => Shape::General {
            area_m2: at(0),
            inertia_y_m4: at(1),
            inertia_z_m4: at(2),
            torsion_m4: at(3),
        },
    };
    Section {
        shape,
        youngs_modulus_pa,
        density_kg_per_m3,
        poisson,
        shear,
    }
}

fn section_parts(section: &Section) -> SectionParts {
    let (name, size) = match section.shape {
        Shape::Tube {
            outer_diameter_m,
            thickness_m,
        } => ("tube", vec![outer_diameter_m, thickness_m]),
        Shape::Rectangle { width_m, height_m } => ("rectangle", vec![width_m, height_m]),
        Shape::General {
            area_m2,
            inertia_y_m4,
            inertia_z_m4,
            torsion_m4,
        } => (
            "general",
            vec![area_m2, inertia_y_m4, inertia_z_m4, torsion_m4],
        ),
    };
    (
        name.to_owned(),
        size,
        section.youngs_modulus_pa,
        section.density_kg_per_m3,
        section.poisson,
    )
}
