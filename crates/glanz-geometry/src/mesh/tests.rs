//! Meshes against the scalar triangle test and closed forms, also with rays through edges and vertices.

use glanz_math::rounding::offset_origin;
use glanz_math::{DVec2, DVec3, Ray};

use super::*;
use crate::batch::BoundedRay;
use crate::bvh::simd::Isa;
use crate::triangle::ShearedRay;

/// Numbers that look random: the finaliser of splitmix64 over a counter.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

type Shape = (Vec<DVec3>, Vec<[u32; 3]>);

/// The unit sphere as an octahedron whose faces are cut into `4^level` triangles; neighbours share their vertices.
fn sphere(level: u32) -> Shape {
    let mut positions: Vec<DVec3> =
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]).collect();
    let mut indices: Vec<[u32; 3]> = Vec::new();
    for corner in 0..8u32 {
        let [x, y, z] = [corner & 1, 2 + (corner >> 1 & 1), 4 + (corner >> 2 & 1)];
        // An odd number of mirrored axes turns the triangle inside out.
        indices.push(if corner.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in indices {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    positions.push((positions[p as usize] + positions[q as usize]).normalize());
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        indices = finer;
    }
    (positions, indices)
}

/// The surface of the cube [-1, 1]^3 in squares of side `2 / n`, all vertices on a lattice.
fn cube(n: u32) -> Shape {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = positions.len() as u32;
            for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (at(i), at(j));
                positions.push(DVec3::from_array(p));
            }
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let a = first + i * (n + 1) + j;
                let [b, c, d] = [a + 1, a + n + 1, a + n + 2];
                indices.extend(if side > 0.0 { [[a, c, d], [a, d, b]] } else { [[a, d, c], [a, b, d]] });
            }
        }
    }
    (positions, indices)
}

fn mesh((positions, indices): Shape) -> Mesh {
    Mesh::try_new(positions, indices, None, None).unwrap()
}

fn with_isa(mesh: &Mesh, isa: Isa) -> Mesh {
    let mesh = mesh.clone();
    Mesh { bvh: mesh.bvh.with_isa(isa), ..mesh }
}

