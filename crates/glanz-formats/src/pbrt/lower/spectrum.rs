//! Spectra, and parameters that are spectra, numbers or textures.

use std::path::Path;

use glanz_light::rgb::xyz_to_rgb;
use glanz_light::{SpectralDistribution, Wavelengths, named};
use glanz_scene::description::{FloatParameter, SpectrumParameter};

use super::Lowering;
use super::named::{at_d_line, suggestion};
use crate::file_list::FileKind;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::lexer::{LexError, Lexer, ListMemory};
use crate::pbrt::parameters::{Parameter, ParameterList, ParameterType, Values, shortened};
use crate::source::{MISSING_FILE, ParseResult};

/// A grey spectrum, which needs no conversion.
pub(super) fn grey(value: f32) -> SpectralDistribution {
    SpectralDistribution::Constant(value)
}

/// A spectrum times a factor; `None` if a product is out of range.
pub(super) fn scaled(spectrum: &SpectralDistribution, factor: f32) -> Option<SpectralDistribution> {
    match spectrum {
        SpectralDistribution::Constant(x) => Some(SpectralDistribution::Constant(x * factor)),
        SpectralDistribution::Rgb(rgb) => Some(SpectralDistribution::Rgb(rgb.map(|x| x * factor))),
        SpectralDistribution::Sampled(samples) => {
            samples.scaled(factor).ok().map(SpectralDistribution::Sampled)
        }
        _ => None,
    }
}

/// The largest value of a spectrum, of colours the largest component; `None` for one without such a value.
pub(super) fn largest(spectrum: &SpectralDistribution) -> Option<f32> {
    Some(match spectrum {
        SpectralDistribution::Constant(value) => *value,
        SpectralDistribution::Rgb(rgb) => rgb.iter().copied().fold(0.0, f32::max),
        SpectralDistribution::Sampled(samples) => samples.range().1,
        _ => return None,
    })
}

impl Lowering {
    /// The spectrum of a parameter without texture.
    pub(super) fn distribution(
        &mut self,
        subject: &str,
        p: &Parameter,
        space: ColorSpace,
    ) -> ParseResult<SpectralDistribution> {
        match (&p.values, p.kind) {
            (Values::Floats(v), ParameterType::Rgb) => self.rgb(subject, p, v, space),
            (Values::Floats(v), ParameterType::Xyz) => match v[..] {
                [x, y, z] => {
                    let rgb = xyz_to_rgb([x, y, z]).map(|x| x.max(0.0) as f32);
                    Ok(SpectralDistribution::Rgb(rgb))
                }
                _ => self.refuse(subject, p, format!("has {} values; 3 are needed", v.len())),
            },
            (Values::Floats(v), ParameterType::Blackbody) => self.blackbody(subject, p, v),
            (Values::Floats(v), ParameterType::Float) => match v[..] {
                [x] => Ok(grey(x as f32)),
                _ => self.refuse(subject, p, format!("has {} values; 1 is needed", v.len())),
            },
            (Values::Integers(v), ParameterType::Integer) => match v[..] {
                [x] => Ok(grey(x as f32)),
                _ => self.refuse(subject, p, format!("has {} values; 1 is needed", v.len())),
            },
            (Values::Floats(v), ParameterType::Spectrum) => self.pairs(subject, p, v),
            (Values::Texts(v), ParameterType::Spectrum) => match &v[..] {
                [name] => self.named_spectrum(subject, p, name),
                _ => self.refuse(subject, p, format!("has {} values; 1 is needed", v.len())),
            },
            _ => self.refuse(subject, p, "is not a spectrum".to_owned()),
        }
    }

    fn refuse<T>(&mut self, subject: &str, p: &Parameter, what: String) -> ParseResult<T> {
        let message = format!("{subject}: parameter {:?} {what}", p.name);
        Err(self.reporter.error(&p.value_place, "spectrum", message))
    }

    fn rgb(
        &mut self,
        subject: &str,
        p: &Parameter,
        v: &[f64],
        space: ColorSpace,
    ) -> ParseResult<SpectralDistribution> {
        let [r, g, b] = *v else {
            return self.refuse(subject, p, format!("has {} values; 3 are needed", v.len()));
        };
        if r < 0.0 || g < 0.0 || b < 0.0 {
            return self.refuse(subject, p, "has a negative component".to_owned());
        }
        Ok(SpectralDistribution::Rgb(space.to_rec709([r, g, b]).map(|x| x as f32)))
    }

    /// A black body by its temperature, in version 3 with a factor. The peak of the spectrum is 1 or that factor; lights of version
    /// 4 are normalised later.
    fn blackbody(&mut self, subject: &str, p: &Parameter, v: &[f64]) -> ParseResult<SpectralDistribution> {
        let (kelvin, scale) = match *v {
            [kelvin] => (kelvin, 1.0),
            [kelvin, scale] => (kelvin, scale),
            _ => {
                let what = format!("has {} values; a temperature in kelvin is needed", v.len());
                return self.refuse(subject, p, what);
            }
        };
        match SpectralDistribution::try_blackbody(kelvin as f32, scale as f32) {
            Ok(body) => Ok(body),
            Err(error) => self.refuse(subject, p, format!("is not a spectrum: {error}")),
        }
    }

