//! Form factors: fractions of the light leaving one element that arrive at another.
//!
//! Polygons that are entirely visible to each other have a closed form; other pairs are integrated over pairs of points with shadow
//! rays, on patches so small that their distance is large for their size.

use std::f64::consts::PI;

use glanz_job::{CancelFlag, Interrupted};
use glanz_math::rounding::offset_origin;
use glanz_math::{DVec3, Ray};
use glanz_scene::Scene;
use rayon::prelude::*;

use crate::elements::{Element, ElementPoint, Elements, Patch};

pub mod polygon;

/// Sum of the radii of two patches over their distance below which their quadrature points represent them.
const FAR: f64 = 0.3;

/// Fraction of the smaller area below which patches that touch are not divided further.
const SMALLEST_FRACTION: f64 = 1.0 / 256.0;

/// Divisions of a pair of polygons that are partly visible to each other.
const PENUMBRA_LEVELS: u32 = 3;

/// The same for pairs of other shapes.
const CURVED_PENUMBRA_LEVELS: u32 = 5;

/// Area times form factor of a pair of elements, m^2, equal in both directions.
#[must_use]
pub fn exchange(elements: &Elements<'_>, a: &Element, b: &Element) -> f64 {
    exchange_counting_rays(elements, a, b, &mut 0)
}

/// As [`exchange`]; adds the number of its shadow rays to `rays`.
pub fn exchange_counting_rays(elements: &Elements<'_>, a: &Element, b: &Element, rays: &mut u64) -> f64 {
    match (&a.polygon, &b.polygon) {
        (Some(p), Some(q)) => match (FlatPolygon::in_front_of(a, p, b), FlatPolygon::in_front_of(b, q, a)) {
            (Some(p), Some(q)) => polygon_exchange(elements.scene, &p, &q, PENUMBRA_LEVELS, rays),
            _ => 0.0,
        },
        _ => {
            let smallest = SMALLEST_FRACTION * a.area.min(b.area);
            let [a, b] = [a, b].map(|element| SampledPatch::new(elements, element.patch));
            patch_exchange(elements, &a, &b, smallest, PatchVisibility::Unknown(CURVED_PENUMBRA_LEVELS), rays)
        }
    }
}

/// Form factors of all pairs of elements that are visible to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct FormFactors {
    /// Form factors of each element to others, by ascending number of these.
    rows: Vec<Vec<(u32, f32)>>,
    rays: u64,
}

/// Exchange of an element with those after it in the list, m^2, and the number of rays.
type ExchangeRow = (Vec<(u32, f64)>, u64);

impl FormFactors {
    /// Computes all form factors, in parallel; memory grows with the square of the number of elements.
    ///
    /// # Errors
    /// [`Interrupted`] if `cancel` is raised; it is checked after each row.
    pub fn new(elements: &Elements<'_>, cancel: &CancelFlag) -> Result<Self, Interrupted> {
        let list = &elements.list;
        let upper: Result<Vec<ExchangeRow>, Interrupted> = list
            .par_iter()
            .enumerate()
            .map(|(i, a)| {
                let others = (0_u32..).zip(list).skip(i + 1);
                let mut rays = 0;
                let row = others.filter_map(|(j, b)| {
                    let exchanged = exchange_counting_rays(elements, a, b, &mut rays);
                    (exchanged > 0.0).then_some((j, exchanged))
                });
                let row = row.collect();
                cancel.check().map(|()| (row, rays))
            })
            .collect();
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); list.len()];
        let mut rays = 0;
        for (i, (row, of_row)) in upper?.into_iter().enumerate() {
            rays += of_row;
            for (j, exchanged) in row {
                rows[i].push((j, (exchanged / list[i].area) as f32));
                rows[j as usize].push((i as u32, (exchanged / list[j as usize].area) as f32));
            }
        }
        rows.iter_mut().for_each(|row| row.sort_unstable_by_key(|&(j, _)| j));
        Ok(Self { rows, rays })
    }

    /// Numbers of the elements visible from an element, with the form factor to each.
    #[must_use]
    pub fn row(&self, element: usize) -> &[(u32, f32)] {
        self.rows.get(element).map_or(&[], Vec::as_slice)
    }

    /// Sum of the form factors of an element: 1 in a closed room, up to errors.
    #[must_use]
    pub fn sum(&self, element: usize) -> f64 {
        self.row(element).iter().map(|&(_, factor)| f64::from(factor)).sum()
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no elements.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of shadow rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Memory of the form factors, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.rows.iter().map(|row| size_of_val(row.as_slice())).sum()
    }
}

