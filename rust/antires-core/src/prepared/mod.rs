//! Damage judged from tables: the antiresonances of a model over the severity of each element, prepared before
//! the test, and the values of the test.
//!
//! With u = −ln(1 − β), between the levels of the tables and for several elements,
//!
//! ```text
//! ln r(u) = ln r(0) + Σ_e [ln r(u_e) − ln r(0)] + Σ_{a<b} I_ab(u_a, u_b)
//! ```
//!
//! with I from the slopes of one element at the severity of the other. The likelihood is that of the package's
//! `damage`: values and roots are associated, a Gaussian for each of a few errors of prediction is told, and the
//! evidence of a set of elements is an integral over a box of u.

pub mod evidence;
pub mod look;
pub mod nearest;
pub mod tables;
