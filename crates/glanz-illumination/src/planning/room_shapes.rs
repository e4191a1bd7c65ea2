//! Shapes of a scene as the parts of a room: planes, borders, reflectances.

use std::collections::BTreeMap;

use glanz_geometry::FaceDomain;
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};

use super::plan_outline::{NEAR, ShapeOutline, face_points, samples};
use crate::receiver::{face_corners, holds, middle, signed_area};

/// Largest number of faces that are looked at one by one; surfaces beyond are boxes.
const MOST_FACES: usize = 1 << 18;

/// Largest number of planes of a shape. Of one with more, which is curved, planes of the largest faces are parts if they are large.
const MOST_PLANES: usize = 64;

/// Least area of a plane of a curved shape, as a share of that of the shape: twice that of equal faces, but no less than `LEAST_LARGE`.
const LARGE: f64 = 2.0;
const LEAST_LARGE: f64 = 0.01;

/// Least cosine between the normals of faces of one plane; their corners decide, as small faces with rounded corners are turned by some degrees.
const PARALLEL: f64 = 0.9;

/// Points along each side of a face by which it is tested for flatness.
const TEST_POINTS: u32 = 5;

/// Points along each side of a face at which its reflectance is sampled, and the largest number of points of a part with several faces, apart from one for each.
const REFLECTANCE_POINTS: u32 = 8;
const MOST_REFLECTANCE_POINTS: usize = 4096;

/// Largest number of shapes that are tested for covering others, and of the polygons of one of them.
const MOST_COVERS: usize = 1024;

/// Largest number of edges that are divided where corners of others lie on them.
const MOST_DIVIDED: usize = 512;

/// The address of a surface, and the number of one of its shapes if it has faces.
pub(super) type ShapeKey = (*const (), Option<u32>);

/// A shape of the scene, or the part of it in one plane.
pub(super) struct RoomShape<'a> {
    pub(super) surface: &'a PlacedSurface<'a>,
    /// Its faces; none for the whole surface.
    faces: Vec<u32>,
    pub(super) outline: ShapeOutline,
}

