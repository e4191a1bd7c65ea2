//! Charts: maps from surfaces to the rectangles of texels of light maps.
//!
//! A face over a square of parameters has a chart of its own; connected flat faces that lie nearly in one plane share a chart. Both
//! sides of a surface have charts. The middles of the outermost texels of a chart lie on its border, so that charts with a common edge
//! have texels at the same points there, patches of a freeform surface too, and bilinear filtering never leaves a chart. Flat charts are divided where thin walls stand on
//! them.

use std::collections::HashMap;
use std::sync::Arc;

use glanz_geometry::freeform::Freeform;
use glanz_geometry::{FaceDomain, Surface};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{ParametricPoint, PlacedSurface};
use rayon::prelude::*;

mod flat_sheet;
mod group;
mod pack;
mod parts;
#[cfg(test)]
mod tests;
mod wall;

pub use flat_sheet::{FlatSheet, FlatTriangle};
pub use pack::{AtlasSlot, Packing, pack};
pub(crate) use parts::clip_left_of;
pub use wall::ChartWall;
pub(crate) use wall::{flat_faces, wall_lines};

/// Side of the largest blocks of texels between whose corners light is interpolated; a power of two.
pub(crate) const BLOCK_SIDE: u32 = 8;

/// Longest side of a chart, texels; larger charts have fewer texels per metre than requested.
const MAX_SIDE: f64 = 4096.0;

/// Distance, texels, by which points on the border are moved inwards, and within which points at a thin wall count as behind it:
/// visibility on the common edge of two surfaces is undefined.
const INSET: f64 = 1e-3;

/// Distance beyond a wall, in units of the sheet, and beyond the window, relative to it, up to which a point is still on a chart: rounding.
const MAX_BEYOND_WALL: f64 = 1e-12;
const MAX_BEYOND_WINDOW: f64 = 1e-9;

/// Points per side at which the stretch of a face is evaluated; more for trimmed faces, to find what is left of them.
const STRETCH_POINTS: u32 = 9;
const TRIMMED_POINTS: u32 = 65;

/// The plane that a chart is a rectangle of.
#[derive(Clone, Debug)]
pub enum Sheet {
    /// The unit square of the parameters of a face with this number.
    Square(u32),
    /// Projected flat faces, metres.
    Flat(FlatSheet),
}

impl Sheet {
    /// Upper right corner of the sheet; its lower left corner is the origin.
    #[must_use]
    pub fn size(&self) -> DVec2 {
        match self {
            Self::Square(_) => DVec2::ONE,
            Self::Flat(flat) => flat.size(),
        }
    }
}

/// A rectangle of a sheet, divided into texels.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Number of the surface in [`Scene::placed_surfaces`](glanz_scene::Scene::placed_surfaces).
    pub surface: u32,
    /// Number of the shape that its faces belong to.
    pub shape: u32,
    /// Whether it is the side opposite to the normal.
    pub back: bool,
    /// The sheet.
    pub sheet: Arc<Sheet>,
    /// Lower left and upper right corner of the rectangle on the sheet.
    pub window: [DVec2; 2],
    /// Thin walls on the sheet; the chart shows the part on the left of each. The charts on both sides of a wall overlap by some texels,
    /// except behind the wall.
    pub walls: Vec<ChartWall>,
    /// Texels along both axes, at least 2 each.
    pub size: [u32; 2],
    /// Whether there are fewer texels per metre than requested.
    pub is_coarse: bool,
}

impl Chart {
    /// Number of texels.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// The point of the sheet at a position in texels, (0, 0) in the middle of the first texel.
    #[must_use]
    pub fn to_sheet(&self, texel: DVec2) -> DVec2 {
        let [min, max] = self.window;
        min + texel / self.last_texel() * (max - min)
    }

    /// Position of the last texel, texels.
    fn last_texel(&self) -> DVec2 {
        DVec2::new(f64::from(self.size[0]) - 1.0, f64::from(self.size[1]) - 1.0)
    }

