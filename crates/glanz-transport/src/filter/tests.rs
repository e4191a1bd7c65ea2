use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::statistics::chi_square;

use super::*;

/// Uniform numbers for the statistical tests.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        unit_f64(combine(0, self.0))
    }

    fn pair(&mut self) -> DVec2 {
        DVec2::new(self.next(), self.next())
    }
}

fn kinds() -> Vec<FilterKind> {
    vec![
        FilterKind::Box,
        FilterKind::Triangle,
        FilterKind::Gaussian { sigma: 0.5 },
        FilterKind::Gaussian { sigma: 40.0 },
        FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        FilterKind::Mitchell { b: 0.0, c: 0.5 },
        FilterKind::Mitchell { b: 1.0, c: 0.0 },
        FilterKind::Sinc { tau: 3.0 },
        FilterKind::Cylinder,
        FilterKind::Pyramid,
        FilterKind::Cone,
    ]
}

fn filter(kind: FilterKind, radius: [f64; 2]) -> Filter {
    Filter::try_new(&FilterDescription { kind, radius }).unwrap()
}

/// Midpoint sum of `f` over [-1, 1]^2 scaled by `radius`, n x n cells.
fn integrate(radius: DVec2, n: usize, f: impl Fn(DVec2) -> f64) -> f64 {
    let cell = 2.0 / n as f64;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let p = DVec2::new((i as f64 + 0.5) * cell - 1.0, (j as f64 + 0.5) * cell - 1.0);
            sum += f(p * radius);
        }
    }
    sum * cell * cell * radius.x * radius.y
}

#[test]
fn filter_and_density_integrate_to_one() {
    for kind in kinds() {
        let filter = filter(kind, [1.7, 0.6]);
        // The midpoint rule on 800 x 800 cells: error of jumps at the rim (cylinder) below 1e-3, else below 1e-5.
        let tolerance = if kind == FilterKind::Cylinder { 1e-3 } else { 1e-5 };
        let sum = integrate(filter.radius(), 800, |p| filter.evaluate(p));
        assert!((sum - 1.0).abs() < tolerance, "{kind:?}: {sum}");
        let density = integrate(filter.radius(), 800, |p| filter.pdf(p));
        assert!((density - 1.0).abs() < tolerance, "{kind:?}: {density}");
    }
}

