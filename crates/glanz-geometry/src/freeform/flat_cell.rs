//! Cells of a leaf that are a point or a line to within rounding: tangencies, points at which the surface is singular, curves along the
//! ray; and the root of the surface itself next to one of its coefficients.

use glanz_math::DVec2;

use super::contact_arc::ArcRoot;
use super::ray_space::RaySpace;
use super::root::SurfaceRoot;
use super::subdivision::{SubdividablePatch, SubdivisionCell};

/// Largest total length of flat cells, in units of the noise, that is a root. Cells that are flat to within rounding and
/// projected to a line or a point are a tangency or a collapsed edge if they are shorter than this; otherwise the ray lies
/// within the surface, which is no hit. Curvature of radius R is flat to within rounding e over a length of sqrt(e R): with
/// e of 1e-15 of the size, 3e-8 of the size for R of the size, and 3e-6 for R ten thousand times as large. Along an
/// asymptote of a saddle, where the ray passes through the surface, it is (e R^2)^(1/3), 1e-5 of the size; where the
/// asymptotic curve has an inflection, (e R^3)^(1/4), 2e-4.
const TANGENT_LENGTH: f64 = (1_u64 << 36) as f64;

/// Largest distance of a root from the ray, in units of the noise.
const BESIDE: f64 = 14.0;

/// A cell that is projected to a line or a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatCell {
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
    pub(super) fn new(patch: &impl SubdividablePatch, space: &RaySpace, cell: &SubdivisionCell) -> Self {
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
    pub(super) fn of_arc(
        patch: &impl SubdividablePatch,
        space: &RaySpace,
        cell: &SubdivisionCell,
        arc: &ArcRoot,
    ) -> Self {
        let [a, b] = arc.ends.map(|end| cell.at(end.clamp(DVec2::ZERO, DVec2::ONE)));
        let place = cell.at(arc.at.clamp(DVec2::ZERO, DVec2::ONE));
        let width = (b - a).abs() + 1e-6 * cell.width;
        let uncertainty = (arc.uncertainty * cell.width).min((b - a).abs()) + rounding(patch, space, place);
        // By its middle: a surface that is folded onto itself turns back.
        let stretch = chord(patch, a, place) + chord(patch, place, b);
        Self { place, middle: 0.5 * (a + b), width, stretch, uncertainty }
    }

    /// The edge of a cell.
    pub(super) fn of_edge(
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
pub(super) fn join(
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

/// The root of the leaf itself next to `place`, a root of its coefficients.
pub(super) fn polish(
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
