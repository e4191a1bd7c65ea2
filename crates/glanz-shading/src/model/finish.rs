//! Surface finish: light that a polished mirror scatters around the mirrored direction.
//!
//! Scattering is shift-invariant in direction cosines, after Harvey and Shack: with `beta` the projections of unit vectors on the tangent
//! plane, the BSDF is the reflectance times a kernel `b(|beta_i - beta_r|)`, where `beta_r` belongs to the mirrored direction. Distances of
//! projections are the same in both directions of light, so that the model is reciprocal. In the tangent plane an element of solid angle times
//! the cosine to the normal is an element of area, so that the scattered fraction of the light is the integral of the kernel over the part of
//! the unit disk around `beta_r`: at normal incidence the total integrated scatter (TIS), under other angles less. What is not scattered
//! stays in the mirrored direction: no light is lost, and none is created.
//!
//! # Source
//! @harvey1976 for the invariance, @pfisterer2011 for the ABg kernel; departure: the light that the kernel would send beyond the unit disk is
//! reflected, as @krywonos2011 derives for waves that do not propagate.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::basis::GaussLegendre;

use super::mirror::mirror_image;
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, to_side_of, upper_side};

/// A kernel of scattering by the distance of direction cosines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FinishModel {
    /// A normal distribution.
    Gaussian {
        /// Standard deviation along each of the two axes, in direction cosines: near normal incidence in radians; from 1e-6 to 1.
        sigma: f64,
        /// Fraction of the reflected light that is scattered at normal incidence, [0, 1].
        fraction: f64,
    },
    /// `A / (B + |beta_i - beta_r|^g)`, per steradian.
    Abg {
        /// The factor, from 0 to 1e6.
        a: f64,
        /// The `g`-th power of the distance where the kernel falls off, from 1e-12 to 1e6.
        b: f64,
        /// Slope of the fall in a plot of logarithms, from 0 to 10.
        g: f64,
    },
}

/// An error in the parameters of a finish.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FinishError {
    /// A number is out of range.
    #[error("{parameter} is {value}; it must be {range}")]
    Range {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// More light would be scattered than is reflected.
    #[error("the total integrated scatter is {total:.6}; it must be at most 1: lower A or raise B")]
    Scatter {
        /// The total integrated scatter.
        total: f64,
    },
}

/// A kernel with the tables to draw from it, which clones share; the BSDFs at points refer to that of their material.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFinish {
    model: FinishModel,
    tables: Arc<FinishTables>,
}

/// Number of rings around the mirrored direction. Within one the kernel of the steepest finish changes by a few per cent, that of others by less than one,
/// which is the unevenness of the weights of samples.
const RINGS: usize = 4096;

/// Number of steps of the table by the angle of incidence.
const INCIDENCE_STEPS: usize = 1024;

/// Standard deviations beyond which a normal distribution counts as 0: it has less than 2e-14 of its weight there.
const GAUSSIAN_REACH: f64 = 8.0;

/// Integrals of a kernel.
#[derive(Clone, Debug, PartialEq)]
struct FinishTables {
    /// Factor on [`FinishModel::shape`].
    scale: f64,
    /// Scattered fraction at normal incidence.
    total: f64,
    /// Distance below which rings are about equally wide; beyond, their width is in proportion to the distance.
    width: f64,
    /// Distance from which on the kernel is 0, at most 2.
    reach: f64,
    /// Squared inner radius of each ring and scattered fraction within; the last is the outer radius of the last ring.
    rings: Vec<[f64; 2]>,
    /// Scattered fraction by the distance of the mirrored direction from the edge of the unit disk, in the steps of [`ring_steps`].
    by_edge_distance: Vec<f64>,
}

impl FinishModel {
    /// The kernel but for its factor.
    fn shape(self, r: f64) -> f64 {
        match self {
            Self::Gaussian { sigma, .. } => (-0.5 * (r / sigma).powi(2)).exp(),
            Self::Abg { a, b, g } => a / (b + r.powf(g)),
        }
    }

    fn check(self) -> Result<Self, FinishError> {
        let check = |parameter, value: f64, [low, high]: [f64; 2], range| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(FinishError::Range { parameter, value, range })
            }
        };
        match self {
            Self::Gaussian { sigma, fraction } => {
                check("sigma", sigma, [1e-6, 1.0], "a number from 1e-6 to 1")?;
                check("fraction", fraction, [0.0, 1.0], "a number from 0 to 1")?;
            }
            Self::Abg { a, b, g } => {
                check("A", a, [0.0, 1e6], "a number from 0 to 1e6")?;
                check("B", b, [1e-12, 1e6], "a number from 1e-12 to 1e6")?;
                check("g", g, [0.0, 10.0], "a number from 0 to 10")?;
            }
        }
        Ok(self)
    }
}

