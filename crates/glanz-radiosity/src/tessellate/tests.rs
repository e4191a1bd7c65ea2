use std::f64::consts::{PI, TAU};

use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

use super::*;
use crate::charts::charts;
use crate::circle::circle;
use crate::scenes;

fn all(scene: &Scene, tolerance: f64) -> Vec<Triangles> {
    let surfaces = scene.placed_surfaces();
    let of_chart = |chart: &Chart| {
        let surface = &surfaces[chart.surface as usize];
        tessellate(surface, chart, divisions(surface, tolerance), tolerance)
    };
    charts(&surfaces, 10.0).iter().filter(|chart| !chart.back).map(of_chart).collect()
}

fn area(triangles: &Triangles) -> f64 {
    let corner = |i: u32| triangles.positions[i as usize];
    let one = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
    0.5 * triangles.indices.iter().map(one).sum::<f64>()
}

/// A shape of which a circle of radius 0.3 in the middle of its parameters is kept, or cut out.
fn trimmed(shape: ShapeDescription, kept: bool) -> Scene {
    let round = circle().into_iter().map(|[x, y, w]| [w * (0.5 + 0.3 * x), w * (0.5 + 0.3 * y), w]);
    let mut round: Vec<[f64; 3]> = round.collect();
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let square = TrimCurveDescription {
        degree: 1,
        knots: vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0],
        points: square.iter().map(|[x, y]| [*x, *y, 1.0]).collect(),
        width: None,
        edge: None,
    };
    let mut loops = Vec::new();
    if !kept {
        round.reverse();
        loops.push(TrimLoopDescription { curves: vec![square] });
    }
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    loops.push(TrimLoopDescription {
        curves: vec![TrimCurveDescription { degree: 2, knots, points: round, width: None, edge: None }],
    });
    let shape = shape.trimmed(TrimDescription::from(loops));
    SceneBuilder::new().shape(shape, MaterialKind::diffuse(0.5)).resolve().unwrap().0
}

#[test]
fn triangles_are_within_the_tolerance_and_have_the_area_of_the_surface() {
    let (sphere, torus) = (ShapeDescription::sphere(0.5), ShapeDescription::torus(1.0, 0.25));
    let wall = scenes::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y);
    for (shape, expected) in [(sphere, PI), (torus, PI * PI), (wall, 2.0)] {
        let scene = scenes::scene(vec![(shape.clone(), 0.5, 0.0)]);
        let made = all(&scene, 1e-3);
        let found: f64 = made.iter().map(area).sum();
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        if let GeometryDescription::Sphere { radius, .. } = shape.geometry {
            for triangles in &made {
                for corners in &triangles.indices {
                    let [a, b, c] = corners.map(|i| triangles.positions[i as usize]);
                    assert!((a + b + c).length() / 3.0 > radius - 1e-3);
                    let [n, ..] = corners.map(|i| triangles.normals[i as usize]);
                    assert!(n.dot(a) > 0.5 - 1e-9 && (b - a).cross(c - a).dot(a) > 0.0);
                }
            }
        } else if expected == 2.0 {
            // A flat rectangle is two triangles.
            assert_eq!(made[0].indices.len(), 2);
        }
    }
}

#[test]
fn trimming_curves_are_followed_within_the_tolerance() {
    let wall = || scenes::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0);
    for kept in [true, false] {
        let scene = trimmed(wall(), kept);
        let made = all(&scene, 1e-4);
        let disk = PI * 0.6 * 0.6;
        let expected = if kept { disk } else { 4.0 - disk };
        let found: f64 = made.iter().map(area).sum();
        // Chords that are off by 1e-4 at most along 3.8 m.
        assert!((found - expected).abs() < 4e-4, "{found} {expected}");
        for p in made.iter().flat_map(|triangles| &triangles.positions) {
            let radius = DVec2::new(p.x - 1.0, p.y - 1.0).length();
            assert!(if kept { radius < 0.6 + 1e-6 } else { radius > 0.6 - 1e-6 }, "{radius}");
        }
    }
}

#[test]
fn no_triangle_leaves_a_gap_within_a_surface() {
    // Each edge of a closed surface belongs to two triangles; of a trimmed one, those on the border to one.
    let torus = ShapeDescription::torus(1.0, 0.25);
    for (scene, is_closed) in
        [(scenes::scene(vec![(torus.clone(), 0.5, 0.0)]), true), (trimmed(torus, true), false)]
    {
        let key = |p: DVec3| (p * 1e9).round().to_array().map(|x| x as i64);
        let mut edges: HashMap<[[i64; 3]; 2], Vec<DVec3>> = HashMap::new();
        for triangles in all(&scene, 1e-2) {
            for corners in triangles.indices {
                let [a, b, c] = corners.map(|i| triangles.positions[i as usize]);
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    let (k, l) = (key(p), key(q));
                    edges.entry(if k < l { [k, l] } else { [l, k] }).or_default().push(p.midpoint(q));
                }
            }
        }
        let open: Vec<DVec3> = edges.values().filter(|list| list.len() == 1).map(|list| list[0]).collect();
        assert!(edges.values().all(|list| list.len() <= 2));
        assert_eq!(open.is_empty(), is_closed, "{}", open.len());
        // The border is a closed curve in parameters: its length is that of its chords.
        assert!(open.len() < edges.len() / 4);
    }
}

/// Distance of a point from a triangle by a fine grid of its points.
fn by_grid(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = 24;
    let all = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
    let at = |(i, j): (i32, i32)| {
        a + (b - a) * (f64::from(i) / f64::from(n)) + (c - a) * (f64::from(j) / f64::from(n))
    };
    all.map(|step| point.distance(at(step))).fold(f64::INFINITY, f64::min)
}

#[test]
fn uneven_parameters_need_no_triangles_and_twisted_patches_get_enough() {
    // A bowl, whose parameter runs with the height, so infinitely fast at its lowest point; and a twisted patch of straight lines.
    let bowl = ShapeDescription::from(GeometryDescription::Paraboloid {
        radius: 0.15,
        z: [0.0, 0.075],
        phi_max: TAU,
    });
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.4)];
    let twisted =
        ShapeDescription::from(GeometryDescription::Bilinear { positions, indices: vec![[0, 1, 2, 3]] });
    let tolerance = 1e-3;
    for shape in [bowl, twisted] {
        let scene = scenes::scene(vec![(shape, 0.5, 0.0)]);
        let surface = &scene.placed_surfaces()[0];
        let [columns, rows] = divisions(surface, tolerance);
        assert!(columns * rows <= 64 * 64, "{columns} {rows}");
        let at = |u: f64, v: f64| {
            let uv = DVec2::new(u / f64::from(columns), v / f64::from(rows));
            surface.at(0, uv, false).unwrap().at.point.position
        };
        for (i, j) in (0..columns).step_by(3).flat_map(|i| (0..rows).map(move |j| (i, j))) {
            let (u, v) = (f64::from(i), f64::from(j));
            let [a, b, c, d] = [at(u, v), at(u + 1.0, v), at(u + 1.0, v + 1.0), at(u, v + 1.0)];
            // The grid of points is off by less than its spacing; across the surface by the square of it.
            let spacing = a.distance(c).max(b.distance(d)) / 24.0;
            let allowed = tolerance.hypot(spacing);
            for (x, y) in [(0.5, 0.5), (0.3, 0.4), (0.7, 0.8), (0.2, 0.9)] {
                let point = at(u + x, v + y);
                let off = by_grid(point, [d, a, b]).min(by_grid(point, [b, c, d]));
                assert!(off <= allowed, "{i} {j}: {off} {allowed}");
            }
        }
    }
}
