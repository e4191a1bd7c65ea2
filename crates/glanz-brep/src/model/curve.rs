//! Curves in space and in parameter planes.

use super::spline_curve::SplineCurve;
use super::vector::CurveVector;

/// A curve with the parameterization of @iso10303-42 section 4.4. Vectors of conics include their radii.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve<P: CurveVector> {
    /// `origin + t direction`.
    Line {
        /// Point at t = 0.
        origin: P,
        /// Derivative.
        direction: P,
    },
    /// `center + cos t a + sin t b`; a circle if `a` and `b` are perpendicular and equally long.
    Ellipse {
        /// Centre.
        center: P,
        /// Conjugate radius at t = 0.
        a: P,
        /// Conjugate radius at t = pi / 2.
        b: P,
    },
    /// `apex + t^2 a + 2 t b`, where `a` and `b` are as long as the focal distance.
    Parabola {
        /// Apex.
        apex: P,
        /// Along the axis.
        a: P,
        /// Along the tangent at the apex.
        b: P,
    },
    /// `center + cosh t a + sinh t b`.
    Hyperbola {
        /// Centre.
        center: P,
        /// Half axis to the apex.
        a: P,
        /// Imaginary half axis.
        b: P,
    },
    /// A rational B-spline.
    Spline(SplineCurve<P>),
    /// Straight segments between points; segment i has the parameters from i to i + 1.
    Polyline(Vec<P>),
    /// Curves one after the other, each run in its sense; their parameters start at 0 and add up.
    Composite(Vec<(Self, bool)>),
    /// A part of a curve from one parameter to another. Where `same_sense` is false it runs against the parameter of the curve;
    /// on a closed curve it may pass the seam. Its own parameters are those of the curve, or their negatives.
    Trimmed {
        /// The whole curve.
        basis: Box<Self>,
        /// Parameters of the curve at the start and at the end.
        range: [f64; 2],
        /// Whether it runs along the parameter of the curve.
        same_sense: bool,
    },
}