    /// Wavelengths in nm with values, in any order.
    fn pairs(&mut self, subject: &str, p: &Parameter, v: &[f64]) -> ParseResult<SpectralDistribution> {
        if !v.len().is_multiple_of(2) {
            let what = format!("has {} values; pairs of wavelength and value are needed", v.len());
            return self.refuse(subject, p, what);
        }
        match sampled(v) {
            Ok(spectrum) => Ok(spectrum),
            Err(error) => self.refuse(subject, p, format!("is not a spectrum: {error}")),
        }
    }

    /// A built-in spectrum by name, or a file of pairs.
    fn named_spectrum(
        &mut self,
        subject: &str,
        p: &Parameter,
        name: &str,
    ) -> ParseResult<SpectralDistribution> {
        if let Some(spectrum) = named::spectrum(name) {
            return Ok(spectrum);
        }
        let (path, bytes) = match self.read_file(name, FileKind::Spectrum) {
            Ok(read) => read,
            // So that the files of further parameters are listed, too.
            Err(_) if self.finder.lists => return Ok(grey(1.0)),
            Err(problem) => {
                let message = format!("{subject}: parameter {:?}: spectrum {problem}", p.name);
                let place = &p.value_place;
                return Err(self.reporter.error_with_help(place, MISSING_FILE, message, suggestion(name)));
            }
        };
        match self.floats_of_file(&path, bytes) {
            Ok(values) => self.pairs(subject, p, &values),
            Err(what) => self.refuse(subject, p, format!("is not a spectrum: {what}")),
        }
    }

    /// The numbers of a text with comments; `path`: its path for the message of the error.
    pub(super) fn floats_of_file(&self, path: &Path, bytes: Vec<u8>) -> Result<Vec<f64>, String> {
        let problem = |error: LexError| {
            let at = error.place.location;
            format!("{}:{}:{}: {}", path.display(), at.line, at.column, error.message)
        };
        let (mut values, mut memory) = (Vec::new(), ListMemory::default());
        let mut lexer = Lexer::new(bytes.into(), self.description_file(), &self.finder.budget);
        while lexer.peek().is_some() {
            lexer.reserve_list::<f64>(&mut memory, values.len() + 1).map_err(problem)?;
            values.push(lexer.float().map_err(problem)?);
        }
        lexer.spend().map_err(problem)?;
        Ok(values)
    }

    /// A file number for lexers whose spans are not used.
    fn description_file(&self) -> glanz_scene::description::FileId {
        glanz_scene::description::FileId(0)
    }

    /// A spectrum or a texture; `None` without the parameter.
    pub(super) fn optional_spectrum(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        space: ColorSpace,
    ) -> ParseResult<Option<SpectrumParameter>> {
        let Some(p) = list.take(name) else { return Ok(None) };
        if p.kind == ParameterType::Texture {
            return self.texture_named(&list.subject, &p, true).map(|t| Some(SpectrumParameter::Texture(t)));
        }
        self.distribution(&list.subject, &p, space).map(|s| Some(SpectrumParameter::Value(s)))
    }

    /// A spectrum or a texture, or grey without the parameter.
    pub(super) fn spectrum_or(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        default: f32,
        space: ColorSpace,
    ) -> ParseResult<SpectrumParameter> {
        let found = self.optional_spectrum(list, name, space)?;
        Ok(found.unwrap_or_else(|| SpectrumParameter::Value(grey(default))))
    }

    /// A number or a texture; `None` without the parameter. For a spectrum, its value at helium's
    /// d line.
    pub(super) fn optional_float(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
    ) -> ParseResult<Option<FloatParameter>> {
        Ok(self.optional_index(list, name)?.map(|(value, _)| value))
    }

    /// As [`Lowering::optional_float`], with the spectrum if it is given by wavelength.
    pub(super) fn optional_index(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
    ) -> ParseResult<Option<(FloatParameter, Option<SpectralDistribution>)>> {
        let Some(p) = list.take(name) else { return Ok(None) };
        if p.kind == ParameterType::Texture {
            let texture = self.texture_named(&list.subject, &p, false)?;
            return Ok(Some((FloatParameter::Texture(texture), None)));
        }
        let spectrum = self.distribution(&list.subject, &p, ColorSpace::Rec709)?;
        let value = FloatParameter::Value(at_d_line(&spectrum));
        Ok(Some((value, Some(spectrum).filter(|spectrum| {
            matches!(spectrum, SpectralDistribution::Sampled(samples) if samples.range().0 < samples.range().1)
        }))))
    }