fn soup(random: &mut Random, count: u32, size: f64) -> Shape {
    let corners = (0..count).flat_map(|_| {
        let center = random.vector();
        [0; 3].map(|_| center + random.vector() * size)
    });
    (corners.collect(), (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Every hit by the scalar test of single triangles, by `t`, then face.
fn brute_force(mesh: &Mesh, ray: &Ray, t_max: f64) -> Vec<Hit> {
    let sheared = ShearedRay::new(ray.origin, ray.direction);
    let mut hits = Vec::new();
    for face in 0..mesh.indices.len() as u32 {
        let [a, b, c] = mesh.corners(face).unwrap();
        if unit_normal(a, b, c).is_some() {
            let hit = sheared.intersect(a, b, c, t_max);
            hits.extend(hit.map(|(t, u, v)| Hit::new(t, u, v, face)));
        }
    }
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
    hits
}

#[test]
fn every_instruction_set_finds_the_bits_that_brute_force_finds() {
    let mut random = Random(1);
    for round in 0..12 {
        let count = [1, 3, 8, 9, 50, 2000][round % 6];
        let (mut positions, indices) = soup(&mut random, count, 0.2);
        let single = round < 6;
        if single {
            positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        }
        let mesh = mesh((positions, indices));
        assert_eq!(matches!(mesh.blocks, TriangleBlocks::Single(_)), single);
        let (mut rays, mut first) = (Vec::new(), Vec::new());
        for i in 0..500 {
            let mut direction = random.vector();
            if i % 5 == 0 {
                direction[i % 3] = 0.0;
            }
            // Some through a vertex of the mesh, some of finite length.
            let vertex = mesh.position(random.below(mesh.vertex_count()) as u32).unwrap();
            let origin = if i % 3 == 0 { vertex - direction } else { random.vector() * 2.0 };
            let ray = Ray::new(origin, direction);
            let t_max = if i % 2 == 0 { f64::INFINITY } else { 1.0 };
            let expected = brute_force(&mesh, &ray, t_max);
            rays.push(BoundedRay::new(ray, t_max));
            first.push(expected.first().copied());
            for isa in Isa::all() {
                let mesh = with_isa(&mesh, isa);
                assert_eq!(mesh.intersect(&ray, t_max).as_ref(), expected.first(), "{isa:?}");
                assert_eq!(mesh.occluded(&ray, t_max), !expected.is_empty(), "{isa:?}");
                let mut all = Vec::new();
                mesh.all_hits(&ray, t_max, &mut all);
                // No two triangles of a soup share a vertex.
                assert_eq!(all, expected, "{isa:?}");
            }
        }
        let met: Vec<bool> = first.iter().map(Option::is_some).collect();
        assert!(met.iter().filter(|&&met| met).count() > 10, "few rays met anything");
        for isa in Isa::all() {
            let mesh = with_isa(&mesh, isa);
            let (mut hits, mut occluded) = (Vec::new(), Vec::new());
            for size in [1, 2, 3, 11, 500] {
                for ((rays, first), met) in rays.chunks(size).zip(first.chunks(size)).zip(met.chunks(size)) {
                    mesh.closest_batch(rays, &mut hits);
                    mesh.occluded_batch(rays, &mut occluded);
                    assert_eq!((&*hits, &*occluded), (first, met), "{isa:?}, batches of {size}");
                }
            }
        }
    }
}

#[test]
fn no_ray_escapes_from_a_closed_mesh() {
    let mut random = Random(2);
    let (mut positions, indices) = sphere(6);
    for p in &mut positions {
        *p *= 1.0 + 0.02 * random.next();
    }
    // Tiny, huge and far from the origin of the world, too.
    for (scale, place) in [(1.0, DVec3::ZERO), (1e-9, DVec3::ZERO), (1e9, DVec3::X), (1.0, DVec3::splat(1e5))]
    {
        let positions: Vec<DVec3> = positions.iter().map(|&p| p * scale + place).collect();
        let mesh = mesh((positions.clone(), indices.clone()));
        let at = |face: [u32; 3], weights: [f64; 3]| {
            (0..3).map(|i| positions[face[i] as usize] * weights[i]).sum::<DVec3>()
        };
        for i in 0..250_000 {
            let face = indices[random.below(indices.len())];
            let x = random.next();
            let target = match i % 4 {
                0 => at(face, [1.0, 0.0, 0.0]),
                1 => at(face, [x, 1.0 - x, 0.0]),
                2 => at(face, [0.5, 0.5, 0.0]),
                _ => at(face, [1.0, 1.0, 1.0]) / 3.0,
            };
            let origin = place + random.vector() * (0.5 * scale);
            let ray = Ray::new(origin, target - origin);
            assert!(mesh.intersect(&ray, f64::INFINITY).is_some(), "{ray:?} escapes");
            assert!(mesh.occluded(&ray, f64::INFINITY));
        }
    }
}

#[test]
fn rays_along_lattice_lines_meet_both_walls_of_a_lattice_cube() {
    let mesh = mesh(cube(16));
    for axis in 0..3 {
        for (i, j) in (0..33).flat_map(|i| (0..33).map(move |j| (i, j))) {
            // Vertices, middles of edges and centres, all exact in binary; the borders of the cube included.
            let mut origin = [-3.0; 3];
            origin[(axis + 1) % 3] = f64::from(i) / 16.0 - 1.0;
            origin[(axis + 2) % 3] = f64::from(j) / 16.0 - 1.0;
            let ray = Ray::new(DVec3::from_array(origin), DVec3::AXES[axis]);
            let mut hits = Vec::new();
            mesh.all_hits(&ray, f64::INFINITY, &mut hits);
            let at: Vec<f64> = hits.iter().map(|h| h.t).collect();
            // At the rim the ray lies in the plane of a side wall, which as a plane edge-on is not hit.
            assert_eq!(at, [2.0, 4.0], "axis {axis} ({i}, {j})");
            assert_eq!(mesh.intersect(&ray, f64::INFINITY).unwrap().t, 2.0);
        }
    }
}

#[test]
fn a_ray_through_a_shared_vertex_meets_the_surface_once_on_each_side() {
    let (positions, indices) = sphere(4);
    let mesh = mesh((positions.clone(), indices));
    for &vertex in &positions {
        // Through the centre, so that the ray leaves through the opposite vertex, exactly.
        let ray = Ray::new(vertex * 2.0, -vertex);
        let mut hits = Vec::new();
        mesh.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), 2, "{hits:?}");
        assert!((hits[0].t - 1.0).abs() < 1e-14 && (hits[1].t - 3.0).abs() < 1e-14);
    }
}

#[test]
fn a_ray_that_leaves_a_convex_mesh_does_not_come_back() {
    let mut random = Random(3);
    for (scale, place) in [(1.0, DVec3::ZERO), (1e-3, DVec3::new(1e3, -2e3, 5e2)), (1e6, DVec3::X)] {
        let (positions, indices) = sphere(5);
        let mesh = mesh((positions.iter().map(|&p| p * scale + place).collect(), indices));
        for i in 0..100_000 {
            let start = place + random.vector() * scale * 2.0;
            // Half of them aim at vertices.
            let target = if i % 2 == 0 {
                mesh.position(random.below(mesh.vertex_count()) as u32).unwrap()
            } else {
                place + random.vector() * (0.5 * scale)
            };
            let ray = Ray::new(start, target - start);
            let Some(hit) = mesh.intersect(&ray, f64::INFINITY) else { continue };
            let point = mesh.point(&ray, &hit);
            // Half of the directions graze.
            let along = random.vector().reject_from_normalized(point.normal).normalize_or_zero();
            let up = random.next() * if i % 4 < 2 { 1.0 } else { 1e-7 };
            let direction = along + point.normal * up;
            let origin = offset_origin(point.position, point.error, point.normal, direction);
            let away = Ray::new(origin, direction);
            assert_eq!(mesh.intersect(&away, f64::INFINITY), None, "case {i}: {away:?} from {hit:?}");
            assert!(!mesh.occluded(&away, f64::INFINITY));
        }
    }
}

#[test]
fn hits_at_the_same_place_go_to_the_lowest_face() {
    // The same square of four triangles, thrice, so that every hit is a tie; in reverse order as well.
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y, DVec3::new(0.5, 0.5, 0.0)];
    let square = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let mut indices: Vec<[u32; 3]> = Vec::new();
    for _ in 0..3 {
        indices.extend(square.iter().rev());
    }
    let mesh = mesh((corners.to_vec(), indices));
    for isa in Isa::all() {
        let mesh = with_isa(&mesh, isa);
        for (x, y, face) in
            [(0.5, 0.1, 3), (0.9, 0.5, 2), (0.5, 0.9, 1), (0.1, 0.5, 0), (0.5, 0.5, 0), (0.75, 0.25, 2)]
        {
            let hit = mesh.intersect(&Ray::new(DVec3::new(x, y, 1.0), -DVec3::Z), 2.0).unwrap();
            assert_eq!((hit.t, hit.face), (1.0, face), "{x} {y} {isa:?}");
        }
    }
}

