//! Bézier patches: graphs of polynomials of many degrees, and surfaces of revolution as rational patches.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glanz_geometry::bezier::TensorPatch;
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_math::glam::DVec4;
use glanz_math::{DMat3, DVec2, DVec3, Ray};

use super::case::ContractCase;
use super::harness::check_kind;

fn choose(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}

/// The polynomial with Bernstein coefficients `c`, that of (i, j) at i (q + 1) + j, by its definition.
fn value(c: &[f64], (p, q): (usize, usize), x: f64, y: f64) -> f64 {
    let basis = |n: usize, x: f64| -> [f64; 10] {
        std::array::from_fn(|i| {
            if i > n { 0.0 } else { choose(n, i) * x.powi(i as i32) * (1.0 - x).powi((n - i) as i32) }
        })
    };
    let (bx, by) = (basis(p, x), basis(q, y));
    c.iter().enumerate().map(|(k, &c)| c * bx[k / (q + 1)] * by[k % (q + 1)]).sum()
}

/// The graph z = f(x, y) over the unit square, mapped by `m` and moved by `offset`.
fn graph(name: &str, degrees: (usize, usize), c: Vec<f64>, m: DMat3, offset: DVec3) -> ContractCase {
    let (p, q) = degrees;
    let place = move |x: f64, y: f64, z: f64| offset + m * DVec3::new(x, y, z);
    let points = c.iter().enumerate().map(|(k, &c)| {
        place((k / (q + 1)) as f64 / p as f64, (k % (q + 1)) as f64 / q as f64, c).extend(1.0)
    });
    let patch = TensorPatch::try_new(p, q, points.collect()).unwrap();
    let piece = SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap();
    let back = m.inverse();
    let (c1, c2) = (c.clone(), c);
    let at = move |x: f64, y: f64| place(x, y, value(&c1, degrees, x, y));
    let center = at(0.5, 0.5);
    let grid = (0..=20).flat_map(|i| (0..=20).map(move |j| (f64::from(i) / 20.0, f64::from(j) / 20.0)));
    let radius = grid.map(|(x, y)| at(x, y).distance(center)).fold(0.0, f64::max);
    let unit = m.x_axis.length().min(m.y_axis.length());
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| at(x, y));
    ContractCase {
        kept: Box::new(move |p| {
            let q = back * (p - offset);
            q.x.min(1.0 - q.x).min(q.y).min(1.0 - q.y) * unit
        }),
        center,
        size: 1.1 * radius,
        resolution: 150,
        // Corners, the middle, where leaves meet, and chords of the borders.
        targets: vec![
            [corners[0]; 2],
            [corners[2]; 2],
            [center; 2],
            [at(0.25, 0.5); 2],
            [corners[0], corners[1]],
            [corners[1], corners[2]],
        ],
        directions: vec![m.x_axis, m.y_axis, m.z_axis, m.x_axis + m.z_axis * 1e-9],
        position: Some(Box::new(move |uv: DVec2| at(uv.x, uv.y))),
        ..ContractCase::new(name, Freeform::try_new(vec![piece]).unwrap(), move |p| {
            let q = back * (p - offset);
            (q.z - value(&c2, degrees, q.x, q.y)) * m.z_axis.length()
        })
    }
}

/// Irregular wavy coefficients.
fn waves(degrees: (usize, usize), height: f64) -> Vec<f64> {
    (0..(degrees.0 + 1) * (degrees.1 + 1)).map(|k| height * (2.4 * k as f64 + 0.3).sin()).collect()
}

#[test]
fn graphs_of_polynomials_keep_the_contract() {
    let m = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| DMat3::from_cols(x.into(), y.into(), z.into());
    let skew = m([1.0, 0.2, -0.3], [-0.4, 1.3, 0.1], [0.5, -0.2, 0.9]);
    let one = DMat3::IDENTITY;
    let cases = [
        graph("bicubic", (3, 3), waves((3, 3), 0.7), one, DVec3::ZERO),
        graph("steep bicubic", (3, 3), waves((3, 3), 6.0), skew, DVec3::new(3.0, -5.0, 2.0)),
        graph("grain", (3, 3), waves((3, 3), 0.5), one * 1e-3, DVec3::splat(1e-3)),
        graph("plane", (3, 3), vec![0.0; 16], skew, DVec3::ONE),
        graph("bilinear", (1, 1), vec![0.0, 0.5, 0.3, -0.6], skew, DVec3::ZERO),
        graph("biquadratic", (2, 2), waves((2, 2), 1.0), one, DVec3::ZERO),
        graph("degrees 4 and 2", (4, 2), waves((4, 2), 1.0), skew, DVec3::ZERO),
        graph("degrees 1 and 7", (1, 7), waves((1, 7), 1.0), one, DVec3::ZERO),
        graph("degree 9", (9, 9), waves((9, 9), 0.4), one, DVec3::ZERO),
    ];
    check_kind("polynomial patch", 41, &cases);
}

