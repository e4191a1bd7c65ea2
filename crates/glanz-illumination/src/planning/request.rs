//! What is to be rated in a lit scene, and its rating.

use glanz_job::{CancelFlag, Interrupted};
use glanz_math::DVec3;
use glanz_report::FactList;
use glanz_scene::Scene;
use glanz_scene::description::ObserverDescription;
use rayon::prelude::*;

pub use glanz_scene::description::ZoneKind;

use super::emergency::{disability_glare_verdicts, open_area_verdicts};
use super::glare::{GlareError, GlareObserver, GlareRating};
use super::luminaire::PlacedLuminaire;
use super::luminaire_list::sky_kind;
use super::maintenance::{MaintenanceError, MaintenanceFactor};
use super::plan_report::{CylindricalPoint, PlanReport};
use super::point_illuminance::{PointGather, PointReceiver};
use super::requirement::{
    LightingCriterion, LightingTask, ROOM_UNIFORMITY, RequirementVerdict, surrounding_illuminance,
};
use crate::lux_map::uniformity;
use crate::replicates::ReplicateEstimate;
use crate::{LuxMap, LuxSummary, Receivers};

/// Least uniformity of the surrounding area in EN 12464-1.
const SURROUNDING_UNIFORMITY: f64 = 0.40;

/// Receivers that are a zone together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LitZone {
    /// Its name in reports.
    pub name: String,
    /// Names of its receivers.
    pub receivers: Vec<String>,
    /// Its kind.
    pub kind: ZoneKind,
}

/// What is to be rated.
#[derive(Clone, Debug, Default)]
pub struct PlanningRequest {
    /// Zones with requirements.
    pub zones: Vec<LitZone>,
    /// All luminaires.
    pub luminaires: Vec<PlacedLuminaire>,
    /// Observers whose glare is rated.
    pub observers: Vec<GlareObserver>,
    /// Points of cylindrical illuminance, metres.
    pub points: Vec<DVec3>,
    /// Points of the core of an open area for emergency lighting, metres; none: emergency lighting is not judged.
    pub open_area: Vec<DVec3>,
    /// Electric power of all luminaires, watts; 0 if unknown.
    pub watts: f64,
    /// Floor area, m^2, to which the power refers.
    pub area: f64,
    /// What is assumed, for the report.
    pub assumptions: FactList,
}

/// Settings of a rating.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanningSettings {
    /// The task, which gives the limits; `None`: values without limits.
    pub task: Option<LightingTask>,
    /// The maintenance factor.
    pub maintenance: MaintenanceFactor,
    /// Number of directions from each eye and point; their error falls with its square root.
    pub directions: u32,
    /// Seed of the directions.
    pub seed: u64,
}

impl Default for PlanningSettings {
    /// A new installation without limits; 2048 directions, whose background luminances have errors of a per cent or two: some hundredths of UGR.
    fn default() -> Self {
        Self { task: None, maintenance: MaintenanceFactor::default(), directions: 2048, seed: 0 }
    }
}

