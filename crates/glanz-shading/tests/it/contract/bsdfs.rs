//! The BSDFs that the contract is tested with.

use super::*;

pub(super) fn phong(diffuse: [f32; 3], specular: [f32; 3], exponent: f64) -> Bsdf<'static> {
    Bsdf::Phong(Phong::new(PhongCoefficients {
        ambient: Spectrum::BLACK,
        diffuse: Spectrum::from_rgb(diffuse),
        specular: Spectrum::from_rgb(specular),
        exponent,
    }))
}

pub(super) const WHITE: Spectrum = Spectrum::from_rgb([1.0; 3]);

pub(super) fn glass(eta: f64, thin: bool) -> Bsdf<'static> {
    let glass = Dielectric::new(eta, WHITE, WHITE);
    Bsdf::Dielectric(if thin { glass.as_sheet() } else { glass })
}

pub(super) fn rough_glass(eta: f64, [x, y]: [f64; 2]) -> Bsdf<'static> {
    let facets = MicrofacetDistribution::new(x, y);
    Bsdf::Dielectric(Dielectric::new(eta, WHITE, WHITE).with_facets(facets, true))
}

pub(super) fn metal(eta: [f32; 3], k: [f32; 3], [x, y]: [f64; 2]) -> Bsdf<'static> {
    let (eta, k) = (Spectrum::from_rgb(eta), Spectrum::from_rgb(k));
    let metal = ConductorFresnel { eta, k, tint: WHITE };
    Bsdf::Conductor(Conductor::new(metal, MicrofacetDistribution::new(x, y), true))
}

/// A part of the table, which outlives all tests.
fn lasting<T>(part: T) -> &'static T {
    Box::leak(Box::new(part))
}

/// A mirror with a surface finish.
pub(super) fn finished(reflectance: Spectrum, model: FinishModel) -> Bsdf<'static> {
    Bsdf::Mirror(Mirror { reflectance, finish: Some(lasting(SurfaceFinish::try_new(model).unwrap())) })
}

/// Scattering of the light by about a half, wide enough for the cells of the tests.
pub(super) const ABG: FinishModel = FinishModel::Abg { a: 0.05, b: 0.05, g: 2.0 };

pub(super) fn polished_gold() -> Bsdf<'static> {
    let [eta, k] = GOLD.map(Spectrum::from_rgb);
    let metal = ConductorFresnel { eta, k, tint: WHITE };
    let metal = Conductor::new(metal, MicrofacetDistribution::SMOOTH, true);
    Bsdf::Conductor(metal.with_finish(Some(lasting(SurfaceFinish::try_new(ABG).unwrap()))))
}

pub(super) const GOLD: [[f32; 3]; 2] = [[0.143, 0.375, 1.442], [3.983, 2.386, 1.603]];

/// A metal without absorption.
pub(super) fn perfect_metal(alpha: [f64; 2]) -> Bsdf<'static> {
    metal([0.0; 3], [1e4; 3], alpha)
}

pub(super) fn coated(reflectance: Spectrum, eta: f32, [x, y]: [f64; 2]) -> Bsdf<'static> {
    let coat = Coat::new(eta, MicrofacetDistribution::new(x, y), true);
    Bsdf::CoatedDiffuse(CoatedDiffuse::new(reflectance, WHITE, coat))
}

pub(super) fn principled(
    color: Spectrum,
    roughness: f32,
    set: impl Fn(&mut PrincipledMaterial),
) -> Bsdf<'static> {
    let mut material = PrincipledMaterial::new(color, roughness);
    set(&mut material);
    let point = TexturePoint::new(DVec2::ZERO, DVec3::ZERO);
    let bsdf = lasting(Material::from(material)).bsdf(&Textures::new(), &point, &Wavelengths::Rgb);
    bsdf.unwrap_or(Bsdf::Black)
}

