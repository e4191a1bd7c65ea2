use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::*;
use crate::SurfaceError;

// 40-digit Cox-de Boor recursion (half-open spans, the last one closed) with @markgraf2019 eq. 8 and 22 to 25, done in
// mpmath; agrees with geomdl to 2.5e-14. Degrees 3 and 2.
const KNOTS_U: [f64; 10] = [0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0];
const KNOTS_V: [f64; 8] = [0.0, 0.0, 0.0, 0.35, 0.6, 1.0, 1.0, 1.0];
/// z of the control points (i, j, z), i = 0 to 5, j = 0 to 4.
const HEIGHTS: [[f64; 5]; 6] = [
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [0.783_327, 0.599_121, 0.13314, -0.39546, -0.738_068],
    [0.973_848, 0.74484, 0.165_522, -0.491_643, -0.917_581],
    [0.42738, 0.326_878, 0.072_641, -0.215_761, -0.402_687],
    [-0.44252, -0.338_458, -0.075_214, 0.223_405, 0.416_953],
    [-0.97753, -0.747_656, -0.166_148, 0.493_502, 0.921_051],
];
const WEIGHTS: [[f64; 5]; 6] = [
    [1.0, 1.166_667, 1.333_333, 1.5, 1.0],
    [1.5, 1.0, 1.166_667, 1.333_333, 1.5],
    [1.333_333, 1.5, 1.0, 1.166_667, 1.333_333],
    [1.166_667, 1.333_333, 1.5, 1.0, 1.166_667],
    [1.0, 1.166_667, 1.333_333, 1.5, 1.0],
    [1.5, 1.0, 1.166_667, 1.333_333, 1.5],
];
/// (u, v), then S, S_u, S_v, S_uu, S_uv, S_vv, unit normal.
const REFERENCE: [([f64; 2], [[f64; 3]; 7]); 6] = [
    (
        [0.15, 0.2],
        [
            [0.997_206_514_922_134_7, 0.981_547_409_238_661_9, 0.447_763_039_561_812_5],
            [5.793_214_026_339_577, -0.276_017_909_326_913_1, 1.924_486_490_894_912],
            [-0.219_637_096_531_801_08, 4.678_836_576_043_683, -1.266_821_233_705_661_7],
            [-13.595_827_436_605_262, 3.032_107_129_310_780_6, -13.863_027_061_508_143],
            [3.303_906_801_182_439_5, -0.886_226_603_062_791_1, -2.757_095_539_603_409],
            [-1.086_704_850_936_230_7, -5.633_117_326_650_993, -0.855_806_448_960_352_4],
            [-0.296_129_041_816_998_2, 0.236_647_433_419_856_64, 0.925_367_809_494_333_5],
        ],
    ),
    (
        [0.4, 0.6],
        [
            [2.063_318_760_085_740_3, 2.387_554_600_040_103_6, -0.080_954_244_892_483_68],
            [3.907_620_415_345_318_7, -0.235_420_540_637_975_6, 0.142_639_328_045_244_35],
            [-0.389_973_624_688_599_3, 3.085_628_416_362_165_4, -1.692_683_059_927_916],
            [-4.341_443_907_849_792, -1.140_612_892_572_558_7, 1.151_786_383_573_562_4],
            [-1.391_777_146_942_108_3, -0.688_270_878_121_118_5, 1.533_558_639_183_936_4],
            [0.971_376_399_431_499_4, 7.565_746_468_953_042_5, -1.430_754_627_643_997_3],
            [-0.003_051_558_790_530_050_5, 0.480_657_141_995_682_3, 0.876_903_301_303_792_8],
        ],
    ),
    (
        [0.55, 0.475],
        [
            [2.628_562_737_598_380_7, 1.968_659_166_183_133_4, 0.111_396_271_770_035_3],
            [3.270_374_028_322_409_6, 0.028_199_641_949_837_862, -0.291_427_828_469_778],
            [0.050_914_716_712_252_076, 3.147_265_996_313_079_6, -1.310_560_948_415_175_7],
            [-1.890_483_703_697_184, 0.712_740_891_836_039_3, -1.169_101_821_552_544_2],
            [1.096_610_394_599_636_4, -2.326_559_079_580_454_3, 4.422_746_381_604_516],
            [-3.086_819_916_940_864, -1.679_595_097_817_714_8, 0.429_886_520_125_476_9],
            [0.078_753_826_306_201_09, 0.382_135_470_682_897_3, 0.920_744_436_251_500_4],
        ],
    ),
    (
        [0.93, 0.81],
        [
            [4.396_951_920_982_492, 3.123_908_805_101_373, 0.343_253_733_901_516_6],
            [7.524_262_216_135_432_4, 0.621_978_554_134_887_7, 2.619_870_944_383_386_7],
            [0.310_532_941_673_167_64, 3.856_131_173_126_781_3, 1.363_187_664_942_340_2],
            [26.907_873_448_289_82, 6.618_450_319_476_631, 6.411_803_760_700_481],
            [1.222_055_850_857_917_6, 1.525_528_951_805_485_5, 10.764_921_828_785_518],
            [0.899_776_420_317_772_6, 5.840_077_560_349_661, 1.152_503_251_819_232_2],
            [-0.291_857_486_208_878_8, -0.297_809_390_786_835_4, 0.908_916_263_746_561],
        ],
    ),
    (
        [0.0, 0.0],
        [
            [0.0, 0.0, 0.0],
            [11.25, 0.0, 8.812_428_75],
            [0.0, 6.666_668_571_428_572, 0.0],
            [-115.625_014_285_714_29, 0.0, -107.509_505_616_771_43],
            [-32.142_878_571_428_57, -32.142_878_571_428_57, -33.072_927_499_864_285],
            [0.0, -17.460_361_451_254_42, 0.0],
            [-0.616_658_885_424_058_1, 0.0, 0.787_230_473_894_118_5],
        ],
    ),
    (
        [1.0, 1.0],
        [
            [5.0, 4.0, 0.921_051],
            [6.666_666_666_666_667, 0.0, 3.360_653_333_333_333_5],
            [0.0, 4.444_443_333_333_333, 1.900_217_302_723_333_3],
            [-29.629_644_444_444_445, 0.0, -23.116_965_361_022_22],
            [-20.370_377_777_777_78, -20.370_377_777_777_78, -7.277_951_345_533_333],
            [0.0, 1.044_617_830_011_965_7, -0.942_013_549_688_521_7],
            [-0.420_532_675_589_564_03, -0.356_673_355_013_593_6, 0.834_228_018_340_806_8],
        ],
    ),
];

