//! Weights of the techniques that find a path, computed along either path.
//!
//! A path z_0 ... z_k leads from a light (z_0) to the camera (z_k). Three techniques find it, each with its densities per area of all vertices:
//!
//! - *hit*: a path from the camera samples every vertex and hits the light by chance;
//! - *sampled*: a path from the camera ends at z_1, and z_0 is sampled on the light;
//! - *sent*: a path from the light samples z_0 ... z_(k-1) and is connected to the camera.
//!
//! Let e be the density of emission per square metre across the ray and steradian ([`Scene::emission_pdf`](glanz_scene::Scene::emission_pdf)), c
//! the density of film points per square metre across the ray at z_(k-1) ([`Camera::density`](glanz_scene::Camera::density)), N the number of
//! paths sent for one sample of every pixel, p_N the density per solid angle with which z_1 samples the light, and at z_j: a_j and b_j the
//! cosines between the directions to light and camera and the normal, p_j and q_j the densities per solid angle with which a path from the
//! camera continues to z_(j-1), and one from the light to z_(j+1). The squared lengths of the segments are in the densities of both
//! directions and cancel, which gives
//!
//! ```text
//! sent / hit     = N e / c  *  product over j = 1 .. k-1 of a_j / (b_j p_j)  *  product over j = 1 .. k-2 of q_j
//! sampled / hit  = p_N / p_1
//! ```
//!
//! A path from the camera has the factors of the last vertices, one from the light those of the first; the others are added at their ends.
//! At a mirror or glass, each direction determines the other: the factor of the vertex is 1 (except for squared refractive
//! indices, which cancel when light leaves the medium that it entered), p_1 is infinite, and nothing can be sampled or connected there: these
//! techniques have density 0. For delta lights, e is per square metre across the ray at z_1, p_N is 1 and *hit* has density 0.
//!
//! The weight of a technique is that of the power heuristic, w = 1 / (1 + sum of (other / own)^2). The weights of a path add up to 1 for
//! any numbers in place of the densities, provided that all techniques use the same ones and a technique that cannot find the path has 0 in
//! all of them. Russian roulette is therefore omitted.
//!
//! # Source
//! @veach1997 chapters 9 and 10; @georgiev2012 for running quantities in place of whole paths.

/// Densities at a scattering vertex that the MIS weights need.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScatteringDensities {
    /// Cosine between the direction to the light and the normal, above 0.
    pub(super) light_cos: f64,
    /// Cosine between the direction to the camera and the normal, above 0.
    pub(super) camera_cos: f64,
    /// Density per solid angle with which a path from the camera continues to the light.
    pub(super) light_pdf: f64,
    /// Density per solid angle with which a path from the light continues to the camera.
    pub(super) camera_pdf: f64,
}

/// Partial MIS sums of a camera path at a vertex z_j: sent / hit without the factors of z_0 to z_j.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraPathWeights {
    sent: f64,
    /// Whether this is the first vertex after the camera.
    is_first: bool,
}

impl CameraPathWeights {
    /// The sums at the first vertex. `light_paths`: N, 0 without light paths; `density`: c.
    pub(super) fn new(light_paths: f64, density: f64) -> Self {
        Self { sent: if light_paths > 0.0 { light_paths / density } else { 0.0 }, is_first: true }
    }

    /// The factor of the vertex without the density of continuing to the light.
    fn factor(&self, turn: &ScatteringDensities) -> f64 {
        // A path from the light is connected to the camera here, so that no continuation is sampled.
        let onwards = if self.is_first { 1.0 } else { turn.camera_pdf };
        turn.light_cos / turn.camera_cos * onwards
    }

    /// At the next vertex, where light is scattered at this one.
    pub(super) fn scattered(&self, turn: &ScatteringDensities) -> Self {
        Self { sent: self.sent * self.factor(turn) / turn.light_pdf, is_first: false }
    }

    /// At the next vertex, where this one is mirror or glass. `both_ways`: whether a walk from the light could come this way.
    pub(super) fn mirrored(&self, both_ways: bool) -> Self {
        Self { sent: if self.is_first || !both_ways { 0.0 } else { self.sent }, is_first: false }
    }

