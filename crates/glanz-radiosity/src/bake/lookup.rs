//! Lookup of the texel and the element at a point of a surface.

use glanz_math::DVec2;
use glanz_scene::ParametricPoint;

use crate::charts::Chart;
use crate::elements::Elements;

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
    /// Cells of [`SideIndex::cells`] per axis.
    columns: usize,
    /// Elements that overlap each cell of a grid over the unit square.
    cells: Vec<Vec<u32>>,
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

    /// Numbers of the chart and of the texel nearest to a point.
    pub(super) fn texel(&self, charts: &[Chart], place: &ParametricPoint) -> Option<(usize, usize)> {
        let (number, texel) = self.on_chart(|number| charts.get(number), place)?;
        let (texel, width) = (texel.round(), charts.get(number)?.size[0]);
        Some((number, texel.y as usize * width as usize + texel.x as usize))
    }

    /// The element at a point; where trimming has left none, the nearest one of the side of the face.
    pub(super) fn element(&self, elements: &Elements<'_>, place: &ParametricPoint) -> Option<u32> {
        let side = self.side(place)?;
        let part = |number: u32| elements.list.get(number as usize).map(|element| element.patch.domain);
        let cell = side.cells.get(side.cell(place.uv))?;
        let holds = |&&number: &&u32| part(number).is_some_and(|part| part.contains(place.uv));
        if let Some(&number) = cell.iter().find(holds) {
            return Some(number);
        }
        let distance =
            |number: u32| part(number).map_or(f64::INFINITY, |part| part.center().distance_squared(place.uv));
        side.elements.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }
}

impl SideIndex {
    fn cell(&self, uv: DVec2) -> usize {
        let [x, y] =
            uv.to_array().map(|x| ((x * self.columns as f64) as usize).min(self.columns.saturating_sub(1)));
        y * self.columns + x
    }

    fn fill(&mut self, elements: &Elements<'_>) {
        self.columns = ((self.elements.len() as f64).sqrt().ceil() as usize).clamp(1, 256);
        self.cells = vec![Vec::new(); self.columns * self.columns];
        for &number in &self.elements {
            let Some(element) = elements.list.get(number as usize) else { continue };
            let corners = element.patch.domain.corners();
            let low = corners.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
            let high = corners.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
            let (from, to) = (self.cell(low), self.cell(high));
            for y in from / self.columns..=to / self.columns {
                for x in from % self.columns..=to % self.columns {
                    self.cells[y * self.columns + x].push(number);
                }
            }
        }
    }
}
