//! Algebraic surfaces of degree 1 to 4, smooth and singular.

use glanz_geometry::algebraic::{AlgebraicSurface, PolynomialTerm};
use glanz_math::{Bounds3, DVec3};

use super::case::ContractCase;
use super::harness::check_kind;

/// `terms`: x, y and z exponents and the coefficient. `implicit`: the same polynomial as a closure.
fn algebraic(
    name: &str,
    terms: &[([u32; 3], f64)],
    bounds: Bounds3,
    implicit: impl Fn(DVec3) -> f64 + 'static,
) -> ContractCase {
    let terms: Vec<PolynomialTerm> =
        terms.iter().map(|&(exponents, coefficient)| PolynomialTerm { exponents, coefficient }).collect();
    let [a, .., b] = bounds.corners();
    ContractCase {
        kept: Box::new(move |p| (p - bounds.min).min(bounds.max - p).min_element()),
        samples: false,
        center: bounds.center(),
        size: 0.5 * bounds.diagonal().length(),
        targets: vec![[a, b], [a, DVec3::new(b.x, a.y, a.z)], [b, DVec3::new(b.x, a.y, b.z)]],
        directions: vec![DVec3::X, DVec3::ONE, DVec3::new(1e-9, 0.0, 1.0), DVec3::new(1.0, -1.0, 0.0)],
        ..ContractCase::new(name, AlgebraicSurface::try_new(&terms, bounds).unwrap(), implicit)
    }
}

fn cube(half: f64) -> Bounds3 {
    Bounds3::new(DVec3::splat(-half), DVec3::splat(half))
}

const X2: [u32; 3] = [2, 0, 0];
const Y2: [u32; 3] = [0, 2, 0];
const Z2: [u32; 3] = [0, 0, 2];

fn sphere(center: DVec3, radius: f64) -> ContractCase {
    // Centers and radii are chosen so that every coefficient is exact.
    let terms = [
        (X2, 1.0),
        (Y2, 1.0),
        (Z2, 1.0),
        ([1, 0, 0], -2.0 * center.x),
        ([0, 1, 0], -2.0 * center.y),
        ([0, 0, 1], -2.0 * center.z),
        ([0; 3], center.length_squared() - radius * radius),
    ];
    let bounds = Bounds3::new(center - 1.25 * radius, center + 1.5 * radius);
    ContractCase {
        convex: true,
        ..algebraic("sphere", &terms, bounds, move |p| p.distance_squared(center) - radius * radius)
    }
}

fn torus(major: f64, minor: f64) -> ContractCase {
    let (a, b) = (major * major - minor * minor, 4.0 * major * major);
    let terms = [
        ([4, 0, 0], 1.0),
        ([0, 4, 0], 1.0),
        ([0, 0, 4], 1.0),
        ([2, 2, 0], 2.0),
        ([0, 2, 2], 2.0),
        ([2, 0, 2], 2.0),
        (X2, 2.0 * a - b),
        (Y2, 2.0 * a - b),
        (Z2, 2.0 * a),
        ([0; 3], a * a),
    ];
    let bounds = Bounds3::new(DVec3::new(-2.0, -3.0, -1.0), DVec3::new(3.0, 3.0, 0.9));
    let mut case = algebraic("torus", &terms, bounds, move |p| (p.x.hypot(p.y) - major).hypot(p.z) - minor);
    case.targets.push([DVec3::new(major - minor, 0.0, 0.0), DVec3::new(major, 0.0, minor)]);
    case
}

