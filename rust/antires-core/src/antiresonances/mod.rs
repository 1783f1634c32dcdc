//! Antiresonances of H_ik: the positive real x = ω² with det(K_ik − x M_ik) = 0.
//!
//! K_ik and M_ik are K and M without row i and column k. That determinant is ± det(K − xM) H_ik(x), so its roots
//! are the zeros of the receptance
//!
//! ```text
//! H_ik(x) = Σ_r φ_ir φ_kr / (λ_r − x) + d
//! ```
//!
//! and those on which a pole cancels. Hence two routes that must agree:
//!
//! - The **modal route** takes one symmetric eigenproblem for all responses and brackets the zeros of
//!   each receptance between its poles ([`secular`]). It is what the optimizer runs.
//! - The **pencil route** deletes row i and column k and solves the general eigenproblem by QZ
//!   ([`crate::linalg::pencil`]). It is the reference, but for roots far below the norm of the matrices: those
//!   that the modal series isolates and Newton's method confirms on the matrices are joined to it.
//!
//! Of r responses I and r forces J the minor det H[I, J] takes the place of H_ik: its zeros, *antiresonances of order
//! r*, are the roots of det(K − xM) without rows I and columns J. It has partial fractions of the same form
//! ([`crate::modal::minor`]), so both routes serve it.
//!
//! Both leave out, by default, the roots that cancel against a pole
//! ([`Receptance`](crate::modal::receptance::Receptance)), since no frequency response shows them. Dropped by
//! both: roots that are infinite, negative, complex, or zero at working precision (the tolerances of
//! [`crate::linalg::pencil`]).
//!
//! | module | what it knows |
//! |---|---|
//! | [`of_model`] | the antiresonances of a model, with bounds of their errors |
//! | [`solver`] | K and M handed over once; both routes |
//! | `search` | the modal route for one response, divided where rounding disturbs |
//! | [`secular`] | the zeros between the poles, isolated by proof, each to the last digits |
//! | [`bounds`] | bounds of f, f' and f'' over a cell, cheap ones and narrow ones, and beyond the last pole |
//! | `far` | roots far above the last pole of a structure with massless dofs |
//! | `placement` | a root on the matrices themselves |
//! | [`sensitivities`] | how a zero moves with the model |
//!
//! May use: `modal`, `fem`, `linalg`.
//!
//! Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021; W. D'Ambrogio &
//! A. Fregolent, The use of antiresonances for robust model updating, J. Sound Vib. 236 (2000) 227-243.

mod bounds;
mod far;
mod of_model;
mod placement;
mod search;
mod secular;
mod sensitivities;
mod solver;

pub use crate::modal::minor::{Ends, MOST_FORCES};
pub use of_model::{antiresonances, bounded_antiresonances};
pub use sensitivities::{ZeroBatch, ZeroSensitivity};
pub use solver::{AntiresonanceSolver, Antiresonances, Prepared, Query, Route, Transfer};
