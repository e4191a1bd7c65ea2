//! The surfaces of the collection.

use std::f64::consts::FRAC_1_SQRT_2;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::files::bicubic_patches;
use super::rays::Random;
use super::test_surface::{TestSurface, net};

/// All built-in surfaces.
pub fn all() -> Vec<TestSurface> {
    let mut all = vec![teapot(), sphere(), torus()];
    all.extend([
        ball("sphere, 1e-3", 1e-3, DVec3::splat(2e-3)),
        ball("sphere, 1e4", 1e4, DVec3::ZERO),
        ball("sphere, far away", 1.0, DVec3::new(-600.0, 700.0, 400.0)),
    ]);
    all.extend(by_degree());
    all.extend(triangles());
    all.extend(weights());
    all.extend(degenerate());
    all.extend(folded());
    all.extend(flat());
    all
}

/// The unit sphere, eight rational patches.
pub fn sphere() -> TestSurface {
    ball("sphere", 1.0, DVec3::ZERO)
}

/// Bicubic patches of a file.
pub fn of_file(path: &str) -> TestSurface {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let patches = bicubic_patches(&text).unwrap_or_else(|why| panic!("{path}: {why}"));
    let name = path.rsplit('/').next().unwrap_or(path);
    TestSurface::of_nets(name, patches.into_iter().map(|points| ((3, 3), points)).collect())
}

