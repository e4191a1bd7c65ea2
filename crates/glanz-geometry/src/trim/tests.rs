//! Regions against closed forms and against winding numbers of dense polygons.

use std::f64::consts::TAU;

use glanz_math::{DVec2, DVec3};

use super::*;

/// SplitMix64: test cases, not statistics.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn point(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit())
    }
}

const UNIT: [DVec2; 2] = [DVec2::ZERO, DVec2::ONE];
const CENTER: DVec2 = DVec2::splat(0.5);

fn at(u: f64, v: f64) -> DVec2 {
    DVec2::new(u, v)
}

fn closed(curve: TrimCurve) -> TrimLoop {
    TrimLoop::try_closed(curve, 0.0).unwrap()
}

fn circle(center: DVec2, radius: f64) -> TrimCurve {
    TrimCurve::try_circle(center, radius).unwrap()
}

fn polygon(corners: &[DVec2]) -> TrimLoop {
    closed(TrimCurve::try_polygon(corners).unwrap())
}

fn region(loops: Vec<TrimLoop>) -> TrimRegion {
    TrimRegion::try_new(loops, UNIT).unwrap()
}

/// The slow twin: the winding number of dense polygons, and the distance from them.
struct Polygons {
    edges: Vec<(DVec2, DVec2)>,
    /// The polygons are this near to the curves.
    sag: f64,
}

impl Polygons {
    /// `curves`: closed ones. A chord is cut where the curve's middle is furthest from it, for short chords; ten times
    /// that is room enough for the others.
    fn new(curves: &[TrimCurve], steps: u32) -> Self {
        let (mut edges, mut sag) = (Vec::new(), 0.0_f64);
        for curve in curves {
            for piece in 0..curve.piece_count() {
                let point = |i: f64| curve.point(piece, i / f64::from(steps)).unwrap();
                for i in (0..steps).map(f64::from) {
                    let (a, b) = (point(i), point(i + 1.0));
                    sag = sag.max(distance(point(i + 0.5), a, b));
                    edges.push((a, b));
                }
            }
        }
        Self { edges, sag: 10.0 * sag + 1e-12 }
    }

    /// `None` too near to say.
    fn winding(&self, p: DVec2) -> Option<i32> {
        let mut winding = 0;
        for &(a, b) in &self.edges {
            let reach = self.sag + (b - a).abs().max_element();
            if (a - p).abs().max_element() <= reach && distance(p, a, b) <= self.sag {
                return None;
            }
            if (a.y > p.y) != (b.y > p.y) {
                let right = (b - a).perp_dot(p - a) > 0.0;
                winding +=
                    if b.y > a.y { i32::from(right) } else { -i32::from((a - b).perp_dot(p - b) > 0.0) };
            }
        }
        Some(winding)
    }

    fn distance(&self, p: DVec2) -> f64 {
        self.edges.iter().fold(f64::INFINITY, |d, &(a, b)| d.min(distance(p, a, b)))
    }
}

fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let length2 = (b - a).length_squared();
    let share = if length2 > 0.0 { ((p - a).dot(b - a) / length2).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a.lerp(b, share))
}

/// A wild closed NURBS curve, periodic with unclamped uneven knots.
fn blob(random: &mut Random, center: DVec2, size: f64, wild: f64) -> TrimCurve {
    let (degree, count) = (2 + (random.bits() % 4) as usize, 8);
    let ring: Vec<DVec3> = (0..count)
        .map(|i| {
            let angle = TAU * (i as f64 + wild * (random.unit() - 0.5)) / count as f64;
            let radius = size * (1.0 - 0.9 * wild * random.unit());
            let w = 10.0_f64.powf(wild * (random.unit() - 0.5));
            ((center + radius * at(angle.cos(), angle.sin())) * w).extend(w)
        })
        .collect();
    let steps: Vec<f64> = (0..count).map(|_| 0.5 + random.unit()).collect();
    let mut knots = vec![0.0];
    for i in 0..count + 2 * degree {
        knots.push(knots[i] + steps[i % count]);
    }
    let points: Vec<DVec3> = (0..count + degree).map(|i| ring[i % count]).collect();
    TrimCurve::try_nurbs(degree, &knots, &points).unwrap()
}

