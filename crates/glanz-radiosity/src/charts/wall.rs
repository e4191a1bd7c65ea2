//! Detection of thin walls on flat charts.
//!
//! A texel at a wall thinner than texels extends to its other side, and bilinear filtering mixes the light of both. Charts are
//! therefore divided along the middles of such walls (`parts`), which hide the borders of the parts.

use std::cmp::Ordering;

use glanz_geometry::Surface;
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::parts::MIN_DEPTH;
use super::{Chart, Sheet};

/// Height above a chart at which walls are detected, texels: faces that end below or begin above it are ignored.
const HEIGHT: f64 = 0.02;

/// Largest thickness of a wall that divides a chart, texels. Thicker walls cover at least two texels between those that reach their sides,
/// so that filled texels do not mix the light of both.
const MAX_THICKNESS: f64 = 4.0;

/// The same for two faces that do not belong to one solid: farther ones may be the walls of a narrow space.
const MAX_SHEET_DISTANCE: f64 = 1.0;

/// Smallest length of a wall that divides a chart, texels, unless it reaches from border to border.
const MIN_LENGTH: f64 = 8.0;

/// Smallest length of the longer side of a chart on which walls are detected, texels.
const MIN_SIDE: u32 = 3;

/// Largest sine of the angle between sides of a wall that count as parallel.
const PARALLEL: f64 = 0.02;

/// Largest distance of lines that are merged, texels.
const MERGE_DISTANCE: f64 = 0.05;

/// Largest number of lines on a chart; the longest are used.
const MAX_LINES: usize = 1024;

/// Largest distance of a flat face from its plane, relative to its size.
const FLATNESS: f64 = 1e-7;

/// A thin wall that stands on a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartWall {
    /// Ends of its center line; the chart shows the part on the left of the line.
    pub ends: [DVec2; 2],
    /// Distance from the center line up to which no light is beneath it, texels.
    pub half_thickness: f64,
}

impl ChartWall {
    /// The wall seen from its other side.
    pub(super) fn reversed(self) -> Self {
        let [from, to] = self.ends;
        Self { ends: [to, from], ..self }
    }
}

/// A flat face in space.
#[derive(Clone, Debug)]
pub(crate) struct WallFace {
    corners: Vec<DVec3>,
    bounds: Bounds3,
    /// The closed solid that it belongs to, by the number of its surface.
    solid: Option<usize>,
}

/// The intersection of a face with a chart, in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WallLine {
    ends: [DVec2; 2],
    solid: Option<usize>,
}

/// The plane of a flat chart in space.
struct ChartPlane {
    origin: DVec3,
    /// Unit normal on the side of the chart.
    normal: DVec3,
    /// Gradients of the texel coordinates, per metre.
    axes: [DVec3; 2],
    /// Texel coordinates of `origin`.
    first: DVec2,
    bounds: Bounds3,
    /// Width of a texel, metres.
    texel: f64,
}

/// All flat faces of surfaces that are not trimmed.
pub(crate) fn flat_faces(surfaces: &[PlacedSurface<'_>]) -> Vec<WallFace> {
    let mut faces = Vec::new();
    let shown = |surface: &PlacedSurface<'_>| !surface.is_passable() && !surface.is_trimmed();
    for (number, surface) in surfaces.iter().enumerate().filter(|(_, surface)| shown(surface)) {
        let is_closed = matches!(surface.surface(), Surface::Cuboid(_) | Surface::Polyhedron(_));
        let solid = is_closed.then_some(number);
        for face in 0..surface.faces() {
            let parameters = surface.face_domain(face).corners();
            let position = |uv| surface.at(face, uv, false).map(|at| at.at.point.position);
            let Some(corners) = parameters.iter().map(|&uv| position(uv)).collect::<Option<Vec<DVec3>>>()
            else {
                continue;
            };
            let is_straight = |i: usize| {
                let next = (i + 1) % corners.len();
                let middle = corners[i].midpoint(corners[next]);
                position(parameters[i].midpoint(parameters[next]))
                    .is_some_and(|p| is_near(p, middle, &corners))
            };
            let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
            let inside = position(parameters.iter().sum::<DVec2>() / parameters.len() as f64);
            let normal = (1..corners.len() - 1)
                .map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]))
                .sum::<DVec3>()
                .normalize_or_zero();
            let lies = |p: DVec3| is_near(p, p - normal * (p - middle).dot(normal), &corners);
            let is_flat = normal != DVec3::ZERO
                && corners.iter().copied().chain(inside).all(lies)
                && (0..corners.len()).all(is_straight);
            if is_flat {
                faces.push(WallFace {
                    bounds: Bounds3::from_points(corners.iter().copied()),
                    corners,
                    solid,
                });
            }
        }
    }
    faces
}

fn is_near(a: DVec3, b: DVec3, corners: &[DVec3]) -> bool {
    let size = corners.iter().map(|corner| corner.distance(corners[0])).fold(0.0, f64::max);
    a.distance(b) <= FLATNESS * size
}

