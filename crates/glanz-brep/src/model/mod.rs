//! A boundary representation as plain data, as a CAD file gives it.
//!
//! Readers fill a [`BrepModel`]; nothing in it is checked but that its indices are valid, and splines. Lengths are metres, angles radians, in the
//! frame of the [`Part`] that owns them. Terms and parameterizations are those of @iso10303-42.

mod curve;
mod spline_curve;
mod surface;
mod topology;
mod vector;

pub use curve::Curve;
pub use spline_curve::SplineCurve;
pub use surface::{FaceSurface, Placement};
pub use topology::{
    Body, BoundaryLoop, BrepModel, ColorStyle, Edge, EntityId, Face, FaceBound, Occurrence, OrientedEdge,
    ParameterCurve, Part, Shell, StyleOverride, SurfaceEntry,
};
pub use vector::CurveVector;
