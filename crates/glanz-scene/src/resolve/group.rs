//! Resolves groups of shapes and instances.

mod pending;

use std::collections::BTreeSet;
use std::sync::Arc;

use glanz_geometry::bvh::{BuildOptions, Bvh};
use glanz_job::ResourceBudget;
use glanz_light::{EmissionSpectrum, Wavelengths};
use glanz_math::{Bounds3, Transform};
use glanz_shading::Material;
use rayon::prelude::*;

use self::pending::{BuiltShape, PendingShape, ShapeEntry};
use super::emission::{EmissionPictures, area_light, emission_per_object};
use super::join::join_small_meshes;
use super::medium::{MediaEnds, ResolvedMedia};
use super::texture::ResolvedTextures;
use super::{LARGEST_COORDINATE, WarningList, range_error, shape, spend, transform};
use crate::description::{
    EdgeDescription, EmissionDescription, GroupDescription, ImageDescription, InstanceDescription, Location,
    ReceiverDescription, SectionDescription, ShapeDescription,
};
use crate::error::{SceneError, SceneErrorKind};
use crate::light::{Light, LightId};
use crate::medium::MediumInterface;
use crate::object::SceneObject;
use crate::receiver::NamedReceiver;
use crate::scene::{Instance, MAX_NESTING, Primitive, SceneGroup};
use crate::section::GroupSection;
use crate::surface_detail::SurfaceDetail;

/// An object that emits light, in the frame of its group.
///
/// Every copy of it is a separate light: it is left out of the group and added to the world once per copy.
#[derive(Clone)]
struct EmissiveObject {
    object: SceneObject,
    emission: EmissionDescription,
    location: Option<Location>,
}

/// Bytes of a copy of an object that emits light, with its light.
const LIGHT_COPY: usize = size_of::<EmissiveObject>() + size_of::<Light>() + size_of::<EmissionSpectrum>();

/// The contents of a group.
#[derive(Default)]
struct GroupParts {
    objects: Vec<SceneObject>,
    emitters: Vec<EmissiveObject>,
    instances: Vec<Instance>,
    /// Number of levels of instances.
    depth: usize,
    /// Solids of which a part of the boundary is missing.
    open: BTreeSet<u32>,
}

/// Resolves groups one after the other.
pub(super) struct GroupResolver<'a> {
    textures: &'a ResolvedTextures,
    wavelengths: &'a Wavelengths,
    budget: &'a ResourceBudget,
    groups: Vec<SceneGroup>,
    emitters: Vec<Vec<EmissiveObject>>,
    depths: Vec<usize>,
    /// Per material, whether it is an interface.
    passable: Vec<bool>,
    /// Per material, its surface detail.
    details: &'a [Option<SurfaceDetail>],
    media: &'a ResolvedMedia,
    media_ends: MediaEnds,
    next_id: u32,
    receivers: Vec<NamedReceiver>,
}

/// All groups, the last of which is the world, with their lights and receivers.
pub(super) struct ResolvedGroups {
    pub(super) groups: Vec<SceneGroup>,
    /// One for each copy of a shape that emits light.
    pub(super) lights: Vec<Light>,
    /// One per light.
    pub(super) light_spectra: Vec<EmissionSpectrum>,
    pub(super) receivers: Vec<NamedReceiver>,
    pub(super) media_ends: MediaEnds,
}

impl<'a> GroupResolver<'a> {
    /// `details`: one per material.
    pub(super) fn new(
        materials: &[Material],
        details: &'a [Option<SurfaceDetail>],
        media: &'a ResolvedMedia,
        textures: &'a ResolvedTextures,
        wavelengths: &'a Wavelengths,
        budget: &'a ResourceBudget,
    ) -> Self {
        let passable = materials.iter().map(Material::is_interface).collect();
        Self {
            textures,
            wavelengths,
            budget,
            details,
            media,
            media_ends: MediaEnds::default(),
            groups: Vec::new(),
            emitters: Vec::new(),
            depths: Vec::new(),
            passable,
            next_id: 0,
            receivers: Vec::new(),
        }
    }

