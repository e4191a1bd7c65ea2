//! The clear sky and the sun behind it.
//!
//! The sky's radiance is the model of @hosek2012, fitted to simulated light in the atmosphere; the sun's irradiance at the ground that of
//! @preetham1999, appendix A.1, without the absorption by water vapour and mixed gases, which begins at 690 nm, where the eye sees little.

use std::f64::consts::FRAC_PI_2;

use glanz_math::DVec3;
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};

use crate::cie;
use crate::distribution::{SpectralDistribution, SpectrumError, blackbody, blackbody_peak_nm};
use crate::units::LUMINOUS_EFFICACY;

/// Turbidities of the model: 1 is pure air, 2 to 3 a clear sky, 6 haze.
pub const TURBIDITIES: std::ops::RangeInclusive<f64> = 1.0..=10.0;

/// Mean angular radius of the sun, radians.
pub const SUN_RADIUS: f64 = 0.004_652_4;

/// Illuminance of the sun outside the atmosphere at its mean distance, lx (@darula2005).
const LUMINOUS_SOLAR_CONSTANT: f64 = 133_334.0;

/// Effective temperature of the sun, K (@prsa2016).
const SUN_TEMPERATURE: f32 = 5772.0;

/// Ozone in a vertical column, cm at normal pressure (@preetham1999).
const OZONE: f64 = 0.35;

/// Absorption by ozone, 1/cm, from 440 nm in steps of 20 nm (@leckner1978); none beyond the table.
const OZONE_ABSORPTION: [f64; 18] = [
    0.0, 0.006, 0.014, 0.030, 0.048, 0.075, 0.103, 0.120, 0.125, 0.105, 0.079, 0.057, 0.036, 0.023, 0.014,
    0.010, 0.007, 0.0,
];

/// Errors of making a sky.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkyError {
    /// The sun is below the horizon, where the model ends.
    #[error("the sun is {0:.2} degrees below the horizon; the model of the sky needs it above")]
    BelowHorizon(f64),
    /// The turbidity is outside [`TURBIDITIES`].
    #[error("the turbidity is {0}; it must be from 1 to 10")]
    Turbidity(f64),
    /// A component of the albedo is outside [0, 1].
    #[error("the albedo of the ground is {0}; it must be from 0 to 1")]
    Albedo(f32),
    /// The spectrum of the sun is invalid; not for arguments that are in range.
    #[error(transparent)]
    Sun(#[from] SpectrumError),
}

/// A clear sky; z is up.
#[derive(Clone, Debug)]
pub struct ClearSky {
    state: SkyState,
    towards_sun: DVec3,
    sun: SpectralDistribution,
}

impl ClearSky {
    /// `towards_sun`: unit direction, not below the horizon; `turbidity`: in [`TURBIDITIES`]; `albedo`: of the ground, linear Rec. 709, in [0, 1].
    ///
    /// # Errors
    /// [`SkyError`] for the first argument out of range.
    pub fn try_new(towards_sun: DVec3, turbidity: f64, albedo: [f32; 3]) -> Result<Self, SkyError> {
        let elevation = towards_sun.z.clamp(-1.0, 1.0).asin();
        if elevation.is_nan() || elevation < 0.0 {
            return Err(SkyError::BelowHorizon(-elevation.to_degrees()));
        }
        if !TURBIDITIES.contains(&turbidity) {
            return Err(SkyError::Turbidity(turbidity));
        }
        if let Some(&outside) = albedo.iter().find(|x| !(0.0..=1.0).contains(*x)) {
            return Err(SkyError::Albedo(outside));
        }
        let parameters = SkyParams {
            elevation: (elevation as f32).min(FRAC_PI_2 as f32),
            turbidity: turbidity as f32,
            albedo,
        };
        // All that the model checks was checked above.
        let state = SkyState::new(&parameters).map_err(|_| SkyError::BelowHorizon(0.0))?;
        let sun = sun_irradiance(elevation, turbidity)?;
        Ok(Self { state, towards_sun, sun })
    }

