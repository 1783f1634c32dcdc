//! Frames against closed forms and laws; run with `--nocapture` for the tables of errors.

mod build;
mod closed_forms;
mod laws;
mod parameters;
mod portal;
mod sensitivities;
mod wrong;
