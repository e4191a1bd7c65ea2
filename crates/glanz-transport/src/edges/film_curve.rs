//! Curves in space on the film.

use glanz_math::{DVec2, DVec3};
use glanz_scene::Camera;

/// Longest step between points of a curve on the film, pixels.
const STEP: f64 = 1.0;

/// Length of steps up to which points of a curve are left out on the film, pixels, since every point costs rays.
const SHORT_STEP: f64 = 0.25;

/// Angle in which the picture of a line counts as straight where the camera bends lines, radians: over it, an arc of a radius of 1000 pixels strays
/// from its chord by a third of a pixel.
const SMALL_ANGLE: f64 = 0.05;

/// Halvings of a segment, at most: from a step in front of the camera to the horizon.
const MAX_HALVINGS: u32 = 48;

/// A point of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmPoint {
    /// Position on the film, pixels.
    pub(super) film: DVec2,
    /// The point in world space, metres.
    pub(super) point: DVec3,
    /// Origin of the ray of the camera through the point, metres.
    pub(super) eye: DVec3,
    /// Width of a pixel at the point, metres.
    pub(super) pixel: f64,
}

/// The centre of the lens.
pub(super) const CENTER: DVec2 = DVec2::new(0.5, 0.5);

/// Projects curves to the film.
pub(super) struct FilmCurves<'a> {
    camera: &'a Camera,
    /// The part of the film within which lines show: smallest and largest x and y.
    window: [DVec2; 2],
}

impl<'a> FilmCurves<'a> {
    /// `width`: of lines, pixels.
    pub(super) fn new(camera: &'a Camera, resolution: [u32; 2], width: f64) -> Self {
        let size = DVec2::from(resolution.map(f64::from));
        // A line covers pixels whose centres are as far as half of its width and half a pixel.
        let margin = DVec2::splat(0.5 * width + 1.0);
        Self { camera, window: [-margin, size + margin] }
    }

    /// The parts of a polyline within the picture, in steps of at most a pixel; how many depends on their lengths on the film, not on the number of
    /// points. They do not depend on the crop window.
    pub(super) fn project(&self, points: &[DVec3]) -> Vec<Vec<FilmPoint>> {
        let mut curves = vec![Vec::new()];
        let mut ends = points.iter().map(|&point| (point, self.at(point)));
        let Some(mut start) = ends.next() else { return Vec::new() };
        for end in ends {
            self.segment([start, end], MAX_HALVINGS, &mut curves);
            start = end;
        }
        curves.retain(|curve| curve.len() > 1);
        curves
    }

    pub(super) fn at(&self, point: DVec3) -> Option<FilmPoint> {
        let seen = self.camera.project(point, CENTER)?;
        Some(FilmPoint { film: seen.film, point, eye: seen.origin, pixel: seen.density.sqrt().recip() })
    }

    fn segment(
        &self,
        [start, end]: [(DVec3, Option<FilmPoint>); 2],
        halvings: u32,
        curves: &mut Vec<Vec<FilmPoint>>,
    ) {
        let interrupt = |curves: &mut Vec<Vec<FilmPoint>>| {
            if curves.last().is_some_and(|curve| !curve.is_empty()) {
                curves.push(Vec::new());
            }
        };
        match (start.1, end.1) {
            // Both are behind the camera, and so is what is between them.
            (None, None) if self.is_straight([start.0, end.0]) => return interrupt(curves),
            (Some(a), Some(b)) if self.is_outside([a.film, b.film]) && self.is_straight([start.0, end.0]) => {
                return interrupt(curves);
            }
            (Some(a), Some(b)) if a.film.distance(b.film) <= STEP => {
                let Some(curve) = curves.last_mut() else { return };
                if curve.is_empty() {
                    curve.push(a);
                }
                add_point(curve, b);
                return;
            }
            _ if halvings == 0 => return interrupt(curves),
            _ => {}
        }
        let middle = 0.5 * (start.0 + end.0);
        let middle = (middle, self.at(middle));
        self.segment([start, middle], halvings - 1, curves);
        self.segment([middle, end], halvings - 1, curves);
    }

    /// Whether the picture of the line between two points can be taken as straight, for the ends of curves.
    fn is_straight(&self, ends: [DVec3; 2]) -> bool {
        let [a, b] = ends.map(|end| end - self.camera.position());
        self.camera.keeps_lines() || a.dot(b) > 0.0 && a.cross(b).length() < SMALL_ANGLE * a.dot(b)
    }

    /// Whether a straight line on the film is outside of the window, as far as its ends tell.
    fn is_outside(&self, [a, b]: [DVec2; 2]) -> bool {
        let [low, high] = self.window;
        a.max(b).cmplt(low).any() || a.min(b).cmpgt(high).any()
    }
}

/// Adds a point to a curve, in the place of the last one if that is a short step behind the one before.
fn add_point(curve: &mut Vec<FilmPoint>, point: FilmPoint) {
    if let [.., before, last] = curve.as_slice()
        && before.film.distance(last.film) <= SHORT_STEP
        && before.film.distance(point.film) <= STEP
    {
        curve.pop();
    }
    curve.push(point);
}
