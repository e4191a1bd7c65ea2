//! Nested loops, and random loops against dense polygons.

use super::*;

fn compare(
    region: &TrimRegion,
    reference: &DensePolygons,
    outermost: i32,
    random: &mut Random,
    count: usize,
) {
    let mut undecided = 0;
    for _ in 0..count {
        let p = random.point();
        match reference.winding(p) {
            Some(winding) => assert_eq!(region.contains(p), winding + outermost > 0, "{p}"),
            None => undecided += 1,
        }
    }
    assert!(undecided * 20 < count, "{undecided}");
}

#[test]
fn nested_loops_follow_their_orientation() {
    // Plate, hole, island, hole in the island; and a hole in the domain, with an island that has a hole with an island.
    let radii = [0.45, 0.35, 0.25, 0.15];
    let mut random = Random(4);
    for first_is_hole in [false, true] {
        let loops = radii.iter().enumerate().map(|(i, &r)| {
            let is_hole = (i % 2 == 1) != first_is_hole;
            closed(if is_hole { circle(CENTER, r).reversed() } else { circle(CENTER, r) })
        });
        let trimmed = region(loops.collect());
        for _ in 0..100_000 {
            let p = random.point();
            let around = radii.iter().filter(|&&r| p.distance(CENTER) < r).count();
            assert_eq!(trimmed.contains(p), (around % 2 == 1) != first_is_hole, "{p}");
        }
    }
}

#[test]
fn random_nurbs_loops_agree_with_dense_polygons() {
    let mut random = Random(5);
    for round in 0..12 {
        let wild = f64::from(round % 4) / 3.0;
        let mut curves = vec![blob(&mut random, CENTER, 0.48, wild)];
        for _ in 0..round % 5 {
            let center = at(0.3, 0.3) + 0.4 * random.point();
            let size = 0.05 + 0.2 * random.unit();
            let curve = blob(&mut random, center, size, wild);
            curves.push(if random.unit() < 0.7 { curve.reversed() } else { curve });
        }
        let reference = DensePolygons::new(&curves, 100);
        let loops: Vec<TrimLoop> =
            curves.iter().map(|c| TrimLoop::try_closed(c.clone(), 1e-12).unwrap()).collect();
        let trimmed = region(loops.clone());
        let largest = loops.iter().map(TrimLoop::approximate_area).max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let outermost = i32::from(largest.unwrap() < 0.0);
        compare(&trimmed, &reference, outermost, &mut random, 10_000);
        for _ in 0..5_000 {
            let curve = &curves[random.bits() as usize % curves.len()];
            let p = curve.point(random.bits() as usize % curve.piece_count(), random.unit()).unwrap();
            assert!(trimmed.contains(p), "on the curve: {p}");
        }
    }
}

#[test]
fn one_loop_of_lines_arcs_and_splines_agrees_with_a_dense_polygon() {
    let mut random = Random(6);
    let (p, q, r) = (at(0.1, 0.1), at(0.9, 0.2), at(0.7, 0.9));
    let spline: Vec<DVec3> = [r, at(0.5, 0.6), at(0.5, 1.2), at(0.1, 0.9), at(0.4, 0.5), p]
        .iter()
        .zip([1.0, 1000.0, 0.001, 1.0, 30.0, 1.0])
        .map(|(p, w)| (*p * w).extend(w))
        .collect();
    let knots = [0.0, 0.0, 0.0, 0.0, 0.3, 0.3, 1.0, 1.0, 1.0, 1.0];
    let arc = [q.extend(1.0), (at(1.1, 0.7) * 0.4).extend(0.4), r.extend(1.0)];
    let curves = vec![
        TrimCurve::try_line(p, q).unwrap(),
        TrimCurve::try_bezier(&arc).unwrap(),
        TrimCurve::try_nurbs(3, &knots, &spline).unwrap(),
    ];
    let reference = DensePolygons::new(&curves, 3_000);
    let trimmed = region(vec![TrimLoop::try_new(curves, 0.0).unwrap()]);
    compare(&trimmed, &reference, 0, &mut random, 20_000);
}
