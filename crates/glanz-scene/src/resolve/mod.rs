//! Resolves a description to a scene.

mod emission;
mod freeform;
mod group;
mod join;
mod light;
mod material;
mod medium;
mod shape;
mod texture;

use glanz_geometry::RaySurface;
use glanz_job::{Resource, ResourceBudget};
use glanz_light::{EmissionSpectrum, Wavelengths};
use glanz_math::{Bounds3, DMat4, Transform};
use glanz_shading::texture::TextureCache;

use crate::camera::Camera;
use crate::description::{Description, GeometryDescription, Location};
use crate::error::{SceneError, SceneErrorKind, SceneWarning};
use crate::light::{Light, LightId, LightSelector, LightTree};
use crate::scene::Scene;
pub(crate) use freeform::region as trim_region;
use group::{GroupResolver, ResolvedGroups};
use medium::ResolvedMedia;
pub(crate) use shape::surface as shape_surface;

/// Coordinates beyond this, in metres, leave the range of the hierarchy's `f32` boxes.
pub(crate) const LARGEST_COORDINATE: f64 = 1e30;

/// The bounding box of a surface in its own frame; `None` if its description is invalid.
pub(crate) fn surface_bounds(geometry: &GeometryDescription) -> Option<Bounds3> {
    Some(shape::surface(geometry.clone(), None).ok()?.bounds())
}

/// Warnings so far.
#[derive(Default)]
struct WarningList {
    warnings: Vec<SceneWarning>,
}

impl WarningList {
    fn warn(&mut self, location: Option<Location>, message: impl Into<String>) {
        self.warnings.push(SceneWarning { location, message: message.into() });
    }
}

impl Scene {
    /// Checks a description through the constructors of its parts and builds the hierarchy.
    ///
    /// The warnings name the parts that were repaired or left out.
    ///
    /// # Errors
    /// [`SceneError`] with the place in the input for the first part that is invalid, and [`SceneErrorKind::Budget`] at the default limits.
    pub fn resolve(description: Description) -> Result<(Self, Vec<SceneWarning>), SceneError> {
        Self::resolve_with(description, &ResourceBudget::default())
    }

    /// As [`Scene::resolve`] within a budget, of which objects, lights and the memory of surfaces, materials, media and pictures are taken.
    ///
    /// # Errors
    /// [`SceneError`] as above, and [`SceneErrorKind::Budget`].
    pub fn resolve_with(
        description: Description,
        budget: &ResourceBudget,
    ) -> Result<(Self, Vec<SceneWarning>), SceneError> {
        let wavelengths = Wavelengths::default();
        let mut warnings = WarningList::default();
        let camera = Camera::try_new(&description.camera, &description.film)?;
        let textures = texture::textures(&description, &wavelengths, budget)?;
        let materials = material::materials(&description, &textures, &wavelengths, budget, &mut warnings)?;
        let surface_details = material::surface_details(&description, &textures, &wavelengths)?;
        let media = ResolvedMedia::new(&description, &wavelengths, budget)?;
        let mut groups =
            GroupResolver::new(&materials, &surface_details, &media, &textures, &wavelengths, budget);
        if let Some(section) = &description.section {
            group::reference("group", section.group, description.groups.len(), None)?;
        }
        for (index, group) in description.groups.into_iter().enumerate() {
            groups.add(group, index, &mut warnings)?;
            if let Some(section) = description.section.as_ref().filter(|section| section.group == index) {
                groups.cut(section, &mut warnings)?;
            }
        }
        let ResolvedGroups { groups, mut lights, mut light_spectra, receivers, media_ends } =
            groups.finish(description.world, &description.images, &mut warnings)?;
        for light in &description.lights {
            let picture = light::picture_bytes(light, &description.images).max(light::portal_bytes(light));
            let memory = size_of::<Light>() as u64 + picture;
            spend(budget, 1, memory, light.location)?;
            lights.push(light::light(light, &description.images, &wavelengths, &mut warnings)?);
            light_spectra.push(EmissionSpectrum::new(&light.emission));
        }
        let backdrop = description.backdrop.as_ref().map(|backdrop| {
            let rgb = light::emitted_spectrum(backdrop, 1.0, &wavelengths, "backdrop: radiance", None)?;
            Ok::<_, SceneError>((rgb, EmissionSpectrum::new(backdrop)))
        });
        let bounds = groups.last().map(group::finite_bounds).unwrap_or(Bounds3::EMPTY);
        let radius = if bounds.is_empty() { 1.0 } else { 0.5 * bounds.diagonal().length() };
        let importance: Vec<f64> = lights.iter().map(|l| l.importance(radius)).collect();
        let infinite_lights = lights
            .iter()
            .enumerate()
            .filter(|(_, light)| light.is_infinite())
            .map(|(index, _)| LightId(index as u32))
            .collect();
        let world = groups.last().map(|group| group.objects.as_slice()).unwrap_or_default();
        let extents = lights.iter().zip(&importance).map(|(light, &importance)| {
            (light.extent(world), if light.can_be_sampled() { importance } else { 0.0 })
        });
        let light_tree = LightTree::new(&extents.collect::<Vec<_>>(), radius);
        let emitters = LightSelector::new(&importance);
        let mut texture_caches: Vec<TextureCache> = Vec::new();
        for cache in description.images.iter().filter_map(|image| image.picture.cache()) {
            if !texture_caches.iter().any(|known| known.is_same(cache)) {
                texture_caches.push(cache.clone());
            }
        }
        let scene = Self {
            camera,
            groups: groups.into(),
            materials: materials.into(),
            surface_details: surface_details.into(),
            textures: textures.textures,
            texture_caches: texture_caches.into(),
            media: media.finish(description.camera_medium, media_ends)?.into(),
            lights: lights.into(),
            light_spectra: light_spectra.into(),
            infinite_lights,
            light_tree: light_tree.into(),
            emitters: emitters.into(),
            bounds,
            receivers: receivers.into(),
            backdrop: backdrop.transpose()?,
        };
        Ok((scene, warnings.warnings))
    }
}

/// Takes objects and their memory off the budget; the error has the place of what needs them.
fn spend(
    budget: &ResourceBudget,
    objects: u64,
    bytes: u64,
    location: Option<Location>,
) -> Result<(), SceneError> {
    let spent = budget
        .check_now()
        .and_then(|()| budget.spend(Resource::Objects, objects))
        .and_then(|()| budget.spend(Resource::Memory, bytes));
    spent.map_err(|end| SceneError { location, kind: end.into() })
}

/// A matrix of the description as a transform.
fn transform(matrix: DMat4, what: &'static str, location: Option<Location>) -> Result<Transform, SceneError> {
    Transform::try_from_matrix(matrix)
        .map_err(|source| SceneError { location, kind: SceneErrorKind::Transform { what, source } })
}

/// Error of a parameter outside its range.
pub(crate) fn range_error(
    location: Option<Location>,
    what: &'static str,
    value: impl ToString,
    range: &'static str,
) -> SceneError {
    SceneError { location, kind: SceneErrorKind::Range { what, value: value.to_string(), range } }
}
