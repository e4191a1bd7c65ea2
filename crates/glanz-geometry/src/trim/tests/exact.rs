//! Points next to borders of known form.

use super::*;

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
fn points_at_the_height_of_the_ends_of_pieces_are_exact() {
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
