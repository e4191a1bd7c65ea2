//! Areas of leaves, and random points with a density that is nearly uniform over the area.

use glanz_math::{AreaPdf, DVec2};

use super::Freeform;
use super::leaf::PatchLeaf;
use super::parameter_rect::ParameterRect;
use super::subpatches::SubpatchLocation;
use crate::bilinear::sample_linear;
use crate::hit::{Hit, SurfaceSample};
use crate::trim::Containment;

/// Gauss-Legendre points and weights of order 4 on [0, 1]: exact up to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Number of cells along each side for the area of a leaf that a trimming curve crosses.
const PARTS: u32 = 32;

/// The leaves with their areas, for sampling.
#[derive(Debug)]
pub(super) struct LeafAreas {
    /// Leaves in ascending order of the patch.
    leaves: Vec<SampledLeaf>,
    /// Mass of the first 1, 2 ... leaves, m^2: the area that they would have if |S_u x S_v| were bilinear in each.
    sums: Vec<f64>,
    /// Area, m^2.
    total: f64,
}

#[derive(Debug)]
struct SampledLeaf {
    patch: u32,
    rect: ParameterRect,
    /// |S_u x S_v| by the parameters of the patch at the corners (0, 0), (1, 0), (0, 1), (1, 1).
    corners: [f64; 4],
}

impl LeafAreas {
    pub(super) fn total(&self) -> f64 {
        self.total
    }

    fn mass(&self) -> f64 {
        self.sums.last().copied().unwrap_or_default()
    }
}

impl SampledLeaf {
    fn new(surface: &Freeform, patch: u32, rect: ParameterRect) -> Self {
        let at = |x, y| {
            let (u, v) = rect.at(x, y);
            surface.area_element_at(patch, u, v)
        };
        Self { patch, rect, corners: [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)] }
    }

    /// Its area in the parameters.
    fn parameter_area(&self) -> f64 {
        (self.rect.u[1] - self.rect.u[0]) * (self.rect.v[1] - self.rect.v[0])
    }

    fn mass(&self) -> f64 {
        0.25 * self.corners.iter().sum::<f64>() * self.parameter_area()
    }

    /// The bilinear approximation of |S_u x S_v| at parameters of the patch.
    fn bilinear(&self, u: f64, v: f64) -> f64 {
        let ParameterRect { u: [u0, u1], v: [v0, v1] } = self.rect;
        let (x, y) = ((u - u0) / (u1 - u0), (v - v0) / (v1 - v0));
        let [a, b, c, d] = self.corners;
        (a + (b - a) * x) * (1.0 - y) + (c + (d - c) * x) * y
    }
}

impl Freeform {
    pub(super) fn areas(&self) -> &LeafAreas {
        self.areas.get_or_init(|| {
            let whole = |leaf: &PatchLeaf| {
                let SubpatchLocation { patch, part } = self.location(leaf.subpatch);
                (patch, leaf.part.within(part).rect())
            };
            let mut leaves: Vec<(u32, ParameterRect)> = self.leaves.iter().map(whole).collect();
            leaves.sort_by(|(a, ra), (b, rb)| {
                a.cmp(b).then(ra.u[0].total_cmp(&rb.u[0])).then(ra.v[0].total_cmp(&rb.v[0]))
            });
            let area = |&(patch, ref rect): &(u32, ParameterRect)| self.leaf_area(patch, rect);
            let total = leaves.iter().map(area).sum();
            let leaves: Vec<_> =
                leaves.into_iter().map(|(patch, rect)| SampledLeaf::new(self, patch, rect)).collect();
            let mut sum = 0.0;
            let sums = leaves.iter().map(|leaf| {
                sum += leaf.mass();
                sum
            });
            LeafAreas { sums: sums.collect(), leaves, total }
        })
    }