/// Materials of all kinds whose BSDFs have a density, with a colour; what else they have is grey.
pub(super) fn materials(color: Spectrum) -> Vec<(&'static str, Material)> {
    let grey = |value: f32| SpectrumInput::from(Spectrum::from_rgb([value; 3]));
    let rough = Roughness::isotropic(0.4, RoughnessScale::Alpha);
    let layered = |set: fn(&mut PrincipledMaterial)| {
        let mut material = PrincipledMaterial::new(color, 0.6);
        set(&mut material);
        material
    };
    let cloth = PrincipledMaterial { sheen: color.into(), ..PrincipledMaterial::new(grey(0.5), 0.6) };
    let tinted = PrincipledMaterial { specular: color.into(), ..PrincipledMaterial::new(grey(0.5), 0.6) };
    vec![
        ("diffuse", Material::diffuse(color)),
        ("plaster", Material::oren_nayar(color, 20.0)),
        (
            "metal",
            ConductorMaterial {
                color: MetalColor::Reflectance(color.into()),
                roughness: rough.clone(),
                multiple_scattering: true,
                finish: None,
            }
            .into(),
        ),
        (
            "glass",
            DielectricMaterial {
                eta: 1.5.into(),
                dispersion: None,
                reflectance: color.into(),
                transmittance: grey(0.7),
                thin: false,
                roughness: rough.clone(),
                multiple_scattering: true,
            }
            .into(),
        ),
        (
            "plastic",
            CoatedDiffuseMaterial {
                reflectance: color.into(),
                eta: 1.5.into(),
                roughness: rough,
                multiple_scattering: true,
            }
            .into(),
        ),
        ("paper", Material::diffuse_transmission(color, grey(0.4))),
        ("paint", layered(|m| m.coat = 0.8.into()).into()),
        ("flaked metal", layered(|m| m.metallic = 0.6.into()).into()),
        ("waxed glass", layered(|m| m.transmission = 0.6.into()).into()),
        ("cloth", cloth.into()),
        ("tinted gloss", tinted.into()),
        ("phong", Material::phong(grey(0.1), color, grey(0.8), 20.0)),
    ]
}

