//! Elements, textures, and their errors against the reference.

use std::time::Duration;

use glanz_radiosity::reconstruct::{Border, InterpolatedTexture, Interpolation, ParameterCells};

use super::exact::{ExactFloor, ReferenceTexture};
use super::method::{FloorDivision, InterpolationMethod, methods};
use super::published::NormErrors;
use super::quadtree::QuadtreeSettings;
use super::room::{DividedFloor, FloorScene, Setup, halved};
use crate::clock::{self, Stopwatch, TimeScope};
use crate::study::{Settings, StudyError};

/// The grid of document 003, 16 x 16.
const GRID: QuadtreeSettings = QuadtreeSettings { threshold: 0.0, first: 4, deepest: 4 };

/// Chosen so that there are about as many elements as in document 003, which does not print its threshold.
pub(super) const QUADTREE: QuadtreeSettings = QuadtreeSettings { threshold: 0.08, first: 2, deepest: 8 };

/// Largest difference of light within the distance of an element away from borders of shadows, relative to the largest light.
const QUIET: f64 = 0.35;

/// Results of one method.
pub(super) struct MethodResult {
    pub(super) method: InterpolationMethod,
    pub(super) errors: NormErrors,
    /// Root mean square error further than an element of the grid from the borders of hard shadows.
    pub(super) away: Option<f64>,
    /// Largest excess of the texture above and below all values of elements.
    pub(super) overshoot: [f64; 2],
    /// Time from elements to texture.
    pub(super) time: Duration,
    pub(super) texels: Vec<f64>,
}

/// Results of one division of a floor.
pub(super) struct DivisionResult {
    pub(super) division: FloorDivision,
    pub(super) divided: DividedFloor,
    /// Time to compute the values of the elements.
    pub(super) time: Duration,
    /// Root mean square and largest difference between values of elements by form factors and exact ones.
    pub(super) off: [f64; 2],
    pub(super) made: Vec<MethodResult>,
}

/// Results of a scene.
pub(super) struct SceneResult {
    pub(super) setup: &'static Setup,
    pub(super) reference: ReferenceTexture,
    pub(super) reference_time: Duration,
    /// Grid, then quadtree.
    pub(super) divisions: Vec<DivisionResult>,
}

impl DivisionResult {
    pub(super) fn of(&self, interpolation: Interpolation, border: Border) -> Option<&MethodResult> {
        self.made.iter().find(|m| m.method.interpolation == interpolation && m.method.border == border)
    }
}

/// Measures a scene; `on_progress` receives the next step.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(super) fn measure(
    setup: &'static Setup,
    size: [usize; 2],
    settings: &Settings,
    on_progress: &mut dyn FnMut(String),
) -> Result<SceneResult, StudyError> {
    on_progress(format!("scene {}: reference", setup.number));
    let scene = setup.scene()?;
    let room = FloorScene::new(&scene, halved(size))?;
    let exact = room.exact();
    let watch = Stopwatch::start(TimeScope::Thread);
    let reference = exact.reference(size, &settings.cancel)?;
    let reference_time = watch.elapsed();
    let quiet = setup.hard.then(|| away_from_borders(&reference.texels, size));
    let mut divisions = Vec::new();
    // Elements smaller than texels would have no effect.
    let deepest = QUADTREE.deepest.min(size[0].min(size[1]).ilog2());
    let quadtree = QuadtreeSettings { deepest, ..QUADTREE };
    for (division, rules) in [(FloorDivision::Grid, GRID), (FloorDivision::Quadtree, quadtree)] {
        on_progress(format!("scene {}: {}", setup.number, division.name()));
        let watch = Stopwatch::start(TimeScope::Thread);
        let divided = room.divided(&rules, reference.unit, &settings.cancel)?;
        let time = watch.elapsed();
        let off = off(&exact, &divided.cells, reference.unit);
        let mut made = Vec::new();
        for method in methods(division) {
            settings.cancel.check()?;
            made.push(make(method, &divided.cells, size, &reference, quiet.as_deref())?);
        }
        divisions.push(DivisionResult { division, divided, time, off, made });
    }
    Ok(SceneResult { setup, reference, reference_time, divisions })
}

