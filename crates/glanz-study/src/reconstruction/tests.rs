//! The whole study at a small size.

use super::*;
use crate::study::StudyProgress;
use glanz_job::Silent;
use glanz_report::{Table, TableCell};

fn number(table: &Table, row: usize, key: &str) -> f64 {
    let column = table.columns().iter().position(|c| c.key == key).unwrap();
    match &table.rows()[row][column] {
        TableCell::Number(number) => *number,
        TableCell::Count(count) => *count as f64,
        other => panic!("{key}: {other:?}"),
    }
}

#[test]
fn six_scenes_are_measured_and_reported() {
    let settings = Settings { size: Some([32, 32]), ..Settings::default() };
    let report = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap();
    assert_eq!(report.summary().rows().len(), 12);
    let named = |name: &str| report.tables().find(|table| table.name() == name).unwrap();
    // Borders on borders of elements: constant values are right but for light that fades, and all else smears them.
    let on = named("table_f_5");
    assert!(number(on, 0, "l2") < 0.5 * number(on, 1, "l2"));
    // Through the middles of elements, each of these is off by half the step.
    let through = named("table_f_7");
    assert!(number(through, 0, "linf") > 0.3);
    // Natural neighbours never leave the range of the elements; splines do at hard shadows.
    for table in (1..=12).map(|i| named(&format!("table_f_{i}"))) {
        let last = table.rows().len() - 1;
        assert_eq!((number(table, last, "above"), number(table, last, "below")), (0.0, 0.0));
        // Their cells end at the sides of the floor: samples there change little.
        let ratio = number(table, last, "l2") / number(table, last - 3, "l2");
        assert!((ratio - 1.0).abs() < 0.02, "{}: {ratio}", table.name());
    }
    assert!(number(through, 2, "below") > 0.02);
    // A quadtree is finer where the shadow ends: values of elements are nearer to the reference than on the grid.
    assert!(number(named("table_f_8"), 0, "l2") < 0.6 * number(through, 0, "l2"));
    let text = report.markdown();
    assert!(text.contains("## Ranking") && text.contains("(border_f_32.png)"), "{text}");
    assert!(text.contains("0.0395"), "document 003's figures stand beside ours");
}

#[test]
fn textures_smaller_than_the_grid_are_refused() {
    let settings = Settings { size: Some([400, 15]), ..Settings::default() };
    assert!(matches!(
        run(&settings, &mut StudyProgress::new(&mut Silent)),
        Err(StudyError::Setting { name: "size", .. })
    ));
}