    /// Face and parameters at a point of the sheet, regardless of trimming; `None` beyond its faces.
    #[must_use]
    pub fn parameters(&self, point: DVec2) -> Option<(u32, DVec2)> {
        match &*self.sheet {
            Sheet::Square(face) => {
                let inside = point.cmpge(DVec2::ZERO).all() && point.cmple(DVec2::ONE).all();
                inside.then_some((*face, point))
            }
            Sheet::Flat(flat) => flat.parameters(point),
        }
    }

    /// The point of the sheet with these parameters; `None` if the face is not on it.
    #[must_use]
    pub fn sheet_point(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        match &*self.sheet {
            Sheet::Square(own) => (*own == face).then_some(uv),
            Sheet::Flat(flat) => flat.sheet_point(face, uv),
        }
    }

    /// Position in texels of a point of the sheet, regardless of walls and of the window.
    pub(crate) fn texel_at(&self, sheet: DVec2) -> DVec2 {
        let [min, max] = self.window;
        ((sheet - min) / (max - min)).clamp(DVec2::ZERO, DVec2::ONE) * self.last_texel()
    }

    /// Position in texels of a point of a face; `None` if the chart does not show it.
    #[must_use]
    pub fn to_texel(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        let point = self.sheet_point(face, uv)?;
        let is_beyond = |wall: &ChartWall| {
            let [from, to] = wall.ends;
            (to - from).perp_dot(point - from) < -MAX_BEYOND_WALL * from.distance(to)
        };
        if self.walls.iter().any(is_beyond) {
            return None;
        }
        let [min, max] = self.window;
        let share = (point - min) / (max - min);
        let slack = DVec2::splat(MAX_BEYOND_WINDOW);
        let inside = share.cmpge(-slack).all() && share.cmple(DVec2::ONE + slack).all();
        inside.then(|| self.texel_at(point))
    }

    /// The part of a polygon of the sheet that the chart shows. The polygon must be convex if a wall crosses it.
    #[must_use]
    pub fn clip(&self, polygon: &[DVec2]) -> Vec<DVec2> {
        let clip =
            |left: Vec<DVec2>, &ChartWall { ends: [from, to], .. }: &ChartWall| clip_left_of(&left, from, to);
        self.walls.iter().fold(polygon.to_vec(), clip)
    }

    /// Numbers of the faces of the sheet.
    pub fn faces(&self) -> Vec<u32> {
        match &*self.sheet {
            Sheet::Square(face) => vec![*face],
            Sheet::Flat(flat) => flat.faces(),
        }
    }

