//! Every root of a ray with a patch, slowly and for certain.
//!
//! The ray is taken as thick: all its parallels within `thickness` are meant at once, by coefficients that are intervals. A
//! *certified* root is one that each of them has exactly once (an interval Newton step maps a box into itself); what is
//! excluded none of them has. What is neither, down to cells in which the thickness hides everything, is a *cluster*:
//! tangencies, collapsed edges, rays within the surface.
//!
//! Nothing of the library is used but its rays. The existence test is that of @moore2009 chapter 8.

use glanz_math::Ray;

use super::cell::{Answer, Cell, Verdict};
use super::interval::Interval;
use super::patch::{BEYOND, Patch, Rows, restrict, value_at};

/// Cells of a patch at most; what is open then is a cluster.
const MOST_CELLS: usize = 200_000;

/// Where something is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the patch.
    pub patch: usize,
    pub u: Interval,
    pub v: Interval,
    /// Ray parameter.
    pub t: Interval,
}

/// Where a certified root lies in the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zone {
    /// For certain.
    Inside,
    /// In the domain or out of it, by less than the thickness moves it.
    Border,
}

/// What a ray meets.
#[derive(Clone, Debug, Default)]
pub struct Found {
    pub roots: Vec<(Place, Zone)>,
    pub clusters: Vec<Place>,
    /// Cells that were looked at.
    pub cells: usize,
    /// Patches whose cells became too many.
    pub given_up: usize,
}

/// A ray as two equations: what is left of x and y (or two other axes) after a shift along the ray to z = 0.
pub struct Line {
    origin: [f64; 3],
    /// Axis along which the direction is largest, and the two others.
    axes: [usize; 3],
    along: f64,
    ratios: [Interval; 2],
    ray: Ray,
}

impl Line {
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let k = (0..3).fold(0, |k, i| if d[i].abs() > d[k].abs() { i } else { k });
        let axes = [k, (k + 1) % 3, (k + 2) % 3];
        let ratios = [axes[1], axes[2]].map(|i| Interval::of(d[i]) / Interval::of(d[k]));
        Self { origin: ray.origin.to_array(), axes, along: d[k], ratios, ray: *ray }
    }

    /// Whether the line passes the ball around the control points, with a millionth to spare.
    fn misses(&self, patch: &Patch, thickness: f64) -> bool {
        let (from, d) = (patch.center - self.ray.origin, self.ray.direction);
        let reach = patch.radius * (1.0 + 1e-6) + 2.0 * thickness + 1e-12 * from.length();
        from.cross(d).length_squared() > reach * reach * d.length_squared()
    }

    /// Coefficients of the two equations, one list after the other.
    fn project(&self, patch: &Patch, thickness: f64) -> Vec<Interval> {
        let [k, i, j] = self.axes;
        let centered = |point: &[Interval; 4], axis: usize| point[axis] - point[3] * self.origin[axis];
        let list = |axis: usize, ratio: Interval| {
            patch.net.iter().map(move |point| {
                let distance = centered(point, axis) - centered(point, k) * ratio;
                distance.widened(thickness * point[3].magnitude())
            })
        };
        list(i, self.ratios[0]).chain(list(j, self.ratios[1])).collect()
    }

    /// The place of the box `u` x `v`, which is in the parameters of the extended net.
    fn place(&self, index: usize, patch: &Patch, u: Interval, v: Interval) -> Place {
        let k = self.axes[0];
        let list = |c: usize| -> Vec<Interval> { patch.net.iter().map(|p| p[c]).collect() };
        let [mut heights, mut weights] = [k, 3].map(list);
        let height = if u.width().max(v.width()) < 1e-6 {
            value_at(&heights, patch.degrees, u, v) / value_at(&weights, patch.degrees, u, v)
        } else {
            // Over a wide box the coefficients over it bound the height, those of the whole with wide parameters do not.
            for list in [&mut heights, &mut weights] {
                for (along_u, side) in [(true, u), (false, v)] {
                    Rows::along(patch.degrees, along_u).map(list, |row| restrict(row, side.low, side.high));
                }
            }
            let shares = heights.iter().zip(&weights).map(|(&height, &weight)| height / weight);
            shares.reduce(Interval::hull).unwrap_or(Interval::ONE)
        };
        let t = (height - Interval::of(self.origin[k])) / Interval::of(self.along);
        let own = |x: Interval| x * (1.0 + 2.0 * BEYOND) - Interval::of(BEYOND);
        Place { patch: index, u: own(u), v: own(v), t }
    }
}

/// Every root of the line through `ray` with the patches, whatever its sign.
///
/// `thickness` is in metres across the ray.
pub fn solve(patches: &[Patch], ray: &Ray, thickness: f64) -> Found {
    let line = Line::new(ray);
    let mut found = Found::default();
    for (index, patch) in patches.iter().enumerate() {
        if !line.misses(patch, thickness) {
            solve_patch(&line, index, patch, thickness, &mut found);
        }
    }
    found
}

fn solve_patch(line: &Line, index: usize, patch: &Patch, thickness: f64, found: &mut Found) {
    let first = found.roots.len();
    let mut stack = vec![Cell::whole(line.project(patch, thickness))];
    let mut spare = Vec::new();
    let mut count = 0;
    while let Some(mut cell) = stack.pop() {
        count += 1;
        let verdict = if count > MOST_CELLS { Verdict::Hidden } else { cell.examine(patch.degrees) };
        let answer = match verdict {
            Verdict::Excluded => Answer::Nothing,
            Verdict::Hidden => {
                let [u, v] = cell.sides();
                found.clusters.push(line.place(index, patch, u, v));
                Answer::Nothing
            }
            Verdict::Injective => cell.certify(patch.degrees),
            Verdict::Open => Answer::Unknown,
        };
        match answer {
            Answer::Nothing => spare.push(cell.coefficients),
            Answer::Root([u, v]) => {
                let place = line.place(index, patch, u, v);
                let same =
                    |(other, _): &(Place, Zone)| other.u.overlaps(place.u) && other.v.overlaps(place.v);
                if let Some(zone) = zone(&place)
                    && !found.roots[first..].iter().any(same)
                {
                    found.roots.push((place, zone));
                }
                spare.push(cell.coefficients);
            }
            Answer::Unknown => {
                let high = cell.split(patch.degrees, spare.pop().unwrap_or_default());
                stack.extend([cell, high]);
            }
        }
    }
    found.cells += count;
    found.given_up += usize::from(count > MOST_CELLS);
}

/// `None` if it is out of the domain for certain.
fn zone(place: &Place) -> Option<Zone> {
    let unit = Interval { low: 0.0, high: 1.0 };
    let inside = |x: Interval| x.low > 0.0 && x.high < 1.0;
    if inside(place.u) && inside(place.v) {
        Some(Zone::Inside)
    } else {
        (place.u.overlaps(unit) && place.v.overlaps(unit)).then_some(Zone::Border)
    }
}
