//! The roots of a leaf by subdivision, for silhouettes, collapsed edges and edge-on views: the Bernstein coefficients of the
//! signed distances from two planes through the ray are halved until a cell is excluded, certified, or as small as rounding.
//!
//! In homogeneous coordinates these distances are polynomials for rational leaves, too: weights cost one more product per
//! coefficient at the start, and nothing afterwards.
//!
//! Bisection alone takes up to a million cells where the ray touches the surface along a curve. Three tools bound their number:
//! `contact_arc` eliminates one parameter where the gradients of the distances are parallel, *deflation* divides by the distance from an
//! edge on which both vanish (apexes, and borders along the ray), and `degree_reduction` makes small cells of high degree cubics. What is
//! below rounding ends as a `flat_cell`.

use glanz_math::DVec2;

use super::cell_class::{CellClass, CellTest};
use super::cell_coefficients::split;
use super::contact_arc::{self, ArcClass};
use super::contraction::{LocalRoot, MapBounds, NoConvergence, PlanarJet, PlanarMap, contract};
use super::control_net::{BernsteinPowers, with_room};
use super::degree_reduction;
use super::flat_cell::{FlatCell, join, polish};
use super::ray_space::RaySpace;
use super::root::{FirstOrderJet, SearchScratch};
use crate::bvh::simd::Isa;

/// Largest number of steps in a certified cell: more than the contraction needs for the last bit.
const MOST_STEPS: usize = 200;

/// Largest error of coefficients by a lower degree, relative to their noise.
const MOST_REDUCTION: f64 = 0.125;

/// Factor of the noise of coefficients that are divided by the distance from an edge: its inverse in the middle of the cell, for the coefficients and for the
/// row of the edge that is dropped. Next to the edge it is more, but there the edge itself is the root.
const DEFLATED: f64 = 4.0;

/// Largest number of cells of a leaf, after which it counts as undecided: several times as many as the hardest leaves need, near tangencies, asymptotes,
/// apexes and curves in the surface, and four times as many as maps with a double point over a whole patch.
const MOST_CELLS: usize = 2000;

/// Number of cells of a leaf that are only halved, unless a contact is expected in one: most leaves need no more, and for them the tests by
/// `degree_reduction` and `contact_arc` cost more than they save.
const EASY_CELLS: usize = 6;

/// Degree from which lower degrees save more than their test costs, in any cell.
const HIGH_DEGREE: usize = 8;

/// Distance in the parameters within which tangencies are one root.
const TANGENT_UNCERTAINTY: f64 = 1.0 / (1 << 18) as f64;

/// A leaf that can be subdivided.
pub(super) trait SubdividablePatch {
    /// Degrees of the coefficients of [`SubdividablePatch::project`].
    fn degrees(&self) -> (usize, usize);
    /// Fills `cells` with the Bernstein coefficients of the signed distances, times weight, from both planes through the
    /// ray, that of (i, j) at j (p + 1) + i, and those of the weights if they are not all 1. Returns the bound on their
    /// rounding errors per weight.
    fn project(&self, space: &RaySpace, cells: &mut Vec<f64>) -> f64;
    /// Point and first derivatives at (x, y) in [0, 1]^2.
    fn jet(&self, x: f64, y: f64) -> FirstOrderJet;
    /// Bound on the rounding error of this point across the ray, metres.
    fn noise(&self, space: &RaySpace) -> f64;
}

/// A rectangle of the leaf, and the position of its coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubdivisionCell {
    pub(super) from: DVec2,
    pub(super) width: DVec2,
    start: usize,
    degrees: (usize, usize),
    /// Factor of the noise: deflation enlarges it.
    factor: f64,
    /// Error of the coefficients by lower degrees.
    reduction: f64,
    /// Whether it is a half across x, or one across y, of a cell whose degrees were reduced as far as possible; `None` if they were not.
    halved: Option<bool>,
}

impl SubdivisionCell {
    /// Number of coefficients of each list.
    fn length(&self) -> usize {
        (self.degrees.0 + 1) * (self.degrees.1 + 1)
    }

