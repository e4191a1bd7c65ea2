//! Light maps compared with closed forms, and with equations that are solved in another way.

use std::f64::consts::{PI, TAU};

use glanz_job::Silent;
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3, Frame};
use glanz_sampling::warp;
use glanz_scene::description::{GeometryDescription, LightKind, ShapeDescription};
use glanz_scene::{Interaction, ParametricPoint, Scene};

use super::tests::{BY_RADIOSITY, texels};
use super::*;
use crate::circle::vase;
use crate::elements::ElementSettings;
use crate::scenes::{scene, scene_with, walls};

const GATHER: BakeSettings =
    BakeSettings { density: 16.0, rays: 256, shadow_rays: 64, method: BakeMethod::Gather };

/// Both methods.
const METHODS: [BakeSettings; 2] = [GATHER, BakeSettings { method: BY_RADIOSITY.method, ..GATHER }];

fn baked(scene: &Scene, settings: &BakeSettings) -> Vec<LightMap> {
    let elements = Elements::new(scene, &ElementSettings { side: 0.3 }).unwrap();
    bake(&elements, settings, &mut Silent, &CancelFlag::default()).unwrap().maps
}

/// A sphere about the origin without its top, which is a share `1 - kept` of its area.
fn bowl(radius: f64, kept: f64) -> ShapeDescription {
    let z = [-radius, radius * (2.0 * kept - 1.0)];
    ShapeDescription::from(GeometryDescription::Sphere { radius, z, phi_max: TAU })
}

/// Irradiance of texels on the sides that face the z axis, with their positions.
fn inside<'a>(scene: &'a Scene, maps: &'a [LightMap]) -> Vec<(DVec3, f64)> {
    let surfaces = scene.placed_surfaces();
    let faces_axis = |chart: &Chart| {
        let surface = &surfaces[chart.surface as usize];
        let at = surface.at(chart.faces()[0], DVec2::splat(0.5), chart.back).unwrap().at;
        at.wo.truncate().dot(at.point.position.truncate()) < 0.0
    };
    texels(scene, maps).filter(|(chart, ..)| faces_axis(chart)).map(|(_, p, light)| (p, light)).collect()
}

/// Mean and largest deviation of irradiance from its expected value, relative.
fn deviations(found: impl IntoIterator<Item = (f64, f64)>) -> [f64; 2] {
    let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0.0);
    for (light, expected) in found {
        let deviation: f64 = light / expected - 1.0;
        sum += deviation;
        largest = largest.max(deviation.abs());
        count += 1.0;
    }
    assert!(count > 100.0, "{count}");
    [sum / count, largest]
}

#[test]
fn light_from_the_middle_of_a_bowl_is_even() {
    // Between any two points of a sphere the form factor is the same: E = E0 / (1 - rho f) for a share f of the sphere.
    let (radius, reflectance) = (0.5, 0.8);
    for (kept, settings) in [0.5, 0.9].into_iter().flat_map(|kept| METHODS.map(|settings| (kept, settings))) {
        let light = LightKind::Point { from: DVec3::ZERO, range: None };
        let scene = scene_with(vec![(bowl(radius, kept), reflectance as f32, 0.0)], vec![light]);
        let maps = baked(&scene, &settings);
        let expected = 1.0 / (radius * radius) / (1.0 - reflectance * kept);
        let [mean, largest] =
            deviations(inside(&scene, &maps).into_iter().map(|(_, light)| (light, expected)));
        assert!(mean.abs() < 0.01 && largest < 0.05, "{kept} {:?}: {mean} {largest}", settings.method);
    }
}

#[test]
fn light_through_the_opening_of_a_bowl_is_scattered_evenly() {
    let (radius, reflectance, kept) = (0.5, 0.8, 0.9);
    let from = DVec3::new(0.0, 0.0, 3.0);
    let scene = scene_with(
        vec![(bowl(radius, kept), reflectance as f32, 0.0)],
        vec![LightKind::Point { from, range: None }],
    );
    // The opening, a circle at z = 0.4 with radius 0.3, seen from above: all of its light lands on the bowl, below the rays through the rim.
    let rim = DVec2::new(0.3, 0.4 - from.z).normalize();
    let flux = TAU * (1.0 + rim.y);
    let along = from.z * rim.y;
    let lit_below = from.z + rim.y * (-along + (along * along - from.z * from.z + radius * radius).sqrt());
    let expected = reflectance * flux / (4.0 * PI * radius * radius) / (1.0 - reflectance * kept);
    for settings in METHODS {
        let maps = baked(&scene, &settings);
        let is_shaded = |p: &DVec3| p.z > lit_below + 0.1 && p.z < 0.38;
        let shaded = inside(&scene, &maps).into_iter().filter(|(p, _)| is_shaded(p));
        let [mean, largest] = deviations(shaded.map(|(_, light)| (light, expected)));
        assert!(mean.abs() < 0.02 && largest < 0.08, "{:?}: {mean} {largest}", settings.method);
    }
}

