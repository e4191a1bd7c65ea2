#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! Lengths are metres, angles radians, coordinates `f64`. The vectors of [`glam`] are re-exported, so that the workspace
//! uses one version.
//!
//! - [`Ray`], [`Transform`] (affine, always invertible), [`Bounds3`], [`Frame`];
//! - [`rounding`]: bounds on accumulated rounding errors, used for hits and secondary rays;
//! - [`angle`]: sine and cosine of bounded angles;
//! - [`polynomial`]: real roots of polynomials of low degree;
//! - [`bspline`]: knots of B-splines and the recursion for their basis functions;
//! - [`AreaPdf`] and [`SolidAnglePdf`]: densities whose measure is part of the type.
//!
//! ```
//! use glanz_math::{DVec3, Ray, Transform};
//!
//! let to_world = Transform::translate(DVec3::new(0.0, 0.0, 5.0));
//! let ray = Ray::new(DVec3::ZERO, DVec3::Z);
//! let local = to_world.inverse().ray(&ray);
//! assert_eq!(local.at(5.0), DVec3::ZERO);
//! ```

pub mod angle;
pub mod bounds;
pub mod bspline;
pub mod frame;
pub mod measure;
pub mod polynomial;
pub mod ray;
pub mod rounding;
pub mod transform;

pub use bounds::Bounds3;
pub use frame::Frame;
pub use glam::{self, DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
pub use measure::{AreaPdf, SolidAnglePdf};
pub use ray::Ray;
pub use transform::{Transform, TransformError};
