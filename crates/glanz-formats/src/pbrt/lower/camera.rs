//! `Camera`.

use glanz_math::DMat4;
use glanz_scene::description::{CameraDescription, CameraKind};

use super::Lowering;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// Lowers a camera; `to_camera` is the current transformation at the directive.
    pub(crate) fn camera(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        to_camera: DMat4,
    ) -> ParseResult<()> {
        let to_world = to_camera.inverse();
        if !to_world.is_finite() {
            let message = "the transformation before the camera cannot be inverted";
            return Err(self.reporter.error(&list.place, "transformation", message));
        }
        let place = list.place;
        let r = &mut self.reporter;
        if !matches!(kind, "perspective" | "orthographic") {
            let known = matches!(kind, "environment" | "spherical" | "realistic");
            let what = if known { "is not available yet" } else { "is unknown" };
            let message = format!("camera {:?} {what}; a perspective camera stands in", shortened(kind));
            r.stand_in(&place, "stand-in-camera", message);
            list.ignore(&[
                "mapping",
                "lensfile",
                "aperturediameter",
                "focusdistance",
                "simpleweighting",
                "aperture",
            ]);
        }
        let fov = list.float("fov", r)?;
        let half = list.float("halffov", r)?;
        let degrees = fov.or(half.map(|h| 2.0 * h)).unwrap_or(90.0);
        if !(degrees > 0.0 && degrees < 180.0) {
            let message =
                format!("camera: the field of view is {degrees} degrees; it must be between 0 and 180");
            return Err(r.error(&place, "parameter-range", message));
        }
        let kind = match kind {
            "orthographic" => CameraKind::Orthographic,
            _ => CameraKind::Perspective { field_of_view: degrees.to_radians() },
        };
        let camera = CameraDescription {
            kind,
            to_world,
            screen_window: list.float_array("screenwindow", r)?,
            aspect: list.float("frameaspectratio", r)?,
            lens_radius: list.float_or("lensradius", 0.0, r)?,
            focal_distance: list.float_or("focaldistance", 1e6, r)?,
            location: Some(place.location),
        };
        list.ignore(&["shutteropen", "shutterclose", "focallength", "hither", "yon"]);
        list.finish(r);
        self.description.camera = camera;
        Ok(())
    }
}
