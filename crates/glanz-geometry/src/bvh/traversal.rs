//! Traversal of the tree, nearest boxes first.

use glanz_math::Ray;

use super::build::MAX_DEPTH;
use super::node::{NodeChild, UnitRay, WIDTH, WideNode};
use super::simd::{Simd, Stack, Task};
use super::{Bvh, BvhLeaf};

/// Capacity of the stack: every level leaves at most all children but one on the stack, and the wide tree is no deeper than the binary one.
pub(super) const STACK_CAPACITY: usize = MAX_DEPTH * (WIDTH - 1) + 1;

/// A stack entry: where the ray enters the box, as the bits of a float that is not negative (they are ordered like
/// the number), and below that the child.
#[inline(always)]
fn entry(near: f32, child: NodeChild) -> u64 {
    (u64::from(near.to_bits()) << 32) | u64::from(child.0)
}

#[inline(always)]
pub(super) fn near(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

#[inline(always)]
pub(super) fn child(entry: u64) -> NodeChild {
    NodeChild(entry as u32)
}

/// The caller's work at the leaves. Methods are `#[inline(always)]`, as a closure cannot be, so that they are compiled for
/// the instruction set of the traversal.
pub(crate) trait LeafVisitor {
    /// Intersects a leaf up to `t_max`; returns the new end of the ray. In a search for any hit, a result below `t_max`
    /// is a hit.
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, t_max: f64) -> f64;
    /// Prepares the ray for leaves; called once the ray has met a box, while the next boxes are tested.
    #[inline(always)]
    fn prepare(&mut self) {}
    /// Prefetches a leaf that will be visited soon.
    fn prefetch<S: Simd>(&self, _simd: S, _leaf: BvhLeaf) {}
}

/// Traversal up to the closest hit; see [`Bvh::closest`].
pub(crate) struct ClosestTraversal<'a, V> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) ray: &'a Ray,
    pub(crate) t_max: f64,
    pub(crate) visit: V,
}

impl<V: LeafVisitor> Task for ClosestTraversal<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { bvh, ray, mut t_max, mut visit } = self;
        let Some(mut unit) = UnitRay::new(simd, &bvh.frame, ray, t_max) else { return };
        let mut stack = Stack::<STACK_CAPACITY>::new();
        let Some(mut current) =
            descend::<S, V, true>(simd, bvh, NodeChild::node(0), &unit, &mut stack, &visit)
        else {
            return;
        };
        visit.prepare();
        loop {
            if let Some(leaf) = current.as_leaf() {
                let closer = visit.leaf(simd, BvhLeaf(leaf), t_max);
                if closer < t_max {
                    t_max = closer;
                    unit.shorten(simd, t_max);
                }
            } else if let Some(next) = descend::<S, V, true>(simd, bvh, current, &unit, &mut stack, &visit) {
                current = next;
                continue;
            }
            current = loop {
                match stack.pop() {
                    Some(next) if unit.reaches(near(next)) => break child(next),
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }
}

/// Tests the children of a node; returns the nearest and pushes the others, if `SORTED` farthest first.
#[inline(always)]
pub(super) fn descend<S: Simd, V: LeafVisitor, const SORTED: bool>(
    simd: S,
    bvh: &Bvh,
    node: NodeChild,
    ray: &UnitRay<S>,
    stack: &mut Stack<STACK_CAPACITY>,
    visit: &V,
) -> Option<NodeChild> {
    let node = bvh.nodes.get(node.0 as usize)?;
    let (mut hits, near) = node.intersect(simd, ray);
    if hits == 0 {
        return None;
    }
    let slot = hits.trailing_zeros() as usize & (WIDTH - 1);
    if hits & (hits - 1) == 0 {
        // Most often there is one, and then its entry is not needed.
        return Some(node.children[slot]);
    }
    let near = simd.store(near).0;
    let first = next(node, &near, &mut hits);
    let second = next(node, &near, &mut hits);
    prefetch(simd, bvh, visit, child(first));
    prefetch(simd, bvh, visit, child(second));
    let mut nearest = first.min(second);
    stack.push(first.max(second));
    if hits == 0 {
        return Some(child(nearest));
    }
    let mut count = 1;
    while hits != 0 {
        let another = next(node, &near, &mut hits);
        prefetch(simd, bvh, visit, child(another));
        stack.push(nearest.max(another));
        nearest = nearest.min(another);
        count += 1;
    }
    if SORTED {
        stack.sort_top(count);
    }
    Some(child(nearest))
}

/// Prefetches a child that will be visited soon.
#[inline(always)]
fn prefetch<S: Simd, V: LeafVisitor>(simd: S, bvh: &Bvh, visit: &V, child: NodeChild) {
    match child.as_leaf() {
        Some(leaf) => visit.prefetch(simd, BvhLeaf(leaf)),
        None => {
            if let Some(node) = bvh.nodes.get(child.0 as usize) {
                node.prefetch(simd);
            }
        }
    }
}

/// Removes the lowest bit of `hits`; returns the stack entry of its child.
#[inline(always)]
fn next(node: &WideNode, near: &[f32; WIDTH], hits: &mut u32) -> u64 {
    let slot = hits.trailing_zeros() as usize & (WIDTH - 1);
    *hits &= *hits - 1;
    entry(near[slot], node.children[slot])
}

/// Traversal up to any hit; see [`Bvh::any`].
pub(crate) struct AnyTraversal<'a, V> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) ray: &'a Ray,
    pub(crate) t_max: f64,
    pub(crate) visit: V,
}

impl<V: LeafVisitor> Task for AnyTraversal<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { bvh, ray, t_max, mut visit } = self;
        let Some(unit) = UnitRay::new(simd, &bvh.frame, ray, t_max) else { return false };
        let mut stack = Stack::<STACK_CAPACITY>::new();
        let Some(mut current) =
            descend::<S, V, false>(simd, bvh, NodeChild::node(0), &unit, &mut stack, &visit)
        else {
            return false;
        };
        visit.prepare();
        loop {
            if let Some(leaf) = current.as_leaf() {
                if visit.leaf(simd, BvhLeaf(leaf), t_max) < t_max {
                    return true;
                }
            } else if let Some(next) = descend::<S, V, false>(simd, bvh, current, &unit, &mut stack, &visit) {
                current = next;
                continue;
            }
            match stack.pop() {
                Some(next) => current = child(next),
                None => return false,
            }
        }
    }
}
