//! Surfaces.

use glanz_geometry::curve::CurveShading;
use glanz_math::{DVec2, DVec3};

use super::freeform::{BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription};

/// A surface in its own frame; angles in radians.
#[derive(Clone, Debug)]
pub enum GeometryDescription {
    /// Sphere about the origin.
    Sphere {
        /// Radius.
        radius: f64,
        /// Smallest and largest z kept.
        z: [f64; 2],
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Cylinder about the z axis.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Smallest and largest z.
        z: [f64; 2],
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Cone about the z axis, apex up.
    Cone {
        /// Radius at z = 0.
        radius: f64,
        /// z of the apex.
        height: f64,
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Paraboloid about the z axis, apex at the origin.
    Paraboloid {
        /// Radius at the larger z.
        radius: f64,
        /// Smallest and largest z.
        z: [f64; 2],
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// One-sheeted hyperboloid: the segment p1 p2 swept about the z axis.
    Hyperboloid {
        /// One end.
        p1: DVec3,
        /// Other end.
        p2: DVec3,
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Two-sheeted hyperboloid z^2 / c^2 - (x^2 + y^2) / a^2 = 1.
    TwoSheetedHyperboloid {
        /// Radial half axis.
        a: f64,
        /// Half axis along z.
        c: f64,
        /// Smallest and largest z kept.
        z: [f64; 2],
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Ring at constant z.
    Disk {
        /// z.
        height: f64,
        /// Outer radius.
        radius: f64,
        /// Inner radius.
        inner_radius: f64,
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// The plane z = 0.
    Plane {
        /// Smallest and largest x; may be infinite.
        x: [f64; 2],
        /// Smallest and largest y; may be infinite.
        y: [f64; 2],
    },
    /// Zero set of a polynomial of total degree up to 4.
    Algebraic {
        /// Exponents of x, y, z and the coefficient.
        terms: Vec<([u8; 3], f64)>,
        /// The surface is cut off outside this box: two corners.
        clip: [DVec3; 2],
    },
    /// Torus about the z axis.
    Torus {
        /// Distance of the tube's centre from the axis.
        major_radius: f64,
        /// Radius of the tube.
        minor_radius: f64,
        /// Sweep about the z axis.
        phi_max: f64,
    },
    /// Intersection of half-spaces `normal . p <= offset`.
    Polyhedron {
        /// Outward normals, any length, with offsets.
        half_spaces: Vec<(DVec3, f64)>,
    },
    /// Axis-parallel box.
    Cuboid {
        /// Smallest corner.
        min: DVec3,
        /// Largest corner.
        max: DVec3,
    },
    /// Indexed triangles.
    Triangles {
        /// Vertices.
        positions: Vec<DVec3>,
        /// Triples of vertices.
        indices: Vec<[u32; 3]>,
        /// One per vertex.
        normals: Option<Vec<DVec3>>,
        /// One per vertex.
        uvs: Option<Vec<DVec2>>,
    },
    /// Bilinear patches.
    Bilinear {
        /// Vertices.
        positions: Vec<DVec3>,
        /// Corners (0,0), (1,0), (0,1), (1,1) of each patch.
        indices: Vec<[u32; 4]>,
    },
    /// A rational spline surface.
    Nurbs(NurbsDescription),
    /// Rational Bézier patches over rectangles.
    BezierPatches(BezierPatchesDescription),
    /// Rational Bézier patches over triangles.
    BezierTriangles(BezierTrianglesDescription),
    /// A chain of cubic Bézier curves with a width, which face every ray.
    Curve {
        /// Control points, three times the number of segments plus one.
        points: Vec<DVec3>,
        /// Widths at the beginning and at the end.
        widths: [f64; 2],
        /// How it is shaded.
        shading: CurveShading,
    },
}

impl GeometryDescription {
    /// The name of its kind in scene files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Paraboloid { .. } => "paraboloid",
            Self::Hyperboloid { .. } => "hyperboloid",
            Self::TwoSheetedHyperboloid { .. } => "twosheetedhyperboloid",
            Self::Disk { .. } => "disk",
            Self::Plane { .. } => "plane",
            Self::Algebraic { .. } => "algebraic",
            Self::Torus { .. } => "torus",
            Self::Polyhedron { .. } => "polyhedron",
            Self::Cuboid { .. } => "box",
            Self::Triangles { .. } => "trianglemesh",
            Self::Bilinear { .. } => "bilinearmesh",
            Self::Nurbs(_) => "nurbs",
            Self::BezierPatches(_) => "bezierpatch",
            Self::BezierTriangles(_) => "beziertriangle",
            Self::Curve { .. } => "curve",
        }
    }
}