impl SurfaceFinish {
    /// Integrates the kernel.
    ///
    /// # Errors
    /// [`FinishError::Range`] for a parameter out of range, [`FinishError::Scatter`] for a total integrated scatter above 1.
    pub fn try_new(model: FinishModel) -> Result<Self, FinishError> {
        let model = model.check()?;
        let (width, reach) = match model {
            FinishModel::Gaussian { sigma, .. } => (sigma, (GAUSSIAN_REACH * sigma).min(2.0)),
            // For g near 0 the power has no scale of its own.
            FinishModel::Abg { b, g, .. } => (b.powf(1.0 / g.max(0.5)).clamp(1e-12, 1.0), 2.0),
        };
        let mut tables = FinishTables {
            scale: 1.0,
            total: 0.0,
            width,
            reach,
            rings: Vec::with_capacity(RINGS + 1),
            by_edge_distance: Vec::new(),
        };
        let rule = GaussLegendre::new(4);
        let (step, mut within, mut inner) = (ring_steps(reach, width) / RINGS as f64, 0.0, 0.0);
        tables.rings.push([0.0; 2]);
        for ring in 1..=RINGS {
            let outer = width * (step * ring as f64).exp_m1();
            within += rule.integrate(inner, outer, |r| TAU * r * model.shape(r));
            tables.rings.push([outer * outer, within]);
            inner = outer;
        }
        tables.total = tables.within(1.0);
        if let FinishModel::Gaussian { fraction, .. } = model {
            tables.scale = fraction / tables.total;
            tables.rings.iter_mut().for_each(|[_, within]| *within *= tables.scale);
            tables.total = fraction;
        }
        if tables.total > 1.0 {
            return Err(FinishError::Scatter { total: tables.total });
        }
        tables.add_incidences();
        Ok(Self { model, tables: Arc::new(tables) })
    }

    /// The kernel.
    #[must_use]
    pub fn model(&self) -> FinishModel {
        self.model
    }

    /// Whether both use the same tables in memory, as clones do.
    #[must_use]
    pub fn shares_tables_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tables, &other.tables)
    }

    /// Total integrated scatter: the fraction of the reflected light that is scattered at normal incidence, [0, 1].
    #[must_use]
    pub fn total_scatter(&self) -> f64 {
        self.tables.total
    }

    /// Fraction of the reflected light that is scattered for light along `w`, above the surface, [0, 1].
    #[must_use]
    pub fn scattered(&self, w: DVec3) -> f64 {
        let from_center = w.truncate().length().min(1.0);
        // Free of cancellation at grazing angles.
        self.tables.scattered(w.z * w.z / (1.0 + from_center))
    }

    /// `f cos_i` over the reflectance, for directions above.
    pub(super) fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        let r = (wo + wi).truncate().length();
        if r < self.tables.reach { self.tables.scale * self.model.shape(r) * wi.z } else { 0.0 }
    }

    /// Density of [`SurfaceFinish::sample`] for directions above, per steradian.
    pub(super) fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let drawn = self.drawn(wo.truncate());
        self.tables.ring_density((wo + wi).truncate().length()) * wi.z / drawn.max(1.0)
    }

    /// The mirror image of a reflectance, or a direction of scattered light of `model`.
    ///
    /// A draw beyond the horizon is a mirror image, as is the light: all weights are about the reflectance, unless the kernel has more than 1 around the
    /// direction and beyond the horizon.
    pub(super) fn sample<M: BsdfModel>(
        &self,
        model: &M,
        reflectance: Spectrum,
        wo: DVec3,
        (xi, xi_lobe): (DVec2, f64),
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        let [up, _] = upper_side(wo, wo)?;
        let projection = up.truncate();
        let drawn = self.drawn(projection);
        let radius = (xi_lobe < drawn).then(|| self.tables.sample_radius(xi.x * drawn)).flatten();
        let scattered = radius.and_then(|r| {
            let (sin, cos) = (TAU * xi.y).sin_cos();
            let to = r * DVec2::new(cos, sin) - projection;
            let z2 = 1.0 - to.length_squared();
            (z2 > 0.0).then(|| to.extend(z2.sqrt()))
        });
        if let Some(wi) = scattered {
            return BsdfSample::of_direction(model, [wo, to_side_of(wo, wi)], Lobe::GLOSSY, mode);
        }
        let share = self.scattered(up);
        let weight = if drawn > 1.0 { (1.0 - share) / (1.0 - share / drawn) } else { 1.0 };
        Some(mirror_image(wo, reflectance * weight as f32))
    }

    /// The integral of the kernel to the far edge of the unit disk, for the projection of a direction; it may be above 1.
    fn drawn(&self, projection: DVec2) -> f64 {
        self.tables.within(1.0 + projection.length())
    }

    /// Mirror image of a reflectance without the scattered fraction; `None` if nothing is left.
    pub(super) fn mirror_image(&self, reflectance: Spectrum, wo: DVec3) -> Option<BsdfSample> {
        let [up, _] = upper_side(wo, wo)?;
        let weight = reflectance * (1.0 - self.scattered(up)) as f32;
        (!weight.is_black()).then(|| mirror_image(wo, weight))
    }
}

