//! `Shape "curve"`: threads, bands that face every ray, and ribbons.

use glanz_geometry::curve::{CurveShading, ribbon_surface};
use glanz_math::DVec3;
use glanz_scene::description::{GeometryDescription, NurbsDescription};

use super::Lowering;
use crate::nearest::nearest;
use crate::pbrt::parameters::{Parameter, ParameterList};
use crate::source::ParseResult;

/// Values of `type`.
const TYPES: [&str; 3] = ["flat", "cylinder", "ribbon"];

/// Values of `basis`.
const BASES: [&str; 2] = ["bezier", "bspline"];

impl Lowering {
    /// The surfaces of a curve: one, or of a ribbon one per segment.
    pub(super) fn curve(&mut self, list: &mut ParameterList) -> ParseResult<Vec<GeometryDescription>> {
        // pbrt divides curves for its hierarchy.
        list.ignore(&["splitdepth"]);
        let (p, points) = self.positions(list)?;
        let kind = self.choice(list, "type", &TYPES)?;
        let basis = self.choice(list, "basis", &BASES)?;
        let degree_place = list.value_place("degree");
        let degree = list.integer("degree", &mut self.reporter)?.unwrap_or(3);
        let count = points.len();
        let segments = match (degree, basis) {
            (2 | 3, "bspline") => count.checked_sub(degree as usize),
            (2 | 3, _) if count % degree as usize == 1 => count.checked_sub(1).map(|n| n / degree as usize),
            (2 | 3, _) => None,
            _ => {
                let message = format!("shape \"curve\": the degree is {degree}; it must be 2 or 3");
                return Err(self.reporter.error(&degree_place, "curve", message));
            }
        };
        let Some(segments) = segments.filter(|segments| *segments > 0) else {
            let message = format!("shape \"curve\": {count} points make no {basis} curve of degree {degree}");
            let help = match basis {
                "bspline" => format!("{} points or more are needed", degree + 1),
                _ => format!(
                    "every segment after the first has {degree} points more: {}, {} ...",
                    degree + 1,
                    2 * degree + 1
                ),
            };
            return Err(self.reporter.error_with_help(&p.value_place, "curve", message, Some(help)));
        };
        let points = match basis {
            "bspline" => bezier_of_spline(&points, degree),
            _ if degree == 2 => elevated(&points),
            _ => points,
        };
        let width = self.float(list, "width", 1.0)?;
        let widths = [self.float(list, "width0", width)?, self.float(list, "width1", width)?];
        let normals = list.vec3s("N", &mut self.reporter)?;
        let shading = match kind {
            "ribbon" => return self.ribbons(list, &points, widths, normals, segments),
            "cylinder" => CurveShading::Cylinder,
            _ => CurveShading::Flat,
        };
        if let Some((p, _)) = normals {
            let message = "shape \"curve\": \"N\" counts for the type \"ribbon\" only";
            self.reporter.warning(&p.value_place, "curve", message);
        }
        Ok(vec![GeometryDescription::Curve { points, widths, shading }])
    }

    /// One of the values of a parameter; the first by default.
    fn choice(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        values: &[&'static str],
    ) -> ParseResult<&'static str> {
        let Some((p, value)) = list.text_parameter(name, &mut self.reporter)? else {
            return Ok(values.first().copied().unwrap_or_default());
        };
        if let Some(value) = values.iter().find(|known| **known == value) {
            return Ok(value);
        }
        let message = format!("shape \"curve\": {name} {value:?} is unknown");
        let help = nearest(&value, values.iter().copied()).map(|n| format!("did you mean {n:?}?"));
        Err(self.reporter.error_with_help(&p.value_place, "curve", message, help))
    }

    fn ribbons(
        &mut self,
        list: &ParameterList,
        points: &[DVec3],
        widths: [f64; 2],
        normals: Option<(Parameter, Vec<DVec3>)>,
        segments: usize,
    ) -> ParseResult<Vec<GeometryDescription>> {
        let place = normals.as_ref().map_or(list.place, |(p, _)| p.value_place);
        let normals = normals.map(|(_, normals)| normals).unwrap_or_default();
        if normals.len() != segments + 1 {
            let message = format!(
                "shape \"curve\": a ribbon needs normals \"N\" at the ends of its segments, {} of them; there are {}",
                segments + 1,
                normals.len()
            );
            return Err(self.reporter.error(&place, "curve", message));
        }
        let width_at =
            |segment: usize| widths[0] + (widths[1] - widths[0]) * (segment as f64 / segments as f64);
        let corners = points.windows(4).step_by(3).zip(normals.windows(2)).enumerate();
        let mut surfaces = Vec::with_capacity(segments);
        for (segment, (points, normals)) in corners {
            let points = [points[0], points[1], points[2], points[3]];
            let widths = [width_at(segment), width_at(segment + 1)];
            match ribbon_surface(points, widths, [normals[0], normals[1]]) {
                Ok(ribbon) => surfaces.push(GeometryDescription::Nurbs(NurbsDescription {
                    degree_u: 3,
                    degree_v: 1,
                    knots_u: ribbon.knots,
                    knots_v: vec![0.0, 0.0, 1.0, 1.0],
                    points: ribbon.points.into_iter().flatten().map(|p| p.extend(1.0).to_array()).collect(),
                    domain: None,
                })),
                Err(error) => {
                    let message = format!("shape \"curve\": segment {segment}: {error}");
                    return Err(self.reporter.error(&list.place, "curve", message));
                }
            }
        }
        Ok(surfaces)
    }
}

/// Cubic Bézier segments of quadratic ones.
fn elevated(points: &[DVec3]) -> Vec<DVec3> {
    let inner = points.windows(3).step_by(2).flat_map(|p| {
        let [a, b, c] = [p[0], p[1], p[2]];
        [a.lerp(b, 2.0 / 3.0), c.lerp(b, 2.0 / 3.0), c]
    });
    points.first().copied().into_iter().chain(inner).collect()
}

/// Cubic Bézier segments of a uniform B-spline.
fn bezier_of_spline(points: &[DVec3], degree: i32) -> Vec<DVec3> {
    if degree == 2 {
        let middles = points.windows(2).map(|p| p[0].midpoint(p[1]));
        let corners: Vec<DVec3> =
            middles.zip(points.iter().skip(1)).flat_map(|(middle, corner)| [middle, *corner]).collect();
        // The last corner is the last control point, beyond the curve.
        return elevated(corners.split_last().map_or(&[], |(_, corners)| corners));
    }
    let knot = |p: &[DVec3]| (p[0] + 4.0 * p[1] + p[2]) / 6.0;
    let first = points.get(..3).map(knot);
    let segments = points
        .windows(4)
        .flat_map(|p| [p[1].lerp(p[2], 1.0 / 3.0), p[1].lerp(p[2], 2.0 / 3.0), knot(&p[1..])]);
    first.into_iter().chain(segments).collect()
}
