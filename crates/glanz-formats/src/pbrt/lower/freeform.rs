//! Freeform surfaces: pbrt's `nurbs`, and additional kinds of patches; `docs/scene-format.md` describes them.

use glanz_math::DVec3;
use glanz_scene::description::{
    BezierPatchesDescription, BezierTrianglesDescription, GeometryDescription, NurbsDescription,
};

use super::Lowering;
use super::spline::KnotParameters;
use crate::newell::{self, transposed};
use crate::pbrt::parameters::{Parameter, ParameterList};
use crate::source::ParseResult;

/// Default degree of patches, and that of lists in Newell's format.
const CUBIC: u32 = 3;

/// Names of the parameters of one direction of a `nurbs`.
struct NurbsAxisNames {
    count: &'static str,
    order: &'static str,
    knots: &'static str,
    from: &'static str,
    to: &'static str,
}

const U: NurbsAxisNames =
    NurbsAxisNames { count: "nu", order: "uorder", knots: "uknots", from: "u0", to: "u1" };
const V: NurbsAxisNames =
    NurbsAxisNames { count: "nv", order: "vorder", knots: "vknots", from: "v0", to: "v1" };

/// One direction of a `nurbs`.
struct NurbsAxis {
    count: usize,
    degree: usize,
    knots: Vec<f64>,
    /// The domain of the knots.
    domain: [f64; 2],
    /// The kept part of the domain.
    part: [f64; 2],
}

impl Lowering {
    /// Lowers a freeform surface.
    pub(super) fn freeform(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
    ) -> ParseResult<GeometryDescription> {
        match kind {
            "nurbs" => self.nurbs(list),
            "bezierpatch" => self.bezier_patches(list),
            "beziertriangle" => self.bezier_triangles(list),
            _ => self.patch_mesh(list),
        }
    }

    fn nurbs(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let u = self.axis(list, &U)?;
        let v = self.axis(list, &V)?;
        let points = self.net(list, u.count, v.count)?;
        let whole = u.part == u.domain && v.part == v.domain;
        Ok(GeometryDescription::Nurbs(NurbsDescription {
            degree_u: u.degree,
            degree_v: v.degree,
            knots_u: u.knots,
            knots_v: v.knots,
            points: transposed(&points, u.count),
            domain: (!whole).then_some([u.part, v.part]),
        }))
    }

    fn axis(&mut self, list: &mut ParameterList, names: &NurbsAxisNames) -> ParseResult<NurbsAxis> {
        let count_place = list.value_place(names.count);
        let count = self.count(list, names.count)?;
        let order = self.count(list, names.order)?;
        if count < order {
            let message = format!(
                "{}: {:?} is {count}; an order {:?} of {order} needs at least {order}",
                list.subject, names.count, names.order
            );
            let help = Some(format!("{:?} is the degree plus one", names.order));
            return Err(self.reporter.error_with_help(&count_place, "parameter-range", message, help));
        }
        let Some((p, knots)) = list.floats(names.knots, &mut self.reporter)? else {
            return Err(self.missing(list, "float", names.knots));
        };
        let needed = count.saturating_add(order);
        if knots.len() != needed {
            let message = format!(
                "{}: parameter {:?} has {} values; {needed} are needed",
                list.subject,
                names.knots,
                knots.len()
            );
            let help = Some(format!(
                "the number of knots is the sum of {:?} and {:?}, {count} + {order}",
                names.count, names.order
            ));
            return Err(self.reporter.error_with_help(&p.value_place, "parameter-count", message, help));
        }
        let domain = self
            .knot_domain(&list.subject, &KnotParameters { parameter: &p, first: 0, order, values: &knots })?;
        let part = self.part(list, names, domain)?;
        Ok(NurbsAxis { count, degree: order.saturating_sub(1), knots, domain, part })
    }

    /// A number of points or an order, both at least 2.
    fn count(&mut self, list: &mut ParameterList, name: &'static str) -> ParseResult<usize> {
        match list.integer_from(name, 2, &mut self.reporter)? {
            Some(count) => Ok(count as usize),
            None => Err(self.missing(list, "integer", name)),
        }
    }

    fn missing(&mut self, list: &ParameterList, kind: &str, name: &str) -> crate::source::ReportedError {
        let message = format!("{} has no \"{kind} {name}\"", list.subject);
        self.reporter.error(&list.place, "parameter-missing", message)
    }

    /// The kept part of the domain along one direction.
    fn part(
        &mut self,
        list: &mut ParameterList,
        names: &NurbsAxisNames,
        domain: [f64; 2],
    ) -> ParseResult<[f64; 2]> {
        let mut part = domain;
        let mut place = list.place;
        for (name, end) in [names.from, names.to].into_iter().zip(&mut part) {
            let here = list.value_place(name);
            let Some(value) = list.float(name, &mut self.reporter)? else { continue };
            if value < domain[0] || value > domain[1] {
                let message = format!(
                    "{}: {name:?} is {value}; the knots {:?} go from {} to {}",
                    list.subject, names.knots, domain[0], domain[1]
                );
                let help = Some(format!("omit {name:?} to keep everything on that side"));
                return Err(self.reporter.error_with_help(&here, "parameter-range", message, help));
            }
            (*end, place) = (value, here);
        }
        if part[0] < part[1] {
            return Ok(part);
        }
        let message = format!(
            "{}: from {:?} = {} to {:?} = {} nothing of the surface is left",
            list.subject, names.from, part[0], names.to, part[1]
        );
        let help = Some(format!("{:?} is the smaller of the two", names.from));
        Err(self.reporter.error_with_help(&place, "parameter-range", message, help))
    }

