//! Camera, ground and light for models that have none of their own.
//!
//! ```
//! use glanz_scene::description::{MaterialKind, ShapeDescription};
//! use glanz_scene::studio::{StudioSettings, add_studio};
//! use glanz_scene::{Scene, SceneBuilder};
//!
//! let mut model = SceneBuilder::new().shape(ShapeDescription::torus(2.0, 0.5), MaterialKind::diffuse(0.5)).describe()?;
//! add_studio(&mut model, &StudioSettings::default());
//! let (scene, _) = Scene::resolve(model)?;
//! assert_eq!(scene.lights().len(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod color;
mod light;
mod material;
mod section;
mod view;

pub use color::{SrgbColor, SrgbColorError};
pub use material::{CAD_GREY, StudioMaterial, StudioMaterialError, cad_material};
pub use section::{SectionPlane, SectionPlaneError};
pub use view::{StudioView, TurntableFrame, UpAxis, UpAxisError};

use glanz_math::{Bounds3, DVec3};

use crate::description::{Description, MaterialDescription};
use view::ViewFrame;

/// Settings of the picture of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct StudioSettings {
    /// Direction from which the model is seen; `None`: that of its own camera, else [`StudioView::Iso`].
    pub view: Option<StudioView>,
    /// Whether the model has a camera, which is used unless a view or a turn is given.
    pub own_camera: bool,
    /// Whether the model has light, so that the studio adds neither light nor ground nor background.
    pub own_light: bool,
    /// Upward axis; `None`: that of the model's format, or z.
    pub up: Option<UpAxis>,
    /// Colour of the background and of the ground where no shadow falls.
    pub background: SrgbColor,
    /// Whether the model stands on a ground; there is none between a camera below it and the model.
    pub ground: bool,
    /// Material of all shapes; `None`: their own.
    pub material: Option<StudioMaterial>,
    /// A plane that cuts the model open, with marked faces; `None`: the whole model.
    pub section: Option<SectionPlane>,
    /// A frame of a turn around the upward axis, in which the model has the same size in all frames; `None`: a single picture.
    pub turntable: Option<TurntableFrame>,
}

impl Default for StudioSettings {
    fn default() -> Self {
        Self {
            view: None,
            own_camera: false,
            own_light: false,
            up: None,
            background: SrgbColor([214; 3]),
            ground: true,
            material: None,
            section: None,
            turntable: None,
        }
    }
}

impl StudioSettings {
    /// Whether [`add_studio`] would add nothing: the model has a camera and light, and the settings ask for no other view or material, no turn
    /// and no section.
    #[must_use]
    pub fn is_superfluous(&self) -> bool {
        let changes = self.material.is_some() || self.section.is_some();
        self.own_light && self.uses_own_camera() && !changes
    }

    fn uses_own_camera(&self) -> bool {
        self.own_camera && self.view.is_none() && self.turntable.is_none()
    }
}

/// Samples per pixel of the picture of a model.
const SAMPLES: u32 = 64;

/// Distance of model and ground, in diagonals of the model: flat bottoms must not coincide with the ground.
const GROUND_GAP: f64 = 1e-5;

/// Adds what a model lacks of camera, ground, light and background to its description, and sets its number of samples.
///
/// The camera sees all of the model, in a picture of the description's film. All lengths are relative to the size of the model, so that
/// the picture does not depend on its unit.
pub fn add_studio(description: &mut Description, settings: &StudioSettings) {
    let up = settings.up.unwrap_or_default();
    let above = up.direction();
    let view = ViewFrame::new(settings.view.unwrap_or_default(), up);
    let bounds = description.bounds();
    if let Some(material) = settings.material {
        replace_materials(description, material);
    }
    description.sampler.samples_per_pixel = SAMPLES;
    let frame = if settings.uses_own_camera() {
        ViewFrame::of_camera(&description.camera.to_world, above).unwrap_or(view)
    } else {
        let frame = view.turned(settings.turntable, above);
        let [width, height] = description.film.resolution.map(f64::from);
        let aspect = if width > 0.0 && height > 0.0 { width / height } else { 1.0 };
        let turned_about = settings.turntable.map(|_| above);
        description.camera = view::fitted_camera(description, bounds, &frame, aspect, turned_about);
        frame
    };
    if let Some(plane) = settings.section {
        section::cut(description, plane, bounds, &view);
    }
    if !settings.own_light {
        add_light(description, settings, bounds, &frame, above);
    }
}

/// Adds light, background and ground.
fn add_light(
    description: &mut Description,
    settings: &StudioSettings,
    bounds: Bounds3,
    frame: &ViewFrame,
    above: DVec3,
) {
    description.lights.extend(light::lights(frame, above));
    let background = settings.background.to_linear();
    description.backdrop = Some(background.into());
    let lowest = bounds.min.dot(above) - GROUND_GAP * bounds.diagonal().length();
    let eye = description.camera.to_world.w_axis.truncate();
    if settings.ground && !bounds.is_empty() && eye.dot(above) > lowest {
        description.materials.push(light::ground_material(background).into());
        let point = bounds.center() + (lowest - bounds.center().dot(above)) * above;
        let material = description.materials.len() - 1;
        description.world.shapes.push(light::ground(point, above, material));
    }
}

fn replace_materials(description: &mut Description, material: StudioMaterial) {
    description.materials = vec![MaterialDescription::from(material.kind())];
    for group in description.groups.iter_mut().chain([&mut description.world]) {
        group.shapes.iter_mut().for_each(|shape| shape.material = 0);
    }
}

#[cfg(test)]
mod tests;
