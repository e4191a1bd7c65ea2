//! The curve along which one of two polynomials vanishes, and the other one along it.
//!
//! Near a tangency both distances f from the planes through the ray have parallel gradients. Of h, that along these gradients, and g,
//! that across them, h is *regular*: its derivative by one parameter, y, has one sign over the cell. So h = 0 is a curve y = Y(x), which
//! a cubic meets up to the fourth power of its length, and g along the curve is a polynomial in x. A contact of any order, and a curve
//! in which the ray lies within the surface, are found in a few halvings of x instead of one cell for every few units of rounding.
//!
//! With G = g(x, Y(x)), H = h(x, Y(x)) for the cubic Y, and w a bound on its distance from the curve, a root y of the cell at x satisfies
//! by Taylor's formula |G H_y - G_y H| <= w^2 (|H_y| |g_yy| + |G_y| |h_yy|) / 2. That polynomial is the *eliminant*.

use glanz_math::DVec2;

use super::arc_polynomial::{LONGEST, ScaledBernstein, crossing, value};

/// Largest degree of a cell whose contact curve is searched, in both directions.
pub(super) const MOST_DEGREE: usize = 7;

/// Largest parameter by which a curve may leave the cell, at which h is still regular.
const EXCESS: f64 = 0.25;

/// Smallest derivative of h, relative to its mean, with which h is regular.
const REGULAR: f64 = 0.25;

/// Smallest change of h over a cell, in units of its rounding.
const SIGNIFICANT: f64 = 8.0;

/// Values of the eliminant, in units of its uncertainty, up to which a part of the curve is in contact with the ray. One that is partly
/// above has a range of three units or no root: halving ends.
const CONTACT: f64 = 4.0;

/// Values of g on the edges of a cell up to which a contact is expected, in units of its rounding.
const EXPECTED_NOISE: f64 = 4.0;

/// The same relative to the largest coefficient of g. Measured: with rounding alone the slowest ray of a hyperboloid takes three times as long; with
/// 1/64 it takes a quarter less, and one beside collapsed edges a quarter more.
const EXPECTED_FRACTION: f64 = 1.0 / 4096.0;

/// Accuracy of the places at which the eliminant is searched for values, in units of its uncertainty.
const RESOLUTION: f64 = 1.0 / 64.0;

const ROW: usize = MOST_DEGREE + 1;

/// A part of the contact curve, in the parameters of the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ArcRoot {
    pub(super) at: DVec2,
    /// Bound on the shift of the root by rounding.
    pub(super) uncertainty: DVec2,
    /// Ends of the part of the curve along which g is below rounding.
    pub(super) ends: [DVec2; 2],
    /// Whether it may be part of a contact that goes on beyond the cell, or is no simple root.
    pub(super) contact: bool,
}

/// What the contact curve says about a cell.
#[derive(Debug, PartialEq)]
pub(super) enum ArcClass {
    /// h is not regular.
    Irregular,
    /// No root.
    Excluded,
    /// All roots, and parts of the curve that are within rounding of the ray.
    Roots([Option<ArcRoot>; 2]),
    /// Unknown: halve x, the first parameter or the second.
    Open { across_first: bool },
}

/// Both polynomials of a cell, first h, then g: rows by powers of y.
struct ContactCell {
    h: [[f64; ROW]; ROW],
    g: [[f64; ROW]; ROW],
    /// Degrees in x and y.
    p: usize,
    q: usize,
}

/// Values along the curve: polynomial, and its derivative by y; scaled.
fn along_curve(
    rows: &[[f64; ROW]; ROW],
    p: usize,
    q: usize,
    y: &ScaledBernstein<4>,
    rest: &ScaledBernstein<4>,
) -> [ScaledBernstein<{ 4 * MOST_DEGREE + 1 }>; 2] {
    // De Casteljau's algorithm in y with polynomials in x as coefficients.
    let mut work: [ScaledBernstein<{ 4 * MOST_DEGREE + 1 }>; ROW] = [ScaledBernstein::ZERO; ROW];
    for (slot, row) in work.iter_mut().zip(&rows[..=q]) {
        *slot = ScaledBernstein::of(row[..=p].iter().copied());
    }
    let mut slope = ScaledBernstein::ZERO;
    for level in 0..q {
        if level + 1 == q {
            slope = work[0];
            for (k, slot) in slope.coefficients.iter_mut().enumerate() {
                *slot = q as f64 * (work[1].coefficients[k] - *slot);
            }
        }
        for j in 0..q - level {
            let mut next = ScaledBernstein { length: work[j].length + 3, ..ScaledBernstein::ZERO };
            next.add_product(rest, &work[j], 1.0);
            next.add_product(y, &work[j + 1], 1.0);
            work[j] = next;
        }
    }
    [work[0], slope]
}

