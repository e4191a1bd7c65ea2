//! Regions asked as the shader asks them, against the exact answer.

use std::f64::consts::{PI, TAU};

use glanz_geometry::trim::{RegionSettings, TrimCurve, TrimLoop, TrimRegion};
use glanz_math::{DVec2, DVec3};

use super::super::blocks::Blocks;
use super::super::head;
use super::super::region::Grid;

/// A sequence of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn point(&mut self) -> DVec2 {
        DVec2::new(self.next(), self.next())
    }
}

fn point_of(points: &[[f32; 4]], t: f32) -> [f32; 2] {
    let mut points: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1], p[2]]).collect();
    while points.len() > 1 {
        points = points.windows(2).map(|p| [0, 1, 2].map(|k| p[0][k] * (1.0 - t) + p[1][k] * t)).collect();
    }
    [points[0][0] / points[0][2], points[0][1] / points[0][2]]
}

fn points_of<'a>(blocks: &'a Blocks, part: &[f32; 8]) -> &'a [[f32; 4]] {
    &blocks.region_points[part[4] as usize..=(part[4] + part[5]) as usize]
}

fn cell_of(blocks: &Blocks, region: &head::ModelRegion, at: [f32; 2]) -> [u32; 4] {
    let [nx, ny] = region.cells;
    let [column, row] = [(at[0], nx), (at[1], ny)].map(|(x, n)| ((x * n as f32) as usize).min(n - 1));
    blocks.region_cells[region.first_cell + row * nx + column]
}

/// The winding number as `docs/viewer.md` says, in single precision.
fn winding(blocks: &Blocks, region: &head::ModelRegion, at: [f32; 2]) -> i32 {
    let [u, v] = at.map(|x| x.clamp(0.0, 1.0));
    let [first_entry, entries, first_step, packed] = cell_of(blocks, region, [u, v]).map(|w| w as usize);
    let mut winding = (packed >> 16) as i32 - 128;
    for [height, change] in &blocks.region_steps[first_step..first_step + (packed & 0xffff)] {
        winding += if *height <= v { *change as i32 } else { 0 };
    }
    for [part, low, high, direction] in &blocks.region_entries[first_entry..first_entry + entries] {
        if !(*low <= v && v < *high) {
            continue;
        }
        let points = points_of(blocks, &blocks.region_parts[*part as usize]);
        let (mut before, mut after) = (0.0_f32, 1.0_f32);
        for _ in 0..32 {
            let middle = 0.5 * (before + after);
            if (point_of(points, middle)[1] < v) == (*direction > 0.0) {
                before = middle;
            } else {
                after = middle;
            }
        }
        winding += if point_of(points, before)[0] > u { *direction as i32 } else { 0 };
    }
    winding
}

/// Whether a listed part of the cell has `at` within its width, as the shader finds it: in units of the width.
fn is_within_width(blocks: &Blocks, region: &head::ModelRegion, at: [f32; 2]) -> bool {
    let [first, count, ..] = cell_of(blocks, region, at).map(|word| word as usize);
    blocks.region_entries[first..first + count].iter().any(|entry| {
        let part = &blocks.region_parts[entry[0] as usize];
        let points = points_of(blocks, part);
        let there = |t: f32| {
            let [u, v] = point_of(points, t);
            ((u - at[0]) / part[6]).hypot((v - at[1]) / part[7])
        };
        (0..=4000).any(|i| there(i as f32 / 4000.0) <= 1.0)
    })
}

/// Distance from the nearest curve, roughly, over the unit square; infinite if there is none within a thousandth.
fn distance(blocks: &Blocks, at: DVec2) -> f64 {
    let mut least = f64::INFINITY;
    let single = [at.x as f32, at.y as f32];
    let is_near =
        |part: &&[f32; 8]| (0..2).all(|k| part[k] - single[k] < 1e-3 && single[k] - part[k + 2] < 1e-3);
    for part in blocks.region_parts.iter().filter(is_near) {
        let points: Vec<[f32; 4]> = points_of(blocks, part).to_vec();
        let there = |t: f64| {
            let [u, v] = point_of(&points, t as f32);
            at.distance(DVec2::new(u.into(), v.into()))
        };
        // The distance has few minima along a monotone part: around the best of many, halve.
        let best =
            (0..=64).map(|i| f64::from(i) / 64.0).min_by(|a, b| there(*a).total_cmp(&there(*b))).unwrap();
        let (mut t, mut step) = (best, 1.0 / 64.0);
        for _ in 0..40 {
            step *= 0.7;
            for candidate in [t - step, t + step] {
                if (0.0..=1.0).contains(&candidate) && there(candidate) < there(t) {
                    t = candidate;
                }
            }
        }
        least = least.min(there(t));
    }
    least
}

