//! The leaves of a surface before its hierarchy is built.

use glanz_math::Bounds3;

use super::build::{CHUNK, PatchLeaves};
use super::leaf::PatchLeaf;
use super::leaf_builder::LeafBuilder;
use super::ray_space::SurfaceFrame;
use super::reduced_net::ReducedNet;
use super::subpatches::Subpatch;
use crate::bvh::parallel_map;

/// Leaves and their boxes. The control points of their parts are gone: those of a million patches would take more memory than the surface.
#[derive(Default)]
pub(super) struct LeafList {
    pub(super) leaves: Vec<PatchLeaf>,
    pub(super) boxes: Vec<Bounds3>,
    pub(super) reduced_nets: Vec<ReducedNet>,
    /// Parts without area, which are kept only if there are no others.
    pub(super) lines: Vec<(PatchLeaf, Bounds3)>,
    /// Patches with such parts.
    pub(super) without_area: Vec<u32>,
}

impl LeafList {
    /// All that `append` adds for each element of `list` and its position, in the order of `list`; in parallel.
    pub(super) fn new<T: Sync>(list: &[T], append: impl Fn(usize, &T, &mut Self) + Sync + Send) -> Self {
        let chunks: Vec<_> = (0..).step_by(CHUNK).zip(list.chunks(CHUNK)).collect();
        let parts = parallel_map(&chunks, 1, |&(first, elements)| {
            let mut part = Self::default();
            (first..).zip(elements).for_each(|(index, element)| append(index, element, &mut part));
            part
        });
        let mut all = Self::default();
        parts.into_iter().for_each(|part| all.append(part));
        all
    }

    /// Adds the leaves of a subpatch, with coordinates relative to the centre of the surface.
    pub(super) fn push_all(&mut self, found: &PatchLeaves, subpatch: &Subpatch, frame: &SurfaceFrame) {
        let of =
            |leaf: &LeafBuilder| (PatchLeaf::new(leaf, frame.center), frame.bounds_in_common(leaf.bounds));
        for builder in &found.leaves {
            let (mut leaf, bounds) = of(builder);
            if let Some(net) = ReducedNet::new(&subpatch.homogeneous_net(), builder.part, frame) {
                leaf.reduced_net = self.reduced_nets.len() as u32;
                self.reduced_nets.push(net);
            }
            self.leaves.push(leaf);
            self.boxes.push(bounds);
        }
        self.lines.extend(found.lines.iter().map(of));
        self.without_area.extend((!found.lines.is_empty()).then_some(subpatch.location.patch));
    }

    pub(super) fn append(&mut self, part: Self) {
        let first = self.reduced_nets.len() as u32;
        self.leaves.extend(part.leaves.into_iter().map(|mut leaf| {
            if leaf.reduced_net != PatchLeaf::NO_NET {
                leaf.reduced_net += first;
            }
            leaf
        }));
        self.reduced_nets.extend(part.reduced_nets);
        self.boxes.extend(part.boxes);
        self.lines.extend(part.lines);
        self.without_area.extend(part.without_area);
    }

    pub(super) fn reverse(&mut self) {
        self.leaves.reverse();
        self.boxes.reverse();
    }
}
