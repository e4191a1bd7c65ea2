//! The scattering models and their materials, one file each, and the table of them.

mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse_transmission;
pub mod finish;
mod lambert;
mod mirror;
mod mix;
mod oren_nayar;
pub mod phong;
mod principled;
pub mod roughness;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, SolidAnglePdf};

use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::phase::HenyeyGreenstein;
use crate::preview::PreviewSurface;
use crate::texture::{SpectrumInput, TexturePoint, Textures};

pub use coated_diffuse::{CoatedDiffuse, CoatedDiffuseMaterial};
pub use conductor::{Conductor, ConductorFresnel, ConductorMaterial, MetalColor};
pub use dielectric::{Dielectric, DielectricMaterial};
pub use diffuse_transmission::{DiffuseTransmission, DiffuseTransmissionMaterial};
pub use finish::{FinishError, FinishModel, SurfaceFinish};
pub use lambert::{DiffuseMaterial, Lambert};
pub use mirror::{Mirror, MirrorMaterial};
pub use mix::MixMaterial;
pub use oren_nayar::{OrenNayar, OrenNayarMaterial};
pub use phong::{Phong, PhongMaterial};
pub use principled::{Principled, PrincipledMaterial};
pub use roughness::{Roughness, RoughnessScale};

/// The parameters of a scattering model, which may be textured.
pub trait MaterialModel<P: ParameterForm> {
    /// The same material with parameters for shading.
    type Textured: TexturedModel;

    /// The name in scene files.
    fn kind(&self) -> &'static str;

    /// Checks the parameters and converts them for shading.
    ///
    /// # Errors
    /// [`MaterialError`] for the first parameter out of range or without its texture.
    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<Self::Textured, MaterialError>;
}

/// Parameters for shading, which give the scattering model at a point.
pub trait TexturedModel: MaterialModel<ShadingForm> {
    /// The scattering model, which may refer to the material.
    type Bsdf<'a>: BsdfModel
    where
        Self: 'a;

    /// The scattering model at a point.
    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Self::Bsdf<'_>;

    /// A warning about parameters that do not act as they suggest.
    fn warning(&self) -> Option<String> {
        None
    }
}

