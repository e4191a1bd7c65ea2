//! Spheres, cylinders, cones, paraboloids, hyperboloids, disks and planes.

use std::f64::consts::{PI, TAU};

use glanz_geometry::quadric::{
    Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid,
};
use glanz_math::{DVec2, DVec3};

use super::case::ContractCase;
use super::harness::check_kind;

/// Ranges of azimuth: a turn, less than half, more than half.
const SWEEPS: [f64; 3] = [TAU, 0.4 * PI, 1.7 * PI];

/// A point by cylinder coordinates.
pub fn polar(rho: f64, phi: f64, z: f64) -> DVec3 {
    DVec3::new(rho * phi.cos(), rho * phi.sin(), z)
}

/// Distance from the nearest border of the azimuth range, metres, negative outside. Near the axis every border is close, so that
/// the distance from the axis bounds the result.
pub fn inside_azimuth(p: DVec3, phi_max: f64) -> f64 {
    if phi_max >= TAU {
        return f64::INFINITY;
    }
    let rho = p.x.hypot(p.y);
    // By sines of differences instead of comparing azimuths, as the surfaces do.
    let from_start = p.y.atan2(p.x).rem_euclid(TAU);
    let inside = from_start <= phi_max;
    let line = |phi: f64| {
        let along = p.x * phi.cos() + p.y * phi.sin();
        let across = (p.y * phi.cos() - p.x * phi.sin()).abs();
        if along > 0.0 { across } else { rho }
    };
    let distance = line(0.0).min(line(phi_max));
    if inside { distance } else { -distance }
}

/// Distance from the nearer end of a range, metres, negative outside.
fn inside_range(x: f64, min: f64, max: f64) -> f64 {
    (x - min).min(max - x)
}

fn sphere(radius: f64, z: [f64; 2], phi_max: f64) -> ContractCase {
    let [low, high] = [z[0].max(-radius), z[1].min(radius)];
    let theta = [(low / radius).acos(), (high / radius).acos()];
    let mut targets = vec![[DVec3::Z * radius; 2], [DVec3::Z * -radius; 2]];
    targets.extend([low, high].map(|z| {
        let rho = (radius * radius - z * z).max(0.0).sqrt();
        [polar(rho, 0.0, z), polar(rho, phi_max, z)]
    }));
    ContractCase {
        // Poles clip nothing.
        kept: Box::new(move |p| {
            let low = if low <= -radius { f64::INFINITY } else { p.z - low };
            let high = if high >= radius { f64::INFINITY } else { high - p.z };
            low.min(high).min(inside_azimuth(p, phi_max))
        }),
        position: Some(Box::new(move |uv| {
            let theta = theta[0] + uv.y * (theta[1] - theta[0]);
            polar(radius * theta.sin(), uv.x * phi_max, radius * theta.cos())
        })),
        area: Some(phi_max * radius * (high - low)),
        size: 1.1 * radius,
        convex: true,
        targets,
        singular: vec![],
        ..ContractCase::new(
            format!("sphere {radius} {z:?} {phi_max}"),
            Sphere::try_new(radius, z, phi_max).unwrap(),
            move |p| p.length_squared() - radius * radius,
        )
    }
}

#[test]
fn spheres_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(sphere(1.0, [-1.0, 1.0], phi_max));
        cases.push(sphere(0.37, [-0.1, 0.25], phi_max));
        cases.push(sphere(1e3, [9e2, 2e3], phi_max));
        cases.push(sphere(1e-6, [-1.0, 0.0], phi_max));
    }
    for case in &mut cases {
        // Parameters have no derivative at the poles; hits are as accurate as elsewhere.
        let radius = case.size / 1.1;
        case.parameter_singular = vec![DVec3::Z * radius, DVec3::Z * -radius];
    }
    check_kind("sphere", 1, &cases);
}

