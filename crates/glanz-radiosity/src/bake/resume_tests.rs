//! Bakes that are interrupted and resumed.

#![expect(clippy::result_large_err, reason = "an interrupted bake ends with its state")]

use std::time::Duration;

use glanz_job::{Interrupted, JobProgress, Silent};
use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;
use glanz_scene::description::ShapeDescription;

use super::*;
use crate::elements::{ElementSettings, Patch};
use crate::scenes::{parallelogram, scene, walls};

pub(super) const COARSE: BakeSettings =
    BakeSettings { density: 5.0, rays: 64, shadow_rays: 64, method: BakeMethod::Gather };

pub(super) const BY_RADIOSITY: BakeSettings = BakeSettings {
    method: BakeMethod::Radiosity { reconstruction: Interpolation::NaturalNeighbour },
    ..COARSE
};

/// A room with a lamp, a box and a ball.
pub(super) fn room() -> Scene {
    let mut shapes: Vec<_> = walls(DVec3::new(2.0, 2.0, 1.5)).into_iter().map(|w| (w, 0.7, 0.0)).collect();
    shapes.push((parallelogram(DVec3::new(0.5, 0.5, 1.4), DVec3::Y, DVec3::X), 0.3, 2.0));
    let cuboid = ShapeDescription::cuboid(DVec3::new(0.4, 0.3, 0.0), DVec3::new(0.9, 0.8, 0.6));
    shapes.push((cuboid, 0.5, 0.0));
    shapes.push((ShapeDescription::sphere(0.4), 0.6, 0.0));
    scene(shapes)
}

pub(super) fn elements(scene: &Scene) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side: 0.5 }).unwrap()
}

pub(super) fn assert_same(a: &[LightMap], b: &[LightMap]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_eq!(
            (a.is_hidden, &a.irradiance, &a.radiance, a.chart.size),
            (b.is_hidden, &b.irradiance, &b.radiance, b.chart.size)
        );
    }
}

/// Cancels a bake after a number of reports, and stores its state.
pub(super) struct Stopper {
    pub(super) reports: usize,
    pub(super) cancel: CancelFlag,
    pub(super) last: Option<BakeState>,
}

impl ProgressSink<BakeState> for Stopper {
    fn on_progress(&mut self, _: &JobProgress<'_>) {
        self.reports = self.reports.saturating_sub(1);
        if self.reports == 0 {
            self.cancel.cancel();
        }
    }

    fn on_checkpoint(&mut self, state: &BakeState) {
        assert!(self.last.replace(state.clone()).is_none());
    }
}

/// Stores the last state and the phases.
#[derive(Default)]
struct StateRecorder {
    last: BakeState,
    phases: Vec<u32>,
}

impl ProgressSink<BakeState> for StateRecorder {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.phases.push(progress.step[0]);
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        Some(Duration::ZERO)
    }

    fn on_checkpoint(&mut self, state: &BakeState) {
        self.last = state.clone();
    }
}

/// Bakes until progress has been reported `reports` times; the light maps, or the state if the bake was cancelled.
fn until(reports: usize, elements: &Elements<'_>, state: BakeState) -> Result<Vec<LightMap>, BakeState> {
    stopped(reports, elements, &COARSE, state)
}

fn stopped(
    reports: usize,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    state: BakeState,
) -> Result<Vec<LightMap>, BakeState> {
    let cancel = CancelFlag::default();
    let mut stopper = Stopper { reports, cancel: cancel.clone(), last: None };
    match resume(state, elements, settings, &mut stopper, &cancel) {
        Ok(light) => Ok(light.maps),
        Err(error) => {
            assert_eq!(error, BakeError::Interrupted(Interrupted));
            Err(stopper.last.unwrap())
        }
    }
}