    /// The place of a point of the cell in the leaf.
    pub(super) fn at(&self, local: DVec2) -> DVec2 {
        self.from + self.width * local
    }
}

/// Appends every root of `patch` to `scratch.roots`, those on the border of two cells possibly twice.
#[cold]
pub(super) fn roots(patch: &impl SubdividablePatch, space: &RaySpace, scratch: &mut SearchScratch) {
    let degrees = patch.degrees();
    let noise = patch.project(space, &mut scratch.cells);
    let lists = scratch.cells.len() / ((degrees.0 + 1) * (degrees.1 + 1));
    let whole = SubdivisionCell {
        from: DVec2::ZERO,
        width: DVec2::ONE,
        start: 0,
        degrees,
        factor: 1.0,
        reduction: 0.0,
        halved: None,
    };
    let mut search = LeafSubdivision {
        isa: Isa::detect(),
        patch,
        space,
        noise,
        lists,
        stack: vec![whole],
        flats: Vec::new(),
        is_hard: false,
    };
    let mut count = 0;
    while let Some(cell) = search.stack.pop() {
        count += 1;
        scratch.examined += 1;
        if count > MOST_CELLS {
            // The tangencies found so far are roots all the same.
            scratch.undecided += 1;
            break;
        }
        search.is_hard |= count > EASY_CELLS;
        search.examine(cell, scratch);
    }
    join(search.flats, patch, space, &mut scratch.roots);
}

/// The state of the subdivision of a leaf.
struct LeafSubdivision<'a, P> {
    isa: Isa,
    patch: &'a P,
    space: &'a RaySpace,
    /// Bound on the rounding of the coefficients, per weight.
    noise: f64,
    /// Two, or three with weights.
    lists: usize,
    stack: Vec<SubdivisionCell>,
    flats: Vec<FlatCell>,
    /// Whether so many cells were examined that the expensive tests pay, or the ray seems to lie within the surface.
    is_hard: bool,
}

