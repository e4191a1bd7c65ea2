//! Ray queries of a freeform surface: closest hit, any hit and all hits.

use std::cmp::Ordering;

use glanz_math::{DVec2, Ray};

use super::Freeform;
use super::ray_space::RaySpace;
use super::root::{SearchScratch, SurfaceRoot};
use super::subpatches::{LeafSearch, SubpatchLocation};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::{BvhLeaf, LeafVisitor};
use crate::hit::{Hit, HitBorder};

/// The search in one leaf after the other, which all queries share.
struct LeafSearcher<'a> {
    surface: &'a Freeform,
    ray: &'a Ray,
    /// Computed at the first box: many rays meet none.
    space: Option<RaySpace>,
    scratch: SearchScratch,
}

impl LeafSearcher<'_> {
    /// Adds every root in a leaf of the hierarchy to `collector`.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, collector: &mut impl RootCollector) {
        let Self { surface, space, scratch, .. } = self;
        let (Some(leaf), Some(space)) = (surface.leaves.get(leaf.ordinal()), space) else { return };
        let Some(projection) = leaf.project(simd, space) else { return };
        let search = LeafSearch {
            subpatches: &surface.subpatches,
            reduced_nets: &surface.reduced_nets,
            leaf,
            projection: &projection,
            space,
            scratch: &mut *scratch,
        };
        let only = simd.outlined(search);
        let location = &surface.location(leaf.subpatch);
        let mut found = |root: SurfaceRoot| {
            let border = if leaf.crossed { surface.border(location, root.at) } else { Some(HitBorder::Away) };
            if let Some(border) = border {
                collector.add(space, location, root, border);
            }
        };
        if let Some(root) = only {
            found(root);
        } else {
            scratch.roots.drain(..).for_each(found);
        }
    }
}

/// The roots of a query, as far as it needs them.
trait RootCollector {
    fn add(&mut self, space: &RaySpace, location: &SubpatchLocation, root: SurfaceRoot, border: HitBorder);

    /// End of the part of the ray that remains to be searched, of which `t_max` was the end so far.
    fn end(&self, t_max: f64) -> f64;
}

/// Searches the leaves that the ray meets for the roots that `roots` needs.
struct QueryVisitor<'a, C> {
    searcher: LeafSearcher<'a>,
    roots: C,
}

impl<'a, C: RootCollector> QueryVisitor<'a, C> {
    #[inline(always)]
    fn new(surface: &'a Freeform, ray: &'a Ray, roots: C) -> Self {
        Self {
            searcher: LeafSearcher { surface, ray, space: None, scratch: SearchScratch::default() },
            roots,
        }
    }
}

impl<C: RootCollector> LeafVisitor for &mut QueryVisitor<'_, C> {
    #[inline(always)]
    fn prepare(&mut self) {
        self.searcher.space = Some(self.searcher.surface.frame.ray_space(self.searcher.ray));
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, t_max: f64) -> f64 {
        self.searcher.leaf(simd, leaf, &mut self.roots);
        self.roots.end(t_max)
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        if let Some(leaf) = self.searcher.surface.leaves.get(leaf.ordinal()) {
            simd.prefetch(leaf);
        }
    }
}

impl Drop for LeafSearcher<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        self.surface.counters.add(&mut self.scratch);
    }
}

#[inline(always)]
pub(super) fn hit(t: f64, location: &SubpatchLocation, at: DVec2, border: HitBorder) -> Hit {
    let DVec2 { x: u, y: v } = location.part.at(at);
    Hit { border, ..Hit::new(t, u, v, location.patch) }
}

/// Order of hits: by t, then by patch and parameters, whatever the order of leaves.
pub(super) fn order(a: &Hit, b: &Hit) -> Ordering {
    let key = |h: &Hit| (h.t, h.face, h.u, h.v);
    key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)
}

/// The closest hit.
pub(super) struct ClosestQuery<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for ClosestQuery<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Hit> {
        let Self { surface, ray, t_max } = self;
        let best = ClosestRoot { hit: None, end: t_max };
        let mut visit = QueryVisitor::new(surface, ray, best);
        surface.bvh.closest_with(simd, ray, t_max, &mut visit);
        visit.roots.hit
    }
}

/// The closest hit so far.
struct ClosestRoot {
    hit: Option<Hit>,
    /// End of the ray.
    end: f64,
}

impl RootCollector for ClosestRoot {
    #[inline(always)]
    fn add(&mut self, space: &RaySpace, location: &SubpatchLocation, root: SurfaceRoot, border: HitBorder) {
        let t = space.line.t(root.s);
        if t > 0.0 && t <= self.end {
            let found = hit(t, location, root.at, border);
            if t < self.end || self.hit.is_some_and(|best| order(&found, &best).is_lt()) {
                *self = Self { hit: Some(found), end: t };
            }
        }
    }

