//! The slow way to the roots of a leaf: its coefficients in the two planes through the ray are halved until a cell is
//! excluded, certified, or as small as rounding.
//!
//! In homogeneous coordinates the signed distances from the planes are polynomials even for rational leaves, so that a
//! weight costs one more product per coefficient and nothing below. Silhouettes, collapsed edges and leaves that are seen
//! edge-on come here.

use glanz_math::DVec2;

use super::contract::{Certificate, Jet, Limits, Map, Place, contract};
use super::net::{Bernstein, with_room};
use super::part::{Part, Rect};
use super::search::{Probe, Root, Scratch, Tangent, cross, weighted};

/// Largest contraction at which a cell is certified.
const CERTIFIED: f64 = 0.75;

/// Share of a cell by which rounding may move the root of a certified one, half of it.
const MOST_BLUR: f64 = 0.0625;

/// Steps in a certified cell: more than the contraction needs to the last bit.
const MOST_STEPS: usize = 200;

/// Cells of one leaf that are looked at before it is called undecided: a hundred times what tangencies need.
const MOST_CELLS: usize = 20_000;

/// Cells that are flat to rounding and seen edge-on, or seen as a point, are a tangency or a collapsed edge if
/// together they are shorter than this many times what rounding is across the ray; otherwise the ray runs within the
/// surface, which is no hit. Curvature of radius R is flat to rounding e over a length of sqrt(e R): with e of 1e-15
/// of the size, that is 3e-8 of it for R of the size, 3e-6 for ten thousand times as much. Along an asymptote of a
/// saddle, where a ray goes through the surface, it is (e R^2)^(1/3), 1e-5 of the size, and where that bends with it,
/// (e R^3)^(1/4), 2e-4.
const TANGENT_LENGTH: f64 = (1_u64 << 36) as f64;

/// Times its noise that a ray may pass beside a root.
const BESIDE: f64 = 14.0;

/// Parameters within which tangencies are one.
const TANGENT_BLUR: f64 = 1.0 / (1 << 18) as f64;

/// What is asked of a leaf here.
pub(super) trait Patch {
    /// Degrees of the coefficients of [`Patch::project`].
    fn degrees(&self) -> (usize, usize);
    /// Fills `cells` with the Bernstein coefficients of the signed distances, times weight, from both planes through the
    /// ray, that of (i, j) at j (p + 1) + i, and those of the weights if they are not all 1; returns what rounding may
    /// change in them per weight.
    fn project(&self, probe: &Probe, cells: &mut Vec<f64>) -> f64;
    /// Point and first derivatives at (x, y) in [0, 1]^2.
    fn tangent(&self, x: f64, y: f64) -> Tangent;
    /// Metres that this point may be off across the ray, by rounding.
    fn noise(&self, probe: &Probe) -> f64;
}

/// A rectangle of the leaf and where its coefficients start.
#[derive(Clone, Copy, Debug)]
struct Cell {
    from: DVec2,
    width: DVec2,
    start: usize,
}

/// What can be said of a cell.
enum Verdict {
    /// No root.
    Excluded,
    /// One at most.
    Certified(Certificate),
    /// All coefficients are zero to rounding, or those across the only direction that is seen.
    Flat,
    /// Nothing yet.
    Open { across_x: bool },
}

