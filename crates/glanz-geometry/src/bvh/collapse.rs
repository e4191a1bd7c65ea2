//! Conversion of the binary tree to eight-wide nodes, at the least expected cost.
//!
//! # Source
//! @ylitie2017 section 3.1. With `C(n, i)` the least cost of covering the subtree at `n` by at most `i` children of a wide
//! node, `C(n, 1)` is the cheaper of a leaf and a wide node, and `C(n, i)` the cheapest way to distribute `i` children
//! over the two subtrees. Departure: a leaf costs by blocks, since primitives of one block are tested at once.

use super::BuildOptions;
use super::build::BinaryNode;
use super::node::{NodeChild, WIDTH, WideNode};
use super::simd::prefer_large_pages;

/// Least costs of covering a subtree with at most 1, 2 ... 7 children of a wide node. Only the plan of its parent needs them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CollapseCosts([f32; WIDTH - 1]);

impl CollapseCosts {
    /// Those of no subtree.
    pub(crate) const ZERO: Self = Self([0.0; WIDTH - 1]);

    /// Expected cost of a ray that meets the root, in node visits times half the area of the root.
    pub(crate) fn of_root(&self) -> f32 {
        self.0[0]
    }
}

/// The cheapest ways to cover a subtree by children of a wide node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CollapsePlan {
    /// Number of children for the left subtree, of at most 2, 3 ... 8; 0 if one child fewer costs no more.
    left: [u8; WIDTH - 1],
    /// Whether a single child is a leaf.
    leaf: bool,
}

impl CollapsePlan {
    pub(crate) const EMPTY: Self = Self { left: [0; WIDTH - 1], leaf: true };

    /// The plan for `node` and its costs, from those of its children.
    pub(crate) fn new(
        node: &BinaryNode,
        children: Option<[CollapseCosts; 2]>,
        options: &BuildOptions,
    ) -> (Self, CollapseCosts) {
        let area = node.half_area();
        let blocks = node.count.div_ceil(options.block.max(1) as u32);
        let leaf_cost = area * options.leaf_cost * blocks as f32;
        let Some([left, right]) = children else {
            return (Self::EMPTY, CollapseCosts([leaf_cost; WIDTH - 1]));
        };
        let mut plan = Self { left: [1; WIDTH - 1], ..Self::EMPTY };
        // Slot i - 2 of `shared`: the least cost of exactly i children.
        let mut shared = [f32::INFINITY; WIDTH - 1];
        for (i, (best, choice)) in (2..).zip(shared.iter_mut().zip(&mut plan.left)) {
            for k in 1..i {
                let cost = left.0[k - 1] + right.0[i - k - 1];
                if cost < *best {
                    (*best, *choice) = (cost, k as u8);
                }
            }
        }
        let node_cost = area + shared[WIDTH - 2];
        plan.leaf = node.count as usize <= options.max_leaf.max(1) && leaf_cost <= node_cost;
        let mut costs = [if plan.leaf { leaf_cost } else { node_cost }; WIDTH - 1];
        for i in 1..WIDTH - 1 {
            costs[i] = shared[i - 1];
            if costs[i - 1] <= costs[i] {
                costs[i] = costs[i - 1];
                plan.left[i - 1] = 0;
            }
        }
        (plan, CollapseCosts(costs))
    }
}

/// The eight-wide tree.
#[derive(Debug, Default)]
pub(crate) struct WideTree {
    pub(crate) nodes: Vec<WideNode>,
    /// Leaf `i` holds the items from `leaf_starts[i]` to `leaf_starts[i + 1]`.
    pub(crate) leaf_starts: Vec<u32>,
    /// Levels of nodes above the deepest leaf.
    pub(crate) depth: usize,
}

/// A subtree of the binary tree, by its first node and its first item.
#[derive(Clone, Copy, Default)]
struct Subtree {
    node: usize,
    item: u32,
}

impl WideTree {
    /// The wide tree by the plans of `tree`. The first node is the root, unless `tree` is empty.
    pub(crate) fn collapse(tree: &[BinaryNode]) -> Self {
        let mut wide = Self::default();
        // Rarely are there more nodes than this; unused room costs nothing.
        wide.nodes.reserve(tree.len() / 16);
        prefer_large_pages(&mut wide.nodes);
        if let Some(root) = tree.first() {
            if root.plan.leaf {
                // A node all the same, so that the only box is tested too.
                wide.nodes.push(WideNode::EMPTY);
                let leaf = wide.child(tree, Subtree::default(), 1);
                wide.nodes[0].set(0, root.min, root.max, leaf);
            } else {
                wide.child(tree, Subtree::default(), 0);
            }
            wide.leaf_starts.push(root.count);
        }
        wide.nodes.shrink_to_fit();
        wide
    }

    /// Appends a subtree as a leaf or a node. Nodes and leaves are in depth-first order.
    fn child(&mut self, tree: &[BinaryNode], subtree: Subtree, level: usize) -> NodeChild {
        if tree[subtree.node].plan.leaf {
            let ordinal = self.leaf_starts.len() as u32;
            self.leaf_starts.push(subtree.item);
            self.depth = self.depth.max(level);
            return NodeChild::leaf(ordinal);
        }
        let mut children = Vec::with_capacity(WIDTH);
        gather(tree, subtree, WIDTH, &mut children);
        let index = self.nodes.len();
        self.nodes.push(WideNode::EMPTY);
        for (slot, &below) in children.iter().enumerate() {
            let child = self.child(tree, below, level + 1);
            let binary = &tree[below.node];
            self.nodes[index].set(slot, binary.min, binary.max, child);
        }
        NodeChild::node(index as u32)
    }
}

/// Collects the subtrees that become children of a wide node, `room` of them at most.
fn gather(tree: &[BinaryNode], subtree: Subtree, room: usize, children: &mut Vec<Subtree>) {
    if room < 2 {
        children.push(subtree);
        return;
    }
    match usize::from(tree[subtree.node].plan.left[room - 2]) {
        0 => gather(tree, subtree, room - 1, children),
        to_left => {
            let left = Subtree { node: subtree.node + 1, item: subtree.item };
            let count = tree[left.node].count;
            let right = Subtree { node: left.node + 2 * count as usize - 1, item: subtree.item + count };
            gather(tree, left, to_left, children);
            gather(tree, right, room - to_left, children);
        }
    }
}
