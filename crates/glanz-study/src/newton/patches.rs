//! The patches of the study.

use glanz_formats::newell;
use glanz_geometry::SurfaceError;
use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec2, DVec3, Ray};

use super::evaluate::{CubicTriangle, FixedBicubic, Linear};
use super::hull::Hull;
use super::iteration::{Jacobian, NonlinearSystem};
use crate::study::StudyError;

/// Control points of document 000 section 4.3 in the order 300, 210, 201, 120, 111, 102, 030, 021, 012, 003.
pub(crate) const TRUE_POINTS: [[f64; 3]; 10] = [
    [6.0, 3.0, 5.0],
    [6.0, 4.0, 8.0],
    [5.0, 3.0, 6.0],
    [6.0, 5.0, 6.0],
    [4.5, 4.5, 7.0],
    [4.0, 3.0, 6.0],
    [6.0, 6.0, 5.0],
    [5.0, 5.0, 6.0],
    [4.0, 4.0, 6.0],
    [3.0, 3.0, 3.0],
];

/// The same, each times i! j! k! / 6: the effective control points of the program of document 000, which omits the factors 3!/(i! j! k!).
pub(super) fn faulty_points() -> [[f64; 3]; 10] {
    let shares = [1.0, 3.0, 3.0, 3.0, 6.0, 3.0, 1.0, 3.0, 3.0, 1.0];
    std::array::from_fn(|i| TRUE_POINTS[i].map(|x| x / shares[i]))
}

/// The cubic triangle with these control points.
pub(super) fn reflector(points: [[f64; 3]; 10]) -> Result<Shape, SurfaceError> {
    let points = points.map(DVec3::from_array);
    Shape::triangle(TrianglePatch::try_from_points(3, &points, None)?)
}

/// A patch.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Tensor(TensorPatch, Box<FixedBicubic>),
    Triangle(TrianglePatch, Box<CubicTriangle>),
}

impl Shape {
    /// A bicubic patch.
    fn tensor(patch: TensorPatch) -> Result<Self, SurfaceError> {
        let fast = FixedBicubic::of(&patch).ok_or(not_cubic(patch.degrees().0))?;
        Ok(Self::Tensor(patch, Box::new(fast)))
    }

    /// A polynomial cubic triangle.
    fn triangle(patch: TrianglePatch) -> Result<Self, SurfaceError> {
        let fast = CubicTriangle::of(&patch).ok_or(not_cubic(patch.degree()))?;
        Ok(Self::Triangle(patch, Box::new(fast)))
    }

    fn point(&self, u: f64, v: f64) -> DVec3 {
        match self {
            Self::Tensor(_, fast) => fast.point(u, v),
            Self::Triangle(_, fast) => fast.point(u, v),
        }
    }

    fn linear(&self, u: f64, v: f64) -> Linear {
        match self {
            Self::Tensor(_, fast) => fast.linear(u, v),
            Self::Triangle(_, fast) => fast.linear(u, v),
        }
    }

    /// Control points, metres.
    pub(super) fn points(&self) -> Vec<DVec3> {
        let homogeneous = match self {
            Self::Tensor(patch, _) => patch.control_points(),
            Self::Triangle(patch, _) => patch.control_points(),
        };
        homogeneous.iter().map(|p| p.truncate() / p.w).collect()
    }

    /// Distance of (u, v) from the domain, 0 inside.
    pub(super) fn outside(&self, u: f64, v: f64) -> f64 {
        match self {
            Self::Tensor(..) => [-u, u - 1.0, -v, v - 1.0].into_iter().fold(0.0, f64::max),
            Self::Triangle(..) => [-u, -v, u + v - 1.0].into_iter().fold(0.0, f64::max),
        }
    }

    fn pieces(&self) -> Result<Vec<SurfacePatch>, SurfaceError> {
        match self {
            Self::Tensor(patch, _) => {
                Ok(vec![SurfacePatch::over_rectangle(patch.clone(), [0.0, 1.0], [0.0, 1.0])?])
            }
            Self::Triangle(patch, _) => {
                patch.to_quads().into_iter().map(|q| SurfacePatch::over_quad(q.patch, q.corners)).collect()
            }
        }
    }

