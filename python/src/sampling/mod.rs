//! Adaptive densities, integrals and point sequences, on arrays.

mod density;
mod integrate;
mod options;
mod sequence;

use pyo3::prelude::*;

/// Densities that are fitted to their own samples, and integrals with them.
#[pymodule(submodule)]
pub(crate) mod sampling {
    use super::*;

    #[pymodule_export]
    use super::density::DensityObject;
    #[pymodule_export]
    use super::density::DensitySamples;
    #[pymodule_export]
    use super::integrate::{AdaptiveEstimate, IntegralEstimate, integrate};
    #[pymodule_export]
    use super::sequence::sobol;

    /// Makes the module importable by its name.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let modules = module.py().import("sys")?.getattr("modules")?;
        modules.set_item("glanz._glanz.sampling", module)
    }
}
