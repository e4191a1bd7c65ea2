//! Light that arrives from one direction.

use glanz_light::Spectrum;
use glanz_math::DVec3;

/// Irradiance from a light that is seen in one direction only.
#[derive(Clone, Copy, Debug)]
pub struct IncidentLight {
    /// Unit direction to the light.
    pub towards: DVec3,
    /// W/m^2 on a surface that faces it.
    pub irradiance: Spectrum,
    /// Its distance, metres; infinite for a distant light.
    pub distance: f64,
}

impl IncidentLight {
    /// Light that arrives at `point` from a light at `position` with `intensity(unit direction from the light, distance)`, W/sr.
    pub(super) fn from_position(
        position: DVec3,
        point: DVec3,
        intensity: impl Fn(DVec3, f64) -> Spectrum,
    ) -> Option<Self> {
        let offset = position - point;
        let distance = offset.length();
        let towards = offset / distance;
        (distance > 0.0).then(|| Self {
            towards,
            irradiance: intensity(-towards, distance) * (1.0 / (distance * distance)) as f32,
            distance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::SpotFalloff;
    use crate::light::{DistantLight, Light, PointLight, SpotLight};

    #[test]
    fn irradiance_falls_by_the_square_of_the_distance() {
        let at = DVec3::new(0.0, 0.0, 2.0);
        let lights = [
            Light::Point(PointLight::new(at, Spectrum::ONE * 8.0, None)),
            Light::Spot(SpotLight::new(at, -DVec3::Z, [0.5, 0.4], SpotFalloff::Quartic, Spectrum::ONE * 8.0)),
        ];
        for light in lights {
            let incident = light.incident(DVec3::ZERO).unwrap();
            let off = incident.irradiance + Spectrum::ONE * -2.0;
            assert!(off.map(f32::abs).max_component() < 1e-6, "{incident:?}");
            assert_eq!((incident.towards, incident.distance), (DVec3::Z, 2.0));
            assert!(light.incident(at).is_none());
        }
    }

    #[test]
    fn distant_light_is_the_same_everywhere() {
        let light = Light::Distant(DistantLight::new(DVec3::X, Spectrum::ONE));
        let incident = light.incident(DVec3::splat(1e9)).unwrap();
        assert_eq!((incident.towards, incident.irradiance), (DVec3::X, Spectrum::ONE));
    }
}
