//! Evaluation of surfaces by face and parameters, for elements on surfaces and for data stored by parameters.
//!
//! Faces are numbered as in [`Hit::face`]: triangles of a mesh, facets of a polyhedron or a box, patches of a freeform surface; other
//! surfaces are one face. The parameters of a face are those of its hits, so that rays find the data stored at their hits.
//!
//! [`Hit::face`]: crate::Hit::face

use glanz_math::DVec2;

use crate::hit::SurfacePoint;
use crate::surface::Surface;

/// Parameter domain of a face.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceDomain {
    /// All of [0, 1]^2.
    Square,
    /// A convex polygon with these corners, in order.
    Polygon(Vec<DVec2>),
}

impl FaceDomain {
    /// Its corners, in order.
    #[must_use]
    pub fn corners(self) -> Vec<DVec2> {
        match self {
            Self::Square => vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
            Self::Polygon(corners) => corners,
        }
    }
}

/// A point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint {
    /// The surface at the point.
    pub point: SurfacePoint,
    /// Area per unit of the parameters, m^2; 0 where they degenerate.
    pub area_element: f64,
}

impl Surface {
    /// Number of faces; 0 if the surface is infinite or has no parameters.
    #[must_use]
    pub fn faces(&self) -> u32 {
        match self {
            Self::Algebraic(_) | Self::Curve(_) => 0,
            Self::Plane(plane) => u32::from(plane.area().is_finite()),
            Self::Cuboid(_) => 6,
            Self::Polyhedron(polyhedron) => polyhedron.facets().len() as u32,
            Self::Mesh(mesh) => mesh.indices().len() as u32,
            Self::Freeform(freeform) => freeform.patch_count() as u32,
            Self::Trimmed(trimmed) => trimmed.surface().faces(),
            _ => 1,
        }
    }

    /// The parameter domain of a face.
    #[must_use]
    pub fn face_domain(&self, face: u32) -> FaceDomain {
        match self {
            Self::Triangle(_) | Self::Mesh(_) => FaceDomain::Polygon(vec![DVec2::ZERO, DVec2::X, DVec2::Y]),
            Self::Polyhedron(polyhedron) => {
                FaceDomain::Polygon(polyhedron.facet_corners(face as usize).collect())
            }
            Self::Trimmed(trimmed) => trimmed.surface().face_domain(face),
            _ => FaceDomain::Square,
        }
    }

    /// The surface at parameters of a face; `None` where a trimming region cuts it away, and for faces from [`Surface::faces`] on.
    #[must_use]
    pub fn at(&self, face: u32, uv: DVec2) -> Option<FacePoint> {
        let DVec2 { x: u, y: v } = uv;
        let by_tangents = |point: SurfacePoint| {
            Some(FacePoint { point, area_element: point.dpdu.cross(point.dpdv).length() })
        };
        if face >= self.faces() {
            return None;
        }
        match self {
            Self::Sphere(s) => by_tangents(s.at(uv)),
            Self::Cylinder(s) => by_tangents(s.at(uv)),
            Self::Cone(s) => by_tangents(s.at(uv)),
            Self::Paraboloid(s) => by_tangents(s.at(uv)),
            Self::Hyperboloid(s) => by_tangents(s.at(uv)),
            Self::TwoSheetedHyperboloid(s) => by_tangents(s.at(uv)),
            Self::Disk(s) => by_tangents(s.at(uv)),
            Self::Plane(s) => by_tangents(s.at_parameters(uv)?),
            Self::Torus(s) => by_tangents(s.point_at(u, v)),
            Self::Bilinear(s) => by_tangents(s.point_at(u, v)),
            Self::Cuboid(s) => by_tangents(s.point_at(face, u, v)),
            Self::Polyhedron(s) => by_tangents(s.point_at(s.facets().get(face as usize)?, u, v)),
            Self::Triangle(s) => Some(FacePoint { point: s.point_at(u, v), area_element: 2.0 * s.area() }),
            Self::Mesh(s) => {
                Some(FacePoint { point: s.point_at(face, u, v), area_element: 2.0 * s.face_area(face) })
            }
            Self::Freeform(s) => {
                let point = s.point_at(face, u, v);
                s.keeps_parameters(point.uv)
                    .then(|| FacePoint { point, area_element: s.area_element_at(face, u, v) })
            }
            Self::Trimmed(s) => s.surface().at(face, uv).filter(|found| s.region().contains(found.point.uv)),
            Self::Algebraic(_) | Self::Curve(_) => None,
        }
    }

