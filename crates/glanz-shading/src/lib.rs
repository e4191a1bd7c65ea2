//! BSDFs, Fresnel's equations, materials and textures.
//!
//! Everything works in a local frame: z is the shading normal, directions have unit length and point away
//! from the surface. Directions and densities are `f64`, light is `f32`.
//!
//! - [`material`]: a [`Material`] has textured parameters; at a [`TexturePoint`] it gives a [`Bsdf`];
//! - [`bsdf`]: [`Bsdf`], the closed set of scattering models, with `eval`, `pdf` and `sample`;
//! - [`model`]: the models, one file each; the classical shading of document 001 is [`model::phong::classic`];
//! - [`fresnel`]: reflectance of glass and metal, the directions of reflection and refraction;
//! - [`texture`]: [`Textures`], their mappings and pictures.
//!
//! ```
//! use glanz_light::{Spectrum, Wavelengths};
//! use glanz_math::{DVec2, DVec3};
//! use glanz_shading::texture::{Checkerboard, Mapping};
//! use glanz_shading::{Material, SpectrumInput, Texture, TexturePoint, Textures, TransportMode};
//!
//! let mut textures = Textures::new();
//! let board = textures.add(Texture::Checkerboard(Checkerboard {
//!     even: Spectrum::from_rgb([0.8; 3]).into(),
//!     odd: Spectrum::from_rgb([0.2; 3]).into(),
//!     mapping: Mapping::Uv { scale: DVec2::splat(8.0), offset: DVec2::ZERO },
//! }))?;
//! let floor = Material::Diffuse { reflectance: SpectrumInput::Texture(board) };
//!
//! let at = TexturePoint::new(DVec2::new(0.05, 0.2), DVec3::ZERO);
//! let bsdf = floor.bsdf(&textures, &at, &Wavelengths::Rgb).expect("not an interface");
//! let sample = bsdf.sample(DVec3::Z, DVec2::new(0.3, 0.6), 0.5, TransportMode::Radiance).expect("not black");
//! assert_eq!(sample.weight, Spectrum::from_rgb([0.2; 3]));
//! # Ok::<(), glanz_shading::texture::TextureError>(())
//! ```

pub mod bsdf;
pub mod fresnel;
pub mod material;
pub mod model;
pub mod texture;

pub use bsdf::{Bsdf, BsdfSample, Lobe, Spread, TransportMode};
pub use material::{Material, MaterialError};
pub use texture::{FloatInput, SpectrumInput, Texture, TextureError, TextureId, TexturePoint, Textures};
