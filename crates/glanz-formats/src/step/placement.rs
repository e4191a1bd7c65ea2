//! Points, directions, frames and transformations.

use glanz_brep::model::Placement;
use glanz_math::{DMat4, DVec3};

use super::geometry::GeometryReader;
use super::part21::{Entity, Keyword, Refusal};
use crate::cad::invertible;

/// Coordinates as in the file; those that are missing are 0.
fn coordinates(entity: Entity<'_>) -> Result<DVec3, Refusal> {
    let attributes = entity.simple();
    let mut coordinates = [0.0; 3];
    let mut items = attributes.list(1)?;
    for (slot, at) in coordinates.iter_mut().zip(items.by_ref()) {
        *slot = attributes.number_at(at).ok_or_else(|| entity.refuse("a coordinate must be a number"))?;
    }
    if items.next().is_some() {
        Err(entity.refuse("there are more than 3 coordinates"))
    } else {
        Ok(coordinates.into())
    }
}

/// The coordinates of a `CARTESIAN_POINT`, in units of the file.
pub(super) fn point(entity: Entity<'_>) -> Result<DVec3, Refusal> {
    match entity.keyword() {
        Keyword::CartesianPoint => coordinates(entity),
        _ => Err(entity.refuse_type("point")),
    }
}

/// The unit vector of a `DIRECTION`.
pub(super) fn direction(entity: Entity<'_>) -> Result<DVec3, Refusal> {
    if entity.keyword() != Keyword::Direction {
        return Err(entity.refuse_type("direction"));
    }
    coordinates(entity)?.try_normalize().ok_or_else(|| entity.refuse("the direction has no length"))
}

/// A `VECTOR`, in units of the file.
pub(super) fn vector(entity: Entity<'_>) -> Result<DVec3, Refusal> {
    if entity.keyword() != Keyword::Vector {
        return Err(entity.refuse_type("vector"));
    }
    let attributes = entity.simple();
    let magnitude = attributes.number(2)?;
    if magnitude == 0.0 {
        return Err(entity.refuse("the vector has no length"));
    }
    Ok(direction(attributes.reference(1)?)? * magnitude)
}

/// A point of an axis and its unit vector, in units of the file.
pub(super) fn axis(entity: Entity<'_>) -> Result<[DVec3; 2], Refusal> {
    if !matches!(entity.keyword(), Keyword::Axis1Placement | Keyword::Axis2Placement3d) {
        return Err(entity.refuse_type("axis"));
    }
    let attributes = entity.simple();
    let axis = attributes.optional_reference(2)?.map_or(Ok(DVec3::Z), direction)?;
    Ok([point(attributes.reference(1)?)?, axis])
}

/// The matrix from the frame of a placement to that in which it is given.
pub(super) fn matrix(placement: &Placement) -> DMat4 {
    let Placement { origin, x, y, z } = placement;
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0))
}

/// The inverse of [`matrix`], without the rounding of a general inverse.
pub(super) fn inverse_matrix(placement: &Placement) -> DMat4 {
    let Placement { origin: o, x, y, z } = *placement;
    let rows = [x.extend(-x.dot(o)), y.extend(-y.dot(o)), z.extend(-z.dot(o)), DVec3::ZERO.extend(1.0)];
    DMat4::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose()
}

impl GeometryReader {
    /// An `AXIS2_PLACEMENT_3D` or `AXIS2_PLACEMENT_2D`, in units of the file.
    ///
    /// # Source
    /// @iso10303-42 section 4.6, `build_axes` and `build_2axes`.
    pub(super) fn placement(&mut self, entity: Entity<'_>) -> Result<Placement, Refusal> {
        let attributes = entity.simple();
        let (axis, reference) = match entity.keyword() {
            Keyword::Axis2Placement3d => {
                (attributes.optional_reference(2)?, attributes.optional_reference(3)?)
            }
            Keyword::Axis2Placement2d => (None, attributes.optional_reference(2)?),
            _ => return Err(entity.refuse_type("placement")),
        };
        let origin = point(attributes.reference(1)?)?;
        let z = axis.map_or(Ok(DVec3::Z), direction)?;
        let x = self.orthogonal(entity, reference.map(direction).transpose()?, z);
        Ok(Placement { origin, x, y: z.cross(x), z })
    }