#[test]
fn texture_derivatives_are_those_of_a_plane() {
    // Over the plane z = 0 the coordinates are u = 2 x + y, v = y - 3: x = (u - v - 3) / 2, y = v + 3.
    let positions = vec![DVec3::ZERO, DVec3::new(2.0, 0.5, 0.0), DVec3::new(-1.0, 3.0, 0.0)];
    let uvs = positions.iter().map(|p| DVec2::new(2.0 * p.x + p.y, p.y - 3.0)).collect();
    let normals = vec![DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 2.0, 2.0)];
    let mesh = Mesh::try_new(positions, vec![[0, 1, 2]], Some(normals), Some(uvs)).unwrap();
    let point = mesh.point_at(0, 0.25, 0.5);
    assert!((point.dpdu - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-15);
    assert!((point.dpdv - DVec3::new(-0.5, 1.0, 0.0)).length() < 1e-15);
    assert_eq!(point.uv, DVec2::new(2.0 * point.position.x + point.position.y, point.position.y - 3.0));
    // By differences: a step in the plane moves the weights, and so the shading normal.
    let weights = |p: DVec3| {
        // p = s e1 + t e2 with e1 = (2, 0.5), e2 = (-1, 3), determinant 6.5.
        ((3.0 * p.x + p.y) / 6.5, (2.0 * p.y - 0.5 * p.x) / 6.5)
    };
    let shading = |p: DVec3| {
        let (u, v) = weights(p);
        mesh.point_at(0, u, v).shading_normal
    };
    let h = 1e-6;
    let hit = Hit::new(1.0, 0.25, 0.5, 0);
    let [dndu, dndv] = mesh.normal_derivatives(&hit, &point);
    for (tangent, derivative) in [(point.dpdu, dndu), (point.dpdv, dndv)] {
        let difference = shading(point.position + tangent * h) - shading(point.position - tangent * h);
        assert!((difference / (2.0 * h) - derivative).length() < 1e-9);
    }
}

