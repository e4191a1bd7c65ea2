//! Lines of constant width along the edges of a scene, drawn over a picture.
//!
//! Edges are projected to the film in steps of at most a pixel (`film_curve`), lines of sight decide which points are seen (`visibility`), and
//! the visible parts cover pixels (`coverage`). Where a section shows its faces, rays find their outlines (`outline`). The layer depends on the
//! scene, the camera and the style alone, not on samples: it is drawn once, and mixed with the mean radiance of the pixels, so that a pixel half
//! of which a line covers shows half of the light.

mod coverage;
mod film_curve;
mod outline;
mod visibility;

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink, WorkCount};
use glanz_math::DVec2;
use glanz_scene::description::EdgeDescription;
use glanz_scene::{PlacedEdges, Scene};
use rayon::prelude::*;

use crate::film::FilmFormat;
use crate::pixel_rect::PixelRect;
use coverage::CoverageMap;
use film_curve::FilmCurves;

/// Largest number of edges of a scene, see [`Scene::edge_count`], that it makes sense to draw.
pub const MAX_EDGES: u64 = 10_000_000;

/// Number of edges per thread between two reports of progress.
const PORTION: usize = 64;

/// Appearance of the lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeStyle {
    /// Width, pixels, positive.
    pub width: f64,
    /// Linear red, green and blue.
    pub color: [f32; 3],
}

/// Lines over the crop window of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeLayer {
    /// The pixels for which they are drawn.
    pub(crate) crop: PixelRect,
    /// Linear red, green and blue of the lines.
    pub(crate) color: [f32; 3],
    /// Covered share of each pixel in 255ths, row by row.
    pub(crate) coverage: Vec<u8>,
}

impl EdgeLayer {
    /// Draws the visible [feature edges](glanz_scene::description::EdgeTransition::is_feature) of the scene, and the outlines of the faces of its section.
    ///
    /// With a lens, edges are drawn as its centre sees them, and sharp.
    ///
    /// The time is at least proportional to the number of edges, see [`MAX_EDGES`], and to their points.
    ///
    /// # Errors
    /// [`Interrupted`] if cancelled.
    pub fn draw(
        scene: &Scene,
        format: &FilmFormat,
        style: EdgeStyle,
        sink: &mut dyn ProgressSink,
        cancel: &CancelFlag,
    ) -> Result<Self, Interrupted> {
        let curves = FilmCurves::new(scene.camera(), format.resolution, style.width);
        let placed = scene.placed_edges();
        let edges: Vec<(&PlacedEdges<'_>, &EdgeDescription)> = placed
            .iter()
            .flat_map(|group| group.edges.iter().map(move |edge| (group, edge)))
            .filter(|(_, edge)| edge.transition.is_feature())
            .collect();
        let lines = |&(group, edge): &(&PlacedEdges<'_>, &EdgeDescription)| {
            cancel.check()?;
            let deviation = group.deviation(edge);
            let pieces = group.pieces(edge);
            let seen = pieces.iter().flat_map(|points| curves.project(points));
            Ok(seen
                .flat_map(|curve| visibility::visible_parts(scene, &curve, deviation, style.width))
                .collect())
        };
        let mut map = CoverageMap::new(format.crop, style.width);
        let (start, mut done) = (Instant::now(), 0);
        for portion in edges.chunks(PORTION * rayon::current_num_threads()) {
            let lines: Result<Vec<Vec<Vec<DVec2>>>, Interrupted> = portion.par_iter().map(lines).collect();
            lines?.iter().flatten().for_each(|line| map.add(line));
            done += portion.len();
            let fraction = done as f64 / edges.len() as f64;
            let count =
                WorkCount { done: done as u64, wanted: Some(edges.len() as u64), unit: ["edge", "edges"] };
            sink.on_progress(&JobProgress::by_work("edges", fraction, start.elapsed()).with_count(count));
        }
        let outline = outline::section_outline(scene, format.crop, style.width, sink, cancel)?;
        outline.iter().for_each(|line| map.add(line));
        Ok(Self { crop: format.crop, color: style.color, coverage: map.bytes() })
    }

    /// Draws the layer over the radiance of all pixels, row by row.
    pub fn draw_over(&self, rgb: &mut [[f32; 3]]) {
        for (pixel, rgb) in rgb.iter_mut().enumerate() {
            *rgb = self.over(pixel, rgb.map(f64::from)).map(|x| x as f32);
        }
    }

    /// The radiance of a pixel under the layer. `pixel`: its index, row by row.
    pub(crate) fn over(&self, pixel: usize, radiance: [f64; 3]) -> [f64; 3] {
        let covered = f64::from(self.coverage.get(pixel).copied().unwrap_or_default()) / 255.0;
        [0, 1, 2].map(|band| radiance[band] + covered * (f64::from(self.color[band]) - radiance[band]))
    }
}

#[cfg(test)]
mod tests;