fn compare(region: &TrimRegion, twin: &Polygons, outermost: i32, random: &mut Random, count: usize) {
    let mut undecided = 0;
    for _ in 0..count {
        let p = random.point();
        match twin.winding(p) {
            Some(winding) => assert_eq!(region.contains(p), winding + outermost > 0, "{p}"),
            None => undecided += 1,
        }
    }
    assert!(undecided * 20 < count, "{undecided}");
}

#[test]
fn circle_and_ellipse_are_exact_to_a_billionth_next_to_the_curve() {
    let mut random = Random(1);
    let (a, b) = (at(0.35, 0.1), at(-0.05, 0.2));
    let disk = region(vec![closed(TrimCurve::try_ellipse(CENTER, a, b).unwrap())]);
    let hole = region(vec![closed(TrimCurve::try_ellipse(CENTER, b, a).unwrap())]);
    let area = a.perp_dot(b);
    let radius = |p: DVec2| at((p - CENTER).perp_dot(b), a.perp_dot(p - CENTER)).length() / area;
    for _ in 0..100_000 {
        let p = random.point();
        assert_eq!(disk.contains(p), radius(p) < 1.0);
        assert_eq!(hole.contains(p), radius(p) > 1.0);
        let angle = TAU * random.unit();
        let on = CENTER + a * angle.cos() + b * angle.sin();
        assert!(disk.contains(on) && hole.contains(on));
        for step in [1e-3, 1e-6, 1e-9, 1e-11] {
            let (inner, outer) = (on.lerp(CENTER, step), on.lerp(CENTER, -step));
            assert!(disk.contains(inner) && !disk.contains(outer), "{angle} {step}");
            assert!(!hole.contains(inner) && hole.contains(outer), "{angle} {step}");
        }
    }
}

#[test]
fn points_level_with_the_ends_of_pieces_are_told_apart() {
    // The pieces of a circle end at its leftmost, lowest, rightmost and highest points.
    let radius = 0.25;
    for (disk, inside) in [(circle(CENTER, radius), true), (circle(CENTER, radius).reversed(), false)] {
        let disk = region(vec![closed(disk)]);
        for i in 0..=4_000 {
            let x = f64::from(i) / 4_000.0;
            for level in [0.25, 0.5, 0.75] {
                for p in [at(x, level), at(level, x)] {
                    let d = p.distance(CENTER);
                    let expected = d == radius || (d < radius) == inside;
                    assert_eq!(disk.contains(p), expected, "{p}");
                }
            }
        }
    }
}

#[test]
fn lattice_points_of_polygons_with_lattice_corners_are_exact() {
    // Everything is a multiple of 1/32: levels, corners, edges that run over points, all in exact arithmetic.
    let mut random = Random(2);
    let mut on_border = 0;
    for _ in 0..100 {
        let count = 3 + random.bits() as usize % 12;
        let corners: Vec<DVec2> =
            (0..count).map(|_| at((random.bits() % 33) as f64, (random.bits() % 33) as f64) / 32.0).collect();
        let area = (0..count).map(|i| corners[i].perp_dot(corners[(i + 1) % count])).sum::<f64>();
        if area == 0.0 {
            continue;
        }
        let outermost = i32::from(area < 0.0);
        let trimmed = region(vec![polygon(&corners)]);
        for (x, y) in (0..=64).flat_map(|x| (0..=64).map(move |y| (x, y))) {
            let p = at(f64::from(x), f64::from(y)) / 64.0;
            let (mut winding, mut on) = (outermost, false);
            for i in 0..count {
                let (a, b) = (corners[i], corners[(i + 1) % count]);
                let cross = (b - a).perp_dot(p - a);
                on |= cross == 0.0 && (p - a).dot(p - b) <= 0.0;
                if (a.y > p.y) != (b.y > p.y) && (cross > 0.0) == (b.y > a.y) {
                    winding += if b.y > a.y { 1 } else { -1 };
                }
            }
            on_border += usize::from(on);
            assert_eq!(trimmed.contains(p), on || winding > 0, "{corners:?} {p}");
        }
    }
    assert!(on_border > 4_000, "{on_border}");
}

