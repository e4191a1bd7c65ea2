//! Descriptions of surfaces under test that are independent of the code.

use glanz_geometry::RaySurface;
use glanz_math::{DVec2, DVec3};

/// An independent description of a surface under test.
pub struct ContractCase {
    /// Printed with each breach.
    pub name: String,
    /// The surface under test.
    pub surface: Box<dyn RaySurface>,
    /// A function that is zero exactly on the surface continued beyond its borders, with a change of sign across it; smooth
    /// wherever the surface is.
    pub implicit: Box<dyn Fn(DVec3) -> f64>,
    /// A function of points on the continued surface: positive on the kept part, negative on the clipped part. Its magnitude is a
    /// length in metres, at most about 10 times the distance to the border.
    pub kept: Box<dyn Fn(DVec3) -> f64>,
    /// Position at the texture coordinates, valid slightly beyond [0, 1] too. `None` if there are no texture coordinates.
    pub position: Option<Box<dyn Fn(DVec2) -> DVec3>>,
    /// Area in m^2 from a closed form; `None` if there is none.
    pub area: Option<f64>,
    /// Middle of a ball around the surface (around an interesting part of it, if it is infinite).
    pub center: DVec3,
    /// Radius of that ball, metres; every accuracy is relative to it.
    pub size: f64,
    /// Whether a line meets the continued surface at most twice and a ray that leaves on the side where `implicit` is
    /// positive cannot come back.
    pub convex: bool,
    /// Whether the surface can be sampled.
    pub samples: bool,
    /// Segments that adversarial rays aim at: edges, vertices and apices (both ends equal), seams, borders.
    pub targets: Vec<[DVec3; 2]>,
    /// Points where the surface has no tangent plane. Roots next to them need only be on surface and ray.
    pub singular: Vec<DVec3>,
    /// Segments along which the surface has no tangent plane: edges, lines of self-intersection; treated as `singular`.
    pub ridges: Vec<[DVec3; 2]>,
    /// Bound on the rounding error of `implicit` and of the function that the surface evaluates.
    pub noise: f64,
    /// Number of samples of a ray in the ball by the reference solver, which may miss three crossings between two samples.
    pub resolution: usize,
    /// Planes, as normal and offset, across which the gradient of `implicit` jumps: additional samples of the reference solver.
    pub kinks: Vec<(DVec3, f64)>,
    /// Further points where only the parameters degenerate; derivatives are not compared near them.
    pub parameter_singular: Vec<DVec3>,
    /// Special directions for adversarial rays: rulings, asymptotes.
    pub directions: Vec<DVec3>,
}

impl ContractCase {
    /// A closed surface in the unit ball; other fields are set with the `..` syntax.
    pub fn new(
        name: impl Into<String>,
        surface: impl RaySurface + 'static,
        implicit: impl Fn(DVec3) -> f64 + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            surface: Box::new(surface),
            implicit: Box::new(implicit),
            kept: Box::new(|_| f64::INFINITY),
            position: None,
            area: None,
            center: DVec3::ZERO,
            size: 1.0,
            convex: false,
            samples: true,
            targets: Vec::new(),
            singular: Vec::new(),
            ridges: Vec::new(),
            noise: 0.0,
            resolution: 48,
            kinks: Vec::new(),
            parameter_singular: Vec::new(),
            directions: Vec::new(),
        }
    }

    /// Distance of `p` from the nearest singular point.
    pub fn distance_to_singular(&self, p: DVec3) -> f64 {
        let to_ridge = |&[a, b]: &[DVec3; 2]| {
            let edge = b - a;
            let fraction = ((p - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            p.distance(a + edge * fraction)
        };
        let points = self.singular.iter().map(|&s| s.distance(p));
        points.chain(self.ridges.iter().map(to_ridge)).fold(f64::INFINITY, f64::min)
    }

    /// Distance of `p` from the nearest point where parameters degenerate, singular points included.
    pub fn distance_to_degenerate(&self, p: DVec3) -> f64 {
        let nearest = self.parameter_singular.iter().map(|&s| s.distance(p)).fold(f64::INFINITY, f64::min);
        nearest.min(self.distance_to_singular(p))
    }

    /// Gradient of the implicit function by differences.
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        let h = 1e-5 * self.size;
        let d = |axis: DVec3| ((self.implicit)(p + axis * h) - (self.implicit)(p - axis * h)) / (2.0 * h);
        DVec3::new(d(DVec3::X), d(DVec3::Y), d(DVec3::Z))
    }
}
