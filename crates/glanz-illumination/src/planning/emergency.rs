//! Emergency lighting: open areas and disability glare. Escape routes are not rated.
//!
//! Illuminances are horizontal, on the floor, and of the direct light of the luminaires alone, since reflections do not count.
//!
//! # Source
//! EN 1838 (@en1838), which was not available: the limits are those of open summaries of the edition of 2013. Open areas: at least 0.5 lx
//! on the floor without a border of 0.5 m (4.3.1), and at most 40 times the least illuminance. On level routes, intensities at 60 to 90 degrees from straight down have limits by
//! the height of the luminaires above the floor.

use std::sync::Arc;

use glanz_light::intensity::AngularSystem;
use glanz_math::DVec3;

use super::luminaire::PlacedLuminaire;
use super::requirement::{LightingCriterion, Requirement, RequirementVerdict};

/// Width of the border of open areas that does not count, metres.
pub(super) const OPEN_AREA_BORDER: f64 = 0.5;

/// Least illuminance of an open area, lx.
const AREA_ILLUMINANCE: f64 = 0.5;

/// Largest over least illuminance.
const MAXIMUM_TO_MINIMUM: f64 = 40.0;

/// Angles from straight down within which intensities are limited on level routes, degrees.
const GLARE_ZONE: [f64; 2] = [60.0, 90.0];

/// Upper ends of mounting heights, metres, with the largest intensity in candela on escape routes and in open areas; twice that for areas of high risk.
const GLARE_LIMITS: [(f64, f64); 6] =
    [(2.5, 500.0), (3.0, 900.0), (3.5, 1600.0), (4.0, 2500.0), (4.5, 3500.0), (f64::INFINITY, 5000.0)];

/// Largest intensity, candela, in the zone of disability glare, of a luminaire at this height above the floor, metres.
#[must_use]
pub fn intensity_limit(height: f64) -> f64 {
    GLARE_LIMITS.iter().find(|(end, _)| height < *end).map_or(5000.0, |(_, candela)| *candela)
}

/// Illuminance of a horizontal plane at a point, lx, by the direct light of luminaires with nothing in its way.
#[must_use]
pub fn direct_horizontal(luminaires: &[PlacedLuminaire], point: DVec3) -> f64 {
    let of_luminaire = |luminaire: &PlacedLuminaire| {
        let offset = luminaire.position - point;
        luminaire.intensity_towards(point) * offset.z.max(0.0) / offset.length().powi(3)
    };
    let lux = luminaires.iter().map(of_luminaire).filter(|lux| lux.is_finite());
    lux.sum()
}

/// Verdicts on the illuminance at points of an open area; none without points. `maintenance`: the factor at the end of the rated duration.
#[must_use]
pub fn open_area_verdicts(
    name: &str,
    luminaires: &[PlacedLuminaire],
    points: &[DVec3],
    maintenance: f64,
) -> Vec<RequirementVerdict> {
    let lux = points.iter().map(|point| maintenance * direct_horizontal(luminaires, *point));
    let (least, most) = lux.fold((f64::INFINITY, 0.0_f64), |(low, high), lux| (low.min(lux), high.max(lux)));
    if points.is_empty() {
        return Vec::new();
    }
    let verdict = |criterion, limit, value| {
        let requirement = Requirement { criterion, limit, source: "EN 1838:2013, 4.3 open area".to_owned() };
        RequirementVerdict::new(name, requirement, value, [value; 2])
    };
    let ratio = if least > 0.0 { most / least } else { f64::INFINITY };
    vec![
        verdict(LightingCriterion::LeastIlluminance, AREA_ILLUMINANCE, least),
        verdict(LightingCriterion::MaximumToMinimum, MAXIMUM_TO_MINIMUM, ratio),
    ]
}

/// Verdicts on the disability glare of luminaires over a level floor at the height `floor`, metres: one for each mounting height, on the largest intensity in the zone.
#[must_use]
pub fn disability_glare_verdicts(luminaires: &[PlacedLuminaire], floor: f64) -> Vec<RequirementVerdict> {
    let mut verdicts: Vec<RequirementVerdict> = Vec::new();
    let mut seen: Vec<&PlacedLuminaire> = Vec::new();
    for luminaire in luminaires {
        // Rooms have many luminaires that differ by their places alone.
        let is_equal = |other: &&PlacedLuminaire| {
            Arc::ptr_eq(&other.distribution, &luminaire.distribution)
                && (other.factor, other.axes, other.position.z)
                    == (luminaire.factor, luminaire.axes, luminaire.position.z)
                && other.name == luminaire.name
        };
        if seen.iter().any(is_equal) {
            continue;
        }
        seen.push(luminaire);
        // In centimetres: luminaires flush with a ceiling are modelled just below it.
        let height = (100.0 * (luminaire.position.z - floor)).round() / 100.0;
        let value = largest_in_zone(luminaire);
        let source = "EN 1838:2013, table 1".to_owned();
        let requirement =
            Requirement { criterion: LightingCriterion::Intensity, limit: intensity_limit(height), source };
        let zone = format!("{} at {height:.2} m", luminaire.name);
        let verdict = RequirementVerdict::new(zone, requirement, value, [value; 2]);
        match verdicts.iter_mut().find(|other| other.zone == verdict.zone) {
            Some(other) if other.value < value => *other = verdict,
            Some(_) => {}
            None => verdicts.push(verdict),
        }
    }
    verdicts
}

