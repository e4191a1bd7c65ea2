//! Freeform surfaces: ray intersection with rational Bézier patches, without tessellation.
//!
//! A [`Freeform`] consists of [`SurfacePatch`]es, patches over parts of a parameter domain: the Bézier patches of a spline
//! surface, a list of patches, the quadrilaterals of triangular patches. They are split into *leaves* that are almost
//! parallelograms, and a hierarchy is built over these. Every root of a ray is found, and none is found twice or invented.
//!
//! - Building: `polynomial_patches` turns polynomial patches of low degrees into powers, `subpatches` splits patches whose weights
//!   differ much, `leaf_builder` bounds the deviation of a part from a parallelogram, and `build` halves parts until it is small.
//! - Searching: `leaf` excludes a leaf, or certifies that it has one root at most. The root is found in the subpatch that
//!   contains the leaf: `bicubic` and `projected_bicubic` for low degrees, `net_search` for all others, with `contraction`
//!   near borders. Leaves without a certificate go to `subdivision`, with `cell_class`, `cell_coefficients`, `contact_arc`,
//!   `degree_reduction`, `reduced_net` and `flat_cell`.
//! - Searching for many rays at once: `stream` collects pairs of a ray and a leaf in a `pair_queue`, and `group_solver` solves eight at a
//!   time; `ray_lanes`, `leaf_lanes`, `bicubic_lanes` with `newton_lanes`, and `net_lanes` are `ray_space`, `leaf`, `bicubic` and
//!   `net_search` for eight of them (`pair_lanes`), with the same bits.
//! - Evaluation: `patch_list` by control points (`control_net`) or by the powers that rays search (`bicubic_surface`, with
//!   `net_corrections` for the control points); `surface_point`, `area`.
//!
//! ```
//! use glanz_geometry::bezier::TensorPatch;
//! use glanz_geometry::freeform::{Freeform, SurfacePatch};
//! use glanz_geometry::RaySurface;
//! use glanz_math::{DVec3, Ray, glam::DVec4};
//!
//! // z = 4 x (1 - x) over the unit square: a parabola pulled along y.
//! let points = [0.0, 0.5, 1.0].into_iter().flat_map(|x| {
//!     let z = if x == 0.5 { 2.0 } else { 0.0 };
//!     [0.0, 1.0].map(|y| DVec4::new(x, y, z, 1.0))
//! });
//! let patch = TensorPatch::try_new(2, 1, points.collect())?;
//! let surface = Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0])?])?;
//! let ray = Ray::new(DVec3::new(0.25, 0.5, 5.0), DVec3::NEG_Z);
//! let hit = surface.intersect(&ray, f64::INFINITY).expect("it is above the surface");
//! assert!((hit.t - (5.0 - 0.75)).abs() < 1e-14);
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

