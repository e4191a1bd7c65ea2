//! Shapes of a scene as the parts of a room: planes, borders, reflectances.

use std::collections::BTreeMap;

use glanz_geometry::FaceDomain;
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};

use super::plan_outline::{ShapeOutline, face_points};
use crate::receiver::{face_corners, signed_area};

/// Largest number of faces that are looked at one by one; surfaces beyond are boxes.
const MOST_FACES: usize = 1 << 18;

/// Largest number of planes of a shape. Of one with more, which is curved, the planes of the largest faces are parts if they are large.
const MOST_PLANES: usize = 64;

/// Least area of a plane of a curved shape, as a share of that of the shape.
const LARGE: f64 = 0.01;

/// Distance of a point from a plane that it lies in, as a share of the extent.
const NEAR: f64 = 1e-6;

/// Difference of 1 and the cosine between the normals of one plane.
const PARALLEL: f64 = 1e-8;

/// Points along each side of a face by which it is tested for flatness.
const TEST_POINTS: u32 = 5;

/// Points along each side of a face at which its reflectance is sampled, and the largest number of points of a part with several faces, apart from one for each.
const REFLECTANCE_POINTS: u32 = 8;
const MOST_REFLECTANCE_POINTS: usize = 4096;

/// Largest number of edges that are divided where corners of others lie on them.
const MOST_DIVIDED: usize = 512;

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

    /// Its area, m^2.
    pub(super) fn area(&self) -> f64 {
        let each = |face: u32| self.surface.area(face..face + 1).unwrap_or(0.0);
        if self.faces.is_empty() {
            return self.surface.area(0..self.surface.faces()).unwrap_or(0.0);
        }
        self.faces.iter().map(|&face| each(face)).sum()
    }

    /// Its mean luminous reflectance at right angles, on the side that faces `middle`; `None` if it is unknown.
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
                sum += own * f64::from(bsdf.reflected(wo).luminance(&wavelengths));
            }
        }
        (area > 0.0).then(|| sum / area)
    }

    /// Polygons from above that cover it, counterclockwise, metres: its faces, or the convex outline of one that is curved or trimmed.
    fn polygons(&self) -> Vec<Vec<DVec2>> {
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
        all.filter(|all| !all.is_empty()).unwrap_or_else(|| vec![self.outline.outline.clone()])
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
    let is_many = planes.len() == MOST_PLANES && !rest.is_empty();
    let (mut parts, mut curved) = (Vec::new(), rest);
    for (_, faces, area) in planes {
        if is_many && area < LARGE * whole { curved.extend(faces) } else { parts.push(faces) }
    }
    parts.extend(Some(curved).filter(|curved| !curved.is_empty()));
    parts
}

/// The plane of a flat face.
struct FacePlane {
    point: DVec3,
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
        points.iter().all(is_near).then_some(Self { point, normal })
    }

    fn is_same(&self, other: &Self, extent: f64) -> bool {
        self.normal.dot(other.normal) >= 1.0 - PARALLEL
            && (other.point - self.point).dot(self.normal).abs() <= NEAR * extent
    }
}

fn middle(domain: &FaceDomain) -> DVec2 {
    match domain {
        FaceDomain::Square => DVec2::splat(0.5),
        FaceDomain::Polygon(corners) => corners.iter().sum::<DVec2>() / corners.len().max(1) as f64,
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

/// Parameters spread evenly over a domain, `side` times `side` of them over the square and each triangle of a polygon, with the area of the domain that each stands for.
fn samples(domain: &FaceDomain, side: u32) -> impl Iterator<Item = (DVec2, f64)> + use<> {
    let fans: Vec<[DVec2; 3]> = match domain {
        FaceDomain::Square => Vec::new(),
        FaceDomain::Polygon(corners) => corners
            .windows(2)
            .skip(1)
            .filter_map(|pair| Some([*corners.first()?, *pair.first()?, *pair.last()?]))
            .collect(),
    };
    let share = 1.0 / f64::from(side * side);
    let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let grid: Vec<DVec2> = (0..side * side).map(|i| DVec2::new(at(i % side), at(i / side))).collect();
    let whole = fans.is_empty().then(|| grid.clone()).into_iter().flatten().map(move |uv| (uv, share));
    let parts = fans.into_iter().flat_map(move |[a, b, c]| {
        let area = 0.5 * (b - a).perp_dot(c - a).abs() * share;
        // Equal areas from the first corner on lie between the square roots.
        let place = move |at: DVec2| (a + at.x.sqrt() * ((1.0 - at.y) * (b - a) + at.y * (c - a)), area);
        grid.clone().into_iter().map(place)
    });
    whole.chain(parts)
}

/// Largest number of outlines of a plane that are drawn.
const MOST_OUTLINES: usize = 400;

/// Corners with this key are the same.
type CornerKey = [i64; 2];

/// Closed outlines of parts in one plane from above, without the edges between parts, metres.
pub(super) fn joint_outlines(parts: &[&RoomShape<'_>]) -> Vec<Vec<DVec2>> {
    let polygons: Vec<Vec<DVec2>> = parts.iter().flat_map(|part| part.polygons()).collect();
    let corners = || polygons.iter().flatten();
    let Some(first) = corners().next().copied() else { return Vec::new() };
    let (low, high) = corners().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    let near = NEAR * (high - low).max_element();
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
    use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};

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

    #[test]
    fn samples_of_a_polygon_have_its_area_and_middle() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]].map(DVec2::from).to_vec();
        for (domain, area, middle) in [
            (FaceDomain::Square, 1.0, [0.5, 0.5]),
            // Triangles of 1/2 and 1/4 about (2/3, 1/3) and (1/3, 1/2).
            (FaceDomain::Polygon(corners), 0.75, [5.0 / 9.0, 7.0 / 18.0]),
        ] {
            let all: Vec<(DVec2, f64)> = samples(&domain, 64).collect();
            let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
            let mean: DVec2 = all.iter().map(|(at, weight)| *weight * *at).sum::<DVec2>() / sum;
            assert!((sum - area).abs() < 1e-12 && mean.distance(middle.into()) < 1e-3, "{sum} {mean}");
        }
    }
}