impl<'a> RoomShape<'a> {
    /// The parts of all finite shapes that light does not pass.
    pub(super) fn all(placed: &'a [PlacedSurface<'a>]) -> Vec<Self> {
        let (mut shapes, mut left) = (Vec::new(), MOST_FACES);
        let mut surfaces: Vec<_> = placed.iter().filter(|surface| !surface.is_passable()).collect();
        // A few large meshes are not to hide that the others form a room.
        surfaces.sort_by_key(|surface| surface.faces());
        for surface in surfaces {
            let bounds = surface.bounds();
            let count = surface.faces() as usize;
            let mut parts: Vec<Vec<u32>> = Vec::new();
            if count == 0 || count > left {
                parts.push(Vec::new());
            } else if bounds.is_finite() {
                left -= count;
                // Joined meshes are one surface.
                let mut by_shape: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
                for face in 0..surface.faces() {
                    by_shape.entry(surface.shape(face)).or_default().push(face);
                }
                let extent = (bounds.max - bounds.min).length();
                parts.extend(by_shape.into_values().flat_map(|faces| by_plane(surface, faces, extent)));
            }
            shapes.extend(parts.into_iter().filter_map(|faces| {
                let outline = ShapeOutline::of(surface, &faces)?;
                Some(Self { surface, faces, outline })
            }));
        }
        shapes
    }

    /// The shape that it is a part of.
    pub(super) fn key(&self) -> ShapeKey {
        let surface = std::ptr::from_ref(self.surface).cast();
        (surface, self.faces.first().map(|&face| self.surface.shape(face)))
    }

    /// Its area, m^2.
    pub(super) fn area(&self) -> f64 {
        let each = |face: u32| match face_corners(self.surface, face) {
            Some(_) => flat_area(&face_points(self.surface, face, 2)),
            None => self.surface.area(face..face + 1).unwrap_or(0.0),
        };
        if self.faces.is_empty() {
            return self.surface.area(0..self.surface.faces()).unwrap_or(0.0);
        }
        self.faces.iter().map(|&face| each(face)).sum()
    }

    /// Width of a rectangle with its area and perimeter, which also has the width of a ring, metres; of a level shape that is curved or trimmed, its area
    /// divided by its length.
    pub(super) fn width(&self) -> f64 {
        let area = self.area();
        if self.face_polygons().is_none() {
            let length = self.outline.length();
            return if length > 0.0 { area / length } else { 0.0 };
        }
        // Width and length are the roots of w^2 - half w + area, where half is their sum.
        let outlines = joint_outlines(&[self]);
        let sides = outlines.iter().flat_map(|outline| outline.iter().zip(outline.iter().cycle().skip(1)));
        let half = 0.5 * sides.map(|(from, to)| from.distance(*to)).sum::<f64>();
        0.5 * (half - (half * half - 4.0 * area).max(0.0).sqrt())
    }

    /// Its mean luminous reflectance at right angles, of which holes reflect nothing, on the side that faces `middle`; `None` if it is unknown.
    pub(super) fn reflectance(&self, scene: &Scene, middle: DVec3) -> Option<f64> {
        let wavelengths = Wavelengths::default();
        let each = (MOST_REFLECTANCE_POINTS / self.faces.len().max(1)) as f64;
        let side = (each.sqrt() as u32).clamp(1, REFLECTANCE_POINTS);
        let (mut area, mut sum) = (0.0, 0.0);
        for &face in &self.faces {
            for (uv, weight) in samples(&self.surface.face_domain(face), side) {
                let Some(front) = self.surface.at(face, uv, false) else { continue };
                let is_behind = front.at.wo.dot(middle - front.at.point.position) < 0.0;
                let seen = if is_behind { self.surface.at(face, uv, true) } else { Some(front) };
                let Some(seen) = seen else { continue };
                let Some(bsdf) = seen.at.bsdf(scene, &wavelengths) else { continue };
                let wo = seen.at.frame_of(&bsdf, seen.at.point.shading_normal).to_local(seen.at.wo);
                let own = weight * seen.area_element;
                area += own;
                sum += own * f64::from(seen.opacity) * f64::from(bsdf.reflected(wo).luminance(&wavelengths));
            }
        }
        (area > 0.0).then(|| sum / area)
    }

    /// Its faces as polygons from above, counterclockwise, metres; `None` if one is curved or trimmed.
    fn face_polygons(&self) -> Option<Vec<Vec<DVec2>>> {
        let polygon = |&face: &u32| {
            face_corners(self.surface, face)?;
            let mut corners: Vec<DVec2> =
                face_points(self.surface, face, 2).into_iter().map(DVec3::truncate).collect();
            if signed_area(&corners) < 0.0 {
                corners.reverse();
            }
            Some(corners)
        };
        let all: Option<Vec<_>> = self.faces.iter().map(polygon).collect();
        all.filter(|all| !all.is_empty())
    }

    /// Polygons from above that cover it: its faces, or the convex outline of one that is curved or trimmed.
    pub(super) fn polygons(&self) -> Vec<Vec<DVec2>> {
        self.face_polygons().unwrap_or_else(|| vec![self.outline.outline.clone()])
    }
}

/// The faces of a shape by the planes in which they lie; those of a curved shape together.
fn by_plane(surface: &PlacedSurface<'_>, faces: Vec<u32>, extent: f64) -> Vec<Vec<u32>> {
    if faces.len() < 2 {
        return vec![faces];
    }
    let mut measured: Vec<(u32, f64)> =
        faces.into_iter().map(|face| (face, rough_area(surface, face))).collect();
    measured.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let whole: f64 = measured.iter().map(|(_, area)| area).sum();
    let mut planes: Vec<(FacePlane, Vec<u32>, f64)> = Vec::new();
    let mut rest = Vec::new();
    for (face, area) in measured {
        let Some(plane) = FacePlane::of(surface, face) else {
            rest.push(face);
            continue;
        };
        let is_full = planes.len() == MOST_PLANES;
        match planes.iter_mut().find(|(other, ..)| other.is_same(&plane, extent)) {
            Some((_, faces, sum)) => {
                faces.push(face);
                *sum += area;
            }
            None if is_full => rest.push(face),
            None => planes.push((plane, vec![face], area)),
        }
    }
    let exceeds_planes = planes.len() == MOST_PLANES && !rest.is_empty();
    let least = (LARGE / (planes.len() + rest.len()) as f64).max(LEAST_LARGE) * whole;
    let (mut parts, mut curved) = (Vec::new(), rest);
    for (_, faces, area) in planes {
        if exceeds_planes && area < least { curved.extend(faces) } else { parts.push(faces) }
    }
    parts.extend(Some(curved).filter(|curved| !curved.is_empty()));
    parts
}

