//! The immutable scene and its queries.

mod lights;

use std::sync::Arc;

use glanz_geometry::bvh::Bvh;
use glanz_geometry::{Hit, RaySurface};
use glanz_job::ScratchFileError;
use glanz_light::{EmissionSpectrum, Spectrum, Wavelengths};
use glanz_math::{Bounds3, DVec2, Ray, Transform};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_shading::parameter::TextureEvaluator;
use glanz_shading::texture::TextureCache;
use glanz_shading::{Material, TexturePoint, Textures};

use crate::alpha::RayKind;
use crate::camera::Camera;
use crate::description::EdgeDescription;
use crate::differential::{RayDifferential, SurfaceDifferential};
use crate::hit::{NearestHit, SceneHit};
use crate::interaction::Interaction;
use crate::light::{Light, LightId, LightSelector, LightTree};
use crate::medium::SceneMedia;
use crate::object::SceneObject;
use crate::parameterization::{LocalPoint, ShapeParameterization};
use crate::placed::ParametricPoint;
use crate::receiver::NamedReceiver;
use crate::section::GroupSection;
use crate::surface_detail::SurfaceDetail;

/// Largest depth to which groups may be nested.
pub const MAX_NESTING: usize = 8;

/// Objects and instances with one frame, and the hierarchy over them.
#[derive(Debug)]
pub(crate) struct SceneGroup {
    pub(crate) objects: Vec<SceneObject>,
    pub(crate) instances: Vec<Instance>,
    /// The primitives in the order of the hierarchy's indices.
    pub(crate) bounded: Vec<Primitive>,
    /// Primitives without a finite box.
    pub(crate) unbounded: Vec<Primitive>,
    pub(crate) bvh: Bvh,
    /// For each instance, the number of surfaces of this group that [`Scene::placed_surfaces`] lists before those of the instance; last, the
    /// number of all.
    pub(crate) placed_before: Vec<u64>,
    /// Largest distance, over all copies, of the origin of the frame from those of the frames around it up to the world's, in its own units.
    pub(crate) placement_distance: f64,
    pub(crate) section: Option<GroupSection>,
    pub(crate) edges: Vec<EdgeDescription>,
    /// Whether it has edges, or one of its instances.
    pub(crate) has_edges: bool,
}

impl SceneGroup {
    /// A primitive by its number: those without a box come first.
    pub(crate) fn primitive(&self, number: usize) -> Primitive {
        match number.checked_sub(self.unbounded.len()) {
            Some(index) => self.bounded[index],
            None => self.unbounded[number],
        }
    }

    /// The instance that a surface is in, by the number of the surface, and its number in the instance; `None` if it is an object of
    /// the group itself.
    pub(crate) fn instance_of(&self, number: u64) -> Option<(&Instance, u64)> {
        let index = self.placed_before.partition_point(|&before| before <= number).checked_sub(1)?;
        Some((self.instances.get(index)?, number - self.placed_before[index]))
    }
}

/// A copy of a group.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) group: usize,
    pub(crate) to_parent: Transform,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Primitive {
    Object(u32),
    Instance(u32),
}

/// A scene in which nothing can be invalid and nothing changes.
///
/// Everything but the camera is shared with the scenes of [`Scene::with_camera`].
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) camera: Camera,
    /// All groups; the last is the world.
    pub(crate) groups: Arc<[SceneGroup]>,
    pub(crate) materials: Arc<[Material]>,
    /// One per material.
    pub(crate) surface_details: Arc<[Option<SurfaceDetail>]>,
    pub(crate) textures: Arc<Textures>,
    /// The caches of pictures that are in files.
    pub(crate) texture_caches: Arc<[TextureCache]>,
    pub(crate) media: Arc<SceneMedia>,
    pub(crate) lights: Arc<[Light]>,
    pub(crate) infinite_lights: Arc<[LightId]>,
    /// Selects lights to sample from a point.
    pub(crate) light_tree: Arc<LightTree>,
    /// Selects lights at which paths start.
    pub(crate) emitters: Arc<LightSelector>,
    pub(crate) bounds: Bounds3,
    pub(crate) receivers: Arc<[NamedReceiver]>,
    /// One per light.
    pub(crate) light_spectra: Arc<[EmissionSpectrum]>,
    /// See [`Scene::backdrop_radiance`].
    pub(crate) backdrop: Option<(Spectrum, EmissionSpectrum)>,
}

impl Scene {
    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The same scene with another camera. Nothing is copied: both share all other data.
    #[must_use]
    pub fn with_camera(&self, camera: Camera) -> Self {
        Self { camera, ..self.clone() }
    }