    /// Weight of hitting a light. `emission`: e; `sampled`: p_N; both with the probability of the light; `pdf`: p_1,
    /// infinite after a mirror.
    pub(super) fn weight_of_hit(&self, emission: f64, sampled: f64, pdf: f64) -> f64 {
        weight(self.sent * emission, sampled / pdf)
    }

    /// Weight of sampling a light from this vertex; `emission` and `sampled` as before.
    pub(super) fn weight_of_sampled(
        &self,
        turn: &ScatteringDensities,
        emission: f64,
        sampled: f64,
        is_delta: bool,
    ) -> f64 {
        let hit = if is_delta { 0.0 } else { turn.light_pdf };
        weight(self.sent * self.factor(turn) * emission / sampled, hit / sampled)
    }
}

/// Partial MIS sums of a light path at a vertex z_j: hit / sent and sampled / sent without the factors of z_j and those
/// after.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPathWeights {
    hit: f64,
    sampled: f64,
    /// Whether this is the vertex z_1, whose light sampling is not yet in `sampled`.
    is_first: bool,
}

impl LightPathWeights {
    /// The sums at z_1. `light_paths`: N; `emission`: e, with the probability of the light.
    pub(super) fn new(light_paths: f64, emission: f64, is_delta: bool) -> Self {
        let sent = 1.0 / (light_paths * emission);
        Self { hit: if is_delta { 0.0 } else { sent }, sampled: sent, is_first: true }
    }

    /// Both ratios with the factor of the vertex, without the density of continuing to the camera. `sampled`: p_N, with the probability of the
    /// light, called at z_1 only.
    fn ratios(&self, turn: &ScatteringDensities, sampled: impl FnOnce() -> f64) -> [f64; 2] {
        let cosines = turn.camera_cos / turn.light_cos;
        let picked = if self.is_first { sampled() } else { turn.light_pdf };
        [self.hit * cosines * turn.light_pdf, self.sampled * cosines * picked]
    }

    /// At the next vertex, where light is scattered at this one.
    pub(super) fn scattered(&self, turn: &ScatteringDensities, sampled: impl FnOnce() -> f64) -> Self {
        let [hit, sampled] = self.ratios(turn, sampled).map(|ratio| ratio / turn.camera_pdf);
        Self { hit, sampled, is_first: false }
    }

    /// At the next vertex, where this one is mirror or glass.
    pub(super) fn mirrored(&self) -> Self {
        Self { sampled: if self.is_first { 0.0 } else { self.sampled }, is_first: false, ..*self }
    }

    /// Weight of connecting this vertex to the camera. `density`: c.
    pub(super) fn weight_of_sent(
        &self,
        turn: &ScatteringDensities,
        density: f64,
        sampled: impl FnOnce() -> f64,
    ) -> f64 {
        let [hit, sampled] = self.ratios(turn, sampled);
        weight(hit * density, sampled * density)
    }
}

