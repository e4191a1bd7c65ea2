//! Settings of photon maps.

use std::fmt;
use std::str::FromStr;

/// Photons of an integrator.
///
/// As text: keys with values, such as `radius=0.01,photons=100000`; both may be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonSettings {
    /// Radius of the first density estimate, metres, above 0; `None`: by the size of pixels in the scene.
    pub radius: Option<f64>,
    /// Number of photon paths in each pass over the pixels, at least 1; `None`: the number of pixels, within bounds.
    pub count: Option<u32>,
}

impl fmt::Display for PhotonSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let radius = self.radius.map(|radius| format!("radius={radius}"));
        let count = self.count.map(|count| format!("photons={count}"));
        let items: Vec<_> = radius.into_iter().chain(count).collect();
        f.write_str(&items.join(","))
    }
}

/// A text that is not one of [`PhotonSettings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not settings of photons; use keys with values such as radius=0.01,photons=100000")]
pub struct PhotonSettingsError;

impl FromStr for PhotonSettings {
    type Err = PhotonSettingsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut settings = Self::default();
        if text.is_empty() {
            return Ok(settings);
        }
        for item in text.split(',') {
            match item.split_once('=') {
                Some(("radius", value)) if settings.radius.is_none() => {
                    settings.radius = Some(value.parse().map_err(|_| PhotonSettingsError)?);
                }
                Some(("photons", value)) if settings.count.is_none() => {
                    settings.count = Some(value.parse().map_err(|_| PhotonSettingsError)?);
                }
                _ => return Err(PhotonSettingsError),
            }
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_settings_is_read_back() {
        for radius in [None, Some(0.1_f64.cbrt())] {
            for count in [None, Some(7)] {
                let settings = PhotonSettings { radius, count };
                assert_eq!(settings.to_string().parse(), Ok(settings));
            }
        }
        for text in [
            "radius",
            "radius=x",
            "photons=0.5",
            "depth=3",
            "radius=1,radius=2",
            "photons=1,photons=1",
            ",",
            "radius=1,",
        ] {
            assert_eq!(text.parse::<PhotonSettings>(), Err(PhotonSettingsError), "{text}");
        }
    }
}
