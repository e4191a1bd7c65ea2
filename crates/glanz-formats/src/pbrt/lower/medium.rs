//! `MakeNamedMedium` and `MediumInterface`.

use glanz_light::SpectralDistribution;
use glanz_math::DVec3;
use glanz_scene::description::{DensityDescription, MediumDescription};

use super::spectrum::grey;
use super::{EntityState, Lowering};
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{ParseResult, Span};

/// Absorption and scattering of media of version 3 without any, 1/m: those of whole milk in 1/mm.
const DEFAULT_COEFFICIENTS: [[f32; 3]; 2] = [[0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77]];

impl Lowering {
    /// The index of the medium of this name, which may be defined later; `None` for empty space, which has no name.
    pub(crate) fn use_medium(&mut self, name: &str, place: &Span) -> Option<usize> {
        if name.is_empty() {
            return None;
        }
        let media = &mut self.description.media;
        let before = media.len();
        let index = self.media.index_of(name, place, media, || nothing(name, place));
        if media.len() > before {
            // A failure is reported, and ends reading at the next directive.
            let _ = self.spend_entry::<MediumDescription>(name, place);
        }
        Some(index)
    }

    /// Reports media that are used and never defined.
    pub(crate) fn check_media(&mut self) {
        self.media.report_missing("medium", "missing-medium", &mut self.reporter);
    }

    /// Defines a medium with a name; its type is the parameter `type`.
    pub(crate) fn named_medium(
        &mut self,
        name: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<()> {
        let place = list.place;
        let Some(kind) = list.text("type", &mut self.reporter)? else {
            let message = format!("medium {:?} has no \"string type\"", shortened(name));
            return Err(self.reporter.error(&place, "parameter-missing", message));
        };
        list.subject = format!("medium {:?}", shortened(&kind));
        let medium = match kind.as_str() {
            "homogeneous" => self.homogeneous_medium(name, list, context)?,
            "uniformgrid" | "heterogeneous" => self.grid_medium(name, &kind, list, context)?,
            _ => {
                let message = format!("{} is not available yet; empty space stands in", list.subject);
                self.stand_in(&place, "stand-in-medium", message);
                nothing(name, &place)
            }
        };
        self.spend_entry::<MediumDescription>(name, &place)?;
        self.media.define(name, medium, &mut self.description.media);
        Ok(())
    }

    /// The parameters of all media.
    fn coefficients(
        &mut self,
        name: &str,
        list: &mut ParameterList,
        defaults: [SpectralDistribution; 2],
        space: ColorSpace,
    ) -> ParseResult<MediumDescription> {
        let place = list.value_place("preset");
        if let Some(preset) = list.text("preset", &mut self.reporter)? {
            let message = format!(
                "{}: preset {:?} is not available yet; the coefficients of the file or the default stand in",
                list.subject,
                shortened(&preset)
            );
            self.stand_in(&place, "stand-in-medium", message);
        }
        let [absorption, scattering] = defaults;
        let mut coefficient = |name, default| match list.take(name) {
            Some(p) => self.distribution(&list.subject, &p, space),
            None => Ok(default),
        };
        let absorption = coefficient("sigma_a", absorption)?;
        let scattering = coefficient("sigma_s", scattering)?;
        let scale = list.float_or("scale", 1.0, &mut self.reporter)? as f32;
        let g = list.float_or("g", 0.0, &mut self.reporter)?;
        let (name, location) = (name.to_owned(), Some(list.place.location));
        Ok(MediumDescription { name, scale, g, location, ..MediumDescription::new(absorption, scattering) })
    }

    fn homogeneous_medium(
        &mut self,
        name: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<MediumDescription> {
        let defaults = match self.dialect {
            Dialect::V3 => DEFAULT_COEFFICIENTS.map(SpectralDistribution::from),
            Dialect::V4 => [grey(1.0), grey(1.0)],
        };
        let mut medium = self.coefficients(name, &mut list, defaults, context.color_space)?;
        medium.emission_scale = list.float_or("Lescale", 1.0, &mut self.reporter)? as f32;
        if let Some(p) = list.take("Le") {
            medium.emission = self.distribution(&list.subject, &p, context.color_space)?;
            medium.emission_scale *= self.normalisation(p.kind, &medium.emission);
        }
        list.finish(&mut self.reporter);
        Ok(medium)
    }

    fn grid_medium(
        &mut self,
        name: &str,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<MediumDescription> {
        let place = list.place;
        let Some((p, densities)) = list.floats("density", &mut self.reporter)? else {
            let message = format!("{} has no \"float density\"", list.subject);
            return Err(self.reporter.error(&place, "parameter-missing", message));
        };
        let r = &mut self.reporter;
        let mut resolution = [1; 3];
        for (count, name) in resolution.iter_mut().zip(["nx", "ny", "nz"]) {
            *count = list.integer_from(name, 1, r)?.unwrap_or(1);
        }
        let [nx, ny, nz] = resolution.map(u64::from);
        if nx.checked_mul(ny).and_then(|product| product.checked_mul(nz)) != Some(densities.len() as u64) {
            let found = densities.len();
            let message =
                format!("{}: {found} densities are not nx {nx} times ny {ny} times nz {nz}", list.subject);
            return Err(r.error(&p.value_place, "parameter-count", message));
        }
        let corners = [list.vec3("p0", r)?.unwrap_or(DVec3::ZERO), list.vec3("p1", r)?.unwrap_or(DVec3::ONE)];
        for emission in ["Le", "Lescale", "temperature"] {
            let place = list.value_place(emission);
            if list.take(emission).is_some() {
                let message = format!(
                    "{}: {emission:?} is not available yet; a medium without it stands in",
                    list.subject
                );
                self.stand_in(&place, "stand-in-medium", message);
            }
        }
        list.ignore(&["temperaturescale", "temperatureoffset", "temperaturecutoff"]);
        let defaults = match kind {
            "uniformgrid" => [grey(1.0), grey(1.0)],
            _ => DEFAULT_COEFFICIENTS.map(SpectralDistribution::from),
        };
        let medium = self.coefficients(name, &mut list, defaults, context.color_space)?;
        list.finish(&mut self.reporter);
        let values = densities.into_iter().map(|density| density as f32).collect();
        let density = DensityDescription { resolution, values, corners, to_world: context.ctm };
        Ok(MediumDescription { density: Some(density), ..medium })
    }
}

/// A medium that does nothing.
fn nothing(name: &str, place: &Span) -> MediumDescription {
    let location = Some(place.location);
    MediumDescription { name: name.to_owned(), location, ..MediumDescription::new(0.0, 0.0) }
}
