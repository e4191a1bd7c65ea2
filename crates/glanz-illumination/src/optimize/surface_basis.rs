//! Freeform surfaces as linear functions of their control points.

use glanz_geometry::bezier::Barycentric;
use glanz_geometry::spline::KnotVector;
use glanz_geometry::spline::basis::BasisFunctions;
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{GeometryDescription, ShapeDescription};

/// A part of a freeform surface over the unit square, or over the triangle of points (u, v) with u + v <= 1. The weights of its control points are constant, so that the
/// position and the tangents at fixed parameters are linear in the points.
#[derive(Clone, Debug)]
pub(super) struct SurfaceBasis {
    functions: BasisKind,
    /// Index of the first control point of the part among those of the shape.
    first: usize,
    /// Control points in the world, with their weights.
    points: Vec<(DVec3, f64)>,
}

#[derive(Clone, Debug)]
enum BasisKind {
    Tensor { u: KnotVector, v: KnotVector, domain: [[f64; 2]; 2] },
    Triangle { degree: usize },
}

/// The factors of one control point in the position and both tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PointFactors {
    /// Index of the control point in the shape.
    pub(super) point: usize,
    pub(super) position: f64,
    pub(super) tangents: [f64; 2],
}

/// Position and both tangents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LocalFrame {
    pub(super) position: DVec3,
    pub(super) tangents: [DVec3; 2],
}

