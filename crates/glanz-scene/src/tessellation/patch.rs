//! Surfaces over a rectangle or a triangle of parameters.

use std::sync::Arc;

use glanz_geometry::bezier::{TensorEdge, TensorPatch, TriangleEdge, TrianglePatch};
use glanz_geometry::spline::NurbsSurface;
use glanz_geometry::{Surface, SurfaceError};
use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3, Transform};

use super::TessellationFaultKind;
use super::patch_side::{PatchSide, inner_fractions};
use super::patch_trim::PatchTrim;
use crate::description::{GeometryDescription, NurbsDescription, ShapeDescription};
use crate::resolve::shape_surface;

/// A surface over a polygon of parameters, in the frame of its group.
pub(super) struct MeshPatch {
    /// Index of its shape in the group.
    pub(super) shape: usize,
    surface: PatchSurface,
    to_group: Transform,
    reversed: bool,
    /// Whether triangles that run counterclockwise in the parameters run clockwise as seen from the front.
    pub(super) flipped: bool,
    /// Corners of the parameters, counterclockwise: a rectangle from its smallest parameters on, or a triangle.
    pub(super) corners: Vec<DVec2>,
    /// The curves of its sides in the frame of the group, each from a corner to the next; `None` where a side has no control points.
    pub(super) sides: Vec<Option<PatchSide>>,
    pub(super) trim: Option<Arc<PatchTrim>>,
    /// Parameters between which it is smooth.
    pub(super) breaks: [Vec<f64>; 2],
    /// Range of each parameter of the whole surface.
    domain: [(f64, f64); 2],
    /// Whether both ends of each range are one line.
    periodic: [bool; 2],
}

enum PatchSurface {
    Analytic(Arc<Surface>, u32),
    Spline(NurbsSurface),
    Tensor(TensorPatch),
    Triangle(TrianglePatch),
}

/// A surface with the description of the shape that it is a part of.
struct PatchParts<'a> {
    shape: (usize, &'a ShapeDescription),
    to_group: Transform,
    trim: Option<Arc<PatchTrim>>,
}

impl MeshPatch {
    /// The patches of a shape that is not a triangle mesh or a polyhedron.
    pub(super) fn of_shape(
        number: usize,
        shape: &ShapeDescription,
    ) -> Result<Vec<Self>, TessellationFaultKind> {
        let invalid = |error: SurfaceError| TessellationFaultKind::Invalid(error.to_string());
        let to_group = Transform::try_from_matrix(shape.to_parent)
            .map_err(|error| TessellationFaultKind::Invalid(error.to_string()))?;
        let trim = shape.trim.as_ref().map(PatchTrim::try_new).transpose().map_err(invalid)?.map(Arc::new);
        let trimmed = trim.is_some();
        let parts = PatchParts { shape: (number, shape), to_group, trim };
        let tensor = |points: Vec<DVec4>, [degree_u, degree_v]: [usize; 2]| {
            TensorPatch::try_new(degree_u, degree_v, points).map(|patch| parts.tensor(patch)).map_err(invalid)
        };
        match &shape.geometry {
            GeometryDescription::Nurbs(nurbs) => {
                let pieces = spline(nurbs).and_then(|whole| whole.continuous_pieces()).map_err(invalid)?;
                if trimmed && pieces.len() > 1 {
                    return Err(TessellationFaultKind::Unsupported("a trimmed surface that jumps"));
                }
                Ok(pieces.into_iter().map(|piece| parts.spline(piece)).collect())
            }
            GeometryDescription::BezierPatches(patches) => {
                let degrees = [patches.degree_u, patches.degree_v];
                patches.patches.iter().map(|points| tensor(homogeneous(points), degrees)).collect()
            }
            GeometryDescription::BezierTriangles(patches) if !trimmed => {
                let triangle = |points: &Vec<[f64; 4]>| {
                    TrianglePatch::try_new(patches.degree, homogeneous(points))
                        .map(|patch| parts.triangle(patch))
                };
                patches.patches.iter().map(triangle).collect::<Result<_, _>>().map_err(invalid)
            }
            GeometryDescription::Bilinear { positions, indices } => {
                let corner = |&i: &u32| positions.get(i as usize).copied().unwrap_or(DVec3::NAN);
                indices
                    .iter()
                    .map(|[a, b, c, d]| tensor(bilinear([a, c, b, d].map(corner)), [1, 1]))
                    .collect()
            }
            GeometryDescription::Cuboid { min, max } if !trimmed => {
                box_faces(*min, *max).into_iter().map(|face| tensor(bilinear(face), [1, 1])).collect()
            }
            GeometryDescription::Algebraic { .. } => {
                Err(TessellationFaultKind::Unsupported("an algebraic surface"))
            }
            GeometryDescription::Curve { .. } => Err(TessellationFaultKind::Unsupported("a curve")),
            GeometryDescription::Plane { x, y }
                if [x, y].iter().any(|range| !(range[1] - range[0]).is_finite()) =>
            {
                Err(TessellationFaultKind::Infinite)
            }
            GeometryDescription::BezierTriangles(_)
            | GeometryDescription::Triangles { .. }
            | GeometryDescription::Polyhedron { .. }
                if trimmed =>
            {
                Err(TessellationFaultKind::Unsupported("a trimmed shape of triangles or polygons"))
            }
            GeometryDescription::TwoSheetedHyperboloid { z: [low, high], .. }
                if *low < 0.0 && *high > 0.0 =>
            {
                Err(TessellationFaultKind::Unsupported("a hyperboloid with both sheets"))
            }
            analytic => {
                let surface = Arc::new(shape_surface(analytic.clone(), None).map_err(invalid)?);
                Ok((0..surface.faces()).map(|face| parts.analytic(Arc::clone(&surface), face)).collect())
            }
        }
    }

