use std::f64::consts::TAU;

use glanz_math::DVec4;

use super::patch_index::PatchIndex;
use super::*;
use crate::bezier::TensorPatch;
use crate::freeform::{Freeform, SurfacePatch};
use crate::quadric::{Plane, Sphere};
use crate::trim::{RegionSettings, TrimCurve, TrimRegion};

const RADIUS: f64 = 0.3;
const WIDTH: f64 = 1e-4;

/// A disk of [`RADIUS`] about the middle of the unit square in the plane z = 0, trimmed by a circle of a width.
fn disk(surface: Surface, width: f64) -> Surface {
    let circle = TrimCurve::try_circle(DVec2::splat(0.5), RADIUS).unwrap().with_width(width).unwrap();
    let settings = RegionSettings { scale: DVec2::ONE, domain: Some([DVec2::ZERO, DVec2::ONE]) };
    surface.trimmed(TrimRegion::try_with_settings(vec![vec![circle]], settings).unwrap())
}

/// The unit square as a plane, and by four patches of one surface.
fn squares() -> [Surface; 2] {
    let plane = Surface::from(Plane::try_new([0.0, 1.0], [0.0, 1.0]).unwrap());
    let patch = |x: [f64; 2], y: [f64; 2]| {
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| DVec4::new(x[i], y[j], 0.0, 1.0));
        SurfacePatch::over_rectangle(TensorPatch::try_new(1, 1, corners.to_vec()).unwrap(), x, y).unwrap()
    };
    let halves = [[0.0, 0.37], [0.37, 1.0]];
    let patches = halves.iter().flat_map(|&x| halves.map(|y| patch(x, y))).collect();
    [plane, Freeform::try_new(patches).unwrap().into()]
}

/// The least distance of a line from the circle, by many points of it.
fn slow_distance(ray: &Ray) -> f64 {
    let distance = |phi: f64| {
        let (sin, cos) = phi.sin_cos();
        let p = DVec3::new(0.5 + RADIUS * cos, 0.5 + RADIUS * sin, 0.0) - ray.origin;
        (p - ray.direction * p.dot(ray.direction) / ray.direction.length_squared()).length()
    };
    (0..200_000).map(|i| distance(TAU * f64::from(i) / 200_000.0)).fold(f64::INFINITY, f64::min)
}

fn rays() -> impl Iterator<Item = Ray> {
    (0..60).map(|i| {
        let (phi, turn) = (0.7 * f64::from(i), 0.11 * f64::from(i));
        let outwards = DVec3::new(phi.cos(), phi.sin(), 0.0);
        let target = DVec3::new(0.5, 0.5, 0.0) + RADIUS * outwards;
        let across = DVec3::new(turn.cos(), turn.sin(), 0.4 * (0.3 * f64::from(i)).sin()).normalize();
        let away = across.any_orthonormal_vector() * WIDTH * f64::from(i % 7) / 2.0;
        Ray::new(target + away - 2.0 * across, 1.7 * across)
    })
}

#[test]
fn lines_within_the_width_of_a_curve_meet_its_tube() {
    for square in squares() {
        let surface = disk(square, WIDTH);
        let tubes = surface.edge_tubes().unwrap();
        for ray in rays() {
            let distance = slow_distance(&ray);
            let contacts = tubes.contacts(&ray);
            let meets = tubes.meets(&ray, f64::INFINITY);
            assert_eq!(meets, !contacts.is_empty(), "{ray:?}");
            if distance <= 0.99 * WIDTH {
                assert!(meets, "{ray:?} {distance}");
                assert!(!tubes.meets(&ray, contacts[0].hit.t - 0.05), "{ray:?}");
            }
            if distance > 2.0 * WIDTH {
                assert!(!meets, "{ray:?} {distance}");
            }
            for TubeContact { hit, radius } in contacts {
                let at = surface.untrimmed_at(hit.face, DVec2::new(hit.u, hit.v)).unwrap();
                let from_middle = at.position.distance(DVec3::new(0.5, 0.5, 0.0));
                assert!((from_middle - RADIUS).abs() < WIDTH, "{from_middle}");
                assert!(at.position.distance(ray.at(hit.t)) <= radius + WIDTH, "{ray:?} {hit:?}");
                assert!((WIDTH..2.0 * WIDTH).contains(&radius), "{radius}");
            }
        }
    }
}

#[test]
fn points_within_the_width_of_a_curve_are_in_its_tube() {
    let tubes = disk(squares()[1].clone(), WIDTH).edge_tubes().unwrap();
    for i in 0..200 {
        let phi = 0.37 * f64::from(i);
        let outwards = DVec3::new(phi.cos(), phi.sin(), 0.0);
        let on_circle = DVec3::new(0.5, 0.5, 0.0) + RADIUS * outwards;
        let away = (0.3 * outwards + DVec3::Z * (f64::from(i % 5) - 2.0)).normalize();
        assert!(tubes.contain(on_circle + 0.99 * WIDTH * away), "{i}");
        assert!(!tubes.contain(on_circle + 2.0 * WIDTH * away), "{i}");
    }
}