    /// Middle of the flat patch between the corners and its directions by u and v; for the triangle the corner u = v = 0.
    fn flat(&self) -> (DVec3, DVec3, DVec3) {
        let [a, b, c] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(u, v)| self.point(u, v));
        match self {
            Self::Triangle(..) => (a, b - a, c - a),
            Self::Tensor(..) => {
                let d = self.point(1.0, 1.0);
                (0.25 * (a + b + c + d), 0.5 * (b - a + d - c), 0.5 * (c - a + d - b))
            }
        }
    }
}

fn not_cubic(degree: usize) -> SurfaceError {
    SurfaceError::OutOfRange { parameter: "degree", value: degree as f64, min: 3.0, max: 3.0 }
}

/// A patch with its search, hull and bounds.
pub(super) struct Target {
    pub(super) shape: Shape,
    pub(super) search: Freeform,
    hull: Hull,
    bounds: Bounds3,
}

impl Target {
    pub(super) fn try_new(shape: Shape) -> Result<Self, SurfaceError> {
        let points = shape.points();
        let search = Freeform::try_new(shape.pieces()?)?;
        Ok(Self { hull: Hull::of(&points), bounds: Bounds3::from_points(points), search, shape })
    }

    /// Diagonal of the box around the control points, metres.
    pub(super) fn size(&self) -> f64 {
        self.bounds.diagonal().length()
    }

    /// A ray from the sphere of twice the size around the patch to a point in the box, by five numbers in [0, 1).
    pub(super) fn ray(&self, xi: [f64; 5]) -> Ray {
        let z = 1.0 - 2.0 * xi[0];
        let (sin, cos) = (std::f64::consts::TAU * xi[1]).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let origin = self.bounds.center() + self.size() * DVec3::new(r * cos, r * sin, z);
        let to = self.bounds.min + self.bounds.diagonal() * DVec3::new(xi[2], xi[3], xi[4]);
        Ray::new(origin, (to - origin).normalize())
    }

    /// Where iterations start: (u, v) of the flat patch below the middle of the part of the ray within the hull, and the
    /// ray parameter of this middle; `None` if the ray misses the hull.
    ///
    /// # Source
    /// @pumberger2010 section 4.2 and function `konvhull`. Departures: the middle is projected onto the plane of the
    /// corners, not onto that of x and y, which may see the patch edge-on; starts are moved into the domain.
    pub(super) fn start(&self, ray: &Ray) -> Option<[f64; 3]> {
        let [near, far] = self.hull.clip(ray)?;
        let middle = 0.5 * (near + far);
        let (origin, a, b) = self.shape.flat();
        let d = ray.at(middle) - origin;
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let (ad, bd) = (a.dot(d), b.dot(d));
        let det = aa * bb - ab * ab;
        let flat = DVec2::new(ad * bb - bd * ab, bd * aa - ad * ab) / det;
        // Collinear corners determine no plane: the middle of the patch serves instead.
        let flat = if flat.is_finite() { flat } else { DVec2::ZERO };
        let at = match self.shape {
            Shape::Tensor(..) => (flat + 0.5).clamp(DVec2::ZERO, DVec2::ONE),
            Shape::Triangle(..) => {
                let inner = flat.max(DVec2::ZERO);
                inner / (inner.x + inner.y).max(1.0)
            }
        };
        Some([at.x, at.y, middle])
    }
}

/// Point of the patch less point of the ray, by (u, v, ray parameter): document 000 (4.9), corrected.
pub(super) struct RayPatchSystem<'a> {
    pub(super) shape: &'a Shape,
    pub(super) ray: Ray,
}

impl NonlinearSystem<3> for RayPatchSystem<'_> {
    fn linear(&self, &[u, v, t]: &[f64; 3]) -> ([f64; 3], Jacobian<3>) {
        let (point, by_u, by_v) = self.shape.linear(u, v);
        let d = self.ray.direction;
        let rows = [[by_u.x, by_v.x, -d.x], [by_u.y, by_v.y, -d.y], [by_u.z, by_v.z, -d.z]];
        ((point - self.ray.at(t)).to_array(), rows)
    }

    fn value(&self, &[u, v, t]: &[f64; 3]) -> [f64; 3] {
        (self.shape.point(u, v) - self.ray.at(t)).to_array()
    }
}

/// Patches of one kind.
pub(super) struct PatchGroup {
    pub(super) name: &'static str,
    pub(super) targets: Vec<Target>,
}

