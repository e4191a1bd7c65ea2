use glanz_sampling::statistics::chi_square;
use glanz_sampling::{PixelSampler, SamplerKind};

use super::*;

/// A tree trained with `light` per steradian in a few passes; the root is 0.
fn learnt(light: impl Fn(DVec3) -> f64) -> DirectionTrees {
    let mut trees = DirectionTrees::default();
    trees.push_blank();
    for _ in 0..8 {
        let grid = 512;
        let mut sums = vec![0.0; 16 * trees.0.len()];
        for i in 0..grid * grid {
            let place = DVec2::new(f64::from(i % grid) + 0.5, f64::from(i / grid) + 0.5) / f64::from(grid);
            let direction = equal_area_sphere(place);
            sums[trees.pdf(0, direction).1 as usize] += light(direction);
        }
        let tree = trees.refined(0, f64::INFINITY, &|leaf| sums[leaf.number as usize]).unwrap();
        trees = DirectionTrees::default();
        trees.push(&tree);
    }
    trees
}

/// A tree trained with a light of 0.1 rad around (0.6, 0, 0.8) and a dim sky.
fn spot() -> DirectionTrees {
    learnt(|d| if d.dot(DVec3::new(0.6, 0.0, 0.8)) > 0.995 { 100.0 } else { d.z.max(0.0) })
}

fn points(count: u32) -> impl Iterator<Item = DVec2> {
    (0..count).map(move |i| PixelSampler::new(SamplerKind::Sobol, count, 3, [1, 2], i).next_2d())
}

#[test]
fn density_integrates_to_one_over_the_sphere() {
    let trees = spot();
    // The map preserves areas: the integral is the mean over the square times 4 pi. Leaves are unions of the grid's cells.
    let grid = 1024;
    let sum: f64 = (0..grid * grid)
        .map(|i| DVec2::new(f64::from(i % grid) + 0.5, f64::from(i / grid) + 0.5) / f64::from(grid))
        .map(|place| trees.pdf(0, equal_area_sphere(place)).0)
        .sum();
    let integral = sum * 4.0 * PI / f64::from(grid * grid);
    assert!((integral - 1.0).abs() < 1e-6, "{integral}");
}

#[test]
fn sample_states_the_density_and_the_leaf_of_its_direction() {
    let trees = spot();
    for xi in points(4096) {
        let draw = trees.sample(0, xi).unwrap();
        let (pdf, leaf) = trees.pdf(0, draw.direction);
        assert!((draw.direction.length() - 1.0).abs() < 1e-12);
        // Directions within rounding of a border may fall to the other side, which happens to none of these.
        assert_eq!(draw.leaf, leaf);
        assert!((draw.pdf - pdf).abs() < 1e-12 * pdf, "{} {pdf}", draw.pdf);
    }
}

#[test]
fn samples_follow_the_density() {
    // Independent numbers, 64 x 64 cells of the square; alpha 0.001.
    let (trees, side, count) = (spot(), 64_usize, 200_000);
    let mut observed = vec![0_u64; side * side];
    for i in 0..count {
        let xi = PixelSampler::new(SamplerKind::Independent, count, 5, [0, 0], i).next_2d();
        let place = equal_area_sphere_inverse(trees.sample(0, xi).unwrap().direction) * side as f64;
        observed[place.y as usize * side + place.x as usize] += 1;
    }
    let fine = 16;
    let expected: Vec<f64> = (0..side * side)
        .map(|cell| {
            let corner = DVec2::new((cell % side) as f64, (cell / side) as f64);
            let mean: f64 = (0..fine * fine)
                .map(|i| DVec2::new((i % fine) as f64 + 0.5, (i / fine) as f64 + 0.5) / fine as f64)
                .map(|inside| trees.pdf(0, equal_area_sphere((corner + inside) / side as f64)).0)
                .sum::<f64>()
                / (fine * fine) as f64;
            mean * 4.0 * PI / (side * side) as f64 * f64::from(count)
        })
        .collect();
    let test = chi_square(&observed, &expected);
    assert!(test.p_value > 0.001, "{test:?}");
}

#[test]
fn leaves_are_small_in_directions_of_light_and_large_elsewhere() {
    let trees = spot();
    let size = |direction| {
        let (mut node, mut level, mut place) = (0, 1, equal_area_sphere_inverse(direction));
        loop {
            place *= 4.0;
            let part = 4 * place.x as usize + place.y as usize;
            place = place.fract();
            match trees.0[node].child[part] {
                NONE => break level,
                child => (node, level) = (usize::from(child), level + 1),
            }
        }
    };
    assert!(size(DVec3::new(0.6, 0.0, 0.8)) >= 3);
    // Below the horizon there is no light.
    assert_eq!(size(DVec3::new(0.6, 0.0, -0.8)), 1);
    assert!(trees.0.len() < 60, "{}", trees.0.len());
    assert_eq!(trees.pdf(0, -DVec3::Z).0, 0.0);
}

