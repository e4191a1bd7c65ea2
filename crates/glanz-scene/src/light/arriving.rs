//! What lights without extent send to a place.

use glanz_light::Spectrum;
use glanz_math::DVec3;

use super::Light;
use super::point::window;

/// What arrives from a light that is seen in one direction only.
#[derive(Clone, Copy, Debug)]
pub struct ArrivingLight {
    /// Unit direction to the light.
    pub towards: DVec3,
    /// W/m^2 on a surface that faces it.
    pub irradiance: Spectrum,
    /// How far away it is, metres; infinite for a distant light.
    pub distance: f64,
}

impl Light {
    /// What arrives at `point`, if nothing stands between, from a light that is seen from there in one direction.
    ///
    /// `None` from lights with an extent, and from a point that `point` itself is.
    #[must_use]
    pub fn arriving(&self, point: DVec3) -> Option<ArrivingLight> {
        let from_point = |position: DVec3| {
            let offset = position - point;
            let distance = offset.length();
            (distance > 0.0).then(|| (offset / distance, distance))
        };
        match self {
            Self::Point(light) => {
                let (towards, distance) = from_point(light.position())?;
                let scale = window(distance, light.range()) / (4.0 * std::f64::consts::PI) as f32;
                let irradiance = light.power() * scale * (1.0 / (distance * distance)) as f32;
                Some(ArrivingLight { towards, irradiance, distance })
            }
            Self::Spot(light) => {
                let (towards, distance) = from_point(light.position())?;
                let irradiance = light.intensity(-towards) * (1.0 / (distance * distance)) as f32;
                Some(ArrivingLight { towards, irradiance, distance })
            }
            Self::Photometric(light) if light.is_point() => {
                let (towards, distance) = from_point(light.center())?;
                let irradiance = light.intensity(-towards) * (1.0 / (distance * distance)) as f32;
                Some(ArrivingLight { towards, irradiance, distance })
            }
            Self::Distant(light) => {
                let (towards, irradiance) = (light.towards(), light.irradiance());
                Some(ArrivingLight { towards, irradiance, distance: f64::INFINITY })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::SpotFalloff;
    use crate::light::{DistantLight, PointLight, SpotLight};

    #[test]
    fn irradiance_falls_by_the_square_of_the_distance() {
        let at = DVec3::new(0.0, 0.0, 2.0);
        let lights = [
            Light::Point(PointLight::new(at, Spectrum::ONE * 8.0, None)),
            Light::Spot(SpotLight::new(at, -DVec3::Z, [0.5, 0.4], SpotFalloff::Quartic, Spectrum::ONE * 8.0)),
        ];
        for light in lights {
            let arriving = light.arriving(DVec3::ZERO).unwrap();
            let off = arriving.irradiance + Spectrum::ONE * -2.0;
            assert!(off.map(f32::abs).max_component() < 1e-6, "{arriving:?}");
            assert_eq!((arriving.towards, arriving.distance), (DVec3::Z, 2.0));
            assert!(light.arriving(at).is_none());
        }
    }

    #[test]
    fn distant_light_is_the_same_everywhere() {
        let light = Light::Distant(DistantLight::new(DVec3::X, Spectrum::ONE));
        let arriving = light.arriving(DVec3::splat(1e9)).unwrap();
        assert_eq!((arriving.towards, arriving.irradiance), (DVec3::X, Spectrum::ONE));
    }
}
