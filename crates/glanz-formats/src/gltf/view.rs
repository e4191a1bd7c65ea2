//! The camera and lights of a file.

use glanz_light::SpectralDistribution;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{CameraDescription, CameraKind, LightDescription, LightKind, SpotFalloff};

use super::GltfReader;
use super::error::GltfError;
use super::json::{JsonObject, JsonPath};
use crate::finder::entry_bytes;

/// W of light of the luminance of white per lumen.
pub(super) const WATTS_PER_LUMEN: f32 = (1.0 / LUMINOUS_EFFICACY) as f32;

/// Pixels of a picture whose sides have a ratio of a file.
const PIXELS: f64 = 1280.0 * 720.0;

/// The unit vector along a column of a matrix.
fn axis(matrix: &DMat4, column: usize) -> Option<DVec3> {
    matrix.col(column).truncate().try_normalize()
}

impl GltfReader<'_, '_> {
    /// Sets the camera, if it is the first one. `node`: names it.
    pub(super) fn camera(
        &mut self,
        number: usize,
        to_world: DMat4,
        node: &JsonObject<'_>,
    ) -> Result<(), GltfError> {
        let document = self.document;
        let (kind, aspect, screen_window) =
            document.element("cameras", number, &node.path().name("camera"), |camera| projection(&camera))?;
        if self.reader.own_camera {
            return Ok(());
        }
        // Its scale has no effect; it looks along -z, with +y up.
        let frame = axis(&to_world, 2).zip(axis(&to_world, 1)).and_then(|(back, up)| {
            let right = up.cross(back).try_normalize()?;
            Some([right, back.cross(right), -back])
        });
        let Some([right, up, forward]) = frame else {
            return Err(node.fault("the transformation of the camera cannot be inverted"));
        };
        let [right, up, forward] = [right, up, forward].map(|axis| axis.extend(0.0));
        let to_world = DMat4::from_cols(right, up, forward, to_world.w_axis);
        self.reader.description.camera =
            CameraDescription { kind, to_world, screen_window, ..CameraDescription::default() };
        if let Some(aspect) = aspect {
            let height = (PIXELS / aspect).sqrt();
            let size = [height * aspect, height].map(|side| side.round().clamp(1.0, 65535.0) as u32);
            self.reader.description.film.resolution = size;
        }
        self.reader.own_camera = true;
        Ok(())
    }

    /// Adds a light. `from`: names it.
    pub(super) fn light(
        &mut self,
        number: usize,
        to_world: DMat4,
        from: &JsonObject<'_>,
    ) -> Result<(), GltfError> {
        let root = self.document.root()?;
        let light = root.extension("KHR_lights_punctual", |extension| {
            let lights = extension.map(|extension| extension.list("lights")).transpose()?.unwrap_or_default();
            let Some(light) = lights.get(number) else {
                return Err(
                    from.error("light", format!("light {number} does not exist; there are {}", lights.len()))
                );
            };
            let root = JsonPath::ROOT;
            let path = root.name("extensions");
            let path = path.name("KHR_lights_punctual");
            let path = path.name("lights");
            let path = path.index(number);
            light_of(&JsonObject::try_new(light, &path)?, to_world)
        })?;
        self.reader.own_light = true;
        if light.is_some() {
            self.spend_object(entry_bytes::<LightDescription>(""), from.path())?;
        }
        self.reader.description.lights.extend(light);
        Ok(())
    }
}

/// The projection of a camera, width over height of its picture, and the range of its screen.
#[allow(clippy::type_complexity)]
fn projection(camera: &JsonObject<'_>) -> Result<(CameraKind, Option<f64>, Option<[f64; 4]>), GltfError> {
    match camera.text("type")? {
        Some("perspective") => camera.object_or_empty("perspective", |perspective| {
            let vertical = perspective.required_number("yfov")?;
            let aspect = perspective.number("aspectRatio")?;
            if aspect.is_some_and(|aspect| !(1e-3..=1e3).contains(&aspect)) {
                return Err(perspective.error("aspectRatio", "the ratio is not between 0.001 and 1000"));
            }
            if !(vertical > 0.0 && vertical < std::f64::consts::PI) {
                return Err(perspective.error("yfov", format!("{vertical} is not between 0 and pi")));
            }
            // The angle here is that over the shorter side.
            let shorter = aspect.unwrap_or(1.0).min(1.0);
            let field_of_view = 2.0 * ((0.5 * vertical).tan() * shorter).atan();
            Ok((CameraKind::Perspective { field_of_view }, aspect, None))
        }),
        Some("orthographic") => camera.object_or_empty("orthographic", |orthographic| {
            let [x, y] = ["xmag", "ymag"].map(|name| orthographic.required_number(name));
            let (x, y) = (x?.abs(), y?.abs());
            if !(1e-3..=1e3).contains(&(x / y)) {
                return Err(orthographic.fault("xmag and ymag must not be 0"));
            }
            Ok((CameraKind::Orthographic, Some(x / y), Some([-x, x, -y, y])))
        }),
        _ => Err(camera.error("type", "a camera is \"perspective\" or \"orthographic\"")),
    }
}

/// A light in the world; `None` for one without light.
fn light_of(light: &JsonObject<'_>, to_world: DMat4) -> Result<Option<LightDescription>, GltfError> {
    let color = light.color("color")?.unwrap_or([1.0; 3]);
    let intensity = light.positive("intensity", 1.0)?;
    let emission = SpectralDistribution::from(color.map(|x| (x * intensity) as f32));
    let from = to_world.w_axis.truncate();
    let direction = -axis(&to_world, 2).unwrap_or(DVec3::Z);
    let kind = match light.text("type")? {
        Some("point") => LightKind::Point { from, range: None },
        Some("directional") => LightKind::Distant { from: DVec3::ZERO, to: direction },
        Some("spot") => light.object_or_empty("spot", |spot| {
            let cone_angle = spot.positive("outerConeAngle", std::f64::consts::FRAC_PI_4)?;
            let inner_angle = spot.positive("innerConeAngle", 0.0)?.min(cone_angle);
            let (to, falloff) = (from + direction, SpotFalloff::Smoothstep);
            Ok(LightKind::Spot { from, to, cone_angle, inner_angle, falloff })
        })?,
        _ => return Err(light.error("type", "a light is \"point\", \"spot\" or \"directional\"")),
    };
    let light = LightDescription { scale: WATTS_PER_LUMEN, ..LightDescription::new(kind, emission) };
    Ok((intensity > 0.0 && color != [0.0; 3]).then_some(light))
}
