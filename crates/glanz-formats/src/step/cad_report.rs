//! The outcome for each face of a CAD file.

use glanz_brep::face::{FaceGeometry, TrimmedFaces};
use glanz_brep::model::{BrepModel, EntityId};

use super::report::{StepFile, StepReport};

/// The outcome of reading a CAD file.
#[derive(Clone, Debug)]
pub struct CadReport {
    /// What was read of the file.
    pub reading: StepReport,
    /// Distance below which points of the file are meant to coincide, metres.
    pub uncertainty: f64,
    /// The faces that were read.
    pub faces: Vec<CadFace>,
    /// The face of each shape of the description, by its index in `faces`: shapes of the groups in their order, then those of the world.
    pub shapes: Vec<usize>,
}

/// The outcome for a face.
#[derive(Clone, Debug)]
pub struct CadFace {
    /// Its number in the file.
    pub entity: EntityId,
    /// Its name; may be empty.
    pub name: String,
    /// The kind of surface that rays meet: `plane`, `cylinder`, ...; that of the file where it is refused.
    pub kind: &'static str,
    /// What was done.
    pub outcome: CadFaceOutcome,
    /// Largest distance by which it extends beyond an edge, metres.
    pub width: f64,
}

/// What was done with a face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CadFaceOutcome {
    /// It is in the scene as it is in the file.
    Read,
    /// It is in the scene after repairs.
    Repaired(Vec<String>),
    /// It is left out.
    Refused(String),
}

/// A warning about a CAD file.
#[derive(Clone, Debug)]
pub(crate) struct CadWarning {
    pub(crate) kind: &'static str,
    /// Line and column from 1, if it is about a place in the text.
    pub(crate) position: Option<(u32, u32)>,
    pub(crate) message: String,
}

impl CadReport {
    /// The report of a file whose faces were trimmed, before shapes are made of them.
    pub(super) fn new(file: &StepFile, trimmed: &TrimmedFaces) -> Self {
        let model: &BrepModel = &file.model;
        let faces = model.faces.iter().zip(&trimmed.faces).map(|(face, trimmed)| {
            let (kind, outcome, width) = match trimmed {
                Ok(trimmed) if trimmed.repairs.is_empty() => {
                    (kind(&trimmed.geometry), CadFaceOutcome::Read, trimmed.width)
                }
                Ok(trimmed) => {
                    let repairs = trimmed.repairs.iter().map(ToString::to_string).collect();
                    (kind(&trimmed.geometry), CadFaceOutcome::Repaired(repairs), trimmed.width)
                }
                Err(refusal) => {
                    let kind =
                        model.surfaces.get(face.surface).map_or("unknown", |entry| entry.surface.kind());
                    (kind, CadFaceOutcome::Refused(refusal.to_string()), 0.0)
                }
            };
            CadFace { entity: face.entity, name: face.name.clone(), kind, outcome, width }
        });
        Self {
            reading: file.report.clone(),
            uncertainty: model.uncertainty,
            faces: faces.collect(),
            shapes: Vec::new(),
        }
    }

    /// The warnings about what is damaged or left out.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = CadWarning> {
        let faults = self.reading.faults.notes().iter().map(|fault| CadWarning {
            kind: "step-syntax",
            position: fault.position.map(|[line, column]| (line, column)),
            message: fault.reason.clone(),
        });
        let warning = |kind, message| CadWarning { kind, position: None, message };
        let omissions = self.reading.omissions.notes().iter();
        let omissions = omissions.map(move |omission| warning("step-omission", omission.to_string()));
        let refusals = self.faces.iter().filter_map(move |face| match &face.outcome {
            CadFaceOutcome::Refused(reason) => {
                Some(warning("step-face", format!("face {} is left out: {reason}", face.entity)))
            }
            CadFaceOutcome::Read | CadFaceOutcome::Repaired(_) => None,
        });
        faults.chain(omissions).chain(refusals)
    }

    /// Largest distance by which faces extend beyond an edge, metres.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.faces.iter().map(|face| face.width).fold(0.0, f64::max)
    }
}

fn kind(geometry: &FaceGeometry) -> &'static str {
    match geometry {
        FaceGeometry::Plane { .. } => "plane",
        FaceGeometry::Cylinder { .. } => "cylinder",
        FaceGeometry::Cone { .. } => "cone",
        FaceGeometry::Sphere { .. } => "sphere",
        FaceGeometry::Torus { .. } => "torus",
        FaceGeometry::Spline(_) => "spline",
    }
}
