//! A scene as plain data: what a file said, checked for syntax but not yet for sense.
//!
//! Readers in `glanz-formats` produce a [`Description`]; [`crate::Scene::resolve`] checks everything through the
//! constructors of geometry and shading. Lengths are metres and angles radians; matrices map columns and may still be
//! singular. Every part that can be wrong carries the [`Location`] where it was said.
//!
//! One file in spite of its length: it is data without behaviour, and whoever writes a reader wants to see all of it.

use std::sync::Arc;

use glanz_light::{Pixels, SpectralDistribution};
use glanz_math::{DMat4, DVec2, DVec3};

/// Index into [`Description::files`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(pub u32);

/// Where in the input something was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// The file.
    pub file: FileId,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// Everything a scene file says.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// Names of the files read, as the user would write them; the scene file is the first.
    pub files: Vec<String>,
    /// How the picture is taken.
    pub camera: CameraDescription,
    /// Size and cut of the picture.
    pub film: FilmDescription,
    /// How samples are weighted within a pixel's neighbourhood.
    pub filter: FilterDescription,
    /// How samples are spread.
    pub sampler: SamplerDescription,
    /// How light is gathered.
    pub integrator: IntegratorDescription,
    /// Pictures that textures refer to by index.
    pub images: Vec<ImageDescription>,
    /// Textures; one may only refer to those before it.
    pub textures: Vec<TextureDescription>,
    /// Materials, referred to by index.
    pub materials: Vec<MaterialDescription>,
    /// Lights that are not surfaces.
    pub lights: Vec<LightDescription>,
    /// Groups that instances refer to by index; one may only refer to those before it.
    pub groups: Vec<GroupDescription>,
    /// What stands in the world itself.
    pub world: GroupDescription,
}

/// Projection and place of the camera, which looks along +z with +x to the right of its picture and +y up.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// The projection.
    pub kind: CameraKind,
    /// From camera to world space.
    pub to_world: DMat4,
    /// Smallest and largest x, then y, of the screen; by default the shorter side spans [-1, 1].
    pub screen_window: Option<[f64; 4]>,
    /// Width over height of the screen, if not that of the film.
    pub aspect: Option<f64>,
    /// Radius of the aperture, metres; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus, metres.
    pub focal_distance: f64,
    /// Where it was said.
    pub location: Option<Location>,
}

/// The projections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraKind {
    /// Central projection.
    Perspective {
        /// Full angle over the shorter side of the screen, radians, in (0, pi).
        field_of_view: f64,
    },
    /// Parallel projection.
    Orthographic,
}

impl Default for CameraDescription {
    fn default() -> Self {
        Self {
            kind: CameraKind::Perspective { field_of_view: std::f64::consts::FRAC_PI_2 },
            to_world: DMat4::IDENTITY,
            screen_window: None,
            aspect: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            location: None,
        }
    }
}

/// Size and cut of the picture.
#[derive(Clone, Debug)]
pub struct FilmDescription {
    /// Width and height of the full picture, pixels.
    pub resolution: [u32; 2],
    /// The part to render as fractions: smallest and largest x, then y, from the top left.
    pub crop: [f64; 4],
    /// The file the scene asks for.
    pub file_name: Option<String>,
    /// Where it was said.
    pub location: Option<Location>,
}

impl Default for FilmDescription {
    fn default() -> Self {
        Self { resolution: [1280, 720], crop: [0.0, 1.0, 0.0, 1.0], file_name: None, location: None }
    }
}

/// A pixel filter; radii in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterDescription {
    /// Its shape.
    pub kind: FilterKind,
    /// Half the width of its support along x and y, pixels.
    pub radius: [f64; 2],
}

/// Shapes of pixel filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// Constant over a rectangle.
    Box,
    /// Linear fall along each axis; product of two tents.
    Triangle,
    /// Gaussian less its value at the border.
    Gaussian {
        /// Standard deviation, pixels.
        sigma: f64,
    },
    /// Piecewise cubic with negative lobes.
    Mitchell {
        /// Parameter B of @mitchell1988.
        b: f64,
        /// Parameter C of @mitchell1988.
        c: f64,
    },
    /// Constant over an ellipse (document 003 section 5.7.3).
    Cylinder,
    /// Linear fall from the middle to the border of the rectangle (document 003 section 5.7.3).
    Pyramid,
    /// Linear fall from the middle to the border of the ellipse (document 003 section 5.7.3).
    Cone,
}

