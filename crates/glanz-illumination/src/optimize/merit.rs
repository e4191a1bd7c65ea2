//! Merits of reflected light: functions of sums over rays, with the derivatives by each ray. They are smooth but where a ray becomes parallel to the plane of a receiver: there
//! its penalty jumps.

use glanz_math::{DVec2, DVec3};

use super::landing_grid::LandingGrid;
use super::reflection::ReflectionGradient;

/// Penalty of a ray that does not arrive on the plane of a receiver, on average over directions: above that of a ray that arrives within 1000 half sides of its middle.
const MISS_PENALTY: f64 = 100.0;
/// Largest penalty per flux, which a merit without any flux has.
const LARGEST_PENALTY: f64 = MISS_PENALTY + 1.0;
/// Square of the chord between opposite directions of unit length.
const OPPOSITE_CHORD: f64 = 4.0;
/// Distance from the border of a receiver, in compressed coordinates, at which a ray has half of the reward of one on it.
const REWARD_WIDTH: f64 = 0.1;

/// A flat rectangular receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReceiverFrame {
    pub(super) center: DVec3,
    /// Half of the sides.
    pub(super) half_sides: [DVec3; 2],
    /// Unit normal on the counted side.
    pub(super) normal: DVec3,
}

/// A reflected ray with its flux.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectedRay {
    pub(super) origin: DVec3,
    /// Not of unit length.
    pub(super) direction: DVec3,
    /// lm.
    pub(super) flux: f64,
    /// Number of the mirror's shape.
    pub(super) mirror: usize,
}

/// A target as a function of sums over rays.
#[derive(Clone, Debug)]
pub(super) enum Merit {
    /// Squared differences of the distribution on a receiver from the wanted one.
    Distribution { receiver: ReceiverFrame, grid: LandingGrid },
    /// Reward of the rays on a receiver and near it, and squared distances from its border of those beside it.
    Flux { receiver: ReceiverFrame, emitted: f64 },
    /// Squared angles to a direction of the light from one mirror.
    Collimation { mirror: usize, direction: DVec3 },
}

/// What a design reaches of a target.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(tag = "target", rename_all = "snake_case")]
pub enum TargetMeasure {
    /// Distribution of light on a receiver.
    Distribution {
        /// Root mean square of the differences from the wanted distribution, relative to it, at the resolution of the cells.
        deviation: f64,
        /// Share of the reflected light that arrives on the receiver.
        share: f64,
    },
    /// Light on a receiver.
    Flux {
        /// Share of the light of the lamps that arrives on the receiver after one reflection.
        share: f64,
    },
    /// Parallel light.
    Collimation {
        /// Root mean square angle to the wanted direction, radians.
        angle: f64,
    },
}

/// A merit with the derivatives by its sums.
#[derive(Clone, Debug)]
pub(super) struct MeritValue {
    pub(super) value: f64,
    pub(super) slopes: Vec<f64>,
    pub(super) measure: TargetMeasure,
}

/// Numbers of sums before those of the grid: flux (for [`Merit::Flux`] rewards), penalties, flux on the receiver.
const SUMS: usize = 3;

impl ReceiverFrame {
    /// Coordinates on the receiver's plane, [-1, 1] on the receiver, with the ray parameter; `None` for a ray that does not arrive there on the counted side.
    fn landing(&self, ray: &ReflectedRay) -> Option<(DVec2, f64)> {
        let towards = ray.direction.dot(self.normal);
        let t = (self.center - ray.origin).dot(self.normal) / towards;
        let offset = ray.origin + t * ray.direction - self.center;
        (towards < 0.0 && t > 0.0).then(|| (self.coordinates(offset), t))
    }

    fn coordinates(&self, offset: DVec3) -> DVec2 {
        let [across, up] = self.half_sides;
        DVec2::new(offset.dot(across) / across.length_squared(), offset.dot(up) / up.length_squared())
    }

    /// The ray parameter at which a ray arrives on the receiver itself.
    pub(super) fn arrival(&self, ray: &ReflectedRay) -> Option<f64> {
        self.landing(ray).filter(|(at, _)| at.abs().max_element() <= 1.0).map(|(_, t)| t)
    }

