//! The cases of CIE 171:2006 with closed forms, sections 5.2 to 5.8, by all methods together.
//!
//! The report itself could not be read: rooms and positions follow what is published about it, and the expected values are those of the closed forms, computed
//! here. Each test prints its line of the table in docs/lighting.md.

#![allow(clippy::print_stdout, reason = "the table in the documentation")]

use std::f64::consts::PI;

use crate::combined::calculated;
use crate::common::*;
use glanz_illumination::GridResolution::Cells;
use glanz_illumination::*;
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// Maps with the error of the goal.
fn lux(scene: &Scene, asked: &[ReceiverRequest], error: f64) -> Vec<LuxMap> {
    calculated(scene, asked, error).0
}

/// Mean of a function over a cell of a flat map, by the middles of 16 x 16 parts.
fn mean(map: &LuxMap, cell: usize, lux: &impl Fn(DVec3) -> f64) -> f64 {
    const PARTS: i32 = 16;
    let [across, up] = [1, map.cells[0] as usize].map(|next| map.positions[next] - map.positions[0]);
    let share = |i: i32| (f64::from(i) + 0.5) / f64::from(PARTS) - 0.5;
    let parts = (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (share(i), share(j))));
    let sum: f64 = parts.map(|(x, y)| lux(map.positions[cell] + across * x + up * y)).sum();
    sum / f64::from(PARTS * PARTS)
}

/// Prints and bounds the largest relative deviation of the cells of a map from a closed form.
fn compare(case: &str, map: &LuxMap, expected: impl Fn(DVec3) -> f64, most: f64) {
    let off = |cell: usize| map.lux[cell] / mean(map, cell, &expected) - 1.0;
    let worst = (0..map.lux.len()).map(|cell| off(cell).abs()).fold(0.0, f64::max);
    println!("| {case} | {} | {:.4} % |", map.lux.len(), 100.0 * worst);
    assert!(worst <= most, "{case}: {worst}");
}

fn black_floor() -> SceneBuilder {
    SceneBuilder::new().shape(rectangle(4.0, 4.0), diffuse(0.0))
}

/// Configuration factor of a rectangle with sides a and b for an element in a parallel plane at the distance d below one of its corners (@howell2011 C-11).
fn parallel(a: f64, b: f64, d: f64) -> f64 {
    let (x, y) = (a / d, b / d);
    let (u, v) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / u * (y / u).atan() + y / v * (x / v).atan()) / (2.0 * PI)
}

/// The same for an element in a perpendicular plane through one side b, at the distance c from the plane of the rectangle, whose sides are a, away from the
/// element's plane, and b, with the element opposite to its corner (@howell2011 C-12).
fn perpendicular(a: f64, b: f64, c: f64) -> f64 {
    let root = (a * a + c * c).sqrt();
    ((b / c).atan() - c / root * (b / root).atan()) / (2.0 * PI)
}

/// The factor of the rectangle from `low` to `high` for an element below the origin, by its four corners.
fn of_rectangle(low: DVec2, high: DVec2, factor: impl Fn(f64, f64) -> f64) -> f64 {
    let corner = |x: f64, y: f64| factor(x.abs(), y.abs()) * x.signum() * y.signum();
    corner(high.x, high.y) - corner(low.x, high.y) - corner(high.x, low.y) + corner(low.x, low.y)
}

/// Cells of sixths of a metre.
const SMALL: GridResolution = Cells([24, 24]);

#[test]
fn case_5_2_point_sources() {
    let (height, candela) = (3.0, 1000.0);
    for (x, y) in [(0.0, 0.0), (1.5, -1.0)] {
        let over = DVec3::new(x, y, height);
        let scene = resolved(black_floor().light(point_light(over, candela as f32)));
        let maps = lux(&scene, &[request("floor", 0, SMALL)], 0.001);
        let expected = |p: DVec3| candela * height / p.distance(over).powi(3);
        compare(&format!("5.2 point source at ({x}, {y}, 3) m"), &maps[0], expected, 0.001);
    }
}

