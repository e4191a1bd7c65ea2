//! Trimming: the part of a parameter domain that closed loops of curves leave.
//!
//! [`TrimCurve`] is a chain of rational Bézier pieces in (u, v), made of lines, ellipses or NURBS. Curves that meet end
//! to end make a [`TrimLoop`], which keeps what lies to its left and holds its curves cut into pieces monotone in u and
//! in v. [`TrimRegion`] puts a hierarchy over the domain: most cells are inside or outside as a whole, in the others a
//! short way to the corner of the cell, of which the winding number is known, counts the pieces that it crosses. On
//! which side of a monotone piece a point lies, one point of the curve above or below it tells.
//!
//! ```
//! use glanz_geometry::DVec2;
//! use glanz_geometry::trim::{Cell, TrimCurve, TrimLoop, TrimRegion};
//!
//! let center = DVec2::splat(0.5);
//! let plate = TrimLoop::try_closed(TrimCurve::try_circle(center, 0.4)?, 0.0)?;
//! let hole = TrimLoop::try_closed(TrimCurve::try_circle(center, 0.2)?.reversed(), 0.0)?;
//! let ring = TrimRegion::try_new(vec![plate, hole], [DVec2::ZERO, DVec2::ONE])?;
//!
//! assert!(ring.contains(DVec2::new(0.8, 0.5)));
//! assert!(!ring.contains(center));
//! assert_eq!(ring.classify(DVec2::splat(0.45), DVec2::splat(0.55)), Cell::Outside);
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

mod curve;
mod locate;
mod loops;
mod monotone;
mod pieces;
#[cfg(test)]
mod tests;
mod tree;

pub use curve::{MAX_DEGREE, TrimCurve};
pub use locate::{Cell, MonotonePiece, TrimRegion, TrimSizes};
pub use loops::TrimLoop;
