//! Stratification, unbiasedness and convergence of the scrambled sequence, and the samplers that use it.

use glanz_math::DVec2;
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::sequence::owen::{ScrambledSobol, scramble, unit};
use glanz_sampling::statistics::chi_square;
use glanz_sampling::{PixelSampler, SamplerKind};

fn sobol(pixel: [u32; 2], index: u32) -> PixelSampler {
    PixelSampler::new(SamplerKind::Sobol, 16, 5, pixel, index)
}

/// Whether each dyadic box of volume 1 / n, of any shape, contains one of the n points (n a power of two).
fn is_net(points: &[[u32; 2]]) -> bool {
    let bits = points.len().trailing_zeros();
    (0..=bits).all(|a| {
        let b = bits - a;
        // A shift by 32 bits leaves 0.
        let cell = |p: &[u32; 2]| (u64::from(p[0]) >> (32 - a)) << b | u64::from(p[1]) >> (32 - b);
        let mut seen = vec![false; points.len()];
        points.iter().for_each(|p| seen[cell(p) as usize] = true);
        seen.iter().all(|&s| s)
    })
}

#[test]
fn every_aligned_block_of_the_first_pair_is_a_net() {
    for key in 0..20 {
        let copy = ScrambledSobol::new(combine(31, key));
        let points: Vec<[u32; 2]> = (0..1024_u32).map(|i| copy.pair(i.reverse_bits(), 0)).collect();
        for bits in 0..=10 {
            assert!(points.chunks_exact(1 << bits).all(is_net), "key {key}, blocks of 2^{bits}");
        }
    }
}

#[test]
fn every_aligned_block_of_each_dimension_is_stratified() {
    for d in 0..4 {
        let copy = ScrambledSobol::new(combine(32, d));
        let values: Vec<u32> = (0..256_u32).map(|i| copy.coordinate(i.reverse_bits(), d as usize)).collect();
        for bits in 1..=8_u32 {
            for block in values.chunks_exact(1 << bits) {
                let mut seen = vec![false; block.len()];
                block.iter().for_each(|v| seen[(v >> (32 - bits)) as usize] = true);
                assert!(seen.iter().all(|&s| s), "dimension {d}, block of 2^{bits}");
            }
        }
    }
}

#[test]
fn single_coordinates_agree_with_pairs() {
    let copy = ScrambledSobol::new(99);
    for i in [0_u32, 1, 77, u32::MAX] {
        for pair in 0..2 {
            let both = [copy.coordinate(i, 2 * pair), copy.coordinate(i, 2 * pair + 1)];
            assert_eq!(copy.pair(i, pair), both);
        }
    }
}

#[test]
fn scrambling_is_nested_a_bijection_and_flips_half() {
    for key in 0..200 {
        let seed = combine(33, key) as u32;
        let (x, y) = (combine(34, key) as u32, combine(35, key) as u32);
        for bits in 1..32 {
            // Equal leading bits stay equal, and different ones stay different.
            let other = (x >> bits << bits) | (y & ((1 << bits) - 1));
            assert_eq!(scramble(x, seed) >> bits, scramble(other, seed) >> bits);
            assert_ne!(scramble(x, seed) >> (bits - 1), scramble(x ^ 1 << (bits - 1), seed) >> (bits - 1));
        }
    }
    // The leading bits of one value over many seeds are uniform.
    for x in [0, 1, 0x8000_0000, 0xdead_beef] {
        let mut counts = [0; 64];
        (0..64_000).for_each(|k| counts[(scramble(x, combine(36, k) as u32) >> 26) as usize] += 1);
        let test = chi_square(&counts, &[1000.0; 64]);
        assert!(test.p_value > 0.001 / 4.0, "{x:x}: {test:?}");
    }
}

/// Root mean square error over many copies of the mean of `f` over `n` points.
fn rms_error(n: u32, exact: f64, f: impl Fn(DVec2) -> f64) -> f64 {
    let copies = 256;
    let squares: f64 = (0..copies)
        .map(|key| {
            let copy = ScrambledSobol::new(combine(37, key));
            let sum: f64 = (0..n)
                .map(|i| {
                    let [x, y] = copy.pair(i.reverse_bits(), 0);
                    f(DVec2::new(unit(x), unit(y)))
                })
                .sum();
            (sum / f64::from(n) - exact).powi(2)
        })
        .sum();
    (squares / copies as f64).sqrt()
}

