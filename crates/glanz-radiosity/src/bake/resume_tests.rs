//! Bakes that stop and go on.

use glanz_math::DVec3;
use glanz_scene::description::GeometryDescription;

use super::*;
use crate::elements::ElementSettings;
use crate::form_factor::FormFactors;
use crate::scenes::{parallelogram, scene, walls};
use crate::solve::{GaussSeidel, gauss_seidel};

const COARSE: BakeSettings = BakeSettings { density: 5.0, rays: 64, shadow_rays: 64 };

/// A room with a lamp, a box and a ball.
fn room() -> Scene {
    let mut shapes: Vec<_> = walls(DVec3::new(2.0, 2.0, 1.5)).into_iter().map(|w| (w, 0.7, 0.0)).collect();
    shapes.push((parallelogram(DVec3::new(0.5, 0.5, 1.4), DVec3::Y, DVec3::X), 0.3, 2.0));
    let cuboid =
        GeometryDescription::Cuboid { min: DVec3::new(0.4, 0.3, 0.0), max: DVec3::new(0.9, 0.8, 0.6) };
    shapes.push((cuboid, 0.5, 0.0));
    let phi_max = std::f64::consts::TAU;
    shapes.push((GeometryDescription::Sphere { radius: 0.4, z: [-0.4, 0.4], phi_max }, 0.6, 0.0));
    scene(shapes)
}

fn elements(scene: &Scene) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side: 0.5 }).unwrap()
}

fn assert_same(a: &[LightMap], b: &[LightMap]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_eq!(
            (a.is_hidden, &a.irradiance, &a.radiance, a.chart.size),
            (b.is_hidden, &b.irradiance, &b.radiance, b.chart.size)
        );
    }
}

/// Bakes until it was asked `asked` times; the light, or what was found.
fn until(
    asked: usize,
    elements: &Elements<'_>,
    radiosity: Option<&[Spectrum]>,
    state: BakeState,
) -> Result<Vec<LightMap>, BakeState> {
    let (mut count, mut last) = (0, BakeState::default());
    let go_on = &mut |report: &BakeReport<'_>| {
        count += 1;
        if count == asked {
            last = report.state();
        }
        count < asked
    };
    match go_on_with(state, elements, radiosity, &COARSE, go_on) {
        Ok(maps) => Ok(maps),
        Err(error) => {
            assert_eq!(error, BakeError::Stopped);
            Err(last)
        }
    }
}

#[test]
fn stopped_bake_comes_to_the_same_bits_from_any_moment() {
    let scene = room();
    let elements = elements(&scene);
    let whole = bake(&elements, None, &COARSE, &mut |_, _| true).unwrap();
    let mut stages = Vec::new();
    let mut asked = 1;
    loop {
        let state = match until(asked, &elements, None, BakeState::default()) {
            Ok(maps) => {
                assert_same(&maps, &whole);
                break;
            }
            Err(state) => state,
        };
        stages.push((state.indirect.is_some(), state.places()));
        let read = BakeState::from_bytes(&state.to_bytes()).unwrap();
        assert_eq!(read, state);
        assert_same(&until(usize::MAX, &elements, None, read).unwrap(), &whole);
        asked += 1;
    }
    // Moments before the final gather, at its beginning and within it.
    assert!(stages.contains(&(false, 0)) && stages.contains(&(true, 0)), "{stages:?}");
    assert!(stages.iter().any(|(_, places)| *places > 100), "{stages:?}");
    assert!(stages.is_sorted());
}

#[test]
fn bake_that_stops_again_and_again_arrives() {
    let scene = room();
    let elements = elements(&scene);
    let factors = FormFactors::new(&elements, |_| true).unwrap();
    let solved = gauss_seidel(&elements.list, &factors, &GaussSeidel::default(), |_, _| true);
    let radiosity = Some(solved.radiosity.as_slice());
    let whole = bake(&elements, radiosity, &COARSE, &mut |_, _| true).unwrap();
    let (mut state, mut asked) = (BakeState::default(), 1);
    let maps = loop {
        match until(asked, &elements, radiosity, state) {
            Ok(maps) => break maps,
            Err(found) => (state, asked) = (found, asked + 1),
        }
    };
    assert_same(&maps, &whole);
}

#[test]
fn what_was_found_is_not_found_again() {
    let scene = room();
    let elements = elements(&scene);
    let mut last = BakeState::default();
    let keep = &mut |report: &BakeReport<'_>| {
        last = report.state();
        true
    };
    go_on_with(BakeState::default(), &elements, None, &COARSE, keep).unwrap();
    let before = last.places();
    let mut stages = Vec::new();
    let go_on = &mut |report: &BakeReport<'_>| {
        stages.push(report.stage);
        true
    };
    go_on_with(last, &elements, None, &COARSE, go_on).unwrap();
    assert!(before > 100 && !stages.contains(&Stage::Between));
}

#[test]
fn state_of_something_else_is_refused() {
    let scene = room();
    let elements = elements(&scene);
    let other = BakeState { indirect: Some(vec![Spectrum::ONE; 3]), ..BakeState::default() };
    let refused = go_on_with(other.clone(), &elements, None, &COARSE, &mut |_| true);
    assert_eq!(refused.err(), Some(BakeError::State));
    let bytes = other.to_bytes();
    assert!((0..bytes.len()).all(|length| BakeState::from_bytes(&bytes[..length]).is_none()));
    let mut longer = bytes;
    longer.push(0);
    assert!(BakeState::from_bytes(&longer).is_none());
}

#[test]
fn stored_maps_are_the_maps() {
    let scene = room();
    let elements = elements(&scene);
    let maps = bake(&elements, None, &COARSE, &mut |_, _| true).unwrap();
    let bytes = stored::to_bytes(&maps);
    assert_same(&stored::from_bytes(&elements, COARSE.density, &bytes).unwrap(), &maps);
    assert!(stored::from_bytes(&elements, 2.0 * COARSE.density, &bytes).is_none());
    for length in (0..bytes.len()).step_by(97) {
        assert!(stored::from_bytes(&elements, COARSE.density, &bytes[..length]).is_none());
    }
}