/// `1 / (1 + a^2 + b^2)`; 0 for NaN.
fn weight(a: f64, b: f64) -> f64 {
    let weight = 1.0 / (1.0 + a * a + b * b);
    if weight.is_nan() { 0.0 } else { weight }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Event at a vertex.
    #[derive(Clone, Copy, Debug)]
    enum Event {
        ScatteredRay(ScatteringDensities),
        Mirrored,
    }

    #[derive(Clone, Copy, Debug)]
    struct PathEnds {
        light_paths: f64,
        density: f64,
        emission: f64,
        sampled: f64,
        is_delta: bool,
    }

    /// Weights of hit, sampled and sent of the path through `events`, z_1 first; 0 for techniques that cannot find it.
    fn weights(events: &[Event], ends: &PathEnds) -> [f64; 3] {
        let PathEnds { light_paths, density, emission, sampled, is_delta } = *ends;
        let [mut hit, mut picked, mut sent] = [0.0; 3];
        let mut camera = CameraPathWeights::new(light_paths, density);
        let mut pdf = 0.0;
        for (j, event) in events.iter().enumerate().rev() {
            match event {
                Event::ScatteredRay(turn) => {
                    if j == 0 {
                        picked = camera.weight_of_sampled(turn, emission, sampled, is_delta);
                    }
                    (camera, pdf) = (camera.scattered(turn), turn.light_pdf);
                }
                Event::Mirrored => (camera, pdf) = (camera.mirrored(true), f64::INFINITY),
            }
        }
        if !is_delta {
            hit = camera.weight_of_hit(emission, sampled, pdf);
        }
        let mut light = LightPathWeights::new(light_paths, emission, is_delta);
        for (j, event) in events.iter().enumerate() {
            match event {
                Event::ScatteredRay(turn) if j + 1 == events.len() => {
                    sent = light.weight_of_sent(turn, density, || sampled);
                }
                Event::ScatteredRay(turn) => light = light.scattered(turn, || sampled),
                Event::Mirrored => light = light.mirrored(),
            }
        }
        [hit, picked, sent]
    }

    fn event() -> impl Strategy<Value = Event> {
        let pdf = 1e-3..1e3;
        let turn = (0.01..1.0, 0.01..1.0, pdf.clone(), pdf).prop_map(|(light_cos, camera_cos, l, c)| {
            Event::ScatteredRay(ScatteringDensities { light_cos, camera_cos, light_pdf: l, camera_pdf: c })
        });
        prop_oneof![2 => turn, 1 => Just(Event::Mirrored)]
    }

    proptest! {
        #[test]
        fn weights_of_all_techniques_add_up_to_one(
            events in prop::collection::vec(event(), 1..6),
            (light_paths, density, emission, sampled) in (1.0..1e6, 1e-3..1e6, 1e-3..1e3, 1e-3..1e3),
            is_delta: bool,
        ) {
            let ends = PathEnds { light_paths, density, emission, sampled, is_delta };
            let sum: f64 = weights(&events, &ends).into_iter().sum();
            let is_mirror = |event: Option<&Event>| matches!(event, Some(Event::Mirrored));
            let lost = is_delta && is_mirror(events.first()) && is_mirror(events.last());
            // A delta light behind a mirror, seen in a mirror, is not found by any technique.
            prop_assert!((sum - if lost { 0.0 } else { 1.0 }).abs() < 1e-12, "{:?}", weights(&events, &ends));
        }
    }

    #[test]
    fn weights_agree_with_the_densities() {
        // k = 3, all squared distances 1.
        let turn = |light_cos, camera_cos, light_pdf, camera_pdf| ScatteringDensities {
            light_cos,
            camera_cos,
            light_pdf,
            camera_pdf,
        };
        let (z1, z2) = (turn(0.5, 0.25, 3.0, 2.0), turn(0.8, 0.4, 5.0, 7.0));
        let ends = PathEnds { light_paths: 10.0, density: 4.0, emission: 0.3, sampled: 1.5, is_delta: false };
        let cos_0 = 0.9;
        // From the camera: z_2 by density times cosine, z_1 by p_2 b_1, z_0 by p_1 or p_N times its cosine.
        let common = 4.0 * 0.4 * (5.0 * 0.25);
        let (hit, sampled) = (common * 3.0 * cos_0, common * 1.5 * cos_0);
        // From the light: z_0 and direction by e times the cosine there, z_1 by its cosine to the light, z_2 by q_1 a_2; ten paths.
        let sent = 10.0 * (0.3 * cos_0) * 0.5 * (2.0 * 0.8);
        let squares = [hit, sampled, sent].map(|p: f64| p * p);
        let sum: f64 = squares.iter().sum();
        let found = weights(&[Event::ScatteredRay(z1), Event::ScatteredRay(z2)], &ends);
        for (found, square) in found.into_iter().zip(squares) {
            assert!((found - square / sum).abs() < 1e-12, "{found} {}", square / sum);
        }
    }

    #[test]
    fn without_paths_from_lights_the_weights_are_those_of_light_sampling() {
        let turn = ScatteringDensities { light_cos: 0.5, camera_cos: 0.5, light_pdf: 2.0, camera_pdf: 1.0 };
        let camera = CameraPathWeights::new(0.0, 0.0);
        assert_eq!(camera.weight_of_sampled(&turn, 3.0, 1.0, false), 0.2);
        assert_eq!(camera.scattered(&turn).weight_of_hit(3.0, 1.0, 2.0), 0.8);
    }
}
