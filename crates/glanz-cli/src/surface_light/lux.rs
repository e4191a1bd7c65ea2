//! The lux maps that `glanz illuminate` wrote into a folder, on the scene they are of.

use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Encoding};
use glanz_illumination::{GridResolution, ReceiverRequest, Receivers};
use glanz_math::DVec2;
use glanz_scene::{Place, PlacedSurface, Scene};
use serde::Deserialize;

use crate::illumination::files::{Names, REPORT};
use crate::messages::Failure;

/// The channel of a lux map's picture.
const CHANNEL: &str = "lux";

/// Lux maps, and the report that lists them.
#[derive(Debug)]
pub(crate) struct LuxFolder {
    folder: PathBuf,
    maps: Vec<StoredMap>,
}

#[derive(Debug)]
struct StoredMap {
    receiver: StoredReceiver,
    /// Per cell, in the order of the receiver, lx.
    lux: Vec<f32>,
}

/// What the report says of a receiver.
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
    /// Reads all maps of the folder.
    ///
    /// # Errors
    /// What is missing or no lux map.
    pub(crate) fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(REPORT);
        let failure = |path: &Path, what: &dyn std::fmt::Display| {
            Failure::new(format!("{}: {what}", path.display()))
                .with_help("give the folder that glanz illuminate wrote with -o")
        };
        let text = std::fs::read_to_string(&path).map_err(|error| failure(&path, &error))?;
        let report: StoredReport = serde_json::from_str(&text).map_err(|error| failure(&path, &error))?;
        let mut names = Names::default();
        let mut maps = Vec::new();
        for receiver in report.receivers {
            let path = folder.join(format!("{}.exr", names.file_of(&receiver.name, "")));
            let bytes = std::fs::read(&path).map_err(|error| failure(&path, &error))?;
            let picture =
                image::read(&bytes, Some(&path), Encoding::Linear).map_err(|error| failure(&path, &error))?;
            let pixels = &picture.pixels;
            let Some(rows) =
                pixels.channel(CHANNEL).filter(|_| [pixels.width(), pixels.height()] == receiver.cells)
            else {
                return Err(failure(&path, &"this is not the lux map that the report tells of"));
            };
            // The first row of a picture is the upper one.
            let lux = rows.chunks(receiver.cells[0].max(1) as usize).rev().flatten().copied().collect();
            maps.push(StoredMap { receiver, lux });
        }
        Ok(Self { folder: folder.to_owned(), maps })
    }

    /// The maps on the receivers of `scene`.
    ///
    /// # Errors
    /// A sentence that these are maps of other receivers.
    pub(super) fn of_scene(&self, scene: &Scene) -> Result<LuxMaps, String> {
        let laid = self.finenesses().into_iter().find_map(|fineness| {
            let requests = ReceiverRequest::of_scene(scene, fineness);
            let receivers = Receivers::try_new(scene, &requests).ok()?;
            let found = receivers.as_slice().iter().map(|receiver| (receiver.name(), receiver.cells()));
            found
                .eq(self.maps.iter().map(|map| (map.receiver.name.as_str(), map.receiver.cells)))
                .then_some(receivers)
        });
        let receivers = laid.ok_or_else(|| {
            format!(
                "{}: these lux maps are of other receivers than those of the scene; for the walls of a room give --room as well",
                self.folder.display()
            )
        })?;
        Ok(LuxMaps { receivers, lux: self.maps.iter().flat_map(|map| &map.lux).copied().collect() })
    }

    /// The ways in which the receivers that say nothing themselves may have been divided.
    fn finenesses(&self) -> Vec<GridResolution> {
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
pub(super) struct LuxMaps {
    receivers: Receivers,
    /// Per cell of all receivers, lx.
    lux: Vec<f32>,
}

impl LuxMaps {
    /// Illuminance at a place, on the side that counts, lx.
    pub(super) fn lux(
        &self,
        placed: &[PlacedSurface<'_>],
        surface: u32,
        face: u32,
        uv: DVec2,
    ) -> Option<f32> {
        let of_side = |back| {
            let at = placed.get(surface as usize)?.at(face, uv, back)?.at;
            let met = self.receivers.met(&at, &Place { surface, face, back, uv })?;
            self.lux.get(met.cell).copied().filter(|_| met.counts)
        };
        [false, true].into_iter().find_map(of_side)
    }
}
