//! The energy that facets scatter once, and what is left for light between facets.
//!
//! The microfacet models follow light to one facet; what that facet sends to another one is lost. It is more the rougher the surface is, up to
//! half. Here are the fractions that are not lost, tabulated on first use, and a diffuse lobe that returns the rest: proportional to the
//! loss in both directions, so that it is reciprocal, and exactly as large as the loss, so that facets without absorption scatter all light.
//!
//! # Source
//! @kulla2017; departure: the fractions are tables over both widths of anisotropic surfaces.

use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

use glanz_math::{DVec2, DVec3};
use glanz_sampling::basis::GaussLegendre;

use super::table::InterpolationTable;
use super::{MicrofacetDistribution, SMOOTH};
use crate::fresnel;

/// Fraction of the flux from `w` (above the surface) that facets without absorption reflect once and no other facet blocks.
///
/// Error at most 0.005, of very anisotropic facets 0.03.
#[must_use]
pub fn reflected(distribution: &MicrofacetDistribution, w: DVec3) -> f64 {
    if distribution.is_smooth() {
        return 1.0;
    }
    let [x, y] = distribution.alpha();
    if x == y {
        return REFLECTED.directional.at([x, masking_coordinate(w.z, x)]);
    }
    let azimuth = w.y.abs().atan2(w.x.abs());
    let masking = masking_coordinate(w.z, width_along(x, y, azimuth));
    REFLECTED_ANISOTROPIC.directional.at([x.sqrt(), y.sqrt(), azimuth / FRAC_PI_2, masking])
}

/// The mean of [`reflected`] over diffuse light.
#[must_use]
pub fn mean_reflected(distribution: &MicrofacetDistribution) -> f64 {
    if distribution.is_smooth() {
        return 1.0;
    }
    let [x, y] = distribution.alpha();
    if x == y { REFLECTED.mean.at([x]) } else { REFLECTED_ANISOTROPIC.mean.at([x.sqrt(), y.sqrt()]) }
}

/// Fraction of light with the cosine `cos` (>= 0) to the normal that an interface of facets without absorption neither reflects nor
/// transmits at once.
///
/// `alpha`: width of the facets. `eta`: refractive index on the far side over that on the near side, in [0.001, 1000]. Error below 0.06 for
/// cosines of at least 0.05, mostly below 0.02.
#[must_use]
pub fn interface_loss(alpha: f64, eta: f64, cos: f64) -> f64 {
    if alpha < SMOOTH {
        return 0.0;
    }
    let (table, index) = loss_table(eta);
    table.directional.at([index, alpha, masking_coordinate(cos, alpha)])
}

/// The mean of [`interface_loss`] over diffuse light.
#[must_use]
pub fn mean_interface_loss(alpha: f64, eta: f64) -> f64 {
    if alpha < SMOOTH {
        return 0.0;
    }
    let (table, index) = loss_table(eta);
    table.mean.at([index, alpha])
}

/// Fraction of the light from `w` (above, which is outside) that an interface of facets reflects at once.
///
/// Of anisotropic facets by those of the width along the azimuth, corrected as if they were of metal; error below 0.05. `eta`: as of
/// [`interface_reflectance`].
#[must_use]
pub fn directional_reflectance(distribution: &MicrofacetDistribution, eta: f64, w: DVec3) -> f64 {
    let [x, y] = distribution.alpha();
    if x == y {
        return interface_reflectance(x, eta, w.z);
    }
    let along = width_along(x, y, w.y.atan2(w.x));
    let correction = reflected(distribution, w) / reflected(&MicrofacetDistribution::isotropic(along), w);
    (interface_reflectance(along, eta, w.z) * correction).min(1.0)
}

/// The mean of [`directional_reflectance`] over diffuse light.
#[must_use]
pub fn mean_directional_reflectance(distribution: &MicrofacetDistribution, eta: f64) -> f64 {
    /// Azimuths within a right angle, at equal steps from the middle of the first.
    const COUNT: u32 = 4;
    let [x, y] = distribution.alpha();
    if x == y {
        return mean_interface_reflectance(x, eta);
    }
    let steps = (0..COUNT).map(|i| {
        let along = width_along(x, y, (f64::from(i) + 0.5) / f64::from(COUNT) * FRAC_PI_2);
        let isotropic = mean_reflected(&MicrofacetDistribution::isotropic(along));
        mean_interface_reflectance(along, eta) * mean_reflected(distribution) / isotropic
    });
    (steps.sum::<f64>() / f64::from(COUNT)).min(1.0)
}

