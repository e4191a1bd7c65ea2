//! Materials and textures.

use glanz_shading::model::{
    FinishModel, MetalColor, MirrorMaterial, Roughness, RoughnessScale, SurfaceFinish,
};

use super::layered_material::principled;
use super::*;

#[test]
fn materials_of_both_versions_are_lowered() {
    for text in ["\"matte\" \"rgb Kd\" [.1 .2 .3]", "\"diffuse\" \"rgb reflectance\" [.1 .2 .3]"] {
        let MaterialKind::Diffuse(diffuse) = material(text) else { panic!("{text}") };
        assert_eq!(value(&diffuse.reflectance), [0.1, 0.2, 0.3]);
    }
    let MaterialKind::Mirror(mirror) = material("\"mirror\"") else { panic!() };
    assert_eq!(value(&mirror.reflectance), [0.9; 3]);
    for (text, index) in [
        ("\"glass\"", 1.5),
        ("\"glass\" \"float index\" 1.3", 1.3),
        ("\"dielectric\" \"float eta\" 1.8", 1.8),
        // Linear between 500 and 700 nm: at helium's 587.5618 nm it is 1.5 + 0.1 * 87.5618 / 200.
        ("\"dielectric\" \"spectrum eta\" [500 1.5 700 1.6]", 1.543_780_9),
    ] {
        close(f64::from(index_of(&material(text), false)), index);
    }
    assert!(matches!(material("\"interface\""), MaterialKind::Interface));
    assert!(matches!(material("\"\""), MaterialKind::Interface));
    let MaterialKind::Phong(phong) = material("\"phong\" \"float exponent\" 50") else { panic!() };
    assert_eq!(phong.exponent, FloatParameter::Value(50.0));
}