    #[inline(always)]
    fn end(&self, _: f64) -> f64 {
        self.end
    }
}

/// Whether there is a hit.
pub(super) struct OcclusionQuery<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for OcclusionQuery<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { surface, ray, t_max } = self;
        let any = AnyRoot { end: t_max, found: false };
        let mut visit = QueryVisitor::new(surface, ray, any);
        surface.bvh.any_with(simd, ray, t_max, &mut visit)
    }
}

/// Whether a root lies before the end of the ray.
struct AnyRoot {
    end: f64,
    found: bool,
}

impl RootCollector for AnyRoot {
    #[inline(always)]
    fn add(&mut self, space: &RaySpace, _: &SubpatchLocation, root: SurfaceRoot, _: HitBorder) {
        let t = space.line.t(root.s);
        self.found |= t > 0.0 && t < self.end;
    }

    #[inline(always)]
    fn end(&self, t_max: f64) -> f64 {
        if self.found { f64::NEG_INFINITY } else { t_max }
    }
}

/// Every hit.
pub(super) struct AllHitsQuery<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    pub(super) hits: &'a mut Vec<Hit>,
}

impl Task for AllHitsQuery<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { surface, ray, t_max, hits } = self;
        let all = AllRoots { found: Vec::new(), end: t_max };
        let mut visit = QueryVisitor::new(surface, ray, all);
        surface.bvh.closest_with(simd, ray, t_max, &mut visit);
        let mut found = visit.roots.found;
        found.sort_by(|a, b| order(&a.hit, &b.hit));
        for (index, candidate) in found.iter().enumerate() {
            if !found[..index].iter().any(|earlier| earlier.is_same(candidate)) {
                hits.push(candidate.hit);
            }
        }
    }
}

/// A root with the bounds that distinguish it from others.
struct HitCandidate {
    hit: Hit,
    root: SurfaceRoot,
    /// Bound on its shift by rounding, in the parameters of the patch.
    uncertainty: [f64; 2],
}

impl HitCandidate {
    /// Whether both are one root, found in two leaves that share a border or a corner, or in two patches.
    ///
    /// Roots are distinguished by their parameters, since sheets of a surface may cross; only at the borders of
    /// patches, where a point has several parameters, by their position.
    fn is_same(&self, other: &Self) -> bool {
        // Both may be off, each by a few times the uncertainty of one step.
        let near = |a: f64, b: f64, uncertainty: f64| (a - b).abs() <= 8.0 * uncertainty;
        let [bu, bv] = [0, 1].map(|k| self.uncertainty[k] + other.uncertainty[k]);
        let distance_uncertainty = self.root.distance_uncertainty + other.root.distance_uncertainty;
        near(self.root.s, other.root.s, distance_uncertainty)
            && if self.hit.face == other.hit.face
                && near(self.hit.u, other.hit.u, bu)
                && near(self.hit.v, other.hit.v, bv)
            {
                true
            } else {
                self.is_on_border(distance_uncertainty) && other.is_on_border(distance_uncertainty)
            }
    }

    /// Whether the border is as near as two roots that count as one, which are together off by `distance_uncertainty`: rays that graze a
    /// collapsed edge meet each patch there at another distance from the edge.
    fn is_on_border(&self, distance_uncertainty: f64) -> bool {
        let scale = 8.0 * distance_uncertainty / self.root.distance_uncertainty;
        let at_end = |x: f64, uncertainty: f64| x <= scale * uncertainty || x >= 1.0 - scale * uncertainty;
        at_end(self.hit.u, self.uncertainty[0]) || at_end(self.hit.v, self.uncertainty[1])
    }
}

struct AllRoots {
    found: Vec<HitCandidate>,
    end: f64,
}

impl RootCollector for AllRoots {
    #[inline(always)]
    fn add(&mut self, space: &RaySpace, location: &SubpatchLocation, root: SurfaceRoot, border: HitBorder) {
        let t = space.line.t(root.s);
        if t > 0.0 && t < self.end {
            let uncertainty = (root.uncertainty * location.part.width() + f64::EPSILON).to_array();
            let root = SurfaceRoot { distance_uncertainty: root.distance_uncertainty + space.noise, ..root };
            let hit = hit(t, location, root.at, border);
            self.found.push(HitCandidate { hit, root, uncertainty });
        }
    }

    #[inline(always)]
    fn end(&self, t_max: f64) -> f64 {
        t_max
    }
}