fn reference() -> NurbsSurface {
    let at = |i: usize, j: usize| DVec3::new(i as f64, j as f64, HEIGHTS[i][j]);
    let points: Vec<DVec3> = (0..6).flat_map(|i| (0..5).map(move |j| at(i, j))).collect();
    NurbsSurface::try_with_weights(3, 2, KNOTS_U.to_vec(), KNOTS_V.to_vec(), &points, WEIGHTS.as_flattened())
        .unwrap()
}

/// Some rational surface whose knots are not clamped and double in places.
fn open() -> NurbsSurface {
    let knots_u = vec![-1.3, -0.5, -0.2, 0.0, 0.4, 0.4, 1.0, 1.7, 2.0, 2.2, 3.1];
    let knots_v = vec![0.0, 1.0, 1.5, 2.0, 2.0, 3.0, 3.5, 4.0];
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64, j as f64);
        let w = 1.0 + 0.5 * (1.7 * x + 2.3 * y).sin();
        DVec4::new(x, y, (x * y * 0.3).cos(), 1.0) * w
    };
    let points = (0..7).flat_map(|i| (0..5).map(move |j| point(i, j))).collect();
    NurbsSurface::try_new(3, 2, knots_u, knots_v, points).unwrap()
}

/// An eighth of the unit sphere as a rational biquadratic: v climbs from the equator to the pole.
fn octant() -> NurbsSurface {
    let arc = [(1.0, 0.0, 1.0), (1.0, 1.0, FRAC_1_SQRT_2), (0.0, 1.0, 1.0)];
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let points = arc.iter().flat_map(|&(x, y, wu)| {
        arc.iter().map(move |&(r, z, wv)| DVec3::new(r * x, r * y, z).extend(1.0) * (wu * wv))
    });
    NurbsSurface::try_new(2, 2, knots(), knots(), points.collect()).unwrap()
}

