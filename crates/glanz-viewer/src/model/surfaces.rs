//! Surfaces in the form for the graphics card: patches, triangles, polynomials.

use std::collections::HashMap;
use std::sync::Arc;

use glanz_geometry::algebraic::AlgebraicSurface;
use glanz_geometry::rational::Reparameterization;
use glanz_geometry::trim::TrimRegion;
use glanz_geometry::{RaySurface, Surface};
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::blocks::Blocks;
use super::error::ModelError;
use super::head;
use super::patches::{PatchRange, PatchRow};
use super::region::Grid;
use super::visible_patches::{PatchParameters, VisiblePatch, untrimmed, visible_patches};

/// The surfaces of the model built so far.
#[derive(Default)]
pub(super) struct Surfaces {
    pub(super) head: Vec<head::ModelSurface>,
    pub(super) regions: Vec<head::ModelRegion>,
    pub(super) blocks: Blocks,
    pub(super) notes: Vec<String>,
    /// Built surfaces by address: instances share them.
    known: HashMap<usize, Vec<BuiltSurface>>,
    known_regions: HashMap<usize, usize>,
}

/// A surface of the model, or a part of one that belongs to a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct BuiltSurface {
    /// Number of the surface of the model.
    pub(super) surface: usize,
    /// Origin of its coordinates in the frame of the scene's surface, metres.
    pub(super) origin: DVec3,
    /// Length of a unit of its coordinates, metres.
    pub(super) unit: f64,
}

impl Surfaces {
    /// The surfaces of the model that show `placed`, one for each of `parts`, the first faces of its shapes.
    ///
    /// `bounds`: of the scene, in the world, for unbounded surfaces.
    ///
    /// # Errors
    /// [`ModelError::TooMany`].
    pub(super) fn add(
        &mut self,
        placed: &PlacedSurface<'_>,
        parts: &[u32],
        bounds: Bounds3,
    ) -> Result<Vec<BuiltSurface>, ModelError> {
        let surface = placed.surface();
        let is_unbounded = !surface.bounds().is_finite();
        let address = address(surface);
        if let Some(built) = self.known.get(&address).filter(|_| !is_unbounded) {
            return Ok(built.clone());
        }
        let built = self.build(placed, parts, bounds)?;
        self.known.insert(address, built.clone());
        Ok(built)
    }

    fn build(
        &mut self,
        placed: &PlacedSurface<'_>,
        parts: &[u32],
        bounds: Bounds3,
    ) -> Result<Vec<BuiltSurface>, ModelError> {
        let (surface, region) = untrimmed(placed.surface());
        if let Some(patches) = visible_patches(placed, bounds) {
            if !surface.bounds().is_finite() && region.is_none_or(|region| region.outermost() > 0) {
                self.notes.push("an unbounded plane is drawn as a large rectangle".to_owned());
            }
            return Ok(vec![self.patches(&patches, region)?]);
        }
        if region.is_some() {
            self.notes.push(format!("a trimmed {} is drawn without its trimming", surface.kind()));
        }
        match surface {
            Surface::Algebraic(algebraic) => Ok(vec![self.algebraic(algebraic)]),
            Surface::Mesh(mesh) => {
                parts_of(parts, mesh.indices().len()).map(|part| self.mesh(mesh, part)).collect()
            }
            Surface::Curve(curve) => {
                self.notes.push("a curve that faces every ray is drawn as a tube".to_owned());
                Ok(vec![self.tube(curve)?])
            }
            _ => Ok(vec![self.flat(surface)?]),
        }
    }

