//! The state of reading one file.

use std::collections::{BTreeMap, HashMap, HashSet};

use glanz_brep::model::{BrepModel, EntityId, FaceSurface, SurfaceEntry};
use glanz_job::ResourceBudget;
use glanz_math::{DMat4, DVec3};

use super::entity::{IgesEntity, type_name};
use super::file::IgesFile;
use super::surfaces::SurfaceLink;
use crate::cad::{BrepFile, CopyBudget, FaceCounts, PartReaches, ReadingReport, Refusal};

/// Entities inside one another, at most.
pub(super) const MAX_DEPTH: usize = 16;

/// The outcome for an entity that is a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum IgesFaceState {
    Read(usize),
    Refused,
    Hidden,
}

/// The state of reading one file.
pub(super) struct IgesReader<'a> {
    pub(super) file: &'a IgesFile,
    pub(super) budget: CopyBudget,
    pub(super) model: BrepModel,
    pub(super) report: ReadingReport,
    /// Faces by their places in the directory, like all that follows.
    pub(super) faces: HashMap<usize, IgesFaceState>,
    pub(super) surfaces: HashMap<usize, Result<SurfaceLink, Refusal>>,
    /// By list and number in it.
    pub(super) vertices: HashMap<(usize, usize), Result<usize, Refusal>>,
    pub(super) edges: HashMap<(usize, usize), Result<usize, Refusal>>,
    /// Parts of subfigures, solids and assemblies; `None` while one is read.
    pub(super) definitions: HashMap<usize, Option<Result<usize, Refusal>>>,
    pub(super) reaches: PartReaches,
    /// What is not shown, and why.
    pub(super) unshown: Vec<(IgesEntity<'a>, &'static str)>,
    /// Solids, shells and assemblies that are not shown, so that their faces are counted once.
    pub(super) concealed: HashSet<usize>,
}

impl<'a> IgesReader<'a> {
    pub(super) fn new(file: &'a IgesFile, report: ReadingReport, budget: &ResourceBudget) -> Self {
        let uncertainty = file.global.resolution * file.global.length;
        Self {
            file,
            budget: CopyBudget::new(file.size, budget),
            model: BrepModel { uncertainty, length_unit: Some(file.global.length), ..BrepModel::default() },
            report,
            faces: HashMap::new(),
            surfaces: HashMap::new(),
            vertices: HashMap::new(),
            edges: HashMap::new(),
            definitions: HashMap::new(),
            reaches: PartReaches::default(),
            unshown: Vec::new(),
            concealed: HashSet::new(),
        }
    }

    /// The map from coordinates of the file to metres.
    pub(super) fn metres(&self) -> DMat4 {
        DMat4::from_scale(DVec3::splat(self.file.global.length))
    }

    /// Takes the copy of an entity off the budget.
    pub(super) fn spend(&mut self, entity: IgesEntity<'_>) -> Result<(), Refusal> {
        self.budget.spend(entity.id(), entity.len() + 1)
    }

    pub(super) fn add_surface(&mut self, surface: FaceSurface, entity: EntityId) -> usize {
        self.model.surfaces.push(SurfaceEntry { surface, entity });
        self.model.surfaces.len() - 1
    }

    /// The model with the completed report.
    pub(super) fn finish(mut self) -> BrepFile {
        let mut counts = FaceCounts::default();
        let mut others: BTreeMap<u32, (usize, EntityId)> = BTreeMap::new();
        for entity in self.file.entities() {
            match self.faces.get(&entity.index) {
                Some(IgesFaceState::Read(_)) => counts.read += 1,
                Some(IgesFaceState::Refused) => counts.refused += 1,
                Some(IgesFaceState::Hidden) => counts.hidden += 1,
                None if matches!(entity.kind(), 143 | 144 | 510) => counts.unreachable += 1,
                None if is_shape(entity.kind()) && !self.file.is_used(entity.index) => {
                    others.entry(entity.kind()).or_insert((0, entity.id())).0 += 1;
                    continue;
                }
                None => continue,
            }
            counts.total += 1;
        }
        for (kind, (count, first)) in others {
            let what = type_name(kind);
            let reason = match count {
                1 => format!("1 entity of type {kind} ({what}) belongs to no face; it is not shown"),
                _ => {
                    format!("{count} entities of type {kind} ({what}) belong to no face; they are not shown")
                }
            };
            self.report.omissions.push(first, reason);
        }
        self.report.faces = counts;
        BrepFile { model: self.model, report: self.report }
    }
}

/// Whether a type is one of shapes, not one of attributes and definitions.
fn is_shape(kind: u32) -> bool {
    !matches!(kind, 0 | 124 | 302 | 304 | 308 | 310 | 312 | 314 | 316 | 402 | 406)
}