fn laid(region: &TrimRegion) -> (Blocks, head::ModelRegion) {
    let mut blocks = Blocks::default();
    let head = Grid::of(region).add_to(&mut blocks).unwrap();
    (blocks, head)
}

fn assert_agrees(name: &str, region: &TrimRegion, count: usize) {
    let (blocks, head) = laid(region);
    let [min, max] = region.domain();
    let mut random = Random(count as u64);
    let cells = head.cells[0] as f64;
    let mut kept = 0;
    for i in 0..count {
        let mut at = random.point();
        match i % 4 {
            // On the border of cells, along one axis or both.
            0 => at.x = (at.x * cells).floor() / cells,
            1 => at = (at * cells).floor() / cells,
            // Near a curve, if there is one.
            2 if !blocks.region_parts.is_empty() => {
                let part = &blocks.region_parts[(random.next() * blocks.region_parts.len() as f64) as usize];
                let [u, v] = point_of(points_of(&blocks, part), random.next() as f32);
                let away = 10.0_f64.powf(-2.0 - 4.0 * random.next());
                at = DVec2::new(u.into(), v.into()) + (random.point() - 0.5) * away;
            }
            _ => {}
        }
        let single = [at.x as f32, at.y as f32];
        let at = DVec2::new(single[0].into(), single[1].into());
        let expected = region.contains(min + at * (max - min));
        let found = winding(&blocks, &head, single) > 0;
        kept += usize::from(found);
        if found != expected {
            let near = distance(&blocks, at.clamp(DVec2::ZERO, DVec2::ONE));
            assert!(near < 1e-6, "{name}: {at} is {near} away from a curve, kept: {expected}");
        }
    }
    assert!(kept > 0, "{name}");
}

fn closed(curve: TrimCurve) -> TrimLoop {
    TrimLoop::try_closed(curve, 1e-9).unwrap()
}

fn circle(center: DVec2, radius: f64) -> TrimCurve {
    TrimCurve::try_circle(center, radius).unwrap()
}

/// A closed rational cubic spline around `center`, counter-clockwise.
fn blob(center: DVec2, radius: f64, random: &mut Random) -> TrimCurve {
    let count = 7;
    let mut points: Vec<DVec3> = (0..count)
        .map(|i| {
            let far = radius * (0.4 + 0.6 * random.next());
            let weight = 0.3 + 2.0 * random.next();
            ((center + DVec2::from_angle(TAU * f64::from(i) / f64::from(count)) * far) * weight)
                .extend(weight)
        })
        .collect();
    points.extend_from_within(..3);
    let knots: Vec<f64> = (0..points.len() as u32 + 4).map(f64::from).collect();
    TrimCurve::try_nurbs(3, &knots, &points).unwrap()
}

fn region(loops: Vec<TrimCurve>, min: [f64; 2], max: [f64; 2]) -> TrimRegion {
    TrimRegion::try_new(loops.into_iter().map(closed).collect(), [min.into(), max.into()]).unwrap()
}

#[test]
fn shader_and_exact_region_agree_away_from_curves() {
    let mut random = Random(1);
    let center = DVec2::new(3.0, -1.0);
    let at = |x: f64, y: f64| DVec2::new(x, y);
    let unit = ([0.0; 2], [1.0; 2]);
    let cases = [
        ("without loops", vec![], unit),
        ("a circle", vec![circle(center, 0.7)], ([2.0, -2.0], [4.0, 0.0])),
        ("a hole", vec![circle(at(0.4, 0.6), 0.3).reversed()], unit),
        (
            "an ellipse askew",
            vec![TrimCurve::try_ellipse(at(0.5, 0.5), at(0.3, 0.2), at(-0.1, 0.15)).unwrap()],
            unit,
        ),
        (
            "nested",
            vec![
                circle(at(0.5, 0.5), 0.45),
                circle(at(0.5, 0.5), 0.3).reversed(),
                circle(at(0.5, 0.5), 0.2),
                circle(at(0.55, 0.5), 0.1).reversed(),
            ],
            unit,
        ),
        ("wound twice", vec![circle(at(0.5, 0.5), 0.4), circle(at(0.6, 0.5), 0.2)], unit),
        ("a border that leaves the domain", vec![circle(at(0.8, 0.9), 0.5)], unit),
        ("a hole that leaves the domain", vec![circle(at(0.0, 0.3), 0.25).reversed()], unit),
        ("lines along cells", vec![TrimCurve::try_rectangle(at(0.25, 0.25), at(0.75, 0.5)).unwrap()], unit),
        ("all of it", vec![TrimCurve::try_rectangle(at(0.0, 0.0), at(1.0, 1.0)).unwrap()], unit),
        ("a spline", vec![blob(at(0.5, 0.5), 0.5, &mut random)], unit),
        (
            "splines in one another",
            vec![blob(at(0.5, 0.5), 0.5, &mut random), blob(at(0.45, 0.5), 0.2, &mut random).reversed()],
            unit,
        ),
    ];
    for (name, loops, (min, max)) in cases {
        assert_agrees(name, &region(loops, min, max), 8000);
    }
}

