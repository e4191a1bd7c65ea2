//! Splines: knot vectors, basis functions, rational curves and surfaces (NURBS).
//!
//! A [`KnotVector`] divides the parameter interval into pieces; [`basis`] holds the functions that weight control points.
//! [`NurbsCurve`] and [`NurbsSurface`] have homogeneous control points (w x, w y, w z, w) with w > 0. Surfaces are evaluated
//! with all derivatives (`surface`), refined, cut and raised in degree (`surface_edit`), interpolated through points
//! (`interpolate`), measured (`measure`, `kept_area`, `closest`), and split into Bézier patches for rays (`extract`). [`polygon`] edits rows of any
//! control points.
//!
//! ```
//! use glanz_geometry::spline::{ParameterDirection, NurbsSurface};
//! use glanz_math::DVec3;
//!
//! // A quarter of a cylinder of radius 1 and height 2 (metres): a circular arc in u, a straight line in v.
//! let arc = [(1.0, 0.0, 1.0), (1.0, 1.0, 0.5_f64.sqrt()), (0.0, 1.0, 1.0)];
//! let points: Vec<DVec3> = arc.iter().flat_map(|&(x, y, _)| [0.0, 2.0].map(|z| DVec3::new(x, y, z))).collect();
//! let weights: Vec<f64> = arc.iter().flat_map(|&(_, _, w)| [w, w]).collect();
//! let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
//! let cylinder = NurbsSurface::try_from_points([2, 1], knots, &points, Some(&weights))?;
//!
//! let p = cylinder.point(0.3, 0.5);
//! assert!((p.truncate().length() - 1.0).abs() < 1e-15 && p.z == 1.0);
//! let area = cylinder.area(1e-9)?.value;
//! assert!((area - std::f64::consts::PI).abs() < 1e-9);
//! let finer = cylinder.insert_knot(ParameterDirection::U, 0.4, 1)?;
//! assert_eq!(finer.bezier_patches()?.len(), 2);
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

pub mod basis;
pub mod closest;
pub mod curve;
pub mod extract;
mod homogeneous;
pub mod interpolate;
mod kept_area;
pub mod knots;
pub mod measure;
pub mod polygon;
pub mod surface;
pub mod surface_edit;
#[cfg(test)]
mod tests;

pub use closest::ClosestPoint;
pub use curve::{BezierSegment, NurbsCurve};
pub use extract::BezierPiece;
pub use interpolate::averaged_knots;
pub use knots::{KnotVector, MAX_DEGREE};
pub use measure::{AreaEstimate, SurfaceCurvature};
pub use surface::NurbsSurface;
pub use surface_edit::ParameterDirection;
