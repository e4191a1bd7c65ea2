//! Light on the receivers of a scene: from its file to maps, with progress.

pub(crate) mod far_field_file;
pub(crate) mod files;

mod integrating;
mod tally_file;
mod tracing;

use std::path::Path;

use glanz_formats::ContentHash;
use glanz_illumination::report::LuxReport;
use glanz_illumination::{
    FarFieldGrid, GridResolution, LuxMap, ReceiverRequest, Receivers, Tally, add_walls,
};
use glanz_job::CancelFlag;
use glanz_report::number::significant;
use glanz_scene::Scene;

use crate::arguments::{IlluminateArguments, MethodName};
use crate::messages::{Failure, Messages};
use crate::report::{duration, grouped, plural};
use crate::scene_file::{Input, SceneFile};

use tracing::Traced;
pub(crate) use tracing::check_goal;

/// Cells of all receivers at most: their sums take 40 bytes for every thread.
const CELLS_LIMIT: usize = 1 << 24;

/// Combined standard errors beyond which two methods differ.
const APART: f64 = 4.0;

/// A scene with receivers.
pub(crate) struct Design {
    pub(crate) file: SceneFile,
    title: String,
    scene: Scene,
    receivers: Receivers,
    /// Fingerprint of both.
    hash: u128,
}

/// What was found of a design.
pub(crate) struct Found {
    pub(crate) report: LuxReport,
    /// Maps by the other method, if both were asked for.
    pub(crate) integrated: Vec<LuxMap>,
    pub(crate) tally: Option<Tally>,
    pub(crate) interrupted: bool,
}

impl Design {
    /// Reads the scene file `path` and lays its receivers out.
    ///
    /// # Errors
    /// Why not.
    pub(crate) fn read(
        path: &Path,
        arguments: &IlluminateArguments,
        messages: Messages,
    ) -> Result<Self, Failure> {
        let mut file = SceneFile::read(&Input::File(path), arguments.strict, messages)?;
        if let Some(size) = arguments.room() {
            add_walls(&mut file.description, size);
        }
        let scene = file.resolve(arguments.strict, messages)?;
        let fineness = arguments.texel.map_or(GridResolution::Longer(arguments.cells), GridResolution::Texel);
        let requests = ReceiverRequest::of_scene(&scene, fineness);
        let wants_far_field = !arguments.far_field.is_empty();
        if requests.is_empty() && !wants_far_field {
            return Err(Failure::new(format!("{}: nothing in this scene receives light", path.display())).with_help(
                "give shapes \"string receiver\" \"NAME\", or ask for the walls of a box with --room X Y Z",
            ));
        }
        let receivers = Receivers::try_new(&scene, &requests)
            .map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        if receivers.cell_count() > CELLS_LIMIT {
            let cells = grouped(receivers.cell_count() as u64);
            return Err(Failure::new(format!(
                "{}: {cells} cells are more than {CELLS_LIMIT}",
                path.display()
            ))
            .with_help("ask for fewer with --cells or longer ones with --texel"));
        }
        if scene.lights().is_empty() {
            return Err(Failure::new(format!("{}: nothing in this scene shines", path.display())));
        }
        let mut hash = ContentHash::default();
        let names: Vec<(&str, [u32; 2])> =
            receivers.as_slice().iter().map(|receiver| (receiver.name(), receiver.cells())).collect();
        let identity =
            format!("{:032x} {:?} {names:?} {wants_far_field}", file.content_hash, arguments.room());
        hash.add_file(identity.as_bytes());
        let title = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Self { file, title, scene, receivers, hash: hash.value() })
    }

    /// Finds the light; `None` if the user wanted an end before there was any.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn illuminate(
        &mut self,
        arguments: &IlluminateArguments,
        messages: Messages,
        cancel: &CancelFlag,
    ) -> Result<Option<Found>, Failure> {
        let count = self.receivers.as_slice().len() as u64;
        messages.note(&format!(
            "{}: {} with {}",
            self.title,
            plural(count, "receiver", "receivers"),
            plural(self.receivers.cell_count() as u64, "cell", "cells"),
        ));
        let mut report = LuxReport { title: self.title.clone(), ..LuxReport::default() };
        let mut integrated = Vec::new();
        if arguments.method != MethodName::Trace {
            let Some(found) = integrating::integrated(self, arguments, messages, cancel)? else {
                return Ok(None);
            };
            integrated = found.maps;
            report.how.extend(found.how);
        }
        if arguments.method == MethodName::Integrate {
            report.maps = integrated;
            return Ok(Some(Found { report, integrated: Vec::new(), tally: None, interrupted: false }));
        }
        let Traced { tally, interrupted, how } = tracing::traced(self, arguments, messages, cancel)?;
        report.how.extend(how);
        report.maps = tally.lux_maps(&self.receivers);
        report.balance = Some(tally.balance());
        self.warn_of_dark_sides(&tally, messages);
        if !integrated.is_empty() {
            report.how.push(("agreement".to_owned(), agreement(&report.maps, &integrated)));
        }
        Ok(Some(Found { report, integrated, tally: Some(tally), interrupted }))
    }

    /// A receiver that nothing comes to may have been turned the wrong way.
    fn warn_of_dark_sides(&mut self, tally: &Tally, messages: Messages) {
        for (number, receiver) in self.receivers.as_slice().iter().enumerate() {
            let other = tally.on_other_side(number);
            if tally.received(number).0 == 0.0 && other > 0.0 {
                let name = receiver.name();
                let lumens = significant(other);
                self.file.warn(
                    &format!(
                        "no light comes to the side of \"{name}\" that counts, {lumens} lm to the other: \
                         \"string receiverside\" chooses"
                    ),
                    messages,
                );
            }
        }
    }
}

/// Directions of a far field: planes every 15, gamma every 5 degrees, as luminaires are usually measured.
pub(crate) fn far_field_grid(arguments: &IlluminateArguments) -> Option<FarFieldGrid> {
    if arguments.far_field.is_empty() { None } else { FarFieldGrid::try_new(24, 36) }
}

/// How far maps of the same cells are apart, in their combined errors.
fn agreement(traced: &[LuxMap], integrated: &[LuxMap]) -> String {
    let (mut cells, mut apart, mut worst) = (0_u64, 0_u64, 0.0_f64);
    let (mut flux, mut other) = (0.0, 0.0);
    for (a, b) in traced.iter().zip(integrated) {
        for cell in (0..a.areas.len()).filter(|&cell| a.areas[cell] > 0.0) {
            let error = a.errors[cell].hypot(b.errors[cell]);
            let distance = (a.lux[cell] - b.lux[cell]).abs() / error;
            cells += 1;
            apart += u64::from(distance > APART);
            worst = worst.max(distance);
            flux += a.lux[cell] * a.areas[cell];
            other += b.lux[cell] * b.areas[cell];
        }
    }
    let percent = 100.0 * (flux / other - 1.0);
    format!(
        "{} of {} more than {APART} combined standard errors apart, {worst:.1} at most; flux by trace {percent:+.3} %",
        grouped(apart),
        plural(cells, "cell", "cells")
    )
}

/// A pace in words.
fn pace(count: u64, seconds: f64, what: &str) -> String {
    format!(
        "{} {what} in {}, {} per second",
        grouped(count),
        duration(seconds),
        significant(count as f64 / seconds)
    )
}
