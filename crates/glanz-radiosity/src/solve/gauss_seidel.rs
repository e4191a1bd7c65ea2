//! All elements gather from all, over and over.

use glanz_job::{CancelFlag, Interrupted};
use glanz_light::Spectrum;

use crate::elements::Element;
use crate::form_factor::FormFactors;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussSeidel {
    /// Largest change of an element in a sweep, per the largest radiosity.
    pub tolerance: f64,
    /// Sweeps at most.
    pub sweeps: u32,
}

impl Default for GaussSeidel {
    fn default() -> Self {
        Self { tolerance: 1e-6, sweeps: 1000 }
    }
}

/// A solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Radiosity of each element: what leaves a unit of its area, in units of radiance times pi.
    pub radiosity: Vec<Spectrum>,
    /// Sweeps that were made.
    pub sweeps: u32,
    /// Change in the last of them, per the largest radiosity.
    pub change: f64,
}

/// Gauss and Seidel's method: each sweep uses what it has found itself (@cohen1993 section 5.3).
///
/// It converges, as every element reflects less than it receives; more slowly, the lighter the room.
///
/// # Errors
/// [`Interrupted`] if `cancel` is raised, which is checked after each sweep.
pub fn gauss_seidel(
    elements: &[Element],
    factors: &FormFactors,
    settings: &GaussSeidel,
    cancel: &CancelFlag,
) -> Result<Solved, Interrupted> {
    let mut radiosity: Vec<Spectrum> = elements.iter().map(|element| element.emission).collect();
    let (mut sweeps, mut change) = (0, f64::INFINITY);
    while sweeps < settings.sweeps && change > settings.tolerance {
        let (mut most_changed, mut largest) = (0.0_f32, 0.0_f32);
        for (i, element) in elements.iter().enumerate() {
            let mut received = Spectrum::BLACK;
            for &(j, factor) in factors.row(i) {
                if let Some(&sent) = radiosity.get(j as usize) {
                    received += sent * factor;
                }
            }
            let new = element.emission + element.reflectance * received;
            if let Some(old) = radiosity.get_mut(i) {
                most_changed = most_changed.max((new - *old).map(f32::abs).max_component());
                largest = largest.max(new.max_component());
                *old = new;
            }
        }
        sweeps += 1;
        change = if largest > 0.0 { f64::from(most_changed / largest) } else { 0.0 };
        cancel.check()?;
    }
    Ok(Solved { radiosity, sweeps, change })
}
