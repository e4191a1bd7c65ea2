//! The surface of a mesh at a hit.

use glanz_math::{DVec2, DVec3};

use super::Mesh;
use super::vector_list::{ListVector, VectorList};
use crate::hit::{Hit, ShadingPoint, SurfacePoint};
use crate::triangle::{normal_and_area, position_error_of};

/// Texture coordinates of a triangle that has none.
///
/// # Source
/// @pharr2023 section 6.5.3.
const DEFAULT_UVS: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::ONE];

/// The map from values at the vertices of a triangle to derivatives by the texture coordinates.
struct Gradient {
    /// Maps the differences `q0 - q2` and `q1 - q2` to the derivatives by u and v.
    by_u: DVec2,
    by_v: DVec2,
}

impl Gradient {
    /// `None` if the texture coordinates of the triangle lie on a line.
    fn new(uvs: [DVec2; 3]) -> Option<Self> {
        let (a, b) = (uvs[0] - uvs[2], uvs[1] - uvs[2]);
        let area = a.x * b.y - a.y * b.x;
        // Points on a line have as much by rounding.
        let largest = uvs.iter().fold(0.0_f64, |most, uv| most.max(uv.abs().max_element()));
        let rounding = 4.0 * f64::EPSILON * largest * (a.abs() + b.abs()).element_sum();
        let inverse = 1.0 / area;
        (area.abs() > rounding && inverse.is_finite())
            .then(|| Self { by_u: DVec2::new(b.y, -a.y) * inverse, by_v: DVec2::new(-b.x, a.x) * inverse })
    }

    /// That of a triangle; if its texture coordinates lie on a line, that of default ones.
    fn of_triangle(uvs: [DVec2; 3]) -> Option<Self> {
        Self::new(uvs).or_else(|| Self::new(DEFAULT_UVS))
    }

    fn of(&self, q: [DVec3; 3]) -> (DVec3, DVec3) {
        let (a, b) = (q[0] - q[2], q[1] - q[2]);
        (a * self.by_u.x + b * self.by_u.y, a * self.by_v.x + b * self.by_v.y)
    }
}

/// `q0 b0 + q1 b1 + q2 b2`.
fn interpolate(q: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    q[0] * (1.0 - u - v) + q[1] * u + q[2] * v
}

/// A triangle with the part of its points that is the same everywhere on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedTriangle {
    corner: DVec3,
    edges: [DVec3; 2],
    error: DVec3,
    normal: DVec3,
}

impl PreparedTriangle {
    #[inline(never)]
    pub(super) fn new([p0, p1, p2]: [DVec3; 3]) -> Self {
        let (normal, twice_area) = normal_and_area(p0, p1, p2).unwrap_or((DVec3::Z, 0.0));
        let error = position_error_of(p0, p1, p2, twice_area);
        Self { corner: p0, edges: [p1 - p0, p2 - p0], error, normal }
    }

    /// The point at the weights `u`, `v` of the second and third vertex.
    #[inline]
    fn point(&self, u: f64, v: f64) -> FlatPoint {
        let Self { corner, edges: [a, b], error, normal } = *self;
        // In this order the error bound holds.
        FlatPoint { position: corner + u * a + v * b, error, normal }
    }
}

/// A point of a triangle.
pub(super) struct FlatPoint {
    pub(super) position: DVec3,
    pub(super) error: DVec3,
    /// Unit normal, by the order of the vertices.
    pub(super) normal: DVec3,
}

/// The normal where those at the vertices determine the side.
pub(super) struct SmoothNormal {
    /// Unit normal of the triangle on that side.
    pub(super) normal: DVec3,
    /// The interpolated normal, of any length.
    sum: DVec3,
}

impl Mesh {
    /// The values of a list by vertex at the corners of a triangle.
    #[inline]
    pub(super) fn at_corners<V: ListVector>(
        &self,
        list: Option<&VectorList<V>>,
        face: u32,
    ) -> Option<[V; 3]> {
        let ([a, b, c], list) = (*self.indices.get(face as usize)?, list?);
        Some([list.get(a)?, list.get(b)?, list.get(c)?])
    }

    /// A point of a triangle, at the weights `u`, `v` of the second and third vertex.
    #[inline]
    pub(super) fn flat_point_at(&self, face: u32, u: f64, v: f64) -> FlatPoint {
        if let Some(triangle) = self.prepared.get(face as usize) {
            return triangle.point(u, v);
        }
        // A face of another mesh has no corners here: the result is meaningless, but it does not panic.
        PreparedTriangle::new(self.corners(face).unwrap_or_default()).point(u, v)
    }

    /// The interpolated normal, where the unit normal of the triangle is `flat`; `None` without normals at the vertices, and where they
    /// cancel or lie in the plane of the triangle, so that they do not determine its side.
    #[inline(never)]
    pub(super) fn smooth_normal(&self, face: u32, u: f64, v: f64, flat: DVec3) -> Option<SmoothNormal> {
        let sum = interpolate(self.at_corners(self.normals.as_ref(), face)?, u, v);
        let side = sum.dot(flat);
        (sum.length_squared() > 0.0 && side != 0.0)
            .then(|| SmoothNormal { normal: flat * side.signum(), sum })
    }

