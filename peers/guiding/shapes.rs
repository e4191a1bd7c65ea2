//! Tessellation of the shapes of a description.
//!
//! Every shape is evaluated over the unit square and divided into a grid. Splines are evaluated from their definition, not by
//! the code of Glanz, so that a fault of either is visible in the comparison.

use std::f64::consts::TAU;

use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{BezierPatchesDescription, GeometryDescription, NurbsDescription};

/// Numbers of cells around the axis of a quadric, along it, and along each side of a patch or knot span.
const AROUND: usize = 96;
const ALONG: usize = 32;
const SPAN: usize = 20;

/// Step of difference quotients, and distance from a collapsed edge at which its normal is evaluated; fractions of the domain.
const STEP: f64 = 1e-5;
const INWARD: f64 = 1e-3;

/// Triangles with normals at their corners.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The part `from` to `to` of a surface over the unit square as `cells` x `cells` cells. Normals follow dp/du x dp/dv.
    fn add(&mut self, surface: &dyn Fn(DVec2) -> DVec3, [from, to]: [DVec2; 2], cells: [usize; 2]) {
        let first = self.positions.len() as u32;
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let share = DVec2::new(i as f64 / cells[0] as f64, j as f64 / cells[1] as f64);
                let uv = from + (to - from) * share;
                self.positions.push(surface(uv));
                self.normals.push(normal(surface, uv));
            }
        }
        let row = cells[0] as u32 + 1;
        for j in 0..cells[1] as u32 {
            for i in 0..cells[0] as u32 {
                let a = first + j * row + i;
                self.triangles.extend([[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]);
            }
        }
    }

    /// Appends `other`, transformed by `to_world` and, if `reversed`, with reversed normals.
    pub(crate) fn append(&mut self, other: &Self, to_world: &DMat4, reversed: bool) {
        let first = self.positions.len() as u32;
        let normals = to_world.inverse().transpose();
        let side = if reversed { -1.0 } else { 1.0 };
        self.positions.extend(other.positions.iter().map(|&p| to_world.transform_point3(p)));
        self.normals
            .extend(other.normals.iter().map(|&n| side * normals.transform_vector3(n).normalize_or_zero()));
        // The orientation of triangles follows the normals of their corners, mirrored or not.
        let turned = (to_world.determinant() < 0.0) != reversed;
        self.triangles.extend(other.triangles.iter().filter_map(|&[a, b, c]| {
            let corners = if turned { [a, c, b] } else { [a, b, c] }.map(|i| i + first);
            let [p, q, r] = corners.map(|i| self.positions[i as usize]);
            // Cells next to a collapsed edge are single triangles.
            ((q - p).cross(r - p).length_squared() > 0.0).then_some(corners)
        }));
    }
}

fn normal(surface: &dyn Fn(DVec2) -> DVec3, uv: DVec2) -> DVec3 {
    let across = |uv: DVec2| {
        let slope = |axis: DVec2| {
            let (a, b) = ((uv - STEP * axis).max(DVec2::ZERO), (uv + STEP * axis).min(DVec2::ONE));
            (surface(b) - surface(a)) / (b - a).dot(axis)
        };
        let (du, dv) = (slope(DVec2::X), slope(DVec2::Y));
        let cross = du.cross(dv);
        // At a collapsed edge one derivative is only rounding.
        (du.length().min(dv.length()) > 1e-4 * du.length().max(dv.length()))
            .then(|| cross.normalize_or_zero())
    };
    let inside = |uv: DVec2| uv + INWARD * (DVec2::splat(0.5) - uv);
    across(uv).or_else(|| across(inside(uv))).unwrap_or_default()
}

const WHOLE: [DVec2; 2] = [DVec2::ZERO, DVec2::ONE];

/// A surface of revolution: radius and height at v, swept to `phi_max`.
fn swept(phi_max: f64, profile: impl Fn(f64) -> (f64, f64)) -> impl Fn(DVec2) -> DVec3 {
    move |uv| {
        let (sin, cos) = (phi_max * uv.x).sin_cos();
        let (r, z) = profile(uv.y);
        DVec3::new(r * cos, r * sin, z)
    }
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The triangles of a shape in its own frame, or the name of an unsupported feature.
pub(crate) fn mesh(geometry: &GeometryDescription) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    let mut quadric = |surface: &dyn Fn(DVec2) -> DVec3, along| mesh.add(surface, WHOLE, [AROUND, along]);
    match geometry {
        GeometryDescription::Sphere { radius, z, phi_max } => {
            let polar = z.map(|z| (z / radius).clamp(-1.0, 1.0).acos());
            let profile = |v| {
                let (sin, cos) = mix(polar[0], polar[1], v).sin_cos();
                (radius * sin, radius * cos)
            };
            quadric(&swept(*phi_max, profile), AROUND / 2);
        }
        GeometryDescription::Cylinder { radius, z, phi_max } => {
            quadric(&swept(*phi_max, |v| (*radius, mix(z[0], z[1], v))), 1);
        }
        GeometryDescription::Cone { radius, height, phi_max } => {
            quadric(&swept(*phi_max, |v| (mix(*radius, 0.0, v), mix(0.0, *height, v))), ALONG);
        }
        GeometryDescription::Paraboloid { radius, z, phi_max } => {
            // Equal steps of the radius, not of the height: the apex is round.
            let low = (z[0] / z[1]).sqrt();
            let profile = |v| (radius * mix(low, 1.0, v), z[1] * mix(low, 1.0, v).powi(2));
            quadric(&swept(*phi_max, profile), ALONG);
        }
        GeometryDescription::Disk { height, radius, inner_radius, phi_max } => {
            quadric(&swept(*phi_max, |v| (mix(*radius, *inner_radius, v), *height)), 1);
        }
        GeometryDescription::Torus { major_radius, minor_radius, phi_max } => {
            let profile =
                |v: f64| (major_radius + minor_radius * (TAU * v).cos(), minor_radius * (TAU * v).sin());
            quadric(&swept(*phi_max, profile), ALONG);
        }
        GeometryDescription::Cuboid { min, max } => cuboid(&mut mesh, *min, *max),
        GeometryDescription::Triangles { positions, indices, normals: None, .. } => {
            flat(&mut mesh, positions, indices);
        }
        GeometryDescription::Bilinear { .. } => return board(geometry, [1, 1]).map(|(even, _)| even),
        GeometryDescription::Nurbs(nurbs) => spline(&mut mesh, nurbs)?,
        GeometryDescription::BezierPatches(patches) => bezier(&mut mesh, patches),
        _ => return Err("a kind of shape that this program does not cut into triangles".into()),
    }
    Ok(mesh)
}

