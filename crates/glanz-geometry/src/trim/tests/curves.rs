//! Curves and loops.

use super::*;
use crate::error::SurfaceError;

#[test]
fn bezier_pieces_of_a_nurbs_curve_are_the_curve() {
    /// Basis functions by their definition.
    fn basis(i: usize, p: usize, knots: &[f64], t: f64) -> f64 {
        if p == 0 {
            return f64::from(u8::from(knots[i] <= t && t < knots[i + 1]));
        }
        let part = |a: f64, b: f64, value: f64| if b > 0.0 { a / b * value } else { 0.0 };
        part(t - knots[i], knots[i + p] - knots[i], basis(i, p - 1, knots, t))
            + part(knots[i + p + 1] - t, knots[i + p + 1] - knots[i + 1], basis(i + 1, p - 1, knots, t))
    }
    let mut random = Random(11);
    let clamped = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.5, 3.0, 3.0, 3.0, 3.0];
    let unclamped = vec![-1.0, 0.0, 0.2, 1.0, 1.5, 2.0, 2.0, 3.0, 4.0, 4.5, 6.0];
    for knots in [clamped, unclamped] {
        let points: Vec<DVec3> = (0..7).map(|_| random.point().extend(0.5 + random.unit())).collect();
        let curve = TrimCurve::try_nurbs(3, &knots, &points).unwrap();
        let mut breaks = knots[3..=7].to_vec();
        breaks.dedup();
        assert_eq!(curve.piece_count(), breaks.len() - 1);
        for piece in 0..curve.piece_count() {
            for i in 0..20 {
                let share = f64::from(i) / 20.0;
                let t = breaks[piece] + share * (breaks[piece + 1] - breaks[piece]);
                let sum: DVec3 = (0..7).map(|j| points[j] * basis(j, 3, &knots, t)).sum();
                let found = curve.point(piece, share).unwrap();
                assert!((found - sum.truncate() / sum.z).length() < 1e-14);
            }
        }
    }
}

#[test]
fn the_bound_on_the_area_holds_and_is_exact_for_rectangles() {
    let mut random = Random(17);
    let mut loops = vec![closed(circle(CENTER, 0.3)), closed(circle(CENTER, 0.3).reversed())];
    // Most of them cross themselves.
    loops.extend((3..60).map(|count| polygon(&(0..count).map(|_| random.point()).collect::<Vec<_>>())));
    for trim_loop in &loops {
        let (area, bound) = (trim_loop.approximate_area(), trim_loop.area_bound());
        assert!(area.abs() <= bound * (1.0 + 1e-9), "{area} of at most {bound}");
    }
    let rectangle = closed(TrimCurve::try_rectangle(at(0.1, 0.2), at(0.7, 0.5)).unwrap());
    assert!((rectangle.area_bound() - 0.18).abs() < 1e-15, "{}", rectangle.area_bound());
}

#[test]
fn gaps_are_closed_within_the_tolerance_and_named_beyond_it() {
    let line = |a, b| TrimCurve::try_line(a, b).unwrap();
    let (p, q, r) = (at(0.1, 0.1), at(0.9, 0.1), at(0.5, 0.9));
    let curves = || vec![line(p, q), line(q + at(0.0, 1e-4), r), line(r, p)];
    match TrimLoop::try_new(curves(), 1e-5) {
        Err(SurfaceError::OpenLoop { curve: 0, next: 1, end, gap, .. }) => {
            assert!(end == q && (gap - 1e-4).abs() < 1e-15);
        }
        other => panic!("{other:?}"),
    }
    let trimmed = region(vec![TrimLoop::try_new(curves(), 1e-3).unwrap()]);
    assert!(
        trimmed.contains(q + at(0.0, 0.5e-4))
            && trimmed.contains(CENTER)
            && !trimmed.contains(q + at(0.0, 1e-4))
    );
}

