//! Tessellation of Bézier patches, and its deviation from them.
//!
//! Every patch has its own grid of n x m cells of two triangles; the vertices are on the surface and have its normals. Points and
//! derivatives are computed from rows of Bernstein values that are tabulated per degree and number of cells.

use std::collections::HashMap;

use glanz_geometry::bezier::TensorPatch;
use glanz_geometry::freeform::SurfacePatch;
use glanz_geometry::trim::TrimRegion;
use glanz_math::DVec3;
use glanz_math::glam::DVec4;

/// Cells of a patch along u and along v.
pub(crate) type Cells = (usize, usize);

/// Largest number of cells along a side.
const MOST_CELLS: usize = 200;

/// Ratios of cells along u to cells along v that are tried, as powers of two.
const SHAPES: [f64; 5] = [0.0, 1.0, -1.0, 2.0, -2.0];

/// A mesh with normals at its vertices.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The largest deviations of a tessellation from its surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deviation {
    /// Distance of a point of a triangle from the surface, metres.
    pub(crate) chord: f64,
    /// Angle between the interpolated normal and that of the nearest point of the surface, degrees.
    pub(crate) normal: f64,
    /// The same for the triangle's own normal.
    pub(crate) facet: f64,
}

impl Deviation {
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            chord: self.chord.max(other.chord),
            normal: self.normal.max(other.normal),
            facet: self.facet.max(other.facet),
        }
    }

    /// Largest ratio to the bounds on chord and interpolated normal.
    fn excess(&self, bounds: &Self) -> f64 {
        (self.chord / bounds.chord).max(self.normal / bounds.normal)
    }
}

/// Values and derivatives of the Bernstein polynomials at one parameter.
#[derive(Clone, Debug)]
struct Row {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Row {
    fn at(degree: usize, t: f64) -> Self {
        let mut values = vec![1.0];
        let mut slopes = vec![0.0];
        for n in 1..=degree {
            if n == degree {
                let below = |i: usize| if i < n { values[i] } else { 0.0 };
                slopes =
                    (0..=n).map(|i| n as f64 * (if i > 0 { below(i - 1) } else { 0.0 } - below(i))).collect();
            }
            values.push(0.0);
            for i in (0..=n).rev() {
                let left = if i > 0 { values[i - 1] * t } else { 0.0 };
                values[i] = values[i] * (1.0 - t) + left;
            }
        }
        Self { values, slopes }
    }

    fn regular(degree: usize, cells: usize) -> Vec<Self> {
        (0..=cells).map(|i| Self::at(degree, i as f64 / cells as f64)).collect()
    }
}

/// A point of a patch and its derivatives.
#[derive(Clone, Copy)]
struct Frame {
    point: DVec3,
    by_u: DVec3,
    by_v: DVec3,
}

impl Frame {
    /// The unit normal; `None` if the derivatives are nearly parallel.
    fn normal(&self) -> Option<DVec3> {
        let n = self.by_u.cross(self.by_v);
        let flat = 1e-6 * self.by_u.length_squared().max(self.by_v.length_squared());
        (n.length() > flat).then(|| n.normalize())
    }
}

/// A patch along a line of constant u: the curve and its derivative by u.
struct Curve(Vec<[DVec4; 2]>);

impl Curve {
    fn new(patch: &TensorPatch, row: &Row) -> Self {
        let columns = patch.degrees().1 + 1;
        let mut curve = vec![[DVec4::ZERO; 2]; columns];
        for (points, (value, slope)) in
            patch.control_points().chunks_exact(columns).zip(row.values.iter().zip(&row.slopes))
        {
            for (sum, point) in curve.iter_mut().zip(points) {
                sum[0] += *point * *value;
                sum[1] += *point * *slope;
            }
        }
        Self(curve)
    }