/// The unit circle in four arcs.
fn circle() -> RationalCurve {
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points = corners.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0));
    let weights: Vec<f64> =
        (0..9).map(|i: usize| if i.is_multiple_of(2) { 1.0 } else { FRAC_1_SQRT_2 }).collect();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    RationalCurve::try_new(2, knots, &points, &weights).unwrap()
}

/// Parameters over the closed domain, knots included.
fn grid(knots: &KnotVector) -> Vec<f64> {
    let [a, b] = knots.domain();
    (0..=16).map(|i| a + (b - a) * f64::from(i) / 16.0).chain(knots.breaks()).collect()
}

/// The largest distance between the points of `part` and of `whole` at the parameters of `part`.
fn distance(part: &NurbsSurface, whole: &NurbsSurface) -> f64 {
    let mut largest: f64 = 0.0;
    for u in grid(part.knots_u()) {
        for v in grid(part.knots_v()) {
            largest = largest.max(part.point(u, v).distance(whole.point(u, v)));
        }
    }
    largest
}

fn as_surface(piece: &BezierPiece) -> NurbsSurface {
    let (p, q) = piece.patch.degrees();
    let knots = |n: usize, [a, b]: [f64; 2]| [vec![a; n + 1], vec![b; n + 1]].concat();
    let points = piece.patch.control_points().to_vec();
    NurbsSurface::try_new(p, q, knots(p, piece.u), knots(q, piece.v), points).unwrap()
}

#[test]
fn reference_surface_has_the_published_points_derivatives_and_normals() {
    let surface = reference();
    for ([u, v], expected) in REFERENCE {
        let d = surface.derivatives(u, v, 2);
        let orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        for ((k, l), value) in orders.into_iter().zip(expected) {
            let value = DVec3::from_array(value);
            let error = d.get(k, l).unwrap().distance(value);
            assert!(error < 1e-10, "S_{k}{l}({u}, {v}): {error}");
        }
        assert!(surface.point(u, v).distance(DVec3::from_array(expected[0])) < 1e-13);
        assert!(surface.normal(u, v).unwrap().distance(DVec3::from_array(expected[6])) < 1e-12);
        assert_eq!(d.get(2, 1), None);
    }
}

#[test]
fn derivatives_of_every_order_are_differences_of_the_order_below() {
    for surface in [reference(), open(), octant()] {
        let ([u0, u1], [v0, v1]) = (surface.knots_u().domain(), surface.knots_v().domain());
        // Away from knots, where derivatives jump.
        for (s, t) in [(0.13, 0.17), (0.31, 0.83), (0.91, 0.47)] {
            let (u, v, h) = (u0 + (u1 - u0) * s, v0 + (v1 - v0) * t, 1e-5);
            let d = surface.derivatives(u, v, 5);
            let around = |du, dv| surface.derivatives(u + du, v + dv, 5);
            let (left, right, below, above) =
                (around(-h, 0.0), around(h, 0.0), around(0.0, -h), around(0.0, h));
            for (k, l) in (0..5).flat_map(|k| (0..5 - k).map(move |l| (k, l))) {
                let of = |d: &Derivatives, k, l| d.get(k, l).unwrap();
                let by_u = (of(&right, k, l) - of(&left, k, l)) / (2.0 * h);
                let by_v = (of(&above, k, l) - of(&below, k, l)) / (2.0 * h);
                for (exact, difference) in [(of(&d, k + 1, l), by_u), (of(&d, k, l + 1), by_v)] {
                    assert!(exact.distance(difference) < 1e-5 * (1.0 + exact.length()), "{k} {l} at {u} {v}");
                }
            }
            let (point, du, dv) = surface.tangents(u, v);
            assert!(
                point == d.at(0, 0) && du.distance(d.at(1, 0)) < 1e-13 && dv.distance(d.at(0, 1)) < 1e-13
            );
        }
    }
}