#[test]
fn a_line_through_both_sides_of_a_circle_has_two_contacts() {
    let tubes = disk(squares()[0].clone(), WIDTH).edge_tubes().unwrap();
    let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.0), DVec3::X);
    let at: Vec<f64> = tubes.contacts(&ray).iter().map(|contact| contact.hit.t).collect();
    assert_eq!(at.len(), 2, "{at:?}");
    assert!((at[0] - 1.2).abs() < 1e-2 && (at[1] - 1.8).abs() < 1e-2, "{at:?}");
    // From inside a tube, only the other one counts.
    let ray = Ray::new(DVec3::new(0.2 - 0.5 * WIDTH, 0.5, 0.0), DVec3::X);
    assert!(tubes.meets(&ray, 1.0) && !tubes.meets(&ray, 0.5));
    assert!(!tubes.meets(&Ray::new(ray.origin, DVec3::NEG_X), 1.0));
}

/// A surface trimmed by polylines or other curves of a width each.
fn trimmed(surface: Surface, loops: Vec<Vec<(TrimCurve, f64)>>) -> Surface {
    let wide = |(curve, width): (TrimCurve, f64)| curve.with_width(width).unwrap();
    let loops = loops.into_iter().map(|curves| curves.into_iter().map(wide).collect()).collect();
    let settings = RegionSettings { scale: DVec2::ONE, domain: Some([DVec2::ZERO, DVec2::ONE]) };
    surface.trimmed(TrimRegion::try_with_settings(loops, settings).unwrap())
}

#[test]
fn a_line_through_both_edges_of_a_narrow_strip_has_two_contacts() {
    for square in squares() {
        for width in [1.5, 8.0, 30.0].map(|widths| widths * WIDTH) {
            let sides = [DVec2::new(0.1, 0.5), DVec2::new(0.9, 0.5 + width)];
            let strip = TrimCurve::try_rectangle(sides[0], sides[1]).unwrap();
            let tubes = trimmed(square.clone(), vec![vec![(strip, WIDTH)]]).edge_tubes().unwrap();
            for direction in [DVec3::Y, DVec3::new(0.7, 1.0, 0.0), DVec3::new(0.1, 1.0, 0.1 * WIDTH)] {
                let ray = Ray::new(DVec3::new(0.45, 0.5 + 0.5 * width, 0.0) - 0.3 * direction, direction);
                let contacts = tubes.contacts(&ray);
                let at: Vec<f64> = contacts.iter().map(|contact| ray.at(contact.hit.t).y).collect();
                assert_eq!(at.len(), 2, "{width} {direction} {at:?}");
                assert!((at[0] - sides[0].y).abs() < WIDTH && (at[1] - sides[1].y).abs() < WIDTH, "{at:?}");
            }
            // Along an edge, which consists of several tubes: one.
            let ray = Ray::new(DVec3::new(-1.0, 0.5 - 0.5 * WIDTH, 0.0), DVec3::X);
            let at: Vec<f64> = tubes.contacts(&ray).iter().map(|contact| contact.hit.t).collect();
            assert!(at.len() <= if width > 2.0 * WIDTH { 1 } else { 2 }, "{width} {at:?}");
        }
    }
}

#[test]
fn curves_that_are_wide_between_their_ends_only_have_tubes() {
    // From pole to pole of a sphere, where parameters along a parallel have no extent.
    let sphere = Surface::from(Sphere::try_full(1.0).unwrap());
    let lune = TrimCurve::try_rectangle(DVec2::new(0.2, 0.0), DVec2::new(0.4, 1.0)).unwrap();
    let tubes = trimmed(sphere.clone(), vec![vec![(lune, WIDTH)]]).edge_tubes().unwrap();
    for v in [0.2, 0.5, 0.7] {
        let on_curve = sphere.untrimmed_at(0, DVec2::new(0.4, v)).unwrap().position;
        assert!(tubes.contain(on_curve), "{v}");
    }
    assert!(tubes.cover(WIDTH));
}

#[test]
fn curves_without_tubes_are_not_said_to_have_some() {
    for square in squares() {
        let corners = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)].map(DVec2::from);
        let narrow = 0.9e-6 * 2.0_f64.sqrt();
        let side = |k: usize| {
            (TrimCurve::try_line(corners[k], corners[(k + 1) % 4]).unwrap(), [WIDTH, narrow][k % 2])
        };
        let surface = trimmed(square, vec![(0..4).map(side).collect()]);
        let tubes = surface.edge_tubes().unwrap();
        assert!(tubes.cover(WIDTH) && !tubes.cover(narrow));
        assert!(tubes.contain(DVec3::new(0.5, 0.2, 0.0)) && !tubes.contain(DVec3::new(0.8, 0.5, 0.0)));
    }
}

