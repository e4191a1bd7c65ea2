//! Bakes of rooms with known light, by all methods.
//!
//! One file in spite of its length: all tests share rooms, settings and their lookup of texels.

use std::f64::consts::PI;

use glanz_job::{Interrupted, Silent};
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{FloatParameter, LightKind, ShapeDescription};
use glanz_scene::{ParametricPoint, Scene};

use super::*;
use crate::elements::{ElementSettings, Patch};
use crate::form_factor::FormFactors;
use crate::scenes::{parallelogram, scene, scene_with, walls};
use crate::solve::{GaussSeidelSettings, gauss_seidel};

const COARSE: BakeSettings =
    BakeSettings { density: 6.0, rays: 256, shadow_rays: 256, method: BakeMethod::Gather };

/// The other method, with the same density and numbers of rays.
pub(super) const BY_RADIOSITY: BakeSettings = BakeSettings {
    method: BakeMethod::Radiosity { reconstruction: Interpolation::NaturalNeighbour },
    ..COARSE
};

/// Both methods.
const METHODS: [BakeSettings; 2] = [COARSE, BY_RADIOSITY];

pub(super) fn baked(scene: &Scene, side: f64, settings: &BakeSettings) -> Vec<LightMap> {
    bake(&divided(scene, side, settings), settings, &mut Silent, &CancelFlag::default()).unwrap().maps
}

fn divided<'a>(scene: &'a Scene, side: f64, settings: &BakeSettings) -> Elements<'a> {
    let mut elements = Elements::new(scene, &ElementSettings { side }).unwrap();
    elements.cut_at_walls(settings.density).unwrap();
    elements
}

/// Positions and irradiance of all texels of maps that are lit.
pub(super) fn texels<'a>(
    scene: &'a Scene,
    maps: &'a [LightMap],
) -> impl Iterator<Item = (&'a Chart, DVec3, f64)> {
    let surfaces = scene.placed_surfaces();
    let lit = maps.iter().filter(|map| !map.is_dark());
    lit.flat_map(move |map| {
        let chart = &map.chart;
        let surface = surfaces[chart.surface as usize].clone();
        let width = chart.size[0] as usize;
        map.irradiance.iter().enumerate().filter_map(move |(i, light)| {
            let place = chart.surface_point(&surface, DVec2::new((i % width) as f64, (i / width) as f64))?;
            let position = surface.at(place.face, place.uv, place.back)?.at.point.position;
            Some((chart, position, f64::from(light.luminance(&Wavelengths::default()))))
        })
    })
}

#[test]
fn furnace_is_uniform_inside_and_dark_outside() {
    let shapes = walls(DVec3::new(3.0, 2.0, 2.5)).into_iter().map(|wall| (wall, 0.5, 1.0));
    let scene = scene(shapes.collect());
    let all = Interpolation::ALL.map(|reconstruction| BakeMethod::Radiosity { reconstruction });
    for method in std::iter::once(BakeMethod::Gather).chain(all) {
        assert_furnace(&scene, &BakeSettings { method, ..COARSE });
    }
}

/// Light of a closed room whose walls reflect .5 and emit 1.
fn assert_furnace(scene: &Scene, settings: &BakeSettings) {
    let maps = baked(scene, 0.5, settings);
    assert!(maps.iter().all(|map| map.is_dark() == map.chart.back));
    let expected = PI / (1.0 - 0.5);
    let errors: Vec<f64> = texels(scene, &maps).map(|(_, _, light)| light / expected - 1.0).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let deviation = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(mean.abs() < 0.01 && deviation < 0.03, "{:?}: {mean} {deviation}", settings.method);
    // The radiance that leaves, emitted and reflected.
    let (sum, count) = maps.iter().flat_map(|map| &map.radiance).fold((0.0, 0.0), |(sum, count), light| {
        (sum + f64::from(light.luminance(&Wavelengths::default())), count + 1.0)
    });
    assert!((sum / count - 2.0).abs() < 0.03, "{}", sum / count);
}

/// Irradiance of a floor at a point.
type Law = Box<dyn Fn(DVec3) -> f64>;

