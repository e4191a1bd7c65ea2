//! B-spline curves and surfaces of all forms.

use glanz_brep::model::Curve;
use glanz_geometry::spline::{MAX_DEGREE, NurbsSurface};
use glanz_math::DVec3;

use super::geometry::{CurveUnits, FileVector, GeometryReader};
use super::part21::{Entity, EntityAttributes, Keyword, Refusal, TapeItems};
use crate::cad::{spline_curve, spline_surface};

/// The ways in which a file gives knots.
#[derive(Clone, Copy, Debug)]
enum KnotForm {
    /// Distinct knots with multiplicities.
    Explicit,
    /// From `-degree` on at distance 1, none repeated.
    Uniform,
    /// Clamped, with distance 1 inside.
    QuasiUniform,
    /// Bézier segments one after the other.
    PiecewiseBezier,
}

/// Types of curves and surfaces with their knots.
const FORMS: [(Keyword, Keyword, KnotForm); 5] = [
    (Keyword::BSplineCurveWithKnots, Keyword::BSplineSurfaceWithKnots, KnotForm::Explicit),
    (Keyword::UniformCurve, Keyword::UniformSurface, KnotForm::Uniform),
    (Keyword::QuasiUniformCurve, Keyword::QuasiUniformSurface, KnotForm::QuasiUniform),
    (Keyword::BezierCurve, Keyword::BezierSurface, KnotForm::PiecewiseBezier),
    (Keyword::PiecewiseBezierCurve, Keyword::PiecewiseBezierSurface, KnotForm::PiecewiseBezier),
];

/// Whether a type is that of a B-spline curve.
pub(super) fn is_spline_curve(kind: Keyword) -> bool {
    kind == Keyword::BSplineCurve || FORMS.iter().any(|(curve, ..)| *curve == kind)
}

/// Whether a type is that of a B-spline surface.
pub(super) fn is_spline_surface(kind: Keyword) -> bool {
    kind == Keyword::BSplineSurface || FORMS.iter().any(|(_, surface, _)| *surface == kind)
}

impl KnotForm {
    fn of(entity: Entity<'_>) -> Result<Self, Refusal> {
        let form = |kind| FORMS.iter().find(|(curve, surface, _)| *curve == kind || *surface == kind);
        let form = entity.kinds().find_map(form);
        form.map(|(.., form)| *form).ok_or_else(|| entity.refuse("the B-spline has no knots"))
    }

    /// The knots for `count` control points.
    fn knots(
        &self,
        attributes: &EntityAttributes<'_>,
        [multiplicities, knots]: [usize; 2],
        degree: usize,
        count: usize,
    ) -> Result<Vec<f64>, Refusal> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(
                attributes.refuse(format!("the degree is {degree}; it must be from 1 to {MAX_DEGREE}"))
            );
        }
        if count <= degree {
            return Err(
                attributes.refuse(format!("{count} control points are too few for the degree {degree}"))
            );
        }
        let steps = |count: usize| (0..count).map(|i| i as f64);
        match self {
            Self::Explicit => expand(attributes, [multiplicities, knots], degree + count + 1),
            Self::Uniform => Ok(steps(degree + count + 1).map(|i| i - degree as f64).collect()),
            Self::QuasiUniform => Ok(repeated(degree, count - degree, 1)),
            Self::PiecewiseBezier if (count - 1).is_multiple_of(degree) => {
                Ok(repeated(degree, (count - 1) / degree, degree))
            }
            Self::PiecewiseBezier => Err(attributes
                .refuse(format!("{count} control points make no Bézier segments of degree {degree}"))),
        }
    }
}

/// Clamped knots 0, 1, 2 and so on, of which the inner ones are repeated.
fn repeated(degree: usize, segments: usize, multiplicity: usize) -> Vec<f64> {
    let times = |i: usize| if i == 0 || i == segments { degree + 1 } else { multiplicity };
    (0..=segments).flat_map(|i| std::iter::repeat_n(i as f64, times(i))).collect()
}

/// Each knot as often as its multiplicity tells; `total` knots.
fn expand(attributes: &EntityAttributes<'_>, at: [usize; 2], total: usize) -> Result<Vec<f64>, Refusal> {
    let (multiplicities, knots) = (attributes.counts(at[0])?, attributes.numbers(at[1])?);
    let (count, sum) = (knots.len(), multiplicities.iter().fold(0_usize, |sum, m| sum.saturating_add(*m)));
    if multiplicities.len() != count {
        let reason = format!("there are {count} knots and {} multiplicities", multiplicities.len());
        return Err(attributes.refuse(reason));
    }
    if sum != total {
        return Err(
            attributes.refuse(format!("the multiplicities add up to {sum}; {total} knots are needed"))
        );
    }
    Ok(knots.into_iter().zip(multiplicities).flat_map(|(knot, m)| std::iter::repeat_n(knot, m)).collect())
}

