//! What preparing a scene may use.

use glanz_job::{BudgetError, CancelFlag, Resource, ResourceBudget, ResourceLimits};
use glanz_light::{Pixels, SpectralDistribution};
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{
    DensityDescription, EmissionDescription, FileId, GeometryDescription, GroupDescription, ImageDescription,
    InstanceDescription, LightDescription, LightKind, Location, MaterialDescription, MediumDescription,
    ShapeDescription, SphereMapping,
};
use glanz_scene::studio::{CAD_GREY, cad_material};
use glanz_scene::{Description, Scene, SceneErrorKind};

fn place(line: u32) -> Location {
    Location { file: FileId(0), line, column: 1 }
}

/// A mesh of `count` triangles.
fn mesh(count: u32) -> ShapeDescription {
    let corner = |i: u32| DVec3::new(f64::from(i), f64::from(i % 2), f64::from(i % 3));
    let geometry = GeometryDescription::Triangles {
        positions: (0..count + 2).map(corner).collect(),
        indices: (0..count).map(|i| [i, i + 1, i + 2]).collect(),
        normals: None,
        uvs: None,
    };
    ShapeDescription { location: Some(place(7)), ..geometry.into() }
}

fn scene(world: GroupDescription, groups: Vec<GroupDescription>) -> Description {
    let grey = MaterialDescription::from(cad_material(CAD_GREY, 0.0));
    Description { world, groups, materials: vec![grey], ..Description::default() }
}

fn shapes(shapes: Vec<ShapeDescription>) -> GroupDescription {
    GroupDescription { shapes, ..GroupDescription::default() }
}

/// The end of preparing within limits, and the line of its place.
fn end(
    description: Description,
    change: impl FnOnce(&mut ResourceLimits),
) -> Option<(BudgetError, Option<u32>)> {
    let mut limits = ResourceLimits::default();
    change(&mut limits);
    let budget = ResourceBudget::new(limits, CancelFlag::default());
    let error = Scene::resolve_with(description, &budget).err()?;
    match error.kind {
        SceneErrorKind::Budget(end) => Some((end, error.location.map(|location| location.line))),
        other => unreachable!("{other}"),
    }
}

fn resource(end: Option<(BudgetError, Option<u32>)>) -> Option<(Resource, Option<u32>)> {
    end.map(|(end, line)| match end {
        BudgetError::Limit(limit) => (limit.resource, line),
        other => unreachable!("{other}"),
    })
}

#[test]
fn objects_and_memory_of_shapes_are_counted() {
    let meshes = || scene(shapes((0..3).map(|_| mesh(1000)).collect()), Vec::new());
    assert_eq!(resource(end(meshes(), |limits| limits.objects = 3)), None);
    assert_eq!(resource(end(meshes(), |limits| limits.objects = 2)), Some((Resource::Objects, Some(7))));
    // A triangle has three numbers of a corner and its place in the hierarchy.
    assert_eq!(resource(end(meshes(), |limits| limits.memory = 50_000)), Some((Resource::Memory, Some(7))));
    assert_eq!(resource(end(meshes(), |limits| limits.memory = 5_000_000)), None);
}

