//! A bicubic patch projected along a ray: two polynomials, whose common zeros are the roots.
//!
//! Newton's method from a good start is enough for most rays. At silhouettes, borders and strongly curved leaves,
//! [`ProjectedBicubic::divide`] multiplies by the inverse Jacobian of the centre, so that the polynomials become (s, t)
//! plus a remainder, bounds the remainder by the sum of its coefficients, and halves until the bound excludes the cell or
//! certifies that it has one root at most.

use glanz_math::DVec2;

use super::contraction::{Certificate, LocalRoot, MapBounds, NoConvergence, PlanarJet, PlanarMap, contract};
use super::parameter_rect::DyadicRect;
use super::ray_space::cross;
use crate::bvh::simd::Simd;

/// Largest bound on the change of the Jacobian, relative to that at the centre, at which a cell is certified.
const CERTIFIED: f64 = 0.85;

/// Largest shift by rounding of the root of a certified cell, as a fraction of half the cell.
const MOST_UNCERTAINTY: f64 = 0.0625;

/// Largest number of steps of Newton's method from a good start.
pub(super) const MAX_NEWTON_STEPS: usize = 6;

/// Steps in a certified cell. Cells that contract too slowly for that are left to `subdivision`.
pub(super) const MOST_STEPS: usize = 24;

/// Largest number of halvings. Tangencies need more, and are left to `subdivision`.
const MOST_HALVINGS: usize = 12;

/// Largest number of cells, for the same reason.
const MOST_CELLS: usize = 64;

/// Two polynomials in (s, t), in [-1, 1]^2: coefficients by power of s, with those of the powers of t in the lanes.
#[derive(Clone, Copy)]
pub(super) struct ProjectedBicubic<S: Simd> {
    pub(super) first: [S::F64; 4],
    pub(super) second: [S::F64; 4],
}

/// A part of the square, with its own (s, t) in [-1, 1]^2.
#[derive(Clone, Copy)]
struct BicubicCell<S: Simd> {
    polynomials: ProjectedBicubic<S>,
    middle: DVec2,
    half: DVec2,
    halvings: usize,
}

/// Result of a test of a cell for roots.
enum BicubicCellClass {
    /// No root.
    Excluded,
    /// One at most; the iteration begins at `start`.
    Certified { certificate: Certificate, start: DVec2 },
    /// Unknown.
    Open,
}

/// The end of a few steps of Newton's method.
pub(super) enum NewtonExit {
    /// The only root.
    Converged(DVec2),
    /// A step left the part, from this point with this jet.
    Left { at: DVec2, jet: PlanarJet },
    /// The steps did not converge.
    Open,
}

/// Values and derivatives of four cubics.
#[inline(always)]
fn horner<S: Simd>(simd: S, [a, b, c, d]: &[S::F64; 4], x: S::F64) -> (S::F64, S::F64) {
    // In pairs, which has a shorter chain of dependent operations than Horner's rule.
    let square = simd.mul64(x, x);
    let (low, high) = (simd.mul_add64(*b, x, *a), simd.mul_add64(*d, x, *c));
    let (double, triple) = (simd.add64(x, x), simd.mul64(simd.splat64(3.0), square));
    (simd.mul_add64(high, square, low), simd.mul_add64(*d, triple, simd.mul_add64(*c, double, *b)))
}

/// The polynomial with these coefficients at (s, t).
#[inline(always)]
pub(super) fn value<S: Simd>(simd: S, rows: &[S::F64; 4], at: DVec2) -> f64 {
    let s = simd.splat64(at.x);
    let sum = simd.mul_add64(rows[3], s, rows[2]);
    let sum = simd.mul_add64(sum, s, rows[1]);
    let [a, b, c, d] = simd.store64(simd.mul_add64(sum, s, rows[0]));
    d.mul_add(at.y, c).mul_add(at.y, b).mul_add(at.y, a)
}

