//! Invertible affine maps.

use crate::rounding::gamma;
use crate::{Bounds3, DAffine3, DMat3, DMat4, DVec3, Ray};

/// The reason why a matrix is not a [`Transform`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransformError {
    /// An entry is infinite or not a number.
    #[error("the matrix has an entry that is not finite; all entries must be finite")]
    NotFinite,
    /// The last row is not (0, 0, 0, w): the map would be projective.
    #[error("the matrix is projective; it must be affine, with the last row (0, 0, 0, w)")]
    Projective,
    /// The matrix is not invertible.
    #[error("the matrix is singular (determinant {0:e}); it must be invertible")]
    Singular(f64),
}

/// An affine map together with its inverse.
///
/// Points, directions and normals transform differently: normals by the inverse transpose (document 001 section 3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    forward: DAffine3,
    backward: DAffine3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The identity.
    pub const IDENTITY: Self = Self { forward: DAffine3::IDENTITY, backward: DAffine3::IDENTITY };

    /// Checks and inverts a homogeneous 4 x 4 matrix (columns as in [`DMat4`]).
    ///
    /// # Errors
    /// [`TransformError`] if an entry is not finite, the last row is not (0, 0, 0, w) with w != 0, or the linear part
    /// is singular up to rounding.
    pub fn try_from_matrix(matrix: DMat4) -> Result<Self, TransformError> {
        if !matrix.is_finite() {
            return Err(TransformError::NotFinite);
        }
        let w = matrix.w_axis.w;
        if matrix.x_axis.w != 0.0 || matrix.y_axis.w != 0.0 || matrix.z_axis.w != 0.0 || w == 0.0 {
            return Err(TransformError::Projective);
        }
        Self::try_from_affine(DAffine3::from_mat4(matrix * (1.0 / w)))
    }

    /// Checks and inverts an affine map.
    ///
    /// # Errors
    /// [`TransformError`] as for [`Transform::try_from_matrix`].
    pub fn try_from_affine(forward: DAffine3) -> Result<Self, TransformError> {
        if !forward.is_finite() {
            return Err(TransformError::NotFinite);
        }
        let m = forward.matrix3;
        let determinant = m.determinant();
        // Hadamard: |det| is at most the product of the column lengths. Their ratio measures, in any unit of length, how close
        // the columns are to a plane.
        let volume = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        let backward = forward.inverse();
        if volume == 0.0 || determinant.abs() <= gamma(8) * volume || !backward.is_finite() {
            return Err(TransformError::Singular(determinant));
        }
        Ok(Self { forward, backward })
    }

    /// The translation by `offset`, metres.
    #[must_use]
    pub fn translate(offset: DVec3) -> Self {
        Self { forward: DAffine3::from_translation(offset), backward: DAffine3::from_translation(-offset) }
    }

    /// The map as linear part and translation.
    #[must_use]
    pub fn forward(&self) -> DAffine3 {
        self.forward
    }

    /// The inverse map.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { forward: self.backward, backward: self.forward }
    }

    /// The composition: first `inner`, then this map.
    #[must_use]
    pub fn after(&self, inner: &Self) -> Self {
        let forward = self.forward * inner.forward;
        // The product of the inverses would differ from the inverse by the roundings of places in between, however far away.
        let backward = forward.inverse();
        Self {
            forward,
            backward: if backward.is_finite() { backward } else { inner.backward * self.backward },
        }
    }

    /// Transforms a point.
    #[inline]
    #[must_use]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.forward.transform_point3(point)
    }

    /// Transforms a direction or a difference of points.
    #[inline]
    #[must_use]
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        self.forward.transform_vector3(vector)
    }

    /// Transforms a normal, by the inverse transpose; the result is not normalized.
    #[inline]
    #[must_use]
    pub fn normal(&self, normal: DVec3) -> DVec3 {
        let m = self.backward.matrix3;
        DVec3::new(m.x_axis.dot(normal), m.y_axis.dot(normal), m.z_axis.dot(normal))
    }

    /// Transforms a ray; its parameter t stays the same.
    #[inline]
    #[must_use]
    pub fn ray(&self, ray: &Ray) -> Ray {
        Ray::new(self.point(ray.origin), self.vector(ray.direction))
    }

    /// Bound, per axis, on the error of [`Transform::point`] for a `point` with the given `error` per axis.
    ///
    /// `gamma(4)` covers the roundings of three products and three sums (@higham2002 section 3.1).
    #[inline]
    #[must_use]
    pub fn point_error(&self, point: DVec3, error: DVec3) -> DVec3 {
        let m = self.forward.matrix3;
        let a = DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
        a * error * (1.0 + gamma(4)) + (a * point.abs() + self.forward.translation.abs()) * gamma(4)
    }

    /// A box around the image of `bounds`.
    #[must_use]
    pub fn bounds(&self, bounds: &Bounds3) -> Bounds3 {
        if bounds.is_empty() {
            return Bounds3::EMPTY;
        }
        let image = Bounds3::from_points(bounds.corners().map(|c| self.point(c)));
        let reach = bounds.min.abs().max(bounds.max.abs());
        let error = self.point_error(reach, DVec3::ZERO);
        Bounds3 { min: image.min - error, max: image.max + error }
    }

    /// Factor by which the area of a surface element with unit normal `normal` grows: |det M| |M^-T n|.
    #[inline]
    #[must_use]
    pub fn area_scale(&self, normal: DVec3) -> f64 {
        self.volume_scale() * self.normal(normal).length()
    }

    /// Factor by which volumes grow: |det M|.
    #[inline]
    #[must_use]
    pub fn volume_scale(&self) -> f64 {
        self.forward.matrix3.determinant().abs()
    }

    /// The factor by which every length grows, if the map is a similarity (rotation, uniform scale, mirror).
    ///
    /// `None` if the factors of different directions differ by more than `tolerance`, relative.
    #[must_use]
    pub fn uniform_scale(&self, tolerance: f64) -> Option<f64> {
        let m = self.forward.matrix3;
        let gram = m.transpose() * m;
        let s2 = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
        let deviation = (gram - DMat3::from_diagonal(DVec3::splat(s2))).to_cols_array();
        deviation.iter().all(|d| d.abs() <= tolerance * s2).then(|| s2.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composed_maps_are_inverted_to_the_digits_of_their_product() {
        // The inner map goes a kilometre away, the outer one comes back.
        let inner = Transform::translate(DVec3::new(1000.0, 300.0, 70.0));
        let turn = DMat3::from_rotation_z(0.3);
        let back = DVec3::new(0.4, 0.5, 0.9) - turn * DVec3::new(1000.0, 300.0, 70.0);
        let outer = Transform::try_from_affine(DAffine3 { matrix3: turn, translation: back }).unwrap();
        let both = outer.after(&inner);
        for point in [DVec3::ZERO, DVec3::new(0.1, -0.2, 0.3)] {
            let there_and_back = both.inverse().point(both.point(point));
            assert!((there_and_back - point).length() < 1e-15, "{there_and_back}");
        }
    }

    fn skewed() -> Transform {
        Transform::try_from_affine(DAffine3 {
            matrix3: DMat3::from_cols(
                DVec3::new(1.0, 0.5, 0.0),
                DVec3::new(0.0, 2.0, 0.25),
                DVec3::new(-0.3, 0.0, -0.5),
            ),
            translation: DVec3::new(3.0, -1.0, 2.0),
        })
        .unwrap()
    }

    #[test]
    fn inverse_brings_points_back() {
        let t = skewed();
        let p = DVec3::new(0.2, 0.4, -7.0);
        assert!((t.inverse().point(t.point(p)) - p).length() < 1e-13);
    }

    #[test]
    fn normals_stay_perpendicular_to_tangents() {
        let t = skewed();
        let (a, b) = (DVec3::new(1.0, 2.0, 0.5), DVec3::new(-1.0, 0.3, 2.0));
        let n = t.normal(a.cross(b));
        assert!(n.dot(t.vector(a)).abs() < 1e-13);
        assert!(n.dot(t.vector(b)).abs() < 1e-13);
    }

    #[test]
    fn area_scale_is_that_of_a_parallelogram() {
        let t = skewed();
        let (a, b) = (DVec3::new(1.0, 2.0, 0.5), DVec3::new(-1.0, 0.3, 2.0));
        let grown = t.vector(a).cross(t.vector(b)).length() / a.cross(b).length();
        assert!((t.area_scale(a.cross(b).normalize()) - grown).abs() < 1e-13);
    }

    #[test]
    fn bounds_hold_the_image_of_every_corner() {
        let t = skewed();
        let b = Bounds3::new(DVec3::new(-1.0, -2.0, 3.0), DVec3::new(4.0, 0.5, 3.0));
        let image = t.bounds(&b);
        assert!(b.corners().iter().all(|&c| image.contains(t.point(c))));
    }

    #[test]
    fn singular_projective_and_infinite_matrices_are_refused() {
        let flat = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
        assert!(matches!(Transform::try_from_matrix(flat), Err(TransformError::Singular(_))));
        let mut projective = DMat4::IDENTITY;
        projective.z_axis.w = 1.0;
        assert_eq!(Transform::try_from_matrix(projective), Err(TransformError::Projective));
        let infinite = DMat4::from_translation(DVec3::new(f64::NAN, 0.0, 0.0));
        assert_eq!(Transform::try_from_matrix(infinite), Err(TransformError::NotFinite));
        // A scale to micrometres is not singular.
        assert!(Transform::try_from_matrix(DMat4::from_scale(DVec3::splat(1e-6))).is_ok());
    }

    #[test]
    fn uniform_scale_is_found_and_skew_is_not() {
        let t = Transform::try_from_matrix(
            DMat4::from_rotation_x(0.3) * DMat4::from_scale(DVec3::new(-2.0, 2.0, 2.0)),
        )
        .unwrap();
        assert!((t.uniform_scale(1e-12).unwrap() - 2.0).abs() < 1e-14);
        assert_eq!(skewed().uniform_scale(1e-12), None);
    }
}
