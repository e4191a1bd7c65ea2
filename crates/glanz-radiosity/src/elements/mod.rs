//! Elements: parts of surfaces over which light is taken for constant.
//!
//! They lie in the parameters of a surface, so that a sphere or a NURBS vase carries them as a wall does: area and normal come from
//! the geometry. The two sides of a surface have elements of their own.

use glanz_geometry::FaceDomain;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};

mod part;
mod quadtree;
mod walls;

pub use part::Part;
pub use quadtree::{Leaf, Quadtree, QuadtreeSettings};

/// Places per side at which a part that is cut by trimming is looked at.
const CUT: u32 = 8;

/// Largest distance of a point of a flat element from its plane or its straight side, per its size.
const FLAT: f64 = 1e-9;

/// Where elements lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Number of the surface in [`Scene::placed_surfaces`].
    pub surface: u32,
    /// Its face.
    pub face: u32,
    /// Whether it is the side that the normal does not point to.
    pub back: bool,
    /// The part of the parameters.
    pub part: Part,
}

/// A place of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Metres.
    pub position: DVec3,
    /// Unit normal on the side of the patch.
    pub normal: DVec3,
    /// Error of the position, see [`glanz_geometry::SurfacePoint::error`].
    pub error: DVec3,
    /// The area that it stands for, m^2.
    pub area: f64,
}

/// A part of a surface with constant light.
#[derive(Clone, Debug)]
pub struct Element {
    /// Where it lies.
    pub patch: Patch,
    /// Area, m^2, above 0.
    pub area: f64,
    /// Its middle.
    pub center: Node,
    /// If it is a flat polygon with straight sides: the corners, counterclockwise seen from its side.
    pub polygon: Option<Vec<DVec3>>,
    /// Share of light that is reflected; what a material reflects in whatever way counts as if it were diffuse.
    pub reflectance: Spectrum,
    /// Radiant exitance of its own, in units of radiance times pi.
    pub emission: Spectrum,
}

/// How large elements are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementSettings {
    /// Longest side of an element, metres.
    pub side: f64,
}

/// Why a scene cannot be divided.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// Not a length.
    #[error("elements need a side above 0 m, not {0}")]
    Side(f64),
    /// More than can be numbered or kept.
    #[error("sides of {side} m would make more than {limit} elements: choose larger ones")]
    TooMany {
        /// That was asked for.
        side: f64,
        /// Elements at most.
        limit: usize,
    },
    /// No quadtree.
    #[error("elements cannot be divided at differences above {threshold} from level {first} to {deepest}")]
    Division {
        /// That was asked for, 0 or more.
        threshold: f64,
        /// At most as deep as the deepest.
        first: u32,
        /// At most 24.
        deepest: u32,
    },
    /// More leaves than can be kept.
    #[error("a quadtree would have more than {limit} elements: choose a larger threshold or fewer levels")]
    TooFine {
        /// Elements at most.
        limit: usize,
    },
}

/// Elements at most.
const LIMIT: usize = 1 << 22;

/// A scene in elements.
#[derive(Debug)]
pub struct Elements<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its surfaces.
    pub surfaces: Vec<PlacedSurface<'a>>,
    /// All elements; those of a face follow one another.
    pub list: Vec<Element>,
    /// Surfaces without parameters, or without end: they throw shadows but neither receive nor reflect light.
    pub left_out: usize,
}

