//! Isolation of every root of a ray with a patch: slow, but certain.
//!
//! Coefficients are intervals that cover the ray and all its parallels within `thickness`. Each of these rays has a *certified*
//! root exactly once (an interval Newton step maps a box into itself); none has a root in an excluded cell. Cells that are neither
//! when they have become so small that the thickness hides all differences are *clusters*: tangencies, collapsed edges, rays
//! within the surface.
//!
//! Of the library, only rays are used. The existence test is that of @moore2009 chapter 8.

use glanz_math::Ray;

use super::cell::{CellProof, PatchCell, PatchCellClass};
use super::interval::Interval;
use super::patch::{EXTENSION, NetRows, ReferencePatch, restrict, value_at};

/// Largest number of cells of a patch; those that remain count as clusters.
const MOST_CELLS: usize = 200_000;

/// A box of parameters and ray parameters that may contain a root.
#[derive(Clone, Copy, Debug)]
pub struct RootBox {
    /// Index of the patch.
    pub patch: usize,
    pub u: Interval,
    pub v: Interval,
    /// Ray parameter.
    pub t: Interval,
}

/// Relation of a certified root to the parameter domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DomainRelation {
    /// Certainly inside.
    Inside,
    /// So close to the border that the thickness decides.
    Border,
}

/// Roots and clusters of a ray.
#[derive(Clone, Debug, Default)]
pub struct IsolatedRoots {
    pub roots: Vec<(RootBox, DomainRelation)>,
    pub clusters: Vec<RootBox>,
    /// Number of cells tested.
    pub cells: usize,
    /// Number of patches with more than [`MOST_CELLS`] cells.
    pub given_up: usize,
}

/// The two equations of a ray: the coordinates of a point along two axes, after a shift along the ray to 0 on the third.
pub struct RayEquations {
    origin: [f64; 3],
    /// The axis of the direction's largest component, and the two others.
    axes: [usize; 3],
    along: f64,
    ratios: [Interval; 2],
    ray: Ray,
}

impl RayEquations {
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let k = (0..3).fold(0, |k, i| if d[i].abs() > d[k].abs() { i } else { k });
        let axes = [k, (k + 1) % 3, (k + 2) % 3];
        let ratios = [axes[1], axes[2]].map(|i| Interval::of(d[i]) / Interval::of(d[k]));
        Self { origin: ray.origin.to_array(), axes, along: d[k], ratios, ray: *ray }
    }

    /// Whether the line misses the ball around the control points, with a margin of a millionth.
    fn misses(&self, patch: &ReferencePatch, thickness: f64) -> bool {
        let (from, d) = (patch.center - self.ray.origin, self.ray.direction);
        let reach = patch.radius * (1.0 + 1e-6) + 2.0 * thickness + 1e-12 * from.length();
        from.cross(d).length_squared() > reach * reach * d.length_squared()
    }

    /// Coefficients of the two equations, one list after the other.
    fn project(&self, patch: &ReferencePatch, thickness: f64) -> Vec<Interval> {
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

    /// The box over `u` x `v`, which are parameters of the extended net.
    fn root_box(&self, index: usize, patch: &ReferencePatch, u: Interval, v: Interval) -> RootBox {
        let k = self.axes[0];
        let list = |c: usize| -> Vec<Interval> { patch.net.iter().map(|p| p[c]).collect() };
        let [mut heights, mut weights] = [k, 3].map(list);
        let height = if u.width().max(v.width()) < 1e-6 {
            value_at(&heights, patch.degrees, u, v) / value_at(&weights, patch.degrees, u, v)
        } else {
            // Over a wide box, evaluation with interval parameters gives no useful bound; restricted coefficients do.
            for list in [&mut heights, &mut weights] {
                for (along_u, side) in [(true, u), (false, v)] {
                    NetRows::along(patch.degrees, along_u)
                        .map(list, |row| restrict(row, side.low, side.high));
                }
            }
            let shares = heights.iter().zip(&weights).map(|(&height, &weight)| height / weight);
            shares.reduce(Interval::hull).unwrap_or(Interval::ONE)
        };
        let t = (height - Interval::of(self.origin[k])) / Interval::of(self.along);
        let own = |x: Interval| x * (1.0 + 2.0 * EXTENSION) - Interval::of(EXTENSION);
        RootBox { patch: index, u: own(u), v: own(v), t }
    }
}

/// Every root of the line through `ray` with the patches, whatever its sign.
///
/// `thickness` is in metres across the ray.
pub fn solve(patches: &[ReferencePatch], ray: &Ray, thickness: f64) -> IsolatedRoots {
    let line = RayEquations::new(ray);
    let mut found = IsolatedRoots::default();
    for (index, patch) in patches.iter().enumerate() {
        if !line.misses(patch, thickness) {
            solve_patch(&line, index, patch, thickness, &mut found);
        }
    }
    found
}

fn solve_patch(
    line: &RayEquations,
    index: usize,
    patch: &ReferencePatch,
    thickness: f64,
    found: &mut IsolatedRoots,
) {
    let first = found.roots.len();
    let mut stack = vec![PatchCell::whole(line.project(patch, thickness))];
    let mut reusable = Vec::new();
    let mut count = 0;
    while let Some(mut cell) = stack.pop() {
        count += 1;
        let class = if count > MOST_CELLS { PatchCellClass::Hidden } else { cell.examine(patch.degrees) };
        let proof = match class {
            PatchCellClass::Excluded => CellProof::Nothing,
            PatchCellClass::Hidden => {
                let [u, v] = cell.sides();
                found.clusters.push(line.root_box(index, patch, u, v));
                CellProof::Nothing
            }
            PatchCellClass::Injective => cell.certify(patch.degrees),
            PatchCellClass::Open => CellProof::Unknown,
        };
        match proof {
            CellProof::Nothing => reusable.push(cell.coefficients),
            CellProof::Root([u, v]) => {
                let bounds = line.root_box(index, patch, u, v);
                let same = |(other, _): &(RootBox, DomainRelation)| {
                    other.u.overlaps(bounds.u) && other.v.overlaps(bounds.v)
                };
                if let Some(relation) = domain_relation(&bounds)
                    && !found.roots[first..].iter().any(same)
                {
                    found.roots.push((bounds, relation));
                }
                reusable.push(cell.coefficients);
            }
            CellProof::Unknown => {
                let high = cell.split(patch.degrees, reusable.pop().unwrap_or_default());
                stack.extend([cell, high]);
            }
        }
    }
    found.cells += count;
    found.given_up += usize::from(count > MOST_CELLS);
}

/// `None` if the box is certainly outside the domain.
fn domain_relation(bounds: &RootBox) -> Option<DomainRelation> {
    let unit = Interval { low: 0.0, high: 1.0 };
    let inside = |x: Interval| x.low > 0.0 && x.high < 1.0;
    if inside(bounds.u) && inside(bounds.v) {
        Some(DomainRelation::Inside)
    } else {
        (bounds.u.overlaps(unit) && bounds.v.overlaps(unit)).then_some(DomainRelation::Border)
    }
}