    /// Whether the surface has these parameters, without its periods.
    pub(super) fn has(&self, uv: DVec2) -> bool {
        [0, 1].into_iter().all(|axis| (self.domain[axis].0..=self.domain[axis].1).contains(&uv[axis]))
    }

    /// Parameters inside the domain of the surface, moved by its periods.
    fn home(&self, uv: DVec2) -> DVec2 {
        let mut moved = uv;
        for (axis, &(low, high)) in self.domain.iter().enumerate() {
            if uv[axis] < low || uv[axis] > high {
                moved[axis] = if self.periodic[axis] {
                    low + (uv[axis] - low).rem_euclid(high - low)
                } else {
                    uv[axis].clamp(low, high)
                };
            }
        }
        moved
    }

    /// The point at `uv`; that of the nearest parameters where the surface has none.
    pub(super) fn point(&self, uv: DVec2) -> DVec3 {
        let uv = self.home(uv);
        let point = match &self.surface {
            PatchSurface::Analytic(surface, face) => {
                surface.untrimmed_at(*face, uv).map_or(DVec3::NAN, |at| at.position)
            }
            PatchSurface::Spline(spline) => spline.point(uv.x, uv.y),
            PatchSurface::Tensor(patch) => patch.point(uv.x, uv.y),
            PatchSurface::Triangle(patch) => patch.point(uv.x, uv.y),
        };
        self.to_group.point(point)
    }

    /// The unit normal on the front; zero where there is none.
    pub(super) fn normal(&self, uv: DVec2) -> DVec3 {
        let uv = self.home(uv);
        let normal = match &self.surface {
            PatchSurface::Analytic(surface, face) => surface.untrimmed_at(*face, uv).map(|at| at.normal),
            PatchSurface::Spline(spline) => spline.normal(uv.x, uv.y),
            PatchSurface::Tensor(patch) => patch.normal(uv.x, uv.y),
            PatchSurface::Triangle(patch) => patch.normal(uv.x, uv.y),
        };
        let normal = normal.map_or(DVec3::ZERO, |normal| self.to_group.normal(normal)).normalize_or_zero();
        if self.reversed { -normal } else { normal }
    }

    /// Corners of a box around the parameters.
    pub(super) fn window(&self) -> [DVec2; 2] {
        let fold = |pick: fn(DVec2, DVec2) -> DVec2| self.corners.iter().copied().reduce(pick);
        [fold(DVec2::min).unwrap_or(DVec2::ZERO), fold(DVec2::max).unwrap_or(DVec2::ONE)]
    }

