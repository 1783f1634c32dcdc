//! K(p) and M(p) of a model at a parameter vector.
//!
//! ```text
//! K(p) = K + Σ_t (s_t(p) − 1) K_t        M(p) = M + Σ_t (s_t(p) − 1) M_t
//! ```
//!
//! s_t is the product of the factors of all parameters on term t. The terms of a frame are formed again where
//! their sections or coordinates change.
//!
//! # slopes
//!
//! dK/dp and dM/dp of one parameter, as sparse entries.
//!
//! ```text
//! K(p) = K + Σ_t (s_t(p) K_t(p) − K_t)      dK/dp_j = Σ_t (ds_t/dp_j K_t + s_t dK_t/dp_j)
//! ```
//!
//! ds_t/dp_j is the slope of the factor of p_j times the factors of the others. The terms of a frame also depend
//! on sections, masses and coordinates: those are smooth functions in closed form, and a central difference of
//! the few terms concerned has ten digits.

use std::sync::Arc;

use super::frame::{Frame, Nominal, Reform};
use super::model::Model;
use super::parameters::{Parameter, Quantity};
use super::term::{Places, Side, Term};
use crate::error::Result;
use crate::linalg::sparse::SparseMatrix;

/// K and M at a parameter vector, with the memory to form them again.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// K(p) (N/m).
    pub stiffness: SparseMatrix,
    /// M(p) (kg).
    pub mass: SparseMatrix,
    stiffness_factors: Vec<f64>,
    mass_factors: Vec<f64>,
    places: Arc<[Places; 2]>,
    reform: Option<Reform>,
}

impl Assembly {
    /// Assembly of the nominal state.
    pub fn new(model: &Model) -> Self {
        Self {
            stiffness: model.stiffness().clone(),
            mass: model.mass().clone(),
            stiffness_factors: vec![1.0; model.stiffness_terms().len()],
            mass_factors: vec![1.0; model.mass_terms().len()],
            places: model.places(),
            reform: model.frame().map(Reform::new),
        }
    }

    /// Forms K(x) and M(x).
    pub fn form(&mut self, model: &Model, parameters: &[Parameter], x: &[f64]) {
        self.stiffness_factors.fill(1.0);
        self.mass_factors.fill(1.0);
        for (parameter, &value) in parameters.iter().zip(x) {
            for (nth, &term) in parameter.terms.iter().enumerate() {
                match parameter.quantity.factor(nth, value) {
                    Some((Side::Stiffness, factor, _)) => self.stiffness_factors[term] *= factor,
                    Some((Side::Mass, factor, _)) => self.mass_factors[term] *= factor,
                    None => {}
                }
            }
        }
        let [stiffness_places, mass_places] = &*self.places;
        let sides = [
            (
                Nominal {
                    matrix: model.stiffness(),
                    terms: model.stiffness_terms(),
                    places: stiffness_places,
                },
                &self.stiffness_factors,
                &mut self.stiffness,
            ),
            (
                Nominal { matrix: model.mass(), terms: model.mass_terms(), places: mass_places },
                &self.mass_factors,
                &mut self.mass,
            ),
        ];
        if let (Some(reform), Some(frame)) = (&mut self.reform, model.frame()) {
            reform.form(frame, parameters, x, sides);
            return;
        }
        for (nominal, factors, target) in sides {
            target.values.copy_from_slice(&nominal.matrix.values);
            for (t, (term, &s)) in nominal.terms.iter().zip(factors).enumerate() {
                if s != 1.0 {
                    term.add_to(&mut target.values, nominal.places.of(t), s - 1.0);
                }
            }
        }
    }
}

impl Model {
    /// The model whose nominal state is this model at parameter values `x`.
    pub fn at(&self, parameters: &[Parameter], x: &[f64]) -> Result<Self> {
        if let Some(frame) = self.frame() {
            return Self::from_frame(frame.at(parameters, x)?);
        }
        let mut assembly = Assembly::new(self);
        assembly.form(self, parameters, x);
        let scaled = |terms: &[Term], factors: &[f64]| {
            terms
                .iter()
                .zip(factors)
                .map(|(term, f)| {
                    Term::from_entries(term.entries().iter().map(|&(i, j, v)| (i, j, v * f)).collect())
                })
                .collect()
        };
        let (stiffness_terms, mass_terms) = (
            scaled(self.stiffness_terms(), &assembly.stiffness_factors),
            scaled(self.mass_terms(), &assembly.mass_factors),
        );
        Self::checked(assembly.stiffness, assembly.mass, stiffness_terms, mass_terms)
    }
}

