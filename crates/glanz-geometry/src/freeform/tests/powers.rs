//! Surfaces whose patches are stored as powers: control points, points and derivatives.

use std::sync::Arc;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3, Ray};

use super::super::control_net::second_order_jet;
use super::super::patch_list::PatchList;
use super::super::subpatches::SubpatchList;
use super::super::{Freeform, SurfacePatch};
use crate::RaySurface;
use crate::bezier::TensorPatch;
use crate::trim::TrimRegion;

/// Numbers uniform in [-1, 1]: Knuth's linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A wavy patch of about `size` around `middle`.
    fn patch(&mut self, (p, q): (usize, usize), middle: DVec3, size: f64) -> SurfacePatch {
        let points = (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))).map(|(i, j)| {
            let flat = DVec3::new(i as f64 / p as f64, j as f64 / q as f64, 0.0);
            let off = 0.3 * DVec3::new(self.next(), self.next(), self.next());
            (middle + size * (flat - DVec3::new(0.5, 0.5, 0.0) + off)).extend(1.0)
        });
        let patch = TensorPatch::try_new(p, q, points.collect()).unwrap();
        SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
    }
}

fn bits(patch: &SurfacePatch) -> Vec<[u64; 4]> {
    patch.patch().control_points().iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

/// Patches of all degrees, far from the origin (but not so far that they have coordinates of their own), across it, small and large.
fn surfaces() -> Vec<Vec<SurfacePatch>> {
    let mut random = Random(5);
    let places =
        [(DVec3::ZERO, 1.0), (DVec3::new(0.9, -0.02, 1e-4), 1e-3), (DVec3::new(-3.0, 0.0, 1e9), 1e6)];
    let degrees = (1..=3).flat_map(|p| (1..=3).map(move |q| (p, q)));
    degrees
        .flat_map(|degrees| places.map(|(middle, size)| (degrees, middle, size)))
        .map(|(degrees, middle, size)| (0..5).map(|_| random.patch(degrees, middle, size)).collect())
        .collect()
}

#[test]
fn control_points_are_restored_to_the_bit() {
    let mut all = surfaces();
    // Zeros of both signs, the smallest numbers, and coordinates of very different size.
    let odd = [0.0, -0.0, f64::MIN_POSITIVE, -5e-324, 1e-200, -1.0, 1e12, 0.1];
    let points = (0..16).map(|i| DVec4::new(odd[i % 8], odd[(i + 3) % 8] + i as f64, odd[(5 * i) % 8], 1.0));
    let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
    all.push(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()]);
    for patches in all {
        let surface = Freeform::try_new(patches.clone()).unwrap();
        assert!(matches!(*surface.patches, PatchList::Powers { .. }));
        assert_eq!(surface.patch_count(), patches.len());
        for (given, restored) in patches.iter().zip(surface.patches()) {
            assert_eq!(bits(given), bits(&restored));
            assert_eq!(*given, restored);
        }
        assert!(surface.patch(patches.len() as u32).is_none());
    }
}

#[test]
fn points_by_powers_are_those_by_control_points_up_to_rounding() {
    let mut random = Random(9);
    for patches in surfaces() {
        let surface = Freeform::try_new(patches.clone()).unwrap();
        for (face, patch) in (0..).zip(&patches) {
            let points = patch.patch().control_points();
            let size = points.iter().map(|p| p.truncate().length()).fold(0.0, f64::max);
            let limit = 64.0 * f64::EPSILON * size;
            for _ in 0..50 {
                let (x, y) = (0.5 + 0.5 * random.next(), 0.5 + 0.5 * random.next());
                let exact = second_order_jet(points, patch.patch().degrees(), x, y);
                let found = surface.second_order(face, x, y).unwrap();
                // The bound by which the error of points is larger than by control points.
                let most = surface.patches.evaluation_rounding() * surface.frame.noise_within();
                assert!((found.s - exact.s).abs().max_element() <= most, "{} at {x} {y}", found.s - exact.s);
                let off = [found.su - exact.su, found.sv - exact.sv];
                assert!(off.iter().all(|off| off.length() <= limit), "{off:?} at {x} {y}");
                let off = [found.suu - exact.suu, found.suv - exact.suv, found.svv - exact.svv];
                assert!(off.iter().all(|off| off.length() <= 8.0 * limit), "{off:?} at {x} {y}");
                let first = surface.first_order(face, x, y).unwrap();
                assert_eq!([first.s, first.su, first.sv], [found.s, found.su, found.sv]);
            }
        }
    }
}

