//! Gauss-Seidel method with the form factors of all pairs of elements.

use glanz_job::{CancelFlag, Interrupted};
use glanz_light::Spectrum;

use crate::elements::Element;
use crate::form_factor::FormFactors;

/// Stopping criteria of the Gauss-Seidel method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussSeidelSettings {
    /// Change of an element in a sweep, relative to the largest radiosity, at which sweeps end.
    pub tolerance: f64,
    /// Largest number of sweeps.
    pub sweeps: u32,
}

impl Default for GaussSeidelSettings {
    fn default() -> Self {
        Self { tolerance: 1e-6, sweeps: 1000 }
    }
}

/// Radiosity of all elements by the Gauss-Seidel method.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussSeidelSolution {
    /// Radiosity of each element (the flux that leaves it per area), in units of radiance times pi.
    pub radiosity: Vec<Spectrum>,
    /// Number of sweeps.
    pub sweeps: u32,
    /// Largest change of an element in the last sweep, relative to the largest radiosity.
    pub change: f64,
}

/// Solves by the Gauss-Seidel method, which uses the new values of a sweep within it.
///
/// It converges because every element reflects less than it receives; the higher the reflectances, the more slowly.
///
/// # Errors
/// [`Interrupted`] if `cancel` is raised; it is checked after each sweep.
///
/// # Source
/// @cohen1993 section 5.3.
pub fn gauss_seidel(
    elements: &[Element],
    factors: &FormFactors,
    settings: &GaussSeidelSettings,
    cancel: &CancelFlag,
) -> Result<GaussSeidelSolution, Interrupted> {
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
    Ok(GaussSeidelSolution { radiosity, sweeps, change })
}
