//! Surfaces of faces.

use glanz_brep::model::{Curve, FaceSurface, Placement};
use glanz_math::DVec3;

use super::geometry::{CurveUnits, ENTITY_COST, GeometryReader, deeper};
use super::part21::{Entity, EntityAttributes, Keyword, Refusal};
use super::placement::{axis, vector};
use super::spline::is_spline_surface;
use super::trim::parameter_scale;
use super::units::UnitSet;

/// A surface with the factors from parameters of the file to its own.
#[derive(Clone, Debug)]
pub(super) struct ScaledSurface {
    /// The surface, in metres and radians.
    pub(super) surface: FaceSurface,
    /// Factors of u and v; negative where they run in the other direction.
    pub(super) scale: [f64; 2],
}

impl GeometryReader {
    /// A surface of any kind but those bounded by curves.
    ///
    /// # Errors
    /// What cannot be read of it.
    pub(super) fn surface(
        &mut self,
        entity: Entity<'_>,
        units: UnitSet,
        depth: usize,
    ) -> Result<ScaledSurface, Refusal> {
        let depth = deeper(entity, depth)?;
        self.spend(entity.id(), ENTITY_COST)?;
        if entity.kinds().any(is_spline_surface) {
            let surface = FaceSurface::Spline(self.spline_surface(entity, units.length)?);
            return Ok(ScaledSurface { surface, scale: [1.0; 2] });
        }
        match entity.keyword() {
            Keyword::Plane
            | Keyword::CylindricalSurface
            | Keyword::ConicalSurface
            | Keyword::SphericalSurface
            | Keyword::ToroidalSurface
            | Keyword::DegenerateToroidalSurface => self.elementary(entity, units),
            Keyword::SurfaceOfRevolution | Keyword::SurfaceOfLinearExtrusion => {
                self.swept(entity, units, depth)
            }
            Keyword::OffsetSurface => self.offset(entity, units, depth),
            Keyword::RectangularTrimmedSurface => self.rectangular(entity, units, depth),
            _ => Err(entity.refuse_type("surface")),
        }
    }

    fn elementary(&mut self, entity: Entity<'_>, units: UnitSet) -> Result<ScaledSurface, Refusal> {
        let UnitSet { length, angle } = units;
        let attributes = entity.simple();
        let placement = self.scaled_placement(attributes.reference(1)?, length)?;
        let radius = |i: usize, least: f64| radius(&attributes, i, length, least);
        let (surface, scale) = match entity.keyword() {
            Keyword::Plane => (FaceSurface::Plane(placement), [length; 2]),
            Keyword::CylindricalSurface => {
                (FaceSurface::Cylinder { placement, radius: radius(2, f64::MIN_POSITIVE)? }, [angle, length])
            }
            Keyword::ConicalSurface => {
                return cone(&attributes, placement, radius(2, 0.0)?, attributes.number(3)? * angle, units);
            }
            Keyword::SphericalSurface => {
                (FaceSurface::Sphere { placement, radius: radius(2, f64::MIN_POSITIVE)? }, [angle; 2])
            }
            kind => {
                let select_outer = kind != Keyword::DegenerateToroidalSurface || attributes.boolean(4)?;
                let [major_radius, minor_radius] =
                    [radius(2, f64::MIN_POSITIVE)?, radius(3, f64::MIN_POSITIVE)?];
                (FaceSurface::Torus { placement, major_radius, minor_radius, select_outer }, [angle; 2])
            }
        };
        Ok(ScaledSurface { surface, scale })
    }

    /// `SURFACE_OF_REVOLUTION(name, curve, axis)` or `SURFACE_OF_LINEAR_EXTRUSION(name, curve, vector)`.
    fn swept(&mut self, entity: Entity<'_>, units: UnitSet, depth: usize) -> Result<ScaledSurface, Refusal> {
        let attributes = entity.simple();
        let curve: Curve<DVec3> = self.curve(attributes.reference(1)?, curve_units(units), depth)?;
        let along = parameter_scale(&curve, units.angle);
        let (curve, path) = (Box::new(curve), attributes.reference(2)?);
        if entity.keyword() == Keyword::SurfaceOfLinearExtrusion {
            let direction = finite(entity, vector(path)? * units.length)?;
            let surface = FaceSurface::Extrusion { curve, direction };
            return Ok(ScaledSurface { surface, scale: [along, 1.0] });
        }
        let [origin, axis] = axis(path)?;
        let origin = finite(entity, origin * units.length)?;
        let surface = FaceSurface::Revolution { curve, origin, axis };
        Ok(ScaledSurface { surface, scale: [units.angle, along] })
    }