impl Default for FilterDescription {
    fn default() -> Self {
        Self { kind: FilterKind::Gaussian { sigma: 0.5 }, radius: [1.5, 1.5] }
    }
}

/// How samples are spread.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplerDescription {
    /// Name in the table of `glanz-sampling`.
    pub name: String,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Seed.
    pub seed: u64,
}

impl Default for SamplerDescription {
    fn default() -> Self {
        Self { name: "sobol".to_owned(), samples_per_pixel: 16, seed: 0 }
    }
}

/// How light is gathered.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorDescription {
    /// Name in the table of `glanz-transport`.
    pub name: String,
    /// Scattering events per path at most.
    pub max_depth: Option<u32>,
    /// Whether lights are sampled at every hit.
    pub light_sampling: bool,
    /// Rays that `distributed` sends on from a hit.
    pub branching: Option<u32>,
    /// Where it was said.
    pub location: Option<Location>,
}

impl Default for IntegratorDescription {
    fn default() -> Self {
        Self {
            name: "path".to_owned(),
            max_depth: None,
            light_sampling: true,
            branching: None,
            location: None,
        }
    }
}

/// A picture for textures.
#[derive(Clone, Debug)]
pub struct ImageDescription {
    /// Its file.
    pub name: String,
    /// Linear values; row 0 is the top.
    pub pixels: Arc<Pixels>,
}

/// A spectrum or a texture of spectra.
#[derive(Clone, Debug)]
pub enum SpectrumInput {
    /// The same everywhere.
    Value(SpectralDistribution),
    /// Index into [`Description::textures`].
    Texture(usize),
}

/// A number or a texture of numbers.
#[derive(Clone, Debug)]
pub enum FloatInput {
    /// The same everywhere.
    Value(f32),
    /// Index into [`Description::textures`].
    Texture(usize),
}

/// A texture.
#[derive(Clone, Debug)]
pub struct TextureDescription {
    /// Its name in the scene.
    pub name: String,
    /// What it computes.
    pub kind: TextureKind,
    /// Where it was said.
    pub location: Option<Location>,
}

/// The textures. Float textures hold their numbers as grey spectra.
#[derive(Clone, Debug)]
pub enum TextureKind {
    /// The same everywhere.
    Constant(SpectrumInput),
    /// Product of two.
    Scale(SpectrumInput, SpectrumInput),
    /// `(1 - amount) a + amount b`.
    Mix {
        /// Where `amount` is 0.
        a: SpectrumInput,
        /// Where `amount` is 1.
        b: SpectrumInput,
        /// Weight of `b`.
        amount: FloatInput,
    },
    /// Two alternating in squares.
    Checkerboard {
        /// Where the sum of the cell numbers is even.
        even: SpectrumInput,
        /// Elsewhere.
        odd: SpectrumInput,
        /// Coordinates in cells.
        mapping: TextureMapping,
    },
    /// A picture.
    Image {
        /// Index into [`Description::images`].
        image: usize,
        /// Coordinates; the picture fills [0, 1]^2, (0, 0) is its lower left corner.
        mapping: TextureMapping,
        /// What lies outside [0, 1]^2.
        wrap: ImageWrap,
        /// How values between pixels are found.
        filter: ImageFilter,
        /// Factor on every value.
        scale: f32,
        /// Whether 1 - value is meant.
        invert: bool,
    },
}

