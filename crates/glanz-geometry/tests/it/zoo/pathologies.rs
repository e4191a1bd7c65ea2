//! Sixty pathological surfaces, and the cost of the hardest rays through each.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::collection;
use super::rays::Random;
use super::test_surface::{TestSurface, net};

/// Kinds of pathologies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Degrees from 10 to 25.
    HighDegree,
    /// Without area, in whole or in part.
    ZeroArea,
    /// Edges or interior lines that are points.
    Collapsed,
    /// Points where the derivatives vanish or are parallel.
    Singular,
    /// Sheets that cross, touch or coincide.
    ManySheets,
    /// Flat, or almost.
    Flat,
    /// Extreme ratios of weights.
    Weights,
    /// Much longer than wide.
    Sliver,
    /// Asymptotic directions and straight lines in the surface.
    Ruled,
    /// Closed surfaces of CAD.
    Revolved,
    /// Discontinuous derivatives.
    Crease,
    /// Extreme sizes and distances.
    Place,
}

/// A patch of these degrees with the control points that `map` gives, without weights.
fn plain(degrees: (usize, usize), map: impl Fn(f64, f64) -> DVec3) -> Net {
    (degrees, net(degrees, |x, y| map(x, y).extend(1.0)))
}

type Net = ((usize, usize), Vec<DVec4>);

fn wavy(degrees: (usize, usize), height: f64) -> Net {
    let mut random = Random::new((100 * degrees.0 + degrees.1) as u64);
    let map = |x: f64, y: f64| {
        let z = height * (7.0 * x + 1.0).sin() * (5.0 * y + 0.5).cos();
        DVec3::new(x, y, z) + random.direction() * (0.05 * height)
    };
    let mut map = map;
    (degrees, net(degrees, |x, y| map(x, y).extend(1.0)))
}

/// A monomial patch: (x, y, z) by coefficients of u^i v^j, exact up to rounding, of these degrees.
fn monomials((p, q): (usize, usize), terms: &[(usize, usize, DVec3)]) -> Net {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n as f64 - i as f64) / (i + 1) as f64);
    let power = |degree: usize, k: usize, of: usize| choose(k, of) / choose(degree, of);
    let mut points = Vec::new();
    for i in 0..=p {
        for j in 0..=q {
            let sum: DVec3 = terms.iter().map(|&(a, b, c)| c * (power(p, i, a) * power(q, j, b))).sum();
            points.push(sum.extend(1.0));
        }
    }
    ((p, q), points)
}

/// z = f(x, y) over [-1, 1]^2 for a polynomial f: coefficients of x^i y^j.
fn graph(degrees: (usize, usize), f: &[(usize, usize, f64)]) -> Net {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n as f64 - i as f64) / (i + 1) as f64);
    let mut terms = vec![
        (0, 0, DVec3::new(-1.0, -1.0, 0.0)),
        (1, 0, DVec3::new(2.0, 0.0, 0.0)),
        (0, 1, DVec3::new(0.0, 2.0, 0.0)),
    ];
    for &(a, b, c) in f {
        // (2 u - 1)^a (2 v - 1)^b.
        for i in 0..=a {
            for j in 0..=b {
                let sign = if (a - i + b - j) % 2 == 0 { 1.0 } else { -1.0 };
                let factor = choose(a, i) * choose(b, j) * f64::from(1 << (i + j)) * sign;
                terms.push((i, j, DVec3::Z * (c * factor)));
            }
        }
    }
    monomials(degrees, &terms)
}

fn weighted(
    degrees: (usize, usize),
    map: impl Fn(f64, f64) -> DVec3,
    mut weight: impl FnMut(f64, f64) -> f64,
) -> Net {
    (
        degrees,
        net(degrees, |x, y| {
            let w = weight(x, y);
            (map(x, y) * w).extend(w)
        }),
    )
}

