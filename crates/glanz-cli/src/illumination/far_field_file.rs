//! Candela distributions of whole optics as photometric files.

use std::path::Path;

use glanz_formats::photometry::write::{self, Header};
use glanz_formats::photometry::{AngularSystem, Distribution, Names, Symmetry};
use glanz_illumination::FarField;
use glanz_illumination::report::PolarPlot;

use crate::messages::Failure;

/// Formats of photometric files that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ies,
    Ldt,
}

fn format(path: &Path) -> Option<Format> {
    let extension = path.extension()?;
    if extension.eq_ignore_ascii_case("ies") {
        return Some(Format::Ies);
    }
    extension.eq_ignore_ascii_case("ldt").then_some(Format::Ldt)
}

/// Refuses names of other formats.
///
/// # Errors
/// Why.
pub(crate) fn check(path: &Path) -> Result<(), Failure> {
    if format(path).is_some() {
        return Ok(());
    }
    Err(Failure::usage(format!("{}: no format for luminaires has this extension", path.display()))
        .with_help("candela distributions are written as .ldt or .ies"))
}

/// The distribution as lighting people draw it.
pub(crate) fn polar(title: &str, far: &FarField) -> PolarPlot {
    let (planes, gammas) = (far.grid.planes().len(), far.grid.gammas().len());
    let candela = |c: f64, gamma: f64| {
        let plane = (c / 360.0 * planes as f64).round() as usize;
        let place = gamma / 180.0 * (gammas - 1) as f64;
        let (low, share) = (place.floor() as usize, place.fract());
        far.at(plane, low) * (1.0 - share) + far.at(plane, (low + 1).min(gammas - 1)) * share
    };
    PolarPlot::sample(format!("{title}: light that leaves the scene"), None, candela)
}

/// The bytes of the file `path`.
///
/// # Errors
/// Why it cannot say this distribution.
pub(crate) fn bytes(path: &Path, title: &str, far: &FarField) -> Result<Vec<u8>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", path.display()));
    let (mut planes, gammas) = (far.grid.planes(), far.grid.gammas());
    // The first plane again closes the round.
    planes.push(360.0);
    let rows = (0..planes.len()).flat_map(|plane| (0..gammas.len()).map(move |gamma| far.at(plane, gamma)));
    let candela = rows.collect();
    let distribution = Distribution::try_new(AngularSystem::C, Symmetry::None, &planes, gammas, candela)
        .map_err(|error| failed(&error))?;
    let program = format!("Glanz {}", env!("CARGO_PKG_VERSION"));
    let names = Names { luminaire: title.to_owned(), ..Names::default() };
    let header = Header { names, laboratory: program, ..Header::default() };
    let written = match format(path) {
        Some(Format::Ies) => write::ies(&distribution, &header),
        _ => write::ldt(&distribution, &header),
    };
    written.map_err(|error| failed(&error))
}
