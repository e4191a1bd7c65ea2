//! Charts: surfaces laid flat, so that a light map can be kept of them.
//!
//! A face over a square of parameters is a chart of its own; flat faces that hang together and lie nearly in a plane share one. Both
//! sides of a surface have charts. The outermost texels of a chart have their middles on its border, so that charts that meet in an
//! edge keep light for the very same points there, and bilinear filtering never leaves a chart. Flat charts are parted where thin walls
//! stand on them.

use std::sync::Arc;

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3};
use glanz_scene::{ParametricPoint, PlacedSurface};
use rayon::prelude::*;

mod flat;
mod group;
mod pack;
mod parts;
#[cfg(test)]
mod tests;
mod wall;

pub use flat::{Flat, FlatTriangle};
pub use pack::{Packed, Slot, pack};
pub(crate) use parts::left_of;

/// Side of the largest blocks of texels between whose corners light is interpolated; a power of two.
pub(crate) const BLOCK: u32 = 8;

/// Texels along a side of a chart at most; larger ones keep less than was asked for.
const LONGEST: f64 = 4096.0;

/// Distance from the border within which a place is moved inwards, in texels, and from a thin wall within which it counts as behind it: on an
/// edge of two walls it is not decided what is seen.
const INWARDS: f64 = 1e-3;

/// Places per side at which the stretch of a face is looked at, and those at which a trimmed one is looked for.
const STRETCH: u32 = 9;
const KEPT: u32 = 65;

/// What a chart shows, laid flat.
#[derive(Clone, Debug)]
pub enum Sheet {
    /// A face over the unit square of its parameters.
    Square(u32),
    /// Flat faces, in metres.
    Flat(Flat),
}

impl Sheet {
    /// Far corner of the sheet, whose near corner is the origin.
    #[must_use]
    pub fn size(&self) -> DVec2 {
        match self {
            Self::Square(_) => DVec2::ONE,
            Self::Flat(flat) => flat.size(),
        }
    }
}

/// A rectangle of a sheet in texels.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Number of the surface in [`Scene::placed_surfaces`](glanz_scene::Scene::placed_surfaces).
    pub surface: u32,
    /// Number of the shape that it belongs to.
    pub shape: u32,
    /// Whether it is the side that the normal does not point to.
    pub back: bool,
    /// What it shows.
    pub sheet: Arc<Sheet>,
    /// The part of the sheet.
    pub window: [DVec2; 2],
    /// Thin walls on the sheet that bound what is shown: it is to the left of their lines. The two charts on both sides of a wall overlap by
    /// some texels, but for those that lie behind the wall.
    pub walls: Vec<[DVec2; 2]>,
    /// Texels, at least 2 each.
    pub size: [u32; 2],
    /// Whether there are fewer texels than were asked for.
    pub is_coarse: bool,
}

impl Chart {
    /// Number of texels.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// The point of the sheet in texels: (0, 0) is the middle of the first one.
    #[must_use]
    pub fn to_sheet(&self, texel: DVec2) -> DVec2 {
        let [min, max] = self.window;
        min + texel / self.last() * (max - min)
    }

    fn last(&self) -> DVec2 {
        DVec2::new(f64::from(self.size[0]) - 1.0, f64::from(self.size[1]) - 1.0)
    }

    /// Face and parameters of a point of the sheet; `None` beyond its faces. What trimming takes away is not looked at.
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
    pub fn on_sheet(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        match &*self.sheet {
            Sheet::Square(own) => (*own == face).then_some(uv),
            Sheet::Flat(flat) => flat.on_sheet(face, uv),
        }
    }

    /// The place in texels with these parameters; `None` outside of what the chart shows.
    #[must_use]
    pub fn to_texel(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        let point = self.on_sheet(face, uv)?;
        let is_beyond = |[from, to]: &[DVec2; 2]| {
            let way = *to - *from;
            way.perp_dot(point - *from) < -1e-12 * way.length()
        };
        if self.walls.iter().any(is_beyond) {
            return None;
        }
        let [min, max] = self.window;
        let share = (point - min) / (max - min);
        let slack = DVec2::splat(1e-9);
        let inside = share.cmpge(-slack).all() && share.cmple(DVec2::ONE + slack).all();
        inside.then_some(share.clamp(DVec2::ZERO, DVec2::ONE) * self.last())
    }

    /// What it shows of a polygon of the sheet, which is convex where a wall crosses it.
    #[must_use]
    pub fn shown(&self, polygon: &[DVec2]) -> Vec<DVec2> {
        self.walls.iter().fold(polygon.to_vec(), |left, &[from, to]| left_of(&left, from, to))
    }

    /// The faces that it shows.
    pub fn faces(&self) -> Vec<u32> {
        match &*self.sheet {
            Sheet::Square(face) => vec![*face],
            Sheet::Flat(flat) => flat.faces(),
        }
    }