/// The cubics at m + h x, as powers of x.
#[inline(always)]
fn moved<S: Simd>(simd: S, [a, b, c, d]: [S::F64; 4], m: f64, h: f64) -> [S::F64; 4] {
    let (at, first, second, third) =
        (simd.splat64(m), simd.splat64(h), simd.splat64(h * h), simd.splat64(h * h * h));
    // Taylor coefficients at m by repeated division.
    let c1 = simd.mul_add64(d, at, c);
    let b1 = simd.mul_add64(c1, at, b);
    let a1 = simd.mul_add64(b1, at, a);
    let c2 = simd.mul_add64(d, at, c1);
    let b2 = simd.mul_add64(c2, at, b1);
    let c3 = simd.mul_add64(d, at, c2);
    [a1, simd.mul64(b2, first), simd.mul64(c3, second), simd.mul64(d, third)]
}

impl<S: Simd> ProjectedBicubic<S> {
    #[inline(always)]
    fn jet(&self, simd: S, at: DVec2) -> PlanarJet {
        let (f, fs) = horner(simd, &self.first, simd.splat64(at.x));
        let (g, gs) = horner(simd, &self.second, simd.splat64(at.x));
        let by_t = simd.transpose64([f, fs, g, gs]);
        let (value, rise) = horner(simd, &by_t, simd.splat64(at.y));
        let ([f, fs, g, gs], [ft, _, gt, _]) = (simd.store64(value), simd.store64(rise));
        PlanarJet { f: DVec2::new(f, g), fs: DVec2::new(fs, gs), ft: DVec2::new(ft, gt) }
    }

    /// The root in a certified part of the square, by a few steps of Newton's method from `start`, the intersection of the
    /// ray with the parallelogram.
    #[inline(always)]
    pub(super) fn newton(&self, simd: S, start: DVec2, part: DyadicRect, bounds: &MapBounds) -> NewtonExit {
        let (middle, half) = (part.middle(), part.width());
        let (low, high) = (middle - half, middle + half);
        let mut x = middle + half * start.clamp(DVec2::NEG_ONE, DVec2::ONE);
        // Two steps are needed most often; there is no branch between them, so that none is mispredicted. A first step
        // that leads outside is clamped, and then is as good as any start. NaN becomes a corner.
        x = (x - self.jet(simd, x).newton_step()).clamp(low, high);
        for _ in 0..MAX_NEWTON_STEPS {
            let jet = self.jet(simd, x);
            let step = jet.newton_step();
            let next = x - step;
            // NaN is not inside.
            let inside = next.cmpge(low).all() && next.cmple(high).all();
            if !inside {
                return NewtonExit::Left { at: x, jet };
            }
            // After a step whose error by curvature is below rounding, no evaluation is needed.
            if bounds.end_with(step, half, &jet) {
                return NewtonExit::Converged(next);
            }
            x = next;
        }
        NewtonExit::Open
    }

    /// The polynomials over a part of the square, in the coordinates of that part.
    #[inline(always)]
    pub(super) fn part(&self, simd: S, middle: DVec2, half: DVec2) -> Self {
        self.moved(simd, true, middle.x, half.x).moved(simd, false, middle.y, half.y)
    }

    /// The polynomials at m + h x instead of x, for s or for t.
    #[inline(always)]
    fn moved(&self, simd: S, along_s: bool, m: f64, h: f64) -> Self {
        let Self { first, second } = *self;
        if along_s {
            return Self { first: moved(simd, first, m, h), second: moved(simd, second, m, h) };
        }
        let first = moved(simd, simd.transpose64(first), m, h);
        let second = moved(simd, simd.transpose64(second), m, h);
        Self { first: simd.transpose64(first), second: simd.transpose64(second) }
    }

    /// Whether both polynomials are zero on one of the edges, to within `noise`.
    #[inline(always)]
    fn vanishes_on_an_edge(&self, simd: S, noise: f64) -> bool {
        let [a, b] = edge_sizes(simd, self.first);
        let [c, d] = edge_sizes(simd, self.second);
        let [e, f] = edge_sizes(simd, simd.transpose64(self.first));
        let [g, h] = edge_sizes(simd, simd.transpose64(self.second));
        a.max(c).min(b.max(d)).min(e.max(g)).min(f.max(h)) <= noise
    }