    /// W/(m^2 sr) from a unit direction, linear Rec. 709; no light from below the horizon, nor from the sun itself.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f32; 3] {
        if direction.z < 0.0 {
            return [0.0; 3];
        }
        let theta = direction.z.min(1.0).acos() as f32;
        let gamma = 2.0 * (0.5 * direction.distance(self.towards_sun)).min(1.0).asin();
        [Channel::R, Channel::G, Channel::B]
            .map(|channel| self.state.radiance(theta, gamma as f32, channel).max(0.0))
    }

    /// W/m^2 of the sun on a surface that faces it.
    #[must_use]
    pub fn sun_irradiance(&self) -> &SpectralDistribution {
        &self.sun
    }
}

/// W/m^2 on a surface that faces the sun, at an elevation in radians.
fn sun_irradiance(elevation: f64, turbidity: f64) -> Result<SpectralDistribution, SpectrumError> {
    let mass = relative_air_mass(elevation);
    let luminance = SpectralDistribution::try_blackbody(SUN_TEMPERATURE, 1.0)?.luminance();
    let scale = LUMINOUS_SOLAR_CONSTANT / LUMINOUS_EFFICACY / f64::from(luminance);
    let peak = blackbody_peak_nm(SUN_TEMPERATURE);
    let arriving = |nm| scale * blackbody(nm, SUN_TEMPERATURE, peak) * transmittance(nm, turbidity, mass);
    let points = (0..cie::COUNT).map(|i| cie::FIRST_NM + cie::STEP_NM * i as f64);
    SpectralDistribution::try_sampled(points.map(|nm| (nm as f32, arriving(nm) as f32)).collect::<Vec<_>>())
}

/// The fraction of sunlight at `nm` that crosses a relative air mass.
fn transmittance(nm: f64, turbidity: f64, mass: f64) -> f64 {
    let micrometres = 1e-3 * nm;
    let molecules = 0.008_735 * micrometres.powf(-4.08);
    let aerosol = (0.046_08 * turbidity - 0.045_86) * micrometres.powf(-1.3);
    (-mass * (molecules + aerosol + OZONE * ozone_absorption(nm))).exp()
}

/// 1/cm, linear between the entries of the table.
fn ozone_absorption(nm: f64) -> f64 {
    let at = ((nm - 440.0) / 20.0).clamp(0.0, (OZONE_ABSORPTION.len() - 1) as f64);
    let [low, high] =
        [at.floor(), at.ceil()].map(|i| OZONE_ABSORPTION.get(i as usize).copied().unwrap_or(0.0));
    low + (at - at.floor()) * (high - low)
}

