//! Maps from uniform numbers to shapes, each with its density.
//!
//! Directions are in a local frame around +z. All maps take numbers in [0, 1); 1 is also valid.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glanz_math::angle::{sin_cos_of_eighth, sin_cos_of_turn};
use glanz_math::{DVec2, DVec3, SolidAnglePdf};

/// The direction at height `z`, distance `sin` from the axis and azimuth 2 pi `turn`, with `turn` in [0, 1].
#[inline]
fn direction(z: f64, sin: f64, turn: f64) -> DVec3 {
    let (s, c) = sin_cos_of_turn(turn);
    DVec3::new(sin * c, sin * s, z)
}

/// Azimuth of (x, y) divided by 2 pi, in [0, 1).
#[inline]
fn turn(x: f64, y: f64) -> f64 {
    let t = y.atan2(x) / TAU;
    // A negative zero or a tiny negative angle would round to 1.
    if t < 0.0 { (t + 1.0).min(1.0 - f64::EPSILON / 2.0) } else { t.abs() }
}

/// A point of the unit disk, uniform by area; squares around the middle are mapped to circles.
///
/// # Source
/// @shirley1997.
#[inline]
#[must_use]
pub fn concentric_disk(xi: DVec2) -> DVec2 {
    let p = 2.0 * xi - 1.0;
    if p.x == 0.0 && p.y == 0.0 {
        return DVec2::ZERO;
    }
    let wide = p.x.abs() > p.y.abs();
    let (radius, other) = if wide { (p.x, p.y) } else { (p.y, p.x) };
    let (s, c) = sin_cos_of_eighth(FRAC_PI_4 * (other / radius));
    radius * if wide { DVec2::new(c, s) } else { DVec2::new(s, c) }
}

/// The inverse of [`concentric_disk`].
#[must_use]
pub fn concentric_disk_inverse(p: DVec2) -> DVec2 {
    let radius = p.length();
    if radius == 0.0 {
        return DVec2::splat(0.5);
    }
    let q = if p.x.abs() > p.y.abs() {
        let r = radius.copysign(p.x);
        DVec2::new(r, r * (p.y / p.x).atan() / FRAC_PI_4)
    } else {
        let r = radius.copysign(p.y);
        DVec2::new(r * (p.x / p.y).atan() / FRAC_PI_4, r)
    };
    0.5 * q + 0.5
}

/// Density of [`concentric_disk`] per unit of area of the unit disk.
#[must_use]
pub fn concentric_disk_pdf() -> f64 {
    FRAC_1_PI
}

/// A direction with z > 0 whose density is proportional to its cosine.
///
/// # Source
/// Nusselt's analogue: the projection of a uniform disk.
#[inline]
#[must_use]
pub fn cosine_hemisphere(xi: DVec2) -> DVec3 {
    let d = concentric_disk(xi);
    let z2 = 1.0 - d.length_squared();
    // At the rim of the disk z^2 is rounding error only and may be negative: keep the direction above the horizon.
    DVec3::new(d.x, d.y, z2.max(0.25 * f64::EPSILON).sqrt())
}

/// The inverse of [`cosine_hemisphere`].
#[must_use]
pub fn cosine_hemisphere_inverse(w: DVec3) -> DVec2 {
    concentric_disk_inverse(DVec2::new(w.x, w.y))
}

/// Density of [`cosine_hemisphere`] for a direction of cosine `cos` to the axis.
#[inline]
#[must_use]
pub fn cosine_hemisphere_pdf(cos: f64) -> SolidAnglePdf {
    SolidAnglePdf(cos.max(0.0) * FRAC_1_PI)
}

/// A uniformly distributed direction.
#[inline]
#[must_use]
pub fn uniform_sphere(xi: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * xi.x;
    // 1 - z^2 = 4 x (1 - x) without the cancellation near the poles.
    direction(z, 2.0 * (xi.x * (1.0 - xi.x)).max(0.0).sqrt(), xi.y)
}

/// The inverse of [`uniform_sphere`].
#[must_use]
pub fn uniform_sphere_inverse(w: DVec3) -> DVec2 {
    DVec2::new((0.5 * (1.0 - w.z)).clamp(0.0, 1.0), turn(w.x, w.y))
}