    /// Appends every root in the square to `found`, those on the border of two cells possibly twice. `weight` is the
    /// weight of the surface at a point.
    #[inline(always)]
    pub(super) fn divide(
        &self,
        simd: S,
        bounds: &MapBounds,
        weight: &impl Fn(DVec2) -> f64,
        found: &mut Vec<LocalRoot>,
    ) -> Result<(), NoConvergence> {
        let mut stack: [Option<BicubicCell<S>>; MOST_HALVINGS] = [None; MOST_HALVINGS];
        let mut height = 0;
        let mut cell = BicubicCell { polynomials: *self, middle: DVec2::ZERO, half: DVec2::ONE, halvings: 0 };
        for _ in 0..MOST_CELLS {
            match cell.verdict(simd, bounds) {
                BicubicCellClass::Excluded => {}
                BicubicCellClass::Certified { certificate, start } => {
                    let mut map = BicubicCellMap { simd, cell: &cell, weight };
                    let bounds = MapBounds {
                        curvature_bound: bounds.curvature_bound * cell.half.max_element().powi(2),
                        ..*bounds
                    };
                    if let Some(LocalRoot { at, uncertainty }) =
                        contract(&mut map, &certificate, &bounds, start)?
                    {
                        found.push(LocalRoot {
                            at: cell.middle + cell.half * at,
                            uncertainty: cell.half * uncertainty,
                        });
                    }
                }
                BicubicCellClass::Open => {
                    // Halves of an edge that is one point, or along the ray, are as hard as the whole.
                    if cell.halvings == 0 && self.vanishes_on_an_edge(simd, bounds.noise * bounds.weights[1])
                    {
                        return Err(NoConvergence);
                    }
                    let Some(slot) = stack.get_mut(height).filter(|_| cell.halvings < MOST_HALVINGS) else {
                        return Err(NoConvergence);
                    };
                    let across_s = cell.varies_along_s(simd);
                    *slot = Some(cell.halve(simd, across_s, true));
                    height += 1;
                    cell = cell.halve(simd, across_s, false);
                    continue;
                }
            }
            let Some(next) = height.checked_sub(1).and_then(|top| stack.get(top)).copied().flatten() else {
                return Ok(());
            };
            height -= 1;
            cell = next;
        }
        Err(NoConvergence)
    }
}

/// Bounds on a polynomial on the edges s = -1 and s = 1: the sums of the coefficients of the powers of t.
#[inline(always)]
fn edge_sizes<S: Simd>(simd: S, [a, b, c, d]: [S::F64; 4]) -> [f64; 2] {
    let (even, odd) = (simd.add64(a, c), simd.add64(b, d));
    let minus = simd.store64(simd.abs64(simd.sub64(even, odd)));
    let plus = simd.store64(simd.abs64(simd.add64(even, odd)));
    [minus.iter().sum(), plus.iter().sum()]
}

/// Coefficients of higher order than one, and the orders of all of them: the sums of the derivatives by s and t have these
/// factors.
const HIGHER: [[f64; 4]; 4] = [[0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0], [1.0; 4], [1.0; 4]];
const ORDERS: [[f64; 4]; 4] =
    [[0.0, 0.0, 2.0, 3.0], [0.0, 2.0, 3.0, 4.0], [2.0, 3.0, 4.0, 5.0], [3.0, 4.0, 5.0, 6.0]];

/// Sums of the absolute values of coefficients by weights, lane by lane.
#[inline(always)]
fn weighted<S: Simd>(simd: S, rows: &[S::F64; 4], weights: &[[f64; 4]; 4]) -> S::F64 {
    let [a, b, c, d] = weights;
    let sum = simd.mul64(simd.abs64(rows[0]), simd.load64(a));
    let sum = simd.mul_add64(simd.abs64(rows[1]), simd.load64(b), sum);
    let sum = simd.mul_add64(simd.abs64(rows[2]), simd.load64(c), sum);
    simd.mul_add64(simd.abs64(rows[3]), simd.load64(d), sum)
}

impl<S: Simd> BicubicCell<S> {
    #[inline(always)]
    fn halve(&self, simd: S, across_s: bool, upper: bool) -> Self {
        let mut cell = *self;
        let side = if upper { 0.5 } else { -0.5 };
        let (middle, half) = if across_s {
            (&mut cell.middle.x, &mut cell.half.x)
        } else {
            (&mut cell.middle.y, &mut cell.half.y)
        };
        *middle += side * *half;
        *half *= 0.5;
        cell.polynomials = self.polynomials.moved(simd, across_s, side, 0.5);
        cell.halvings += 1;
        cell
    }

