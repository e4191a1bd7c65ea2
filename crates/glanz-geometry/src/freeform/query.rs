//! What rays ask a freeform surface.

use std::cmp::Ordering;
use std::sync::atomic;

use glanz_math::{DVec2, Ray};

use super::Freeform;
use super::leaf::Leaf;
use super::search::{OnRoot, Probe, Root, Scratch};
use super::subpatches::{Form, Forms, Place};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::{self, Visit};
use crate::hit::Hit;

/// Runs `$run` on the subpatches of a surface, whichever kind they are.
macro_rules! on_forms {
    ($surface:expr, $forms:ident => $run:expr) => {
        match &$surface.forms {
            Forms::Polynomial(list) => {
                let $forms = &**list;
                $run
            }
            Forms::Rational(list) => {
                let $forms = &**list;
                $run
            }
            Forms::General(list) => {
                let $forms = &**list;
                $run
            }
        }
    };
}

/// What all queries carry from leaf to leaf.
struct Walk<'a, F> {
    surface: &'a Freeform,
    forms: &'a [F],
    ray: &'a Ray,
    /// From the first box on: many rays meet none.
    probe: Option<Probe>,
    scratch: Scratch,
}

impl<'a, F: Form> Walk<'a, F> {
    #[inline(always)]
    fn new(surface: &'a Freeform, forms: &'a [F], ray: &'a Ray) -> Self {
        Self { surface, forms, ray, probe: None, scratch: Scratch::default() }
    }

    /// Makes the ray ready for leaves.
    #[inline(always)]
    fn prepare(&mut self) {
        self.probe = Some(self.surface.sight.probe(self.ray));
    }

    /// Tells `report` of every root in a leaf of the hierarchy.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: bvh::Leaf, report: &mut impl Report) {
        let Self { surface, forms, probe, scratch, .. } = self;
        let (Some(leaf), Some(probe)) = (surface.leaves.get(leaf.ordinal()), probe) else { return };
        let Some(look) = leaf.look(simd, probe) else { return };
        let Some(form) = forms.get(leaf.subpatch as usize) else { return };
        form.roots(simd, leaf, &look, probe, scratch, &mut InLeaf { report, surface, probe, leaf });
    }

    /// Asks the memory for a leaf.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: bvh::Leaf) {
        if let Some(leaf) = self.surface.leaves.get(leaf.ordinal()) {
            simd.prefetch(leaf);
        }
    }
}

/// What becomes of the roots.
trait Report {
    fn root(&mut self, probe: &Probe, place: &Place, root: Root);
}

/// A report of the roots of one leaf.
struct InLeaf<'a, R> {
    report: &'a mut R,
    surface: &'a Freeform,
    probe: &'a Probe,
    leaf: &'a Leaf,
}

impl<R: Report> OnRoot for InLeaf<'_, R> {
    #[inline(always)]
    fn root(&mut self, root: Root) {
        let Some(place) = self.surface.places.get(self.leaf.subpatch as usize) else { return };
        if !self.leaf.crossed || self.surface.keeps(place, &root) {
            self.report.root(self.probe, place, root);
        }
    }
}

impl<F> Drop for Walk<'_, F> {
    #[inline(always)]
    fn drop(&mut self) {
        if self.scratch.undecided > 0 {
            self.surface.undecided.fetch_add(self.scratch.undecided, atomic::Ordering::Relaxed);
        }
    }
}

#[inline(always)]
fn hit(t: f64, place: &Place, root: &Root) -> Hit {
    let DVec2 { x: u, y: v } = place.part.at(root.at);
    Hit { t, u, v, face: place.piece }
}

/// Of hits at the same place that of the lowest piece and parameters comes first, in whatever order they are met.
fn order(a: &Hit, b: &Hit) -> Ordering {
    let key = |h: &Hit| (h.t, h.face, h.u, h.v);
    key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)
}

/// The closest hit.
pub(super) struct Closest<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for Closest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Hit> {
        let Self { surface, ray, t_max } = self;
        on_forms!(surface, forms => {
            let best = Best { hit: None, end: t_max };
            let mut visit = ClosestVisit { walk: Walk::new(surface, forms, ray), best };
            surface.bvh.closest_with(simd, ray, t_max, &mut visit);
            visit.best.hit
        })
    }
}

struct ClosestVisit<'a, F> {
    walk: Walk<'a, F>,
    best: Best,
}

/// The closest hit so far.
struct Best {
    hit: Option<Hit>,
    /// Where the ray ends.
    end: f64,
}

impl Report for Best {
    #[inline(always)]
    fn root(&mut self, probe: &Probe, place: &Place, root: Root) {
        let t = probe.line.t(root.s);
        if t > 0.0 && t <= self.end {
            let found = hit(t, place, &root);
            if t < self.end || self.hit.is_some_and(|best| order(&found, &best).is_lt()) {
                *self = Self { hit: Some(found), end: t };
            }
        }
    }
}

