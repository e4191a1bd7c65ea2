//! Widths of curves, scales and domains.

use super::*;

/// A rectangle from `min` to `max`, counter-clockwise, of four lines with these widths: lower, right, upper and left side.
fn rectangle(min: DVec2, max: DVec2, widths: [Option<f64>; 4]) -> Vec<TrimCurve> {
    let corners = [min, at(max.x, min.y), max, at(min.x, max.y), min];
    let side = |(ends, width): (&[DVec2], Option<f64>)| {
        let line = TrimCurve::try_line(ends[0], ends[1]).unwrap();
        width.map_or(line.clone(), |width| line.with_width(width).unwrap())
    };
    corners.windows(2).zip(widths).map(side).collect()
}

/// The sides, by their number, in whose borders a point lies, by its distance from the segments.
fn borders(p: DVec2, min: DVec2, max: DVec2, widths: [f64; 4]) -> Vec<usize> {
    let corners = [min, at(max.x, min.y), max, at(min.x, max.y), min];
    (0..4).filter(|side| distance(p, corners[*side], corners[side + 1]) <= widths[*side]).collect()
}

/// The location of a point by its distances from the sides.
fn expected(p: DVec2, min: DVec2, max: DVec2, widths: [f64; 4]) -> RegionLocation {
    let in_border = !borders(p, min, max, widths).is_empty();
    let inside = p.cmpgt(min).all() && p.cmplt(max).all();
    match (inside, in_border) {
        (true, true) => RegionLocation::InnerBorder,
        (true, false) => RegionLocation::Inside,
        (false, true) => RegionLocation::OuterBorder,
        (false, false) => RegionLocation::Outside,
    }
}

#[test]
fn every_side_of_a_rectangle_has_a_border_of_its_own_width() {
    let (min, max) = (at(0.25, 0.3), at(0.7, 0.8));
    let mut random = Random(30);
    for widths in [[0.1, 1e-3, 0.02, 1e-6], [0.0, 0.3, 0.0, 0.0], [1e-5, 1e-5, 1e-5, 0.05]] {
        let region = TrimRegion::try_from_curves(vec![rectangle(min, max, widths.map(Some))]).unwrap();
        let mut seen = [0; 4];
        for i in 0..40_000 {
            let width = widths[i % 4];
            let on_side = [at(random.unit(), min.y), at(max.x, random.unit())][i % 2];
            let p = if i % 3 == 0 {
                random.point()
            } else {
                on_side + 3.0 * width.max(1e-6) * (random.point() - 0.5)
            };
            let p = p.clamp(at(0.21, 0.26), at(0.74, 0.84));
            let found = region.locate(p);
            seen[found as usize] += 1;
            assert_eq!(found, expected(p, min, max, widths), "{p}");
            assert_eq!(region.contains(p), found != RegionLocation::Outside);
            // Across the sides along x, a unit of y is half a metre; across the others, one of x is three.
            let [across_x, across_y] = [0.5, 3.0];
            let lengths = [across_x, across_y, across_x, across_y];
            let in_space: [f64; 4] = std::array::from_fn(|side| widths[side] * lengths[side]);
            let widest =
                borders(p, min, max, widths).into_iter().map(|side| in_space[side]).fold(0.0, f64::max);
            assert_eq!(region.border_width(p, [DVec3::X * 3.0, DVec3::Y * 0.5]), widest, "{p}");
        }
        assert!(seen.iter().all(|&n| n > 300), "{seen:?}");
    }
}

