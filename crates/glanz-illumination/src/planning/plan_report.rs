//! Ratings of a plan, for people and programs.

use glanz_math::DVec3;
use glanz_report::{FactList, FactValue, Table};
use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use super::glare::GlareRating;
use super::maintenance::MaintenanceFactor;
use super::point_illuminance::GOOD_MODELLING;
use super::power::InstalledPower;
use super::requirement::{LightingTask, RequirementVerdict, installation_table, verdict_table};
use crate::lux_map::uniformity;
use crate::replicates::ReplicateEstimate;
use crate::report::shown_vector;

/// Maintained illuminance at a point in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylindricalPoint {
    /// Metres.
    pub position: DVec3,
    /// Cylindrical illuminance, lx.
    pub cylindrical: ReplicateEstimate,
    /// Horizontal illuminance, lx.
    pub horizontal: ReplicateEstimate,
}

impl CylindricalPoint {
    /// Cylindrical over horizontal illuminance; `None` in the dark.
    #[must_use]
    pub fn modelling(&self) -> Option<f64> {
        (self.horizontal.value > 0.0).then(|| self.cylindrical.value / self.horizontal.value)
    }
}

/// The rating of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanReport {
    /// What is assumed: the room, its surfaces, its luminaires.
    pub assumptions: FactList,
    /// The maintenance factor.
    pub maintenance: MaintenanceFactor,
    /// Its value.
    pub maintenance_factor: f64,
    /// The task, if there is one.
    pub task: Option<LightingTask>,
    /// Verdicts on its requirements.
    pub verdicts: Vec<RequirementVerdict>,
    /// Glare of the observers.
    pub ratings: Vec<GlareRating>,
    /// The reason why glare is not rated; `None` if it is.
    pub glare_refusal: Option<String>,
    /// Cylindrical illuminance.
    pub cylindrical: Vec<CylindricalPoint>,
    /// Number of luminaires.
    pub luminaires: usize,
    /// Their luminous flux when new, lm.
    pub flux: f64,
    /// Their electric power, watts; 0 if unknown.
    pub watts: f64,
    /// Floor area, m^2.
    pub area: f64,
    /// Maintained mean illuminance of the task area, lx.
    pub task_illuminance: Option<f64>,
    /// Whether a part of the light comes from the sky, which costs no power.
    pub has_daylight: bool,
}

impl PlanReport {
    /// The largest UGR with its interval; minus infinity without glare, not a number if glare is not rated.
    #[must_use]
    pub fn largest_ugr(&self) -> (f64, [f64; 2]) {
        if self.glare_refusal.is_some() {
            return (f64::NAN, [f64::NAN; 2]);
        }
        let largest = |value: &dyn Fn(&GlareRating) -> Option<f64>| {
            self.ratings.iter().filter_map(value).fold(f64::NEG_INFINITY, f64::max)
        };
        let end =
            |end: usize| largest(&|rating: &GlareRating| rating.interval().map(|interval| interval[end]));
        (largest(&GlareRating::ugr), [end(0), end(1)])
    }

    /// Mean cylindrical illuminance, lx, and its uniformity (least over mean, 0 in the dark) with its interval; `None` without points.
    ///
    /// The least of several estimates with errors is on average below the least of their true values.
    #[must_use]
    pub fn mean_cylindrical(&self) -> Option<(ReplicateEstimate, [f64; 3])> {
        let count = self.cylindrical.len() as f64;
        let sum = |value: &dyn Fn(&ReplicateEstimate) -> f64| -> f64 {
            self.cylindrical.iter().map(|point| value(&point.cylindrical)).sum()
        };
        let value = sum(&|lux| lux.value) / count;
        // The points are independent.
        let error = sum(&|lux| lux.error.powi(2)).sqrt() / count;
        let margin = sum(&|lux| (0.5 * (lux.interval[1] - lux.interval[0])).powi(2)).sqrt() / count;
        let interval = [value - margin, value + margin];
        let least = |value: &dyn Fn(&ReplicateEstimate) -> f64| {
            self.cylindrical.iter().map(|point| value(&point.cylindrical)).fold(f64::INFINITY, f64::min)
        };
        let ends = [0, 1].map(|end| least(&|lux| lux.interval[end]));
        let (u0, [low, high]) = uniformity((least(&|lux| lux.value), ends), (value, interval));
        (count > 0.0).then_some((ReplicateEstimate { value, error, interval }, [u0, low, high]))
    }

