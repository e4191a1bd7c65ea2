//! Points of the luminous opening of a luminaire.

use std::f64::consts::TAU;

use glanz_light::intensity::{LuminousOpening, OpeningShape};
use glanz_math::{DVec2, DVec3};
use glanz_sampling::discrete::PiecewiseConstant1;
use glanz_sampling::warp;

/// A point of the opening in the luminaire's frame, metres, by two numbers uniform in [0, 1).
///
/// Flat openings are sampled evenly. Of solids it is their surface: of a box the bottom and the four sides; of an upright cylinder the bottom
/// and the side, of a lying one the side alone; of an ellipsoid all of it. Their parts are selected by area and each of them is sampled evenly
/// if its cross-section is a circle; if that is an ellipse, as a stretched circle.
pub(super) fn point(opening: &LuminousOpening, xi: DVec2) -> DVec3 {
    let size = DVec3::from_array(opening.size);
    let unit = match opening.shape {
        OpeningShape::Point => DVec3::ZERO,
        OpeningShape::Rectangle => (xi - 0.5).extend(0.0),
        OpeningShape::Box => on_box(size, xi),
        OpeningShape::Ellipse => (0.5 * warp::concentric_disk(xi)).extend(0.0),
        OpeningShape::EllipseFacingX => {
            let disk = 0.5 * warp::concentric_disk(xi);
            DVec3::new(0.0, disk.x, disk.y)
        }
        OpeningShape::VerticalCylinder => on_upright_cylinder(size, xi),
        OpeningShape::CylinderAlongX => {
            let circle = circle(xi.y);
            DVec3::new(xi.x - 0.5, circle.x, circle.y)
        }
        OpeningShape::CylinderAlongY => {
            let circle = circle(xi.y);
            DVec3::new(circle.x, xi.x - 0.5, circle.y)
        }
        OpeningShape::Ellipsoid => 0.5 * warp::uniform_sphere(xi),
    };
    unit * size
}

/// A circle of diameter 1.
fn circle(xi: f64) -> DVec2 {
    0.5 * DVec2::from_angle(TAU * xi)
}

/// Selects a part by area, and returns it with the remaining random number; the first part if none has an area.
fn part(areas: &[f64], xi: f64) -> (usize, f64) {
    match PiecewiseConstant1::try_new(areas) {
        Ok(parts) => {
            let choice = parts.choose(xi);
            (choice.index, choice.xi)
        }
        Err(_) => (0, xi),
    }
}

/// The bottom and the four sides of a box, in units of its size about its centre.
fn on_box(size: DVec3, xi: DVec2) -> DVec3 {
    let (across_x, across_y) = (size.y * size.z, size.x * size.z);
    let (side, x) = part(&[size.x * size.y, across_x, across_x, across_y, across_y], xi.x);
    let (a, b) = (x - 0.5, xi.y - 0.5);
    match side {
        0 => DVec3::new(a, b, -0.5),
        1 => DVec3::new(0.5, a, b),
        2 => DVec3::new(-0.5, a, b),
        3 => DVec3::new(a, 0.5, b),
        _ => DVec3::new(a, -0.5, b),
    }
}

