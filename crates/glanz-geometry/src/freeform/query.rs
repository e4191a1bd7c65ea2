//! What rays ask a freeform surface.

use std::cmp::Ordering;
use std::sync::atomic;

use glanz_math::Ray;

use super::search::{self, Net, Probe, Root, Scratch};
use super::{Freeform, Place};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::{Leaf, Visit};
use crate::hit::Hit;

/// What all queries carry from leaf to leaf.
struct Walk<'a> {
    surface: &'a Freeform,
    probe: Probe,
    scratch: Scratch,
}

impl<'a> Walk<'a> {
    #[inline(always)]
    fn new(surface: &'a Freeform, ray: &Ray) -> Self {
        let bounds = surface.bvh.bounds();
        let radius = 0.5 * bounds.diagonal().length();
        let probe = Probe::new(ray, bounds.center(), radius, surface.size, surface.degrees);
        Self { surface, probe, scratch: Scratch::default() }
    }

    /// Reports every root in a leaf of the hierarchy.
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, mut report: impl FnMut(&Probe, &Place, Root)) {
        let Self { surface, probe, scratch } = self;
        let starts = surface.starts.get(leaf.ordinal()).zip(surface.starts.get(leaf.ordinal() + 1));
        let Some((&start, &end)) = starts else { return };
        for index in start as usize..end as usize {
            let (Some(frame), Some(place)) = (surface.frames.get(index), surface.places.get(index)) else {
                return;
            };
            search::roots(frame, || surface.net(place), probe, scratch, &mut |root| {
                report(probe, place, root)
            });
        }
    }
}

impl Drop for Walk<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        if self.scratch.undecided > 0 {
            self.surface.undecided.fetch_add(self.scratch.undecided, atomic::Ordering::Relaxed);
        }
    }
}

impl Freeform {
    #[inline(always)]
    fn net(&self, place: &Place) -> Net<'_> {
        let degrees = self.pieces.get(place.piece as usize).map_or((0, 0), |piece| piece.patch.degrees());
        let length = (degrees.0 + 1) * (degrees.1 + 1) * if place.rational { 4 } else { 3 };
        let start = place.net as usize;
        let lists = self.nets.get(start..start + length).unwrap_or_default();
        Net { degrees, lists, rational: place.rational }
    }
}

#[inline(always)]
fn hit(t: f64, place: &Place, root: &Root) -> Hit {
    let (u, v) = place.rect.at(root.x, root.y);
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
        let mut visit = ClosestVisit { walk: Walk::new(self.surface, self.ray), best: None };
        self.surface.bvh.closest_with(simd, self.ray, self.t_max, &mut visit);
        visit.best
    }
}

struct ClosestVisit<'a> {
    walk: Walk<'a>,
    best: Option<Hit>,
}

impl Visit for &mut ClosestVisit<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        let ClosestVisit { walk, best } = &mut **self;
        let mut end = t_max;
        walk.leaf(leaf, |probe, place, root| {
            let t = probe.line.t(root.s);
            let found = hit(t, place, &root);
            let closer = t < end || best.is_some_and(|b| order(&found, &b).is_lt());
            if t > 0.0 && closer {
                *best = Some(found);
                end = t;
            }
        });
        end
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
        let mut visit = OccludedVisit(Walk::new(self.surface, self.ray));
        self.surface.bvh.any_with(simd, self.ray, self.t_max, &mut visit)
    }
}

struct OccludedVisit<'a>(Walk<'a>);

impl Visit for &mut OccludedVisit<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        let mut met = false;
        self.0.leaf(leaf, |probe, _, root| {
            let t = probe.line.t(root.s);
            met |= t > 0.0 && t < t_max;
        });
        if met { f64::NEG_INFINITY } else { t_max }
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
        let mut visit =
            EveryVisit { walk: Walk::new(self.surface, self.ray), found: Vec::new(), t_max: self.t_max };
        self.surface.bvh.closest_with(simd, self.ray, self.t_max, &mut visit);
        let mut found = std::mem::take(&mut visit.found);
        found.sort_by(|a, b| order(&a.hit, &b.hit));
        for (index, candidate) in found.iter().enumerate() {
            if !found[..index].iter().any(|earlier| earlier.is_same(candidate)) {
                self.hits.push(candidate.hit);
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

struct EveryVisit<'a> {
    walk: Walk<'a>,
    found: Vec<Found>,
    t_max: f64,
}

impl Visit for &mut EveryVisit<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        let EveryVisit { walk, found, t_max: end } = &mut **self;
        walk.leaf(leaf, |probe, place, root| {
            let t = probe.line.t(root.s);
            if t > 0.0 && t < *end {
                let Place { rect, .. } = place;
                let blur = [(rect.u, root.blur.x), (rect.v, root.blur.y)]
                    .map(|([low, high], blur)| blur * (high - low) + f64::EPSILON);
                let root = Root { reach: root.reach + probe.noise, ..root };
                found.push(Found { hit: hit(t, place, &root), root, blur });
            }
        });
        t_max
    }
}
