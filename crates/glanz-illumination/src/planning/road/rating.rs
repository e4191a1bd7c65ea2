//! Luminance and illuminance of a road.

use glanz_math::{DVec2, DVec3};
use glanz_report::{FactList, Table, TableCell};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::class::RoadClass;
use super::layout::{RoadError, RoadLayout, illuminance_lines, middles};
use super::r_table::RoadSurface;
use super::threshold_increment::{OBSERVER_AGE, ThresholdIncrement, threshold_increment, veiling_luminance};
use crate::planning::luminaire::PlacedLuminaire;
use crate::planning::maintenance::{MaintenanceError, MaintenanceFactor};
use crate::planning::requirement::{
    LightingCriterion, Requirement, RequirementVerdict, installation_table, verdict_table,
};

/// Height of the observer's eye, metres.
const EYE: f64 = 1.5;

/// Distance of the observer of luminances before the field, metres.
const DISTANCE: f64 = 60.0;

/// Largest distance ahead of luminaires that glare, metres.
const GLARE_DISTANCE: f64 = 500.0;

/// Tangent of the angle of the plane above which the roof of the car hides luminaires, 20 degrees.
const ROOF: f64 = 0.363_970_234_266_202_4;

/// Luminaires within this many heights light a point; the largest tan epsilon of r-tables is 12.
const ILLUMINANCE_HEIGHTS: f64 = 5.0;
const LUMINANCE_HEIGHTS: f64 = 12.0;

/// Luminance as the observer in one lane sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoadLuminance {
    /// Position of the observer across the road, metres.
    pub y: f64,
    /// Maintained mean over the field, cd/m^2.
    pub mean: f64,
    /// Overall uniformity: least over mean.
    pub overall: f64,
    /// Longitudinal uniformity: least over largest along the middle of the observer's lane.
    pub longitudinal: f64,
    /// Glare of the new installation.
    pub increment: ThresholdIncrement,
}

/// The rating of a road.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadReport {
    /// Observers from right to left; none without a road surface.
    pub luminance: Vec<RoadLuminance>,
    /// Maintained mean illuminance of the carriageway, lx.
    pub mean_illuminance: f64,
    /// Its least value, lx.
    pub least_illuminance: f64,
    /// Edge illuminance ratio.
    pub edge_ratio: f64,
    /// Verdicts on the requirements of a class.
    pub verdicts: Vec<RequirementVerdict>,
    /// What is assumed.
    pub assumptions: FactList,
}