#[test]
fn lights_that_are_no_surfaces_shine_by_their_laws() {
    let floor = || (parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0), 0.0, 0.0);
    let from = DVec3::new(0.7, 0.9, 1.3);
    let cases: [(LightKind, Law); 3] = [
        (
            LightKind::Point { from, range: None },
            Box::new(move |p| (from - p).z / (from - p).length().powi(3)),
        ),
        (
            LightKind::Distant { from: DVec3::new(1.0, 0.0, 1.0), to: DVec3::ZERO },
            Box::new(|_| 0.5_f64.sqrt()),
        ),
        (LightKind::Infinite, Box::new(|_| PI)),
    ];
    for ((kind, expected), settings) in cases.iter().flat_map(|case| METHODS.map(|settings| (case, settings)))
    {
        let scene = scene_with(vec![floor()], vec![kind.clone()]);
        let maps = baked(&scene, 1.0, &settings);
        let mut count = 0;
        for (chart, position, light) in texels(&scene, &maps).filter(|(chart, ..)| !chart.back) {
            let expected = expected(position);
            // Places around the middle of a texel of 1/6 m.
            assert!((light / expected - 1.0).abs() < 0.02, "{kind:?} {position} {light} {expected}");
            count += usize::from(chart.size == [13, 13]);
        }
        assert_eq!(count, 169);
    }
}

#[test]
fn no_light_comes_through_a_wall() {
    // Two rooms, whose floors and ceilings end at the wall of 1 cm between them; a lamp in one of them.
    let room = |x: f64, size: DVec3| {
        walls(size).into_iter().map(move |wall| (wall.translated(DVec3::X * x), 0.7, 0.0))
    };
    let size = DVec3::new(2.0, 2.0, 2.0);
    let mut shapes: Vec<_> = room(0.0, size).chain(room(2.01, size)).collect();
    shapes.push((parallelogram(DVec3::new(0.5, 0.5, 1.9), DVec3::Y, DVec3::X), 0.0, 1.0));
    let scene = scene(shapes);
    for settings in METHODS {
        let maps = baked(&scene, 0.5, &settings);
        let mut lit = 0;
        for (_, position, light) in texels(&scene, &maps) {
            assert!(position.x < 2.005 && light > 0.0, "{position} {light}");
            lit += 1;
        }
        assert!(lit > 500);
        // Of twelve walls and the lamp six and the lamp are lit on one side.
        assert_eq!(maps.iter().filter(|map| !map.is_dark()).count(), 8);
    }
}

/// A room of 4 m x 2 m x 2 m in six pieces with a lamp, and a wall of 1 cm on its floor from (`x`, 0) towards (`end`, 2), of which
/// a share `length` is built.
fn parted_room(x: f64, end: f64, length: f64) -> Scene {
    let mut shapes: Vec<_> = walls(DVec3::new(4.0, 2.0, 2.0)).into_iter().map(|w| (w, 0.7, 0.0)).collect();
    let way = DVec3::new(end - x, 2.0, 0.0);
    let across = 0.01 * DVec3::new(way.y, -way.x, 0.0).normalize();
    // It begins a little outside, so that no slanted one leaves a gap.
    let (u, v) = ((length + 0.02) * way, DVec3::Z * 2.0);
    let from = DVec3::X * x - 0.01 * way;
    shapes.push((parallelogram(from, v, u), 0.7, 0.0));
    shapes.push((parallelogram(from + across, u, v), 0.7, 0.0));
    if length < 1.0 {
        shapes.push((parallelogram(from + u, v, across), 0.7, 0.0));
    }
    shapes.push((parallelogram(DVec3::new(0.5, 0.5, 1.9), DVec3::Y, DVec3::X), 0.0, 1.0));
    scene(shapes)
}

#[test]
fn no_light_comes_beneath_a_thin_wall_on_a_floor_in_one_piece() {
    let rooms = [(2.1, 2.1), (1.9, 2.4)];
    for ((x, end), settings) in rooms.into_iter().flat_map(|room| METHODS.map(|settings| (room, settings))) {
        let scene = parted_room(x, end, 1.0);
        let elements = divided(&scene, 0.5, &settings);
        let light = bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap();
        let maps = LightMaps::new(&elements, light.maps);
        let (mut dark, mut lit) = (0, 0);
        for (surface, i) in (0..6).flat_map(|surface| (0..400).map(move |i| (surface, i))) {
            let uv = DVec2::new(f64::from(i % 20) + 0.5, f64::from(i / 20) + 0.5) / 20.0;
            // One of the two sides is outside.
            for back in [false, true] {
                let at = elements.surfaces[surface].at(0, uv, back).unwrap().at;
                let p = at.point.position + 1e-6 * at.wo;
                if p.cmplt(DVec3::ZERO).any() || p.cmpgt(DVec3::new(4.0, 2.0, 2.0)).any() {
                    continue;
                }
                let place = ParametricPoint { surface: surface as u32, face: 0, uv, back };
                let light = maps.irradiance(&place).unwrap().luminance(&Wavelengths::default());
                let beyond = (p.x - (x + (end - x) * p.y / 2.0)) / (1.0 + (0.5 * (end - x)).powi(2)).sqrt();
                if beyond > 0.01 {
                    assert!(light < 1e-7, "{x} {end} {:?} {p} {light}", settings.method);
                    dark += 1;
                } else if beyond < 0.0 {
                    assert!(light > 0.005, "{p} {light}");
                    lit += 1;
                }
            }
        }
        assert!(dark > 700 && lit > 700, "{dark} {lit}");
    }
}

