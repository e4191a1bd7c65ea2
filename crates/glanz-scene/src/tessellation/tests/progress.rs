//! Progress and cancelling.

use std::sync::atomic::{AtomicBool, Ordering};

use glanz_job::CancelFlag;

use super::*;

/// Shapes with one patch, with several, with none, and one that is left out.
fn shapes() -> Description {
    let triangle = GeometryDescription::Triangles {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        indices: vec![[0, 1, 2]],
        normals: None,
        uvs: None,
    };
    let shapes = vec![ShapeDescription::sphere(1.0), triangle.into(), ShapeDescription::plane(), patches()];
    let ball = GroupDescription { shapes: vec![ShapeDescription::sphere(1.0)], ..Default::default() };
    let world = GroupDescription { shapes, ..Default::default() };
    Description { groups: vec![ball], world, ..Description::default() }
}

fn patches() -> ShapeDescription {
    let flat =
        |x: f64| [[x, 0.0], [x, 1.0], [x + 1.0, 0.0], [x + 1.0, 1.0]].map(|[x, y]| [x, y, 0.0, 1.0]).to_vec();
    let patches = (0..5).map(|i| flat(f64::from(i))).collect();
    GeometryDescription::BezierPatches(BezierPatchesDescription { degree_u: 1, degree_v: 1, patches }).into()
}

#[test]
fn all_of_the_work_is_counted_once() {
    // Edges of the crescent are sampled several times.
    let crescent = GroupDescription { shapes: crossing::crescent(0.1, 0.08), ..Default::default() };
    let narrow = Description { world: crescent, ..Description::default() };
    for (description, deviation) in [(shapes(), 1e-3), (narrow, 0.15)] {
        let progress = TessellationProgress::default();
        assert_eq!(progress.fraction(), 0.0);
        SceneTessellation::try_new(&description, settings(deviation), &progress).unwrap();
        let [done, total] = progress.counts();
        assert!(done <= total && progress.fraction() > 0.999, "{done} of {total}");
    }
}

#[test]
fn filling_ends_when_it_is_cancelled() {
    let shapes = vec![ShapeDescription::torus(2.0, 0.7); 40];
    let description =
        Description { world: GroupDescription { shapes, ..Default::default() }, ..Default::default() };
    let cancel = CancelFlag::default();
    let progress = TessellationProgress::new(cancel.clone());
    let is_over = AtomicBool::new(false);
    // As many patches as threads are filled when the end is requested.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // Half is done only while patches are filled.
            while progress.fraction() < 0.5 && !is_over.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            cancel.cancel();
        });
        let made = pool.install(|| SceneTessellation::try_new(&description, settings(1e-3), &progress));
        is_over.store(true, Ordering::Relaxed);
        assert_eq!(made.err(), Some(TessellationError::Interrupted(Interrupted)));
    });
    assert!(progress.fraction() < 0.9, "{}", progress.fraction());
}

#[test]
fn a_cancelled_tessellation_has_no_result() {
    let cancel = CancelFlag::default();
    let progress = TessellationProgress::new(cancel.clone());
    assert!(SceneTessellation::try_new(&shapes(), settings(0.1), &progress).is_ok());
    cancel.cancel();
    let made = SceneTessellation::try_new(&shapes(), settings(0.1), &progress);
    assert_eq!(made.err(), Some(TessellationError::Interrupted(Interrupted)));
}
