//! The outcome for each face of a CAD file.

use std::sync::{Arc, OnceLock};

use glanz_brep::face::{FaceGeometry, FaceMeasure, TrimmedFaces};
use glanz_brep::model::{Body, BrepModel, EntityId};

use super::report::ReadingReport;

/// Accuracy of areas, relative to those of surfaces.
const ACCURACY: f64 = 1e-8;

/// The outcome of reading a CAD file.
#[derive(Clone, Debug)]
pub struct CadReport {
    /// What was read of the file.
    pub reading: ReadingReport,
    /// Distance below which points of the file are meant to coincide, metres.
    pub uncertainty: f64,
    /// The unit of length of the file, metres: the first, where it has several.
    pub length_unit: Option<f64>,
    /// The faces that were read.
    pub faces: Vec<CadFace>,
    /// The bodies of all parts.
    pub bodies: Vec<CadBody>,
    /// The name of the part that is the whole file, where its shapes and instances are those of the world.
    pub whole: Option<String>,
    /// The face of each shape of the description, by its index in `faces`: shapes of the groups in their order, then those of the world.
    pub shapes: Vec<usize>,
    trimmed: Arc<TrimmedFaces>,
    /// The measures of faces that were asked for.
    measures: Arc<[OnceLock<FaceMeasure>]>,
}

/// A solid, or a surface model.
#[derive(Clone, Debug)]
pub struct CadBody {
    /// Its number in the file.
    pub entity: EntityId,
    /// Its name; may be empty.
    pub name: String,
    /// Whether it bounds a volume: it is a solid all of whose faces were made.
    pub solid: bool,
    /// The faces that were made, by their indices; those with `true` have their normal reversed.
    pub faces: Vec<(usize, bool)>,
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
    pub(super) fn new(model: &BrepModel, reading: ReadingReport, trimmed: &Arc<TrimmedFaces>) -> Self {
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
            reading,
            uncertainty: model.uncertainty,
            length_unit: model.length_unit,
            faces: faces.collect(),
            bodies: model.parts.iter().flat_map(|part| &part.bodies).map(|b| body(b, trimmed)).collect(),
            whole: None,
            shapes: Vec::new(),
            trimmed: Arc::clone(trimmed),
            measures: model.faces.iter().map(|_| OnceLock::new()).collect(),
        }
    }

    /// The area of a face, m^2; `None` if it is left out. Calculated when first asked for.
    #[must_use]
    pub fn face_area(&self, face: usize) -> Option<f64> {
        self.measure(face).map(|measure| measure.area)
    }

    /// The volume of a body, m^3; `None` if it is not a solid. Calculated when first asked for.
    #[must_use]
    pub fn body_volume(&self, body: usize) -> Option<f64> {
        let body = self.bodies.get(body).filter(|body| body.solid)?;
        let volumes = body.faces.iter().map(|&(face, reversed)| {
            let volume = self.measure(face)?.volume;
            Some(if reversed { -volume } else { volume })
        });
        volumes.sum::<Option<f64>>().map(f64::abs)
    }

    fn measure(&self, face: usize) -> Option<FaceMeasure> {
        let trimmed = self.trimmed.faces.get(face)?.as_ref().ok()?;
        Some(*self.measures.get(face)?.get_or_init(|| trimmed.measure(ACCURACY)))
    }

    /// The warnings about what is damaged or left out.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = CadWarning> {
        let faults = self.reading.faults.notes().iter().map(|fault| CadWarning {
            kind: "cad-syntax",
            position: fault.position.map(|[line, column]| (line, column)),
            message: fault.reason.clone(),
        });
        let warning = |kind, message| CadWarning { kind, position: None, message };
        let omissions = self.reading.omissions.notes().iter();
        let omissions = omissions.map(move |omission| warning("cad-omission", omission.to_string()));
        let refusals = self.faces.iter().filter_map(move |face| match &face.outcome {
            CadFaceOutcome::Refused(reason) => {
                Some(warning("cad-face", format!("face {} is left out: {reason}", face.entity)))
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

fn body(body: &Body, trimmed: &TrimmedFaces) -> CadBody {
    let made = |&&(face, _): &&(usize, bool)| matches!(trimmed.faces.get(face), Some(Ok(_)));
    let all = || body.shells.iter().flat_map(|shell| &shell.faces);
    CadBody {
        entity: body.entity,
        name: body.name.clone(),
        solid: body.solid && body.shells.iter().all(|shell| shell.closed) && all().all(|face| made(&face)),
        faces: all().filter(made).copied().collect(),
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
