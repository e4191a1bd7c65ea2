//! Conversion of B-spline surfaces to Bézier patches, and to surfaces for rays.

use super::polygon;
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
    /// The control points of neighbours along their common border are equal to the last bit. Weights that are all 1 stay 1,
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
        let mut breaks_v = Vec::new();
        let mut rows = Vec::with_capacity(count_u);
        for row in self.control_points().chunks_exact(count_v) {
            let (breaks, row) = polygon::bezier(self.knots_v(), row)?;
            breaks_v = breaks;
            rows.push(row);
        }
        let mut breaks_u = Vec::new();
        let mut columns = Vec::new();
        for j in 0..rows.first().map_or(0, Vec::len) {
            let column: Vec<_> = rows.iter().map(|row| row[j]).collect();
            let (breaks, column) = polygon::bezier(self.knots_u(), &column)?;
            breaks_u = breaks;
            columns.push(column);
        }
        let mut pieces = Vec::new();
        for (i, u) in breaks_u.windows(2).enumerate() {
            for (j, v) in breaks_v.windows(2).enumerate() {
                let (i, j) = (i * p, j * q);
                let columns = &columns;
                let points = (i..=i + p).flat_map(|i| (j..=j + q).map(move |j| columns[j][i])).collect();
                let patch = TensorPatch::try_new(p, q, points)?;
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
        let pieces =
            self.bezier_patches()?.into_iter().map(|p| SurfacePatch::over_rectangle(p.patch, p.u, p.v));
        Freeform::try_new(pieces.collect::<Result<_, _>>()?)
    }
}
