//! Freeform surfaces: rays against rational Bézier patches, without facets.
//!
//! A [`Freeform`] is made of [`Piece`]s, patches over parts of a parameter domain: the Bézier pieces of a spline
//! surface, a list of patches, the quadrilaterals of triangular patches. They are cut into *leaves* that are almost
//! parallelograms, and a hierarchy is built over these. Every root of a ray is found, none twice, none is invented:
//! `draft` bounds how far a leaf is from a parallelogram; `leaf` uses that to exclude it, or to certify that it has one root
//! at most. That is found in the patch that the leaf is a part of, by `bicubic` and `view` for low degrees, `search` for all
//! others, with `contract` where it is next to a border; `cells` splits what is not certified. `net` evaluates.
//!
//! ```
//! use glanz_geometry::bezier::TensorPatch;
//! use glanz_geometry::freeform::{Freeform, Piece};
//! use glanz_geometry::RaySurface;
//! use glanz_math::{DVec3, Ray, glam::DVec4};
//!
//! // z = 4 x (1 - x) over the unit square: a parabola pulled along y.
//! let points = [0.0, 0.5, 1.0].into_iter().flat_map(|x| {
//!     let z = if x == 0.5 { 2.0 } else { 0.0 };
//!     [0.0, 1.0].map(|y| DVec4::new(x, y, z, 1.0))
//! });
//! let patch = TensorPatch::try_new(2, 1, points.collect())?;
//! let surface = Freeform::try_new(vec![Piece::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0])?])?;
//! let ray = Ray::new(DVec3::new(0.25, 0.5, 5.0), DVec3::NEG_Z);
//! let hit = surface.intersect(&ray, f64::INFINITY).expect("it is above the surface");
//! assert!((hit.t - (5.0 - 0.75)).abs() < 1e-14);
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

mod bicubic;
mod build;
mod cells;
mod contract;
mod draft;
mod leaf;
mod net;
pub mod newton;
mod part;
mod piece;
mod point;
mod query;
mod search;
mod subpatches;
#[cfg(test)]
mod tests;
mod view;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use glanz_math::{AreaPdf, Bounds3, DVec2, Ray};

use self::leaf::Leaf;
pub use self::net::MAX_DEGREE;
pub use self::piece::Piece;
use self::point::Areas;
use self::query::{Closest, Every, Occluded};
use self::search::{Root, Sight};
use self::subpatches::{Forms, Place};
use crate::bvh::{Bvh, Statistics};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;
use crate::trim::TrimRegion;

/// A surface of rational Bézier patches with a hierarchy of its own.
///
/// `Hit::face` is the position of the piece, `u` and `v` are the parameters of its patch, in [0, 1]; those of the surface
/// are [`SurfacePoint::uv`]. The normal is that of dpdu x dpdv.
#[derive(Debug)]
pub struct Freeform {
    pieces: Vec<Piece>,
    /// What is kept of the parameters, if not all.
    region: Option<Arc<TrimRegion>>,
    /// Diagonal of a box around the control points, metres.
    extent: f64,
    bvh: Bvh,
    /// By position in the hierarchy.
    leaves: Vec<Leaf>,
    /// What they are parts of, and where that is.
    forms: Forms,
    places: Vec<Place>,
    sight: Sight,
    /// Leaves without certified answer: see [`Freeform::undecided`].
    undecided: AtomicU64,
    /// Only surfaces that shine need it.
    areas: OnceLock<Areas>,
}

impl Freeform {
    /// Bézier patches, in the order of `Hit::face`.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Whether the trimming region keeps the point with such parameters of the surface; all are kept without one.
    pub(crate) fn keeps_parameters(&self, uv: DVec2) -> bool {
        self.region.as_ref().is_none_or(|region| region.contains(uv))
    }

    /// What is kept of its parameters, if not all.
    #[must_use]
    pub fn region(&self) -> Option<&Arc<TrimRegion>> {
        self.region.as_ref()
    }

    /// Whether it is what a region keeps of another.
    #[must_use]
    pub fn is_trimmed(&self) -> bool {
        self.region.is_some()
    }

    /// Searches since the surface was built that gave up on a leaf, whose answer may therefore lack a root. It is
    /// expected to be 0.
    #[must_use]
    pub fn undecided(&self) -> u64 {
        self.undecided.load(Ordering::Relaxed)
    }

    /// Whether the trimming region keeps a root in a leaf that a curve of it crosses.
    #[cold]
    fn keeps(&self, place: &Place, root: &Root) -> bool {
        let DVec2 { x: u, y: v } = place.part.at(root.at);
        let region_and_piece = self.region.as_ref().zip(self.pieces.get(place.piece as usize));
        region_and_piece.is_none_or(|(region, piece)| region.contains(piece.parameters(u, v)))
    }

    /// Area, m^2, to about 1e-6 of itself; if trimmed, to about 1e-3.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas().total()
    }

    /// How large the hierarchy came out, and how good; its primitives are leaves of the patches.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        self.bvh.statistics()
    }

    /// Memory of patches, leaves and hierarchy, bytes. A trimming region, which may be shared, is not counted.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let patches: usize = self.pieces.iter().map(|p| size_of_val(p.patch.control_points())).sum();
        size_of_val(&*self.pieces)
            + patches
            + size_of_val(&*self.leaves)
            + self.forms.bytes()
            + size_of_val(&*self.places)
            + self.statistics().bytes
    }
}

impl RaySurface for Freeform {
    fn bounds(&self) -> Bounds3 {
        self.bvh.bounds()
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.bvh.isa().run(Closest { surface: self, ray, t_max })
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.bvh.isa().run(Occluded { surface: self, ray, t_max })
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        self.bvh.isa().run(Every { surface: self, ray, t_max, hits });
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.face, hit.u, hit.v)
    }

    /// With a density in (u, v) that goes bilinearly between the area elements at the corners of each leaf: nearly
    /// uniform over the area. A trimmed surface cannot be sampled: how much is kept of a leaf has no closed form.
    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        if self.region.is_some() { None } else { self.sample_area(xi) }
    }

    fn area_pdf(&self, hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        if self.region.is_some() { None } else { self.density(hit) }
    }
}
