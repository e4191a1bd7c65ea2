//! Paths of rays that gather light.

use glanz_light::Spectrum;
use glanz_math::{DVec3, Frame};
use glanz_sampling::hash::permute;
use glanz_scene::{Interaction, Light, ParametricPoint, Scene};

use super::super::direct::luminance;
use super::super::receiver::BakeReceiver;
use super::super::visibility::MAX_PASSED;
use super::{FinalGather, KEY};

/// Largest number of bounces between surfaces that are near each other.
const MAX_BOUNCES: u32 = 8;

/// End of a ray.
pub(super) struct RayEnd {
    pub(super) at: Interaction,
    pub(super) place: ParametricPoint,
    /// Factor on the light that leaves there.
    pub(super) weight: Spectrum,
}

impl FinalGather<'_> {
    /// Radiosity at the end of a ray: the part from direct light, and an element with the factor on its indirect irradiance.
    ///
    /// An element that is nearer than its size is too coarse: the ray continues from there over the hemisphere until the distance
    /// suffices, as in the gap between a vase and the floor.
    pub(super) fn continue_path(
        &self,
        from: &BakeReceiver,
        end: RayEnd,
        ray: usize,
    ) -> (Spectrum, Option<(u32, Spectrum)>) {
        let (mut light, mut throughput) = (Spectrum::BLACK, Spectrum::ONE);
        let (mut from, mut end) = (*from, end);
        for bounce in 1.. {
            if self.is_dark_at(&end.place) {
                break;
            }
            throughput *= end.weight * self.visibility.albedo(&end.at);
            light += throughput * self.direct_at(&end.place).unwrap_or_default();
            let Some(number) = self.index.element(self.elements, &end.place) else { break };
            let area = self.elements.list.get(number as usize).map_or(0.0, |element| element.area);
            let distance_squared = end.at.point.position.distance_squared(from.at.point.position);
            if distance_squared >= area || bounce > MAX_BOUNCES || throughput.is_black() {
                return (light, Some((number, throughput)));
            }
            let Some(next) = BakeReceiver::new(self.elements, &end.place) else { break };
            // Equal for all receivers, so that adjacent texels agree; different at each bounce.
            let pick = permute(ray as u32, self.directions.len() as u32, KEY + u64::from(bounce));
            let Some(&direction) = self.directions.get(pick as usize) else { break };
            let (emitted, there) =
                self.trace(&next, Frame::from_z(next.shading).to_world(direction), pick as usize);
            light += throughput * emitted;
            let Some(there) = there else { break };
            (from, end) = (next, there);
        }
        (light, None)
    }

    /// Traces a ray; returns pi times the radiance of lights on its way that cannot be sampled, and its end.
    ///
    /// At clear glass it passes straight through or ends, at random with the probability of each.
    pub(super) fn trace(
        &self,
        receiver: &BakeReceiver,
        direction: DVec3,
        ray: usize,
    ) -> (Spectrum, Option<RayEnd>) {
        let (mut found, mut throughput) = (Spectrum::BLACK, Spectrum::ONE);
        if receiver.normal.dot(direction) <= 0.0 {
            // Below the surface, though above the plane of the shading normal: no light arrives from there.
            return (found, None);
        }
        let scene = self.elements.scene;
        let mut segment = receiver.at.spawn(direction);
        for passed in 0..MAX_PASSED {
            let Some((at, place)) = scene.intersect_parametric(&segment, f64::INFINITY) else {
                return (found, None);
            };
            if is_unsampled_light(scene, &at) {
                found += throughput * scene.emitted(&at, at.wo) * std::f32::consts::PI;
            }
            let through = self.visibility.surface_transmittance(&at);
            let probability = luminance(through);
            if probability <= 0.0 {
                return (found, Some(RayEnd { at, place, weight: throughput }));
            }
            // Equal for all receivers, so that adjacent texels agree.
            let turn = permute(ray as u32, self.directions.len() as u32, KEY ^ (u64::from(passed) << 32));
            let pick = (turn as f32 + 0.5) / self.directions.len() as f32;
            if pick >= probability {
                throughput *= 1.0 / (1.0 - probability);
                return (found, Some(RayEnd { at, place, weight: throughput }));
            }
            throughput *= through * (1.0 / probability);
            segment = at.spawn(direction);
        }
        (found, None)
    }
}

/// Whether a surface emits light but cannot be selected by light sampling.
fn is_unsampled_light(scene: &Scene, at: &Interaction) -> bool {
    at.light().is_some_and(|id| match scene.light(id) {
        Some(Light::Area(light)) => luminance(scene.emitted(at, at.wo)) > 0.0 && !light.can_be_sampled(),
        _ => false,
    })
}
