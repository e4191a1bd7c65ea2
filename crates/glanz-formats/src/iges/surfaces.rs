//! Surfaces.

use std::f64::consts::TAU;

use glanz_brep::model::{FaceSurface, Placement};
use glanz_math::glam::{DAffine2, DMat2};
use glanz_math::{DMat4, DVec2, DVec3};

use super::attributes::is_rigid;
use super::curves::check_degree;
use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use crate::cad::{Refusal, spline_surface};

/// Difference from a turn up to which a sweep is one, radians: files write it with five digits or more.
const TURN_SLACK: f64 = 1e-4;

/// A surface with its relation to that of the file.
#[derive(Clone, Debug)]
pub(super) struct IgesSurface {
    pub(super) surface: FaceSurface,
    /// From parameters of the file to its own; `None` if the standard defines none.
    pub(super) parameters: Option<DAffine2>,
    /// Whether its normal is opposite to that of the file.
    pub(super) reversed: bool,
    /// The ranges of its parameters in the file, where it is bounded.
    pub(super) ranges: Option<[[f64; 2]; 2]>,
}

/// A surface of the model by its index.
#[derive(Clone, Debug)]
pub(super) struct SurfaceLink {
    pub(super) index: usize,
    pub(super) parameters: Option<DAffine2>,
    pub(super) reversed: bool,
    pub(super) ranges: Option<[[f64; 2]; 2]>,
}

impl IgesSurface {
    /// A surface with the parameters of the file.
    pub(super) fn same(surface: FaceSurface, ranges: Option<[[f64; 2]; 2]>) -> Self {
        Self { surface, parameters: Some(DAffine2::IDENTITY), reversed: false, ranges }
    }

    pub(super) fn without_parameters(surface: FaceSurface) -> Self {
        Self { surface, parameters: None, reversed: false, ranges: None }
    }
}

impl<'a> IgesReader<'a> {
    /// A surface of the model, made once.
    pub(super) fn surface(&mut self, entity: IgesEntity<'a>) -> Result<SurfaceLink, Refusal> {
        if let Some(known) = self.surfaces.get(&entity.index) {
            return known.clone();
        }
        let surface = self.any_surface(entity);
        let link = surface.map(|IgesSurface { surface, parameters, reversed, ranges }| {
            let index = self.add_surface(surface, entity.id());
            SurfaceLink { index, parameters, reversed, ranges }
        });
        self.surfaces.insert(entity.index, link.clone());
        link
    }

    fn any_surface(&mut self, entity: IgesEntity<'_>) -> Result<IgesSurface, Refusal> {
        self.spend(entity)?;
        let outer = self.metres() * entity.matrix()?;
        match entity.kind() {
            108 => plane(entity, outer),
            118 => self.ruled(entity, outer),
            120 => self.revolution(entity, outer),
            122 => self.tabulated_cylinder(entity, outer),
            128 => rational_spline(entity, outer),
            140 => self.offset(entity, outer),
            190 | 192 | 194 | 196 | 198 => {
                self.check_rigid(entity, &outer)?;
                analytic(entity, outer)
            }
            _ => Err(entity.refuse_kind("surface")),
        }
    }

    /// Refuses surfaces that a map other than a rotation or reflection makes into others.
    fn check_rigid(&self, entity: IgesEntity<'_>, outer: &DMat4) -> Result<(), Refusal> {
        if is_rigid(&(self.metres().inverse() * *outer)) {
            Ok(())
        } else {
            Err(entity.refuse("its transformation is neither a rotation nor a reflection"))
        }
    }

    /// `L, C, SA, TA`: the generatrix C turned about the line L. The first parameter is that of C, the second the angle.
    fn revolution(&mut self, entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
        let (line, generatrix) = (entity.reference(1)?, entity.reference(2)?);
        let [start, end] = entity.numbers(3)?;
        self.check_rigid(entity, &outer)?;
        let line = self.curve(line, outer, MAX_DEPTH)?;
        let curve = self.curve(generatrix, outer, MAX_DEPTH)?;
        let [from, to] = line.domain();
        let origin = line.point(from);
        let axis = (line.point(to) - origin)
            .try_normalize()
            .ok_or_else(|| entity.refuse("the axis has no length"))?;
        // A reflection turns the sense of rotations.
        let axis = axis * outer.determinant().signum();
        let exchange = DAffine2::from_mat2(DMat2::from_cols(DVec2::Y, DVec2::X));
        let sweep = end - start;
        if !(sweep > 0.0 && sweep <= TAU + TURN_SLACK) {
            return Err(entity
                .refuse(format!("the angles are {start} and {end}; they must ascend by at most a turn")));
        }
        let sweep = if sweep >= TAU - TURN_SLACK { TAU } else { sweep };
        let ranges = [[start, start + sweep], curve.domain()];
        let surface = FaceSurface::Revolution { curve: Box::new(curve), origin, axis };
        Ok(IgesSurface { surface, parameters: Some(exchange), reversed: true, ranges: Some(ranges) })
    }

