//! The visible patches of a surface, and the mapping from their parameters to those of the surface.

use glanz_geometry::bezier::TensorPatch;
use glanz_geometry::quadric::Plane;
use glanz_geometry::rational::{ParameterMap, RationalPatch, Reparameterization, bilinear};
use glanz_geometry::trim::{Containment, TrimRegion};
use glanz_geometry::{RaySurface, Surface};
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::PlacedSurface;

/// Half side of the patch that represents an infinite plane near the scene, in scene diagonals; small coordinates are accurate.
const NEAR: f64 = 4.0;

/// Half side of the whole drawn plane: its border is a fraction of a pixel below the horizon.
const FAR: f64 = 1024.0;

/// A patch is clipped to the domain of its region if that spans less than this share of it, along u or along v.
const WORTHWHILE: f64 = 0.5;

/// A patch, or the part of it that trimming may leave visible.
pub(super) struct VisiblePatch {
    pub(super) patch: TensorPatch,
    /// Number of its face, as in hits.
    pub(super) face: u32,
    pub(super) parameters: PatchParameters,
}

/// Mapping from the parameters (x, y) of a patch to those of its surface.
#[derive(Clone, Copy)]
pub(super) enum PatchParameters {
    /// Bilinear between those at (0, 0), (1, 0), (0, 1), (1, 1).
    Corners {
        /// Parameters of the surface.
        surface: [DVec2; 4],
        /// Parameters of the face, as [`PlacedSurface::at`] takes them.
        face: [DVec2; 4],
    },
    /// Each along one side; those of the face are the same.
    Sides { u: ParameterMap, v: ParameterMap },
}

/// The visible patches of a surface; `None` if it has no patches. Patches that its region cuts away as a whole are left out.
///
/// `bounds`: of the scene, in the world, for unbounded planes.
pub(super) fn visible_patches(placed: &PlacedSurface<'_>, bounds: Bounds3) -> Option<Vec<VisiblePatch>> {
    let (surface, region) = untrimmed(placed.surface());
    let all: Vec<VisiblePatch> = match surface {
        Surface::Freeform(freeform) => {
            let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
            let pieces = (0..).zip(freeform.patches());
            let patches = pieces.map(|(face, piece)| {
                let surface = square.map(|at| piece.parameters(at.x, at.y));
                let parameters = PatchParameters::Corners { surface, face: square };
                VisiblePatch { patch: piece.patch().clone(), face, parameters }
            });
            patches.collect()
        }
        Surface::Plane(plane) if !plane.area().is_finite() => {
            rectangles_of_plane(plane, placed, bounds, region).into_iter().map(VisiblePatch::from).collect()
        }
        Surface::Cuboid(_) => (0..surface.faces()).filter_map(|face| side(surface, face)).collect(),
        other => other.rational_patches()?.into_iter().map(VisiblePatch::from).collect(),
    };
    let Some(region) = region else { return Some(all) };
    Some(all.into_iter().filter_map(|patch| patch.clipped(region)).collect())
}

/// The surface without trimming, and its trimming region.
pub(super) fn untrimmed(surface: &Surface) -> (&Surface, Option<&std::sync::Arc<TrimRegion>>) {
    match surface {
        Surface::Trimmed(trimmed) => (trimmed.surface(), Some(trimmed.region())),
        Surface::Freeform(freeform) => (surface, freeform.region()),
        other => (other, None),
    }
}

/// A side of a box.
fn side(surface: &Surface, face: u32) -> Option<VisiblePatch> {
    let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
    let mut corners = [DVec3::ZERO; 4];
    for (corner, at) in corners.iter_mut().zip(square) {
        *corner = surface.untrimmed_at(face, at)?.position;
    }
    let along = ParameterMap { ends: [0.0, 1.0], reparameterization: Reparameterization::Linear };
    bilinear(corners, along, along).map(|patch| VisiblePatch { face, ..VisiblePatch::from(patch) })
}

impl From<RationalPatch> for VisiblePatch {
    fn from(patch: RationalPatch) -> Self {
        let RationalPatch { patch, u, v } = patch;
        let parameters = if u.reparameterization == Reparameterization::Linear
            && v.reparameterization == Reparameterization::Linear
        {
            let ends = |i: usize, j: usize| DVec2::new(u.ends[i], v.ends[j]);
            let corners = [ends(0, 0), ends(1, 0), ends(0, 1), ends(1, 1)];
            PatchParameters::Corners { surface: corners, face: corners }
        } else {
            PatchParameters::Sides { u, v }
        };
        Self { patch, face: 0, parameters }
    }
}

fn between([a, b, c, d]: [DVec2; 4], at: DVec2) -> DVec2 {
    a.lerp(b, at.x).lerp(c.lerp(d, at.x), at.y)
}