#[test]
fn rectangles_without_crossing_have_no_border() {
    let (min, max, widths) = (at(0.25, 0.3), at(0.7, 0.8), [0.1, 1e-3, 0.02, 1e-6]);
    let region = TrimRegion::try_from_curves(vec![rectangle(min, max, widths.map(Some))]).unwrap();
    let (mut random, mut seen) = (Random(31), [0; 3]);
    for i in 0..20_000 {
        let size = random.point() * 0.5_f64.powi(i % 10);
        let low = random.point();
        let cell = region.classify(low, low + size);
        seen[cell as usize] += 1;
        for _ in 0..10 {
            let [start, end] = region.domain();
            let found = region.locate((low + random.point() * size).clamp(start, end));
            match cell {
                Containment::Inside => assert_eq!(found, RegionLocation::Inside),
                Containment::Outside => assert_eq!(found, RegionLocation::Outside),
                Containment::Crossed => {}
            }
        }
    }
    assert!(seen.iter().all(|&n| n > 200), "{seen:?}");
}

#[test]
fn scaled_regions_measure_widths_in_their_own_coordinates() {
    // A cylinder of radius 50 and height 0.2, unrolled: u is 314 m, v is 0.2 m.
    let scale = at(TAU * 50.0, 0.2);
    let (min, max) = (at(0.1, 0.2), at(0.7, 0.9));
    let widths = [1e-3, 2e-3, 5e-3, 1e-4];
    let loops = || vec![rectangle(min, max, widths.map(Some))];
    let settings = RegionSettings { scale, domain: Some([at(0.0, 0.0), at(1.0, 1.0)]) };
    let region = TrimRegion::try_with_settings(loops(), settings).unwrap();
    assert_eq!(region.scale(), scale);
    let [low, high] = region.domain();
    assert!(low == DVec2::ZERO && high.distance(DVec2::ONE) < 1e-15);
    let mut random = Random(32);
    let mut borders = 0;
    for i in 0..40_000 {
        let near = [at(0.1, random.unit()), at(random.unit(), 0.9)][i % 2];
        let p = near + 2.0 * (random.point() - 0.5) * 6e-3 / scale;
        let p = p.clamp(DVec2::ZERO, DVec2::ONE);
        let found = region.locate(p);
        assert_eq!(found, expected(p * scale, min * scale, max * scale, widths), "{p}");
        borders += usize::from(found.border().is_some_and(|border| border != crate::HitBorder::Away));
    }
    assert!(borders > 4_000, "{borders}");
    for (piece, corner) in region.monotone_pieces().zip([min, at(max.x, min.y), max, at(min.x, max.y)]) {
        assert!(piece.start.distance(corner) < 1e-15 && piece.control_points.len() == 2);
    }
    let wrong = RegionSettings { scale: at(1.0, 0.0), domain: None };
    let refused =
        [TrimRegion::check(loops(), wrong), TrimRegion::try_with_settings(loops(), wrong).map(drop)];
    assert!(refused.iter().all(|r| matches!(r, Err(crate::SurfaceError::NotPositive { .. }))), "{refused:?}");
    assert!(TrimRegion::check(loops(), settings).is_ok());
    let empty = RegionSettings { domain: Some([max, min]), ..settings };
    assert!(matches!(TrimRegion::check(loops(), empty), Err(crate::SurfaceError::EmptyRange { .. })));
    let line = TrimCurve::try_line(min, max).unwrap();
    assert!(matches!(line.with_width(-1.0), Err(crate::SurfaceError::Negative { .. })));
}

