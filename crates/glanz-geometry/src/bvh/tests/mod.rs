//! The tree against brute force, the box test against exact slabs, both on hard cases.

mod stream;

use glanz_math::{Bounds3, DVec3, Ray};

use super::node::UnitFrame;
use super::*;

/// Numbers that look random: the finaliser of splitmix64 over a counter.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }

    fn vector(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.next() * from.len() as f64) as usize]
    }
}

/// Entry of a ray into a box, whose border counts as inside; `None` if it misses.
fn slab(b: &Bounds3, ray: &Ray, t_max: f64) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, t_max);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d == 0.0 {
            if o < b.min[axis] || o > b.max[axis] {
                return None;
            }
        } else {
            let (p, q) = ((b.min[axis] - o) / d, (b.max[axis] - o) / d);
            enter = enter.max(p.min(q));
            leave = leave.min(p.max(q));
        }
    }
    (enter <= leave).then_some(enter)
}

fn boxes(random: &mut Random, count: usize, size: f64) -> Vec<Bounds3> {
    (0..count)
        .map(|_| {
            let (a, b) = (random.vector(1.0), random.vector(size));
            // Every fourth box is flat.
            let flat = if random.next() < 0.25 { DVec3::new(1.0, 0.0, 1.0) } else { DVec3::ONE };
            Bounds3::new(a, a + b * flat)
        })
        .collect()
}

/// A ray through a box, of a kind that is numerically difficult.
fn hard_ray(random: &mut Random, target: &Bounds3) -> Ray {
    let inside =
        target.min + (target.max - target.min) * DVec3::new(random.next(), random.next(), random.next());
    let corner = random.pick(&target.corners());
    let mut aim = random.pick(&[inside, corner, target.center()]);
    let mut direction = random.vector(1.0);
    for axis in 0..3 {
        match random.next() {
            x if x < 0.15 => direction[axis] = 0.0,
            x if x < 0.2 => direction[axis] = -0.0,
            x if x < 0.3 => direction[axis] *= 1e-14,
            // On the plane of a side of the box.
            x if x < 0.4 => aim[axis] = target.max[axis],
            _ => {}
        }
    }
    if direction == DVec3::ZERO {
        direction = DVec3::X;
    }
    let distance = random.pick(&[0.0, 1e-9, 0.1, 3.0, 1e4, 1e9]);
    Ray::new(aim - direction * distance, direction * random.pick(&[1.0, 1e-6, 1e20]))
}

#[test]
fn no_box_that_an_exact_ray_meets_is_ever_culled() {
    let mut random = Random(1);
    let mut met = 0;
    for round in 0..200 {
        // Tiny and huge scenes, near and far from the origin of the world.
        let scale = random.pick(&[1e-30, 1.0, 1e30]);
        let place = random.vector(1.0) * scale * random.pick(&[0.0, 1.0, 1e6]);
        let size = random.pick(&[1.0, 1e-3]);
        let cloud: Vec<Bounds3> = boxes(&mut random, 64, size)
            .iter()
            .map(|b| Bounds3 { min: b.min * scale + place, max: b.max * scale + place })
            .collect();
        let bvh = Bvh::build(&cloud, &BuildOptions { max_leaf: 1 + round % 4, ..Default::default() });
        let mut rays = Vec::new();
        for _ in 0..100 {
            let target = random.pick(&cloud);
            let local = Bounds3 { min: (target.min - place) / scale, max: (target.max - place) / scale };
            let ray = hard_ray(&mut random, &local);
            let ray = Ray::new(ray.origin * scale + place, ray.direction * scale);
            rays.push(ray.into());
            for isa in Isa::all() {
                let bvh = bvh.clone().with_isa(isa);
                let mut seen = vec![false; cloud.len()];
                bvh.closest(&ray, f64::INFINITY, |leaf, t_max| {
                    bvh.leaf(leaf).iter().for_each(|&i| seen[i as usize] = true);
                    t_max
                });
                for (b, seen) in cloud.iter().zip(seen) {
                    if slab(b, &ray, f64::INFINITY).is_some() {
                        met += 1;
                        assert!(seen, "{isa:?} {ray:?} misses {b:?} in {:?}", bvh.bounds());
                    }
                }
            }
        }
        let ends = stream::with_ends(&mut random, &cloud, &rays);
        for isa in Isa::all() {
            stream::assert_no_box_is_culled(isa, &bvh, &cloud, &rays);
            stream::assert_no_box_is_culled(isa, &bvh, &cloud, &ends);
        }
    }
    assert!(met > 20_000, "only {met} boxes met: the test tests nothing");
}

