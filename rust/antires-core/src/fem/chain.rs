//! Masses in a row, joined by springs; optionally a spring to ground at either end.
//!
//! ```text
//! ground --kg0-- m_0 --k_0-- m_1 --k_1-- ... --k_{n-2}-- m_{n-1} --kg1-- ground
//! ```
//!
//! Stiffness terms in order: the n − 1 springs between the masses, the ground spring at the first
//! mass, the ground spring at the last. Mass terms: the masses. Source of the case: Meruane, J. Sound
//! Vib. 332 (2013) 807-820, section 4 (its eight-mass chain is free at both ends).

use super::elements::{lumped, spring};
use super::model::{Entry, Model};
use super::term::Term;
use crate::error::{Error, Result};

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
    for (name, unit, values) in [
        ("masses_kg", "kg", masses_kg),
        ("springs_n_per_m", "N/m", springs_n_per_m),
    ] {
        if let Some(i) = values.iter().position(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(Error::input(
                name,
                format!("{} {unit} at index {i}", values[i]),
                "positive, finite values",
            )
            .remedy("Correct the value, or leave that mass or spring out of the chain."));
        }
    }
    for (name, value) in [
        ("ground_first_n_per_m", ground_first_n_per_m),
        ("ground_last_n_per_m", ground_last_n_per_m),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(
                Error::input(name, format!("{value} N/m"), "a finite value of at least 0")
                    .remedy("Leave it at 0 where nothing joins that end to the ground."),
            );
        }
    }
    let mut stiffness_terms: Vec<Term> = springs_n_per_m
        .iter()
        .enumerate()
        .map(|(i, &k)| spring::between(i, i + 1, k))
        .collect();
    stiffness_terms.push(spring::to_ground(0, ground_first_n_per_m));
    stiffness_terms.push(spring::to_ground(n - 1, ground_last_n_per_m));
    let mass_terms: Vec<Term> = masses_kg
        .iter()
        .enumerate()
        .map(|(i, &m)| lumped::at(i, m))
        .collect();
    let entries =
        |terms: &[Term]| -> Vec<Entry> { terms.iter().flat_map(Term::entries).copied().collect() };
    let (stiffness, mass) = (entries(&stiffness_terms), entries(&mass_terms));
    Model::from_entries(n, (&stiffness, &mass), stiffness_terms, mass_terms)
}