fn cylinder(radius: f64, z: [f64; 2], phi_max: f64) -> ContractCase {
    ContractCase {
        kept: Box::new(move |p| inside_range(p.z, z[0], z[1]).min(inside_azimuth(p, phi_max))),
        position: Some(Box::new(move |uv| polar(radius, uv.x * phi_max, z[0] + uv.y * (z[1] - z[0])))),
        area: Some(phi_max * radius * (z[1] - z[0])),
        center: DVec3::Z * (0.5 * (z[0] + z[1])),
        size: 1.1 * radius.hypot(0.5 * (z[1] - z[0])),
        convex: true,
        targets: vec![
            [polar(radius, 0.0, z[0]), polar(radius, 0.0, z[1])],
            [polar(radius, phi_max, z[0]), polar(radius, phi_max, z[1])],
            [polar(radius, 0.5 * phi_max, z[0]), polar(radius, 0.5 * phi_max, z[1])],
        ],
        directions: vec![DVec3::Z, -DVec3::Z, DVec3::new(1e-9, 0.0, 1.0), DVec3::X],
        ..ContractCase::new(
            format!("cylinder {radius} {z:?} {phi_max}"),
            Cylinder::try_new(radius, z, phi_max).unwrap(),
            move |p| p.x * p.x + p.y * p.y - radius * radius,
        )
    }
}

#[test]
fn cylinders_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(cylinder(1.0, [-1.0, 1.0], phi_max));
        cases.push(cylinder(0.3, [2.0, 2.1], phi_max));
        cases.push(cylinder(0.05, [-2.0, 1.0], phi_max));
        cases.push(cylinder(1e3, [-2e3, 1e3], phi_max));
    }
    check_kind("cylinder", 2, &cases);
}

fn cone(radius: f64, height: f64, phi_max: f64) -> ContractCase {
    let slope = radius / height;
    let apex = DVec3::Z * height;
    ContractCase {
        kept: Box::new(move |p| inside_range(p.z, 0.0, height).min(inside_azimuth(p, phi_max))),
        position: Some(Box::new(move |uv| polar(radius * (1.0 - uv.y), uv.x * phi_max, uv.y * height))),
        area: Some(0.5 * phi_max * radius * radius.hypot(height)),
        center: DVec3::Z * (0.4 * height),
        size: 1.1 * radius.hypot(0.6 * height),
        targets: vec![
            [apex; 2],
            [apex, polar(radius, 0.0, 0.0)],
            [apex, polar(radius, phi_max, 0.0)],
            [apex, polar(radius, 0.5 * phi_max, 0.0)],
        ],
        singular: vec![apex],
        directions: [0.0, 1.0, 2.5, phi_max]
            .into_iter()
            .flat_map(|phi| [polar(radius, phi, height), polar(-radius, phi, -height)])
            .chain([DVec3::Z, -DVec3::Z])
            .collect(),
        ..ContractCase::new(
            format!("cone {radius} {height} {phi_max}"),
            Cone::try_new(radius, height, phi_max).unwrap(),
            move |p| {
                let across = slope * (height - p.z);
                p.x * p.x + p.y * p.y - across * across
            },
        )
    }
}

#[test]
fn cones_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(cone(1.0, 1.0, phi_max));
        cases.push(cone(0.1, 1.3, phi_max));
        cases.push(cone(20.0, 1.7, phi_max));
    }
    check_kind("cone", 3, &cases);
}

fn paraboloid(radius: f64, z: [f64; 2], phi_max: f64) -> ContractCase {
    let rise = radius * radius / z[1];
    let [low, high] = z;
    // pi r / (6 h^2) ((r^2 + 4 h^2)^(3/2) - r^3) between two heights.
    let area_below = |h: f64| {
        let r = (rise * h).sqrt();
        if h > 0.0 { PI * r / (6.0 * h * h) * ((r * r + 4.0 * h * h).powf(1.5) - r.powi(3)) } else { 0.0 }
    };
    ContractCase {
        kept: Box::new(move |p| {
            let low = if low <= 0.0 { f64::INFINITY } else { p.z - low };
            low.min(high - p.z).min(inside_azimuth(p, phi_max))
        }),
        position: Some(Box::new(move |uv| {
            let z = low + uv.y * (high - low);
            polar((rise * z).max(0.0).sqrt(), uv.x * phi_max, z)
        })),
        area: Some(phi_max / TAU * (area_below(high) - area_below(low))),
        center: DVec3::Z * (0.5 * high),
        size: 1.1 * radius.hypot(0.5 * high),
        convex: true,
        targets: vec![
            [DVec3::ZERO; 2],
            [DVec3::ZERO, DVec3::Z],
            [polar(radius, 0.0, high), polar(radius, phi_max, high)],
        ],
        parameter_singular: vec![DVec3::ZERO],
        directions: vec![DVec3::Z, -DVec3::Z, DVec3::new(1e-9, 0.0, 1.0)],
        ..ContractCase::new(
            format!("paraboloid {radius} {z:?} {phi_max}"),
            Paraboloid::try_new(radius, z, phi_max).unwrap(),
            move |p| p.x * p.x + p.y * p.y - rise * p.z,
        )
    }
}

