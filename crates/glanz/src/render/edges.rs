//! Lines along edges, over the picture.

use glanz_job::{ProgressSink, Silent};
use glanz_scene::Scene;
use glanz_scene::studio::SrgbColor;
use glanz_transport::{EdgeLayer, EdgeStyle, FilmFormat, MAX_EDGES};

use crate::error::Error;
use crate::event::Warning;
use crate::job_options::JobOptions;
use crate::running_job::RunningJob;

/// Colour of the lines.
const INK: SrgbColor = SrgbColor([26; 3]);

/// Shorter side of a picture, pixels, whose lines have the width [`USUAL_WIDTH`] by default; in larger pictures they are wider.
const USUAL_SIDE: f64 = 720.0;

/// Width of lines by default, pixels.
const USUAL_WIDTH: f64 = 1.5;

/// Largest width of lines, pixels: wider ones would only cost time.
pub const MAX_LINE_WIDTH: f64 = 64.0;

/// Appearance of the lines over a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeLines {
    /// Width, pixels, above 0 and at most [`MAX_LINE_WIDTH`], to which it is limited; `None` (or a number that is no width): 1.5 pixels in a picture
    /// whose shorter side has 720, and in proportion, but at least 1.
    pub width: Option<f64>,
}

impl EdgeLines {
    /// The style for a picture of this width and height, pixels.
    pub(super) fn style(self, resolution: [u32; 2]) -> EdgeStyle {
        let side = f64::from(resolution[0].min(resolution[1]));
        let width = self.width.filter(|width| *width > 0.0);
        let width = width.unwrap_or_else(|| (side / USUAL_SIDE * USUAL_WIDTH).max(1.0)).min(MAX_LINE_WIDTH);
        EdgeStyle { width, color: INK.to_linear() }
    }
}

/// Draws the edges of the scene; `None`, with a warning, if there are none or too many, or the camera cannot project them.
pub(super) fn layer(
    scene: &Scene,
    format: &FilmFormat,
    style: EdgeStyle,
    job: &mut RunningJob<'_>,
) -> Result<Option<EdgeLayer>, Error> {
    let edges = scene.edge_count();
    if edges == 0 {
        job.warn(Warning::NoEdges);
        return Ok(None);
    }
    if !scene.camera().can_project() {
        job.warn(Warning::EdgesOfCamera);
        return Ok(None);
    }
    if edges > MAX_EDGES {
        job.warn(Warning::TooManyEdges { edges });
        return Ok(None);
    }
    job.in_pool(|job| {
        let JobOptions { sink, cancel, .. } = &mut job.options;
        let mut silent = Silent;
        let sink: &mut dyn ProgressSink = match sink {
            Some(sink) => &mut **sink,
            None => &mut silent,
        };
        Ok(Some(EdgeLayer::draw(scene, format, style, sink, cancel)?))
    })
}
