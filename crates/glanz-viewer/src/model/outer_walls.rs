//! Outer walls: surfaces that can be left out where they are seen from outside of the scene.

use std::collections::HashMap;
use std::ops::Range;

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_scene::description::ReceiverSide;
use glanz_scene::{Interaction, ParametricPoint, PlacedSurface, Scene};
use rayon::prelude::*;
use serde::Serialize;

use super::Model;
use super::head::ModelLight;
use super::lights::placed_lights;

/// Objects from which on a scene is too large for walls to be looked for: parts of machines have no walls.
const MOST_OBJECTS: usize = 20_000;

/// Lights from which on walls are not looked for: each point would look for the nearest ones among too many.
const MOST_LIGHTS: usize = 1 << 16;

/// Faces from which on walls are not looked for: the area of each is estimated. Those of copies count once.
const MOST_FACES: u64 = 1 << 22;

/// Largest number of rays for all objects, but for those that pass interfaces.
const MOST_RAYS: usize = 1 << 20;

/// Fewest and most points on an object at which rays decide.
const POINTS: [usize; 2] = [8, 64];

/// Lights, the nearest ones, that a point may see.
const NEAREST_LIGHTS: usize = 3;

/// Distance from a luminaire to the point before it that has to be in sight, as a share of the diagonal of the scene: luminaires are part of ceilings.
const LIGHT_OFFSET: f64 = 0.01;

/// Rounding of distances, as a share of them, for a light on a surface to be in sight although its surface is hit.
const ROUNDING: f64 = 1e-6;

/// Largest number of interfaces that a ray passes.
const MOST_PASSED: usize = 64;

/// Share of the area that has to see nothing on one side and the room on the other. Furniture may be part of the mesh of a room.
const LEAST_SHARE: f64 = 1.0 / 3.0;

/// Distance at which a wall has to see something, as a share of the diagonal of the scene: the sides of furniture see each other.
const LEAST_DISTANCE: f64 = 0.05;

/// The same as a share of the extent of the scene along the normal, where a light or a receiver tells rooms from furniture: a wide room is low.
const LEAST_SIDE: f64 = 0.25;

/// Points on a curved face that its area is estimated by.
const FACE_POINTS: usize = 4;

/// Multiples of these numbers, without their integer parts, are spread evenly over an interval and over a square.
const INTERVAL_STEP: f64 = 0.618_033_988_749_894_8;
const SQUARE_STEPS: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// The side of a wall from which it is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum OuterSide {
    /// The side of its normal.
    Front,
    /// The other side.
    Back,
}

impl Model {
    /// The model with its outer walls marked: a side of a surface from which rays along the normal leave the scene is an outer side if the other side is in a room:
    /// a receiver counts light there, or it sees a light, or, in scenes whose light has no place, a surface that faces it. Files of models rarely say which side is the room's.
    #[must_use]
    pub(crate) fn with_outer_sides(mut self, scene: &Scene) -> Self {
        if self.head.objects.len() > MOST_OBJECTS || scene.lights().len() > MOST_LIGHTS {
            return self;
        }
        let placed = scene.placed_surfaces();
        let candidates = wall_candidates(&placed);
        if candidates.values().map(|surface| u64::from(surface.faces())).sum::<u64>() > MOST_FACES {
            return self;
        }
        let area_sums = candidates.into_par_iter().map(|(key, surface)| (key, area_sums(surface))).collect();
        let search = WallSearch::new(&self, scene, &placed, area_sums);
        let objects: Vec<_> = self.object_faces(&placed).collect();
        let sides: Vec<_> = objects
            .into_par_iter()
            .map(|(object, surface, faces)| (object, search.outer_side(object, surface, faces)))
            .collect();
        for (object, side) in sides {
            if let Some(object) = self.head.objects.get_mut(object as usize) {
                object.outside = side;
            }
        }
        self
    }

    /// Whether an object is left out when it is seen from this side.
    #[must_use]
    pub fn is_outside(&self, object: u32, back: bool) -> bool {
        let side = if back { OuterSide::Back } else { OuterSide::Front };
        self.head.objects.get(object as usize).is_some_and(|object| object.outside == Some(side))
    }
}

/// Sums of the areas of the faces of each surface that may be a wall, by [`address`].
type AreaSums = HashMap<usize, Vec<f64>>;

