use std::f64::consts::TAU;

use glanz_scene::description::{GeometryDescription, ShapeDescription};

use super::*;
use crate::elements::ElementSettings;
use crate::scenes::{parallelogram, scene, walls};

fn elements(scene: &Scene, side: f64) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side }).unwrap()
}

/// Form factor from one side of shape `from` to one of shape `to`, over all elements.
fn form_factor(elements: &Elements<'_>, from: (u32, bool), to: (u32, bool)) -> f64 {
    let of = |(shape, back): (u32, bool)| {
        elements.list.iter().filter(move |element| {
            let surface = &elements.surfaces[element.patch.surface as usize];
            surface.shape(element.patch.face) == shape && element.patch.back == back
        })
    };
    let area: f64 = of(from).map(|element| element.area).sum();
    let sum: f64 = of(from).flat_map(|a| of(to).map(move |b| exchange(elements, a, b))).sum();
    sum / area
}

/// Form factor of parallel rectangles of x by y, z apart (@howell1982 configuration C-11).
fn parallel(x: f64, y: f64, z: f64) -> f64 {
    let (x, y) = (x / z, y / z);
    let (xx, yy) = (1.0 + x * x, 1.0 + y * y);
    let logarithm = (xx * yy / (xx + yy - 1.0)).sqrt().ln();
    let turns = x * yy.sqrt() * (x / yy.sqrt()).atan() + y * xx.sqrt() * (y / xx.sqrt()).atan()
        - x * x.atan()
        - y * y.atan();
    2.0 / (PI * x * y) * (logarithm + turns)
}

/// Form factor from a rectangle of width w to one of width h that stands on their common side of length l (@howell1982, C-14).
fn perpendicular(w: f64, h: f64, l: f64) -> f64 {
    let (w, h) = (w / l, h / l);
    let (ww, hh) = (w * w, h * h);
    let root = (ww + hh).sqrt();
    let logarithm = ((1.0 + ww) * (1.0 + hh) / (1.0 + ww + hh)).ln()
        + ww * (ww * (1.0 + ww + hh) / ((1.0 + ww) * (ww + hh))).ln()
        + hh * (hh * (1.0 + hh + ww) / ((1.0 + hh) * (hh + ww))).ln();
    let turns = w * (1.0 / w).atan() + h * (1.0 / h).atan() - root * (1.0 / root).atan();
    (turns + 0.25 * logarithm) / (PI * w)
}

#[test]
fn parallel_rectangles() {
    let (u, v) = (DVec3::X * 2.0, DVec3::Y);
    for z in [0.25, 1.0, 7.0] {
        let scene = scene(vec![
            (parallelogram(DVec3::ZERO, u, v), 0.5, 0.0),
            (parallelogram(DVec3::Z * z, v, u), 0.5, 0.0),
        ]);
        for side in [2.0, 0.5] {
            let found = form_factor(&elements(&scene, side), (0, false), (1, false));
            let expected = parallel(2.0, 1.0, z);
            assert!((found / expected - 1.0).abs() < 1e-6, "{z}, {side}: {found} {expected}");
        }
        // Backs see nothing.
        assert_eq!(form_factor(&elements(&scene, 2.0), (0, true), (1, false)), 0.0);
    }
}

#[test]
fn perpendicular_rectangles_with_a_common_side() {
    let scene = scene(vec![
        (parallelogram(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 2.0), 0.5, 0.0),
        (parallelogram(DVec3::ZERO, DVec3::Z, DVec3::X * 3.0), 0.5, 0.0),
    ]);
    // The second faces -(z x x) = y: the common side runs along x.
    let expected = perpendicular(2.0, 1.0, 3.0);
    for side in [3.0, 0.5] {
        let found = form_factor(&elements(&scene, side), (0, false), (1, false));
        assert!((found / expected - 1.0).abs() < 1e-5, "{side}: {found} {expected}");
    }
}

