//! Exact light for exact surfaces: the parts of Glanz under one roof.
//!
//! A scene becomes a picture in four steps, each the work of one part:
//!
//! 1. [`formats`] reads a scene file into a [`Description`](scene::Description), plain data with the places where
//!    everything was said, and messages that point into the file;
//! 2. [`scene`] checks it and builds the hierarchy: [`Scene::resolve`](scene::Scene::resolve). After that nothing can
//!    be invalid and nothing changes;
//! 3. [`transport`] sends rays through the scene and adds the light up in a film;
//! 4. [`formats::image`] writes the picture.
//!
//! Below them lie [`geometry`] (surfaces and the hierarchy over their boxes), [`shading`] (materials and textures),
//! [`light`] (spectra, colour, pictures in memory and their comparison), [`sampling`] (where samples lie) [`math`]
//! (vectors, transforms, roots of polynomials) and [`job`] (progress, cancelling and checkpoints of long computations); above them [`illumination`] counts what light arrives where. Lengths are metres and angles radians;
//! positions are `f64`, light is `f32`, sums are exact. A picture depends on scene, settings and seed
//! alone.
//!
//! A tiny scene, from its text to the bytes of a PNG file:
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use glanz::formats::{Options, image, load_str};
//! use glanz::job::{CancelFlag, Silent};
//! use glanz::light::Tone;
//! use glanz::sampling::SamplerKind;
//! use glanz::scene::Scene;
//! use glanz::transport::{Film, FilmFormat, Filter, IntegratorSettings, RenderSettings, render};
//!
//! let text = r#"
//!     LookAt 0 -5 1  0 0 0  0 0 1
//!     Camera "perspective" "float fov" 40
//!     Film "rgb" "integer xresolution" 32 "integer yresolution" 24
//!     PixelFilter "box"
//!     WorldBegin
//!     LightSource "distant" "point3 from" [-1 -1 2]
//!     LightSource "infinite" "rgb L" [0.2 0.2 0.2]
//!     Shape "torus" "float majorradius" 1 "float minorradius" 0.4
//! "#;
//! let description = load_str("torus.pbrt", text, &Options::default())?.description;
//! let filter = Filter::try_new(&description.filter)?;
//! let integrator = IntegratorSettings::resolve(&description.integrator)?.build();
//! let film = Film::try_new(FilmFormat::plain(description.film.resolution))?;
//! let (scene, _warnings) = Scene::resolve(description)?;
//! let settings = RenderSettings {
//!     filter,
//!     sampler: SamplerKind::Sobol,
//!     seed: 0,
//!     samples_per_pixel: 4,
//!     samples: 0..4,
//!     threads: 0,
//!     time_limit: None,
//! };
//! let outcome = render(&scene, integrator.as_ref(), &settings, film, &mut Silent, &CancelFlag::default())?;
//! let picture = outcome.film.to_pixels()?;
//! let png = image::write(&picture, image::Format::Png, &Tone::default(), &BTreeMap::new())?;
//! assert!(png.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The program `glanz` does the same from the command line.

#[doc(inline)]
pub use glanz_formats as formats;
#[doc(inline)]
pub use glanz_geometry as geometry;
#[doc(inline)]
pub use glanz_illumination as illumination;
#[doc(inline)]
pub use glanz_job as job;
#[doc(inline)]
pub use glanz_light as light;
#[doc(inline)]
pub use glanz_math as math;
#[doc(inline)]
pub use glanz_radiosity as radiosity;
#[doc(inline)]
pub use glanz_report as report;
#[doc(inline)]
pub use glanz_sampling as sampling;
#[doc(inline)]
pub use glanz_scene as scene;
#[doc(inline)]
pub use glanz_shading as shading;
#[doc(inline)]
pub use glanz_transport as transport;
#[doc(inline)]
pub use glanz_viewer as viewer;
