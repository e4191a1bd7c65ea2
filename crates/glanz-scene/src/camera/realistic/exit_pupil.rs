//! Where light from a lens arrives at the film.

use std::sync::Arc;

use glanz_math::{DVec2, Ray};

use super::interface::{LensInterface, trace};
use super::stop::LensStop;

/// Number of rings of the film with bounds of their own.
const RINGS: usize = 64;

/// Points of the film per ring for which rays are traced, its borders included.
const STEPS: usize = 2;

/// Number of cells of the grid of rays across the last lens.
const CELLS: i32 = 96;

/// Half the width of that grid, relative to the opening of the last lens: rays at an angle to the axis meet the plane of its vertex outside.
const REACH: f64 = 1.5;

/// Halvings of the interval in which the pupil ends, for the middle of the film.
const HALVINGS: u32 = 50;

/// A rectangle on the plane of the last vertex.
#[derive(Clone, Copy, Debug)]
struct PupilBounds {
    min: DVec2,
    max: DVec2,
}

/// Bounds of the exit pupil on the plane of the last vertex, by distance from the middle of the film.
#[derive(Clone, Debug)]
pub(super) struct ExitPupil {
    /// Distance of the plane from the film, metres.
    pub(super) plane: f64,
    /// For points of the film on +x.
    rings: Arc<[PupilBounds]>,
    /// For points beyond the corners of the film.
    whole: PupilBounds,
    /// Width of a ring, metres.
    width: f64,
    /// Area of the square around the pupil as seen from the middle of the film, square metres.
    pub(super) middle_area: f64,
}

impl ExitPupil {
    /// `radius`: distance of the corners of the film from its middle, metres.
    pub(super) fn new(interfaces: &[LensInterface], radius: f64) -> Self {
        let (plane, reach) =
            interfaces.last().map_or((1.0, 0.0), |last| (last.z, REACH * last.aperture_radius));
        let width = radius / RINGS as f64;
        let steps: Vec<Option<PupilBounds>> = (0..=RINGS * STEPS)
            .map(|step| bounds(interfaces, step as f64 * width / STEPS as f64, plane, reach))
            .collect();
        let cell = 2.0 * reach / f64::from(CELLS);
        let whole = PupilBounds { min: DVec2::splat(-reach), max: DVec2::splat(reach) };
        let ring = |ring: usize| {
            let inside = steps.iter().skip(ring * STEPS).take(STEPS + 1).flatten();
            let all =
                inside.copied().reduce(|a, b| PupilBounds { min: a.min.min(b.min), max: a.max.max(b.max) });
            // The pupil ends within a cell of the last ray that passes. A ring without such rays might have a pupil smaller than a cell.
            all.map_or(whole, |b| PupilBounds {
                min: (b.min - cell).max(whole.min),
                max: (b.max + cell).min(whole.max),
            })
        };
        let diameter = 2.0 * middle_radius(interfaces, plane, reach);
        Self { plane, rings: (0..RINGS).map(ring).collect(), whole, width, middle_area: diameter * diameter }
    }

    /// A point within the bounds for a point of the film, uniform for `xi` uniform in [0, 1), and their area, square metres.
    pub(super) fn sample(&self, film: DVec2, xi: DVec2) -> (DVec2, f64) {
        let radius = film.length();
        let ring = self.rings.get((radius / self.width) as usize);
        let PupilBounds { min, max } = ring.copied().unwrap_or(self.whole);
        let turn = if radius > 0.0 { film / radius } else { DVec2::X };
        (turn.rotate(min + xi * (max - min)), (max - min).element_product())
    }
}

/// Whether the ray from (`x`, 0) of the film to this point of the plane passes the lens with circular stops.
fn passes(interfaces: &[LensInterface], x: f64, target: DVec2, plane: f64) -> bool {
    let start = DVec2::new(x, 0.0).extend(0.0);
    let direction = (target.extend(plane) - start).normalize();
    trace(interfaces, &LensStop::DISK, Ray::new(start, direction)).is_some()
}

/// Radius of the exit pupil on the plane, metres, as seen from the middle of the film: a disk.
fn middle_radius(interfaces: &[LensInterface], plane: f64, reach: f64) -> f64 {
    let halved = |[inside, outside]: [f64; 2], _| {
        let middle = 0.5 * (inside + outside);
        let does_pass = passes(interfaces, 0.0, DVec2::new(middle, 0.0), plane);
        if does_pass { [middle, outside] } else { [inside, middle] }
    };
    (0..HALVINGS).fold([0.0, reach], halved)[1]
}

/// The box around the points of a grid whose rays from (`x`, 0) of the film pass the lens with circular stops; `None` if no ray passes.
fn bounds(interfaces: &[LensInterface], x: f64, plane: f64, reach: f64) -> Option<PupilBounds> {
    let cell = 2.0 * reach / f64::from(CELLS);
    let does_pass = |column: i32, row: i32| {
        passes(interfaces, x, cell * DVec2::new(f64::from(column), f64::from(row)), plane)
    };
    // The lens is symmetric, so that half of the rows tell.
    let half = CELLS / 2;
    let cells = (0..=half).flat_map(|row| (-half..=half).map(move |column| (column, row)));
    cells.filter(|&(column, row)| does_pass(column, row)).fold(
        None,
        |bounds: Option<PupilBounds>, (column, row)| {
            let [x, y] = [f64::from(column) * cell, f64::from(row) * cell];
            let [low, high] = [DVec2::new(x, -y), DVec2::new(x, y)];
            Some(bounds.map_or(PupilBounds { min: low, max: high }, |b| PupilBounds {
                min: b.min.min(low),
                max: b.max.max(high),
            }))
        },
    )
}
