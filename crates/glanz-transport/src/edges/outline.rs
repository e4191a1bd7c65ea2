//! Outlines of the faces of a section.

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink};
use glanz_math::DVec2;
use glanz_scene::Scene;
use rayon::prelude::*;

use super::film_curve::CENTER;
use crate::pixel_rect::PixelRect;

/// Halvings of the side of a pixel on which an outline lies.
const HALVINGS: u32 = 4;

/// Number of rows of pixels per thread between two reports of progress.
const PORTION: usize = 16;

/// The border of the part of the film in which the camera sees the faces of the section, as short lines, pixels.
///
/// Rays through the corners of all pixels tell on which sides of pixels the border lies; more rays find it there, and lines connect these points
/// within each pixel. The lines do not depend on the crop window, as far as they reach into it.
///
/// # Errors
/// [`Interrupted`] if cancelled.
///
/// # Source
/// @lorensen1987, in the plane.
pub(super) fn section_outline(
    scene: &Scene,
    crop: PixelRect,
    width: f64,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
) -> Result<Vec<[DVec2; 2]>, Interrupted> {
    let Some(section) = scene.section_id() else { return Ok(Vec::new()) };
    let shows = |film: DVec2| {
        let hit =
            scene.camera().ray(film, CENTER).and_then(|camera| scene.intersect(&camera.ray, f64::INFINITY));
        hit.is_some_and(|hit| hit.id == section)
    };
    let margin = (0.5 * width).ceil() as i64 + 1;
    let [x, y] = [0, 1].map(|axis| {
        let first = i64::from(crop.min[axis]) - margin;
        first..first + i64::from(crop.size[axis]) + 2 * margin
    });
    let corner = |x: i64, y: i64| DVec2::new(x as f64, y as f64);
    let row = |y: i64| -> Vec<bool> { (x.start..=x.end).map(|x| shows(corner(x, y))).collect() };
    let (start, heights): (Instant, Vec<i64>) = (Instant::now(), (y.start..=y.end).collect());
    let mut rows: Vec<Vec<bool>> = Vec::with_capacity(heights.len());
    for portion in heights.chunks(PORTION * rayon::current_num_threads()) {
        cancel.check()?;
        rows.par_extend(portion.par_iter().map(|&y| row(y)));
        let fraction = rows.len() as f64 / heights.len() as f64;
        sink.on_progress(&JobProgress::by_work("outline of the section", fraction, start.elapsed()));
    }
    let lines_of_row = |(y, rows): (i64, &[Vec<bool>])| -> Result<Vec<[DVec2; 2]>, Interrupted> {
        cancel.check()?;
        let [above, below] = rows else { return Ok(Vec::new()) };
        let mut lines = Vec::new();
        for ((x, above), below) in x.clone().zip(above.windows(2)).zip(below.windows(2)) {
            let corners = [(corner(x, y), above[0]), (corner(x + 1, y), above[1])];
            let corners =
                [corners[0], corners[1], (corner(x + 1, y + 1), below[1]), (corner(x, y + 1), below[0])];
            let sides = (0..4).map(|side| [corners[side], corners[(side + 1) % 4]]);
            let crossed = sides.filter(|[start, end]| start.1 != end.1);
            let points: Vec<DVec2> = crossed.map(|ends| border(ends, &shows)).collect();
            // Two points, or four where two corners face each other.
            lines.extend(points.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
        }
        Ok(lines)
    };
    let pairs: Vec<(i64, &[Vec<bool>])> = y.zip(rows.windows(2)).collect();
    let lines: Result<Vec<_>, Interrupted> = pairs.into_par_iter().map(lines_of_row).collect();
    Ok(lines?.concat())
}

/// Where the faces begin on the side of a pixel, of whose ends one shows them.
fn border([start, end]: [(DVec2, bool); 2], shows: &impl Fn(DVec2) -> bool) -> DVec2 {
    // From the end with the smaller coordinates, so that both pixels beside it find the same point.
    let (mut low, mut high) =
        if start.0.x + start.0.y < end.0.x + end.0.y { (start, end) } else { (end, start) };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low.0 + high.0);
        let shown = shows(middle);
        if shown == low.1 {
            low.0 = middle;
        } else {
            high.0 = middle;
        }
    }
    0.5 * (low.0 + high.0)
}
