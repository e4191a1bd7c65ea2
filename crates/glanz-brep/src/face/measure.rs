//! Areas of trimmed faces, and volumes of solids.
//!
//! Integrals over a region of the parameters are integrals along its border (Green): with F(x, y) the integral of f from the left side
//! of the domain to x, the integral of f over the region is that of F dy around its loops. f counts as zero outside the domain, so that
//! parts of loops beyond it add nothing. Both integrals are made of Gauss-Legendre rules, the outer one halved until it holds.

use std::f64::consts::FRAC_PI_4;
use std::ops::{Add, Mul};

use glanz_math::{DVec2, DVec3};

use super::geometry::FaceGeometry;
use super::trim::{FaceTrim, TrimmedFace};
use crate::boundary::BoundaryCurve;
use crate::quadrature::{Integral, MAX_DEPTH, gauss, refined};

/// Integrals over a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceMeasure {
    /// Area, m^2.
    pub area: f64,
    /// The volume between the face and the origin of its part, m^3: a third of the integral of position and normal. Those of all faces
    /// of a solid add up to its volume.
    pub volume: f64,
}

impl Add for FaceMeasure {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { area: self.area + other.area, volume: self.volume + other.volume }
    }
}

impl Mul<f64> for FaceMeasure {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { area: self.area * factor, volume: self.volume * factor }
    }
}

impl Integral for FaceMeasure {
    fn magnitude(self) -> f64 {
        self.area
    }
}

/// How many times more accurate rows are than the whole, so that their errors do not divide curves.
const ROWS: f64 = 8.0;

impl TrimmedFace {
    /// Area and volume to a relative `accuracy` of the area of its surface, where the face is smooth.
    #[must_use]
    pub fn measure(&self, accuracy: f64) -> FaceMeasure {
        let mut field = FaceField::new(self);
        let [[_, x1], [y0, y1]] = field.domain;
        let whole = BoundaryCurve::line(DVec2::new(x1, y0), DVec2::new(x1, y1));
        let tolerance = accuracy * field.along(&whole, f64::INFINITY).area;
        field.row_tolerance = tolerance / (ROWS * (y1 - y0));
        let Some(FaceTrim { loops, .. }) = &self.trim else { return field.along(&whole, tolerance) };
        let count = loops.iter().map(Vec::len).sum::<usize>().max(1);
        let curves = loops.iter().flatten();
        let sum = curves
            .fold(FaceMeasure::default(), |sum, curve| sum + field.along(curve, tolerance / count as f64));
        if sum.area < 0.0 {
            // The loops are holes of the whole domain.
            return sum + field.along(&whole, tolerance);
        }
        sum
    }
}

/// A face as a field over its region.
struct FaceField<'a> {
    face: &'a TrimmedFace,
    domain: [[f64; 2]; 2],
    /// Where the inner integrals are divided.
    breaks: Vec<f64>,
    /// Largest error of the area of the inner integrals, m^2 per unit of y; the same for all, as short rows count little.
    row_tolerance: f64,
}

impl<'a> FaceField<'a> {
    fn new(face: &'a TrimmedFace) -> Self {
        let domain = face.domain();
        let [x, _] = domain;
        let mut breaks: Vec<f64> = match &face.geometry {
            FaceGeometry::Spline(surface) => surface.knots_u().knots().to_vec(),
            geometry => {
                // Pieces of at most an eighth of a turn, so that sines are smooth for the rule.
                let pieces = (geometry.azimuth() / FRAC_PI_4).ceil().max(1.0) as usize;
                (0..=pieces).map(|i| x[0] + (x[1] - x[0]) * i as f64 / pieces as f64).collect()
            }
        };
        breaks.push(x[1]);
        breaks.retain(|&at| at > x[0] && at <= x[1]);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        Self { face, domain, breaks, row_tolerance: f64::INFINITY }
    }

    /// The integrand at a point of the region.
    fn at(&self, point: DVec2) -> FaceMeasure {
        let (position, du, dv) = self.face.geometry.tangents(point);
        let [position, normal] = {
            let sign = if self.face.reversed { -1.0 } else { 1.0 };
            let to_part = &self.face.to_part;
            let normal = du.cross(dv) * sign;
            [to_part.transform_point3(position), to_part.transform_vector3(normal)]
        };
        FaceMeasure { area: normal.length(), volume: position.dot(normal) / 3.0 }
    }

    /// The integral from the left side to `point`, at its height.
    fn row(&self, point: DVec2) -> FaceMeasure {
        let [[x0, x1], [y0, y1]] = self.domain;
        if point.y < y0 || point.y > y1 {
            return FaceMeasure::default();
        }
        let end = point.x.min(x1);
        let rule = |range: [f64; 2]| gauss(range, |x| self.at(DVec2::new(x, point.y)));
        let (mut parts, mut from) = (Vec::with_capacity(self.breaks.len()), x0);
        for &at in &self.breaks {
            let to = at.min(end);
            if to > from {
                parts.push(([from, to], rule([from, to])));
                from = to;
            }
        }
        let tolerance = self.row_tolerance / parts.len().max(1) as f64;
        parts.into_iter().fold(FaceMeasure::default(), |sum, (range, whole)| {
            sum + refined(&rule, range, whole, tolerance, MAX_DEPTH)
        })
    }

