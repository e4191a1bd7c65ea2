//! What is told of a calculation of illuminance: tables and pictures for people, numbers for programs.
//!
//! Everything here makes text, bytes or pixels of data and writes no file. Per receiver there are [`csv`], the pixels
//! of [`false_colour()`] and [`lux_pixels`], and the drawing [`isolux()`]; of a whole calculation a [`Report`] makes
//! the table for a terminal, a page of HTML, and by `serde` the JSON; a [`Comparison`] sets two designs side by side.
//! [`Polar`] draws the candela distribution of a luminaire.
//!
//! [`table`], [`svg`] and [`lettering`] are also what studies are written with.
//!
//! ```
//! use glanz_illumination::LuxMap;
//! use glanz_illumination::report::{Report, Scale, csv, isolux};
//! use glanz_math::DVec3;
//!
//! // 1000 cd, 2 m above the middle of two squares of 1 m: 1000 * 2 / (4 + 0.5^2)^1.5 in the middle of each.
//! let lux = 2000.0 / 4.25_f64.powf(1.5);
//! let desk = LuxMap {
//!     name: "desk".into(),
//!     cells: [2, 1],
//!     size: [2.0, 1.0],
//!     positions: vec![DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0)],
//!     areas: vec![1.0; 2],
//!     lux: vec![lux; 2],
//!     errors: vec![0.0; 2],
//! };
//! assert_eq!(csv(&desk).lines().count(), 3);
//! assert!(isolux(&desk, &Scale::of(&[&desk])).starts_with("<svg"));
//! let report = Report { title: "Office".into(), maps: vec![desk], ..Report::default() };
//! assert!(report.text().contains("228.3"));
//! assert!(report.html().contains("<h1>Office</h1>"));
//! ```

mod compare;
pub mod contour;
mod csv;
mod drawing;
mod false_colour;
mod field;
mod html;
mod isolux;
mod json;
pub mod lettering;
mod levels;
pub mod palette;
mod polar;
mod scale;
pub mod svg;
pub mod table;
mod text;

use crate::{FluxBalance, LuxMap};

pub use compare::{Comparison, Pair};
pub use csv::csv;
pub use false_colour::{false_colour, lux_pixels};
pub use isolux::{isolux, isolux_at};
pub use levels::levels;
pub use polar::Polar;
pub use scale::Scale;

/// What a calculation found.
///
/// `serde` makes of it: `title`; `receivers`, each with `name`, `cells`, `size_m` and the fields of
/// [`LuxSummary`](crate::LuxSummary); `flux_balance` with the fields of [`FluxBalance`] or null; `how`, an object of
/// the facts. JSON has no word for numbers that are not finite: they become null.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What was calculated: the name of the design.
    pub title: String,
    /// The receivers, in the order in which they are told of.
    pub maps: Vec<LuxMap>,
    /// Where the light went; an integration of illuminance at points does not know.
    pub balance: Option<FluxBalance>,
    /// Facts about the calculation, each with its name: method, particles, seed, time.
    pub how: Vec<(String, String)>,
    /// Candela distributions to be shown, of the whole optic or of its lamps.
    pub polars: Vec<Polar>,
}