/// The largest intensity in the zone at whole degrees and at the points of the distribution's own grid, between which it is interpolated, candela.
fn largest_in_zone(luminaire: &PlacedLuminaire) -> f64 {
    let [low, high] = GLARE_ZONE;
    let whole = (low as u32..=high as u32).flat_map(|gamma| (0..360).map(move |azimuth| (azimuth, gamma)));
    let whole =
        whole.map(|(azimuth, gamma)| AngularSystem::C.direction(f64::from(azimuth), f64::from(gamma)));
    let PlacedLuminaire { distribution, axes, .. } = luminaire;
    let (azimuths, polars) = (distribution.azimuths(), distribution.polars());
    let own = azimuths.iter().flat_map(|&azimuth| polars.iter().map(move |&polar| (azimuth, polar)));
    let own = own.map(|(azimuth, polar)| *axes * distribution.direction(azimuth, polar));
    let in_zone = |towards: &DVec3| {
        let gamma = towards.angle_between(DVec3::NEG_Z).to_degrees();
        (low - 1e-6..=high + 1e-6).contains(&gamma)
    };
    let intensities = whole
        .chain(own.filter(in_zone))
        .map(|towards| luminaire.factor * distribution.intensity(axes.transpose() * towards));
    intensities.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::requirement::VerdictOutcome;
    use crate::planning::test_luminaires::{downlight, of_gamma, uniform};
    use glanz_light::intensity::{IntensityDistribution, Symmetry};
    use glanz_math::DMat3;

    #[test]
    fn line_between_two_luminaires_agrees_with_the_calculation_by_hand() {
        // Two lamps of 20 cd, 3 m high and 8 m apart; middle: 2 * 20 * 3 / (16 + 9)^1.5 = 0.96 lx; below one: 20 / 9 + 20 * 3 / 73^1.5 = 2.3184 lx.
        let lamps = [0.0, 8.0].map(|x| downlight(uniform(20.0), DVec3::new(x, 0.0, 3.0)));
        let line: Vec<DVec3> = (0..=16).map(|i| DVec3::new(0.5 * f64::from(i), 0.0, 0.0)).collect();
        let [least, ratio] = open_area_verdicts("hall", &lamps, &line, 0.5).try_into().unwrap();
        assert!((least.value - 0.48).abs() < 1e-12 && least.outcome == VerdictOutcome::NotMet);
        assert!((ratio.value - 2.318_4 / 0.96).abs() < 1e-4, "{ratio:?}");
        assert_eq!(ratio.outcome, VerdictOutcome::Met);
        let area = open_area_verdicts("hall", &lamps, &line, 0.8);
        assert!((area[0].value - 0.768).abs() < 1e-12 && area[0].outcome == VerdictOutcome::Met);
        assert!(open_area_verdicts("hall", &lamps, &[], 1.0).is_empty());
        let dark = open_area_verdicts("hall", &[], &line, 1.0);
        assert!(dark.iter().all(|verdict| verdict.outcome == VerdictOutcome::NotMet));
    }

    #[test]
    fn limits_of_intensity_rise_with_the_height() {
        let limits = [2.0, 2.5, 2.99, 3.0, 3.5, 4.0, 4.5, 20.0].map(intensity_limit);
        assert_eq!(limits, [500.0, 900.0, 900.0, 1600.0, 2500.0, 3500.0, 5000.0, 5000.0]);
        // 2000 cd down to 59.5 degrees, and 700 cd at 62.3 degrees.
        let distribution = of_gamma(
            vec![0.0, 59.4, 59.5, 62.2, 62.3, 62.4, 90.0],
            vec![2000.0, 2000.0, 10.0, 10.0, 700.0, 10.0, 0.0],
        );
        let lamps = [2.4, 2.4, 2.8].map(|z| downlight(distribution.clone(), DVec3::new(0.0, 0.0, z)));
        let verdicts = disability_glare_verdicts(&lamps, 0.0);
        let outcomes: Vec<_> =
            verdicts.iter().map(|verdict| (verdict.requirement.limit, verdict.outcome)).collect();
        assert_eq!(outcomes, [(500.0, VerdictOutcome::NotMet), (900.0, VerdictOutcome::Met)]);
        assert!((verdicts[0].value - 700.0).abs() < 1e-6, "{verdicts:?}");
        // A needle between whole degrees of C, also if the luminaire is turned.
        let planes = [0.0, 10.2, 10.3, 10.4, 360.0];
        let candela: Vec<f64> =
            planes.iter().flat_map(|plane| [0.0, if *plane == 10.3 { 600.0 } else { 0.0 }, 0.0]).collect();
        let gammas = vec![0.0, 62.5, 90.0];
        let needle =
            IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, &planes, gammas, candela)
                .unwrap();
        let lamp = PlacedLuminaire {
            axes: DMat3::from_rotation_z(0.123),
            ..downlight(Arc::new(needle), DVec3::new(0.0, 0.0, 2.4))
        };
        assert!((disability_glare_verdicts(&[lamp], 0.0)[0].value - 600.0).abs() < 1e-6);
    }
}