    /// Points that represent a texel: four around its middle, along the border for texels on it; if none of them is on the surface, the
    /// nearest point that is, up to a texel away.
    #[must_use]
    pub fn texel_points(&self, surface: &PlacedSurface<'_>, texel: [u32; 2]) -> Vec<ParametricPoint> {
        let middle = DVec2::new(f64::from(texel[0]), f64::from(texel[1]));
        let mut points: Vec<ParametricPoint> = Vec::with_capacity(4);
        let spread = |axis: usize| {
            if texel[axis] == 0 || texel[axis] + 1 == self.size[axis] { 0.0 } else { 0.25 }
        };
        let spread = DVec2::new(spread(0), spread(1));
        for corner in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let place = self.surface_point(surface, middle + DVec2::from_array(corner) * spread);
            if let Some(place) = place.filter(|place| !points.contains(place)) {
                points.push(place);
            }
        }
        if points.is_empty() {
            let near =
                NEARBY.iter().find_map(|&[x, y]| self.surface_point(surface, middle + DVec2::new(x, y)));
            points.extend(near);
        }
        points
    }

    /// Texels per unit of the sheet along both axes.
    pub(crate) fn texels_per_unit(&self) -> DVec2 {
        self.last_texel() / (self.window[1] - self.window[0])
    }

    /// Whether a point of the sheet lies beneath a wall, or a wall separates it from the part that the chart shows.
    pub(crate) fn is_behind_wall(&self, point: DVec2) -> bool {
        let scale = self.texels_per_unit();
        self.walls.iter().any(|&ChartWall { ends: [from, to], half_thickness }| {
            let (way, there) = (scale * (to - from), scale * (point - from));
            // Visibility on the common edge of two surfaces is undefined.
            way.perp_dot(there) <= (half_thickness + INSET) * way.length()
                && (0.0..=way.length_squared()).contains(&way.dot(there))
        })
    }

    /// The point of the surface at a position in texels; `None` where there is no surface, or behind a wall.
    #[must_use]
    pub fn surface_point(&self, surface: &PlacedSurface<'_>, texel: DVec2) -> Option<ParametricPoint> {
        let inside = texel.clamp(DVec2::splat(INSET), self.last_texel() - INSET);
        let point = self.to_sheet(inside);
        if self.is_behind_wall(point) {
            return None;
        }
        let (face, uv) = self.parameters(point)?;
        if surface.is_trimmed() && surface.at(face, uv, self.back).is_none() {
            return None;
        }
        Some(ParametricPoint { surface: self.surface, face, back: self.back, uv })
    }
}

/// Offsets from a texel, by distance.
const NEARBY: [[f64; 2]; 20] = [
    [0.5, 0.0],
    [-0.5, 0.0],
    [0.0, 0.5],
    [0.0, -0.5],
    [0.5, 0.5],
    [-0.5, 0.5],
    [0.5, -0.5],
    [-0.5, -0.5],
    [0.95, 0.0],
    [-0.95, 0.0],
    [0.0, 0.95],
    [0.0, -0.95],
    [0.95, 0.5],
    [-0.95, 0.5],
    [0.95, -0.5],
    [-0.95, -0.5],
    [0.5, 0.95],
    [-0.5, 0.95],
    [0.5, -0.95],
    [-0.5, -0.95],
];