    /// `C, LX, LY, LZ`: the directrix C moved so that its start comes to a point. Both parameters are from 0 to 1.
    fn tabulated_cylinder(&mut self, entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
        let curve = self.curve(entity.reference(1)?, outer, MAX_DEPTH)?;
        let [x, y, z] = entity.numbers(2)?;
        let [from, to] = curve.domain();
        let direction = outer.transform_point3(DVec3::new(x, y, z)) - curve.point(from);
        if direction == DVec3::ZERO || !direction.is_finite() {
            return Err(entity.refuse("the length of the cylinder is 0, or not finite"));
        }
        let scale = DMat2::from_diagonal(DVec2::new(to - from, 1.0));
        let parameters = DAffine2::from_mat2_translation(scale, DVec2::new(from, 0.0));
        let surface = FaceSurface::Extrusion { curve: Box::new(curve), direction };
        let ranges = Some([[from, to], [0.0, 1.0]]);
        Ok(IgesSurface { surface, parameters: Some(parameters), reversed: false, ranges })
    }

    /// `NX, NY, NZ, D, SURFACE`: a spline moved along its normal, to the side of a vector in the middle of its parameters.
    fn offset(&mut self, entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
        let [x, y, z, distance] = entity.numbers(1)?;
        self.check_rigid(entity, &outer)?;
        let basis = entity.reference(5)?;
        if basis.kind() != 128 {
            return Err(basis.refuse_kind("surface with an offset"));
        }
        self.spend(basis)?;
        let inner = outer * basis.matrix()?;
        let IgesSurface { surface, parameters, reversed, ranges } = rational_spline(basis, inner)?;
        let side = outer.transform_vector3(DVec3::new(x, y, z));
        let normal = match (&surface, ranges) {
            (FaceSurface::Spline(spline), Some([[u0, u1], [v0, v1]])) => {
                spline.normal(0.5 * (u0 + u1), 0.5 * (v0 + v1))
            }
            _ => None,
        };
        let cosine = normal.map_or(0.0, |normal| normal.dot(side));
        if cosine == 0.0 || !cosine.is_finite() {
            return Err(entity.refuse("the side of the offset is unknown"));
        }
        let length = outer.determinant().abs().cbrt();
        let surface =
            FaceSurface::Offset { basis: Box::new(surface), distance: distance * length * cosine.signum() };
        Ok(IgesSurface { surface, parameters, reversed, ranges })
    }
}

/// Number of parameters of a surface in front of its references to notes and properties.
pub(super) fn own_parameters(entity: IgesEntity<'_>) -> Result<usize, Refusal> {
    let has_reference = usize::from(entity.form() == 1);
    Ok(match entity.kind() {
        108 => 9,
        128 => rational_spline_layout(entity)?.ranges_at + 3,
        140 => 5,
        190 => 2 + has_reference,
        192 => 3 + has_reference,
        194 | 198 => 4 + has_reference,
        196 => 2 + 2 * has_reference,
        // 118, 120 and 122.
        _ => 4,
    })
}

/// `A, B, C, D`: the points with A x + B y + C z = D. It has no parameters.
fn plane(entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
    let [a, b, c, d] = entity.numbers(1)?;
    let normal = DVec3::new(a, b, c);
    let square = normal.length_squared();
    let fault = || entity.refuse("the normal of the plane has no length");
    let unit = normal.try_normalize().ok_or_else(fault)?;
    let x = unit.any_orthonormal_vector();
    let [x, y, across] = [x, unit.cross(x), unit].map(|v| outer.transform_vector3(v));
    let z = x.cross(y).try_normalize().ok_or_else(fault)?;
    let z = if z.dot(across) < 0.0 { -z } else { z };
    let origin = outer.transform_point3(normal * (d / square));
    if !origin.is_finite() {
        return Err(entity.refuse("the plane is not finite"));
    }
    Ok(IgesSurface::without_parameters(FaceSurface::Plane(Placement::from_axis(origin, z, x))))
}

/// Where the parameters of a rational spline are.
struct SplineLayout {
    counts: [usize; 2],
    degrees: [usize; 2],
    knots_v_at: usize,
    weights_at: usize,
    points_at: usize,
    ranges_at: usize,
}

/// `K1, K2, M1, M2, PROP1-5, knots, weights, points, U0, U1, V0, V1`.
fn rational_spline_layout(entity: IgesEntity<'_>) -> Result<SplineLayout, Refusal> {
    let counts = [entity.count(1)? + 1, entity.count(2)? + 1];
    let degrees = [check_degree(entity, 3)?, check_degree(entity, 4)?];
    let total = counts[0].saturating_mul(counts[1]);
    let knots_v_at = 10 + counts[0] + degrees[0] + 1;
    let weights_at = knots_v_at + counts[1] + degrees[1] + 1;
    let points_at = weights_at.saturating_add(total);
    let ranges_at = points_at.saturating_add(total.saturating_mul(3));
    if counts[0] <= degrees[0] || counts[1] <= degrees[1] || entity.len() + 1 < ranges_at {
        let [m, n] = counts;
        return Err(entity.refuse(format!("there are too few parameters for {m} x {n} control points")));
    }
    Ok(SplineLayout { counts, degrees, knots_v_at, weights_at, points_at, ranges_at })
}