/// The table.
pub(super) fn bsdfs() -> Vec<(&'static str, Bsdf<'static>)> {
    let colour = Spectrum::from_rgb([0.9, 0.5, 0.1]);
    let tinted = Dielectric::new(1.5, colour, colour * 0.5);
    let tinted_rough = tinted.with_facets(MicrofacetDistribution::new(0.3, 0.3), true);
    let [eta, k] = GOLD;
    let table = vec![
        ("black", Bsdf::Black),
        ("lambert", Bsdf::Lambert(Lambert { reflectance: colour })),
        ("white", Bsdf::Lambert(Lambert { reflectance: Spectrum::ONE })),
        ("plaster", Bsdf::OrenNayar(OrenNayar::new(colour, 0.6))),
        ("white plaster", Bsdf::OrenNayar(OrenNayar::new(WHITE, 0.2))),
        ("mirror", Bsdf::Mirror(Mirror { reflectance: colour, finish: None })),
        ("polished mirror", finished(colour, ABG)),
        ("steep mirror", finished(colour, FinishModel::Abg { a: 0.001, b: 1e-3, g: 3.2 })),
        ("even mirror", finished(WHITE, FinishModel::Abg { a: 0.1, b: 0.5, g: 0.0 })),
        ("hazy mirror", finished(WHITE, FinishModel::Gaussian { sigma: 0.15, fraction: 1.0 })),
        ("polished gold", polished_gold()),
        ("gold", metal(eta, k, [0.0; 2])),
        ("dull gold", metal(eta, k, [0.4; 2])),
        ("brushed gold", metal(eta, k, [0.15, 0.6])),
        ("perfect rough metal", perfect_metal([1.0; 2])),
        ("perfect brushed metal", perfect_metal([0.2, 0.5])),
        ("glass", glass(1.5, false)),
        ("bubble", glass(1.0 / 1.33, false)),
        ("matched glass", glass(1.0, false)),
        ("densest glass", glass(1e3, false)),
        ("thinnest glass", glass(1e-3, false)),
        ("pane", glass(1.5, true)),
        ("tinted glass", Bsdf::Dielectric(tinted)),
        ("frosted glass", rough_glass(1.5, [0.3; 2])),
        ("rough glass", rough_glass(1.5, [0.9; 2])),
        ("rough bubble", rough_glass(1.0 / 1.33, [0.5; 2])),
        ("brushed glass", rough_glass(1.5, [0.2, 0.5])),
        ("tinted frosted glass", Bsdf::Dielectric(tinted_rough)),
        ("plastic", coated(colour, 1.5, [0.0; 2])),
        ("white plastic", coated(WHITE, 1.5, [0.0; 2])),
        ("rough white plastic", coated(WHITE, 1.5, [0.4; 2])),
        ("rough plastic", coated(colour * 0.5, 1.8, [0.25, 0.5])),
        ("paint", principled(colour, 0.5, |_| {})),
        ("white paint", principled(WHITE, 0.6, |_| {})),
        (
            "coated paint",
            principled(colour, 0.6, |m| {
                m.coat = 0.8.into();
                m.coat_roughness = Roughness::isotropic(0.4, RoughnessScale::Square);
            }),
        ),
        ("cloth", principled(colour * 0.3, 0.8, |m| m.sheen = WHITE.into())),
        (
            "flaked metal",
            principled(colour, 0.5, |m| {
                m.metallic = 0.6.into();
                m.roughness.v = 0.7.into();
            }),
        ),
        ("waxed glass", principled(colour, 0.5, |m| m.transmission = 0.6.into())),
        ("clear plastic", principled(colour, 0.0, |m| m.transmission = 1.0.into())),
        (
            "dirty pane",
            principled(colour, 0.6, |m| {
                m.transmission = 0.8.into();
                m.thin = true;
            }),
        ),
        ("dense white coat", coated(WHITE, 6.0, [0.3; 2])),
        ("densest white coat", coated(WHITE, 500.0, [0.0; 2])),
        ("brushed white coat", coated(WHITE, 1.5, [0.05, 0.5])),
        (
            "gold on black",
            principled(Spectrum::BLACK, 0.5, |m| {
                m.metallic = 1.0.into();
                let [eta, k] = GOLD.map(|constants| Spectrum::from_rgb(constants).into());
                m.metal = Some(MetalColor::Index { eta, k });
            }),
        ),
        (
            "brushed coat",
            principled(colour, 0.5, |m| {
                m.coat = 1.0.into();
                m.coat_roughness = Roughness { u: 0.2.into(), v: 0.6.into(), scale: RoughnessScale::Square };
            }),
        ),
        ("paper", Bsdf::DiffuseTransmission(DiffuseTransmission::new(colour * 0.5, colour * 0.3))),
        ("flat phong", phong([0.3, 0.2, 0.1], [0.5, 0.6, 0.7], 0.0)),
        ("dull phong", phong([0.2, 0.3, 0.5], [0.5, 0.4, 0.3], 3.5)),
        ("sharp phong", phong([0.1; 3], [0.9; 3], 150.0)),
        ("bare phong", phong([0.0; 3], [1.0; 3], 20.0)),
        ("greedy phong", phong([0.9; 3], [0.8; 3], 10.0)),
    ];
    // Does not compile for a variant without an arm: give the new one a line above.
    for (_, bsdf) in &table {
        match bsdf {
            Bsdf::Black | Bsdf::Lambert(_) | Bsdf::Mirror(_) | Bsdf::Conductor(_) => {}
            Bsdf::Dielectric(_) | Bsdf::Phong(_) | Bsdf::CoatedDiffuse(_) | Bsdf::DiffuseTransmission(_) => {}
            Bsdf::Principled(_) | Bsdf::OrenNayar(_) => {}
            // Of no surface, so that the contract is another: `phase` has the tests.
            Bsdf::Medium(_) => {}
        }
    }
    table
}