#[test]
fn paraboloids_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(paraboloid(1.0, [0.0, 1.0], phi_max));
        cases.push(paraboloid(2.0, [0.1, 0.2], phi_max));
        cases.push(paraboloid(0.2, [0.0, 1.5], phi_max));
        cases.push(paraboloid(300.0, [0.0, 100.0], phi_max));
    }
    check_kind("paraboloid", 4, &cases);
}

fn hyperboloid(p1: DVec3, p2: DVec3, phi_max: f64) -> ContractCase {
    let on_line = move |v: f64| p1 + (p2 - p1) * v;
    let v_at = move |z: f64| (z - p1.z) / (p2.z - p1.z);
    // The rotation of a point starts at the point of the line at the same height.
    let turned_back = move |p: DVec3| {
        let start = on_line(v_at(p.z)).truncate();
        DVec3::new(start.x * p.x + start.y * p.y, start.x * p.y - start.y * p.x, 0.0)
            / start.length().max(1e-300)
    };
    let widest = p1.truncate().length().max(p2.truncate().length());
    let d = p2 - p1;
    let v_waist = -p1.truncate().dot(d.truncate()) / d.truncate().length_squared().max(1e-300);
    let waist = on_line(v_waist);
    let is_cone = waist.truncate().length() < 1e-9;
    let middle = 0.5 * (p1 + p2);
    ContractCase {
        kept: Box::new(move |p| {
            inside_range(p.z, p1.z.min(p2.z), p1.z.max(p2.z)).min(inside_azimuth(turned_back(p), phi_max))
        }),
        position: Some(Box::new(move |uv| {
            let p = on_line(uv.y);
            let (sin, cos) = (uv.x * phi_max).sin_cos();
            DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z)
        })),
        area: Some(hyperboloid_area(p1, p2, phi_max)),
        center: DVec3::Z * middle.z,
        size: 1.1 * widest.hypot(0.5 * d.z),
        targets: vec![[p1, p2], [DVec3::Z * waist.z; 2], [on_line(v_waist.clamp(0.0, 1.0)); 2], [p1, p1]],
        singular: if is_cone { vec![DVec3::Z * waist.z] } else { vec![] },
        // Differences step over a thin neck.
        parameter_singular: if waist.truncate().length() < 0.02 * widest {
            vec![DVec3::Z * waist.z]
        } else {
            vec![]
        },
        directions: vec![
            d,
            -d,
            DVec3::new(d.x, -d.y, d.z),
            DVec2::from_angle(1.0).rotate(d.truncate()).extend(d.z),
            DVec2::from_angle(4.0).rotate(d.truncate()).extend(d.z),
            DVec3::Z,
        ],
        ..ContractCase::new(
            format!("hyperboloid {p1} {p2} {phi_max}"),
            Hyperboloid::try_new(p1, p2, phi_max).unwrap(),
            move |p| {
                // From the foot of the line's distance to the axis, so that it is as exact as the surface at a waist.
                let w = if v_waist.is_finite() && v_waist.abs() < 1e3 { v_waist } else { 0.5 };
                let foot = on_line(w);
                let s = (p.z - foot.z) / d.z;
                let flat = d.truncate();
                let rho2 = foot.truncate().length_squared()
                    + 2.0 * s * foot.truncate().dot(flat)
                    + s * s * flat.length_squared();
                let rho2 = if w == v_waist {
                    foot.truncate().length_squared() + s * s * flat.length_squared()
                } else {
                    rho2
                };
                p.x * p.x + p.y * p.y - rho2
            },
        )
    }
}