impl SurfaceBasis {
    /// The parts of a freeform shape of the world, those of a spline between its jumps; `None` for another shape, a spline with control points
    /// that act nowhere, or one that no scene can have.
    pub(super) fn of_shape(shape: &ShapeDescription) -> Option<Vec<Self>> {
        let placed = |points: &[[f64; 4]]| -> Vec<(DVec3, f64)> {
            let place =
                |&[x, y, z, w]: &[f64; 4]| (shape.to_parent.transform_point3(DVec3::new(x, y, z) / w), w);
            points.iter().map(place).collect()
        };
        match &shape.geometry {
            GeometryDescription::Nurbs(nurbs) => {
                let u = KnotVector::try_with_jumps(nurbs.degree_u, nurbs.knots_u.clone()).ok()?;
                let v = KnotVector::try_with_jumps(nurbs.degree_v, nurbs.knots_v.clone()).ok()?;
                let [range_u, range_v] = nurbs.domain.unwrap_or([u.domain(), v.domain()]);
                let ranges_v = continuous_ranges(&v, range_v);
                let points = placed(&nurbs.points);
                let part = |domain| Self {
                    functions: BasisKind::Tensor { u: u.clone(), v: v.clone(), domain },
                    first: 0,
                    points: points.clone(),
                };
                let ranges_u = continuous_ranges(&u, range_u);
                Some(ranges_u.iter().flat_map(|&u| ranges_v.iter().map(move |&v| [u, v])).map(part).collect())
            }
            GeometryDescription::BezierPatches(patches) => {
                let knots = |degree: usize| {
                    KnotVector::try_new(degree, [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat()).ok()
                };
                let (u, v) = (knots(patches.degree_u)?, knots(patches.degree_v)?);
                let count = (patches.degree_u + 1) * (patches.degree_v + 1);
                let part = |(n, points): (usize, &Vec<[f64; 4]>)| Self {
                    functions: BasisKind::Tensor { u: u.clone(), v: v.clone(), domain: [[0.0, 1.0]; 2] },
                    first: n * count,
                    points: placed(points),
                };
                Some(patches.patches.iter().enumerate().map(part).collect())
            }
            GeometryDescription::BezierTriangles(triangles) => {
                let degree = triangles.degree;
                let count = (degree + 1) * (degree + 2) / 2;
                let part = |(n, points): (usize, &Vec<[f64; 4]>)| Self {
                    functions: BasisKind::Triangle { degree },
                    first: n * count,
                    points: placed(points),
                };
                Some(triangles.patches.iter().enumerate().map(part).collect())
            }
            _ => None,
        }
    }

    /// Whether the parameters fill the triangle u + v <= 1 instead of the square.
    pub(super) fn is_triangle(&self) -> bool {
        matches!(self.functions, BasisKind::Triangle { .. })
    }

    /// The factors of all control points that are not zero at a point of the domain.
    pub(super) fn factors(&self, at: DVec2) -> Vec<PointFactors> {
        let mut factors = match &self.functions {
            BasisKind::Tensor { u, v, domain } => tensor_factors(u, v, *domain, at),
            BasisKind::Triangle { degree } => triangle_factors(*degree, at),
        };
        // The functions times their weights over the sum of these products, by the quotient rule.
        let mut sums = [0.0; 3];
        for factor in &mut factors {
            let weight = self.points.get(factor.point).map_or(0.0, |point| point.1);
            factor.position *= weight;
            factor.tangents = factor.tangents.map(|tangent| tangent * weight);
            sums[0] += factor.position;
            sums[1] += factor.tangents[0];
            sums[2] += factor.tangents[1];
        }
        for factor in &mut factors {
            factor.position /= sums[0];
            let tangent = |k: usize| (factor.tangents[k] - factor.position * sums[k + 1]) / sums[0];
            factor.tangents = [tangent(0), tangent(1)];
        }
        factors
    }

    /// Position and tangents by the factors at a point.
    pub(super) fn frame(&self, factors: &[PointFactors]) -> LocalFrame {
        let mut frame = LocalFrame::default();
        for factor in factors {
            let point = self.points.get(factor.point).map_or(DVec3::ZERO, |point| point.0);
            frame.add(factor.position, factor.tangents, point);
        }
        frame
    }

    /// The factors with the indices of their points in the shape.
    pub(super) fn indexed(&self, factors: Vec<PointFactors>) -> impl Iterator<Item = PointFactors> {
        let first = self.first;
        factors.into_iter().map(move |factor| PointFactors { point: first + factor.point, ..factor })
    }
}

impl LocalFrame {
    /// Adds a vector with its factors.
    pub(super) fn add(&mut self, position: f64, tangents: [f64; 2], vector: DVec3) {
        self.position += position * vector;
        self.tangents[0] += tangents[0] * vector;
        self.tangents[1] += tangents[1] * vector;
    }
}

/// The parts of a range of parameters between the jumps of a spline, ascending. At a jump a spline has the point of the piece that starts there,
/// so that the piece before ends at the next smaller number.
fn continuous_ranges(knots: &KnotVector, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let jumps: Vec<f64> = knots.jumps().into_iter().map(|(knot, _)| knot).collect();
    let inside: Vec<f64> = jumps.iter().copied().filter(|&knot| knot > from && knot < to).collect();
    let starts = std::iter::once(from).chain(inside.iter().copied());
    let ends = inside.iter().copied().chain([to]);
    let before_jump = |end: f64| if jumps.contains(&end) { end.next_down() } else { end };
    starts.zip(ends).map(|(start, end)| [start, before_jump(end)]).collect()
}

fn tensor_factors(u: &KnotVector, v: &KnotVector, domain: [[f64; 2]; 2], at: DVec2) -> Vec<PointFactors> {
    let [[u0, u1], [v0, v1]] = domain;
    // Rounding must not reach the piece behind a jump.
    let along_u = BasisFunctions::at(u, (u0 + at.x * (u1 - u0)).min(u1));
    let along_v = BasisFunctions::at(v, (v0 + at.y * (v1 - v0)).min(v1));
    let ([bu, du], [bv, dv]) = (along_u.rows::<2>(), along_v.rows::<2>());
    let mut factors = Vec::with_capacity((u.degree() + 1) * (v.degree() + 1));
    for (i, (bu, du)) in bu.iter().zip(&du).take(u.degree() + 1).enumerate() {
        for (j, (bv, dv)) in bv.iter().zip(&dv).take(v.degree() + 1).enumerate() {
            factors.push(PointFactors {
                point: (along_u.first() + i) * v.count() + along_v.first() + j,
                position: bu * bv,
                tangents: [du * bv * (u1 - u0), bu * dv * (v1 - v0)],
            });
        }
    }
    factors
}

fn triangle_factors(degree: usize, at: DVec2) -> Vec<PointFactors> {
    let Barycentric { r, s, t } = Barycentric::from_parameters(at);
    let power = |x: f64, k: usize| x.powi(k as i32);
    // k x^(k - 1), which is 0 for k = 0.
    let slope = |x: f64, k: usize| k.checked_sub(1).map_or(0.0, |below| k as f64 * power(x, below));
    let factorial = |k: usize| (1..=k).map(|x| x as f64).product::<f64>();
    let mut factors = Vec::new();
    for i in (0..=degree).rev() {
        for j in (0..=degree - i).rev() {
            let k = degree - i - j;
            let count = factorial(degree) / (factorial(i) * factorial(j) * factorial(k));
            let [ri, sj, tk] = [power(r, i), power(s, j), power(t, k)];
            // u = s, v = t, r = 1 - u - v.
            let by_r = slope(r, i) * sj * tk;
            factors.push(PointFactors {
                point: factors.len(),
                position: count * ri * sj * tk,
                tangents: [count * (ri * slope(s, j) * tk - by_r), count * (ri * sj * slope(t, k) - by_r)],
            });
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
    use glanz_geometry::spline::NurbsSurface;
    use glanz_math::glam::DVec4;

    use super::*;

    /// Points in a disorder, with weights.
    fn points(count: usize) -> Vec<DVec4> {
        let point = |i: usize| {
            let x = i as f64;
            let weight = 1.0 + 0.3 * (x * 1.7).sin();
            (weight * DVec3::new((x * 0.9).cos() + x, (x * 1.3).sin(), (x * 2.1).cos())).extend(weight)
        };
        (0..count).map(point).collect()
    }

    fn assert_frames(shape: ShapeDescription, expected: impl Fn(f64, f64) -> (DVec3, DVec3, DVec3)) {
        let parts = SurfaceBasis::of_shape(&shape).unwrap();
        let part = parts.last().unwrap();
        for (u, v) in [(0.0, 0.0), (0.2, 0.7), (0.35, 0.1), (0.5, 0.5)] {
            let frame = part.frame(&part.factors(DVec2::new(u, v)));
            let (position, du, dv) = expected(u, v);
            assert!(frame.position.distance(position) < 1e-13, "{u} {v} {frame:?} {position}");
            assert!(
                frame.tangents[0].distance(du) < 1e-12 && frame.tangents[1].distance(dv) < 1e-12,
                "{u} {v}"
            );
        }
    }

    #[test]
    fn factors_give_the_points_and_tangents_of_the_surfaces_themselves() {
        let knots = || vec![0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0];
        let nurbs = NurbsSurface::try_new([2, 2], [knots(), knots()], points(16)).unwrap();
        assert_frames(ShapeDescription::nurbs(&nurbs), |u, v| nurbs.tangents(u, v));
        let patches = [
            TensorPatch::try_new(3, 2, points(12)).unwrap(),
            TensorPatch::try_new(3, 2, points(24)[12..].to_vec()).unwrap(),
        ];
        assert_frames(ShapeDescription::bezier_patches(&patches), |u, v| patches[1].point_and_tangents(u, v));
        let triangle = TrianglePatch::try_new(3, points(10)).unwrap();
        assert_frames(ShapeDescription::bezier_triangles(std::slice::from_ref(&triangle)), |u, v| {
            triangle.point_and_tangents(u, v)
        });
    }

    #[test]
    fn a_spline_that_jumps_has_a_part_on_each_side() {
        // Of degree 1: z = u from 0 to 1, and z = 4 + u from there to 2.
        let profile = [(0.0, 0.0), (1.0, 1.0), (1.0, 5.0), (2.0, 6.0)];
        let points = profile.into_iter().flat_map(|(x, z)| [0.0, 1.0].map(|y| DVec4::new(x, y, z, 1.0)));
        let knots = [vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
        let nurbs = NurbsSurface::try_new([1, 1], knots, points.collect()).unwrap();
        let parts = SurfaceBasis::of_shape(&ShapeDescription::nurbs(&nurbs)).unwrap();
        assert_eq!(parts.len(), 2);
        // A part that ends at the jump ends in front of it.
        assert_eq!(continuous_ranges(nurbs.knots_u(), [0.5, 1.0]), [[0.5, 1.0_f64.next_down()]]);
        for (part, start, end) in [(&parts[0], 0.0, 1.0), (&parts[1], 5.0, 6.0)] {
            for (u, z) in [(0.0, start), (0.5, 0.5 * (start + end)), (1.0, end)] {
                let frame = part.frame(&part.factors(DVec2::new(u, 0.5)));
                assert!((frame.position.z - z).abs() < 1e-14, "{u} {frame:?}");
                assert!((frame.tangents[0].z - 1.0).abs() < 1e-14, "{u} {frame:?}");
            }
        }
    }

    #[test]
    fn factors_are_the_derivatives_by_the_points() {
        let patch = |points: Vec<DVec4>| {
            ShapeDescription::bezier_patches(&[TensorPatch::try_new(2, 2, points).unwrap()])
        };
        let at = DVec2::new(0.3, 0.8);
        let frame = |points: Vec<DVec4>| {
            let basis = SurfaceBasis::of_shape(&patch(points)).unwrap().remove(0);
            basis.frame(&basis.factors(at))
        };
        let basis = SurfaceBasis::of_shape(&patch(points(9))).unwrap().remove(0);
        let before = frame(points(9));
        for factor in basis.indexed(basis.factors(at)) {
            // Linear: the step may be large.
            let mut moved = points(9);
            let weight = moved[factor.point].w;
            moved[factor.point].z += weight;
            let after = frame(moved);
            let close = |a: DVec3, b: DVec3, factor: f64| (a - b - factor * DVec3::Z).length() < 1e-13;
            assert!(close(after.position, before.position, factor.position));
            for k in 0..2 {
                assert!(close(after.tangents[k], before.tangents[k], factor.tangents[k]), "{factor:?}");
            }
        }
    }
}
