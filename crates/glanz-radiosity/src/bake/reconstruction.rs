//! From the light of elements to that of texels.

use std::collections::{BTreeMap, HashMap};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{ParametricPoint, PlacedSurface};

use super::lookup::Index;
use super::solution::Solution;
use crate::charts::Chart;
use crate::elements::Elements;
use crate::reconstruct::partition::of_many_samples;
use crate::reconstruct::{Interpolation, Lattice, Sample};

/// Step across the side of an element that finds out whether it is a border, per its size.
const ACROSS: f64 = 1e-3;

/// Distance below which samples are one, per the longest side of the domain.
const SAME: f64 = 1e-9;

/// Lines of a grid at most, and places along each side of a cell at which elements are looked up.
const LINES: f64 = 256.0;
const PER_CELL: u32 = 3;

/// Interpolates the light of elements on charts.
pub(super) struct Reconstruction<'a> {
    elements: &'a Elements<'a>,
    /// Of the elements.
    solution: &'a Solution,
    index: &'a Index,
    interpolation: Interpolation,
    /// Numbers of the elements of each side of a face.
    sides: HashMap<(u32, u32, bool), Vec<u32>>,
}

/// Where the sheet of a chart lies in the domain of an interpolation, the rectangle from the origin to `size`, whose longer side is 1.
#[derive(Clone, Copy)]
struct Domain {
    /// Per unit of the sheet.
    scale: DVec2,
    size: DVec2,
}

impl Domain {
    fn new(chart: &Chart) -> Self {
        // Texels are about square.
        let texels = chart.texels_per_unit();
        let scale = texels / (texels * chart.sheet.size()).max_element();
        Self { scale, size: scale * chart.sheet.size() }
    }

    fn point(&self, sheet: DVec2) -> DVec2 {
        (sheet * self.scale).clamp(DVec2::ZERO, self.size)
    }
}

impl<'a> Reconstruction<'a> {
    /// `index`: of the charts and of `elements`, whose light `solution` holds.
    pub(super) fn new(
        elements: &'a Elements<'a>,
        solution: &'a Solution,
        index: &'a Index,
        interpolation: Interpolation,
    ) -> Self {
        let mut sides: HashMap<(u32, u32, bool), Vec<u32>> = HashMap::new();
        for (number, element) in (0..).zip(&elements.list) {
            let patch = &element.patch;
            sides.entry((patch.surface, patch.face, patch.back)).or_default().push(number);
        }
        Self { elements, solution, index, interpolation, sides }
    }

    /// Irradiance of all texels of a chart, 0 or more.
    pub(super) fn texels(&self, chart: &Chart) -> Vec<Spectrum> {
        let Some(surface) = self.elements.surfaces.get(chart.surface as usize) else {
            return vec![Spectrum::BLACK; chart.texels()];
        };
        let samples = self.samples(chart, surface);
        if samples.iter().all(|sample| sample.value == DVec3::ZERO) {
            return vec![Spectrum::BLACK; chart.texels()];
        }
        let domain = Domain::new(chart);
        let interpolant = match self.interpolation {
            Interpolation::Constant => None,
            Interpolation::Bilinear | Interpolation::Spline => {
                self.lattice(chart, &domain).and_then(|lattice| self.interpolation.of_lattice(&lattice).ok())
            }
            _ => of_many_samples(self.interpolation, &samples, domain.size).ok(),
        };
        let width = chart.size[0] as usize;
        let texel = |texel: usize| {
            let sheet = chart.to_sheet(DVec2::new((texel % width) as f64, (texel / width) as f64));
            let value = match &interpolant {
                Some(interpolant) => interpolant.value(domain.point(sheet)),
                None => self.constant(chart, sheet).unwrap_or(DVec3::ZERO),
            };
            spectrum(value.max(DVec3::ZERO))
        };
        (0..chart.texels()).map(texel).collect()
    }

    /// The elements of a chart that light can reach and no wall hides, with their light.
    fn elements(&self, chart: &Chart) -> impl Iterator<Item = (u32, DVec3)> {
        let of_face = |face| self.sides.get(&(chart.surface, face, chart.back));
        chart.faces().into_iter().filter_map(of_face).flatten().filter_map(move |&number| {
            let patch = &self.elements.list.get(number as usize)?.patch;
            let sheet = chart.on_sheet(patch.face, patch.part.center())?;
            let value = self.value(number).filter(|_| !chart.is_behind_a_wall(sheet))?;
            Some((number, value))
        })
    }

