use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;
use glanz_scene::description::*;

use super::*;
use crate::circle::vase;
use crate::elements::{ElementSettings, Elements};
use crate::scenes::{parallelogram, scene, walls};

fn place_of(chart: &Chart, surface: &PlacedSurface<'_>, texel: DVec2) -> Option<DVec3> {
    let place = chart.surface_point(surface, texel)?;
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
    let tube = ShapeDescription::mesh(positions, indices);
    let sphere = ShapeDescription::sphere(0.5);
    let wall = parallelogram(DVec3::Z * 4.0, DVec3::X * 2.0, DVec3::Y);
    scene(vec![(tube, 0.5, 0.0), (sphere, 0.5, 0.0), (wall, 0.5, 0.0)])
}

#[test]
fn every_point_of_a_surface_is_on_one_chart_of_each_side() {
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
fn texels_have_the_requested_density_everywhere() {
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
    assert_eq!(pack(&[], 0, 3).side, 3);
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

/// A floor of 4 m x 3 m with walls of 1 cm on it: a box, a slanted sheet in two triangles, and a box that is too thick to part texels.
fn walls_on_a_floor() -> Scene {
    let floor = parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 3.0);
    let thin = ShapeDescription::cuboid(DVec3::new(1.5, 0.0, 0.0), DVec3::new(1.51, 2.0, 2.0));
    let thick = ShapeDescription::cuboid(DVec3::new(3.0, 2.0, 0.0), DVec3::new(4.0, 3.0, 2.0));
    let corners = [DVec3::new(2.0, 0.5, 0.0), DVec3::new(3.4, 1.9, 0.0)];
    let sheet = ShapeDescription::mesh(
        vec![corners[0], corners[1], corners[1] + DVec3::Z, corners[0] + DVec3::Z],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    scene([floor, thin, thick, sheet].map(|shape| (shape, 0.5, 0.0)).into())
}

#[test]
fn thin_walls_divide_the_charts_that_they_stand_on() {
    let scene = walls_on_a_floor();
    let surfaces = scene.placed_surfaces();
    let all = charts(&surfaces, 10.0);
    let floor: Vec<&Chart> = all.iter().filter(|chart| chart.surface == 0).collect();
    let sides = |back: bool| floor.iter().filter(|chart| chart.back == back).count();
    // The line of the sheet reaches the first wall only where it is not built.
    assert_eq!((sides(false), sides(true)), (3, 1));
    // On the chart of any point, filtering mixes no texels from behind a wall.
    let separated = |a: DVec3, b: DVec3| {
        let crosses = |p: DVec2, q: DVec2| {
            let turn = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
            let (a, b) = (a.truncate(), b.truncate());
            turn(p, q, a) * turn(p, q, b) < 0.0 && turn(a, b, p) * turn(a, b, q) < 0.0
        };
        crosses(DVec2::new(1.505, 0.0), DVec2::new(1.505, 2.0))
            || crosses(DVec2::new(2.0, 0.5), DVec2::new(3.4, 1.9))
    };
    let mut beneath = 0;
    for i in 0..10_000 {
        let uv = DVec2::new(f64::from(i % 100) + 0.47, f64::from(i / 100) + 0.52) / 100.0;
        let own: Vec<(&&Chart, DVec2)> = floor
            .iter()
            .filter(|chart| !chart.back)
            .filter_map(|chart| Some((chart, chart.to_texel(0, uv)?)))
            .collect();
        let [(chart, texel)] = own[..] else { panic!("{uv}: {}", own.len()) };
        // None beneath a wall.
        let Some(here) = place_of(chart, &surfaces[0], texel) else {
            beneath += 1;
            continue;
        };
        for corner in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            if let Some(there) = place_of(chart, &surfaces[0], texel.floor() + corner) {
                assert!(!separated(here, there), "{here} {there}");
            }
        }
    }
    // Strips a tenth of a texel wide along the two walls, 4 m in all, cover .04 of 12 m^2: some 33 of the points.
    assert!(beneath < 50, "{beneath}");
}

#[test]
fn sides_of_a_small_box_are_no_wall_in_it() {
    let scene = scene(vec![(ShapeDescription::cuboid(DVec3::ZERO, DVec3::ONE), 0.5, 0.0)]);
    let surfaces = scene.placed_surfaces();
    assert!(charts(&surfaces, 3.0).iter().all(|chart| chart.walls.is_empty()));
}

#[test]
fn walls_divide_the_charts_and_elements_of_trimmed_faces() {
    // A floor without its margin, and a sheet across its middle.
    let kept = [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]];
    let curve = TrimCurveDescription {
        degree: 1,
        knots: vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0],
        points: kept.iter().map(|[x, y]| [*x, *y, 1.0]).collect(),
        width: None,
        edge: None,
    };
    let trim = TrimDescription::from(vec![TrimLoopDescription { curves: vec![curve] }]);
    let floor = parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 3.0).trimmed(trim);
    let sheet = parallelogram(DVec3::X * 2.0, DVec3::Y * 3.0, DVec3::Z);
    let scene = scene(vec![(floor, 0.5, 0.0), (sheet, 0.5, 0.0)]);
    let mut elements = Elements::new(&scene, &ElementSettings { side: 1.2 }).unwrap();
    let floor = elements.surfaces.iter().position(PlacedSurface::is_trimmed).unwrap() as u32;
    let charts = charts(&elements.surfaces, 10.0);
    let sides = |back: bool| charts.iter().filter(|c| c.surface == floor && c.back == back).count();
    assert_eq!((sides(false), sides(true)), (2, 1));
    let crosses = |elements: &Elements<'_>| {
        let fronts = elements.list.iter().filter(|e| e.patch.surface == floor && !e.patch.back);
        let is_across = |corners: Vec<DVec2>| {
            corners.iter().any(|uv| uv.x < 0.49) && corners.iter().any(|uv| uv.x > 0.51)
        };
        fronts.filter(|e| is_across(e.patch.domain.corners())).count()
    };
    assert!(crosses(&elements) > 0);
    elements.cut_at_walls(10.0).unwrap();
    assert_eq!(crosses(&elements), 0);
}

