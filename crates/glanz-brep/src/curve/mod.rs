//! Curves: evaluation, exact rational forms, closest points, and the curves of edges.
//!
//! [`Curve`] and [`SplineCurve`] are evaluated over the plane and over space alike (`evaluate`, `spline`). [`Curve::to_spline`] gives the
//! exact rational form of a part of any curve (`rational`). [`EdgeCurve`] is the part of a curve that runs from the start of an edge
//! to its end; [`EdgeCurve::polyline`] samples it.
//!
//! [`Curve`]: crate::model::Curve
//! [`SplineCurve`]: crate::model::SplineCurve
//! [`Curve::to_spline`]: crate::model::Curve::to_spline

mod affine;
mod closest;
mod edge;
mod evaluate;
mod near;
mod polyline;
mod rational;
mod spline;
#[cfg(test)]
mod tests;

pub(crate) use affine::AffineMap;
pub(crate) use closest::local_minimum;
pub use edge::EdgeCurve;
pub use polyline::EdgePolyline;
