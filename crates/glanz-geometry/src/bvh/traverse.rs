//! Walks through the tree, nearest boxes first.

use glanz_math::Ray;

use super::build::MAX_DEPTH;
use super::node::{Child, UnitRay, WIDTH};
use super::simd::{Simd, Stack, Task};
use super::{Bvh, Leaf};

/// Every level leaves at most all children but one on the stack, and no wide level is deeper than a binary one.
const ROOM: usize = MAX_DEPTH * (WIDTH - 1) + 1;

/// A stack entry: where the ray enters the box, as the bits of a float that is not negative (they are ordered like
/// the number), and below that the child.
#[inline(always)]
fn entry(near: f32, child: Child) -> u64 {
    (u64::from(near.to_bits()) << 32) | u64::from(child.0)
}

#[inline(always)]
fn near(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

#[inline(always)]
fn child(entry: u64) -> Child {
    Child(entry as u32)
}

/// Closest hit; see [`Bvh::closest`].
pub(crate) struct Closest<'a, F> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) ray: &'a Ray,
    pub(crate) t_max: f64,
    pub(crate) visit: F,
}

impl<F: FnMut(Leaf, f64) -> f64> Task for Closest<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { bvh, ray, mut t_max, mut visit } = self;
        let Some(mut unit) = UnitRay::new(simd, &bvh.frame, ray, t_max) else { return };
        let mut stack = Stack::<ROOM>::new();
        let mut current = entry(0.0, Child::node(0));
        loop {
            if let Some(leaf) = child(current).as_leaf() {
                let closer = visit(Leaf(leaf), t_max);
                if closer < t_max {
                    t_max = closer;
                    unit.shorten(simd, t_max);
                }
            } else if let Some(next) = descend(simd, bvh, child(current), &unit, &mut stack) {
                current = next;
                continue;
            }
            current = loop {
                match stack.pop() {
                    Some(next) if unit.reaches(near(next)) => break next,
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }
}

/// Tests the children of a node; returns the nearest and pushes the others, farthest first.
#[inline(always)]
fn descend<S: Simd>(
    simd: S,
    bvh: &Bvh,
    node: Child,
    ray: &UnitRay<S>,
    stack: &mut Stack<ROOM>,
) -> Option<u64> {
    let node = bvh.nodes.get(node.0 as usize)?;
    let (mut hits, near) = node.intersect(simd, ray);
    if hits == 0 {
        return None;
    }
    let near = simd.store(near).0;
    let mut next = || {
        let slot = hits.trailing_zeros() as usize & (WIDTH - 1);
        hits &= hits - 1;
        (entry(near[slot], node.children[slot]), hits)
    };
    let (first, left) = next();
    if left == 0 {
        return Some(first);
    }
    let (second, left) = next();
    let (mut nearest, farther) = (first.min(second), first.max(second));
    stack.push(farther);
    if left == 0 {
        return Some(nearest);
    }
    let mut count = 1;
    loop {
        let (another, left) = next();
        stack.push(nearest.max(another));
        nearest = nearest.min(another);
        count += 1;
        if left == 0 {
            break;
        }
    }
    stack.sort_top(count);
    Some(nearest)
}

/// Any hit; see [`Bvh::any`].
pub(crate) struct Any<'a, F> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) ray: &'a Ray,
    pub(crate) t_max: f64,
    pub(crate) visit: F,
}

impl<F: FnMut(Leaf) -> bool> Task for Any<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { bvh, ray, t_max, mut visit } = self;
        let Some(unit) = UnitRay::new(simd, &bvh.frame, ray, t_max) else { return false };
        let mut stack = Stack::<ROOM>::new();
        let mut current = entry(0.0, Child::node(0));
        loop {
            if let Some(leaf) = child(current).as_leaf() {
                if visit(Leaf(leaf)) {
                    return true;
                }
            } else if let Some(next) = descend(simd, bvh, child(current), &unit, &mut stack) {
                current = next;
                continue;
            }
            match stack.pop() {
                Some(next) => current = next,
                None => return false,
            }
        }
    }
}
