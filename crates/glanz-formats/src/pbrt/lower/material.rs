//! `Material`, `MakeNamedMaterial`, `NamedMaterial`.

use glanz_job::Resource;
use glanz_light::named;
use glanz_scene::description::{
    DescriptionForm, FloatParameter, MaterialDescription, MaterialKind, SpectrumParameter,
    SurfaceDetailDescription,
};
use glanz_shading::model::{
    ConductorMaterial, DielectricMaterial, FinishError, FinishModel, MetalColor, MirrorMaterial, Roughness,
    SurfaceFinish,
};

use super::Lowering;
use super::roughness::RoughnessNames;
use super::spectrum::grey;
use crate::image::Encoding;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{ParseResult, Span};

impl Lowering {
    /// Adds a material; returns its index.
    pub(crate) fn material(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        space: ColorSpace,
    ) -> ParseResult<usize> {
        let place = list.place;
        let location = Some(place.location);
        let surface_detail = self.surface_detail(&mut list)?;
        let kind = self.material_kind(kind, list, space)?;
        self.spend_entry::<MaterialDescription>("", &place)?;
        let materials = &mut self.description.materials;
        materials.push(MaterialDescription { name: String::new(), kind, surface_detail, location });
        Ok(materials.len() - 1)
    }

    /// Defines a material with a name; its type is the parameter `type`.
    pub(crate) fn named_material(
        &mut self,
        name: &str,
        mut list: ParameterList,
        space: ColorSpace,
    ) -> ParseResult<()> {
        let place = list.place;
        let location = Some(place.location);
        let Some(kind) = list.text("type", &mut self.reporter)? else {
            let message = format!("material {:?} has no \"string type\"", shortened(name));
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        list.subject = format!("material {kind:?}");
        let surface_detail = self.surface_detail(&mut list)?;
        let kind = self.material_kind(&kind, list, space)?;
        self.spend_entry::<MaterialDescription>(name, &place)?;
        let material = MaterialDescription { name: name.to_owned(), kind, surface_detail, location };
        self.materials.define(name, material, &mut self.description.materials);
        Ok(())
    }

    /// The index of the material of this name, which may be defined later.
    pub(crate) fn use_material(&mut self, name: &str, place: &Span) -> usize {
        let materials = &mut self.description.materials;
        let before = materials.len();
        let index = self.materials.index_of(name, place, materials, || grey_material(name, place));
        if materials.len() > before {
            // A failure is reported, and ends reading at the next directive.
            let _ = self.spend_entry::<MaterialDescription>(name, place);
        }
        index
    }

    /// The material of shapes without one.
    pub(crate) fn default_material(&mut self, place: &Span) -> usize {
        match self.default_material {
            Some(index) => index,
            None => {
                let materials = &mut self.description.materials;
                materials.push(grey_material("", place));
                let index = materials.len() - 1;
                self.default_material = Some(index);
                index
            }
        }
    }

    /// Reports materials that are used and never defined.
    pub(crate) fn check_materials(&mut self) {
        self.materials.report_missing("material", "missing-material", &mut self.reporter);
    }

    fn material_kind(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let l = &mut list;
        let made = match kind {
            "diffuse" | "matte" => self.diffuse(kind, l, space)?,
            "mirror" => {
                let reflectance = self.spectrum_or(l, "Kr", 0.9, space)?;
                let reflectance = self.optional_spectrum(l, "reflectance", space)?.unwrap_or(reflectance);
                MaterialKind::Mirror(MirrorMaterial { reflectance, finish: self.finish(l)? })
            }
            "conductor" | "metal" => MaterialKind::Conductor(ConductorMaterial {
                color: self.metal_color(l, ["eta", "k", "reflectance"], space)?,
                roughness: match kind {
                    "metal" => self.facet_roughness(l, 0.01)?,
                    _ => self.roughness(l, RoughnessNames::PLAIN, 0.0)?,
                },
                multiple_scattering: self.multiple_scattering(l)?,
                finish: if kind == "conductor" { self.finish(l)? } else { None },
            }),
            "dielectric" | "glass" | "thindielectric" => self.dielectric(kind, l, space)?,
            "coateddiffuse" => self.coated_diffuse(l, space)?,
            "coatedconductor" => self.coated_conductor(l, space)?,
            "diffusetransmission" => self.diffuse_transmission(l, space)?,
            "principled" => self.principled(l, space)?,
            "plastic" => MaterialKind::Principled(self.plastic(l, space)?),
            "substrate" => self.substrate(l, space)?,
            "uber" => self.uber(l, space)?,
            "translucent" => self.translucent(l, space)?,
            "shinymetal" => self.shiny_metal(l, space)?,
            "disney" => self.disney(l, space)?,
            "phong" => MaterialKind::phong(
                self.spectrum_or(l, "Ka", 0.0, space)?,
                self.spectrum_or(l, "Kd", 0.5, space)?,
                self.spectrum_or(l, "Ks", 0.5, space)?,
                self.float_or(l, "exponent", 10.0)?,
            ),
            "mix" => self.mix(l)?,
            "" | "none" | "interface" => MaterialKind::Interface,
            other => self.replaced_material(other, l, space)?,
        };
        list.finish(&mut self.reporter);
        Ok(made)
    }

    /// The detail that every material may have: a map of normals, or heights as `displacement` (`bumpmap` in version 3), which a map of normals replaces.
    fn surface_detail(&mut self, list: &mut ParameterList) -> ParseResult<Option<SurfaceDetailDescription>> {
        let bump = self.optional_float(list, "bumpmap")?;
        let bump = self.optional_float(list, "displacement")?.or(bump);
        if let Some((p, name)) = list.text_parameter("normalmap", &mut self.reporter)? {
            let subject = format!("{}: normal map", list.subject);
            let instead = "the smooth surface stands in";
            let picture = self.image(&p, &name, Encoding::Linear, &subject, instead)?;
            return Ok(picture.map(SurfaceDetailDescription::NormalMap));
        }
        // The same height everywhere changes no normal.
        Ok(bump.filter(|bump| matches!(bump, FloatParameter::Texture(_))).map(SurfaceDetailDescription::Bump))
    }

    fn diffuse(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let name = if kind == "matte" { "Kd" } else { "reflectance" };
        let reflectance = self.spectrum_or(list, name, 0.5, space)?;
        let sigma = self.float_or(list, "sigma", 0.0)?;
        if !matches!(sigma, FloatParameter::Value(x) if x <= 0.0) {
            return Ok(MaterialKind::oren_nayar(reflectance, sigma));
        }
        Ok(MaterialKind::diffuse(reflectance))
    }

    /// A metal by its index and absorption (copper's by default) or, in version 4, by its reflectance at normal incidence.
    pub(super) fn metal_color(
        &mut self,
        list: &mut ParameterList,
        [eta, k, reflectance]: [&'static str; 3],
        space: ColorSpace,
    ) -> ParseResult<MetalColor<DescriptionForm>> {
        if let Some(reflectance) = self.optional_spectrum(list, reflectance, space)? {
            list.ignore(&[eta, k]);
            return Ok(MetalColor::Reflectance(reflectance));
        }
        let eta = self.optional_spectrum(list, eta, space)?;
        let k = self.optional_spectrum(list, k, space)?;
        let copper = |name: &str| SpectrumParameter::Value(named::spectrum(name).unwrap_or_default());
        Ok(MetalColor::Index {
            eta: eta.unwrap_or_else(|| copper("metal-Cu-eta")),
            k: k.unwrap_or_else(|| copper("metal-Cu-k")),
        })
    }

    /// The surface finish of a smooth mirror, an extension; `None` for one that scatters nothing, too.
    fn finish(&mut self, list: &mut ParameterList) -> ParseResult<Option<SurfaceFinish>> {
        let Some((parameter, kind)) = list.text_parameter("finish", &mut self.reporter)? else {
            return Ok(None);
        };
        let places = ["sigma", "fraction", "A", "B", "g"].map(|name| (name, list.value_place(name)));
        let mut number = |name: &'static str, default: Option<f64>| {
            let found = list.float(name, &mut self.reporter)?.or(default);
            found.ok_or_else(|| {
                let message = format!("{}: finish {kind:?} has no \"float {name}\"", list.subject);
                self.reporter.error(&parameter.value_place, "parameter-missing", message)
            })
        };
        let model = match &kind[..] {
            "gaussian" => FinishModel::Gaussian {
                sigma: number("sigma", None)?,
                fraction: number("fraction", Some(1.0))?,
            },
            "abg" => FinishModel::Abg { a: number("A", None)?, b: number("B", None)?, g: number("g", None)? },
            other => {
                let message = format!("{}: finish {:?} is unknown", list.subject, shortened(other));
                let help = Some("use \"gaussian\" or \"abg\"".to_owned());
                let place = &parameter.value_place;
                return Err(self.reporter.error_with_help(place, "parameter-range", message, help));
            }
        };
        let key = format!("{model:?}");
        let scatters = |finish: &SurfaceFinish| finish.total_scatter() > 0.0;
        if let Some(finish) = self.finishes.get(&key) {
            return Ok(Some(finish.clone()).filter(scatters));
        }
        self.reporter.spend(&parameter.value_place, Resource::Memory, BYTES_PER_FINISH)?;
        let finish = SurfaceFinish::try_new(model).map_err(|error| {
            let wrong = match error {
                FinishError::Range { parameter, .. } => parameter,
                _ => "A",
            };
            let place = places.iter().find(|(name, _)| *name == wrong);
            let place = place.map_or(parameter.value_place, |&(_, place)| place);
            self.reporter.error(&place, "parameter-range", format!("{}: {error}", list.subject))
        })?;
        self.finishes.insert(key, finish.clone());
        Ok(Some(finish).filter(scatters))
    }

    fn dielectric(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let (eta, dispersion) = self.refractive_index(list)?;
        let thin = kind == "thindielectric";
        Ok(MaterialKind::Dielectric(DielectricMaterial {
            eta,
            dispersion,
            reflectance: self.spectrum_or(list, "Kr", 1.0, space)?,
            transmittance: self.spectrum_or(list, "Kt", 1.0, space)?,
            thin,
            // A pane has no facets.
            roughness: if thin {
                Roughness::smooth()
            } else {
                self.roughness(list, RoughnessNames::PLAIN, 0.0)?
            },
            multiple_scattering: thin || self.multiple_scattering(list)?,
        }))
    }
}

/// Bytes of the tables of a finish: 4097 rings of two numbers, and 1025 angles of incidence.
const BYTES_PER_FINISH: u64 = 16 * 4097 + 8 * 1025;

/// The material of shapes without one, and of a name until it is defined.
fn grey_material(name: &str, place: &Span) -> MaterialDescription {
    let location = Some(place.location);
    MaterialDescription { name: name.to_owned(), location, ..MaterialKind::diffuse(grey(0.5)).into() }
}
