//! Light on a floor from flat lamps behind flat panels, in closed form.

use std::f64::consts::TAU;

use glanz_job::CancelFlag;
use glanz_math::{DVec2, DVec3};
use glanz_radiosity::form_factor::polygon::in_front;

use crate::study::StudyError;

/// Abscissa of Gauss's rule with two points on [0, 1].
const GAUSS: f64 = 0.211_324_865_405_187_1;

/// Smallest and largest number of subdivisions of a texel.
const LEVELS: [u32; 2] = [1, 4];

/// Largest difference of the values in a part of a texel that is not divided further, relative to the largest value of all.
const SMOOTH: f64 = 0.04;

/// A floor, lamps and blockers.
pub(super) struct ExactFloor {
    /// Corners of the parallelogram, in the order of its parameters (0, 0), (1, 0), (1, 1), (0, 1).
    floor: Vec<DVec3>,
    normal: DVec3,
    /// Corners, and the radiosity of a floor that sees nothing else.
    lamps: Vec<(Vec<DVec3>, f64)>,
    blockers: Vec<Vec<DVec3>>,
}

/// Means of the floor's radiosity over texels.
pub(super) struct ReferenceTexture {
    /// Rows in sequence, relative to the largest value.
    pub(super) texels: Vec<f64>,
    /// The largest value.
    pub(super) unit: f64,
    /// Root mean square and largest change of a texel by its last division: bounds of the effect of further divisions.
    pub(super) change: [f64; 2],
}

impl ExactFloor {
    pub(super) fn new(floor: Vec<DVec3>, lamps: Vec<(Vec<DVec3>, f64)>, blockers: Vec<Vec<DVec3>>) -> Self {
        let normal = match floor.as_slice() {
            [a, b, .., d] => (*b - *a).cross(*d - *a).normalize_or_zero(),
            _ => DVec3::ZERO,
        };
        Self { floor, normal, lamps, blockers }
    }

    /// The position at these parameters of the floor.
    fn place(&self, uv: DVec2) -> DVec3 {
        match self.floor.as_slice() {
            [a, b, .., d] => *a + uv.x * (*b - *a) + uv.y * (*d - *a),
            _ => DVec3::ZERO,
        }
    }

    /// Radiosity at a place of the floor: Lambert's sum over the edges of the visible part of each lamp (@goral1984 appendix).
    pub(super) fn at(&self, uv: DVec2) -> f64 {
        let x = self.place(uv);
        let seen_from = |(lamp, light): &(Vec<DVec3>, f64)| {
            let lamp = in_front(lamp, x, self.normal);
            if lamp.len() < 3 || normal(&lamp).dot(x - lamp[0]) <= 0.0 {
                return 0.0;
            }
            let mut seen = vec![lamp];
            for blocker in &self.blockers {
                if !seen.iter().all(|piece| is_beside(piece, blocker, x)) {
                    seen = seen.iter().flat_map(|piece| without(piece, blocker, x)).collect();
                }
            }
            light * seen.iter().map(|piece| form_factor(piece, x, self.normal)).sum::<f64>()
        };
        self.lamps.iter().map(seen_from).sum()
    }

    /// Means over `size[0]` x `size[1]` texels.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`] if `cancel` is raised, which is checked before each row.
    pub(super) fn reference(
        &self,
        size: [usize; 2],
        cancel: &CancelFlag,
    ) -> Result<ReferenceTexture, StudyError> {
        let unit = self.largest();
        let step = DVec2::new(1.0 / size[0] as f64, 1.0 / size[1] as f64);
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        let (mut squares, mut most) = (0.0, 0.0_f64);
        for y in 0..size[1] {
            cancel.check()?;
            for x in 0..size[0] {
                let [coarse, fine] = self.mean(DVec2::new(x as f64, y as f64) * step, step, unit, 0);
                texels.push(fine / unit);
                let change = (fine - coarse).abs() / unit;
                squares += change * change;
                most = most.max(change);
            }
        }
        let rms = (squares / texels.len().max(1) as f64).sqrt();
        Ok(ReferenceTexture { texels, unit, change: [rms, most] })
    }

