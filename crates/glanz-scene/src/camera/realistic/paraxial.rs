//! The focus of a system of lenses, from its matrix for rays near the axis.
//!
//! A ray from the scene has a height y and, times the refractive index, a slope u. A surface of curvature radius R between the indices n and n'
//! makes u' = u - y (n' - n) / R, a way d in a medium n makes y' = y + u d / n. The whole lens is a matrix [[a, b], [c, d]] of (y, u), with
//! a d - b c = 1 in air. Its focal length is f = -1 / c; the principal plane on the side of the film is (1 - a) / c behind the last vertex, that on
//! the side of the scene (d - 1) / c behind the first one (@born1999 section 4.4).

use super::LensRangeError;
use super::interface::LensInterface;

/// A lens by its cardinal points.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThickLens {
    /// Focal length, metres.
    pub(super) focal_length: f64,
    /// Distance of the principal plane on the side of the film behind the last vertex, metres.
    pub(super) rear_plane: f64,
    /// Distance of that plane behind the one on the side of the scene, metres.
    separation: f64,
}

impl ThickLens {
    /// The lens of `interfaces`, from the scene to the film.
    pub(super) fn try_new(interfaces: &[LensInterface]) -> Result<Self, LensRangeError> {
        let [mut a, mut b, mut c, mut d] = [1.0, 0.0, 0.0, 1.0];
        let mut previous: Option<&LensInterface> = None;
        for interface in interfaces {
            if let Some(previous) = previous {
                let way = (previous.z - interface.z) / previous.eta_film;
                (a, b) = (a + way * c, b + way * d);
            }
            if let Some(radius) = interface.curvature_radius {
                let power = (interface.eta_film - interface.eta_scene) / radius;
                (c, d) = (c - power * a, d - power * b);
            }
            previous = Some(interface);
        }
        let focal_length = -1.0 / c;
        if !(focal_length > 0.0 && focal_length.is_finite()) {
            return Err(("focal length of the lens", focal_length, "positive"));
        }
        let length = interfaces.first().map_or(0.0, |first| first.z) - previous.map_or(0.0, |last| last.z);
        let rear_plane = (1.0 - a) / c;
        Ok(Self { focal_length, rear_plane, separation: length + rear_plane - (d - 1.0) / c })
    }

    /// Distance from the film to the last vertex, metres, that focuses the plane at `focus_distance` from the film.
    ///
    /// The distances s and s' of that plane and the film from the principal planes have the sum T and 1/s + 1/s' = 1/f, thus s s' = f T.
    pub(super) fn film_distance(&self, focus_distance: f64) -> Result<f64, LensRangeError> {
        let sum = focus_distance - self.separation;
        let root = sum * (sum - 4.0 * self.focal_length);
        if !(focus_distance.is_finite() && sum > 0.0 && root >= 0.0) {
            return Err(("focus distance of the lens", focus_distance, "at least four of its focal lengths"));
        }
        // The smaller of both solutions, without cancellation.
        let image = 2.0 * self.focal_length * sum / (sum + root.sqrt());
        let distance = self.rear_plane + image;
        if distance > 0.0 {
            Ok(distance)
        } else {
            Err(("distance of the lens from the film", distance, "positive"))
        }
    }
}
