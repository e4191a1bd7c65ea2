//! The surface behind a Python object.

use std::sync::{Arc, OnceLock, RwLock};

use glanz::geometry::bezier::{TensorPatch, TrianglePatch, TriangleQuad};
use glanz::geometry::freeform::{Freeform, SurfacePatch};
use glanz::geometry::rational::ParameterMap;
use glanz::geometry::spline::{AreaEstimate, ClosestPoint, KnotVector, NurbsSurface, SurfaceCurvature};
use glanz::geometry::trim::TrimRegion;
use glanz::geometry::{Bounds3, DVec2, DVec3, Hit, RaySurface, Surface, SurfaceError, SurfacePoint};

/// A surface as it was given.
pub(crate) enum Definition {
    /// A spline surface, with the part that is kept.
    Nurbs(Box<NurbsSurface>, Option<Arc<TrimRegion>>),
    /// A triangular patch.
    Triangle(TrianglePatch),
    /// A surface given by an equation.
    Equation(Box<Surface>),
}

/// A part of a surface as a spline surface, for measures.
struct SplinePart {
    spline: NurbsSurface,
    parameters: PartParameters,
}

/// The parameters of the surface as a function of those of a part.
enum PartParameters {
    Quad([DVec2; 4]),
    Separate(ParameterMap, ParameterMap),
}

impl PartParameters {
    fn at(&self, x: f64, y: f64) -> DVec2 {
        match self {
            Self::Quad([p00, p10, p01, p11]) => p00.lerp(*p10, x).lerp(p01.lerp(*p11, x), y),
            Self::Separate(u, v) => DVec2::new(u.parameter(x), v.parameter(y)),
        }
    }
}

/// A surface, and what is built from it on first use.
pub(crate) struct SurfaceState {
    pub(crate) definition: Definition,
    /// Held for reading by searches, and alone by those that compare the surface's number of undecided searches.
    pub(super) searches: RwLock<()>,
    rays: OnceLock<Result<Surface, SurfaceError>>,
    parts: OnceLock<Result<Vec<SplinePart>, SurfaceError>>,
}

impl From<Definition> for SurfaceState {
    fn from(definition: Definition) -> Self {
        Self { definition, searches: RwLock::new(()), rays: OnceLock::new(), parts: OnceLock::new() }
    }
}

impl SurfaceState {
    /// The surface for rays.
    pub(crate) fn for_rays(&self) -> Result<&Surface, SurfaceError> {
        let build = || match &self.definition {
            Definition::Nurbs(spline, None) => Ok(spline.to_freeform()?.into()),
            Definition::Nurbs(spline, Some(region)) => {
                Ok(Freeform::try_trimmed(spline.surface_patches()?, region.clone())?.into())
            }
            Definition::Triangle(_) => {
                let patch = |TriangleQuad { patch, corners }| SurfacePatch::over_quad(patch, corners);
                Ok(Freeform::try_new(self.quads(patch)?)?.into())
            }
            Definition::Equation(surface) => Ok(Surface::clone(surface)),
        };
        self.rays.get_or_init(build).as_ref().map_err(Clone::clone)
    }

    /// A box that contains the surface.
    pub(crate) fn bounds(&self) -> Bounds3 {
        match &self.definition {
            Definition::Nurbs(spline, _) => spline.bounds(),
            Definition::Triangle(patch) => patch.bounds(),
            Definition::Equation(surface) => surface.bounds(),
        }
    }

    /// Ranges of u and of v.
    pub(crate) fn domain(&self) -> [[f64; 2]; 2] {
        match &self.definition {
            Definition::Nurbs(spline, _) => [spline.knots_u().domain(), spline.knots_v().domain()],
            Definition::Equation(surface) => match &**surface {
                Surface::Plane(plane) => plane.domain(),
                _ => [[0.0, 1.0]; 2],
            },
            Definition::Triangle(_) => [[0.0, 1.0]; 2],
        }
    }

