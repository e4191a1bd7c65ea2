//! Receivers that lie in a plane.

use std::collections::HashSet;

use glanz_geometry::{FaceDomain, Surface};
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::ReceiverPoint;

/// Sides of the polygon that replaces a disk. The relative difference of the areas is 2 pi^2 / (3 n^2): 4e-7.
const RIM: u32 = 4096;

/// Largest number of edges that are tried as directions of the grid.
const EDGES: usize = 4096;

/// A grid in a plane.
#[derive(Clone, Debug)]
pub(super) struct FlatGrid {
    origin: DVec3,
    /// Unit directions of the grid, at right angles.
    across: DVec3,
    up: DVec3,
    /// Unit normal on the front of the surface.
    normal: DVec3,
    size: DVec2,
    /// The surface as convex polygons in grid coordinates, [0, 1]^2.
    polygons: Vec<Vec<DVec2>>,
}

impl FlatGrid {
    /// `None` unless the faces lie in one plane and face the same way. `back`: whether the back is the counted side.
    pub(super) fn try_new(surface: &PlacedSurface<'_>, faces: &[u32], back: bool) -> Option<Self> {
        let mut corners = Vec::new();
        for &face in faces {
            corners.extend(polygons(surface, face)?);
        }
        let &first = faces.first()?;
        let inside = middle(&surface.face_domain(first));
        let normal = surface.at(first, inside, false)?.at.point.normal;
        let origin = *corners.first()?.first()?;
        let size = corners.iter().flatten().fold(0.0_f64, |size, p| size.max(p.distance(origin)));
        // Positions of placed surfaces are exact up to some rounding errors of their coordinates.
        let far = corners.iter().flatten().fold(size, |far, p| far.max(p.abs().max_element()));
        let apart = |p: &DVec3| (*p - origin).dot(normal).abs();
        if corners.iter().flatten().any(|p| apart(p) > 1e-12 * far + 1e-9 * size) {
            return None;
        }
        if !faces.iter().all(|&face| faces_along(surface, face, normal)) {
            return None;
        }
        let seen_from = if back { -normal } else { normal };
        let (across, up) = directions(&corners, normal, seen_from)?;
        let plane = |p: &DVec3| DVec2::new((*p - origin).dot(across), (*p - origin).dot(up));
        let flat: Vec<Vec<DVec2>> =
            corners.iter().map(|polygon| polygon.iter().map(plane).collect()).collect();
        let low = flat.iter().flatten().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = flat.iter().flatten().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        let size = high - low;
        if size.min_element() <= 0.0 {
            return None;
        }
        let share = |p: &DVec2| (*p - low) / size;
        let polygons = flat.iter().map(|polygon| polygon.iter().map(share).collect()).collect();
        let origin = origin + low.x * across + low.y * up;
        Some(Self { origin, across, up, normal, size, polygons })
    }

    pub(super) fn size(&self) -> DVec2 {
        self.size
    }

    /// Its lower left corner, metres, and its directions across and up.
    pub(super) fn frame(&self) -> [DVec3; 3] {
        [self.origin, self.across, self.up]
    }

    /// Grid coordinates of a point, [0, 1]^2.
    pub(super) fn share(&self, position: DVec3) -> DVec2 {
        let p = position - self.origin;
        (DVec2::new(p.dot(self.across), p.dot(self.up)) / self.size).clamp(DVec2::ZERO, DVec2::ONE)
    }

    fn position(&self, share: DVec2) -> DVec3 {
        self.origin + share.x * self.size.x * self.across + share.y * self.size.y * self.up
    }

    pub(super) fn centers(&self, cells: [u32; 2]) -> Vec<DVec3> {
        let [nx, ny] = cells;
        let center = |i: u32, j: u32| {
            let cell = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            self.position(cell / DVec2::new(f64::from(nx), f64::from(ny)))
        };
        (0..ny).flat_map(|j| (0..nx).map(move |i| center(i, j))).collect()
    }

    /// Area of the surface in each cell, m^2.
    pub(super) fn areas(&self, cells: [u32; 2]) -> Vec<f64> {
        let [nx, ny] = cells;
        let n = DVec2::new(f64::from(nx), f64::from(ny));
        let cell_area = (self.size / n).element_product();
        let mut areas = vec![0.0; nx as usize * ny as usize];
        for polygon in &self.polygons {
            let scaled: Vec<DVec2> = polygon.iter().map(|&p| p * n).collect();
            let low = scaled.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
            let high = scaled.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
            let range = |low: f64, high: f64, n: u32| {
                (low.floor().max(0.0) as u32).min(n - 1)..(high.ceil().max(0.0) as u32).clamp(1, n)
            };
            for j in range(low.y, high.y, ny) {
                let row = clipped(&clipped(&scaled, 1, f64::from(j), true), 1, f64::from(j + 1), false);
                if row.len() < 3 {
                    continue;
                }
                for i in range(low.x, high.x, nx) {
                    let cell = clipped(&clipped(&row, 0, f64::from(i), true), 0, f64::from(i + 1), false);
                    if let Some(slot) = areas.get_mut(j as usize * nx as usize + i as usize) {
                        *slot += signed_area(&cell).abs() * cell_area;
                    }
                }
            }
        }
        // Clipping along the border of a cell leaves degenerate polygons.
        for slot in areas.iter_mut().filter(|area| **area < 1e-12 * cell_area) {
            *slot = 0.0;
        }
        areas
    }