impl PatchParameters {
    /// Parameters of the face at (x, y) of the patch.
    pub(super) fn of_face(&self, x: f64, y: f64) -> DVec2 {
        match self {
            Self::Corners { face, .. } => between(*face, DVec2::new(x, y)),
            Self::Sides { u, v } => DVec2::new(u.parameter(x), v.parameter(y)),
        }
    }

    /// Smallest and largest parameters of the surface.
    fn range(&self) -> [DVec2; 2] {
        let corners = match self {
            Self::Corners { surface, .. } => surface.to_vec(),
            Self::Sides { u, v } => {
                vec![DVec2::new(u.ends[0], v.ends[0]), DVec2::new(u.ends[1], v.ends[1])]
            }
        };
        let (low, high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        [corners.iter().fold(low, |a, b| a.min(*b)), corners.iter().fold(high, |a, b| a.max(*b))]
    }
}

impl VisiblePatch {
    /// The patch, clipped to what `region` may leave visible; `None` if that is nothing.
    ///
    /// Parameters are sent in single precision over the whole patch: where a face is a small part of its surface, its trimming
    /// curves need that precision for themselves.
    fn clipped(self, region: &TrimRegion) -> Option<Self> {
        let [low, high] = self.parameters.range();
        if region.classify(low, high) == Containment::Outside {
            return None;
        }
        let PatchParameters::Corners { surface, face } = self.parameters else { return Some(self) };
        let [a, b, c, d] = surface;
        let upright = a.x == c.x && b.x == d.x && a.y == b.y && c.y == d.y && a.x < b.x && a.y < c.y;
        if region.outermost() != 0 || !upright {
            return Some(self);
        }
        let [min, max] =
            region.domain().map(|corner| ((corner - low) / (high - low)).clamp(DVec2::ZERO, DVec2::ONE));
        let cut = |min: f64, max: f64| if max - min < WORTHWHILE && min < max { min..max } else { 0.0..1.0 };
        let (x, y) = (cut(min.x, max.x), cut(min.y, max.y));
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let corners = [at(x.start, y.start), at(x.end, y.start), at(x.start, y.end), at(x.end, y.end)];
        let patch = self.patch.sub_rectangle(x, y);
        let Ok(patch) = patch else { return Some(self) };
        let parameters = PatchParameters::Corners {
            surface: corners.map(|at| between(surface, at)),
            face: corners.map(|at| between(face, at)),
        };
        Some(Self { patch, parameters, ..self })
    }
}

/// Rectangles that represent an unbounded plane: the domain of the region, if it keeps the inside of loops, else one around the scene and others far beyond it.
fn rectangles_of_plane(
    plane: &Plane,
    placed: &PlacedSurface<'_>,
    bounds: Bounds3,
    region: Option<&std::sync::Arc<TrimRegion>>,
) -> Vec<RationalPatch> {
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
    let reach = stretch * reach.max(f64::MIN_POSITIVE);
    let kept = region.filter(|region| region.outermost() == 0).map(|region| region.domain());
    let axis = |low: f64, high: f64, middle: f64, kept: Option<[f64; 2]>| -> Vec<RectangleSide> {
        // The parameter of an axis with two ends goes from 0 to 1, that of others is the coordinate.
        if (high - low).is_finite() {
            return vec![([low, high], [0.0, 1.0])];
        }
        // Half a plane may end beyond the scene.
        let middle = middle.clamp(low, high);
        let steps = match kept {
            Some(ends) => ends.to_vec(),
            None => [-FAR, -NEAR, NEAR, FAR].map(|step| middle + step * reach).to_vec(),
        };
        let clamped: Vec<f64> = steps.iter().map(|step| step.clamp(low, high)).collect();
        let parts = clamped.windows(2).filter_map(|ends| <[f64; 2]>::try_from(ends).ok());
        parts.filter(|[first, last]| first < last).map(|ends| (ends, ends)).collect()
    };
    let columns = axis(own.min.x, own.max.x, middle.x, kept.map(|[min, max]| [min.x, max.x]));
    let rows = axis(own.min.y, own.max.y, middle.y, kept.map(|[min, max]| [min.y, max.y]));
    let along = |ends| ParameterMap { ends, reparameterization: Reparameterization::Linear };
    let patch = |((x, u), (y, v)): (RectangleSide, RectangleSide)| {
        let corners =
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j): (usize, usize)| DVec3::new(x[i], y[j], 0.0));
        bilinear(corners, along(u), along(v))
    };
    columns.iter().flat_map(|&column| rows.iter().filter_map(move |&row| patch((column, row)))).collect()
}

/// Coordinates of the ends of a side of a rectangle, and its parameters there.
type RectangleSide = ([f64; 2], [f64; 2]);
