//! Parameterizations of shapes by a sheet and two numbers, for data that is stored by place.

use std::ops::Range;

use glanz_geometry::{RaySurface, Surface};
use glanz_math::{Bounds3, DVec2, DVec3};

use crate::interaction::Interaction;

/// A point of a shape in the shape's own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalPoint {
    pub(crate) position: DVec3,
    /// Normal on the side of the ray's origin, of any length.
    pub(crate) normal_to_viewer: DVec3,
}

impl LocalPoint {
    /// A point of a surface, for a ray that arrives along `direction`.
    #[inline]
    pub(crate) fn new(position: DVec3, normal: DVec3, direction: DVec3) -> Self {
        Self { position, normal_to_viewer: if normal.dot(direction) > 0.0 { -normal } else { normal } }
    }
}

/// A map from the points of a shape to a sheet and two numbers in [0, 1].
///
/// The two sides of a surface are different sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeParameterization {
    /// Two sheets with the parameters (u, v) of the surface, from `min` to `max`.
    Parameters {
        /// Smallest parameters.
        min: DVec2,
        /// Largest parameters.
        max: DVec2,
    },
    /// Six sheets with the position in a box in the shape's own frame, projected along the axis nearest to the normal.
    ///
    /// For surfaces with parameters of their own on every facet (meshes, boxes, polyhedra), or that do not fill a rectangle.
    Projections(Bounds3),
}

impl ShapeParameterization {
    /// The parameterization of a whole surface.
    pub(crate) fn of(surface: &Surface) -> Self {
        match surface {
            Surface::Triangle(_)
            | Surface::Mesh(_)
            | Surface::Cuboid(_)
            | Surface::Polyhedron(_)
            | Surface::Curve(_)
            | Surface::Algebraic(_) => Self::Projections(surface.bounds()),
            Surface::Freeform(freeform) => {
                let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
                let all = || {
                    let faces = 0..freeform.patch_count() as u32;
                    faces
                        .flat_map(move |face| corners.map(|(x, y)| freeform.parameters(face, x, y)))
                        .flatten()
                };
                Self::Parameters {
                    min: all().fold(DVec2::INFINITY, DVec2::min),
                    max: all().fold(DVec2::NEG_INFINITY, DVec2::max),
                }
            }
            Surface::Trimmed(trimmed) => Self::of(trimmed.surface()),
            _ => Self::Parameters { min: DVec2::ZERO, max: DVec2::ONE },
        }
    }

    /// The parameterization of some facets of a mesh.
    pub(crate) fn of_faces(surface: &Surface, faces: Range<u32>) -> Self {
        let Surface::Mesh(mesh) = surface else { return Self::of(surface) };
        let range = faces.start as usize..(faces.end as usize).min(mesh.indices().len());
        let triangles = mesh.indices().get(range).unwrap_or_default();
        let corners = triangles.iter().flatten().filter_map(|&i| mesh.position(i));
        Self::Projections(Bounds3::from_points(corners))
    }

    /// A parameterization for the points of both.
    pub(crate) fn joined(self, other: Self) -> Self {
        match (self, other) {
            (Self::Parameters { min, max }, Self::Parameters { min: a, max: b }) => {
                Self::Parameters { min: min.min(a), max: max.max(b) }
            }
            (Self::Projections(a), Self::Projections(b)) => Self::Projections(a.union(b)),
            (own, _) => own,
        }
    }

    /// Number of sheets.
    #[must_use]
    pub fn sheets(&self) -> u32 {
        match self {
            Self::Parameters { .. } => 2,
            Self::Projections(_) => 6,
        }
    }

    /// Sheet of a point, less than [`ShapeParameterization::sheets`], and its two numbers in [0, 1]; those of points outside are clamped.
    #[must_use]
    pub fn locate(&self, at: &Interaction) -> (u32, DVec2) {
        match self {
            Self::Parameters { min, max } => {
                let back = at.point.normal.dot(at.wo) < 0.0;
                (u32::from(back), share(at.point.uv, *min, *max))
            }
            Self::Projections(bounds) => {
                let LocalPoint { position, normal_to_viewer: normal } = at.local_point();
                let axis = nearest_axis(normal);
                let sheet = 2 * axis as u32 + u32::from(normal[axis] < 0.0);
                let plane = |v: DVec3| DVec2::new(v[(axis + 1) % 3], v[(axis + 2) % 3]);
                (sheet, share(plane(position), plane(bounds.min), plane(bounds.max)))
            }
        }
    }

    /// A tangent at `at` that varies little over a sheet, in world space and of any length.
    ///
    /// The derivative by u; for projections, the axis of the world after the one nearest to the normal.
    #[must_use]
    pub fn tangent(&self, at: &Interaction) -> DVec3 {
        match self {
            Self::Parameters { .. } => at.point.dpdu,
            Self::Projections(_) => DVec3::AXES[(nearest_axis(at.point.normal) + 1) % 3],
        }
    }
}

/// 0 for x, 1 for y, 2 for z.
fn nearest_axis(v: DVec3) -> usize {
    let [x, y, z] = v.abs().to_array();
    if x >= y && x >= z { 0 } else { usize::from(y < z) + 1 }
}