/// Every root of `patch`, into `scratch.roots`; some may be there twice, from cells that share a border.
#[cold]
pub(super) fn roots(patch: &impl Patch, probe: &Probe, scratch: &mut Scratch) {
    let degrees = patch.degrees();
    let noise = patch.project(probe, &mut scratch.cells);
    let (size, n) = (scratch.cells.len(), (degrees.0 + 1) * (degrees.1 + 1));
    let mut stack = vec![Cell { from: DVec2::ZERO, width: DVec2::ONE, start: 0 }];
    let mut flats = Vec::new();
    let mut count = 0;
    while let Some(cell) = stack.pop() {
        count += 1;
        if count > MOST_CELLS {
            scratch.undecided += 1;
            return;
        }
        scratch.cells.truncate(cell.start + size);
        let (both, weights) = scratch.cells[cell.start..].split_at(2 * n);
        // Next to small weights large ones are far away.
        let noise = noise * if weights.is_empty() { 1.0 } else { range(weights.iter().copied()).1 };
        let verdict = examine(both, degrees, noise);
        let found = match verdict {
            Verdict::Excluded => None,
            Verdict::Certified(certificate) => {
                let (first, second) = both.split_at(n);
                let map = Coefficients { lists: [first, second], degrees };
                let limits = Limits { noise, bend: f64::INFINITY, weights: [1.0; 2], steps: MOST_STEPS };
                let found = contract(&map, &certificate, &limits, DVec2::ZERO);
                scratch.undecided += u64::from(found.is_err());
                let half = 0.5 * cell.width;
                found
                    .ok()
                    .flatten()
                    .map(|Place { at, blur }| (cell.from + half * (at + DVec2::ONE), blur * half))
            }
            Verdict::Flat => {
                flats.push(FlatCell::new(patch, probe, &cell));
                None
            }
            Verdict::Open { across_x } => {
                let [low, high] = halve(&cell, across_x, size);
                if low.width.min_element() < f64::EPSILON {
                    Some((cell.from + cell.width * 0.5, DVec2::splat(TANGENT_BLUR)))
                } else {
                    split(&mut scratch.cells, cell.start, degrees, across_x);
                    stack.extend([low, high]);
                    None
                }
            }
        };
        if let Some((place, blur)) = found
            && let Some(root) = polish(patch, probe, place, blur, cell.width)
        {
            scratch.roots.push(root);
        }
    }
    join(flats, patch, probe, &mut scratch.roots);
}

/// A cell that looks like a line or a point.
#[derive(Clone, Copy, Debug)]
struct FlatCell {
    middle: DVec2,
    width: DVec2,
    /// Its length along the ray, metres.
    stretch: f64,
    /// By how much a root in it may be off.
    blur: DVec2,
}

impl FlatCell {
    /// Whatever of the cell looks like one point lies along the direction in the parameters that the ray does not see.
    fn new(patch: &impl Patch, probe: &Probe, cell: &Cell) -> Self {
        let middle = cell.from + cell.width * 0.5;
        let tangent = patch.tangent(middle.x, middle.y);
        let (along_x, along_y) = (tangent.su * cell.width.x, tangent.sv * cell.width.y);
        let (a, b) = (probe.across(along_x), probe.across(along_y));
        let seen = if a.length_squared() >= b.length_squared() { a } else { b };
        // What is seen at all must stand out from rounding, else the whole cell looks like a point.
        let clear = seen.length() > 4.0 * patch.noise(probe);
        let unseen = DVec2::new(-b.dot(seen), a.dot(seen));
        let unseen = unseen / unseen.abs().max_element();
        let (stretch, unseen) = if clear && unseen.is_finite() {
            ((along_x * unseen.x + along_y * unseen.y).length(), unseen.abs())
        } else {
            (along_x.length() + along_y.length(), DVec2::ONE)
        };
        let steepness = DVec2::new(tangent.su.length(), tangent.sv.length());
        let blur = cell.width * unseen + 64.0 * patch.noise(probe) / steepness;
        Self { middle, width: cell.width, stretch, blur }
    }

    fn touches(&self, other: &Self) -> bool {
        let apart = (self.middle - other.middle).abs();
        apart.cmple((self.width + other.width) * (0.5 + 1e-9)).all()
    }
}

/// The roots among the flat cells: one for every chain of them that is short. It is a root that rounding blurs: a tangency,
/// the neighbourhood of a collapsed edge, a sliver across the ray. Along a long one the ray runs within the surface.
fn join(mut open: Vec<FlatCell>, patch: &impl Patch, probe: &Probe, roots: &mut Vec<Root>) {
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
        if chain.iter().map(|cell| cell.stretch).sum::<f64>() > TANGENT_LENGTH * probe.noise {
            continue;
        }
        let (low, high) = chain.iter().fold((first.middle, first.middle), |(low, high), cell| {
            (low.min(cell.middle), high.max(cell.middle))
        });
        // From the middle outwards, until a cell has a root within rounding.
        let distance = |cell: &FlatCell| cell.middle.distance_squared(0.5 * (low + high));
        chain.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        roots.extend(chain.iter().find_map(|cell| {
            // Roots within a few times that are taken for one: no farther than twice the chain.
            let blur = (0.25 * (cell.blur + (high - low))).min(DVec2::ONE);
            polish(patch, probe, cell.middle, blur, cell.width)
        }));
    }
}

