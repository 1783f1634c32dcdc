//! The core from outside, in one binary: each further one would be linked to the whole of it again.

mod antiresonances;
mod architecture;
mod common;
mod frames;
mod modal_objective;
mod optimizer;
mod optimizer_boundary;
mod optimizer_polish;
mod optimizer_snapshot;
mod sensitivities;
mod updating;