/// The cubic triangle of document 000, the Newell teapot's bicubic patches, an eighth of a sphere.
pub(super) fn groups() -> Result<[PatchGroup; 3], StudyError> {
    let mesh = newell::read(include_bytes!("../../scenes/newell_teapot.txt"))?;
    let corner = |index: &u32| mesh.positions.get(*index as usize).copied().unwrap_or_default();
    let teapot = mesh.patches.iter().map(|patch| {
        let points: Vec<DVec3> = patch.iter().map(corner).collect();
        Target::try_new(Shape::tensor(TensorPatch::try_from_points(3, 3, &points, None)?)?)
    });
    Ok([
        PatchGroup { name: "cubic triangle", targets: vec![Target::try_new(reflector(TRUE_POINTS)?)?] },
        PatchGroup { name: "teapot, 32 bicubic", targets: teapot.collect::<Result<_, SurfaceError>>()? },
        PatchGroup { name: "sphere octant, rational", targets: vec![Target::try_new(octant()?)?] },
    ])
}

/// An eighth of the unit sphere as a rational biquadratic patch, elevated to a bicubic one; its edge v = 1 is collapsed to
/// the pole.
fn octant() -> Result<Shape, SurfaceError> {
    let w = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter of the unit circle.
    let arc = [[1.0, 0.0, 1.0], [1.0, 1.0, w], [0.0, 1.0, 1.0]];
    let points = arc.iter().flat_map(|&[x, y, wu]| {
        arc.map(|[radius, z, wv]| DVec4::new(radius * x, radius * y, z, 1.0) * (wu * wv))
    });
    Shape::tensor(TensorPatch::try_new(2, 2, points.collect())?.elevated_u().elevated_v())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octant_lies_on_the_unit_sphere_and_ends_at_its_pole() {
        let shape = octant().unwrap();
        for i in 0..=10 {
            for j in 0..=10 {
                let p = shape.point(f64::from(i) / 10.0, f64::from(j) / 10.0);
                assert!((p.length() - 1.0).abs() < 1e-14 && p.min_element() > -1e-15);
            }
            assert!(shape.point(f64::from(i) / 10.0, 1.0).distance(DVec3::Z) < 1e-15);
        }
    }

    #[test]
    fn faulty_points_are_those_of_the_reference() {
        // The points 120, 111 and 102, computed independently.
        let points = faulty_points();
        for (p, expected) in [
            (points[3], [2.0, 1.666_666_666_666_666_7, 2.0]),
            (points[4], [0.75, 0.75, 1.166_666_666_666_666_7]),
            (points[5], [1.333_333_333_333_333_3, 1.0, 2.0]),
        ] {
            assert!(DVec3::from_array(p).distance(DVec3::from_array(expected)) < 1e-15);
        }
    }

    #[test]
    fn jacobian_is_that_of_differences() {
        for group in groups().unwrap() {
            for target in &group.targets {
                let ray = target.ray([0.3, 0.7, 0.4, 0.5, 0.6]);
                let meeting = RayPatchSystem { shape: &target.shape, ray };
                let at = [0.3, 0.4, 1.5 * target.size()];
                let (f, jacobian) = meeting.linear(&at);
                assert_eq!(f, meeting.value(&at));
                for j in 0..3 {
                    let h = 1e-6;
                    let moved = |by: f64| {
                        let mut x = at;
                        x[j] += by;
                        meeting.value(&x)
                    };
                    let (after, before) = (moved(h), moved(-h));
                    for i in 0..3 {
                        let slope = (after[i] - before[i]) / (2.0 * h);
                        assert!((slope - jacobian[i][j]).abs() < 1e-6 * target.size());
                    }
                }
            }
        }
    }

    #[test]
    fn every_ray_that_meets_a_patch_has_a_start_in_its_domain() {
        use glanz_geometry::RaySurface;
        for group in groups().unwrap() {
            for (k, target) in group.targets.iter().enumerate() {
                for i in 0..50 {
                    let x = |m: f64| (f64::from(i) * m + 0.1 * k as f64).fract();
                    let ray = target.ray([x(0.618), x(0.755), x(0.57), x(0.437), x(0.332)]);
                    let start = target.start(&ray);
                    assert!(start.is_some() || target.search.intersect(&ray, f64::INFINITY).is_none());
                    assert!(start.is_none_or(|[u, v, t]| target.shape.outside(u, v) < 1e-15 && t > 0.0));
                }
            }
        }
    }
}