    /// How often the boundary goes around a point that is not near it, from 1 on inside.
    pub(super) fn winding(&self, uv: DVec2) -> i32 {
        let Some(trim) = &self.trim else { return 1 };
        let curves = trim.loops.iter().flatten();
        let around: i32 = curves
            .map(|curve| {
                let points: Vec<DVec2> = curve.places().into_iter().map(|t| curve.at(t)).collect();
                let crossings = points.windows(2).filter(|pair| (pair[0].y > uv.y) != (pair[1].y > uv.y));
                let signs = crossings.map(|pair| {
                    let on_left = (pair[1] - pair[0]).perp_dot(uv - pair[0]) > 0.0;
                    match (pair[1].y > pair[0].y, on_left) {
                        (true, true) => 1,
                        (false, false) => -1,
                        _ => 0,
                    }
                });
                signs.sum::<i32>()
            })
            .sum();
        around + trim.region.outermost()
    }

    /// The same patch, with the axes that close.
    fn with_periods(mut self) -> Self {
        /// Part of the size of the surface below which points are the same.
        const SAME: f64 = 1e-7;
        let at = |axis: usize, across: f64, along: f64| {
            let mut t = DVec2::splat(along);
            t[axis] = across;
            let [(u0, u1), (v0, v1)] = self.domain;
            self.point(DVec2::new(u0 + (u1 - u0) * t.x, v0 + (v1 - v0) * t.y))
        };
        self.periodic = [0, 1].map(|axis| {
            let gap = |along: f64| at(axis, 0.0, along).distance(at(axis, 1.0, along));
            let size = |along: f64| at(axis, 0.0, along).distance(at(axis, 0.5, along));
            let places = [0.1, 0.37, 0.71];
            let largest = places.into_iter().map(size).fold(0.0, f64::max);
            places.into_iter().all(|along| gap(along) <= SAME * largest)
        });
        self
    }

    /// The same patch, with the side on which its triangles run counterclockwise.
    fn oriented(mut self) -> Self {
        /// Places inside the window that are not on a line of symmetry.
        const PLACES: [[f64; 2]; 4] = [[0.31, 0.27], [0.67, 0.71], [0.23, 0.64], [0.48, 0.12]];
        /// Step of the differences, a part of the window.
        const STEP: f64 = 1e-3;
        let [low, high] = self.window();
        let size = high - low;
        let side = |place: [f64; 2]| {
            let at = low + size * DVec2::from_array(place);
            let [du, dv] = [DVec2::X, DVec2::Y].map(|axis| {
                let step = size * axis * STEP;
                self.point(at + step) - self.point(at - step)
            });
            let area = du.cross(dv);
            area.normalize_or_zero().dot(self.normal(at))
        };
        self.flipped = PLACES.into_iter().map(side).sum::<f64>() < 0.0;
        self
    }
}