    /// As [`Surface::at`], including the parts that a trimming region cuts away.
    #[must_use]
    pub fn untrimmed_at(&self, face: u32, uv: DVec2) -> Option<SurfacePoint> {
        match self {
            Self::Trimmed(s) => s.surface().untrimmed_at(face, uv),
            Self::Freeform(s) => (face < self.faces()).then(|| s.point_at(face, uv.x, uv.y)),
            _ => self.at(face, uv).map(|at| at.point),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};
    use std::sync::Arc;

    use glanz_math::glam::DVec4;
    use glanz_math::{DVec3, Ray};

    use super::*;
    use crate::bezier::TensorPatch;
    use crate::bilinear::BilinearPatch;
    use crate::cuboid::Cuboid;
    use crate::freeform::{Freeform, SurfacePatch};
    use crate::mesh::Mesh;
    use crate::polyhedron::{HalfSpace, Polyhedron};
    use crate::quadric::{
        Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid,
    };
    use crate::surface::RaySurface;
    use crate::torus::Torus;
    use crate::triangle::Triangle;
    use crate::trim::{TrimCurve, TrimLoop, TrimRegion};

    fn mesh() -> Mesh {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::new(0.0, 2.0, 1.0)];
        let uvs = vec![DVec2::ZERO, DVec2::new(3.0, 0.0), DVec2::new(3.0, 7.0), DVec2::new(0.0, 7.0)];
        Mesh::try_new(positions, vec![[0, 1, 2], [0, 2, 3]], None, Some(uvs)).unwrap()
    }

    /// Two quarters of a cylinder of radius 1 and height 2, side by side over u in [0, 4] and v in [0, 3].
    fn two_quarters() -> Freeform {
        let half = 0.5_f64.sqrt();
        let quarter = |turn: DVec2, u: [f64; 2]| {
            let row = |p: DVec2, w: f64| {
                let p = turn.rotate(p);
                [0.0, 2.0].map(|z| DVec4::new(w * p.x, w * p.y, w * z, w))
            };
            let points =
                [row(DVec2::X, 1.0), row(DVec2::ONE, half), row(DVec2::Y, 1.0)].into_iter().flatten();
            let patch = TensorPatch::try_new(2, 1, points.collect()).unwrap();
            SurfacePatch::over_rectangle(patch, u, [0.0, 3.0]).unwrap()
        };
        Freeform::try_new(vec![quarter(DVec2::X, [0.0, 2.0]), quarter(DVec2::Y, [2.0, 4.0])]).unwrap()
    }

    fn rectangle(min: DVec2, max: DVec2) -> Arc<TrimRegion> {
        let curve = TrimCurve::try_rectangle(min, max).unwrap();
        let kept = TrimLoop::try_closed(curve, 1e-9).unwrap();
        Arc::new(TrimRegion::try_new(vec![kept], [DVec2::ZERO, DVec2::new(4.0, 3.0)]).unwrap())
    }