#[test]
fn smooth_algebraic_surfaces_keep_the_contract() {
    let square = |x: f64| x * x;
    let mut cases = [
        sphere(DVec3::ZERO, 1.0),
        sphere(DVec3::new(64.0, 128.0, -32.0), 0.5),
        torus(2.0, 0.75),
        algebraic(
            "plane",
            &[([1, 0, 0], 3.0), ([0, 1, 0], 2.0), ([0, 0, 1], -1.0), ([0; 3], -0.25)],
            cube(1.0),
            |p| 3.0 * p.x + 2.0 * p.y - p.z - 0.25,
        ),
        algebraic("hyperboloid", &[(X2, 1.0), (Y2, 1.0), (Z2, -1.0), ([0; 3], -1.0)], cube(3.0), move |p| {
            square(p.x) + square(p.y) - square(p.z) - 1.0
        }),
        // z = x^3 - 3 x y^2
        algebraic(
            "monkey saddle",
            &[([0, 0, 1], -1.0), ([3, 0, 0], 1.0), ([1, 2, 0], -3.0)],
            cube(1.0),
            |p| p.x * (p.x * p.x - 3.0 * p.y * p.y) - p.z,
        ),
        algebraic(
            "tangle",
            &[
                ([4, 0, 0], 1.0),
                (X2, -5.0),
                ([0, 4, 0], 1.0),
                (Y2, -5.0),
                ([0, 0, 4], 1.0),
                (Z2, -5.0),
                ([0; 3], 11.75),
            ],
            cube(3.0),
            move |p| p.to_array().iter().map(|&x| square(x) * (square(x) - 5.0)).sum::<f64>() + 11.75,
        ),
        // Small, with coefficients that are not round: x^4 + y^4 + z^4 = 1e-12 / 16.
        algebraic(
            "rounded cube",
            &[([4, 0, 0], 1.0), ([0, 4, 0], 1.0), ([0, 0, 4], 1.0), ([0; 3], -0.0625e-12)],
            cube(0.6e-3),
            move |p| p.to_array().iter().map(|&x| square(square(x))).sum::<f64>() - 0.0625e-12,
        ),
    ];
    for case in &mut cases {
        // Three crossings of the monkey saddle come together at its middle.
        case.resolution = 200;
    }
    check_kind("smooth algebraic surface", 21, &cases);
}

#[test]
fn singular_algebraic_surfaces_keep_the_contract() {
    // Cayley's cubic has four nodes; the cone an apex; Steiner's Roman surface crosses itself along the axes.
    let half = 0.5;
    let mut cayley = algebraic(
        "Cayley's cubic",
        &[(X2, 4.0), (Y2, 4.0), (Z2, 4.0), ([1, 1, 1], 16.0), ([0; 3], -1.0)],
        cube(0.75),
        |p| 4.0 * p.length_squared() + 16.0 * p.x * p.y * p.z - 1.0,
    );
    // A few roundings of terms that add up to 7.
    cayley.noise = 3e-15;
    cayley.resolution = 800;
    cayley.singular = vec![
        DVec3::splat(-half),
        DVec3::new(-half, half, half),
        DVec3::new(half, -half, half),
        DVec3::new(half, half, -half),
    ];
    // The lines through two nodes lie on the surface.
    cayley
        .targets
        .extend([[cayley.singular[0], cayley.singular[1]], [cayley.singular[2], cayley.singular[3]]]);
    let mut cone = algebraic("cone", &[(X2, 1.0), (Y2, 1.0), (Z2, -1.0)], cube(1.0), |p| {
        p.x * p.x + p.y * p.y - p.z * p.z
    });
    // The terms add up to less than 2.
    cone.noise = 4e-16;
    cone.singular = vec![DVec3::ZERO];
    cone.targets.push([DVec3::ZERO; 2]);
    cone.directions.push(DVec3::new(1.0, 0.0, 1.0));
    let mut roman = algebraic(
        "Roman surface",
        &[([2, 2, 0], 1.0), ([0, 2, 2], 1.0), ([2, 0, 2], 1.0), ([1, 1, 1], 1.0)],
        cube(0.55),
        |p| {
            let [x, y, z] = p.to_array();
            x * x * y * y + y * y * z * z + z * z * x * x + x * y * z
        },
    );
    // The terms add up to less than 1 where rays meet the surface.
    roman.noise = 4e-16;
    roman.resolution = 1500;
    roman.singular = vec![DVec3::ZERO];
    roman.ridges = DVec3::AXES.map(|a| [a, -a]).to_vec();
    roman.targets.extend(roman.ridges.clone());
    check_kind("singular algebraic surface", 22, &[cayley, cone, roman]);
}