/// A room of 1.2 m x 0.6 m x 0.6 m in six pieces with a lamp in its left half, and a wall from x = 0.63 in the middle.
fn room_with_wall(thickness: f64, is_solid: bool) -> Scene {
    let size = DVec3::new(1.2, 0.6, 0.6);
    let mut shapes: Vec<_> = walls(size).into_iter().map(|wall| (wall, 0.7, 0.0)).collect();
    let (from, v, w) = (DVec3::X * 0.63, DVec3::Y * size.y, DVec3::Z * size.z);
    if is_solid {
        shapes.push((ShapeDescription::cuboid(from, from + DVec3::X * thickness + v + w), 0.7, 0.0));
    } else {
        shapes.push((parallelogram(from, w, v), 0.7, 0.0));
        shapes.push((parallelogram(from + DVec3::X * thickness, v, w), 0.7, 0.0));
    }
    shapes.push((parallelogram(DVec3::new(0.2, 0.2, 0.55), DVec3::Y * 0.2, DVec3::X * 0.2), 0.0, 1.0));
    scene(shapes)
}

/// Largest irradiance that is shown behind the wall of a room, relative to the mean in front of it, in 2601 points of each piece of the room.
fn leak(scene: &Scene, settings: &BakeSettings, thickness: f64) -> f64 {
    let elements = divided(scene, 0.3, settings);
    let light = bake(&elements, settings, &mut Silent, &CancelFlag::default()).unwrap();
    let maps = LightMaps::new(&elements, light.maps);
    let (mut dark, mut lit, mut count) = (0.0_f64, 0.0, 0.0);
    for (surface, i) in (0..6).flat_map(|surface| (0..51 * 51).map(move |i| (surface, i))) {
        let uv = DVec2::new(f64::from(i % 51), f64::from(i / 51)) / 50.0;
        let place = ParametricPoint { surface: surface as u32, face: 0, uv, back: false };
        let p = elements.surfaces[surface].at(0, uv, false).unwrap().at.point.position;
        let light = f64::from(maps.irradiance(&place).unwrap().luminance(&Wavelengths::default()));
        if p.x > 0.63 + thickness {
            dark = dark.max(light);
        } else if p.x < 0.63 {
            (lit, count) = (lit + light, count + 1.0);
        }
    }
    // Points right behind the wall, too.
    for (surface, i) in [2, 3, 4, 5].into_iter().flat_map(|surface| (0..200).map(move |i| (surface, i))) {
        let (x, along) = ((0.63 + thickness + 1e-5) / 1.2, (f64::from(i) + 0.5) / 200.0);
        for uv in [DVec2::new(x, along), DVec2::new(along, x)] {
            let p = elements.surfaces[surface].at(0, uv, false).unwrap().at.point.position;
            if p.x > 0.63 + thickness {
                let place = ParametricPoint { surface: surface as u32, face: 0, uv, back: false };
                dark =
                    dark.max(f64::from(maps.irradiance(&place).unwrap().luminance(&Wavelengths::default())));
            }
        }
    }
    dark / (lit / count)
}

fn assert_no_leak(density: f64, thickness: f64, is_solid: bool) {
    let scene = room_with_wall(thickness, is_solid);
    for settings in METHODS {
        let settings = BakeSettings { density, rays: 32, shadow_rays: 16, ..settings };
        let leak = leak(&scene, &settings, thickness);
        assert!(leak == 0.0, "{density} {thickness} {is_solid} {:?}: {leak}", settings.method);
    }
}

