//! The cells of a region against those found by testing every cell and every point on their own.

use super::super::cell_tree::{CellLookup, CellTree, GridSquare, MAX_LEVEL};
use super::super::piece_table::{CurveSide, PieceTable};
use super::*;

/// The slow way to the cells: four corners of each quarter are searched anew for every piece. Regions that exceed the budget
/// of entries differ.
struct SlowCells<'a> {
    pieces: &'a PieceTable,
    tree: &'a CellTree,
    domain: [DVec2; 2],
    outermost: i32,
    random: Random,
    /// Number of cells, of crossed cells, and of their entries.
    sizes: (usize, usize, usize),
}

impl SlowCells<'_> {
    fn check(&mut self, square: GridSquare, list: &[u32]) {
        let (min, max) = self.tree.bounds(square);
        let touches = |i: &u32| self.pieces.touches(&self.pieces.pieces[*i as usize], min, max);
        let list: Vec<u32> = list.iter().copied().filter(touches).collect();
        self.sizes.0 += 1;
        let [low, high] = self.domain;
        let size = 0.5_f64.powi(square.level as i32);
        let piece = |&i: &u32| &self.pieces.pieces[i as usize];
        // Larger than the piece's width, and than an eighth of the piece.
        let exceeds_width = |i: &u32| size > (piece(i).width / (high - low)).min_element();
        let exceeds_strip = |i: &u32| size > piece(i).extent(low, high) / 8.0;
        let is_coarse = list.len() > 3 && list.iter().any(exceeds_width)
            || !list.is_empty() && list.iter().all(|i| exceeds_width(i) && exceeds_strip(i));
        if is_coarse && square.level < MAX_LEVEL {
            return (0..4).for_each(|quarter| self.check(square.quarter(quarter), &list));
        }
        if !list.is_empty() {
            self.sizes.1 += 1;
            self.sizes.2 += list.len();
        }
        for _ in 0..3 {
            let p = min + (max - min) * (0.05 + 0.9 * self.random.point());
            let location = self.location(p);
            match self.tree.find(p) {
                CellLookup::Uniform(inside) => {
                    assert!(list.is_empty(), "{p}");
                    assert_eq!(location == RegionLocation::Inside, inside, "{p}");
                    assert_eq!(location == RegionLocation::Outside, !inside, "{p}");
                }
                CellLookup::Crossed(leaf) => {
                    assert_eq!(self.tree.entries(leaf), list, "{p} {square:?}");
                    assert_eq!(self.pieces.locate(leaf, &list, p), location, "{p}");
                }
            }
        }
    }

    /// By the crossings of all pieces right of `p`, and the distances of all.
    fn location(&self, p: DVec2) -> RegionLocation {
        let winding = self.pieces.pieces.iter().try_fold(self.outermost, |winding, piece| {
            let is_near = piece.near(p, self.pieces.slack);
            let side = if is_near { self.pieces.side(piece, p) } else { CurveSide::Left };
            (side != CurveSide::On).then(|| winding + piece.crossings_right(p, side))
        });
        let in_border = self.pieces.pieces.iter().any(|piece| self.pieces.side_near(piece, p).1);
        match winding {
            None => RegionLocation::InnerBorder,
            Some(winding) if winding > 0 && in_border => RegionLocation::InnerBorder,
            Some(winding) if winding > 0 => RegionLocation::Inside,
            Some(_) if in_border => RegionLocation::OuterBorder,
            Some(_) => RegionLocation::Outside,
        }
    }
}

fn check(loops: &[TrimLoop], domain: [DVec2; 2], border: f64, seed: u64) {
    check_with_widths(loops, domain, |_| border, seed);
}

/// `width`: that of each piece.
fn check_with_widths(loops: &[TrimLoop], domain: [DVec2; 2], width: impl Fn(usize) -> f64, seed: u64) {
    for outermost in [0, 1] {
        let mut pieces = PieceTable::try_new(loops, DVec2::ONE).unwrap();
        pieces.pieces.iter_mut().enumerate().for_each(|(i, piece)| piece.width = width(i));
        let tree = CellTree::try_new(&pieces, domain, outermost).unwrap();
        let all: Vec<u32> = (0..pieces.pieces.len() as u32).collect();
        let random = Random(seed);
        let mut slow =
            SlowCells { pieces: &pieces, tree: &tree, domain, outermost, random, sizes: (0, 0, 0) };
        slow.check(GridSquare { x: 0, y: 0, level: 0 }, &all);
        assert_eq!(slow.sizes, tree.sizes());
    }
}

