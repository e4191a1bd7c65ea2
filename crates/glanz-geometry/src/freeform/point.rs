//! What a freeform surface looks like at its points, and how they are picked.

use glanz_math::{AreaPdf, DVec2, DVec3};

use super::leaf::Leaf;
use super::net::{Jet, jet, jet_by};
use super::part::Rect;
use super::subpatches::Place;
use super::{Freeform, Piece};
use crate::bilinear::sample_linear;
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::trim::{Containment, TrimRegion};

/// Gauss-Legendre points and weights of order 4 on [0, 1]: exact up to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// A normal S_x x S_y that is shorter than this, in terms of the square of the patch's size, has lost half of its digits.
const COLLAPSED: f64 = 1e-8;

/// Parts along each side into which a leaf that a trimming curve crosses is cut for its area.
const PARTS: u32 = 32;

/// A search believes points this many times its noise beside the ray, seen across it: up to eight times, and as much
/// for the rounding of the leaves.
const ERROR: f64 = 16.0;

/// Leaves by area, to pick points from.
#[derive(Debug)]
pub(super) struct Areas {
    /// In ascending order of the piece.
    leaves: Vec<AreaLeaf>,
    /// Mass of the first 1, 2 ... of them, m^2: their areas, if |S_u x S_v| were bilinear in each.
    sums: Vec<f64>,
    /// m^2.
    total: f64,
}

#[derive(Debug)]
struct AreaLeaf {
    piece: u32,
    rect: Rect,
    /// |S_u x S_v| by the parameters of the patch at the corners (0, 0), (1, 0), (0, 1), (1, 1).
    corners: [f64; 4],
}

impl Areas {
    pub(super) fn total(&self) -> f64 {
        self.total
    }

    fn mass(&self) -> f64 {
        self.sums.last().copied().unwrap_or_default()
    }
}

impl AreaLeaf {
    fn new(surface: &Freeform, piece: u32, rect: Rect) -> Self {
        let at = |x, y| {
            let (u, v) = rect.at(x, y);
            surface.pieces.get(piece as usize).map_or(0.0, |piece| stretch(piece, u, v))
        };
        Self { piece, rect, corners: [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)] }
    }

    /// The part of the parameters that it covers.
    fn spread(&self) -> f64 {
        (self.rect.u[1] - self.rect.u[0]) * (self.rect.v[1] - self.rect.v[0])
    }

    fn mass(&self) -> f64 {
        0.25 * self.corners.iter().sum::<f64>() * self.spread()
    }

    /// The bilinear stand-in for |S_u x S_v| at the parameters of the patch.
    fn bilinear(&self, u: f64, v: f64) -> f64 {
        let Rect { u: [u0, u1], v: [v0, v1] } = self.rect;
        let (x, y) = ((u - u0) / (u1 - u0), (v - v0) / (v1 - v0));
        let [a, b, c, d] = self.corners;
        (a + (b - a) * x) * (1.0 - y) + (c + (d - c) * x) * y
    }
}

/// |S_u x S_v| by the parameters of the patch.
fn stretch(piece: &Piece, u: f64, v: f64) -> f64 {
    let jet = jet(piece.patch.control_points(), piece.patch.degrees(), u, v);
    jet.su.cross(jet.sv).length()
}

impl Freeform {
    pub(super) fn areas(&self) -> &Areas {
        self.areas.get_or_init(|| {
            let whole = |leaf: &Leaf| {
                let Place { piece, part } = *self.places.get(leaf.subpatch as usize)?;
                Some((piece, leaf.part.within(part).rect()))
            };
            let mut leaves: Vec<(u32, Rect)> = self.leaves.iter().filter_map(whole).collect();
            leaves.sort_by(|(a, ra), (b, rb)| {
                a.cmp(b).then(ra.u[0].total_cmp(&rb.u[0])).then(ra.v[0].total_cmp(&rb.v[0]))
            });
            let area = |(piece, rect): &(u32, Rect)| {
                let piece = self.pieces.get(*piece as usize);
                piece.map_or(0.0, |piece| leaf_area(piece, rect, self.region.as_deref()))
            };
            let total = leaves.iter().map(area).sum();
            let leaves: Vec<_> =
                leaves.into_iter().map(|(piece, rect)| AreaLeaf::new(self, piece, rect)).collect();
            let mut sum = 0.0;
            let sums = leaves.iter().map(|leaf| {
                sum += leaf.mass();
                sum
            });
            Areas { sums: sums.collect(), leaves, total }
        })
    }

