//! Cells of the guide: parts of space, by the direction that a surface faces.
//!
//! Six binary trees over the scene's bounds, one for each of the six axis directions, of which the one nearest to the normal applies: the
//! two sides of a wall and the walls that meet in a corner have separate cells. Boxes with many records are halved across their longest
//! side (@muller2017, where normals are not considered).

use glanz_math::{Bounds3, DVec3};

/// Largest number of halvings.
const MAX_DEPTH: u32 = 40;

/// An inner node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GuideNode {
    /// A node halved across an axis; its lower half is node `low`, the upper half the next node.
    Halved {
        /// 0, 1 or 2.
        axis: u8,
        /// Index of the lower half.
        low: u32,
    },
    /// Cell of this number.
    GuideCell(u32),
}

/// The trees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GuideCells {
    /// Corner of the bounds.
    pub(crate) min: DVec3,
    /// Sides of the bounds, above 0.
    pub(crate) size: DVec3,
    /// The first six are the roots; halves follow their parent.
    pub(crate) nodes: Vec<GuideNode>,
    count: u32,
}

impl GuideCells {
    /// Six cells over `bounds`; where these are empty or have no extent, a box of 1 m around.
    pub(crate) fn new(bounds: &Bounds3) -> Self {
        let usable = !bounds.is_empty() && bounds.is_finite();
        let (min, size) =
            if usable { (bounds.min, bounds.diagonal()) } else { (DVec3::splat(-0.5), DVec3::ONE) };
        let longest = size.max_element();
        // The thickness of flat scenes must not be 0, because it is a divisor; any other value serves.
        let size = if longest > 0.0 { size.max(DVec3::splat(longest * 1e-6)) } else { DVec3::ONE };
        Self { min, size, nodes: (0..6).map(GuideNode::GuideCell).collect(), count: 6 }
    }

    /// The trees with these parts, if they are valid.
    pub(crate) fn from_parts(min: DVec3, size: DVec3, nodes: Vec<GuideNode>) -> Option<Self> {
        let sound = min.is_finite() && size.is_finite() && size.min_element() > 0.0 && nodes.len() >= 6;
        let mut cells = vec![false; nodes.len()];
        // Depth of each node that has a parent.
        let mut depths: Vec<Option<u32>> = (0..nodes.len()).map(|i| (i < 6).then_some(0)).collect();
        let mut count = 0;
        for (i, node) in nodes.iter().enumerate() {
            match *node {
                GuideNode::Halved { axis, low } => {
                    let depth = depths.get(i).copied().flatten()? + 1;
                    if axis > 2 || low as usize <= i || depth > MAX_DEPTH {
                        return None;
                    }
                    for half in [low as usize, low as usize + 1] {
                        // No node has two parents.
                        if depths.get_mut(half)?.replace(depth).is_some() {
                            return None;
                        }
                    }
                }
                GuideNode::GuideCell(cell) => {
                    // Every number occurs once.
                    let seen = cells.get_mut(cell as usize)?;
                    if std::mem::replace(seen, true) {
                        return None;
                    }
                    count += 1;
                }
            }
        }
        let rooted = depths.iter().all(Option::is_some);
        (sound && rooted && cells.iter().take(count as usize).all(|&seen| seen)).then_some(Self {
            min,
            size,
            nodes,
            count,
        })
    }

    /// Number of cells.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The cell of a position whose surface has this unit normal. Positions outside the bounds belong to the cells at their border.
    #[inline]
    pub(crate) fn find(&self, position: DVec3, normal: DVec3) -> u32 {
        let mut place =
            ((position - self.min) / self.size).clamp(DVec3::ZERO, DVec3::splat(1.0 - f64::EPSILON / 2.0));
        let mut node = facing(normal);
        loop {
            match self.nodes.get(node) {
                Some(&GuideNode::Halved { axis, low }) => {
                    let side = &mut place[usize::from(axis.min(2))];
                    *side *= 2.0;
                    let is_high = *side >= 1.0;
                    if is_high {
                        *side -= 1.0;
                    }
                    node = low as usize + usize::from(is_high);
                }
                Some(&GuideNode::GuideCell(cell)) => return cell,
                None => return 0,
            }
        }
    }

    /// The same trees with some cells split, recursively.
    ///
    /// `halvings`: number of halvings of each cell. `copied`: called for each cell of the new trees, in the order of their numbers, with the
    /// number of the old cell that contains it.
    pub(crate) fn halved(&self, halvings: &dyn Fn(u32) -> u32, copied: &mut dyn FnMut(u32)) -> Self {
        let blank = GuideNode::GuideCell(0);
        let mut new = Self { min: self.min, size: self.size, nodes: vec![blank; 6], count: 0 };
        for root in 0..6 {
            new.copy(
                root,
                self,
                SplitCell { node: root, left: None, depth: 0, size: self.size },
                halvings,
                copied,
            );
        }
        new
    }