/// Direct irradiance at a point, of a point light of intensity 1.
fn direct_light(scene: &Scene, light: DVec3, at: &Interaction) -> f64 {
    let to = light - at.point.position;
    let cos = at.wo.dot(to.normalize());
    let is_lit = cos > 0.0 && !scene.occluded(&at.spawn_to(light, None), 1.0);
    if is_lit { cos / to.length_squared() } else { 0.0 }
}

/// Irradiance at a point of a scene with one point light of intensity 1, by paths over the hemisphere. `reflectance`: that of all surfaces.
fn traced(scene: &Scene, light: DVec3, reflectance: f64, at: &Interaction, paths: u32) -> f64 {
    // Other random numbers at every point.
    let mut random =
        at.point.position.to_array().map(f64::to_bits).into_iter().fold(0, glanz_sampling::hash::combine);
    let mut sum = 0.0;
    for _ in 0..paths {
        let (mut at, mut throughput) = (*at, 1.0);
        for _ in 0..64 {
            let [x, y] = [0, 1].map(|_| {
                random = random.wrapping_add(1);
                (glanz_sampling::hash::combine(7, random) >> 11) as f64 * 2.0_f64.powi(-53)
            });
            let direction = Frame::from_z(at.wo).to_world(warp::cosine_hemisphere(DVec2::new(x, y)));
            // A diffuse surface reflects to the side that is seen.
            let Some(hit) = scene.intersect(&at.spawn(direction), f64::INFINITY) else { break };
            at = hit;
            at.wo = if at.point.normal.dot(at.wo) < 0.0 { -at.point.normal } else { at.point.normal };
            throughput *= reflectance;
            sum += throughput * direct_light(scene, light, &at);
        }
    }
    direct_light(scene, light, at) + sum / f64::from(paths)
}

/// The number of the vase among the surfaces of [`room_with_vase`].
const VASE: u32 = 6;

/// A vase with a bottom in a closed room, under a point light of intensity 1. `reflectance`: that of all surfaces.
fn room_with_vase(light: DVec3, reflectance: f32) -> Scene {
    let mut shapes: Vec<_> = walls(DVec3::new(2.0, 2.0, 1.8))
        .into_iter()
        .map(|wall| (wall.translated(DVec3::new(-1.0, -1.0, 0.0)), reflectance, 0.0))
        .collect();
    shapes.push((vase(), reflectance, 0.0));
    shapes.push((ShapeDescription::disk(0.1).translated(DVec3::Z * 0.002), reflectance, 0.0));
    scene_with(shapes, vec![LightKind::Point { from: light, range: None }])
}

#[test]
fn inside_of_a_vase_is_as_bright_as_paths_show() {
    let (light, reflectance) = (DVec3::new(0.3, 0.1, 1.6), 0.6);
    let scene = room_with_vase(light, reflectance as f32);
    let elements = Elements::new(&scene, &ElementSettings { side: 0.3 }).unwrap();
    let vase = &elements.surfaces[VASE as usize];
    // Points below the neck, without those near the edges of the light that falls through the opening: between texels these are blurred.
    let mut points = Vec::new();
    for (face, uv) in (0..12).flat_map(|face| [(face, DVec2::new(0.3, 0.6)), (face, DVec2::new(0.7, 0.3))]) {
        for back in [false, true] {
            let at = vase.at(face, uv, back).unwrap().at;
            let is_inside = at.wo.truncate().dot(at.point.position.truncate()) < 0.0;
            let mut around =
                (0..25).map(|i| uv + 0.125 * DVec2::new(f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.0));
            let is_shaded = |uv| direct_light(&scene, light, &vase.at(face, uv, back).unwrap().at) == 0.0;
            if is_inside && at.point.position.z < 0.5 && around.all(is_shaded) {
                let expected = traced(&scene, light, f64::from(reflectance as f32), &at, 4096);
                points.push((ParametricPoint { surface: VASE, face, back, uv }, expected));
            }
        }
    }
    assert!(points.len() > 10, "{}", points.len());
    let expected: f64 = points.iter().map(|(_, expected)| expected).sum();
    for settings in METHODS.map(|settings| BakeSettings { density: 32.0, ..settings }) {
        let light = bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap();
        let maps = LightMaps::new(&elements, light.maps);
        let light = |place| f64::from(maps.irradiance(place).unwrap().luminance(&Wavelengths::default()));
        let found: f64 = points.iter().map(|(place, _)| light(place)).sum();
        let deviation = found / expected - 1.0;
        // The light that falls through the opening is as small as texels.
        assert!(deviation.abs() < 0.05, "{:?}: {deviation}", settings.method);
    }
}

