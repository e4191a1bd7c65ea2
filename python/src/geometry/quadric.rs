//! Quadrics, disks, planes and tori.

use std::f64::consts::TAU;

use glanz::geometry::quadric::{
    Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid,
};
use glanz::geometry::torus::Torus;
use glanz::geometry::{DVec3, Surface};
use pyo3::prelude::*;

use super::definition::Definition;
use super::surface::SurfaceObject;
use crate::arguments::value_error;

/// A class per surface: its name, its constructor's arguments with their defaults, and the surface that they define.
macro_rules! equations {
    ($($object:ident, $name:literal: ($($argument:ident: $kind:ty $(= $default:expr)?),*) => $surface:expr;)*) => {
        $(
            #[doc = concat!("A surface given by an equation; see `glanz.geometry.", $name, "`.")]
            #[pyclass(name = $name, module = "glanz.geometry", extends = SurfaceObject, frozen)]
            pub(crate) struct $object;

            #[pymethods]
            impl $object {
                #[new]
                #[pyo3(signature = ($($argument $(= $default)?),*))]
                fn new($($argument: $kind),*) -> PyResult<PyClassInitializer<Self>> {
                    let surface: Surface = $surface.map_err(value_error)?.into();
                    let base = SurfaceObject::from(Definition::Equation(Box::new(surface)));
                    Ok(PyClassInitializer::from(base).add_subclass(Self))
                }
            }
        )*
    };
}

equations! {
    SphereObject, "Sphere": (radius: f64 = 1.0, z: Option<[f64; 2]> = None, phi_max: f64 = TAU) =>
        Sphere::try_new(radius, z.unwrap_or([-radius, radius]), phi_max);
    CylinderObject, "Cylinder": (radius: f64 = 1.0, z: [f64; 2] = [-1.0, 1.0], phi_max: f64 = TAU) =>
        Cylinder::try_new(radius, z, phi_max);
    ConeObject, "Cone": (radius: f64 = 1.0, height: f64 = 1.0, phi_max: f64 = TAU) =>
        Cone::try_new(radius, height, phi_max);
    ParaboloidObject, "Paraboloid": (radius: f64 = 1.0, z: [f64; 2] = [0.0, 1.0], phi_max: f64 = TAU) =>
        Paraboloid::try_new(radius, z, phi_max);
    HyperboloidObject, "Hyperboloid": (p1: [f64; 3], p2: [f64; 3], phi_max: f64 = TAU) =>
        Hyperboloid::try_new(DVec3::from_array(p1), DVec3::from_array(p2), phi_max);
    TwoSheetedHyperboloidObject, "TwoSheetedHyperboloid": (a: f64, c: f64, z: [f64; 2], phi_max: f64 = TAU) =>
        TwoSheetedHyperboloid::try_new(a, c, z, phi_max);
    DiskObject, "Disk": (radius: f64 = 1.0, inner_radius: f64 = 0.0, height: f64 = 0.0, phi_max: f64 = TAU) =>
        Disk::try_new(height, radius, inner_radius, phi_max);
    PlaneObject, "Plane": (x: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY], y: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY]) =>
        Plane::try_new(x, y);
    TorusObject, "Torus": (major: f64 = 1.0, minor: f64 = 0.25, phi_max: f64 = TAU) =>
        Torus::try_new(major, minor, phi_max);
}
