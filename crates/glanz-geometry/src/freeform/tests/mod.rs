//! Known roots, seams and degenerate patches. The contract test of all surfaces shoots many more rays.

mod instruction_sets;
mod pair_queue;
mod powers;

use std::sync::Arc;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3, Ray};

use super::{Freeform, SurfacePatch};
use crate::bezier::{TensorPatch, TrianglePatch};
use crate::hit::Hit;
use crate::spline::NurbsSurface;
use crate::surface::RaySurface;
use crate::trim::{TrimCurve, TrimLoop, TrimRegion};

fn all(surface: &Freeform, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    surface.all_hits(ray, f64::INFINITY, &mut hits);
    hits
}

fn of_triangle(triangle: &TrianglePatch) -> Freeform {
    let pieces =
        triangle.to_quads().into_iter().map(|q| SurfacePatch::over_quad(q.patch, q.corners).unwrap());
    Freeform::try_new(pieces.collect()).unwrap()
}

/// The patch of document 000 section 4.3, by its control points 300, 210, 201, 120, 111, 102, 030, 021, 012, 003.
fn reflector() -> Freeform {
    let points = [
        [6.0, 3.0, 5.0],
        [6.0, 4.0, 8.0],
        [5.0, 3.0, 6.0],
        [6.0, 5.0, 6.0],
        [4.5, 4.5, 7.0],
        [4.0, 3.0, 6.0],
        [6.0, 6.0, 5.0],
        [5.0, 5.0, 6.0],
        [4.0, 4.0, 6.0],
        [3.0, 3.0, 3.0],
    ];
    let points = points.map(|[x, y, z]| DVec4::new(x, y, z, 1.0));
    of_triangle(&TrianglePatch::try_new(3, points.to_vec()).unwrap())
}

#[test]
fn one_ray_of_the_fan_of_document_000_meets_the_patch() {
    // All 256 rays of the fan with k = 4 from (0, 5, 5); the root is known to 30 digits from the resultant of two
    // plane cubics.
    let surface = reflector();
    let mut met = Vec::new();
    let n = 15_i32;
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let theta = std::f64::consts::PI * f64::from(2 * i - n) / f64::from(n);
        let phi = std::f64::consts::FRAC_PI_2 * f64::from(2 * j - n) / f64::from(n);
        let v = 0.1 * DVec3::new(phi.cos() * theta.cos(), phi.cos() * theta.sin(), phi.sin());
        let ray = Ray::new(DVec3::new(0.0, 5.0, 5.0), v);
        met.extend(all(&surface, &ray).into_iter().map(|hit| (i, j, hit, surface.point(&ray, &hit))));
    }
    let [(7, 8, hit, point)] = met[..] else { panic!("{met:?}") };
    assert!((hit.t - 43.341_790_020_607_25).abs() < 1e-11);
    let (s, t) = (0.354_776_787_529_589_9, 0.581_425_944_232_568_5);
    assert!((point.uv - DVec2::new(s, t)).length() < 1e-13);
    let normal = DVec3::new(-0.812_378_898_193_333_8, 0.425_688_116_503_215_64, 0.398_535_008_798_637_07);
    assert!(point.normal.cross(normal).length() < 1e-13);
    // The line that was published misses the patch, however it is rounded.
    let published =
        Ray::new(DVec3::new(0.0, 5.0, 5.0), DVec3::new(0.092_368_038, -0.028_980_659, -0.025_065_253));
    assert_eq!(all(&surface, &published), []);
    assert_eq!(surface.undecided(), 0);
}