#[test]
fn well_distributed_numbers_give_well_distributed_directions() {
    // The integral of z^2 over the sphere is 4 pi / 3. Over 16 estimates of 4096 samples, the error with Sobol points is less than
    // 0.6 of that with independent numbers: the descent preserves their stratification.
    let trees = learnt(|d| d.z * d.z);
    let error = |kind| {
        let squares = (0..16).map(|seed| {
            let sum: f64 = (0..4096)
                .map(|i| PixelSampler::new(kind, 4096, seed, [1, 2], i).next_2d())
                .filter_map(|xi| trees.sample(0, xi))
                .map(|draw| draw.direction.z.powi(2) / draw.pdf)
                .sum();
            (sum / 4096.0 - 4.0 * PI / 3.0).powi(2)
        });
        (squares.sum::<f64>() / 16.0).sqrt()
    };
    let (spread, independent) = (error(SamplerKind::Sobol), error(SamplerKind::Independent));
    assert!(spread < 0.6 * independent, "{spread} {independent}");
}

#[test]
fn trees_without_light_give_no_direction() {
    let mut trees = DirectionTrees::default();
    let root = trees.push_blank();
    assert_eq!(trees.0.len(), 1 + 16);
    assert!(!trees.is_lit(root) && trees.sample(root, DVec2::splat(0.5)).is_none());
    assert_eq!(trees.pdf(root, DVec3::X).0, 0.0);
    assert!(trees.refined(root, 1e6, &|_| 0.0).is_none());
}

#[test]
fn invalid_trees_are_refused() {
    let good = spot();
    assert!(good.is_valid([0].into_iter()));
    let with = |change: &dyn Fn(&mut Vec<QuadtreeNode>)| {
        let mut trees = good.clone();
        change(&mut trees.0);
        trees.is_valid([0].into_iter())
    };
    let shared = good.0[0].child.into_iter().find(|&child| child != NONE).unwrap();
    assert!(!with(&|trees| trees[0].child = [shared; 16]));
    assert!(!with(&|trees| trees[0].child[1] = u16::MAX));
    assert!(!with(&|trees| trees.last_mut().unwrap().child[0] = 1));
    assert!(!with(&|trees| trees[0].share[0] ^= 1));
    assert!(!with(&|trees| trees.push(QuadtreeNode::default())));
    assert!(!good.is_valid([0, 0].into_iter()) && !good.is_valid([1 << 20].into_iter()));
}

#[test]
fn leaves_store_their_fraction_of_the_tree() {
    let trees = spot();
    // A tree refined with its own fractions stays the same; the sum over all leaves is 1.
    assert!((trees.total(0, &|leaf| leaf.share) - 1.0).abs() < 1e-12);
    let same = trees.refined(0, f64::INFINITY, &|leaf| 7.0 * leaf.share).unwrap();
    assert_eq!(same, trees.tree(0));
    assert_eq!(trees.tree(0), trees.0);
}

#[test]
fn few_samples_are_spread_evenly_and_many_are_not() {
    let light: [f64; 16] = std::array::from_fn(|i| if i == 3 { 1.0 } else { 0.0 });
    let mut trees = DirectionTrees::default();
    trees.push_blank();
    let shares = |effective| {
        let found =
            |leaf: QuadtreeLeaf| if leaf.number < 16 { 0.0 } else { light[leaf.number as usize % 16] };
        trees.refined(0, effective, &found).unwrap()[0].share
    };
    // All nodes of the second level are equal: the root is uniform with any number of samples.
    assert!(shares(4.0).iter().all(|&share| share.abs_diff(4096) <= 16));
    let one = |effective| {
        let found = |leaf: QuadtreeLeaf| if leaf.number / 16 == 4 { 1.0 } else { 0.0 };
        trees.refined(0, effective, &found).unwrap()[0].share
    };
    // n samples in one part and four spread evenly: (n + 4/16) / (n + 4).
    for n in [4.0, 60.0, 1e6] {
        let expected = (n + 0.25) / (n + 4.0) * f64::from(WHOLE);
        let largest = one(n).into_iter().max().unwrap();
        assert!((f64::from(largest) - expected).abs() < 16.0, "{n}: {largest} {expected}");
    }
}
