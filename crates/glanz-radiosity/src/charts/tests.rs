use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;
use glanz_scene::description::*;

use super::*;
use crate::scenes::{parallelogram, scene, walls};

fn place_of(chart: &Chart, surface: &PlacedSurface<'_>, texel: DVec2) -> Option<DVec3> {
    let place = chart.place(surface, texel)?;
    Some(surface.at(place.face, place.uv, place.back)?.at.point.position)
}

fn mixed() -> Scene {
    // A tube of 12 sides without lids, a sphere and a wall.
    let n = 12;
    let rim = |i: u32, z: f64| {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        DVec3::new(angle.cos(), angle.sin(), z)
    };
    let positions = (0..n).flat_map(|i| [rim(i, 0.0), rim(i, 3.0)]).collect();
    let side = |i: u32| {
        let (a, b) = (2 * i, 2 * ((i + 1) % n));
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    let indices = (0..n).flat_map(side).collect();
    let tube = GeometryDescription::Triangles { positions, indices, normals: None, uvs: None };
    let sphere = GeometryDescription::Sphere { radius: 0.5, z: [-0.5, 0.5], phi_max: std::f64::consts::TAU };
    let wall = parallelogram(DVec3::Z * 4.0, DVec3::X * 2.0, DVec3::Y);
    scene(vec![(tube, 0.5, 0.0), (sphere, 0.5, 0.0), (wall, 0.5, 0.0)])
}

#[test]
fn every_place_of_a_surface_is_on_one_chart_of_each_side() {
    let scene = mixed();
    let surfaces = scene.placed_surfaces();
    let charts = charts(&surfaces, 7.0);
    for (number, surface) in (0..).zip(&surfaces) {
        for (face, i) in (0..surface.faces()).flat_map(|face| (0..16).map(move |i| (face, i))) {
            let uv = DVec2::new(f64::from(i % 4) + 0.3, f64::from(i / 4) + 0.4) / 8.0;
            for back in [false, true] {
                let own = charts.iter().filter(|c| c.surface == number && c.back == back);
                let found: Vec<(&Chart, DVec2)> =
                    own.filter_map(|c| Some((c, c.to_texel(face, uv)?))).collect();
                let [(chart, texel)] = found[..] else { panic!("{number} {face} {uv}: {}", found.len()) };
                let there = place_of(chart, surface, texel).unwrap();
                let expected = surface.at(face, uv, back).unwrap().at.point.position;
                assert!(there.distance(expected) < 1e-9, "{there} {expected}");
            }
        }
    }
}

#[test]
fn texels_are_as_dense_as_was_asked_everywhere() {
    let scene = mixed();
    let surfaces = scene.placed_surfaces();
    for chart in charts(&surfaces, 7.0) {
        let surface = &surfaces[chart.surface as usize];
        for (x, y) in (0..chart.size[0] - 1).flat_map(|x| (0..chart.size[1] - 1).map(move |y| (x, y))) {
            let at = |dx: f64, dy: f64| {
                place_of(&chart, surface, DVec2::new(f64::from(x) + dx, f64::from(y) + dy))
            };
            for (a, b) in [(at(0.1, 0.1), at(0.9, 0.1)), (at(0.1, 0.1), at(0.1, 0.9))] {
                if let (Some(a), Some(b)) = (a, b) {
                    assert!(a.distance(b) <= 0.8 / 7.0 * 1.001, "{} {x} {y}", chart.surface);
                }
            }
        }
    }
}

#[test]
fn a_tube_is_cut_into_few_charts_that_do_not_overlap() {
    let scene = mixed();
    let surfaces = scene.placed_surfaces();
    let number = surfaces.iter().position(|s| s.faces() == 24).unwrap();
    let flat: Vec<Chart> =
        charts(&surfaces, 7.0).into_iter().filter(|c| c.surface as usize == number && !c.back).collect();
    // Three of the twelve sides each, or what is left between two such.
    assert!((4..=8).contains(&flat.len()), "{:?}", flat.iter().map(Chart::faces).collect::<Vec<_>>());
    assert_eq!(flat.iter().map(|c| c.faces().len()).sum::<usize>(), 24);
}

#[test]
fn walls_meet_in_the_same_points() {
    // A wall in two parts, of different width: the texels at the common edge are at the same points.
    let (u, v) = (DVec3::X, DVec3::Z);
    let parts = vec![
        (parallelogram(DVec3::ZERO, u * 2.0, v), 0.5, 0.0),
        (parallelogram(u * 2.0, u * 0.7, v), 0.5, 0.0),
    ];
    let scene = scene(parts);
    let surfaces = scene.placed_surfaces();
    let charts = charts(&surfaces, 10.0);
    let (a, b) = (&charts[0], &charts[2]);
    assert_eq!((a.size, b.size), ([21, 11], [8, 11]));
    for y in 0..11 {
        let left = place_of(a, &surfaces[0], DVec2::new(20.0, f64::from(y))).unwrap();
        let right = place_of(b, &surfaces[1], DVec2::new(0.0, f64::from(y))).unwrap();
        // Each is moved inwards by a thousandth of a texel.
        assert!(left.distance(right) < 3e-3 / 10.0, "{left} {right}");
    }
}

#[test]
fn rectangles_lie_apart_and_fill_their_square() {
    let mut state = 1_u32;
    let mut random = |n: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % n
    };
    let sizes: Vec<[u32; 2]> = (0..400).map(|_| [2 + random(60), 2 + random(90)]).collect();
    for limit in [4096, 256] {
        let packed = pack(&sizes, 2, limit);
        let mut taken = vec![false; (packed.side * packed.side * packed.pages) as usize];
        let mut used = 0;
        for (slot, [width, height]) in packed.slots.iter().zip(&sizes) {
            for y in slot.corner[1] - 2..slot.corner[1] + height + 2 {
                for x in slot.corner[0] - 2..slot.corner[0] + width + 2 {
                    assert!(x < packed.side && y < packed.side);
                    let cell = ((slot.page * packed.side + y) * packed.side + x) as usize;
                    assert!(!std::mem::replace(&mut taken[cell], true));
                    used += 1;
                }
            }
        }
        assert_eq!(packed.pages > 1, limit == 256);
        assert!(limit == 256 || f64::from(used) > 0.85 * taken.len() as f64, "{used} {}", taken.len());
    }
    assert_eq!(pack(&[], 2, 64).pages, 1);
}

#[test]
fn both_sides_of_a_room_have_charts() {
    let shapes = walls(DVec3::new(3.0, 2.0, 2.5)).into_iter().map(|wall| (wall, 0.5, 0.0));
    let scene = scene(shapes.collect());
    let surfaces = scene.placed_surfaces();
    let charts = charts(&surfaces, 4.0);
    assert_eq!(charts.len(), 12);
    assert_eq!(charts.iter().filter(|chart| chart.back).count(), 6);
}