/// The position of `p` between `min` and `max` per axis, clamped to [0, 1]; 0 where these are the same.
fn share(p: DVec2, min: DVec2, max: DVec2) -> DVec2 {
    let axis = |p: f64, min: f64, max: f64| {
        let share = (p - min) / (max - min);
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    };
    DVec2::new(axis(p.x, min.x, max.x), axis(p.y, min.y, max.y))
}

#[cfg(test)]
mod tests {
    use glanz_math::Ray;

    use super::*;
    use crate::description::*;
    use crate::{Scene, SceneBuilder};

    fn scene<const N: usize>(shapes: [ShapeDescription; N]) -> Scene {
        SceneBuilder::new().shapes(shapes, MaterialKind::diffuse(1.0)).resolve().unwrap().0
    }

    fn located(scene: &Scene, from: [f64; 3], to: [f64; 3]) -> (u32, DVec2) {
        let (from, to) = (DVec3::from(from), DVec3::from(to));
        let hit = scene.intersect(&Ray::new(from, (to - from).normalize()), f64::INFINITY).unwrap();
        scene.parameterizations()[hit.id as usize].unwrap().locate(&hit)
    }

    #[test]
    fn parameters_of_a_sphere_begin_and_end_at_its_seam() {
        let scene = scene([ShapeDescription::sphere(1.0).translated(DVec3::X * 10.0)]);
        // u is the azimuth from the x axis: 0 and 1 meet there.
        let (sheet, before) = located(&scene, [13.0, -1e-3, 0.0], [10.0, -1e-3, 0.0]);
        let (_, after) = located(&scene, [13.0, 1e-3, 0.0], [10.0, 1e-3, 0.0]);
        assert!(before.x > 0.999 && after.x < 0.001 && (after.y - 0.5).abs() < 1e-3, "{before} {after}");
        // The inside is the other sheet.
        assert_eq!((sheet, located(&scene, [10.0, 0.0, 0.0], [20.0, 0.1, 0.0]).0), (0, 1));
    }

    #[test]
    fn parameters_of_a_patch_span_its_knots() {
        // A flat spline over u in [2, 6] and v in [-1, 0]: x from 0 to 4 m, y from 0 to 1 m.
        let corner = |x: f64, y: f64| [x, y, 0.0, 1.0];
        let surface = NurbsDescription {
            degree_u: 1,
            degree_v: 1,
            knots_u: vec![2.0, 2.0, 6.0, 6.0],
            knots_v: vec![-1.0, -1.0, 0.0, 0.0],
            points: vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(4.0, 0.0), corner(4.0, 1.0)],
            domain: None,
        };
        let scene = scene([GeometryDescription::Nurbs(surface).into()]);
        let (_, place) = located(&scene, [1.0, 0.75, 5.0], [1.0, 0.75, 0.0]);
        assert!((place - DVec2::new(0.25, 0.75)).length() < 1e-9, "{place}");
        let (_, corner) = located(&scene, [4.0 - 1e-12, 1e-12, 5.0], [4.0 - 1e-12, 1e-12, 0.0]);
        assert!((corner - DVec2::new(1.0, 0.0)).length() < 1e-9, "{corner}");
    }

    #[test]
    fn faces_of_a_box_are_sheets_under_any_transformation() {
        let cuboid = ShapeDescription::cuboid([0.0; 3], [2.0, 4.0, 8.0]);
        let scene = scene([cuboid.rotated(DVec3::Z, std::f64::consts::FRAC_PI_2)]);
        // Own +x is the world's +y; own y, from 0 to 4, is the world's -x.
        let (sheet, place) = located(&scene, [-1.0, 9.0, 2.0], [-1.0, 0.0, 2.0]);
        assert_eq!(sheet, 0);
        assert!((place - DVec2::new(0.25, 0.25)).length() < 1e-12, "{place}");
        let sheets =
            [[9.0, 1.0, 4.0], [-9.0, 1.0, 4.0], [-2.0, -9.0, 4.0], [-2.0, 1.0, 20.0], [-2.0, 1.0, -9.0]]
                .map(|from| located(&scene, from, [-2.0, 1.0, 4.0]).0);
        assert_eq!(sheets, [3, 2, 1, 4, 5]);
    }

    #[test]
    fn joined_meshes_keep_their_own_boxes() {
        let wall = |x: f64| {
            let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 4.0], [0.0, 4.0]];
            let positions = corners.iter().map(|&[y, z]| DVec3::new(x, y, z)).collect();
            ShapeDescription::mesh(positions, vec![[0, 1, 2], [0, 2, 3]])
        };
        let scene = scene([wall(0.0), wall(7.0)]);
        let boxes: Vec<_> = scene.parameterizations();
        let of = |x| {
            ShapeParameterization::Projections(Bounds3::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x, 2.0, 4.0)))
        };
        assert_eq!(boxes, [Some(of(0.0)), Some(of(7.0))]);
        // Both triangles of a wall are one sheet, its sides are two.
        assert_eq!(located(&scene, [5.0, 1.5, 1.0], [9.0, 1.5, 1.0]), (1, DVec2::new(0.75, 0.25)));
        assert_eq!(located(&scene, [5.0, 0.5, 3.0], [9.0, 0.5, 3.0]), (1, DVec2::new(0.25, 0.75)));
        assert_eq!(located(&scene, [9.0, 0.5, 3.0], [5.0, 0.5, 3.0]).0, 0);
    }
}