    /// Places that a texel stands for: four around its middle, along the border if it lies there; if none is on the surface, the
    /// nearest one that is, up to a texel away.
    #[must_use]
    pub fn places(&self, surface: &PlacedSurface<'_>, texel: [u32; 2]) -> Vec<ParametricPoint> {
        let middle = DVec2::new(f64::from(texel[0]), f64::from(texel[1]));
        let mut places: Vec<ParametricPoint> = Vec::with_capacity(4);
        let spread = |axis: usize| {
            if texel[axis] == 0 || texel[axis] + 1 == self.size[axis] { 0.0 } else { 0.25 }
        };
        let spread = DVec2::new(spread(0), spread(1));
        for corner in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let place = self.place(surface, middle + DVec2::from_array(corner) * spread);
            if let Some(place) = place.filter(|place| !places.contains(place)) {
                places.push(place);
            }
        }
        if places.is_empty() {
            let near = NEARBY.iter().find_map(|&[x, y]| self.place(surface, middle + DVec2::new(x, y)));
            places.extend(near);
        }
        places
    }

    /// Texels per unit of the sheet along both.
    pub(crate) fn texels_per_unit(&self) -> DVec2 {
        self.last() / (self.window[1] - self.window[0])
    }

    /// Whether a wall stands between a point of the sheet and what the chart shows.
    pub(crate) fn is_behind_a_wall(&self, point: DVec2) -> bool {
        let scale = self.texels_per_unit();
        self.walls.iter().any(|&[from, to]| {
            let (way, there) = (scale * (to - from), scale * (point - from));
            // What lies right beneath a sheet is seen from either side.
            way.perp_dot(there) <= INWARDS * way.length()
                && (0.0..=way.length_squared()).contains(&way.dot(there))
        })
    }

    /// The place at a point in texels; `None` where there is no surface, or one behind a wall.
    #[must_use]
    pub fn place(&self, surface: &PlacedSurface<'_>, texel: DVec2) -> Option<ParametricPoint> {
        let inside = texel.clamp(DVec2::splat(INWARDS), self.last() - INWARDS);
        let point = self.to_sheet(inside);
        if self.is_behind_a_wall(point) {
            return None;
        }
        let (face, uv) = self.parameters(point)?;
        if surface.is_trimmed() && surface.at(face, uv, self.back).is_none() {
            return None;
        }
        Some(ParametricPoint { surface: self.surface, face, back: self.back, uv })
    }
}

/// Points around a texel, by distance.
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

/// Charts of all faces of `surfaces`, parted by thin walls, with at least `density` texels per metre everywhere.
#[must_use]
pub fn charts(surfaces: &[PlacedSurface<'_>], density: f64) -> Vec<Chart> {
    let mut charts = Vec::new();
    let faces = wall::faces(surfaces);
    for (number, surface) in (0..).zip(surfaces).filter(|(_, surface)| !surface.is_passable()) {
        let (mut flat, mut whole) = (Vec::new(), Vec::new());
        for face in 0..surface.faces() {
            match surface.face_domain(face) {
                FaceDomain::Polygon(_) => flat.push(face),
                FaceDomain::Square => {
                    if let Some((window, stretch)) = stretch(surface, face) {
                        let sheet = Arc::new(Sheet::Square(face));
                        let shape = surface.shape(face);
                        both(&mut whole, [number, shape], &sheet, window, stretch * density);
                    }
                }
            }
        }
        for group in group::groups(surface, &flat) {
            let (shape, size, shrink) = (surface.shape(group.faces()[0]), group.size(), group.shrink());
            let sheet = Arc::new(Sheet::Flat(group));
            both(&mut whole, [number, shape], &sheet, [DVec2::ZERO, size], DVec2::splat(density / shrink));
        }
        let parted: Vec<Vec<Chart>> = whole
            .into_par_iter()
            .map(|chart| {
                let walls = wall::walls(surface, &chart, &faces);
                parts::parted(chart, &walls)
            })
            .collect();
        charts.extend(parted.into_iter().flatten());
    }
    charts
}

/// Adds the charts of both sides; `density`: texels per unit of the sheet.
fn both(
    charts: &mut Vec<Chart>,
    [surface, shape]: [u32; 2],
    sheet: &Arc<Sheet>,
    window: [DVec2; 2],
    density: DVec2,
) {
    let wanted = (density * (window[1] - window[0]) * (1.0 - 1e-9)).ceil() + 1.0;
    let is_coarse = wanted.max_element() > LONGEST;
    let size = wanted.clamp(DVec2::splat(2.0), DVec2::splat(LONGEST)).to_array().map(|n| n as u32);
    for back in [false, true] {
        let sheet = Arc::clone(sheet);
        charts.push(Chart { surface, shape, back, sheet, window, walls: Vec::new(), size, is_coarse });
    }
}

/// The part of a face's parameters that is kept, and the largest speeds of the position along both, m; `None` if nothing is found.
fn stretch(surface: &PlacedSurface<'_>, face: u32) -> Option<([DVec2; 2], DVec2)> {
    let count = if surface.is_trimmed() { KEPT } else { STRETCH };
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
    Some(([(min - margin).max(DVec2::ZERO), (max + margin).min(DVec2::ONE)], speed))
}