/// A flat polygon in space.
struct FlatPolygon {
    corners: Vec<DVec3>,
    normal: DVec3,
    error: DVec3,
}

impl FlatPolygon {
    /// The part of an element in front of another's plane; `None` if nothing is.
    fn in_front_of(element: &Element, corners: &[DVec3], other: &Element) -> Option<Self> {
        let corners = polygon::in_front(corners, other.center.position, other.center.normal);
        let ElementPoint { normal, error, .. } = element.center;
        (corners.len() >= 3).then_some(Self { corners, normal, error })
    }

    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    fn area(&self) -> f64 {
        let first = self.corners.first().copied().unwrap_or_default();
        let twice: DVec3 = self.corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum();
        0.5 * twice.length()
    }

    /// Ends of shadow rays: points inside, one towards each corner.
    fn points(&self) -> Vec<ElementPoint> {
        let middle = self.middle();
        let point = |&corner: &DVec3| ElementPoint {
            position: middle.lerp(corner, 0.55),
            normal: self.normal,
            error: self.error,
            area: 0.0,
        };
        self.corners.iter().map(point).collect()
    }

    /// Quadrilaterals, one per corner, between the corner, the middles of its sides and the middle.
    fn parts(&self) -> Vec<Self> {
        let (middle, n) = (self.middle(), self.corners.len());
        let part = |i: usize| {
            let [before, here, after] = [i + n - 1, i, i + 1].map(|i| self.corners[i % n]);
            let corners = vec![here, 0.5 * (here + after), middle, 0.5 * (before + here)];
            Self { corners, normal: self.normal, error: self.error }
        };
        (0..n).map(part).collect()
    }
}

/// Exchange of two polygons in front of one another's planes, m^2.
fn polygon_exchange(scene: &Scene, a: &FlatPolygon, b: &FlatPolygon, levels: u32, rays: &mut u64) -> f64 {
    let (from, to) = (a.points(), b.points());
    let all = from.len() * to.len();
    *rays += all as u64;
    let visible =
        from.iter().map(|a| to.iter().filter(|b| is_unoccluded(scene, a, b)).count()).sum::<usize>();
    if visible == 0 {
        return 0.0;
    }
    if visible == all || levels == 0 {
        return polygon::exchange(&a.corners, &b.corners) * visible as f64 / all as f64;
    }
    if a.area() >= b.area() {
        a.parts().iter().map(|part| polygon_exchange(scene, part, b, levels - 1, rays)).sum()
    } else {
        b.parts().iter().map(|part| polygon_exchange(scene, a, part, levels - 1, rays)).sum()
    }
}

/// A patch of a surface with its quadrature points.
struct SampledPatch {
    patch: Patch,
    points: Vec<ElementPoint>,
    middle: DVec3,
    radius: f64,
    area: f64,
}

impl SampledPatch {
    fn new(elements: &Elements<'_>, patch: Patch) -> Self {
        let points = elements.quadrature_points(&patch);
        let count = points.len().max(1) as f64;
        let middle = points.iter().map(|point| point.position).sum::<DVec3>() / count;
        let reach = points.iter().map(|point| point.position.distance(middle)).fold(0.0, f64::max);
        // Corners are at most twice as far from the middle as the quadrature points.
        Self { patch, middle, radius: 2.0 * reach, area: points.iter().map(|point| point.area).sum(), points }
    }

