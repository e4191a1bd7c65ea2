//! Common parts of splines in space and in parameter domains: knots, weights, and spans of single numbers.

use glanz_math::DVec3;

use super::Lowering;
use crate::pbrt::lexer::Lexer;
use crate::pbrt::parameters::Parameter;
use crate::source::{ParseResult, Span};

/// The knots of one curve or axis within a parameter that may contain several.
pub(super) struct KnotParameters<'a> {
    /// The parameter.
    pub(super) parameter: &'a Parameter,
    /// Index of the first knot.
    pub(super) first: usize,
    /// Degree + 1.
    pub(super) order: usize,
    /// The knots.
    pub(super) values: &'a [f64],
}

impl Lowering {
    /// Span of a number of a list.
    pub(super) fn number_place(&self, parameter: &Parameter, index: usize) -> Span {
        match self.reporter.sources.bytes(parameter.value_place.location.file) {
            Some(bytes) => Lexer::resume(bytes, &parameter.value_place).word_after(index),
            None => parameter.value_place,
        }
    }

    /// The domain of a spline, which must not be empty; its knots must not decrease, and none may occur more often than the order.
    ///
    /// The number of knots in `values` must be that of the points plus the order, with at least as many points as the order.
    pub(super) fn knot_domain(&mut self, subject: &str, knots: &KnotParameters<'_>) -> ParseResult<[f64; 2]> {
        let KnotParameters { parameter, first, order, values } = *knots;
        let name = &parameter.name;
        if let Some((i, (a, b))) =
            values.iter().zip(values.iter().skip(1)).enumerate().find(|(_, (a, b))| a > b)
        {
            let place = self.number_place(parameter, first + i + 1);
            let message = format!("{subject}: knot vector {name:?} must not decrease");
            let help = Some(format!("sort the knots, or check a missing value between {a} and {b}"));
            return Err(self.reporter.error_with_help(&place, "knots", message, help));
        }
        if let Some((i, knot)) =
            values.iter().zip(values.iter().skip(order)).enumerate().find(|(_, (a, b))| a == b)
        {
            let place = self.number_place(parameter, first + i + order);
            let message = format!("{subject}: knot vector {name:?} has {} more than {order} times", knot.0);
            let help = Some(format!("a spline of order {order} has the same knot {order} times at most"));
            return Err(self.reporter.error_with_help(&place, "knots", message, help));
        }
        let end = values.len().saturating_sub(order);
        let at = |i: usize| values.get(i).copied().unwrap_or_default();
        let domain = [at(order.saturating_sub(1)), at(end)];
        if domain[0] < domain[1] {
            return Ok(domain);
        }
        let place = self.number_place(parameter, first + end);
        let message = format!("{subject}: knot vector {name:?} leaves nothing of the domain");
        let help =
            Some(format!("it spans the knots number {order} to {}, which are both {}", end + 1, domain[0]));
        Err(self.reporter.error_with_help(&place, "knots", message, help))
    }

    /// Refuses a homogeneous point whose weight is not positive or which is at infinity.
    ///
    /// `index`: index of the weight among the numbers of the parameter.
    pub(super) fn check_weight(
        &mut self,
        subject: &str,
        (parameter, index): (&Parameter, usize),
        coordinates: &[f64],
        weight: f64,
    ) -> ParseResult<()> {
        let finite = coordinates.iter().all(|x| x.is_finite() && (x / weight).is_finite());
        if weight > 0.0 && finite {
            return Ok(());
        }
        let place = self.number_place(parameter, index);
        let (message, help) = if weight > 0.0 {
            let message = format!(
                "{subject}: the weight {weight:?} in {:?} puts its point out of range",
                parameter.name
            );
            (message, "weights near 1 are best: a common factor has no effect")
        } else {
            let message =
                format!("{subject}: a weight in {:?} is {weight:?}; it must be positive", parameter.name);
            (message, "for a point of little influence use a small weight, such as 1e-3")
        };
        Err(self.reporter.error_with_help(&place, "weight", message, Some(help.to_owned())))
    }

    /// Homogeneous points from points and, if given, their weights.
    pub(super) fn weighted(
        &mut self,
        subject: &str,
        points: &[DVec3],
        weights: Option<(Parameter, Vec<f64>)>,
    ) -> ParseResult<Vec<[f64; 4]>> {
        let Some((p, weights)) = weights else {
            return Ok(points.iter().map(|p| p.extend(1.0).to_array()).collect());
        };
        if weights.len() != points.len() {
            let message = format!(
                "{subject}: there are {} points \"P\" and {} weights {:?}",
                points.len(),
                weights.len(),
                p.name
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let mut out = Vec::with_capacity(points.len());
        for (i, (point, &weight)) in points.iter().zip(&weights).enumerate() {
            let scaled = *point * weight;
            self.check_weight(subject, (&p, i), &scaled.to_array(), weight)?;
            out.push(scaled.extend(weight).to_array());
        }
        Ok(out)
    }
}