/// Where on a texture a point of a surface lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextureMapping {
    /// `(scale.x u + offset.x, scale.y v + offset.y)`.
    Uv {
        /// Factors on (u, v).
        scale: DVec2,
        /// Added after the factors.
        offset: DVec2,
    },
    /// `(p . v1 + offset.x, p . v2 + offset.y)` with p in texture space.
    Planar {
        /// First axis.
        v1: DVec3,
        /// Second axis.
        v2: DVec3,
        /// Added to both.
        offset: DVec2,
        /// From world to texture space.
        to_texture: DMat4,
    },
    /// Polar and azimuthal angle, scaled to [0, 1].
    Spherical {
        /// From world to texture space.
        to_texture: DMat4,
    },
    /// Azimuthal angle scaled to [0, 1], and height.
    Cylindrical {
        /// From world to texture space.
        to_texture: DMat4,
    },
    /// The point itself, for solid textures.
    Solid {
        /// From world to texture space.
        to_texture: DMat4,
    },
}

/// What lies outside a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ImageWrap {
    /// The picture again.
    #[default]
    Repeat,
    /// Zero.
    Black,
    /// The nearest border value.
    Clamp,
}

/// How values between pixels are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ImageFilter {
    /// The nearest pixel.
    Point,
    /// Bilinear interpolation.
    #[default]
    Bilinear,
    /// Bilinear in two levels of a pyramid.
    Trilinear,
}

/// A material.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// Its name, if it has one.
    pub name: String,
    /// What it does with light.
    pub kind: MaterialKind,
    /// Where it was said.
    pub location: Option<Location>,
}

/// The materials.
#[derive(Clone, Debug)]
pub enum MaterialKind {
    /// Lambert's law.
    Diffuse {
        /// Share of light reflected, [0, 1].
        reflectance: SpectrumInput,
    },
    /// Perfect mirror.
    Mirror {
        /// Share of light reflected, [0, 1].
        reflectance: SpectrumInput,
    },
    /// Smooth metal.
    Conductor {
        /// Refractive index.
        eta: SpectrumInput,
        /// Absorption coefficient.
        k: SpectrumInput,
    },
    /// Smooth glass, a solid piece or a pane.
    Dielectric {
        /// Refractive index inside over outside.
        eta: FloatInput,
        /// Factor on reflected light.
        reflectance: SpectrumInput,
        /// Factor on transmitted light.
        transmittance: SpectrumInput,
        /// Whether the surface is a pane with two faces, too thin to displace a ray, instead of the border of a solid.
        thin: bool,
    },
    /// The classical model (document 001 section 3.4).
    Phong {
        /// Ambient coefficient.
        ambient: SpectrumInput,
        /// Diffuse coefficient.
        diffuse: SpectrumInput,
        /// Specular coefficient.
        specular: SpectrumInput,
        /// Exponent of the specular lobe, >= 0.
        exponent: FloatInput,
    },
    /// No surface at all: rays pass.
    Interface,
}

/// A light that is not a surface.
#[derive(Clone, Debug)]
pub struct LightDescription {
    /// What it does.
    pub kind: LightKind,
    /// Intensity, radiance or irradiance, see [`LightKind`].
    pub emission: SpectralDistribution,
    /// Factor on `emission`.
    pub scale: f32,
    /// From light to world space.
    pub to_world: DMat4,
    /// Where it was said.
    pub location: Option<Location>,
}

/// The lights that are not surfaces; points and directions in light space.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Emits W/sr alike in all directions.
    Point {
        /// Where it is.
        from: DVec3,
        /// Distance at which it has faded to nothing, metres.
        range: Option<f64>,
    },
    /// Emits W/sr into a cone.
    Spot {
        /// Where it is.
        from: DVec3,
        /// Where its axis goes.
        to: DVec3,
        /// Half angle of the cone, radians.
        cone_angle: f64,
        /// Half angle inside which it does not fall, radians.
        inner_angle: f64,
        /// How it falls between the two.
        falloff: SpotFalloff,
    },
    /// W/m^2 on a surface that faces it, from one direction.
    Distant {
        /// From here ...
        from: DVec3,
        /// ... to here the light goes.
        to: DVec3,
    },
    /// W/(m^2 sr) from every direction.
    Infinite,
}

