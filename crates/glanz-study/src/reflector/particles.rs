//! Particles from the lamp towards the mirror, and on to the walls.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec3, Frame, Ray};
use glanz_sampling::{PixelSampler, SamplerKind, warp};
use glanz_scene::Scene;

use super::room::{LAMP, REFLECTANCE, WALLS, wall_hit};

/// Number of cells along a side of a wall.
pub(super) const CELLS: u32 = 32;

/// Number of cells of all walls.
pub(super) const ALL_CELLS: usize = WALLS.len() * (CELLS * CELLS) as usize;

/// Largest number of reflections of a particle.
const REFLECTIONS: u32 = 100;

/// End of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParticleEnd {
    /// It missed the mirror.
    Missed,
    /// In a cell, by its number over all walls, and the number of reflections.
    Cell(u16, u8),
    /// In the mirror: a shading normal reflected it into its own facet, or it was reflected too often.
    Lost,
}

/// The lamp of the scene, restricted to a cone that contains the mirror; all particles carry the same light.
///
/// The lamp is a sphere of equal brightness in all directions: along a direction it appears as a uniform disk.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConeSource {
    frame: Frame,
    one_minus_cos: f64,
    seed: u64,
}

impl ConeSource {
    /// The cone around a ball (middle and radius, metres) that does not contain the lamp.
    pub(super) fn at(ball: (DVec3, f64), seed: u64) -> Self {
        let (lamp, radius, _) = LAMP;
        let way = ball.0 - lamp;
        // A line from the lamp to the ball deviates from the line between the middles by at most both radii.
        let sine = (ball.1 + radius) / way.length();
        Self { frame: Frame::from_z(way.normalize()), one_minus_cos: warp::one_minus_cos(sine * sine), seed }
    }

    /// Flux of all particles together, lm.
    pub(super) fn flux(&self) -> f64 {
        LAMP.2 * TAU * self.one_minus_cos / (4.0 * PI)
    }

    /// The initial ray of particle `number`.
    pub(super) fn particle(&self, number: u32) -> Ray {
        let mut sampler = PixelSampler::new(SamplerKind::Sobol, 1, self.seed, [0, 0], number);
        let (towards, place) = (sampler.next_2d(), sampler.next_2d());
        let direction = self.frame.to_world(warp::uniform_cone(towards, self.one_minus_cos));
        let on_lamp = Frame::from_z(direction).to_world(warp::cosine_hemisphere(place));
        Ray::new(LAMP.0 + LAMP.1 * on_lamp, direction)
    }
}

/// Follows a particle in a scene of the mirror alone, within the walls. Its flux does not depend on the shading normal.
pub(super) fn follow(scene: &Scene, particle: &Ray) -> ParticleEnd {
    let mut ray = *particle;
    let mut reflections = 0;
    while let Some(at) = scene.intersect(&ray, f64::INFINITY) {
        let (d, n) = (ray.direction, at.point.shading_normal);
        let mirrored = d - 2.0 * n.dot(d) * n;
        reflections += 1;
        if at.point.normal.dot(d) * at.point.normal.dot(mirrored) >= 0.0 || reflections > REFLECTIONS {
            return ParticleEnd::Lost;
        }
        ray = at.spawn(mirrored);
    }
    if reflections == 0 {
        return ParticleEnd::Missed;
    }
    match wall_hit(&ray) {
        Some(end) => {
            let cell = end.wall * (CELLS * CELLS) as usize + end.cell(CELLS);
            ParticleEnd::Cell(cell as u16, reflections as u8)
        }
        None => ParticleEnd::Lost,
    }
}

impl ParticleEnd {
    /// The cell, and the share of its flux that the particle carries there.
    pub(super) fn arriving(self) -> Option<(usize, f64)> {
        match self {
            Self::Cell(cell, reflections) => {
                Some((usize::from(cell), REFLECTANCE.powi(i32::from(reflections))))
            }
            Self::Missed | Self::Lost => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_leave_the_lamp_outwards_within_the_cone() {
        let ball = (DVec3::new(4.0, 4.0, 6.0), 2.0);
        let aim = ConeSource::at(ball, 1);
        let (lamp, radius, lumens) = LAMP;
        let axis = (ball.0 - lamp).normalize();
        let sine: f64 = (2.0 + radius) / ball.0.distance(lamp);
        for number in 0..1000 {
            let ray = aim.particle(number);
            assert!((ray.origin.distance(lamp) - radius).abs() < 1e-12);
            assert!((ray.origin - lamp).dot(ray.direction) >= 0.0);
            assert!(ray.direction.dot(axis) >= sine.asin().cos() - 1e-12);
        }
        // A lamp that sends as much in all directions: the share of the cone in the sphere.
        assert!((aim.flux() - lumens * 0.5 * (1.0 - sine.asin().cos())).abs() < 1e-9 * lumens);
    }
}
