//! Elements: patches of surfaces on which light is assumed to be constant.
//!
//! They are rectangles or triangles of a surface's parameters, so that spheres and NURBS are divided like walls: area and normal come
//! from the geometry. The two sides of a surface have separate elements.

use glanz_geometry::FaceDomain;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{Light, PlacedSurface, Scene};

mod parameter_patch;
mod walls;

pub use parameter_patch::ParameterPatch;

/// Quadrature points along each side of a patch that trimming cuts; a power of two.
const TRIM_GRID: u32 = 8;

/// Largest distance of a point of a flat element from its plane or its straight side, relative to its size.
const FLATNESS: f64 = 1e-9;

/// Bound on the rounding of lengths, relative to them: sides that are longer by no more are not divided.
const LENGTH_ROUNDING: f64 = 1e-9;

/// Location of an element: parameters of one side of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Number of the surface in [`Scene::placed_surfaces`].
    pub surface: u32,
    /// Number of the face of the surface.
    pub face: u32,
    /// Whether it is the side opposite to the normal.
    pub back: bool,
    /// The parameters that it covers.
    pub domain: ParameterPatch,
}

/// A point of a patch, with the area that it represents in integrals.
#[derive(Clone, Copy, Debug)]
pub struct ElementPoint {
    /// Position, metres.
    pub position: DVec3,
    /// Unit normal on the side of the patch.
    pub normal: DVec3,
    /// Bound on the error of the position, metres, see [`glanz_geometry::SurfacePoint::error`].
    pub error: DVec3,
    /// Area that it represents, m^2, 0 or more.
    pub area: f64,
}

/// A patch of a surface with constant light.
#[derive(Clone, Debug)]
pub struct Element {
    /// Its location.
    pub patch: Patch,
    /// Area, m^2, above 0.
    pub area: f64,
    /// Its middle, or the point of the surface nearest to it in the parameters if trimming has removed the middle.
    pub center: ElementPoint,
    /// Corners, metres, counterclockwise seen from its side; `None` unless it is flat with straight sides.
    pub polygon: Option<Vec<DVec3>>,
    /// Fraction of light that is reflected, [0, 1]; all reflection of a material counts as diffuse.
    pub reflectance: Spectrum,
    /// Emitted radiant exitance, in units of radiance times pi.
    pub emission: Spectrum,
}

/// Size of elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementSettings {
    /// Longest side of an element, metres, above 0.
    pub side: f64,
}

/// Error of the division of a scene into elements.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// The side is not a positive, finite length.
    #[error("the side of elements is {0} m; it must be above 0 and finite")]
    Side(f64),
    /// There would be more elements than can be stored.
    #[error("sides of {side} m make more than {limit} elements; choose longer sides")]
    TooMany {
        /// The requested side, metres.
        side: f64,
        /// Largest number of elements.
        limit: usize,
    },
    /// Thin walls cut the elements into more than can be stored.
    #[error(
        "thin walls cut the scene into more than {limit} elements; choose longer sides or a lower density of texels"
    )]
    WallCuts {
        /// Largest number of elements.
        limit: usize,
    },
}

/// Largest number of elements.
const MAX_ELEMENTS: usize = 1 << 22;

/// Division of a scene into elements.
#[derive(Debug)]
pub struct Elements<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its surfaces, as in [`Scene::placed_surfaces`].
    pub surfaces: Vec<PlacedSurface<'a>>,
    /// All elements; those of a face are contiguous.
    pub list: Vec<Element>,
    /// Number of surfaces without parameters or of infinite size: they cast shadows but neither receive nor reflect light.
    pub left_out: usize,
}

impl<'a> Elements<'a> {
    /// Divides both sides of all surfaces of a scene.
    ///
    /// # Errors
    /// [`ElementError::Side`] for a side that is not positive and finite, [`ElementError::TooMany`] if there would be too many elements.
    pub fn new(scene: &'a Scene, settings: &ElementSettings) -> Result<Self, ElementError> {
        let ElementSettings { side } = *settings;
        if !(side > 0.0 && side.is_finite()) {
            return Err(ElementError::Side(side));
        }
        let surfaces = scene.placed_surfaces();
        let mut elements = Self { scene, surfaces, list: Vec::new(), left_out: 0 };
        for (number, surface) in (0_u32..).zip(&elements.surfaces) {
            if surface.is_passable() {
                continue;
            }
            elements.left_out += usize::from(surface.faces() == 0);
            for (face, back) in (0..surface.faces()).flat_map(|face| [(face, false), (face, true)]) {
                let room = MAX_ELEMENTS - elements.list.len();
                let parts = divide_face(surface, face, side).filter(|parts| parts.len() <= room);
                let parts = parts.ok_or(ElementError::TooMany { side, limit: MAX_ELEMENTS })?;
                let patch = |part| Patch { surface: number, face, back, domain: part };
                let found = parts.into_iter().filter_map(|part| element(scene, surface, patch(part)));
                elements.list.extend(found);
            }
        }
        Ok(elements)
    }

