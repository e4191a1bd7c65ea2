//! Rays through participating media: free paths, and the light that is left of a shadow ray.

use glanz_geometry::BoundedRay;
use glanz_light::{LaneChoice, Spectrum, Wavelengths};
use glanz_math::Ray;
use glanz_sampling::hash::{combine, unit_f64};
use glanz_scene::medium::{MediumCoefficients, transmittance};
use glanz_scene::{Interaction, Medium, MediumId};
use glanz_shading::Bsdf;

use super::Context;
use super::path_state::PathState;
use super::path_tracer::{DirectionSampler, INTERFACE_LIMIT, PathTracer};
use super::vertex::Vertex;

/// The first dimension of the sampler for media, four for each segment of a path: beyond those of scattering events.
const FIRST_MEDIUM_DIMENSION: u32 = 1 << 30;

/// Largest number of tentative collisions on a ray: one with more is in a medium so dense that it makes no progress, and counts as absorbed.
const COLLISION_LIMIT: u32 = 1 << 20;

/// Transmittance below which ratio tracking continues with a probability of [`ROULETTE_SURVIVAL`] only.
const ROULETTE_BELOW: f32 = 0.05;
const ROULETTE_SURVIVAL: f32 = 0.25;

/// Numbers uniform in [0, 1) for a ray through a medium, whose number is not known in advance: three of a sampler, then hashes.
#[derive(Clone, Copy, Debug)]
struct TrackingNumbers {
    first: [f64; 3],
    key: u64,
    used: usize,
}

impl TrackingNumbers {
    /// The first three numbers of a group of a sampler come first, the last one is the key of all others.
    fn of_group([a, b, c, key]: [f64; 4]) -> Self {
        Self { first: [a, b, c], key: key.to_bits(), used: 0 }
    }

    /// Numbers that depend on a single one.
    fn of_number(xi: f64) -> Self {
        Self { first: [0.0; 3], key: xi.to_bits(), used: 3 }
    }

    fn next(&mut self) -> f64 {
        let number = self.used;
        self.used += 1;
        let hashed = || unit_f64(combine(self.key, number as u64));
        self.first.get(number).copied().unwrap_or_else(hashed)
    }

    /// A number of the exponential distribution with mean 1.
    fn next_exponential(&mut self) -> f64 {
        -(-self.next()).ln_1p()
    }
}

/// Result of tracking a path through a medium.
#[derive(Clone, Copy, Debug)]
struct MediumPassage {
    /// Factor on the throughput; black if nothing is left.
    factor: Spectrum,
    /// Ray parameter at which it is scattered; `None` if it gets through.
    scattered_at: Option<f64>,
}

/// Samples the free path of a ray with `0 < t < t_max`, by delta tracking under the bounds of the medium's segments.
///
/// A collision is sampled for one lane, chosen in proportion to `throughput`, and weighted for all by [`LaneChoice`]: the sum of the lanes never grows.
/// Real and null collisions have the same probability in all lanes, since density does not depend on them. Absorption is a weight, no end of the path; in
/// a medium that does not scatter, nothing is sampled where it is homogeneous.
///
/// # Source
/// @novak2018 sections 3 and 5 (null collisions, spectral media); @miller2019 (weights of lanes; departure: the lane is chosen anew for each
/// collision by what is left in it, which is its probability given the path so far and needs no state).
fn track(
    medium: &Medium,
    ray: &Ray,
    t_max: f64,
    throughput: Spectrum,
    wavelengths: &Wavelengths,
    numbers: &mut TrackingNumbers,
) -> MediumPassage {
    let MediumCoefficients { extinction, albedo, .. } = medium.coefficients(wavelengths);
    if albedo.is_black() {
        return MediumPassage {
            factor: remaining(medium, ray, t_max, wavelengths, numbers),
            scattered_at: None,
        };
    }
    let length = ray.direction.length();
    let absorbed = MediumPassage { factor: Spectrum::BLACK, scattered_at: None };
    let (mut factor, mut collisions) = (Spectrum::ONE, 0);
    for segment in medium.segments(ray, t_max) {
        let extinction = extinction * segment.density;
        let mut t = segment.start;
        loop {
            let Some(lanes) = LaneChoice::try_new(throughput * factor, wavelengths) else { return absorbed };
            let rate = f64::from(lanes.select(extinction, numbers.next()));
            // Nothing is in the way of a lane without extinction.
            let distance = if rate > 0.0 { numbers.next_exponential() / rate } else { f64::INFINITY };
            let rest = (segment.end - t) * length;
            if distance >= rest {
                factor *= lanes.balanced(transmittance(extinction, rest));
                break;
            }
            t += distance / length;
            factor *= lanes.balanced(extinction * transmittance(extinction, distance));
            if numbers.next() * f64::from(segment.density) < medium.density(ray.at(t)) {
                return MediumPassage { factor: factor * albedo, scattered_at: Some(t) };
            }
            collisions += 1;
            if collisions > COLLISION_LIMIT {
                return absorbed;
            }
        }
    }
    MediumPassage { factor, scattered_at: None }
}

