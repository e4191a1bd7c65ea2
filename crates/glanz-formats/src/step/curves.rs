//! Curves in space and in the parameters of surfaces.

use glanz_brep::model::{Curve, Placement};
use glanz_math::DVec3;

use super::geometry::{CurveUnits, FileVector, GeometryReader, deeper};
use super::part21::{Entity, Keyword, Refusal};
use super::placement::{point, vector};
use super::spline::is_spline_curve;

/// Whether a type is that of a curve in space with its curves in the parameters of surfaces.
pub(super) fn is_surface_curve(kind: Keyword) -> bool {
    use Keyword::{BoundedSurfaceCurve, IntersectionCurve, SeamCurve, SurfaceCurve};
    matches!(kind, BoundedSurfaceCurve | IntersectionCurve | SeamCurve | SurfaceCurve)
}

impl GeometryReader {
    /// A curve of any kind.
    ///
    /// # Errors
    /// What cannot be read of it.
    pub(super) fn curve<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
        depth: usize,
    ) -> Result<Curve<P>, Refusal> {
        let depth = deeper(entity, depth)?;
        self.spend(entity.id(), 1)?;
        let kinds = || entity.kinds();
        if kinds().any(is_spline_curve) {
            return self.spline_curve(entity, units);
        }
        if kinds().any(is_surface_curve) {
            let attributes = entity.attributes(&[Keyword::RepresentationItem, Keyword::SurfaceCurve]);
            return self.curve(attributes.reference(1)?, units, depth);
        }
        match entity.keyword() {
            Keyword::Line => self.line(entity, units),
            Keyword::Circle | Keyword::Ellipse => self.ellipse(entity, units),
            Keyword::Parabola => self.parabola(entity, units),
            Keyword::Hyperbola => self.hyperbola(entity, units),
            Keyword::Polyline => Ok(Curve::Polyline(self.points(entity, units)?)),
            Keyword::TrimmedCurve => self.trimmed(entity, units, depth),
            Keyword::CompositeCurve | Keyword::CompositeCurveOnSurface => {
                self.composite(entity, units, depth)
            }
            _ if entity.is(Keyword::CompositeCurve) => self.composite(entity, units, depth),
            _ => Err(entity.refuse_type("curve")),
        }
    }

    /// A point in metres, or in metres and radians.
    pub(super) fn located<P: FileVector>(entity: Entity<'_>, units: CurveUnits) -> Result<P, Refusal> {
        let point = P::from_file(point(entity)? * units.coordinates);
        if point.is_finite() { Ok(point) } else { Err(entity.refuse("the point is not finite")) }
    }

    /// The points of a polyline or a polygon.
    pub(super) fn points<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
    ) -> Result<Vec<P>, Refusal> {
        let attributes = entity.simple();
        self.spend_items(entity.id(), attributes.list(1)?, 1)?;
        let points: Vec<P> = attributes
            .references(1)?
            .map(|entity| Self::located(entity?, units))
            .collect::<Result<_, _>>()?;
        if points.len() < 2 { Err(entity.refuse("there are fewer than 2 points")) } else { Ok(points) }
    }

    fn line<P: FileVector>(&mut self, entity: Entity<'_>, units: CurveUnits) -> Result<Curve<P>, Refusal> {
        let attributes = entity.simple();
        let direction = P::from_file(vector(attributes.reference(2)?)? * units.coordinates);
        if direction.dot(direction) == 0.0 || !direction.is_finite() {
            return Err(entity.refuse("the direction of the line has no length, or is not finite"));
        }
        Ok(Curve::Line { origin: Self::located(attributes.reference(1)?, units)?, direction })
    }

    /// The centre and the axes of a conic, and its two lengths, in units of the file.
    fn conic(&mut self, entity: Entity<'_>, lengths: [usize; 2]) -> Result<(Placement, [f64; 2]), Refusal> {
        let attributes = entity.simple();
        let placement = self.placement(attributes.reference(1)?)?;
        let mut values = [0.0; 2];
        for (value, i) in values.iter_mut().zip(lengths) {
            *value = attributes.number(i)?;
            if *value <= 0.0 {
                return Err(entity.refuse(format!("a length of the conic is {value}; it must be positive")));
            }
        }
        Ok((placement, values))
    }

    /// A point and two vectors of a conic in the units of the model.
    fn vectors<P: FileVector>(
        entity: Entity<'_>,
        [o, a, b]: [DVec3; 3],
        units: CurveUnits,
    ) -> Result<[P; 3], Refusal> {
        let vectors = [o, a, b].map(|v| P::from_file(v * units.coordinates));
        if vectors.iter().all(|v| v.is_finite()) {
            Ok(vectors)
        } else {
            Err(entity.refuse("the conic is not finite"))
        }
    }

    fn ellipse<P: FileVector>(&mut self, entity: Entity<'_>, units: CurveUnits) -> Result<Curve<P>, Refusal> {
        let second = if entity.keyword() == Keyword::Circle { 2 } else { 3 };
        let (Placement { origin, x, y, .. }, [r, s]) = self.conic(entity, [2, second])?;
        let [center, a, b] = Self::vectors(entity, [origin, x * r, y * s], units)?;
        Ok(Curve::Ellipse { center, a, b })
    }

    fn parabola<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
    ) -> Result<Curve<P>, Refusal> {
        let (Placement { origin, x, y, .. }, [f, _]) = self.conic(entity, [2, 2])?;
        let [apex, a, b] = Self::vectors(entity, [origin, x * f, y * f], units)?;
        Ok(Curve::Parabola { apex, a, b })
    }

    fn hyperbola<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
    ) -> Result<Curve<P>, Refusal> {
        let (Placement { origin, x, y, .. }, [r, s]) = self.conic(entity, [2, 3])?;
        let [center, a, b] = Self::vectors(entity, [origin, x * r, y * s], units)?;
        Ok(Curve::Hyperbola { center, a, b })
    }

    fn composite<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
        depth: usize,
    ) -> Result<Curve<P>, Refusal> {
        let attributes = entity.attributes(&[Keyword::RepresentationItem, Keyword::CompositeCurve]);
        let mut curves = Vec::new();
        for segment in attributes.references(1)? {
            let segment = segment?;
            if !segment.is(Keyword::CompositeCurveSegment) {
                return Err(segment.refuse_type("segment of a composite curve"));
            }
            let attributes = segment.attributes(&[Keyword::CompositeCurveSegment]);
            curves.push((self.curve(attributes.reference(2)?, units, depth)?, attributes.boolean(1)?));
        }
        if curves.is_empty() {
            Err(entity.refuse("there are no segments"))
        } else {
            Ok(Curve::Composite(curves))
        }
    }
}
