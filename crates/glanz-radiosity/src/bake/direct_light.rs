//! Direct light of texels, in runs of a fixed length over the texels of all charts.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use glanz_light::Spectrum;

use super::state::{read_bytes, read_light, write_light};
use crate::charts::Chart;

/// Texels of a run; the last one may be shorter.
pub(super) const RUN: usize = 256;

/// Largest number of points of a texel.
const MAX_POINTS: u8 = 4;

/// Irradiance at the points of consecutive texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct DirectRun {
    /// Number of points of each texel up to the end of each, which is the index of the light of the next.
    ends: Vec<u32>,
    light: Vec<Spectrum>,
}

/// Runs by their numbers, as far as they are known.
pub(super) type DirectRuns = BTreeMap<u32, Arc<DirectRun>>;

impl DirectRun {
    /// The light of texels.
    pub(super) fn new(of_texels: impl IntoIterator<Item = Vec<Spectrum>>) -> Self {
        let mut run = Self::default();
        for lights in of_texels {
            run.light.extend(lights);
            run.ends.push(run.light.len() as u32);
        }
        run
    }

    /// Number of texels.
    pub(super) fn texels(&self) -> usize {
        self.ends.len()
    }

    /// Irradiance at the points of a texel; empty where there is no surface.
    pub(super) fn at(&self, texel: usize) -> &[Spectrum] {
        let start =
            texel.checked_sub(1).and_then(|before| self.ends.get(before)).map_or(0, |end| *end as usize);
        self.ends.get(texel).and_then(|end| self.light.get(start..*end as usize)).unwrap_or_default()
    }
}

/// Texels of all charts of a run, by their numbers over all charts.
pub(super) fn texels_of_run(number: usize, texels: usize) -> Range<usize> {
    (number * RUN).min(texels)..((number + 1) * RUN).min(texels)
}

/// Direct light on a chart.
#[derive(Clone, Debug)]
pub(super) struct DirectMap {
    runs: Arc<Vec<Arc<DirectRun>>>,
    /// The texels of the chart among those of all charts.
    texels: Range<usize>,
    is_lit: bool,
}

impl DirectMap {
    /// Whether any texel receives light.
    pub(super) fn is_lit(&self) -> bool {
        self.is_lit
    }

    /// Irradiance at the points of a texel; empty where there is no surface.
    pub(super) fn at(&self, texel: usize) -> &[Spectrum] {
        let number = self.texels.start + texel;
        if number >= self.texels.end {
            return &[];
        }
        self.runs.get(number / RUN).map_or(&[], |run| run.at(number % RUN))
    }

    /// Mean irradiance over the points of a texel.
    pub(super) fn mean(&self, texel: usize) -> Spectrum {
        let lights = self.at(texel);
        if lights.is_empty() {
            return Spectrum::BLACK;
        }
        lights.iter().copied().sum::<Spectrum>() * (1.0 / lights.len() as f32)
    }
}

/// The light on each chart, of all runs.
pub(super) fn maps(charts: &[Chart], runs: &DirectRuns) -> Vec<DirectMap> {
    let runs = Arc::new(runs.values().cloned().collect::<Vec<_>>());
    let mut start = 0;
    let map = |chart: &Chart| {
        let texels = start..start + chart.texels();
        start = texels.end;
        let mut map = DirectMap { runs: runs.clone(), texels, is_lit: false };
        map.is_lit = (0..chart.texels()).any(|texel| map.at(texel).iter().any(|light| !light.is_black()));
        map
    };
    charts.iter().map(map).collect()
}

/// Length of the bytes of [`write_runs`].
pub(super) fn length(runs: &DirectRuns) -> usize {
    4 + runs.values().map(|run| 6 + run.texels() + 12 * run.light.len()).sum::<usize>()
}

/// Appends runs: 4 bytes with their number, for each 4 and 2 bytes with its number and that of its texels, for each texel a byte with the
/// number of its points, then the light of all points.
pub(super) fn write_runs(bytes: &mut Vec<u8>, runs: &DirectRuns) {
    bytes.extend((runs.len() as u32).to_le_bytes());
    for (number, run) in runs {
        bytes.extend(number.to_le_bytes());
        bytes.extend((run.texels() as u16).to_le_bytes());
        bytes.extend((0..run.texels()).map(|texel| run.at(texel).len() as u8));
        run.light.iter().for_each(|&light| write_light(bytes, light));
    }
}

/// Reads the bytes of [`write_runs`] from the front; `None` if they are no runs.
pub(super) fn read_runs(bytes: &mut &[u8]) -> Option<DirectRuns> {
    let count = u32::from_le_bytes(read_bytes(bytes)?);
    let mut runs = DirectRuns::new();
    for _ in 0..count {
        let number = u32::from_le_bytes(read_bytes(bytes)?);
        let texels = usize::from(u16::from_le_bytes(read_bytes(bytes)?));
        if !(1..=RUN).contains(&texels) || runs.last_key_value().is_some_and(|(last, _)| *last >= number) {
            return None;
        }
        let (counts, rest) = bytes.split_at_checked(texels)?;
        *bytes = rest;
        let lights = |&count: &u8| {
            (0..count).map(|_| read_light(bytes)).collect::<Option<Vec<_>>>().filter(|_| count <= MAX_POINTS)
        };
        let of_texels = counts.iter().map(lights).collect::<Option<Vec<_>>>()?;
        runs.insert(number, Arc::new(DirectRun::new(of_texels)));
    }
    Some(runs)
}