    fn value(&self, number: u32) -> Option<DVec3> {
        let light = self.solution.get(number as usize)?.1?;
        Some(DVec3::from_array(light.to_rgb(&Wavelengths::default()).map(f64::from)))
    }

    /// A sample in the middle of each element, and more at borders of what the chart shows, so that nothing lies beyond all of them: at sides of
    /// elements and in corners, with the light of their element (@pietrek2001 section 4.6).
    fn samples(&self, chart: &Chart, surface: &PlacedSurface<'_>) -> Vec<Sample> {
        let domain = Domain::new(chart);
        // Faces may meet in a corner.
        let mut found: BTreeMap<[i64; 2], (DVec2, DVec3, f64)> = BTreeMap::new();
        let mut add = |sheet: DVec2, value: DVec3| {
            let point = domain.point(sheet);
            let key = (point / SAME).round().to_array().map(|x| x as i64);
            let sum = found.entry(key).or_insert((point, DVec3::ZERO, 0.0));
            *sum = (sum.0, sum.1 + value, sum.2 + 1.0);
        };
        let is_beyond = |sheet: DVec2| {
            chart.is_behind_a_wall(sheet)
                || chart.parameters(sheet).is_none_or(|(face, uv)| {
                    surface.is_trimmed() && surface.at(face, uv, chart.back).is_none()
                })
        };
        for (number, value) in self.elements(chart) {
            let Some(element) = self.elements.list.get(number as usize) else { continue };
            let patch = &element.patch;
            let on_sheet = |uv: DVec2| chart.on_sheet(patch.face, uv);
            let Some(middle) = on_sheet(patch.part.center()) else { continue };
            add(middle, value);
            let corners: Vec<DVec2> = patch.part.corners().into_iter().filter_map(on_sheet).collect();
            let count = corners.len();
            let is_border: Vec<bool> = (0..count)
                .map(|i| {
                    let side = corners[i].midpoint(corners[(i + 1) % count]);
                    is_beyond(side + ACROSS * (side - middle))
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
        let place = ParametricPoint { surface: chart.surface, face, back: chart.back, uv };
        self.value(self.index.element(self.elements, &place)?)
    }

    /// A grid over the sheet, with cells as large as an element in the middle of all by size; cells without light take that of the nearest
    /// cell that has some.
    fn lattice(&self, chart: &Chart, domain: &Domain) -> Option<Lattice> {
        let mut areas: Vec<f64> = Vec::new();
        for (number, _) in self.elements(chart) {
            let patch = &self.elements.list.get(number as usize)?.patch;
            let corners = patch.part.corners();
            let corners: Vec<DVec2> = corners
                .iter()
                .filter_map(|&uv| Some(domain.point(chart.on_sheet(patch.face, uv)?)))
                .collect();
            let [a, b, rest @ ..] = corners.as_slice() else { continue };
            let twice: f64 =
                [*b].iter().chain(rest).zip(rest).map(|(p, q)| (*p - *a).perp_dot(*q - *a)).sum();
            areas.push(0.5 * twice.abs());
        }
        areas.sort_by(f64::total_cmp);
        let side = areas.get(areas.len() / 2)?.sqrt();
        let [columns, rows] = (domain.size / side).to_array().map(|n| n.round().clamp(1.0, LINES) as u32);
        let cell = DVec2::new(f64::from(columns), f64::from(rows)).recip() * domain.size;
        let mut values: Vec<Option<DVec3>> = Vec::new();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let low = DVec2::new(f64::from(column), f64::from(row)) * cell;
            let inside = (0..PER_CELL * PER_CELL).map(|i| {
                let share = DVec2::new(f64::from(i % PER_CELL) + 0.5, f64::from(i / PER_CELL) + 0.5);
                (low + cell * share / f64::from(PER_CELL)) / domain.scale
            });
            let found: Vec<DVec3> = inside
                .filter(|sheet| !chart.is_behind_a_wall(*sheet))
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