/// The thin walls on a chart, in its texels, by decreasing length; none on a chart that is not flat.
pub(super) fn thin_walls(surface: &PlacedSurface<'_>, chart: &Chart, faces: &[WallFace]) -> Vec<ChartWall> {
    let lines = merged_lines(surface, chart, faces);
    let mut walls: Vec<ChartWall> = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        match opposite(&lines, i) {
            // Each pair is added once.
            Some((other, wall)) if i < other || opposite(&lines, other).is_none_or(|(back, _)| back != i) => {
                walls.push(wall);
            }
            None if line.solid.is_none() => {
                walls.push(ChartWall { ends: line.ends, half_thickness: MERGE_DISTANCE })
            }
            _ => {}
        }
    }
    let is_at_border = |end: &DVec2| {
        let inside = end.min(chart.last_texel() - *end).min_element();
        inside <= MIN_DEPTH
    };
    walls.retain(|wall| length(wall.ends) >= MIN_LENGTH || wall.ends.iter().all(is_at_border));
    walls.sort_by(|a, b| by_length(a.ends, b.ends));
    walls
}

/// Lines on the sheet of a chart along which flat faces stand on it, by decreasing length; none on a chart that is not flat.
pub(crate) fn wall_lines(surface: &PlacedSurface<'_>, chart: &Chart, faces: &[WallFace]) -> Vec<[DVec2; 2]> {
    let lines = merged_lines(surface, chart, faces);
    lines.into_iter().map(|line| line.ends.map(|end| chart.to_sheet(end))).collect()
}

/// Lines along which faces stand on a chart, in its texels, by decreasing length.
fn merged_lines(surface: &PlacedSurface<'_>, chart: &Chart, faces: &[WallFace]) -> Vec<WallLine> {
    if chart.size[0].max(chart.size[1]) <= MIN_SIDE {
        return Vec::new();
    }
    let Some(plane) = ChartPlane::new(surface, chart) else { return Vec::new() };
    // Opposite sides of a solid are no wall on its own inside, however near.
    let is_near =
        |face: &&WallFace| face.solid != Some(chart.surface as usize) && meets(&face.bounds, &plane.bounds);
    let near = faces.iter().filter(is_near);
    let mut lines: Vec<WallLine> = near.filter_map(|face| plane.line(face)).collect();
    sort(&mut lines);
    lines.truncate(MAX_LINES);
    merge_lines(lines)
}

fn meets(a: &Bounds3, b: &Bounds3) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

/// Sorts by decreasing length.
fn sort(lines: &mut [WallLine]) {
    lines.sort_by(|a, b| by_length(a.ends, b.ends));
}

/// Order by decreasing length, equal lengths by position.
fn by_length(a: [DVec2; 2], b: [DVec2; 2]) -> Ordering {
    let key = |ends: [DVec2; 2]| [-length(ends), ends[0].x, ends[0].y, ends[1].x, ends[1].y];
    key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)
}

fn length([from, to]: [DVec2; 2]) -> f64 {
    from.distance(to)
}

/// Merges lines that continue one another.
fn merge_lines(lines: Vec<WallLine>) -> Vec<WallLine> {
    let mut left: Vec<WallLine> = Vec::new();
    for mut line in lines {
        // A merged line may reach further lines.
        while let Some(i) = left.iter().position(|other| other.continues(&line)) {
            line = left.swap_remove(i).merged(&line);
        }
        left.push(line);
    }
    sort(&mut left);
    left
}

/// The nearest parallel line beside at least half of the shorter of the two, and the wall between both.
fn opposite(lines: &[WallLine], number: usize) -> Option<(usize, ChartWall)> {
    let line = lines[number];
    let (from, direction) = (line.ends[0], line.direction());
    let beside = |(i, other): (usize, &WallLine)| {
        if i == number || direction.perp_dot(other.direction()).abs() > PARALLEL {
            return None;
        }
        let offset = direction.perp_dot(other.ends[0].midpoint(other.ends[1]) - from);
        let ends = other.ends.map(|end| direction.dot(end - from));
        let (low, high) = (ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1]).min(line.length()));
        let is_solid = line.solid.is_some() && line.solid == other.solid;
        let is_beside = offset.abs() > MERGE_DISTANCE
            && offset.abs() <= if is_solid { MAX_THICKNESS } else { MAX_SHEET_DISTANCE };
        (is_beside && high - low >= 0.5 * line.length().min(other.length())).then_some((i, offset, low, high))
    };
    let nearest =
        lines.iter().enumerate().filter_map(beside).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let (i, offset, low, high) = nearest;
    let ends = [low, high].map(|along| from + along * direction + 0.5 * offset * direction.perp());
    // The lines may be slightly inclined.
    let farthest = lines[i].ends.iter().map(|end| direction.perp_dot(*end - from).abs()).fold(0.0, f64::max);
    let half_thickness = (farthest - 0.5 * offset.abs()).max(MERGE_DISTANCE);
    Some((i, ChartWall { ends, half_thickness }))
}

impl WallLine {
    fn length(&self) -> f64 {
        length(self.ends)
    }