#[test]
fn cusp_is_exact_at_its_tip_and_level_with_it() {
    // (t^2, t^3) for t from 1 to -1, moved, and a straight line back: |v| < u^(3/2), u < 1.
    let tip = at(0.1, 0.5);
    let control = [(1.0, 0.4), (-1.0 / 3.0, -0.4), (-1.0 / 3.0, 0.4), (1.0, -0.4)];
    let control = control.map(|(u, v)| (tip + at(0.8 * u, v)).extend(1.0));
    let cusp = TrimCurve::try_bezier(&control).unwrap();
    let back = TrimCurve::try_line(cusp.end(), cusp.start()).unwrap();
    let trimmed = region(vec![TrimLoop::try_new(vec![cusp, back], 0.0).unwrap()]);
    assert!(trimmed.contains(tip));
    let expected = |p: DVec2| {
        let q = (p - tip) / at(0.8, 0.4);
        q.x > 0.0 && q.x < 1.0 && q.y.abs() < q.x.powf(1.5)
    };
    let mut random = Random(3);
    for i in 0..100_000 {
        let p = random.point();
        assert_eq!(trimmed.contains(p), expected(p));
        let level = at(p.x, 0.5);
        assert_eq!(trimmed.contains(level), expected(level) || level == tip);
        let near = tip + 10.0_f64.powi(-(i % 9)) * (p - CENTER);
        assert_eq!(trimmed.contains(near), expected(near), "{near}");
    }
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
        let twin = Polygons::new(&curves, 100);
        let loops: Vec<TrimLoop> =
            curves.iter().map(|c| TrimLoop::try_closed(c.clone(), 1e-12).unwrap()).collect();
        let trimmed = region(loops.clone());
        let largest = loops.iter().map(TrimLoop::approximate_area).max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let outermost = i32::from(largest.unwrap() < 0.0);
        compare(&trimmed, &twin, outermost, &mut random, 10_000);
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
    let twin = Polygons::new(&curves, 3_000);
    let trimmed = region(vec![TrimLoop::try_new(curves, 0.0).unwrap()]);
    compare(&trimmed, &twin, 0, &mut random, 20_000);
}

#[test]
fn domains_far_from_the_origin_and_of_unequal_sides_are_exact_to_a_billionth() {
    let mut random = Random(7);
    for (min, size) in [(at(1000.0, -1000.0), at(1.0, 2.0)), (at(0.0, 0.0), at(1e4, 1e-4))] {
        let on_domain = |p: DVec2| min + p * size;
        let (a, b) = (at(0.3 * size.x, 0.0), at(0.0, 0.4 * size.y));
        let disk = closed(TrimCurve::try_ellipse(on_domain(CENTER), a, b).unwrap());
        let trimmed = TrimRegion::try_new(vec![disk], [min, min + size]).unwrap();
        for _ in 0..20_000 {
            let angle = TAU * random.unit();
            let on = at(0.3 * angle.cos(), 0.4 * angle.sin());
            for step in [0.5 * random.unit(), 1e-8] {
                assert!(trimmed.contains(on_domain(CENTER + on * (1.0 - step))));
                assert!(!trimmed.contains(on_domain(CENTER + on * (1.0 + step))));
            }
        }
    }
}