/// Errors of a rating.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanningError {
    /// A maintenance factor out of range.
    #[error(transparent)]
    Maintenance(#[from] MaintenanceError),
    /// The paths that gather light cannot be set up.
    #[error(transparent)]
    Paths(#[from] glanz_transport::IntegratorError),
    /// The calculation was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl PlanningRequest {
    /// What a scene declares: receivers with a zone, of which those of one name are one zone; observers; its photometric lights.
    #[must_use]
    pub fn of_scene(
        scene: &Scene,
        receivers: &Receivers,
        observers: &[ObserverDescription],
        luminaires: Vec<PlacedLuminaire>,
    ) -> Self {
        let mut zones: Vec<LitZone> = Vec::new();
        for declared in scene.receivers() {
            let Some(kind) = declared.zone() else { continue };
            let own = receivers.as_slice().iter().filter(|receiver| receiver.shape() == declared.shape());
            let names: Vec<String> = own.map(|receiver| receiver.name().to_owned()).collect();
            match zones.iter_mut().find(|zone| zone.name == declared.name() && zone.kind == kind) {
                Some(zone) => zone.receivers.extend(names),
                None => zones.push(LitZone { name: declared.name().to_owned(), receivers: names, kind }),
            }
        }
        let eyes = observers.iter().filter_map(|at| GlareObserver::try_new(at.position, at.view?).ok());
        let points = observers.iter().filter(|at| at.view.is_none()).map(|at| at.position);
        Self { zones, luminaires, observers: eyes.collect(), points: points.collect(), ..Self::default() }
    }

    /// Whether there is nothing to be rated.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.zones.is_empty() && self.observers.is_empty() && self.points.is_empty()
    }

    /// Rates a scene by the illuminance of its receivers, `maps`, of the new installation.
    ///
    /// `on_progress` is called with the share that is done, in (0, 1]. UGR is that of the new installation, all illuminances are maintained ones.
    ///
    /// # Errors
    /// [`PlanningError`].
    pub fn rate(
        &self,
        scene: &Scene,
        maps: &[LuxMap],
        settings: &PlanningSettings,
        on_progress: &mut dyn FnMut(f64),
        cancel: &CancelFlag,
    ) -> Result<PlanReport, PlanningError> {
        let factor = settings.maintenance.value()?;
        let gather = PointGather::try_new(scene, settings.directions, settings.seed)?;
        let sources: Result<Vec<_>, GlareError> =
            self.observers.iter().map(|observer| sources(&gather, observer, &self.luminaires)).collect();
        let (sources, glare_refusal) = match sources {
            Ok(sources) => (sources, None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        let steps = self.points.len() + sources.len();
        let mut done = 0;
        let mut add_done = |count: usize| {
            done += count;
            on_progress(done as f64 / steps as f64);
        };
        let points: Vec<(u32, DVec3)> = (0..).step_by(2).zip(self.points.iter().copied()).collect();
        let cylindrical = in_portions(&points, &mut add_done, |&(number, position)| {
            cylinder(&gather, position, number, factor, cancel)
        })?;
        let first = 2 * self.points.len() as u32;
        let observers: Vec<_> = (first..).zip(self.observers.iter().zip(&sources)).collect();
        let ratings = in_portions(&observers, &mut add_done, |&(number, (observer, sources))| {
            rating(&gather, observer, number, *sources, cancel)
        })?;
        let mut report = PlanReport {
            assumptions: self.assumptions(maps),
            maintenance: settings.maintenance,
            maintenance_factor: factor,
            task: settings.task,
            verdicts: Vec::new(),
            ratings,
            glare_refusal,
            cylindrical,
            luminaires: self.luminaires.len(),
            flux: self.luminaires.iter().map(PlacedLuminaire::flux).sum(),
            watts: self.watts,
            area: self.area,
            task_illuminance: self.task_illuminance(maps, factor),
            has_daylight: scene.lights().iter().any(|light| sky_kind(light).is_some()),
        };
        if let Some(task) = &settings.task {
            report.verdicts = self.verdicts(task, maps, &report);
        }
        if let Some(point) = self.open_area.first() {
            let name = "open area, emergency";
            report.verdicts.extend(open_area_verdicts(name, &self.luminaires, &self.open_area, factor));
            report.verdicts.extend(disability_glare_verdicts(&self.luminaires, point.z));
        }
        Ok(report)
    }

    /// What is assumed, with the names of zones whose illuminance is unknown.
    fn assumptions(&self, maps: &[LuxMap]) -> FactList {
        let unknown = self.zones.iter().filter(|zone| ZoneSummary::new(zone, maps).is_none());
        let names: Vec<&str> = unknown.map(|zone| zone.name.as_str()).collect();
        let mut facts = self.assumptions.clone();
        if !names.is_empty() {
            facts.push(
                "zones without an area that receives light, undecided",
                "unlit_zones",
                names.join(", "),
            );
        }
        facts
    }

    /// Maintained mean illuminance of the first task area, lx.
    fn task_illuminance(&self, maps: &[LuxMap], factor: f64) -> Option<f64> {
        let zone = self.zones.iter().find(|zone| zone.kind == ZoneKind::Task)?;
        Some(ZoneSummary::new(zone, maps)?.mean.0 * factor)
    }

    fn verdicts(&self, task: &LightingTask, maps: &[LuxMap], report: &PlanReport) -> Vec<RequirementVerdict> {
        use LightingCriterion::{CylindricalIlluminance, GlareRating, MeanIlluminance, Uniformity};
        let factor = report.maintenance_factor;
        let mut verdicts = Vec::new();
        for zone in &self.zones {
            let ZoneSummary { mean: (mean, interval), uniformity: (u0, u0_interval) } =
                ZoneSummary::new(zone, maps).unwrap_or(ZoneSummary::UNKNOWN);
            let surrounding = surrounding_illuminance(task.illuminance);
            let (illuminance, uniformity) = match zone.kind {
                ZoneKind::Task => (task.illuminance, task.uniformity),
                ZoneKind::Surrounding => (surrounding, SURROUNDING_UNIFORMITY),
                ZoneKind::Background => (surrounding / 3.0, ROOM_UNIFORMITY),
                ZoneKind::Wall => (task.walls, ROOM_UNIFORMITY),
                ZoneKind::Ceiling => (task.ceiling, ROOM_UNIFORMITY),
            };
            for (criterion, limit, value, interval) in [
                (MeanIlluminance, illuminance, mean * factor, interval.map(|lux| lux * factor)),
                (Uniformity, uniformity, u0, u0_interval),
            ] {
                let requirement = task.requirement(criterion, limit);
                verdicts.push(RequirementVerdict::new(&zone.name, requirement, value, interval));
            }
        }
        if !self.observers.is_empty() {
            let (value, interval) = report.largest_ugr();
            let requirement = task.requirement(GlareRating, task.glare_rating);
            verdicts.push(RequirementVerdict::new("observers", requirement, value, interval));
        }
        if let Some((mean, [u0, low, high])) = report.mean_cylindrical() {
            let zone = "cylinders";
            let requirement = task.requirement(CylindricalIlluminance, task.cylindrical);
            verdicts.push(RequirementVerdict::new(zone, requirement, mean.value, mean.interval));
            let requirement = task.requirement(Uniformity, ROOM_UNIFORMITY);
            verdicts.push(RequirementVerdict::new(zone, requirement, u0, [low, high]));
        }
        verdicts
    }
}

/// Mean illuminance of a zone, lx, and its uniformity, with their intervals.
struct ZoneSummary {
    mean: (f64, [f64; 2]),
    uniformity: (f64, [f64; 2]),
}

impl ZoneSummary {
    /// That of a zone without a lit receiver, on which nothing can be decided.
    const UNKNOWN: Self = Self { mean: (f64::NAN, [f64::NAN; 2]), uniformity: (f64::NAN, [f64::NAN; 2]) };

    /// `None` if none of its receivers has an area.
    fn new(zone: &LitZone, maps: &[LuxMap]) -> Option<Self> {
        let own = maps.iter().filter(|map| zone.receivers.contains(&map.name)).map(LuxMap::summary);
        let parts: Vec<LuxSummary> = own.filter(|summary| summary.area > 0.0).collect();
        if let [only] = parts.as_slice() {
            let mean = (only.mean, only.mean_interval);
            return Some(Self { mean, uniformity: (only.u0, only.u0_interval) });
        }
        let area: f64 = parts.iter().map(|part| part.area).sum();
        let mean = |value: &dyn Fn(&LuxSummary) -> f64| {
            parts.iter().map(|part| part.area * value(part)).sum::<f64>() / area
        };
        let least =
            |value: &dyn Fn(&LuxSummary) -> f64| parts.iter().map(value).fold(f64::INFINITY, f64::min);
        // Parts at their limits at the same time.
        let ends = [0, 1].map(|end| mean(&|part| part.mean_interval[end]));
        let minima = [0, 1].map(|end| least(&|part| part.minimum_interval[end]));
        let value = mean(&|part| part.mean);
        let uniformity = uniformity((least(&|part| part.minimum), minima), (value, ends));
        (area > 0.0).then_some(Self { mean: (value, ends), uniformity })
    }
}

/// Number of luminaires that an observer sees and counts, and the sum of their glare.
fn sources(
    gather: &PointGather<'_>,
    observer: &GlareObserver,
    luminaires: &[PlacedLuminaire],
) -> Result<(usize, f64), GlareError> {
    let (mut count, mut glare) = (0, 0.0);
    for luminaire in luminaires {
        let offset = luminaire.position - observer.eye();
        let distance = offset.length();
        if observer.position_index(offset).is_none()
            || !gather.is_free(observer.eye(), offset / distance, distance)
        {
            continue;
        }
        if let Some(source) = observer.source(luminaire)? {
            count += 1;
            glare += source.glare();
        }
    }
    Ok((count, glare))
}

/// The results of `work` for all items, with all threads; `add_done` is called with numbers of items that are done.
fn in_portions<T: Sync, R: Send>(
    items: &[T],
    add_done: &mut dyn FnMut(usize),
    work: impl Fn(&T) -> Result<R, Interrupted> + Sync,
) -> Result<Vec<R>, Interrupted> {
    let mut results = Vec::with_capacity(items.len());
    for portion in items.chunks(4 * rayon::current_num_threads()) {
        let found: Result<Vec<R>, Interrupted> = portion.par_iter().map(&work).collect();
        results.extend(found?);
        add_done(portion.len());
    }
    Ok(results)
}

/// The rating of an observer who sees this number of luminaires with this sum of their glare.
fn rating(
    gather: &PointGather<'_>,
    observer: &GlareObserver,
    number: u32,
    (sources, of_luminaires): (usize, f64),
    cancel: &CancelFlag,
) -> Result<GlareRating, Interrupted> {
    let plane = PointReceiver::Plane(observer.horizontal_view());
    let light = gather.illuminance(observer.eye(), plane, number, cancel)?;
    let background = light.reflected.scaled(std::f64::consts::FRAC_1_PI);
    let glare = gather.emitted_glare(observer, number, cancel)?.plus(of_luminaires);
    Ok(GlareRating { observer: *observer, background, sources, glare })
}

/// Maintained cylindrical and horizontal illuminance at a point.
fn cylinder(
    gather: &PointGather<'_>,
    position: DVec3,
    number: u32,
    factor: f64,
    cancel: &CancelFlag,
) -> Result<CylindricalPoint, Interrupted> {
    let of = |receiver, number| -> Result<ReplicateEstimate, Interrupted> {
        Ok(gather.illuminance(position, receiver, number, cancel)?.total().scaled(factor))
    };
    let horizontal = of(PointReceiver::Plane(DVec3::Z), number + 1)?;
    Ok(CylindricalPoint { position, cylindrical: of(PointReceiver::Cylinder, number)?, horizontal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn receivers_of_a_zone_count_by_their_areas() {
        let map = |name: &str, area: f64, lux: [f64; 2], error: f64| LuxMap {
            name: name.into(),
            cells: [2, 1],
            size: [1.0, 1.0],
            positions: vec![DVec3::ZERO; 2],
            areas: vec![0.5 * area; 2],
            lux: lux.to_vec(),
            errors: vec![error; 2],
            statistics: None,
        };
        let maps = [
            map("a 1", 1.0, [80.0, 120.0], 1.0),
            map("b", 9.0, [1.0; 2], 0.0),
            map("a 2", 3.0, [250.0, 350.0], 2.0),
        ];
        let zone = |receivers: &[&str]| LitZone {
            name: "a".into(),
            receivers: receivers.iter().map(|name| (*name).to_owned()).collect(),
            kind: ZoneKind::Surrounding,
        };
        let both = ZoneSummary::new(&zone(&["a 1", "a 2"]), &maps).unwrap();
        // (1 * 100 + 3 * 300) / 4 = 250, with bounds of (1 + 3 * 2) / 4 = 1.75; the least is 80 in the first.
        assert_eq!(both.mean, (250.0, [248.25, 251.75]));
        assert_eq!(both.uniformity, (80.0 / 250.0, [79.0 / 251.75, 81.0 / 248.25]));
        let one = ZoneSummary::new(&zone(&["a 2"]), &maps).unwrap();
        assert_eq!((one.mean.0, one.uniformity.0), (300.0, 250.0 / 300.0));
        assert!(ZoneSummary::new(&zone(&["c"]), &maps).is_none());
    }

    #[test]
    fn zones_whose_illuminance_is_unknown_are_undecided() {
        let zone = LitZone { name: "desk".into(), receivers: vec!["desk".into()], kind: ZoneKind::Task };
        let request = PlanningRequest { zones: vec![zone], ..PlanningRequest::default() };
        let (scene, _) = glanz_scene::SceneBuilder::new()
            .light(glanz_scene::description::LightDescription::infinite(1.0))
            .resolve()
            .unwrap();
        let settings =
            PlanningSettings { task: LightingTask::of_reference("34.2"), ..PlanningSettings::default() };
        let report = request.rate(&scene, &[], &settings, &mut |_| (), &CancelFlag::default()).unwrap();
        assert_eq!(report.verdicts.len(), 2);
        let undecided = crate::planning::requirement::VerdictOutcome::Undecided;
        assert!(report.verdicts.iter().all(|verdict| verdict.outcome == undecided && verdict.value.is_nan()));
        assert_eq!(report.facts().get("unlit_zones"), Some(&"desk".to_owned().into()));
    }
}
