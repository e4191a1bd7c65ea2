//! A scene without some of its shapes.

use std::collections::{BTreeSet, HashMap};

use glanz_scene::Description;
use glanz_scene::description::{DesignDescription, GroupDescription};

/// The scene without the leaves `hidden`, numbered as in [`Model`](super::Model).
///
/// Groups whose copies lose different shapes are duplicated.
#[must_use]
pub fn without(description: &Description, hidden: &BTreeSet<u32>) -> Description {
    let mut counts: Vec<u64> = Vec::with_capacity(description.groups.len());
    for group in &description.groups {
        let copied = group.instances.iter().filter_map(|instance| counts.get(instance.group));
        counts.push(copied.fold(group.shapes.len() as u64, |sum, count| sum.saturating_add(*count)));
    }
    let mut pruning = Pruning {
        description,
        counts,
        hidden,
        groups: description.groups.clone(),
        pruned_groups: HashMap::new(),
    };
    let world = pruning.pruned(&description.world, 0);
    Description {
        observers: description.observers.clone(),
        files: description.files.clone(),
        camera: description.camera.clone(),
        film: description.film.clone(),
        filter: description.filter,
        sampler: description.sampler.clone(),
        integrator: description.integrator.clone(),
        images: description.images.clone(),
        textures: description.textures.clone(),
        materials: description.materials.clone(),
        media: description.media.clone(),
        camera_medium: description.camera_medium,
        lights: description.lights.clone(),
        backdrop: description.backdrop.clone(),
        groups: pruning.groups,
        // The page has sections of its own.
        section: None,
        world,
        // Its indices would be those of other shapes.
        design: DesignDescription::default(),
    }
}

struct Pruning<'a> {
    description: &'a Description,
    /// Leaves of each group.
    counts: Vec<u64>,
    hidden: &'a BTreeSet<u32>,
    /// The groups of the description, then pruned groups.
    groups: Vec<GroupDescription>,
    /// Indices of pruned groups, by group and its hidden leaves relative to its first leaf.
    pruned_groups: HashMap<(usize, Vec<u64>), usize>,
}

impl Pruning<'_> {
    /// Visible part of a group whose first leaf has the number `first`.
    fn pruned(&mut self, group: &GroupDescription, first: u64) -> GroupDescription {
        let hidden = self.hidden;
        let is_hidden = |leaf: u64| u32::try_from(leaf).is_ok_and(|leaf| hidden.contains(&leaf));
        let kept = (first..).zip(&group.shapes).filter(|&(leaf, _)| !is_hidden(leaf));
        let shapes = kept.map(|(_, shape)| shape.clone()).collect();
        let mut instances = Vec::with_capacity(group.instances.len());
        let mut next = first.saturating_add(group.shapes.len() as u64);
        for instance in &group.instances {
            let count = self.counts.get(instance.group).copied().unwrap_or_default();
            let start = next;
            next = next.saturating_add(count);
            let lost = self.lost(start, next);
            if lost.is_empty() {
                instances.push(instance.clone());
            } else if (lost.len() as u64) < count
                && let Some(group) = self.without(instance.group, start, lost)
            {
                let mut instance = instance.clone();
                instance.group = group;
                instances.push(instance);
            }
        }
        // Edges refer to shapes by their numbers, and no ray meets them.
        GroupDescription { name: group.name.clone(), shapes, instances, edges: Vec::new() }
    }

    /// The hidden leaves from `start` to `end` (not included), relative to the first.
    fn lost(&self, start: u64, end: u64) -> Vec<u64> {
        let Ok(first) = u32::try_from(start) else { return Vec::new() };
        let all = self.hidden.range(first..).map(|&leaf| u64::from(leaf));
        all.take_while(|&leaf| leaf < end).map(|leaf| leaf - start).collect()
    }

    /// The index of the group `index` without `lost`; its leaves begin with `start`.
    fn without(&mut self, index: usize, start: u64, lost: Vec<u64>) -> Option<usize> {
        let key = (index, lost);
        if let Some(&known) = self.pruned_groups.get(&key) {
            return Some(known);
        }
        let description = self.description;
        let left = self.pruned(description.groups.get(index)?, start);
        self.groups.push(left);
        self.pruned_groups.insert(key, self.groups.len() - 1);
        Some(self.groups.len() - 1)
    }
}
