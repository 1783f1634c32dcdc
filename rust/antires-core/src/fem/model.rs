//! A structural model: nominal K and M with their element terms.

use faer::{Mat, MatRef};

use super::frame::{Frame, sum};
use super::term::Term;
use crate::error::{Error, Result};

/// Relative asymmetry up to which a matrix counts as symmetric: assembly in another code rounds.
const SYMMETRY: f64 = 1e-9;

/// Nominal stiffness and mass with the terms that parameters scale.
#[derive(Debug, Clone)]
pub struct Model {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    stiffness_terms: Vec<Term>,
    mass_terms: Vec<Term>,
    /// What the terms are formed from, in models of beams.
    frame: Option<Frame>,
}

impl Model {
    /// Model from nominal matrices and the terms contained in them.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a matrix is empty, not square, not finite or not symmetric, when
    /// M has a negative diagonal entry, or when a term has an entry outside the matrix.
    pub fn new(
        stiffness: Mat<f64>,
        mass: Mat<f64>,
        stiffness_terms: Vec<Term>,
        mass_terms: Vec<Term>,
    ) -> Result<Self> {
        let n = stiffness.nrows();
        check_symmetric("stiffness", stiffness.as_ref(), n)?;
        check_symmetric("mass", mass.as_ref(), n)?;
        if let Some(i) = (0..n).find(|&i| mass[(i, i)] < 0.0) {
            return Err(Error::input(
                "mass",
                format!("{:e} kg on the diagonal at dof {i}", mass[(i, i)]),
                "no negative mass",
            )
            .remedy("Check its signs, and that stiffness and mass are not exchanged."));
        }
        for (name, terms) in [
            ("stiffness_terms", &stiffness_terms),
            ("mass_terms", &mass_terms),
        ] {
            for (i, term) in terms.iter().enumerate() {
                let outside = |e: &&(u32, u32, f64)| e.0 as usize >= n || e.1 as usize >= n;
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
        Ok(Self {
            stiffness,
            mass,
            stiffness_terms,
            mass_terms,
            frame: None,
        })
    }

    /// Model of a frame.
    ///
    /// # Errors
    /// Those of [`Model::new`].
    pub fn from_frame(frame: Frame) -> Result<Self> {
        let n = frame.dofs().n_free();
        let (stiffness_terms, mass_terms) = frame.terms();
        let (stiffness, mass) = (sum(&stiffness_terms, n), sum(&mass_terms, n));
        let model = Self::new(stiffness, mass, stiffness_terms, mass_terms)?;
        Ok(Self {
            frame: Some(frame),
            ..model
        })
    }

    /// The frame that this is the model of, if it is one.
    #[must_use]
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// Number of degrees of freedom.
    #[must_use]
    pub fn n_dof(&self) -> usize {
        self.stiffness.nrows()
    }

    /// Nominal stiffness (N/m).
    #[must_use]
    pub fn stiffness(&self) -> MatRef<'_, f64> {
        self.stiffness.as_ref()
    }

    /// Nominal mass (kg).
    #[must_use]
    pub fn mass(&self) -> MatRef<'_, f64> {
        self.mass.as_ref()
    }

    /// Terms of the stiffness, in element order.
    #[must_use]
    pub fn stiffness_terms(&self) -> &[Term] {
        &self.stiffness_terms
    }

    /// Terms of the mass, in element order.
    #[must_use]
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
        Err(Error::input(
            argument,
            format!("dof {dof}"),
            format!("a zero-based dof in 0..{}", self.n_dof() - 1),
        )
        .remedy("Dofs are counted from 0."))
    }

    /// Whether dofs `i` and `k` are joined by any chain of stiffness or mass entries. If not, H_ik is
    /// identically zero.
    #[must_use]
    pub fn connected(&self, i: usize, k: usize) -> bool {
        connected(self.stiffness(), self.mass(), i, k)
    }
}

/// Whether a path of non-zero entries of K or M joins `i` to `k`.
#[must_use]
pub fn connected(k_mat: MatRef<'_, f64>, m_mat: MatRef<'_, f64>, i: usize, k: usize) -> bool {
    let n = k_mat.nrows();
    let mut seen = vec![false; n];
    let mut pending = vec![i];
    seen[i] = true;
    while let Some(dof) = pending.pop() {
        if dof == k {
            return true;
        }
        for other in 0..n {
            if !seen[other] && (k_mat[(other, dof)] != 0.0 || m_mat[(other, dof)] != 0.0) {
                seen[other] = true;
                pending.push(other);
            }
        }
    }
    false
}

fn check_symmetric(name: &str, matrix: MatRef<'_, f64>, n: usize) -> Result<()> {
    if n == 0 || matrix.nrows() != n || matrix.ncols() != n {
        return Err(Error::input(
            name,
            format!("a matrix of shape ({}, {})", matrix.nrows(), matrix.ncols()),
            "a non-empty square matrix, stiffness and mass of one size",
        )
        .remedy("Pass both after the same dofs were removed."));
    }
    let largest = matrix.norm_max();
    for j in 0..n {
        for i in 0..n {
            let value = matrix[(i, j)];
            if !value.is_finite() {
                return Err(
                    Error::input(name, format!("{value} at ({i}, {j})"), "finite entries").remedy(
                        "Check how the matrix was exported; NaN and infinity cannot be solved.",
                    ),
                );
            }
            if (value - matrix[(j, i)]).abs() > SYMMETRY * largest {
                return Err(Error::input(
                    name,
                    format!(
                        "{value:e} at ({i}, {j}) but {:e} at ({j}, {i})",
                        matrix[(j, i)]
                    ),
                    "a symmetric matrix",
                )
                .remedy("Pass (A + A.T) / 2 if the difference is rounding."));
            }
        }
    }
    Ok(())
}
