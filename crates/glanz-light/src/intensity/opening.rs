//! The luminous opening: the light-emitting part of a luminaire.

/// Shape of the luminous opening; sizes are in [`LuminousOpening::size`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpeningShape {
    /// No extent.
    Point,
    /// A rectangle with normal -z; a line if one size is 0.
    Rectangle,
    /// A box that emits downwards and sideways; an upright rectangle if one size is 0.
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
pub struct LuminousOpening {
    /// Shape.
    pub shape: OpeningShape,
    /// Extent along x, y and z in metres, not negative: diameters of round shapes.
    pub size: [f64; 3],
}

impl LuminousOpening {
    /// An opening without extent.
    pub const POINT: Self = Self { shape: OpeningShape::Point, size: [0.0; 3] };
}