/// A flat face and its plane.
struct FacePlane {
    points: Vec<DVec3>,
    normal: DVec3,
}

impl FacePlane {
    /// `None` if the face is curved.
    fn of(surface: &PlacedSurface<'_>, face: u32) -> Option<Self> {
        let points = face_points(surface, face, TEST_POINTS);
        let &point = points.first()?;
        let [low, high] = points.iter().fold([point; 2], |[low, high], p| [low.min(*p), high.max(*p)]);
        let extent = (high - low).length();
        let middle = middle(&surface.face_domain(face));
        let on_edge =
            || samples(&surface.face_domain(face), 4).find_map(|(uv, _)| surface.at(face, uv, false));
        let normal = surface.at(face, middle, false).or_else(on_edge)?.at.point.normal;
        let is_near = |p: &DVec3| (*p - point).dot(normal).abs() <= NEAR * extent;
        points.iter().all(is_near).then_some(Self { points, normal })
    }

    /// Whether another face of the same shape, of this extent, lies in the plane.
    fn is_same(&self, other: &Self, extent: f64) -> bool {
        let Some(point) = self.points.first() else { return false };
        let is_near = |p: &DVec3| (*p - *point).dot(self.normal).abs() <= NEAR * extent;
        self.normal.dot(other.normal) >= PARALLEL && other.points.iter().all(is_near)
    }
}

/// Area of a flat polygon, m^2.
fn flat_area(corners: &[DVec3]) -> f64 {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let first = corners.first().copied().unwrap_or_default();
    0.5 * pairs.map(|(a, b)| (*a - first).cross(*b - first)).sum::<DVec3>().length()
}

/// The shapes of one plane, from the largest on, that the others do not cover: a floor without the undersides of the things on it.
pub(super) fn uncovered<'s, 'a>(mut shapes: Vec<&'s RoomShape<'a>>) -> Vec<&'s RoomShape<'a>> {
    shapes.sort_by(|a, b| b.outline.area().total_cmp(&a.outline.area()));
    let mut kept: Vec<&'s RoomShape<'a>> = Vec::new();
    // With the numbers of the kept shapes that they are.
    let mut covers: Vec<(usize, PlaneCover)> = Vec::new();
    for shape in shapes {
        if is_covered(shape, covers.iter().map(|(_, cover)| cover)) {
            continue;
        }
        if covers.len() < MOST_COVERS {
            covers.extend(PlaneCover::of(shape).map(|cover| (kept.len(), cover)));
        }
        kept.push(shape);
    }
    // A rug may be larger than each of the boards on which it lies.
    let mut uncovered = Vec::new();
    for (number, shape) in kept.into_iter().enumerate() {
        let others = covers.iter().filter(|(of, _)| *of != number).map(|(_, cover)| cover);
        if is_covered(shape, others) {
            covers.retain(|(of, _)| *of != number);
        } else {
            uncovered.push(shape);
        }
    }
    uncovered
}

/// Whether others cover the polygons of a shape, by the middle of each, its corners and the middles of its sides.
fn is_covered<'c>(shape: &RoomShape<'_>, covers: impl Iterator<Item = &'c PlaneCover> + Clone) -> bool {
    /// Distance of tested points from the middle, as a share of that of the border: coordinates are rounded, and furniture often stands a little in walls.
    const DRAWN_IN: f64 = 0.9;
    let holds = |point: DVec2| covers.clone().any(|cover| cover.holds(point));
    shape.polygons().iter().all(|polygon| {
        let middle = polygon.iter().sum::<DVec2>() / polygon.len().max(1) as f64;
        let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
        let mut border = sides.flat_map(|(from, to)| [*from, 0.5 * (*from + *to)]);
        holds(middle) && border.all(|point| holds(middle.lerp(point, DRAWN_IN)))
    })
}

/// A level shape that hides others in its plane: convex polygons, and the box around them.
struct PlaneCover {
    polygons: Vec<Vec<DVec2>>,
    corners: [DVec2; 2],
}