#[test]
fn copies_of_loops_far_outside_the_domain_add_no_cells() {
    let mut random = Random(33);
    let blob = blob(&mut random, CENTER, 0.4, 0.5);
    let moved = |x: f64, y: f64| {
        let by = |p: &DVec3| (p.truncate() + at(x, y) * p.z).extend(p.z);
        let pieces = blob
            .pieces
            .iter()
            .map(|piece| TrimCurve::try_bezier(&piece.iter().map(by).collect::<Vec<_>>()).unwrap());
        pieces.collect::<Vec<_>>()
    };
    let settings = RegionSettings { domain: Some(UNIT), ..RegionSettings::default() };
    let copies = (0..9).map(|i| moved(f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0)).collect();
    let copies = TrimRegion::try_with_settings(copies, settings).unwrap();
    let alone = TrimRegion::try_with_settings(vec![moved(0.0, 0.0)], settings).unwrap();
    let (many, few) = (copies.statistics(), alone.statistics());
    assert_eq!(many.pieces, 9 * few.pieces);
    assert_eq!((many.cells, many.entries), (few.cells, few.entries));
    // A band around the period, three periods long.
    let wave = |y: f64| {
        let points = (0..=30).map(|i| at(f64::from(i) / 10.0 - 1.0, y + 0.05 * f64::from(i % 2)).extend(1.0));
        let knots: Vec<f64> = (0..35).map(f64::from).collect();
        let knots: Vec<f64> = knots.iter().map(|k| k.clamp(3.0, 31.0)).collect();
        TrimCurve::try_nurbs(3, &knots, &points.collect::<Vec<_>>()).unwrap()
    };
    let (low, high) = (wave(0.3), wave(0.6).reversed());
    let line = |a: DVec2, b: DVec2| TrimCurve::try_line(a, b).unwrap();
    let band = vec![low.clone(), line(low.end(), high.start()), high.clone(), line(high.end(), low.start())];
    let band = TrimRegion::try_with_settings(vec![band], settings).unwrap();
    assert!(band.contains(at(0.0, 0.5)) && band.contains(at(1.0, 0.5)) && !band.contains(at(0.5, 0.8)));
    // In cells of the middle period, few pieces each.
    let sizes = band.statistics();
    assert!(sizes.crossed_cells > 30 && sizes.entries < 3 * sizes.crossed_cells, "{sizes:?}");
}

#[test]
fn curves_may_miss_each_other_by_their_widths_and_are_widened_by_what_is_moved() {
    let mut curves = rectangle(at(0.2, 0.2), at(0.8, 0.8), [Some(1e-3); 4]);
    curves[1] = TrimCurve::try_line(at(0.8015, 0.2), at(0.8, 0.8)).unwrap().with_width(1e-3).unwrap();
    let region = TrimRegion::try_from_curves(vec![curves.clone()]).unwrap();
    let widths: Vec<f64> = region.monotone_pieces().map(|piece| piece.width).collect();
    assert!(
        widths.iter().zip([1.75e-3, 1.75e-3, 1e-3, 1e-3]).all(|(a, b)| (a - b).abs() < 1e-12),
        "{widths:?}"
    );
    // The original ends are within the borders.
    assert!(region.contains(at(0.8015, 0.2)) && region.contains(at(0.8, 0.2)));
    curves[1] = TrimCurve::try_line(at(0.803, 0.2), at(0.8, 0.8)).unwrap().with_width(1e-3).unwrap();
    let apart = TrimRegion::try_from_curves(vec![curves]);
    assert!(matches!(apart, Err(crate::SurfaceError::OpenLoop { .. })));
}

#[test]
fn thousands_of_pieces_in_one_wide_border_stay_cheap() {
    // A circle of 2000 chords, each shorter than the width.
    let corners: Vec<DVec2> =
        (0..2000).map(|i| CENTER + 0.4 * DVec2::from_angle(TAU * f64::from(i) / 2000.0)).collect();
    let curve = TrimCurve::try_polygon(&corners).unwrap().with_width(0.02).unwrap();
    let region = TrimRegion::try_from_curves(vec![vec![curve]]).unwrap();
    let sizes = region.statistics();
    assert!(sizes.entries < 40 * sizes.pieces, "{sizes:?}");
    let mut random = Random(34);
    for _ in 0..20_000 {
        let p = random.point();
        let d = p.distance(CENTER) - 0.4;
        let expected = match (d < 0.0, d.abs() < 0.02) {
            (true, true) => RegionLocation::InnerBorder,
            (true, false) => RegionLocation::Inside,
            (false, true) => RegionLocation::OuterBorder,
            (false, false) => RegionLocation::Outside,
        };
        // Chords are within 5e-7 of the circle.
        if d.abs() > 1e-6 && (d.abs() - 0.02).abs() > 1e-6 {
            assert_eq!(region.locate(p), expected, "{p}");
        }
    }
}