    /// The refractive index of glass, 1.5 by default: a number, a texture, a spectrum, or the two numbers of Cauchy's formula.
    pub(super) fn refractive_index(
        &mut self,
        list: &mut ParameterList,
    ) -> ParseResult<(FloatParameter, Option<SpectralDistribution>)> {
        let place = list.value_place("cauchy");
        let cauchy = list.float_array::<2>("cauchy", &mut self.reporter)?;
        let (index, eta) = (self.optional_index(list, "index")?, self.optional_index(list, "eta")?);
        let Some(coefficients) = cauchy else {
            return Ok(eta.or(index).unwrap_or((FloatParameter::Value(1.5), None)));
        };
        if eta.or(index).is_some() {
            let message = format!("{}: \"cauchy\" and \"eta\" both set the refractive index", list.subject);
            let help = Some("give one of them".to_owned());
            return Err(self.reporter.error_with_help(&place, "parameter-conflict", message, help));
        }
        let spectrum = named::cauchy(coefficients).map_err(|error| {
            let message = format!("{}: \"cauchy\" is not an index: {error}", list.subject);
            self.reporter.error(&place, "spectrum", message)
        })?;
        Ok((FloatParameter::Value(at_d_line(&spectrum)), Some(spectrum)))
    }

    /// A number or a texture, or a default.
    pub(super) fn float_or(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        default: f32,
    ) -> ParseResult<FloatParameter> {
        Ok(self.optional_float(list, name)?.unwrap_or(FloatParameter::Value(default)))
    }

    fn texture_named(&mut self, subject: &str, p: &Parameter, spectrum: bool) -> ParseResult<usize> {
        let name = match &p.values {
            Values::Texts(v) => match &v[..] {
                [name] => name.clone(),
                _ => return self.refuse(subject, p, format!("has {} values; 1 is needed", v.len())),
            },
            _ => return self.refuse(subject, p, "names no texture".to_owned()),
        };
        if let Some(index) = self.textures.find(&name, spectrum) {
            return Ok(index);
        }
        let message =
            format!("{subject}: parameter {:?}: there is no texture {:?}", p.name, shortened(&name));
        let help = match self.textures.nearest(&name) {
            Some(n) => format!("did you mean {n:?}?"),
            None => "a texture must be defined before it is used".to_owned(),
        };
        Err(self.reporter.error_with_help(&p.value_place, "missing-texture", message, Some(help)))
    }

    /// Light of the given parameter and `scale`.
    ///
    /// In version 4, sampled spectra and black bodies are scaled to luminance 1 before `scale`; in version 3 they are
    /// unchanged, and `scale` may be a colour.
    pub(super) fn emission(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        space: ColorSpace,
    ) -> ParseResult<EmissionParameters> {
        let mut light = EmissionParameters { spectrum: grey(1.0), factor: 1.0, normalisation: 1.0 };
        if let Some(p) = list.take(name) {
            light.spectrum = self.distribution(&list.subject, &p, space)?;
            light.normalisation = self.normalisation(p.kind, &light.spectrum);
        }
        let Some(p) = list.take("scale") else { return Ok(light) };
        match self.distribution(&list.subject, &p, space)? {
            SpectralDistribution::Constant(x) => light.factor = x,
            SpectralDistribution::Rgb([r, g, b]) if r == g && g == b => light.factor = r,
            color => {
                let (a, b) = (within_gamut(&light.spectrum), within_gamut(&color));
                light.spectrum = SpectralDistribution::Rgb(std::array::from_fn(|i| a[i] * b[i]));
            }
        }
        Ok(light)
    }

    /// The factor that version 4 has on sampled light and black bodies, which brings them to luminance 1.
    pub(super) fn normalisation(&self, kind: ParameterType, spectrum: &SpectralDistribution) -> f32 {
        if self.dialect == Dialect::V3 || !matches!(kind, ParameterType::Blackbody | ParameterType::Spectrum)
        {
            return 1.0;
        }
        let luminance = spectrum.luminance();
        if luminance > 0.0 { 1.0 / luminance } else { 0.0 }
    }
}

/// Emission of a light: the spectrum times both factors.
#[derive(Clone, Debug)]
pub(super) struct EmissionParameters {
    pub(super) spectrum: SpectralDistribution,
    /// The `scale` of the scene.
    pub(super) factor: f32,
    /// Factor that scales the spectrum to the luminance of its version.
    pub(super) normalisation: f32,
}

impl EmissionParameters {
    /// Both factors.
    pub(super) fn scale(&self) -> f32 {
        self.factor * self.normalisation
    }
}

/// The colour of light without the negative components that it has outside Rec. 709 (black bodies below some 1900 K
/// do), for products with other colours.
pub(super) fn within_gamut(light: &SpectralDistribution) -> [f32; 3] {
    let wavelengths = Wavelengths::default();
    light.radiance(&wavelengths).to_rgb(&wavelengths).map(|x| x.max(0.0))
}

/// A spectrum from pairs in any order.
fn sampled(pairs: &[f64]) -> Result<SpectralDistribution, glanz_light::SpectrumError> {
    let mut points: Vec<(f32, f32)> =
        pairs.chunks_exact(2).map(|pair| (pair[0] as f32, pair[1] as f32)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    SpectralDistribution::try_sampled(points)
}
