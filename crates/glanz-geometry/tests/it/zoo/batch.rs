//! Batches of rays against the same rays one by one.

use std::sync::Arc;

use glanz_geometry::trim::{TrimCurve, TrimLoop, TrimRegion};
use glanz_geometry::{BoundedRay, Hit, RaySurface, Surface, SurfacePoint};
use glanz_math::DVec2;

use super::rays::{Random, RayFamily};
use super::test_surface::TestSurface;
use super::{collection, number};

/// Chords and adversarial rays in equal parts, some of which end before, at, or behind their first hit.
fn rays(tested: &TestSurface, surface: &impl RaySurface, count: u64) -> Vec<BoundedRay> {
    let random = &mut Random::new(count);
    (0..count)
        .map(|index| {
            let family = match index % 2 {
                0 => RayFamily::Chord,
                _ => RayFamily::ADVERSARIAL[(index / 2 % 10) as usize],
            };
            let ray = family.ray(tested, random);
            let first = surface.intersect(&ray, f64::INFINITY).map_or(1.0, |hit| hit.t);
            let factors = [f64::INFINITY, f64::INFINITY, 1.0, 0.5, 1.0 + f64::EPSILON, 1.5];
            let t_max = first * factors[random.below(factors.len())];
            BoundedRay { ray, t_max }
        })
        .collect()
}

fn shuffled(mut rays: Vec<BoundedRay>) -> Vec<BoundedRay> {
    let random = &mut Random::new(7);
    for i in (1..rays.len()).rev() {
        rays.swap(i, random.below(i + 1));
    }
    rays
}

/// Number of times that [`compare`] traces each ray.
const QUERIES: u64 = 2 * (2 + 5 * 2);

/// The numbers of a point, as bits.
fn point_bits(point: &SurfacePoint) -> [u64; 20] {
    let SurfacePoint { position, error, normal, shading_normal, uv, dpdu, dpdv } = point;
    let mut bits = [0; 20];
    let vectors = [position, error, normal, shading_normal, dpdu, dpdv].map(|v| v.to_array());
    for (bits, x) in bits.iter_mut().zip(vectors.into_iter().flatten().chain(uv.to_array())) {
        *bits = x.to_bits();
    }
    bits
}

/// Compares the points of a batch of hits with those of single hits, bit by bit.
fn compare_points(name: &str, surface: &impl RaySurface, rays: &[BoundedRay], hits: &[Option<Hit>]) {
    let met = rays.iter().zip(hits).filter_map(|(bounded, hit)| Some((bounded.ray, (*hit)?)));
    let (rays, hits): (Vec<_>, Vec<_>) = met.unzip();
    let mut points = Vec::new();
    surface.point_batch(&rays, &hits, &mut points);
    assert_eq!(points.len(), hits.len());
    for ((ray, hit), point) in rays.iter().zip(&hits).zip(&points) {
        assert_eq!(point_bits(point), point_bits(&surface.point(ray, hit)), "{name}: {hit:?}");
    }
}

/// Compares batches of 1 to 9000 rays, in order and shuffled, with single rays, bit by bit.
fn compare(name: &str, surface: &impl RaySurface, rays: Vec<BoundedRay>) {
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    let bits = |hit: &Option<Hit>| hit.map(|h| (h.face, [h.t, h.u, h.v].map(f64::to_bits)));
    for rays in [rays.clone(), shuffled(rays)] {
        let single: Vec<_> = rays.iter().map(|b| surface.intersect(&b.ray, b.t_max)).collect();
        for (bounded, single) in rays.iter().zip(&single) {
            assert_eq!(
                surface.occluded(&bounded.ray, bounded.t_max),
                single.is_some(),
                "{name}: {bounded:?}"
            );
        }
        for size in [1, 7, 64, 4096, 9000] {
            for (part, single) in rays.chunks(size).zip(single.chunks(size)) {
                surface.closest_batch(part, &mut hits);
                surface.occluded_batch(part, &mut occluded);
                assert_eq!((hits.len(), occluded.len()), (part.len(), part.len()));
                compare_points(name, surface, part, &hits);
                for (((bounded, single), hit), &occluded) in part.iter().zip(single).zip(&hits).zip(&occluded)
                {
                    assert_eq!(bits(hit), bits(single), "{name}, batches of {size}: {bounded:?}");
                    assert_eq!(occluded, single.is_some(), "{name}, batches of {size}: {bounded:?}");
                }
            }
        }
    }
}

