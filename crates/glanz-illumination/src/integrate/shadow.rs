//! Direct light that something hides from a part of a cell.
//!
//! At the border of a shadow the illuminance of points has no smooth derivatives, and to integrate the visible part of an emitter for one point takes many rays
//! that touch what hides it. The mean over the cell does not need that accuracy: it is an integral over the cell and the emitter at once, here by scrambled Sobol' points in
//! four dimensions, with the spread of copies as the error. The order of its error is N^(-5/8) at such borders (@he2015).

use glanz_light::units::photometric;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::hash::combine;
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};

use super::mean::{CellPatch, DividedCell};
use super::{Reflections, direct};

/// Independent copies of the sequence.
const COPIES: usize = 16;
/// Standard errors that bound the error: for fifteen degrees of freedom, 99 % of Student's distribution.
const BOUND: f64 = 3.0;
/// Upper limit of the mean number of points at which none is found, with 95 %.
const UNSEEN: f64 = 3.0;
/// Points of a copy, in all squares of the cell, by which shadows are found.
const FIRST_POINTS: usize = 16;
/// Largest number of rays for one light and cell.
const MOST_RAYS: usize = 1 << 20;

/// The light of one source on a cell by equal numbers of points of each copy in each square.
#[derive(Clone, Debug)]
pub(super) struct ShadowSum {
    source: usize,
    /// Points of a copy in a square.
    points: u32,
    /// Number of squares of the cell.
    squares: usize,
    /// Sums over the points on the surface: their illuminance, and that as if nothing hid the light, lm, and their area, m^2, each times the number of points.
    sums: [[f64; 3]; COPIES],
    is_open: bool,
    is_hidden: bool,
}

impl ShadowSum {
    /// The first points.
    pub(super) fn of_source<P: CellPatch>(
        reflections: &Reflections<'_>,
        cell: &DividedCell<'_, P>,
        source: usize,
    ) -> Self {
        let mut sum = Self {
            source,
            points: 0,
            squares: cell.squares.len(),
            sums: [[0.0; 3]; COPIES],
            is_open: false,
            is_hidden: false,
        };
        let first = FIRST_POINTS.div_ceil(cell.squares.len().max(1)).next_power_of_two();
        sum.extend(reflections, cell, first as u32);
        sum
    }

    pub(super) fn source(&self) -> usize {
        self.source
    }

    /// Whether some points see the light, and others would if nothing hid it.
    pub(super) fn is_border(&self) -> bool {
        self.is_open && self.is_hidden
    }

    /// Mean over the part of the cell that is on the surface, and the bound on its error, lx.
    ///
    /// The same points have the flux and the area, whose errors at the rim of the surface cancel.
    pub(super) fn mean(&self) -> [f64; 2] {
        let [flux, whole, area] = [0, 1, 2].map(|k| self.sums.iter().map(|sums| sums[k]).sum::<f64>());
        if area <= 0.0 {
            return [0.0; 2];
        }
        let mean = flux / area;
        let squares = self.sums.iter().map(|[flux, _, area]| (flux - mean * area).powi(2)).sum::<f64>();
        let count = COPIES as f64;
        let spread = BOUND * (squares * count / (count - 1.0)).sqrt();
        // A border that no point has found yet is smaller than three points with a probability of 95 %.
        let all = count * f64::from(self.points) * self.squares as f64;
        let unseen = if self.is_border() { 0.0 } else { UNSEEN / all * whole };
        [mean, (spread + unseen) / area]
    }

    /// Doubles the points until the bound is below `allowed`, lx, or there are too many.
    pub(super) fn converge<P: CellPatch>(
        &mut self,
        reflections: &Reflections<'_>,
        cell: &DividedCell<'_, P>,
        allowed: f64,
    ) {
        let per_point = COPIES * cell.squares.len();
        while self.mean()[1] > allowed && 2 * self.points as usize * per_point <= MOST_RAYS {
            self.extend(reflections, cell, 2 * self.points);
        }
    }

    fn extend<P: CellPatch>(
        &mut self,
        reflections: &Reflections<'_>,
        cell: &DividedCell<'_, P>,
        points: u32,
    ) {
        for (number, square) in (0..).zip(cell.squares) {
            let size = square.size();
            for (copy, [flux, whole, area]) in (0..).zip(&mut self.sums) {
                let sequence = ScrambledSobol::new(combine(combine(self.source as u64, number), copy));
                for index in self.points..points {
                    let [u, v, s, t] = sequence.point(index.reverse_bits()).map(unit);
                    let at = square.min + size * DVec2::new(u, v);
                    let Some((point, normal, area_element)) = (cell.patch)(at) else { continue };
                    let element = area_element * size.element_product();
                    *area += element;
                    let Some((lux, is_seen)) =
                        reflections.sampled(self.source, point, normal, DVec2::new(s, t))
                    else {
                        continue;
                    };
                    *whole += lux * element;
                    if is_seen {
                        *flux += lux * element;
                    }
                    self.is_open |= is_seen;
                    self.is_hidden |= !is_seen;
                }
            }
        }
        self.points = points;
    }
}

impl Reflections<'_> {
    /// Number of lights: emitters, then lights without extent.
    pub(super) fn source_count(&self) -> usize {
        self.emitters.len() + self.points.len()
    }

    /// Illuminance of a point by the ray to a random place of a light, lx, as if nothing hid it, and whether nothing does; `None` if it comes from below the
    /// horizon.
    fn sampled(&self, source: usize, point: DVec3, normal: DVec3, at: DVec2) -> Option<(f64, bool)> {
        let (receiver, origin) = self.receiving(point, normal);
        if let Some(emitter) = self.emitters.get(source) {
            let (projected, is_seen) = direct::sampled(self.scene, receiver, origin, emitter, at)?;
            return Some((projected * photometric(emitter.radiance, &self.wavelengths), is_seen));
        }
        let (_, light) = self.points.get(source - self.emitters.len())?;
        direct::from_point(self.scene, receiver, origin, light, &self.wavelengths)
    }
}