    /// The bounding box of all bounded objects; empty if there is none.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// The parameterization of each shape, by the shape's number; `None` where there is no such shape.
    ///
    /// Copies of a shape by instances share it.
    #[must_use]
    pub fn parameterizations(&self) -> Vec<Option<ShapeParameterization>> {
        let mut parameterizations: Vec<Option<ShapeParameterization>> = Vec::new();
        let objects = self.groups.iter().flat_map(|group| &group.objects);
        for (id, parameterization) in objects.flat_map(SceneObject::parameterizations) {
            let id = id as usize;
            if parameterizations.len() <= id {
                parameterizations.resize(id + 1, None);
            }
            if let Some(slot) = parameterizations.get_mut(id) {
                *slot =
                    Some(slot.map_or(parameterization, |other: ShapeParameterization| {
                        other.joined(parameterization)
                    }));
            }
        }
        parameterizations
    }

    /// All lights.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// All materials.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Whether a bump map or a picture of normals changes the shading normals of the material with this number.
    #[must_use]
    pub fn has_surface_detail(&self, material: u32) -> bool {
        self.surface_details.get(material as usize).is_some_and(Option::is_some)
    }

    pub(crate) fn material(&self, index: u32) -> &Material {
        &self.materials[index as usize]
    }

    /// The material with this number; of a mixture that which a number `xi` in [0, 1) selects at a point. `None`: it does not exist.
    #[must_use]
    pub fn material_at(
        &self,
        number: usize,
        at: &TexturePoint,
        wavelengths: &Wavelengths,
        mut xi: f64,
    ) -> Option<&Material> {
        let mut material = self.materials.get(number)?;
        while let Material::Mix(mix) = material {
            let part = mix.select(&TextureEvaluator::new(&self.textures, at, wavelengths), xi);
            material = self.materials.get(part)?;
            // Mixtures within each other decide independently.
            xi = unit_f64(combine(xi.to_bits(), part as u64));
        }
        Some(material)
    }

    /// All textures.
    #[must_use]
    pub fn textures(&self) -> &Textures {
        &self.textures
    }

    /// Checks that all texels could be read so far. Where one could not, it was black: what was computed since is of no use.
    ///
    /// # Errors
    /// [`ScratchFileError`] of a file of pictures.
    pub fn check_textures(&self) -> Result<(), ScratchFileError> {
        self.texture_caches.iter().try_for_each(TextureCache::check)
    }

    pub(crate) fn world(&self) -> &SceneGroup {
        &self.groups[self.groups.len() - 1]
    }

    pub(crate) fn world_object(&self, index: u32) -> Option<&SceneObject> {
        self.world().objects.get(index as usize)
    }