impl ContactCell {
    /// The root y of h at x, as far as the cell and `EXCESS` reach.
    fn curve(&self, x: f64) -> Option<f64> {
        let mut column = [0.0; ROW];
        for (slot, row) in column.iter_mut().zip(&self.h[..=self.q]) {
            *slot = value(&row[..=self.p], x).0;
        }
        let column = &column[..=self.q];
        let (low, high) = (column[0], column[self.q]);
        let mut y = low / (low - high);
        for _ in 0..8 {
            let (f, slope) = value(column, y.clamp(-1.0, 2.0));
            let step = f / slope;
            y -= step;
            if step.abs() <= 4.0 * f64::EPSILON {
                break;
            }
        }
        (-EXCESS..=1.0 + EXCESS).contains(&y).then_some(y)
    }

    /// Smallest and largest derivative of h by y: of its coefficients.
    fn slopes(&self) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for pair in self.h[..=self.q].windows(2) {
            for (a, b) in pair[0][..=self.p].iter().zip(&pair[1]) {
                let slope = (b - a) * self.q as f64;
                range = (range.0.min(slope), range.1.max(slope));
            }
        }
        range
    }

    /// Bound on the second derivative by y of the coefficients.
    fn bend(&self, rows: &[[f64; ROW]; ROW]) -> f64 {
        let mut most = 0.0_f64;
        for three in rows[..=self.q].windows(3) {
            let of_rows = three[0].iter().zip(&three[1]).zip(&three[2]).take(self.p + 1);
            most = of_rows.fold(most, |most, ((a, b), c)| most.max((a - 2.0 * b + c).abs()));
        }
        most * (self.q * self.q.saturating_sub(1)) as f64
    }
}

/// The direction along which h is measured, and whether y, the parameter with the larger mean derivative, is the second one; `None` if the degrees are too high or there is no
/// direction.
fn direction((p, q): (usize, usize), [a, b]: [DVec2; 2]) -> Option<(DVec2, bool)> {
    let by_second = b.length_squared() >= a.length_squared();
    let along = if by_second { b } else { a };
    let length = along.length();
    // NaN has no direction.
    (length > 0.0 && p.max(q) <= MOST_DEGREE).then(|| (along / length, by_second))
}

/// Whether g is small where h vanishes on two edges of the cell, as along a line of the surface next to the ray; by the arguments of
/// [`classify`].
pub(super) fn is_expected(
    [first, second]: [&[f64]; 2],
    (p, q): (usize, usize),
    slopes: [DVec2; 2],
    noise: f64,
) -> bool {
    let Some((d, _)) = direction((p, q), slopes) else { return false };
    let largest =
        first.iter().zip(second).fold(0.0_f64, |most, (&x, &y)| most.max(d.perp_dot(DVec2::new(x, y)).abs()));
    let expected = (EXPECTED_NOISE * noise).max(EXPECTED_FRACTION * largest);
    // Start, step and degree of the coefficients on each edge.
    let edges = [(0, 1, p), (q * (p + 1), 1, p), (0, p + 1, q), (p, p + 1, q)];
    let touches = |&(start, step, degree): &(usize, usize, usize)| {
        let at = |k: usize| DVec2::new(first[start + k * step], second[start + k * step]);
        let ends = [0, degree].map(|k| d.dot(at(k)));
        if degree == 0 || ends[0].min(ends[1]) > noise || ends[0].max(ends[1]) < -noise {
            return false;
        }
        let (mut h, mut g) = ([0.0; ROW], [0.0; ROW]);
        for (k, (h, g)) in h.iter_mut().zip(&mut g).enumerate().take(degree + 1) {
            (*h, *g) = (d.dot(at(k)), d.perp_dot(at(k)));
        }
        let (h, g) = (&h[..=degree], &g[..=degree]);
        let sign = if ends[0] < ends[1] { 1.0 } else { -1.0 };
        let of_h = |x: f64| {
            let (y, slope) = value(h, x);
            (sign * y, sign * slope)
        };
        let start = (ends[0] / (ends[0] - ends[1])).clamp(0.0, 1.0);
        let root = crossing(of_h, [0.0, 1.0], start, 0.25 * noise);
        value(g, root).0.abs() <= expected
    };
    edges.iter().filter(|edge| touches(edge)).count() >= 2
}

