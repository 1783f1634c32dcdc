//! Hands the search's snapshots to a Python object that stores them.

use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// The Python object (`resume`, `every_s`, `store(bytes)`) and the snapshot it does not have yet.
pub struct Checkpoint {
    object: Py<PyAny>,
    every: Duration,
    stored: Instant,
    latest: Option<Vec<u8>>,
}

impl Checkpoint {
    /// The object, and the snapshot that it wants the search to go on from.
    pub fn new(object: Bound<'_, PyAny>) -> PyResult<(Self, Option<Vec<u8>>)> {
        let resume = object.getattr("resume")?.extract()?;
        let every: f64 = object.getattr("every_s")?.extract()?;
        let checkpoint = Self {
            object: object.unbind(),
            every: Duration::from_secs_f64(every),
            stored: Instant::now(),
            latest: None,
        };
        Ok((checkpoint, resume))
    }

    /// Takes a snapshot, and stores it when it is time to.
    pub fn take(&mut self, bytes: Vec<u8>) -> PyResult<()> {
        self.latest = Some(bytes);
        if self.stored.elapsed() >= self.every {
            self.store()?;
        }
        Ok(())
    }

    /// Stores the latest snapshot.
    pub fn store(&mut self) -> PyResult<()> {
        if let Some(bytes) = self.latest.take() {
            Python::attach(|py| self.object.call_method1(py, "store", (PyBytes::new(py, &bytes),)))?;
            self.stored = Instant::now();
        }
        Ok(())
    }
}