    pub(super) fn sample_area(&self, xi: DVec2) -> Option<SurfaceSample> {
        let areas = self.areas();
        let target = xi.x * areas.mass();
        let index = areas.sums.partition_point(|&sum| sum <= target).min(areas.leaves.len().checked_sub(1)?);
        let leaf = areas.leaves.get(index)?;
        let (mass, [a, b, c, d]) = (leaf.mass(), leaf.corners);
        if mass <= 0.0 {
            return None;
        }
        // What is left of the number that picked the leaf picks u.
        let rest = ((target - (areas.sums.get(index)? - mass)) / mass).clamp(0.0, 1.0_f64.next_down());
        let y = sample_linear(xi.y, a + b, c + d);
        let x = sample_linear(rest, a * (1.0 - y) + c * y, b * (1.0 - y) + d * y);
        let (u, v) = leaf.rect.at(x, y);
        let within = |x: f64, [low, high]: [f64; 2]| x.clamp(low, high.next_down());
        let (u, v) = (within(u, leaf.rect.u), within(v, leaf.rect.v));
        let hit = Hit { t: 0.0, u, v, face: leaf.piece };
        Some(SurfaceSample { hit, point: self.point_at(leaf.piece, u, v), pdf: self.density_in(leaf, &hit)? })
    }

    /// Square metres per unit of the parameters of a piece.
    pub(crate) fn stretch_at(&self, face: u32, x: f64, y: f64) -> f64 {
        self.pieces.get(face as usize).map_or(0.0, |piece| stretch(piece, x, y))
    }

    pub(super) fn density(&self, hit: &Hit) -> Option<AreaPdf> {
        let areas = self.areas();
        let start = areas.leaves.partition_point(|leaf| leaf.piece < hit.face);
        let inside = |[low, high]: [f64; 2], x: f64| low <= x && (x < high || high == 1.0);
        let of_piece = areas.leaves.get(start..)?.iter().take_while(|leaf| leaf.piece == hit.face);
        let leaf =
            of_piece.into_iter().find(|leaf| inside(leaf.rect.u, hit.u) && inside(leaf.rect.v, hit.v))?;
        self.density_in(leaf, hit)
    }

    fn density_in(&self, leaf: &AreaLeaf, hit: &Hit) -> Option<AreaPdf> {
        let piece = self.pieces.get(leaf.piece as usize)?;
        // At a collapsed edge both vanish: no more than its neighbourhood has.
        let stretch = stretch(piece, hit.u, hit.v).max(f64::MIN_POSITIVE);
        let mass = self.areas().mass();
        Some(AreaPdf((leaf.bilinear(hit.u, hit.v) / (mass * stretch)).min(1e6 / mass)))
    }

    pub(crate) fn point_at(&self, face: u32, x: f64, y: f64) -> SurfacePoint {
        // Hits are the surface's own; of a strange one the first piece answers.
        let Some(piece) = self.pieces.get(face as usize).or(self.pieces.first()) else { return nowhere() };
        let (points, degrees) = (piece.patch.control_points(), piece.patch.degrees());
        let here = jet_by(self.bvh.isa(), points, degrees, x, y);
        let n = here.su.cross(here.sv);
        let (length, size) = (n.length(), piece.extent());
        let is_regular = length > COLLAPSED * size * size;
        let collapsed = (!is_regular).then(|| beside(piece, x, y, &here));
        let (regular, normal, length) = match &collapsed {
            None => (&here, n * (1.0 / length), length),
            Some((beside, normal, length)) => (beside, *normal, *length),
        };
        let [by_u, by_v] = piece.rates(x, y);
        // What rounding leaves of a derivative along a collapsed edge has no direction.
        let steep = 1e2 * self.error();
        let [sx, sy] = [here.su, here.sv].map(|s| {
            if s.length_squared() > steep * steep { s - normal * normal.dot(s) } else { DVec3::ZERO }
        });
        let along = |rate: DVec2| sx * rate.x + sy * rate.y;
        let flip = if by_u.perp_dot(by_v) < 0.0 { -1.0 } else { 1.0 };
        let normal = normal * flip;
        let per = flip / length;
        // n = N / |N| with N = S_x x S_y; what is along n drops out.
        let bend = |rate: DVec2| {
            let Jet { su, sv, suu, suv, svv, .. } = *regular;
            let turn = (suu.cross(sv) + su.cross(suv)) * rate.x + (suv.cross(sv) + su.cross(svv)) * rate.y;
            let turn = turn * per;
            turn - normal * normal.dot(turn)
        };
        let bounds = self.bvh.bounds();
        SurfacePoint {
            position: here.s.clamp(bounds.min, bounds.max),
            error: DVec3::splat(self.error()),
            normal,
            shading_normal: normal,
            uv: piece.parameters(x, y),
            dpdu: along(by_u),
            dpdv: along(by_v),
            dndu: bend(by_u),
            dndv: bend(by_v),
        }
    }