    /// The mean over a rectangle of parameters; `unit`: the largest light of all.
    pub(super) fn mean_over(&self, min: DVec2, size: DVec2, unit: f64) -> f64 {
        // In parts small enough that refinement detects all borders.
        let n = (64.0 * size.max_element()).ceil().max(1.0) as u32;
        let part = size / f64::from(n);
        let parts = (0..n).flat_map(|y| (0..n).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        let sum: f64 = parts.map(|at| self.mean(min + at * part, part, unit, 0)[1]).sum();
        sum / f64::from(n).powi(2)
    }

    /// The largest value at the middles of 32 x 32 parts; 1 if the floor is dark.
    fn largest(&self) -> f64 {
        let n = 32;
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let values = (0..n).flat_map(|y| (0..n).map(move |x| DVec2::new(middle(x), middle(y))));
        let largest = values.map(|uv| self.at(uv)).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// The mean over a rectangle, without and with its last division.
    fn mean(&self, min: DVec2, size: DVec2, unit: f64, level: u32) -> [f64; 2] {
        let places = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
            let at = [GAUSS, 1.0 - GAUSS];
            min + DVec2::new(at[i], at[j]) * size
        });
        let [sure, deepest] = LEVELS;
        let values = if level < sure { [0.0; 4] } else { places.map(|uv| self.at(uv)) };
        let own = 0.25 * values.iter().sum::<f64>();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        if level == deepest || (level >= sure && high - low <= SMOOTH * unit) {
            return [own, own];
        }
        let half = 0.5 * size;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let quarters = corners.map(|corner| self.mean(min + corner * half, half, unit, level + 1));
        let mean = |i: usize| 0.25 * quarters.iter().map(|q| q[i]).sum::<f64>();
        let is_last = level + 1 == deepest;
        [if is_last { own } else { mean(0) }, mean(1)]
    }
}

/// Unit normal of a convex polygon, on the side from which its corners are in counterclockwise order.
fn normal(polygon: &[DVec3]) -> DVec3 {
    let Some((&first, rest)) = polygon.split_first() else { return DVec3::ZERO };
    let twice: DVec3 = rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum();
    twice.normalize_or_zero()
}

/// Inward normals of the planes through `x` and the sides of a convex polygon.
fn sides(polygon: &[DVec3], x: DVec3) -> impl Iterator<Item = DVec3> {
    let middle = polygon.iter().sum::<DVec3>() / polygon.len().max(1) as f64;
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(move |(&a, &b)| {
        let across = (a - x).cross(b - x).normalize_or_zero();
        if across.dot(middle - x) < 0.0 { -across } else { across }
    })
}

/// Whether a polygon lies entirely beside another one as seen from `x`; `false` if the simple test does not show it.
fn is_beside(piece: &[DVec3], blocker: &[DVec3], x: DVec3) -> bool {
    sides(blocker, x).any(|side| piece.iter().all(|p| (p - x).dot(side) <= 0.0))
}

/// The part of a convex polygon that a convex blocker does not hide from `x`, in convex pieces.
fn without(piece: &[DVec3], blocker: &[DVec3], x: DVec3) -> Vec<Vec<DVec3>> {
    let Some(&corner) = blocker.first() else { return vec![piece.to_vec()] };
    let towards = normal(blocker);
    let away = if towards.dot(corner - x) < 0.0 { -towards } else { towards };
    let mut rest = in_front(piece, corner, away);
    // Polygons in its plane are not hidden: a lamp does not hide itself.
    if rest.len() < 3 {
        return vec![piece.to_vec()];
    }
    // On this side of the blocker nothing is hidden.
    let mut pieces = vec![in_front(piece, corner, -away)];
    for side in sides(blocker, x) {
        pieces.push(in_front(&rest, x, -side));
        rest = in_front(&rest, x, side);
    }
    pieces.retain(|piece| piece.len() >= 3);
    pieces
}