    /// The first hit of the ray with `0 < t < t_max`.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Interaction> {
        self.closest(self.world(), ray, t_max).map(|found| self.interaction(ray, &found))
    }

    /// As [`Scene::intersect`], with the point by its parameters.
    #[must_use]
    pub fn intersect_parametric(&self, ray: &Ray, t_max: f64) -> Option<(Interaction, ParametricPoint)> {
        let found = self.closest(self.world(), ray, t_max)?;
        let at = self.interaction(ray, &found);
        Some((at, self.parametric_point(&found, &at)))
    }

    /// As [`Scene::intersect_parametric`], of a ray of unit direction that may have a differential.
    #[must_use]
    pub fn intersect_differential(
        &self,
        ray: &Ray,
        differential: Option<&RayDifferential>,
    ) -> Option<(Interaction, ParametricPoint)> {
        let found = self.closest(self.world(), ray, f64::INFINITY)?;
        let at = self.interaction_differential(ray, &found, differential);
        Some((at, self.parametric_point(&found, &at)))
    }

    /// The parameters of a hit of this scene. `at`: the point at the hit, by [`Scene::interaction`].
    #[must_use]
    pub fn parametric_point(&self, found: &SceneHit, at: &Interaction) -> ParametricPoint {
        let Hit { u, v, face, .. } = found.hit;
        let back = at.point.normal.dot(at.wo) < 0.0;
        // No list holds more surfaces, so that no look-up finds this number.
        let surface = u32::try_from(found.surface).unwrap_or(u32::MAX);
        ParametricPoint { surface, face, back, uv: DVec2::new(u, v) }
    }

    /// Whether the ray hits anything with `0 < t < t_max`.
    #[must_use]
    pub fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.any(self.world(), ray, t_max)
    }

    /// As [`Scene::closest`], regardless of a section.
    pub(crate) fn closest_uncut(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> Option<SceneHit> {
        let mut nearest = NearestHit::before(t_max);
        for number in 0..group.unbounded.len() {
            self.visit(group, number, ray, &mut nearest);
        }
        group.bvh.closest(ray, nearest.t(), |leaf, _| {
            for &index in group.bvh.leaf(leaf) {
                self.visit(group, group.unbounded.len() + index as usize, ray, &mut nearest);
            }
            nearest.t()
        });
        nearest.hit()
    }

    /// Offers the hit with a primitive, by its number.
    pub(crate) fn visit(&self, group: &SceneGroup, number: usize, ray: &Ray, nearest: &mut NearestHit) {
        let found = match group.primitive(number) {
            Primitive::Object(object) => {
                let hit = group.object_hit(object, ray, nearest.end(), RayKind::Closest);
                hit.map(|hit| SceneHit::new(hit, object))
            }
            Primitive::Instance(index) => {
                let instance = &group.instances[index as usize];
                let local = instance.to_parent.inverse().ray(ray);
                let found = self.closest(&self.groups[instance.group], &local, nearest.end());
                found.map(|found| found.within(group.placed_before[index as usize]))
            }
        };
        if let Some(found) = found {
            nearest.offer(found, number);
        }
    }

    /// As [`Scene::any`], regardless of a section.
    pub(crate) fn any_uncut(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> bool {
        let stops = |primitive: Primitive| self.is_stopped_by(group, primitive, ray, t_max);
        group.unbounded.iter().any(|&primitive| stops(primitive))
            || group.bvh.any(ray, t_max, |leaf| {
                group.bvh.leaf(leaf).iter().any(|&index| stops(group.bounded[index as usize]))
            })
    }

    /// Whether a primitive of `group` stops a ray.
    pub(crate) fn is_stopped_by(
        &self,
        group: &SceneGroup,
        primitive: Primitive,
        ray: &Ray,
        t_max: f64,
    ) -> bool {
        match primitive {
            Primitive::Object(object) => group.is_stopped_by_object(object, ray, t_max),
            Primitive::Instance(index) => {
                let instance = &group.instances[index as usize];
                let local = instance.to_parent.inverse().ray(ray);
                self.any(&self.groups[instance.group], &local, t_max)
            }
        }
    }

    /// The point at a hit of this scene with this ray.
    #[must_use]
    pub fn interaction(&self, ray: &Ray, found: &SceneHit) -> Interaction {
        self.interaction_differential(ray, found, None)
    }

    /// As [`Scene::interaction`], of a ray of unit direction that may have a differential.
    #[must_use]
    pub fn interaction_differential(
        &self,
        ray: &Ray,
        found: &SceneHit,
        differential: Option<&RayDifferential>,
    ) -> Interaction {
        let (mut group, mut number) = (self.world(), found.surface);
        let (mut moved, mut depth) = (None, 0);
        let mut maps = [&Transform::IDENTITY; MAX_NESTING];
        while let Some((instance, inner)) = group.instance_of(number) {
            moved = Some(instance.to_parent.inverse().ray(moved.as_ref().unwrap_or(ray)));
            maps[depth] = &instance.to_parent;
            depth += 1;
            (group, number) = (&self.groups[instance.group], inner);
        }
        let object = &group.objects[number as usize];
        let attributes = object.attributes(found.hit.face);
        if let Some(to_parent) = object.to_parent() {
            moved = Some(to_parent.inverse().ray(moved.as_ref().unwrap_or(ray)));
        }
        let local = moved.as_ref().unwrap_or(ray);
        // Filled in place: a copy of an interaction costs as much as part of its computation.
        let mut at = Interaction {
            point: object.own_point(local, &found.hit),
            t: found.hit.t,
            wo: -ray.direction.normalize(),
            id: attributes.id,
            differential: None,
            own: None,
            area_pdf: object.area_pdf(local, &found.hit),
            material: attributes.material,
            media: attributes.media,
            light: object.light,
        };
        at.own = moved.map(|local| LocalPoint::new(at.point.position, at.point.normal, local.direction));
        object.place(&mut at.point, attributes.reversed);
        for map in maps[..depth].iter().rev() {
            at.point = at.point.transformed(map);
        }
        if let Some(differential) = differential {
            let (point, normal) = object.differential_point(local, &found.hit, &maps[..depth]);
            let uv_rates = object.surface().uv_rates(&found.hit);
            at.differential = SurfaceDifferential::try_new(ray, differential, at.t, &point, normal, uv_rates);
        }
        if attributes.has_detail {
            self.apply_surface_detail(&mut at, object, local, &found.hit, &maps[..depth]);
        }
        at
    }
}