#[test]
fn error_of_a_smooth_integrand_decreases_like_n_to_the_minus_three_halves() {
    // Owen: N^-1.5 (log N)^0.5 in two dimensions. x y has mean 1/4, variance 7/144.
    let f = |p: DVec2| p.x * p.y;
    let errors: Vec<f64> = [16, 256, 4096].map(|n| rms_error(n, 0.25, f)).to_vec();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log(16.0);
        // Over a factor of 16 the logarithm costs at most log_16(sqrt(2)) = 0.125; the estimates from 256 copies
        // err by 1 / sqrt(512) = 4 % each, 0.02 in the order.
        assert!((1.3..1.7).contains(&order), "order {order}, errors {errors:?}");
    }
    // Independent points would be at sqrt(7 / 144 / 4096) = 3.4e-3.
    assert!(errors[2] < 1e-5, "{errors:?}");
}

#[test]
fn copies_are_unbiased() {
    // The mean over 256 copies of 16 points of a discontinuous integrand: a quarter circle.
    let exact = std::f64::consts::FRAC_PI_4;
    let inside = |p: DVec2| if p.length_squared() < 1.0 { 1.0 } else { 0.0 };
    let spread = rms_error(16, exact, inside);
    let mean: f64 = (0..256)
        .map(|key| {
            let copy = ScrambledSobol::new(combine(37, key));
            let hits = (0..16_u32)
                .map(|i| copy.pair(i.reverse_bits(), 0))
                .map(|[x, y]| inside(DVec2::new(unit(x), unit(y))));
            hits.sum::<f64>() / 16.0
        })
        .sum::<f64>()
        / 256.0;
    // 3.3 standard errors: significance 0.001.
    assert!((mean - exact).abs() < 3.3 * spread / 16.0, "{mean}");
}

#[test]
fn samples_do_not_depend_on_earlier_requests() {
    for kind in SamplerKind::ALL {
        let mut a = PixelSampler::new(kind, 16, 5, [7, 8], 3);
        let mut b = a;
        for _ in 0..5 {
            let _ = a.next_1d();
        }
        a.skip_to_dimension(20);
        b.skip_to_dimension(20);
        assert_eq!(a.pixel_2d(), b.pixel_2d());
        assert_eq!(a.next_2d(), b.next_2d());
        assert_eq!(a.dimension(), 22);
        assert_eq!(a.next_1d(), b.next_1d());
        // A pair starts at an even dimension.
        assert_eq!((a.dimension(), a.next_2d(), a.dimension()), (23, b.next_2d(), 26));
    }
}

#[test]
fn another_index_gives_the_numbers_of_another_sample() {
    for kind in SamplerKind::ALL {
        let sample = |index| PixelSampler::new(kind, 16, 5, [7, 8], index);
        let (mut moved, mut other) = (sample(3), sample(9));
        assert_eq!((moved.next_2d(), other.next_2d()), (sample(3).next_2d(), sample(9).next_2d()));
        moved = moved.with_index(9);
        assert_eq!((moved.sample_index(), moved.dimension()), (9, other.dimension()));
        assert_eq!(moved.next_group(), other.next_group(), "{kind:?}");
    }
}

#[test]
fn groups_of_samples_are_those_of_each() {
    for kind in SamplerKind::ALL {
        let mut first = PixelSampler::new(kind, 16, 5, [7, 8], u32::MAX - 20);
        let mut groups = vec![[2.0; 4]];
        for dimension in [4, 6, 24] {
            first.skip_to_dimension(dimension);
            first.groups_of_samples(50, &mut groups);
            let index = |i: u32| first.sample_index().wrapping_add(i);
            let each: Vec<_> = (0..50).map(|i| first.with_index(index(i)).next_group()).collect();
            assert_eq!((&groups, first.dimension()), (&each, dimension), "{kind:?}");
        }
    }
}