/// phi_max times the integral of |dp/dphi x dp/dv| over v, by Simpson's rule in small steps.
fn hyperboloid_area(p1: DVec3, p2: DVec3, phi_max: f64) -> f64 {
    let d = p2 - p1;
    let n = 20_000;
    let element = |i: usize| {
        let p = p1 + d * (i as f64 / f64::from(n));
        DVec3::new(-p.y, p.x, 0.0).cross(d).length()
    };
    let weight = |i: usize| if i == 0 || i == n as usize { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let sum: f64 = (0..=n as usize).map(|i| weight(i) * element(i)).sum();
    phi_max * sum / f64::from(3 * n)
}

#[test]
fn hyperboloids_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        let v = DVec3::new;
        cases.push(hyperboloid(v(1.0, -1.0, -1.0), v(1.0, 1.0, 1.0), phi_max));
        cases.push(hyperboloid(v(0.3, 2.0, 3.0), v(0.5, -0.4, 1.0), phi_max));
        // Waist outside the segment; thin neck; double cone; cone; cylinder.
        cases.push(hyperboloid(v(1.0, 2.0, 0.0), v(1.0, 3.0, 0.7), phi_max));
        cases.push(hyperboloid(v(0.01, -1.0, -1.0), v(0.01, 1.0, 1.0), phi_max));
        cases.push(hyperboloid(v(-1.0, 0.0, -1.0), v(1.0, 0.0, 1.0), phi_max));
        cases.push(hyperboloid(v(0.0, 0.0, 0.5), v(0.6, 0.8, -0.5), phi_max));
        cases.push(hyperboloid(v(0.5, 0.0, -1.0), v(0.5, 0.0, 1.0), phi_max));
    }
    check_kind("hyperboloid", 5, &cases);
}

fn two_sheets(a: f64, c: f64, z: [f64; 2], phi_max: f64) -> ContractCase {
    let s_of = move |z: f64| if z.abs() <= c { 0.0 } else { (z.abs() / c).acosh().copysign(z) };
    let (s0, s1) = (s_of(z[0]), s_of(z[1]));
    let upper_only = z[0] > -c;
    let reach = z[0].abs().max(z[1].abs());
    let widest = a / c * (reach * reach - c * c).sqrt();
    ContractCase {
        // The apices clip nothing of their sheet; zero lies in the gap.
        kept: Box::new(move |p| {
            let low = if z[0] >= -c && z[0] <= c { p.z } else { p.z - z[0] };
            let high = if z[1] >= -c && z[1] <= c { -p.z } else { z[1] - p.z };
            low.min(high).min(inside_azimuth(p, phi_max))
        }),
        position: Some(Box::new(move |uv| {
            let s = s0 + uv.y * (s1 - s0);
            let sign = if s < 0.0 || (s == 0.0 && !upper_only) { -1.0 } else { 1.0 };
            polar(a * s.abs().sinh(), uv.x * phi_max, sign * c * s.cosh())
        })),
        area: Some(two_sheets_area(a, c, s0, s1, phi_max)),
        size: 1.1 * widest.hypot(reach),
        targets: vec![
            [DVec3::Z * c; 2],
            [DVec3::Z * -c; 2],
            [DVec3::Z * -c, DVec3::Z * c],
            [polar(widest, 0.0, reach), polar(widest, phi_max, -reach)],
        ],
        parameter_singular: vec![DVec3::Z * c, DVec3::Z * -c],
        directions: vec![DVec3::Z, -DVec3::Z, polar(a, 0.3, c), polar(a, 2.0, -c)],
        ..ContractCase::new(
            format!("two-sheeted hyperboloid {a} {c} {z:?} {phi_max}"),
            TwoSheetedHyperboloid::try_new(a, c, z, phi_max).unwrap(),
            move |p| p.x * p.x + p.y * p.y - (a / c).powi(2) * (p.z - c) * (p.z + c),
        )
    }
}