/// A quarter of the unit circle, homogeneous (w x, w y, w).
fn quarter(index: usize) -> [DVec3; 3] {
    let unit = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let (a, b) = (unit[index % 4], unit[(index + 1) % 4]);
    [a.extend(1.0), ((a + b) * FRAC_1_SQRT_2).extend(FRAC_1_SQRT_2), b.extend(1.0)]
}

/// Surface of revolution of a profile (w r, w z, w), four patches.
fn revolved(profile: &[DVec3], turn: impl Fn(DVec3) -> DVec3) -> Vec<Net> {
    let patch = |k: usize| {
        let points = quarter(k).into_iter().flat_map(|around| {
            let turn = &turn;
            profile.iter().map(move |p| {
                let w = p.z * around.z;
                let point = DVec3::new(around.x * p.x, around.y * p.x, p.y * around.z) / w;
                (turn(point) * w).extend(w)
            })
        });
        ((2, profile.len() - 1), points.collect())
    };
    (0..4).map(patch).collect()
}

fn unturned(p: DVec3) -> DVec3 {
    p
}

/// A rotation by an angle that no coordinate plane keeps.
fn turned(p: DVec3) -> DVec3 {
    let (s, c) = 0.7_f64.sin_cos();
    let p = DVec3::new(c * p.x - s * p.z, p.y, s * p.x + c * p.z);
    DVec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z)
}

fn moved(nets: Vec<Net>, scale: f64, offset: DVec3) -> Vec<Net> {
    let change = |p: &DVec4| (p.truncate() * scale + offset * p.w).extend(p.w);
    nets.into_iter().map(|(degrees, points)| (degrees, points.iter().map(change).collect())).collect()
}

