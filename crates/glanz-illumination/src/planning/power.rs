//! Electric power of an installation.

use glanz_report::FactList;

/// Electric power over a floor, and over it and the illuminance that it gives.
#[derive(Clone, Debug, PartialEq)]
pub struct InstalledPower {
    /// Watts of all luminaires.
    pub watts: f64,
    /// Floor area, m^2.
    pub area: f64,
    /// The receiver or zone that the illuminance refers to, and its maintained mean illuminance, lx.
    pub reference: Option<(String, f64)>,
}

impl InstalledPower {
    /// Power per area, W/m^2; `None` without power or area.
    #[must_use]
    pub fn density(&self) -> Option<f64> {
        (self.watts > 0.0 && self.area > 0.0).then(|| self.watts / self.area)
    }

    /// Power per area and 100 lx, W/m^2; `None` without power, area or light.
    #[must_use]
    pub fn density_per_100_lux(&self) -> Option<f64> {
        let (_, lux) = self.reference.as_ref().filter(|(_, lux)| *lux > 0.0)?;
        Some(100.0 * self.density()? / lux)
    }

    /// Adds the figures that are known.
    pub(crate) fn add_to(&self, facts: &mut FactList) {
        let Some(density) = self.density() else { return };
        facts.push("power, W", "power_w", self.watts);
        facts.push("power per area, W/m2", "power_density_w_m2", density);
        if let Some(density) = self.density_per_100_lux() {
            facts.push("power per area and 100 lx, W/m2", "power_density_w_m2_100lx", density);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_agree_with_the_calculation_by_hand() {
        // Four luminaires of 36 W in a room of 6 m x 4 m at 450 lx: 144 / 24 = 6 W/m2, 6 / 4.5 = 1.3333 per 100 lx.
        let power = InstalledPower { watts: 144.0, area: 24.0, reference: Some(("desk".into(), 450.0)) };
        assert_eq!(power.density(), Some(6.0));
        assert!((power.density_per_100_lux().unwrap() - 1.333_333).abs() < 1e-6);
        let dark = InstalledPower { reference: Some(("desk".into(), 0.0)), ..power.clone() };
        assert_eq!((dark.density(), dark.density_per_100_lux()), (Some(6.0), None));
        assert_eq!(InstalledPower { watts: 0.0, ..power.clone() }.density(), None);
        assert_eq!(InstalledPower { area: 0.0, ..power }.density_per_100_lux(), None);
    }
}