    /// Verdicts.
    #[must_use]
    pub fn verdict_table(&self) -> Table {
        verdict_table(&self.verdicts)
    }

    /// Figures of the installation.
    #[must_use]
    pub fn facts(&self) -> FactList {
        let mut facts = self.assumptions.clone();
        facts.push("luminaires", "luminaires", self.luminaires as u64);
        facts.push("flux of all luminaires when new, lm", "flux_lm", self.flux);
        if let Some(task) = &self.task {
            facts.push("task", "task", task.label());
            facts.push("required colour rendering Ra, not judged", "color_rendering", task.color_rendering);
        }
        facts.push("maintenance factor", "maintenance_factor", self.maintenance_factor);
        if let MaintenanceFactor::Parts { lamp_lumens, lamp_survival, luminaire, room_surfaces } =
            self.maintenance
        {
            let parts = [lamp_lumens, lamp_survival, luminaire, room_surfaces].map(|part| part.to_string());
            facts.push("its parts LLMF x LSF x LMF x RSMF", "maintenance_parts", parts.join(" x "));
        }
        if let Some(lux) = self.task_illuminance {
            facts.push("maintained mean illuminance of the task area, lx", "task_mean_lux", lux);
        }
        let electric = self.task_illuminance.filter(|_| !self.has_daylight);
        let reference = electric.map(|lux| ("task area".to_owned(), lux));
        InstalledPower { watts: self.watts, area: self.area, reference }.add_to(&mut facts);
        self.add_glare(&mut facts);
        if let Some((mean, [u0, ..])) = self.mean_cylindrical() {
            facts.push(
                "points of cylindrical illuminance",
                "cylindrical_points",
                self.cylindrical.len() as u64,
            );
            facts.push("mean cylindrical illuminance, lx", "cylindrical_mean_lux", mean.value);
            facts.push("its uniformity", "cylindrical_u0", u0);
            let ratios = || self.cylindrical.iter().filter_map(CylindricalPoint::modelling);
            if let (Some(least), Some(most)) = (ratios().reduce(f64::min), ratios().reduce(f64::max)) {
                facts.push("modelling: least cylindrical over horizontal", "modelling_minimum", least);
                facts.push("modelling: largest", "modelling_maximum", most);
            }
            let [low, high] = GOOD_MODELLING;
            facts.push(
                "modelling, indicator of EN 12464-1",
                "modelling_indicator",
                format!("{low} to {high}"),
            );
        }
        facts
    }

    fn add_glare(&self, facts: &mut FactList) {
        if let Some(reason) = &self.glare_refusal {
            facts.push("UGR", "ugr_refusal", reason.clone());
            return;
        }
        let worst = self.ratings.iter().filter_map(|rating| Some((rating, rating.ugr()?)));
        let Some((rating, ugr)) = worst.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let shown = |vector: DVec3| FactValue::Text(format!("({})", shown_vector(vector, 3)));
        facts.push("observers", "observers", self.ratings.len() as u64);
        facts.push("largest UGR", "ugr", ugr);
        facts.push("its eye, m", "ugr_eye_m", shown(rating.observer.eye()));
        facts.push("its view", "ugr_view", shown(rating.observer.view()));
        facts.push("its background luminance, cd/m2", "ugr_background_cd_m2", rating.background.value);
        facts.push("luminaires in its field of view", "ugr_luminaires", rating.sources as u64);
    }

    /// The figures as a table.
    #[must_use]
    pub fn fact_table(&self) -> Table {
        installation_table(&self.facts())
    }
}