#[test]
fn case_5_3_area_sources() {
    let (height, luminance) = (3.0, 2000.0);
    // A square of a metre below the ceiling, and a wall of four metres beside it, in the plane y = -2.
    let down = DMat4::from_translation(DVec3::Z * height) * DMat4::from_rotation_x(PI);
    let wall = ShapeDescription::parallelogram([-2.0, -2.0, 0.0], DVec3::Z * 2.5, DVec3::X * 4.0);
    let scene = resolved(black_floor().shape(wall, diffuse(0.0)).shape(
        rectangle(1.0, 1.0).transformed(down).emitting(candela_per_area(luminance as f32)),
        diffuse(0.0),
    ));
    let asked = [request("floor", 0, SMALL), request("wall", 1, SMALL)];
    let maps = lux(&scene, &asked, 0.001);
    let square = |p: DVec3| [DVec2::splat(-0.5) - p.truncate(), DVec2::splat(0.5) - p.truncate()];
    let floor = |p: DVec3| {
        let [low, high] = square(p);
        PI * luminance * of_rectangle(low, high, |a, b| parallel(a, b, height))
    };
    compare("5.3 area source, floor", &maps[0], floor, 0.001);
    let on_wall = |p: DVec3| {
        let [low, high] = square(p);
        let factor = |a, b| perpendicular(a, b, height - p.z);
        PI * luminance * of_rectangle(DVec2::new(low.y, low.x), DVec2::new(high.y, high.x), factor)
    };
    compare("5.3 area source, wall", &maps[1], on_wall, 0.002);
}

/// A box from the origin to `size`, its walls inwards, each a receiver of 4 x 4 cells.
fn closed_room(size: DVec3, reflectance: f32) -> (SceneBuilder, Vec<ReceiverRequest>) {
    let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
    let o = DVec3::ZERO;
    let walls = [(o, x, y), (z, y, x), (o, y, z), (x, z, y), (o, z, x), (y, x, z)];
    let builder = walls.into_iter().fold(SceneBuilder::new(), |builder, (corner, u, v)| {
        builder.shape(ShapeDescription::parallelogram(corner, u, v), diffuse(reflectance))
    });
    (builder, (0..6).map(|wall| request(&format!("wall {wall}"), wall, Cells([4, 4]))).collect())
}

#[test]
fn case_5_4_luminous_flux_conservation() {
    let candela = 100.0;
    let (builder, asked) = closed_room(DVec3::new(4.0, 4.0, 3.0), 0.0);
    let scene = resolved(builder.light(point_light(DVec3::new(1.0, 2.5, 2.0), candela as f32)));
    let received: f64 = lux(&scene, &asked, 0.001).iter().map(|map| map.summary().flux).sum();
    let off = received / (4.0 * PI * candela) - 1.0;
    println!("| 5.4 flux on the walls of a room of 4 x 4 x 3 m | 96 | {:.4} % |", 100.0 * off.abs());
    assert!(off.abs() < 3e-4, "{off}");
}

/// Transmittance of a pane without absorption at an angle of incidence for unpolarised light, of index 1.5.
fn pane(degrees: f64) -> f64 {
    let (cos, sin) = (degrees.to_radians().cos(), degrees.to_radians().sin());
    let inside = (1.0 - (sin / 1.5).powi(2)).sqrt();
    let reflectance = |r: f64| r * r;
    let s = reflectance((cos - 1.5 * inside) / (cos + 1.5 * inside));
    let p = reflectance((1.5 * cos - inside) / (1.5 * cos + inside));
    0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
}

#[test]
fn case_5_5_directional_transmittance_of_clear_glass() {
    transmittance(&[0.0, 40.0, 60.0, 80.0], 0.006);
}

/// Compares the light below a pane at angles of incidence, computed to this error.
fn transmittance(angles: &[f64], error: f64) {
    let mut worst = 0.0_f64;
    for &degrees in angles {
        let towards = DVec3::new(f64::sin(f64::to_radians(degrees)), 0.0, f64::cos(f64::to_radians(degrees)));
        let light =
            LightDescription { scale: 10_000.0, ..LightDescription::distant(towards, DVec3::ZERO, CANDELA) };
        // As large as the light on the floor needs it.
        let glass = rectangle(1.2, 1.2).translated([degrees.to_radians().tan(), 0.0, 1.0]);
        let scene = SceneBuilder::new()
            .shape(rectangle(1.0, 1.0), diffuse(0.0))
            .shape(glass, MaterialKind::thin_dielectric(1.5, 1.0, 1.0))
            .light(light);
        let map = &lux(&resolved(scene), &[request("floor", 0, Cells([1, 1]))], error)[0];
        let expected = 10_000.0 * degrees.to_radians().cos() * pane(degrees);
        worst = worst.max((map.lux[0] / expected - 1.0).abs());
    }
    println!("| 5.5 pane of index 1.5, 0 to 80 degrees | {} | {:.3} % |", angles.len(), 100.0 * worst);
    assert!(worst < 4.0 * error, "{worst}");
}