/// The bottom and the side of an upright cylinder, in units of its size about its centre.
fn on_upright_cylinder(size: DVec3, xi: DVec2) -> DVec3 {
    let (rx, ry) = (0.5 * size.x, 0.5 * size.y);
    // Circumference of a circle of the mean square radius: exact for circles, accurate enough to select between parts of ellipses.
    let around = TAU * (0.5 * (rx * rx + ry * ry)).sqrt();
    let (side, x) = part(&[0.5 * TAU * rx * ry, around * size.z], xi.x);
    if side == 0 {
        (0.5 * warp::concentric_disk(DVec2::new(x, xi.y))).extend(-0.5)
    } else {
        circle(x).extend(xi.y - 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: u32 = 100;

    fn points(shape: OpeningShape, size: [f64; 3]) -> Vec<DVec3> {
        let opening = LuminousOpening { shape, size };
        let xi = |i: u32| (f64::from(i) + 0.5) / f64::from(N);
        (0..N * N).map(|i| point(&opening, DVec2::new(xi(i % N), xi(i / N)))).collect()
    }

    fn mean(points: &[DVec3], f: impl Fn(DVec3) -> f64) -> f64 {
        points.iter().map(|&p| f(p)).sum::<f64>() / points.len() as f64
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 2e-3, "{found} {expected}");
    }

    #[test]
    fn flat_openings_are_filled_evenly() {
        // Mean squares: of a side of length a a^2 / 12, of a diameter d d^2 / 16.
        let rectangle = points(OpeningShape::Rectangle, [2.0, 0.5, 0.0]);
        near(mean(&rectangle, |p| p.x * p.x), 4.0 / 12.0);
        near(mean(&rectangle, |p| p.y * p.y), 0.25 / 12.0);
        let ellipse = points(OpeningShape::Ellipse, [2.0, 1.0, 0.0]);
        near(mean(&ellipse, |p| p.x * p.x), 4.0 / 16.0);
        near(mean(&ellipse, |p| p.y * p.y), 1.0 / 16.0);
        assert!(rectangle.iter().chain(&ellipse).all(|p| p.z == 0.0));
        let upright = points(OpeningShape::EllipseFacingX, [0.0, 2.0, 1.0]);
        near(mean(&upright, |p| p.y * p.y), 4.0 / 16.0);
        assert!(upright.iter().all(|p| p.x == 0.0));
    }

    #[test]
    fn points_of_solids_lie_on_their_surface() {
        let half = DVec3::new(1.0, 0.5, 0.25);
        let size = (2.0 * half).to_array();
        let of = |shape| points(shape, size);
        for p in of(OpeningShape::Box) {
            let q = (p / half).abs();
            assert!(
                p.z >= -half.z && (p.z == -half.z || (q.x == 1.0 || q.y == 1.0) && q.max_element() <= 1.0)
            );
        }
        let round = |x: f64, y: f64| (x * x + y * y - 1.0).abs() < 1e-12;
        for p in of(OpeningShape::VerticalCylinder) {
            let q = p / half;
            assert!(
                q.z == -1.0 && q.x * q.x + q.y * q.y <= 1.0 + 1e-12 || round(q.x, q.y) && q.z.abs() <= 1.0
            );
        }
        assert!(of(OpeningShape::CylinderAlongX).iter().all(|p| round(p.y / half.y, p.z / half.z)));
        assert!(of(OpeningShape::CylinderAlongY).iter().all(|p| round(p.x / half.x, p.z / half.z)));
        assert!(of(OpeningShape::Ellipsoid).iter().all(|p| ((*p / half).length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn parts_of_solids_are_picked_by_area() {
        // Bottom 6, sides 2 of 3 x 1 and 2 of 2 x 1: 6 of 16.
        let on_bottom =
            mean(&points(OpeningShape::Box, [3.0, 2.0, 1.0]), |p| f64::from(u8::from(p.z == -0.5)));
        assert!((on_bottom - 6.0 / 16.0).abs() < 0.01);
        // Diameter and height 1: bottom pi / 4, side pi.
        let drum = points(OpeningShape::VerticalCylinder, [1.0; 3]);
        let on_bottom = mean(&drum, |p| f64::from(u8::from(p.z == -0.5)));
        assert!((on_bottom - 0.2).abs() < 0.01);
    }

    #[test]
    fn a_box_without_area_is_a_line() {
        let line = points(OpeningShape::Box, [3.0, 0.0, 0.0]);
        near(mean(&line, |p| p.x * p.x), 9.0 / 12.0);
        assert!(line.iter().all(|p| p.y == 0.0 && p.z == 0.0));
    }
}
