#![doc = include_str!("../README.md")]
//!
//! # Modules
//! Everything works in a local frame: z is the shading normal, directions have unit length and point away
//! from the surface. Directions and densities are `f64`, light is `f32`.
//!
//! - [`model`]: the table of scattering models, one file each with the material that describes it: a [`Material`] has textured parameters
//!   and at a [`TexturePoint`] a [`Bsdf`]; the classical shading of document 001 is [`model::phong::classic`];
//! - [`bsdf`]: the interface of a model, [`BsdfModel`]: `eval`, `pdf`, `sample` and more;
//! - [`parameter`]: parameters of materials, checked and converted from the form of a description;
//! - [`preview`]: materials in a rasteriser;
//! - [`fresnel`]: reflectance of glass and metal, the directions of reflection and refraction;
//! - [`microfacet`]: rough surfaces as distributions of facets;
//! - [`texture`]: [`Textures`], their mappings and pictures.

pub mod bsdf;
pub mod fresnel;
pub mod microfacet;
pub mod model;
pub mod parameter;
mod phase;
pub mod preview;
pub mod texture;

pub use bsdf::{BsdfModel, BsdfSample, Lobe, Spread, TransportMode};
pub use model::{Bsdf, Material};
pub use parameter::{MaterialError, ParameterForm};
pub use phase::HenyeyGreenstein;
pub use preview::PreviewSurface;
pub use texture::{FloatInput, SpectrumInput, Texture, TextureError, TextureId, TexturePoint, Textures};
