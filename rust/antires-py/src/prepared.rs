//! Damage from tables: the arrays of a plan and of a test, handed to the core.

use antires_core::prepared::look::{Look, look};
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
    variance: Vec<f64>,
}

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
    fn test(&self) -> Test<'_> {
        Test {
            response: &self.response,
            log_f: &self.log_f,
            std: &self.std,
            set: &self.set,
            times: &self.times,
            low: self.band.0,
            high: self.band.1,
            common: self.common,
            extra: self.extra,
            errors: &self.errors,
            together: Together { alike: self.together.0, heat: &self.together.1, many: self.together.2 },
        }
    }
}

fn known(t: &Tables<'_>, elements: &[usize], u: &[f64]) -> PyResult<()> {
    if elements.len() == u.len() && elements.iter().all(|&e| e < t.n + t.host.len()) {
        Ok(())
    } else {
        Err(internal("elements outside the tables"))
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
        let mut made = Self {
            tables,
            response,
            log_f,
            std,
            set,
            times,
            band,
            common,
            extra,
            errors,
            together,
            outside,
            variance: Vec::new(),
        };
        if !made.test().consistent() {
            return Err(internal("values of different lengths"));
        }
        let borrowed = made.tables.get().borrowed(py);
        let variance = variances(&borrowed.tables()?, &made.test());
        drop(borrowed);
        made.variance = variance;
        Ok(made)
    }

    /// The values as seen from severities of some elements, with slopes by all.
    fn look<'py>(&self, py: Python<'py>, elements: Vec<usize>, u: Vec<f64>) -> PyResult<PyLook<'py>> {
        let borrowed = self.tables.get().borrowed(py);
        let t = borrowed.tables()?;
        known(&t, &elements, &u)?;
        let at = Places::new(&t, &elements, &u);
        let all: Vec<usize> = (0..t.n).collect();
        let test = self.test();
        let found: Look = guarded(py, || Ok(look(&t, &test, &at, &all)))?;
        Ok((
            found.log_likelihood,
            found.gain.into_pyarray(py),
            found.curvature.into_pyarray(py).reshape([t.n, t.n])?,
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
        let borrowed = self.tables.get().borrowed(py);
        let t = borrowed.tables()?;
        known(&t, &elements, &u)?;
        known(&t, &further, &vec![0.0; further.len()])?;
        let test = self.test();
        let left = guarded(py, || {
            let at = Places::new(&t, &elements, &u);
            Ok(scanned(&t, &test, &at, &further, &self.variance))
        })?;
        let shape = [further.len(), t.levels.len()];
        Ok((left.distance.into_pyarray(py).reshape(shape)?, left.misfit.into_pyarray(py).reshape(shape)?))
    }

    /// Severities of sets after a few steps by the nearest roots, and what they leave.
    fn refine(
        &self,
        py: Python<'_>,
        sets: Vec<(Vec<usize>, Vec<f64>)>,
        steps: usize,
    ) -> PyResult<Vec<(Vec<f64>, f64)>> {
        let borrowed = self.tables.get().borrowed(py);
        let t = borrowed.tables()?;
        sets.iter().try_for_each(|(e, u)| known(&t, e, u))?;
        let test = self.test();
        guarded(py, || {
            let of = |(e, u): &(Vec<usize>, Vec<f64>)| {
                refined(&t, &test, e, u, (steps, self.outside), &self.variance)
            };
            Ok(sets.iter().map(of).collect())
        })
    }

    /// Sets at their most probable severities, by the likelihood.
    fn settle(
        &self,
        py: Python<'_>,
        sets: Vec<(Vec<usize>, Vec<f64>)>,
        looks: usize,
        rests: f64,
    ) -> PyResult<Vec<PySettled>> {
        let borrowed = self.tables.get().borrowed(py);
        let t = borrowed.tables()?;
        sets.iter().try_for_each(|(e, u)| known(&t, e, u))?;
        let test = self.test();
        guarded(py, || {
            let of = |(e, u): &(Vec<usize>, Vec<f64>)| {
                let found = settled(&t, &test, e, u, (looks, rests));
                let seen = found.seen;
                (found.u, seen.u, seen.mean, seen.covariance, seen.log, found.log_likelihood)
            };
            Ok(sets.iter().map(of).collect())
        })
    }
}