    /// A random point, uniform over the area of the leaves up to their bilinear approximation.
    pub(super) fn sample_leaf(&self, xi: DVec2) -> Option<SurfaceSample> {
        let areas = self.areas();
        let target = xi.x * areas.mass();
        let index = areas.sums.partition_point(|&sum| sum <= target).min(areas.leaves.len().checked_sub(1)?);
        let leaf = areas.leaves.get(index)?;
        let (mass, [a, b, c, d]) = (leaf.mass(), leaf.corners);
        if mass <= 0.0 {
            return None;
        }
        // The rest of the number that selected the leaf selects u.
        let rest = ((target - (areas.sums.get(index)? - mass)) / mass).clamp(0.0, 1.0_f64.next_down());
        let y = sample_linear(xi.y, a + b, c + d);
        let x = sample_linear(rest, a * (1.0 - y) + c * y, b * (1.0 - y) + d * y);
        let (u, v) = leaf.rect.at(x, y);
        let within = |x: f64, [low, high]: [f64; 2]| x.clamp(low, high.next_down());
        let (u, v) = (within(u, leaf.rect.u), within(v, leaf.rect.v));
        let hit = Hit::new(0.0, u, v, leaf.patch);
        Some(SurfaceSample { hit, point: self.point_at(leaf.patch, u, v), pdf: self.density_in(leaf, &hit)? })
    }

    /// Area per unit of the parameters of a patch, m^2.
    pub(crate) fn area_element_at(&self, face: u32, x: f64, y: f64) -> f64 {
        self.first_order(face, x, y).map_or(0.0, |jet| jet.su.cross(jet.sv).length())
    }

    pub(super) fn density(&self, hit: &Hit) -> Option<AreaPdf> {
        let areas = self.areas();
        let start = areas.leaves.partition_point(|leaf| leaf.patch < hit.face);
        let inside = |[low, high]: [f64; 2], x: f64| low <= x && (x < high || high == 1.0);
        let of_patch = areas.leaves.get(start..)?.iter().take_while(|leaf| leaf.patch == hit.face);
        let leaf =
            of_patch.into_iter().find(|leaf| inside(leaf.rect.u, hit.u) && inside(leaf.rect.v, hit.v))?;
        self.density_in(leaf, hit)
    }

    fn density_in(&self, leaf: &SampledLeaf, hit: &Hit) -> Option<AreaPdf> {
        // At a collapsed edge both vanish: bounded as in its neighbourhood.
        let area_element = self.area_element_at(leaf.patch, hit.u, hit.v).max(f64::MIN_POSITIVE);
        let mass = self.areas().mass();
        Some(AreaPdf((leaf.bilinear(hit.u, hit.v) / (mass * area_element)).min(1e6 / mass)))
    }

    /// The area of a part of a patch; with a region, that of the kept quadrature points of its cells.
    fn leaf_area(&self, patch: u32, rect: &ParameterRect) -> f64 {
        let Some(placement) = self.patches.placement(patch) else { return 0.0 };
        let [low, high] = placement.range(rect);
        match self.region.as_deref().map(|region| (region, region.classify(low, high))) {
            Some((_, Containment::Outside)) => 0.0,
            Some((region, Containment::Crossed)) => {
                let part = |k: u32| (f64::from(k) / f64::from(PARTS), f64::from(k + 1) / f64::from(PARTS));
                let parts = (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (i, j)));
                let areas = parts.map(|(i, j)| {
                    let ((x0, x1), (y0, y1)) = (part(i), part(j));
                    let ((u0, v0), (u1, v1)) = (rect.at(x0, y0), rect.at(x1, y1));
                    let part = ParameterRect { u: [u0, u1], v: [v0, v1] };
                    self.gauss(patch, &part, |u, v| region.contains(placement.parameters(u, v)))
                });
                areas.sum()
            }
            _ => self.gauss(patch, rect, |_, _| true),
        }
    }

    /// The integral of |S_u x S_v| over the kept points of a rectangle.
    fn gauss(&self, patch: u32, rect: &ParameterRect, keeps: impl Fn(f64, f64) -> bool) -> f64 {
        let points = GAUSS.iter().flat_map(|&(x, wx)| GAUSS.iter().map(move |&(y, wy)| (x, y, wx * wy)));
        let sum: f64 = points
            .map(|(x, y, weight)| {
                let (u, v) = rect.at(x, y);
                if keeps(u, v) { weight * self.area_element_at(patch, u, v) } else { 0.0 }
            })
            .sum();
        sum * (rect.u[1] - rect.u[0]) * (rect.v[1] - rect.v[0])
    }
}
