//! The report of a study.

use std::collections::BTreeMap;
use std::path::Path;

use glanz_formats::image::{self, Format};
use glanz_job::write_atomically;
use glanz_light::{Pixels, Tone};

use crate::study::StudyError;
use glanz_report::{Plot, Table};

/// Headings, paragraphs, tables, plots and pictures in reading order, with a summary table.
#[derive(Debug)]
pub struct Report {
    title: String,
    summary: Table,
    blocks: Vec<ReportBlock>,
}

/// A plot with the name of its file, without extension, and its caption.
#[derive(Debug)]
pub struct Figure {
    /// Name of the file.
    pub name: String,
    /// The plot.
    pub plot: Plot,
    /// Its caption.
    pub caption: String,
}

#[derive(Debug)]
enum ReportBlock {
    Heading(String),
    Paragraph(String),
    Table(Table),
    Data(Table),
    Plot(Figure),
    Drawing { name: String, svg: String, caption: String },
    Picture { name: String, pixels: Pixels, caption: String },
}

impl Report {
    /// A report of a title and a summary table.
    #[must_use]
    pub fn new(title: impl Into<String>, summary: Table) -> Self {
        Self { title: title.into(), summary, blocks: Vec::new() }
    }

    /// The summary table.
    #[must_use]
    pub fn summary(&self) -> &Table {
        &self.summary
    }

    /// All tables but the summary.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks.iter().filter_map(|block| match block {
            ReportBlock::Table(table) | ReportBlock::Data(table) => Some(table),
            _ => None,
        })
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(ReportBlock::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(ReportBlock::Paragraph(text.into()));
    }

    /// Adds a table, also written as CSV.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(ReportBlock::Table(table));
    }

    /// Adds a table that is too long to be printed: the report only links to its CSV file.
    pub fn data(&mut self, table: Table) {
        self.blocks.push(ReportBlock::Data(table));
    }

    /// Adds a plot, written as `name`.svg.
    pub fn plot(&mut self, name: impl Into<String>, plot: Plot, caption: impl Into<String>) {
        self.figure(Figure { name: name.into(), plot, caption: caption.into() });
    }

    /// Adds a plot, written as `figure.name`.svg.
    pub fn figure(&mut self, figure: Figure) {
        self.blocks.push(ReportBlock::Plot(figure));
    }

    /// Adds a drawing, the text of an SVG file, written as `name`.svg.
    pub fn drawing(&mut self, name: impl Into<String>, svg: String, caption: impl Into<String>) {
        self.blocks.push(ReportBlock::Drawing { name: name.into(), svg, caption: caption.into() });
    }

    /// Adds a picture in linear light, written as `name`.png.
    pub fn picture(&mut self, name: impl Into<String>, pixels: Pixels, caption: impl Into<String>) {
        self.blocks.push(ReportBlock::Picture { name: name.into(), pixels, caption: caption.into() });
    }

    /// The text of `report.md`.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n", self.title);
        let table = |table: &Table| {
            format!(
                "{}\n\nData: [{name}.csv]({name}.csv).\n\n{}\n",
                table.caption(),
                table.markdown(),
                name = table.name()
            )
        };
        text += &table(&self.summary);
        for block in &self.blocks {
            text += &match block {
                ReportBlock::Heading(heading) => format!("## {heading}\n\n"),
                ReportBlock::Paragraph(paragraph) => format!("{paragraph}\n\n"),
                ReportBlock::Table(t) => table(t),
                ReportBlock::Data(t) => {
                    format!("{} [{name}.csv]({name}.csv).\n\n", t.caption(), name = t.name())
                }
                ReportBlock::Plot(Figure { name, caption, .. })
                | ReportBlock::Drawing { name, caption, .. } => {
                    format!("![{caption}]({name}.svg)\n\n{caption}\n\n")
                }
                ReportBlock::Picture { name, caption, .. } => {
                    format!("![{caption}]({name}.png)\n\n{caption}\n\n")
                }
            };
        }
        text
    }

    /// Writes `report.md` and everything it shows into the folder `out`, which is created if necessary; returns the
    /// names of the files. Each file has its old content until its new one is complete.
    ///
    /// # Errors
    /// [`StudyError::File`] or [`StudyError::Image`].
    pub fn write(&self, out: &Path) -> Result<Vec<String>, StudyError> {
        glanz_job::make_folder(out)
            .map_err(|source| StudyError::File { path: out.display().to_string(), source })?;
        let mut names = Vec::new();
        let mut put = |name: String, bytes: &[u8]| -> Result<(), StudyError> {
            write_atomically(&out.join(&name), bytes)?;
            names.push(name);
            Ok(())
        };
        put(format!("{}.csv", self.summary.name()), self.summary.csv().as_bytes())?;
        for block in &self.blocks {
            match block {
                ReportBlock::Heading(_) | ReportBlock::Paragraph(_) => {}
                ReportBlock::Table(table) | ReportBlock::Data(table) => {
                    put(format!("{}.csv", table.name()), table.csv().as_bytes())?
                }
                ReportBlock::Plot(Figure { name, plot, .. }) => {
                    put(format!("{name}.svg"), plot.svg().as_bytes())?
                }
                ReportBlock::Drawing { name, svg, .. } => put(format!("{name}.svg"), svg.as_bytes())?,
                ReportBlock::Picture { name, pixels, .. } => {
                    let bytes = image::write(pixels, Format::Png, &Tone::default(), &BTreeMap::new())?;
                    put(format!("{name}.png"), &bytes)?;
                }
            }
        }
        // Last, so that all files it refers to exist.
        put("report.md".to_owned(), self.markdown().as_bytes())?;
        Ok(names)
    }
}
