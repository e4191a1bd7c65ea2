//! The luminous opening in LM-63.

use glanz_light::intensity::{LuminousOpening, OpeningShape};

/// The opening by its width, length and height in LM-63, whose signs denote the shape.
///
/// The length is along the photometric horizontal (x), the width across it (y). `metres`: unit of the file.
/// `signs_of_1995`: whether signs are those of the editions to 1995 or those from 2002 on; signs that are
/// undefined in one table are read by the other. `None` if they are undefined in both.
#[must_use]
pub(super) fn from_signs(
    width: f64,
    length: f64,
    height: f64,
    metres: f64,
    signs_of_1995: bool,
) -> Option<LuminousOpening> {
    let sign = |v: f64| if v == 0.0 { 0 } else { v.signum() as i8 };
    let signs = (sign(width), sign(length), sign(height));
    let shape = if signs_of_1995 {
        by_1995(signs).or_else(|| by_2002(signs))
    } else {
        by_2002(signs).or_else(|| by_1995(signs))
    }?;
    let (mut w, mut l, mut h) = (width.abs() * metres, length.abs() * metres, height.abs() * metres);
    // The early table omits sizes equal to the diameter.
    match shape {
        OpeningShape::Ellipse | OpeningShape::VerticalCylinder if l == 0.0 => l = w,
        OpeningShape::Ellipse | OpeningShape::VerticalCylinder if w == 0.0 => w = l,
        OpeningShape::Ellipsoid if l == 0.0 => l = w,
        OpeningShape::CylinderAlongX if w == 0.0 => w = h,
        OpeningShape::CylinderAlongY if l == 0.0 => l = h,
        _ => {}
    }
    if shape == OpeningShape::Ellipsoid && h == 0.0 {
        h = w;
    }
    Some(LuminousOpening { shape, size: [l, w, h] })
}

/// The shape by the signs of width, length and height from 2002 on; a negative size is round.
fn by_2002(signs: (i8, i8, i8)) -> Option<OpeningShape> {
    Some(match signs {
        (0, 0, 0) => OpeningShape::Point,
        (0 | 1, 0 | 1, 0) => OpeningShape::Rectangle,
        (0 | 1, 0 | 1, 1) => OpeningShape::Box,
        (-1, -1, 0) => OpeningShape::Ellipse,
        (-1, -1, 1) => OpeningShape::VerticalCylinder,
        (-1, -1, -1) => OpeningShape::Ellipsoid,
        (-1, 1, -1) => OpeningShape::CylinderAlongX,
        (1, -1, -1) => OpeningShape::CylinderAlongY,
        (-1, 0, -1) => OpeningShape::EllipseFacingX,
        _ => return None,
    })
}

/// The shape by the signs up to 1995: "along" is the direction of the larger axis, and 0 means the same size.
fn by_1995(signs: (i8, i8, i8)) -> Option<OpeningShape> {
    Some(match signs {
        (0, 0, 0) => OpeningShape::Point,
        (0 | 1, 0 | 1, 0) => OpeningShape::Rectangle,
        (0 | 1, 0 | 1, 1) => OpeningShape::Box,
        (-1, 0 | 1, 0) | (0 | 1, -1, 0) => OpeningShape::Ellipse,
        (-1, 0 | 1, 1) | (0 | 1, -1, 1) => OpeningShape::VerticalCylinder,
        (-1, 0 | 1, -1) | (1, -1, -1) => OpeningShape::Ellipsoid,
        (0, 1, -1) => OpeningShape::CylinderAlongX,
        (1, 0, -1) => OpeningShape::CylinderAlongY,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_of_2002_select_the_shape() {
        use OpeningShape::*;
        // Width, length, height as in the table; length along x.
        for (w, l, h, shape, size) in [
            (0.0, 0.0, 0.0, Point, [0.0, 0.0, 0.0]),
            (1.0, 2.0, 0.0, Rectangle, [2.0, 1.0, 0.0]),
            (1.0, 2.0, 3.0, Box, [2.0, 1.0, 3.0]),
            (-1.0, -1.0, 0.0, Ellipse, [1.0, 1.0, 0.0]),
            (-1.0, -2.0, 0.0, Ellipse, [2.0, 1.0, 0.0]),
            (-1.0, -1.0, 3.0, VerticalCylinder, [1.0, 1.0, 3.0]),
            (-1.0, -1.0, -1.0, Ellipsoid, [1.0, 1.0, 1.0]),
            (-1.0, 2.0, -1.0, CylinderAlongX, [2.0, 1.0, 1.0]),
            (2.0, -1.0, -1.0, CylinderAlongY, [1.0, 2.0, 1.0]),
            (-1.0, 0.0, -2.0, EllipseFacingX, [0.0, 1.0, 2.0]),
        ] {
            assert_eq!(from_signs(w, l, h, 1.0, false), Some(LuminousOpening { shape, size }), "{w} {l} {h}");
        }
    }

    #[test]
    fn feet_and_the_signs_of_1995_are_supported() {
        let circle = LuminousOpening { shape: OpeningShape::Ellipse, size: [0.6096, 0.6096, 0.0] };
        assert_eq!(from_signs(-2.0, 0.0, 0.0, 0.3048, true), Some(circle));
        assert_eq!(from_signs(-2.0, 0.0, 0.0, 0.3048, false), Some(circle));
        let sphere = LuminousOpening { shape: OpeningShape::Ellipsoid, size: [2.0; 3] };
        assert_eq!(from_signs(-2.0, 0.0, -2.0, 1.0, true), Some(sphere));
        let tube = LuminousOpening { shape: OpeningShape::CylinderAlongX, size: [4.0, 0.5, 0.5] };
        assert_eq!(from_signs(0.0, 4.0, -0.5, 1.0, true), Some(tube));
        assert_eq!(from_signs(0.0, 0.0, -1.0, 1.0, true), None);
    }
}