/// A uniformly distributed direction; neighbouring points of the square give neighbouring directions, with little distortion.
///
/// The upper hemisphere is the diamond between the middles of the sides, the lower one the four corners; z is the middle, x the middle
/// of the side x = 1.
///
/// # Source
/// @clarberg2008.
#[inline]
#[must_use]
pub fn equal_area_sphere(xi: DVec2) -> DVec3 {
    let signed = 2.0 * xi - 1.0;
    let DVec2 { x: u, y: v } = signed.abs();
    // Above 0 in the upper hemisphere; r is the distance to the nearer pole.
    let height = 1.0 - (u + v);
    let r = 1.0 - height.abs();
    let phi = if r > 0.0 { FRAC_PI_4 * ((v - u) / r + 1.0) } else { 0.0 };
    let (sin_phi, cos_phi) = phi.sin_cos();
    let sin = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new(
        (sin * cos_phi).copysign(signed.x),
        (sin * sin_phi).copysign(signed.y),
        (1.0 - r * r).copysign(height),
    )
}

/// The inverse of [`equal_area_sphere`], in [0, 1)^2.
#[inline]
#[must_use]
pub fn equal_area_sphere_inverse(w: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = w.abs();
    // r^2 = 1 - z without cancellation.
    let r = ((x * x + y * y) / (1.0 + z)).sqrt();
    let (large, small) = if x < y { (y, x) } else { (x, y) };
    let angle = if large > 0.0 { (small / large).atan() / FRAC_PI_2 } else { 0.0 };
    let v = r * if x < y { 1.0 - angle } else { angle };
    let (u, v) = if w.z < 0.0 { (1.0 - v, 1.0 - (r - v)) } else { (r - v, v) };
    let place = 0.5 * DVec2::new(u.copysign(w.x), v.copysign(w.y)) + 0.5;
    place.clamp(DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON / 2.0))
}

/// Density of [`uniform_sphere`] and [`equal_area_sphere`].
#[must_use]
pub fn uniform_sphere_pdf() -> SolidAnglePdf {
    SolidAnglePdf(0.25 * FRAC_1_PI)
}

/// A uniformly distributed direction with z >= 0.
#[inline]
#[must_use]
pub fn uniform_hemisphere(xi: DVec2) -> DVec3 {
    uniform_cone(xi, 1.0)
}

/// The inverse of [`uniform_hemisphere`].
#[must_use]
pub fn uniform_hemisphere_inverse(w: DVec3) -> DVec2 {
    DVec2::new((1.0 - w.z).clamp(0.0, 1.0), turn(w.x, w.y))
}

/// Density of [`uniform_hemisphere`] for a direction of cosine `cos` to the axis.
#[must_use]
pub fn uniform_hemisphere_pdf(cos: f64) -> SolidAnglePdf {
    SolidAnglePdf(if cos >= 0.0 { 0.5 * FRAC_1_PI } else { 0.0 })
}

/// 1 - cos of the angle whose squared sine is `sin2` (in [0, 1], angle at most pi / 2), without cancellation.
///
/// The argument of [`uniform_cone`] for a sphere of radius r at distance d is `one_minus_cos(r^2 / d^2)`.
#[inline]
#[must_use]
pub fn one_minus_cos(sin2: f64) -> f64 {
    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
}

/// A uniformly distributed direction in a cone around +z.
///
/// `one_minus_cos_max`: 1 - cos of the half angle of the cone, in [0, 2]; see [`one_minus_cos`]. In this form a cone with a half
/// angle of 1e-9 has full precision.
#[inline]
#[must_use]
pub fn uniform_cone(xi: DVec2, one_minus_cos_max: f64) -> DVec3 {
    let drop = xi.x * one_minus_cos_max;
    // sin^2 = (1 - z)(1 + z) with 1 - z = drop.
    direction(1.0 - drop, (drop * (2.0 - drop)).max(0.0).sqrt(), xi.y)
}

/// The inverse of [`uniform_cone`], for a unit vector `w`.
#[must_use]
pub fn uniform_cone_inverse(w: DVec3, one_minus_cos_max: f64) -> DVec2 {
    let sin2 = w.x * w.x + w.y * w.y;
    let drop = if w.z > 0.0 { one_minus_cos(sin2.min(1.0)) } else { 1.0 - w.z };
    DVec2::new((drop / one_minus_cos_max).clamp(0.0, 1.0), turn(w.x, w.y))
}