/// The surfaces with their kinds.
pub fn all() -> Vec<(SurfaceKind, TestSurface)> {
    let mut all = Vec::new();
    let v3 = DVec3::new;
    let dome = |x: f64, y: f64| 1.5 * x * (1.0 - x) + y * (1.0 - y) - x * y;
    // Index of a control point of a cubic.
    let of4 = |x: f64, list: [f64; 4]| list[(3.0 * x).round() as usize];
    let mut add =
        |kind: SurfaceKind, name: &str, nets: Vec<Net>| all.push((kind, TestSurface::of_nets(name, nets)));
    {
        use SurfaceKind::HighDegree as Kind;
        add(Kind, "wavy, degrees 10 and 10", vec![wavy((10, 10), 0.4)]);
        add(Kind, "wavy, degrees 20 and 20", vec![wavy((20, 20), 0.4)]);
        add(Kind, "wavy, degrees 25 and 25", vec![wavy((25, 25), 0.4)]);
        add(Kind, "wavy, degrees 20 and 1", vec![wavy((20, 1), 0.4)]);
        let mut random = Random::new(12);
        add(
            Kind,
            "crumpled, degree 12",
            vec![((12, 12), net((12, 12), |_, _| random.direction().extend(1.0)))],
        );
        add(
            Kind,
            "rational, degree 12",
            vec![weighted(
                (12, 12),
                |x, y| v3(x, y, 0.5 * dome(x, y)),
                |x, y| 1.0 + 0.5 * (9.0 * x + 4.0 * y).sin(),
            )],
        );
        add(
            Kind,
            "plane of degree 20, coincident points",
            vec![plain((20, 20), |x, y| {
                v3(if x < 0.5 { 0.0 } else { x }, if y > 0.6 { 1.0 } else { y }, 0.0)
            })],
        );
        add(Kind, "plane of degree 20, evenly", vec![plain((20, 20), |x, y| v3(x, y, 0.3 * x + 0.2 * y))]);
        add(Kind, "paraboloid of degree 20", vec![graph((20, 20), &[(2, 0, 1.0), (0, 2, 1.0)])]);
    }
    {
        use SurfaceKind::ZeroArea as Kind;
        add(Kind, "line", vec![plain((3, 3), |x, y| v3(x + 0.3 * y, 0.5 * x + 0.15 * y, 0.0))]);
        add(Kind, "cubic curve", vec![plain((3, 3), |x, _| v3(x, dome(x, 0.2), x * x * x))]);
        add(Kind, "curve of degree 20", vec![plain((20, 20), |x, _| v3(x, dome(x, 0.2), (3.0 * x).sin()))]);
        add(
            Kind,
            "point beside a patch",
            vec![plain((3, 3), |_, _| v3(0.2, 0.3, 0.1)), plain((3, 3), |x, y| v3(x, y, dome(x, y)))],
        );
        add(
            Kind,
            "curve beside a patch",
            vec![plain((3, 3), |_, y| v3(0.0, y, 0.0)), plain((3, 3), |x, y| v3(x, y, x * dome(x, y)))],
        );
        add(
            Kind,
            "strip folded onto itself",
            vec![plain((2, 1), |x, y| v3(x * (1.0 - x), y, 2.0 * x * (1.0 - x)))],
        );
        add(
            Kind,
            "bilinear with three points on a line",
            vec![plain((1, 1), |x, y| v3(x + y, x + y, if x * y > 0.5 { 1.0 } else { 0.0 }))],
        );
    }
    {
        use SurfaceKind::Collapsed as Kind;
        add(Kind, "one edge", vec![plain((3, 3), |x, y| v3(x * (0.5 - y), x, 0.7 * x * x * (1.0 + y)))]);
        add(
            Kind,
            "two opposite edges",
            vec![plain((3, 3), |x, y| v3(x * (1.0 - x) * (y - 0.5) * 4.0, x, dome(x, 0.5)))],
        );
        add(Kind, "two adjacent edges", vec![plain((3, 3), |x, y| v3(x * y, x * y * y, x * x * y))]);
        add(
            Kind,
            "three edges",
            vec![plain((4, 4), |x, y| v3(x * y * (1.0 - y), x * x * y * (1.0 - y), x * y * y * (1.0 - y)))],
        );
        add(
            Kind,
            "four edges",
            vec![plain((4, 4), |x, y| {
                let b = x * (1.0 - x) * y * (1.0 - y);
                v3(b * (x - 0.5), b * (y - 0.5), b) * 16.0
            })],
        );
        add(
            Kind,
            "pole with a cusp",
            vec![plain((3, 3), |x, y| v3(x * x * (0.5 - y), x * x * x, x * x * y))],
        );
        add(
            Kind,
            "apex of degree 10",
            vec![plain((10, 10), |x, y| v3(x * (TAU * 0.2 * y).cos(), x * (TAU * 0.2 * y).sin(), 1.2 * x))],
        );
        add(Kind, "cone", revolved(&[v3(0.0, 0.0, 1.0), v3(1.0, 1.0, 1.0)], unturned));
        add(
            Kind,
            "turned cone, degree 2 along",
            revolved(&[v3(0.0, 0.0, 1.0), v3(0.5, 0.5, 1.0), v3(1.0, 1.0, 1.0)], turned),
        );
        add(Kind, "double cone, apex inside", revolved(&[v3(-1.0, -1.0, 1.0), v3(1.0, 1.0, 1.0)], turned));
    }
    {
        use SurfaceKind::Singular as Kind;
        add(
            Kind,
            "cusp",
            vec![plain((3, 3), |x, y| v3(of4(x, [0.0, 1.0, 0.0, 1.0]), y, of4(x, [0.0, 1.0, 1.0, 0.0])))],
        );
        add(
            Kind,
            "cuspidal edge",
            vec![monomials(
                (3, 1),
                &[(0, 1, DVec3::Y), (2, 0, DVec3::X), (3, 0, DVec3::Z), (0, 0, v3(0.1, 0.0, 0.0))],
            )],
        );
        add(
            Kind,
            "swallow's tail",
            vec![monomials(
                (4, 1),
                &[
                    (0, 1, DVec3::X),
                    (3, 0, DVec3::Y * 4.0),
                    (1, 1, DVec3::Y * 2.0),
                    (4, 0, DVec3::Z * 3.0),
                    (2, 1, DVec3::Z),
                ],
            )],
        );
        add(
            Kind,
            "Whitney's umbrella",
            vec![monomials(
                (2, 2),
                &[
                    (1, 1, DVec3::X * 4.0),
                    (0, 1, DVec3::X * -2.0),
                    (1, 0, v3(-2.0, 2.0, 0.0)),
                    (0, 0, v3(1.0, -1.0, 1.0)),
                    (0, 1, DVec3::Z * -4.0),
                    (0, 2, DVec3::Z * 4.0),
                ],
            )],
        );
        add(
            Kind,
            "fold",
            vec![plain((3, 3), |x, y| {
                v3(of4(x, [0.0, 0.9, 0.1, 1.0]), y, 0.3 * y * of4(x, [1.0, -1.0, 2.0, 0.5]))
            })],
        );
    }
    {
        use SurfaceKind::ManySheets as Kind;
        add(
            Kind,
            "loop",
            vec![plain((3, 3), |x, y| {
                v3(of4(x, [0.0, 1.6, -0.6, 1.0]), y + 0.2 * x, of4(x, [0.0, 1.0, 1.0, 0.1]))
            })],
        );
        add(
            Kind,
            "nine sheets",
            vec![plain((3, 3), |x, y| {
                v3(of4(x, [0.0, 2.2, -1.2, 1.0]), of4(y, [0.0, 2.2, -1.2, 1.0]), x + 0.5 * y)
            })],
        );
        add(
            Kind,
            "coincident sheets",
            vec![plain((3, 3), |x, y| v3(x, y, dome(x, y))), plain((3, 3), |x, y| v3(x, y, dome(x, y)))],
        );
        add(
            Kind,
            "touching sheets",
            vec![graph((2, 2), &[(2, 0, 0.5), (0, 2, 0.5)]), graph((2, 2), &[(2, 0, -0.5), (0, 2, -0.5)])],
        );
        all.push((Kind, collection::eighteen()));
    }
    let mut add =
        |kind: SurfaceKind, name: &str, nets: Vec<Net>| all.push((kind, TestSurface::of_nets(name, nets)));
    {
        use SurfaceKind::Flat as Kind;
        let mut random = Random::new(9);
        let mut uneven =
            |height: f64| ((3, 3), net((3, 3), |x, y| v3(x, y, height * (random.unit() - 0.5)).extend(1.0)));
        add(Kind, "flat", vec![uneven(0.0)]);
        add(Kind, "curvature 1e-12", vec![uneven(1e-12)]);
        add(Kind, "curvature 1e-14", vec![uneven(1e-14)]);
        add(
            Kind,
            "flat, crooked parameters",
            vec![plain((3, 3), |x, y| {
                v3(x + 0.3 * y * y, y - 0.4 * x * x, 0.4 * x + 0.7 * y + 0.12 * y * y - 0.28 * x * x)
            })],
        );
    }
    {
        use SurfaceKind::Weights as Kind;
        add(
            Kind,
            "1e-6 to 1e6, graded",
            vec![weighted(
                (3, 3),
                |x, y| v3(x, y, 0.5 * dome(x, y)),
                |x, y| 10_f64.powf(6.0 * (x + y) - 6.0),
            )],
        );
        let mut random = Random::new(78);
        add(
            Kind,
            "1e-6 to 1e6, wild",
            vec![weighted((3, 3), |x, y| v3(x, y, 0.5 * dome(x, y)), |_, _| random.magnitude(-6.0, 6.0))],
        );
        add(
            Kind,
            "1e-3 to 1e3, wild, degree 6",
            vec![weighted((6, 6), |x, y| v3(x, y, 0.5 * dome(x, y)), |_, _| random.magnitude(-3.0, 3.0))],
        );
        add(
            Kind,
            "one of 1e6",
            vec![weighted(
                (4, 4),
                |x, y| v3(x, y, 0.5 * dome(x, y)),
                |x, y| if x == 0.5 && y == 0.5 { 1e6 } else { 1.0 },
            )],
        );
    }
    {
        use SurfaceKind::Sliver as Kind;
        add(Kind, "1e-9 wide", vec![plain((3, 3), |x, y| v3(x, 1e-9 * y, dome(x, 0.3) + 1e-9 * y * y))]);
        add(
            Kind,
            "1e-9 wide, twisted",
            vec![plain((3, 3), |x, y| v3(x, 1e-9 * y * (2.0 * x).cos(), 1e-9 * y * (2.0 * x).sin()))],
        );
        add(Kind, "triangle 1e-9 wide", vec![plain((1, 1), |x, y| v3(x, 1e-9 * x * y, 0.3 * x))]);
    }
    {
        use SurfaceKind::Ruled as Kind;
        add(Kind, "saddle along its rulings", vec![graph((1, 1), &[(1, 1, 1.0)])]);
        add(Kind, "saddle, diagonal rulings", vec![graph((2, 2), &[(2, 0, 1.0), (0, 2, -1.0)])]);
        add(
            Kind,
            "saddle, curved parameters",
            vec![monomials(
                (4, 2),
                &[
                    (1, 0, v3(1.0, 0.0, 0.0)),
                    (2, 0, v3(0.5, 0.0, 0.0)),
                    (0, 1, v3(0.3, 1.0, 0.0)),
                    // z = x y with x = u + u^2 / 2 + 0.3 v, y = v.
                    (1, 1, DVec3::Z),
                    (2, 1, DVec3::Z * 0.5),
                    (0, 2, DVec3::Z * 0.3),
                ],
            )],
        );
        add(Kind, "monkey saddle", vec![graph((3, 3), &[(3, 0, 1.0), (1, 2, -3.0)])]);
        add(Kind, "contact of order 4", vec![graph((4, 4), &[(4, 0, 1.0), (0, 4, -1.0)])]);
        let waist = [v3(1.0, -1.0, 1.0), v3(0.0, 0.0, 1.0), v3(1.0, 1.0, 1.0)];
        // x^2 + y^2 - z^2 = 1/2: the middle point's weight makes the profile a hyperbola.
        let waist = [
            waist[0] * v3(1.5_f64.sqrt(), 1.0, 1.0),
            v3(1.0 / 1.5_f64.sqrt() * 0.5 * 3.0_f64.sqrt(), 0.0, 3.0_f64.sqrt()),
            waist[2] * v3(1.5_f64.sqrt(), 1.0, 1.0),
        ];
        add(Kind, "hyperboloid", revolved(&waist, turned));
    }
    {
        use SurfaceKind::Revolved as Kind;
        let ball = |k: usize| quarter(k).to_vec();
        add(Kind, "sphere", [revolved(&ball(3), turned), revolved(&ball(0), turned)].concat());
        add(Kind, "cylinder", revolved(&[v3(1.0, -1.0, 1.0), v3(1.0, 1.0, 1.0)], turned));
        let tube = |k: usize| quarter(k).map(|p| v3(p.z + 0.4 * p.x, 0.4 * p.y, p.z)).to_vec();
        add(Kind, "torus", (0..4).flat_map(|k| revolved(&tube(k), turned)).collect());
    }
    {
        use SurfaceKind::Crease as Kind;
        let roof = |x: f64| 0.5 - (x - 0.5).abs();
        let half = |from: f64| plain((2, 1), move |x, y| v3(from + 0.5 * x, y, roof(from + 0.5 * x)));
        add(Kind, "roof of two patches", vec![half(0.0), half(0.5)]);
    }
    {
        use SurfaceKind::Place as Kind;
        let bowl = || vec![graph((2, 2), &[(2, 0, 0.5), (0, 2, 0.3), (1, 1, 0.2)])];
        add(Kind, "size 1e-6", moved(bowl(), 1e-6, DVec3::ZERO));
        add(Kind, "offset by 1e6", moved(bowl(), 1.0, v3(1e6, -0.7e6, 0.3e6)));
        add(Kind, "size 1e-6, offset by 1", moved(bowl(), 1e-6, v3(1.0, -0.7, 0.3)));
    }
    all
}
