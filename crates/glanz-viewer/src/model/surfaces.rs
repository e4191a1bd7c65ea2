//! Surfaces as the graphics card gets them: patches, triangles, polynomials.

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
use super::patches::{Face, Sheet};
use super::region::Grid;
use super::shown::{Parameters, Shown, shown, untrimmed};

/// Surfaces in the making.
#[derive(Default)]
pub(super) struct Surfaces {
    pub(super) head: Vec<head::Surface>,
    pub(super) regions: Vec<head::Region>,
    pub(super) blocks: Blocks,
    pub(super) notes: Vec<String>,
    /// Built surfaces by address: instances share them.
    known: HashMap<usize, Vec<Made>>,
    known_regions: HashMap<usize, usize>,
}

/// A surface of the model, or a part of one that belongs to a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    /// Number of the surface of the model.
    pub(super) surface: usize,
    /// Origin of its coordinates in the frame of the scene's surface, metres ...
    pub(super) origin: DVec3,
    /// ... and what their unit is, metres.
    pub(super) unit: f64,
}

impl Surfaces {
    /// The surfaces of the model that show `placed`, one for each of `parts`, which are the faces that its shapes begin with.
    ///
    /// `bounds`: of the scene, in the world, for what has no end itself.
    ///
    /// # Errors
    /// [`ModelError::TooMany`].
    pub(super) fn add(
        &mut self,
        placed: &PlacedSurface<'_>,
        parts: &[u32],
        bounds: Bounds3,
    ) -> Result<Vec<Made>, ModelError> {
        let surface = placed.surface();
        let endless = !surface.bounds().is_finite();
        let address = address(surface);
        if let Some(made) = self.known.get(&address).filter(|_| !endless) {
            return Ok(made.clone());
        }
        let made = self.make(placed, parts, bounds)?;
        self.known.insert(address, made.clone());
        Ok(made)
    }

    fn make(
        &mut self,
        placed: &PlacedSurface<'_>,
        parts: &[u32],
        bounds: Bounds3,
    ) -> Result<Vec<Made>, ModelError> {
        let (surface, region) = untrimmed(placed.surface());
        if let Some(patches) = shown(placed, bounds) {
            if !surface.bounds().is_finite() && region.is_none_or(|region| region.outermost() > 0) {
                self.notes.push("a plane without end is drawn as a large rectangle".to_owned());
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
            _ => Ok(vec![self.flat(surface)?]),
        }
    }

    fn patches(
        &mut self,
        patches: &[Shown<'_>],
        region: Option<&Arc<TrimRegion>>,
    ) -> Result<Made, ModelError> {
        let scaled = Scaled::new(region);
        let faces: Vec<Face<'_>> = patches
            .iter()
            .map(|shown| Face {
                patch: &shown.patch,
                number: shown.face,
                words: scaled.words(&shown.parameters),
            })
            .collect();
        let turns = patches.iter().any(|shown| matches!(shown.parameters, Parameters::Sides { .. }));
        let mapping = if turns { head::Mapping::Revolution } else { head::Mapping::Patch };
        let region = region.map(|region| self.region(region)).transpose()?;
        let Sheet { first, count, origin } = Sheet::lay(&mut self.blocks, &faces)?;
        let origin_of_head = origin.to_array();
        self.head.push(head::Surface::Patches { first, count, origin: origin_of_head, region, mapping });
        Ok(Made { surface: self.head.len() - 1, origin, unit: 1.0 })
    }

    fn algebraic(&mut self, surface: &AlgebraicSurface) -> Made {
        let (center, scale) = (surface.center(), surface.scale());
        let term = |term: glanz_geometry::algebraic::PolynomialTerm| {
            let [i, j, k] = term.exponents;
            (i, j, k, term.coefficient)
        };
        let bounds = surface.bounds();
        let own = |corner: DVec3| ((corner - center) / scale).to_array();
        self.head.push(head::Surface::Algebraic {
            terms: surface.centered_terms().map(term).collect(),
            min: own(bounds.min),
            max: own(bounds.max),
        });
        Made { surface: self.head.len() - 1, origin: center, unit: scale }
    }

    fn region(&mut self, region: &Arc<TrimRegion>) -> Result<usize, ModelError> {
        let address = Arc::as_ptr(region).addr();
        if let Some(&known) = self.known_regions.get(&address) {
            return Ok(known);
        }
        let head = Grid::of(region).lay(&mut self.blocks)?;
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

/// Parameters as those of a region are: from 0 to 1 over it.
struct Scaled {
    min: DVec2,
    size: DVec2,
}

impl Scaled {
    fn new(region: Option<&Arc<TrimRegion>>) -> Self {
        let [min, max] = region.map_or([DVec2::ZERO, DVec2::ONE], |region| region.domain());
        Self { min, size: max - min }
    }

    fn at(&self, uv: DVec2) -> DVec2 {
        (uv - self.min) / self.size
    }

    /// Words 4 to 11 of a patch.
    fn words(&self, parameters: &Parameters) -> Vec<f64> {
        match parameters {
            Parameters::Corners { surface, .. } => surface.map(|uv| self.at(uv).to_array()).concat(),
            Parameters::Sides { u, v } => {
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