/// The fraction of light left of a ray with `0 < t < t_max`: in homogeneous media by Beer's law, in others estimated by ratio tracking with the largest
/// lane.
///
/// # Source
/// @novak2014 section 4.1.
fn remaining(
    medium: &Medium,
    ray: &Ray,
    t_max: f64,
    wavelengths: &Wavelengths,
    numbers: &mut TrackingNumbers,
) -> Spectrum {
    let (length, extinction) = (ray.direction.length(), medium.coefficients(wavelengths).extinction);
    if medium.is_homogeneous() {
        return transmittance(extinction, t_max * length);
    }
    let largest = extinction.max_component();
    let (mut left, mut collisions) = (Spectrum::one(wavelengths), 0);
    for segment in medium.segments(ray, t_max) {
        let rate = f64::from(largest) * f64::from(segment.density) * length;
        let mut t = segment.start;
        loop {
            t += numbers.next_exponential() / rate;
            if t >= segment.end {
                break;
            }
            let share = (medium.density(ray.at(t)) / f64::from(segment.density)).min(1.0) as f32;
            left *= extinction.map(|sigma| 1.0 - share * (sigma / largest));
            if left.max_component() < ROULETTE_BELOW {
                if numbers.next() >= f64::from(ROULETTE_SURVIVAL) {
                    return Spectrum::BLACK;
                }
                left *= 1.0 / ROULETTE_SURVIVAL;
            }
            collisions += 1;
            if collisions > COLLISION_LIMIT {
                return Spectrum::BLACK;
            }
        }
    }
    left
}

impl PathTracer {
    /// Follows a path through its medium up to the ray parameter `end`: adds emitted light and samples where it is scattered. `None` if it gets through;
    /// otherwise, whether it continues.
    pub(super) fn pass_medium<D: DirectionSampler>(
        &self,
        context: &mut Context<'_>,
        directions: &mut D,
        path: &mut PathState<D::VertexData>,
        end: f64,
        branches: &mut Vec<PathState<D::VertexData>>,
    ) -> Option<bool> {
        let medium = context.scene.medium(path.medium)?;
        let segment = path.depth.wrapping_mul(INTERFACE_LIMIT + 1).wrapping_add(path.interfaces);
        let mut sampler = context.sampler.with_index(path.sampler_index);
        sampler.skip_to_dimension(FIRST_MEDIUM_DIMENSION.wrapping_add(segment.wrapping_mul(4)));
        let mut numbers = TrackingNumbers::of_group(sampler.next_group());
        let coefficients = medium.coefficients(&context.wavelengths);
        if !coefficients.source.is_black() {
            path.light += path.throughput * coefficients.emitted(end * path.ray.direction.length());
        }
        let passage = track(medium, &path.ray, end, path.throughput, &context.wavelengths, &mut numbers);
        let before = path.throughput;
        path.throughput *= passage.factor;
        path.importance *= passage.factor;
        if path.throughput.is_black() {
            return Some(false);
        }
        directions.record_medium(before, path.throughput);
        let t = passage.scattered_at?;
        if path.depth >= self.max_depth {
            return Some(false);
        }
        let at = Interaction::in_medium(path.ray.at(t), t, -path.ray.direction.normalize());
        let vertex = Vertex::new(&at, Bsdf::Medium(medium.phase()));
        Some(self.scatter_at_or_divide(context, directions, path, &vertex, branches))
    }
}

/// The fraction of light that media leave of a shadow ray that nothing stops and that starts in `medium`. `xi`: a number uniform in [0, 1).
///
/// Where media end at interfaces, the ray is traced from one surface to the next; what it passes by its opacity has no part in this.
pub(super) fn shadow_transmittance(
    context: &mut Context<'_>,
    shadow: &BoundedRay,
    mut medium: MediumId,
    xi: f64,
) -> Spectrum {
    let (scene, mut numbers) = (context.scene, TrackingNumbers::of_number(xi));
    let BoundedRay { mut ray, t_max: mut end } = *shadow;
    let mut left = Spectrum::one(&context.wavelengths);
    for _ in 0..INTERFACE_LIMIT {
        let hit = if scene.has_open_media() {
            context.counters.closest += 1;
            scene.intersect(&ray, end)
        } else {
            None
        };
        if let Some(medium) = scene.medium(medium) {
            left *= remaining(medium, &ray, hit.map_or(end, |hit| hit.t), &context.wavelengths, &mut numbers);
        }
        let Some(hit) = hit.filter(|_| !left.is_black()) else { return left };
        if hit.is_interface(scene) {
            medium = hit.medium_towards(ray.direction, medium);
        }
        ray = hit.spawn(ray.direction);
        end -= hit.t;
    }
    Spectrum::BLACK
}
