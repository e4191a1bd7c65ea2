//! Conversion of B-spline surfaces to Bézier patches, and to surfaces for rays.

use super::polygon::{self, BezierRow};
use super::surface::NurbsSurface;
use crate::bezier::TensorPatch;
use crate::error::SurfaceError;
use crate::freeform::{Freeform, SurfacePatch};

/// A piece of a surface between neighbouring knots.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPiece {
    /// Range of the surface's u; its ends are 0 and 1 in the patch.
    pub u: [f64; 2],
    /// Range of the surface's v.
    pub v: [f64; 2],
    /// The same points, over the unit square.
    pub patch: TensorPatch,
}

impl NurbsSurface {
    /// The pieces between knots, those of equal u next to each other.
    ///
    /// The control points of neighbours along their common border are equal to the last bit, unless the surface jumps there. Weights that are all 1 stay 1,
    /// and coordinates that all points share stay as they are.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if knots are so close together that a weight underflows.
    ///
    /// # Source
    /// Every knot is inserted until it appears `degree` times (@boehm1980).
    pub fn bezier_patches(&self) -> Result<Vec<BezierPiece>, SurfaceError> {
        let (p, q) = (self.knots_u().degree(), self.knots_v().degree());
        let (count_u, count_v) = self.counts();
        // Flat lists: unlike that of many short rows, their memory goes back to the system.
        let (mut breaks_u, mut breaks_v) = (Vec::new(), Vec::new());
        let (mut starts_u, mut starts_v) = (Vec::new(), Vec::new());
        let (mut rows, mut columns) = (Vec::new(), Vec::new());
        for row in self.control_points().chunks_exact(count_v) {
            let BezierRow { breaks, starts, points } = polygon::bezier_row(self.knots_v(), row)?;
            (breaks_v, starts_v) = (breaks, starts);
            rows.extend(points);
        }
        let width = rows.len() / count_u.max(1);
        for j in 0..width {
            let column: Vec<_> = rows.iter().skip(j).step_by(width).copied().collect();
            let BezierRow { breaks, starts, points } = polygon::bezier_row(self.knots_u(), &column)?;
            (breaks_u, starts_u) = (breaks, starts);
            columns.extend(points);
        }
        drop(rows);
        let height = columns.len() / width.max(1);
        let mut pieces = Vec::new();
        for (&i, u) in starts_u.iter().zip(breaks_u.windows(2)) {
            for (&j, v) in starts_v.iter().zip(breaks_v.windows(2)) {
                let columns = &columns;
                let points = (i..=i + p).flat_map(|i| (j..=j + q).map(move |j| columns[j * height + i]));
                let patch = TensorPatch::try_new(p, q, points.collect())?;
                pieces.push(BezierPiece { u: [u[0], u[1]], v: [v[0], v[1]], patch });
            }
        }
        Ok(pieces)
    }

    /// The surface as Bézier patches with a hierarchy over them, for intersection with rays.
    ///
    /// [`SurfacePoint::uv`](crate::SurfacePoint::uv) of a hit are the parameters of this surface.
    ///
    /// # Errors
    /// Those of [`NurbsSurface::bezier_patches`] and [`Freeform::try_new`].
    pub fn to_freeform(&self) -> Result<Freeform, SurfaceError> {
        Freeform::try_new(self.surface_patches()?)
    }

    /// The pieces between knots with their places in the parameters of this surface.
    ///
    /// # Errors
    /// Those of [`NurbsSurface::bezier_patches`].
    pub fn surface_patches(&self) -> Result<Vec<SurfacePatch>, SurfaceError> {
        let pieces = self.bezier_patches()?.into_iter();
        pieces.map(|piece| SurfacePatch::over_rectangle(piece.patch, piece.u, piece.v)).collect()
    }
}
