//! The whole study at a small size.

use super::*;
use crate::study::StudyProgress;
use glanz_job::Silent;
use glanz_report::{Table, TableCell};
use std::path::PathBuf;

/// A box with a lamp and a block in it.
const BOX: &str = r#"
WorldBegin
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "box" "point3 min" [ -1 -1 -1 ] "point3 max" [ 1 1 1 ]
Shape "box" "point3 min" [ -.4 -.3 -1 ] "point3 max" [ .2 .3 -.5 ]
AreaLightSource "diffuse" "rgb L" [ 6 6 6 ]
Shape "bilinearmesh" "point3 P" [ -.4 0 .8  -.4 .8 .8  .4 0 .8  .4 .8 .8 ]
"#;

/// A file that is removed when the test ends.
struct File(PathBuf);

impl File {
    fn new(name: &str, text: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glanz-{}-{name}.pbrt", std::process::id()));
        std::fs::write(&path, text).unwrap();
        Self(path)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn column(table: &Table, key: &str) -> Vec<Option<f64>> {
    let column = table.columns().iter().position(|c| c.key == key).unwrap();
    let number = |cell: &TableCell| match cell {
        TableCell::Number(number) | TableCell::Precise(number) => Some(*number),
        TableCell::Count(count) => Some(*count as f64),
        _ => None,
    };
    table.rows().iter().map(|row| number(&row[column])).collect()
}

#[test]
fn box_is_solved_in_all_ways() {
    let file = File::new("solvers", BOX);
    let settings = Settings {
        rooms: Some(vec![file.0.display().to_string()]),
        elements: Some(300),
        ..Settings::default()
    };
    let report = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap();
    let named = |name: &str| report.tables().find(|table| table.name() == name).unwrap();
    assert_eq!(report.summary().rows().len(), 3);
    let [rays, ends] = ["rays_exponent", "elements_max"].map(|key| column(report.summary(), key));
    // Pairs grow with the square.
    assert!((rays[0].unwrap() - 2.0).abs() < 0.5, "{rays:?}");
    assert!(ends[0].unwrap() <= 300.0 && ends[2].unwrap() > 1000.0, "{ends:?}");
    let runs = named("runs");
    let of = |solver: &str, key: &str| -> Vec<Option<f64>> {
        let rows = runs.rows().iter().zip(column(runs, key));
        rows.filter(|(row, _)| row[1] == TableCell::from(solver)).map(|(_, value)| value).collect()
    };
    // The finest by all pairs is the reference, and the second finest nearer to it than the coarsest.
    let errors = of("all pairs", "error");
    let count = errors.len();
    assert!(count > 2 && errors[count - 1].is_none() && errors[count - 2] < errors[0], "{errors:?}");
    let links = of("hierarchical", "error");
    assert!(links.last().unwrap().unwrap() < 0.7 * links[0].unwrap(), "{links:?}");
    assert!(links.last().unwrap().unwrap() < 0.2, "{links:?}");
    let others = of("all pairs", "links_error");
    assert!(
        others[count - 1] < others[0] && of("hierarchical", "links_error").pop() == Some(None),
        "{others:?}"
    );
    // A tenth of the light is unshot where shooting ends.
    assert!(of("progressive", "unfinished").iter().all(|off| (0.001..0.3).contains(&off.unwrap())));

    let furnaces = named("furnaces");
    assert_eq!(furnaces.rows().len(), 9);
    for (row, mean) in column(furnaces, "mean").into_iter().enumerate() {
        let off = (mean.unwrap() - 1.0).abs();
        // All pairs, shooting that stops early, and links with a bound of 1e-3 whose last sweep changed 1e-4, of which a tenth is lost at each bounce.
        assert!(off < [1e-5, 0.15, 5e-3][row % 3], "{row}: {off}");
    }
    for key in ["sum_min", "sum_max"] {
        assert!(column(furnaces, key).into_iter().flatten().all(|sum| (sum - 1.0).abs() < 1e-4));
    }

    let convergence = named("convergence");
    let [shot, ambient] = ["error", "error_with_ambient"].map(|key| column(convergence, key));
    let shot: Vec<f64> = shot.into_iter().flatten().collect();
    let ambient: Vec<f64> = ambient.into_iter().flatten().collect();
    assert!(shot.last().unwrap() < &0.01 && shot[0] > 20.0 * shot.last().unwrap(), "{shot:?}");
    // While light is on its way, the estimate of it helps.
    let early = |curve: &[f64]| curve[3..12].iter().sum::<f64>();
    assert!(early(&ambient) < 0.8 * early(&shot), "{shot:?} {ambient:?}");
    let text = report.markdown();
    assert!(text.contains("(time_glanz-") && text.contains("times less"), "{text}");
}

#[test]
fn unknown_rooms_are_refused() {
    let settings = Settings { rooms: Some(vec!["cellar".to_owned()]), ..Settings::default() };
    assert!(matches!(
        run(&settings, &mut StudyProgress::new(&mut Silent)),
        Err(StudyError::Setting { name: "rooms", .. })
    ));
}
