//! Triangles, cuboids and convex polyhedra.

use glanz_geometry::cuboid::Cuboid;
use glanz_geometry::polyhedron::{HalfSpace, Polyhedron};
use glanz_geometry::triangle::Triangle;
use glanz_math::{Bounds3, DVec3};

use super::case::ContractCase;
use super::harness::check_kind;

/// A triangle, without parameterization: its domain is not a square, and the unit tests check it.
fn triangle(p: [DVec3; 3]) -> ContractCase {
    let n = (p[1] - p[0]).cross(p[2] - p[0]);
    let unit = n.normalize();
    let edges = [[p[0], p[1]], [p[1], p[2]], [p[2], p[0]]];
    let center = (p[0] + p[1] + p[2]) / 3.0;
    ContractCase {
        // The inside is on the left of an edge from a to b.
        kept: Box::new(move |x| {
            let to_edge = |[a, b]: [DVec3; 2]| unit.cross((b - a).normalize()).dot(x - a);
            edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
        }),
        area: Some(0.5 * n.length()),
        center,
        size: 1.1 * p.iter().map(|q| q.distance(center)).fold(0.0, f64::max),
        convex: true,
        targets: edges.to_vec(),
        directions: vec![p[1] - p[0], unit, (p[2] - p[0]) + unit * 1e-9],
        ..ContractCase::new(
            format!("triangle {p:?}"),
            Triangle::try_new(p[0], p[1], p[2]).unwrap(),
            move |x| unit.dot(x - center),
        )
    }
}

#[test]
fn triangles_keep_the_contract() {
    let v = DVec3::new;
    let cases = [
        triangle([v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)]),
        triangle([v(0.3, -0.7, 1.1), v(2.0, 0.4, -0.5), v(-0.6, 1.5, 0.2)]),
        triangle([v(0.3, 5.7, 1.1), v(0.2, 5.9, 1.3), v(0.4, 5.5, 1.2)].map(|p| p * 1e-3)),
        // A hundred times as long as wide.
        triangle([v(1.0, 2.0, 3.0), v(2.0, 2.0, 3.5), v(1.5, 2.01, 3.25)]),
        triangle([v(1e4, 0.0, -1e4), v(0.0, 2e4, 0.0), v(-1e4, -1e4, 1e4)]),
    ];
    check_kind("triangle", 23, &cases);
}

fn cuboid(a: DVec3, b: DVec3) -> ContractCase {
    let bounds = Bounds3::new(a, b);
    let d = bounds.diagonal();
    let corners = bounds.corners();
    let mut edges = Vec::new();
    for i in 0..8 {
        for bit in [1, 2, 4] {
            if i & bit == 0 {
                edges.push([corners[i], corners[i | bit]]);
            }
        }
    }
    ContractCase {
        area: Some(2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)),
        center: bounds.center(),
        size: 0.55 * d.length(),
        convex: true,
        targets: edges.clone(),
        ridges: edges,
        directions: vec![DVec3::X, DVec3::new(0.0, 1.0, 1e-9), DVec3::new(1.0, 1.0, 0.0)],
        ..ContractCase::new(format!("cuboid {a} {b}"), Cuboid::try_new(a, b).unwrap(), move |p| {
            (bounds.min - p).max(p - bounds.max).max_element()
        })
    }
}

#[test]
fn cuboids_keep_the_contract() {
    let cases = [
        cuboid(DVec3::splat(-1.0), DVec3::ONE),
        cuboid(DVec3::new(0.1, 7.3, -0.2), DVec3::new(0.4, 7.0, 3.3)),
        cuboid(DVec3::ZERO, DVec3::new(1e3, 1.7e3, 0.1e3)),
        cuboid(DVec3::splat(1e-4), DVec3::new(2e-4, 3e-4, 1.5e-4)),
    ];
    check_kind("cuboid", 24, &cases);
}

fn polyhedron(name: &str, planes: &[HalfSpace], area: Option<f64>) -> ContractCase {
    let solid = Polyhedron::try_new(planes).unwrap();
    let vertices = solid.vertices();
    let center = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    let size = 1.1 * vertices.iter().map(|v| v.distance(center)).fold(0.0, f64::max);
    let edges: Vec<[DVec3; 2]> = solid
        .facets()
        .iter()
        .flat_map(|f| {
            let c = f.corners();
            (0..c.len()).map(move |i| [vertices[c[i]], vertices[c[(i + 1) % c.len()]]])
        })
        .collect();
    // Independent of the constructor: all half-spaces as they were given.
    let planes: Vec<(DVec3, f64)> =
        planes.iter().map(|h| (h.normal.normalize(), h.distance / h.normal.length())).collect();
    ContractCase {
        area,
        center,
        size,
        convex: true,
        targets: edges.clone(),
        ridges: edges.clone(),
        directions: edges.iter().take(3).map(|[a, b]| *b - *a).chain([DVec3::X]).collect(),
        ..ContractCase::new(name, solid, move |p| {
            planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max)
        })
    }
}

#[test]
fn polyhedra_keep_the_contract() {
    let at = |n: DVec3, distance: f64| HalfSpace { normal: n, distance };
    let v = DVec3::new;
    let octahedron: Vec<_> = (0..8)
        .map(|i| at(DVec3::from([1, 2, 4].map(|bit| if i & bit == 0 { 1.0 } else { -1.0 })), 1.0))
        .collect();
    let tetrahedron = [
        at(v(-1.0, 0.0, 0.0), 0.0),
        at(v(0.0, -1.0, 0.0), 0.0),
        at(v(0.0, 0.0, -1.0), 0.0),
        at(v(3.0, 2.0, 1.0), 6.0),
    ];
    // Sixty planes that touch a ball away from the origin; some facets are tiny.
    let center = v(3.0, -2.0, 1.0);
    let ball: Vec<_> = (0..60)
        .map(|i| {
            let z = (f64::from(i) + 0.5) / 30.0 - 1.0;
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            let n = v(r * cos, r * sin, z);
            at(n, 0.5 + n.dot(center))
        })
        .collect();
    let wedge = [
        at(v(0.0, 0.0, -1.0), 0.0),
        at(v(0.4, 0.0, 1.0), 0.3),
        at(v(-0.4, 0.0, 1.0), 0.3),
        at(v(0.0, 1.0, 0.3), 1.0),
        at(v(0.0, -1.0, 0.2), 1.0),
    ];
    let cases = [
        // Edge sqrt 2: 2 sqrt 3 edge^2.
        polyhedron("octahedron", &octahedron, Some(4.0 * 3.0_f64.sqrt())),
        // Corners (2, 0, 0), (0, 3, 0), (0, 0, 6): three right triangles and |(3, 2, 1)| 6 / 2 of the slanted one.
        polyhedron("tetrahedron", &tetrahedron, Some(3.0 + 6.0 + 9.0 + 3.0 * 14.0_f64.sqrt())),
        polyhedron("sixty planes", &ball, None),
        polyhedron("wedge", &wedge, None),
    ];
    check_kind("polyhedron", 25, &cases);
}
