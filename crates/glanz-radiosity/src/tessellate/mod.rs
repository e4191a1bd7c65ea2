//! Triangles of surfaces, for the display of light maps.
//!
//! Vertices lie on the surface and have its normals. All faces of a surface are divided at the same parameters, which leaves no gaps
//! between them; borders of trimmed faces have vertices on the trimming curves.

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
    /// Positions of the vertices, metres.
    pub positions: Vec<DVec3>,
    /// Unit shading normals on the side of the chart.
    pub normals: Vec<DVec3>,
    /// Texture coordinates of the surface.
    pub uvs: Vec<DVec2>,
    /// Positions on the chart in texels, (0, 0) in the middle of the first texel.
    pub texels: Vec<DVec2>,
    /// Vertices of each triangle, counterclockwise seen from the side of the chart.
    pub indices: Vec<[u32; 3]>,
}

/// Triangles of a chart. `divisions`: those of its surface, see [`divisions`]; `tolerance`: largest distance from trimming curves, metres.
#[must_use]
pub fn tessellate(
    surface: &PlacedSurface<'_>,
    chart: &Chart,
    divisions: [u32; 2],
    tolerance: f64,
) -> Triangles {
    let mut triangulator =
        ChartTriangulator { surface, chart, triangles: Triangles::default(), numbers: HashMap::new() };
    match &*chart.sheet {
        Sheet::Flat(flat) if !surface.is_trimmed() => {
            for triangle in flat.triangles() {
                if chart.walls.is_empty() {
                    // Vertices are made from the parameters of each face, since neighbours may have other normals there.
                    let corners = triangle.parameters.map(|uv| triangulator.vertex(triangle.face, uv));
                    triangulator.triangle(corners);
                } else {
                    let polygon = chart.clip(&triangle.corners);
                    let vertices: Vec<Option<u32>> = polygon
                        .iter()
                        .map(|&point| triangulator.vertex(triangle.face, triangle.at(point)))
                        .collect();
                    triangulator.polygon(&polygon, &vertices);
                }
            }
        }
        _ => triangulator.grid(divisions, tolerance),
    }
    triangulator.triangles
}

/// Builder of the triangles of a chart.
struct ChartTriangulator<'a> {
    surface: &'a PlacedSurface<'a>,
    chart: &'a Chart,
    triangles: Triangles,
    /// Numbers of the vertices by position, normal and point of the sheet.
    numbers: HashMap<[u64; 8], u32>,
}

impl ChartTriangulator<'_> {
    /// The vertex at parameters of a face; `None` where there is no surface.
    fn vertex(&mut self, face: u32, uv: DVec2) -> Option<u32> {
        let at = self.surface.at(face, uv, self.chart.back)?.at;
        let side = if at.point.normal.dot(at.wo) < 0.0 { -1.0 } else { 1.0 };
        let (position, normal) = (at.point.position, side * at.point.shading_normal);
        let sheet = self.chart.sheet_point(face, uv)?;
        let key = [position.x, position.y, position.z, normal.x, normal.y, normal.z, sheet.x, sheet.y];
        let next = u32::try_from(self.triangles.positions.len()).ok()?;
        let number = *self.numbers.entry(key.map(|x| (x + 0.0).to_bits())).or_insert(next);
        if number == next {
            self.triangles.positions.push(position);
            self.triangles.normals.push(normal);
            self.triangles.uvs.push(at.point.uv);
            self.triangles.texels.push(self.chart.texel_at(sheet));
        }
        Some(number)
    }

    /// Adds a triangle, oriented to the side of the chart; one without area is dropped.
    fn triangle(&mut self, corners: [Option<u32>; 3]) {
        let [Some(a), Some(b), Some(c)] = corners else { return };
        let position = |i: u32| self.triangles.positions[i as usize];
        let normal = (position(b) - position(a)).cross(position(c) - position(a));
        let side: DVec3 = [a, b, c].into_iter().map(|i| self.triangles.normals[i as usize]).sum();
        if normal == DVec3::ZERO {
            return;
        }
        self.triangles.indices.push(if normal.dot(side) < 0.0 { [a, c, b] } else { [a, b, c] });
    }

    /// Adds the triangles of a polygon of the sheet.
    fn polygon(&mut self, polygon: &[DVec2], vertices: &[Option<u32>]) {
        for [a, b, c] in cut::triangles(polygon) {
            self.triangle([vertices[a], vertices[b], vertices[c]]);
        }
    }

    /// Adds the triangles of a grid over the sheet.
    fn grid(&mut self, [columns, rows]: [u32; 2], tolerance: f64) {
        let size = self.chart.sheet.size();
        let at = |i: u32, j: u32| {
            DVec2::new(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows)) * size
        };
        let (surface, chart) = (self.surface, self.chart);
        let position = |point: DVec2| {
            let (face, uv) = chart.parameters(point)?;
            Some(surface.at(face, uv, false)?.at.point.position)
        };
        let is_kept = |point: DVec2| position(point).is_some();
        let kept: Vec<bool> = (0..=rows)
            .flat_map(|j| (0..=columns).map(move |i| (i, j)))
            .map(|(i, j)| is_kept(at(i, j)))
            .collect();
        let kept = |i: u32, j: u32| kept[(j * (columns + 1) + i) as usize];
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let cell = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let corners = cell.map(|[i, j]| at(i, j));
            let flags = cell.map(|[i, j]| kept(i, j));
            for polygon in cut::clip_cell(corners, flags, &is_kept, &position, tolerance) {
                let polygon = if chart.walls.is_empty() { polygon } else { chart.clip(&polygon) };
                let vertices: Vec<Option<u32>> = polygon
                    .iter()
                    .map(|&point| chart.parameters(point).and_then(|(face, uv)| self.vertex(face, uv)))
                    .collect();
                self.polygon(&polygon, &vertices);
            }
        }
    }
}