fn halve(cell: &Cell, across_x: bool, size: usize) -> [Cell; 2] {
    let (mut low, mut high) = (*cell, *cell);
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

/// Replaces lists of the coefficients (i, j) at j (p + 1) + i by those of a part of the square.
pub(super) fn restrict(lists: &mut [f64], (p, q): (usize, usize), part: Part) {
    let Rect { u, v } = part.rect();
    for list in lists.chunks_exact_mut((p + 1) * (q + 1)) {
        for row in 0..=q {
            restrict_row(list, row * (p + 1), 1, p, u);
        }
        for column in 0..=p {
            restrict_row(list, column, p + 1, q, v);
        }
    }
}

/// One row of coefficients, by de Casteljau's scheme at the upper end and then at the lower one.
fn restrict_row(list: &mut [f64], first: usize, step: usize, degree: usize, [low, high]: [f64; 2]) {
    let at = |i: usize| first + i * step;
    for (x, upper) in [(high, false), (low / high, true)] {
        for k in 0..degree {
            if upper {
                for i in 0..degree - k {
                    list[at(i)] = (1.0 - x) * list[at(i)] + x * list[at(i + 1)];
                }
            } else {
                for i in (k + 1..=degree).rev() {
                    list[at(i)] = (1.0 - x) * list[at(i - 1)] + x * list[at(i)];
                }
            }
        }
    }
}

/// Smallest and largest of a function of the coefficients.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn examine(cell: &[f64], (p, q): (usize, usize), noise: f64) -> Verdict {
    let (first, second) = cell.split_at(cell.len() / 2);
    let one_sided = |(low, high): (f64, f64), noise: f64| low > noise || high < -noise;
    let (range1, range2) = (range(first.iter().copied()), range(second.iter().copied()));
    if one_sided(range1, noise) || one_sided(range2, noise) {
        return Verdict::Excluded;
    }
    let at = |i: usize, j: usize| DVec2::new(first[j * (p + 1) + i], second[j * (p + 1) + i]);
    let coefficients = || first.iter().zip(second).map(|(&x, &y)| DVec2::new(x, y));
    // The mean of the derivatives; the sums telescope.
    let a = (0..=q).map(|j| at(p, j) - at(0, j)).sum::<DVec2>() / (q + 1) as f64;
    let b = (0..=p).map(|i| at(i, q) - at(i, 0)).sum::<DVec2>() / (p + 1) as f64;
    // Combined so that one of the derivatives drops out: where both are parallel, what is left is the curvature.
    let (a_length, b_length) = (a.length(), b.length());
    let (across_b, across_a) =
        (range(coefficients().map(|f| cross(f, b))), range(coefficients().map(|f| cross(a, f))));
    if one_sided(across_b, 1.5 * noise * b_length) || one_sided(across_a, 1.5 * noise * a_length) {
        return Verdict::Excluded;
    }
    let spread = (range1.1 - range1.0).max(range2.1 - range2.0);
    let narrow = |(low, high): (f64, f64), noise: f64| low >= -noise && high <= noise;
    let seen = a_length.max(b_length);
    if spread <= 2.0 * noise
        || (seen >= 0.25 * spread
            && narrow(across_b, 2.0 * noise * b_length)
            && narrow(across_a, 2.0 * noise * a_length))
    {
        return Verdict::Flat;
    }
    let det = cross(a, b);
    // Largest entries of J0^-1 J - I over the cell, whose derivatives their coefficients bound.
    let mut strays = [0.0_f64; 4];
    let mut rises = [0.0_f64; 2];
    for j in 0..=q {
        for i in 0..=p {
            if i < p {
                let du = (at(i + 1, j) - at(i, j)) * p as f64;
                rises[0] = rises[0].max(du.length_squared());
                let du = du - a;
                strays[0] = strays[0].max(cross(du, b).abs());
                strays[1] = strays[1].max(cross(a, du).abs());
            }
            if j < q {
                let dv = (at(i, j + 1) - at(i, j)) * q as f64;
                rises[1] = rises[1].max(dv.length_squared());
                let dv = dv - b;
                strays[2] = strays[2].max(cross(dv, b).abs());
                strays[3] = strays[3].max(cross(a, dv).abs());
            }
        }
    }
    let stray = (strays[0] + strays[2]).max(strays[1] + strays[3]);
    // A root that rounding may move by more than a part of the cell is next to a tangency: smaller cells are flat.
    let clear = noise * seen <= MOST_BLUR * det.abs();
    if clear && stray < CERTIFIED * det.abs() {
        // By (s, t), which go twice as far.
        return Verdict::Certified(Certificate { a: 0.5 * a, b: 0.5 * b, q: stray / det.abs() });
    }
    // Where the coefficients vary more, so that cells become as wide as long, seen along the ray.
    Verdict::Open { across_x: rises[0] >= rises[1] }
}

