//! Rectangles of parameters.

use glanz_math::DVec2;

/// A rectangle of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ParameterRect {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
}

impl ParameterRect {
    /// The parameters at (x, y) of the rectangle, which is in [0, 1]^2; exact at the corners.
    pub(super) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let mix = |[a, b]: [f64; 2], x: f64| if x == 1.0 { b } else { (b - a) * x + a };
        (mix(self.u, x), mix(self.v, y))
    }
}

/// A dyadic rectangle: a result of at most 16 halvings of the unit square in each direction. Its coordinates are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DyadicRect {
    /// Positions of its intervals along u and v, counted in their own lengths.
    index: [u16; 2],
    /// Numbers of halvings along u and v.
    halvings: [u8; 2],
}

/// 2^-n.
#[inline(always)]
fn power(n: u8) -> f64 {
    f64::from_bits((1023 - u64::from(n)) << (f64::MANTISSA_DIGITS - 1))
}

impl DyadicRect {
    pub(super) const WHOLE: Self = Self { index: [0; 2], halvings: [0; 2] };

    /// Its halves along u or v.
    pub(super) fn halves(self, across_u: bool) -> [Self; 2] {
        let axis = usize::from(!across_u);
        let (mut low, mut high) = (self, self);
        low.halvings[axis] += 1;
        low.index[axis] *= 2;
        high.halvings[axis] += 1;
        high.index[axis] = low.index[axis] + 1;
        [low, high]
    }

    /// Number of halvings in both directions.
    pub(super) fn count(self) -> usize {
        self.halvings.iter().map(|&n| usize::from(n)).sum()
    }

    /// This part of `outer` as a part of the square.
    pub(super) fn within(self, outer: Self) -> Self {
        let index = [0, 1].map(|k| (outer.index[k] << self.halvings[k]) + self.index[k]);
        Self { index, halvings: [0, 1].map(|k| outer.halvings[k] + self.halvings[k]) }
    }

    /// Its side lengths.
    #[inline(always)]
    pub(super) fn width(self) -> DVec2 {
        DVec2::new(power(self.halvings[0]), power(self.halvings[1]))
    }

    #[inline(always)]
    fn indices(self) -> DVec2 {
        DVec2::new(self.index[0].into(), self.index[1].into())
    }

    /// The point of the square at a point of the rectangle, both in [0, 1]^2.
    #[inline(always)]
    pub(super) fn at(self, x: DVec2) -> DVec2 {
        (self.indices() + x) * self.width()
    }

    /// Its centre, if the square is [-1, 1]^2; half its sides are then its [width](Self::width).
    #[inline(always)]
    pub(super) fn middle(self) -> DVec2 {
        (2.0 * self.indices() + 1.0) * self.width() - 1.0
    }

    /// The rectangle in floating point.
    pub(super) fn rect(self) -> ParameterRect {
        let (low, high) = (self.at(DVec2::ZERO), self.at(DVec2::ONE));
        ParameterRect { u: [low.x, high.x], v: [low.y, high.y] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_cover_the_part() {
        let mut part = DyadicRect::WHOLE;
        for (across_u, upper) in [(true, true), (false, false), (true, false), (true, true), (false, true)] {
            let [low, high] = part.halves(across_u);
            assert_eq!(low.at(DVec2::ZERO), part.at(DVec2::ZERO));
            assert_eq!(high.at(DVec2::ONE), part.at(DVec2::ONE));
            assert_eq!(low.width(), high.width());
            assert_eq!(
                part.at(DVec2::splat(0.5)),
                if across_u { high.at(DVec2::new(0.0, 0.5)) } else { high.at(DVec2::new(0.5, 0.0)) }
            );
            part = if upper { high } else { low };
        }
        // u: upper, lower, upper of eighths; v: lower, upper of quarters.
        assert_eq!(part.rect(), ParameterRect { u: [0.625, 0.75], v: [0.25, 0.5] });
        assert_eq!(part.middle(), DVec2::new(2.0 * 0.6875 - 1.0, -0.25));
        assert_eq!(part.count(), 5);
        assert_eq!(DyadicRect::WHOLE.halves(true)[1].within(part), part.halves(true)[1]);
        assert_eq!(part.within(DyadicRect::WHOLE), part);
    }

    #[test]
    fn sixteen_halvings_are_exact() {
        let part = (0..16).fold(DyadicRect::WHOLE, |p, _| p.halves(false)[1]);
        assert_eq!(part.rect(), ParameterRect { u: [0.0, 1.0], v: [1.0 - 0.5_f64.powi(16), 1.0] });
    }
}