    /// Adds the derivatives of a number by the coordinates of the landing.
    fn add_gradient(&self, by: DVec2, ray: &ReflectedRay, t: f64, gradient: &mut ReflectionGradient) {
        let [across, up] = self.half_sides;
        let by_point = by.x / across.length_squared() * across + by.y / up.length_squared() * up;
        // point = origin + t direction, t = (center - origin).n / direction.n
        let by_t = by_point.dot(ray.direction) / ray.direction.dot(self.normal);
        let along_plane = by_point - by_t * self.normal;
        gradient.origin += along_plane;
        gradient.direction += t * along_plane;
    }
}

/// Coordinates that are linear on the receiver and logarithmic beyond, so that far light has a finite place.
pub(super) fn compressed(x: f64) -> (f64, f64) {
    if x.abs() <= 1.0 { (x, 1.0) } else { ((1.0 + x.abs().ln()).copysign(x), 1.0 / x.abs()) }
}

/// The square of what `x` exceeds `limit` by in size, with its derivative.
fn excess(x: f64, limit: f64) -> (f64, f64) {
    let beyond = (x.abs() - limit).max(0.0);
    (beyond * beyond, 2.0 * beyond.copysign(x))
}

/// The penalty of a ray that goes away from a receiver, and its derivative by the direction.
fn miss_penalty(direction: DVec3, normal: DVec3) -> (f64, DVec3) {
    let unit = direction.normalize_or_zero();
    let cosine = unit.dot(normal);
    (MISS_PENALTY + cosine, (normal - cosine * unit) / direction.length())
}

/// The reward of a ray with a squared distance from a receiver, and its derivative by that.
fn reward(squared: f64) -> (f64, f64) {
    let width = REWARD_WIDTH * REWARD_WIDTH;
    let reward = width / (width + squared);
    (reward, -reward * reward / width)
}

impl Merit {
    /// Number of sums.
    pub(super) fn sums(&self) -> usize {
        match self {
            Self::Distribution { grid, .. } => SUMS + grid.len(),
            Self::Flux { .. } | Self::Collimation { .. } => SUMS,
        }
    }

    /// The receiver, if the target is on one.
    pub(super) fn receiver(&self) -> Option<&ReceiverFrame> {
        match self {
            Self::Distribution { receiver, .. } | Self::Flux { receiver, .. } => Some(receiver),
            Self::Collimation { .. } => None,
        }
    }

    /// The grid of a distribution.
    pub(super) fn grid_mut(&mut self) -> Option<&mut LandingGrid> {
        match self {
            Self::Distribution { grid, .. } => Some(grid),
            Self::Flux { .. } | Self::Collimation { .. } => None,
        }
    }

    /// Adds a ray that something blocks: light that is missing on the receiver.
    pub(super) fn deposit_blocked(&self, flux: f64, sums: &mut [f64]) {
        if let (Self::Distribution { .. }, Some(total)) = (self, sums.first_mut()) {
            *total += flux;
        }
    }

    /// The derivative of the merit by the flux of a blocked ray.
    pub(super) fn blocked_slope(&self, slopes: &[f64]) -> f64 {
        match self {
            Self::Distribution { .. } => slopes.first().copied().unwrap_or_default(),
            Self::Flux { .. } | Self::Collimation { .. } => 0.0,
        }
    }

    /// Adds a ray.
    pub(super) fn deposit(&self, ray: &ReflectedRay, sums: &mut [f64]) {
        let Some((first, cells)) = sums.split_first_chunk_mut::<SUMS>() else { return };
        match self {
            Self::Collimation { mirror, direction } => {
                if ray.mirror == *mirror {
                    let unit = ray.direction.normalize_or_zero();
                    first[0] += ray.flux;
                    first[1] += ray.flux * (unit - *direction).length_squared();
                }
            }
            Self::Distribution { receiver, .. } | Self::Flux { receiver, .. } => {
                let is_distribution = matches!(self, Self::Distribution { .. });
                if is_distribution {
                    first[0] += ray.flux;
                }
                let Some((at, _)) = receiver.landing(ray) else {
                    first[1] += ray.flux * miss_penalty(ray.direction, receiver.normal).0;
                    return;
                };
                if at.abs().max_element() <= 1.0 {
                    first[2] += ray.flux;
                }
                let [x, y] = at.to_array().map(|x| compressed(x).0);
                let limit = self.limit();
                let squared = excess(x, limit).0 + excess(y, limit).0;
                first[1] += ray.flux * squared;
                if !is_distribution {
                    first[0] += ray.flux * reward(squared).0;
                }
                if let Self::Distribution { grid, .. } = self {
                    grid.cells_near(DVec2::new(x, y), |index, weight, _| {
                        if let Some(cell) = cells.get_mut(index) {
                            *cell += ray.flux * weight;
                        }
                    });
                }
            }
        }
    }