#[test]
fn inserting_elevating_cutting_and_turning_keep_the_surface() {
    for surface in [reference(), open()] {
        let inserted = surface.insert_knot(Direction::U, 0.55, 3).unwrap();
        let [c, d] = surface.knots_v().domain();
        let inserted = inserted.insert_knot(Direction::V, c + 0.9 * (d - c), 1).unwrap();
        assert_eq!(inserted.counts(), (surface.counts().0 + 3, surface.counts().1 + 1));
        assert!(distance(&inserted, &surface) < 1e-12);
        let raised = surface.elevate(Direction::U).unwrap().elevate(Direction::V).unwrap();
        assert_eq!((raised.knots_u().degree(), raised.knots_v().degree()), (4, 3));
        assert_eq!(raised.knots_u().domain(), surface.knots_u().domain());
        assert!(distance(&raised, &surface) < 1e-12, "{}", distance(&raised, &surface));
        for direction in [Direction::U, Direction::V] {
            let [a, b] = surface.knots(direction).domain();
            for cut in [a + 0.37 * (b - a), surface.knots(direction).inner()[0]] {
                let (low, high) = surface.split(direction, cut).unwrap();
                assert_eq!(
                    (low.knots(direction).domain(), high.knots(direction).domain()),
                    ([a, cut], [cut, b])
                );
                // At the cut itself the pieces have one value, the closed end of the lower one too.
                assert!(distance(&low, &surface) < 1e-12 && distance(&high, &surface) < 1e-12);
            }
            let turned = surface.reversed(direction).unwrap().reversed(direction).unwrap();
            assert!(distance(&turned, &surface) < 1e-12);
        }
        let backwards = surface.reversed(Direction::U).unwrap();
        let ([a, b], [c, d]) = (surface.knots_u().domain(), surface.knots_v().domain());
        for (u, v) in grid(surface.knots_u()).into_iter().zip(grid(surface.knots_v())) {
            assert!(backwards.point(a + (b - u), v).distance(surface.point(u, v)) < 1e-12);
            assert!(surface.swapped().point(v, u).distance(surface.point(u, v)) < 1e-14);
            assert!(
                surface.isocurve(Direction::U, u).unwrap().point(v).distance(surface.point(u, v)) < 1e-13
            );
            assert!(
                surface.isocurve(Direction::V, v).unwrap().point(u).distance(surface.point(u, v)) < 1e-13
            );
        }
        let part = surface.restrict([[a + 0.2 * (b - a), b], [c, c + 0.7 * (d - c)]]).unwrap();
        assert!(part.knots_u().is_clamped() && part.knots_v().is_clamped());
        assert!(distance(&part, &surface) < 1e-12);
    }
}

#[test]
fn inserted_knots_can_be_removed_and_needed_ones_cannot() {
    for surface in [reference(), open()] {
        for direction in [Direction::U, Direction::V] {
            let [a, b] = surface.knots(direction).domain();
            let new = a + 0.81 * (b - a);
            let finer = surface.insert_knot(direction, new, 2).unwrap();
            let (once, moved) = finer.remove_knot(direction, new, 1e-12).unwrap();
            assert!(moved < 1e-12);
            let (twice, _) = once.remove_knot(direction, new, 1e-12).unwrap();
            assert_eq!(twice.knots(direction), surface.knots(direction));
            assert!(distance(&twice, &surface) < 1e-12);
            let needed = surface.knots(direction).inner()[0];
            let refused = surface.remove_knot(direction, needed, 1e-6).unwrap_err();
            let SurfaceError::KnotNeeded { deviation, .. } = refused else { panic!("{refused}") };
            if deviation.is_infinite() {
                // Without it, a weight would be negative.
                continue;
            }
            let (rougher, bound) = surface.remove_knot(direction, needed, 2.0 * deviation).unwrap();
            let true_deviation = distance(&rougher, &surface);
            assert!(bound == deviation && true_deviation <= bound && true_deviation > 1e-3 * bound);
        }
        assert!(surface.remove_knot(Direction::U, 0.123, 1.0).is_err());
        assert!(surface.remove_knot(Direction::U, f64::NAN, 1.0).is_err());
    }
}