    fn offset(&mut self, entity: Entity<'_>, units: UnitSet, depth: usize) -> Result<ScaledSurface, Refusal> {
        let attributes = entity.simple();
        let basis = self.surface(attributes.reference(1)?, units, depth)?;
        let distance = attributes.number(2)? * units.length;
        let surface = FaceSurface::Offset { basis: Box::new(basis.surface), distance };
        Ok(ScaledSurface { surface, scale: basis.scale })
    }

    /// `RECTANGULAR_TRIMMED_SURFACE(name, basis, u1, u2, v1, v2, usense, vsense)`.
    fn rectangular(
        &mut self,
        entity: Entity<'_>,
        units: UnitSet,
        depth: usize,
    ) -> Result<ScaledSurface, Refusal> {
        let attributes = entity.simple();
        let ScaledSurface { surface, scale } = self.surface(attributes.reference(1)?, units, depth)?;
        let mut ranges = [[0.0; 2]; 2];
        let mut same_sense = [true; 2];
        for (axis, factor) in scale.into_iter().enumerate() {
            let [start, end] = [2, 3].map(|i| attributes.number(2 * axis + i));
            if let (Some(range), Some(sense)) = (ranges.get_mut(axis), same_sense.get_mut(axis)) {
                *range = [start? * factor, end? * factor];
                // Along a parameter that was turned the ends ascend in the other sense.
                *sense = attributes.boolean(6 + axis)? == (factor > 0.0);
            }
        }
        Ok(ScaledSurface {
            surface: FaceSurface::Rectangular { basis: Box::new(surface), ranges, same_sense },
            scale: scale.map(f64::abs),
        })
    }
}

/// Units of curves in space.
pub(super) fn curve_units(units: UnitSet) -> CurveUnits {
    CurveUnits { coordinates: DVec3::splat(units.length), angle: units.angle }
}

fn finite(entity: Entity<'_>, vector: DVec3) -> Result<DVec3, Refusal> {
    if vector.is_finite() { Ok(vector) } else { Err(entity.refuse("a coordinate is not finite")) }
}

/// A radius in metres, not less than `least`.
fn radius(attributes: &EntityAttributes<'_>, i: usize, length: f64, least: f64) -> Result<f64, Refusal> {
    let value = attributes.number(i)?;
    let radius = value * length;
    if radius >= least && radius.is_finite() {
        Ok(radius)
    } else {
        Err(attributes.refuse(format!("the radius is {value}; it must be positive and finite")))
    }
}

/// A cone; with a negative angle it opens downwards, and the frame is turned over, with both parameters.
fn cone(
    attributes: &EntityAttributes<'_>,
    placement: Placement,
    radius: f64,
    angle: f64,
    units: UnitSet,
) -> Result<ScaledSurface, Refusal> {
    let half_angle = angle.abs();
    let scale = [units.angle, units.length];
    if half_angle == 0.0 && radius > 0.0 {
        return Ok(ScaledSurface { surface: FaceSurface::Cylinder { placement, radius }, scale });
    }
    if !(half_angle > 0.0 && half_angle < std::f64::consts::FRAC_PI_2) {
        let reason = format!("the half angle is {angle} radians; it must be between 0 and pi / 2");
        return Err(attributes.refuse(reason));
    }
    let Placement { origin, x, y, z } = placement;
    let turned = angle < 0.0;
    let placement = if turned { Placement { origin, x, y: -y, z: -z } } else { placement };
    let scale = if turned { scale.map(|factor| -factor) } else { scale };
    Ok(ScaledSurface { surface: FaceSurface::Cone { placement, radius, half_angle }, scale })
}