impl PlaneCover {
    /// `None` if it is not known what the shape covers: it is not convex, and has curved, trimmed or very many faces.
    fn of(shape: &RoomShape<'_>) -> Option<Self> {
        /// Share of its outline that a convex shape fills, but for the errors of areas and of outlines with corners.
        const CONVEX: f64 = 0.98;
        let outline = &shape.outline.outline;
        let polygons = shape.face_polygons().filter(|polygons| polygons.len() <= MOST_COVERS);
        let convex = || (shape.area() >= CONVEX * shape.outline.area()).then(|| vec![outline.clone()]);
        let polygons = polygons.or_else(convex)?;
        let low = outline.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = outline.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        Some(Self { polygons, corners: [low, high] })
    }

    fn holds(&self, point: DVec2) -> bool {
        let [low, high] = self.corners;
        point.cmpge(low).all()
            && point.cmple(high).all()
            && self.polygons.iter().any(|polygon| holds(polygon, point))
    }
}

/// Area of a face by the area element in its middle, m^2.
fn rough_area(surface: &PlacedSurface<'_>, face: u32) -> f64 {
    let domain = surface.face_domain(face);
    let element = surface.at(face, middle(&domain), false).map_or(0.0, |found| found.area_element);
    match domain {
        FaceDomain::Square => element,
        FaceDomain::Polygon(corners) => signed_area(&corners).abs() * element,
    }
}

/// Largest number of outlines of a plane that are drawn.
const MOST_OUTLINES: usize = 400;

/// Distance of corners that are one, as a share of the extent.
const SAME_CORNER: f64 = 1e-6;

/// Corners with this key are the same.
type CornerKey = [i64; 2];

/// Closed outlines of parts in one plane from above, without the edges between parts, metres.
pub(super) fn joint_outlines(parts: &[&RoomShape<'_>]) -> Vec<Vec<DVec2>> {
    let polygons: Vec<Vec<DVec2>> = parts.iter().flat_map(|part| part.polygons()).collect();
    let corners = || polygons.iter().flatten();
    let Some(first) = corners().next().copied() else { return Vec::new() };
    let (low, high) = corners().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    let near = SAME_CORNER * (high - low).max_element();
    let key = |p: DVec2| ((p - low) / near).round().to_array().map(|x| x as i64);
    let mut edges: Vec<[DVec2; 2]> = Vec::new();
    for polygon in &polygons {
        edges.extend(polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(from, to)| [*from, *to]));
    }
    if edges.len() <= MOST_DIVIDED {
        edges = edges.into_iter().flat_map(|edge| divided(edge, corners(), near)).collect();
    }
    // What two parts share, they pass in opposite directions.
    let mut open: BTreeMap<(CornerKey, CornerKey), DVec2> = BTreeMap::new();
    for [from, to] in edges {
        let (a, b) = (key(from), key(to));
        if a != b && open.remove(&(b, a)).is_none() {
            open.insert((a, b), from);
        }
    }
    let mut next: BTreeMap<CornerKey, Vec<(CornerKey, DVec2)>> = BTreeMap::new();
    for ((a, b), from) in open {
        next.entry(a).or_default().push((b, from));
    }
    let mut outlines = Vec::new();
    while let Some(start) = next.keys().next().copied() {
        let (mut at, mut outline) = (start, Vec::new());
        while let Some(ends) = next.get_mut(&at) {
            let taken = ends.pop();
            if ends.is_empty() {
                next.remove(&at);
            }
            let Some((to, from)) = taken else { break };
            outline.push(from);
            at = to;
        }
        outlines.push(without_straight_corners(&outline, near));
    }
    outlines.retain(|outline| outline.len() > 2);
    outlines.sort_by_key(|outline| std::cmp::Reverse(outline.len()));
    outlines.truncate(MOST_OUTLINES);
    outlines
}

/// An edge, divided at the corners that lie on it.
fn divided<'a>(
    [from, to]: [DVec2; 2],
    corners: impl Iterator<Item = &'a DVec2>,
    near: f64,
) -> Vec<[DVec2; 2]> {
    let length = from.distance(to);
    let along = (to - from) / length;
    let off = |corner: &DVec2| (*corner - from).dot(along);
    let is_on = |corner: &&DVec2| {
        (*corner - from).perp_dot(along).abs() <= near && (near..length - near).contains(&off(corner))
    };
    let mut points: Vec<DVec2> = corners.filter(is_on).copied().chain([from, to]).collect();
    points.sort_by(|a, b| off(a).total_cmp(&off(b)));
    points.windows(2).filter_map(|pair| Some([*pair.first()?, *pair.last()?])).collect()
}

