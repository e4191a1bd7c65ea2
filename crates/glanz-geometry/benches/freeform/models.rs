//! Freeform surfaces for measurements, shared with `peers/freeform`. All of them are computed, but for the teapot.

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use glanz_geometry::Surface;
use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_geometry::trim::{TrimCurve, TrimLoop, TrimRegion};
use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

/// An error of building a model.
pub(crate) type Failure = Box<dyn std::error::Error>;

/// Names that [`Model::named`] knows.
pub(crate) const NAMES: [&str; 18] = [
    "bicubic",
    "teapot",
    "rational bicubic",
    "torus",
    "ball",
    "degree 2",
    "degree 4",
    "degree 5",
    "degree 6",
    "degree 7",
    "degree 8",
    "degree 9",
    "rational degree 5",
    "cubic triangles",
    "quintic triangles",
    "trimmed",
    "rational trimmed",
    "10 000 patches",
];

/// The definition of a surface, before anything is built for rays.
pub(crate) enum Source {
    Spline(NurbsSurface),
    Patches(Vec<TensorPatch>),
    Triangles(Vec<TrianglePatch>),
}

/// A surface by its control points.
pub(crate) struct Model {
    pub(crate) source: Source,
    /// The region of the parameters that is kept.
    pub(crate) region: Option<Arc<TrimRegion>>,
}

impl Source {
    /// The Bézier patches.
    pub(crate) fn pieces(&self) -> Result<Vec<SurfacePatch>, Failure> {
        let unit = [0.0, 1.0];
        match self {
            Self::Spline(spline) => spline
                .bezier_patches()?
                .into_iter()
                .map(|p| Ok(SurfacePatch::over_rectangle(p.patch, p.u, p.v)?))
                .collect(),
            Self::Patches(patches) => {
                patches.iter().map(|p| Ok(SurfacePatch::over_rectangle(p.clone(), unit, unit)?)).collect()
            }
            Self::Triangles(patches) => patches
                .iter()
                .flat_map(TrianglePatch::to_quads)
                .map(|quad| Ok(SurfacePatch::over_quad(quad.patch, quad.corners)?))
                .collect(),
        }
    }
}

impl Model {
    /// The model of one of [`NAMES`], or of any square number of patches.
    pub(crate) fn named(name: &str) -> Result<Self, Failure> {
        let source = match name {
            "bicubic" | "trimmed" => Source::Spline(wavy(3, 5, 0.15, |_, _| 1.0)?),
            "rational bicubic" | "rational trimmed" => Source::Spline(wavy(3, 5, 0.15, uneven)?),
            "rational degree 5" => Source::Spline(wavy(5, 5, 0.15, uneven)?),
            "teapot" => Source::Patches(newell(include_str!("../../../../scenes/newell_teapot.txt"))?),
            "torus" => Source::Spline(torus(1.0, 0.4)?),
            "ball" => Source::Spline(ball()?),
            "cubic triangles" => Source::Triangles(triangles(3, 5)?),
            "quintic triangles" => Source::Triangles(triangles(5, 5)?),
            _ => match (name.strip_prefix("degree "), name.strip_suffix(" patches")) {
                (Some(degree), _) => Source::Spline(wavy(degree.parse()?, 5, 0.15, |_, _| 1.0)?),
                (_, Some(count)) => Source::Spline(hills(side(count.replace(' ', "").parse()?)?)?),
                _ => return Err(format!("there is no model {name}").into()),
            },
        };
        let region = if name.ends_with("trimmed") { Some(Arc::new(plate()?)) } else { None };
        Ok(Self { source, region })
    }

    /// The surface for rays.
    pub(crate) fn surface(&self) -> Result<Surface, Failure> {
        let freeform = Surface::from(Freeform::try_new(self.source.pieces()?)?);
        Ok(match &self.region {
            Some(region) => freeform.trimmed(region.clone()),
            None => freeform,
        })
    }
}

/// The square root of a square number.
fn side(square: usize) -> Result<usize, Failure> {
    let side = square.isqrt();
    if side * side != square {
        return Err(format!(
            "{square} is not a square number of patches; choose {} or {}",
            side * side,
            (side + 1).pow(2)
        )
        .into());
    }
    Ok(side)
}

/// Weights from 0.7 to 1.3.
fn uneven(i: usize, j: usize) -> f64 {
    1.0 + 0.3 * ((13 * i + 7 * j) as f64).sin()
}

/// `spans` x `spans` patches over the unit square around the origin, with waves in z.
fn wavy(
    degree: usize,
    spans: usize,
    height: f64,
    weight: impl Fn(usize, usize) -> f64,
) -> Result<NurbsSurface, Failure> {
    let count = spans + degree;
    let knots = KnotVector::clamped_uniform(degree, count)?;
    let last = (count - 1) as f64;
    let points = grid(count).map(|(i, j)| {
        let (x, y) = (i as f64 / last, j as f64 / last);
        let z = height * (9.0 * x).sin() * (7.0 * y + 0.5).cos();
        DVec3::new(x - 0.5, y - 0.5, z).extend(1.0) * weight(i, j)
    });
    Ok(NurbsSurface::from_knots(knots.clone(), knots, points.collect())?)
}

/// Bicubic hills of three sizes, `spans` x `spans` patches.
fn hills(spans: usize) -> Result<NurbsSurface, Failure> {
    let knots = KnotVector::clamped_uniform(3, spans + 3)?;
    let last = (spans + 2) as f64;
    let points = grid(spans + 3).map(|(i, j)| {
        let (x, y) = (i as f64 / last, j as f64 / last);
        let octave = |f: f64, a: f64| a * (f * x + 0.3 * a * f).sin() * (0.8 * f * y + 1.0).cos();
        DVec4::new(x - 0.5, y - 0.5, octave(9.0, 0.08) + octave(31.0, 0.02) + octave(101.0, 0.006), 1.0)
    });
    Ok(NurbsSurface::from_knots(knots.clone(), knots, points.collect())?)
}

