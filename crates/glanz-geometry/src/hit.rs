//! Intersections of rays with surfaces, and points of surfaces.

use glanz_math::{AreaPdf, DVec2, DVec3, Transform};

/// An intersection by ray parameter and surface parameters. The [`SurfacePoint`] is computed for the closest one only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, > 0.
    pub t: f64,
    /// First surface parameter; barycentric weight of the second vertex on triangles.
    pub u: f64,
    /// Second surface parameter; barycentric weight of the third vertex on triangles.
    pub v: f64,
    /// Facet of a polyhedron, triangle of a mesh; 0 elsewhere.
    pub face: u32,
    /// Whether it lies in the border of a trimming curve.
    pub border: HitBorder,
}

// Batches hold many.
const _: () = assert!(size_of::<Hit>() == 32);

impl Hit {
    /// A hit away from trimming curves.
    #[inline(always)]
    #[must_use]
    pub const fn new(t: f64, u: f64, v: f64, face: u32) -> Self {
        Self { t, u, v, face, border: HitBorder::Away }
    }
}

/// Location of a hit relative to the borders of the trimming curves of its surface: the points within the width of a curve, see
/// [`TrimRegion`](crate::trim::TrimRegion).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HitBorder {
    /// In no border.
    #[default]
    Away,
    /// In a border, on the kept side of the curves.
    Inner,
    /// In a border, on the side that the curves cut away.
    Outer,
}

/// A point of a surface with its error bound, normals and first derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, metres.
    pub position: DVec3,
    /// Absolute bound per axis on the distance from `position` to the surface, large enough that a ray started at the
    /// edge of this box (see [`glanz_math::rounding::offset_origin`]) is on the side it should be when the
    /// intersection is computed again in `f64`.
    pub error: DVec3,
    /// Unit normal of the surface itself.
    pub normal: DVec3,
    /// Unit normal for shading: that of the surface, or interpolated over a mesh; within 90 degrees of `normal`.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Derivative of the position by `uv.x`; zero where the parameters degenerate.
    pub dpdu: DVec3,
    /// Derivative of the position by `uv.y`; zero where the parameters degenerate.
    pub dpdv: DVec3,
}

impl SurfacePoint {
    /// The same point in the frame that `to_world` maps to.
    ///
    /// The error grows by the roundings of the map and by those of its inverse, since the next ray is transformed to the
    /// local frame again.
    #[inline]
    #[must_use]
    pub fn transformed(&self, to_world: &Transform) -> Self {
        let ShadingPoint { position, error, normal, shading_normal, uv, dpdu } =
            ShadingPoint::from(*self).transformed(to_world);
        Self { position, error, normal, shading_normal, uv, dpdu, dpdv: to_world.vector(self.dpdv) }
    }

    /// The derivatives `[dn/du, dn/dv]` of the shading normal at this point, of which those in its own frame are `derivatives`, in the
    /// frame that `to_world` maps to.
    #[must_use]
    pub fn transformed_normal_derivatives(
        &self,
        derivatives: [DVec3; 2],
        to_world: &Transform,
    ) -> [DVec3; 2] {
        let normal = to_world.normal(self.shading_normal);
        let scale = 1.0 / normal.length();
        let unit = normal * scale;
        // d(n / |n|) = (dn - n (n . dn) / |n|^2) / |n|
        derivatives.map(|dn| {
            let moved = to_world.normal(dn) * scale;
            moved - unit * unit.dot(moved)
        })
    }

    /// The same point of the surface with reversed orientation: both normals change sign.
    #[inline]
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, shading_normal: -self.shading_normal, ..self }
    }
}

impl From<SurfacePoint> for ShadingPoint {
    fn from(point: SurfacePoint) -> Self {
        let SurfacePoint { position, error, normal, shading_normal, uv, dpdu, .. } = point;
        Self { position, error, normal, shading_normal, uv, dpdu }
    }
}

/// A [`SurfacePoint`] as far as shading needs it; its fields are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingPoint {
    /// The point, metres.
    pub position: DVec3,
    /// Absolute bound per axis on the distance from `position` to the surface.
    pub error: DVec3,
    /// Unit normal of the surface itself.
    pub normal: DVec3,
    /// Unit normal for shading.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Derivative of the position by `uv.x`; zero also on meshes, each triangle of which has parameters of its own.
    pub dpdu: DVec3,
}

impl ShadingPoint {
    /// The same point in the frame that `to_world` maps to: the bits of [`SurfacePoint::transformed`].
    #[inline]
    #[must_use]
    pub fn transformed(&self, to_world: &Transform) -> Self {
        let (position, error) = transformed_position(self.position, self.error, to_world);
        let shading_normal = to_world.normal(self.shading_normal);
        Self {
            position,
            error,
            normal: to_world.normal(self.normal).normalize(),
            shading_normal: shading_normal * (1.0 / shading_normal.length()),
            uv: self.uv,
            dpdu: to_world.vector(self.dpdu),
        }
    }

    /// The same point of the surface with reversed orientation: both normals change sign.
    #[inline]
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, shading_normal: -self.shading_normal, ..self }
    }
}

/// Position and error bound in the frame that `to_world` maps to.
#[inline]
fn transformed_position(position: DVec3, error: DVec3, to_world: &Transform) -> (DVec3, DVec3) {
    let moved = to_world.point(position);
    let back = to_world.inverse().point_error(moved, DVec3::ZERO);
    (moved, to_world.point_error(position, error + back))
}

/// Position, normal and texture coordinates of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceLocation {
    /// The point, metres.
    pub position: DVec3,
    /// Normal of the surface itself, of any length.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
}

/// A point sampled on a surface, without parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaSample {
    /// The point, metres.
    pub position: DVec3,
    /// As [`SurfacePoint::error`].
    pub error: DVec3,
    /// Unit normal of the surface itself.
    pub normal: DVec3,
    /// As [`Hit::face`].
    pub face: u32,
    /// Density with which it was sampled.
    pub pdf: AreaPdf,
}

impl From<SurfaceSample> for AreaSample {
    fn from(sample: SurfaceSample) -> Self {
        let SurfacePoint { position, error, normal, .. } = sample.point;
        Self { position, error, normal, face: sample.hit.face, pdf: sample.pdf }
    }
}

impl AreaSample {
    /// The same point in the frame that `to_world` maps to, where its density is that of the area there.
    #[inline]
    #[must_use]
    pub fn transformed(&self, to_world: &Transform) -> Self {
        let (position, error) = transformed_position(self.position, self.error, to_world);
        let normal = to_world.normal(self.normal);
        let length = normal.length();
        Self {
            position,
            error,
            normal: normal * (1.0 / length),
            face: self.face,
            pdf: AreaPdf(self.pdf.0 / (to_world.volume_scale() * length)),
        }
    }
}

/// A point sampled on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Parameters of the point; `t` is 0.
    pub hit: Hit,
    /// The point.
    pub point: SurfacePoint,
    /// Density with which it was sampled.
    pub pdf: AreaPdf,
}