impl PatchParts<'_> {
    fn patch(&self, surface: PatchSurface, corners: Vec<DVec2>, sides: Vec<Option<PatchSide>>) -> MeshPatch {
        let (breaks, domain) = match &surface {
            PatchSurface::Spline(spline) => {
                let knots = [spline.knots_u(), spline.knots_v()];
                (knots.map(|knots| knots.breaks()), knots.map(|knots| knots.domain().into()))
            }
            _ => (Default::default(), [(0.0, 1.0); 2]),
        };
        MeshPatch {
            shape: self.shape.0,
            surface,
            to_group: self.to_group,
            reversed: self.shape.1.reverse_orientation,
            flipped: false,
            corners,
            sides: sides.into_iter().map(|side| side.map(|side| side.moved(&self.to_group))).collect(),
            trim: self.trim.clone(),
            breaks,
            domain,
            periodic: [false; 2],
        }
        .with_periods()
        .oriented()
    }

    /// Corners of the part of a domain in which curves count.
    fn rectangle(&self, [low, high]: [DVec2; 2]) -> Vec<DVec2> {
        let domain = self.trim.as_ref().and_then(|trim| trim.domain);
        let [low, high] = domain.map_or([low, high], |[a, b]| [low.max(a), high.min(b)]);
        vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
    }

    fn analytic(&self, surface: Arc<Surface>, face: u32) -> MeshPatch {
        let corners = self.rectangle([DVec2::ZERO, DVec2::ONE]);
        self.patch(PatchSurface::Analytic(surface, face), corners, vec![None; 4])
    }

    fn spline(&self, spline: NurbsSurface) -> MeshPatch {
        let (knots_u, knots_v) = (spline.knots_u(), spline.knots_v());
        let ([u0, u1], [v0, v1]) = (knots_u.domain(), knots_v.domain());
        let whole = [DVec2::new(u0, v0), DVec2::new(u1, v1)];
        let corners = self.rectangle(whole);
        let clamped = knots_u.is_clamped() && knots_v.is_clamped();
        let (count_u, count_v) = spline.counts();
        let points = spline.control_points();
        let at = |i: usize, j: usize| points.get(i * count_v + j).copied().unwrap_or(DVec4::NAN);
        let (last_u, last_v) = (count_u.saturating_sub(1), count_v.saturating_sub(1));
        let recognisable = clamped && self.trim.is_none();
        let (ahead_u, ahead_v) = (inner_fractions(knots_u), inner_fractions(knots_v));
        let sides: Vec<Option<PatchSide>> = [
            PatchSide::new((0..count_u).map(|i| at(i, 0)), ahead_u.clone()),
            PatchSide::new((0..count_v).map(|j| at(last_u, j)), ahead_v.clone()),
            PatchSide::new((0..count_u).map(|i| at(i, last_v)), ahead_u).reversed(),
            PatchSide::new((0..count_v).map(|j| at(0, j)), ahead_v).reversed(),
        ]
        .into_iter()
        .map(|side| recognisable.then_some(side))
        .collect();
        self.patch(PatchSurface::Spline(spline), corners, sides)
    }

    fn tensor(&self, patch: TensorPatch) -> MeshPatch {
        let corners = self.rectangle([DVec2::ZERO, DVec2::ONE]);
        let edges = [TensorEdge::VZero, TensorEdge::UOne, TensorEdge::VOne, TensorEdge::UZero];
        let sides =
            edges.map(|edge| self.trim.is_none().then(|| PatchSide::new(patch.edge(edge), Vec::new())));
        self.patch(PatchSurface::Tensor(patch), corners, sides.to_vec())
    }

    fn triangle(&self, patch: TrianglePatch) -> MeshPatch {
        let corners = vec![DVec2::ZERO, DVec2::X, DVec2::Y];
        let edges = [TriangleEdge::TZero, TriangleEdge::RZero, TriangleEdge::SZero];
        let sides = edges.map(|edge| Some(PatchSide::new(patch.edge(edge), Vec::new())));
        self.patch(PatchSurface::Triangle(patch), corners, sides.to_vec())
    }
}

fn homogeneous(points: &[[f64; 4]]) -> Vec<DVec4> {
    points.iter().copied().map(DVec4::from_array).collect()
}

fn spline(nurbs: &NurbsDescription) -> Result<NurbsSurface, SurfaceError> {
    let NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain } = nurbs;
    let surface = NurbsSurface::try_new(
        [*degree_u, *degree_v],
        [knots_u.clone(), knots_v.clone()],
        homogeneous(points),
    )?;
    domain.map_or(Ok(surface.clone()), |domain| surface.restrict(domain))
}

/// Control points of a bilinear patch from its corners at (0, 0), (0, 1), (1, 0) and (1, 1).
fn bilinear(corners: [DVec3; 4]) -> Vec<DVec4> {
    corners.into_iter().map(|corner| corner.extend(1.0)).collect()
}

/// The corners of the sides of a box at (0, 0), (0, 1), (1, 0) and (1, 1), with normals outwards.
fn box_faces(min: DVec3, max: DVec3) -> [[DVec3; 4]; 6] {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let sides = [[0, 1, 2, 3], [4, 6, 5, 7], [0, 4, 1, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 5, 3, 7]];
    sides.map(|side| side.map(corner))
}
