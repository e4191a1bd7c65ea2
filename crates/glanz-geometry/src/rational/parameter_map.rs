//! Parameters of a surface along the sides of its patches.

/// A parameter of a surface as a function of a parameter of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterMap {
    /// Values of the surface parameter at both ends of the patch.
    pub ends: [f64; 2],
    /// Its progress between them.
    pub reparameterization: Reparameterization,
}

/// An increasing function from [0, 1] to [0, 1] of the parameter x of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reparameterization {
    /// Equal to x.
    Linear,
    /// Proportional to the angle along a circular arc with this half angle, radians, below pi / 2.
    Circular(f64),
    /// Proportional to the hyperbolic angle along an arc of a hyperbola with this half angle.
    Hyperbolic(f64),
    /// Equal to `x + k x (x - 1)`, k in [0, 1].
    Quadratic(f64),
}

impl ParameterMap {
    /// The linear map from 0 to 1.
    pub const UNIT: Self = Self { ends: [0.0, 1.0], reparameterization: Reparameterization::Linear };

    /// The surface parameter at `x` in [0, 1].
    #[must_use]
    pub fn parameter(&self, x: f64) -> f64 {
        let [start, end] = self.ends;
        let fraction = self.reparameterization.fraction(x);
        start * (1.0 - fraction) + end * fraction
    }
}

impl Reparameterization {
    /// The value at `x` in [0, 1].
    ///
    /// On an arc of weights 1, c, 1, where c is the cosine (or hyperbolic cosine) of the half angle a, the sine and cosine of the
    /// angle from its middle are in proportion to `(2 x - 1) s` and `((1 - x)^2 + x^2) c + 2 x (1 - x)`, where s is the sine
    /// of a.
    #[must_use]
    pub fn fraction(self, x: f64) -> f64 {
        let cosine = |c: f64| ((1.0 - x) * (1.0 - x) + x * x) * c + 2.0 * x * (1.0 - x);
        let sine = |s: f64| (2.0 * x - 1.0) * s;
        match self {
            Self::Linear => x,
            Self::Circular(half) => 0.5 * (1.0 + sine(half.sin()).atan2(cosine(half.cos())) / half),
            Self::Hyperbolic(half) => 0.5 * (1.0 + (sine(half.sinh()) / cosine(half.cosh())).atanh() / half),
            Self::Quadratic(k) => x + k * x * (x - 1.0),
        }
    }
}
