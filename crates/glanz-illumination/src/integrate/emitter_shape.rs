//! Shapes of emitters with their border functions, which decide whether a ray hits them.

use glanz_geometry::{ShadingPoint, Surface};
use glanz_light::Spectrum;
use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};
use glanz_scene::light::AreaLight;
use glanz_scene::{LightId, PlacedSurface};

use super::error::IntegrateError;
use super::polygon::ConvexPolygon;

/// A surface of uniform radiance.
#[derive(Clone, Debug)]
pub(super) struct EmitterShape {
    pub(super) form: EmitterForm,
    /// W/(m^2 sr).
    pub(super) radiance: Spectrum,
    /// Whether a flat emitter emits from both sides.
    two_sided: bool,
}

/// The form; normals of flat emitters point to the emitting side.
#[derive(Clone, Debug)]
pub(super) enum EmitterForm {
    Sphere { center: DVec3, radius: f64 },
    Disk { center: DVec3, normal: DVec3, radius: f64 },
    Polygon { polygon: ConvexPolygon, normal: DVec3 },
}

impl EmitterShape {
    /// The light `id`, whose surface is `placed`.
    ///
    /// # Errors
    /// [`IntegrateError::EmitterForm`] if it is neither a whole sphere that emits outwards nor a full disk nor a flat convex polygon.
    pub(super) fn try_new(
        id: LightId,
        light: &AreaLight,
        placed: &PlacedSurface<'_>,
    ) -> Result<Self, IntegrateError> {
        let (kind, shape) = (placed.surface().kind(), placed.shape(0));
        let form =
            form(placed).map_err(|fault| IntegrateError::EmitterForm { light: id, shape, kind, fault })?;
        if light.is_two_sided() && matches!(form, EmitterForm::Sphere { .. }) {
            let fault = "shines inwards";
            return Err(IntegrateError::EmitterForm { light: id, shape, kind, fault });
        }
        Ok(Self { form, radiance: light.radiance(), two_sided: light.is_two_sided() })
    }

    pub(super) fn center(&self) -> DVec3 {
        match &self.form {
            EmitterForm::Sphere { center, .. } | EmitterForm::Disk { center, .. } => *center,
            EmitterForm::Polygon { polygon, .. } => polygon.center(),
        }
    }

    /// Radius of a ball around it.
    pub(super) fn outer_radius(&self) -> f64 {
        match &self.form {
            EmitterForm::Sphere { radius, .. } | EmitterForm::Disk { radius, .. } => *radius,
            EmitterForm::Polygon { polygon, .. } => polygon.reach(),
        }
    }

    /// Radius of a ball or disk inside it.
    pub(super) fn inner_radius(&self) -> f64 {
        match &self.form {
            EmitterForm::Sphere { radius, .. } | EmitterForm::Disk { radius, .. } => *radius,
            EmitterForm::Polygon { polygon, .. } => polygon.inner_radius(),
        }
    }

    /// The point of its axis that is nearest to `place`: of the line through its middle along its length, up to half of its width from its ends.
    pub(super) fn nearest_of_axis(&self, place: DVec3) -> DVec3 {
        let center = self.center();
        let EmitterForm::Polygon { polygon, .. } = &self.form else { return center };
        let offsets = polygon.corners().iter().map(|corner| *corner - center);
        let longest = offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let half = longest.unwrap_or_default() * (1.0 - self.inner_radius() / self.outer_radius());
        let along = (place - center).dot(half) / half.length_squared().max(f64::MIN_POSITIVE);
        center + half * along.clamp(-1.0, 1.0)
    }

    /// Whether no point of the ball is on an emitting side.
    pub(super) fn is_dark_in(&self, center: DVec3, radius: f64) -> bool {
        match &self.form {
            EmitterForm::Sphere { .. } => false,
            EmitterForm::Disk { normal, .. } | EmitterForm::Polygon { normal, .. } => {
                !self.two_sided && (center - self.center()).dot(*normal) <= -radius
            }
        }
    }