    /// Coordinate up to which there is no penalty.
    fn limit(&self) -> f64 {
        if matches!(self, Self::Distribution { .. }) { LandingGrid::HALF } else { 1.0 }
    }

    /// The merit, 0 for the ideal, by the sums over all rays.
    pub(super) fn value(&self, sums: &[f64]) -> MeritValue {
        let mut slopes = vec![0.0; sums.len()];
        let (Some((&[flux, penalty, inside], cells)), Some(([by_flux, by_penalty, _], by_cells))) =
            (sums.split_first_chunk::<SUMS>(), slopes.split_first_chunk_mut::<SUMS>())
        else {
            return MeritValue { value: 0.0, slopes, measure: TargetMeasure::Flux { share: 0.0 } };
        };
        let (value, measure) = match self {
            // Without flux there is no mean: the worst value, without slopes.
            Self::Collimation { .. } if flux.is_nan() || flux <= 0.0 => {
                (OPPOSITE_CHORD, TargetMeasure::Collimation { angle: std::f64::consts::PI })
            }
            Self::Distribution { .. } if flux.is_nan() || flux <= 0.0 => {
                (LARGEST_PENALTY, TargetMeasure::Distribution { deviation: 1.0, share: 0.0 })
            }
            Self::Collimation { .. } => {
                (*by_flux, *by_penalty) = (-penalty / (flux * flux), 1.0 / flux);
                // Chord and angle differ by a 24th of its cube.
                let chord = (penalty / flux).sqrt();
                (penalty / flux, TargetMeasure::Collimation { angle: 2.0 * (0.5 * chord).min(1.0).asin() })
            }
            Self::Flux { emitted, .. } => {
                // A light near a point of a mirror has more flux by few rays than it emits: the square has no reward for that.
                let missing = 1.0 - flux / emitted;
                (*by_flux, *by_penalty) = (-2.0 * missing / emitted, 1.0 / emitted);
                (missing * missing + penalty / emitted, TargetMeasure::Flux { share: inside / emitted })
            }
            Self::Distribution { grid, .. } => {
                let (difference, finest) = grid.difference(cells, flux, by_cells, by_flux);
                *by_flux -= penalty / (flux * flux);
                *by_penalty = 1.0 / flux;
                let measure = TargetMeasure::Distribution { deviation: finest.sqrt(), share: inside / flux };
                (difference + penalty / flux, measure)
            }
        };
        MeritValue { value, slopes, measure }
    }