    /// The absolute error per axis, metres.
    ///
    /// The origin of a ray that starts here is this point or near it, so that the noise is the one that `Sight` takes
    /// for an origin within the surface.
    fn error(&self) -> f64 {
        ERROR * self.sight.noise_within()
    }
}

/// At a collapsed edge or corner: a place with a normal next to it, the unit normal at (x, y), and the length of S_x x S_y
/// at that place.
#[cold]
fn beside(piece: &Piece, x: f64, y: f64, here: &Jet) -> (Jet, DVec3, f64) {
    let (points, degrees) = (piece.patch.control_points(), piece.patch.degrees());
    let size = piece.extent();
    // Where the normal vanishes, its derivative towards the middle of the patch has the direction of its neighbourhood.
    let Jet { su, sv, suu, suv, svv, .. } = *here;
    let (by_x, by_y) = (suu.cross(sv) + su.cross(suv), suv.cross(sv) + su.cross(svv));
    let rise = by_x * (0.5 - x) + by_y * (0.5 - y);
    let mut at = *here;
    for step in [1e-3, 1e-2, 0.1, 0.5] {
        at = jet(points, degrees, x + (0.5 - x) * step, y + (0.5 - y) * step);
        let n = at.su.cross(at.sv);
        if n.length() > COLLAPSED * size * size {
            let normal = if rise.length() > 1e-6 * size * size { rise } else { n };
            return (at, normal.normalize(), n.length());
        }
    }
    (at, su.cross(sv).try_normalize().unwrap_or(DVec3::Z), size * size)
}

/// The area of a part of a patch; of what a region keeps of it, by the parts of it that are kept at their points.
fn leaf_area(piece: &Piece, rect: &Rect, region: Option<&TrimRegion>) -> f64 {
    let [low, high] = piece.range(rect);
    match region.map(|region| (region, region.classify(low, high))) {
        Some((_, Containment::Outside)) => 0.0,
        Some((region, Containment::Crossed)) => {
            let part = |k: u32| (f64::from(k) / f64::from(PARTS), f64::from(k + 1) / f64::from(PARTS));
            let parts = (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (i, j)));
            let areas = parts.map(|(i, j)| {
                let ((x0, x1), (y0, y1)) = (part(i), part(j));
                let ((u0, v0), (u1, v1)) = (rect.at(x0, y0), rect.at(x1, y1));
                let part = Rect { u: [u0, u1], v: [v0, v1] };
                gauss(piece, &part, |u, v| region.contains(piece.parameters(u, v)))
            });
            areas.sum()
        }
        _ => gauss(piece, rect, |_, _| true),
    }
}

/// The integral of |S_u x S_v| over the points of a rectangle that are kept.
fn gauss(piece: &Piece, rect: &Rect, keeps: impl Fn(f64, f64) -> bool) -> f64 {
    let points = GAUSS.iter().flat_map(|&(x, wx)| GAUSS.iter().map(move |&(y, wy)| (x, y, wx * wy)));
    let sum: f64 = points
        .map(|(x, y, weight)| {
            let (u, v) = rect.at(x, y);
            if keeps(u, v) { weight * stretch(piece, u, v) } else { 0.0 }
        })
        .sum();
    sum * (rect.u[1] - rect.u[0]) * (rect.v[1] - rect.v[0])
}

/// What a surface without pieces, which cannot be built, would say.
fn nowhere() -> SurfacePoint {
    let zero = DVec3::ZERO;
    SurfacePoint {
        position: zero,
        error: zero,
        normal: DVec3::Z,
        shading_normal: DVec3::Z,
        uv: DVec2::ZERO,
        dpdu: zero,
        dpdv: zero,
        dndu: zero,
        dndv: zero,
    }
}