#[test]
fn spline_surface_has_the_roots_of_the_reference() {
    // Roots with 40 digits of an independent evaluation.
    let heights = [0.0, 0.783_327, 0.973_848, 0.427_38, -0.442_52, -0.977_53];
    let z: [[f64; 5]; 6] = [
        [0.0; 5],
        [heights[1], 0.599_121, 0.133_14, -0.395_46, -0.738_068],
        [heights[2], 0.744_84, 0.165_522, -0.491_643, -0.917_581],
        [heights[3], 0.326_878, 0.072_641, -0.215_761, -0.402_687],
        [heights[4], -0.338_458, -0.075_214, 0.223_405, 0.416_953],
        [heights[5], -0.747_656, -0.166_148, 0.493_502, 0.921_051],
    ];
    let a = [1.0, 1.166_667, 1.333_333, 1.5];
    let w: [[f64; 5]; 6] = [
        [a[0], a[1], a[2], a[3], a[0]],
        [a[3], a[0], a[1], a[2], a[3]],
        [a[2], a[3], a[0], a[1], a[2]],
        [a[1], a[2], a[3], a[0], a[1]],
        [a[0], a[1], a[2], a[3], a[0]],
        [a[3], a[0], a[1], a[2], a[3]],
    ];
    let points = (0..30).map(|k| {
        let (i, j) = (k / 5, k % 5);
        DVec3::new(i as f64, j as f64, z[i][j]).extend(1.0) * w[i][j]
    });
    let knots_u = vec![0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0];
    let knots_v = vec![0.0, 0.0, 0.0, 0.35, 0.6, 1.0, 1.0, 1.0];
    let spline = NurbsSurface::try_new([3, 2], [knots_u, knots_v], points.collect()).unwrap();
    let surface = spline.to_freeform().unwrap();
    /// Origin, direction, and the roots as u, v and t.
    type Expected = ([f64; 3], [f64; 3], &'static [[f64; 3]]);
    let expected: [Expected; 3] = [
        (
            [2.2, 1.7, 5.0],
            [0.1, 0.05, -1.0],
            &[[0.568_594_757_101_075, 0.466_937_939_598_131_07, 4.914_751_312_365_184]],
        ),
        (
            [-2.0, -1.0, 0.15],
            [1.0, 0.55, 0.0],
            &[
                [0.021_582_328_987_200_146, 0.035_794_111_441_449_825, 2.514_631_340_192_512_5],
                [0.649_477_147_990_037_9, 0.389_678_026_492_642_9, 5.631_531_553_810_419],
                [0.946_626_268_910_357_1, 0.649_673_917_058_694_2, 7.404_951_832_606_883_5],
            ],
        ),
        (
            [-1.0, 2.1, 0.0],
            [1.0, 0.02, 0.01],
            &[
                [0.029_664_041_153_982_36, 0.508_469_372_498_130_5, 1.192_618_668_597_866_4],
                [0.469_080_151_637_537_25, 0.535_269_979_116_236_6, 3.346_455_958_553_354_6],
            ],
        ),
    ];
    for (origin, direction, roots) in expected {
        let ray = Ray::new(origin.into(), DVec3::from(direction).normalize());
        let hits = all(&surface, &ray);
        assert_eq!(hits.len(), roots.len(), "{hits:?}");
        for (hit, &[u, v, t]) in hits.iter().zip(roots) {
            let uv = surface.point(&ray, hit).uv;
            assert!((hit.t - t).abs() < 1e-12 && (uv - DVec2::new(u, v)).length() < 1e-12, "{hit:?} {uv:?}");
        }
    }
}

#[test]
fn rays_through_the_seam_of_two_patches_meet_it_once() {
    // Two bicubic patches of a wave with the row of control points in common.
    let height = |i: usize, j: usize| (1.3 * i as f64 + 0.4).sin() * (0.9 * j as f64).cos();
    let patch = |from: usize| {
        let points = (from..from + 4)
            .flat_map(|i| (0..4).map(move |j| DVec4::new(i as f64 / 3.0, j as f64 / 3.0, height(i, j), 1.0)));
        let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
        SurfacePatch::over_rectangle(patch, [from as f64, from as f64 + 3.0], [0.0, 3.0]).unwrap()
    };
    let surface = Freeform::try_new(vec![patch(0), patch(3)]).unwrap();
    for k in 0..50_000 {
        let k = f64::from(k);
        let target = surface.point_at(0, 1.0, (k * 0.618_033_988_7).fract()).position;
        let origin = target + DVec3::new((1.7 * k).sin(), (2.3 * k).cos(), 1.5 + k.sin()) * 3.0;
        let hits = all(&surface, &Ray::new(origin, target - origin));
        let there = hits.iter().filter(|h| (h.t - 1.0).abs() < 1e-9).count();
        // One root, found in one patch or in both.
        assert_eq!(there, 1, "{origin:?} {target:?} {hits:?}");
    }
    assert_eq!(surface.undecided(), 0);
}

#[test]
fn tangent_ray_meets_a_parabola_once_and_one_beside_it_twice_or_never() {
    // z = -x^2 over [-1, 1] x [0, 1], along x at height z: roots at +-sqrt(-z).
    let points = [[-1.0, -1.0], [0.0, 1.0], [1.0, -1.0]];
    let points = points.iter().flat_map(|&[x, z]| [0.0, 1.0].map(|y| DVec4::new(x, y, z, 1.0)));
    let patch = TensorPatch::try_new(2, 1, points.collect()).unwrap();
    let surface =
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
            .unwrap();
    let along = |z: f64| all(&surface, &Ray::new(DVec3::new(-3.0, 0.3, z), DVec3::X));
    assert_eq!(along(0.0).len(), 1);
    assert_eq!(along(1e-9), []);
    for depth in [1e-3, 1e-6, 1e-9, 1e-11] {
        let hits = along(-depth);
        assert_eq!(hits.len(), 2, "{depth}: {hits:?}");
        for (hit, x) in hits.iter().zip([-depth.sqrt(), depth.sqrt()]) {
            assert!((hit.t - 3.0 - x).abs() < 1e-14 / depth.sqrt(), "{depth}: {hit:?}");
        }
    }
    // In the plane of the rulings, along one of them: no hit, and no unlimited subdivision.
    assert_eq!(all(&surface, &Ray::new(DVec3::new(0.5, -1.0, -0.25), DVec3::Y)), []);
    assert_eq!(surface.undecided(), 0);
}

#[test]
fn tangency_next_to_a_cusp_does_not_hide_the_root_beside_it() {
    // The first derivative along u vanishes at u = 1/2. By 50-digit arithmetic there are roots at u = 0.4999053076
    // and, closer to each other than rounding can resolve, at 0.5001891386 and 0.5001896316.
    let row = |k: usize| ([0.0, 1.0, 0.0, 1.0][k / 4], (k % 4) as f64 / 3.0, [0.0, 1.0, 1.0, 0.0][k / 4]);
    let points = (0..16).map(row).map(|(x, y, z)| DVec4::new(x, y, z, 1.0));
    let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
    let surface =
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
            .unwrap();
    let ray = Ray::new(
        DVec3::new(0.498_859_539_470_083_66, 0.170_785_592_721_375_64, 3.760_954_794_414_791),
        DVec3::new(0.065_010_139_116_226_77, 9.825_831_809_107_976e-13, -171.634_692_525_154_46),
    );
    let hits = all(&surface, &ray);
    let found = |u: f64, within: f64| hits.iter().filter(|hit| (hit.u - u).abs() < within).count();
    assert_eq!((hits.len(), found(0.499_905_3, 1e-6), found(0.500_189_4, 1e-5)), (2, 1, 1), "{hits:?}");
}

#[test]
fn ray_within_the_plane_of_a_flat_patch_is_no_hit() {
    // Projected edge-on, the Jacobian is only rounding and must not certify anything.
    let third = |k: i32| f64::from(k) / 3.0;
    let points = (0..4).flat_map(|i| (0..4).map(move |j| DVec4::new(third(i), third(j), 0.0, 1.0)));
    let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
    let surface =
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
            .unwrap();
    for (x, y, dx, dy) in [
        (-1.150_881_977_367_205_4, 2.817_548_644_033_872, 1.0, -1.0),
        (
            -1.999_454_936_177_244_2,
            1.999_636_624_118_162_7,
            0.021_886_989_618_407_49,
            -0.014_591_326_412_271_661,
        ),
        (-0.898_938_010_291_137_4, 3.464_542_689_248_941_7, 1.0, -2.0),
        (-1.0, 0.25, 1.0, 0.0),
    ] {
        let ray = Ray::new(DVec3::new(x, y, 0.0), DVec3::new(dx, dy, 0.0));
        assert_eq!(all(&surface, &ray), [], "{ray:?}");
    }
    assert_eq!(surface.undecided(), 0);
}

#[test]
fn invalid_surfaces_are_refused() {
    assert!(Freeform::try_new(Vec::new()).is_err());
    let point = TensorPatch::try_new(1, 1, vec![DVec4::ONE; 4]).unwrap();
    let point = SurfacePatch::over_rectangle(point, [0.0, 1.0], [0.0, 1.0]).unwrap();
    assert!(Freeform::try_new(vec![point]).is_err());
}

#[test]
fn grazing_rays_pass_a_seam_exactly_once() {
    // z = 0.1 x^2 + 0.05 x y^2, cut at x = 0, where it touches z = 0.
    let half = |from: f64| {
        let z = |u: [f64; 2], v: [f64; 3]| {
            // Blossom of the polynomial: u for x, v for y.
            let x = |u: f64| from + u;
            0.1 * x(u[0]) * x(u[1])
                + 0.05 * 0.5 * (x(u[0]) + x(u[1])) * (v[0] * v[1] + v[1] * v[2] + v[0] * v[2]) / 3.0
        };
        let points = (0..3).flat_map(|i| {
            (0..4).map(move |j| {
                let u = [0, 1].map(|k| if k < i { 1.0 } else { 0.0 });
                let v = [0, 1, 2].map(|k| if k < j { 1.0 } else { 0.0 });
                DVec4::new(from + 0.5 * i as f64, j as f64 / 3.0, z(u, v), 1.0)
            })
        });
        let patch = TensorPatch::try_new(2, 3, points.collect()).unwrap();
        SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
    };
    let surface = Freeform::try_new(vec![half(-1.0), half(0.0)]).unwrap();
    for k in 0..20_000 {
        let y = 0.05 + 0.9 * f64::from(k % 101) / 101.0;
        let angle = 2.4 * f64::from(k);
        let steep = 10.0_f64.powf(-1.0 - 4.0 * f64::from(k) / 20_000.0);
        let normal = DVec3::new(-0.05 * y * y, 0.0, 1.0);
        let tangent = DVec3::new(angle.cos(), angle.sin(), 0.05 * y * y * angle.cos());
        let direction = (tangent - normal * steep).normalize();
        let ray = Ray::new(DVec3::new(0.0, y, 0.0) - direction * 3.0, direction);
        let near = |hit: &&Hit| (hit.t - 3.0).abs() < steep;
        let hits = all(&surface, &ray);
        assert_eq!(hits.iter().filter(near).count(), 1, "{k} {steep:e} {hits:?}");
    }
    assert_eq!(surface.undecided(), 0);
}

/// The unit square of parameters without two round holes, whose border has a width.
fn plate(radius: f64, width: f64) -> Arc<TrimRegion> {
    let hole = |x, y| {
        let circle = TrimCurve::try_circle(DVec2::new(x, y), radius).unwrap().reversed();
        TrimLoop::try_closed(circle, 0.0).unwrap()
    };
    let domain = [DVec2::ZERO, DVec2::ONE];
    let region = TrimRegion::try_new(vec![hole(0.3, 0.3), hole(0.7, 0.6)], domain).unwrap();
    Arc::new(region.with_widened_border(width).unwrap())
}

#[test]
fn trimmed_surface_has_the_hits_whose_parameters_are_kept() {
    let points = (0..16).map(|k: i32| {
        let (i, j) = (f64::from(k / 4), f64::from(k % 4));
        DVec4::new(i / 3.0, j / 3.0, 0.5 * (2.0 * f64::from(k)).sin(), 1.0)
    });
    let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
    let waves = Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
        .unwrap();
    for whole in [waves, reflector()] {
        let region = plate(0.16, 0.02);
        let trimmed = whole.trimmed(region.clone());
        assert!(trimmed.is_trimmed() && trimmed.sample(DVec2::splat(0.5)).is_none());
        let patches = (0..whole.patch_count() as u32).filter_map(|face| whole.patch(face)).collect();
        let built = Freeform::try_trimmed(patches, region.clone()).unwrap();
        assert_eq!(built.leaves.len(), trimmed.leaves.len());
        assert!(built.leaves.len() < whole.leaves.len());
        let bounds = whole.bounds();
        let (center, size) = (bounds.center(), bounds.diagonal().length());
        let (mut counts, mut borders) = ([0; 2], [0; 3]);
        for k in 0..4000 {
            let turn = |rate: f64| (rate * f64::from(k)).sin();
            let target = center + 0.4 * size * DVec3::new(turn(1.3), turn(2.7), 0.3 * turn(3.1));
            let direction = DVec3::new(turn(0.7), turn(1.9), 0.5 + turn(4.1).abs());
            let ray = Ray::new(target - direction * 3.0 * size, direction);
            let of_whole = all(&whole, &ray);
            let is_kept = |hit: &&Hit| region.contains(whole.point(&ray, hit).uv);
            let kept: Vec<Hit> = of_whole.iter().filter(is_kept).copied().collect();
            counts[0] += of_whole.len();
            counts[1] += kept.len();
            let hits = all(&trimmed, &ray);
            assert_eq!(hits.len(), kept.len(), "{ray:?}");
            for (hit, of_whole) in hits.iter().zip(&kept) {
                assert!((hit.t - of_whole.t).abs() < 1e-11);
                let location = region.locate(whole.point(&ray, of_whole).uv);
                assert_eq!(Some(hit.border), location.border());
                borders[hit.border as usize] += 1;
            }
            assert_eq!(trimmed.intersect(&ray, f64::INFINITY), hits.first().copied());
            assert_eq!(all(&built, &ray), hits);
            assert_eq!(trimmed.occluded(&ray, f64::INFINITY), !hits.is_empty());
        }
        assert!(counts[1] > 500 && counts[0] > counts[1] + 50, "{counts:?}");
        assert!(borders.iter().all(|&count| count > 20), "{borders:?}");
    }
}

#[test]
fn area_of_a_trimmed_plane_is_that_without_its_holes() {
    let corners = [(0.0, 0.0), (0.0, 2.0), (3.0, 0.0), (3.0, 2.0)].map(|(x, y)| DVec4::new(x, y, 0.0, 1.0));
    let patch = TensorPatch::try_new(1, 1, corners.to_vec()).unwrap();
    let plane = Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
        .unwrap();
    assert!((plane.area() - 6.0).abs() < 1e-12);
    // Parameters are six times as dense as the area.
    let expected = 6.0 * (1.0 - 2.0 * std::f64::consts::PI * 0.15 * 0.15);
    assert!((plane.trimmed(plate(0.15, 0.0)).area() / expected - 1.0).abs() < 1e-3);
}

#[test]
fn weights_do_not_hide_roots_next_to_the_border_of_a_leaf() {
    // Weights that grow fourfold along u, so that they differ much from those of the patch's middle.
    let points = (0..16).map(|k| {
        let (i, j) = (k / 4, k % 4);
        let (x, y) = (f64::from(i) / 3.0, f64::from(j) / 3.0);
        let w = 1.0 + 2.9 * x;
        (DVec3::new(x, y, 0.5 * (4.0 * x).sin() * (1.0 + y)) * w).extend(w)
    });
    let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
    let surface =
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch.clone(), [0.0, 1.0], [0.0, 1.0]).unwrap()])
            .unwrap();
    for k in 0..100_000 {
        // Next to the borders of leaves, which lie at multiples of powers of two.
        let turn = |a: f64| (f64::from(k) * a).fract();
        let (border, off) = ((turn(0.377) * 32.0).round() / 32.0, 4e-2 * (turn(0.618) - 0.5).powi(5));
        let (u, v) = ((border + off).clamp(0.0, 1.0), turn(0.733));
        let (u, v) = if k % 2 == 0 { (u, v) } else { (v, u) };
        let target = patch.point(u, v);
        let direction = DVec3::new(turn(0.123) - 0.5, turn(0.456) - 0.5, -1.0 - turn(0.789));
        let mut hits = Vec::new();
        surface.all_hits(&Ray::new(target - direction, direction), f64::INFINITY, &mut hits);
        assert!(hits.iter().any(|h| (h.t - 1.0).abs() < 1e-9), "{u} {v} {direction}: {hits:?}");
    }
}

