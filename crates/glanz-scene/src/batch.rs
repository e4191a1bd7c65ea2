//! Batches of rays through a scene: plain arrays in, plain arrays out.
//!
//! The rays of a batch descend the hierarchy over the objects together, and each object is intersected with all rays that reach its
//! box. Answers are those of [`Scene::intersect`] and [`Scene::occluded`] ray by ray, bit for bit, for any size and order of the batch:
//! hits at the same parameter are decided by the numbers of their primitives, not by the order in which they are found.

use std::cell::RefCell;

use glanz_geometry::bvh::{BatchVisitor, BvhLeaf};
use glanz_geometry::{BoundedRay, Hit};
use glanz_math::Ray;

use crate::alpha::RayKind;
use crate::hit::{NearestHit, SceneHit};
use crate::scene::{Primitive, Scene, SceneGroup};

/// Number of rays from which on an object is intersected with all of them at once: fewer are faster one by one.
const LEAST_RAYS: usize = 4;

/// Largest number of rays for which a thread keeps its memory, of some hundred bytes a ray.
const KEPT_RAYS: usize = 1 << 16;

thread_local! {
    /// The memory of earlier batches, one for each level of instances: getting it from the system would take as long as the rays.
    static MEMORY: RefCell<Vec<SceneBatchMemory>> = const { RefCell::new(Vec::new()) };
}

/// Memory that batches reuse.
#[derive(Default)]
struct SceneBatchMemory {
    all: Vec<u32>,
    nearest: Vec<NearestHit>,
    local: Vec<BoundedRay>,
    hits: Vec<Option<Hit>>,
    nested: Vec<Option<SceneHit>>,
    open: Vec<u32>,
    occluded: Vec<bool>,
}

impl SceneBatchMemory {
    /// Runs `work` with memory of this thread.
    fn with(work: impl FnOnce(&mut Self)) {
        // A thread that ends has no pool any more.
        let mut memory = MEMORY.try_with(|pool| pool.borrow_mut().pop()).ok().flatten().unwrap_or_default();
        work(&mut memory);
        let SceneBatchMemory { all, nearest, local, .. } = &memory;
        if all.capacity().max(nearest.capacity()).max(local.capacity()) <= KEPT_RAYS {
            let _ = MEMORY.try_with(|pool| pool.borrow_mut().push(memory));
        }
    }
}

impl Scene {
    /// The first hit of each ray before its end. `hits` is replaced.
    ///
    /// The same bits as ray by ray, see the module.
    pub fn closest_batch(&self, rays: &[BoundedRay], hits: &mut Vec<Option<SceneHit>>) {
        self.closest_in_group(self.world(), rays, hits);
    }

    /// Whether each ray hits anything before its end. `occluded` is replaced.
    ///
    /// The same as ray by ray.
    pub fn occluded_batch(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        self.occluded_in_group(self.world(), rays, occluded);
    }

    fn closest_in_group(&self, group: &SceneGroup, rays: &[BoundedRay], hits: &mut Vec<Option<SceneHit>>) {
        if group.section.is_some() {
            hits.clear();
            hits.extend(rays.iter().map(|ray| self.closest(group, &ray.ray, ray.t_max)));
            return;
        }
        SceneBatchMemory::with(|memory| {
            let SceneBatchMemory { all, nearest, local, hits: local_hits, nested, .. } = memory;
            nearest.clear();
            nearest.extend(rays.iter().map(|ray| NearestHit::before(ray.t_max)));
            let mut search = ClosestSearch { scene: self, group, rays, nearest, local, local_hits, nested };
            if !group.unbounded.is_empty() {
                all.clear();
                all.extend(0..rays.len() as u32);
                for number in 0..group.unbounded.len() {
                    search.visit(number, all);
                }
            }
            group.bvh.visit_batch(rays, &mut search);
            hits.clear();
            hits.extend(nearest.iter().map(NearestHit::hit));
        });
    }

    fn occluded_in_group(&self, group: &SceneGroup, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        occluded.clear();
        if group.section.is_some() {
            occluded.extend(rays.iter().map(|ray| self.any(group, &ray.ray, ray.t_max)));
            return;
        }
        occluded.resize(rays.len(), false);
        SceneBatchMemory::with(|memory| {
            let SceneBatchMemory { all, open, local, hits: local_hits, occluded: local_occluded, .. } =
                memory;
            let mut search =
                AnySearch { scene: self, group, rays, occluded, local, local_hits, local_occluded, open };
            if !group.unbounded.is_empty() {
                all.clear();
                all.extend(0..rays.len() as u32);
                for number in 0..group.unbounded.len() {
                    search.visit(number, all);
                }
            }
            group.bvh.visit_batch(rays, &mut search);
        });
    }
}

/// The closest hit of each ray of a batch with the primitives of a group.
struct ClosestSearch<'a> {
    scene: &'a Scene,
    group: &'a SceneGroup,
    rays: &'a [BoundedRay],
    nearest: &'a mut [NearestHit],
    local: &'a mut Vec<BoundedRay>,
    local_hits: &'a mut Vec<Option<Hit>>,
    nested: &'a mut Vec<Option<SceneHit>>,
}