#[test]
fn no_light_leaks_beneath_walls_of_any_thickness_at_any_density() {
    let walls = [(0.01, false), (0.01, true), (0.05, false), (0.05, true)];
    for (density, &(thickness, is_solid)) in
        [4.0, 16.0, 64.0].into_iter().flat_map(|density| walls.iter().map(move |wall| (density, wall)))
    {
        assert_no_leak(density, thickness, is_solid);
    }
}

#[test]
fn thin_slab_on_a_floor_does_not_darken_it() {
    // Under an even sky, a slab so thin that it takes no light away.
    let floor = parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0);
    let slab = ShapeDescription::cuboid(DVec3::new(0.53, 0.61, 0.0), DVec3::new(1.37, 1.43, 0.001));
    let scene = scene_with(vec![(floor, 0.5, 0.0), (slab, 0.5, 0.0)], vec![LightKind::Infinite]);
    for settings in METHODS {
        let maps = baked(&scene, 0.5, &settings);
        let map = maps.iter().find(|map| map.chart.size == [13, 13] && !map.chart.back);
        let lights: Vec<f32> =
            map.unwrap().irradiance.iter().map(|l| l.luminance(&Wavelengths::default())).collect();
        let (low, high) = lights.iter().fold((f32::INFINITY, 0.0_f32), |(l, h), &x| (l.min(x), h.max(x)));
        // Texels beneath are filled from those around.
        assert!(low > 0.9 * high, "{low} {high}");
    }
}

#[test]
fn charts_that_meet_agree_on_the_edge() {
    // A floor in two parts beside a box, under a lamp: shadow and light from the box cross the edge.
    let shapes = vec![
        (parallelogram(DVec3::ZERO, DVec3::X * 1.3, DVec3::Y * 2.0), 0.6, 0.0),
        (parallelogram(DVec3::X * 1.3, DVec3::X * 0.9, DVec3::Y * 2.0), 0.6, 0.0),
        (ShapeDescription::cuboid(DVec3::new(0.9, 0.8, 0.0), DVec3::new(1.6, 1.2, 0.7)), 0.8, 0.0),
        (parallelogram(DVec3::new(0.2, 0.1, 2.0), DVec3::Y * 0.6, DVec3::X * 0.6), 0.0, 5.0),
    ];
    let scene = scene(shapes);
    let maps = baked(&scene, 0.4, &BakeSettings { density: 20.0, ..COARSE });
    let surfaces = scene.placed_surfaces();
    let of = |surface: &str, x: f64| {
        let number = surfaces.iter().position(|s| {
            s.surface().kind() == surface
                && s.at(0, DVec2::splat(0.5), false)
                    .is_some_and(|at| (at.at.point.position.x - x).abs() < 1e-9)
        });
        maps.iter().find(|map| Some(map.chart.surface as usize) == number && !map.is_dark()).unwrap()
    };
    let (left, right) = (of("bilinearmesh", 0.65), of("bilinearmesh", 1.75));
    let column = |map: &LightMap, x: u32| -> Vec<f32> {
        let [width, height] = map.chart.size;
        (0..height)
            .map(|y| map.irradiance[(y * width + x) as usize].luminance(&Wavelengths::default()))
            .collect()
    };
    let (a, b) = (column(left, left.chart.size[0] - 1), column(right, 0));
    assert_eq!(a.len(), b.len());
    let brightest = a.iter().fold(0.0_f32, |most, &x| most.max(x));
    let step = 2.0 / (a.len() - 1) as f64;
    for (row, (a, b)) in a.iter().zip(&b).enumerate() {
        // Beneath the box is no light: texels there are filled from around, on each chart by itself.
        let y = row as f64 * step;
        let is_beneath = y > 0.8 + 1e-9 && y < 1.2 - 1e-9;
        assert!(is_beneath || (a - b).abs() < 0.01 * a.max(0.01 * brightest), "{y}: {a} {b}");
    }
}

#[test]
fn light_of_elements_agrees_with_their_form_factors() {
    let mut shapes: Vec<_> =
        walls(DVec3::new(2.0, 2.0, 2.0)).into_iter().map(|wall| (wall, 0.6, 0.0)).collect();
    shapes.push((parallelogram(DVec3::new(0.8, 0.7, 1.9), DVec3::Y * 0.5, DVec3::X * 0.5), 0.3, 10.0));
    let scene = scene(shapes);
    let elements = Elements::new(&scene, &ElementSettings { side: 0.2 }).unwrap();
    let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
    let solved =
        gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &CancelFlag::default())
            .unwrap();
    for settings in METHODS {
        let light = bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap();
        let maps = LightMaps::new(&elements, light.maps);
        let (mut sum, mut difference) = (0.0, 0.0);
        for (element, radiosity) in elements.list.iter().zip(&solved.radiosity) {
            let Patch { surface, face, back, domain: part } = element.patch;
            let place = ParametricPoint { surface, face, back, uv: part.center() };
            let received = (*radiosity - element.emission) * (1.0 / element.reflectance.max_component());
            let light = maps.irradiance(&place).unwrap_or(Spectrum::BLACK);
            sum += received.max_component();
            difference += (light - received).max_component().abs();
        }
        assert!(difference / sum < 0.03, "{:?}: {}", settings.method, difference / sum);
    }
}

