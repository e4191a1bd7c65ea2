#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! [`RaySurface`] is the common interface of all surfaces: intersection with a ray, position and derivatives at a hit, sampling of
//! points. [`Surface`] is the closed set of all surfaces, each in its own local frame.
//!
//! - [`quadric`], [`torus`], [`algebraic`]: surfaces given by equations;
//! - [`triangle`], [`mesh`], [`bilinear`], [`cuboid`], [`polyhedron`]: flat facets and bilinear patches;
//! - [`spline`] (NURBS) and [`bezier`] (patches over squares and triangles): control points, evaluation, editing;
//!   [`freeform`] intersects them with rays; [`rational`] represents other surfaces as such patches;
//! - [`subdivision`]: limits of meshes that are divided again and again;
//! - [`curve`]: curves with a width;
//! - [`trim`]: parts of parameter domains inside loops of curves; [`trimmed`]: surfaces restricted to them; [`edge_tube`]: where
//!   neighbours may leave gaps;
//! - [`face`]: evaluation of surfaces by face and parameters;
//! - [`batch`]: queries of many rays at once;
//! - [`bvh`]: the bounding volume hierarchy over boxes.

pub mod algebraic;
pub mod batch;
pub mod bezier;
pub mod bilinear;
pub mod bvh;
mod convex;
pub mod cuboid;
pub mod curve;
pub mod edge_tube;
pub mod error;
pub mod face;
pub mod freeform;
pub mod hit;
pub mod mesh;
pub mod polyhedron;
pub mod quadric;
pub mod rational;
mod ray_line;
pub mod spline;
pub mod subdivision;
pub mod surface;
pub mod torus;
pub mod triangle;
pub mod trim;
pub mod trimmed;

pub use batch::BoundedRay;
pub use edge_tube::{EdgeTubes, TubeContact};
pub use error::SurfaceError;
pub use face::{FaceDomain, FacePoint};
pub use glanz_math::{Bounds3, DVec2, DVec3, DVec4, Ray};
pub use hit::{AreaSample, Hit, HitBorder, ShadingPoint, SurfaceLocation, SurfacePoint, SurfaceSample};
pub use surface::{RaySurface, Surface};