impl ClosestSearch<'_> {
    /// Intersects rays with a primitive, by its number.
    fn visit(&mut self, number: usize, ids: &[u32]) {
        if ids.len() < LEAST_RAYS {
            for &id in ids {
                let (ray, nearest) = (&self.rays[id as usize].ray, &mut self.nearest[id as usize]);
                self.scene.visit(self.group, number, ray, nearest);
            }
            return;
        }
        self.local.clear();
        match self.group.primitive(number) {
            Primitive::Object(index) => {
                let object = &self.group.objects[index as usize];
                self.gather(ids, |ray| object.local(ray));
                object.closest_batch(self.local, self.local_hits);
                for ((&id, hit), local) in ids.iter().zip(self.local_hits.iter()).zip(self.local.iter()) {
                    let ray = &self.rays[id as usize].ray;
                    let hit = self.group.accepted_hit(index, ray, local.t_max, *hit, RayKind::Closest);
                    if let Some(hit) = hit {
                        self.nearest[id as usize].offer(SceneHit::new(hit, index), number);
                    }
                }
            }
            Primitive::Instance(index) => {
                let instance = &self.group.instances[index as usize];
                let before = self.group.placed_before[index as usize];
                self.gather(ids, |ray| instance.to_parent.inverse().ray(ray));
                self.scene.closest_in_group(&self.scene.groups[instance.group], self.local, self.nested);
                for (&id, found) in ids.iter().zip(self.nested.iter()) {
                    if let Some(found) = found {
                        self.nearest[id as usize].offer(found.within(before), number);
                    }
                }
            }
        }
    }

    /// The rays in a local frame, with their current ends.
    fn gather(&mut self, ids: &[u32], to_local: impl Fn(&Ray) -> Ray) {
        let (rays, nearest) = (self.rays, &*self.nearest);
        let bounded =
            |&id: &u32| BoundedRay::new(to_local(&rays[id as usize].ray), nearest[id as usize].end());
        self.local.extend(ids.iter().map(bounded));
    }
}

impl BatchVisitor for ClosestSearch<'_> {
    fn leaf(&mut self, leaf: BvhLeaf, ids: &[u32]) {
        let before = self.group.unbounded.len();
        for &index in self.group.bvh.leaf(leaf) {
            self.visit(before + index as usize, ids);
        }
    }

    fn end(&self, ray: u32) -> f64 {
        self.nearest[ray as usize].t()
    }
}

/// Whether each ray of a batch hits a primitive of a group.
struct AnySearch<'a> {
    scene: &'a Scene,
    group: &'a SceneGroup,
    rays: &'a [BoundedRay],
    occluded: &'a mut [bool],
    local: &'a mut Vec<BoundedRay>,
    local_hits: &'a mut Vec<Option<Hit>>,
    local_occluded: &'a mut Vec<bool>,
    /// Rays of the list in hand that have not hit anything.
    open: &'a mut Vec<u32>,
}

impl AnySearch<'_> {
    /// Intersects rays with a primitive, by its number.
    fn visit(&mut self, number: usize, ids: &[u32]) {
        self.open.clear();
        self.open.extend(ids.iter().filter(|&&id| !self.occluded[id as usize]));
        let (group, primitive) = (self.group, self.group.primitive(number));
        if self.open.len() < LEAST_RAYS {
            for &id in self.open.iter() {
                let BoundedRay { ray, t_max } = &self.rays[id as usize];
                self.occluded[id as usize] = self.scene.is_stopped_by(group, primitive, ray, *t_max);
            }
            return;
        }
        self.local.clear();
        match primitive {
            Primitive::Object(index) => {
                let object = &group.objects[index as usize];
                self.gather(|ray| object.local(ray));
                if object.has_optional_hits() && !object.passable {
                    object.closest_batch(self.local, self.local_hits);
                    let stops = |(&id, hit): (&u32, &Option<Hit>)| {
                        let BoundedRay { ray, t_max } = &self.rays[id as usize];
                        group.accepted_hit(index, ray, *t_max, *hit, RayKind::Shadow).is_some()
                    };
                    self.local_occluded.clear();
                    self.local_occluded.extend(self.open.iter().zip(self.local_hits.iter()).map(stops));
                } else {
                    object.occluded_batch(self.local, self.local_occluded);
                }
            }
            Primitive::Instance(index) => {
                let instance = &group.instances[index as usize];
                self.gather(|ray| instance.to_parent.inverse().ray(ray));
                let inner = &self.scene.groups[instance.group];
                self.scene.occluded_in_group(inner, self.local, self.local_occluded);
            }
        }
        for (&id, &occluded) in self.open.iter().zip(self.local_occluded.iter()) {
            self.occluded[id as usize] = occluded;
        }
    }

    /// The open rays in a local frame.
    fn gather(&mut self, to_local: impl Fn(&Ray) -> Ray) {
        let bounded = |&id: &u32| {
            let BoundedRay { ray, t_max } = &self.rays[id as usize];
            BoundedRay::new(to_local(ray), *t_max)
        };
        self.local.extend(self.open.iter().map(bounded));
    }
}

impl BatchVisitor for AnySearch<'_> {
    fn leaf(&mut self, leaf: BvhLeaf, ids: &[u32]) {
        let before = self.group.unbounded.len();
        for &index in self.group.bvh.leaf(leaf) {
            self.visit(before + index as usize, ids);
        }
    }

    fn end(&self, ray: u32) -> f64 {
        if self.occluded[ray as usize] { f64::NEG_INFINITY } else { self.rays[ray as usize].t_max }
    }
}