impl GeometryReader {
    /// A B-spline curve; the form of its knots may be any.
    pub(super) fn spline_curve<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
    ) -> Result<Curve<P>, Refusal> {
        let parts = [Keyword::RepresentationItem, Keyword::BSplineCurve, Keyword::BSplineCurveWithKnots];
        let attributes = entity.attributes(&parts);
        let degree = attributes.count(1)?;
        let count = self.spend_items(entity.id(), attributes.list(2)?, 1)?;
        let knots = KnotForm::of(entity)?.knots(&attributes, [6, 7], degree, count)?;
        let weights = weights(entity, Keyword::RationalBSplineCurve, count, |a| a.numbers(0))?;
        let mut points = Vec::with_capacity(count);
        for (i, point) in attributes.references(2)?.enumerate() {
            let weight = weights.as_ref().and_then(|w| w.get(i)).copied().unwrap_or(1.0);
            points.push((Self::located::<P>(point?, units)? * weight).with_weight(weight));
        }
        let spline = spline_curve::<P>(degree, knots, points);
        spline.map(Curve::Spline).map_err(|reason| entity.refuse(reason))
    }

    /// A B-spline surface with clamped knots; `length`: metres.
    pub(super) fn spline_surface(
        &mut self,
        entity: Entity<'_>,
        length: f64,
    ) -> Result<NurbsSurface, Refusal> {
        let parts = [Keyword::RepresentationItem, Keyword::BSplineSurface, Keyword::BSplineSurfaceWithKnots];
        let attributes = entity.attributes(&parts);
        let degrees = [attributes.count(1)?, attributes.count(2)?];
        let rows = attributes.list(3)?;
        // Counting takes time too.
        self.spend(entity.id(), 1)?;
        let row_length = |at: u32| attributes.sublist(at).count_items();
        let counts = [rows.count_items(), rows.clone().next().map_or(0, row_length)];
        if rows.clone().any(|at| row_length(at) != counts[1]) {
            return Err(entity.refuse("the rows of control points differ in length"));
        }
        let total = counts[0].saturating_mul(counts[1]);
        self.spend(entity.id(), total)?;
        let form = KnotForm::of(entity)?;
        let knots_u = form.knots(&attributes, [8, 10], degrees[0], counts[0])?;
        let knots_v = form.knots(&attributes, [9, 11], degrees[1], counts[1])?;
        let weights = weights(entity, Keyword::RationalBSplineSurface, total, nested_numbers)?;
        let units = CurveUnits { coordinates: DVec3::splat(length), angle: 1.0 };
        let mut net = Vec::with_capacity(counts[0]);
        for (i, row) in rows.enumerate() {
            let mut points = Vec::with_capacity(counts[1]);
            for (j, at) in attributes.sublist(row).enumerate() {
                let weight = weights.as_ref().and_then(|w| w.get(i * counts[1] + j)).copied().unwrap_or(1.0);
                let point: DVec3 = Self::located(attributes.reference_at(at)?, units)?;
                points.push((point * weight).extend(weight));
            }
            net.push(points);
        }
        spline_surface(degrees, [knots_u, knots_v], net).map_err(|reason| entity.refuse(reason))
    }
}

/// The weights of a rational spline, `count` of them; `None` if it is polynomial.
fn weights(
    entity: Entity<'_>,
    part: Keyword,
    count: usize,
    numbers: impl FnOnce(&EntityAttributes<'_>) -> Result<Vec<f64>, Refusal>,
) -> Result<Option<Vec<f64>>, Refusal> {
    if !entity.is(part) {
        return Ok(None);
    }
    let weights = numbers(&entity.attributes(&[part]))?;
    if weights.len() != count {
        return Err(entity.refuse(format!("there are {} weights and {count} control points", weights.len())));
    }
    Ok(Some(weights))
}

/// The numbers in lists of a list.
fn nested_numbers(attributes: &EntityAttributes<'_>) -> Result<Vec<f64>, Refusal> {
    let rows: TapeItems<'_> = attributes.list(0)?;
    let numbers = rows
        .flat_map(|row| attributes.sublist(row))
        .map(|at| attributes.number_at(at))
        .collect::<Option<_>>();
    numbers.ok_or_else(|| attributes.refuse("the weights must be numbers"))
}