    /// Whether the polynomials vary more along s than along t, so that projected cells become as wide as long.
    #[inline(always)]
    fn varies_along_s(&self, simd: S) -> bool {
        let ProjectedBicubic { first, second } = &self.polynomials;
        let (p0, p1, p2) = (simd.store64(first[0]), simd.store64(first[1]), simd.store64(first[2]));
        let (q0, q1, q2) = (simd.store64(second[0]), simd.store64(second[1]), simd.store64(second[2]));
        let size = |p: f64, q: f64| DVec2::new(p, q).length();
        let twist = size(p1[1], q1[1]);
        let along_s = size(p1[0], q1[0]) + 2.0 * size(p2[0], q2[0]) + twist;
        let along_t = size(p0[1], q0[1]) + 2.0 * size(p0[2], q0[2]) + twist;
        if along_s == along_t { self.halvings.is_multiple_of(2) } else { along_s > along_t }
    }

    #[inline(always)]
    fn verdict(&self, simd: S, bounds: &MapBounds) -> BicubicCellClass {
        let ProjectedBicubic { first, second } = &self.polynomials;
        let noise = bounds.noise * bounds.weights[1];
        let (p0, p1) = (simd.store64(first[0]), simd.store64(first[1]));
        let (q0, q1) = (simd.store64(second[0]), simd.store64(second[1]));
        let (c, a, b) = (DVec2::new(p0[0], q0[0]), DVec2::new(p1[0], q1[0]), DVec2::new(p0[1], q0[1]));
        let det = cross(a, b);
        // Rows of J^-1 times det: u goes with s, v with t.
        let across_b = combined(simd, first, second, DVec2::new(b.y, -b.x));
        let across_a = combined(simd, first, second, DVec2::new(-a.y, a.x));
        let sums = simd.transpose64([
            weighted(simd, &across_b, &HIGHER),
            weighted(simd, &across_b, &ORDERS),
            weighted(simd, &across_a, &HIGHER),
            weighted(simd, &across_a, &ORDERS),
        ]);
        let total = simd.add64(simd.add64(sums[0], sums[1]), simd.add64(sums[2], sums[3]));
        let [rest_u, slope_u, rest_v, slope_v] = simd.store64(total);
        let size = det.abs();
        let (a_length, b_length) = (a.length(), b.length());
        let flat = DVec2::new(-cross(c, b), -cross(a, c));
        if flat.x.abs() > size + rest_u + 1.5 * noise * b_length
            || flat.y.abs() > size + rest_v + 1.5 * noise * a_length
        {
            return BicubicCellClass::Excluded;
        }
        let slope = slope_u.max(slope_v);
        // If rounding may move the root by more than a part of the cell, it is next to a tangency.
        let clear = noise * a_length.max(b_length) <= MOST_UNCERTAINTY * size;
        if clear && slope < CERTIFIED * size {
            return BicubicCellClass::Certified {
                certificate: Certificate { a, b, q: slope / size },
                start: flat / det,
            };
        }
        BicubicCellClass::Open
    }
}

/// A cell as a map for [`contract`].
struct BicubicCellMap<'a, S: Simd, W> {
    simd: S,
    cell: &'a BicubicCell<S>,
    weight: &'a W,
}

impl<S: Simd, W: Fn(DVec2) -> f64> PlanarMap for BicubicCellMap<'_, S, W> {
    #[inline(always)]
    fn jet(&mut self, x: DVec2) -> PlanarJet {
        self.cell.polynomials.jet(self.simd, x)
    }

    #[inline(always)]
    fn weight(&self, x: DVec2) -> f64 {
        (self.weight)(self.cell.middle + self.cell.half * x)
    }
}

/// The polynomial `by.x` first + `by.y` second.
#[inline(always)]
fn combined<S: Simd>(simd: S, first: &[S::F64; 4], second: &[S::F64; 4], by: DVec2) -> [S::F64; 4] {
    let (x, y) = (simd.splat64(by.x), simd.splat64(by.y));
    let sum =
        [simd.mul64(first[0], x), simd.mul64(first[1], x), simd.mul64(first[2], x), simd.mul64(first[3], x)];
    [
        simd.mul_add64(second[0], y, sum[0]),
        simd.mul_add64(second[1], y, sum[1]),
        simd.mul_add64(second[2], y, sum[2]),
        simd.mul_add64(second[3], y, sum[3]),
    ]
}
