//! How the parameter of a surface goes along a side of a patch.

/// The parameter of a surface along a side of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Along {
    /// At the two ends.
    pub ends: [f64; 2],
    /// How it goes between them.
    pub pace: Pace,
}

/// How a parameter goes from 0 to 1 while that of the patch, x, does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// As x.
    Proportional,
    /// As the angle along an arc of a circle with this half angle, radians, below pi / 2.
    Circular(f64),
    /// As the hyperbolic angle along an arc of a hyperbola of which this is half.
    Hyperbolic(f64),
    /// As `x + k x (x - 1)`, k in [0, 1].
    Quadratic(f64),
}

impl Along {
    /// In proportion from 0 to 1.
    pub const UNIT: Self = Self { ends: [0.0, 1.0], pace: Pace::Proportional };

    /// The parameter at `x` in [0, 1].
    #[must_use]
    pub fn parameter(&self, x: f64) -> f64 {
        let [start, end] = self.ends;
        let share = self.pace.share(x);
        start * (1.0 - share) + end * share
    }
}

impl Pace {
    /// How much of the way is behind at `x` in [0, 1].
    ///
    /// An arc of weights 1, c, 1 (c being the cosine of the half angle a, or its hyperbolic cosine) has sine and cosine of the angle from its middle in
    /// proportion to `(2 x - 1) s` and `((1 - x)^2 + x^2) c + 2 x (1 - x)`, with s the sine of a.
    #[must_use]
    pub fn share(self, x: f64) -> f64 {
        let cosine = |c: f64| ((1.0 - x) * (1.0 - x) + x * x) * c + 2.0 * x * (1.0 - x);
        let sine = |s: f64| (2.0 * x - 1.0) * s;
        match self {
            Self::Proportional => x,
            Self::Circular(half) => 0.5 * (1.0 + sine(half.sin()).atan2(cosine(half.cos())) / half),
            Self::Hyperbolic(half) => 0.5 * (1.0 + (sine(half.sinh()) / cosine(half.cosh())).atanh() / half),
            Self::Quadratic(k) => x + k * x * (x - 1.0),
        }
    }
}
