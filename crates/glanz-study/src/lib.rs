//! Studies: new measurements of the claims in the documents behind Glanz.
//!
//! A [`Study`] answers one question with a [`Report`]: tables, plots and pictures, and findings as sentences with their figures.
//! [`studies()`] lists all; a new one is a file and a line there. All figures depend on the [`Settings`] alone, except for times,
//! which are processor times by [`clock`].
//!
//! - [`report`] holds results and writes them (Markdown, CSV, SVG, PNG), with tables and plots of [`glanz_report`];
//! - `bsdfs` plots scattering models;
//! - `densities` integrates with learnt densities (document 003);
//! - `guiding` renders rooms with and without learnt densities (document 003);
//! - `newton` compares Newton's method with the certified search (document 000);
//! - `reconstruction` interpolates light that is known per element (document 003);
//! - `reflector` traces light reflected by a freeform mirror (document 000);
//! - `solvers` compares ways to solve for radiosity (document 003);
//! - `tessellation` compares triangles with the surface that they approximate (document 002).
//!
//! ```
//! use glanz_job::Silent;
//! use glanz_study::{Settings, named};
//!
//!
//! let settings = Settings { rays: Some(300), ..Settings::default() };
//! let report = named("newton").ok_or("no such study")?.run(&settings, &mut Silent)?;
//! assert_eq!(report.summary().rows()[0].len(), report.summary().columns().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bsdfs;
pub mod clock;
mod densities;
mod guiding;
mod newton;
mod reconstruction;
mod reflector;
pub mod report;
mod rooms;
mod solvers;
mod study;
mod tessellation;

pub use reconstruction::quadtree::QuadtreeError;
pub use report::Report;
pub use study::{Settings, Study, StudyError, StudyOption, named, studies};