    /// Quadrature points of a patch, see [`ParameterPatch::quadrature_points`]; of a patch that is trimmed, those points of a finer grid that trimming
    /// leaves.
    #[must_use]
    pub fn quadrature_points(&self, patch: &Patch) -> Vec<ElementPoint> {
        self.surfaces
            .get(patch.surface as usize)
            .map_or_else(Vec::new, |surface| quadrature_points(surface, patch))
    }

    /// The element on a patch; `None` if trimming leaves nothing of it.
    #[must_use]
    pub fn element(&self, patch: Patch) -> Option<Element> {
        element(self.scene, self.surfaces.get(patch.surface as usize)?, patch)
    }

    /// The elements on the four quarters of an element's parameters, without those of which trimming leaves nothing.
    #[must_use]
    pub fn quarters(&self, whole: &Element) -> Vec<Element> {
        let quarters = whole.patch.domain.quarters().into_iter();
        quarters.filter_map(|domain| self.element(Patch { domain, ..whole.patch })).collect()
    }

    /// The point of a patch at `uv`, with area 0; `None` where trimming has removed the surface.
    #[must_use]
    pub fn point(&self, patch: &Patch, uv: DVec2) -> Option<ElementPoint> {
        element_point(self.surfaces.get(patch.surface as usize)?, patch, uv, 0.0)
    }
}

fn element_point(surface: &PlacedSurface<'_>, patch: &Patch, uv: DVec2, size: f64) -> Option<ElementPoint> {
    let at = surface.at(patch.face, uv, patch.back)?;
    let point = &at.at.point;
    Some(ElementPoint {
        position: point.position,
        normal: at.at.wo,
        error: point.error,
        area: at.area_element * size,
    })
}

fn quadrature_points(surface: &PlacedSurface<'_>, patch: &Patch) -> Vec<ElementPoint> {
    let sample = |points: &[DVec2]| -> Vec<ElementPoint> {
        let size = patch.domain.size() / points.len() as f64;
        points.iter().filter_map(|&uv| element_point(surface, patch, uv, size)).collect()
    };
    let points = patch.domain.quadrature_points();
    let regular = sample(&points);
    if regular.len() == points.len() && !surface.is_trimmed() {
        return regular;
    }
    sample(&trim_grid_points(&patch.domain))
}

/// Middles of [`TRIM_GRID`] x [`TRIM_GRID`] equal patches.
fn trim_grid_points(part: &ParameterPatch) -> Vec<DVec2> {
    let mut parts = vec![*part];
    for _ in 0..TRIM_GRID.ilog2() {
        parts = parts.iter().flat_map(ParameterPatch::quarters).collect();
    }
    parts.iter().map(ParameterPatch::center).collect()
}

/// Division of a face into patches with sides of at most `side` metres; `None` if they are more than [`MAX_ELEMENTS`].
fn divide_face(surface: &PlacedSurface<'_>, face: u32, side: f64) -> Option<Vec<ParameterPatch>> {
    let length = |from: DVec2, to: DVec2| {
        let n = 16;
        let points =
            (0..=n).filter_map(|i| surface.at(face, from.lerp(to, f64::from(i) / f64::from(n)), false));
        let points: Vec<DVec3> = points.map(|at| at.at.point.position).collect();
        points.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
    };
    // Clamped so that the product below cannot overflow; larger counts are refused there.
    let count =
        |length: f64| (length / side * (1.0 - LENGTH_ROUNDING)).ceil().clamp(1.0, MAX_ELEMENTS as f64) as u32;
    match surface.face_domain(face) {
        FaceDomain::Square => {
            let lines = [0.0, 0.5, 1.0];
            let along_u = lines.map(|v| length(DVec2::new(0.0, v), DVec2::new(1.0, v)));
            let along_v = lines.map(|u| length(DVec2::new(u, 0.0), DVec2::new(u, 1.0)));
            let [columns, rows] = [along_u, along_v].map(|l| count(l.into_iter().fold(0.0, f64::max)));
            let fits = u64::from(columns) * u64::from(rows) <= MAX_ELEMENTS as u64;
            fits.then(|| ParameterPatch::SQUARE.grid(columns, rows))
        }
        FaceDomain::Polygon(corners) => {
            let mut parts = ParameterPatch::fan(&corners);
            let longest = |part: &ParameterPatch| {
                let corners = part.corners();
                let ends = corners.iter().zip(corners.iter().cycle().skip(1));
                ends.map(|(&from, &to)| length(from, to)).fold(0.0, f64::max)
            };
            let most = parts.iter().map(longest).fold(0.0, f64::max);
            // Quarters have sides of half the length.
            let mut rest = most;
            while rest > side * (1.0 + LENGTH_ROUNDING) {
                if 4 * parts.len() > MAX_ELEMENTS {
                    return None;
                }
                parts = parts.iter().flat_map(ParameterPatch::quarters).collect();
                rest *= 0.5;
            }
            Some(parts)
        }
    }
}

