//! The one way in and out: detach, guard against panics, map errors, watch for Ctrl-C and time.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use antires_core::error::{Argument, Error, Step};
use antires_core::optimize::Interrupt;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::import_exception;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

import_exception!(antires_rs.exceptions, InternalError);
import_exception!(antires_rs.exceptions, InvalidInputError);
import_exception!(antires_rs.exceptions, NumericalError);
import_exception!(antires_rs.exceptions, OutOfMemoryError);
import_exception!(antires_rs.exceptions, ObjectiveError);

/// How often signals are looked at: often enough for a person, seldom enough to cost nothing.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);

/// The Python exception of a core error, which takes its fields.
pub fn to_python(error: Error) -> PyErr {
    match error {
        Error::InvalidInput { argument, got, wanted, remedy } => {
            Python::attach(|py| match python_argument(py, &argument) {
                Ok(argument) => InvalidInputError::new_err((argument, got, wanted, remedy)),
                Err(error) => error,
            })
        }
        Error::Numerical { what, detail } => NumericalError::new_err((what, detail)),
        Error::Memory { what, bytes } => OutOfMemoryError::new_err((what, bytes)),
        other => internal(&other.to_string()),
    }
}

/// What never should happen.
pub fn internal(text: &str) -> PyErr {
    InternalError::new_err(format!(
        "internal error in the Rust core: {text}. This is a bug of antires_rs; please report the call."
    ))
}

/// The argument as the Python face has it: its spelling, and the way to the part that is meant.
fn python_argument(py: Python<'_>, argument: &Argument) -> PyResult<Py<PyAny>> {
    let mut path = vec![argument.name().into_pyobject(py)?.into_any()];
    for step in argument.steps() {
        path.push(match step {
            Step::Item(index) => index.into_pyobject(py)?.into_any(),
            Step::Field(name) => name.into_pyobject(py)?.into_any(),
        });
    }
    let class = py.import("antires_rs.exceptions")?.getattr("Argument")?;
    let made = class.call1((argument.to_string(), PyTuple::new(py, path)?))?;
    Ok(made.unbind())
}

/// Runs `work` detached from the interpreter. A panic becomes an `InternalError`.
pub fn guarded<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        Err(internal(text))
    })
}

/// [`guarded`] for work that fails with a core error.
pub fn run<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> antires_core::error::Result<T> + Send,
) -> PyResult<T> {
    guarded(py, || work().map_err(to_python))
}

/// Watches for Ctrl-C and for a deadline while the core works.
pub struct Watch {
    deadline: Option<Instant>,
    next_look: Instant,
    /// What a signal handler or a callback raised, other than Ctrl-C.
    pub raised: Option<PyErr>,
}

impl Watch {
    /// Starts now; `max_seconds` from now is the deadline.
    pub fn start(max_seconds: Option<f64>) -> Self {
        let now = Instant::now();
        let limit = max_seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
        Self { deadline: limit.and_then(|l| now.checked_add(l)), next_look: now, raised: None }
    }

    /// What asks for a stop now, if anything.
    pub fn poll(&mut self) -> Option<Interrupt> {
        let now = Instant::now();
        if self.deadline.is_some_and(|deadline| now >= deadline) {
            return Some(Interrupt::TimeLimit);
        }
        if now < self.next_look {
            return None;
        }
        self.next_look = now + SIGNAL_INTERVAL;
        // Not the method itself: its lifetime is not general enough for `attach`.
        #[allow(clippy::redundant_closure_for_method_calls)]
        Python::attach(|py| py.check_signals()).err().map(|error| self.stop_for(error))
    }

    /// Ctrl-C ends a run with the best so far; any other exception is raised once the run has ended.
    pub fn stop_for(&mut self, error: PyErr) -> Interrupt {
        let user = Python::attach(|py| error.is_instance_of::<PyKeyboardInterrupt>(py));
        if user {
            return Interrupt::User;
        }
        self.raised.get_or_insert(error);
        Interrupt::Callback
    }
}