impl<P: SubdividablePatch> LeafSubdivision<'_, P> {
    /// Excludes the last cell in memory, adds its roots, or puts its parts on the stack.
    fn examine(&mut self, mut cell: SubdivisionCell, scratch: &mut SearchScratch) {
        let n = cell.length();
        scratch.cells.truncate(cell.start + self.lists * n);
        let (both, weights) = scratch.cells[cell.start..].split_at(2 * n);
        // The largest weight of the cell bounds the noise of all its coefficients.
        let weight = weights.iter().copied().reduce(f64::max).unwrap_or(1.0);
        let exact = self.noise * cell.factor * weight;
        let noise = exact + cell.reduction;
        let (first, second) = both.split_at(n);
        let test = CellTest { lists: [first, second], degrees: cell.degrees, noise };
        let (across_x, slopes) = match self.isa.run(test) {
            CellClass::Excluded => return,
            CellClass::Certified(certificate) => {
                let mut map = CellPolynomials { lists: [first, second], degrees: cell.degrees };
                let bounds =
                    MapBounds { noise, curvature_bound: f64::INFINITY, weights: [1.0; 2], steps: MOST_STEPS };
                let found = contract(&mut map, &certificate, &bounds, DVec2::ZERO);
                match found {
                    Ok(Some(LocalRoot { at, uncertainty })) => {
                        let half = 0.5 * cell.width;
                        self.add(cell.from + half * (at + DVec2::ONE), uncertainty * half, &cell, scratch);
                    }
                    Ok(None) => {}
                    // Rounding stopped the contraction short of its bound.
                    Err(NoConvergence) => self.halve(cell, cell.width.x >= cell.width.y, false, scratch),
                }
                return;
            }
            CellClass::Flat => {
                self.flats.push(FlatCell::new(self.patch, self.space, &cell));
                return;
            }
            CellClass::Open { across_x, slopes } => (across_x, slopes),
        };
        let is_reducible = self.is_reducible(&cell);
        for along_x in [true, false].into_iter().filter(|_| is_reducible) {
            // Only halving lowers the degree.
            if cell.halved.is_some_and(|across_x| across_x != along_x) {
                continue;
            }
            let most = MOST_REDUCTION * exact;
            if let Some((degrees, error)) =
                degree_reduction::reduce(&mut scratch.cells, cell.start, cell.degrees, along_x, most, 2)
            {
                (cell.degrees, cell.reduction) = (degrees, cell.reduction + error);
            }
        }
        let noise = exact + cell.reduction;
        if self.deflate(&mut cell, noise, scratch) {
            self.stack.push(cell);
            return;
        }
        let both = &scratch.cells[cell.start..cell.start + 2 * cell.length()];
        let (first, second) = both.split_at(cell.length());
        if !self.is_hard {
            if !contact_arc::is_expected([first, second], cell.degrees, slopes, noise) {
                self.halve(cell, across_x, is_reducible, scratch);
                return;
            }
            self.is_hard = true;
        }
        let across_x = match contact_arc::classify([first, second], cell.degrees, slopes, noise) {
            ArcClass::Excluded => return,
            ArcClass::Roots(roots) => {
                for root in roots.into_iter().flatten() {
                    if root.contact {
                        self.flats.push(FlatCell::of_arc(self.patch, self.space, &cell, &root));
                    } else {
                        self.add(cell.at(root.at), root.uncertainty * cell.width, &cell, scratch);
                    }
                }
                return;
            }
            ArcClass::Open { across_first } => across_first,
            ArcClass::Irregular => across_x,
        };
        self.halve(cell, across_x, is_reducible, scratch);
    }

    /// Whether a lower degree of the cell is searched for.
    fn is_reducible(&self, cell: &SubdivisionCell) -> bool {
        self.is_hard || cell.degrees.0.max(cell.degrees.1) >= HIGH_DEGREE
    }

    /// Puts the halves of the last cell in memory on the stack; one that is as small as parameters can be is a root.
    fn halve(
        &mut self,
        cell: SubdivisionCell,
        across_x: bool,
        is_reduced: bool,
        scratch: &mut SearchScratch,
    ) {
        let halved = is_reduced.then_some(across_x);
        let [low, high] = halve(&SubdivisionCell { halved, ..cell }, across_x, self.lists * cell.length());
        if low.width.min_element() < f64::EPSILON {
            let middle = cell.at(DVec2::splat(0.5));
            self.add(middle, DVec2::splat(TANGENT_UNCERTAINTY), &cell, scratch);
        } else {
            split(self.isa, &mut scratch.cells, cell.start, cell.degrees, across_x);
            self.stack.extend([low, high]);
        }
    }

    /// Adds the root next to `place`, if the leaf has one there.
    fn add(&self, place: DVec2, uncertainty: DVec2, cell: &SubdivisionCell, scratch: &mut SearchScratch) {
        scratch.roots.extend(polish(self.patch, self.space, place, uncertainty, cell.width));
    }

    /// Divides the polynomials of a cell by the distance from an edge on which both vanish to within rounding: an edge that is one point,
    /// or one along the ray. That edge becomes a flat cell, and what remains has no more roots there than anywhere else.
    fn deflate(&mut self, cell: &mut SubdivisionCell, noise: f64, scratch: &mut SearchScratch) -> bool {
        let ((p, q), n) = (cell.degrees, cell.length());
        let coefficients = &scratch.cells[cell.start..];
        let vanishes = |start: usize, step: usize, count: usize| {
            let of_list = |list: &[f64]| (0..count).all(|k| list[start + k * step].abs() <= noise);
            coefficients[..2 * n].chunks_exact(n).all(of_list)
        };
        // Start, end and step of the rows across each edge, their count and distance.
        let edges = [
            (p > 0, 0, p + 1, q + 1, true, false),
            (p > 0, p, p + 1, q + 1, true, true),
            (q > 0, 0, 1, p + 1, false, false),
            (q > 0, q * (p + 1), 1, p + 1, false, true),
        ];
        let found = edges
            .into_iter()
            .find(|&(possible, start, step, count, ..)| possible && vanishes(start, step, count));
        let Some((.., across_x, upper)) = found else { return false };
        self.flats.push(FlatCell::of_edge(self.patch, self.space, cell, across_x, upper));
        let degree = if across_x { p } else { q };
        let degrees = if across_x { (p - 1, q) } else { (p, q - 1) };
        let mut divided = Vec::with_capacity(self.lists * n);
        for (number, list) in coefficients.chunks_exact(n).enumerate() {
            for j in 0..=degrees.1 {
                for i in 0..=degrees.0 {
                    let k = if across_x { i } else { j };
                    let (i, j) = match (upper, across_x) {
                        (true, _) => (i, j),
                        (false, true) => (i + 1, j),
                        (false, false) => (i, j + 1),
                    };
                    let share = degree as f64 / if upper { degree - k } else { k + 1 } as f64;
                    let value = list[j * (p + 1) + i];
                    // Weights only bound the rounding, also that of the row on the edge.
                    let (edge_i, edge_j) = match (upper, across_x) {
                        (true, true) => (p, j),
                        (true, false) => (i, q),
                        (false, true) => (0, j),
                        (false, false) => (i, 0),
                    };
                    let bound = || value.max(list[edge_j * (p + 1) + edge_i]);
                    divided.push(if number < 2 { value * share } else { bound() });
                }
            }
        }
        scratch.cells.truncate(cell.start);
        scratch.cells.extend(divided);
        cell.degrees = degrees;
        cell.factor *= DEFLATED;
        cell.reduction *= DEFLATED;
        true
    }
}