/// A square of `side` on the floor with reflectance .8 under a distant light of 10 000 lx, beside a black wall x = -2 and under a black ceiling; with a black
/// screen of half a metre upright in the middle between square and wall if `screened`.
fn reflecting_square(side: f64, screened: bool) -> Scene {
    let light =
        LightDescription { scale: 10_000.0, ..LightDescription::distant(DVec3::Z, DVec3::ZERO, CANDELA) };
    let wall = ShapeDescription::parallelogram([-2.0, -2.0, 0.0], DVec3::Y * 4.0, DVec3::Z * 3.0);
    let mut builder =
        SceneBuilder::new().shape(wall, diffuse(0.0)).shape(rectangle(side, side), diffuse(0.8)).light(light);
    if screened {
        let screen = ShapeDescription::parallelogram([-1.0, -50.0, 0.0], DVec3::Y * 100.0, DVec3::Z * 0.5);
        builder = builder.shape(screen, diffuse(0.0));
    }
    resolved(builder)
}

#[test]
fn case_5_6_light_reflection_over_diffuse_surfaces() {
    for side in [1.0, 3.0] {
        let map = &lux(&reflecting_square(side, false), &[request("wall", 0, Cells([2, 2]))], 0.01)[0];
        let half = 0.5 * side;
        let expected = |p: DVec3| {
            // Seen from the wall, the square begins 2 - half away from it.
            let factor = |a, b| perpendicular(a, b, p.z);
            let (low, high) = (DVec2::new(2.0 - half, -half - p.y), DVec2::new(2.0 + half, half - p.y));
            0.8 * 10_000.0 * of_rectangle(low, high, factor)
        };
        compare(&format!("5.6 square of {side} m on a wall"), map, expected, 0.03);
    }
}

#[test]
fn case_5_7_diffuse_reflection_with_internal_obstructions() {
    let map = &lux(&reflecting_square(1.0, true), &[request("wall", 0, Cells([2, 4]))], 0.01)[0];
    // Over the upper edge of the screen, a metre away, points at the height z see the square beyond d = z / (z - 0.5) metres from the wall.
    let expected = |p: DVec3| {
        let from = if p.z > 0.5 { p.z / (p.z - 0.5) } else { f64::INFINITY };
        let (near, far) = (from.max(1.5), 2.5);
        if near >= far {
            return 0.0;
        }
        let factor = |a, b| perpendicular(a, b, p.z);
        8000.0 * of_rectangle(DVec2::new(near, -0.5 - p.y), DVec2::new(far, 0.5 - p.y), factor)
    };
    // The lowest row sees nothing of it.
    let below = |p: &DVec3| p.z < 0.75;
    assert!(map.positions.iter().zip(&map.lux).all(|(p, lux)| below(p) == (*lux == 0.0)));
    let lit = (0..8).filter(|&cell| !below(&map.positions[cell]));
    let off = |cell: usize| (map.lux[cell] / mean(map, cell, &expected) - 1.0).abs();
    let worst = lit.map(off).fold(0.0, f64::max);
    println!("| 5.7 square of 1 m behind a screen | 6 | {:.3} % |", 100.0 * worst);
    assert!(worst < 0.03, "{worst}");
}

#[test]
fn case_5_8_internal_reflected_component() {
    internal_reflection(&[0.2, 0.5, 0.8], 0.01);
}

/// Compares the flux on the walls of a closed cube, computed to this error.
fn internal_reflection(reflectances: &[f64], error: f64) {
    let candela = 100.0;
    for &reflectance in reflectances {
        let (builder, asked) = closed_room(DVec3::splat(4.0), reflectance as f32);
        let scene = resolved(builder.light(point_light(DVec3::splat(2.0), candela as f32)));
        let maps = lux(&scene, &asked, error);
        // All flux is absorbed in the end: 1 - r of the flux on the walls.
        let received: f64 = maps.iter().map(|map| map.summary().flux).sum();
        let off = received * (1.0 - reflectance) / (4.0 * PI * candela) - 1.0;
        println!("| 5.8 closed cube, reflectance {reflectance} | 96 | {:.3} % |", 100.0 * off.abs());
        assert!(off.abs() < 0.002, "{reflectance}: {off}");
    }
}

/// The rest of the table, by `cargo xtask nightly heavy`.
mod heavy {
    use super::*;

    #[test]
    fn case_5_5_at_all_angles() {
        transmittance(&[0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0], 0.003);
    }

    #[test]
    fn case_5_8_of_a_white_room() {
        internal_reflection(&[0.2, 0.5, 0.8, 0.95], 0.005);
    }
}