#[test]
fn invalid_curves_are_refused() {
    let nan = at(f64::NAN, 0.0);
    assert!(matches!(TrimCurve::try_line(UNIT[0], nan), Err(SurfaceError::NotFinite { .. })));
    assert!(matches!(TrimCurve::try_polygon(&UNIT), Err(SurfaceError::TooFew { count: 2, .. })));
    assert!(matches!(TrimCurve::try_circle(CENTER, 0.0), Err(SurfaceError::NotPositive { .. })));
    assert!(matches!(
        TrimCurve::try_ellipse(CENTER, UNIT[1], UNIT[1]),
        Err(SurfaceError::NotPositive { .. })
    ));
    assert!(matches!(TrimCurve::try_rectangle(UNIT[1], UNIT[0]), Err(SurfaceError::EmptyRange { .. })));
    assert!(matches!(TrimCurve::try_bezier(&[DVec3::ONE]), Err(SurfaceError::OutOfRange { value: 0.0, .. })));
    let points = [DVec3::ONE, DVec3::new(0.0, 0.0, 1.0), DVec3::ONE];
    let weightless = [DVec3::ONE, DVec3::ZERO];
    assert!(matches!(TrimCurve::try_bezier(&weightless), Err(SurfaceError::NotPositive { .. })));
    let nurbs = |degree, knots: &[f64]| TrimCurve::try_nurbs(degree, knots, &points).unwrap_err();
    assert!(matches!(nurbs(1, &[0.0; 4]), SurfaceError::CountMismatch { count: 4, expected: 5, .. }));
    assert!(matches!(nurbs(1, &[0.0; 5]), SurfaceError::EmptyRange { .. }));
    assert!(matches!(nurbs(3, &[0.0; 7]), SurfaceError::TooFew { .. }));
    assert!(matches!(nurbs(1, &[0.0, 0.0, 2.0, 1.0, 1.0]), SurfaceError::KnotsDecrease { position: 3, .. }));
    assert!(matches!(nurbs(1, &[0.0, 0.0, f64::INFINITY, 1.0, 1.0]), SurfaceError::NotFinite { .. }));
    let four = [points[0], points[1], points[2], points[0]];
    let apart = TrimCurve::try_nurbs(1, &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0], &four);
    assert!(matches!(apart, Err(SurfaceError::KnotMultiplicity { multiplicity: 2, max: 1, .. })));
    assert!(matches!(TrimLoop::try_new(Vec::new(), 0.0), Err(SurfaceError::TooFew { .. })));
    let point = TrimCurve::try_line(CENTER, CENTER).unwrap();
    assert!(matches!(TrimLoop::try_closed(point, 0.0), Err(SurfaceError::CollapsedLoop { .. })));
    assert!(matches!(TrimRegion::try_new(Vec::new(), [UNIT[0], nan]), Err(SurfaceError::NotFinite { .. })));
    assert!(matches!(
        TrimRegion::try_new(Vec::new(), [UNIT[0], UNIT[0]]),
        Err(SurfaceError::EmptyRange { .. })
    ));
    assert!(matches!(region(Vec::new()).with_widened_border(-1.0), Err(SurfaceError::Negative { .. })));
}

#[test]
fn a_curve_of_the_highest_degree_is_as_good_as_a_line() {
    // The lower border of the square as a polynomial of degree 25 in the same parameter.
    let lower: Vec<DVec3> =
        (0..=MAX_DEGREE).map(|i| at(i as f64 / MAX_DEGREE as f64, 0.0).extend(1.0)).collect();
    let rest = TrimCurve::try_polyline(&[at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0), at(0.0, 0.0)]).unwrap();
    let border = TrimLoop::try_new(vec![TrimCurve::try_bezier(&lower).unwrap(), rest], 0.0).unwrap();
    let square = TrimRegion::try_new(vec![border], [at(-1.0, -1.0), at(2.0, 2.0)]).unwrap();
    for u in [0.001, 0.3, 0.999] {
        assert!(square.contains(at(u, 1e-9)) && !square.contains(at(u, -1e-9)));
    }
    let higher = vec![DVec3::ONE; MAX_DEGREE + 2];
    assert!(matches!(
        TrimCurve::try_bezier(&higher),
        Err(SurfaceError::OutOfRange { value: 26.0, max: 25.0, .. })
    ));
}

#[test]
fn region_from_curves_takes_its_tolerances_from_their_extent() {
    // Quarters of a circle that miss each other by 1e-4, less than 1e-6 of the extent of 600.
    let (center, radius) = (at(100.0, -50.0), 300.0);
    let quarter = |a: DVec2, b: DVec2| {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let corner = center + radius * (a + b);
        TrimCurve::try_bezier(&[
            (center + radius * a).extend(1.0),
            (corner * w).extend(w),
            (center + radius * b + at(1e-4, 0.0)).extend(1.0),
        ])
        .unwrap()
    };
    let axes = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y, DVec2::X];
    let disk: Vec<TrimCurve> = axes.windows(2).map(|pair| quarter(pair[0], pair[1])).collect();
    let region = TrimRegion::try_from_curves(vec![disk]).unwrap();
    assert_eq!(region.domain().map(|p| p.x.round()), [-260.0, 460.0]);
    assert!((region.max_width() - 600e-9).abs() < 1e-12);
    assert!(region.contains(center) && !region.contains(center + radius));
    assert!(!region.contains(at(1e6, 0.0)));
    assert!(matches!(TrimRegion::try_from_curves(vec![Vec::new()]), Err(SurfaceError::TooFew { .. })));
    let apart = vec![TrimCurve::try_line(UNIT[0], UNIT[1]).unwrap()];
    assert!(matches!(TrimRegion::try_from_curves(vec![apart]), Err(SurfaceError::OpenLoop { .. })));
}