    fn copy(
        &mut self,
        at: usize,
        old: &Self,
        place: SplitCell,
        halvings: &dyn Fn(u32) -> u32,
        copied: &mut dyn FnMut(u32),
    ) {
        let node = old.nodes.get(place.node).copied();
        let (axis, below) = match (node, place.left) {
            (Some(GuideNode::Halved { axis, low }), _) => (usize::from(axis.min(2)), Some(low as usize)),
            (Some(GuideNode::GuideCell(cell)), left) => {
                let left = left.unwrap_or_else(|| halvings(cell));
                if left == 0 || place.depth >= MAX_DEPTH {
                    if let Some(slot) = self.nodes.get_mut(at) {
                        *slot = GuideNode::GuideCell(self.count);
                    }
                    self.count += 1;
                    copied(cell);
                    return;
                }
                let half = SplitCell { left: Some(left - 1), ..place };
                return self.halve(at, old, [half, half], longest(place.size), halvings, copied);
            }
            (None, _) => return,
        };
        let low = below.unwrap_or(place.node);
        let child = |i| SplitCell { node: low + i, left: None, ..place };
        self.halve(at, old, [child(0), child(1)], axis, halvings, copied);
    }

    fn halve(
        &mut self,
        at: usize,
        old: &Self,
        halves: [SplitCell; 2],
        axis: usize,
        halvings: &dyn Fn(u32) -> u32,
        copied: &mut dyn FnMut(u32),
    ) {
        let low = self.nodes.len();
        if let Some(slot) = self.nodes.get_mut(at) {
            *slot = GuideNode::Halved { axis: axis as u8, low: low as u32 };
        }
        self.nodes.extend([GuideNode::GuideCell(0); 2]);
        for (i, mut half) in halves.into_iter().enumerate() {
            half.depth += 1;
            half.size[axis] *= 0.5;
            self.copy(low + i, old, half, halvings, copied);
        }
    }
}

/// A node of the old trees that is being copied to the new ones.
#[derive(Clone, Copy)]
struct SplitCell {
    node: usize,
    /// Remaining halvings of this cell; `None` before they are determined.
    left: Option<u32>,
    depth: u32,
    size: DVec3,
}

fn longest(size: DVec3) -> usize {
    let [x, y, z] = size.to_array();
    if x >= y && x >= z { 0 } else { usize::from(y < z) + 1 }
}

/// Index of the direction among +x, -x, +y, -y, +z, -z that is nearest to `normal`.
#[inline]
fn facing(normal: DVec3) -> usize {
    let axis = longest(normal.abs());
    2 * axis + usize::from(normal[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> Bounds3 {
        Bounds3::new(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 1.0, 4.0))
    }

    #[test]
    fn sides_of_a_wall_are_different_cells() {
        let cells = GuideCells::new(&bounds());
        let found = |normal| cells.find(DVec3::new(0.0, 0.5, 3.0), normal);
        let mut all =
            [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.1, -0.79)].map(found);
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn cells_are_halved_across_their_longest_side() {
        let mut origin = Vec::new();
        // The cell that faces +y is halved three times: across x (4 m), x again (2 m, as long as z) and z.
        let halved = GuideCells::new(&bounds())
            .halved(&|cell| if cell == 2 { 3 } else { 0 }, &mut |old| origin.push(old));
        assert_eq!((halved.count(), origin.len()), (13, 13));
        assert_eq!(origin.iter().filter(|&&old| old == 2).count(), 8);
        let find = |x, z| halved.find(DVec3::new(x, 0.5, z), DVec3::Y);
        assert_eq!(find(-0.9, 2.1), find(-0.1, 2.9));
        for (x, z) in [(0.1, 2.1), (-0.9, 3.1), (2.9, 2.1)] {
            assert_ne!(find(-0.9, 2.1), find(x, z));
        }
        // Positions outside belong to the cells at the border.
        assert_eq!(find(-50.0, 1.0), find(-0.9, 2.1));
        assert!(
            origin[find(0.5, 3.5) as usize] == 2 && origin[halved.find(DVec3::ZERO, DVec3::Z) as usize] == 4
        );
        // Further halving keeps the earlier halves.
        let again = halved.halved(&|cell| u32::from(cell == find(-0.9, 2.1)), &mut |_| {});
        assert_eq!(again.count(), 14);
        assert_eq!(GuideCells::from_parts(again.min, again.size, again.nodes.clone()), Some(again));
    }

    #[test]
    fn invalid_trees_are_refused() {
        let good = GuideCells::new(&bounds());
        let with = |at: usize, node| {
            let mut nodes = good.nodes.clone();
            nodes[at] = node;
            GuideCells::from_parts(good.min, good.size, nodes)
        };
        assert!(with(5, GuideNode::GuideCell(5)).is_some());
        for node in [
            GuideNode::GuideCell(4),
            GuideNode::GuideCell(9),
            GuideNode::Halved { axis: 0, low: 5 },
            GuideNode::Halved { axis: 3, low: 4 },
        ] {
            assert_eq!(with(5, node), None);
        }
        assert_eq!(with(0, GuideNode::Halved { axis: 0, low: 0 }), None);
        assert_eq!(GuideCells::from_parts(good.min, DVec3::ZERO, good.nodes.clone()), None);
    }

    #[test]
    fn scenes_without_extent_have_cells() {
        for bounds in
            [Bounds3::EMPTY, Bounds3::new(DVec3::ONE, DVec3::ONE), Bounds3::new(DVec3::ZERO, DVec3::X)]
        {
            assert!(GuideCells::new(&bounds).find(DVec3::new(1.0, -2.0, 1e300), DVec3::Z) == 4);
        }
    }
}
