//! Lines of constant parameter between which a surface is nearly straight.

use glanz_math::{DVec2, DVec3};

use super::TessellationSettings;
use super::patch::MeshPatch;
use super::shared_edge::distance_to_segment;

/// Lines of constant parameter that are compared, parts of the window.
const LINES: [f64; 5] = [0.02, 0.26, 0.5, 0.74, 0.98];

/// Parameters of an axis between which lines of the surface along it are straight within the settings.
pub(super) fn straight_breaks(patch: &MeshPatch, axis: usize, settings: TessellationSettings) -> Vec<f64> {
    /// A step is never shorter than this power of one half of the window.
    const MAX_DEPTH: u32 = 12;
    let [low, high] = patch.window().map(|corner| corner[axis]);
    let mut breaks = vec![low];
    let mut waiting = vec![(low, high, 0)];
    while let Some((from, to, depth)) = waiting.pop() {
        if depth == MAX_DEPTH || is_straight(patch, axis, [from, to], settings) {
            breaks.push(to);
        } else {
            let middle = 0.5 * (from + to);
            waiting.extend([(middle, to, depth + 1), (from, middle, depth + 1)]);
        }
    }
    breaks
}

fn is_straight(patch: &MeshPatch, axis: usize, [from, to]: [f64; 2], settings: TessellationSettings) -> bool {
    /// Points compared on a smooth line, and at most.
    const POINTS: [usize; 2] = [6, 64];
    let [low, high] = patch.window();
    let inner = patch.breaks[axis].iter().filter(|&&at| from < at && at < to).count();
    let parts = (2 * (inner + 1)).clamp(POINTS[0], POINTS[1]);
    LINES.iter().all(|&line| {
        let at = |i: usize| {
            let mut uv = low + (high - low) * line;
            uv[axis] = from + (to - from) * i as f64 / parts as f64;
            uv
        };
        let (first, last) = (patch.point(at(0)), patch.point(at(parts)));
        let strays = (1..parts).map(|i| distance_to_segment(patch.point(at(i)), first, last));
        if strays.fold(0.0, f64::max) > settings.deviation {
            return false;
        }
        let normals = [at(0), at(parts)].map(|uv| patch.normal(uv));
        let known = normals.iter().all(|normal| *normal != DVec3::ZERO);
        first.distance(last) <= settings.deviation
            || !known
            || normals[0].angle_between(normals[1]) <= settings.angle
    })
}

/// Factors on the parameters that make steps of the grid equally long; of a surface that is flat, metres.
pub(super) fn grid_scale(patch: &MeshPatch, grid: &[Vec<f64>; 2]) -> DVec2 {
    let [low, high] = patch.window();
    let size = high - low;
    let counts = DVec2::new((grid[0].len() - 1) as f64, (grid[1].len() - 1) as f64);
    if counts.max_element() > 1.0 {
        // Triangles as long as the surface is straight: points inside would only bring more of them.
        return counts / size;
    }
    let lengths = lengths(patch).max(DVec2::splat(f64::MIN_POSITIVE));
    let scale = lengths / lengths.min_element() / size;
    if scale.is_finite() { scale } else { size.recip() }
}

/// The largest lengths of lines of the surface along both axes, metres.
pub(super) fn lengths(patch: &MeshPatch) -> DVec2 {
    let [low, high] = patch.window();
    let size = high - low;
    let length = |axis: usize| {
        let along = |line: &f64| {
            let at = |i: u32| {
                let mut uv = low + size * *line;
                uv[axis] = low[axis] + size[axis] * f64::from(i) / 8.0;
                patch.point(uv)
            };
            (0..8).map(|i| at(i).distance(at(i + 1))).sum::<f64>()
        };
        LINES.iter().map(along).fold(0.0, f64::max)
    };
    DVec2::new(length(0), length(1))
}
