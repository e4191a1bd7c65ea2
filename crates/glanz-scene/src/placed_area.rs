//! Areas of placed surfaces, also of trimmed ones.

use std::ops::Range;

use glanz_geometry::trim::Containment;
use glanz_geometry::{FaceDomain, Surface};
use glanz_math::DVec2;
use glanz_math::rounding::gamma;
use glanz_sampling::basis::GaussLegendre;

use crate::area::{closed_form, polygon_area};
use crate::placed::PlacedSurface;

/// Smallest number of squares that a surface is divided into, apart from what a region cuts away.
const FEWEST_CELLS: u32 = 256;

/// Largest number of squares tested: those on the border of a region are quartered up to then.
const MOST_CELLS: usize = 1 << 14;

/// Quadrature nodes along each side of a square, and points along each side of one that a border crosses.
const NODES: usize = 4;

/// A square in the parameters of a face.
#[derive(Clone, Copy)]
struct FaceSquare {
    face: u32,
    low: DVec2,
    side: f64,
}

impl PlacedSurface<'_> {
    /// Area of some faces in the world, m^2, with a relative error of about 1e-6, of 1e-3 if the surface is trimmed; closed forms are exact.
    /// `None` if it is infinite or has no parameters.
    ///
    /// A triangle of a trimmed mesh counts if its middle is kept.
    #[must_use]
    pub fn area(&self, faces: Range<u32>) -> Option<f64> {
        let surface = self.surface();
        let whole = faces == (0..self.faces());
        if faces.is_empty() || faces.end > self.faces() {
            return None;
        }
        let scale = self.to_world().uniform_scale(gamma(64));
        let closed = scale.and_then(|scale| Some(scale * scale * closed_form(surface)?));
        let area = closed.filter(|_| whole).unwrap_or_else(|| self.integrated(faces));
        (area >= 0.0 && area.is_finite()).then_some(area)
    }

    fn integrated(&self, faces: Range<u32>) -> f64 {
        let area_element =
            |face: u32, uv: DVec2| self.at(face, uv, false).map_or(0.0, |found| found.area_element);
        let (mut area, mut open) = (0.0, Vec::new());
        for face in faces {
            match self.face_domain(face) {
                // These are flat: the area element is the same everywhere.
                FaceDomain::Polygon(corners) => {
                    let middle = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
                    area += polygon_area(&corners) * area_element(face, middle);
                }
                FaceDomain::Square => open.push(FaceSquare { face, low: DVec2::ZERO, side: 1.0 }),
            }
        }
        let smallest = (open.len() as f64 / f64::from(FEWEST_CELLS)).sqrt().clamp(1.0 / 16.0, 1.0);
        let (rule, mut tested) = (GaussLegendre::new(NODES), open.len());
        // Level by level, so that squares of one size are left when the budget is used up.
        while !open.is_empty() {
            let mut next = Vec::new();
            for square in open {
                let FaceSquare { face, low, side } = square;
                let state = self.state(&square);
                let divide = side > smallest || (state == Containment::Crossed && tested < MOST_CELLS);
                match state {
                    Containment::Outside => {}
                    _ if divide => {
                        next.extend(square.quarters());
                        tested += 4;
                    }
                    Containment::Inside => {
                        let along = |v: f64| {
                            rule.integrate(low.x, low.x + side, |u| area_element(face, DVec2::new(u, v)))
                        };
                        area += rule.integrate(low.y, low.y + side, along);
                    }
                    Containment::Crossed => {
                        let mean = square.places().map(|at| area_element(face, at)).sum::<f64>();
                        area += mean * side * side / (NODES * NODES) as f64;
                    }
                }
            }
            open = next;
        }
        area
    }

    /// The relation of a square to the trimming region.
    fn state(&self, square: &FaceSquare) -> Containment {
        let FaceSquare { face, low, side } = *square;
        let high = low + side;
        match self.surface() {
            Surface::Freeform(freeform) => {
                let Some(region) = freeform.region() else { return Containment::Inside };
                let corners = [low, DVec2::new(high.x, low.y), DVec2::new(low.x, high.y), high];
                let [Some(a), Some(b), Some(c), Some(d)] =
                    corners.map(|p| freeform.parameters(face, p.x, p.y))
                else {
                    return Containment::Inside;
                };
                let corners = [a, b, c, d];
                let [first, rest @ ..] = corners;
                let [low, high] =
                    rest.iter().fold([first, first], |[low, high], p| [low.min(*p), high.max(*p)]);
                region.classify(low, high)
            }
            // The parameters of all others are those of their face.
            Surface::Trimmed(trimmed) => trimmed.region().classify(low, high),
            _ => Containment::Inside,
        }
    }
}