/// A closed outline without corners on straight lines.
fn without_straight_corners(outline: &[DVec2], near: f64) -> Vec<DVec2> {
    let before = outline.iter().cycle().skip(outline.len().saturating_sub(1));
    let after = outline.iter().cycle().skip(1);
    let all = outline.iter().zip(before.zip(after));
    let bent = all.filter(|(at, (before, after))| {
        let along = (**after - **before).normalize_or_zero();
        along == DVec2::ZERO || (**at - **before).perp_dot(along).abs() > near
    });
    bent.map(|(at, _)| *at).collect()
}

/// Distance of a point from the nearest side of closed outlines, metres.
pub(super) fn border_distance(outlines: &[Vec<DVec2>], point: DVec2) -> f64 {
    let sides = outlines.iter().flat_map(|outline| outline.iter().zip(outline.iter().cycle().skip(1)));
    let distances = sides.map(|(a, b)| {
        let side = *b - *a;
        let share = ((point - *a).dot(side) / side.length_squared()).clamp(0.0, 1.0);
        point.distance(*a + if share.is_nan() { 0.0 } else { share } * side)
    });
    distances.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{FloatParameter, LightDescription, MaterialKind, ShapeDescription};

    /// The parts of shapes from above, each with the number of its faces.
    fn with_shapes<T>(shapes: Vec<ShapeDescription>, look: impl FnOnce(&[RoomShape<'_>]) -> T) -> T {
        let builder = SceneBuilder::new().light(LightDescription::infinite(1.0));
        let builder = shapes
            .into_iter()
            .fold(builder, |builder, shape| builder.shape(shape, MaterialKind::diffuse(0.5)));
        let (scene, _) = builder.resolve().unwrap();
        let placed = scene.placed_surfaces();
        look(&RoomShape::all(&placed))
    }

    fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> ShapeDescription {
        ShapeDescription::parallelogram(corner, u, v)
    }

    #[test]
    fn parts_of_a_plane_have_one_outline() {
        // An L of 4 m x 4 m less 2 m x 2 m: a long part along two others, whose corner lies on its side.
        let floor = vec![
            quad([0.0; 3], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
            quad([0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
            quad([1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0]),
        ];
        let outlines = with_shapes(floor, |shapes| joint_outlines(&shapes.iter().collect::<Vec<_>>()));
        let [l] = outlines.try_into().unwrap();
        assert_eq!((l.len(), signed_area(&l)), (6, 12.0), "{l:?}");
        let apart = |x: f64, y: f64| border_distance(std::slice::from_ref(&l), DVec2::new(x, y));
        // In the middle of the inner side; on the line between two parts; beyond a corner.
        assert!(apart(2.0, 3.0) < 1e-12 && (apart(1.0, 2.0) - 1.0).abs() < 1e-12);
        assert!((apart(7.0, -4.0) - 5.0).abs() < 1e-12);
    }

    /// Areas of the level shapes that are not covered, m^2, from the largest on.
    fn uncovered_areas(shapes: Vec<ShapeDescription>) -> Vec<f64> {
        with_shapes(shapes, |shapes| {
            uncovered(shapes.iter().collect()).into_iter().map(RoomShape::area).collect()
        })
    }

    fn assert_areas(found: &[f64], expected: &[f64]) {
        let are_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9);
        assert!(found.len() == expected.len() && are_near, "{found:?} {expected:?}");
    }

    #[test]
    fn rugs_on_boards_are_covered() {
        // 20 boards of 5 m x 0.2 m, and a rug of 3 m x 2 m, which covers none of them.
        let board = |i: u32| quad([0.0, 0.2 * f64::from(i), 0.0], [5.0, 0.0, 0.0], [0.0, 0.2, 0.0]);
        let rug = quad([1.0, 1.1, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        assert_areas(&uncovered_areas((0..20).map(board).chain([rug]).collect()), &[1.0; 20]);
    }

    #[test]
    fn corridors_across_a_hall_are_not_covered() {
        // The middle of the corridor of 20 m x 2 m lies in the hall of 10 m x 8 m, its ends do not.
        let hall = quad([-5.0, -4.0, 0.0], [10.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
        let corridor = quad([-10.0, -1.0, 0.0], [20.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        assert_areas(&uncovered_areas(vec![corridor, hall]), &[80.0, 40.0]);
    }

    #[test]
    fn large_planes_of_a_mesh_of_many_are_parts() {
        // A floor of 100 m2 and two walls of 3 m2, 2.8 % of the whole, with 100 level triangles of 50 cm2 at different heights: twice the share of equal planes is 2 / 103.
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        let mut add = |corners: &[[f64; 3]]| {
            let first = points.len() as u32;
            points.extend(corners.iter().map(|corner| DVec3::from(*corner)));
            faces.extend((2..corners.len() as u32).map(|i| [first, first + i - 1, first + i]));
        };
        add(&[[0.0; 3], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [0.0, 10.0, 0.0]]);
        add(&[[0.0; 3], [0.0, 0.0, 0.3], [10.0, 0.0, 0.3], [10.0, 0.0, 0.0]]);
        add(&[[0.0; 3], [0.0, 10.0, 0.0], [0.0, 10.0, 0.3], [0.0, 0.0, 0.3]]);
        for z in (0..100).map(|i| 0.5 + 0.02 * f64::from(i)) {
            add(&[[1.0, 1.0, z], [1.1, 1.0, z], [1.0, 1.1, z]]);
        }
        let mut areas = with_shapes(vec![ShapeDescription::mesh(points, faces)], |shapes| {
            shapes.iter().map(RoomShape::area).collect::<Vec<_>>()
        });
        areas.sort_by(|a, b| b.total_cmp(a));
        assert_areas(&areas, &[100.0, 3.0, 3.0, 0.5]);
    }

    #[test]
    fn balls_of_few_faces_are_one_thing() {
        // The icosahedron with each face divided into four, which are 80 nearly equal ones on the unit ball.
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut points: Vec<DVec3> = [[1.0, golden], [-1.0, golden], [1.0, -golden], [-1.0, -golden]]
            .into_iter()
            .flat_map(|[a, b]| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)])
            .collect();
        let mut faces: Vec<[u32; 3]> = Vec::new();
        let is_edge = |points: &[DVec3], a: usize, b: usize| points[a].distance(points[b]) < 2.1;
        for (a, b, c) in (0..12).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| (a, b, c)))) {
            if !(is_edge(&points, a, b) && is_edge(&points, b, c) && is_edge(&points, a, c)) {
                continue;
            }
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| {
                points.push(0.5 * (points[a] + points[b]));
                points.len() - 1
            });
            let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            faces.extend(parts.map(|part| part.map(|corner| corner as u32)));
        }
        assert_eq!(faces.len(), 80);
        // All seen from outside.
        for [a, b, c] in &mut faces {
            let [p, q, r] = [*a, *b, *c].map(|corner| points[corner as usize]);
            if (q - p).cross(r - p).dot(p + q + r) < 0.0 {
                std::mem::swap(b, c);
            }
        }
        let points = points.into_iter().map(DVec3::normalize).collect();
        assert_eq!(with_shapes(vec![ShapeDescription::mesh(points, faces)], |shapes| shapes.len()), 1);
    }

    #[test]
    fn holes_reflect_nothing() {
        let floor = quad([0.0; 3], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]).with_alpha(FloatParameter::Value(0.25));
        let builder = SceneBuilder::new().light(LightDescription::infinite(1.0));
        let (scene, _) = builder.shape(floor, MaterialKind::diffuse(0.8)).resolve().unwrap();
        let placed = scene.placed_surfaces();
        let found = RoomShape::all(&placed)[0].reflectance(&scene, DVec3::Z).unwrap();
        assert!((found - 0.2).abs() < 1e-6, "{found}");
    }

    #[test]
    fn faces_of_a_mesh_are_divided_by_their_planes_alone() {
        // A box of 12 triangles has six planes; a ball of more than 64 faces is one thing.
        let cuboid = |size: f64| ShapeDescription::cuboid([0.0; 3], [size, 1.0, 1.0]);
        assert_eq!(with_shapes(vec![cuboid(2.0)], |shapes| shapes.len()), 6);
        let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let mesh = ShapeDescription::mesh((0..8).map(corner).collect(), triangles.collect());
        let areas = with_shapes(vec![mesh], |shapes| shapes.iter().map(RoomShape::area).collect::<Vec<_>>());
        assert!(areas.len() == 6 && areas.iter().all(|area| (area - 1.0).abs() < 1e-12), "{areas:?}");
    }
}