#[test]
fn copies_of_lights_are_counted_and_other_copies_are_not() {
    let sphere = |emission| {
        let geometry =
            GeometryDescription::Sphere { radius: 1.0, z: [-1.0, 1.0], phi_max: std::f64::consts::TAU };
        ShapeDescription { emission, ..geometry.into() }
    };
    let light = || EmissionDescription::from([2.0, 1.0, 0.5]);
    let copies = |emission: Option<EmissionDescription>| {
        let instance = |i: u32| InstanceDescription {
            name: String::new(),
            group: 0,
            to_parent: DMat4::from_translation(DVec3::new(3.0 * f64::from(i), 0.0, 0.0)),
            location: Some(place(i)),
        };
        let world =
            GroupDescription { instances: (0..100).map(instance).collect(), ..GroupDescription::default() };
        scene(world, vec![shapes((0..10).map(|_| sphere(emission.clone())).collect())])
    };
    // Ten shapes and a hundred instances; of lights, ten of each instance.
    assert_eq!(resource(end(copies(None), |limits| limits.objects = 110)), None);
    assert_eq!(resource(end(copies(Some(light())), |limits| limits.objects = 1110)), None);
    let few = resource(end(copies(Some(light())), |limits| limits.objects = 10 + 11 * 50));
    assert_eq!(few, Some((Resource::Objects, Some(50))), "fifty fit");
    let memory = resource(end(copies(Some(light())), |limits| limits.memory = 100_000));
    assert_eq!(memory.map(|(resource, _)| resource), Some(Resource::Memory));
}

#[test]
fn pictures_of_lights_are_counted() {
    let pixels = Pixels::try_from_rgb(100, 100, &vec![[1.0; 3]; 10_000]).unwrap();
    let images = vec![ImageDescription::try_new("sky", &pixels).unwrap()];
    let kind = LightKind::ImageInfinite { image: 0, mapping: SphereMapping::EqualArea };
    let light = LightDescription {
        location: Some(place(3)),
        ..LightDescription::new(kind, SpectralDistribution::from(1.0_f32))
    };
    let lit = || Description {
        images: images.clone(),
        lights: vec![light.clone()],
        ..scene(shapes(vec![mesh(1)]), Vec::new())
    };
    // 40 bytes for each pixel.
    assert_eq!(resource(end(lit(), |limits| limits.memory = 300_000)), Some((Resource::Memory, Some(3))));
    assert_eq!(resource(end(lit(), |limits| limits.memory = 1_000_000)), None);
}

#[test]
fn media_materials_and_portals_are_counted() {
    let density = DensityDescription {
        resolution: [1; 3],
        values: vec![1.0].into(),
        corners: [DVec3::ZERO, DVec3::ONE],
        to_world: DMat4::IDENTITY,
    };
    let medium = MediumDescription {
        density: Some(density),
        location: Some(place(4)),
        ..MediumDescription::new(0.1_f32, 0.2_f32)
    };
    let smoke =
        || Description { media: vec![medium.clone(); 10], ..scene(shapes(vec![mesh(1)]), Vec::new()) };
    // 16 kB of bounds for each.
    assert_eq!(resource(end(smoke(), |limits| limits.memory = 150_000)), Some((Resource::Memory, Some(4))));
    assert_eq!(resource(end(smoke(), |limits| limits.memory = 400_000)), None);
    let portal = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let kind = LightKind::PortalInfinite { image: None, portal };
    let light = LightDescription {
        location: Some(place(3)),
        ..LightDescription::new(kind, SpectralDistribution::from(1.0_f32))
    };
    let lit = || Description { lights: vec![light.clone()], ..scene(shapes(vec![mesh(1)]), Vec::new()) };
    // 40 bytes for each of 128 x 128 texels.
    assert_eq!(resource(end(lit(), |limits| limits.memory = 300_000)), Some((Resource::Memory, Some(3))));
    assert_eq!(resource(end(lit(), |limits| limits.memory = 1_000_000)), None);
}

#[test]
fn time_and_flag_end_preparing() {
    let meshes = || scene(shapes(vec![mesh(10)]), Vec::new());
    // The first part is the material, which has no place.
    assert_eq!(
        resource(end(meshes(), |limits| limits.time = std::time::Duration::ZERO)),
        Some((Resource::Time, None))
    );
    let cancel = CancelFlag::default();
    cancel.cancel();
    let budget = ResourceBudget::new(ResourceLimits::default(), cancel);
    let error = Scene::resolve_with(meshes(), &budget).err().map(|error| error.kind);
    assert!(matches!(error, Some(SceneErrorKind::Budget(BudgetError::Interrupted))));
}
