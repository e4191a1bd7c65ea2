//! Counts of the parts of a scene.

use std::collections::BTreeMap;

use glanz_geometry::Surface;

use crate::scene::Scene;

/// Counts of the parts of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneStatistics {
    /// Surfaces by kind; a surface in a group counts once, however often the group is copied.
    pub surfaces: BTreeMap<&'static str, usize>,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Groups that instances copy.
    pub groups: usize,
    /// Instances of groups.
    pub instances: usize,
    /// Lights by kind.
    pub lights: BTreeMap<&'static str, usize>,
    /// Materials.
    pub materials: usize,
}

impl Scene {
    /// Number of searches for hits since the scene was built that could not be decided: pictures may lack points of
    /// freeform surfaces. It is expected to be 0.
    #[must_use]
    pub fn undecided(&self) -> u64 {
        let of_surface = |surface: &Surface| match surface {
            Surface::Freeform(freeform) => freeform.undecided(),
            _ => 0,
        };
        self.groups.iter().flat_map(|group| &group.objects).map(|object| of_surface(object.surface())).sum()
    }

    /// Counts the parts of the scene.
    #[must_use]
    pub fn statistics(&self) -> SceneStatistics {
        let mut statistics = SceneStatistics {
            groups: self.groups.len().saturating_sub(1),
            materials: self.materials.len(),
            ..SceneStatistics::default()
        };
        for group in self.groups.iter() {
            statistics.instances += group.instances.len();
            for object in &group.objects {
                *statistics.surfaces.entry(object.surface().kind()).or_default() += object.shape_count();
                if let Surface::Mesh(mesh) = object.surface() {
                    statistics.triangles += mesh.indices().len() - mesh.degenerate();
                }
            }
        }
        for light in self.lights.iter() {
            *statistics.lights.entry(light.kind()).or_default() += 1;
        }
        statistics
    }
}