#[test]
fn radiosity_agrees_with_the_gather_in_a_furnished_room() {
    let mut shapes: Vec<_> =
        walls(DVec3::new(3.0, 2.5, 2.0)).into_iter().map(|wall| (wall, 0.6, 0.0)).collect();
    shapes.push((parallelogram(DVec3::new(0.8, 0.7, 1.9), DVec3::Y * 0.5, DVec3::X * 0.5), 0.3, 10.0));
    shapes.push((ShapeDescription::cuboid(DVec3::new(1.6, 1.2, 0.0), DVec3::new(2.2, 2.0, 0.7)), 0.5, 0.0));
    shapes.push((ShapeDescription::sphere(0.3).translated(DVec3::new(0.8, 1.6, 0.5)), 0.5, 0.0));
    let scene = scene(shapes);
    let [gathered, solved] =
        METHODS.map(|settings| baked(&scene, 0.3, &BakeSettings { density: 16.0, ..settings }));
    let (mut sums, mut errors) = ([0.0; 2], 0.0);
    let (gathered, solved): (Vec<_>, Vec<_>) = gathered
        .into_iter()
        .zip(solved)
        // Sides of objects on the floor that receive almost no light may be dark for one method only.
        .filter(|(a, b)| !a.is_dark() && !b.is_dark())
        .unzip();
    for ((_, p, a), (_, q, b)) in texels(&scene, &gathered).zip(texels(&scene, &solved)) {
        assert_eq!(p, q);
        sums = [sums[0] + a, sums[1] + b];
        errors += (b - a).abs();
    }
    let (bias, error) = (sums[1] / sums[0] - 1.0, errors / sums[0]);
    assert!(bias.abs() < 0.01 && error < 0.02, "{bias} {error}");
}

#[test]
fn pages_repeat_the_borders_of_charts() {
    let scene = scene_with(
        vec![(parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y), 0.5, 0.0)],
        vec![LightKind::Point { from: DVec3::new(0.2, 0.4, 0.7), range: None }],
    );
    let maps = baked(&scene, 1.0, &COARSE);
    let atlas = Atlas::new(&maps);
    let (map, slot) = maps.iter().zip(&atlas.slots).find_map(|(m, s)| Some((m, (*s)?))).unwrap();
    assert_eq!(atlas.slots.iter().filter(|slot| slot.is_none()).count(), 1);
    let [width, height] = map.chart.size;
    let texel = |x: u32, y: u32| atlas.pages[slot.page as usize].irradiance[(y * atlas.side + x) as usize];
    let own = |x: u32, y: u32| map.irradiance[(y * width + x) as usize];
    for border in 1..=BORDER {
        assert_eq!(texel(slot.corner[0] - border, slot.corner[1] - border), own(0, 0));
        assert_eq!(texel(slot.corner[0] + width - 1 + border, slot.corner[1] + 2), own(width - 1, 2));
    }
    // The middle of the last texel of the chart.
    let last = DVec2::new(f64::from(width) - 1.0, f64::from(height) - 1.0);
    let place = atlas.coordinates(&slot, last) * f64::from(atlas.side) - 0.5;
    let [x, y] = place.to_array().map(|n| n.round() as u32);
    assert_eq!(texel(x, y), own(width - 1, height - 1));
}

#[test]
fn invalid_density_is_refused_and_a_bake_can_be_cancelled() {
    let scene = scene(vec![(parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 0.5, 1.0)]);
    let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
    let run = |density: f64, cancel: &CancelFlag| {
        bake(&elements, &BakeSettings { density, ..COARSE }, &mut Silent, cancel).map(|_| ())
    };
    let (open, cancelled) = (CancelFlag::default(), CancelFlag::default());
    cancelled.cancel();
    assert_eq!(run(0.0, &open), Err(BakeError::Density(0.0)));
    assert_eq!(run(1.0, &cancelled), Err(BakeError::Interrupted(Interrupted)));
    assert_eq!(run(1.0, &open), Ok(()));
}