/// Density of [`uniform_cone`] inside the cone; infinite for a half angle of 0.
#[inline]
#[must_use]
pub fn uniform_cone_pdf(one_minus_cos_max: f64) -> SolidAnglePdf {
    SolidAnglePdf(1.0 / (TAU * one_minus_cos_max))
}

/// Barycentric weights of a point of a triangle, uniform by area.
///
/// # Source
/// @heitz2019: continuous, with less distortion of the square than the square root map.
#[inline]
#[must_use]
pub fn triangle(xi: DVec2) -> [f64; 3] {
    let (a, b) = if xi.x < xi.y {
        let a = 0.5 * xi.x;
        (a, xi.y - a)
    } else {
        let b = 0.5 * xi.y;
        (xi.x - b, b)
    };
    [a, b, 1.0 - a - b]
}

/// The inverse of [`triangle`].
#[must_use]
pub fn triangle_inverse(weights: [f64; 3]) -> DVec2 {
    let [a, b, _] = weights;
    if a < b { DVec2::new(2.0 * a, a + b) } else { DVec2::new(a + b, 2.0 * b) }
}

/// A number in (-radius, radius) whose density decreases linearly from the middle to the ends.
#[inline]
#[must_use]
pub fn tent(xi: f64, radius: f64) -> f64 {
    if xi < 0.5 {
        radius * ((2.0 * xi).sqrt() - 1.0)
    } else {
        radius * (1.0 - (2.0 - 2.0 * xi).max(0.0).sqrt())
    }
}

/// The inverse of [`tent`].
#[must_use]
pub fn tent_inverse(x: f64, radius: f64) -> f64 {
    let t = (x / radius).clamp(-1.0, 1.0);
    if t < 0.0 { 0.5 * (1.0 + t) * (1.0 + t) } else { 1.0 - 0.5 * (1.0 - t) * (1.0 - t) }
}

/// Density of [`tent`] at `x`, per unit of x.
#[must_use]
pub fn tent_pdf(x: f64, radius: f64) -> f64 {
    (1.0 - (x / radius).abs()).max(0.0) / radius
}

/// A direction around +z whose density is proportional to cos^exponent; `exponent` >= 0.
///
/// # Source
/// @lafortune1994.
#[inline]
#[must_use]
pub fn phong_lobe(xi: DVec2, exponent: f64) -> DVec3 {
    // cos = (1 - x)^(1 / (n + 1)); its complement by expm1, which is accurate for exponents of 1e12.
    let log_cos = (-xi.x).ln_1p() / (exponent + 1.0);
    direction(log_cos.exp(), (-(2.0 * log_cos).exp_m1()).max(0.0).sqrt(), xi.y)
}

/// The inverse of [`phong_lobe`], for z >= 0.
#[must_use]
pub fn phong_lobe_inverse(w: DVec3, exponent: f64) -> DVec2 {
    DVec2::new(1.0 - w.z.clamp(0.0, 1.0).powf(exponent + 1.0), turn(w.x, w.y))
}

/// Density of [`phong_lobe`] for a direction of cosine `cos` to the axis.
#[inline]
#[must_use]
pub fn phong_lobe_pdf(cos: f64, exponent: f64) -> SolidAnglePdf {
    SolidAnglePdf(if cos > 0.0 { (exponent + 1.0) / TAU * cos.powf(exponent) } else { 0.0 })
}

/// A point of a regular polygon with `blades` >= 3 corners on the unit circle, uniform by area: the aperture of an iris.
///
/// Fewer than 3 blades give the full disk.
#[must_use]
pub fn regular_polygon(xi: DVec2, blades: u32) -> DVec2 {
    if blades < 3 {
        return concentric_disk(xi);
    }
    let n = f64::from(blades);
    let scaled = xi.x * n;
    let sector = scaled.floor().min(n - 1.0);
    let [a, b, _] = triangle(DVec2::new(scaled - sector, xi.y));
    let corner = |k: f64| {
        let (s, c) = (2.0 * PI * k / n).sin_cos();
        DVec2::new(c, s)
    };
    a * corner(sector) + b * corner(sector + 1.0)
}