#[test]
fn patches_without_area_count_where_the_region_keeps_them() {
    // Over [0, 1] in u a square, over [1, 2] a line.
    let bilinear = |u: f64, height: f64| {
        let points =
            [0.0, 1.0].into_iter().flat_map(|x| [0.0, height].map(|y| DVec4::new(u + x, y, 0.0, 1.0)));
        let patch = TensorPatch::try_new(1, 1, points.collect()).unwrap();
        SurfacePatch::over_rectangle(patch, [u, u + 1.0], [0.0, 1.0]).unwrap()
    };
    let patches = vec![bilinear(0.0, 1.0), bilinear(1.0, 0.0)];
    let whole = Freeform::try_new(patches.clone()).unwrap();
    assert_eq!(whole.patches_without_area(), [1_u32]);
    for (center, expected) in [(0.5, &[][..]), (1.5, &[1_u32][..])] {
        let circle = TrimCurve::try_circle(DVec2::new(center, 0.5), 0.3).unwrap();
        let domain = [DVec2::ZERO, DVec2::new(2.0, 1.0)];
        let loops = vec![TrimLoop::try_closed(circle, 1e-9).unwrap()];
        let region = Arc::new(TrimRegion::try_new(loops, domain).unwrap());
        assert_eq!(whole.trimmed(Arc::clone(&region)).patches_without_area(), expected);
        let trimmed = Freeform::try_trimmed(patches.clone(), region).unwrap();
        assert_eq!(trimmed.patches_without_area(), expected);
    }
}