#[test]
fn interrupted_bake_resumes_to_the_same_bits_from_any_moment() {
    let scene = room();
    let elements = elements(&scene);
    let whole = bake(&elements, &COARSE, &mut Silent, &CancelFlag::default()).unwrap().maps;
    let mut stages = Vec::new();
    let mut reports = 1;
    loop {
        let state = match until(reports, &elements, BakeState::default()) {
            Ok(maps) => {
                assert_same(&maps, &whole);
                break;
            }
            Err(state) => state,
        };
        stages.push((state.indirect.is_some(), state.points()));
        let read = BakeState::from_bytes(&state.to_bytes()).unwrap();
        assert_eq!(read, state);
        assert_same(&until(usize::MAX, &elements, read).unwrap(), &whole);
        reports += 1;
    }
    // Moments before the final gather, at its beginning and within it.
    assert!(stages.contains(&(false, 0)) && stages.contains(&(true, 0)), "{stages:?}");
    assert!(stages.iter().any(|(_, places)| *places > 100), "{stages:?}");
    assert!(stages.is_sorted());
}

#[test]
fn interrupted_radiosity_resumes_to_the_same_bits_from_any_moment() {
    let scene = room();
    let elements = elements(&scene);
    let settings = BY_RADIOSITY;
    let whole = bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap().maps;
    let (mut reports, mut solved) = (1, 0);
    loop {
        let state = match stopped(reports, &elements, &settings, BakeState::default()) {
            Ok(maps) => {
                assert_same(&maps, &whole);
                break;
            }
            Err(state) => state,
        };
        solved += usize::from(state.solution.is_some());
        let bytes = state.to_bytes();
        assert!((0..bytes.len()).step_by(37).all(|length| BakeState::from_bytes(&bytes[..length]).is_none()));
        let read = BakeState::from_bytes(&bytes).unwrap();
        assert_eq!(read, state);
        assert_same(&stopped(usize::MAX, &elements, &settings, read).unwrap(), &whole);
        reports += 1;
    }
    assert!(reports > 3 && solved > 0, "{reports} {solved}");
}

#[test]
fn bake_that_is_interrupted_repeatedly_finishes() {
    let scene = room();
    let elements = elements(&scene);
    let whole = bake(&elements, &COARSE, &mut Silent, &CancelFlag::default()).unwrap().maps;
    let (mut state, mut reports) = (BakeState::default(), 1);
    let maps = loop {
        match until(reports, &elements, state) {
            Ok(maps) => break maps,
            Err(found) => (state, reports) = (found, reports + 1),
        }
    };
    assert_same(&maps, &whole);
}

#[test]
fn gathered_light_is_not_gathered_again() {
    let scene = room();
    let elements = elements(&scene);
    let cancel = CancelFlag::default();
    let (mut first, mut second) = (StateRecorder::default(), StateRecorder::default());
    resume(BakeState::default(), &elements, &COARSE, &mut first, &cancel).unwrap();
    let before = first.last.points();
    resume(first.last, &elements, &COARSE, &mut second, &cancel).unwrap();
    // The second phase, light between surfaces, is not repeated.
    assert!(before > 100 && first.phases.contains(&2) && !second.phases.contains(&2));
}

#[test]
fn traced_rays_of_elements_are_not_traced_again() {
    let scene = room();
    let fine = BakeSettings { density: 16.0, ..BY_RADIOSITY };
    for (settings, phase, side) in [(COARSE, 2, 0.1), (fine, 3, 0.5)] {
        let elements = Elements::new(&scene, &ElementSettings { side }).unwrap();
        let cancel = CancelFlag::default();
        let mut stopper =
            SweepStopper { phase, reports: 0, cancel: cancel.clone(), last: BakeState::default() };
        let ended = resume(BakeState::default(), &elements, &settings, &mut stopper, &cancel);
        assert_eq!(ended.err(), Some(BakeError::Interrupted(Interrupted)));
        let traced = stopper.last.rows.as_ref().map_or(0, Vec::len);
        assert!(traced >= 256, "{traced}");
        let read = BakeState::from_bytes(&stopper.last.to_bytes()).unwrap();
        assert_eq!(read, stopper.last);
        let mut recorder = StateRecorder::default();
        resume(read, &elements, &settings, &mut recorder, &CancelFlag::default()).unwrap();
        assert!(recorder.phases.iter().all(|&number| number >= phase));
    }
}

