//! How light converges, step by step (as @cohen1988 compare it).

use glanz_light::Spectrum;
use glanz_radiosity::elements::Elements;
use glanz_radiosity::form_factor::FormFactors;
use glanz_radiosity::solve::{GaussSeidel, gauss_seidel};

use super::field::error_of;
use super::progressive::Progressive;
use crate::study::{Settings, StudyError};

/// Light that is left in the end.
const LEFT: f64 = 1e-3;

/// Steps at most, per element.
const STEPS: usize = 20;

/// Points are this factor apart, or a step.
const APART: f64 = 1.05;

/// Sweeps of Gauss and Seidel's method that are shown.
const SWEEPS: u32 = 8;

/// Errors after steps: elements that shot, or that gathered.
pub(super) struct Descent {
    pub(super) elements: usize,
    pub(super) shooting: Vec<[f64; 2]>,
    pub(super) with_ambient: Vec<[f64; 2]>,
    pub(super) gathering: Vec<[f64; 2]>,
    /// Of the flux of the lamps, what is left after each of the steps of `shooting`.
    pub(super) left: Vec<f64>,
}

/// Solves with form factors that are known, against `end`, where nothing changes any more.
///
/// # Errors
/// An end that was wanted.
pub(super) fn descent(
    elements: &Elements<'_>,
    factors: &FormFactors,
    end: &[Spectrum],
    settings: &Settings,
) -> Result<Descent, StudyError> {
    let list = &elements.list;
    let error = |found: &[Spectrum]| error_of(list, found, end);
    let mut shot = Progressive::new(elements);
    let mut made = Descent {
        elements: list.len(),
        shooting: Vec::new(),
        with_ambient: Vec::new(),
        gathering: Vec::new(),
        left: Vec::new(),
    };
    let mut next = 1.0;
    for step in 1..=STEPS * list.len() {
        if !shot.shoot_known(elements, factors) {
            break;
        }
        if step as f64 >= next {
            settings.cancel.check()?;
            next = (step as f64 * APART).max(next + 1.0);
            let left = shot.left(elements);
            made.shooting.push([step as f64, error(shot.radiosity())]);
            made.with_ambient.push([step as f64, error(&shot.with_ambient(elements))]);
            made.left.push(left);
            if left <= LEFT {
                break;
            }
        }
    }
    for sweeps in 1..=SWEEPS {
        let way = GaussSeidel { tolerance: 0.0, sweeps };
        let solved = gauss_seidel(list, factors, &way, &settings.cancel)?;
        made.gathering.push([(sweeps as usize * list.len()) as f64, error(&solved.radiosity)]);
    }
    Ok(made)
}

impl Descent {
    /// Steps after which an error stays below `error`, if it does.
    pub(super) fn steps_to(curve: &[[f64; 2]], error: f64) -> Option<f64> {
        let above = curve.iter().rposition(|point| point[1] > error);
        curve.get(above.map_or(0, |place| place + 1)).map(|point| point[0])
    }
}