mod arc_polynomial;
mod area;
mod bicubic;
mod bicubic_lanes;
mod bicubic_surface;
mod build;
mod cell_class;
mod cell_coefficients;
mod contact_arc;
mod contraction;
mod control_net;
mod degree_reduction;
mod flat_cell;
mod group_solver;
mod leaf;
mod leaf_builder;
mod leaf_lanes;
mod leaf_list;
mod net_corrections;
mod net_lanes;
mod net_search;
mod newton_lanes;
mod pair_lanes;
mod pair_queue;
mod parameter_rect;
mod patch_list;
mod point_lanes;
mod polynomial_patches;
mod projected_bicubic;
mod query;
mod ray_lanes;
mod ray_space;
mod reduced_net;
mod root;
mod stream;
mod subdivision;
mod subpatches;
mod surface_patch;
mod surface_point;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use self::area::LeafAreas;
pub use self::control_net::MAX_DEGREE;
use self::leaf::PatchLeaf;
use self::parameter_rect::DyadicRect;
use self::patch_list::PatchList;
use self::point_lanes::PointBatch;
use self::query::{AllHitsQuery, ClosestQuery, OcclusionQuery};
use self::ray_space::SurfaceFrame;
use self::reduced_net::ReducedNet;
use self::root::SearchScratch;
use self::subpatches::{SubpatchList, SubpatchLocation};
pub use self::surface_patch::SurfacePatch;
use crate::batch::BoundedRay;
use crate::bvh::{Bvh, BvhStatistics};
use crate::hit::{Hit, HitBorder, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;
use crate::trim::TrimRegion;

/// A surface of rational Bézier patches with a hierarchy of its own.
///
/// `Hit::face` is the position of the patch, `u` and `v` are its parameters, in [0, 1]; those of the surface are
/// [`SurfacePoint::uv`]. The normal is that of dpdu x dpdv.
#[derive(Debug)]
pub struct Freeform {
    /// Shared with trimmed parts of the surface, as are subpatches and locations.
    patches: Arc<PatchList>,
    /// The part of the parameters that is kept, if not all.
    region: Option<Arc<TrimRegion>>,
    /// Diagonal of a box around the control points, metres.
    extent: f64,
    bvh: Bvh,
    /// Leaves by position in the hierarchy.
    leaves: Vec<PatchLeaf>,
    /// Nets of leaves of high degree.
    reduced_nets: Vec<ReducedNet>,
    /// Patches of which parts have no area.
    without_area: Vec<u32>,
    /// The subpatches that the leaves are parts of.
    subpatches: Arc<SubpatchList>,
    /// Positions of the subpatches in their patches; none if every patch is one of them, in the same order.
    locations: Arc<[SubpatchLocation]>,
    frame: SurfaceFrame,
    /// See [`Freeform::undecided`] and [`Freeform::subdivision_cells`].
    counters: SubdivisionCounters,
    /// Computed on first use: only emitters need it.
    areas: OnceLock<LeafAreas>,
}

/// Counters of the searches that need subdivision.
#[derive(Debug, Default)]
struct SubdivisionCounters {
    /// Leaves that were given up.
    undecided: AtomicU64,
    /// Cells that were examined.
    cells: AtomicU64,
}

impl SubdivisionCounters {
    /// Adds the counters of a query, and clears them.
    #[inline(always)]
    fn add(&self, scratch: &mut SearchScratch) {
        let SearchScratch { examined, undecided, .. } = scratch;
        // Atomic operations cost more than most queries.
        if *examined > 0 {
            self.cells.fetch_add(std::mem::take(examined), Ordering::Relaxed);
        }
        if *undecided > 0 {
            self.undecided.fetch_add(std::mem::take(undecided), Ordering::Relaxed);
        }
    }
}

impl Freeform {
    /// Whether the trimming region keeps the point with these parameters of the surface; true without a region.
    pub(crate) fn keeps_parameters(&self, uv: DVec2) -> bool {
        self.region.as_ref().is_none_or(|region| region.contains(uv))
    }

    /// The part of the parameters that is kept, if not all.
    #[must_use]
    pub fn region(&self) -> Option<&Arc<TrimRegion>> {
        self.region.as_ref()
    }

    /// Whether the surface has a trimming region.
    #[must_use]
    pub fn is_trimmed(&self) -> bool {
        self.region.is_some()
    }

    /// Number of searches since the surface was built that gave up a leaf, so that a root may be missing. Expected to be 0. A batch of
    /// rays may search leaves that single rays skip behind a closer hit, and count those too, but none that all hits do not need.
    #[must_use]
    pub fn undecided(&self) -> u64 {
        self.counters.undecided.load(Ordering::Relaxed)
    }

    /// Number of cells that subdivisions have examined since the surface was built: those of rays near tangencies, singular points and
    /// curves in the surface, a few hundred each; almost all other rays need none.
    #[must_use]
    pub fn subdivision_cells(&self) -> u64 {
        self.counters.cells.load(Ordering::Relaxed)
    }

    /// The position of a subpatch in its patch.
    #[inline(always)]
    fn location(&self, subpatch: u32) -> SubpatchLocation {
        let whole = SubpatchLocation { patch: subpatch, part: DyadicRect::WHOLE };
        self.locations.get(subpatch as usize).copied().unwrap_or(whole)
    }

    /// The border of the trimming region in which a root lies, in a leaf that one of its curves crosses; `None` if the region cuts the
    /// root away.
    #[cold]
    fn border(&self, location: &SubpatchLocation, at: DVec2) -> Option<HitBorder> {
        let DVec2 { x: u, y: v } = location.part.at(at);
        let region_and_uv = self.region.as_ref().zip(self.parameters(location.patch, u, v));
        region_and_uv.map_or(Some(HitBorder::Away), |(region, uv)| region.locate(uv).border())
    }

    /// Area, m^2, with a relative error of about 1e-6. If trimmed, parts smaller than a 32nd of a leaf are found or missed by chance; see
    /// [`NurbsSurface::kept_area`](crate::spline::NurbsSurface::kept_area).
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas().total()
    }

    /// Numbers of the patches that are lines or points to within rounding, in whole or in part, where the region keeps them, ascending.
    /// No ray meets those parts, unless the surface has no others.
    #[must_use]
    pub fn patches_without_area(&self) -> &[u32] {
        &self.without_area
    }

    /// Size and expected cost of the hierarchy, whose primitives are the leaves of the patches.
    #[must_use]
    pub fn statistics(&self) -> BvhStatistics {
        self.bvh.statistics()
    }

    /// Memory of patches, leaves and hierarchy, bytes, without the trimming region, which may be shared. A trimmed surface counts the
    /// patches that it shares with the whole one.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.patches.bytes()
            + size_of_val(&*self.leaves)
            + self.reduced_nets.iter().map(ReducedNet::bytes).sum::<usize>()
            + self.subpatches.bytes()
            + size_of_val(&*self.locations)
            + self.statistics().bytes
    }
}

impl RaySurface for Freeform {
    fn bounds(&self) -> Bounds3 {
        self.bvh.bounds()
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.bvh.isa().run(ClosestQuery { surface: self, ray, t_max })
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.bvh.isa().run(OcclusionQuery { surface: self, ray, t_max })
    }

    fn closest_batch(&self, rays: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
        self.closest_hits(rays, hits);
    }

    fn occluded_batch(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        self.any_hits(rays, occluded);
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        self.bvh.isa().run(AllHitsQuery { surface: self, ray, t_max, hits });
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.face, hit.u, hit.v)
    }

    fn point_batch(&self, rays: &[Ray], hits: &[Hit], points: &mut Vec<SurfacePoint>) {
        points.clear();
        let hits = &hits[..hits.len().min(rays.len())];
        self.bvh.isa().run(PointBatch { surface: self, hits, points });
    }

    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        self.normal_derivatives_at(hit.face, hit.u, hit.v, point.normal)
    }

    /// The density in (u, v) is bilinear between the area elements at the corners of each leaf: nearly uniform over the
    /// area. A trimmed surface cannot be sampled, since the kept area of a leaf has no closed form.
    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        if self.region.is_some() { None } else { self.sample_leaf(xi) }
    }

    fn area_pdf(&self, hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        if self.region.is_some() { None } else { self.density(hit) }
    }
}
