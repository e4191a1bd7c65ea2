//! A system of lenses, through which rays are traced from the film.
//!
//! The film is the plane z = 0; the interfaces are at z > 0, the scene behind them. As the picture on the film is upside down and mirrored, the
//! point of the film for a point of the screen is its opposite.

mod exit_pupil;
mod interface;
mod paraxial;
mod stop;

use std::sync::Arc;

use glanz_math::{DVec2, Ray};

use crate::description::{LensDescription, StopShape};
use exit_pupil::ExitPupil;
use interface::LensInterface;
use paraxial::ThickLens;
use stop::LensStop;

/// Most blades of a stop: every ray is compared with all of them.
const MOST_BLADES: u32 = 256;

/// Errors of lens systems: the parameter, its value and its range.
pub(super) type LensRangeError = (&'static str, f64, &'static str);

/// A system of lenses in front of a film.
///
/// # Source
/// @kolb1995; @pharr2023 section 5.4. Departures: the focus follows from matrices of paraxial rays instead of two traced ones, and the bounds of
/// the exit pupil contain that of stops with circular openings, so that they hold in all directions from the middle of the film.
#[derive(Clone, Debug)]
pub struct RealisticLens {
    /// From the scene to the film.
    interfaces: Arc<[LensInterface]>,
    stop: LensStop,
    pupil: ExitPupil,
    relative_weights: bool,
}

impl RealisticLens {
    /// `diagonal`: of the film, metres.
    pub(super) fn try_new(lens: &LensDescription, diagonal: f64) -> Result<Self, LensRangeError> {
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            return Err(("diagonal of the film", diagonal, "positive"));
        }
        check_stop(lens.stop)?;
        let interfaces = interface::interfaces(lens)?;
        let distance = ThickLens::try_new(&interfaces)?.film_distance(lens.focus_distance)?;
        let interfaces = interface::moved(interfaces, distance);
        let pupil = ExitPupil::new(&interfaces, 0.5 * diagonal);
        let stop = LensStop::new(lens.stop);
        Ok(Self { interfaces: interfaces.into(), stop, pupil, relative_weights: lens.relative_weights })
    }

    /// The ray that leaves the lens towards the scene, for a point of the screen (metres on the film), and its weight; `None` if it is stopped.
    ///
    /// `xi`: two numbers uniform in [0, 1) that select the point of the exit pupil, from the bounds for the point `pupil_of` of the screen: `screen` itself, or a neighbour
    /// whose ray goes through the same point. The mean of weight times radiance is the irradiance of the film,
    /// or with relative weights that over (d / z)^2, for the exit pupil of diameter d at the distance z from the middle of the film.
    #[must_use]
    pub fn ray(&self, screen: DVec2, pupil_of: DVec2, xi: DVec2) -> Option<(Ray, f64)> {
        let film = -screen;
        let (on_plane, area) = self.pupil.sample(-pupil_of, xi);
        let (start, target) = (film.extend(0.0), on_plane.extend(self.pupil.plane));
        let inside = Ray::new(start, (target - start).normalize());
        let (outside, transmittance) = interface::trace(&self.interfaces, &self.stop, inside)?;
        let cos2 = inside.direction.z * inside.direction.z;
        let unit =
            if self.relative_weights { self.pupil.middle_area } else { self.pupil.plane * self.pupil.plane };
        Some((outside, transmittance * cos2 * cos2 * area / unit))
    }
}

/// Refuses blades without number or direction.
fn check_stop(stop: StopShape) -> Result<(), LensRangeError> {
    match stop {
        StopShape::Iris(iris) if iris.blades > MOST_BLADES => {
            Err(("number of blades", f64::from(iris.blades), "at most 256"))
        }
        StopShape::Iris(iris) if !iris.rotation.is_finite() => {
            Err(("rotation of the blades", iris.rotation, "finite"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
