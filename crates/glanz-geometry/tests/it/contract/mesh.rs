//! Triangle meshes: convex bodies with a known hull, and a height field.

use glanz_geometry::mesh::Mesh;
use glanz_math::{DVec2, DVec3};

use super::case::ContractCase;
use super::harness::check_kind;

/// The fields that all meshes have in common.
fn mesh(
    name: &str,
    positions: Vec<DVec3>,
    indices: Vec<[u32; 3]>,
    normals: Option<Vec<DVec3>>,
    implicit: impl Fn(DVec3) -> f64 + 'static,
) -> ContractCase {
    let corners = |t: &[u32; 3]| t.map(|i| positions[i as usize]);
    let area = indices.iter().map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
    let mut edges: Vec<[DVec3; 2]> = Vec::new();
    for [a, b, c] in indices.iter().map(corners) {
        for edge in [[a, b], [b, c], [c, a]] {
            if !edges.contains(&[edge[1], edge[0]]) {
                edges.push(edge);
            }
        }
    }
    let center = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let size = 1.1 * positions.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
    let uvs = positions.iter().map(|p| DVec2::new(p.x + 0.3 * p.z, p.y)).collect();
    ContractCase {
        area: Some(area),
        center,
        size,
        targets: edges.clone(),
        directions: edges.iter().take(5).map(|[a, b]| *b - *a).chain([DVec3::X, DVec3::Z]).collect(),
        ridges: edges,
        ..ContractCase::new(name, Mesh::try_new(positions, indices, normals, Some(uvs)).unwrap(), implicit)
    }
}

/// The inside of a convex body is that of all planes of its triangles.
fn convex(name: &str, positions: Vec<DVec3>, indices: Vec<[u32; 3]>, smooth: bool) -> ContractCase {
    let center = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let planes: Vec<(DVec3, f64)> = indices
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            let n = (b - a).cross(c - a).normalize();
            (n, n.dot(a))
        })
        .collect();
    let normals = smooth.then(|| positions.iter().map(|p| *p - center).collect());
    let signed = move |p: DVec3| planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max);
    ContractCase { convex: true, ..mesh(name, positions, indices, normals, signed) }
}

/// An octahedron of which every triangle is split into four, `levels` times, with corners on a sphere.
fn ball(levels: u32, center: DVec3, radius: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut corners = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
                let middle = (corners[i as usize] + corners[j as usize]).normalize();
                // Neighbours share it: a mesh without gaps.
                corners.iter().position(|&p| p == middle).unwrap_or_else(|| {
                    corners.push(middle);
                    corners.len() - 1
                }) as u32
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (corners.into_iter().map(|p| center + p * radius).collect(), triangles)
}

/// A height field over a square of `n` x `n` cells, two triangles each.
fn landscape(n: usize, half: f64, height: impl Fn(DVec2) -> f64) -> ContractCase {
    let side = n + 1;
    let at = move |i: usize, j: usize| {
        DVec2::new(i as f64, j as f64) * (2.0 * half / n as f64) - DVec2::splat(half)
    };
    let positions: Vec<DVec3> =
        (0..side * side).map(|k| at(k / side, k % side)).map(|p| p.extend(height(p))).collect();
    let corner = move |i: usize, j: usize| (i * side + j) as u32;
    let indices = (0..n * n)
        .flat_map(|k| {
            let (i, j) = (k / n, k % n);
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let heights: Vec<f64> = positions.iter().map(|p| p.z).collect();
    let surface = move |p: DVec3| {
        let cells = (p.truncate() + DVec2::splat(half)) * (n as f64 / (2.0 * half));
        // Beyond the border the triangles of the last cells are continued.
        let cell = |x: f64| (x.floor().max(0.0) as usize).min(n - 1);
        let (i, j) = (cell(cells.x), cell(cells.y));
        let (x, y) = (cells.x - i as f64, cells.y - j as f64);
        let z = |i: usize, j: usize| heights[corner(i, j) as usize];
        let there = if x >= y {
            z(i, j) + x * (z(i + 1, j) - z(i, j)) + y * (z(i + 1, j + 1) - z(i + 1, j))
        } else {
            z(i, j) + y * (z(i, j + 1) - z(i, j)) + x * (z(i + 1, j + 1) - z(i, j + 1))
        };
        p.z - there
    };
    // Between the edges of the triangles the function is linear, so that no two crossings are stepped over.
    let cell = 2.0 * half / n as f64;
    let n_cells = n as i32;
    let straight = (0..=n_cells).map(|k| f64::from(k).mul_add(cell, -half));
    let diagonal = (-n_cells..=n_cells).map(|k| (DVec3::new(1.0, -1.0, 0.0), f64::from(k) * cell));
    let kinks = straight.flat_map(|at| [(DVec3::X, at), (DVec3::Y, at)]).chain(diagonal).collect();
    ContractCase {
        kept: Box::new(move |p| half - p.x.abs().max(p.y.abs())),
        kinks,
        ..mesh(&format!("landscape {n} {half}"), positions, indices, None, surface)
    }
}

#[test]
fn meshes_keep_the_contract() {
    let (octahedron, faces) = ball(0, DVec3::ZERO, 1.0);
    let (stone, stone_faces) = ball(2, DVec3::new(30.0, -20.0, 10.0), 2.0);
    let (grain, grain_faces) = ball(1, DVec3::splat(1e-4), 1e-4);
    let cases = [
        convex("octahedron", octahedron, faces, false),
        convex("smooth ball of 128 triangles", stone, stone_faces, true),
        convex("grain", grain, grain_faces, false),
        landscape(5, 1.0, |p| 0.3 * (3.0 * p.x).sin() * (2.0 * p.y + 0.3).cos()),
        landscape(2, 100.0, |p| 0.3 * p.x - 0.002 * p.y * p.y),
    ];
    check_kind("mesh", 31, &cases);
}
