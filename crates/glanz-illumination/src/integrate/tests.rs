//! Illuminance by way of mirrors beside closed forms.

use std::f64::consts::{PI, TAU};

use glanz_light::SpectralDistribution;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_math::DMat4;
use glanz_scene::description::*;

use super::*;

const BLACK: usize = 0;
const MIRROR: usize = 1;
/// Of the mirrors.
const REFLECTANCE: f64 = 0.75;
/// cd/m^2 of a lamp of radiance 1.
const LUMINANCE: f64 = LUMINOUS_EFFICACY;

const EXACT: Tolerance = Tolerance { relative: 1e-7, absolute: 0.0 };

fn shape(geometry: GeometryDescription, to_parent: DMat4, material: usize) -> ShapeDescription {
    ShapeDescription {
        geometry,
        to_parent,
        reverse_orientation: false,
        material,
        emission: None,
        trim: None,
        receiver: None,
        location: None,
    }
}

fn lamp(geometry: GeometryDescription, to_parent: DMat4) -> ShapeDescription {
    let radiance = SpectralDistribution::Constant(1.0);
    let emission = EmissionDescription { radiance, scale: 1.0, power: None, two_sided: false };
    ShapeDescription { emission: Some(emission), ..shape(geometry, to_parent, BLACK) }
}

fn scene(shapes: Vec<ShapeDescription>) -> Scene {
    scene_with(shapes, Vec::new())
}

fn scene_with(shapes: Vec<ShapeDescription>, lights: Vec<LightDescription>) -> Scene {
    let constant = |value: f64| SpectrumInput::Value(SpectralDistribution::Constant(value as f32));
    let materials = [
        MaterialKind::Diffuse { reflectance: constant(0.0) },
        MaterialKind::Mirror { reflectance: constant(REFLECTANCE) },
    ];
    let materials = materials.map(|kind| MaterialDescription { name: String::new(), kind, location: None });
    let mut description = Description { materials: materials.into(), lights, ..Description::default() };
    description.world.shapes = shapes;
    Scene::resolve(description).unwrap().0
}

fn at(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

fn sphere(radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { radius, z: [-radius, radius], phi_max: TAU }
}

fn disk(radius: f64) -> GeometryDescription {
    GeometryDescription::Disk { height: 0.0, radius, inner_radius: 0.0, phi_max: TAU }
}

fn rectangle(x: [f64; 2], y: [f64; 2]) -> GeometryDescription {
    GeometryDescription::Plane { x, y }
}

fn facing_down() -> DMat4 {
    DMat4::from_rotation_x(PI)
}

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(
        off <= relative * expected.abs(),
        "{what}: {found} instead of {expected}, {:.1e}",
        off / expected
    );
}

/// Illuminance of a sphere of which all is above the horizon: L pi (R / d)^2 cos.
fn by_sphere(center: DVec3, radius: f64, point: DVec3, normal: DVec3) -> f64 {
    let to = center - point;
    LUMINANCE * PI * radius * radius / to.length_squared() * normal.dot(to.normalize())
}

/// Of a disk parallel to the receiver at height h, with its axis at distance a (@howell2011, factor B-13 of an element beside a disk).
fn by_disk(h: f64, a: f64, radius: f64) -> f64 {
    let (h2, a2, r2) = (h * h, a * a, radius * radius);
    let root = ((h2 + a2 + r2).powi(2) - 4.0 * a2 * r2).sqrt();
    LUMINANCE * PI * 0.5 * (1.0 - (h2 + a2 - r2) / root)
}

/// Of a rectangle parallel to the receiver at height 1, from the foot of the receiver's normal to (x, y) (@howell2011, factor B-3).
fn by_corner(x: f64, y: f64) -> f64 {
    let (u, v) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    LUMINANCE * 0.5 * (x / u * (y / u).atan() + y / v * (x / v).atan())
}

fn by_rectangle(h: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let corner = |x: f64, y: f64| by_corner(x / h, y / h);
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// The plane z = 0 as a mirror from -2 m to 2 m, as surfaces of several kinds.
fn flat_mirrors() -> Vec<(&'static str, ShapeDescription)> {
    let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let mesh = GeometryDescription::Triangles {
        positions: corners.to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uvs: None,
    };
    // Bent in its parameters, but flat.
    let patch = BezierPatchesDescription {
        degree_u: 2,
        degree_v: 1,
        patches: vec![[-2.0, 0.5, 2.0].iter().flat_map(|&x| [-2.0, 2.0].map(|y| [x, y, 0.0, 1.0])).collect()],
    };
    let lid =
        GeometryDescription::Cuboid { min: DVec3::new(-2.0, -2.0, -1.0), max: DVec3::new(2.0, 2.0, 0.0) };
    vec![
        ("plane", shape(rectangle([-2.0, 2.0], [-2.0, 2.0]), DMat4::IDENTITY, MIRROR)),
        ("mesh", shape(mesh, DMat4::IDENTITY, MIRROR)),
        ("patch", shape(GeometryDescription::BezierPatches(patch), DMat4::IDENTITY, MIRROR)),
        ("disk", shape(disk(2.5), DMat4::IDENTITY, MIRROR)),
        ("box", shape(lid, DMat4::IDENTITY, MIRROR)),
    ]
}

#[test]
fn flat_mirror_shows_a_lamp_at_its_image() {
    // Receivers at z = 1 look down, so that they see the lamps at z = 1.5 by way of the mirror alone: as if they were at z = -1.5.
    let lamps = [
        ("sphere", lamp(sphere(0.1), at(0.3, 0.2, 1.5))),
        ("disk", lamp(disk(0.2), at(0.3, 0.2, 1.5) * facing_down())),
        ("rectangle", lamp(rectangle([-0.3, 0.3], [-0.05, 0.05]), at(0.3, 0.2, 1.5) * facing_down())),
    ];
    for (kind, lamp) in lamps {
        for (mirror, shape) in flat_mirrors() {
            let scene = scene(vec![lamp.clone(), shape]);
            let reflections = Reflections::new(&scene).unwrap();
            for (x, y) in [(0.31, 0.22), (-0.7, 0.4), (1.1, -0.9)] {
                let point = DVec3::new(x, y, 1.0);
                let image = DVec3::new(0.3, 0.2, -1.5);
                let expected = match kind {
                    "sphere" => by_sphere(image, 0.1, point, -DVec3::Z),
                    "disk" => by_disk(2.5, (x - 0.3).hypot(y - 0.2), 0.2),
                    _ => by_rectangle(2.5, [-x, 0.6 - x], [0.15 - y, 0.25 - y]),
                };
                let found = reflections.illuminance(point, -DVec3::Z, EXACT);
                let expected = REFLECTANCE * expected;
                let what = format!("{kind} in a {mirror} from ({x}, {y}): {found:?}");
                assert_eq!(found.direct, 0.0, "{what}");
                close(found.reflected, expected, 1e-6, &what);
                let off = (found.reflected - expected).abs();
                // Spectra have seven digits.
                assert!(off <= found.error + 3e-7 * expected && found.error <= 1e-6 * expected, "{what}");
            }
        }
    }
}