    /// The integral of rows along a curve.
    fn along(&self, curve: &BoundaryCurve, tolerance: f64) -> FaceMeasure {
        let (first, last) = (curve.start(), curve.end());
        if curve.degree == 1 && curve.points.len() == 2 && first.y == last.y {
            return FaceMeasure::default();
        }
        let spans = self.divided(curve);
        let part = tolerance / spans.len().max(1) as f64;
        let rule = |range: [f64; 2]| {
            gauss(range, |t| {
                let (point, derivative) = curve.point_and_derivative(t);
                self.row(point) * derivative.y
            })
        };
        spans
            .into_iter()
            .fold(FaceMeasure::default(), |sum, span| sum + refined(&rule, span, rule(span), part, MAX_DEPTH))
    }

    /// The spans of a curve, divided where it leaves the domain: there the integrand has a step.
    fn divided(&self, curve: &BoundaryCurve) -> Vec<[f64; 2]> {
        /// Parts of a span in which a curve crosses a side of the domain at most once, in practice.
        const PARTS: u32 = 8;
        /// Halvings to the last digit.
        const HALVINGS: u32 = 60;
        let mut divided = Vec::new();
        for [from, to] in curve.spans() {
            let mut cuts = vec![from];
            let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(PARTS);
            for (low, high) in (0..PARTS).map(|i| (at(i), at(i + 1))) {
                for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let beyond = |t: f64| curve.point_and_derivative(t).0[axis] > self.domain[axis][side];
                    let start = beyond(low);
                    if start == beyond(high) {
                        continue;
                    }
                    let (mut before, mut behind) = (low, high);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (before + behind);
                        *(if beyond(middle) == start { &mut before } else { &mut behind }) = middle;
                    }
                    cuts.push(behind);
                }
            }
            cuts.push(to);
            cuts.sort_by(f64::total_cmp);
            divided.extend(cuts.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| [pair[0], pair[1]]));
        }
        divided
    }
}

impl TrimmedFace {
    /// The part of the domain that contains the face: the ranges of u and v.
    #[must_use]
    pub fn domain(&self) -> [[f64; 2]; 2] {
        self.trim.as_ref().map_or_else(|| self.geometry.domain(), |trim| trim.domain)
    }
}

impl FaceGeometry {
    /// The point at `uv` in the frame of the surface, metres.
    #[must_use]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.tangents(uv).0
    }

    /// The whole domain of its parameters.
    fn domain(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Spline(surface) => [surface.knots_u().domain(), surface.knots_v().domain()],
            _ => [[0.0, 1.0]; 2],
        }
    }

    /// The length of the azimuth, radians; 0 if it has none.
    fn azimuth(&self) -> f64 {
        match *self {
            Self::Cylinder { phi_max, .. }
            | Self::Cone { phi_max, .. }
            | Self::Sphere { phi_max, .. }
            | Self::Torus { phi_max, .. } => phi_max,
            Self::Plane { .. } | Self::Spline(_) => 0.0,
        }
    }

    /// Position and derivatives by both parameters.
    fn tangents(&self, uv: DVec2) -> (DVec3, DVec3, DVec3) {
        // A profile (distance from the axis, height) with its derivative, turned by the azimuth.
        let turned = |phi_max: f64, [rho, z]: [f64; 2], [drho, dz]: [f64; 2]| {
            let (sin, cos) = (uv.x * phi_max).sin_cos();
            (
                DVec3::new(rho * cos, rho * sin, z),
                DVec3::new(-rho * sin, rho * cos, 0.0) * phi_max,
                DVec3::new(drho * cos, drho * sin, dz),
            )
        };
        match *self {
            Self::Plane { x, y } => {
                let size = DVec2::new(x[1] - x[0], y[1] - y[0]);
                let at = DVec2::new(x[0], y[0]) + uv * size;
                (at.extend(0.0), DVec3::X * size.x, DVec3::Y * size.y)
            }
            Self::Cylinder { radius, z, phi_max } => {
                let height = z[1] - z[0];
                turned(phi_max, [radius, z[0] + uv.y * height], [0.0, height])
            }
            Self::Cone { radius, height, phi_max } => {
                turned(phi_max, [radius * (1.0 - uv.y), uv.y * height], [-radius, height])
            }
            Self::Sphere { radius, z, phi_max } => {
                let [from, to] = z.map(|z| z.atan2(((radius - z) * (radius + z)).max(0.0).sqrt()));
                let (sin, cos) = (from + uv.y * (to - from)).sin_cos();
                let turn = (to - from) * radius;
                turned(phi_max, [radius * cos, radius * sin], [-turn * sin, turn * cos])
            }
            Self::Torus { major_radius, minor_radius, phi_max } => {
                let (sin, cos) = (uv.y * std::f64::consts::TAU).sin_cos();
                let turn = std::f64::consts::TAU * minor_radius;
                turned(
                    phi_max,
                    [major_radius + minor_radius * cos, minor_radius * sin],
                    [-turn * sin, turn * cos],
                )
            }
            Self::Spline(ref surface) => surface.tangents(uv.x, uv.y),
        }
    }
}
