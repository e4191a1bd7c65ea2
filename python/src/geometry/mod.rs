//! Surfaces: evaluation, measures and intersection with rays, on arrays.

mod closest;
mod definition;
mod hits;
mod intersect;
mod nurbs;
mod quadric;
mod surface;
mod triangle;
mod trims;

use pyo3::prelude::*;

/// Surfaces: evaluation, measures and intersection with rays.
#[pymodule(submodule)]
pub(crate) mod geometry {
    use super::*;

    #[pymodule_export]
    use super::closest::{AreaObject, ClosestPoints, CurvatureArrays};
    #[pymodule_export]
    use super::hits::{AllHits, RayHits};
    #[pymodule_export]
    use super::nurbs::{BezierPatchObject, NurbsObject};
    #[pymodule_export]
    use super::quadric::{
        ConeObject, CylinderObject, DiskObject, HyperboloidObject, ParaboloidObject, PlaneObject,
        SphereObject, TorusObject, TwoSheetedHyperboloidObject,
    };
    #[pymodule_export]
    use super::surface::SurfaceObject;
    #[pymodule_export]
    use super::triangle::BezierTriangleObject;

    /// Makes the module importable by its name.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let modules = module.py().import("sys")?.getattr("modules")?;
        modules.set_item("glanz._glanz.geometry", module)
    }
}