#[test]
fn patches_of_a_vase_agree_on_their_common_edges() {
    let scene = room_with_vase(DVec3::new(0.3, 0.1, 1.6), 0.6);
    let elements = Elements::new(&scene, &ElementSettings { side: 0.3 }).unwrap();
    let light = bake(&elements, &GATHER, &mut Silent, &CancelFlag::default()).unwrap();
    let maps = LightMaps::new(&elements, light.maps);
    let light = |face, uv, back| {
        let place = ParametricPoint { surface: VASE, face, back, uv };
        maps.irradiance(&place).unwrap().luminance(&Wavelengths::default())
    };
    // Patches lie one above the other, three in each quarter of a turn.
    let (mut largest, mut apart, mut count) = (0.0_f32, 0, 0);
    for (face, i) in (0..12).flat_map(|face| (0..40).map(move |i| (face, i))) {
        let along = (f64::from(i) + 0.5) / 40.0;
        for back in [false, true] {
            let beside = [
                light(face, DVec2::new(1.0, along), back),
                light((face + 3) % 12, DVec2::new(0.0, along), back),
            ];
            let above = (face % 3 < 2).then(|| {
                [light(face, DVec2::new(along, 1.0), back), light(face + 1, DVec2::new(along, 0.0), back)]
            });
            for [a, b] in std::iter::once(beside).chain(above) {
                let difference = (a - b).abs() / a.max(b).max(0.05);
                largest = largest.max(difference);
                apart += i32::from(difference > 0.01);
                count += 1;
            }
        }
    }
    // A single ray that hits the light on one side only is one to four percent of the light where it is dark.
    assert!(count == 1600 && largest < 0.05 && apart < 80, "{largest} {apart}");
}

#[test]
fn box_with_light_on_things_inside_is_as_bright_as_a_room_of_six_walls() {
    // The lamp in the opening of a bowl shines into it: no light falls on the room directly.
    let size = DVec3::new(1.6, 1.4, 1.2);
    let things = || {
        let lamp = ShapeDescription::disk(0.12).rotated(DVec3::X, PI).translated(DVec3::new(0.8, 0.7, 0.29));
        let bowl = bowl(0.3, 0.5).translated(DVec3::new(0.8, 0.7, 0.3));
        vec![(bowl, 0.7, 0.0), (lamp, 0.0, 20.0)]
    };
    let room = |walls: Vec<ShapeDescription>| {
        scene(things().into_iter().chain(walls.into_iter().map(|wall| (wall, 0.7, 0.0))).collect())
    };
    let mean = |scene: &Scene, settings: &BakeSettings| {
        let maps = baked(scene, settings);
        let is_on_wall = |p: &DVec3| p.min(size - *p).min_element() < 1e-3;
        let lights: Vec<f64> =
            texels(scene, &maps).filter(|(_, p, _)| is_on_wall(p)).map(|(.., light)| light).collect();
        assert!(lights.len() > 1000, "{}", lights.len());
        lights.iter().sum::<f64>() / lights.len() as f64
    };
    let (hollow, open) = (room(vec![ShapeDescription::cuboid(DVec3::ZERO, size)]), room(walls(size)));
    // The solver finds other elements for the walls.
    for (settings, largest) in METHODS.into_iter().zip([0.03, 0.1]) {
        let settings = BakeSettings { density: 10.0, rays: 128, ..settings };
        let (found, expected) = (mean(&hollow, &settings), mean(&open, &settings));
        assert!((found / expected - 1.0).abs() < largest, "{:?}: {found} {expected}", settings.method);
    }
}