impl FaceSquare {
    fn quarters(&self) -> [Self; 4] {
        let side = 0.5 * self.side;
        [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|at| Self {
            low: self.low + at * side,
            side,
            ..*self
        })
    }

    /// Midpoints of a regular subdivision.
    fn places(&self) -> impl Iterator<Item = DVec2> {
        let (low, step) = (self.low, self.side / NODES as f64);
        let at = move |k: usize| (k as f64 + 0.5) * step;
        (0..NODES * NODES).map(move |k| low + DVec2::new(at(k % NODES), at(k / NODES)))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glanz_geometry::bezier::TensorPatch;
    use glanz_math::DVec3;

    use crate::SceneBuilder;
    use crate::description::*;

    fn area(shape: impl Into<ShapeDescription>) -> Option<f64> {
        let scene = SceneBuilder::new().shape(shape, MaterialKind::diffuse(0.5)).resolve().unwrap().0;
        let placed = scene.placed_surfaces();
        placed[0].area(0..placed[0].faces())
    }

    /// Circles about (1/2, 1/2) of four rational quarters each; counter-clockwise, or clockwise for a negative radius.
    fn rings(radii: &[f64]) -> TrimDescription {
        let r = 0.5_f64.sqrt();
        let circle = |radius: f64| {
            let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
            let points = corners.iter().enumerate().map(|(i, &(x, y))| {
                let w = if i % 2 == 0 { 1.0 } else { r };
                let (x, y) = (f64::from(x) * radius.abs(), f64::from(y) * radius);
                [w * (0.5 + x), w * (0.5 + y), w]
            });
            let curve = TrimCurveDescription {
                degree: 2,
                knots: vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0],
                points: points.collect(),
                width: None,
                edge: None,
            };
            TrimLoopDescription { curves: vec![curve] }
        };
        radii.iter().map(|&radius| circle(radius)).collect::<Vec<_>>().into()
    }

    fn bilinear_square() -> ShapeDescription {
        let corners = [DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
        ShapeDescription::bezier_patches(&[TensorPatch::try_from_points(1, 1, &corners, None).unwrap()])
    }

    #[test]
    fn areas_are_those_of_closed_forms() {
        let sphere = || ShapeDescription::sphere(1.0);
        let turned = sphere().scaled([2.0; 3]).rotated(DVec3::X, 0.7);
        assert!((area(turned).unwrap() - 16.0 * PI).abs() < 1e-12 * 16.0 * PI);
        // A prolate spheroid with c = 2, a = 1: 2 pi (1 + (c / e) asin e), e^2 = 3/4.
        let e = 0.75_f64.sqrt();
        let expected = 2.0 * PI * (1.0 + 2.0 / e * e.asin());
        let stretched = area(sphere().scaled([1.0, 1.0, 2.0])).unwrap();
        assert!((stretched - expected).abs() < 1e-6 * expected, "{stretched} {expected}");
        let cuboid = ShapeDescription::cuboid([0.0; 3], [1.0; 3]);
        let stretched = area(cuboid.scaled([1.0, 2.0, 3.0])).unwrap();
        assert!((stretched - 22.0).abs() < 1e-12 * 22.0);
        let endless = ShapeDescription::rectangle([f64::NEG_INFINITY, f64::INFINITY], [0.0, 1.0]);
        assert_eq!(area(endless), None);
    }

    #[test]
    fn areas_of_trimmed_surfaces_are_those_kept() {
        for (rings_of, share) in [
            (rings(&[0.3]), 0.09 * PI),
            (rings(&[-0.25]), 1.0 - 0.0625 * PI),
            (rings(&[0.4, -0.3, 0.02]), PI * (0.16 - 0.09 + 0.0004)),
            (rings(&[0.01]), 1e-4 * PI),
        ] {
            let flat = area(bilinear_square().scaled([3.0, 0.5, 2.0]).trimmed(rings_of.clone())).unwrap();
            assert!((flat - 1.5 * share).abs() < 1e-3 * 1.5 * share, "{flat} {share}");
            // A cylinder whose parameters have the same area everywhere.
            let curved = area(ShapeDescription::cylinder(0.5, [0.0, 2.0]).trimmed(rings_of)).unwrap();
            assert!((curved - 2.0 * PI * share).abs() < 1e-3 * 2.0 * PI * share, "{curved} {share}");
        }
    }
}
