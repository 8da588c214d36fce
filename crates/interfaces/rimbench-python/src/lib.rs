//! rimbench from Python, and Python inside rimbench.
//!
//! The module `rimbench._native`, on which the package in `python/rimbench` stands. A call computes on a thread of its
//! own without the lock of the interpreter (`interruption`), so that Ctrl-C and other threads of Python get their turn;
//! a side or a scheme that is an object of Python takes the lock for each callback (`subsystem`, `scheme`) and is run
//! by the same loop as any other.

mod calls;
mod case;
mod engine_rows;
mod errors;
mod interruption;
mod model;
mod numbers;
mod scheme;
mod subsystem;

use pyo3::prelude::*;
use rimbench::catalogue::Catalogue;
use std::sync::LazyLock;

/// Everything that the command line can run by name.
fn everything() -> &'static Catalogue {
    static EVERYTHING: LazyLock<Catalogue> =
        LazyLock::new(|| rimbench::everything().unwrap_or_else(|_| Catalogue::standard()));
    &EVERYTHING
}

#[pymodule(name = "_native")]
fn native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("RimbenchError", module.py().get_type::<errors::RimbenchError>())?;
    module.add("__version__", rimbench::BUILD.version)?;
    module.add_class::<case::PyCase>()?;
    module.add_class::<scheme::PyScheme>()?;
    module.add_class::<engine_rows::EngineRows>()?;
    module.add_class::<scheme::PySample>()?;
    module.add_class::<scheme::PyMicroStep>()?;
    module.add_function(wrap_pyfunction!(case::open_case, module)?)?;
    module.add_function(wrap_pyfunction!(case::fmu_worker, module)?)?;
    module.add_function(wrap_pyfunction!(calls::cases, module)?)?;
    module.add_function(wrap_pyfunction!(calls::schemes, module)?)?;
    module.add_function(wrap_pyfunction!(calls::metrics, module)?)?;
    module.add_function(wrap_pyfunction!(calls::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(calls::limit, module)?)?;
    module.add_function(wrap_pyfunction!(calls::advise, module)?)?;
    module.add_function(wrap_pyfunction!(calls::run, module)?)
}