/// Number of a ring, not rounded, times its step: about r / width below the width, then a logarithm.
fn ring_steps(r: f64, width: f64) -> f64 {
    (r / width).ln_1p()
}

impl FinishTables {
    /// The ring around a distance below the reach, with that beyond it.
    fn ring(&self, r: f64) -> Option<[[f64; 2]; 2]> {
        let ring = ring_steps(r, self.width) / ring_steps(self.reach, self.width) * RINGS as f64;
        let ring = (ring as usize).min(RINGS - 1);
        Some([*self.rings.get(ring)?, *self.rings.get(ring + 1)?])
    }

    /// Fraction that is scattered by less than this distance, if nothing is beyond the unit disk.
    fn within(&self, r: f64) -> f64 {
        if r >= self.reach {
            return self.rings.last().map_or(0.0, |&[_, within]| within);
        }
        self.ring(r).map_or(0.0, |[[from, inner], [to, outer]]| {
            inner + (outer - inner) * (r * r - from) / (to - from)
        })
    }

    /// Scattered fraction per area of direction cosines, constant in each ring.
    fn ring_density(&self, r: f64) -> f64 {
        let ring = if r < self.reach { self.ring(r) } else { None };
        ring.map_or(0.0, |[[from, inner], [to, outer]]| (outer - inner) / (PI * (to - from)))
    }

    /// The distance within which the kernel has this integral; `None` if nothing is scattered.
    fn sample_radius(&self, wanted: f64) -> Option<f64> {
        let outer = self.rings.partition_point(|&[_, within]| within <= wanted);
        let [from, inner] = *self.rings.get(outer.checked_sub(1)?)?;
        let [to, outer] = *self.rings.get(outer)?;
        Some((from + (to - from) * (wanted - inner) / (outer - inner)).sqrt())
    }

    /// Scattered fraction if the mirrored direction is at this distance from the edge of the unit disk.
    fn scattered(&self, edge_distance: f64) -> f64 {
        let most = self.reach.min(1.0);
        if edge_distance >= most {
            return self.total;
        }
        let at =
            ring_steps(edge_distance, self.width) / ring_steps(most, self.width) * INCIDENCE_STEPS as f64;
        let step = (at as usize).min(INCIDENCE_STEPS - 1);
        match self.by_edge_distance.get(step..step + 2) {
            Some(&[a, b]) => a + (b - a) * (at - step as f64),
            _ => self.total,
        }
    }