    /// The derivatives of the merit by a ray, by those by the sums. The flux of the ray has the factor `scale` on that of its reflection.
    pub(super) fn ray_gradient(&self, ray: &ReflectedRay, scale: f64, slopes: &[f64]) -> ReflectionGradient {
        let mut gradient = ReflectionGradient::default();
        let Some((&[by_flux, by_penalty, _], by_cells)) = slopes.split_first_chunk::<SUMS>() else {
            return gradient;
        };
        match self {
            Self::Collimation { mirror, direction } => {
                if ray.mirror == *mirror {
                    let length = ray.direction.length();
                    let unit = ray.direction / length;
                    gradient.flux = scale * (by_flux + by_penalty * (unit - *direction).length_squared());
                    let across = *direction - unit.dot(*direction) * unit;
                    gradient.direction = -2.0 * by_penalty * ray.flux / length * across;
                }
            }
            Self::Distribution { receiver, .. } | Self::Flux { receiver, .. } => {
                let Some((at, t)) = receiver.landing(ray) else {
                    let (penalty, by_direction) = miss_penalty(ray.direction, receiver.normal);
                    let by_total = if matches!(self, Self::Distribution { .. }) { by_flux } else { 0.0 };
                    gradient.flux = scale * (by_total + by_penalty * penalty);
                    gradient.direction = by_penalty * ray.flux * by_direction;
                    return gradient;
                };
                let [(x, dx), (y, dy)] = at.to_array().map(compressed);
                let limit = self.limit();
                let [(ex, dex), (ey, dey)] = [x, y].map(|x| excess(x, limit));
                let (reward, by_squared) = match self {
                    Self::Flux { .. } => reward(ex + ey),
                    Self::Distribution { .. } | Self::Collimation { .. } => (1.0, 0.0),
                };
                let mut by_share = by_flux * reward + by_penalty * (ex + ey);
                let mut by_place = (by_penalty + by_flux * by_squared) * DVec2::new(dex, dey);
                if let Self::Distribution { grid, .. } = self {
                    grid.cells_near(DVec2::new(x, y), |index, weight, derivative| {
                        let slope = by_cells.get(index).copied().unwrap_or_default();
                        by_share += slope * weight;
                        by_place += slope * derivative;
                    });
                }
                gradient.flux = scale * by_share;
                let by_landing = ray.flux * by_place * DVec2::new(dx, dy);
                receiver.add_gradient(by_landing, ray, t, &mut gradient);
            }
        }
        gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::landing_grid::WantedLight;

    fn receiver() -> ReceiverFrame {
        let half_sides = [DVec3::X * 0.5, DVec3::Y * 0.25];
        ReceiverFrame { center: DVec3::new(0.0, 0.0, 2.0), half_sides, normal: DVec3::NEG_Z }
    }

    fn merits() -> [Merit; 4] {
        let grid = |wanted: WantedLight<'_>| LandingGrid::new([8, 6], &wanted);
        [
            Merit::Distribution { receiver: receiver(), grid: grid(WantedLight::Even { margin: 0.1 }) },
            Merit::Distribution { receiver: receiver(), grid: grid(WantedLight::Peak) },
            Merit::Flux { receiver: receiver(), emitted: 9.0 },
            Merit::Collimation { mirror: 3, direction: DVec3::Z },
        ]
    }

    /// Rays that arrive on the receiver, beside it, far from it and never.
    fn rays() -> Vec<ReflectedRay> {
        let directions = [[0.1, 0.05], [-0.2, 0.11], [0.4, -0.02], [3.0, -9.0], [200.0, 150.0]];
        let to = |[x, y]: [f64; 2], z: f64| DVec3::new(x, y, z);
        let up = directions.map(|d| to(d, 1.0));
        let rays = up.into_iter().chain([to([0.3, 0.2], -1.0)]).enumerate();
        rays.map(|(i, direction)| ReflectedRay {
            origin: DVec3::new(0.01 * i as f64, 0.02, 0.1),
            direction: 1.3 * direction,
            flux: 1.0 + 0.1 * i as f64,
            mirror: if i == 5 { 2 } else { 3 },
        })
        .collect()
    }

    fn value(merit: &Merit, rays: &[ReflectedRay]) -> MeritValue {
        let mut sums = vec![0.0; merit.sums()];
        rays.iter().for_each(|ray| merit.deposit(ray, &mut sums));
        merit.value(&sums)
    }

    #[test]
    fn derivatives_by_each_ray_agree_with_differences() {
        for merit in merits() {
            let slopes = value(&merit, &rays()).slopes;
            for i in 0..rays().len() {
                let gradient = merit.ray_gradient(&rays()[i], 1.0, &slopes);
                let check = |derivative: f64, change: &dyn Fn(&mut ReflectedRay, f64)| {
                    let h = 2e-6;
                    let at = |step: f64| {
                        let mut moved = rays();
                        change(&mut moved[i], step);
                        value(&merit, &moved).value
                    };
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    assert!(
                        (derivative - slope).abs() < 1e-7 * (1.0 + slope.abs()),
                        "{i}: {derivative} {slope} {merit:?}"
                    );
                };
                check(gradient.flux, &|ray, h| ray.flux += h);
                for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                    check(gradient.origin[axis], &|ray, h| ray.origin += h * unit);
                    check(gradient.direction[axis], &|ray, h| ray.direction += h * unit);
                }
            }
        }
    }

    #[test]
    fn merits_without_flux_are_finite_and_have_no_slopes() {
        for merit in merits() {
            let dark = value(&merit, &[]);
            let slopes: f64 = dark.slopes.iter().map(|slope| slope.abs()).sum();
            let is_flux = matches!(merit, Merit::Flux { .. });
            assert!(dark.value.is_finite() && (is_flux || slopes == 0.0), "{merit:?} {}", dark.value);
            // Nothing is worse.
            assert!(value(&merit, &rays()).value < dark.value || is_flux, "{}", dark.value);
        }
    }

