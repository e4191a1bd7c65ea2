//! Triangles of surfaces, to show light maps on.
//!
//! Vertices lie on the surface and have its normals. All faces of a surface are divided at the same parameters, so that there are no
//! gaps between them; trimmed faces end in points on the trimming curves.

use std::collections::HashMap;

use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use crate::charts::{Chart, Sheet};

mod cut;
mod divide;
#[cfg(test)]
mod tests;

pub use divide::divisions;

/// Triangles of one side of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Metres.
    pub positions: Vec<DVec3>,
    /// Unit normals on the side of the chart: those for shading.
    pub normals: Vec<DVec3>,
    /// The surface's own texture coordinates.
    pub uvs: Vec<DVec2>,
    /// Points of the chart in texels, (0, 0) in the middle of the first.
    pub texels: Vec<DVec2>,
    /// Triples of vertices, counterclockwise seen from the side of the chart.
    pub indices: Vec<[u32; 3]>,
}

/// Triangles of a chart. `divisions`: those of its surface; `tolerance`: distance to trimming curves at most, metres.
#[must_use]
pub fn tessellate(
    surface: &PlacedSurface<'_>,
    chart: &Chart,
    divisions: [u32; 2],
    tolerance: f64,
) -> Triangles {
    let mut maker = Maker { surface, chart, made: Triangles::default(), known: HashMap::new() };
    match &*chart.sheet {
        Sheet::Flat(flat) if !surface.is_trimmed() => {
            for triangle in flat.triangles() {
                if chart.walls.is_empty() {
                    // Corners by their own parameters: neighbours may have other normals there.
                    let corners = triangle.parameters.map(|uv| maker.vertex(triangle.face, uv));
                    maker.triangle(corners);
                } else {
                    let polygon = chart.shown(&triangle.corners);
                    let vertices: Vec<Option<u32>> = polygon
                        .iter()
                        .map(|&point| maker.vertex(triangle.face, triangle.at(point)))
                        .collect();
                    maker.polygon(&polygon, &vertices);
                }
            }
        }
        _ => maker.grid(divisions, tolerance),
    }
    maker.made
}

/// Triangles in the making.
struct Maker<'a> {
    surface: &'a PlacedSurface<'a>,
    chart: &'a Chart,
    made: Triangles,
    /// Vertices by what tells them apart.
    known: HashMap<[u64; 8], u32>,
}

impl Maker<'_> {
    /// The vertex at parameters of a face; `None` where there is no surface.
    fn vertex(&mut self, face: u32, uv: DVec2) -> Option<u32> {
        let at = self.surface.at(face, uv, self.chart.back)?.at;
        let side = if at.point.normal.dot(at.wo) < 0.0 { -1.0 } else { 1.0 };
        let (position, normal) = (at.point.position, side * at.point.shading_normal);
        let sheet = self.chart.on_sheet(face, uv)?;
        let key = [position.x, position.y, position.z, normal.x, normal.y, normal.z, sheet.x, sheet.y];
        let next = u32::try_from(self.made.positions.len()).ok()?;
        let number = *self.known.entry(key.map(|x| (x + 0.0).to_bits())).or_insert(next);
        if number == next {
            let [min, max] = self.chart.window;
            let last = DVec2::new(f64::from(self.chart.size[0]) - 1.0, f64::from(self.chart.size[1]) - 1.0);
            self.made.positions.push(position);
            self.made.normals.push(normal);
            self.made.uvs.push(at.point.uv);
            self.made.texels.push(((sheet - min) / (max - min)).clamp(DVec2::ZERO, DVec2::ONE) * last);
        }
        Some(number)
    }

    /// Adds a triangle, turned to the side of the chart; one without area is left out.
    fn triangle(&mut self, corners: [Option<u32>; 3]) {
        let [Some(a), Some(b), Some(c)] = corners else { return };
        let position = |i: u32| self.made.positions[i as usize];
        let normal = (position(b) - position(a)).cross(position(c) - position(a));
        let side: DVec3 = [a, b, c].into_iter().map(|i| self.made.normals[i as usize]).sum();
        if normal == DVec3::ZERO {
            return;
        }
        self.made.indices.push(if normal.dot(side) < 0.0 { [a, c, b] } else { [a, b, c] });
    }

    /// Adds a polygon of the sheet.
    fn polygon(&mut self, polygon: &[DVec2], vertices: &[Option<u32>]) {
        for [a, b, c] in cut::triangles(polygon) {
            self.triangle([vertices[a], vertices[b], vertices[c]]);
        }
    }

    /// Triangles over a grid of the sheet.
    fn grid(&mut self, [columns, rows]: [u32; 2], tolerance: f64) {
        let size = match &*self.chart.sheet {
            Sheet::Square(_) => DVec2::ONE,
            Sheet::Flat(flat) => flat.size(),
        };
        let at = |i: u32, j: u32| {
            DVec2::new(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows)) * size
        };
        let (surface, chart) = (self.surface, self.chart);
        let is_kept = |point: DVec2| {
            chart.parameters(point).is_some_and(|(face, uv)| surface.at(face, uv, false).is_some())
        };
        let position = |point: DVec2| {
            let (face, uv) = chart.parameters(point)?;
            Some(surface.at(face, uv, false)?.at.point.position)
        };
        let kept: Vec<bool> = (0..=rows)
            .flat_map(|j| (0..=columns).map(move |i| (i, j)))
            .map(|(i, j)| is_kept(at(i, j)))
            .collect();
        let kept = |i: u32, j: u32| kept[(j * (columns + 1) + i) as usize];
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let cell = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let corners = cell.map(|[i, j]| at(i, j));
            let flags = cell.map(|[i, j]| kept(i, j));
            for polygon in cut::cut(corners, flags, &is_kept, &position, tolerance) {
                let polygon = if chart.walls.is_empty() { polygon } else { chart.shown(&polygon) };
                let vertices: Vec<Option<u32>> = polygon
                    .iter()
                    .map(|&point| chart.parameters(point).and_then(|(face, uv)| self.vertex(face, uv)))
                    .collect();
                self.polygon(&polygon, &vertices);
            }
        }
    }
}