#[test]
fn pieces_are_the_surface_and_share_their_borders_to_the_last_bit() {
    for surface in [reference(), open()] {
        let pieces = surface.bezier_patches().unwrap();
        let (spans_u, spans_v) = (surface.knots_u().breaks().len() - 1, surface.knots_v().breaks().len() - 1);
        assert_eq!(pieces.len(), spans_u * spans_v);
        let (p, q) = (surface.knots_u().degree(), surface.knots_v().degree());
        let bits = |piece: &BezierPiece, i: usize, j: usize| {
            piece.patch.control_points()[i * (q + 1) + j].to_array().map(f64::to_bits)
        };
        for (index, piece) in pieces.iter().enumerate() {
            assert!(distance(&as_surface(piece), &surface) < 1e-12);
            if index % spans_v + 1 < spans_v {
                let above = &pieces[index + 1];
                assert!(piece.v[1] == above.v[0] && piece.u == above.u);
                assert!((0..=p).all(|i| bits(piece, i, q) == bits(above, i, 0)));
            }
            if let Some(right) = pieces.get(index + spans_v) {
                assert!(piece.u[1] == right.u[0] && piece.v == right.v);
                assert!((0..=q).all(|j| bits(piece, p, j) == bits(right, 0, j)));
            }
        }
    }
}

#[test]
fn weights_that_are_one_stay_exactly_one_and_planes_stay_planes() {
    let source = open();
    let plain: Vec<DVec4> =
        source.control_points().iter().map(|p| (p.truncate() / p.w).with_z(0.1).extend(1.0)).collect();
    let surface =
        NurbsSurface::from_knots(source.knots_u().clone(), source.knots_v().clone(), plain).unwrap();
    assert!(surface.is_polynomial());
    let is_plane = |points: &[DVec4]| points.iter().all(|p| p.w == 1.0 && p.z == 0.1);
    for piece in surface.bezier_patches().unwrap() {
        assert!(is_plane(piece.patch.control_points()));
    }
    let raised = surface.elevate(Direction::U).unwrap().elevate(Direction::V).unwrap();
    let cut = raised.split(Direction::U, 0.77).unwrap().0;
    let (removed, _) = surface
        .insert_knot(Direction::V, 2.5, 1)
        .and_then(|s| s.remove_knot(Direction::V, 2.5, 1e-12))
        .unwrap();
    for changed in [raised, cut, removed] {
        assert!(is_plane(changed.control_points()));
    }
}

#[test]
fn circle_is_round_with_exact_tangents_under_every_change() {
    let circle = circle();
    let (left, right) = circle.split(1.3).unwrap();
    let changed = [
        circle.clone(),
        circle.insert_knot(0.3, 2).unwrap(),
        circle.elevate().unwrap().elevate().unwrap(),
        circle.reversed().unwrap(),
        left,
        right,
    ];
    for curve in changed {
        for u in grid(curve.knots()) {
            let d = curve.derivatives(u, 2);
            assert!((d[0].length() - 1.0).abs() < 1e-14);
            assert!(d[0].dot(d[1]).abs() < 1e-13);
            // x . x'' + x' . x' = 0.
            assert!((d[0].dot(d[2]) + d[1].length_squared()).abs() < 1e-12);
        }
    }
    let arcs = circle.bezier_arcs().unwrap();
    assert_eq!(arcs.len(), 4);
    for pair in arcs.windows(2) {
        assert!(pair[0].points.last() == pair[1].points.first() && pair[0].u[1] == pair[1].u[0]);
    }
    let (smooth, moved) = circle.insert_knot(0.5, 1).unwrap().remove_knot(0.5, 1e-14).unwrap();
    assert!(smooth.knots() == circle.knots() && moved <= 1e-14);
    assert!(matches!(circle.remove_knot(1.0, 1e-3), Err(SurfaceError::KnotNeeded { .. })));
}

#[test]
fn curve_derivatives_are_differences_of_the_order_below() {
    let curve = open().isocurve(Direction::V, 2.2).unwrap();
    let h = 1e-5;
    for u in [0.1, 0.35, 0.77, 1.5] {
        let (d, low, high) =
            (curve.derivatives(u, 5), curve.derivatives(u - h, 5), curve.derivatives(u + h, 5));
        for k in 0..5 {
            let difference = (high[k] - low[k]) / (2.0 * h);
            assert!(d[k + 1].distance(difference) < 1e-5 * (1.0 + difference.length()));
        }
    }
}