#[test]
fn filters_are_those_of_their_formulas() {
    // Mitchell and Netravali (1988) eq. 8 over [-2, 2] with B = C = 1/3, support scaled to the radius.
    let mitchell = filter(FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, [2.0, 2.0]);
    let cubic = |x: f64| {
        let x = x.abs();
        if x < 1.0 {
            (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
        } else {
            (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
        }
    };
    let gauss = filter(FilterKind::Gaussian { sigma: 0.5 }, [1.5, 1.5]);
    let bell = |x: f64| (-2.0 * x * x).exp() - (-4.5_f64).exp();
    // Integral of the bell over [-1.5, 1.5]: sqrt(pi / 2) erf(1.5 sqrt 2) - 3 exp(-4.5), erf(2.1213203) = 0.9973002.
    let bell_integral = (PI / 2.0).sqrt() * 0.997_300_203_936_739_8 - 3.0 * (-4.5_f64).exp();
    for i in 0..97 {
        for j in 0..97 {
            let p = DVec2::new(i as f64, j as f64) / 48.0 - 1.0;
            let q = p * 2.0;
            // The cubic has an integral of 1 for every B and C.
            let error = mitchell.evaluate(q) - cubic(q.x) * cubic(q.y);
            assert!(error.abs() < 5e-6, "{q}: {error}");
            let q = p * 1.5;
            let error = gauss.evaluate(q) - bell(q.x) * bell(q.y) / (bell_integral * bell_integral);
            assert!(error.abs() < 5e-6, "{q}: {error}");
        }
    }
}

#[test]
fn sinc_is_that_of_lanczos() {
    let filter = filter(FilterKind::Sinc { tau: 3.0 }, [4.0, 4.0]);
    let cardinal = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let lanczos = |x: f64| cardinal(x) * cardinal(x / 3.0);
    let peak = filter.evaluate(DVec2::ZERO);
    for i in 0..80 {
        let p = DVec2::new(f64::from(i) * 0.05, 3.97 - f64::from(i) * 0.03);
        let error = filter.evaluate(p) / peak - lanczos(p.x) * lanczos(p.y);
        assert!(error.abs() < 1e-5, "{p}: {error}");
    }
    // Its integral is near 1, as that of the sine cardinal.
    assert!((1.0 / peak - 1.0).abs() < 0.03, "{peak}");
}

#[test]
fn splats_are_distributed_by_the_filters_of_the_pixels() {
    let n = 20_000;
    let pixels = PixelRect { min: [2, 1], size: [5, 4] };
    for kind in kinds() {
        let filter = filter(kind, [1.7, 1.2]);
        for place in [DVec2::new(4.3, 2.8), DVec2::new(1.2, 0.4), DVec2::new(7.9, 4.9)] {
            let mut got = [[0.0; 8]; 8];
            for i in 0..n {
                let xi = (f64::from(i) + 0.5) / f64::from(n);
                if let Some(([x, y], weight)) = filter.pick_pixel(place, &pixels, xi) {
                    got[x as usize][y as usize] += weight / f64::from(n);
                }
            }
            for [x, y] in PixelRect::full([8, 8]).pixels() {
                let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let inside = (2..7).contains(&x) && (1..5).contains(&y);
                let expected = if inside { filter.evaluate(place - middle) } else { 0.0 };
                // Borders between pixels lie between two of the numbers: an error of 1/n of the sum of weights, below 2.
                let error = (got[x as usize][y as usize] - expected).abs();
                assert!(error < 4.0 / f64::from(n), "{kind:?} {place} {x} {y}: {error}");
            }
        }
    }
    let narrow = filter(FilterKind::Box, [0.5, 0.5]);
    assert_eq!(narrow.pick_pixel(DVec2::new(7.1, 2.0), &pixels, 0.5), None);
    assert_eq!(narrow.pick_pixel(DVec2::new(-1e30, f64::NAN), &pixels, 0.5), None);
    assert_eq!(narrow.pick_pixel(DVec2::new(6.9, 1.1), &pixels, 0.5), Some(([6, 1], 1.0)));
}

#[test]
fn very_wide_gaussian_is_a_parabola() {
    // exp(-x^2 / 2 s^2) - exp(-r^2 / 2 s^2) -> (r^2 - x^2) / 2 s^2 for s >> r; its integral over [-1, 1] is 4 / 3.
    let wide = filter(FilterKind::Gaussian { sigma: 1e12 }, [1.0, 1.0]);
    for x in [0.0, 0.3, 0.9] {
        let expected = (1.0 - x * x) * 0.75 * 0.75;
        assert!((wide.evaluate(DVec2::new(x, 0.0)) - expected).abs() < 5e-6);
    }
}

#[test]
fn samples_follow_the_stated_density() {
    // Chi-square over 16 x 16 cells, 200 000 samples each, eleven filters; significance 1e-4 for each.
    const CELLS: usize = 16;
    const FINE: usize = 64;
    const SAMPLES: usize = 200_000;
    let mut uniform = Uniform(0);
    for kind in kinds() {
        let filter = filter(kind, [0.8, 2.5]);
        let mut counts = [0_u64; CELLS * CELLS];
        for _ in 0..SAMPLES {
            let p = (filter.sample(uniform.pair()).offset / filter.radius() + 1.0) * (0.5 * CELLS as f64);
            counts[(p.y as usize).min(CELLS - 1) * CELLS + (p.x as usize).min(CELLS - 1)] += 1;
        }
        let mut shares: Vec<f64> = (0..CELLS * CELLS)
            .map(|i| {
                let points = (0..FINE * FINE).map(|k| {
                    let inner = DVec2::new((k % FINE) as f64 + 0.5, (k / FINE) as f64 + 0.5) / FINE as f64;
                    let p = (DVec2::new((i % CELLS) as f64, (i / CELLS) as f64) + inner) / CELLS as f64;
                    filter.pdf((p * 2.0 - 1.0) * filter.radius())
                });
                points.sum()
            })
            .collect();
        // The error of the midpoint rule at jumps is about 1e-4; both sides must have the same total.
        let scale = SAMPLES as f64 / shares.iter().sum::<f64>();
        shares.iter_mut().for_each(|s| *s *= scale);
        let test = chi_square(&counts, &shares);
        assert!(test.p_value > 1e-4, "{kind:?}: {test:?}");
        assert!(test.degrees_of_freedom > 150, "{kind:?}: {test:?}");
    }
}

#[test]
fn signs_are_those_of_the_filter_and_average_to_its_integral() {
    let mut uniform = Uniform(1 << 32);
    for kind in kinds() {
        let filter = filter(kind, [2.0, 1.0]);
        let (mut net, n) = (0.0, 100_000);
        for _ in 0..n {
            let sample = filter.sample(uniform.pair());
            assert!(sample.offset.abs().cmple(filter.radius()).all());
            if filter.evaluate(sample.offset).abs() > 1e-9 {
                assert_eq!(
                    sample.negative,
                    filter.evaluate(sample.offset) < 0.0,
                    "{kind:?} {:?}",
                    sample.offset
                );
            }
            net += if sample.negative { -1.0 } else { 1.0 };
        }
        let net = net / f64::from(n);
        let expected = filter.net_weight();
        // Five standard errors of a coin with mean `expected`.
        let error = ((1.0 - expected * expected).max(0.0) / f64::from(n)).sqrt();
        assert!((net - expected).abs() <= 5.0 * error, "{kind:?}: {net}, not {expected}");
        assert_eq!(
            filter.is_signed(),
            match kind {
                FilterKind::Mitchell { c, .. } => c > 0.0,
                // Radii of 2 and 1: beyond 1 the inner function is negative.
                FilterKind::Sinc { .. } => true,
                _ => false,
            }
        );
    }
}

#[test]
fn middle_of_the_unit_square_maps_to_the_middle_of_the_pixel() {
    for kind in kinds() {
        let sample = filter(kind, [1.5, 2.0]).sample(DVec2::splat(0.5));
        assert_eq!(sample, FilterSample { offset: DVec2::ZERO, negative: false }, "{kind:?}");
    }
}

#[test]
fn opposite_numbers_map_to_opposite_positions() {
    let mut uniform = Uniform(2 << 32);
    for kind in kinds() {
        let filter = filter(kind, [1.5, 2.0]);
        for _ in 0..100 {
            let xi = uniform.pair();
            let (a, b) = (filter.sample(xi), filter.sample(DVec2::ONE - xi));
            assert!((a.offset + b.offset).length() < 1e-9, "{kind:?}");
        }
    }
}

#[test]
fn invalid_filters_are_refused() {
    let make = |kind, radius| Filter::try_new(&FilterDescription { kind, radius });
    for radius in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
        assert!(matches!(make(FilterKind::Box, radius), Err(FilterError::Radius(..))));
    }
    for sigma in [0.0, -1.0, f64::NAN, 1e-5] {
        let kind = FilterKind::Gaussian { sigma };
        assert!(matches!(make(kind, [1.0, 1.0]), Err(FilterError::Parameter { .. })), "{sigma}");
    }
    assert!(make(FilterKind::Mitchell { b: f64::NAN, c: 0.0 }, [1.0, 1.0]).is_err());
    assert!(make(FilterKind::Mitchell { b: 4.0, c: 0.0 }, [1.0, 1.0]).is_err());
    assert!(matches!(
        make(FilterKind::Mitchell { b: 0.0, c: 40.0 }, [1.0, 1.0]),
        Err(FilterError::Lobes(..))
    ));
}
