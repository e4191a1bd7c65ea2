//! Random numbers, and the rays: chords and adversarial rays.

use std::f64::consts::TAU;

use glanz_geometry::RaySurface;
use glanz_math::rounding::offset_origin;
use glanz_math::{DVec3, Ray};

use super::test_surface::TestSurface;

/// SplitMix64 (@steele2014): a stream per seed, so that any ray can be traced again alone.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// 10 to a power that is uniform between these.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(self.between(low, high))
    }

    /// Uniform over the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Families of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayFamily {
    /// Through two random points of the ball around the surface, from outside or from the first.
    Chord,
    /// In a tangent plane, through its point or beside it.
    Tangent,
    /// Along the tangent of an isoline.
    Isoline,
    /// Through a corner of a patch.
    Corner,
    /// Through a point of a border, or of a line at a dyadic parameter, where leaves meet.
    Border,
    /// Along the tangent of a border.
    BorderTangent,
    /// From a point of the surface itself.
    FromSurface,
    /// From a hit, moved out of its error box as a renderer does.
    Spawned,
    /// Exactly through two control points.
    ControlPoints,
    /// Parallel to an axis or to a coordinate plane, through a point of the surface or the middle.
    AxisParallel,
    /// Through two points of one patch: in its plane, if it has one.
    TwoPoints,
}

impl RayFamily {
    pub const ADVERSARIAL: [Self; 10] = [
        Self::Tangent,
        Self::Isoline,
        Self::Corner,
        Self::Border,
        Self::BorderTangent,
        Self::FromSurface,
        Self::Spawned,
        Self::ControlPoints,
        Self::AxisParallel,
        Self::TwoPoints,
    ];

    pub fn ray(self, tested: &TestSurface, random: &mut Random) -> Ray {
        let size = tested.size;
        let ball = |random: &mut Random| tested.center + random.direction() * (size * random.unit().cbrt());
        let patch = &tested.patches[random.below(tested.patches.len())];
        let (u, v) = (random.unit(), random.unit());
        let end = |random: &mut Random| if random.unit() < 0.5 { 0.0 } else { 1.0 };
        let (target, direction) = match self {
            Self::Chord => {
                let (a, b) = (ball(random), ball(random));
                if random.unit() < 0.3 {
                    return scaled(a, b - a, random);
                }
                (b, a - b)
            }
            Self::Tangent => {
                let [s, su, sv] = patch.tangent(u, v);
                let (sin, cos) = random.between(0.0, TAU).sin_cos();
                let (a, b) = (su.normalize_or_zero(), sv.normalize_or_zero());
                let beside = if random.unit() < 0.5 { 0.0 } else { size * random.magnitude(-16.0, -2.0) };
                (s + a.cross(b).normalize_or_zero() * beside, a * cos + b * sin)
            }
            Self::Isoline => {
                let [s, su, sv] = patch.tangent(u, v);
                (s, if random.unit() < 0.5 { su } else { sv })
            }
            Self::Corner => {
                let (i, j) = (end(random), end(random));
                (patch.tangent(i, j)[0], random.direction())
            }
            Self::Border => {
                let steps = [1.0, 1.0, 2.0, 8.0, 64.0][random.below(5)];
                let x = random.below(steps as usize + 1) as f64 / steps;
                let [s, ..] = if random.unit() < 0.5 { patch.tangent(x, v) } else { patch.tangent(u, x) };
                let beside = if random.unit() < 0.5 { 0.0 } else { size * random.magnitude(-16.0, -6.0) };
                (s + random.direction() * beside, random.direction())
            }
            Self::BorderTangent => {
                if random.unit() < 0.5 {
                    let [s, su, _] = patch.tangent(u, end(random));
                    (s, su)
                } else {
                    let [s, _, sv] = patch.tangent(end(random), v);
                    (s, sv)
                }
            }
            Self::FromSurface => return scaled(patch.tangent(u, v)[0], random.direction(), random),
            Self::Spawned => {
                let (target, from) = (ball(random), random.direction());
                return spawned(tested, random, target, from);
            }
            Self::ControlPoints => {
                let point = |random: &mut Random| {
                    let p = patch.points[random.below(patch.points.len())];
                    p.truncate() / p.w
                };
                let (a, b) = (point(random), point(random));
                (a, b - a)
            }
            Self::AxisParallel => {
                let mut direction = DVec3::AXES[random.below(3)];
                if random.unit() < 0.3 {
                    direction = random.direction();
                    direction[random.below(3)] = 0.0;
                }
                let target = match random.below(4) {
                    0 => tested.center,
                    1 => patch.tangent(end(random), end(random))[0],
                    _ => patch.tangent(u, v)[0],
                };
                (target, direction)
            }
            Self::TwoPoints => {
                let [a, ..] = patch.tangent(u, v);
                let [b, ..] = patch.tangent(random.unit(), random.unit());
                (a, b - a)
            }
        };
        let direction = direction.try_normalize().unwrap_or_else(|| random.direction());
        scaled(target - direction * (size * random.between(2.0, 4.0)), direction, random)
    }
}

/// A ray with a direction of random length.
fn scaled(origin: DVec3, direction: DVec3, random: &mut Random) -> Ray {
    let direction = direction.try_normalize().unwrap_or(DVec3::Z);
    Ray::new(origin, direction * random.magnitude(-3.0, 3.0))
}

fn spawned(tested: &TestSurface, random: &mut Random, target: DVec3, from: DVec3) -> Ray {
    let first = Ray::new(target + from * (3.0 * tested.size), -from);
    let direction = random.direction();
    match tested.surface.intersect(&first, f64::INFINITY) {
        Some(hit) => {
            let point = tested.surface.point(&first, &hit);
            scaled(offset_origin(point.position, point.error, point.normal, direction), direction, random)
        }
        None => scaled(target, direction, random),
    }
}