#[test]
fn tubes_hold_curves_that_cross_their_chord_in_the_middle() {
    // The halves cross their chords in the middle, too.
    let height = |u: f64| u + 0.4 * u * (u - 0.25) * (u - 0.5) * (u - 0.75) * (u - 1.0);
    // By q = u (u - 1): the product is q (q + 3/16) (u - 1/2), expanded in powers of u.
    let powers = [0.0, 1.0 + 0.4 * 0.09375, -0.4 * 0.78125, 0.4 * 2.1875, -0.4 * 2.5, 0.4];
    let binomial = |n: usize, k: usize| (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64);
    let point = |i: usize| {
        let v: f64 = (0..=i).map(|k| powers[k] * binomial(i, k) / binomial(5, k)).sum();
        DVec3::new(i as f64 / 5.0, v, 1.0)
    };
    let control_points: Vec<DVec3> = (0..6).map(point).collect();
    let wave = TrimCurve::try_bezier(&control_points).unwrap();
    assert!(
        (0..=50)
            .map(|i| f64::from(i) / 50.0)
            .all(|u| (wave.point(0, u).unwrap().y - height(u)).abs() < 1e-12)
    );
    let back = TrimCurve::try_polyline(&[DVec2::ONE, DVec2::Y, DVec2::ZERO]).unwrap();
    let width = 1e-5;
    for square in squares() {
        let surface = trimmed(square, vec![vec![(wave.clone(), width), (back.clone(), width)]]);
        let tubes = surface.edge_tubes().unwrap();
        for i in 0..=1000 {
            let u = f64::from(i) / 1000.0;
            let on_curve = DVec3::new(u, height(u), 0.0);
            assert!(tubes.contain(on_curve + 0.9 * width * DVec3::Z), "{u}");
        }
    }
}

#[test]
fn patches_are_found_by_their_parameters() {
    let mut patches = Vec::new();
    let at = |i: i32| f64::from(i * i) / 100.0;
    for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))) {
        let (x, y) = ([at(i), at(i + 1)], [at(j), at(j + 1)]);
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| DVec4::new(x[i], y[j], 0.0, 1.0));
        let patch = TensorPatch::try_new(1, 1, corners.to_vec()).unwrap();
        patches.push(SurfacePatch::over_rectangle(patch, x, y).unwrap());
    }
    let index = PatchIndex::new(&Freeform::try_new(patches).unwrap());
    for i in 0..2000 {
        let uv = DVec2::new(f64::from(i % 47) / 46.0, f64::from(i % 53) / 52.0);
        let (face, parameters) = index.find(uv).unwrap();
        let cell = [uv.x, uv.y].map(|x| (0..10).find(|&i| x <= at(i + 1)).unwrap());
        assert_eq!(face as i32, cell[0] * 10 + cell[1], "{uv}");
        let low = cell.map(at);
        let size = cell.map(|i| at(i + 1) - at(i));
        let back = DVec2::from(low) + parameters * DVec2::from(size);
        assert!(back.distance(uv) < 1e-14, "{uv} {back}");
    }
    // Beyond the border, the nearest.
    assert_eq!(index.find(DVec2::new(-1e-9, 2.0)).unwrap(), (9, DVec2::new(0.0, 1.0)));
}

#[test]
fn a_line_along_a_curved_surface_passes_its_border_in_both_directions() {
    // z = x^2 / 2 up to the edge in x = 0.1: lines that are parallel to the surface a little before the edge, and above it at the edge.
    let points = [0.0, 0.5, 1.0].into_iter().flat_map(|x| {
        let z = if x == 1.0 { 0.5 } else { 0.0 };
        [0.0, 1.0].map(|y| DVec4::new(x, y, z, 1.0))
    });
    let patch = TensorPatch::try_new(2, 1, points.collect()).unwrap();
    let patch = SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap();
    let surface = Surface::from(Freeform::try_new(vec![patch]).unwrap());
    let edge = TrimCurve::try_rectangle(DVec2::new(0.0, 0.1), DVec2::new(0.1, 0.9)).unwrap();
    let surface = trimmed(surface, vec![vec![(edge, WIDTH)]]);
    let tubes = surface.edge_tubes().unwrap();
    for (before, is_turned) in [(0.005, true), (-0.005, false), (0.03, false)] {
        // Parallel to the surface `before` the edge, WIDTH / 4 below it there.
        let x = 0.1 - before;
        let direction = DVec3::new(1.0, 0.0, x);
        let ray = Ray::new(DVec3::new(x, 0.5, 0.5 * x * x - 0.25 * WIDTH) - direction, direction);
        let contacts = tubes.contacts(&ray);
        let turned: Vec<Hit> =
            contacts.iter().filter_map(|contact| surface.turned_contact(&ray, contact)).collect();
        assert_eq!(turned.len(), usize::from(is_turned), "{before} {contacts:?}");
        for hit in turned {
            let side = |at: &Hit| surface.location(&ray, at).normal.dot(direction);
            assert!(side(&hit) * side(&contacts[0].hit) < 0.0, "{before} {hit:?}");
            assert!(surface.location(&ray, &hit).position.distance(ray.at(hit.t)) < 4.0 * before);
        }
    }
}

#[test]
fn curves_as_wide_as_rounding_have_no_tubes() {
    for square in squares() {
        assert!(square.edge_tubes().is_none());
        assert!(disk(square, 1e-12).edge_tubes().is_none());
    }
}
