//! `Camera`.

use glanz_math::DMat4;
use glanz_scene::description::{
    CameraDescription, CameraKind, FisheyeProjection, IrisDescription, SphericalMapping,
};

use super::Lowering;
use crate::pbrt::dialect::Dialect;
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
        let location = Some(place.location);
        let projection = match kind {
            "perspective" => self.perspective(&mut list)?,
            "orthographic" => CameraKind::Orthographic,
            "spherical" => CameraKind::Spherical(self.spherical_mapping(&mut list)?),
            "environment" => CameraKind::Spherical(SphericalMapping::Equirectangular),
            "fisheye" => self.fisheye(&mut list)?,
            "realistic" => CameraKind::Realistic(Box::new(self.realistic_lens(&mut list)?)),
            _ => {
                let message =
                    format!("camera {:?} is unknown; a perspective camera stands in", shortened(kind));
                self.stand_in(&place, "stand-in-camera", message);
                self.perspective(&mut list)?
            }
        };
        let r = &mut self.reporter;
        let mut camera =
            CameraDescription { kind: projection, to_world, location, ..CameraDescription::default() };
        let has_thin_lens = matches!(camera.kind, CameraKind::Perspective { .. } | CameraKind::Orthographic);
        if has_thin_lens || matches!(camera.kind, CameraKind::Fisheye { .. }) {
            camera.screen_window = list.float_array("screenwindow", r)?;
            camera.aspect = list.float("frameaspectratio", r)?;
        }
        if has_thin_lens {
            camera.lens_radius = list.float_or("lensradius", 0.0, r)?;
            camera.focal_distance = list.float_or("focaldistance", 1e6, r)?;
            camera.iris = self.iris(&mut list)?;
        }
        let is_irradiance = matches!(&camera.kind, CameraKind::Realistic(lens) if !lens.relative_weights);
        let is_timed = is_irradiance || self.dialect == Dialect::V4;
        self.shutter(&mut list, is_timed)?;
        list.ignore(&["focallength", "hither", "yon"]);
        list.finish(&mut self.reporter);
        self.description.camera = camera;
        Ok(())
    }

    fn perspective(&mut self, list: &mut ParameterList) -> ParseResult<CameraKind> {
        let r = &mut self.reporter;
        let fov = list.float("fov", r)?;
        let half = list.float("halffov", r)?;
        let degrees = fov.or(half.map(|h| 2.0 * h)).unwrap_or(90.0);
        if !(degrees > 0.0 && degrees < 180.0) {
            let message =
                format!("camera: the field of view is {degrees} degrees; it must be between 0 and 180");
            return Err(r.error(&list.place, "parameter-range", message));
        }
        Ok(CameraKind::Perspective { field_of_view: degrees.to_radians() })
    }

    fn fisheye(&mut self, list: &mut ParameterList) -> ParseResult<CameraKind> {
        let places = ["projection", "fov"].map(|name| list.value_place(name));
        let r = &mut self.reporter;
        let degrees = list.float_or("fov", 180.0, r)?;
        let projection = match list.text("projection", r)?.as_deref() {
            None | Some("equidistant") => FisheyeProjection::Equidistant,
            Some("equisolid") => FisheyeProjection::Equisolid,
            Some("stereographic") => FisheyeProjection::Stereographic,
            Some(other) => {
                let message = format!(
                    "camera: the projection is {:?}; it must be \"equidistant\", \"equisolid\" or \"stereographic\"",
                    shortened(other)
                );
                return Err(r.error(&places[0], "parameter-range", message));
            }
        };
        let is_open = projection == FisheyeProjection::Stereographic;
        if !(degrees > 0.0 && (degrees < 360.0 || degrees == 360.0 && !is_open)) {
            let most = if is_open { "below 360" } else { "at most 360" };
            let message =
                format!("camera: the field of view is {degrees} degrees; it must be above 0 and {most}");
            return Err(r.error(&places[1], "parameter-range", message));
        }
        Ok(CameraKind::Fisheye { field_of_view: degrees.to_radians().min(std::f64::consts::TAU), projection })
    }

    fn spherical_mapping(&mut self, list: &mut ParameterList) -> ParseResult<SphericalMapping> {
        let place = list.value_place("mapping");
        match list.text("mapping", &mut self.reporter)?.as_deref() {
            None | Some("equalarea") => Ok(SphericalMapping::EqualArea),
            Some("equirectangular") => Ok(SphericalMapping::Equirectangular),
            Some(other) => {
                let message = format!(
                    "camera: the mapping is {:?}; it must be \"equalarea\" or \"equirectangular\"",
                    shortened(other)
                );
                Err(self.reporter.error(&place, "parameter-range", message))
            }
        }
    }

    /// `blades`, `bladerotation`: shape of an aperture.
    pub(super) fn iris(&mut self, list: &mut ParameterList) -> ParseResult<IrisDescription> {
        let place = list.value_place("blades");
        let r = &mut self.reporter;
        let blades = list.integer_from("blades", 0, r)?.unwrap_or(0);
        if (1..3).contains(&blades) {
            let message =
                format!("camera: {blades} blades make no polygon; there must be 3 or more, or 0 for a disk");
            return Err(r.error(&place, "parameter-range", message));
        }
        Ok(IrisDescription { blades, rotation: list.float_or("bladerotation", 0.0, r)?.to_radians() })
    }

    /// The times of the shutter; `is_timed`: whether they are those of the exposure.
    fn shutter(&mut self, list: &mut ParameterList, is_timed: bool) -> ParseResult<()> {
        let place = list.value_place(if list.has("shutterclose") { "shutterclose" } else { "shutteropen" });
        let r = &mut self.reporter;
        let open = list.float_or("shutteropen", 0.0, r)?;
        let close = list.float_or("shutterclose", 1.0, r)?;
        if is_timed && close <= open {
            let message =
                format!("camera: the shutter opens at {open} and closes at {close}; it must close later");
            return Err(r.error(&place, "parameter-range", message));
        }
        self.shutter_time = if is_timed { close - open } else { 1.0 };
        Ok(())
    }
}
