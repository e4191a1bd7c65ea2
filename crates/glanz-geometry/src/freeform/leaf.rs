//! A piece of a patch that is almost a parallelogram, with bounds on how far it is not.

use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec3};

use super::net::{self, Poly};

/// A rectangle of a patch's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
}

impl Rect {
    pub(super) const UNIT: Self = Self { u: [0.0, 1.0], v: [0.0, 1.0] };

    /// The parameters of the patch at those of the rectangle, both in [0, 1]^2. Corners are met exactly.
    pub(super) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let mix = |[a, b]: [f64; 2], x: f64| if x == 1.0 { b } else { (b - a) * x + a };
        (mix(self.u, x), mix(self.v, y))
    }

    /// Halves across u or v.
    pub(super) fn halves(&self, across_u: bool) -> [Self; 2] {
        let (mut low, mut high) = (*self, *self);
        let (l, h) = if across_u { (&mut low.u, &mut high.u) } else { (&mut low.v, &mut high.v) };
        let middle = 0.5 * (l[0] + l[1]);
        l[1] = middle;
        h[0] = middle;
        [low, high]
    }
}

/// A leaf as a *thick parallelogram*: for (s, t) in [-1, 1]^2 the point of the surface is within `reach` of
/// `center + s along_u + t along_v`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) center: DVec3,
    /// Half of the derivative by the leaf's u, which goes from 0 to 1.
    pub(super) along_u: DVec3,
    /// The same for v.
    pub(super) along_v: DVec3,
    /// Metres.
    pub(super) reach: f64,
    /// Sum of the squares of the bounds on how far the half derivatives stray from `along_u` and `along_v`.
    pub(super) stray_squared: f64,
    /// Bound on the half of any second derivative by (s, t), so that a linear step of length h is off by at most
    /// `bend` h^2.
    pub(super) bend: f64,
}

/// A leaf while the surface is built.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub(super) frame: Frame,
    pub(super) bounds: Bounds3,
    pub(super) patch: u32,
    pub(super) rect: Rect,
    pub(super) degrees: (usize, usize),
    pub(super) net: Vec<DVec4>,
}

fn largest(vectors: impl Iterator<Item = DVec3>) -> f64 {
    vectors.fold(0.0, |most: f64, v| most.max(v.length()))
}

impl Frame {
    /// The frame of a net of `degrees`.
    pub(super) fn new(points: &[DVec4], degrees: (usize, usize)) -> Self {
        let middle = net::jet(points, degrees, 0.5, 0.5);
        let (center, a, b) = (middle.s, middle.su * 0.5, middle.sv * 0.5);
        let (reach, m_a, m_b, bend) = if points.iter().all(|p| p.w == 1.0) {
            polynomial_bounds(points, degrees, center, a, b)
        } else {
            rational_bounds(points, degrees, center, a, b)
        };
        // The bounds themselves are rounded, and so is the net of the leaf.
        let size = largest(points.iter().map(|p| p.truncate() / p.w));
        let reach = reach * (1.0 + 1e-12) + gamma(64) * size;
        Self {
            center,
            along_u: a,
            along_v: b,
            reach,
            stray_squared: (m_a * m_a + m_b * m_b) * (1.0 + 1e-12),
            bend,
        }
    }

    /// How far from a parallelogram: the bound on the relative change of the Jacobian, seen along the normal.
    pub(super) fn unevenness(&self) -> f64 {
        let area = self.along_u.cross(self.along_v).length_squared();
        (self.stray_squared * (self.along_u.length_squared() + self.along_v.length_squared()) / area).sqrt()
    }

    /// A box around the parallelogram and its reach.
    pub(super) fn bounds(&self) -> Bounds3 {
        let half = self.along_u.abs() + self.along_v.abs() + DVec3::splat(self.reach);
        Bounds3::new(self.center - half, self.center + half)
    }
}

/// Reach, strays and bend of a polynomial patch from its coefficients, which bound it as their hull does.
fn polynomial_bounds(
    points: &[DVec4],
    (p, q): (usize, usize),
    center: DVec3,
    a: DVec3,
    b: DVec3,
) -> (f64, f64, f64, f64) {
    let space = Poly { degrees: (p, q), coefficients: points.iter().map(|p| p.truncate()).collect() };
    let affine = |k: usize| {
        let (i, j) = (k / (q + 1), k % (q + 1));
        center + a * (2.0 * i as f64 / p as f64 - 1.0) + b * (2.0 * j as f64 / q as f64 - 1.0)
    };
    let reach = largest(space.coefficients.iter().enumerate().map(|(k, &c)| c - affine(k)));
    let (du, dv) = (space.derivative(true), space.derivative(false));
    let m_a = largest(du.coefficients.iter().map(|&d| d * 0.5 - a));
    let m_b = largest(dv.coefficients.iter().map(|&d| d * 0.5 - b));
    let second = |d: &Poly<DVec3>, by_first| largest(d.derivative(by_first).coefficients.into_iter()) * 0.25;
    let (uu, uv, vv) = (second(&du, true), second(&du, false), second(&dv, false));
    (reach, m_a, m_b, 0.5 * (uu + 2.0 * uv + vv))
}

