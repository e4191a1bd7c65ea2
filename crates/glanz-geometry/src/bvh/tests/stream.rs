//! Streams of rays against brute force, with rays that end.

use glanz_math::{Bounds3, Ray};

use super::super::simd::lanes::LANES;
use super::super::stream::{StreamScratch, StreamVisitor};
use super::super::{BuildOptions, Bvh, BvhLeaf, CompactRay, Isa, Simd, Task};
use super::{Random, boxes, slab};
use crate::batch::BoundedRay;

/// The boxes that each ray of a stream visits.
struct VisitedBoxes<'a> {
    bvh: &'a Bvh,
    rays: &'a [BoundedRay],
    /// Whether a ray visits a box.
    seen: Vec<Vec<bool>>,
}

impl StreamVisitor for VisitedBoxes<'_> {
    fn prepare<S: Simd>(&mut self, _: S, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            rays[id as usize].slot = id + 1;
        }
    }

    fn leaf<S: Simd>(&mut self, _: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            assert_eq!(rays[id as usize].slot, id + 1, "rays are prepared before leaves");
            let seen = &mut self.seen[id as usize];
            self.bvh.leaf(leaf).iter().for_each(|&i| seen[i as usize] = true);
        }
    }

    fn pairs<S: Simd>(
        &mut self,
        simd: S,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        count: usize,
        rays: &mut [CompactRay],
    ) {
        for (leaf, id) in leaves.iter().zip(ids).take(count) {
            self.leaf(simd, *leaf, &[*id], rays);
        }
    }

    fn finish<S: Simd>(&mut self, _: S, _: &mut [CompactRay]) {}

    fn prefetch<S: Simd>(&self, _: S, _: BvhLeaf) {}
}

impl Task for VisitedBoxes<'_> {
    type Output = Vec<Vec<bool>>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Vec<Vec<bool>> {
        let (bvh, rays) = (self.bvh, self.rays);
        bvh.stream(simd, rays, &mut StreamScratch::default(), &mut self);
        self.seen
    }
}

/// The rays with ends: before, at and behind a box that they meet, at the origin, and before it.
pub(super) fn with_ends(random: &mut Random, cloud: &[Bounds3], rays: &[BoundedRay]) -> Vec<BoundedRay> {
    let bounded = |&BoundedRay { ray, .. }: &BoundedRay| {
        let entries: Vec<f64> = cloud.iter().filter_map(|b| slab(b, &ray, f64::INFINITY)).collect();
        let entry = if entries.is_empty() { 1.0 } else { random.pick(&entries) };
        BoundedRay::new(ray, entry * random.pick(&[0.0, 0.5, 1.0, 1.0 + 1e-9, 2.0, -1.0]))
    };
    rays.iter().map(bounded).collect()
}

/// Asserts that the stream visits every box that a ray meets before its end.
pub(super) fn assert_no_box_is_culled(isa: Isa, bvh: &Bvh, cloud: &[Bounds3], rays: &[BoundedRay]) {
    let visits = VisitedBoxes { bvh, rays, seen: vec![vec![false; cloud.len()]; rays.len()] };
    for (bounded, seen) in rays.iter().zip(isa.run(visits)) {
        for (b, seen) in cloud.iter().zip(seen) {
            let met = slab(b, &bounded.ray, bounded.t_max).is_some();
            assert!(seen || !met, "{isa:?} {bounded:?} misses {b:?} in {:?}", bvh.bounds());
        }
    }
}

/// The search for the first box that each ray of a stream meets.
struct ClosestBoxes<'a> {
    bvh: &'a Bvh,
    cloud: &'a [Bounds3],
    rays: &'a [BoundedRay],
    entries: Vec<Option<f64>>,
    /// Number of tests of a box.
    tested: usize,
}

