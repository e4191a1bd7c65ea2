//! Writing of EULUMDAT files.

use super::{Header, PhotometryWriteError, PlaneSelection, digits, one_line};
use crate::photometry::{IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};

const MILLIMETRES: f64 = 1000.0;

/// Largest number of characters of a line of text.
const WORDS: usize = 78;

/// Largest interval of gamma, in degrees, for integrating the downward fraction of the flux: the error of three points
/// is far below the two decimals of per cent that are written.
const STRETCH: f64 = 5.0;

/// A file of EULUMDAT for absolute photometry: -1 lamps whose flux is that of the luminaire, light output ratio 100 %,
/// intensities in cd per 1000 lm of that flux.
///
/// Luminaire and luminous area have the size of [`Header::opening`] if the format supports its shape: a circle, an
/// upright round cylinder, a rectangle or a box; other shapes are written as the box around them. The ten direct
/// ratios, which are unknown, are 0. Text is Latin-1, with question marks for other characters, and
/// the equals sign of a `TILT=` at the beginning of a line becomes a blank, because it marks LM-63 files. Watts that are not a
/// finite number above 0 are written as 0.
///
/// # Errors
/// [`PhotometryWriteError`].
///
/// # Source
/// @stockmar1990; -1 lamps for absolute photometry as agreed between makers of lighting programs in 2009.
pub fn ldt(distribution: &IntensityDistribution, header: &Header) -> Result<Vec<u8>, PhotometryWriteError> {
    let flux = distribution.flux();
    let planes = EulumdatPlanes::of(distribution)?;
    if flux.is_nan() || flux <= 0.0 {
        return Err(PhotometryWriteError::Dark);
    }
    let mut lines = head(distribution, header, &planes);
    lines.extend([
        format!("{:.2}", 100.0 * downward(distribution)),
        // Light output ratio, conversion factor, tilt, sets of lamps, lamps.
        "100".into(),
        "1".into(),
        "0".into(),
        "1".into(),
        "-1".into(),
        "LED".into(),
        flux.to_string(),
        // Colour and colour rendering.
        String::new(),
        String::new(),
        if header.watts.is_finite() { header.watts.max(0.0) } else { 0.0 }.to_string(),
    ]);
    lines.extend(std::iter::repeat_n("0".to_owned(), 10));
    lines.extend(planes.listed.iter().map(f64::to_string));
    lines.extend(distribution.polars().iter().map(f64::to_string));
    for plane in &planes.stored {
        lines.extend(distribution.plane(*plane).iter().map(|candela| digits(candela * 1000.0 / flux)));
    }
    let text = lines.join("\r\n") + "\r\n";
    Ok(text.chars().map(|letter| u8::try_from(letter).unwrap_or(b'?')).collect())
}

/// The lines before the flux downwards.
fn head(distribution: &IntensityDistribution, header: &Header, planes: &EulumdatPlanes) -> Vec<String> {
    let names = &header.names;
    let words = |words: &str| {
        let line = one_line(words, WORDS);
        // A line with this beginning distinguishes LM-63 from EULUMDAT.
        let is_tilt = line.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("TILT="));
        if is_tilt { line.replacen('=', " ", 1) } else { line }
    };
    let (kind, indicator) = match planes.symmetry {
        Symmetry::Axial => (1, 1),
        Symmetry::None => (3, 0),
        Symmetry::AcrossY => (3, 2),
        Symmetry::AcrossX => (3, 3),
        Symmetry::Quadrants => (3, 4),
    };
    let [length, width, height] = sizes(header.opening);
    let mut lines = vec![
        words(&names.manufacturer),
        kind.to_string(),
        indicator.to_string(),
        planes.listed.len().to_string(),
        distance(&planes.listed).to_string(),
        distribution.polars().len().to_string(),
        distance(distribution.polars()).to_string(),
        words(&names.report),
        words(&names.luminaire),
        words(&names.catalog_number),
        // The name of the file, which is arbitrary.
        String::new(),
        words(&names.issued),
    ];
    // Size of the luminaire, of the luminous area, and of its four sides.
    let all = [length, width, height, length, width, height, height, height, height];
    lines.extend(all.map(|size| size.to_string()));
    lines
}

