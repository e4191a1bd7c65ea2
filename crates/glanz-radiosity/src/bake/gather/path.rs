//! Paths of rays that gather light.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec3, Ray};
use glanz_sampling::hash::permute;
use glanz_scene::{BatchedPath, Interaction, Light, ParametricPoint, Scene, SceneHit};
use glanz_shading::Bsdf;

use super::super::direct::luminance;
use super::super::receiver::BakeReceiver;
use super::super::visibility::MAX_PASSED;
use super::{FinalGather, KEY};

/// Largest number of bounces between surfaces that are near each other.
const MAX_BOUNCES: u32 = 8;

/// Squared distance of the middle of an element, in areas of the element, below which it is too coarse.
const NEAR_AREAS: f64 = 2.0;

/// Light gathered along the path of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PathLight {
    /// pi times the radiance of lights on the ray that cannot be sampled.
    pub(super) emitted: Spectrum,
    /// End of the ray; `None` if it has none, or was not traced because no light arrives from below the surface.
    pub(super) end: Option<RayEnd>,
    /// Whether the ray leaves the scene.
    pub(super) leaves_scene: bool,
    /// Radiosity at the end by direct light.
    pub(super) direct: Spectrum,
    /// An element, and the factor on its indirect irradiance for the rest of the radiosity at the end.
    pub(super) element: Option<(u32, Spectrum)>,
}

/// End of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayEnd {
    /// Distance from the origin, metres.
    pub(super) distance: f64,
    /// Whether light reaches the chart there.
    pub(super) is_lit: bool,
}

impl FinalGather<'_> {
    /// Light along paths from receivers, each with a direction around z and a number that selects the directions of further rays.
    ///
    /// All paths advance from surface to surface together, so that their rays are traced as batches.
    pub(super) fn trace_paths<'a>(
        &self,
        starts: impl Iterator<Item = (&'a BakeReceiver, DVec3, usize)>,
    ) -> Vec<PathLight> {
        let mut traced = GatherBatch { gather: self, lights: Vec::new() };
        let mut paths: Vec<GatherPath> = Vec::new();
        for (receiver, direction, number) in starts {
            let path = GatherPath::new(receiver, direction, number as u32, traced.lights.len());
            paths.extend(path);
            traced.lights.push(PathLight::default());
        }
        self.elements.scene.trace_paths(&mut paths, &mut traced);
        traced.lights
    }

    /// Whether a ray from a receiver in one of the directions leaves the scene or ends at a point that satisfies `condition`; `false` for
    /// directions below the surface.
    pub(super) fn ray_sees(
        &self,
        receiver: &BakeReceiver,
        number: usize,
        condition: impl Fn(&ParametricPoint) -> bool,
    ) -> bool {
        let direction = self.directions.get(number);
        let ray = direction.and_then(|&direction| GatherRay::new(receiver, number as u32, direction));
        let Some(mut ray) = ray else { return false };
        loop {
            let found = self.elements.scene.intersect_parametric(&ray.segment, f64::INFINITY);
            let Some((at, place)) = found else { return true };
            match ray.meet(self, &at) {
                SurfaceEvent::Pass => {}
                SurfaceEvent::End(_) => return condition(&place),
                SurfaceEvent::Lost => return false,
            }
        }
    }
}

/// A ray that passes clear glass.
#[derive(Clone, Copy)]
struct GatherRay {
    /// Its part behind the last surface.
    segment: Ray,
    /// Its number among those of a receiver.
    number: u32,
    /// Number of surfaces that it passed.
    passed: u32,
    /// pi times the radiance of lights on its way that cannot be sampled.
    emitted: Spectrum,
    /// Factor on the light that leaves at its end.
    weight: Spectrum,
}

/// What happens to a ray at a surface.
enum SurfaceEvent<'a> {
    Pass,
    /// It ends; the BSDF there, `None` on an interface.
    End(Option<Bsdf<'a>>),
    /// It passed too many surfaces.
    Lost,
}

impl GatherRay {
    /// A ray in a direction around z, turned to the receiver; `None` below the surface, though above the plane of the shading normal:
    /// no light arrives from there.
    fn new(receiver: &BakeReceiver, number: u32, direction: DVec3) -> Option<Self> {
        let direction = receiver.frame().to_world(direction);
        (receiver.normal.dot(direction) > 0.0).then(|| Self {
            segment: receiver.at.spawn(direction),
            number,
            passed: 0,
            emitted: Spectrum::BLACK,
            weight: Spectrum::ONE,
        })
    }