#[test]
fn coaxial_disks() {
    let disk = |height, radius| {
        ShapeDescription::from(GeometryDescription::Disk { height, radius, inner_radius: 0.0, phi_max: TAU })
    };
    let scene = scene(vec![(disk(0.0, 1.0), 0.5, 0.0), (disk(1.5, 0.7), 0.5, 0.0)]);
    let s = 1.0 + (1.5_f64.powi(2) + 0.7_f64.powi(2));
    let expected = 0.5 * (s - (s * s - 4.0 * 0.7_f64.powi(2)).sqrt());
    let found = form_factor(&elements(&scene, 0.4), (0, false), (1, true));
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

#[test]
fn sphere_to_a_rectangle() {
    // Its middle is 1 m above a corner.
    let rectangle = parallelogram(DVec3::new(0.0, 0.0, -1.0), DVec3::X * 2.0, DVec3::Y * 1.5);
    let sphere = ShapeDescription::sphere(0.4);
    let scene = scene(vec![(sphere, 0.5, 0.0), (rectangle, 0.5, 0.0)]);
    let (x, y) = (0.5_f64, 1.0 / 1.5);
    let expected = (1.0 / (x * x + y * y + x * x * y * y).sqrt()).atan() / (4.0 * PI);
    let found = form_factor(&elements(&scene, 0.3), (0, false), (1, false));
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

#[test]
fn surfaces_between_elements_occlude() {
    // A wall of the same size right in the middle hides all; one beside, nothing.
    let (u, v) = (DVec3::X, DVec3::Y);
    let with = |corner: DVec3, size: f64| {
        let scene = scene(vec![
            (parallelogram(DVec3::ZERO, u, v), 0.5, 0.0),
            (parallelogram(DVec3::Z, v, u), 0.5, 0.0),
            (parallelogram(corner, u * size, v * size), 0.5, 0.0),
        ]);
        form_factor(&elements(&scene, 0.25), (0, false), (1, false))
    };
    assert_eq!(with(DVec3::new(-1.0, -1.0, 0.5), 3.0), 0.0);
    let visible = parallel(1.0, 1.0, 1.0);
    assert!((with(DVec3::new(5.0, 0.0, 0.5), 1.0) / visible - 1.0).abs() < 1e-6);
    // Half-plane x < 0.5 at half the height hides one half and, through the middle, as much as it shows: by symmetry
    // exactly half is left.
    let half = with(DVec3::new(-2.5, -1.0, 0.5), 3.0);
    assert!((half / visible - 0.5).abs() < 0.01, "{}", half / visible);
}

#[test]
fn exchange_is_the_same_both_ways_and_rows_of_a_closed_room_sum_to_one() {
    let scene = scene(walls(DVec3::new(4.0, 3.0, 2.5)).into_iter().map(|w| (w, 0.5, 0.0)).collect());
    let elements = elements(&scene, 1.0);
    let inside: Vec<usize> = (0..elements.list.len()).filter(|&i| !elements.list[i].patch.back).collect();
    let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
    assert_eq!(factors.len(), elements.list.len());
    for &i in &inside {
        let sum = factors.sum(i);
        assert!((sum - 1.0).abs() < 1e-5, "{i}: {sum}");
    }
    for (&i, &j) in inside.iter().zip(inside.iter().skip(7)) {
        let (a, b) = (&elements.list[i], &elements.list[j]);
        let (there, back) = (exchange(&elements, a, b), exchange(&elements, b, a));
        assert!((there - back).abs() <= 1e-9 * a.area, "{there} {back}");
    }
    let cancelled = CancelFlag::default();
    cancelled.cancel();
    assert_eq!(FormFactors::new(&elements, &cancelled), Err(Interrupted));
}

#[test]
fn rows_inside_a_sphere_sum_to_one() {
    let sphere = ShapeDescription::sphere(1.0);
    let scene = scene(vec![(sphere, 0.5, 0.0)]);
    let elements = elements(&scene, 0.5);
    let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
    // The kernel between any two points of a sphere is 1 / (4 pi r^2): a row sums to the fraction of the other area, as an element does not
    // see itself.
    for (i, element) in elements.list.iter().enumerate().filter(|(_, element)| element.patch.back) {
        let (sum, expected) = (factors.sum(i), 1.0 - element.area / (4.0 * PI));
        assert!((sum - expected).abs() < 1e-3, "{i}: {sum} {expected}");
    }
}
