//! Frames against closed forms and laws; run with `--nocapture` for the tables of errors.
#![allow(clippy::print_stdout, clippy::format_collect)]

mod build;
mod closed_forms;
mod laws;
mod parameters;
mod portal;
mod sensitivities;
mod wrong;