/// Errors of rating a road.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RoadRatingError {
    /// A length out of range.
    #[error(transparent)]
    Layout(#[from] RoadError),
    /// A maintenance factor out of range.
    #[error(transparent)]
    Maintenance(#[from] MaintenanceError),
    /// A class of luminance without a road surface.
    #[error("class {0} limits luminances, which need the r-table of a road surface")]
    Surface(RoadClass),
}

impl RoadLayout {
    /// Rates the road. `surface`: `None` leaves luminances and glare out.
    ///
    /// # Errors
    /// [`RoadRatingError`].
    pub fn rate(
        &self,
        surface: Option<&RoadSurface>,
        maintenance: &MaintenanceFactor,
        class: Option<RoadClass>,
    ) -> Result<RoadReport, RoadRatingError> {
        self.check()?;
        let factor = maintenance.value()?;
        if let Some(class @ RoadClass::M(_)) = class
            && surface.is_none()
        {
            return Err(RoadRatingError::Surface(class));
        }
        let reach = self.spacing + LUMINANCE_HEIGHTS * self.height;
        let luminaires = self.luminaires(-reach, self.spacing + reach);
        let lanes = middles(0.0, self.width(), self.lanes);
        let observers = |surface: &RoadSurface| {
            lanes.iter().map(|&y| self.luminance(surface, &luminaires, y, factor)).collect()
        };
        let carriageway = self.illuminances(&luminaires, 0.0, self.width());
        let least = carriageway.iter().copied().fold(f64::INFINITY, f64::min);
        let mut report = RoadReport {
            luminance: surface.map(observers).unwrap_or_default(),
            mean_illuminance: factor * mean(&carriageway),
            least_illuminance: factor * least,
            edge_ratio: self.edge_ratio(&luminaires),
            verdicts: Vec::new(),
            assumptions: self.assumptions(surface, factor, class),
        };
        if let Some(class) = class {
            report.verdicts = report.verdicts(class);
        }
        Ok(report)
    }

    /// Luminance for the observer at `y`.
    fn luminance(
        &self,
        surface: &RoadSurface,
        luminaires: &[PlacedLuminaire],
        y: f64,
        factor: f64,
    ) -> RoadLuminance {
        let eye = DVec2::new(-DISTANCE, y);
        let at = |point: DVec2| -> f64 {
            let ahead = point - eye;
            let of_luminaire = |luminaire: &PlacedLuminaire| {
                let foot = luminaire.position.truncate() - point;
                let beta = if foot == DVec2::ZERO { 0.0 } else { ahead.angle_to(foot).to_degrees() };
                let coefficient = surface.coefficient(beta, foot.length() / self.height);
                if coefficient == 0.0 {
                    return 0.0;
                }
                coefficient * luminaire.intensity_towards(point.extend(0.0)) / self.height.powi(2)
            };
            factor * luminaires.iter().map(of_luminaire).sum::<f64>()
        };
        let stations = self.stations();
        let lines = middles(0.0, self.width(), 3 * self.lanes);
        let field: Vec<f64> =
            lines.iter().flat_map(|&y| stations.iter().map(move |&x| DVec2::new(x, y))).map(at).collect();
        let own: Vec<f64> = stations.iter().map(|&x| at(DVec2::new(x, y))).collect();
        let (low, high) = extremes(&own);
        let average = mean(&field);
        RoadLuminance {
            y,
            mean: average,
            overall: ratio(extremes(&field).0, average),
            longitudinal: ratio(low, high),
            increment: self.increment(y, average / factor),
        }
    }

    /// Threshold increment of the observer at `y` on a new road of this mean luminance.
    fn increment(&self, y: f64, mean: f64) -> ThresholdIncrement {
        let start = -2.75 * (self.height - EYE);
        let (sin, cos) = 1.0_f64.to_radians().sin_cos();
        let mut worst = ThresholdIncrement { station: start, ..ThresholdIncrement::default() };
        for (number, _) in self.stations().iter().enumerate() {
            let station = start + number as f64 * self.spacing / self.stations().len() as f64;
            let eye = DVec3::new(station, y, EYE);
            let is_seen = |luminaire: &PlacedLuminaire| {
                let ahead = luminaire.position.x - station;
                // The first luminaire is in the plane of the roof at the start, but for rounding.
                ahead > 0.0 && self.height - EYE <= ROOF * ahead * (1.0 + 1e-3)
            };
            let ahead: Vec<PlacedLuminaire> =
                self.luminaires(station, station + GLARE_DISTANCE).into_iter().filter(is_seen).collect();
            let veiling = veiling_luminance(&ahead, eye, DVec3::new(cos, 0.0, -sin), OBSERVER_AGE);
            let percent = threshold_increment(veiling, mean);
            if percent > worst.percent {
                worst = ThresholdIncrement { percent, veiling_luminance: veiling, station };
            }
        }
        worst
    }

    /// Illuminances of the new installation on a strip from `start` across, lx.
    fn illuminances(&self, luminaires: &[PlacedLuminaire], start: f64, width: f64) -> Vec<f64> {
        let lux = |point: DVec3| -> f64 {
            let of_luminaire = |luminaire: &PlacedLuminaire| {
                let offset = luminaire.position - point;
                if offset.truncate().length() > ILLUMINANCE_HEIGHTS * self.height {
                    return 0.0;
                }
                luminaire.intensity_towards(point) * offset.z / offset.length().powi(3)
            };
            luminaires.iter().map(of_luminaire).sum()
        };
        let stations = self.stations();
        let lines = illuminance_lines(start, width);
        lines.iter().flat_map(|&y| stations.iter().map(move |&x| DVec3::new(x, y, 0.0))).map(lux).collect()
    }

    fn edge_ratio(&self, luminaires: &[PlacedLuminaire]) -> f64 {
        let strip = self.lane_width;
        let of = |start: f64| mean(&self.illuminances(luminaires, start, strip));
        let width = self.width();
        let right = ratio(of(-strip), of(0.0));
        let left = ratio(of(width), of(width - strip));
        right.min(left)
    }

    /// The road in words.
    fn assumptions(&self, surface: Option<&RoadSurface>, factor: f64, class: Option<RoadClass>) -> FactList {
        let mut facts = FactList::default();
        let luminaire = &self.luminaire.description;
        facts.push("luminaire", "luminaire", luminaire.label());
        if !luminaire.maker.is_empty() {
            facts.push("its maker", "maker", luminaire.maker.clone());
        }
        facts.push("flux of one luminaire, lm", "luminaire_flux_lm", self.luminaire.distribution.flux());
        facts.push("lanes", "lanes", u64::from(self.lanes));
        facts.push("width of a lane, m", "lane_width_m", self.lane_width);
        facts.push("rows of luminaires", "rows", self.rows.len() as u64);
        facts.push("spacing, m", "spacing_m", self.spacing);
        facts.push("height, m", "height_m", self.height);
        facts.push("tilt, degrees", "tilt_degrees", self.tilt.to_degrees());
        facts.push("points along the field", "stations", self.stations().len() as u64);
        if luminaire.watts > 0.0 {
            let density = luminaire.watts * self.rows.len() as f64 / (self.spacing * self.width());
            facts.push("power per area of the carriageway, W/m2", "power_density_w_m2", density);
        }
        if let Some(surface) = surface {
            facts.push("road surface: Q0", "q0", surface.average_coefficient());
            if let Some(specular) = surface.specular_factor() {
                facts.push("road surface: S1", "s1", specular);
            }
        }
        facts.push("maintenance factor", "maintenance_factor", factor);
        if let Some(class) = class {
            facts.push("class", "class", class.to_string());
        }
        facts
    }
}

impl RoadReport {
    /// The worst value over the observers, or of the carriageway; `None` if it was not computed.
    #[must_use]
    pub fn value(&self, criterion: LightingCriterion) -> Option<f64> {
        let least = |value: fn(&RoadLuminance) -> f64| self.luminance.iter().map(value).reduce(f64::min);
        match criterion {
            LightingCriterion::MeanLuminance => least(|observer| observer.mean),
            LightingCriterion::OverallUniformity => least(|observer| observer.overall),
            LightingCriterion::LongitudinalUniformity => least(|observer| observer.longitudinal),
            LightingCriterion::ThresholdIncrement => {
                self.luminance.iter().map(|observer| observer.increment.percent).reduce(f64::max)
            }
            LightingCriterion::EdgeIlluminanceRatio => Some(self.edge_ratio),
            LightingCriterion::MeanIlluminance | LightingCriterion::LargestMeanIlluminance => {
                Some(self.mean_illuminance)
            }
            LightingCriterion::LeastIlluminance => Some(self.least_illuminance),
            LightingCriterion::Uniformity => Some(ratio(self.least_illuminance, self.mean_illuminance)),
            _ => None,
        }
    }

    fn verdicts(&self, class: RoadClass) -> Vec<RequirementVerdict> {
        let verdict = |requirement: Requirement| {
            let value = self.value(requirement.criterion).unwrap_or(f64::NAN);
            RequirementVerdict::new("carriageway", requirement, value, [value; 2])
        };
        class.requirements().into_iter().map(verdict).collect()
    }

    /// Figures of the observers.
    #[must_use]
    pub fn observer_table(&self) -> Table {
        let columns = [
            ("y_m", "observer at y, m"),
            ("mean_luminance_cd_m2", "L, cd/m2"),
            ("overall_uniformity", "Uo"),
            ("longitudinal_uniformity", "Ul"),
            ("threshold_increment_percent", "fTI, %"),
            ("veiling_luminance_cd_m2", "Lv, cd/m2"),
            ("station_m", "at x, m"),
        ];
        let mut table = Table::new("observers", "Luminance and glare", &columns);
        for observer in &self.luminance {
            let ThresholdIncrement { percent, veiling_luminance, station } = observer.increment;
            let RoadLuminance { y, mean, overall, longitudinal, .. } = *observer;
            let numbers = [y, mean, overall, longitudinal, percent, veiling_luminance, station];
            table.push(numbers.map(TableCell::Number));
        }
        table
    }

    /// The report for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        if !self.verdicts.is_empty() {
            text += &format!("{}\n", verdict_table(&self.verdicts).plain());
        }
        if !self.luminance.is_empty() {
            text += &format!("{}\n", self.observer_table().plain());
        }
        text + &installation_table(&self.facts()).plain()
    }

    /// Assumptions and figures of the carriageway.
    #[must_use]
    pub fn facts(&self) -> FactList {
        let mut facts = self.assumptions.clone();
        facts.push("maintained mean illuminance, lx", "mean_lux", self.mean_illuminance);
        facts.push("least illuminance, lx", "minimum_lux", self.least_illuminance);
        facts.push("uniformity", "u0", ratio(self.least_illuminance, self.mean_illuminance));
        facts.push("edge illuminance ratio REI", "edge_illuminance_ratio", self.edge_ratio);
        facts
    }
}

