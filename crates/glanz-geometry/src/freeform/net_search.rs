//! The roots of a ray with a leaf of any degree, point by point.
//!
//! The search has three steps, each more expensive and rarer than the one before.
//!
//! 1. *The thick parallelogram* ([`PatchLeaf::project`]). If the ray passes the projected parallelogram at more than its
//!    thickness, there is no root.
//! 2. *The certificate* ([`contract`]). If the Jacobian of the leaf, projected along the ray, deviates from that of the
//!    parallelogram by a factor q < 1, the map is injective and its simplified Newton step contracts by q. Clamped to the
//!    parameter square it still does, so that its fixed point is either the only root or proof that there is none.
//! 3. *Subdivision* ([`subdivision`]). The coefficients are halved until every cell is excluded, certified, or as small as
//!    rounding.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::cell_coefficients;
use super::contraction::{LocalRoot, MapBounds, NoConvergence, PlanarJet, PlanarMap, contract};
use super::control_net;
use super::leaf::{LeafProjection, PatchLeaf};
use super::parameter_rect::DyadicRect;
use super::ray_space::RaySpace;
use super::reduced_net::ReducedNet;
use super::root::{FirstOrderJet, SearchScratch, SurfaceRoot};
use super::subdivision::{self, SubdividablePatch};
use crate::bvh::simd::Simd;

/// Steps in a certified leaf. Leaves that contract too slowly for that are subdivided.
const MOST_STEPS: usize = 24;

/// The homogeneous control points of a subpatch, that of (i, j) at i (q + 1) + j.
#[derive(Clone, Copy, Debug)]
pub(super) struct HomogeneousNet<'a> {
    /// Degrees.
    pub(super) degrees: (usize, usize),
    pub(super) points: &'a [DVec4],
    /// Whether not all weights are 1.
    pub(super) rational: bool,
}

/// A leaf of any degree: a part of a net.
#[derive(Clone, Copy, Debug)]
struct NetLeaf<'a> {
    net: HomogeneousNet<'a>,
    part: DyadicRect,
    reduced: Option<&'a ReducedNet>,
}

impl SubdividablePatch for NetLeaf<'_> {
    fn degrees(&self) -> (usize, usize) {
        self.reduced.map_or(self.net.degrees, |reduced| reduced.degrees)
    }

    fn project(&self, space: &RaySpace, cells: &mut Vec<f64>) -> f64 {
        let HomogeneousNet { degrees, points, rational } = self.net;
        if let Some(reduced) = self.reduced {
            return reduced.project(rational, space, cells);
        }
        space.project_net(points, rational, cells);
        cell_coefficients::restrict(cells, degrees, self.part);
        2.0 * space.noise
    }

    fn jet(&self, x: f64, y: f64) -> FirstOrderJet {
        let (at, width) = (self.part.at(DVec2::new(x, y)), self.part.width());
        let jet = control_net::second_order_jet(self.net.points, self.net.degrees, at.x, at.y);
        FirstOrderJet { s: jet.s, su: jet.su * width.x, sv: jet.sv * width.y }
    }

    fn noise(&self, space: &RaySpace) -> f64 {
        space.noise
    }
}

/// A leaf of any degree as a map to the plane across the ray.
struct ProjectedNet<'a, S> {
    simd: S,
    net: HomogeneousNet<'a>,
    /// Centre and half sides of the leaf, in [0, 1]^2.
    middle: DVec2,
    half: DVec2,
    space: &'a RaySpace,
    /// The last point in (s, t) at which the surface was evaluated.
    last: DVec2,
    /// The surface there, with the last derivatives.
    surface: FirstOrderJet,
}

impl<S: Simd> PlanarMap for ProjectedNet<'_, S> {
    const HAS_VALUE: bool = true;

    #[inline(always)]
    fn jet(&mut self, x: DVec2) -> PlanarJet {
        (self.last, self.surface) = (x, self.surface_jet::<true>(x));
        let Self { half, space, surface: FirstOrderJet { s, su, sv }, .. } = *self;
        PlanarJet {
            f: space.across(s - space.line.origin),
            fs: half.x * space.across(su),
            ft: half.y * space.across(sv),
        }
    }

    #[inline(always)]
    fn value(&mut self, x: DVec2) -> DVec2 {
        (self.last, self.surface.s) = (x, self.surface_jet::<false>(x).s);
        self.space.across(self.surface.s - self.space.line.origin)
    }

    #[inline(always)]
    fn weight(&self, _: DVec2) -> f64 {
        1.0
    }
}

impl<S: Simd> ProjectedNet<'_, S> {
    /// The surface at (s, t) of the leaf, and its derivatives by the parameters of the net: zero without `DERIVATIVES`.
    #[inline(always)]
    fn surface_jet<const DERIVATIVES: bool>(&self, x: DVec2) -> FirstOrderJet {
        let Self { simd, net: HomogeneousNet { degrees, points, rational }, middle, half, .. } = *self;
        let at = middle + half * x;
        let [h, hu, hv] = control_net::first_order::<S, DERIVATIVES>(simd, points, degrees, at.x, at.y);
        if !rational {
            return FirstOrderJet { s: h.truncate(), su: hu.truncate(), sv: hv.truncate() };
        }
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let derivative = |d: DVec4| (d.truncate() - s * d.w) * per;
        FirstOrderJet { s, su: derivative(hu), sv: derivative(hv) }
    }
}

/// Finds every root of the leaf of `net`: returns the only one, or puts all of them into `scratch.roots`, unordered.
#[inline(always)]
pub(super) fn roots<S: Simd>(
    simd: S,
    net: HomogeneousNet<'_>,
    reduced: Option<&ReducedNet>,
    leaf: &PatchLeaf,
    projection: &LeafProjection,
    space: &RaySpace,
    scratch: &mut SearchScratch,
) -> Option<SurfaceRoot> {
    let part = leaf.part;
    if projection.certified {
        let bounds = MapBounds {
            noise: space.noise,
            curvature_bound: leaf.curvature_bound(),
            weights: [1.0; 2],
            steps: MOST_STEPS,
        };
        let half = 0.5 * part.width();
        let surface = FirstOrderJet { s: DVec3::ZERO, su: DVec3::ZERO, sv: DVec3::ZERO };
        let middle = part.at(DVec2::splat(0.5));
        let mut map = ProjectedNet { simd, net, middle, half, space, last: DVec2::ZERO, surface };
        match contract(&mut map, &projection.certificate, &bounds, projection.start) {
            Ok(None) => return None,
            Ok(Some(LocalRoot { at, uncertainty })) => {
                // The last step is so short that the surface is straight along it, to within rounding.
                let FirstOrderJet { s, su, sv } = map.surface;
                let (along, by) = (space.line.direction, half * (at - map.last));
                let (at, uncertainty) = (map.middle + half * at, half * uncertainty);
                return Some(SurfaceRoot {
                    s: along.dot(s - space.line.origin) + along.dot(su) * by.x + along.dot(sv) * by.y,
                    at,
                    uncertainty,
                    distance_uncertainty: uncertainty.x * su.length() + uncertainty.y * sv.length(),
                });
            }
            Err(NoConvergence) => {}
        }
    }
    subdivision::roots(&NetLeaf { net, part, reduced }, space, scratch);
    for root in &mut scratch.roots {
        *root = root.of_part(part);
    }
    None
}