/// The same for a rational patch: quotients are bounded by their numerator over the least denominator.
fn rational_bounds(
    points: &[DVec4],
    degrees: (usize, usize),
    center: DVec3,
    a: DVec3,
    b: DVec3,
) -> (f64, f64, f64, f64) {
    // About the centre, so that the products cancel as little as they can.
    let space = Poly { degrees, coefficients: points.iter().map(|p| p.truncate() - center * p.w).collect() };
    let weight = Poly { degrees, coefficients: points.iter().map(|p| p.w).collect() };
    let least = points.iter().fold(f64::INFINITY, |least, p| least.min(p.w));
    let most = |poly: &Poly<DVec3>| largest(poly.coefficients.iter().copied());
    // s a + t b over the unit square: bilinear coefficients at the corners.
    let affine = Poly { degrees: (1, 1), coefficients: vec![-a - b, b - a, a - b, a + b] };
    let one = Poly { degrees: (1, 1), coefficients: vec![1.0; 4] };
    let minus = |x: Poly<DVec3>, y: Poly<DVec3>| Poly {
        degrees: x.degrees,
        coefficients: x.coefficients.iter().zip(&y.coefficients).map(|(&x, &y)| x - y).collect(),
    };
    let reach = most(&minus(space.times(&one), affine.times(&weight))) / least;
    // (X' W - X W') / 2 - a W^2, all of degrees (2p, 2q) or one less.
    let stray = |by_first: bool, along: DVec3| {
        let raise = Poly { degrees: if by_first { (1, 0) } else { (0, 1) }, coefficients: vec![0.5; 2] };
        let rise = space.derivative(by_first).times(&weight).times(&raise);
        let fall = space.times(&weight.derivative(by_first)).times(&raise);
        let square = weight.times(&weight);
        let mean = Poly { degrees: (0, 0), coefficients: vec![along] }.times(&square);
        most(&minus(minus(rise, fall), mean)) / (least * least)
    };
    (reach, stray(true, a), stray(false, b), f64::INFINITY)
}

impl Draft {
    pub(super) fn new(patch: u32, rect: Rect, net: Vec<DVec4>, degrees: (usize, usize)) -> Self {
        let frame = Frame::new(&net, degrees);
        let hull = net.iter().fold(Bounds3::EMPTY, |b, p| b.including(p.truncate() / p.w));
        // Both hold the leaf. The reach covers the rounding of the net, which the hull does not know of.
        let size = hull.min.abs().max(hull.max.abs()).max_element();
        let pad = DVec3::splat(gamma(64) * size);
        let thick = frame.bounds();
        let bounds = Bounds3::new((hull.min - pad).max(thick.min), (hull.max + pad).min(thick.max));
        Self { frame, bounds, patch, rect, degrees, net }
    }

    /// Whether all weights are 1.
    pub(super) fn is_polynomial(&self) -> bool {
        self.net.iter().all(|p| p.w == 1.0)
    }

    /// Halves it across the direction in which it bends more.
    pub(super) fn halves(&self) -> [Self; 2] {
        let degrees = self.degrees;
        let across_u = bends_along_u(&self.net, degrees);
        let [low, high] = net::split(&self.net, degrees, across_u);
        let [below, above] = self.rect.halves(across_u);
        [Self::new(self.patch, below, low, degrees), Self::new(self.patch, above, high, degrees)]
    }
}

/// Whether the control polygons along u bend more than those along v; where neither bends, whether they are longer.
fn bends_along_u(points: &[DVec4], (p, q): (usize, usize)) -> bool {
    let at = |i: usize, j: usize| {
        let point = points[i * (q + 1) + j];
        point.truncate() / point.w
    };
    let (mut u, mut v) = ([0.0_f64; 2], [0.0_f64; 2]);
    for i in 0..=p {
        for j in 0..=q {
            if i >= 1 {
                u[0] = u[0].max((at(i, j) - at(i - 1, j)).length() * p as f64);
            }
            if j >= 1 {
                v[0] = v[0].max((at(i, j) - at(i, j - 1)).length() * q as f64);
            }
            if i >= 2 {
                let bend = at(i, j) - at(i - 1, j) * 2.0 + at(i - 2, j);
                u[1] = u[1].max(bend.length() * (p * (p - 1)) as f64);
            }
            if j >= 2 {
                let bend = at(i, j) - at(i, j - 1) * 2.0 + at(i, j - 2);
                v[1] = v[1].max(bend.length() * (q * (q - 1)) as f64);
            }
        }
    }
    // A twisted patch without curved lines is cut across its longer side.
    u[1] + 1e-3 * u[0] >= v[1] + 1e-3 * v[0]
}
