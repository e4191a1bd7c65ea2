//! Files of materials (MTL).

use std::borrow::Cow;

use glanz_job::ResourceBudget;

use super::SkippedStatement;
use super::error::{ObjError, ObjErrorKind};
use super::statement::{ObjWord, Statements};
use crate::growing_memory::GrowingReservation;
use crate::source::shortened;

/// Parameters of a material, as the file gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMaterial {
    /// Its name.
    pub name: String,
    /// `Kd`: diffuse reflectance.
    pub diffuse: Option<[f64; 3]>,
    /// `Ks`: specular reflectance.
    pub specular: Option<[f64; 3]>,
    /// `Ke`: emitted light.
    pub emission: Option<[f64; 3]>,
    /// `Tf`: transmission filter.
    pub filter: Option<[f64; 3]>,
    /// `Ns`: exponent of the highlight.
    pub exponent: Option<f64>,
    /// `d`: 1 is opaque.
    pub opacity: Option<f64>,
    /// `Tr`: 0 is opaque.
    pub transparency: Option<f64>,
    /// `Ni`: refractive index.
    pub index: Option<f64>,
    /// `illum`: model of illumination.
    pub illumination: Option<f64>,
    /// `Pr`: roughness.
    pub roughness: Option<f64>,
    /// `Pm`: metallicity.
    pub metallic: Option<f64>,
    /// `map_Kd`.
    pub diffuse_map: Option<ObjPicture>,
    /// `map_Ke`.
    pub emission_map: Option<ObjPicture>,
    /// `map_d`.
    pub opacity_map: Option<ObjPicture>,
}

/// A picture on a surface: at texture coordinates times `scale` plus `offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjPicture {
    /// Name of the file.
    pub file: String,
    /// `-s`: factors.
    pub scale: [f64; 2],
    /// `-o`: summands.
    pub offset: [f64; 2],
    /// `-clamp on`: beyond the picture, its border goes on instead of its repetition.
    pub clamped: bool,
}

impl Default for ObjPicture {
    /// The whole picture by the texture coordinates themselves, repeated.
    fn default() -> Self {
        Self { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], clamped: false }
    }
}

/// The contents of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMaterials {
    /// The materials.
    pub materials: Vec<ObjMaterial>,
    /// What was left out.
    pub skipped: Vec<SkippedStatement>,
}

/// Statements without an effect here: ambient light, sharpness of reflections, and pictures of what other statements say.
const IGNORED: [&str; 4] = ["Ka", "map_Ka", "sharpness", "map_aat"];

/// Options of pictures with the number of their values.
const OPTIONS: [(&str, usize); 13] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-boost", 1),
    ("-cc", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
    ("-clamp", 1),
    ("-bm", 1),
    ("-imfchan", 1),
    ("-type", 1),
];

/// Reads the bytes of a file.
///
/// # Errors
/// [`ObjError`] with line and column.
pub fn read_materials(bytes: &[u8]) -> Result<ObjMaterials, ObjError> {
    read_materials_with(bytes, &ResourceBudget::default())
}

/// As [`read_materials`] within a budget.
///
/// # Errors
/// [`ObjError`] with line and column.
pub fn read_materials_with(bytes: &[u8], budget: &ResourceBudget) -> Result<ObjMaterials, ObjError> {
    let mut statements = Statements::new(bytes).within(budget);
    let mut memory = GrowingReservation::new(budget);
    let mut file = ObjMaterials::default();
    while statements.advance() {
        let s = &statements;
        let needed = (3 * size_of::<ObjMaterial>() * (file.materials.len() + 1)) as u64;
        let reserved = budget.check().and_then(|()| memory.reach(needed));
        reserved.map_err(|end| s.error(None, end.into()))?;
        if s.keyword() == "newmtl" {
            file.materials.push(ObjMaterial { name: s.rest(), ..ObjMaterial::default() });
            continue;
        }
        let Some(material) = file.materials.last_mut() else {
            return Err(s.error(None, ObjErrorKind::NoMaterial(shortened(s.keyword()))));
        };
        if let Some(what) = statement(s, material)? {
            SkippedStatement::add(&mut file.skipped, s.place(), what);
        }
    }
    budget.check().map_err(|end| statements.error(None, end.into()))?;
    Ok(file)
}