// ---- slopes

/// Step of the difference: truncation and rounding are then both near 1e-10.
const STEP: f64 = 1e-5;

/// Step in degrees for angles, that is 1.7e-5 rad.
const STEP_DEG: f64 = 1e-3;

type Entries = Vec<(u32, u32, f64)>;

/// Entries (row, column, value) of dK/dp and dM/dp; entries of one place add up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MatrixSlopes {
    /// dK/dp.
    pub stiffness: Entries,
    /// dM/dp.
    pub mass: Entries,
}

/// The slopes of one model along each of its parameters at one x.
pub struct Slopes<'a> {
    model: &'a Model,
    parameters: &'a [Parameter],
    x: &'a [f64],
    /// The frame as it is at x, factors on terms left out.
    formed: Option<Frame>,
}

impl<'a> Slopes<'a> {
    /// Slopes of `model` at `x`.
    pub fn new(model: &'a Model, parameters: &'a [Parameter], x: &'a [f64]) -> Self {
        Self { model, parameters, x, formed: model.frame().map(|frame| frame.formed(parameters, x)) }
    }

    /// The slopes along parameter `index`.
    pub fn along(&self, index: usize) -> MatrixSlopes {
        let mut slopes = MatrixSlopes::default();
        match self.model.frame() {
            Some(frame) if self.parameters[index].quantity.forms_anew() => {
                self.formed_anew(frame, index, &mut slopes);
            }
            _ => self.scaled(index, &mut slopes),
        }
        slopes
    }

    /// Slope of the factors on the terms of a parameter.
    fn scaled(&self, index: usize, slopes: &mut MatrixSlopes) {
        let parameter = &self.parameters[index];
        for (nth, &t) in parameter.terms.iter().enumerate() {
            let Some((side, _, own)) = parameter.quantity.factor(nth, self.x[index]) else { return };
            let (listed, entries) = match side {
                Side::Stiffness => (self.model.stiffness_terms(), &mut slopes.stiffness),
                Side::Mass => (self.model.mass_terms(), &mut slopes.mass),
            };
            let slope = own * self.factor_on(t, side, Some(index));
            let mut push = |term: &Term| {
                entries.extend(term.entries().iter().map(|&(r, c, v)| (r, c, slope * v)));
            };
            match &self.formed {
                Some(frame) => push(&frame.term(side, t)),
                None => push(&listed[t]),
            }
        }
    }

    /// Slope of the terms themselves along a property, an angle, a position or a length.
    fn formed_anew(&self, frame: &Frame, index: usize, slopes: &mut MatrixSlopes) {
        let step = match self.parameters[index].quantity {
            Quantity::Angle(_) => STEP_DEG,
            Quantity::Position(_) => STEP * frame.shortest_m(),
            _ if self.x[index] == 0.0 => STEP,
            _ => STEP * self.x[index].abs(),
        };
        let at = |offset: f64| {
            let mut x = self.x.to_vec();
            x[index] += offset;
            (frame.formed(self.parameters, &x), x[index])
        };
        let ((above, high), (below, low)) = (at(step), at(-step));
        let difference = |term: &Term, times: f64, into: &mut Entries| {
            let times = times / (high - low);
            into.extend(term.entries().iter().map(|&(r, c, v)| (r, c, times * v)));
        };
        for (side, entries) in [(Side::Stiffness, &mut slopes.stiffness), (Side::Mass, &mut slopes.mass)] {
            for t in above.terms_unlike(&below, side) {
                let times = self.factor_on(t, side, None);
                difference(&above.term(side, t), times, entries);
                difference(&below.term(side, t), -times, entries);
            }
        }
    }

    /// The product of the factors that parameters other than `without` put on term `t`.
    fn factor_on(&self, t: usize, side: Side, without: Option<usize>) -> f64 {
        let mut product = 1.0;
        let others = self.parameters.iter().zip(self.x).enumerate().filter(|(i, _)| without != Some(*i));
        for (_, (parameter, &value)) in others {
            let on = parameter.terms.iter().enumerate().filter(|&(_, &other)| other == t);
            let factors = on.filter_map(|(nth, _)| parameter.quantity.factor(nth, value));
            product *= factors.filter(|each| each.0 == side).map(|each| each.1).product::<f64>();
        }
        product
    }
}