#[test]
fn groups_start_at_every_fourth_dimension() {
    let mut s = sobol([1, 1], 0);
    assert_eq!(s.dimension(), 2);
    s.begin_group();
    assert_eq!(s.dimension(), 4);
    s.begin_group();
    assert_eq!(s.dimension(), 4, "a group that has not begun is not skipped");
    let _ = (s.next_2d(), s.next_1d());
    s.begin_group();
    assert_eq!(s.dimension(), 8);
}

#[test]
fn a_group_at_once_has_the_numbers_of_its_dimensions() {
    for kind in SamplerKind::ALL {
        for (index, dimension) in [(0, 0), (1, 4), (77, 6), (1_000_000, 1021), (u32::MAX, u32::MAX - 7)] {
            let mut at_once = PixelSampler::new(kind, 64, 3, [5, 6], index);
            at_once.skip_to_dimension(dimension);
            let mut one_by_one = at_once;
            one_by_one.begin_group();
            let pair = one_by_one.next_2d();
            let expected = [pair.x, pair.y, one_by_one.next_1d(), one_by_one.next_1d()];
            assert_eq!(at_once.next_group(), expected, "{kind:?} {index} {dimension}");
            assert_eq!(at_once.dimension(), one_by_one.dimension());
        }
    }
}

#[test]
fn choice_and_direction_of_one_group_converge_faster_than_of_two() {
    // The number selects one of two functions of the pair: their mean is 1/2, and each has variance 7/144
    // + 1/16. The root mean square over 64 pixels of 256 samples.
    let rms = |grouped: bool| {
        let squares: f64 = (0..64)
            .map(|x| {
                let sum: f64 = (0..256)
                    .map(|i| {
                        let mut s = sobol([x, 9], i);
                        s.begin_group();
                        let p = s.next_2d();
                        if !grouped {
                            s.begin_group();
                        }
                        if s.next_1d() < 0.5 { 2.0 * p.x * p.y } else { 2.0 * (1.0 - p.x) * p.y }
                    })
                    .sum();
                (sum / 256.0 - 0.5_f64).powi(2)
            })
            .sum();
        (squares / 64.0).sqrt()
    };
    let (one, two) = (rms(true), rms(false));
    // The part that needs both, 2 (x - 1/2) y times a sign, has mean square 4 / 12 / 3 = 1/9: 0.0208 with 256
    // independent pairings.
    assert!((0.015..0.027).contains(&two), "{two}");
    assert!(one < 0.2 * two, "{one} against {two}");
}

#[test]
fn numbers_lie_in_the_unit_interval_for_all_arguments() {
    for kind in SamplerKind::ALL {
        assert_eq!(SamplerKind::from_name(kind.name()), Some(kind));
        for spp in [0, 1, 2, 7, 16, 1000, u32::MAX] {
            for index in [0, 1, 15, 16, 999, u32::MAX] {
                let mut s = PixelSampler::new(kind, spp, u64::MAX, [u32::MAX, 0], index);
                for d in [2, 3, 1000, u32::MAX - 1, u32::MAX] {
                    s.skip_to_dimension(d);
                    let (x, p) = (s.next_1d(), s.next_2d());
                    let c = s.pixel_2d();
                    assert!(
                        [x, p.x, p.y, c.x, c.y].iter().all(|v| (0.0..1.0).contains(v)),
                        "{kind:?} {spp} {index} {d}"
                    );
                }
            }
        }
    }
    assert_eq!(SamplerKind::from_name("halton"), None);
}

