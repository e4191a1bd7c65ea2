//! Axes of models, which have y up.

use glanz_math::{DMat3, DMat4, DVec3};

/// Conversion of a scene's axes to those of the model, which is right-handed with y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes(DMat3);

impl Axes {
    /// `camera`: camera to world. Up is the axis nearest to that of the camera. If the camera shows the world mirrored, as in pbrt's
    /// left-handed scenes, the model is mirrored, too.
    pub(crate) fn of_camera(camera: &DMat4) -> Self {
        let up = camera.y_axis.truncate();
        let mirror = if DMat3::from_mat4(*camera).determinant() > 0.0 { -1.0 } else { 1.0 };
        let size = up.abs();
        let rows = if size.y >= size.x && size.y >= size.z {
            let sign = up.y.signum();
            [DVec3::X, DVec3::Y * sign, DVec3::Z * sign]
        } else if size.z >= size.x {
            let sign = up.z.signum();
            [DVec3::X, DVec3::Z * sign, DVec3::Y * -sign]
        } else {
            let sign = up.x.signum();
            [DVec3::Y * -sign, DVec3::X * sign, DVec3::Z]
        };
        Self(DMat3::from_cols(rows[0] * mirror, rows[1], rows[2]).transpose())
    }

    /// Converts a matrix whose columns are in the axes of the scene to the axes of the model.
    pub(crate) fn of(&self, matrix: DMat3) -> DMat3 {
        self.0 * matrix
    }

    /// As a matrix.
    pub(crate) fn matrix(&self) -> DMat4 {
        DMat4::from_mat3(self.0)
    }

    /// Converts a point or a direction of the scene to the axes of the model.
    pub(crate) fn of_point(&self, point: DVec3) -> DVec3 {
        self.0 * point
    }

    pub(crate) fn is_mirrored(&self) -> bool {
        self.0.determinant() < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_up_and_nothing_is_mirrored_that_a_picture_does_not_mirror() {
        // A camera that looks along y with z up; x to the right in a right-handed world.
        let right_handed = DMat4::from_cols(
            DVec3::X.extend(0.0),
            DVec3::Z.extend(0.0),
            DVec3::Y.extend(0.0),
            DVec3::ZERO.extend(1.0),
        );
        let axes = Axes::of_camera(&right_handed);
        assert_eq!(axes.0 * DVec3::Z, DVec3::Y);
        assert!((axes.0.determinant() - 1.0).abs() < 1e-12 && !axes.is_mirrored());
        // The same with x to the left: what is right in the picture is right in the model.
        let left_handed = DMat4::from_cols(
            -DVec3::X.extend(0.0),
            DVec3::Z.extend(0.0),
            DVec3::Y.extend(0.0),
            DVec3::ZERO.extend(1.0),
        );
        let axes = Axes::of_camera(&left_handed);
        assert_eq!(axes.0 * DVec3::Z, DVec3::Y);
        assert!(axes.is_mirrored());
        for up in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            let right = up.any_orthonormal_vector();
            let camera = DMat4::from_mat3(DMat3::from_cols(right, up, -right.cross(up)));
            let axes = Axes::of_camera(&camera);
            assert_eq!(axes.0 * up, DVec3::Y);
            assert!((axes.0.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
