//! Surfaces that jump at knots of full multiplicity.

use std::sync::Arc;

use glanz_math::{DVec2, DVec3, Ray};

use super::*;
use crate::freeform::Freeform;
use crate::trim::{TrimCurve, TrimLoop, TrimRegion};
use crate::{RaySurface, SurfaceError};

/// Of degrees 2 and 1 over [0, 2] x [0, 1]: z = u^2 for u below 1, and z = 5 + (u - 1) from there on, over x = u, y = v. `times` is the
/// number of knots at u = 1; idle control points are far away.
fn step(times: usize) -> Result<NurbsSurface, SurfaceError> {
    let knots_u = [vec![0.0; 3], vec![1.0; times], vec![2.0; 3]].concat();
    let mut profile = vec![(0.0, 0.0), (0.5, 0.0), (1.0, 1.0)];
    profile.extend(vec![(1e3, 1e3); times.saturating_sub(3)]);
    profile.extend([(1.0, 5.0), (1.5, 5.5), (2.0, 6.0)]);
    let points: Vec<DVec3> =
        profile.into_iter().flat_map(|(x, z)| [0.0, 1.0].map(|y| DVec3::new(x, y, z))).collect();
    NurbsSurface::try_from_points([2, 1], [knots_u, vec![0.0, 0.0, 1.0, 1.0]], &points, None)
}

fn height(u: f64) -> f64 {
    if u < 1.0 { u * u } else { 4.0 + u }
}

/// Heights at which the vertical line through (x, y) meets a surface.
fn heights(surface: &Freeform, x: f64, y: f64) -> Vec<f64> {
    let mut hits = Vec::new();
    surface.all_hits(&Ray::new(DVec3::new(x, y, 10.0), DVec3::NEG_Z), f64::INFINITY, &mut hits);
    hits.iter().map(|hit| 10.0 - hit.t).collect()
}

#[test]
fn surface_consists_of_the_pieces_beside_its_jump() {
    for times in [3, 4, 6] {
        let surface = step(times).unwrap();
        assert_eq!(surface.counts(), (6, 2));
        for u in [0.0, 0.3, 0.999, 1.0, 1.7, 2.0] {
            let point = surface.point(u, 0.25);
            assert!(point.distance(DVec3::new(u, 0.25, height(u))) < 1e-14, "{u}: {point}");
        }
        let pieces = surface.bezier_patches().unwrap();
        assert_eq!(pieces.iter().map(|piece| piece.u).collect::<Vec<_>>(), [[0.0, 1.0], [1.0, 2.0]]);
        // The end of the first, which no parameter of the whole surface has.
        assert!(pieces[0].patch.point(1.0, 0.5).distance(DVec3::new(1.0, 0.5, 1.0)) < 1e-14);
        let freeform = surface.to_freeform().unwrap();
        for x in [0.1, 0.9, 1.1, 1.9] {
            let found = heights(&freeform, x, 0.6);
            assert!(matches!(*found, [z] if (z - height(x)).abs() < 1e-12), "{x}: {found:?}");
        }
        // The parabola's length: sqrt(5) / 2 + asinh(2) / 4, the line's sqrt(2); one wide.
        let expected = 5.0_f64.sqrt() / 2.0 + 2.0_f64.asinh() / 4.0 + 2.0_f64.sqrt();
        assert!((freeform.area() - expected).abs() < 1e-5 * expected, "{}", freeform.area());
    }
    // Vertical between the pieces there is nothing.
    let freeform = step(3).unwrap().to_freeform().unwrap();
    let across = Ray::new(DVec3::new(-1.0, 0.5, 3.0), DVec3::X);
    assert!(freeform.intersect(&across, f64::INFINITY).is_none());
}

#[test]
fn trims_cut_the_piece_that_has_their_parameters() {
    let surface = step(3).unwrap();
    let circle =
        |u: f64| TrimLoop::try_closed(TrimCurve::try_circle(DVec2::new(u, 0.5), 0.3).unwrap(), 1e-9).unwrap();
    let domain = [DVec2::ZERO, DVec2::new(2.0, 1.0)];
    for (center, other) in [(0.5, 1.5), (1.5, 0.5)] {
        let region = Arc::new(TrimRegion::try_new(vec![circle(center)], domain).unwrap());
        let kept = Freeform::try_trimmed(surface.surface_patches().unwrap(), region).unwrap();
        assert!(matches!(*heights(&kept, center, 0.5), [z] if (z - height(center)).abs() < 1e-12));
        assert!(heights(&kept, other, 0.5).is_empty() && heights(&kept, center + 0.4, 0.5).is_empty());
    }
    // A region across the jump keeps a half disk of each.
    let region = Arc::new(TrimRegion::try_new(vec![circle(1.0)], domain).unwrap());
    let kept = Freeform::try_trimmed(surface.surface_patches().unwrap(), region).unwrap();
    for x in [0.75, 1.25] {
        assert!(matches!(*heights(&kept, x, 0.5), [z] if (z - height(x)).abs() < 1e-12));
    }
}