#[test]
fn cells_of_scattered_ellipses_are_those_of_the_slow_way() {
    let mut random = Random(20);
    for border in [0.0, 1e-9] {
        let loops: Vec<TrimLoop> = (0..60)
            .map(|_| {
                let (center, size) = (1.2 * random.point() - 0.1, 0.01 + 0.1 * random.unit());
                let angle = TAU * random.unit();
                let a = size * at(angle.cos(), angle.sin());
                let ellipse = TrimCurve::try_ellipse(center, a, (0.2 + random.unit()) * a.perp()).unwrap();
                closed(if random.unit() < 0.5 { ellipse } else { ellipse.reversed() })
            })
            .collect();
        check(&loops, UNIT, border, 21);
    }
}

#[test]
fn cells_of_circles_on_the_lines_of_the_grid_are_those_of_the_slow_way() {
    // Ends of pieces, and polygons' sides and corners, on the sides and corners of cells.
    let mut loops: Vec<TrimLoop> = (0..36)
        .map(|i| closed(circle(at(f64::from(i % 6), f64::from(i / 6)) / 8.0 + 0.125, 1.0 / 32.0).reversed()))
        .collect();
    loops.push(closed(TrimCurve::try_rectangle(UNIT[0], UNIT[1]).unwrap()));
    loops.push(polygon(&[at(0.25, 0.25), at(0.75, 0.5), at(0.5, 0.75)]));
    loops.push(polygon(&[at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]));
    check(&loops, UNIT, 0.0, 22);
}

#[test]
fn cells_of_circles_that_touch_lines_of_the_grid_are_those_of_the_slow_way() {
    // The rightmost point of every fourth circle is 15/32 of the domain from its left side.
    let hole = |i: u32| circle(at(f64::from(i % 4) + 0.5, f64::from(i / 4) + 0.5) / 4.0, 0.35 / 4.0);
    let mut loops: Vec<TrimLoop> = (0..16).map(|i| closed(hole(i).reversed())).collect();
    loops.push(closed(TrimCurve::try_rectangle(UNIT[0], UNIT[1]).unwrap()));
    for border in [1e-9, 1e-3] {
        check(&loops, [DVec2::splat(-0.1), DVec2::splat(1.1)], border, 24);
    }
}

#[test]
fn cells_of_random_nurbs_loops_are_those_of_the_slow_way() {
    let mut random = Random(23);
    for round in 0..12 {
        let wild = f64::from(round % 4) / 3.0;
        let mut loops = Vec::new();
        for _ in 0..6 {
            let size = 0.02 + 0.4 * random.unit();
            let curve = blob(&mut random, CENTER, size, wild);
            let curve = if random.unit() < 0.5 { curve.reversed() } else { curve };
            loops.push(TrimLoop::try_closed(curve, 1e-12).unwrap());
        }
        check(&loops, UNIT, [0.0, 1e-9][round as usize % 2], 25);
    }
}

#[test]
fn cells_of_curves_of_unequal_widths_are_those_of_the_slow_way() {
    // Widths from none to more than the size of the curves.
    let mut random = Random(26);
    for domain in [UNIT, [at(0.2, 0.4), at(0.5, 0.5)]] {
        let loops: Vec<TrimLoop> =
            (0..12).map(|_| closed(circle(1.2 * random.point() - 0.1, 0.02 + 0.3 * random.unit()))).collect();
        let widths: Vec<f64> = (0..60).map(|_| 10.0_f64.powf(-8.0 * random.unit() - 1.0)).collect();
        let width = |i: usize| if i.is_multiple_of(5) { 0.0 } else { widths[i % 60] };
        check_with_widths(&loops, domain, width, 27);
    }
}
