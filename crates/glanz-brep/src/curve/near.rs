//! Bounded parts of unbounded curves.

use crate::model::{Curve, CurveVector};

impl<P: CurveVector> Curve<P> {
    /// A range of parameters outside of which an unbounded curve is farther than `radius` (metres) from `center`; the domain of a
    /// bounded one.
    ///
    /// On a parabola `|t^2 a + 2 t b|` is at least `t^2 |a| - 2 |t| |b|`. On a hyperbola `|cosh t a + sinh t b|` is at least
    /// `(e^t |a + b| - |a - b|) / 2` for t > 0. Both exceed the radius and the distance of `center` from apex or centre beyond the
    /// range.
    pub(crate) fn range_near(&self, center: P, radius: f64) -> [f64; 2] {
        let [low, high] = self.far_limits(center, radius);
        // A curve whose size is lost to rounding is a point.
        if low <= high { [low, high] } else { [0.0, 0.0] }
    }

    /// The range of [`Self::range_near`]; NaN where numbers underflow.
    fn far_limits(&self, center: P, radius: f64) -> [f64; 2] {
        match self {
            Self::Line { origin, direction } => {
                let length2 = direction.dot(*direction);
                let middle = (center - *origin).dot(*direction) / length2;
                let half = radius / length2.sqrt();
                [middle - half, middle + half]
            }
            Self::Parabola { apex, a, b } => {
                let far = radius + apex.distance_to(center);
                let (a, b) = (a.norm(), b.norm());
                let limit = (b + (b * b + a * far).sqrt()) / a;
                [-limit, limit]
            }
            Self::Hyperbola { center: middle, a, b } => {
                let far = radius + middle.distance_to(center);
                let (sum, difference) = ((*a + *b).norm(), (*a - *b).norm());
                let limit = |near: f64, other: f64| ((2.0 * far + other) / near).max(1.0).ln();
                [-limit(difference, sum), limit(sum, difference)]
            }
            Self::Trimmed { basis, range, same_sense } => {
                let ends = basis.trimmed_range(*range, *same_sense);
                if *same_sense { ends } else { ends.map(|t| -t) }
            }
            _ => self.domain(),
        }
    }
}