fn grid(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (0..count).map(move |j| (i, j)))
}

/// Points and weights of the unit circle as four quarters.
const CIRCLE: [(f64, f64, f64); 9] = [
    (1.0, 0.0, 1.0),
    (1.0, 1.0, FRAC_1_SQRT_2),
    (0.0, 1.0, 1.0),
    (-1.0, 1.0, FRAC_1_SQRT_2),
    (-1.0, 0.0, 1.0),
    (-1.0, -1.0, FRAC_1_SQRT_2),
    (0.0, -1.0, 1.0),
    (1.0, -1.0, FRAC_1_SQRT_2),
    (1.0, 0.0, 1.0),
];

const CIRCLE_KNOTS: [f64; 12] = [0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0];

/// The profile of points (distance from the axis, height, weight) turned about z.
fn turned(profile: &[(f64, f64, f64)], knots: Vec<f64>) -> Result<NurbsSurface, Failure> {
    let points = CIRCLE.iter().flat_map(|&(x, y, w)| {
        profile.iter().map(move |&(r, z, v)| DVec3::new(r * x, r * y, z).extend(1.0) * (w * v))
    });
    Ok(NurbsSurface::try_new([2, 2], [CIRCLE_KNOTS.to_vec(), knots], points.collect())?)
}

/// 16 rational biquadratic patches.
fn torus(major: f64, minor: f64) -> Result<NurbsSurface, Failure> {
    let profile = CIRCLE.map(|(x, y, w)| (major + minor * x, minor * y, w));
    turned(&profile, CIRCLE_KNOTS.to_vec())
}

/// The unit sphere as 8 rational biquadratic patches, each with an edge that is a pole.
fn ball() -> Result<NurbsSurface, Failure> {
    let w = FRAC_1_SQRT_2;
    let half = [(0.0, -1.0, 1.0), (1.0, -1.0, w), (1.0, 0.0, 1.0), (1.0, 1.0, w), (0.0, 1.0, 1.0)];
    turned(&half, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])
}

/// 2 x `cells` x `cells` triangular patches, continuous but with edges; control points over a regular net.
fn triangles(degree: usize, cells: usize) -> Result<Vec<TrianglePatch>, Failure> {
    let point = |p: DVec2| {
        let z = 0.15 * (9.0 * p.x).sin() * (7.0 * p.y + 0.5).cos();
        DVec4::new(p.x - 0.5, p.y - 0.5, z, 1.0)
    };
    let patch = |[a, b, c]: [DVec2; 3]| {
        // Rows of equal j + k, k ascending.
        let net = (0..=degree).flat_map(|row| (0..=row).map(move |k| (degree - row, row - k, k)));
        let at = net.map(|(i, j, k)| (a * i as f64 + b * j as f64 + c * k as f64) / degree as f64);
        TrianglePatch::try_new(degree, at.map(point).collect())
    };
    let corner = |i: usize, j: usize| DVec2::new(i as f64, j as f64) / cells as f64;
    let both = grid(cells).flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        [[a, b, d], [a, d, c]]
    });
    Ok(both.map(patch).collect::<Result<_, _>>()?)
}

/// Centre and radius of 4 x 3 round holes in the unit square.
pub(crate) fn holes() -> impl Iterator<Item = (DVec2, f64)> {
    let center = |i: usize, j: usize| DVec2::new((i as f64 + 0.5) / 4.0, (j as f64 + 0.5) / 3.0);
    (0..4).flat_map(move |i| (0..3).map(move |j| (center(i, j), 0.07)))
}

/// The unit square without the holes.
fn plate() -> Result<TrimRegion, Failure> {
    let mut loops = vec![TrimLoop::try_closed(TrimCurve::try_rectangle(DVec2::ZERO, DVec2::ONE)?, 1e-12)?];
    for (center, radius) in holes() {
        loops.push(TrimLoop::try_closed(TrimCurve::try_circle(center, radius)?.reversed(), 1e-12)?);
    }
    Ok(TrimRegion::try_new(loops, [DVec2::ZERO, DVec2::ONE])?)
}

/// A list of bicubic patches in Newell's form: their number, 16 indices each, the number of points, the points.
fn newell(text: &str) -> Result<Vec<TensorPatch>, Failure> {
    let mut words = text.split([',', ' ', '\n', '\r', '\t']).filter(|word| !word.is_empty());
    let mut word = || words.next().ok_or("the list of patches ends too early");
    let count: usize = word()?.parse()?;
    let indices = (0..16 * count).map(|_| Ok(word()?.parse()?)).collect::<Result<Vec<usize>, Failure>>()?;
    let count: usize = word()?.parse()?;
    let coordinates = (0..3 * count).map(|_| Ok(word()?.parse()?)).collect::<Result<Vec<f64>, Failure>>()?;
    let point = |&index: &usize| {
        let start = 3 * index.checked_sub(1)?;
        Some(DVec3::from_slice(coordinates.get(start..start + 3)?).extend(1.0))
    };
    let patch = |indices: &[usize]| {
        let points = indices.iter().map(point).collect::<Option<Vec<_>>>().ok_or("no such control point")?;
        Ok(TensorPatch::try_new(3, 3, points)?)
    };
    indices.chunks_exact(16).map(patch).collect()
}