/// A scene with what its walls are found by.
struct WallSearch<'a> {
    model: &'a Model,
    scene: &'a Scene,
    placed: &'a [PlacedSurface<'a>],
    /// Points that are lit, for each light that has a place.
    lights: Vec<DVec3>,
    /// Sides of shapes that receivers measure.
    measured: HashMap<u32, Vec<ReceiverSide>>,
    area_sums: AreaSums,
    /// Sides of the bounding box of the scene, metres.
    size: DVec3,
    /// Number of points on each object.
    points: usize,
}

impl<'a> WallSearch<'a> {
    fn new(model: &'a Model, scene: &'a Scene, placed: &'a [PlacedSurface<'a>], area_sums: AreaSums) -> Self {
        let size = scene.bounds().diagonal();
        let mut measured: HashMap<u32, Vec<ReceiverSide>> = HashMap::new();
        for receiver in scene.receivers() {
            measured.entry(receiver.shape()).or_default().push(receiver.side());
        }
        let lit_point = |light: &ModelLight| {
            let [position, direction] = [light.position, light.direction].map(DVec3::from_array);
            match light.kind {
                "point" => Some(position),
                "spot" | "area" => Some(position + LIGHT_OFFSET * size.length() * direction),
                _ => None,
            }
        };
        let lights: Vec<DVec3> = placed_lights(scene, placed).iter().filter_map(lit_point).collect();
        let rays = model.head.objects.len().max(1) * (2 + NEAREST_LIGHTS);
        let points = (MOST_RAYS / rays).clamp(POINTS[0], POINTS[1]);
        Self { model, scene, placed, lights, measured, area_sums, size, points }
    }

    fn outer_side(&self, object: u32, surface: &PlacedSurface<'_>, faces: Range<u32>) -> Option<OuterSide> {
        // Light passes a work plane; surfaces without parameters have no points.
        if surface.is_passable() || faces.is_empty() {
            return None;
        }
        let receivers = self.measured.get(&surface.shape(faces.start)).map_or(&[][..], Vec::as_slice);
        let [is_front, is_back] = [ReceiverSide::Front, ReceiverSide::Back]
            .map(|side| receivers.iter().any(|&other| other == side || other == ReceiverSide::Both));
        let (mut area, mut front_area, mut back_area) = (0.0, 0.0, 0.0);
        for number in 0..self.points {
            let share = (number as f64 * INTERVAL_STEP).fract();
            let Some((face, face_area)) = self.face_at(surface, &faces, share) else { continue };
            let Some((uv, domain_area)) = sample(&surface.face_domain(face), number) else { continue };
            let [Some(front), Some(back)] = [false, true].map(|back| surface.at(face, uv, back)) else {
                continue;
            };
            let weight = front.area_element * domain_area / face_area;
            area += weight;
            let [before, behind] = [&front.at, &back.at].map(|at| self.first_hit(at.spawn(at.wo)));
            // Where light counts, there is no outside.
            match (before, behind) {
                (Some(hit), None) if !is_back && self.is_in_room(object, &front.at, &hit, is_front) => {
                    back_area += weight
                }
                (None, Some(hit)) if !is_front && self.is_in_room(object, &back.at, &hit, is_back) => {
                    front_area += weight
                }
                _ => {}
            }
        }
        if !(area > 0.0 && f64::max(front_area, back_area) >= LEAST_SHARE * area) {
            return None;
        }
        Some(if front_area > back_area { OuterSide::Front } else { OuterSide::Back })
    }

    /// The face among `faces` up to which they have a share of their area, and the estimate of its area; faces without an area are never met.
    fn face_at(&self, surface: &PlacedSurface<'_>, faces: &Range<u32>, share: f64) -> Option<(u32, f64)> {
        let sums = self.area_sums.get(&address(surface))?.get(faces.start as usize..=faces.end as usize)?;
        let (first, last) = (*sums.first()?, *sums.last()?);
        let before = sums.partition_point(|&sum| sum <= first + share * (last - first)).checked_sub(1)?;
        let area = sums.get(before + 1)? - sums.get(before)?;
        Some((faces.start + before as u32, area))
    }

    /// The first hit that is not on an interface.
    fn first_hit(&self, ray: Ray) -> Option<(Interaction, ParametricPoint)> {
        let mut rest = ray;
        for _ in 0..MOST_PASSED {
            let (at, place) = self.scene.intersect_parametric(&rest, f64::INFINITY)?;
            if !self.placed.get(place.surface as usize)?.is_passable() {
                return Some((at, place));
            }
            rest = at.spawn(ray.direction);
        }
        None
    }

    /// Whether the side of a point of an object that sees `hit` is in a room. `is_measured`: whether a receiver counts light there.
    fn is_in_room(
        &self,
        object: u32,
        at: &Interaction,
        (hit, place): &(Interaction, ParametricPoint),
        is_measured: bool,
    ) -> bool {
        let mut least = LEAST_DISTANCE * self.size.length();
        if is_measured || !self.lights.is_empty() {
            least = least.min(LEAST_SIDE * at.wo.abs().dot(self.size));
        }
        let is_near = hit.point.position.distance(at.point.position) <= least;
        // A solid sees the backs of its own sides.
        if is_near || (place.back && self.model.object_of(place) == Some(object)) {
            return false;
        }
        if is_measured {
            return true;
        }
        if self.lights.is_empty() {
            return !place.back;
        }
        self.nearest_lights(at.point.position).any(|light| self.is_in_sight(at, light))
    }

    /// The lights nearest to a point.
    fn nearest_lights(&self, point: DVec3) -> impl Iterator<Item = DVec3> {
        let mut nearest = [(f64::INFINITY, DVec3::ZERO); NEAREST_LIGHTS];
        for &light in &self.lights {
            let distance = light.distance_squared(point);
            if distance < nearest[NEAREST_LIGHTS - 1].0 {
                nearest[NEAREST_LIGHTS - 1] = (distance, light);
                nearest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        nearest.into_iter().filter(|(distance, _)| distance.is_finite()).map(|(_, light)| light)
    }

    /// Whether a light is in sight of a point on its side.
    fn is_in_sight(&self, at: &Interaction, light: DVec3) -> bool {
        let way = light - at.point.position;
        let (distance, direction) = (way.length(), way.normalize_or_zero());
        direction.dot(at.wo) > 0.0
            && self.first_hit(at.spawn(direction)).is_none_or(|(hit, _)| {
                hit.light().is_some()
                    || hit.point.position.distance(at.point.position) >= (1.0 - ROUNDING) * distance
            })
    }
}

/// What tells a surface from others; its copies have the same.
fn address(surface: &PlacedSurface<'_>) -> usize {
    std::ptr::from_ref(surface.surface()).addr()
}

/// The surfaces that may be walls, that is all but interfaces, by [`address`].
fn wall_candidates<'a>(placed: &'a [PlacedSurface<'a>]) -> HashMap<usize, &'a PlacedSurface<'a>> {
    let candidates = placed.iter().filter(|surface| !surface.is_passable());
    candidates.map(|surface| (address(surface), surface)).collect()
}

/// Sums of estimates of the areas of the faces before each face, and of all, m^2; 1 is the area of a single face.
fn area_sums(surface: &PlacedSurface<'_>) -> Vec<f64> {
    if surface.faces() == 1 {
        return vec![0.0, 1.0];
    }
    let areas: Vec<f64> = (0..surface.faces()).into_par_iter().map(|face| face_area(surface, face)).collect();
    // In order, so that the sums do not depend on the number of threads.
    let mut sum = 0.0;
    let mut sums = vec![sum];
    sums.extend(areas.into_iter().map(|area| {
        sum += area;
        sum
    }));
    sums
}

/// An estimate of the area of a face, m^2; 0 if it is not finite.
fn face_area(surface: &PlacedSurface<'_>, face: u32) -> f64 {
    let domain = surface.face_domain(face);
    // Polygons are flat: one point in each of their triangles is enough.
    let points = match &domain {
        FaceDomain::Square => FACE_POINTS,
        FaceDomain::Polygon(corners) => corners.len().saturating_sub(2),
    };
    let area = |number| {
        let (uv, domain_area) = sample(&domain, number)?;
        Some(surface.at(face, uv, false)?.area_element * domain_area)
    };
    let estimate = (0..points).filter_map(area).sum::<f64>() / points as f64;
    if estimate.is_finite() { estimate } else { 0.0 }
}

/// A point of a face by its parameters, and the area of the parameters; points of successive numbers are spread evenly.
fn sample(domain: &FaceDomain, number: usize) -> Option<(DVec2, f64)> {
    let at = (0.5 + number as f64 * SQUARE_STEPS).fract();
    let FaceDomain::Polygon(corners) = domain else { return Some((at, 1.0)) };
    // One of the triangles from the first corner.
    let triangles = corners.len().saturating_sub(2);
    let second = 1 + number.checked_rem(triangles)?;
    let (first, second, third) = (corners.first()?, corners.get(second)?, corners.get(second + 1)?);
    let at = if at.x + at.y > 1.0 { 1.0 - at } else { at };
    let sides = [*second - *first, *third - *first];
    let area = 0.5 * sides[0].perp_dot(sides[1]).abs();
    Some((*first + at.x * sides[0] + at.y * sides[1], area * triangles as f64))
}
