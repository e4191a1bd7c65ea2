//! The roots of a leaf by subdivision, for silhouettes, collapsed edges and edge-on views: the Bernstein coefficients of the
//! signed distances from two planes through the ray are halved until a cell is excluded, certified, or as small as rounding.
//!
//! In homogeneous coordinates these distances are polynomials for rational leaves, too: weights cost one more product per
//! coefficient at the start, and nothing afterwards.

use glanz_math::DVec2;

use super::contact_arc::{self, ArcClass, ArcRoot};
use super::contraction::{Certificate, LocalRoot, MapBounds, PlanarJet, PlanarMap, contract};
use super::control_net::{BernsteinPowers, with_room};
use super::degree_reduction;
use super::parameter_rect::{DyadicRect, ParameterRect};
use super::ray_space::{RaySpace, cross};
use super::root::{FirstOrderJet, SearchScratch, SurfaceRoot};

/// Largest contraction at which a cell is certified.
const CERTIFIED: f64 = 0.75;

/// Largest shift by rounding of the root of a certified cell, as a fraction of half the cell.
const MOST_UNCERTAINTY: f64 = 0.0625;

/// Largest number of steps in a certified cell: more than the contraction needs for the last bit.
const MOST_STEPS: usize = 200;

/// Largest error of coefficients by a lower degree, relative to their noise.
const MOST_REDUCTION: f64 = 0.125;

/// Factor of the noise of coefficients that are divided by the distance from an edge: its inverse in the middle of the cell. Next to the
/// edge it is more, but there the edge itself is the root.
const DEFLATED: f64 = 2.0;

/// Largest number of cells of a leaf, after which it counts as undecided.
const MOST_CELLS: usize = 2000;

/// Largest total length of flat cells, in units of the noise, that is a root. Cells that are flat to within rounding and
/// projected to a line or a point are a tangency or a collapsed edge if they are shorter than this; otherwise the ray lies
/// within the surface, which is no hit. Curvature of radius R is flat to within rounding e over a length of sqrt(e R): with
/// e of 1e-15 of the size, 3e-8 of the size for R of the size, and 3e-6 for R ten thousand times as large. Along an
/// asymptote of a saddle, where the ray passes through the surface, it is (e R^2)^(1/3), 1e-5 of the size; where the
/// asymptotic curve has an inflection, (e R^3)^(1/4), 2e-4.
const TANGENT_LENGTH: f64 = (1_u64 << 36) as f64;

/// Largest distance of a root from the ray, in units of the noise.
const BESIDE: f64 = 14.0;

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
struct SubdivisionCell {
    from: DVec2,
    width: DVec2,
    start: usize,
    degrees: (usize, usize),
    /// Factor of the noise: deflation enlarges it.
    factor: f64,
    /// Error of the coefficients by lower degrees.
    reduction: f64,
    /// Whether it is a half across x, or one across y; none for a whole leaf.
    halved: Option<bool>,
}

impl SubdivisionCell {
    /// Number of coefficients of each list.
    fn length(&self) -> usize {
        (self.degrees.0 + 1) * (self.degrees.1 + 1)
    }

    /// The place of a point of the cell in the leaf.
    fn at(&self, local: DVec2) -> DVec2 {
        self.from + self.width * local
    }
}

/// Result of a test of a cell for roots.
enum CellClass {
    /// No root.
    Excluded,
    /// One at most.
    Certified(Certificate),
    /// All coefficients are zero to within rounding, or those across the only direction of the projection.
    Flat,
    /// Unknown; with the means of the derivatives.
    Open { across_x: bool, slopes: [DVec2; 2] },
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
    let mut search = LeafSubdivision { patch, space, noise, lists, stack: vec![whole], flats: Vec::new() };
    let mut count = 0;
    while let Some(cell) = search.stack.pop() {
        count += 1;
        scratch.examined += 1;
        if count > MOST_CELLS {
            scratch.undecided += 1;
            return;
        }
        search.examine(cell, scratch);
    }
    join(search.flats, patch, space, &mut scratch.roots);
}

/// The state of the subdivision of a leaf.
struct LeafSubdivision<'a, P> {
    patch: &'a P,
    space: &'a RaySpace,
    /// Bound on the rounding of the coefficients, per weight.
    noise: f64,
    /// Two, or three with weights.
    lists: usize,
    stack: Vec<SubdivisionCell>,
    flats: Vec<FlatCell>,
}