fn element(scene: &Scene, surface: &PlacedSurface<'_>, patch: Patch) -> Option<Element> {
    let points = quadrature_points(surface, &patch);
    let area: f64 = points.iter().map(|point| point.area).sum();
    if !(area > 0.0 && area.is_finite()) {
        return None;
    }
    // Trimming may have removed the middle.
    let middle = patch.domain.center();
    let at = match surface.at(patch.face, middle, patch.back) {
        Some(at) => at,
        None => surface.at(patch.face, nearest_remaining_point(surface, &patch, middle)?, patch.back)?,
    };
    let point = &at.at.point;
    let center = ElementPoint { position: point.position, normal: at.at.wo, error: point.error, area };
    let wavelengths = Wavelengths::default();
    let bsdf = at.at.bsdf(scene, &wavelengths)?;
    let emitted = match at.at.light().and_then(|id| scene.light(id)) {
        Some(Light::Area(light)) => light.emitted_fraction(at.opacity),
        _ => 1.0,
    };
    Some(Element {
        polygon: flat_corners(surface, &patch),
        patch,
        area,
        center,
        reflectance: bsdf.reflected(at.at.frame_of(&bsdf, at.at.point.shading_normal).to_local(at.at.wo))
            * at.opacity,
        emission: scene.emitted(&at.at, at.at.wo) * (emitted * std::f32::consts::PI),
    })
}

/// The point nearest to the middle that trimming leaves.
fn nearest_remaining_point(surface: &PlacedSurface<'_>, patch: &Patch, middle: DVec2) -> Option<DVec2> {
    let kept =
        trim_grid_points(&patch.domain).into_iter().filter(|&uv| surface.at(patch.face, uv, false).is_some());
    kept.min_by(|a, b| a.distance_squared(middle).total_cmp(&b.distance_squared(middle)))
}

/// The corners of a patch if it is flat with straight sides.
fn flat_corners(surface: &PlacedSurface<'_>, patch: &Patch) -> Option<Vec<DVec3>> {
    if surface.is_trimmed() {
        return None;
    }
    let at = |uv: DVec2| surface.at(patch.face, uv, patch.back);
    let middle = at(patch.domain.center())?;
    let normal = middle.at.wo;
    let uvs = patch.domain.corners();
    let mut corners = Vec::new();
    for &uv in &uvs {
        corners.push(at(uv)?.at.point.position);
    }
    let size = corners.iter().map(|c| c.distance(middle.at.point.position)).fold(0.0, f64::max);
    let is_in_plane = |p: DVec3| (p - middle.at.point.position).dot(normal).abs() <= FLATNESS * size;
    for (i, (&from, &to)) in uvs.iter().zip(uvs.iter().cycle().skip(1)).enumerate() {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let along = (b - a).normalize_or_zero();
        for share in [0.25, 0.5, 0.75] {
            let p = at(from.lerp(to, share))?;
            let off = (p.at.point.position - a).reject_from(along);
            let inside = at(from.lerp(to, share).lerp(patch.domain.center(), 0.5))?;
            let flat = p.at.wo.dot(normal) > 1.0 - FLATNESS && inside.at.wo.dot(normal) > 1.0 - FLATNESS;
            if off.length() > FLATNESS * size || !is_in_plane(inside.at.point.position) || !flat {
                return None;
            }
        }
    }
    if !corners.iter().all(|&corner| is_in_plane(corner)) {
        return None;
    }
    let area: DVec3 =
        (1..corners.len() - 1).map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0])).sum();
    if area.dot(normal) < 0.0 {
        corners.reverse();
    }
    Some(corners)
}

#[cfg(test)]
mod tests;