/// Irradiance at the middles of equal pieces of a tube over a disk lamp of radiance 1, in the order of height. `length`: in diameters.
///
/// The form factor from a point of the wall to a disk at a distance of x diameters is F(x) = (x^2 + 1/2) / sqrt(x^2 + 1) - x; that to a
/// piece of the wall is a difference of two of these.
fn tube(length: f64, reflectance: f64, pieces: usize) -> Vec<f64> {
    let to_disk = |x: f64| (x * x + 0.5) / (x * x + 1.0).sqrt() - x;
    let step = length / pieces as f64;
    let at = |i: usize| (i as f64 + 0.5) * step;
    let factor = |i: usize, j: usize| {
        let x = (at(i) - at(j)).abs();
        if i == j {
            2.0 * (0.5 - to_disk(0.5 * step))
        } else {
            to_disk(x - 0.5 * step) - to_disk(x + 0.5 * step)
        }
    };
    let direct: Vec<f64> = (0..pieces).map(|i| PI * to_disk(at(i))).collect();
    let mut light = direct.clone();
    for _ in 0..100 {
        let received = |i: usize| (0..pieces).map(|j| factor(i, j) * light[j]).sum::<f64>();
        light = (0..pieces).map(|i| direct[i] + reflectance * received(i)).collect();
    }
    light
}

#[test]
fn light_fades_along_a_tube() {
    let (radius, height, reflectance) = (0.15, 0.6, 0.7);
    let lamp = ShapeDescription::disk(radius);
    let scene = scene(vec![
        (ShapeDescription::cylinder(radius, [0.0, height]), reflectance as f32, 0.0),
        (lamp, 0.0, 1.0),
    ]);
    let expected = tube(height / (2.0 * radius), reflectance, 200);
    for settings in METHODS {
        let maps = baked(&scene, &BakeSettings { density: 40.0, ..settings });
        let of_wall = inside(&scene, &maps).into_iter().filter(|(p, _)| p.z > 0.03 && p.z < height - 0.01);
        let found: Vec<_> =
            of_wall.map(|(p, light)| (light, expected[(p.z / height * 200.0) as usize])).collect();
        let [mean, largest] = deviations(found);
        assert!(mean.abs() < 0.02 && largest < 0.12, "{:?}: {mean} {largest}", settings.method);
    }
}

/// Mean irradiance of the fronts of rectangles.
fn mean_irradiance(scene: &Scene, maps: &[LightMap]) -> f64 {
    let surfaces = scene.placed_surfaces();
    let (mut flux, mut all) = (0.0, 0.0);
    for map in maps.iter().filter(|map| !map.chart.back) {
        let [x, y, z] = surfaces[map.chart.surface as usize].bounds().diagonal().to_array();
        let area = x * y + y * z + z * x;
        // The outermost texels cover half of their squares, those of a corner a quarter.
        let [width, height] = map.chart.size;
        let share = |i: u32, n: u32| if i == 0 || i + 1 == n { 0.5 } else { 1.0 };
        let weight = |i: u32| share(i % width, width) * share(i / width, height);
        let light = |light: &Spectrum| f64::from(light.luminance(&Wavelengths::default()));
        let sum: f64 = (0..).zip(&map.irradiance).map(|(i, found)| weight(i) * light(found)).sum();
        flux += area * sum / (f64::from(width - 1) * f64::from(height - 1));
        all += area;
    }
    flux / all
}

#[test]
fn closed_room_that_absorbs_nothing_is_refused() {
    let light = LightKind::Point { from: DVec3::splat(0.4), range: None };
    let shapes = walls(DVec3::ONE).into_iter().map(|wall| (wall, 1.0, 0.0));
    let scene = scene_with(shapes.collect(), vec![light]);
    let elements = Elements::new(&scene, &ElementSettings { side: 0.5 }).unwrap();
    let settings = BakeSettings { density: 4.0, rays: 16, shadow_rays: 4, ..GATHER };
    let found = bake(&elements, &settings, &mut Silent, &CancelFlag::default());
    assert_eq!(found.err(), Some(BakeError::NotConverged(1000)));
}

#[test]
fn white_boxes_keep_their_light() {
    let size = DVec3::new(2.0, 1.5, 1.2);
    let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    for (reflectance, settings) in
        [0.5, 0.8, 0.9].into_iter().flat_map(|rho| METHODS.map(|settings| (rho, settings)))
    {
        let light = LightKind::Point { from: DVec3::new(0.7, 0.6, 0.8), range: None };
        let shapes = walls(size).into_iter().map(|wall| (wall, reflectance as f32, 0.0));
        let scene = scene_with(shapes.collect(), vec![light]);
        let maps = baked(&scene, &settings);
        let expected = 4.0 * PI / (area * (1.0 - reflectance));
        let deviation = mean_irradiance(&scene, &maps) / expected - 1.0;
        assert!(deviation.abs() < 0.005, "{reflectance} {:?}: {deviation}", settings.method);
    }
}