#[test]
fn edits_keep_the_jump() {
    let surface = step(3).unwrap();
    let u = ParameterDirection::U;
    let edited = [
        surface.insert_knot(u, 0.5, 1).unwrap(),
        surface.elevate(u).unwrap(),
        surface.restrict([[0.1, 1.9], [0.0, 1.0]]).unwrap(),
        surface.reversed(u).unwrap().reversed(u).unwrap(),
    ];
    for edited in edited {
        for u in [0.2, 0.6, 0.999, 1.0, 1.4] {
            assert!(edited.point(u, 0.5).distance(DVec3::new(u, 0.5, height(u))) < 1e-13, "{u}");
        }
    }
    let (before, after) = surface.split(u, 1.0).unwrap();
    assert!((before.point(1.0, 0.0).z, after.point(1.0, 0.0).z) == (1.0, 5.0));
    assert!(matches!(surface.insert_knot(u, 1.0, 1), Err(SurfaceError::KnotMultiplicity { .. })));
    assert!(matches!(surface.remove_knot(u, 1.0, 1.0), Err(SurfaceError::KnotNeeded { .. })));
    let v = surface.isocurve(ParameterDirection::V, 0.5);
    assert!(matches!(v, Err(SurfaceError::KnotMultiplicity { multiplicity: 3, max: 2, .. })));
}

#[test]
fn reversal_does_not_tear_a_surface_whose_knots_coincide_by_rounding() {
    // The mirror images of both inner knots are 0, and the piece between them has the points from x = 1 to 2.
    let knots_u = vec![-1.0, -1.0, 1e-17, 2e-17, 1.0, 1.0];
    let points: Vec<DVec3> =
        [0.0, 1.0, 2.0, 3.0].into_iter().flat_map(|x| [0.0, 1.0].map(|y| DVec3::new(x, y, 0.0))).collect();
    let surface =
        NurbsSurface::try_from_points([1, 1], [knots_u, vec![0.0, 0.0, 1.0, 1.0]], &points, None).unwrap();
    assert!(matches!(
        surface.reversed(ParameterDirection::U),
        Err(SurfaceError::KnotMultiplicity { multiplicity: 2, max: 1, .. })
    ));
    // Beside a jump, too.
    let knots = KnotVector::try_with_jumps(1, vec![-1.0, -1.0, -0.5, -0.5, 1e-17, 2e-17, 1.0, 1.0]).unwrap();
    assert!(matches!(knots.reversed(), Err(SurfaceError::KnotMultiplicity { value: 0.0, .. })));
    let knots = KnotVector::try_with_jumps(1, vec![-1.0, -1.0, -0.5, -0.5, 0.25, 1.0, 1.0]).unwrap();
    assert_eq!(knots.reversed().unwrap().knots(), [-1.0, -1.0, -0.25, 0.5, 0.5, 1.0, 1.0]);
}

#[test]
fn continuous_pieces_end_at_the_jumps() {
    let surface = step(3).unwrap();
    let pieces = surface.continuous_pieces().unwrap();
    let domains: Vec<_> = pieces.iter().map(|piece| piece.knots_u().domain()).collect();
    assert_eq!(domains, [[0.0, 1.0], [1.0, 2.0]]);
    // The height at the jump belongs to both sides, each with its own.
    assert_eq!([pieces[0].point(1.0, 0.5).z, pieces[1].point(1.0, 0.5).z], [1.0, 5.0]);
    assert_eq!(pieces[1].continuous_pieces().unwrap(), [pieces[1].clone()]);
    // In both directions: two rows of three.
    let knots_u = vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0];
    let knots_v = vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0];
    let points: Vec<DVec3> =
        (0..4).flat_map(|i| (0..6).map(move |j| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
    let grid = NurbsSurface::try_from_points([1, 1], [knots_u, knots_v], &points, None).unwrap();
    let corners: Vec<_> = grid
        .continuous_pieces()
        .unwrap()
        .iter()
        .map(|piece| piece.point(piece.knots_u().domain()[0], piece.knots_v().domain()[0]))
        .collect();
    let expected = [0.0, 2.0].into_iter().flat_map(|x| [0.0, 2.0, 4.0].map(|y| DVec3::new(x, y, 0.0)));
    assert_eq!(corners, expected.collect::<Vec<_>>());
}
