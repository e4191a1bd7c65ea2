//! Rough surfaces as random microscopic facets, each a smooth surface.

pub mod coat;
pub mod energy;
pub mod interface;
pub mod sheen;
mod table;

use std::f64::consts::{FRAC_1_PI, TAU};

use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

/// The distribution of facet normals of Trowbridge and Reitz (GGX), with the masking function of Smith.
///
/// Directions are on the upper side, z >= 0, and of unit length.
///
/// # Source
/// @walter2007, @heitz2014.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MicrofacetDistribution {
    alpha_x: f64,
    alpha_y: f64,
}

/// Widths below which a surface counts as smooth: no picture resolves such lobes.
pub(crate) const SMOOTH: f64 = 1e-3;

impl MicrofacetDistribution {
    /// A smooth surface.
    pub const SMOOTH: Self = Self { alpha_x: 0.0, alpha_y: 0.0 };

    /// A distribution with the root mean squares `alpha_x` and `alpha_y` of the slopes along the tangents, clamped to [0, 1]; NaN counts as
    /// 0.
    #[must_use]
    pub fn new(alpha_x: f64, alpha_y: f64) -> Self {
        // A surface that is smooth along one tangent only would have an unbounded density.
        let [x, y] = [alpha_x, alpha_y].map(clamp_unit);
        if x.max(y) < SMOOTH { Self::SMOOTH } else { Self { alpha_x: x.max(SMOOTH), alpha_y: y.max(SMOOTH) } }
    }

    /// A distribution of one width, see [`MicrofacetDistribution::new`].
    #[must_use]
    pub fn isotropic(alpha: f64) -> Self {
        Self::new(alpha, alpha)
    }

    /// The width of isotropic facets as dense around the normal, [0, 1].
    #[must_use]
    pub fn mean_width(&self) -> f64 {
        if self.is_anisotropic() { (self.alpha_x * self.alpha_y).sqrt() } else { self.alpha_x }
    }

    /// Widths along the tangents, [0, 1].
    #[must_use]
    pub fn alpha(&self) -> [f64; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// Whether the surface has no facets but itself.
    #[inline]
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.alpha_x == 0.0
    }