#[test]
fn too_many_links_between_elements_are_refused() {
    let scene = scene(walls(DVec3::ONE).into_iter().map(|wall| (wall, 0.5, 1.0)).collect());
    let elements = Elements::new(&scene, &ElementSettings { side: 0.5 }).unwrap();
    let charts = charts(&elements.surfaces, COARSE.density);
    let (mut sink, cancel) = (Silent, CancelFlag::default());
    let mut progress = BakeProgress::new(&mut sink, &cancel, 3);
    let mut state = BakeState::default();
    let direct =
        direct::light_on_charts(&elements, &charts, &COARSE, None, &mut state, &mut progress).unwrap();
    let index = SurfaceIndex::new(&elements, &charts);
    let gather = FinalGather::new(&elements, &index, &charts, &direct, &COARSE);
    let rows = gather.rows(usize::MAX, &mut progress).unwrap();
    let links: usize = rows.iter().map(|row| row.links.len()).sum();
    // The elements of each wall exchange light with those of the five others.
    assert!(links > 24 * 10, "{links}");
    assert!(gather.rows(links, &mut progress).is_ok());
    assert_eq!(gather.rows(links - 1, &mut progress).err(), Some(BakeError::Memory(elements.list.len())));
}

/// Tests of the nightly run.
mod heavy {
    use super::*;

    #[test]
    fn no_light_leaks_beneath_walls_of_several_texels() {
        for (density, is_solid) in
            [120.0, 250.0, 400.0].into_iter().flat_map(|density| [(density, false), (density, true)])
        {
            assert_no_leak(density, 0.01, is_solid);
        }
    }

    #[test]
    fn parts_of_a_chart_agree_where_the_wall_has_ended() {
        let scene = parted_room(2.1, 2.1, 0.59);
        let settings = BakeSettings { density: 20.0, ..COARSE };
        let elements = divided(&scene, 0.5, &settings);
        let maps = LightMaps::new(
            &elements,
            bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap().maps,
        );
        assert_eq!(maps.as_slice().iter().filter(|map| map.chart.surface == 4 && !map.is_dark()).count(), 2);
        let light = |x: f64, y: f64| {
            // The floor is over y and x.
            let uv = DVec2::new(x / 4.0, y / 2.0);
            let back = elements.surfaces[4].at(0, uv, false).unwrap().at.wo.z < 0.0;
            let place = ParametricPoint { surface: 4, face: 0, uv, back };
            maps.irradiance(&place).unwrap().luminance(&Wavelengths::default())
        };
        for i in 0..70 {
            let y = 1.27 + 0.01 * f64::from(i);
            let (left, right) = (light(2.105 - 1e-7, y), light(2.105 + 1e-7, y));
            assert!((left - right).abs() < 0.002 * left, "{y}: {left} {right}");
        }
        // Along the wall they do not.
        assert!(light(2.09, 0.8) > 2.0 * light(2.12, 0.8), "{} {}", light(2.09, 0.8), light(2.12, 0.8));
    }
}

#[test]
fn lights_of_no_opacity_near_a_surface_shine_in_full() {
    // A square under a lamp of its size at half of its side.
    let mean = |side: u32, opacity: f32| {
        let piece = 1.0 / f64::from(side);
        let floor = parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y);
        let lamps = (0..side * side).map(|i| {
            let corner = DVec3::new(f64::from(i % side), f64::from(i / side), 0.0) * piece + 0.5 * DVec3::Z;
            let lamp = parallelogram(corner, DVec3::Y * piece, DVec3::X * piece);
            (lamp.with_alpha(FloatParameter::Value(opacity)), 0.0, 1.0)
        });
        let scene = scene(std::iter::once((floor, 0.0, 0.0)).chain(lamps).collect());
        let maps = baked(&scene, 0.5, &COARSE);
        let light: Vec<f64> = texels(&scene, &maps)
            .filter(|(chart, ..)| chart.surface == 0 && !chart.back)
            .map(|(.., light)| light)
            .collect();
        light.iter().sum::<f64>() / light.len() as f64
    };
    let expected = mean(1, 1.0);
    // More lamps than are sampled one by one, too.
    for side in [1, 9] {
        let found = mean(side, 0.0);
        assert!((found / expected - 1.0).abs() < 0.05, "{side}: {found} {expected}");
    }
}