    /// The surface at the weights `u`, `v` of the second and third vertex of a triangle, without derivatives.
    #[inline]
    pub(super) fn shading_point_at(&self, face: u32, u: f64, v: f64) -> ShadingPoint {
        let FlatPoint { position, error, normal } = self.flat_point_at(face, u, v);
        let uvs = self.at_corners(self.uvs.as_ref(), face).unwrap_or(DEFAULT_UVS);
        let uv = uvs[0] * (1.0 - u - v) + uvs[1] * u + uvs[2] * v;
        let smooth = self.normals.as_ref().and_then(|_| self.smooth_normal(face, u, v, normal));
        let (normal, shading_normal) = match smooth {
            Some(SmoothNormal { normal, sum }) => (normal, sum * (1.0 / sum.length())),
            None => (normal, normal),
        };
        ShadingPoint { position, error, normal, shading_normal, uv, dpdu: DVec3::ZERO }
    }

    /// The surface at the weights `u`, `v` of the second and third vertex of a triangle.
    pub(crate) fn point_at(&self, face: u32, u: f64, v: f64) -> SurfacePoint {
        let corners = self.corners(face).unwrap_or_default();
        let uvs = self.at_corners(self.uvs.as_ref(), face).unwrap_or(DEFAULT_UVS);
        let (dpdu, dpdv) = Gradient::of_triangle(uvs).map_or_else(Default::default, |g| g.of(corners));
        let ShadingPoint { position, error, normal, shading_normal, uv, .. } =
            self.shading_point_at(face, u, v);
        SurfacePoint { position, error, normal, shading_normal, uv, dpdu, dpdv }
    }

    /// The derivatives of the texture coordinates by the parameters of `dpdu` and `dpdv`, which are default ones where the coordinates lie on a line.
    pub(super) fn uv_rates_at(&self, face: u32) -> [DVec2; 2] {
        let uvs = self.at_corners(self.uvs.as_ref(), face).unwrap_or(DEFAULT_UVS);
        if Gradient::new(uvs).is_some() {
            return [DVec2::X, DVec2::Y];
        }
        // By default coordinates the weights of the second and the third corner are u - v and v.
        [uvs[1] - uvs[0], uvs[2] - uvs[1]]
    }

    /// Derivatives of the interpolated normal at the weights `u`, `v`, where the shading normal is `unit`.
    pub(super) fn normal_derivatives_at(&self, face: u32, u: f64, v: f64, unit: DVec3) -> [DVec3; 2] {
        let uvs = self.at_corners(self.uvs.as_ref(), face).unwrap_or(DEFAULT_UVS);
        let (Some(normals), Some(gradient)) =
            (self.at_corners(self.normals.as_ref(), face), Gradient::of_triangle(uvs))
        else {
            return [DVec3::ZERO; 2];
        };
        let smooth = interpolate(normals, u, v);
        let inverse = 1.0 / smooth.length();
        // Where normals do not determine the side, the triangle's own is used, which is constant.
        if !(inverse.is_finite() && smooth * inverse == unit) {
            return [DVec3::ZERO; 2];
        }
        let (dndu, dndv) = gradient.of(normals);
        // d(n / |n|) = (dn - n (n . dn) / |n|^2) / |n|
        [dndu, dndv].map(|dn| (dn - unit * unit.dot(dn)) * inverse)
    }

    /// Drops hits, from the sorted ones beginning at `start`, that repeat another.
    ///
    /// A ray exactly through an edge or a vertex meets several triangles; that is one point of the surface. Two hits are
    /// one if their triangles share a vertex and the points are no farther apart than their error bounds.
    pub(super) fn drop_repeated(&self, start: usize, hits: &mut Vec<Hit>) {
        let same = |a: &Hit, b: &Hit| {
            let (Some(p), Some(q)) = (self.corners(a.face), self.corners(b.face)) else { return false };
            let (m, n) = (self.point_at(a.face, a.u, a.v), self.point_at(b.face, b.u, b.v));
            (m.position - n.position).abs().cmple(m.error + n.error).all()
                && p.iter().any(|corner| q.contains(corner))
        };
        let mut kept = start;
        for i in start..hits.len() {
            let hit = hits[i];
            if !hits[start..kept].iter().rev().any(|other| same(other, &hit)) {
                hits[kept] = hit;
                kept += 1;
            }
        }
        hits.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_coordinates_on_a_line_have_no_gradient() {
        let of = |uvs: [[f64; 2]; 3]| Gradient::new(uvs.map(DVec2::from_array));
        // Their determinants are -1e-19 and 7e-18.
        assert!(of([[0.152, 0.192], [0.188, 0.078], [0.158, 0.173]]).is_none());
        assert!(of([[0.1, 0.3], [0.2, 0.6], [0.3, 0.9]]).is_none());
        assert!(of([[0.5, 0.5], [0.5001, 0.5], [0.5, 0.5001]]).is_some());
    }
}
