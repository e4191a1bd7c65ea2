//! Groups of pairs that must make room for pairs of another subpatch.

use glanz_math::{DVec3, Ray};

use super::super::pair_queue::PairQueue;
use super::super::{Freeform, SurfacePatch};
use crate::batch::BoundedRay;
use crate::bezier::TensorPatch;
use crate::surface::RaySurface;

/// Number of patches in a row.
const SIDE: usize = 7;

/// A square of unit patches of degree 5 with waves.
fn waves() -> Freeform {
    let patch = |place: usize| {
        let points = (0..36).map(|k| {
            let x = (place % SIDE) as f64 + (k / 6) as f64 / 5.0;
            let y = (place / SIDE) as f64 + (k % 6) as f64 / 5.0;
            DVec3::new(x, y, 0.3 * (2.3 * x).sin() * (1.7 * y).cos()).extend(1.0)
        });
        let patch = TensorPatch::try_new(5, 5, points.collect()).unwrap();
        SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
    };
    Freeform::try_new((0..SIDE * SIDE).map(patch).collect()).unwrap()
}

#[test]
fn a_group_is_taken_by_pairs_of_another_subpatch_only() {
    let mut queue = PairQueue::new();
    let groups = PairQueue::subpatch_groups().len() as u32;
    let (index, taken) = queue.index_of(3);
    assert!(!taken);
    queue.group_mut(index).push(0, 0, &[0.0; 8]);
    assert_eq!(queue.index_of(3), (index, false));
    assert_ne!(queue.index_of(4).0, index);
    assert_eq!(queue.index_of(3 + groups), (index, true));
}

#[test]
fn batches_that_alternate_between_subpatches_of_one_group_have_the_answers_of_single_rays() {
    let surface = waves();
    let groups = PairQueue::subpatch_groups().len();
    // Rays alternate between two patches whose numbers differ by that of the groups, so that pairs find their group taken. Some pairs
    // wait until the end.
    let ray = |k: usize| {
        let number = k / 2 % (SIDE * SIDE - groups) + k % 2 * groups;
        let at = |rate: f64| 0.5 + 0.45 * (rate * k as f64).sin();
        let target = DVec3::new((number % SIDE) as f64 + at(1.3), (number / SIDE) as f64 + at(2.1), 0.0);
        BoundedRay::from(Ray::new(target + DVec3::new(0.3 * at(0.7), -0.2, 2.0), DVec3::new(0.05, 0.1, -1.0)))
    };
    let rays: Vec<BoundedRay> = (0..3001).map(ray).collect();
    let single: Vec<_> = rays.iter().map(|b| surface.intersect(&b.ray, b.t_max)).collect();
    assert!(single.iter().flatten().count() > 2500);
    for size in [1, 2, 9, 3001] {
        let mut hits = Vec::new();
        for (rays, single) in rays.chunks(size).zip(single.chunks(size)) {
            surface.closest_batch(rays, &mut hits);
            assert_eq!(hits, single, "batches of {size}");
        }
    }
}