/// Fraction of light from outside, with the cosine `cos` (>= 0) to the normal, that an interface of facets reflects at once. `eta`: refractive
/// index inside over that outside, in [1, 1000]. Error below 0.06 for cosines of at least 0.05, mostly below 0.02.
#[must_use]
pub fn interface_reflectance(alpha: f64, eta: f64, cos: f64) -> f64 {
    if alpha < SMOOTH {
        return fresnel::dielectric(cos, eta).reflectance;
    }
    INTERFACE.directional.at([index_coordinate(eta), alpha, cos.max(0.0).sqrt()])
}

/// The mean of [`interface_reflectance`] over diffuse light.
#[must_use]
pub fn mean_interface_reflectance(alpha: f64, eta: f64) -> f64 {
    INTERFACE.mean.at([index_coordinate(eta), alpha])
}

/// A table over a direction, the last axis, and that of its mean over diffuse light.
struct EnergyTable<const N: usize, const M: usize> {
    directional: InterpolationTable<N>,
    mean: InterpolationTable<M>,
}

impl<const N: usize, const M: usize> EnergyTable<N, M> {
    /// `mean`: of the table, for the parameters before the direction.
    fn new(
        nodes: [usize; N],
        directional: impl Fn([f64; N]) -> f64,
        mean: impl Fn(&InterpolationTable<N>, [f64; M]) -> f64,
    ) -> Self {
        let directional = InterpolationTable::new(nodes, directional);
        let other = std::array::from_fn(|axis| nodes[axis]);
        Self { mean: InterpolationTable::new(other, |point| mean(&directional, point)), directional }
    }
}

/// Of isotropic facets: width, masking.
static REFLECTED: LazyLock<EnergyTable<2, 1>> = LazyLock::new(|| {
    let directional = |[alpha, masking]: [f64; 2]| {
        let alpha = alpha.max(SMOOTH);
        reflected_once(alpha, alpha, direction(masked_cosine(masking, alpha), 0.0))
    };
    let mean = |table: &InterpolationTable<2>, [alpha]: [f64; 1]| {
        diffuse_mean(&RULE, |cos| table.at([alpha, masking_coordinate(cos, alpha)]))
    };
    EnergyTable::new([17, 33], directional, mean)
});

/// Of anisotropic facets: square roots of the widths, azimuth from the first tangent in right angles, masking.
static REFLECTED_ANISOTROPIC: LazyLock<EnergyTable<4, 2>> = LazyLock::new(|| {
    let width = |root: f64| (root * root).max(SMOOTH);
    let directional = |[x, y, azimuth, masking]: [f64; 4]| {
        let (x, y, azimuth) = (width(x), width(y), azimuth * FRAC_PI_2);
        reflected_once(x, y, direction(masked_cosine(masking, width_along(x, y, azimuth)), azimuth))
    };
    let mean = |table: &InterpolationTable<4>, [x, y]: [f64; 2]| {
        GaussLegendre::new(6).integrate(0.0, 1.0, |azimuth| {
            let along = width_along(width(x), width(y), azimuth * FRAC_PI_2);
            diffuse_mean(&RULE, |cos| table.at([x, y, azimuth, masking_coordinate(cos, along)]))
        })
    };
    EnergyTable::new([11, 11, 7, 17], directional, mean)
});

/// The loss of interfaces for light from the thinner or the denser side, and the coordinate of the index: index, width, masking.
fn loss_table(eta: f64) -> (&'static EnergyTable<3, 2>, f64) {
    static ENTERING: LazyLock<EnergyTable<3, 2>> = LazyLock::new(|| new_loss_table(1.0));
    static LEAVING: LazyLock<EnergyTable<3, 2>> = LazyLock::new(|| new_loss_table(-1.0));
    // The loss changes fast where indices are almost equal.
    (if eta < 1.0 { &LEAVING } else { &ENTERING }, amplitude(eta.max(1.0 / eta)).sqrt())
}