    /// Whether the distribution depends on the tangents.
    #[inline]
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        self.alpha_x != self.alpha_y
    }

    /// The roughness of glTF, whose square is the width: of anisotropic facets one between both, [0, 1].
    #[must_use]
    pub fn preview_roughness(&self) -> f32 {
        self.mean_width().sqrt() as f32
    }

    /// Density of the facet normal `m`: area of facets per area of surface and steradian.
    #[must_use]
    pub fn density(&self, m: DVec3) -> f64 {
        let (x, y) = (m.x / self.alpha_x, m.y / self.alpha_y);
        let sum = x * x + y * y + m.z * m.z;
        FRAC_1_PI / (self.alpha_x * self.alpha_y * sum * sum)
    }

    /// Area of hidden facets per area of visible ones, both projected along `w`.
    #[must_use]
    pub fn lambda(&self, w: DVec3) -> f64 {
        // The root grows beyond all bounds at grazing angles, where the difference is exact enough.
        0.5 * (self.stretched_length(w) / w.z - 1.0)
    }

    /// Fraction of the facets that both directions see; heights of facets count, so that what one sees is more likely to be seen by the other.
    #[must_use]
    pub fn masking_shadowing(&self, wo: DVec3, wi: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// `D G / (4 cos_o)`: a factor on the Fresnel reflectance of a facet that gives `f cos_i`. `m`: half of the two directions.
    #[must_use]
    pub fn reflection(&self, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
        // cos_o (1 + lambda_o + lambda_i) = (l_o + cos_o l_i / cos_i) / 2 with the stretched lengths, which does not overflow.
        let (o, i) = (self.stretched_length(wo), self.stretched_length(wi));
        0.5 * self.density(m) * wi.z / (o * wi.z + i * wo.z)
    }

    /// Length of `w` in units in which facet normals are distributed evenly over the hemisphere.
    fn stretched_length(&self, w: DVec3) -> f64 {
        DVec3::new(w.x * self.alpha_x, w.y * self.alpha_y, w.z).length()
    }

    /// A direction that a facet reflects from `wo`, by two numbers uniform in [0, 1); most are above the surface.
    ///
    /// # Source
    /// @eto2023, listing 1.
    #[must_use]
    pub fn sample_reflection(&self, wo: DVec3, xi: DVec2) -> DVec3 {
        let m = self.sample_cap(wo, xi, self.lower_bound(wo));
        2.0 * wo.dot(m) * m - wo
    }

    /// Density with which [`MicrofacetDistribution::sample_reflection`] draws the direction whose half with `wo` is `m`.
    #[must_use]
    pub fn reflection_pdf(&self, wo: DVec3, m: DVec3) -> SolidAnglePdf {
        let length = self.stretched_length(wo);
        SolidAnglePdf(self.density(m) / (2.0 * (self.lower_bound(wo) * wo.z + length)))
    }

    /// A direction that facets reflect from `wo` once, or with the probability `multiple` more than once, which is diffuse; it may be below the
    /// surface.
    pub(crate) fn sample_scattering(&self, wo: DVec3, multiple: f64, xi: DVec2, xi_lobe: f64) -> DVec3 {
        if xi_lobe < multiple {
            warp::cosine_hemisphere(xi)
        } else {
            self.sample_reflection(wo, xi).normalize()
        }
    }

    /// Density of [`MicrofacetDistribution::sample_scattering`] for `wi` above.
    pub(crate) fn scattering_pdf(&self, wo: DVec3, wi: DVec3, multiple: f64) -> f64 {
        let once = self.reflection_pdf(wo, half_vector(wo, wi)).0;
        (1.0 - multiple) * once + multiple * warp::cosine_hemisphere_pdf(wi.z).0
    }

    /// A facet normal among those that `wo` sees, by two numbers uniform in [0, 1).
    ///
    /// # Source
    /// @dupuy2023.
    #[must_use]
    pub fn sample_visible(&self, wo: DVec3, xi: DVec2) -> DVec3 {
        self.sample_cap(wo, xi, 1.0)
    }

    /// Density per steradian of [`MicrofacetDistribution::sample_visible`] for the normal `m`.
    #[must_use]
    pub fn visible_pdf(&self, wo: DVec3, m: DVec3) -> f64 {
        2.0 * self.density(m) * wo.dot(m).max(0.0) / (wo.z + self.stretched_length(wo))
    }

    /// The factor on the lower end of the cap of directions, below which none is above the surface.
    fn lower_bound(&self, wo: DVec3) -> f64 {
        let a2 = self.alpha_x.min(self.alpha_y).powi(2);
        let s2 = (1.0 + wo.truncate().length()).powi(2);
        (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z)
    }

    /// The normal between stretched `wo` and a direction of a cap around z, the lower end of which is `-bound` times its height.
    fn sample_cap(&self, wo: DVec3, xi: DVec2, bound: f64) -> DVec3 {
        let stretched = DVec3::new(wo.x * self.alpha_x, wo.y * self.alpha_y, wo.z).normalize();
        let bound = bound * stretched.z;
        let z = (1.0 - xi.y) * (1.0 + bound) - bound;
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * xi.x).sin_cos();
        let m = stretched + DVec3::new(sin * cos_phi, sin * sin_phi, z);
        let m = DVec3::new(m.x * self.alpha_x, m.y * self.alpha_y, m.z.max(0.0));
        // Opposite vectors, by rounding at grazing angles.
        m.try_normalize().unwrap_or(DVec3::Z)
    }
}

/// The facet normal that reflects between two directions above.
pub(crate) fn half_vector(wo: DVec3, wi: DVec3) -> DVec3 {
    // Along the surface, opposite directions may sum up to less than the smallest number.
    (wo + wi).try_normalize().unwrap_or(DVec3::Z)
}

