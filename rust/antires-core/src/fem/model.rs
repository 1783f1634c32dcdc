//! A structural model: nominal K and M with their element terms.
//!
//! # chain
//!
//! Masses in a row, joined by springs; optionally a spring to ground at either end.
//!
//! ```text
//! ground --kg0-- m_0 --k_0-- m_1 --k_1-- ... --k_{n-2}-- m_{n-1} --kg1-- ground
//! ```
//!
//! Stiffness terms in order: the n − 1 springs between the masses, the ground spring at the first
//! mass, the ground spring at the last. Mass terms: the masses. Source of the case: Meruane, J. Sound
//! Vib. 332 (2013) 807-820, section 4 (its eight-mass chain is free at both ends).

use std::sync::{Arc, OnceLock};

use faer::{Mat, MatRef};

use super::elements::{between, lump, to_ground};
use super::frame::Frame;
use super::term::{Places, Side, Term};
use crate::error::{Error, Result};
use crate::linalg::sparse::{Pattern, SparseMatrix};

/// Relative asymmetry up to which a matrix counts as symmetric: assembly in another code rounds.
const SYMMETRY: f64 = 1e-9;

/// Row, column and value of an entry.
pub type Entry = (u32, u32, f64);

/// Nominal stiffness and mass with the terms that parameters scale.
#[derive(Debug, Clone)]
pub struct Model {
    /// K and M share a pattern, in which the terms have their places too.
    stiffness: SparseMatrix,
    mass: SparseMatrix,
    stiffness_terms: Vec<Term>,
    mass_terms: Vec<Term>,
    /// Where the entries of the terms are, once asked for.
    places: OnceLock<Arc<[Places; 2]>>,
    /// What the terms are formed from, in models of beams.
    frame: Option<Frame>,
}

impl Model {
    /// Model from dense nominal matrices and the terms contained in them.
    pub fn new(
        stiffness: Mat<f64>,
        mass: Mat<f64>,
        stiffness_terms: Vec<Term>,
        mass_terms: Vec<Term>,
    ) -> Result<Self> {
        let n = stiffness.nrows();
        let (stiffness, mass) =
            (square("stiffness", stiffness.as_ref(), n)?, square("mass", mass.as_ref(), n)?);
        Self::from_entries(n, (&stiffness, &mass), stiffness_terms, mass_terms)
    }

    /// Model of `n` dofs from the entries of K and M, both triangles given, and the terms contained in them.
    /// Entries of one place add up.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a matrix is not finite or not symmetric, when M has a negative diagonal
    /// entry, or when an entry of a matrix or a term lies outside.
    pub fn from_entries(
        n: usize,
        (stiffness, mass): (&[Entry], &[Entry]),
        stiffness_terms: Vec<Term>,
        mass_terms: Vec<Term>,
    ) -> Result<Self> {
        for (name, terms) in [("stiffness_terms", &stiffness_terms), ("mass_terms", &mass_terms)] {
            for (i, term) in terms.iter().enumerate() {
                let outside = |e: &&Entry| e.0 as usize >= n || e.1 as usize >= n;
                if let Some(e) = term.entries().iter().find(outside) {
                    return Err(Error::input(
                        name,
                        format!("an entry at ({}, {}) in term {i}", e.0, e.1),
                        format!("entries inside the {n} x {n} matrix"),
                    )
                    .remedy("A term is a part of the model's own matrix, of the same size."));
                }
            }
        }
        let of_terms = stiffness_terms.iter().chain(&mass_terms);
        let listed = of_terms.flat_map(Term::entries);
        let all = stiffness.iter().chain(mass).chain(listed);
        let pattern = Arc::new(Pattern::new(n, all.map(|e| (e.0, e.1))));
        let matrix = |entries: &[Entry]| {
            let mut matrix = SparseMatrix::new(Arc::clone(&pattern));
            for &(i, j, value) in entries {
                matrix.add(i as usize, j as usize, value);
            }
            matrix
        };
        let (stiffness, mass) = (matrix(stiffness), matrix(mass));
        Self::checked(stiffness, mass, stiffness_terms, mass_terms)
    }