/// How a spot light falls between inner and outer angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpotFalloff {
    /// Fourth power of the linear share of cosines (pbrt v3).
    Quartic,
    /// Cubic with horizontal ends (pbrt v4).
    Smoothstep,
}

/// Shapes and instances with one frame.
#[derive(Clone, Debug, Default)]
pub struct GroupDescription {
    /// Its name; empty for the world.
    pub name: String,
    /// Shapes.
    pub shapes: Vec<ShapeDescription>,
    /// Copies of other groups.
    pub instances: Vec<InstanceDescription>,
}

/// A copy of a group.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Index into [`Description::groups`].
    pub group: usize,
    /// From the group's frame to that of the group that holds this instance.
    pub to_parent: DMat4,
    /// Where it was said.
    pub location: Option<Location>,
}

/// A surface with its material.
#[derive(Clone, Debug)]
pub struct ShapeDescription {
    /// The surface in its own frame.
    pub geometry: GeometryDescription,
    /// From the frame of the surface to that of the group.
    pub to_parent: DMat4,
    /// Whether the normal is turned round.
    pub reverse_orientation: bool,
    /// Index into [`Description::materials`].
    pub material: usize,
    /// Light it gives off.
    pub emission: Option<EmissionDescription>,
    /// The part of its parameter domain that is kept; `None`: all of it.
    pub trim: Option<TrimDescription>,
    /// Where it was said.
    pub location: Option<Location>,
}

/// Light a surface gives off, the same in all directions of its front.
#[derive(Clone, Debug)]
pub struct EmissionDescription {
    /// W/(m^2 sr).
    pub radiance: SpectralDistribution,
    /// Factor on `radiance`.
    pub scale: f32,
    /// Total power in W that replaces the magnitude of `radiance`.
    pub power: Option<f32>,
    /// Whether the back shines too.
    pub two_sided: bool,
}

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
}

/// A rational spline surface.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsDescription {
    /// Degree along u.
    pub degree_u: usize,
    /// Degree along v.
    pub degree_v: usize,
    /// Knots along u, `degree_u + 1` more than points; they do not decrease.
    pub knots_u: Vec<f64>,
    /// Knots along v, `degree_v + 1` more than points; they do not decrease.
    pub knots_v: Vec<f64>,
    /// Homogeneous (w x, w y, w z, w), those of equal u side by side: index `i * count_v + j`.
    pub points: Vec<[f64; 4]>,
    /// The part kept, `[[u0, u1], [v0, v1]]`; `None`: the whole domain.
    pub domain: Option<[[f64; 2]; 2]>,
}

/// Rational Bézier patches over the unit square, all of the same degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatchesDescription {
    /// Degree along u.
    pub degree_u: usize,
    /// Degree along v.
    pub degree_v: usize,
    /// Per patch `(degree_u + 1) * (degree_v + 1)` homogeneous points (w x, w y, w z, w), index
    /// `i * (degree_v + 1) + j`, i along u.
    pub patches: Vec<Vec<[f64; 4]>>,
}

/// Rational Bézier patches over a triangle with barycentric coordinates (r, s, t), all of the same degree.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierTrianglesDescription {
    /// Total degree.
    pub degree: usize,
    /// Per patch `(degree + 1) * (degree + 2) / 2` homogeneous points (w x, w y, w z, w) of the terms r^i s^j t^k: by
    /// descending i, then descending j. The first is the corner r = 1, the last the corner t = 1.
    pub patches: Vec<Vec<[f64; 4]>>,
}

/// The part of a parameter domain that closed loops of curves leave.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimDescription {
    /// The loops, at least one.
    pub loops: Vec<TrimLoopDescription>,
}

/// A closed chain of curves; material is on its left.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoopDescription {
    /// The curves; each ends where the next begins, the last where the first does.
    pub curves: Vec<TrimCurveDescription>,
}

/// A rational spline curve in a parameter domain.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurveDescription {
    /// Degree.
    pub degree: usize,
    /// Knots, `degree + 1` more than points; they do not decrease.
    pub knots: Vec<f64>,
    /// Homogeneous (w u, w v, w).
    pub points: Vec<[f64; 3]>,
}