/// The refractive index of solid glass, or of a pane.
fn index_of(material: &MaterialKind, thin: bool) -> f32 {
    match material {
        MaterialKind::Dielectric(glass) if glass.thin == thin => match glass.eta {
            FloatParameter::Value(eta) => eta,
            FloatParameter::Texture(_) => panic!("{glass:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn glass_by_name_has_the_index_of_its_catalogue() {
    // n_d of Schott's data sheets.
    for (name, index) in [("glass-BK7", 1.5168), ("glass-SF11", 1.784_72)] {
        let text = format!("\"dielectric\" \"spectrum eta\" \"{name}\"");
        let eta = index_of(&material(&text), false);
        assert!((f64::from(eta) - index).abs() < 1e-4, "{name}: {eta}");
    }
}

/// The index at the d line and that at 450 nm, if it is given by wavelength.
fn dispersion_of(text: &str) -> (f32, Option<f64>) {
    let kind = material(text);
    let MaterialKind::Dielectric(glass) = &kind else { panic!("{text}") };
    let at_450 = glass.dispersion.as_ref().map(|index| match index {
        SpectralDistribution::Sampled(samples) => samples.at(450.0),
        other => panic!("{other:?}"),
    });
    (index_of(&kind, glass.thin), at_450)
}

#[test]
fn index_by_wavelength_is_dispersion() {
    // Schott's formula for N-BK7 at 450 nm.
    let (_, blue) = dispersion_of("\"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    assert!((blue.unwrap() - 1.525_32).abs() < 1e-5, "{blue:?}");
    // 1.5 + 0.0081 / 0.45^2, and at 587.5618 nm.
    let (eta, blue) = dispersion_of("\"glass\" \"float cauchy\" [1.5 0.0081]");
    assert!((blue.unwrap() - 1.54).abs() < 1e-6 && (eta - 1.523_46).abs() < 1e-5, "{eta} {blue:?}");
    for same in ["\"float eta\" 1.7", "\"rgb eta\" [1.7 1.7 1.7]", "\"float index\" 1.7"] {
        let (eta, dispersion) = dispersion_of(&format!("\"glass\" {same}"));
        assert!((eta - 1.7).abs() < 1e-6 && dispersion.is_none(), "{same}: {eta} {dispersion:?}");
    }
}

#[test]
fn two_indices_of_one_glass_are_refused() {
    for other in ["eta", "index"] {
        let text =
            format!("WorldBegin Material \"glass\" \"float {other}\" 1.5\n\"float cauchy\" [1.5 .008]");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err().to_string();
        assert!(
            errors.contains("test.pbrt:2:17") && errors.contains("\"cauchy\" and \"eta\" both"),
            "{errors}"
        );
    }
}

#[test]
fn integrators_are_spectral_if_asked() {
    for (text, expected) in
        [("", false), (" \"bool spectral\" true", true), (" \"bool spectral\" false", false)]
    {
        let loaded = read_clean(&format!("Film \"rgb\" Integrator \"path\"{text} WorldBegin"));
        assert_eq!(loaded.description.integrator.spectral, expected);
    }
}

#[test]
fn metals_by_name_keep_their_spectrum_and_copper_is_the_default() {
    for (text, metal) in [
        ("\"conductor\"", "Cu"),
        ("\"metal\" \"float roughness\" 0", "Cu"),
        ("\"conductor\" \"spectrum eta\" \"metal-CuZn-eta\" \"spectrum k\" \"metal-CuZn-k\"", "CuZn"),
    ] {
        let MaterialKind::Conductor(metal_of) = material(text) else { panic!("{text}") };
        let MetalColor::Index { eta, k } = metal_of.color else { panic!() };
        for (input, quantity) in [(eta, "eta"), (k, "k")] {
            let SpectrumParameter::Value(spectrum) = input else { panic!("{text}") };
            assert!(matches!(spectrum, SpectralDistribution::Sampled(_)));
            assert_eq!(Some(spectrum), named::spectrum(&format!("metal-{metal}-{quantity}")));
        }
    }
}

#[test]
fn a_name_that_is_not_built_in_is_an_error_with_the_nearest_ones() {
    for (name, help) in [
        ("metal-Ag-etta", "did you mean the built-in \"metal-Ag-eta\"?"),
        ("metal-Au", "did you mean one of the built-in \"metal-Au-eta\", \"metal-Au-k\"?"),
    ] {
        let text = format!("WorldBegin Material \"conductor\" \"spectrum eta\" \"{name}\"");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err();
        let found: Vec<_> = errors.iter().map(|d| (d.kind, d.help.as_deref())).collect();
        assert_eq!(found, [("missing-file", Some(help))]);
    }
}

#[test]
fn thin_glass_is_a_pane() {
    let text =
        "Film \"rgb\" WorldBegin Material \"thindielectric\" \"float eta\" 1.3 Material \"thindielectric\"";
    let materials = read_clean(text).description.materials;
    for (material, index) in materials.iter().zip([1.3, 1.5]) {
        assert_eq!(index_of(&material.kind, true), index);
    }
}

#[test]
fn metal_has_its_reflectance() {
    let MaterialKind::Conductor(metal) = material("\"conductor\" \"rgb reflectance\" [.2 .5 .9]") else {
        panic!()
    };
    assert_eq!(metal.color, MetalColor::Reflectance([0.2, 0.5, 0.9].into()));
}

/// Widths of the facets of a metal along both directions.
fn widths(text: &str) -> [f64; 2] {
    let MaterialKind::Conductor(metal) = material(text) else { panic!("{text}") };
    [metal.roughness.u, metal.roughness.v].map(|roughness| match roughness {
        FloatParameter::Value(x) => metal.roughness.scale.alpha(x),
        FloatParameter::Texture(_) => panic!(),
    })
}

#[test]
fn roughness_has_the_meaning_of_its_version() {
    assert_eq!(widths("\"conductor\""), [0.0; 2]);
    // Version 4: the square root.
    for (found, root) in widths("\"conductor\" \"float roughness\" .25").into_iter().zip([0.5, 0.5]) {
        close(found, root);
    }
    assert_eq!(widths("\"conductor\" \"float vroughness\" .25 \"bool remaproughness\" false"), [0.0, 0.25]);
    // Version 3: ln 0.1 = -2.302585: 1.62142 - 1.888017 + 0.919340 - 0.209003 + 0.018010 = 0.461750.
    let both = "\"metal\" \"float uroughness\" .1 \"float vroughness\" 1";
    for (found, alpha) in widths(both).into_iter().zip([0.46175, 1.62142]) {
        assert!((found - alpha).abs() < 2e-5, "{found}");
    }
    // Not given: 0.01.
    assert!((widths("\"metal\"")[0] - RoughnessScale::Logarithmic.alpha(0.01)).abs() < 1e-9);
    // Version 3's logarithm has no value at 0, which counts as 0.001; the width is
    // 1.62142 - 0.819955 * 6.907755 + 0.1734 * 47.71708 - 0.0171201 * 329.6179 + 0.000640711 * 2276.920 = 0.047.
    for (found, alpha) in widths("\"metal\" \"float roughness\" 0").into_iter().zip([0.047_47; 2]) {
        assert!((found - alpha).abs() < 1e-3, "{found}");
    }
    for (name, smooth) in [("plastic", false), ("uber", false), ("substrate", false), ("principled", true)] {
        let surface = principled(&format!("\"{name}\" \"float roughness\" 0")).roughness;
        assert_eq!(surface.scale.alpha(0.0) == 0.0, smooth, "{name}");
    }
    let MaterialKind::Dielectric(glass) = material("\"glass\" \"float uroughness\" 0") else { panic!() };
    assert_eq!(glass.roughness, Roughness::smooth());
}

#[test]
fn mixtures_name_their_parts_before_or_after_these() {
    let parts = "MakeNamedMaterial \"a\" \"string type\" \"mirror\" MakeNamedMaterial \"b\" \"string type\" \"diffuse\"";
    let version4 = "\"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" .25";
    let version3 =
        "\"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"float amount\" .75";
    for (text, film) in [(version4, "rgb"), (version3, "image")] {
        for text in [format!("Material {text} {parts}"), format!("{parts} Material {text}")] {
            let loaded = read_clean(&format!("Film \"{film}\" WorldBegin {text} Shape \"sphere\""));
            let materials = &loaded.description.materials;
            let mix = materials.iter().find_map(|material| match &material.kind {
                MaterialKind::Mix(mix) => Some(mix.clone()),
                _ => None,
            });
            let mix = mix.unwrap();
            let names = mix.materials.map(|part| materials[part].name.as_str());
            assert_eq!((names, mix.amount), (["a", "b"], 0.25.into()), "{text}");
        }
    }
    let text =
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"a\" ]";
    let endless = read_clean(&format!("Film \"rgb\" {text} NamedMaterial \"a\" Shape \"sphere\""));
    let error = glanz_scene::Scene::resolve(endless.description).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("a mixture of itself"), "{error}");
}

#[test]
fn matte_with_sigma_is_rough_and_diffuse() {
    let MaterialKind::OrenNayar(plaster) = material("\"matte\" \"rgb Kd\" [.1 .2 .3] \"float sigma\" 20")
    else {
        panic!()
    };
    assert_eq!((value(&plaster.reflectance), plaster.sigma), ([0.1, 0.2, 0.3], 20.0.into()));
    assert!(matches!(material("\"matte\" \"float sigma\" 0"), MaterialKind::Diffuse(_)));
}

#[test]
fn stand_ins_cause_warnings_and_strict_mode_refuses_them() {
    for (text, kind) in [
        ("Material \"coateddiffuse\" \"rgb albedo\" [.1 .1 .1]", "stand-in-material"),
        ("Material \"hair\"", "stand-in-material"),
        ("Material \"fluff\"", "stand-in-material"),
        ("Shape \"heightfield\"", "stand-in-shape"),
        ("LightSource \"projection\"", "stand-in-light"),
        ("LightSource \"infinite\" \"string mapname\" \"no.exr\"", "missing-file"),
        ("Texture \"t\" \"color\" \"ptex\"", "stand-in-texture"),
        ("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"no.png\"", "missing-file"),
        ("MakeNamedMedium \"fog\" \"string type\" \"cloud\"", "stand-in-medium"),
        ("ActiveTransform EndTime Translate 0 0 1 ActiveTransform All", "stand-in-motion"),
    ] {
        let text = format!("WorldBegin {text}");
        let loaded = read(&text);
        let kinds: Vec<_> = loaded.diagnostics.iter().map(|d| d.kind).collect();
        assert_eq!(kinds, [kind], "{text}: {}", loaded.diagnostics);
        let strict = Options { strict: true, ..Options::default() };
        let errors = load_str("test.pbrt", &text, &strict).unwrap_err();
        assert!(errors.has_errors() && errors.iter().all(|d| d.kind == kind), "{text}");
    }
}

#[test]
fn named_materials_may_come_after_their_use() {
    let text = "Film \"rgb\" WorldBegin NamedMaterial \"later\" Shape \"sphere\" \
        MakeNamedMaterial \"later\" \"string type\" \"interface\" NamedMaterial \"later\" Shape \"sphere\"";
    let d = read_clean(text).description;
    assert_eq!(d.world.shapes[0].material, d.world.shapes[1].material);
    assert!(matches!(d.materials[d.world.shapes[0].material].kind, MaterialKind::Interface));
}

#[test]
fn a_material_made_again_leaves_earlier_shapes_alone() {
    let text = "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mirror\" NamedMaterial \"a\" Shape \"sphere\" \
        MakeNamedMaterial \"a\" \"string type\" \"matte\" NamedMaterial \"a\" Shape \"sphere\"";
    let d = read_clean(text).description;
    let kind = |i: usize| &d.materials[d.world.shapes[i].material].kind;
    assert!(matches!(kind(0), MaterialKind::Mirror(_)));
    assert!(matches!(kind(1), MaterialKind::Diffuse(_)));
}

#[test]
fn textures_are_found_by_name_and_mapped() {
    let text = "WorldBegin Translate 1 0 0 Texture \"c\" \"color\" \"checkerboard\" \"string mapping\" \"planar\" \
        \"vector v1\" [2 0 0] \"vector v2\" [0 0 3] \"float udelta\" .5 \"rgb tex1\" [1 0 0] \
        Texture \"s\" \"color\" \"scale\" \"texture tex1\" \"c\" \"color tex2\" [.5 .5 .5] \
        Texture \"m\" \"color\" \"mix\" \"texture tex1\" \"s\" \"float amount\" .25 \
        Material \"matte\" \"texture Kd\" \"m\"";
    let d = read_clean(text).description;
    assert_eq!(d.materials[0].kind, MaterialKind::diffuse(SpectrumParameter::Texture(2)));
    let TextureKind::Checkerboard { even, odd, mapping } = &d.textures[0].kind else { panic!() };
    assert_eq!((value(even), value(odd)), ([1.0, 0.0, 0.0], [0.0; 3]));
    let MappingDescription::Planar { v1, v2, offset, to_texture } = mapping else { panic!() };
    assert_eq!((*v1, *v2, *offset), (2.0 * DVec3::X, 3.0 * DVec3::Z, DVec2::new(0.5, 0.0)));
    assert_eq!(to_texture.transform_point3(DVec3::X), DVec3::ZERO);
    assert!(matches!(&d.textures[1].kind, TextureKind::Scale(SpectrumParameter::Texture(0), _)));
    assert!(matches!(
        &d.textures[2].kind,
        TextureKind::Mix { a: SpectrumParameter::Texture(1), amount: FloatParameter::Value(0.25), .. }
    ));
}

#[test]
fn computed_textures_have_their_parameters_and_defaults() {
    let text = "WorldBegin Translate 1 0 0 Scale 2 2 2 Texture \"n\" \"float\" \"fbm\" \"integer octaves\" 3 \
        Texture \"d\" \"color\" \"dots\" \"texture inside\" \"n\" \"float uscale\" 4 \
        Texture \"x\" \"color\" \"directionmix\" \"vector3 dir\" [0 0 3] Texture \"b\" \"color\" \"bilerp\" \"rgb v10\" [1 0 0] \
        Texture \"m\" \"color\" \"marble\" \"float variation\" 0.5 Texture \"w\" \"float\" \"windy\" Texture \"u\" \"color\" \"uv\"";
    let textures = read_clean(text).description.textures;
    let TextureKind::Fractal { kind, mapping: MappingDescription::Solid { to_texture } } = &textures[0].kind
    else {
        panic!()
    };
    assert_eq!(*kind, FractalKind::Fbm { octaves: 3, roughness: 0.5 });
    assert_eq!(to_texture.transform_point3(DVec3::new(3.0, 2.0, 0.0)), DVec3::new(1.0, 1.0, 0.0));
    let TextureKind::Dots { inside: SpectrumParameter::Texture(0), outside, mapping } = &textures[1].kind
    else {
        panic!()
    };
    assert_eq!(value(outside), [0.0; 3]);
    assert!(matches!(mapping, MappingDescription::Uv { scale, .. } if scale.x == 4.0));
    let TextureKind::DirectionMix { along, across, direction } = &textures[2].kind else { panic!() };
    assert_eq!((value(along), value(across), direction.normalize()), ([0.0; 3], [1.0; 3], DVec3::Z));
    let TextureKind::Bilerp { corners, .. } = &textures[3].kind else { panic!() };
    let red = [1.0, 0.0, 0.0];
    assert_eq!(corners.each_ref().map(value), [[0.0; 3], [1.0; 3], red, [1.0; 3]]);
    let marble = (8, 0.5, 1.0, 0.5);
    assert!(matches!(textures[4].kind, TextureKind::Marble { octaves, roughness, scale, variation, .. }
        if (octaves, roughness, scale, variation) == marble));
    assert!(matches!(textures[5].kind, TextureKind::Fractal { kind: FractalKind::Windy, .. }));
    assert!(matches!(textures[6].kind, TextureKind::Uv(_)));
}

#[test]
fn every_material_may_have_bumps_and_every_shape_an_opacity() {
    let text = "WorldBegin Texture \"h\" \"float\" \"fbm\" Texture \"a\" \"float\" \"constant\" \"float value\" 0.5 \
        Material \"matte\" \"texture bumpmap\" \"h\" Shape \"sphere\" \"texture alpha\" \"a\" \"float shadowalpha\" 0 \
        MakeNamedMaterial \"m\" \"string type\" \"mirror\" \"texture displacement\" \"h\" NamedMaterial \"m\" \
        Shape \"sphere\" \"float alpha\" .25 Material \"matte\" \"float bumpmap\" 2 Shape \"sphere\"";
    let d = read_clean(text).description;
    let details: Vec<_> =
        d.world.shapes.iter().map(|shape| d.materials[shape.material].surface_detail).collect();
    let bump = Some(SurfaceDetailDescription::Bump(FloatParameter::Texture(0)));
    assert_eq!(details, [bump, bump, None]);
    let alphas: Vec<_> = d.world.shapes.iter().map(|shape| shape.alpha).collect();
    let first = AlphaDescription { opacity: FloatParameter::Texture(1), shadow: FloatParameter::Value(0.0) };
    assert_eq!(alphas, [Some(first), Some(FloatParameter::Value(0.25).into()), None]);
    let missing = read("WorldBegin Material \"matte\" \"string normalmap\" \"no.png\"");
    let messages = missing.diagnostics.to_string();
    assert!(messages.contains("the smooth surface stands in"), "{messages}");
    assert_eq!(missing.description.materials[0].surface_detail, None);
}

#[test]
fn textures_of_numbers_and_colours_may_share_a_name() {
    let text = "WorldBegin Texture \"t\" \"float\" \"constant\" \"float value\" 2 Texture \"t\" \"color\" \"constant\" \
        Material \"phong\" \"texture exponent\" \"t\" \"texture Kd\" \"t\"";
    let d = read_clean(text).description;
    let MaterialKind::Phong(phong) = &d.materials[0].kind else { panic!() };
    assert_eq!(phong.diffuse, SpectrumParameter::Texture(1));
    assert_eq!(phong.exponent, FloatParameter::Texture(0));
}

#[test]
fn attributes_are_defaults_for_the_objects_of_their_block() {
    let text = "Film \"rgb\" WorldBegin AttributeBegin Attribute \"shape\" \"float radius\" 2 Shape \"sphere\" \
        Shape \"sphere\" \"float radius\" 3 AttributeEnd Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    let radius = |i: usize| match shapes[i].geometry {
        GeometryDescription::Sphere { radius, .. } => radius,
        _ => panic!(),
    };
    assert_eq!([radius(0), radius(1), radius(2)], [2.0, 3.0, 1.0]);
}

#[test]
fn mirrors_have_a_finish_whose_scatter_is_at_most_all_light() {
    let gaussian = material("\"mirror\" \"string finish\" \"gaussian\" \"float sigma\" .01");
    let MaterialKind::Mirror(mirror) = gaussian else { panic!() };
    let model = mirror.finish.unwrap().model();
    assert_eq!(model, FinishModel::Gaussian { sigma: 0.01, fraction: 1.0 });
    let abg = "\"string finish\" \"abg\" \"float A\" .001 \"float B\" .01 \"float g\" 2";
    let MaterialKind::Conductor(metal) = material(&format!("\"conductor\" {abg}")) else { panic!() };
    assert_eq!(metal.finish.unwrap().model(), FinishModel::Abg { a: 0.001, b: 0.01, g: 2.0 });
    // One that scatters nothing is none.
    let none = material("\"mirror\" \"string finish\" \"gaussian\" \"float sigma\" .01 \"float fraction\" 0");
    assert!(matches!(none, MaterialKind::Mirror(MirrorMaterial { finish: None, .. })));
    for (parameters, place, message) in [
        ("\"string finish\" \"abg\" \"float A\" .9 \"float B\" .01 \"float g\" 2", 51, "scatter is 13.04"),
        ("\"string finish\" \"abg\" \"float A\" .9 \"float B\" 0 \"float g\" 2", 64, "B is 0; it must be"),
        ("\"string finish\" \"abg\" \"float A\" .9 \"float B\" .1", 35, "has no \"float g\""),
        ("\"string finish\" \"satin\"", 35, "finish \"satin\" is unknown"),
        ("\"string finish\" \"gaussian\" \"float sigma\" 2", 60, "sigma is 2; it must be"),
    ] {
        let text = format!("WorldBegin\nMaterial \"mirror\" {parameters}");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err().to_string();
        assert!(errors.contains(message) && errors.contains(&format!("test.pbrt:2:{place}:")), "{errors}");
    }
    let rough =
        read(&format!("WorldBegin\nMaterial \"conductor\" \"float roughness\" .1 {abg}\nShape \"sphere\""));
    let error = glanz_scene::Scene::resolve(rough.description).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("a finish needs a smooth surface"), "{error}");
}

#[test]
fn equal_finishes_share_their_tables() {
    let finish = |sigma: &str| format!("\"string finish\" \"gaussian\" \"float sigma\" {sigma}");
    let [narrow, same, wide] = [".01", "1e-2", ".02"].map(finish);
    let text = format!(
        "WorldBegin\nMaterial \"mirror\" {narrow}\nAttributeBegin\nMaterial \"conductor\" {same}\nAttributeEnd\n\
         MakeNamedMaterial \"wide\" \"string type\" \"mirror\" {wide}"
    );
    let d = read_clean(&text).description;
    let [narrow, same, wide] = [0, 1, 2].map(|i| match &d.materials[i].kind {
        MaterialKind::Mirror(MirrorMaterial { finish, .. }) => finish.as_ref().unwrap(),
        MaterialKind::Conductor(metal) => metal.finish.as_ref().unwrap(),
        other => panic!("{other:?}"),
    });
    assert!(narrow.shares_tables_with(same) && !narrow.shares_tables_with(wide));
    // Their tables are those of the model, to the bit.
    let anew = |finish: &SurfaceFinish| SurfaceFinish::try_new(finish.model()).unwrap();
    assert_eq!([narrow, same, wide], [&anew(narrow), &anew(same), &anew(wide)]);
}