/// EulumdatPlanes as EULUMDAT has them.
struct EulumdatPlanes {
    symmetry: Symmetry,
    /// C angles of all planes, degrees, without the one that closes the round.
    listed: Vec<f64>,
    /// Numbers of the planes that are stored, in order.
    stored: Vec<usize>,
}

impl EulumdatPlanes {
    fn of(distribution: &IntensityDistribution) -> Result<Self, PhotometryWriteError> {
        let PlaneSelection { symmetry, mut planes } = PlaneSelection::of(distribution)?;
        let azimuths = distribution.azimuths();
        let listed: Vec<f64> = azimuths.iter().copied().filter(|c| *c < 360.0).collect();
        match symmetry {
            // From C270 through C0 to C90; the other half is equal.
            Symmetry::AcrossX => {
                let planes_of = |of: fn(f64) -> bool| {
                    let numbered = azimuths.iter().enumerate();
                    numbered.filter(move |(_, c)| of(**c)).map(|(i, _)| i)
                };
                planes = planes_of(|c| (270.0..360.0).contains(&c)).chain(planes_of(|c| c <= 90.0)).collect();
            }
            Symmetry::None => planes.truncate(listed.len()),
            _ => {}
        }
        Ok(Self { symmetry, listed, stored: planes })
    }
}

/// The distance between neighbours if it is constant, else 0.
fn distance(angles: &[f64]) -> f64 {
    let mut steps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    let first = steps.next().unwrap_or(0.0);
    // Differences of two numbers up to 360.
    let rounding = 2.0 * 360.0 * f64::EPSILON;
    if steps.all(|step| (step - first).abs() <= rounding) { first } else { 0.0 }
}

/// Length (along y), width (along x, 0 if round) and height in millimetres, to a thousandth.
fn sizes(opening: LuminousOpening) -> [f64; 3] {
    let [x, y, z] = opening.size.map(|size| if size.is_finite() { size.max(0.0) } else { 0.0 });
    let is_round = matches!(opening.shape, OpeningShape::Ellipse | OpeningShape::VerticalCylinder) && x == y;
    let sizes = match opening.shape {
        OpeningShape::Point => [0.0; 3],
        _ => [y, if is_round { 0.0 } else { x }, z],
    };
    sizes.map(|metres| (metres * MILLIMETRES * 1000.0).round() / 1000.0)
}

/// The fraction of the flux below the horizontal.
fn downward(distribution: &IntensityDistribution) -> f64 {
    // Gauss-Legendre with three points.
    let nodes = [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)];
    let azimuths = distribution.azimuths();
    let last = azimuths.len() - 1;
    // Linear in azimuth: the weight of a plane is half of the adjacent steps.
    let weight = |i: usize| {
        let at = |i: usize| azimuths.get(i).copied().unwrap_or(0.0);
        if last == 0 { 1.0 } else { at((i + 1).min(last)) - at(i.saturating_sub(1)) }
    };
    let (mut below, mut whole) = (0.0, 0.0);
    for pair in distribution.polars().windows(2) {
        let count = ((pair[1] - pair[0]) / STRETCH).ceil().max(1.0) as u32;
        let half = 0.5 * (pair[1] - pair[0]) / f64::from(count);
        for middle in (0..count).map(|n| pair[0] + half * f64::from(2 * n + 1)) {
            for (node, share) in nodes {
                let gamma = middle + half * node;
                let of = |(i, &c): (usize, &f64)| weight(i) * distribution.at(c, gamma);
                let mean: f64 = azimuths.iter().enumerate().map(of).sum();
                let flux = share * half * gamma.to_radians().sin() * mean;
                whole += flux;
                below += if gamma < 90.0 { flux } else { 0.0 };
            }
        }
    }
    below / whole
}
