//! Receivers and the rays that hit them.

use glanz_math::{DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder, SceneErrorKind};

const HERE: Location = Location { file: FileId(0), line: 4, column: 2 };

fn receiver(name: &str, cells: Option<[u32; 2]>) -> ReceiverDescription {
    ReceiverDescription {
        name: name.into(),
        cells,
        side: ReceiverSide::Both,
        zone: None,
        location: Some(HERE),
    }
}

fn shape(shape: ShapeDescription, x: f64, receiver: Option<ReceiverDescription>) -> ShapeDescription {
    ShapeDescription { receiver, ..shape.translated([x, 0.0, 0.0]) }
}

fn triangle() -> ShapeDescription {
    ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]])
}

fn disk() -> ShapeDescription {
    ShapeDescription::disk(1.0)
}

fn with(material: MaterialKind, shapes: Vec<ShapeDescription>) -> SceneBuilder {
    SceneBuilder::new().shapes(shapes, material)
}

fn grey() -> MaterialKind {
    MaterialKind::diffuse(0.5)
}

/// The number of the shape that a ray downwards at x hits.
fn met(scene: &Scene, x: f64) -> u32 {
    scene.intersect(&Ray::new(DVec3::new(x, 0.25, 1.0), -DVec3::Z), 2.0).unwrap().id
}

#[test]
fn rays_hit_receivers_by_their_shape_also_in_joined_meshes_and_behind_groups() {
    let shapes = vec![
        shape(triangle(), 10.0, None),
        shape(triangle(), 20.0, Some(receiver("wall", Some([3, 4])))),
        shape(disk(), 30.0, Some(receiver("desk", None))),
        shape(triangle(), 40.0, Some(receiver("wall", None))),
    ];
    let inner = |group: SceneBuilder| group.shape(triangle(), grey());
    let (scene, warnings) = with(grey(), shapes).group("triangle", inner).resolve().unwrap();
    assert!(warnings.is_empty());
    let [first, desk, last] = scene.receivers() else { panic!("{:?}", scene.receivers()) };
    assert_eq!([first.name(), desk.name(), last.name()], ["wall", "desk", "wall"]);
    // The three meshes of the world are one surface.
    assert_eq!(scene.placed_surfaces().len(), 2);
    assert_eq!([20.25, 30.0, 40.25].map(|x| met(&scene, x)), [first.shape(), desk.shape(), last.shape()]);
    assert!(scene.receivers().iter().all(|r| r.shape() != met(&scene, 10.25)));
    assert_eq!(
        (first.cells(), first.side(), first.location()),
        (Some([3, 4]), ReceiverSide::Both, Some(HERE))
    );
}

#[test]
fn an_interface_that_measures_light_is_hit_and_does_not_occlude() {
    let shapes = vec![shape(disk(), 0.0, Some(receiver("plane", None))), shape(disk(), 5.0, None)];
    let (scene, _) = with(MaterialKind::Interface, shapes).resolve().unwrap();
    let ray = Ray::new(DVec3::Z, -DVec3::Z);
    assert_eq!(scene.intersect(&ray, 2.0).unwrap().id, scene.receivers()[0].shape());
    assert!(!scene.occluded(&ray, 2.0));
    assert!(scene.intersect(&Ray::new(DVec3::new(5.0, 0.0, 1.0), -DVec3::Z), 2.0).is_none());
}

#[test]
fn a_mesh_without_area_measures_nothing() {
    let flat = ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X, DVec3::X], vec![[0, 1, 2]]);
    let (scene, warnings) = with(grey(), vec![flat.receiver("none")]).resolve().unwrap();
    assert!(scene.receivers().is_empty() && warnings.len() == 1);
}

#[test]
fn invalid_receivers_are_reported_with_their_location() {
    for cells in [[0, 1], [1, 0], [4097, 1], [1, 4097]] {
        let shapes = vec![shape(disk(), 0.0, Some(receiver("a", Some(cells))))];
        let error = with(grey(), shapes).resolve().unwrap_err();
        assert_eq!(error.location, Some(HERE));
        assert!(error.to_string().contains("it must be 1 to 4096"), "{error}");
    }
    let named = shape(disk(), 0.0, Some(receiver("", None)));
    assert!(with(grey(), vec![named]).resolve().is_err());
    let inner = |group: SceneBuilder| group.shape(shape(disk(), 0.0, Some(receiver("a", None))), grey());
    let error = SceneBuilder::new().group("disk", inner).resolve().unwrap_err();
    assert_eq!(error.location, Some(HERE));
    assert!(matches!(error.kind, SceneErrorKind::ReceiverInGroup(name) if name == "a"));
    let translucent = shape(disk(), 0.0, Some(receiver("a", None))).with_alpha(FloatParameter::Value(0.5));
    let error = with(grey(), vec![translucent]).resolve().unwrap_err();
    assert_eq!(error.location, Some(HERE));
    assert!(error.to_string().contains("receiver: opacity is not 1"), "{error}");
}