#[test]
fn closest_box_is_the_one_that_brute_force_finds() {
    let mut random = Random(2);
    for isa in Isa::all() {
        let cloud = boxes(&mut random, 3000, 0.1);
        let bvh = Bvh::build(&cloud, &BuildOptions::default()).with_isa(isa);
        let mut tested = 0;
        for _ in 0..2000 {
            let ray = Ray::new(random.vector(2.0), random.vector(1.0));
            let expected = cloud.iter().filter_map(|b| slab(b, &ray, f64::INFINITY)).min_by(f64::total_cmp);
            let mut found = None;
            bvh.closest(&ray, f64::INFINITY, |leaf, mut t_max| {
                for &i in bvh.leaf(leaf) {
                    tested += 1;
                    if let Some(t) = slab(&cloud[i as usize], &ray, t_max) {
                        t_max = t;
                        found = Some(t);
                    }
                }
                t_max
            });
            assert_eq!(found, expected);
            let any = bvh.any(&ray, f64::INFINITY, |leaf| {
                bvh.leaf(leaf).iter().any(|&i| slab(&cloud[i as usize], &ray, f64::INFINITY).is_some())
            });
            assert_eq!(any, expected.is_some());
        }
        // Brute force tests 3000 boxes per ray.
        assert!(tested < 2000 * 60, "{tested} boxes tested: the tree hardly culls");
    }
}

#[test]
fn far_origins_cost_no_more_than_near_ones() {
    let mut random = Random(3);
    let cloud = boxes(&mut random, 3000, 0.02);
    let bvh = Bvh::build(&cloud, &BuildOptions::default());
    let visits = |distance: f64| {
        let mut count = 0;
        let mut random = Random(4);
        for _ in 0..500 {
            let (aim, direction) = (random.vector(0.9), random.vector(1.0).normalize());
            bvh.closest(&Ray::new(aim - direction * distance, direction), f64::INFINITY, |_, t_max| {
                count += 1;
                t_max
            });
        }
        count
    };
    let (near, far) = (visits(4.0), visits(1e8));
    assert!(far <= near + near / 50, "{far} leaves from afar, {near} from nearby");
}

#[test]
fn invalid_rays_hit_nothing() {
    let bvh = Bvh::build(&[Bounds3::new(-DVec3::ONE, DVec3::ONE)], &BuildOptions::default());
    for isa in Isa::all() {
        for (origin, direction, t_max) in [
            (DVec3::NAN, DVec3::X, 1.0),
            (DVec3::ZERO, DVec3::new(1.0, f64::NAN, 0.0), 1.0),
            (DVec3::ZERO, DVec3::ZERO, 1.0),
            (DVec3::ZERO, DVec3::X, f64::NAN),
            (DVec3::ZERO, DVec3::X, -1.0),
            (DVec3::splat(f64::INFINITY), DVec3::X, 1.0),
        ] {
            let bvh = bvh.clone().with_isa(isa);
            assert!(!bvh.any(&Ray::new(origin, direction), t_max, |_| true), "{origin} {direction} {t_max}");
        }
    }
}

#[test]
fn one_box_is_tested_before_its_leaf_is_visited() {
    let cloud = [Bounds3::new(-DVec3::ONE, DVec3::ONE)];
    let bvh = Bvh::build(&cloud, &BuildOptions::default());
    assert!(bvh.any(&Ray::new(DVec3::new(0.0, 0.0, -5.0), DVec3::Z), 10.0, |_| true));
    assert!(!bvh.any(&Ray::new(DVec3::new(0.0, 3.0, -5.0), DVec3::Z), 10.0, |_| true));
    assert!(!bvh.any(&Ray::new(DVec3::new(0.0, 0.0, -5.0), DVec3::Z), 3.9, |_| true));
}