    fn parts(&self, elements: &Elements<'_>) -> Vec<Self> {
        let quarters = self.patch.domain.quarters();
        quarters.into_iter().map(|part| Self::new(elements, Patch { domain: part, ..self.patch })).collect()
    }
}

/// Mutual visibility of two patches, as far as known.
#[derive(Clone, Copy, Debug)]
enum PatchVisibility {
    /// Unknown: shadow rays are traced in this number of further divisions.
    Unknown(u32),
    /// The fraction of unoccluded rays between them, [0, 1].
    Fraction(f64),
}

/// Exchange of two patches of any shape, m^2.
///
/// Patches without points that face one another exchange nothing: the exchange of the rims of curved ones, which is neglected, vanishes
/// with their size. Patches whose points are all visible to each other are divided without further rays.
fn patch_exchange(
    elements: &Elements<'_>,
    a: &SampledPatch,
    b: &SampledPatch,
    smallest: f64,
    visibility: PatchVisibility,
    rays: &mut u64,
) -> f64 {
    let (mut whole, mut seen, mut facing, mut visible) = (0.0, 0.0, 0_usize, 0_usize);
    for (a, b) in a.points.iter().flat_map(|a| b.points.iter().map(move |b| (a, b))) {
        let exchanged = kernel(a, b) * a.area * b.area;
        if exchanged > 0.0 {
            facing += 1;
            whole += exchanged;
            if matches!(visibility, PatchVisibility::Unknown(_)) && is_unoccluded(elements.scene, a, b) {
                visible += 1;
                seen += exchanged;
            }
        }
    }
    if facing == 0 {
        return 0.0;
    }
    let all = a.points.len() * b.points.len();
    let (found, below) = match visibility {
        PatchVisibility::Fraction(fraction) => (fraction * whole, visibility),
        PatchVisibility::Unknown(levels) => {
            *rays += facing as u64;
            // If few pairs face one another, they do not represent the others.
            let below = match (2 * facing >= all, levels.checked_sub(1)) {
                (true, _) if visible == facing => PatchVisibility::Fraction(1.0),
                (_, Some(levels)) => PatchVisibility::Unknown(levels),
                (_, None) => PatchVisibility::Fraction(visible as f64 / facing as f64),
            };
            if visible == 0 && facing == all {
                return 0.0;
            }
            (seen, below)
        }
    };
    let is_far = a.radius + b.radius <= FAR * a.middle.distance(b.middle);
    if is_far || a.area.min(b.area) <= smallest {
        // The kernel is unbounded for points that nearly touch: no more than all light is exchanged.
        return found.min(a.area.min(b.area));
    }
    if a.radius >= b.radius {
        a.parts(elements).iter().map(|part| patch_exchange(elements, part, b, smallest, below, rays)).sum()
    } else {
        b.parts(elements).iter().map(|part| patch_exchange(elements, a, part, smallest, below, rays)).sum()
    }
}

/// The kernel cos cos' / (pi r^2) between two points, per m^2; 0 if one faces away.
pub(crate) fn kernel(a: &ElementPoint, b: &ElementPoint) -> f64 {
    let way = b.position - a.position;
    let square = way.length_squared();
    let (leaves, meets) = (a.normal.dot(way), -b.normal.dot(way));
    if leaves > 0.0 && meets > 0.0 { leaves * meets / (PI * square * square) } else { 0.0 }
}

/// Whether no surface is between two points.
pub(crate) fn is_unoccluded(scene: &Scene, a: &ElementPoint, b: &ElementPoint) -> bool {
    let way = b.position - a.position;
    let from = offset_origin(a.position, a.error, a.normal, way);
    let to = offset_origin(b.position, b.error, b.normal, -way);
    !scene.occluded(&Ray::new(from, to - from), 1.0)
}

#[cfg(test)]
mod tests;