fn new_loss_table(sign: f64) -> EnergyTable<3, 2> {
    let directional = |[index, alpha, masking]: [f64; 3]| {
        let (alpha, eta) = (alpha.max(SMOOTH), index_at(index * index).powf(sign));
        let [reflected, transmitted] =
            scattered_once(alpha, eta, direction(masked_cosine(masking, alpha), 0.0), true);
        (1.0 - reflected - transmitted).max(0.0)
    };
    let mean = |table: &InterpolationTable<3>, [index, alpha]: [f64; 2]| {
        diffuse_mean(&RULE, |cos| table.at([index, alpha, masking_coordinate(cos, alpha)]))
    };
    EnergyTable::new([21, 17, 25], directional, mean)
}

/// Largest refractive index of the tables, and the inverse of the smallest.
const LARGEST_INDEX: f64 = 1e3;

/// The amplitude that an interface of an index of at least 1 reflects at normal incidence, over that of the largest index.
fn amplitude(eta: f64) -> f64 {
    (eta - 1.0) / (eta + 1.0) * (LARGEST_INDEX + 1.0) / (LARGEST_INDEX - 1.0)
}

/// The inverse of [`amplitude`].
fn index_at(amplitude: f64) -> f64 {
    let amplitude = amplitude * (LARGEST_INDEX - 1.0) / (LARGEST_INDEX + 1.0);
    (1.0 + amplitude) / (1.0 - amplitude)
}

/// The coordinate of an index of at least 1 in the table of reflectances. Of grazing light they change fast where indices are almost equal
/// and where almost all light is reflected: nodes are close there.
fn index_coordinate(eta: f64) -> f64 {
    amplitude(eta).clamp(0.0, 1.0).sqrt().asin() / FRAC_PI_2
}

/// Reflectance of interfaces from the thinner side: index, width, square root of the cosine.
static INTERFACE: LazyLock<EnergyTable<3, 2>> = LazyLock::new(|| {
    let directional = |[index, alpha, root]: [f64; 3]| {
        let eta = index_at((index * FRAC_PI_2).sin().powi(2));
        let [reflected, _] = scattered_once(alpha.max(SMOOTH), eta, direction(root * root, 0.0), false);
        reflected
    };
    let mean = |table: &InterpolationTable<3>, [index, alpha]: [f64; 2]| {
        diffuse_mean(&RULE, |cos| table.at([index, alpha, cos.sqrt()]))
    };
    EnergyTable::new([21, 17, 25], directional, mean)
});

/// The mean over diffuse light of a function of the cosine, by the nodes of `rule`.
pub(super) fn diffuse_mean(rule: &GaussLegendre, f: impl Fn(f64) -> f64) -> f64 {
    // With cos = x^2 the weight 2 cos d(cos) is 4 x^3 dx.
    rule.integrate(0.0, 1.0, |x| 4.0 * x.powi(3) * f(x * x))
}

/// The rule for tables.
static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(16));

/// The coordinate of a cosine in tables: facets of the width `alpha` hide one another where the cosine is about `alpha`, and everything that
/// depends on this is smooth in it for narrow and for wide ones.
fn masking_coordinate(cos: f64, alpha: f64) -> f64 {
    let (cos, alpha) = (cos.max(0.0), alpha.max(SMOOTH));
    cos * (1.0 + alpha) / (cos + alpha)
}

/// The inverse of [`masking_coordinate`].
fn masked_cosine(coordinate: f64, alpha: f64) -> f64 {
    coordinate * alpha / (1.0 + alpha - coordinate)
}

/// The width of anisotropic facets along an azimuth.
fn width_along(alpha_x: f64, alpha_y: f64, azimuth: f64) -> f64 {
    (alpha_x * azimuth.cos()).hypot(alpha_y * azimuth.sin())
}

