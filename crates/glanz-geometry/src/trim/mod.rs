//! Trimming: the part of a parameter domain inside closed loops of curves.
//!
//! [`TrimCurve`] is a chain of rational Bézier pieces in (u, v): lines, ellipses or NURBS. Curves that meet end to end make a
//! [`TrimLoop`], which keeps the points on its left and splits its curves into pieces monotone in u and in v. [`TrimRegion`]
//! has a quadtree over the domain: most cells are inside or outside as a whole. In the others, the winding number of a point
//! is that of the corner of its cell plus the crossings of the pieces on a short path to that corner. A single point of a
//! monotone piece, to the upper left or lower right, decides on which side of the piece a point lies.
//!
//! Curves have widths: points within the width of a curve are kept on both sides of it. Where two faces of a solid meet, their curves
//! agree only up to such a width, which closes the slit between the faces; [`RegionLocation`] tells points in these borders, of which one
//! face or the other has one too many.
//!
//! ```
//! use glanz_geometry::DVec2;
//! use glanz_geometry::trim::{Containment, TrimCurve, TrimLoop, TrimRegion};
//!
//! let center = DVec2::splat(0.5);
//! let plate = TrimLoop::try_closed(TrimCurve::try_circle(center, 0.4)?, 0.0)?;
//! let hole = TrimLoop::try_closed(TrimCurve::try_circle(center, 0.2)?.reversed(), 0.0)?;
//! let ring = TrimRegion::try_new(vec![plate, hole], [DVec2::ZERO, DVec2::ONE])?;
//!
//! assert!(ring.contains(DVec2::new(0.8, 0.5)));
//! assert!(!ring.contains(center));
//! assert_eq!(ring.classify(DVec2::splat(0.45), DVec2::splat(0.55)), Containment::Outside);
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

mod border;
mod cell_builder;
mod cell_tree;
mod curve;
mod loops;
mod monotone;
mod piece_in_cell;
mod piece_table;
mod region;
#[cfg(test)]
mod tests;

pub use border::scale_across;
pub use curve::{MAX_DEGREE, TrimCurve};
pub use loops::TrimLoop;
pub use monotone::MonotonePiece;
pub use region::{Containment, RegionLocation, RegionSettings, TrimRegion, TrimStatistics};
