//! Convergence of light step by step (as compared by @cohen1988).

use glanz_light::Spectrum;
use glanz_radiosity::elements::Elements;
use glanz_radiosity::form_factor::FormFactors;
use glanz_radiosity::solve::{GaussSeidelSettings, gauss_seidel};

use super::field::error_of;
use super::progressive::Progressive;
use crate::study::{Settings, StudyError};

/// Share of unshot light at the end.
const LEFT: f64 = 1e-3;

/// Largest number of steps per element.
const STEPS: usize = 20;

/// Factor between the steps of two points, at least one step.
const APART: f64 = 1.05;

/// Number of sweeps of the Gauss-Seidel method.
const SWEEPS: u32 = 8;

/// Errors over steps: elements that have shot or gathered.
pub(super) struct Descent {
    pub(super) elements: usize,
    pub(super) shooting: Vec<[f64; 2]>,
    pub(super) with_ambient: Vec<[f64; 2]>,
    pub(super) gathering: Vec<[f64; 2]>,
    /// Share of the lamps' flux that is unshot after each of the steps of `shooting`.
    pub(super) left: Vec<f64>,
}

/// Solves with known form factors and compares with `end`, the converged solution.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(super) fn descent(
    elements: &Elements<'_>,
    factors: &FormFactors,
    end: &[Spectrum],
    settings: &Settings,
) -> Result<Descent, StudyError> {
    let list = &elements.list;
    let error = |found: &[Spectrum]| error_of(list, found, end);
    let mut shot = Progressive::new(elements);
    let mut curves = Descent {
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
            curves.shooting.push([step as f64, error(shot.radiosity())]);
            curves.with_ambient.push([step as f64, error(&shot.with_ambient(elements))]);
            curves.left.push(left);
            if left <= LEFT {
                break;
            }
        }
    }
    for sweeps in 1..=SWEEPS {
        let method = GaussSeidelSettings { tolerance: 0.0, sweeps };
        let solution = gauss_seidel(list, factors, &method, &settings.cancel)?;
        curves.gathering.push([(sweeps as usize * list.len()) as f64, error(&solution.radiosity)]);
    }
    Ok(curves)
}

impl Descent {
    /// Number of steps after which the error stays below `error`; `None` if it does not.
    pub(super) fn steps_to(curve: &[[f64; 2]], error: f64) -> Option<f64> {
        let above = curve.iter().rposition(|point| point[1] > error);
        curve.get(above.map_or(0, |place| place + 1)).map(|point| point[0])
    }
}
