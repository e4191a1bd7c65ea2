//! Parts of curves between two points or parameters.

use glanz_brep::model::{Curve, CurveVector};

use super::geometry::{CurveUnits, FileVector, GeometryReader};
use super::part21::{Entity, EntityAttributes, Keyword, Refusal, TapeToken};

/// Cost of a search of the nearest point per point of a spline, in copies of points.
const SEARCH_COST: usize = 8;

/// An end of a trimmed curve, by its point, its parameter, or both.
struct TrimEnd<P> {
    point: Option<P>,
    parameter: Option<f64>,
}

impl GeometryReader {
    /// `TRIMMED_CURVE(name, basis, ends, ends, sense, master)`.
    pub(super) fn trimmed<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
        depth: usize,
    ) -> Result<Curve<P>, Refusal> {
        let attributes = entity.simple();
        let basis: Curve<P> = self.curve(attributes.reference(1)?, units, depth)?;
        let same_sense = attributes.boolean(4)?;
        let prefers_points = attributes.enumeration(5) == Some(b"CARTESIAN");
        let scale = parameter_scale(&basis, units.angle);
        let mut range = [0.0; 2];
        for (end, i) in range.iter_mut().zip([2, 3]) {
            let TrimEnd { point, parameter } = trim_end::<P>(&attributes, i, units)?;
            let by_point = point.filter(|_| prefers_points || parameter.is_none());
            *end = match (by_point, parameter) {
                (Some(point), _) => {
                    self.spend(entity.id(), search_size(&basis).saturating_mul(SEARCH_COST))?;
                    basis.closest_parameter(point, None)
                }
                (None, Some(parameter)) => parameter * scale,
                (None, None) => {
                    return Err(entity.refuse(format!("attribute {} has no point or parameter", i + 1)));
                }
            };
        }
        Ok(Curve::Trimmed { basis: Box::new(basis), range, same_sense })
    }
}

/// Points of splines in a curve, which a search of the nearest point evaluates many times; 1 for others.
fn search_size<P: CurveVector>(curve: &Curve<P>) -> usize {
    match curve {
        Curve::Spline(spline) => spline.control_points().len(),
        Curve::Polyline(points) => points.len(),
        Curve::Trimmed { basis, .. } => match basis.as_ref() {
            // To find a point, all segments before it are passed.
            Curve::Composite(segments) => segments.len().saturating_mul(search_size(basis)),
            basis => search_size(basis),
        },
        Curve::Composite(segments) => {
            segments.iter().fold(0, |size: usize, (segment, _)| size.saturating_add(search_size(segment)))
        }
        _ => 1,
    }
}

/// The factor from parameters of a file to those of the model: that of angles for circles and ellipses.
pub(super) fn parameter_scale<P: CurveVector>(curve: &Curve<P>, angle: f64) -> f64 {
    match curve {
        Curve::Ellipse { .. } => angle,
        Curve::Trimmed { basis, .. } => parameter_scale(basis, angle),
        _ => 1.0,
    }
}

fn trim_end<P: FileVector>(
    attributes: &EntityAttributes<'_>,
    i: usize,
    units: CurveUnits,
) -> Result<TrimEnd<P>, Refusal> {
    let mut end = TrimEnd { point: None, parameter: None };
    for at in attributes.list(i)? {
        match attributes.token(at) {
            TapeToken::Reference(_) => {
                end.point = Some(GeometryReader::located(attributes.reference_at(at)?, units)?);
            }
            TapeToken::Typed { keyword: Keyword::ParameterValue, .. }
            | TapeToken::Real(_)
            | TapeToken::Integer(_) => {
                end.parameter = attributes.number_at(at);
            }
            _ => return Err(attributes.refuse(format!("attribute {} must have points or parameters", i + 1))),
        }
    }
    Ok(end)
}