    pub(super) fn place(&self, cells: [u32; 2], cell: usize, at: DVec2) -> Option<ReceiverPoint> {
        let [nx, ny] = cells.map(|n| n as usize);
        let n = DVec2::new(nx as f64, ny as f64);
        let share = (DVec2::new((cell % nx) as f64, (cell / nx) as f64) + at) / n;
        let holds = self.polygons.iter().any(|polygon| holds(polygon, share));
        let area_element = (self.size / n).element_product();
        holds.then(|| ReceiverPoint { position: self.position(share), normal: self.normal, area_element })
    }
}

/// The face as convex polygons in the world; `None` if it is not known to be flat.
fn polygons(surface: &PlacedSurface<'_>, face: u32) -> Option<Vec<Vec<DVec3>>> {
    let at = |uv: DVec2| surface.at(face, uv, false).map(|at| at.at.point.position);
    let all = |corners: &[DVec2]| corners.iter().map(|&uv| at(uv)).collect::<Option<Vec<DVec3>>>();
    if let Some(corners) = face_corners(surface, face) {
        return Some(vec![all(&corners)?]);
    }
    match surface.surface() {
        Surface::Disk(_) => {
            let rim = |i: u32, v: f64| DVec2::new(f64::from(i) / f64::from(RIM), v);
            (0..RIM).map(|i| all(&[rim(i, 0.0), rim(i + 1, 0.0), rim(i + 1, 1.0), rim(i, 1.0)])).collect()
        }
        _ => None,
    }
}

/// Parameters of the corners of a face that lies within their convex hull: a triangle, a quadrilateral, a side of a box or of a polyhedron; `None` for others.
pub(crate) fn face_corners(surface: &PlacedSurface<'_>, face: u32) -> Option<Vec<DVec2>> {
    match (surface.surface(), surface.face_domain(face)) {
        (Surface::Trimmed(_), _) => None,
        (_, FaceDomain::Polygon(corners)) => Some(corners),
        (Surface::Bilinear(_) | Surface::Plane(_) | Surface::Cuboid(_), FaceDomain::Square) => {
            Some(vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y])
        }
        _ => None,
    }
}

/// Parameters of the middle of a face.
pub(crate) fn middle(domain: &FaceDomain) -> DVec2 {
    match domain {
        FaceDomain::Square => DVec2::splat(0.5),
        FaceDomain::Polygon(corners) => corners.iter().copied().sum::<DVec2>() / corners.len().max(1) as f64,
    }
}

fn faces_along(surface: &PlacedSurface<'_>, face: u32, normal: DVec3) -> bool {
    let at = surface.at(face, middle(&surface.face_domain(face)), false);
    at.is_none_or(|at| at.at.point.normal.dot(normal) > 0.0)
}

/// Directions across and up of the smallest rectangle around the polygons: up is as close to +z as possible, or to +y if the plane is
/// horizontal; across points to the right for a viewer in front.
fn directions(polygons: &[Vec<DVec3>], normal: DVec3, seen_from: DVec3) -> Option<(DVec3, DVec3)> {
    let wish = if normal.z.abs() < 0.9 { DVec3::Z } else { DVec3::Y };
    let in_plane = |v: DVec3| (v - v.dot(normal) * normal).try_normalize();
    let edges = polygons.iter().flat_map(|polygon| polygon.windows(2).map(|pair| pair[1] - pair[0]));
    let mut seen = HashSet::new();
    let mut best: Option<(f64, DVec3)> = None;
    for direction in [wish].into_iter().chain(edges.take(EDGES)).filter_map(in_plane) {
        // Parallel edges give the same rectangle.
        if !seen.insert((direction * 1e6).round().to_array().map(f64::to_bits)) {
            continue;
        }
        let other = normal.cross(direction);
        let extent = |axis: DVec3| {
            let along = polygons.iter().flatten().map(|p| p.dot(axis));
            let (low, high) =
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        let area = extent(direction) * extent(other);
        // A rectangle that is hardly smaller does not justify another direction.
        if best.is_none_or(|(least, _)| area < least * (1.0 - 1e-6)) {
            best = Some((area, direction));
        }
    }
    let (_, direction) = best?;
    let other = normal.cross(direction);
    let candidates = [direction, -direction, other, -other];
    let up = candidates.into_iter().max_by(|a, b| a.dot(wish).total_cmp(&b.dot(wish)))?;
    Some((up.cross(seen_from), up))
}

/// The part of a convex polygon with coordinate `axis` at least (`above`) or at most `bound`.
pub(crate) fn clipped(polygon: &[DVec2], axis: usize, bound: f64, above: bool) -> Vec<DVec2> {
    let inside = |p: DVec2| if above { p[axis] >= bound } else { p[axis] <= bound };
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (&p, &q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        if inside(p) {
            kept.push(p);
        }
        if inside(p) != inside(q) {
            kept.push(p.lerp(q, (bound - p[axis]) / (q[axis] - p[axis])));
        }
    }
    kept
}

/// Area of a polygon, negative if it is clockwise.
pub(crate) fn signed_area(polygon: &[DVec2]) -> f64 {
    let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
    0.5 * pairs.map(|(p, q)| p.perp_dot(*q)).sum::<f64>()
}

/// Whether a convex polygon contains a point; the border counts as inside.
pub(crate) fn holds(polygon: &[DVec2], point: DVec2) -> bool {
    let mut turns =
        polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(p, q)| (*q - *p).perp_dot(point - *p));
    let rounding = 1e-14;
    turns.clone().all(|turn| turn >= -rounding) || turns.all(|turn| turn <= rounding)
}