/// Classifies the cell with the Bernstein coefficients `first` and `second`, that of (i, j) at j (p + 1) + i, whose mean derivatives are
/// `slopes`, by its contact curve. `noise` bounds the rounding of the coefficients.
pub(super) fn classify(
    [first, second]: [&[f64]; 2],
    (p, q): (usize, usize),
    slopes: [DVec2; 2],
    noise: f64,
) -> ArcClass {
    let Some((d, by_second)) = direction((p, q), slopes) else { return ArcClass::Irregular };
    let degrees = if by_second { (p, q) } else { (q, p) };
    if degrees.1 == 0 {
        return ArcClass::Irregular;
    }
    let mut cell = ContactCell { h: [[0.0; ROW]; ROW], g: [[0.0; ROW]; ROW], p: degrees.0, q: degrees.1 };
    for j in 0..=q {
        for i in 0..=p {
            let f = DVec2::new(first[j * (p + 1) + i], second[j * (p + 1) + i]);
            let (row, column) = if by_second { (j, i) } else { (i, j) };
            cell.h[row][column] = d.dot(f);
            cell.g[row][column] = d.perp_dot(f);
        }
    }
    cell.examine(noise, by_second)
}

impl ContactCell {
    fn examine(&self, noise: f64, by_second: bool) -> ArcClass {
        let q = self.q;
        let (least, most) = self.slopes();
        let mean = 0.5 * (least + most);
        // A change of h of a few roundings over the cell has no direction.
        if least < REGULAR * mean || mean < SIGNIFICANT * noise {
            return ArcClass::Irregular;
        }
        // The cubic through four points of the curve.
        let nodes = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|x| self.curve(x));
        let [Some(a), Some(b), Some(c), Some(d)] = nodes else {
            let is_partly_inside = nodes.iter().any(Option::is_some);
            return if is_partly_inside {
                ArcClass::Open { across_first: by_second }
            } else {
                ArcClass::Irregular
            };
        };
        let y = [
            a,
            (18.0 * b - 5.0 * a - 9.0 * c + 2.0 * d) / 6.0,
            (18.0 * c - 5.0 * d - 9.0 * b + 2.0 * a) / 6.0,
            d,
        ];
        let excess = y.iter().fold(0.0_f64, |most, y| most.max(-y).max(y - 1.0));
        // Beyond the cell, Bernstein polynomials add up to no more than this.
        let beyond = |degree: usize| (1.0 + 2.0 * excess).powi(degree as i32);
        let slope = mean - 0.5 * (most - least) * beyond(q - 1);
        if slope.is_nan() || slope <= REGULAR * mean {
            return ArcClass::Irregular;
        }
        let (curve, rest) =
            (ScaledBernstein::of(y.into_iter()), ScaledBernstein::of(y.map(|y| 1.0 - y).into_iter()));
        let [h, h_y] = along_curve(&self.h, self.p, q, &curve, &rest);
        let [g, g_y] = along_curve(&self.g, self.p, q, &curve, &rest);
        let mut scaled: ScaledBernstein<LONGEST> =
            ScaledBernstein { length: h.length + h_y.length - 1, ..ScaledBernstein::ZERO };
        scaled.add_product(&g, &h_y, 1.0);
        scaled.add_product(&g_y, &h, -1.0);
        let [rises, steep] = [h_y.largest(), g_y.largest()];
        let distance = (h.largest() + noise) / slope;
        let bend = beyond(q.saturating_sub(2)) * (rises * self.bend(&self.g) + steep * self.bend(&self.h));
        let (curved, rounded) = (0.5 * distance * distance * bend, 1.5 * noise * (rises + steep));
        let limit = curved + rounded;
        // Very large or small numbers have no products.
        if !limit.is_finite() || limit <= 0.0 || !scaled.is_finite() {
            return ArcClass::Irregular;
        }
        let eliminant = Eliminant {
            cell: self,
            y,
            psi: scaled.unscaled(),
            limit,
            offset: 2.0 * noise / slope,
            by_second,
        };
        let (low, high) = eliminant.range();
        if low > limit || high < -limit {
            return ArcClass::Excluded;
        }
        // Halving x divides the distance of the cubic by 16; a curve that is exact to rounding gains nothing by being shorter.
        if curved > rounded {
            return ArcClass::Open { across_first: by_second == (h.largest() > noise) };
        }
        eliminant.classify()
    }
}