impl<P: SubdividablePatch> LeafSubdivision<'_, P> {
    /// Excludes the last cell in memory, adds its roots, or puts its parts on the stack.
    fn examine(&mut self, mut cell: SubdivisionCell, scratch: &mut SearchScratch) {
        let n = cell.length();
        scratch.cells.truncate(cell.start + self.lists * n);
        let (both, weights) = scratch.cells[cell.start..].split_at(2 * n);
        // The largest weight of the cell bounds the noise of all its coefficients.
        let weight = if weights.is_empty() { 1.0 } else { range(weights.iter().copied()).1 };
        let exact = self.noise * cell.factor * weight;
        let noise = exact + cell.reduction;
        let (across_x, slopes) = match examine(both, cell.degrees, noise) {
            CellClass::Excluded => return,
            CellClass::Certified(certificate) => {
                let (first, second) = both.split_at(n);
                let mut map = CellPolynomials { lists: [first, second], degrees: cell.degrees };
                let bounds =
                    MapBounds { noise, curvature_bound: f64::INFINITY, weights: [1.0; 2], steps: MOST_STEPS };
                let found = contract(&mut map, &certificate, &bounds, DVec2::ZERO);
                scratch.undecided += u64::from(found.is_err());
                if let Ok(Some(LocalRoot { at, uncertainty })) = found {
                    let half = 0.5 * cell.width;
                    self.add(cell.from + half * (at + DVec2::ONE), uncertainty * half, &cell, scratch);
                }
                return;
            }
            CellClass::Flat => {
                self.flats.push(FlatCell::new(self.patch, self.space, &cell));
                return;
            }
            CellClass::Open { across_x, slopes } => (across_x, slopes),
        };
        for along_x in [true, false] {
            // Only halving lowers the degree.
            if cell.halved.is_some_and(|across_x| across_x != along_x) {
                continue;
            }
            let most = MOST_REDUCTION * exact;
            if let Some((degrees, error)) =
                degree_reduction::reduce(&mut scratch.cells, cell.start, cell.degrees, along_x, most)
            {
                (cell.degrees, cell.reduction) = (degrees, cell.reduction + error);
            }
        }
        if self.deflate(&mut cell, noise, scratch) {
            self.stack.push(cell);
            return;
        }
        let both = &scratch.cells[cell.start..cell.start + 2 * cell.length()];
        let (first, second) = both.split_at(cell.length());
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
        let [low, high] = halve(&cell, across_x, self.lists * cell.length());
        if low.width.min_element() < f64::EPSILON {
            let middle = cell.at(DVec2::splat(0.5));
            self.add(middle, DVec2::splat(TANGENT_UNCERTAINTY), &cell, scratch);
        } else {
            split(&mut scratch.cells, cell.start, cell.degrees, across_x);
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
                    // Weights only bound the rounding.
                    divided.push(list[j * (p + 1) + i] * if number < 2 { share } else { 1.0 });
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

/// A cell that is projected to a line or a point.
#[derive(Clone, Copy, Debug)]
struct FlatCell {
    /// Where a root is expected.
    place: DVec2,
    middle: DVec2,
    width: DVec2,
    /// Its length along the ray, metres.
    stretch: f64,
    /// Bound on the shift of a root in it by rounding.
    uncertainty: DVec2,
}

impl FlatCell {
    /// The points of the cell with the same projection lie along the direction in the parameters whose projection vanishes.
    fn new(patch: &impl SubdividablePatch, space: &RaySpace, cell: &SubdivisionCell) -> Self {
        let middle = cell.from + cell.width * 0.5;
        let tangent = patch.jet(middle.x, middle.y);
        let (along_x, along_y) = (tangent.su * cell.width.x, tangent.sv * cell.width.y);
        let (a, b) = (space.across(along_x), space.across(along_y));
        let seen = if a.length_squared() >= b.length_squared() { a } else { b };
        // A projection within rounding is a point.
        let clear = seen.length() > 4.0 * patch.noise(space);
        let unseen = DVec2::new(-b.dot(seen), a.dot(seen));
        let unseen = unseen / unseen.abs().max_element();
        let (stretch, unseen) = if clear && unseen.is_finite() {
            ((along_x * unseen.x + along_y * unseen.y).length(), unseen.abs())
        } else {
            (along_x.length() + along_y.length(), DVec2::ONE)
        };
        let steepness = DVec2::new(tangent.su.length(), tangent.sv.length());
        let uncertainty = cell.width * unseen + 64.0 * patch.noise(space) / steepness;
        Self { place: middle, middle, width: cell.width, stretch, uncertainty }
    }

    /// The cell of a part of the contact curve.
    fn of_arc(
        patch: &impl SubdividablePatch,
        space: &RaySpace,
        cell: &SubdivisionCell,
        arc: &ArcRoot,
    ) -> Self {
        let [a, b] = arc.ends.map(|end| cell.at(end.clamp(DVec2::ZERO, DVec2::ONE)));
        let place = cell.at(arc.at.clamp(DVec2::ZERO, DVec2::ONE));
        let width = (b - a).abs() + 1e-6 * cell.width;
        let uncertainty = (arc.uncertainty * cell.width).min((b - a).abs()) + rounding(patch, space, place);
        Self { place, middle: 0.5 * (a + b), width, stretch: chord(patch, a, b), uncertainty }
    }

    /// The edge of a cell.
    fn of_edge(
        patch: &impl SubdividablePatch,
        space: &RaySpace,
        cell: &SubdivisionCell,
        across_x: bool,
        upper: bool,
    ) -> Self {
        let side = f64::from(u8::from(upper));
        let at = |x: f64| cell.at(if across_x { DVec2::new(side, x) } else { DVec2::new(x, side) });
        let (a, middle, b) = (at(0.0), at(0.5), at(1.0));
        let width = b - a;
        let uncertainty = width + rounding(patch, space, middle);
        let stretch = chord(patch, a, middle) + chord(patch, middle, b);
        Self { place: middle, middle, width, stretch, uncertainty }
    }

    fn touches(&self, other: &Self) -> bool {
        let apart = (self.middle - other.middle).abs();
        apart.cmple((self.width + other.width) * (0.5 + 1e-9)).all()
    }
}

/// Distance of two points of a leaf, metres.
fn chord(patch: &impl SubdividablePatch, a: DVec2, b: DVec2) -> f64 {
    patch.jet(a.x, a.y).s.distance(patch.jet(b.x, b.y).s)
}

/// Bound on the shift of a root at `place` by rounding where the surface is regular.
fn rounding(patch: &impl SubdividablePatch, space: &RaySpace, place: DVec2) -> DVec2 {
    let tangent = patch.jet(place.x, place.y);
    let steepness = DVec2::new(tangent.su.length(), tangent.sv.length());
    (64.0 * patch.noise(space) / steepness).min(DVec2::ONE)
}

/// Appends the roots of the flat cells, one for every short chain of them: a tangency, the neighbourhood of a collapsed edge,
/// or a sliver across the ray. Along a long chain the ray lies within the surface.
fn join(
    mut open: Vec<FlatCell>,
    patch: &impl SubdividablePatch,
    space: &RaySpace,
    roots: &mut Vec<SurfaceRoot>,
) {
    while let Some(first) = open.pop() {
        let mut chain = vec![first];
        let mut next = 0;
        while let Some(&link) = chain.get(next) {
            next += 1;
            open.retain(|other| {
                let touches = link.touches(other);
                if touches {
                    chain.push(*other);
                }
                !touches
            });
        }
        if chain.iter().map(|cell| cell.stretch).sum::<f64>() > TANGENT_LENGTH * space.noise {
            continue;
        }
        let (low, high) = chain.iter().fold((first.place, first.place), |(low, high), cell| {
            (low.min(cell.place), high.max(cell.place))
        });
        // From the middle outwards, until a cell has a root within rounding.
        let distance = |cell: &FlatCell| cell.place.distance_squared(0.5 * (low + high));
        chain.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        roots.extend(chain.iter().find_map(|cell| {
            // Roots within a few times this uncertainty count as one: no farther apart than twice the chain.
            let uncertainty = (0.25 * (cell.uncertainty + (high - low))).min(DVec2::ONE);
            polish(patch, space, cell.place, uncertainty, cell.width.max(uncertainty))
        }));
    }
}

fn halve(cell: &SubdivisionCell, across_x: bool, size: usize) -> [SubdivisionCell; 2] {
    let mut low = SubdivisionCell { halved: Some(across_x), ..*cell };
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

/// Replaces the cell at `start`, the last one, by its halves.
fn split(cells: &mut Vec<f64>, start: usize, (p, q): (usize, usize), across_x: bool) {
    let size = cells.len() - start;
    cells.resize(start + 2 * size, 0.0);
    let (low, high) = cells[start..].split_at_mut(size);
    let n = (p + 1) * (q + 1);
    let (rows, length, stride, step) =
        if across_x { (q + 1, p + 1, p + 1, 1) } else { (p + 1, q + 1, 1, p + 1) };
    for list in 0..size / n {
        for row in 0..rows {
            let first = list * n + row * stride;
            for k in 0..length {
                high[first + (length - 1 - k) * step] = low[first + (length - 1) * step];
                for i in (k + 1..length).rev() {
                    let at = first + i * step;
                    low[at] = 0.5 * (low[at - step] + low[at]);
                }
            }
        }
    }
}

/// Restricts polynomials to a part of the square. On entry the coefficients along v are consecutive, on return those along u.
pub(super) fn restrict(cells: &mut Vec<f64>, (p, q): (usize, usize), part: DyadicRect) {
    let ParameterRect { u, v } = part.rect();
    let (size, n) = (cells.len(), (p + 1) * (q + 1));
    cells.reserve(size);
    for start in (0..size).step_by(n) {
        restrict_columns(&mut cells[start..start + n], q + 1, u);
        for j in 0..=q {
            for i in 0..=p {
                cells.push(cells[start + i * (q + 1) + j]);
            }
        }
    }
    cells.drain(..size);
    for list in cells.chunks_exact_mut(n) {
        restrict_columns(list, p + 1, v);
    }
}

/// Restricts each column of a table to a part of [0, 1]: Bernstein coefficients, one in each row of `length` numbers. By de Casteljau's
/// algorithm at the upper end, then at the lower one; whole rows at a time, for vector instructions.
fn restrict_columns(rows: &mut [f64], length: usize, [low, high]: [f64; 2]) {
    let size = rows.len();
    if high < 1.0 {
        for k in 1..size / length {
            // Row after row from the last one, each with the one before it.
            for row in (k..size / length).rev() {
                let (before, here) = rows.split_at_mut(row * length);
                let before = &before[(row - 1) * length..];
                for (here, &before) in here[..length].iter_mut().zip(before) {
                    *here = (1.0 - high) * before + high * *here;
                }
            }
        }
    }
    if low > 0.0 {
        let x = low / high;
        for k in 1..size / length {
            for row in 0..size / length - k {
                let (here, behind) = rows.split_at_mut((row + 1) * length);
                let here = &mut here[row * length..];
                for (here, &behind) in here.iter_mut().zip(&behind[..length]) {
                    *here = (1.0 - x) * *here + x * behind;
                }
            }
        }
    }
}

/// Smallest and largest of a function of the coefficients.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn examine(cell: &[f64], (p, q): (usize, usize), noise: f64) -> CellClass {
    let (first, second) = cell.split_at(cell.len() / 2);
    let one_sided = |(low, high): (f64, f64), noise: f64| low > noise || high < -noise;
    let (range1, range2) = (range(first.iter().copied()), range(second.iter().copied()));
    if one_sided(range1, noise) || one_sided(range2, noise) {
        return CellClass::Excluded;
    }
    let at = |i: usize, j: usize| DVec2::new(first[j * (p + 1) + i], second[j * (p + 1) + i]);
    let coefficients = || first.iter().zip(second).map(|(&x, &y)| DVec2::new(x, y));
    // The mean of the derivatives; the sums telescope.
    let a = (0..=q).map(|j| at(p, j) - at(0, j)).sum::<DVec2>() / (q + 1) as f64;
    let b = (0..=p).map(|i| at(i, q) - at(i, 0)).sum::<DVec2>() / (p + 1) as f64;
    // Combinations in which one of the derivatives drops out: where both are parallel, the curvature remains.
    let (a_length, b_length) = (a.length(), b.length());
    let (across_b, across_a) =
        (range(coefficients().map(|f| cross(f, b))), range(coefficients().map(|f| cross(a, f))));
    if one_sided(across_b, 1.5 * noise * b_length) || one_sided(across_a, 1.5 * noise * a_length) {
        return CellClass::Excluded;
    }
    if is_one_sided(first, second, noise) {
        return CellClass::Excluded;
    }
    let spread = (range1.1 - range1.0).max(range2.1 - range2.0);
    let narrow = |(low, high): (f64, f64), noise: f64| low >= -noise && high <= noise;
    let seen = a_length.max(b_length);
    if spread <= 2.0 * noise
        || (seen >= 0.25 * spread
            && narrow(across_b, 2.0 * noise * b_length)
            && narrow(across_a, 2.0 * noise * a_length))
    {
        return CellClass::Flat;
    }
    let det = cross(a, b);
    // Largest entries of J0^-1 J - I over the cell, bounded by the coefficients of the derivatives.
    let mut deviations = [0.0_f64; 4];
    let mut rises = [0.0_f64; 2];
    for j in 0..=q {
        for i in 0..=p {
            if i < p {
                let du = (at(i + 1, j) - at(i, j)) * p as f64;
                rises[0] = rises[0].max(du.length_squared());
                let du = du - a;
                deviations[0] = deviations[0].max(cross(du, b).abs());
                deviations[1] = deviations[1].max(cross(a, du).abs());
            }
            if j < q {
                let dv = (at(i, j + 1) - at(i, j)) * q as f64;
                rises[1] = rises[1].max(dv.length_squared());
                let dv = dv - b;
                deviations[2] = deviations[2].max(cross(dv, b).abs());
                deviations[3] = deviations[3].max(cross(a, dv).abs());
            }
        }
    }
    let deviation = (deviations[0] + deviations[2]).max(deviations[1] + deviations[3]);
    // If rounding may move the root by more than a part of the cell, it is next to a tangency: smaller cells are flat.
    let clear = noise * seen <= MOST_UNCERTAINTY * det.abs();
    if clear && deviation < CERTIFIED * det.abs() {
        // By (s, t), whose interval is twice as long.
        return CellClass::Certified(Certificate { a: 0.5 * a, b: 0.5 * b, q: deviation / det.abs() });
    }
    // Along the direction in which the coefficients vary more, so that projected cells become as wide as long.
    CellClass::Open { across_x: rises[0] >= rises[1], slopes: [a, b] }
}

/// Whether all coefficients lie on one side of a line at a distance of more than the noise from 0: that across the bisector of the
/// outermost directions, if they enclose less than half a turn.
fn is_one_sided(first: &[f64], second: &[f64], noise: f64) -> bool {
    let mut points = first.iter().zip(second).map(|(&x, &y)| DVec2::new(x, y));
    let Some(start) = points.next() else { return false };
    let (mut right, mut left) = (start, start);
    for point in points {
        let (beyond_right, beyond_left) = (cross(right, point) < 0.0, cross(left, point) > 0.0);
        if beyond_right && beyond_left {
            return false;
        }
        if beyond_right {
            right = point;
        } else if beyond_left {
            left = point;
        }
        if cross(right, left) < 0.0 {
            return false;
        }
    }
    let across = right.normalize_or_zero() + left.normalize_or_zero();
    let limit = noise * across.length();
    limit > 0.0 && first.iter().zip(second).all(|(x, y)| across.x * x + across.y * y > limit)
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

/// The root of the leaf itself next to `place`, a root of its coefficients.
fn polish(
    patch: &impl SubdividablePatch,
    space: &RaySpace,
    place: DVec2,
    uncertainty: DVec2,
    width: DVec2,
) -> Option<SurfaceRoot> {
    let mut x = place.clamp(DVec2::ZERO, DVec2::ONE);
    let noise = patch.noise(space);
    // The distance of the best point from the ray, and the largest that is accepted.
    let mut best: Option<(f64, f64, SurfaceRoot)> = None;
    for _ in 0..12 {
        let tangent = patch.jet(x.x, x.y);
        let from = tangent.s - space.line.origin;
        let f = space.across(from);
        if best.is_none_or(|(least, ..)| f.length() < least) {
            let distance_uncertainty =
                uncertainty.x * tangent.su.length() + uncertainty.y * tangent.sv.length();
            let root =
                SurfaceRoot { s: space.line.direction.dot(from), at: x, uncertainty, distance_uncertainty };
            // Next to a small weight one bit of a parameter is far on the surface.
            let bit = f64::EPSILON * (tangent.su.length() * x.x + tangent.sv.length() * x.y);
            best = Some((f.length(), BESIDE * space.noise + 4.0 * bit, root));
        }
        if f.length() <= noise {
            break;
        }
        let (ju, jv) = (space.across(tangent.su), space.across(tangent.sv));
        // Least squares of least length: at a tangency the Jacobian has no inverse.
        let (uu, uv, vv) = (ju.length_squared(), ju.dot(jv), jv.length_squared());
        let damping = 1e-26 * (uu + vv);
        let det = (uu + damping) * (vv + damping) - uv * uv;
        let (fu, fv) = (ju.dot(f), jv.dot(f));
        let step = DVec2::new((vv + damping) * fu - uv * fv, (uu + damping) * fv - uv * fu) / det;
        let next = (x - step).clamp(DVec2::ZERO, DVec2::ONE);
        // The iteration must not converge to another root.
        if !next.is_finite() || (next - place).abs().cmpgt((64.0 * uncertainty).max(width)).any() {
            break;
        }
        x = next;
    }
    best.and_then(|(off, most, root)| (off <= most).then_some(root))
}
