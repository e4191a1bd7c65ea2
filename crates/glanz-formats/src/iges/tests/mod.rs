//! Small files, with facts that follow from the standard.

mod assemblies;
mod attributes;
mod curves;
mod faces;
mod solids;
mod surfaces;

use glanz_brep::face::trimmed_faces;
use glanz_brep::model::EntityId;
use glanz_math::DVec3;

use super::read;
use crate::cad::BrepFile;
use crate::cad::testing::{self, assert_near, omissions};

/// An entity of a file; the first has the number 1, the next 3, and so on.
#[derive(Clone, Copy, Default)]
struct EntityText<'a> {
    kind: u32,
    form: u32,
    /// Parameters without the type.
    parameters: &'a str,
    matrix: i32,
    color: i32,
    level: u32,
    status: &'a str,
    label: &'a str,
}

/// An entity without attributes.
fn entity(kind: u32, form: u32, parameters: &str) -> EntityText<'_> {
    EntityText { kind, form, parameters, ..EntityText::default() }
}

/// The text of a file in metres with a resolution of 1e-6.
fn text(entities: &[EntityText<'_>]) -> String {
    text_with_global(",,4Hpart,,,,32,38,6,308,15,,1.,6,1HM,1,0.01,,1E-6,1.,,,11,0,;", entities)
}

fn text_with_global(global: &str, entities: &[EntityText<'_>]) -> String {
    let mut text = format!("{:<72}S0000001\n", "A test.");
    let chunks = |text: &str, width: usize| -> Vec<String> {
        text.as_bytes().chunks(width).map(|chunk| String::from_utf8(chunk.to_vec()).unwrap()).collect()
    };
    for (i, line) in chunks(global, 72).iter().enumerate() {
        text += &format!("{line:<72}G{:07}\n", i + 1);
    }
    let (mut directory, mut parameters, mut line) = (String::new(), String::new(), 1);
    for (i, entity) in entities.iter().enumerate() {
        let number = 2 * i + 1;
        let lines = chunks(&format!("{},{};", entity.kind, entity.parameters), 64);
        let EntityText { kind, form, matrix, color, level, status, label, .. } = *entity;
        let status = if status.is_empty() { "00000000" } else { status };
        directory +=
            &format!("{kind:8}{line:8}{:8}{:8}{level:8}{:8}{matrix:8}{:8}{status}D{number:07}\n", 0, 0, 0, 0);
        directory += &format!(
            "{kind:8}{:8}{color:8}{:8}{form:8}{:8}{:8}{label:>8}{:8}D{:07}\n",
            0,
            lines.len(),
            "",
            "",
            0,
            number + 1
        );
        for part in &lines {
            parameters += &format!("{part:<64}{number:8}P{line:07}\n");
            line += 1;
        }
    }
    text + &directory + &parameters + &format!("{:<72}T0000001\n", "S      1G      1")
}

fn file(entities: &[EntityText<'_>]) -> BrepFile {
    read(text(entities).as_bytes()).unwrap()
}

/// A file in which nothing is wrong.
fn clean(entities: &[EntityText<'_>]) -> BrepFile {
    testing::clean(file(entities))
}

/// The areas of all faces, none of which needs a repair.
fn areas(file: &BrepFile) -> Vec<f64> {
    let trimmed = trimmed_faces(&file.model);
    let faces = trimmed.faces.iter().map(|face| face.as_ref().unwrap());
    faces
        .map(|face| {
            assert_eq!(face.repairs, []);
            face.measure(1e-9).area
        })
        .collect()
}

fn assert_close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-6 * expected.abs(), "{value} is not {expected}");
}

#[test]
fn files_without_directory_or_in_compressed_form_are_refused() {
    let message = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(message(b"solid").contains("it is no IGES file"));
    let whole = text(&[entity(116, 0, "0.,0.,0.")]);
    let cut: String = whole.lines().take(2).map(|line| format!("{line}\n")).collect();
    assert!(message(cut.as_bytes()).contains("no directory entries"));
    let compressed = whole.replacen("S0000001", "C0000001", 1);
    assert!(message(compressed.as_bytes()).contains("compressed form"));
}

#[test]
fn records_may_lack_ends_of_lines_and_have_carriage_returns() {
    let lines = text(&[entity(128, 0, BILINEAR)]);
    for text in [lines.replace('\n', "\r\n"), lines.replace('\n', "")] {
        let file = read(text.as_bytes()).unwrap();
        assert_eq!((file.report.faces.read, file.report.faults.count()), (1, 0));
    }
}

#[test]
fn damaged_records_are_faults_with_line_and_column() {
    let text = text(&[entity(128, 0, BILINEAR), entity(116, 0, "1.,2x,0.")]);
    let file = read(text.replacen("S0000001", "S0000001\nstray", 1).as_bytes()).unwrap();
    let faults: Vec<String> = file.report.faults.notes().iter().map(ToString::to_string).collect();
    let line = text.lines().position(|line| line.starts_with("116,1.,2x")).unwrap() + 2;
    assert_eq!(
        faults,
        [
            "2:6: the record has no section in column 73; it is left out".to_owned(),
            format!("{line}:8: #3: this is neither a number nor a text"),
        ]
    );
}

#[test]
fn lost_record_of_the_directory_costs_one_entry() {
    let whole = text(&[entity(116, 0, "0.,0.,0."), entity(128, 0, BILINEAR), entity(128, 0, BILINEAR)]);
    for lost in ["D0000001", "D0000002"] {
        let lines: Vec<&str> = whole.lines().filter(|line| !line.ends_with(lost)).collect();
        let report = read(lines.join("\n").as_bytes()).unwrap().report;
        assert_eq!((report.faces.read, report.faults.count(), report.omissions.count()), (2, 1, 0));
    }
}

#[test]
fn lost_record_of_parameters_costs_one_entity() {
    // Two records each.
    let whole = text(&[entity(128, 0, BILINEAR), entity(128, 0, BILINEAR)]);
    for (lost, fault) in [
        (1, "#1: its parameters are in record 1, which is missing"),
        (2, "#1: record 2 of the parameters is missing"),
        (4, "#3: record 4 of the parameters is missing"),
    ] {
        let lines = whole.lines().filter(|line| !line.ends_with(&format!("P{lost:07}")));
        let lines: Vec<&str> = lines.collect();
        let report = read(lines.join("\n").as_bytes()).unwrap().report;
        assert_eq!((report.faces.read, report.faces.refused, report.faults.count()), (1, 1, 1));
        assert!(report.faults.notes()[0].to_string().contains(fault), "{:?}", report.faults);
    }
}

#[test]
fn parameters_of_another_type_are_not_taken() {
    let whole = text(&[entity(128, 0, BILINEAR), entity(116, 0, "0.,0.,0.")]);
    let shared = whole.replacen("     116       3", "     116       1", 1);
    assert_ne!(whole, shared);
    let file = read(shared.as_bytes()).unwrap();
    let faults: Vec<String> = file.report.faults.notes().iter().map(ToString::to_string).collect();
    assert!(
        faults.len() == 1 && faults[0].contains("#3: the parameters are not those of an entity of type 116")
    );
}

#[test]
fn units_and_scale_make_metres() {
    let global = ",,4Hpart,,,,32,38,6,308,15,,0.5,2,2HMM,1,0.01,,0.25,1.,,,11,0,;";
    let text = text_with_global(global, &[entity(128, 0, BILINEAR)]);
    let file = read(text.as_bytes()).unwrap();
    assert_eq!((file.model.uncertainty, file.model.length_unit), (5e-4, Some(2e-3)));
    // A square of 1 unit, which is 1 mm, in a model of half its size.
    let trimmed = trimmed_faces(&file.model);
    assert_close(trimmed.faces[0].as_ref().unwrap().measure(1e-9).area, 4e-6);
    assert_eq!(file.model.parts[0].name, "part");
}

/// The unit square as a spline of degree 1.
const BILINEAR: &str =
    "1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,0.,0.,0.,1.,0.,0.,0.,1.,0.,1.,1.,0.,0.,1.,0.,1.";

fn id(number: u64) -> EntityId {
    EntityId(number)
}