#[test]
fn all_numbers_of_all_kinds_are_uniform_over_pixels() {
    // Cells of 4 x 4 over 16000 pixels of one sample each; 3 decisions of 4 kinds, and 3 of the pixel.
    for kind in SamplerKind::ALL {
        let mut counts = vec![[0_u64; 16]; 4];
        let count = |c: &mut [u64; 16], p: DVec2| c[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
        for i in 0..16_000 {
            let mut s = PixelSampler::new(kind, 16, 9, [i % 160, i / 160], 6);
            count(&mut counts[0], s.pixel_2d());
            count(&mut counts[1], s.next_2d());
            count(&mut counts[2], s.next_2d());
            let (a, b) = (s.next_1d(), s.next_1d());
            count(&mut counts[3], DVec2::new(a, b));
        }
        let skip = if kind == SamplerKind::Center { 1 } else { 0 };
        for (d, c) in counts.iter().enumerate().skip(skip) {
            let test = chi_square(c, &[1000.0; 16]);
            assert!(test.p_value > 0.001 / 19.0, "{kind:?} request {d}: {test:?}");
        }
    }
}

#[test]
fn neighbouring_pixels_and_requests_are_independent() {
    for other in 0..3 {
        let mut counts = [0_u64; 64];
        for i in 0..64_000_u32 {
            let (pixel, index) = ([i / 4, 3], i % 4);
            let a = sobol(pixel, index).next_1d();
            let b = match other {
                0 => sobol([pixel[0] + 1, 3], index).next_1d(),
                1 => sobol([pixel[0], 4], index).next_1d(),
                _ => {
                    let mut s = sobol(pixel, index);
                    s.skip_to_dimension(6);
                    s.next_1d()
                }
            };
            counts[(a * 8.0) as usize * 8 + (b * 8.0) as usize] += 1;
        }
        // Within a pixel the four samples are stratified, which makes counts more even than independent ones:
        // the test can only err towards acceptance, and still detects a correlation.
        let test = chi_square(&counts, &[1000.0; 64]);
        assert!(test.p_value > 0.001 / 3.0, "{other}: {test:?}");
    }
}

#[test]
fn correlated_pixels_are_detected() {
    // The control of the test above: the same sequence in both pixels.
    let mut counts = [0_u64; 64];
    for i in 0..64_000_u32 {
        let a = sobol([i / 4, 3], i % 4).next_1d();
        let b = (a + 0.01 * unit_f64(combine(40, u64::from(i)))).min(0.999);
        counts[(a * 8.0) as usize * 8 + (b * 8.0) as usize] += 1;
    }
    assert!(chi_square(&counts, &[1000.0; 64]).p_value < 1e-9);
}

#[test]
fn center_regular_and_stratified_follow_document_003() {
    let at = |kind, i| PixelSampler::new(kind, 16, 1, [4, 4], i);
    let cell = |p: DVec2| (p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize;
    assert!((0..16).all(|i| at(SamplerKind::Center, i).pixel_2d() == DVec2::splat(0.5)));
    for kind in [SamplerKind::Regular, SamplerKind::Stratified] {
        let mut pixel = [0; 16];
        let mut light = [0; 16];
        let mut number = [0; 16];
        for i in 0..16 {
            let mut s = at(kind, i);
            pixel[cell(s.pixel_2d())] += 1;
            light[cell(s.next_2d())] += 1;
            number[(s.next_1d() * 16.0) as usize] += 1;
            let middle = (s.pixel_2d() * 4.0 - 0.5).fract() == DVec2::ZERO;
            assert_eq!(middle, kind == SamplerKind::Regular);
        }
        assert_eq!((pixel, light, number), ([1; 16], [1; 16], [1; 16]), "{kind:?}");
    }
}

#[test]
fn strata_of_two_requests_are_paired_at_random() {
    let mut counts = [0_u64; 16];
    for x in 0..4000 {
        for i in 0..4 {
            let mut s = PixelSampler::new(SamplerKind::Stratified, 4, 1, [x, 0], i);
            let cell = |p: DVec2| (p.x * 2.0) as usize * 2 + (p.y * 2.0) as usize;
            let pair = cell(s.next_2d()) * 4 + cell(s.next_2d());
            counts[pair] += 1;
        }
    }
    assert!(chi_square(&counts, &[1000.0; 16]).p_value > 0.001);
}

#[test]
fn samples_beyond_the_planned_number_start_another_pass() {
    let mut cells = [0; 9];
    for i in 0..18 {
        let p = PixelSampler::new(SamplerKind::Stratified, 9, 1, [0, 0], i).pixel_2d();
        cells[(p.x * 3.0) as usize * 3 + (p.y * 3.0) as usize] += 1;
    }
    assert_eq!(cells, [2; 9]);
}
