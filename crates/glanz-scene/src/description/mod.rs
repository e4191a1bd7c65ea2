//! A scene as plain data: the contents of a file, checked for syntax but not yet for meaning.
//!
//! Readers in `glanz-formats` produce a [`Description`]; [`crate::Scene::resolve`] checks everything through the
//! constructors of geometry and shading. Lengths are metres and angles radians; matrices map columns and may still be
//! singular. Every part that can be wrong carries its [`Location`] in the input.

mod bounds;
mod camera;
mod design;
mod edge;
mod film;
mod freeform;
mod geometry;
mod group;
mod guide;
mod integrator;
mod light;
mod luminaire;
mod material;
mod medium;
mod memory;
mod observer;
mod pass_lengths;
mod photon;
mod receiver;
mod section;
mod shape;
mod texture;
mod trim;

use glanz_light::SpectralDistribution;

pub use camera::{
    CameraDescription, CameraKind, FisheyeProjection, IrisDescription, LensDescription,
    LensInterfaceDescription, SphericalMapping, StopShape, look_at,
};
pub use design::{
    DesignDescription, TargetDescription, TargetKind, VariableDescription, VariableNumbers, VariableQuantity,
};
pub use edge::{EdgeDescription, EdgeKind, EdgeTransition};
pub use film::{FilmDescription, FilterDescription, FilterKind, SampleLimit, SensorDescription};
pub use freeform::{BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription};
pub use geometry::GeometryDescription;
pub use glanz_shading::texture::noise::MAX_OCTAVES;
pub use glanz_shading::texture::{FractalKind, ImageFilter, ImageWrap};
pub use group::{GroupDescription, InstanceDescription};
pub use guide::{GridSettings, GuideBasis, GuideSettings, GuideSettingsError};
pub use integrator::{IntegratorDescription, SamplerDescription};
pub use light::{
    EmissionDescription, EmissionPower, LightDescription, LightKind, SkyDescription, SourceRay,
    SphereMapping, SpotFalloff,
};
pub use luminaire::LuminaireDescription;
pub use material::{DescriptionForm, MaterialDescription, MaterialKind, SurfaceDetailDescription};
pub use medium::{DensityDescription, MediumDescription, SurfaceMedia};
pub use observer::ObserverDescription;
pub use pass_lengths::{PassLengths, PassLengthsError};
pub use photon::{PhotonSettings, PhotonSettingsError};
pub use receiver::{MAX_RECEIVER_CELLS, ReceiverDescription, ReceiverSide, ZoneKind};
pub use section::SectionDescription;
pub use shape::{AlphaDescription, ShapeDescription};
pub use texture::{
    FloatParameter, ImageDescription, MappingDescription, SpectrumParameter, TextureDescription, TextureKind,
};
pub use trim::{TrimCurveDescription, TrimDescription, TrimEdgeDescription, TrimLoopDescription};

/// Index into [`Description::files`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(pub u32);

/// A place in the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// The file.
    pub file: FileId,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// The contents of a scene file.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// Names of the files read, as the user would write them; the scene file is the first.
    pub files: Vec<String>,
    /// The camera.
    pub camera: CameraDescription,
    /// Size and crop window of the picture.
    pub film: FilmDescription,
    /// The pixel filter.
    pub filter: FilterDescription,
    /// The sampler.
    pub sampler: SamplerDescription,
    /// The integrator.
    pub integrator: IntegratorDescription,
    /// Pictures that textures and lights refer to by index.
    pub images: Vec<ImageDescription>,
    /// Textures; one may only refer to those before it.
    pub textures: Vec<TextureDescription>,
    /// Materials, referred to by index.
    pub materials: Vec<MaterialDescription>,
    /// Participating media, referred to by index.
    pub media: Vec<MediumDescription>,
    /// Index of the medium around the camera; `None`: empty space.
    pub camera_medium: Option<usize>,
    /// Lights that are not surfaces.
    pub lights: Vec<LightDescription>,
    /// Points at which the light of a planned room is rated; they have no effect on light and pictures.
    pub observers: Vec<ObserverDescription>,
    /// Radiance, W/(m^2 sr), that the camera sees where its rays leave the scene; it lights nothing. `None`: that of the infinite lights.
    pub backdrop: Option<SpectralDistribution>,
    /// Groups that instances refer to by index; one may only refer to those before it.
    pub groups: Vec<GroupDescription>,
    /// A plane that cuts one of the groups open.
    pub section: Option<SectionDescription>,
    /// Shapes and instances of the world itself.
    pub world: GroupDescription,
    /// The task of an inverse design.
    pub design: DesignDescription,
}