    /// Continues from a surface. At clear glass a ray passes straight through or ends, at random with the probability of each.
    fn meet<'a>(&mut self, gather: &FinalGather<'a>, at: &Interaction) -> SurfaceEvent<'a> {
        let scene = gather.elements.scene;
        if is_unsampled_light(scene, at) {
            self.emitted += self.weight * scene.emitted(at, at.wo) * std::f32::consts::PI;
        }
        let bsdf = at.bsdf(scene, &Wavelengths::default());
        let through = gather.visibility.bsdf_transmittance(at, bsdf.as_ref());
        let probability = luminance(through);
        if probability <= 0.0 {
            return SurfaceEvent::End(bsdf);
        }
        // Equal for all receivers, so that adjacent texels agree.
        let count = gather.directions.len();
        let turn = permute(self.number, count as u32, KEY ^ (u64::from(self.passed) << 32));
        let pick = (turn as f32 + 0.5) / count as f32;
        if pick >= probability {
            self.weight *= 1.0 / (1.0 - probability);
            return SurfaceEvent::End(bsdf);
        }
        self.weight *= through * (1.0 / probability);
        self.segment = at.spawn(self.segment.direction);
        self.passed += 1;
        if self.passed < MAX_PASSED { SurfaceEvent::Pass } else { SurfaceEvent::Lost }
    }
}

/// Light gathered by paths that are traced together.
struct GatherBatch<'a, 'b> {
    gather: &'b FinalGather<'a>,
    lights: Vec<PathLight>,
}

/// State of a path between its surfaces.
struct GatherPath {
    /// Its index among the paths that are traced together.
    slot: usize,
    /// The number of its first ray.
    number: u32,
    ray: GatherRay,
    /// Origin of the ray.
    from: DVec3,
    /// Rays before this one.
    bounces: u32,
    throughput: Spectrum,
    /// Whether it has no further ray.
    has_ended: bool,
}

impl GatherPath {
    /// A path that starts at a receiver; `None` if no light arrives from there.
    fn new(receiver: &BakeReceiver, direction: DVec3, number: u32, slot: usize) -> Option<Self> {
        let ray = GatherRay::new(receiver, number, direction)?;
        let (from, throughput) = (receiver.at.point.position, Spectrum::ONE);
        Some(Self { has_ended: false, slot, number, ray, from, bounces: 0, throughput })
    }

    /// Continues from the hit of the ray, and adds the light found there to `light`. Returns whether the path has another ray.
    ///
    /// An element that is nearer than its size is too coarse: the path continues from there over the hemisphere until the distance
    /// suffices, as in the gap between a vase and the floor.
    fn continue_at(
        &mut self,
        gather: &FinalGather<'_>,
        hit: Option<&SceneHit>,
        light: &mut PathLight,
    ) -> bool {
        let scene = gather.elements.scene;
        let end = hit.map(|hit| (hit, scene.interaction(&self.ray.segment, hit)));
        let event = end.as_ref().map_or(SurfaceEvent::Lost, |(_, at)| self.ray.meet(gather, at));
        if matches!(event, SurfaceEvent::Pass) {
            return true;
        }
        if self.bounces == 0 {
            light.leaves_scene = hit.is_none();
            light.emitted = self.ray.emitted;
        } else {
            light.direct += self.throughput * self.ray.emitted;
        }
        let (Some((hit, at)), SurfaceEvent::End(bsdf)) = (&end, event) else { return false };
        let place = scene.parametric_point(hit, at);
        let texel = gather.index.texel(gather.charts, &place);
        if self.bounces == 0 {
            let distance = at.point.position.distance(self.from);
            light.end =
                Some(RayEnd { distance, is_lit: texel.is_none_or(|(chart, _)| gather.is_lit[chart]) });
        }
        if texel.is_some_and(|(chart, _)| gather.is_dark[chart]) {
            return false;
        }
        self.throughput *= self.ray.weight * gather.visibility.albedo(at, bsdf.as_ref());
        light.direct += self.throughput * texel.and_then(|texel| gather.direct_on(texel)).unwrap_or_default();
        let Some(number) = gather.index.element(gather.elements, &place) else { return false };
        self.bounces += 1;
        // The same for all points of an element: of one that is seen from its edge, the far part alone is no sample.
        let is_far = gather.elements.list.get(number as usize).is_none_or(|element| {
            element.center.position.distance_squared(self.from) >= NEAR_AREAS * element.area
        });
        if is_far || self.bounces > MAX_BOUNCES || self.throughput.is_black() {
            light.element = Some((number, self.throughput));
            return false;
        }
        self.continue_from(gather, &place)
    }

    /// Continues from a point over its hemisphere. Returns whether there is a ray.
    fn continue_from(&mut self, gather: &FinalGather<'_>, place: &ParametricPoint) -> bool {
        let Some(next) = BakeReceiver::new(gather.elements, place) else { return false };
        // Equal for all receivers, so that adjacent texels agree; different at each bounce.
        let pick = permute(self.number, gather.directions.len() as u32, KEY + u64::from(self.bounces));
        let Some(&direction) = gather.directions.get(pick as usize) else { return false };
        let Some(ray) = GatherRay::new(&next, pick, direction) else { return false };
        self.ray = ray;
        self.from = next.at.point.position;
        true
    }
}

impl<'a, 'b> BatchedPath<GatherBatch<'a, 'b>> for GatherPath {
    fn ray(&self) -> Option<Ray> {
        (!self.has_ended).then_some(self.ray.segment)
    }

    fn advance(&mut self, traced: &mut GatherBatch<'a, 'b>, hit: Option<&SceneHit>, _: &mut Vec<Self>) {
        self.has_ended = !self.continue_at(traced.gather, hit, &mut traced.lights[self.slot]);
    }
}

