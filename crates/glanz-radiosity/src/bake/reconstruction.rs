//! Interpolation of the light of elements on texels.

use std::collections::{BTreeMap, HashMap};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{ParametricPoint, PlacedSurface};
use rayon::prelude::*;

use super::direct;
use super::lookup::SurfaceIndex;
use super::solution::Solution;
use crate::charts::Chart;
use crate::elements::Elements;
use crate::reconstruct::partition::of_many_samples;
use crate::reconstruct::{Interpolation, Lattice, ReconstructError, Sample};

/// Step across the side of an element that tests whether it is a border, relative to the element's size.
const BORDER_STEP: f64 = 1e-3;

/// Distance below which samples are merged, relative to the longest side of the domain.
const MERGE_DISTANCE: f64 = 1e-9;

/// Largest number of lines of a grid along each axis.
const MAX_LINES: f64 = 256.0;

/// Lookups of elements along each side of a cell of a grid, whose mean is its value.
const LOOKUPS_PER_CELL: u32 = 3;

/// Interpolator of the light of elements on charts.
pub(super) struct Reconstruction<'a> {
    elements: &'a Elements<'a>,
    /// Light of the elements.
    solution: &'a Solution,
    index: &'a SurfaceIndex,
    interpolation: Interpolation,
    /// Numbers of the elements of each side of a face.
    sides: HashMap<(u32, u32, bool), Vec<u32>>,
}

/// Map from the sheet of a chart to the domain of an interpolation, the rectangle from the origin to `size`, whose longer side is 1.
#[derive(Clone, Copy)]
struct SheetDomain {
    /// Domain units per unit of the sheet.
    scale: DVec2,
    size: DVec2,
}

impl SheetDomain {
    fn new(chart: &Chart) -> Self {
        // Texels are nearly square.
        let texels = chart.texels_per_unit();
        let scale = texels / (texels * chart.sheet.size()).max_element();
        Self { scale, size: scale * chart.sheet.size() }
    }

    fn point(&self, sheet: DVec2) -> DVec2 {
        (sheet * self.scale).clamp(DVec2::ZERO, self.size)
    }
}

impl<'a> Reconstruction<'a> {
    /// `index`: that of the charts and `elements`; `solution`: the light of `elements`.
    pub(super) fn new(
        elements: &'a Elements<'a>,
        solution: &'a Solution,
        index: &'a SurfaceIndex,
        interpolation: Interpolation,
    ) -> Self {
        let mut sides: HashMap<(u32, u32, bool), Vec<u32>> = HashMap::new();
        for (number, element) in (0..).zip(&elements.list) {
            let patch = &element.patch;
            sides.entry((patch.surface, patch.face, patch.back)).or_default().push(number);
        }
        Self { elements, solution, index, interpolation, sides }
    }

    /// Indirect irradiance of all texels of a chart, 0 or more.
    ///
    /// # Errors
    /// Those of the interpolation.
    pub(super) fn texels(&self, chart: &Chart) -> Result<Vec<Spectrum>, ReconstructError> {
        let surface = self.elements.surfaces.get(chart.surface as usize);
        let samples = surface.map_or_else(Vec::new, |surface| self.samples(chart, surface));
        if samples.iter().all(|sample| sample.value == DVec3::ZERO) {
            return Ok(vec![Spectrum::BLACK; chart.texels()]);
        }
        let domain = SheetDomain::new(chart);
        let interpolant = match self.interpolation {
            Interpolation::Constant => None,
            Interpolation::Bilinear | Interpolation::Spline => self
                .lattice(chart, &domain)
                .map(|lattice| self.interpolation.of_lattice(&lattice))
                .transpose()?,
            _ => Some(of_many_samples(self.interpolation, &samples, domain.size)?),
        };
        let width = chart.size[0] as usize;
        let texel = |texel: usize| {
            let sheet = chart.to_sheet(DVec2::new((texel % width) as f64, (texel / width) as f64));
            let value = match &interpolant {
                Some(interpolant) => interpolant.value(domain.point(sheet)),
                // The middle of a texel may lie beneath a wall.
                None if chart.is_behind_wall(sheet) => {
                    let places = direct::texel_points(self.elements, chart, texel);
                    places.first().and_then(|place| self.constant_at(place)).unwrap_or(DVec3::ZERO)
                }
                None => self.constant(chart, sheet).unwrap_or(DVec3::ZERO),
            };
            spectrum(value.max(DVec3::ZERO))
        };
        Ok((0..chart.texels()).into_par_iter().map(texel).collect())
    }

    /// The elements shown by a chart that are outside of solids, with their light.
    fn elements(&self, chart: &Chart) -> impl Iterator<Item = (u32, DVec3)> {
        let of_face = |face| self.sides.get(&(chart.surface, face, chart.back));
        chart.faces().into_iter().filter_map(of_face).flatten().filter_map(move |&number| {
            let patch = &self.elements.list.get(number as usize)?.patch;
            let sheet = chart.sheet_point(patch.face, patch.domain.center())?;
            let value = self.value(number).filter(|_| !chart.is_behind_wall(sheet))?;
            Some((number, value))
        })
    }

    fn value(&self, number: u32) -> Option<DVec3> {
        let light = self.solution.get(number as usize)?.1?;
        Some(DVec3::from_array(light.to_rgb(&Wavelengths::default()).map(f64::from)))
    }