    fn patches(
        &mut self,
        patches: &[VisiblePatch],
        region: Option<&Arc<TrimRegion>>,
    ) -> Result<BuiltSurface, ModelError> {
        let scaled = RegionScale::new(region);
        let faces: Vec<PatchRow<'_>> = patches
            .iter()
            .map(|patch| PatchRow {
                patch: &patch.patch,
                number: patch.face,
                words: scaled.words(&patch.parameters),
            })
            .collect();
        let turns = patches.iter().any(|patch| matches!(patch.parameters, PatchParameters::Sides { .. }));
        let mapping = if turns { head::Mapping::Revolution } else { head::Mapping::Patch };
        let region = region.map(|region| self.region(region)).transpose()?;
        let PatchRange { first, count, origin } = PatchRange::add(&mut self.blocks, &faces)?;
        let origin_of_head = origin.to_array();
        self.head.push(head::ModelSurface::Patches { first, count, origin: origin_of_head, region, mapping });
        Ok(BuiltSurface { surface: self.head.len() - 1, origin, unit: 1.0 })
    }

    fn algebraic(&mut self, surface: &AlgebraicSurface) -> BuiltSurface {
        let (center, scale) = (surface.center(), surface.scale());
        let term = |term: glanz_geometry::algebraic::PolynomialTerm| {
            let [i, j, k] = term.exponents;
            (i, j, k, term.coefficient)
        };
        let bounds = surface.bounds();
        let own = |corner: DVec3| ((corner - center) / scale).to_array();
        self.head.push(head::ModelSurface::Algebraic {
            terms: surface.centered_terms().map(term).collect(),
            min: own(bounds.min),
            max: own(bounds.max),
        });
        BuiltSurface { surface: self.head.len() - 1, origin: center, unit: scale }
    }

    fn region(&mut self, region: &Arc<TrimRegion>) -> Result<usize, ModelError> {
        let address = Arc::as_ptr(region).addr();
        if let Some(&known) = self.known_regions.get(&address) {
            return Ok(known);
        }
        let head = Grid::of(region).add_to(&mut self.blocks)?;
        self.regions.push(head);
        self.known_regions.insert(address, self.regions.len() - 1);
        Ok(self.regions.len() - 1)
    }
}

/// Address of a surface.
fn address(surface: &Surface) -> usize {
    match surface {
        Surface::Freeform(freeform) => Arc::as_ptr(freeform).addr(),
        Surface::Mesh(mesh) => Arc::as_ptr(mesh).addr(),
        other => std::ptr::from_ref(other).addr(),
    }
}

/// The ranges of faces that begin with those of `parts`.
fn parts_of(parts: &[u32], faces: usize) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let ends = parts.iter().skip(1).map(|&end| end as usize).chain([faces]);
    parts.iter().zip(ends).map(|(&start, end)| start as usize..end)
}

/// Words of the half angle, negative for hyperbolas, and of the quadratic term.
fn reparameterization_words(reparameterization: Reparameterization) -> (f64, f64) {
    match reparameterization {
        Reparameterization::Linear => (0.0, 0.0),
        Reparameterization::Circular(half) => (half, 0.0),
        Reparameterization::Hyperbolic(half) => (-half, 0.0),
        Reparameterization::Quadratic(k) => (0.0, k),
    }
}

/// Scale from parameters of a surface to those of its region, which go from 0 to 1.
struct RegionScale {
    min: DVec2,
    size: DVec2,
}

impl RegionScale {
    fn new(region: Option<&Arc<TrimRegion>>) -> Self {
        let [min, max] = region.map_or([DVec2::ZERO, DVec2::ONE], |region| region.domain());
        Self { min, size: max - min }
    }

    fn at(&self, uv: DVec2) -> DVec2 {
        (uv - self.min) / self.size
    }

    /// Words 4 to 11 of a patch.
    fn words(&self, parameters: &PatchParameters) -> Vec<f64> {
        match parameters {
            PatchParameters::Corners { surface, .. } => surface.map(|uv| self.at(uv).to_array()).concat(),
            PatchParameters::Sides { u, v } => {
                let [low, high] = [0, 1].map(|k| self.at(DVec2::new(u.ends[k], v.ends[k])));
                let ((half_u, _), (half_v, k)) = (
                    reparameterization_words(u.reparameterization),
                    reparameterization_words(v.reparameterization),
                );
                vec![low.x, high.x, low.y, high.y, half_u, half_v, k, 0.0]
            }
        }
    }
}