/// The air that light from this elevation, radians, crosses, over that from the zenith (@kasten1965).
fn relative_air_mass(elevation: f64) -> f64 {
    1.0 / (elevation.sin() + 0.15 * (3.885 + elevation.to_degrees()).powf(-1.253))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Wavelengths;
    use crate::units::photometric;

    fn towards(elevation: f64) -> DVec3 {
        let (sin, cos) = elevation.to_radians().sin_cos();
        DVec3::new(0.0, cos, sin)
    }

    fn sky(elevation: f64, turbidity: f64) -> ClearSky {
        ClearSky::try_new(towards(elevation), turbidity, [0.2; 3]).unwrap()
    }

    fn luminance(rgb: [f32; 3]) -> f64 {
        LUMINOUS_EFFICACY * crate::rgb::luminance(rgb.map(f64::from))
    }

    /// Illuminance of the sky alone on the ground, lx.
    fn diffuse_illuminance(sky: &ClearSky) -> f64 {
        let (rings, sectors) = (200, 200);
        let mut sum = 0.0;
        for ring in 0..rings {
            // Equal steps of sin^2 are equal steps of cosine times solid angle.
            let sin = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            for sector in 0..sectors {
                let (y, x) =
                    (std::f64::consts::TAU * (f64::from(sector) + 0.5) / f64::from(sectors)).sin_cos();
                sum += luminance(sky.radiance(DVec3::new(sin * x, sin * y, (1.0 - sin * sin).sqrt())));
            }
        }
        std::f64::consts::PI * sum / f64::from(rings * sectors)
    }

    #[test]
    fn illuminances_are_those_of_the_recommended_practice_for_a_clear_sky() {
        // @ies1984: 127.5 klx exp(-0.21 m) from the sun, 0.8 klx + 15.5 klx sin^(1/2) of the elevation from the sky.
        for elevation in [15.0, 30.0, 45.0, 60.0] {
            let (sky, sin) = (sky(elevation, 2.0), f64::to_radians(elevation).sin());
            let sun = sky.sun_irradiance().radiance(&Wavelengths::Rgb);
            let sun = photometric(sun, &Wavelengths::Rgb) / (127_500.0 * (-0.21 / sin).exp());
            let diffuse = diffuse_illuminance(&sky) / (800.0 + 15_500.0 * sin.sqrt());
            assert!(
                (sun - 1.0).abs() < 0.04,
                "sun at {elevation} degrees: {sun} of the expected illuminance"
            );
            // The two models differ by up to 17 %.
            assert!((0.93..1.17).contains(&diffuse), "sky at {elevation} degrees: {diffuse}");
        }
    }

    #[test]
    fn sky_is_brightest_around_the_sun_and_blue_away_from_it() {
        let sky = sky(30.0, 3.0);
        let (near, away) = (sky.radiance(towards(33.0)), sky.radiance(towards(120.0)));
        assert!(luminance(near) > 5.0 * luminance(away), "{near:?} {away:?}");
        assert!(away[2] > 2.0 * away[0], "{away:?}");
        assert_eq!(sky.radiance(towards(-1.0)), [0.0; 3]);
    }

    #[test]
    fn low_sun_is_red_and_haze_dims_it() {
        let of = |elevation, turbidity| {
            sky(elevation, turbidity).sun_irradiance().radiance(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb)
        };
        let ([low_red, _, low_blue], [red, _, blue]) = (of(5.0, 3.0), of(60.0, 3.0));
        assert!(low_red / low_blue > 10.0 * red / blue);
        assert!(of(60.0, 8.0).iter().zip(of(60.0, 2.0)).all(|(hazy, clear)| *hazy < 0.9 * clear));
    }

    #[test]
    fn air_mass_is_one_at_the_zenith_and_36_at_the_horizon() {
        assert!((relative_air_mass(FRAC_PI_2) - 1.0).abs() < 1e-3);
        assert!((relative_air_mass(f64::to_radians(30.0)) - 2.0).abs() < 0.02);
        assert!((relative_air_mass(0.0) - 36.5).abs() < 0.5);
    }

    #[test]
    fn arguments_outside_of_the_model_are_refused() {
        let refused =
            |elevation, turbidity, albedo| ClearSky::try_new(towards(elevation), turbidity, albedo).err();
        assert!(
            matches!(refused(-2.0, 3.0, [0.2; 3]), Some(SkyError::BelowHorizon(below)) if (below - 2.0).abs() < 1e-9)
        );
        assert_eq!(refused(20.0, 0.9, [0.2; 3]), Some(SkyError::Turbidity(0.9)));
        assert!(matches!(refused(20.0, f64::NAN, [0.2; 3]), Some(SkyError::Turbidity(_))));
        assert_eq!(refused(20.0, 3.0, [0.2, 1.5, 0.2]), Some(SkyError::Albedo(1.5)));
        assert!(ClearSky::try_new(DVec3::NAN, 3.0, [0.2; 3]).is_err());
        assert!(
            ClearSky::try_new(DVec3::Z, 10.0, [1.0; 3]).is_ok()
                && ClearSky::try_new(DVec3::Y, 1.0, [0.0; 3]).is_ok()
        );
    }
}
