//! Random numbers and the families of rays.

use std::f64::consts::TAU;

use glanz_math::{DVec2, DVec3, Ray};

use super::case::ContractCase;

/// PCG-XSH-RR 64/32 (O'Neill 2014), so that the rays never depend on another crate.
pub struct Pcg {
    state: u64,
}

impl Pcg {
    /// A generator for the stream `seed`.
    pub fn new(seed: u64) -> Self {
        let mut pcg = Self { state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) };
        pcg.next();
        pcg
    }

    fn next(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn unit(&mut self) -> f64 {
        let high = u64::from(self.next() >> 5);
        let low = u64::from(self.next() >> 6);
        (high * (1 << 26) + low) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in [min, max).
    pub fn between(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.unit()
    }

    /// Uniform below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Two uniform numbers.
    pub fn pair(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit())
    }

    /// Uniform over the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        DVec3::new(r * cos, r * sin, z)
    }

    /// Uniform in the unit ball.
    pub fn in_ball(&mut self) -> DVec3 {
        self.direction() * self.unit().cbrt()
    }
}

/// Families of rays.
#[derive(Clone, Copy, Debug)]
pub enum ContractRays {
    /// From a few sizes away to a point in the ball.
    Towards,
    /// From inside the ball.
    Inside,
    /// From 1e5 sizes away.
    Far,
    /// Parallel to a coordinate axis, or to a coordinate plane.
    AxisParallel,
    /// Through edges, vertices, apices and seams, or along rulings.
    Adversarial,
}

impl ContractRays {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Towards, Self::Inside, Self::Far, Self::AxisParallel, Self::Adversarial];

    /// A ray whose direction has a length from 1e-3 to 1e3.
    pub fn ray(self, case: &ContractCase, pcg: &mut Pcg) -> Ray {
        let within = |pcg: &mut Pcg| case.center + pcg.in_ball() * case.size;
        let outside = |pcg: &mut Pcg, sizes: f64| case.center + pcg.direction() * (sizes * case.size);
        let (origin, direction) = match self {
            Self::Towards => {
                let origin = outside(pcg, 3.0);
                (origin, within(pcg) - origin)
            }
            Self::Inside => (within(pcg), pcg.direction()),
            Self::Far => {
                let origin = outside(pcg, 1e5);
                (origin, within(pcg) - origin)
            }
            Self::AxisParallel => axis_parallel(case, pcg),
            Self::Adversarial => adversarial(case, pcg),
        };
        let length = 10_f64.powf(pcg.between(-3.0, 3.0));
        Ray::new(origin, direction * (length / direction.length()))
    }
}

fn axis_parallel(case: &ContractCase, pcg: &mut Pcg) -> (DVec3, DVec3) {
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][pcg.below(3)] * if pcg.unit() < 0.5 { 1.0 } else { -1.0 };
    let mut target = case.center + pcg.in_ball() * case.size;
    if pcg.unit() < 0.25 {
        // Straight through the middle: zeros in the coefficients.
        target = case.center;
    }
    let mut direction = axis;
    if pcg.unit() < 0.25 {
        // One coordinate of the direction is zero, the others are not.
        direction = pcg.direction();
        direction[pcg.below(3)] = 0.0;
    }
    (target - direction * (case.size * pcg.between(0.0, 4.0)), direction)
}

fn adversarial(case: &ContractCase, pcg: &mut Pcg) -> (DVec3, DVec3) {
    let target = if case.targets.is_empty() || pcg.unit() < 0.1 {
        case.center
    } else {
        let [a, b] = case.targets[pcg.below(case.targets.len())];
        match pcg.below(4) {
            0 => a,
            1 => b,
            _ => a.lerp(b, pcg.unit()),
        }
    };
    let direction = if !case.directions.is_empty() && pcg.unit() < 0.4 {
        case.directions[pcg.below(case.directions.len())].normalize()
    } else {
        pcg.direction()
    };
    // Some pass the target at a distance between rounding and visible.
    let miss = if pcg.unit() < 0.5 { 0.0 } else { case.size * 10_f64.powf(pcg.between(-16.0, -2.0)) };
    let back = case.size * if pcg.unit() < 0.2 { 0.0 } else { 10_f64.powf(pcg.between(-6.0, 5.0)) };
    (target + pcg.direction() * miss - direction * back, direction)
}
