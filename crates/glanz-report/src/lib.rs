//! Tables, plots, contours, grids of values, floor plans and colour scales, as text, SVG and pixels.
//!
//! Everything here is a pure function from data to text or pixels; nothing writes a file. The same data give the same
//! bytes.
//!
//! - [`Table`] holds rows under named columns: Markdown, CSV, HTML, lines of a terminal, and by `serde` JSON;
//! - a [`FactList`] holds facts about a computation: words for people, typed values for programs;
//! - [`Plot`] draws series over linear or logarithmic axes, [`HeatMap`] numbers over the cells of a rectangle with
//!   contours ([`ContourGrid`]) at round [`levels()`], a [`ValueGrid`] the numbers themselves, a [`FloorPlan`] a room from above to scale, all as SVG, for which
//!   [`Svg`] is the writer;
//! - [`ColourScale`] assigns colours of a [`Palette`] to numbers;
//! - [`contact_sheet`] puts pictures side by side, [`Raster`] draws rectangles and letters in pixels;
//! - [`number`] writes numbers as people read them.
//!
//! ```
//! use glanz_report::{Axis, Plot, Series, Table};
//!
//! let mut table = Table::new("errors", "Errors over samples", &[("samples", "samples"), ("rmse", "RMSE")]);
//! table.push([64_u64.into(), 0.0125.into()]);
//! assert_eq!(table.csv(), "samples,rmse\n64,0.0125\n");
//!
//! let plot = Plot {
//!     title: "Errors".into(),
//!     x: Axis::logarithmic("samples per pixel"),
//!     y: Axis::logarithmic("RMSE"),
//!     series: vec![Series { name: "path".into(), points: vec![[16.0, 0.025], [64.0, 0.0125]] }],
//!     reference_lines: Vec::new(),
//! };
//! assert!(plot.svg().starts_with("<svg"));
//! ```

mod cell_field;
mod colour_scale;
mod contact_sheet;
mod contour;
mod fact;
mod floor_plan;
mod heat_map;
mod label_boxes;
mod lettering;
mod levels;
mod map_frame;
pub mod number;
mod palette;
mod plot;
mod raster;
pub mod svg;
mod table;
mod thumbnail;
mod value_grid;

pub use cell_field::CellField;
pub use colour_scale::ColourScale;
pub use contact_sheet::{SheetPanel, contact_sheet};
pub use contour::{Contour, ContourGrid};
pub use fact::{Fact, FactList, FactValue};
pub use floor_plan::{FloorPlan, PlanArea, PlanSymbol};
pub use heat_map::HeatMap;
pub use levels::levels;
pub use map_frame::MapAxis;
pub use palette::{Palette, contrasting, hexadecimal};
pub use plot::{Axis, Plot, ReferenceLine, Series};
pub use raster::{LETTER_HEIGHT, Raster, fitting, text_width};
pub use svg::Svg;
pub use table::{Column, Table, TableCell, printable};
pub use thumbnail::{colour_bar, thumbnail};
pub use value_grid::ValueGrid;
