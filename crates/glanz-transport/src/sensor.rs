//! The sensor: values of a picture from radiance.

use glanz_light::rgb::luminance;
use glanz_light::white_balance::white_balance;
use glanz_scene::description::{SampleLimit, SensorDescription};

/// Errors of sensors.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// An exposure that is negative or not finite.
    #[error("exposure is {0}; it must be positive")]
    Exposure(f64),
    /// A temperature out of range.
    #[error("temperature of white is {0} K; it must be between 1000 and 25000 K")]
    WhiteBalance(f64),
    /// A limit that is not positive.
    #[error("limit of samples is {0}; it must be positive")]
    Limit(f64),
}

/// A sensor, which multiplies samples by its exposure, adapts them to its white, and limits them; by default it changes no bit.
///
/// # Source
/// pbrt-v4, sensor `cie1931` (@pharr2023 section 5.4.2), but for its limit of components, which is that of CIE XYZ before the adaptation and here that of
/// the picture's red, green and blue; the limit of luminance is pbrt-v3's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSensor {
    /// Maps linear Rec. 709 radiance to that of the picture, row by row; `None` for the identity.
    matrix: Option<[[f64; 3]; 3]>,
    limit: SampleLimit,
}

impl Default for FilmSensor {
    fn default() -> Self {
        Self { matrix: None, limit: SampleLimit::None }
    }
}

impl FilmSensor {
    /// The sensor of `description`.
    ///
    /// # Errors
    /// [`SensorError`] for parameters out of range.
    pub fn try_new(description: &SensorDescription) -> Result<Self, SensorError> {
        let &SensorDescription { exposure, white_balance: kelvin, limit } = description;
        if !(exposure > 0.0 && exposure.is_finite()) {
            return Err(SensorError::Exposure(exposure));
        }
        if let SampleLimit::Component(limit) | SampleLimit::Luminance(limit) = limit
            && (limit.is_nan() || limit <= 0.0)
        {
            return Err(SensorError::Limit(limit));
        }
        let adaptation = match kelvin {
            Some(kelvin) => Some(white_balance(kelvin).ok_or(SensorError::WhiteBalance(kelvin))?),
            None if exposure == 1.0 => None,
            None => Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        };
        Ok(Self { matrix: adaptation.map(|rows| rows.map(|row| row.map(|x| exposure * x))), limit })
    }

    /// The value for a sample of this linear Rec. 709 radiance.
    #[inline]
    pub(crate) fn exposed(&self, radiance: [f32; 3]) -> [f32; 3] {
        match self {
            Self { matrix: None, limit: SampleLimit::None } => radiance,
            _ => self.changed(radiance),
        }
    }

    fn changed(&self, radiance: [f32; 3]) -> [f32; 3] {
        let mut rgb = radiance.map(f64::from);
        if let Some(rows) = &self.matrix {
            rgb = rows.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]);
        }
        let factor = match self.limit {
            SampleLimit::None => 1.0,
            // An infinite limit is none; the ratio would not be a number.
            SampleLimit::Component(limit) | SampleLimit::Luminance(limit) if limit.is_infinite() => 1.0,
            SampleLimit::Component(limit) => limit / rgb.into_iter().fold(limit, f64::max),
            SampleLimit::Luminance(limit) => limit / luminance(rgb).max(limit),
        };
        rgb.map(|x| (factor * x) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor(description: SensorDescription) -> FilmSensor {
        FilmSensor::try_new(&description).unwrap()
    }

    #[test]
    fn exposure_multiplies_and_the_default_changes_nothing() {
        let odd = [0.1, f32::MIN_POSITIVE, -3.3e20];
        assert_eq!(sensor(SensorDescription::default()).exposed(odd), odd);
        let bright = sensor(SensorDescription { exposure: 4.0, ..SensorDescription::default() });
        assert_eq!(bright.exposed([0.25, 1.0, -2.0]), [1.0, 4.0, -8.0]);
    }

    #[test]
    fn limits_apply_to_exposed_values_and_keep_the_hue() {
        let limit = SampleLimit::Component(8.0);
        let component = sensor(SensorDescription { exposure: 2.0, limit, ..SensorDescription::default() });
        assert_eq!(component.exposed([1.0, 4.0, 2.0]), [2.0, 8.0, 4.0]);
        assert_eq!(component.exposed([2.0, 16.0, 4.0]), [1.0, 8.0, 2.0]);
        let limit = SampleLimit::Luminance(0.5);
        let luminous = sensor(SensorDescription { limit, ..SensorDescription::default() });
        assert_eq!(luminous.exposed([3.0; 3]).map(|x| (x * 1e6).round()), [0.5e6; 3]);
        assert_eq!(luminous.exposed([0.3; 3]), [0.3; 3]);
        for limit in [SampleLimit::Component(f64::INFINITY), SampleLimit::Luminance(f64::INFINITY)] {
            let unlimited = sensor(SensorDescription { limit, ..SensorDescription::default() });
            assert_eq!(unlimited.exposed([3.0, 1.0, 0.5]), [3.0, 1.0, 0.5]);
        }
    }

    #[test]
    fn light_of_the_temperature_of_white_becomes_grey() {
        // Illuminant A, 2856 K: chromaticity (0.44758, 0.40745) of CIE 015:2018, here of luminance 1.
        let (x, y) = (0.447_58, 0.407_45);
        let lamp = glanz_light::rgb::xyz_to_rgb([x / y, 1.0, (1.0 - x - y) / y]).map(|x| x as f32);
        let kelvin = Some(2856.0 * 1.4380 / 1.4388);
        let adapted =
            sensor(SensorDescription { white_balance: kelvin, ..SensorDescription::default() }).exposed(lamp);
        for value in adapted {
            assert!((value - 1.0).abs() < 2e-3, "{adapted:?}");
        }
    }

    #[test]
    fn sensors_out_of_range_are_refused() {
        let error = |description| FilmSensor::try_new(&description).unwrap_err();
        let description = SensorDescription::default();
        assert_eq!(error(SensorDescription { exposure: 0.0, ..description }), SensorError::Exposure(0.0));
        let kelvin = Some(300.0);
        assert_eq!(
            error(SensorDescription { white_balance: kelvin, ..description }),
            SensorError::WhiteBalance(300.0)
        );
        let limit = SampleLimit::Luminance(-1.0);
        assert_eq!(error(SensorDescription { limit, ..description }), SensorError::Limit(-1.0));
    }
}