fn halve(cell: &SubdivisionCell, across_x: bool, size: usize) -> [SubdivisionCell; 2] {
    let mut low = *cell;
    let mut high = low;
    if across_x {
        low.width.x *= 0.5;
        high.from.x += low.width.x;
    } else {
        low.width.y *= 0.5;
        high.from.y += low.width.y;
    }
    high.width = low.width;
    high.start += size;
    [low, high]
}

/// The coefficients of a cell as a map of [-1, 1]^2.
struct CellPolynomials<'a> {
    lists: [&'a [f64]; 2],
    degrees: (usize, usize),
}

impl PlanarMap for CellPolynomials<'_> {
    fn jet(&mut self, x: DVec2) -> PlanarJet {
        let (p, q) = self.degrees;
        let z = 0.5 * (x + DVec2::ONE);
        let sums = with_room!(p.max(q), N => {
            let (x, y) = (BernsteinPowers::<N>::new(p, z.x), BernsteinPowers::<N>::new(q, z.y));
            let (bx, dx, by, dy) = (x.values(), x.first_derivatives(), y.values(), y.first_derivatives());
            self.lists.map(|list| weighted(list, p + 1, &bx, &dx, &by, &dy))
        });
        let at = |k: usize| DVec2::new(sums[0][k], sums[1][k]);
        PlanarJet { f: at(0), fs: 0.5 * at(1), ft: 0.5 * at(2) }
    }

    /// The noise of a cell includes the weights.
    fn weight(&self, _: DVec2) -> f64 {
        1.0
    }
}

/// Sums of a list by bases: value, derivative by x, by y.
#[inline(always)]
fn weighted<const N: usize>(
    list: &[f64],
    stride: usize,
    bx: &[f64; N],
    dx: &[f64; N],
    by: &[f64; N],
    dy: &[f64; N],
) -> [f64; 3] {
    // Over the rows first, whose entries are neighbours.
    let (mut values, mut rises) = ([0.0; N], [0.0; N]);
    for ((row, by), dy) in list.chunks_exact(stride).zip(by).zip(dy) {
        for ((value, rise), coefficient) in values.iter_mut().zip(&mut rises).zip(row) {
            *value += coefficient * by;
            *rise += coefficient * dy;
        }
    }
    let mut sums = [0.0; 3];
    for i in 0..N {
        sums[0] += values[i] * bx[i];
        sums[1] += values[i] * dx[i];
        sums[2] += rises[i] * bx[i];
    }
    sums
}
