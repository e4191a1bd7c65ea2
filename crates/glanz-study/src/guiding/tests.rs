//! The whole study, in a box of a few pixels.

use std::path::{Path, PathBuf};

use glanz_scene::description::GridSettings;

use super::*;
use crate::study::StudyProgress;
use glanz_job::{CancelFlag, JobProgress, ProgressSink, Silent};
use glanz_report::TableCell;

/// A closed box with a lamp that shines at the ceiling alone.
const BOX: &str = r#"
LookAt 0 -.95 -.1  0 1 -.1  0 0 1
Camera "perspective" "float fov" 75
Integrator "path" "integer maxdepth" 6
WorldBegin
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "box" "point3 min" [ -1 -1 -1 ] "point3 max" [ 1 1 1 ]
AreaLightSource "diffuse" "rgb L" [ 6 6 6 ]
Shape "bilinearmesh" "point3 P" [ -.4 0 .3  .4 0 .3  -.4 .8 .3  .4 .8 .3 ]
"#;

/// A folder that is removed when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glanz-study-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        std::fs::write(path.join("box.pbrt"), BOX).unwrap();
        Self(path)
    }

    fn has(&self, name: &str) -> bool {
        self.0.join("out").join(name).is_file()
    }

    fn kept(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join("out/kept")).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn settings(folder: &Path) -> Settings {
    Settings {
        rooms: Some(vec![folder.join("box.pbrt").display().to_string()]),
        size: Some([16, 12]),
        samples: Some(16),
        references: Some(256),
        methods: Some(["tree", "haar-8-3"].map(str::to_owned).into()),
        rounds: Some(2),
        seconds: Some(0.05),
        threads: Some(1),
        cache: Some(folder.join("out")),
        ..Settings::default()
    }
}

#[test]
fn study_of_a_box_writes_tables_plots_and_pictures() {
    let folder = Folder::new("all");
    let settings = settings(&folder.0);
    let report = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap();
    let names = report.write(&folder.0.join("out")).unwrap();
    for name in ["summary.csv", "speed_up.csv", "speed_ups.csv", "curves.csv", "frozen.csv", "report.md"] {
        assert!(names.iter().any(|n| n == name) && folder.has(name), "{name}");
    }
    for plot in ["samples", "time", "l2", "frozen"] {
        assert!(folder.has(&format!("{plot}_bases_box_lights.svg")), "{plot}");
        assert!(folder.has(&format!("{plot}_bases_box_chance.svg")), "{plot}");
    }
    assert!(folder.has("equal_time_box.png"));
    let summary = report.summary();
    assert_eq!(summary.rows().len(), 2 * 3);
    assert!(summary.rows().iter().all(|row| row[3] == TableCell::Count(16)));

    // Errors fall as samples come; those of densities without the BSDF beside them have outliers for long.
    let curves = report.tables().find(|table| table.name() == "curves").unwrap();
    let error = |row: &[TableCell]| match row[6] {
        TableCell::Number(error) => error,
        _ => f64::NAN,
    };
    assert_eq!(curves.rows().len(), 5 * summary.rows().len());
    for curve in curves.rows().chunks(5).take(4) {
        assert!(error(&curve[4]) < 0.7 * error(&curve[0]), "{curve:?}");
    }
    // Without light sampling there is more noise.
    assert!(error(&curves.rows()[4]) > error(&curves.rows()[9]));

    // Times are part of the report: only what is kept can give them again.
    let again = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap();
    assert_eq!(again.markdown(), report.markdown());
}

/// Cancels when a room is rendered by some method.
struct Stopper<'a>(&'a CancelFlag, &'static str);

impl ProgressSink for Stopper<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        if progress.phase.contains(self.1) {
            self.0.cancel();
        }
    }
}

#[test]
fn a_study_that_was_stopped_goes_on_where_it_was() {
    let folder = Folder::new("stopped");
    let settings = settings(&folder.0);
    let mut stopper = Stopper(&settings.cancel, "tree");
    let stopped = run(&settings, &mut StudyProgress::new(&mut stopper));
    assert!(matches!(stopped, Err(StudyError::Interrupted(_))));
    let before = folder.kept();
    assert!(before.iter().any(|name| name.starts_with("reference-box-16x12-")), "{before:?}");
    assert!(before.iter().any(|name| name.contains("-path-chance-1")), "{before:?}");
    assert!(before.iter().all(|name| !name.contains("-tree-")), "{before:?}");
    let again = Settings { cancel: CancelFlag::default(), ..settings };
    // The reference is there: its samples are not taken again.
    let mut stopper = Stopper(&again.cancel, "reference");
    let done = run(&again, &mut StudyProgress::new(&mut stopper));
    assert!(done.is_ok() && folder.kept().len() > before.len());
}

#[test]
fn more_samples_add_to_the_reference_and_measure_again() {
    let folder = Folder::new("more");
    let first = Settings { rounds: None, ..settings(&folder.0) };
    let one = run(&first, &mut StudyProgress::new(&mut Silent)).unwrap();
    let two =
        run(&Settings { references: Some(512), ..first }, &mut StudyProgress::new(&mut Silent)).unwrap();
    let errors =
        |report: &Report| report.summary().rows().iter().map(|row| row[5].clone()).collect::<Vec<_>>();
    assert_ne!(errors(&one), errors(&two));
    assert!(two.markdown().contains("512 samples"));
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let folder = Folder::new("refused");
    let refused = |settings: Settings, told: &str| {
        let error = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap_err();
        assert!(error.to_string().contains(told), "{error}");
    };
    let sound = || Settings { cache: None, ..settings(&folder.0) };
    refused(Settings { samples: Some(12), ..sound() }, "power of two");
    refused(Settings { methods: Some(vec!["haar".into()]), ..sound() }, "haar-8-3");
    refused(Settings { rooms: Some(vec!["cellar".into()]), ..sound() }, "scenes/rooms");
    let room = |name: &str, text: &str| {
        let path = folder.0.join(name);
        std::fs::write(&path, text).unwrap();
        Settings { rooms: Some(vec![path.display().to_string()]), ..sound() }
    };
    refused(room("broken.pbrt", "WorldBegin Shape \"sphere\" \"float radius\" [ 1"), "broken.pbrt");
    refused(room("point.pbrt", "WorldBegin LightSource \"point\""), "lit by surfaces alone");
}

#[test]
fn grid_too_large_for_the_room_is_omitted_with_a_note() {
    let folder = Folder::new("large");
    let settings = Settings { cache: None, samples: Some(2), references: Some(4), ..settings(&folder.0) };
    // 30 shapes with 64 x 64 cells of 64 x 64 coefficients each.
    let spheres = "Shape \"sphere\" \"float radius\" .01\n".repeat(30);
    std::fs::write(folder.0.join("box.pbrt"), BOX.to_owned() + &spheres).unwrap();
    let mut plan = GuidingPlan::new(&settings).unwrap();
    let grid = GridSettings { cells: 64, scale: 6, ..GridSettings::default() };
    let large = MethodEntry { method: RenderMethod::of(grid), samples: 2, frozen: vec![2] };
    plan.entries = vec![MethodEntry { method: RenderMethod::path(), samples: 2, frozen: Vec::new() }, large];
    let report = run_plan(&plan, &settings, &mut StudyProgress::new(&mut Silent)).unwrap();
    assert_eq!(report.summary().rows().len(), 2);
    assert!(report.markdown().contains("Left out of room box: the guide grid=64"), "{}", report.markdown());
}
