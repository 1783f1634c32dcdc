//! # antires-core
//!
//! Antiresonances of vibrating structures, and what they tell about the structure.
#![forbid(unsafe_code)]

pub mod error;
pub mod fem;
pub mod linalg;
pub mod modal;
pub mod optimize;
pub mod rational;
pub mod rng;
pub mod update;
