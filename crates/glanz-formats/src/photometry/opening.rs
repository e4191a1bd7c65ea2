//! The luminous opening: the part of a luminaire that shines.

/// Shape of the luminous opening; sizes are in [`Opening::size`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpeningShape {
    /// No extent.
    Point,
    /// A rectangle with normal -z; a line if one size is 0.
    Rectangle,
    /// A box that shines downwards and sideways; an upright rectangle if one size is 0.
    Box,
    /// An ellipse with normal -z; a circle if x and y are equal.
    Ellipse,
    /// An upright cylinder with elliptic base.
    VerticalCylinder,
    /// A cylinder with its axis along x.
    CylinderAlongX,
    /// A cylinder with its axis along y.
    CylinderAlongY,
    /// An ellipsoid; a sphere if the sizes are equal.
    Ellipsoid,
    /// An upright ellipse with normal +x.
    EllipseFacingX,
}

/// Shape and size of the luminous opening, around the photometric centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Its shape.
    pub shape: OpeningShape,
    /// Extent along x, y and z in metres, none below zero. For round shapes these are diameters.
    pub size: [f64; 3],
}

impl Opening {
    /// No extent.
    pub const POINT: Self = Self { shape: OpeningShape::Point, size: [0.0; 3] };

    /// The opening that LM-63 writes as width, length and height with signs for the shape.
    ///
    /// Length lies along the photometric horizontal (x), width across it (y). `metres` is the unit of the file.
    /// `signs_of_1995` tells whether signs are read by the table of the editions to 1995 or by that from 2002; what
    /// means nothing in one is read by the other. `None` if it means nothing in both.
    #[must_use]
    pub fn from_signs(
        width: f64,
        length: f64,
        height: f64,
        metres: f64,
        signs_of_1995: bool,
    ) -> Option<Self> {
        let sign = |v: f64| if v == 0.0 { 0 } else { v.signum() as i8 };
        let signs = (sign(width), sign(length), sign(height));
        let shape = if signs_of_1995 {
            by_1995(signs).or_else(|| by_2002(signs))
        } else {
            by_2002(signs).or_else(|| by_1995(signs))
        }?;
        let (mut w, mut l, mut h) = (width.abs() * metres, length.abs() * metres, height.abs() * metres);
        // The early table leaves out sizes that equal the diameter.
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
        Some(Self { shape, size: [l, w, h] })
    }
}

/// Signs of width, length and height from 2002 on; a negative size is round.
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

/// The same up to 1995: "along" is the direction of the larger axis, 0 stands for the same size again.
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
    fn the_table_of_2002_is_read_by_its_signs() {
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
            assert_eq!(
                Opening::from_signs(w, l, h, 1.0, false),
                Some(Opening { shape, size }),
                "{w} {l} {h}"
            );
        }
    }

    #[test]
    fn feet_and_the_signs_of_1995_are_known() {
        let circle = Opening { shape: OpeningShape::Ellipse, size: [0.6096, 0.6096, 0.0] };
        assert_eq!(Opening::from_signs(-2.0, 0.0, 0.0, 0.3048, true), Some(circle));
        assert_eq!(Opening::from_signs(-2.0, 0.0, 0.0, 0.3048, false), Some(circle));
        let sphere = Opening { shape: OpeningShape::Ellipsoid, size: [2.0; 3] };
        assert_eq!(Opening::from_signs(-2.0, 0.0, -2.0, 1.0, true), Some(sphere));
        let tube = Opening { shape: OpeningShape::CylinderAlongX, size: [4.0, 0.5, 0.5] };
        assert_eq!(Opening::from_signs(0.0, 4.0, -0.5, 1.0, true), Some(tube));
        assert_eq!(Opening::from_signs(0.0, 0.0, -1.0, 1.0, true), None);
    }
}