    /// Fills the table by the angle of incidence.
    ///
    /// Around the mirrored direction, the fraction within the edge of the unit disk is integrated over the azimuth, in which the edge is nearly a step
    /// across the plane of incidence if the direction is close to it.
    fn add_incidences(&mut self) {
        let (most, rule) = (self.reach.min(1.0), GaussLegendre::new(32));
        let step = ring_steps(most, self.width) / INCIDENCE_STEPS as f64;
        self.by_edge_distance = (0..=INCIDENCE_STEPS)
            .map(|number| {
                let distance = (self.width * (step * number as f64).exp_m1()).min(1.0);
                let power = distance * (2.0 - distance);
                let half = |sign: f64| {
                    rule.integrate(0.0, 1.0, |s| {
                        let cos = sign * (0.5 * PI * s.powi(3)).sin();
                        let root = (cos * cos + power * (1.0 - cos * cos)).sqrt();
                        let along = (1.0 - distance) * cos;
                        // Of the two forms of the distance to the edge, that without cancellation.
                        let edge = if along > 0.0 { power / (root + along) } else { root - along };
                        3.0 * s * s * self.within(edge)
                    })
                };
                (0.5 * (half(1.0) + half(-1.0))).min(self.total)
            })
            .collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Mirror;

    fn abg(a: f64, b: f64, g: f64) -> Result<SurfaceFinish, FinishError> {
        SurfaceFinish::try_new(FinishModel::Abg { a, b, g })
    }

    fn gaussian(sigma: f64, fraction: f64) -> SurfaceFinish {
        SurfaceFinish::try_new(FinishModel::Gaussian { sigma, fraction }).unwrap()
    }

    fn direction(cos: f64) -> DVec3 {
        DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    #[test]
    fn total_scatter_of_abg_is_that_of_closed_forms() {
        // The ring of the horizon counts in proportion to area.
        let near =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 2e-6, "{found} {expected}");
        for b in [1e-10, 1e-6, 1e-3, 0.1, 10.0] {
            // The integral of 2 pi r A / (B + r^2).
            near(abg(0.01, b, 2.0).unwrap().total_scatter(), PI * 0.01 * (1.0 / b).ln_1p());
            // Of 2 pi r A / (B + r).
            let of_one = TAU * 0.01 * (1.0 - b * (1.0 / b).ln_1p());
            assert!((abg(0.01, b, 1.0).unwrap().total_scatter() - of_one).abs() < 1e-6);
            // Of 2 pi r A / (B + r^4).
            let root = b.sqrt();
            near(abg(1e-7, b, 4.0).unwrap().total_scatter(), PI * 1e-7 / root * (1.0 / root).atan());
        }
        // The same in all directions.
        near(abg(0.2, 1.0, 0.0).unwrap().total_scatter(), PI * 0.1);
    }

    #[test]
    fn scatter_of_all_light_is_refused_with_its_fraction() {
        // pi A ln(1 + 1 / B) = 1 with ln(1 + 1 / B) = ln 11.
        let most = 1.0 / (PI * 11.0_f64.ln());
        assert!(abg(most * 0.999_99, 0.1, 2.0).is_ok());
        let error = abg(most * 1.5, 0.1, 2.0).unwrap_err();
        assert!(matches!(error, FinishError::Scatter { total } if (total - 1.5).abs() < 2e-6), "{error}");
        assert!(error.to_string().starts_with("the total integrated scatter is 1."), "{error}");
        assert!(matches!(abg(0.1, 0.0, 2.0), Err(FinishError::Range { parameter: "B", .. })));
        assert!(matches!(abg(0.1, 0.1, f64::NAN), Err(FinishError::Range { parameter: "g", .. })));
    }

    #[test]
    fn scatter_of_slanted_light_is_the_integral_over_the_unit_disk() {
        // By the midpoint rule over the disk, in polar coordinates around its centre.
        for (finish, tolerance) in [(abg(0.05, 0.05, 2.0).unwrap(), 3e-4), (gaussian(0.15, 0.8), 3e-4)] {
            for cos in [1.0, 0.8, 0.4, 0.1, 0.01] {
                let wo = direction(cos);
                let (n, m) = (400, 400);
                let mut sum = 0.0;
                for i in 0..n {
                    let r = (f64::from(i) + 0.5) / f64::from(n);
                    for k in 0..m {
                        let (sin, cos) = (TAU * (f64::from(k) + 0.5) / f64::from(m)).sin_cos();
                        let wi = DVec3::new(r * cos, r * sin, (1.0 - r * r).sqrt());
                        sum += finish.value(wo, wi) / wi.z * r;
                    }
                }
                let expected = sum * TAU / f64::from(n * m);
                let found = finish.scattered(wo);
                assert!((found - expected).abs() < tolerance, "{cos}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn narrow_kernels_scatter_the_same_at_all_but_grazing_angles() {
        let finish = gaussian(1e-3, 1.0);
        for cos in [1.0, 0.5, 0.2] {
            assert_eq!(finish.scattered(direction(cos)), 1.0, "{cos}");
        }
        // In the plane of the surface, half of the kernel is beyond the edge of the disk, which is nearly straight.
        let grazing = finish.scattered(direction(1e-9));
        assert!((grazing - 0.5).abs() < 2e-3, "{grazing}");
    }

    #[test]
    fn kernels_with_more_than_all_light_beyond_the_horizon_lose_none() {
        // Even scattering of 0.63 of the light: four times as much within the distance 2.
        let finish = abg(0.3, 0.5, 0.0).unwrap();
        let mirror = Mirror { reflectance: Spectrum::ONE, finish: Some(&finish) };
        for cos in [1.0, 0.6, 0.1] {
            let n = 1 << 16;
            let (mut all, mut scattered) = (0.0, 0.0);
            for i in 0..n {
                // A lattice.
                let at = |step: f64| (0.5 + step * f64::from(i)).fract();
                let xi = DVec2::new((f64::from(i) + 0.5) / f64::from(n), at(0.754_877_666_246_692_8));
                let sample =
                    mirror.sample(direction(cos), xi, at(0.569_840_290_998_053_3), TransportMode::Radiance);
                let Some(sample) = sample else { continue };
                let weight = f64::from(sample.weight.hero()) / f64::from(n);
                all += weight;
                scattered += if sample.lobe.is_delta() { 0.0 } else { weight };
            }
            assert!((all - 1.0).abs() < 2e-3, "{cos}: {all}");
            assert!((scattered - 0.2 * PI).abs() < 3e-3, "{cos}: {scattered}");
        }
    }
}
