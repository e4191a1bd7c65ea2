//! `LightSource "photometric"`: a luminaire from a photometric file.

use std::sync::Arc;

use glanz_light::intensity::{Opening, OpeningShape};
use glanz_math::DVec3;
use glanz_scene::description::LightKind;

use super::light::Lit;
use super::spectrum::{Emission, grey};
use super::{Context, Lowering};
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::photometry::{self, Fault, Photometry, PhotometryFile};
use crate::source::Step;

impl Lowering {
    /// The light of an IES or EULUMDAT file.
    pub(super) fn photometric(&mut self, list: &mut ParameterList, context: &Context) -> Step<Lit> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = "light \"photometric\" has no \"string filename\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let from = list.vec3("from", &mut self.reporter)?.unwrap_or(DVec3::ZERO);
        let emission = self.color_and_scale(list, context)?;
        let mut photometry = self.photometry(&p, &name)?;
        self.choose_lamps(list, &mut photometry)?;
        self.tilt(list, &mut photometry)?;
        self.scale_to_lumens(list, &mut photometry)?;
        if photometry.flux() <= 0.0 {
            let message = format!("light \"photometric\": {name:?} has no light");
            self.reporter.warning(&p.value_place, "photometry", message);
        }
        let opening = self.opening(list, &photometry)?;
        let distribution = Arc::new(photometry.distribution);
        Ok((LightKind::Photometric { distribution, opening, from }, emission))
    }

    /// `color`, of which the magnitude does not count, and `scale`.
    fn color_and_scale(&mut self, list: &mut ParameterList, context: &Context) -> Step<Emission> {
        let spectrum = match list.take("color") {
            Some(p) => self.distribution(&list.subject, &p, context.color_space)?,
            None => grey(1.0),
        };
        let factor = list.float_or("scale", 1.0, &mut self.reporter)? as f32;
        Ok(Emission { spectrum, factor, normalisation: 1.0 })
    }

    /// Reads the file, and that of its tilt data if it names one.
    fn photometry(&mut self, p: &Parameter, name: &str) -> Step<Photometry> {
        let (path, bytes) = match self.read_file(name) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("light \"photometric\": {problem}");
                return Err(self.reporter.error(&p.value_place, "missing-file", message));
            }
        };
        let read = photometry::read_with(&bytes, &mut |tilt| self.read_file(tilt).map(|(_, bytes)| bytes));
        let message = |fault: &Fault| format!("light \"photometric\": {}:{fault}", path.display());
        let help = |fault: &Fault| fault.kind.help().map(str::to_owned);
        match read {
            Ok(PhotometryFile { photometry, warnings }) => {
                for fault in &warnings {
                    let r = &mut self.reporter;
                    r.warning_with_help(&p.value_place, "photometry", message(fault), help(fault));
                }
                Ok(photometry)
            }
            Err(fault) => {
                let r = &mut self.reporter;
                Err(r.error_with_help(&p.value_place, "photometry", message(&fault), help(&fault)))
            }
        }
    }

    /// `lamps`: which set of an EULUMDAT file.
    fn choose_lamps(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> Step<()> {
        let place = list.value_place("lamps");
        let Some(set) = list.integer_from("lamps", 0, &mut self.reporter)?.filter(|&set| set > 0) else {
            return Ok(());
        };
        match photometry.with_lamps(set as usize) {
            Some(changed) => *photometry = changed,
            None => {
                let count = photometry.lamps.len();
                let message = format!(
                    "light \"photometric\": there is no set of lamps {set} with a flux, the file has {count}"
                );
                let help = Some("sets are counted from 0; only EULUMDAT files have several".to_owned());
                return Err(self.reporter.error_with_help(&place, "parameter-range", message, help));
            }
        }
        Ok(())
    }

    /// `tilt`: degrees that the lamp is turned by, for files that say what that does.
    fn tilt(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> Step<()> {
        let place = list.value_place("tilt");
        let Some(degrees) = list.float("tilt", &mut self.reporter)? else { return Ok(()) };
        let Some(factor) = photometry.tilt.as_ref().map(|tilt| tilt.factor(degrees)) else {
            let message = "light \"photometric\": its file has no tilt data, \"tilt\" changes nothing";
            self.reporter.warning(&place, "photometry", message);
            return Ok(());
        };
        self.scale(&place, photometry.scaled_by(factor), photometry, &format!("the tilt factor {factor}"))
    }

    /// `lumens`: what the luminaire gives in all, in place of what its file says.
    fn scale_to_lumens(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> Step<()> {
        let place = list.value_place("lumens");
        let Some(lumens) = list.float("lumens", &mut self.reporter)? else { return Ok(()) };
        self.scale(&place, photometry.scaled_to(lumens), photometry, &format!("{lumens} lm"))
    }

    fn scale(
        &mut self,
        place: &crate::source::Place,
        scaled: Option<Photometry>,
        photometry: &mut Photometry,
        what: &str,
    ) -> Step<()> {
        match scaled {
            Some(scaled) => *photometry = scaled,
            None => {
                let message = format!("light \"photometric\": {what} cannot be had from this luminaire");
                return Err(self.reporter.error(place, "parameter-range", message));
            }
        }
        Ok(())
    }

    /// `as`: a point or the luminous opening.
    fn opening(&mut self, list: &mut ParameterList, photometry: &Photometry) -> Step<Option<Opening>> {
        let Some((p, kind)) = list.text_parameter("as", &mut self.reporter)? else { return Ok(None) };
        let Opening { shape, size } = photometry.opening;
        match kind.as_str() {
            "point" => Ok(None),
            "area" if shape == OpeningShape::Point || size == [0.0; 3] => {
                let message = "light \"photometric\": its file states no size; a point stands in";
                self.reporter.warning(&p.value_place, "photometry", message);
                Ok(None)
            }
            "area" => Ok(Some(photometry.opening)),
            other => {
                let message = format!("light \"photometric\": {:?} is not known as \"as\"", shortened(other));
                let help = Some("a luminaire shines as a point or as an area".to_owned());
                Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help))
            }
        }
    }
}