#[test]
fn state_of_other_elements_is_refused() {
    let scene = room();
    let elements = elements(&scene);
    let other = BakeState { indirect: Some(vec![Spectrum::ONE; 3]), ..BakeState::default() };
    let refused = resume(other.clone(), &elements, &COARSE, &mut Silent, &CancelFlag::default());
    assert_eq!(refused.err(), Some(BakeError::State));
    let bytes = other.to_bytes();
    assert!((0..bytes.len()).all(|length| BakeState::from_bytes(&bytes[..length]).is_none()));
    let mut longer = bytes;
    longer.push(0);
    assert!(BakeState::from_bytes(&longer).is_none());
}

#[test]
fn stored_maps_equal_the_maps() {
    let scene = room();
    let elements = elements(&scene);
    let maps = bake(&elements, &COARSE, &mut Silent, &CancelFlag::default()).unwrap().maps;
    let bytes = stored::to_bytes(&maps);
    assert_same(&stored::from_bytes(&elements, COARSE.density, &bytes).unwrap(), &maps);
    assert!(stored::from_bytes(&elements, 2.0 * COARSE.density, &bytes).is_none());
    for length in (0..bytes.len()).step_by(97) {
        assert!(stored::from_bytes(&elements, COARSE.density, &bytes[..length]).is_none());
    }
}

/// The last state of a bake.
fn last_state(elements: &Elements<'_>, settings: &BakeSettings) -> BakeState {
    let mut recorder = StateRecorder::default();
    resume(BakeState::default(), elements, settings, &mut recorder, &CancelFlag::default()).unwrap();
    recorder.last
}

fn refusal(state: BakeState, elements: &Elements<'_>, settings: &BakeSettings) -> Option<BakeError> {
    resume(state, elements, settings, &mut Silent, &CancelFlag::default()).err()
}

#[test]
fn stored_elements_that_overlap_or_leave_their_face_are_refused() {
    use crate::elements::ParameterPatch;
    let scene = room();
    let elements = elements(&scene);
    let whole = Patch { domain: ParameterPatch::SQUARE, ..elements.list[0].patch };
    let wide = ParameterPatch::Rectangle { min: DVec2::ZERO, max: DVec2::splat(2.0) };
    for patches in [vec![whole; 2], vec![Patch { domain: wide, ..whole }]] {
        let solution = Some(patches.into_iter().map(|patch| (patch, None)).collect());
        let state = BakeState { solution, ..BakeState::default() };
        assert_eq!(refusal(state, &elements, &BY_RADIOSITY), Some(BakeError::State));
    }
}

#[test]
fn stored_elements_that_leave_a_part_of_the_scene_without_light_are_refused() {
    let scene = room();
    let elements = elements(&scene);
    let stored = last_state(&elements, &BY_RADIOSITY).solution.unwrap();
    let refused = |solution: Vec<_>| {
        let state = BakeState { solution: Some(solution), ..BakeState::default() };
        refusal(state, &elements, &BY_RADIOSITY) == Some(BakeError::State)
    };
    assert!(stored.len() > 100 && !refused(stored.clone()));
    assert!(refused(Vec::new()));
    for gap in [0, stored.len() / 2, stored.len() - 1] {
        let mut rest = stored.clone();
        rest.remove(gap);
        assert!(refused(rest), "{gap}");
    }
    let side = |patch: &Patch| (patch.surface, patch.face, patch.back);
    let first = side(&stored[0].0);
    assert!(refused(stored.iter().filter(|(patch, _)| side(patch) != first).copied().collect()));
    assert!(refused(stored.iter().filter(|(patch, _)| side(patch) == first).copied().collect()));
}

#[test]
fn state_of_the_other_method_is_refused() {
    let scene = room();
    let elements = elements(&scene);
    for (own, other) in [(COARSE, BY_RADIOSITY), (BY_RADIOSITY, COARSE)] {
        let state = last_state(&elements, &own);
        assert!(!state.is_empty());
        assert_eq!(refusal(state, &elements, &other), Some(BakeError::State));
    }
}

