//! Bakes in parts.

use glanz_job::{JobPart, Silent};
use glanz_math::DVec3;
use glanz_scene::description::LightKind;

use super::resume_tests::{BY_RADIOSITY, COARSE, Stopper, assert_same, elements, room};
use super::*;
use crate::elements::ElementSettings;
use crate::scenes::{scene_with, walls};

fn part(number: u32, count: u32, direct_only: bool) -> BakePart {
    BakePart { part: JobPart::try_new(number, count).unwrap(), direct_only }
}

/// The joined state of all parts, as it is read from its bytes.
fn joined(elements: &Elements<'_>, start: &BakeState, count: u32, direct_only: bool) -> BakeState {
    let mut whole: Option<BakeState> = None;
    for number in (1..=count).rev() {
        let part = part(number, count, direct_only);
        let state =
            bake_part(start.clone(), elements, &COARSE, part, &mut Silent, &CancelFlag::default()).unwrap();
        let state = BakeState::from_bytes(&state.to_bytes()).unwrap();
        match &mut whole {
            None => whole = Some(state),
            Some(whole) => whole.merge(state).unwrap(),
        }
    }
    let whole = whole.unwrap();
    assert_eq!(whole.parts.as_ref().unwrap().missing().count(), 0);
    whole
}

#[test]
fn joined_parts_give_the_bits_of_one_bake() {
    let scene = room();
    let elements = elements(&scene);
    let whole = bake(&elements, &COARSE, &mut Silent, &CancelFlag::default()).unwrap().maps;
    let texels: usize = whole.iter().map(|map| map.chart.texels()).sum();
    for count in [1, 3, 5] {
        let state = joined(&elements, &BakeState::default(), count, false);
        assert_eq!(state.direct_texels(), texels);
        // Without parts that end with the direct light, and with them.
        let direct = joined(&elements, &BakeState::default(), count, true);
        assert_eq!((direct.direct_texels(), direct.points()), (texels, 0));
        let start = BakeState { parts: None, ..direct };
        assert_eq!(joined(&elements, &start, count, false), state);
        // Nothing is computed again: no point is added.
        let points = state.points();
        assert!(points > 100);
        let mut sink = PointCounter::default();
        let maps = resume(state, &elements, &COARSE, &mut sink, &CancelFlag::default()).unwrap().maps;
        assert_same(&maps, &whole);
        assert_eq!((sink.points, sink.first_phase), (Some(points), Some(3)), "{count}");
    }
}

#[test]
fn parts_of_different_divisions_are_not_joined() {
    let scene = room();
    let elements = elements(&scene);
    let state = |part| {
        let start = BakeState::default();
        bake_part(start, &elements, &COARSE, part, &mut Silent, &CancelFlag::default()).unwrap()
    };
    let first = state(part(1, 3, true));
    for other in [part(2, 4, true), part(2, 3, false)] {
        assert_eq!(first.clone().merge(state(other)), Err(BakeConflict::Division));
    }
    assert_eq!(first.clone().merge(state(part(2, 3, true))), Ok(()));
}

/// Stores the number of points of the last state, and the first phase with progress.
#[derive(Default)]
struct PointCounter {
    points: Option<usize>,
    first_phase: Option<u32>,
}

impl ProgressSink<BakeState> for PointCounter {
    fn on_progress(&mut self, progress: &glanz_job::JobProgress<'_>) {
        self.first_phase.get_or_insert(progress.step[0]);
    }

    fn checkpoint_interval(&self) -> Option<std::time::Duration> {
        Some(std::time::Duration::ZERO)
    }

    fn on_checkpoint(&mut self, state: &BakeState) {
        self.points = Some(state.points());
    }
}