    /// The border function: positive where the ray hits the emitter on an emitting side, 0 at its rim, of the order of 1 inside.
    ///
    /// It is smooth for spheres and disks, and for polygons smooth for each side, whose number is the second result. It is negative infinity where the
    /// ray points away or hits the dark side.
    pub(super) fn border(&self, origin: DVec3, direction: DVec3) -> (f64, u32) {
        let plane = |normal: DVec3| {
            let towards = direction.dot(normal);
            let t = (self.center() - origin).dot(normal) / towards;
            let is_lit = t > 0.0 && (self.two_sided || towards < 0.0);
            is_lit.then(|| origin + t * direction)
        };
        match &self.form {
            EmitterForm::Sphere { center, radius } => {
                let to = *center - origin;
                let along = to.dot(direction);
                // If the sphere is behind the ray, the point of the ray nearest to it is the origin.
                let distance_squared =
                    if along > 0.0 { to.cross(direction).length_squared() } else { to.length_squared() };
                if to.length_squared() <= radius * radius {
                    return (f64::NEG_INFINITY, 0);
                }
                (1.0 - distance_squared / (radius * radius), 0)
            }
            EmitterForm::Disk { center, normal, radius } => {
                let rim = |at: DVec3| 1.0 - at.distance_squared(*center) / (radius * radius);
                (plane(*normal).map_or(f64::NEG_INFINITY, rim), 0)
            }
            EmitterForm::Polygon { polygon, normal } => {
                let Some(at) = plane(*normal) else { return (f64::NEG_INFINITY, 0) };
                let (depth, side) = polygon.depth(at);
                (depth / polygon.inner_radius(), side)
            }
        }
    }

    /// Distance along a ray of unit direction to the emitter that it hits.
    pub(super) fn distance(&self, origin: DVec3, direction: DVec3) -> f64 {
        let to = self.center() - origin;
        match &self.form {
            EmitterForm::Sphere { radius, .. } => {
                let half_chord = (radius * radius - to.cross(direction).length_squared()).max(0.0).sqrt();
                to.dot(direction) - half_chord
            }
            EmitterForm::Disk { normal, .. } | EmitterForm::Polygon { normal, .. } => {
                to.dot(*normal) / direction.dot(*normal)
            }
        }
    }
}

/// The form of a surface, or the fault.
fn form(placed: &PlacedSurface<'_>) -> Result<EmitterForm, &'static str> {
    if placed.is_trimmed() {
        return Err("is trimmed");
    }
    let to_world = placed.to_world();
    let point = |uv: DVec2| placed.at(0, uv, false).map(|at| at.at.point);
    let inner: ShadingPoint = point(DVec2::splat(0.25)).ok_or("has no parameters")?;
    // As in sampling: a shape that is not exactly round has another rim.
    let scale = to_world.uniform_scale(gamma(64));
    match placed.surface() {
        Surface::Sphere(sphere) => {
            let scale = scale.filter(|_| sphere.is_whole()).ok_or("is not a whole sphere")?;
            let center = to_world.point(DVec3::ZERO);
            if inner.normal.dot(inner.position - center) < 0.0 {
                return Err("shines inwards");
            }
            Ok(EmitterForm::Sphere { center, radius: scale * sphere.radius() })
        }
        Surface::Disk(disk) => {
            let scale = scale.filter(|_| disk.is_whole()).ok_or("is not a full disk")?;
            let center = to_world.point(DVec3::Z * disk.height());
            Ok(EmitterForm::Disk { center, normal: inner.normal, radius: scale * disk.radius() })
        }
        Surface::Plane(_) | Surface::Bilinear(_) => {
            let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(point);
            flat(corners.into_iter().map(|p| p.map(|p| p.position)).collect(), &inner)
        }
        Surface::Triangle(_) => {
            let corners = [DVec2::ZERO, DVec2::X, DVec2::Y].map(point);
            flat(corners.into_iter().map(|p| p.map(|p| p.position)).collect(), &inner)
        }
        Surface::Mesh(mesh) => {
            let polygon = ConvexPolygon::of_mesh(mesh, |p| to_world.point(p));
            let polygon = polygon.ok_or("is not a flat convex polygon")?;
            Ok(EmitterForm::Polygon { normal: facing(&polygon, &inner), polygon })
        }
        _ => Err("is of such a form"),
    }
}

fn flat(corners: Option<Vec<DVec3>>, inner: &ShadingPoint) -> Result<EmitterForm, &'static str> {
    let polygon = corners.and_then(ConvexPolygon::try_new).ok_or("is not a flat convex polygon")?;
    Ok(EmitterForm::Polygon { normal: facing(&polygon, inner), polygon })
}

/// The normal of the polygon on the side of that of the surface.
fn facing(polygon: &ConvexPolygon, inner: &ShadingPoint) -> DVec3 {
    if polygon.normal().dot(inner.normal) < 0.0 { -polygon.normal() } else { polygon.normal() }
}