    /// The next parameters in the domain.
    fn clamped(&self, uv: DVec2) -> DVec2 {
        let [u, v] = self.domain();
        let inside = DVec2::new(uv.x.clamp(u[0], u[1]), uv.y.clamp(v[0], v[1]));
        match &self.definition {
            Definition::Triangle(_) => inside / inside.element_sum().max(1.0),
            _ => inside,
        }
    }

    /// The highest order of derivatives.
    pub(crate) fn max_order(&self) -> u32 {
        match &self.definition {
            Definition::Equation(_) => 1,
            _ => 16,
        }
    }

    /// Writes the derivatives up to a total `order`: that of order k in u and l in v at `(k (order + 1) + l) * 3`. The others, and all at
    /// parameters that are not numbers, are not numbers.
    pub(crate) fn derivatives(&self, uv: DVec2, order: usize, values: &mut [f64]) {
        values.fill(f64::NAN);
        if uv.is_nan() {
            return;
        }
        let uv = self.clamped(uv);
        let mut write = |k: usize, l: usize, value: DVec3| {
            let start = 3 * (k * (order + 1) + l);
            if let Some(place) = values.get_mut(start..start + 3) {
                place.copy_from_slice(&value.to_array());
            }
        };
        let all = match &self.definition {
            Definition::Nurbs(spline, _) if order == 0 => return write(0, 0, spline.point(uv.x, uv.y)),
            Definition::Triangle(patch) if order == 0 => return write(0, 0, patch.point(uv.x, uv.y)),
            Definition::Nurbs(spline, _) => spline.derivatives(uv.x, uv.y, order),
            Definition::Triangle(patch) => patch.derivatives(uv.x, uv.y, order),
            Definition::Equation(surface) => {
                let Some(point) = equation_point(surface, uv) else { return };
                write(0, 0, point.position);
                if order > 0 {
                    write(1, 0, point.dpdu);
                    write(0, 1, point.dpdv);
                }
                return;
            }
        };
        for (k, l) in (0..=order).flat_map(|k| (0..=order - k).map(move |l| (k, l))) {
            if let Some(value) = all.get(k, l) {
                write(k, l, value);
            }
        }
    }

    /// The unit normal, if there is one.
    pub(crate) fn normal(&self, uv: DVec2) -> Option<DVec3> {
        if uv.is_nan() {
            return None;
        }
        let uv = self.clamped(uv);
        match &self.definition {
            Definition::Nurbs(spline, _) => spline.normal(uv.x, uv.y),
            Definition::Triangle(patch) => patch.normal(uv.x, uv.y),
            Definition::Equation(surface) => Some(equation_point(surface, uv)?.normal),
        }
    }

    /// The curvature, where the tangents span a plane.
    pub(crate) fn curvature(&self, uv: DVec2) -> Option<SurfaceCurvature> {
        if uv.is_nan() {
            return None;
        }
        let uv = self.clamped(uv);
        match &self.definition {
            Definition::Nurbs(spline, _) => spline.curvature(uv.x, uv.y),
            Definition::Triangle(patch) => {
                SurfaceCurvature::from_derivatives(&patch.derivatives(uv.x, uv.y, 2))
            }
            Definition::Equation(surface) => {
                let point = equation_point(surface, uv)?;
                let turn = surface.normal_derivatives(&Hit::new(0.0, uv.x, uv.y, 0), &point);
                SurfaceCurvature::from_normal_derivatives([point.dpdu, point.dpdv], turn)
            }
        }
    }

    /// Whether a part is cut away.
    pub(crate) fn is_trimmed(&self) -> bool {
        matches!(&self.definition, Definition::Nurbs(_, Some(_)))
    }

    /// Whether trims keep the point with these parameters.
    pub(crate) fn keeps(&self, uv: DVec2) -> bool {
        match &self.definition {
            Definition::Nurbs(_, Some(region)) => region.contains(uv),
            _ => true,
        }
    }