#[test]
fn rational_octant_is_an_exact_sphere() {
    let sphere = octant();
    for u in grid(sphere.knots_u()) {
        for v in grid(sphere.knots_v()) {
            let p = sphere.point(u, v);
            assert!((p.length() - 1.0).abs() < 1e-15);
            // The pole v = 1 included, where dS/du is 0.
            assert!(sphere.normal(u, v).unwrap().distance(p) < 1e-14, "{u} {v}");
        }
    }
    for (u, v) in [(0.1, 0.2), (0.7, 0.9), (0.0, 0.0), (1.0, 0.5)] {
        let curvature = sphere.curvature(u, v).unwrap();
        assert!((curvature.gaussian - 1.0).abs() < 1e-12 && (curvature.mean + 1.0).abs() < 1e-13);
        // The square root of the rounding error in H^2 - K.
        assert!(curvature.principal.iter().all(|k| (k + 1.0).abs() < 1e-6));
    }
    assert_eq!(sphere.curvature(0.5, 1.0), None);
}

#[test]
fn area_of_a_sphere_octant_is_half_of_pi() {
    for tolerance in [1e-4, 1e-10] {
        let area = octant().area(tolerance).unwrap();
        assert!(area.error <= tolerance && (area.value - FRAC_PI_2).abs() <= tolerance, "{area:?}");
    }
    let parted = octant().insert_knot(Direction::U, 0.21, 2).unwrap();
    assert!((parted.area(1e-10).unwrap().value - FRAC_PI_2).abs() < 1e-10);
    assert!(octant().area(0.0).is_err() && octant().area(f64::NAN).is_err());
}

#[test]
fn periodic_points_make_a_closed_torus() {
    // The circle of radius 1 from its 8 points, given once: the corner (1, -1), then (1, 0), ...
    let corners = [(1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1)];
    let weight = |i: usize| if i.is_multiple_of(2) { FRAC_1_SQRT_2 } else { 1.0 };
    let period = || vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0];
    let points = (0..8).flat_map(|i| {
        (0..8).map(move |j| {
            let (x, y) = (f64::from(corners[i].0), f64::from(corners[i].1));
            let (r, z) = (3.0 + f64::from(corners[j].0), f64::from(corners[j].1));
            DVec3::new(r * x, r * y, z).extend(1.0) * (weight(i) * weight(j))
        })
    });
    let points: Vec<DVec4> = points.collect();
    let torus =
        NurbsSurface::try_new_periodic([2, 2], [period(), period()], points.clone(), [true, true]).unwrap();
    assert_eq!((torus.counts(), torus.knots_u().domain()), ((9, 9), [0.0, 4.0]));
    for u in grid(torus.knots_u()) {
        for v in grid(torus.knots_v()) {
            let p = torus.point(u, v);
            let ring = p.truncate().length() - 3.0;
            assert!((ring.hypot(p.z) - 1.0).abs() < 1e-14);
            let curvature = torus.curvature(u, v).unwrap();
            // K = cos t / (r (R + r cos t)) with r = 1, R = 3 and cos t = ring.
            assert!((curvature.gaussian - ring / (3.0 + ring)).abs() < 1e-12);
            assert!((curvature.principal[0] + 1.0).abs() < 1e-12);
        }
        assert!(torus.point(u, 0.0) == torus.point(u, 4.0) && torus.point(0.0, u) == torus.point(4.0, u));
    }
    assert!((torus.area(1e-8).unwrap().value - 4.0 * PI * PI * 3.0).abs() < 1e-8);
    let wrong = NurbsSurface::try_new_periodic([2, 2], [period(), vec![0.0]], points, [true, true]);
    assert!(matches!(wrong, Err(SurfaceError::TooFew { .. })));
}

#[test]
fn periodic_points_without_double_knots_are_smooth_across_the_seam() {
    let points = (0..7).flat_map(|i| {
        let t = f64::from(i) * 2.0 * PI / 7.0;
        [0.0, 1.0].map(|z| DVec4::new(t.cos(), t.sin() * (1.0 + z), z, 1.0))
    });
    let knots = vec![0.0, 1.0, 1.5, 2.5, 4.0, 4.5, 6.0, 7.0];
    let pipe = NurbsSurface::try_new_periodic(
        [3, 1],
        [knots, vec![0.0, 0.0, 1.0, 1.0]],
        points.collect(),
        [true, false],
    )
    .unwrap();
    let (start, end) = (pipe.derivatives(0.0, 0.3, 2), pipe.derivatives(7.0, 0.3, 2));
    for k in 0..=2 {
        assert!(start.at(k, 0).distance(end.at(k, 0)) < 1e-12);
    }
    assert!(pipe.is_polynomial());
    assert_eq!(pipe.knots_u().breaks(), [0.0, 1.0, 1.5, 2.5, 4.0, 4.5, 6.0, 7.0]);
}

