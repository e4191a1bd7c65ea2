//! Footprints of rays on surfaces.

use glanz_math::{DVec2, DVec3};

/// The part of a surface that one sample of the film sees, to the first order: a parallelogram whose sides are the ways of the point on the surface while
/// the sample moves on the film to the next one, along x and along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureFootprint {
    /// The sides in texture coordinates.
    pub uv: [DVec2; 2],
    /// The sides in the world, metres.
    pub position: [DVec3; 2],
}

/// Axes of a parallelogram in a picture: those of the ellipse that has the same first order.
#[derive(Clone, Copy, Debug)]
pub(super) struct FootprintEllipse {
    /// The longer axis, from end to end.
    pub(super) major: DVec2,
    /// Its length, and that of the shorter axis.
    pub(super) lengths: [f64; 2],
}

impl FootprintEllipse {
    /// The image of the unit circle under the matrix with these columns; of infinite length if they are not finite.
    ///
    /// The squared lengths are the eigenvalues of the matrix times its transpose.
    pub(super) fn new([a, b]: [DVec2; 2]) -> Self {
        let (xx, yy, xy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y, a.x * a.y + b.x * b.y);
        let major = (0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy)).sqrt();
        if !major.is_finite() {
            return Self { major: DVec2::ZERO, lengths: [f64::INFINITY; 2] };
        }
        let minor = if major > 0.0 { a.perp_dot(b).abs() / major } else { 0.0 };
        let direction = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        Self { major: major * direction, lengths: [major, minor] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_of_an_ellipse_do_not_depend_on_the_diameters_that_describe_it() {
        // A circle stretched to 5 and 2 and turned by 0.3, from any two perpendicular radii of the circle.
        let turn = DVec2::from_angle(0.3);
        for angle in [0.0, 0.4, 1.2, 2.9] {
            let radii = [DVec2::from_angle(angle), DVec2::from_angle(angle).perp()];
            let ellipse = FootprintEllipse::new(radii.map(|r| turn.rotate(DVec2::new(5.0, 2.0) * r)));
            assert!((ellipse.lengths[0] - 5.0).abs() < 1e-12 && (ellipse.lengths[1] - 2.0).abs() < 1e-12);
            let along = ellipse.major.dot(turn).abs();
            assert!((along - 5.0).abs() < 1e-12, "{:?}", ellipse.major);
        }
    }

    #[test]
    fn footprints_without_extent_and_without_bound_have_lengths() {
        assert_eq!(FootprintEllipse::new([DVec2::ZERO; 2]).lengths, [0.0; 2]);
        assert_eq!(FootprintEllipse::new([DVec2::X, DVec2::X]).lengths[1], 0.0);
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(FootprintEllipse::new([DVec2::new(x, 0.0), DVec2::Y]).lengths[0], f64::INFINITY);
        }
    }
}