    /// The homogeneous control points of a `nurbs` in the order of the file.
    fn net(&mut self, list: &mut ParameterList, nu: usize, nv: usize) -> ParseResult<Vec<[f64; 4]>> {
        let place = list.value_place("Pw");
        let plain = list.vec3s("P", &mut self.reporter)?;
        let weighted = list.groups::<4>("Pw", &mut self.reporter)?;
        let (p, points) = match (plain, weighted) {
            (Some(_), Some(_)) => {
                let message = format!("{}: give either \"P\" or \"Pw\"", list.subject);
                return Err(self.reporter.error(&place, "parameter-count", message));
            }
            (None, None) => {
                let message = format!("{} has neither points \"P\" nor \"float Pw\"", list.subject);
                return Err(self.reporter.error(&list.place, "parameter-missing", message));
            }
            (Some((p, points)), None) => (p, self.weighted(&list.subject, &points, None)?),
            (None, Some((p, points))) => {
                for (i, [x, y, z, w]) in points.iter().enumerate() {
                    self.check_weight(&list.subject, (&p, 4 * i + 3), &[*x, *y, *z], *w)?;
                }
                (p, points)
            }
        };
        let needed = nu.saturating_mul(nv);
        if points.len() == needed {
            return Ok(points);
        }
        let message = format!(
            "{}: {:?} has {} points, \"nu\" times \"nv\" is {needed}",
            list.subject,
            p.name,
            points.len()
        );
        Err(self.reporter.error(&p.value_place, "parameter-count", message))
    }

    fn bezier_patches(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let degree_u = self.degree(list, "udegree")?;
        let degree_v = self.degree(list, "vdegree")?;
        let count = degree_u.saturating_add(1).saturating_mul(degree_v.saturating_add(1));
        let what = format!("a patch of degrees {degree_u} and {degree_v}");
        let patches = self.patches(list, count, &what)?;
        let patches = patches.chunks_exact(count).map(|p| transposed(p, degree_u + 1)).collect();
        Ok(GeometryDescription::BezierPatches(BezierPatchesDescription { degree_u, degree_v, patches }))
    }

    fn bezier_triangles(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let degree = self.degree(list, "degree")?;
        let count = degree.saturating_add(1).saturating_mul(degree.saturating_add(2)) / 2;
        let patches = self.patches(list, count, &format!("a triangle of degree {degree}"))?;
        let patches = patches.chunks_exact(count).map(<[_]>::to_vec).collect();
        Ok(GeometryDescription::BezierTriangles(BezierTrianglesDescription { degree, patches }))
    }

    fn degree(&mut self, list: &mut ParameterList, name: &'static str) -> ParseResult<usize> {
        Ok(list.integer_from(name, 1, &mut self.reporter)?.unwrap_or(CUBIC) as usize)
    }

    /// The homogeneous points of one or more patches of `count` points each.
    fn patches(&mut self, list: &mut ParameterList, count: usize, what: &str) -> ParseResult<Vec<[f64; 4]>> {
        if let Some((p, points)) = list.groups::<4>("Pw", &mut self.reporter)? {
            for (i, [x, y, z, w]) in points.iter().enumerate() {
                self.check_weight(&list.subject, (&p, 4 * i + 3), &[*x, *y, *z], *w)?;
            }
            self.check_patch_points(list, &p, points.len(), (count, what))?;
            return Ok(points);
        }
        let (p, points) = self.positions(list)?;
        let weights = list.floats("weights", &mut self.reporter)?;
        self.check_patch_points(list, &p, points.len(), (count, what))?;
        self.weighted(&list.subject, &points, weights)
    }

    /// Refuses points that are not those of one or more patches of `count` points each.
    fn check_patch_points(
        &mut self,
        list: &ParameterList,
        p: &Parameter,
        found: usize,
        (count, what): (usize, &str),
    ) -> ParseResult<()> {
        if found == 0 || !found.is_multiple_of(count) {
            let message =
                format!("{}: there are {found} points {:?}, {what} has {count}", list.subject, p.name);
            let help = Some(format!("give {count} points, or a multiple for several patches"));
            return Err(self.reporter.error_with_help(&p.value_place, "parameter-count", message, help));
        }
        Ok(())
    }

    /// Bicubic patches with shared points.
    fn patch_mesh(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        if !list.has("P") {
            let message = format!("{} has neither \"string filename\" nor points \"P\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        }
        let (p, positions) = self.positions(list)?;
        let indices = self.corners::<{ newell::POINTS }>(list, &p, positions.len())?;
        self.bicubic_patches(list, &positions, &indices)
    }

    /// Bicubic patches, each of sixteen of the `positions` by their indices.
    pub(super) fn bicubic_patches(
        &mut self,
        list: &ParameterList,
        positions: &[DVec3],
        indices: &[[u32; newell::POINTS]],
    ) -> ParseResult<GeometryDescription> {
        if indices.is_empty() {
            let message = format!("{} has no patches", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-count", message));
        }
        Ok(GeometryDescription::BezierPatches(newell::bicubic_patches(positions, indices)))
    }
}
