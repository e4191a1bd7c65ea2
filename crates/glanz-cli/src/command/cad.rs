//! The part of `glanz info` about CAD files.

use std::collections::BTreeMap;
use std::fmt::Write;

use glanz::formats::cad::{CadFace, CadFaceOutcome, CadReport, NoteList};
use serde::Serialize;

use crate::report::grouped;

/// A CAD file in the output of `--json`.
#[derive(Serialize)]
pub(super) struct CadSummary {
    schemas: Vec<String>,
    /// Distance below which points of the file are meant to coincide, metres.
    uncertainty: f64,
    /// Largest distance by which faces extend beyond an edge, metres.
    overlap: f64,
    faces_in_file: usize,
    faces_hidden: usize,
    faces_unreachable: usize,
    faces: Vec<FaceSummary>,
    /// Entities that are left out, damaged, or read other than the file says: the first ones, and how many more there are.
    omissions: Vec<String>,
    faults: Vec<String>,
    repairs: Vec<String>,
}

/// The outcome for a face.
#[derive(Serialize)]
struct FaceSummary {
    entity: u64,
    kind: &'static str,
    status: &'static str,
    /// Repairs, or the reason of a refusal.
    notes: Vec<String>,
    /// Largest distance by which it extends beyond an edge, metres.
    overlap: f64,
}

impl From<&CadFace> for FaceSummary {
    fn from(face: &CadFace) -> Self {
        let (status, notes) = match &face.outcome {
            CadFaceOutcome::Read => ("read", Vec::new()),
            CadFaceOutcome::Repaired(repairs) => ("repaired", repairs.clone()),
            CadFaceOutcome::Refused(reason) => ("refused", vec![reason.clone()]),
        };
        Self { entity: face.entity.0, kind: face.kind, status, notes, overlap: face.width }
    }
}

impl From<&CadReport> for CadSummary {
    fn from(report: &CadReport) -> Self {
        let notes = |list: &NoteList| {
            let rest = list.count().saturating_sub(list.notes().len());
            let rest = (rest > 0).then(|| format!("{} more, which are not listed", grouped(rest as u64)));
            list.notes().iter().map(ToString::to_string).chain(rest).collect()
        };
        let reading = &report.reading;
        Self {
            schemas: reading.schemas.clone(),
            uncertainty: report.uncertainty,
            overlap: report.width(),
            faces_in_file: reading.faces.total,
            faces_hidden: reading.faces.hidden,
            faces_unreachable: reading.faces.unreachable,
            faces: report.faces.iter().map(FaceSummary::from).collect(),
            omissions: notes(&reading.omissions),
            faults: notes(&reading.faults),
            repairs: notes(&reading.repairs),
        }
    }
}

impl CadSummary {
    /// Lines for a reader; `verbose`: with repairs and what is left out.
    pub(super) fn text(&self, verbose: bool) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            // Writing to a text cannot fail.
            let _ = writeln!(text, "{name:<12} {value}");
        };
        let count = |status: &str| self.faces.iter().filter(|face| face.status == status).count();
        let lost = self.faces_in_file - self.faces.len().min(self.faces_in_file) + count("refused");
        line(
            "faces",
            &format!(
                "{} in the file: {} read, {} repaired, {} left out ({} hidden, {} not shown by the file)",
                grouped(self.faces_in_file as u64),
                grouped(count("read") as u64),
                grouped(count("repaired") as u64),
                grouped(lost as u64),
                self.faces_hidden,
                self.faces_unreachable
            ),
        );
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        for face in &self.faces {
            *kinds.entry(face.kind).or_default() += 1;
        }
        let kinds: Vec<String> =
            kinds.iter().map(|(kind, count)| format!("{} {kind}", grouped(*count as u64))).collect();
        line("kinds", &kinds.join(", "));
        line("uncertainty", &format!("{:.1e} m", self.uncertainty));
        line("overlap", &format!("{:.1e} m at most", self.overlap));
        line("schema", &self.schemas.join(", "));
        if verbose {
            for face in self.faces.iter().filter(|face| !face.notes.is_empty()) {
                for note in &face.notes {
                    line(face.status, &format!("face #{} ({}): {note}", face.entity, face.kind));
                }
            }
            let lists = [("omitted", &self.omissions), ("damaged", &self.faults), ("mended", &self.repairs)];
            for (name, notes) in lists {
                notes.iter().for_each(|note| line(name, note));
            }
        }
        text
    }
}