#[test]
fn triangles_without_texture_coordinates_get_those_of_pbrt() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0)];
    // None, and some that lie on a line.
    let none = Mesh::try_new(positions.clone(), vec![[0, 1, 2]], None, None).unwrap();
    let same = Some(vec![DVec2::ONE; 3]);
    let degenerate = Mesh::try_new(positions, vec![[0, 1, 2]], None, same).unwrap();
    for (mesh, uv) in [(none, DVec2::new(0.75, 0.5)), (degenerate, DVec2::ONE)] {
        let point = mesh.point_at(0, 0.25, 0.5);
        assert_eq!((point.dpdu, point.dpdv), (DVec3::X, DVec3::new(0.0, 2.0, 0.0)));
        assert_eq!(point.uv, uv);
        assert_eq!(point.position, DVec3::new(0.75, 1.0, 0.0));
    }
}

#[test]
fn the_normal_takes_the_side_of_the_shading_normals() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let point = |normals| {
        Mesh::try_new(positions.clone(), vec![[0, 1, 2]], normals, None).unwrap().point_at(0, 0.25, 0.25)
    };
    assert_eq!(point(None).normal, DVec3::Z);
    let down = point(Some(vec![DVec3::new(0.6, 0.0, -0.8) * 5.0; 3]));
    assert_eq!(down.normal, -DVec3::Z);
    assert!((down.shading_normal - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-15);
    // Normals that determine no side: zero, or in the plane.
    for useless in [DVec3::ZERO, DVec3::X] {
        let flat = point(Some(vec![useless; 3]));
        assert_eq!((flat.normal, flat.shading_normal), (DVec3::Z, DVec3::Z));
    }
}

#[test]
fn samples_fall_on_triangles_by_their_area() {
    // Areas 1/2, 2, 9/2 in a row, and a degenerate triangle between them.
    let mut positions = Vec::new();
    for (x, size) in [(0.0, 1.0), (2.0, 2.0), (5.0, 3.0)] {
        positions.extend([DVec3::X * x, DVec3::X * (x + size), DVec3::new(x, size, 0.0)]);
    }
    let mesh = mesh((positions, vec![[0, 1, 2], [0, 1, 1], [3, 4, 5], [6, 7, 8]]));
    assert_eq!((mesh.degenerate(), mesh.area()), (1, 7.0));
    let mut counts = [0; 4];
    let n = 700;
    for i in 0..n {
        let xi = DVec2::new((f64::from(i) + 0.5) / f64::from(n), 0.3);
        let sample = mesh.sample(xi).unwrap();
        counts[sample.hit.face as usize] += 1;
        assert_eq!(sample.pdf, AreaPdf(1.0 / 7.0));
        assert_eq!(mesh.area_pdf(&sample.hit, &sample.point), Some(sample.pdf));
        let (u, v) = (sample.hit.u, sample.hit.v);
        assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0);
    }
    // One stratum each per hundredth of the area.
    assert_eq!(counts, [50, 0, 200, 450]);
    for xi in [DVec2::ZERO, DVec2::splat(1.0f64.next_down())] {
        assert!(mesh.sample(xi).unwrap().point.position.is_finite());
    }
}

#[test]
fn the_largest_number_samples_the_last_triangle_that_has_an_area() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    // The last two have none.
    let mesh = mesh((positions, vec![[0, 1, 2], [0, 1, 3], [3, 3, 1], [2, 2, 2]]));
    // 1 itself, since sums of areas are rounded.
    for x in [1.0, 1.0f64.next_down()] {
        let sample = mesh.sample(DVec2::new(x, 0.5)).unwrap();
        assert_eq!(sample.hit.face, 1);
        assert_eq!(mesh.sample_area(DVec2::new(x, 0.5)), Some(AreaSample::from(sample)));
        assert!(sample.point.position.is_finite() && sample.point.normal == -DVec3::Y);
    }
}