impl<'a> Elements<'a> {
    /// Divides all surfaces of a scene.
    ///
    /// # Errors
    /// [`ElementError`].
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
                let room = LIMIT - elements.list.len();
                let parts = divided(surface, face, side).filter(|parts| parts.len() <= room);
                let parts = parts.ok_or(ElementError::TooMany { side, limit: LIMIT })?;
                let patch = |part| Patch { surface: number, face, back, part };
                let found = parts.into_iter().filter_map(|part| element(scene, surface, patch(part)));
                elements.list.extend(found);
            }
        }
        Ok(elements)
    }

    /// Places that stand for a patch in integrals, see [`Part::nodes`]; where it is cut, more and those that are left.
    #[must_use]
    pub fn nodes(&self, patch: &Patch) -> Vec<Node> {
        self.surfaces.get(patch.surface as usize).map_or_else(Vec::new, |surface| nodes(surface, patch))
    }

    /// The element on a patch; `None` if nothing of the surface is there.
    #[must_use]
    pub fn element(&self, patch: Patch) -> Option<Element> {
        element(self.scene, self.surfaces.get(patch.surface as usize)?, patch)
    }

    /// The place of a patch at `uv`; it stands for no area. `None` where trimming has cut it away.
    #[must_use]
    pub fn place(&self, patch: &Patch, uv: DVec2) -> Option<Node> {
        node(self.surfaces.get(patch.surface as usize)?, patch, uv, 0.0)
    }
}

fn node(surface: &PlacedSurface<'_>, patch: &Patch, uv: DVec2, size: f64) -> Option<Node> {
    let at = surface.at(patch.face, uv, patch.back)?;
    let point = &at.at.point;
    Some(Node {
        position: point.position,
        normal: at.at.wo,
        error: point.error,
        area: at.area_element * size,
    })
}

fn nodes(surface: &PlacedSurface<'_>, patch: &Patch) -> Vec<Node> {
    let of = |places: &[DVec2]| -> Vec<Node> {
        let size = patch.part.size() / places.len() as f64;
        places.iter().filter_map(|&uv| node(surface, patch, uv, size)).collect()
    };
    let places = patch.part.nodes();
    let regular = of(&places);
    if regular.len() == places.len() && !surface.is_trimmed() {
        return regular;
    }
    of(&cut_places(&patch.part))
}

/// Middles of [`CUT`] x [`CUT`] equal parts.
fn cut_places(part: &Part) -> Vec<DVec2> {
    let mut parts = vec![*part];
    for _ in 0..CUT.ilog2() {
        parts = parts.iter().flat_map(Part::quarters).collect();
    }
    parts.iter().map(Part::center).collect()
}

/// The parts of a face, with sides of `side` metres at most; `None` if they are more than [`LIMIT`].
fn divided(surface: &PlacedSurface<'_>, face: u32, side: f64) -> Option<Vec<Part>> {
    let length = |from: DVec2, to: DVec2| {
        let n = 16;
        let places =
            (0..=n).filter_map(|i| surface.at(face, from.lerp(to, f64::from(i) / f64::from(n)), false));
        let places: Vec<DVec3> = places.map(|at| at.at.point.position).collect();
        places.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
    };
    // What is more is refused all the same.
    let count = |length: f64| (length / side * (1.0 - 1e-9)).ceil().clamp(1.0, LIMIT as f64) as u32;
    match surface.face_domain(face) {
        FaceDomain::Square => {
            let lines = [0.0, 0.5, 1.0];
            let along_u = lines.map(|v| length(DVec2::new(0.0, v), DVec2::new(1.0, v)));
            let along_v = lines.map(|u| length(DVec2::new(u, 0.0), DVec2::new(u, 1.0)));
            let [columns, rows] = [along_u, along_v].map(|l| count(l.into_iter().fold(0.0, f64::max)));
            let fits = u64::from(columns) * u64::from(rows) <= LIMIT as u64;
            fits.then(|| Part::SQUARE.grid(columns, rows))
        }
        FaceDomain::Polygon(corners) => {
            let mut parts = filled(&corners);
            let longest = |part: &Part| {
                let corners = part.corners();
                let ends = corners.iter().zip(corners.iter().cycle().skip(1));
                ends.map(|(&from, &to)| length(from, to)).fold(0.0, f64::max)
            };
            let most = parts.iter().map(longest).fold(0.0, f64::max);
            // Quarters have sides of half the length.
            let mut rest = most;
            while rest > side * (1.0 + 1e-9) {
                if 4 * parts.len() > LIMIT {
                    return None;
                }
                parts = parts.iter().flat_map(Part::quarters).collect();
                rest *= 0.5;
            }
            Some(parts)
        }
    }
}