/// The quarter of the unit circle in quadrant `index`, homogeneous (w x, w y, w).
fn quarter(index: usize) -> [DVec3; 3] {
    // Exact at the quarters, so that neighbours have the same bits.
    let unit = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let (a, b) = (unit[index % 4], unit[(index + 1) % 4]);
    let middle = (a + b) * FRAC_1_SQRT_2;
    [a.extend(1.0), middle.extend(FRAC_1_SQRT_2), b.extend(1.0)]
}

/// Patches of the surface that a profile (w r, w z, w) makes around the z axis.
fn revolved(profiles: &[[DVec3; 3]]) -> Freeform {
    let pieces = profiles.iter().flat_map(|profile| {
        (0..4).map(move |k| {
            let points = quarter(k).into_iter().flat_map(|around| {
                profile.map(|p| DVec4::new(around.x * p.x, around.y * p.x, p.y * around.z, p.z * around.z))
            });
            let patch = TensorPatch::try_new(2, 2, points.collect()).unwrap();
            SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
        })
    });
    Freeform::try_new(pieces.collect()).unwrap()
}

fn ball(radius: f64, stretch: f64) -> ContractCase {
    // From the south pole to the equator to the north pole; a projective map of the parameters changes weights only.
    let profile = |points: [DVec3; 3]| {
        let mut share = 1.0;
        points.map(|p| {
            let scaled = DVec3::new(p.x * radius, p.y * radius, p.z) * share;
            share *= stretch;
            scaled
        })
    };
    let surface = revolved(&[profile(quarter(3)), profile(quarter(0))]);
    let poles = [DVec3::Z * radius, DVec3::NEG_Z * radius];
    ContractCase {
        size: radius,
        area: Some(4.0 * PI * radius * radius),
        convex: true,
        parameter_singular: poles.to_vec(),
        targets: vec![[poles[0]; 2], [poles[1]; 2], [DVec3::X * radius; 2], [poles[0], DVec3::X * radius]],
        directions: vec![DVec3::X, DVec3::Z],
        ..ContractCase::new(format!("ball {radius} {stretch}"), surface, move |p| {
            p.length_squared() / radius - radius
        })
    }
}

#[test]
fn rational_patches_keep_the_contract() {
    let (major, minor) = (1.0, 0.4);
    let tube: Vec<[DVec3; 3]> =
        (0..4).map(|k| quarter(k).map(|p| DVec3::new(major * p.z + minor * p.x, minor * p.y, p.z))).collect();
    let torus = ContractCase {
        size: major + minor,
        area: Some(4.0 * PI * PI * major * minor),
        resolution: 100,
        targets: vec![[DVec3::X * (major + minor); 2], [DVec3::X * (major - minor), DVec3::Y * major]],
        directions: vec![DVec3::X, DVec3::Z],
        ..ContractCase::new("torus", revolved(&tube), move |p| {
            let r = p.truncate().length() - major;
            r * r + p.z * p.z - minor * minor
        })
    };
    let cases = [ball(1.0, 1.0), ball(1e-2, 1.0), ball(3.0, 5.0), ball(1.0, 0.03), torus];
    check_kind("rational patch", 42, &cases);
}

#[test]
fn rays_that_graze_a_pole_meet_it_once() {
    let rays = [
        (
            ball(1.0, 1.0),
            [-7857.0885668729625, -3397.674109141398, -70.38267682826515],
            [100.60954943549869, 43.507013869060096, 0.8884410293848527],
        ),
        (
            ball(1.0, 0.03),
            [24509.413760907642, 41144.59356543838, 288.5162248701069],
            [-0.031365777588372876, -0.05265455075045201, -0.00037050667984499496],
        ),
    ];
    for (case, origin, direction) in rays {
        let ray = Ray::new(origin.into(), direction.into());
        let mut hits = Vec::new();
        case.surface.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), 2, "{}: {hits:?}", case.name);
    }
}
