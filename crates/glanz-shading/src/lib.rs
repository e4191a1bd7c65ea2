//! BSDFs, Fresnel's equations, materials and textures.
//!
//! Everything works in a local frame: z is the shading normal, directions have unit length and point away
//! from the surface. Directions and densities are `f64`, light is `f32`.
//!
//! - [`model`]: the table of scattering models, one file each with the material that describes it: a [`Material`] has textured parameters
//!   and at a [`TexturePoint`] a [`Bsdf`]; the classical shading of document 001 is [`model::phong::classic`];
//! - [`bsdf`]: what a model provides, [`BsdfModel`]: `eval`, `pdf`, `sample` and more;
//! - [`parameter`]: parameters of materials, checked and converted from the form of a description;
//! - [`preview`]: materials in a rasteriser;
//! - [`fresnel`]: reflectance of glass and metal, the directions of reflection and refraction;
//! - [`texture`]: [`Textures`], their mappings and pictures.
//!
//! ```
//! use glanz_light::{Spectrum, Wavelengths};
//! use glanz_math::{DVec2, DVec3};
//! use glanz_shading::texture::{Checkerboard, TextureMapping};
//! use glanz_shading::{Material, SpectrumInput, Texture, TexturePoint, Textures, TransportMode};
//!
//! let mut textures = Textures::new();
//! let board = textures.add(Texture::Checkerboard(Checkerboard {
//!     even: Spectrum::from_rgb([0.8; 3]).into(),
//!     odd: Spectrum::from_rgb([0.2; 3]).into(),
//!     mapping: TextureMapping::Uv { scale: DVec2::splat(8.0), offset: DVec2::ZERO },
//! }))?;
//! let floor = Material::diffuse(SpectrumInput::Texture(board));
//!
//! let at = TexturePoint::new(DVec2::new(0.05, 0.2), DVec3::ZERO);
//! let bsdf = floor.bsdf(&textures, &at, &Wavelengths::Rgb).expect("not an interface");
//! let sample = bsdf.sample(DVec3::Z, DVec2::new(0.3, 0.6), 0.5, TransportMode::Radiance).expect("not black");
//! assert_eq!(sample.weight, Spectrum::from_rgb([0.2; 3]));
//! # Ok::<(), glanz_shading::texture::TextureError>(())
//! ```

pub mod bsdf;
pub mod fresnel;
pub mod model;
pub mod parameter;
pub mod preview;
pub mod texture;

pub use bsdf::{BsdfModel, BsdfSample, Lobe, Spread, TransportMode};
pub use model::{Bsdf, Material};
pub use parameter::{MaterialError, ParameterForm};
pub use preview::PreviewSurface;
pub use texture::{FloatInput, SpectrumInput, Texture, TextureError, TextureId, TexturePoint, Textures};