    fn direction(&self) -> DVec2 {
        (self.ends[1] - self.ends[0]).normalize_or_zero()
    }

    fn continues(&self, other: &Self) -> bool {
        let (long, short) = if self.length() >= other.length() { (self, other) } else { (other, self) };
        let (from, direction) = (long.ends[0], long.direction());
        let along = short.ends.map(|end| direction.dot(end - from));
        let is_on = short.ends.iter().all(|&end| direction.perp_dot(end - from).abs() <= MERGE_DISTANCE);
        is_on
            && along[0].max(along[1]) >= -MERGE_DISTANCE
            && along[0].min(along[1]) <= long.length() + MERGE_DISTANCE
    }

    /// The line that covers both.
    fn merged(&self, other: &Self) -> Self {
        let long = if self.length() >= other.length() { self } else { other };
        let (from, direction) = (long.ends[0], long.direction());
        let along = [self, other].map(|line| line.ends.map(|end| direction.dot(end - from)));
        let [a, b] = along.map(|[a, b]| [a.min(b), a.max(b)]);
        let ends = [a[0].min(b[0]), a[1].max(b[1])].map(|t| from + t * direction);
        // Side by side, they are both sides of a solid that is thin enough for one line.
        let is_continued = a[1].min(b[1]) - a[0].max(b[0]) <= MERGE_DISTANCE;
        Self { ends, solid: self.solid.filter(|_| is_continued && self.solid == other.solid) }
    }
}

impl ChartPlane {
    fn new(surface: &PlacedSurface<'_>, chart: &Chart) -> Option<Self> {
        let to_world = surface.to_world();
        // Position and normal on the side of the chart. Trimming leaves the plane as it is.
        let at = |face, uv| {
            let point = surface.surface().untrimmed_at(face, uv)?.transformed(&to_world);
            let is_opposite = chart.back != surface.is_reversed(face);
            Some((point.position, if is_opposite { -point.normal } else { point.normal }))
        };
        // Points of the sheet with their positions in space.
        let mut points = Vec::new();
        match &*chart.sheet {
            Sheet::Square(face) => {
                for uv in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE, DVec2::splat(0.5)] {
                    points.push((uv, at(*face, uv)?));
                }
            }
            Sheet::Flat(flat) => {
                for triangle in flat.triangles() {
                    for (corner, uv) in triangle.corners.into_iter().zip(triangle.parameters) {
                        points.push((corner, at(triangle.face, uv)?));
                    }
                }
            }
        }
        let scale = chart.last_texel() / (chart.window[1] - chart.window[0]);
        let texel = |sheet: DVec2| (sheet - chart.window[0]) * scale;
        let [(a, p), (b, q), (c, r)] = [0, 1, 2]
            .map(|i| points.get(i).map(|(s, (position, _))| (texel(*s), *position)))
            .into_iter()
            .collect::<Option<Vec<_>>>()?
            .try_into()
            .ok()?;
        let (u, v) = (q - p, r - p);
        let normal = u.cross(v).try_normalize()?;
        let side = points[0].1.1.dot(normal).signum();
        // Dual basis of u and v: points of the plane are s u + t v.
        let square = u.cross(v).length_squared();
        let (s, t) = (v.cross(u.cross(v)) / square, u.cross(v).cross(u) / square);
        let axes = [0, 1].map(|axis| (b - a)[axis] * s + (c - a)[axis] * t);
        let wide = 1.0 / axes[0].length().max(axes[1].length());
        let mut plane = Self {
            origin: p,
            normal: side * normal,
            axes,
            first: a,
            bounds: Bounds3::from_points(points.iter().map(|(_, (position, _))| *position)),
            texel: wide,
        };
        let is_flat = points.iter().all(|(sheet, (position, _))| {
            let off = (*position - p).dot(plane.normal).abs();
            off <= 0.5 * HEIGHT * wide && plane.texel(*position).distance(texel(*sheet)) <= MERGE_DISTANCE
        });
        plane.bounds = plane.bounds.expanded(wide);
        is_flat.then_some(plane)
    }

    fn texel(&self, point: DVec3) -> DVec2 {
        let direction = point - self.origin;
        self.first + DVec2::new(self.axes[0].dot(direction), self.axes[1].dot(direction))
    }

    /// The intersection of a face with the plane.
    fn line(&self, face: &WallFace) -> Option<WallLine> {
        let height = |corner: DVec3| (corner - self.origin).dot(self.normal) / self.texel - HEIGHT;
        let mut ends = Vec::with_capacity(2);
        for (&a, &b) in face.corners.iter().zip(face.corners.iter().cycle().skip(1)) {
            let (low, high) = (height(a), height(b));
            if (low < 0.0) != (high < 0.0) {
                ends.push(self.texel(a.lerp(b, low / (low - high))));
            }
        }
        let highest = face.corners.iter().map(|&corner| height(corner)).fold(f64::NEG_INFINITY, f64::max);
        let ends = <[DVec2; 2]>::try_from(ends).ok().filter(|_| highest > 0.5)?;
        Some(WallLine { ends, solid: face.solid })
    }
}
