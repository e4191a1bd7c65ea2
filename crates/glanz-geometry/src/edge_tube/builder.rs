//! Division of trimming curves into tubes.

use glanz_math::{DVec2, DVec3};

use super::patch_index::PatchIndex;
use super::tube::EdgeTube;
use crate::hit::SurfacePoint;
use crate::surface::Surface;
use crate::trim::{MonotonePiece, TrimRegion, scale_across};

/// Widths of curves, relative to the size of the surface, up to which they have no tubes: few rays meet such a gap at a small angle, and tubes as thin as
/// these would take more memory than the surfaces.
const LEAST_WIDTH: f64 = 1e-6;

/// Smallest radius of a tube relative to the size of the surface: thinner ones would need more parts than a surface has leaves.
const LEAST_RADIUS: f64 = 1e-6;

/// Part of its radius by which the axis of a tube may be off the curve before the tube is halved.
const SAG: f64 = 0.45;

/// Largest number of halvings of the tube of a piece of a curve.
const MOST_HALVINGS: u32 = 12;

/// Largest number of tubes of a surface, from which on they get thicker instead of shorter.
const MOST_TUBES: usize = 1 << 17;

/// Margin of the largest width left out, since widths vary between the points at which they are known.
const VARIATION: f64 = 2.0;

/// Divides curves into tubes.
pub(super) struct TubeBuilder<'a> {
    surface: &'a Surface,
    region: &'a TrimRegion,
    /// Of a freeform surface.
    patches: Option<PatchIndex>,
    extent: f64,
    pub(super) tubes: Vec<EdgeTube>,
    /// Upper bound on the width, metres, of the borders of curves without tubes.
    pub(super) widest_without: f64,
}

/// A point of a trimming curve on the surface.
#[derive(Clone, Copy)]
struct TubeEnd {
    t: f64,
    face: u32,
    parameters: DVec2,
    position: DVec3,
    /// See [`scale_across`], in the coordinates of the region.
    scale: f64,
}

impl<'a> TubeBuilder<'a> {
    pub(super) fn new(surface: &'a Surface, region: &'a TrimRegion, extent: f64) -> Self {
        let patches = surface.freeform().map(PatchIndex::new);
        Self { surface, region, patches, extent, tubes: Vec::new(), widest_without: 0.0 }
    }

    /// Adds tubes around a piece if it is wide enough for them.
    pub(super) fn add(&mut self, piece: &MonotonePiece) {
        let [Some(start), Some(middle), Some(end)] = [0.0, 0.5, 1.0].map(|t| self.point(piece, t)) else {
            self.widest_without = f64::INFINITY;
            return;
        };
        let width = piece.width * [start, middle, end].iter().map(|end| end.scale).fold(0.0, f64::max);
        if width > LEAST_WIDTH * self.extent {
            self.divide(piece, [start, middle, end], MOST_HALVINGS);
        } else {
            self.widest_without = self.widest_without.max(VARIATION * width);
        }
    }

    /// Adds tubes for a part of a piece from its start over its middle to its end.
    fn divide(&mut self, piece: &MonotonePiece, [start, middle, end]: [TubeEnd; 3], halvings: u32) {
        let quarters = [[start, middle], [middle, end]].map(|[a, b]| self.point(piece, 0.5 * (a.t + b.t)));
        let [Some(first), Some(third)] = quarters else {
            self.widest_without = f64::INFINITY;
            return;
        };
        let between = [first, middle, third];
        let scale = between.iter().fold(start.scale.max(end.scale), |s, p| s.max(p.scale));
        let radius = (piece.width * scale).max(LEAST_RADIUS * self.extent);
        let off_axis = |(point, share): (&TubeEnd, f64)| {
            point.position.distance(start.position.lerp(end.position, share))
        };
        let sag = between.iter().zip([0.25, 0.5, 0.75]).map(off_axis).fold(0.0, f64::max);
        // The first halves of a curve that swings around its chord could seem straight.
        let is_straight = sag <= SAG * radius && halvings < MOST_HALVINGS;
        if is_straight && start.face == end.face || halvings == 0 || self.tubes.len() >= MOST_TUBES {
            let parameters = if start.face == end.face {
                [start.parameters, end.parameters]
            } else {
                [start.parameters; 2]
            };
            let along = end.position - start.position;
            let radius = radius + 2.0 * sag;
            self.tubes.push(EdgeTube { start: start.position, along, radius, face: start.face, parameters });
            return;
        }
        self.divide(piece, [start, first, middle], halvings - 1);
        self.divide(piece, [middle, third, end], halvings - 1);
    }

    fn point(&self, piece: &MonotonePiece, t: f64) -> Option<TubeEnd> {
        let uv = if t == 0.0 {
            piece.start
        } else if t == 1.0 {
            piece.end
        } else {
            piece.point(t)
        };
        let (face, parameters) = match &self.patches {
            Some(patches) => patches.find(uv)?,
            _ if self.surface.faces() == 1 => (0, uv.clamp(DVec2::ZERO, DVec2::ONE)),
            _ => return None,
        };
        let SurfacePoint { position, dpdu, dpdv, .. } = self.surface.untrimmed_at(face, parameters)?;
        let units = self.region.scale();
        let scale = scale_across([dpdu / units.x, dpdv / units.y], piece.direction(t) * units);
        position.is_finite().then_some(TubeEnd { t, face, parameters, position, scale })
    }
}