/// `x` clamped to [0, 1]; NaN becomes 0.
pub(crate) fn clamp_unit(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distributions() -> [MicrofacetDistribution; 5] {
        [(0.05, 0.05), (0.3, 0.3), (1.0, 1.0), (0.1, 0.4), (0.8, 0.2)]
            .map(|(x, y)| MicrofacetDistribution::new(x, y))
    }

    fn direction(cos: f64, azimuth: f64) -> DVec3 {
        let sin = (1.0 - cos * cos).sqrt();
        DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    /// The integral of `f` over the upper hemisphere by the midpoint rule, in coordinates in which density is even.
    fn integral(distribution: &MicrofacetDistribution, f: impl Fn(DVec3) -> f64) -> f64 {
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (s, phi) =
                    ((f64::from(i) + 0.5) / f64::from(n), TAU * (f64::from(j) + 0.5) / f64::from(n));
                // Normals with density D cos: tan(theta)^2 = u / (1 - u) in stretched coordinates, for u = 1 - s^2.
                let slope = (1.0 - s * s).sqrt() / s;
                let [x, y] = distribution.alpha();
                let m = DVec3::new(x * slope * phi.cos(), y * slope * phi.sin(), 1.0).normalize();
                sum += 2.0 * s * f(m) / (distribution.density(m) * m.z);
            }
        }
        sum / f64::from(n * n)
    }

    #[test]
    fn facets_cover_the_surface_once_seen_from_anywhere() {
        // The projected area of the facets that are seen is the projected area of the surface (@heitz2014 eq. 14).
        for d in distributions() {
            assert!((integral(&d, |m| d.density(m) * m.z) - 1.0).abs() < 1e-4);
            for (cos, azimuth) in [(1.0, 0.0), (0.7, 0.5), (0.2, 1.2)] {
                let wo = direction(cos, azimuth);
                let seen = |m: DVec3| d.density(m) * wo.dot(m).max(0.0) / (1.0 + d.lambda(wo));
                let area = integral(&d, seen);
                assert!((area / cos - 1.0).abs() < 1e-3, "{d:?} {cos}: {area}");
                let density = integral(&d, |m| d.visible_pdf(wo, m));
                assert!((density - 1.0).abs() < 1e-3, "{d:?} {cos}: {density}");
            }
        }
    }

    #[test]
    fn reflection_is_density_times_masking_over_the_cosines() {
        for d in distributions() {
            let (wo, wi) = (direction(0.6, 0.3), direction(0.35, 2.9));
            let m = (wo + wi).normalize();
            let expected = d.density(m) * d.masking_shadowing(wo, wi) / (4.0 * wo.z);
            assert!((d.reflection(wo, wi, m) / expected - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn widths_out_of_range_are_clamped() {
        assert!(MicrofacetDistribution::new(5e-4, 0.0).is_smooth());
        assert!(MicrofacetDistribution::new(f64::NAN, -1.0).is_smooth());
        assert_eq!(MicrofacetDistribution::new(0.0, 7.0).alpha(), [SMOOTH, 1.0]);
        assert!(MicrofacetDistribution::new(0.2, 0.3).is_anisotropic());
    }

    #[test]
    fn sampled_reflections_are_rarely_below_the_surface() {
        let below = |d: &MicrofacetDistribution, wo: DVec3| {
            let n = 64;
            let grid =
                (0..n * n).map(|i| DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n));
            grid.filter(|&xi| d.sample_reflection(wo, xi).z <= 0.0).count() as f64 / f64::from(n * n)
        };
        for d in distributions().into_iter().filter(|d| !d.is_anisotropic()) {
            for cos in [1.0, 0.7, 0.2] {
                // Without the bound a third of the samples at alpha 1 are lost.
                assert!(below(&d, direction(cos, 0.0)) < 0.12, "{d:?} {cos}");
            }
        }
    }
}
