//! Two faces that meet in a common trimming curve leave no gap.
//!
//! One face keeps the inside of a closed curve on a wavy spline surface. The other is the same surface with other parameters and
//! another degree, reversed, and keeps the outside, so that their curves agree only up to rounding.
//! `GLANZ_SEAM_RAYS` is the number of rays; `cargo xtask seam` traces 10^8.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::sync::atomic::{AtomicU64, Ordering};

use glanz_geometry::spline::{NurbsSurface, ParameterDirection};
use glanz_geometry::trim::{TrimCurve, TrimLoop, TrimRegion};
use glanz_geometry::{BoundedRay, RaySurface, Surface};
use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3, Ray};

/// Bound on the rounding errors of parameters, with a margin.
const BORDER: f64 = 1e-9;

/// Half of the length of the rays: at these radii of curvature, the surface crosses a ray once.
const REACH: f64 = 1e-3;

/// Number of rays of a batch.
const BATCH: u64 = 4096;

/// 8 x 8 control points of degree 3, rational, over the unit square of parameters.
fn waves() -> NurbsSurface {
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0];
    let points = (0..64).map(|k| {
        let (i, j) = (f64::from(k / 8) / 7.0, f64::from(k % 8) / 7.0);
        let weight = 1.0 + 0.3 * (2.1 * f64::from(k)).sin();
        (DVec3::new(i, j, 0.1 * (9.0 * i).sin() * (7.0 * j).cos()) * weight).extend(weight)
    });
    NurbsSurface::try_new([3, 3], [knots(), knots()], points.collect::<Vec<DVec4>>()).unwrap()
}

/// A circle, as quarters of degree 2, or a flower of degree 3; mapped by `place`, which must be affine.
fn closed_curve(flower: bool, place: impl Fn(DVec2) -> DVec2) -> TrimCurve {
    let center = DVec2::splat(0.5);
    if flower {
        // Periodic: the first points are repeated at the end.
        let count = 15;
        let petals = (0..count + 3).map(|k| {
            let angle = TAU * f64::from(k % count) / f64::from(count);
            let radius = if k % 3 == 0 { 0.42 } else { 0.25 };
            place(center + radius * DVec2::from_angle(angle)).extend(1.0)
        });
        let knots: Vec<f64> = (0..count + 7).map(f64::from).collect();
        return TrimCurve::try_nurbs(3, &knots, &petals.collect::<Vec<_>>()).unwrap();
    }
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points = corners.iter().enumerate().map(|(k, &(x, y))| {
        let weight = if k % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 };
        (place(center + 0.3 * DVec2::new(f64::from(x), f64::from(y))) * weight).extend(weight)
    });
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    TrimCurve::try_nurbs(2, &knots, &points.collect::<Vec<_>>()).unwrap()
}

fn face(surface: &NurbsSurface, curve: TrimCurve) -> Surface {
    let lid = TrimLoop::try_closed(curve, 1e-9).unwrap();
    let region = TrimRegion::try_new(vec![lid], [DVec2::ZERO, DVec2::ONE]).unwrap();
    let region = region.with_widened_border(BORDER).unwrap();
    Surface::from(surface.to_freeform().unwrap()).trimmed(region)
}

/// A point on the seam with its tangents.
struct SeamTarget([DVec3; 3]);

/// Numbers in [0, 1) that depend on the counter alone.
fn random(counter: u64) -> f64 {
    let mut x = counter.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A short ray at a distance of 3e-4 to 3e-12 of the size from the seam.
fn ray(targets: &[SeamTarget], index: u64) -> Ray {
    let number = |k: u64| random(index * 8 + k);
    let SeamTarget([point, su, sv]) = &targets[(number(0) * targets.len() as f64) as usize];
    let offset = 0.3 * REACH * 10.0_f64.powf(-8.0 * number(1));
    let angle = TAU * number(2);
    let target = *point + (*su * angle.cos() + *sv * angle.sin()) * offset;
    // Not along the surface, where a ray would cross it more than once.
    let (z, turn) = (0.1 + 0.9 * number(3), TAU * number(4));
    let side = if number(5) < 0.5 { -z } else { z };
    let normal = su.cross(*sv).normalize();
    let tangent = su.normalize();
    let across = (tangent * turn.cos() + normal.cross(tangent) * turn.sin()) * (1.0 - z * z).sqrt();
    let direction = normal * side + across;
    Ray::new(target - direction * REACH, direction)
}

#[test]
fn no_ray_slips_through_a_seam_of_trimmed_faces() {
    let rays = std::env::var("GLANZ_SEAM_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(400_000_u64);
    let waves = waves();
    let other = waves.reversed(ParameterDirection::U).unwrap().elevate(ParameterDirection::V).unwrap();
    for (flower, count) in [(false, rays / 2), (true, rays - rays / 2)] {
        let curve = closed_curve(flower, |p| p);
        let targets: Vec<SeamTarget> = (0..curve.piece_count())
            .flat_map(|piece| (0..500).map(move |k| (piece, f64::from(k) / 499.0)))
            .filter_map(|(piece, t)| curve.point(piece, t))
            .map(|uv| {
                let (point, su, sv) = waves.tangents(uv.x, uv.y);
                SeamTarget([point, su, sv])
            })
            .collect();
        // Reversed, the curve runs clockwise and is a hole.
        let turned = closed_curve(flower, |p| DVec2::new(1.0 - p.x, p.y));
        let faces = [face(&waves, curve), face(&other, turned)];
        let (slipped, both) = (AtomicU64::new(0), AtomicU64::new(0));
        let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
        std::thread::scope(|scope| {
            for thread in 0..threads {
                let (targets, faces, slipped, both) = (&targets, &faces, &slipped, &both);
                scope.spawn(move || {
                    let mut met = [Vec::new(), Vec::new()];
                    for start in (thread * BATCH..count).step_by((threads * BATCH) as usize) {
                        let rays = start..count.min(start + BATCH);
                        let rays: Vec<BoundedRay> =
                            rays.map(|index| BoundedRay::new(ray(targets, index), 2.0 * REACH)).collect();
                        for (face, met) in faces.iter().zip(&mut met) {
                            face.occluded_batch(&rays, met);
                        }
                        for ((bounded, &first), &second) in rays.iter().zip(&met[0]).zip(&met[1]) {
                            if !first && !second {
                                slipped.fetch_add(1, Ordering::Relaxed);
                                println!("{bounded:?} slips through");
                            }
                            both.fetch_add(u64::from(first && second), Ordering::Relaxed);
                        }
                        // A part of them one by one as well.
                        for (k, bounded) in rays.iter().enumerate().step_by(16) {
                            let single =
                                faces.each_ref().map(|face| face.occluded(&bounded.ray, bounded.t_max));
                            assert_eq!(single, [met[0][k], met[1][k]], "{bounded:?}");
                        }
                    }
                });
            }
        });
        let (slipped, both) = (slipped.into_inner(), both.into_inner());
        println!("{count} rays, {slipped} slip through, {both} meet both faces");
        assert_eq!(slipped, 0);
        // Both faces keep the border only, and most offsets are far larger.
        assert!(both > count / 100 && both < count / 2, "{both}");
    }
}