/// One texture with its time and errors.
fn make(
    method: InterpolationMethod,
    cells: &ParameterCells,
    size: [usize; 2],
    reference: &ReferenceTexture,
    quiet: Option<&[bool]>,
) -> Result<MethodResult, StudyError> {
    // The small textures of tests need not be timed as long.
    let share = (size[0] * size[1]) as f64 / 160_000.0;
    let (texture, time) = clock::repeated_for(
        clock::SHORTEST.mul_f64(share.min(1.0)),
        || (),
        |()| texture(method, cells, size),
    )?;
    let texels: Vec<f64> = texture.texels().iter().map(|texel| texel.x).collect();
    let values = || cells.as_slice().iter().map(|cell| cell.value.x);
    let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max)];
    let above = texels.iter().fold(0.0, |most: f64, x| most.max(x - high));
    let below = texels.iter().fold(0.0, |most: f64, x| most.max(low - x));
    let away = quiet.map(|quiet| {
        let chosen = texels.iter().zip(&reference.texels).zip(quiet).filter(|(_, quiet)| **quiet);
        let (sum, count) =
            chosen.fold((0.0, 0_u32), |(sum, count), ((a, b), _)| (sum + (a - b).powi(2), count + 1));
        (sum / f64::from(count.max(1))).sqrt()
    });
    Ok(MethodResult {
        method,
        errors: errors(&texels, &reference.texels),
        away,
        overshoot: [above, below],
        time,
        texels,
    })
}

/// The texture of a method.
///
/// # Errors
/// Cells that the method refuses.
pub(super) fn texture(
    method: InterpolationMethod,
    cells: &ParameterCells,
    size: [usize; 2],
) -> Result<InterpolatedTexture, StudyError> {
    Ok(method.interpolation.of_cells(cells, method.border)?.texture(size))
}

/// Mean, root mean square and largest difference.
pub(super) fn errors(a: &[f64], b: &[f64]) -> NormErrors {
    let n = a.len().max(1) as f64;
    let differences = || a.iter().zip(b).map(|(a, b)| (a - b).abs());
    let square: f64 = differences().map(|d| d * d).sum();
    [differences().sum::<f64>() / n, (square / n).sqrt(), differences().fold(0.0, f64::max)]
}

/// Root mean square (by area) and largest difference between values of cells and exact means over them.
fn off(exact: &ExactFloor, cells: &ParameterCells, unit: f64) -> [f64; 2] {
    let (mut squares, mut most) = (0.0, 0.0_f64);
    for cell in cells.as_slice() {
        let size = cell.max - cell.min;
        let off = cell.value.x - exact.mean_over(cell.min, size, unit) / unit;
        squares += off * off * size.element_product();
        most = most.max(off.abs());
    }
    [squares.sqrt(), most]
}

/// Texels around which light differs by less than at the border of a hard shadow, within the distance of an element of the grid.
fn away_from_borders(texels: &[f64], size: [usize; 2]) -> Vec<bool> {
    let reach = size.map(|n| n / 16);
    let along = |values: &[f64], axis: usize, pick: fn(f64, f64) -> f64| -> Vec<f64> {
        let stride = if axis == 0 { 1 } else { size[0] };
        let of = |i: usize| {
            let place = (i / stride) % size[axis];
            let low = place - reach[axis].min(place);
            let high = (place + reach[axis]).min(size[axis] - 1);
            let first = i - (place - low) * stride;
            (0..=high - low).filter_map(|k| values.get(first + k * stride).copied()).fold(values[i], pick)
        };
        (0..values.len()).map(of).collect()
    };
    let [low, high] =
        [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| along(&along(texels, 0, pick), 1, pick));
    low.iter().zip(&high).map(|(low, high)| high - low < QUIET).collect()
}