/// Form factor from a place with a normal to a polygon in front of it.
fn form_factor(polygon: &[DVec3], x: DVec3, normal: DVec3) -> f64 {
    let ways: Vec<DVec3> = polygon.iter().map(|p| p - x).collect();
    let edges = ways.iter().zip(ways.iter().cycle().skip(1));
    let sum: DVec3 = edges
        .map(|(&a, &b)| {
            let across = a.cross(b);
            let sine = across.length();
            if sine > 0.0 { across / sine * sine.atan2(a.dot(b)) } else { DVec3::ZERO }
        })
        .sum();
    (sum.dot(normal) / TAU).abs()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn square(min: [f64; 2], max: [f64; 2], height: f64) -> Vec<DVec3> {
        [[min[0], min[1]], [max[0], min[1]], max, [min[0], max[1]]]
            .map(|[x, y]| DVec3::new(x, y, height))
            .into()
    }

    fn down(mut corners: Vec<DVec3>) -> Vec<DVec3> {
        corners.reverse();
        corners
    }

    fn floor() -> Vec<DVec3> {
        square([0.0; 2], [1.0; 2], 0.0)
    }

    #[test]
    fn rectangle_above_a_corner_has_its_closed_form() {
        // @howell1982 configuration B-3: a rectangle a x b at distance c, above one of its corners.
        let (a, b, c) = (0.7_f64, 0.4_f64, 0.5_f64);
        let lamp = down(square([0.0; 2], [a, b], c));
        let (x, y) = (a / c, b / c);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        let expected = (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU;
        let exact = ExactFloor::new(floor(), vec![(lamp.clone(), 3.0)], Vec::new());
        assert!((exact.at(DVec2::ZERO) - 3.0 * expected).abs() < 1e-14);
        // From behind it is dark.
        let turned = ExactFloor::new(floor(), vec![(down(lamp), 3.0)], Vec::new());
        assert_eq!(turned.at(DVec2::ZERO), 0.0);
    }

    /// Form factor by many points of a lamp in the plane z = 1 and rays between them and `x`.
    fn by_points(lamp: [[f64; 2]; 2], blockers: &[[[f64; 2]; 2]], heights: &[f64], x: DVec3) -> f64 {
        let n = 400;
        let [low, high] = lamp.map(DVec2::from);
        let mut sum = 0.0;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let share = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(n);
            let way = (low + share * (high - low)).extend(1.0) - x;
            let hidden = blockers.iter().zip(heights).any(|(blocker, height)| {
                let p = x + way * ((height - x.z) / way.z);
                let [min, max] = blocker.map(DVec2::from);
                let p = p.truncate();
                p.cmpge(min).all() && p.cmple(max).all()
            });
            let square = way.length_squared();
            sum += if hidden { 0.0 } else { way.z * way.z / (PI * square * square) };
        }
        sum * (high - low).element_product() / f64::from(n * n)
    }

    #[test]
    fn lamp_behind_two_panels_is_what_points_and_rays_find() {
        let lamp = [[0.2, 0.3], [0.9, 0.7]];
        let blockers = [[[0.3, 0.2], [0.6, 0.6]], [[0.4, 0.4], [0.9, 0.5]]];
        let heights = [0.5, 0.7];
        // The lamp too is in the way of what is behind it.
        let shining = down(square(lamp[0], lamp[1], 1.0));
        let mut panels = vec![shining.clone()];
        panels.extend(blockers.iter().zip(heights).map(|(&[min, max], height)| square(min, max, height)));
        let exact = ExactFloor::new(floor(), vec![(shining, 1.0)], panels);
        for (u, v) in [(0.1, 0.2), (0.4, 0.45), (0.5, 0.5), (0.55, 0.1), (0.9, 0.95), (0.35, 0.8)] {
            let found = exact.at(DVec2::new(u, v));
            let expected = by_points(lamp, &blockers, &heights, DVec3::new(u, v, 0.0));
            assert!((found - expected).abs() < 2e-4, "{u} {v}: {found} {expected}");
        }
    }

    #[test]
    fn reference_of_a_hard_shadow_has_the_share_of_each_texel() {
        // A lamp so small that it is a point: the panel's shadow ends at u = 0.45, in the middle of the fifth of ten texels.
        let lamp = down(square([0.4999; 2], [0.5001; 2], 2.0));
        let panel = square([-3.0, -3.0], [0.475, 3.0], 1.0);
        let exact = ExactFloor::new(floor(), vec![(lamp, 1.0)], vec![panel]);
        let reference = exact.reference([10, 10], &CancelFlag::default()).unwrap();
        for row in reference.texels.chunks(10) {
            assert!(row[..4].iter().all(|&x| x == 0.0), "{row:?}");
            assert!((row[4] / row[5] - 0.5).abs() < 0.05, "{row:?}");
        }
        assert!(reference.change[1] < 0.05 && reference.change[0] <= reference.change[1]);
        assert!((exact.at(DVec2::splat(0.5)) / reference.unit - 1.0).abs() < 1e-2);
    }
}