#[test]
fn classified_rectangles_are_what_their_points_are() {
    let mut random = Random(8);
    let curves = [blob(&mut random, CENTER, 0.45, 0.8), blob(&mut random, CENTER, 0.2, 0.5).reversed()];
    let loops = curves.iter().map(|c| TrimLoop::try_closed(c.clone(), 1e-12).unwrap()).collect();
    let twin = Polygons::new(&curves, 100);
    for border in [0.0, 0.01] {
        let trimmed = region(Vec::clone(&loops)).with_widened_border(border).unwrap();
        let mut seen = [0; 3];
        for i in 0..20_000 {
            let size = random.point() * 0.5_f64.powi(i % 12);
            let min = random.point() - 0.5 * size;
            let max = min + size;
            let cell = trimmed.classify(min, max);
            seen[cell as usize] += 1;
            if cell != Cell::Crossed {
                for _ in 0..20 {
                    let p = (min + random.point() * size).clamp(UNIT[0], UNIT[1]);
                    assert_eq!(trimmed.contains(p), cell == Cell::Inside, "{min} {max} {p}");
                }
            } else if i < 4_000 {
                // Crossed rectangles are not far from a curve.
                let middle = 0.5 * (min + max);
                let near = twin.distance(middle) <= 0.5 * size.length() + 2.0 * border + twin.sag;
                let leaves_domain = middle.clamp(UNIT[0], UNIT[1]) != middle;
                assert!(near || leaves_domain, "{min} {max}");
            }
        }
        assert!(seen.iter().all(|&n| n > 1_000), "{seen:?}");
    }
    let nothing = region(loops);
    assert_eq!(nothing.classify(at(f64::NAN, 0.0), at(1.0, 1.0)), Cell::Crossed);
    assert_eq!(nothing.classify(at(0.6, 0.0), at(0.4, 1.0)), Cell::Crossed);
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
    let twin = Polygons::new(&curves, 200);
    let wide = TrimRegion::try_new(vec![TrimLoop::try_closed(curves[0].clone(), 1e-12).unwrap()], UNIT);
    let wide = wide.unwrap().with_widened_border(0.03).unwrap();
    for _ in 0..10_000 {
        let p = random.point();
        let (d, winding) = (twin.distance(p), twin.winding(p));
        if (d - 0.03).abs() > twin.sag {
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
    let sizes = plate.sizes();
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
fn piles_of_the_same_loop_do_not_blow_up_the_hierarchy() {
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
        let sizes = trimmed.sizes();
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
fn touching_and_coinciding_borders_are_kept() {
    // A hole that touches the plate's border from within, and one that is the plate.
    let plate = TrimCurve::try_rectangle(UNIT[0], UNIT[1]).unwrap();
    let touching = region(vec![closed(plate.clone()), closed(circle(at(0.5, 0.25), 0.25).reversed())]);
    assert!(touching.contains(at(0.5, 0.0)) && !touching.contains(at(0.5, 1e-9)));
    assert!(
        touching.contains(at(0.5 + 1e-3, 0.0))
            && touching.contains(at(0.0, 0.0))
            && touching.contains(at(1.0, 1.0))
    );
    let empty = region(vec![closed(plate.clone()), closed(plate.reversed())]);
    assert!(empty.contains(at(0.3, 0.0)) && !empty.contains(at(0.3, 1e-9)) && !empty.contains(CENTER));
}

#[test]
fn without_loops_the_domain_is_kept_and_senseless_points_are_not() {
    let all = region(Vec::new());
    assert!(all.contains(CENTER) && all.contains(UNIT[0]) && all.contains(UNIT[1]));
    assert_eq!(all.classify(UNIT[0], UNIT[1]), Cell::Inside);
    assert!(!all.contains(at(f64::NAN, 0.5)) && !all.contains(at(0.5, f64::NAN)));
    // Loops around all of the domain, and beside it.
    let around = region(vec![closed(circle(CENTER, 10.0))]);
    let beside = region(vec![closed(circle(at(5.0, 5.0), 1.0))]);
    assert!(around.contains(at(0.1, 0.9)) && !beside.contains(at(0.1, 0.9)));
    assert_eq!(around.classify(UNIT[0], UNIT[1]), Cell::Inside);
}

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
fn gaps_are_closed_within_the_tolerance_and_named_beyond_it() {
    let line = |a, b| TrimCurve::try_line(a, b).unwrap();
    let (p, q, r) = (at(0.1, 0.1), at(0.9, 0.1), at(0.5, 0.9));
    let curves = || vec![line(p, q), line(q + at(0.0, 1e-4), r), line(r, p)];
    match TrimLoop::try_new(curves(), 1e-5) {
        Err(TrimError::Open { curve: 0, next: 1, end, gap, .. }) => {
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
fn senseless_curves_are_refused() {
    let nan = at(f64::NAN, 0.0);
    assert!(matches!(TrimCurve::try_line(UNIT[0], nan), Err(TrimError::NotFinite { .. })));
    assert!(matches!(TrimCurve::try_polygon(&UNIT), Err(TrimError::TooFew { count: 2, .. })));
    assert!(matches!(TrimCurve::try_circle(CENTER, 0.0), Err(TrimError::NotPositive { .. })));
    assert!(matches!(TrimCurve::try_ellipse(CENTER, UNIT[1], UNIT[1]), Err(TrimError::NotPositive { .. })));
    assert!(matches!(TrimCurve::try_rectangle(UNIT[1], UNIT[0]), Err(TrimError::EmptyRange { .. })));
    assert!(matches!(TrimCurve::try_bezier(&[DVec3::ONE]), Err(TrimError::Degree { degree: 0, .. })));
    let points = [DVec3::ONE, DVec3::new(0.0, 0.0, 1.0), DVec3::ONE];
    let weightless = [DVec3::ONE, DVec3::ZERO];
    assert!(matches!(TrimCurve::try_bezier(&weightless), Err(TrimError::NotPositive { .. })));
    let nurbs = |degree, knots: &[f64]| TrimCurve::try_nurbs(degree, knots, &points).unwrap_err();
    assert!(matches!(nurbs(1, &[0.0; 4]), TrimError::KnotCount { expected: 5, .. }));
    assert!(matches!(nurbs(1, &[0.0; 5]), TrimError::EmptyRange { .. }));
    assert!(matches!(nurbs(3, &[0.0; 7]), TrimError::TooFew { .. }));
    assert!(matches!(nurbs(1, &[0.0, 0.0, 2.0, 1.0, 1.0]), TrimError::KnotsDecrease { position: 3, .. }));
    assert!(matches!(nurbs(1, &[0.0, 0.0, f64::INFINITY, 1.0, 1.0]), TrimError::NotFinite { .. }));
    let four = [points[0], points[1], points[2], points[0]];
    let apart = TrimCurve::try_nurbs(1, &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0], &four);
    assert!(matches!(apart, Err(TrimError::KnotRepeated { count: 2, max: 1, .. })));
    assert!(matches!(TrimLoop::try_new(Vec::new(), 0.0), Err(TrimError::TooFew { .. })));
    let point = TrimCurve::try_line(CENTER, CENTER).unwrap();
    assert!(matches!(TrimLoop::try_closed(point, 0.0), Err(TrimError::Collapsed { .. })));
    assert!(matches!(TrimRegion::try_new(Vec::new(), [UNIT[0], nan]), Err(TrimError::NotFinite { .. })));
    assert!(matches!(TrimRegion::try_new(Vec::new(), [UNIT[0], UNIT[0]]), Err(TrimError::EmptyRange { .. })));
    assert!(matches!(region(Vec::new()).with_widened_border(-1.0), Err(TrimError::Negative { .. })));
}