    /// Adds the group with this index, after all groups that it refers to.
    pub(super) fn add(
        &mut self,
        mut description: GroupDescription,
        index: usize,
        warnings: &mut WarningList,
    ) -> Result<(), SceneError> {
        let edges = std::mem::take(&mut description.edges);
        let inner = description.shapes.iter().find_map(|shape| shape.receiver.as_ref());
        if let Some(ReceiverDescription { name, location, .. }) = inner {
            let kind = SceneErrorKind::ReceiverInGroup(name.clone());
            return Err(SceneError { location: *location, kind });
        }
        let GroupParts { mut objects, emitters, instances, depth, .. } =
            self.parts(description, index, warnings)?;
        // Copies of what emits light are added to the world.
        let open: BTreeSet<u32> = emitters.iter().filter_map(|emitter| emitter.object.solid).collect();
        release_solids(&mut objects, &open);
        self.groups.push(self.build(objects, instances, edges));
        self.emitters.push(emitters);
        self.depths.push(depth);
        Ok(())
    }

    /// Cuts the group open that was added last.
    pub(super) fn cut(
        &mut self,
        description: &SectionDescription,
        warnings: &mut WarningList,
    ) -> Result<(), SceneError> {
        let invalid = || range_error(None, "section: normal", description.normal, "finite and not 0");
        reference("material", description.material, self.passable.len(), None)?;
        let Some(group) = self.groups.last_mut() else { return Ok(()) };
        let section = GroupSection::try_new(description, group.objects.len() as u32).ok_or_else(invalid)?;
        // Behind all objects of the hierarchy; instances have the numbers after it.
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1);
        group.objects.extend(shape::objects(
            section.shape(description.material),
            id,
            MediumInterface::NONE,
            warnings,
        )?);
        group.placed_before.iter_mut().for_each(|before| *before += 1);
        group.section = Some(section);
        Ok(())
    }

    /// Adds the world and makes lights of all objects that emit.
    pub(super) fn finish(
        mut self,
        mut world: GroupDescription,
        images: &[ImageDescription],
        warnings: &mut WarningList,
    ) -> Result<ResolvedGroups, SceneError> {
        let index = self.groups.len();
        let edges = std::mem::take(&mut world.edges);
        let GroupParts { mut objects, emitters, instances, .. } = self.parts(world, index, warnings)?;
        let mut lights = Vec::with_capacity(emitters.len());
        let mut light_spectra = Vec::with_capacity(emitters.len());
        let mut pictures = EmissionPictures::new(images, self.budget);
        for emitter in emitters {
            let mut object = emitter.object;
            let index = objects.len() as u32;
            let (emission, location) = (&emitter.emission, emitter.location);
            self.budget.check().map_err(|end| SceneError { location, kind: end.into() })?;
            let light = area_light(index, &object, emission, location, &mut pictures, self.wavelengths)?;
            if !light.can_be_sampled() {
                let message = format!(
                    "points on a {} cannot be sampled, so that its light is found by chance only, with noise; use another shape as light",
                    object.surface().kind()
                );
                warnings.warn(emitter.location, message);
            }
            object.light = Some(LightId(lights.len() as u32));
            lights.push(Light::Area(light));
            light_spectra.push(EmissionSpectrum::new(&emission.radiance));
            objects.push(object);
        }
        let world = self.build(objects, instances, edges);
        self.groups.push(world);
        measure_placements(&mut self.groups);
        let Self { groups, receivers, media_ends, .. } = self;
        Ok(ResolvedGroups { groups, lights, light_spectra, receivers, media_ends })
    }

    fn parts(
        &mut self,
        description: GroupDescription,
        index: usize,
        warnings: &mut WarningList,
    ) -> Result<GroupParts, SceneError> {
        let pending = self.pending_shapes(description.shapes)?;
        // Surfaces of CAD models are many, and each takes a while to build.
        let build = |shape: PendingShape| shape.build_within(self.budget);
        let built: Vec<_> = pending.into_par_iter().map(build).collect::<Result<_, _>>()?;
        let mut parts = GroupParts::default();
        for shape in built {
            self.add_built(shape, &mut parts, warnings)?;
        }
        self.add_instances(description.instances, index, &mut parts)?;
        release_solids(&mut parts.objects, &parts.open);
        release_solids(parts.emitters.iter_mut().map(|emitter| &mut emitter.object), &parts.open);
        parts.objects = join_small_meshes(parts.objects);
        Ok(parts)
    }

    fn pending_shapes(&mut self, shapes: Vec<ShapeDescription>) -> Result<Vec<PendingShape>, SceneError> {
        let mut pending = Vec::with_capacity(shapes.len());
        for mut shape in shapes {
            let id = self.next_id;
            self.next_id = self.next_id.wrapping_add(1);
            let location = shape.location;
            reference("material", shape.material, self.passable.len(), location)?;
            let inputs = self.textures.inputs(self.wavelengths, location);
            let alpha =
                shape.alpha.as_ref().map(|alpha| inputs.alpha(alpha, &self.textures.textures)).transpose()?;
            let alpha = alpha.flatten().map(Arc::new);
            let receiver = shape.receiver.take();
            let receiver = receiver.map(|r| NamedReceiver::try_new(r, id, alpha.is_none())).transpose()?;
            let entry = ShapeEntry {
                id,
                passable: self.passable[shape.material],
                has_detail: self.details.get(shape.material).is_some_and(Option::is_some),
                alpha,
                location,
                emission: shape.emission.take(),
                solid: shape.solid,
                receiver,
                media: self.media.interface(shape.media, location)?,
            };
            pending.push(PendingShape { entry, shape });
        }
        Ok(pending)
    }

    fn add_built(
        &mut self,
        shape: BuiltShape,
        parts: &mut GroupParts,
        warnings: &mut WarningList,
    ) -> Result<(), SceneError> {
        let (entry, objects) = (shape.entry, shape.objects?);
        warnings.warnings.extend(shape.warnings.warnings);
        for object in &objects {
            check_extent(&object.bounds(), entry.location)?;
        }
        let (is_absent, bounds_medium) = (entry.is_absent(), entry.bounds_medium());
        self.media_ends.anywhere |= bounds_medium;
        self.media_ends.at_interfaces |= bounds_medium && entry.passable;
        // What light passes has no effect if it neither emits nor measures light and no medium ends there.
        let is_passed = entry.passable && !bounds_medium || is_absent;
        let is_left_out = is_passed && entry.receiver.is_none() && entry.emission.is_none();
        self.receivers.extend(entry.receiver.filter(|_| !objects.is_empty()));
        if is_left_out || is_absent {
            parts.open.extend(entry.solid);
        }
        match entry.emission {
            Some(emission) => {
                let location = entry.location;
                let emissions = emission_per_object(&emission, &objects, location)?;
                let shining = objects.into_iter().zip(emissions);
                let emitters =
                    shining.map(|(object, emission)| EmissiveObject { object, emission, location });
                parts.emitters.extend(emitters);
            }
            None if is_left_out => {}
            None => parts.objects.extend(objects),
        }
        Ok(())
    }

    /// Adds the instances of the group with this index, after its own shapes.
    fn add_instances(
        &self,
        instances: Vec<InstanceDescription>,
        index: usize,
        parts: &mut GroupParts,
    ) -> Result<(), SceneError> {
        let mut placed = parts.objects.len() as u64;
        for InstanceDescription { name: _, group, to_parent, location } in instances {
            reference("object", group, index.min(self.groups.len()), location)?;
            let to_parent = transform(to_parent, "instance", location)?;
            // A light cannot be shared by instances.
            let copies = self.emitters.get(group).map_or(0, Vec::len);
            let bytes = size_of::<Instance>() + copies * LIGHT_COPY;
            spend(self.budget, 1 + copies as u64, bytes as u64, location)?;
            parts.depth = parts.depth.max(self.depths[group] + 1);
            if parts.depth > MAX_NESTING {
                return Err(SceneError { location, kind: SceneErrorKind::Nesting(MAX_NESTING) });
            }
            placed += self.groups[group].placed_before.last().copied().unwrap_or_default();
            if placed >= MOST_SURFACES {
                return Err(SceneError { location, kind: SceneErrorKind::TooManyCopies });
            }
            parts.emitters.extend(self.emitters[group].iter().map(|e| EmissiveObject {
                object: e.object.placed(&to_parent),
                emission: e.emission.clone(),
                location: e.location,
            }));
            check_extent(&instance_bounds(&self.groups[group], &to_parent), location)?;
            parts.instances.push(Instance { group, to_parent });
        }
        Ok(())
    }

    fn build(
        &self,
        objects: Vec<SceneObject>,
        instances: Vec<Instance>,
        edges: Vec<EdgeDescription>,
    ) -> SceneGroup {
        let mut bounded = Vec::new();
        let mut unbounded = Vec::new();
        let mut boxes = Vec::new();
        let present = objects.iter().enumerate().filter(|(_, object)| !object.is_absent());
        let of_objects = present.map(|(i, object)| (Primitive::Object(i as u32), object.bounds()));
        let of_instances = instances.iter().enumerate().map(|(i, instance)| {
            (
                Primitive::Instance(i as u32),
                instance_bounds(&self.groups[instance.group], &instance.to_parent),
            )
        });
        for (primitive, bounds) in of_objects.chain(of_instances) {
            if bounds.is_finite() {
                bounded.push(primitive);
                boxes.push(bounds);
            } else if !bounds.is_empty() {
                unbounded.push(primitive);
            }
        }
        let bvh = Bvh::build(&boxes, &BuildOptions::default());
        let mut placed_before = vec![objects.len() as u64];
        for instance in &instances {
            let inner = self.groups[instance.group].placed_before.last().copied().unwrap_or_default();
            placed_before.push(placed_before.last().copied().unwrap_or_default() + inner);
        }
        let has_edges =
            !edges.is_empty() || instances.iter().any(|instance| self.groups[instance.group].has_edges);
        SceneGroup {
            objects,
            instances,
            bounded,
            unbounded,
            bvh,
            placed_before,
            placement_distance: 0.0,
            section: None,
            edges,
            has_edges,
        }
    }
}