#[test]
fn sampled_triangles_take_the_side_of_their_normals() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let tilted = |x: f64, z: f64| DVec3::new(x, 0.1, z);
    // All on the side of the winding, all on the other one, and on both.
    let lists = [[0.8, 0.9, 0.7], [-0.8, -0.9, -0.7], [0.8, -0.9, 0.7], [-0.2, -0.9, 0.9]];
    for (heights, sides) in lists.into_iter().zip([[true, false], [false, true], [true; 2], [true; 2]]) {
        let normals = [0.1, -0.2, 0.3].into_iter().zip(heights).map(|(x, z)| tilted(x, z)).collect();
        let mesh = Mesh::try_new(positions.clone(), vec![[0, 1, 2]], Some(normals), None).unwrap();
        let mut seen = [false; 2];
        for i in 0..400 {
            let xi = DVec2::new((f64::from(i) + 0.5) / 400.0, (0.618_034 * f64::from(i)).fract());
            let sample = mesh.sample(xi).unwrap();
            assert_eq!(mesh.sample_area(xi), Some(AreaSample::from(sample)));
            seen[usize::from(sample.point.normal.z < 0.0)] = true;
        }
        assert_eq!(seen, sides, "{heights:?}");
    }
}

#[test]
fn a_ray_from_a_sample_of_a_convex_mesh_does_not_meet_it() {
    let mut random = Random(5);
    for (scale, place) in [(1.0, DVec3::ZERO), (1e-3, DVec3::new(1e3, -2e3, 5e2)), (1e6, DVec3::X)] {
        // With and without prepared triangles.
        for level in [2, 6] {
            let (positions, indices) = sphere(level);
            let mesh = mesh((positions.iter().map(|&p| p * scale + place).collect(), indices));
            for i in 0..20_000 {
                let sample = mesh.sample_area(DVec2::new(random.next(), random.next())).unwrap();
                let along = random.vector().reject_from_normalized(sample.normal).normalize_or_zero();
                // Half of the directions graze.
                let up = random.next() * if i % 2 == 0 { 1.0 } else { 1e-7 };
                let direction = along + sample.normal * up;
                let origin = offset_origin(sample.position, sample.error, sample.normal, direction);
                let away = Ray::new(origin, direction);
                assert_eq!(mesh.intersect(&away, f64::INFINITY), None, "case {i}: {away:?} from {sample:?}");
            }
        }
    }
}

#[test]
fn area_of_a_finer_and_finer_sphere_approaches_four_pi() {
    // Area of an inscribed polyhedron: the deficit shrinks by four with every cut.
    let deficit = |level| 4.0 * std::f64::consts::PI - mesh(sphere(level)).area();
    assert!((3.9..4.1).contains(&(deficit(4) / deficit(5))));
}

#[test]
fn invalid_lists_are_refused_with_their_values() {
    let p = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let new = |p: &[DVec3], i: &[[u32; 3]], n, uv| Mesh::try_new(p.to_vec(), i.to_vec(), n, uv).map(|_| ());
    assert_eq!(
        new(&p, &[[0, 1, 2], [0, 7, 1]], None, None),
        Err(SurfaceError::BadIndex { parameter: "vertex index", position: 4, index: 7, count: 3 })
    );
    assert_eq!(
        new(&p, &[[0, 1, 2]], Some(vec![DVec3::Z; 2]), None),
        Err(SurfaceError::CountMismatch { parameter: "vertex normals", count: 2, expected: 3 })
    );
    assert_eq!(
        new(&p, &[[0, 1, 2]], None, Some(vec![DVec2::ZERO; 4])),
        Err(SurfaceError::CountMismatch { parameter: "texture coordinates", count: 4, expected: 3 })
    );
    assert_eq!(
        new(&[DVec3::ZERO, DVec3::X, DVec3::new(0.0, f64::INFINITY, 0.0)], &[[0, 1, 2]], None, None),
        Err(SurfaceError::NotFinite { parameter: "vertex positions", value: f64::INFINITY })
    );
    assert!(matches!(new(&p, &[], None, None), Err(SurfaceError::TooFew { .. })));
    assert!(matches!(new(&p, &[[0, 1, 1]], None, None), Err(SurfaceError::Degenerate { .. })));
}

#[test]
fn invalid_rays_hit_nothing() {
    let small = mesh((vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]));
    for mesh in [small, mesh(sphere(3))] {
        for isa in Isa::all() {
            let mesh = with_isa(&mesh, isa);
            for (origin, direction) in
                [(DVec3::NAN, DVec3::Z), (DVec3::ZERO, DVec3::ZERO), (DVec3::ZERO, DVec3::NAN)]
            {
                let ray = Ray::new(origin, direction);
                assert_eq!(mesh.intersect(&ray, f64::INFINITY), None);
                assert!(!mesh.occluded(&ray, f64::INFINITY));
                let mut hits = Vec::new();
                mesh.all_hits(&ray, f64::INFINITY, &mut hits);
                assert!(hits.is_empty());
            }
        }
    }
}