#[test]
fn empty_and_unbounded_boxes_are_left_out() {
    let infinite = Bounds3 { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    let nan = Bounds3 { min: DVec3::NAN, max: DVec3::NAN };
    let unit = Bounds3::new(DVec3::ZERO, DVec3::ONE);
    let bvh = Bvh::build(&[Bounds3::EMPTY, infinite, unit, nan], &BuildOptions::default());
    let all: Vec<u32> = bvh.leaves().flat_map(|leaf| bvh.leaf(leaf).to_vec()).collect();
    assert_eq!(all, [2]);
    assert_eq!(bvh.bounds(), unit);
    let none = Bvh::build(&[Bounds3::EMPTY], &BuildOptions::default());
    assert_eq!((none.leaf_count(), none.statistics().nodes), (0, 0));
    assert!(none.bounds().is_empty());
    assert!(!none.any(&Ray::new(DVec3::ZERO, DVec3::X), 1.0, |_| true));
}

/// Inputs on which a careless builder recurses without end or runs in quadratic time.
fn degenerate_clouds() -> Vec<Vec<Bounds3>> {
    let unit = Bounds3::new(DVec3::ZERO, DVec3::ONE);
    let cube = |x: f64| Bounds3::new(DVec3::splat(-x), DVec3::splat(x));
    vec![
        vec![unit; 100_000],
        // The same centre, growing sizes.
        (0..20_000).map(|i| cube(1.0 + f64::from(i))).collect(),
        // Sizes and distances that halve each time: every split peels off one box.
        (0..900)
            .map(|i| (-f64::from(i)).exp2())
            .map(|s| Bounds3::new(DVec3::splat(s), DVec3::splat(1.5 * s)))
            .collect(),
        (0..2000).map(|i| cube(1e-300 * f64::from(i))).collect(),
        (0..2000).map(|i| cube(1e300 * f64::from(i + 1) / 2000.0)).collect(),
        (0..50_000).map(|i| Bounds3::new(DVec3::X * f64::from(i), DVec3::X * f64::from(i))).collect(),
        vec![Bounds3::new(DVec3::ZERO, DVec3::ZERO); 10],
    ]
}

#[test]
fn degenerate_inputs_give_trees_of_bounded_depth_that_hold_every_box_once() {
    for cloud in degenerate_clouds() {
        let options = BuildOptions::default();
        let bvh = Bvh::build(&cloud, &options);
        let mut count = vec![0; cloud.len()];
        for leaf in bvh.leaves() {
            assert!((1..=options.max_leaf).contains(&bvh.leaf(leaf).len()));
            bvh.leaf(leaf).iter().for_each(|&i| count[i as usize] += 1);
        }
        assert!(count.iter().all(|&c| c == 1));
        assert!(bvh.statistics().depth <= build::MAX_DEPTH);
        assert_eq!(bvh.statistics().primitives, cloud.len());
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let cloud = boxes(&mut Random(5), 200_000, 0.01);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::build(&cloud, &BuildOptions::default()))
    };
    let (one, two) = (build(1), build(2));
    assert_eq!(one.items, two.items);
    assert_eq!(one.leaf_starts, two.leaf_starts);
    assert!(one.nodes.iter().zip(&two.nodes).all(|(a, b)| a.planes == b.planes && a.children == b.children));
    assert_eq!(one.statistics(), two.statistics());
}

#[test]
fn a_regular_grid_costs_at_most_what_octants_cost() {
    // 4096 unit cells of a 16^3 grid; an 8-wide tree that cuts every cell into 8 octants has 4 levels. A random line
    // meets the half area ratio 1/4 of the children each: 1 + 8/4 + 64/16 + 512/64 = 15 nodes, and 16 leaves of cost 2.
    let mut grid = Vec::new();
    for i in 0..4096 {
        let corner = DVec3::new(f64::from(i % 16), f64::from(i / 16 % 16), f64::from(i / 256));
        grid.push(Bounds3::new(corner, corner + 1.0));
    }
    let bvh = Bvh::build(&grid, &BuildOptions { max_leaf: 1, block: 1, leaf_cost: 2.0 });
    let cost = bvh.statistics().cost;
    assert!(cost <= 15.0 + 2.0 * 16.0 + 1e-3, "{cost}");
}

#[test]
fn the_unit_frame_rounds_outward() {
    let mut random = Random(6);
    for _ in 0..1000 {
        let place = random.vector(1.0) * random.pick(&[0.0, 1e3, 1e12]);
        let all = Bounds3::new(place - random.vector(1.0), place + random.vector(1.0));
        let frame = UnitFrame::around(&all);
        let part = Bounds3::new(all.min, all.center());
        let (min, max) = frame.bounds(&part);
        for axis in 0..3 {
            // Going back rounds by half an ulp of the result: exact again beyond the outward step.
            let (low, high) = (f64::from(min[axis]) * frame.unit(), f64::from(max[axis]) * frame.unit());
            assert!(low <= part.min[axis] - all.center()[axis]);
            assert!(high >= part.max[axis] - all.center()[axis]);
            assert!(low >= -frame.unit() * (1.0 + f64::from(f32::EPSILON)));
            assert!(high <= frame.unit() * (1.0 + f64::from(f32::EPSILON)));
        }
    }
}
