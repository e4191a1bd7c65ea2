//! `LightSource "photometric"`: a luminaire from a photometric file.

use std::path::Path;
use std::sync::Arc;

use glanz_job::{Resource, ResourceBudget};
use glanz_light::intensity::{LuminousOpening, OpeningShape};
use glanz_math::DVec3;
use glanz_scene::description::{LightKind, LuminaireDescription, SourceRay};

use super::light::LightParts;
use super::spectrum::{EmissionParameters, grey};
use super::{EntityState, Lowering};
use crate::file_list::FileKind;
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::photometry::tm25::{MAGIC, RayReader};
use crate::photometry::{self, Photometry, PhotometryError, PhotometryFile};
use crate::source::{MISSING_FILE, ParseResult};

impl Lowering {
    /// Lowers a light with an IES or EULUMDAT file, which describes its `luminaire`, or with rays.
    pub(super) fn photometric(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
        luminaire: &mut Option<Arc<LuminaireDescription>>,
    ) -> ParseResult<LightParts> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = "light \"photometric\" has no \"string filename\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let from = list.vec3("from", &mut self.reporter)?.unwrap_or(DVec3::ZERO);
        let emission = self.color_and_scale(list, context)?;
        let (path, bytes) = match self.read_file(&name, FileKind::Luminaire) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("light \"photometric\": {problem}");
                return Err(self.reporter.error(&p.value_place, MISSING_FILE, message));
            }
        };
        if bytes.starts_with(MAGIC) {
            let rays = self.source_rays(list, &p, &path, &bytes)?;
            return Ok((LightKind::Rays { rays: rays.into(), from }, emission));
        }
        let mut photometry = self.photometry(&p, &path, &bytes)?;
        let read = &photometry.distribution;
        let values = read.azimuths().len().saturating_mul(read.polars().len());
        let memory = BYTES_PER_INTENSITY.saturating_mul(values as u64).saturating_add(bytes.len() as u64);
        self.reporter.spend(&p.value_place, Resource::Memory, memory)?;
        self.choose_lamps(list, &mut photometry)?;
        *luminaire = Some(Arc::new(photometry.description(&path)));
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

    /// `color`, whose magnitude is ignored, and `scale`.
    fn color_and_scale(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<EmissionParameters> {
        let spectrum = match list.take("color") {
            Some(p) => self.distribution(&list.subject, &p, context.color_space)?,
            None => grey(1.0),
        };
        let factor = list.float_or("scale", 1.0, &mut self.reporter)? as f32;
        Ok(EmissionParameters { spectrum, factor, normalisation: 1.0 })
    }

    /// The photometry in the file, and in the file of its tilt data if there is one.
    fn photometry(&mut self, p: &Parameter, path: &Path, bytes: &[u8]) -> ParseResult<Photometry> {
        let read = photometry::read_with(bytes, &mut |tilt| {
            self.read_file(tilt, FileKind::Luminaire)
                .map(|(_, bytes)| bytes)
                .map_err(|problem| problem.message)
        });
        let message = |fault: &PhotometryError| format!("light \"photometric\": {}:{fault}", path.display());
        let help = |fault: &PhotometryError| fault.kind.help().map(str::to_owned);
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

    /// The rays of a TM-25 file, with its luminous flux or that of `lumens`.
    fn source_rays(
        &mut self,
        list: &mut ParameterList,
        p: &Parameter,
        path: &Path,
        bytes: &[u8],
    ) -> ParseResult<Vec<SourceRay>> {
        let place = list.value_place("lumens");
        let lumens = self.not_negative(list, "lumens")?;
        let (mut rays, stated) = match read_rays(bytes, &self.finder.budget) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("light \"photometric\": {}: {problem}", path.display());
                return Err(self.reporter.error(&p.value_place, "photometry", message));
            }
        };
        let Some(wanted) = lumens.or(stated) else {
            let message = format!("light \"photometric\": {} states no luminous flux", path.display());
            let help = Some("say \"float lumens\"".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "photometry", message, help));
        };
        let sum: f64 = rays.iter().map(|ray| f64::from(ray.lumens)).sum();
        let factor = wanted / sum;
        if !factor.is_finite() {
            let message = format!("light \"photometric\": {wanted} lm cannot be had from dark rays");
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        for ray in &mut rays {
            ray.lumens = (f64::from(ray.lumens) * factor) as f32;
        }
        Ok(rays)
    }

    /// `lamps`: number of the set of lamps of an EULUMDAT file.
    fn choose_lamps(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> ParseResult<()> {
        let place = list.value_place("lamps");
        let Some(set) = list.integer_from("lamps", 0, &mut self.reporter)?.filter(|&set| set > 0) else {
            return Ok(());
        };
        match photometry.with_lamps(set as usize) {
            Some(changed) => *photometry = changed,
            None => {
                let count = photometry.lamps.len();
                let message = format!(
                    "light \"photometric\": there is no set of lamps {set} with a flux; the file has {count}"
                );
                let help = Some("sets are counted from 0; only EULUMDAT files have several".to_owned());
                return Err(self.reporter.error_with_help(&place, "parameter-range", message, help));
            }
        }
        Ok(())
    }

    /// `tilt`: angle of the lamp in degrees, for files with tilt data.
    fn tilt(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> ParseResult<()> {
        let place = list.value_place("tilt");
        let Some(degrees) = list.float("tilt", &mut self.reporter)? else { return Ok(()) };
        let Some(factor) = photometry.tilt.as_ref().map(|tilt| tilt.factor(degrees)) else {
            let message = "light \"photometric\": its file has no tilt data, \"tilt\" changes nothing";
            self.reporter.warning(&place, "photometry", message);
            return Ok(());
        };
        self.scale(&place, photometry.scaled_by(factor), photometry, &format!("the tilt factor {factor}"))
    }

    /// `lumens`: total flux of the luminaire, in place of that in its file.
    fn scale_to_lumens(&mut self, list: &mut ParameterList, photometry: &mut Photometry) -> ParseResult<()> {
        let place = list.value_place("lumens");
        let Some(lumens) = list.float("lumens", &mut self.reporter)? else { return Ok(()) };
        self.scale(&place, photometry.scaled_to(lumens), photometry, &format!("{lumens} lm"))
    }

    fn scale(
        &mut self,
        place: &crate::source::Span,
        scaled: Option<Photometry>,
        photometry: &mut Photometry,
        what: &str,
    ) -> ParseResult<()> {
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
    fn opening(
        &mut self,
        list: &mut ParameterList,
        photometry: &Photometry,
    ) -> ParseResult<Option<LuminousOpening>> {
        let Some((p, kind)) = list.text_parameter("as", &mut self.reporter)? else { return Ok(None) };
        let LuminousOpening { shape, size } = photometry.opening;
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
                let help = Some("a luminaire is a point or an area".to_owned());
                Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help))
            }
        }
    }
}

