//! Lux maps read from a folder, and their lookup in the scene.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Encoding};
use glanz_geometry::Surface;
use glanz_illumination::{GridResolution, ReceiverHit, ReceiverRequest, Receivers};
use glanz_scene::{HitLocation, ParametricPoint, PlacedSurface, Scene};
use glanz_viewer::model::{LuxCell, LuxLookup, LuxReading};
use serde::Deserialize;

use super::files::{FileNames, REPORT};
use crate::error::{Error, FileFault};
use crate::file;

/// The channels of a lux map's picture.
const CHANNELS: [&str; 3] = ["lux", "error", "area"];

/// Fewest and most values along each side of a surface.
const VALUES: [usize; 2] = [65, 1025];

/// Lux maps with the report that lists them.
#[derive(Debug)]
pub struct LuxFolder {
    folder: PathBuf,
    maps: Vec<StoredMap>,
    content_hash: Option<u128>,
}

#[derive(Debug)]
struct StoredMap {
    receiver: StoredReceiver,
    cells: Vec<LuxCell>,
}

/// A receiver in the report.
#[derive(Debug, Deserialize)]
struct StoredReceiver {
    name: String,
    cells: [u32; 2],
    size_m: [f64; 2],
    minimum_lux: f64,
    mean_lux: f64,
    maximum_lux: f64,
}

#[derive(Debug, Deserialize)]
struct StoredReport {
    receivers: Vec<StoredReceiver>,
}

/// The part of the report that tells which scene it is of.
#[derive(Debug, Deserialize)]
struct ReportOrigin {
    facts: ReportFacts,
}

#[derive(Debug, Deserialize)]
struct ReportFacts {
    /// Hexadecimal digits.
    scene_content_hash: String,
}

/// Whether lux maps were written into this folder.
#[must_use]
pub fn is_lux_folder(folder: &Path) -> bool {
    folder.join(REPORT).is_file()
}

/// [Hash](glanz_job::ContentHash) of the files of the scene that the lux maps in this folder were computed for; `None` if the report does not tell it.
#[must_use]
pub fn lux_folder_content_hash(folder: &Path) -> Option<u128> {
    content_hash(&file::read(&folder.join(REPORT)).ok()?)
}

fn content_hash(report: &[u8]) -> Option<u128> {
    let report: ReportOrigin = serde_json::from_slice(report).ok()?;
    u128::from_str_radix(&report.facts.scene_content_hash, 16).ok()
}

impl LuxFolder {
    /// Reads all maps of a folder written by [`IlluminateOutcome::save`](super::IlluminateOutcome::save).
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        let path = folder.join(REPORT);
        let bytes = file::read(&path)?;
        let report: StoredReport = serde_json::from_slice(&bytes).map_err(Error::of_file(&path))?;
        let mut names = FileNames::default();
        let mut maps = Vec::new();
        for receiver in report.receivers {
            let path = folder.join(format!("{}.exr", names.of_map(&receiver.name, "")));
            let picture = image::read(&file::read(&path)?, Some(&path), Encoding::Linear);
            let pixels = picture.map_err(Error::of_file(&path))?.pixels;
            let is_map = [pixels.width(), pixels.height()] == receiver.cells;
            let [Some(lux), Some(errors), Some(areas)] =
                CHANNELS.map(|name| pixels.channel(name).filter(|_| is_map))
            else {
                return Err(FileFault::OtherLuxMap.of(&path));
            };
            let cell = |((&lux, &error), &area)| LuxCell { lux, error, area };
            let rows: Vec<LuxCell> = lux.iter().zip(errors).zip(areas).map(cell).collect();
            // The first row of a picture is the top one.
            let cells = rows.chunks(receiver.cells[0].max(1) as usize).rev().flatten().copied().collect();
            maps.push(StoredMap { receiver, cells });
        }
        Ok(Self { folder: folder.to_owned(), maps, content_hash: content_hash(&bytes) })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// [Hash](glanz_job::ContentHash) of the files of the scene that the maps, as they were read, were computed for; `None` if the report does not tell it.
    #[must_use]
    pub fn content_hash(&self) -> Option<u128> {
        self.content_hash
    }

    /// The maps on the receivers of `scene`.
    ///
    /// # Errors
    /// [`Error::File`] with [`FileFault::OtherReceivers`] if these are maps of other receivers; walls of a room have to be in the scene.
    pub fn place(&self, scene: &Scene) -> Result<PlacedLux, Error> {
        let laid = self.grid_resolutions().into_iter().find_map(|resolution| {
            let requests = ReceiverRequest::of_scene(scene, resolution);
            let receivers = Receivers::try_new(scene, &requests).ok()?;
            let found = receivers.as_slice().iter().map(|receiver| (receiver.name(), receiver.cells()));
            found
                .eq(self.maps.iter().map(|map| (map.receiver.name.as_str(), map.receiver.cells)))
                .then_some(receivers)
        });
        let receivers = laid.ok_or_else(|| FileFault::OtherReceivers.of(&self.folder))?;
        let cells = self.maps.iter().flat_map(|map| &map.cells).copied().collect();
        let summaries = self.maps.iter().map(|StoredMap { receiver, .. }| {
            [receiver.minimum_lux, receiver.mean_lux, receiver.maximum_lux]
        });
        Ok(PlacedLux { summaries: summaries.collect(), receivers, cells })
    }

