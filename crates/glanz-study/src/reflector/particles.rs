//! Particles from the lamp towards the mirror, and the walls that they reach by way of it.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec3, Frame, Ray};
use glanz_sampling::{PixelSampler, SamplerKind, warp};
use glanz_scene::Scene;

use super::room::{LAMP, REFLECTANCE, WALLS, wall_hit};

/// Cells along a side of a wall.
pub(super) const CELLS: u32 = 32;

/// All cells.
pub(super) const ALL_CELLS: usize = WALLS.len() * (CELLS * CELLS) as usize;

/// Reflections of a particle that are followed at most.
const REFLECTIONS: u32 = 100;

/// Where a particle ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParticleEnd {
    /// It passed by the mirror.
    Missed,
    /// In a cell, numbered through all walls, after so many reflections.
    Cell(u16, u8),
    /// In the mirror: a normal for shading sent it into its own facet, or it was reflected too often.
    Lost,
}

/// Directions that may meet the mirror, from the lamp of the scene; all particles carry the same light.
///
/// The lamp is a sphere that is equally bright from everywhere: seen along a direction it is an even disk.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConeSource {
    frame: Frame,
    one_minus_cos: f64,
    seed: u64,
}

impl ConeSource {
    /// At a ball around the mirror: middle and radius, metres; it does not hold the lamp.
    pub(super) fn at(ball: (DVec3, f64), seed: u64) -> Self {
        let (lamp, radius, _) = LAMP;
        let way = ball.0 - lamp;
        // From any place of the lamp to any of the ball: no further off the line between the middles than both radii.
        let sine = (ball.1 + radius) / way.length();
        Self { frame: Frame::from_z(way.normalize()), one_minus_cos: warp::one_minus_cos(sine * sine), seed }
    }

    /// Light of all such particles together, lm.
    pub(super) fn flux(&self) -> f64 {
        LAMP.2 * TAU * self.one_minus_cos / (4.0 * PI)
    }

    /// Particle `number` leaves the lamp.
    pub(super) fn particle(&self, number: u32) -> Ray {
        let mut sampler = PixelSampler::new(SamplerKind::Sobol, 1, self.seed, [0, 0], number);
        let (towards, place) = (sampler.next_2d(), sampler.next_2d());
        let direction = self.frame.to_world(warp::uniform_cone(towards, self.one_minus_cos));
        let on_lamp = Frame::from_z(direction).to_world(warp::cosine_hemisphere(place));
        Ray::new(LAMP.0 + LAMP.1 * on_lamp, direction)
    }
}

/// Follows a particle in a scene of the mirror alone, within the walls. It keeps its light whichever normal tells where it goes.
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
    /// The cell, and the share of its light that a particle brings there.
    pub(super) fn brought(self) -> Option<(usize, f64)> {
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
