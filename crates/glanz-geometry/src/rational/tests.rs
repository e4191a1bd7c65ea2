//! Patches against their surfaces.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::bilinear::BilinearPatch;
use crate::quadric::{Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid};
use crate::torus::Torus;

fn surfaces() -> Vec<Surface> {
    let segment = |p1: [f64; 3], p2: [f64; 3], phi_max| {
        Hyperboloid::try_new(p1.into(), p2.into(), phi_max).unwrap().into()
    };
    vec![
        Sphere::try_full(1.5).unwrap().into(),
        Sphere::try_new(1.5, [-0.5, 1.5], 5.0).unwrap().into(),
        Sphere::try_new(2.0, [-2.0, 2.0], 1.0).unwrap().into(),
        Sphere::try_new(2.0, [0.3, 0.31], TAU).unwrap().into(),
        Cylinder::try_new(0.5, [1.0, -2.0], TAU).unwrap().into(),
        Cylinder::try_new(0.5, [1.0, 2.0], 4.5).unwrap().into(),
        Cone::try_new(1.0, 2.0, TAU).unwrap().into(),
        Paraboloid::try_new(1.0, [0.2, 1.0], 3.0).unwrap().into(),
        Paraboloid::try_new(2.0, [0.0, 0.5], TAU).unwrap().into(),
        segment([1.0, 0.0, 0.0], [0.0, 2.0, 1.0], TAU),
        segment([1.0, 0.5, 2.0], [-0.3, 2.0, -1.0], 2.0),
        // A double cone.
        segment([1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], TAU),
        TwoSheetedHyperboloid::try_new(0.7, 0.5, [-1.0, 2.0], TAU).unwrap().into(),
        TwoSheetedHyperboloid::try_new(0.7, 0.5, [0.6, 50.0], 2.0).unwrap().into(),
        TwoSheetedHyperboloid::try_new(0.7, 0.5, [-3.0, -0.8], 2.0).unwrap().into(),
        Disk::try_new(0.3, 2.0, 0.5, 4.0).unwrap().into(),
        Disk::try_new(-1.0, 2.0, 0.0, TAU).unwrap().into(),
        Torus::try_new(2.0, 0.5, TAU).unwrap().into(),
        Torus::try_new(2.0, 0.5, 2.0 * PI / 3.0).unwrap().into(),
        Plane::try_new([-1.0, 3.0], [0.0, 2.0]).unwrap().into(),
        BilinearPatch::try_new(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)).unwrap().into(),
    ]
}

#[test]
fn patches_agree_with_the_surface_at_their_parameters() {
    for surface in surfaces() {
        let size = surface.bounds().diagonal().length();
        for RationalPatch { patch, u, v } in surface.rational_patches().unwrap() {
            for (i, j) in (0..=10).flat_map(|i| (0..=10).map(move |j| (i, j))) {
                let (x, y) = (f64::from(i) / 10.0, f64::from(j) / 10.0);
                // Where v jumps from one sheet to the other it belongs to both apices.
                let jumps = surface.kind() == "twosheetedhyperboloid" && patch.point(x, y).x.abs() < 1e-12;
                if jumps && surface.bounds().min.z < 0.0 {
                    continue;
                }
                let expected = surface.at(0, DVec2::new(u.parameter(x), v.parameter(y))).unwrap().point;
                let apart = patch.point(x, y).distance(expected.position);
                assert!(apart < 1e-12 * size, "{} at {x} {y}: {apart}", surface.kind());
                // Borders may be poles, where the patch has a neighbour's normal.
                if (1..10).contains(&i) && (1..10).contains(&j) && expected.dpdu.length() > 1e-3 * size {
                    let normal = patch.normal(x, y).unwrap();
                    assert!(normal.distance(expected.normal) < 1e-12 * 1e3, "{}", surface.kind());
                }
            }
        }
    }
}

#[test]
fn parameters_cover_the_unit_square_once() {
    for surface in surfaces() {
        let length = |map: ParameterMap| map.ends[1] - map.ends[0];
        let patches = surface.rational_patches().unwrap();
        let area: f64 = patches.iter().map(|p| length(p.u) * length(p.v)).sum();
        assert!((area - 1.0).abs() < 1e-14, "{}: {area}", surface.kind());
    }
}

#[test]
fn neighbours_share_the_bits_of_their_border() {
    for surface in [
        Surface::from(Sphere::try_full(1.5).unwrap()),
        Surface::from(Torus::try_new(2.0, 0.5, TAU).unwrap()),
        Surface::from(Cylinder::try_new(0.5, [0.0, 2.0], TAU).unwrap()),
    ] {
        let patches = surface.rational_patches().unwrap();
        let row = |patch: &TensorPatch, i: usize| {
            let columns = patch.degrees().1 + 1;
            patch.control_points()[i * columns..(i + 1) * columns].to_vec()
        };
        for patch in &patches {
            let next = patches.iter().find(|p| p.u.ends[0] == patch.u.ends[1] % 1.0 && p.v == patch.v);
            assert_eq!(row(&patch.patch, 2), row(&next.unwrap().patch, 0), "{}", surface.kind());
        }
    }
}

#[test]
fn reparameterizations_start_at_0_and_end_at_1() {
    for map in [
        Reparameterization::Linear,
        Reparameterization::Circular(1.0),
        Reparameterization::Hyperbolic(0.7),
        Reparameterization::Quadratic(0.4),
    ] {
        assert!(map.fraction(0.0).abs() < 1e-15 && (map.fraction(1.0) - 1.0).abs() < 1e-15);
        assert!(map.fraction(0.5) > 0.3 && map.fraction(0.25) < map.fraction(0.3));
    }
    // By symmetry.
    assert!((Reparameterization::Circular(1.0).fraction(0.5) - 0.5).abs() < 1e-15);
}

#[test]
fn infinite_planes_and_boxes_have_no_rational_patches() {
    assert_eq!(Surface::from(Plane::infinite()).rational_patches(), None);
    let cuboid = crate::cuboid::Cuboid::try_new(DVec3::ZERO, DVec3::ONE).unwrap();
    assert_eq!(Surface::from(cuboid).rational_patches(), None);
}