#[test]
fn interpolation_reproduces_polynomials_of_its_degree() {
    let f = |u: f64, v: f64| DVec3::new(u - 0.3 * v, 2.0 * v + u * v, u * u * u - u * v * v + 0.25);
    let knots_u = KnotVector::try_new(3, KNOTS_U.to_vec()).unwrap();
    let knots_v = KnotVector::try_new(2, KNOTS_V.to_vec()).unwrap();
    let (gu, gv) = (knots_u.greville(), knots_v.greville());
    let points: Vec<DVec3> = gu.iter().flat_map(|&u| gv.iter().map(move |&v| f(u, v))).collect();
    let surface = NurbsSurface::interpolate_at([knots_u, knots_v], [&gu, &gv], &points).unwrap();
    assert!(surface.is_polynomial());
    for u in grid(surface.knots_u()) {
        for v in grid(surface.knots_v()) {
            assert!(surface.point(u, v).distance(f(u, v)) < 1e-13);
        }
    }
}

#[test]
fn interpolation_meets_its_points_at_parameters_that_follow_the_distances() {
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64 * 0.7, j as f64);
        DVec3::new(x + 0.1 * y.sin(), y * y * 0.2, (x * 1.3).sin() + y.cos())
    };
    let points: Vec<DVec3> = (0..9).flat_map(|i| (0..6).map(move |j| point(i, j))).collect();
    let surface = NurbsSurface::interpolate([3, 2], [9, 6], &points).unwrap();
    for p in &points {
        assert!(surface.closest_point(*p, 1e-9).unwrap().distance < 1e-9);
    }
    let row: Vec<DVec3> = (0..9).map(|i| point(i, 0)).collect();
    for degree in 1..=8 {
        let curve = RationalCurve::interpolate(degree, &row).unwrap();
        let lengths: Vec<f64> = row.windows(2).map(|w| w[0].distance(w[1])).collect();
        let whole: f64 = lengths.iter().sum();
        let mut run = 0.0;
        for (i, p) in row.iter().enumerate() {
            assert!(curve.point(run / whole).distance(*p) < 1e-12, "{degree} {i}");
            run += lengths.get(i).copied().unwrap_or(0.0);
        }
    }
    assert!(RationalCurve::interpolate(9, &row).is_err());
    assert!(RationalCurve::interpolate(3, &[DVec3::X; 5]).is_err());
}

#[test]
fn interpolation_is_refused_where_a_basis_function_vanishes() {
    let knots = KnotVector::try_new(2, KNOTS_V.to_vec()).unwrap();
    let points = [DVec3::X; 5];
    // The last basis function begins at 0.6.
    let crowded = RationalCurve::interpolate_at(knots.clone(), &[0.0, 0.1, 0.4, 0.5, 0.6], &points);
    assert!(
        matches!(crowded, Err(SurfaceError::OutOfRange { value: 0.6, min: 0.6, max: 1.0, .. })),
        "{crowded:?}"
    );
    let twice = RationalCurve::interpolate_at(knots.clone(), &[0.0, 0.4, 0.4, 0.7, 1.0], &points);
    assert!(matches!(twice, Err(SurfaceError::EmptyRange { .. })), "{twice:?}");
    assert!(RationalCurve::interpolate_at(knots.clone(), &[0.0, 0.2, f64::NAN, 0.7, 1.0], &points).is_err());
    assert!(RationalCurve::interpolate_at(knots, &[0.0, 0.2, 0.5, 0.7, 1.1], &points).is_err());
}