/// Whether a surface emits light but cannot be selected by light sampling.
fn is_unsampled_light(scene: &Scene, at: &Interaction) -> bool {
    at.light().is_some_and(|id| match scene.light(id) {
        Some(Light::Area(light)) => luminance(scene.emitted(at, at.wo)) > 0.0 && !light.can_be_sampled(),
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, Silent};

    use glanz_math::DVec2;
    use glanz_scene::description::{GeometryDescription, ShapeDescription};

    use super::super::super::{BakeMethod, BakeProgress, BakeSettings, BakeState, direct};
    use super::*;
    use crate::bake::lookup::SurfaceIndex;
    use crate::charts::charts;
    use crate::elements::{ElementSettings, Elements};
    use crate::scenes::{parallelogram, scene, walls};

    #[test]
    fn paths_do_not_depend_on_those_traced_with_them() {
        // Elements as large as the walls: paths from near their edges bounce several times.
        let scene = scene(walls(DVec3::ONE).into_iter().map(|wall| (wall, 0.7, 1.0)).collect());
        let settings = BakeSettings { density: 3.0, rays: 64, shadow_rays: 16, method: BakeMethod::Gather };
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let charts = charts(&elements.surfaces, settings.density);
        let (mut sink, cancel) = (Silent, CancelFlag::default());
        let mut progress = BakeProgress::new(&mut sink, &cancel, 3);
        let mut state = BakeState::default();
        let direct =
            direct::light_on_charts(&elements, &charts, &settings, None, &mut state, &mut progress).unwrap();
        let index = SurfaceIndex::new(&elements, &charts);
        let gather = FinalGather::new(&elements, &index, &charts, &direct, &settings);
        let places = elements.list.iter().map(super::super::element_center);
        let receivers: Vec<BakeReceiver> =
            places.filter_map(|place| BakeReceiver::new(&elements, &place)).collect();
        let directions = gather.directions.iter().copied().zip(0..64);
        let starts: Vec<(&BakeReceiver, DVec3, usize)> =
            directions.flat_map(|(way, i)| receivers.iter().map(move |at| (at, way, i))).collect();
        let together = gather.trace_paths(starts.iter().copied());
        let alone: Vec<PathLight> =
            starts.iter().flat_map(|&start| gather.trace_paths(std::iter::once(start))).collect();
        assert_eq!(together, alone);
        // Some end at an element, others after bounces at none.
        let ends = together.iter().filter(|light| light.element.is_some()).count();
        assert!(ends > 100 && together.iter().any(|light| light.end.is_none()), "{ends}");
    }

    #[test]
    fn directions_below_the_surface_do_not_leave_the_scene() {
        // A triangle with inclined shading normals inside a box above a lit floor: no light is visible from it.
        let corners = [DVec3::new(0.2, 0.2, 0.2), DVec3::new(0.8, 0.2, 0.2), DVec3::new(0.2, 0.8, 0.2)];
        let inclined = GeometryDescription::Triangles {
            positions: corners.to_vec(),
            indices: vec![[0, 1, 2]],
            normals: Some(vec![DVec3::new(2.0, 0.0, 1.0); 3]),
            uvs: None,
        };
        let scene = scene(vec![
            (parallelogram(DVec3::new(-1.0, -1.0, -0.5), DVec3::X * 3.0, DVec3::Y * 3.0), 0.5, 0.0),
            (ShapeDescription::cuboid(DVec3::ZERO, DVec3::ONE), 0.5, 0.0),
            (inclined.into(), 0.5, 0.0),
            (parallelogram(DVec3::new(0.0, 0.0, 2.0), DVec3::Y, DVec3::X), 0.5, 1.0),
        ]);
        let settings = BakeSettings { density: 3.0, rays: 64, shadow_rays: 16, method: BakeMethod::Gather };
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let charts = charts(&elements.surfaces, settings.density);
        let (mut sink, cancel) = (Silent, CancelFlag::default());
        let mut progress = BakeProgress::new(&mut sink, &cancel, 3);
        let mut state = BakeState::default();
        let direct =
            direct::light_on_charts(&elements, &charts, &settings, None, &mut state, &mut progress).unwrap();
        let index = SurfaceIndex::new(&elements, &charts);
        let gather = FinalGather::new(&elements, &index, &charts, &direct, &settings);
        let receiver = |z: f64| {
            let surface = elements
                .surfaces
                .iter()
                .position(|surface| (surface.bounds().max.z - z).abs() < 1e-6)
                .unwrap() as u32;
            let place = ParametricPoint { surface, face: 0, back: false, uv: DVec2::splat(0.3) };
            BakeReceiver::new(&elements, &place).unwrap()
        };
        let inside = receiver(0.2);
        assert!(inside.normal.dot(inside.shading) < 0.5);
        assert!(!gather.sees_light(&inside) && !gather.gather(&[inside])[0].sees_light);
        let floor = receiver(-0.5);
        assert!(gather.sees_light(&floor) && gather.gather(&[floor])[0].sees_light);
    }
}