#[test]
fn polynomial_patches_far_from_the_origin_are_searched_without_weights() {
    let mut random = Random(17);
    let patches: Vec<_> =
        (0..3_u32).map(|k| random.patch((3, 2), DVec3::new(1e5, 3.0 * f64::from(k), 0.0), 1.0)).collect();
    let surface = Freeform::try_new(patches.clone()).unwrap();
    assert!(matches!(*surface.patches, PatchList::Moved { .. }));
    assert!(matches!(*surface.subpatches, SubpatchList::Polynomial(_)));
    for given in &patches {
        let point = given.patch().point(0.4, 0.7);
        let mut hits = Vec::new();
        let ray = Ray::new(point + DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z);
        surface.all_hits(&ray, f64::INFINITY, &mut hits);
        assert!(hits.iter().any(|hit| (hit.t - 5.0).abs() < 1e-6), "{point}: {hits:?}");
    }
    for (given, stored) in patches.iter().zip(surface.patches()) {
        assert_eq!(bits(given), bits(&stored));
    }
}

#[test]
fn control_points_of_more_patches_than_are_given_back_at_once_are_restored() {
    let mut random = Random(11);
    let patches: Vec<_> = (0..20_000_u32)
        .map(|k| random.patch((1, 1), DVec3::new(f64::from(k % 140), f64::from(k / 140), 0.0), 0.9))
        .collect();
    let surface = Freeform::try_new(patches.clone()).unwrap();
    assert!(matches!(*surface.patches, PatchList::Powers { .. }));
    assert!(patches.iter().zip(surface.patches()).all(|(given, restored)| bits(given) == bits(&restored)));
}

#[test]
fn equal_weights_other_than_one_are_kept() {
    let points = [(0.0, 0.0), (0.0, 2.0), (2.0, 0.0), (2.0, 2.0)].map(|(x, y)| DVec4::new(x, y, 0.0, 2.0));
    let patch = TensorPatch::try_new(1, 1, points.to_vec()).unwrap();
    let given = SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap();
    let surface = Freeform::try_new(vec![given.clone()]).unwrap();
    assert_eq!(bits(&surface.patch(0).unwrap()), bits(&given));
}

/// All bits of the leaves, in the order of the hierarchy.
fn leaf_bits(surface: &Freeform) -> Vec<String> {
    // Numbers are printed with as many digits as tell them apart.
    surface.leaves.iter().map(|leaf| format!("{leaf:?}")).collect()
}

#[test]
fn a_region_that_keeps_all_changes_no_leaf_and_shares_the_patches() {
    let mut random = Random(13);
    // Stored as powers, in three and in four coordinates; as nets; and as nets of which some fall into several subpatches.
    for (degree, weight) in [(3, 1.0), (3, 1.1), (5, 1.1), (2, 30.0), (5, 30.0)] {
        let patches = (0..150_u32).map(|k| {
            let patch = random.patch((degree, 2), DVec3::new(f64::from(k % 12), f64::from(k / 12), 0.0), 0.9);
            let mut points = patch.patch().control_points().to_vec();
            points[0] *= if k % 3 == 0 { weight } else { 1.0 };
            let patch = TensorPatch::try_new(degree, 2, points).unwrap();
            SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
        });
        let whole = Freeform::try_new(patches.collect()).unwrap();
        assert_eq!(whole.locations.is_empty(), weight < 4.0);
        let region = TrimRegion::try_new(Vec::new(), [DVec2::splat(-1.0), DVec2::splat(2.0)]).unwrap();
        let trimmed = whole.trimmed(Arc::new(region));
        assert_eq!(leaf_bits(&trimmed), leaf_bits(&whole));
        assert!(Arc::ptr_eq(&trimmed.patches, &whole.patches));
        assert!(Arc::ptr_eq(&trimmed.subpatches, &whole.subpatches));
    }
}