#[test]
fn parts_of_a_chart_cover_it_once() {
    let scene = walls_on_a_floor();
    let surfaces = scene.placed_surfaces();
    let mut area = 0.0;
    for chart in charts(&surfaces, 10.0).iter().filter(|chart| chart.surface == 0 && !chart.back) {
        let made = crate::tessellate::tessellate(&surfaces[0], chart, [1, 1], 1e-3);
        for [a, b, c] in made.indices {
            let [p, q, r] = [a, b, c].map(|i| made.positions[i as usize]);
            area += 0.5 * (q - p).cross(r - p).z;
            for i in [a, b, c] {
                let found = place_of(chart, &surfaces[0], made.texels[i as usize]);
                // Corners lie on the walls, or where there is none.
                assert!(found.is_none_or(|found| found.distance(made.positions[i as usize]) < 1e-3));
            }
        }
    }
    assert!((area - 12.0).abs() < 1e-9, "{area}");
}

#[test]
fn patches_of_a_freeform_surface_have_texels_at_the_same_points_of_common_edges() {
    let scene = scene(vec![(vase(), 0.5, 0.0)]);
    let surfaces = scene.placed_surfaces();
    let charts = charts(&surfaces, 16.0);
    let chart = |face: u32| charts.iter().find(|chart| !chart.back && chart.faces() == [face]).unwrap();
    // Patches lie one above the other, three in each quarter of a turn.
    for face in 0..12 {
        let (own, beside) = (chart(face), chart((face + 3) % 12));
        assert_eq!(own.size[1], beside.size[1]);
        let side = (0..own.size[1]).map(|y| {
            [
                (own, DVec2::new(f64::from(own.size[0] - 1), f64::from(y))),
                (beside, DVec2::new(0.0, f64::from(y))),
            ]
        });
        let mut pairs: Vec<_> = side.collect();
        if face % 3 < 2 {
            let above = chart(face + 1);
            assert_eq!(own.size[0], above.size[0]);
            pairs.extend((0..own.size[0]).map(|x| {
                [
                    (own, DVec2::new(f64::from(x), f64::from(own.size[1] - 1))),
                    (above, DVec2::new(f64::from(x), 0.0)),
                ]
            }));
        }
        for pair in pairs {
            let [a, b] = pair.map(|(chart, texel)| place_of(chart, &surfaces[0], texel).unwrap());
            // Each is moved inwards by a thousandth of a texel.
            assert!(a.distance(b) < 3e-3 / 16.0, "{face}: {a} {b}");
        }
    }
}