// One line per model; the macro generates the delegation for all of them.
macro_rules! bsdfs {
    ($($(#[$doc:meta])* $material_variant:ident($material:ident) => $variant:ident($model:ty),)*) => {
        /// The closed set of scattering models at a point, see [`BsdfModel`].
        #[derive(Clone, Debug, PartialEq)]
        pub enum Bsdf<'a> {
            /// Absorbs everything.
            Black,
            /// A point in a medium, which no material has.
            Medium(HenyeyGreenstein),
            $($(#[$doc])* $variant($model),)*
        }

        impl Bsdf<'_> {
            /// See [`BsdfModel::eval`].
            #[must_use]
            pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
                match self {
                    Self::Black => Spectrum::BLACK,
                    Self::Medium(model) => model.eval(wo, wi),
                    $(Self::$variant(model) => model.eval(wo, wi),)*
                }
            }

            /// See [`BsdfModel::pdf`].
            #[must_use]
            pub fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
                match self {
                    Self::Black => SolidAnglePdf(0.0),
                    Self::Medium(model) => model.pdf(wo, wi),
                    $(Self::$variant(model) => model.pdf(wo, wi),)*
                }
            }

            /// See [`BsdfModel::sample`].
            #[must_use]
            pub fn sample(
                &self,
                wo: DVec3,
                xi: DVec2,
                xi_lobe: f64,
                mode: TransportMode,
            ) -> Option<BsdfSample> {
                match self {
                    Self::Black => None,
                    Self::Medium(model) => model.sample(wo, xi, xi_lobe, mode),
                    $(Self::$variant(model) => model.sample(wo, xi, xi_lobe, mode),)*
                }
            }

            /// See [`BsdfModel::diffuse_probability`].
            #[inline]
            #[must_use]
            pub fn diffuse_probability(&self, wo: DVec3) -> f64 {
                match self {
                    Self::Black => 0.0,
                    Self::Medium(model) => model.diffuse_probability(wo),
                    $(Self::$variant(model) => model.diffuse_probability(wo),)*
                }
            }

            /// See [`BsdfModel::delta_branches`].
            #[must_use]
            pub fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
                match self {
                    Self::Black => [None; 2],
                    Self::Medium(model) => model.delta_branches(wo, mode),
                    $(Self::$variant(model) => model.delta_branches(wo, mode),)*
                }
            }

            /// See [`BsdfModel::is_delta`].
            #[must_use]
            pub fn is_delta(&self) -> bool {
                match self {
                    Self::Black => false,
                    Self::Medium(model) => model.is_delta(),
                    $(Self::$variant(model) => model.is_delta(),)*
                }
            }

            /// Whether a surface finish scatters light closely around the mirrored direction.
            #[must_use]
            pub fn has_finish(&self) -> bool {
                match self {
                    Self::Mirror(mirror) => mirror.finish.is_some(),
                    Self::Conductor(metal) => metal.finish.is_some(),
                    _ => false,
                }
            }

            /// See [`BsdfModel::is_dispersive`].
            #[inline]
            #[must_use]
            pub fn is_dispersive(&self) -> bool {
                match self {
                    Self::Black => false,
                    Self::Medium(model) => model.is_dispersive(),
                    $(Self::$variant(model) => model.is_dispersive(),)*
                }
            }

            /// See [`BsdfModel::is_anisotropic`].
            #[must_use]
            pub fn is_anisotropic(&self) -> bool {
                match self {
                    Self::Black => false,
                    Self::Medium(model) => model.is_anisotropic(),
                    $(Self::$variant(model) => model.is_anisotropic(),)*
                }
            }

            /// See [`BsdfModel::transmits`].
            #[must_use]
            pub fn transmits(&self) -> bool {
                match self {
                    Self::Black => false,
                    Self::Medium(model) => model.transmits(),
                    $(Self::$variant(model) => model.transmits(),)*
                }
            }

            /// See [`BsdfModel::albedo`].
            #[must_use]
            pub fn albedo(&self, wo: DVec3) -> Spectrum {
                match self {
                    Self::Black => Spectrum::BLACK,
                    Self::Medium(model) => model.albedo(wo),
                    $(Self::$variant(model) => model.albedo(wo),)*
                }
            }

            /// See [`BsdfModel::eta_scale`].
            #[must_use]
            pub fn eta_scale(&self, wo: DVec3, wi: DVec3) -> f32 {
                match self {
                    Self::Black => 1.0,
                    Self::Medium(model) => model.eta_scale(wo, wi),
                    $(Self::$variant(model) => model.eta_scale(wo, wi),)*
                }
            }

            /// See [`BsdfModel::reflected`].
            #[must_use]
            pub fn reflected(&self, wo: DVec3) -> Spectrum {
                match self {
                    Self::Black => Spectrum::BLACK,
                    Self::Medium(model) => model.reflected(wo),
                    $(Self::$variant(model) => model.reflected(wo),)*
                }
            }
        }

        $(impl<'a> From<$model> for Bsdf<'a> {
            fn from(model: $model) -> Self {
                Self::$variant(model)
            }
        })*

        /// The material of a surface; its parameters may be textured.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Material<P: ParameterForm = ShadingForm> {
            $($(#[$doc])* $material_variant($material<P>),)*
            /// One of two other materials.
            Mix(MixMaterial<P>),
            /// No surface at all: rays pass.
            Interface,
        }

        impl<P: ParameterForm> Material<P> {
            /// The name in scene files.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$material_variant(material) => material.kind(),)*
                    Self::Mix(_) => "mix",
                    Self::Interface => "interface",
                }
            }

            /// Checks the parameters and converts them for shading.
            ///
            /// # Errors
            /// [`MaterialError`] for the first parameter out of range or without its texture.
            pub fn resolve(&self, resolver: &impl ParameterResolver<P>) -> Result<Material, MaterialError> {
                Ok(match self {
                    $(Self::$material_variant(material) => Material::$material_variant(material.resolve(resolver)?),)*
                    Self::Mix(mix) => Material::Mix(mix.resolve(resolver)?),
                    Self::Interface => Material::Interface,
                })
            }

            /// The lobes that its BSDFs may have; of a mixture all.
            #[must_use]
            pub fn lobes(&self) -> &'static [Lobe] {
                match self {
                    Self::Mix(_) => Lobe::ALL,
                    $(Self::$material_variant(_) => <<$material as TexturedModel>::Bsdf<'static> as BsdfModel>::LOBES,)*
                    Self::Interface => &[],
                }
            }
        }

        impl Material {
            /// The BSDF at a point; `None` for [`Material::Interface`], and for [`Material::Mix`], which has those of other materials.
            #[must_use]
            pub fn bsdf(&self, textures: &Textures, at: &TexturePoint, wavelengths: &Wavelengths) -> Option<Bsdf<'_>> {
                let at = TextureEvaluator::new(textures, at, wavelengths);
                match self {
                    $(Self::$material_variant(material) => {
                        let model = material.bsdf(&at);
                        Some(if model.is_black() { Bsdf::Black } else { Bsdf::$variant(model) })
                    })*
                    Self::Mix(_) | Self::Interface => None,
                }
            }

            /// The appearance in a rasteriser at a point; `None` as for [`Material::bsdf`].
            #[must_use]
            pub fn preview(
                &self,
                textures: &Textures,
                at: &TexturePoint,
                wavelengths: &Wavelengths,
            ) -> Option<PreviewSurface> {
                let at = TextureEvaluator::new(textures, at, wavelengths);
                match self {
                    $(Self::$material_variant(material) => Some(material.bsdf(&at).preview()),)*
                    Self::Mix(_) | Self::Interface => None,
                }
            }

            /// See [`TexturedModel::warning`].
            #[must_use]
            pub fn warning(&self) -> Option<String> {
                match self {
                    $(Self::$material_variant(material) => material.warning(),)*
                    Self::Mix(_) | Self::Interface => None,
                }
            }
        }

        $(impl<P: ParameterForm> From<$material<P>> for Material<P> {
            fn from(material: $material<P>) -> Self {
                Self::$material_variant(material)
            }
        })*
    };
}