/// In JSON: `verdicts`, `facts`, and lists of the ratings of observers and of the points of cylindrical illuminance.
impl Serialize for PlanReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct ObserverEntry {
            eye_m: [f64; 3],
            view: [f64; 3],
            ugr: Option<f64>,
            ugr_interval: Option<[f64; 2]>,
            background_cd_m2: f64,
            luminaires: usize,
        }
        #[derive(Serialize)]
        struct PointEntry {
            position_m: [f64; 3],
            cylindrical_lux: f64,
            cylindrical_error_lux: f64,
            horizontal_lux: f64,
            horizontal_error_lux: f64,
        }
        let observers = self.ratings.iter().map(|rating| ObserverEntry {
            eye_m: rating.observer.eye().to_array(),
            view: rating.observer.view().to_array(),
            ugr: rating.ugr().filter(|ugr| ugr.is_finite()),
            ugr_interval: rating.interval().filter(|ends| ends.iter().all(|end| end.is_finite())),
            background_cd_m2: rating.background.value,
            luminaires: rating.sources,
        });
        let points = self.cylindrical.iter().map(|point| PointEntry {
            position_m: point.position.to_array(),
            cylindrical_lux: point.cylindrical.value,
            cylindrical_error_lux: point.cylindrical.error,
            horizontal_lux: point.horizontal.value,
            horizontal_error_lux: point.horizontal.error,
        });
        let mut fields = serializer.serialize_struct("Plan", 4)?;
        fields.serialize_field("verdicts", &self.verdicts)?;
        fields.serialize_field("facts", &self.facts())?;
        fields.serialize_field("observers", &observers.collect::<Vec<_>>())?;
        fields.serialize_field("cylindrical", &points.collect::<Vec<_>>())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(cylindrical: Vec<CylindricalPoint>) -> PlanReport {
        PlanReport {
            assumptions: FactList::default(),
            maintenance: MaintenanceFactor::default(),
            maintenance_factor: 1.0,
            task: None,
            verdicts: Vec::new(),
            ratings: Vec::new(),
            glare_refusal: None,
            cylindrical,
            luminaires: 4,
            flux: 8000.0,
            watts: 60.0,
            area: 20.0,
            task_illuminance: Some(500.0),
            has_daylight: false,
        }
    }

    #[test]
    fn mean_and_uniformity_of_cylinders_have_intervals() {
        let point = |value: f64, half: f64| CylindricalPoint {
            position: DVec3::ZERO,
            cylindrical: ReplicateEstimate { value, error: 1.0, interval: [value - half, value + half] },
            horizontal: ReplicateEstimate { value: 2.0 * value, error: 0.0, interval: [2.0 * value; 2] },
        };
        let found = report(vec![point(100.0, 2.0), point(300.0, 10.0)]);
        let (mean, uniformity) = found.mean_cylindrical().unwrap();
        // Independent errors: half of sqrt(1 + 1), and of sqrt(4 + 100).
        assert!((mean.value, mean.error) == (200.0, 0.5 * 2.0_f64.sqrt()));
        assert!((mean.interval[1] - 205.099).abs() < 1e-3, "{mean:?}");
        for (found, expected) in uniformity.into_iter().zip([0.5, 98.0 / 205.099, 102.0 / 194.901]) {
            assert!((found - expected).abs() < 1e-4, "{uniformity:?}");
        }
        let facts = found.facts();
        assert_eq!(facts.get("power_density_w_m2"), Some(&FactValue::Number(3.0)));
        assert_eq!(facts.get("power_density_w_m2_100lx"), Some(&FactValue::Number(0.6)));
        let lit = PlanReport { has_daylight: true, ..found };
        let of_lit = lit.facts();
        assert_eq!(of_lit.get("power_density_w_m2"), Some(&FactValue::Number(3.0)));
        assert_eq!(of_lit.get("power_density_w_m2_100lx"), None);
        assert_eq!(facts.get("modelling_minimum"), Some(&FactValue::Number(0.5)));
        assert_eq!(report(Vec::new()).mean_cylindrical(), None);
        // Darkness is judged; where the mean may be 0, nothing is known of the uniformity but that it is at most 1.
        let dark = report(vec![point(0.0, 0.0)]);
        let (mean, uniformity) = dark.mean_cylindrical().unwrap();
        assert_eq!((mean.value, uniformity), (0.0, [0.0; 3]));
        assert_eq!(dark.facts().get("modelling_minimum"), None);
        assert_eq!(report(vec![point(1.0, 2.0)]).mean_cylindrical().unwrap().1, [1.0, 0.0, 1.0]);
        // Nobody sees a luminaire: no glare, whatever the limit.
        assert_eq!(report(Vec::new()).largest_ugr().0, f64::NEG_INFINITY);
    }
}
