//! Cuts of elements along walls.

use std::collections::HashMap;

use glanz_math::DVec2;
use rayon::prelude::*;

use super::{Element, ElementError, Elements, MAX_ELEMENTS, ParameterPatch, Patch};
use crate::charts::{Chart, clip_left_of, flat_faces, undivided_charts, wall_lines};

/// Fraction of an element below which a piece that a wall cuts off is dropped.
const SMALLEST_PIECE: f64 = 1e-9;

/// Largest distance of the corner of a rectangle from that of its bounds, relative to its parameters.
const ROUNDING: f64 = 1e-12;

/// Smallest share of an element's width that a wall covers to cut it: light gets round shorter ones.
const SMALLEST_SHARE: f64 = 0.5;

/// Largest number of pieces of an element.
const MAX_PIECES: usize = 64;

/// Texels on the diagonal of the scene, at least, in the detection of walls.
const TEXELS_OF_SCENE: f64 = 256.0;

/// A segment of the sheet of a chart.
type Segment = [DVec2; 2];

impl Elements<'_> {
    /// Cuts flat elements where flat faces stand on them: an element has one radiosity, which would leak light through a wall.
    ///
    /// `density`: texels per metre; faces that end within half a texel above an element, or begin more than a fiftieth of one above it,
    /// cut nothing.
    ///
    /// # Errors
    /// [`ElementError::WallCuts`] if there would be too many elements.
    pub fn cut_at_walls(&mut self, density: f64) -> Result<(), ElementError> {
        let faces = flat_faces(&self.surfaces);
        let density =
            density.max(TEXELS_OF_SCENE / self.scene.bounds().diagonal().length().max(f64::MIN_POSITIVE));
        let lines = |chart: Chart| {
            let lines = wall_lines(self.surfaces.get(chart.surface as usize)?, &chart, &faces);
            (!lines.is_empty()).then_some((chart, lines))
        };
        let walls: Vec<(Chart, Vec<Segment>)> =
            undivided_charts(&self.surfaces, density).into_par_iter().filter_map(lines).collect();
        if walls.is_empty() {
            return Ok(());
        }
        let mut by_side: HashMap<(u32, u32, bool), &(Chart, Vec<Segment>)> = HashMap::new();
        for wall in &walls {
            let chart = &wall.0;
            by_side.extend(chart.faces().into_iter().map(|face| ((chart.surface, face, chart.back), wall)));
        }
        let mut list = Vec::with_capacity(self.list.len());
        for element in std::mem::take(&mut self.list) {
            let patch = element.patch;
            let walls = by_side.get(&(patch.surface, patch.face, patch.back));
            match walls.and_then(|(chart, lines)| pieces(chart, lines, &patch)) {
                Some(pieces) => {
                    let made =
                        pieces.into_iter().filter_map(|domain| self.element(Patch { domain, ..patch }));
                    list.extend(made.collect::<Vec<Element>>());
                }
                None => list.push(element),
            }
            if list.len() > MAX_ELEMENTS {
                return Err(ElementError::WallCuts { limit: MAX_ELEMENTS });
            }
        }
        self.list = list;
        Ok(())
    }
}

/// The pieces of a patch between lines on the sheet of its chart; `None` if none of them cuts it.
fn pieces(chart: &Chart, lines: &[Segment], patch: &Patch) -> Option<Vec<ParameterPatch>> {
    let corners = patch.domain.corners();
    let sheet =
        corners.iter().map(|&uv| chart.sheet_point(patch.face, uv)).collect::<Option<Vec<DVec2>>>()?;
    let [a, b, c] = *sheet.first_chunk::<3>()?;
    let whole = (b - a).perp_dot(c - a);
    let mut polygons = vec![sheet];
    for &line in lines {
        let mut next = Vec::with_capacity(polygons.len());
        for (i, polygon) in polygons.iter().enumerate() {
            let room = MAX_PIECES.saturating_sub(next.len() + polygons.len() - i);
            match halves(polygon, line, whole.abs()).filter(|_| room > 0) {
                Some(halves) => next.extend(halves),
                None => next.push(polygon.clone()),
            }
        }
        polygons = next;
    }
    if polygons.len() < 2 {
        return None;
    }
    // Parameters of the face are affine in those of the sheet.
    let parameters = |point: &DVec2| {
        let (s, t) = ((*point - a).perp_dot(c - a) / whole, (b - a).perp_dot(*point - a) / whole);
        corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0])
    };
    let of_polygon = |polygon: Vec<DVec2>| {
        let polygon: Vec<DVec2> = polygon.iter().map(parameters).collect();
        rectangle(&polygon).map_or_else(|| ParameterPatch::fan(&polygon), |part| vec![part])
    };
    Some(polygons.into_iter().flat_map(of_polygon).collect())
}

/// The parts of a convex polygon on both sides of a segment that covers most of its width; `None` if it does not, or one of them has less
/// than a tiny share of `area`.
fn halves(polygon: &[DVec2], [from, to]: Segment, area: f64) -> Option<[Vec<DVec2>; 2]> {
    let way = to - from;
    let is_left = |corner: &DVec2| way.perp_dot(*corner - from) >= 0.0;
    if polygon.iter().all(is_left) || !polygon.iter().any(is_left) {
        return None;
    }
    let halves = [clip_left_of(polygon, from, to), clip_left_of(polygon, to, from)];
    if halves.iter().any(|half| twice_area(half) < SMALLEST_PIECE * area) {
        return None;
    }
    // Where the line enters and leaves the polygon, as shares of the segment.
    let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crossings = ends.filter_map(|(&a, &b)| {
        let (here, there) = (way.perp_dot(a - from), way.perp_dot(b - from));
        let is_crossed = (here < 0.0) != (there < 0.0);
        is_crossed.then(|| way.dot(a.lerp(b, here / (here - there)) - from) / way.length_squared())
    });
    let (low, high) = crossings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    (high.min(1.0) - low.max(0.0) >= SMALLEST_SHARE * (high - low)).then_some(halves)
}

fn twice_area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    polygon.windows(2).map(|pair| (pair[0] - first).perp_dot(pair[1] - first)).sum::<f64>().abs()
}

/// A polygon as a rectangle of parameters, if it is one.
fn rectangle(corners: &[DVec2]) -> Option<ParameterPatch> {
    let min = corners.iter().fold(DVec2::INFINITY, |min, corner| min.min(*corner));
    let max = corners.iter().fold(DVec2::NEG_INFINITY, |max, corner| max.max(*corner));
    let near = ROUNDING * (1.0 + max.abs().max_element());
    let is_corner = |corner: &DVec2| {
        let [x, y] = [0, 1].map(|axis| (corner[axis] - min[axis]).min(max[axis] - corner[axis]));
        x <= near && y <= near
    };
    (corners.len() == 4 && corners.iter().all(is_corner)).then_some(ParameterPatch::Rectangle { min, max })
}
