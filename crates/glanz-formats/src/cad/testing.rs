//! What the tests of all CAD formats share.

use glanz_math::DVec3;

use super::BrepFile;

/// The file, in which nothing is wrong.
pub(crate) fn clean(file: BrepFile) -> BrepFile {
    let report = &file.report;
    for list in [&report.faults, &report.omissions, &report.repairs] {
        assert_eq!(list.notes(), []);
    }
    assert_eq!(report.faces.total, report.faces.read);
    file
}

/// The reasons of what is left out.
pub(crate) fn omissions(file: &BrepFile) -> Vec<String> {
    file.report.omissions.notes().iter().map(ToString::to_string).collect()
}

pub(crate) fn assert_near(a: DVec3, b: DVec3) {
    assert!(a.distance(b) <= 1e-12 * (1.0 + b.length()), "{a} is not {b}");
}