    fn frame(&self, row: &Row) -> Frame {
        let (mut s, mut su, mut sv) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
        for (point, (value, slope)) in self.0.iter().zip(row.values.iter().zip(&row.slopes)) {
            s += point[0] * *value;
            sv += point[0] * *slope;
            su += point[1] * *value;
        }
        let point = s.truncate() / s.w;
        let tangent = |d: DVec4| (d.truncate() - point * d.w) / s.w;
        Frame { point, by_u: tangent(su), by_v: tangent(sv) }
    }
}

fn frame(patch: &TensorPatch, u: f64, v: f64) -> Frame {
    let (point, by_u, by_v) = patch.point_and_tangents(u, v);
    Frame { point, by_u, by_v }
}

/// The normal at (u, v); on a collapsed edge, that of a nearby point.
fn normal(patch: &TensorPatch, at: &Frame, u: f64, v: f64) -> DVec3 {
    let beside = || {
        let near = |x: f64| x + (0.5 - x) * 1e-4;
        frame(patch, near(u), near(v)).normal()
    };
    at.normal().or_else(beside).unwrap_or(DVec3::Z)
}

/// Rows of Bernstein values by degree and number of cells.
#[derive(Default)]
struct Table(HashMap<(usize, usize), Vec<Row>>);

impl Table {
    fn fill(&mut self, degree: usize, cells: usize) {
        self.0.entry((degree, cells)).or_insert_with(|| Row::regular(degree, cells));
    }

    fn get(&self, degree: usize, cells: usize) -> &[Row] {
        self.0.get(&(degree, cells)).map_or(&[], Vec::as_slice)
    }
}

/// The triangles of all patches, each with its number of cells. Triangles whose middle `region` does not keep are left out, and so
/// are those with a collapsed side.
pub(crate) fn tessellate(pieces: &[SurfacePatch], cells: &[Cells], region: Option<&TrimRegion>) -> Mesh {
    let mut table = Table::default();
    let vertices = cells.iter().map(|(n, m)| (n + 1) * (m + 1)).sum();
    let triangles = cells.iter().map(|(n, m)| 2 * n * m).sum();
    let mut mesh = Mesh {
        positions: Vec::with_capacity(vertices),
        normals: Vec::with_capacity(vertices),
        triangles: Vec::with_capacity(triangles),
    };
    for (piece, &(n, m)) in pieces.iter().zip(cells) {
        let patch = piece.patch();
        let (p, q) = patch.degrees();
        table.fill(p, n);
        table.fill(q, m);
        let first = mesh.positions.len() as u32;
        for (i, row) in table.get(p, n).iter().enumerate() {
            let curve = Curve::new(patch, row);
            for (j, row) in table.get(q, m).iter().enumerate() {
                let frame = curve.frame(row);
                let normal = normal(patch, &frame, i as f64 / n as f64, j as f64 / m as f64);
                mesh.positions.push(frame.point.as_vec3().to_array());
                mesh.normals.push(normal.as_vec3().to_array());
            }
        }
        let at = |i: usize, j: usize| first + (i * (m + 1) + j) as u32;
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let halves = [(2.0 / 3.0, at(i + 1, j)), (1.0 / 3.0, at(i, j + 1))];
            for (third, middle) in halves {
                let (x, y) = ((i as f64 + third) / n as f64, (j as f64 + 1.0 - third) / m as f64);
                let corners = [at(i, j), middle, at(i + 1, j + 1)];
                let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                let kept = || region.is_none_or(|region| region.contains(piece.parameters(x, y)));
                if a != b && b != c && c != a && kept() {
                    mesh.triangles.push(corners);
                }
            }
        }
    }
    mesh
}

/// The largest deviations of a patch in n x m cells, at the points of the triangles whose barycentric coordinates are multiples of
/// 1 / `fineness`, except for vertices. In a row of cells at most `look`, evenly distributed, and the last one are tested; the search
/// ends when `enough` returns true for the deviations so far.
pub(crate) fn deviation(
    patch: &TensorPatch,
    (n, m): Cells,
    fineness: usize,
    look: usize,
    enough: impl Fn(&Deviation) -> bool,
) -> Deviation {
    let (p, q) = patch.degrees();
    let (rows, columns) = (Row::regular(p, n), Row::regular(q, m));
    let corners: Vec<Vec<(DVec3, DVec3)>> = (rows.iter().enumerate())
        .map(|(i, row)| {
            let curve = Curve::new(patch, row);
            let vertex = |(j, row): (usize, &Row)| {
                let frame = curve.frame(row);
                (frame.point, normal(patch, &frame, i as f64 / n as f64, j as f64 / m as f64))
            };
            columns.iter().enumerate().map(vertex).collect()
        })
        .collect();
    let mut most = Deviation::default();
    let some = |n: usize| (0..n - 1).step_by(n.div_ceil(look)).chain([n - 1]);
    for (i, j) in some(n).flat_map(|i| some(m).map(move |j| (i, j))) {
        for middle in [(i + 1, j), (i, j + 1)] {
            let places = [(i, j), middle, (i + 1, j + 1)];
            let vertices = places.map(|(i, j)| corners[i][j]);
            let uv = places.map(|(i, j)| [i as f64 / n as f64, j as f64 / m as f64]);
            most = most.max(of_triangle(patch, &vertices, &uv, fineness));
        }
        if enough(&most) {
            break;
        }
    }
    most
}