    /// Model from matrices of one pattern, in which the terms have their places.
    pub(super) fn checked(
        stiffness: SparseMatrix,
        mass: SparseMatrix,
        stiffness_terms: Vec<Term>,
        mass_terms: Vec<Term>,
    ) -> Result<Self> {
        check_symmetric("stiffness", &stiffness)?;
        check_symmetric("mass", &mass)?;
        if let Some(i) = (0..mass.n()).find(|&i| mass.diagonal(i) < 0.0) {
            return Err(Error::input(
                "mass",
                format!("{:e} kg on the diagonal at dof {i}", mass.diagonal(i)),
                "no negative mass",
            )
            .remedy("Check its signs, and that stiffness and mass are not exchanged."));
        }
        Ok(Self { stiffness, mass, stiffness_terms, mass_terms, places: OnceLock::new(), frame: None })
    }

    /// Model of a frame.
    pub fn from_frame(frame: Frame) -> Result<Self> {
        let n = frame.dofs().n_free();
        let [stiffness_terms, mass_terms] = [Side::Stiffness, Side::Mass].map(|side| frame.terms(side));
        let mut model = Self::from_entries(n, (&[], &[]), stiffness_terms, mass_terms)?;
        let places = model.places();
        for (matrix, terms, places) in [
            (&mut model.stiffness, &model.stiffness_terms, &places[0]),
            (&mut model.mass, &model.mass_terms, &places[1]),
        ] {
            for (i, term) in terms.iter().enumerate() {
                term.add_to(&mut matrix.values, places.of(i), 1.0);
            }
        }
        check_symmetric("stiffness", &model.stiffness)?;
        check_symmetric("mass", &model.mass)?;
        Ok(Self { frame: Some(frame), ..model })
    }

    /// The frame that this is the model of, if it is one.
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// Number of degrees of freedom.
    pub fn n_dof(&self) -> usize {
        self.stiffness.n()
    }

    /// Nominal stiffness (N/m).
    pub fn stiffness(&self) -> &SparseMatrix {
        &self.stiffness
    }

    /// Nominal mass (kg).
    pub fn mass(&self) -> &SparseMatrix {
        &self.mass
    }

    /// Where the entries of the terms are in the matrices: stiffness terms, mass terms.
    #[must_use]
    pub fn places(&self) -> Arc<[Places; 2]> {
        let places = self.places.get_or_init(|| {
            let pattern = self.stiffness.pattern();
            let of = |terms: &[Term]| Places::new(pattern, terms);
            Arc::new([of(&self.stiffness_terms), of(&self.mass_terms)])
        });
        Arc::clone(places)
    }

    /// Terms of the stiffness, in element order.
    pub fn stiffness_terms(&self) -> &[Term] {
        &self.stiffness_terms
    }

    /// Terms of the mass, in element order.
    pub fn mass_terms(&self) -> &[Term] {
        &self.mass_terms
    }

    /// Checks a dof argument against the model.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when `dof` is not below [`n_dof`](Self::n_dof).
    pub fn check_dof(&self, argument: &str, dof: usize) -> Result<()> {
        if dof < self.n_dof() {
            return Ok(());
        }
        Err(Error::input(argument, format!("dof {dof}"), format!("a dof from 0 to {}", self.n_dof() - 1))
            .remedy("Dofs are counted from 0."))
    }
}

/// Whether every part of the structure has as many of the responses as of the forces: else det H[I, J] is zero. Parts
/// are held together by non-zero entries of K or M.
pub fn joins(stiffness: &SparseMatrix, mass: &SparseMatrix, responses: &[usize], forces: &[usize]) -> bool {
    let pattern = stiffness.pattern();
    let mut seen = vec![false; stiffness.n()];
    let (mut pending, mut missing) = (Vec::new(), responses.len() + forces.len());
    for &i in responses {
        if !std::mem::replace(&mut seen[i], true) {
            pending.push(i);
        }
        let (mut own, mut theirs) = (0, 0);
        while let Some(dof) = pending.pop() {
            own += usize::from(responses.contains(&dof));
            theirs += usize::from(forces.contains(&dof));
            if own + theirs == missing {
                return own == theirs;
            }
            for (at, &other) in pattern.places(dof).zip(pattern.column(dof)) {
                let other = other as usize;
                if !seen[other] && (stiffness.values[at] != 0.0 || mass.values[at] != 0.0) {
                    seen[other] = true;
                    pending.push(other);
                }
            }
        }
        if own != theirs {
            return false;
        }
        missing -= own + theirs;
    }
    true
}