/// Bytes for each intensity of a luminaire: itself, and once more while all are scaled.
const BYTES_PER_INTENSITY: u64 = 16;

/// Largest number of rays of a file: all are in memory, with 28 bytes each and 8 for their selection.
const MAX_RAYS: u64 = 20_000_000;

/// Least number of bytes of a ray in a file: position, direction and flux as single numbers.
const LEAST_RECORD: u64 = 28;

/// The rays of a file, each with its fraction of the flux, and the lumens stated in the file.
fn read_rays(bytes: &[u8], budget: &ResourceBudget) -> Result<(Vec<SourceRay>, Option<f64>), String> {
    let rays = RayReader::new(bytes).map_err(|error| error.to_string())?;
    let header = rays.header().clone();
    if header.ray_count > MAX_RAYS {
        return Err(format!("it has {} rays, at most {MAX_RAYS} can be used", header.ray_count));
    }
    let bytes_of = |rays: u64| rays.saturating_mul(size_of::<SourceRay>() as u64);
    // The header may state more than there are. The list grows: all are in the old one, and there is room for twice as many in the new one.
    let most = header.ray_count.min(bytes.len() as u64 / LEAST_RECORD);
    let mut memory = budget.reserve(bytes_of(most).saturating_mul(3)).map_err(|end| end.to_string())?;
    let single = |v: DVec3| v.as_vec3().to_array();
    let read = rays.map(|ray| {
        budget.check().map_err(|end| end.to_string())?;
        let ray = ray.map_err(|error| error.to_string())?;
        // The header has no other kinds of flux.
        let lumens = ray.luminous_flux.or(ray.radiant_flux).unwrap_or(0.0);
        Ok(SourceRay { origin: single(ray.position), direction: single(ray.direction), lumens })
    });
    let mut read: Vec<SourceRay> = read.collect::<Result<_, String>>()?;
    read.shrink_to_fit();
    memory.shrink(bytes_of(read.len() as u64));
    memory.keep();
    let of_rays = || read.iter().map(|ray| f64::from(ray.lumens)).sum();
    let stated = header.luminous_flux.map(f64::from).or_else(|| header.has_luminous_flux.then(of_rays));
    Ok((read, stated))
}
