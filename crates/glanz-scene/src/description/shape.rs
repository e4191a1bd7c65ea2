//! Shapes: surfaces with a transformation, a material and perhaps emission.

use std::f64::consts::TAU;

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::spline::NurbsSurface;
use glanz_math::glam::DVec4;
use glanz_math::{DMat4, DVec3};

use super::Location;
use super::freeform::{BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription};
use super::geometry::GeometryDescription;
use super::light::EmissionDescription;
use super::medium::SurfaceMedia;
use super::receiver::{ReceiverDescription, ReceiverSide};
use super::texture::FloatParameter;
use super::trim::TrimDescription;

/// A surface with its material.
///
/// Constructors give it the frame of its group; methods place and complete it:
/// ```
/// use glanz_scene::description::ShapeDescription;
///
/// let lamp = ShapeDescription::sphere(0.2).emitting(50.0).translated([0.0, 0.0, 3.0]);
/// assert_eq!(lamp.to_parent.w_axis.z, 3.0);
/// ```
#[derive(Clone, Debug)]
pub struct ShapeDescription {
    /// The surface in its own frame.
    pub geometry: GeometryDescription,
    /// Transformation from the frame of the surface to that of the group.
    pub to_parent: DMat4,
    /// Whether the normal is reversed.
    pub reverse_orientation: bool,
    /// Index into [`Description::materials`](super::Description::materials).
    pub material: usize,
    /// The media on both sides.
    pub media: SurfaceMedia,
    /// Emitted light.
    pub emission: Option<EmissionDescription>,
    /// The part of the parameter domain that is kept; `None`: all of it.
    pub trim: Option<TrimDescription>,
    /// The solid that it bounds: shapes of one group with the same number bound a volume together, with normals that point outwards.
    /// Where borders of their trimming curves overlap, a ray enters and leaves the volume once.
    pub solid: Option<u32>,
    /// Receiver settings; only shapes of the world can be receivers.
    pub receiver: Option<ReceiverDescription>,
    /// The opacity, if it is not 1.
    pub alpha: Option<AlphaDescription>,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// The opacity of a surface: the probability, clamped to [0, 1], with which it stops a ray at a point.
///
/// Positions of textures are those in the frame of the group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaDescription {
    /// For all rays.
    pub opacity: FloatParameter,
    /// Factor on it for shadow rays.
    pub shadow: FloatParameter,
}

impl From<FloatParameter> for AlphaDescription {
    /// The same opacity for all rays.
    fn from(opacity: FloatParameter) -> Self {
        Self { opacity, shadow: FloatParameter::Value(1.0) }
    }
}

impl From<GeometryDescription> for ShapeDescription {
    /// The surface in the frame of its group, with material 0.
    fn from(geometry: GeometryDescription) -> Self {
        Self {
            geometry,
            to_parent: DMat4::IDENTITY,
            reverse_orientation: false,
            material: 0,
            media: SurfaceMedia::default(),
            emission: None,
            trim: None,
            solid: None,
            receiver: None,
            alpha: None,
            location: None,
        }
    }
}

impl ShapeDescription {
    /// A whole sphere about the origin; its normal points outwards.
    #[must_use]
    pub fn sphere(radius: f64) -> Self {
        GeometryDescription::Sphere { radius, z: [-radius, radius], phi_max: TAU }.into()
    }

    /// An open cylinder about the z axis from `z[0]` to `z[1]`; its normal points outwards.
    #[must_use]
    pub fn cylinder(radius: f64, z: [f64; 2]) -> Self {
        GeometryDescription::Cylinder { radius, z, phi_max: TAU }.into()
    }

    /// A disk about the origin in the plane z = 0; its normal is +z.
    #[must_use]
    pub fn disk(radius: f64) -> Self {
        GeometryDescription::Disk { height: 0.0, radius, inner_radius: 0.0, phi_max: TAU }.into()
    }

    /// The infinite plane z = 0; its normal is +z.
    #[must_use]
    pub fn plane() -> Self {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        GeometryDescription::Plane { x: all, y: all }.into()
    }

    /// The rectangle of the plane z = 0 between the smallest and largest x and y; its normal is +z.
    #[must_use]
    pub fn rectangle(x: [f64; 2], y: [f64; 2]) -> Self {
        GeometryDescription::Plane { x, y }.into()
    }

    /// The parallelogram with a corner and two edges that start there; its normal is `u` x `v`.
    #[must_use]
    pub fn parallelogram(corner: impl Into<DVec3>, u: impl Into<DVec3>, v: impl Into<DVec3>) -> Self {
        let (corner, u, v) = (corner.into(), u.into(), v.into());
        let positions = vec![corner, corner + u, corner + v, corner + u + v];
        GeometryDescription::Bilinear { positions, indices: vec![[0, 1, 2, 3]] }.into()
    }

