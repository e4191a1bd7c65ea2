//! Lookup of the texel and the element at a point of a surface.

use glanz_math::DVec2;
use glanz_scene::ParametricPoint;

use crate::charts::Chart;
use crate::elements::Elements;
use crate::rectangle_grid::RectangleGrid;

/// Largest number of cells along each parameter.
const MAX_COLUMNS: usize = 256;

/// Index of charts and elements by side of a face.
#[derive(Debug)]
pub(super) struct SurfaceIndex {
    /// Index in `sides` of the first side of each surface.
    first: Vec<usize>,
    sides: Vec<SideIndex>,
}

/// Charts and elements of one side of a face.
#[derive(Clone, Debug, Default)]
struct SideIndex {
    charts: Vec<u32>,
    elements: Vec<u32>,
    /// Bounds of the elements in the unit square, by their index in `elements`.
    grid: RectangleGrid,
}

impl SurfaceIndex {
    pub(super) fn new(elements: &Elements<'_>, charts: &[Chart]) -> Self {
        let mut first = Vec::with_capacity(elements.surfaces.len());
        let mut count = 0;
        for surface in &elements.surfaces {
            first.push(count);
            count += 2 * surface.faces() as usize;
        }
        let mut index = Self { first, sides: vec![SideIndex::default(); count] };
        for (number, chart) in (0_u32..).zip(charts) {
            for face in chart.faces() {
                if let Some(side) = index.side_mut(chart.surface, face, chart.back) {
                    side.charts.push(number);
                }
            }
        }
        for (number, element) in (0_u32..).zip(&elements.list) {
            let patch = &element.patch;
            if let Some(side) = index.side_mut(patch.surface, patch.face, patch.back) {
                side.elements.push(number);
            }
        }
        for side in &mut index.sides {
            side.fill(elements);
        }
        index
    }

    fn number(&self, surface: u32, face: u32, back: bool) -> Option<usize> {
        Some(self.first.get(surface as usize)? + 2 * face as usize + usize::from(back))
    }

    fn side_mut(&mut self, surface: u32, face: u32, back: bool) -> Option<&mut SideIndex> {
        let number = self.number(surface, face, back)?;
        self.sides.get_mut(number)
    }

    fn side(&self, place: &ParametricPoint) -> Option<&SideIndex> {
        self.sides.get(self.number(place.surface, place.face, place.back)?)
    }

    /// Number of the chart of a point, and its position on it, texels. `chart`: the chart of a number.
    pub(super) fn on_chart<'a>(
        &self,
        chart: impl Fn(usize) -> Option<&'a Chart>,
        place: &ParametricPoint,
    ) -> Option<(usize, DVec2)> {
        self.side(place)?.charts.iter().find_map(|&number| {
            let texel = chart(number as usize)?.to_texel(place.face, place.uv)?;
            Some((number as usize, texel))
        })
    }

    /// Numbers of the chart and of the texel nearest to a point; `None` also beneath a thin wall, where no texel has light of its own.
    pub(super) fn texel(&self, charts: &[Chart], place: &ParametricPoint) -> Option<(usize, usize)> {
        let (number, texel) = self.on_chart(|number| charts.get(number), place)?;
        let chart = charts.get(number)?;
        if !chart.walls.is_empty() && chart.is_behind_wall(chart.to_sheet(texel)) {
            return None;
        }
        // Coordinates are not negative; to round them is a library call without SSE4.1.
        let (texel, width) = (texel + 0.5, chart.size[0]);
        Some((number, texel.y as usize * width as usize + texel.x as usize))
    }

    /// The element at a point; where trimming has left none, the nearest one of the side of the face.
    pub(super) fn element(&self, elements: &Elements<'_>, place: &ParametricPoint) -> Option<u32> {
        let side = self.side(place)?;
        let part = |number: u32| elements.list.get(number as usize).map(|element| element.patch.domain);
        let mut near =
            side.grid.near(place.uv).iter().filter_map(|&i| side.elements.get(i as usize).copied());
        if let Some(number) = near.find(|&number| part(number).is_some_and(|part| part.contains(place.uv))) {
            return Some(number);
        }
        let distance =
            |number: u32| part(number).map_or(f64::INFINITY, |part| part.center().distance_squared(place.uv));
        side.elements.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }
}

impl SideIndex {
    fn fill(&mut self, elements: &Elements<'_>) {
        let bounds = |&number: &u32| {
            // Numbers are those of the list.
            let domain = elements.list[number as usize].patch.domain;
            let corners = domain.corners();
            let low = corners.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
            let high = corners.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
            [low, high]
        };
        let bounds: Vec<[DVec2; 2]> = self.elements.iter().map(bounds).collect();
        let columns = ((bounds.len() as f64).sqrt().ceil() as usize).clamp(1, MAX_COLUMNS);
        self.grid = RectangleGrid::with_linear_memory(DVec2::ONE, columns, &bounds);
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;

    use super::*;
    use crate::elements::{ElementSettings, ParameterPatch, Patch};
    use crate::rectangle_grid::slender_triangles;
    use crate::scenes::{parallelogram, scene};

    #[test]
    fn slender_elements_fill_few_cells() {
        let scene = scene(vec![(parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 0.5, 0.0)]);
        let mut elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
        let patch = elements.list[0].patch;
        let fan = slender_triangles(3000);
        let patches = fan.iter().map(|&corners| Patch { domain: ParameterPatch::Triangle(corners), ..patch });
        elements.list = patches.filter_map(|patch| elements.element(patch)).collect();
        let index = SurfaceIndex::new(&elements, &[]);
        let side = index.sides.iter().find(|side| !side.elements.is_empty()).unwrap();
        let (covered, cells) =
            (side.grid.lists().map(<[u32]>::len).sum::<usize>(), side.grid.lists().count());
        assert!(covered <= 16 * fan.len() + cells, "{covered} {cells}");
        for (i, [_, b, c]) in (0..).zip(fan).step_by(7) {
            let uv = 0.4 * b + 0.4 * c;
            let place = ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv };
            assert_eq!(index.element(&elements, &place), Some(i));
        }
    }
}