/// Sets the distances of the groups, the last of which is the world, from the origins of the frames around them.
fn measure_placements(groups: &mut [SceneGroup]) {
    for index in (0..groups.len()).rev() {
        // Instances refer to groups before their own.
        let (inner, outer) = groups.split_at_mut(index);
        let Some(group) = outer.first() else { continue };
        for Instance { group: number, to_parent } in &group.instances {
            let Some(placed) = inner.get_mut(*number) else { continue };
            let axes = to_parent.inverse().forward().matrix3;
            let per_unit = axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length());
            let distance = per_unit * (to_parent.forward().translation.length() + group.placement_distance);
            placed.placement_distance = placed.placement_distance.max(distance);
        }
    }
}

/// Makes objects of these solids bound none: a part of the boundary is missing.
fn release_solids<'a>(objects: impl IntoIterator<Item = &'a mut SceneObject>, open: &BTreeSet<u32>) {
    let is_open = |object: &&mut SceneObject| object.solid.is_some_and(|solid| open.contains(&solid));
    objects.into_iter().filter(is_open).for_each(SceneObject::release);
}

/// Numbers of surfaces are below this one, so that sums of two do not overflow.
const MOST_SURFACES: u64 = 1 << 63;

/// The bounding box of all bounded objects of the group.
pub(super) fn finite_bounds(group: &SceneGroup) -> Bounds3 {
    group.bvh.bounds()
}

fn instance_bounds(group: &SceneGroup, to_parent: &Transform) -> Bounds3 {
    if group.unbounded.is_empty() {
        to_parent.bounds(&group.bvh.bounds())
    } else {
        Bounds3 { min: glanz_math::DVec3::NEG_INFINITY, max: glanz_math::DVec3::INFINITY }
    }
}

fn check_extent(bounds: &Bounds3, location: Option<Location>) -> Result<(), SceneError> {
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    if bounds.is_finite() && reach > LARGEST_COORDINATE {
        return Err(range_error(location, "shape: largest coordinate", reach, "at most 1e30 m"));
    }
    Ok(())
}

pub(super) fn reference(
    what: &'static str,
    index: usize,
    count: usize,
    location: Option<Location>,
) -> Result<(), SceneError> {
    if index < count {
        return Ok(());
    }
    Err(SceneError { location, kind: SceneErrorKind::Reference { what, index, count } })
}