#[test]
fn batches_give_the_bits_of_single_rays() {
    let surfaces = collection::all();
    let count = number("GLANZ_ZOO_RAYS", 6_000).div_ceil(surfaces.len() as u64);
    for tested in &surfaces {
        let rays = rays(tested, &tested.surface, count);
        let before = tested.surface.undecided();
        for bounded in &rays {
            tested.surface.all_hits(&bounded.ray, f64::INFINITY, &mut Vec::new());
        }
        let undecided = tested.surface.undecided() - before;
        compare(&tested.name, &tested.surface, rays);
        // No query visits more leaves than that for all hits.
        let queries = tested.surface.undecided() - before - undecided;
        assert!(queries <= QUERIES * undecided, "{}: {queries} undecided, not {undecided}", tested.name);
    }
}

#[test]
fn batches_of_trimmed_surfaces_give_the_bits_of_single_rays() {
    let circle = TrimCurve::try_circle(DVec2::splat(0.5), 0.37).unwrap();
    let kept = TrimLoop::try_closed(circle, 1e-9).unwrap();
    // A border wide enough that many hits lie in it, which batches find as well.
    let region = TrimRegion::try_new(vec![kept], [DVec2::ZERO, DVec2::ONE]).unwrap();
    let region = Arc::new(region.with_widened_border(0.03).unwrap());
    let surfaces = collection::all();
    let count = number("GLANZ_ZOO_RAYS", 20_000).div_ceil(surfaces.len() as u64);
    for tested in surfaces.iter().step_by(3) {
        let surface = Surface::from(tested.surface.trimmed(region.clone()));
        compare(&tested.name, &surface, rays(tested, &surface, count));
    }
}

#[test]
fn long_batches_of_close_rays_give_the_bits_of_single_rays() {
    let surfaces = collection::all();
    let tested = surfaces.iter().max_by_key(|tested| tested.patches.len()).unwrap();
    // From one point, as those of a camera, so that lists are long.
    let random = &mut Random::new(3);
    let eye = tested.center + random.direction() * (3.0 * tested.size);
    let rays = (0..9000).map(|index| {
        let to = tested.center + random.direction() * (tested.size * random.unit());
        let t_max = if index % 50 == 0 { f64::NAN } else { f64::INFINITY };
        BoundedRay { ray: glanz_math::Ray::new(eye, to - eye), t_max }
    });
    compare(&tested.name, &tested.surface, rays.collect());
}

#[test]
fn special_rays_have_the_answers_of_single_rays() {
    use glanz_math::{DVec3, Ray};
    let surfaces = collection::all();
    let (first, second) = (&surfaces[0], surfaces.last().unwrap());
    let at = first.center + DVec3::new(0.3, 0.2, 3.0) * first.size;
    let origins = [at, DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e30), first.center, DVec3::ZERO];
    let directions =
        [first.center - at, DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::X, -DVec3::Z * 1e-300];
    let ends = [f64::INFINITY, 1.0, 0.0, -0.0, -1.0, f64::NEG_INFINITY, f64::NAN, f64::MIN_POSITIVE];
    let mut rays = Vec::new();
    for (origin, direction) in origins.iter().flat_map(|o| directions.iter().map(move |d| (*o, *d))) {
        rays.extend(ends.map(|t_max| BoundedRay { ray: Ray::new(origin, direction), t_max }));
    }
    // Two surfaces in turns, which share the memory of the thread.
    for _ in 0..2 {
        compare(&first.name, &first.surface, rays.clone());
        compare(&second.name, &second.surface, rays.clone());
    }
    let mut hits = vec![None; 3];
    first.surface.closest_batch(&[], &mut hits);
    assert!(hits.is_empty());
}