/// A rational spline, of whose control points the first parameter runs fastest.
fn rational_spline(entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
    let SplineLayout { counts, degrees, knots_v_at, weights_at, points_at, ranges_at } =
        rational_spline_layout(entity)?;
    let knots =
        |range: std::ops::Range<usize>| range.map(|i| entity.number(i)).collect::<Result<Vec<f64>, _>>();
    let (knots_u, knots_v) = (knots(10..knots_v_at)?, knots(knots_v_at..weights_at)?);
    let mut net = Vec::with_capacity(counts[0]);
    for i in 0..counts[0] {
        let mut row = Vec::with_capacity(counts[1]);
        for j in 0..counts[1] {
            let at = i + counts[0] * j;
            let (weight, [x, y, z]) = (entity.number(weights_at + at)?, entity.numbers(points_at + 3 * at)?);
            row.push((outer.transform_point3(DVec3::new(x, y, z)) * weight).extend(weight));
        }
        net.push(row);
    }
    let surface = spline_surface(degrees, [knots_u, knots_v], net).map_err(|reason| entity.refuse(reason))?;
    let domain = [surface.knots_u().domain(), surface.knots_v().domain()];
    let mut ranges = domain;
    if entity.len() + 1 >= ranges_at + 4 {
        let [u0, u1, v0, v1] = entity.numbers(ranges_at)?;
        for (range, [from, to]) in ranges.iter_mut().zip([[u0, u1], [v0, v1]]) {
            let part = [from.max(range[0]), to.min(range[1])];
            if part[0] < part[1] {
                *range = part;
            }
        }
    }
    Ok(IgesSurface::same(FaceSurface::Spline(surface), Some(ranges)))
}

/// A point or a direction, moved.
fn located(entity: IgesEntity<'_>, i: usize, kind: u32, outer: DMat4) -> Result<Option<DVec3>, Refusal> {
    let Some(part) = entity.optional_reference(i)? else { return Ok(None) };
    if part.kind() != kind {
        return Err(part.refuse_kind(if kind == 116 { "point" } else { "direction" }));
    }
    let matrix = outer * part.matrix()?;
    let [x, y, z] = part.numbers(1)?;
    let vector = DVec3::new(x, y, z);
    let moved = if kind == 116 {
        Some(matrix.transform_point3(vector)).filter(|point| point.is_finite())
    } else {
        matrix.transform_vector3(vector).try_normalize()
    };
    moved.map(Some).ok_or_else(|| part.refuse("it has no length, or is not finite"))
}

/// Surfaces of the types 190 to 198: a plane, or one of an axis. Their curves in parameters are not needed.
fn analytic(entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
    let length = outer.determinant().abs().cbrt();
    // Location, axis, reference direction, by their parameters.
    let [at, axis_at, reference_at] = match entity.kind() {
        190 => [1, 2, 3],
        192 => [1, 2, 4],
        194 => [1, 2, 5],
        196 => [1, 3, 4],
        _ => [1, 2, 5],
    };
    let missing = |what: &str| entity.refuse(format!("the surface has no {what}"));
    let origin = located(entity, at, 116, outer)?.ok_or_else(|| missing("location"))?;
    let optional = |i: usize| if i <= entity.len() { located(entity, i, 123, outer) } else { Ok(None) };
    // In form 0 there are references to notes and properties in place of the directions.
    let has_reference = entity.form() == 1;
    let z = match entity.kind() {
        196 if !has_reference => DVec3::Z,
        196 => optional(axis_at)?.unwrap_or(DVec3::Z),
        _ => optional(axis_at)?.ok_or_else(|| missing("axis"))?,
    };
    let x = if has_reference { optional(reference_at)? } else { None };
    let placement = Placement::from_axis(origin, z, x.unwrap_or_else(|| z.any_orthonormal_vector()));
    let radius = |i: usize| {
        let value = entity.number(i)?;
        let radius = value * length;
        if radius >= f64::MIN_POSITIVE && radius.is_finite() {
            Ok(radius)
        } else {
            Err(entity.refuse(format!("the radius is {value}; it must be positive and finite")))
        }
    };
    let surface = match entity.kind() {
        190 => FaceSurface::Plane(placement),
        192 => FaceSurface::Cylinder { placement, radius: radius(3)? },
        194 => {
            let radius = entity.number(3)? * length;
            let degrees = entity.number(4)?;
            if !(degrees > 0.0 && degrees < 90.0 && radius >= 0.0 && radius.is_finite()) {
                return Err(entity
                    .refuse(format!("the angle of the cone is {degrees} degrees, its radius {radius} m")));
            }
            FaceSurface::Cone { placement, radius, half_angle: degrees.to_radians() }
        }
        196 => FaceSurface::Sphere { placement, radius: radius(2)? },
        _ => FaceSurface::Torus {
            placement,
            major_radius: radius(3)?,
            minor_radius: radius(4)?,
            select_outer: true,
        },
    };
    Ok(IgesSurface::without_parameters(surface))
}
