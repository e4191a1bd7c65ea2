//! Picking: the hit of a ray on the exact surface.

mod curvature;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use glanz_geometry::Surface;
use glanz_math::{DVec3, Ray};
use glanz_scene::{HitLocation, Interaction, ParametricPoint, PlacedSurface, Scene};
use serde::{Deserialize, Serialize};

pub use self::curvature::Curvature;
use crate::leaf_ranges::leaves;
use crate::model::{LuxReading, Model, SurfaceDimensions};

/// Largest number of hidden surfaces that a ray passes.
const MOST_PASSED: usize = 1 << 12;

/// The picked point of a shape, in the world.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PickResult {
    /// Number of the shape, with its copies, in the order of the tree.
    pub leaf: u32,
    /// Number of the object of the model.
    pub object: u32,
    /// Name of the surface in scene files.
    pub kind: &'static str,
    /// Name of the shape in the tree.
    pub name: String,
    /// Name of the material, or its kind if it has none.
    pub material: String,
    /// Degrees of the patch there, if the surface consists of patches.
    pub degree: Option<[usize; 2]>,
    /// Area of the shape, m^2, without what is trimmed away; `None` if it has none.
    pub area: Option<f64>,
    /// Lengths and angles of the surface; `None` if it is not enlarged the same in all directions.
    pub dimensions: Option<SurfaceDimensions>,
    /// Number of its face in the CAD file, such as `#120`.
    pub entity: Option<String>,
    /// Parameters of the surface.
    pub uv: [f64; 2],
    /// Face of the surface.
    pub face: u32,
    /// The place, metres.
    pub point: [f64; 3],
    /// Unit normal of the surface; it may point away from the viewer.
    pub normal: [f64; 3],
    /// From the origin of the ray, metres.
    pub distance: f64,
    /// Illuminance there, if a receiver has a lux map.
    pub lux: Option<LuxReading>,
    /// Positive where the surface is convex towards the origin of the ray, whatever its normal; `None` for meshes, and where the parameters degenerate.
    pub curvature: Option<Curvature>,
}

/// What a view leaves out.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct PickFilter {
    /// Hidden leaves of the tree.
    #[serde(deserialize_with = "leaves")]
    pub hidden: BTreeSet<u32>,
    /// (a, b, c, d): only points with a x + b y + c z <= d are visible.
    pub section: Option<[f64; 4]>,
    /// Whether outer walls are left out where they are seen from outside.
    pub see_through: bool,
    /// Whether surfaces that light passes are visible if they have a lux map.
    pub maps: bool,
}

impl PickFilter {
    fn admits(&self, model: &Model, object: u32, place: &ParametricPoint, point: DVec3) -> bool {
        let cut = self.section.is_some_and(|[a, b, c, d]| a * point.x + b * point.y + c * point.z > d);
        let is_seen = model.is_seen(object) || (self.maps && model.has_lux(object));
        let is_left_out = self.see_through && model.is_outside(object, place.back);
        let is_hidden = model.leaf_of(object).is_none_or(|leaf| self.hidden.contains(&leaf));
        is_seen && !cut && !is_left_out && !is_hidden
    }
}

/// First hit of `ray` that is visible and that `filter` does not leave out.
///
/// `model` is that of `scene`. `None` if nothing is hit, or only after more than 4096 hits on surfaces that are left out.
#[must_use]
pub fn pick(scene: &Scene, model: &Model, ray: &Ray, filter: &PickFilter) -> Option<PickResult> {
    let mut rest = *ray;
    for _ in 0..MOST_PASSED {
        let (at, place) = scene.intersect_parametric(&rest, f64::INFINITY)?;
        let object = model.object_of(&place)?;
        let leaf = model.leaf_of(object)?;
        let point = at.point.position;
        if filter.admits(model, object, &place, point) {
            let distance = point.distance(ray.origin);
            return Some(pick_result(scene, model, &rest, (object, leaf), &at, &place, distance));
        }
        rest = at.spawn(ray.direction);
    }
    None
}

fn pick_result(
    scene: &Scene,
    model: &Model,
    ray: &Ray,
    (object, leaf): (u32, u32),
    at: &Interaction,
    place: &ParametricPoint,
    distance: f64,
) -> PickResult {
    let placed = scene.placed_surfaces();
    let surface = placed.get(place.surface as usize);
    let point = &at.point;
    PickResult {
        leaf,
        object,
        kind: model.kind_of(object),
        name: model.name_of(leaf).unwrap_or_default().to_owned(),
        material: model.material_of(object).to_owned(),
        degree: surface.and_then(|surface| degree(surface, place.face)),
        area: model.area_of(leaf, &placed),
        dimensions: model.dimensions_of(object),
        entity: model.entity_of(leaf),
        uv: point.uv.to_array(),
        face: place.face,
        point: point.position.to_array(),
        normal: point.normal.to_array(),
        distance,
        lux: model.lux_at(&HitLocation::new(at, *place)),
        curvature: surface.and_then(|surface| curvature(surface, ray, at, place)),
    }
}

fn degree(placed: &PlacedSurface<'_>, face: u32) -> Option<[usize; 2]> {
    let Surface::Freeform(freeform) = placed.surface() else { return None };
    let (u, v) = freeform.degrees(face)?;
    Some([u, v])
}

fn curvature(
    placed: &PlacedSurface<'_>,
    ray: &Ray,
    at: &Interaction,
    place: &ParametricPoint,
) -> Option<Curvature> {
    let surface = match placed.surface() {
        Surface::Trimmed(trimmed) => trimmed.surface(),
        other => other,
    };
    // A mesh approximates an unknown surface, and its normals need not fit its shape.
    if matches!(surface, Surface::Mesh(_)) {
        return None;
    }
    let size = placed.bounds().diagonal().length();
    let side = if at.point.normal.dot(at.wo) < 0.0 { -1.0 } else { 1.0 };
    let (point, derivatives) = placed.differential(ray, at.t, place);
    Curvature::of(&point, derivatives.map(|dn| dn * side), if size.is_finite() { size } else { at.t })
}