/// In JSON: `verdicts`, `observers` and `facts`.
impl Serialize for RoadReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Road", 3)?;
        fields.serialize_field("verdicts", &self.verdicts)?;
        fields.serialize_field("observers", &self.observer_table())?;
        fields.serialize_field("facts", &self.facts())?;
        fields.end()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, 0.0), |(low, high), &value| (low.min(value), high.max(value)))
}

/// 0 on a dark road.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::layout::{LuminaireRow, RowArrangement};
    use super::*;
    use crate::planning::requirement::VerdictOutcome;
    use crate::planning::room::LuminaireKind;
    use crate::planning::test_luminaires::uniform;
    use glanz_light::intensity::{AngularSystem, IntensityDistribution, Symmetry};
    use glanz_scene::description::LuminaireDescription;
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// Two lanes of 3.5 m, one row over the right edge, 10 m high, every 30 m, 1000 cd in all directions.
    fn road() -> RoadLayout {
        RoadLayout {
            luminaire: LuminaireKind {
                description: Arc::new(LuminaireDescription {
                    name: "lantern".to_owned(),
                    watts: 42.0,
                    ..LuminaireDescription::default()
                }),
                distribution: uniform(1000.0),
            },
            rows: LuminaireRow::of_arrangement(RowArrangement::SingleSided, 7.0, 30.0, 0.0),
            spacing: 30.0,
            height: 10.0,
            turn: 0.0,
            tilt: 0.0,
            lanes: 2,
            lane_width: 3.5,
        }
    }

    /// Illuminance of the row at a point of the road, from luminaires within a distance.
    fn lux(x: f64, y: f64, within: f64) -> f64 {
        let mut sum = 0.0;
        for number in -50..=50 {
            let (dx, d2) = (30.0 * f64::from(number) - x, y * y);
            if dx.hypot(y) <= within {
                sum += 1000.0 * 10.0 / (dx * dx + d2 + 100.0).powf(1.5);
            }
        }
        sum
    }

    fn field(lines: &[f64], within: f64) -> Vec<f64> {
        lines.iter().flat_map(|&y| (0..10).map(move |i| lux(1.5 + 3.0 * f64::from(i), y, within))).collect()
    }

    #[test]
    fn illuminance_agrees_with_the_calculation_by_hand() {
        // docs/lighting.md, "Illuminance of a road": the point (1.5, 0.7) m has luminaires at 1.655, 28.509 and 31.508 m.
        // 10^4 (102.74^-1.5 + 912.74^-1.5 + 1092.74^-1.5) = 9.6026 + 0.3626 + 0.2768.
        let by_hand = 9.6026 + 0.3626 + 0.2768;
        assert!((lux(1.5, 0.7, 50.0) - by_hand).abs() < 2e-4, "{}", lux(1.5, 0.7, 50.0));
        let lines = [0.7, 2.1, 3.5, 4.9, 6.3];
        let points = field(&lines, 50.0);
        let report = road().rate(None, &MaintenanceFactor::Whole(0.8), None).unwrap();
        assert!((report.mean_illuminance - 0.8 * mean(&points)).abs() < 1e-9, "{report:?}");
        let least = points.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((report.least_illuminance - 0.8 * least).abs() < 1e-9);
        // The row is over the right edge: as bright on both sides of it; darker beyond the left edge.
        let strip = |lines: [f64; 3]| mean(&field(&lines, 50.0));
        let d = 3.5 / 3.0;
        let left = strip([7.0 + 0.5 * d, 7.0 + 1.5 * d, 7.0 + 2.5 * d])
            / strip([3.5 + 0.5 * d, 3.5 + 1.5 * d, 3.5 + 2.5 * d]);
        assert!((report.edge_ratio - left).abs() < 1e-9 && left < 0.8, "{report:?}, {left}");
        assert!(report.luminance.is_empty() && report.value(LightingCriterion::MeanLuminance).is_none());
    }

    #[test]
    fn luminance_of_a_diffuse_road_is_its_illuminance_times_reflectance_over_pi() {
        let surface = RoadSurface::diffuse(0.3);
        let class = Some(RoadClass::M(4));
        let report = road().rate(Some(&surface), &MaintenanceFactor::Whole(0.8), class).unwrap();
        let d = 3.5 / 3.0;
        let lines: Vec<f64> = (0..6).map(|j| (f64::from(j) + 0.5) * d).collect();
        let points = field(&lines, 120.0);
        let expected = 0.8 * mean(&points) * 0.3 / PI;
        assert_eq!(report.luminance.len(), 2);
        for observer in &report.luminance {
            // The table is linear between tangents 0.025 apart.
            assert!((observer.mean / expected - 1.0).abs() < 1e-3, "{observer:?}, {expected}");
            let overall = extremes(&points).0 / mean(&points);
            assert!((observer.overall / overall - 1.0).abs() < 2e-3, "{observer:?}, {overall}");
            let lane = field(&[observer.y], 120.0);
            let longitudinal = extremes(&lane).0 / extremes(&lane).1;
            assert!((observer.longitudinal / longitudinal - 1.0).abs() < 2e-3, "{observer:?}");
        }
        let verdict = &report.verdicts[0];
        assert_eq!((verdict.outcome, verdict.requirement.limit), (VerdictOutcome::NotMet, 0.75));
        assert_eq!(report.verdicts.len(), 5);
    }

    #[test]
    fn threshold_increment_agrees_with_its_sum_over_the_luminaires() {
        let surface = RoadSurface::diffuse(0.3);
        let report = road().rate(Some(&surface), &MaintenanceFactor::Whole(0.8), None).unwrap();
        for observer in &report.luminance {
            let mut worst: f64 = 0.0;
            for step in 0..10 {
                let x = -2.75 * 8.5 + 3.0 * f64::from(step);
                let mut veiling = 0.0;
                for number in 0..=20 {
                    let (dx, dy, dz) = (30.0 * f64::from(number) - x, -observer.y, 8.5);
                    // The roof hides what is steeper than 20 degrees; the first luminaire is at its border at the start.
                    if dx > 500.0 || (dz / dx > 0.364 * 1.0005) || dx < 0.0 {
                        continue;
                    }
                    let r = (dx * dx + dy * dy + dz * dz).sqrt();
                    let down = 1.0_f64.to_radians();
                    let cosine = (dx * down.cos() - dz * down.sin()) / r;
                    let theta = cosine.acos().to_degrees();
                    veiling += 10.001_94 * 1000.0 / (r * r) * cosine / (theta * theta);
                }
                worst = worst.max(veiling);
            }
            // Of the new road: without the maintenance factor.
            let expected = 65.0 * worst / (observer.mean / 0.8).powf(0.8);
            let found = observer.increment;
            assert!((found.percent / expected - 1.0).abs() < 1e-4, "{found:?}, {expected}");
            assert!((found.veiling_luminance / worst - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn light_from_ahead_has_beta_zero() {
        // Luminaires that shine back along the road only, 500 m apart; tables of light from ahead and from behind.
        let values = vec![0.0, 0.0, 0.0, 0.0, 1000.0, 1000.0, 0.0, 0.0];
        let planes = [0.0, 120.0, 180.0, 240.0];
        let distribution = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::None,
            &planes,
            vec![0.0, 90.0],
            values,
        );
        let mut road = RoadLayout { spacing: 500.0, ..road() };
        road.luminaire.distribution = Arc::new(distribution.unwrap());
        road.rows[0].y = 3.5;
        let [ahead, behind] =
            ["tan 0 40 140 180\n0 300 0 0 0\n3 300 0 0 0\n", "tan 0 40 140 180\n0 0 0 0 300\n3 0 0 0 300\n"]
                .map(|text| {
                    road.rate(Some(&RoadSurface::read(text).unwrap()), &MaintenanceFactor::default(), None)
                        .unwrap()
                });
        assert!(ahead.luminance[0].mean > 0.0 && behind.luminance[0].mean == 0.0);
        // No light comes to most of the road.
        assert_eq!(ahead.luminance[0].overall, 0.0);
    }

    #[test]
    fn lanterns_of_both_sides_face_the_road() {
        // Light in the plane C90 alone comes to the road from both sides, and not beside it.
        let values = vec![0.0, 0.0, 1000.0, 1000.0, 0.0, 0.0];
        let planes = [0.0, 90.0, 180.0];
        let distribution = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::None,
            &planes,
            vec![0.0, 90.0],
            values,
        );
        let mut road = road();
        road.luminaire.distribution = Arc::new(distribution.unwrap());
        for arrangement in [RowArrangement::Opposite, RowArrangement::Staggered] {
            road.rows = LuminaireRow::of_arrangement(arrangement, 7.0, 30.0, 0.0);
            let report = road.rate(None, &MaintenanceFactor::default(), None).unwrap();
            // Only the lanterns of the other side shine beyond an edge.
            assert!(report.edge_ratio < 0.7 && report.mean_illuminance > 3.0, "{report:?}");
        }
        // Files whose C0 is the side of the road are turned.
        road.turn = 0.5 * PI;
        let turned = road.luminaires(0.0, 0.0);
        assert!(turned[0].intensity_towards(DVec3::new(10.0, 1e-6, 0.0)) < 1e-3);
        assert!((turned[0].intensity_towards(DVec3::new(-10.0, 1e-6, 0.0)) - 1000.0).abs() < 1e-3);
        road.turn = 0.0;
        // A tilt raises the light of C90.
        let beam = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::Axial,
            &[0.0],
            vec![0.0, 5.0, 6.0],
            vec![1000.0, 1000.0, 0.0],
        );
        road.luminaire.distribution = Arc::new(beam.unwrap());
        let tilted = RoadLayout { tilt: 20.0_f64.to_radians(), ..road };
        let lit = &tilted.luminaires(0.0, 0.0)[0];
        assert_eq!(lit.intensity_towards(DVec3::new(0.0, 10.0 * 20.0_f64.to_radians().tan(), 0.0)), 1000.0);
        assert_eq!(lit.intensity_towards(DVec3::ZERO), 0.0);
    }

    #[test]
    fn faults_are_reported() {
        let refused = |change: fn(&mut RoadLayout)| {
            let mut road = road();
            change(&mut road);
            road.rate(None, &MaintenanceFactor::default(), None).unwrap_err().to_string()
        };
        assert!(refused(|road| road.spacing = 0.0).starts_with("the spacing of the luminaires, m, is 0;"));
        assert!(refused(|road| road.height = f64::NAN).starts_with("the height of the luminaires"));
        assert!(refused(|road| road.lanes = 0).starts_with("the number of lanes is 0;"));
        assert!(
            refused(|road| road.rows[0].y = f64::INFINITY).starts_with("the place of a row across the road")
        );
        assert!(refused(|road| road.rows.clear()).starts_with("the number of rows is 0"));
        let error = road().rate(None, &MaintenanceFactor::default(), Some(RoadClass::M(2))).unwrap_err();
        assert!(error.to_string().starts_with("class M2 limits luminances"));
        assert!(road().rate(None, &MaintenanceFactor::Whole(2.0), None).is_err());
        // 45 m: 15 points; 46 m: 16.
        let stations = |spacing| RoadLayout { spacing, ..road() }.stations().len();
        assert_eq!((stations(20.0), stations(30.0), stations(45.0), stations(46.0)), (10, 10, 15, 16));
    }
}
