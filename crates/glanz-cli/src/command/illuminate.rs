//! `glanz illuminate`: how much light arrives where.

use glanz_illumination::Tally;
use glanz_illumination::report::{LuxComparison, LuxReport};
use serde::Serialize;

use crate::Ending;
use crate::arguments::IlluminateArguments;
use crate::checkpoint_file;
use crate::illumination::{Design, Found, check_goal, far_field_file, files};
use crate::interrupt;
use crate::messages::{Failure, Messages};
use crate::outputs;
use crate::report;

/// What `--json` prints.
#[derive(Serialize)]
struct Told<'a> {
    scenes: Vec<String>,
    outputs: Vec<String>,
    designs: Vec<&'a LuxReport>,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Illuminates the scene file.
///
/// # Errors
/// Why there is no result.
pub(crate) fn run(arguments: &IlluminateArguments, messages: Messages) -> Result<Ending, Failure> {
    let cancel = interrupt::listen()?;
    check_goal(arguments)?;
    for path in &arguments.far_field {
        far_field_file::check(path)?;
        outputs::check_writable(path)?;
    }
    checkpoint_file::check(arguments.checkpoint.as_deref(), arguments.resume)?;
    files::make_folder(&arguments.output)?;
    crate::baking::use_threads(arguments.threads)?;
    let mut paths = vec![arguments.scene.as_path()];
    paths.extend(arguments.compare.as_deref());
    let (mut found, mut warnings) = (Vec::new(), Vec::new());
    for path in &paths {
        let mut design = Design::read(path, arguments, messages)?;
        let Some(one) = design.illuminate(arguments, messages, &cancel)? else {
            messages.note("interrupted; nothing was written");
            return Ok(Ending::Interrupted);
        };
        warnings.extend(design.file.into_warnings());
        found.push(one);
    }
    let written = written(arguments, &mut found)?;
    let interrupted = found.iter().any(|one| one.interrupted);
    if !arguments.talk.quiet && !arguments.talk.json {
        tell(&found)?;
    }
    messages.note(&format!("wrote {} and {} more files", written[0], written.len() - 1));
    if arguments.talk.json {
        report::print(&Told {
            scenes: paths.iter().map(|path| path.display().to_string()).collect(),
            outputs: written,
            designs: found.iter().map(|one| &one.report).collect(),
            peak_memory_bytes: report::peak_memory_bytes(),
            warnings,
        })?;
    }
    Ok(if interrupted { Ending::Interrupted } else { Ending::Done })
}

/// Prints the summary.
fn tell(found: &[Found]) -> Result<(), Failure> {
    match found {
        [a, b] => report::print_text(&LuxComparison::between(&a.report, &b.report).text()),
        _ => found.iter().try_for_each(|one| report::print_text(&one.report.text())),
    }
}

/// Writes all files; returns their names.
fn written(arguments: &IlluminateArguments, found: &mut [Found]) -> Result<Vec<String>, Failure> {
    let folder = arguments.output.as_path();
    match found {
        [a, b] => {
            let mut written = Vec::new();
            let comparison = LuxComparison::between(&a.report, &b.report);
            files::write(&folder.join("comparison.html"), comparison.html().as_bytes(), &mut written)?;
            files::write(&folder.join("comparison.txt"), comparison.text().as_bytes(), &mut written)?;
            written.extend(files::write_all(&folder.join("a"), a)?);
            written.extend(files::write_all(&folder.join("b"), b)?);
            Ok(written)
        }
        [one, ..] => {
            let far_field = one.tally.as_ref().and_then(Tally::far_field);
            if let Some(far) = &far_field {
                one.report.polars.push(far_field_file::polar(&one.report.title, far));
            }
            let mut written = files::write_all(folder, one)?;
            if let Some(far) = &far_field {
                for path in &arguments.far_field {
                    let bytes = far_field_file::bytes(path, &one.report.title, far)?;
                    files::write(path, &bytes, &mut written)?;
                }
            }
            Ok(written)
        }
        [] => Ok(Vec::new()),
    }
}
