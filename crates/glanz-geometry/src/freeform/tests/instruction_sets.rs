//! The same bits with all instructions that the processor has, for single rays and for batches.

use glanz_math::{DVec3, Ray};

use super::super::{Freeform, SurfacePatch};
use super::plate;
use crate::batch::BoundedRay;
use crate::bezier::TensorPatch;
use crate::bvh::simd::Isa;
use crate::hit::{Hit, SurfacePoint};
use crate::surface::RaySurface;

/// A patch of waves over a square with as many metres a side as its degree.
fn wave(degree: usize, weight: fn(usize) -> f64) -> Freeform {
    let points = (0..(degree + 1) * (degree + 1)).map(|k| {
        let (i, j) = (k / (degree + 1), k % (degree + 1));
        let p = DVec3::new(i as f64, j as f64, (2.1 * k as f64).sin());
        (p * weight(k)).extend(weight(k))
    });
    let patch = TensorPatch::try_new(degree, degree, points.collect()).unwrap();
    Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()]).unwrap()
}

fn even(_: usize) -> f64 {
    1.0
}

fn uneven(k: usize) -> f64 {
    1.0 + 0.5 * (k as f64).cos()
}

#[test]
fn every_instruction_set_gives_the_same_hits() {
    for mut surface in [wave(3, even), wave(2, uneven), wave(3, uneven), wave(5, uneven)] {
        let mut answers = Vec::new();
        for isa in Isa::all() {
            surface.bvh = surface.bvh.clone().with_isa(isa);
            let mut hits = Vec::new();
            for k in 0..2000 {
                let (a, b) = (f64::from(k % 50) * 0.1, f64::from(k / 50) * 0.1);
                let ray = Ray::new(DVec3::new(a, b, 4.0), DVec3::new(0.3 * b, 0.2 * a - 0.4, -4.0));
                surface.all_hits(&ray, f64::INFINITY, &mut hits);
                hits.extend(surface.intersect(&ray, f64::INFINITY));
            }
            answers.push(hits);
        }
        assert!(answers[0].len() > 500, "{}", answers[0].len());
        assert!(answers.windows(2).all(|pair| pair[0] == pair[1]));
    }
}

/// Rays from a point above the surface, as those of a camera, and rays in all directions; some end before, at or behind a hit.
fn bounded_rays(surface: &Freeform) -> Vec<BoundedRay> {
    let bounds = surface.bounds();
    let (center, size) = (bounds.center(), bounds.diagonal().length());
    let ray = |k: u32| {
        let turn = |rate: f64| (rate * f64::from(k)).sin();
        let target = center + 0.4 * size * DVec3::new(turn(1.3), turn(2.7), 0.3 * turn(3.1));
        let origin = match k % 2 {
            0 => center + size * DVec3::new(0.2, -0.3, 1.0),
            _ => center + 1.5 * size * DVec3::new(turn(0.7), turn(1.9), turn(4.1)),
        };
        let ray = Ray::new(origin, target - origin);
        let first = surface.intersect(&ray, f64::INFINITY).map_or(1.0, |hit| hit.t);
        let factors = [f64::INFINITY, 0.5, 1.0, 1.0 + f64::EPSILON, 2.0];
        BoundedRay::new(ray, first * factors[k as usize % factors.len()])
    };
    (0..1500).map(ray).collect()
}

/// The hits of single rays with the present instructions.
fn single_hits(surface: &Freeform, rays: &[BoundedRay]) -> Vec<Option<Hit>> {
    rays.iter().map(|BoundedRay { ray, t_max }| surface.intersect(ray, *t_max)).collect()
}

#[test]
fn every_instruction_set_gives_batches_the_answers_of_single_rays() {
    // Patches that lanes solve as polynomials, as rational ones and as nets, patches that they leave to single rays, and
    // roots in leaves that a trimming curve crosses.
    let trimmed = wave(3, uneven).trimmed(plate(0.2, 0.0));
    let (high, net) = (wave(10, even), wave(5, uneven));
    for mut surface in [wave(3, even), wave(2, uneven), wave(3, uneven), trimmed, net, high] {
        let rays = bounded_rays(&surface);
        let expected = single_hits(&surface, &rays);
        let met = expected.iter().flatten().count();
        assert!(met > 200 && met + 200 < rays.len(), "{met} of {} rays hit", rays.len());
        let (of_hits, found): (Vec<Ray>, Vec<Hit>) =
            rays.iter().zip(&expected).filter_map(|(bounded, hit)| Some((bounded.ray, (*hit)?))).unzip();
        // As text, which tells the signs of zeros apart.
        let text = |points: &[SurfacePoint]| format!("{points:?}");
        let points: Vec<SurfacePoint> = found.iter().map(|hit| surface.point(&rays[0].ray, hit)).collect();
        let is_hit: Vec<bool> = expected.iter().map(Option::is_some).collect();
        for isa in Isa::all() {
            surface.bvh = surface.bvh.clone().with_isa(isa);
            assert!(single_hits(&surface, &rays) == expected, "{isa:?}, one by one");
            let (mut hits, mut occluded) = (Vec::new(), Vec::new());
            surface.closest_batch(&rays, &mut hits);
            surface.occluded_batch(&rays, &mut occluded);
            for (index, bounded) in rays.iter().enumerate() {
                assert_eq!(hits[index], expected[index], "{isa:?}: {bounded:?}");
                assert_eq!(occluded[index], is_hit[index], "{isa:?}: {bounded:?}");
            }
            assert_eq!((hits.len(), occluded.len()), (rays.len(), rays.len()));
            let mut at_hits = Vec::new();
            surface.point_batch(&of_hits, &found, &mut at_hits);
            assert_eq!(text(&at_hits), text(&points), "{isa:?}");
        }
    }
}
