//! Solids of faces whose trimming curves agree with their edges up to a width.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glanz_math::{DMat4, DVec2, DVec3};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// Half side of the cube, radius and half height of the cylinder, metres.
pub(crate) const HALF: f64 = 0.5;

/// Half side of the surfaces that are trimmed.
pub(crate) const REACH: f64 = 0.7;

/// Numbers that depend on a seed.
pub(crate) struct Random {
    seed: u64,
    count: u64,
}

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, count: 0 }
    }

    /// From -1 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.count += 1;
        2.0 * unit_f64(combine(self.seed, self.count)) - 1.0
    }

    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    /// One of `count`.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        (0.5 * (self.next() + 1.0) * count as f64) as usize % count
    }
}

/// How trimming curves deviate from the edges, within their width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Deviation {
    None,
    /// Faces too small: slits.
    Inwards,
    /// Faces too large: overlaps.
    Outwards,
    /// Every point of a curve to another side.
    Random,
}

pub(crate) const DEVIATIONS: [Deviation; 4] =
    [Deviation::None, Deviation::Inwards, Deviation::Outwards, Deviation::Random];

impl Deviation {
    /// A deviation outwards of at most `most`.
    fn distance(self, most: f64, random: &mut Random) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Inwards => -most * random.next().abs(),
            Self::Outwards => most * random.next().abs(),
            Self::Random => most * random.next(),
        }
    }
}

/// A polyline of the given width through `points` about the middle of a square from -REACH to REACH.
pub(crate) fn polyline(points: &[DVec2], width: f64) -> TrimCurveDescription {
    let count = points.len() - 1;
    let inner = (0..=count).map(|i| i as f64);
    let knots = std::iter::once(0.0).chain(inner).chain([count as f64]).collect();
    let point = |p: &DVec2| [(p.x + REACH) / (2.0 * REACH), (p.y + REACH) / (2.0 * REACH), 1.0];
    TrimCurveDescription {
        degree: 1,
        knots,
        points: points.iter().map(point).collect(),
        width: Some(width),
        edge: None,
    }
}

/// The square from -HALF to HALF by four curves that deviate from its sides by less than `width`.
pub(crate) fn square(width: f64, deviation: Deviation, random: &mut Random) -> TrimDescription {
    let outwards = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];
    let mut corner = |k: usize| {
        let (a, b) = (outwards[(k + 3) % 4], outwards[k]);
        HALF * (a + b)
            + deviation.distance(0.6 * width, random) * a
            + deviation.distance(0.6 * width, random) * b
    };
    let corners: Vec<DVec2> = (0..4).map(&mut corner).collect();
    let mut curves = Vec::new();
    for k in 0..4 {
        let (start, end) = (corners[k], corners[(k + 1) % 4]);
        let mut points = vec![start];
        for i in 1..7 {
            let middle = start.lerp(end, f64::from(i) / 7.0);
            let side = HALF + deviation.distance(0.95 * width, random);
            points.push(middle + outwards[k] * (side - middle.dot(outwards[k])));
        }
        points.push(end);
        curves.push(polyline(&points, width));
    }
    metric(vec![TrimLoopDescription { curves }], DVec2::splat(2.0 * REACH))
}

pub(crate) fn metric(loops: Vec<TrimLoopDescription>, scale: DVec2) -> TrimDescription {
    TrimDescription { loops, scale: scale.to_array(), domain: Some([[0.0; 2], [1.0; 2]]) }
}

/// A disk of radius HALF by a polygon that deviates by less than `width`.
fn disk(width: f64, deviation: Deviation, random: &mut Random) -> TrimDescription {
    let count = 200;
    let mut points: Vec<DVec2> = (0..count)
        .map(|i| {
            let radius = HALF + deviation.distance(0.8 * width, random);
            radius * DVec2::from_angle(TAU * f64::from(i) / f64::from(count))
        })
        .collect();
    points.push(points[0]);
    // The middle of a chord is 6.2e-5 nearer to the centre.
    let curves = vec![polyline(&points, width + 7e-5)];
    metric(vec![TrimLoopDescription { curves }], DVec2::splat(2.0 * REACH))
}