fn direction(cos: f64, azimuth: f64) -> DVec3 {
    // Grazing light has a limit, which is approached here.
    let cos = cos.clamp(1e-4, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

/// The integral of `f` over the unit square. It is periodic in the first coordinate and, if `is_even`, the same for 1 minus that.
fn over_samples<const N: usize>(
    is_even: bool,
    rule: &GaussLegendre,
    f: impl Fn(DVec2) -> [f64; N],
) -> [f64; N] {
    const TURN: u32 = 16;
    let count = if is_even { TURN / 2 } else { TURN };
    let mut sums = [0.0; N];
    for &(y, weight) in rule.rule() {
        for i in 0..count {
            let values = f(DVec2::new((f64::from(i) + 0.5) / f64::from(TURN), y));
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * weight / f64::from(count));
        }
    }
    sums
}

fn reflected_once(alpha_x: f64, alpha_y: f64, wo: DVec3) -> f64 {
    let distribution = MicrofacetDistribution::new(alpha_x, alpha_y);
    let [reflected] = over_samples(alpha_x == alpha_y && wo.y == 0.0, &RULE, |xi| {
        let wi = distribution.sample_reflection(wo, xi);
        let m = (wo + wi).normalize();
        [if wi.z <= 0.0 {
            0.0
        } else {
            distribution.reflection(wo, wi, m) / distribution.reflection_pdf(wo, m).0
        }]
    });
    reflected.min(1.0)
}

/// Reflected and, if `transmits`, transmitted fraction.
fn scattered_once(alpha: f64, eta: f64, wo: DVec3, transmits: bool) -> [f64; 2] {
    // From the denser side total reflection begins at some facets, where the integrand jumps.
    static LEAVING: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(80));
    let rule = if eta < 1.0 { &LEAVING } else { &RULE };
    let distribution = MicrofacetDistribution::new(alpha, alpha);
    let visible = 1.0 + distribution.lambda(wo);
    over_samples(true, rule, |xi| {
        let m = distribution.sample_visible(wo, xi);
        let share = fresnel::dielectric(wo.dot(m), eta).reflectance;
        let seen =
            |wi: DVec3| if wi.z > 0.0 { distribution.masking_shadowing(wo, wi) * visible } else { 0.0 };
        let refracted = if transmits { fresnel::refract(wo, m, eta) } else { None };
        [share * seen(fresnel::reflect(wo, m)), refracted.map_or(0.0, |wi| (1.0 - share) * seen(-wi))]
    })
}

#[cfg(test)]
mod tests {
    use glanz_sampling::hash::{combine, unit_f64};

    use super::*;

    fn number(i: u64, dimension: u64) -> f64 {
        unit_f64(combine(dimension, i))
    }

    #[test]
    fn tables_agree_with_quadrature_between_their_nodes() {
        let mut worst = [0.0_f64; 4];
        for i in 0..300 {
            let [x, y, azimuth, cos] = [0, 1, 2, 3].map(|dimension| number(i, dimension));
            // Rarely needed and less exact below.
            let cos = 0.05 + 0.95 * cos;
            let wo = direction(cos, azimuth * FRAC_PI_2);
            for (k, y, wo) in [(0, x, direction(cos, 0.0)), (1, y, wo)] {
                let error = reflected(&MicrofacetDistribution::new(x, y), wo) - reflected_once(x, y, wo);
                worst[k] = worst[k].max(error.abs());
            }
            let eta = if i % 4 == 0 { 1.2 + 30.0 * number(i, 4) } else { 1.2 + number(i, 4) };
            let exact = |eta: f64| scattered_once(x, eta, direction(cos, 0.0), true);
            worst[2] = worst[2].max((interface_reflectance(x, eta, cos) - exact(eta)[0]).abs());
            for eta in [eta, 1.0 / eta] {
                let [reflected, transmitted] = exact(eta);
                let error = interface_loss(x, eta, cos) - (1.0 - reflected - transmitted);
                worst[3] = worst[3].max(error.abs());
            }
        }
        assert!(worst[0] < 0.005 && worst[1] < 0.03 && worst[2] < 0.02 && worst[3] < 0.02, "{worst:?}");
    }

    #[test]
    fn tables_of_interfaces_hold_for_almost_equal_and_for_very_different_media() {
        let mut worst = [0.0_f64; 2];
        for i in 0..600 {
            // Small widths, at which grazing light changes fast, as often as large ones.
            let (alpha, cos) = (number(i, 5).powi(2).max(SMOOTH), 0.05 + 0.95 * number(i, 6).powi(2));
            let contrast = number(i, 7);
            let eta = if i % 2 == 0 { 1.0 + 0.2 * contrast } else { 1e3_f64.powf(contrast) };
            for eta in [eta, 1.0 / eta] {
                let [reflected, transmitted] = scattered_once(alpha, eta, direction(cos, 0.0), true);
                if eta >= 1.0 {
                    worst[0] = worst[0].max((interface_reflectance(alpha, eta, cos) - reflected).abs());
                }
                let error = interface_loss(alpha, eta, cos) - (1.0 - reflected - transmitted);
                worst[1] = worst[1].max(error.abs());
            }
        }
        assert!(worst.iter().all(|&error| error < 0.06), "{worst:?}");
    }
}
