//! From a description to a scene that cannot be wrong, and the questions that rays ask it.
//!
//! A reader fills a [`Description`], plain data with the places where everything was said. [`Scene::resolve`] checks
//! it through the constructors of geometry and shading and builds the hierarchies. After that nothing can be invalid
//! and nothing changes: a [`Scene`] only answers.
//!
//! - [`Camera`] turns a place on the film into a ray;
//! - [`Scene::intersect`] answers with an [`Interaction`], [`Scene::occluded`] with yes or no;
//! - [`Light`]s are chosen by [`Scene::pick_light`] and sampled by [`Scene::sample_light`], or by [`Scene::emit`] for paths that begin there; the densities for multiple
//!   importance sampling come from [`Scene::light_pdf`] and [`Scene::infinite_pdf`].
//!
//! ```
//! use glanz_light::SpectralDistribution;
//! use glanz_math::{DMat4, DVec3, Ray};
//! use glanz_scene::description::*;
//! use glanz_scene::Scene;
//!
//! let white = SpectrumInput::Value(SpectralDistribution::Constant(0.8));
//! let mut description = Description {
//!     materials: vec![MaterialDescription {
//!         name: String::new(),
//!         kind: MaterialKind::Diffuse { reflectance: white },
//!         location: None,
//!     }],
//!     ..Description::default()
//! };
//! description.world.shapes.push(ShapeDescription {
//!     geometry: GeometryDescription::Sphere { radius: 1.0, z: [-1.0, 1.0], phi_max: std::f64::consts::TAU },
//!     to_parent: DMat4::from_translation(DVec3::new(0.0, 0.0, 5.0)),
//!     reverse_orientation: false,
//!     material: 0,
//!     emission: None,
//!     trim: None,
//!     receiver: None,
//!     location: None,
//! });
//! let (scene, warnings) = Scene::resolve(description)?;
//! assert!(warnings.is_empty());
//! let hit = scene.intersect(&Ray::new(DVec3::ZERO, DVec3::Z), f64::INFINITY).ok_or("a miss")?;
//! assert!((hit.t - 4.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod area;
pub mod camera;
pub mod chart;
pub mod description;
pub mod diagnostic;
pub mod error;
mod interaction;
pub mod light;
mod object;
mod placed;
mod placed_area;
mod receiver;
mod resolve;
mod scene;
mod statistics;

pub use camera::{Camera, Projected};
pub use chart::Chart;
pub use description::{Description, Location};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use error::{SceneError, SceneErrorKind, SceneWarning};
pub use interaction::{Interaction, Reference};
pub use light::{ArrivingLight, Light, LightId, LightRay, LightSample, MAX_LIGHT_GROUPS};
pub use object::Object;
pub use placed::{Place, PlacedPoint, PlacedSurface};
pub use receiver::NamedReceiver;
pub use scene::{MAX_NESTING, Scene};
pub use statistics::Statistics;
