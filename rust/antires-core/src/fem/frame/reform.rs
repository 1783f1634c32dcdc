//! K and M of a frame at a parameter vector: only the terms that changed are formed again.

use super::Frame;
use crate::fem::parameters::Parameter;
use crate::fem::term::{Places, Term};
use crate::linalg::sparse::SparseMatrix;

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
        Self {
            working: frame.clone(),
            stiffness: Terms::default(),
            mass: Terms::default(),
        }
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
            self.stiffness.refresh(
                stiffness.0.terms,
                |i| working.stiffness_changed(nominal, i),
                |i, term| working.form_stiffness(i, term),
            );
            self.mass.refresh(
                mass.0.terms,
                |i| working.mass_changed(nominal, i),
                |i, term| working.form_mass(i, term),
            );
        }
        self.stiffness.sum(stiffness.0, stiffness.1, stiffness.2);
        self.mass.sum(mass.0, mass.1, mass.2);
    }
}

impl Terms {
    fn refresh(
        &mut self,
        nominal: &[Term],
        changed: impl Fn(usize) -> bool,
        form: impl Fn(usize, &mut Term),
    ) {
        if self.now.is_empty() {
            self.now = nominal.to_vec();
            self.altered = vec![false; nominal.len()];
        }
        for (i, (term, altered)) in self.now.iter_mut().zip(&mut self.altered).enumerate() {
            if changed(i) {
                form(i, term);
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
        let terms = if self.now.is_empty() {
            nominal.terms
        } else {
            &self.now
        };
        matrix.values.fill(0.0);
        for (t, (term, &factor)) in terms.iter().zip(factors).enumerate() {
            term.add_to(&mut matrix.values, nominal.places.of(t), factor);
        }
    }
}

impl Frame {
    /// The frame with its own parameters at `x`; factors on terms are left to the caller.
    pub fn formed(&self, parameters: &[Parameter], x: &[f64]) -> Self {
        let mut frame = self.clone();
        frame.apply(parameters, x);
        frame
    }

    /// Indices of the stiffness terms in which this frame differs from `other`, formed from the same one.
    pub fn stiffness_terms_unlike<'a>(
        &'a self,
        other: &'a Self,
    ) -> impl Iterator<Item = usize> + 'a {
        (0..self.n_stiffness_terms()).filter(|&t| self.stiffness_changed(other, t))
    }

    /// Indices of the mass terms in which this frame differs from `other`, formed from the same one.
    pub fn mass_terms_unlike<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = usize> + 'a {
        (0..self.n_mass_terms()).filter(|&t| self.mass_changed(other, t))
    }

    /// Brings back what [`Frame::apply`] can change.
    fn reset_to(&mut self, nominal: &Self) {
        let (now, then) = (&mut self.description, &nominal.description);
        now.nodes_m.clone_from(&then.nodes_m);
        now.sections.clone_from(&then.sections);
        now.point_masses.clone_from(&then.point_masses);
        now.ground_springs.clone_from(&then.ground_springs);
        self.references.clone_from(&nominal.references);
    }

    fn stiffness_changed(&self, nominal: &Self, index: usize) -> bool {
        let (now, then) = (&self.description, &nominal.description);
        let Some(after_beams) = index.checked_sub(now.beams.len()) else {
            return self.beam_changed(nominal, index);
        };
        match after_beams.checked_sub(now.ground_springs.len()) {
            None => now.ground_springs[after_beams] != then.ground_springs[after_beams],
            Some(after_ground) => self.moved(nominal, now.node_springs[after_ground].nodes),
        }
    }

    fn mass_changed(&self, nominal: &Self, index: usize) -> bool {
        let (now, then) = (&self.description, &nominal.description);
        match index.checked_sub(now.beams.len()) {
            None => self.beam_changed(nominal, index),
            Some(lump) => now.point_masses[lump] != then.point_masses[lump],
        }
    }

    fn beam_changed(&self, nominal: &Self, index: usize) -> bool {
        let (now, then) = (&self.description, &nominal.description);
        let beam = &now.beams[index];
        now.sections[beam.section] != then.sections[beam.section]
            || self.moved(nominal, beam.nodes)
            // A turn about a beam's own axis moves no node.
            || self.references[index] != nominal.references[index]
    }

    fn moved(&self, nominal: &Self, nodes: [usize; 2]) -> bool {
        let (now, then) = (&self.description.nodes_m, &nominal.description.nodes_m);
        nodes.iter().any(|&node| now[node] != then[node])
    }
}