fn of_triangle(
    patch: &TensorPatch,
    vertices: &[(DVec3, DVec3); 3],
    uv: &[[f64; 2]; 3],
    fineness: usize,
) -> Deviation {
    let [a, b, c] = vertices.map(|(point, _)| point);
    // Next to a collapsed edge there are slivers.
    let n = (b - a).cross(c - a);
    let flat = 1e-4 * (b - a).length_squared().max((c - a).length_squared());
    let facet = (n.length() > flat).then(|| n.normalize());
    let mut most = Deviation::default();
    for k in 0..=fineness {
        for l in 0..=fineness - k {
            let counts = [k, l, fineness - k - l];
            if counts.contains(&fineness) {
                continue;
            }
            let weights = counts.map(|count| count as f64 / fineness as f64);
            let mix = |f: &dyn Fn(usize) -> DVec3| (0..3).map(|i| f(i) * weights[i]).sum::<DVec3>();
            let point = mix(&|i| vertices[i].0);
            let smooth = mix(&|i| vertices[i].1).normalize_or_zero();
            let at = |axis: usize| (0..3).map(|i| uv[i][axis] * weights[i]).sum();
            let (foot, normal) = next_to(patch, point, at(0), at(1));
            let angle = |n: DVec3| n.cross(normal).length().atan2(n.dot(normal).abs()).to_degrees();
            most = most.max(Deviation {
                chord: point.distance(foot),
                normal: angle(smooth),
                facet: facet.map_or(0.0, angle),
            });
        }
    }
    most
}

/// The point of the surface nearest to `point`, and its normal, by the Gauss-Newton method from the nearby (u, v).
fn next_to(patch: &TensorPatch, point: DVec3, mut u: f64, mut v: f64) -> (DVec3, DVec3) {
    let mut at = frame(patch, u, v);
    for _ in 0..2 {
        let (r, a, b) = (point - at.point, at.by_u, at.by_v);
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let determinant = aa * bb - ab * ab;
        if determinant <= 1e-12 * (aa * bb) {
            break;
        }
        u = (u + (bb * r.dot(a) - ab * r.dot(b)) / determinant).clamp(0.0, 1.0);
        v = (v + (aa * r.dot(b) - ab * r.dot(a)) / determinant).clamp(0.0, 1.0);
        at = frame(patch, u, v);
    }
    (at.point, normal(patch, &at, u, v))
}

/// The smallest number of cells of a patch within `bounds` on chord and interpolated normal, over some ratios of cells.
pub(crate) fn fewest_cells(patch: &TensorPatch, bounds: &Deviation) -> Cells {
    let cells = |n: f64, shape: f64| {
        let (n, m) = (n * 2.0_f64.powf(0.5 * shape), n * 2.0_f64.powf(-0.5 * shape));
        let whole = |x: f64| (x.round() as usize).clamp(1, MOST_CELLS);
        (whole(n), whole(m))
    };
    let size = |(n, m): Cells| n * m;
    // The deviation falls with the square of the number of cells, so a few steps come close.
    let near = |shape: f64| {
        let excess = |n| deviation(patch, cells(n, shape), 2, 10, |_| false).excess(bounds);
        let step = |n: f64| (n * excess(n).sqrt()).clamp(0.5, 2.0 * MOST_CELLS as f64);
        step(step(step(6.0)))
    };
    let by_size = |a: &(f64, f64), b: &(f64, f64)| size(cells(a.0, a.1)).cmp(&size(cells(b.0, b.1)));
    let Some((mut n, shape)) = SHAPES.iter().map(|&shape| (near(shape), shape)).min_by(by_size) else {
        return (MOST_CELLS, MOST_CELLS);
    };
    let exceeds = |n: f64| {
        let beyond = |found: &Deviation| found.excess(bounds) > 1.0;
        beyond(&deviation(patch, cells(n, shape), 4, usize::MAX, beyond))
    };
    n *= 0.95;
    while exceeds(n) && cells(n, shape) != (MOST_CELLS, MOST_CELLS) {
        n += (0.02 * n).max(0.5);
    }
    cells(n, shape)
}