bsdfs! {
    /// Lambert's law.
    Diffuse(DiffuseMaterial) => Lambert(Lambert),
    /// Rough diffuse reflection.
    OrenNayar(OrenNayarMaterial) => OrenNayar(OrenNayar),
    /// Mirror.
    Mirror(MirrorMaterial) => Mirror(Mirror<'a>),
    /// Metal.
    Conductor(ConductorMaterial) => Conductor(Conductor<'a>),
    /// Glass.
    Dielectric(DielectricMaterial) => Dielectric(Dielectric),
    /// A diffuse base under a clear coat.
    CoatedDiffuse(CoatedDiffuseMaterial) => CoatedDiffuse(CoatedDiffuse),
    /// Diffuse reflection and transmission.
    DiffuseTransmission(DiffuseTransmissionMaterial) => DiffuseTransmission(DiffuseTransmission),
    /// Metallic-roughness with coat, sheen and transmission.
    Principled(PrincipledMaterial) => Principled(Box<Principled>),
    /// Modified Phong model.
    Phong(PhongMaterial) => Phong(Phong),
}

impl Material {
    /// Whether all of its BSDFs have delta lobes alone, whatever its textures: a perfect mirror, smooth metal, clear glass.
    #[must_use]
    pub fn is_specular(&self) -> bool {
        match self {
            Self::Mirror(mirror) => mirror.finish.is_none(),
            Self::Conductor(metal) => metal.roughness.is_smooth() && metal.finish.is_none(),
            Self::Dielectric(glass) => glass.thin || glass.roughness.is_smooth(),
            _ => false,
        }
    }
}

impl<P: ParameterForm> Material<P> {
    /// Whether rays pass as if there were no surface.
    #[must_use]
    pub fn is_interface(&self) -> bool {
        matches!(self, Self::Interface)
    }
}

impl Material {
    /// Whether its constants make it absorb all light everywhere: a diffuse material without reflectance.
    #[inline]
    #[must_use]
    pub fn absorbs_all(&self) -> bool {
        matches!(self, Self::Diffuse(DiffuseMaterial { reflectance: SpectrumInput::Constant(constant) }) if constant.is_black())
    }

    /// Checks that every texture exists and every constant is in its range.
    ///
    /// # Errors
    /// [`MaterialError`] for the first parameter out of range or without its texture.
    pub fn check(&self, textures: &Textures) -> Result<(), MaterialError> {
        self.resolve(textures).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::{SampledWavelengths, SpectralDistribution};
    use glanz_math::{DVec2, DVec3};

    use super::*;
    use crate::texture::{FloatInput, SpectralConstant, Texture};

    const RGB: Wavelengths = Wavelengths::Rgb;

    fn point() -> TexturePoint {
        TexturePoint::new(DVec2::ZERO, DVec3::ZERO)
    }

    fn grey(value: f32) -> SpectrumInput {
        Spectrum::from_rgb([value; 3]).into()
    }

    #[test]
    fn reflectance_out_of_range_is_clamped() {
        let mut textures = Textures::new();
        let wild = textures.add(Texture::Constant(Spectrum::from_rgb([1.5, -0.5, f32::NAN]))).unwrap();
        let material = Material::diffuse(SpectrumInput::Texture(wild));
        assert_eq!(material.check(&textures), Ok(()));
        let bsdf = material.bsdf(&textures, &point(), &RGB).unwrap();
        assert_eq!(bsdf.albedo(DVec3::Z).to_rgb(&RGB), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn interface_has_no_bsdf_and_black_absorbs() {
        let textures = Textures::new();
        let interface = Material::<ShadingForm>::Interface;
        assert_eq!(interface.bsdf(&textures, &point(), &RGB), None);
        assert!(interface.is_interface());
        let black = Material::diffuse(grey(0.0));
        assert_eq!(black.bsdf(&textures, &point(), &RGB), Some(Bsdf::Black));
        assert!(black.absorbs_all());
        assert!(!interface.absorbs_all() && !Material::<ShadingForm>::diffuse(grey(0.01)).absorbs_all());
    }

    #[test]
    fn constants_out_of_range_are_reported_with_their_values() {
        let textures = Textures::new();
        let glass = |eta: f32| Material::dielectric(eta, grey(1.0), grey(1.0));
        assert_eq!(glass(1.5).check(&textures), Ok(()));
        for eta in [0.0, -1.5, 1e-4, 1001.0, f32::INFINITY] {
            let error = MaterialError::Range {
                parameter: "eta",
                value: eta,
                range: "a number between 0.001 and 1000",
            };
            assert_eq!(glass(eta).check(&textures), Err(error));
        }
        let negative = Material::mirror(grey(-0.25));
        assert!(matches!(negative.check(&textures), Err(MaterialError::Range { value: -0.25, .. })));
        let mut others = Textures::new();
        let foreign = SpectrumInput::Texture(others.add(Texture::Constant(Spectrum::ONE)).unwrap());
        let error = Material::mirror(foreign).check(&textures);
        assert_eq!(error, Err(MaterialError::Texture { parameter: "reflectance" }));
    }

    #[test]
    fn errors_name_the_parameter_of_their_layer() {
        let checked = |set: fn(&mut PrincipledMaterial)| {
            let mut material = PrincipledMaterial::new(0.5, 0.5);
            set(&mut material);
            match Material::from(material).check(&Textures::new()) {
                Err(MaterialError::Range { parameter, .. }) => parameter,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(checked(|m| m.roughness.v = (-1.0).into()), "roughness");
        assert_eq!(checked(|m| m.coat_roughness.u = (-1.0).into()), "coat.roughness");
        assert_eq!(checked(|m| m.eta = 0.5.into()), "eta");
        assert_eq!(
            checked(|m| m.metal = Some(MetalColor::Index { eta: grey(-1.0), k: grey(1.0) })),
            "metal.eta"
        );
        assert_eq!(
            checked(|m| m.metal = Some(MetalColor::Index { eta: grey(1.0), k: grey(-1.0) })),
            "metal.k"
        );
    }

    #[test]
    fn mixtures_select_the_second_part_with_the_probability_of_their_amount() {
        let (textures, at) = (Textures::new(), point());
        let at = TextureEvaluator::new(&textures, &at, &RGB);
        for (amount, xi, selected) in
            [(0.25, 0.249, 9), (0.25, 0.25, 4), (-1.0, 0.0, 4), (7.0, 0.999, 9), (f32::NAN, 0.0, 4)]
        {
            let mix = MixMaterial::<ShadingForm> { materials: [4, 9], amount: FloatInput::Constant(amount) };
            assert_eq!(mix.select(&at, xi), selected, "{amount} {xi}");
        }
        assert!(matches!(
            Material::mix([0, 1], f32::INFINITY).check(&textures),
            Err(MaterialError::Range { parameter: "amount", .. })
        ));
    }

    #[test]
    fn phong_that_would_create_energy_has_a_warning() {
        let warning =
            |diffuse, specular| Material::phong(grey(0.1), grey(diffuse), grey(specular), 20.0).warning();
        assert_eq!(warning(0.5, 0.5), None);
        assert!(warning(0.75, 0.5).is_some_and(|message| message.contains("1.25")));
        // Also if one is given by wavelength.
        let distribution = SpectralDistribution::try_sampled(vec![(400.0, 0.5), (700.0, 0.9)]).unwrap();
        let rgb = distribution.reflectance(&RGB);
        let spectral = SpectrumInput::Spectral(SpectralConstant { rgb, distribution }.into());
        let message = Material::phong(grey(0.1), spectral, grey(0.8), 20.0).warning();
        assert!(message.is_some_and(|message| {
            message.contains(&(rgb + Spectrum::splat(0.8)).max_component().to_string())
        }));
    }

    #[test]
    fn glass_of_the_same_index_at_all_wavelengths_does_not_disperse() {
        let sampled = |points: &[(f32, f32)]| SpectralDistribution::try_sampled(points.to_vec()).unwrap();
        let wavelengths = Wavelengths::Sampled(SampledWavelengths::sample(0.3));
        for (dispersion, is_dispersive) in [
            (SpectralDistribution::Constant(0.0), false),
            (sampled(&[(400.0, 1.7), (700.0, 1.7)]), false),
            (sampled(&[(400.0, 1.7), (700.0, 1.6)]), true),
        ] {
            let glass = DielectricMaterial::<ShadingForm> {
                eta: 1.5.into(),
                dispersion: Some(dispersion),
                reflectance: grey(1.0),
                transmittance: grey(1.0),
                thin: false,
                roughness: Roughness::smooth(),
                multiple_scattering: true,
            };
            let textures = Textures::new();
            let glass = Material::from(glass).resolve(&textures).unwrap();
            let bsdf = glass.bsdf(&textures, &point(), &wavelengths).unwrap();
            assert_eq!(bsdf.is_dispersive(), is_dispersive, "{glass:?}");
        }
    }

    #[test]
    fn metal_leaves_unused_lanes_black() {
        let (eta, k) = (Spectrum::from_rgb([0.143, 0.375, 1.442]), Spectrum::from_rgb([3.983, 2.386, 1.603]));
        let gold = Material::conductor(eta, k);
        let albedo = gold.bsdf(&Textures::new(), &point(), &RGB).unwrap().albedo(DVec3::Z);
        let [r, g, b] = albedo.to_rgb(&RGB);
        assert!(r > 0.95 && g < 0.85 && b < 0.4, "gold is yellow: {r} {g} {b}");
        assert!(albedo.max_component() == r, "the fourth lane stays dark");
    }
}