/// Reads a statement, or tells why it is left out.
fn statement(s: &Statements<'_>, material: &mut ObjMaterial) -> Result<Option<String>, ObjError> {
    let number = || s.numbers::<1>(1, 0.0).map(|[x]| Some(x));
    match s.keyword() {
        "Kd" | "Ks" | "Ke" | "Tf" => {
            if s.values().first().is_some_and(|word| matches!(word.text, "spectral" | "xyz")) {
                return Ok(Some(format!("a {} that is no RGB colour is not read and skipped", s.keyword())));
            }
            let color = color(s)?;
            match s.keyword() {
                "Kd" => material.diffuse = color,
                "Ks" => material.specular = color,
                "Ke" => material.emission = color,
                _ => material.filter = color,
            }
        }
        "Ns" => material.exponent = number()?,
        // `d -halo factor` makes the border of a sphere transparent.
        "d" if s.values().first().is_some_and(|word| word.text == "-halo") => {
            return Ok(Some("a halo is not read and skipped".to_owned()));
        }
        "d" => material.opacity = number()?,
        "Tr" => material.transparency = number()?,
        "Ni" => material.index = number()?,
        "illum" => material.illumination = number()?,
        "Pr" => material.roughness = number()?,
        "Pm" => material.metallic = number()?,
        "map_Kd" | "map_Ke" | "map_d" => {
            let (picture, problem) = picture(s);
            match s.keyword() {
                "map_Kd" => material.diffuse_map = Some(picture),
                "map_d" => material.opacity_map = Some(picture),
                _ => material.emission_map = Some(picture),
            }
            return Ok(problem);
        }
        ignored if IGNORED.contains(&ignored) => {}
        other => return Ok(Some(format!("statement {:?} is not read and skipped", shortened(other)))),
    }
    Ok(None)
}

/// A colour; one number stands for three.
fn color(s: &Statements<'_>) -> Result<Option<[f64; 3]>, ObjError> {
    let [r, g, b] = s.numbers(1, f64::NAN)?;
    let [g, b] = [g, b].map(|x| if x.is_nan() { r } else { x });
    Ok(Some([r, g, b].map(|x| x.max(0.0))))
}

/// A picture after its options, and what of them is left out.
fn picture(s: &Statements<'_>) -> (ObjPicture, Option<String>) {
    let mut words: Vec<_> = s.values().iter().map(ObjWord::name).collect();
    let mut picture = ObjPicture::default();
    let mut problem = None;
    while let Some(&(option, values)) =
        OPTIONS.iter().find(|(option, _)| words.first().is_some_and(|word| word == option))
    {
        let number = |word: &Cow<'_, str>| word.parse().ok().filter(|x: &f64| x.is_finite());
        // The second and third number may be missing.
        let is_value = |word: &&Cow<'_, str>| number(word).is_some() || !matches!(option, "-o" | "-s" | "-t");
        let count = words.iter().skip(1).take(values).take_while(is_value).count();
        let mut given = words.drain(..words.len().min(1 + count)).skip(1);
        let list = match option {
            "-s" => &mut picture.scale,
            "-o" => &mut picture.offset,
            "-clamp" => {
                picture.clamped = given.next().is_some_and(|word| word == "on");
                continue;
            }
            "-mm" | "-t" => {
                problem = Some(format!("option \"{option}\" of a picture is not read and skipped"));
                continue;
            }
            _ => continue,
        };
        list.iter_mut().zip(given.filter_map(|word| number(&word))).for_each(|(x, value)| *x = value);
    }
    picture.file = words.join(" ");
    (picture, problem)
}
