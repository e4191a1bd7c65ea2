//! Surfaces as the graphics card gets them: patches, triangles, polynomials.

use std::collections::HashMap;
use std::sync::Arc;

use glanz_geometry::algebraic::AlgebraicSurface;
use glanz_geometry::freeform::Freeform;
use glanz_geometry::quadric::Plane;
use glanz_geometry::rational::{Along, Pace, RationalPatch, bilinear};
use glanz_geometry::trim::TrimRegion;
use glanz_geometry::{RaySurface, Surface};
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::blocks::Blocks;
use super::error::ModelError;
use super::head;
use super::patches::{Face, Sheet};
use super::region::Grid;

/// How far a plane without end is drawn, in diagonals of the scene.
const FAR: f64 = 4.0;

/// Surfaces in the making.
#[derive(Default)]
pub(super) struct Surfaces {
    pub(super) head: Vec<head::Surface>,
    pub(super) regions: Vec<head::Region>,
    pub(super) blocks: Blocks,
    pub(super) notes: Vec<String>,
    /// What was made of a surface, by where it is kept: copies by instances share it.
    known: HashMap<usize, Vec<Made>>,
    known_regions: HashMap<usize, usize>,
}

/// A surface of the model, or a part of one that belongs to a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    /// Number of the surface of the model.
    pub(super) surface: usize,
    /// Where its coordinates have their origin, in the frame of the scene's surface, metres ...
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
        let made = match surface {
            Surface::Freeform(freeform) => self.freeform(freeform)?,
            Surface::Plane(plane) if !plane.area().is_finite() => {
                self.notes.push("a plane without end is drawn as a large rectangle".to_owned());
                let patch = endless(plane, placed, bounds);
                self.rational(patch.into_iter().collect(), region)?
            }
            Surface::Algebraic(algebraic) => {
                self.note_untrimmed(region, surface);
                self.algebraic(algebraic)
            }
            Surface::Mesh(mesh) => {
                self.note_untrimmed(region, surface);
                return parts_of(parts, mesh.indices().len()).map(|part| self.mesh(mesh, part)).collect();
            }
            _ => match surface.rational_patches() {
                Some(patches) => self.rational(patches, region)?,
                None => {
                    self.note_untrimmed(region, surface);
                    self.flat(surface)?
                }
            },
        };
        Ok(vec![made])
    }

    fn note_untrimmed(&mut self, region: Option<&Arc<TrimRegion>>, surface: &Surface) {
        if region.is_some() {
            self.notes.push(format!("a trimmed {} is drawn without its trimming", surface.kind()));
        }
    }

    fn freeform(&mut self, freeform: &Freeform) -> Result<Made, ModelError> {
        let region = freeform.region();
        let scaled = Scaled::new(region);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let faces = (0..).zip(freeform.pieces()).map(|(number, piece)| Face {
            patch: piece.patch(),
            number,
            words: corners.map(|(x, y)| scaled.at(piece.parameters(x, y)).to_array()).concat(),
        });
        self.sheet(faces.collect(), head::Mapping::Patch, region)
    }

    fn rational(
        &mut self,
        patches: Vec<RationalPatch>,
        region: Option<&Arc<TrimRegion>>,
    ) -> Result<Made, ModelError> {
        let scaled = Scaled::new(region);
        let turns = patches.iter().flat_map(|p| [p.u, p.v]).any(|along| along.pace != Pace::Proportional);
        let words = |p: &RationalPatch| {
            let ends = [0, 1].map(|k| scaled.at(DVec2::new(p.u.ends[k], p.v.ends[k])));
            let [low, high] = ends;
            if turns {
                let (half_u, _) = pace_words(p.u.pace);
                let (half_v, k) = pace_words(p.v.pace);
                vec![low.x, high.x, low.y, high.y, half_u, half_v, k, 0.0]
            } else {
                vec![low.x, low.y, high.x, low.y, low.x, high.y, high.x, high.y]
            }
        };
        let faces = patches.iter().map(|p| Face { patch: &p.patch, number: 0, words: words(p) });
        let mapping = if turns { head::Mapping::Revolution } else { head::Mapping::Patch };
        self.sheet(faces.collect(), mapping, region)
    }

    fn sheet(
        &mut self,
        faces: Vec<Face<'_>>,
        mapping: head::Mapping,
        region: Option<&Arc<TrimRegion>>,
    ) -> Result<Made, ModelError> {
        let region = region.map(|region| self.region(region)).transpose()?;
        let Sheet { first, count, origin } = Sheet::lay(&mut self.blocks, &faces)?;
        let origin_of_head = origin.to_array();
        self.head.push(head::Surface::Patches { first, count, origin: origin_of_head, region, mapping });
        Ok(Made { surface: self.head.len() - 1, origin, unit: 1.0 })
    }

    fn algebraic(&mut self, surface: &AlgebraicSurface) -> Made {
        let (center, scale) = (surface.center(), surface.scale());
        let term = |term: glanz_geometry::algebraic::Term| {
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

/// Where a surface is kept.
fn address(surface: &Surface) -> usize {
    match surface {
        Surface::Freeform(freeform) => Arc::as_ptr(freeform).addr(),
        Surface::Mesh(mesh) => Arc::as_ptr(mesh).addr(),
        other => std::ptr::from_ref(other).addr(),
    }
}

/// The surface without trimming, and what trims it. Freeform surfaces know their own region.
fn untrimmed(surface: &Surface) -> (&Surface, Option<&Arc<TrimRegion>>) {
    match surface {
        Surface::Trimmed(trimmed) => (trimmed.surface(), Some(trimmed.region())),
        other => (other, None),
    }
}

/// The ranges of faces that begin with those of `parts`.
fn parts_of(parts: &[u32], faces: usize) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let ends = parts.iter().skip(1).map(|&end| end as usize).chain([faces]);
    parts.iter().zip(ends).map(|(&start, end)| start as usize..end)
}

/// Words of the half angle, negative for hyperbolas, and of the quadratic term.
fn pace_words(pace: Pace) -> (f64, f64) {
    match pace {
        Pace::Proportional => (0.0, 0.0),
        Pace::Circular(half) => (half, 0.0),
        Pace::Hyperbolic(half) => (-half, 0.0),
        Pace::Quadratic(k) => (0.0, k),
    }
}

/// Parameters as those of a region are: from 0 to 1 over it.
pub(super) struct Scaled {
    min: DVec2,
    size: DVec2,
}

impl Scaled {
    pub(super) fn new(region: Option<&Arc<TrimRegion>>) -> Self {
        let [min, max] = region.map_or([DVec2::ZERO, DVec2::ONE], |region| region.domain());
        Self { min, size: max - min }
    }

    pub(super) fn at(&self, uv: DVec2) -> DVec2 {
        (uv - self.min) / self.size
    }
}

/// A rectangle of a plane without end that reaches far beyond the scene.
fn endless(plane: &Plane, placed: &PlacedSurface<'_>, bounds: Bounds3) -> Option<RationalPatch> {
    let own = plane.bounds();
    let inverse = placed.to_world().inverse();
    let columns = inverse.forward().matrix3;
    let stretch = [columns.x_axis, columns.y_axis, columns.z_axis];
    let stretch = stretch.into_iter().fold(0.0, |most: f64, column| most.max(column.length()));
    let (middle, reach) = if bounds.is_empty() {
        (DVec3::ZERO, 1.0)
    } else {
        (inverse.point(bounds.center()), bounds.diagonal().length())
    };
    let reach = FAR * stretch * reach.max(f64::MIN_POSITIVE);
    let axis = |low: f64, high: f64, middle: f64| {
        // Half a plane may end beyond the scene.
        let middle = middle.clamp(low, high);
        let ends = [low.max(middle - reach), high.min(middle + reach)];
        // The parameter of an axis with two ends goes from 0 to 1, that of others is the coordinate.
        let parameters = if (high - low).is_finite() { [0.0, 1.0] } else { ends };
        (if (high - low).is_finite() { [low, high] } else { ends }, parameters)
    };
    let (x, u) = axis(own.min.x, own.max.x, middle.x);
    let (y, v) = axis(own.min.y, own.max.y, middle.y);
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| DVec3::new(x[i], y[j], 0.0));
    let along = |ends| Along { ends, pace: Pace::Proportional };
    bilinear(corners, along(u), along(v))
}
