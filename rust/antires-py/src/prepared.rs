//! Damage from tables: the arrays of a plan and of a test, handed to the core.

use antires_core::prepared::look::look;
use antires_core::prepared::nearest::{refined, scanned, settled, variances};
use antires_core::prepared::tables::{Error, Places, Tables, Test, Together};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyReadonlyArray4,
};
use pyo3::prelude::*;

use crate::doorway::{guarded, internal};

/// The arrays of [`Tables`] by name, as they are kept, as they are read while the core runs, and handed over.
macro_rules! prepared_tables {
    ($($name:ident: $kept:ident, $read:ident, $number:ty;)*) => {
        /// Tables of roots (r,) at levels (l,) of each element (n,), shared by all tests.
        #[pyclass(frozen, module = "antires_rs._core")]
        pub struct PreparedTables {
            $($name: Py<$kept<$number>>,)*
            new_variance: f64,
        }

        /// The arrays while they are read.
        struct Borrowed<'py> {
            $($name: $read<'py, $number>,)*
            new_variance: f64,
        }

        impl Borrowed<'_> {
            fn tables(&self) -> PyResult<Tables<'_>> {
                Ok(Tables {
                    n: self.slopes.as_array().shape()[0],
                    q: self.errors.as_array().shape()[3],
                    $($name: self.$name.as_slice()?,)*
                    new_variance: self.new_variance,
                })
            }
        }

        impl PreparedTables {
            fn borrowed<'py>(&self, py: Python<'py>) -> Borrowed<'py> {
                Borrowed { $($name: self.$name.bind(py).readonly(),)* new_variance: self.new_variance }
            }
        }

        #[pymethods]
        impl PreparedTables {
            #[new]
            #[allow(clippy::too_many_arguments)]
            fn new(py: Python<'_>, $($name: Py<$kept<$number>>,)* new_variance: f64) -> PyResult<Self> {
                let made = Self { $($name,)* new_variance };
                if made.borrowed(py).tables()?.consistent() {
                    Ok(made)
                } else {
                    Err(internal("tables of different shapes"))
                }
            }
        }
    };
}

prepared_tables! {
    levels: PyArray1, PyReadonlyArray1, f64;
    response: PyArray1, PyReadonlyArray1, i64;
    seen: PyArray1, PyReadonlyArray1, bool;
    old: PyArray1, PyReadonlyArray1, bool;
    intact: PyArray1, PyReadonlyArray1, f64;
    there: PyArray3, PyReadonlyArray3, bool;
    place: PyArray3, PyReadonlyArray3, f64;
    beside: PyArray3, PyReadonlyArray3, f64;
    by_own: PyArray3, PyReadonlyArray3, f64;
    slopes: PyArray4, PyReadonlyArray4, f32;
    crossed: PyArray4, PyReadonlyArray4, f32;
    errors: PyArray4, PyReadonlyArray4, f32;
    spread: PyArray2, PyReadonlyArray2, f64;
    host: PyArray1, PyReadonlyArray1, i64;
    errors_of: PyArray1, PyReadonlyArray1, i64;
}

/// Values of one test against tables.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct PreparedTest {
    tables: Py<PreparedTables>,
    test: Test,
    outside: f64,
    variance: Vec<f64>,
}

/// Elements and their severities.
type Set = (Vec<usize>, Vec<f64>);

/// Log-likelihood, gain (k,), curvature (k, k), number of the error, partner, beside, residual, std, chi-square,
/// shift.
type PyLook<'py> = (
    f64,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    usize,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    f64,
);

/// Severities of the last look; from there the most probable ones, the mean without bounds and its covariance,
/// log evidence; log-likelihood.
type PySettled = (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>, f64, f64);

impl PreparedTest {
    /// What `work` finds of each set, which `further` elements may join, detached from the interpreter.
    fn each<T: Send>(
        &self,
        py: Python<'_>,
        sets: &[Set],
        further: &[usize],
        work: impl Fn(&Tables<'_>, &Set) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        let borrowed = self.tables.get().borrowed(py);
        let t = borrowed.tables()?;
        let known = |(elements, u): &Set| {
            elements.len() == u.len() && elements.iter().chain(further).all(|&e| e < t.n + t.host.len())
        };
        if !sets.iter().all(known) {
            return Err(internal("elements outside the tables"));
        }
        guarded(py, || Ok(sets.iter().map(|set| work(&t, set)).collect()))
    }
}

#[pymethods]
impl PreparedTest {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        tables: Py<PreparedTables>,
        response: Vec<i64>,
        log_f: Vec<f64>,
        std: Vec<f64>,
        set: Vec<i64>,
        times: Vec<f64>,
        band: (f64, f64),
        common: f64,
        extra: f64,
        errors: Vec<Error>,
        together: (f64, Vec<f64>, usize),
        outside: f64,
    ) -> PyResult<Self> {
        let ((low, high), (alike, heat, many)) = (band, together);
        let together = Together { alike, heat, many };
        let test = Test { response, log_f, std, set, times, low, high, common, extra, errors, together };
        if !test.consistent() {
            return Err(internal("values of different lengths"));
        }
        let variance = variances(&tables.get().borrowed(py).tables()?, &test);
        Ok(Self { tables, test, outside, variance })
    }

    /// The values as seen from severities of some elements, with slopes by all.
    fn look<'py>(&self, py: Python<'py>, elements: Vec<usize>, u: Vec<f64>) -> PyResult<PyLook<'py>> {
        let mut looks = self.each(py, &[(elements, u)], &[], |t, (elements, u)| {
            look(t, &self.test, &Places::new(t, elements, u), &(0..t.n).collect::<Vec<_>>())
        })?;
        let found = looks.remove(0);
        let n = found.gain.len();
        Ok((
            found.log_likelihood,
            found.gain.into_pyarray(py),
            found.curvature.into_pyarray(py).reshape([n, n])?,
            found.error,
            found.partner.into_pyarray(py),
            found.beside.into_pyarray(py),
            found.residual.into_pyarray(py),
            found.std.into_pyarray(py),
            found.chi_square,
            found.shift,
        ))
    }

    /// Distances and misfits (further, levels) that sets with one element more leave.
    #[allow(clippy::type_complexity)]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        elements: Vec<usize>,
        u: Vec<f64>,
        further: Vec<usize>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let mut scans = self.each(py, &[(elements, u)], &further, |t, (elements, u)| {
            let at = Places::new(t, elements, u);
            (scanned(t, &self.test, &at, &further, &self.variance), [further.len(), t.levels.len()])
        })?;
        let (left, shape) = scans.remove(0);
        Ok((left.distance.into_pyarray(py).reshape(shape)?, left.misfit.into_pyarray(py).reshape(shape)?))
    }

    /// Severities of sets after a few steps by the nearest roots, and what they leave.
    fn refine(&self, py: Python<'_>, sets: Vec<Set>, steps: usize) -> PyResult<Vec<(Vec<f64>, f64)>> {
        self.each(py, &sets, &[], |t, (elements, u)| {
            refined(t, &self.test, elements, u, (steps, self.outside), &self.variance)
        })
    }

    /// Sets at their most probable severities, by the likelihood.
    fn settle(&self, py: Python<'_>, sets: Vec<Set>, looks: usize, rests: f64) -> PyResult<Vec<PySettled>> {
        self.each(py, &sets, &[], |t, (elements, u)| {
            let found = settled(t, &self.test, elements, u, (looks, rests));
            let seen = found.seen;
            (found.u, seen.u, seen.mean, seen.covariance, seen.log, found.log_likelihood)
        })
    }
}