/// Charts of both sides of all faces of `surfaces`, divided at thin walls, with at least `density` texels per metre, a finite number above
/// 0 (up to 4096 texels along a side).
#[must_use]
pub fn charts(surfaces: &[PlacedSurface<'_>], density: f64) -> Vec<Chart> {
    let faces = flat_faces(surfaces);
    let divided: Vec<Vec<Chart>> = undivided_charts(surfaces, density)
        .into_par_iter()
        .map(|chart| {
            let walls = wall::thin_walls(&surfaces[chart.surface as usize], &chart, &faces);
            parts::divide_at_walls(chart, &walls)
        })
        .collect();
    divided.into_iter().flatten().collect()
}

/// As [`charts`], not divided at thin walls.
pub(crate) fn undivided_charts(surfaces: &[PlacedSurface<'_>], density: f64) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (number, surface) in (0..).zip(surfaces).filter(|(_, surface)| !surface.is_passable()) {
        let (mut flat, mut square) = (Vec::new(), Vec::new());
        for face in 0..surface.faces() {
            match surface.face_domain(face) {
                FaceDomain::Polygon(_) => flat.push(face),
                FaceDomain::Square => square.extend(ChartExtent::new(surface, face)),
            }
        }
        if let Surface::Freeform(freeform) = surface.surface() {
            adapt_to_neighbours(freeform, &mut square);
        }
        for ChartExtent { face, window, stretch } in square {
            let sheet = Arc::new(Sheet::Square(face));
            let shape = surface.shape(face);
            add_both_sides(&mut charts, [number, shape], &sheet, window, stretch * density);
        }
        for group in group::groups(surface, &flat) {
            let (shape, size, shrink) = (surface.shape(group.faces()[0]), group.size(), group.shrink());
            let sheet = Arc::new(Sheet::Flat(group));
            add_both_sides(
                &mut charts,
                [number, shape],
                &sheet,
                [DVec2::ZERO, size],
                DVec2::splat(density / shrink),
            );
        }
    }
    charts
}

/// Adds the charts of both sides of a sheet. `density`: texels per unit of the sheet.
fn add_both_sides(
    charts: &mut Vec<Chart>,
    [surface, shape]: [u32; 2],
    sheet: &Arc<Sheet>,
    window: [DVec2; 2],
    density: DVec2,
) {
    let wanted = (density * (window[1] - window[0]) * (1.0 - MAX_BEYOND_WINDOW)).ceil() + 1.0;
    let is_coarse = wanted.max_element() > MAX_SIDE;
    let size = wanted.clamp(DVec2::splat(2.0), DVec2::splat(MAX_SIDE)).to_array().map(|n| n as u32);
    for back in [false, true] {
        let sheet = Arc::clone(sheet);
        charts.push(Chart { surface, shape, back, sheet, window, walls: Vec::new(), size, is_coarse });
    }
}

/// Extent of the chart of a face over a square of parameters.
struct ChartExtent {
    face: u32,
    /// Bounds of its parameters after trimming.
    window: [DVec2; 2],
    /// Largest speeds of the position along both parameters, metres.
    stretch: DVec2,
}

/// Gives patches that share a range of a parameter of their surface the same window and stretch along it, so that their charts have texels at
/// the same points of common sides.
fn adapt_to_neighbours(freeform: &Freeform, faces: &mut [ChartExtent]) {
    for axis in [0, 1] {
        let range = |extent: &ChartExtent| {
            [0.0, 1.0].map(|end| freeform.parameters(extent.face, end, end).map(|uv| uv[axis].to_bits()))
        };
        let mut shared: HashMap<[Option<u64>; 2], [f64; 3]> = HashMap::new();
        for extent in faces.iter() {
            let own = [extent.window[0][axis], extent.window[1][axis], extent.stretch[axis]];
            let [low, high, stretch] = shared.entry(range(extent)).or_insert(own);
            (*low, *high, *stretch) = (low.min(own[0]), high.max(own[1]), stretch.max(own[2]));
        }
        for extent in faces.iter_mut() {
            let Some([low, high, stretch]) = shared.get(&range(extent)) else { continue };
            (extent.window[0][axis], extent.window[1][axis], extent.stretch[axis]) = (*low, *high, *stretch);
        }
    }
}

impl ChartExtent {
    /// `None` if trimming leaves nothing of the face.
    fn new(surface: &PlacedSurface<'_>, face: u32) -> Option<Self> {
        let count = if surface.is_trimmed() { TRIMMED_POINTS } else { STRETCH_POINTS };
        let step = 1.0 / f64::from(count - 1);
        let at = |uv: DVec2| surface.at(face, uv, false).map(|at| at.at.point.position);
        let (mut min, mut max, mut speed) = (DVec2::INFINITY, DVec2::NEG_INFINITY, DVec2::ZERO);
        let h = 0.01 * step;
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let uv = DVec2::new(f64::from(i), f64::from(j)) * step;
            let Some(here) = at(uv) else { continue };
            (min, max) = (min.min(uv), max.max(uv));
            let along = |axis: DVec2| {
                let other = if uv.dot(axis) > 0.5 { uv - h * axis } else { uv + h * axis };
                at(other).map_or(0.0, |there: DVec3| there.distance(here) / h)
            };
            speed = speed.max(DVec2::new(along(DVec2::X), along(DVec2::Y)));
        }
        if !(max.cmpge(min).all() && speed.is_finite()) {
            return None;
        }
        let margin = if surface.is_trimmed() { step } else { 0.0 };
        let window = [(min - margin).max(DVec2::ZERO), (max + margin).min(DVec2::ONE)];
        Some(Self { face, window, stretch: speed })
    }
}