/// A face in the fewest parts.
fn face_parts(surface: &PlacedSurface<'_>, face: u32) -> Vec<Part> {
    match surface.face_domain(face) {
        FaceDomain::Square => vec![Part::SQUARE],
        FaceDomain::Polygon(corners) => filled(&corners),
    }
}

/// Triangles that fill a convex polygon.
fn filled(corners: &[DVec2]) -> Vec<Part> {
    match corners {
        [a, rest @ ..] => rest.windows(2).map(|pair| Part::Triangle([*a, pair[0], pair[1]])).collect(),
        [] => Vec::new(),
    }
}

fn element(scene: &Scene, surface: &PlacedSurface<'_>, patch: Patch) -> Option<Element> {
    let nodes = nodes(surface, &patch);
    let area: f64 = nodes.iter().map(|node| node.area).sum();
    if !(area > 0.0 && area.is_finite()) {
        return None;
    }
    // Trimming may have cut the middle away.
    let middle = patch.part.center();
    let at = match surface.at(patch.face, middle, patch.back) {
        Some(at) => at,
        None => surface.at(patch.face, nearest_kept(surface, &patch, middle)?, patch.back)?,
    };
    let point = &at.at.point;
    let center = Node { position: point.position, normal: at.at.wo, error: point.error, area };
    let wavelengths = Wavelengths::default();
    let bsdf = at.at.bsdf(scene, &wavelengths)?;
    Some(Element {
        polygon: polygon(surface, &patch),
        patch,
        area,
        center,
        reflectance: bsdf.albedo(at.at.frame().to_local(at.at.wo)),
        emission: scene.emitted(&at.at, at.at.wo) * std::f32::consts::PI,
    })
}

/// Of the places that are kept, the one next to the middle.
fn nearest_kept(surface: &PlacedSurface<'_>, patch: &Patch, middle: DVec2) -> Option<DVec2> {
    let kept = cut_places(&patch.part).into_iter().filter(|&uv| surface.at(patch.face, uv, false).is_some());
    kept.min_by(|a, b| a.distance_squared(middle).total_cmp(&b.distance_squared(middle)))
}

/// The corners of a patch if it is a flat polygon.
fn polygon(surface: &PlacedSurface<'_>, patch: &Patch) -> Option<Vec<DVec3>> {
    if surface.is_trimmed() {
        return None;
    }
    let at = |uv: DVec2| surface.at(patch.face, uv, patch.back);
    let middle = at(patch.part.center())?;
    let normal = middle.at.wo;
    let uvs = patch.part.corners();
    let mut corners = Vec::new();
    for &uv in &uvs {
        corners.push(at(uv)?.at.point.position);
    }
    let size = corners.iter().map(|c| c.distance(middle.at.point.position)).fold(0.0, f64::max);
    let is_in_plane = |p: DVec3| (p - middle.at.point.position).dot(normal).abs() <= FLAT * size;
    for (i, (&from, &to)) in uvs.iter().zip(uvs.iter().cycle().skip(1)).enumerate() {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let along = (b - a).normalize_or_zero();
        for share in [0.25, 0.5, 0.75] {
            let p = at(from.lerp(to, share))?;
            let off = (p.at.point.position - a).reject_from(along);
            let inside = at(from.lerp(to, share).lerp(patch.part.center(), 0.5))?;
            let flat = p.at.wo.dot(normal) > 1.0 - FLAT && inside.at.wo.dot(normal) > 1.0 - FLAT;
            if off.length() > FLAT * size || !is_in_plane(inside.at.point.position) || !flat {
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