#[test]
fn a_factor_of_all_weights_changes_no_hit() {
    // A rational wave of degree 5 whose tangent rays need subdivision and contact curves.
    let surface = |factor: f64| {
        let points = (0..36).map(|k| {
            let (i, j) = (f64::from(k / 6), f64::from(k % 6));
            let (point, weight) =
                (DVec3::new(i, j, (1.3 * i).sin() * (1.7 * j).cos()), 1.0 + 0.1 * (i * j).sin());
            (point * weight).extend(weight) * factor
        });
        let patch = TensorPatch::try_new(5, 5, points.collect()).unwrap();
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()]).unwrap()
    };
    let plain = surface(1.0);
    let mut rays = Vec::new();
    for k in 0..200 {
        let part = |a: f64| (f64::from(k) * a).fract();
        let probe = Ray::new(DVec3::new(5.0 * part(0.618), 5.0 * part(0.733), 9.0), -DVec3::Z);
        for hit in all(&plain, &probe) {
            let at = plain.point(&probe, &hit);
            let along = at.normal.cross(DVec3::new(part(0.377) - 0.5, part(0.541) - 0.5, 0.1)).normalize();
            rays.push(Ray::new(at.position - 20.0 * along, along));
        }
    }
    let expected: Vec<Vec<Hit>> = rays.iter().map(|ray| all(&plain, ray)).collect();
    assert!(plain.subdivision_cells() > 1000, "{}", plain.subdivision_cells());
    for exponent in [-560, 560] {
        let scaled = surface(2.0_f64.powi(exponent));
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(all(&scaled, ray), *expected, "{exponent} {ray:?}");
        }
        assert_eq!(scaled.undecided(), 0);
    }
}