    /// The unit vector at a right angle to `z` that is nearest to `wanted`.
    fn orthogonal(&mut self, entity: Entity<'_>, wanted: Option<DVec3>, z: DVec3) -> DVec3 {
        let project = |v: DVec3| {
            // Of two unit vectors along one another, rounding is left.
            let rest = v - z * v.dot(z);
            let x = (rest.length() > f64::EPSILON.sqrt()).then(|| rest.try_normalize())??;
            // The shorter the rest, the more its rounding is along z.
            (x - z * x.dot(z)).try_normalize()
        };
        if let Some(x) = wanted.and_then(project) {
            return x;
        }
        if wanted.is_some() {
            self.repairs.push(entity.id(), "the reference direction is along the axis; another one is taken");
        }
        // The default of the standard: the x axis, or the y axis where z is along x.
        [DVec3::X, DVec3::Y].into_iter().find_map(project).unwrap_or_else(|| z.any_orthonormal_vector())
    }

    /// The transformation of a mapped item or a relationship from metres to metres: an item of geometry in its units.
    ///
    /// It takes the frame in which the item is (an `AXIS2_PLACEMENT_3D`) or the operator that it is.
    pub(super) fn transformation(&mut self, entity: Entity<'_>, length: f64) -> Result<DMat4, Refusal> {
        if entity.is(Keyword::CartesianTransformationOperator3d) {
            return self.operator(entity, length);
        }
        Ok(matrix(&self.scaled_placement(entity, length)?))
    }

    /// The inverse of [`Self::transformation`].
    pub(super) fn inverse_transformation(
        &mut self,
        entity: Entity<'_>,
        length: f64,
    ) -> Result<DMat4, Refusal> {
        if entity.is(Keyword::CartesianTransformationOperator3d) {
            return Ok(self.operator(entity, length)?.inverse());
        }
        Ok(inverse_matrix(&self.scaled_placement(entity, length)?))
    }

    /// A placement in metres.
    pub(super) fn scaled_placement(&mut self, entity: Entity<'_>, length: f64) -> Result<Placement, Refusal> {
        let placement = self.placement(entity)?;
        let origin = placement.origin * length;
        if !origin.is_finite() {
            return Err(entity.refuse("the placement is not finite"));
        }
        Ok(Placement { origin, ..placement })
    }

    /// A `CARTESIAN_TRANSFORMATION_OPERATOR_3D`: a rotation or reflection with a uniform scale and a translation.
    fn operator(&mut self, entity: Entity<'_>, length: f64) -> Result<DMat4, Refusal> {
        use Keyword::{CartesianTransformationOperator, CartesianTransformationOperator3d};
        let parts = [CartesianTransformationOperator, CartesianTransformationOperator3d];
        let attributes = entity.attributes(&parts);
        // In front of its own attributes a simple instance has one to three names.
        let first = attributes.len().checked_sub(5).ok_or_else(|| entity.refuse("attributes are missing"))?;
        let optional = |i: usize| attributes.optional_reference(first + i)?.map(direction).transpose();
        let [x, y, z] = [optional(0)?, optional(1)?, optional(4)?];
        let z = z.or_else(|| x.zip(y).and_then(|(x, y)| x.cross(y).try_normalize())).unwrap_or(DVec3::Z);
        let x = self.orthogonal(entity, x, z);
        let right = z.cross(x);
        let y = if y.is_some_and(|y| y.dot(right) < 0.0) { -right } else { right };
        let origin = point(attributes.reference(first + 2)?)? * length;
        let scale = if attributes.is_missing(first + 3) { 1.0 } else { attributes.number(first + 3)? };
        if !(scale > 0.0 && scale.is_finite() && origin.is_finite()) {
            return Err(entity.refuse(format!("the scale is {scale}; it must be positive and finite")));
        }
        let columns = [x, y, z].map(|axis| (axis * scale).extend(0.0));
        invertible(entity.id(), DMat4::from_cols(columns[0], columns[1], columns[2], origin.extend(1.0)))
    }
}