/// The entries of a square matrix of `n` rows that are not zero.
fn square(name: &str, matrix: MatRef<'_, f64>, n: usize) -> Result<Vec<Entry>> {
    if n == 0 || matrix.nrows() != n || matrix.ncols() != n {
        return Err(Error::input(
            name,
            format!("a matrix of shape ({}, {})", matrix.nrows(), matrix.ncols()),
            "a non-empty square matrix, stiffness and mass of one size",
        )
        .remedy("Pass both after the same dofs were removed."));
    }
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let entries = places.map(|(i, j)| (i as u32, j as u32, matrix[(i, j)]));
    Ok(entries.filter(|e| e.2 != 0.0).collect())
}

fn check_symmetric(name: &str, matrix: &SparseMatrix) -> Result<()> {
    let largest = matrix.norm_max();
    for (i, j, value) in matrix.entries() {
        if !value.is_finite() {
            return Err(Error::input(name, format!("{value} at ({i}, {j})"), "finite entries")
                .remedy("Check how the matrix was exported; NaN and infinity cannot be solved."));
        }
        if i <= j {
            continue;
        }
        let mirrored = matrix.get(j, i);
        if (value - mirrored).abs() > SYMMETRY * largest {
            return Err(Error::input(
                name,
                format!("{value:e} at ({i}, {j}) but {mirrored:e} at ({j}, {i})"),
                "a symmetric matrix",
            )
            .remedy("Pass (A + A.T) / 2 if the difference is rounding."));
        }
    }
    Ok(())
}

// ---- chain

/// Builds the chain of `masses_kg` and `springs_n_per_m`.
///
/// # Errors
/// [`Error::InvalidInput`] when there is no mass, a mass or spring is not positive and finite, a
/// ground spring is negative, or the counts do not fit.
pub fn mass_spring_chain(
    masses_kg: &[f64],
    springs_n_per_m: &[f64],
    ground_first_n_per_m: f64,
    ground_last_n_per_m: f64,
) -> Result<Model> {
    let n = masses_kg.len();
    if n == 0 {
        return Err(Error::input("masses_kg", "no mass", "at least one mass")
            .remedy("Give the masses in kg, from the first to the last."));
    }
    if springs_n_per_m.len() + 1 != n {
        return Err(Error::input(
            "springs_n_per_m",
            format!("{} springs", springs_n_per_m.len()),
            format!("{} springs between {n} masses", n - 1),
        )
        .remedy("Springs to ground go to ground_first_n_per_m and ground_last_n_per_m."));
    }
    for (name, unit, values) in [("masses_kg", "kg", masses_kg), ("springs_n_per_m", "N/m", springs_n_per_m)]
    {
        if let Some(i) = values.iter().position(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(Error::input(
                name,
                format!("{} {unit} at index {i}", values[i]),
                "positive, finite values",
            )
            .remedy("Correct the value, or leave that mass or spring out of the chain."));
        }
    }
    for (name, value) in
        [("ground_first_n_per_m", ground_first_n_per_m), ("ground_last_n_per_m", ground_last_n_per_m)]
    {
        if !(value.is_finite() && value >= 0.0) {
            return Err(Error::input(name, format!("{value} N/m"), "a finite value of at least 0")
                .remedy("Leave it at 0 where nothing joins that end to the ground."));
        }
    }
    let mut stiffness_terms: Vec<Term> =
        springs_n_per_m.iter().enumerate().map(|(i, &k)| between(i, i + 1, k)).collect();
    stiffness_terms.push(to_ground(0, ground_first_n_per_m));
    stiffness_terms.push(to_ground(n - 1, ground_last_n_per_m));
    let mass_terms: Vec<Term> = masses_kg.iter().enumerate().map(|(i, &m)| lump(i, m)).collect();
    let entries = |terms: &[Term]| -> Vec<Entry> { terms.iter().flat_map(Term::entries).copied().collect() };
    let (stiffness, mass) = (entries(&stiffness_terms), entries(&mass_terms));
    Model::from_entries(n, (&stiffness, &mass), stiffness_terms, mass_terms)
}
