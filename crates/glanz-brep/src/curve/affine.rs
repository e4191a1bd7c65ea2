//! Images of curves under affine maps.

use crate::model::{Curve, CurveVector, SplineCurve};

/// `x -> linear(x) + offset`, also between plane and space.
pub(crate) struct AffineMap<P, Q, F: Fn(P) -> Q> {
    /// The linear part.
    pub(crate) linear: F,
    /// The image of the origin.
    pub(crate) offset: Q,
    source: std::marker::PhantomData<P>,
}

impl<P: CurveVector, Q: CurveVector, F: Fn(P) -> Q> AffineMap<P, Q, F> {
    pub(crate) fn new(linear: F, offset: Q) -> Self {
        Self { linear, offset, source: std::marker::PhantomData }
    }

    fn point(&self, p: P) -> Q {
        (self.linear)(p) + self.offset
    }

    /// The image of a spline, of the same knots; `None` if it overflows.
    pub(crate) fn spline(&self, curve: &SplineCurve<P>) -> Option<SplineCurve<Q>> {
        let image = |h: &P::Homogeneous| {
            let (numerator, weight) = P::split(*h);
            ((self.linear)(numerator) + self.offset * weight).with_weight(weight)
        };
        let points = curve.control_points().iter().map(image).collect();
        SplineCurve::from_knots(curve.knots().clone(), points).ok()
    }

    /// The image of a curve, with the same parameters; `None` if it overflows.
    pub(crate) fn curve(&self, curve: &Curve<P>) -> Option<Curve<Q>> {
        let vector = |p: P| (self.linear)(p);
        Some(match curve {
            Curve::Line { origin, direction } => {
                Curve::Line { origin: self.point(*origin), direction: vector(*direction) }
            }
            Curve::Ellipse { center, a, b } => {
                Curve::Ellipse { center: self.point(*center), a: vector(*a), b: vector(*b) }
            }
            Curve::Parabola { apex, a, b } => {
                Curve::Parabola { apex: self.point(*apex), a: vector(*a), b: vector(*b) }
            }
            Curve::Hyperbola { center, a, b } => {
                Curve::Hyperbola { center: self.point(*center), a: vector(*a), b: vector(*b) }
            }
            Curve::Spline(spline) => Curve::Spline(self.spline(spline)?),
            Curve::Polyline(points) => Curve::Polyline(points.iter().map(|p| self.point(*p)).collect()),
            Curve::Composite(segments) => {
                let image = |(segment, sense): &(Curve<P>, bool)| Some((self.curve(segment)?, *sense));
                Curve::Composite(segments.iter().map(image).collect::<Option<_>>()?)
            }
            Curve::Trimmed { basis, range, same_sense } => {
                Curve::Trimmed { basis: Box::new(self.curve(basis)?), range: *range, same_sense: *same_sense }
            }
        })
    }
}

impl<P: CurveVector> Curve<P> {
    /// The image under `x -> linear(x) + offset`, with the same parameters; `None` if it overflows.
    #[must_use]
    pub fn mapped<Q: CurveVector>(&self, linear: impl Fn(P) -> Q, offset: Q) -> Option<Curve<Q>> {
        AffineMap::new(linear, offset).curve(self)
    }
}