fn teapot() -> TestSurface {
    of_file(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/newell_teapot.txt"))
}

/// A quarter of the unit circle, homogeneous (w x, w y, w), exact at both ends.
fn quarter(index: usize) -> [DVec3; 3] {
    let unit = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let (a, b) = (unit[index % 4], unit[(index + 1) % 4]);
    [a.extend(1.0), ((a + b) * FRAC_1_SQRT_2).extend(FRAC_1_SQRT_2), b.extend(1.0)]
}

/// The surface of revolution of profiles (w r, w z, w) about the z axis, moved by `offset`.
fn revolved(name: &str, profiles: &[[DVec3; 3]], offset: DVec3) -> TestSurface {
    let nets = profiles.iter().flat_map(|profile| {
        (0..4).map(move |k| {
            let points = quarter(k).into_iter().flat_map(|around| {
                profile.map(|p| {
                    let w = p.z * around.z;
                    let point = DVec3::new(around.x * p.x, around.y * p.x, p.y * around.z);
                    (point + offset * w).extend(w)
                })
            });
            ((2, 2), points.collect())
        })
    });
    TestSurface::of_nets(name, nets.collect())
}

fn ball(name: &str, radius: f64, offset: DVec3) -> TestSurface {
    let profile = |k| quarter(k).map(|p| DVec3::new(p.x * radius, p.y * radius, p.z));
    revolved(name, &[profile(3), profile(0)], offset)
}

fn torus() -> TestSurface {
    let tube = |k| quarter(k).map(|p| DVec3::new(p.z + 0.4 * p.x, 0.4 * p.y, p.z));
    revolved("torus", &[0, 1, 2, 3].map(tube), DVec3::ZERO)
}

/// A point of a wavy plate over the unit square with some noise, without weight.
fn wavy(random: &mut Random, height: f64, x: f64, y: f64) -> DVec3 {
    let z = height * (7.0 * x + 1.0).sin() * (5.0 * y + 0.5).cos();
    DVec3::new(x, y, z) + random.direction() * (0.15 * height)
}

fn by_degree() -> Vec<TestSurface> {
    let pairs =
        [(1, 1), (1, 2), (2, 1), (2, 2), (3, 3), (1, 5), (4, 2), (5, 5), (3, 7), (9, 1), (6, 8), (9, 9)];
    let tested = |(p, q): (usize, usize)| {
        let mut random = Random::new((10 * p + q) as u64);
        let nets = (0..3).map(|k| {
            let height = [0.2, 0.6, 1.5][k];
            let point = |x, y| (wavy(&mut random, height, x, y) + DVec3::X * k as f64).extend(1.0);
            ((p, q), net((p, q), point))
        });
        TestSurface::of_nets(format!("degrees {p} and {q}"), nets.collect())
    };
    pairs.into_iter().map(tested).collect()
}

/// Triangular patches over the two halves of the unit square, with the control points of the diagonal in common.
fn triangles() -> Vec<TestSurface> {
    let pair = |degree: usize, weight: &dyn Fn(f64, f64) -> f64, name: String| {
        let mut patches = Vec::new();
        for upper in [false, true] {
            let mut points = Vec::new();
            for i in (0..=degree).rev() {
                for j in (0..=degree - i).rev() {
                    let n = degree as f64;
                    let (s, t) = (j as f64 / n, (degree - i - j) as f64 / n);
                    // The second one is turned about the middle of the square: the diagonal goes onto itself.
                    let (x, y) = if upper { (1.0 - s, 1.0 - t) } else { (s, t) };
                    let z = 0.5 * (6.0 * x).sin() * (1.0 + 4.0 * y).cos();
                    let w = weight(x, y);
                    points.push((DVec3::new(x, y, z) * w).extend(w));
                }
            }
            patches.push((degree, points));
        }
        TestSurface::triangles(name, patches)
    };
    let mut out: Vec<TestSurface> =
        (1..=6).map(|n| pair(n, &|_, _| 1.0, format!("triangles of degree {n}"))).collect();
    for n in [2, 3, 5] {
        let bell = |x: f64, y: f64| 1.0 + 20.0 * (-8.0 * ((x - 0.4).powi(2) + (y - 0.5).powi(2))).exp();
        out.push(pair(n, &bell, format!("rational triangles of degree {n}")));
    }
    out
}

fn weights() -> Vec<TestSurface> {
    let plate = |name: &str, degrees, weight: &mut dyn FnMut(f64, f64) -> f64| {
        let mut random = Random::new(77);
        TestSurface::tensor(name, degrees, |x, y| {
            let w = weight(x, y);
            (wavy(&mut random, 0.5, x, y) * w).extend(w)
        })
    };
    let mut random = Random::new(78);
    vec![
        plate("weights 1 to 1000, smooth", (4, 4), &mut |x, y| {
            1e3_f64.powf((3.0 * x).sin().abs() * (2.0 * y).sin().abs())
        }),
        plate("weights 1e-3 to 1e3, graded", (3, 3), &mut |x, y| 10_f64.powf(3.0 * (x + y) - 3.0)),
        plate("weights 1e-3 to 1e3, wild bicubic", (3, 3), &mut |_, _| random.magnitude(-3.0, 3.0)),
        plate("weights 1e-3 to 1e3, wild degree 6", (6, 6), &mut |_, _| random.magnitude(-3.0, 3.0)),
        plate("weights all 1000", (3, 2), &mut |_, _| 1e3),
    ]
}

fn degenerate() -> Vec<TestSurface> {
    let plain = |x: f64, y: f64, z: f64| DVec4::new(x, y, z, 1.0);
    let dome = |x: f64, y: f64| 1.5 * x * (1.0 - x) + y * (1.0 - y) - x * y;
    let one = |name: &str, map: &dyn Fn(f64, f64) -> DVec4| TestSurface::tensor(name, (3, 3), map);
    // Maps parameters so that control points coincide.
    let pull = |x: f64| if x < 0.5 { 0.0 } else { x };
    vec![
        one("coincident control points", &|x, y| plain(pull(x), pull(1.0 - y), dome(x, pull(y)))),
        one("collapsed edge", &|x, y| plain(x * (0.5 - y), x, 0.7 * x * x * (1.0 + y))),
        one("two collapsed edges", &|x, y| plain(x * (1.0 - x) * (y - 0.5) * 4.0, x, dome(x, 0.5))),
        one("two edges on one line", &|x, y| {
            if x == 0.0 {
                plain(0.0, y, 0.0)
            } else if y == 0.0 {
                plain(0.0, x, 0.0)
            } else {
                plain(x, y, dome(x, y))
            }
        }),
        // The first derivative along u vanishes at u = 1/2: control points 0, 1, 0, 1 and a cusp between.
        one("cusp", &|x, y| {
            let k = (3.0 * x).round() as usize;
            plain([0.0, 1.0, 0.0, 1.0][k], y, [0.0, 1.0, 1.0, 0.0][k])
        }),
        one("loop", &|x, y| {
            let k = (3.0 * x).round() as usize;
            plain([0.0, 1.6, -0.6, 1.0][k], y + 0.2 * x, [0.0, 1.0, 1.0, 0.1][k])
        }),
        one("crossed corners", &|x, y| plain(x + y, (1.0 - 2.0 * x) * (1.0 - 2.0 * y), dome(x, y) * (x - y))),
        one("border that runs back", &|x, y| {
            let k = (3.0 * x).round() as usize;
            plain([0.0, 0.9, 0.1, 1.0][k], y, 0.3 * y * [1.0, -1.0, 2.0, 0.5][k])
        }),
    ]
}

/// Product of two polynomials in Bernstein form, coefficients (i, j) at i (q + 1) + j.
fn product(f: &[f64], (p, q): (usize, usize), g: &[f64], (r, s): (usize, usize)) -> Vec<f64> {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let mut out = vec![0.0; (p + r + 1) * (q + s + 1)];
    for (a, x) in f.iter().enumerate() {
        for (b, y) in g.iter().enumerate() {
            let (i, j, k, l) = (a / (q + 1), a % (q + 1), b / (s + 1), b % (s + 1));
            let share = choose(p, i) * choose(r, k) / choose(p + r, i + k) * choose(q, j) * choose(s, l)
                / choose(q + s, j + l);
            out[(i + k) * (q + s + 1) + j + l] += share * x * y;
        }
    }
    out
}

/// A bicubic patch that the z axis meets 18 times, as often as two curves of degrees (3, 3) can cross: x is the product of
/// three hyperbolas in the parameters, y of three that bend the other way, and each of the first crosses each of the second
/// twice.
pub fn eighteen() -> TestSurface {
    let hyperbola = |offset: f64, k: f64| -> Vec<f64> {
        [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]
            .map(|(u, v): (f64, f64)| (u - offset).abs() * (v - offset).abs() - k)
            .to_vec()
    };
    let three = |offset: f64, ks: [f64; 3]| {
        let [a, b, c] = ks.map(|k| hyperbola(offset, k));
        product(&product(&a, (1, 1), &b, (1, 1)), (2, 2), &c, (1, 1))
    };
    let x = three(-0.1, [0.25, 0.2809, 0.3136]);
    let y = three(1.1, [0.3136, 0.2809, 0.25]);
    let scale = |list: &[f64]| 1.0 / list.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    let (by_x, by_y) = (scale(&x), scale(&y));
    TestSurface::tensor("eighteen roots", (3, 3), |u, v| {
        let k = (3.0 * u).round() as usize * 4 + (3.0 * v).round() as usize;
        DVec4::new(x[k] * by_x, y[k] * by_y, u - v, 1.0)
    })
}

fn folded() -> Vec<TestSurface> {
    // x and y run back and forth three times: nine sheets.
    let fold = |t: f64| [0.0, 2.2, -1.2, 1.0][(3.0 * t).round() as usize];
    let mut random = Random::new(5);
    vec![
        eighteen(),
        TestSurface::tensor("nine sheets", (3, 3), |x, y| DVec4::new(fold(x), fold(y), x + 0.5 * y, 1.0)),
        TestSurface::tensor("crumpled, degrees 7 and 7", (7, 7), |_, _| random.direction().extend(1.0)),
        TestSurface::tensor("crumpled, rational", (4, 5), |_, _| {
            let w = random.magnitude(-1.0, 1.0);
            (random.direction() * w).extend(w)
        }),
    ]
}

fn flat() -> Vec<TestSurface> {
    let plate = |name: &str, height: f64, size: f64, offset: DVec3| {
        let mut random = Random::new(9);
        TestSurface::tensor(name, (3, 3), |x, y| {
            let p = DVec3::new(x, y, height * (random.unit() - 0.5)) * size + offset;
            p.extend(1.0)
        })
    };
    let zero = DVec3::ZERO;
    vec![
        plate("flat", 0.0, 1.0, zero),
        plate("flat but for 1e-6", 1e-6, 1.0, zero),
        plate("flat but for 1e-10", 1e-10, 1.0, zero),
        plate("flat but for 1e-14", 1e-14, 1.0, zero),
        plate("plate, 1e-3", 0.8, 1e-3, zero),
        plate("plate, 1e4", 0.8, 1e4, zero),
        plate("plate, far away", 0.8, 1.0, DVec3::new(900.0, -300.0, 500.0)),
        TestSurface::tensor("flat and inclined", (2, 2), |x, y| {
            DVec4::new(x + 0.3 * y, y - 0.2 * x * x, 0.4 * x + 0.7 * y, 1.0)
        }),
    ]
}