impl<F: Form> Visit for &mut ClosestVisit<'_, F> {
    #[inline(always)]
    fn prepare(&mut self) {
        self.walk.prepare();
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: bvh::Leaf, _: f64) -> f64 {
        self.walk.leaf(simd, leaf, &mut self.best);
        self.best.end
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: bvh::Leaf) {
        self.walk.prefetch(simd, leaf);
    }
}

/// Whether there is a hit.
pub(super) struct Occluded<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for Occluded<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { surface, ray, t_max } = self;
        on_forms!(surface, forms => {
            let before = Before { end: t_max, met: false };
            let mut visit = OccludedVisit { walk: Walk::new(surface, forms, ray), before };
            surface.bvh.any_with(simd, ray, t_max, &mut visit)
        })
    }
}

struct OccludedVisit<'a, F> {
    walk: Walk<'a, F>,
    before: Before,
}

/// Whether there was a root before the end.
struct Before {
    end: f64,
    met: bool,
}

impl Report for Before {
    #[inline(always)]
    fn root(&mut self, probe: &Probe, _: &Place, root: Root) {
        let t = probe.line.t(root.s);
        self.met |= t > 0.0 && t < self.end;
    }
}

impl<F: Form> Visit for &mut OccludedVisit<'_, F> {
    #[inline(always)]
    fn prepare(&mut self) {
        self.walk.prepare();
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: bvh::Leaf, t_max: f64) -> f64 {
        self.walk.leaf(simd, leaf, &mut self.before);
        if self.before.met { f64::NEG_INFINITY } else { t_max }
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: bvh::Leaf) {
        self.walk.prefetch(simd, leaf);
    }
}

/// Every hit.
pub(super) struct Every<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    pub(super) hits: &'a mut Vec<Hit>,
}

impl Task for Every<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { surface, ray, t_max, hits } = self;
        let mut found = on_forms!(surface, forms => {
            let walk = Walk::new(surface, forms, ray);
            let mut visit = EveryVisit { walk, all: All { found: Vec::new(), end: t_max } };
            surface.bvh.closest_with(simd, ray, t_max, &mut visit);
            visit.all.found
        });
        found.sort_by(|a, b| order(&a.hit, &b.hit));
        for (index, candidate) in found.iter().enumerate() {
            if !found[..index].iter().any(|earlier| earlier.is_same(candidate)) {
                hits.push(candidate.hit);
            }
        }
    }
}

/// A root with what tells it from others.
struct Found {
    hit: Hit,
    root: Root,
    /// By how much rounding may move it, in the patch's u and v.
    blur: [f64; 2],
}

impl Found {
    /// Whether both are one root, found in two leaves that share a border or a corner, or in two patches.
    ///
    /// Roots are told apart by their parameters, since sheets of a surface may cross; only at the borders of
    /// patches, where one point has several parameters, by their place.
    fn is_same(&self, other: &Self) -> bool {
        // Both may be off, and each by a few times what one step may be.
        let near = |a: f64, b: f64, blur: f64| (a - b).abs() <= 8.0 * blur;
        let [bu, bv] = [0, 1].map(|k| self.blur[k] + other.blur[k]);
        near(self.root.s, other.root.s, self.root.reach + other.root.reach)
            && if self.hit.face == other.hit.face
                && near(self.hit.u, other.hit.u, bu)
                && near(self.hit.v, other.hit.v, bv)
            {
                true
            } else {
                self.on_border() && other.on_border()
            }
    }

    fn on_border(&self) -> bool {
        let at_end = |x: f64, blur: f64| x <= 8.0 * blur || x >= 1.0 - 8.0 * blur;
        at_end(self.hit.u, self.blur[0]) || at_end(self.hit.v, self.blur[1])
    }
}

struct EveryVisit<'a, F> {
    walk: Walk<'a, F>,
    all: All,
}

struct All {
    found: Vec<Found>,
    end: f64,
}

impl Report for All {
    #[inline(always)]
    fn root(&mut self, probe: &Probe, place: &Place, root: Root) {
        let t = probe.line.t(root.s);
        if t > 0.0 && t < self.end {
            let blur = (root.blur * place.part.width() + f64::EPSILON).to_array();
            let root = Root { reach: root.reach + probe.noise, ..root };
            self.found.push(Found { hit: hit(t, place, &root), root, blur });
        }
    }
}

impl<F: Form> Visit for &mut EveryVisit<'_, F> {
    #[inline(always)]
    fn prepare(&mut self) {
        self.walk.prepare();
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: bvh::Leaf, t_max: f64) -> f64 {
        self.walk.leaf(simd, leaf, &mut self.all);
        t_max
    }
}
