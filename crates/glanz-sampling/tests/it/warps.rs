//! Warps against their densities and inverses.
//!
//! Significance: 0.001 over all chi-square tests of this file together (Bonferroni).

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec2, DVec3};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::statistics::chi_square;
use glanz_sampling::warp::*;

const SIGNIFICANCE: f64 = 0.001 / 40.0;
const SAMPLES: u64 = 200_000;

fn xi(i: u64) -> DVec2 {
    DVec2::new(unit_f64(combine(21, i)), unit_f64(combine(22, i)))
}

/// Counts `cell_of` over many samples and compares with `expected`, the probabilities of the cells.
fn check(name: &str, expected: &[f64], cell_of: impl Fn(DVec2) -> usize) {
    let total: f64 = expected.iter().sum();
    assert!((total - 1.0).abs() < 1e-6, "{name}: the density integrates to {total}");
    let mut counts = vec![0; expected.len()];
    for i in 0..SAMPLES {
        counts[cell_of(xi(i))] += 1;
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * SAMPLES as f64).collect();
    let test = chi_square(&counts, &expected);
    assert!(test.p_value > SIGNIFICANCE, "{name}: {test:?}");
}

/// Integral of `f` over [a, b] by Simpson's rule with 64 intervals.
fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / 64.0;
    let weight = |i: u32| if i == 0 || i == 64 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=64).map(|i| weight(i) * f(a + h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// Compares a density of directions that depends on the height only, on 20 x 12 cells of equal solid angle.
fn check_directions(name: &str, warp: impl Fn(DVec2) -> DVec3, pdf: impl Fn(f64) -> f64) {
    let mut expected = Vec::new();
    for row in 0..20 {
        let low = -1.0 + 0.1 * f64::from(row);
        // Densities may jump at z = 0, a border of cells: stay inside.
        let share = TAU * integral(low + 1e-12, low + 0.1 - 1e-12, &pdf) / 12.0;
        expected.extend([share; 12]);
    }
    check(name, &expected, |x| {
        let w = warp(x);
        assert!((w.length() - 1.0).abs() < 1e-14, "{name}: {w} is no direction");
        let turn = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
        let row = ((w.z + 1.0) * 10.0).min(19.0) as usize;
        row * 12 + ((turn * 12.0) as usize).min(11)
    });
}

#[test]
fn directions_follow_their_densities() {
    check_directions("sphere", uniform_sphere, |_| uniform_sphere_pdf().0);
    check_directions("equal-area sphere", equal_area_sphere, |_| uniform_sphere_pdf().0);
    check_directions("hemisphere", uniform_hemisphere, |z| uniform_hemisphere_pdf(z).0);
    check_directions("cosine", cosine_hemisphere, |z| cosine_hemisphere_pdf(z).0);
    for n in [0.0, 1.0, 7.5, 60.0] {
        check_directions(&format!("phong {n}"), |x| phong_lobe(x, n), |z| phong_lobe_pdf(z, n).0);
    }
    // Half angles whose cosine lies on a border of cells.
    for c in [0.9, 0.5, -0.3] {
        let drop = 1.0 - c;
        let pdf = |z: f64| if z > c { uniform_cone_pdf(drop).0 } else { 0.0 };
        check_directions(&format!("cone {c}"), |x| uniform_cone(x, drop), pdf);
    }
}

#[test]
fn disk_is_uniform_in_area() {
    assert_eq!(concentric_disk_pdf(), 1.0 / PI);
    // Rings of equal width have areas 1, 3, 5, ... / 100.
    let expected: Vec<f64> = (0..120).map(|i| f64::from(2 * (i / 12) + 1) / 1200.0).collect();
    check("disk", &expected, |x| {
        let p = concentric_disk(x);
        let turn = (p.y.atan2(p.x) / TAU).rem_euclid(1.0);
        ((p.length() * 10.0) as usize).min(9) * 12 + ((turn * 12.0) as usize).min(11)
    });
}

#[test]
fn triangle_is_uniform_in_area() {
    // Squares of side 1/10 in two of the weights; those on the diagonal are cut in half.
    let expected: Vec<f64> = (0..100)
        .map(|i| match i / 10 + i % 10 {
            0..=8 => 0.02,
            9 => 0.01,
            _ => 0.0,
        })
        .collect();
    check("triangle", &expected, |x| {
        let [a, b, c] = triangle(x);
        assert!(a >= 0.0 && b >= 0.0 && c >= 0.0);
        ((a * 10.0) as usize).min(9) * 10 + ((b * 10.0) as usize).min(9)
    });
}

#[test]
fn polygon_of_four_blades_is_a_uniform_square() {
    check("polygon", &[0.01; 100], |x| {
        let p = regular_polygon(x, 4);
        // Rotated by 45 degrees, the square spans [-1, 1]^2 / sqrt(2); |x + y| <= 1.
        let q = 0.5 * DVec2::new(p.x + p.y, p.y - p.x) + 0.5;
        ((q.x * 10.0) as usize).min(9) * 10 + ((q.y * 10.0) as usize).min(9)
    });
    assert_eq!(regular_polygon(DVec2::splat(0.5), 2), DVec2::ZERO);
}

#[test]
fn polygons_have_the_moment_of_their_sides_and_fill_them() {
    // Mean of |p|^2 over a regular polygon with corners on the unit circle: (2 + cos(2 pi / n)) / 6.
    for n in [3_u32, 5, 8] {
        let points = (0..SAMPLES).map(|i| regular_polygon(xi(i), n));
        let (sum, squares, largest) = points
            .map(|p| p.length_squared())
            .fold((0.0, 0.0, 0.0_f64), |a, r| (a.0 + r, a.1 + r * r, a.2.max(r)));
        let mean = sum / SAMPLES as f64;
        let error = ((squares / SAMPLES as f64 - mean * mean) / SAMPLES as f64).sqrt();
        let expected = (2.0 + (TAU / f64::from(n)).cos()) / 6.0;
        assert!((mean - expected).abs() < 4.0 * error, "{n}: {mean} {expected}");
        assert!(largest <= 1.0 + 1e-12 && largest > 0.98);
    }
}

#[test]
fn tent_follows_its_density() {
    let expected: Vec<f64> = (0..30)
        .map(|i| {
            let low = -1.5 + 0.1 * f64::from(i);
            integral(low, low + 0.1, |x| tent_pdf(x, 1.5))
        })
        .collect();
    check("tent", &expected, |x| (((tent(x.x, 1.5) + 1.5) * 10.0) as usize).min(29));
}

#[test]
fn tiniest_cones_keep_their_shape() {
    for half_angle in [1e-4_f64, 1e-9, 1e-150] {
        let sin2 = half_angle.sin().powi(2);
        let drop = one_minus_cos(sin2);
        // 1 - cos = angle^2 / 2 up to terms of angle^4.
        assert!((drop / (0.5 * half_angle * half_angle) - 1.0).abs() < 1e-8);
        assert!((uniform_cone_pdf(drop).0 * PI * half_angle * half_angle - 1.0).abs() < 1e-8);
        check(&format!("cone {half_angle}"), &[0.01; 100], |x| {
            let w = uniform_cone(x, drop);
            // Uniform in solid angle is, for such cones, uniform in the squared distance from the axis.
            let ring = (w.x * w.x + w.y * w.y) / sin2;
            assert!(ring < 1.0 + 1e-9);
            let turn = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
            ((ring * 10.0) as usize).min(9) * 10 + ((turn * 10.0) as usize).min(9)
        });
    }
    assert!((one_minus_cos(1.0) - 1.0).abs() < 1e-15);
}

#[test]
fn inverses_undo_warps() {
    let near = |name: &str, back: DVec2, x: DVec2, tolerance: f64| {
        assert!((back - x).abs().max_element() < tolerance, "{name}: {x} came back as {back}");
    };
    for i in 0..5000 {
        // Away from the border, where a turn of 0 may come back as a turn of 1.
        let x = 0.001 + 0.998 * xi(i);
        near("disk", concentric_disk_inverse(concentric_disk(x)), x, 1e-14);
        near("cosine", cosine_hemisphere_inverse(cosine_hemisphere(x)), x, 1e-14);
        near("sphere", uniform_sphere_inverse(uniform_sphere(x)), x, 1e-14);
        near("hemisphere", uniform_hemisphere_inverse(uniform_hemisphere(x)), x, 1e-14);
        near("triangle", triangle_inverse(triangle(x)), x, 1e-14);
        near("phong", phong_lobe_inverse(phong_lobe(x, 30.0), 30.0), x, 1e-12);
        for drop in [1e-18, 1e-3, 0.4, 1.7] {
            near("cone", uniform_cone_inverse(uniform_cone(x, drop), drop), x, 1e-12);
        }
        assert!((tent_inverse(tent(x.x, 2.0), 2.0) - x.x).abs() < 1e-14);
    }
}

#[test]
fn corners_of_the_square_give_directions() {
    let last = 1.0 - f64::EPSILON / 2.0;
    for x in [0.0, 0.5, last, 1.0] {
        for y in [0.0, 0.5, last, 1.0] {
            let x = DVec2::new(x, y);
            for w in [cosine_hemisphere(x), uniform_sphere(x), uniform_hemisphere(x), phong_lobe(x, 5.0)] {
                assert!((w.length() - 1.0).abs() < 1e-14, "{x}: {w}");
            }
            assert!(cosine_hemisphere(x).z > 0.0);
            assert!(concentric_disk(x).length() <= 1.0 + 1e-15);
        }
    }
}

#[test]
fn equal_area_map_preserves_areas_and_is_invertible() {
    // Centroids of octants, known from symmetry, and every direction back to itself.
    let n = 256;
    let mut octants = [(0, DVec3::ZERO); 8];
    for i in 0..n * n {
        let place = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
        let direction = equal_area_sphere(place);
        assert!((direction.length() - 1.0).abs() < 1e-14);
        assert!((equal_area_sphere_inverse(direction) - place).length() < 1e-12, "{place}");
        let octant = usize::from(direction.x < 0.0)
            + 2 * usize::from(direction.y < 0.0)
            + 4 * usize::from(direction.z < 0.0);
        octants[octant].0 += 1;
        octants[octant].1 += direction.abs();
    }
    for (count, sum) in octants {
        // The diamond's border crosses cells of the grid: of those on the diagonal, half are on either side.
        assert!((f64::from(count) / f64::from(n * n / 8) - 1.0).abs() < 0.01, "{count}");
        // Each coordinate is uniform over a sphere (Archimedes): its mean over an octant is 1/2.
        assert!((sum / f64::from(count) - 0.5).abs().max_element() < 0.005, "{sum}");
    }
    for pole in [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y] {
        assert!((equal_area_sphere(equal_area_sphere_inverse(pole)) - pole).length() < 1e-7);
    }
}