#[test]
fn interrupted_part_resumes_to_the_same_bits_and_is_not_finished() {
    let scene = room();
    let elements = elements(&scene);
    let own = part(2, 3, false);
    let cancel = CancelFlag::default();
    let whole = bake_part(BakeState::default(), &elements, &COARSE, own, &mut Silent, &cancel).unwrap();
    assert_eq!(whole.parts.as_ref().unwrap().missing().count(), 2);
    for reports in 1.. {
        let cancel = CancelFlag::default();
        let mut stopper = Stopper { reports, cancel: cancel.clone(), last: None };
        let Err(error) = bake_part(BakeState::default(), &elements, &COARSE, own, &mut stopper, &cancel)
        else {
            assert!(reports > 5);
            break;
        };
        assert!(matches!(error, BakeError::Interrupted(_)));
        let state = BakeState::from_bytes(&stopper.last.unwrap().to_bytes()).unwrap();
        let missing: Vec<_> = state.parts.as_ref().unwrap().missing().collect();
        assert_eq!(missing[1], (own.part, true));
        let other = part(1, 3, false);
        let refused =
            bake_part(state.clone(), &elements, &COARSE, other, &mut Silent, &CancelFlag::default());
        assert_eq!(refused.err(), Some(BakeError::State));
        let again = bake_part(state, &elements, &COARSE, own, &mut Silent, &CancelFlag::default());
        assert_eq!(again.unwrap(), whole);
    }
    // A finished part is not computed again.
    let mut sink = PointCounter::default();
    let again = bake_part(whole.clone(), &elements, &COARSE, own, &mut sink, &CancelFlag::default()).unwrap();
    assert!(again == whole && sink.first_phase.is_none());
}

#[test]
fn states_that_contradict_each_other_are_not_joined() {
    let scene = room();
    let elements = elements(&scene);
    let of = |number| {
        let part = part(number, 2, false);
        bake_part(BakeState::default(), &elements, &COARSE, part, &mut Silent, &CancelFlag::default())
            .unwrap()
    };
    let (first, second) = (of(1), of(2));
    assert_eq!(first.clone().merge(first.clone()), Err(BakeConflict::Part(1)));
    let mut other = second.clone();
    other.indirect.as_mut().unwrap()[0] += Spectrum::ONE;
    assert_eq!(first.clone().merge(other), Err(BakeConflict::Light("light between surfaces")));
    let mut other = second.clone();
    // An infinite distance would not change.
    let is_shared = |key: &&u128| first.gathered.get(key).is_some_and(|light| light.distance.is_finite());
    let shared = other.gathered.keys().find(is_shared).copied().unwrap();
    other.gathered.get_mut(&shared).unwrap().distance += 1.0;
    assert_eq!(first.clone().merge(other), Err(BakeConflict::Light("gathered light")));
    // The shares are even: neighbours have few points in common.
    let whole = first.points() + second.points();
    assert!(first.points().abs_diff(second.points()) < whole / 4, "{} {}", first.points(), second.points());
    let refused = bake_part(
        BakeState::default(),
        &elements,
        &BY_RADIOSITY,
        part(1, 2, false),
        &mut Silent,
        &CancelFlag::default(),
    );
    assert_eq!(refused.err(), Some(BakeError::Indivisible));
}

#[test]
fn light_that_varies_smoothly_is_gathered_at_few_texels() {
    let walls = walls(DVec3::splat(2.0)).into_iter().map(|wall| (wall, 0.5, 0.0));
    let light = LightKind::Point { from: DVec3::new(0.9, 1.1, 1.2), range: None };
    let scene = scene_with(walls.collect(), vec![light]);
    let elements = Elements::new(&scene, &ElementSettings { side: 0.3 }).unwrap();
    let state = |density: f64| {
        let settings = BakeSettings { density, rays: 256, ..COARSE };
        let start = BakeState::default();
        let state =
            bake_part(start, &elements, &settings, part(1, 1, false), &mut Silent, &CancelFlag::default())
                .unwrap();
        let maps = resume(state.clone(), &elements, &settings, &mut Silent, &CancelFlag::default());
        (state.points(), maps.unwrap().maps)
    };
    // With few texels nearly all have light of their own; every fourth one of the other maps is at the same point.
    let ((all, coarse), (points, fine)) = (state(10.0), state(40.0));
    let mut compared = 0;
    for (coarse, fine) in coarse.iter().zip(&fine).filter(|(map, _)| !map.is_dark()) {
        assert_eq!((coarse.chart.size, fine.chart.size), ([21, 21], [81, 81]));
        for (i, a) in coarse.irradiance.iter().enumerate() {
            let b = fine.irradiance[4 * (i / 21) * 81 + 4 * (i % 21)];
            assert!((a.max_component() / b.max_component() - 1.0).abs() < 0.02, "{i}: {a:?} {b:?}");
            compared += 1;
        }
    }
    assert_eq!(compared, 6 * 21 * 21);
    // 16 times the texels.
    assert!(points < 6 * all, "{points} {all}");
}