    /// An axis-parallel box between two corners; its normal points outwards.
    #[must_use]
    pub fn cuboid(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Self {
        GeometryDescription::Cuboid { min: min.into(), max: max.into() }.into()
    }

    /// A torus about the z axis; its normal points outwards.
    #[must_use]
    pub fn torus(major_radius: f64, minor_radius: f64) -> Self {
        GeometryDescription::Torus { major_radius, minor_radius, phi_max: TAU }.into()
    }

    /// Triangles with flat normals (p1 - p0) x (p2 - p0).
    #[must_use]
    pub fn mesh(positions: Vec<DVec3>, indices: Vec<[u32; 3]>) -> Self {
        GeometryDescription::Triangles { positions, indices, normals: None, uvs: None }.into()
    }

    /// A NURBS surface.
    #[must_use]
    pub fn nurbs(surface: &NurbsSurface) -> Self {
        let (u, v) = (surface.knots_u(), surface.knots_v());
        GeometryDescription::Nurbs(NurbsDescription {
            degree_u: u.degree(),
            degree_v: v.degree(),
            knots_u: u.knots().to_vec(),
            knots_v: v.knots().to_vec(),
            points: homogeneous(surface.control_points()),
            domain: None,
        })
        .into()
    }

    /// Bézier patches over rectangles, all of the degrees of the first.
    #[must_use]
    pub fn bezier_patches(patches: &[TensorPatch]) -> Self {
        let (degree_u, degree_v) = patches.first().map_or((1, 1), TensorPatch::degrees);
        let patches = patches.iter().map(|patch| homogeneous(patch.control_points())).collect();
        GeometryDescription::BezierPatches(BezierPatchesDescription { degree_u, degree_v, patches }).into()
    }

    /// Bézier patches over triangles, all of the degree of the first.
    #[must_use]
    pub fn bezier_triangles(patches: &[TrianglePatch]) -> Self {
        let degree = patches.first().map_or(1, TrianglePatch::degree);
        let patches = patches.iter().map(|patch| homogeneous(patch.control_points())).collect();
        GeometryDescription::BezierTriangles(BezierTrianglesDescription { degree, patches }).into()
    }

    /// The shape transformed by `matrix` after its present transformation.
    #[must_use]
    pub fn transformed(self, matrix: DMat4) -> Self {
        Self { to_parent: matrix * self.to_parent, ..self }
    }

    /// The shape moved by `offset`, metres.
    #[must_use]
    pub fn translated(self, offset: impl Into<DVec3>) -> Self {
        self.transformed(DMat4::from_translation(offset.into()))
    }

    /// The shape rotated by `angle`, radians, about an axis of unit length through the origin.
    #[must_use]
    pub fn rotated(self, axis: impl Into<DVec3>, angle: f64) -> Self {
        self.transformed(DMat4::from_axis_angle(axis.into(), angle))
    }

    /// The shape scaled about the origin along the three axes.
    #[must_use]
    pub fn scaled(self, factors: impl Into<DVec3>) -> Self {
        self.transformed(DMat4::from_scale(factors.into()))
    }

    /// The shape with its normal reversed.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { reverse_orientation: !self.reverse_orientation, ..self }
    }

    /// The shape as a light: a radiance, W/(m^2 sr), that leaves its front, or an [`EmissionDescription`].
    #[must_use]
    pub fn emitting(self, emission: impl Into<EmissionDescription>) -> Self {
        Self { emission: Some(emission.into()), ..self }
    }

    /// The shape as the boundary of the medium `inside`, by its index; `outside` there is another, or empty space.
    #[must_use]
    pub fn enclosing(self, inside: usize, outside: Option<usize>) -> Self {
        Self { media: SurfaceMedia { inside: Some(inside), outside }, ..self }
    }

    /// The shape with an opacity.
    #[must_use]
    pub fn with_alpha(self, alpha: impl Into<AlphaDescription>) -> Self {
        Self { alpha: Some(alpha.into()), ..self }
    }

    /// The shape without what `trim` cuts away.
    #[must_use]
    pub fn trimmed(self, trim: TrimDescription) -> Self {
        Self { trim: Some(trim), ..self }
    }

    /// The shape as a part of the boundary of the solid with this number.
    #[must_use]
    pub fn bounding(self, solid: u32) -> Self {
        Self { solid: Some(solid), ..self }
    }

    /// The shape as a receiver of that name, measured on its front.
    #[must_use]
    pub fn receiver(self, name: impl Into<String>) -> Self {
        let receiver = ReceiverDescription {
            name: name.into(),
            cells: None,
            side: ReceiverSide::Front,
            zone: None,
            location: None,
        };
        Self { receiver: Some(receiver), ..self }
    }
}

fn homogeneous(points: &[DVec4]) -> Vec<[f64; 4]> {
    points.iter().map(DVec4::to_array).collect()
}