/// phi_max times the integral of rho |d(rho, z)/ds| over s, by Simpson's rule in small steps.
fn two_sheets_area(a: f64, c: f64, s0: f64, s1: f64, phi_max: f64) -> f64 {
    let n = 20_000;
    let element = |i: usize| {
        let s = s0 + (s1 - s0) * (i as f64 / f64::from(n));
        a * s.abs().sinh() * (a * s.cosh()).hypot(c * s.sinh())
    };
    let weight = |i: usize| if i == 0 || i == n as usize { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let sum: f64 = (0..=n as usize).map(|i| weight(i) * element(i)).sum();
    phi_max * (s1 - s0) * sum / f64::from(3 * n)
}

#[test]
fn two_sheeted_hyperboloids_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(two_sheets(1.0, 1.0, [-2.0, 2.5], phi_max));
        cases.push(two_sheets(0.4, 0.7, [0.0, 2.0], phi_max));
        cases.push(two_sheets(0.4, 0.7, [-2.0, 0.3], phi_max));
        cases.push(two_sheets(2.0, 0.1, [0.15, 1.0], phi_max));
        cases.push(two_sheets(0.01, 0.5, [-1.0, 1.0], phi_max));
    }
    check_kind("two-sheeted hyperboloid", 6, &cases);
}

fn disk(height: f64, radius: f64, inner: f64, phi_max: f64) -> ContractCase {
    ContractCase {
        kept: Box::new(move |p| {
            let rho = p.x.hypot(p.y);
            let hole = if inner == 0.0 { f64::INFINITY } else { rho - inner };
            hole.min(radius - rho).min(inside_azimuth(p, phi_max))
        }),
        position: Some(Box::new(move |uv| polar(radius - uv.y * (radius - inner), uv.x * phi_max, height))),
        area: Some(0.5 * phi_max * (radius * radius - inner * inner)),
        center: DVec3::Z * height,
        size: 1.1 * radius,
        convex: true,
        parameter_singular: vec![DVec3::Z * height],
        targets: vec![
            [DVec3::Z * height; 2],
            [polar(inner, 0.0, height), polar(radius, 0.0, height)],
            [polar(inner, phi_max, height), polar(radius, phi_max, height)],
        ],
        directions: vec![DVec3::X, DVec3::new(1.0, 0.0, 1e-9), DVec3::Z],
        ..ContractCase::new(
            format!("disk {height} {radius} {inner} {phi_max}"),
            Disk::try_new(height, radius, inner, phi_max).unwrap(),
            move |p| p.z - height,
        )
    }
}

#[test]
fn disks_keep_the_contract() {
    let mut cases = Vec::new();
    for phi_max in SWEEPS {
        cases.push(disk(0.0, 1.0, 0.0, phi_max));
        cases.push(disk(-3.0, 2.0, 1.5, phi_max));
        cases.push(disk(1e2, 1e3, 10.0, phi_max));
    }
    check_kind("disk", 7, &cases);
}

fn plane(x: [f64; 2], y: [f64; 2]) -> ContractCase {
    let finite = [x, y].iter().flatten().all(|end| end.is_finite());
    let scale = |[min, max]: [f64; 2]| if (max - min).is_finite() { (min, max - min) } else { (0.0, 1.0) };
    let (sx, sy) = (scale(x), scale(y));
    let end = |value: f64, instead: f64| if value.is_finite() { value } else { instead };
    let corners =
        [DVec3::new(end(x[0], -1.0), end(y[0], -1.0), 0.0), DVec3::new(end(x[1], 1.0), end(y[1], 1.0), 0.0)];
    ContractCase {
        kept: Box::new(move |p| inside_range(p.x, x[0], x[1]).min(inside_range(p.y, y[0], y[1]))),
        position: Some(Box::new(move |uv| DVec3::new(sx.0 + uv.x * sx.1, sy.0 + uv.y * sy.1, 0.0))),
        area: finite.then(|| (x[1] - x[0]) * (y[1] - y[0])),
        center: 0.5 * (corners[0] + corners[1]),
        size: corners[0].distance(corners[1]),
        convex: true,
        samples: finite,
        targets: vec![corners, [corners[0]; 2]],
        directions: vec![DVec3::X, DVec3::new(1.0, 0.0, 1e-9), DVec3::Z],
        ..ContractCase::new(format!("plane {x:?} {y:?}"), Plane::try_new(x, y).unwrap(), move |p| p.z)
    }
}

#[test]
fn planes_keep_the_contract() {
    let far = f64::INFINITY;
    let cases = [
        plane([-1.0, 1.0], [-2.0, 0.5]),
        plane([3.0, 1e3], [1.0, 1.5]),
        plane([-far, far], [-far, far]),
        plane([0.0, far], [-1.0, 1.0]),
    ];
    check_kind("plane", 8, &cases);
}
