//! One element a file: its matrix as data, its formula beside it.

pub mod lumped;
pub mod spring;