#[test]
fn a_thousand_holes_agree_and_cells_list_few_of_them() {
    let mut holes = Vec::new();
    for (i, j) in (0..40).flat_map(|i| (0..25).map(move |j| (i, j))) {
        let center = DVec2::new((f64::from(i) + 0.5) / 10.0, (f64::from(j) + 0.5) / 10.0);
        holes.push(circle(center, 0.04).reversed());
    }
    let region = region(holes, [0.0; 2], [4.0, 2.5]);
    assert_agrees("holes", &region, 20_000);
    let (blocks, head) = laid(&region);
    // 4000 quarters of circles and, at most, 256 cells along a side.
    assert_eq!(blocks.region_parts.len(), 4000);
    assert_eq!(head.cells, [128, 128]);
    let most = blocks.region_cells.iter().map(|cell| cell[1]).max().unwrap();
    assert!(most <= 8, "{most}");
}

#[test]
fn a_cell_lists_the_parts_that_come_near_it() {
    let mut random = Random(5);
    // Many ends of parts, some of them just beyond the border of a cell.
    let mut hole = |_| circle(random.point(), 0.005 + 0.03 * random.next()).reversed();
    let holes = (0..200).map(&mut hole).collect();
    let (blocks, head) = laid(&region(holes, [0.0; 2], [1.0; 2]));
    // Less than the twentieth that the lists promise, by the rounding of single precision.
    let near = 0.0499 / head.cells[0] as f64;
    for i in 0..100_000 {
        let number = i % blocks.region_parts.len();
        let [u, v] = point_of(points_of(&blocks, &blocks.region_parts[number]), random.next() as f32);
        let at = DVec2::new(u.into(), v.into()) + (random.point() * 2.0 - 1.0) * near;
        if at.min_element() < 0.0 || at.max_element() >= 1.0 {
            continue;
        }
        let [first, count, ..] = cell_of(&blocks, &head, [at.x as f32, at.y as f32]).map(|w| w as usize);
        let entries = &blocks.region_entries[first..first + count];
        assert!(entries.iter().any(|entry| entry[0] as usize == number), "{at}, part {number}");
    }
}

#[test]
fn winding_numbers_are_those_of_circles_in_circles() {
    // Points along a radius, from inside out: wound round twice, once, not at all.
    let circles = vec![circle(DVec2::splat(0.5), 0.4), circle(DVec2::splat(0.5), 0.2)];
    let (blocks, head) = laid(&region(circles, [0.0; 2], [1.0; 2]));
    for turn in 0..24 {
        let direction = DVec2::from_angle(PI / 12.0 * f64::from(turn));
        for (radius, expected) in [(0.1, 2), (0.199, 2), (0.201, 1), (0.399, 1), (0.401, 0)] {
            let at = DVec2::splat(0.5) + radius * direction;
            assert_eq!(winding(&blocks, &head, [at.x as f32, at.y as f32]), expected, "{radius} {turn}");
        }
    }
}

#[test]
fn points_within_the_width_of_a_curve_are_kept_as_by_the_exact_region() {
    let curve = circle(DVec2::new(0.5, 0.4), 0.25).with_width(0.03).unwrap();
    // Metres per unit of u and v: the border is an ellipse in the unit square, three times as long along u.
    let settings = RegionSettings {
        scale: DVec2::new(0.5, 1.5),
        domain: Some([DVec2::new(0.1, 0.0), DVec2::new(1.1, 0.8)]),
    };
    let region = TrimRegion::try_with_settings(vec![vec![curve]], settings).unwrap();
    let (blocks, head) = laid(&region);
    let [min, max] = region.domain();
    let (mut random, mut borders) = (Random(9), 0);
    for _ in 0..4000 {
        let single = random.point().to_array().map(|x| x as f32);
        let at = DVec2::from(single.map(f64::from));
        let kept = winding(&blocks, &head, single) > 0;
        let found = kept || is_within_width(&blocks, &head, single);
        let uv = min + at * (max - min);
        // Which points are kept is certain a thousandth of the width off the border's own border.
        let location = |share: f64| {
            let curve = circle(DVec2::new(0.5, 0.4), 0.25).with_width(0.03 * share).unwrap();
            TrimRegion::try_with_settings(vec![vec![curve]], settings).unwrap().contains(uv)
        };
        assert!(!found || location(1.002), "{uv}");
        assert!(found || !location(0.998), "{uv}");
        borders += usize::from(found && !kept);
    }
    assert!(borders > 200, "{borders}");
}
