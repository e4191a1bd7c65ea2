//! Trimming: the kept part of a shape's parameter domain.

use std::f64::consts::FRAC_1_SQRT_2;

use glanz_scene::description::{
    TrimCurveDescription, TrimDescription, TrimEdgeDescription, TrimLoopDescription,
};

use super::Lowering;
use super::spline::KnotParameters;
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::source::ParseResult;

/// Names of the parameters of loops of curves, as in RenderMan's `TrimCurve`.
const CURVES: [&str; 5] = ["trimloops", "trimorders", "trimcounts", "trimknots", "trimpoints"];

/// The kept side of a simple outline; the kept part is on the left of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TrimSide {
    /// Clockwise: the outline is a hole.
    Outside,
    /// Counterclockwise: the inside of the outline is kept.
    Inside,
}

impl Lowering {
    /// The kept side of a shape, if the scene states one.
    pub(super) fn trim(&mut self, list: &mut ParameterList) -> ParseResult<Option<TrimDescription>> {
        let mut loops = self.trim_curves(list)?;
        loops.extend(self.trim_outlines(list)?);
        if loops.is_empty() {
            // Scale and domain have no effect and are reported as not used.
            return Ok(None);
        }
        let place = list.value_place("trimscale");
        let scale = list.float_array("trimscale", &mut self.reporter)?.unwrap_or([1.0; 2]);
        if let Some(factor) = scale.iter().find(|factor| **factor <= 0.0) {
            let message = format!("{}: \"trimscale\" has {factor}; it must be positive", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        let place = list.value_place("trimdomain");
        let domain = list.float_array("trimdomain", &mut self.reporter)?;
        if let Some([u0, v0, u1, v1]) = domain
            && (u0 >= u1 || v0 >= v1)
        {
            let message = format!("{}: \"trimdomain\" is empty", list.subject);
            let help = Some("a domain is smallest u v, largest u v".to_owned());
            return Err(self.reporter.error_with_help(&place, "parameter-range", message, help));
        }
        let domain = domain.map(|[u0, v0, u1, v1]| [[u0, v0], [u1, v1]]);
        Ok(Some(TrimDescription { loops, scale, domain }))
    }

    /// The widths of curves, if the scene states them.
    fn trim_widths(&mut self, list: &mut ParameterList, curves: usize) -> ParseResult<Option<Vec<f64>>> {
        let Some((p, widths)) = list.floats("trimwidths", &mut self.reporter)? else { return Ok(None) };
        self.check_count((list, &p), (widths.len(), "values"), curves, "each curve has a width")?;
        if let Some((i, width)) = widths.iter().enumerate().find(|(_, width)| **width < 0.0) {
            let place = self.number_place(&p, i);
            let message = format!("{}: \"trimwidths\" has {width}; it must not be negative", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        Ok(Some(widths))
    }

    /// The edges of which curves are the images, if the scene states them.
    fn trim_edges(
        &mut self,
        list: &mut ParameterList,
        curves: usize,
    ) -> ParseResult<Vec<Option<TrimEdgeDescription>>> {
        let Some((p, numbers)) = list.integers("trimedges", &mut self.reporter)? else {
            // Fractions have no effect and are reported as not used.
            return Ok(Vec::new());
        };
        let help = "each curve has the number of an edge and those of its first and last vertex";
        self.check_count((list, &p), (numbers.len(), "values"), 3 * curves, help)?;
        let (numbers, _) = numbers.as_chunks::<3>();
        for (curve, numbers) in numbers.iter().enumerate().filter(|(_, numbers)| **numbers != [-1; 3]) {
            if let Some((i, number)) = numbers.iter().enumerate().find(|(_, number)| **number < 0) {
                let place = self.number_place(&p, 3 * curve + i);
                let subject = &list.subject;
                let message = format!(
                    "{subject}: \"trimedges\" has {number}; numbers must be at least 0, or all three of a curve -1"
                );
                return Err(self.reporter.error(&place, "parameter-range", message));
            }
        }
        let ranges = match list.groups::<2>("trimedgeranges", &mut self.reporter)? {
            None => vec![[0.0, 1.0]; curves],
            Some((p, ranges)) => {
                let help = "each curve has the fractions of the edge at its start and its end";
                self.check_count((list, &p), (ranges.len(), "pairs"), curves, help)?;
                let mut fractions = ranges.as_flattened().iter().enumerate();
                if let Some((i, x)) = fractions.find(|(_, x)| !(0.0..=1.0).contains(*x)) {
                    let place = self.number_place(&p, i);
                    let message =
                        format!("{}: \"trimedgeranges\" has {x}; it must be from 0 to 1", list.subject);
                    return Err(self.reporter.error(&place, "parameter-range", message));
                }
                ranges
            }
        };
        let edges = numbers.iter().zip(ranges).map(|(numbers, range)| {
            let [edge, start, end] = numbers.map(|number| u32::try_from(number).ok());
            Some(TrimEdgeDescription { edge: edge?, vertices: [start?, end?], range })
        });
        Ok(edges.collect())
    }

    /// Loops of rational spline curves.
    fn trim_curves(&mut self, list: &mut ParameterList) -> ParseResult<Vec<TrimLoopDescription>> {
        let Some(present) = CURVES.iter().find(|name| list.has(name)) else {
            // Read nevertheless, so that misspelt names are recognised.
            list.ignore(&CURVES);
            return Ok(Vec::new());
        };
        if let Some(missing) = CURVES.iter().find(|name| !list.has(name)) {
            let place = list.value_place(present);
            let message = format!("{}: {present:?} is given without {missing:?}", list.subject);
            let help =
                Some("curves need trimloops, trimorders, trimcounts, trimknots and trimpoints".to_owned());
            return Err(self.reporter.error_with_help(&place, "parameter-missing", message, help));
        }
        let (p, loops) = self.trim_integers(list, "trimloops", 1)?;
        let (p_orders, orders) = self.trim_integers(list, "trimorders", 2)?;
        let (p_counts, counts) = self.trim_integers(list, "trimcounts", 2)?;
        let curves: usize = loops.iter().sum();
        for (p, values) in [(&p_orders, &orders), (&p_counts, &counts)] {
            if values.len() != curves {
                let message = format!(
                    "{}: \"trimloops\" has {curves} curves in all, {:?} is given for {}",
                    list.subject,
                    p.name,
                    values.len()
                );
                return Err(self.reporter.error(&p.value_place, "parameter-count", message));
            }
        }
        if curves == 0 {
            let message = format!("{}: \"trimloops\" has no loops", list.subject);
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        for (i, (&order, &count)) in orders.iter().zip(&counts).enumerate() {
            if count < order {
                let place = self.number_place(&p_counts, i);
                let message = format!(
                    "{}: trimming curve {i} has {count} points; its order {order} needs at least {order}",
                    list.subject
                );
                let help = Some("the order is the degree plus one".to_owned());
                return Err(self.reporter.error_with_help(&place, "parameter-range", message, help));
            }
        }
        let mut curves = self.trim_splines(list, &orders, &counts)?.into_iter();
        Ok(loops
            .into_iter()
            .map(|n| TrimLoopDescription { curves: curves.by_ref().take(n).collect() })
            .collect())
    }

    /// Integers of at least `low`.
    fn trim_integers(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        low: i32,
    ) -> ParseResult<(Parameter, Vec<usize>)> {
        let Some((p, values)) = list.integers(name, &mut self.reporter)? else {
            let message = format!("{} has no \"integer {name}\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        if let Some((i, value)) = values.iter().enumerate().find(|(_, value)| **value < low) {
            let place = self.number_place(&p, i);
            let message = format!("{}: {name:?} has {value}; it must be at least {low}", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        Ok((p, values.into_iter().map(|value| value.unsigned_abs() as usize).collect()))
    }

    /// The curves, one after the other.
    fn trim_splines(
        &mut self,
        list: &mut ParameterList,
        orders: &[usize],
        counts: &[usize],
    ) -> ParseResult<Vec<TrimCurveDescription>> {
        let knots = list.floats("trimknots", &mut self.reporter)?;
        let points = list.groups::<3>("trimpoints", &mut self.reporter)?;
        let (Some((p_knots, knots)), Some((p_points, points))) = (knots, points) else {
            let message = format!("{} has no \"float trimknots\" or \"float trimpoints\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let all_points: usize = counts.iter().sum();
        let all_knots = all_points.saturating_add(orders.iter().sum());
        let (found, help) =
            (knots.len(), "the number of knots of a curve is that of its points plus the order");
        self.check_count((list, &p_knots), (found, "values"), all_knots, help)?;
        let (found, help) = (points.len(), "a point has three numbers: w u, w v, w");
        self.check_count((list, &p_points), (found, "points"), all_points, help)?;
        for (i, [u, v, w]) in points.iter().enumerate() {
            self.check_weight(&list.subject, (&p_points, 3 * i + 2), &[*u, *v], *w)?;
        }
        let mut widths = self.trim_widths(list, orders.len())?.map(Vec::into_iter);
        let mut edges = self.trim_edges(list, orders.len())?.into_iter();
        let mut curves = Vec::with_capacity(orders.len());
        let (mut first, mut values, mut rest) = (0, knots.as_slice(), points.into_iter());
        for (&order, &count) in orders.iter().zip(counts) {
            let Some((of_curve, others)) = values.split_at_checked(order + count) else { break };
            let knots = KnotParameters { parameter: &p_knots, first, order, values: of_curve };
            self.knot_domain(&list.subject, &knots)?;
            let points = rest.by_ref().take(count).collect();
            curves.push(TrimCurveDescription {
                degree: order.saturating_sub(1),
                knots: of_curve.to_vec(),
                points,
                width: widths.as_mut().and_then(Iterator::next),
                edge: edges.next().flatten(),
            });
            (first, values) = (first + of_curve.len(), others);
        }
        Ok(curves)
    }

    /// Refuses a number of objects other than the required one.
    fn check_count(
        &mut self,
        (list, p): (&ParameterList, &Parameter),
        (found, objects): (usize, &str),
        needed: usize,
        help: &str,
    ) -> ParseResult<()> {
        if found == needed {
            return Ok(());
        }
        let message =
            format!("{}: parameter {:?} has {found} {objects}; {needed} are needed", list.subject, p.name);
        let help = Some(help.to_owned());
        Err(self.reporter.error_with_help(&p.value_place, "parameter-count", message, help))
    }

    /// Polygons, ellipses and rectangles; each parameter may occur several times.
    fn trim_outlines(&mut self, list: &mut ParameterList) -> ParseResult<Vec<TrimLoopDescription>> {
        let mut polygons = Vec::new();
        while let Some((p, corners)) = list.groups::<2>("trimpolygon", &mut self.reporter)? {
            polygons.push((p, 0, corners));
        }
        while let Some((p, rectangles)) = list.groups::<4>("trimrectangle", &mut self.reporter)? {
            for (i, [u0, v0, u1, v1]) in rectangles.into_iter().enumerate() {
                let corners = vec![[u0, v0], [u1, v0], [u1, v1], [u0, v1]];
                polygons.push((p.clone(), 4 * i, corners));
            }
        }
        let mut ellipses = Vec::new();
        while let Some((p, found)) = list.groups::<4>("trimellipse", &mut self.reporter)? {
            ellipses.extend(found.into_iter().enumerate().map(|(i, e)| (p.clone(), 4 * i, e)));
        }
        if polygons.is_empty() && ellipses.is_empty() {
            // Without an outline `trimside` has no effect and is reported as not used.
            return Ok(Vec::new());
        }
        let side = self.trim_side(list)?;
        let mut loops = Vec::with_capacity(polygons.len() + ellipses.len());
        for (p, first, corners) in polygons {
            let Some(points) = polygon(corners, side) else {
                let place = self.number_place(&p, first);
                let message = format!("{}: {:?} encloses no area", list.subject, p.name);
                let help = Some("an outline has at least three corners that are not on one line".to_owned());
                return Err(self.reporter.error_with_help(&place, "trim-outline", message, help));
            };
            loops.push(TrimLoopDescription { curves: vec![points] });
        }
        for (p, first, ellipse) in ellipses {
            let [_, _, ru, rv] = ellipse;
            for (i, radius) in [(2, ru), (3, rv)] {
                if radius <= 0.0 {
                    let place = self.number_place(&p, first + i);
                    let message = format!(
                        "{}: a radius in \"trimellipse\" is {radius}; it must be positive",
                        list.subject
                    );
                    let help = Some("an ellipse is centre u, centre v, radius along u, along v".to_owned());
                    return Err(self.reporter.error_with_help(&place, "trim-outline", message, help));
                }
            }
            let curve = self::ellipse(ellipse, side);
            if !curve.points.as_flattened().iter().all(|x| x.is_finite()) {
                let place = self.number_place(&p, first);
                let message = format!("{}: an ellipse in \"trimellipse\" is out of range", list.subject);
                return Err(self.reporter.error(&place, "trim-outline", message));
            }
            loops.push(TrimLoopDescription { curves: vec![curve] });
        }
        Ok(loops)
    }

    fn trim_side(&mut self, list: &mut ParameterList) -> ParseResult<TrimSide> {
        match list.text_parameter("trimside", &mut self.reporter)? {
            None => Ok(TrimSide::Outside),
            Some((_, side)) if side == "outside" => Ok(TrimSide::Outside),
            Some((_, side)) if side == "inside" => Ok(TrimSide::Inside),
            Some((p, side)) => {
                let message = format!("{}: \"trimside\" is {:?}", list.subject, shortened(&side));
                let help = Some("the side that is kept is \"outside\" or \"inside\"".to_owned());
                Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help))
            }
        }
    }
}

/// A closed polygon; `None` if it encloses no area. The first corner may be repeated at the end.
fn polygon(mut corners: Vec<[f64; 2]>, side: TrimSide) -> Option<TrimCurveDescription> {
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let &start = corners.first()?;
    // Twice the signed area of the fan about the first corner.
    let from_start = |[u, v]: [f64; 2]| [u - start[0], v - start[1]];
    let area: f64 = corners
        .iter()
        .zip(corners.iter().skip(1))
        .map(|(a, b)| {
            let ([au, av], [bu, bv]) = (from_start(*a), from_start(*b));
            au * bv - av * bu
        })
        .sum();
    if area.is_nan() || area == 0.0 {
        return None;
    }
    corners.push(start);
    if (area > 0.0) != (side == TrimSide::Inside) {
        corners.reverse();
    }
    let last = (corners.len() - 1) as f64;
    let inner = (0..corners.len()).map(|i| i as f64);
    let knots = std::iter::once(0.0).chain(inner).chain([last]).collect();
    let points = corners.into_iter().map(|[u, v]| [u, v, 1.0]).collect();
    Some(TrimCurveDescription { degree: 1, knots, points, width: None, edge: None })
}

/// An ellipse from centre and radii: four exact quarters of a rational quadratic.
fn ellipse([cu, cv, ru, rv]: [f64; 4], side: TrimSide) -> TrimCurveDescription {
    let around: [[f64; 2]; 9] = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    let mut points: Vec<[f64; 3]> = around
        .iter()
        .enumerate()
        .map(|(i, [u, v])| {
            let w = if i % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 };
            [w * (cu + ru * u), w * (cv + rv * v), w]
        })
        .collect();
    if side == TrimSide::Outside {
        points.reverse();
    }
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    TrimCurveDescription { degree: 2, knots, points, width: None, edge: None }
}
