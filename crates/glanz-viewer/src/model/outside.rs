//! Outer walls: surfaces that can be left out where they are seen from outside of the scene.

use std::ops::Range;

use glanz_geometry::FaceDomain;
use glanz_math::DVec2;
use glanz_scene::{PlacedSurface, Scene};
use serde::Serialize;

use super::Model;

/// Largest number of faces of an object at whose points rays decide.
const MOST_FACES: usize = 48;

/// Objects from which on a scene is too large for walls to be looked for: parts of machines have no walls.
const MOST_OBJECTS: usize = 20_000;

/// Share of the points, by area, that have to see nothing on one side and the scene on the other. Furniture may be part of the mesh of a room.
const SHARE: f64 = 1.0 / 3.0;

/// Distance at which the front of a surface has to see something if its back does, as a share of the diagonal of the scene: the
/// sides of a solid see each other.
const APART: f64 = 0.05;

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
    /// The model with its outer walls marked: a side of a surface from which rays along the normal leave the scene is an outer side if the other side sees the
    /// scene. Files of models rarely say which side is the room's. Solids have no outer sides, as their surfaces see themselves, or one another at a short distance.
    #[must_use]
    pub(crate) fn with_outer_sides(mut self, scene: &Scene) -> Self {
        if self.head.objects.len() > MOST_OBJECTS {
            return self;
        }
        let mut sides = Vec::new();
        for (surface, parts) in scene.placed_surfaces().iter().zip(&self.objects) {
            let ends = parts.iter().skip(1).map(|&(end, _)| end).chain([surface.faces()]);
            sides.extend(parts.iter().zip(ends).map(|(&(first, object), end)| {
                (object, self.outer_side(scene, (object, surface), first..end))
            }));
        }
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

    fn outer_side(
        &self,
        scene: &Scene,
        (object, surface): (u32, &PlacedSurface<'_>),
        faces: Range<u32>,
    ) -> Option<OuterSide> {
        let apart = APART * scene.bounds().diagonal().length();
        let (mut all, mut of_front, mut of_back) = (0.0, 0.0, 0.0);
        let step = faces.len().div_ceil(MOST_FACES).max(1);
        for face in faces.step_by(step) {
            let (points, area) = points(&surface.face_domain(face));
            for uv in &points {
                // Objects that both sides see, with their distances.
                let seen = [false, true].map(|back| {
                    let found = surface.at(face, *uv, back)?;
                    let normal = if back { -found.at.point.normal } else { found.at.point.normal };
                    let hit = scene.intersect_parametric(&found.at.spawn(normal), f64::INFINITY);
                    let seen = hit.map(|(hit, place)| {
                        (self.object_of(&place), hit.point.position.distance(found.at.point.position))
                    });
                    Some((seen, found.area_element * area / points.len() as f64))
                });
                let [Some((front, weight)), Some((back, _))] = seen else { continue };
                all += weight;
                match (front, back) {
                    (Some(_), None) => of_back += weight,
                    (None, Some((other, distance))) if other != Some(object) && distance > apart => {
                        of_front += weight
                    }
                    _ => {}
                }
            }
        }
        if !(all > 0.0 && f64::max(of_front, of_back) >= SHARE * all) {
            return None;
        }
        Some(if of_front > of_back { OuterSide::Front } else { OuterSide::Back })
    }
}

/// Points of a face by its parameters, and the area of the parameters.
fn points(domain: &FaceDomain) -> (Vec<DVec2>, f64) {
    match domain {
        FaceDomain::Square => {
            let at = [1.0, 3.0, 5.0].map(|x| x / 6.0);
            (at.iter().flat_map(|&x| at.map(|y| DVec2::new(x, y))).collect(), 1.0)
        }
        FaceDomain::Polygon(corners) => {
            let middle = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
            let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
            (vec![middle], 0.5 * pairs.map(|(p, q)| p.perp_dot(*q)).sum::<f64>().abs())
        }
    }
}