#[test]
fn closest_point_of_a_sphere_lies_under_the_query() {
    let sphere = octant();
    for (query, distance) in [(1.7, 0.7), (0.4, 0.6), (1.0, 0.0)] {
        let direction = DVec3::new(0.5, 0.3, 0.6).normalize();
        let found = sphere.closest_point(direction * query, 1e-9).unwrap();
        assert!(found.point.distance(direction) < 1e-9, "{found:?}");
        assert!((found.distance - distance).abs() < 1e-12 && found.distance - found.at_least <= 2e-9);
        assert!(sphere.point(found.u, found.v) == found.point);
    }
    // Past the border: the nearest point is the corner (1, 0, 0), and from below the pole's side the pole itself.
    let corner = sphere.closest_point(DVec3::new(2.0, -1.0, -1.0), 1e-9).unwrap();
    assert!(corner.point.distance(DVec3::X) < 1e-12);
    let pole = sphere.closest_point(DVec3::new(-1.0, -1.0, 2.0), 1e-9).unwrap();
    assert!(pole.point.distance(DVec3::Z) < 1e-9, "{pole:?}");
    // From the centre all are equally near: the answer is right, the bound stays open.
    let center = sphere.closest_point(DVec3::ZERO, 1e-9).unwrap();
    assert!((center.distance - 1.0).abs() < 1e-14 && center.at_least > 0.99 && center.at_least <= 1.0);
    assert!(sphere.closest_point(DVec3::NAN, 1e-9).is_err());
    assert!(sphere.closest_point(DVec3::X, 0.0).is_err());
}

#[test]
fn closest_point_is_no_farther_than_any_of_a_dense_grid() {
    let surface = reference();
    for i in 0..12 {
        let t = f64::from(i);
        let query =
            DVec3::new(2.5 + 3.0 * (t * 1.9).sin(), 2.0 + 3.0 * (t * 0.7).cos(), 2.0 * (t * 2.3).sin());
        let found = surface.closest_point(query, 1e-9).unwrap();
        let steps = |n: i32| (0..=n).map(move |k| f64::from(k) / f64::from(n));
        let least = steps(100)
            .flat_map(|u| steps(100).map(move |v| (u, v)))
            .map(|(u, v)| surface.point(u, v).distance(query))
            .fold(f64::INFINITY, f64::min);
        assert!(found.distance <= least && least - found.distance < 0.01, "{found:?} {least}");
        assert!(found.distance - found.at_least <= 2e-9, "{found:?}");
    }
}

#[test]
fn unusable_surfaces_are_refused() {
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let with = |points: Vec<DVec4>| NurbsSurface::try_new(1, 1, knots(), knots(), points);
    assert!(matches!(with(vec![DVec4::ONE; 3]), Err(SurfaceError::CountMismatch { expected: 4, .. })));
    for (bad, kind) in [(0.0, true), (-1.0, true), (f64::NAN, false), (f64::INFINITY, false)] {
        let refused = with(vec![DVec4::ONE, DVec4::ONE.with_w(bad), DVec4::ONE, DVec4::ONE]).unwrap_err();
        assert_eq!(matches!(refused, SurfaceError::NotPositive { .. }), kind, "{refused}");
    }
    assert!(with(vec![DVec4::ONE.with_x(f64::NAN); 4]).is_err());
    let tiny = DVec4::new(1e300, 0.0, 0.0, 1e-300);
    assert!(matches!(with(vec![tiny; 4]), Err(SurfaceError::NotFinite { .. })));
    let named = NurbsSurface::try_new(1, 1, knots(), vec![0.0, 0.0, 1.0, f64::NAN], vec![DVec4::ONE; 4]);
    assert!(matches!(named, Err(SurfaceError::NotFinite { parameter: "knot in v", .. })));
    let weights = NurbsSurface::try_with_weights(1, 1, knots(), knots(), &[DVec3::X; 4], &[1.0; 3]);
    assert!(matches!(weights, Err(SurfaceError::CountMismatch { parameter: "weights", .. })));
    let surface = reference();
    for bad in [0.0, 1.0, -3.0, f64::NAN] {
        assert!(
            surface.split(Direction::U, bad).is_err() && surface.insert_knot(Direction::U, bad, 1).is_err()
        );
    }
    assert!(matches!(
        surface.insert_knot(Direction::U, 0.4, 3),
        Err(SurfaceError::KnotMultiplicity { multiplicity: 4, max: 3, .. })
    ));
    assert!(surface.insert_knot(Direction::U, 0.5, usize::MAX).is_err());
    // Outside of the domain the nearest point of it answers; what is no number gives no number, and no panic.
    assert_eq!(surface.point(-1.0, 7.0), surface.point(0.0, 1.0));
    assert!(surface.point(f64::NAN, 0.5).is_nan());
}