/// The part from -HALF to HALF of a cylinder from -REACH to REACH, by curves that go once around and beyond the ends of u.
fn band(width: f64, deviation: Deviation, random: &mut Random) -> TrimDescription {
    let mut around = |outwards: f64| -> Vec<DVec2> {
        let v = |random: &mut Random| {
            0.5 + outwards * (HALF + deviation.distance(0.95 * width, random)) / (2.0 * REACH)
        };
        let heights: Vec<f64> = (0..40).map(|_| v(random)).collect();
        let point = |i: i32| DVec2::new(f64::from(i) / 40.0, heights[i.rem_euclid(40) as usize]);
        (-10..=50).map(point).collect()
    };
    let (low, mut high) = (around(-1.0), around(1.0));
    high.reverse();
    let curve = |points: &[DVec2], width| {
        let points: Vec<DVec2> = points.iter().map(|p| (2.0 * *p - 1.0) * REACH).collect();
        polyline(&points, width)
    };
    let ends = [[low[60], high[0]], [high[60], low[0]]];
    let curves = vec![curve(&low, width), curve(&ends[0], 0.0), curve(&high, width), curve(&ends[1], 0.0)];
    metric(vec![TrimLoopDescription { curves }], DVec2::new(TAU * HALF, 2.0 * REACH))
}

/// A square of half side REACH in the plane z = 0, as a plane or as a spline surface.
pub(crate) fn sheet(is_spline: bool) -> ShapeDescription {
    if !is_spline {
        return ShapeDescription::rectangle([-REACH, REACH], [-REACH, REACH]);
    }
    let at = |i: usize| (2.0 * i as f64 / 3.0 - 1.0) * REACH;
    let points = (0..16).map(|k| [at(k / 4), at(k % 4), 0.0, 1.0]).collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    GeometryDescription::Nurbs(NurbsDescription {
        degree_u: 3,
        degree_v: 3,
        knots_u: knots(),
        knots_v: knots(),
        points,
        domain: None,
    })
    .into()
}

/// A sheet moved along +z by HALF and turned to the side of the cube with this number.
pub(crate) fn side(shape: ShapeDescription, number: usize) -> ShapeDescription {
    let normal = DVec3::AXES[number / 2] * if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    let x = normal.any_orthonormal_vector();
    let map = glanz_math::DMat3::from_cols(x, normal.cross(x), normal);
    shape.translated([0.0, 0.0, HALF]).transformed(DMat4::from_mat3(map))
}

/// A cube and a cylinder, by the same faces with and without a number of their solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    Cube,
    SplineCube,
    Cylinder,
}

pub(crate) const FORMS: [Form; 3] = [Form::Cube, Form::SplineCube, Form::Cylinder];

impl Form {
    pub(crate) fn faces(self, width: f64, deviation: Deviation, seed: u64) -> Vec<ShapeDescription> {
        let random = &mut Random::new(seed);
        match self {
            Self::Cylinder => {
                let wall = ShapeDescription::cylinder(HALF, [-REACH, REACH]);
                let mut faces = vec![wall.trimmed(band(width, deviation, random))];
                faces.extend([4, 5].map(|k| side(sheet(false).trimmed(disk(width, deviation, random)), k)));
                faces
            }
            _ => (0..6)
                .map(|k| side(sheet(self == Self::SplineCube).trimmed(square(width, deviation, random)), k))
                .collect(),
        }
    }

    /// The solid, turned, in an instance.
    pub(crate) fn scene(self, width: f64, deviation: Deviation, seed: u64) -> Scene {
        self.placed(width, deviation, seed, to_world())
    }

    pub(crate) fn placed(self, width: f64, deviation: Deviation, seed: u64, to_world: DMat4) -> Scene {
        let faces = self.faces(width, deviation, seed).into_iter().map(|face| face.bounding(3));
        SceneBuilder::new()
            .group("solid", |group| group.shapes(faces, MaterialKind::diffuse(0.5)))
            .instance("solid", to_world)
            .resolve()
            .unwrap()
            .0
    }

    /// A point of an edge, or a vertex.
    pub(crate) fn edge_point(self, random: &mut Random) -> DVec3 {
        match self {
            Self::Cylinder => {
                let around = DVec2::from_angle(TAU * random.next()) * HALF;
                around.extend(HALF * random.next().signum())
            }
            _ => {
                let mut p = HALF * random.vector().signum();
                if random.next() < 0.5 {
                    p[random.index(3)] = HALF * random.next();
                }
                p
            }
        }
    }

    /// A point inside, away from the border.
    pub(crate) fn inner_point(self, random: &mut Random) -> DVec3 {
        let p = HALF * 0.95 * random.vector();
        if self == Self::Cylinder { p * DVec3::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2, 1.0) } else { p }
    }
}

pub(crate) fn to_world() -> DMat4 {
    DMat4::from_translation(DVec3::new(3.0, -2.0, 1.0))
        * DMat4::from_axis_angle(DVec3::new(0.48, 0.6, 0.64), 0.9)
}