    /// Surfaces with their areas, where there is a closed form.
    fn surfaces() -> Vec<(Surface, Option<f64>)> {
        let facet = |normal, distance| HalfSpace { normal, distance };
        let octant = [-DVec3::X, -DVec3::Y, -DVec3::Z].map(|normal| facet(normal, 0.0));
        let corner = [octant.as_slice(), &[facet(DVec3::ONE.normalize(), 1.0 / 3.0_f64.sqrt())]].concat();
        let quarter_of_area = rectangle(DVec2::new(1.0, 0.0), DVec2::new(3.0, 1.5));
        let upper = TrimRegion::try_new(
            vec![
                TrimLoop::try_closed(
                    TrimCurve::try_rectangle(DVec2::new(0.0, 0.5), DVec2::ONE).unwrap(),
                    1e-9,
                )
                .unwrap(),
            ],
            [DVec2::ZERO, DVec2::ONE],
        );
        vec![
            (Sphere::try_new(1.5, [-0.5, 1.5], 5.0).unwrap().into(), Some(5.0 * 1.5 * 2.0)),
            (Cylinder::try_new(0.5, [0.0, 2.0], TAU).unwrap().into(), Some(2.0 * PI)),
            (Cone::try_new(1.0, 2.0, TAU).unwrap().into(), Some(PI * 5.0_f64.sqrt())),
            (Paraboloid::try_new(1.0, [0.2, 1.0], TAU).unwrap().into(), None),
            (Hyperboloid::try_new(DVec3::X, DVec3::new(0.0, 2.0, 1.0), TAU).unwrap().into(), None),
            (TwoSheetedHyperboloid::try_new(0.7, 0.5, [-1.0, 2.0], TAU).unwrap().into(), None),
            (Disk::try_new(0.3, 2.0, 0.5, 4.0).unwrap().into(), Some(2.0 * (4.0 - 0.25))),
            (Plane::try_new([-1.0, 3.0], [0.0, 2.0]).unwrap().into(), Some(8.0)),
            (Torus::try_new(2.0, 0.5, TAU).unwrap().into(), Some(4.0 * PI * PI)),
            (Cuboid::try_new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).unwrap().into(), Some(22.0)),
            (Polyhedron::try_new(&corner).unwrap().into(), Some(1.5 + 0.5 * 3.0_f64.sqrt())),
            (
                BilinearPatch::try_new(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5))
                    .unwrap()
                    .into(),
                None,
            ),
            (
                Triangle::try_new(DVec3::ZERO, DVec3::X * 2.0, DVec3::new(0.5, 3.0, 0.0)).unwrap().into(),
                Some(3.0),
            ),
            (
                mesh().into(),
                Some(1.0 + 0.5 * (DVec3::new(1.0, 2.0, 0.0).cross(DVec3::new(0.0, 2.0, 1.0))).length()),
            ),
            (two_quarters().into(), Some(2.0 * PI)),
            (Surface::from(two_quarters()).trimmed(quarter_of_area), Some(0.5 * PI)),
            (
                Surface::from(Cylinder::try_new(0.5, [0.0, 2.0], TAU).unwrap())
                    .trimmed(Arc::new(upper.unwrap())),
                Some(PI),
            ),
        ]
    }

    /// Corners of triangles that fill the domain.
    fn triangles(domain: &FaceDomain) -> Vec<[DVec2; 3]> {
        let corners = match domain {
            FaceDomain::Square => vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
            FaceDomain::Polygon(corners) => corners.clone(),
        };
        corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]).collect()
    }

    #[test]
    fn parameters_of_a_hit_evaluate_to_its_point() {
        let direction = |i: u32| {
            let (a, z) = (f64::from(i) * 2.399_963, f64::from(i % 211) / 105.5 - 1.0);
            let r = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(r * a.cos(), r * a.sin(), z)
        };
        for (surface, _) in surfaces() {
            let bounds = surface.bounds();
            let (center, size) = (bounds.center(), bounds.diagonal().length());
            let mut found = 0;
            for i in 0..2000 {
                let from = center + direction(i) * size;
                let ray = Ray::new(from, (center + direction(7 * i + 3) * 0.4 * size - from).normalize());
                let mut hits = Vec::new();
                surface.all_hits(&ray, f64::INFINITY, &mut hits);
                for hit in hits {
                    let there = surface.point(&ray, &hit);
                    let here = surface.at(hit.face, DVec2::new(hit.u, hit.v)).unwrap().point;
                    let apart = here.position.distance(there.position);
                    assert!(apart < 1e-9 * size, "{}: {hit:?} is {apart} m away", surface.kind());
                    assert!(here.normal.dot(there.normal) > 1.0 - 1e-9, "{}: {hit:?}", surface.kind());
                    assert!(here.uv.distance(there.uv) < 1e-9);
                    found += 1;
                }
            }
            assert!(found > 100, "{}: {found}", surface.kind());
        }
    }

    #[test]
    fn area_elements_add_up_to_the_area() {
        for (surface, area) in surfaces() {
            let mut sum = 0.0;
            for face in 0..surface.faces() {
                for [a, b, c] in triangles(&surface.face_domain(face)) {
                    // The midpoint rule on n^2 triangles.
                    let n = 200;
                    let (x, y) = ((b - a) / f64::from(n), (c - a) / f64::from(n));
                    let element = 0.5 * x.perp_dot(y).abs();
                    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
                        let corner = a + x * f64::from(i) + y * f64::from(j);
                        let upper = (i + j + 1 < n).then_some(corner + (x + y) * (2.0 / 3.0));
                        for uv in [Some(corner + (x + y) / 3.0), upper].into_iter().flatten() {
                            sum += surface.at(face, uv).map_or(0.0, |at| at.area_element) * element;
                        }
                    }
                }
            }
            // Surfaces that can be sampled state their area as the mean of one over the density.
            let expected = area.unwrap_or_else(|| {
                let n = 400;
                let one = |i: u32| {
                    let xi = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
                    1.0 / surface.sample(xi).unwrap().pdf.0
                };
                (0..n * n).map(one).sum::<f64>() / f64::from(n * n)
            });
            assert!((sum - expected).abs() < 2e-3 * expected, "{}: {sum} {expected}", surface.kind());
        }
    }

    #[test]
    fn missing_faces_have_no_points() {
        let plane = Surface::from(Plane::infinite());
        assert_eq!((plane.faces(), plane.at(0, DVec2::ZERO)), (0, None));
        let cuboid = Surface::from(Cuboid::try_new(DVec3::ZERO, DVec3::ONE).unwrap());
        assert!(cuboid.at(5, DVec2::ONE).is_some() && cuboid.at(6, DVec2::ONE).is_none());
        let trimmed = Surface::from(two_quarters()).trimmed(rectangle(DVec2::ONE, DVec2::splat(2.0)));
        // Parameters 1.5 and 0.75, of which the first is kept.
        assert!(trimmed.at(0, DVec2::new(0.75, 0.5)).is_some());
        assert!(trimmed.at(0, DVec2::new(0.375, 0.5)).is_none());
        let whole = Surface::from(two_quarters()).at(0, DVec2::new(0.375, 0.5)).unwrap().point;
        assert_eq!(trimmed.untrimmed_at(0, DVec2::new(0.375, 0.5)), Some(whole));
        assert_eq!(trimmed.untrimmed_at(2, DVec2::ONE), None);
    }
}
