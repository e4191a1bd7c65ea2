//! What the tests of all CAD formats share: checks of files, and damage to them.

use glanz_math::DVec3;
use glanz_scene::Description;
use proptest::prelude::*;
use proptest::sample::Index;

use super::{BrepFile, CadModel};

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

/// A change of a file: its place, its kind, the index of a byte with a meaning, and any byte or number of bytes.
type Change = (Index, u8, Index, u8);

/// The changes of a damaged file.
pub(crate) fn changes() -> impl Strategy<Value = Vec<Change>> {
    prop::collection::vec((any::<Index>(), 0_u8..6, any::<Index>(), any::<u8>()), 1..8)
}

/// A file after some changes; `meaningful`: the bytes that mean something in its format.
pub(crate) fn damaged(mut bytes: Vec<u8>, changes: Vec<Change>, meaningful: &[u8]) -> Vec<u8> {
    for (at, kind, byte, any) in changes {
        let at = at.index(bytes.len());
        let meaningful = *byte.get(meaningful);
        match kind {
            // Most changes keep the columns, without which little is read of some formats.
            0..3 => bytes[at] = meaningful,
            3 => bytes[at] = any,
            4 => bytes.insert(at, meaningful),
            _ => drop(bytes.drain(at..(at + usize::from(any)).min(bytes.len() - 1).max(at))),
        }
    }
    bytes
}

/// The settings for `cases` damaged files, which `GLANZ_FUZZ` multiplies.
pub(crate) fn config(cases: u32) -> ProptestConfig {
    let factor: u32 = std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1);
    ProptestConfig::with_cases(cases * factor)
}

/// Checks that a damaged file gives an error, or a model in which everything is counted and exists.
pub(crate) fn check<E>(
    bytes: &[u8],
    read: impl Fn(&[u8]) -> Result<BrepFile, E>,
) -> Result<(), TestCaseError> {
    // What a user runs: a scene.
    if let Ok(model) = CadModel::read(bytes, true) {
        let mut description = Description::default();
        let report = model.into_world(&mut description);
        let groups: usize = description.groups.iter().map(|group| group.shapes.len()).sum();
        prop_assert_eq!(report.shapes.len(), groups + description.world.shapes.len());
    }
    if let Ok(file) = read(bytes) {
        let faces = file.report.faces;
        prop_assert_eq!(faces.total, faces.read + faces.refused + faces.hidden + faces.unreachable);
        let model = &file.model;
        prop_assert!(model.faces.iter().all(|face| face.surface < model.surfaces.len()));
        for (i, part) in model.parts.iter().enumerate() {
            prop_assert!(part.occurrences.iter().all(|occurrence| occurrence.part < i));
        }
    }
    Ok(())
}
