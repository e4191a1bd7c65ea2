//! Grid guides as bytes, see [`crate::guide`].

use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::ShapeParameterization;
use glanz_scene::description::GuideSettings;

use super::{FittedCells, GridGuide, GridSums};
use crate::codec::{Decoder, Encoder};

/// Codes of a chart, and of a cell or its sums.
const NOTHING: u8 = 0;
const PARAMETERS: u8 = 1;
const PROJECTIONS: u8 = 2;
const SOMETHING: u8 = 1;

/// Appends the guide.
pub(crate) fn encode_grid(e: &mut Encoder, guide: &GridGuide) {
    e.text(&guide.settings.to_string());
    e.u32(guide.passes);
    e.u32(guide.parameterizations.len() as u32);
    for parameterization in &guide.parameterizations {
        let (tag, numbers) = match parameterization {
            None => (NOTHING, Vec::new()),
            Some((ShapeParameterization::Parameters { min, max }, _)) => {
                (PARAMETERS, [min.to_array(), max.to_array()].concat())
            }
            Some((ShapeParameterization::Projections(bounds), _)) => {
                (PROJECTIONS, [bounds.min.to_array(), bounds.max.to_array()].concat())
            }
        };
        e.u8(tag);
        numbers.into_iter().for_each(|number| e.f64(number));
    }
    for cell in &guide.cells {
        e.u8(if cell.is_some() { SOMETHING } else { NOTHING });
        let coefficients = cell.iter().flat_map(|learnt| &learnt.coefficients);
        coefficients.for_each(|coefficient| e.u32(coefficient.to_bits()));
    }
}

/// Reads the output of [`encode_grid`]; `None` if malformed.
pub(crate) fn decode_grid(d: &mut Decoder<'_>) -> Option<GridGuide> {
    let GuideSettings::Grid(settings) = d.text()?.parse().ok()? else { return None };
    let passes = d.u32()?;
    let mut parameterizations = Vec::new();
    for _ in 0..d.u32()? {
        parameterizations.push(decode_chart(d)?);
    }
    // Every cell has at least one byte; checked before the cells are allocated.
    let sheets: u64 = parameterizations
        .iter()
        .flatten()
        .map(|parameterization: &ShapeParameterization| u64::from(parameterization.sheets()))
        .sum();
    let cells = sheets * u64::from(settings.cells) * u64::from(settings.cells);
    if cells > d.0.len() as u64 {
        return None;
    }
    let mut guide = GridGuide::from_charts(parameterizations, &settings, passes).ok()?;
    let functions = guide.basis().len();
    for i in 0..guide.cells.len() {
        if d.u8()? == NOTHING {
            continue;
        }
        let (words, _) = d.take(4 * functions)?.as_chunks::<4>();
        let coefficients = words.iter().map(|word| f32::from_bits(u32::from_le_bytes(*word))).collect();
        let learnt = FittedCells::new(guide.basis(), coefficients)?;
        *guide.cells.get_mut(i)? = Some(learnt);
    }
    Some(guide)
}

fn decode_chart(d: &mut Decoder<'_>) -> Option<Option<ShapeParameterization>> {
    Some(match d.u8()? {
        NOTHING => None,
        PARAMETERS => Some(ShapeParameterization::Parameters {
            min: DVec2::new(d.f64()?, d.f64()?),
            max: DVec2::new(d.f64()?, d.f64()?),
        }),
        PROJECTIONS => Some(ShapeParameterization::Projections(Bounds3 {
            min: DVec3::new(d.f64()?, d.f64()?, d.f64()?),
            max: DVec3::new(d.f64()?, d.f64()?, d.f64()?),
        })),
        _ => return None,
    })
}

/// Appends sums.
pub(crate) fn encode_sums(e: &mut Encoder, sums: &GridSums) {
    for cell in 0..sums.shape().0 as u32 {
        let words = sums.cell(cell);
        e.u8(if words.is_some() { SOMETHING } else { NOTHING });
        for (count, light) in words.into_iter().flatten() {
            e.u64(count);
            e.u64(light);
        }
    }
}

/// Reads the output of [`encode_sums`] for sums of `guide`; `None` if malformed.
pub(crate) fn decode_sums(d: &mut Decoder<'_>, guide: &GridGuide) -> Option<GridSums> {
    let mut sums = guide.sums();
    let (cells, functions) = sums.shape();
    for cell in 0..cells as u32 {
        if d.u8()? == NOTHING {
            continue;
        }
        let (words, _) = d.take(16 * functions)?.as_chunks::<16>();
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n: u64, &b| n << 8 | u64::from(b));
        sums.set_cell(cell, words.iter().map(|w| (number(&w[..8]), number(&w[8..]))));
    }
    Some(sums)
}
