//! Classification of rectangles, and the size of the hierarchy.

use super::*;

#[test]
fn classification_of_rectangles_agrees_with_their_points() {
    let mut random = Random(8);
    let curves = [blob(&mut random, CENTER, 0.45, 0.8), blob(&mut random, CENTER, 0.2, 0.5).reversed()];
    let loops = curves.iter().map(|c| TrimLoop::try_closed(c.clone(), 1e-12).unwrap()).collect();
    let reference = DensePolygons::new(&curves, 100);
    for border in [0.0, 0.01] {
        let trimmed = region(Vec::clone(&loops)).with_widened_border(border).unwrap();
        let mut seen = [0; 3];
        for i in 0..20_000 {
            let size = random.point() * 0.5_f64.powi(i % 12);
            let min = random.point() - 0.5 * size;
            let max = min + size;
            let cell = trimmed.classify(min, max);
            seen[cell as usize] += 1;
            if cell != Containment::Crossed {
                for _ in 0..20 {
                    let p = (min + random.point() * size).clamp(UNIT[0], UNIT[1]);
                    assert_eq!(trimmed.contains(p), cell == Containment::Inside, "{min} {max} {p}");
                }
            } else if i < 4_000 {
                // Crossed rectangles are close to a curve.
                let middle = 0.5 * (min + max);
                let near = reference.distance(middle) <= 0.5 * size.length() + 2.0 * border + reference.sag;
                let leaves_domain = middle.clamp(UNIT[0], UNIT[1]) != middle;
                assert!(near || leaves_domain, "{min} {max}");
            }
        }
        assert!(seen.iter().all(|&n| n > 1_000), "{seen:?}");
    }
    let nothing = region(loops);
    assert_eq!(nothing.classify(at(f64::NAN, 0.0), at(1.0, 1.0)), Containment::Crossed);
    assert_eq!(nothing.classify(at(0.6, 0.0), at(0.4, 1.0)), Containment::Crossed);
}

#[test]
fn widened_border_reaches_as_far_as_its_tolerance() {
    let mut random = Random(9);
    for tolerance in [1e-6, 1e-3, 0.05] {
        let disk = region(vec![closed(circle(CENTER, 0.3))]).with_widened_border(tolerance).unwrap();
        let hole =
            region(vec![closed(circle(CENTER, 0.3).reversed())]).with_widened_border(tolerance).unwrap();
        for _ in 0..20_000 {
            let p = random.point();
            let d = p.distance(CENTER);
            assert_eq!(disk.contains(p), d < 0.3 + tolerance);
            assert_eq!(hole.contains(p), d > 0.3 - tolerance);
            let angle = TAU * random.unit();
            let along = at(angle.cos(), angle.sin());
            let by = |x: f64| CENTER + along * (0.3 + x);
            assert!(disk.contains(by(tolerance - 1e-10)) && !disk.contains(by(tolerance + 1e-10)));
            assert!(hole.contains(by(-tolerance + 1e-10)) && !hole.contains(by(-tolerance - 1e-10)));
        }
    }
    // Round corners, and a curve without a formula for its distance.
    let square = TrimCurve::try_rectangle(at(0.4, 0.4), at(0.6, 0.6)).unwrap();
    let square = region(vec![closed(square)]).with_widened_border(0.1).unwrap();
    assert!(square.contains(at(0.67, 0.67)) && !square.contains(at(0.68, 0.68)));
    let curves = [blob(&mut random, CENTER, 0.4, 1.0)];
    let reference = DensePolygons::new(&curves, 200);
    let wide = TrimRegion::try_new(vec![TrimLoop::try_closed(curves[0].clone(), 1e-12).unwrap()], UNIT);
    let wide = wide.unwrap().with_widened_border(0.03).unwrap();
    for _ in 0..10_000 {
        let p = random.point();
        let (d, winding) = (reference.distance(p), reference.winding(p));
        if (d - 0.03).abs() > reference.sag {
            assert_eq!(wide.contains(p), d < 0.03 || winding.is_some_and(|w| w > 0), "{p}");
        }
    }
}

#[test]
fn thousands_of_holes_stay_small_and_exact() {
    let n = 64;
    let cell = 1.0 / f64::from(n);
    let center = |x: u32, y: u32| at(f64::from(x) + 0.5, f64::from(y) + 0.5) * cell;
    let holes = (0..n * n).map(|i| closed(circle(center(i % n, i / n), 0.4 * cell).reversed()));
    let plate = region(holes.collect());
    let sizes = plate.statistics();
    assert_eq!(sizes.pieces, 4 * 64 * 64);
    assert!(sizes.entries < 100 * sizes.pieces && sizes.cells < 200 * sizes.pieces, "{sizes:?}");
    let mut random = Random(10);
    for _ in 0..100_000 {
        let p = random.point();
        let (x, y) = ((p.x / cell) as u32, (p.y / cell) as u32);
        assert_eq!(plate.contains(p), p.distance(center(x, y)) > 0.4 * cell);
    }
}

#[test]
fn repeated_loops_do_not_enlarge_the_hierarchy_out_of_proportion() {
    let pile = region((0..500).map(|_| closed(circle(CENTER, 0.4))).collect());
    let star = region(
        (0..300)
            .map(|i| TAU * f64::from(i) / 300.0)
            .map(|a| {
                polygon(&[
                    CENTER,
                    CENTER + 0.4 * at(a.cos(), a.sin()),
                    CENTER + 0.4 * at((a + 0.01).cos(), (a + 0.01).sin()),
                ])
            })
            .collect(),
    );
    for trimmed in [&pile, &star] {
        let sizes = trimmed.statistics();
        assert!(sizes.entries < 200 * sizes.pieces + 2_000 && sizes.cells < 100_000, "{sizes:?}");
    }
    assert!(pile.contains(CENTER) && pile.contains(at(0.9, 0.5)) && !pile.contains(at(0.9, 0.6)));
    let angle = TAU * 7.0 / 300.0;
    let spoke = |a: f64| CENTER + 0.2 * at(a.cos(), a.sin());
    assert!(
        star.contains(CENTER) && star.contains(spoke(angle + 0.005)) && !star.contains(spoke(angle + 0.015))
    );
}

#[test]
fn without_loops_the_domain_is_kept_and_nan_is_not() {
    let all = region(Vec::new());
    assert!(all.contains(CENTER) && all.contains(UNIT[0]) && all.contains(UNIT[1]));
    assert_eq!(all.classify(UNIT[0], UNIT[1]), Containment::Inside);
    assert!(!all.contains(at(f64::NAN, 0.5)) && !all.contains(at(0.5, f64::NAN)));
    // Loops around all of the domain, and beside it.
    let around = region(vec![closed(circle(CENTER, 10.0))]);
    let beside = region(vec![closed(circle(at(5.0, 5.0), 1.0))]);
    assert!(around.contains(at(0.1, 0.9)) && !beside.contains(at(0.1, 0.9)));
    assert_eq!(around.classify(UNIT[0], UNIT[1]), Containment::Inside);
}