/// Triangles with flat normals.
fn flat(mesh: &mut Mesh, positions: &[DVec3], indices: &[[u32; 3]]) {
    for corners in indices {
        let [a, b, c] = corners.map(|i| positions[i as usize]);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([a, b, c]);
        mesh.normals.extend([(b - a).cross(c - a).normalize_or_zero(); 3]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
}

fn cuboid(mesh: &mut Mesh, min: DVec3, max: DVec3) {
    for axis in 0..3 {
        for (end, side) in [(0.0, -1.0), (1.0, 1.0)] {
            let face = |uv: DVec2| {
                // u and v are the two other axes, in the order for which the normal points outwards.
                let (u, v) = if side > 0.0 { (uv.x, uv.y) } else { (uv.y, uv.x) };
                let mut share = [0.0; 3];
                (share[axis], share[(axis + 1) % 3], share[(axis + 2) % 3]) = (end, u, v);
                min + (max - min) * DVec3::from_array(share)
            };
            mesh.add(&face, WHOLE, [1, 1]);
        }
    }
}

/// The even and the odd cells of a checkerboard on a bilinear patch, with the given numbers of cells along u and v.
pub(crate) fn board(geometry: &GeometryDescription, fields: [usize; 2]) -> Result<(Mesh, Mesh), String> {
    let GeometryDescription::Bilinear { positions, indices } = geometry else {
        return Err("a pattern on something other than a bilinear patch".into());
    };
    let (mut even, mut odd) = (Mesh::default(), Mesh::default());
    for corners in indices {
        let [a, b, c, d] = corners.map(|i| positions[i as usize]);
        let patch = |uv: DVec2| a.lerp(b, uv.x).lerp(c.lerp(d, uv.x), uv.y);
        let count = DVec2::new(fields[0] as f64, fields[1] as f64);
        for j in 0..fields[1] {
            for i in 0..fields[0] {
                let corner = DVec2::new(i as f64, j as f64);
                let mesh = if (i + j) % 2 == 0 { &mut even } else { &mut odd };
                mesh.add(&patch, [corner / count, (corner + DVec2::ONE) / count], [1, 1]);
            }
        }
    }
    Ok((even, odd))
}

fn projected(point: [f64; 4]) -> DVec3 {
    DVec3::new(point[0], point[1], point[2]) / point[3]
}

fn blend(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    std::array::from_fn(|i| mix(a[i], b[i], t))
}

/// De Casteljau's algorithm.
fn casteljau(mut points: Vec<[f64; 4]>, t: f64) -> [f64; 4] {
    while points.len() > 1 {
        points = points.windows(2).map(|pair| blend(pair[0], pair[1], t)).collect();
    }
    points[0]
}

fn bezier(mesh: &mut Mesh, description: &BezierPatchesDescription) {
    for points in &description.patches {
        let surface = |uv: DVec2| {
            let rows = points.chunks(description.degree_v + 1).map(|row| casteljau(row.to_vec(), uv.y));
            projected(casteljau(rows.collect(), uv.x))
        };
        mesh.add(&surface, WHOLE, [SPAN, SPAN]);
    }
}

/// De Boor's algorithm in the span between the knots `span` and `span + 1`.
fn boor(points: &[[f64; 4]], knots: &[f64], degree: usize, span: usize, t: f64) -> [f64; 4] {
    let mut d = points[span - degree..=span].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let (low, high) = (knots[span - degree + j], knots[span + 1 + j - r]);
            d[j] = blend(d[j - 1], d[j], (t - low) / (high - low));
        }
    }
    d[degree]
}

/// The nonempty knot spans of the domain.
fn spans(knots: &[f64], degree: usize) -> Vec<usize> {
    (degree..knots.len() - degree - 1).filter(|&i| knots[i] < knots[i + 1]).collect()
}

fn spline(mesh: &mut Mesh, nurbs: &NurbsDescription) -> Result<(), String> {
    if nurbs.domain.is_some() {
        return Err("a part of a spline surface".into());
    }
    let (knots_u, knots_v) = (&nurbs.knots_u, &nurbs.knots_v);
    let columns: Vec<_> = nurbs.points.chunks(knots_v.len() - nurbs.degree_v - 1).collect();
    for i in spans(knots_u, nurbs.degree_u) {
        for j in spans(knots_v, nurbs.degree_v) {
            let surface = |uv: DVec2| {
                let (u, v) = (mix(knots_u[i], knots_u[i + 1], uv.x), mix(knots_v[j], knots_v[j + 1], uv.y));
                let column: Vec<_> = columns.iter().map(|c| boor(c, knots_v, nurbs.degree_v, j, v)).collect();
                projected(boor(&column, knots_u, nurbs.degree_u, i, u))
            };
            mesh.add(&surface, WHOLE, [SPAN, SPAN]);
        }
    }
    Ok(())
}