/// The coefficients of a cell as a map of [-1, 1]^2.
struct Coefficients<'a> {
    lists: [&'a [f64]; 2],
    degrees: (usize, usize),
}

impl Map for Coefficients<'_> {
    fn jet(&self, x: DVec2) -> Jet {
        let (p, q) = self.degrees;
        let z = 0.5 * (x + DVec2::ONE);
        let sums = with_room!(p.max(q), N => {
            let (x, y) = (Bernstein::<N>::new(p, z.x), Bernstein::<N>::new(q, z.y));
            let (bx, dx, by, dy) = (x.values(), x.rises(), y.values(), y.rises());
            self.lists.map(|list| weighted(list, p + 1, &bx, &dx, &by, &dy))
        });
        let at = |k: usize| DVec2::new(sums[0][k], sums[1][k]);
        Jet { f: at(0), fs: 0.5 * at(1), ft: 0.5 * at(2) }
    }

    /// The noise of a cell is that of its coefficients, weights included.
    fn weight(&self, _: DVec2) -> f64 {
        1.0
    }
}

/// The root of the leaf itself next to `place`, a root of its projection.
fn polish(patch: &impl Patch, probe: &Probe, place: DVec2, blur: DVec2, width: DVec2) -> Option<Root> {
    let mut x = place.clamp(DVec2::ZERO, DVec2::ONE);
    let noise = patch.noise(probe);
    // How far beside the ray the best place is, and by how much it may be.
    let mut best: Option<(f64, f64, Root)> = None;
    for _ in 0..12 {
        let tangent = patch.tangent(x.x, x.y);
        let from = tangent.s - probe.line.origin;
        let f = probe.across(from);
        if best.is_none_or(|(least, ..)| f.length() < least) {
            let reach = blur.x * tangent.su.length() + blur.y * tangent.sv.length();
            let root = Root { s: probe.line.direction.dot(from), at: x, blur, reach };
            // Next to a small weight a bit of a parameter is far on the surface.
            let bit = f64::EPSILON * (tangent.su.length() * x.x + tangent.sv.length() * x.y);
            best = Some((f.length(), BESIDE * probe.noise + 4.0 * bit, root));
        }
        if f.length() <= noise {
            break;
        }
        let (ju, jv) = (probe.across(tangent.su), probe.across(tangent.sv));
        // Least squares of least length: at a tangency the Jacobian has no inverse.
        let (uu, uv, vv) = (ju.length_squared(), ju.dot(jv), jv.length_squared());
        let damping = 1e-26 * (uu + vv);
        let det = (uu + damping) * (vv + damping) - uv * uv;
        let (fu, fv) = (ju.dot(f), jv.dot(f));
        let step = DVec2::new((vv + damping) * fu - uv * fv, (uu + damping) * fv - uv * fu) / det;
        let next = (x - step).clamp(DVec2::ZERO, DVec2::ONE);
        // It must stay the root that was certified.
        if !next.is_finite() || (next - place).abs().cmpgt((64.0 * blur).max(width)).any() {
            break;
        }
        x = next;
    }
    best.and_then(|(off, most, root)| (off <= most).then_some(root))
}