impl StreamVisitor for ClosestBoxes<'_> {
    fn prepare<S: Simd>(&mut self, _: S, _: &[u32], _: &mut [CompactRay]) {}

    fn leaf<S: Simd>(&mut self, _: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            let (bounded, entry) = (&self.rays[id as usize], &mut self.entries[id as usize]);
            for &index in self.bvh.leaf(leaf) {
                self.tested += 1;
                let end = entry.unwrap_or(bounded.t_max);
                if let Some(t) = slab(&self.cloud[index as usize], &bounded.ray, end) {
                    *entry = Some(t);
                    rays[id as usize].shorten(t);
                }
            }
        }
    }

    fn pairs<S: Simd>(
        &mut self,
        simd: S,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        count: usize,
        rays: &mut [CompactRay],
    ) {
        for (leaf, id) in leaves.iter().zip(ids).take(count) {
            self.leaf(simd, *leaf, &[*id], rays);
        }
    }

    fn finish<S: Simd>(&mut self, _: S, _: &mut [CompactRay]) {}

    fn prefetch<S: Simd>(&self, _: S, _: BvhLeaf) {}
}

impl Task for ClosestBoxes<'_> {
    type Output = (Vec<Option<f64>>, usize);

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> (Vec<Option<f64>>, usize) {
        let (bvh, rays) = (self.bvh, self.rays);
        bvh.stream(simd, rays, &mut StreamScratch::default(), &mut self);
        (self.entries, self.tested)
    }
}

#[test]
fn closest_box_before_the_end_of_a_ray_is_the_one_that_brute_force_finds() {
    let mut random = Random(7);
    let cloud = boxes(&mut random, 3000, 0.1);
    let bvh = Bvh::build(&cloud, &BuildOptions::default());
    let rays: Vec<BoundedRay> = (0..1000)
        .map(|_| {
            let origin = random.vector(2.0);
            Ray::new(origin, random.vector(1.5) - origin).into()
        })
        .collect();
    let ends = with_ends(&mut random, &cloud, &rays);
    for rays in [rays, ends] {
        let first =
            |b: &BoundedRay| cloud.iter().filter_map(|c| slab(c, &b.ray, b.t_max)).min_by(f64::total_cmp);
        let expected: Vec<Option<f64>> = rays.iter().map(first).collect();
        assert!(expected.iter().flatten().count() > 300 && expected.contains(&None));
        for isa in Isa::all() {
            // Streams of many rays, and of one or two, which have no lists.
            for size in [1, 2, 1000] {
                let mut tested = 0;
                for (rays, expected) in rays.chunks(size).zip(expected.chunks(size)) {
                    let entries = vec![None; rays.len()];
                    let search = ClosestBoxes { bvh: &bvh, cloud: &cloud, rays, entries, tested: 0 };
                    let (entries, count) = isa.run(search);
                    assert_eq!(entries, expected, "{isa:?}, streams of {size}");
                    tested += count;
                }
                // Brute force tests 3000 boxes per ray.
                assert!(tested < 1000 * 60, "{isa:?}, streams of {size}: {tested} boxes tested");
            }
        }
    }
}

#[test]
fn rays_that_end_before_the_tree_visit_no_leaf() {
    let mut random = Random(8);
    let cloud = boxes(&mut random, 500, 0.1);
    let bvh = Bvh::build(&cloud, &BuildOptions::default());
    let rays: Vec<BoundedRay> = (0..500)
        .map(|_| {
            let direction = random.vector(1.0).normalize();
            let ray = Ray::new(random.vector(0.5) - 5.0 * direction, direction);
            let entry = slab(&bvh.bounds(), &ray, f64::INFINITY).unwrap();
            BoundedRay::new(ray, 0.99 * entry)
        })
        .collect();
    for isa in Isa::all() {
        let visits =
            VisitedBoxes { bvh: &bvh, rays: &rays, seen: vec![vec![false; cloud.len()]; rays.len()] };
        assert!(isa.run(visits).concat().iter().all(|seen| !seen), "{isa:?}");
    }
}