/// The eliminant of a cell along its contact curve.
struct Eliminant<'a> {
    cell: &'a ContactCell,
    /// The cubic along which it is the eliminant.
    y: [f64; 4],
    /// Bernstein coefficients.
    psi: ScaledBernstein<LONGEST>,
    /// Uncertainty of the values at roots.
    limit: f64,
    /// Bound on the shift of a root across the curve by rounding.
    offset: f64,
    /// Whether x is the first parameter.
    by_second: bool,
}

impl Eliminant<'_> {
    fn coefficients(&self) -> &[f64] {
        &self.psi.coefficients[..self.psi.length]
    }

    fn range(&self) -> (f64, f64) {
        self.coefficients().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)))
    }

    /// Accuracy of values at the places that are searched.
    fn accuracy(&self) -> f64 {
        RESOLUTION * self.limit
    }

    fn point(&self, x: f64, y: f64) -> DVec2 {
        if self.by_second { DVec2::new(x, y) } else { DVec2::new(y, x) }
    }

    /// The point of the contact curve at x.
    fn at(&self, x: f64) -> DVec2 {
        self.point(x, self.cell.curve(x).unwrap_or_else(|| value(&self.y, x).0))
    }

    /// The part of the curve between x0 and x1, around a root at x.
    fn arc(&self, [x0, x1]: [f64; 2], x: f64, uncertainty: f64) -> ArcRoot {
        let run = (value(&self.y, x).1.abs() * uncertainty).min(1.0);
        ArcRoot {
            at: self.at(x),
            uncertainty: self.point(uncertainty, run + self.offset),
            ends: [self.at(x0), self.at(x1)],
            contact: true,
        }
    }

    /// All roots, if the eliminant is within rounding, monotone or convex.
    fn classify(&self) -> ArcClass {
        let ((low, high), limit) = (self.range(), self.limit);
        if low >= -CONTACT * limit && high <= CONTACT * limit {
            return ArcClass::Roots([Some(self.arc([0.0, 1.0], 0.5, 1.0)), None]);
        }
        if let Some(sign) = self.sign(1) {
            return ArcClass::Roots([self.ascending(sign, [0.0, 1.0]), None]);
        }
        match self.sign(2) {
            Some(sign) => self.convex(sign),
            None => ArcClass::Open { across_first: self.by_second },
        }
    }

    /// Difference of the first or second order.
    fn difference(&self, k: usize, order: usize) -> f64 {
        let psi = self.coefficients();
        if order == 1 { psi[k + 1] - psi[k] } else { psi[k + 2] - 2.0 * psi[k + 1] + psi[k] }
    }

    /// The sign of all differences of an order, if they have the same.
    fn sign(&self, order: usize) -> Option<f64> {
        let count = self.psi.length.saturating_sub(order);
        let (mut up, mut down) = (count > 0, count > 0);
        for k in 0..count {
            let s = self.difference(k, order);
            (up, down) = (up && s >= 0.0, down && s <= 0.0);
        }
        if up {
            Some(1.0)
        } else if down {
            Some(-1.0)
        } else {
            None
        }
    }

    /// The root between two places between which the eliminant ascends, multiplied by `sign`.
    fn ascending(&self, sign: f64, [from, to]: [f64; 2]) -> Option<ArcRoot> {
        let limit = self.limit;
        let above = |x: f64, level: f64| {
            let (f, slope) = value(self.coefficients(), x);
            (sign * f - level, sign * slope)
        };
        if above(from, 0.0).0 > limit || above(to, 0.0).0 < -limit {
            return None;
        }
        let level =
            |level: f64, start: f64| crossing(|x| above(x, level), [from, to], start, self.accuracy());
        let x = level(0.0, 0.5 * (from + to));
        let (x0, x1) = (level(-limit, x), level(limit, x));
        // At an end of the curve it may be the end of a contact in the next cell.
        let contact = x0.min(x1) <= 0.0 || x0.max(x1) >= 1.0;
        let found = ArcRoot { contact, ..self.arc([x0, x1], x, (x1 - x0).abs().max(f64::EPSILON)) };
        let outside = (found.at - DVec2::splat(0.5)).abs() - 0.5;
        let beside = outside.cmpgt(4.0 * found.uncertainty + 1e-12).any();
        (!beside).then_some(found)
    }

    /// The roots of an eliminant that is convex, multiplied by `sign`: it ascends from the least value to both ends.
    fn convex(&self, sign: f64) -> ArcClass {
        let (psi, limit) = (self.coefficients(), self.limit);
        let degree = psi.len() - 1;
        let rises: [f64; LONGEST] =
            std::array::from_fn(|k| if k < degree { sign * self.difference(k, 1) } else { 0.0 });
        // Differences are derivatives over the degree. The value there is above the least one by no more than the accuracy.
        let flat = self.accuracy() / degree as f64;
        let x = crossing(|x| value(&rises[..degree], x), [0.0, 1.0], 0.5, flat);
        let least = sign * value(psi, x).0;
        if least > limit + self.accuracy() {
            return ArcClass::Excluded;
        }
        if least < -limit {
            return ArcClass::Roots([self.ascending(sign, [x, 0.0]), self.ascending(sign, [x, 1.0])]);
        }
        let [x0, x1] = [0.0, 1.0].map(|end| {
            let above = |z: f64| {
                let (f, slope) = value(psi, z);
                (sign * f - 2.0 * limit, sign * slope)
            };
            crossing(above, [x, end], 0.5 * (x + end), self.accuracy())
        });
        ArcClass::Roots([Some(self.arc([x0, x1], x, (x1 - x0).max(f64::EPSILON))), None])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::bernstein::binomial;

    const NOISE: f64 = 1e-15;

    /// Bernstein coefficients of degrees (p, q) of a sum of c x^a y^b.
    fn polynomial((p, q): (usize, usize), terms: &[(usize, usize, f64)]) -> Vec<f64> {
        let power = |n: usize, i: usize, k: usize| binomial(i, k) / binomial(n, k);
        let at =
            |i: usize, j: usize| terms.iter().map(|&(a, b, c)| c * power(p, i, a) * power(q, j, b)).sum();
        (0..=q).flat_map(|j| (0..=p).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect()
    }

    /// Coefficients of h + k g and of g - k h, the plane turned, so that neither polynomial is h; and their mean gradients.
    fn turned(
        (p, q): (usize, usize),
        h: &[(usize, usize, f64)],
        g: &[(usize, usize, f64)],
    ) -> ([Vec<f64>; 2], [DVec2; 2]) {
        let (h, g, k) = (polynomial((p, q), h), polynomial((p, q), g), 0.75);
        let first: Vec<f64> = h.iter().zip(&g).map(|(h, g)| h + k * g).collect();
        let second: Vec<f64> = h.iter().zip(&g).map(|(h, g)| g - k * h).collect();
        let at = |i: usize, j: usize| DVec2::new(first[j * (p + 1) + i], second[j * (p + 1) + i]);
        let a = (0..=q).map(|j| at(p, j) - at(0, j)).sum::<DVec2>() / (q + 1) as f64;
        let b = (0..=p).map(|i| at(i, q) - at(i, 0)).sum::<DVec2>() / (p + 1) as f64;
        ([first, second], [a, b])
    }

    fn class(degrees: (usize, usize), h: &[(usize, usize, f64)], g: &[(usize, usize, f64)]) -> ArcClass {
        let ([first, second], slopes) = turned(degrees, h, g);
        classify([&first, &second], degrees, slopes, NOISE)
    }

    fn roots(class: &ArcClass) -> Vec<ArcRoot> {
        match class {
            ArcClass::Roots(roots) => roots.iter().flatten().copied().collect(),
            other => panic!("{other:?}"),
        }
    }

    /// y - 0.3 - 0.2 x.
    const LINE: [(usize, usize, f64); 3] = [(0, 1, 1.0), (0, 0, -0.3), (1, 0, -0.2)];

    #[test]
    fn tangency_beside_tangency_and_two_roots_are_told_apart_in_one_cell() {
        // (x - 0.4)^2 - c along the line y = 0.3 + 0.2 x.
        let parabola =
            |c: f64| class((2, 2), &LINE, &[(2, 0, 0.01), (1, 0, -0.008), (0, 0, 0.0016 - 0.01 * c)]);
        let touching = roots(&parabola(0.0));
        assert!(
            matches!(touching[..], [ArcRoot { contact: true, at, .. }] if at.distance(DVec2::new(0.4, 0.38)) < 1e-6)
        );
        let [a, b] = touching[0].ends;
        // Twice 4.5 noise below a parabola of 0.01: of 1e-6 length.
        assert!((b.x - a.x) > 1e-7 && (b.x - a.x) < 1e-5, "{a} {b}");
        for distance in [1e-2, 1e-4] {
            let found = roots(&parabola(distance * distance));
            assert_eq!(found.len(), 2);
            for (root, x) in found.iter().zip([0.4 - distance, 0.4 + distance]) {
                assert!(!root.contact && root.at.distance(DVec2::new(x, 0.3 + 0.2 * x)) < 1e-9, "{root:?}");
            }
            assert_eq!(parabola(-distance * distance), ArcClass::Excluded);
        }
        // Roots beyond the cell belong to others.
        assert_eq!(
            class((2, 2), &LINE, &[(2, 0, 0.01), (1, 0, 0.01), (0, 0, -0.02 * 1.1)]),
            ArcClass::Excluded
        );
    }

    #[test]
    fn ray_in_the_surface_is_one_contact_along_the_whole_curve() {
        // g vanishes on h = 0 for the curve y = 0.4 + 0.3 x - 0.2 x^2, off which the surface is twisted.
        let h = [(0, 1, 1.0), (0, 0, -0.4), (1, 0, -0.3), (2, 0, 0.2)];
        let twisted: Vec<_> =
            h.iter().flat_map(|&(a, b, c)| [(a + 1, b, 0.3 * c), (a, b + 1, 0.1 * c)]).collect();
        let found = roots(&class((3, 2), &h, &twisted));
        assert!(
            matches!(found[..], [ArcRoot { contact: true, ends: [a, b], .. }]
            if a.distance(DVec2::new(0.0, 0.4)) < 1e-9 && b.distance(DVec2::new(1.0, 0.5)) < 1e-9),
            "{found:?}"
        );
    }

    #[test]
    fn contact_is_expected_where_the_ray_lies_beside_a_line_of_the_surface() {
        // g is (0.1 + 0.2 x + 0.3 y) h, and `beside` more.
        let expected = |beside: f64| {
            let twisted = LINE
                .iter()
                .flat_map(|&(a, b, c)| [(a, b, 0.1 * c), (a + 1, b, 0.2 * c), (a, b + 1, 0.3 * c)]);
            let g: Vec<_> = twisted.chain([(0, 0, beside)]).collect();
            let ([first, second], slopes) = turned((2, 2), &LINE, &g);
            is_expected([&first, &second], (2, 2), slopes, NOISE)
        };
        assert_eq!([0.0, 1e-5, 0.01].map(expected), [true, true, false]);
        let ([first, second], slopes) = turned((2, 2), &LINE, &[(1, 0, 0.1), (0, 0, -0.05)]);
        assert!(!is_expected([&first, &second], (2, 2), slopes, NOISE));
    }

    #[test]
    fn simple_root_is_found_and_what_has_no_direction_is_left() {
        let found = roots(&class((2, 2), &LINE, &[(1, 0, 0.1), (2, 0, 0.02), (0, 0, -0.05 - 0.005)]));
        assert!(
            matches!(found[..], [ArcRoot { contact: false, at, .. }] if at.distance(DVec2::new(0.5, 0.4)) < 1e-12)
        );
        // The change of h is rounding.
        assert_eq!(class((1, 1), &[(0, 1, 4.0 * NOISE)], &[(1, 0, NOISE)]), ArcClass::Irregular);
        // The gradient of h changes its sign.
        assert_eq!(class((2, 2), &[(0, 2, 1.0), (0, 1, -0.9)], &[(1, 0, 0.01)]), ArcClass::Irregular);
    }
}