    /// The area of the kept part, m^2, with its error; `tolerance`: its largest error, as far as it can be reached.
    pub(crate) fn area(&self, tolerance: f64) -> Result<AreaEstimate, SurfaceError> {
        match &self.definition {
            Definition::Nurbs(spline, None) => spline.area(tolerance),
            Definition::Nurbs(spline, Some(region)) => spline.kept_area(region, tolerance),
            _ => {
                let parts = self.parts()?;
                let share = (tolerance / parts.len() as f64).max(f64::MIN_POSITIVE);
                let mut sum = AreaEstimate { value: 0.0, error: 0.0 };
                for part in parts {
                    let area = part.spline.area(share)?;
                    sum.value += area.value;
                    sum.error += area.error;
                }
                Ok(sum)
            }
        }
    }

    /// The point nearest to `query`, trims aside.
    pub(crate) fn closest_point(
        &self,
        query: DVec3,
        tolerance: f64,
    ) -> Result<Option<ClosestPoint>, SurfaceError> {
        if let Definition::Nurbs(spline, _) = &self.definition {
            return spline.closest_point(query, tolerance).map(Some);
        }
        let (mut best, mut lower_bound): (Option<ClosestPoint>, _) = (None, f64::INFINITY);
        for part in self.parts()? {
            let found = part.spline.closest_point(query, tolerance)?;
            lower_bound = found.lower_bound.min(lower_bound);
            if best.is_none_or(|best| found.distance < best.distance) {
                let DVec2 { x: u, y: v } = part.parameters.at(found.u, found.v);
                best = Some(ClosestPoint { u, v, ..found });
            }
        }
        Ok(best.map(|best| ClosestPoint { lower_bound, ..best }))
    }

    /// Builds what [`Self::closest_point`] and [`Self::area`] need.
    fn parts(&self) -> Result<&[SplinePart], SurfaceError> {
        let build = || match &self.definition {
            Definition::Triangle(_) => self.quads(|TriangleQuad { patch, corners }| {
                Ok(SplinePart { spline: spline(&patch)?, parameters: PartParameters::Quad(corners) })
            }),
            Definition::Equation(surface) => {
                let infinite =
                    SurfaceError::NotFinite { parameter: "extent of the surface", value: f64::INFINITY };
                let patches = surface.rational_patches().ok_or(infinite)?;
                let part = |patch: &glanz::geometry::rational::RationalPatch| {
                    let parameters = PartParameters::Separate(patch.u, patch.v);
                    Ok(SplinePart { spline: spline(&patch.patch)?, parameters })
                };
                patches.iter().map(part).collect()
            }
            Definition::Nurbs(..) => Ok(Vec::new()),
        };
        self.parts.get_or_init(build).as_deref().map_err(Clone::clone)
    }

    /// The quadrilaterals of a triangular patch; none of other surfaces.
    fn quads<T>(
        &self,
        part: impl Fn(TriangleQuad) -> Result<T, SurfaceError>,
    ) -> Result<Vec<T>, SurfaceError> {
        match &self.definition {
            Definition::Triangle(patch) => patch.to_quads().into_iter().map(part).collect(),
            _ => Ok(Vec::new()),
        }
    }
}

/// The point of a surface given by an equation.
fn equation_point(surface: &Surface, uv: DVec2) -> Option<SurfacePoint> {
    match surface {
        Surface::Plane(plane) => Some(plane.point_at(uv)),
        _ => surface.untrimmed_at(0, uv),
    }
}

/// A patch as a spline surface over the unit square.
fn spline(patch: &TensorPatch) -> Result<NurbsSurface, SurfaceError> {
    let (p, q) = patch.degrees();
    let [knots_u, knots_v] = [KnotVector::clamped_uniform(p, p + 1)?, KnotVector::clamped_uniform(q, q + 1)?];
    NurbsSurface::from_knots(knots_u, knots_v, patch.control_points().to_vec())
}