#[test]
fn elements_that_memory_makes_larger_are_reported_even_after_an_interruption() {
    let scene = room();
    let elements = elements(&scene);
    let charts = charts(&elements.surfaces, COARSE.density);
    let (mut sink, cancel) = (Silent, CancelFlag::default());
    let mut progress = BakeProgress::new(&mut sink, &cancel, 4);
    let mut state = BakeState::default();
    let direct =
        direct::light_on_charts(&elements, &charts, &BY_RADIOSITY, None, &mut state, &mut progress).unwrap();
    let index = SurfaceIndex::new(&elements, &charts);
    let gather = FinalGather::new(&elements, &index, &charts, &direct, &BY_RADIOSITY);
    for (limit, is_coarse) in [(100, true), (MAX_SMALL_ELEMENTS, false)] {
        let (refined, error) =
            solution::refined(&gather, &elements, &BY_RADIOSITY, limit, &mut progress).unwrap();
        assert!(refined.list.len() <= limit);
        assert_eq!(error.is_some_and(|error| error > solution::BOUND), is_coarse, "{limit} {error:?}");
    }
    let state = last_state(&elements, &BY_RADIOSITY);
    let count = state.solution.as_ref().map_or(0, Vec::len);
    for coarse_error in [None, Some(0.02)] {
        let stored = BakeState { coarse_error, ..state.clone() };
        let read = BakeState::from_bytes(&stored.to_bytes()).unwrap();
        let light = resume(read, &elements, &BY_RADIOSITY, &mut Silent, &cancel).unwrap();
        let expected = coarse_error.map(|error| CoarseElements { count, error, bound: solution::BOUND });
        assert_eq!(light.coarse_elements, expected);
    }
}

/// Cancels a bake at the second report of its phase before the last one, after all rays between elements were traced.
struct SweepStopper {
    phase: u32,
    reports: usize,
    cancel: CancelFlag,
    last: BakeState,
}

impl ProgressSink<BakeState> for SweepStopper {
    fn on_checkpoint(&mut self, state: &BakeState) {
        self.last = state.clone();
    }

    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.reports += usize::from(progress.step[0] == self.phase);
        if self.reports == 2 {
            self.cancel.cancel();
        }
    }
}

#[test]
fn sweeps_over_elements_can_be_cancelled() {
    // So few elements that the rays of all are traced between two reports.
    let scene = room();
    let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
    assert!(elements.list.len() < 256);
    let cancel = CancelFlag::default();
    let mut stopper =
        SweepStopper { phase: 2, reports: 0, cancel: cancel.clone(), last: BakeState::default() };
    let ended = resume(BakeState::default(), &elements, &COARSE, &mut stopper, &cancel);
    assert_eq!(ended.err(), Some(BakeError::Interrupted(Interrupted)));
    assert_eq!(stopper.reports, 2);
}

#[test]
fn exponents_that_an_interpolation_refuses_are_errors() {
    let scene = room();
    let elements = elements(&scene);
    let refused = |reconstruction: Interpolation, cancel: &CancelFlag| {
        let settings = BakeSettings { method: BakeMethod::Radiosity { reconstruction }, ..COARSE };
        bake(&elements, &settings, &mut Silent, cancel).err()
    };
    // A cancelled bake ends at its first report: these are refused before.
    let cancelled = CancelFlag::default();
    cancelled.cancel();
    for reconstruction in [
        Interpolation::Shepard { exponent: 0.0 },
        Interpolation::Shepard { exponent: f64::NAN },
        Interpolation::Multiquadrics { exponent: 0.0 },
        Interpolation::Multiquadrics { exponent: f64::INFINITY },
    ] {
        let error = refused(reconstruction, &cancelled);
        let is_exponent = matches!(error, Some(BakeError::Interpolation(ReconstructError::Exponent(..))));
        assert!(is_exponent, "{reconstruction:?} {error:?}");
    }
    // Polynomials of degree 4: too few of them for the samples of a wall.
    let error = refused(Interpolation::Multiquadrics { exponent: 2.0 }, &CancelFlag::default());
    assert!(matches!(error, Some(BakeError::Interpolation(ReconstructError::Singular(_)))), "{error:?}");
}