    /// Possible divisions of receivers without a resolution of their own.
    fn grid_resolutions(&self) -> Vec<GridResolution> {
        let counts = self.maps.iter().map(|map| map.receiver.cells[0].max(map.receiver.cells[1]));
        let longer = counts.map(GridResolution::Longer);
        let texels = self.maps.iter().map(|map| {
            let StoredReceiver { cells, size_m, .. } = &map.receiver;
            GridResolution::Texel(size_m[0] / f64::from(cells[0].max(1)))
        });
        let mut all: Vec<GridResolution> = longer.chain(texels).collect();
        all.dedup();
        all
    }
}

/// Lux maps on the receivers of a scene.
#[derive(Debug)]
pub struct PlacedLux {
    receivers: Receivers,
    /// The cells of all receivers.
    cells: Vec<LuxCell>,
    /// Minimum, mean and maximum of each receiver, as the report states them, lx.
    summaries: Vec<[f64; 3]>,
}

impl PlacedLux {
    /// Whether a surface counts light on both of its sides, as two receivers.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        let backs: HashSet<u32> =
            self.receivers.as_slice().iter().filter(|r| r.is_back()).map(|r| r.surface()).collect();
        self.receivers.as_slice().iter().any(|r| !r.is_back() && backs.contains(&r.surface()))
    }

    /// Whether a surface has receivers, by its number in [`Scene::placed_surfaces`].
    #[must_use]
    pub fn is_on(&self, surface: u32) -> bool {
        self.receivers.as_slice().iter().any(|receiver| receiver.surface() == surface)
    }

    /// Number of values along each side of a surface by which the page draws the maps, 65 to 1025: among them those in the middles and at the borders of up to 512
    /// cells along the longer side of a receiver. `placed`: the surfaces of the scene.
    #[must_use]
    pub fn side(&self, placed: &[PlacedSurface<'_>]) -> usize {
        let is_mesh = |surface: u32| {
            placed.get(surface as usize).is_some_and(|placed| matches!(placed.surface(), Surface::Mesh(_)))
        };
        // The cells of a mesh, which may be its triangles, are not drawn.
        let drawn = self.receivers.as_slice().iter().filter(|receiver| !is_mesh(receiver.surface()));
        let cells = drawn.flat_map(|receiver| receiver.cells());
        let halves = 2 * cells.max().unwrap_or(1).max(1) as usize;
        let [fewest, most] = VALUES;
        if halves >= most { most } else { halves * (fewest - 1).div_ceil(halves) + 1 }
    }

    /// Illuminance at a point, interpolated between the middles of the cells, lx: on the side of the point, or on the other one if light counts there only.
    #[must_use]
    pub fn interpolated(&self, at: &HitLocation) -> Option<f32> {
        let (at, met) = self.met(at)?;
        let own = self.cells.get(met.cell)?;
        let first = self.receivers.cells_of(met.receiver).start;
        let around = self.receivers.as_slice().get(met.receiver)?.interpolation(&at)?;
        let known = around.iter().filter_map(|(cell, weight)| {
            self.cells
                .get(first + cell)
                .filter(|cell| cell.area > 0.0)
                .map(|cell| (f64::from(cell.lux), weight))
        });
        let (sum, weights) =
            known.fold((0.0, 0.0), |(sum, all), (lux, weight)| (sum + lux * weight, all + weight));
        (own.area > 0.0 && weights > 0.0).then(|| (sum / weights) as f32)
    }

    /// The cell at a point and the point on its side, which is the side of the point, or the other one if light counts there only.
    fn met(&self, at: &HitLocation) -> Option<(HitLocation, ReceiverHit)> {
        let other = HitLocation { place: ParametricPoint { back: !at.place.back, ..at.place }, ..*at };
        [*at, other].into_iter().find_map(|at| Some((at, self.receivers.met(&at).filter(|met| met.counts)?)))
    }
}

impl LuxLookup for PlacedLux {
    fn reading(&self, at: &HitLocation) -> Option<LuxReading> {
        let (_, met) = self.met(at)?;
        let receiver = self.receivers.as_slice().get(met.receiver)?;
        let cell = self.cells.get(met.cell).filter(|cell| cell.area > 0.0)?;
        let [minimum, mean, maximum] = *self.summaries.get(met.receiver)?;
        let number = (met.cell - self.receivers.cells_of(met.receiver).start) as u32;
        let columns = receiver.cells()[0].max(1);
        Some(LuxReading {
            receiver: receiver.name().to_owned(),
            cell: [number % columns, number / columns],
            lux: cell.lux.into(),
            relative_error: (cell.lux > 0.0).then(|| f64::from(cell.error) / f64::from(cell.lux)),
            minimum,
            mean,
            maximum,
        })
    }

    fn cells_on(&self, surface: u32) -> Vec<LuxCell> {
        let numbers = 0..self.receivers.as_slice().len();
        let found =
            numbers.zip(self.receivers.as_slice()).filter(|(_, receiver)| receiver.surface() == surface);
        let cells = found.flat_map(|(number, _)| self.cells.get(self.receivers.cells_of(number)));
        cells.flatten().copied().collect()
    }
}
