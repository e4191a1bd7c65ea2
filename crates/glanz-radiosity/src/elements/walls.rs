//! Cuts of elements along thin walls.

use glanz_math::DVec2;

use super::{Element, ElementError, Elements, MAX_ELEMENTS, ParameterPatch, Patch};
use crate::charts::{Chart, charts};

/// Fraction of an element below which a piece that a wall cuts off is dropped.
const SMALLEST_PIECE: f64 = 1e-9;

impl Elements<'_> {
    /// Cuts flat elements along the middles of thin walls that stand on them: an element has one radiosity, which would leak light
    /// through the wall.
    ///
    /// `density`: texels per metre; the walls are those at which [`charts`] of that density are divided.
    ///
    /// # Errors
    /// [`ElementError::WallCuts`] if there would be too many elements.
    pub fn cut_at_walls(&mut self, density: f64) -> Result<(), ElementError> {
        let charts = charts(&self.surfaces, density);
        let parted: Vec<&Chart> = charts.iter().filter(|chart| !chart.walls.is_empty()).collect();
        if parted.is_empty() {
            return Ok(());
        }
        let mut list = Vec::with_capacity(self.list.len());
        for element in std::mem::take(&mut self.list) {
            let patch = element.patch;
            let of_side = |chart: &&&Chart| chart.surface == patch.surface && chart.back == patch.back;
            let pieces: Vec<Vec<ParameterPatch>> =
                parted.iter().filter(of_side).filter_map(|chart| pieces(chart, &patch)).collect();
            if element.polygon.is_none() || pieces.len() < 2 {
                list.push(element);
                continue;
            }
            let made =
                pieces.into_iter().flatten().filter_map(|part| self.element(Patch { domain: part, ..patch }));
            list.extend(made.collect::<Vec<Element>>());
            if list.len() > MAX_ELEMENTS {
                return Err(ElementError::WallCuts { limit: MAX_ELEMENTS });
            }
        }
        self.list = list;
        Ok(())
    }
}

/// The pieces of a patch that a chart shows; `None` if it shows nothing.
fn pieces(chart: &Chart, patch: &Patch) -> Option<Vec<ParameterPatch>> {
    let corners = patch.domain.corners();
    let sheet =
        corners.iter().map(|&uv| chart.sheet_point(patch.face, uv)).collect::<Option<Vec<DVec2>>>()?;
    let [a, b, c] = *sheet.first_chunk::<3>()?;
    let whole = (b - a).perp_dot(c - a);
    // A chart shows the left side of its walls.
    let sheet = if whole < 0.0 { sheet.into_iter().rev().collect() } else { sheet };
    let shown = chart.clip(&sheet);
    let area: f64 = shown.windows(2).map(|pair| (pair[0] - a).perp_dot(pair[1] - a)).sum();
    if shown.len() < 3 || area.abs() < SMALLEST_PIECE * whole.abs() {
        return None;
    }
    // Parameters of the face are affine in those of the sheet.
    let parameters = |point: DVec2| {
        let (s, t) = ((point - a).perp_dot(c - a) / whole, (b - a).perp_dot(point - a) / whole);
        corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0])
    };
    let shown: Vec<DVec2> = shown.into_iter().map(parameters).collect();
    Some(rectangle(&shown).map_or_else(|| ParameterPatch::fan(&shown), |part| vec![part]))
}

/// A polygon as a rectangle of parameters, if it is one.
fn rectangle(corners: &[DVec2]) -> Option<ParameterPatch> {
    let min = corners.iter().fold(DVec2::INFINITY, |min, corner| min.min(*corner));
    let max = corners.iter().fold(DVec2::NEG_INFINITY, |max, corner| max.max(*corner));
    let near = 1e-12 * (1.0 + max.abs().max_element());
    let is_corner = |corner: &DVec2| {
        let [x, y] = [0, 1].map(|axis| (corner[axis] - min[axis]).min(max[axis] - corner[axis]));
        x <= near && y <= near
    };
    (corners.len() == 4 && corners.iter().all(is_corner)).then_some(ParameterPatch::Rectangle { min, max })
}