    #[test]
    fn hits_have_more_reward_than_misses_and_no_flux_has_more_than_all() {
        let [_, _, flux, _] = merits();
        let ray = |x: f64, flux: f64| ReflectedRay {
            origin: DVec3::ZERO,
            direction: DVec3::new(x, 0.0, 2.0),
            flux,
            mirror: 0,
        };
        let merit = |x: f64, flux_of_ray: f64| value(&flux, &[ray(x, flux_of_ray)]).value;
        // All 9 lm on the receiver: ideal. A third of it: (2/3)^2. Beyond the border by 10 % of the half side, ln 1.1 = 0.0953: 1 / (1 + 0.953^2) of the reward.
        assert_eq!(merit(0.4, 9.0), 0.0);
        assert!((merit(0.4, 3.0) - 4.0 / 9.0).abs() < 1e-15);
        let (beyond, reward) = (1.1_f64.ln(), 1.0 / (1.0 + (1.1_f64.ln() / 0.1).powi(2)));
        assert!((merit(0.55, 9.0) - ((1.0 - reward).powi(2) + beyond * beyond)).abs() < 1e-14);
        // A sample with more flux than the lamp emits is no better than all of it.
        assert!(merit(0.4, 900.0) > merit(0.4, 9.0));
    }

    #[test]
    fn blocked_light_counts_in_the_total() {
        let [even, _, flux, _] = merits();
        let blocked = |merit: &Merit| {
            let mut sums = vec![0.0; merit.sums()];
            rays().iter().for_each(|ray| merit.deposit(ray, &mut sums));
            merit.deposit_blocked(2.5, &mut sums);
            merit.value(&sums)
        };
        let TargetMeasure::Distribution { share, .. } = blocked(&even).measure else { panic!() };
        assert!((share - 2.1 / 10.0).abs() < 1e-15, "{share}");
        assert_eq!(blocked(&flux).value, value(&flux, &rays()).value);
        let slope = even.blocked_slope(&blocked(&even).slopes);
        let at = |flux: f64| {
            let mut sums = vec![0.0; even.sums()];
            rays().iter().for_each(|ray| even.deposit(ray, &mut sums));
            even.deposit_blocked(flux, &mut sums);
            even.value(&sums).value
        };
        let difference = (at(2.5 + 1e-5) - at(2.5 - 1e-5)) / 2e-5;
        assert!((slope - difference).abs() < 1e-7 * slope.abs(), "{slope} {difference}");
    }

    #[test]
    fn measures_are_those_of_the_rays() {
        let [even, _, flux, collimation] = merits();
        // Five of six rays arrive on the plane, the first two within the receiver.
        let TargetMeasure::Distribution { share, .. } = value(&even, &rays()).measure else { panic!() };
        assert!((share - 2.1 / 7.5).abs() < 1e-15);
        let TargetMeasure::Flux { share } = value(&flux, &rays()).measure else { panic!() };
        assert!((share - 2.1 / 9.0).abs() < 1e-15);
        let tilted = ReflectedRay { direction: DVec3::new(0.03_f64.tan(), 0.0, 1.0), ..rays()[0] };
        let TargetMeasure::Collimation { angle } = value(&collimation, &[tilted]).measure else { panic!() };
        assert!((angle - 0.03).abs() < 1e-12);
    }

    #[test]
    fn even_light_has_no_deviation_and_a_spot_has_one() {
        let [even, ..] = merits();
        let evenly = |side: f64| -> Vec<ReflectedRay> {
            let place = |i: usize| (i as f64 + 0.5) / 48.0 * 2.0 - 1.0;
            let ray = |i: usize| {
                let at = side * DVec2::new(0.5 * place(i % 48), 0.25 * place(i / 48));
                ReflectedRay { origin: DVec3::ZERO, direction: at.extend(2.0), flux: 1.0, mirror: 0 }
            };
            (0..48 * 48).map(ray).collect()
        };
        let deviation = |rays: &[ReflectedRay]| value(&even, rays).value;
        // The lit area is a tenth larger on each side.
        let (ideal, smaller, spot) =
            (deviation(&evenly(1.2)), deviation(&evenly(1.0)), deviation(&evenly(0.1)));
        assert!(ideal < 1e-4 && smaller > 0.01 && spot > 1.0, "{ideal} {smaller} {spot}");
    }
}