    /// Samples in the middle of each element, and at sides and corners of elements on the border of what the chart shows, so that no
    /// texel needs extrapolation (@pietrek2001 section 4.6).
    fn samples(&self, chart: &Chart, surface: &PlacedSurface<'_>) -> Vec<Sample> {
        let domain = SheetDomain::new(chart);
        // Faces may share a corner, whose samples are averaged.
        let mut found: BTreeMap<[i64; 2], (DVec2, DVec3, f64)> = BTreeMap::new();
        let mut add = |sheet: DVec2, value: DVec3| {
            let point = domain.point(sheet);
            let key = (point / MERGE_DISTANCE).round().to_array().map(|x| x as i64);
            let sum = found.entry(key).or_insert((point, DVec3::ZERO, 0.0));
            *sum = (sum.0, sum.1 + value, sum.2 + 1.0);
        };
        let is_beyond = |sheet: DVec2| {
            chart.is_behind_wall(sheet)
                || chart.parameters(sheet).is_none_or(|(face, uv)| {
                    surface.is_trimmed() && surface.at(face, uv, chart.back).is_none()
                })
        };
        for (number, value) in self.elements(chart) {
            let Some(element) = self.elements.list.get(number as usize) else { continue };
            let patch = &element.patch;
            let on_sheet = |uv: DVec2| chart.sheet_point(patch.face, uv);
            let Some(middle) = on_sheet(patch.domain.center()) else { continue };
            add(middle, value);
            let corners: Vec<DVec2> = patch.domain.corners().into_iter().filter_map(on_sheet).collect();
            let count = corners.len();
            let is_border: Vec<bool> = (0..count)
                .map(|i| {
                    let side = corners[i].midpoint(corners[(i + 1) % count]);
                    is_beyond(side + BORDER_STEP * (side - middle))
                })
                .collect();
            for i in 0..count {
                let next = (i + 1) % count;
                if is_border[i] {
                    add(corners[i].midpoint(corners[next]), value);
                }
                if is_border[i] && is_border[next] {
                    add(corners[next], value);
                }
            }
        }
        found.into_values().map(|(point, sum, count)| Sample { point, value: sum / count }).collect()
    }

    /// The light of the element at a point of the sheet.
    fn constant(&self, chart: &Chart, sheet: DVec2) -> Option<DVec3> {
        let (face, uv) = chart.parameters(sheet)?;
        self.constant_at(&ParametricPoint { surface: chart.surface, face, back: chart.back, uv })
    }

    /// The light of the element at a point.
    fn constant_at(&self, place: &ParametricPoint) -> Option<DVec3> {
        self.value(self.index.element(self.elements, place)?)
    }

    /// A grid over the sheet, with cells of the median size of the elements; cells without light take that of neighbouring cells.
    fn lattice(&self, chart: &Chart, domain: &SheetDomain) -> Option<Lattice> {
        let mut areas: Vec<f64> = Vec::new();
        for (number, _) in self.elements(chart) {
            let patch = &self.elements.list.get(number as usize)?.patch;
            let corners = patch.domain.corners();
            let corners: Vec<DVec2> = corners
                .iter()
                .filter_map(|&uv| Some(domain.point(chart.sheet_point(patch.face, uv)?)))
                .collect();
            let [a, b, rest @ ..] = corners.as_slice() else { continue };
            let twice: f64 =
                [*b].iter().chain(rest).zip(rest).map(|(p, q)| (*p - *a).perp_dot(*q - *a)).sum();
            areas.push(0.5 * twice.abs());
        }
        areas.sort_by(f64::total_cmp);
        let side = areas.get(areas.len() / 2)?.sqrt();
        let [columns, rows] = (domain.size / side).to_array().map(|n| n.round().clamp(1.0, MAX_LINES) as u32);
        let cell = DVec2::new(f64::from(columns), f64::from(rows)).recip() * domain.size;
        let mut values: Vec<Option<DVec3>> = Vec::new();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let low = DVec2::new(f64::from(column), f64::from(row)) * cell;
            let inside = (0..LOOKUPS_PER_CELL * LOOKUPS_PER_CELL).map(|i| {
                let share =
                    DVec2::new(f64::from(i % LOOKUPS_PER_CELL) + 0.5, f64::from(i / LOOKUPS_PER_CELL) + 0.5);
                (low + cell * share / f64::from(LOOKUPS_PER_CELL)) / domain.scale
            });
            let found: Vec<DVec3> = inside
                .filter(|sheet| !chart.is_behind_wall(*sheet))
                .filter_map(|sheet| self.constant(chart, sheet))
                .collect();
            values.push((!found.is_empty()).then(|| found.iter().sum::<DVec3>() / found.len() as f64));
        }
        let filled = super::fill::filled(
            values.into_iter().map(|value| value.map(spectrum)).collect(),
            [columns as usize, rows as usize],
        );
        let lines = |count: u32, size: f64| {
            let line = |i: u32| (f64::from(i) + 0.5) / f64::from(count) * size;
            (0..count).map(line).collect::<Vec<f64>>()
        };
        let values = filled
            .into_iter()
            .map(|light| DVec3::from_array(light.to_rgb(&Wavelengths::default()).map(f64::from)));
        Lattice::new(lines(columns, domain.size.x), lines(rows, domain.size.y), values.collect())
    }
}

fn spectrum(rgb: DVec3) -> Spectrum {
    Spectrum::from_rgb(rgb.as_vec3().to_array())
}
