//! Lux maps read from a folder, and their lookup in the scene.

use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Encoding};
use glanz_illumination::{GridResolution, ReceiverRequest, Receivers};
use glanz_math::DVec2;
use glanz_scene::{HitLocation, ParametricPoint, PlacedSurface, Scene};
use serde::Deserialize;

use super::files::{FileNames, REPORT};
use crate::error::{Error, FileFault};
use crate::file;

/// The channel of a lux map's picture.
const CHANNEL: &str = "lux";

/// Lux maps with the report that lists them.
#[derive(Debug)]
pub struct LuxFolder {
    folder: PathBuf,
    maps: Vec<StoredMap>,
}

#[derive(Debug)]
struct StoredMap {
    receiver: StoredReceiver,
    /// Illuminance per cell, in the order of the receiver, lx.
    lux: Vec<f32>,
}

/// A receiver in the report.
#[derive(Debug, Deserialize)]
struct StoredReceiver {
    name: String,
    cells: [u32; 2],
    size_m: [f64; 2],
}

#[derive(Debug, Deserialize)]
struct StoredReport {
    receivers: Vec<StoredReceiver>,
}

impl LuxFolder {
    /// Reads all maps of a folder written by [`IlluminateOutcome::save`](super::IlluminateOutcome::save).
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        let path = folder.join(REPORT);
        let report: StoredReport =
            serde_json::from_slice(&file::read(&path)?).map_err(Error::of_file(&path))?;
        let mut names = FileNames::default();
        let mut maps = Vec::new();
        for receiver in report.receivers {
            let path = folder.join(format!("{}.exr", names.of_map(&receiver.name, "")));
            let picture = image::read(&file::read(&path)?, Some(&path), Encoding::Linear);
            let pixels = picture.map_err(Error::of_file(&path))?.pixels;
            let Some(rows) =
                pixels.channel(CHANNEL).filter(|_| [pixels.width(), pixels.height()] == receiver.cells)
            else {
                return Err(FileFault::OtherLuxMap.of(&path));
            };
            // The first row of a picture is the top one.
            let lux = rows.chunks(receiver.cells[0].max(1) as usize).rev().flatten().copied().collect();
            maps.push(StoredMap { receiver, lux });
        }
        Ok(Self { folder: folder.to_owned(), maps })
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
        Ok(PlacedLux { receivers, lux: self.maps.iter().flat_map(|map| &map.lux).copied().collect() })
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
    /// Illuminance per cell of all receivers, lx.
    lux: Vec<f32>,
}

impl PlacedLux {
    /// Illuminance at a point on the counted side, lx.
    #[must_use]
    pub fn lux(&self, placed: &[PlacedSurface<'_>], surface: u32, face: u32, uv: DVec2) -> Option<f32> {
        let of_side = |back| {
            let at = placed.get(surface as usize)?.at(face, uv, back)?.at;
            let met =
                self.receivers.met(&HitLocation::new(&at, ParametricPoint { surface, face, back, uv }))?;
            self.lux.get(met.cell).copied().filter(|_| met.counts)
        };
        [false, true].into_iter().find_map(of_side)
    }
}
